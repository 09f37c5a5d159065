//! Water supply: the pressure that is left when several monitors flow. A model of ours.
//!
//! The pressure in front of the monitors follows the curve of the pump, less the loss of the pipe, and
//! is the same at all of them; a monitor lets Q = K·√p through. Heights and the pipe of each monitor are
//! not modelled: give the curve as it is measured where the monitors are connected.

use lafet_texts::place as text;
use serde::{Deserialize, Serialize};

use crate::text::{Problem, counted, within};

/// Most points of a curve.
pub const POINTS_MAX: usize = 32;
/// Greatest flow and pressure of a supply, l/min and MPa.
pub const FLOW_MAX_LPM: f64 = 200_000.0;
/// See [`FLOW_MAX_LPM`].
pub const PRESSURE_MAX_MPA: f64 = 2.5;
/// Halvings of the interval in which the pressure lies.
const HALVINGS: usize = 60;

/// A supply of water.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Supply {
    /// Points of flow, l/min, and pressure, MPa: flows rise from 0, pressures do not.
    curve: Vec<[f64; 2]>,
}

impl Supply {
    /// A supply that keeps its pressure whatever flows, MPa.
    pub fn constant(pressure_mpa: f64) -> Result<Self, Problem> {
        Self::curve(&[[0.0, pressure_mpa], [FLOW_MAX_LPM, pressure_mpa]])
    }

    /// A pump by its pressure without flow and one point of its curve, which is a parabola.
    pub fn parabola(static_mpa: f64, flow_lpm: f64, pressure_mpa: f64) -> Result<Self, Problem> {
        within(&text::SupplyFlow, flow_lpm, 1.0..=FLOW_MAX_LPM)?;
        let drop = static_mpa - pressure_mpa;
        let points = (POINTS_MAX - 1) as f64;
        let last = if drop > 0.0 { (static_mpa / drop).sqrt() } else { 1.0 };
        let point = |index: usize| {
            let part = last * index as f64 / points;
            [(part * flow_lpm).min(FLOW_MAX_LPM * 10.0), (static_mpa - drop * part * part).max(0.0)]
        };
        Self::curve(&(0..POINTS_MAX).map(point).collect::<Vec<_>>())
    }

    /// A pump by points of its curve: flow, l/min, and pressure, MPa; straight between them, and on
    /// behind the last.
    pub fn curve(points: &[[f64; 2]]) -> Result<Self, Problem> {
        counted(&text::CurvePoints, points.len(), 2..=POINTS_MAX)?;
        for [flow, pressure] in points {
            let most = 10.0 * FLOW_MAX_LPM;
            within(&text::CurveFlow, *flow, 0.0..=most)?;
            let what = &text::CurvePressure;
            within(what, *pressure, 0.0..=PRESSURE_MAX_MPA)?;
        }
        let falls =
            points.windows(2).all(|pair| pair[0][0] < pair[1][0] && pair[0][1] >= pair[1][1]);
        if falls && points[0][0] == 0.0 {
            return Ok(Self { curve: points.to_vec() });
        }
        Err(Problem::new(text::CurveNotFalling))
    }

    /// Pressure at a flow, MPa.
    pub fn pressure_mpa(&self, flow_lpm: f64) -> f64 {
        let after = self.curve.iter().position(|point| point[0] >= flow_lpm);
        let end = after.unwrap_or(self.curve.len() - 1).max(1);
        let ([q0, p0], [q1, p1]) = (self.curve[end - 1], self.curve[end]);
        (p0 + (p1 - p0) * (flow_lpm - q0) / (q1 - q0)).max(0.0)
    }

    /// The pressure that is left when nozzles flow together, MPa, by the sum of their K, l/min at 1 MPa.
    pub fn left_mpa(&self, k_sum: f64) -> f64 {
        let (mut less, mut more) = (0.0, PRESSURE_MAX_MPA);
        for _ in 0..HALVINGS {
            let mid = 0.5 * (less + more);
            let is_more = self.pressure_mpa(k_sum * f64::sqrt(mid)) > mid;
            *(if is_more { &mut less } else { &mut more }) = mid;
        }
        0.5 * (less + more)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_monitors_leave_less_pressure() {
        let supply = Supply::parabola(1.0, 2400.0, 0.8).unwrap();
        assert!((supply.pressure_mpa(0.0) - 1.0).abs() < 1e-9);
        assert!((supply.pressure_mpa(2400.0) - 0.8).abs() < 2e-3);
        let k = 1200.0 / 0.8_f64.sqrt();
        let mut before = 1.0;
        for monitors in 1..=8 {
            let k_sum = k * f64::from(monitors);
            let left = supply.left_mpa(k_sum);
            assert!(left < before, "{monitors}: {left}");
            // What flows at this pressure is what the pump gives at it.
            assert!((supply.pressure_mpa(k_sum * left.sqrt()) - left).abs() < 1e-6);
            before = left;
        }
        assert!((supply.left_mpa(2.0 * k) - 0.8).abs() < 3e-3);
        assert!((Supply::constant(0.7).unwrap().left_mpa(9.0 * k) - 0.7).abs() < 1e-9);
    }

    #[test]
    fn points_are_joined_by_lines() {
        let supply = Supply::curve(&[[0.0, 1.0], [1000.0, 0.9], [2000.0, 0.5]]).unwrap();
        assert!((supply.pressure_mpa(500.0) - 0.95).abs() < 1e-12);
        assert!((supply.pressure_mpa(2500.0) - 0.3).abs() < 1e-12);
        assert_eq!(supply.pressure_mpa(9000.0), 0.0);
    }

    #[test]
    fn what_is_no_curve_is_refused() {
        let wrong: [&[[f64; 2]]; 6] = [
            &[[0.0, 1.0]],
            &[[0.0, 1.0], [0.0, 0.9]],
            &[[0.0, 0.5], [10.0, 0.9]],
            &[[5.0, 1.0], [10.0, 0.9]],
            &[[0.0, f64::NAN], [10.0, 0.9]],
            &[[0.0, 3.0], [10.0, 0.9]],
        ];
        for points in wrong {
            assert!(Supply::curve(points).is_err(), "{points:?}");
        }
        assert!(Supply::parabola(0.5, 100.0, 0.8).is_err());
        assert!(Supply::parabola(0.5, f64::NAN, 0.4).is_err());
    }
}
