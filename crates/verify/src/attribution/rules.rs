//! Whether a claimed cause explains what an output does.

use lafet_device::cause::{Asked, Cause, Program, Rule};
use lafet_device::guard::SETTLE_MS;
use lafet_device::image::{Axis, Place, ValveNo, ValveOutput};
use lafet_proto::flags::{ControlFlags, DriveFlags, GeneralFlags, ValveFlags};
use lafet_proto::param::{DriveParam, Param};
use lafet_proto::{RequestId, SubsystemId};
use lafet_sim::world::STEP_MS;

use super::closing::STABLE_MS;
use super::invariants::is_in_vain;
use super::ledger::{Ledger, Lock, Move, Start, Work, is_cut_off, is_running, valve_button};
use super::view::axis_of;
use super::{Output, View};

/// A drive that has passed its target by so much has arrived, arc-minutes or mm.
const PASSED: i32 = 2;
/// Deployment aims so far beyond its limits, where the switches are.
const SEAT: i32 = 60;
/// §D/5 The guard lets a drive pass a limit by so much.
const BEYOND: i32 = 2;
/// A drive and a valve stop when they have drawn too much for longer than this, ms.
const OVERLOAD_MS: u64 = 200;
const VALVE_OVERLOAD_MS: u64 = 300;
/// Bit of InputFaults: a switch of Deployer contradicts its position.
const DEPLOYER_DOUBTED: i32 = 1 << 16;
/// A driven valve has to leave its switch within this part of TravelTime, and this time at least.
const LEAVING_PART: u64 = 15;
const LEAVING_MIN_MS: u64 = 400;
/// Over this way the motion of a drive is judged at least, counts; over this time, ms; and from
/// this speed on, 0.1 °/s or 0.1 mm/s. What breaks shows at the end of a stretch, so a fault that
/// is gone again may still be found for as long.
const WATCH_COUNTS: f64 = 4.0;
const WATCH_MS: f64 = 400.0;
/// §D/6 From this flow on water flows, l/s.
const FLOWING_LPS: u16 = 2;
/// A drive that goes less than a quarter of its commanded way does not turn.
const SEEMS_STILL: f64 = 4.0;

/// An output in a step.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Which.
    pub output: Output,
    /// Its value before the step.
    pub before: i16,
    /// Its value now.
    pub after: i16,
    /// What the device gives as the cause.
    pub cause: Cause,
    /// What it gave before.
    pub cause_before: Cause,
}

/// Why a cause does not explain.
pub type Why = &'static str;

/// Whether what an output does is explained; otherwise why not.
pub fn explain(ledger: &Ledger, view: &View<'_>, step: &Step) -> Result<(), Why> {
    match step.output {
        Output::Drive(axis) => drive(ledger, view, step, axis),
        Output::Valve(valve) => work(ledger, view, step, valve),
        Output::Heater(place) => heater(ledger, view, step, place),
    }
}

fn no<T>(why: Why) -> Result<T, Why> {
    Err(why)
}

fn holds(condition: bool, why: Why) -> Result<(), Why> {
    if condition { Ok(()) } else { no(why) }
}

fn drive(ledger: &Ledger, view: &View<'_>, step: &Step, axis: Axis) -> Result<(), Why> {
    let Step { before, after, cause, .. } = *step;
    let turns = after != 0 && after.signum() != before.signum();
    let grows = turns || after.unsigned_abs() > before.unsigned_abs();
    if after == 0 && before == 0 {
        return Ok(());
    }
    let set = 10 * view.params.drive(axis, DriveParam::Speed).max(0);
    if grows && i32::from(after).abs() > set {
        return no("it goes faster than it is set to");
    }
    match cause {
        Cause::Request(asked) if after == 0 && stops(ledger, asked, axis) => Ok(()),
        Cause::Request(asked) => {
            let Some(granted) = ledger.moves[axis as usize].filter(|g| g.asked == asked) else {
                return no("no such Move is in force");
            };
            holds(
                !grows || leads_to(view, &granted, axis, after),
                "it moves away from the destination",
            )
        }
        Cause::Program(program, asked) => {
            holds(moves(program, axis), "this program has no business with this drive")?;
            if ledger.start_of(program, asked).is_none() {
                return no("no such program is in force");
            }
            // What ends or pauses a program stops its drives in the same step; but a button takes
            // its drive over a step before that shows.
            let runs = is_running(program, &view.told) || ledger.buttons.takes_over(axis);
            holds(runs || after == 0, "the program has ended")?;
            let waits = is_extinguishing(program)
                && view.told.control & ControlFlags::PAUSED.bits() != 0
                && !ledger.buttons.was_held(axis);
            holds(!waits || after == 0, "the program is paused")
        }
        Cause::Button(post) => {
            // One that is held for the other way brakes first.
            let held = ledger.buttons.holds(post, axis, after > 0)
                || !grows && ledger.buttons.holds(post, axis, after <= 0)
                // The other post holds it on, or another button turns it: it takes over a step
                // before that shows.
                || (ledger.is_asked_by_button(axis, after > 0) || ledger.buttons.takes_over(axis))
                    && ledger.buttons.held_before(post, axis, after > 0);
            holds(held, "no such button is held")
        }
        Cause::Rule(_) if grows => no("a rule may only take away"),
        Cause::Rule(_) if after != 0 => no("a rule stops, it does not slow down"),
        Cause::Rule(rule) => drive_rule(ledger, view, step, axis, rule),
    }
}

