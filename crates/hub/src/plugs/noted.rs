//! Openings that a plug refuses without a question to the monitor, in the audit log.

use std::sync::Mutex;
use std::time::Duration;

use lafet_proto::Request;
use serde::Serialize;

use super::orders::valve_of;
use super::refusal::Refusal;
use super::seat::PlugSeat;
use crate::command::request::MonitorRequest;
use crate::sync::lock;

/// A client that tries again and again has an entry in this time, with the number of its tries.
const EACH: Duration = Duration::from_secs(10);

/// Refused openings of a session.
#[derive(Debug, Default)]
pub struct Noted(Mutex<Latest>);

#[derive(Debug, Default)]
struct Latest {
    /// The latest entry.
    at: Option<Duration>,
    /// Since that entry.
    count: u32,
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
        let now = seat.hub.now();
        let mut latest = lock(&self.0);
        latest.count = latest.count.saturating_add(1);
        if latest.at.is_some_and(|at| now.saturating_sub(at) < EACH) {
            return;
        }
        let (code, text) = (why.0.number(), why.1);
        let details = RefusedDetails { code, text, count: latest.count };
        *latest = Latest { at: Some(now), count: 0 };
        let record = seat.hub.record(seat.caller, monitor, request.text(), "not allowed");
        drop(seat.hub.audit().note(record.with(&details).about(&request.act())));
    }
}
