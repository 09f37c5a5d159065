//! Reasons of a refusal: the scenario of the document that the answer belongs to.
//!
//! An answer names the subsystem that refuses, which may have several reasons; its flags show which one
//! it is. Where they are not known, or show none, all of them are named.

mod denied;

use lafet_proto::dictionary;
use lafet_proto::request::{Body, LimitsState};
use lafet_proto::{Request, RequestId, Status, SubsystemId};
use lafet_texts::{Fixed, client as text};

use denied::Denied;

/// Explanation of a refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reason {
    /// Section and scenario, as in docs/protocol.md: `§3.1/1`.
    pub scenario: &'static str,
    /// Cause of the refusal.
    pub why: Fixed,
    /// What to do.
    pub remedy: Fixed,
    /// The action on the monitor that most likely helps, or shows what does; `None`: there is none,
    /// or only the request has to be corrected.
    pub helps: Option<Help>,
}

/// An action that helps against a refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Help {
    /// Read the flags of this subsystem.
    Status(SubsystemId),
    /// Stop this subsystem, or all.
    Stop(SubsystemId),
    /// Close this valve.
    Close(SubsystemId),
    /// Deploy the barrel.
    Deploy,
    /// Release the lockout.
    ReleaseLockout,
    /// Read the limits of the drives.
    Limits,
    /// Switch the limits on.
    LimitsOn,
    /// Switch the limits of this drive on without those that were set meanwhile.
    RejectLimits(SubsystemId),
    /// Look up the parameters of this subsystem.
    Parameters(SubsystemId),
    /// Read the kind of this drive.
    DriveType(SubsystemId),
    /// Read which sensors are not believed.
    InputFaults,
    /// Look up the stored programs and trajectories.
    Programs,
    /// Read the crash data.
    CrashData,
}

/// The status words of a monitor by subsystem; `None` of one that it does not have, or that is not known.
pub type Flags<'a> = &'a dyn Fn(SubsystemId) -> Option<u32>;

/// The reason for which `by` refused this request; its data and the flags can narrow it down.
pub fn reason_of(
    request: &Request<'_>,
    status: Status,
    by: SubsystemId,
    flags: Flags<'_>,
) -> Reason {
    let found = match (&request.body, status) {
        (Body::SwitchLimits { new_state }, Status::INVALID_VALUE)
            if LimitsState::from_wire(*new_state).is_none() =>
        {
            because("§2/4", text::LimitsStateUnknown.fixed(), text::LimitsStateRemedy.fixed())
        }
        _ => None,
    };
    found.unwrap_or_else(|| reason_now(request.body.id(), request.to, status, by, flags))
}

/// The reason for which `by` refused a request of this kind to `to`, where the flags are not known.
pub fn reason(request: RequestId, to: SubsystemId, status: Status, by: SubsystemId) -> Reason {
    reason_now(request, to, status, by, &|_| None)
}

/// The same with the flags of the monitor.
pub fn reason_now(
    request: RequestId,
    to: SubsystemId,
    status: Status,
    by: SubsystemId,
    flags: Flags<'_>,
) -> Reason {
    let found = match status {
        Status::DENIED => Denied { request, to, by, flags }.reason(),
        Status::MODULE_FAULT => module_fault(request, by),
        Status::BUSY => busy(request, by),
        Status::WRONG_REQUEST => wrong_request(request, to, by),
        Status::WRONG_DATA => wrong_data(request, to),
        Status::INVALID_ID => invalid_id(request, to),
        Status::INVALID_VALUE => invalid_value(request, to),
        _ => None,
    };
    found.unwrap_or_else(|| of_status(request, to, status, by))
}

const fn because(scenario: &'static str, why: Fixed, remedy: Fixed) -> Option<Reason> {
    Some(Reason { scenario, why, remedy, helps: None })
}

const fn helped(scenario: &'static str, why: Fixed, remedy: Fixed, helps: Help) -> Option<Reason> {
    Some(Reason { scenario, why, remedy, helps: Some(helps) })
}

fn module_fault(request: RequestId, by: SubsystemId) -> Option<Reason> {
    let scenario = match request {
        RequestId::MOVE => "§3.1/4",
        RequestId::STOP => "§3.2/5",
        RequestId::OPEN => "§3.8/3",
        RequestId::CLOSE => "§3.9/2",
        RequestId::DEPLOY => "§3.10/3",
        RequestId::WRAP => "§3.11/3",
        RequestId::START_SEEK | RequestId::START_JUSTIFY => "§3.3.7/1",
        _ => return None,
    };
    let why = text::SubsystemFaulty.fixed();
    helped(scenario, why, text::ReadFlags.fixed(), Help::Status(by))
}

