use super::*;
use crate::draw::Draw;
use crate::station::tests::{bearing, station};

const SIGMA: f64 = 0.2 * std::f64::consts::PI / 180.0;
const FIRES: [[f64; 3]; 2] = [[-8.0, 25.0, 0.0], [9.0, 31.0, 3.0]];

fn seen(
    stations: &[Station],
    fires: &[[f64; 3]],
    elevations: bool,
    draw: &mut Draw,
) -> Vec<Bearing> {
    let mut all = Vec::new();
    for (index, station) in stations.iter().enumerate() {
        for fire in fires {
            let (azimuth, elevation) = station.sees(*fire);
            let azimuth = azimuth + SIGMA * draw.error();
            let elevation = elevations.then_some(elevation + SIGMA * draw.error());
            all.push(bearing(index, azimuth, elevation, SIGMA));
        }
    }
    all
}

fn pair() -> [Station; 2] {
    [station(-20.0, 0.0, 6.0), station(20.0, 0.0, 6.0)]
}

fn near(fix: &Fix, fires: &[[f64; 3]]) -> bool {
    fires.iter().any(|fire| (fix.at[0] - fire[0]).hypot(fix.at[1] - fire[1]) < 2.0)
}

/// Azimuths of two fires from two stations: four crossings, all shown, none to be aimed at.
#[test]
fn ghosts_are_never_aimed_at() {
    let mut draw = Draw::new(1);
    for _ in 0..200 {
        let bearings = seen(&pair(), &FIRES, false, &mut draw);
        let found = fires(&pair(), &bearings, 0.0, None).unwrap();
        assert_eq!(found.len(), 4);
        assert!(found.iter().all(|it| it.standing == Standing::Doubtful && it.aim().is_none()));
        for fire in FIRES {
            assert!(found.iter().any(|it| near(&it.fix, &[fire])), "{found:?}");
        }
    }
}

/// A third station decides; what remains of the ghosts is shown as such.
#[test]
fn a_third_station_decides() {
    let [left, right] = pair();
    let stations = [left, right, station(5.0, 60.0, 6.0)];
    let mut draw = Draw::new(2);
    let mut decided = 0;
    for _ in 0..300 {
        let bearings = seen(&stations, &FIRES, false, &mut draw);
        let found = fires(&stations, &bearings, 0.0, None).unwrap();
        let sure: Vec<&Fix> = found.iter().filter_map(Candidate::aim).collect();
        assert!(sure.iter().all(|fix| near(fix, &FIRES)), "{found:?}");
        decided += usize::from(sure.len() == 2);
        assert!(found.iter().any(|it| it.standing == Standing::Ghost), "{found:?}");
    }
    assert!(decided >= 295, "{decided}");
}

/// So does the elevation, where the ghosts would float or lie at different heights for the two.
#[test]
fn elevations_decide() {
    let mut draw = Draw::new(3);
    let mut decided = 0;
    for _ in 0..300 {
        let bearings = seen(&pair(), &FIRES, true, &mut draw);
        let found = fires(&pair(), &bearings, 0.0, None).unwrap();
        let sure: Vec<&Fix> = found.iter().filter_map(Candidate::aim).collect();
        assert!(sure.iter().all(|fix| near(fix, &FIRES)), "{found:?}");
        decided += usize::from(sure.len() == 2);
    }
    assert!(decided >= 290, "{decided}");
}

/// Fires anywhere: what is aimed at is a fire, always; with a third station nearly all are found.
#[test]
fn nothing_but_fires_is_aimed_at() {
    let [left, right] = pair();
    let stations = [left, right, station(0.0, 70.0, 8.0)];
    let mut draw = Draw::new(4);
    let (mut aimed, mut wrong) = (0, 0);
    for round in 0..1000 {
        let burning: Vec<[f64; 3]> = (0..1 + round % 3)
            .map(|_| [draw.between(-25.0, 25.0), draw.between(10.0, 55.0), draw.between(0.0, 4.0)])
            .collect();
        let bearings = seen(&stations, &burning, true, &mut draw);
        for candidate in fires(&stations, &bearings, 0.0, None).unwrap() {
            let Some(fix) = candidate.aim() else { continue };
            aimed += 1;
            wrong += usize::from(!near(fix, &burning));
        }
    }
    assert!(wrong == 0 && aimed > 1900, "{wrong} of {aimed}");
}

/// A false bearing beside a fire that three stations see makes no second fire.
#[test]
fn a_false_bearing_is_no_fire() {
    let [left, right] = pair();
    let stations = [left, right, station(0.0, 70.0, 8.0)];
    let mut draw = Draw::new(5);
    let mut bearings = seen(&stations, &FIRES[..1], false, &mut draw);
    bearings.push(bearing(0, -0.4, None, SIGMA));
    let found = fires(&stations, &bearings, 0.0, None).unwrap();
    let sure: Vec<&Fix> = found.iter().filter_map(Candidate::aim).collect();
    assert!(sure.len() == 1 && near(sure[0], &FIRES[..1]), "{found:?}");
}

#[test]
fn what_lies_outside_of_the_area_is_a_ghost() {
    let mut draw = Draw::new(6);
    let bearings = seen(&pair(), &FIRES[..1], false, &mut draw);
    let inside = fires(&pair(), &bearings, 0.0, Some([[-30.0, 0.0], [30.0, 60.0]])).unwrap();
    assert_eq!(inside[0].standing, Standing::Sure);
    let outside = fires(&pair(), &bearings, 0.0, Some([[0.0, 0.0], [30.0, 60.0]])).unwrap();
    assert_eq!((outside.len(), outside[0].standing), (1, Standing::Ghost));
}

/// A flood of bearings ends in time, with nothing to aim at.
#[test]
fn a_flood_is_bounded() {
    let stations = [station(-20.0, 0.0, 6.0), station(20.0, 0.0, 6.0)];
    let mut bearings = Vec::new();
    for index in 0..32 {
        let offset = f64::from(index) * 0.02;
        bearings.push(bearing(0, -0.3 - offset, None, SIGMA));
        bearings.push(bearing(1, 0.3 + offset, None, SIGMA));
    }
    let found = fires(&stations, &bearings, 0.0, None).unwrap();
    assert!(found.len() <= CANDIDATES_MAX && found.iter().all(|it| it.aim().is_none()));
    assert!(fires(&stations, &vec![bearings[0]; 65], 0.0, None).is_err());
}
