//! The current value of a series: which changes are stored, and the means and extremes of its minutes.

use std::sync::Arc;

use super::history::{Key, Row};
use super::series::{HEARTBEAT_MS, bucket_ms};
use super::thin::MINUTE_MS;
use crate::monitor::link_series;

/// Shortest time between two changes that are stored.
const RAW_MS: u64 = 200;

/// The current value of a series, and the bucket that it is in.
#[derive(Clone, Debug)]
pub struct Current {
    key: Arc<Key>,
    value: f64,
    noted_ms: u64,
    bucket: Bucket,
    /// The last bucket stored, if the value did not change in it: value and start.
    constant: Option<(f64, u64)>,
}

/// A minute, or a longer time, that has not ended.
#[derive(Clone, Copy, Debug)]
struct Bucket {
    start_ms: u64,
    until_ms: u64,
    area: f64,
    least: f64,
    most: f64,
}

impl Bucket {
    fn begin(at_ms: u64, value: f64) -> Self {
        Self { start_ms: at_ms, until_ms: at_ms, area: 0.0, least: value, most: value }
    }

    /// The value holds until a time.
    fn hold(&mut self, value: f64, until_ms: u64) {
        let for_ms = until_ms.saturating_sub(self.until_ms);
        self.area += value * for_ms as f64;
        self.until_ms += for_ms;
        self.include(value);
    }

    fn include(&mut self, value: f64) {
        self.least = self.least.min(value);
        self.most = self.most.max(value);
    }

    fn figures(&self) -> [f64; 3] {
        let over_ms = self.until_ms - self.start_ms;
        let mean = if over_ms == 0 { self.least } else { self.area / over_ms as f64 };
        [mean.clamp(self.least, self.most), self.least, self.most]
    }
}

impl Current {
    /// The first value.
    pub fn begin(key: Arc<Key>, at_ms: u64, value: f64) -> Self {
        Self { key, value, noted_ms: at_ms, bucket: Bucket::begin(at_ms, value), constant: None }
    }

    /// Ends the bucket at a time. A constant is stored when it becomes one, and each hour.
    fn end_bucket(&mut self, end_ms: u64, pending: &mut Vec<Row>) {
        self.bucket.hold(self.value, end_ms);
        let start_ms = self.bucket.start_ms;
        let figures @ [_, least, most] = self.bucket.figures();
        self.bucket = Bucket::begin(end_ms, self.value);
        let constant = least.total_cmp(&most).is_eq();
        let holds = self.constant.is_some_and(|(value, since_ms)| {
            constant && value.total_cmp(&least).is_eq() && start_ms < since_ms + HEARTBEAT_MS
        });
        if !holds {
            self.constant = constant.then_some((least, start_ms));
            pending.push(Row::Minute(self.key.clone(), start_ms, figures));
        }
    }

    /// The value is unknown from a time on.
    pub fn lose(mut self, at_ms: u64, pending: &mut Vec<Row>) {
        // After the start of what it ends.
        let at_ms = at_ms.max(self.bucket.until_ms).max(self.bucket.start_ms + 1);
        self.end_bucket(at_ms, pending);
        pending.push(Row::Gap(self.key.clone(), at_ms));
        pending.push(Row::Raw(self.key, at_ms, None));
    }

    /// Notes the value again, with the time from which it holds, and the minutes from the next one on: the file
    /// lacks them, and all changes from a time on.
    pub fn repeat(&mut self, from_ms: u64, pending: &mut Vec<Row>) {
        self.constant = None;
        pending.push(Row::Raw(self.key.clone(), self.noted_ms.max(from_ms), Some(self.value)));
    }

    /// Takes a value at a time; `None`: the series had no value for long, or the clock was put back.
    /// `false`: it comes too soon after the last change, and has to be noted again if it stays.
    pub fn note(&mut self, at_ms: u64, value: f64, pending: &mut Vec<Row>) -> Option<bool> {
        let bucket_ms = bucket_ms(&self.key.series);
        let end_ms = self.bucket.start_ms - self.bucket.start_ms % bucket_ms + bucket_ms;
        let known = at_ms < self.bucket.until_ms + 2 * MINUTE_MS
            && at_ms + MINUTE_MS >= self.bucket.until_ms;
        if !known {
            return None;
        }
        if at_ms >= end_ms {
            self.end_bucket(end_ms, pending);
        }
        Some(self.hold(at_ms, value, pending))
    }

    /// The time until which the value is known, ms since 1970.
    pub fn until_ms(&self) -> u64 {
        self.bucket.until_ms
    }

    fn hold(&mut self, at_ms: u64, value: f64, pending: &mut Vec<Row>) -> bool {
        let (raw_ms, band) = link_series::grain(&self.key.series, self.value)
            .map_or((RAW_MS, f64::EPSILON), |it| (it.every_ms, it.band));
        let old = self.value;
        self.bucket.hold(old, at_ms);
        let changed = (value - old).abs() > band;
        if changed {
            self.bucket.include(value);
        }
        // Of what changes too fast the extremes are in the minute.
        let changed = changed && at_ms >= self.noted_ms.saturating_add(raw_ms);
        let due = at_ms >= self.noted_ms + HEARTBEAT_MS;
        if changed || due || at_ms < self.noted_ms {
            self.value = if changed { value } else { old };
            self.noted_ms = at_ms;
            pending.push(Row::Raw(self.key.clone(), at_ms, Some(self.value)));
        }
        (value - self.value).abs() <= band
    }
}
