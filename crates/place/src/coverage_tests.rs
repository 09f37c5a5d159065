use super::*;
use crate::reach::{OF_STILL_THROW, OF_THROW};
use crate::site::Monitor;
use crate::site::tests::{monitor, site};
use crate::supply::Supply;

fn area(size: f64, winds: Vec<Wind>) -> Area {
    let corner = [-0.5 * size; 2];
    Area { corner, size: [size; 2], cell_m: 2.0, plane_m: 0.0, winds, flowing: 1 }
}

/// In still air a monitor without obstacles covers a ring: its shares follow from its throw.
#[test]
fn one_monitor_covers_a_ring() {
    let one = site(vec![monitor(0.0, 0.0)]);
    let area = area(100.0, Vec::new());
    let coverage = Coverage::of(&one, &area).unwrap();
    assert_eq!(coverage.cells, [50, 50]);
    let throw = Cache::default().of(&one.monitors[0], 0.8, 0.0, 0.0).unwrap().farthest_m();
    for (rule, part) in
        [(Rule::Reached, 1.0), (Rule::Within90, OF_THROW), (Rule::Within75, OF_STILL_THROW)]
    {
        let counts = coverage.counts(0, rule);
        let (mut inside, mut outside) = (0, 0);
        for (index, jets) in counts.iter().enumerate() {
            let [east, north] = area.centre(index);
            let distance = east.hypot(north);
            if (12.0..part * throw - 0.1).contains(&distance) {
                assert_eq!(*jets, 1, "{rule:?} {distance}");
                inside += 1;
            } else if distance > part * throw + 0.1 {
                assert_eq!(*jets, 0, "{rule:?} {distance}");
                outside += 1;
            }
        }
        assert!(inside > 500 && outside > 500, "{inside} {outside}");
    }
    assert!(coverage.counts(1, Rule::Reached).is_empty());
    let lost = &coverage.summary.lost[0];
    assert!((lost.none_left - coverage.summary.winds[0].one[1]).abs() < 1e-12);
    assert_eq!((lost.one_left, coverage.summary.winds[0].two), (0.0, [0.0; 3]));
}

/// A wind carries the ring with it.
#[test]
fn wind_moves_it() {
    let one = site(vec![monitor(0.0, 0.0)]);
    let north = Wind { from: 0.0, speed_mps: 8.0 };
    let area = area(100.0, vec![north]);
    let coverage = Coverage::of(&one, &area).unwrap();
    let count = |rule, northern: bool| {
        let cells = coverage.counts(1, rule).iter().enumerate();
        cells
            .filter(|(index, jets)| **jets > 0 && (area.centre(*index)[1] > 0.0) == northern)
            .count()
    };
    for rule in [Rule::Reached, Rule::Within90] {
        assert!(count(rule, true) + 100 < count(rule, false), "{rule:?}");
    }
    let summary = &coverage.summary;
    assert_eq!((summary.winds.len(), summary.winds[1].wind), (2, north));
    // The weakest points lie apart, and none is better than those that follow.
    assert_eq!(summary.weakest.len(), WEAKEST_MAX);
    assert!(summary.weakest.windows(2).all(|pair| pair[0].fewest <= pair[1].fewest));
}

#[test]
fn two_monitors_and_what_a_loss_costs() {
    let two = site(vec![monitor(-10.0, 0.0), monitor(10.0, 0.0)]);
    let coverage = Coverage::of(&two, &area(60.0, Vec::new())).unwrap();
    let InWind { one, two, .. } = coverage.summary.winds[0];
    assert!(one[1] > 0.9 && two[1] > 0.7 && two[1] < one[1], "{one:?} {two:?}");
    let [left, right] = &coverage.summary.lost[..] else { panic!() };
    assert!(
        (left.one_left - two[1]).abs() < 1e-12 && (left.one_left - right.one_left).abs() < 1e-12
    );
    assert!(
        left.none_left > 0.0 && (left.none_left + right.none_left + two[1] - one[1]).abs() < 1e-9
    );
    assert_eq!(left.monitor, "-10/0");
}

/// Where an obstacle is nothing is protected, and its shadow is not reached by a low barrel.
#[test]
fn obstacles_stand_and_shade() {
    let tower = Body::Box { at: [15.0, 0.0], size: [4.0; 2], heading: 0.0, heights: [0.0, 25.0] };
    let low = Monitor { elevations: [-0.26, 0.6], ..monitor(0.0, 0.0) };
    let site = Site { obstacles: vec![tower], ..site(vec![low]) };
    let area = area(80.0, Vec::new());
    let coverage = Coverage::of(&site, &area).unwrap();
    let at = |east: f64, north: f64| {
        let cell = |x: f64| ((x + 40.0) / 2.0) as usize;
        coverage.counts(0, Rule::Reached)[cell(north) * 40 + cell(east)]
    };
    assert_eq!((at(15.0, 0.5), at(25.0, 0.5), at(-25.0, 0.5)), (COVERED, 0, 1));
    assert_eq!(coverage.summary.protected, 1600 - 6);
}

/// Two that flow together leave less pressure for each.
#[test]
fn pressure_counts() {
    let supply = Supply::parabola(1.0, 1200.0, 0.6).unwrap();
    let both = Site { supply, ..site(vec![monitor(-10.0, 0.0), monitor(10.0, 0.0)]) };
    let alone = Coverage::of(&both, &area(100.0, Vec::new())).unwrap();
    let together = Coverage::of(&both, &Area { flowing: 2, ..area(100.0, Vec::new()) }).unwrap();
    assert!(together.pressure_mpa < alone.pressure_mpa);
    assert!(together.summary.winds[0].one[1] < alone.summary.winds[0].one[1]);
}

#[test]
fn bounds() {
    let one = site(vec![monitor(0.0, 0.0)]);
    let good = area(20.0, Vec::new());
    let wind = Wind { from: 0.0, speed_mps: 1.0 };
    for (wrong, words) in [
        (Area { cell_m: 0.01, ..good.clone() }, "side of a cell"),
        (Area { size: [5000.0; 2], cell_m: 1.0, ..good.clone() }, "cells"),
        (Area { corner: [f64::NAN, 0.0], ..good.clone() }, "corner"),
        (Area { plane_m: f64::INFINITY, ..good.clone() }, "plane"),
        (Area { winds: vec![wind; 17], ..good.clone() }, "17 winds"),
        (Area { flowing: 2, ..good.clone() }, "flow together"),
        (Area { flowing: 0, ..good }, "flow together"),
    ] {
        let problem = Coverage::of(&one, &wrong).unwrap_err();
        assert!(problem.0.en.contains(words) && !problem.0.ru.is_empty(), "{problem}");
    }
}
