//! `lafet lockout`, `restart`, `crash`.

use clap::{Args, ValueEnum};
use lafet_proto::answer::Reply;
use lafet_proto::request::Body;
use lafet_proto::status::{FaultArch, FaultInfo};
use lafet_proto::{Request, SubsystemId};
use serde_json::{Map, Value, json};

use super::motion::simple;
use super::param::{failed_to_save, saved_name, saved_text};
use crate::cli::Global;
use crate::connect::Connection;
use crate::exchange;
use crate::failure::Outcome;
use crate::lang::pick;
use crate::out::{Out, columns};

/// `lafet lockout`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 lockout on\n  \
                        lafet -c tcp://127.0.0.1:10485 lockout off")]
pub struct LockoutArgs {
    /// on: everything stops, valves close, every command is refused; off: the monitor works again
    #[arg(value_name = "on|off")]
    state: Switch,
}

/// On or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Switch {
    On,
    Off,
}

/// `lafet restart`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 restart")]
pub struct RestartArgs {}

/// `lafet crash`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 crash\n  \
                        lafet -c tcp://127.0.0.1:10485 crash --json")]
pub struct CrashArgs {}

/// Locks out or releases.
pub async fn run_lockout(args: LockoutArgs, global: &Global, out: &mut Out) -> Outcome {
    let on = args.state == Switch::On;
    let connection = Connection::open(global).await?;
    let (answers, saved) = connection.monitor.save_lockout(on).await?;
    let request = Request::lockout(on);
    let what = match on {
        true => pick("Locked out over a power loss too", "Блокировка и после отключения питания"),
        false => pick("Released over a power loss too", "Снятие и после отключения питания"),
    };
    let answered = exchange::text(request.to, &answers);
    out.show(format!("{answered}\n{what}: {}.", saved_text(saved)), || {
        let mut json = exchange::json(&request, &answers);
        json["saved"] = json!(saved_name(saved));
        json
    })?;
    failed_to_save(saved)
}

/// Restarts the program.
pub async fn run_restart(global: &Global, out: &mut Out) -> Outcome {
    simple(Request::new(SubsystemId::ALL, Body::Restart), global, out).await
}

/// Shows the crash data.
pub async fn run_crash(global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    let answers = connection.ask(SubsystemId::GENERAL, Body::GetCrashData).await?;
    let Ok(Reply::Fault(info)) = answers.first().decode().map(|answer| answer.data) else {
        return out
            .show(pick("No crash data.", "Данных об отказе нет."), || json!({ "fault": null }));
    };
    if info == FaultInfo::NONE {
        let text = pick("No hardware fault is recorded.", "Аппаратных отказов не записано.");
        return out.show(text, || json!({ "fault": null }));
    }
    let words = words(&info);
    let rows: Vec<Vec<String>> = words
        .iter()
        .map(|(name, word)| vec![(*name).to_owned(), format!("{word:#010x}")])
        .collect();
    out.show(columns(&rows), || {
        let object: Map<String, Value> =
            words.iter().map(|(name, word)| ((*name).to_owned(), json!(word))).collect();
        json!({ "fault": object })
    })
}

fn words(info: &FaultInfo) -> Vec<(&'static str, u32)> {
    let all = info.to_words();
    let common = FaultInfo::NAMES.iter().copied();
    match info.arch {
        FaultArch::CortexM3(_) => common.zip(all).collect(),
        FaultArch::Arm7Tdmi(_) => {
            common.take(10).chain(FaultInfo::NAMES_ARM7TDMI).zip(all).collect()
        }
    }
}
