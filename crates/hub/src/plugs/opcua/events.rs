//! Events: what happens to a condition, field by field. No I/O.

use opcua::nodes::{DefaultTypeTree, Event, TypeTree as _};
use opcua::server::EventField;
use opcua::types::{
    AttributeId, ByteString, DateTime, LocalizedText, NodeClass, NodeId, NumericRange,
    ObjectTypeId, QualifiedName, StatusCode, Variant,
};

use super::Language;
use crate::alarms::{Alarm, Priority, State};
use lafet_texts::{Text as _, hub as text};

/// The type of the conditions, and those of which it is one.
const TYPES: [ObjectTypeId; 4] = [
    ObjectTypeId::BaseEventType,
    ObjectTypeId::ConditionType,
    ObjectTypeId::AcknowledgeableConditionType,
    ObjectTypeId::AlarmConditionType,
];
/// The fields.
const FIELDS: [&str; 33] = [
    "EventId",
    "EventType",
    "SourceNode",
    "SourceName",
    "Time",
    "ReceiveTime",
    "Message",
    "Severity",
    "LastSeverity",
    "ConditionClassId",
    "ConditionClassName",
    "ConditionName",
    "BranchId",
    "Retain",
    "Quality",
    "ClientUserId",
    "Comment",
    "Comment/SourceTimestamp",
    "EnabledState",
    "EnabledState/Id",
    "ActiveState",
    "ActiveState/Id",
    "ActiveState/TransitionTime",
    "AckedState",
    "AckedState/Id",
    "InputNode",
    "SuppressedOrShelved",
    "ShelvingState/CurrentState",
    "ShelvingState/CurrentState/Id",
    "ShelvingState/UnshelveTime",
    "LocalTime",
    "ConfirmedState",
    "ConfirmedState/Id",
];

/// Clients may ask for the fields of a type by each type that has them, and for the condition itself: the library knows
/// them by the type that declares them alone.
pub fn complete(types: &mut DefaultTypeTree) {
    let path = |field: &str| -> Vec<QualifiedName> {
        field.split('/').filter(|it| !it.is_empty()).map(QualifiedName::from).collect()
    };
    for kind in TYPES.map(NodeId::from) {
        for field in FIELDS.into_iter().chain([""]) {
            let path = path(field);
            if types.find_type_prop_by_browse_path(&kind, &path).is_some() {
                continue;
            }
            let class = if path.is_empty() { NodeClass::Object } else { NodeClass::Variable };
            let id = NodeId::new(0, opcua::types::UAString::from(format!("{kind}/{field}")));
            types.add_type_property(&id, &kind, &path.iter().collect::<Vec<_>>(), class);
        }
    }
}

/// Ticks of 100 ns from 1601 to 1970.
const EPOCH_TICKS: i64 = 116_444_736_000_000_000;

/// A time, ms since 1970.
pub fn time(ms: u64) -> DateTime {
    let ticks = i64::try_from(ms).unwrap_or(i64::MAX).saturating_mul(10_000);
    DateTime::from(ticks.saturating_add(EPOCH_TICKS))
}

/// The same back; `None`: it is no time.
pub fn millis(time: &DateTime) -> Option<u64> {
    let ticks = time.ticks().checked_sub(EPOCH_TICKS)?;
    u64::try_from(ticks / 10_000).ok().filter(|_| !time.is_null())
}

/// How severe an alarm is, of 1000.
pub const fn severity(priority: Priority) -> u16 {
    match priority {
        Priority::Fire => 1000,
        Priority::High => 800,
        Priority::Medium => 500,
        Priority::Low => 200,
    }
}

/// What a user has written of an alarm.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Comment {
    /// The words.
    pub text: String,
    /// Who wrote them.
    pub user: String,
    /// When, ms since 1970.
    pub at_ms: u64,
}

/// What happened to a condition.
#[derive(Debug)]
pub struct ConditionEvent {
    /// Its number.
    pub id: ByteString,
    /// The condition.
    pub condition: NodeId,
    /// The node of its monitor, or of the site.
    pub source: NodeId,
    /// The name of its monitor, or `Lafet`.
    pub source_name: String,
    /// The alarm as it is now; of one that is normal, as it was last.
    pub alarm: Alarm,
    /// The alarm is normal now.
    pub is_normal: bool,
    /// The last comment.
    pub comment: Comment,
    /// The language of the texts.
    pub language: Language,
    /// When it happened, ms since 1970.
    pub at_ms: u64,
    /// For how long it is still on the shelf, ms.
    pub unshelve_ms: u64,
    kind: NodeId,
    at: DateTime,
}

