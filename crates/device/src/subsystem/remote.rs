//! Remote units of the explosion-proof execution: access to their parameters over the internal bus.
//!
//! One operation is under way at a time. NotCached and Cached (§2) ask the client to come again.

use crate::image::{UnitError, UnitInput, UnitOp};
use lafet_proto::ParamId;
use lafet_proto::flags::DriveFlags;

/// How long what a unit has said counts as its value (ours).
const FRESH_MS: u16 = 5000;
/// Parameters of one unit that are asked for at a time: as many as any unit keeps.
const READS: usize = 8;

/// This side of the internal bus to one unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Link {
    op: Option<UnitOp>,
    seq: u8,
    reads: [Option<Read>; READS],
    write: Option<Write>,
    error: Option<UnitError>,
}

/// A parameter that a client wants to read.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Read {
    param: u16,
    age_ms: u16,
    /// What the unit has said; `None` until then.
    value: Option<i32>,
}

/// A value that a client wants to write.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Write {
    param: u16,
    value: i32,
    /// The unit has taken it, which is not reported yet.
    taken: bool,
    age_ms: u16,
}

impl Link {
    /// §3.4/2 The value of a parameter, once the unit has sent it; asks for it otherwise.
    pub(crate) fn read(&mut self, id: ParamId) -> Option<i32> {
        if let Some(read) = self.reads.iter().flatten().find(|read| read.param == id.0) {
            return read.value;
        }
        // An empty place, or that of the oldest value.
        let age = |place: &&mut Option<Read>| place.map_or(u32::MAX, |read| read.age_ms.into());
        if let Some(place) = self.reads.iter_mut().max_by_key(age) {
            *place = Some(Read { param: id.0, value: None, age_ms: 0 });
        }
        None
    }

    /// §3.5/7 Whether the unit has taken this value; sends it otherwise, one at a time.
    pub(crate) fn write(&mut self, id: ParamId, value: i32) -> bool {
        match self.write {
            Some(write) if write.taken && (write.param, write.value) == (id.0, value) => {
                self.write = None;
                return true;
            }
            Some(Write { taken: false, .. }) => {}
            Some(_) | None => {
                self.write = Some(Write { param: id.0, value, taken: false, age_ms: 0 });
            }
        }
        false
    }

    /// The operation under way, for the outputs.
    pub(crate) const fn op(&self) -> Option<UnitOp> {
        self.op
    }

    /// Takes the unit's side; returns the common flags (§3.3.1) that it leads to.
    pub(crate) fn step(&mut self, dt_ms: u32, unit: &UnitInput) -> u32 {
        self.age(dt_ms);
        if !unit.online {
            // A later request must not be answered with old values, nor may a write happen much later.
            (self.op, self.reads, self.write) = (None, [None; READS], None);
        }
        if let (Some(op), Some(reply)) = (self.op, unit.reply)
            && reply.seq == op.seq
        {
            self.op = None;
            self.error = reply.result.err();
            self.take(op, reply.result.ok());
        }
        if unit.online && self.op.is_none() {
            self.start_next();
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

    fn age(&mut self, dt_ms: u32) {
        let dt_ms = dt_ms.min(u16::MAX.into()) as u16;
        for place in &mut self.reads {
            if let Some(read) = place {
                read.age_ms = read.age_ms.saturating_add(dt_ms);
                if read.value.is_some() && read.age_ms > FRESH_MS {
                    *place = None;
                }
            }
        }
        if let Some(write) = &mut self.write {
            write.age_ms = write.age_ms.saturating_add(dt_ms);
            if write.taken && write.age_ms > FRESH_MS {
                self.write = None;
            }
        }
    }

    /// The unit has answered an operation: with a value, or with an error.
    fn take(&mut self, op: UnitOp, value: Option<i32>) {
        if op.write.is_some() {
            // What has been written is read back at once.
            self.read(ParamId(op.param));
            self.write = self.write.filter(|_| value.is_some());
            if let Some(write) = &mut self.write {
                (write.taken, write.age_ms) = (true, 0);
            }
        }
        for place in &mut self.reads {
            if let Some(read) = place.as_mut().filter(|read| read.param == op.param) {
                (read.value, read.age_ms) = (value, 0);
                if value.is_none() {
                    *place = None;
                }
            }
        }
    }

    /// A write goes first; then what has waited longest.
    fn start_next(&mut self) {
        let write = self.write.filter(|write| !write.taken);
        let waiting = self.reads.iter().flatten().filter(|read| read.value.is_none());
        let next = match write {
            Some(write) => Some((write.param, Some(write.value))),
            None => waiting.max_by_key(|read| read.age_ms).map(|read| (read.param, None)),
        };
        if let Some((param, write)) = next {
            self.seq = self.seq.wrapping_add(1);
            self.op = Some(UnitOp { seq: self.seq, param, write });
        }
    }
}
