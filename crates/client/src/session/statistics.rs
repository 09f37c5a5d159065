//! Statistics of a link for each second, for logs and dashboards.

use std::fmt;
use std::time::Duration;

use super::{Now, Stats};

/// Period of the statistics.
pub const PERIOD: Duration = Duration::from_secs(1);

/// Statistics of a link: of the last period, and in total.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct LinkStatistics {
    /// Time since the client was created.
    pub at: Duration,
    /// Duration of the period of `last`: a second, or more after a stall.
    pub over: Duration,
    /// Counts of the period; round trips are current ones.
    pub last: Stats,
    /// Counts since the client was created.
    pub total: Stats,
}

impl Stats {
    /// Share of sent frames without answer in time, in thousandths.
    pub const fn loss_permille(&self) -> u32 {
        let asked = self.believed + self.timeouts;
        match asked {
            0 => 0,
            asked => (self.timeouts * 1000 / asked) as u32,
        }
    }

    /// Frames dropped because of errors.
    pub const fn errors(&self) -> u64 {
        self.crc_errors + self.framing_errors
    }

    /// Counts since `before`.
    #[must_use]
    pub const fn since(self, before: &Self) -> Self {
        Self {
            frames_sent: self.frames_sent.saturating_sub(before.frames_sent),
            frames_received: self.frames_received.saturating_sub(before.frames_received),
            believed: self.believed.saturating_sub(before.believed),
            crc_errors: self.crc_errors.saturating_sub(before.crc_errors),
            framing_errors: self.framing_errors.saturating_sub(before.framing_errors),
            retries: self.retries.saturating_sub(before.retries),
            timeouts: self.timeouts.saturating_sub(before.timeouts),
            late: self.late.saturating_sub(before.late),
            duplicates: self.duplicates.saturating_sub(before.duplicates),
            foreign: self.foreign.saturating_sub(before.foreign),
            unmatched: self.unmatched.saturating_sub(before.unmatched),
            reconnects: self.reconnects.saturating_sub(before.reconnects),
            collisions: self.collisions.saturating_sub(before.collisions),
            echoes_missing: self.echoes_missing.saturating_sub(before.echoes_missing),
            ..self
        }
    }
}

/// One line of `name=value` for a log; counts are those of the last period, with the total in
/// parentheses.
impl fmt::Display for LinkStatistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (last, total) = (&self.last, &self.total);
        write!(f, "t={:.1}s", self.at.as_secs_f64())?;
        let counts = [
            ("sent", last.frames_sent, total.frames_sent),
            ("received", last.frames_received, total.frames_received),
            ("errors", last.errors(), total.errors()),
            ("retries", last.retries, total.retries),
            ("late", last.late, total.late),
            ("strays", last.strays() - last.late, total.strays() - total.late),
            ("collisions", last.collisions, total.collisions),
            ("reconnects", last.reconnects, total.reconnects),
        ];
        for (name, last, total) in counts {
            write!(f, " {name}={last}({total})")?;
        }
        for (name, rtt) in [("rtt", last.rtt_last), ("srtt", last.rtt_average)] {
            match rtt {
                Some(rtt) => write!(f, " {name}={:.1}ms", rtt.as_secs_f64() * 1000.0)?,
                None => write!(f, " {name}=-")?,
            }
        }
        let permille = |n: u32| (n / 10, n % 10);
        let ((a, b), (c, d)) = (permille(last.loss_permille()), permille(total.loss_permille()));
        write!(f, " loss={a}.{b}%({c}.{d}%)")?;
        if total.crc32c > 0 { write!(f, " crc32c={}", total.crc32c) } else { Ok(()) }
    }
}

/// Produces the statistics of each second.
#[derive(Debug)]
pub struct Meter {
    taken: Now,
    before: Stats,
}

impl Meter {
    /// A meter that counts from now on.
    pub const fn new(now: Now, stats: Stats) -> Self {
        Self { taken: now, before: stats }
    }

    /// Time of the next statistics.
    pub fn poll_timeout(&self) -> Now {
        self.taken + PERIOD
    }

    /// The statistics, if they are due.
    pub fn poll(&mut self, now: Now, total: Stats) -> Option<LinkStatistics> {
        let over = now.saturating_sub(self.taken);
        if over < PERIOD {
            return None;
        }
        let last = total.since(&self.before);
        (self.taken, self.before) = (now, total);
        Some(LinkStatistics { at: now, over, last, total })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_second_has_its_own_figures() {
        let start = Stats { frames_sent: 5, ..Stats::default() };
        let mut meter = Meter::new(Now::ZERO, start);
        let rtt_last = Some(Duration::from_micros(12_340));
        let total = Stats {
            frames_sent: 25,
            believed: 19,
            timeouts: 1,
            late: 1,
            foreign: 2,
            rtt_last,
            ..Stats::default()
        };
        assert_eq!(meter.poll(Duration::from_millis(999), total), None);
        let first = meter.poll(PERIOD, total).expect("a second has passed");
        assert_eq!((first.last.frames_sent, first.total.frames_sent), (20, 25));
        assert_eq!(first.last.loss_permille(), 50);
        let text = first.to_string();
        for word in ["t=1.0s", "sent=20(25)", "late=1(1)", "strays=2(2)", "rtt=12.3ms", "srtt=-"] {
            assert!(text.contains(word), "{text}");
        }
        assert!(text.ends_with("loss=5.0%(5.0%)"), "{text}");
        // A stall makes one report of a longer time, not several.
        let second = meter.poll(Duration::from_secs(4), total).expect("due");
        assert_eq!((second.over, second.last.frames_sent), (Duration::from_secs(3), 0));
        assert_eq!(second.last.loss_permille(), 0);
        assert_eq!(meter.poll_timeout(), Duration::from_secs(5));
    }
}
