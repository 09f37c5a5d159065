//! How long a request was under way: what a stalled network delivers is not carried out.
//!
//! A client says when it has sent a request, by two clocks. Its own (`t`) is compared with its quickest request:
//! exact, but the first one has nothing to be compared with, nor have those that a stall delivers together.
//! That of the hub (`up_ms`), which it knows from what the hub has sent, is behind by the time that took: a request is
//! never taken for younger than it is.
//!
//! Both stand still while the machine of the hub sleeps, the first one if its client sleeps with it. The date goes on: by
//! how much it is ahead afterwards, what was sent before is older.

use std::time::Duration;

use lafet_proto::SubsystemId;
use lafet_texts::{Text as _, hub as text};
use tokio::time::Instant;

use super::request::MonitorRequest;
use crate::error::ApiError;
use crate::hub::Hub;
use crate::monitor::station::Station;

/// A request that was under way for so much longer than the quickest one is not carried out.
const LATE: Duration = Duration::from_secs(1);
/// Nor one that may have been under way for so long: the console says by then that there is no answer.
const OLD: Duration = Duration::from_secs(2);
/// A client is ahead of the hub's time by less than this: what is rounded, and clocks that run apart.
const AHEAD_MS: f64 = 200.0;

impl Hub {
    /// For how long something was under way at most that was sent so long after the start of the hub.
    ///
    /// # Errors
    ///
    /// 400: that time has not come yet.
    fn at_most(&self, up_ms: Option<f64>) -> Result<Option<Duration>, ApiError> {
        let Some(up_ms) = up_ms else { return Ok(None) };
        let most_ms = self.up_ms() as f64 - up_ms;
        if most_ms.is_nan() || most_ms < -(OLD.as_millis() as f64) {
            return Err(ApiError::bad_request(text::SentInFuture.words()));
        }
        // A client is never ahead of this time: the one that it knows was when the hub stood still, asleep or paused.
        if most_ms < -AHEAD_MS {
            return Ok(Some(Duration::MAX));
        }
        // More than a duration has room for was under way for ever.
        let most = Duration::try_from_secs_f64(most_ms.max(0.0) / 1000.0);
        Ok(Some(self.age(most.unwrap_or(Duration::MAX))))
    }

    /// Whether a request is still to be carried out that was under way for so much longer than the quickest one of its
    /// client, and was sent so long after the start of the hub: not if it is late, and not after a Stop, Close or
    /// Lockout that undoes it and came while it was under way.
    ///
    /// # Errors
    ///
    /// 409, `late` or `void`; 400: it says that it was sent in the future.
    pub fn in_time(
        &self,
        station: &Station,
        request: &MonitorRequest,
        longer: Option<Duration>,
        up_ms: Option<f64>,
    ) -> Result<(), ApiError> {
        let most = self.at_most(up_ms)?;
        if longer.is_some_and(|it| it >= LATE) || most.is_some_and(|it| it >= OLD) {
            return Err(ApiError::late());
        }
        match longer.max(most) {
            Some(longest) if self.is_undone(station, request, longest) => Err(ApiError::void()),
            _ => Ok(()),
        }
    }

    /// Whether a heartbeat is late: its control may have been released meanwhile, or a Stop has come.
    ///
    /// # Errors
    ///
    /// 400: it says that it was sent in the future.
    pub fn is_late_beat(
        &self,
        station: &Station,
        drive: SubsystemId,
        up_ms: Option<f64>,
    ) -> Result<bool, ApiError> {
        let Some(most) = self.at_most(up_ms)? else { return Ok(false) };
        let undone = |request: MonitorRequest| self.is_undone(station, &request, most);
        Ok(most >= LATE || MonitorRequest::moving(drive).is_ok_and(undone))
    }

    /// When something was sent at the earliest, so long after the start of the hub: not if it is late.
    ///
    /// # Errors
    ///
    /// 409, `late`; 400: it says that it was sent in the future.
    pub fn sent_at(&self, up_ms: Option<f64>) -> Result<Option<Instant>, ApiError> {
        match self.at_most(up_ms)? {
            Some(most) if most >= OLD => Err(ApiError::late()),
            most => Ok(most.map(|most| self.ago(most))),
        }
    }

    fn ago(&self, time: Duration) -> Instant {
        Instant::now().checked_sub(time).unwrap_or(self.start())
    }

    /// Whether something has come that undoes a request which was under way for so long.
    fn is_undone(&self, station: &Station, request: &MonitorRequest, longest: Duration) -> bool {
        station.is_undone_since(request, self.ago(longest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Clock;
    use crate::clock::ManualTime;

    /// What is sent is known to be older, or to be sent now; a client that is ahead of the hub has known its time from before
    /// it stood still.
    #[tokio::test]
    async fn a_client_that_is_ahead_sent_it_before_the_hub_stood_still() {
        let (hub, _) = Hub::of_one(None);
        let sent = |ahead_ms: f64| hub.sent_at(Some(hub.up_ms() as f64 + ahead_ms));
        assert!(sent(0.0).is_ok_and(|at| at.is_some()) && sent(100.0).is_ok());
        for ahead_ms in [300.0, 1000.0, 1900.0] {
            assert_eq!(sent(ahead_ms).unwrap_err().code, "late", "{ahead_ms}");
        }
        for ahead_ms in [2500.0, f64::INFINITY, f64::NAN] {
            assert_eq!(sent(ahead_ms).unwrap_err().code, "bad_request", "{ahead_ms}");
        }
        assert_eq!(hub.sent_at(None).unwrap(), None);
    }

    /// Assumed: hub and client are on one machine, which sleeps while a request is under way.
    #[tokio::test]
    async fn what_was_sent_before_the_machine_slept_is_late() {
        let time = ManualTime::at(1_000_000);
        let (hub, station) = Hub::of_one_at(None, Clock::Manual(time.clone()));
        let open = MonitorRequest::parse("Open Valve1").unwrap();
        let code = |t: Option<Duration>, up_ms: Option<f64>| {
            hub.in_time(&station, &open, t, up_ms).err().map(|error| error.code)
        };
        let now = || Some(hub.up_ms() as f64);
        let quick = |hub: &Hub| Some(hub.age(Duration::ZERO));
        assert_eq!([code(quick(&hub), None), code(None, now())], [None; 2]);
        time.set_date(1_300_000);
        assert_eq!(code(quick(&hub), None), Some("late"));
        assert_eq!(code(None, now()), Some("late"));
        assert!(hub.is_late_beat(&station, SubsystemId::VERTICAL, now()).unwrap());
        assert_eq!(code(None, None), None, "of which nothing is known");
    }
}
