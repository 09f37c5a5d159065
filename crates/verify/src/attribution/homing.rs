//! §D/7 Position sensors that count from where the program has started: from when on a position is known,
//! and by how much it differs from what is read.

use lafet_device::guard::SETTLE_MS;
use lafet_device::image::{AXES, Axis, DriveInput};
use lafet_device::params::Params;
use lafet_proto::param::{DriveParam, Param};
use lafet_sim::fault::{DriveFault, Fault};

use super::View;

/// A drive has left the switch at which it has started after this way, ' or mm.
const LEFT_ARCMIN: u32 = 60;
const LEFT_MM: u32 = 1;
/// §D/6 A contact counts when it has lasted for more steps than these.
const LASTING_STEPS: u8 = 3;
/// Bit of InputFaults for the first axis: its position is not known.
const NOT_HOMED_BIT: usize = 8;

/// A drive.
#[derive(Clone, Copy, Debug, Default)]
struct Homing {
    /// The end at which it is homed, up/left (true) or down/right, while its position is not known.
    end: Option<bool>,
    /// Reading at the start.
    start: i32,
    /// It has started off the switch there, or has left it.
    left: bool,
    /// When it has started: the inputs settle for a time, in which a program may stand still.
    started_ms: Option<u64>,
    /// For how many of the last steps that switch is closed.
    closed_steps: u8,
    /// It was driven there in the step before.
    driven: bool,
    /// For how many steps the switch at the other end is closed.
    other_steps: u8,
    /// What is added to each reading.
    offset: i32,
}

/// All drives.
#[derive(Clone, Copy, Debug, Default)]
pub struct Homings {
    drives: [Homing; AXES],
    /// At which ends they are homed, as the parameters had it when the program started: what is set before its
    /// first step is for the next start.
    ends: Option<[Option<bool>; AXES]>,
    /// How many times a drive was homed.
    pub homed: u64,
}

impl Homings {
    /// The program starts again: what counts from there has to be homed again.
    pub(super) fn powered_up(&self, params: &Params) -> Self {
        let ends = Axis::ALL.map(|axis| end_of(axis, params));
        Self { ends: Some(ends), homed: self.homed, ..Self::default() }
    }

    /// The first step: each drive is where it was switched on.
    pub(super) fn start(&mut self, view: &View<'_>) {
        let ends = self.ends.take();
        let ends = ends.unwrap_or_else(|| Axis::ALL.map(|axis| end_of(axis, view.params)));
        self.drives = ends.map(Homing::starting);
    }

    /// Takes over what is sensed and reported; returns which drives claim to know their position and cannot.
    pub(super) fn follow(&mut self, view: &View<'_>) -> Vec<Axis> {
        let bits = view.device.input_faults();
        let mut wrong = Vec::new();
        for (axis, homing) in Axis::ALL.into_iter().zip(&mut self.drives) {
            let told = bits & 1 << (NOT_HOMED_BIT + axis as usize) != 0;
            let Some(up) = homing.end else {
                if told {
                    wrong.push(axis);
                }
                continue;
            };
            let input = &view.inputs.drives[axis as usize];
            let far = if axis == Axis::Nozzle { LEFT_MM } else { LEFT_ARCMIN };
            let closed = is_closed(up, input);
            homing.closed_steps = if closed { homing.closed_steps.saturating_add(1) } else { 0 };
            homing.start(view.now_ms, input);
            // A switch that has closed counts once it has lasted.
            let off = homing.closed_steps <= LASTING_STEPS;
            homing.left |= off && input.position.abs_diff(homing.start) >= far;
            let other = is_closed(!up, input);
            homing.other_steps = if other { homing.other_steps.saturating_add(1) } else { 0 };
            if !told {
                // A switch that lies may have closed before the drive could move.
                let lies = [DriveFault::MinSwitch, DriveFault::MaxSwitch]
                    .iter()
                    .any(|fault| view.faults.contains(&Fault::Drive(axis, *fault)));
                // Both ends at a time are none, but a blip of the other one is no end.
                let one = closed && homing.other_steps <= LASTING_STEPS;
                if !(one && homing.left && (homing.driven || lies)) {
                    wrong.push(axis);
                }
                homing.end = None;
                homing.offset = home_position(axis, view.params).saturating_sub(input.position);
                self.homed += 1;
            }
        }
        wrong
    }

