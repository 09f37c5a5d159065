//! What is urgent for a monitor that is off, on a line whose other monitors answer, on virtual time.

use std::time::Duration;

use crate::fake::{answer, encode};
use lafet_client::RequestBuf;
use lafet_client::session::line::Line;
use lafet_client::session::{Config, Now, Outcome, Terms, Ticket};
use lafet_proto::link::Decoder;
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, SubsystemId};

const MS: Duration = Duration::from_millis(1);
const SECOND: Duration = Duration::from_secs(1);
/// As on a serial line.
const TURNAROUND: Duration = MS;
/// Each monitor is polled five times a second.
const PERIOD: Duration = Duration::from_millis(200);
/// By then it is known which monitors are there.
const KNOWN: Now = Duration::from_secs(10);
const PRESENT: [u8; 2] = [1, 2];
const SILENT: u8 = 3;
/// How long an answer takes: over USB, at 19,200 baud, and on a line that is nearly full.
const ANSWERS: [Duration; 3] = [MS.saturating_mul(2), MS.saturating_mul(15), MS.saturating_mul(60)];
/// What a client presses in turn.
const STOPPED: [SubsystemId; 4] =
    [SubsystemId::ALL, SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE];

/// What one monitor is asked again and again, as soon as the last question has ended.
struct Poll {
    address: u8,
    every: Duration,
    /// Longest wait, where it keeps a motion going.
    life: Option<Duration>,
    due: Now,
    asked: Option<(Ticket, Now)>,
    /// When it was answered.
    answered: Vec<Now>,
    longest: Duration,
    expired: u32,
}

struct World {
    line: Line,
    now: Now,
    takes: Duration,
    /// Monitors that answer, and for how long their answers take if not as usual.
    present: Vec<u8>,
    slow: Option<(u8, Duration)>,
    coming: Vec<(Now, u8, Vec<u8>)>,
    polls: Vec<Poll>,
    sent: Vec<(Now, u8, Vec<u8>)>,
    ends: Vec<(Now, Ticket, Outcome)>,
    heard: Now,
    /// Frames that were sent while an answer was on its way, or without a pause after it.
    collided: u32,
}

impl World {
    /// Monitors of which some are present, polled until it is known which.
    fn new(takes: Duration, present: &[u8], polled: impl IntoIterator<Item = u8>) -> Self {
        let mut world = Self::empty(takes, present);
        polled.into_iter().for_each(|address| world.poll(address, PERIOD, None));
        world.run(KNOWN);
        world
    }

    fn empty(takes: Duration, present: &[u8]) -> Self {
        let mut line = Line::new(Config { turnaround: TURNAROUND, ..Config::default() });
        line.handle_connected(Now::ZERO);
        Self {
            line,
            now: Now::ZERO,
            takes,
            present: present.to_vec(),
            slow: None,
            coming: Vec::new(),
            polls: Vec::new(),
            sent: Vec::new(),
            ends: Vec::new(),
            heard: Now::ZERO,
            collided: 0,
        }
    }

    fn three(takes: Duration) -> Self {
        Self::new(takes, &PRESENT, [1, 2, SILENT])
    }

    fn poll(&mut self, address: u8, every: Duration, life: Option<Duration>) {
        let (due, asked, answered) = (self.now, None, Vec::new());
        let (longest, expired) = (Duration::ZERO, 0);
        self.polls.push(Poll { address, every, life, due, asked, answered, longest, expired });
    }

    fn stop(&mut self, address: u8, what: SubsystemId) -> Ticket {
        let request = RequestBuf::new(&Request::new(what, Body::Stop)).unwrap();
        self.line.submit(self.now, address, Terms::default(), vec![request]).unwrap()
    }

    /// Until a time: wakes when something is due, and no earlier.
    fn run(&mut self, until: Now) {
        loop {
            self.ask();
            while let Some(bytes) = self.line.poll_transmit(self.now) {
                self.on_the_wire(&bytes);
            }
            self.take_ends();
            let polls = self.polls.iter().filter(|poll| poll.asked.is_none()).map(|poll| poll.due);
            let answers = self.coming.iter().map(|(at, ..)| *at);
            let next = polls.chain(answers).chain(self.line.poll_timeout(self.now)).min();
            if self.now >= until {
                return;
            }
            self.now = next.unwrap_or(until).clamp(self.now + MS / 10, until);
            let due: Vec<_> = self.coming.extract_if(.., |(at, ..)| *at <= self.now).collect();
            for (_, from, payload) in due {
                self.heard = self.now;
                self.line.handle_bytes(self.now, &encode(129, from, &answer(&payload)));
            }
            self.line.handle_timeout(self.now);
            self.take_ends();
        }
    }

