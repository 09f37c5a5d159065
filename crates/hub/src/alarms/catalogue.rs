//! What each alarm says. What it is, why, and what to do come from the dictionary of flags; what it
//! leads to is added here.

use lafet_proto::SubsystemId;
use lafet_proto::flags::{FlagInfo, Severity};
use lafet_texts::{Text, hub as text};

use super::alarm::Priority;
use crate::text::Both;

/// The texts of an alarm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texts {
    /// How urgent the response is.
    pub priority: Priority,
    /// The condition, in words.
    pub what: Both,
    /// What usually leads to it.
    pub cause: Both,
    /// What follows if there is no response.
    pub consequence: Both,
    /// What the operator does.
    pub remedy: Both,
}

/// The texts of a flag of a subsystem.
pub fn of_flag(id: SubsystemId, flag: &FlagInfo) -> Texts {
    Texts {
        priority: match flag.severity {
            // Not a fault of the monitor, but what it is there for.
            _ if id == SubsystemId::DETECTOR && flag.name == "Found" => Priority::Fire,
            Severity::Alarm => Priority::High,
            _ => Priority::Medium,
        },
        what: flag.meaning.words(),
        cause: flag.cause.words(),
        consequence: consequence(id, flag.name).map(Text::words).unwrap_or_default(),
        remedy: flag.remedy.words(),
    }
}

/// There is no connection to a monitor.
pub fn link_down() -> Texts {
    Texts {
        priority: Priority::High,
        what: text::AlarmLinkDown.words(),
        cause: text::AlarmLinkDownCause.words(),
        consequence: text::AlarmLinkDownConsequence.words(),
        remedy: text::AlarmLinkDownRemedy.words(),
    }
}

/// The monitor does not answer.
pub fn stale() -> Texts {
    Texts { what: text::MonitorSilent.words(), cause: text::AlarmStaleCause.words(), ..link_down() }
}

/// Bytes arrive on the line that are no frames, so nothing is polled.
pub fn unreadable(baud: u32) -> Texts {
    Texts {
        what: text::AlarmUnreadable { baud }.words(),
        cause: text::AlarmUnreadableCause.words(),
        consequence: text::AlarmWithheldConsequence.words(),
        remedy: text::AlarmUnreadableRemedy.words(),
        ..link_down()
    }
}

/// A bus controller transmits on the line, and the hub is no console of its bus.
pub fn foreign_controller() -> Texts {
    Texts {
        what: text::AlarmController.words(),
        cause: text::AlarmControllerCause.words(),
        consequence: text::AlarmWithheldConsequence.words(),
        remedy: text::AlarmControllerRemedy.words(),
        ..link_down()
    }
}

/// Water goes where it must not.
pub fn kept_out(name: &str) -> Texts {
    Texts {
        priority: Priority::High,
        what: text::AlarmKeepOut { name }.words(),
        cause: text::AlarmKeepOutCause.words(),
        consequence: text::AlarmKeepOutConsequence.words(),
        remedy: text::AlarmKeepOutRemedy.words(),
    }
}

/// Nothing ends a motion by hand in time when the hub or the connection fails.
pub fn unheld() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: text::AlarmUnheld.words(),
        cause: text::AlarmUnheldCause.words(),
        consequence: text::AlarmUnheldConsequence.words(),
        remedy: text::AlarmUnheldRemedy.words(),
    }
}

/// The audit log cannot be stored.
pub fn audit() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: text::AlarmAudit.words(),
        cause: text::AlarmDiskCause.words(),
        consequence: text::AlarmAuditConsequence.words(),
        remedy: text::AlarmAuditRemedy.words(),
    }
}

/// The disk of the state is almost full.
pub fn disk() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: text::AlarmDisk.words(),
        cause: text::AlarmDiskLowCause.words(),
        consequence: text::AlarmDiskConsequence.words(),
        remedy: text::AlarmDiskRemedy.words(),
    }
}

/// Nothing can be recorded.
pub fn recordings() -> Texts {
    Texts {
        priority: Priority::Low,
        what: text::AlarmRecordings.words(),
        cause: text::AlarmRecordingsCause.words(),
        consequence: text::AlarmRecordingsConsequence.words(),
        remedy: text::AlarmRecordingsRemedy.words(),
    }
}

/// The certificate ends soon, or has ended.
pub fn certificate() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: text::AlarmCertificate.words(),
        cause: text::AlarmCertificateCause.words(),
        consequence: text::AlarmCertificateConsequence.words(),
        remedy: text::AlarmCertificateRemedy.words(),
    }
}

/// An entry of the audit log is not the one that was written.
pub fn chain() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: text::AlarmChain.words(),
        cause: text::AlarmChainCause.words(),
        consequence: text::AlarmChainConsequence.words(),
        remedy: text::AlarmChainRemedy.words(),
    }
}

/// Files of the state were lost before this start.
pub fn state() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: text::AlarmState.words(),
        cause: text::AlarmStateCause.words(),
        consequence: text::AlarmStateConsequence.words(),
        remedy: text::AlarmStateRemedy.words(),
    }
}

/// Many logins have failed.
pub fn logins() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: text::AlarmLogins.words(),
        cause: text::AlarmLoginsCause.words(),
        consequence: text::AlarmLoginsConsequence.words(),
        remedy: text::AlarmLoginsRemedy.words(),
    }
}

/// What was revoked is not on the disk.
pub fn revocations() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: text::AlarmRevocations.words(),
        cause: text::AlarmDiskCause.words(),
        consequence: text::AlarmRevocationsConsequence.words(),
        remedy: text::AlarmRevocationsRemedy.words(),
    }
}

