//! The address space: types, the site, and its monitors with their parts, variables and methods.

use std::collections::HashMap;

use opcua::server::address_space::{
    AccessLevel, AddressSpace, EventNotifier, MethodBuilder, ObjectBuilder, ObjectTypeBuilder,
    ReferenceDirection, VariableBuilder,
};
use opcua::types::{
    DataTypeId, EUInformation, ExtensionObject, LocalizedText, NodeId, ObjectId, ObjectTypeId,
    QualifiedName, Range, ReferenceTypeId, UAString, VariableTypeId, Variant,
};

use super::methods::{Method, OF_MONITOR, OF_SITE, declared};
use super::values::{Kind, PARTS, Part, Spec, Unit, all};

/// The namespace of the hub's nodes.
pub const NAMESPACE: &str = "urn:lafet:hub";
/// Where units of measurement are numbered.
const UNITS: &str = "http://www.opcfoundation.org/UA/units/un/cefact";
/// Ids of nodes that belong to no monitor begin with what no name of a monitor has.
const SITE: &str = "$site";

/// A node of the hub, by what it shows or does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// A variable: the monitor, and its place in [`all`].
    Variable(usize, usize),
    /// A method; `None`: of all monitors.
    Method(Option<usize>, Method),
}

/// The nodes by their ids.
#[derive(Debug, Default)]
pub struct Space {
    namespace: u16,
    nodes: HashMap<NodeId, Node>,
    /// Ids of the variables, by monitor and place.
    variables: Vec<Vec<NodeId>>,
    monitors: Vec<NodeId>,
}

impl Space {
    /// Makes the nodes.
    pub fn build(space: &mut AddressSpace, namespace: u16, monitors: &[String]) -> Self {
        let mut own = Self { namespace, ..Self::default() };
        own.types(space);
        let site = own.site();
        ObjectBuilder::new(&site, own.name("Lafet"), "Lafet")
            .organized_by(ObjectId::ObjectsFolder)
            .has_type_definition(own.class("SiteType"))
            .event_notifier(EventNotifier::SUBSCRIBE_TO_EVENTS)
            .reference(ObjectId::Server, ReferenceTypeId::HasNotifier, ReferenceDirection::Inverse)
            .insert(space);
        for method in OF_SITE {
            own.method(space, &site, SITE, (None, method));
        }
        for (at, id) in monitors.iter().enumerate() {
            own.monitor(space, &site, (at, id));
        }
        own
    }

    /// What a node is.
    pub fn of(&self, id: &NodeId) -> Option<Node> {
        self.nodes.get(id).copied()
    }

    /// The variables of a monitor.
    pub fn variables(&self, monitor: usize) -> &[NodeId] {
        self.variables.get(monitor).map(Vec::as_slice).unwrap_or_default()
    }

    /// The node of a monitor, or of the site: where its events come from.
    pub fn source(&self, monitor: Option<usize>) -> NodeId {
        monitor.and_then(|at| self.monitors.get(at)).cloned().unwrap_or_else(|| self.site())
    }

    /// The id of a condition: that of its alarm.
    pub fn condition(&self, alarm: &str) -> NodeId {
        self.id(&format!("$alarm:{alarm}"))
    }

    /// The alarm of a condition, or of its state of shelving.
    pub fn alarm(&self, condition: &NodeId) -> Option<String> {
        if condition.namespace != self.namespace {
            return None;
        }
        let opcua::types::Identifier::String(text) = &condition.identifier else { return None };
        let alarm = text.as_ref().strip_prefix("$alarm:")?;
        Some(alarm.strip_suffix(".ShelvingState").unwrap_or(alarm).to_owned())
    }

    fn id(&self, text: &str) -> NodeId {
        NodeId::new(self.namespace, UAString::from(text))
    }

    fn site(&self) -> NodeId {
        self.id(SITE)
    }

    fn class(&self, class: &str) -> NodeId {
        self.id(&format!("${class}"))
    }

    fn name(&self, name: &str) -> QualifiedName {
        QualifiedName::new(self.namespace, name)
    }