/// Whether an accepted request of this step ends the motion of a drive.
fn stops(ledger: &Ledger, asked: Asked, axis: Axis) -> bool {
    let aiming = axis != Axis::Deployer;
    let concerns = match asked.request {
        RequestId::STOP => match asked.to {
            SubsystemId::ALL | SubsystemId::MOTORS => true,
            SubsystemId::CONTROL => aiming,
            SubsystemId::DETECTOR | SubsystemId::DEPLOYER => axis != Axis::Nozzle,
            other => axis_of(other) == Some(axis),
        },
        RequestId::LOCKOUT | RequestId::RESTART | RequestId::CLEAN_FLASH | RequestId::WRAP => true,
        RequestId::START_QUENCH
        | RequestId::START_TRAJECTORY
        | RequestId::START_SEEK
        | RequestId::START_JUSTIFY => true,
        RequestId::DEPLOY => axis != Axis::Nozzle,
        RequestId::MOVE | RequestId::SET_PARAM => axis_of(asked.to) == Some(axis),
        RequestId::SWITCH_LIMITS => {
            matches!(asked.to, SubsystemId::ALL | SubsystemId::MOTORS)
                || axis_of(asked.to) == Some(axis)
        }
        _ => false,
    };
    concerns && ledger.recent.iter().any(|(known, _)| *known == asked)
}

const fn is_extinguishing(program: Program) -> bool {
    matches!(program, Program::Quench | Program::Trajectory)
}

/// Which drives a program moves.
const fn moves(program: Program, axis: Axis) -> bool {
    match program {
        Program::Quench | Program::Trajectory => !matches!(axis, Axis::Deployer),
        Program::Seek | Program::Justify => matches!(axis, Axis::Horizontal | Axis::Vertical),
        Program::Deploy => matches!(axis, Axis::Deployer),
        Program::Wrap => !matches!(axis, Axis::Nozzle),
    }
}

/// Position as the monitor counts it.
fn position(view: &View<'_>, axis: Axis) -> i32 {
    let zero = view.params.drive(axis, DriveParam::ZeroPoint);
    let homed =
        view.inputs.drives[axis as usize].position.saturating_add(view.offsets[axis as usize]);
    homed.saturating_sub(zero)
}

/// How far it is to where a Move leads: to its destination inside the limits that were in force when
/// it was accepted, or that were set together with it.
fn ways(view: &View<'_>, granted: &Move, axis: Axis) -> [i32; 2] {
    let min = view.params.drive(axis, DriveParam::MinLimit);
    let max = view.params.drive(axis, DriveParam::MaxLimit);
    let now =
        if granted.limitless { granted.destination } else { granted.destination.min(max).max(min) };
    [now, granted.target].map(|target| target.saturating_sub(position(view, axis)))
}

fn leads_to(view: &View<'_>, granted: &Move, axis: Axis, speed: i16) -> bool {
    match granted.runs {
        Some(up) => up == (speed > 0),
        None => ways(view, granted, axis)
            .into_iter()
            .any(|way| way.signum() == i32::from(speed.signum())),
    }
}

