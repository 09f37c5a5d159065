//! The nodes of the hub: what is read of them, which methods are called, and who may.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use async_trait::async_trait;
use futures_util::future::join_all;
use opcua::core::sync::RwLock;
use opcua::server::address_space::AddressSpace;
use opcua::server::diagnostics::NamespaceMetadata;
use opcua::server::node_manager::memory::InMemoryNodeManagerImpl;
use opcua::server::node_manager::{
    HistoryNode, MethodCall, ParsedReadValueId, RequestContext, ServerContext,
};
use opcua::server::{CreateMonitoredItem, SubscriptionCache};
use opcua::types::{
    AttributeId, DataValue, DateTime, NumericRange, ReadRawModifiedDetails, StatusCode,
    TimestampsToReturn, Variant,
};

use super::ServerConfig;
use super::alarms::Conditions;
use super::events::time;
use super::history;
use super::methods::{Method, number, returned};
use super::seats::{Seat, Seats};
use super::space::{NAMESPACE, Node, Space};
use super::values::{Seen, all};
use crate::hub::{Caller, Hub};
use crate::plugs::refusal::{Failed, Refusal};
use crate::plugs::seat::PlugSeat;
use crate::plugs::sight::Tally;
use crate::sync::lock;

/// Values that wait for an item.
const VALUES_MAX: usize = 100;

/// The nodes of the hub.
pub struct Nodes {
    namespace: u16,
    view: View,
    seats: Seats,
    conditions: Conditions,
}

/// What is seen of the monitors.
#[derive(Clone)]
pub struct View {
    hub: Hub,
    config: Arc<ServerConfig>,
    space: Arc<OnceLock<Space>>,
    /// Looks on.
    caller: Caller,
}

impl View {
    /// Of the monitors of a server.
    pub fn new(hub: &Hub, config: &Arc<ServerConfig>, space: &Arc<OnceLock<Space>>) -> Self {
        let (hub, config, space) = (hub.clone(), config.clone(), space.clone());
        Self { hub, config, space, caller: Caller::hub() }
    }

    fn tallies(&self) -> Vec<Tally> {
        PlugSeat { hub: &self.hub, caller: &self.caller }.tallies(&self.config.monitors)
    }

    /// The values of the variables of a monitor.
    fn values(&self, at: usize, tallies: &[Tally]) -> Vec<DataValue> {
        let id = self.config.monitors.get(at).map(String::as_str).unwrap_or_default();
        let tally = tallies.get(at).copied().unwrap_or_default();
        let seat = PlugSeat { hub: &self.hub, caller: &self.caller };
        let holder = self.holder(at).unwrap_or_default();
        let now = DateTime::now();
        seat.sees(id, tally, |known| {
            let heard = known.status.at_ms.map_or(now, time);
            let stamped = |seen: Seen| DataValue {
                value: Some(seen.value),
                status: Some(seen.status),
                source_timestamp: Some(if seen.own { now } else { heard }),
                source_picoseconds: None,
                server_timestamp: Some(now),
                server_picoseconds: None,
            };
            all().map(|(_, spec)| stamped(spec.of.seen(known, &holder))).collect()
        })
    }

    /// Who has authority over a monitor.
    fn holder(&self, at: usize) -> Option<String> {
        let station = self.hub.station(self.config.monitors.get(at)?).ok()?;
        let authority = lock(&station.authority);
        authority.holder().map(|(seat, _)| seat.user.clone())
    }

    /// Shows the subscribers what is new: the library compares.
    pub fn look(&self, subscriptions: &SubscriptionCache) {
        let Some(space) = self.space.get() else { return };
        let mut notifier = subscriptions.data_notifier();
        let mut tallies = None;
        for at in 0..self.config.monitors.len() {
            let mut values = None;
            for (place, id) in space.variables(at).iter().enumerate() {
                let Some(mut items) = notifier.notify_for(id, AttributeId::Value) else { continue };
                let tallies = tallies.get_or_insert_with(|| self.tallies());
                let values = values.get_or_insert_with(|| self.values(at, tallies));
                if let Some(value) = values.get(place) {
                    items.data_value(value.clone());
                }
            }
        }
    }
}

