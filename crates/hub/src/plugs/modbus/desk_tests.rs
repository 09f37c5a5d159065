//! The rules of the desk, each with what breaks it.

mod keys;

use std::time::Duration;

use lafet_client::Toward;

use super::desk::{Act, Around, Command, Desk, Stops, Terms, What};
use super::heart::SPAN;
use super::layout::{
    COMMAND, COMMAND_LEN, DETAIL_LEN, END, HEARTBEAT, JOG, JOG_LEN, JOG_RESULT, KEYS, NAME_LEN,
    RESULTS, SESSION, SUMMARY_LEN,
};
use super::pdu::Exception;
use super::refusal::{Failed, Refusal};
use super::sight::{Holder, Seen, Sight};
use crate::words::MotionWord;

const LIMIT: Duration = Duration::from_millis(150);
const BEAT: Duration = Duration::from_millis(50);
/// So many beats make a heartbeat alive.
const ALIVE: u16 = 11;
const TERMS: Terms = Terms { heartbeat: LIMIT, answer: Duration::from_secs(5), closes: true };

/// A session with two monitors.
struct Bench {
    desk: Desk,
    sight: Sight,
    now: Duration,
    beat: u16,
    sequence: u16,
    operates: bool,
    broadcast: bool,
    surplus: bool,
    random: u64,
}

impl Bench {
    fn new() -> Self {
        let one = Seen {
            holder: Holder::Mine,
            words: [7; SUMMARY_LEN],
            detail: [9; DETAIL_LEN],
            name: [0; NAME_LEN],
        };
        let mut random = 0;
        let next = &mut || {
            random += 0x0101;
            Some(random)
        };
        Self {
            desk: Desk::new(TERMS, 0x0001_0002, Duration::ZERO, next),
            sight: Sight { header: [1, 2, 3, 2, 0], monitors: vec![one; 2] },
            now: Duration::ZERO,
            beat: 0,
            sequence: 0,
            operates: true,
            broadcast: false,
            surplus: false,
            random,
        }
    }

    /// One whose heartbeat is alive.
    fn live() -> Self {
        let mut bench = Self::new();
        bench.beats(ALIVE);
        assert!(bench.desk.generation().is_some());
        bench
    }

    fn write(&mut self, first: u16, words: &[u16]) -> Result<Vec<Act>, Exception> {
        let random = &mut self.random;
        let mut next = || {
            *random += 0x0101;
            Some(*random)
        };
        let (operates, broadcast, surplus) = (self.operates, self.broadcast, self.surplus);
        let (now, sight) = (self.now, &self.sight);
        let mut around = Around { now, operates, broadcast, surplus, sight, random: &mut next };
        self.desk.write(&mut around, first, words)
    }

    fn beats(&mut self, count: u16) -> Vec<Act> {
        let mut acts = Vec::new();
        for _ in 0..count {
            self.now += BEAT;
            self.beat = self.beat.wrapping_add(1);
            acts.extend(self.write(HEARTBEAT, &[self.beat]).unwrap());
        }
        acts
    }

    fn read(&self, first: u16, count: u16) -> Vec<u16> {
        self.desk.read(true, &self.sight, first, count).unwrap()
    }

    fn block(&mut self, command: u16, monitor: u16, arguments: [u16; 4]) -> [u16; COMMAND_LEN] {
        self.sequence += 1;
        let [a, b, c, d] = arguments;
        let key = self.read(KEYS + 4 * monitor.saturating_sub(1).min(1), 4);
        let session = self.read(SESSION, 2);
        let head = [self.sequence, session[0], session[1], command, monitor];
        let tail = [a, b, c, d, key[0], key[1], key[2], key[3]];
        let mut words = head.into_iter().chain(tail);
        std::array::from_fn(|_| words.next().unwrap())
    }

    fn command(&mut self, command: Command, monitor: u16, arguments: [u16; 4]) -> Vec<Act> {
        let block = self.block(command.number(), monitor, arguments);
        self.write(COMMAND, &block).unwrap()
    }

    /// The refusal of the latest command; 0: none.
    fn refusal(&self) -> u16 {
        let result = self.read(RESULTS, 3);
        assert_eq!((result[0], result[1]), (self.sequence, if result[2] == 0 { 1 } else { 3 }));
        result[2]
    }

    fn jog(&mut self, directions: [i16; 3]) -> Vec<Act> {
        self.sequence += 1;
        let session = self.read(SESSION, 2);
        let [h, v, n] = directions.map(i16::cast_unsigned);
        let block: [u16; JOG_LEN] = [self.sequence, session[0], session[1], 1, h, v, n];
        self.write(JOG, &block).unwrap()
    }

