//! Causes and violations in words, in both languages.

use lafet_device::Source;
use lafet_device::cause::{Asked, Cause, Program, Rule};
use lafet_device::image::Axis;
use lafet_sim::fault::axis_name;

use super::rules::Step;
use super::{Output, Violation};

/// A violation: what an output does is not explained.
pub(super) fn unexplained(at_ms: u64, step: &Step, why: &str) -> Violation {
    let Step { output, before, after, cause: claimed, .. } = *step;
    let (name, from, to) = (output.name(), output.words(before), output.words(after));
    let claimed = cause(claimed);
    let text = format!("{name} {from} → {to} is not explained by “{claimed}”: {why}");
    Violation { at_ms, unexplained: true, text }
}

/// A violation: an output changed though the program stood still.
pub(super) fn stood_still(at_ms: u64, output: Output) -> Violation {
    let text = format!("{} changed while the program stood still", output.name());
    Violation { at_ms, unexplained: true, text }
}

/// A violation: a drive counts as homed and cannot be.
pub(super) fn not_homed(at_ms: u64, axis: Axis) -> Violation {
    let name = axis_name(axis);
    let text = format!("{name} reports wrongly whether its position is known");
    Violation { at_ms, unexplained: false, text }
}

/// A cause in words: `quench, started by StartQuench Control (Radio)`.
pub fn cause(cause: Cause) -> String {
    match cause {
        Cause::Request(by) => format!("request {}", asked(by)),
        Cause::Program(program, by) => {
            format!("{}, started by {}", program_name(program), asked(by))
        }
        Cause::Button(post) => format!("button of {post}"),
        Cause::Rule(name) => format!("rule: {}", rule(name)),
    }
}

fn asked(asked: Asked) -> String {
    let source = match asked.source {
        Source::ExternalConn => "ExternalConn",
        Source::Radio => "Radio",
    };
    format!("{} {} ({source})", asked.request, asked.to)
}

/// The name of a program.
pub const fn program_name(program: Program) -> &'static str {
    match program {
        Program::Quench => "quench",
        Program::Trajectory => "trajectory",
        Program::Seek => "search",
        Program::Justify => "justification",
        Program::Deploy => "deployment",
        Program::Wrap => "wrapping",
    }
}

/// A short name of a rule, for tables and programs.
pub const fn rule_name(rule: Rule) -> &'static str {
    match rule {
        Rule::Inert => "inert",
        Rule::PowerUp => "power-up",
        Rule::Lockout => "lockout",
        Rule::NotDeployed => "not-deployed",
        Rule::Water => "water",
        Rule::Blocked => "blocked",
        Rule::Unconfirmed => "unconfirmed",
        Rule::Limit => "limit",
        Rule::EndSwitch => "end-switch",
        Rule::Overload => "overload",
        Rule::CutOff => "cut-off",
        Rule::Timeout => "timeout",
        Rule::Fault => "fault",
        Rule::ConnLost => "conn-lost",
        Rule::Arrived => "arrived",
        Rule::ProgramEnd => "program-end",
        Rule::Paused => "paused",
        Rule::Released => "released",
        Rule::Refused => "refused",
        Rule::Cold => "cold",
        Rule::Warm => "warm",
        Rule::NoTemperature => "no-temperature",
        Rule::HeaterFault => "heater-fault",
        Rule::Absent => "absent",
    }
}

/// What a rule says.
pub const fn rule(rule: Rule) -> &'static str {
    match rule {
        Rule::Inert => "inert until the sensors settle",
        Rule::PowerUp => "valves close after power-up",
        Rule::Lockout => "lockout",
        Rule::NotDeployed => "not deployed",
        Rule::Water => "water in the barrel",
        Rule::Blocked => "hardware block of the valve",
        Rule::Unconfirmed => "water not confirmed",
        Rule::Limit => "limit",
        Rule::EndSwitch => "end switch",
        Rule::Overload => "overload",
        Rule::CutOff => "current cut-off",
        Rule::Timeout => "time over",
        Rule::Fault => "fault",
        Rule::ConnLost => "remote unit lost",
        Rule::Arrived => "arrived",
        Rule::ProgramEnd => "end of the program",
        Rule::Paused => "program paused",
        Rule::Released => "button released",
        Rule::Refused => "button refused",
        Rule::Cold => "too cold",
        Rule::Warm => "warm enough",
        Rule::NoTemperature => "no temperature",
        Rule::HeaterFault => "heater fault",
        Rule::Absent => "not part of the monitor",
    }
}
