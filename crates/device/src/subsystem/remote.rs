//! Remote units of the explosion-proof execution: access to their parameters over the internal bus.
//!
//! One operation is under way at a time. NotCached and Cached (§2) ask the client to come again.

use crate::image::{UnitError, UnitInput, UnitOp};
use lafet_proto::ParamId;
use lafet_proto::flags::DriveFlags;

/// How long what a unit has said counts as its value (ours).
const FRESH_MS: u32 = 5000;

/// This side of the internal bus to one unit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Link {
    op: Option<UnitOp>,
    seq: u8,
    /// The last answer, until it is stale; that to a write, until it has been told.
    done: Option<(UnitOp, i32)>,
    age_ms: u32,
    error: Option<UnitError>,
}

impl Link {
    /// §3.4/2 The value of a parameter, once the unit has sent it; asks for it otherwise.
    pub(crate) fn read(&mut self, id: ParamId) -> Option<i32> {
        match self.done {
            Some((UnitOp { param, .. }, value)) if param == id.0 => Some(value),
            _ => {
                self.start(id, None);
                None
            }
        }
    }

    /// §3.5/7 Whether the unit has taken this value; sends it otherwise.
    pub(crate) fn write(&mut self, id: ParamId, value: i32) -> bool {
        match self.done {
            Some((UnitOp { param, write: Some(written), .. }, _))
                if param == id.0 && written == value =>
            {
                self.done = None;
                true
            }
            _ => {
                self.start(id, Some(value));
                false
            }
        }
    }

    /// The operation under way, for the outputs.
    pub(crate) const fn op(&self) -> Option<UnitOp> {
        self.op
    }

    /// Takes the unit's side; returns the common flags (§3.3.1) that it leads to.
    pub(crate) fn step(&mut self, dt_ms: u32, unit: &UnitInput) -> u32 {
        self.age_ms = self.age_ms.saturating_add(dt_ms);
        if self.age_ms > FRESH_MS {
            self.done = None;
        }
        if !unit.online {
            // Whoever comes again must not be told old values, nor may a write happen much later.
            (self.op, self.done) = (None, None);
        }
        if let (Some(op), Some(reply)) = (self.op, unit.reply)
            && reply.seq == op.seq
        {
            self.op = None;
            self.error = reply.result.err();
            self.done = reply.result.ok().map(|value| (op, value));
            self.age_ms = 0;
        }
        // §3.3.1/3
        let mut flags = DriveFlags::empty();
        flags.set(DriveFlags::PROTOCOL_FAULT, unit.protocol_fault);
        flags.set(DriveFlags::WDT_FAULT, unit.watchdog_reset);
        flags.set(DriveFlags::REMOTE_PA_INCOMPLETE, self.error == Some(UnitError::Incomplete));
        flags.set(DriveFlags::REMOTE_PA_BAD_ID, self.error == Some(UnitError::BadId));
        flags.set(DriveFlags::REMOTE_PA_BAD_VAL, self.error == Some(UnitError::BadValue));
        flags.set(DriveFlags::REMOTE_PA_ERROR, self.error == Some(UnitError::Internal));
        flags.bits()
    }

    fn start(&mut self, id: ParamId, write: Option<i32>) {
        if self.op.is_none() {
            self.seq = self.seq.wrapping_add(1);
            self.op = Some(UnitOp { seq: self.seq, param: id.0, write });
        }
    }
}
