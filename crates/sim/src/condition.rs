//! Conditions on a running simulation: what scenarios expect, wait for, and forbid.
//!
//! ```text
//! [not] PATH OP VALUE            OP: = != < <= > >= has lacks; without: the last word is the value
//!
//! Vertical flags has Move        flags of a subsystem: has, lacks (several), = (exactly; `none`)
//! Vertical position >= 1190      fields of GetStatus: position current speed, voltage pressure
//!                                flow, horizontal vertical nozzle deployer housing humidity
//! Detector hotbeds = 1           number of hotbeds that GetHotbed returns
//! param Vertical MaxLimit = 4500 the first value; `param Control Program0 6 = 25`: one by index
//! output vertical > 0            commanded speed, 0.1 °/s; `output motion`: all four, unsigned
//! output valve1 opening          opening closing off
//! output heater box on           on off
//! input vertical position < 9    position speed current; min-switch max-switch (on off)
//! input valve1 open on           open closed blocked (on off); current
//! input pressure > 10000         µA; also flow voltage spots
//! world fire 0 out               burning out; `world fire 0 heat < 0.5`
//! world jet on                   on off; also range (m), flooded (yes no), resets, time (ms),
//!                                vertical … deployer (true position), valve1 valve2 (0 … 1)
//! ```

use lafet_device::image::{Axis, DriveInput, Place, ValveInput, ValveNo, ValveOutput};
use lafet_proto::answer::Reply;
use lafet_proto::flags::{FlagClass, flags_of, set_flags};
use lafet_proto::request::Body;
use lafet_proto::text::nearest;
use lafet_proto::{Answer, ParamId, SubsystemId};
use lafet_texts::{Argument, Lang, Text as _, Words, sim as text};

use crate::fault::{axis_name, place_name, valve_name};
use crate::sim::Sim;

/// A condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    text: String,
    path: Vec<String>,
    op: Op,
    value: String,
    negated: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Op {
    Equal,
    NotEqual,
    Less,
    AtMost,
    Greater,
    AtLeast,
    Has,
    Lacks,
}

/// What a path leads to.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Number(f64),
    /// One of these words.
    Word(&'static str, &'static [&'static str]),
    Flags(Vec<String>),
}

/// The name that may be meant, if one is near.
struct Meant(Option<&'static str>);

impl Argument for Meant {
    fn write(&self, lang: Lang, out: &mut dyn core::fmt::Write) -> core::fmt::Result {
        self.0.map_or(Ok(()), |name| text::OrMeant { name }.write(lang, out))
    }
}

/// A word that is none of those that the path can lead to: which they are, and which may be meant.
fn unknown_word(word: &str, known: &'static [&'static str]) -> Words {
    let meant = Meant(nearest(word, known.iter().copied()));
    text::WordNoneOf { word, known: known.join(", "), meant }.words()
}

/// A flag that the subsystem does not have, and which may be meant.
pub(crate) fn unknown_flag(name: &str, subsystem: &str, class: &'static FlagClass) -> Words {
    let meant = Meant(nearest(name, class.flags.iter().map(|flag| flag.name)));
    text::FlagUnknown { name, subsystem, meant }.words()
}

/// A flag of the subsystem, a button's with its state or without.
fn known_flag(name: &str, subsystem: &str, class: &'static FlagClass) -> Result<(), Words> {
    let (bare, state) = name.split_once('=').map_or((name, None), |(bare, it)| (bare, Some(it)));
    let flag = class.flags.iter().find(|flag| flag.name == bare);
    let flag = flag.ok_or_else(|| unknown_flag(bare, subsystem, class))?;
    let Some(state) = state else { return Ok(()) };
    if flag.button_state(0).is_none() {
        return Err(text::FlagHasNoStates { flag: bare, subsystem, state }.words());
    }
    // Released is the absence of the flag: nothing ever has it.
    match ["Pressed", "Short", "Open"].contains(&state) {
        true => Ok(()),
        false => Err(unknown_word(state, &["Pressed", "Short", "Open"])),
    }
}

impl core::fmt::Display for Value {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Word(word, _) => f.write_str(word),
            Self::Flags(flags) if flags.is_empty() => f.write_str("none"),
            Self::Flags(flags) => f.write_str(&flags.join(" ")),
        }
    }
}