impl ConditionEvent {
    /// Of an alarm.
    pub fn new(alarm: &Alarm, condition: NodeId, source: NodeId, language: Language) -> Self {
        let site = alarm.monitor.is_empty();
        Self {
            id: ByteString::null(),
            condition,
            source,
            source_name: if site { "Lafet".into() } else { alarm.monitor.clone() },
            alarm: alarm.clone(),
            is_normal: false,
            comment: Comment::default(),
            language,
            at_ms: 0,
            unshelve_ms: 0,
            kind: ObjectTypeId::AlarmConditionType.into(),
            at: DateTime::null(),
        }
    }

    /// It happened now, and has this number.
    #[must_use]
    pub fn now(mut self, at_ms: u64, id: ByteString) -> Self {
        self.at = time(at_ms);
        let until_ms = self.alarm.shelved.as_ref().map_or(0, |it| it.until_ms);
        self.unshelve_ms = until_ms.saturating_sub(at_ms);
        (self.at_ms, self.id) = (at_ms, id);
        self
    }

    fn text(&self, words: &crate::text::Both) -> Variant {
        LocalizedText::new(self.language.code(), self.language.of(words)).into()
    }

    /// What is active, and what waits, of an alarm that is not normal.
    fn is_active(&self) -> bool {
        self.alarm.active && !self.is_normal
    }

    fn is_acked(&self) -> bool {
        self.is_normal || matches!(self.alarm.state, State::Ack)
    }

    fn is_shelved(&self) -> bool {
        self.alarm.state == State::Shelved && !self.is_normal
    }

    fn value(&self, path: &str) -> Variant {
        let state = |is, yes: crate::text::Both, no| self.text(if is { &yes } else { &no });
        match path {
            "EventId" => self.id.clone().into(),
            "EventType" => self.kind.clone().into(),
            "SourceNode" => self.source.clone().into(),
            "SourceName" => self.source_name.as_str().into(),
            "Time" | "ReceiveTime" => self.at.into(),
            "Message" => {
                let (what, remedy) = (&self.alarm.what, &self.alarm.remedy);
                let text = format!("{} {}", self.language.of(what), self.language.of(remedy));
                LocalizedText::new(self.language.code(), text.trim_end()).into()
            }
            "Severity" | "LastSeverity" => severity(self.alarm.priority).into(),
            "ConditionClassId" => NodeId::from(ObjectTypeId::ProcessConditionClassType).into(),
            "ConditionClassName" => LocalizedText::new("en", "ProcessConditionClassType").into(),
            "ConditionName" => self.alarm.id.as_str().into(),
            "BranchId" => NodeId::null().into(),
            "Retain" => (!self.is_normal).into(),
            "Quality" => StatusCode::Good.into(),
            "ClientUserId" => self.user().into(),
            "Comment" => LocalizedText::new("", &self.comment.text).into(),
            "Comment/SourceTimestamp" => time(self.comment.at_ms).into(),
            "EnabledState" => self.text(&text::OpcuaEnabled.words()),
            "EnabledState/Id" => true.into(),
            "ActiveState" => {
                state(self.is_active(), text::OpcuaActive.words(), text::OpcuaInactive.words())
            }
            "ActiveState/Id" => self.is_active().into(),
            "ActiveState/TransitionTime" => {
                let ended = self.alarm.returned_ms.filter(|_| !self.is_active());
                time(ended.unwrap_or(self.alarm.since_ms)).into()
            }
            "AckedState" => {
                state(self.is_acked(), text::OpcuaAcked.words(), text::OpcuaUnacked.words())
            }
            "AckedState/Id" => self.is_acked().into(),
            "InputNode" => NodeId::null().into(),
            "SuppressedOrShelved" => self.is_shelved().into(),
            "ShelvingState/CurrentState" => {
                state(self.is_shelved(), text::OpcuaShelved.words(), text::OpcuaUnshelved.words())
            }
            "ShelvingState/CurrentState/Id" => {
                let shelved = opcua::types::ObjectId::ShelvedStateMachineType_TimedShelved;
                let free = opcua::types::ObjectId::ShelvedStateMachineType_Unshelved;
                NodeId::from(if self.is_shelved() { shelved } else { free }).into()
            }
            "ShelvingState/UnshelveTime" => (self.unshelve_ms as f64).into(),
            _ => Variant::Empty,
        }
    }