    fn wait(&mut self, time: Duration) -> Vec<Act> {
        self.now += time;
        self.desk.tick(self.now, &mut || Some(99))
    }
}

fn what(acts: &[Act]) -> Option<What> {
    acts.iter().find_map(|act| match act {
        Act::Do { what, .. } => Some(*what),
        _ => None,
    })
}

fn ticket(acts: &[Act]) -> u32 {
    let of = |act: &Act| match act {
        Act::Do { ticket, .. } => Some(*ticket),
        _ => None,
    };
    acts.iter().find_map(of).expect("a command")
}

#[test]
fn blocks_are_written_whole_or_not_at_all() {
    let mut bench = Bench::live();
    let block = bench.block(7, 0, [0; 4]);
    for (first, len, why) in [
        (COMMAND, 12, Exception::Value),
        (COMMAND + 1, 12, Exception::Value),
        (JOG, 3, Exception::Value),
        (HEARTBEAT, 4, Exception::Value),
        (COMMAND + 3, 1, Exception::Value),
        (COMMAND, 14, Exception::Address),
        (0, 1, Exception::Address),
        (KEYS, 4, Exception::Address),
        (u16::MAX, 1, Exception::Address),
    ] {
        let words: Vec<u16> = block.iter().copied().cycle().take(len).collect();
        assert_eq!(bench.write(first, &words), Err(why), "{first} {len}");
    }
    assert_eq!(bench.read(RESULTS, 24), [0; 24], "nothing of it was taken");
    assert_eq!(what(&bench.write(COMMAND, &block).unwrap()), Some(What::Stop));
    assert_eq!(bench.desk.read(true, &bench.sight, END, 1), Err(Exception::Address));
    assert_eq!(bench.desk.read(true, &bench.sight, END - 1, 2), Err(Exception::Address));
    // All three blocks at once, as a PLC writes its image.
    let mut image = vec![bench.beat + 1];
    image.extend([0; JOG_LEN]);
    image.extend(bench.block(1, 1, [0; 4]));
    let acts = bench.write(HEARTBEAT, &image).unwrap();
    assert_eq!(what(&acts), Some(What::Authority(Command::Take)));
}

#[test]
fn every_command_is_answered_and_every_refusal_has_its_number() {
    let mut bench = Bench::live();
    let go = |bench: &mut Bench| bench.command(Command::GoTo, 1, [7, 100, 200, 30]);
    let acts = go(&mut bench);
    assert_eq!(what(&acts), Some(What::GoTo([Some(600), Some(1200), Some(30)])));
    assert_eq!(bench.refusal(), 0);
    go(&mut bench);
    assert_eq!(bench.refusal(), Refusal::Busy.number());
    bench.desk.answered(ticket(&acts), Err(Failed { why: Refusal::Refused, status: 0x10 }));
    assert_eq!(bench.read(RESULTS + 6, 6), [1, 3, Refusal::Refused.number(), 4, 1, 0x10]);
    for (command, monitor, arguments, why) in [
        (99, 1, [0; 4], Refusal::Command),
        (1, 3, [0; 4], Refusal::Monitor),
        (1, 0, [0; 4], Refusal::Monitor),
        (6, 0, [0; 4], Refusal::Monitor),
        (7, 9, [0; 4], Refusal::Monitor),
        (6, 1, [3, 0, 0, 0], Refusal::Argument),
        (4, 1, [0, 1, 1, 1], Refusal::Argument),
        (4, 1, [8, 1, 1, 1], Refusal::Argument),
        (4, 1, [1, 3601, 0, 0], Refusal::Argument),
        (4, 1, [2, 0, 1801, 0], Refusal::Argument),
        (4, 1, [4, 0, 0, 0xFFFF], Refusal::Argument),
        (5, 1, [3, 0, 0, 0], Refusal::Argument),
    ] {
        let block = bench.block(command, monitor, arguments);
        assert_eq!(what(&bench.write(COMMAND, &block).unwrap()), None);
        assert_eq!(bench.refusal(), why.number(), "{command} {monitor} {arguments:?}");
    }
    for (change, why) in [
        (
            (|bench: &mut Bench| bench.sight.monitors[0].holder = Holder::Other) as fn(&mut Bench),
            Refusal::Held,
        ),
        (|bench| bench.sight.monitors[0].holder = Holder::Free, Refusal::NotTaken),
        (|bench| bench.operates = false, Refusal::Role),
        (|bench| _ = bench.wait(LIMIT), Refusal::Heartbeat),
    ] {
        let mut bench = Bench::live();
        change(&mut bench);
        for (command, first) in [(Command::GoTo, 1), (Command::Open, 1), (Command::Deploy, 0)] {
            assert_eq!(what(&bench.command(command, 1, [first, 0, 0, 0])), None);
            assert_eq!(bench.refusal(), why.number());
        }
    }
    let mut block = bench.block(1, 1, [0; 4]);
    block[2] ^= 1;
    bench.write(COMMAND, &block).unwrap();
    assert_eq!(bench.refusal(), Refusal::Session.number());
    block[3] = 2;
    bench.write(COMMAND, &block).unwrap();
    assert_eq!(bench.refusal(), Refusal::Sequence.number());
}

