//! Rules for legal outputs: those of the interlock, by the sampled inputs and the monitor's own answers;
//! and of subsystems that are absent, and motors that draw too much.

use crate::interlock::{Drive, Moment, Travel, Valve};
use lafet_device::Device;
use lafet_device::image::{AXES, Axis, Inputs, Outputs, ValveNo, ValveOutput};
use lafet_proto::param::DriveParam;
use lafet_proto::status::Limits;
use lafet_proto::{SubsystemId, param::Param};

/// Distance beyond a limit that a drive may need to stop, arc-minutes or mm.
const ALLOWANCE: f64 = 2.0;

/// What the monitor reports about itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Said {
    pub is_locked: bool,
    /// Limits in force, by [`Axis`].
    pub limits: [Option<Limits>; AXES],
}

/// Panics on illegal outputs.
pub fn check(device: &Device, said: &Said, is_settled: bool, inputs: &Inputs, outputs: &Outputs) {
    absent(device, outputs);
    let deployer = &inputs.drives[Axis::Deployer as usize];
    let folds = device.has(SubsystemId::DEPLOYER);
    let valve = |valve: ValveNo| {
        let input = &inputs.valves[valve as usize];
        let present = device.has(valve.id());
        Valve {
            open: present && folds && !input.close_switch,
            blocked: present && input.blocked,
            ..Valve::default()
        }
    };
    let moment = Moment {
        settling: !is_settled,
        locked: said.is_locked,
        stowed: folds && (!deployer.max_switch || deployer.min_switch),
        drives: Axis::ALL.map(|axis| drive(device, said, axis, inputs)),
        valves: ValveNo::ALL.map(valve),
        ..Moment::new(outputs)
    };
    if let Some(broken) = moment.judge().first() {
        panic!("{broken}: {outputs:?}");
    }
    for axis in Axis::ALL.into_iter().filter(|axis| speed(outputs, *axis) != 0) {
        let draws_da = i64::from(inputs.drives[axis as usize].current_da);
        let most_da = 2 * i64::from(device.params().drive(axis, DriveParam::MaxCurrent));
        assert!(draws_da <= most_da, "§D/4: {axis:?} over its current");
    }
}

/// Deployment ends at its switches, whatever its limits.
fn drive(device: &Device, said: &Said, axis: Axis, inputs: &Inputs) -> Drive {
    let input = &inputs.drives[axis as usize];
    let limits = said.limits[axis as usize].filter(|_| axis != Axis::Deployer);
    let zero = f64::from(device.params().drive(axis, DriveParam::ZeroPoint));
    let travel = limits.map(|Limits { min, max }| Travel {
        at: f64::from(input.position) - zero,
        min: min.into(),
        max: max.into(),
        allowance: ALLOWANCE,
    });
    Drive { travel, ends: (input.min_switch, input.max_switch) }
}

fn speed(outputs: &Outputs, axis: Axis) -> i16 {
    outputs.drives[axis as usize].speed_tenths
}

/// An absent subsystem is never driven.
fn absent(device: &Device, outputs: &Outputs) {
    for axis in Axis::ALL.into_iter().filter(|axis| !device.has(axis.id())) {
        assert_eq!(speed(outputs, axis), 0, "§1: {axis:?} is not in the chain");
    }
    for no in ValveNo::ALL.into_iter().filter(|no| !device.has(no.id())) {
        assert_eq!(outputs.valves[no as usize], ValveOutput::Off, "§1: {no:?} is not in the chain");
    }
    if !device.has(SubsystemId::CLIMATICS) {
        assert!(!outputs.heaters.contains(&true), "§1: Climatics is not in the chain");
    }
}

/// A parameter that the monitor stores, chosen by `index`.
pub fn param(index: usize) -> Param {
    Param::ALL[index % Param::COUNT]
}
