//! The site as the planner and the coverage compute with it ([`lafet_place`]): metres, radians, MPa.

use lafet_place::Problem;
use lafet_place::obstacle::Body;
use lafet_place::site::{For, KeepOut as Kept, Kept as Shape, Monitor, Site as Planned};
use lafet_place::supply::Supply;
use lafet_proto::param::Param;

use super::keep_out::{KeepOut, KeptFor};
use super::{Place, Site, Tank, Wall};

/// Flow of an outlet of 28 mm at 0.8 MPa, l/min: no monitor says its own.
const USUAL_LPM: f64 = 1200.0;
const USUAL_MM: f64 = 28.0;
/// Pressure where none is known, MPa.
pub const USUAL_MPA: f64 = 0.8;
/// Around a monitor other jets keep this distance, m.
pub const CLEARANCE_M: f64 = 1.0;
/// A nozzle is never lower than this, and a wall as thick, m.
const LEAST_M: f64 = 0.1;
const WALL_M: f64 = 0.3;
/// Solutions of a flight are not looked for above this elevation, degrees.
const STEEPEST_DEG: f64 = 80.0;

/// What is known of a monitor besides its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Built {
    /// Limits of Horizontal, arc-minutes.
    pub azimuths: [i32; 2],
    /// Limits of Vertical, arc-minutes.
    pub elevations: [i32; 2],
    /// Outlet, 0.1 mm.
    pub outlet_dmm: i32,
    /// Position of the nozzle, mm.
    pub nozzle_mm: i32,
    /// Speeds of Horizontal and Vertical, °/s.
    pub speeds: [i32; 2],
}

impl Built {
    /// By its parameters.
    pub fn by(parameter: impl Fn(Param) -> i32) -> Self {
        Self {
            azimuths: [Param::HorizontalMinLimit, Param::HorizontalMaxLimit].map(&parameter),
            elevations: [Param::VerticalMinLimit, Param::VerticalMaxLimit].map(&parameter),
            outlet_dmm: parameter(Param::ControlNozzleDiameter),
            nozzle_mm: lafet_ballistics::NARROWEST_MM,
            speeds: [Param::HorizontalSpeed, Param::VerticalSpeed].map(&parameter),
        }
    }

    /// As monitors are delivered.
    pub fn as_delivered() -> Self {
        Self::by(|param| param.spec().default)
    }
}

/// The site with these monitors, in this order.
pub fn planned(site: &Site, monitors: &[(String, Place, Built)], supply: Supply) -> Planned {
    let tanks = site.tanks.iter().filter(|it| it.height >= LEAST_M).map(Tank::body);
    let walls = site.walls.iter().filter(|it| it.height >= LEAST_M).filter_map(Wall::body);
    let keep_outs = site.keep_outs.iter().filter_map(|it| kept(it, monitors));
    Planned {
        monitors: monitors.iter().map(monitor).collect(),
        obstacles: tanks.chain(walls).collect(),
        keep_outs: keep_outs.collect(),
        supply,
        clearance_m: CLEARANCE_M,
    }
}

/// Whether the planner can compute with a monitor: its place and its parameters are within what is usual.
pub fn is_plannable(it: &(String, Place, Built)) -> bool {
    monitor(it).check().is_ok()
}

/// Why the planner cannot compute with a monitor as delivered that is placed there.
pub fn check_place(place: &Place) -> Result<(), Problem> {
    monitor(&(String::new(), *place, Built::as_delivered())).check()
}

fn monitor((name, place, built): &(String, Place, Built)) -> Monitor {
    let arcmin = |limits: [i32; 2]| limits.map(|it| (f64::from(it) / 60.0).to_radians());
    let steepest = STEEPEST_DEG.to_radians();
    let outlet_mm = f64::from(built.outlet_dmm) / 10.0;
    Monitor {
        name: name.clone(),
        at: place.at,
        height_m: place.height.max(LEAST_M),
        heading: place.heading.to_radians(),
        azimuths: arcmin(built.azimuths),
        elevations: arcmin(built.elevations).map(|it| it.clamp(-steepest, steepest)),
        outlet_mm,
        nozzle_mm: f64::from(built.nozzle_mm),
        k_lpm: USUAL_LPM * (outlet_mm / USUAL_MM).powi(2) / USUAL_MPA.sqrt(),
        speeds: built.speeds.map(|it| f64::from(it).to_radians()),
    }
}

