//! Programs at the controller (ours): each connection is assigned an address of the bus, and its
//! frames are sent in the controller's own turns.
//!
//! The protocol does not number requests, so two programs must not share a source address: a late
//! answer to one would be taken for an answer to the other. Addresses are assigned in turn, so that
//! one that has just been released is not assigned again immediately.

use std::collections::{BTreeMap, VecDeque};
use std::ops::RangeInclusive;
use std::time::Duration;

use lafet_proto::bus::{CONTROLLER, MONITORS, ProbeLimit};
use lafet_proto::link::{Check, Decoder, Frame};

use super::controller::{Controller, wire};
use super::kind::is_urgent;
use crate::session::Now;

/// Addresses for programs (ours); consoles of the bus must have others.
pub const LENT: RangeInclusive<u8> = 230..=254;
/// Most programs at a time; fewer than addresses.
pub const PROGRAMS_MAX: usize = 16;
/// Most connections beyond these at a time. They are there for a Stop, Close or Lockout on, which must not wait
/// until one of the programs is quiet.
const GUESTS_MAX: usize = 8;
/// A guest has this time to say what it came for before it gives way to another one.
const GUEST_STAYS: Duration = Duration::from_millis(250);
/// A program that has said nothing for this long gives way to another one where there are so many: its
/// connection may be half open.
const QUIET: Duration = Duration::from_secs(30);
/// Most waiting frames of a program; more are dropped, as on a line that is too slow.
const WAITING_MAX: usize = 16;
/// A frame that has waited longer is dropped: its client has stopped waiting, and its request may
/// no longer be wanted.
const LIFE: Duration = Duration::from_millis(500);
/// The same of a Stop, Close or Lockout on. It outlasts the reopening of a line; one of minutes ago
/// would end what another client has started since.
const URGENT_LIFE: Duration = Duration::from_secs(10);

/// The programs of a controller.
#[derive(Debug, Default)]
pub struct Gateway {
    programs: BTreeMap<u8, Program>,
    /// The address that was assigned last.
    lent: Option<u8>,
    /// The program whose turn was last.
    turn: u8,
    ear: Box<Decoder>,
    dropped: u64,
}

#[derive(Debug, Default)]
struct Program {
    decoder: Box<Decoder>,
    /// The source address that the program uses in its frames.
    own: u8,
    /// §L/8 Limits which of its probes are answered.
    probes: ProbeLimit,
    /// When it was heard last.
    heard: Now,
    /// Whether it has one of the places of programs.
    place: Place,
    /// The program has disconnected.
    gone: bool,
    waiting: VecDeque<Waiting>,
}

/// Whether a connection counts as a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Place {
    #[default]
    Program,
    /// It has not said anything yet.
    Guest,
    /// It began with something urgent, so it stays until others need its place.
    Urgent,
    /// It began with something else.
    Refused,
}

#[derive(Debug)]
struct Waiting {
    since: Now,
    check: Check,
    monitor: u8,
    payload: Vec<u8>,
    urgent: bool,
}

impl Waiting {
    fn is_due(&self, now: Now) -> bool {
        now <= self.since + if self.urgent { URGENT_LIFE } else { LIFE }
    }
}

impl Program {
    /// A frame more, if there is room. An urgent one takes the place of the oldest that is not.
    fn queue(&mut self, frame: Waiting) -> bool {
        if self.waiting.len() >= WAITING_MAX {
            let other = self.waiting.iter().position(|other| !other.urgent);
            let Some(other) = other.filter(|_| frame.urgent) else { return false };
            self.waiting.remove(other);
            self.waiting.push_back(frame);
            return false;
        }
        self.waiting.push_back(frame);
        true
    }
}

impl Gateway {
    /// Assigns an address to a new program; `None` if there are too many.
    pub fn connect(&mut self, now: Now) -> Option<u8> {
        self.forget(now);
        if self.is_full() {
            return None;
        }
        self.lend(now, Place::Program)
    }

