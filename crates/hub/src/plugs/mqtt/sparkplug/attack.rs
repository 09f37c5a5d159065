//! Writes of a legal session over Sparkplug, lost, repeated, delayed, sent elsewhere and changed by chance: the one
//! opening that was meant is carried out, and never another.

use prost::Message as _;
use serde_json::{Value as Json, json};

use super::commands::{self, Write};
use super::payload::{Metric, Payload, Value};
use crate::plugs::mqtt::attack::{Dice, opens};
use crate::plugs::mqtt::desk::Act;
use crate::plugs::mqtt::desk_tests::{Bench, TERMS, number};

/// Streams in a run; `LAFET_ATTACKS` for the long one.
const ATTACKS: u64 = 20_000;

fn written(text: String) -> Vec<u8> {
    let metric = Metric {
        name: Some("Command/Text".into()),
        value: Some(Value::Text(text)),
        ..Metric::default()
    };
    Payload { timestamp: Some(1), metrics: vec![metric], seq: None }.encode_to_vec()
}

fn hear(bench: &mut Bench, device: Option<usize>, retained: bool, payload: &[u8]) -> Vec<Act> {
    let mut all = Vec::new();
    for write in commands::read(device, payload) {
        if let Write::Asked { asked, is_old } = write {
            let acts = bench.ask(device, retained || is_old, asked);
            if let Some(number) = number(&acts) {
                bench.desk.answered(number, Ok(()));
            }
            all.extend(acts);
        }
    }
    all
}

fn changed(dice: &mut Dice, payload: &[u8]) -> Vec<u8> {
    let mut payload = payload.to_vec();
    match dice.below(5) {
        0 => {
            let at = dice.below(payload.len() as u64) as usize;
            payload[at] ^= 1 << dice.below(8);
        }
        1 => payload.truncate(dice.below(payload.len() as u64) as usize),
        // The same write twice in one message.
        2 => payload.extend(payload.clone()),
        // Another id, as a client that repeats with care would have.
        3 => {
            let text = String::from_utf8_lossy(&payload).into_owned();
            let json = text.find('{').map(|at| &text[at..]).unwrap_or_default();
            if let Ok(mut json) = serde_json::from_str::<Json>(json) {
                json["id"] = json!(format!("x{}", dice.below(1 << 40)));
                payload = written(json.to_string());
            }
        }
        _ => {}
    }
    payload
}

/// One stream: openings that were meant, others, and what was refused.
fn attack(dice: &mut Dice) -> (usize, usize, usize) {
    let mut bench = Bench::of_seed(TERMS, dice.below(u64::MAX));
    let (mut recorded, mut meant, mut others, mut refused) = (Vec::new(), 0, 0, 0);
    for command in ["take", "goto", "open", "goto", "release"] {
        bench.pass(100 + dice.below(900));
        let more = match command {
            "goto" => json!({ "nozzle": dice.below(90) }),
            "open" => json!({ "valve": 1 + dice.below(2), "key": bench.key(0) }),
            _ => json!({}),
        };
        let own = written(bench.text(command, more));
        for _ in 0..1 + dice.below(2) {
            meant += opens(&hear(&mut bench, Some(0), false, &own));
        }
        recorded.push(own);
        for _ in 0..dice.below(4) {
            let pick = dice.below(recorded.len() as u64) as usize;
            let message = changed(dice, &recorded[pick]);
            bench.pass(dice.below(1500));
            let device = [None, Some(0), Some(1)][dice.below(3) as usize];
            let acts = hear(&mut bench, device, dice.below(10) == 0, &message);
            // Whether the own one has opened or was refused: there is no other.
            others += opens(&acts);
            refused += usize::from(!acts.iter().any(|it| matches!(it, Act::Do { .. })));
        }
    }
    // In the next session, all of it, in any order.
    bench = Bench::of_seed(TERMS, dice.below(u64::MAX));
    bench.pass(dice.below(5000));
    for _ in 0..recorded.len() {
        let pick = dice.below(recorded.len() as u64) as usize;
        let message = changed(dice, &recorded[pick]);
        others += opens(&hear(&mut bench, Some(0), false, &message));
    }
    (meant, others, refused)
}

#[test]
fn no_write_opens_that_was_not_meant_to() {
    let attacks = std::env::var("LAFET_ATTACKS").ok().and_then(|it| it.parse().ok());
    let attacks = attacks.unwrap_or(ATTACKS);
    let (mut dice, mut counts) = (Dice(0x5BA6), (0, 0, 0));
    for _ in 0..attacks {
        let (meant, others, refused) = attack(&mut dice);
        assert!(meant <= 1);
        counts = (counts.0 + meant, counts.1 + others, counts.2 + refused);
    }
    println!("{attacks} streams: {} meant, {} others, {} refused", counts.0, counts.1, counts.2);
    assert_eq!(counts.1, 0, "{counts:?}");
    // The openings that were meant are witnessed in the same run, and so is what was refused.
    assert!(counts.0 as u64 > attacks * 9 / 10, "{counts:?}");
    assert!(counts.2 as u64 > attacks, "{counts:?}");
}

#[test]
fn retained_and_old_writes_open_nothing() {
    let mut bench = Bench::new(TERMS);
    // Each with the key that is offered at that moment.
    let text = |bench: &mut Bench| {
        let key = bench.key(0);
        bench.text("open", json!({ "valve": 1, "key": key }))
    };
    let retained = written(text(&mut bench));
    assert_eq!(opens(&hear(&mut bench, Some(0), true, &retained)), 0);
    let metric = Metric {
        name: Some("Command/Text".into()),
        is_historical: Some(true),
        value: Some(Value::Text(text(&mut bench))),
        ..Metric::default()
    };
    let old = Payload { metrics: vec![metric], ..Payload::default() }.encode_to_vec();
    assert_eq!(opens(&hear(&mut bench, Some(0), false, &old)), 0);
    // Kept back for as long as its ticket lasts, while signs of life keep the key.
    let late = written(text(&mut bench));
    let key = bench.key(0);
    for _ in 0..3 {
        bench.pass(1000);
        let ticket = bench.ticket.expect("a ticket");
        bench.alive(ticket);
    }
    assert_eq!(bench.key(0), key);
    assert_eq!(opens(&hear(&mut bench, Some(0), false, &late)), 0);
    let own = written(text(&mut bench));
    assert_eq!(opens(&hear(&mut bench, Some(0), false, &own)), 1, "and by the rules it opens");
}
