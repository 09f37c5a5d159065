//! What a scenario says has to have an effect: a word that would do nothing is an error.

use lafet_device::Source as Interface;
use lafet_device::image::{Axis, Unit, ValveNo};
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};
use lafet_texts::{Text as _, Words, sim as text};

use super::plan::{Action, ControllerPlan, Exercise, Trigger};
use super::reader::{Problem, Table, one_of};
use super::report::clock;
use crate::condition::Condition;
use crate::fault::{Fault, Post, SingleFault};
use crate::site::Site;

type Checked = Result<(), Problem>;

/// What to say of a key that does nothing without another one.
pub fn without(what: &str) -> Words {
    text::NoEffectWithout { what }.words()
}

/// What to say of a key that does nothing beside another one.
pub fn beside(what: &str) -> Words {
    text::NoEffectBeside { what }.words()
}

/// A time has to be before the end.
pub fn before_end(table: &Table<'_>, key: &str, at_ms: u64, end_ms: u64) -> Checked {
    match at_ms > end_ms {
        true => Err(table.wrong(key, text::AfterTheEnd { end: clock(end_ms) }.words())),
        false => Ok(()),
    }
}

/// A trigger has to be before the end.
pub fn trigger_in_time(table: &Table<'_>, trigger: &Trigger, end_ms: u64) -> Checked {
    let at_ms = trigger.at_ms.unwrap_or(0);
    before_end(table, "at", at_ms, end_ms)?;
    before_end(table, "delay", at_ms + trigger.delay_ms, end_ms)
}

/// Every supply has a monitor that draws from it.
pub fn supplies(exercise: &Exercise, root: &Table<'_>) -> Checked {
    for (index, table) in root.tables("supply")?.iter().enumerate() {
        if !exercise.site.monitors.iter().any(|it| it.supply == Some(index)) {
            return Err(table.wrong("name", text::SupplyUnused.words()));
        }
    }
    Ok(())
}

/// The answer that a line expects: `none`, a status, or a status and who gives it.
pub fn answer(table: &Table<'_>) -> Result<Option<String>, Problem> {
    let Some(answer) = table.text("answer")? else { return Ok(None) };
    let answer = answer.trim();
    if answer == "none" {
        let repeats = table.has("repeat");
        let wrong = || table.wrong("answer", text::NeverAnswered.words());
        return (!repeats).then(|| Some(answer.to_owned())).ok_or_else(wrong);
    }
    let (status, from) = match answer.strip_suffix(')').and_then(|it| it.split_once('(')) {
        Some((status, from)) => (status.trim_end(), Some(from.trim())),
        None => (answer, None),
    };
    if Status::from_name(status).is_none() {
        let names = Status::KNOWN.iter().map(|(_, name)| *name);
        let known: Vec<&str> = core::iter::once("none").chain(names).collect();
        return Err(table.wrong("answer", one_of(status, &known)));
    }
    let Some(from) = from else { return Ok(Some(status.to_owned())) };
    if SubsystemId::from_name(from).is_none() {
        let names: Vec<&str> = SubsystemId::CHAIN.iter().filter_map(|id| id.name()).collect();
        return Err(table.wrong("answer", one_of(from, &names)));
    }
    Ok(Some(format!("{status} ({from})")))
}

/// Whether a monitor of the site has a subsystem, as it says itself.
pub fn has(site: &mut Site, monitor: usize, subsystem: SubsystemId) -> bool {
    let mut exists = false;
    site.members[monitor].sim.ask(subsystem, Body::GetStatus, |answer| {
        exists = answer.status != Status::MODULE_NOT_EXIST;
    });
    exists
}

/// Requests go over an interface that the monitor has.
pub fn interface(
    table: &Table<'_>,
    key: &str,
    exercise: &Exercise,
    site: &mut Site,
    monitor: usize,
    over: Interface,
) -> Checked {
    let subsystem = match over {
        Interface::Radio => SubsystemId::RADIO,
        _ => SubsystemId::EXTERNAL_CONN,
    };
    needs(table, key, exercise, site, monitor, subsystem)
}

/// What a controller needs: a detector, its valve, its interface, and a barrel that it can wrap.
pub fn controller(
    table: &Table<'_>,
    exercise: &Exercise,
    site: &mut Site,
    plan: &ControllerPlan,
) -> Checked {
    trigger_in_time(table, &plan.trigger, exercise.duration_ms)?;
    interface(table, "over", exercise, site, plan.monitor, plan.over)?;
    let valve = SubsystemId::from_name(plan.valve).unwrap_or(SubsystemId::VALVE1);
    needs(table, "", exercise, site, plan.monitor, SubsystemId::DETECTOR)?;
    needs(table, "valve", exercise, site, plan.monitor, valve)?;
    match plan.wrap {
        true => needs(table, "wrap", exercise, site, plan.monitor, SubsystemId::DEPLOYER),
        false => Ok(()),
    }
}

fn needs(
    table: &Table<'_>,
    key: &str,
    exercise: &Exercise,
    site: &mut Site,
    monitor: usize,
    subsystem: SubsystemId,
) -> Checked {
    if has(site, monitor, subsystem) {
        return Ok(());
    }
    let monitor = &exercise.monitors[monitor].name;
    let subsystem = subsystem.to_string();
    Err(table.wrong(key, text::MonitorLacks { monitor, subsystem }.words()))
}

