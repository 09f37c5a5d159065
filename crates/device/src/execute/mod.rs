//! What each request does once the chain has let it through (§3.1–§3.21).
//!
//! Each request has a file with the number of its section. What is in them is inlined here: most of
//! it is a call of the subsystem that does the work.

mod s3_01_move;
mod s3_02_stop;
mod s3_03_getstatus;
mod s3_04_getparam;
mod s3_05_setparam;
mod s3_06_correction_table;
mod s3_07_retrieve_limits;
mod s3_08_open;
mod s3_09_close;
mod s3_10_deploy;
mod s3_11_wrap;
mod s3_12_restart;
mod s3_13_justify;
mod s3_14_quench;
mod s3_15_trajectory;
mod s3_16_seek;
mod s3_17_switch_limits;
mod s3_18_lockout;
mod s3_19_clean_flash;
mod s3_20_crash_data;
mod s3_21_hotbeds;

use crate::answers::Answers;
use crate::cause::{Asked, Cause};
use crate::device::Device;
use crate::image::Axis;
use crate::subsystem::drive::Drive;
use crate::subsystem::valve::Valve;
use crate::subsystem::{by_axis, of_axis, remote};
use crate::time::Millis;
use lafet_proto::answer::Reply;
use lafet_proto::flags::ValveFlags;
use lafet_proto::param::{DriveParam, Param};
use lafet_proto::request::Body;
use lafet_proto::{Answer, RequestId, Status, SubsystemId};

impl Device {
    /// Executes a request that concerns one subsystem, and answers as it.
    pub(crate) fn execute(
        &mut self,
        now: Millis,
        id: SubsystemId,
        body: &Body<'_>,
        by: Asked,
        answers: &mut Answers<'_>,
    ) {
        let request = body.id();
        let status = match body {
            Body::GetStatus => return self.tell_status(id, answers),
            Body::GetParam { id: param } => return self.tell_param(id, request, *param, answers),
            Body::SetParam { id: param, values } => {
                return self.set_param(now, id, *param, *values, by, answers);
            }
            Body::GetHotbed => return self.tell_hotbeds(id, answers),
            Body::RetrieveLimits => match self.limits_of(id) {
                Some(limits) => {
                    let data = Reply::Limits(limits);
                    return answers.push(&Answer { from: id, request, status: Status::OK, data });
                }
                None => Status::SYSTEM_FAULT,
            },
            Body::GetCrashData => {
                let data = self.crash_data();
                return answers.push(&Answer { from: id, request, status: Status::OK, data });
            }
            other => self.command(now, id, other, by),
        };
        answers.bare(id, request, status);
    }

    /// Requests answered with a status alone.
    #[inline(never)]
    fn command(&mut self, now: Millis, id: SubsystemId, body: &Body<'_>, by: Asked) -> Status {
        match body {
            Body::Move { destination } => self.move_to(now, id, *destination, by),
            Body::Stop => self.stop(id, by),
            Body::SetupCorrectionTable { first, corrections } => {
                self.set_corrections(*first, *corrections)
            }
            Body::Open { key } => self.open_keyed(now, *key, by),
            Body::Close { key } => self.close_keyed(now, *key, by),
            Body::Deploy => self.deploy(now, by),
            Body::Wrap => self.wrap(now, by),
            Body::StartJustify => self.start_justify(now, by),
            Body::StartQuench(quench) => self.start_quench(now, quench, by),
            Body::StartTrajectory(trajectory) => self.start_trajectory(now, trajectory, by),
            Body::StartSeek(seek) => self.start_seek(now, seek, by),
            Body::SwitchLimits { new_state } => self.switch_limits(id, *new_state, by),
            Body::CleanFlash { key } => self.clean_flash(now, *key, by),
            _ => Status::UNIMPLEMENTED,
        }
    }

    /// Stop, Restart and Lockout of everything at once; `None` for other requests, and for those
    /// that each subsystem executes by itself.
    pub(crate) fn execute_as_a_whole(
        &mut self,
        now: Millis,
        body: &Body<'_>,
        motors: bool,
        by: Asked,
    ) -> Option<Status> {
        Some(match body {
            Body::Stop => self.stop_as_a_whole(motors, by),
            Body::Restart => self.restart(now, by),
            Body::Lockout { key } => self.lockout(now, *key, by),
            _ => return None,
        })
    }

