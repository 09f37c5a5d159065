//! What has been granted, and is in force until it is used up, stopped or replaced.

use lafet_device::cause::{Asked, Cause, Program};
use lafet_device::image::ValveOutput;

/// Whether the monitor is locked out, as far as the ledger can know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lock {
    /// No.
    Off,
    /// Yes.
    On,
    /// The memory could not tell; the monitor's own word counts.
    Unknown,
}

/// A Move that was accepted.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    /// The request.
    pub asked: Asked,
    /// Where to.
    pub destination: i32,
    /// Where to, inside the limits at that time.
    pub target: i32,
    /// When.
    pub at_ms: u64,
    /// MoveTimeout at that time, ms.
    pub timeout_ms: u32,
    /// When MoveHold was set last for it, and for how long, ms (§D/4).
    pub hold: Option<(u64, u32)>,
    /// Limits were off at that time.
    pub limitless: bool,
    /// §3.17 Up/left (true) or down/right until stopped: a direct drive without limits.
    pub runs: Option<bool>,
}

/// A program that a request has started.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// What.
    pub program: Program,
    /// By which request.
    pub asked: Asked,
    /// When.
    pub at_ms: u64,
    /// Replaced by another start at this moment.
    pub replaced_ms: Option<u64>,
    /// TravelTime of Deployer at the start, ms.
    pub travel_ms: u32,
}

/// A right to drive a valve.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    /// Which way.
    pub output: ValveOutput,
    /// By whom.
    pub cause: Cause,
    /// Since when.
    pub at_ms: u64,
    /// TravelTime at that time, ms.
    pub travel_ms: u32,
}
