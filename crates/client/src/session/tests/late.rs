//! Late, lost and doubled answers: none is believed for an operation that it does not answer.

use std::collections::{BTreeMap, HashMap, HashSet};

use lafet_sim::rng::Rng;

use super::numbered::{Unknown, answer, outcome_of};
use super::*;

/// A session, a monitor, and a network that loses, delays and copies, but never beyond `bound`.
struct World {
    now: Now,
    session: Session,
    random: Rng,
    unknown: Unknown,
    bound: Duration,
    copies: bool,
    /// Answers under way, by arrival.
    air: BTreeMap<(Now, u64), Vec<u8>>,
    /// Which operation each frame belonged to.
    owner: Vec<Ticket>,
    /// Frames of an operation whose answers are not lost.
    answered_by: HashMap<Ticket, Vec<u32>>,
    cancelled: HashSet<Ticket>,
    seen: Seen,
}

#[derive(Debug, Default)]
struct Seen {
    submitted: u32,
    answered: u32,
    ended: u32,
    wrong: u32,
}

impl World {
    fn new(config: Config, unknown: Unknown, bound: Duration, seed: u64) -> Self {
        let copies = config.duplicates;
        let mut session = Session::new(Config { first_number: Some(seed as u32), ..config });
        session.handle_connected(Now::ZERO);
        Self {
            now: Now::ZERO,
            session,
            random: Rng::new(seed),
            unknown,
            bound,
            copies,
            air: BTreeMap::new(),
            owner: Vec::new(),
            answered_by: HashMap::new(),
            cancelled: HashSet::new(),
            seen: Seen::default(),
        }
    }

    fn run(&mut self, operations: u32) {
        while self.seen.ended < operations {
            if self.session.is_idle() || self.random.below(8) == 0 {
                self.submit();
            }
            self.step();
        }
    }

    fn submit(&mut self) {
        let requests = match self.random.below(12) {
            0..4 => vec![param(1)],
            4 => vec![param(2)],
            5 => vec![status_all()],
            6 | 7 => vec![moving()],
            8 => vec![stop()],
            9 => vec![param(1), param(2), moving()],
            10 => vec![stop(), status_all()],
            _ => vec![],
        };
        let Ok(ticket) = self.session.submit(self.now, requests) else { return };
        self.seen.submitted += 1;
        if self.random.below(50) == 0 {
            self.session.cancel(ticket);
            self.cancelled.insert(ticket);
            self.seen.ended += 1;
        }
    }

    /// Goes to the next thing that happens.
    fn step(&mut self) {
        while let Some(bytes) = self.session.poll_transmit(self.now) {
            self.send(&bytes);
        }
        self.check_outcomes();
        let arrival = self.air.first_key_value().map(|((time, _), _)| *time);
        let timeout = self.session.poll_timeout(self.now);
        let Some(next) = arrival.into_iter().chain(timeout).min() else { return };
        self.now = self.now.max(next);
        if arrival == Some(next)
            && let Some((_, bytes)) = self.air.pop_first()
        {
            self.session.handle_bytes(self.now, &bytes);
        }
        if self.random.below(5000) == 0 {
            self.session.handle_disconnected(self.now);
            self.now += MS;
            self.session.handle_connected(self.now);
        }
        self.session.handle_timeout(self.now);
        self.check_outcomes();
    }

    fn send(&mut self, bytes: &[u8]) {
        let ticket = self.session.outstanding.as_ref().map(|o| o.operation.ticket);
        let serial = self.owner.len() as u32;
        self.owner.push(ticket.expect("something is outstanding"));
        let reply = answer(&payload_of(bytes), serial, self.unknown);
        let copies = if self.random.below(12) == 0 { 0 } else { 1 };
        let more =
            if self.copies && self.random.below(6) == 0 { 1 + self.random.below(2) } else { 0 };
        for _ in 0..copies + more {
            let longest = match self.random.below(40) {
                0 => self.bound,
                1..4 => Duration::from_secs(2).min(self.bound),
                _ => 30 * MS,
            };
            let delay = Duration::from_micros(self.random.below(longest.as_micros() as u64));
            let key = (self.now + delay, self.random.bits());
            self.air.insert(key, frame(129, 1, &reply));
            self.answered_by.entry(self.owner[serial as usize]).or_default().push(serial);
        }
    }

