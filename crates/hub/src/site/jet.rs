//! Where the jet of a monitor goes, and how high to aim it: the monitor's own law (§3.14,
//! `lafet-ballistics`), computed for those who draw it and for those who point on a plan.

use lafet_ballistics::{Fault, Jet, NARROWEST_MM, Solver, Target};
use lafet_proto::SubsystemId;
use lafet_proto::param::Param;
use lafet_texts::{Text as _, hub as text};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Site;
use super::struck::{Line, Profile, Struck};
use super::thrown::{NoThrow, Thrown, Wind, thrown};
use crate::error::ApiError;
use crate::hub::Hub;
use crate::monitor::station::Station;
use crate::sync::lock;

/// Most jets in one request.
pub const JETS_MAX: usize = 16;
/// Points of a flight in an answer, the nozzle and the landing included.
pub const POINTS_MAX: usize = 34;
/// No point but the first is nearer to the landing.
const APART_M: f32 = 0.05;
/// Steepest elevation of a flight, up and down, arc-minutes: 80°, as the monitor's own solver.
const STEEPEST_ARCMIN: i32 = 4800;
/// Elevations that are tried for the reach, degrees: the best one is always between these.
const REACH_DEG: std::ops::RangeInclusive<i32> = 8..=50;
const REACH_STEP_DEG: usize = 2;
/// More calls of the solver than any solution takes.
const CALLS_MAX: u32 = 5000;
/// Bounds of what is asked: levels as in the configuration, outlets as the parameter has them.
const HEIGHT_MAX_CM: i32 = 100_000;
const WAY_MAX_M: f32 = 1000.0;

/// Jets that are asked for.
#[derive(Debug, Deserialize, ToSchema)]
pub struct Jets {
    /// The jets to compute, at most 16.
    pub jets: Vec<Asked>,
}

/// A jet. What is not given is the monitor's present value.
#[derive(Clone, Debug, Default, Deserialize, ToSchema)]
#[schema(as = JetAsked)]
pub struct Asked {
    /// The monitor; without one, pressure, nozzle and height are needed.
    pub monitor: Option<String>,
    /// Pressure at the nozzle, 0.1 atm.
    pub pressure_datm: Option<u16>,
    /// Position of the nozzle, mm: 0 the widest cone, 60 the narrowest jet.
    pub nozzle_mm: Option<i32>,
    /// Outlet, 0.1 mm: parameter NozzleDiameter of Control; without a monitor as delivered.
    pub diameter_dmm: Option<i32>,
    /// Height of the nozzle above the ground, cm.
    pub height_cm: Option<i32>,
    /// Elevation of the barrel, arc-minutes.
    pub elevation_arcmin: Option<i32>,
    /// Horizontal position of the barrel, arc-minutes: what is in that direction ends the jet.
    pub horizontal_arcmin: Option<i32>,
    /// Flow, l/s, for `throw`; what is not measured is that of the outlet.
    pub flow_lps: Option<f32>,
    /// Wind, for `throw`; without it still air is assumed.
    pub wind: Option<Wind>,
}

/// What a jet was computed from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Basis {
    /// Pressure at the nozzle, 0.1 atm; `null` when the monitor has no valid value.
    #[schema(required)]
    pub pressure_datm: Option<u16>,
    /// Position of the nozzle, mm.
    pub nozzle_mm: i32,
    /// Diameter of the outlet, 0.1 mm.
    pub diameter_dmm: i32,
    /// Height of the nozzle above the ground, cm.
    pub height_cm: i32,
}

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum NoJet {
    /// The pressure is outside of what makes a jet: 1.0 … 25.0 atm.
    Pressure,
    /// The monitor has no valid pressure: give one.
    PressureUnknown,
    /// Farther than this jet reaches.
    Range,
    /// The elevation is above 80°.
    Angle,
    /// The monitor has no valid elevation: give one.
    ElevationUnknown,
}

