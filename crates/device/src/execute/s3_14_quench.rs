//! §3.14 StartQuench: `subsystem/control.rs` does it.

use crate::cause::Asked;
use crate::device::Device;
use crate::time::Millis;
use lafet_proto::Status;
use lafet_proto::request::Quench;

impl Device {
    #[inline(always)]
    pub(super) fn start_quench(&mut self, now: Millis, quench: &Quench<'_>, by: Asked) -> Status {
        let (control, _, env) = self.programs();
        let status = control.start_quench(quench, by, &env);
        self.begin_extinguishing(now, status, by)
    }
}
