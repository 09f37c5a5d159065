//! An opening by the rules is recorded, and the recording is sent again: as it is, cut, reordered, with bits
//! changed. It opens nothing. More of it: `LAFET_ATTACKS=10000000 cargo test -p lafet-hub --lib attack`.

use std::time::Duration;

use super::desk::{Act, Around, Desk, Terms, What};
use super::layout::{
    COMMAND, COMMAND_LEN, DETAIL_LEN, HEARTBEAT, NAME_LEN, SUMMARY_LEN, halves, key_words,
};
use super::pdu::{self, Ask};
use super::sight::{Holder, Seen, Sight};

const SESSION: u32 = 0xCAFE_0001;
const USUAL: u64 = 100_000;
const BEAT: Duration = Duration::from_millis(70);

/// Numbers that look random and are the same in each run.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    fn below(&mut self, end: usize) -> usize {
        (self.roll() % end.max(1) as u64) as usize
    }
}

/// The worst case: the session holds all eight monitors.
fn sight() -> Sight {
    let one = Seen {
        holder: Holder::Mine,
        words: [0; SUMMARY_LEN],
        detail: [0; DETAIL_LEN],
        name: [0; NAME_LEN],
    };
    Sight { header: [0; 5], monitors: vec![one; 8] }
}

fn terms() -> Terms {
    Terms { heartbeat: Duration::from_millis(150), answer: Duration::from_secs(5), closes: false }
}

fn write(first: u16, words: &[u16]) -> Vec<u8> {
    let mut pdu = vec![pdu::WRITE_MANY];
    pdu.extend(first.to_be_bytes());
    pdu.extend((words.len() as u16).to_be_bytes());
    pdu.push(2 * words.len() as u8);
    pdu.extend(words.iter().flat_map(|it| it.to_be_bytes()));
    pdu
}

fn command(sequence: u16, number: u16, key: u64) -> Vec<u8> {
    let [high, low] = halves(SESSION);
    let [k1, k2, k3, k4] = key_words(key);
    let block: [u16; COMMAND_LEN] = [sequence, high, low, number, 1, 1, 0, 0, 0, k1, k2, k3, k4];
    write(COMMAND, &block)
}

/// The frames of an opening by the rules, with the key that is offered for the first monitor.
fn recording(key: u64) -> Vec<Vec<u8>> {
    let beats = |values: std::ops::Range<u16>| values.map(|it| write(HEARTBEAT, &[it]));
    let mut frames: Vec<Vec<u8>> = beats(1..11).collect();
    frames.push(command(1, 1, 0));
    frames.extend(beats(11..12));
    frames.push(command(2, 5, key));
    frames.extend(beats(12..14));
    frames
}

/// Sends a frame; how many valves that opens.
fn send(desk: &mut Desk, now: Duration, sight: &Sight, dice: &mut Dice, frame: &[u8]) -> usize {
    let Ok(Ask::Write { first, words }) = pdu::parse(frame) else { return 0 };
    let mut random = || Some(dice.roll());
    let (operates, broadcast, surplus) = (true, false, false);
    let mut around = Around { now, operates, broadcast, surplus, sight, random: &mut random };
    let acts = desk.write(&mut around, first, &words).unwrap_or_default();
    let mut opened = 0;
    for act in acts {
        if let Act::Do { ticket, what, .. } = act {
            opened += usize::from(matches!(what, What::Open(_)));
            desk.answered(ticket, Ok(()));
        }
    }
    opened
}

fn key_of(desk: &Desk, sight: &Sight, monitor: u16) -> u64 {
    let first = super::layout::KEYS + 4 * monitor;
    let words = desk.read(true, sight, first, 4).unwrap();
    words.iter().fold(0, |key, word| key << 16 | u64::from(*word))
}

