//! What plugs report of clients that try again and again: seldom, and openings that are refused without a
//! question to the monitor in the audit log.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_proto::Request;
use serde::Serialize;

use super::orders::valve_of;
use super::refusal::Refusal;
use super::seat::PlugSeat;
use crate::command::request::MonitorRequest;
use crate::sync::lock;

/// What happens again and again is reported once in this time.
const EACH: Duration = Duration::from_secs(10);

/// When something was reported last.
#[derive(Clone, Debug, Default)]
pub struct Seldom(Arc<Mutex<Option<Duration>>>);

impl Seldom {
    /// Whether it is time to report it; if so, it counts as reported.
    pub fn is_due(&self, now: Duration) -> bool {
        let mut last = lock(&self.0);
        let due = last.is_none_or(|at| now.saturating_sub(at) >= EACH);
        if due {
            *last = Some(now);
        }
        due
    }
}

/// What is reported of a client, however often it connects.
#[derive(Clone, Debug, Default)]
pub struct Reports {
    /// When the loss of its sign of life was reported.
    pub lost: Seldom,
    /// Its openings that were refused.
    pub refused: Arc<Noted>,
}

/// The same by the names of the configuration, which are few.
#[derive(Debug, Default)]
pub struct ByName(Mutex<BTreeMap<String, Reports>>);

impl ByName {
    /// Those of a client.
    pub fn of(&self, name: &str) -> Reports {
        lock(&self.0).entry(name.to_owned()).or_default().clone()
    }
}

/// Refused openings of a client.
#[derive(Debug, Default)]
pub struct Noted {
    /// Since the latest entry.
    count: AtomicU32,
    entries: Seldom,
}

/// Details of an entry.
#[derive(Debug, Serialize)]
struct RefusedDetails {
    /// Number of the refusal.
    code: u16,
    text: String,
    /// With those since the entry before it.
    count: u32,
}

impl Noted {
    /// Notes that an opening was refused.
    pub fn refused(&self, seat: PlugSeat<'_>, monitor: &str, valve: u16, why: (Refusal, String)) {
        let Ok(request) = MonitorRequest::new(&Request::open(valve_of(valve))) else { return };
        self.count.fetch_add(1, Ordering::Relaxed);
        if !self.entries.is_due(seat.hub.now()) {
            return;
        }
        let (code, text) = (why.0.number(), why.1);
        let details = RefusedDetails { code, text, count: self.count.swap(0, Ordering::Relaxed) };
        let record = seat.hub.record(seat.caller, monitor, request.text(), "not allowed");
        drop(seat.hub.audit().note(record.with(&details).about(&request.act())));
    }
}
