//! Measuring at rest: the mean of several pictures, for analysis (§3.16/6) and alignment (§3.13/1).

use super::hotbeds::centre;
use crate::time::{Millis, Timer};
use lafet_proto::status::Hotbed;

/// Pictures that make a measurement: the noise of one is divided by four.
const COUNT: u8 = 16;
/// Time from picture to picture, ms: the detector has made a new one by then.
const PICTURE_MS: u32 = 40;
/// Three times as many that do not make one: there is nothing to measure.
const COUNT_MOST: u8 = 51;

/// What has been measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measured {
    pub mean: Hotbed,
    /// Widest distance of the pictures' middles, arc-minutes.
    pub scatter: i32,
}

/// Pictures so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Samples {
    count: u8,
    /// Pictures that were looked at.
    looked: u8,
    sums: [i64; 5],
    /// Right, left, bottom, top of the middles.
    range: [i32; 4],
    picture: Timer,
}

impl Samples {
    /// Begins after a time to settle.
    pub(super) fn after(now: Millis, settle_ms: u32) -> Self {
        let mut samples = Self {
            count: 0,
            looked: 0,
            sums: [0; 5],
            range: [i32::MAX, i32::MIN, i32::MAX, i32::MIN],
            picture: Timer::default(),
        };
        samples.picture.start(now, settle_ms);
        samples
    }

    /// Takes a picture when it is time to; the measurement, or `Some(None)` when there is none.
    pub(super) fn step(
        &mut self,
        now: Millis,
        picture: &mut dyn FnMut() -> Option<Hotbed>,
    ) -> Option<Option<Measured>> {
        if self.picture.poll(now) {
            self.picture.start(now, PICTURE_MS);
            self.looked += 1;
            if let Some(seen) = picture() {
                self.add(&seen);
            }
        }
        if self.count >= COUNT {
            return Some(Some(self.measured()));
        }
        (self.looked >= COUNT_MOST).then_some(None)
    }

    /// Some of the pictures have shown it.
    pub(super) const fn have_shown(&self) -> bool {
        self.count > 0
    }

    fn add(&mut self, seen: &Hotbed) {
        for (sum, value) in self.sums.iter_mut().zip(seen.to_values()) {
            *sum += i64::from(value);
        }
        let middle = centre(seen);
        let [right, left, bottom, top] = &mut self.range;
        *right = middle.horizontal.min(*right);
        *left = middle.horizontal.max(*left);
        *bottom = middle.vertical.min(*bottom);
        *top = middle.vertical.max(*top);
        self.count += 1;
    }

    fn measured(&self) -> Measured {
        const ALL: i64 = COUNT as i64;
        // Rounded to the nearest, below zero too; a mean of i32 is one.
        let mean = self.sums.map(|sum| (2 * sum + ALL).div_euclid(2 * ALL) as i32);
        let [right, left, bottom, top] = self.range;
        let scatter = left.saturating_sub(right).max(top.saturating_sub(bottom));
        Measured { mean: Hotbed::from_values(mean), scatter }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(h: i32) -> Hotbed {
        Hotbed { x1: h + 10, x2: h - 10, y1: -110, y2: -90, brightness: 500 + h }
    }

    #[test]
    fn mean_and_scatter() {
        let mut samples = Samples::after(Millis(0), 300);
        let mut pictures = 0;
        let done = (0..5000).find_map(|ms| {
            let done = samples.step(Millis(ms), &mut || {
                pictures += 1;
                Some(spot(if pictures % 2 == 0 { 3 } else { -2 }))
            });
            done.map(|done| (ms, done))
        });
        let (ms, measured) = done.unwrap();
        assert_eq!((pictures, ms), (16, 300 + 15 * 40));
        let measured = measured.unwrap();
        let mean = Hotbed { x1: 11, x2: -9, y1: -110, y2: -90, brightness: 501 };
        assert_eq!(measured, Measured { mean, scatter: 5 });
    }

    #[test]
    fn nothing_to_measure() {
        let mut samples = Samples::after(Millis(0), 300);
        let mut pictures = 0;
        let done = (0..5000).find(|ms| {
            let done = samples.step(Millis(*ms), &mut || {
                pictures += 1;
                (pictures < 16).then(|| spot(0))
            });
            assert!(done.is_none() || done == Some(None));
            done.is_some()
        });
        assert_eq!(done, Some(2300));
    }
}
