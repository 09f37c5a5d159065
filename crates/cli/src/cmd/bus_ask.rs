//! `lafet bus who` and `lafet bus log`: what the controller of a bus reports (§B/1).

use clap::Args;
use lafet_client::{Answers, Client, Error};
use lafet_proto::answer::Reply;
use lafet_proto::bus::{CONTROLLER, Log};
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::{Text as _, cli as text};
use serde_json::json;

use super::bus::{called, logged, logged_json};
use crate::cli::Global;
use crate::connect::Connection;
use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::Out;

/// Arguments of `lafet bus who`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 bus who\n  \
                        lafet -c 'serial:///dev/ttyUSB0?role=active&src=130' bus who --json")]
pub struct WhoArgs {}

/// Arguments of `lafet bus log`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 bus log\n  \
                        lafet -c tcp://127.0.0.1:10485 bus log --last 20")]
pub struct LogArgs {
    #[arg(long, value_name = "NUMBER")]
    last: Option<usize>,
}

/// Lines requested at once; the controller answers with as many as fit into a record.
const LINES: u16 = 32;

/// Runs `lafet bus who`: lists the addresses present.
pub async fn who(global: &Global, out: &mut Out) -> Outcome {
    let (_connection, controller) = controller(global).await?;
    let answers = ask(&controller, Body::GetNetworkStatus).await?;
    let Some(Reply::Network(status)) = answers.first().decode().ok().map(|a| a.data) else {
        return Err(no_controller());
    };
    let present: Vec<u8> = status.iter().collect();
    let rows: Vec<String> = present.iter().map(|address| called(*address)).collect();
    let text = match &rows[..] {
        [] => text::NobodyOnBus.str(current()).into(),
        rows => rows.join("\n"),
    };
    out.show(text, || json!({ "present": present }))
}

/// Runs `lafet bus log`: prints the controller's journal of control requests.
pub async fn log(args: &LogArgs, global: &Global, out: &mut Out) -> Outcome {
    let (_connection, controller) = controller(global).await?;
    let mut lines = Vec::new();
    let mut first = 0_u16;
    loop {
        let answers = ask(&controller, Body::GetLog { first, count: LINES }).await?;
        let decoded = answers.first().decode().ok().map(|answer| answer.data);
        let Some(Reply::Log(log @ Log { count, .. })) = decoded else {
            return Err(no_controller());
        };
        for line in log.iter().map_while(Result::ok) {
            let text = logged(line.time_s, line.dst, line.src, &line.record);
            lines.push((text, logged_json(line.time_s, line.dst, line.src, &line.record)));
        }
        first = match first.checked_add(count) {
            Some(next) if count > 0 => next,
            _ => break,
        };
    }
    let skipped = args.last.map_or(0, |last| lines.len().saturating_sub(last));
    if lines.is_empty() {
        return out.say(text::NothingAskedYet.str(current()));
    }
    lines.into_iter().skip(skipped).try_for_each(|(text, json)| out.show(text, || json))
}

async fn controller(global: &Global) -> Result<(Connection, Client), Failure> {
    let connection = Connection::open(global).await?;
    let controller = connection.client.at(CONTROLLER)?;
    Ok((connection, controller))
}

async fn ask(controller: &Client, body: Body<'_>) -> Result<Answers, Failure> {
    let request = Request::new(SubsystemId::GENERAL, body);
    let answers = match controller.request(&request).await {
        Err(Error::NoAnswer { endpoint, tries, .. }) => {
            return Err(Failure::Silent(
                text::NoControllerAnswers { endpoint: &*endpoint, controller: CONTROLLER, tries }
                    .of(current()),
            ));
        }
        answers => answers?,
    };
    Ok(answers.accepted()?)
}

fn no_controller() -> Failure {
    Failure::Ended(text::NotAController.str(current()).into())
}
