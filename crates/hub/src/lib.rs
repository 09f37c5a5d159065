//! The hub: one program that owns the links to fire monitors.
//!
//! ```text
//!            browser, programs                       config (TOML, environment, flags)
//!                   │ HTTP, WebSocket, TLS                     │
//!  server ─▶ api ─▶ hub ─▶ command ─▶ station ─▶ lafet-client ─▶ the wire
//!             │      │ authority, beats  ▲ owner (polls)
//!             │      ├─ alarms           │
//!             │      └─ store: audit, history; access: users, sessions, tokens
//!             └─ topics: what is published, the latest value wins
//! ```
//!
//! Everything that decides (who may command, when a motion ends, what an alarm is) is without I/O
//! and clock, in [`authority`], [`beats`], [`alarms`], [`access`].

pub mod access;
pub mod alarms;
mod allowances;
mod api;
pub mod authority;
pub mod beats;
mod broadcast;
mod clock;
mod command;
pub mod config;
mod error;
mod hub;
mod integrity;
mod jet;
mod jogs;
mod link_series;
mod messages;
pub mod model;
mod outcome;
mod owner;
mod paced;
mod program;
mod rates;
mod recording;
mod request;
mod server;
pub mod simulation;
pub mod site;
mod station;
pub mod store;
mod summary;
mod sync;
pub mod text;
mod tls;
pub mod topics;
mod urgent;
mod view;
mod words;

pub use api::{description, messages};
pub use clock::{Clock, ManualTime};
pub use config::{Config, MonitorConfig, Overrides, Problem, RecordingConfig, TlsConfig};
pub use error::ApiError;
pub use hub::Hub;
pub use server::Server;

/// A configuration to start with, as TOML with comments: English, Russian.
pub const EXAMPLES: [&str; 2] =
    [include_str!("../hub.example.toml"), include_str!("../hub.example.ru.toml")];
/// The unit with which systemd runs `lafet serve`.
pub const UNIT: &str = include_str!("../lafet-hub.service");
