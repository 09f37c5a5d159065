//! Detector stations and their bearings.

use lafet_texts::place as text;
use serde::{Deserialize, Serialize};

use crate::linear::{Vector, minus, wrapped};
use crate::text::{Problem, within};
use crate::{FARTHEST_M, Place};

/// Error added per second of age, rad: a fire spreads and its smoke moves. Ours.
pub const AGEING_PER_S: f64 = 0.000_873;
/// Bearings older than this are refused, ms.
pub const AGE_MAX_MS: u32 = 60_000;
/// Least quality of a bearing.
pub const QUALITY_MIN: f64 = 0.05;

/// A detector that gives bearings, as it is mounted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Station {
    /// Place of its optics.
    pub at: Place,
    /// Bearing of its azimuth 0, rad.
    pub heading: f64,
    /// How far its axis is tilted up, rad.
    #[serde(default)]
    pub pitch: f64,
    /// How far its left side is tilted up, rad.
    #[serde(default)]
    pub roll: f64,
    /// Standard error of the heading, rad.
    #[serde(default)]
    pub heading_sigma: f64,
    /// Standard error of pitch and roll, rad.
    #[serde(default)]
    pub tilt_sigma: f64,
    /// Standard error of its height, m.
    #[serde(default)]
    pub height_sigma_m: f64,
}

/// What a bearing was taken of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Radiation of a flame (UV, IR).
    Flame,
    /// A hot spot of a thermal camera.
    Heat,
    /// Flame or smoke in a picture.
    Picture,
    /// A person who points.
    Manual,
}

/// A bearing of a fire from a station.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bearing {
    /// Index of the station.
    pub station: usize,
    /// Azimuth, rad, positive to the left of the station's axis.
    pub azimuth: f64,
    /// Elevation, rad, if the detector measures it.
    pub elevation: Option<f64>,
    /// Standard error of both, rad.
    pub sigma: f64,
    /// How sure the detector is, 0.05…1; the error counts 1/√quality times.
    pub quality: f64,
    /// What it was taken of.
    pub kind: Kind,
    /// Age, ms.
    pub age_ms: u32,
}

impl Station {
    /// One that is mounted level and looks north, without an error of its mounting.
    pub const fn level(at: Place) -> Self {
        Self {
            at,
            heading: 0.0,
            pitch: 0.0,
            roll: 0.0,
            heading_sigma: 0.0,
            tilt_sigma: 0.0,
            height_sigma_m: 0.0,
        }
    }

    /// Refuses what is no number or beyond every installation.
    pub fn check(&self) -> Result<(), Problem> {
        let far = -FARTHEST_M..=FARTHEST_M;
        for value in self.at {
            within(&text::StationPlace, value, far.clone())?;
        }
        let turn = -std::f64::consts::TAU..=std::f64::consts::TAU;
        within(&text::StationHeading, self.heading, turn)?;
        for value in [self.pitch, self.roll] {
            within(&text::StationTilt, value, -1.6..=1.6)?;
        }
        let errors = [self.heading_sigma, self.tilt_sigma];
        for value in errors {
            let what = &text::StationAngleError;
            within(what, value, 0.0..=0.5)?;
        }
        let what = &text::StationHeightError;
        within(what, self.height_sigma_m, 0.0..=10.0)
    }

    /// The direction of an azimuth and elevation: east, north, up.
    pub fn direction(&self, azimuth: f64, elevation: f64) -> [f64; 3] {
        let forward = elevation.cos() * azimuth.cos();
        let left = elevation.cos() * azimuth.sin();
        let up = elevation.sin();
        let (sin, cos) = self.roll.sin_cos();
        let (left, up) = (left * cos - up * sin, up * cos + left * sin);
        let (sin, cos) = self.pitch.sin_cos();
        let (forward, up) = (forward * cos - up * sin, up * cos + forward * sin);
        let (sin, cos) = self.heading.sin_cos();
        [forward * sin - left * cos, forward * cos + left * sin, up]
    }

    /// Azimuth and elevation at which it sees a place, rad.
    pub fn sees(&self, place: Place) -> (f64, f64) {
        let [east, north, up] = minus(place, self.at);
        let (sin, cos) = self.heading.sin_cos();
        let (forward, left) = (east * sin + north * cos, north * sin - east * cos);
        let (sin, cos) = self.pitch.sin_cos();
        let (forward, up) = (forward * cos + up * sin, up * cos - forward * sin);
        let (sin, cos) = self.roll.sin_cos();
        let (left, up) = (left * cos + up * sin, up * cos - left * sin);
        (left.atan2(forward), up.atan2(forward.hypot(left)))
    }
}

