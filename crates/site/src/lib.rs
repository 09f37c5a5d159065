//! The zone controller of an installation: from votes of detectors to commands for monitors, pumps and valves.
//!
//! [`Site`] is a pure state machine. It has no I/O and no clock: the caller gives it [`Event`]s with a monotonic
//! time in milliseconds, calls [`Site::step`] at [`Site::next_deadline`], carries out the [`Command`]s of each
//! [`Reaction`], stores its [`Record`]s, and stores [`Site::persisted`] when the reaction says so. The same
//! events give the same commands.
//!
//! Who wins, in this order: lockout; Stop, Close and abort; a release by hand; a hold, before the release and
//! for a limited time; the automatic release.
//!
//! ```
//! use lafet_site::{Condition, Config, Event, Order, Signal, Site};
//!
//! let config: Config = toml::from_str(r#"
//!     monitors = ["north", "south"]
//!     [[zone]]
//!     id = "hall"
//!     votes = "2oo2"
//!     kinds = 2
//!     coincidence_s = 5
//!     water_max_s = 600
//!     monitors = ["north", "south"]
//!     [[detector]]
//!     id = "flame"
//!     kind = "flame"
//!     zones = ["hall"]
//!     [[detector]]
//!     id = "heat"
//!     kind = "heat"
//!     zones = ["hall"]
//! "#).unwrap();
//! let (mut site, _) = Site::new(config, 0, None).unwrap();
//! let sees = |detector: &str, signal| Event::Detector {
//!     detector: detector.to_owned(),
//!     signal,
//!     condition: Condition::Ready,
//! };
//! for detector in ["flame", "heat"] {
//!     site.handle(0, &sees(detector, Signal::Quiet));
//! }
//! let report = lafet_site::MonitorReport { reachable: true, ..Default::default() };
//! site.handle(0, &Event::Monitor { monitor: "north".to_owned(), report });
//! site.handle(1000, &sees("flame", Signal::Alarm));
//! site.handle(2000, &sees("heat", Signal::Alarm));
//! let reaction = site.step(7000);
//! assert!(matches!(&reaction.commands[0].order, Order::Engage { monitor, .. } if monitor == "north"));
//! ```

#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

pub mod config;
mod event;
mod machine;
mod output;
mod persisted;
mod plan;
#[doc(hidden)]
pub mod rules;
mod state;

pub use config::{Config, Mode, Problem};
pub use event::{
    Authority, Bypass, Condition, Event, Hand, MonitorReport, PathFault, Scope, Signal, Valve,
};
pub use machine::Site;
pub use output::{Cause, Command, Entry, Order, Reaction, Record, Refusal, Tone, Why};
pub use persisted::{Persisted, StoredMonitor, StoredZone, VERSION};
pub use state::{
    DetectorState, Disablement, MonitorState, NotReleased, OutputState, Phase, PumpState, State,
    Trouble, TroubleState, Unable, Voteless, Withheld, ZoneState,
};
