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
/// Time after which more may be tried, as the answer says.
const TRIES_WAIT: Duration = Duration::from_secs(1);
/// Failures that are noted in the audit log at once, and in a second: a flood does not fill the disk.
const NOTED: (f64, f64) = (100.0, 1.0);
/// Tries at one account from places that are not known, wherever they are: so many at once, and then
/// one in 15 s. Guesses from many addresses are as slow as from one.
const ACCOUNT: (f64, f64) = (10.0, 1.0 / 15.0);
/// Failures at one account, and at all, within [`FORGET`] that are an alarm.
const ATTACK_ON_ONE: u32 = 10;
const ATTACK_ON_ALL: u32 = 100;

/// The origin of a login.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// IP address; of IPv6 the /64 network.
    pub address: String,
    /// It is a device on which this user has logged in before: what strangers do does not hold it up.
    pub device: bool,
}

impl Place {
    /// What its tries are counted by.
    fn key(&self) -> String {
        if self.device { "a known device".into() } else { self.address.clone() }
    }
}

/// Logins that have failed or are under way, by user and place.
#[derive(Debug)]
pub struct Logins {
    tries: HashMap<(String, String), Tries>,
    accounts: HashMap<String, Account>,
    noted: Bucket,
}

#[derive(Clone, Debug)]
struct Tries {
    address: String,
    failures: u32,
    last: Now,
    under_way: u32,
    /// The user has logged in here.
    familiar: bool,
}

#[derive(Clone, Copy, Debug)]
struct Account {
    failures: u32,
    last: Now,
    strangers: Bucket,
}

impl Account {
    /// A try has failed, or was too many.
    fn fail(&mut self, now: Now) {
        let forgotten = self.last + FORGET < now;
        self.failures = if forgotten { 1 } else { self.failures.saturating_add(1) };
        self.last = now;
    }
}

impl Default for Logins {
    fn default() -> Self {
        let noted = Bucket::new(Now::ZERO, NOTED.0, NOTED.1);
        Self { tries: HashMap::new(), accounts: HashMap::new(), noted }
    }
}

