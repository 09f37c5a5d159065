//! The medium between this side and the monitors: addresses, framing, role on a bus, echo.

use std::time::Duration;

use lafet_proto::bus;

/// Longer than a bus controller is ever silent: one without a device to ask transmits every 2.5 s.
pub const CONTROLLER_PAUSE: Duration = Duration::from_secs(3);

/// Bus addresses (observed): monitors 1…127, the controller 128, consoles 129…254.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Addresses {
    /// The monitor, `addr=`.
    pub monitor: u8,
    /// This side, `src=`.
    pub source: u8,
}

impl Default for Addresses {
    fn default() -> Self {
        Self { monitor: *bus::MONITORS.start(), source: *bus::CONSOLES.start() }
    }
}

/// Contents of a TCP connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Framing {
    /// Link frames, as on every other medium.
    #[default]
    Link,
    /// §C/3 Bare records, one monitor for each connection.
    Records,
}

/// Role of a client on its bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Role {
    /// The only client of its monitors: transmits at any time.
    #[default]
    Direct,
    /// A console on a bus with a controller (observed): transmits when it has access.
    Active,
}

/// Handling of bytes that come back because the receiver hears its own sender.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Echo {
    /// No echo.
    #[default]
    Off,
    /// The echo is removed.
    Strip,
    /// The echo is removed, and compared with the sent bytes: a difference is a collision.
    Verify,
}
