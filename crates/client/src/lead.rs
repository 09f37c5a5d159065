//! When a caller may serve the link instead of the task, and when the task looks whether it does.
//!
//! A caller leads only while the task has promised to look at the link within [`LOOK`]: a leader
//! that is not polled delays others by that, at most. A look that finds an answer for which such a
//! leader was woken, or that none has led, withdraws the promise, and it is not made again within
//! [`REST`]. The promise costs timers, so it is made only to a caller that asks again soon after a
//! quick answer.

use std::time::Duration;

use crate::session::Now;

/// Longest time for which a leader that is not polled delays the link.
pub const LOOK: Duration = Duration::from_millis(20);
/// Time since the submission after which an answer that the task finds shows that the leader was
/// not polled: a leader that is polled takes far less, so that it seldom meets a look.
const ASLEEP: Duration = Duration::from_millis(5);
/// Time without leaders after one was not polled, or none was needed.
const REST: Duration = Duration::from_secs(1);

/// The promise of the task, and what it depends on.
#[derive(Debug, Default)]
pub struct Lead {
    /// When the task looks at the link by itself.
    alarm: Option<Now>,
    allowed: bool,
    /// A caller asked again soon.
    asked: bool,
    /// Exchanges that callers have served, and their number at the last look.
    led: u64,
    seen: u64,
    /// A leader was not polled.
    asleep: bool,
    brisk_until: Now,
    rest_until: Now,
}

impl Lead {
    /// Whether callers may lead.
    pub const fn is_allowed(&self) -> bool {
        self.allowed
    }

    /// A caller has submitted an operation.
    pub fn submitted(&mut self, now: Now) {
        self.asked |= !self.allowed && now < self.brisk_until && now >= self.rest_until;
    }

    /// An operation submitted at `since` has ended, served by a caller or by the task.
    pub fn ended(&mut self, now: Now, since: Now, by_caller: bool) {
        let took = now.saturating_sub(since);
        self.led += u64::from(by_caller);
        self.asleep |= self.allowed && !by_caller && took >= ASLEEP;
        if took < LOOK {
            self.brisk_until = now + LOOK;
        }
    }

    /// Whether the task looks too late for what is due.
    pub fn is_late_for(&self, due: Option<Now>) -> bool {
        due.is_some_and(|due| self.alarm.is_none_or(|alarm| due < alarm))
    }

    /// The task has looked at the link, and something is due then. Returns when it looks again.
    pub fn look(&mut self, now: Now, due: Option<Now>) -> Option<Now> {
        let passed = self.alarm.is_none_or(|alarm| alarm <= now);
        if self.allowed && (passed || self.asleep) {
            self.allowed = self.led != self.seen && !self.asleep;
            self.asleep = false;
            if !self.allowed {
                self.rest_until = now + REST;
            }
            self.seen = self.led;
        } else if !self.allowed && std::mem::take(&mut self.asked) {
            self.allowed = true;
            self.seen = self.led;
        }
        let next = due.into_iter().chain(self.allowed.then_some(now + LOOK)).min();
        // A timer that fires too early is set again: usually the request is answered by then.
        if passed || self.is_late_for(next) {
            self.alarm = next;
        }
        self.alarm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    fn exchange(lead: &mut Lead, now: Now, took: Duration, by_caller: bool) {
        lead.submitted(now);
        lead.ended(now + took, now, by_caller);
    }

    /// A lead that is allowed at 3 ms.
    fn allowed() -> Lead {
        let mut lead = Lead::default();
        exchange(&mut lead, MS, MS, false);
        lead.submitted(3 * MS);
        assert_eq!(lead.look(3 * MS, Some(1000 * MS)), Some(23 * MS));
        assert!(lead.is_allowed());
        lead
    }

    #[test]
    fn who_asks_seldom_or_waits_long_does_not_lead() {
        for (pause, took) in [(50, 1), (1, 30)] {
            let mut lead = Lead::default();
            for n in 1..100 {
                let now = n * (pause + took) * MS;
                exchange(&mut lead, now, took * MS, false);
                assert_eq!(lead.look(now + took * MS, None), None);
                assert!(!lead.is_allowed());
            }
        }
    }

    /// While callers lead, the task looks at least each [`LOOK`].
    #[test]
    fn the_task_keeps_its_promise() {
        let mut lead = allowed();
        for n in 0..50 {
            let now = (23 + n * 20) * MS;
            assert!(lead.is_late_for(Some(now - MS)) && !lead.is_late_for(Some(now + MS)));
            exchange(&mut lead, now - 5 * MS, MS, true);
            assert_eq!(lead.look(now - MS, None), Some(now), "woken for something else");
            assert_eq!(lead.look(now, Some(9 * MS + now)), Some(now + 9 * MS));
            exchange(&mut lead, now + MS, MS, true);
            assert_eq!(lead.look(now + 9 * MS, None), Some(now + 29 * MS));
            exchange(&mut lead, now + 10 * MS, MS, true);
            lead = Lead { alarm: Some(now + 20 * MS), ..lead };
        }
    }

    /// The task and a leader that is polled come upon the same answer now and then.
    #[test]
    fn an_answer_that_just_came_proves_nothing() {
        let mut lead = allowed();
        exchange(&mut lead, 4 * MS, MS, true);
        exchange(&mut lead, 22 * MS, MS, false);
        assert_eq!(lead.look(23 * MS, None), Some(43 * MS));
        assert!(lead.is_allowed());
    }

    /// A leader that is not polled costs one look, and none for the next second.
    #[test]
    fn one_that_is_not_polled_leads_no_longer() {
        // Another one that leads does not hide it.
        let mut lead = allowed();
        exchange(&mut lead, 4 * MS, MS, true);
        lead.submitted(5 * MS);
        lead.ended(23 * MS, 5 * MS, false);
        assert_eq!(lead.look(23 * MS, None), None);
        assert!(!lead.is_allowed());
        for n in 24..1023 {
            exchange(&mut lead, n * MS, MS / 2, false);
            lead.look(n * MS, None);
            assert!(!lead.is_allowed(), "{n} ms");
        }
        lead.submitted(1023 * MS);
        assert_eq!(lead.look(1023 * MS, None), Some(1043 * MS));
        assert!(lead.is_allowed());
    }
}