impl Logins {
    /// A try begins, and has a rank for [`super::Turns`]; or has to wait for so long. One that has
    /// started ends with `failed` or `succeeded`.
    pub fn begin(&mut self, now: Now, user: &str, place: &Place) -> Result<u32, Duration> {
        let key = (user.to_owned(), place.key());
        let mut known = place.device;
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
            known |= tries.familiar;
        }
        let here = self.tries.values().filter(|it| it.address == place.address);
        let sum = |(under_way, failures), it: &Tries| {
            let late = if it.last + FORGET > now { it.failures } else { 0 };
            (under_way + it.under_way, late.saturating_add(failures))
        };
        let (under_way, failures): (u32, u32) = here.fold((0, 0), sum);
        if under_way >= TRIES_FROM_MAX && !known {
            return Err(TRIES_WAIT);
        }
        self.make_room(now);
        if !known {
            let new = Bucket::new(now, ACCOUNT.0, ACCOUNT.1);
            let new = Account { failures: 0, last: now, strangers: new };
            let account = self.accounts.entry(user.to_owned()).or_insert(new);
            if let Err(wait) = account.strangers.take(now) {
                account.fail(now);
                return Err(wait);
            }
        }
        let address = place.address.clone();
        let new = Tries { address, failures: 0, last: now, under_way: 0, familiar: false };
        self.tries.entry(key).or_insert(new).under_way += 1;
        Ok(if known { 0 } else { failures.saturating_add(under_way).saturating_add(1) })
    }

    fn make_room(&mut self, now: Now) {
        if self.tries.len() >= REMEMBERED_MAX {
            self.tries.retain(|_, it| it.under_way > 0 || it.familiar || it.last + FORGET > now);
        }
        if self.tries.len() >= REMEMBERED_MAX {
            let idle = self.tries.iter().filter(|(_, it)| it.under_way == 0);
            // Places of successful logins are forgotten last.
            let first = idle.min_by_key(|(_, it)| (it.familiar, it.last));
            if let Some(first) = first.map(|(key, _)| key.clone()) {
                self.tries.remove(&first);
            }
        }
        if self.accounts.len() >= REMEMBERED_MAX {
            self.accounts.retain(|_, it| it.last + FORGET > now);
        }
        if self.accounts.len() >= REMEMBERED_MAX {
            let first = self.accounts.iter().min_by_key(|(_, it)| (it.failures, it.last));
            if let Some(first) = first.map(|(name, _)| name.clone()) {
                self.accounts.remove(&first);
            }
        }
    }

    /// A login has failed; whether that is to be noted.
    pub fn failed(&mut self, now: Now, user: &str, place: &Place) -> bool {
        if let Some(tries) = self.tries.get_mut(&(user.to_owned(), place.key())) {
            let forgotten = tries.last + FORGET < now;
            tries.failures = if forgotten { 1 } else { tries.failures.saturating_add(1) };
            tries.last = now;
            tries.under_way = tries.under_way.saturating_sub(1);
        }
        if let Some(account) = self.accounts.get_mut(user) {
            account.fail(now);
        }
        self.noted.take(now).is_ok()
    }

    /// A login has succeeded: here, the user is known from now on.
    pub fn succeeded(&mut self, user: &str, place: &Place) {
        if let Some(tries) = self.tries.get_mut(&(user.to_owned(), place.key())) {
            (tries.failures, tries.familiar) = (0, true);
            tries.under_way = tries.under_way.saturating_sub(1);
        }
    }

    /// Whether passwords are being guessed: at one account, or at many.
    pub fn attack(&self, now: Now) -> bool {
        let late = self.accounts.values().filter(|it| it.last + FORGET > now);
        let mut all = 0_u32;
        for account in late {
            all = all.saturating_add(account.failures);
            if account.failures >= ATTACK_ON_ONE || all >= ATTACK_ON_ALL {
                return true;
            }
        }
        false
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
    /// A bucket that is full: `most` at once, `per_s` a second.
    pub const fn new(now: Now, most: f64, per_s: f64) -> Self {
        Self { tokens: most, filled: now, most, per_s }
    }

    /// Takes one, or returns the time to wait.
    pub fn take(&mut self, now: Now) -> Result<(), Duration> {
        self.take_so_many(now, 1.0)
    }

    /// Takes so many, or returns the time to wait for them.
    pub fn take_so_many(&mut self, now: Now, count: f64) -> Result<(), Duration> {
        self.fill(now);
        if self.tokens >= count {
            self.tokens -= count;
            return Ok(());
        }
        Err(Duration::from_secs_f64((count - self.tokens) / self.per_s))
    }

    /// Takes so many that may not be there, and returns the time until nothing is owed; no
    /// more is owed than a full one has.
    pub fn owe(&mut self, now: Now, count: f64) -> Option<Duration> {
        self.fill(now);
        self.tokens = (self.tokens - count).max(-self.most);
        (self.tokens < 0.0).then(|| Duration::from_secs_f64(-self.tokens / self.per_s))
    }

    fn fill(&mut self, now: Now) {
        let passed = now.saturating_sub(self.filled);
        self.tokens = (self.tokens + passed.as_secs_f64() * self.per_s).min(self.most);
        self.filled = self.filled.max(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn s(seconds: u64) -> Now {
        Duration::from_secs(seconds)
    }

    fn at(address: &str) -> Place {
        Place { address: address.into(), device: false }
    }

    fn fail(logins: &mut Logins, now: Now, user: &str, from: &str) -> Result<(), Duration> {
        logins.begin(now, user, &at(from))?;
        logins.failed(now, user, &at(from));
        Ok(())
    }

    #[test]
    fn each_failure_makes_the_next_try_wait_longer() {
        let mut logins = Logins::default();
        let mut now = s(100);
        let waits: Vec<u64> = (0..9)
            .map(|_| {
                fail(&mut logins, now, "anna", "1.2.3.4").unwrap();
                let wait = logins.begin(now, "anna", &at("1.2.3.4")).unwrap_err();
                now += wait;
                wait.as_secs()
            })
            .collect();
        assert_eq!(waits, [1, 2, 4, 8, 16, 32, 60, 60, 60]);
        assert_eq!(fail(&mut logins, now, "boris", "1.2.3.4"), Ok(()), "others are not shut out");
        assert_eq!(fail(&mut logins, now, "anna", "1.2.3.5"), Ok(()), "nor is she elsewhere");
        now += s(1000);
        assert_eq!(fail(&mut logins, now, "anna", "1.2.3.4"), Ok(()));
        let again = logins.begin(now, "anna", &at("1.2.3.4"));
        assert_eq!(again, Err(s(1)), "the old ones are forgotten");
        now += s(1);
        assert!(logins.begin(now, "anna", &at("1.2.3.4")).is_ok());
        logins.succeeded("anna", &at("1.2.3.4"));
        assert!(logins.begin(now, "anna", &at("1.2.3.4")).is_ok());
    }

    #[test]
    fn guesses_at_one_account_from_everywhere_are_slow_and_an_alarm() {
        let mut logins = Logins::default();
        let home = at("10.0.0.1");
        logins.begin(s(1), "anna", &home).unwrap();
        logins.succeeded("anna", &home);
        let guesses = |logins: &mut Logins, now: Now| {
            let from = |n: u32| format!("{}.{n}", now.as_secs());
            (0..60).filter(|n| fail(logins, now, "anna", &from(*n)).is_ok()).count()
        };
        assert!(!logins.attack(s(2)));
        assert_eq!(guesses(&mut logins, s(2)), 9);
        assert_eq!(guesses(&mut logins, s(62)), 4, "one in 15 s");
        assert!(logins.attack(s(62)));
        // Where she has logged in before, and on a device of hers, she does not wait.
        assert_eq!(logins.begin(s(62), "anna", &home), Ok(0));
        let device = Place { address: "6.6.6.6".into(), device: true };
        assert_eq!(logins.begin(s(62), "anna", &device), Ok(0));
        let elsewhere = logins.begin(s(62), "anna", &at("7.7.7.7"));
        assert!(elsewhere.unwrap_err() <= s(15), "others wait");
        assert!(logins.begin(s(62), "boris", &at("7.7.7.7")).is_ok());
        assert!(!logins.attack(s(62) + FORGET));
    }

    #[test]
    fn who_has_failed_is_served_after_who_has_not() {
        let mut logins = Logins::default();
        let rank = |logins: &mut Logins, user: &str, from: &str| {
            logins.begin(s(100), user, &at(from)).unwrap()
        };
        assert_eq!(rank(&mut logins, "a", "1.1.1.1"), 1);
        assert_eq!(rank(&mut logins, "b", "1.1.1.1"), 2, "side by side");
        logins.failed(s(100), "a", &at("1.1.1.1"));
        logins.failed(s(100), "b", &at("1.1.1.1"));
        assert_eq!(rank(&mut logins, "c", "1.1.1.1"), 3);
        assert_eq!(rank(&mut logins, "anna", "2.2.2.2"), 1);
    }

    #[test]
    fn guesses_side_by_side_are_few() {
        let mut logins = Logins::default();
        let begun = |logins: &mut Logins, user: &str, from: &str| {
            (0..50).filter(|_| logins.begin(s(1), user, &at(from)).is_ok()).count()
        };
        assert_eq!(begun(&mut logins, "anna", "1.2.3.4"), 4);
        let users: Vec<String> = (0..50).map(|n| n.to_string()).collect();
        let here = |it: &&String| logins.begin(s(1), it, &at("1.2.3.4")).is_ok();
        assert_eq!(users.iter().filter(here).count(), 4, "of one address");
        assert_eq!(begun(&mut logins, "anna", "1.2.3.5"), 4, "another one");
        (0..4).for_each(|_| _ = logins.failed(s(1), "anna", &at("1.2.3.4")));
        let next = logins.begin(s(1), "anna", &at("1.2.3.4"));
        assert_eq!(next, Err(s(8)), "each of them counts");
        assert_eq!(begun(&mut logins, "anna", "1.2.3.6"), 2, "ten at one account");
    }

    #[test]
    fn so_many_names_do_not_wash_the_latest_away() {
        let mut logins = Logins::default();
        for n in 0..REMEMBERED_MAX + 10 {
            // Each from an address of its own, which is how the list is filled fastest.
            fail(&mut logins, s(10), &n.to_string(), &n.to_string()).unwrap();
        }
        fail(&mut logins, s(11), "root", "1.2.3.4").unwrap();
        assert_eq!(logins.begin(s(11), "root", &at("1.2.3.4")), Err(s(1)));
        assert!(logins.tries.len() <= REMEMBERED_MAX && logins.accounts.len() <= REMEMBERED_MAX);
        let place = at("1.2.3.4");
        let noted = (0..1000).filter(|_| logins.failed(s(1000), "root", &place)).count();
        assert_eq!(noted, 100);
    }

    #[test]
    fn a_bucket_gives_so_many_and_then_so_many_a_second() {
        let mut bucket = Bucket::new(s(0), 3.0, 2.0);
        assert!((0..3).all(|_| bucket.take(s(0)).is_ok()));
        assert_eq!(bucket.take(s(0)), Err(Duration::from_millis(500)));
        assert!(bucket.take(Duration::from_millis(500)).is_ok());
        assert!((0..3).all(|_| bucket.take(s(60)).is_ok()) && bucket.take(s(60)).is_err());
        assert_eq!(bucket.owe(s(60), 2.0), Some(s(1)));
        assert_eq!(bucket.owe(s(60), 100.0), Some(Duration::from_millis(1500)), "bounded");
        assert_eq!(bucket.owe(s(62), 0.0), None);
        assert!(bucket.take(s(62)).is_ok() && bucket.take(s(62)).is_err());
    }
}