/// What happens to a monitor has to reach a part that it has.
pub fn reaches(table: &Table<'_>, exercise: &Exercise, site: &mut Site, action: Action) -> Checked {
    match action {
        Action::Inject(monitor, fault) => broken(table, "inject", exercise, site, monitor, fault),
        Action::Clear(monitor, Some(fault)) => {
            broken(table, "clear", exercise, site, monitor, fault)
        }
        Action::Link(monitor, over, _) => {
            let key = if over == Interface::Radio { "radio" } else { "external" };
            interface(table, key, exercise, site, monitor, over)
        }
        Action::Press(monitor, post, _, pressed) => {
            let key = if pressed { "press" } else { "release" };
            needs(table, key, exercise, site, monitor, of_post(post))
        }
        _ => Ok(()),
    }
}

fn broken(
    table: &Table<'_>,
    key: &str,
    exercise: &Exercise,
    site: &mut Site,
    monitor: usize,
    fault: Fault,
) -> Checked {
    let Some(subsystem) = part(fault) else { return Ok(()) };
    needs(table, key, exercise, site, monitor, subsystem)?;
    let Fault::Unit(unit, _) = fault else { return Ok(()) };
    let kind = match unit {
        Unit::Valve1 | Unit::Valve2 => "ValveType",
        _ => "DriveType",
    };
    let remote = Condition::parse(&format!("param {} {kind} = 1", of_unit(unit)));
    let sim = &mut site.members[monitor].sim;
    match remote.and_then(|remote| remote.holds(sim)) {
        Ok((false, _)) => {
            let monitor = &exercise.monitors[monitor].name;
            Err(table.wrong(key, text::NoUnitThere { monitor }.words()))
        }
        _ => Ok(()),
    }
}

/// The subsystem that a fault is one of; `None` for what every monitor has.
const fn part(fault: Fault) -> Option<SubsystemId> {
    Some(match fault {
        Fault::Drive(axis, _) => of_axis(axis),
        Fault::Valve(ValveNo::Valve1, _) => SubsystemId::VALVE1,
        Fault::Valve(ValveNo::Valve2, _) => SubsystemId::VALVE2,
        Fault::Temperature(_)
        | Fault::TemperatureFrozen(_)
        | Fault::TemperatureDrift(_)
        | Fault::Heater(_)
        | Fault::Single(SingleFault::Humidity) => SubsystemId::CLIMATICS,
        Fault::Unit(unit, _) => of_unit(unit),
        Fault::Button(post, ..) => of_post(post),
        Fault::Single(
            SingleFault::DetectorDead | SingleFault::DetectorSaturated | SingleFault::DirtyLens,
        ) => SubsystemId::DETECTOR,
        Fault::Single(_) => return None,
    })
}

const fn of_axis(axis: Axis) -> SubsystemId {
    match axis {
        Axis::Vertical => SubsystemId::VERTICAL,
        Axis::Horizontal => SubsystemId::HORIZONTAL,
        Axis::Nozzle => SubsystemId::NOZZLE,
        Axis::Deployer => SubsystemId::DEPLOYER,
    }
}

const fn of_unit(unit: Unit) -> SubsystemId {
    match unit {
        Unit::Vertical => SubsystemId::VERTICAL,
        Unit::Horizontal => SubsystemId::HORIZONTAL,
        Unit::Nozzle => SubsystemId::NOZZLE,
        Unit::Deployer => SubsystemId::DEPLOYER,
        Unit::Valve1 => SubsystemId::VALVE1,
        Unit::Valve2 => SubsystemId::VALVE2,
    }
}

const fn of_post(post: Post) -> SubsystemId {
    match post {
        Post::Buttons => SubsystemId::BUTTONS,
        Post::ExtButtons => SubsystemId::EXT_BUTTONS,
    }
}

/// What can be seen in all steps together alone: what undoes nothing, and what waits for itself.
pub fn of_steps(exercise: &Exercise, root: &Table<'_>) -> Checked {
    for (table, event) in root.tables("event")?.iter().zip(&exercise.events) {
        for action in &event.actions {
            undoes(table, exercise, *action)?;
        }
    }
    let events = exercise.events.iter().map(|it| (it.mark, it.trigger.after));
    let lines = exercise.operator.iter().map(|it| (it.mark, it.trigger.after));
    let controllers = exercise.controllers.iter().map(|it| (it.mark, it.trigger.after));
    let waits: Vec<_> = events.chain(lines).chain(controllers).collect();
    let lists = [root.tables("event")?, root.tables("operator")?, root.tables("controller")?];
    for (table, (mark, after)) in lists.iter().flatten().zip(&waits) {
        // Each mark is of one step, so a way of more steps than there are goes in a circle.
        let next = |at: usize| waits.iter().find(|it| it.0 == Some(at)).and_then(|it| it.1);
        let way = core::iter::successors(*after, |at| next(*at)).take(waits.len());
        if mark.is_some() && way.into_iter().any(|at| Some(at) == *mark) {
            return Err(table.wrong("after", text::WaitsForItself.words()));
        }
    }
    Ok(())
}

fn undoes(table: &Table<'_>, exercise: &Exercise, action: Action) -> Checked {
    let some = |does: &dyn Fn(&Action) -> bool| {
        exercise.events.iter().flat_map(|event| &event.actions).any(does)
    };
    let (key, monitor, done) = match action {
        Action::Clear(who, fault) => {
            let breaks = |it: &Action| match it {
                Action::Inject(whom, what) => {
                    *whom == who && fault.is_none_or(|fault| fault == *what)
                }
                _ => false,
            };
            ("clear", who, some(&breaks))
        }
        Action::Press(who, post, button, false) => {
            let pressed = Action::Press(who, post, button, true);
            ("release", who, some(&|it| *it == pressed))
        }
        _ => return Ok(()),
    };
    if done {
        return Ok(());
    }
    let monitor = &exercise.monitors[monitor].name;
    Err(table.wrong(key, text::NothingToUndo { monitor }.words()))
}
