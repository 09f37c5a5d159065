//! What a monitor carries out by itself: which request began it, and when one that is paused goes
//! on. No I/O, no clock.

use lafet_proto::{RequestId, SubsystemId};
use serde::Serialize;
use utoipa::ToSchema;

use crate::clock::shifted;
use crate::monitor::status::Status;

/// §3.1/3 A paused program goes on this long after the last Move.
const RESUME_MS: u64 = 3000;
/// The flag of what was accepted is set this long afterwards at the latest.
const BEGIN_MS: u64 = 3000;
/// The flags of what a monitor does by itself.
const FLAGS: [(SubsystemId, &str); 3] = [
    (SubsystemId::CONTROL, "Quench"),
    (SubsystemId::DETECTOR, "Searching"),
    (SubsystemId::DETECTOR, "Justifying"),
];

/// A program, as the topic `program` has it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Program {
    /// The request that began it; `None`: not one of this hub.
    #[schema(required)]
    pub request: Option<String>,
    /// User who sent the request.
    #[schema(required)]
    pub by: Option<String>,
    /// When it was sent, ms since 1970.
    pub since_ms: u64,
}

/// What is known of the programs of a monitor.
#[derive(Clone, Debug, Default)]
pub struct Programs {
    current: Option<Program>,
    /// Whether the monitor has reported the program.
    seen: bool,
    /// Time of the last Move, ms since 1970.
    moved_ms: Option<u64>,
    /// One was paused when it was looked at last.
    paused: bool,
}

/// Whether a request begins what a monitor then does by itself.
pub const fn begins(id: RequestId) -> bool {
    matches!(
        id,
        RequestId::START_QUENCH
            | RequestId::START_TRAJECTORY
            | RequestId::START_SEEK
            | RequestId::START_JUSTIFY
    )
}

impl Programs {
    /// The program, if one runs.
    pub const fn current(&self) -> Option<&Program> {
        self.current.as_ref()
    }

    /// Nothing runs, nothing is paused: a state with the flags of the last one says nothing new.
    pub const fn are_idle(&self) -> bool {
        self.current.is_none() && !self.paused
    }

    /// A request that begins one was accepted.
    pub fn accepted(&mut self, now_ms: u64, request: &str, by: &str) {
        let (request, by) = (Some(request.to_owned()), Some(by.to_owned()));
        self.current = Some(Program { request, by, since_ms: now_ms });
        self.seen = false;
    }

    /// The date has changed by so much: moves the dates kept here.
    pub fn stepped(&mut self, by_ms: i64) {
        if let Some(program) = &mut self.current {
            program.since_ms = shifted(program.since_ms, by_ms);
        }
        self.moved_ms = self.moved_ms.map(|it| shifted(it, by_ms));
    }

    /// A Move is on its way to the monitor.
    pub const fn moved(&mut self, now_ms: u64) {
        self.moved_ms = Some(now_ms);
    }

    /// Takes a state that is not stale; returns when a paused program goes on.
    pub fn observe(&mut self, now_ms: u64, status: &Status) -> Option<u64> {
        let runs = FLAGS.iter().any(|(id, flag)| status.is_set(*id, flag));
        match &self.current {
            None if runs => {
                self.current = Some(Program { request: None, by: None, since_ms: now_ms });
                self.seen = true;
            }
            Some(_) if runs => self.seen = true,
            Some(program) => {
                let deploys = status.is_set(SubsystemId::DEPLOYER, "Deploying");
                let may_come = now_ms.saturating_sub(program.since_ms) < BEGIN_MS || deploys;
                if self.seen || !may_come {
                    self.current = None;
                }
            }
            None => {}
        }
        self.paused = status.is_set(SubsystemId::CONTROL, "Paused");
        if !self.paused {
            return None;
        }
        // A button or another client has paused it: the time counts from now.
        let lately = self.moved_ms.filter(|at_ms| now_ms.saturating_sub(*at_ms) <= RESUME_MS);
        let moved_ms = lately.unwrap_or(now_ms);
        self.moved_ms = Some(moved_ms);
        Some(moved_ms + RESUME_MS)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::monitor::status::Subsystem;

    fn status(control: u32, deployer: u32) -> Status {
        let with = |bits| Arc::new(Subsystem { bits, ..Subsystem::default() });
        let subsystems = [("Control", with(control)), ("Deployer", with(deployer))];
        Status { subsystems: subsystems.into(), ..Status::default() }
    }

    const QUENCH: u32 = 1 << 16;
    const PAUSED: u32 = 1 << 19;
    const DEPLOYING: u32 = 1 << 29;

    #[test]
    fn it_is_known_while_its_flag_is_set() {
        let mut all = Programs::default();
        all.accepted(1000, "StartQuench Control program=1", "anna");
        all.observe(1100, &status(0, 0));
        assert!(all.current().is_some(), "the poll was older than the answer");
        all.observe(9000, &status(0, DEPLOYING));
        assert!(all.current().is_some(), "it deploys first");
        all.observe(9100, &status(QUENCH, 0));
        assert_eq!(all.current().unwrap().by.as_deref(), Some("anna"));
        all.observe(9200, &status(0, 0));
        assert_eq!(all.current(), None);
        all.accepted(10_000, "StartQuench Control program=1", "anna");
        all.observe(13_000, &status(0, 0));
        assert_eq!(all.current(), None, "it was over before it was seen");
        all.observe(14_000, &status(QUENCH, 0));
        let others = Program { request: None, by: None, since_ms: 14_000 };
        assert_eq!(all.current(), Some(&others), "another client has started it");
    }

    #[test]
    fn a_paused_one_goes_on_after_the_last_move() {
        let mut all = Programs::default();
        all.moved(100);
        assert_eq!(all.observe(1000, &status(QUENCH, 0)), None);
        all.moved(5000);
        assert_eq!(all.observe(5100, &status(QUENCH | PAUSED, 0)), Some(8000));
        all.moved(6000);
        assert_eq!(all.observe(6100, &status(QUENCH | PAUSED, 0)), Some(9000));
        assert_eq!(all.observe(9010, &status(QUENCH, 0)), None);
        let by_button = all.observe(60_000, &status(QUENCH | PAUSED, 0));
        assert_eq!(by_button, Some(63_000), "no Move of ours: since it was seen");
        assert_eq!(all.observe(60_100, &status(QUENCH | PAUSED, 0)), Some(63_000));
    }
}
