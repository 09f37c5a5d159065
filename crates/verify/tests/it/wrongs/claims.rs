//! Causes that are not true, and stops without a reason.

use lafet_device::Source;
use lafet_device::cause::{Asked, Cause, Program, Rule};
use lafet_device::image::{Axis, DriveOutput, ValveOutput};
use lafet_proto::SubsystemId;
use lafet_proto::param::DriveParam;
use lafet_verify::swarm::Wrong;

use super::Seeded;
use super::acts::drives;

pub const ALL: &[Seeded] = &[
    ("the cause names the other interface", other_interface, &["no such"]),
    ("the cause names another subsystem", other_addressee, &["no such Move is in force"]),
    ("the cause names another program", other_program, &["no business", "no such program"]),
    ("the cause names the other post", other_post, &["no such button is held"]),
    ("the cause of the valve names the other post", other_valve_post, &["was pressed", "no such"]),
    ("a motion is called a rule", called_a_rule, &["a rule may only take away"]),
    ("a request is called a program", called_a_program, &["no such program is in force"]),
    ("arrived where no request has sent it", || stops(Rule::Arrived), UNMET),
    ("stopped at a limit that is not there", || stops(Rule::Limit), UNMET),
    ("stopped by an end switch that is open", || stops(Rule::EndSwitch), UNMET),
    ("stopped by an overload that is none", || stops(Rule::Overload), UNMET),
    ("stopped in time", || stops(Rule::Timeout), UNMET),
    ("stopped by a fault that is none", || stops(Rule::Fault), UNMET),
    ("stopped by a pause that is none", || stops(Rule::Paused), UNMET),
    ("stopped by a lockout that is none", || stops(Rule::Lockout), UNMET),
    ("an overload is judged at once", || overloads(Axis::Vertical), UNMET),
    ("a valve is stopped in time", || stops_valve(Rule::Timeout), UNMET),
    ("a valve in its time is called faulty", || stops_valve(Rule::Fault), UNMET),
    ("a valve on its way has arrived", || stops_valve(Rule::Arrived), UNMET),
    ("a valve is stopped by a lost unit", || stops_valve(Rule::ConnLost), UNMET),
];

const UNMET: &[&str] = &["the condition of the rule does not hold"];

fn other_interface() -> Box<dyn Wrong> {
    let other = |asked: Asked| Asked {
        source: match asked.source {
            Source::Radio => Source::ExternalConn,
            Source::ExternalConn => Source::Radio,
        },
        ..asked
    };
    drives(move |_, _, causes| {
        for cause in causes.drives.iter_mut().chain(&mut causes.valves) {
            *cause = match *cause {
                Cause::Request(asked) => Cause::Request(other(asked)),
                Cause::Program(program, asked) => Cause::Program(program, other(asked)),
                own => own,
            };
        }
    })
}

fn other_addressee() -> Box<dyn Wrong> {
    drives(|_, outputs, causes| {
        let moves = outputs.drives[Axis::Horizontal as usize].speed_tenths != 0;
        if let (true, Cause::Request(asked)) =
            (moves, &mut causes.drives[Axis::Horizontal as usize])
        {
            asked.to = SubsystemId::VERTICAL;
        }
    })
}

fn other_program() -> Box<dyn Wrong> {
    drives(|_, _, causes| {
        for cause in &mut causes.drives {
            if let Cause::Program(program, _) = cause {
                *program = match *program {
                    Program::Quench | Program::Trajectory | Program::Justify => Program::Seek,
                    Program::Seek => Program::Quench,
                    Program::Deploy => Program::Wrap,
                    Program::Wrap => Program::Deploy,
                };
            }
        }
    })
}

const fn other(post: SubsystemId) -> SubsystemId {
    match post {
        SubsystemId::BUTTONS => SubsystemId::EXT_BUTTONS,
        _ => SubsystemId::BUTTONS,
    }
}

fn other_post() -> Box<dyn Wrong> {
    drives(|_, _, causes| {
        for cause in &mut causes.drives {
            if let Cause::Button(post) = cause {
                *post = other(*post);
            }
        }
    })
}

fn other_valve_post() -> Box<dyn Wrong> {
    drives(|_, _, causes| {
        for cause in &mut causes.valves {
            if let Cause::Button(post) = cause {
                *post = other(*post);
            }
        }
    })
}

fn called_a_rule() -> Box<dyn Wrong> {
    drives(|_, outputs, causes| {
        for (cause, output) in causes.drives.iter_mut().zip(&outputs.drives) {
            if output.speed_tenths != 0 {
                *cause = Cause::Rule(Rule::Arrived);
            }
        }
    })
}

fn called_a_program() -> Box<dyn Wrong> {
    drives(|_, outputs, causes| {
        let axis = Axis::Horizontal as usize;
        if let (true, Cause::Request(asked)) =
            (outputs.drives[axis].speed_tenths != 0, causes.drives[axis])
        {
            causes.drives[axis] = Cause::Program(Program::Quench, asked);
        }
    })
}

/// Stops Horizontal in the middle of its motion, once a second.
fn stops(rule: Rule) -> Box<dyn Wrong> {
    drives(move |view, outputs, causes| {
        let axis = Axis::Horizontal as usize;
        let moves = matches!(causes.drives[axis], Cause::Request(_))
            && outputs.drives[axis].speed_tenths.abs() > 100;
        if moves && view.now_ms.is_multiple_of(1_000) {
            (outputs.drives[axis], causes.drives[axis]) =
                (DriveOutput::default(), Cause::Rule(rule));
        }
    })
}

/// Starting current is no overload: it is called one.
fn overloads(axis: Axis) -> Box<dyn Wrong> {
    drives(move |view, outputs, causes| {
        let max = view.params.drive(axis, DriveParam::MaxCurrent);
        let over = i32::from(view.inputs.drives[axis as usize].current_da) > max;
        if over && outputs.drives[axis as usize].speed_tenths != 0 {
            outputs.drives[axis as usize] = DriveOutput::default();
            causes.drives[axis as usize] = Cause::Rule(Rule::Overload);
        }
    })
}

/// Stops a valve on its way.
fn stops_valve(rule: Rule) -> Box<dyn Wrong> {
    let mut steps = 0;
    drives(move |view, outputs, causes| {
        let input = &view.inputs.valves[0];
        let away = !input.open_switch && !input.close_switch;
        steps = if away && outputs.valves[0] == ValveOutput::Opening { steps + 1 } else { 0 };
        if steps > 100 {
            (outputs.valves[0], causes.valves[0]) = (ValveOutput::Off, Cause::Rule(rule));
        }
    })
}
