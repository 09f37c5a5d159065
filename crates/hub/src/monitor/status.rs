//! The model of a monitor as JSON, made from the dictionary of the protocol: fields, flags and
//! severities bear its names.

use std::collections::BTreeMap;
use std::sync::Arc;

use lafet_client::{AnswerBuf, Stats};
use lafet_proto::dictionary::{self, layouts};
use lafet_proto::flags;
use lafet_proto::{RequestId, SubsystemId};
use lafet_texts::{Text as _, hub as text};
use serde::Serialize;
use utoipa::ToSchema;

use super::described::States;
use crate::text::Both;
use crate::words::Severity;

/// The state of a monitor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct Status {
    /// When it was true; `None` before the first answer.
    #[schema(required)]
    pub at_ms: Option<u64>,
    /// It was not to be had since.
    pub stale: bool,
    /// It was not silent: others on its line were, and its turn has not come.
    #[serde(skip)]
    pub queued: bool,
    /// Its polls are not sent, so as not to disturb others on its line.
    #[serde(skip)]
    pub withheld: Option<Withheld>,
    /// Why the state is stale.
    #[schema(required)]
    pub error: Option<Both>,
    /// When a paused program goes on.
    #[schema(required)]
    pub resumes_ms: Option<u64>,
    /// The subsystems that the monitor consists of.
    #[schema(value_type = States)]
    pub subsystems: Subsystems,
}

/// Why nothing but Stop, Close and Lockout on is sent on a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Withheld {
    /// Bytes arrive that are no frames.
    Unreadable {
        /// The speed of the configuration, baud.
        baud: u32,
    },
    /// A bus controller transmits, and the hub is no console of its bus.
    Controller,
}

/// Subsystems by name. One that is as it was is shared with the state before.
pub type Subsystems = BTreeMap<&'static str, Arc<Subsystem>>;

/// The state of a subsystem.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Subsystem {
    /// The data of the answer that it was read from.
    #[serde(skip)]
    pub(crate) data: Vec<u8>,
    /// The status word (§3.3).
    pub bits: u32,
    /// Names of the flags that are set.
    pub flags: Vec<String>,
    /// That of the worst flag.
    pub severity: Severity,
    /// Fields whose values are not to be believed, and the flags that say so.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub bad: BTreeMap<&'static str, &'static str>,
    /// The other fields, by the dictionary's names.
    #[serde(flatten)]
    pub fields: BTreeMap<&'static str, i64>,
}

/// Reads the answers to GetStatus; what is as it was before is not read again.
pub fn subsystems<'a>(
    answers: impl Iterator<Item = &'a AnswerBuf>,
    before: &Subsystems,
) -> Subsystems {
    let read = |answer: &AnswerBuf| {
        let name = answer.from().name()?;
        let same = before.get(name).filter(|it| it.data == answer.data());
        Some((name, same.cloned().or_else(|| subsystem(answer).map(Arc::new))?))
    };
    answers.filter(|answer| answer.status().is_success()).filter_map(read).collect()
}

fn subsystem(answer: &AnswerBuf) -> Option<Subsystem> {
    let layouts = layouts::of_answer(RequestId::GET_STATUS, answer.from());
    let layout = layouts.iter().find(|layout| layout.fits(answer.data()))?;
    let mut state = Subsystem { data: answer.data().to_vec(), ..Subsystem::default() };
    for (_, field, value) in layout.values(answer.data()) {
        if field.kind == layouts::Kind::Flags {
            state.set_bits(answer.from(), u32::try_from(value).unwrap_or(0));
        } else {
            state.fields.insert(field.name, value);
        }
    }
    Some(state)
}

impl Subsystem {
    /// Takes a status word, with what it says of the fields.
    pub fn set_bits(&mut self, id: SubsystemId, bits: u32) {
        let class = flags::flags_of(id);
        self.bits = bits;
        self.flags = class.set(bits).map(|flag| flag.to_string()).collect();
        self.severity = class.severity(bits).into();
        self.bad = dictionary::invalid(id, bits).map(|(field, flag)| (field, flag.name)).collect();
    }
}

impl Status {
    /// Where a drive is; `None` of one whose limits are off or that is not homed, too (§D/7).
    pub fn position(&self, drive: SubsystemId) -> Option<i64> {
        let limitless = self.is_set(drive, "Limitless");
        self.valid(drive, "position").filter(|_| !limitless)
    }

