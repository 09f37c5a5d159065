//! Rules for legal outputs, written from the document independently of `guard`: one rule at a time,
//! from the sampled inputs and the monitor's own answers.

use lafet_device::Device;
use lafet_device::image::{AXES, Axis, DriveInput, Inputs, Outputs, VALVES, ValveNo, ValveOutput};
use lafet_proto::param::DriveParam;
use lafet_proto::status::Limits;
use lafet_proto::{SubsystemId, param::Param};

/// Distance beyond a limit that a drive may need to stop, arc-minutes or mm.
const ALLOWANCE: i64 = 2;

/// What the monitor reports about itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Said {
    pub is_locked: bool,
    /// §3.3.1/4 Nothing is erased on it.
    pub has_bad_power: bool,
    /// Limits in force, by [`Axis`].
    pub limits: [Option<Limits>; AXES],
}

/// Panics on the first illegal output.
pub fn check(device: &Device, said: &Said, is_settled: bool, inputs: &Inputs, outputs: &Outputs) {
    if !is_settled {
        let mut inert = Outputs::default();
        inert.units = outputs.units;
        assert_eq!(*outputs, inert, "§D/1: driven before it has settled");
    }
    absent(device, outputs);
    let deployer = &inputs.drives[Axis::Deployer as usize];
    let folding = speed(outputs, Axis::Deployer);
    let works = !device.has(SubsystemId::DEPLOYER)
        || deployer.max_switch && !deployer.min_switch && folding == 0;
    for axis in Axis::ALL {
        let speed = speed(outputs, axis);
        let input = &inputs.drives[axis as usize];
        if speed == 0 {
            continue;
        }
        assert!(!said.is_locked, "§3.18: {axis:?} moves while locked out");
        assert!(works || axis == Axis::Deployer, "§3.1/1: {axis:?} moves while folded");
        assert!(!(speed > 0 && input.max_switch), "§3.3.4: {axis:?} into its upper switch");
        assert!(!(speed < 0 && input.min_switch), "§3.3.4: {axis:?} into its lower switch");
        within_limits(device, said, axis, input, speed);
        let current_da = i64::from(device.params().drive(axis, DriveParam::MaxCurrent));
        assert!(i64::from(input.current_da) <= 2 * current_da, "§D/4: {axis:?} over its current");
    }
    valves(device, said, works, inputs, outputs);
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

/// §3.3.4: no further out while limits are on. Deployment ends at its switches.
fn within_limits(device: &Device, said: &Said, axis: Axis, input: &DriveInput, speed: i16) {
    let Some(Limits { min, max }) = said.limits[axis as usize] else { return };
    if axis == Axis::Deployer {
        return;
    }
    let zero = i64::from(device.params().drive(axis, DriveParam::ZeroPoint));
    let position = i64::from(input.position) - zero;
    let is_out = speed > 0 && position > i64::from(max) + ALLOWANCE
        || speed < 0 && position < i64::from(min) - ALLOWANCE;
    assert!(!is_out, "§3.3.4: {axis:?} at {position} leaves {min}…{max}");
}

fn valves(device: &Device, said: &Said, works: bool, inputs: &Inputs, outputs: &Outputs) {
    let mut water = false;
    for index in 0..VALVES {
        if !device.has(ValveNo::ALL[index].id()) {
            continue;
        }
        let (input, output) = (&inputs.valves[index], outputs.valves[index]);
        water |= !input.close_switch;
        if output == ValveOutput::Opening {
            assert!(works, "§3.8/1: valve {index} opens while folded");
            assert!(!said.is_locked, "§3.18: valve {index} opens while locked out");
            assert!(!input.blocked, "§3.3.5: valve {index} opens while blocked");
        }
    }
    let folds = device.has(SubsystemId::DEPLOYER) && speed(outputs, Axis::Deployer) < 0;
    assert!(!(folds && water), "§3.11/5: folds with water in the barrel");
}

/// A parameter that the monitor stores, chosen by `index`.
pub fn param(index: usize) -> Param {
    Param::ALL[index % Param::COUNT]
}
