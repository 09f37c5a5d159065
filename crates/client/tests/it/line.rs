//! Several monitors on one line, on virtual time: whose turn it is, and who may overtake.

use std::time::Duration;

use crate::fake::{answer, encode};
use lafet_client::session::line::Line;
use lafet_client::session::{Config, Now, Outcome, QUEUE_MAX, Terms, Ticket};
use lafet_client::{Echo, RequestBuf, Role};
use lafet_proto::bus::CONTROLLER;
use lafet_proto::link::Decoder;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};

const MS: Duration = Duration::from_millis(1);
const SECOND: Duration = Duration::from_secs(1);
const STOP: [u8; 4] = [0x46, 0x5D, 0, 0];
/// AccessGranted (observed).
const GRANT: [u8; 4] = [0xE6, 0xC2, 0, 0];

fn read() -> Vec<RequestBuf> {
    buf(Request::new(SubsystemId::VERTICAL, Body::GetStatus))
}

fn moving() -> Vec<RequestBuf> {
    buf(Request::new(SubsystemId::VERTICAL, Body::Move { destination: 1 }))
}

fn stop() -> Vec<RequestBuf> {
    buf(Request::new(SubsystemId::ALL, Body::Stop))
}

fn buf(request: Request<'_>) -> Vec<RequestBuf> {
    vec![RequestBuf::new(&request).unwrap()]
}

fn connected(config: Config) -> Line {
    let mut line = Line::new(config);
    line.handle_connected(Now::ZERO);
    line
}

fn ask(line: &mut Line, now: Now, address: u8, requests: Vec<RequestBuf>) -> Ticket {
    line.submit(now, address, Terms::default(), requests).unwrap()
}

/// What is sent now: to whom, and the records.
fn sent(line: &mut Line, now: Now) -> Option<(u8, Vec<u8>)> {
    let bytes = line.poll_transmit(now)?;
    let mut decoder: Decoder = Decoder::new();
    let frame = decoder.push_slice(&bytes).1.expect("a frame");
    Some((frame.dst, frame.payload.to_vec()))
}

fn reply(line: &mut Line, now: Now, from: u8, payload: &[u8]) {
    line.handle_bytes(now, &encode(129, from, &answer(payload)));
}

fn answered(line: &mut Line) -> Vec<Ticket> {
    let ends = std::iter::from_fn(|| line.poll_outcome());
    ends.filter(|(_, end)| matches!(end, Outcome::Answered(_))).map(|(ticket, _)| ticket).collect()
}

/// A monitor that is never silent for long and one that asks for a lot: turn by turn.
#[test]
fn the_line_is_shared_fairly() {
    let mut line = connected(Config::default());
    for _ in 0..5 {
        ask(&mut line, Now::ZERO, 7, read());
    }
    ask(&mut line, Now::ZERO, 8, read());
    ask(&mut line, Now::ZERO, 9, read());
    let mut order = Vec::new();
    for n in 0..7 {
        let now = n * 10 * MS;
        let (to, payload) = sent(&mut line, now).unwrap();
        assert_eq!(sent(&mut line, now), None, "one frame on the line at a time");
        reply(&mut line, now + MS, to, &payload);
        assert_eq!(answered(&mut line).len(), 1);
        order.push(to);
    }
    // One that answers has a turn after each of which nothing is known yet.
    assert_eq!(order, [7, 7, 8, 7, 9, 7, 7]);
    assert!(line.is_idle() && line.poll_timeout(SECOND).is_none());
    assert_eq!((line.stats(7).believed, line.stats(8).believed, line.total().believed), (5, 1, 7));
}

