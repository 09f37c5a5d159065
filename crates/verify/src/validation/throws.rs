//! Flow and throw beside published figures.

use lafet_sim::jet::Jet;
use lafet_sim::nozzle::{Family, MONITOR, SMOOTH_BORE, spray_mm};

use super::{Table, percent};

const GPM_LPS: f64 = 0.063_090_2;
const PSI_MPA: f64 = 0.006_894_757;
const INCH_MM: f64 = 25.4;
const FOOT_M: f64 = 0.3048;

/// A published flow.
struct Flow {
    source: &'static str,
    family: Family,
    nozzle_mm: f64,
    pressure_mpa: f64,
    lps: f64,
}

fn flows() -> Vec<Flow> {
    let freeman = |inches: f64, psi: f64| Flow {
        source: "Freeman's formula, c = 0.97 [TFT]",
        family: SMOOTH_BORE,
        nozzle_mm: inches * INCH_MM,
        pressure_mpa: psi * PSI_MPA,
        lps: 29.71 * 0.97 * inches * inches * libm::sqrt(psi) * GPM_LPS,
    };
    let tip = |inches: f64, gpm: f64| Flow {
        source: "[H2N]",
        family: SMOOTH_BORE,
        nozzle_mm: inches * INCH_MM,
        pressure_mpa: 50.0 * PSI_MPA,
        lps: gpm * GPM_LPS,
    };
    vec![
        freeman(0.5, 50.0),
        freeman(1.0, 50.0),
        freeman(1.125, 50.0),
        freeman(1.75, 80.0),
        tip(1.125, 266.0),
        tip(1.25, 328.0),
        Flow {
            source: "20 l/s at 0.8 MPa [given]",
            family: MONITOR,
            nozzle_mm: 28.0,
            pressure_mpa: 0.8,
            lps: 20.0,
        },
        Flow {
            source: "40 l/s at 0.8 MPa [given]",
            family: MONITOR,
            nozzle_mm: 40.0,
            pressure_mpa: 0.8,
            lps: 40.0,
        },
    ]
}

/// Flow of nozzles.
pub fn flow() -> String {
    let mut table = Table::new(&[
        "source",
        "nozzle",
        "outlet, mm",
        "pressure, MPa",
        "published, l/s",
        "model, l/s",
        "error",
    ]);
    for Flow { source, family, nozzle_mm, pressure_mpa, lps } in flows() {
        let model = family.flow_lps(nozzle_mm, pressure_mpa);
        table.row(&[
            source.to_owned(),
            family.name.to_owned(),
            format!("{nozzle_mm:.1}"),
            format!("{pressure_mpa:.3}"),
            format!("{lps:.2}"),
            format!("{model:.2}"),
            percent(model, lps),
        ]);
    }
    table.0
}

/// A published throw.
struct Throw {
    source: &'static str,
    jet: Jet,
    metres: f64,
    at_least: bool,
}

fn throw_rows() -> Vec<Throw> {
    let angle = 30_f64.to_radians();
    let hand = |nozzle_mm: f64, lps: f64, metres: f64| {
        let pressure_mpa = SMOOTH_BORE.pressure_mpa(nozzle_mm, lps);
        let solid = Jet::solid(pressure_mpa, nozzle_mm, angle);
        let jet = Jet { family: SMOOTH_BORE, height_m: 1.0, ..solid };
        Throw { source: "hand nozzle [given]", jet, metres, at_least: false }
    };
    let monitor = |lps: f64, pressure_mpa: f64, metres: f64, at_least: bool| {
        let nozzle_mm = MONITOR.outlet_mm(lps, pressure_mpa);
        let jet = Jet::solid(pressure_mpa, nozzle_mm, angle);
        Throw { source: "monitor [given]", jet, metres, at_least }
    };
    let hague = Jet::solid(45.0 * PSI_MPA, 1.125 * INCH_MM, angle);
    vec![
        monitor(20.0, 0.8, 42.0, false),
        monitor(20.0, 0.9, 42.0, false),
        monitor(20.0, 1.0, 42.0, false),
        monitor(40.0, 0.8, 60.0, true),
        hand(16.0, 5.5, 33.0),
        hand(12.0, 3.6, 28.0),
        hand(19.0, 7.4, 32.0),
        Throw {
            source: "hand nozzle, a still day [Hague]",
            jet: Jet { family: SMOOTH_BORE, height_m: 1.0, ..hague },
            metres: 120.0 * FOOT_M,
            at_least: false,
        },
    ]
}

/// Throw of solid jets at 30°.
pub fn throws() -> String {
    let mut table = Table::new(&[
        "source",
        "outlet, mm",
        "pressure, MPa",
        "flow, l/s",
        "published, m",
        "model, m",
        "error",
        "outermost water, m",
        "no drag, m",
    ]);
    for Throw { source, jet, metres, at_least } in throw_rows() {
        let model = jet.landing().range_m();
        let sine = libm::sin(2.0 * jet.elevation);
        let free = jet.exit_mps() * jet.exit_mps() * sine / lafet_sim::jet::GRAVITY;
        table.row(&[
            source.to_owned(),
            format!("{:.1}", jet.nozzle_mm),
            format!("{:.2}", jet.pressure_mpa),
            format!("{:.1}", jet.family.flow_lps(jet.nozzle_mm, jet.pressure_mpa)),
            format!("{}{metres:.1}", if at_least { "≥ " } else { "" }),
            format!("{model:.1}"),
            percent(model, metres),
            format!("{:.1}", jet.reach_m()),
            format!("{free:.0}"),
        ]);
    }
    table.0
}

