//! `lafet quench`, `trajectory`: extinguishing.

use clap::{ArgGroup, Args};
use lafet_client::AnswerBuf;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{ControlFlags, DeployerFlags};
use lafet_proto::request::{Body, Path, Points, Quench, Sector, Trajectory, TrajectoryPoint};
use lafet_proto::{Bytes, Request, SubsystemId};
use lafet_texts::{Shown, Text as _, cli as text};
use serde_json::json;

use super::motion::stopped;
use crate::angle::{Angle, Pair};
use crate::cli::Global;
use crate::connect::Connection;
use crate::describe::{flag_names, values};
use crate::failure::{Failure, Outcome};
use crate::follow::{self, Follow, Step};
use crate::lang::current;
use crate::out::Out;
use crate::undo::{States, Undo};

/// Nozzle position of the narrowest jet, mm.
const NARROW: i16 = 60;

/// Arguments of `lafet quench`.
#[derive(Debug, Args)]
#[command(
    group = ArgGroup::new("what").required(true).args(["program", "distance", "corrections"]),
    after_help = "Examples:\n  \
        lafet -c tcp://127.0.0.1:10485 quench --centre 30deg,-2deg --distance 25 \
        --sector 6deg,2deg --step 1\n  \
        lafet -c tcp://127.0.0.1:10485 quench --program 3\n  \
        lafet -c tcp://127.0.0.1:10485 quench --program 3 --centre 10deg,0 --nozzle 40 --follow"
)]
pub struct QuenchArgs {
    #[arg(long, value_name = "N", conflicts_with_all = ["sector", "step"])]
    program: Option<i16>,
    #[arg(
        long,
        value_name = "H,V",
        allow_hyphen_values = true,
        required_unless_present = "program"
    )]
    centre: Option<Pair>,
    #[arg(long, value_name = "W,H", requires = "step")]
    sector: Option<Pair>,
    #[arg(long, value_name = "DEGREES")]
    step: Option<i8>,
    #[arg(long, value_name = "MM")]
    nozzle: Option<i16>,
    #[arg(long, value_name = "METRES")]
    distance: Option<i8>,
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true)]
    corrections: Option<Vec<i8>>,
    #[arg(long, requires = "program")]
    empty: bool,
    #[arg(long)]
    follow: bool,
}

/// Arguments of `lafet trajectory`.
#[derive(Debug, Args)]
#[command(
    group = ArgGroup::new("path").required(true).args(["point", "stored"]),
    after_help = "Examples:\n  \
        lafet -c tcp://127.0.0.1:10485 trajectory --ballistics --point 20deg,-2deg,25,10 \
        --point 24deg,-2deg,25,10\n  \
        lafet -c tcp://127.0.0.1:10485 trajectory --stored 0,3 --repeat"
)]
pub struct TrajectoryArgs {
    #[arg(long, value_name = "H,V,M,DS", allow_hyphen_values = true, value_parser = point)]
    point: Vec<TrajectoryPoint>,
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    stored: Vec<u8>,
    #[arg(long)]
    ballistics: bool,
    #[arg(long)]
    repeat: bool,
    #[arg(long)]
    follow: bool,
}

impl QuenchArgs {
    /// Arguments that run a stored program around its own centre.
    pub const fn stored(program: i16, empty: bool, follow: bool) -> Self {
        Self {
            program: Some(program),
            centre: None,
            sector: None,
            step: None,
            nozzle: None,
            distance: None,
            corrections: None,
            empty,
            follow,
        }
    }
}

impl TrajectoryArgs {
    /// Arguments that run a stored trajectory.
    pub fn stored(number: u8, ballistics: bool, repeat: bool, follow: bool) -> Self {
        Self { point: Vec::new(), stored: vec![number], ballistics, repeat, follow }
    }
}

/// Runs `lafet quench`.
pub async fn run_quench(args: QuenchArgs, global: &Global, out: &mut Out) -> Outcome {
    let bytes: Vec<u8> =
        args.corrections.iter().flatten().map(|degrees| degrees.to_le_bytes()[0]).collect();
    if bytes.len() == 1 {
        return Err(Failure::Usage(text::CorrectionsTooFew.str(current()).into()));
    }
    if let Some(program) = args.program {
        return run_program(program, &args, global, out).await;
    }
    let Pair(centre_h, centre_v) = args.centre.unwrap_or(Pair(0, 0));
    let nozzle = args.nozzle.unwrap_or(NARROW);
    let Pair(width, height) = args.sector.unwrap_or(Pair(0, 0));
    let step = args.step.unwrap_or(0);
    let sector = Sector { centre_h, centre_v, nozzle, width, height, step };
    let quench = match args.distance {
        Some(distance) => Quench::Full { sector, distance },
        None => Quench::Corrected { sector, corrections: Bytes(&bytes) },
    };
    start(Body::StartQuench(quench), args.follow, global, out).await
}

