//! §3.19 CleanFlash: `subsystem/general.rs` erases when all have ended.

use crate::cause::{Asked, Cause};
use crate::device::Device;
use crate::subsystem::general::Reset;
use crate::time::Millis;
use lafet_proto::Status;
use lafet_proto::id::key;

impl Device {
    #[inline(always)]
    pub(super) fn clean_flash(&mut self, now: Millis, key: u16, by: Asked) -> Status {
        match key {
            // §3.19/1, §3.19/2
            key::CLEAN_FLASH => {
                self.close_everything(now, Cause::Request(by));
                self.general.schedule(now, Reset::CleanFlash);
                Status::OK
            }
            _ => Status::NEED_CONFIRM,
        }
    }
}