/// A jet that was computed.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Computed {
    /// What it was computed from.
    #[serde(flatten)]
    pub basis: Basis,
    /// Elevation of the barrel, arc-minutes.
    #[schema(required)]
    pub elevation_arcmin: Option<i32>,
    /// The farthest that this jet lands with any elevation, m.
    #[schema(required)]
    pub reach_m: Option<f32>,
    /// The flight; null if there is no jet.
    #[schema(required)]
    pub flight: Option<Flight>,
    /// Why there is no flight.
    #[schema(required)]
    pub fault: Option<NoJet>,
    /// Where the water is expected to land, by published throws: independent of `flight`, which is the law
    /// by which the monitor aims.
    #[schema(required)]
    pub throw: Option<Thrown>,
    /// Why there is no throw.
    #[schema(required)]
    pub no_throw: Option<NoThrow>,
    /// The tank or wall that ends `flight` before it lands; null: none, or place or direction of the monitor are
    /// not known.
    #[schema(required)]
    pub strikes: Option<Struck>,
    /// The same of `throw`, whose figures end there.
    #[schema(required)]
    pub throw_strikes: Option<Struck>,
}

/// The flight of a jet.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Flight {
    /// Level distance from the nozzle, m; height above the nozzle, m; time from the nozzle, s. The
    /// first point is the nozzle, the last one the landing.
    #[schema(value_type = Vec<Vec<f32>>)]
    pub points: Vec<[f32; 3]>,
    /// Level distance of the landing, m.
    pub lands_m: f32,
    /// Path after which the jet has broken up, m.
    pub core_m: f32,
    /// Speed at the nozzle, m/s.
    pub speed_mps: f32,
}

/// A place that the jet is to hit.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
pub struct Aim {
    /// Level distance from the nozzle, m.
    pub way_m: f32,
    /// Height above the nozzle, m; negative below it.
    pub rise_m: f32,
    /// Pressure to assume instead of the monitor's, 0.1 atm.
    pub pressure_datm: Option<u16>,
}

/// The elevation that reaches the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Aimed {
    /// What it was computed from.
    #[serde(flatten)]
    pub basis: Basis,
    /// The lower of the elevations that hit the place, arc-minutes.
    #[schema(required)]
    pub elevation_arcmin: Option<i32>,
    /// Why there is no jet.
    #[schema(required)]
    pub fault: Option<NoJet>,
}

impl From<Fault> for NoJet {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Pressure => Self::Pressure,
            Fault::Range => Self::Range,
            Fault::Angle => Self::Angle,
        }
    }
}

impl Basis {
    fn jet(&self) -> Result<Jet, NoJet> {
        let pressure_datm = self.pressure_datm.ok_or(NoJet::PressureUnknown)?;
        Ok(Jet::new(pressure_datm, self.diameter_dmm, self.nozzle_mm)?)
    }

    fn height_m(&self) -> f32 {
        self.height_cm as f32 / 100.0
    }
}

/// Computes a jet at this elevation; without one, only its reach.
pub fn compute(
    basis: Basis,
    elevation_arcmin: Option<i32>,
    flow_lps: Option<f32>,
    wind: Option<Wind>,
) -> Computed {
    let jet = basis.jet();
    let flight = match (&jet, elevation_arcmin) {
        (Err(fault), _) => Err(*fault),
        (_, None) => Err(NoJet::ElevationUnknown),
        (_, Some(elevation)) if elevation.abs() > STEEPEST_ARCMIN => Err(NoJet::Angle),
        (Ok(jet), Some(elevation)) => Ok(flight(jet, elevation, basis.height_m())),
    };
    let reach_m = jet.ok().map(|jet| reach(&jet, basis.height_m()));
    let throw = thrown(&basis, elevation_arcmin, flow_lps, wind);
    Computed {
        basis,
        elevation_arcmin,
        reach_m,
        fault: flight.as_ref().err().copied(),
        flight: flight.ok(),
        no_throw: throw.err(),
        throw: throw.ok(),
        strikes: None,
        throw_strikes: None,
    }
}

