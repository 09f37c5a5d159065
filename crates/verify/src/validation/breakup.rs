//! How far measured jets hold together: what the exponent of the core's length rests on.

use lafet_sim::nozzle::MONITOR;

use super::Table;

/// Density, kg/m³, and surface tension, N/m.
type Liquid = (f64, f64);

const WATER_19: Liquid = (998.0, 0.072_9);
const WATER_25: Liquid = (997.0, 0.071_0);
const WATER_55: Liquid = (986.0, 0.067_1);

/// Measured break-up lengths over the diameter: source, diameter in mm, speed in m/s, water, length.
const MEASURED: [(&str, f64, f64, Liquid, f64); 11] = [
    ("Grant", 0.62, 20.0, WATER_25, 115.0),
    ("Grant", 0.62, 39.6, WATER_25, 194.0),
    ("Grant", 0.62, 68.2, WATER_25, 268.0),
    ("Kusui", 2.4, 10.2, WATER_19, 113.8),
    ("Kusui", 2.4, 15.4, WATER_19, 143.2),
    ("Kusui", 2.4, 22.4, WATER_19, 188.9),
    ("Kusui", 2.4, 27.6, WATER_19, 200.5),
    ("Kusui", 4.0, 14.7, WATER_55, 181.3),
    ("Kusui", 4.0, 19.2, WATER_55, 224.8),
    ("Kusui", 4.0, 23.7, WATER_55, 255.5),
    ("Kusui", 4.0, 29.6, WATER_55, 272.9),
];

/// The exponent.
const EXPONENT: f64 = 0.32;

fn weber(diameter_mm: f64, speed: f64, (density, tension): Liquid) -> f64 {
    density * speed * speed * diameter_mm / 1000.0 / tension
}

/// Length over diameter and over We^0.32, measured and in the model.
pub fn table() -> String {
    let mut table =
        Table::new(&["source", "outlet, mm", "speed, m/s", "We", "L_b/d", "L_b/(d·We^0.32)"]);
    let mut row = |source: String, diameter_mm: f64, speed: f64, weber: f64, length: f64| {
        table.row(&[
            source,
            format!("{diameter_mm}"),
            format!("{speed:.1}"),
            format!("{weber:.0}"),
            format!("{length:.0}"),
            format!("{:.2}", length / libm::pow(weber, EXPONENT)),
        ]);
    };
    for (source, diameter_mm, speed, liquid, length) in MEASURED {
        let weber = weber(diameter_mm, speed, liquid);
        row(format!("measured [{source}]"), diameter_mm, speed, weber, length);
    }
    for (diameter_mm, pressure_mpa) in [(28.0, 0.8), (40.0, 0.8)] {
        let speed = MONITOR.exit_mps(pressure_mpa);
        let jet = lafet_sim::jet::Jet::solid(pressure_mpa, diameter_mm, 0.0);
        let length = jet.core_m() / (diameter_mm / 1000.0);
        row("model".to_owned(), diameter_mm, speed, jet.weber(), length);
    }
    table.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One factor serves jets of 0.62–4 mm at 10–68 m/s within a tenth.
    #[test]
    fn the_exponent_holds() {
        for (source, diameter_mm, speed, liquid, length) in MEASURED {
            let factor = length / libm::pow(weber(diameter_mm, speed, liquid), EXPONENT);
            assert!((factor / 8.6 - 1.0).abs() < 0.1, "{source} {diameter_mm} {speed}: {factor}");
        }
    }
}