fn busy(request: RequestId, by: SubsystemId) -> Option<Reason> {
    let (scenario, why) = match (request, by) {
        (RequestId::SWITCH_LIMITS, _) if by.is_drive() => {
            ("§3.17/2", text::LimitsNotReceived.fixed())
        }
        (RequestId::SET_PARAM, by) if by.is_drive() => ("§3.17/5", text::DriveMoves.fixed()),
        (_, SubsystemId::GENERAL) => ("§3.12/2", text::MonitorRestarts.fixed()),
        _ => return None,
    };
    because(scenario, why, text::RepeatInASecond.fixed())
}

fn wrong_request(request: RequestId, to: SubsystemId, by: SubsystemId) -> Option<Reason> {
    if request == RequestId::RESTART {
        return because("§3.12/3", text::RestartForAllOnly.fixed(), text::RestartAll.fixed());
    }
    if to == SubsystemId::ALL || to == SubsystemId::MOTORS {
        return because("§1/7", text::NotForBroadcast.fixed(), text::NameSubsystem.fixed());
    }
    let known = dictionary::request(request).is_some();
    if by == SubsystemId::GENERAL && (to != SubsystemId::GENERAL || !known) {
        return because(
            "§1/4",
            text::RequestNotSupported.fixed(),
            text::RequestNotSupportedRemedy.fixed(),
        );
    }
    let scenario = match request {
        RequestId::MOVE => "§3.1/5",
        RequestId::STOP => "§3.2/6",
        RequestId::OPEN => "§3.8/4",
        RequestId::CLOSE => "§3.9/3",
        RequestId::DEPLOY => "§3.10/4",
        RequestId::WRAP => "§3.11/4",
        _ => "§1/12",
    };
    because(
        scenario,
        text::RequestNotForSubsystem.fixed(),
        text::RequestNotForSubsystemRemedy.fixed(),
    )
}

fn wrong_data(request: RequestId, to: SubsystemId) -> Option<Reason> {
    let (scenario, why) = match request {
        RequestId::SET_PARAM => {
            let (why, remedy) = (text::ParameterCount.fixed(), text::CorrectCount.fixed());
            return helped("§3.5/4", why, remedy, Help::Parameters(to));
        }
        RequestId::SETUP_CORRECTION_TABLE => ("§3.6/2", text::TableEmpty.fixed()),
        RequestId::START_QUENCH => ("§3.14/4", text::QuenchForm.fixed()),
        RequestId::START_TRAJECTORY => ("§3.15/3", text::PointsCount.fixed()),
        _ => return None,
    };
    because(scenario, why, text::CorrectCount.fixed())
}

fn invalid_id(request: RequestId, to: SubsystemId) -> Option<Reason> {
    if request == RequestId::START_TRAJECTORY {
        let (why, remedy) = (text::TrajectoryEmpty.fixed(), text::TrajectoryEmptyRemedy.fixed());
        return helped("§3.15/2", why, remedy, Help::Programs);
    }
    let scenario = if request == RequestId::SET_PARAM { "§3.5/2" } else { "§3.4/1" };
    let (why, remedy) = (text::ParameterUnknown.fixed(), text::ParameterUnknownRemedy.fixed());
    helped(scenario, why, remedy, Help::Parameters(to))
}

fn invalid_value(request: RequestId, to: SubsystemId) -> Option<Reason> {
    match request {
        RequestId::SET_PARAM => invalid_param(to),
        RequestId::START_SEEK => {
            let (why, remedy) =
                (text::SectorOutsideLimits.fixed(), text::SectorInsideLimits.fixed());
            helped("§3.16/2", why, remedy, Help::Limits)
        }
        RequestId::START_QUENCH => helped(
            "§3.14/8",
            text::QuenchSectorOutsideLimits.fixed(),
            text::QuenchSectorRemedy.fixed(),
            Help::Limits,
        ),
        RequestId::START_TRAJECTORY => {
            let (why, remedy) =
                (text::TrajectoryOutOfRange.fixed(), text::TrajectoryNumbers.fixed());
            helped("§3.15/3", why, remedy, Help::Limits)
        }
        RequestId::SWITCH_LIMITS => {
            let (why, remedy) = (text::LimitsCrossed.fixed(), text::LimitsCrossedRemedy.fixed());
            helped("§3.17/6", why, remedy, Help::RejectLimits(to))
        }
        RequestId::SETUP_CORRECTION_TABLE => {
            because("§3.6/2", text::TableTooLong.fixed(), text::TableTooLongRemedy.fixed())
        }
        RequestId::LOCKOUT => {
            because("§3.18/5", text::LockoutKey.fixed(), text::LockoutKeyRemedy.fixed())
        }
        _ => None,
    }
}

