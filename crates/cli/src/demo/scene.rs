//! What a view of the demonstration shows.

use std::collections::{BTreeMap, VecDeque};

use lafet_client::AnswerBuf;
use lafet_proto::SubsystemId;
use lafet_proto::answer::Reply;
use lafet_proto::flags::DeployerFlags;
use lafet_proto::status::Hotbed;
use lafet_sim::jet::Landing;

use crate::failure::Failure;

/// Lines of the log that are kept.
const LOG_MAX: usize = 200;

/// A line of the log.
#[derive(Clone, Debug)]
pub struct Line {
    /// Simulated time, ms.
    pub at_ms: u64,
    /// What it is.
    pub kind: Kind,
    /// The text.
    pub text: String,
}

/// What a line of the log is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A request on its way to the monitor.
    Request,
    /// An answer.
    Answer,
    /// A refusal.
    Refusal,
    /// What happens in the world.
    World,
    /// What the operator thinks and decides.
    Operator,
}

impl Kind {
    /// The mark before the line.
    pub const fn mark(self) -> &'static str {
        match self {
            Self::Request => "→",
            Self::Answer | Self::Refusal => "←",
            Self::World => "*",
            Self::Operator => "·",
        }
    }
}

/// Everything that can be seen.
#[derive(Debug, Default)]
pub struct Scene {
    /// Simulated time, ms.
    pub now_ms: u64,
    /// What the script is at.
    pub phase: &'static str,
    /// Where the monitor listens.
    pub url: String,
    /// The seed.
    pub seed: u64,
    /// The last state of each subsystem, as the monitor answered.
    pub states: BTreeMap<SubsystemId, AnswerBuf>,
    /// The hotbeds, as the monitor answered.
    pub hotbeds: Vec<Hotbed>,
    /// The last lines of the log.
    pub log: VecDeque<Line>,
    /// The world, for the plan.
    pub world: Plan,
}

/// What an observer in the field sees.
#[derive(Debug, Default)]
pub struct Plan {
    /// Where the barrel points, radians, positive left.
    pub azimuth: f64,
    /// Whether the barrel is out.
    pub deployed: bool,
    /// Where the water lands.
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

    /// Takes over the states of an answer to GetStatus.
    pub fn learn(&mut self, answers: &[AnswerBuf]) {
        let states = answers.iter().filter(|answer| answer.status().is_success());
        self.states.extend(states.map(|answer| (answer.from(), answer.clone())));
    }

    /// The flags of a subsystem.
    pub fn flags(&self, who: SubsystemId) -> u32 {
        let answer = self.states.get(&who).and_then(|answer| answer.decode().ok());
        answer.and_then(|answer| answer.data.flags_bits()).unwrap_or(0)
    }

    /// Whether Deployer has all of these flags.
    pub fn deployer_is(&self, flags: DeployerFlags) -> bool {
        DeployerFlags::from_bits_retain(self.flags(SubsystemId::DEPLOYER)).contains(flags)
    }

    /// The position of a drive.
    pub fn position(&self, who: SubsystemId) -> Option<i16> {
        match self.states.get(&who)?.decode().ok()?.data {
            Reply::Drive(status) => Some(status.position),
            Reply::Deployer(status) => Some(status.position),
            _ => None,
        }
    }
}

/// Shows the scene to somebody.
pub trait View {
    /// A new line of the log.
    fn line(&mut self, line: &Line) -> Result<(), Failure>;
    /// The scene has changed.
    fn draw(&mut self, scene: &Scene) -> Result<(), Failure>;
    /// Whether the viewer wants to end it.
    fn wants_to_leave(&mut self) -> bool {
        false
    }
    /// The end; `to_the_end` when the script came to its end.
    fn close(&mut self, scene: &Scene, to_the_end: bool) -> Result<(), Failure>;
}

/// Nobody watches.
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
