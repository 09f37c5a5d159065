//! Causes and violations in words, in both languages.

use lafet_device::Source;
use lafet_device::cause::{Asked, Cause, Program, Rule};
use lafet_device::image::Axis;
use lafet_proto::dictionary::Text;

use super::Violation;
use super::rules::Step;
use crate::fault::axis_name;

/// A text in both languages, made while running.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bilingual {
    /// English.
    pub en: String,
    /// Russian.
    pub ru: String,
}

/// A violation: what an output does is not explained.
pub(super) fn unexplained(at_ms: u64, step: &Step, why: Bilingual) -> Violation {
    let Step { output, before, after, cause: claimed, .. } = *step;
    let (name, from, to) = (output.name(), output.words(before), output.words(after));
    let claimed = cause(claimed);
    let text = Bilingual {
        en: format!("{name} {from} → {to} is not explained by “{}”: {}", claimed.en, why.en),
        ru: format!("{name} {from} → {to} не объясняется причиной «{}»: {}", claimed.ru, why.ru),
    };
    Violation { at_ms, unexplained: true, text }
}

/// A violation: a drive counts as homed and cannot be.
pub(super) fn not_homed(at_ms: u64, axis: Axis) -> Violation {
    let name = axis_name(axis);
    let text = Bilingual {
        en: format!("{name} tells wrongly whether its position is known"),
        ru: format!("{name} неверно сообщает, известно ли положение"),
    };
    Violation { at_ms, unexplained: false, text }
}

/// A cause in words: `quench, started by StartQuench Control (Radio)`.
pub fn cause(cause: Cause) -> Bilingual {
    match cause {
        Cause::Request(by) => {
            let by = asked(by);
            Bilingual { en: format!("request {by}"), ru: format!("запрос {by}") }
        }
        Cause::Program(program, by) => {
            let (name, by) = (program_name(program), asked(by));
            Bilingual {
                en: format!("{}, started by {by}", name.en),
                ru: format!("{}, по запросу {by}", name.ru),
            }
        }
        Cause::Button(post) => Bilingual {
            en: format!("button of {post}"),
            ru: format!("кнопка поста {post}"),
        },
        Cause::Rule(name) => {
            let text = rule(name);
            Bilingual {
                en: format!("rule: {}", text.en), ru: format!("правило: {}", text.ru)
            }
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
pub const fn program_name(program: Program) -> Text {
    match program {
        Program::Quench => Text::new("quench", "тушение"),
        Program::Trajectory => Text::new("trajectory", "тушение по траектории"),
        Program::Seek => Text::new("search", "поиск"),
        Program::Justify => Text::new("justification", "юстировка"),
        Program::Deploy => Text::new("deployment", "развёртывание"),
        Program::Wrap => Text::new("wrapping", "свёртывание"),
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
pub const fn rule(rule: Rule) -> Text {
    match rule {
        Rule::Inert => Text::new("inert until the sensors settle", "выдержка после включения"),
        Rule::PowerUp => Text::new("valves close after power-up", "закрытие после включения"),
        Rule::Lockout => Text::new("lockout", "аварийная блокировка"),
        Rule::NotDeployed => Text::new("not deployed", "ствол не развёрнут"),
        Rule::Water => Text::new("water in the barrel", "вода в стволе"),
        Rule::Blocked => Text::new("hardware block of the valve", "аппаратная блокировка затвора"),
        Rule::Unconfirmed => Text::new("water not confirmed", "подача воды не подтверждена"),
        Rule::Limit => Text::new("limit", "предел"),
        Rule::EndSwitch => Text::new("end switch", "концевой датчик"),
        Rule::Overload => Text::new("overload", "перегрузка по току"),
        Rule::CutOff => Text::new("current cut-off", "токовая отсечка"),
        Rule::Timeout => Text::new("time over", "время истекло"),
        Rule::Fault => Text::new("fault", "неисправность"),
        Rule::ConnLost => Text::new("remote unit lost", "потеря связи с блоком"),
        Rule::Arrived => Text::new("arrived", "прибыл"),
        Rule::ProgramEnd => Text::new("end of the program", "конец программы"),
        Rule::Paused => Text::new("program paused", "пауза программы"),
        Rule::Released => Text::new("button released", "кнопка отпущена"),
        Rule::Refused => Text::new("button refused", "кнопка отклонена"),
        Rule::Cold => Text::new("too cold", "холодно"),
        Rule::Warm => Text::new("warm enough", "тепло"),
        Rule::NoTemperature => Text::new("no temperature", "нет температуры"),
        Rule::HeaterFault => Text::new("heater fault", "неисправность подогрева"),
        Rule::Absent => Text::new("not part of the monitor", "нет в составе ствола"),
    }
}
