//! The file of a site for `lafet coverage`: that of a hub, or one of its own. docs/coverage.md has both formats.
//! Degrees, metres, MPa, l/min.

use lafet_place::coverage::Area;
use lafet_place::obstacle::Body;
use lafet_place::site::{For, KeepOut, Kept, Monitor, Site, Wind};
use lafet_place::supply::Supply;
use lafet_place::{KEEP_OUTS_MAX, MONITORS_MAX, OBSTACLES_MAX, WINDS_MAX};
use lafet_sim::exercise::reader::{Document, Problem, Table};
use lafet_texts::{Text as _, cli as text};

use super::hub;
use crate::lang::current;

/// Flow of an outlet of 28 mm at 0.8 MPa, l/min: what a monitor has that does not say it.
const USUAL_LPM: f64 = 1200.0;
const USUAL_MM: f64 = 28.0;
const USUAL_MPA: f64 = 0.8;
/// Side of a cell, clearance around monitors, m; monitors that flow together.
pub const CELL_M: f64 = 1.0;
const CLEARANCE_M: f64 = 1.0;
pub const FLOWING: usize = 2;
/// Limits and speeds of a monitor that does not say them, degrees and degrees per second.
const AZIMUTHS: [f64; 2] = [-180.0, 180.0];
const ELEVATIONS: [f64; 2] = [-15.0, 75.0];
const SPEEDS: [f64; 2] = [20.0, 12.0];
const FAR: f64 = 10_000.0;

type Read<T> = Result<T, Problem>;

/// A site and the area to compute.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Its name; the file without one.
    pub name: String,
    /// The installation.
    pub site: Site,
    /// What is asked for.
    pub area: Area,
}

/// Reads a file of either format; what is wrong, in words.
pub fn load(file: &str, text: &str) -> Result<Plan, String> {
    if is_of_hub(file, text) {
        return hub::plan(file, text);
    }
    parse(file, text).map_err(|problem| problem.told(current()))
}

/// The monitors of a hub have URLs.
fn is_of_hub(file: &str, text: &str) -> bool {
    let Ok(document) = Document::parse(file, text) else { return false };
    let root = document.root();
    let monitors = root.tables("monitor").unwrap_or_default();
    !root.has("site") && monitors.iter().any(|it| it.has("url"))
}

/// Reads a file of the format of its own.
pub fn parse(file: &str, text: &str) -> Read<Plan> {
    let document = Document::parse(file, text)?;
    let root = document.root();
    let mut monitors: Vec<Monitor> = Vec::new();
    for table in bounded(&root, "monitor", MONITORS_MAX)? {
        let monitor = monitor(table, &monitors)?;
        monitors.push(monitor);
    }
    if monitors.is_empty() {
        let what = text::SiteNeedsMonitor.words();
        return Err(root.wrong("monitor", what));
    }
    let obstacles = bounded(&root, "obstacle", OBSTACLES_MAX)?.into_iter().map(|table| {
        let body = body(&table)?;
        let checked = body.check().map_err(|problem| wrong(&table, problem));
        checked.and_then(|()| table.finish()).map(|()| body)
    });
    let obstacles = obstacles.collect::<Read<Vec<Body>>>()?;
    let keep_outs = bounded(&root, "keep_out", KEEP_OUTS_MAX)?;
    let keep_outs = keep_outs.into_iter().map(|table| keep_out(table, &monitors));
    let keep_outs = keep_outs.collect::<Read<Vec<KeepOut>>>()?;
    let winds = bounded(&root, "wind", WINDS_MAX)?.into_iter().map(wind);
    let winds = winds.collect::<Read<Vec<Wind>>>()?;
    let (supply, flowing) = supply(&root, monitors.len())?;
    let Some(head) = root.table_of("site")? else {
        return Err(root.wrong("", text::SiteNeedsSite.words()));
    };
    let area = Area {
        corner: head.needed_numbers("corner")?,
        size: head.needed_numbers("size")?,
        cell_m: head.number("cell", 0.05, 100.0)?.unwrap_or(CELL_M),
        plane_m: head.number("plane", -100.0, 200.0)?.unwrap_or_default(),
        winds,
        flowing,
    };
    let clearance_m = head.number("clearance", 0.0, 20.0)?.unwrap_or(CLEARANCE_M);
    let name = head.text("name")?.unwrap_or(file).to_owned();
    area.check(monitors.len()).map_err(|problem| wrong(&head, problem))?;
    head.finish()?;
    root.finish()?;
    Ok(Plan { name, site: Site { monitors, obstacles, keep_outs, supply, clearance_m }, area })
}

