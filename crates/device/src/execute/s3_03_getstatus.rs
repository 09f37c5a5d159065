//! §3.3 GetStatus, and the common flags (§3.3.1); the flags of a class are its subsystem's.

use crate::answers::Answers;
use crate::device::Device;
use crate::subsystem::drive::Drive;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{
    ButtonsFlags, CommonFlags, ConnFlags, ControlFlags, DetectorFlags, DriveFlags, ValveFlags,
};
use lafet_proto::status::{ControlStatus, DetectorStatus};
use lafet_proto::{Answer, RequestId, Status, SubsystemId};

impl Device {
    /// §3.3
    pub(crate) fn tell_status(&self, from: SubsystemId, answers: &mut Answers<'_>) {
        let (request, status) = (RequestId::GET_STATUS, Status::OK);
        answers.push(&Answer { from, request, status, data: self.status_of(from) });
    }

    fn status_of(&self, id: SubsystemId) -> Reply<'static> {
        let common = self.common_flags(id);
        let bits = common.bits();
        match id {
            SubsystemId::GENERAL => Reply::General(self.general.status(bits)),
            SubsystemId::CLIMATICS => Reply::Thermo(self.climatics.status(bits)),
            SubsystemId::CONTROL => {
                let flags = self.control.flags() | ControlFlags::from_bits_retain(bits);
                Reply::Control(ControlStatus { flags })
            }
            SubsystemId::DETECTOR => {
                let flags = self.detector.flags() | DetectorFlags::from_bits_retain(bits);
                Reply::Detector(DetectorStatus { flags })
            }
            SubsystemId::DEPLOYER => {
                let [.., drive] = &self.drives;
                Reply::Deployer(self.deployer.status(drive, bits))
            }
            SubsystemId::EXTERNAL_CONN | SubsystemId::RADIO => {
                let external = id == SubsystemId::EXTERNAL_CONN;
                let conn = if external { &self.external_conn } else { &self.radio };
                let mut status = conn.status();
                status.flags |= ConnFlags::from_bits_retain(bits);
                Reply::Conn(status)
            }
            SubsystemId::BUTTONS | SubsystemId::EXT_BUTTONS => {
                let post = id == SubsystemId::BUTTONS;
                let post = if post { &self.buttons } else { &self.ext_buttons };
                let mut status = post.status();
                status.flags |= ButtonsFlags::from_bits_retain(bits);
                Reply::Buttons(status)
            }
            _ => self.status_of_motor(id, bits),
        }
    }

    fn status_of_motor(&self, id: SubsystemId, common: u32) -> Reply<'static> {
        if let Some(drive) = self.drive(id) {
            let mut status = drive.status();
            status.flags |= DriveFlags::from_bits_retain(common);
            return Reply::Drive(status);
        }
        match self.valve(id) {
            Some(valve) => {
                let mut status = valve.status();
                status.flags |= ValveFlags::from_bits_retain(common);
                Reply::Valve(status)
            }
            None => Reply::None,
        }
    }

    /// §3.3.1 The flags that mean the same in every subsystem.
    fn common_flags(&self, id: SubsystemId) -> CommonFlags {
        let restarting = self.general.is_restarting();
        let moving = || self.drive(id).is_some_and(Drive::is_moving);
        // §3.3.1/4
        let bad_power = id == SubsystemId::GENERAL && self.general.has_bad_power();
        let mut flags = self.config_flags(id);
        flags.set(CommonFlags::BAD_POWER, bad_power);
        flags.set(CommonFlags::RESTARTING, restarting);
        flags.set(CommonFlags::TERMINATED, restarting && !moving());
        flags
    }

    /// No culprit is looked for while all is well.
    fn config_flags(&self, id: SubsystemId) -> CommonFlags {
        let mut flags = CommonFlags::empty();
        if self.params.is_sound() {
            flags.set(CommonFlags::CONFIG_INVALID, self.params.is_contradictory(id));
            return flags;
        }
        // §3.3.1/1
        flags.set(CommonFlags::CONFIG_FAULT, self.params.has_read_fault(id));
        // §3.3.1/2
        let invalid = self.params.is_incomplete(id) || self.params.is_contradictory(id);
        flags.set(CommonFlags::CONFIG_INVALID, invalid);
        flags.set(CommonFlags::CONFIG_WRITE_FAULT, self.params.has_write_fault(id));
        flags
    }
}
