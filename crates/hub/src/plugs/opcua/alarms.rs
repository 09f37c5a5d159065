//! The conditions: an alarm of the hub is one, as long as it is not normal. What is seen of it makes an event,
//! each with a number, by which it is acknowledged.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, OnceLock};

use opcua::nodes::{BaseEventType, DefaultTypeTree};
use opcua::server::node_manager::{MethodCall, RequestContext};
use opcua::server::{CreateMonitoredItem, SubscriptionCache};
use opcua::sync::RwLock;
use opcua::types::{ByteString, LocalizedText, NodeId, ObjectTypeId, StatusCode, Variant};

use super::ServerConfig;
use super::events::{Comment, ConditionEvent};
use super::methods::number;
use super::post::{Letter, Post};
use super::seats::{Seat, Seats};
use super::space::Space;
use crate::alarms::{Alarm, Priority, SHELVE_MAX_MIN, State, are_words};
use crate::hub::Hub;
use crate::sync::lock;

/// Events of a condition by which it can be acknowledged, the latest.
const EVENTS_MAX: usize = 8;
/// Time on the shelf until the next change of an alarm, as far as that is asked for, minutes.
const ONE_SHOT_MIN: u64 = SHELVE_MAX_MIN;
/// The reason of who gives none.
const REASON: &str = "OPC UA";

/// The types of the standard and of the hub.
pub type Types = RwLock<DefaultTypeTree>;
/// Where a refresh begins, and ends.
type Bound = Arc<BaseEventType>;

/// What a user does with a condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    /// It is acknowledged.
    Acknowledge,
    /// It gets a comment.
    Comment,
    /// All that are not normal are sent once more, to a subscription or to one item of it.
    Refresh(bool),
    /// It is shelved for a time.
    Shelve,
    /// It is shelved for as long as may be.
    ShelveOnce,
    /// Its shelving ends.
    Unshelve,
}

impl Deed {
    /// That of a method of the standard.
    pub fn of(method: &NodeId) -> Option<Self> {
        let number = match (method.namespace, &method.identifier) {
            (0, opcua::types::Identifier::Numeric(number)) => *number,
            _ => return None,
        };
        match number {
            9111 => Some(Self::Acknowledge),
            9029 => Some(Self::Comment),
            3875 => Some(Self::Refresh(false)),
            12912 => Some(Self::Refresh(true)),
            2949 => Some(Self::Shelve),
            2948 => Some(Self::ShelveOnce),
            2947 => Some(Self::Unshelve),
            _ => None,
        }
    }
}

/// What is seen of an alarm: another one is another event.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Mark(State, bool, u64, Priority, Option<u64>, Option<u64>, Comment);

impl Mark {
    fn of(alarm: &Alarm, comment: &Comment) -> Self {
        let (acked, shelved) = (alarm.ack.as_ref(), alarm.shelved.as_ref());
        let (acked, shelved) = (acked.map(|it| it.at_ms), shelved.map(|it| it.until_ms));
        let Alarm { state, active, since_ms, priority, .. } = *alarm;
        Self(state, active, since_ms, priority, acked, shelved, comment.clone())
    }
}

#[derive(Debug)]
struct Condition {
    alarm: Alarm,
    comment: Comment,
    /// `None`: it has to be sent.
    mark: Option<Mark>,
    /// The numbers of its events, the latest last.
    ids: VecDeque<ByteString>,
    at_ms: u64,
}

/// The conditions of a server.
#[derive(Clone)]
pub struct Conditions {
    hub: Hub,
    config: Arc<ServerConfig>,
    seats: Seats,
    space: Arc<OnceLock<Space>>,
    all: Arc<Mutex<All>>,
    post: Arc<Mutex<Post>>,
}

#[derive(Debug, Default)]
struct All {
    by_id: BTreeMap<String, Condition>,
    /// Events of another run have other numbers.
    run: u64,
    numbers: u64,
}

impl All {
    fn next_id(&mut self) -> ByteString {
        self.numbers += 1;
        let bytes = [self.run.to_be_bytes(), self.numbers.to_be_bytes()].concat();
        ByteString::from(bytes)
    }
}