    /// A subsystem's part of what was done as a whole: a valve that closes has only accepted it,
    /// and so has General a lockout that is not stored yet (§3.18/8). One that rests does not close (§3.3.5).
    pub(crate) fn part_of_whole(
        &self,
        id: SubsystemId,
        request: RequestId,
        status: Status,
    ) -> Status {
        let locking = id == SubsystemId::GENERAL && request == RequestId::LOCKOUT;
        let closing = self
            .valve(id)
            .is_some_and(|valve| valve.flags().contains(ValveFlags::CLOSING) && !valve.is_closed());
        let storing = locking && !self.params.lockout_is_stored();
        let locked = request == RequestId::LOCKOUT && self.general.is_locked();
        if locked && status == Status::OK && self.valve(id).is_some_and(Valve::rests) {
            return Status::MODULE_FAULT;
        }
        if (closing || storing) && status == Status::OK { Status::ACCEPTED } else { status }
    }

    /// What was accepted has the drives from now on, wherever it goes first: nothing could stop a
    /// Move that went on any more (§3.2/3, §3.2/4). While folded it deploys first (§3.14/5, §3.16/3).
    fn begin_program(&mut self, now: Millis, status: Status, by: Asked) -> Status {
        if status.is_success() {
            self.end_moves(Cause::Request(by));
            if !self.is_deployed() {
                self.deployer.deploy(now, &mut self.drives, &self.params, by);
            }
        }
        status
    }

    /// §D/8 Who extinguishes wants the water.
    fn begin_extinguishing(&mut self, now: Millis, status: Status, by: Asked) -> Status {
        if status.is_success() {
            self.confirm_water();
        }
        self.begin_program(now, status, by)
    }

    fn remote_link(&mut self, id: SubsystemId) -> Option<&mut remote::Link> {
        if let Some(axis) = axis_of(id) {
            let drive = by_axis(&mut self.drives, axis);
            return drive.is_remote().then(|| drive.unit());
        }
        let valve = self.valve_mut(id)?;
        valve.is_remote().then(|| valve.unit())
    }

    fn drive(&self, id: SubsystemId) -> Option<&Drive> {
        axis_of(id).map(|axis| of_axis(&self.drives, axis))
    }

    fn drive_mut(&mut self, id: SubsystemId) -> Option<&mut Drive> {
        axis_of(id).map(|axis| by_axis(&mut self.drives, axis))
    }

    fn valve(&self, id: SubsystemId) -> Option<&Valve> {
        let [valve1, valve2] = &self.valves;
        match id {
            SubsystemId::VALVE1 => Some(valve1),
            SubsystemId::VALVE2 => Some(valve2),
            _ => None,
        }
    }

    fn valve_mut(&mut self, id: SubsystemId) -> Option<&mut Valve> {
        let [valve1, valve2] = &mut self.valves;
        match id {
            SubsystemId::VALVE1 => Some(valve1),
            SubsystemId::VALVE2 => Some(valve2),
            _ => None,
        }
    }
}

pub(crate) fn axis_of(id: SubsystemId) -> Option<Axis> {
    Axis::ALL.iter().copied().find(|axis| axis.id() == id)
}

/// The drive and the common drive parameter that a parameter is.
fn drive_param(param: Param) -> Option<(Axis, DriveParam)> {
    const ALL: [DriveParam; 13] = [
        DriveParam::MinLimit,
        DriveParam::MaxLimit,
        DriveParam::ZeroPoint,
        DriveParam::Speed,
        DriveParam::Acceleration,
        DriveParam::MaxCurrent,
        DriveParam::SlowCurrent,
        DriveParam::DriveType,
        DriveParam::MoveHold,
        DriveParam::StopLag,
        DriveParam::MinSpeed,
        DriveParam::StopLagSeen,
        DriveParam::MinSpeedSeen,
    ];
    let axis = axis_of(param.subsystem())?;
    let first = Param::of_drive(axis.id(), DriveParam::MinLimit)?;
    let which = ALL.get((param as usize).checked_sub(first as usize)?)?;
    Some((axis, *which))
}
