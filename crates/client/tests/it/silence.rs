//! Monitors that do not answer, or not always, on virtual time: which reads end, and when.

use std::time::Duration;

use crate::fake::{answer, encode};
use lafet_client::session::line::Line;
use lafet_client::session::{Config, Now, Outcome, Terms, Ticket};
use lafet_client::{RequestBuf, Role};
use lafet_proto::bus::CONTROLLER;
use lafet_proto::link::Decoder;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};

const MS: Duration = Duration::from_millis(1);
const SECOND: Duration = Duration::from_secs(1);
/// AccessGranted (observed).
const GRANT: [u8; 4] = [0xE6, 0xC2, 0, 0];
/// What the monitors never answer.
const MUTE: SubsystemId = SubsystemId::CONTROL;

fn status(of: SubsystemId) -> Vec<RequestBuf> {
    vec![RequestBuf::new(&Request::new(of, Body::GetStatus)).unwrap()]
}

/// A line with monitors; time passes as the line asks for it.
struct World {
    line: Line,
    now: Now,
    /// Who is there: a bit for each address.
    present: u64,
    /// From the end of a request to the answer.
    takes: Duration,
    /// Share of frames lost, each way, in thousandths.
    loss_permille: u64,
    /// So many frames of the next ones are lost.
    lost_next: u32,
    seed: u64,
    /// Whose turn to speak the controller announces, every 100 ms.
    granted: Option<u8>,
    answers: Vec<(Now, Vec<u8>)>,
    frames: Vec<u8>,
    ends: Vec<(Ticket, Outcome, Now)>,
}

impl World {
    fn new(present: &[u8], config: Config) -> Self {
        let mut line = Line::new(config);
        line.handle_connected(Now::ZERO);
        Self {
            line,
            now: Now::ZERO,
            present: present.iter().map(|address| 1 << address).sum(),
            takes: 5 * MS,
            loss_permille: 0,
            lost_next: 0,
            seed: 1,
            granted: None,
            answers: Vec::new(),
            frames: Vec::new(),
            ends: Vec::new(),
        }
    }

    fn loses(&mut self) -> bool {
        if self.lost_next > 0 {
            self.lost_next -= 1;
            return true;
        }
        self.seed = self.seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.seed >> 33) % 1000 < self.loss_permille
    }

    fn ask(&mut self, address: u8, of: SubsystemId) -> Ticket {
        self.line.submit(self.now, address, Terms::default(), status(of)).unwrap()
    }

    fn ask_many(&mut self, address: u8, count: usize) -> Vec<Ticket> {
        (0..count).map(|_| self.ask(address, SubsystemId::VERTICAL)).collect()
    }

    fn send(&mut self) {
        while let Some(bytes) = self.line.poll_transmit(self.now) {
            let mut decoder: Decoder = Decoder::new();
            let frame = decoder.push_slice(&bytes).1.expect("a frame");
            let (to, payload) = (frame.dst, frame.payload.to_vec());
            if to == CONTROLLER {
                continue;
            }
            self.frames.push(to);
            let lost = self.loses() || self.loses();
            let mute = payload.chunks(4).any(|record| record == status(MUTE)[0].bytes());
            if self.present & (1 << to) != 0 && !lost && !mute {
                self.answers.push((self.now + self.takes, encode(129, to, &answer(&payload))));
            }
        }
    }

    /// Does what is due, and lets the time pass until more is. What has been done must not be
    /// asked for again: a program that sleeps until then would not sleep at all.
    fn step(&mut self, until: Now) {
        self.line.handle_timeout(self.now);
        self.send();
        while let Some((ticket, end)) = self.line.poll_outcome() {
            self.ends.push((ticket, end, self.now));
        }
        let next = self.line.poll_timeout(self.now);
        assert!(next.is_none_or(|next| next > self.now), "{next:?} is not after {:?}", self.now);
        let answers = self.answers.iter().map(|(at, _)| *at).min();
        let tick = self.now.as_millis() / 100 + 1;
        let grant = self.granted.map(|_| Now::from_millis(tick as u64 * 100));
        let then = next.into_iter().chain(answers).chain(grant).chain([until]).min();
        self.now = then.unwrap_or(until);
        let now = self.now;
        let (due, later) = self.answers.drain(..).partition(|(at, _)| now >= *at);
        self.answers = later;
        let due: Vec<(Now, Vec<u8>)> = due;
        due.iter().for_each(|(_, bytes)| self.line.handle_bytes(now, bytes));
        if let Some(source) = self.granted.filter(|_| grant == Some(now)) {
            self.line.handle_bytes(now, &encode(source, CONTROLLER, &GRANT));
            // The transceiver turns round.
            self.now += MS;
        }
    }

    fn run(&mut self, until: Now) {
        while self.now < until {
            self.step(until);
        }
    }

    /// Runs until all of these have ended.
    fn end(&mut self, tickets: &[Ticket]) {
        let until = self.now + 300 * SECOND;
        let ended = |world: &Self| tickets.iter().all(|ticket| world.outcome(*ticket).is_some());
        while !ended(self) {
            assert!(self.now < until, "it does not end");
            self.step(until);
        }
    }

    fn outcome(&self, ticket: Ticket) -> Option<&Outcome> {
        self.ends.iter().find(|(known, ..)| *known == ticket).map(|(_, outcome, _)| outcome)
    }

    fn answered(&self, tickets: &[Ticket]) -> usize {
        let answered =
            |ticket: &&Ticket| matches!(self.outcome(**ticket), Some(Outcome::Answered(_)));
        tickets.iter().filter(answered).count()
    }

    /// Makes the line know that this monitor is silent.
    fn find_silent(&mut self, address: u8) {
        let reads = self.ask_many(address, 6);
        self.end(&reads);
        assert_eq!(self.answered(&reads), 0);
    }
}

