//! §3.8 Open.

use crate::cause::{Asked, Cause};
use crate::device::Device;
use crate::time::Millis;
use lafet_proto::id::key;
use lafet_proto::{Status, SubsystemId};

impl Device {
    #[inline(always)]
    pub(super) fn open_keyed(&mut self, now: Millis, key: u16, by: Asked) -> Status {
        // §3.8/6
        if key != key::OPEN {
            return Status::NEED_CONFIRM;
        }
        let [valve1, valve2] = &mut self.valves;
        let valve = if by.to == SubsystemId::VALVE1 { valve1 } else { valve2 };
        valve.open(now, &self.params, Cause::Request(by))
    }
}
