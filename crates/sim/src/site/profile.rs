//! How high water is on its way.

use crate::airborne::Portion;

/// Places on the way at which the height is known.
const POINTS: usize = 14;

/// The height of the water over its way: that of the middle of the jet, which also lands there.
pub struct Profile([(f64, f64); POINTS]);

impl Profile {
    /// The way of a portion, in parts of its range.
    pub fn of(portion: &Portion) -> Self {
        let flight_s = portion.landing.flight_s;
        let mut points = [(0.0, 0.0); POINTS];
        for (index, point) in (0..).zip(&mut points) {
            let part = f64::from(index) / (POINTS - 1) as f64;
            *point = portion.jet.after(part * flight_s);
        }
        // The mean of all water lands a little beside its middle.
        let (last_m, rest_m) = points[POINTS - 1];
        for (index, (way, height)) in (0..).zip(&mut points) {
            *way /= last_m.max(1e-9);
            *height -= rest_m * f64::from(index) / (POINTS - 1) as f64;
        }
        Self(points)
    }

    /// Height at a part of the way, m.
    pub fn height_m(&self, part: f64) -> f64 {
        let beyond = self.0.iter().position(|(way, _)| *way >= part);
        let beyond = beyond.unwrap_or(POINTS - 1).max(1);
        let ((from, low), (to, high)) = (self.0[beyond - 1], self.0[beyond]);
        low + (high - low) * ((part - from) / (to - from).max(1e-9)).clamp(0.0, 1.0)
    }

    /// Where the water falls to a height, between a part of the way where it is above and one
    /// where it is below.
    pub fn falls_to(&self, height_m: f64, above: f64, below: f64) -> f64 {
        let (mut above, mut below) = (above, below);
        for _ in 0..24 {
            let middle = f64::midpoint(above, below);
            if self.height_m(middle) < height_m {
                below = middle;
            } else {
                above = middle;
            }
        }
        below
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jet::Jet;

    /// Between the points it is as high as the jet itself, within 1.5 m: what lands is the mean of
    /// all water, what is followed its middle.
    #[test]
    fn follows_the_jet() {
        for degrees in [8.0_f64, 20.0, 35.0] {
            let jet = Jet::solid(0.8, 28.0, degrees.to_radians());
            let landing = jet.landing();
            let profile = Profile::of(&Portion { litres: 1.0, foam: 0.0, jet, landing });
            assert!(profile.height_m(1.0).abs() < 1e-9 && profile.height_m(0.0) == 1.5);
            for tenth in 1..10 {
                let (way, height) = jet.after(landing.flight_s * f64::from(tenth) / 10.0);
                let off = profile.height_m(way / landing.range_m()) - height;
                assert!(off.abs() < 1.5, "{degrees} {tenth}: {off}");
            }
        }
    }
}