/// What the geometry refuses, with the line of the table.
fn wrong(table: &Table<'_>, problem: lafet_place::Problem) -> Problem {
    let lafet_place::Problem(text) = problem;
    table.wrong("", text)
}

/// The tables of a list of which there is a greatest number.
fn bounded<'a>(root: &Table<'a>, key: &'static str, most: usize) -> Read<Vec<Table<'a>>> {
    let tables = root.tables(key)?;
    let count = tables.len();
    if count <= most {
        return Ok(tables);
    }
    Err(root.wrong(key, text::TablesAtMost { count, most }.words()))
}

fn monitor(table: Table<'_>, before: &[Monitor]) -> Read<Monitor> {
    let name = match table.text("name")? {
        Some(name) if before.iter().any(|other| other.name == name) => {
            return Err(table.wrong("name", text::MonitorsWithOneName { name }.words()));
        }
        Some(name) => name.to_owned(),
        None => format!("M{}", before.len() + 1),
    };
    let outlet_mm = table.number("outlet", 8.0, 100.0)?.unwrap_or(USUAL_MM);
    let usual_lpm = USUAL_LPM * (outlet_mm / USUAL_MM).powi(2);
    let flow_lpm = table.number("flow", 10.0, 50_000.0)?.unwrap_or(usual_lpm);
    let at_mpa = table.number("flow_pressure", 0.1, 2.5)?.unwrap_or(USUAL_MPA);
    let degrees = |key, usual: [f64; 2]| -> Read<[f64; 2]> {
        Ok(table.numbers(key)?.unwrap_or(usual).map(f64::to_radians))
    };
    let monitor = Monitor {
        name,
        at: table.needed_numbers("at")?,
        height_m: table.needed("height", 0.1, 200.0)?,
        heading: bearing(&table, "heading")?,
        azimuths: degrees("azimuth", AZIMUTHS)?,
        elevations: degrees("elevation", ELEVATIONS)?,
        outlet_mm,
        nozzle_mm: table.number("nozzle", 0.0, 60.0)?.unwrap_or(60.0),
        k_lpm: flow_lpm / at_mpa.sqrt(),
        speeds: degrees("speed", SPEEDS)?,
    };
    monitor.check().map_err(|problem| wrong(&table, problem))?;
    table.finish().map(|()| monitor)
}

fn bearing(table: &Table<'_>, key: &'static str) -> Read<f64> {
    Ok(table.number(key, -360.0, 360.0)?.unwrap_or_default().to_radians())
}

/// A cylinder by its `radius`, or a box by its `size`.
fn body(table: &Table<'_>) -> Read<Body> {
    let at = table.needed_numbers("at")?;
    let bottom = table.number("bottom", -FAR, FAR)?.unwrap_or_default();
    let heights = [bottom, table.needed("top", -FAR, FAR)?];
    if let Some(radius_m) = table.number("radius", 0.01, 2000.0)? {
        return Ok(Body::Cylinder { at, radius_m, heights });
    }
    let Some(size) = table.numbers("size")? else {
        return Err(table.wrong("", text::BodyNeedsSize.words()));
    };
    Ok(Body::Box { at, size, heading: bearing(table, "heading")?, heights })
}

fn keep_out(table: Table<'_>, monitors: &[Monitor]) -> Read<KeepOut> {
    let of =
        [("people", For::People), ("detectors", For::Detectors), ("equipment", For::Equipment)];
    let of = table.choice("for", &of)?.unwrap_or(For::People);
    let place = if table.has("bearings") {
        let names: Vec<String> = monitors.iter().map(|monitor| monitor.name.clone()).collect();
        let elevations: Option<[f64; 2]> = table.numbers("elevations")?;
        Kept::Sector {
            monitor: table.one_of_names("monitor", &names)?,
            bearings: table.needed_numbers("bearings")?.map(f64::to_radians),
            elevations: elevations.unwrap_or([-90.0, 90.0]).map(f64::to_radians),
        }
    } else {
        Kept::Zone(body(&table)?)
    };
    let keep_out = KeepOut { of, place };
    keep_out.check(monitors.len()).map_err(|problem| wrong(&table, problem))?;
    table.finish().map(|()| keep_out)
}

fn wind(table: Table<'_>) -> Read<Wind> {
    let from = table.needed("from", -360.0, 360.0)?.to_radians();
    let wind = Wind { from, speed_mps: table.needed("speed", 0.0, 40.0)? };
    table.finish().map(|()| wind)
}

