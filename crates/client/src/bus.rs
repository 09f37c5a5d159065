//! A bus with a controller (observed; what is not is ours): who may speak when.
//!
//! Monitors speak when they are asked. Consoles, the "active" devices, speak one frame each time the
//! controller (address 128) grants access. [`Controller`] is the controller without I/O: bytes and
//! time in, frames out; [`Gateway`] lends programs its turns, and [`Driver`] runs both on real links.
//! A console is a client in the role `active` ([`crate::Role::Active`]), which waits for grants.
//!
//! ```text
//! console     ◀── AccessGranted ── controller      its turn
//! console     ── its one frame ──▶ monitor         on one line the monitor hears it by itself;
//! console     ◀────── answer ───── monitor         on two lines the controller passes both on
//! console     ── empty frame ────▶ controller      nothing to say: the next one's turn (ours)
//! ```

mod config;
mod controller;
#[cfg(feature = "client")]
mod driver;
mod gateway;
mod journal;
mod roster;

pub use config::{ControllerConfig, Port, Ports, Repeat};
pub use controller::{BusStats, Controller, Transmit};
#[cfg(feature = "client")]
pub use driver::{Driver, DriverConfig, Event};
pub use gateway::{Gateway, LENT, PROGRAMS_MAX};
pub use journal::{Entry, Journal};
pub use roster::{Change, Roster};

use lafet_proto::RequestId;
use lafet_proto::bus::CONTROLLER;
use lafet_proto::link::Check;
use lafet_proto::record::Records;

/// What the controller wants of a console.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Word {
    /// It may send one frame; if it has none, the empty one, so that the line is not idle.
    Granted,
    /// It shall say that it is there, with the empty frame.
    Probed,
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
