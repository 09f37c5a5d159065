//! How often things happen: totals, looked at each second.

use std::collections::VecDeque;
use std::sync::Mutex;
use std::sync::atomic::Ordering;

use serde_json::{Map, Value, json};
use tokio::time::Instant;

use crate::hub::Counts;
use crate::sync::lock;

/// Rates are those of so many seconds.
const OVER: usize = 10;
const NAMES: [&str; 5] = ["polls", "commands", "requests", "messages", "message_bytes"];

type Totals = [u64; NAMES.len()];

/// The totals of the last seconds.
#[derive(Debug, Default)]
pub struct Rates(Mutex<VecDeque<(Instant, Totals)>>);

impl Rates {
    /// A second has passed.
    pub fn take(&self, now: Instant, counts: &Counts) {
        let mut all = lock(&self.0);
        all.push_back((now, totals(counts)));
        if all.len() > OVER + 1 {
            all.pop_front();
        }
    }

    /// What happens in a second.
    pub fn json(&self, now: Instant, counts: &Counts) -> Value {
        let first = lock(&self.0).front().copied();
        let (since, before) = first.unwrap_or((now, totals(counts)));
        let over_s = now.saturating_duration_since(since).as_secs_f64();
        let rate = |(name, (after, before)): (&str, (u64, u64))| {
            let rate =
                if over_s > 0.0 { after.saturating_sub(before) as f64 / over_s } else { 0.0 };
            (format!("{name}_per_s"), json!((rate * 10.0).round() / 10.0))
        };
        let totals = totals(counts).into_iter().zip(before);
        let all: Map<String, Value> = NAMES.into_iter().zip(totals).map(rate).collect();
        Value::Object(all)
    }
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
        assert_eq!(rates.json(at(0), &counts)["polls_per_s"], 0.0);
        for second in 0..100 {
            rates.take(at(second), &counts);
            counts.polls.fetch_add(if second < 50 { 1000 } else { 25 }, Ordering::Relaxed);
        }
        assert_eq!(rates.json(at(100), &counts)["polls_per_s"], 25.0);
        assert_eq!(rates.json(at(100), &counts)["commands_per_s"], 0.0);
    }
}
