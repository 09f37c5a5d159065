//! Outputs that are not what the device gives.

use lafet_device::cause::{Cause, Causes, Rule};
use lafet_device::guard::SETTLE_MS;
use lafet_device::image::{Axis, DriveOutput, Outputs, ValveOutput};
use lafet_proto::flags::{ControlFlags, DriveFlags, GeneralFlags};
use lafet_proto::param::{DriveParam, Param};
use lafet_proto::{RequestId, SubsystemId};
use lafet_verify::attribution::View;
use lafet_verify::swarm::Wrong;

use super::Seeded;

pub const ALL: &[Seeded] = &[
    ("a drive starts by itself", starts, &["vertical 0.0 → 5.0 is not explained"]),
    ("a drive turns the wrong way", turns_round, &["it moves away from the destination"]),
    ("a drive is faster than its Speed", hurries, &["faster than it is set to"]),
    ("a drive goes on after a stop", runs_on, &["is not explained"]),
    ("a drive goes on behind its program", outlives, &["the program", "no such program"]),
    ("a program moves while it is paused", moves_in_pause, &["the program is paused"]),
    ("a drive goes on when the button is released", clings, &["no such button is held"]),
    ("a drive moves under lockout", moves_locked, &["under lockout", "is not explained"]),
    ("a drive overruns its limits", overruns, &["is driven out of its limits"]),
    ("a folded barrel is aimed", aims_folded, &["is not explained"]),
    ("the barrel is folded with water in it", folds_wet, &["is not explained"]),
    ("a valve opens by itself", opens, &["a rule never opens"]),
    ("a valve opens under lockout", opens_locked, &["a rule never opens"]),
    ("a valve is not closed under lockout", stays_open, &["is not being closed under lockout"]),
    ("a folded barrel gets water", floods, &["a rule never opens"]),
    (
        "a valve goes on after a stop",
        opens_on,
        &["no such request is in force", "no such button was pressed"],
    ),
    ("an opening that has ended comes back", comes_back, &["no such request is in force"]),
    ("an output is on before the sensors have settled", hastens, &["sensors have settled"]),
    ("an output changes while the program is stopped", haunts, &["program stood still"]),
    ("a heater is on in the warm", heats, &["the condition of the rule does not hold"]),
    ("a heater is off in the cold", freezes, &["the condition of the rule does not hold"]),
];

/// A wrong that is a function of what there is to see.
struct Drives<F>(F);

impl<F: FnMut(&View<'_>, &mut Outputs, &mut Causes)> Wrong for Drives<F> {
    fn drives(&mut self, view: &View<'_>, still: bool, outputs: &mut Outputs, causes: &mut Causes) {
        if !still {
            (self.0)(view, outputs, causes);
        }
    }
}