/// Range by elevation and pressure: the world's jet.
pub fn ranges() -> String {
    let jets = [(28.0, 0.4), (28.0, 0.6), (28.0, 0.8), (28.0, 1.0), (40.0, 0.8)];
    let titles: Vec<String> =
        jets.iter().map(|(mm, mpa)| format!("{mm:.0} mm, {mpa} MPa")).collect();
    let titles: Vec<&str> =
        core::iter::once("elevation").chain(titles.iter().map(String::as_str)).collect();
    let mut table = Table::new(&titles);
    for degrees in (-15..=60).step_by(5) {
        let range = |(nozzle_mm, pressure_mpa)| {
            let jet = Jet::solid(pressure_mpa, nozzle_mm, f64::from(degrees).to_radians());
            format!("{:.1}", jet.landing().range_m())
        };
        let cells = core::iter::once(format!("{degrees}°")).chain(jets.map(range));
        table.row(&cells.collect::<Vec<_>>());
    }
    table.0
}

/// Range and footprint by the position of the nozzle.
pub fn spray() -> String {
    let mut table = Table::new(&[
        "nozzle, mm",
        "half-angle",
        "range, m",
        "footprint along × across, m",
        "area, m²",
        "density, l/(s·m²)",
    ]);
    for spray_mm in [60.0, 55.0, 50.0, 40.0, 30.0, 20.0, 0.0] {
        let jet = Jet { spray_mm, ..Jet::solid(0.8, 28.0, 15_f64.to_radians()) };
        let landing = jet.landing();
        let flow = jet.family.flow_lps(jet.nozzle_mm, jet.pressure_mpa);
        table.row(&[
            format!("{spray_mm:.0}"),
            format!("{:.1}°", lafet_sim::nozzle::half_angle(spray_mm).to_degrees()),
            format!("{:.1}", landing.range_m()),
            format!("{:.1} × {:.1}", 2.0 * landing.along_m, 2.0 * landing.across_m),
            format!("{:.0}", landing.area_m2()),
            format!("{:.2}", flow / landing.area_m2()),
        ]);
    }
    table.0
}

/// Torches of which a reach is recalled: l/s, MPa, whole angle of the cone, least reach in m.
const TORCHES: [(f64, f64, f64, f64); 4] = [
    (20.0, 0.6, 2.0, 50.0),
    (20.0, 0.6, 30.0, 30.0),
    (40.0, 0.8, 2.0, 60.0),
    (40.0, 0.8, 30.0, 35.0),
];

/// Farthest drops of a jet of so many l/s whose cone has a whole angle, 30° up: far end of its
/// footprint, m, and the middle.
fn farthest(lps: f64, pressure_mpa: f64, cone_deg: f64) -> (Jet, f64, f64) {
    let nozzle_mm = MONITOR.outlet_mm(lps, pressure_mpa);
    let solid = Jet::solid(pressure_mpa, nozzle_mm, 30_f64.to_radians());
    let jet = Jet { spray_mm: spray_mm(cone_deg), ..solid };
    let landing = jet.landing();
    (jet, landing.range_m(), landing.range_m() + landing.along_m)
}

/// Reach of sprays beside what is asked of monitors.
pub fn torch() -> String {
    let mut table = Table::new(&[
        "flow, l/s",
        "pressure, MPa",
        "whole angle of the cone",
        "nozzle, mm",
        "farthest drops, recalled, m",
        "model: farthest, m",
        "middle, m",
        "lumps, mm",
    ]);
    for (lps, pressure_mpa, cone_deg, least_m) in TORCHES {
        let (jet, middle_m, far_m) = farthest(lps, pressure_mpa, cone_deg);
        table.row(&[
            format!("{lps:.0}"),
            format!("{pressure_mpa}"),
            format!("{cone_deg:.0}°"),
            format!("{:.1}", jet.spray_mm),
            format!("≥ {least_m:.0}"),
            format!("{far_m:.1}"),
            format!("{middle_m:.1}"),
            format!("{:.1}", jet.lump_m() * 1000.0),
        ]);
    }
    table.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every throw within a tenth, with one set of constants per family of nozzles.
    #[test]
    fn within_a_tenth() {
        for Throw { source, jet, metres, .. } in throw_rows() {
            let error = jet.landing().range_m() / metres - 1.0;
            assert!(error.abs() < 0.1, "{source} {:.1} mm: {error:+.3}", jet.nozzle_mm);
        }
        for Flow { source, family, nozzle_mm, pressure_mpa, lps } in flows() {
            let error = family.flow_lps(nozzle_mm, pressure_mpa) / lps - 1.0;
            assert!(error.abs() < 0.04, "{source} {nozzle_mm:.1} mm: {error:+.3}");
        }
    }

    /// Sprays reach what is asked of them, and not twice as far.
    #[test]
    fn sprays_reach() {
        for (lps, pressure_mpa, cone_deg, least_m) in TORCHES {
            let (_, _, far_m) = farthest(lps, pressure_mpa, cone_deg);
            assert!((1.0..1.25).contains(&(far_m / least_m)), "{lps} {cone_deg}°: {far_m:.1}");
        }
    }

    /// The ratio to the throw without drag that makes a parabola useless.
    #[test]
    fn drag_matters() {
        let jet = Jet::solid(0.8, 28.0, 30_f64.to_radians());
        let free = jet.exit_mps() * jet.exit_mps() * libm::sin(2.0 * jet.elevation)
            / lafet_sim::jet::GRAVITY;
        assert!((0.30..0.42).contains(&(jet.landing().range_m() / free)));
    }
}