impl core::fmt::Display for Condition {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.text)
    }
}

impl Condition {
    /// Reads a condition.
    ///
    /// # Errors
    ///
    /// What is not understood.
    pub fn parse(condition: &str) -> Result<Self, Words> {
        let mut words: Vec<&str> = condition.split_whitespace().collect();
        let negated = words.first() == Some(&"not");
        if negated {
            words.remove(0);
        }
        let found = words.iter().enumerate().find_map(|(at, word)| Some((at, op(word)?)));
        let (path, op, value) = match found {
            Some((at, op)) => (&words[..at], op, words[at + 1..].join(" ")),
            None => match words.split_last() {
                Some((last, path)) => (path, Op::Equal, (*last).to_owned()),
                None => return Err(text::ConditionMissing.words()),
            },
        };
        if path.is_empty() || value.is_empty() {
            return Err(text::ConditionForm { condition }.words());
        }
        let path: Vec<String> = path.iter().map(|word| (*word).to_owned()).collect();
        if let Some((class, names)) = flags_class(&path).zip(flag_names(op, &value)) {
            let alone = matches!(op, Op::Equal | Op::NotEqual) && value.trim() == "none";
            if !alone && value.split_whitespace().any(|name| name == "none") {
                return Err(text::NoneIsAlone.words());
            }
            for name in names {
                known_flag(name, &path[0], class)?;
            }
        }
        Ok(Self { text: condition.trim().to_owned(), path, op, value, negated })
    }

    /// Whether it holds, and what the path led to.
    ///
    /// # Errors
    ///
    /// The path leads nowhere, or to something else than the value.
    pub fn holds(&self, sim: &mut Sim) -> Result<(bool, String), Words> {
        let path: Vec<&str> = self.path.iter().map(String::as_str).collect();
        let nowhere = || text::PathLeadsNowhere { path: path.join(" ") }.words();
        let value = look_up(&path, sim).ok_or_else(nowhere)?;
        self.judge(&value)
    }

    /// The words before the operator.
    pub(crate) fn path(&self) -> &[String] {
        &self.path
    }

    /// As [`Condition::holds`], with a number that the path has led to elsewhere.
    pub(crate) fn judge_number(&self, number: f64) -> Result<(bool, String), Words> {
        self.judge(&Value::Number(number))
    }

    /// As [`Condition::holds`], with a word that the path has led to elsewhere.
    pub(crate) fn judge_word(
        &self,
        word: &'static str,
        known: &'static [&'static str],
    ) -> Result<(bool, String), Words> {
        self.judge(&Value::Word(word, known))
    }

    fn judge(&self, value: &Value) -> Result<(bool, String), Words> {
        let holds = self.compare(value)?;
        Ok((holds != self.negated, format!("{} = {value}", self.path.join(" "))))
    }

    fn compare(&self, value: &Value) -> Result<bool, Words> {
        let wanted = &self.value;
        match value {
            Value::Number(number) => {
                let finite = wanted.parse().ok().filter(|it: &f64| it.is_finite());
                let wanted = finite.ok_or_else(|| text::ConditionNumber { wanted }.words())?;
                Ok(match self.op {
                    Op::Equal | Op::Has => *number == wanted,
                    Op::NotEqual | Op::Lacks => *number != wanted,
                    Op::Less => *number < wanted,
                    Op::AtMost => *number <= wanted,
                    Op::Greater => *number > wanted,
                    Op::AtLeast => *number >= wanted,
                })
            }
            Value::Word(_, known) if !known.contains(&wanted.as_str()) => {
                Err(unknown_word(wanted, known))
            }
            Value::Word(word, _) => match self.op {
                Op::Equal => Ok(word == wanted),
                Op::NotEqual => Ok(word != wanted),
                _ => Err(text::ConditionWord { word }.words()),
            },
            Value::Flags(flags) => {
                // A button's flag has a state: its bare name means any but released.
                let has = |name: &str| {
                    flags.iter().any(|flag| flag == name || flag.split('=').next() == Some(name))
                };
                let mut names = wanted.split_whitespace();
                match self.op {
                    Op::Has => Ok(names.all(has)),
                    Op::Lacks => Ok(!names.any(has)),
                    Op::Equal | Op::NotEqual => {
                        let wanted: Vec<&str> = names.filter(|name| *name != "none").collect();
                        let same = wanted.len() == flags.len() && wanted.iter().all(|n| has(n));
                        Ok(same == (self.op == Op::Equal))
                    }
                    _ => Err(text::ConditionFlags.words()),
                }
            }
        }
    }
}

