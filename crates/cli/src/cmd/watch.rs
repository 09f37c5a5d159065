//! `lafet watch`: shows the state repeatedly.

use std::io::{self, IsTerminal};
use std::time::Duration;

use clap::Args;
use lafet_client::AnswerBuf;
use lafet_proto::SubsystemId;
use lafet_texts::cli as text;
use tokio::time::{Instant, MissedTickBehavior, interval};

use super::status;
use crate::cli::{Global, seconds, subsystem};
use crate::connect::Connection;
use crate::describe;
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::{current, decimal};
use crate::out::Out;

/// Arguments of `lafet watch`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 watch\n  \
                        lafet -c tcp://127.0.0.1:10485 watch control --interval 0.2 --json")]
pub struct WatchArgs {
    #[arg(value_name = "SUBSYSTEM", value_parser = subsystem)]
    subsystem: Option<SubsystemId>,
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, value_parser = every)]
    interval: f64,
    #[arg(long, value_name = "N")]
    count: Option<u64>,
}

fn every(text: &str) -> Result<f64, String> {
    seconds(text, 0.02)
}

/// Runs `lafet watch`.
pub async fn run(args: WatchArgs, global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    let mut interrupt = Interrupt::catch()?;
    let who = args.subsystem.unwrap_or(SubsystemId::ALL);
    let began = Instant::now();
    let mut looks = interval(Duration::from_secs_f64(args.interval));
    looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let live = io::stdout().is_terminal() && !out.json();
    let mut left = args.count.unwrap_or(u64::MAX);
    while left > 0 {
        left -= 1;
        let look = async {
            looks.tick().await;
            status::read(&connection, who).await
        };
        let answers = tokio::select! {
            answers = look => answers,
            () = interrupt.wait() => return Ok(()),
        };
        let at_s = began.elapsed().as_secs_f64();
        match answers {
            Ok(answers) if live => screen(out, at_s, &answers, global)?,
            Ok(answers) => show(out, at_s, &answers)?,
            // A monitor that is off may come back; one that refuses will refuse again.
            Err(failure) if failure.exit_code() == 3 && args.count.is_none() => {
                report(out, at_s, &failure)?;
            }
            Err(failure) => return Err(failure),
        }
    }
    Ok(())
}

fn show(out: &mut Out, at_s: f64, answers: &[AnswerBuf]) -> Outcome {
    if out.json() {
        let mut json = status::json(answers);
        json["t_s"] = serde_json::json!((at_s * 1000.0).round() / 1000.0);
        return out.value(&json);
    }
    out.say(line(at_s, answers))
}

/// Draws the table in place of the previous one.
fn screen(out: &mut Out, at_s: f64, answers: &[AnswerBuf], global: &Global) -> Outcome {
    let hint = match global.open {
        // In a shell, Ctrl-C would stop what moves as well.
        Some(_) => text::EnterEnds.str(current()),
        None => text::CtrlCEnds.str(current()),
    };
    // Move home, clear the rest of each line, and everything below the last one.
    let (at_s, s) = (decimal(at_s, 1), text::UnitS.str(current()));
    let table = status::table(answers).replace('\n', "\x1b[K\n");
    out.say(format!("\x1b[H{table}\x1b[K\n\x1b[K\n{at_s} {s}  {hint}\x1b[J"))
}

fn report(out: &mut Out, at_s: f64, failure: &Failure) -> Outcome {
    if out.json() {
        let mut json = failure.json();
        json["t_s"] = serde_json::json!((at_s * 1000.0).round() / 1000.0);
        return out.value(&json);
    }
    out.say(format!("{} {}  {}", decimal(at_s, 1), text::UnitS.str(current()), failure.message()))
}

/// The state in one line, for a file or a pipe.
fn line(at_s: f64, answers: &[AnswerBuf]) -> String {
    let part = |answer: &AnswerBuf| {
        let decoded = answer.decode().ok()?;
        let bits = decoded.data.flags_bits()?;
        let values = describe::values(&decoded);
        let flags = describe::flag_names(answer.from(), bits).join(" ");
        let separator = if values.is_empty() || flags.is_empty() { "" } else { ", " };
        Some(format!("{}: {values}{separator}{flags}", answer.from()))
    };
    let parts: Vec<String> = answers.iter().filter_map(part).collect();
    format!("{} {}  {}", decimal(at_s, 1), text::UnitS.str(current()), parts.join(" | "))
}