    /// Whether water flows or may flow: a valve is not closed for certain, or there is flow.
    pub fn flows(&self) -> bool {
        let flow = self.valid(SubsystemId::GENERAL, "flowrate");
        let shut = |valve: &SubsystemId| {
            let is_set = |flag| self.is_set(*valve, flag);
            is_set("Closed") && !is_set("Opening") && !is_set("CloseSensorFault")
        };
        match &self.valves()[..] {
            [] => flow != Some(0),
            valves => !valves.iter().all(shut) || flow.is_some_and(|flow| flow > 0),
        }
    }

    /// Whether a drive moves.
    pub fn moves(&self) -> bool {
        let mut names = self.subsystems.keys().filter_map(|name| SubsystemId::from_name(name));
        names.any(|id| id.is_drive() && self.is_set(id, "Move"))
    }

    /// Whether the monitor can do its work: it is heard, not locked out, and no flag is an alarm but that of
    /// a fire that was found.
    pub fn is_ready(&self, link_up: bool) -> bool {
        let fine = |(name, state): (&&'static str, &Arc<Subsystem>)| {
            let flags = SubsystemId::from_name(name).map(|id| flags::set_flags(id, state.bits));
            flags
                .into_iter()
                .flatten()
                .all(|flag| flag.severity() < flags::Severity::Alarm || flag.info.name == "Found")
        };
        link_up
            && !self.stale
            && self.at_ms.is_some()
            && !self.is_set(SubsystemId::GENERAL, "LockedOut")
            && self.subsystems.iter().all(fine)
    }

    /// The status word of a subsystem, if the monitor has it.
    pub fn bits(&self, id: SubsystemId) -> Option<u32> {
        self.subsystems.get(id.name()?).map(|state| state.bits)
    }

    /// Whether a flag of a subsystem is set.
    pub fn is_set(&self, id: SubsystemId, flag: &str) -> bool {
        let info = flags::flags_of(id).by_name(flag);
        let value = self.bits(id).zip(info).map(|(bits, info)| info.value(bits));
        value.is_some_and(|value| value != 0)
    }

    /// The value of a field, if it is the present one and no flag says that it is bad.
    pub fn valid(&self, id: SubsystemId, field: &str) -> Option<i64> {
        let state = self.subsystems.get(id.name()?).filter(|_| !self.stale)?;
        if state.bad.contains_key(field) {
            return None;
        }
        state.fields.get(field).copied()
    }

    /// Whether its flags are those of another one, and it is known as well or as little: then
    /// alarms and readiness are the same.
    pub fn has_flags_of(&self, other: &Self) -> bool {
        let flags = |(name, state): (&&'static str, &Arc<Subsystem>)| (*name, state.bits);
        (self.stale, self.queued, self.withheld) == (other.stale, other.queued, other.withheld)
            && self.at_ms.is_some() == other.at_ms.is_some()
            && self.subsystems.iter().map(flags).eq(other.subsystems.iter().map(flags))
    }

    /// The valves that the monitor has.
    pub fn valves(&self) -> Vec<SubsystemId> {
        let valves = [SubsystemId::VALVE1, SubsystemId::VALVE2];
        valves.into_iter().filter(|valve| self.bits(*valve).is_some()).collect()
    }

    /// The valves that end its water: those that the monitor has; both, while that is not known.
    pub fn valves_to_close(&self) -> Vec<SubsystemId> {
        let valves = self.valves();
        if valves.is_empty() { vec![SubsystemId::VALVE1, SubsystemId::VALVE2] } else { valves }
    }
}

/// Whether a monitor can do its work, and why not.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct Readiness {
    /// Whether the monitor can work.
    pub ready: bool,
    /// What prevents it, or should be known.
    pub reasons: Vec<ReadinessReason>,
}

/// Something that prevents work.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct ReadinessReason {
    /// `link`, `stale`, `flag`, `wrapped` or `move_hold`.
    pub code: &'static str,
    /// The subsystem, if it is one's flag.
    #[schema(required)]
    pub subsystem: Option<String>,
    /// Name of the flag; null if no flag is the cause.
    #[schema(required)]
    pub flag: Option<String>,
    /// Severity of the flag.
    pub severity: Severity,
    /// The cause, in words.
    pub what: Both,
    /// What to do.
    pub remedy: Both,
}

