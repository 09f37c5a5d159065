//! Texts in each language, with their arguments.

use lafet_texts::{Argument, Fixed, Lang, Shown, Text, Words, capture, place, site};

#[test]
fn a_text_has_words_in_every_language() {
    let words = site::RefusalNoHold.words();
    assert_eq!(words.en, "The zone has no hold.");
    assert_eq!(words.ru, "Удержание в этой зоне не предусмотрено.");
    for lang in Lang::ALL {
        assert_eq!(words.of(lang), site::RefusalNoHold.of(lang));
    }
    assert_eq!(Lang::ALL.map(Lang::code), ["en", "ru"]);
    assert_eq!(Lang::default(), Lang::En);
}

/// No isolation marks, no separators, nothing rounded: terminals, logs and JSON get what was given.
#[test]
fn arguments_are_put_in_as_they_are() {
    let text = site::OutOfRange { key: "delay_s", value: 1_234_567 };
    assert_eq!(text.of(Lang::En), "delay_s = 1234567 is out of range.");
    assert_eq!(text.of(Lang::Ru), "delay_s = 1234567 вне диапазона.");
    let odd = site::OutOfRange { key: "{ $value } \u{2068}<b>\n", value: f64::NAN };
    assert_eq!(odd.of(Lang::En), "{ $value } \u{2068}<b>\n = NaN is out of range.");
    let text = place::ReferenceWrong {
        number: 2,
        azimuth: format_args!("{:.2}", 1.005_1),
        elevation: format_args!("{:.2}", -0.5),
    };
    assert!(text.of(Lang::Ru).contains("по азимуту 1.01°, по углу места -0.50°"));
}

/// A text in a text is in the language of the whole, also where only its interface is known.
#[test]
fn a_text_may_be_an_argument() {
    let what: &dyn Text = &place::Winds;
    let text = place::TooMany { what, count: 9, least: 0, most: 8 };
    assert_eq!(text.of(Lang::En), "9 winds; allowed: 0 … 8");
    assert_eq!(text.of(Lang::Ru), "ветров: 9; допустимо: 0 … 8");
    let made: Words = place::Winds.words();
    assert_eq!(place::TooMany { what: made, count: 9, least: 0, most: 8 }.words(), text.words());
}

/// Words that were made are an argument like any other; so is what borrows.
#[test]
fn every_kind_of_argument() {
    fn shown(argument: impl Argument) -> String {
        site::IdLength { id: argument }.of(Lang::Ru)
    }
    let around = |id: &str| format!("Имя `{id}` пустое, слишком длинное или из одних точек.");
    assert_eq!(shown("a"), around("a"));
    assert_eq!(shown(String::from("a")), around("a"));
    assert_eq!(shown(std::borrow::Cow::Borrowed("a")), around("a"));
    assert_eq!(shown('я'), around("я"));
    assert_eq!(shown(u64::MAX), around("18446744073709551615"));
    assert_eq!(shown(-1_i8), around("-1"));
    assert_eq!(shown(true), around("true"));
    assert_eq!(shown(1e300), around(&1e300.to_string()));
    assert_eq!(shown(Shown(std::net::Ipv4Addr::LOCALHOST)), around("127.0.0.1"));
    assert_eq!(shown(Words { en: "a".into(), ru: "б".into() }), around("б"));
}

/// Each text is there in both, and neither is the other.
#[test]
fn the_dissectors_texts() {
    let all: [&dyn Text; 3] = [&capture::Protocol, &capture::BadCrc, &capture::Refused];
    for text in all {
        assert_ne!(text.of(Lang::En), text.of(Lang::Ru));
        assert!(!text.of(Lang::En).is_empty() && !text.of(Lang::Ru).is_empty());
    }
}

/// Without arguments, a text is a constant.
#[test]
fn a_fixed_text_is_a_constant_and_has_a_key() {
    const NO_HOLD: Fixed = site::RefusalNoHold.fixed();
    assert_eq!(NO_HOLD.en, "The zone has no hold.");
    for lang in Lang::ALL {
        assert_eq!(NO_HOLD.str(lang), site::RefusalNoHold.str(lang));
        assert_eq!(NO_HOLD.of(lang), NO_HOLD.str(lang));
        assert_eq!(NO_HOLD.words().of(lang), NO_HOLD.str(lang));
    }
    let find = |key| site::BY_KEY.iter().find(|(known, _)| *known == key).map(|(_, text)| *text);
    assert_eq!(find("refusal-no-hold"), Some(NO_HOLD));
    assert_eq!(find("id-length"), None);
}
