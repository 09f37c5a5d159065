//! Plugs: other systems that connect to the hub in a protocol of theirs, or to which it connects. Each has
//! sessions like a console, and goes through the same authority, commands and audit log.
//!
//! ```text
//!  modbus, mqtt, opcua ─▶ orders ─▶ seat ─▶ hub: authority, commands
//!           ▲
//!         sight ◀─ states of the monitors
//! ```

pub mod closing;
pub mod modbus;
pub mod mqtt;
mod noted;
pub mod opcua;
pub mod orders;
pub mod refusal;
mod seat;
pub mod sight;
pub mod view;

use crate::hub::Hub;
use view::PlugView;

/// The plugs as clients of the API see them.
pub fn views(hub: &Hub) -> Vec<PlugView> {
    let mut views = hub.modbus_servers().view();
    views.extend(hub.mqtt_brokers().view());
    views.extend(hub.opcua_servers().view());
    views
}

/// Starts all of the configuration.
pub fn start(hub: &Hub) {
    modbus::start(hub);
    mqtt::start(hub);
    opcua::start(hub);
}

/// Whether commands that came so are a plug's: their seat has signs of life of its own.
pub fn is_plug(via: &str) -> bool {
    [modbus::VIA, mqtt::VIA, opcua::VIA].contains(&via)
}
