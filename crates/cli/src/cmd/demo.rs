//! `lafet demo`: a simulated monitor finds a fire and puts it out.

use std::path::PathBuf;

use clap::Args;
use lafet_sim::fire::FireSpec;

use crate::demo::{self, Options};
use crate::failure::Outcome;
use crate::out::Out;
use crate::simulator;

/// `lafet demo`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet demo\n  \
                        lafet demo --plain --speed 0 --fire az=-40,range=30,size=2\n  \
                        lafet demo --seed 3 --trace trace.txt")]
pub struct DemoArgs {
    /// Everything random follows from this number (default 7)
    #[arg(long, value_name = "N", default_value_t = 7)]
    seed: u64,
    /// Simulated time runs this many times as fast as the clock; 0 is as fast as possible
    /// (default 1)
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        value_parser = simulator::speed_or_zero
    )]
    speed: f64,
    /// Lines of a log instead of the picture
    #[arg(long)]
    plain: bool,
    /// A fire: az=DEGREES,range=METRES[,size=METRES]; left is positive. May be repeated
    #[arg(long, value_name = "FIRE", value_parser = simulator::fire)]
    fire: Vec<FireSpec>,
    /// Write what happens into this file; with the same seed it is the same byte for byte
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Write the picture of one moment into this SVG file, and show nothing
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// The moment of --picture, simulated seconds (default 60)
    #[arg(long, value_name = "SECONDS", default_value_t = 60, requires = "picture")]
    picture_at: u64,
}

/// Plays it and tells what came out.
pub async fn run(args: DemoArgs, out: &mut Out) -> Outcome {
    let summary = demo::run(Options {
        seed: args.seed,
        speed: args.speed,
        plain: args.plain,
        silent: out.json(),
        fires: args.fire,
        trace: args.trace,
        picture: args.picture.map(|path| (path, args.picture_at.saturating_mul(1000))),
    })
    .await?;
    out.show(format!("\n{}", summary.text()), || summary.json())
}
