//! `lafet program`: the extinguishing programs and trajectories stored in a monitor.

use clap::{Args, Subcommand};
use lafet_client::Saved;
use lafet_proto::SubsystemId;
use lafet_proto::param::Param;
use lafet_proto::request::TrajectoryPoint;
use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};

use super::param::{failed_to_save, saved_text};
use super::quench::{QuenchArgs, TrajectoryArgs, point, run_quench, run_trajectory};
use crate::angle::{Pair, degrees};
use crate::cli::Global;
use crate::connect::Connection;
use crate::failure::Outcome;
use crate::lang::current;
use crate::out::{Out, columns};

/// Number of programs, and of trajectories: 0 to 7 (§3.14, §3.15).
const COUNT: u8 = 8;

/// Subcommands of `lafet program`.
#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 program list\n  \
                        lafet -c tcp://127.0.0.1:10485 program run 3 --follow")]
pub enum ProgramCommand {
    #[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 program list")]
    List,
    #[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 program show 3\n  \
                            lafet -c tcp://127.0.0.1:10485 program show 0 --trajectory")]
    Show(WhichArgs),
    #[command(
        after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 program set 3 --centre 30deg,-2deg \
                      --sector 6deg,2deg --step 1 --distance 25\n  \
                      lafet -c tcp://127.0.0.1:10485 program set 0 --point 20deg,-2deg,25,10 \
                      --point 24deg,-2deg,25,10"
    )]
    Set(SetArgs),
    #[command(
        after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 program run 3 --follow\n  \
                      lafet -c tcp://127.0.0.1:10485 program run 0 --trajectory --ballistics"
    )]
    Run(RunArgs),
    #[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 program clear 3\n  \
                            lafet -c tcp://127.0.0.1:10485 program clear 0 --trajectory")]
    Clear(WhichArgs),
}

/// A program or trajectory, by number.
#[derive(Debug, Args)]
pub struct WhichArgs {
    #[arg(value_name = "N", value_parser = number)]
    number: u8,
    #[arg(long)]
    trajectory: bool,
}

/// Arguments of `lafet program set`.
#[derive(Debug, Args)]
pub struct SetArgs {
    #[arg(value_name = "N", value_parser = number)]
    number: u8,
    #[arg(long, value_name = "H,V", allow_hyphen_values = true, required_unless_present = "point")]
    centre: Option<Pair>,
    #[arg(long, value_name = "W,H")]
    sector: Option<Pair>,
    #[arg(long, value_name = "DEGREES", default_value_t = 0)]
    step: i8,
    #[arg(long, value_name = "MM", default_value_t = 60)]
    nozzle: i16,
    #[arg(long, value_name = "METRES", default_value_t = 0)]
    distance: i8,
    #[arg(
        long,
        value_name = "H,V,M,DS",
        allow_hyphen_values = true,
        value_parser = point,
        conflicts_with_all = ["centre", "sector", "step", "nozzle", "distance"]
    )]
    point: Vec<TrajectoryPoint>,
}

/// Arguments of `lafet program run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    #[arg(value_name = "N", value_parser = number)]
    number: u8,
    #[arg(long)]
    trajectory: bool,
    #[arg(long, requires = "trajectory")]
    ballistics: bool,
    #[arg(long, requires = "trajectory")]
    repeat: bool,
    #[arg(long, conflicts_with = "trajectory")]
    empty: bool,
    #[arg(long)]
    follow: bool,
}

fn number(text: &str) -> Result<u8, String> {
    match text.parse() {
        Ok(number) if number < COUNT => Ok(number),
        _ => Err(text::ProgramNumberExpected.str(current()).into()),
    }
}

/// Runs `lafet program`.
pub async fn run(command: ProgramCommand, global: &Global, out: &mut Out) -> Outcome {
    match command {
        ProgramCommand::List => list(global, out).await,
        ProgramCommand::Show(args) => show(&args, global, out).await,
        ProgramCommand::Set(args) => set(&args, global, out).await,
        ProgramCommand::Run(args) if args.trajectory => {
            let RunArgs { number, ballistics, repeat, follow, .. } = args;
            let args = TrajectoryArgs::stored(number, ballistics, repeat, follow);
            run_trajectory(args, global, out).await
        }
        ProgramCommand::Run(args) => {
            let RunArgs { number, empty, follow, .. } = args;
            run_quench(QuenchArgs::stored(number.into(), empty, follow), global, out).await
        }
        ProgramCommand::Clear(args) => clear(&args, global, out).await,
    }
}

async fn list(global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    let all: Vec<Stored> = [false, true]
        .into_iter()
        .flat_map(|t| (0..COUNT).map(move |n| Stored::new(n, t)))
        .collect();
    let params: Vec<Param> = all.iter().filter_map(Stored::param).collect();
    let mut rows = Vec::new();
    let mut objects = Vec::new();
    for (stored, values) in all.iter().zip(connection.monitor.params(&params).await) {
        let values = values?;
        rows.push(vec![stored.title(), stored.told(&values).join("; ")]);
        objects.push(stored.json(&values));
    }
    out.show(columns(&rows), || Value::Array(objects))
}

async fn show(args: &WhichArgs, global: &Global, out: &mut Out) -> Outcome {
    let stored = Stored::new(args.number, args.trajectory);
    let connection = Connection::open(global).await?;
    let values = connection.monitor.param(SubsystemId::CONTROL, &stored.name()).await?;
    let lines: String = stored.told(&values).iter().map(|line| format!("\n  {line}")).collect();
    out.show(format!("{}{lines}", stored.title()), || stored.json(&values))
}