impl Computed {
    /// Ends flight and throw at what is in their way.
    fn end_at(&mut self, site: &Site, from: [f64; 2], bearing: f64) {
        let (Ok(jet), Some(elevation), Some(flight)) =
            (self.basis.jet(), self.elevation_arcmin, &self.flight)
        else {
            return;
        };
        let height_m = self.basis.height_m();
        let path = jet.path(elevation, height_m).map(|it| [it.way_m, it.height_m]);
        let profile = Profile::of(std::iter::once([0.0; 2]).chain(path), height_m);
        let way_m = f64::from(flight.lands_m);
        self.strikes = site.strikes(Line { from, bearing, way_m }, &profile);
        let Some(throw) = &mut self.throw else { return };
        let left_m = f64::from(throw.left_m.value);
        let strikes = |way_m: f32| {
            let way_m = f64::from(way_m);
            let turn = if way_m > 0.0 { (left_m / way_m).clamp(-1.0, 1.0).asin() } else { 0.0 };
            site.strikes(Line { from, bearing: bearing - turn, way_m }, &profile)
        };
        self.throw_strikes = throw.end_at(strikes);
    }
}

/// Finds how high to aim at a place.
pub fn aim(basis: Basis, way_m: f32, rise_m: f32) -> Aimed {
    let solved = basis.jet().and_then(|jet| {
        let mut solver = Solver::new(jet, Target::at(way_m, rise_m, basis.height_cm));
        let solved = (0..CALLS_MAX).find_map(|_| solver.step());
        Ok(solved.unwrap_or(Err(Fault::Range))?)
    });
    Aimed { basis, elevation_arcmin: solved.ok(), fault: solved.err() }
}

fn flight(jet: &Jet, elevation_arcmin: i32, height_m: f32) -> Flight {
    let mut points = vec![[0.0; 3]];
    let (mut seconds, mut before) = (0.0, 0.0);
    for point in jet.path(elevation_arcmin, height_m) {
        seconds += (point.way_m - before) * point.slowness.sqrt();
        before = point.way_m;
        points.push([point.way_m, point.height_m, seconds]);
    }
    let last = points.len() - 1;
    // Short flights keep all their points, long ones as many as a picture needs.
    let every = last.div_ceil(POINTS_MAX - 1).max(1);
    let lands = points[last][0];
    let apart = |way: f32| lands - way > APART_M;
    let kept = points
        .iter()
        .enumerate()
        .filter(|(n, [way, ..])| *n == 0 || (n % every == 0 && apart(*way)) || *n == last);
    let cm = |metres: f32| (metres * 100.0).round() / 100.0;
    Flight {
        points: kept
            .map(|(_, [way, rise, at])| [cm(*way), cm(*rise), (at * 1e3).round() / 1e3])
            .collect(),
        lands_m: cm(lands),
        core_m: cm(jet.broken_up_after_m()),
        speed_mps: cm(jet.exit_speed_mps()),
    }
}

fn reach(jet: &Jet, height_m: f32) -> f32 {
    let ranges =
        REACH_DEG.step_by(REACH_STEP_DEG).map(|degrees| jet.range_of(degrees * 60, height_m));
    (ranges.fold(0.0, f32::max) * 100.0).round() / 100.0
}

