//! The remote units of the explosion-proof execution, and their internal bus.
//!
//! Each unit is polled every 20 ms. A good exchange carries the outputs to the unit and its inputs
//! back; a lost one leaves both as they were, and so does one that breaks the protocol, though it is an answer. A unit
//! counts as online while the last answer is at most 100 ms old; a unit that has heard nothing for 200 ms stops its motor by itself. An access
//! to a parameter is answered 60 ms after the unit has got it. Figures ours.

use std::collections::BTreeMap;

use lafet_device::image::{Unit, UnitError, UnitInput, UnitOp, UnitReply};
use lafet_proto::SubsystemId;
use lafet_proto::param::{Param, Placement};

use crate::fault::{Fault, Faults, UnitFault};
use crate::rng::Rng;

/// Time between two exchanges with a unit, ms.
pub const POLL_MS: u64 = 20;

const ONLINE_MS: u64 = 100;
const DEADMAN_MS: u64 = 200;
const PARAM_MS: u64 = 60;

/// A remote unit.
#[derive(Clone, Debug, PartialEq)]
pub struct RemoteUnit {
    unit: Unit,
    params: BTreeMap<u16, i32>,
    op: Option<(UnitOp, u64)>,
    reply: Option<UnitReply>,
    answered_ms: Option<u64>,
    heard_ms: Option<u64>,
    protocol_fault: bool,
}

impl RemoteUnit {
    /// A unit with the default values of the parameters that are kept on units.
    pub fn new(unit: Unit) -> Self {
        let params = Param::of(subsystem(unit))
            .map(Param::spec)
            .filter(|spec| spec.placement == Placement::Unit)
            .map(|spec| (spec.id.0, spec.default))
            .collect();
        Self {
            unit,
            params,
            op: None,
            reply: None,
            answered_ms: None,
            heard_ms: None,
            protocol_fault: false,
        }
    }

    /// One exchange; true when it was good.
    pub fn poll(
        &mut self,
        now_ms: u64,
        op: Option<UnitOp>,
        rng: &mut Rng,
        faults: &Faults,
    ) -> bool {
        let has = |fault| faults.has(Fault::Unit(self.unit, fault));
        let lost = has(UnitFault::Lossy) && rng.chance(0.5);
        if has(UnitFault::Offline) || lost {
            return false;
        }
        self.answered_ms = Some(now_ms);
        self.protocol_fault = has(UnitFault::Protocol);
        if self.protocol_fault {
            return false;
        }
        self.heard_ms = Some(now_ms);
        self.access(now_ms, op, faults);
        true
    }

    fn access(&mut self, now_ms: u64, op: Option<UnitOp>, faults: &Faults) {
        let Some(op) = op else {
            (self.op, self.reply) = (None, None);
            return;
        };
        match self.op {
            Some((known, since_ms)) if known == op => {
                let silent = faults.has(Fault::Unit(self.unit, UnitFault::ParamSilent));
                if self.reply.is_none() && now_ms >= since_ms + PARAM_MS && !silent {
                    self.reply = Some(UnitReply { seq: op.seq, result: self.result(op, faults) });
                }
            }
            _ => (self.op, self.reply) = (Some((op, now_ms)), None),
        }
    }

    fn result(&mut self, op: UnitOp, faults: &Faults) -> Result<i32, UnitError> {
        let injected = [
            (UnitFault::ParamIncomplete, UnitError::Incomplete),
            (UnitFault::ParamBadId, UnitError::BadId),
            (UnitFault::ParamBadValue, UnitError::BadValue),
            (UnitFault::ParamError, UnitError::Internal),
        ];
        if let Some((_, error)) =
            injected.iter().find(|(fault, _)| faults.has(Fault::Unit(self.unit, *fault)))
        {
            return Err(*error);
        }
        let value = self.params.get_mut(&op.param).ok_or(UnitError::BadId)?;
        if let Some(new) = op.write {
            let spec =
                Param::of(subsystem(self.unit)).map(Param::spec).find(|s| s.id.0 == op.param);
            if spec.is_some_and(|spec| spec.check(core::iter::once(new)).is_err()) {
                return Err(UnitError::BadValue);
            }
            *value = new;
        }
        Ok(*value)
    }

    /// Whether the next exchange is good and changes nothing but its time.
    pub(crate) fn rests(&self, op: Option<UnitOp>, rng: &mut Rng, faults: &Faults) -> bool {
        let Some(answered_ms) = self.answered_ms.filter(|at| Some(*at) == self.heard_ms) else {
            return false;
        };
        let mut next = self.clone();
        let is_good = next.poll(answered_ms + POLL_MS, op, rng, faults);
        next.rest(answered_ms);
        is_good && next == *self
    }

