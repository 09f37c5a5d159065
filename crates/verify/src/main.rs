//! `lafet-verify`: runs the checks that take long or print tables.

mod commands;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
#[cfg(unix)]
use commands::{chip, load};
use commands::{faults, model, noise, pace, physics, replay, swarm, years};

/// Check the device and the simulator
#[derive(Parser)]
#[command(name = "lafet-verify")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compare a firmware on the emulated chip with the same monitor on the host
    #[cfg(unix)]
    Chip(chip::Plan),
    /// Print how each flag and status is reached, and what detects which fault
    Faults,
    /// Count the instructions of a firmware on the emulated chip while it extinguishes a fire
    #[cfg(unix)]
    Load(load::Options),
    /// Check the interlock on every state that a request, a fault or time can lead to
    Model(model::Options),
    /// Count the frames that noise on a line forges
    Noise(noise::Options),
    /// Measure how much faster than real time a simulated monitor runs
    Pace,
    /// Print the tables of docs/physics.md
    Physics,
    /// Show a life from the swarm, step by step
    Replay(replay::Options),
    /// Run random lives of simulated monitors; every change of an output must be explained
    Swarm(swarm::Options),
    /// Run years in the life of a monitor
    Years(years::Options),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        #[cfg(unix)]
        Command::Chip(plan) => chip::run(&plan),
        Command::Faults => faults::run(),
        #[cfg(unix)]
        Command::Load(options) => load::run(&options),
        Command::Model(options) => model::run(&options),
        Command::Noise(options) => noise::run(&options),
        Command::Pace => pace::run(),
        Command::Physics => physics::run(),
        Command::Replay(options) => replay::run(&options),
        Command::Swarm(options) => swarm::run(&options),
        Command::Years(options) => years::run(&options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
