//! `lafet status`: the state of the monitor, and what its flags mean.

use clap::Args;
use lafet_client::{AnswerBuf, Answers};
use lafet_proto::flags::Severity;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use serde_json::{Map, Value};

use crate::cli::{Global, subsystem};
use crate::connect::Connection;
use crate::describe;
use crate::failure::{Failure, Outcome};
use crate::out::{Out, columns};

/// Arguments of `lafet status`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 status\n  \
                        lafet -c sim: status deployer --json")]
pub struct StatusArgs {
    #[arg(value_name = "SUBSYSTEM", value_parser = subsystem)]
    subsystem: Option<SubsystemId>,
}

/// Runs `lafet status`.
pub async fn run(args: StatusArgs, global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    let answers = read(&connection, args.subsystem.unwrap_or(SubsystemId::ALL)).await?;
    out.show(table(&answers), || json(&answers))
}

/// Reads the state of one subsystem, or of all.
pub async fn read(connection: &Connection, who: SubsystemId) -> Result<Answers, Failure> {
    let answers = connection.client.request(&Request::new(who, Body::GetStatus)).await?;
    // A single refusal applies to the whole request; one among several answers is shown in its row.
    if answers.len() > 1 { Ok(answers) } else { Ok(answers.accepted()?) }
}

/// A row for each subsystem, followed by the meaning of its flags.
pub fn table(answers: &[AnswerBuf]) -> String {
    let mut rows = Vec::new();
    let mut notes = Vec::new();
    for answer in answers {
        let from = answer.from();
        if !answer.status().is_success() {
            rows.push(vec![from.to_string(), answer.status().to_string()]);
            continue;
        }
        let Ok(decoded) = answer.decode() else {
            rows.push(vec![from.to_string(), describe::hex(answer.data())]);
            continue;
        };
        let bits = decoded.data.flags_bits().unwrap_or(0);
        let flags = describe::flag_names(from, bits).join(" ");
        rows.push(vec![from.to_string(), flags, describe::values(&decoded)]);
        let lines = describe::flag_lines(from, bits, Severity::Info);
        notes.extend(lines.into_iter().map(|line| format!("{from} {line}")));
    }
    let notes = notes.iter().map(|note| format!("\n{note}")).collect::<String>();
    format!("{}\n{notes}", columns(&rows)).trim_end().to_owned()
}

/// An object with a member for each subsystem.
pub fn json(answers: &[AnswerBuf]) -> Value {
    let state = |answer: &AnswerBuf| (answer.from().to_string(), describe::state_json(answer));
    Value::Object(answers.iter().map(state).collect::<Map<_, _>>())
}
