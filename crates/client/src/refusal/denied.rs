//! Why a request was Denied: what the subsystem that refuses may mean, and which of it the flags show.

use lafet_proto::flags::{
    ControlFlags, DeployerFlags, DetectorFlags, DriveFlags, GeneralFlags, ValveFlags,
};
use lafet_proto::{RequestId, SubsystemId};
use lafet_texts::{Fixed, client as text};

use super::{Flags, Help, Reason, helped};

/// A refusal as Denied.
pub(super) struct Denied<'a> {
    pub request: RequestId,
    pub to: SubsystemId,
    pub by: SubsystemId,
    pub flags: Flags<'a>,
}

impl Denied<'_> {
    pub fn reason(&self) -> Option<Reason> {
        match self.by {
            SubsystemId::GENERAL => self.by_general(),
            SubsystemId::DEPLOYER => self.by_deployer(),
            SubsystemId::DETECTOR => self.by_detector(),
            SubsystemId::CONTROL => self.by_control(),
            SubsystemId::BUTTONS | SubsystemId::EXT_BUTTONS => {
                let (why, remedy) = (text::ButtonHeld.fixed(), text::ReleaseButton.fixed());
                helped("§3.3.10/1", why, remedy, Help::Status(self.by))
            }
            id if id.is_valve() => self.by_valve(),
            id if id.is_drive() => self.by_drive(),
            _ => None,
        }
    }

    /// Whether any of these flags of a subsystem is set; no, where its status is not known.
    fn has(&self, id: SubsystemId, flags: u32) -> bool {
        (self.flags)(id).is_some_and(|bits| bits & flags != 0)
    }

    fn detector(&self, flags: DetectorFlags) -> bool {
        self.has(SubsystemId::DETECTOR, flags.bits())
    }

    fn deployer(&self, flags: DeployerFlags) -> bool {
        self.has(SubsystemId::DEPLOYER, flags.bits())
    }

    /// Limits of one of these drives are off, or its position is not known (§D/7).
    fn limitless(&self, drives: &[SubsystemId]) -> bool {
        drives.iter().any(|id| self.has(*id, DriveFlags::LIMITLESS.bits()))
    }

    fn by_general(&self) -> Option<Reason> {
        let general = Help::Status(SubsystemId::GENERAL);
        let locked = || {
            let (why, remedy) = (text::LockedOut.fixed(), text::LockedOutRemedy.fixed());
            helped("§3.18/2", why, remedy, Help::ReleaseLockout)
        };
        // Nothing else keeps a lockout from being released (docs/update.md).
        if self.request == RequestId::LOCKOUT {
            let why = text::LockedByUpdate.fixed();
            return helped("§3.18/2", why, text::LockedByUpdateRemedy.fixed(), general);
        }
        if !self.request.needs_supply()
            || self.has(SubsystemId::GENERAL, GeneralFlags::LOCKED_OUT.bits())
        {
            return locked();
        }
        if self.has(SubsystemId::GENERAL, GeneralFlags::BAD_POWER.bits()) {
            let (why, remedy) = (text::SupplyWeak.fixed(), text::SupplyRemedy.fixed());
            return helped("§3.3.1/4", why, remedy, general);
        }
        let (why, remedy) = (text::LockedOutOrWeak.fixed(), text::LockedOutOrWeakRemedy.fixed());
        helped("§1/2", why, remedy, general)
    }

    fn by_deployer(&self) -> Option<Reason> {
        match self.request {
            RequestId::STOP => stop_all("§3.2/2", text::DeployerMoves.fixed()),
            RequestId::WRAP => self.wrap_by_deployer(),
            RequestId::MOVE if self.to == SubsystemId::DEPLOYER => self.move_by_deployer(),
            // It deploys first: only water that no valve shuts off is in its way.
            RequestId::START_SEEK => self.no_valve("§3.16/8"),
            request => {
                let scenario = match request {
                    RequestId::MOVE => "§3.1/1",
                    RequestId::OPEN => "§3.8/1",
                    RequestId::START_JUSTIFY => "§3.13/2",
                    _ => "§1/2",
                };
                let (why, remedy) = (text::NotDeployed.fixed(), text::DeployFirst.fixed());
                helped(scenario, why, remedy, Help::Deploy)
            }
        }
    }

    /// A barrel that is not deployed is wrapped from where it is: only its drives can forbid it, and
    /// water on a monitor without a valve.
    fn wrap_by_deployer(&self) -> Option<Reason> {
        // Which drive is to be homed (§D/7), and whether water flows all the same (§D/6).
        let not_homed = || {
            let (why, remedy) = (text::BarrelNotHomed.fixed(), text::HomeIt.fixed());
            helped("§D/7", why, remedy, Help::InputFaults)
        };
        let limitless = self.limitless(&[SubsystemId::VERTICAL, SubsystemId::HORIZONTAL]);
        match (self.is_without_valves(), limitless) {
            (Some(false), _) => not_homed(),
            (Some(true), false) => self.no_valve("§D/6"),
            _ => helped(
                "§1/2",
                text::BarrelNotHomedOrWater.fixed(),
                text::BarrelNotHomedOrWaterRemedy.fixed(),
                Help::InputFaults,
            ),
        }
    }

    fn move_by_deployer(&self) -> Option<Reason> {
        let folded = || {
            let (why, remedy) =
                (text::DeployerNotFree.fixed(), text::DeployerNotFreeRemedy.fixed());
            helped("§3.1/9", why, remedy, Help::Deploy)
        };
        let away = DeployerFlags::WRAPPED | DeployerFlags::DEPLOYING | DeployerFlags::WRAPPING;
        match self.is_without_valves() {
            Some(true) if !self.deployer(away) => self.no_valve("§D/6"),
            _ => folded(),
        }
    }

    fn no_valve(&self, scenario: &'static str) -> Option<Reason> {
        let (why, remedy) = (text::WaterWithoutValve.fixed(), text::CloseMain.fixed());
        helped(scenario, why, remedy, Help::InputFaults)
    }

    /// Where the status is known.
    fn is_without_valves(&self) -> Option<bool> {
        (self.flags)(SubsystemId::GENERAL)?;
        let valves = [SubsystemId::VALVE1, SubsystemId::VALVE2];
        Some(valves.iter().all(|id| (self.flags)(*id).is_none()))
    }

    fn by_detector(&self) -> Option<Reason> {
        let searching = self.detector(DetectorFlags::SEARCHING);
        let justifying = self.detector(DetectorFlags::JUSTIFYING);
        let search = text::SearchGoesOn.fixed();
        let scenario = match self.request {
            RequestId::START_SEEK => return self.seek_by_detector(justifying),
            RequestId::START_JUSTIFY => return self.justify_by_detector(searching),
            RequestId::STOP => {
                let why = match (searching, justifying) {
                    (true, _) => text::SearchRuns.fixed(),
                    (_, true) => text::AlignmentRuns.fixed(),
                    _ => text::SearchOrAlignmentOnlyStopped.fixed(),
                };
                return stop_all("§3.2/3", why);
            }
            // An alignment does not keep a valve from closing.
            RequestId::CLOSE => return stop_detector("§3.9/1", search),
            RequestId::MOVE => "§3.1/2",
            RequestId::OPEN => "§3.8/2",
            RequestId::WRAP => "§3.11/7",
            RequestId::START_QUENCH => "§3.14/6",
            RequestId::START_TRAJECTORY => "§3.15/4",
            _ => "§1/2",
        };
        match (searching, justifying) {
            (true, _) => stop_detector(scenario, search),
            (_, true) => stop_detector("§3.13/3", text::AlignmentGoesOn.fixed()),
            _ => stop_detector(scenario, text::SearchOrAlignmentRuns.fixed()),
        }
    }

    fn seek_by_detector(&self, justifying: bool) -> Option<Reason> {
        if self.has(SubsystemId::CONTROL, ControlFlags::QUENCH.bits()) {
            return self.by_program("§3.16/4");
        }
        if justifying {
            return stop_detector("§3.16/4", text::AlignmentGoesOn.fixed());
        }
        self.without_limits().or_else(|| {
            let (why, remedy) =
                (text::ProgramOrAlignmentRuns.fixed(), text::ProgramOrAlignmentRemedy.fixed());
            helped("§3.16/4", why, remedy, Help::Stop(SubsystemId::DETECTOR))
        })
    }

    fn justify_by_detector(&self, searching: bool) -> Option<Reason> {
        if searching {
            return stop_detector("§3.13/2", text::SearchGoesOn.fixed());
        }
        self.without_limits().or_else(|| {
            let (why, remedy) =
                (text::SearchOrNoLimits.fixed(), text::SearchOrNoLimitsRemedy.fixed());
            helped("§3.13/2", why, remedy, Help::Stop(SubsystemId::DETECTOR))
        })
    }

    /// Limits of a drive that points the barrel are off.
    fn without_limits(&self) -> Option<Reason> {
        let limitless = self.limitless(&[SubsystemId::VERTICAL, SubsystemId::HORIZONTAL]);
        limitless.then(limits_on).flatten()
    }

    fn by_control(&self) -> Option<Reason> {
        match self.request {
            RequestId::START_QUENCH | RequestId::START_TRAJECTORY => limits_on(),
            RequestId::STOP => stop_all("§3.2/4", text::ProgramOnlyStopped.fixed()),
            RequestId::MOVE => self.by_program("§3.1/9"),
            RequestId::START_JUSTIFY => self.by_program("§3.13/2"),
            _ => self.by_program("§1/2"),
        }
    }

    fn by_program(&self, scenario: &'static str) -> Option<Reason> {
        let (why, remedy) = (text::ProgramRuns.fixed(), text::StopControl.fixed());
        helped(scenario, why, remedy, Help::Stop(SubsystemId::CONTROL))
    }

    fn by_valve(&self) -> Option<Reason> {
        // What flows out of a valve does not forbid to open one.
        if self.request == RequestId::OPEN {
            let (why, remedy) = (text::ValveBlocked.fixed(), text::ValveBlockedRemedy.fixed());
            return helped("§3.3.5/1", why, remedy, Help::Status(self.by));
        }
        if self.request == RequestId::STOP {
            return stop_all("§1/2", text::WaterFlows.fixed());
        }
        let valve = (self.flags)(self.by).map(ValveFlags::from_bits_retain);
        // A switch that is not believed, or water past a valve that is closed (§D/6).
        let doubted = valve.map(|flags| {
            let closed = flags.contains(ValveFlags::CLOSED) && !flags.contains(ValveFlags::OPENING);
            closed || flags.contains(ValveFlags::CLOSE_SENSOR_FAULT)
        });
        let (scenario, open, either) = match self.request {
            RequestId::WRAP => {
                ("§3.11/6", text::OpenUnderFolding.fixed(), text::WaterInFoldingBarrel.fixed())
            }
            RequestId::START_SEEK => {
                ("§3.16/8", text::OpenBeforeDetector.fixed(), text::WaterBeforeDetector.fixed())
            }
            RequestId::MOVE => {
                ("§3.1/9", text::OpenUnderFolding.fixed(), text::WaterUnderFoldingBarrel.fixed())
            }
            _ => ("§1/2", text::ValveNotClosed.fixed(), text::WaterFlows.fixed()),
        };
        let close = Help::Close(self.by);
        match doubted {
            Some(true) => {
                let (why, remedy) = (text::FlowsThoughClosed.fixed(), text::LookForWater.fixed());
                helped("§D/6", why, remedy, Help::InputFaults)
            }
            Some(false) => helped(scenario, open, text::CloseAndWait.fixed(), close),
            None => helped(scenario, either, text::CloseValve.fixed(), close),
        }
    }

    fn by_drive(&self) -> Option<Reason> {
        let positions = matches!(self.request, RequestId::SWITCH_LIMITS | RequestId::SET_PARAM);
        positions.then_some(Reason {
            scenario: "§D/7",
            why: text::NotHomed.fixed(),
            remedy: text::HomeIt.fixed(),
            helps: Some(Help::InputFaults),
        })
    }
}

fn stop_all(scenario: &'static str, why: Fixed) -> Option<Reason> {
    helped(scenario, why, text::StopAll.fixed(), Help::Stop(SubsystemId::ALL))
}

fn stop_detector(scenario: &'static str, why: Fixed) -> Option<Reason> {
    helped(scenario, why, text::StopDetector.fixed(), Help::Stop(SubsystemId::DETECTOR))
}

fn limits_on() -> Option<Reason> {
    let (why, remedy) = (text::ProgramWithoutLimits.fixed(), text::LimitsOn.fixed());
    helped("§3.17/1", why, remedy, Help::LimitsOn)
}
