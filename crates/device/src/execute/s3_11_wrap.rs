//! §3.11 Wrap: `subsystem/deployer.rs` does it.

use crate::cause::Asked;
use crate::device::Device;
use crate::time::Millis;
use lafet_proto::Status;

impl Device {
    #[inline(always)]
    pub(super) fn wrap(&mut self, now: Millis, by: Asked) -> Status {
        let status = self.deployer.wrap(now, &mut self.drives, &self.params, by);
        if status == Status::ACCEPTED {
            // §3.11/7 The program ends: it must not aim a folding barrel.
            self.control.stop();
        }
        status
    }
}
