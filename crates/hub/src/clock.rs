//! The one clock of the hub: what is logged, and when sessions and shelvings end.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

/// Milliseconds since 1970.
#[derive(Clone, Debug, Default)]
pub enum Clock {
    /// The system's.
    #[default]
    System,
    /// One that is set by hand, for tests.
    Manual(Arc<AtomicU64>),
}

impl Clock {
    /// Now, ms since 1970. It may jump; nothing that moves a monitor depends on it.
    #[expect(clippy::disallowed_methods, reason = "logs, sessions and alarms bear the date")]
    pub fn now_ms(&self) -> u64 {
        match self {
            Self::System => SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .map_or(0, |since| u64::try_from(since.as_millis()).unwrap_or(u64::MAX)),
            Self::Manual(now_ms) => now_ms.load(Ordering::Relaxed),
        }
    }
}
