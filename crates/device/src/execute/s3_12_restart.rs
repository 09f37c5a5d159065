//! §3.12 Restart: `subsystem/general.rs` resets when all have ended.

use crate::cause::{Asked, Cause};
use crate::device::Device;
use crate::subsystem::general::Reset;
use crate::time::Millis;
use lafet_proto::Status;
use lafet_proto::param::Param;

impl Device {
    /// §3.12/1
    #[inline(always)]
    pub(super) fn restart(&mut self, now: Millis, by: Asked) -> Status {
        // §D/2
        if self.params.get(Param::GeneralResetValves) == 0 {
            self.close_everything(now, Cause::Request(by));
        } else {
            self.stop_motion(false, Cause::Request(by));
            // What closes goes on, and so it does behind the reset.
            self.valves.iter_mut().for_each(|valve| valve.end_opening(Cause::Request(by)));
        }
        self.general.schedule(now, Reset::Restart);
        Status::OK
    }
}
