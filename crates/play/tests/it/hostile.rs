//! Whatever comes from a link, a text field or a page, the answer is JSON in both languages, soon.

use lafet_play::{FRAGMENT_MAX, Playground, Session, call};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::{error, later, ok};

fn answers(command: &[u8]) -> Value {
    let answer = call(&mut Playground::default(), command);
    let answer: Value = serde_json::from_slice(&answer).expect("JSON");
    let error = &answer["error"];
    assert!(error.is_null() || error["en"].is_string() && error["ru"].is_string(), "{answer}");
    answer
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_bytes_are_a_command_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        answers(&bytes);
    }

    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,80}", bytes in any::<bool>()) {
        let input = json!({ "bytes": bytes, "text": text });
        answers(json!({ "op": "read", "input": &input }).to_string().as_bytes());
        let act = json!({ "kind": "send", "link": "radio", "input": input });
        answers(json!({ "op": "act", "act": act }).to_string().as_bytes());
    }

    #[test]
    fn any_fragment_is_opened_or_refused(fragment in "(1\\.)?[A-Za-z0-9_-]{0,200}") {
        answers(json!({ "op": "open", "fragment": fragment }).to_string().as_bytes());
    }

    /// Contents of any kind behind a right checksum: within the bounds, or refused.
    #[test]
    fn any_contents_keep_the_bounds(
        seed in any::<u32>(),
        steps in any::<u32>(),
        payloads in proptest::collection::vec((any::<u32>(), proptest::collection::vec(any::<u8>(), 0..40)), 0..6),
    ) {
        let mut session = Session::default();
        session.setup.seed = seed;
        for (step, payload) in payloads {
            let link = serde_json::from_value(json!(if step & 1 == 0 { "wired" } else { "radio" })).unwrap();
            let last = session.actions.last().map_or(0, |(at, _)| *at);
            session.actions.push((last.saturating_add(step % 40_000), lafet_play::Action::Send(link, payload)));
        }
        session.steps = steps % 400_000;
        let within = session.steps <= 180_000 && session.actions.last().is_none_or(|(at, _)| *at <= session.steps);
        let read = Session::from_fragment(&session.fragment());
        prop_assert_eq!(read.is_ok(), within);
        if within {
            prop_assert_eq!(read, Ok(session));
        }
    }

    /// Any records, over and over, with time between: no panic, and time goes on.
    #[test]
    fn any_records_are_survived(
        all in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 1..60), 1..12),
    ) {
        let mut playground = Playground::default();
        for bytes in all {
            let text: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
            let input = json!({ "bytes": true, "text": text });
            let act = json!({ "kind": "send", "link": "wired", "input": input });
            let view = ok(&mut playground, json!({ "op": "act", "act": act }));
            prop_assert_eq!(view["entries"].as_array().unwrap().len(), 1);
            playground.advance(100);
        }
        let fragment = playground.session().fragment();
        let mut again = Playground::open(&fragment).unwrap();
        while again.is_repeating() {
            again.advance(500);
        }
        prop_assert_eq!(again.hash(), playground.hash());
    }
}

#[test]
fn mistakes_are_told() {
    let playground = &mut Playground::default();
    let read =
        |bytes, text: &str| json!({ "op": "read", "input": { "bytes": bytes, "text": text } });
    assert!(error(playground, read(false, "Opn Valve1")).contains("did you mean `Open`"));
    assert!(error(playground, read(false, " \n")).contains("Type a request"));
    assert!(error(playground, read(true, "9d c")).contains("one digit"));
    assert!(error(playground, read(true, "9d xx")).contains("“x”"));
    assert!(error(playground, read(false, &"a".repeat(5_000))).contains("too long"));
    assert!(error(playground, read(false, &"Stop All;".repeat(33))).contains("32"));
    assert!(error(playground, read(true, &"00".repeat(600))).contains("512"));
    let break_ = json!({ "kind": "break", "fault": "teapot" });
    assert!(error(playground, json!({ "op": "act", "act": break_ })).contains("teapot"));
    let far = json!({ "kind": "light", "azimuth": 0, "range": 200, "fuel": false });
    assert!(error(playground, json!({ "op": "act", "act": far })).contains("80 m"));
    let long = "1.".to_owned() + &"A".repeat(FRAGMENT_MAX);
    assert!(error(playground, json!({ "op": "open", "fragment": long })).contains("too long"));
    assert!(error(playground, json!({ "op": "nonsense" })).contains("reload"));
    assert!(
        error(playground, json!({ "op": "start", "seed": 1, "profile": "x", "wind": [0, 0] }))
            .contains("profile")
    );
}

/// A session ends after half an hour, with its last state, and says so.
#[test]
fn half_an_hour_is_the_end() {
    let playground = &mut Playground::default();
    let view = later(playground, 1_900);
    assert_eq!((view["at_ms"].as_u64(), view["over"].as_bool()), (Some(1_800_000), Some(true)));
    let act = json!({ "op": "act", "act": { "kind": "sweep" } });
    assert!(error(playground, act).contains("full"));
    assert!(Session::from_fragment(&playground.session().fragment()).is_ok());
}

/// One call never lets more than two seconds pass, whatever it asks for.
#[test]
fn a_call_is_short() {
    let playground = &mut Playground::default();
    let view = ok(playground, json!({ "op": "advance", "ms": u32::MAX, "since": 9 }));
    assert_eq!(view["at_ms"], 2_000);
}
