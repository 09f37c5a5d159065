use super::*;
use crate::jet::Jet;

/// Seconds until it is out under a constant density, `None` after 10 minutes.
fn time_out(fire: &mut Fire, density: f64, foam: f64) -> Option<f64> {
    (0..6000).map(f64::from).find_map(|tenth| {
        fire.wet(density * fire.area_m2() * 0.1, foam);
        fire.step(0.1);
        (!fire.burns()).then_some((tenth + 1.0) / 10.0)
    })
}

#[test]
fn goes_out_above_the_critical_density_alone() {
    let fire = || Fire::new(FireSpec { size_m: 1.5, ..FireSpec::default() });
    assert_eq!(time_out(&mut fire(), 0.05, 0.0), None);
    let direct = time_out(&mut fire(), 4.0, 0.0).unwrap();
    let swept = time_out(&mut fire(), 0.25, 0.0).unwrap();
    let foam = time_out(&mut fire(), 0.25, 1.0).unwrap();
    assert!((10.0..14.0).contains(&direct), "{direct}");
    assert!((45.0..65.0).contains(&swept), "{swept}");
    assert!(foam < 0.75 * swept, "{foam}");
}

/// A footprint of 4π m² over a fire of 1 m²: a part of 0.08 of the water is its own.
#[test]
fn catches_what_lands_on_it() {
    let landing = crate::jet::Landing {
        at: (20.0, 0.0),
        flight_s: 1.0,
        along_m: 4.0,
        across_m: 1.0,
        heading: 0.0,
        // Straight down: nothing is in the way.
        slope: 1e6,
    };
    let portion = Portion { litres: 2.0, foam: 0.0, jet: Jet::solid(0.8, 28.0, 0.3), landing };
    let catch = |azimuth_deg: f64, size_m: f64| {
        let mut fire = Fire::new(FireSpec { azimuth_deg, size_m, ..FireSpec::default() });
        (fire.catch(&portion), fire.landed_l)
    };
    let (hit, litres) = catch(0.0, 1.128);
    assert!(hit && (litres - 2.0 / 12.566).abs() < 0.001, "{litres}");
    assert_eq!(catch(20.0, 1.128), (false, 0.0));
    let (hit, litres) = catch(0.0, 30.0);
    assert!(hit && litres == 2.0, "{litres}");
}

/// Water on its way to the ground behind a fire strikes the fire, as far as it is high.
#[test]
fn catches_what_passes_through_it() {
    let mut fire = Fire::new(FireSpec { size_m: 2.0, ..FireSpec::default() });
    let mut catch = |behind_m: f64, slope: f64| {
        let landing = Landing {
            at: (20.0 + behind_m, 0.0),
            flight_s: 1.0,
            along_m: 0.3,
            across_m: 0.3,
            heading: 0.0,
            slope,
        };
        fire.catch(&Portion { litres: 1.0, foam: 0.0, jet: Jet::solid(0.8, 28.0, 0.3), landing })
    };
    assert!(catch(0.0, 0.5) && catch(2.0, 0.5) && catch(3.5, 0.5));
    assert!(!catch(5.5, 0.5) && !catch(-1.5, 0.5) && !catch(2.0, 1e6));
}

#[test]
fn recovers_and_grows_when_left_alone() {
    let mut fire = Fire::new(FireSpec { growth_mps: 0.01, ..FireSpec::default() });
    fire.heat = 0.5;
    (0..600).for_each(|_| fire.step(0.1));
    assert!(fire.heat > 0.9 && (fire.size_m - 1.6).abs() < 0.01);
    (0..6000).for_each(|_| fire.step(0.1));
    assert_eq!(fire.size_m, 2.0);
}

#[test]
fn embers_flare_up_unless_drowned() {
    let lit = FireSpec { reignites: true, ..FireSpec::default() };
    let mut fire = Fire::new(lit);
    time_out(&mut fire, 4.0, 0.0).unwrap();
    (0..600).for_each(|_| fire.step(0.1));
    assert!(fire.burns());
    let mut drowned = Fire::new(lit);
    time_out(&mut drowned, 4.0, 0.0).unwrap();
    for _ in 0..400 {
        drowned.wet(4.0 * drowned.area_m2() * 0.1, 0.0);
        drowned.step(0.1);
    }
    (0..600).for_each(|_| drowned.step(0.1));
    assert!(!drowned.burns());
}

#[test]
fn reads_a_spec() {
    let spec: FireSpec = "az=-30,range=25,size=1.5".parse().unwrap();
    assert_eq!((spec.azimuth_deg, spec.range_m, spec.size_m), (-30.0, 25.0, 1.5));
    assert_eq!(spec.class, Class::Solid);
    let pool: FireSpec = "az=0,range=20,class=hydrocarbon".parse().unwrap();
    assert_eq!(pool.class, Class::Hydrocarbon);
    for bad in [
        "",
        "az=30",
        "range=25",
        "az=x,range=1",
        "az=1,range=0",
        "az=1,range=5,hue=2",
        "az=1,range=5,class=gas",
    ] {
        assert!(bad.parse::<FireSpec>().is_err(), "{bad}");
    }
    for (bad, english, russian) in [
        ("az=x,range=1", "`az=x`: `x` is not a number", "`az=x`: `x` — не число"),
        ("az=1,range=0", "`range=0`: least is 0.5", "`range=0`: не меньше 0,5"),
        (
            "az=1,range=5,class=gas",
            "`class=gas`: solid or hydrocarbon",
            "`class=gas`: solid или hydrocarbon",
        ),
        ("range=25", "az= and range= are needed", "нужны az= и range="),
    ] {
        let error = bad.parse::<FireSpec>().unwrap_err();
        assert_eq!((error.en.as_str(), error.ru.as_str()), (english, russian), "{bad}");
    }
}

