//! A simulated site behind the hub: what the hub asks of it. The hub knows no simulator; the program
//! that starts both (`lafet demo`) connects them.

mod shown;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

pub use shown::{
    Burning, Check, CheckState, Fault, JetShown, LinkState, Scenario, Scene, Score, Simulated,
    Splash, State,
};

use crate::config::MonitorConfig;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::site::Site;
use crate::store::Act as Noted;
use crate::text::Both;

/// A simulated site that can be changed while it runs.
pub trait Simulation: std::fmt::Debug + Send + Sync {
    /// The scenarios that can be loaded and the faults that can be injected.
    fn catalogue(&self) -> (Vec<Scenario>, Vec<Fault>);

    /// What runs: the topic `sim`.
    fn state(&self) -> State;

    /// Simulated time against the clock, 1 = the same.
    fn speed(&self) -> f64 {
        1.0
    }

    /// Loads a scenario and starts it. `seed`: the scenario's own if `None`.
    ///
    /// # Errors
    /// There is no such scenario.
    fn load(&self, scenario: &str, seed: Option<u64>, automatic: bool) -> Result<Loaded, Both>;

    /// Changes something.
    ///
    /// # Errors
    /// There is no such monitor, fault, fire or kind of fire, or too many fires burn.
    fn act(&self, act: &Act) -> Result<(), Both>;

    /// A monitor has accepted a client's request, given as text.
    fn commanded(&self, monitor: &str, request: &str);

    /// The report so far, in the format of `lafet sim run --json`.
    fn report(&self) -> Value;

    /// The report as a picture (SVG).
    fn picture(&self, russian: bool) -> String;
}

/// The site of a scenario.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Monitors of the scenario.
    pub monitors: Vec<MonitorConfig>,
    /// Places and heights, as the API publishes them.
    pub site: Option<Site>,
}

/// A change of a simulated site.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = SimAct)]
pub enum Act {
    /// Whether the scenario's own operator and controllers act.
    Automatic(bool),
    /// Simulated time is stopped, or goes on.
    Pause(bool),
    /// So many times as fast as the clock.
    Speed(f64),
    /// A fault of a monitor begins or ends; `all` can only end.
    Fault {
        /// Id of the monitor.
        monitor: String,
        /// Name of the fault.
        fault: String,
        /// Whether the fault begins or ends.
        on: bool,
    },
    /// A fire is lit at a place, metres east and north.
    Fire {
        /// Place of the fire, m east and north.
        at: [f64; 2],
        /// Diameter of the fire, m.
        size: f64,
        /// `pool`, `pile` or `spray`.
        kind: String,
    },
    /// A fire of the scenario is lit.
    Ignite(String),
    /// The link to a monitor is lost, or back.
    Link {
        /// Id of the monitor.
        monitor: String,
        /// Whether the link is restored or cut.
        up: bool,
    },
}

impl Act {
    /// Its name in the audit log.
    const fn what(&self) -> &'static str {
        match self {
            Self::Automatic(_) => "sim automatic",
            Self::Pause(_) => "sim pause",
            Self::Speed(_) => "sim speed",
            Self::Fault { .. } => "sim fault",
            Self::Fire { .. } => "sim fire",
            Self::Ignite(_) => "sim ignite",
            Self::Link { .. } => "sim link",
        }
    }
}

impl Hub {
    /// The simulation, where there is one.
    pub fn simulation(&self) -> Result<&dyn Simulation, ApiError> {
        self.simulated().ok_or_else(ApiError::not_found)
    }

    /// Publishes the state of the simulation.
    pub fn publish_simulation(&self) {
        if let Some(simulation) = self.simulated() {
            self.topics().set("sim", &simulation.state());
        }
    }

    /// Loads a scenario: other monitors, on another site.
    pub fn load_scenario(
        &self,
        caller: &Caller,
        scenario: &str,
        seed: Option<u64>,
        automatic: bool,
    ) -> Result<State, ApiError> {
        let simulation = self.simulation()?;
        let loaded = simulation.load(scenario, seed, automatic);
        let act = Noted::SimScenario { scenario: scenario.into(), seed };
        self.note_act(caller, &format!("sim scenario {scenario}"), &act, loaded.is_ok());
        let Loaded { monitors, site } = loaded.map_err(ApiError::bad_request)?;
        self.replace_monitors(&monitors, site);
        self.publish_simulation();
        Ok(simulation.state())
    }

    /// Changes something in the simulation.
    pub fn act(&self, caller: &Caller, act: &Act) -> Result<State, ApiError> {
        let simulation = self.simulation()?;
        if let Act::Fault { monitor, .. } | Act::Link { monitor, .. } = act {
            self.station(monitor)?;
        }
        let done = simulation.act(act);
        self.note_act(caller, act.what(), &Noted::Sim { act: act.clone() }, done.is_ok());
        done.map_err(ApiError::bad_request)?;
        self.publish_simulation();
        Ok(simulation.state())
    }

    fn note_act(&self, caller: &Caller, what: &str, act: &Noted, done: bool) {
        let outcome = if done { "Ok" } else { "refused" };
        drop(self.audit().note(self.record(caller, "", what, outcome).about(act)));
    }
}
