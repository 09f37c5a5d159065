//! The dictionary of the protocol and its texts: each row has all of its texts in every language,
//! and no text is without a row.

use std::collections::BTreeSet;

use lafet_proto::crash::{Context, FAULT_BITS};
use lafet_proto::dictionary::{self, Key, REQUESTS, STATUSES, SUBSYSTEMS, layouts};
use lafet_proto::flags::{self, Button, ButtonState, Severity};
use lafet_proto::id::SubsystemId;
use lafet_proto::param::{Param, Unit};
use lafet_proto::status::FaultInfo;
use lafet_texts::{Fixed, Lang, Text, proto};

/// Every key of the dictionary.
fn keys() -> BTreeSet<&'static str> {
    let mut keys: Vec<Key> = Vec::new();
    keys.extend(SUBSYSTEMS.iter().flat_map(|it| [it.title, it.meaning]));
    keys.extend(STATUSES.iter().flat_map(|it| [it.meaning, it.remedy]));
    keys.extend(REQUESTS.iter().flat_map(|it| [it.title, it.meaning]));
    let ids = SUBSYSTEMS.iter().map(|it| it.id);
    let classes = ids.clone().flat_map(|id| flags::flags_of(id).flags);
    keys.extend(classes.flat_map(|it| [it.meaning, it.cause, it.remedy]));
    let answers = |request| ids.clone().flat_map(move |from| layouts::of_answer(request, from));
    let of = |request| layouts::of_request(request).iter().chain(answers(request));
    let structures = REQUESTS.iter().flat_map(|it| of(it.id));
    keys.extend(structures.flat_map(|it| it.fields.iter().chain(it.repeated)).map(|it| it.text));
    keys.extend(Param::ALL.iter().map(|it| it.text()));
    keys.extend(units().filter_map(Unit::name));
    keys.extend(Severity::ALL.iter().map(|it| it.text()));
    keys.extend(ButtonState::ALL.iter().map(|it| it.text()));
    keys.extend(Button::ALL.iter().map(|it| it.text()));
    keys.extend(FAULT_BITS.iter().flat_map(|it| [it.meaning, it.remedy]));
    let mut words = [1; 20];
    let fault = FaultInfo::from_words(words);
    keys.extend(["pc", "lr", "mmfar", "bfar"].iter().filter_map(|it| fault.note(it)));
    (words[14], words[17]) = (0, 0);
    keys.extend(FaultInfo::from_words(words).summary());
    let contexts = [Context::Program, Context::Interrupt(1), Context::Reserved(1)];
    keys.extend(contexts.into_iter().filter_map(Context::text));
    keys.into_iter().map(Key::name).collect()
}

/// The units that parameters and fields have.
fn units() -> impl Iterator<Item = Unit> {
    let of_params = Param::ALL
        .iter()
        .map(|it| it.spec())
        .flat_map(|spec| spec.elements.iter().map(|element| element.unit).chain([spec.unit]));
    let ids = SUBSYSTEMS.iter().map(|it| it.id);
    let states = ids.flat_map(|from| layouts::of_answer(lafet_proto::RequestId::GET_STATUS, from));
    let requests = REQUESTS.iter().flat_map(|it| layouts::of_request(it.id));
    let structures = states.chain(requests);
    let of_fields = structures.flat_map(|it| it.fields.iter().chain(it.repeated)).map(|it| it.unit);
    of_params.chain(of_fields)
}

/// Keys are names in two crates: without this, one mistyped in either would be shown to people.
#[test]
fn every_row_has_its_texts_and_every_text_its_row() {
    let texts: BTreeSet<&str> = proto::BY_KEY.iter().map(|(key, _)| *key).collect();
    let keys = keys();
    let lacking: Vec<_> = keys.difference(&texts).collect();
    assert!(lacking.is_empty(), "proto.ftl lacks {lacking:#?}");
    let spare: Vec<_> = texts.difference(&keys).collect();
    assert!(spare.is_empty(), "no row of lafet-proto has {spare:#?}");
}

#[test]
fn a_key_is_a_text() {
    let status = dictionary::status(lafet_proto::Status::BUSY).unwrap();
    assert_eq!(status.meaning.of(Lang::En), "The addressee is busy.");
    assert_eq!(status.meaning.words().ru, "Подсистема-получатель занята.");
    for unit in units() {
        let name = unit.name().map_or(Fixed::same(""), lafet_texts::dictionary);
        assert_eq!(name.en, unit.symbol(), "{unit:?}");
    }
    let amperes = Unit::DeciAmpere.name().map(lafet_texts::dictionary);
    assert_eq!(amperes, Some(Fixed { en: "×0.1 A", ru: "×0,1 А" }));
}

fn is_cyrillic(text: &str) -> bool {
    text.chars().any(|c| ('а'..='я').contains(&c) || ('А'..='Я').contains(&c))
}

/// Whole sentences where there is room for them.
#[test]
fn meanings_causes_and_remedies_are_sentences() {
    for (key, text) in proto::BY_KEY {
        for lang in Lang::ALL {
            let words = text.str(lang);
            assert!(!words.is_empty() && !words.contains("  "), "{key}: {words}");
        }
        let sentence = ["-meaning", "-cause", "-remedy"].iter().any(|end| key.ends_with(end));
        if sentence || key.starts_with("param-") {
            assert!(text.en.ends_with('.') && !is_cyrillic(text.en), "{key}: {}", text.en);
            assert!(text.ru.ends_with('.') && is_cyrillic(text.ru), "{key}: {}", text.ru);
        }
    }
}

/// Two flags of a subsystem that mean the same could not be distinguished; neither could two statuses.
#[test]
fn nothing_is_said_twice() {
    for id in SubsystemId::TABLE {
        let flags = flags::flags_of(id).flags;
        let meanings: BTreeSet<_> = flags.iter().map(|it| it.meaning.of(Lang::En)).collect();
        assert_eq!(meanings.len(), flags.len(), "{id}");
    }
    let meanings: BTreeSet<_> = STATUSES.iter().map(|it| it.meaning.of(Lang::En)).collect();
    assert_eq!(meanings.len(), STATUSES.len());
}

/// §3.20: a record without a known bit says what can have stopped the program.
#[test]
fn a_fault_without_a_cause_has_a_summary() {
    let mut words = [1; 20];
    (words[14], words[17], words[19]) = (0, 0, 9);
    let summary = FaultInfo::from_words(words).summary().unwrap();
    assert!(summary.of(Lang::En).contains("watchdog"));
    (words[14], words[17]) = (1 << 30, 1 << 15);
    let note = FaultInfo::from_words(words).note("mmfar").unwrap();
    assert_eq!(note.of(Lang::En), "no address: not valid");
}
