//! A simulated monitor on the network: any number of clients, one simulation.
//!
//! Everything runs on one thread. A frame is handled at once, at the simulated time that [`Paced`]
//! or [`pace()`] has reached; no connection waits for another.

mod connections;
mod datagram;
mod listener;
mod pace;
#[cfg(unix)]
mod pty;
mod radio;
mod site;
mod stream;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lafet_device::Source;
use lafet_sim::sim::Sim;

pub use listener::Listen;
pub use pace::{Paced, pace};
pub use radio::Air;
pub use site::SharedSite;
pub use stream::{Habits, Wire, serve_stream};

/// Handles the frames of a connection: one simulated monitor, or those of a site.
pub trait Bus: Clone + Send + Sync + 'static {
    /// Passes bytes of a stream to all monitors on it; returns their answers.
    fn receive(&self, wire: &mut Wire, bytes: &[u8]) -> Vec<u8>;

    /// Passes a datagram to all monitors; returns the answer, if there is one.
    fn datagram(&self, source: Source, bytes: &[u8]) -> Option<Vec<u8>>;

    /// Advances simulated time.
    fn advance_ms(&self, ms: u64);
}

/// The simulation shared by all connections.
#[derive(Clone)]
pub struct Shared(Arc<Mutex<Sim>>);

impl Shared {
    /// Shares a simulation.
    pub fn new(sim: Sim) -> Self {
        Self(Arc::new(Mutex::new(sim)))
    }

    /// Locks the simulation. Do not hold the guard across an await.
    pub fn lock(&self) -> MutexGuard<'_, Sim> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Bus for Shared {
    fn receive(&self, wire: &mut Wire, bytes: &[u8]) -> Vec<u8> {
        wire.receive(0, &mut self.lock(), bytes)
    }

    fn datagram(&self, source: Source, bytes: &[u8]) -> Option<Vec<u8>> {
        self.lock().datagram(source, bytes)
    }

    fn advance_ms(&self, ms: u64) {
        self.lock().advance_ms(ms);
    }
}
