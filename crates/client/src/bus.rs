//! A bus with a controller (observed; what is not is ours): who may speak when.
//!
//! Monitors speak when they are asked. Consoles, the "active" devices, speak one frame each time the
//! controller (address 128) grants access. [`Controller`] is the controller without I/O: bytes and
//! time in, frames out. A console is a client whose link waits for grants
//! ([`crate::session::line::Access::Granted`]); [`Active`] finds them among the bytes of the line.
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
pub use journal::{Entry, Journal};
pub use roster::{Change, Roster};

use lafet_proto::RequestId;
use lafet_proto::bus::CONTROLLER;
use lafet_proto::link::{Check, Decoder};
use lafet_proto::record::Records;

/// What the controller wants of a console.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Word {
    /// It may send one frame; if it has none, [`Active::nothing`], so that the line is not idle.
    Granted,
    /// It shall say that it is there: [`Active::nothing`].
    Probed,
}

/// A console's ear on a line with a controller.
#[derive(Debug)]
pub struct Active {
    decoder: Box<Decoder>,
    address: u8,
}

impl Active {
    /// For the console at this address.
    pub fn new(address: u8) -> Self {
        Self { decoder: Box::default(), address }
    }

    /// Takes bytes; what the controller wants, if nothing has followed it yet: a grant is for now.
    pub fn heard(&mut self, bytes: &[u8]) -> Option<Word> {
        let mut word = None;
        let mut rest = bytes;
        while !rest.is_empty() {
            let (taken, frame) = self.decoder.push_slice(rest);
            rest = &rest[taken..];
            if let Some(frame) = frame {
                let ours = (frame.dst, frame.src) == (self.address, CONTROLLER);
                word = if ours { wanted(frame.payload) } else { None };
            }
        }
        word
    }

    /// The empty frame to the controller.
    pub fn nothing(&self) -> Vec<u8> {
        nothing_from(self.address)
    }
}

/// The empty frame to the controller.
pub(crate) fn nothing_from(address: u8) -> Vec<u8> {
    controller::wire(Check::Crc16, CONTROLLER, address, &[])
}

/// What the controller wants with a frame to a console.
pub(crate) fn wanted(payload: &[u8]) -> Option<Word> {
    match Records::new(payload).next() {
        None => Some(Word::Probed),
        Some(Ok(record)) if record.request == RequestId::ACCESS_GRANTED => Some(Word::Granted),
        Some(_) => None,
    }
}
