//! Configuration of a session for an endpoint.

use std::time::Duration;

use super::{Behaviour, Endpoint, SerialLine};
use crate::session::Config;

/// Time for which a direct client listens on a serial line before its first frame: a controller
/// with a console on its bus transmits within this time.
const LISTEN: Duration = Duration::from_millis(100);

impl Config {
    /// This configuration for an endpoint: addresses, framing and the kind of line are taken from
    /// it.
    pub fn of(self, endpoint: &Endpoint) -> Self {
        let Behaviour { check, role, late } = endpoint.behaviour();
        let (addresses, framing) = (endpoint.addresses(), endpoint.framing());
        let (echo, turnaround, listen) = match endpoint {
            Endpoint::Serial { line, .. } => (line.echo, line.turnaround, self.listen.max(LISTEN)),
            _ => (self.echo, self.turnaround, self.listen),
        };
        let may_disturb =
            matches!(endpoint, Endpoint::Serial { line: SerialLine { insist: false, .. }, .. });
        let heed = self.heed && may_disturb;
        let in_memory = matches!(endpoint, Endpoint::Sim { .. });
        let outlives = late != Some(Duration::ZERO) && !in_memory;
        let drain_bound = late.filter(|late| !late.is_zero()).unwrap_or(self.drain_bound);
        let kind = Self { check, role, addresses, framing, outlives, drain_bound, ..self };
        // Datagrams may arrive twice.
        let duplicates = self.duplicates || matches!(endpoint, Endpoint::Udp { .. });
        Self { echo, turnaround, listen, heed, duplicates, ..kind }
    }
}
