//! §3.3.9 «Флаги состояния ExternalConn, Radio»: an interface that controls the monitor.

use crate::time::{Millis, Timer};
use lafet_proto::flags::ConnFlags;
use lafet_proto::status::ConnStatus;

/// The interface a frame came in by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Wired: RS-485, Ethernet.
    ExternalConn,
    /// Radio modem.
    Radio,
}

/// An interface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conn {
    control: Timer,
}

impl Conn {
    /// §3.3.9/1 A client has tried to control the monitor through this interface.
    pub(crate) fn note_control(&mut self, now: Millis, timeout_ms: i32) {
        self.control.start(now, timeout_ms.unsigned_abs());
    }

    pub(crate) fn step(&mut self, now: Millis) {
        self.control.poll(now);
    }

    /// Flags but the common ones of the configuration.
    pub(crate) fn flags(&self) -> ConnFlags {
        let mut flags = ConnFlags::empty();
        flags.set(ConnFlags::CONN_LOST, !self.control.is_running());
        flags
    }

    /// §3.3 ConnStatus.
    pub(crate) fn status(&self) -> ConnStatus {
        ConnStatus { flags: self.flags() }
    }
}
