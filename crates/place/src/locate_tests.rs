use super::*;
use crate::accuracy::two_stations;
use crate::draw::Draw;
use crate::station::tests::{bearing, station};

const SIGMA: f64 = 0.2 * PI / 180.0;

fn seen(stations: &[Station], fire: Place, elevations: bool) -> Vec<Bearing> {
    let see = |(index, station): (usize, &Station)| {
        let (azimuth, elevation) = station.sees(fire);
        bearing(index, azimuth, elevations.then_some(elevation), SIGMA)
    };
    stations.iter().enumerate().map(see).collect()
}

#[test]
fn exact_bearings_give_the_place() {
    let stations = [station(-20.0, 0.0, 6.0), station(20.0, 0.0, 4.0)];
    let fire = [3.0, 25.0, 1.0];
    let fix = locate(&stations, &seen(&stations, fire, true), 0.0).unwrap();
    assert!((fix.at[0] - 3.0).abs() < 1e-6 && (fix.at[1] - 25.0).abs() < 1e-6, "{fix:?}");
    assert!((fix.height_m.unwrap() - 1.0).abs() < 1e-6, "{fix:?}");
    assert_eq!(fix.misfit.1, 1);
    let flat = locate(&stations, &seen(&stations, fire, false), 0.0).unwrap();
    assert!((flat.at[1] - 25.0).abs() < 1e-6 && flat.height_m.is_none(), "{flat:?}");
    assert_eq!(flat.covariance[2], [0.0; 3]);
}

/// The goals of docs/coverage.md; `examples/accuracy.rs` prints the figures of 1e5 draws.
#[test]
fn as_accurate_as_promised() {
    for (distance, bound) in [(25.0, 0.4), (50.0, 0.9)] {
        for elevations in [false, true] {
            let figures = two_stations((40.0, distance, SIGMA), elevations, 8000, 11).unwrap();
            assert!(figures.p95_m <= bound && figures.p95_m > 0.5 * bound, "{figures:?}");
            assert!((0.93..=0.97).contains(&figures.inside), "{figures:?}");
        }
    }
}

/// The long axis of the ellipse points away from the base, and grows with the probability.
#[test]
fn ellipses() {
    let stations = [station(-20.0, 0.0, 0.0), station(20.0, 0.0, 0.0)];
    let fix = locate(&stations, &seen(&stations, [0.0, 60.0, 0.0], false), 0.0).unwrap();
    let ellipse = fix.ellipse(0.95).unwrap();
    // Bearing 0 is north: away from a base that lies along the east axis.
    assert!(ellipse.direction.min(PI - ellipse.direction) < 1e-3, "{ellipse:?}");
    let distance = 20.0_f64.hypot(60.0);
    let scale = (-2.0 * 0.05_f64.ln()).sqrt() * SIGMA * distance / 2.0_f64.sqrt();
    assert!((ellipse.minor_m - scale * distance / 60.0).abs() < 1e-3, "{ellipse:?}");
    assert!((ellipse.major_m - scale * distance / 20.0).abs() < 1e-3, "{ellipse:?}");
    assert!(fix.ellipse(0.99).unwrap().major_m > ellipse.major_m);
    assert!(fix.holds([0.0, 60.0 + 0.99 * ellipse.major_m], 0.95).unwrap());
    assert!(!fix.holds([0.0, 60.0 + 1.01 * ellipse.major_m], 0.95).unwrap());
    assert!(!fix.holds([1.01 * ellipse.minor_m, 60.0], 0.95).unwrap());
    for probability in [0.0, 1.0, f64::NAN] {
        assert!(fix.ellipse(probability).is_err());
    }
}

#[test]
fn a_gross_error_is_left_out() {
    let stations = [station(-20.0, 0.0, 6.0), station(20.0, 0.0, 6.0), station(0.0, 60.0, 6.0)];
    let fire = [4.0, 22.0, 0.0];
    let mut draw = Draw::new(3);
    for wrong in 0..3 {
        let mut bearings = seen(&stations, fire, true);
        for bearing in &mut bearings {
            bearing.azimuth += SIGMA * draw.error();
        }
        bearings[wrong].azimuth += 0.15;
        let fix = locate(&stations, &bearings, 0.0).unwrap();
        assert_eq!(fix.rejected, [wrong]);
        assert!((fix.at[0] - 4.0).hypot(fix.at[1] - 22.0) < 0.8, "{fix:?}");
    }
}

/// Two stations whose elevations contradict each other: no place rather than a wrong one.
#[test]
fn what_cannot_be_decided_is_no_place() {
    let stations = [station(-20.0, 0.0, 6.0), station(20.0, 0.0, 6.0)];
    let mut bearings = seen(&stations, [4.0, 22.0, 0.0], true);
    bearings[0].elevation = Some(0.3);
    let problem = locate(&stations, &bearings, 0.0).unwrap_err();
    assert!(problem.0.en.contains("do not meet") && problem.0.ru.contains("не сходятся"));
}

#[test]
fn parallel_and_diverging_lines_of_sight_are_no_place() {
    let stations = [station(-20.0, 0.0, 6.0), station(20.0, 0.0, 6.0)];
    for (left, right) in [(0.0, 0.0), (0.5, -0.5), (0.001, 0.0)] {
        let bearings = [bearing(0, left, None, SIGMA), bearing(1, right, None, SIGMA)];
        let problem = locate(&stations, &bearings, 0.0).unwrap_err();
        assert!(problem.0.en.contains("do not cross"), "{problem}");
    }
    let same = [bearing(0, 0.1, None, SIGMA), bearing(0, 0.4, None, SIGMA)];
    assert!(locate(&stations, &same, 0.0).is_err());
}

#[test]
fn no_numbers_and_too_many() {
    let stations = [station(-20.0, 0.0, 6.0), station(20.0, 0.0, 6.0)];
    let good = seen(&stations, [4.0, 22.0, 0.0], true);
    assert!(locate(&stations, &good, f64::NAN).is_err());
    assert!(locate(&[], &good, 0.0).is_err());
    let many = vec![good[0]; BEARINGS_MAX + 1];
    assert!(locate(&stations, &many, 0.0).is_err());
    let nan = [Bearing { azimuth: f64::NAN, ..good[0] }, good[1]];
    assert!(locate(&stations, &nan, 0.0).is_err());
}

#[test]
fn quantiles() {
    for (spare, quantile) in [(1, 10.83), (2, 13.82), (3, 16.27), (10, 29.59)] {
        assert!((greatest_misfit(spare) - quantile).abs() < 0.3, "{spare}");
    }
}
