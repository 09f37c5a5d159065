//! What the hub knows of a monitor, as plugs show it. No I/O, no clock.

use std::time::Duration;

use lafet_proto::SubsystemId;
use serde::Serialize;

use crate::alarms::{Priority, State};
use crate::monitor::status::Status;

/// The authority over a monitor, as this session sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Holder {
    /// No client holds it.
    #[default]
    Free,
    /// This session holds it.
    Mine,
    /// Another client holds it.
    Other,
}

/// What is known of the authority over a monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Control {
    /// Who holds it.
    pub holder: Holder,
    /// The holder's connection or heartbeat is lost.
    pub lost: bool,
    /// A client asks for it.
    pub asked: bool,
    /// This session asks for it.
    pub asks: bool,
}

/// What the hub knows of a monitor.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// Its state as last heard.
    pub status: &'a Status,
    /// Age of that state, by a clock that does not jump; `None`: never heard.
    pub age: Option<Duration>,
    /// There is a connection to it.
    pub up: bool,
    /// It can do its work.
    pub ready: bool,
    /// The authority over it.
    pub control: Control,
    /// Its alarms that are not normal.
    pub alarms: Tally,
}

/// Alarms in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Alarms that are active or not acknowledged, and not shelved.
    pub count: u16,
    /// Of these, those that are not acknowledged.
    pub waiting: u16,
    /// The most urgent of them.
    pub worst: Option<Priority>,
    /// A fire is seen, or its alarm waits.
    pub fire: bool,
}

impl Known<'_> {
    /// The state is the present one, and there is a connection.
    pub fn is_fresh(&self) -> bool {
        !self.status.stale && self.up && self.age.is_some()
    }
}

impl Tally {
    /// Counts an alarm.
    pub fn add(&mut self, priority: Priority, state: State) {
        if state == State::Shelved {
            return;
        }
        self.count = self.count.saturating_add(1);
        if state != State::Ack {
            self.waiting = self.waiting.saturating_add(1);
        }
        self.worst = Some(self.worst.map_or(priority, |worst| worst.min(priority)));
        self.fire |= priority == Priority::Fire;
    }
}

/// Whether a valve reports that it is not well.
pub fn is_faulty(status: &Status, valve: SubsystemId) -> bool {
    let faults = ["OpenSensorFault", "CloseSensorFault", "AmperageOverload"];
    faults.into_iter().any(|flag| status.is_set(valve, flag))
}

/// What the monitor does: its number, and its word.
pub fn mode(status: &Status) -> (u16, &'static str) {
    let is_set = |id, flag| status.is_set(id, flag);
    let modes = [
        (SubsystemId::GENERAL, "LockedOut", (9, "locked_out")),
        (SubsystemId::GENERAL, "Restarting", (10, "restarts")),
        (SubsystemId::DEPLOYER, "Deploying", (2, "deploys")),
        (SubsystemId::DEPLOYER, "Wrapping", (3, "stows")),
        (SubsystemId::DEPLOYER, "Wrapped", (1, "stowed")),
        (SubsystemId::CONTROL, "Paused", (7, "paused")),
        (SubsystemId::CONTROL, "Quench", (6, "extinguishes")),
        (SubsystemId::DETECTOR, "Searching", (5, "searches")),
        (SubsystemId::DETECTOR, "Justifying", (8, "aligns")),
    ];
    let found = modes.into_iter().find(|(id, flag, _)| is_set(*id, flag));
    found.map_or((4, "by_hand"), |(.., mode)| mode)
}

/// A monitor that is there, for the tests of what plugs show.
#[cfg(test)]
pub mod fixture {
    use std::sync::Arc;

    use super::*;
    use crate::monitor::status::Subsystem;

    /// It turns, extinguishes and sees a fire; it has no deployer and one valve.
    pub fn status() -> Status {
        let subsystem = |id: SubsystemId, bits: u32, fields: &[(&'static str, i64)]| {
            let mut state = Subsystem::default();
            state.set_bits(id, bits);
            state.fields = fields.iter().copied().collect();
            (id.name().unwrap(), Arc::new(state))
        };
        let general = [("pressure", 80), ("flowrate", 20), ("main_voltage", 24)];
        let subsystems = [
            subsystem(SubsystemId::GENERAL, 0, &general),
            subsystem(SubsystemId::HORIZONTAL, 1 << 16, &[("position", -605)]),
            subsystem(SubsystemId::VERTICAL, 1 << 25, &[("position", 1203)]),
            subsystem(SubsystemId::NOZZLE, 0, &[("position", 60)]),
            subsystem(SubsystemId::VALVE1, 1 << 22, &[]),
            subsystem(SubsystemId::CONTROL, 1 << 16, &[]),
            subsystem(SubsystemId::DETECTOR, 1 << 17, &[]),
        ];
        Status { at_ms: Some(1), subsystems: subsystems.into(), ..Status::default() }
    }
}
