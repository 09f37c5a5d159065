//! MQTT: the hub publishes its monitors to a broker, and takes commands of the broker's clients.
//!
//! ```text
//!  link ─▶ serve ─▶ message ─▶ desk ─▶ hand ─▶ hub: authority, commands
//!  broker    │       ask       decides  orders
//!    ◀──── outbox ◀─ state, discovery, results
//! ```
//!
//! [`desk`] decides and is without I/O and clock; topics and messages are our own: docs/mqtt.md. A broker with
//! `sparkplug` has those of that format instead, from the same desk.

pub mod desk;
pub mod discovery;
pub mod hand;
mod leftover;
mod link;
pub mod message;
pub mod outbox;
mod reason;
mod serve;
mod session;
mod sparkplug;
mod state;
mod words;

#[cfg(test)]
mod attack;
#[cfg(test)]
mod desk_tests;

use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use tokio::task::JoinHandle;

use super::view::{Counts, PlugView};
use crate::hub::Hub;
use crate::sync::lock;
use desk::Terms;
pub use link::Files;
pub use sparkplug::NodeConfig;

/// How commands of a broker came, in the audit log.
pub const VIA: &str = "mqtt";
/// The hub waits so long at its end for the brokers to take what it says last.
const FAREWELL: Duration = Duration::from_secs(3);

/// A broker of the configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BrokerConfig {
    /// Its name, in logs.
    pub name: String,
    /// Name or address.
    pub host: String,
    /// Port.
    pub port: u16,
    /// Its certificates; `None`: without TLS.
    pub tls: Option<Files>,
    /// User and password.
    pub login: Option<Login>,
    /// The hub's name at the broker.
    pub client_id: String,
    /// What all topics begin with.
    pub prefix: String,
    /// The monitors.
    pub monitors: Vec<String>,
    /// One state of a monitor in this time.
    pub interval: Duration,
    /// Who may do what, and what happens when the clients are silent.
    pub terms: Terms,
    /// Prefix of Home Assistant's discovery; `None`: it is not published.
    pub homeassistant: Option<String>,
    /// The edge node that it is instead of the plain topics; `None`: those.
    pub sparkplug: Option<NodeConfig>,
}

/// User and password at a broker.
#[derive(Clone, PartialEq, Eq)]
pub struct Login {
    /// The user.
    pub user: String,
    /// The password.
    pub secret: Option<Secret>,
}

/// A password.
#[derive(Clone, PartialEq, Eq)]
pub enum Secret {
    /// In hub.toml.
    Here(String),
    /// The first line of a file, read at each connection.
    File(PathBuf),
}

impl std::fmt::Debug for Login {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Login").field("user", &self.user).finish_non_exhaustive()
    }
}

impl BrokerConfig {
    /// Where it is.
    pub fn url(&self) -> String {
        let scheme = if self.tls.is_some() { "mqtts" } else { "mqtt" };
        format!("{scheme}://{}", self.place())
    }

    /// Host and port.
    pub fn place(&self) -> String {
        let (host, port) = (&self.host, self.port);
        if host.contains(':') { format!("[{host}]:{port}") } else { format!("{host}:{port}") }
    }

    /// A topic of the hub.
    pub fn topic(&self, part: &str) -> String {
        format!("{}/{part}", self.prefix)
    }

    /// A topic of a monitor; `None`: of all.
    pub fn topic_of(&self, monitor: Option<usize>, part: &str) -> String {
        match monitor.and_then(|at| self.monitors.get(at)) {
            Some(id) => format!("{}/{id}/{part}", self.prefix),
            None => self.topic(part),
        }
    }
}

/// The brokers of a hub.
#[derive(Debug, Default)]
pub struct Brokers {
    all: Vec<Arc<Broker>>,
    tasks: Mutex<Vec<JoinHandle<()>>>,
}

/// A broker.
#[derive(Debug)]
pub struct Broker {
    config: BrokerConfig,
    counts: Counts,
}

impl Brokers {
    /// The brokers of the configuration; none is connected yet.
    pub fn new(configs: &[BrokerConfig]) -> Self {
        let one = |config: &BrokerConfig| {
            let counts = Counts::default();
            counts.set_error(Some(text::MqttNotYet.words()));
            Arc::new(Broker { config: config.clone(), counts })
        };
        Self { all: configs.iter().map(one).collect(), tasks: Mutex::default() }
    }

    /// The brokers as clients of the API see them.
    pub fn view(&self) -> Vec<PlugView> {
        let one = |broker: &Arc<Broker>| {
            let config = &broker.config;
            broker.counts.view("mqtt", &config.name, config.url())
        };
        self.all.iter().map(one).collect()
    }
}

/// Connects, until the hub ends.
pub fn start(hub: &Hub) {
    let brokers = hub.mqtt_brokers();
    let run = |broker: &Arc<Broker>| {
        let (own, broker) = (hub.clone(), broker.clone());
        if broker.config.sparkplug.is_some() {
            return hub
                .again("an edge node", move || sparkplug::serve::run(own.clone(), broker.clone()));
        }
        hub.again("a broker", move || serve::run(own.clone(), broker.clone()))
    };
    *lock(&brokers.tasks) = brokers.all.iter().map(run).collect();
}

/// Waits until the brokers know that the hub ends.
pub async fn ended(hub: &Hub) {
    let tasks = std::mem::take(&mut *lock(&hub.mqtt_brokers().tasks));
    let all = futures_util::future::join_all(tasks);
    _ = tokio::time::timeout(FAREWELL, all).await;
}
