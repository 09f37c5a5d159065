//! Drawings that other programs wrote of one site, and how large that is in truth: `drawings/make.py`.

use std::path::Path;
use std::process::Command;

use lafet_drawing::placing::{Known, Placed, place};
use lafet_drawing::site::{Plan, Spot, Tank, site};
use lafet_drawing::{Drawing, Limits, Problem, Stated, Unit, read, written};
use serde::Deserialize;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/drawings");
/// A place may be off by this part of the site's extent, a length by this part of itself.
const GOAL: f64 = 0.001;

#[derive(Deserialize)]
struct Truth {
    site: Site,
    drawings: Vec<Case>,
}

#[derive(Deserialize)]
struct Site {
    tanks: Vec<TrueTank>,
    /// Both ends, height.
    walls: Vec<[f64; 5]>,
    /// East, north, height.
    monitors: Vec<[f64; 3]>,
    extent: [f64; 2],
}

/// Name, east, north, diameter, height.
type TrueTank = (String, f64, f64, f64, f64);

/// A drawing, and what a person would state about it.
#[derive(Deserialize)]
struct Case {
    file: String,
    unit: String,
    layers: Vec<String>,
    points: Vec<String>,
    geo: Vec<String>,
    distances: Vec<String>,
    marks: Vec<String>,
    north: Option<f64>,
    origin: Option<String>,
    zero: Option<String>,
    scale: Option<f64>,
    ground: Option<f64>,
    /// The height of all tanks, where the layer states it.
    height: Option<f64>,
    /// The names of the tanks are on the drawing.
    #[serde(default)]
    named: bool,
    /// Something is known that decides about the unit.
    #[serde(default)]
    decided: bool,
    /// Other tanks than those of the site, and nothing else.
    tanks: Option<Vec<TrueTank>>,
    pixels: Option<[u32; 2]>,
}

impl Case {
    fn known(&self, unit: &str) -> Known {
        let place = |it: &String| written::place(it).unwrap();
        Known {
            scale: self.scale.unwrap_or(1.0),
            points: self.points.iter().map(|it| written::point(it).unwrap()).collect(),
            on_earth: self.geo.iter().map(|it| written::geo(it).unwrap()).collect(),
            distances: self.distances.iter().map(|it| written::distance(it).unwrap()).collect(),
            origin: self.origin.as_ref().map(place),
            north_deg: self.north,
            zero: self.zero.as_ref().map(|it| written::on_earth(it).unwrap()),
            ..Known::of(Stated::by_name(unit).unwrap())
        }
    }

    fn placed(&self, drawing: &Drawing, unit: &str) -> Result<(Placed, Plan), Problem> {
        let layers: Vec<_> = self.layers.iter().map(|it| written::layer(it).unwrap()).collect();
        let marks: Vec<_> = self.marks.iter().map(|it| written::mark(it).unwrap()).collect();
        let placed = place(drawing.clone(), &self.known(unit))?;
        let plan = site(&placed, &layers, &marks, self.ground)?;
        Ok((placed, plan))
    }
}

fn truth(folder: &Path) -> Truth {
    let text = std::fs::read_to_string(folder.join("truth.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn drawing(folder: &Path, case: &Case) -> Drawing {
    let bytes = std::fs::read(folder.join(&case.file)).unwrap();
    read(&bytes, &Limits::default()).unwrap_or_else(|problem| panic!("{}: {problem}", case.file))
}

fn away(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The farthest that anything is off, as a part of what is allowed.
fn worst(case: &Case, site: &Site, plan: &Plan) -> f64 {
    let file = &case.file;
    let allowed = GOAL * site.extent[0].hypot(site.extent[1]);
    let tanks = case.tanks.as_ref().unwrap_or(&site.tanks);
    assert_eq!(plan.tanks.len(), tanks.len(), "{file}: {:#?}", plan.tanks);
    let mut worst: f64 = 0.0;
    for (name, east, north, diameter, height) in tanks {
        let near = |it: &&Tank| (away(it.at, [*east, *north]) * 1e6) as u64;
        let found = plan.tanks.iter().min_by_key(near).unwrap();
        worst = worst.max(away(found.at, [*east, *north]) / allowed);
        worst = worst.max((found.diameter / diameter - 1.0).abs() / GOAL);
        worst = worst.max((found.height / case.height.unwrap_or(*height) - 1.0).abs() / GOAL);
        let named = case.named || case.tanks.is_some();
        assert!(!named || found.name == *name, "{file}: {} is {name}", found.name);
    }
    if case.tanks.is_some() {
        return worst;
    }
    assert_eq!(plan.walls.len(), site.walls.len(), "{file}: {:#?}", plan.walls);
    for [a, b, c, d, height] in &site.walls {
        let off = plan.walls.iter().map(|it| {
            let along = away(it.from, [*a, *b]).max(away(it.to, [*c, *d]));
            let back = away(it.from, [*c, *d]).max(away(it.to, [*a, *b]));
            along.min(back) + (it.height - height).abs()
        });
        worst = worst.max(off.fold(f64::INFINITY, f64::min) / allowed);
    }
    assert_eq!(plan.monitors.len(), site.monitors.len(), "{file}");
    for [east, north, height] in &site.monitors {
        let off = |it: &Spot| away(it.at, [*east, *north]) + (it.height.unwrap() - height).abs();
        worst = worst.max(plan.monitors.iter().map(off).fold(f64::INFINITY, f64::min) / allowed);
    }
    worst
}

/// All of them: where everything is, and that no other unit passes.
fn check(folder: &Path) {
    let Truth { site, drawings } = truth(folder);
    assert!(drawings.len() >= 20);
    for case in &drawings {
        let file = &case.file;
        let drawing = drawing(folder, case);
        assert_eq!(drawing.pixels, case.pixels, "{file}");
        let (_, plan) =
            case.placed(&drawing, &case.unit).unwrap_or_else(|problem| panic!("{file}: {problem}"));
        let worst = worst(case, &site, &plan);
        println!("{file}: {:.4} % of 0.1 %", 100.0 * worst);
        assert!(worst <= 1.0, "{file}: {worst} times as far off as allowed: {plan:#?}");
        if !case.decided {
            continue;
        }
        // A foot and a foot of the surveys differ by less than anything that is measured.
        let meant = Unit::by_name(&case.unit).map_or(1.0, Unit::metres);
        let others = Unit::ALL.into_iter().filter(|it| (it.metres() / meant - 1.0).abs() > 1e-3);
        for other in others {
            let stated = case.placed(&drawing, other.name());
            assert!(stated.is_err(), "{file}: {} as well", other.name());
        }
    }
}

#[test]
fn drawings_of_other_programs_are_placed_within_a_thousandth() {
    check(Path::new(FOLDER));
}

/// The same, written now by the versions that are installed.
#[test]
#[ignore = "needs ezdxf, svgwrite, pyproj and pillow"]
fn drawings_written_now_are_placed_as_well() {
    let folder = std::env::temp_dir().join(format!("lafet-drawings-{}", std::process::id()));
    let python = std::env::var("LAFET_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(FOLDER).join("make.py");
    let made = Command::new(python).arg(script).arg(&folder).status().unwrap();
    assert!(made.success());
    check(&folder);
    std::fs::remove_dir_all(&folder).unwrap();
}
