//! The faults that can be injected, with their texts.

use lafet_hub::simulation;
use lafet_hub::text::Both;
use lafet_sim::fault::{
    ButtonFault, DriveFault, Fault, SingleFault, UnitFault, ValveFault, axis_name, place_name,
    unit_name, valve_name,
};
use lafet_texts::{Fixed, Text as _, cli as text};

/// All faults: name, group and text.
pub fn catalogue() -> Vec<simulation::Fault> {
    let one = |fault: Fault| {
        let group = group(fault);
        let group_text = group_words(group).words();
        simulation::Fault { name: fault.name(), group, group_text, text: words(fault) }
    };
    Fault::all().map(one).collect()
}

/// Name of the part of the monitor that a fault belongs to.
fn group(fault: Fault) -> &'static str {
    match fault {
        Fault::Drive(axis, _) => axis_name(axis),
        Fault::Valve(valve, _) => valve_name(valve),
        Fault::Temperature(place)
        | Fault::TemperatureFrozen(place)
        | Fault::TemperatureDrift(place)
        | Fault::Heater(place) => place_name(place),
        Fault::Unit(unit, _) => unit_name(unit),
        Fault::Button(post, ..) => post.name(),
        Fault::Single(fault) => match fault {
            SingleFault::PressureBreak
            | SingleFault::PressureShort
            | SingleFault::PressureFrozen
            | SingleFault::PressureDrift
            | SingleFault::FlowFrozen
            | SingleFault::FlowDrift
            | SingleFault::PumpOff
            | SingleFault::PumpWeak => "water",
            SingleFault::DetectorDead | SingleFault::DetectorSaturated | SingleFault::DirtyLens => {
                "detector"
            }
            SingleFault::Humidity => "box",
            _ => "general",
        },
    }
}

fn group_words(group: &str) -> Fixed {
    match group {
        "vertical" => text::PartVertical.fixed(),
        "horizontal" => text::PartHorizontal.fixed(),
        "nozzle" => text::PartNozzle.fixed(),
        "deployer" => text::PartDeployer.fixed(),
        "valve1" => text::PartValve1.fixed(),
        "valve2" => text::PartValve2.fixed(),
        "box" => text::PartBox.fixed(),
        "buttons" => text::PartButtons.fixed(),
        "ext-buttons" => text::PartExtButtons.fixed(),
        "water" => text::PartWater.fixed(),
        "detector" => text::PartDetector.fixed(),
        _ => text::PartMonitor.fixed(),
    }
}

fn words(fault: Fault) -> Both {
    match fault {
        Fault::Drive(_, fault) => of(drive(fault)),
        Fault::Valve(_, fault) => of(valve(fault)),
        Fault::Temperature(_) => of(text::FaultTemperatureDead.fixed()),
        Fault::TemperatureFrozen(_) => of(text::FaultTemperatureFrozen.fixed()),
        Fault::TemperatureDrift(_) => of(text::FaultTemperatureDrift.fixed()),
        Fault::Heater(_) => of(text::FaultHeater.fixed()),
        Fault::Unit(_, fault) => of(unit(fault)),
        Fault::Button(_, button, fault) => {
            let what = match fault {
                ButtonFault::Short => text::FaultButtonShort.fixed(),
                ButtonFault::Break => text::FaultButtonBreak.fixed(),
                ButtonFault::Bounce => text::FaultButtonBounce.fixed(),
            };
            text::FaultButton { button: format_args!("{button:?}"), what }.words()
        }
        Fault::Single(fault) => of(single(fault)),
    }
}

fn of(text: Fixed) -> Both {
    text.words()
}

