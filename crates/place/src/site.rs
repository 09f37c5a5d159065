//! What an installation consists of: monitors, obstacles, keep-outs, water, wind.

use std::f64::consts::{PI, TAU};

use lafet_ballistics::{Jet, NARROWEST_MM};
use lafet_texts::place as text;
use serde::Serialize;

use crate::linear::wrapped;
use lafet_ballistics::DATM_MPA;

use crate::obstacle::Body;
use crate::supply::Supply;
use crate::text::{Problem, counted, within};
use crate::{FARTHEST_M, KEEP_OUTS_MAX, MONITORS_MAX, OBSTACLES_MAX};

/// A monitor is kept clear of jets from the ground to this far above its nozzle, m.
const ABOVE_NOZZLE_M: f64 = 0.5;

/// A monitor as it is mounted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Monitor {
    /// Its name.
    pub name: String,
    /// East and north, m.
    pub at: [f64; 2],
    /// Height of the nozzle above the ground, m.
    pub height_m: f64,
    /// Bearing of its azimuth 0, rad.
    pub heading: f64,
    /// Limits of its azimuth, rad, left positive: right and left.
    pub azimuths: [f64; 2],
    /// Limits of its elevation, rad.
    pub elevations: [f64; 2],
    /// Diameter of the outlet, mm.
    pub outlet_mm: f64,
    /// Position of the nozzle, mm: 60 narrowest.
    pub nozzle_mm: f64,
    /// K of its nozzle: flow at 1 MPa, l/min.
    pub k_lpm: f64,
    /// Speed of traverse and elevation, rad/s.
    pub speeds: [f64; 2],
}

/// For whom a zone or sector is kept clear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum For {
    /// People.
    People,
    /// Detectors.
    Detectors,
    /// Other equipment.
    Equipment,
}

/// What no jet may point into, or pass through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct KeepOut {
    /// For whom.
    pub of: For,
    /// Where.
    pub place: Kept,
}

/// The shape of a keep-out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kept {
    /// No jet passes through this body.
    Zone(Body),
    /// A barrel does not point into these directions.
    Sector {
        /// Index of the monitor; without it, all.
        monitor: Option<usize>,
        /// From and to which bearing, clockwise, rad.
        bearings: [f64; 2],
        /// From and to which elevation, rad.
        elevations: [f64; 2],
    },
}

/// A wind, 10 m above the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Wind {
    /// Bearing that it blows from, rad.
    pub from: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
}

/// An installation.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Its monitors.
    pub monitors: Vec<Monitor>,
    /// What is in the way.
    pub obstacles: Vec<Body>,
    /// What is kept clear.
    pub keep_outs: Vec<KeepOut>,
    /// Its water.
    pub supply: Supply,
    /// Around a monitor other jets keep this distance, m; 0 for none.
    pub clearance_m: f64,
}

/// Where a barrel points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Direction {
    /// Bearing, rad.
    pub bearing: f64,
    /// Elevation, rad.
    pub elevation: f64,
}

impl Monitor {
    /// Refuses what is no number or no monitor.
    pub fn check(&self) -> Result<(), Problem> {
        let far = -FARTHEST_M..=FARTHEST_M;
        for value in self.at {
            within(&text::MonitorPlace, value, far.clone())?;
        }
        let what = &text::NozzleHeight;
        within(what, self.height_m, 0.1..=200.0)?;
        within(&text::MonitorHeading, self.heading, -TAU..=TAU)?;
        for value in self.azimuths {
            within(&text::AzimuthLimit, value, -TAU..=TAU)?;
        }
        let steepest = 80.0_f64.to_radians() + 1e-9;
        for value in self.elevations {
            let what = &text::ElevationLimit;
            within(what, value, -steepest..=steepest)?;
        }
        let [right, left] = self.azimuths;
        let [lower, upper] = self.elevations;
        if right >= left || lower >= upper {
            return Err(Problem::new(text::LimitsReversed));
        }
        within(&text::Outlet, self.outlet_mm, 8.0..=100.0)?;
        let narrowest = f64::from(NARROWEST_MM);
        let what = &text::NozzlePosition;
        within(what, self.nozzle_mm, 0.0..=narrowest)?;
        within(&text::FlowAt1Mpa, self.k_lpm, 10.0..=50_000.0)?;
        for value in self.speeds {
            let what = &text::DriveSpeed;
            within(what, value, 0.001..=10.0)?;
        }
        Ok(())
    }