    /// Assigns an address to a connection more than there may be programs. If its first frame is urgent it
    /// stays, else it is to be closed: see [`Self::is_refused`]. `None` if there are too many of these.
    pub fn connect_guest(&mut self, now: Now) -> Option<u8> {
        if self.is_full_of_guests() {
            return None;
        }
        self.lend(now, Place::Guest)
    }

    fn is_full(&self) -> bool {
        self.programs.values().filter(|one| one.place == Place::Program).count() >= PROGRAMS_MAX
    }

    fn is_full_of_guests(&self) -> bool {
        let guests = self.programs.values().filter(|one| one.place != Place::Program && !one.gone);
        guests.count() >= GUESTS_MAX
    }

    /// When one more connection may be accepted; `None`: now. What waits until then loses nothing, while a guest that
    /// gave way too early would lose what it has just sent.
    pub fn accepts_from(&mut self, now: Now) -> Option<Now> {
        self.forget(now);
        if self.programs.len() >= LENT.count() {
            // The urgent requests of one that is gone have its address until they are sent.
            return Some(now + GUEST_STAYS);
        }
        if !self.is_full() || self.quietest(now).is_some() || !self.is_full_of_guests() {
            return None;
        }
        let (_, heard) = self.first(|program| program.place != Place::Program)?;
        Some(heard + GUEST_STAYS).filter(|at| *at > now)
    }

    fn lend(&mut self, now: Now, place: Place) -> Option<u8> {
        let after = self.lent.map_or(*LENT.start(), |last| last.saturating_add(1));
        let mut order = (after..=*LENT.end()).chain(LENT);
        let address = order.find(|address| !self.programs.contains_key(address))?;
        self.lent = Some(address);
        self.programs.insert(address, Program { heard: now, place, ..Program::default() });
        Some(address)
    }

    /// The program that has to give way to one more: of those that were quiet for long, the quietest.
    pub fn quietest(&self, now: Now) -> Option<u8> {
        let programs = |program: &Program| program.place == Place::Program;
        let (address, heard) = self.first(programs)?;
        (now >= heard + QUIET).then_some(address)
    }

    /// The guest that has to give way to one more: the quietest, if it has had its time.
    pub fn quietest_guest(&self, now: Now) -> Option<u8> {
        let (address, heard) = self.first(|program| program.place != Place::Program)?;
        (now >= heard + GUEST_STAYS).then_some(address)
    }

    /// Of these, the one that was heard first, and when.
    fn first(&self, is: impl Fn(&Program) -> bool) -> Option<(u8, Now)> {
        let there = self.programs.iter().filter(|(_, program)| !program.gone && is(program));
        let first = there.min_by_key(|(_, program)| program.heard);
        first.map(|(address, program)| (*address, program.heard))
    }

    /// Whether this connection has no place: it began with something that is not urgent.
    pub fn is_refused(&self, program: u8) -> bool {
        self.programs.get(&program).is_some_and(|program| program.place == Place::Refused)
    }

    /// Removes a program. Its urgent requests are still sent.
    pub fn disconnect(&mut self, program: u8) {
        if let Some(program) = self.programs.get_mut(&program) {
            program.gone = true;
            program.waiting.retain(|frame| frame.urgent);
        }
        self.forget_gone();
    }

    /// Drops what has waited too long.
    fn forget(&mut self, now: Now) {
        for program in self.programs.values_mut() {
            let before = program.waiting.len();
            program.waiting.retain(|frame| frame.is_due(now));
            self.dropped += (before - program.waiting.len()) as u64;
        }
        self.forget_gone();
    }

    fn forget_gone(&mut self) {
        self.programs.retain(|_, program| !program.gone || !program.waiting.is_empty());
    }

    /// Frames that were dropped because they waited too long or were too many.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Whether a frame waits for the line.
    pub fn waits(&self) -> bool {
        self.programs.values().any(|program| !program.waiting.is_empty())
    }

