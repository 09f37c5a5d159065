//! `lafet seek`, `hotbeds`, `justify`: the fire detector.

use clap::Args;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{DeployerFlags, DetectorFlags};
use lafet_proto::request::{Body, Seek};
use lafet_proto::status::Hotbed;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::{Text as _, cli as text};
use serde_json::json;

use super::motion::stopped;
use crate::angle::{self, Bearing};
use crate::cli::Global;
use crate::connect::Connection;
use crate::describe::{hotbed_rows, hotbeds_json};
use crate::failure::Outcome;
use crate::follow::{self, Follow, Step};
use crate::lang::current;
use crate::out::{Out, columns};
use crate::undo::{States, Undo};

/// Arguments of `lafet seek`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
                        lafet -c tcp://127.0.0.1:10485 seek --from-az -60 --to-az 60\n  \
                        lafet -c sim:?fire=az=30,range=25 seek --analyse")]
pub struct SeekArgs {
    #[arg(long, value_name = "DEGREES", default_value = "-90", allow_hyphen_values = true)]
    from_az: Bearing,
    #[arg(long, value_name = "DEGREES", default_value = "90", allow_hyphen_values = true)]
    to_az: Bearing,
    #[arg(long, value_name = "DEGREES", default_value = "-10", allow_hyphen_values = true)]
    from_el: Bearing,
    #[arg(long, value_name = "DEGREES", default_value = "10", allow_hyphen_values = true)]
    to_el: Bearing,
    #[arg(long)]
    analyse: bool,
    #[arg(long)]
    no_wait: bool,
}

/// Arguments of `lafet hotbeds`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 hotbeds\n  \
                        lafet -c tcp://127.0.0.1:10485 hotbeds --json")]
pub struct HotbedsArgs {}

/// Arguments of `lafet justify`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 justify")]
pub struct JustifyArgs {
    #[arg(long)]
    no_wait: bool,
}

/// Runs `lafet seek`: searches a sector, and prints the fire spots found.
pub async fn run_seek(args: SeekArgs, global: &Global, out: &mut Out) -> Outcome {
    let seek = Seek {
        start_h: args.from_az.0,
        end_h: args.to_az.0,
        start_v: args.from_el.0,
        end_v: args.to_el.0,
        analyse: i16::from(args.analyse),
    };
    let request = Request::new(SubsystemId::DETECTOR, Body::StartSeek(seek));
    let connection = Connection::open(global).await?;
    if args.no_wait {
        return follow::begin(request, &connection, out).await;
    }
    let watch = [
        SubsystemId::DETECTOR,
        SubsystemId::DEPLOYER,
        SubsystemId::HORIZONTAL,
        SubsystemId::VERTICAL,
    ];
    let undo = Undo::of(&request).unwrap_or_default();
    let follow = Follow { connection: &connection, watch: &watch, undo };
    let begin = connection.send(&request);
    let mut searched = false;
    follow.run(out, begin, |states| judge_seek(states, &mut searched)).await?;
    let hotbeds = connection.monitor.hotbeds().await?;
    show(&hotbeds, out)
}

/// Runs `lafet hotbeds`: prints the fire spots of the last search.
pub async fn run_hotbeds(global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    let hotbeds = connection.monitor.hotbeds().await?;
    show(&hotbeds, out)
}

/// Runs `lafet justify`: aligns the detector.
pub async fn run_justify(args: JustifyArgs, global: &Global, out: &mut Out) -> Outcome {
    let request = Request::new(SubsystemId::DETECTOR, Body::StartJustify);
    let connection = Connection::open(global).await?;
    if args.no_wait {
        return follow::begin(request, &connection, out).await;
    }
    let watch = [SubsystemId::DETECTOR, SubsystemId::HORIZONTAL, SubsystemId::VERTICAL];
    let undo = Undo::of(&request).unwrap_or_default();
    let follow = Follow { connection: &connection, watch: &watch, undo };
    let begin = connection.send(&request);
    follow.run(out, begin, judge_justify).await?;
    let mut angles = Vec::new();
    for name in ["JustifyHorizontal", "JustifyVertical"] {
        let values = connection.monitor.param(SubsystemId::DETECTOR, name).await?;
        angles.push(values.first().copied().unwrap_or(0));
    }
    let [horizontal, vertical] = [0, 1].map(|index| angles.get(index).copied().unwrap_or(0));
    out.show(text::Aligned { horizontal, vertical }.of(current()), || {
        json!({
            "justified": true,
            "horizontal_arcmin": horizontal,
            "vertical_arcmin": vertical,
        })
    })
}

fn show(hotbeds: &[Hotbed], out: &mut Out) -> Outcome {
    let text = if hotbeds.is_empty() {
        text::NoFireSpots.str(current()).to_owned()
    } else {
        columns(&hotbed_rows(hotbeds))
    };
    out.show(text, || hotbeds_json(hotbeds))
}

fn judge_seek(states: &States, searched: &mut bool) -> Step {
    let who = SubsystemId::DETECTOR;
    let bits = states.flags(who);
    let flags = DetectorFlags::from_bits_retain(bits);
    let deployer = DeployerFlags::from_bits_retain(states.flags(SubsystemId::DEPLOYER));
    if deployer.contains(DeployerFlags::DEPLOYING) {
        return Step::Running(text::SeekDeploying.str(current()).into());
    }
    if flags.contains(DetectorFlags::SEARCHING) {
        *searched = true;
        return Step::Running(aim(states));
    }
    let broken = DetectorFlags::CANCELED | DetectorFlags::DEVICE_FAULT | DetectorFlags::BAD_SECTOR;
    if flags.intersects(broken) {
        Step::Ended(stopped(who, (flags & broken).bits()))
    } else if *searched || flags.contains(DetectorFlags::FOUND) {
        Step::Done
    } else {
        Step::Idle(stopped(who, bits))
    }
}

fn judge_justify(states: &States) -> Step {
    let who = SubsystemId::DETECTOR;
    let bits = states.flags(who);
    let flags = DetectorFlags::from_bits_retain(bits);
    if flags.contains(DetectorFlags::JUSTIFYING) {
        Step::Running(aim(states))
    } else if flags.contains(DetectorFlags::JUSTIFIED) {
        Step::Done
    } else {
        Step::Idle(stopped(who, bits))
    }
}

/// Direction of the barrel during a search, as text.
fn aim(states: &States) -> String {
    let position = |who| match states.of(who)?.decode().ok()?.data {
        Reply::Drive(status) => Some(angle::degrees(i32::from(status.position))),
        _ => None,
    };
    let [horizontal, vertical] = [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL].map(position);
    let (horizontal, vertical) = (horizontal.unwrap_or_default(), vertical.unwrap_or_default());
    text::SeekLooksAt { horizontal, vertical }.of(current())
}
