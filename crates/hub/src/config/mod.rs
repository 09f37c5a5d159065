//! The configuration of the hub: one TOML file, then the environment, then flags.

mod check;
mod field;
mod file;
mod modbus_server;
mod monitors;
mod mqtt;
mod opcua;
mod outputs;
mod places;
mod plan;
mod supervision;
mod words;
mod written;
mod zones;

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

use lafet_client::Endpoint;

use crate::access::Role;
pub use crate::field::BusConfig;
pub use crate::plugs::modbus::ServerConfig;
pub use crate::plugs::mqtt::BrokerConfig;
pub use crate::plugs::opcua::ServerConfig as OpcuaConfig;
use crate::site::Site;
use crate::store::{Address, StateFile};
use crate::text::Both;
pub use check::Problem;
pub(crate) use check::is_name;
pub use plan::{Area, PlanConfig};
pub use words::of as said;
pub use zones::{Aim, Outlet, Station, Target, ZonesConfig};

/// Environment: the folder that systemd has made for the state.
const STATE: &str = "STATE_DIRECTORY";
/// Default address of the listener.
pub const LISTEN: &str = "127.0.0.1:8480";
/// Environment: the file, the place to listen, the folder of the state.
pub const ENV: [&str; 3] = ["LAFET_HUB_CONFIG", "LAFET_HUB_LISTEN", "LAFET_HUB_DATA"];

/// The configuration of the hub.
#[derive(Clone, Debug)]
pub struct Config {
    /// Address of the listener.
    pub listen: SocketAddr,
    /// Names under which browsers reach it, besides IP addresses and localhost.
    pub names: Vec<String>,
    /// Other origins whose pages may use the API.
    pub origins: Vec<String>,
    /// Proxies whose X-Forwarded-For is trusted.
    pub proxies: Vec<IpAddr>,
    /// Whether users log in. Without login every client is an administrator: on loopback alone.
    pub login: bool,
    /// Folder of the state; `None` keeps it in memory.
    pub data: Option<PathBuf>,
    /// Files of the state whose loss is accepted at this start.
    pub accept_lost: Vec<StateFile>,
    /// New software of a monitor has to be as the monitor was before for so long until it is confirmed.
    pub proven: Duration,
    /// Most open connections.
    pub connections_max: usize,
    /// TLS; without it plain HTTP.
    pub tls: Option<TlsConfig>,
    /// Metrics need no login.
    pub metrics_open: bool,
    /// Milliseconds that a holder whose connection is lost may take to come back.
    pub lost_ms: u64,
    /// PostgreSQL for the history, instead of SQLite.
    pub postgres: Option<Address>,
    /// Days for which each change is kept.
    pub raw_days: u32,
    /// Days for which minutes are kept.
    pub minute_days: u32,
    /// Recordings of frames.
    pub recording: RecordingConfig,
    /// The monitors, in the order of the file.
    pub monitors: Vec<MonitorConfig>,
    /// The map of the site, as the API publishes it.
    pub site: Option<Site>,
    /// Water, winds and what is protected.
    pub plan: PlanConfig,
    /// The zones; `None`: the hub releases nothing by itself.
    pub zones: Option<ZonesConfig>,
    /// Buses of detectors, contacts, outputs and pumps.
    pub modbus: Vec<BusConfig>,
    /// Servers for masters on Modbus.
    pub modbus_servers: Vec<ServerConfig>,
    /// MQTT brokers to which the hub connects.
    pub mqtt: Vec<BrokerConfig>,
    /// OPC UA servers.
    pub opcua: Vec<OpcuaConfig>,
    /// What is not wrong, but should not stay: the hub starts all the same.
    pub warnings: Vec<Problem>,
    /// Monitors are simulated, which the console says.
    pub simulation: bool,
    /// Started by `lafet demo`.
    pub demo: bool,
}