    /// Whether a Stop, Close or Lockout on waits.
    pub fn is_urgent(&self) -> bool {
        self.programs.values().any(|program| program.waiting.iter().any(|frame| frame.urgent))
    }

    /// Takes bytes of a program. Its frames to monitors wait for their turn; the answers to those
    /// for the controller are returned.
    pub fn handle_program(
        &mut self,
        now: Now,
        program: u8,
        bytes: &[u8],
        controller: &Controller,
    ) -> Vec<u8> {
        let Some(program) = self.programs.get_mut(&program) else { return Vec::new() };
        program.heard = now;
        let (mut answers, mut rest) = (Vec::new(), bytes);
        while !rest.is_empty() {
            let (taken, frame) = program.decoder.push_slice(rest);
            rest = &rest[taken..];
            let Some(Frame { dst, src, payload }) = frame else { continue };
            let payload = payload.to_vec();
            let check = program.decoder.check();
            program.own = src;
            if program.place == Place::Guest {
                let urgent = MONITORS.contains(&dst) && is_urgent(&payload);
                program.place = if urgent { Place::Urgent } else { Place::Refused };
            }
            if program.place == Place::Refused {
                break;
            }
            if dst == CONTROLLER {
                if payload.is_empty() && !program.probes.allows(now.as_millis() as u32) {
                    continue;
                }
                answers.extend(wire(check, src, CONTROLLER, &controller.services(&payload)));
            } else if MONITORS.contains(&dst) {
                let urgent = is_urgent(&payload);
                let frame = Waiting { since: now, check, monitor: dst, payload, urgent };
                self.dropped += u64::from(!program.queue(frame));
            }
        }
        answers
    }

    /// The next frame for the monitors' line.
    pub fn poll_transmit(&mut self, now: Now) -> Option<Vec<u8>> {
        self.forget(now);
        let urgent = self.is_urgent();
        let turn = self.turn;
        let has = |program: &Program| match urgent {
            true => program.waiting.iter().any(|frame| frame.urgent),
            false => !program.waiting.is_empty(),
        };
        let mut ready = self.programs.iter().filter(|(_, program)| has(program)).map(|(a, _)| *a);
        let first = ready.next()?;
        let address = std::iter::once(first).chain(ready).find(|a| *a > turn).unwrap_or(first);
        self.turn = address;
        let program = self.programs.get_mut(&address)?;
        let at = if urgent { program.waiting.iter().position(|frame| frame.urgent)? } else { 0 };
        let Waiting { check, monitor, payload, .. } = program.waiting.remove(at)?;
        // Earlier requests of the program must not reverse its Stop.
        let mut earlier = at;
        program.waiting.retain(|frame| {
            let undoes = earlier > 0 && frame.monitor == monitor;
            earlier = earlier.saturating_sub(1);
            !undoes
        });
        self.forget_gone();
        Some(wire(check, monitor, address, &payload))
    }

    /// Takes bytes of the monitors' line; returns the answers for programs, each with its receiver.
    pub fn handle_line(&mut self, bytes: &[u8]) -> Vec<(u8, Vec<u8>)> {
        let (mut answers, mut rest) = (Vec::new(), bytes);
        while !rest.is_empty() {
            let (taken, frame) = self.ear.push_slice(rest);
            rest = &rest[taken..];
            let Some(Frame { dst, src, payload }) = frame else { continue };
            let payload = payload.to_vec();
            if let Some(program) = self.programs.get(&dst)
                && !program.gone
                && MONITORS.contains(&src)
            {
                answers.push((dst, wire(self.ear.check(), program.own, src, &payload)));
            }
        }
        answers
    }
}

#[cfg(test)]
mod tests {
    use lafet_proto::link::Check;

    use super::super::ControllerConfig;
    use super::*;

