//! §3.2 Stop.

use super::axis_of;
use crate::cause::{Asked, Cause};
use crate::device::Device;
use crate::subsystem::control::{self, approach};
use crate::subsystem::detector;
use lafet_proto::{Status, SubsystemId};

impl Device {
    /// §3.2/2–§3.2/5
    pub(super) fn stop(&mut self, id: SubsystemId, by: Asked) -> Status {
        let why = Cause::Request(by);
        match id {
            SubsystemId::CONTROL => {
                self.control.stop();
                approach::stop(&mut self.drives, &control::PROGRAMS, why);
                return Status::OK;
            }
            SubsystemId::DETECTOR => {
                self.detector.stop();
                approach::stop(&mut self.drives, &detector::PROGRAMS, why);
                return Status::OK;
            }
            SubsystemId::DEPLOYER => self.deployer.stop(&mut self.drives, why),
            _ => {}
        }
        if let Some(axis) = axis_of(id) {
            self.buttons.disarm(axis);
            self.ext_buttons.disarm(axis);
        }
        if let Some(drive) = self.drive_mut(id) {
            drive.stop(why);
            return if drive.is_faulty() { Status::MODULE_FAULT } else { Status::OK };
        }
        match self.valve_mut(id) {
            Some(valve) => {
                valve.stop(why);
                if valve.is_faulty() { Status::MODULE_FAULT } else { Status::OK }
            }
            None => Status::SYSTEM_FAULT,
        }
    }

    /// §3.2/1, §1/6 Everything, or the drives alone.
    #[inline(always)]
    pub(super) fn stop_as_a_whole(&mut self, motors: bool, by: Asked) -> Status {
        self.stop_motion(!motors, Cause::Request(by));
        Status::OK
    }
}
