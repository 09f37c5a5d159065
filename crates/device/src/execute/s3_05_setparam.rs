//! §3.5 SetParam.

use super::drive_param;
use crate::answers::Answers;
use crate::cause::Asked;
use crate::device::Device;
use crate::image::Axis;
use crate::subsystem::by_axis;
use crate::time::Millis;
use lafet_proto::answer::Reply;
use lafet_proto::param::{Access, DriveParam, Param, Placement};
use lafet_proto::{Answer, Ints, ParamId, RequestId, Status, SubsystemId};

impl Device {
    #[inline(always)]
    pub(super) fn set_param(
        &mut self,
        now: Millis,
        from: SubsystemId,
        id: ParamId,
        values: Ints<'_>,
        by: Asked,
        answers: &mut Answers<'_>,
    ) {
        let request = RequestId::SET_PARAM;
        let status = self.write_param(now, from, id, values, by);
        let data = match status {
            Status::WRONG_DATA => Reply::None,
            _ => Reply::Param { id, values: Ints::Values(&[]) },
        };
        answers.push(&Answer { from, request, status, data });
    }

    /// §3.5: order of checks in docs/questions.md.
    #[inline(never)]
    fn write_param(
        &mut self,
        now: Millis,
        id: SubsystemId,
        param: ParamId,
        values: Ints<'_>,
        by: Asked,
    ) -> Status {
        // §3.5/2
        let Some(param) = Param::find(id, param) else { return Status::INVALID_ID };
        // §U/9
        #[cfg(feature = "update")]
        if crate::software::is_of_it(param) && !self.software.is_present() {
            return Status::INVALID_ID;
        }
        let spec = param.kind();
        // §3.5/5, §3.21/3
        if spec.access == Access::ReadOnly {
            return Status::ACCESS_DENIED;
        }
        // §3.5/4, §3.5/3
        if let Err(status) = spec.check(values.iter()) {
            return status;
        }
        let first = values.get(0).unwrap_or(0);
        if let Some((axis, which)) = drive_param(param) {
            let timeout_ms = self.params.get(Param::GeneralMoveTimeout).unsigned_abs();
            let drive = by_axis(&mut self.drives, axis);
            if which != DriveParam::MoveHold {
                return drive.set_param(which, first, &mut self.params, by);
            }
            // §D/4, §3.1/3 Held on, it is moved by hand as by a Move.
            if drive.hold(now, first.unsigned_abs(), timeout_ms) && axis != Axis::Deployer {
                self.control.note_manual(now);
            }
            return Status::OK;
        }
        let unit = (spec.placement == Placement::Unit).then(|| self.remote_link(id));
        // §3.5/7
        if unit.flatten().is_some_and(|unit| !unit.write(param.id(), first)) {
            return Status::CACHED;
        }
        if param == Param::GeneralWaterTimeout {
            // §D/8
            self.confirm_water();
        }
        self.params.write(param, values)
    }
}