/// A monitor that is off holds the line for one timeout, and for less as soon as others answer.
#[test]
fn a_silent_monitor_does_not_take_the_line() {
    let mut line = connected(Config::default());
    ask(&mut line, Now::ZERO, 2, read());
    for _ in 0..3 {
        ask(&mut line, Now::ZERO, 1, read());
    }
    let (mut now, mut order, mut waits) = (Now::ZERO, Vec::new(), Vec::new());
    for _ in 0..5 {
        let (to, payload) = sent(&mut line, now).expect("due");
        order.push(to);
        match to {
            1 => {
                now += MS;
                reply(&mut line, now, 1, &payload);
            }
            _ => {
                let until = line.poll_timeout(now).expect("the answer is waited for");
                waits.push(until - now);
                now = until;
                line.handle_timeout(now);
            }
        }
    }
    assert_eq!((order, waits), (vec![2, 1, 1, 2, 1], vec![SECOND, 102 * MS]));
    let silent = std::iter::from_fn(|| line.poll_outcome())
        .filter(|(_, outcome)| *outcome == Outcome::Silence { tries: 2, stray: None });
    assert_eq!(silent.count(), 1);
    assert_eq!((line.stats(1).timeouts, line.stats(2).timeouts), (0, 2));
    assert_eq!(line.silent_tries(), 0, "a monitor answers: the connection is sound");
}

/// A half-open connection shows by the monitors that were heard on it, though another is off, or was asked only once.
#[test]
fn a_connection_without_answers_shows_beside_monitors_that_are_off() {
    for (other, answers) in [(2, false), (3, true)] {
        let mut line = connected(Config::default());
        let mut now = Now::ZERO;
        for address in [1, other] {
            ask(&mut line, now, address, read());
        }
        while now < 5 * SECOND {
            match sent(&mut line, now) {
                Some((to, payload)) if to == 1 || answers => {
                    now += MS;
                    reply(&mut line, now, to, &payload);
                }
                _ => {
                    let next = line.poll_timeout(now).unwrap_or(5 * SECOND);
                    now = next.max(now + MS);
                    line.handle_timeout(now);
                }
            }
        }
        assert_eq!(line.silent_tries(), 0, "{other}");
        let (mut most, from) = (0, now);
        while most < 2 && now < from + 5 * SECOND {
            ask(&mut line, now, 1, read());
            while sent(&mut line, now).is_some() {}
            now = line.poll_timeout(now).expect("an answer is waited for").max(now + MS);
            line.handle_timeout(now);
            most = most.max(line.silent_tries());
        }
        assert!(most >= 2 && now <= from + 3_500 * MS, "{other}: {most} after {:?}", now - from);
    }
}

/// 31 of 32 monitors fall silent at once: the one that is heard has its turn after each of them.
#[test]
fn many_that_fall_silent_at_once_do_not_take_the_line() {
    let mut line = connected(Config::default());
    let mut now = Now::ZERO;
    for _ in 0..2 {
        (1..=32).for_each(|address| _ = ask(&mut line, now, address, read()));
        while let Some((to, payload)) = sent(&mut line, now) {
            now += MS;
            reply(&mut line, now, to, &payload);
        }
        assert_eq!(answered(&mut line).len(), 32);
    }
    (1..=32).for_each(|address| _ = ask(&mut line, now, address, read()));
    let (from, mut turn, mut longest) = (now, None, Duration::ZERO);
    while now < from + 10 * SECOND {
        match sent(&mut line, now) {
            Some((16, payload)) => {
                longest = longest.max(now - turn.unwrap_or(now));
                now += MS;
                turn = Some(now);
                reply(&mut line, now, 16, &payload);
                ask(&mut line, now, 16, read());
            }
            _ => {
                now = line.poll_timeout(now).expect("an answer is waited for").max(now + MS);
                line.handle_timeout(now);
            }
        }
    }
    assert!(turn.is_some() && longest <= 160 * MS, "{longest:?} without a turn");
}

/// What one monitor answers is never taken for another's, though all asked for the same.
#[test]
fn answers_are_told_apart_by_their_sender() {
    let mut line = connected(Config::default());
    let first = ask(&mut line, Now::ZERO, 1, read());
    let second = ask(&mut line, Now::ZERO, 2, read());
    let (_, payload) = sent(&mut line, Now::ZERO).unwrap();
    reply(&mut line, MS, 2, &payload);
    assert_eq!(answered(&mut line), [], "nothing was asked of it yet");
    assert_eq!(line.stats(2).unmatched, 1);
    reply(&mut line, MS, 1, &payload);
    assert_eq!(answered(&mut line), [first]);
    let (to, payload) = sent(&mut line, MS).unwrap();
    assert_eq!(to, 2);
    reply(&mut line, MS, 3, &payload);
    reply(&mut line, MS, 2, &payload);
    assert_eq!(answered(&mut line), [second]);
    assert_eq!(line.total().foreign, 1);
}

