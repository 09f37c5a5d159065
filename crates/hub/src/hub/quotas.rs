//! How many requests a user may make, and how long they are under way.

use std::collections::HashMap;
use std::sync::Mutex;
use std::time::Duration;

use super::{Caller, Hub};
use crate::access::{Bucket, Principal};
use crate::control::beats::Delay;
use crate::error::ApiError;
use crate::sync::lock;
use crate::zones::ZONES;

/// Requests of a user that change something: at once, and per second. Stop, Close and Lockout are
/// not counted.
const REQUESTS: (f64, f64) = (100.0, 50.0);
/// Requests that only read: a page that opens makes many at once.
const READS: (f64, f64) = (400.0, 100.0);
/// Reports of one detector: a gateway has many of them behind one token.
const REPORTS: (f64, f64) = (20.0, 10.0);
/// Users and sessions whose requests are counted.
const BUCKETS_MAX: usize = 10_000;

/// The requests that each user and session has left.
#[derive(Debug, Default)]
pub(super) struct Quotas(Mutex<HashMap<String, Bucket>>);

/// How long the requests over HTTP of each session or token are under way, by address.
#[derive(Debug, Default)]
pub(super) struct Delays(Mutex<HashMap<String, Delay>>);

impl Hub {
    /// Counts a request to a monitor. Not called for Stop, Close and Lockout.
    ///
    /// # Errors
    ///
    /// 429 if the user has made too many.
    pub fn count_request(&self, principal: &Principal) -> Result<(), ApiError> {
        self.count("", principal, REQUESTS)
    }

    /// Counts a change over HTTP.
    ///
    /// # Errors
    ///
    /// 429 if the user has made too many.
    pub fn count_change(&self, principal: &Principal) -> Result<(), ApiError> {
        self.count("changes ", principal, REQUESTS)
    }

    /// Counts a report of a detector: each detector has its own count, so that those behind one gateway
    /// are all heard when all alarm.
    ///
    /// # Errors
    ///
    /// 429 if it has reported too often.
    pub fn count_report(&self, principal: &Principal, detector: &str) -> Result<(), ApiError> {
        self.count(&format!("detector {detector} "), principal, REPORTS)
    }

    /// Counts a read. Reads take nothing from the requests that command.
    ///
    /// # Errors
    ///
    /// 429 if the user has made too many.
    pub fn count_reading(&self, principal: &Principal) -> Result<(), ApiError> {
        self.count("reads ", principal, READS)
    }

    /// For how much longer a request over HTTP that was sent at `t`, ms by its sender's clock, was under way
    /// than the quickest one of this session or token from there.
    pub fn longer(&self, by: &Caller, t: f64) -> Duration {
        let now = self.now();
        let mut delays = lock(&self.0.delays.0);
        if delays.len() >= BUCKETS_MAX {
            delays.clear();
        }
        let delay = delays.entry(format!("{}/{}", by.principal.key, by.seat.from)).or_default();
        self.age(delay.longer(now, t).unwrap_or(Duration::MAX))
    }

    fn count(&self, what: &str, by: &Principal, (most, per_s): (f64, f64)) -> Result<(), ApiError> {
        if by.key == ZONES {
            // The zone controller is no client: it opens many monitors at once.
            return Ok(());
        }
        let now = self.now();
        let mut buckets = lock(&self.0.quotas.0);
        if buckets.len() >= BUCKETS_MAX {
            buckets.clear();
        }
        let key = format!("{what}{}/{}", by.user, by.key);
        let bucket = buckets.entry(key).or_insert_with(|| Bucket::new(now, most, per_s));
        bucket.take(now).map_err(ApiError::slow_down)
    }
}
