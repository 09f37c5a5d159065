//! How far a jet throws: middle and greatest reach, top and time of flight, each with a band.
//!
//! The jet is that of [`crate::lumps`]. A band is the figure times the least and the greatest ratio of a published
//! figure to the computed one, over rows that were kept out of the fit (`lafet-verify`, tables in docs/physics.md).
//! It is wider for sprays and in wind, of which no row is known: by shares that are ours.

use crate::lumps::Jet;
use crate::nozzle::{self, Family, MAKERS, MONITOR, NOZZLE_TRAVEL_MM, SMOOTH_BORE};

/// Pressures at the nozzle for which the law holds, MPa.
pub const PRESSURE_MPA: [f64; 2] = [0.2, 2.0];
/// Outlets for which it holds, mm.
pub const OUTLET_MM: [f64; 2] = [12.0, 80.0];
/// Elevations, degrees.
pub const ELEVATION_DEG: [f64; 2] = [-15.0, 80.0];
/// Heights of the nozzle above the ground on which the water lands, m.
pub const HEIGHT_M: [f64; 2] = [0.0, 50.0];
/// Winds 10 m above the ground, m/s.
pub const WIND_MPS: [f64; 2] = [0.0, 20.0];

/// Part by which a flow at a limit may be rounded: published ones have two digits.
const FLOW_ROUNDED: f64 = 0.01;
/// Elevations of the rows that state one, degrees.
const ROWS_DEG: [f64; 2] = [20.0, 45.0];
/// Part of what the wind changes by which a band is wider.
const WIND_SHARE: f64 = 1.0 / 3.0;
/// How much wider a band is by the width of the spray, and at most.
const SPRAY_SHARE: f64 = 0.5;
const SPRAY_SHARE_MAX: f64 = 1.0 / 3.0;

/// Kind of a nozzle. The two differ in how coherent the jet is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A monitor with an adjustable nozzle, as its makers state the reach.
    Monitor,
    /// A smooth bore behind a straight barrel: hand nozzles, water cannons.
    Smooth,
}

/// How large a nozzle is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// What flows through it, l/s.
    Flow(f64),
    /// Its outlet, mm.
    Outlet(f64),
}

/// A jet to compute the throw of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Kind of the nozzle.
    pub kind: Kind,
    /// How large it is.
    pub size: Size,
    /// Pressure at the nozzle, MPa.
    pub pressure_mpa: f64,
    /// Position of an adjustable nozzle, mm: 0 widest … 60 narrowest.
    pub nozzle_mm: f64,
    /// Elevation, degrees.
    pub elevation_deg: f64,
    /// Height of the nozzle above the ground on which the water lands, m.
    pub height_m: f64,
    /// Wind 10 m above the ground, m/s.
    pub wind_mps: f64,
    /// Where the wind comes from, degrees clockwise from the direction of the jet: 0 is against it.
    pub wind_from_deg: f64,
}

/// A figure and the band in which it is expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// As computed.
    pub value: f64,
    /// Lower end of the band.
    pub low: f64,
    /// Upper end of the band.
    pub high: f64,
}

/// The throw of a jet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throw {
    /// Outlet, mm.
    pub outlet_mm: f64,
    /// Flow, l/s.
    pub flow_lps: f64,
    /// Distance to the middle of the wetted ground, m.
    pub middle_m: Figure,
    /// Distance to where the outermost water lands, m.
    pub greatest_m: Figure,
    /// Highest water above the ground, m.
    pub top_m: Figure,
    /// Time of flight of the middle, s.
    pub flight_s: Figure,
    /// How far the wind carries the middle to the left of the jet's direction, m.
    pub left_m: Figure,
    /// Half of the width of the wetted ground, m.
    pub across_m: f64,
    /// What the bands do not cover.
    pub notes: [Option<Note>; NOTES],
}

/// What no row covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Note {
    /// The pressure or the outlet.
    Pressure,
    /// The elevation.
    Elevation,
    /// The middle and the top of a monitor's jet.
    Monitor,
    /// A spray.
    Spray,
    /// Wind.
    Wind,
}

/// Number of the notes.
pub const NOTES: usize = 5;