    /// Its jet at a pressure; none where there is no jet to speak of.
    pub fn jet(&self, pressure_mpa: f64) -> Option<Jet> {
        let datm = (pressure_mpa / DATM_MPA).round().clamp(0.0, f64::from(u16::MAX));
        let diameter_dmm = (self.outlet_mm * 10.0).round();
        Jet::new(datm as u16, diameter_dmm as i32, self.nozzle_mm.round() as i32).ok()
    }

    /// Flow at a pressure, l/min.
    pub fn flow_lpm(&self, pressure_mpa: f64) -> f64 {
        self.k_lpm * pressure_mpa.max(0.0).sqrt()
    }

    /// Whether it can point there at all.
    pub fn has(&self, direction: Direction) -> bool {
        let [lower, upper] = self.elevations;
        let slack = 1e-9;
        (lower - slack..=upper + slack).contains(&direction.elevation)
            && self.azimuth(direction.bearing).is_some()
    }

    /// The azimuth of a bearing within its limits; of several, the one nearest to 0.
    pub fn azimuth(&self, bearing: f64) -> Option<f64> {
        let azimuth = wrapped(self.heading - bearing);
        let [right, left] = self.azimuths;
        let turns = [azimuth, azimuth - TAU, azimuth + TAU];
        let inside = turns.into_iter().filter(|it| (right - 1e-9..=left + 1e-9).contains(it));
        inside.min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// What others keep clear of it.
    pub fn body(&self, clearance_m: f64) -> Body {
        let heights = [0.0, self.height_m + ABOVE_NOZZLE_M];
        Body::Cylinder { at: self.at, radius_m: clearance_m, heights }
    }
}

impl KeepOut {
    /// Refuses what is no number.
    pub fn check(&self, monitors: usize) -> Result<(), Problem> {
        match self.place {
            Kept::Zone(body) => body.check(),
            Kept::Sector { monitor, bearings, elevations } => {
                if monitor.is_some_and(|index| index >= monitors) {
                    return Err(Problem::new(text::SectorOfUnknownMonitor));
                }
                for value in bearings.into_iter().chain(elevations) {
                    within(&text::SectorAngle, value, -TAU..=TAU)?;
                }
                Ok(())
            }
        }
    }

    /// Whether a barrel of this monitor points into it.
    pub fn has(&self, of: usize, direction: Direction) -> bool {
        let Kept::Sector { monitor, bearings, elevations } = self.place else { return false };
        let [from, to] = bearings;
        let wide = if to - from >= TAU - 1e-9 { TAU } else { (to - from).rem_euclid(TAU) };
        monitor.is_none_or(|monitor| monitor == of)
            && (direction.bearing - from).rem_euclid(TAU) <= wide
            && (elevations[0]..=elevations[1]).contains(&direction.elevation)
    }
}

impl Wind {
    /// Refuses what is no number or no wind in which a jet is aimed.
    pub fn check(&self) -> Result<(), Problem> {
        within(&text::WindDirection, self.from, -TAU..=TAU)?;
        within(&text::WindSpeed, self.speed_mps, 0.0..=40.0)
    }

    /// Bearing that it blows to, rad.
    pub fn to(&self) -> f64 {
        wrapped(self.from + PI)
    }
}

impl Site {
    /// Refuses what is out of bounds, no number, or too much.
    pub fn check(&self) -> Result<(), Problem> {
        counted(&text::Monitors, self.monitors.len(), 1..=MONITORS_MAX)?;
        counted(&text::Obstacles, self.obstacles.len(), 0..=OBSTACLES_MAX)?;
        counted(&text::KeepOuts, self.keep_outs.len(), 0..=KEEP_OUTS_MAX)?;
        self.monitors.iter().try_for_each(Monitor::check)?;
        self.obstacles.iter().try_for_each(Body::check)?;
        self.keep_outs.iter().try_for_each(|it| it.check(self.monitors.len()))?;
        let what = &text::MonitorClearance;
        within(what, self.clearance_m, 0.0..=20.0)
    }

