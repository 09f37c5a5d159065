//! `lafet limits`: the limits of motion.

use clap::{Args, Subcommand};
use lafet_proto::answer::Reply;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::cli as text;
use serde_json::{Map, Value, json};

use super::motion::simple;
use super::teach::TeachArgs;
use crate::angle;
use crate::cli::{Global, drive};
use crate::connect::Connection;
use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::{Out, columns};

/// Arguments of `lafet limits`.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 limits\n  \
                        lafet -c tcp://127.0.0.1:10485 limits vertical\n  \
                        lafet -c tcp://127.0.0.1:10485 limits off vertical\n  \
                        lafet -c tcp://127.0.0.1:10485 limits reject"
)]
pub struct LimitsArgs {
    #[command(subcommand)]
    command: Option<LimitsCommand>,
    #[arg(value_name = "DRIVE|off|on|reject")]
    what: Option<String>,
    #[arg(value_name = "DRIVE", value_parser = drive)]
    drive: Option<SubsystemId>,
}

/// Subcommands with arguments of their own.
#[derive(Debug, Subcommand)]
pub enum LimitsCommand {
    Teach(TeachArgs),
}

/// Runs `lafet limits`: shows, switches or sets the limits.
pub async fn run(args: LimitsArgs, global: &Global, out: &mut Out) -> Outcome {
    if let Some(LimitsCommand::Teach(args)) = args.command {
        return super::teach::run(args, global, out).await;
    }
    let state = match args.what.as_deref() {
        Some(word) if word.eq_ignore_ascii_case("off") => Some(0),
        Some(word) if word.eq_ignore_ascii_case("on") => Some(1),
        Some(word) if word.eq_ignore_ascii_case("reject") => Some(2),
        _ => None,
    };
    if let Some(new_state) = state {
        let to = args.drive.unwrap_or(SubsystemId::MOTORS);
        return simple(Request::new(to, Body::SwitchLimits { new_state }), global, out).await;
    }
    if args.drive.is_some() {
        return Err(Failure::Usage(text::LimitsUsage.str(current()).into()));
    }
    let who = match args.what.as_deref() {
        Some(name) => drive(name)
            .map_err(|error| Failure::Usage(format!("`{name}`: {error}, off, on, reject")))?,
        None => SubsystemId::ALL,
    };
    show(who, global, out).await
}

async fn show(who: SubsystemId, global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    let answers = connection.ask(who, Body::RetrieveLimits).await?;
    let mut rows = Vec::new();
    let mut object = Map::new();
    for answer in &*answers {
        let from = answer.from();
        let Ok(Reply::Limits(limits)) = answer.decode().map(|answer| answer.data) else { continue };
        rows.push(vec![
            from.to_string(),
            angle::show(from, limits.min),
            "…".into(),
            angle::show(from, limits.max),
        ]);
        let unit = if from == SubsystemId::NOZZLE { "mm" } else { "arcmin" };
        let json = json!({ "min": limits.min, "max": limits.max, "unit": unit });
        object.insert(from.to_string(), json);
    }
    out.show(columns(&rows), || Value::Object(object))
}
