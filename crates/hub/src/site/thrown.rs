//! How far the water of a jet is expected to land, with its uncertainty: the law of `lafet throw`, which is
//! compared with published throws, beside the monitor's own one, by which it aims.

use lafet_ballistics::DATM_MPA;
use lafet_ballistics::throw::{Figure, Kind, Refusal, Shot, Size, Throw, Value};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::jet::Basis;
use super::struck::Struck;

/// Wind 10 m above the ground, as the jet has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = JetWind)]
pub struct Wind {
    /// In the direction of the jet, m/s; against it negative.
    pub along_mps: f32,
    /// To the left of the jet, m/s.
    pub left_mps: f32,
}

/// A distance and the band in which it is expected, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Banded {
    /// As computed.
    pub value: f32,
    /// Lower end of the band.
    pub low: f32,
    /// Upper end of the band.
    pub high: f32,
}

/// Where the water of a jet is expected to land.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Thrown {
    /// Distance to the middle of the wetted ground. The lower end is the nearest landing.
    pub middle_m: Banded,
    /// Distance to where the outermost water lands. The upper end is the farthest landing.
    pub greatest_m: Banded,
    /// How far the wind carries the middle to the left of the jet's direction.
    pub left_m: Banded,
    /// Half of the width of the wetted ground, m.
    pub across_m: f32,
    /// Flow that it was computed from, l/s: as measured, else that of the outlet.
    pub flow_lps: f32,
    /// Wind that it was computed with; `null`: not known, still air is assumed.
    #[schema(required)]
    pub wind: Option<Wind>,
}

/// Why it is not known where the water lands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum NoThrow {
    /// The monitor has no valid pressure.
    PressureUnknown,
    /// The monitor has no valid elevation.
    ElevationUnknown,
    /// The pressure is outside of 0.2 … 2 MPa.
    Pressure,
    /// Flow and pressure together are those of no outlet from 12 to 80 mm.
    Flow,
    /// The outlet is outside of 12 … 80 mm.
    Outlet,
    /// The elevation is outside of −15 … 80°.
    Elevation,
    /// The nozzle is below the ground or more than 50 m above it.
    Height,
    /// The wind is above 20 m/s.
    Wind,
}

/// Computes the throw of a jet, of the measured flow if there is one.
pub fn thrown(
    basis: &Basis,
    elevation_arcmin: Option<i32>,
    flow_lps: Option<f32>,
    wind: Option<Wind>,
) -> Result<Thrown, NoThrow> {
    let pressure_datm = basis.pressure_datm.ok_or(NoThrow::PressureUnknown)?;
    let elevation_arcmin = elevation_arcmin.ok_or(NoThrow::ElevationUnknown)?;
    let [along, left] = wind.map_or([0.0; 2], |it| [it.along_mps, it.left_mps].map(f64::from));
    let shot = Shot {
        kind: Kind::Monitor,
        size: flow_lps.map_or(Size::Outlet(f64::from(basis.diameter_dmm) / 10.0), |flow_lps| {
            Size::Flow(flow_lps.into())
        }),
        pressure_mpa: f64::from(pressure_datm) * DATM_MPA,
        nozzle_mm: f64::from(basis.nozzle_mm),
        elevation_deg: f64::from(elevation_arcmin) / 60.0,
        height_m: f64::from(basis.height_cm) / 100.0,
        wind_mps: along.hypot(left),
        wind_from_deg: left.atan2(-along).to_degrees(),
    };
    Ok(of(&shot.throw()?, wind))
}

impl Thrown {
    /// Ends each distance at what is in the way of water that would land so far. What that is: what
    /// the middle strikes, else the outermost or the nearest water.
    pub fn end_at(&mut self, strikes: impl Fn(f32) -> Option<Struck>) -> Option<Struck> {
        let ends =
            [self.middle_m.value, self.greatest_m.value, self.middle_m.low, self.greatest_m.high];
        let struck = ends.map(&strikes);
        let end = |way_m: f32| strikes(way_m).map_or(way_m, |it| it.way_m.min(way_m));
        for it in [&mut self.middle_m, &mut self.greatest_m] {
            let [low, value, high] = [it.low, it.value, it.high].map(end);
            *it = Banded { value, low: low.min(value), high: high.max(value) };
        }
        let first = struck.iter().flatten().next()?.clone();
        let whole = struck.iter().all(|it| it.as_ref().is_some_and(|it| it.is_of(&first)));
        Some(Struck { whole, ..first })
    }
}

