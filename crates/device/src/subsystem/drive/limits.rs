//! §3.17 «SwitchLimits», §3.5 SetParam of a drive: limits and zero point, as plain values or taken where it is.

use super::{Drive, Goal, Staged, config_invalid, stored_limits};
use crate::cause::{Asked, Cause};
use crate::composition::DriveKind;
use crate::params::Params;
use lafet_proto::Status;
use lafet_proto::param::{DriveParam, Param};
use lafet_proto::request::LimitsState;
use lafet_proto::status::Limits;

impl Drive {
    /// §3.17 SwitchLimits.
    pub(crate) fn switch_limits(
        &mut self,
        state: LimitsState,
        params: &mut Params,
        by: Asked,
    ) -> Status {
        // §3.17/4
        if self.kind == DriveKind::LimitSwitches {
            return Status::NOT_SUPPORTED;
        }
        match state {
            // §3.17/1
            LimitsState::Off => self.limitless = true,
            // §3.17/3
            LimitsState::Reject => self.staged = Staged::default(),
            // §D/7
            LimitsState::On if !self.is_homed() => return Status::DENIED,
            // §3.17/2
            LimitsState::On => {
                let min = self.staged.min.unwrap_or(self.limits.min);
                let max = self.staged.max.unwrap_or(self.limits.max);
                // §3.17/6
                if min >= max {
                    return Status::INVALID_VALUE;
                }
                if !self.store_staged(params) {
                    return Status::BUSY;
                }
            }
        }
        if state != LimitsState::Off && self.limitless {
            self.limitless = false;
            // What runs without limits must not go on into a limit that has just come back.
            self.stop(Cause::Request(by));
        }
        Status::OK
    }

    /// §3.5, §3.17/5 SetParam of this drive; range and access have been checked.
    pub(crate) fn set_param(
        &mut self,
        param: DriveParam,
        value: i32,
        params: &mut Params,
        by: Asked,
    ) -> Status {
        let homed = self.is_homed();
        let staged = match param {
            DriveParam::MinLimit => &mut self.staged.min,
            DriveParam::MaxLimit => &mut self.staged.max,
            DriveParam::ZeroPoint => return self.set_zero_point(value, params),
            other => return self.write(other, value, params),
        };
        if self.limitless {
            // §D/7
            if !homed {
                return Status::DENIED;
            }
            if self.goal != Goal::Hold {
                return Status::BUSY;
            }
            if value != self.position {
                return Status::INVALID_VALUE;
            }
            *staged = Some(value);
            return Status::ACCEPTED;
        }
        let status = self.write(param, value, params);
        self.limits = stored_limits(self.axis, params);
        if status.is_success() {
            self.stop_outside_limits(by);
        }
        status
    }

    /// §3.4 A limit taken while limits are off is read back before it is in force; MoveHold and what is
    /// measured are kept nowhere else.
    pub(crate) fn staged_param(&self, param: DriveParam) -> Option<i32> {
        match param {
            DriveParam::MinLimit => self.staged.min,
            DriveParam::MaxLimit => self.staged.max,
            DriveParam::StopLagSeen => Some(self.seen.lag_ms()),
            DriveParam::MinSpeedSeen => Some(self.seen.least()),
            DriveParam::MoveHold => Some(self.next_hold_ms.max(self.hold_ms).cast_signed()),
            _ => None,
        }
    }

    fn write(&mut self, param: DriveParam, value: i32, params: &mut Params) -> Status {
        let Some(param) = Param::of_drive(self.axis.id(), param) else {
            return Status::INVALID_ID;
        };
        if self.kind == DriveKind::Remote
            && param.kind().placement == lafet_proto::param::Placement::Unit
            && !self.unit.write(param.id(), value)
        {
            return Status::CACHED;
        }
        let status = params.write(param, lafet_proto::Ints::Values(&[value]));
        self.faulty_config = config_invalid(self.axis, params);
        status
    }

    /// §3.17 Without limits the present position becomes zero; with limits a plain value is taken.
    fn set_zero_point(&mut self, value: i32, params: &mut Params) -> Status {
        if self.goal != Goal::Hold {
            return Status::BUSY;
        }
        if !self.limitless {
            let status = self.write(DriveParam::ZeroPoint, value, params);
            self.position = self.sensed(params);
            return status;
        }
        // §D/7
        if !self.is_homed() {
            return Status::DENIED;
        }
        let repeated = self.staged.zero == Some(value) && self.position == 0;
        if value != self.position && !repeated {
            return Status::INVALID_VALUE;
        }
        // Nothing is left to shift where it is repeated.
        let shift = self.position;
        let zero = params.drive(self.axis, DriveParam::ZeroPoint).saturating_add(shift);
        // The encoder's own zero is too far away for the parameter.
        if zero.unsigned_abs() > i16::MAX.unsigned_abs().into() {
            return Status::INVALID_VALUE;
        }
        let status = self.write(DriveParam::ZeroPoint, zero, params);
        if status.is_success() {
            self.position = self.sensed(params);
            self.staged.min = self.staged.min.map(|min| min.saturating_sub(shift));
            self.staged.max = self.staged.max.map(|max| max.saturating_sub(shift));
            self.staged.zero = Some(value);
        }
        status
    }

    /// Puts the limits taken into force; false while a remote unit has not got them yet.
    fn store_staged(&mut self, params: &mut Params) -> bool {
        if let Some(min) = self.staged.min {
            if self.write(DriveParam::MinLimit, min, params) == Status::CACHED {
                return false;
            }
            self.staged.min = None;
        }
        if let Some(max) = self.staged.max {
            if self.write(DriveParam::MaxLimit, max, params) == Status::CACHED {
                return false;
            }
            self.staged.max = None;
        }
        self.limits = stored_limits(self.axis, params);
        true
    }

    fn stop_outside_limits(&mut self, by: Asked) {
        if let (Goal::Position(target), Some(Limits { min, max })) = (self.goal, self.limits())
            && !(min..=max).contains(&target)
        {
            self.stop(Cause::Request(by));
        }
    }
}
