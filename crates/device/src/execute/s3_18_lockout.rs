//! §3.18 Lockout.

use crate::cause::{Asked, Cause};
use crate::device::Device;
use crate::subsystem::valve::Valve;
use crate::time::Millis;
use lafet_proto::Status;
use lafet_proto::id::key;

impl Device {
    #[inline(always)]
    pub(super) fn lockout(&mut self, now: Millis, key: u16, by: Asked) -> Status {
        match key {
            // §3.18/1
            key::ENABLE => {
                self.close_everything(now, Cause::Request(by));
                self.valves.iter_mut().for_each(Valve::note_lockout);
                self.general.set_locked(true);
                self.params.set_lockout(true);
                Status::OK
            }
            #[cfg(feature = "update")]
            key::DISABLE if self.software.keeps_locked() => Status::DENIED,
            // §3.18/4
            key::DISABLE => {
                self.general.set_locked(false);
                self.params.set_lockout(false);
                Status::OK
            }
            // §3.18/5
            _ => Status::INVALID_VALUE,
        }
    }
}
