//! Gusts: how the wind varies around its mean.
//!
//! Along the mean wind U and across it the speed departs from the mean by two independent
//! Ornstein-Uhlenbeck processes, du = −u·dt/T + σ·√(2/T)·dW, with σ = I·U along and 0.8·I·U across and
//! T = Λ/U, Λ = 60 m: the time in which an eddy drifts past. Spectrum S(f) = 4·σ²·T / (1 + (2π·f·T)²),
//! close to those that are measured near the ground (which fall with f^(−5/3), not f^(−2)). They
//! are stepped exactly, from a sequence of their own: gusts change nothing else that is random.
//!
//! I is the turbulence intensity: 0.15 over open country, 0.2–0.3 among buildings (ours, usual
//! figures). The 3 s gust over 10 minutes is then about 1 + 2.2·I times the mean (docs/physics.md).

use crate::rng::Rng;

/// Size of the eddies, m.
const EDDY_M: f64 = 60.0;
/// Intensity across the mean wind over that along it.
const ACROSS: f64 = 0.8;
/// What the seed of the world is changed by for the gusts' own sequence.
const SEED: u64 = 0x6775_7374;

/// The gusts of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct Gusts {
    /// Turbulence intensity I; 0 is a wind without gusts.
    pub intensity: f64,
    /// Departures along and across the mean wind, in their standard deviations.
    departure: (f64, f64),
    rng: Rng,
}

impl Gusts {
    /// Gusts that have blown for long.
    pub fn new(intensity: f64, seed: u64) -> Self {
        let mut rng = Rng::new(seed ^ SEED);
        let departure = (rng.noise(), rng.noise());
        Self { intensity, departure, rng }
    }

    /// Moves time around a mean wind, m/s.
    pub fn step(&mut self, mean: (f64, f64), dt_s: f64) {
        let speed = libm::hypot(mean.0, mean.1);
        if self.intensity <= 0.0 || speed <= 0.0 {
            return;
        }
        let keeps = libm::exp(-dt_s * speed / EDDY_M);
        let stirs = libm::sqrt(1.0 - keeps * keeps);
        let mut departed = |before: f64| keeps * before + stirs * self.rng.noise();
        self.departure = (departed(self.departure.0), departed(self.departure.1));
    }

    /// The wind at this moment around its mean, m/s.
    pub fn around(&self, mean: (f64, f64)) -> (f64, f64) {
        let along = 1.0 + self.intensity * self.departure.0;
        let across = ACROSS * self.intensity * self.departure.1;
        (mean.0 * along - mean.1 * across, mean.1 * along + mean.0 * across)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEAN: (f64, f64) = (3.0, -4.0);

    /// Mean, both deviations and the time that gusts last, over two hours.
    #[test]
    fn has_the_moments_it_claims() {
        let mut gusts = Gusts::new(0.2, 3);
        let (dt_s, count) = (0.1, 72_000);
        let mut along = Vec::new();
        let (mut sum, mut across) = ((0.0, 0.0), 0.0);
        for _ in 0..count {
            gusts.step(MEAN, dt_s);
            let wind = gusts.around(MEAN);
            sum = (sum.0 + wind.0, sum.1 + wind.1);
            along.push((wind.0 * 3.0 - wind.1 * 4.0) / 5.0 - 5.0);
            across += libm::pow((wind.0 * 4.0 + wind.1 * 3.0) / 5.0, 2.0);
        }
        let n = f64::from(count);
        assert!((sum.0 / n - 3.0).abs() < 0.15 && (sum.1 / n + 4.0).abs() < 0.15, "{sum:?}");
        let variance = along.iter().map(|u| u * u).sum::<f64>() / n;
        assert!((variance - 1.0).abs() < 0.15, "{variance}");
        assert!((across / n - 0.64).abs() < 0.1, "{across}");
        // One T later, 60 m / 5 m/s, a departure is forgotten to 1/e.
        let later = along.iter().zip(&along[120..]).map(|(a, b)| a * b).sum::<f64>() / n;
        assert!((later / variance - 0.37).abs() < 0.1, "{later}");
    }

    #[test]
    fn none_without_intensity_or_wind_and_the_same_for_a_seed() {
        let blow = |intensity, mean, seed| {
            let mut gusts = Gusts::new(intensity, seed);
            (0..100).for_each(|_| gusts.step(mean, 0.1));
            gusts.around(mean)
        };
        assert_eq!(blow(0.0, MEAN, 1), MEAN);
        assert_eq!(blow(0.3, (0.0, 0.0), 1), (0.0, 0.0));
        assert_eq!(blow(0.3, MEAN, 7), blow(0.3, MEAN, 7));
        assert_ne!(blow(0.3, MEAN, 7), blow(0.3, MEAN, 8));
    }
}