fn pair(gap_m: f64, size_m: f64) -> Vec<Fire> {
    let fire = |range_m, lit| Fire::new(FireSpec { range_m, size_m, lit, ..FireSpec::default() });
    vec![fire(20.0, true), fire(20.0 + gap_m, false)]
}

/// 2 m burning: 1571 kW, 37.5 kW/m² at 1 m, 12 kW/m² at 1.77 m.
#[test]
fn spreads_to_what_is_near() {
    let catches = |gap_m: f64| {
        let mut fires = pair(gap_m, 2.0);
        (0..6000).map(f64::from).find_map(|tenth| {
            spread(&mut fires, 0.1);
            fires[1].burns().then_some((tenth + 1.0) / 10.0)
        })
    };
    assert!((pair(1.0, 2.0)[0].flux_kw_m2((21.0, 0.0)) - 37.5).abs() < 0.1);
    let near = catches(1.0).unwrap();
    assert!((23.0..24.5).contains(&near), "{near}");
    assert!(catches(1.6).unwrap() > 2.0 * near);
    assert_eq!(catches(1.8), None);
}

#[test]
fn what_is_wet_does_not_catch() {
    let mut fires = pair(1.0, 2.0);
    for _ in 0..3000 {
        let area = fires[1].area_m2();
        fires[1].wet(0.1 * area * 0.1, 0.0);
        fires[1].step(0.1);
        spread(&mut fires, 0.1);
    }
    assert!(fires[0].burns() && !fires[1].burns());
}

/// A thing that has never burned has no embers; t² growth as the head says.
#[test]
fn cold_things_and_growth() {
    let mut cold = Fire::new(FireSpec { lit: false, reignites: true, ..FireSpec::default() });
    (0..1000).for_each(|_| cold.step(0.1));
    assert!(!cold.burns() && cold.power_kw() == 0.0);
    let grown = FireSpec { size_m: 0.05, growth_mps: 0.0109, ..FireSpec::default() };
    let power = HEAT_KW_M2 * FRAC_PI_4 * libm::pow(grown.growth_mps * 100.0, 2.0);
    assert!((power / (0.0469 * 100.0 * 100.0) - 1.0).abs() < 0.01, "{power}");
}

fn pool(reignites: bool) -> Fire {
    let class = Class::Hydrocarbon;
    Fire::new(FireSpec { size_m: 4.0, class, reignites, ..FireSpec::default() })
}

/// Water alone never puts out light fuel; foam does, and what covers it keeps it out until the
/// blanket has drained away.
#[test]
fn light_fuel_needs_foam() {
    assert_eq!(time_out(&mut pool(false), 4.0, 0.0), None);
    assert_eq!(time_out(&mut pool(false), crate::foam::DESTROYED, 1.0), None);
    let mut fire = pool(false);
    let out_s = time_out(&mut fire, 0.1, 1.0).unwrap();
    assert!((20.0..120.0).contains(&out_s) && fire.covered() == 1.0, "{out_s}");
    (0..36_000).for_each(|_| fire.step(0.1));
    assert!(!fire.burns() && fire.covered() < 0.1, "it has nothing that lights it");
}

/// An attack that ends too soon: the rest burns back.
#[test]
fn burns_back() {
    let mut fire = pool(false);
    while fire.covered() < 0.8 {
        fire.wet(0.1 * fire.area_m2() * 0.1, 1.0);
        fire.step(0.1);
    }
    (0..300).for_each(|_| fire.step(0.1));
    let (heat, covered) = (fire.heat, fire.covered());
    assert!(fire.burns() && covered < 0.8, "{heat} {covered}");
    (0..6_000).for_each(|_| fire.step(0.1));
    assert!(fire.heat > 0.9 && fire.covered() < 0.1, "{} {}", fire.heat, fire.covered());
}

/// Hot metal lights the fuel again where the foam has been washed off.
#[test]
fn hot_metal_lights_it_again() {
    let again = |reignites| {
        let mut fire = pool(reignites);
        time_out(&mut fire, 0.1, 1.0).unwrap();
        for _ in 0..600 {
            fire.wet(0.5 * fire.area_m2() * 0.1, 0.0);
            fire.step(0.1);
        }
        fire.burns()
    };
    assert!(again(true) && !again(false));
}

/// What is beside a fire and under foam does not catch, however long it is heated.
#[test]
fn foam_shields() {
    let mut fires = pair(1.0, 2.0);
    fires[1] = Fire::new(FireSpec { class: Class::Hydrocarbon, ..fires[1].spec });
    for step in 0..6_000 {
        let area = fires[1].area_m2();
        fires[1].wet(0.02 * area * 0.1, 1.0);
        fires[1].step(0.1);
        if step > 3_000 {
            spread(&mut fires, 0.1);
        }
    }
    assert!(!fires[1].burns() && fires[1].covered() == 1.0 && fires[1].heated() == 0.0);
}
