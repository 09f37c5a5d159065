//! Swarm simulation: seeds × profiles × faults × requests, each step under the check of
//! [`crate::attribution`].
//!
//! A seed is a whole life of a monitor: what it is built of, what burns, the wind, the clock near
//! its wrap, what operators, adversaries, buttons, faults and power cuts do. The same seed gives
//! the same life, so a failure is replayed by its number: `cargo xtask replay SEED`. From
//! [`PAIRS_SEED`] on a seed is a short life with two faults, of which each pair has its own.

mod mission;
mod pairs;
mod plan;
mod requests;
mod tally;
mod watched;

pub use pairs::{PAIRS_SEED, pair, pairs};
pub use plan::setting;
pub use requests::frame;
pub use tally::Tally;
pub use watched::{Entry, Log, Wrong};

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::attribution::Violation;
use pairs::Pair;
use plan::Life;
use watched::Watched;

/// Virtual time of one seed, ms; the lives of pairs of faults are shorter.
pub const LIFE_MS: u64 = 300_000;

/// How a seed ended.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The seed.
    pub seed: u64,
    /// What was seen.
    pub tally: Tally,
    /// What must never happen; the life ends there.
    pub failure: Option<Violation>,
}

impl Outcome {
    /// What to tell about a failure: seed, step, explanation, and how to see it again.
    pub fn failure_text(&self) -> Option<String> {
        let Violation { at_ms, text, .. } = self.failure.as_ref()?;
        let (seed, step) = (self.seed, at_ms / lafet_sim::world::STEP_MS);
        let seconds = *at_ms as f64 / 1000.0;
        let from = (seconds - 5.0).max(0.0);
        Some(format!(
            "seed {seed}, step {step} ({seconds:.2} s): {text}\n  cargo xtask replay {seed} --from \
             {from:.0}"
        ))
    }
}

/// Lives one seed. A panic of the device is a failure like any other.
pub fn run(seed: u64, log: &mut dyn Log) -> Outcome {
    live(seed, None, log)
}

/// Lives one seed with a monitor that does something wrong: it must end in a failure.
pub fn run_wrong(seed: u64, wrong: &mut dyn Wrong) -> Outcome {
    live(seed, Some(wrong), &mut ())
}

fn live<'l>(seed: u64, wrong: Option<&'l mut dyn Wrong>, log: &'l mut dyn Log) -> Outcome {
    let mut watched = Watched::new(seed, wrong, log);
    let lived = catch_unwind(AssertUnwindSafe(|| match Pair::of(seed) {
        Some(mut pair) => pair.live(&mut watched),
        None => Life::new(seed).live(&mut watched),
    }));
    if lived.is_err() {
        watched.panicked();
    }
    let (tally, failure) = watched.end();
    Outcome { seed, tally, failure }
}