/// Whether a monitor is ready.
/// `unheld`: the monitor has no MoveHold.
pub fn readiness(status: &Status, link_up: bool, unheld: bool) -> Readiness {
    let mut reasons = Vec::new();
    let mut say = |code, severity, what, remedy| {
        reasons.push(ReadinessReason { code, subsystem: None, flag: None, severity, what, remedy });
    };
    let cable = text::CheckLinkRemedy.words();
    if !link_up {
        let what = text::LinkDown.words();
        say("link", Severity::Alarm, what, cable);
    } else if status.stale || status.at_ms.is_none() {
        let what = text::MonitorSilent.words();
        say("stale", Severity::Alarm, what, cable);
    }
    if status.is_set(SubsystemId::DEPLOYER, "Wrapped") {
        say(
            "wrapped",
            Severity::Info,
            text::BarrelStowed.words(),
            text::BarrelStowedRemedy.words(),
        );
    }
    if unheld {
        let Unheld { what, remedy } = Unheld::text();
        say("move_hold", Severity::Warning, what, remedy);
    }
    for (name, state) in &status.subsystems {
        let Some(id) = SubsystemId::from_name(name) else { continue };
        // A fire that was found is an alarm, and what the monitor is ready for.
        let bad = flags::set_flags(id, state.bits)
            .filter(|it| it.severity() >= flags::Severity::Warning && it.info.name != "Found");
        reasons.extend(bad.map(|flag| ReadinessReason {
            code: "flag",
            subsystem: Some((*name).to_owned()),
            flag: Some(flag.info.name.to_owned()),
            severity: flag.severity().into(),
            what: flag.info.meaning.words(),
            remedy: flag.info.remedy.words(),
        }));
    }
    Readiness { ready: status.is_ready(link_up), reasons }
}

/// What is said of a monitor without MoveHold.
#[derive(Debug)]
pub struct Unheld {
    /// The meaning, in words.
    pub what: Both,
    /// What to do.
    pub remedy: Both,
}

impl Unheld {
    /// The time is that of a drive that brakes from 20 °/s as ours does.
    pub fn text() -> Self {
        Self { what: text::NoMoveHold.words(), remedy: text::NoMoveHoldRemedy.words() }
    }
}

/// What was exchanged: with a monitor, and on the line that it may share with others.
#[derive(Clone, Copy, Debug, Default)]
pub struct Exchanged {
    /// Exchanged with the monitor.
    pub own: Stats,
    /// Exchanged on its line, with all monitors.
    pub line: Stats,
}

impl Exchanged {
    /// What has come since `before`.
    #[must_use]
    pub const fn since(&self, before: &Self) -> Self {
        Self { own: self.own.since(&before.own), line: self.line.since(&before.line) }
    }
}

/// Frames that came from the monitor.
pub const fn received(own: &Stats) -> u64 {
    own.believed + strays(own)
}

/// Of these, what was no answer to what was outstanding.
pub const fn strays(own: &Stats) -> u64 {
    own.late + own.duplicates + own.unmatched
}

#[cfg(test)]
mod tests {
    use lafet_proto::Status as Code;
    use lafet_proto::record::Record;

    use super::*;

    fn answer(from: SubsystemId, data: &[u8]) -> AnswerBuf {
        let request = RequestId::GET_STATUS;
        AnswerBuf::new(&Record { request, device: from, status: Code::OK, data })
    }

    #[test]
    fn what_is_as_it_was_is_not_read_again() {
        let state = |position: u8| {
            [
                answer(SubsystemId::VERTICAL, &[0, 0, 0, 0, position, 0, 0, 0]),
                answer(SubsystemId::HORIZONTAL, &[0; 8]),
            ]
        };
        let first = subsystems(state(7).iter(), &Subsystems::new());
        assert_eq!(first["Vertical"].fields["position"], 7);
        let second = subsystems(state(8).iter(), &first);
        assert_eq!(second["Vertical"].fields["position"], 8);
        assert!(Arc::ptr_eq(&first["Horizontal"], &second["Horizontal"]));
        assert!(!Arc::ptr_eq(&first["Vertical"], &second["Vertical"]));
    }

    #[test]
    fn a_monitor_without_move_hold_is_ready_and_says_what_that_means() {
        let status = Status { at_ms: Some(1), ..Status::default() };
        assert!(readiness(&status, true, false).reasons.is_empty());
        let told = readiness(&status, true, true);
        assert!(told.ready && told.reasons[0].code == "move_hold");
        assert!(told.reasons[0].what.ru.contains("0,5 с"));
    }
}
