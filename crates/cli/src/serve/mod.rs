//! A simulated monitor on the network: any number of clients, one simulation.
//!
//! Everything runs on one thread. A frame is handled at once, at the simulated time that
//! [`pace()`] has reached; nobody waits for anybody else's connection.

mod connections;
mod datagram;
mod listener;
mod pace;
#[cfg(unix)]
mod pty;
mod stream;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lafet_sim::sim::Sim;

pub use listener::Listen;
pub use pace::pace;
pub use stream::{Habits, Wire, serve_stream};

/// The simulation that all connections share.
#[derive(Clone)]
pub struct Shared(Arc<Mutex<Sim>>);

impl Shared {
    /// Shares a simulation.
    pub fn new(sim: Sim) -> Self {
        Self(Arc::new(Mutex::new(sim)))
    }

    /// The simulation. Do not keep it while waiting for anything.
    pub fn lock(&self) -> MutexGuard<'_, Sim> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
