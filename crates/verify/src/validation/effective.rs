//! Freeman's "effective fire streams" (1889): how high and how far a stream is still a good one.

use lafet_sim::jet::Jet;
use lafet_sim::nozzle::SMOOTH_BORE;

use super::Table;

const PSI_MPA: f64 = 0.006_894_757;
const INCH_MM: f64 = 25.4;
const FOOT_M: f64 = 0.3048;

/// Pressures at the nozzle, psi.
const PSI: [f64; 9] = [20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0];

/// A smooth nozzle: inches, then effective height and distance in feet by pressure.
type Column = (f64, [f64; 9], [f64; 9]);

/// The columns as recalled.
const COLUMNS: [Column; 6] = [
    (
        0.75,
        [33.0, 48.0, 60.0, 67.0, 72.0, 76.0, 79.0, 81.0, 83.0],
        [29.0, 37.0, 44.0, 50.0, 54.0, 58.0, 62.0, 65.0, 68.0],
    ),
    (
        0.875,
        [34.0, 49.0, 62.0, 71.0, 77.0, 81.0, 85.0, 88.0, 90.0],
        [33.0, 42.0, 49.0, 55.0, 61.0, 66.0, 70.0, 74.0, 76.0],
    ),
    (
        1.0,
        [35.0, 51.0, 64.0, 73.0, 79.0, 85.0, 89.0, 92.0, 96.0],
        [37.0, 47.0, 55.0, 61.0, 67.0, 72.0, 76.0, 80.0, 83.0],
    ),
    (
        1.125,
        [36.0, 52.0, 65.0, 75.0, 83.0, 88.0, 92.0, 96.0, 99.0],
        [38.0, 50.0, 59.0, 66.0, 72.0, 77.0, 81.0, 85.0, 89.0],
    ),
    (
        1.25,
        [37.0, 53.0, 67.0, 77.0, 85.0, 91.0, 95.0, 99.0, 101.0],
        [40.0, 54.0, 63.0, 70.0, 76.0, 81.0, 85.0, 90.0, 93.0],
    ),
    (
        1.375,
        [38.0, 55.0, 69.0, 79.0, 87.0, 92.0, 97.0, 100.0, 103.0],
        [42.0, 56.0, 66.0, 73.0, 79.0, 84.0, 88.0, 92.0, 96.0],
    ),
];

/// The stream is good for a time t = a·(d / 1 in)^b·(P / 50 psi)^0.1: a and b for the height of a
/// stream straight up and for the distance of one at 30°.
const HEIGHT: (f64, f64) = (1.17, 0.1);
const DISTANCE: (f64, f64) = (0.89, 0.5);
const PRESSURE_EXPONENT: f64 = 0.1;
const REFERENCE_PSI: f64 = 50.0;

fn jet(inches: f64, psi: f64, degrees: f64) -> Jet {
    let solid = Jet::solid(psi * PSI_MPA, inches * INCH_MM, degrees.to_radians());
    Jet { family: SMOOTH_BORE, height_m: 0.0, ..solid }
}

fn good_s((a, b): (f64, f64), inches: f64, psi: f64) -> f64 {
    a * libm::pow(inches, b) * libm::pow(psi / REFERENCE_PSI, PRESSURE_EXPONENT)
}

fn height_ft(inches: f64, psi: f64) -> f64 {
    let (up, good) = (jet(inches, psi, 90.0), good_s(HEIGHT, inches, psi));
    let highest = (0..=40).map(|part| up.after(good * f64::from(part) / 40.0).1);
    highest.fold(0.0, f64::max) / FOOT_M
}

fn distance_ft(inches: f64, psi: f64) -> f64 {
    jet(inches, psi, 30.0).after(good_s(DISTANCE, inches, psi)).0 / FOOT_M
}

/// Errors of a column's heights and distances.
fn errors((inches, heights, distances): &Column) -> [Vec<f64>; 2] {
    let compare = |model: fn(f64, f64) -> f64, published: &[f64; 9]| {
        let pairs = PSI.iter().zip(published);
        pairs.map(|(psi, feet)| model(*inches, *psi) / feet - 1.0).collect()
    };
    [compare(height_ft, heights), compare(distance_ft, distances)]
}

/// Height and distance by nozzle: at 50 psi, and the errors over 20–100 psi.
pub fn table() -> String {
    let mut table = Table::new(&[
        "smooth nozzle, in",
        "height at 50 psi, ft: recalled / model",
        "distance at 50 psi, ft: recalled / model",
        "height, 20–100 psi: rms, worst error",
        "distance, 20–100 psi: rms, worst error",
    ]);
    for column in &COLUMNS {
        let (inches, heights, distances) = column;
        let summary = |errors: &Vec<f64>| {
            let squares: f64 = errors.iter().map(|error| error * error).sum();
            let rms = libm::sqrt(squares / errors.len() as f64);
            let worst = errors.iter().fold(0.0, |w: f64, e| if e.abs() > w.abs() { *e } else { w });
            format!("{:.1} %, {:+.1} %", rms * 100.0, worst * 100.0)
        };
        let [high, far] = errors(column);
        table.row(&[
            format!("{inches}"),
            format!("{:.0} / {:.0}", heights[3], height_ft(*inches, 50.0)),
            format!("{:.0} / {:.0}", distances[3], distance_ft(*inches, 50.0)),
            summary(&high),
            summary(&far),
        ]);
    }
    table.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All 108 figures within a tenth, with the constants of smooth bores.
    #[test]
    fn within_a_tenth() {
        for column in &COLUMNS {
            for error in errors(column).concat() {
                assert!(error.abs() < 0.1, "{} in: {error:+.3}", column.0);
            }
        }
    }
}