/// A value of a shot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    /// Pressure, MPa.
    Pressure,
    /// Outlet, mm.
    Outlet,
    /// Flow, l/s.
    Flow,
    /// Position of the nozzle, mm.
    Nozzle,
    /// Elevation, degrees.
    Elevation,
    /// Height of the nozzle, m.
    Height,
    /// Speed of the wind, m/s.
    Wind,
    /// Direction of the wind, degrees.
    WindDirection,
}

/// Why there is no throw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// A value is outside of the range for which the law holds.
    Outside {
        /// Which.
        what: Value,
        /// What was given.
        value: f64,
        /// The range.
        range: [f64; 2],
    },
    /// A smooth bore has one position of the nozzle.
    NoSpray,
}

/// Published over computed, least and greatest.
pub type Band = [f64; 2];

/// Band of the middle of the water of smooth bores.
pub const SMOOTH_MIDDLE: Band = [0.91, 1.10];
/// Band of the greatest reach of smooth bores.
pub const SMOOTH_GREATEST: Band = [0.81, 1.10];
/// Band of the highest water of smooth bores.
pub const SMOOTH_TOP: Band = [0.93, 1.12];
/// Band of the greatest reach of monitors.
pub const MONITOR_GREATEST: Band = [0.90, 1.09];

impl Kind {
    /// Its jet.
    pub const fn family(self) -> Family {
        match self {
            Self::Monitor => MAKERS,
            Self::Smooth => SMOOTH_BORE,
        }
    }

    /// Bands of middle, greatest reach and top. No row states the middle or the top of a monitor's jet: its bands
    /// are those of smooth bores, wider by that of its greatest reach.
    fn bands(self) -> [Band; 3] {
        match self {
            Self::Smooth => [SMOOTH_MIDDLE, SMOOTH_GREATEST, SMOOTH_TOP],
            Self::Monitor => [
                both_of(SMOOTH_MIDDLE, MONITOR_GREATEST),
                MONITOR_GREATEST,
                both_of(SMOOTH_TOP, MONITOR_GREATEST),
            ],
        }
    }

    /// Pressures, MPa, and outlets, mm, of the rows of this kind.
    const fn rows(self) -> [[f64; 2]; 2] {
        match self {
            Self::Monitor => [[0.8, 1.4], [26.0, 73.0]],
            Self::Smooth => [[0.2, 2.0], [12.0, 29.0]],
        }
    }
}

fn both_of(a: Band, b: Band) -> Band {
    [a[0] * b[0], a[1] * b[1]]
}

impl Shot {
    /// Computes the throw; an error says which value is out of the range of the law.
    pub fn throw(&self) -> Result<Throw, Refusal> {
        let jet = self.jet()?;
        let still = Jet { wind: (0.0, 0.0), ..jet };
        let (landing, calm) = (jet.landing(), still.landing());
        let spray = (SPRAY_SHARE * nozzle::width(jet.spray_mm)).min(SPRAY_SHARE_MAX);
        let figure = |value: f64, calm: f64, band: Band| {
            let wind = WIND_SHARE * (value - calm).abs();
            let low = (value * band[0] * (1.0 - spray) - wind).max(0.0);
            Figure { value, low, high: value * band[1] * (1.0 + spray) + wind }
        };
        let [middle, greatest, top] = self.kind.bands();
        Ok(Throw {
            outlet_mm: jet.nozzle_mm,
            flow_lps: jet.family.flow_lps(jet.nozzle_mm, jet.pressure_mpa),
            middle_m: figure(landing.range_m(), calm.range_m(), middle),
            greatest_m: figure(jet.reach_m(), still.reach_m(), greatest),
            top_m: figure(jet.top_m(), still.top_m(), top),
            // The time of a fall grows with the root of the height.
            flight_s: figure(landing.flight_s, calm.flight_s, top.map(libm::sqrt)),
            left_m: aside(landing.at.1),
            across_m: landing.across_m,
            notes: self.notes(&jet),
        })
    }

    /// Where the simulator's own monitor, after which `lafet coverage` and the aim are made, has its middle, m.
    pub fn simulator_m(&self) -> Result<f64, Refusal> {
        let jet = self.jet()?;
        Ok(Jet { family: MONITOR, ..jet }.landing().range_m())
    }

