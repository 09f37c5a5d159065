//! The hub: one program that owns the links to fire monitors.
//!
//! ```text
//!            browser, programs                       config (TOML, environment, flags)
//!                   │ HTTP, WebSocket, TLS                     │
//!  server ─▶ api ─▶ hub ─▶ command ─▶ monitor ─▶ lafet-client ─▶ the wire
//!             │      │                  │ owner (polls), station (state)
//!             │      ├─ control: authority, beats, jogs
//!             │      ├─ alarms
//!             │      ├─ store: audit, history, events; access: users, sessions, tokens
//!             │      ├─ zones: the zone controller (lafet-site), its detectors and orders
//!             │      ├─ field: detectors on Modbus, which report to the zones
//!             │      ├─ updates: the software of monitors, one after the other
//!             │      ├─ plugs: other protocols, whose clients command like consoles
//!             │      └─ recording, simulation, site
//!             └─ publish: topics, of which the latest value wins; messages
//! ```
//!
//! Everything that decides (who may command, when a motion ends, what an alarm is) is without I/O
//! and clock, in [`control`], [`alarms`], [`access`].

pub mod access;
pub mod alarms;
mod api;
mod clock;
mod command;
pub mod config;
pub mod control;
mod error;
mod field;
mod hub;
mod monitor;
mod plugs;
mod publish;
mod recording;
mod server;
pub mod simulation;
pub mod site;
pub mod store;
mod sync;
pub mod text;
mod updates;
mod words;
mod zones;

pub use api::{description, messages};
pub use clock::{Clock, ManualTime};
pub use config::{
    Area, Config, MonitorConfig, Overrides, PlanConfig, Problem, RecordingConfig, Station,
    TlsConfig, ZonesConfig,
};
pub use error::ApiError;
pub use hub::Hub;
pub use plugs::{modbus as modbus_server, mqtt, opcua};
pub use publish::topics;
pub use server::Server;

/// A configuration to start with, as TOML with comments: English, Russian.
pub const EXAMPLES: [&str; 2] =
    [include_str!("../hub.example.toml"), include_str!("../hub.example.ru.toml")];
/// The unit with which systemd runs `lafet serve`.
pub const UNIT: &str = include_str!("../lafet-hub.service");