impl Asked {
    /// Computes it from what is given, and for the rest from what the monitor has now.
    pub fn jet(&self, hub: &Hub) -> Result<Computed, ApiError> {
        let station = self.monitor.as_deref().map(|id| hub.station(id)).transpose()?;
        let live = station.as_deref().map(|station| present(hub, station));
        let missing = |name: &str| ApiError::bad_request(text::JetValueNeeded { name }.words());
        let of = |given: Option<i32>, live: Option<i32>, name: &str| {
            given.or(live).ok_or_else(|| missing(name))
        };
        let basis = live.map(|(basis, _)| basis);
        let all = Basis {
            pressure_datm: match (self.pressure_datm, basis) {
                (None, None) => return Err(missing("pressure_datm")),
                (given, basis) => given.or(basis.and_then(|basis| basis.pressure_datm)),
            },
            nozzle_mm: of(self.nozzle_mm, basis.map(|it| it.nozzle_mm), "nozzle_mm")?,
            diameter_dmm: self
                .diameter_dmm
                .or(basis.map(|it| it.diameter_dmm))
                .unwrap_or(Param::ControlNozzleDiameter.spec().default),
            height_cm: of(self.height_cm, basis.map(|it| it.height_cm), "height_cm")?
                .clamp(-HEIGHT_MAX_CM, HEIGHT_MAX_CM),
        };
        let elevation_arcmin = self.elevation_arcmin.or(live.and_then(|(_, elevation)| elevation));
        let flow_lps = self.flow_lps.or(station.as_deref().and_then(flow));
        let mut computed = compute(all, elevation_arcmin, flow_lps, self.wind);
        if let (Some(station), Some(site)) = (station.as_deref(), hub.map())
            && let Some(place) = site.monitors.get(station.id()).copied()
            && let Some(horizontal) = self.horizontal_arcmin.or_else(|| turned(station))
        {
            let bearing = (place.heading - f64::from(horizontal) / 60.0).to_radians();
            computed.end_at(&site, place.at, bearing);
        }
        Ok(computed)
    }
}

impl Aim {
    /// Computes it for a monitor.
    pub fn at(&self, hub: &Hub, station: &Station) -> Result<Aimed, ApiError> {
        let on_site = |metres: f32| metres.abs() <= WAY_MAX_M;
        if !(on_site(self.way_m) && on_site(self.rise_m) && self.way_m >= 0.0) {
            return Err(ApiError::bad_request(
                text::JetTargetRange { way_max_m: WAY_MAX_M }.words(),
            ));
        }
        let (live, _) = present(hub, station);
        let pressure_datm = self.pressure_datm.or(live.pressure_datm);
        Ok(aim(Basis { pressure_datm, ..live }, self.way_m, self.rise_m))
    }
}

/// What the monitor has now, and its elevation.
fn present(hub: &Hub, station: &Station) -> (Basis, Option<i32>) {
    let status = station.status();
    let valid = |id, field| status.valid(id, field).and_then(|value| i32::try_from(value).ok());
    let pressure = valid(SubsystemId::GENERAL, "pressure");
    let basis = Basis {
        pressure_datm: pressure.and_then(|datm| u16::try_from(datm).ok()),
        nozzle_mm: valid(SubsystemId::NOZZLE, "position").unwrap_or(NARROWEST_MM),
        diameter_dmm: parameter(station, Param::ControlNozzleDiameter),
        height_cm: hub
            .height_cm(station.id())
            .unwrap_or_else(|| parameter(station, Param::ControlHeight)),
    };
    (basis, valid(SubsystemId::VERTICAL, "position"))
}

/// How far the jet of a monitor reaches with its present pressure, m, a tenth of the throw left in hand; none
/// without a pressure that makes a jet.
pub fn reaches_m(hub: &Hub, station: &Station) -> Option<f32> {
    let (basis, _) = present(hub, station);
    let jet = basis.jet().ok()?;
    Some(0.9 * reach(&jet, basis.height_m()))
}

/// The horizontal position of a monitor, arc-minutes, while it is known.
fn turned(station: &Station) -> Option<i32> {
    let position = station.status().valid(SubsystemId::HORIZONTAL, "position")?;
    i32::try_from(position).ok()
}

/// The flow that the monitor measures, l/s, while there is one.
fn flow(station: &Station) -> Option<f32> {
    let flow_lps = station.status().valid(SubsystemId::GENERAL, "flowrate")?;
    (flow_lps > 0).then_some(flow_lps as f32)
}