    const STATUS: [u8; 4] = [0xD4, 0x0D, 0, 0];
    const MOVE: [u8; 6] = [0x4D, 0x0D, 0, 2, 1, 0];
    const STOP: [u8; 4] = [0x46, 0x5D, 0, 0];
    const MS: Duration = Duration::from_millis(1);

    struct World {
        gateway: Gateway,
        controller: Controller,
    }

    impl World {
        fn new() -> Self {
            let controller = Controller::new(ControllerConfig::default());
            Self { gateway: Gateway::default(), controller }
        }

        fn says(&mut self, now: Now, program: u8, dst: u8, payload: &[u8]) -> Vec<u8> {
            let bytes = wire(Check::Crc16, dst, 129, payload);
            self.gateway.handle_program(now, program, &bytes, &self.controller)
        }

        /// Receiver, sender and records of the next frame.
        fn sent(&mut self, now: Now) -> Option<(u8, u8, Vec<u8>)> {
            let bytes = self.gateway.poll_transmit(now)?;
            let mut decoder: Box<Decoder> = Box::default();
            let frame = decoder.push_slice(&bytes).1.expect("a frame");
            Some((frame.dst, frame.src, frame.payload.to_vec()))
        }
    }

    #[test]
    fn an_answer_goes_to_the_program_that_asked_under_the_name_it_gave_itself() {
        let mut world = World::new();
        let (a, b) =
            (world.gateway.connect(Now::ZERO).unwrap(), world.gateway.connect(Now::ZERO).unwrap());
        assert_ne!(a, b);
        assert!(world.says(Now::ZERO, a, 1, &STATUS).is_empty());
        world.says(Now::ZERO, b, 1, &STATUS);
        assert_eq!(world.sent(MS), Some((1, a, STATUS.to_vec())));
        assert_eq!(world.sent(MS), Some((1, b, STATUS.to_vec())));
        let answer = wire(Check::Crc32c, b, 1, &STATUS);
        let expected = wire(Check::Crc32c, 129, 1, &STATUS);
        assert_eq!(world.gateway.handle_line(&answer), [(b, expected)]);
        assert!(world.gateway.handle_line(&wire(Check::Crc16, CONTROLLER, 1, &[])).is_empty());
        // A new program must not be taken for the previous one.
        world.gateway.disconnect(b);
        let c = world.gateway.connect(Now::ZERO).unwrap();
        assert!(c != a && c != b);
        assert!(world.gateway.handle_line(&answer).is_empty());
    }

    #[test]
    fn the_controller_itself_is_asked_without_the_line() {
        let mut world = World::new();
        let a = world.gateway.connect(Now::ZERO).unwrap();
        let answer = world.says(Now::ZERO, a, CONTROLLER, &[0x29, 0xC2, 0, 0]);
        let mut decoder: Box<Decoder> = Box::default();
        let frame = decoder.push_slice(&answer).1.expect("a frame");
        assert_eq!((frame.dst, frame.src, frame.payload.len()), (129, CONTROLLER, 36));
        assert_eq!(world.says(Now::ZERO, a, CONTROLLER, &[]), wire(Check::Crc16, 129, 128, &[]));
        assert_eq!(world.sent(MS), None);
    }

    #[test]
    fn a_stop_overtakes_and_is_not_undone() {
        let mut world = World::new();
        let (a, b) =
            (world.gateway.connect(Now::ZERO).unwrap(), world.gateway.connect(Now::ZERO).unwrap());
        world.says(Now::ZERO, a, 1, &STATUS);
        world.says(Now::ZERO, b, 2, &STATUS);
        world.says(Now::ZERO, b, 1, &MOVE);
        assert!(!world.gateway.is_urgent());
        world.says(Now::ZERO, b, 1, &STOP);
        world.says(Now::ZERO, b, 1, &MOVE);
        assert!(world.gateway.is_urgent());
        let order: Vec<_> = std::iter::from_fn(|| world.sent(MS)).collect();
        let expected: [(u8, u8, &[u8]); 4] =
            [(1, b, &STOP), (1, a, &STATUS), (2, b, &STATUS), (1, b, &MOVE)];
        assert!(order.iter().map(|(d, s, p)| (*d, *s, &p[..])).eq(expected), "{order:?}");
    }

