//! The site of a hub for `lafet coverage`: the map, keep-outs, water and winds of its hub.toml. What only the
//! monitors know (limits, outlet, speeds) is as they are delivered.

use std::path::Path;

use lafet_hub::site::planned::{Built, USUAL_MPA, planned};
use lafet_hub::site::{Place, Site as Map};
use lafet_hub::{Config, Overrides};
use lafet_place::coverage::Area;
use lafet_place::supply::Supply;
use lafet_texts::{Text as _, cli as text};

use super::file::{CELL_M, FLOWING, Plan};
use crate::lang::current;

/// Around what is on the map, m, where `[coverage]` does not say what is protected.
const AROUND_M: f64 = 20.0;
/// Cells of such a map; of a larger one they are wider.
const CELLS: f64 = 250_000.0;

/// Reads the file of a hub; what is wrong, a line each.
pub fn plan(file: &str, text: &str) -> Result<Plan, String> {
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let config = Config::parse(file, text, folder, &Overrides::default());
    let config = config.map_err(|problems| {
        let lines: Vec<_> = problems.iter().map(|it| it.localized(current())).collect();
        lines.join("\n")
    })?;
    let wrong = |problem: lafet_place::Problem| format!("{file}: {}", problem.0.of(current()));
    let Some(map) = &config.site else {
        return Err(format!("{file}: {}", text::CoverageNoPlaces.of(current())));
    };
    let monitors: Vec<(String, Place, Built)> = config
        .monitors
        .iter()
        .filter_map(|it| Some((it.id.clone(), *map.monitors.get(&it.id)?, built(&config, &it.id))))
        .collect();
    let supply = match &config.plan.supply {
        Some(supply) => supply.clone(),
        None => Supply::constant(USUAL_MPA).map_err(wrong)?,
    };
    let site = planned(map, &monitors, supply);
    let area = area(&config, map, monitors.len());
    site.check().and_then(|()| area.check(monitors.len())).map_err(wrong)?;
    Ok(Plan { name: file.to_owned(), site, area })
}

/// As delivered, with the nozzle of its first aim.
fn built(config: &Config, monitor: &str) -> Built {
    let usual = Built::as_delivered();
    let mut aims = config.zones.iter().flat_map(|zones| zones.aims.values());
    let aim = aims.find(|aim| aim.monitor == monitor);
    let nozzle_mm = aim.map_or(usual.nozzle_mm, |aim| aim.nozzle.into());
    Built { nozzle_mm: nozzle_mm.clamp(0, usual.nozzle_mm), ..usual }
}

fn area(config: &Config, map: &Map, monitors: usize) -> Area {
    let plan = &config.plan;
    let (corner, size, cell_m, plane_m) = match plan.area {
        Some(it) => (it.corner, it.size, it.cell, it.plane),
        None => around(map),
    };
    let flowing = plan.flowing.unwrap_or(FLOWING.min(monitors));
    Area { corner, size, cell_m, plane_m, winds: plan.winds.clone(), flowing }
}

/// What holds all that is on a map.
fn around(map: &Map) -> ([f64; 2], [f64; 2], f64, f64) {
    let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut hold = |at: [f64; 2], radius_m: f64| {
        for axis in 0..2 {
            least[axis] = least[axis].min(at[axis] - radius_m - AROUND_M);
            most[axis] = most[axis].max(at[axis] + radius_m + AROUND_M);
        }
    };
    map.monitors.values().for_each(|it| hold(it.at, 0.0));
    map.tanks.iter().for_each(|it| hold(it.at, 0.5 * it.diameter));
    map.walls.iter().flat_map(|it| [it.from, it.to]).for_each(|at| hold(at, 0.0));
    let size = [most[0] - least[0], most[1] - least[1]];
    let cell_m = (size[0] * size[1] / CELLS).sqrt().ceil().max(CELL_M);
    (least, size, cell_m, 0.0)
}

#[cfg(test)]
mod tests {
    use lafet_place::coverage::Coverage;

    use super::super::file::load;
    use super::*;

    const HUB: &str = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://h?addr=1\"\nat = [0, 0]\nheight = 3\n\
                       [[monitor]]\nid = \"M2\"\nurl = \"tcp://h?addr=2\"\nat = [40, 0]\nheight = 3\n\
                       [[tank]]\nname = \"T\"\nat = [20, 25]\ndiameter = 12\nheight = 8\n";

    #[test]
    fn the_file_of_a_hub_is_a_site() {
        let plan = load("hub.toml", HUB).unwrap();
        assert_eq!((plan.area.corner, plan.area.size), ([-20.0, -20.0], [80.0, 71.0]));
        assert_eq!((plan.site.monitors.len(), plan.site.obstacles.len()), (2, 1));
        assert_eq!((plan.area.cell_m, plan.area.flowing), (1.0, 2));
        let known = format!(
            "{HUB}[[keep_out]]\nname = \"stand\"\nfor = \"people\"\nbearings = [330, 30]\n\
             [supply]\npressure = 0.6\nflowing = 1\n[[wind]]\nfrom = 270\nspeed = 8\n\
             [coverage]\ncorner = [-10, 0]\nsize = [60, 40]\ncell = 2\n"
        );
        let plan = load("hub.toml", &known).unwrap();
        assert_eq!((plan.area.size, plan.area.cell_m, plan.area.flowing), ([60.0, 40.0], 2.0, 1));
        assert!((plan.site.pressure_mpa(1) - 0.6).abs() < 1e-9);
        let reached = |plan: &Plan| Coverage::of(&plan.site, &plan.area).unwrap().summary;
        let kept = reached(&plan);
        assert_eq!(kept.winds.len(), 2);
        let free =
            Plan { site: lafet_place::site::Site { keep_outs: vec![], ..plan.site }, ..plan };
        assert!(kept.winds[0].two[0] < reached(&free).winds[0].two[0], "the sector counts");
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let nowhere = HUB.replace("at = [0, 0]\n", "").replace("at = [40, 0]\n", "");
        let wrong = |text: &str| load("hub.toml", text).unwrap_err();
        assert!(wrong(&nowhere).contains("at = [east, north]"), "{}", wrong(&nowhere));
        let unknown = wrong(&format!("{HUB}[[wind]]\nfrom = 0\nspeed = 99\n"));
        assert!(unknown.starts_with("hub.toml:16: "), "{unknown}");
        let two = wrong(&format!("{HUB}[supply]\npressure = 0.6\nflowing = 3\n"));
        assert!(two.contains('3'), "{two}");
    }
}