async fn set(args: &SetArgs, global: &Global, out: &mut Out) -> Outcome {
    let stored = Stored::new(args.number, !args.point.is_empty());
    let values: Vec<i32> = match args.centre {
        Some(Pair(h, v)) => {
            let Pair(width, height) = args.sector.unwrap_or(Pair(0, 0));
            let rest = [i32::from(args.step), i32::from(args.distance)];
            [h, v, args.nozzle, width, height].map(i32::from).into_iter().chain(rest).collect()
        }
        None => args.point.iter().flat_map(of_point).collect(),
    };
    store(stored, &values, global, out).await
}

fn of_point(point: &TrajectoryPoint) -> [i32; 4] {
    let TrajectoryPoint { horizontal, vertical, distance, dwell } = *point;
    [horizontal.into(), vertical.into(), distance.into(), dwell.into()]
}

async fn clear(args: &WhichArgs, global: &Global, out: &mut Out) -> Outcome {
    // A program always has seven values; a cleared one is all zeros.
    let values: &[i32] = if args.trajectory { &[] } else { &[0; 7] };
    store(Stored::new(args.number, args.trajectory), values, global, out).await
}

async fn store(stored: Stored, values: &[i32], global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    let saved: Saved =
        connection.monitor.save_param(SubsystemId::CONTROL, &stored.name(), values).await?;
    let told = stored.told(values).join("; ");
    out.show(format!("{}: {told}\n{}.", stored.title(), saved_text(saved)), || {
        let mut json = stored.json(values);
        json["saved"] = json!(saved.name());
        json
    })?;
    failed_to_save(saved)
}

/// A slot for a program or a trajectory.
#[derive(Clone, Copy)]
struct Stored {
    number: u8,
    trajectory: bool,
}

impl Stored {
    const fn new(number: u8, trajectory: bool) -> Self {
        Self { number, trajectory }
    }

    fn name(&self) -> String {
        format!("{}{}", if self.trajectory { "Trajectory" } else { "Program" }, self.number)
    }

    fn param(&self) -> Option<Param> {
        Param::by_name(SubsystemId::CONTROL, &self.name())
    }

    fn title(&self) -> String {
        let what = match self.trajectory {
            true => text::TheTrajectory.str(current()),
            false => text::TheProgram.str(current()),
        };
        format!("{what} {}", self.number)
    }

    fn is_empty(&self, values: &[i32]) -> bool {
        values.iter().all(|value| *value == 0)
    }

    /// The stored values as text, in degrees, metres and seconds.
    fn told(&self, values: &[i32]) -> Vec<String> {
        match values {
            values if self.is_empty(values) => vec![text::ProgramIsEmpty.str(current()).into()],
            [h, v, nozzle, width, height, step, distance] if !self.trajectory => {
                program_told(*h, *v, *nozzle, [*width, *height, *step, *distance])
            }
            values => values.chunks(4).enumerate().map(point_told).collect(),
        }
    }

    fn json(&self, values: &[i32]) -> Value {
        let mut json = json!({
            "kind": if self.trajectory { "trajectory" } else { "program" },
            "number": self.number,
            "empty": self.is_empty(values),
        });
        match values {
            [h, v, nozzle, width, height, step, distance] if !self.trajectory => {
                json["centre_arcmin"] = json!([h, v]);
                json["nozzle_mm"] = json!(nozzle);
                json["sector_arcmin"] = json!([width, height]);
                json["step_deg"] = json!(step);
                json["distance_m"] = json!(distance);
            }
            values => {
                let point = |one: &[i32]| match one {
                    [h, v, distance, dwell] => json!({
                        "horizontal_arcmin": h,
                        "vertical_arcmin": v,
                        "distance_m": distance,
                        "dwell_s": f64::from(*dwell) / 10.0,
                    }),
                    rest => json!(rest),
                };
                json["points"] = values.chunks(4).map(point).collect();
            }
        }
        json
    }
}

fn program_told(h: i32, v: i32, nozzle: i32, rest: [i32; 4]) -> Vec<String> {
    let [width, height, step, distance] = rest;
    let (h, v) = (degrees(h), degrees(v));
    let mut told = vec![text::ProgramCentre { h, v }.of(current())];
    if (width, height) != (0, 0) {
        let (width, height) = (degrees(width), degrees(height));
        told.push(text::ProgramSector { width, height, step }.of(current()));
    }
    told.push(text::ProgramNozzle { nozzle }.of(current()));
    told.push(match distance {
        0 => text::AimedStraight.str(current()).into(),
        metres => text::FireAway { metres }.of(current()),
    });
    told
}

fn point_told((index, point): (usize, &[i32])) -> String {
    let [h, v, distance, dwell] = point else { return format!("{point:?}") };
    let (h, v, seconds) = (degrees(*h), degrees(*v), f64::from(*dwell) / 10.0);
    let number = index + 1;
    text::TrajectoryPoint { number, h, v, distance, seconds }.of(current())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_and_trajectories_in_words() {
        let told = Stored::new(3, false).told(&[1800, -120, 60, 360, 120, 1, 25]);
        assert_eq!(told[0], "centre 30.0° horizontally, -2.0° vertically");
        assert_eq!(told[1], "sector 6.0° wide, 2.0° high, a line every 1°");
        assert_eq!(told[2..], ["nozzle 60 mm", "fire 25 m away"]);
        let told = Stored::new(0, true).told(&[1200, -120, 25, 10, 1440, -120, 25, 15]);
        assert_eq!(told[1], "2: 24.0° -2.0°, 25 m, stays 1.5 s");
        assert_eq!(Stored::new(0, true).told(&[]), ["empty"]);
        assert_eq!(Stored::new(0, false).told(&[0; 7]), ["empty"]);
        assert!(number("8").is_err() && number("7") == Ok(7));
    }
}
