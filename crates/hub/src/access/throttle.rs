//! Limits of rate: for logins that fail, and for requests of one user.

use std::collections::HashMap;
use std::time::Duration;

/// A moment: time since the hub's start.
type Now = Duration;

/// The longest wait after failures.
const WAIT_MAX_S: u64 = 60;
/// Failures are forgotten after this time.
const FORGET: Duration = Duration::from_secs(900);
/// Users and addresses that are remembered; then the one that failed first is forgotten.
const REMEMBERED_MAX: usize = 10_000;
/// Tries of a user that has not failed, and of an address, that may be under way at once: each is
/// a guess before the first one's answer is known, and costs the processor as much as any.
const TRIES_MAX: u32 = 4;
const TRIES_FROM_MAX: u32 = 8;
/// What is told to whoever tries more.
const TRIES_WAIT: Duration = Duration::from_secs(1);
/// Failures that are noted in the audit log at once, and in a second: nobody fills a disk so.
const NOTED: (f64, f64) = (100.0, 1.0);

/// Logins that have failed or are under way, by user and address.
#[derive(Debug)]
pub struct Logins {
    tries: HashMap<(String, String), Tries>,
    noted: Bucket,
}

#[derive(Clone, Copy, Debug)]
struct Tries {
    failures: u32,
    last: Now,
    under_way: u32,
}

impl Default for Logins {
    fn default() -> Self {
        Self { tries: HashMap::new(), noted: Bucket::new(Now::ZERO, NOTED.0, NOTED.1) }
    }
}

impl Logins {
    /// A try begins, or has to wait for so long. One that has begun ends with `failed` or
    /// `succeeded`.
    pub fn begin(&mut self, now: Now, user: &str, from: &str) -> Result<(), Duration> {
        let key = (user.to_owned(), from.to_owned());
        if let Some(tries) = self.tries.get(&key) {
            let wait_s = match tries.failures {
                0 => 0,
                n => 1_u64.checked_shl(n - 1).unwrap_or(WAIT_MAX_S).min(WAIT_MAX_S),
            };
            let until = tries.last + Duration::from_secs(wait_s);
            if let Some(wait) = until.checked_sub(now).filter(|wait| !wait.is_zero()) {
                return Err(wait);
            }
            if tries.under_way >= if tries.failures == 0 { TRIES_MAX } else { 1 } {
                return Err(TRIES_WAIT);
            }
        }
        let here = self.tries.iter().filter(|((_, address), _)| address == from);
        if here.map(|(_, tries)| tries.under_way).sum::<u32>() >= TRIES_FROM_MAX {
            return Err(TRIES_WAIT);
        }
        self.make_room(now);
        let tries = Tries { failures: 0, last: now, under_way: 0 };
        self.tries.entry(key).or_insert(tries).under_way += 1;
        Ok(())
    }

    fn make_room(&mut self, now: Now) {
        if self.tries.len() < REMEMBERED_MAX {
            return;
        }
        self.tries.retain(|_, it| it.under_way > 0 || it.last + FORGET > now);
        if self.tries.len() >= REMEMBERED_MAX {
            let idle = self.tries.iter().filter(|(_, it)| it.under_way == 0);
            if let Some(first) = idle.min_by_key(|(_, it)| it.last).map(|(key, _)| key.clone()) {
                self.tries.remove(&first);
            }
        }
    }

    /// A login has failed; whether that is to be noted.
    pub fn failed(&mut self, now: Now, user: &str, from: &str) -> bool {
        if let Some(tries) = self.tries.get_mut(&(user.to_owned(), from.to_owned())) {
            let forgotten = tries.last + FORGET < now;
            tries.failures = if forgotten { 1 } else { tries.failures.saturating_add(1) };
            tries.last = now;
            tries.under_way = tries.under_way.saturating_sub(1);
        }
        self.noted.take(now).is_ok()
    }

    /// A login has succeeded.
    pub fn succeeded(&mut self, user: &str, from: &str) {
        let key = (user.to_owned(), from.to_owned());
        if let Some(tries) = self.tries.get_mut(&key) {
            tries.failures = 0;
            tries.under_way = tries.under_way.saturating_sub(1);
            if tries.under_way == 0 {
                self.tries.remove(&key);
            }
        }
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

    fn fail(logins: &mut Logins, now: Now, user: &str, from: &str) -> Result<(), Duration> {
        logins.begin(now, user, from)?;
        logins.failed(now, user, from);
        Ok(())
    }

    #[test]
    fn each_failure_makes_the_next_try_wait_longer() {
        let mut logins = Logins::default();
        let mut now = s(100);
        let waits: Vec<u64> = (0..9)
            .map(|_| {
                fail(&mut logins, now, "anna", "1.2.3.4").unwrap();
                let wait = logins.begin(now, "anna", "1.2.3.4").unwrap_err();
                now += wait;
                wait.as_secs()
            })
            .collect();
        assert_eq!(waits, [1, 2, 4, 8, 16, 32, 60, 60, 60]);
        assert_eq!(fail(&mut logins, now, "boris", "1.2.3.4"), Ok(()), "others are not shut out");
        assert_eq!(fail(&mut logins, now, "anna", "1.2.3.5"), Ok(()), "nor is she elsewhere");
        now += s(1000);
        assert_eq!(fail(&mut logins, now, "anna", "1.2.3.4"), Ok(()));
        assert_eq!(logins.begin(now, "anna", "1.2.3.4"), Err(s(1)), "the old ones are forgotten");
        now += s(1);
        assert_eq!(logins.begin(now, "anna", "1.2.3.4"), Ok(()));
        logins.succeeded("anna", "1.2.3.4");
        assert_eq!(logins.begin(now, "anna", "1.2.3.4"), Ok(()));
    }

    #[test]
    fn guesses_side_by_side_are_few() {
        let mut logins = Logins::default();
        let begun = |logins: &mut Logins, user: &str, from: &str| {
            (0..50).filter(|_| logins.begin(s(1), user, from).is_ok()).count()
        };
        assert_eq!(begun(&mut logins, "anna", "1.2.3.4"), 4);
        let users: Vec<String> = (0..50).map(|n| n.to_string()).collect();
        let more = users.iter().filter(|it| logins.begin(s(1), it, "1.2.3.4").is_ok()).count();
        assert_eq!(more, 4, "of one address");
        assert_eq!(begun(&mut logins, "anna", "1.2.3.5"), 4, "another one");
        (0..4).for_each(|_| _ = logins.failed(s(1), "anna", "1.2.3.4"));
        assert_eq!(logins.begin(s(1), "anna", "1.2.3.4"), Err(s(8)), "each of them counts");
        assert_eq!(begun(&mut logins, "anna", "1.2.3.6"), 4);
    }

    #[test]
    fn so_many_names_do_not_wash_the_latest_away() {
        let mut logins = Logins::default();
        for n in 0..REMEMBERED_MAX + 10 {
            fail(&mut logins, s(10), &n.to_string(), "1.2.3.4").unwrap();
        }
        fail(&mut logins, s(11), "root", "1.2.3.4").unwrap();
        assert_eq!(logins.begin(s(11), "root", "1.2.3.4"), Err(s(1)));
        assert!(logins.tries.len() <= REMEMBERED_MAX);
        let noted = (0..1000).filter(|_| logins.failed(s(1000), "root", "1.2.3.4")).count();
        assert_eq!(noted, 100);
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