fn with_stamps(mut value: DataValue, stamps: TimestampsToReturn) -> DataValue {
    if matches!(stamps, TimestampsToReturn::Server | TimestampsToReturn::Neither) {
        value.source_timestamp = None;
    }
    if matches!(stamps, TimestampsToReturn::Source | TimestampsToReturn::Neither) {
        value.server_timestamp = None;
    }
    value
}

fn bad(status: StatusCode) -> DataValue {
    DataValue { status: Some(status), ..DataValue::null() }
}

impl Nodes {
    /// Makes them.
    pub fn new(
        (context, nodes): (ServerContext, &mut AddressSpace),
        (view, seats, conditions): (View, Seats, Conditions),
    ) -> Self {
        let namespace = {
            let mut types = context.type_tree.write();
            types.namespaces_mut().add_namespace(NAMESPACE)
        };
        nodes.add_namespace(NAMESPACE, namespace);
        let space = Space::build(nodes, namespace, &view.config.monitors);
        _ = view.space.set(space);
        Self { namespace, view, seats, conditions }
    }

    fn node(&self, id: &opcua::types::NodeId) -> Option<Node> {
        self.view.space.get()?.of(id)
    }

    /// Calls a method: its status, and what it returns.
    async fn called(
        &self,
        seat: &Seat,
        (monitor, method): (Option<usize>, Method),
        inputs: Vec<Variant>,
    ) -> (StatusCode, Vec<Variant>) {
        let config = &self.view.config;
        let missing = method.inputs().len().saturating_sub(inputs.len());
        // Stop is never held up by its form, nor Close: without a valve it closes all.
        if missing > 0 && !matches!(method, Method::Of(it) if it.is_urgent()) {
            return (StatusCode::BadArgumentsMissing, Vec::new());
        }
        match (method, monitor) {
            (Method::Key, Some(at)) => match seat.key(at).await {
                Some(key) if seat.rights.operates => (StatusCode::Good, vec![key.into()]),
                _ => (StatusCode::BadUserAccessDenied, Vec::new()),
            },
            (Method::Alive, _) => match seat.alive(number(inputs.first())).await {
                Some((ticket, live)) => {
                    (StatusCode::Good, vec![ticket.unwrap_or_default().into(), live.into()])
                }
                None => (StatusCode::BadSessionClosed, Vec::new()),
            },
            (Method::Key, None) => (StatusCode::BadMethodInvalid, Vec::new()),
            (method, monitor) => {
                let result = seat.command(monitor, method, inputs).await;
                let by = monitor.filter(|_| is_by_holder(result));
                let by = by.and_then(|at| self.view.holder(at)).unwrap_or_default();
                let id = monitor.and_then(|at| config.monitors.get(at));
                let id = id.map(String::as_str).unwrap_or_default();
                returned(result, &by, id, config.language)
            }
        }
    }
}

fn is_by_holder(result: Result<(), Failed>) -> bool {
    result.is_err_and(|it| it.why == Refusal::Held)
}

#[async_trait]
impl InMemoryNodeManagerImpl for Nodes {
    async fn init(&self, _: &mut AddressSpace, _: ServerContext) {}