#[test]
fn a_command_without_a_result_times_out_and_its_late_result_changes_nothing() {
    let mut bench = Bench::live();
    let acts = bench.command(Command::Take, 1, [0; 4]);
    bench.wait(TERMS.answer);
    assert_eq!(bench.read(RESULTS, 3), [1, 4, Refusal::Late.number()]);
    bench.desk.answered(ticket(&acts), Ok(()));
    assert_eq!(bench.read(RESULTS, 2), [1, 4]);
    bench.beats(ALIVE);
    bench.command(Command::Take, 1, [0; 4]);
    assert_eq!(bench.refusal(), 0, "the next one is taken");
}

#[test]
fn an_image_that_is_written_again_and_again_is_one_command_and_a_stop_is_each_time_one() {
    let mut bench = Bench::live();
    let block = bench.block(4, 1, [1, 10, 0, 0]);
    assert!(what(&bench.write(COMMAND, &block).unwrap()).is_some());
    for _ in 0..10 {
        bench.beats(1);
        assert_eq!(bench.write(COMMAND, &block).unwrap(), []);
    }
    let stop = bench.block(7, 1, [0; 4]);
    for _ in 0..10 {
        assert_eq!(what(&bench.write(COMMAND, &stop).unwrap()), Some(What::Stop));
    }
    let results = bench.read(RESULTS, 12);
    assert_eq!((results[0], results[6]), (2, 1), "its result is one entry");
    // The number of a command before it makes no difference to a Stop.
    let mut again = stop;
    again[4] = 2;
    assert_eq!(what(&bench.write(COMMAND, &again).unwrap()), Some(What::Stop));
}

#[test]
fn stop_close_and_lockout_need_nothing() {
    let mut bench = Bench::new();
    bench.operates = false;
    bench.sight.monitors[0].holder = Holder::Other;
    for (command, monitor, wanted) in
        [(7, 1, What::Stop), (7, 0, What::Stop), (6, 1, What::Close(0)), (8, 1, What::Lockout)]
    {
        let mut block = [0; COMMAND_LEN];
        (block[0], block[3], block[4]) = (command, command, monitor);
        assert_eq!(what(&bench.write(COMMAND, &block).unwrap()), Some(wanted));
    }
    // While so many wait for their results that there is room for none, too.
    for sequence in 100..200 {
        let mut block = [0; COMMAND_LEN];
        (block[0], block[3], block[4]) = (sequence, 7, 1);
        assert_eq!(what(&bench.write(COMMAND, &block).unwrap()), Some(What::Stop));
    }
    assert_eq!(bench.read(RESULTS, 1), [199]);
}

#[test]
fn a_broadcast_stops_and_closes_and_does_nothing_else() {
    let mut bench = Bench::live();
    bench.broadcast = true;
    for command in Command::ALL {
        let acts = bench.command(command, 1, [1, 0, 0, 0]);
        let wanted = matches!(command, Command::Stop | Command::Close);
        assert_eq!(what(&acts).is_some(), wanted, "{command:?}");
    }
    let before = bench.read(HEARTBEAT, 8);
    assert_eq!(bench.jog([1, 0, 0]), []);
    bench.now += BEAT;
    assert_eq!(bench.write(HEARTBEAT, &[77]), Ok(vec![]));
    assert_eq!(bench.read(HEARTBEAT, 8), before);
}