impl Conditions {
    /// None yet.
    pub fn new(
        hub: &Hub,
        config: &Arc<ServerConfig>,
        seats: &Seats,
        space: &Arc<OnceLock<Space>>,
    ) -> Self {
        let run = getrandom::u64().unwrap_or_default();
        let all = All { run, ..All::default() };
        Self {
            hub: hub.clone(),
            config: config.clone(),
            seats: seats.clone(),
            space: space.clone(),
            all: Arc::new(Mutex::new(all)),
            post: Arc::default(),
        }
    }

    /// Whether who asks may see them.
    pub fn may_read(&self, context: &RequestContext) -> bool {
        self.seats.may_read(context)
    }

    /// Items of who asks look at events.
    pub fn came<'a>(
        &self,
        context: &RequestContext,
        items: impl Iterator<Item = &'a mut CreateMonitoredItem>,
    ) {
        let (reads, mut post) = (self.may_read(context), lock(&self.post));
        for item in items {
            if reads {
                post.came(context, item);
            } else {
                item.set_status(StatusCode::BadUserAccessDenied);
            }
        }
    }

    /// A session is there.
    pub fn saw(&self, context: &RequestContext) {
        lock(&self.post).saw(context.session_id);
    }

    /// Sends what has changed.
    pub fn look(&self, subscriptions: &SubscriptionCache, types: &Types) {
        let Some(space) = self.space.get() else { return };
        let events = self.changed(space);
        let mut post = lock(&self.post);
        for event in events {
            let source = event.source.clone();
            post.put(&Letter::Condition(Arc::new(event)), &source);
        }
        post.send(subscriptions, &*types.read());
    }

    fn event(&self, space: &Space, alarm: &Alarm) -> ConditionEvent {
        let at = self.config.monitors.iter().position(|it| *it == alarm.monitor);
        let (condition, source) = (space.condition(&alarm.id), space.source(at));
        ConditionEvent::new(alarm, condition, source, self.config.language)
    }

    /// The events of what has changed since this was asked last.
    fn changed(&self, space: &Space) -> Vec<ConditionEvent> {
        let now_ms = self.hub.clock().now_ms();
        let alarms: BTreeMap<String, Alarm> = {
            let alarms = self.hub.alarms();
            let own =
                |it: &&Alarm| it.monitor.is_empty() || self.config.monitors.contains(&it.monitor);
            alarms.list().into_iter().filter(own).map(|it| (it.id.clone(), it.clone())).collect()
        };
        let (mut all, mut events) = (lock(&self.all), Vec::new());
        let gone: Vec<String> =
            all.by_id.keys().filter(|id| !alarms.contains_key(*id)).cloned().collect();
        for id in gone {
            let Some(condition) = all.by_id.remove(&id) else { continue };
            let mut event = self.event(space, &condition.alarm);
            (event.is_normal, event.comment) = (true, condition.comment);
            events.push(event.now(now_ms, all.next_id()));
        }
        for (id, alarm) in alarms {
            let known = all.by_id.get(&id);
            let comment = known.map(|it| it.comment.clone()).unwrap_or_default();
            let mark = Mark::of(&alarm, &comment);
            if known.is_some_and(|it| it.mark.as_ref() == Some(&mark)) {
                continue;
            }
            let number = all.next_id();
            let mut event = self.event(space, &alarm);
            event.comment = comment.clone();
            events.push(event.now(now_ms, number.clone()));
            let ids = VecDeque::new();
            let new = Condition { alarm: alarm.clone(), comment, mark: None, ids, at_ms: now_ms };
            let condition = all.by_id.entry(id).or_insert(new);
            (condition.alarm, condition.mark, condition.at_ms) = (alarm, Some(mark), now_ms);
            condition.ids.push_back(number);
            if condition.ids.len() > EVENTS_MAX {
                condition.ids.pop_front();
            }
        }
        events
    }

    /// A method of a condition is called.
    pub async fn call(&self, context: &RequestContext, deed: Deed, call: &mut MethodCall) {
        let status = match self.checked(context, deed, call) {
            Ok(seat) => {
                let result = match deed {
                    Deed::Refresh(one) => self.refresh(context, one, call),
                    _ => self.done(seat, deed, call).await,
                };
                self.look(&context.subscriptions, &context.type_tree);
                result.err().unwrap_or(StatusCode::Good)
            }
            Err(status) => status,
        };
        call.set_outputs(Vec::new());
        call.set_status(status);
    }

    fn checked(
        &self,
        context: &RequestContext,
        deed: Deed,
        call: &MethodCall,
    ) -> Result<Arc<Seat>, StatusCode> {
        let seat = self.seats.of(context).ok_or(StatusCode::BadUserAccessDenied)?;
        let is_refresh = matches!(deed, Deed::Refresh(_));
        let allowed = if is_refresh { seat.rights.reads } else { seat.rights.operates };
        let wanted = match deed {
            Deed::Acknowledge | Deed::Comment | Deed::Refresh(true) => 2,
            Deed::Refresh(false) | Deed::Shelve => 1,
            Deed::ShelveOnce | Deed::Unshelve => 0,
        };
        match call.arguments().len() {
            _ if !allowed => Err(StatusCode::BadUserAccessDenied),
            given if given < wanted => Err(StatusCode::BadArgumentsMissing),
            given if given > wanted => Err(StatusCode::BadTooManyArguments),
            _ => Ok(seat),
        }
    }

    /// Does it, on the hub's own threads.
    async fn done(&self, seat: Arc<Seat>, deed: Deed, call: &MethodCall) -> Result<(), StatusCode> {
        let space = self.space.get().ok_or(StatusCode::BadInternalError)?;
        let id = space.alarm(call.object_id()).ok_or(StatusCode::BadNodeIdUnknown)?;
        let inputs = call.arguments().to_vec();
        let own = self.clone();
        let done = self.seats.main().spawn(async move { own.act(&seat, deed, &id, &inputs) });
        done.await.unwrap_or(Err(StatusCode::BadInternalError))
    }

    fn act(&self, seat: &Seat, deed: Deed, id: &str, inputs: &[Variant]) -> Result<(), StatusCode> {
        let (hub, caller) = (&self.hub, &seat.caller);
        let (state, monitor) = {
            let alarms = hub.alarms();
            let alarm = alarms.get(id).ok_or(StatusCode::BadNodeIdUnknown)?;
            (alarm.state, alarm.monitor.clone())
        };
        match deed {
            Deed::Acknowledge => {
                let comment = self.commented(id, inputs)?;
                let is_done = hub.acknowledge_alarms(caller, Some(vec![id.into()]), &comment) > 0;
                if !is_done {
                    return Err(StatusCode::BadConditionBranchAlreadyAcked);
                }
                self.note(id, comment, &caller.principal.user);
            }
            Deed::Comment => {
                let comment = self.commented(id, inputs)?;
                hub.comment_alarm(caller, (id, &monitor), &comment);
                self.note(id, comment, &caller.principal.user);
            }
            Deed::Shelve | Deed::ShelveOnce => {
                if state == State::Shelved {
                    return Err(StatusCode::BadConditionAlreadyShelved);
                }
                let minutes = match (deed, inputs.first()) {
                    (Deed::Shelve, Some(Variant::Double(ms))) => (ms / 60_000.0).ceil(),
                    (Deed::Shelve, _) => return Err(StatusCode::BadInvalidArgument),
                    _ => ONE_SHOT_MIN as f64,
                };
                if !(1.0..=SHELVE_MAX_MIN as f64).contains(&minutes) {
                    return Err(StatusCode::BadShelvingTimeOutOfRange);
                }
                hub.shelve_alarm(caller, id, minutes as u64, REASON);
            }
            Deed::Unshelve => {
                if state != State::Shelved {
                    return Err(StatusCode::BadConditionNotShelved);
                }
                hub.unshelve_alarm(caller, id);
            }
            Deed::Refresh(_) => {}
        }
        Ok(())
    }

    /// The comment of a call, if it is about an event of the condition that is not long ago.
    fn commented(&self, id: &str, inputs: &[Variant]) -> Result<String, StatusCode> {
        let [Variant::ByteString(event), comment] = inputs else {
            return Err(StatusCode::BadInvalidArgument);
        };
        let comment = match comment {
            Variant::LocalizedText(it) => it.text.as_ref().trim().to_owned(),
            Variant::Empty => String::new(),
            _ => return Err(StatusCode::BadInvalidArgument),
        };
        let all = lock(&self.all);
        let condition = all.by_id.get(id).ok_or(StatusCode::BadNodeIdUnknown)?;
        match condition.ids.contains(event) {
            false => Err(StatusCode::BadEventIdUnknown),
            true if !are_words(&comment) => Err(StatusCode::BadInvalidArgument),
            true => Ok(comment),
        }
    }

    fn note(&self, id: &str, text: String, user: &str) {
        let (user, at_ms) = (user.to_owned(), self.hub.clock().now_ms());
        if let Some(condition) = lock(&self.all).by_id.get_mut(id) {
            condition.comment = Comment { text, user, at_ms };
        }
    }

    /// Sends all conditions once more, between two events that say so.
    fn refresh(
        &self,
        context: &RequestContext,
        one: bool,
        call: &MethodCall,
    ) -> Result<(), StatusCode> {
        let space = self.space.get().ok_or(StatusCode::BadInternalError)?;
        let inputs = call.arguments();
        let argument = |at: usize| number(inputs.get(at)).and_then(|it| u32::try_from(it).ok());
        let subscription = argument(0).ok_or(StatusCode::BadSubscriptionIdInvalid)?;
        self.look(&context.subscriptions, &context.type_tree);
        let own = context.subscriptions.get_session_subscriptions(context.session_id);
        let own = own.ok_or(StatusCode::BadSubscriptionIdInvalid)?;
        if !own.lock().contains(subscription) {
            return Err(StatusCode::BadSubscriptionIdInvalid);
        }
        let mut post = lock(&self.post);
        let mut items = post.of(subscription);
        if one {
            let wanted = argument(1).ok_or(StatusCode::BadMonitoredItemIdInvalid)?;
            items.retain(|(id, _)| *id == wanted);
            if items.is_empty() {
                return Err(StatusCode::BadMonitoredItemIdInvalid);
            }
        }
        let (begins, kept, ends) = self.kept(space);
        for (item, node) in items {
            // What is seen at a monitor, and at the site or the server.
            let seen = kept.iter().filter(|it| node.namespace == 0 || it.source == node);
            let seen = seen.cloned().map(Letter::Condition);
            let marks = [&begins, &ends].map(|it| Letter::Mark(it.clone()));
            let [begins, ends] = marks;
            post.put_to((subscription, item), [begins].into_iter().chain(seen).chain([ends]));
        }
        Ok(())
    }

    fn kept(&self, space: &Space) -> (Bound, Vec<Arc<ConditionEvent>>, Bound) {
        let mut all = lock(&self.all);
        let mut mark = |kind: ObjectTypeId| {
            let event = BaseEventType::new_now(kind, all.next_id(), LocalizedText::null());
            Arc::new(event.set_source_node(opcua::types::ObjectId::Server.into()))
        };
        let begins = mark(ObjectTypeId::RefreshStartEventType);
        let ends = mark(ObjectTypeId::RefreshEndEventType);
        let kept = all.by_id.values().filter_map(|it| {
            let mut event = self.event(space, &it.alarm);
            event.comment = it.comment.clone();
            Some(Arc::new(event.now(it.at_ms, it.ids.back()?.clone())))
        });
        (begins, kept.collect(), ends)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_methods_of_the_standard_are_known() {
        use opcua::types::MethodId;
        for (method, deed) in [
            (MethodId::AcknowledgeableConditionType_Acknowledge, Deed::Acknowledge),
            (MethodId::ConditionType_AddComment, Deed::Comment),
            (MethodId::ConditionType_ConditionRefresh, Deed::Refresh(false)),
            (MethodId::ConditionType_ConditionRefresh2, Deed::Refresh(true)),
            (MethodId::ShelvedStateMachineType_TimedShelve, Deed::Shelve),
            (MethodId::ShelvedStateMachineType_OneShotShelve, Deed::ShelveOnce),
            (MethodId::ShelvedStateMachineType_Unshelve, Deed::Unshelve),
        ] {
            assert_eq!(Deed::of(&method.into()), Some(deed));
        }
        assert_eq!(Deed::of(&MethodId::Server_GetMonitoredItems.into()), None);
        assert_eq!(Deed::of(&NodeId::new(2, 9111_u32)), None, "another one's");
    }
}
