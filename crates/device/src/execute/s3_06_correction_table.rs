//! §3.6 SetupCorrectionTable.

use crate::device::Device;
use lafet_proto::{Bytes, Status};

impl Device {
    #[inline(always)]
    pub(super) fn set_corrections(&mut self, first: u8, corrections: Bytes<'_>) -> Status {
        self.params.set_corrections(first, corrections)
    }
}
