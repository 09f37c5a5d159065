//! Scenarios for users: a file describes a site, what happens on it, what the operator does, and
//! what is expected; [`run()`] carries it out in virtual time. `docs/scenarios.md` is the format.
//!
//! ```text
//! TOML → reader, file, scenes, steps, effect → plan::Exercise
//!                                       │ director: the site and its events
//! run: operator, controllers, checks ───┘ recording, log → report (text, JSON), picture (SVG)
//! ```

mod checks;
mod condition;
mod controller;
mod director;
mod effect;
mod file;
mod log;
mod picture;
mod plan;
pub mod reader;
mod recording;
mod report;
mod run;
mod scenes;
mod shipped;
mod steps;

pub use lafet_texts::{Lang, Words};

pub use checks::Check;
pub use condition::SiteCondition;
pub use director::Director;
pub use log::{Counts, Kind, Line};
pub use picture::{canvas, svg};
pub use plan::{
    Action, ControllerPlan, EventPlan, Exercise, Expectation, FirePlan, Link, Moment, MonitorPlan,
    OperatorLine, Rule, Trigger,
};
pub use reader::Problem;
pub use recording::{Bar, BarKind, Bounds, Recording, Sample};
pub use report::{json, text};
pub use run::{FireFigures, MonitorFigures, Outcome, Run, run};
pub use shipped::{SHIPPED, Shipped};

#[cfg(test)]
mod tests;
