//! Nozzles: what flows out of them, how fast, and how the water holds together afterwards.
//!
//! - exit speed v₀ = φ·√(2P/ρ), φ = 0.97;
//! - flow Q = c·A·√(2P/ρ) = K·√P, A = π·d²/4; smooth bores have c = 0.97 (in the customary units
//!   `Q[gpm] = 29.71·c·d²[in]·√P[psi]`), monitors with a nozzle that can be set from solid jet to
//!   spray c = 0.812, the share of the bore that its insert leaves free (ours: 20 l/s from 28 mm
//!   at 0.8 MPa);
//! - spray: w = 1 − n/60 for the nozzle at n mm, 0 narrowest … 1 widest; half-angle of the cone
//!   δ = 1° + 34°·w (ours).

/// Density of water at 10 °C, kg/m³.
pub const DENSITY: f64 = 1000.0;
/// Travel of the nozzle from widest to narrowest, mm.
pub const NOZZLE_TRAVEL_MM: f64 = 60.0;

const CONE_DEG: f64 = 1.0;
const SPRAY_CONE_DEG: f64 = 34.0;

/// A family of nozzles; everything in which one family's jets differ from another's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Family {
    /// What people call it.
    pub name: &'static str,
    /// Coefficient of discharge c.
    pub discharge: f64,
    /// Coefficient of velocity φ.
    pub velocity: f64,
    /// Factor k of the size of the lumps that the jet breaks into (see [`crate::lumps`]).
    pub lump: f64,
}

/// Nozzles of monitors, set from solid jet to spray.
pub const MONITOR: Family = Family { name: "monitor", discharge: 0.812, velocity: 0.97, lump: 5.6 };
/// Monitors whose outermost water lands where their makers state the reach (`validation::reach`).
pub const MAKERS: Family = Family { name: "monitor by its makers", lump: 3.3, ..MONITOR };
/// Smooth-bore hand nozzles.
pub const SMOOTH_BORE: Family =
    Family { name: "smooth bore", discharge: 0.97, velocity: 0.97, lump: 10.5 };

impl Family {
    /// Exit speed, m/s.
    pub fn exit_mps(&self, pressure_mpa: f64) -> f64 {
        self.velocity * ideal_mps(pressure_mpa)
    }

    /// Nozzle constant K, l/s per √MPa.
    pub fn k(&self, nozzle_mm: f64) -> f64 {
        self.discharge * area_m2(nozzle_mm) * ideal_mps(1.0) * 1000.0
    }

    /// Flow, l/s.
    pub fn flow_lps(&self, nozzle_mm: f64, pressure_mpa: f64) -> f64 {
        self.k(nozzle_mm) * libm::sqrt(pressure_mpa)
    }

    /// Outlet that lets a flow through at a pressure, mm.
    pub fn outlet_mm(&self, flow_lps: f64, pressure_mpa: f64) -> f64 {
        libm::sqrt(flow_lps / self.flow_lps(1.0, pressure_mpa))
    }

    /// Pressure that makes a flow, MPa.
    pub fn pressure_mpa(&self, nozzle_mm: f64, flow_lps: f64) -> f64 {
        let through = flow_lps / self.k(nozzle_mm);
        through * through
    }
}

/// How wide the spray is: 0 solid jet … 1 widest.
pub fn width(spray_mm: f64) -> f64 {
    (1.0 - spray_mm / NOZZLE_TRAVEL_MM).clamp(0.0, 1.0)
}

/// Half-angle of the cone, radians.
pub fn half_angle(spray_mm: f64) -> f64 {
    (CONE_DEG + SPRAY_CONE_DEG * width(spray_mm)).to_radians()
}

/// Position of the nozzle for a whole angle of the cone, mm; the nearest there is.
pub fn spray_mm(cone_deg: f64) -> f64 {
    let width = ((cone_deg / 2.0 - CONE_DEG) / SPRAY_CONE_DEG).clamp(0.0, 1.0);
    NOZZLE_TRAVEL_MM * (1.0 - width)
}

fn area_m2(nozzle_mm: f64) -> f64 {
    let diameter_m = nozzle_mm / 1000.0;
    core::f64::consts::FRAC_PI_4 * diameter_m * diameter_m
}

fn ideal_mps(pressure_mpa: f64) -> f64 {
    libm::sqrt(2.0 * pressure_mpa * 1e6 / DENSITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GPM_LPS: f64 = 0.063_090_2;
    const PSI_MPA: f64 = 0.006_894_757;
    const INCH_MM: f64 = 25.4;

    /// `Q[gpm] = 29.71·c·d²[in]·√P[psi]`, within half a per cent.
    #[test]
    fn customary_formula() {
        for (inches, psi) in [(1.0, 50.0), (1.125, 50.0), (1.25, 80.0), (2.0, 100.0_f64)] {
            let gpm = 29.71 * SMOOTH_BORE.discharge * inches * inches * psi.sqrt();
            let flow = SMOOTH_BORE.flow_lps(inches * INCH_MM, psi * PSI_MPA);
            assert!((flow / (gpm * GPM_LPS) - 1.0).abs() < 0.005, "{inches} {psi}: {flow}");
        }
    }

    #[test]
    fn monitor() {
        assert!((MONITOR.flow_lps(28.0, 0.8) - 20.0).abs() < 0.01);
        assert!((MONITOR.pressure_mpa(28.0, 20.0) - 0.8).abs() < 0.001);
        assert!((MONITOR.outlet_mm(20.0, 0.8) - 28.0).abs() < 0.01);
        assert!((MONITOR.exit_mps(0.8) - 38.80).abs() < 0.001);
        assert_eq!((width(60.0), width(0.0), width(-5.0)), (0.0, 1.0, 1.0));
        assert!((half_angle(30.0).to_degrees() - 18.0).abs() < 1e-9);
        assert_eq!((spray_mm(36.0), spray_mm(0.0), spray_mm(120.0)), (30.0, 60.0, 0.0));
    }
}
