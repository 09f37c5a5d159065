//! What each request does once the chain has let it through (§3.1–§3.21).

use crate::answers::Answers;
use crate::cause::{Asked, Cause};
use crate::device::Device;
use crate::image::Axis;
use crate::params::VALUES_MAX;
use crate::subsystem::control::{self, approach};
use crate::subsystem::detector;
use crate::subsystem::drive::Drive;
use crate::subsystem::general::Reset;
use crate::subsystem::valve::Valve;
use crate::subsystem::{by_axis, of_axis, remote};
use crate::time::Millis;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{
    ButtonsFlags, CommonFlags, ConnFlags, ControlFlags, DetectorFlags, DriveFlags, ValveFlags,
};
use lafet_proto::id::key;
use lafet_proto::param::{Access, DriveParam, Param, Placement};
use lafet_proto::request::{Body, LimitsState};
use lafet_proto::status::{ControlStatus, DetectorStatus, Hotbed};
use lafet_proto::{Answer, Ints, ParamId, RequestId, Status, SubsystemId};

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
                let status = self.write_param(now, id, *param, *values, by);
                let data = match status {
                    Status::WRONG_DATA => Reply::None,
                    _ => Reply::Param { id: *param, values: Ints::Values(&[]) },
                };
                return answers.push(&Answer { from: id, request, status, data });
            }
            // §3.21/2
            Body::GetHotbed => return self.tell_param(id, request, ParamId::HOTBEDS, answers),
            // §3.7/1
            Body::RetrieveLimits => match self.drive(id) {
                Some(drive) => {
                    let data = Reply::Limits(drive.retrieve_limits());
                    return answers.push(&Answer { from: id, request, status: Status::OK, data });
                }
                None => Status::SYSTEM_FAULT,
            },
            // §3.20/1
            Body::GetCrashData => {
                let data = Reply::Fault(self.general.crash());
                return answers.push(&Answer { from: id, request, status: Status::OK, data });
            }
            other => self.command(now, id, other, by),
        };
        answers.bare(id, request, status);
    }

    // Apart: the values must not lie on top of what other requests need.
    #[inline(never)]
    fn tell_param(
        &mut self,
        from: SubsystemId,
        request: RequestId,
        id: ParamId,
        answers: &mut Answers<'_>,
    ) {
        let mut buffer = [0; VALUES_MAX];
        let (status, values) = match self.read_param(from, id, &mut buffer) {
            Ok(values) => (Status::OK, values),
            Err(status) => (status, [].as_slice()),
        };
        let data = Reply::Param { id, values: Ints::Values(values) };
        answers.push(&Answer { from, request, status, data });
    }

    /// Requests answered with a status alone.
    #[inline(never)]
    fn command(&mut self, now: Millis, id: SubsystemId, body: &Body<'_>, by: Asked) -> Status {
        match body {
            Body::Move { destination } => self.move_to(now, id, *destination, by),
            Body::Stop => self.stop(id, by),
            Body::Open { key } | Body::Close { key } => {
                let open = matches!(body, Body::Open { .. });
                self.work_valve(now, by, open, *key)
            }
            // §3.10
            Body::Deploy => self.deployer.deploy(now, &mut self.drives, &self.params, by),
            // §3.11
            Body::Wrap => {
                let status = self.deployer.wrap(now, &mut self.drives, &self.params, by);
                if status == Status::ACCEPTED {
                    // §3.11/7 The program ends: it must not aim a folding barrel.
                    self.control.stop();
                }
                status
            }
            // §3.13
            Body::StartJustify => {
                let (_, detector, env) = self.programs();
                let status = detector.start_justify(by, &env);
                self.begin_program(now, status, by)
            }
            // §3.14
            Body::StartQuench(quench) => {
                let (control, _, env) = self.programs();
                let status = control.start_quench(quench, by, &env);
                self.begin_extinguishing(now, status, by)
            }
            // §3.15
            Body::StartTrajectory(trajectory) => {
                let (control, _, env) = self.programs();
                let status = control.start_trajectory(trajectory, by, &env);
                self.begin_extinguishing(now, status, by)
            }
            // §3.16
            Body::StartSeek(seek) => {
                let (_, detector, env) = self.programs();
                let status = detector.start_seek(seek, by, &env);
                self.begin_program(now, status, by)
            }
            // §3.6
            Body::SetupCorrectionTable { first, corrections } => {
                self.params.set_corrections(*first, *corrections)
            }
            // §3.17
            Body::SwitchLimits { new_state } => self.switch_limits(id, *new_state, by),
            // §3.19/1, §3.19/2
            Body::CleanFlash { key: key::CLEAN_FLASH } => {
                self.close_everything(now, Cause::Request(by));
                self.general.schedule(now, Reset::CleanFlash);
                Status::OK
            }
            Body::CleanFlash { .. } => Status::NEED_CONFIRM,
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
            // §3.2/1, §1/6
            Body::Stop => {
                self.stop_motion(!motors, Cause::Request(by));
                Status::OK
            }
            // §3.12/1
            Body::Restart => {
                // §D/2
                if self.params.get(Param::GeneralResetValves) == 0 {
                    self.close_everything(now, Cause::Request(by));
                } else {
                    self.stop_motion(true, Cause::Request(by));
                }
                self.general.schedule(now, Reset::Restart);
                Status::OK
            }
            // §3.18/1
            Body::Lockout { key: key::ENABLE } => {
                self.close_everything(now, Cause::Request(by));
                self.general.set_locked(true);
                self.params.set_lockout(true);
                Status::OK
            }
            // §3.18/4
            Body::Lockout { key: key::DISABLE } => {
                self.general.set_locked(false);
                self.params.set_lockout(false);
                Status::OK
            }
            // §3.18/5
            Body::Lockout { .. } => Status::INVALID_VALUE,
            _ => return None,
        })
    }

    /// A subsystem's part of what was done as a whole: a valve that closes has only accepted it,
    /// and so has General a lockout that is not stored yet (§3.18/8).
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
        if (closing || storing) && status == Status::OK { Status::ACCEPTED } else { status }
    }

    /// §3.1
    fn move_to(&mut self, now: Millis, id: SubsystemId, destination: i16, by: Asked) -> Status {
        // §D/4
        let timeout_ms = self.params.get(Param::GeneralMoveTimeout).unsigned_abs();
        let Some(drive) = self.drive_mut(id) else { return Status::SYSTEM_FAULT };
        let status = drive.move_to(now, destination.into(), timeout_ms, by);
        if status.is_success() {
            if id == SubsystemId::DEPLOYER {
                self.deployer.note_move();
            } else {
                // §3.1/3
                self.control.note_manual(now);
            }
        }
        status
    }

    /// §3.2/2–§3.2/5
    fn stop(&mut self, id: SubsystemId, by: Asked) -> Status {
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
            SubsystemId::DEPLOYER => {
                let [_, _, _, input] = self.inputs.drives;
                self.deployer.stop(&mut self.drives, &input, why);
            }
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

    /// §3.8, §3.9: the key first, then the valve.
    fn work_valve(&mut self, now: Millis, by: Asked, open: bool, key: u16) -> Status {
        // §3.8/6, §3.9/5
        if key != if open { key::OPEN } else { key::CLOSE } {
            return Status::NEED_CONFIRM;
        }
        let [valve1, valve2] = &mut self.valves;
        let valve = if by.to == SubsystemId::VALVE1 { valve1 } else { valve2 };
        let cause = Cause::Request(by);
        if open {
            valve.open(now, &self.params, cause)
        } else {
            valve.close(now, &self.params, cause)
        }
    }

    /// What was accepted has the drives from now on, wherever it goes first: nobody could stop a
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

    fn switch_limits(&mut self, id: SubsystemId, new_state: u16, by: Asked) -> Status {
        let Some(state) = LimitsState::from_wire(new_state) else {
            return Status::INVALID_VALUE;
        };
        let Some(axis) = axis_of(id) else { return Status::SYSTEM_FAULT };
        by_axis(&mut self.drives, axis).switch_limits(state, &mut self.params, by)
    }

    /// §3.4
    #[inline(never)]
    fn read_param<'b>(
        &mut self,
        id: SubsystemId,
        param: ParamId,
        buffer: &'b mut [i32; VALUES_MAX],
    ) -> Result<&'b [i32], Status> {
        // §3.4/1
        let param = Param::find(id, param).ok_or(Status::INVALID_ID)?;
        match param {
            Param::GeneralFaultInfo => {
                for (value, word) in buffer.iter_mut().zip(self.general.crash().to_words()) {
                    *value = word.cast_signed();
                }
                return Ok(buffer.get(..20).unwrap_or_default());
            }
            Param::GeneralInputFaults => {
                let [first, ..] = buffer;
                *first = self.input_faults();
                return Ok(core::slice::from_ref(first));
            }
            // §3.21/1
            Param::DetectorHotbeds => return Ok(hotbed_values(self.detector.hotbeds(), buffer)),
            _ => {}
        }
        let staged = drive_param(param)
            .and_then(|(axis, which)| of_axis(&self.drives, axis).staged_param(which));
        let value = match (staged, self.remote_link(id)) {
            (Some(value), _) => Some(value),
            // §3.4/2
            (None, Some(link)) if param.kind().placement == Placement::Unit => {
                Some(link.read(param.id()).ok_or(Status::NOT_CACHED)?)
            }
            (None, _) => None,
        };
        match (value, buffer) {
            (Some(value), [first, ..]) => {
                *first = value;
                Ok(core::slice::from_ref(first))
            }
            (None, buffer) => self.params.read(param, buffer),
        }
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

    fn remote_link(&mut self, id: SubsystemId) -> Option<&mut remote::Link> {
        if let Some(axis) = axis_of(id) {
            let drive = by_axis(&mut self.drives, axis);
            return drive.is_remote().then(|| drive.unit());
        }
        let valve = self.valve_mut(id)?;
        valve.is_remote().then(|| valve.unit())
    }

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

    /// Nobody is looked for while all is well.
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

/// §3.21 Hotbeds as the values of the parameter.
fn hotbed_values<'b>(hotbeds: &[Hotbed], buffer: &'b mut [i32; VALUES_MAX]) -> &'b [i32] {
    let (chunks, _) = buffer.as_chunks_mut();
    let mut len = 0;
    for (values, hotbed) in chunks.iter_mut().zip(hotbeds.iter().take(Hotbed::MAX)) {
        *values = hotbed.to_values();
        len += values.len();
    }
    buffer.get(..len).unwrap_or_default()
}