/// The share of reads that end without an answer: of monitor 1 on a line that loses frames, six at
/// a time; `beside` others are polled that are off.
fn silent_share(beside: u8, loss_permille: u64, takes: Duration, mute: bool) -> f64 {
    let (mut reads, mut silent) = (0, 0);
    for seed in 0..400 {
        let mut world = World::new(&[1], Config::default());
        (world.seed, world.loss_permille, world.takes) = (seed * 977, loss_permille, takes);
        let off: Vec<_> = (2..2 + beside).flat_map(|other| world.ask_many(other, 2)).collect();
        if mute {
            world.ask(1, MUTE);
        }
        let asked = world.ask_many(1, 6);
        world.end(&[&asked[..], &off].concat());
        reads += asked.len();
        silent += asked.len() - world.answered(&asked);
    }
    silent as f64 / reads as f64
}

/// A read of a living monitor is without answer as often as all its own tries are lost, whatever
/// becomes of others.
#[test]
fn a_monitor_that_answers_now_and_then_is_not_silent() {
    for loss_permille in [100, 200, 300] {
        let passes = 1.0 - loss_permille as f64 / 1000.0;
        let own = (1.0 - passes * passes).powi(3);
        for (beside, takes, mute) in [
            (0, 5 * MS, false),
            (0, 5 * MS, true),
            (0, 850 * MS, false),
            (1, 5 * MS, false),
            (1, 5 * MS, true),
            (1, 850 * MS, false),
            (3, 5 * MS, false),
        ] {
            let share = silent_share(beside, loss_permille, takes, mute);
            println!(
                "{loss_permille} ‰ lost, {beside} others are off, an answer takes {takes:?}, \
                      mute: {mute}: {:.2} % of reads without answer, alone {:.2} %",
                share * 100.0,
                own * 100.0
            );
            // Three standard deviations of 2400 reads.
            let spare = 3.0 * (own * (1.0 - own) / 2400.0).sqrt();
            assert!(share <= own + spare, "{share} {own} {spare}");
        }
    }
}