#[test]
fn a_heartbeat_lives_by_changes_in_time() {
    let mut bench = Bench::new();
    assert_eq!(bench.desk.timeout(), None);
    bench.beats(1);
    assert_eq!(bench.desk.generation(), None, "one value says nothing");
    assert_eq!(bench.beats(ALIVE - 2), [], "nor do some");
    assert_eq!(bench.beats(1), [Act::Back]);
    bench.now += BEAT;
    assert_eq!(bench.write(HEARTBEAT, &[bench.beat]), Ok(vec![]), "the same value is no beat");
    assert_eq!(bench.desk.timeout(), Some(u32::from(ALIVE) * BEAT + LIMIT));
    assert_eq!(bench.wait(LIMIT - BEAT), [Act::Lost]);
    assert_eq!(bench.wait(Duration::from_secs(3600)), []);
    assert_eq!(bench.beats(ALIVE - 1), [], "it counts from the beginning");
    assert_eq!(bench.beats(1), [Act::Back]);
    assert_eq!(bench.read(SESSION + 3, 3), [1, 150, 1]);
    // Beats that come all at once after a pause are late.
    bench.now += 2 * LIMIT;
    bench.beat += 1;
    assert_eq!(bench.write(HEARTBEAT, &[bench.beat]), Ok(vec![Act::Lost]));
    assert_eq!(bench.desk.generation(), None);
}

#[test]
fn keys_change_with_each_use_each_loss_and_each_session() {
    let mut bench = Bench::live();
    let keys = |bench: &Bench| bench.read(KEYS, 8);
    let first = keys(&bench);
    assert_ne!(first[..4], first[4..], "each monitor has its own");
    let acts = bench.command(Command::Open, 1, [1, 0, 0, 0]);
    assert_eq!(what(&acts), Some(What::Open(1)));
    let second = keys(&bench);
    assert!(second[..4] != first[..4] && second[4..] == first[4..]);
    bench.desk.answered(ticket(&acts), Ok(()));
    // The key of the other monitor, or none: both are tries, and change the key.
    for wrong in [&first[4..], &[0; 4]] {
        let mut block = bench.block(5, 1, [1, 0, 0, 0]);
        block[9..].copy_from_slice(wrong);
        let refused = Act::Refused { monitor: 0, valve: 1, why: Refusal::Key };
        assert_eq!(bench.write(COMMAND, &block), Ok(vec![refused]));
        assert_eq!(bench.refusal(), Refusal::Key.number());
    }
    let third = keys(&bench);
    assert_ne!(third[..4], second[..4]);
    bench.wait(LIMIT);
    let fourth = keys(&bench);
    assert!(third[..4] != fourth[..4] && third[4..] != fourth[4..]);
}

#[test]
fn without_random_numbers_nothing_opens() {
    let mut bench = Bench::live();
    bench.desk = Desk::new(TERMS, 0x0001_0002, bench.now, &mut || None);
    bench.beats(ALIVE);
    assert_eq!(bench.read(KEYS, 4), [0; 4]);
    assert_eq!(what(&bench.command(Command::Open, 1, [1, 0, 0, 0])), None);
    assert_eq!(bench.refusal(), Refusal::Key.number());
}

#[test]
fn a_session_without_a_number_stops_and_closes_only() {
    let mut bench = Bench::live();
    bench.desk = Desk::new(TERMS, 0, bench.now, &mut || None);
    bench.beats(ALIVE);
    assert_eq!(what(&bench.command(Command::Deploy, 1, [0; 4])), None);
    assert_eq!(bench.refusal(), Refusal::Session.number());
    assert_eq!(bench.jog([1, 0, 0]), []);
    assert_eq!(bench.read(JOG_RESULT, 3)[2], Refusal::Session.number());
    assert_eq!(what(&bench.command(Command::Stop, 1, [0; 4])), Some(What::Stop));
    assert_eq!(what(&bench.command(Command::Close, 1, [0; 4])), Some(What::Close(0)));
}

#[test]
fn drives_are_held_by_the_heartbeat_and_end_with_it() {
    let mut bench = Bench::live();
    assert_eq!(bench.jog([1, -1, 0]), []);
    let max = Act::Beat { monitor: 0, axis: 0, toward: Toward::Max };
    let min = Act::Beat { monitor: 0, axis: 1, toward: Toward::Min };
    assert_eq!(bench.beats(1), [max, min]);
    bench.desk.jogged(0, 0, Ok(MotionWord::Moving));
    bench.desk.jogged(0, 1, Ok(MotionWord::Armed));
    assert_eq!(bench.read(JOG_RESULT, 7), [1, 2, 0, 1, 2, 1, 0]);
    let release = |axis| Act::Release { monitor: 0, axis };
    assert_eq!(bench.wait(LIMIT), [release(0), release(1), Act::Lost]);
    assert_eq!(bench.read(JOG_RESULT, 7), [1, 4, Refusal::Heartbeat.number(), 1, 4, 4, 0]);
    assert_eq!(bench.beats(ALIVE + 2), [Act::Back], "it does not start again by itself");
    bench.jog([1, 0, 0]);
    assert_eq!(bench.beats(1), [max]);
    bench.desk.jogged(0, 0, Err(Refusal::Held.into()));
    assert_eq!(bench.beats(1), [], "the authority is lost, and the heartbeat counts");
    assert_eq!(bench.read(JOG_RESULT + 1, 2), [3, Refusal::Held.number()]);
    bench.jog([0, 0, 1]);
    assert_eq!(bench.jog([0, 0, 0]), [release(2)], "released");
    bench.jog([0, 1, 0]);
    let acts = bench.command(Command::Stop, 1, [0; 4]);
    assert_eq!(acts[0], release(1), "Stop of one's own ends it");
    assert_eq!(bench.beats(1), []);
}

