//! The OPC UA server: SCADA systems browse the monitors, subscribe to their values and alarms, and call methods.
//!
//! ```text
//!  front ─▶ library: channels, ─▶ nodes ─▶ seats ─▶ desk ─▶ hand ─▶ hub: authority, commands
//!  who may  sessions,              │                decides  orders
//!  connect  subscriptions          └─ values, alarms, history
//! ```
//!
//! The library has a thread of its own: what strangers make it decrypt takes no time of the hub's others. What decides is
//! the desk of MQTT, with one session of OPC UA as its clients: docs/opcua.md.

mod alarms;
mod base;
mod door;
mod events;
mod folder;
mod front;
mod history;
mod login;
mod methods;
mod nodes;
mod peers;
mod post;
mod seats;
mod serve;
mod session;
mod space;
mod values;
mod words;

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use serde::Deserialize;
use tokio::task::JoinHandle;

use super::modbus::access::{Level, Net};
use super::mqtt::desk::Terms;
use super::noted::ByName;
use super::view::{Counts, PlugView};
use crate::hub::Hub;
use crate::sync::lock;
use crate::text::Both;

/// How commands of a client came, in the audit log.
pub const VIA: &str = "opcua";
/// The hub waits so long at its end for the sessions to end what they have started.
const FAREWELL: Duration = Duration::from_secs(3);

/// A server of the configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerConfig {
    /// Its name, in logs.
    pub name: String,
    /// Where it listens.
    pub listen: SocketAddr,
    /// The name or address under which clients reach it.
    pub host: String,
    /// Addresses that may connect; none: loopback alone.
    pub allow: Vec<Net>,
    /// The monitors.
    pub monitors: Vec<String>,
    /// The most that users of the hub may do.
    pub role: Level,
    /// What clients without a user may do.
    pub anonymous: Level,
    /// Connections without security are taken: on loopback alone.
    pub plain: bool,
    /// Language of texts and names.
    pub language: Language,
    /// Who may do what, and what happens when a client is silent.
    pub terms: Terms,
    /// Most sessions.
    pub sessions_max: usize,
    /// Certificate and key; `None`: made at the first start.
    pub own: Option<(PathBuf, PathBuf)>,
    /// Folder of the certificates that are trusted, and were rejected.
    pub folder: PathBuf,
}

/// A language of texts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Language {
    /// English.
    #[default]
    En,
    /// Russian.
    Ru,
}

impl Language {
    /// Its code.
    pub const fn code(self) -> &'static str {
        match self {
            Self::En => "en",
            Self::Ru => "ru",
        }
    }

    /// What is said in it.
    pub fn of(self, words: &Both) -> &str {
        match self {
            Self::En => &words.en,
            Self::Ru => &words.ru,
        }
    }
}

impl ServerConfig {
    /// What a client connects to.
    pub fn url(&self) -> String {
        let (host, port) = (&self.host, self.listen.port());
        format!(
            "opc.tcp://{}:{port}/",
            if host.contains(':') { format!("[{host}]") } else { host.clone() }
        )
    }
}

/// The servers of a hub.
#[derive(Debug, Default)]
pub struct Servers {
    all: Vec<Arc<Server>>,
    tasks: Mutex<Vec<JoinHandle<()>>>,
}

/// A server.
#[derive(Debug)]
pub struct Server {
    config: ServerConfig,
    counts: Counts,
    /// What is reported of clients.
    reports: ByName,
}

impl Servers {
    /// The servers of the configuration; none listens yet.
    pub fn new(configs: &[ServerConfig]) -> Self {
        let one = |config: &ServerConfig| {
            let (counts, reports) = (Counts::default(), ByName::default());
            counts.set_error(Some(text::OpcuaNotYet.words()));
            Arc::new(Server { config: config.clone(), counts, reports })
        };
        Self { all: configs.iter().map(one).collect(), tasks: Mutex::default() }
    }

    /// The servers as clients of the API see them.
    pub fn view(&self) -> Vec<PlugView> {
        let one = |server: &Arc<Server>| {
            let config = &server.config;
            server.counts.view("opcua", &config.name, config.url())
        };
        self.all.iter().map(one).collect()
    }
}

/// Listens until the hub ends.
pub fn start(hub: &Hub) {
    let servers = hub.opcua_servers();
    let run = |server: &Arc<Server>| {
        let (own, server) = (hub.clone(), server.clone());
        hub.again("an OPC UA server", move || serve::run(own.clone(), server.clone()))
    };
    *lock(&servers.tasks) = servers.all.iter().map(run).collect();
}

/// Waits until the sessions have ended what they have started.
pub async fn ended(hub: &Hub) {
    let tasks = std::mem::take(&mut *lock(&hub.opcua_servers().tasks));
    let all = futures_util::future::join_all(tasks);
    _ = tokio::time::timeout(FAREWELL, all).await;
}