fn op(word: &str) -> Option<Op> {
    Some(match word {
        "=" => Op::Equal,
        "!=" => Op::NotEqual,
        "<" => Op::Less,
        "<=" => Op::AtMost,
        ">" => Op::Greater,
        ">=" => Op::AtLeast,
        "has" => Op::Has,
        "lacks" => Op::Lacks,
        _ => return None,
    })
}

fn flags_class(path: &[String]) -> Option<&'static FlagClass> {
    let [subsystem, what] = path else { return None };
    (what == "flags").then(|| SubsystemId::from_name(subsystem).map(flags_of)).flatten()
}

fn flag_names(op: Op, value: &str) -> Option<impl Iterator<Item = &str>> {
    let flags = matches!(op, Op::Has | Op::Lacks | Op::Equal | Op::NotEqual);
    flags.then(|| value.split_whitespace().filter(|name| *name != "none"))
}

fn look_up(path: &[&str], sim: &mut Sim) -> Option<Value> {
    match path {
        ["output", rest @ ..] => output(rest, sim),
        ["input", rest @ ..] => input(rest, sim),
        ["world", rest @ ..] => world(rest, sim),
        ["param", subsystem, name] => param(subsystem, name, "0", sim),
        ["param", subsystem, name, index] => param(subsystem, name, index, sim),
        ["Detector", "hotbeds"] => {
            let mut count = None;
            sim.ask(SubsystemId::DETECTOR, Body::GetHotbed, |answer| {
                count = answer.hotbeds().map(|hotbeds| hotbeds.count() as f64);
            });
            count.map(Value::Number)
        }
        [subsystem, field] => {
            let subsystem = SubsystemId::from_name(subsystem)?;
            let mut value = None;
            sim.ask(subsystem, Body::GetStatus, |answer| {
                value = field_of(subsystem, field, answer)
            });
            value
        }
        _ => None,
    }
}

fn param(subsystem: &str, name: &str, index: &str, sim: &mut Sim) -> Option<Value> {
    let index: usize = index.parse().ok()?;
    let mut value = None;
    let body = Body::GetParam { id: ParamId::of(name) };
    sim.ask(SubsystemId::from_name(subsystem)?, body, |answer| {
        if let Reply::Param { values, .. } = answer.data {
            value = values.iter().nth(index);
        }
    });
    value.map(|value| Value::Number(f64::from(value)))
}

