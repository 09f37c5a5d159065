//! `lafet plan`: a site's drawing as tables of hub.toml (docs/plan.md).

use std::fmt::Write as _;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use lafet_drawing::placing::{Distance, Known, Pair, Placed, place};
use lafet_drawing::site::{Chosen, Mark, Plan, site};
use lafet_drawing::{Drawing, Geodetic, Limits, Problem, Stated, pieces, read, report, written};
use lafet_texts::{Shown, Text as _, Words, cli as text};
use serde::Serialize;
use serde_json::Value;

use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::Out;

/// Subcommands of `lafet plan`.
#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:\n  lafet plan show site.dxf\n  \
                        lafet plan import site.dxf --unit mm --layer TANKS=tank:12 --layer WALLS=wall:6")]
pub enum PlanCommand {
    #[command(
        after_help = "Examples:\n  lafet plan show site.dxf\n  lafet --json plan show site.geojson"
    )]
    Show(ShowArgs),
    #[command(
        after_help = "Examples:\n  lafet plan import site.dxf --unit mm --layer TANKS=tank:12 --layer WALLS=wall:6 > plan.toml\n  \
                      lafet plan import site.dxf --unit in --distance 0,0,1653.5,0=42 --layer TANKS=tank:12\n  \
                      lafet plan import site.dxf --unit m --point 7412300,6123400=0,0 --point 7412392,6123452=92,52.5 --layer TANKS=tank:12\n  \
                      lafet plan import site.geojson --unit wgs84 --zero 59.9386,30.3141 --layer tanks=tank\n  \
                      lafet plan import yard.jpg --unit points --point 120,900=0,0 --point 1900,860=90,0 --mark tank:T-1:12=640,420,700,420"
    )]
    Import(Box<ImportArgs>),
}

/// Arguments of `lafet plan show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

/// Arguments of `lafet plan import`.
#[derive(Debug, Args)]
pub struct ImportArgs {
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[arg(long, value_name = "UNIT", value_parser = said(written::unit))]
    unit: Option<Stated>,
    #[arg(long, value_name = "NAME=ROLE:HEIGHT", value_parser = said(written::layer))]
    layer: Vec<Chosen>,
    #[arg(long, value_name = "ROLE:NAME:HEIGHT=X,Y,…", value_parser = said(written::mark))]
    mark: Vec<Mark>,
    #[arg(
        long,
        value_name = "X,Y=EAST,NORTH",
        allow_hyphen_values = true,
        value_parser = said(written::point)
    )]
    point: Vec<Pair>,
    #[arg(
        long,
        value_name = "X,Y=LATITUDE,LONGITUDE",
        allow_hyphen_values = true,
        value_parser = said(written::geo)
    )]
    geo: Vec<([f64; 2], Geodetic)>,
    #[arg(
        long,
        value_name = "X,Y,X,Y=METRES",
        allow_hyphen_values = true,
        value_parser = said(written::distance)
    )]
    distance: Vec<Distance>,
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    scale: f64,
    #[arg(
        long,
        value_name = "X,Y",
        allow_hyphen_values = true,
        value_parser = said(written::place)
    )]
    origin: Option<Origin>,
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    north: Option<f64>,
    #[arg(
        long,
        value_name = "LATITUDE,LONGITUDE",
        allow_hyphen_values = true,
        value_parser = said(written::on_earth)
    )]
    zero: Option<Geodetic>,
    #[arg(long, value_name = "Z", allow_hyphen_values = true)]
    ground: Option<f64>,
}

/// A place as drawn.
type Origin = [f64; 2];

