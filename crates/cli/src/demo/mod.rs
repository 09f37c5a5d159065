//! The demonstration: a monitor finds a fire and puts it out, over real frames on a TCP connection.
//!
//! **Time.** The simulated monitor listens on a port of the loopback, and lafet-client talks to it
//! as to any other. Simulated time moves in lock-step with that talk: it stands still while a
//! request and its answers are under way, and goes on, 50 ms at a time, only when the script lets
//! it ([`stage::Stage::pass`]). What the monitor does therefore depends on seed and fires alone,
//! and the trace is the same byte for byte, however fast the computer is. `--speed` only decides
//! how long the script waits by the clock between two such steps; 0 does not wait at all.
//!
//! **What the operator knows.** The script asks the monitor, and it looks out of the window: that a
//! fire is lit and that it is out is taken from the simulated world, everything else from answers.

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

/// What a demonstration is made of.
#[derive(Clone, Debug)]
pub struct Options {
    /// Everything random follows from it, the place of the fire too.
    pub seed: u64,
    /// Simulated time by the clock; 0 is as fast as possible.
    pub speed: f64,
    /// Lines instead of the picture.
    pub plain: bool,
    /// Nothing but the summary.
    pub silent: bool,
    /// The fires; without any the seed chooses one.
    pub fires: Vec<FireSpec>,
    /// Where the trace goes.
    pub trace: Option<PathBuf>,
    /// Where the picture of one moment goes, and which: simulated ms.
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
    // The trace is kept whatever happened, and what happened counts more than the trace.
    let closed = stage.close(played.is_ok()).await;
    played?;
    closed
}