    /// Pressure that is left when so many monitors flow, the thirstiest ones, MPa.
    pub fn pressure_mpa(&self, flowing: usize) -> f64 {
        let mut all: Vec<f64> = self.monitors.iter().map(|monitor| monitor.k_lpm).collect();
        all.sort_by(|a, b| b.total_cmp(a));
        self.supply.left_mpa(all.iter().take(flowing).sum())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A monitor of 20 l/s at 0.8 MPa, looking north.
    pub fn monitor(east: f64, north: f64) -> Monitor {
        Monitor {
            name: format!("{east}/{north}"),
            at: [east, north],
            height_m: 2.0,
            heading: 0.0,
            azimuths: [-PI, PI],
            elevations: [-0.26, 1.3],
            outlet_mm: 28.0,
            nozzle_mm: 60.0,
            k_lpm: 1200.0 / 0.8_f64.sqrt(),
            speeds: [0.35, 0.2],
        }
    }

    pub fn site(monitors: Vec<Monitor>) -> Site {
        Site {
            monitors,
            obstacles: Vec::new(),
            keep_outs: Vec::new(),
            supply: Supply::constant(0.8).unwrap(),
            clearance_m: 1.0,
        }
    }

    pub fn sector(bearings: [f64; 2], elevations: [f64; 2]) -> KeepOut {
        KeepOut { of: For::People, place: Kept::Sector { monitor: None, bearings, elevations } }
    }

    #[test]
    fn sectors_run_clockwise_through_north() {
        let kept = sector([6.0, 0.5], [-1.0, 0.4]);
        let points = |bearing, elevation| kept.has(0, Direction { bearing, elevation });
        assert!(points(0.0, 0.0) && points(6.1, 0.0) && points(-0.1, 0.0) && points(0.4, 0.39));
        assert!(!points(0.6, 0.0) && !points(5.9, 0.0) && !points(0.0, 0.5));
        let round = sector([0.0, TAU], [0.0, 1.0]);
        assert!(round.has(3, Direction { bearing: 4.0, elevation: 0.5 }));
    }

    #[test]
    fn limits_are_azimuths() {
        let narrow = Monitor { heading: 1.0, azimuths: [-0.5, 1.2], ..monitor(0.0, 0.0) };
        assert_eq!(narrow.azimuth(1.4).map(|it| it < 0.0), Some(true));
        assert!(narrow.azimuth(1.6).is_none() && narrow.azimuth(-0.1).is_some());
        assert!(!narrow.has(Direction { bearing: 1.0, elevation: 1.4 }));
    }

    #[test]
    fn the_thirstiest_count() {
        let thirsty = Monitor { k_lpm: 3000.0, ..monitor(0.0, 0.0) };
        let supply = Supply::parabola(1.0, 3000.0, 0.8).unwrap();
        let site = Site { supply, ..site(vec![monitor(0.0, 0.0), thirsty]) };
        let alone = site.pressure_mpa(1);
        assert!((alone - site.supply.left_mpa(3000.0)).abs() < 1e-12);
        assert!(site.pressure_mpa(2) < alone);
    }

    #[test]
    fn no_numbers_and_too_many_are_refused() {
        assert_eq!(site(vec![monitor(0.0, 0.0)]).check(), Ok(()));
        assert!(site(Vec::new()).check().is_err());
        assert!(site(vec![monitor(0.0, 0.0); 65]).check().unwrap_err().0.ru.contains("стволов"));
        for wrong in [
            Monitor { at: [f64::NAN, 0.0], ..monitor(0.0, 0.0) },
            Monitor { height_m: f64::INFINITY, ..monitor(0.0, 0.0) },
            Monitor { elevations: [0.5, 0.2], ..monitor(0.0, 0.0) },
            Monitor { outlet_mm: 0.0, ..monitor(0.0, 0.0) },
            Monitor { speeds: [0.0, 1.0], ..monitor(0.0, 0.0) },
        ] {
            assert!(wrong.check().is_err(), "{wrong:?}");
        }
        assert!(Wind { from: f64::NAN, speed_mps: 1.0 }.check().is_err());
        assert!(Wind { from: 0.0, speed_mps: 41.0 }.check().is_err());
        let far = KeepOut {
            of: For::Detectors,
            place: Kept::Sector { monitor: Some(1), bearings: [0.0; 2], elevations: [0.0; 2] },
        };
        assert!(far.check(1).is_err());
    }
}