    fn jet(&self) -> Result<Jet, Refusal> {
        let Self { kind, pressure_mpa, nozzle_mm, elevation_deg, height_m, wind_mps, .. } = *self;
        within(Value::Pressure, pressure_mpa, PRESSURE_MPA)?;
        let family = kind.family();
        let outlet_mm = match self.size {
            Size::Outlet(outlet_mm) => {
                within(Value::Outlet, outlet_mm, OUTLET_MM)?;
                outlet_mm
            }
            Size::Flow(flow_lps) => {
                let limits = OUTLET_MM.map(|mm| family.flow_lps(mm, pressure_mpa));
                let [least, most] = limits;
                let rounded = [least * (1.0 - FLOW_ROUNDED), most * (1.0 + FLOW_ROUNDED)];
                if outside(flow_lps, rounded) {
                    within(Value::Flow, flow_lps, limits)?;
                }
                let [least, most] = OUTLET_MM;
                family.outlet_mm(flow_lps, pressure_mpa).clamp(least, most)
            }
        };
        within(Value::Nozzle, nozzle_mm, [0.0, NOZZLE_TRAVEL_MM])?;
        if kind == Kind::Smooth && nozzle_mm < NOZZLE_TRAVEL_MM {
            return Err(Refusal::NoSpray);
        }
        within(Value::Elevation, elevation_deg, ELEVATION_DEG)?;
        within(Value::Height, height_m, HEIGHT_M)?;
        within(Value::Wind, wind_mps, WIND_MPS)?;
        within(Value::WindDirection, self.wind_from_deg, [-360.0, 360.0])?;
        let from = self.wind_from_deg.to_radians();
        Ok(Jet {
            family,
            pressure_mpa,
            nozzle_mm: outlet_mm,
            spray_mm: nozzle_mm,
            azimuth: 0.0,
            elevation: elevation_deg.to_radians(),
            height_m,
            wind: (-wind_mps * libm::cos(from), wind_mps * libm::sin(from)),
        })
    }

    /// What of this shot no row covers.
    fn notes(&self, jet: &Jet) -> [Option<Note>; NOTES] {
        let [pressures, outlets] = self.kind.rows();
        let pressure = outside(jet.pressure_mpa, pressures) || outside(jet.nozzle_mm, outlets);
        [
            pressure.then_some(Note::Pressure),
            outside(self.elevation_deg, ROWS_DEG).then_some(Note::Elevation),
            (self.kind == Kind::Monitor).then_some(Note::Monitor),
            (self.nozzle_mm < NOZZLE_TRAVEL_MM).then_some(Note::Spray),
            (self.wind_mps > 0.0).then_some(Note::Wind),
        ]
    }
}

/// What the wind does to the side, with the same share of doubt as in a band.
fn aside(left_m: f64) -> Figure {
    let doubt = WIND_SHARE * left_m.abs();
    Figure { value: left_m, low: left_m - doubt, high: left_m + doubt }
}

fn outside(value: f64, [least, most]: [f64; 2]) -> bool {
    !(least..=most).contains(&value)
}

