//! The nodes of the standard itself, as the library has them, with the methods of conditions that it leaves out.

use std::sync::Arc;

use async_trait::async_trait;
use opcua::nodes::DefaultTypeTree;
use opcua::server::CreateMonitoredItem;
use opcua::server::diagnostics::NamespaceMetadata;
use opcua::server::node_manager::memory::{CoreNodeManagerBuilder, InMemoryNodeManagerBuilder};
use opcua::server::node_manager::{
    BrowseNode, BrowsePathItem, DynNodeManager, ExternalReferenceRequest, MethodCall,
    MonitoredItemRef, MonitoredItemUpdateRef, NodeManager, NodeManagerBuilder, ReadNode,
    RegisterNodeItem, RequestContext, ServerContext,
};
use opcua::types::{
    AttributeId, ExpandedNodeId, MonitoringMode, NodeId, StatusCode, TimestampsToReturn,
};

use super::alarms::{Conditions, Deed};
use super::events;

/// The nodes of the standard.
pub struct Base {
    inner: Arc<DynNodeManager>,
    conditions: Conditions,
}

impl Base {
    /// Them, with these conditions.
    pub fn new(context: ServerContext, conditions: Conditions) -> Self {
        let builder = InMemoryNodeManagerBuilder::new(CoreNodeManagerBuilder);
        Self { inner: Box::new(builder).build(context), conditions }
    }
}

type Done = Result<(), StatusCode>;

#[async_trait]
impl NodeManager for Base {
    fn owns_node(&self, id: &NodeId) -> bool {
        self.inner.owns_node(id)
    }

    fn name(&self) -> &str {
        self.inner.name()
    }

    fn owns_server_events(&self) -> bool {
        self.inner.owns_server_events()
    }

    fn handle_new_node(&self, parent_id: &ExpandedNodeId) -> bool {
        self.inner.handle_new_node(parent_id)
    }

    fn namespaces_for_user(&self, context: &RequestContext) -> Vec<NamespaceMetadata> {
        self.inner.namespaces_for_user(context)
    }

    async fn init(&self, type_tree: &mut DefaultTypeTree, context: ServerContext) {
        self.inner.init(type_tree, context).await;
        events::complete(type_tree);
    }

    async fn resolve_external_references(
        &self,
        context: &RequestContext,
        items: &mut [&mut ExternalReferenceRequest],
    ) {
        self.inner.resolve_external_references(context, items).await;
    }

    async fn read(
        &self,
        context: &RequestContext,
        max_age: f64,
        timestamps_to_return: TimestampsToReturn,
        nodes_to_read: &mut [&mut ReadNode],
    ) -> Done {
        self.conditions.saw(context);
        self.inner.read(context, max_age, timestamps_to_return, nodes_to_read).await
    }

    async fn browse(&self, context: &RequestContext, nodes_to_browse: &mut [BrowseNode]) -> Done {
        self.inner.browse(context, nodes_to_browse).await
    }

    async fn translate_browse_paths_to_node_ids(
        &self,
        context: &RequestContext,
        nodes: &mut [&mut BrowsePathItem],
    ) -> Done {
        self.inner.translate_browse_paths_to_node_ids(context, nodes).await
    }

    async fn register_nodes(
        &self,
        context: &RequestContext,
        nodes: &mut [&mut RegisterNodeItem],
    ) -> Done {
        self.inner.register_nodes(context, nodes).await
    }

    async fn create_monitored_items(
        &self,
        context: &RequestContext,
        items: &mut [&mut CreateMonitoredItem],
    ) -> Done {
        if !self.conditions.may_read(context) {
            items.iter_mut().for_each(|it| it.set_status(StatusCode::BadUserAccessDenied));
            return Ok(());
        }
        self.inner.create_monitored_items(context, items).await?;
        let events = AttributeId::EventNotifier;
        let is_of_events =
            |it: &&mut &mut CreateMonitoredItem| it.item_to_monitor().attribute_id == events;
        self.conditions.came(context, items.iter_mut().filter(is_of_events).map(|it| &mut **it));
        Ok(())
    }

    async fn modify_monitored_items(
        &self,
        context: &RequestContext,
        items: &[&MonitoredItemUpdateRef],
    ) {
        self.inner.modify_monitored_items(context, items).await;
    }

    async fn set_monitoring_mode(
        &self,
        context: &RequestContext,
        mode: MonitoringMode,
        items: &[&MonitoredItemRef],
    ) {
        self.inner.set_monitoring_mode(context, mode, items).await;
    }

    async fn delete_monitored_items(&self, context: &RequestContext, items: &[&MonitoredItemRef]) {
        self.inner.delete_monitored_items(context, items).await;
    }

    async fn call(
        &self,
        context: &RequestContext,
        methods_to_call: &mut [&mut MethodCall],
    ) -> Done {
        let mut others: Vec<&mut MethodCall> = Vec::new();
        for call in methods_to_call.iter_mut() {
            match Deed::of(call.method_id()) {
                Some(deed) => self.conditions.call(context, deed, call).await,
                None => others.push(call),
            }
        }
        if others.is_empty() { Ok(()) } else { self.inner.call(context, &mut others).await }
    }
}
