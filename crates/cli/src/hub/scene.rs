//! A simulated site as the hub publishes it: where things stand, what burns, where water lands.

use lafet_sim::exercise::{Director, Exercise};
use lafet_sim::obstacle::Shape;
use serde_json::{Map, Value, json};

/// Where things stand: metres east and north, bearings clockwise from north.
pub fn site(exercise: &Exercise) -> Value {
    let monitors = exercise.monitors.iter().zip(&exercise.site.monitors).map(|(plan, monitor)| {
        let place = json!({
            "at": pair(monitor.pose.at), "heading": monitor.pose.heading_deg,
            "height": monitor.sim.height_m,
        });
        (plan.name.clone(), place)
    });
    let monitors: Map<String, Value> = monitors.collect();
    let (mut tanks, mut walls) = (Vec::new(), Vec::new());
    for (name, obstacle) in exercise.obstacles.iter().zip(&exercise.site.obstacles) {
        match obstacle.shape {
            Shape::Tank(at, diameter) => tanks.push(json!({
                "name": name, "at": pair(at), "diameter": diameter, "height": obstacle.height_m,
            })),
            Shape::Wall(from, to) => walls.push(json!({
                "name": name, "from": pair(from), "to": pair(to), "height": obstacle.height_m,
            })),
        }
    }
    json!({ "monitors": monitors, "tanks": tanks, "walls": walls })
}

/// What only the simulation knows.
pub fn scene(director: &Director, speed: f64) -> Value {
    let (exercise, site) = (director.exercise(), &director.site);
    let ambient_c = site.members.first().map(|member| member.sim.world().climate.ambient_c);
    let fires: Vec<Value> = exercise
        .fires
        .iter()
        .zip(site.fires.iter())
        .map(|(plan, fire)| {
            json!({
                "name": plan.name, "at": pair(fire.at), "size": round(fire.size_m),
                "base": fire.spec.base_m, "burns": fire.burns(),
                "heat_kw": round(fire.power_kw()), "density": round(fire.density),
            })
        })
        .collect();
    let mut jets = Map::new();
    for (index, (plan, member)) in exercise.monitors.iter().zip(&site.members).enumerate() {
        let lps = member.sim.world().water.jet_lps();
        if lps > 0.0 {
            let lands = site.landing(index).map(|landing| pair(landing.at));
            let jet = json!({ "lps": round(lps), "lands": lands, "litres": round(member.litres) });
            jets.insert(plan.name.clone(), jet);
        }
    }
    let splashes: Vec<Value> = site
        .splashes()
        .iter()
        .filter_map(|splash| {
            let name = &exercise.monitors.get(splash.monitor)?.name;
            let (at, portion) = (pair(splash.portion.landing.at), &splash.portion);
            Some(json!({
                "monitor": name, "at": at, "litres": round(portion.litres),
                "foam": round(portion.foam),
            }))
        })
        .collect();
    json!({
        "t_s": site.now_ms() as f64 / 1000.0, "speed": speed, "wind": pair(site.wind.now_mps()),
        "ambient_c": ambient_c, "fires": fires, "jets": jets, "splashes": splashes,
    })
}

fn pair((x, y): (f64, f64)) -> [f64; 2] {
    [round(x), round(y)]
}

/// Centimetres are enough for a picture.
fn round(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}