/// A monitor that does not answer one kind of request is not silent: the others are asked, also
/// if it is the only one on its line that is there.
#[test]
fn a_request_without_answer_does_not_end_others() {
    for (others_off, lost_next) in [(false, 0), (true, 0), (false, 5), (true, 5)] {
        let mut world = World::new(&[1], Config::default());
        if others_off {
            let off = world.ask_many(2, 1);
            world.end(&off);
        }
        let mute = world.ask(1, MUTE);
        let others = world.ask_many(1, 5);
        // Those of the mute request, and two of the next.
        world.lost_next = lost_next;
        world.end(&[&[mute], &others[..]].concat());
        assert_eq!(world.answered(&others), 5, "{others_off} {lost_next}");
        assert_eq!(world.outcome(mute), Some(&Outcome::Silence { tries: 3, stray: None }));
    }
}

/// By radio two exchanges take nearly as long as two tries: those that wait have theirs.
#[test]
fn by_radio_reads_wait_for_their_turn() {
    let mut world = World::new(&[1], Config::default());
    world.takes = 850 * MS;
    let off = world.ask_many(2, 1);
    world.end(&off);
    let reads = world.ask_many(1, 8);
    world.lost_next = 2;
    world.end(&reads);
    assert_eq!(world.answered(&reads), 8);
}

/// Another connection may lead to another monitor: it starts without a past.
#[test]
fn a_new_connection_knows_of_no_silence() {
    let mut world = World::new(&[2], Config::default());
    world.find_silent(1);
    world.line.handle_disconnected(world.now);
    world.line.handle_connected(world.now);
    world.present |= 1 << 1;
    let reads = world.ask_many(1, 6);
    world.lost_next = 2;
    world.end(&reads);
    assert_eq!(world.answered(&reads), 6);
    // An absent one beside others has one try at a time; it is not absent any more.
    world.present = 1 << 2;
    for _ in 0..3 {
        let both = [world.ask(2, SubsystemId::VERTICAL), world.ask(1, SubsystemId::VERTICAL)];
        world.end(&both);
        assert_eq!(world.answered(&both), 1);
    }
    world.line.handle_disconnected(world.now);
    world.line.handle_connected(world.now);
    world.present |= 1 << 1;
    world.lost_next = 1;
    let read = world.ask_many(1, 1);
    world.end(&read);
    assert_eq!(world.answered(&read), 1);
}

/// Without a grant nothing is known of a monitor, whatever was known before.
#[test]
fn a_read_without_a_grant_is_not_without_answer() {
    for others in [&[][..], &[2]] {
        let config = Config { role: Role::Active, ..Config::default() };
        let mut world = World::new(others, config);
        world.granted = Some(129);
        for _ in 0..4 {
            let reads = [world.ask_many(2, 1), world.ask_many(1, 3)].concat();
            world.end(&reads);
            assert_eq!(world.answered(&reads), others.len());
        }
        // From now on another console has the word.
        world.granted = Some(130);
        world.run(world.now + SECOND);
        let (reads, from) = (world.ask_many(1, 3), world.now);
        world.end(&reads);
        for read in reads {
            assert_eq!(world.outcome(read), Some(&Outcome::NoGrant { controller: true }));
        }
        assert!(world.now >= from + 29 * SECOND, "{:?}", world.now - from);
    }
}

/// What is reported as sent was sent.
#[test]
fn an_outcome_counts_the_frames_of_its_request() {
    for others in [&[][..], &[2]] {
        let mut world = World::new(others, Config::default());
        let beside = world.ask_many(2, 1);
        let reads = world.ask_many(1, 40);
        world.end(&[&beside[..], &reads].concat());
        let tries = |read: &Ticket| match world.outcome(*read) {
            Some(Outcome::Silence { tries, .. }) => *tries,
            other => panic!("{other:?}"),
        };
        let counted: u32 = reads.iter().map(tries).sum();
        let frames = world.frames.iter().filter(|to| **to == 1).count();
        assert_eq!(counted as usize, frames, "{others:?}");
    }
}

/// More tries than are remembered: each request has all of its own.
#[test]
fn many_tries_are_all_made() {
    let mut world = World::new(&[], Config { tries: 40, ..Config::default() });
    let reads = world.ask_many(1, 4);
    world.end(&reads);
    assert_eq!(world.frames.len(), 4 * 40);
}