    fn ask(&mut self) {
        let request = Request::new(SubsystemId::VERTICAL, Body::GetStatus);
        for poll in &mut self.polls {
            if poll.asked.is_none() && self.now >= poll.due {
                let terms = Terms { expires: poll.life.map(|life| self.now + life), first: None };
                let request = RequestBuf::new(&request).unwrap();
                let ticket = self.line.submit(self.now, poll.address, terms, vec![request]);
                poll.asked = Some((ticket.unwrap(), self.now));
                poll.due = (poll.due + poll.every).max(self.now);
            }
        }
    }

    fn on_the_wire(&mut self, bytes: &[u8]) {
        let mut decoder: Decoder = Decoder::new();
        let frame = decoder.push_slice(bytes).1.expect("a frame");
        let (to, payload) = (frame.dst, frame.payload.to_vec());
        let early = self.heard > Now::ZERO && self.now < self.heard + TURNAROUND;
        self.collided += u32::from(early || !self.coming.is_empty());
        let slow = self.slow.filter(|(address, _)| *address == to);
        if self.present.contains(&to) || slow.is_some() {
            let takes = slow.map_or(self.takes, |(_, takes)| takes);
            self.coming.push((self.now + takes, to, payload.clone()));
        }
        self.sent.push((self.now, to, payload));
    }

    fn take_ends(&mut self) {
        while let Some((ticket, end)) = self.line.poll_outcome() {
            let of = |poll: &&mut Poll| poll.asked.is_some_and(|(asked, _)| asked == ticket);
            let Some(poll) = self.polls.iter_mut().find(of) else {
                self.ends.push((self.now, ticket, end));
                continue;
            };
            let asked = poll.asked.take();
            if matches!(end, Outcome::Answered(_)) {
                poll.answered.push(self.now);
                poll.longest = poll.longest.max(self.now - asked.unwrap().1);
            }
            poll.expired += u32::from(end == Outcome::Expired);
        }
    }

    /// Answered polls of a monitor in this time, and the longest time without one.
    fn values(&self, address: u8, from: Now, until: Now) -> (usize, Duration) {
        let poll = self.polls.iter().find(|poll| poll.address == address).expect("polled");
        let within: Vec<Now> =
            poll.answered.iter().copied().filter(|at| (from..=until).contains(at)).collect();
        let ends = [from].into_iter().chain(within.iter().copied()).chain([until]);
        let ends: Vec<Now> = ends.collect();
        let gap = ends.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or_default();
        (within.len(), gap)
    }

    /// When frames with a Stop were sent to a monitor.
    fn stops(&self, address: u8) -> Vec<Now> {
        let stops = |it: &&(Now, u8, Vec<u8>)| it.1 == address && it.2[0] == RequestId::STOP.0;
        self.sent.iter().filter(stops).map(|(at, ..)| *at).collect()
    }

    fn end(&self, ticket: Ticket) -> Option<&(Now, Ticket, Outcome)> {
        self.ends.iter().find(|(_, of, _)| *of == ticket)
    }
}

/// Presses Stop of the silent monitor four times a second, of another part each time.
fn press(world: &mut World, duration: Duration, mut each: impl FnMut(&mut World, u32)) {
    let from = world.now;
    let mut count = 0;
    while world.now < from + duration {
        world.stop(SILENT, STOPPED[count as usize % STOPPED.len()]);
        let next = world.now + 250 * MS;
        each(world, count);
        world.run(next);
        count += 1;
    }
}

/// The monitors that answer keep their polls, as without a Stop.
fn assert_polled(world: &World, until: Now, share: usize) {
    let mut alone = World::three(world.takes);
    alone.run(until);
    for address in PRESENT {
        let (usual, _) = alone.values(address, KNOWN, until);
        let (count, gap) = world.values(address, KNOWN, until);
        let takes = world.takes;
        println!("{takes:?}, monitor {address}: {count} of {usual} polls, longest gap {gap:?}");
        assert!(count * 100 >= usual * share, "{takes:?}: {count} of {usual}");
        assert!(gap <= 2 * PERIOD + 200 * MS, "{takes:?}: {gap:?} without a value");
    }
    assert_eq!(world.collided, 0, "{:?}", world.takes);
}

