//! `lafet param get|set|list`.

use clap::{Args, Subcommand};
use lafet_client::{Error, Saved};
use lafet_proto::param::{Access, Effect, Param, ParamSpec, Placement};
use lafet_proto::{ParamId, Status, SubsystemId};
use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};

use super::backup::{BackupArgs, DiffArgs, RestoreArgs, run_backup, run_diff, run_restore};
use crate::cli::{Global, subsystem};
use crate::connect::Connection;
use crate::failure::{Failure, Outcome};
use crate::lang::{current, of};
use crate::out::{Out, columns, complain};

/// Subcommands of `lafet param`.
#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 param list vertical\n  \
                        lafet -c tcp://127.0.0.1:10485 param set vertical Speed 8")]
pub enum ParamCommand {
    #[command(
        after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 param get vertical MaxLimit\n  \
                            lafet -c tcp://127.0.0.1:10485 param get detector 0x23fe"
    )]
    Get(GetArgs),
    #[command(
        after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 param set vertical MaxLimit \
                            4000\n  lafet -c tcp://127.0.0.1:10485 param set control Program0 \
                            -1200 300 60 600 300 2 25"
    )]
    Set(SetArgs),
    #[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 param list\n  \
                            lafet -c tcp://127.0.0.1:10485 param list vertical --json")]
    List(ListArgs),
    #[command(
        after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 param backup monitor-1.toml\n  \
                      lafet -c tcp://127.0.0.1:10485 param backup - --firmware 2.4"
    )]
    Backup(BackupArgs),
    #[command(
        after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 param diff monitor-1.toml\n  \
                      lafet param diff monitor-1.toml monitor-2.toml"
    )]
    Diff(DiffArgs),
    #[command(
        after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 param restore monitor-1.toml \
                      --dry-run\n  lafet -c tcp://127.0.0.1:10485 param restore monitor-1.toml \
                      --except General.Address"
    )]
    Restore(RestoreArgs),
}

/// Arguments of `lafet param get`.
#[derive(Debug, Args)]
pub struct GetArgs {
    #[arg(value_name = "SUBSYSTEM", value_parser = subsystem)]
    subsystem: SubsystemId,
    #[arg(value_name = "NAME")]
    name: String,
}

/// Arguments of `lafet param set`.
#[derive(Debug, Args)]
pub struct SetArgs {
    #[arg(value_name = "SUBSYSTEM", value_parser = subsystem)]
    subsystem: SubsystemId,
    #[arg(value_name = "NAME")]
    name: String,
    #[arg(value_name = "VALUE", required = true, allow_negative_numbers = true, value_parser = value)]
    values: Vec<i32>,
}

/// Arguments of `lafet param list`.
#[derive(Debug, Args)]
pub struct ListArgs {
    #[arg(value_name = "SUBSYSTEM", value_parser = subsystem)]
    subsystem: Option<SubsystemId>,
}

/// Runs `lafet param`.
pub async fn run(command: ParamCommand, global: &Global, out: &mut Out) -> Outcome {
    match command {
        ParamCommand::Get(args) => get(args, global, out).await,
        ParamCommand::Set(args) => set(args, global, out).await,
        ParamCommand::List(args) => list(args, global, out).await,
        ParamCommand::Backup(args) => run_backup(args, global, out).await,
        ParamCommand::Diff(args) => run_diff(args, global, out).await,
        ParamCommand::Restore(args) => run_restore(args, global, out).await,
    }
}

async fn get(args: GetArgs, global: &Global, out: &mut Out) -> Outcome {
    let (who, id) = (args.subsystem, id(args.subsystem, &args.name));
    let connection = Connection::open(global).await?;
    let values = connection.monitor.param_id(who, id).await?;
    let name = name(who, id).unwrap_or(&args.name);
    let text = match Param::find(who, id) {
        Some(param) => {
            let spec = param.spec();
            let range = range(spec);
            let range = if range.is_empty() { range } else { format!(" ({range})") };
            format!("{who} {name} = {}{range}\n{}", shown(Some(spec), &values), of(&param.text()))
        }
        None => format!("{who} {name} = {}", shown(None, &values)),
    };
    out.show(text, || value_json(who, id, name, &values))
}

async fn set(args: SetArgs, global: &Global, out: &mut Out) -> Outcome {
    let (who, id) = (args.subsystem, id(args.subsystem, &args.name));
    let connection = Connection::open(global).await?;
    let param = Param::find(who, id);
    let saved = connection.monitor.save_param_id(who, id, &args.values).await;
    let saved = saved.map_err(|error| explain(error.into(), param))?;
    let name = name(who, id).unwrap_or(&args.name);
    let later = param.is_some_and(|param| param.spec().effect == Effect::Restart);
    let when = match later {
        true => text::TakesEffectLater.str(current()),
        false => "",
    };
    let shown = shown(param.map(Param::spec), &args.values);
    out.show(format!("{who} {name} = {shown}: {}.{when}", saved_text(saved)), || {
        json!({
            "subsystem": who.to_string(),
            "name": name,
            "values": args.values,
            "status": if saved == Saved::Stored { "Ok" } else { "Accepted" },
            "saved": saved.name(),
            "acts": if later { "after-restart" } else { "at-once" },
        })
    })?;
    failed_to_save(saved)
}

/// Whether a value is stored, as text.
pub fn saved_text(saved: Saved) -> &'static str {
    match saved {
        Saved::Stored => text::ValueStored.str(current()),
        Saved::Unconfirmed => text::ValueAccepted.str(current()),
        Saved::WriteFailed => text::ValueInForce.str(current()),
    }
}