/// Certificates of the hub and its clients.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TlsConfig {
    /// Certificate chain, PEM.
    pub cert: PathBuf,
    /// Private key, PEM.
    pub key: PathBuf,
    /// Who signs clients' certificates; with it every client needs one.
    pub client_ca: Option<PathBuf>,
    /// Role of a client by the common name of its certificate; others have to log in as well.
    pub client_roles: BTreeMap<String, Role>,
}

/// Recordings of frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordingConfig {
    /// Where they are; `None`: in a folder that is removed at the end.
    pub folder: Option<PathBuf>,
    /// Whether alarms are recorded.
    pub alarms: bool,
    /// So much of the time before an alarm, s.
    pub before_s: u64,
    /// So much of the time after it, s.
    pub after_s: u64,
    /// They are removed after so many days …
    pub keep_days: u32,
    /// … or when all of them are larger than this: the oldest first.
    pub keep_mb: u64,
}

impl Default for RecordingConfig {
    fn default() -> Self {
        Self { folder: None, alarms: true, before_s: 30, after_s: 30, keep_days: 90, keep_mb: 2000 }
    }
}

/// A configured monitor.
#[derive(Clone, Debug)]
pub struct MonitorConfig {
    /// Its id in the API.
    pub id: String,
    /// Name for people.
    pub name: Both,
    /// Line and address.
    pub endpoint: Endpoint,
    /// Milliseconds between two polls of its state.
    pub poll_ms: u64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            listen: SocketAddr::from(([127, 0, 0, 1], 8480)),
            names: Vec::new(),
            origins: Vec::new(),
            proxies: Vec::new(),
            login: true,
            data: None,
            accept_lost: Vec::new(),
            proven: lafet_client::update::PROVEN,
            connections_max: 2048,
            tls: None,
            metrics_open: false,
            lost_ms: 3000,
            postgres: None,
            raw_days: 7,
            minute_days: 400,
            recording: RecordingConfig::default(),
            monitors: Vec::new(),
            warnings: Vec::new(),
            site: None,
            plan: PlanConfig::default(),
            zones: None,
            modbus: Vec::new(),
            modbus_servers: Vec::new(),
            mqtt: Vec::new(),
            opcua: Vec::new(),
            simulation: false,
            demo: false,
        }
    }
}

/// Settings from the environment and the command line, which override the file.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Environment variable `LAFET_HUB_LISTEN`.
    pub listen: Option<String>,
    /// Environment variable `LAFET_HUB_DATA`.
    pub data: Option<PathBuf>,
    /// Option `--port`.
    pub port: Option<u16>,
    /// Environment variable `STATE_DIRECTORY`, which systemd sets: where the state is unless the file says it.
    pub state: Option<PathBuf>,
}

impl Overrides {
    /// What the environment says, read by `var`.
    pub fn of_environment(var: impl Fn(&str) -> Option<String>) -> Self {
        let set = |name| var(name).filter(|value| !value.is_empty());
        let path = |name| set(name).map(PathBuf::from);
        Self { listen: set(ENV[1]), data: path(ENV[2]), port: None, state: path(STATE) }
    }
}

impl Config {
    /// Reads the text of a file; `folder` is what relative paths in it start from. Every
    /// problem is reported at once.
    pub fn parse(
        file: &str,
        text: &str,
        folder: &std::path::Path,
        overrides: &Overrides,
    ) -> Result<Self, Vec<Problem>> {
        let (read, is_toml, mut problems) = file::File::read(file, text);
        if !is_toml {
            return Err(problems);
        }
        match check::check(file, text, read, folder, overrides) {
            Ok(config) if problems.is_empty() => Ok(config),
            Ok(_) => Err(problems),
            Err(more) => {
                // What could not be read is missing for the checks: that is no mistake of its own.
                let (whole, end) = (problems.is_empty(), text.len());
                let last = Problem::at(file, text, end, Both::default(), Both::default()).place;
                problems.extend(more.into_iter().filter(|it| whole || it.place != last));
                Err(problems)
            }
        }
    }
}
