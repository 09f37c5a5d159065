//! §3.7 RetrieveLimits.

use crate::device::Device;
use lafet_proto::SubsystemId;
use lafet_proto::status::Limits;

impl Device {
    /// §3.7/1 The limits of a drive; `None` for what is no drive.
    #[inline(always)]
    pub(super) fn limits_of(&self, id: SubsystemId) -> Option<Limits> {
        self.drive(id).map(|drive| drive.retrieve_limits())
    }
}
