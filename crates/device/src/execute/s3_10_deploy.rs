//! §3.10 Deploy: `subsystem/deployer.rs` does it.

use crate::cause::Asked;
use crate::device::Device;
use crate::time::Millis;
use lafet_proto::Status;

impl Device {
    #[inline(always)]
    pub(super) fn deploy(&mut self, now: Millis, by: Asked) -> Status {
        self.deployer.deploy(now, &mut self.drives, &self.params, by)
    }
}
