//! What a simulation shows of itself: what can be loaded, what runs, where things are.

use std::collections::BTreeMap;

use serde::Serialize;
use utoipa::ToSchema;

use crate::text::Both;

/// A scenario that can be loaded.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = SimScenario)]
pub struct Scenario {
    /// Its id: the name of its file without `.toml`.
    pub id: String,
    /// Title of the scenario.
    pub title: Both,
    /// What happens in it and what is asked of the operator.
    pub about: Both,
    /// How long it takes, s.
    pub duration_s: f64,
    /// The ids of its monitors.
    pub monitors: Vec<String>,
}

/// A fault that can be simulated.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = SimFault)]
pub struct Fault {
    /// Its name, as `POST /api/sim/faults` takes it: `vertical-jam`.
    pub name: String,
    /// The part of the monitor that it belongs to: `vertical`.
    pub group: &'static str,
    /// Part of the monitor, in words.
    pub group_text: Both,
    /// The fault, in words.
    pub text: Both,
}

/// What runs: the topic `sim`.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = SimState)]
pub struct State {
    /// The id of the scenario.
    pub scenario: String,
    /// How many scenarios have been started, this one included.
    pub run: u64,
    /// The number from which everything random follows.
    pub seed: u64,
    /// Whether the scenario's own operator and controllers act.
    pub automatic: bool,
    /// Simulated time since the start of the scenario, s.
    pub t_s: f64,
    /// When it is over, s.
    pub duration_s: f64,
    /// Whether it is over: the score is final.
    pub over: bool,
    /// Whether simulated time is stopped.
    pub paused: bool,
    /// Simulated time against the clock.
    pub speed: f64,
    /// What is broken, by the id of the monitor.
    pub monitors: BTreeMap<String, Simulated>,
    /// The checks of the scenario.
    pub score: Score,
}

/// What is broken on purpose at a simulated monitor.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = SimMonitor)]
pub struct Simulated {
    /// Names of its faults.
    pub faults: Vec<String>,
    /// The wired link to it.
    pub link: LinkState,
}

/// A simulated link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = SimLinkState)]
pub enum LinkState {
    /// It carries every frame.
    Up,
    /// It carries no frames.
    Lost,
    /// Requests arrive, answers do not.
    AnswersLost,
}

/// How many checks of the scenario are decided.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = SimScore)]
pub struct Score {
    /// Number of checks passed.
    pub passed: usize,
    /// Number of checks failed.
    pub failed: usize,
    /// Checks that are not decided.
    pub open: usize,
    /// The checks in their order.
    pub checks: Vec<Check>,
}

impl From<Vec<Check>> for Score {
    fn from(checks: Vec<Check>) -> Self {
        let count = |state| checks.iter().filter(|check| check.state == state).count();
        Self {
            passed: count(CheckState::Passed),
            failed: count(CheckState::Failed),
            open: count(CheckState::Open),
            checks,
        }
    }
}

/// A check of the scenario.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = SimCheck)]
pub struct Check {
    /// The check, in words.
    pub text: Both,
    /// Result of the check.
    pub state: CheckState,
    /// When it was decided, s of simulated time.
    #[schema(required)]
    pub at_s: Option<f64>,
    /// What was found; null while it is open.
    #[schema(required)]
    pub came: Option<Both>,
}

/// Whether a check is decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[schema(as = SimCheckState)]
pub enum CheckState {
    /// Not decided yet.
    Open,
    /// What is asked has happened.
    Passed,
    /// It has not, and cannot any more.
    Failed,
}

/// What only the simulation knows: the topic `scene`. Places are metres east and north.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct Scene {
    /// Simulated time since the start of the scenario, s.
    pub t_s: f64,
    /// Simulated time against the clock; 0 while it is stopped.
    pub speed: f64,
    /// Where the wind blows to, m/s east and north.
    #[schema(min_items = 2, max_items = 2)]
    pub wind: [f64; 2],
    /// Temperature of the air at the first monitor, °C.
    #[schema(required)]
    pub ambient_c: Option<f64>,
    /// The fires.
    pub fires: Vec<Burning>,
    /// The jets, by the id of the monitor.
    pub jets: BTreeMap<String, JetShown>,
    /// Water that has landed in the last 100 ms.
    pub splashes: Vec<Splash>,
}

/// A fire of the scenario or one that was lit later.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
#[schema(as = SceneFire)]
pub struct Burning {
    /// Its name in the scenario.
    pub name: String,
    /// Centre, m east and north.
    #[schema(min_items = 2, max_items = 2)]
    pub at: [f64; 2],
    /// The diameter that burns, m.
    pub size: f64,
    /// The height of what burns above the ground, m.
    pub base: f64,
    /// Whether it burns.
    pub burns: bool,
    /// The heat it gives off, kW.
    pub heat_kw: f64,
    /// The density of the water that falls on it, l/(s·m²).
    pub density: f64,
}

/// The jet of a monitor.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = SceneJet)]
pub struct JetShown {
    /// The flow, l/s.
    pub lps: f64,
    /// Where it lands; null: it has not landed yet.
    #[schema(required, min_items = 2, max_items = 2)]
    pub lands: Option<[f64; 2]>,
    /// Water given since the start, l.
    pub litres: f64,
}

/// A portion of water that has landed.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = SceneSplash)]
pub struct Splash {
    /// The id of the monitor.
    pub monitor: String,
    /// Centre, m east and north.
    #[schema(min_items = 2, max_items = 2)]
    pub at: [f64; 2],
    /// Amount of water, l.
    pub litres: f64,
    /// The part of it that has come through the foam valve, 0…1.
    pub foam: f64,
}