/// Stop overtakes full queues of its own monitor and of others, frames in flight and quarantine.
#[test]
fn a_stop_overtakes_everything() {
    // Untagged monitors of which one is in doubt: what would be mistaken waits, a Stop does not.
    let drain_bound = 3 * SECOND;
    let config = Config { tags: false, tries: 1, drain_bound, ..Config::default() };
    let mut line = connected(config);
    ask(&mut line, Now::ZERO, 2, stop());
    assert_eq!(sent(&mut line, Now::ZERO).unwrap(), (2, STOP.to_vec()));
    ask(&mut line, Now::ZERO, 2, read());
    line.handle_timeout(SECOND);
    let (_, payload) = sent(&mut line, SECOND).unwrap();
    line.handle_timeout(2 * SECOND);
    let now = 2 * SECOND;
    ask(&mut line, now, 2, read());
    assert_eq!(sent(&mut line, now), None, "the late answer could be mistaken for this one's");
    reply(&mut line, now, 2, &payload);
    while line.poll_outcome().is_some() {}
    // Full queues, and a frame in flight to another monitor.
    for _ in 1..QUEUE_MAX {
        ask(&mut line, now, 2, moving());
    }
    assert!(line.submit(now, 2, Terms::default(), moving()).is_err(), "full");
    for _ in 0..QUEUE_MAX {
        ask(&mut line, now, 1, read());
    }
    assert_eq!(sent(&mut line, now).unwrap().0, 1);
    let stopped = ask(&mut line, now, 2, stop());
    assert_eq!(line.poll_timeout(now), Some(now + 150 * MS));
    assert_eq!(sent(&mut line, now + 149 * MS), None, "the answer has a moment to come");
    let at = now + 150 * MS;
    assert_eq!(sent(&mut line, at).unwrap(), (2, STOP.to_vec()));
    // None of the motions is sent any more; the other monitor's answer is still believed.
    let superseded = std::iter::from_fn(|| line.poll_outcome())
        .filter(|(_, outcome)| matches!(outcome, Outcome::Superseded { sent: false, .. }));
    assert_eq!(superseded.count(), QUEUE_MAX - 1);
    reply(&mut line, at + MS, 1, read()[0].bytes());
    assert_eq!(answered(&mut line).len(), 1);
    // A Stop in doubt is sent at once, and again when its answer can be believed.
    reply(&mut line, at + MS, 2, &STOP);
    let mut now = at + MS;
    for _ in 0..20 {
        if answered(&mut line).contains(&stopped) {
            return;
        }
        now = line.poll_timeout(now).unwrap().max(now + MS);
        line.handle_timeout(now);
        if let Some((to, payload)) = sent(&mut line, now) {
            reply(&mut line, now, to, &payload);
        }
    }
    panic!("the Stop was never answered");
}

/// A console on a bus with a controller speaks once for each grant.
#[test]
fn with_a_controller_it_speaks_when_granted() {
    let mut line = connected(Config { role: Role::Active, ..Config::default() });
    ask(&mut line, Now::ZERO, 1, read());
    ask(&mut line, Now::ZERO, 2, stop());
    assert_eq!(sent(&mut line, Now::ZERO), None);
    // Another device's grant is none of ours.
    line.handle_bytes(MS, &encode(130, CONTROLLER, &GRANT));
    assert_eq!(sent(&mut line, MS), None);
    line.handle_bytes(MS, &encode(129, CONTROLLER, &GRANT));
    assert_eq!(sent(&mut line, MS).unwrap().0, 2, "what is urgent goes first");
    reply(&mut line, 2 * MS, 2, &STOP);
    assert_eq!(sent(&mut line, 3 * MS), None, "one frame for one grant");
    line.handle_bytes(4 * MS, &encode(129, CONTROLLER, &GRANT));
    assert_eq!(sent(&mut line, 4 * MS).unwrap().0, 1);
    reply(&mut line, 5 * MS, 1, read()[0].bytes());
    // Nothing to say, or only asked whether it is there: the empty frame to the controller.
    for payload in [&GRANT[..], &[]] {
        line.handle_bytes(6 * MS, &encode(129, CONTROLLER, payload));
        assert_eq!(sent(&mut line, 6 * MS), Some((CONTROLLER, vec![])));
    }
}

