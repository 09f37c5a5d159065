//! A bus with a controller (observed; what is not is ours): who may speak when.
//!
//! Monitors speak when they are asked. Consoles, the "active" devices, speak one frame each time the
//! controller (address 128) grants access. [`Controller`] is the controller without I/O: bytes and
//! time in, frames out. A console is a client whose link waits for grants; [`Grants`] finds them
//! among the bytes of the line.
//!
//! ```text
//! console     ◀── AccessGranted ── controller      its turn
//! console     ── its one frame ──▶ monitor         on one line the monitor hears it by itself;
//! console     ◀────── answer ───── monitor         on two lines the controller passes both on
//! console     ── empty frame ────▶ controller      nothing to say: the next one's turn (ours)
//! ```

mod controller;
mod journal;
mod roster;

pub use controller::{BusStats, Controller, ControllerConfig, Port, Ports, Transmit};
pub use journal::{Journal, Line};
pub use roster::{Change, Roster};

use lafet_proto::RequestId;
use lafet_proto::bus::CONTROLLER;
use lafet_proto::link::Decoder;
use lafet_proto::record::Records;

/// Finds the grants for one console among the bytes of a line.
#[derive(Debug)]
pub struct Grants {
    decoder: Box<Decoder>,
    address: u8,
}

impl Grants {
    /// For the console at this address.
    pub fn new(address: u8) -> Self {
        Self { decoder: Box::default(), address }
    }

    /// Takes bytes; whether they end with a grant that nothing has followed yet.
    pub fn heard(&mut self, bytes: &[u8]) -> bool {
        let mut granted = false;
        let mut rest = bytes;
        while !rest.is_empty() {
            let (taken, frame) = self.decoder.push_slice(rest);
            rest = &rest[taken..];
            if let Some(frame) = frame {
                let first = Records::new(frame.payload).next();
                granted = (frame.dst, frame.src) == (self.address, CONTROLLER)
                    && matches!(first, Some(Ok(r)) if r.request == RequestId::ACCESS_GRANTED);
            }
        }
        granted
    }
}
