//! §3.9 Close.

use crate::cause::{Asked, Cause};
use crate::device::Device;
use crate::time::Millis;
use lafet_proto::id::key;
use lafet_proto::{Status, SubsystemId};

impl Device {
    #[inline(always)]
    pub(super) fn close_keyed(&mut self, now: Millis, key: u16, by: Asked) -> Status {
        // §3.9/5
        if key != key::CLOSE {
            return Status::NEED_CONFIRM;
        }
        let [valve1, valve2] = &mut self.valves;
        let valve = if by.to == SubsystemId::VALVE1 { valve1 } else { valve2 };
        valve.close(now, &self.params, Cause::Request(by))
    }
}