/// The reason for an invalid value of a parameter.
fn invalid_param(of: SubsystemId) -> Option<Reason> {
    if !of.is_drive() {
        let (why, remedy) = (text::ParameterOutOfRange.fixed(), text::ParameterRange.fixed());
        return helped("§3.5/3", why, remedy, Help::Parameters(of));
    }
    let why = text::DriveParameterOutOfRange.fixed();
    helped("§3.17/5", why, text::DriveParameterRemedy.fixed(), Help::Parameters(of))
}

/// The reason that follows from the status alone.
fn of_status(request: RequestId, to: SubsystemId, status: Status, by: SubsystemId) -> Reason {
    let scenario = match (status, request) {
        (Status::NEED_CONFIRM, RequestId::OPEN) => "§3.8/6",
        (Status::NEED_CONFIRM, RequestId::CLOSE) => "§3.9/5",
        (Status::NEED_CONFIRM, RequestId::CLEAN_FLASH) => "§3.19/2",
        (Status::MODULE_NOT_EXIST, _) => "§1/3",
        (Status::WRONG_DATA, _) => "§2/3",
        (Status::INVALID_VALUE, _) => "§2/4",
        (Status::NO_ROOM, _) => "§1/9",
        (Status::ACCESS_DENIED, _) => "§3.5/5",
        (Status::INCOMPLETE_CONFIG, RequestId::GET_PARAM) => "§3.4/3",
        (Status::INCOMPLETE_CONFIG, _) => "§3.5/6",
        (Status::NOT_CACHED, _) => "§3.4/2",
        (Status::CACHED, _) => "§3.5/7",
        (Status::NOT_SUPPORTED, _) => "§3.17/4",
        (Status::DENIED, _) => "§1/2",
        _ => "§2/5",
    };
    let unknown = || Reason {
        scenario,
        why: text::StatusUnknown.fixed(),
        remedy: text::StatusUnknownRemedy.fixed(),
        helps: None,
    };
    dictionary::status(status).map_or_else(unknown, |info| Reason {
        scenario,
        why: lafet_texts::dictionary(info.meaning),
        remedy: lafet_texts::dictionary(info.remedy),
        helps: helps_by_status(request, to, status, by),
    })
}

