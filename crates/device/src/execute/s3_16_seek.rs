//! §3.16 StartSeek: `subsystem/detector.rs` does it.

use crate::cause::Asked;
use crate::device::Device;
use crate::time::Millis;
use lafet_proto::Status;
use lafet_proto::request::Seek;

impl Device {
    #[inline(always)]
    pub(super) fn start_seek(&mut self, now: Millis, seek: &Seek, by: Asked) -> Status {
        let (_, detector, env) = self.programs();
        let status = detector.start_seek(seek, by, &env);
        self.begin_program(now, status, by)
    }
}