fn of(throw: &Throw, wind: Option<Wind>) -> Thrown {
    Thrown {
        middle_m: banded(throw.middle_m),
        greatest_m: banded(throw.greatest_m),
        left_m: banded(throw.left_m),
        across_m: cm(throw.across_m),
        flow_lps: cm(throw.flow_lps),
        wind,
    }
}

fn banded(figure: Figure) -> Banded {
    Banded { value: cm(figure.value), low: cm(figure.low), high: cm(figure.high) }
}

/// Two decimals; no -0.
fn cm(value: f64) -> f32 {
    ((value * 100.0).round() / 100.0 + 0.0) as f32
}

impl From<Refusal> for NoThrow {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Outside { what, .. } => match what {
                Value::Pressure => Self::Pressure,
                Value::Flow => Self::Flow,
                Value::Outlet | Value::Nozzle => Self::Outlet,
                Value::Elevation => Self::Elevation,
                Value::Height => Self::Height,
                Value::Wind | Value::WindDirection => Self::Wind,
            },
            Refusal::NoSpray => Self::Outlet,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASIS: Basis =
        Basis { pressure_datm: Some(79), nozzle_mm: 60, diameter_dmm: 280, height_cm: 150 };

    fn still(basis: &Basis) -> Result<Thrown, NoThrow> {
        thrown(basis, Some(1800), None, None)
    }

    /// The figures of `lafet throw --flow 20 --pressure 0.8004675 --elevation 30`, in its own bands.
    #[test]
    fn is_the_throw_of_the_command_line() {
        let shot = Shot {
            kind: Kind::Monitor,
            size: Size::Flow(20.0),
            pressure_mpa: 0.800_467_5,
            nozzle_mm: 60.0,
            elevation_deg: 30.0,
            height_m: 1.5,
            wind_mps: 5.0,
            wind_from_deg: 90.0,
        };
        // Wind from the right of the jet carries it to the left.
        let wind = Some(Wind { along_mps: 0.0, left_mps: 5.0 });
        let hub = thrown(&BASIS, Some(1800), Some(20.0), wind).expect("a throw");
        let throw = shot.throw().expect("a throw");
        assert_eq!(hub, of(&throw, wind));
        let near = |a: f32, b: f32| (a - b).abs() < 0.11;
        let Banded { value, low, high } = hub.middle_m;
        assert!(near(value, 35.9) && near(low, 29.0) && near(high, 43.4), "{hub:?}");
        let Banded { value, low, high } = hub.greatest_m;
        assert!(near(value, 42.3) && near(low, 37.8) && near(high, 46.4), "{hub:?}");
        assert!(near(hub.left_m.value, 9.5) && hub.left_m.low < 6.5, "{hub:?}");
    }

    /// The flow that is measured counts, not the outlet by which the monitor aims: that is changed by a calibration.
    #[test]
    fn the_measured_flow_counts() {
        let calibrated = Basis { diameter_dmm: 220, ..BASIS };
        let of = |basis: &Basis, flow| thrown(basis, Some(1800), flow, None).unwrap().greatest_m;
        assert_eq!(of(&calibrated, Some(20.0)), of(&BASIS, Some(20.0)));
        assert!(of(&calibrated, None).high < of(&BASIS, None).low + 5.0);
        assert!((of(&BASIS, None).value - of(&BASIS, Some(20.0)).value).abs() < 0.05);
    }

    #[test]
    fn what_is_not_known_is_named() {
        let calm = still(&BASIS).expect("a throw");
        assert_eq!((calm.wind, calm.left_m), (None, Banded { value: 0.0, low: 0.0, high: 0.0 }));
        let unknown = Basis { pressure_datm: None, ..BASIS };
        assert_eq!(still(&unknown), Err(NoThrow::PressureUnknown));
        assert_eq!(thrown(&BASIS, None, None, None), Err(NoThrow::ElevationUnknown));
        assert_eq!(still(&Basis { pressure_datm: Some(5), ..BASIS }), Err(NoThrow::Pressure));
        assert_eq!(still(&Basis { diameter_dmm: 900, ..BASIS }), Err(NoThrow::Outlet));
        assert_eq!(still(&Basis { height_cm: -10, ..BASIS }), Err(NoThrow::Height));
        assert_eq!(thrown(&BASIS, Some(1800), Some(1.0), None), Err(NoThrow::Flow));
        assert_eq!(thrown(&BASIS, Some(-960), None, None), Err(NoThrow::Elevation));
        let gale = Some(Wind { along_mps: 21.0, left_mps: 0.0 });
        assert_eq!(thrown(&BASIS, Some(0), None, gale), Err(NoThrow::Wind));
    }
}
