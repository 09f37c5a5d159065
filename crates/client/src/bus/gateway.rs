//! Programs at the controller (ours): each connection is assigned an address of the bus, and its
//! frames are sent in the controller's own turns.
//!
//! The protocol does not number requests, so two programs must not share a source address: a late
//! answer to one would be taken for an answer to the other. Addresses are assigned in turn, so that
//! one that has just been released is not assigned again immediately.

use std::collections::{BTreeMap, VecDeque};
use std::ops::RangeInclusive;
use std::time::Duration;

use lafet_proto::RequestId;
use lafet_proto::bus::{CONTROLLER, MONITORS, ProbeLimit};
use lafet_proto::link::{Check, Decoder, Frame};
use lafet_proto::record::Records;

use super::controller::{Controller, wire};
use crate::session::Now;

/// Addresses for programs (ours); consoles of the bus must have others.
pub const LENT: RangeInclusive<u8> = 230..=254;
/// Most programs at a time; fewer than addresses.
pub const PROGRAMS_MAX: usize = 16;
/// Most waiting frames of a program; more are dropped, as on a line that is too slow.
const WAITING_MAX: usize = 16;
/// A frame that has waited longer is dropped: its client has stopped waiting, and its request may
/// no longer be wanted. Stop, Close and Lockout are not dropped.
const LIFE: Duration = Duration::from_millis(500);

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
    /// The program has disconnected.
    gone: bool,
    waiting: VecDeque<Waiting>,
}

#[derive(Debug)]
struct Waiting {
    since: Now,
    check: Check,
    monitor: u8,
    payload: Vec<u8>,
    urgent: bool,
}

impl Gateway {
    /// Assigns an address to a new program; `None` if there are too many.
    pub fn connect(&mut self) -> Option<u8> {
        if self.programs.len() >= PROGRAMS_MAX {
            return None;
        }
        let after = self.lent.map_or(*LENT.start(), |last| last.saturating_add(1));
        let mut order = (after..=*LENT.end()).chain(LENT);
        let address = order.find(|address| !self.programs.contains_key(address))?;
        self.lent = Some(address);
        self.programs.insert(address, Program::default());
        Some(address)
    }

    /// Removes a program. Its urgent requests are still sent.
    pub fn disconnect(&mut self, program: u8) {
        if let Some(program) = self.programs.get_mut(&program) {
            program.gone = true;
            program.waiting.retain(|frame| frame.urgent);
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

    /// Whether a Stop, Close or Lockout waits.
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
        let (mut answers, mut rest) = (Vec::new(), bytes);
        while !rest.is_empty() {
            let (taken, frame) = program.decoder.push_slice(rest);
            rest = &rest[taken..];
            let Some(Frame { dst, src, payload }) = frame else { continue };
            let payload = payload.to_vec();
            let check = program.decoder.check();
            program.own = src;
            if dst == CONTROLLER {
                if payload.is_empty() && !program.probes.allows(now.as_millis() as u32) {
                    continue;
                }
                answers.extend(wire(check, src, CONTROLLER, &controller.services(&payload)));
            } else if MONITORS.contains(&dst) && program.waiting.len() < WAITING_MAX {
                let urgent = is_urgent(&payload);
                let frame = Waiting { since: now, check, monitor: dst, payload, urgent };
                program.waiting.push_back(frame);
            } else if MONITORS.contains(&dst) {
                self.dropped += 1;
            }
        }
        answers
    }

    /// The next frame for the monitors' line.
    pub fn poll_transmit(&mut self, now: Now) -> Option<Vec<u8>> {
        let mut dropped = 0;
        for program in self.programs.values_mut() {
            let before = program.waiting.len();
            program.waiting.retain(|frame| frame.urgent || now <= frame.since + LIFE);
            dropped += before - program.waiting.len();
        }
        self.dropped += dropped as u64;
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

fn is_urgent(payload: &[u8]) -> bool {
    let urgent = [RequestId::STOP, RequestId::CLOSE, RequestId::LOCKOUT];
    Records::new(payload).map_while(Result::ok).any(|record| urgent.contains(&record.request))
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
        let (a, b) = (world.gateway.connect().unwrap(), world.gateway.connect().unwrap());
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
        let c = world.gateway.connect().unwrap();
        assert!(c != a && c != b);
        assert!(world.gateway.handle_line(&answer).is_empty());
    }

    #[test]
    fn the_controller_itself_is_asked_without_the_line() {
        let mut world = World::new();
        let a = world.gateway.connect().unwrap();
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
        let (a, b) = (world.gateway.connect().unwrap(), world.gateway.connect().unwrap());
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
        let a = world.gateway.connect().unwrap();
        world.says(Now::ZERO, a, 1, &MOVE);
        world.says(Now::ZERO, a, 1, &STOP);
        world.gateway.disconnect(a);
        assert_eq!(world.sent(700 * MS), Some((1, a, STOP.to_vec())));
        assert_eq!(world.sent(700 * MS), None);
        let b = world.gateway.connect().unwrap();
        world.says(Now::ZERO, b, 1, &MOVE);
        assert_eq!((world.sent(501 * MS), world.gateway.dropped()), (None, 1));
        (0..20).for_each(|_| assert!(world.says(Now::ZERO, b, 1, &STATUS).is_empty()));
        assert_eq!(world.gateway.dropped(), 5);
    }

    #[test]
    fn not_more_programs_than_it_can_bear() {
        let mut world = World::new();
        let all: Vec<u8> = std::iter::from_fn(|| world.gateway.connect()).collect();
        assert_eq!(all.len(), PROGRAMS_MAX);
        world.gateway.disconnect(all[3]);
        for _ in 0..100 {
            let next = world.gateway.connect().expect("there is room");
            assert!(LENT.contains(&next));
            assert_eq!(world.gateway.connect(), None);
            world.gateway.disconnect(next);
        }
    }
}