#[test]
fn motions_by_hand_are_refused_like_commands() {
    for (directions, change, why) in [
        ([2, 0, 0], (|_| {}) as fn(&mut Bench), Refusal::Argument),
        ([1, 0, 0], |bench| bench.operates = false, Refusal::Role),
        ([1, 0, 0], |bench| _ = bench.wait(LIMIT), Refusal::Heartbeat),
        ([1, 0, 0], |bench| bench.sight.monitors[0].holder = Holder::Other, Refusal::Held),
        ([1, 0, 0], |bench| bench.sight.monitors.clear(), Refusal::Monitor),
    ] {
        let mut bench = Bench::live();
        change(&mut bench);
        bench.jog(directions);
        assert_eq!(bench.read(JOG_RESULT + 1, 2), [3, why.number()]);
        let beats = bench.beats(3);
        assert!(!beats.iter().any(|act| matches!(act, Act::Beat { .. })), "{beats:?}");
    }
}

#[test]
fn what_a_lost_master_has_sent_and_opened_ends() {
    let mut bench = Bench::live();
    let acts = bench.command(Command::GoTo, 1, [3, 10, 10, 0]);
    bench.desk.answered(ticket(&acts), Ok(()));
    let acts = bench.command(Command::Open, 2, [2, 0, 0, 0]);
    let own = bench.desk.generation();
    bench.desk.answered(ticket(&acts), Ok(()));
    let halt = |axis| Act::Halt { monitor: 0, axis };
    let shut = Act::Shut { monitor: 1, valve: 2 };
    assert_eq!(bench.wait(LIMIT), [halt(0), halt(1), shut, Act::Lost]);
    assert_eq!(bench.wait(LIMIT), []);
    bench.beats(ALIVE);
    assert_ne!(bench.desk.generation(), own, "what waits to be sent is void");
    // What was not done, was closed or is the hand's is left alone.
    let acts = bench.command(Command::Open, 2, [1, 0, 0, 0]);
    bench.desk.answered(ticket(&acts), Err(Refusal::Void.into()));
    let acts = bench.command(Command::Open, 2, [2, 0, 0, 0]);
    bench.desk.answered(ticket(&acts), Ok(()));
    let acts = bench.command(Command::Close, 2, [2, 0, 0, 0]);
    bench.desk.answered(ticket(&acts), Ok(()));
    let acts = bench.command(Command::GoTo, 1, [1, 10, 0, 0]);
    bench.desk.answered(ticket(&acts), Ok(()));
    bench.jog([1, 0, 0]);
    bench.desk.jogged(0, 0, Ok(MotionWord::Moving));
    bench.jog([0, 0, 0]);
    assert_eq!(bench.wait(LIMIT), [Act::Lost]);
}

/// A second opening of the same valve that was refused leaves the first one in force.
#[test]
fn a_refused_opening_does_not_forget_the_one_before() {
    let mut bench = Bench::live();
    for result in [Ok(()), Err(Refusal::Refused.into())] {
        let acts = bench.command(Command::Open, 2, [2, 0, 0, 0]);
        bench.desk.answered(ticket(&acts), result);
    }
    assert_eq!(bench.wait(LIMIT), [Act::Shut { monitor: 1, valve: 2 }, Act::Lost]);
}

/// A hand that has asked for a drive and does not move it yet has not ended what the drive was sent to; nor
/// has a Stop that has not arrived.
#[test]
fn a_drive_on_its_way_stops_whatever_was_asked_for_since() {
    let halt = Act::Halt { monitor: 0, axis: 0 };
    let mut bench = Bench::live();
    let acts = bench.command(Command::GoTo, 1, [1, 10, 0, 0]);
    bench.desk.answered(ticket(&acts), Ok(()));
    bench.jog([1, 0, 0]);
    assert_eq!(bench.wait(LIMIT), [Act::Release { monitor: 0, axis: 0 }, halt, Act::Lost]);
    for arrives in [false, true] {
        let mut bench = Bench::live();
        let acts = bench.command(Command::GoTo, 1, [1, 10, 0, 0]);
        bench.desk.answered(ticket(&acts), Ok(()));
        let acts = bench.command(Command::Stop, 1, [0; 4]);
        if arrives {
            bench.desk.answered(ticket(&acts), Ok(()));
        }
        assert_eq!(bench.wait(LIMIT).contains(&halt), !arrives);
    }
}