/// Runs a program around its own centre, which the request has to repeat (§3.14), or another one.
async fn run_program(program: i16, args: &QuenchArgs, global: &Global, out: &mut Out) -> Outcome {
    if !(0..=7).contains(&program) {
        return Err(Failure::Usage(text::NoSuchProgram { program }.of(current())));
    }
    let connection = Connection::open(global).await?;
    let name = format!("Program{program}");
    let stored = connection.monitor.param(SubsystemId::CONTROL, &name).await?;
    if !args.empty && stored.iter().all(|value| *value == 0) {
        return Err(Failure::Usage(is_empty(program)));
    }
    let value = |index: usize| {
        stored.get(index).and_then(|value| i16::try_from(*value).ok()).unwrap_or_default()
    };
    let Pair(centre_h, centre_v) = args.centre.unwrap_or(Pair(value(0), value(1)));
    let own = if args.centre.is_some() { NARROW } else { value(2) };
    let nozzle = args.nozzle.unwrap_or(own);
    let quench = Quench::Program { program, centre_h, centre_v, nozzle };
    start(Body::StartQuench(quench), args.follow, global, out).await
}

fn is_empty(program: i16) -> String {
    text::ProgramEmpty { program }.of(current())
}

/// Runs `lafet trajectory`.
pub async fn run_trajectory(args: TrajectoryArgs, global: &Global, out: &mut Out) -> Outcome {
    let path = match args.stored.as_slice() {
        [] => Path::Points(Points::Values(&args.point)),
        stored => Path::Stored(stored),
    };
    let trajectory = Trajectory { ballistics: args.ballistics, repeat: args.repeat, path };
    start(Body::StartTrajectory(trajectory), args.follow, global, out).await
}

async fn start(body: Body<'_>, wait: bool, global: &Global, out: &mut Out) -> Outcome {
    let request = Request::new(SubsystemId::CONTROL, body);
    let connection = Connection::open(global).await?;
    if !wait {
        return follow::begin(request, &connection, out).await;
    }
    let watch = [
        SubsystemId::CONTROL,
        SubsystemId::DEPLOYER,
        SubsystemId::GENERAL,
        SubsystemId::HORIZONTAL,
        SubsystemId::VERTICAL,
    ];
    let undo = Undo::of(&request).unwrap_or_default();
    let follow = Follow { connection: &connection, watch: &watch, undo };
    let begin = connection.send(&request);
    let mut ran = false;
    follow.run(out, begin, |states| judge(states, &mut ran)).await?;
    out.show(
        text::RequestDone { request: Shown(&request) }.of(current()),
        || json!({ "request": request.to_string(), "done": true }),
    )
}

fn judge(states: &States, ran: &mut bool) -> Step {
    let who = SubsystemId::CONTROL;
    let bits = states.flags(who);
    let flags = ControlFlags::from_bits_retain(bits);
    let deployer = DeployerFlags::from_bits_retain(states.flags(SubsystemId::DEPLOYER));
    let running = flags.intersects(ControlFlags::QUENCH | ControlFlags::TRAJECTORY);
    if running || deployer.contains(DeployerFlags::DEPLOYING) {
        *ran |= running;
        return Step::Running(progress(states, bits));
    }
    if flags.intersects(ControlFlags::MODE_FAULT | ControlFlags::INTERNAL_FAULT) {
        Step::Ended(stopped(who, bits))
    } else if *ran {
        Step::Done
    } else {
        Step::Idle(stopped(who, bits))
    }
}

fn progress(states: &States, bits: u32) -> String {
    let decoded = |who| states.of(who).and_then(|answer: &AnswerBuf| answer.decode().ok());
    let aim = [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL].map(|who| {
        match decoded(who).map(|answer| answer.data) {
            Some(Reply::Drive(status)) => crate::angle::degrees(i32::from(status.position)),
            _ => String::new(),
        }
    });
    let water = decoded(SubsystemId::GENERAL).map_or_else(String::new, |answer| values(&answer));
    let flags = flag_names(SubsystemId::CONTROL, bits).join(" ");
    format!("{} {}  {water}  {flags}", aim[0], aim[1])
}

/// Parses a point of a path.
pub fn point(text: &str) -> Result<TrajectoryPoint, String> {
    let parts: Vec<&str> = text.split(',').collect();
    let wrong = || text::PointExpected.str(current()).to_owned();
    let [horizontal, vertical, distance, dwell] = parts.as_slice() else { return Err(wrong()) };
    Ok(TrajectoryPoint {
        horizontal: horizontal.parse::<Angle>()?.0,
        vertical: vertical.parse::<Angle>()?.0,
        distance: distance.trim().parse().map_err(|_| wrong())?,
        dwell: dwell.trim().parse().map_err(|_| wrong())?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points() {
        let expected =
            TrajectoryPoint { horizontal: 1200, vertical: -120, distance: 25, dwell: 10 };
        assert_eq!(point("20deg,-120,25,10"), Ok(expected));
        for wrong in ["", "1,2,3", "1,2,3,4,5", "1,2,300,4", "1,2,-3,4"] {
            assert!(point(wrong).is_err(), "{wrong}");
        }
    }
}
