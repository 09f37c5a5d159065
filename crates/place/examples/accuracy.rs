//! The figures of docs/coverage.md: `cargo run --release -p lafet-place --example accuracy`.

use std::time::Instant;

use lafet_place::accuracy::two_stations;
use lafet_place::coverage::Coverage;
use lafet_place::planner::{Fire, Situation, Turned, assign, exhaustive, offers, plan, score};
use lafet_place::site::{Direction, Wind};
use lafet_place::{Problem, example};

const DRAWS: usize = 100_000;

fn main() -> Result<(), Problem> {
    places()?;
    plans()?;
    coverage()
}

fn places() -> Result<(), Problem> {
    println!("place, base 40 m, {DRAWS} draws: median, p95, share inside the 95 % ellipse");
    for (sigma_deg, distance_m) in [(0.2, 25.0), (0.2, 50.0), (0.5, 25.0), (0.5, 50.0)] {
        for elevations in [false, true] {
            let case = (40.0, distance_m, f64::to_radians(sigma_deg));
            let found = two_stations(case, elevations, DRAWS, 1)?;
            println!(
                "  {sigma_deg}°, {distance_m} m, {}: {:.2} m, {:.2} m, {:.1} %",
                if elevations { "azimuth and elevation" } else { "azimuth alone" },
                found.median_m,
                found.p95_m,
                100.0 * found.inside
            );
        }
    }
    Ok(())
}

fn plans() -> Result<(), Problem> {
    let (site, _) = example::site(36);
    let fire = |index: u32| Fire {
        at: [18.0 + 16.0 * f64::from(index), 62.0, 0.0],
        area_m2: 60.0,
        density_lpm_m2: 60.0,
    };
    let to = Direction { bearing: 0.0, elevation: 0.2 };
    let wind = Wind { from: 1.0, speed_mps: 6.0 };
    let monitors = vec![Turned { to, works: true }; site.monitors.len()];
    let situation = Situation { fires: (0..5).map(fire).collect(), wind, monitors };
    let started = Instant::now();
    let task = offers(&site, &situation)?;
    let offered = started.elapsed();
    let assignment = assign(&task);
    let assigned = started.elapsed() - offered;
    println!("36 monitors, 5 fires: offers {offered:.0?}, assignment {assigned:.0?}");
    println!("  {:?}", score(&task, &assignment));
    println!("  densities {:.1?} l/min/m²", plan(&site, &situation)?.densities);
    let (small, _) = example::site(6);
    let monitors = situation.monitors[..6].to_vec();
    let fires = situation.fires[..3].to_vec();
    let task = offers(&small, &Situation { monitors, fires, wind })?;
    let best = exhaustive(&task, 5000).map(|best| score(&task, &best));
    println!("6 monitors, 3 fires: {:?}, exact {best:?}", score(&task, &assign(&task)));
    Ok(())
}

fn coverage() -> Result<(), Problem> {
    for monitors in [6, 36] {
        let (site, area) = example::site(monitors);
        let started = Instant::now();
        let coverage = Coverage::of(&site, &area)?;
        let took = started.elapsed();
        let still = &coverage.summary.winds[0];
        println!(
            "coverage 100 m × 100 m at 1 m, {} winds, {monitors} monitors: {took:.1?}; \
             still air, 90 %: one jet {:.1} %, two {:.1} %",
            area.winds.len(),
            100.0 * still.one[1],
            100.0 * still.two[1]
        );
    }
    Ok(())
}