#[test]
fn a_release_in_the_write_of_a_beat_is_not_moved_once_more() {
    let mut bench = Bench::live();
    bench.jog([1, 0, 0]);
    bench.beats(1);
    bench.now += BEAT;
    bench.sequence += 1;
    let session = bench.read(SESSION, 2);
    let released = [bench.beat + 1, bench.sequence, session[0], session[1], 1, 0, 0, 0];
    let acts = bench.write(HEARTBEAT, &released).unwrap();
    assert_eq!(acts, [Act::Release { monitor: 0, axis: 0 }]);
}

#[test]
fn changes_that_come_all_at_once_are_no_heartbeat() {
    let mut bench = Bench::new();
    bench.now = Duration::from_secs(9);
    for beat in 1..50 {
        assert_eq!(bench.write(HEARTBEAT, &[beat]), Ok(vec![]));
    }
    assert_eq!(bench.desk.generation(), None);
    // A master that is quick is alive all the same.
    for beat in 50..150 {
        assert_eq!(bench.desk.generation(), None, "{beat}");
        bench.now += SPAN / 100;
        bench.write(HEARTBEAT, &[beat]).unwrap();
    }
    assert!(bench.desk.generation().is_some());
}

#[test]
fn an_older_number_is_no_new_command() {
    let mut bench = Bench::live();
    let first = bench.block(1, 1, [0; 4]);
    let acts = bench.write(COMMAND, &first).unwrap();
    bench.desk.answered(ticket(&acts), Ok(()));
    let acts = bench.command(Command::GoTo, 1, [1, 10, 0, 0]);
    bench.desk.answered(ticket(&acts), Ok(()));
    assert_eq!(what(&bench.write(COMMAND, &first).unwrap()), None);
    assert_eq!(bench.read(RESULTS, 3), [1, 3, Refusal::Sequence.number()]);
    bench.jog([1, 0, 0]);
    bench.jog([0, 0, 0]);
    bench.sequence -= 2;
    bench.jog([1, 0, 0]);
    assert_eq!(bench.read(JOG_RESULT + 1, 2), [3, Refusal::Sequence.number()]);
}

#[test]
fn a_stop_that_is_written_again_and_again_has_its_result() {
    let mut bench = Bench::live();
    let stop = bench.block(7, 1, [0; 4]);
    let first = ticket(&bench.write(COMMAND, &stop).unwrap());
    assert_eq!(ticket(&bench.write(COMMAND, &stop).unwrap()), first);
    bench.desk.answered(first, Ok(()));
    assert_eq!(bench.read(RESULTS, 2), [1, 2]);
    assert_eq!(what(&bench.write(COMMAND, &stop).unwrap()), Some(What::Stop));
    assert_eq!(bench.read(RESULTS, 2), [1, 2], "it stays done");
    // Releasing waits for nothing.
    bench.command(Command::GoTo, 1, [1, 10, 0, 0]);
    let acts = bench.command(Command::Release, 1, [0; 4]);
    assert_eq!(what(&acts), Some(What::Authority(Command::Release)));
}

#[test]
fn stop_makes_void_what_was_asked_for_before_it() {
    let mut bench = Bench::live();
    bench.command(Command::GoTo, 1, [1, 10, 0, 0]);
    let before = bench.desk.generation();
    bench.command(Command::Stop, 1, [0; 4]);
    assert!(bench.desk.generation().is_some() && bench.desk.generation() != before);
}

/// Nothing here has a date: the times are those since any moment, and no more than their differences count.
#[test]
fn the_beginning_of_time_makes_no_difference() {
    let run = |start: Duration| {
        let mut bench = Bench::new();
        bench.now = start;
        bench.desk = Desk::new(TERMS, 0x0001_0002, start, &mut || Some(5));
        let mut acts = bench.beats(ALIVE);
        acts.extend(bench.jog([1, 0, 0]));
        acts.extend(bench.beats(2));
        acts.extend(bench.wait(LIMIT));
        acts
    };
    let acts = run(Duration::ZERO);
    assert!(acts.contains(&Act::Lost) && acts.len() > 4);
    assert_eq!(acts, run(Duration::from_secs(1 << 40)));
}