    fn types(&self, space: &mut AddressSpace) {
        let mut made: Vec<&str> = Vec::new();
        for part in PARTS {
            if made.contains(&part.class) {
                continue;
            }
            made.push(part.class);
            self.object_type(space, part.class);
            let (class, prefix) = (self.class(part.class), format!("${}", part.class));
            for spec in part.all {
                _ = self.variable(space, &class, &prefix, spec, true);
            }
        }
        self.object_type(space, "SiteType");
        let monitor = self.class("MonitorType");
        for part in PARTS.iter().filter(|it| !it.name.is_empty()) {
            let id = self.id(&format!("$MonitorType.{}", part.name));
            self.part(&monitor, &id, part)
                .reference(
                    ObjectId::ModellingRule_Mandatory,
                    ReferenceTypeId::HasModellingRule,
                    ReferenceDirection::Forward,
                )
                .insert(space);
        }
        for (class, methods) in [("MonitorType", &OF_MONITOR[..]), ("SiteType", &OF_SITE)] {
            for method in methods {
                let (owner, prefix) = (self.class(class), format!("${class}"));
                self.declare(space, &owner, &prefix, *method);
            }
        }
    }

    fn object_type(&self, space: &mut AddressSpace, class: &str) {
        ObjectTypeBuilder::new(&self.class(class), self.name(class), class)
            .subtype_of(ObjectTypeId::BaseObjectType)
            .insert(space);
    }

    fn part(&self, owner: &NodeId, id: &NodeId, part: &Part) -> ObjectBuilder {
        ObjectBuilder::new(id, self.name(part.name), part.name)
            .component_of(owner.clone())
            .has_type_definition(self.class(part.class))
    }

    fn monitor(&mut self, space: &mut AddressSpace, site: &NodeId, (at, id): (usize, &str)) {
        let node = self.id(id);
        ObjectBuilder::new(&node, self.name(id), id)
            .component_of(site.clone())
            .has_type_definition(self.class("MonitorType"))
            .event_notifier(EventNotifier::SUBSCRIBE_TO_EVENTS)
            .reference(site.clone(), ReferenceTypeId::HasNotifier, ReferenceDirection::Inverse)
            .insert(space);
        self.monitors.push(node.clone());
        let mut variables = Vec::new();
        for part in &PARTS {
            let prefix =
                if part.name.is_empty() { id.to_owned() } else { format!("{id}.{}", part.name) };
            let owner = self.id(&prefix);
            if !part.name.is_empty() {
                self.part(&node, &owner, part).insert(space);
            }
            for spec in part.all {
                let variable = self.variable(space, &owner, &prefix, spec, false);
                self.nodes.insert(variable.clone(), Node::Variable(at, variables.len()));
                variables.push(variable);
            }
        }
        debug_assert_eq!(variables.len(), all().count());
        self.variables.push(variables);
        for method in OF_MONITOR {
            self.method(space, &node, id, (Some(at), method));
        }
    }

    fn variable(
        &self,
        space: &mut AddressSpace,
        owner: &NodeId,
        prefix: &str,
        spec: &Spec,
        is_type: bool,
    ) -> NodeId {
        let text = format!("{prefix}.{}", spec.name);
        let id = self.id(&text);
        let (kind, class) = match spec.kind {
            Kind::Bool => (DataTypeId::Boolean, VariableTypeId::BaseDataVariableType),
            Kind::Count => (DataTypeId::UInt16, VariableTypeId::BaseDataVariableType),
            Kind::Text => (DataTypeId::String, VariableTypeId::BaseDataVariableType),
            Kind::Measure(..) => (DataTypeId::Double, VariableTypeId::AnalogItemType),
        };
        let mut access = AccessLevel::CURRENT_READ;
        if spec.series.is_some() && !is_type {
            access |= AccessLevel::HISTORY_READ;
        }
        let mut builder = VariableBuilder::new(&id, self.name(spec.name), spec.name)
            .component_of(owner.clone())
            .has_type_definition(class)
            .data_type(kind)
            .historizing(spec.series.is_some() && !is_type)
            .access_level(access)
            .user_access_level(access)
            .value(Variant::Empty);
        if is_type {
            builder = builder.has_modelling_rule(ObjectId::ModellingRule_Mandatory);
        }
        builder.insert(space);
        if let Kind::Measure(unit, (low, high)) = spec.kind {
            let range = ExtensionObject::from_message(Range { low, high });
            self.property(space, &text, "EURange", DataTypeId::Range, range);
            let units = DataTypeId::EUInformation;
            self.property(space, &text, "EngineeringUnits", units, unit.information());
        }
        id
    }

