//! Water and fire by themselves.

use core::f64::consts::FRAC_PI_2;

use lafet_sim::fault::Faults;
use lafet_sim::fire::{Fire, FireSpec, spread as spread_fires};
use lafet_sim::water::Water;

use super::Table;

const DT_S: f64 = 0.01;

/// Free areas with the first valve open by a part of its travel (see `valve`).
fn areas(opening: f64) -> [f64; 2] {
    let sine = libm::sin(FRAC_PI_2 * opening.clamp(0.0, 1.0));
    [sine * sine, 0.0]
}

/// From the command to open until the jet is complete, by the time of the valve.
pub fn filling() -> String {
    let mut table = Table::new(&[
        "outlet, mm",
        "valve, s",
        "first water at the nozzle, s",
        "95 % of the pressure, s",
        "highest pressure, MPa",
        "steady: MPa, l/s",
    ]);
    for (nozzle_mm, travel_s) in [(28.0, 2.0), (28.0, 4.0), (28.0, 8.0), (40.0, 4.0)] {
        let mut water = Water::new(nozzle_mm);
        let (mut first, mut stands, mut peak) = (None, None, 0.0_f64);
        for step in 0..6_000 {
            let time = f64::from(step) * DT_S;
            water.step(areas(time / travel_s), DT_S, &Faults::default());
            first = first.or((water.jet_lps() > 0.1).then_some(time));
            stands = stands.or((water.pressure_mpa > 0.76).then_some(time));
            peak = peak.max(water.pressure_mpa);
        }
        let seconds = |time: Option<f64>| time.map_or("never".to_owned(), |s| format!("{s:.1}"));
        table.row(&[
            format!("{nozzle_mm:.0}"),
            format!("{travel_s:.0}"),
            seconds(first),
            seconds(stands),
            format!("{peak:.2}"),
            format!("{:.2}, {:.1}", water.pressure_mpa, water.flow_lps),
        ]);
    }
    table.0
}

/// Highest pressure in front of a valve that closes.
pub fn closing() -> String {
    let mut table = Table::new(&["closing, s", "highest pressure in front of the valve, MPa"]);
    for closing_s in [8.0, 4.0, 2.0, 1.0, 0.5] {
        let mut water = Water::new(28.0);
        (0..2_000).for_each(|_| water.step([1.0, 0.0], DT_S, &Faults::default()));
        let mut peak = 0.0_f64;
        for step in 0..1_000 {
            water.step(areas(1.0 - f64::from(step) * DT_S / closing_s), DT_S, &Faults::default());
            peak = peak.max(water.upstream_mpa);
        }
        table.row(&[format!("{closing_s}"), format!("{peak:.2}")]);
    }
    table.0
}

/// Seconds until a fire of 1.5 m is out under a density, `None` within 15 minutes.
fn out_s(density: f64, foam: f64) -> Option<f64> {
    let mut fire = Fire::new(FireSpec { size_m: 1.5, ..FireSpec::default() });
    (0..9_000).map(f64::from).find_map(|tenth| {
        fire.wet(density * fire.area_m2() * 0.1, foam);
        fire.step(0.1);
        (!fire.burns()).then_some((tenth + 1.0) / 10.0)
    })
}

/// Time and water to put a fire out, by the density that reaches it.
pub fn extinction() -> String {
    let mut table = Table::new(&[
        "density, l/(s·m²)",
        "water: out after, s",
        "water used, l/m²",
        "foam: out after, s",
    ]);
    for density in [0.05, 0.065, 0.1, 0.2, 0.5, 1.0, 2.0] {
        let seconds =
            |time: Option<f64>| time.map_or("not in 15 min".to_owned(), |s| format!("{s:.0}"));
        let water = out_s(density, 0.0);
        table.row(&[
            format!("{density}"),
            seconds(water),
            water.map_or("—".to_owned(), |s| format!("{:.0}", s * density)),
            seconds(out_s(density, 1.0)),
        ]);
    }
    table.0
}

/// When a fire lights what is beside it.
pub fn spread() -> String {
    let mut table =
        Table::new(&["fire, m", "its heat, kW", "distance, m", "flux, kW/m²", "catches after, s"]);
    for (size_m, gap_m) in [(1.5, 1.0), (1.5, 1.5), (3.0, 2.0), (3.0, 2.5), (3.0, 3.0), (6.0, 5.0)]
    {
        let fire =
            |range_m, lit| Fire::new(FireSpec { range_m, size_m, lit, ..FireSpec::default() });
        let mut fires = [fire(20.0, true), fire(20.0 + gap_m, false)];
        let flux = fires[0].flux_kw_m2(fires[1].at);
        let power = fires[0].power_kw();
        let caught = (0..18_000).map(f64::from).find(|_| {
            spread_fires(&mut fires, 0.1);
            fires[1].burns()
        });
        table.row(&[
            format!("{size_m}"),
            format!("{power:.0}"),
            format!("{gap_m}"),
            format!("{flux:.1}"),
            caught.map_or("never".to_owned(), |tenth| format!("{:.0}", (tenth + 1.0) / 10.0)),
        ]);
    }
    table.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Below the critical density a fire never goes out; above it sooner with more and with foam.
    #[test]
    fn extinction_has_a_threshold() {
        assert_eq!(out_s(0.05, 0.0), None);
        let (little, much) = (out_s(0.1, 0.0).unwrap(), out_s(0.5, 0.0).unwrap());
        assert!(little > 4.0 * much && out_s(0.1, 1.0).unwrap() < little);
    }
}