/// Stopped from elsewhere while an opening is on its way.
#[test]
fn an_opening_from_before_a_stop_has_an_old_key() {
    let mut bench = Bench::live();
    let block = bench.block(Command::Open.number(), 1, [1, 0, 0, 0]);
    let other = bench.read(KEYS + 4, 4);
    let mut next = || Some(77);
    bench.desk.stopped(&[NONE, NONE], &mut next);
    assert_eq!(bench.read(KEYS, 4), block[9..], "nothing was stopped");
    bench.desk.stopped(&[CLOSED, NONE], &mut next);
    assert_eq!(what(&bench.write(COMMAND, &block).unwrap()), None);
    assert_eq!(bench.refusal(), Refusal::Key.number());
    assert_eq!(bench.read(KEYS + 4, 4), other, "the other monitor was not stopped");
    let acts = bench.command(Command::Open, 1, [1, 0, 0, 0]);
    assert_eq!(what(&acts), Some(What::Open(1)));
}

const NONE: Stops = Stops { all: 0, motion: 0 };
const CLOSED: Stops = Stops { all: 1, motion: 0 };
const STOPPED: Stops = Stops { all: 2, motion: 1 };

/// The state and the refusal of the latest result.
fn latest(bench: &Bench) -> (u16, u16) {
    let result = bench.read(RESULTS, 3);
    (result[1], result[2])
}

/// A panel writes a constant block: without a number, a session, a heartbeat.
#[test]
fn a_stop_that_is_pressed_again_is_not_done_before_it_is_confirmed() {
    let mut panel = [0; COMMAND_LEN];
    (panel[3], panel[4]) = (7, 1);
    for (released, pause) in [(true, Duration::ZERO), (false, Duration::from_secs(3600))] {
        let mut bench = Bench::new();
        let first = ticket(&bench.write(COMMAND, &panel).unwrap());
        bench.desk.answered(first, Ok(()));
        assert_eq!(latest(&bench), (2, 0));
        if released {
            bench.write(COMMAND, &[0; COMMAND_LEN]).unwrap();
        }
        bench.wait(pause);
        let second = ticket(&bench.write(COMMAND, &panel).unwrap());
        assert_eq!(latest(&bench), (1, 0), "no monitor has confirmed this one");
        bench.desk.answered(first, Ok(()));
        assert_eq!(latest(&bench), (1, 0), "the result of the first one is not its own");
        bench.desk.answered(second, Err(Refusal::NoAnswer.into()));
        assert_eq!(latest(&bench), (3, Refusal::NoAnswer.number()));
    }
}

#[test]
fn a_held_stop_whose_repetition_fails_is_not_done_any_more() {
    for (result, wanted) in [
        (Some(Ok(())), (2, 0)),
        (Some(Err(Refusal::NotSent.into())), (3, Refusal::NotSent.number())),
        (None, (4, Refusal::Late.number())),
    ] {
        let mut bench = Bench::live();
        let stop = bench.block(7, 1, [0; 4]);
        let first = ticket(&bench.write(COMMAND, &stop).unwrap());
        bench.desk.answered(first, Ok(()));
        let again = ticket(&bench.write(COMMAND, &stop).unwrap());
        assert_ne!(again, first);
        assert_eq!(ticket(&bench.write(COMMAND, &stop).unwrap()), again, "one at most");
        assert_eq!(latest(&bench), (2, 0));
        match result {
            Some(result) => bench.desk.answered(again, result),
            None => drop(bench.wait(TERMS.answer)),
        }
        assert_eq!(latest(&bench), wanted);
        assert_eq!(bench.read(RESULTS + 6, 2), [0, 0], "it is one entry");
    }
}

#[test]
fn the_late_result_of_a_stop_or_close_forgets_nothing_newer() {
    let mut bench = Bench::live();
    let stop = ticket(&bench.command(Command::Stop, 1, [0; 4]));
    let close = ticket(&bench.command(Command::Close, 1, [0; 4]));
    let goto = ticket(&bench.command(Command::GoTo, 1, [1, 10, 0, 0]));
    bench.desk.answered(goto, Ok(()));
    let open = ticket(&bench.command(Command::Open, 1, [1, 0, 0, 0]));
    bench.desk.answered(open, Ok(()));
    bench.desk.answered(stop, Ok(()));
    bench.desk.answered(close, Ok(()));
    let (halt, shut) = (Act::Halt { monitor: 0, axis: 0 }, Act::Shut { monitor: 0, valve: 1 });
    assert_eq!(bench.wait(LIMIT), [halt, shut, Act::Lost]);
}