/// A parser whose errors are in the user's language.
fn said<T>(
    parse: fn(&str) -> Result<T, Words>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: 'static,
{
    move |text| parse(text).map_err(|words| words.of(current()).to_owned())
}

/// Shows or imports a drawing.
pub fn run(command: &PlanCommand, out: &mut Out) -> Outcome {
    match command {
        PlanCommand::Show(args) => show(args, out),
        PlanCommand::Import(args) => import(args, out),
    }
}

fn show(args: &ShowArgs, out: &mut Out) -> Outcome {
    let drawing = load(&args.file)?;
    out.show(report::overview(&drawing, current()), || as_json(&Shape::of(&drawing)))
}

fn import(args: &ImportArgs, out: &mut Out) -> Outcome {
    let lang = current();
    let drawing = load(&args.file)?;
    let Some(stated) = args.unit else {
        return Err(Failure::Usage(report::unit_missing(&drawing, lang)));
    };
    let known = Known {
        stated,
        scale: args.scale,
        points: args.point.clone(),
        on_earth: args.geo.clone(),
        distances: args.distance.clone(),
        origin: args.origin,
        north_deg: args.north,
        zero: args.zero,
    };
    let refused = |problem: Problem| refused(&args.file, &problem);
    let placed = place(drawing, &known).map_err(refused)?;
    let plan = site(&placed, &args.layer, &args.mark, args.ground).map_err(refused)?;
    let name = args.file.display().to_string().replace(char::is_control, " ");
    let mut printed = format!("# {name}\n");
    for line in report::summary(&placed, &known, &args.layer, &plan, lang) {
        _ = writeln!(printed, "# {line}");
    }
    if !plan.is_empty() {
        _ = write!(printed, "\n{}", pieces::toml(&plan, lang));
    }
    out.show(printed.trim_end(), || as_json(&Imported::of(&placed, &plan)))
}

/// Reads a drawing, and not more of it than is read of any.
fn load(path: &Path) -> Result<Drawing, Failure> {
    let shown = path.display();
    let failed = |error| {
        let what = text::CannotReadDrawing { shown: Shown(&shown) }.of(current());
        Failure::io(what, error)
    };
    let limits = Limits::default();
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(failed)?;
    file.take(limits.bytes as u64 + 1).read_to_end(&mut bytes).map_err(failed)?;
    read(&bytes, &limits).map_err(|problem| refused(path, &problem))
}

fn refused(path: &Path, problem: &Problem) -> Failure {
    Failure::Usage(format!("{}: {}", path.display(), problem.localized(current())))
}

fn as_json(value: &impl Serialize) -> Value {
    serde_json::to_value(value).unwrap_or_default()
}

/// `lafet --json plan show`.
#[derive(Serialize)]
struct Shape {
    format: &'static str,
    proposed_unit: Option<&'static str>,
    reference: Option<String>,
    pixels: Option<[u32; 2]>,
    extent: Option<[[f64; 2]; 2]>,
    sizes_m: Vec<Size>,
    layers: Vec<Layer>,
    skipped: std::collections::BTreeMap<String, usize>,
}

#[derive(Serialize)]
struct Size {
    unit: &'static str,
    size: [f64; 2],
}

#[derive(Serialize)]
struct Layer {
    name: String,
    hidden: bool,
    circles: usize,
    lines: usize,
    points: usize,
}

impl Shape {
    fn of(drawing: &Drawing) -> Self {
        let counts = report::counts(drawing);
        let layers = drawing.layers.iter().zip(counts).map(|(layer, counts)| {
            let report::Counts { circles, lines, points } = counts;
            let (name, hidden) = (layer.name.clone(), layer.hidden);
            Layer { name, hidden, circles, lines, points }
        });
        let sizes = report::sizes(drawing).into_iter();
        Self {
            format: drawing.format.name(),
            proposed_unit: drawing.proposed.map(lafet_drawing::Unit::name),
            reference: drawing.reference.clone(),
            pixels: drawing.pixels,
            extent: drawing.extent(None),
            sizes_m: sizes.map(|(unit, size)| Size { unit, size }).collect(),
            layers: layers.collect(),
            skipped: drawing.skipped.clone(),
        }
    }
}

/// `lafet --json plan import`.
#[derive(Serialize)]
struct Imported<'a> {
    format: &'static str,
    size_m: [f64; 2],
    scale: f64,
    north_deg: f64,
    checked: Option<Checked>,
    #[serde(flatten)]
    plan: &'a Plan,
    left_out: Vec<String>,
}

#[derive(Serialize)]
struct Checked {
    count: usize,
    worst_m: f64,
    worst: f64,
    ratio: Option<f64>,
}

impl<'a> Imported<'a> {
    fn of(placed: &Placed, plan: &'a Plan) -> Self {
        let checked = placed.checked.map(|it| Checked {
            count: it.count,
            worst_m: it.worst_m,
            worst: it.worst,
            ratio: it.ratio,
        });
        Self {
            format: placed.drawing.format.name(),
            size_m: placed.size,
            scale: placed.placing.scale,
            north_deg: placed.placing.north_deg(),
            checked,
            plan,
            left_out: plan.left_out.iter().map(|it| it.words().of(current()).to_owned()).collect(),
        }
    }
}
