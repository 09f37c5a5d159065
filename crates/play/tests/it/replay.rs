//! A session that was shared ends in the state in which it was.

use lafet_play::{EXAMPLES, Playground, Session};
use serde_json::json;

use crate::{later, ok, send};

/// Fragment and last view of a session with a bit of everything, looked at in odd slices.
fn lived(slice_ms: u32) -> (String, serde_json::Value) {
    let mut playground = Playground::default();
    ok(&mut playground, json!({ "op": "start", "seed": 77, "profile": "full", "wind": [3, -2] }));
    let run = |playground: &mut Playground, ms: u32| {
        let end = playground.session().steps * 10 + ms;
        while playground.session().steps * 10 < end {
            let left = end - playground.session().steps * 10;
            ok(playground, json!({ "op": "advance", "ms": slice_ms.min(left), "since": 0 }));
        }
    };
    run(&mut playground, 430);
    let light = json!({ "kind": "light", "azimuth": -20, "range": 25, "fuel": false });
    ok(&mut playground, json!({ "op": "act", "act": light }));
    send(&mut playground, "Deploy");
    run(&mut playground, 12_000);
    send(&mut playground, "SetParam Vertical Speed 7; Move Vertical 400");
    send(&mut playground, "Open Valve1");
    run(&mut playground, 5_010);
    ok(
        &mut playground,
        json!({ "op": "act", "act": { "kind": "break", "fault": "horizontal-jam" } }),
    );
    let input = |text: &str| json!({ "bytes": false, "text": text });
    let (wired, radio) = (input("Move Horizontal 600"), input("Close Valve1"));
    let race = json!({ "kind": "race", "first": "radio", "wired": wired, "radio": radio });
    ok(&mut playground, json!({ "op": "act", "act": race }));
    run(&mut playground, 3_000);
    ok(&mut playground, json!({ "op": "act", "act": { "kind": "power" } }));
    run(&mut playground, 2_570);
    let fragment = ok(&mut playground, json!({ "op": "share" }));
    (fragment.as_str().unwrap().to_owned(), later(&mut playground, 0))
}

#[test]
fn a_shared_session_is_repeated_to_the_same_state() {
    let (fragment, lived) = lived(130);
    assert!(fragment.len() < 250, "{} characters", fragment.len());
    for slice_ms in [10, 70, 2_000] {
        let mut playground = Playground::open(&fragment).unwrap();
        while playground.is_repeating() {
            playground.advance(slice_ms);
        }
        let repeated = later(&mut playground, 0);
        assert_eq!(repeated, lived, "in slices of {slice_ms} ms");
        assert_eq!(playground.session().fragment(), fragment);
    }
}

#[test]
fn how_often_the_page_looks_does_not_matter() {
    assert_eq!(lived(50), lived(990));
}

/// The hash knows of everything: another seed, a request more, a moment later.
#[test]
fn another_session_has_another_hash() {
    let session = EXAMPLES[1].session();
    let hash = |session: &Session| {
        let mut playground = Playground::open(&session.fragment()).unwrap();
        while playground.is_repeating() {
            playground.advance(2_000);
        }
        playground.hash()
    };
    let mut others = vec![hash(&session)];
    let mut seed = session.clone();
    seed.setup.seed += 1;
    others.push(hash(&seed));
    let mut fewer = session.clone();
    fewer.actions.pop();
    others.push(hash(&fewer));
    let mut later = session.clone();
    later.actions[1].0 += 1;
    others.push(hash(&later));
    others.sort_unstable();
    others.dedup();
    assert_eq!(others.len(), 4);
}

/// Who acts in the middle of a recorded session goes on from there.
#[test]
fn an_action_ends_the_repetition() {
    let mut playground = Playground::open(&EXAMPLES[1].session().fragment()).unwrap();
    playground.advance(2_000);
    assert!(playground.is_repeating());
    send(&mut playground, "Stop All");
    assert!(!playground.is_repeating());
    let view = later(&mut playground, 20);
    assert_eq!(view["count"], 3, "light, deploy, stop");
    assert_eq!(view["at_ms"], 22_000);
}

/// The five sessions of a first visit show what their titles say.
#[test]
fn the_examples_show_what_they_promise() {
    let views: Vec<_> = EXAMPLES
        .iter()
        .map(|example| {
            let mut playground = Playground::open(&example.session().fragment()).unwrap();
            while playground.is_repeating() {
                playground.advance(2_000);
            }
            later(&mut playground, 0)
        })
        .collect();
    let verdict = |view: usize, entry: usize| {
        let verdict = &views[view]["entries"][entry]["walks"][0]["verdicts"][0];
        format!("{} {}", verdict["from"].as_str().unwrap(), verdict["status"].as_str().unwrap())
    };
    assert_eq!(verdict(0, 0), "Deployer Ok");
    assert!(views[1]["scene"]["deployed"].as_bool().unwrap());
    assert!(views[1]["scene"]["water"].is_object(), "the jet");
    assert!(verdict(2, 0).starts_with("Valve1 "), "closing is the safe direction");
    assert_eq!(verdict(2, 1), "Deployer Denied");
    assert_eq!(verdict(2, 2), "Deployer Denied");
    assert_eq!(
        (verdict(3, 1), verdict(3, 2)),
        ("Horizontal Accepted".into(), "Horizontal Accepted".into())
    );
    assert_eq!(verdict(3, 4), "Detector Denied", "the search of the other client has the drives");
    let mut race = Playground::open(&EXAMPLES[3].session().fragment()).unwrap();
    let before_the_search = later(&mut race, 14);
    let azimuth = before_the_search["scene"]["azimuth"].as_f64().unwrap();
    assert!(azimuth < -1.0, "the later Move won: {azimuth}");
    let flags = views[4]["states"].as_array().unwrap().iter().find(|it| it["name"] == "Vertical");
    let flags = flags.unwrap()["flags"].to_string();
    assert!(flags.contains("Limit") || flags.contains("Fault"), "{flags}");
}
