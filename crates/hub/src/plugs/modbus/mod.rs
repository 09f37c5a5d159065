//! The Modbus server: a PLC, a SCADA system or a fire panel is the master, over TCP or a serial line.
//!
//! ```text
//!  serve ─▶ rtu / tcp ─▶ pdu ─▶ desk ─▶ hand ─▶ hub: authority, beats, commands
//!  bytes    frames       ask    decides  orders
//!                         ▲
//!                       sight ◀─ states of the monitors
//! ```
//!
//! [`desk`] decides and is without I/O and clock; the register map is our own: docs/modbus.md.

pub mod access;
pub mod desk;
mod frames;
mod hand;
mod heart;
pub mod layout;
pub mod map;
pub mod orders;
pub mod pdu;
mod serve;
pub mod sight;
pub mod vectors;

#[cfg(test)]
mod attack;
#[cfg(test)]
mod desk_tests;

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

pub use super::{refusal, view};
use crate::field::line::Line;
use crate::hub::Hub;
use crate::plugs::noted::ByName;
use access::{Grant, Net};
use desk::Terms;
use view::{Counts, PlugView};

/// How commands of a master came, in the audit log.
pub const VIA: &str = "modbus";

/// A server of the configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerConfig {
    /// Its name, in logs.
    pub name: String,
    /// Where it listens.
    pub place: Place,
    /// Addresses that may connect; none: loopback alone.
    pub allow: Vec<Net>,
    /// Address of the first unit; each has eight monitors.
    pub unit: u8,
    /// The monitors, in the order of the map.
    pub monitors: Vec<String>,
    /// Who may do what: the first one that fits counts.
    pub grants: Vec<Grant>,
    /// Times, and what happens to water that a lost master has opened.
    pub terms: Terms,
    /// A connection without a request is closed after this time.
    pub idle: Duration,
    /// Most connections.
    pub connections_max: usize,
}

/// Where a server listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Modbus TCP, or frames of a serial line over TCP.
    Tcp(SocketAddr, crate::field::wire::Framing),
    /// A serial line.
    Serial(Line),
}

impl ServerConfig {
    /// The units, each with its monitors.
    pub fn units(&self) -> Vec<(u8, &[String])> {
        (self.unit..=u8::MAX).zip(self.monitors.chunks(layout::MONITORS)).collect()
    }

    /// What a master writes to reach it.
    pub fn url(&self) -> String {
        match &self.place {
            Place::Tcp(address, crate::field::wire::Framing::Tcp) => format!("tcp://{address}"),
            Place::Tcp(address, _) => format!("rtu+tcp://{address}"),
            Place::Serial(line) => line.to_string(),
        }
    }
}

/// The servers of a hub.
#[derive(Debug, Default)]
pub struct Servers(Vec<Arc<Server>>);

/// A server.
#[derive(Debug)]
pub struct Server {
    config: ServerConfig,
    /// Version of the map, for each unit.
    versions: Vec<u32>,
    counts: Counts,
    /// What is reported of masters.
    reports: ByName,
}

impl Servers {
    /// The servers of the configuration; none listens yet.
    pub fn new(configs: &[ServerConfig]) -> Self {
        let one = |config: &ServerConfig| {
            let version = |(unit, ids): (u8, &[String])| map::version(unit, ids);
            Arc::new(Server {
                versions: config.units().into_iter().map(version).collect(),
                counts: Counts::default(),
                reports: ByName::default(),
                config: config.clone(),
            })
        };
        Self(configs.iter().map(one).collect())
    }

    /// The servers as clients of the API see them.
    pub fn view(&self) -> Vec<PlugView> {
        let one = |server: &Arc<Server>| {
            let config = &server.config;
            server.counts.view("modbus", &config.name, config.url())
        };
        self.0.iter().map(one).collect()
    }
}

/// Listens until the hub ends.
pub fn start(hub: &Hub) {
    for server in &hub.modbus_servers().0 {
        let (own, server) = (hub.clone(), server.clone());
        drop(hub.again("a Modbus server", move || serve::run(own.clone(), server.clone())));
    }
}
