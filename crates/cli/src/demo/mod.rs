//! The demonstration: a monitor finds a fire and puts it out, over real frames on a TCP connection.
//!
//! **Time.** The simulated monitor listens on a port of the loopback, and lafet-client connects to
//! it as to any other. Simulated time moves in lock-step with the exchange: it does not advance
//! while a request and its answers are under way, and advances, 50 ms at a time, only when the
//! script calls [`stage::Stage::pass`]. What the monitor does therefore depends on seed and fires
//! alone, and the trace is the same byte for byte, however fast the computer is. `--speed` only
//! sets how long the script waits in real time between two such steps; 0 does not wait at all.
//!
//! **What the operator knows.** The script queries the monitor and observes the site: that a fire
//! is lit and that it is out is taken from the simulated world, everything else from answers.

mod drawing;
mod fires;
mod picture;
mod plain;
mod plan;
mod scene;
mod script;
mod stage;
mod summary;
mod trace;

use std::io::{self, IsTerminal};
use std::path::PathBuf;

use lafet_sim::fire::FireSpec;

use crate::failure::Failure;
use scene::View;
use stage::Stage;
pub use summary::Summary;

/// Settings of a demonstration.
#[derive(Clone, Debug)]
pub struct Options {
    /// Seed of everything random, including the place of the fire.
    pub seed: u64,
    /// Simulated seconds per second of real time; 0 is as fast as possible.
    pub speed: f64,
    /// Log lines instead of the picture.
    pub plain: bool,
    /// No output but the summary.
    pub silent: bool,
    /// The fires; if empty, the seed chooses one.
    pub fires: Vec<FireSpec>,
    /// File for the trace.
    pub trace: Option<PathBuf>,
    /// File for the picture of one moment, and that moment, simulated ms.
    pub picture: Option<(PathBuf, u64)>,
}

/// Runs the demonstration from standby to standby.
pub async fn run(options: Options) -> Result<Summary, Failure> {
    let view: Box<dyn View> = match () {
        () if let Some((path, at_ms)) = &options.picture => {
            Box::new(drawing::Drawing::new(path.clone(), *at_ms))
        }
        () if options.silent => Box::new(scene::Nobody),
        () if options.plain || !io::stdout().is_terminal() => Box::new(plain::Plain::new()),
        () => Box::new(picture::Picture::open()?),
    };
    let fires = match options.fires.is_empty() {
        true => vec![fires::of_seed(options.seed)],
        false => options.fires.clone(),
    };
    let mut stage = Stage::open(&options, &fires, view).await?;
    let played = script::play(&mut stage, &fires).await;
    // The trace is closed in any case; an error of the run takes precedence over one of the trace.
    let closed = stage.close(played.is_ok()).await;
    played?;
    closed
}