fn drive_rule(
    ledger: &Ledger,
    view: &View<'_>,
    step: &Step,
    axis: Axis,
    rule: Rule,
) -> Result<(), Why> {
    let input = &view.inputs.drives[axis as usize];
    let max_current = view.params.drive(axis, DriveParam::MaxCurrent);
    let upwards = step.before > 0;
    let condition = match rule {
        Rule::Inert => is_inert(ledger, view),
        Rule::Lockout => ledger.lock == Lock::On,
        Rule::NotDeployed => axis != Axis::Deployer && !is_working(ledger, view),
        Rule::Water => axis == Axis::Deployer && !upwards && is_wet(view),
        Rule::Limit => !ledger.has_no_limits(axis) && is_beyond(view, axis, upwards),
        // The switch there, or the one where it has to turn round to, or from where it has come.
        Rule::EndSwitch => {
            let at_end = |up: bool| if up { input.max_switch } else { input.min_switch };
            let rests = has_arrived(ledger, view, step, axis);
            at_end(upwards) || at_end(!upwards) && (rests || may_go(ledger, view, axis, !upwards))
        }
        Rule::Overload => ledger.over_ms[axis as usize] > OVERLOAD_MS,
        Rule::CutOff => is_cut_off(input.current_da.into(), max_current),
        Rule::Timeout => is_late(ledger, view, axis),
        Rule::Fault => {
            is_broken(ledger, view, axis, step.before) || waits_to_see(ledger, view, step)
        }
        Rule::ConnLost => ledger.units.is_lost(axis.unit() as usize),
        Rule::Arrived => has_arrived(ledger, view, step, axis),
        Rule::ProgramEnd => {
            let ended = |program| moves(program, axis) && !is_running(program, &view.told);
            // It may have been started and have ended within this very step.
            matches!(step.cause_before, Cause::Program(program, _) if ended(program))
                || ledger.starts.iter().any(|start| ended(start.program))
        }
        Rule::Paused => {
            ledger.starts.iter().any(|start| is_extinguishing(start.program))
                && view.told.control & ControlFlags::PAUSED.bits() != 0
                && ledger.has_just_aimed()
        }
        Rule::Released => {
            let was =
                matches!(step.cause_before, Cause::Button(_)) || ledger.buttons.was_held(axis);
            let asked = |up| ledger.is_asked_by_button(axis, up);
            was && !asked(true) && !asked(false)
                || matches!(step.cause_before, Cause::Button(_)) && !asked(upwards)
        }
        Rule::Refused => {
            let busy = [Program::Seek, Program::Justify];
            let was =
                matches!(step.cause_before, Cause::Button(_)) || ledger.buttons.was_held(axis);
            was && (!is_working(ledger, view)
                || busy.iter().any(|program| is_running(*program, &view.told))
                || ledger.starts.iter().any(|start| busy.contains(&start.program))
                || is_broken(ledger, view, axis, step.before))
        }
        Rule::PowerUp
        | Rule::Blocked
        | Rule::Unconfirmed
        | Rule::Cold
        | Rule::Warm
        | Rule::NoTemperature
        | Rule::HeaterFault => {
            return no("this rule is not for drives");
        }
        Rule::Absent => !view.device.has(axis.id()),
    };
    holds(condition, "the condition of the rule does not hold")
}

/// Until the sensors have settled; and before the erase after which there should have been a reset,
/// had it not failed (§3.19).
fn is_inert(ledger: &Ledger, view: &View<'_>) -> bool {
    let waits = view.told.general & GeneralFlags::RESTARTING.bits() != 0;
    view.now_ms < ledger.powered_ms + u64::from(SETTLE_MS) || ledger.restart_ms.is_some() && !waits
}

/// The sensors say deployed, and nothing folds.
fn is_working(ledger: &Ledger, view: &View<'_>) -> bool {
    let deployer = &view.inputs.drives[Axis::Deployer as usize];
    let folds = [Program::Deploy, Program::Wrap];
    let wanted = ledger.moves[Axis::Deployer as usize].is_some()
        || ledger.starts.iter().any(|start| folds.contains(&start.program));
    // §D/6 Its switches are not believed, and it says so.
    let doubted = view.device.input_faults() & DEPLOYER_DOUBTED != 0;
    !view.device.has(SubsystemId::DEPLOYER)
        || deployer.max_switch && !deployer.min_switch && !wanted && !doubted
}

fn is_wet(view: &View<'_>) -> bool {
    let wet = |valve: ValveNo| {
        view.device.has(valve.id()) && !view.inputs.valves[valve as usize].close_switch
    };
    ValveNo::ALL.into_iter().any(wet) || view.inputs.flow_lps >= FLOWING_LPS
}

