//! Whether a motion by hand ends within half a second when whatever holds it is gone.

use std::time::Duration;

/// From this round trip on, MoveHold alone is half a second: two and a half round trips and 50 ms.
const SLOW: Duration = Duration::from_millis(180);
/// Below this one it is not; between them what was said stays.
const QUICK: Duration = Duration::from_millis(150);

/// What is known of it for a monitor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Holding {
    has_hold: Option<bool>,
    slow: bool,
}

impl Holding {
    /// The monitor has MoveHold, or has it not.
    pub const fn set_hold(&mut self, has_hold: bool) {
        self.has_hold = Some(has_hold);
    }

    /// Sets the round trip; returns whether that changes the result.
    pub fn set_round_trip(&mut self, round_trip: Duration) -> bool {
        let slow = round_trip >= if self.slow { QUICK } else { SLOW };
        std::mem::replace(&mut self.slow, slow) != slow
    }

    /// Whether it ends in time; `None`: that is not known yet.
    pub const fn is_bounded(self) -> Option<bool> {
        if self.slow { Some(false) } else { self.has_hold }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_move_hold_or_over_a_slow_line_it_does_not() {
        let mut holding = Holding::default();
        assert_eq!(holding.is_bounded(), None);
        holding.set_hold(false);
        assert_eq!(holding.is_bounded(), Some(false));
        holding.set_hold(true);
        assert_eq!(holding.is_bounded(), Some(true));
        let said = [100, 179, 180, 160, 151, 149, 179].map(|ms| {
            holding.set_round_trip(Duration::from_millis(ms));
            holding.is_bounded().unwrap()
        });
        assert_eq!(said, [true, true, false, false, false, true, true]);
        assert!(holding.set_round_trip(Duration::from_secs(1)));
        assert!(!holding.set_round_trip(Duration::from_secs(2)), "no news");
    }
}