    fn check_outcomes(&mut self) {
        while let Some((ticket, outcome)) = self.session.poll_outcome() {
            let frames = self.answered_by.remove(&ticket).unwrap_or_default();
            if self.cancelled.remove(&ticket) {
                continue;
            }
            self.seen.ended += 1;
            let Outcome::Answered(slots) = outcome else { continue };
            self.seen.answered += 1;
            // Nothing is believed that no frame of this operation was answered with.
            let mut right = !frames.is_empty();
            for slot in slots {
                let Slot::Answered(answers) = slot else { panic!("there is room") };
                for answer in answers {
                    right &= match number_in(&answer) {
                        Some(serial) => self.owner[serial as usize] == ticket,
                        None if answer.request() == RequestId::MOVE => frames
                            .iter()
                            .any(|serial| outcome_of(*serial) == (answer.from(), answer.status())),
                        None => true,
                    };
                }
            }
            self.seen.wrong += u32::from(!right);
        }
    }
}

/// The claim of `late_answers.rs`, on a medium that copies frames (UDP) and on one that does not.
#[test]
fn no_late_answer_is_believed() {
    for (duplicates, seed) in [(true, 1), (false, 2)] {
        believes_none(duplicates, seed, 260_000);
    }
}

/// The same for as long as is wanted: `cargo xtask late EXCHANGES`.
#[test]
#[ignore = "a long run: cargo xtask late"]
fn no_late_answer_is_believed_in_a_long_run() {
    let exchanges = std::env::var("LAFET_EXCHANGES").ok().and_then(|n| n.parse().ok());
    let exchanges: u32 = exchanges.unwrap_or(10_000_000);
    // New seeds from time to time: a run of its own each.
    const RUN: u32 = 500_000;
    let mut sum = Stats::default();
    let mut answered = 0;
    for run in 0..exchanges.div_ceil(RUN) {
        let operations = RUN.min(exchanges - run * RUN);
        let (seen, stats) = believes_none(run % 2 == 0, 1000 + u64::from(run), operations);
        sum = sum.and(stats);
        answered += seen.answered;
    }
    let Stats { frames_sent, believed, late, duplicates, unmatched, retries, .. } = sum;
    println!(
        "{exchanges} exchanges: {answered} answered, {frames_sent} frames, {retries} retries, \
         {believed} answers believed, 0 of them wrong; {late} late, {duplicates} doubled and \
         {unmatched} other answers not believed"
    );
}

fn believes_none(duplicates: bool, seed: u64, exchanges: u32) -> (Seen, Stats) {
    let config = Config { duplicates, ..Config::default() };
    let bound = config.late_bound;
    let mut world = World::new(config, Unknown::Answered, bound, seed);
    world.run(exchanges);
    let (seen, stats) = (world.seen, world.session.stats());
    assert_eq!(seen.wrong, 0, "seed {seed}: {seen:?} {stats:?}");
    assert!(seen.answered > seen.submitted * 7 / 10, "{seen:?}");
    assert!(stats.late > u64::from(exchanges) / 130, "{stats:?}");
    assert!(stats.retries > u64::from(exchanges) / 26, "{stats:?}");
    assert!(stats.duplicates > u64::from(exchanges) / 130, "{stats:?}");
    (seen, stats)
}

/// The same of a monitor that does not know §1's answer to a subsystem that does not exist, and
/// with tags switched off: what is in doubt waits.
#[test]
fn without_tags_what_is_in_doubt_waits() {
    let config = Config { duplicates: true, ..Config::default() };
    let off = Config { tags: false, ..config.clone() };
    let runs =
        [(config.clone(), Unknown::LeftOut), (config, Unknown::Refused), (off, Unknown::Answered)];
    for (seed, (config, unknown)) in runs.into_iter().enumerate() {
        let bound = config.drain_bound;
        let mut world = World::new(config, unknown, bound, 10 + seed as u64);
        world.run(20_000);
        let (seen, stats) = (&world.seen, world.session.stats());
        assert_eq!(seen.wrong, 0, "{seen:?} {stats:?}");
        assert!(seen.answered > seen.submitted / 2, "{seen:?}");
        assert!(stats.late > 0 && stats.duplicates > 0, "{stats:?}");
    }
}

/// The two tests above can fail: without tags and without waiting, wrong values are believed.
#[test]
fn the_check_finds_wrong_values() {
    let config = Config { tags: false, drain_bound: Duration::ZERO, ..Config::default() };
    let mut world = World::new(config, Unknown::Answered, Duration::from_secs(3), 3);
    world.run(5_000);
    assert!(world.seen.wrong > 10, "{:?}", world.seen);
}
