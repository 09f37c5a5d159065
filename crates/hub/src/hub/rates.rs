//! How often things happen: totals, looked at each second.

use std::collections::VecDeque;
use std::sync::Mutex;
use std::sync::atomic::Ordering;

use serde::Serialize;
use tokio::time::Instant;
use utoipa::ToSchema;

use super::Counts;
use crate::sync::lock;

/// Rates are those of so many seconds.
const OVER: usize = 10;
type Totals = [u64; 5];

/// What happens in a second, over the last ten.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct PerSecond {
    /// States polled from monitors.
    pub polls_per_s: f64,
    /// Requests to monitors.
    pub commands_per_s: f64,
    /// HTTP requests.
    pub requests_per_s: f64,
    /// Messages to WebSockets.
    pub messages_per_s: f64,
    /// Bytes to WebSockets.
    pub message_bytes_per_s: f64,
}

/// The totals of the last seconds.
#[derive(Debug, Default)]
pub struct Rates(Mutex<VecDeque<(Instant, Totals)>>);

impl Rates {
    /// Takes the totals; called once a second.
    pub fn take(&self, now: Instant, counts: &Counts) {
        let mut all = lock(&self.0);
        all.push_back((now, totals(counts)));
        if all.len() > OVER + 1 {
            all.pop_front();
        }
    }

    /// What happens in a second.
    pub fn per_second(&self, now: Instant, counts: &Counts) -> PerSecond {
        let first = lock(&self.0).front().copied();
        let (since, before) = first.unwrap_or((now, totals(counts)));
        let over_s = now.saturating_duration_since(since).as_secs_f64();
        let after = totals(counts);
        let [polls_per_s, commands_per_s, requests_per_s, messages_per_s, message_bytes_per_s] =
            std::array::from_fn(|at| rate(after[at].saturating_sub(before[at]), over_s));
        PerSecond {
            polls_per_s,
            commands_per_s,
            requests_per_s,
            messages_per_s,
            message_bytes_per_s,
        }
    }
}

/// To a tenth; nothing is known of no time.
fn rate(count: u64, over_s: f64) -> f64 {
    if over_s > 0.0 { (count as f64 / over_s * 10.0).round() / 10.0 } else { 0.0 }
}

fn totals(counts: &Counts) -> Totals {
    [&counts.polls, &counts.commands, &counts.requests, &counts.messages, &counts.message_bytes]
        .map(|count| count.load(Ordering::Relaxed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn rates_are_those_of_the_last_seconds() {
        let (rates, counts, start) = (Rates::default(), Counts::default(), Instant::now());
        let at = |second: u64| start + Duration::from_secs(second);
        assert_eq!(rates.per_second(at(0), &counts).polls_per_s, 0.0);
        for second in 0..100 {
            rates.take(at(second), &counts);
            counts.polls.fetch_add(if second < 50 { 1000 } else { 25 }, Ordering::Relaxed);
        }
        assert_eq!(rates.per_second(at(100), &counts).polls_per_s, 25.0);
        assert_eq!(rates.per_second(at(100), &counts).commands_per_s, 0.0);
    }
}