/// Whether anything may want the drive to go up/left (true) or down/right: a Move, a button, or a
/// program, which alone knows where it goes.
fn may_go(ledger: &Ledger, view: &View<'_>, axis: Axis, up: bool) -> bool {
    let speed = if up { 1 } else { -1 };
    ledger.moves[axis as usize].is_some_and(|granted| leads_to(view, &granted, axis, speed))
        || ledger.is_asked_by_button(axis, up)
        || ledger.starts.iter().any(|start| moves(start.program, axis))
}

fn is_beyond(view: &View<'_>, axis: Axis, upwards: bool) -> bool {
    let at = position(view, axis);
    match upwards {
        true => at > view.params.drive(axis, DriveParam::MaxLimit).saturating_add(BEYOND),
        false => at < view.params.drive(axis, DriveParam::MinLimit).saturating_sub(BEYOND),
    }
}

/// A Move that was not repeated within MoveTimeout or MoveHold; a deployment within TravelTime. Wrap has that
/// time for the way to its rest, and again for folding: when the one ends and the other begins is the
/// monitor's own business, so it is not held against a wrapping that lasts between once and twice as
/// long which of the two was late.
fn is_late(ledger: &Ledger, view: &View<'_>, axis: Axis) -> bool {
    let age = |at_ms: u64| view.now_ms.saturating_sub(at_ms);
    let moved = ledger.moves[axis as usize].is_some_and(|granted| {
        let held = granted.hold.is_some_and(|(at_ms, ms)| age(at_ms) >= u64::from(ms));
        held || granted.timeout_ms > 0 && age(granted.at_ms) >= u64::from(granted.timeout_ms)
    });
    let folds = |start: &Start| {
        matches!(start.program, Program::Deploy | Program::Wrap)
            && moves(start.program, axis)
            && age(start.at_ms) >= u64::from(start.travel_ms)
    };
    moved || ledger.starts.iter().any(folds)
}

/// §D/6 A search or an alignment waits for a detector that is not ready, or has not been for long.
fn waits_to_see(ledger: &Ledger, view: &View<'_>, step: &Step) -> bool {
    let looks = matches!(step.cause_before, Cause::Program(Program::Seek | Program::Justify, _));
    looks && ledger.blind_ms.is_some_and(|at_ms| view.now_ms <= at_ms + STABLE_MS + STEP_MS)
}

/// The monitor reports a fault of the drive, and there is one, or was in the stretch over which its
/// motion was judged last, or its parameters are bad.
fn is_broken(ledger: &Ledger, view: &View<'_>, axis: Axis, speed: i16) -> bool {
    const FAULTS: DriveFlags = DriveFlags::POSITION_WAY_FAULT
        .union(DriveFlags::POS_ENCODER_FAULT)
        .union(DriveFlags::SPEED_ENCODER_FAULT)
        .union(DriveFlags::MOTOR_BROKEN)
        .union(DriveFlags::SPEED_WAY_FAULT)
        .union(DriveFlags::INTERNAL_FAULT)
        .union(DriveFlags::CONFIG_INVALID)
        .union(DriveFlags::CONN_LOST);
    let told = view.told.drives[axis as usize] & FAULTS.bits() != 0;
    let min = view.params.drive(axis, DriveParam::MinLimit);
    let bad = view.params.is_incomplete(axis.id())
        || min >= view.params.drive(axis, DriveParam::MaxLimit);
    let unit = if axis == Axis::Nozzle { 1.0 } else { 60.0 };
    // What is set four times as fast as the drive can go seems not to turn.
    let set = f64::from(view.params.drive(axis, DriveParam::Speed)) * unit;
    let seems = set > SEEMS_STILL * view.max_speeds[axis as usize];
    let counts_per_s = f64::from(speed.unsigned_abs().max(1)) / 10.0 * unit;
    let stretch_ms = (WATCH_COUNTS * 1000.0 / counts_per_s).max(WATCH_MS) as u64 + STEP_MS;
    let lately = |at_ms: u64| view.now_ms <= at_ms + stretch_ms;
    told && (ledger.broken_ms[axis as usize].is_some_and(lately) || bad || seems)
}