const fn drive(fault: DriveFault) -> Fixed {
    match fault {
        DriveFault::MotorOpen => text::FaultMotorOpen.fixed(),
        DriveFault::Jam => text::FaultJam.fixed(),
        DriveFault::PowerStage => text::FaultPowerStage.fixed(),
        DriveFault::Runaway => text::FaultRunaway.fixed(),
        DriveFault::Friction => text::FaultFriction.fixed(),
        DriveFault::Flicker => text::FaultFlicker.fixed(),
        DriveFault::Lag => text::FaultLag.fixed(),
        DriveFault::DeadBand => text::FaultDeadBand.fixed(),
        DriveFault::Droop => text::FaultDroop.fixed(),
        DriveFault::Backlash => text::FaultBacklash.fixed(),
        DriveFault::Stiff => text::FaultStiff.fixed(),
        DriveFault::EncoderDead => text::FaultEncoderDead.fixed(),
        DriveFault::EncoderReversed => text::FaultEncoderReversed.fixed(),
        DriveFault::EncoderFast => text::FaultEncoderFast.fixed(),
        DriveFault::EncoderJump => text::FaultEncoderJump.fixed(),
        DriveFault::EncoderNoise => text::FaultEncoderNoise.fixed(),
        DriveFault::EncoderFault => text::FaultEncoderFault.fixed(),
        DriveFault::SpeedDead => text::FaultSpeedDead.fixed(),
        DriveFault::SpeedReversed => text::FaultSpeedReversed.fixed(),
        DriveFault::SpeedFault => text::FaultSpeedFault.fixed(),
        DriveFault::MinSwitch => text::FaultMinSwitch.fixed(),
        DriveFault::MaxSwitch => text::FaultMaxSwitch.fixed(),
        DriveFault::MinBounce => text::FaultMinBounce.fixed(),
        DriveFault::MaxBounce => text::FaultMaxBounce.fixed(),
    }
}

const fn valve(fault: ValveFault) -> Fixed {
    match fault {
        ValveFault::MotorOpen => text::FaultMotorOpen.fixed(),
        ValveFault::OpenRelay => text::FaultOpenRelay.fixed(),
        ValveFault::Jam => text::FaultValveJam.fixed(),
        ValveFault::OpenSwitch => text::FaultOpenSwitch.fixed(),
        ValveFault::CloseSwitch => text::FaultCloseSwitch.fixed(),
        ValveFault::CloseStuck => text::FaultCloseStuck.fixed(),
        ValveFault::Blocked => text::FaultBlocked.fixed(),
        ValveFault::OpenBounce => text::FaultOpenBounce.fixed(),
        ValveFault::CloseBounce => text::FaultCloseBounce.fixed(),
        ValveFault::BlockedBounce => text::FaultBlockedBounce.fixed(),
    }
}

const fn unit(fault: UnitFault) -> Fixed {
    match fault {
        UnitFault::Offline => text::FaultUnitOffline.fixed(),
        UnitFault::Lossy => text::FaultUnitLossy.fixed(),
        UnitFault::Protocol => text::FaultUnitProtocol.fixed(),
        UnitFault::Watchdog => text::FaultUnitWatchdog.fixed(),
        UnitFault::ParamSilent => text::FaultRemoteNoAnswer.fixed(),
        UnitFault::ParamIncomplete => text::FaultRemoteIncomplete.fixed(),
        UnitFault::ParamBadId => text::FaultRemoteBadId.fixed(),
        UnitFault::ParamBadValue => text::FaultRemoteBadValue.fixed(),
        UnitFault::ParamError => text::FaultRemoteError.fixed(),
    }
}

const fn single(fault: SingleFault) -> Fixed {
    match fault {
        SingleFault::PressureBreak => text::FaultPressureBreak.fixed(),
        SingleFault::PressureShort => text::FaultPressureShort.fixed(),
        SingleFault::PressureFrozen => text::FaultPressureFrozen.fixed(),
        SingleFault::PressureDrift => text::FaultPressureDrift.fixed(),
        SingleFault::FlowFrozen => text::FaultFlowFrozen.fixed(),
        SingleFault::FlowDrift => text::FaultFlowDrift.fixed(),
        SingleFault::PumpOff => text::FaultPumpOff.fixed(),
        SingleFault::PumpWeak => text::FaultPumpWeak.fixed(),
        SingleFault::VoltageLow => text::FaultSupplyLow.fixed(),
        SingleFault::VoltageHigh => text::FaultSupplyHigh.fixed(),
        SingleFault::SupplyDip => text::FaultSupplyDip.fixed(),
        SingleFault::SupplySag => text::FaultSupplySag.fixed(),
        SingleFault::Humidity => text::FaultHumidity.fixed(),
        SingleFault::DetectorDead => text::FaultDetectorDead.fixed(),
        SingleFault::DetectorSaturated => text::FaultDetectorSaturated.fixed(),
        SingleFault::DirtyLens => text::FaultDirtyLens.fixed(),
        SingleFault::FlashRead => text::FaultMemoryRead.fixed(),
        SingleFault::FlashWrite => text::FaultMemoryWrite.fixed(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_its_words_once() {
        let all = catalogue();
        assert_eq!(all.len(), Fault::all().count());
        let mut words: Vec<(&str, &str)> = all.iter().map(|it| (it.group, &*it.text.ru)).collect();
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), all.len(), "two faults of a part have the same words");
    }
}
