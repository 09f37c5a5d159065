//! Why a request was Denied: what the subsystem that refuses may mean, and which of it the flags show.

use lafet_proto::flags::{
    ControlFlags, DeployerFlags, DetectorFlags, DriveFlags, GeneralFlags, ValveFlags,
};
use lafet_proto::{RequestId, SubsystemId};
use lafet_texts::client as text;

use super::{Flags, Reason, because};

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
                because("§3.3.10/1", text::ButtonHeld.fixed(), text::ReleaseButton.fixed())
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
        let locked = || because("§3.18/2", text::LockedOut.fixed(), text::LockedOutRemedy.fixed());
        if !self.request.needs_supply()
            || self.has(SubsystemId::GENERAL, GeneralFlags::LOCKED_OUT.bits())
        {
            return locked();
        }
        if self.has(SubsystemId::GENERAL, GeneralFlags::BAD_POWER.bits()) {
            return because("§3.3.1/4", text::SupplyWeak.fixed(), text::SupplyRemedy.fixed());
        }
        because("§1/2", text::LockedOutOrWeak.fixed(), text::LockedOutOrWeakRemedy.fixed())
    }

    fn by_deployer(&self) -> Option<Reason> {
        match self.request {
            RequestId::STOP => {
                because("§3.2/2", text::DeployerMoves.fixed(), text::StopAll.fixed())
            }
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
                because(scenario, text::NotDeployed.fixed(), text::DeployFirst.fixed())
            }
        }
    }

    /// A barrel that is not deployed is wrapped from where it is: only its drives can forbid it, and
    /// water on a monitor without a valve.
    fn wrap_by_deployer(&self) -> Option<Reason> {
        let not_homed = || because("§D/7", text::BarrelNotHomed.fixed(), text::HomeIt.fixed());
        let limitless = self.limitless(&[SubsystemId::VERTICAL, SubsystemId::HORIZONTAL]);
        match (self.is_without_valves(), limitless) {
            (Some(false), _) => not_homed(),
            (Some(true), false) => self.no_valve("§D/6"),
            _ => because(
                "§1/2",
                text::BarrelNotHomedOrWater.fixed(),
                text::BarrelNotHomedOrWaterRemedy.fixed(),
            ),
        }
    }

    fn move_by_deployer(&self) -> Option<Reason> {
        let folded = || {
            because("§3.1/9", text::DeployerNotFree.fixed(), text::DeployerNotFreeRemedy.fixed())
        };
        let away = DeployerFlags::WRAPPED | DeployerFlags::DEPLOYING | DeployerFlags::WRAPPING;
        match self.is_without_valves() {
            Some(true) if !self.deployer(away) => self.no_valve("§D/6"),
            _ => folded(),
        }
    }

    fn no_valve(&self, scenario: &'static str) -> Option<Reason> {
        because(scenario, text::WaterWithoutValve.fixed(), text::CloseMain.fixed())
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
        let (search, stop) = (text::SearchGoesOn.fixed(), text::StopDetector.fixed());
        let scenario = match self.request {
            RequestId::START_SEEK => return self.seek_by_detector(justifying),
            RequestId::START_JUSTIFY => return self.justify_by_detector(searching),
            RequestId::STOP => {
                let why = match (searching, justifying) {
                    (true, _) => text::SearchRuns.fixed(),
                    (_, true) => text::AlignmentRuns.fixed(),
                    _ => text::SearchOrAlignmentOnlyStopped.fixed(),
                };
                return because("§3.2/3", why, text::StopAll.fixed());
            }
            // An alignment does not keep a valve from closing.
            RequestId::CLOSE => return because("§3.9/1", search, stop),
            RequestId::MOVE => "§3.1/2",
            RequestId::OPEN => "§3.8/2",
            RequestId::WRAP => "§3.11/7",
            RequestId::START_QUENCH => "§3.14/6",
            RequestId::START_TRAJECTORY => "§3.15/4",
            _ => "§1/2",
        };
        match (searching, justifying) {
            (true, _) => because(scenario, search, stop),
            (_, true) => because("§3.13/3", text::AlignmentGoesOn.fixed(), stop),
            _ => because(scenario, text::SearchOrAlignmentRuns.fixed(), stop),
        }
    }

    fn seek_by_detector(&self, justifying: bool) -> Option<Reason> {
        if self.has(SubsystemId::CONTROL, ControlFlags::QUENCH.bits()) {
            return self.by_program("§3.16/4");
        }
        if justifying {
            let why = text::AlignmentGoesOn.fixed();
            return because("§3.16/4", why, text::StopDetector.fixed());
        }
        self.without_limits().or_else(|| {
            let why = text::ProgramOrAlignmentRuns.fixed();
            because("§3.16/4", why, text::ProgramOrAlignmentRemedy.fixed())
        })
    }

    fn justify_by_detector(&self, searching: bool) -> Option<Reason> {
        if searching {
            return because("§3.13/2", text::SearchGoesOn.fixed(), text::StopDetector.fixed());
        }
        self.without_limits().or_else(|| {
            let why = text::SearchOrNoLimits.fixed();
            because("§3.13/2", why, text::SearchOrNoLimitsRemedy.fixed())
        })
    }

    /// Limits of a drive that points the barrel are off.
    fn without_limits(&self) -> Option<Reason> {
        let limitless = self.limitless(&[SubsystemId::VERTICAL, SubsystemId::HORIZONTAL]);
        let why = text::ProgramWithoutLimits.fixed();
        limitless.then(|| because("§3.17/1", why, text::LimitsOn.fixed())).flatten()
    }

    fn by_control(&self) -> Option<Reason> {
        match self.request {
            RequestId::START_QUENCH | RequestId::START_TRAJECTORY => {
                because("§3.17/1", text::ProgramWithoutLimits.fixed(), text::LimitsOn.fixed())
            }
            RequestId::STOP => {
                because("§3.2/4", text::ProgramOnlyStopped.fixed(), text::StopAll.fixed())
            }
            RequestId::MOVE => self.by_program("§3.1/9"),
            RequestId::START_JUSTIFY => self.by_program("§3.13/2"),
            _ => self.by_program("§1/2"),
        }
    }

    fn by_program(&self, scenario: &'static str) -> Option<Reason> {
        because(scenario, text::ProgramRuns.fixed(), text::StopControl.fixed())
    }

    fn by_valve(&self) -> Option<Reason> {
        // What flows out of a valve does not forbid to open one.
        if self.request == RequestId::OPEN {
            let (why, remedy) = (text::ValveBlocked.fixed(), text::ValveBlockedRemedy.fixed());
            return because("§3.3.5/1", why, remedy);
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
        match doubted {
            Some(true) => {
                because("§D/6", text::FlowsThoughClosed.fixed(), text::LookForWater.fixed())
            }
            Some(false) => because(scenario, open, text::CloseAndWait.fixed()),
            None => because(scenario, either, text::CloseValve.fixed()),
        }
    }

    fn by_drive(&self) -> Option<Reason> {
        let positions = matches!(self.request, RequestId::SWITCH_LIMITS | RequestId::SET_PARAM);
        positions.then_some(Reason {
            scenario: "§D/7",
            why: text::NotHomed.fixed(),
            remedy: text::HomeIt.fixed(),
        })
    }
}
