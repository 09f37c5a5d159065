//! §3.1 Move: `subsystem/drive.rs` does it.

use crate::cause::Asked;
use crate::device::Device;
use crate::subsystem::deployer::is_straight;
use crate::time::Millis;
use lafet_proto::param::Param;
use lafet_proto::{Status, SubsystemId};

impl Device {
    /// §3.1
    pub(super) fn move_to(
        &mut self,
        now: Millis,
        id: SubsystemId,
        destination: i16,
        by: Asked,
    ) -> Status {
        // §D/4
        let timeout_ms = self.params.get(Param::GeneralMoveTimeout).unsigned_abs();
        let straight = id != SubsystemId::DEPLOYER || is_straight(&self.drives);
        let Some(drive) = self.drive_mut(id) else { return Status::SYSTEM_FAULT };
        // §3.1/9 As Wrap: a barrel that is turned aside is not folded.
        if !straight && drive.way(destination.into()).is_lt() && !drive.refuses(false) {
            return Status::DENIED;
        }
        let status = drive.move_to(now, destination.into(), timeout_ms, by);
        let idle = drive.is_idle();
        if status.is_success() {
            if id == SubsystemId::DEPLOYER {
                // Where nothing moves it is where it was.
                if !idle {
                    self.deployer.note_move();
                }
            } else {
                // §3.1/3
                self.control.note_manual(now);
            }
        }
        status
    }
}
