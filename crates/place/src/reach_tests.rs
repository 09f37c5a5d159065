use super::*;
use crate::site::tests::{monitor, sector, site};
use crate::site::{For, KeepOut, Monitor};

const STILL: (Wind, f64, f64) = (Wind { from: 0.0, speed_mps: 0.0 }, 0.8, 0.0);

fn aim(site: &Site, index: usize, place: [f64; 2]) -> Result<Aim, Hindrance> {
    Reach::new(site, index, STILL, &mut Cache::default()).unwrap().aim(place)
}

#[test]
fn rules_of_75_and_90() {
    let one = site(vec![monitor(0.0, 0.0)]);
    let throw = aim(&one, 0, [0.0, 20.0]).unwrap().throw_m;
    for (part, within_75, within_90) in
        [(0.74, true, true), (0.76, false, true), (0.89, false, true), (0.91, false, false)]
    {
        let aim = aim(&one, 0, [part * throw, 0.0]).unwrap();
        assert_eq!((aim.is_within_75(), aim.is_within_90()), (within_75, within_90), "{part}");
    }
    assert_eq!(aim(&one, 0, [0.0, 1.02 * throw]), Err(Hindrance::TooFar));
    assert_eq!(aim(&one, 0, [0.0, 2.0]), Err(Hindrance::TooNear));
    assert_eq!(aim(&one, 0, [0.0, 0.1]), Err(Hindrance::TooNear));
    let empty = Reach::new(&one, 0, (Wind::default(), 0.05, 0.0), &mut Cache::default());
    assert!(matches!(empty, Err(Hindrance::Pressure)));
}

/// Against the wind the throw shrinks; the rule of 75 % stays with that in still air.
#[test]
fn wind_counts_for_the_rule_of_90() {
    let one = site(vec![monitor(0.0, 0.0)]);
    let wind = Wind { from: 0.0, speed_mps: 10.0 };
    let reach = Reach::new(&one, 0, (wind, 0.8, 0.0), &mut Cache::default()).unwrap();
    let against = reach.aim([0.0, 27.0]).unwrap();
    let with = reach.aim([0.0, -27.0]).unwrap();
    assert!(against.throw_m < against.still_throw_m - 5.0, "{against:?}");
    assert!(with.throw_m > with.still_throw_m + 5.0, "{with:?}");
    assert!(against.is_within_75() && !against.is_within_90() && with.is_within_90());
}

#[test]
fn over_a_wall_with_the_high_jet() {
    let wall = Body::Box { at: [0.0, 15.0], size: [1.0, 30.0], heading: 0.0, heights: [0.0, 9.0] };
    let walled = Site { obstacles: vec![wall], ..site(vec![monitor(0.0, 0.0)]) };
    let before = aim(&walled, 0, [0.0, 12.0]).unwrap();
    assert!(!before.steep);
    let behind = aim(&walled, 0, [0.0, 26.0]).unwrap();
    assert!(behind.steep && behind.direction.elevation > 0.9, "{behind:?}");
    let low = Monitor { elevations: [-0.26, 0.8], ..monitor(0.0, 0.0) };
    let walled = Site { monitors: vec![low], ..walled };
    assert_eq!(aim(&walled, 0, [0.0, 26.0]), Err(Hindrance::Obstacle(0)));
    assert!(aim(&walled, 0, [30.0, 0.0]).is_ok(), "beside it");
}

#[test]
fn keep_outs_and_other_monitors() {
    let zone = Body::Cylinder { at: [0.0, 20.0], radius_m: 2.0, heights: [0.0, 12.0] };
    let people = KeepOut { of: For::People, place: Kept::Zone(zone) };
    let kept = Site { keep_outs: vec![people], ..site(vec![monitor(0.0, 0.0)]) };
    assert_eq!(aim(&kept, 0, [0.0, 20.0]), Err(Hindrance::KeepOut(0)));
    assert_eq!(aim(&kept, 0, [0.5, 28.0]).map(|it| it.steep), Ok(true));
    assert!(aim(&kept, 0, [10.0, 20.0]).is_ok());

    let sectors = vec![sector([1.0, 2.0], [-1.0, 1.5])];
    let kept = Site { keep_outs: sectors, ..site(vec![monitor(0.0, 0.0)]) };
    assert_eq!(aim(&kept, 0, [20.0, 0.0]), Err(Hindrance::KeepOut(0)));
    assert!(aim(&kept, 0, [-20.0, 0.0]).is_ok());

    let low = |east: f64| Monitor { elevations: [-0.26, 0.5], ..monitor(east, 0.0) };
    let two = site(vec![low(0.0), low(20.0)]);
    assert_eq!(aim(&two, 0, [20.5, 0.0]), Err(Hindrance::Monitor(1)));
    assert!(aim(&two, 0, [20.0, 4.0]).is_ok());
    assert_eq!(aim(&two, 1, [20.0, 4.0]), Err(Hindrance::TooNear));
}

#[test]
fn sweeps_keep_clear() {
    let zone = Body::Cylinder { at: [0.0, 20.0], radius_m: 2.0, heights: [0.0, 12.0] };
    let people = KeepOut { of: For::People, place: Kept::Zone(zone) };
    let kept = Site { keep_outs: vec![people], ..site(vec![monitor(0.0, 0.0)]) };
    let gun = Gun::new(&kept.monitors[0], 0.8, Wind::default(), 0.0).unwrap();
    let [west, east, north_west] =
        [-0.5, 0.5, -0.2].map(|bearing| Direction { bearing, elevation: 0.15 });
    assert_eq!(sweeping(&kept, 0, &gun, [west, east]), Err(Hindrance::KeepOut(0)));
    assert_eq!(sweeping(&kept, 0, &gun, [west, north_west]), Ok(()));
    // Round the back, if that is where the limits lead.
    let narrow = Monitor { heading: 3.1, azimuths: [-2.9, 2.9], ..monitor(0.0, 0.0) };
    let kept = Site { monitors: vec![narrow], ..kept };
    assert_eq!(sweeping(&kept, 0, &gun, [west, east]), Ok(()));
    let turn = turning_s(&kept, 0, [west, east]).unwrap();
    assert!((turn - (std::f64::consts::TAU - 1.0) / 0.35).abs() < 1e-6, "{turn}");
    // A wall on the way is no reason to stop.
    let wall = Body::Cylinder { at: [-5.0, 18.0], radius_m: 1.0, heights: [0.0, 9.0] };
    let walled =
        Site { obstacles: vec![wall], keep_outs: Vec::new(), ..site(vec![monitor(0.0, 0.0)]) };
    assert_eq!(sweeping(&walled, 0, &gun, [west, east]), Ok(()));
}
