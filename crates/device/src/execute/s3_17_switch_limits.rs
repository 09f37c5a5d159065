//! §3.17 SwitchLimits: `subsystem/drive.rs` does it.

use super::axis_of;
use crate::cause::Asked;
use crate::device::Device;
use crate::subsystem::by_axis;
use lafet_proto::request::LimitsState;
use lafet_proto::{Status, SubsystemId};

impl Device {
    pub(super) fn switch_limits(&mut self, id: SubsystemId, new_state: u16, by: Asked) -> Status {
        let Some(state) = LimitsState::from_wire(new_state) else {
            return Status::INVALID_VALUE;
        };
        let Some(axis) = axis_of(id) else { return Status::SYSTEM_FAULT };
        by_axis(&mut self.drives, axis).switch_limits(state, &mut self.params, by)
    }
}