/// It is tried as often as where it is alone on its line, and the others are polled meanwhile.
#[test]
fn a_stop_of_a_silent_monitor_leaves_the_line_to_the_others() {
    let mut single = World::new(MS, &[], [SILENT]);
    let from = single.now;
    single.stop(SILENT, SubsystemId::ALL);
    single.run(from + 4 * SECOND);
    let tries = single.stops(SILENT).len();
    assert!(tries >= 4, "{tries}");
    for takes in ANSWERS {
        let mut world = World::three(takes);
        let stop = world.stop(SILENT, SubsystemId::ALL);
        let until = KNOWN + 3500 * MS;
        world.run(until);
        assert_polled(&world, until, 90);
        let sent = world.stops(SILENT);
        println!(
            "{takes:?}: a Stop is sent at {:?}",
            sent.iter().map(|at| *at - KNOWN).collect::<Vec<_>>()
        );
        assert!(sent[0] <= KNOWN + takes + 42 * MS, "{takes:?}: {:?}", sent[0] - KNOWN);
        assert!(sent.len() >= tries, "{takes:?}: {sent:?}");
        let (at, _, end) = world.end(stop).expect("it ends");
        assert!(matches!(end, Outcome::Silence { .. }), "{takes:?}: {end:?}");
        assert!(*at >= KNOWN + 3 * SECOND, "{takes:?}: {at:?}");
    }
}

#[test]
fn many_stops_of_a_silent_monitor_leave_the_line_to_the_others() {
    for takes in ANSWERS {
        let mut world = World::three(takes);
        let mut late = Duration::ZERO;
        press(&mut world, 10 * SECOND, |world, _| {
            let (from, before) = (world.now, world.stops(SILENT).len());
            world.run(from + 160 * MS);
            late = late.max(world.stops(SILENT)[before] - from);
        });
        // With the slowest answers, polls and first frames are all that the line can carry.
        assert_polled(&world, KNOWN + 10 * SECOND, if takes < 50 * MS { 95 } else { 75 });
        println!("{takes:?}: a Stop is sent after {late:?} at most");
        assert!(late <= takes + 42 * MS, "{takes:?}: {late:?}");
    }
}

/// What keeps a motion of another monitor going has its turn in time.
#[test]
fn a_motion_of_another_monitor_goes_on_beside_stops() {
    // With the slowest answers the polls, the beats and the Stops are more than the line can carry.
    for takes in [ANSWERS[0], ANSWERS[1]] {
        let mut world = World::three(takes);
        world.poll(1, 100 * MS, Some(300 * MS));
        press(&mut world, 10 * SECOND, |_, _| {});
        let beats = world.polls.last().unwrap();
        let (count, longest) = (beats.answered.len(), beats.longest);
        println!("{takes:?}: {count} of 100 beats, answered after {longest:?} at most");
        assert!(beats.expired == 0 && count >= 90, "{takes:?}: {count}");
        assert!(longest <= 2 * (takes + 42 * MS) + takes, "{takes:?}: {longest:?}");
    }
}

/// A Stop of a monitor that answers waits for no more than an answer and the first frame of another Stop.
#[test]
fn a_stop_of_a_monitor_that_answers_goes_first() {
    for takes in ANSWERS {
        let (mut world, mut stops) = (World::three(takes), Vec::new());
        press(&mut world, 10 * SECOND, |world, count| {
            world.run(world.now + MS * (count * 37 % 240));
            stops.push((world.now, world.stop(2, SubsystemId::ALL)));
            world.run(world.now);
        });
        world.run(world.now + SECOND);
        let sent = world.stops(2);
        assert_eq!(sent.len(), stops.len(), "{takes:?}: once each");
        let mut late = Duration::ZERO;
        for ((asked, stop), sent) in stops.iter().zip(sent) {
            late = late.max(sent - *asked);
            assert!(matches!(world.end(*stop), Some((_, _, Outcome::Answered(_)))), "{takes:?}");
        }
        println!("{takes:?}: a Stop of a monitor that answers is sent after {late:?} at most");
        assert!(late <= 2 * takes + 42 * MS, "{takes:?}: {late:?}");
    }
}

/// One that comes back is stopped by the next frame.
#[test]
fn a_monitor_that_comes_back_is_stopped() {
    for takes in ANSWERS {
        for back in [20, 140, 400, 900, 1500, 2000].map(|ms| MS * ms) {
            let mut world = World::three(takes);
            let stop = world.stop(SILENT, SubsystemId::ALL);
            world.run(KNOWN + back);
            let before = world.stops(SILENT).len();
            world.present.push(SILENT);
            world.run(KNOWN + 4 * SECOND);
            let sent = world.stops(SILENT);
            assert_eq!(sent.len(), before + 1, "{takes:?}, back after {back:?}: {sent:?}");
            let (at, _, end) = world.end(stop).expect("it ends");
            assert!(matches!(end, Outcome::Answered(_)), "{takes:?}, {back:?}: {end:?}");
            assert_eq!(*at, sent[before] + takes);
            assert!(*at <= KNOWN + back + 1200 * MS, "{takes:?}, {back:?}: {at:?}");
        }
    }
}