fn has_arrived(ledger: &Ledger, view: &View<'_>, step: &Step, axis: Axis) -> bool {
    let near = |way: i32| way.saturating_abs() <= PASSED;
    let limits = || {
        let min = view.params.drive(axis, DriveParam::MinLimit);
        let max = view.params.drive(axis, DriveParam::MaxLimit);
        ledger.past_limits[axis as usize].iter().flatten().copied().chain([min, max])
    };
    let at = position(view, axis);
    let by_move = ledger.moves[axis as usize]
        .is_some_and(|m| m.runs.is_none() && ways(view, &m, axis).into_iter().any(near));
    // A button drives to the limit that was in force when it was pressed.
    let by_button = (matches!(step.cause_before, Cause::Button(_))
        || ledger.buttons.was_held(axis))
        && limits().any(|limit| near(at - limit));
    // A program takes a drive over a step before it shows, and may find it where it is to go.
    let paused = view.told.control & ControlFlags::PAUSED.bits() != 0;
    let by_program = ledger.starts.iter().any(|start| {
        let was = step.cause_before == Cause::Program(start.program, start.asked);
        let takes_over = moves(start.program, axis) && !(is_extinguishing(start.program) && paused);
        (was || takes_over) && is_end_of(start.program, view, axis, limits())
    });
    by_move || by_button || by_program
}

/// Whether a drive may stop here, as far as it can be known where a program goes: the deployer to
/// its switches or a little beyond its limits, a barrel that is to be wrapped straight ahead. Where
/// extinguishing and searching go only the program knows; that it stops there takes nothing.
fn is_end_of(
    program: Program,
    view: &View<'_>,
    axis: Axis,
    mut limits: impl Iterator<Item = i32>,
) -> bool {
    let at = position(view, axis);
    let near = |way: i32| way.saturating_abs() <= PASSED;
    let input = &view.inputs.drives[axis as usize];
    match (program, axis) {
        (Program::Deploy, Axis::Deployer) => {
            input.max_switch || limits.any(|limit| near(at - limit - SEAT))
        }
        (Program::Wrap, Axis::Deployer) => {
            input.min_switch || limits.any(|limit| near(at - limit + SEAT))
        }
        (Program::Wrap, _) => near(at) || limits.any(|limit| near(at - limit)),
        _ => true,
    }
}

fn work(ledger: &Ledger, view: &View<'_>, step: &Step, valve: ValveNo) -> Result<(), Why> {
    let Step { before, after, cause, .. } = *step;
    let way = view.outputs.valves[valve as usize];
    if after == 0 && before == 0 {
        return Ok(());
    }
    let granted =
        ledger.works[valve as usize].iter().any(|work| work.output == way && work.cause == cause);
    match (cause, way) {
        (_, ValveOutput::Opening | ValveOutput::Closing) if granted => Ok(()),
        // What is owed goes on when a block is gone, a unit is back or the motor has rested; by power-up, after an overload too.
        (_, ValveOutput::Closing) if ledger.owes(valve, cause) => Ok(()),
        (Cause::Button(post), ValveOutput::Opening | ValveOutput::Closing) => {
            holds(ledger.buttons.pressed(post, valve_button(way)), "no such button was pressed")
        }
        // Released, what it closes goes on to its end: the safe direction.
        (Cause::Rule(Rule::Lockout), ValveOutput::Closing) => {
            let goes_on = before < 0 && step.cause_before == cause;
            let condition = ledger.lock == Lock::On || goes_on;
            holds(condition, "there is no lockout")
        }
        (Cause::Rule(Rule::Unconfirmed), ValveOutput::Closing) => {
            holds(ledger.is_unconfirmed(view, valve), "its water was confirmed, or needs not be")
        }
        (Cause::Rule(Rule::PowerUp), ValveOutput::Closing) => {
            no("it has closed, or a request has come since power-up")
        }
        (Cause::Rule(_), ValveOutput::Opening) => no("a rule never opens"),
        (Cause::Program(..), _) => no("no program drives valves"),
        (_, ValveOutput::Opening | ValveOutput::Closing) => no("no such request is in force"),
        (Cause::Request(asked), ValveOutput::Off) => {
            let concerns = matches!(asked.request, RequestId::STOP | RequestId::RESTART)
                && (asked.to == SubsystemId::ALL || asked.to == valve.id());
            holds(
                concerns && ledger.recent.iter().any(|(known, _)| *known == asked),
                "no such stop was accepted",
            )
        }
        (Cause::Button(_), ValveOutput::Off) => no("no button stops a valve"),
        (Cause::Rule(rule), ValveOutput::Off) => {
            let condition = valve_rule(ledger, view, step, valve, rule);
            holds(condition, "the condition of the rule does not hold")
        }
    }
}