    fn name(&self) -> &'static str {
        "lafet"
    }

    fn namespaces(&self) -> Vec<NamespaceMetadata> {
        vec![NamespaceMetadata {
            namespace_uri: NAMESPACE.to_owned(),
            namespace_index: self.namespace,
            ..NamespaceMetadata::default()
        }]
    }

    async fn read_values(
        &self,
        context: &RequestContext,
        address_space: &RwLock<AddressSpace>,
        nodes: &[&ParsedReadValueId],
        max_age: f64,
        stamps: TimestampsToReturn,
    ) -> Vec<DataValue> {
        let reads = self.seats.may_read(context);
        let (mut tallies, mut monitors) = (None, HashMap::new());
        let address_space = address_space.read();
        let one = |node: &&ParsedReadValueId| match self.node(&node.node_id) {
            _ if !reads => bad(StatusCode::BadUserAccessDenied),
            Some(Node::Variable(..)) if !matches!(node.index_range, NumericRange::None) => {
                bad(StatusCode::BadIndexRangeNoData)
            }
            Some(Node::Variable(at, place)) => {
                let tallies = tallies.get_or_insert_with(|| self.view.tallies());
                let values = monitors.entry(at).or_insert_with(|| self.view.values(at, tallies));
                let value = values.get(place).cloned();
                value.map_or(bad(StatusCode::BadNodeIdUnknown), |it| with_stamps(it, stamps))
            }
            _ => address_space.read(context, node, max_age, stamps),
        };
        nodes.iter().map(one).collect()
    }

    async fn create_value_monitored_items(
        &self,
        context: &RequestContext,
        address_space: &RwLock<AddressSpace>,
        items: &mut [&mut &mut CreateMonitoredItem],
    ) {
        let reads = self.seats.may_read(context);
        let asked: Vec<_> = items.iter().map(|it| it.item_to_monitor()).collect();
        let stamps = TimestampsToReturn::Both;
        let values = self.read_values(context, address_space, &asked, 0.0, stamps).await;
        for (value, item) in values.into_iter().zip(items) {
            item.revise_queue_size(VALUES_MAX);
            if reads {
                item.set_initial_value(value);
            }
            item.set_status(if reads { StatusCode::Good } else { StatusCode::BadUserAccessDenied });
        }
    }

    async fn create_event_monitored_items(
        &self,
        context: &RequestContext,
        _: &RwLock<AddressSpace>,
        items: &mut [&mut &mut CreateMonitoredItem],
    ) {
        self.conditions.came(context, items.iter_mut().map(|it| &mut ***it));
    }

    async fn call(
        &self,
        context: &RequestContext,
        _: &RwLock<AddressSpace>,
        methods_to_call: &mut [&mut &mut MethodCall],
    ) -> Result<(), StatusCode> {
        let Some(seat) = self.seats.of(context) else {
            return Err(StatusCode::BadUserAccessDenied);
        };
        let calls = methods_to_call.iter_mut().map(|call| {
            let seat = seat.clone();
            async move {
                let Some(Node::Method(monitor, method)) = self.node(call.method_id()) else {
                    return call.set_status(StatusCode::BadMethodInvalid);
                };
                let inputs = call.arguments().to_vec();
                let (status, outputs) = self.called(&seat, (monitor, method), inputs).await;
                call.set_outputs(outputs);
                call.set_status(status);
            }
        });
        join_all(calls).await;
        Ok(())
    }

    async fn history_read_raw_modified(
        &self,
        context: &RequestContext,
        details: &ReadRawModifiedDetails,
        nodes: &mut [&mut &mut HistoryNode],
        stamps: TimestampsToReturn,
    ) -> Result<(), StatusCode> {
        let reads = self.seats.may_read(context);
        for node in nodes {
            let variable = match self.node(node.node_id()) {
                Some(Node::Variable(at, place)) => all().nth(place).zip(Some(at)),
                _ => None,
            };
            let series = variable.and_then(|((_, spec), at)| spec.series.zip(Some(at)));
            let Some((series, at)) = series.filter(|_| reads) else {
                node.set_status(if reads {
                    StatusCode::BadHistoryOperationUnsupported
                } else {
                    StatusCode::BadUserAccessDenied
                });
                continue;
            };
            let monitor = self.view.config.monitors.get(at).map(String::as_str).unwrap_or_default();
            let asked = history::Asked { details, stamps, monitor, series };
            history::read(&self.view.hub, node, &asked).await;
        }
        Ok(())
    }
}
