//! §3.13 StartJustify: `subsystem/detector.rs` does it.

use crate::cause::Asked;
use crate::device::Device;
use crate::time::Millis;
use lafet_proto::Status;

impl Device {
    #[inline(always)]
    pub(super) fn start_justify(&mut self, now: Millis, by: Asked) -> Status {
        let (_, detector, env) = self.programs();
        let status = detector.start_justify(by, &env);
        self.begin_program(now, status, by)
    }
}
