//! A simulated site as the hub publishes it: positions, fires, and where water lands.

use lafet_hub::simulation::{Burning, JetShown, Scene, Splash};
use lafet_hub::site::{Place, Site, Tank, Wall};
use lafet_sim::exercise::{Director, Exercise, FirePlan};
use lafet_sim::fire::Fire;
use lafet_sim::obstacle::Shape;

/// Positions of the objects of a site.
pub fn site(exercise: &Exercise) -> Site {
    let mut site = Site::default();
    for (plan, monitor) in exercise.monitors.iter().zip(&exercise.site.monitors) {
        let (at, heading) = (pair(monitor.pose.at), monitor.pose.heading_deg);
        let place = Place { at, heading, height: monitor.sim.height_m };
        site.monitors.insert(plan.name.clone(), place);
    }
    for (name, obstacle) in exercise.obstacles.iter().zip(&exercise.site.obstacles) {
        let (name, height) = (name.clone(), obstacle.height_m);
        match obstacle.shape {
            Shape::Tank(at, diameter) => {
                site.tanks.push(Tank { name, at: pair(at), diameter, height });
            }
            Shape::Wall(from, to) => {
                site.walls.push(Wall { name, from: pair(from), to: pair(to), height });
            }
        }
    }
    site
}

/// State that only the simulation knows.
pub fn scene(director: &Director, speed: f64) -> Scene {
    let (exercise, site) = (director.exercise(), &director.site);
    let ambient_c = site.members.first().map(|member| member.sim.world().climate.ambient_c);
    let burning = |(plan, fire): (&FirePlan, &Fire)| Burning {
        name: plan.name.clone(),
        at: pair(fire.at),
        size: round(fire.size_m),
        base: fire.spec.base_m,
        burns: fire.burns(),
        heat_kw: round(fire.power_kw()),
        density: round(fire.density),
    };
    let members = exercise.monitors.iter().zip(&site.members).enumerate();
    let jets = members.filter_map(|(index, (plan, member))| {
        let lps = member.sim.world().water.jet_lps();
        let lands = site.landing(index).map(|landing| pair(landing.at));
        let jet = JetShown { lps: round(lps), lands, litres: round(member.litres) };
        (lps > 0.0).then(|| (plan.name.clone(), jet))
    });
    let splashes = site.splashes().iter().filter_map(|splash| {
        let portion = &splash.portion;
        Some(Splash {
            monitor: exercise.monitors.get(splash.monitor)?.name.clone(),
            at: pair(portion.landing.at),
            litres: round(portion.litres),
            foam: round(portion.foam),
        })
    });
    Scene {
        t_s: site.now_ms() as f64 / 1000.0,
        speed,
        wind: pair(site.wind.now_mps()),
        ambient_c,
        fires: exercise.fires.iter().zip(site.fires.iter()).map(burning).collect(),
        jets: jets.collect(),
        splashes: splashes.collect(),
    }
}

fn pair((x, y): (f64, f64)) -> [f64; 2] {
    [round(x), round(y)]
}

/// Rounds to centimetres, which is enough for a picture.
fn round(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}