impl Bearing {
    /// Refuses what is no number, too old, or of no station.
    pub fn check(&self, stations: usize) -> Result<(), Problem> {
        if self.station >= stations {
            let index = self.station;
            return Err(Problem::new(text::StationUnknown { station: index, stations }));
        }
        let turn = -std::f64::consts::TAU..=std::f64::consts::TAU;
        within(&text::Azimuth, self.azimuth, turn)?;
        let quarter = -std::f64::consts::FRAC_PI_2..=std::f64::consts::FRAC_PI_2;
        let elevation = self.elevation.unwrap_or_default();
        within(&text::Elevation, elevation, quarter)?;
        let what = &text::BearingError;
        within(what, self.sigma, 1e-5..=0.5)?;
        let what = &text::BearingQuality;
        within(what, self.quality, QUALITY_MIN..=1.0)?;
        let what = &text::BearingAge;
        within(what, f64::from(self.age_ms), 0.0..=f64::from(AGE_MAX_MS))
    }

    /// Its standard error as it counts, of azimuth and of elevation: with quality, age and mounting.
    pub(crate) fn errors(&self, station: &Station) -> (f64, f64) {
        let ageing = AGEING_PER_S * f64::from(self.age_ms) / 1000.0;
        let own = self.sigma * self.sigma / self.quality + ageing * ageing;
        let mounted = |sigma: f64| (own + sigma * sigma).sqrt();
        (mounted(station.heading_sigma), mounted(station.tilt_sigma))
    }

    /// Its line of sight.
    pub(crate) fn line(&self, station: &Station) -> Vector {
        station.direction(self.azimuth, self.elevation.unwrap_or_default())
    }

    /// How far the azimuth and elevation of a place are from it, rad.
    pub(crate) fn miss(&self, station: &Station, place: Place) -> (f64, Option<f64>) {
        let (azimuth, elevation) = station.sees(place);
        (wrapped(self.azimuth - azimuth), self.elevation.map(|own| own - elevation))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub fn station(x: f64, y: f64, height: f64) -> Station {
        Station::level([x, y, height])
    }

    pub fn bearing(station: usize, azimuth: f64, elevation: Option<f64>, sigma: f64) -> Bearing {
        Bearing { station, azimuth, elevation, sigma, quality: 1.0, kind: Kind::Flame, age_ms: 0 }
    }

    #[test]
    fn what_is_seen_lies_in_its_direction() {
        let tilted = Station { heading: 1.1, pitch: 0.2, roll: -0.1, ..station(3.0, -2.0, 6.0) };
        for place in [[20.0, 5.0, 0.0], [-10.0, 30.0, 9.0], [3.5, -40.0, 2.0]] {
            let (azimuth, elevation) = tilted.sees(place);
            let direction = tilted.direction(azimuth, elevation);
            let to = minus(place, tilted.at);
            let length = crate::linear::length(to);
            for (a, b) in direction.into_iter().zip(to) {
                assert!((a - b / length).abs() < 1e-12, "{place:?}");
            }
        }
    }

    /// Heading 90° looks east; to its left is north.
    #[test]
    fn azimuths_are_positive_to_the_left() {
        let east = Station { heading: std::f64::consts::FRAC_PI_2, ..station(0.0, 0.0, 0.0) };
        let (azimuth, _) = east.sees([10.0, 1.0, 0.0]);
        assert!((azimuth - 0.1_f64.atan()).abs() < 1e-12);
    }

    #[test]
    fn no_number_is_refused_in_words() {
        let wrong = Station { heading: f64::NAN, ..station(0.0, 0.0, 0.0) };
        let problem = wrong.check().unwrap_err();
        assert!(problem.0.en.contains("heading") && problem.0.ru.contains("курс"), "{problem}");
        assert!(station(f64::INFINITY, 0.0, 0.0).check().is_err());
        let good = bearing(1, 0.0, None, 0.003);
        assert_eq!(good.check(2), Ok(()));
        let wrong = [
            Bearing { station: 2, ..good },
            Bearing { azimuth: f64::NAN, ..good },
            Bearing { elevation: Some(f64::NAN), ..good },
            Bearing { sigma: 0.0, ..good },
            Bearing { quality: 0.0, ..good },
            Bearing { age_ms: AGE_MAX_MS + 1, ..good },
        ];
        for bearing in wrong {
            assert!(bearing.check(2).is_err(), "{bearing:?}");
        }
    }

    #[test]
    fn poor_old_and_badly_mounted_bearings_count_less() {
        let plain = bearing(0, 0.0, None, 0.003);
        let here = station(0.0, 0.0, 0.0);
        assert!((plain.errors(&here).0 - 0.003).abs() < 1e-12);
        let poor = Bearing { quality: 0.25, ..plain };
        assert!((poor.errors(&here).0 - 0.006).abs() < 1e-12);
        let old = Bearing { age_ms: 10_000, ..plain };
        assert!(old.errors(&here).0 > 0.009);
        let loose = Station { heading_sigma: 0.004, ..here };
        assert!((plain.errors(&loose).0 - 0.005).abs() < 1e-12);
    }
}