/// Modes, masks and refusals of the zones are not on the disk.
pub fn zones() -> Texts {
    Texts {
        priority: Priority::Medium,
        what: text::AlarmZones.words(),
        cause: text::AlarmDiskCause.words(),
        consequence: text::AlarmZonesConsequence.words(),
        remedy: text::AlarmZonesRemedy.words(),
    }
}

/// The disk, or PostgreSQL, does not take the history.
pub fn history() -> Texts {
    Texts {
        priority: Priority::Low,
        what: text::AlarmHistory.words(),
        cause: text::AlarmHistoryCause.words(),
        consequence: text::AlarmHistoryConsequence.words(),
        remedy: text::AlarmHistoryRemedy.words(),
    }
}

/// The disk does not take the event log.
pub fn events() -> Texts {
    Texts {
        priority: Priority::Low,
        what: text::AlarmEvents.words(),
        cause: text::AlarmEventsCause.words(),
        consequence: text::AlarmEventsConsequence.words(),
        remedy: text::AlarmEventsRemedy.words(),
    }
}

/// What a flag leads to.
type Consequence = &'static dyn Text;

/// What a flag leads to; `None`: it only informs.
pub fn consequence(id: SubsystemId, flag: &str) -> Option<Consequence> {
    of_unit(flag)
        .or_else(|| of_monitor(flag))
        .or_else(|| of_motion(id, flag))
        .or_else(|| of_program(flag))
        .or_else(|| flag.ends_with("ButtonState").then_some(&text::FlagButton as Consequence))
}

/// Flags of the parameters, the supply and the electronics of any subsystem.
fn of_unit(flag: &str) -> Option<Consequence> {
    Some(match flag {
        "ConfigFault" => &text::FlagConfigFault,
        "ConfigInvalid" => &text::FlagConfigInvalid,
        "ConfigWriteFault" => &text::FlagConfigWriteFault,
        "ConnLost" => &text::FlagConnLost,
        "BadPower" => &text::FlagBadPower,
        "RemotePaIncomplete" | "RemotePaBadId" | "RemotePaBadVal" | "RemotePaError" => {
            &text::FlagRemote
        }
        "InternalFault" => &text::FlagInternalFault,
        "WdtFault" => &text::FlagWdtFault,
        "ProtocolFault" => &text::FlagProtocolFault,
        _ => return None,
    })
}

/// Flags of the monitor as a whole and of its heating.
fn of_monitor(flag: &str) -> Option<Consequence> {
    Some(match flag {
        "PressureSensorBreak" | "PressureSensorShort" => &text::FlagPressureSensor,
        "LockedOut" => &text::FlagLockedOut,
        "HorizontalFault" | "VerticalFault" | "NozzleFault" | "DeployerFault" | "BoxFault" => {
            &text::FlagHeating
        }
        "HorizontalSensorFault"
        | "VerticalSensorFault"
        | "NozzleSensorFault"
        | "DeployerSensorFault"
        | "BoxSensorFault"
        | "HumiditySensorFault" => &text::FlagHeatingSensor,
        _ => return None,
    })
}

/// Flags of drives and valves.
fn of_motion(id: SubsystemId, flag: &str) -> Option<Consequence> {
    let deployer = id == SubsystemId::DEPLOYER;
    Some(match flag {
        "AmperageOverload" if id.is_valve() => &text::FlagValveOverload,
        "AmperageOverload" if !deployer => &text::FlagDriveOverload,
        "Limitless" => &text::FlagLimitless,
        "AmperageOverload" | "PositionWayFault" | "PosEncoderFault" | "SpeedEncoderFault"
        | "MotorBroken" | "SpeedWayFault" => {
            if deployer {
                &text::FlagDeployer
            } else {
                &text::FlagDrive
            }
        }
        "Blocked" => &text::FlagBlocked,
        "OpenSensorFault" | "CloseSensorFault" => &text::FlagValveSensors,
        _ => return None,
    })
}

/// Flags of programs and of the search.
fn of_program(flag: &str) -> Option<Consequence> {
    Some(match flag {
        "OutsideLimits" => &text::FlagOutsideLimits,
        "ModeFault" => &text::FlagModeFault,
        "TrajectoryPressureFault"
        | "TrajectoryRangeFault"
        | "TrajectoryAngleFault"
        | "TrajectoryCRCFault" => &text::FlagTrajectory,
        "Found" => &text::FlagFound,
        "DeviceFault" => &text::FlagDeviceFault,
        "BadSector" => &text::FlagBadSector,
        "DirtyLens" => &text::FlagDirtyLens,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::flags::flags_of;

    #[test]
    fn every_flag_that_warns_says_what_it_leads_to_in_both_languages() {
        let cyrillic = |text: &str| text.chars().any(|c| ('а'..='я').contains(&c));
        let mut count = 0;
        for id in SubsystemId::TABLE {
            let flags = flags_of(id).flags.iter();
            for flag in flags.filter(|flag| flag.severity >= Severity::Warning) {
                let texts = of_flag(id, flag);
                for text in [texts.what, texts.cause, texts.consequence, texts.remedy] {
                    let fine = text.en.ends_with('.') && text.ru.ends_with('.');
                    assert!(
                        fine && !cyrillic(&text.en) && cyrillic(&text.ru),
                        "{id} {}: {text:?}",
                        flag.name
                    );
                }
                count += 1;
            }
        }
        assert!(count > 150, "{count}");
    }
}