/// One for a monitor that is not among these is none.
fn kept(it: &KeepOut, monitors: &[(String, Place, Built)]) -> Option<Kept> {
    let of = match it.of {
        KeptFor::People => For::People,
        KeptFor::Detectors => For::Detectors,
        KeptFor::Equipment => For::Equipment,
    };
    let monitor = match &it.monitor {
        None => None,
        Some(id) => Some(monitors.iter().position(|(name, ..)| name == id)?),
    };
    let (bearings, elevations) = it.with_margin();
    let place = Shape::Sector {
        monitor,
        bearings: bearings.map(f64::to_radians),
        elevations: elevations.map(f64::to_radians),
    };
    Some(Kept { of, place })
}

impl Tank {
    /// Why the planner cannot compute with it.
    pub fn check_planned(&self) -> Result<(), Problem> {
        if self.height < LEAST_M { Ok(()) } else { self.body().check() }
    }

    fn body(&self) -> Body {
        let heights = [0.0, self.height];
        Body::Cylinder { at: self.at, radius_m: 0.5 * self.diameter, heights }
    }

    /// Whether a place in plan is on it.
    pub fn has(&self, at: [f64; 2]) -> bool {
        (at[0] - self.at[0]).hypot(at[1] - self.at[1]) <= 0.5 * self.diameter
    }
}

impl Wall {
    /// Why the planner cannot compute with it.
    pub fn check_planned(&self) -> Result<(), Problem> {
        let body = self.body().filter(|_| self.height >= LEAST_M);
        body.map_or(Ok(()), |body| body.check())
    }

    /// None without a length.
    fn body(&self) -> Option<Body> {
        let (east, north) = (self.to[0] - self.from[0], self.to[1] - self.from[1]);
        let (length, heading) = (east.hypot(north), east.atan2(north));
        let at = [0, 1].map(|axis| 0.5 * (self.from[axis] + self.to[axis]));
        let body = Body::Box { at, size: [length, WALL_M], heading, heights: [0.0, self.height] };
        (length >= LEAST_M).then_some(body)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn a_site_is_planned_in_the_units_of_the_planner() {
        let wall = Wall { name: "w".into(), from: [0.0, 5.0], to: [10.0, 5.0], height: 3.0 };
        let tank = Tank { name: "t".into(), at: [0.0, 40.0], diameter: 12.0, height: 9.0 };
        let flat = Tank { height: 0.0, ..tank.clone() };
        let sector = |monitor: &str| KeepOut {
            name: monitor.into(),
            of: KeptFor::People,
            monitor: Some(monitor.into()),
            bearings: [350.0, 20.0],
            elevations: [-90.0, 30.0],
        };
        let site = Site {
            tanks: vec![tank.clone(), flat],
            walls: vec![wall],
            keep_outs: vec![sector("M2"), sector("M9")],
            ..Site::default()
        };
        let place = |east| Place { at: [east, 0.0], heading: 90.0, height: 0.0 };
        let built = Built::as_delivered();
        let monitors = [("M1", 0.0), ("M2", 20.0)].map(|it| (it.0.to_owned(), place(it.1), built));
        let planned = planned(&site, &monitors, Supply::constant(USUAL_MPA).unwrap());
        assert_eq!(planned.check(), Ok(()));
        assert!((planned.monitors[1].flow_lpm(0.8) - 1200.0).abs() < 1e-9);
        assert!((planned.monitors[0].heading - FRAC_PI_2).abs() < 1e-9);
        let [Body::Cylinder { radius_m, .. }, Body::Box { at, heading, size, .. }] =
            &planned.obstacles[..]
        else {
            panic!("{:?}", planned.obstacles)
        };
        assert_eq!((*radius_m, *at, *size), (6.0, [5.0, 5.0], [10.0, WALL_M]));
        assert!((heading - FRAC_PI_2).abs() < 1e-9, "it runs east");
        let [kept] = &planned.keep_outs[..] else { panic!("that of M9 is none") };
        let north = |of, bearing: f64| {
            let (bearing, elevation) = (bearing.to_radians(), 0.2);
            kept.has(of, lafet_place::site::Direction { bearing, elevation })
        };
        assert!(north(1, 0.0) && north(1, 349.1) && north(1, 20.9) && !north(1, 21.1));
        assert!(!north(0, 0.0), "it is that of M2");
        assert!(tank.has([5.9, 40.0]) && !tank.has([6.1, 40.0]));
    }
}