/// A parameter as last read, else as delivered.
pub fn parameter(station: &Station, param: Param) -> i32 {
    let params = lock(&station.params);
    let read = params.of(param).and_then(|values| values.first().copied());
    read.unwrap_or(param.spec().default)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn basis(pressure_datm: u16, diameter_dmm: i32, nozzle_mm: i32, height_cm: i32) -> Basis {
        Basis { pressure_datm: Some(pressure_datm), nozzle_mm, diameter_dmm, height_cm }
    }

    /// The device solves for a line of sight and whole metres; asked for the same place, the hub
    /// gives the same minute of arc or the same fault.
    #[test]
    fn aims_as_the_device_does() {
        let (mut solved, mut refused) = (0, 0);
        for (pressure, diameter, nozzle) in [
            (9, 280, 60),
            (10, 280, 60),
            (40, 280, 60),
            (79, 280, 60),
            (79, 280, 30),
            (118, 500, 60),
        ] {
            for height_cm in [50, 150, 600] {
                for distance in (2..=80_u8).step_by(3) {
                    for sight in (-1800..=4800).step_by(450) {
                        let device = Jet::new(pressure, diameter, nozzle).and_then(|jet| {
                            let target = Target::new(sight, distance, height_cm);
                            let mut solver = Solver::new(jet, target);
                            (0..CALLS_MAX).find_map(|_| solver.step()).expect("bounded")
                        });
                        let angle = f64::from(sight).to_radians() / 60.0;
                        let way = f64::from(distance) * angle.cos();
                        let rise = f64::from(distance) * angle.sin();
                        let hub = aim(
                            basis(pressure, diameter, nozzle, height_cm),
                            way as f32,
                            rise as f32,
                        );
                        match (device, hub.elevation_arcmin) {
                            (Ok(device), Some(hub)) => {
                                assert!(device.abs_diff(hub) <= 1, "{distance} m {sight}'");
                                solved += 1;
                            }
                            (Err(fault), None) => {
                                assert_eq!(hub.fault, Some(fault.into()), "{distance} m {sight}'");
                                refused += 1;
                            }
                            (device, hub) => panic!("{distance} m {sight}': {device:?} {hub:?}"),
                        }
                    }
                }
            }
        }
        assert!(solved > 500 && refused > 500, "{solved} {refused}");
    }

    /// A jet that is aimed at a place lands there, over every point of its flight.
    #[test]
    fn what_is_aimed_lands() {
        for way in [8.0, 17.0, 28.0, 40.0_f32] {
            let from = basis(79, 280, 60, 600);
            let elevation = aim(from, way, -6.0).elevation_arcmin;
            let flight = compute(from, elevation, None, None).flight.expect("a flight");
            assert!((flight.lands_m - way).abs() < 0.1, "{way} m: {}", flight.lands_m);
            let (first, last) = (flight.points[0], flight.points[flight.points.len() - 1]);
            assert_eq!((first, last[0], last[1]), ([0.0; 3], flight.lands_m, -6.0));
            assert!(flight.points.len() <= POINTS_MAX);
            let rising =
                flight.points.windows(2).all(|two| two[0][0] < two[1][0] && two[0][2] < two[1][2]);
            assert!(rising, "{flight:?}");
            // Between the exit speed and that of what has broken up.
            let mean = way / last[2];
            assert!(mean > 5.0 && mean < flight.speed_mps, "{mean} m/s");
        }
    }

    /// The reach is the best range there is, and every missing value is named.
    #[test]
    fn reach_and_faults() {
        for (pressure, diameter, best) in [(40, 280, 37.0), (79, 280, 44.5), (79, 400, 60.7)] {
            let reach = compute(basis(pressure, diameter, 60, 150), Some(0), None, None).reach_m;
            let reach = reach.expect("a reach");
            assert!((reach - best).abs() < 0.6, "{reach}");
        }
        let fault = |basis, elevation| compute(basis, elevation, None, None).fault;
        assert_eq!(fault(basis(9, 280, 60, 150), Some(0)), Some(NoJet::Pressure));
        let unknown = Basis { pressure_datm: None, ..basis(79, 280, 60, 150) };
        assert_eq!(fault(unknown, Some(0)), Some(NoJet::PressureUnknown));
        assert_eq!(fault(basis(79, 280, 60, 150), None), Some(NoJet::ElevationUnknown));
        assert_eq!(fault(basis(79, 280, 60, 150), Some(4801)), Some(NoJet::Angle));
        assert_eq!(aim(unknown, 20.0, 0.0).fault, Some(NoJet::PressureUnknown));
    }
}
