//! §D/5 (ours) The last filter between what the subsystems want and what the HAL gets.
//!
//! It knows nothing of requests and trusts no subsystem: it judges by the inputs of this very
//! step. It only ever takes away, except that lockout makes valves close.

use crate::image::{
    AXES, Axis, DriveInput, DriveOutput, Inputs, Outputs, VALVES, ValveInput, ValveOutput,
};

/// How long after power-up everything stays inert, ms: sensors settle, supplies rise.
pub const SETTLE_MS: u32 = 100;

/// What the guard has to know besides the inputs.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Power-up is over.
    pub settled: bool,
    /// §3.18 Locked out.
    pub locked: bool,
    /// There is a Deployer: aiming and water need the working position.
    pub deployer: bool,
    /// Which valves there are.
    pub valves: [bool; VALVES],
    /// Limits of each drive in its encoder's own coordinates, with the allowance for arriving;
    /// `None` while they are off.
    pub limits: [Option<(i32, i32)>; AXES],
    /// Current above which a drive is cut off at once, 0.1 A.
    pub current_da: [i32; AXES],
}

/// What may reach the hardware of what is wanted.
pub fn filter(rules: &Rules, inputs: &Inputs, wanted: &Outputs) -> Outputs {
    let mut allowed = *wanted;
    let [_, _, _, deployer] = &inputs.drives;
    let [_, _, _, folding] = &wanted.drives;
    let working =
        !rules.deployer || deployer.max_switch && !deployer.min_switch && folding.speed_tenths == 0;
    let mut valves = rules.valves.iter().zip(&inputs.valves);
    for (output, (present, input)) in allowed.valves.iter_mut().zip(valves.clone()) {
        *output = match present {
            true => valve_output(rules, working, input, *output),
            false => ValveOutput::Off,
        };
    }
    let water = valves.any(|(present, valve)| *present && !valve.close_switch);
    let drives = allowed.drives.iter_mut().zip(&inputs.drives).zip(Axis::ALL);
    let bounds = rules.limits.iter().zip(&rules.current_da);
    for (((output, input), axis), (limits, current_da)) in drives.zip(bounds) {
        // Folding with water in the barrel destroys it; aiming a folded barrel does too.
        let position_allows = match axis {
            Axis::Deployer => !(water && rules.deployer && folding.speed_tenths < 0),
            Axis::Vertical | Axis::Horizontal | Axis::Nozzle => working,
        };
        let free = rules.settled
            && !rules.locked
            && position_allows
            && i32::from(input.current_da) <= *current_da;
        *output = if free { within(*limits, input, *output) } else { DriveOutput::default() };
    }
    if !rules.settled {
        allowed.heaters = Default::default();
    }
    allowed
}

fn valve_output(
    rules: &Rules,
    working: bool,
    input: &ValveInput,
    wanted: ValveOutput,
) -> ValveOutput {
    match wanted {
        _ if !rules.settled => ValveOutput::Off,
        _ if rules.locked && !input.close_switch => ValveOutput::Closing,
        ValveOutput::Opening if rules.locked || !working || input.blocked => ValveOutput::Off,
        other => other,
    }
}

/// Never further out of the limits, never into a closed end switch.
fn within(limits: Option<(i32, i32)>, input: &DriveInput, wanted: DriveOutput) -> DriveOutput {
    let (min, max) = limits.unwrap_or((i32::MIN, i32::MAX));
    let speed = wanted.speed_tenths;
    let stopped = speed > 0 && (input.max_switch || input.position > max)
        || speed < 0 && (input.min_switch || input.position < min);
    if stopped { DriveOutput::default() } else { wanted }
}