fn field_of(subsystem: SubsystemId, field: &str, answer: &Answer<'_>) -> Option<Value> {
    let bits = answer.data.flags_bits()?;
    let number = match (answer.data, field) {
        (_, "flags") => {
            return Some(Value::Flags(set_flags(subsystem, bits).map(|f| f.to_string()).collect()));
        }
        (Reply::General(status), "voltage") => i32::from(status.main_voltage),
        (Reply::General(status), "pressure") => i32::from(status.pressure),
        (Reply::General(status), "flow") => i32::from(status.flowrate),
        (Reply::Thermo(status), "horizontal") => i32::from(status.horizontal),
        (Reply::Thermo(status), "vertical") => i32::from(status.vertical),
        (Reply::Thermo(status), "nozzle") => i32::from(status.nozzle),
        (Reply::Thermo(status), "deployer") => i32::from(status.deployer),
        (Reply::Thermo(status), "housing") => i32::from(status.housing),
        (Reply::Thermo(status), "humidity") => i32::from(status.humidity),
        (Reply::Drive(status), "position") => i32::from(status.position),
        (Reply::Drive(status), "current") => i32::from(status.current),
        (Reply::Drive(status), "speed") => i32::from(status.speed),
        (Reply::Deployer(status), "position") => i32::from(status.position),
        (Reply::Deployer(status), "current") => i32::from(status.current),
        (Reply::Deployer(status), "speed") => i32::from(status.speed),
        _ => return None,
    };
    Some(Value::Number(f64::from(number)))
}

fn output(path: &[&str], sim: &Sim) -> Option<Value> {
    let outputs = sim.world().outputs();
    match path {
        ["motion"] => {
            let sum: i32 = outputs.drives.iter().map(|d| i32::from(d.speed_tenths).abs()).sum();
            Some(Value::Number(f64::from(sum)))
        }
        ["heater", place] => {
            let place = Place::ALL.into_iter().find(|known| place_name(*known) == *place)?;
            Some(on(outputs.heaters[place as usize]))
        }
        [part] => match (axis(part), valve(part)) {
            (Some(axis), _) => {
                Some(Value::Number(f64::from(outputs.drives[axis as usize].speed_tenths)))
            }
            (_, Some(valve)) => {
                let word = match outputs.valves[valve as usize] {
                    ValveOutput::Off => "off",
                    ValveOutput::Opening => "opening",
                    ValveOutput::Closing => "closing",
                };
                Some(Value::Word(word, &["off", "opening", "closing"]))
            }
            _ => None,
        },
        _ => None,
    }
}

fn input(path: &[&str], sim: &Sim) -> Option<Value> {
    let inputs = sim.world().inputs();
    match path {
        ["pressure"] => Some(Value::Number(f64::from(inputs.pressure_ua))),
        ["flow"] => Some(Value::Number(f64::from(inputs.flow_lps))),
        ["voltage"] => Some(Value::Number(f64::from(inputs.main_voltage_dv))),
        ["spots"] => {
            let spots = inputs.detector.spots.iter().flatten().count();
            Some(Value::Number(spots as f64))
        }
        [part, field] => match (axis(part), valve(part)) {
            (Some(axis), _) => drive_field(&inputs.drives[axis as usize], field),
            (_, Some(valve)) => valve_field(&inputs.valves[valve as usize], field),
            _ => None,
        },
        _ => None,
    }
}

fn drive_field(drive: &DriveInput, field: &str) -> Option<Value> {
    Some(match field {
        "position" => Value::Number(f64::from(drive.position)),
        "speed" => Value::Number(f64::from(drive.speed_tenths)),
        "current" => Value::Number(f64::from(drive.current_da)),
        "min-switch" => on(drive.min_switch),
        "max-switch" => on(drive.max_switch),
        _ => return None,
    })
}

fn valve_field(valve: &ValveInput, field: &str) -> Option<Value> {
    Some(match field {
        "open" => on(valve.open_switch),
        "closed" => on(valve.close_switch),
        "blocked" => on(valve.blocked),
        "current" => Value::Number(f64::from(valve.current_da)),
        _ => return None,
    })
}