fn helps_by_status(
    request: RequestId,
    to: SubsystemId,
    status: Status,
    by: SubsystemId,
) -> Option<Help> {
    let of_parameters = matches!(request, RequestId::SET_PARAM | RequestId::GET_PARAM);
    Some(match status {
        Status::WRONG_DATA | Status::ACCESS_DENIED | Status::INCOMPLETE_CONFIG if of_parameters => {
            Help::Parameters(to)
        }
        Status::MODULE_NOT_EXIST => Help::Status(SubsystemId::ALL),
        Status::MODULE_FAULT => Help::Status(by),
        Status::NOT_SUPPORTED if by.is_drive() => Help::DriveType(by),
        Status::SYSTEM_FAULT => Help::CrashData,
        // Stop All is never denied (§3.2/1).
        Status::DENIED if request == RequestId::STOP => Help::Stop(SubsystemId::ALL),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenarios_are_those_of_the_request() {
        let of = |request, to, status, by| reason(request, to, status, by).scenario;
        let (vertical, deployer) = (SubsystemId::VERTICAL, SubsystemId::DEPLOYER);
        assert_eq!(of(RequestId::MOVE, vertical, Status::DENIED, deployer), "§3.1/1");
        assert_eq!(of(RequestId::STOP, vertical, Status::DENIED, SubsystemId::CONTROL), "§3.2/4");
        let general = SubsystemId::GENERAL;
        // Locked out, or a weak supply.
        assert_eq!(of(RequestId::MOVE, vertical, Status::DENIED, general), "§1/2");
        assert_eq!(of(RequestId::CLOSE, vertical, Status::DENIED, general), "§3.18/2");
        // To release a lockout is no advice to who is refused just that.
        let release = reason(RequestId::LOCKOUT, SubsystemId::ALL, Status::DENIED, general);
        assert_eq!(release.why, text::LockedByUpdate.fixed());
        assert_eq!(release.helps, Some(Help::Status(general)));
        assert_eq!(of(RequestId::MOVE, vertical, Status::BUSY, general), "§3.12/2");
        assert_eq!(of(RequestId::WRAP, deployer, Status::DENIED, SubsystemId::VALVE1), "§3.11/6");
        assert_eq!(of(RequestId::MOVE, SubsystemId::ALL, Status::WRONG_REQUEST, general), "§1/7");
        let unknown = RequestId(0x99);
        assert_eq!(of(unknown, general, Status::WRONG_REQUEST, general), "§1/4");
        assert_eq!(of(RequestId::MOVE, general, Status::WRONG_REQUEST, general), "§3.1/5");
    }

    /// What is said must help: closing does not free a valve that is blocked, nor deploying a barrel whose
    /// rest is not known.
    #[test]
    fn blocked_and_not_homed() {
        let denied = |request, of, by| reason(request, of, Status::DENIED, by);
        let (valve, deployer) = (SubsystemId::VALVE2, SubsystemId::DEPLOYER);
        let blocked = denied(RequestId::OPEN, valve, valve);
        assert_eq!((blocked.scenario, blocked.why), ("§3.3.5/1", text::ValveBlocked.fixed()));
        assert!(blocked.remedy.en.contains("handwheel") && blocked.remedy.ru.contains("маховик"));
        let wrap = reason_now(RequestId::WRAP, deployer, Status::DENIED, deployer, &|_| Some(0));
        assert_eq!((wrap.scenario, wrap.why), ("§D/7", text::BarrelNotHomed.fixed()));
        let vertical = SubsystemId::VERTICAL;
        for request in [RequestId::SWITCH_LIMITS, RequestId::SET_PARAM] {
            let limits = denied(request, vertical, vertical);
            assert_eq!((limits.scenario, limits.why), ("§D/7", text::NotHomed.fixed()));
            assert_eq!(limits.remedy, wrap.remedy);
        }
        assert!(wrap.remedy.en.contains("Homing") && wrap.remedy.ru.contains("Homing"));
    }

    #[test]
    fn what_helps_follows_from_the_state() {
        let (detector, control) = (SubsystemId::DETECTOR, SubsystemId::CONTROL);
        let helps = |request, by, flags: Flags<'_>| {
            reason_now(request, by, Status::DENIED, by, flags).helps
        };
        // A seek may be kept back by a program, by an alignment, or by limits that are off.
        let only = |id, bits| move |of| Some(if of == id { bits } else { 0 });
        let quench = only(control, lafet_proto::flags::ControlFlags::QUENCH.bits());
        let off = only(SubsystemId::VERTICAL, lafet_proto::flags::DriveFlags::LIMITLESS.bits());
        let seek = RequestId::START_SEEK;
        assert_eq!(helps(seek, detector, &quench), Some(Help::Stop(control)));
        assert_eq!(helps(seek, detector, &off), Some(Help::LimitsOn));
        assert_eq!(helps(seek, detector, &|_| None), Some(Help::Stop(detector)));
        let valve = SubsystemId::VALVE1;
        assert_eq!(helps(RequestId::WRAP, valve, &|_| None), Some(Help::Close(valve)));
        let closed = only(valve, lafet_proto::flags::ValveFlags::CLOSED.bits());
        assert_eq!(helps(RequestId::WRAP, valve, &closed), Some(Help::InputFaults));
        assert_eq!(helps(RequestId::STOP, control, &quench), Some(Help::Stop(SubsystemId::ALL)));
        for flags in [&closed as Flags<'_>, &|_| Some(0), &|_| None] {
            assert_eq!(helps(RequestId::STOP, valve, flags), Some(Help::Stop(SubsystemId::ALL)));
        }
    }

    #[test]
    fn an_unknown_state_of_limits_is_not_crossing_limits() {
        let refused = |new_state| {
            let request = Request::new(SubsystemId::VERTICAL, Body::SwitchLimits { new_state });
            reason_of(&request, Status::INVALID_VALUE, SubsystemId::VERTICAL, &|_| None).scenario
        };
        assert_eq!((refused(1), refused(5)), ("§3.17/6", "§2/4"));
    }
}
