//! Limits of rate: for logins that fail, and for requests of one user.

use std::collections::HashMap;
use std::time::Duration;

/// A moment: time since the hub's start.
type Now = Duration;

/// The longest wait after failures.
const WAIT_MAX_S: u64 = 60;
/// Failures are forgotten after this time.
const FORGET: Duration = Duration::from_secs(900);
/// Users and addresses that are remembered; more than that, and all have to wait a little.
const REMEMBERED_MAX: usize = 10_000;

/// Logins that have failed, by user and address.
#[derive(Debug, Default)]
pub struct Logins {
    failures: HashMap<(String, String), (u32, Now)>,
}

impl Logins {
    /// How long this user has to wait for the next try from this address.
    pub fn wait(&self, now: Now, user: &str, from: &str) -> Option<Duration> {
        let key = (user.to_owned(), from.to_owned());
        let (failures, last) = self.failures.get(&key)?;
        let wait_s = 1_u64.checked_shl(failures.saturating_sub(1)).unwrap_or(WAIT_MAX_S);
        let until = *last + Duration::from_secs(wait_s.min(WAIT_MAX_S));
        until.checked_sub(now).filter(|wait| !wait.is_zero())
    }

    /// A login has failed.
    pub fn failed(&mut self, now: Now, user: &str, from: &str) {
        if self.failures.len() >= REMEMBERED_MAX {
            self.failures.retain(|_, (_, last)| *last + FORGET > now);
        }
        if self.failures.len() >= REMEMBERED_MAX {
            return;
        }
        let entry = self.failures.entry((user.to_owned(), from.to_owned())).or_insert((0, now));
        let forgotten = entry.1 + FORGET < now;
        *entry = (if forgotten { 1 } else { entry.0.saturating_add(1) }, now);
    }

    /// A login has succeeded.
    pub fn succeeded(&mut self, user: &str, from: &str) {
        self.failures.remove(&(user.to_owned(), from.to_owned()));
    }
}

/// So many at once, so many a second.
#[derive(Clone, Copy, Debug)]
pub struct Bucket {
    tokens: f64,
    filled: Now,
    most: f64,
    per_s: f64,
}

impl Bucket {
    /// A full one.
    pub const fn new(now: Now, most: f64, per_s: f64) -> Self {
        Self { tokens: most, filled: now, most, per_s }
    }

    /// Takes one, or tells how long to wait.
    pub fn take(&mut self, now: Now) -> Result<(), Duration> {
        let passed = now.saturating_sub(self.filled);
        self.tokens = (self.tokens + passed.as_secs_f64() * self.per_s).min(self.most);
        self.filled = now;
        if self.tokens >= 1.0 {
            self.tokens -= 1.0;
            return Ok(());
        }
        Err(Duration::from_secs_f64((1.0 - self.tokens) / self.per_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn s(seconds: u64) -> Now {
        Duration::from_secs(seconds)
    }

    #[test]
    fn each_failure_makes_the_next_try_wait_longer() {
        let mut logins = Logins::default();
        let waits: Vec<u64> = (0..9)
            .map(|_| {
                logins.failed(s(100), "anna", "1.2.3.4");
                logins.wait(s(100), "anna", "1.2.3.4").unwrap().as_secs()
            })
            .collect();
        assert_eq!(waits, [1, 2, 4, 8, 16, 32, 60, 60, 60]);
        assert_eq!(logins.wait(s(100), "anna", "1.2.3.5"), None, "others are not shut out");
        assert_eq!(logins.wait(s(160), "anna", "1.2.3.4"), None);
        logins.failed(s(1100), "anna", "1.2.3.4");
        assert_eq!(logins.wait(s(1100), "anna", "1.2.3.4"), Some(s(1)), "forgotten");
        logins.succeeded("anna", "1.2.3.4");
        assert_eq!(logins.wait(s(1100), "anna", "1.2.3.4"), None);
    }

    #[test]
    fn a_bucket_gives_so_many_and_then_so_many_a_second() {
        let mut bucket = Bucket::new(s(0), 3.0, 2.0);
        assert!((0..3).all(|_| bucket.take(s(0)).is_ok()));
        assert_eq!(bucket.take(s(0)), Err(Duration::from_millis(500)));
        assert!(bucket.take(Duration::from_millis(500)).is_ok());
        assert!((0..3).all(|_| bucket.take(s(60)).is_ok()) && bucket.take(s(60)).is_err());
    }
}