    fn property(
        &self,
        space: &mut AddressSpace,
        owner: &str,
        name: &str,
        kind: DataTypeId,
        value: ExtensionObject,
    ) {
        let id = self.id(&format!("{owner}.{name}"));
        VariableBuilder::new(&id, name, name)
            .property_of(self.id(owner))
            .has_type_definition(VariableTypeId::PropertyType)
            .data_type(kind)
            .value(value)
            .insert(space);
    }

    fn method(
        &mut self,
        space: &mut AddressSpace,
        owner: &NodeId,
        prefix: &str,
        (at, method): (Option<usize>, Method),
    ) {
        let id = self.declare(space, owner, prefix, method);
        self.nodes.insert(id, Node::Method(at, method));
    }

    fn declare(
        &self,
        space: &mut AddressSpace,
        owner: &NodeId,
        prefix: &str,
        method: Method,
    ) -> NodeId {
        let text = format!("{prefix}.{}", method.name());
        let id = self.id(&text);
        let mut builder = MethodBuilder::new(&id, self.name(method.name()), method.name())
            .component_of(owner.clone())
            .executable(true)
            .user_executable(true);
        let (inputs, outputs) = (declared(method.inputs()), declared(method.outputs()));
        if !inputs.is_empty() {
            let of = self.id(&format!("{text}.InputArguments"));
            builder = builder.input_args(space, &of, &inputs);
        }
        let of = self.id(&format!("{text}.OutputArguments"));
        builder.output_args(space, &of, &outputs).insert(space);
        id
    }
}

impl Unit {
    fn information(self) -> ExtensionObject {
        ExtensionObject::from_message(EUInformation {
            namespace_uri: UNITS.into(),
            unit_id: self.number(),
            display_name: LocalizedText::new("en", self.sign),
            description: LocalizedText::new("en", self.sign),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn built(monitors: &[&str]) -> (AddressSpace, Space) {
        let mut nodes = AddressSpace::new();
        nodes.add_namespace(NAMESPACE, 2);
        let monitors: Vec<String> = monitors.iter().map(|it| (*it).to_owned()).collect();
        let space = Space::build(&mut nodes, 2, &monitors);
        (nodes, space)
    }

    #[test]
    fn every_variable_and_method_has_its_node() {
        let (nodes, space) = built(&["M1", "site"]);
        for (at, monitor) in ["M1", "site"].iter().enumerate() {
            assert_eq!(space.variables(at).len(), all().count());
            for (id, (part, spec)) in space.variables(at).iter().zip(all()) {
                let part =
                    if part.name.is_empty() { String::new() } else { format!(".{}", part.name) };
                assert_eq!(*id, space.id(&format!("{monitor}{part}.{}", spec.name)));
                assert!(nodes.node_exists(id));
            }
            for method in OF_MONITOR {
                let id = space.id(&format!("{monitor}.{}", method.name()));
                assert_eq!(space.of(&id), Some(Node::Method(Some(at), method)));
            }
        }
        assert!(nodes.node_exists(&space.id("M1.Traverse.Position.EngineeringUnits")));
        assert_eq!(space.of(&space.id("$MonitorType.Stop")), None, "a type does nothing");
    }

    #[test]
    fn conditions_have_the_ids_of_their_alarms() {
        let (_, space) = built(&["M1"]);
        let condition = space.condition("M1/Link/Stale");
        assert_eq!(space.alarm(&condition).as_deref(), Some("M1/Link/Stale"));
        let shelving = space.id("$alarm:M1/Link/Stale.ShelvingState");
        assert_eq!(space.alarm(&shelving).as_deref(), Some("M1/Link/Stale"));
        assert_eq!(space.alarm(&space.id("M1")), None);
        assert_eq!(space.alarm(&NodeId::new(1, UAString::from("$alarm:x"))), None);
    }
}