    fn user(&self) -> &str {
        let acked = self.alarm.ack.as_ref();
        match (acked, self.comment.at_ms) {
            (Some(ack), at_ms) if ack.at_ms >= at_ms => &ack.user,
            _ => &self.comment.user,
        }
    }
}

impl EventField for ConditionEvent {
    fn get_value(
        &self,
        attribute: AttributeId,
        range: &NumericRange,
        path: &[QualifiedName],
    ) -> Variant {
        match attribute {
            AttributeId::NodeId if path.is_empty() => self.condition.clone().into(),
            AttributeId::Value if path.iter().all(|it| it.namespace_index == 0) => {
                let names: Vec<&str> = path.iter().map(|it| it.name.as_ref()).collect();
                let value = self.value(&names.join("/"));
                if matches!(range, NumericRange::None) { value } else { Variant::Empty }
            }
            _ => Variant::Empty,
        }
    }
}

impl Event for ConditionEvent {
    fn get_field(
        &self,
        _: &NodeId,
        attribute: AttributeId,
        range: &NumericRange,
        path: &[QualifiedName],
    ) -> Variant {
        self.get_value(attribute, range, path)
    }

    fn time(&self) -> &DateTime {
        &self.at
    }

    fn event_type_id(&self) -> &NodeId {
        &self.kind
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alarms::Alarms;
    use crate::monitor::status::Status;

    fn event(is_normal: bool) -> ConditionEvent {
        let mut alarms = Alarms::default();
        let stale = Status { stale: true, at_ms: Some(1), ..Status::default() };
        alarms.observe(5, "M1", &stale, true);
        let alarm = alarms.list()[0];
        let node = |text: &str| NodeId::new(2, opcua::types::UAString::from(text));
        let event = ConditionEvent::new(alarm, node("$alarm:x"), node("M1"), Language::Ru);
        ConditionEvent { is_normal, ..event }.now(9, ByteString::from(vec![1, 2]))
    }

    fn field(event: &ConditionEvent, path: &str) -> Variant {
        let path: Vec<QualifiedName> = path.split('/').map(QualifiedName::from).collect();
        event.get_field(&NodeId::null(), AttributeId::Value, &NumericRange::None, &path)
    }

    #[test]
    fn an_alarm_has_the_fields_of_the_standard() {
        let event = event(false);
        for (path, value) in [
            ("ActiveState/Id", Variant::from(true)),
            ("AckedState/Id", false.into()),
            ("EnabledState/Id", true.into()),
            ("Retain", true.into()),
            ("SourceName", "M1".into()),
            ("SuppressedOrShelved", false.into()),
            ("Time", time(9).into()),
            ("EventId", ByteString::from(vec![1, 2]).into()),
        ] {
            assert_eq!(field(&event, path), value, "{path}");
        }
        let Variant::LocalizedText(message) = field(&event, "Message") else { panic!() };
        assert_eq!(message.locale.as_ref(), "ru");
        assert!(message.text.as_ref().chars().any(|c| ('а'..='я').contains(&c)), "{message:?}");
        let id = event.get_field(&NodeId::null(), AttributeId::NodeId, &NumericRange::None, &[]);
        assert_eq!(id, event.condition.clone().into());
        assert_eq!(field(&event, "Nothing"), Variant::Empty);
    }

    #[test]
    fn an_alarm_that_is_normal_is_not_retained() {
        let event = event(true);
        for path in ["Retain", "ActiveState/Id"] {
            assert_eq!(field(&event, path), false.into(), "{path}");
        }
        assert_eq!(field(&event, "AckedState/Id"), true.into());
    }

    #[test]
    fn times_pass_through_unchanged() {
        for ms in [0, 1, 1_700_000_000_123] {
            assert_eq!(millis(&time(ms)), Some(ms));
        }
        assert_eq!(millis(&DateTime::null()), None);
    }
}