/// Fails if the monitor could not store the value.
pub fn failed_to_save(saved: Saved) -> Outcome {
    if saved != Saved::WriteFailed {
        return Ok(());
    }
    Err(Failure::Ended(text::MemoryNotWritten.str(current()).into()))
}

/// Adds the range and meaning from the dictionary to a refusal of a value.
fn explain(failure: Failure, param: Option<Param>) -> Failure {
    let wrong_value = [Status::INVALID_VALUE, Status::WRONG_DATA];
    let Some(param) = param else { return failure };
    if wrong_value.iter().any(|status| failure.is_refused_with(*status)) {
        let hint = text::ValuesAllowed {
            name: param.name(),
            range: range(param.spec()),
            text: of(&param.text()),
        }
        .of(current());
        // The error itself describes the refusal; the hint precedes it.
        complain(hint);
    }
    failure
}

async fn list(args: ListArgs, global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    let wanted = |param: &Param| args.subsystem.is_none_or(|who| param.spec().subsystem == who);
    let params: Vec<Param> = Param::ALL.into_iter().filter(wanted).collect();
    if params.is_empty() {
        let none = text::NoParameters.str(current());
        return out.show(none, || json!([]));
    }
    let mut rows = Vec::new();
    let mut all = Vec::new();
    for (param, values) in params.iter().zip(connection.monitor.params(&params).await) {
        let spec = param.spec();
        let who = spec.subsystem;
        let value = match values {
            Ok(values) => {
                all.push(value_json(who, spec.id, param.name(), &values));
                shown(Some(spec), &values)
            }
            // This monitor does not have the subsystem.
            Err(Error::Refused { status: Status::MODULE_NOT_EXIST, .. })
                if args.subsystem.is_none() =>
            {
                continue;
            }
            Err(Error::Refused { status, .. }) => {
                all.push(json!({
                    "subsystem": who.to_string(),
                    "name": param.name(),
                    "status": status.to_string(),
                }));
                status.to_string()
            }
            Err(error) => return Err(error.into()),
        };
        rows.push(vec![who.to_string(), param.name().into(), value, range(spec)]);
    }
    out.show(columns(&rows), || Value::Array(all))
}

/// The id for a name of the dictionary, any other name, or a number.
fn id(who: SubsystemId, name: &str) -> ParamId {
    let number = |digits: &str| u16::from_str_radix(digits, 16).ok().map(ParamId);
    match (Param::by_name(who, name), name.strip_prefix("0x").and_then(number)) {
        (Some(param), _) => param.spec().id,
        (None, Some(id)) => id,
        (None, None) => ParamId::of(name.trim_start_matches('@')),
    }
}

fn name(who: SubsystemId, id: ParamId) -> Option<&'static str> {
    Param::find(who, id).map(Param::name)
}

/// The values with their units.
pub fn shown(spec: Option<&'static ParamSpec>, values: &[i32]) -> String {
    if values.is_empty() {
        return text::NoValues.str(current()).into();
    }
    let one = |(index, value): (usize, &i32)| match spec {
        Some(spec) => with_unit(spec, index, *value),
        None => value.to_string(),
    };
    values.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
}

fn with_unit(spec: &ParamSpec, index: usize, value: i32) -> String {
    use lafet_proto::param::Unit;
    let unit = spec.element(index).unit;
    match unit {
        Unit::Bits => format!("{value:#x}"),
        // Symbols like "×0.1 A" apply to the number as sent.
        _ => {
            let name = unit.name().map_or("", |name| of(&name));
            let blank = if matches!(name, "" | "'" | "°") { "" } else { " " };
            format!("{value}{blank}{name}")
        }
    }
}

/// The allowed values: `-900…4500', default 0, after restart`.
fn range(spec: &ParamSpec) -> String {
    let mut parts = Vec::new();
    match spec.access {
        Access::ReadOnly => parts.push(text::ReadOnly.str(current()).to_owned()),
        Access::ReadWrite if spec.elements.is_empty() => {
            parts.push(format!("{}…{}", spec.min, spec.max));
            parts.push(text::DefaultValue { value: spec.default }.of(current()));
        }
        Access::ReadWrite => {
            let elements = spec.elements.iter().map(|one| format!("{}…{}", one.min, one.max));
            parts.push(elements.collect::<Vec<_>>().join(" "));
        }
    }
    if spec.effect == Effect::Restart {
        parts.push(text::AfterRestart.str(current()).into());
    }
    if spec.placement == Placement::Unit {
        parts.push(text::MayBeOnRemoteUnit.str(current()).into());
    }
    parts.join(", ")
}

fn value_json(who: SubsystemId, id: ParamId, name: &str, values: &[i32]) -> Value {
    json!({
        "subsystem": who.to_string(),
        "name": name,
        "id": id.0,
        "values": values,
        "unit": Param::find(who, id).map(|param| param.spec().unit.symbol()),
    })
}

fn value(text: &str) -> Result<i32, String> {
    let hex = |digits: &str| u32::from_str_radix(digits, 16).ok().map(u32::cast_signed);
    text.parse()
        .ok()
        .or_else(|| text.strip_prefix("0x").and_then(hex))
        .ok_or_else(|| text::WholeNumberExpected.str(current()).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers() {
        let detector = SubsystemId::DETECTOR;
        for name in ["Hotbeds", "hotbeds", "0x23fe", "0x23FE", "@Hotbeds"] {
            assert_eq!(id(detector, name), ParamId::HOTBEDS, "{name}");
        }
        assert_eq!(id(detector, "FaultInfo"), ParamId::FAULT_INFO);
        assert_eq!((value("-5"), value("0xffffffff")), (Ok(-5), Ok(-1)));
        assert!(value("1.5").is_err());
    }
}
