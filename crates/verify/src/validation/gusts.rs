//! Gusts: what the wind of a world is like, and what it does to a jet that is aimed for still air.

use lafet_sim::calibration::elevation_for;
use lafet_sim::gust::Gusts;

use super::Table;
use super::aim::{HEIGHT_CM, calibrated, lands, way_m};

const DT_S: f64 = 0.1;
/// Samples of ten minutes.
const TEN_MINUTES: usize = 6_000;
const SEEDS: u64 = 20;

/// Speeds over ten minutes, m/s, along a mean wind.
fn blow(mean: f64, intensity: f64, seed: u64) -> Vec<f64> {
    let mut gusts = Gusts::new(intensity, seed);
    let mut speeds = Vec::with_capacity(TEN_MINUTES);
    for _ in 0..TEN_MINUTES {
        gusts.step((mean, 0.0), DT_S);
        speeds.push(gusts.around((mean, 0.0)).0);
    }
    speeds
}

/// The strongest wind over so many samples, over the mean of ten minutes.
fn gust_factor(speeds: &[f64], samples: usize) -> f64 {
    let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
    let strongest = speeds.windows(samples).map(|window| window.iter().sum::<f64>());
    strongest.fold(0.0, f64::max) / samples as f64 / mean
}

fn mean_of(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Strongest gusts of ten minutes, twenty seeds each.
pub fn factors() -> String {
    let mut table = Table::new(&[
        "mean wind, m/s",
        "I",
        "1 s gust over the mean",
        "3 s gust over the mean",
        "(3 s gust − 1)/I",
    ]);
    for (mean, intensity) in [(2.0, 0.15), (5.0, 0.15), (5.0, 0.3), (10.0, 0.15), (10.0, 0.3)] {
        let factor = |samples| {
            mean_of((0..SEEDS).map(|seed| gust_factor(&blow(mean, intensity, seed), samples)))
        };
        let (short, long) = (factor(10), factor(30));
        table.row(&[
            format!("{mean:.0}"),
            format!("{intensity}"),
            format!("{short:.2}"),
            format!("{long:.2}"),
            format!("{:.1}", (long - 1.0) / intensity),
        ]);
    }
    table.0
}

/// Misses over ten minutes: mean and standard deviation, along and across, m.
fn misses(distance_m: u8, wind: (f64, f64), intensity: f64) -> Option<[(f64, f64); 2]> {
    let elevation = elevation_for(79, calibrated(28.0), HEIGHT_CM, distance_m).ok()?;
    let mut gusts = Gusts::new(intensity, 1);
    let mut misses = Vec::new();
    for step in 0..TEN_MINUTES {
        gusts.step(wind, DT_S);
        if step.is_multiple_of(10) {
            let at = lands(28.0, 79, elevation, gusts.around(wind)).at;
            misses.push([at.0 - way_m(distance_m), at.1]);
        }
    }
    Some([0, 1].map(|axis| {
        let mean = mean_of(misses.iter().map(|miss| miss[axis]));
        let square = mean_of(misses.iter().map(|miss| libm::pow(miss[axis] - mean, 2.0)));
        (mean, libm::sqrt(square))
    }))
}

/// What gusts of 5 m/s do to the aim at 0.8 MPa, 28 mm.
pub fn aim() -> String {
    let mut table = Table::new(&["wind of 5 m/s", "I", "20 m", "30 m", "40 m"]);
    for (name, wind) in [("head", (-5.0, 0.0)), ("cross", (0.0, 5.0))] {
        for intensity in [0.0, 0.15, 0.3] {
            let cell = |distance_m| {
                misses(distance_m, wind, intensity).map_or("out of reach".to_owned(), |both| {
                    let [along, across] = both.map(|(mean, sd)| format!("{mean:+.1} ± {sd:.1}"));
                    format!("{along} along, {across} across")
                })
            };
            let head = [name.to_owned(), format!("{intensity}")];
            let cells = [20, 30, 40].map(cell);
            table.row(&head.into_iter().chain(cells).collect::<Vec<_>>());
        }
    }
    table.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The relation between gust factor and intensity that docs/physics.md states.
    #[test]
    fn gust_factors_follow_the_intensity() {
        for (mean, intensity) in [(5.0, 0.15), (10.0, 0.3)] {
            let factor =
                mean_of((0..SEEDS).map(|seed| gust_factor(&blow(mean, intensity, seed), 30)));
            let peak = (factor - 1.0) / intensity;
            assert!((1.7..3.2).contains(&peak), "{mean} {intensity}: {peak}");
        }
    }

    /// Gusts scatter the landing, far out more, and leave its mean about where it was.
    #[test]
    fn gusts_scatter_the_landing() {
        let [still, gusty] = [0.0, 0.3].map(|i| misses(40, (0.0, 5.0), i).unwrap()[1]);
        assert!(still.1 < 1e-9 && gusty.1 > 0.5 && (gusty.0 - still.0).abs() < gusty.1);
        assert!(misses(20, (0.0, 5.0), 0.3).unwrap()[1].1 < 0.5 * gusty.1);
    }
}