/// An opening that is reported refused after the valve was closed is not open again.
#[test]
fn a_refused_opening_opens_nothing_that_was_closed_meanwhile() {
    let mut bench = Bench::live();
    let first = ticket(&bench.command(Command::Open, 1, [1, 0, 0, 0]));
    bench.desk.answered(first, Ok(()));
    let second = ticket(&bench.command(Command::Open, 1, [1, 0, 0, 0]));
    let close = ticket(&bench.command(Command::Close, 1, [0; 4]));
    bench.desk.answered(close, Ok(()));
    bench.desk.answered(second, Err(Refusal::Void.into()));
    assert_eq!(bench.wait(LIMIT), [Act::Lost]);
}

#[test]
fn a_motion_that_was_asked_for_before_a_stop_of_others_does_not_begin() {
    let release = Act::Release { monitor: 0, axis: 0 };
    for (counts, ends) in [([STOPPED, NONE], true), ([CLOSED, STOPPED], false)] {
        let mut bench = Bench::live();
        bench.jog([1, 0, 0]);
        let acts = bench.desk.stopped(&counts, &mut || Some(5));
        assert_eq!(acts.contains(&release), ends);
        let beats = bench.beats(3);
        assert_eq!(beats.iter().any(|it| matches!(it, Act::Beat { .. })), !ends);
        if ends {
            assert_eq!(bench.read(JOG_RESULT + 1, 2), [4, Refusal::Ended.number()]);
            bench.jog([1, 0, 0]);
            assert!(!bench.beats(1).is_empty(), "asked for after it, it begins");
        }
    }
    // What moves is ended by its monitor, which knows what stops it.
    let mut bench = Bench::live();
    bench.jog([1, 0, 0]);
    bench.beats(1);
    bench.desk.jogged(0, 0, Ok(MotionWord::Moving));
    assert_eq!(bench.desk.stopped(&[STOPPED, NONE], &mut || Some(5)), []);
}

/// A network holds frames up, and delivers them when another has stopped the monitor.
#[test]
fn what_was_written_before_a_loss_is_refused_after_it() {
    let mut bench = Bench::live();
    let before = bench.read(SESSION, 2);
    let held_up = bench.block(4, 1, [1, 10, 0, 0]);
    assert_eq!(bench.wait(Duration::from_secs(5)), [Act::Lost]);
    assert_ne!(bench.read(SESSION, 2), before);
    // All that was held up, within 50 ms.
    for beat in 1000..1010 {
        bench.now += Duration::from_millis(5);
        assert_eq!(bench.write(HEARTBEAT, &[beat]), Ok(vec![]), "no sign of life");
    }
    bench.write(COMMAND, &held_up).unwrap();
    assert_eq!(latest(&bench), (3, Refusal::Session.number()));
    bench.beats(ALIVE);
    let mut later = held_up;
    later[0] += 1;
    assert_eq!(what(&bench.write(COMMAND, &later).unwrap()), None);
    assert_eq!(latest(&bench), (3, Refusal::Session.number()));
    bench.sequence += 1;
    assert!(what(&bench.command(Command::GoTo, 1, [1, 10, 0, 0])).is_some());
    // Each loss has another number, and without random numbers there is none.
    let second = bench.read(SESSION, 2);
    bench.now += LIMIT;
    bench.desk.tick(bench.now, &mut || Some(99));
    assert_ne!(bench.read(SESSION, 2), second);
    bench.beats(ALIVE);
    bench.now += LIMIT;
    bench.desk.tick(bench.now, &mut || None);
    assert_eq!(bench.read(SESSION, 2), [0, 0]);
}

#[test]
fn what_is_too_much_stops_and_closes_and_is_no_sign_of_life() {
    let mut bench = Bench::live();
    bench.surplus = true;
    for command in Command::ALL {
        let acts = bench.command(command, 1, [1, 0, 0, 0]);
        assert_eq!(what(&acts).is_some(), command.is_urgent(), "{command:?}");
    }
    assert_eq!(bench.jog([1, 0, 0]), []);
    let acts = bench.beats(3);
    assert_eq!(acts, [Act::Lost], "beats that are too many keep nothing alive");
}

#[test]
fn what_was_never_alive_loses_nothing() {
    let mut bench = Bench::new();
    bench.beats(2);
    assert_eq!(bench.desk.end(&mut || Some(9)), []);
    let mut bench = Bench::live();
    assert_eq!(bench.desk.end(&mut || Some(9)), [Act::Lost]);
    assert_eq!(bench.desk.end(&mut || Some(9)), [], "once");
}
