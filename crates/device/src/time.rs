//! §D/3 Milliseconds that wrap (ours): every comparison survives the wrap after 49.7 days.

/// A moment, milliseconds since some start; wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Millis(pub u32);

impl Millis {
    /// Milliseconds since an earlier moment, at most 49.7 days ago.
    pub const fn since(self, earlier: Self) -> u32 {
        self.0.wrapping_sub(earlier.0)
    }
}

/// Fires once after a time. Poll it at each step: then the wrap of the clock never matters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timer {
    deadline: Option<Millis>,
}

impl Timer {
    /// Does not run.
    pub const STOPPED: Self = Self { deadline: None };

    /// Starts, or starts again.
    pub fn start(&mut self, now: Millis, after_ms: u32) {
        self.deadline = Some(Millis(now.0.wrapping_add(after_ms)));
    }

    /// Fires after this time at the latest: what runs is not put off, nor what is over and not yet polled.
    pub fn hasten(&mut self, now: Millis, after_ms: u32) {
        let later = |ms: u32| ms > after_ms && ms <= 1 << 31;
        if self.deadline.is_none_or(|deadline| later(deadline.since(now))) {
            self.start(now, after_ms);
        }
    }

    /// Until it fires, ms; 0 of one that does not run.
    pub fn left_ms(&self, now: Millis) -> u32 {
        let left_ms = self.deadline.map_or(0, |deadline| deadline.since(now));
        if left_ms > 1 << 31 { 0 } else { left_ms }
    }

    /// Will not fire.
    pub fn stop(&mut self) {
        self.deadline = None;
    }

    /// Started and not yet fired.
    pub const fn is_running(&self) -> bool {
        self.deadline.is_some()
    }

    /// True once when the time is over.
    #[inline(never)]
    pub fn poll(&mut self, now: Millis) -> bool {
        let fired = self.deadline.is_some_and(|deadline| now.since(deadline) < 1 << 31);
        if fired {
            self.deadline = None;
        }
        fired
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// §D/3
    #[test]
    fn survives_the_wrap() {
        let mut timer = Timer::default();
        timer.start(Millis(u32::MAX - 10), 30);
        assert!(!timer.poll(Millis(u32::MAX)));
        assert!(!timer.poll(Millis(18)));
        assert!(timer.poll(Millis(19)));
        assert!(!timer.poll(Millis(20)));
        assert!(!timer.is_running());
    }

    /// §D/3 Hastened, also over the wrap, it is sooner or as it was.
    #[test]
    fn hastened() {
        for (first_ms, then_ms, fires_ms) in [(100, 30, 40), (100, 500, 100), (100, 90, 100)] {
            let start = Millis(u32::MAX - 20);
            let mut timer = Timer::default();
            timer.hasten(start, first_ms);
            timer.hasten(Millis(start.0.wrapping_add(10)), then_ms);
            let at = |ms: u32| Millis(start.0.wrapping_add(ms));
            assert!(!timer.poll(at(fires_ms - 1)), "{first_ms} {then_ms}");
            assert!(timer.poll(at(fires_ms)), "{first_ms} {then_ms}");
        }
        let mut over = Timer::default();
        over.start(Millis(0), 100);
        over.hasten(Millis(150), 100);
        assert!(over.poll(Millis(150)));
    }

    /// §D/3 What is left, also over the wrap, and of one that is over or does not run.
    #[test]
    fn what_is_left() {
        let mut timer = Timer::default();
        assert_eq!(timer.left_ms(Millis(5)), 0);
        timer.start(Millis(u32::MAX - 10), 30);
        assert_eq!(timer.left_ms(Millis(u32::MAX)), 20);
        assert_eq!(timer.left_ms(Millis(18)), 1);
        assert_eq!(timer.left_ms(Millis(19)), 0);
        assert_eq!(timer.left_ms(Millis(500)), 0);
    }

    /// §D/3 A time of half the clock's range, 24.8 days, is the longest: it is not over at once.
    #[test]
    fn longest_time() {
        let mut timer = Timer::default();
        timer.start(Millis(7), 1 << 31);
        assert!(!timer.poll(Millis(7)));
        assert!(!timer.poll(Millis(6 + (1 << 31))));
        assert!(timer.poll(Millis(7 + (1 << 31))));
    }
}
