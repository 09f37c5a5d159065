//! A bus with a controller (observed; the rest is ours): which device may transmit when.
//!
//! Monitors transmit only answers. Consoles, the "active" devices, transmit one frame each time the
//! controller (address 128) grants access. [`Controller`] is the controller without I/O: bytes and
//! time in, frames out; [`Gateway`] lets programs use its turns, and [`Driver`] runs both on real
//! links. A console is a client in the role `active` ([`crate::Role::Active`]), which waits for
//! grants.
//!
//! ```text
//! console     ◀── AccessGranted ── controller      the console's turn
//! console     ── its one frame ──▶ monitor         on one line the monitor receives it directly;
//! console     ◀────── answer ───── monitor         on two lines the controller forwards both
//! console     ── empty frame ────▶ controller      nothing to send: the next console's turn (ours)
//! ```

mod config;
mod controller;
#[cfg(feature = "client")]
mod driver;
mod gateway;
mod journal;
mod kind;
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

/// Frames of the controller to a console that have a meaning of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Word {
    /// The console may send one frame; the empty frame if it has none, so that the line is not
    /// idle.
    Granted,
    /// The console answers the presence probe with the empty frame.
    Probed,
}

/// The empty frame to the controller.
pub(crate) fn nothing_from(address: u8) -> Vec<u8> {
    controller::wire(Check::Crc16, CONTROLLER, address, &[])
}

/// The meaning of a frame that a console has received.
pub(crate) fn wanted(payload: &[u8]) -> Option<Word> {
    match Records::new(payload).next() {
        None => Some(Word::Probed),
        Some(Ok(record)) if record.request == RequestId::ACCESS_GRANTED => Some(Word::Granted),
        Some(_) => None,
    }
}
