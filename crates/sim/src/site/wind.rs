//! The wind over a site: a mean, and gusts around it.
//!
//! Gusts are a random walk that returns to the mean within about 4 s (an Ornstein–Uhlenbeck
//! process), of speed and of direction; `gusts` is how far the speed goes up at most times (two
//! standard deviations). Ours: for training, no measured spectrum.

use crate::rng::Rng;

const RETURN_S: f64 = 4.0;
/// Swing of the direction when gusts are as strong as the wind, radians.
const SWING: f64 = 0.4;

/// What the wind is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WindSpec {
    /// Bearing that it comes from, degrees.
    pub from_deg: f64,
    /// Mean speed, m/s.
    pub speed_mps: f64,
    /// How much faster gusts are, m/s.
    pub gusts_mps: f64,
}

/// The wind.
#[derive(Clone, Debug)]
pub struct Wind {
    /// What it is now.
    pub spec: WindSpec,
    rng: Rng,
    /// Gust and swing, standard deviations.
    gust: (f64, f64),
}

impl Wind {
    /// A wind whose gusts follow from the seed.
    pub fn new(spec: WindSpec, seed: u64) -> Self {
        // Another sequence than that of the first monitor.
        Self { spec, rng: Rng::new(!seed), gust: (0.0, 0.0) }
    }

    /// Runs for `dt_s`.
    pub fn step(&mut self, dt_s: f64) {
        let (keep, fresh) = (1.0 - dt_s / RETURN_S, libm::sqrt(2.0 * dt_s / RETURN_S));
        self.gust.0 = self.gust.0 * keep + fresh * self.rng.noise();
        self.gust.1 = self.gust.1 * keep + fresh * self.rng.noise();
    }

    /// Speed and bearing that it comes from now: m/s, degrees.
    pub fn now(&self) -> (f64, f64) {
        let WindSpec { from_deg, speed_mps, gusts_mps } = self.spec;
        let speed = (speed_mps + gusts_mps / 2.0 * self.gust.0).max(0.0);
        let swing = SWING / 2.0 * self.gust.1 * gusts_mps / speed_mps.max(gusts_mps).max(1e-9);
        (speed, from_deg + swing.to_degrees())
    }

    /// The air's motion now, m/s east and north.
    pub fn now_mps(&self) -> (f64, f64) {
        let (speed, from_deg) = self.now();
        let from = from_deg.to_radians();
        (-speed * libm::sin(from), -speed * libm::cos(from))
    }
}