/// A grant is for now: a late frame would fall into another device's turn.
#[test]
fn a_grant_passes() {
    let active = || connected(Config { role: Role::Active, ..Config::default() });
    let mut line = active();
    ask(&mut line, Now::ZERO, 1, read());
    line.handle_bytes(MS, &encode(129, CONTROLLER, &GRANT));
    assert_eq!(sent(&mut line, 40 * MS), None, "too late");
    let mut line = active();
    ask(&mut line, Now::ZERO, 1, read());
    let heard = [encode(129, CONTROLLER, &GRANT), encode(130, CONTROLLER, &GRANT)].concat();
    line.handle_bytes(MS, &heard);
    assert_eq!(sent(&mut line, MS), None, "the word is another's by now");
}

/// Without a controller a console says so after 3 s; with one that passes it over, after 30 s.
#[test]
fn waiting_for_a_grant_in_vain() {
    let active = || connected(Config { role: Role::Active, ..Config::default() });
    let mut line = active();
    ask(&mut line, Now::ZERO, 1, read());
    let end = |line: &mut Line, from: Now, each: &mut dyn FnMut(&mut Line, Now)| {
        for step in 0..4000u32 {
            let now = from + step * 10 * MS;
            each(line, now);
            assert_eq!(sent(line, now), None);
            if let Some((_, outcome)) = line.poll_outcome() {
                return (outcome, now);
            }
        }
        panic!("it waits for ever");
    };
    let (outcome, at) = end(&mut line, Now::ZERO, &mut |_, _| {});
    assert_eq!((outcome, at), (Outcome::NoGrant { controller: false }, 3000 * MS));
    let mut line = active();
    ask(&mut line, Now::ZERO, 1, read());
    let (outcome, at) = end(&mut line, Now::ZERO, &mut |line, now| {
        line.handle_bytes(now, &encode(130, CONTROLLER, &GRANT));
    });
    assert_eq!((outcome, at), (Outcome::NoGrant { controller: true }, 30_000 * MS));
}

/// In the role `direct` it does not speak where a controller gives leave to speak.
#[test]
fn who_is_alone_does_not_speak_on_an_ordered_line() {
    let mut line = connected(Config::default());
    line.handle_bytes(MS, &encode(130, CONTROLLER, &GRANT));
    ask(&mut line, 2 * MS, 1, read());
    assert_eq!(sent(&mut line, 2 * MS), None);
    assert_eq!(line.poll_outcome().map(|(_, outcome)| outcome), Some(Outcome::ControllerPresent));
    // A Stop goes out all the same: better garbled than not sent.
    ask(&mut line, 3 * MS, 1, stop());
    assert_eq!(sent(&mut line, 3 * MS).unwrap().0, 1);
    // The controller is gone for 3 s.
    let later = 3100 * MS;
    line.handle_timeout(later);
    while line.poll_outcome().is_some() {}
    ask(&mut line, later, 2, read());
    assert_eq!(sent(&mut line, later).unwrap().0, 2);
}

#[test]
fn a_transceiver_has_time_to_turn_round() {
    let mut line = connected(Config { turnaround: 5 * MS, ..Config::default() });
    ask(&mut line, Now::ZERO, 1, read());
    ask(&mut line, Now::ZERO, 1, read());
    let (_, payload) = sent(&mut line, Now::ZERO).unwrap();
    reply(&mut line, 20 * MS, 1, &payload);
    assert_eq!(sent(&mut line, 20 * MS), None);
    assert_eq!(line.poll_timeout(20 * MS), Some(25 * MS));
    assert!(sent(&mut line, 25 * MS).is_some());
}

