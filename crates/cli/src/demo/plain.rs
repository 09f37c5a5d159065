//! The demonstration as log lines.

use std::io::{self, Write};

use super::scene::{Kind, Line, Scene, View};
use crate::describe::values;
use crate::failure::Failure;
use lafet_proto::SubsystemId;

/// Simulated time between two lines about the state, ms.
const STATE_MS: u64 = 5000;

/// A view that prints lines to standard output.
pub struct Plain {
    phase: &'static str,
    next_state_ms: u64,
}

impl Plain {
    /// A view that has printed nothing yet.
    pub const fn new() -> Self {
        Self { phase: "", next_state_ms: STATE_MS }
    }
}

impl View for Plain {
    fn line(&mut self, line: &Line) -> Result<(), Failure> {
        let Line { at_ms, kind, text } = line;
        let mark = kind.mark();
        Ok(writeln!(io::stdout(), "{:7.2} {mark} {text}", *at_ms as f64 / 1000.0)?)
    }

    fn draw(&mut self, scene: &Scene) -> Result<(), Failure> {
        if scene.phase != self.phase {
            self.phase = scene.phase;
            writeln!(io::stdout(), "{:7.2} == {}", scene.now_ms as f64 / 1000.0, scene.phase)?;
        }
        if scene.now_ms < self.next_state_ms {
            return Ok(());
        }
        self.next_state_ms = scene.now_ms + STATE_MS;
        let state = |who: SubsystemId| {
            let answer = scene.states.get(&who)?.decode().ok()?;
            Some(format!("{who} {}", values(&answer)))
        };
        let who = [
            SubsystemId::DEPLOYER,
            SubsystemId::HORIZONTAL,
            SubsystemId::VERTICAL,
            SubsystemId::GENERAL,
        ];
        let text: Vec<String> = who.into_iter().filter_map(state).collect();
        self.line(&Line { at_ms: scene.now_ms, kind: Kind::World, text: text.join(" | ") })
    }

    fn close(&mut self, _: &Scene, _: bool) -> Result<(), Failure> {
        Ok(io::stdout().flush()?)
    }
}
