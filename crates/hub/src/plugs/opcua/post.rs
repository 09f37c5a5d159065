//! Sends events to the items that have asked for them, as many at a time as an item has room for. The library gives an
//! item that names no number room for one event, and would forget the earlier of two alarms of one moment.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use opcua::nodes::{BaseEventType, Event, TypeTree};
use opcua::server::node_manager::RequestContext;
use opcua::server::{CreateMonitoredItem, SubscriptionCache};
use opcua::types::{NodeId, StatusCode};

use super::events::ConditionEvent;

/// Most items that ask for events.
const ITEMS_MAX: usize = 256;
/// Events that wait for an item: of more the earliest are lost.
const WAITING_MAX: usize = 4000;
/// An item that is not found so often has gone.
const MISSED_MAX: u32 = 400;
/// Sessions that are remembered.
const SESSIONS_MAX: usize = 256;

/// An event.
#[derive(Clone, Debug)]
pub enum Letter {
    /// Something happened to a condition.
    Condition(Arc<ConditionEvent>),
    /// A mark between events.
    Mark(Arc<BaseEventType>),
}

impl Letter {
    fn event(&self) -> &dyn Event {
        match self {
            Self::Condition(it) => &**it,
            Self::Mark(it) => &**it,
        }
    }
}

/// An item of a subscription.
type Key = (u32, u32);

#[derive(Debug)]
struct Item {
    session: u32,
    /// What it looks at.
    node: NodeId,
    waiting: VecDeque<Letter>,
    missed: u32,
}

/// The items, and what waits for them.
#[derive(Debug, Default)]
pub struct Post {
    items: BTreeMap<Key, Item>,
    /// Sessions that were seen: a subscription may have been moved to one.
    sessions: BTreeSet<u32>,
}

/// Whether a filter asks for a field that there is not. The library would leave it out, so that those behind it move up, and
/// shows the results no other way.
fn is_wrong(item: &CreateMonitoredItem) -> bool {
    let shown = format!("{item:?}");
    let results = shown.split_once("select_clause_results: Some([");
    let results = results.and_then(|(_, rest)| rest.split_once("])"));
    results.is_some_and(|(results, _)| results.contains("Bad"))
}

impl Post {
    /// A session has asked for something.
    pub fn saw(&mut self, session: u32) {
        if self.sessions.insert(session) && self.sessions.len() > SESSIONS_MAX {
            self.sessions.pop_first();
        }
    }

    /// An item asks for events.
    pub fn came(&mut self, context: &RequestContext, item: &mut CreateMonitoredItem) {
        if !item.status_code().is_good() {
            return;
        }
        if is_wrong(item) {
            return item.set_status(StatusCode::BadEventFilterInvalid);
        }
        if self.items.len() >= ITEMS_MAX {
            return item.set_status(StatusCode::BadTooManyMonitoredItems);
        }
        self.saw(context.session_id);
        let handle = item.handle();
        let key = (handle.subscription_id, handle.monitored_item_id);
        let node = item.item_to_monitor().node_id.clone();
        let new = Item { session: context.session_id, node, waiting: VecDeque::new(), missed: 0 };
        self.items.insert(key, new);
    }

    /// The items of a subscription, and what they look at.
    pub fn of(&self, subscription: u32) -> Vec<(u32, NodeId)> {
        let all = self.items.range((subscription, 0)..=(subscription, u32::MAX));
        all.map(|((_, item), it)| (*item, it.node.clone())).collect()
    }

    /// An event has happened at a node: who looks at it, or at the server, is to see it.
    pub fn put(&mut self, letter: &Letter, source: &NodeId) {
        let sees = |it: &&mut Item| it.node.namespace == 0 || it.node == *source;
        for item in self.items.values_mut().filter(sees) {
            item.put(letter.clone());
        }
    }

    /// One item is to see these.
    pub fn put_to(&mut self, key: Key, letters: impl IntoIterator<Item = Letter>) {
        if let Some(item) = self.items.get_mut(&key) {
            letters.into_iter().for_each(|it| item.put(it));
        }
    }

    /// Sends what there is room for; forgets items that have gone.
    pub fn send(&mut self, subscriptions: &SubscriptionCache, types: &dyn TypeTree) {
        let sessions = &self.sessions;
        self.items.retain(|(subscription, id), item| {
            let found = item.send((*subscription, *id), subscriptions, types);
            let found = found || item.has_moved(*subscription, sessions, subscriptions);
            item.missed = if found { 0 } else { item.missed + 1 };
            item.missed < MISSED_MAX
        });
    }
}

impl Item {
    fn put(&mut self, letter: Letter) {
        if self.waiting.len() >= WAITING_MAX {
            self.waiting.pop_front();
        }
        self.waiting.push_back(letter);
    }

    /// `false`: the item is not there.
    fn send(
        &mut self,
        (subscription, id): Key,
        subscriptions: &SubscriptionCache,
        types: &dyn TypeTree,
    ) -> bool {
        let Some(own) = subscriptions.get_session_subscriptions(self.session) else { return false };
        let mut own = own.lock();
        let Some(own) = own.get_mut(subscription) else { return false };
        let Some(item) = own.get(&id) else { return false };
        // What is still in its queue would be lost.
        let room = if item.has_notifications() { 0 } else { item.queue_size().max(1) };
        for letter in self.waiting.drain(..room.min(self.waiting.len())) {
            own.notify_event(&id, letter.event(), types);
        }
        true
    }

    /// Looks for the subscription in other sessions.
    fn has_moved(
        &mut self,
        subscription: u32,
        sessions: &BTreeSet<u32>,
        subscriptions: &SubscriptionCache,
    ) -> bool {
        let has = |session: &&u32| {
            let own = subscriptions.get_session_subscriptions(**session);
            own.is_some_and(|it| it.lock().contains(subscription))
        };
        let found = sessions.iter().filter(|it| **it != self.session).find(has);
        if let Some(session) = found {
            self.session = *session;
        }
        found.is_some()
    }
}
