//! `lafet move`, `stop`, `open`, `close`, `deploy`, `wrap`: everything that moves.

use clap::Args;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{DeployerFlags, DriveFlags, ValveFlags};
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::{Shown, Text as _, cli as text};
use serde_json::json;

use crate::angle;
use crate::cli::{Global, drive, subsystem, valve};
use crate::connect::Connection;
use crate::describe::{flag_names, state_json};
use crate::exchange;
use crate::failure::{Failure, Outcome};
use crate::follow::{self, Follow, Step};
use crate::lang::current;
use crate::out::Out;
use crate::undo::{States, Undo};

/// A drive has reached its target when it is no farther off than this, arc-minutes or mm.
const TOLERANCE: i32 = 2;

/// Arguments of `lafet move`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 move vertical 20deg\n  \
                        lafet -c tcp://127.0.0.1:10485 move horizontal -1800\n  \
                        lafet -c tcp://127.0.0.1:10485 move nozzle 30mm")]
pub struct MoveArgs {
    #[arg(value_name = "DRIVE", value_parser = drive)]
    drive: SubsystemId,
    #[arg(value_name = "POSITION", allow_hyphen_values = true)]
    position: String,
    #[arg(long)]
    no_wait: bool,
}

/// Arguments of `lafet stop`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 stop\n  \
                        lafet -c tcp://127.0.0.1:10485 stop control")]
pub struct StopArgs {
    #[arg(value_name = "SUBSYSTEM", value_parser = subsystem)]
    subsystem: Option<SubsystemId>,
}

/// Arguments of `lafet open`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 open\n  \
                        lafet -c tcp://127.0.0.1:10485 open valve2 --no-wait")]
pub struct OpenArgs {
    #[arg(value_name = "VALVE", value_parser = valve)]
    valve: Option<SubsystemId>,
    #[arg(long)]
    no_wait: bool,
}

/// Arguments of `lafet close`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 close\n  \
                        lafet -c tcp://127.0.0.1:10485 close valve2")]
pub struct CloseArgs {
    #[arg(value_name = "VALVE", value_parser = valve)]
    valve: Option<SubsystemId>,
    #[arg(long)]
    no_wait: bool,
}

/// Arguments of `lafet deploy`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 deploy")]
pub struct DeployArgs {
    #[arg(long)]
    no_wait: bool,
}

/// Arguments of `lafet wrap`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 wrap")]
pub struct WrapArgs {
    #[arg(long)]
    no_wait: bool,
}

/// Runs `lafet move`.
pub async fn run_move(args: MoveArgs, global: &Global, out: &mut Out) -> Outcome {
    let target = angle::position(args.drive, &args.position).map_err(Failure::Usage)?;
    let request = Request::new(args.drive, Body::Move { destination: target });
    let judge = |states: &States| judge_move(args.drive, i32::from(target), states);
    start(request, args.no_wait, global, out, judge).await
}

/// Runs `lafet stop`.
pub async fn run_stop(args: StopArgs, global: &Global, out: &mut Out) -> Outcome {
    let request = Request::new(args.subsystem.unwrap_or(SubsystemId::ALL), Body::Stop);
    let connection = Connection::open_for(global, &[request]).await?;
    let ended = follow::begin(request, &connection, out).await;
    done_after_all(request, ended, out)
}

/// The outcome of a request that is repeated after a cut until its effect has been seen.
fn done_after_all(request: Request<'_>, ended: Outcome, out: &mut Out) -> Outcome {
    match ended {
        Err(Failure::BrokenOff(broken)) if broken.is_done() => {
            out.show(broken.message(), || json!({ "request": request.to_string(), "done": true }))
        }
        ended => ended,
    }
}

/// Runs `lafet open`.
pub async fn run_open(args: OpenArgs, global: &Global, out: &mut Out) -> Outcome {
    let valve = args.valve.unwrap_or(SubsystemId::VALVE1);
    let judge = |states: &States| judge_valve(valve, ValveFlags::OPEN, states);
    start(Request::open(valve), args.no_wait, global, out, judge).await
}

/// Runs `lafet close`.
pub async fn run_close(args: CloseArgs, global: &Global, out: &mut Out) -> Outcome {
    let valve = args.valve.unwrap_or(SubsystemId::VALVE1);
    let judge = |states: &States| judge_valve(valve, ValveFlags::CLOSED, states);
    let request = Request::close(valve);
    let ended = start(request, args.no_wait, global, out, judge).await;
    done_after_all(request, ended, out)
}

/// Runs `lafet deploy`.
pub async fn run_deploy(args: DeployArgs, global: &Global, out: &mut Out) -> Outcome {
    let request = Request::new(SubsystemId::DEPLOYER, Body::Deploy);
    let judge = |states: &States| judge_deployer(DeployerFlags::DEPLOYED, states);
    start(request, args.no_wait, global, out, judge).await
}

