//! What reaches the machine. Each event comes with a monotonic time in milliseconds.

use serde::{Deserialize, Serialize};

use crate::config::Mode;

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Event {
    /// A detector reports itself: at each change, and often enough not to be silent.
    Detector {
        /// Its id.
        detector: String,
        /// What it sees.
        signal: Signal,
        /// Whether it can see.
        condition: Condition,
    },
    /// A contact as it is now, bouncing included.
    Contact {
        /// Its id.
        input: String,
        /// Closed, on.
        pressed: bool,
    },
    /// A supervised path is at fault, or well again.
    Path {
        /// Id of an input, an output, a pump or a further path.
        path: String,
        /// `None`: well.
        fault: Option<PathFault>,
    },
    /// A monitor as it is now.
    Monitor {
        /// Its id.
        monitor: String,
        /// What is known of it.
        report: MonitorReport,
    },
    /// Feedback of an output.
    Output {
        /// Its id.
        output: String,
        /// On or open.
        on: bool,
    },
    /// Feedback of a pump.
    Pump {
        /// Its id.
        pump: String,
        /// It runs.
        on: bool,
    },
    /// A person's command.
    Hand {
        /// Who.
        by: String,
        /// What.
        order: Hand,
    },
    /// The planner's order of preference for a zone; others of the zone follow in the configured order.
    Prefer {
        /// The zone.
        zone: String,
        /// Monitors, the preferred first.
        monitors: Vec<String>,
        /// Those that votes may open, as the water suffices; `None`: all of the zone. By hand each may.
        #[serde(default)]
        opens: Option<Vec<String>>,
    },
}

/// What a detector sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = DetectorSignal))]
pub enum Signal {
    /// Nothing.
    #[default]
    Quiet,
    /// Something; no vote.
    PreAlarm,
    /// Fire.
    Alarm,
}

/// Whether a detector can see.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = DetectorCondition))]
pub enum Condition {
    /// It can.
    #[default]
    Ready,
    /// Its window is dirty.
    Dirty,
    /// It is at fault, or its window is covered.
    Fault,
    /// It masks itself.
    Masked,
    /// It tests itself.
    SelfTest,
    /// It is starting up.
    Starting,
}

/// What is wrong with a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PathFault {
    /// Open circuit.
    Open,
    /// Short circuit.
    Short,
    /// Leak to earth.
    Earth,
    /// No supply.
    Power,
    /// The device that reads or drives it does not answer.
    Lost,
}

/// What is known of a monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MonitorReport {
    /// It answers. Without an answer the other fields are the last known ones.
    pub reachable: bool,
    /// Who controls it.
    pub authority: Authority,
    /// Its own lockout is on.
    pub lockout: bool,
    /// Its valve.
    pub valve: Valve,
    /// Its program for extinguishing runs.
    pub extinguishing: bool,
    /// It has a fault that prevents aiming or opening.
    pub failure: bool,
}

impl MonitorReport {
    /// It gives water, or is about to.
    pub fn acts(&self) -> bool {
        matches!(self.valve, Valve::Open | Valve::Opening | Valve::Moving) || self.extinguishing
    }
}

/// Who controls a monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Authority {
    /// No client.
    #[default]
    Free,
    /// This machine.
    Site,
    /// A person: console, local buttons, another panel.
    Person,
}

/// A valve of a monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Valve {
    /// Not known.
    #[default]
    Unknown,
    /// Closed.
    Closed,
    /// Between, and it does not open.
    Moving,
    /// It opens.
    Opening,
    /// Open.
    Open,
}

/// A person's command. Who may give which one is for the caller to check.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneHand))]
pub enum Hand {
    /// Another mode.
    Mode {
        /// The zone.
        zone: String,
        /// The mode.
        mode: Mode,
        /// It returns to automatic after so long, s; without it after `return_after_s` of the zone.
        /// A test always returns: after 900 s, 3600 s at most.
        for_s: Option<u32>,
    },
    /// Holds the delay, or lets it go on.
    Hold {
        /// The zone.
        zone: String,
        /// Hold.
        on: bool,
    },
    /// Ends countdown and water of a zone.
    Abort {
        /// The zone.
        zone: String,
    },
    /// Releases a zone.
    Release {
        /// The zone.
        zone: String,
    },
    /// Closes.
    Close(Scope),
    /// Stops motion, and closes.
    Stop(Scope),
    /// Withdraws a no that is over, forgets troubles that are over.
    Reset(Scope),
    /// Lockout of the site.
    Lockout {
        /// On.
        on: bool,
    },
    /// Masks or disables a detector.
    Bypass {
        /// The detector.
        detector: String,
        /// How.
        bypass: Bypass,
    },
    /// Silences the sounders until something new.
    Silence,
    /// Starts or stops a pump.
    Pump {
        /// The pump.
        pump: String,
        /// Start.
        on: bool,
    },
}

/// What a command is for.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneScope))]
pub enum Scope {
    /// Everything.
    Site,
    /// A zone.
    Zone(String),
    /// A monitor.
    Monitor(String),
}

/// What people withhold from a detector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = DetectorBypass))]
pub enum Bypass {
    /// Nothing.
    #[default]
    None,
    /// Its vote; its alarm is shown.
    Masked,
    /// Vote and alarm.
    Disabled,
}
