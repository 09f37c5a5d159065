//! What lies between this side and the monitors: addresses, framing, role on a bus, echo.

use lafet_proto::bus;

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

/// What travels over a TCP connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Framing {
    /// Link frames, as on every other medium.
    #[default]
    Link,
    /// §C/3 Bare records, one monitor a connection.
    Records,
}

/// What a client is on its bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Role {
    /// Alone with its monitors: it speaks when it wants to.
    #[default]
    Direct,
    /// A console on a bus with a controller (observed): it speaks when it has access.
    Active,
}

/// What is done about bytes that come back because the receiver hears its own sender.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Echo {
    /// None comes.
    #[default]
    Off,
    /// It comes and is taken away.
    Strip,
    /// It comes, is taken away, and has to be what was sent: if not, two speak at once.
    Verify,
}