/// Boxes it.
pub fn drives(act: impl FnMut(&View<'_>, &mut Outputs, &mut Causes) + 'static) -> Box<dyn Wrong> {
    Box::new(Drives(act))
}

const VERTICAL: usize = Axis::Vertical as usize;
const HORIZONTAL: usize = Axis::Horizontal as usize;
const DEPLOYER: usize = Axis::Deployer as usize;

fn speed(speed_tenths: i16) -> DriveOutput {
    DriveOutput { speed_tenths, cut: false }
}

fn is_locked(view: &View<'_>) -> bool {
    view.told.general & GeneralFlags::LOCKED_OUT.bits() != 0
}

fn starts() -> Box<dyn Wrong> {
    drives(|view, outputs, _| {
        if view.now_ms == 20_000 && outputs.drives[VERTICAL].speed_tenths == 0 {
            outputs.drives[VERTICAL] = speed(50);
        }
    })
}

fn turns_round() -> Box<dyn Wrong> {
    drives(|_, outputs, causes| {
        if matches!(causes.drives[HORIZONTAL], Cause::Request(_)) {
            outputs.drives[HORIZONTAL].speed_tenths *= -1;
        }
    })
}

fn hurries() -> Box<dyn Wrong> {
    drives(|view, outputs, _| {
        let set = 10 * view.params.drive(Axis::Horizontal, DriveParam::Speed) as i16;
        let output = &mut outputs.drives[HORIZONTAL];
        if output.speed_tenths.abs() == set {
            output.speed_tenths += output.speed_tenths.signum();
        }
    })
}

/// Goes on with what it did, and the cause it had, for as long as `goes_on` says of the new cause.
fn keeps(axis: Axis, goes_on: impl Fn(Cause, Cause) -> bool + 'static) -> Box<dyn Wrong> {
    let mut last = (DriveOutput::default(), Cause::Rule(Rule::Inert));
    drives(move |_, outputs, causes| {
        let (output, cause) =
            (&mut outputs.drives[axis as usize], &mut causes.drives[axis as usize]);
        let stopped = output.speed_tenths == 0 && last.0.speed_tenths != 0;
        if stopped && goes_on(last.1, *cause) {
            (*output, *cause) = last;
        } else {
            last = (*output, *cause);
        }
    })
}

fn runs_on() -> Box<dyn Wrong> {
    keeps(
        Axis::Horizontal,
        |_, now| matches!(now, Cause::Request(asked) if asked.request == RequestId::STOP),
    )
}

fn outlives() -> Box<dyn Wrong> {
    keeps(Axis::Horizontal, |before, now| {
        matches!(before, Cause::Program(..)) && now == Cause::Rule(Rule::ProgramEnd)
    })
}

fn clings() -> Box<dyn Wrong> {
    keeps(Axis::Vertical, |_, now| now == Cause::Rule(Rule::Released))
}

/// What stops it elsewhere is another wrong: it goes on where it has reached a limit.
fn overruns() -> Box<dyn Wrong> {
    let mut last = (DriveOutput::default(), Cause::Rule(Rule::Inert));
    drives(move |view, outputs, causes| {
        let told = DriveFlags::from_bits_retain(view.told.drives[VERTICAL]);
        let at_limit = told.intersects(
            DriveFlags::MIN_LIMIT_REACHED
                | DriveFlags::MAX_LIMIT_REACHED
                | DriveFlags::ABSOLUTE_MIN_LIMIT_REACHED
                | DriveFlags::ABSOLUTE_MAX_LIMIT_REACHED,
        );
        let (output, cause) = (&mut outputs.drives[VERTICAL], &mut causes.drives[VERTICAL]);
        let stopped = output.speed_tenths == 0 && last.0.speed_tenths != 0;
        // A program that has arrived has ended: that is another wrong.
        let goes_on = !matches!(last.1, Cause::Program(..))
            && [Rule::Arrived, Rule::Limit, Rule::EndSwitch, Rule::Overload, Rule::CutOff]
                .map(Cause::Rule)
                .contains(cause);
        if stopped && at_limit && goes_on {
            (*output, *cause) = last;
        } else {
            last = (*output, *cause);
        }
    })
}

fn moves_in_pause() -> Box<dyn Wrong> {
    let mut last = None;
    drives(move |view, outputs, causes| {
        let told = ControlFlags::from_bits_retain(view.told.control);
        let paused = told.contains(ControlFlags::PAUSED);
        // What has ended is another wrong.
        last = last.filter(|_| told.contains(ControlFlags::QUENCH));
        let cause = &mut causes.drives[VERTICAL];
        if let Cause::Program(..) = *cause {
            last = Some(*cause);
        } else if let (true, Some(program)) = (paused, last)
            && outputs.drives[VERTICAL].speed_tenths == 0
            && *cause == Cause::Rule(Rule::Paused)
        {
            (outputs.drives[VERTICAL], *cause) = (speed(10), program);
        }
    })
}

fn moves_locked() -> Box<dyn Wrong> {
    drives(|view, outputs, _| {
        if is_locked(view) {
            outputs.drives[HORIZONTAL] = speed(-10);
        }
    })
}

fn aims_folded() -> Box<dyn Wrong> {
    let mut moved = None;
    drives(move |view, outputs, causes| {
        moved = [moved, Some(causes.drives[HORIZONTAL])].into_iter().flatten().find(
            |cause| matches!(cause, Cause::Request(asked) if asked.request == RequestId::MOVE),
        );
        if let (false, Some(cause)) = (view.deployed, moved) {
            (outputs.drives[HORIZONTAL], causes.drives[HORIZONTAL]) = (speed(10), cause);
        }
    })
}

fn folds_wet() -> Box<dyn Wrong> {
    drives(|view, outputs, _| {
        if view.wet[0] && view.device.has(SubsystemId::DEPLOYER) && view.deployed {
            outputs.drives[DEPLOYER] = speed(-100);
        }
    })
}

fn opens() -> Box<dyn Wrong> {
    drives(|view, outputs, _| {
        if view.now_ms > 5_000 && view.deployed {
            outputs.valves[0] = ValveOutput::Opening;
        }
    })
}

fn opens_locked() -> Box<dyn Wrong> {
    drives(|view, outputs, _| {
        if is_locked(view) {
            outputs.valves[0] = ValveOutput::Opening;
        }
    })
}

/// One that was closing already stops: that is another wrong.
fn stays_open() -> Box<dyn Wrong> {
    let mut last = (ValveOutput::Off, Cause::Rule(Rule::Inert));
    drives(move |view, outputs, causes| {
        let closes = is_locked(view) && outputs.valves[0] == ValveOutput::Closing;
        if closes && last.0 == ValveOutput::Off {
            (outputs.valves[0], causes.valves[0]) = last;
        }
        last = (outputs.valves[0], causes.valves[0]);
    })
}

fn floods() -> Box<dyn Wrong> {
    drives(|view, outputs, _| {
        if view.now_ms > 2_000 && !view.deployed {
            outputs.valves[0] = ValveOutput::Opening;
        }
    })
}

fn opens_on() -> Box<dyn Wrong> {
    let mut last = (ValveOutput::Off, Cause::Rule(Rule::Inert));
    drives(move |_, outputs, causes| {
        let stop = matches!(causes.valves[0], Cause::Request(a) if a.request == RequestId::STOP);
        if last.0 != ValveOutput::Off && outputs.valves[0] == ValveOutput::Off && stop {
            (outputs.valves[0], causes.valves[0]) = last;
        }
        last = (outputs.valves[0], causes.valves[0]);
    })
}

/// The device once let an opening wait behind the guard; this one does not let it end at all.
fn comes_back() -> Box<dyn Wrong> {
    let (mut asked, mut ended_ms) = (None, 0);
    drives(move |view, outputs, causes| {
        let cause = &mut causes.valves[0];
        match *cause {
            Cause::Request(open) if open.request == RequestId::OPEN => {
                (asked, ended_ms) = (Some(*cause), view.now_ms);
            }
            Cause::Rule(_) => {}
            _ => asked = None,
        }
        if let Some(opens) = asked
            && view.now_ms > ended_ms + 500
        {
            (outputs.valves[0], *cause) = (ValveOutput::Opening, opens);
        }
    })
}

fn hastens() -> Box<dyn Wrong> {
    drives(|view, outputs, causes| {
        if view.now_ms < u64::from(SETTLE_MS) {
            outputs.valves[0] = ValveOutput::Closing;
            causes.valves[0] = Cause::Rule(Rule::PowerUp);
        }
    })
}

fn haunts() -> Box<dyn Wrong> {
    struct Haunts;
    impl Wrong for Haunts {
        fn drives(&mut self, _: &View<'_>, still: bool, outputs: &mut Outputs, _: &mut Causes) {
            if still {
                outputs.drives[VERTICAL] = speed(10);
            }
        }
    }
    Box::new(Haunts)
}

fn heats() -> Box<dyn Wrong> {
    drives(|view, outputs, causes| {
        let warm = view.inputs.places[0]
            .temperature_dc
            .is_some_and(|value| i32::from(value) > view.params.get(Param::ClimaticsHeatOff));
        if view.now_ms > 1_000 && warm {
            (outputs.heaters[0], causes.heaters[0]) = (true, Cause::Rule(Rule::Cold));
        }
    })
}

fn freezes() -> Box<dyn Wrong> {
    drives(|view, outputs, causes| {
        if view.now_ms > 1_000 && outputs.heaters[0] {
            (outputs.heaters[0], causes.heaters[0]) = (false, Cause::Rule(Rule::Warm));
        }
    })
}