    #[test]
    fn what_has_waited_too_long_is_not_sent_but_a_stop_is() {
        let mut world = World::new();
        let a = world.gateway.connect(Now::ZERO).unwrap();
        world.says(Now::ZERO, a, 1, &MOVE);
        world.says(Now::ZERO, a, 1, &STOP);
        world.gateway.disconnect(a);
        assert_eq!(world.sent(700 * MS), Some((1, a, STOP.to_vec())));
        assert_eq!(world.sent(700 * MS), None);
        let b = world.gateway.connect(Now::ZERO).unwrap();
        world.says(Now::ZERO, b, 1, &MOVE);
        assert_eq!((world.sent(501 * MS), world.gateway.dropped()), (None, 1));
        (0..20).for_each(|_| assert!(world.says(Now::ZERO, b, 1, &STATUS).is_empty()));
        assert_eq!(world.gateway.dropped(), 5);
    }

    #[test]
    fn a_full_queue_keeps_no_stop_out() {
        let mut world = World::new();
        let a = world.gateway.connect(Now::ZERO).unwrap();
        (0..20).for_each(|_| _ = world.says(Now::ZERO, a, 2, &STATUS));
        (0..20).for_each(|_| _ = world.says(Now::ZERO, a, 1, &STOP));
        let sent: Vec<_> = std::iter::from_fn(|| world.sent(MS)).collect();
        assert_eq!(sent, vec![(1, a, STOP.to_vec()); WAITING_MAX]);
        assert_eq!(world.gateway.dropped(), 4 + 20);
    }

    /// The line was lost for minutes: what was to be stopped then is no matter of now, and programs
    /// that have gone keep no place.
    #[test]
    fn a_stop_of_long_ago_is_not_sent() {
        let mut world = World::new();
        let all: Vec<u8> =
            std::iter::from_fn(|| world.gateway.connect(Now::ZERO)).take(PROGRAMS_MAX).collect();
        for program in all {
            world.says(Now::ZERO, program, 1, &STOP);
            world.gateway.disconnect(program);
        }
        assert_eq!(world.gateway.connect(9000 * MS), None);
        assert!(world.gateway.connect(10_001 * MS).is_some());
        assert_eq!(world.sent(10_001 * MS), None);
    }

    #[test]
    fn who_was_quiet_for_long_gives_way() {
        let mut world = World::new();
        let all: Vec<u8> = std::iter::from_fn(|| world.gateway.connect(Now::ZERO)).collect();
        let (quiet, others) = all.split_last().unwrap();
        for program in others {
            world.says(20_000 * MS, *program, 1, &STATUS);
        }
        assert_eq!(world.gateway.quietest(29_999 * MS), None);
        assert_eq!(world.gateway.quietest(30_000 * MS), Some(*quiet));
        world.gateway.disconnect(*quiet);
        assert_eq!(world.gateway.quietest(30_000 * MS), None);
        assert!(world.gateway.connect(30_000 * MS).is_some());
    }

    #[test]
    fn not_more_programs_than_it_can_bear() {
        let mut world = World::new();
        let all: Vec<u8> = std::iter::from_fn(|| world.gateway.connect(Now::ZERO)).collect();
        assert_eq!(all.len(), PROGRAMS_MAX);
        world.gateway.disconnect(all[3]);
        for _ in 0..100 {
            let next = world.gateway.connect(Now::ZERO).expect("there is room");
            assert!(LENT.contains(&next));
            assert_eq!(world.gateway.connect(Now::ZERO), None);
            world.gateway.disconnect(next);
        }
    }
}