/// Runs `lafet wrap`: stows the barrel.
pub async fn run_wrap(args: WrapArgs, global: &Global, out: &mut Out) -> Outcome {
    let request = Request::new(SubsystemId::DEPLOYER, Body::Wrap);
    let judge = |states: &States| judge_deployer(DeployerFlags::WRAPPED, states);
    start(request, args.no_wait, global, out, judge).await
}

/// Sends a request that is complete with its answers, and shows them.
pub async fn simple(request: Request<'_>, global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open_for(global, &[request]).await?;
    let answers = connection.send(&request).await?;
    out.show(exchange::text(request.to, &answers), || exchange::json(&request, &answers))
}

/// Sends a request to the subsystem that executes it, and follows the execution.
async fn start(
    request: Request<'_>,
    no_wait: bool,
    global: &Global,
    out: &mut Out,
    judge: impl FnMut(&States) -> Step,
) -> Outcome {
    let connection = Connection::open_for(global, &[request]).await?;
    if no_wait {
        return follow::begin(request, &connection, out).await;
    }
    let who = request.to;
    let undo = Undo::of(&request).unwrap_or_default();
    let follow = Follow { connection: &connection, watch: &[who], undo };
    let begin = connection.send(&request);
    let states = follow.run(out, begin, judge).await?;
    let Some(answer) = states.of(who) else { return Ok(()) };
    let text = match answer.decode() {
        Ok(decoded) => decoded.to_string(),
        Err(_) => who.to_string(),
    };
    let text = text.split_once("→ Ok: ").map_or(text.as_str(), |(_, state)| state);
    out.show(
        format!("{request}: {} {text}", text::DoneThen.str(current())),
        || json!({ "request": request.to_string(), "done": true, "state": state_json(answer) }),
    )
}

fn judge_move(drive: SubsystemId, target: i32, states: &States) -> Step {
    let Some(answer) = states.of(drive) else { return Step::Idle(stopped(drive, 0)) };
    let (position, bits) = match answer.decode().map(|answer| answer.data) {
        Ok(Reply::Drive(status)) => (i32::from(status.position), status.flags.bits()),
        Ok(Reply::Deployer(status)) => (i32::from(status.position), status.flags.bits()),
        _ => return Step::Ended(stopped(drive, 0)),
    };
    let (show, to) = (angle::show(drive, position), angle::show(drive, target));
    if bits & DriveFlags::MOVE.bits() != 0 {
        return Step::Running(format!("{drive} {show} → {to}"));
    }
    // §3.1: a target beyond a limit moves the drive to the limit.
    let flags = DriveFlags::from_bits_retain(bits);
    let up = DriveFlags::MAX_LIMIT_REACHED | DriveFlags::ABSOLUTE_MAX_LIMIT_REACHED;
    let down = DriveFlags::MIN_LIMIT_REACHED | DriveFlags::ABSOLUTE_MIN_LIMIT_REACHED;
    let at_limit = if target > position { flags.intersects(up) } else { flags.intersects(down) };
    if (position - target).abs() <= TOLERANCE || at_limit {
        return Step::Done;
    }
    let flags = stopped(drive, bits);
    Step::Idle(text::StoppedBefore { drive: Shown(drive), show, to, flags }.of(current()))
}

fn judge_valve(valve: SubsystemId, wanted: ValveFlags, states: &States) -> Step {
    let bits = states.flags(valve);
    let flags = ValveFlags::from_bits_retain(bits);
    let names = flag_names(valve, bits).join(" ");
    if flags.contains(wanted) && !flags.intersects(ValveFlags::OPENING | ValveFlags::CLOSING) {
        Step::Done
    } else if flags.intersects(ValveFlags::OPENING | ValveFlags::CLOSING) {
        Step::Running(format!("{valve} {names}"))
    } else {
        Step::Idle(stopped(valve, bits))
    }
}

fn judge_deployer(wanted: DeployerFlags, states: &States) -> Step {
    let who = SubsystemId::DEPLOYER;
    let bits = states.flags(who);
    let flags = DeployerFlags::from_bits_retain(bits);
    if flags.contains(wanted) {
        return Step::Done;
    }
    if !flags.intersects(DeployerFlags::DEPLOYING | DeployerFlags::WRAPPING) {
        return Step::Idle(stopped(who, bits));
    }
    let position = match states.of(who).and_then(|answer| answer.decode().ok()) {
        Some(answer) => match answer.data {
            Reply::Deployer(status) => angle::show(who, i32::from(status.position)),
            _ => String::new(),
        },
        None => String::new(),
    };
    Step::Running(format!("{who} {} {position}", flag_names(who, bits).join(" ")))
}

/// What the flags say about a subsystem at rest in the wrong place, and what to do.
pub fn stopped(who: SubsystemId, bits: u32) -> String {
    use lafet_proto::flags::Severity;
    let lines = crate::describe::flag_lines(who, bits, Severity::Notice);
    if lines.is_empty() {
        text::StoppedWithoutFlag { who: Shown(who) }.of(current())
    } else {
        format!("{who}: {}", lines.join(" "))
    }
}