fn world(path: &[&str], sim: &Sim) -> Option<Value> {
    let world = sim.world();
    match path {
        ["fire", index, rest @ ..] => {
            let fire = world.fires.get(index.parse::<usize>().ok()?)?;
            match rest {
                [] => {
                    let word = if fire.burns() { "burning" } else { "out" };
                    Some(Value::Word(word, &["burning", "out"]))
                }
                ["heat"] => Some(Value::Number(fire.heat)),
                _ => None,
            }
        }
        ["jet"] => Some(on(world.landing().is_some())),
        ["range"] => Some(Value::Number(world.landing().map_or(0.0, |jet| jet.range_m()))),
        ["flooded"] => {
            Some(Value::Word(if world.flooded() { "yes" } else { "no" }, &["yes", "no"]))
        }
        ["resets"] => Some(Value::Number(f64::from(sim.resets()))),
        ["time"] => Some(Value::Number(world.now_ms() as f64)),
        [part] => match (axis(part), valve(part)) {
            (Some(axis), _) => Some(Value::Number(world.drives[axis as usize].position)),
            (_, Some(valve)) => Some(Value::Number(world.valves[valve as usize].opening)),
            _ => None,
        },
        _ => None,
    }
}

const fn on(state: bool) -> Value {
    Value::Word(if state { "on" } else { "off" }, &["on", "off"])
}

fn axis(name: &str) -> Option<Axis> {
    Axis::ALL.into_iter().find(|axis| axis_name(*axis) == name)
}

fn valve(name: &str) -> Option<ValveNo> {
    ValveNo::ALL.into_iter().find(|valve| valve_name(*valve) == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::Config;
    use lafet_proto::flags::Button;

    fn holds(text: &str, sim: &mut Sim) -> bool {
        Condition::parse(text).unwrap().holds(sim).unwrap().0
    }

    /// A monitor after power-up: wrapped, closed, still, cold pipe.
    #[test]
    fn after_power_up() {
        let fires = vec!["az=30,range=25,size=1.5".parse().unwrap()];
        let mut sim = Sim::new(Config { fires, ..Config::default() });
        sim.advance_ms(500);
        sim.world_mut().press(crate::fault::Post::Buttons, Button::Left, true);
        sim.advance_ms(20);
        for text in [
            "Buttons flags has LeftButtonState",
            "Buttons flags has LeftButtonState=Pressed",
            "Buttons flags lacks RightButtonState LeftButtonState=Short",
            "Deployer flags has Wrapped",
            "Deployer flags lacks Deployed Move",
            "Deployer position = 0",
            "General voltage = 24",
            "General pressure < 2",
            "param Vertical MaxLimit = 4500",
            "Detector hotbeds = 0",
            "output vertical = 0",
            "output motion = 0",
            "not output valve1 opening",
            "output heater box off",
            "input deployer min-switch on",
            "input valve1 closed on",
            "input spots = 0",
            "world fire 0 burning",
            "world fire 0 heat > 0.9",
            "world jet off",
            "world flooded no",
            "world resets = 0",
            "world nozzle = 60",
        ] {
            assert!(holds(text, &mut sim), "{text}");
        }
        assert!(!holds("Deployer flags = none", &mut sim));
    }

    #[test]
    fn nonsense_is_refused() {
        for text in [
            "",
            "not",
            "Vertical flags has Moved",
            "Vertical flags has none Move",
            "Vertical flags has Move=Pressed",
            "Buttons flags has LeftButtonState=Presed",
            "output vertical >",
        ] {
            is_in_russian(text, &Condition::parse(text).unwrap_err());
        }
        let mut sim = Sim::new(Config::default());
        for text in [
            "Vertical colour = 1",
            "world jet > 1",
            "world jet onn",
            "not output valve1 openning",
            "output vertical fast",
            "world fire 3 out",
            "Vertical flags > Move",
        ] {
            let error = Condition::parse(text).unwrap().holds(&mut sim).unwrap_err();
            is_in_russian(text, &error);
        }
        let near = Condition::parse("Vertical flags has Moved").unwrap_err();
        assert!(near.of(Lang::En).ends_with("; did you mean `Move`?"), "{near}");
    }

    /// What is wrong with a condition is said in both languages.
    fn is_in_russian(condition: &str, error: &Words) {
        let russian = error.of(Lang::Ru).chars().any(|it| ('а'..='я').contains(&it));
        assert!(russian && !error.of(Lang::En).is_empty(), "{condition}: {error:?}");
    }
}
