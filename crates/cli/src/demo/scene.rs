//! The data that a view of the demonstration shows.

use std::collections::{BTreeMap, VecDeque};

use lafet_client::AnswerBuf;
use lafet_proto::SubsystemId;
use lafet_proto::answer::Reply;
use lafet_proto::flags::DeployerFlags;
use lafet_proto::status::Hotbed;
use lafet_sim::jet::Landing;

use crate::failure::Failure;

/// Most log lines kept.
const LOG_MAX: usize = 200;

/// A line of the log.
#[derive(Clone, Debug)]
pub struct Line {
    /// Simulated time, ms.
    pub at_ms: u64,
    /// Kind of event.
    pub kind: Kind,
    /// Text of the line.
    pub text: String,
}

/// Kind of a log line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A request to the monitor.
    Request,
    /// An answer that is not a refusal.
    Answer,
    /// An answer that is a refusal.
    Refusal,
    /// An event in the simulated world.
    World,
    /// A remark or decision of the operator.
    Operator,
}

impl Kind {
    /// The mark printed before the line.
    pub const fn mark(self) -> &'static str {
        match self {
            Self::Request => "→",
            Self::Answer | Self::Refusal => "←",
            Self::World => "*",
            Self::Operator => "·",
        }
    }
}

/// Everything a view can show.
#[derive(Debug, Default)]
pub struct Scene {
    /// Simulated time, ms.
    pub now_ms: u64,
    /// Current part of the script.
    pub phase: &'static str,
    /// URL of the monitor.
    pub url: String,
    /// Seed of the simulation.
    pub seed: u64,
    /// Last state of each subsystem, as answered.
    pub states: BTreeMap<SubsystemId, AnswerBuf>,
    /// Fire spots, as answered.
    pub hotbeds: Vec<Hotbed>,
    /// The last lines of the log.
    pub log: VecDeque<Line>,
    /// The simulated world, for the plan.
    pub world: Plan,
}

/// What an observer in the field sees.
#[derive(Debug, Default)]
pub struct Plan {
    /// Direction of the barrel, radians, positive left.
    pub azimuth: f64,
    /// Whether the barrel is deployed.
    pub deployed: bool,
    /// Where the water lands; `None` without a jet.
    pub landing: Option<Landing>,
    /// The fires: place (forward, left), diameter, heat.
    pub fires: Vec<((f64, f64), f64, f64)>,
}

impl Scene {
    /// Adds a line to the log.
    pub fn note(&mut self, line: Line) {
        if self.log.len() == LOG_MAX {
            self.log.pop_front();
        }
        self.log.push_back(line);
    }

    /// Updates the states from an answer to GetStatus.
    pub fn learn(&mut self, answers: &[AnswerBuf]) {
        let states = answers.iter().filter(|answer| answer.status().is_success());
        self.states.extend(states.map(|answer| (answer.from(), answer.clone())));
    }

    /// Status flags of a subsystem; 0 if its state is not known.
    pub fn flags(&self, who: SubsystemId) -> u32 {
        let answer = self.states.get(&who).and_then(|answer| answer.decode().ok());
        answer.and_then(|answer| answer.data.flags_bits()).unwrap_or(0)
    }

    /// Whether Deployer has all of these flags set.
    pub fn deployer_is(&self, flags: DeployerFlags) -> bool {
        DeployerFlags::from_bits_retain(self.flags(SubsystemId::DEPLOYER)).contains(flags)
    }

    /// Position of a drive, arc-minutes or mm; `None` if it is not known.
    pub fn position(&self, who: SubsystemId) -> Option<i16> {
        match self.states.get(&who)?.decode().ok()?.data {
            Reply::Drive(status) => Some(status.position),
            Reply::Deployer(status) => Some(status.position),
            _ => None,
        }
    }
}

/// A way of showing the scene.
pub trait View {
    /// Called for each new line of the log.
    fn line(&mut self, line: &Line) -> Result<(), Failure>;
    /// Called when the scene has changed.
    fn draw(&mut self, scene: &Scene) -> Result<(), Failure>;
    /// Whether the viewer wants to quit.
    fn wants_to_leave(&mut self) -> bool {
        false
    }
    /// Called at the end; `to_the_end` is set if the script was completed.
    fn close(&mut self, scene: &Scene, to_the_end: bool) -> Result<(), Failure>;
}

/// A view that shows nothing.
pub struct Nobody;

impl View for Nobody {
    fn line(&mut self, _: &Line) -> Result<(), Failure> {
        Ok(())
    }

    fn draw(&mut self, _: &Scene) -> Result<(), Failure> {
        Ok(())
    }

    fn close(&mut self, _: &Scene, _: bool) -> Result<(), Failure> {
        Ok(())
    }
}
