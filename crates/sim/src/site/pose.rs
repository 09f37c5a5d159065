//! Where a monitor is and where its azimuth 0 points, and what follows for everything else.

use crate::fire::Fire;
use crate::jet::Landing;

/// Where a monitor is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Place, m east and north.
    pub at: (f64, f64),
    /// Bearing of azimuth 0, degrees clockwise from north.
    pub heading_deg: f64,
}

impl Pose {
    /// A place as the monitor sees it: m forward and left.
    pub fn local(&self, place: (f64, f64)) -> (f64, f64) {
        self.turned((place.0 - self.at.0, place.1 - self.at.1))
    }

    /// A vector of the site (east, north) as the monitor sees it (forward, left).
    pub fn turned(&self, vector: (f64, f64)) -> (f64, f64) {
        let (sin, cos) = self.sin_cos();
        (vector.0 * sin + vector.1 * cos, vector.1 * sin - vector.0 * cos)
    }

    /// A place of the monitor's (forward, left) on the site.
    pub fn site(&self, local: (f64, f64)) -> (f64, f64) {
        let (sin, cos) = self.sin_cos();
        (self.at.0 + local.0 * sin - local.1 * cos, self.at.1 + local.0 * cos + local.1 * sin)
    }

    /// The monitor's azimuth of a bearing, −180…180°.
    pub fn azimuth_deg(&self, bearing_deg: f64) -> f64 {
        let azimuth = self.heading_deg - bearing_deg;
        azimuth - 360.0 * libm::round(azimuth / 360.0)
    }

    /// Where a jet of the monitor lands on the site.
    pub fn landing(&self, landing: Landing) -> Landing {
        let heading = landing.heading + (90.0 - self.heading_deg).to_radians();
        Landing { at: self.site(landing.at), heading, ..landing }
    }

    /// A fire of the site as the monitor sees it.
    pub fn fire(&self, fire: &Fire) -> Fire {
        let at = self.local(fire.at);
        let mut seen = fire.clone();
        seen.at = at;
        seen.spec.azimuth_deg = libm::atan2(at.1, at.0).to_degrees();
        seen.spec.range_m = libm::hypot(at.0, at.1);
        seen
    }

    fn sin_cos(&self) -> (f64, f64) {
        let heading = self.heading_deg.to_radians();
        (libm::sin(heading), libm::cos(heading))
    }
}
