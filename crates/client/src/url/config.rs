//! How a session behaves on the way that a URL names.

use std::time::Duration;

use super::{Endpoint, Manner};
use crate::session::Config;

/// How long a serial line is listened to before the first frame of a direct client: a controller
/// with a console on its bus speaks within this time.
const LISTEN: Duration = Duration::from_millis(100);

impl Config {
    /// The same for the way that an endpoint names: addresses, framing and the kind of line are its.
    pub fn of(self, endpoint: &Endpoint) -> Self {
        let Manner { check, role, late } = endpoint.manner();
        let (addresses, framing) = (endpoint.addresses(), endpoint.framing());
        let (echo, turnaround, listen) = match endpoint {
            Endpoint::Serial { line, .. } => (line.echo, line.turnaround, self.listen.max(LISTEN)),
            _ => (self.echo, self.turnaround, self.listen),
        };
        let in_memory = matches!(endpoint, Endpoint::Sim { .. });
        let outlives = late != Some(Duration::ZERO) && !in_memory;
        let drain_bound = late.filter(|late| !late.is_zero()).unwrap_or(self.drain_bound);
        let kind = Self { check, role, addresses, framing, outlives, drain_bound, ..self };
        // Datagrams may arrive twice.
        let duplicates = self.duplicates || matches!(endpoint, Endpoint::Udp { .. });
        Self { echo, turnaround, listen, duplicates, ..kind }
    }
}