/// Changes a recording in one of the ways in which lines and people do.
fn mutate(dice: &mut Dice, frames: &mut Vec<Vec<u8>>) {
    let at = dice.below(frames.len());
    match dice.below(8) {
        0 => {}
        1 => {
            let other = dice.below(frames.len());
            frames.swap(at, other);
        }
        2 => frames.truncate(at + 1),
        3 => _ = frames.remove(at),
        4 => {
            let again = frames[at].clone();
            let place = dice.below(frames.len() + 1);
            frames.insert(place, again);
        }
        5 => {
            let len = dice.below(frames[at].len());
            frames[at].truncate(len);
        }
        6 => {
            // The beginning of one frame and the end of another.
            let (other, cut) = (frames[dice.below(frames.len())].clone(), dice.below(40));
            frames[at].truncate(cut);
            frames[at].extend(other.iter().skip(cut));
        }
        _ => {
            for _ in 0..=dice.below(6) {
                let byte = dice.below(frames[at].len());
                if let Some(byte) = frames[at].get_mut(byte) {
                    *byte ^= 1 << dice.below(8);
                }
            }
        }
    }
}

fn attacks() -> u64 {
    std::env::var("LAFET_ATTACKS").ok().and_then(|it| it.parse().ok()).unwrap_or(USUAL)
}

#[test]
fn the_recording_opens_once_and_never_again() {
    let (sight, mut dice) = (sight(), Dice(1));
    let mut desk = Desk::new(terms(), SESSION, Duration::ZERO, &mut || Some(dice.roll()));
    let frames = recording(key_of(&desk, &sight, 0));
    let mut opened = 0;
    for (at, frame) in (1..).zip(&frames) {
        opened += send(&mut desk, at * BEAT, &sight, &mut dice, frame);
    }
    assert_eq!(opened, 1, "an opening by the rules is carried out");
    // In the same session, with its heartbeat alive and its authority: the key has changed.
    let mut now = frames.len() as u32 * BEAT;
    let mut beat = 100;
    for _ in 0..attacks() / 2 {
        let mut frames = frames.clone();
        mutate(&mut dice, &mut frames);
        for frame in &frames {
            now += BEAT / 2;
            beat = u16::wrapping_add(beat, 1);
            opened += send(&mut desk, now, &sight, &mut dice, &write(HEARTBEAT, &[beat]));
            // The sequence number is made new: nothing but the key is in the way.
            let mut frame = frame.clone();
            if frame.len() > 8 && frame[2] == 8 {
                frame[6..8].copy_from_slice(&beat.to_be_bytes());
            }
            opened += send(&mut desk, now, &sight, &mut dice, &frame);
        }
    }
    assert_eq!(opened, 1);
    // That it was not the rest of the frame that was refused: with its key it opens.
    now += BEAT;
    send(&mut desk, now, &sight, &mut dice, &write(HEARTBEAT, &[beat.wrapping_add(1)]));
    let key = key_of(&desk, &sight, 0);
    assert_eq!(send(&mut desk, now, &sight, &mut dice, &command(beat.wrapping_add(2), 5, key)), 1);
}

#[test]
fn in_another_session_it_opens_nothing() {
    let (sight, mut dice) = (sight(), Dice(2));
    let mut first = Desk::new(terms(), SESSION, Duration::ZERO, &mut || Some(dice.roll()));
    let frames = recording(key_of(&first, &sight, 0));
    let whole = (1..)
        .zip(&frames)
        .map(|(at, frame)| send(&mut first, at * BEAT, &sight, &mut Dice(3), frame));
    assert_eq!(whole.sum::<usize>(), 1);
    let mut opened = 0;
    for attack in 0..attacks() / 2 {
        // Every other time the attacker has been given the session number as well.
        let session = if attack % 2 == 0 { SESSION } else { dice.roll() as u32 | 1 };
        let mut desk = Desk::new(terms(), session, Duration::ZERO, &mut || Some(dice.roll()));
        let mut frames = frames.clone();
        for _ in 0..=dice.below(3) {
            if !frames.is_empty() {
                mutate(&mut dice, &mut frames);
            }
        }
        let mut now = Duration::ZERO;
        for frame in &frames {
            now += Duration::from_millis(dice.roll() % 160);
            opened += send(&mut desk, now, &sight, &mut dice, frame);
        }
    }
    assert_eq!(opened, 0);
}
