//! `lafet lockout`, `restart`, `crash`.

use clap::{Args, ValueEnum};
use lafet_client::Saved;
use lafet_proto::answer::Reply;
use lafet_proto::crash::Context;
use lafet_proto::request::Body;
use lafet_proto::status::FaultInfo;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::cli as text;
use serde_json::{Map, Value, json};

use super::motion::simple;
use super::param::failed_to_save;
use crate::cli::Global;
use crate::connect::Connection;
use crate::exchange;
use crate::failure::Outcome;
use crate::insist::insist;
use crate::lang::{current, of};
use crate::out::Out;

/// Arguments of `lafet lockout`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 lockout on\n  \
                        lafet -c tcp://127.0.0.1:10485 lockout off")]
pub struct LockoutArgs {
    #[arg(value_name = "on|off")]
    state: Switch,
}

/// State of the lockout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Switch {
    On,
    Off,
}

/// Arguments of `lafet restart`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 restart")]
pub struct RestartArgs {}

/// Arguments of `lafet crash`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 crash\n  \
                        lafet -c tcp://127.0.0.1:10485 crash --json")]
pub struct CrashArgs {}

/// Runs `lafet lockout`: locks the monitor out or releases it.
pub async fn run_lockout(args: LockoutArgs, global: &Global, out: &mut Out) -> Outcome {
    let on = args.state == Switch::On;
    let request = Request::lockout(on);
    let connection = Connection::open_for(global, &[request]).await?;
    let lock = || async { Ok(connection.monitor.save_lockout(on).await?) };
    // A lockout is repeated as a Stop is; its release never is.
    let (answers, saved) =
        if on { insist(&request.to_string(), lock).await? } else { lock().await? };
    let answered = exchange::text(request.to, &answers);
    out.show(format!("{answered}\n{}", stored_text(on, saved)), || {
        let mut json = exchange::json(&request, &answers);
        json["saved"] = json!(saved.name());
        json
    })?;
    failed_to_save(saved)
}

/// What the next start will find. A release is sent once, so the monitor cannot say later that it is stored.
fn stored_text(on: bool, saved: Saved) -> &'static str {
    match (on, saved) {
        (true, Saved::Stored) => text::LockoutStored.str(current()),
        (true, Saved::Unconfirmed) => text::LockoutUnconfirmed.str(current()),
        (true, Saved::WriteFailed) => text::LockoutNotStored.str(current()),
        (false, Saved::Stored) => text::ReleaseStored.str(current()),
        (false, Saved::Unconfirmed) => text::ReleaseUnconfirmed.str(current()),
        (false, Saved::WriteFailed) => text::ReleaseNotStored.str(current()),
    }
}

/// Runs `lafet restart`.
pub async fn run_restart(global: &Global, out: &mut Out) -> Outcome {
    simple(Request::new(SubsystemId::ALL, Body::Restart), global, out).await
}

/// Runs `lafet crash`: shows the data of the last hardware fault.
pub async fn run_crash(global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    let answers = connection.ask(SubsystemId::GENERAL, Body::GetCrashData).await?;
    let Ok(Reply::Fault(info)) = answers.first().decode().map(|answer| answer.data) else {
        return out.show(text::NoCrashData.str(current()), || json!({ "fault": null }));
    };
    if info == FaultInfo::NONE {
        let text = text::NoHardwareFault.str(current());
        return out.show(text, || json!({ "fault": null }));
    }
    out.show(crash_text(&info), || crash_json(&info))
}

/// Each register; below the fault status registers, the bits that are set.
fn crash_text(info: &FaultInfo) -> String {
    let mut lines = Vec::new();
    for (name, word) in info.registers() {
        lines.push(format!("{name:<9}  {word:#010x}{}", remark(info, name)));
        for bit in info.bits().filter(|bit| bit.register == name) {
            lines.push(format!("    {:<11}  {}", bit.name, of(&bit.meaning)));
            lines.push(format!("    {:<11}  → {}", "", of(&bit.remedy)));
        }
        for (_, unknown) in info.unknown_bits().iter().filter(|(n, bits)| *n == name && *bits != 0)
        {
            let text = text::UnknownBits.str(current());
            lines.push(format!("    {text}: {unknown:#010x}"));
        }
    }
    lines.extend(info.summary().map(|text| of(&text).to_owned()));
    lines.join("\n")
}

/// Explains a word of the fault data that its name does not explain.
fn remark(info: &FaultInfo, name: &str) -> String {
    if let Some(note) = info.note(name) {
        return format!("  {}", of(&note));
    }
    if !matches!(name, "psr" | "spsr") {
        return String::new();
    }
    let context = info.context();
    let number = context.number().map(|number| format!(" {number}")).unwrap_or_default();
    let running = text::CrashRunning.str(current());
    format!("  {running}: {}{number}", executed(context))
}

/// What the processor was executing.
fn executed(context: Context) -> &'static str {
    context.name().or_else(|| context.text().map(|text| of(&text))).unwrap_or_default()
}

fn crash_json(info: &FaultInfo) -> Value {
    let words: Map<String, Value> =
        info.registers().map(|(name, word)| (name.to_owned(), json!(word))).collect();
    let bits: Vec<Value> = info
        .bits()
        .map(|bit| {
            json!({
                "register": bit.register,
                "bit": bit.bit,
                "name": bit.name,
                "meaning": of(&bit.meaning),
                "remedy": of(&bit.remedy),
            })
        })
        .collect();
    let context = info.context();
    json!({
        "fault": words,
        "bits": bits,
        "running": { "what": executed(context), "number": context.number() },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(hfsr: u32, cfsr: u32) -> FaultInfo {
        let mut words = [0x0800_1234; 20];
        (words[14], words[17], words[19]) = (hfsr, cfsr, 0x0100_001B);
        FaultInfo::from_words(words)
    }

    #[test]
    fn registers_are_shown_bit_by_bit() {
        let text = crash_text(&info(1 << 30, 1 << 9 | 1 << 15));
        let line = |start: &str| text.lines().find(|line| line.trim().starts_with(start)).unwrap();
        assert!(line("PRECISERR").contains("failed on the bus"), "{text}");
        assert!(line("mmfar").contains("not valid") && !line("bfar").contains("not valid"));
        assert!(line("psr").contains("interrupt 11"), "{text}");
        let json = crash_json(&info(0, 1 << 25));
        assert_eq!(json["bits"][0]["name"], "DIVBYZERO");
        assert_eq!(
            (&json["fault"]["pc"], &json["running"]["number"]),
            (&json!(0x0800_1234), &json!(11))
        );
        assert!(crash_text(&info(0, 0)).contains("watchdog"));
    }
}