/// The supply, and how many monitors flow together.
fn supply(root: &Table<'_>, monitors: usize) -> Read<(Supply, usize)> {
    let usual = FLOWING.min(monitors);
    let Some(table) = root.table_of("supply")? else {
        let constant = Supply::constant(USUAL_MPA).map_err(|problem| wrong(root, problem))?;
        return Ok((constant, usual));
    };
    let flowing = table.number("flowing", 1.0, monitors as f64)?;
    let supply = if table.has("curve") {
        let points: Vec<[f64; 2]> =
            table.places("curve")?.into_iter().map(|(flow, pressure)| [flow, pressure]).collect();
        Supply::curve(&points)
    } else if table.has("static") {
        let least = table.needed("static", 0.1, 2.5)?;
        Supply::parabola(
            least,
            table.needed("flow", 1.0, 200_000.0)?,
            table.needed("pressure", 0.0, 2.5)?,
        )
    } else {
        Supply::constant(table.needed("pressure", 0.1, 2.5)?)
    };
    let supply = supply.map_err(|problem| wrong(&table, problem))?;
    table.finish()?;
    Ok((supply, flowing.map_or(usual, |flowing| flowing.round() as usize)))
}

#[cfg(test)]
mod tests {
    use lafet_sim::exercise::Lang;

    use super::*;

    const SMALL: &str = "[site]\ncorner = [0, 0]\nsize = [10, 10]\n\
                         [[monitor]]\nat = [0, 0]\nheight = 2\n";

    #[test]
    fn the_example_is_read() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/examples/coverage.toml");
        let text = std::fs::read_to_string(path).unwrap();
        let Plan { site, area, .. } = parse("coverage.toml", &text).unwrap();
        assert_eq!((site.monitors.len(), area.winds.len(), area.flowing), (4, 4, 2));
        assert_eq!((site.obstacles.len(), site.keep_outs.len()), (2, 2));
        assert_eq!(site.check(), Ok(()));
    }

    #[test]
    fn what_is_not_given_is_usual() {
        let Plan { site, area, name } = parse("a.toml", SMALL).unwrap();
        assert_eq!((name.as_str(), area.flowing, area.cell_m), ("a.toml", 1, 1.0));
        assert!((site.monitors[0].flow_lpm(0.8) - 1200.0).abs() < 1e-9);
        assert!((site.pressure_mpa(1) - 0.8).abs() < 1e-9);
    }

    #[test]
    fn errors_have_line_key_and_both_languages() {
        let cases = [
            (String::new(), "[[monitor]]", "[[monitor]]"),
            (
                "[site]\ncorner = [0, 0]\nsize = [10, 10]\n[[monitor]]\nat = [0, 0]\n".to_owned(),
                ":4: monitor.height: is missing",
                "не хватает",
            ),
            (
                format!("{SMALL}heigt = 3\n"),
                ":7: monitor.heigt: `heigt` is not known",
                "не подходит",
            ),
            (format!("{SMALL}heading = nan\n"), ":7: monitor.heading: a number", "число"),
            (format!("{SMALL}elevation = [10, 5]\n"), ":4: monitor: the limits", "пределы ствола"),
            (
                format!("{SMALL}[[obstacle]]\nat = [1, 1]\ntop = 3\n"),
                ":7: obstacle: `radius`",
                "цилиндр",
            ),
            (
                format!("{SMALL}[[keep_out]]\nmonitor = \"M9\"\nbearings = [1, 2]\n"),
                ":8: keep_out.monitor: `M9`",
                "допустимо: M1",
            ),
            (
                format!("{SMALL}[supply]\ncurve = [[0, 0.5], [10, 0.6]]\n"),
                ":7: supply: the curve",
                "кривая",
            ),
            (
                format!("{SMALL}[supply]\npressure = 0.8\nflowing = 2\n"),
                ":9: supply.flowing",
                "число",
            ),
            (format!("{SMALL}[[wind]]\nfrom = 10\nspeed = 99\n"), ":9: wind.speed", "число"),
            (SMALL.replace("10, 10", "5000, 5000"), ":1: site: 25000000 cells", "ячеек"),
            (
                format!("{SMALL}name = \"A\"\n[[monitor]]\nname = \"A\"\n"),
                ":9: monitor.name: two monitors",
                "два ствола",
            ),
            ("a = [".to_owned(), ":1: ", "TOML"),
        ];
        for (text, en, ru) in cases {
            let problem = parse("a.toml", &text).unwrap_err();
            assert!(problem.told(Lang::En).contains(en), "{}", problem.told(Lang::En));
            assert!(problem.told(Lang::Ru).contains(ru), "{}", problem.told(Lang::Ru));
        }
        let many = format!("{SMALL}{}", "[[wind]]\nfrom = 1\nspeed = 1\n".repeat(17));
        assert!(parse("a.toml", &many).unwrap_err().told(Lang::En).contains("16 at most"));
    }
}
