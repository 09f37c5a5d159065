//! The stream of messages of a legal session, lost, repeated, delayed, reordered and changed by chance: the one
//! opening that was meant is carried out, and never another.

use serde_json::{Value, json};

use super::desk::{Act, Desk, Now};
use super::desk_tests::{Bench, TERMS, number, what};
use super::message::shown;
use crate::plugs::orders::What;

/// Streams in a run; `LAFET_ATTACKS` for the long one.
const ATTACKS: u64 = 100_000;

/// Random numbers that are the same in each run.
pub struct Dice(pub u64);

impl Dice {
    pub fn below(&mut self, most: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % most
    }
}

/// A message that a client has sent, and when.
#[derive(Clone)]
struct Sent {
    at: Now,
    monitor: usize,
    text: String,
}

pub fn opens(acts: &[Act]) -> usize {
    acts.iter().filter(|it| matches!(it, Act::Do { what: What::Open(_), .. })).count()
}

fn is_opening(message: &Sent) -> bool {
    message.text.contains("\"open\"")
}

fn answer(desk: &mut Desk, acts: &[Act]) {
    if let Some(number) = number(acts) {
        desk.answered(number, Ok(()));
    }
}

/// A client that takes authority, turns, opens once and closes; what it has sent.
fn legal(bench: &mut Bench, pauses: &mut dyn FnMut() -> u64) -> Vec<Sent> {
    let mut sent = Vec::new();
    for (command, more) in [
        ("take", json!({})),
        ("goto", json!({ "traverse": 10, "elevation": 5 })),
        ("open", json!({ "valve": 1 })),
        ("goto", json!({ "traverse": 12 })),
        ("close", json!({})),
        ("release", json!({})),
    ] {
        bench.pass(pauses());
        let mut more = more;
        if command == "open" {
            more["key"] = bench.key(0);
        }
        let text = bench.text(command, more);
        sent.push(Sent { at: bench.now, monitor: 0, text: text.clone() });
        let acts = bench.hear(Some(0), false, text.as_bytes());
        assert!(what(&acts).is_some(), "{command}: {acts:?}");
        answer(&mut bench.desk, &acts);
    }
    sent
}

fn changed(dice: &mut Dice, message: &Sent) -> Sent {
    let mut message = message.clone();
    match dice.below(6) {
        0 => message.monitor = 1,
        1 => {
            let mut bytes = message.text.into_bytes();
            let at = dice.below(bytes.len() as u64) as usize;
            bytes[at] ^= 1 << dice.below(7);
            message.text = String::from_utf8_lossy(&bytes).into_owned();
        }
        2 => {
            let keep = dice.below(message.text.len() as u64) as usize;
            message.text.truncate(keep);
        }
        // A new id, as a client that repeats with care would have.
        3 => {
            let mut text: Value = serde_json::from_str(&message.text).unwrap();
            text["id"] = json!(format!("x{}", dice.below(1 << 40)));
            message.text = text.to_string();
        }
        4 => {
            let mut text: Value = serde_json::from_str(&message.text).unwrap();
            text["key"] = json!(shown(dice.below(u64::MAX)));
            message.text = text.to_string();
        }
        _ => {}
    }
    message
}

/// How many streams, how many openings in them, and how many of these were meant.
#[derive(Debug, Default, PartialEq)]
struct Count {
    meant: usize,
    others: usize,
    refused: usize,
}

fn attack(dice: &mut Dice, count: &mut Count) {
    // While the legal session goes on, what it has sent comes again.
    let mut bench = Bench::of_seed(TERMS, dice.below(u64::MAX));
    let mut recorded: Vec<Sent> = Vec::new();
    let (mut opened, mut is_lost) = (0, false);
    for command in ["take", "goto", "open", "goto", "release"] {
        bench.pass(100 + dice.below(900));
        let more = match command {
            "goto" => json!({ "traverse": dice.below(90) }),
            "open" => json!({ "valve": 1 + dice.below(2), "key": bench.key(0) }),
            _ => json!({}),
        };
        let text = bench.text(command, more);
        let own = Sent { at: bench.now, monitor: 0, text };
        // The broker may deliver it late, or never; and twice.
        let lost = dice.below(20) == 0;
        is_lost |= lost && command == "open";
        for _ in 0..if lost { 0 } else { 1 + dice.below(2) } {
            let acts = bench.hear(Some(0), false, own.text.as_bytes());
            opened += opens(&acts);
            answer(&mut bench.desk, &acts);
        }
        recorded.push(own);
        for _ in 0..dice.below(4) {
            let pick = dice.below(recorded.len() as u64) as usize;
            // An opening that was lost may still arrive: then it is the one that was meant. One that was refused is not.
            if is_lost && is_opening(&recorded[pick]) {
                continue;
            }
            let message = changed(dice, &recorded[pick]);
            bench.pass(dice.below(1500));
            let retained = dice.below(10) == 0;
            let acts = bench.hear(Some(message.monitor), retained, message.text.as_bytes());
            count.others += opens(&acts);
            count.refused += usize::from(what(&acts).is_none());
            answer(&mut bench.desk, &acts);
        }
    }
    assert!(opened <= 1);
    count.meant += opened;
    // After it, and in another session: all of it, in any order.
    if dice.below(2) == 0 {
        bench = Bench::of_seed(TERMS, dice.below(u64::MAX));
        bench.pass(dice.below(5000));
    } else {
        bench.pass(dice.below(4000));
    }
    for _ in 0..recorded.len() {
        let pick = dice.below(recorded.len() as u64) as usize;
        if is_lost && is_opening(&recorded[pick]) {
            continue;
        }
        let message = changed(dice, &recorded[pick]);
        let acts = bench.hear(Some(message.monitor), false, message.text.as_bytes());
        count.others += opens(&acts);
        answer(&mut bench.desk, &acts);
        bench.pass(dice.below(500));
    }
}

#[test]
fn no_message_opens_that_was_not_meant_to() {
    let attacks = std::env::var("LAFET_ATTACKS").ok().and_then(|it| it.parse().ok());
    let attacks = attacks.unwrap_or(ATTACKS);
    let (mut dice, mut count) = (Dice(0x1AFE7), Count::default());
    for _ in 0..attacks {
        attack(&mut dice, &mut count);
    }
    println!("{attacks} streams: {count:?}");
    assert_eq!(count.others, 0, "{count:?}");
    // The openings that were meant are witnessed in the same run, and so is what was refused.
    assert!(count.meant as u64 > attacks * 8 / 10, "{count:?}");
    assert!(count.refused as u64 > attacks, "{count:?}");
}

#[test]
fn the_recording_opens_once_and_never_again() {
    let mut bench = Bench::new(TERMS);
    let sent = legal(&mut bench, &mut || 300);
    let again = |bench: &mut Bench| {
        let acts = sent.iter().map(|it| bench.hear(Some(0), false, it.text.as_bytes()));
        acts.map(|acts| opens(&acts)).sum::<usize>()
    };
    assert_eq!(again(&mut bench), 0, "in the same session, at once");
    bench.pass(10_000);
    assert_eq!(again(&mut bench), 0, "later");
    assert!(sent.iter().is_sorted_by_key(|it| it.at));
    assert_eq!(opens(&bench.open()), 1, "and by the rules it opens");
}