fn valve_rule(ledger: &Ledger, view: &View<'_>, step: &Step, valve: ValveNo, rule: Rule) -> bool {
    let input = &view.inputs.valves[valve as usize];
    // What was asked for since the last step is judged in it too.
    let asked = |way: ValveOutput| {
        let works = &ledger.works[valve as usize];
        works.iter().any(|work| work.output == way)
    };
    let opened = step.before > 0 || asked(ValveOutput::Opening);
    let closed = step.before < 0 || asked(ValveOutput::Closing);
    match rule {
        Rule::Inert => is_inert(ledger, view),
        Rule::Lockout => opened && ledger.lock == Lock::On,
        Rule::NotDeployed => opened && !is_working(ledger, view),
        Rule::Blocked => opened && input.blocked,
        Rule::ConnLost => opened && ledger.units.is_lost(valve.unit() as usize),
        // Closed, or released from the lockout, it is left where it is, and what had ended its
        // own closing before shows again.
        Rule::Arrived | Rule::Overload | Rule::Timeout | Rule::Fault
            if step.cause_before == Cause::Rule(Rule::Lockout) =>
        {
            ledger.lock == Lock::Off || input.close_switch || is_in_vain(ledger, view, valve)
        }
        Rule::Arrived => opened && input.open_switch || closed && input.close_switch,
        Rule::Overload => ledger.valve_over_ms[valve as usize] > VALVE_OVERLOAD_MS,
        // Half as much again as TravelTime, for the cold.
        Rule::Timeout => {
            let over = |work: &Work| {
                let travel_ms = u64::from(work.travel_ms);
                view.now_ms.saturating_sub(work.at_ms) >= travel_ms + travel_ms / 2
            };
            ledger.works[valve as usize].iter().any(over)
                // Closed for one reason after another, it has its time once.
                || step.before < 0 && ledger.is_in_vain(valve)
        }
        Rule::Fault => opened && sticks(ledger, view, valve),
        Rule::Absent => !view.device.has(valve.id()),
        _ => false,
    }
}

/// The monitor reports that the valve does not leave its switch, and there is a fault, or was one in the
/// time it has for that.
fn sticks(ledger: &Ledger, view: &View<'_>, valve: ValveNo) -> bool {
    let travel_ms = u64::from(ledger.valve_travel_ms[valve as usize]);
    let leaving_ms = (travel_ms / LEAVING_PART).max(LEAVING_MIN_MS) + STEP_MS;
    let lately = |at_ms: u64| view.now_ms <= at_ms + leaving_ms;
    view.told.valves[valve as usize] & ValveFlags::INTERNAL_FAULT.bits() != 0
        && ledger.valve_broken_ms[valve as usize].is_some_and(lately)
}

fn heater(ledger: &Ledger, view: &View<'_>, step: &Step, place: Place) -> Result<(), Why> {
    let input = &view.inputs.places[place as usize];
    let on_below = view.params.get(Param::ClimaticsHeatOn);
    let off_above = view.params.get(Param::ClimaticsHeatOff).max(on_below);
    let temperature = input.temperature_dc.map(i32::from);
    let Step { before, after, cause, .. } = *step;
    let condition = match (cause, after) {
        // Between the thresholds it stays as it was, also while it is held back.
        (Cause::Rule(Rule::Cold), 1) => {
            let began = before == 0 && step.cause_before != Cause::Rule(Rule::Inert);
            let most = if began { on_below - 1 } else { off_above };
            // §D/6
            let faulty = ledger.heater_fault_ms[place as usize] > STABLE_MS;
            temperature.is_some_and(|value| value <= most) && !faulty
        }
        (_, 1) => return no("only cold switches heat on"),
        _ if before == 0 => true,
        (Cause::Rule(Rule::Warm), _) => temperature.is_some_and(|value| value > off_above),
        (Cause::Rule(Rule::NoTemperature), _) => temperature.is_none(),
        (Cause::Rule(Rule::HeaterFault), _) => input.heater_fault,
        (Cause::Rule(Rule::Inert), _) => is_inert(ledger, view),
        _ => return no("heaters follow rules alone"),
    };
    holds(condition, "the condition of the rule does not hold")
}