/// Reads of monitors of which none answers, as many at a time; how long they take at most while
/// that is found out, and after so long.
fn silent_reads(monitors: u8, reads: usize, found_out: Duration) -> (Duration, Duration) {
    let mut world = World::new(&[], Config::default());
    let (mut asked, mut first, mut later) = (Vec::new(), Duration::ZERO, Duration::ZERO);
    let mut ended = 0;
    while world.now < found_out + 60 * SECOND {
        for address in 1..=monitors {
            let waiting = |(_, of, _): &&(Ticket, u8, Now)| *of == address;
            for _ in asked.iter().filter(waiting).count()..reads {
                asked.push((world.ask(address, SubsystemId::VERTICAL), address, world.now));
            }
        }
        world.step(world.now + SECOND);
        for (ticket, end, at) in std::mem::take(&mut world.ends) {
            let index = asked.iter().position(|(known, ..)| *known == ticket).expect("asked");
            let since = asked.swap_remove(index).2;
            assert!(matches!(end, Outcome::Silence { .. }), "{end:?}");
            let took = if since < found_out { &mut first } else { &mut later };
            *took = (*took).max(at - since);
            ended += 1;
        }
    }
    assert!(ended >= reads * 12, "{monitors} × {reads}: {ended}");
    (first, later)
}

/// Where nothing answers, a read ends when three others had all their tries, and from then on within
/// the time of its own tries and one more, however many others wait.
#[test]
fn reads_of_silent_monitors_do_not_wait_for_each_other() {
    for (monitors, reads) in [(1, 1), (1, 6), (1, 40), (2, 1), (2, 6), (8, 1), (8, 6)] {
        // Nine frames to each show it.
        let found_out = 9 * SECOND * u32::from(monitors);
        let (first, later) = silent_reads(monitors, reads, found_out);
        println!("{monitors} monitors, {reads} reads: at first {first:?}, then {later:?}");
        assert!(first <= found_out + SECOND, "{monitors} × {reads}: {first:?}");
        let turns = 4 * SECOND * u32::from(monitors);
        assert!(later <= turns, "{monitors} × {reads}: {later:?}");
    }
}

/// A read that comes while others are not answered waits for as many answers as it has tries.
#[test]
fn a_read_behind_others_counts_the_frames_since_it_was_asked() {
    let mut world = World::new(&[], Config::default());
    let mut asked: Vec<_> = world.ask_many(1, 3).into_iter().map(|read| (read, 0)).collect();
    for at in [5500, 6000, 6100] {
        world.run(at * MS);
        asked.extend(world.ask_many(1, 1).into_iter().map(|read| (read, at)));
    }
    world.run(30 * SECOND);
    let since = |read| asked.iter().find(|(known, _)| *known == read).expect("asked").1;
    let ends: Vec<_> =
        world.ends.iter().map(|(read, _, at)| (since(*read), at.as_millis())).collect();
    // After nine frames the monitor is known to be silent. The last three of them were sent at 6, 7
    // and 8 s; those after 6 s have one more.
    assert_eq!(ends, [(0, 3000), (0, 6000), (0, 9000), (5500, 9000), (6000, 9000), (6100, 10_000)]);
}

/// Without tags a read waits until late answers are over; then it has all its tries.
#[test]
fn without_tags_a_silent_monitor_is_asked_again_when_late_answers_are_over() {
    let mut world = World::new(&[], Config { tags: false, ..Config::default() });
    let (mut frames, mut ends) = (Vec::new(), Vec::new());
    for _ in 0..2 {
        let read = world.ask_many(1, 1);
        while world.outcome(read[0]).is_none() {
            let before = world.frames.len();
            let at = world.now.as_secs();
            world.step(world.now + SECOND);
            frames.extend((before..world.frames.len()).map(|_| at));
        }
        ends.push(world.ends.last().unwrap().2.as_secs());
    }
    assert_eq!((frames, ends), (vec![0, 1, 2, 12, 13, 14], vec![3, 15]));
}
