//! The wind over a site, 10 m above ground: one for all monitors, with the [gusts](crate::gust) of
//! a world. How much faster gusts are than the mean, 2.2 times their deviation, is what people say.

use crate::gust::Gusts;

/// The fastest gusts over their standard deviation.
const PEAK: f64 = 2.2;

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

impl WindSpec {
    /// The mean motion of the air, m/s east and north.
    fn mean_mps(&self) -> (f64, f64) {
        let from = self.from_deg.to_radians();
        (-self.speed_mps * libm::sin(from), -self.speed_mps * libm::cos(from))
    }
}

/// The wind.
#[derive(Clone, Debug)]
pub struct Wind {
    spec: WindSpec,
    gusts: Gusts,
}

impl Wind {
    /// A wind whose gusts follow from the seed.
    pub fn new(spec: WindSpec, seed: u64) -> Self {
        let mut wind = Self { spec, gusts: Gusts::new(0.0, seed) };
        wind.set(spec);
        wind
    }

    /// What it is.
    pub const fn spec(&self) -> WindSpec {
        self.spec
    }

    /// The wind changes.
    pub fn set(&mut self, spec: WindSpec) {
        self.spec = spec;
        self.gusts.intensity = spec.gusts_mps / PEAK / spec.speed_mps.max(0.1);
    }

    /// Runs for `dt_s`.
    pub fn step(&mut self, dt_s: f64) {
        self.gusts.step(self.spec.mean_mps(), dt_s);
    }

    /// The air's motion now, m/s east and north.
    pub fn now_mps(&self) -> (f64, f64) {
        self.gusts.around(self.spec.mean_mps())
    }
}