/// Several that come back together are stopped in the time of a timeout, and a little.
#[test]
fn several_that_come_back_are_stopped() {
    for takes in ANSWERS {
        let mut world = World::new(takes, &PRESENT, 1..=8);
        let stops: Vec<_> = (3..=8).map(|address| world.stop(address, SubsystemId::ALL)).collect();
        let back = KNOWN + 500 * MS;
        world.run(back);
        world.present.extend(3..=8);
        world.run(KNOWN + 4 * SECOND);
        for stop in stops {
            let (at, _, end) = world.end(stop).expect("it ends");
            assert!(matches!(end, Outcome::Answered(_)), "{takes:?}: {end:?}");
            println!("{takes:?}: {:?} after they are back", *at - back);
            // Polls nearly fill the line where each answer takes 60 ms.
            assert!(*at <= back + 1400 * MS + takes * 6, "{takes:?}: {:?}", *at - back);
        }
    }
}

/// The answer of one that was always slower than the others meets no frame of theirs.
#[test]
fn a_slow_monitor_that_comes_back_is_heard() {
    let mut world = World::empty(15 * MS, &[1, 2, SILENT]);
    world.slow = Some((SILENT, 70 * MS));
    [1, 2, SILENT].into_iter().for_each(|address| world.poll(address, PERIOD, None));
    world.run(KNOWN);
    world.present.retain(|address| *address != SILENT);
    world.run(KNOWN + 3 * SECOND);
    world.polls.retain(|poll| poll.address != SILENT);
    world.run(KNOWN + 5 * SECOND);
    world.present.push(SILENT);
    world.collided = 0;
    let (before, from) = (world.stops(SILENT).len(), world.now);
    let stop = world.stop(SILENT, SubsystemId::ALL);
    world.run(from + SECOND);
    assert_eq!(world.stops(SILENT).len(), before + 1);
    let (_, _, end) = world.end(stop).expect("it ends");
    assert!(matches!(end, Outcome::Answered(_)), "{end:?}");
    assert_eq!(world.collided, 0);
}

/// An answer after others have had the line is still that to the Stop, and to nothing else.
#[test]
fn a_late_answer_to_a_stop_is_taken() {
    let takes = 15 * MS;
    let mut world = World::three(takes);
    // Its polls end: a frame of it would show that it is there.
    world.polls.retain(|poll| poll.address != SILENT);
    world.slow = Some((SILENT, 110 * MS));
    let stop = world.stop(SILENT, SubsystemId::ALL);
    world.run(KNOWN + SECOND);
    let sent = world.stops(SILENT);
    assert_eq!(sent.len(), 1, "{sent:?}");
    let (at, _, end) = world.end(stop).expect("it ends");
    assert!(matches!(end, Outcome::Answered(_)), "{end:?}");
    assert_eq!(*at, sent[0] + 110 * MS);
    let stats = world.line.total();
    assert_eq!((stats.late, stats.unmatched), (0, 0), "{stats:?}");
    let polled = world
        .sent
        .iter()
        .any(|(at, to, _)| *to != SILENT && *at > sent[0] && *at < sent[0] + 110 * MS);
    assert!(polled, "the others had the line meanwhile");
}

/// All of 32 are stopped, and 31 are off: after the first frame to each, the one has its turn.
#[test]
fn a_stop_of_all_leaves_the_line_to_the_one_that_answers() {
    for takes in ANSWERS {
        let mut world = World::new(takes, &[1], 1..=32);
        world.run(30 * SECOND);
        let from = world.now;
        (2..=32).for_each(|address| _ = world.stop(address, SubsystemId::ALL));
        let stop = world.stop(1, SubsystemId::ALL);
        world.run(from + 4 * SECOND);
        let firsts = (2..=32).map(|address| world.stops(address)[0]).max().unwrap();
        let first = firsts - from;
        assert!(first <= 32 * (takes + 41 * MS), "{takes:?}: {first:?}");
        let (at, _, end) = world.end(stop).expect("it ends");
        assert!(matches!(end, Outcome::Answered(_)), "{takes:?}: {end:?}");
        assert!(*at <= from + 200 * MS, "{takes:?}: {:?}", *at - from);
        let until = firsts + 3 * SECOND;
        world.run(until);
        let (count, gap) = world.values(1, firsts + takes + 40 * MS, until);
        println!(
            "{takes:?}: {first:?} for the first frames, then {count} of 15, longest gap {gap:?}"
        );
        assert!(count >= 13, "{takes:?}: {count}");
        assert!(gap <= 2 * PERIOD + 200 * MS, "{takes:?}: {gap:?}");
    }
}