    /// Takes over what was driven, or held back at the switch, in this step.
    pub(super) fn settle(&mut self, view: &View<'_>) {
        for (axis, homing) in Axis::ALL.into_iter().zip(&mut self.drives) {
            let Some(up) = homing.end else { continue };
            let speed = view.outputs.drives[axis as usize].speed_tenths;
            let there = if up { speed > 0 } else { speed < 0 };
            let held = speed == 0 && is_closed(up, &view.inputs.drives[axis as usize]);
            homing.driven = there || homing.driven && held;
        }
    }

    /// Its position is not known: it has no limits.
    pub fn is_unknown(&self, axis: Axis) -> bool {
        self.drives[axis as usize].end.is_some()
    }

    /// What is added to the readings.
    pub(super) fn offsets(&self) -> [i32; AXES] {
        self.drives.map(|homing| homing.offset)
    }
}

impl Homing {
    fn starting(end: Option<bool>) -> Self {
        Self { end, left: true, ..Self::default() }
    }

    /// A switch that has lasted as closed while the inputs settle is where it has started.
    fn start(&mut self, now_ms: u64, input: &DriveInput) {
        let started_ms = *self.started_ms.get_or_insert(now_ms);
        if now_ms - started_ms < u64::from(SETTLE_MS) {
            self.start = input.position;
            self.left &= self.closed_steps <= LASTING_STEPS;
        }
    }
}

/// The end at which a drive is homed that starts with these parameters.
fn end_of(axis: Axis, params: &Params) -> Option<bool> {
    let local = params.drive(axis, DriveParam::DriveType) == 0;
    let homing = Param::by_name(axis.id(), "Homing").map_or(0, |param| params.get(param));
    match homing {
        1 if local => Some(false),
        2 if local => Some(true),
        _ => None,
    }
}

fn home_position(axis: Axis, params: &Params) -> i32 {
    Param::by_name(axis.id(), "HomePosition").map_or(0, |param| params.get(param))
}

const fn is_closed(up: bool, input: &DriveInput) -> bool {
    if up { input.max_switch } else { input.min_switch }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attribution::Told;
    use lafet_sim::sim::{Config, Sim};

    /// A drive that has not been at its end, and reports that its position is known, is found out.
    #[test]
    fn a_claim() {
        let mut sim = Sim::new(Config::default());
        (0..20).for_each(|_| sim.tick());
        let told = Told::ask(&mut sim);
        let view = View::of(&sim, told);
        let mut homings = Homings::default();
        homings.start(&view);
        assert_eq!(homings.follow(&view), []);
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            homings.drives[axis as usize].end = Some(true);
            assert_eq!(homings.follow(&view), [axis]);
            assert_eq!(homings.follow(&view), [], "reported once");
        }
        assert_eq!(homings.homed, 3);
    }

    /// At its end a blip of the other switch says nothing, and one that lasts makes both of them none.
    #[test]
    fn a_blip_at_the_other_end() {
        let mut sim = Sim::new(Config::default());
        (0..20).for_each(|_| sim.tick());
        let told = Told::ask(&mut sim);
        let view = View::of(&sim, told);
        let axis = Axis::Vertical;
        let mut both = view.inputs.clone();
        (both.drives[axis as usize].min_switch, both.drives[axis as usize].max_switch) =
            (true, true);
        let bounced = View { inputs: &both, ..view };
        for (steps, wrong) in [(0, vec![]), (LASTING_STEPS, vec![axis])] {
            let mut homings = Homings::default();
            homings.start(&view);
            let arrived =
                Homing { left: true, driven: true, other_steps: steps, ..Homing::default() };
            homings.drives[axis as usize] = Homing { end: Some(false), ..arrived };
            assert_eq!(homings.follow(&bounced), wrong, "{steps}");
        }
    }
}