    /// Exchanges like the last one went on until now.
    pub(crate) fn rest(&mut self, now_ms: u64) {
        (self.answered_ms, self.heard_ms) = (Some(now_ms), Some(now_ms));
    }

    /// Whether the exchange of this moment was good.
    pub fn answered_at(&self, now_ms: u64) -> bool {
        self.heard_ms == Some(now_ms)
    }

    /// Whether the unit has heard nothing for so long that it stops its motor.
    pub fn abandoned(&self, now_ms: u64) -> bool {
        self.heard_ms.is_none_or(|heard| now_ms - heard > DEADMAN_MS)
    }

    /// Its side of the internal bus.
    pub fn sense(&self, now_ms: u64, faults: &Faults) -> UnitInput {
        let online = self.answered_ms.is_some_and(|at| now_ms - at <= ONLINE_MS);
        let mut input = UnitInput::default();
        input.online = online;
        input.protocol_fault = online && self.protocol_fault;
        input.watchdog_reset = online && faults.has(Fault::Unit(self.unit, UnitFault::Watchdog));
        input.reply = self.reply;
        input
    }
}

/// The subsystem whose unit it is.
pub const fn subsystem(unit: Unit) -> SubsystemId {
    match unit {
        Unit::Vertical => SubsystemId::VERTICAL,
        Unit::Horizontal => SubsystemId::HORIZONTAL,
        Unit::Nozzle => SubsystemId::NOZZLE,
        Unit::Deployer => SubsystemId::DEPLOYER,
        Unit::Valve1 => SubsystemId::VALVE1,
        Unit::Valve2 => SubsystemId::VALVE2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::ParamId;

    fn run(unit: &mut RemoteUnit, from_ms: u64, op: Option<UnitOp>, faults: &Faults) -> u64 {
        let mut rng = Rng::new(3);
        for now_ms in (from_ms..from_ms + 400).step_by(20) {
            unit.poll(now_ms, op, &mut rng, faults);
        }
        from_ms + 400
    }

    fn op(seq: u8, param: u16, write: Option<i32>) -> Option<UnitOp> {
        Some(UnitOp { seq, param, write })
    }

    #[test]
    fn parameters_are_read_and_written() {
        let mut unit = RemoteUnit::new(Unit::Vertical);
        let faults = Faults::default();
        let speed = ParamId::of("Speed").0;
        let now = run(&mut unit, 0, op(1, speed, Some(7)), &faults);
        let reply = |unit: &RemoteUnit, now| unit.sense(now, &Faults::default()).reply;
        assert_eq!(reply(&unit, now), Some(UnitReply { seq: 1, result: Ok(7) }));
        let now = run(&mut unit, now, op(2, speed, None), &faults);
        assert_eq!(reply(&unit, now), Some(UnitReply { seq: 2, result: Ok(7) }));
        let now = run(&mut unit, now, op(3, 0x1234, None), &faults);
        assert_eq!(reply(&unit, now).unwrap().result, Err(UnitError::BadId));
        let now = run(&mut unit, now, op(4, speed, Some(100_000)), &faults);
        assert_eq!(reply(&unit, now).unwrap().result, Err(UnitError::BadValue));
    }

    #[test]
    fn a_reply_takes_its_time() {
        let mut unit = RemoteUnit::new(Unit::Valve1);
        let (faults, mut rng) = (Faults::default(), Rng::new(1));
        let travel = op(9, ParamId::of("TravelTime").0, None);
        for now_ms in [0, 20, 40] {
            assert!(unit.poll(now_ms, travel, &mut rng, &faults));
            assert_eq!(unit.sense(now_ms, &faults).reply, None);
        }
        unit.poll(60, travel, &mut rng, &faults);
        assert!(unit.sense(60, &faults).reply.is_some());
    }

    #[test]
    fn loss_of_connection() {
        let mut unit = RemoteUnit::new(Unit::Nozzle);
        let mut faults = Faults::default();
        let now = run(&mut unit, 0, None, &faults);
        assert!(unit.sense(now, &faults).online && !unit.abandoned(now));
        faults.inject(Fault::Unit(Unit::Nozzle, UnitFault::Offline));
        let now = run(&mut unit, now, None, &faults);
        assert!(!unit.sense(now, &faults).online && unit.abandoned(now));
        faults.clear_all();
        faults.inject(Fault::Unit(Unit::Nozzle, UnitFault::Lossy));
        let now = run(&mut unit, now, None, &faults);
        assert!(unit.sense(now, &faults).online, "half of the exchanges are enough");
        faults.inject(Fault::Unit(Unit::Nozzle, UnitFault::Protocol));
        let now = run(&mut unit, now, None, &faults);
        assert!(unit.sense(now, &faults).protocol_fault && unit.abandoned(now));
    }
}
