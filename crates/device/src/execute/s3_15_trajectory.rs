//! §3.15 StartTrajectory: `subsystem/control.rs` does it.

use crate::cause::Asked;
use crate::device::Device;
use crate::time::Millis;
use lafet_proto::Status;
use lafet_proto::request::Trajectory;

impl Device {
    #[inline(always)]
    pub(super) fn start_trajectory(
        &mut self,
        now: Millis,
        trajectory: &Trajectory<'_>,
        by: Asked,
    ) -> Status {
        let (control, _, env) = self.programs();
        let status = control.start_trajectory(trajectory, by, &env);
        self.begin_extinguishing(now, status, by)
    }
}
