//! Causes and violations in words, in both languages.

use lafet_device::Source;
use lafet_device::cause::{Asked, Cause, Program, Rule};
use lafet_device::image::Axis;
use lafet_texts::{Text, Words, sim as text};

use super::rules::Step;
use super::{Output, Violation};
use crate::fault::axis_name;

/// A violation: what an output does is not explained.
pub(super) fn unexplained(at_ms: u64, step: &Step, why: Words) -> Violation {
    let Step { output, before, after, cause: claimed, .. } = *step;
    let (name, from, to) = (output.name(), output.words(before), output.words(after));
    let claimed = cause(claimed);
    let text = text::Unexplained { name, from, to, cause: claimed, why }.words();
    Violation { at_ms, unexplained: true, text }
}

/// A violation: an output changed though the program stood still.
pub(super) fn stood_still(at_ms: u64, output: Output) -> Violation {
    let text = text::ChangedWhileStopped { output: output.name() }.words();
    Violation { at_ms, unexplained: true, text }
}

/// A violation: a drive counts as homed and cannot be.
pub(super) fn not_homed(at_ms: u64, axis: Axis) -> Violation {
    let name = axis_name(axis);
    let text = text::HomedWrong { name }.words();
    Violation { at_ms, unexplained: false, text }
}

/// A cause in words: `quench, started by StartQuench Control (Radio)`.
pub fn cause(cause: Cause) -> Words {
    match cause {
        Cause::Request(by) => {
            let by = asked(by);
            text::CauseRequest { by }.words()
        }
        Cause::Program(program, by) => {
            let (name, by) = (program_name(program), asked(by));
            text::CauseProgram { program: name, by }.words()
        }
        Cause::Button(post) => text::CauseButton { post: format_args!("{post}") }.words(),
        Cause::Rule(name) => {
            let text = rule(name);
            text::CauseRule { rule: text }.words()
        }
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
pub const fn program_name(program: Program) -> &'static dyn Text {
    match program {
        Program::Quench => &text::ProgramQuench,
        Program::Trajectory => &text::ProgramTrajectory,
        Program::Seek => &text::ProgramSeek,
        Program::Justify => &text::ProgramJustify,
        Program::Deploy => &text::ProgramDeploy,
        Program::Wrap => &text::ProgramWrap,
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
pub const fn rule(rule: Rule) -> &'static dyn Text {
    match rule {
        Rule::Inert => &text::RuleInert,
        Rule::PowerUp => &text::RulePowerUp,
        Rule::Lockout => &text::RuleLockout,
        Rule::NotDeployed => &text::RuleNotDeployed,
        Rule::Water => &text::RuleWater,
        Rule::Blocked => &text::RuleBlocked,
        Rule::Unconfirmed => &text::RuleUnconfirmed,
        Rule::Limit => &text::RuleLimit,
        Rule::EndSwitch => &text::RuleEndSwitch,
        Rule::Overload => &text::RuleOverload,
        Rule::CutOff => &text::RuleCutOff,
        Rule::Timeout => &text::RuleTimeout,
        Rule::Fault => &text::RuleFault,
        Rule::ConnLost => &text::RuleConnLost,
        Rule::Arrived => &text::RuleArrived,
        Rule::ProgramEnd => &text::RuleProgramEnd,
        Rule::Paused => &text::RulePaused,
        Rule::Released => &text::RuleReleased,
        Rule::Refused => &text::RuleRefused,
        Rule::Cold => &text::RuleCold,
        Rule::Warm => &text::RuleWarm,
        Rule::NoTemperature => &text::RuleNoTemperature,
        Rule::HeaterFault => &text::RuleHeaterFault,
        Rule::Absent => &text::RuleAbsent,
    }
}