/// What comes back of a frame is not taken for anything; where it differs, two spoke at once.
#[test]
fn echo() {
    for echo in [Echo::Off, Echo::Strip, Echo::Verify] {
        let mut line = connected(Config { echo, ..Config::default() });
        for n in 0..10u32 {
            let now = n * 10 * MS;
            ask(&mut line, now, 1, read());
            let bytes = line.poll_transmit(now).unwrap();
            let mut back = bytes.clone();
            if n == 3 {
                back[5] ^= 0x40;
            }
            line.handle_bytes(now, &back);
            reply(&mut line, now, 1, read()[0].bytes());
            assert_eq!(answered(&mut line).len(), 1, "{echo:?} {n}");
        }
        let stats = line.total();
        let foreign = if echo == Echo::Off { 9 } else { 0 };
        assert_eq!(stats.foreign, foreign, "{echo:?}: {stats:?}");
        assert_eq!(stats.collisions, u64::from(echo == Echo::Verify));
        assert_eq!((stats.crc_errors, stats.echoes_missing), (1, 0), "{echo:?}");
    }
}

/// Answered reads of the one monitor in the second half of a minute, when so many others are polled that do not; and the
/// longest time between two of its answers.
fn answers_beside(absent: u8, answer_takes: Duration) -> (u32, Duration) {
    let mut line = connected(Config::default());
    let (mut now, minute) = (Now::ZERO, 60 * SECOND);
    let mut due: Vec<(u8, Now)> = (1..=1 + absent).map(|address| (address, Now::ZERO)).collect();
    let (mut asked, mut count, mut last, mut gap) = (Vec::new(), 0, Now::ZERO, Duration::ZERO);
    let mut answer_at = None;
    while now < minute {
        // Each is asked five times a second, as soon as its last question has ended.
        for (address, at) in &mut due {
            if now >= *at && !asked.iter().any(|(_, of)| of == address) {
                asked.push((ask(&mut line, now, *address, read()), *address));
                *at = (*at + 200 * MS).max(now);
            }
        }
        if let Some((to, payload)) = sent(&mut line, now)
            && to == 1
        {
            answer_at = Some((now + answer_takes, payload));
        }
        while let Some((ticket, end)) = line.poll_outcome() {
            let at = asked.iter().position(|(known, _)| *known == ticket).expect("asked");
            if asked.swap_remove(at).1 == 1 && matches!(end, Outcome::Answered(_)) {
                // The first half shows which are there.
                count += u32::from(now > 30 * SECOND);
                gap = gap.max(now - last);
                last = now;
            }
        }
        now += MS;
        if let Some((at, payload)) = answer_at.take() {
            if now >= at {
                reply(&mut line, now, 1, &payload);
            } else {
                answer_at = Some((at, payload));
            }
        }
        line.handle_timeout(now);
    }
    (count, gap)
}

/// 31 of 32 addresses are silent: the one keeps its rate.
#[test]
fn absent_monitors_cost_the_others_nothing() {
    for takes in [2 * MS, 15 * MS, 110 * MS] {
        let (alone, _) = answers_beside(0, takes);
        let (beside, gap) = answers_beside(31, takes);
        println!("an answer takes {takes:?}: {beside} of {alone} reads, longest gap {gap:?}");
        assert!(alone >= 145, "{alone}");
        assert!(beside * 10 >= alone * 9, "{takes:?}: {beside} of {alone}");
        assert!(gap < 600 * MS, "{takes:?}: {gap:?}");
    }
}

/// One that comes back is found again soon, and is then asked as often as before.
#[test]
fn an_absent_monitor_that_comes_back_is_found() {
    let mut line = connected(Config::default());
    let (mut now, mut found) = (Now::ZERO, None);
    let mut asked = [None, None];
    while now < 60 * SECOND && found.is_none() {
        for (index, ticket) in asked.iter_mut().enumerate() {
            ticket.get_or_insert_with(|| ask(&mut line, now, index as u8 + 1, read()));
        }
        let back = now >= 20 * SECOND;
        let frame = sent(&mut line, now);
        now += MS;
        if let Some((to, payload)) = frame.filter(|(to, _)| *to == 1 || back) {
            reply(&mut line, now, to, &payload);
        }
        line.handle_timeout(now);
        while let Some((ticket, end)) = line.poll_outcome() {
            let index = usize::from(asked[1] == Some(ticket));
            asked[index] = None;
            if index == 1 && matches!(end, Outcome::Answered(_)) {
                found = Some(now);
            }
        }
        now += 19 * MS;
    }
    let found = found.expect("it answers") - 20 * SECOND;
    assert!(found < SECOND, "{found:?}");
}