fn within(what: Value, value: f64, range: [f64; 2]) -> Result<(), Refusal> {
    let [least, most] = range;
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(Refusal::Outside { what, value, range })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shot(kind: Kind, flow_lps: f64, pressure_mpa: f64) -> Shot {
        Shot {
            kind,
            size: Size::Flow(flow_lps),
            pressure_mpa,
            nozzle_mm: NOZZLE_TRAVEL_MM,
            elevation_deg: 30.0,
            height_m: 1.5,
            wind_mps: 0.0,
            wind_from_deg: 0.0,
        }
    }

    #[test]
    fn figures_lie_in_their_bands_and_in_order() {
        for (kind, flow, pressure) in
            [(Kind::Monitor, 20.0, 0.8), (Kind::Monitor, 150.0, 1.0), (Kind::Smooth, 20.0, 2.0)]
        {
            for elevation_deg in [-10.0, 0.0, 20.0, 45.0, 80.0] {
                let throw = Shot { elevation_deg, ..shot(kind, flow, pressure) }.throw().unwrap();
                for it in [throw.middle_m, throw.greatest_m, throw.top_m, throw.flight_s] {
                    assert!(0.0 < it.low && it.low < it.value && it.value < it.high, "{throw:?}");
                }
                assert!(
                    throw.greatest_m.value > throw.middle_m.value - 1e-9
                        && throw.left_m.value == 0.0
                );
                assert!((throw.flow_lps - flow).abs() < 1e-9 && throw.flight_s.value < 14.9);
            }
        }
        let throw = shot(Kind::Monitor, 20.0, 0.8).throw().unwrap();
        assert!((throw.outlet_mm - 28.0).abs() < 0.01, "{throw:?}");
        assert!((throw.greatest_m.value - 41.4).abs() < 0.3, "{throw:?}");
        assert!((throw.middle_m.value - 34.7).abs() < 0.3, "{throw:?}");
    }

    /// Against the jet, with it, and from the right; the band is wider than in still air.
    #[test]
    fn wind() {
        let still = shot(Kind::Monitor, 20.0, 0.8);
        let of = |wind_from_deg| Shot { wind_mps: 5.0, wind_from_deg, ..still }.throw().unwrap();
        let (calm, against, with, right) = (still.throw().unwrap(), of(0.0), of(180.0), of(90.0));
        assert!(against.middle_m.value < calm.middle_m.value - 2.0, "{against:?}");
        assert!(with.greatest_m.value > calm.greatest_m.value + 2.0, "{with:?}");
        let (left, from_left) = (right.left_m, of(270.0).left_m);
        assert!(left.value > 1.0 && (from_left.value + left.value).abs() < 1e-9);
        assert!(left.low > 0.0 && (left.high + from_left.low).abs() < 1e-9, "{from_left:?}");
        let width = |it: Figure| (it.high - it.low) / it.value;
        assert!(width(against.middle_m) > width(calm.middle_m) + 0.02);
        assert_eq!((calm.notes[4], against.notes[4]), (None, Some(Note::Wind)));
    }

    #[test]
    fn sprays_are_nearer_and_less_certain() {
        let solid = shot(Kind::Monitor, 20.0, 0.8);
        let spray = Shot { nozzle_mm: 40.0, ..solid };
        let (solid, spray) = (solid.throw().unwrap(), spray.throw().unwrap());
        assert!(spray.greatest_m.value < 0.8 * solid.greatest_m.value, "{spray:?}");
        let width = |it: Figure| (it.high - it.low) / it.value;
        assert!(width(spray.middle_m) > width(solid.middle_m) + 0.2, "{spray:?}");
    }

    /// The published flow of the smallest hand nozzle is rounded: 12 mm let 3.604 l/s through at 0.54 MPa.
    #[test]
    fn a_published_flow_is_not_refused_for_its_rounding() {
        let throw = Shot { height_m: 1.0, ..shot(Kind::Smooth, 3.6, 0.54) }.throw().unwrap();
        assert_eq!((throw.outlet_mm, throw.notes[0]), (12.0, None));
        let Figure { low, high, .. } = throw.middle_m;
        assert!(low < 28.0 && 28.0 < high, "{throw:?}");
        assert!(shot(Kind::Smooth, 3.5, 0.54).throw().is_err());
    }

    #[test]
    fn at_the_limits_themselves_it_holds() {
        let good = shot(Kind::Monitor, 20.0, 0.8);
        for size in [Size::Outlet(80.0), Size::Flow(MAKERS.flow_lps(80.0, 0.8))] {
            assert!(Shot { size, ..good }.throw().is_ok(), "{size:?}");
        }
    }

    #[test]
    fn notes_say_what_no_row_covers() {
        let notes = |shot: Shot| shot.throw().unwrap().notes.iter().flatten().count();
        let smooth = shot(Kind::Smooth, 5.0, 0.4);
        assert_eq!(notes(smooth), 0);
        assert_eq!(notes(Shot { elevation_deg: 60.0, ..smooth }), 1);
        assert_eq!(notes(Shot { size: Size::Outlet(60.0), ..smooth }), 1);
        assert_eq!(notes(shot(Kind::Monitor, 20.0, 0.8)), 1);
        assert_eq!(notes(shot(Kind::Monitor, 20.0, 0.4)), 2);
    }
}
