//! §D/5 (ours) The last filter between what the subsystems want and what the HAL gets.
//!
//! It knows nothing of requests and trusts no subsystem: it judges by the inputs of this very
//! step, its contacts judged (§D/6) but for end switches that close, which stop at once. It only ever takes away, except that lockout makes valves close; and it says by which rule.

use crate::cause::{Cause, Causes, Rule};
use crate::image::{
    AXES, Axis, DriveInput, DriveOutput, Inputs, Outputs, VALVES, ValveInput, ValveOutput,
};
use crate::inputs::FLOWING_LPS;

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
    /// Which of them were driven towards closed for all their time in vain: no motor is fed without end.
    pub spent: [bool; VALVES],
    /// Limits of each drive in its encoder's own coordinates, with the allowance for arriving;
    /// `None` while they are off.
    pub limits: [Option<(i32, i32)>; AXES],
    /// Current above which a drive is cut off at once, 0.1 A.
    pub current_da: [i32; AXES],
}

/// Outputs that the guard has passed. By default everything is inert; no others can be made without
/// [`filter`], and [`Hal::write`](crate::hal::Hal::write) takes no others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passed(Outputs);

impl Passed {
    /// The outputs.
    pub const fn outputs(&self) -> &Outputs {
        &self.0
    }

    /// Nothing is driven; the supplies that are cut stay so.
    pub(crate) fn inert(&self) -> Self {
        let drives =
            self.0.drives.map(|DriveOutput { cut, .. }| DriveOutput { speed_tenths: 0, cut });
        Self(Outputs { drives, ..Outputs::default() })
    }
}

impl core::ops::Deref for Passed {
    type Target = Outputs;

    fn deref(&self) -> &Outputs {
        &self.0
    }
}

/// What may reach the hardware of what is wanted. Where that is something else, the rule takes the
/// place of the cause.
#[inline(never)]
pub fn filter(rules: &Rules, inputs: &Inputs, wanted: &Outputs, causes: &mut Causes) -> Passed {
    let mut allowed = *wanted;
    let [_, _, _, deployer] = &inputs.drives;
    let [_, _, _, folding] = &wanted.drives;
    let working =
        !rules.deployer || deployer.max_switch && !deployer.min_switch && folding.speed_tenths == 0;
    let mut valves = rules.valves.iter().zip(&inputs.valves);
    let judged = allowed.valves.iter_mut().zip(&mut causes.valves).zip(valves.clone());
    for (((output, cause), (present, input)), spent) in judged.zip(&rules.spent) {
        let locked = rules.locked && !input.close_switch && !spent;
        let instead = match present {
            true if locked && rules.settled => Some((ValveOutput::Closing, Rule::Lockout)),
            true => instead_of_valve(rules, working, input, *output),
            false => Some((ValveOutput::Off, Rule::Absent)),
        };
        if let Some((passes, rule)) = instead {
            replace(output, passes, cause, rule);
        }
    }
    let water = valves.any(|(present, valve)| *present && !valve.close_switch)
        || inputs.flow_lps >= FLOWING_LPS;
    let drives = allowed.drives.iter_mut().zip(&inputs.drives).zip(&Axis::ALL);
    let bounds = rules.limits.iter().zip(&rules.current_da).zip(&mut causes.drives);
    for (((output, input), axis), ((limits, current_da), cause)) in drives.zip(bounds) {
        // Folding with water in the barrel destroys it; aiming a folded barrel does too.
        let rule = match *axis {
            _ if !rules.settled => Some(Rule::Inert),
            _ if rules.locked => Some(Rule::Lockout),
            Axis::Deployer if water && rules.deployer && folding.speed_tenths < 0 => {
                Some(Rule::Water)
            }
            Axis::Vertical | Axis::Horizontal | Axis::Nozzle if !working => Some(Rule::NotDeployed),
            _ if i32::from(input.current_da) > *current_da => Some(Rule::CutOff),
            _ => stopped_at(*limits, input, *output),
        };
        if let Some(rule) = rule {
            let stopped = DriveOutput { speed_tenths: 0, ..*output };
            replace(output, stopped, cause, rule);
        }
    }
    if !rules.settled {
        for (output, cause) in allowed.heaters.iter_mut().zip(&mut causes.heaters) {
            replace(output, false, cause, Rule::Inert);
        }
    }
    Passed(allowed)
}

/// What passes as it is keeps its cause.
fn replace<T: PartialEq>(output: &mut T, passes: T, cause: &mut Cause, rule: Rule) {
    if *output != passes {
        (*output, *cause) = (passes, Cause::Rule(rule));
    }
}

fn instead_of_valve(
    rules: &Rules,
    working: bool,
    input: &ValveInput,
    wanted: ValveOutput,
) -> Option<(ValveOutput, Rule)> {
    match wanted {
        _ if !rules.settled => Some((ValveOutput::Off, Rule::Inert)),
        ValveOutput::Opening if rules.locked => Some((ValveOutput::Off, Rule::Lockout)),
        ValveOutput::Opening if !working => Some((ValveOutput::Off, Rule::NotDeployed)),
        ValveOutput::Opening if input.blocked => Some((ValveOutput::Off, Rule::Blocked)),
        _ => None,
    }
}

/// Never further out of the limits, never into a closed end switch.
fn stopped_at(limits: Option<(i32, i32)>, input: &DriveInput, wanted: DriveOutput) -> Option<Rule> {
    let (min, max) = limits.unwrap_or((i32::MIN, i32::MAX));
    let (end, beyond) = match wanted.speed_tenths {
        0 => return None,
        1.. => (input.max_switch, input.position > max),
        ..0 => (input.min_switch, input.position < min),
    };
    end.then_some(Rule::EndSwitch).or(beyond.then_some(Rule::Limit))
}
