//! `lafet limits teach`: drives the barrel to its limits and stores them (§3.17).

use std::io::{self, IsTerminal};
use std::time::Duration;

use clap::Args;
use lafet_client::teach::{Side, Taken};
use lafet_client::{Hold, StatusUpdate};
use lafet_proto::SubsystemId;
use lafet_proto::request::LimitsState;
use lafet_proto::status::Limits;
use ratatui::crossterm::event::{KeyCode, KeyEventKind};
use serde_json::{Value, json};
use tokio::sync::mpsc;

use super::jog::{Hands, Pressed, note, state};
use crate::angle;
use crate::cli::{Global, drive};
use crate::connect::Connection;
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::keyboard::{Keyboard, Keys};
use crate::lang::{current, of, pick};
use crate::out::Out;
use crate::undo::{Because, Undo};

/// Interval at which the state is shown.
const SHOW: Duration = Duration::from_millis(250);
/// For how long a key moves the drive, as in `lafet jog`.
const LEASE: Duration = Duration::from_millis(300);

/// Arguments of `lafet limits teach`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 limits teach\n  \
                        lafet -c tcp://127.0.0.1:10485 limits teach horizontal\n  \
                        lafet -c tcp://127.0.0.1:10485 limits teach --here left")]
pub struct TeachArgs {
    /// The drive; without it Horizontal, Vertical and Nozzle in turn
    #[arg(value_name = "DRIVE", value_parser = drive)]
    drive: Option<SubsystemId>,
    /// Do not prompt: take the present position as this limit (left, right, up, down, narrow, wide)
    #[arg(long, value_name = "SIDE", value_parser = side, conflicts_with = "drive")]
    here: Option<Side>,
}

fn side(text: &str) -> Result<Side, String> {
    let names = Side::ALL.map(Side::name).join(", ");
    let found = Side::ALL.into_iter().find(|side| side.name().eq_ignore_ascii_case(text));
    found.ok_or_else(|| {
        pick(format!("expected one of {names}"), format!("ожидается одно из: {names}"))
    })
}

/// Runs `lafet limits teach`: takes one limit, or guides the user through all of them.
pub async fn run(args: TeachArgs, global: &Global, out: &mut Out) -> Outcome {
    if let Some(side) = args.here {
        let connection = Connection::open(global).await?;
        let taken = connection.monitor.take_limit(side).await?;
        return out.show(taken_text(&taken), || taken_json(&taken));
    }
    let connection = Connection::open(global).await?;
    let present = connection.monitor.limits_all().await?;
    let mut drives = vec![SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE];
    if let Some(one) = args.drive {
        drives.retain(|drive| *drive == one);
        if drives.is_empty() {
            return Err(Failure::Usage(
                pick(
                    "The end positions of Deployer are set by its switches: it has no limits to \
                     set.",
                    "Крайние положения Deployer определяются его датчиками: задать их нельзя.",
                )
                .into(),
            ));
        }
        // Its own refusal says why: the drive is absent, or has limit switches.
        connection.monitor.limits(one).await?;
    }
    drives.retain(|drive| present.iter().any(|(id, _)| id == drive));
    let mut interrupt = Interrupt::catch()?;
    let mut hand = if io::stdin().is_terminal() { Hand::keyboard()? } else { Hand::lines() };
    let mut all = Vec::new();
    for drive in drives {
        let taught = tokio::select! {
            taught = teach(drive, &connection, &mut hand, out) => taught,
            () = interrupt.wait() => Err(Failure::Interrupted),
        };
        match taught {
            Ok(value) => all.push(value),
            Err(failure) => {
                drop(hand);
                return Err(give_up(drive, failure, &connection, out, &mut interrupt).await);
            }
        }
    }
    drop(hand);
    if out.json() { out.value(&Value::Array(all)) } else { Ok(()) }
}

/// Stops the drive and switches its limits on: it must not keep moving, or stay, without limits.
async fn give_up(
    drive: SubsystemId,
    failure: Failure,
    connection: &Connection,
    out: &mut Out,
    interrupt: &mut Interrupt,
) -> Failure {
    let because = match &failure {
        Failure::Client(error) if !error.is_refused() => Because::Lost(error.clone()),
        _ => Because::Interrupted,
    };
    match Undo::teaching(drive).carry_out(connection, out, interrupt, because).await {
        Failure::BrokenOff(broken) if broken.is_at_rest() => {
            let kept = out.say(pick(
                format!("{drive} keeps its old limits; they are on again."),
                format!("У {drive} прежние пределы; они снова включены."),
            ));
            kept.err().unwrap_or(failure)
        }
        broken => broken,
    }
}

/// Sets the limits of one drive: limits off, each side, limits on.
async fn teach(
    drive: SubsystemId,
    connection: &Connection,
    hand: &mut Hand,
    out: &mut Out,
) -> Result<Value, Failure> {
    let monitor = &connection.monitor;
    let old = monitor.limits(drive).await?;
    let range = limits_text(drive, old);
    note(
        out,
        &pick(
            format!(
                "{drive}: its limits are {range}. They are off now: only the motor's overload \
                 protection stops it at the end of its travel."
            ),
            format!(
                "{drive}: пределы {range}. Теперь они выключены: в конце хода его остановит только \
             перегрузка двигателя."
            ),
        ),
    );
    monitor.switch_limits(drive, LimitsState::Off).await?;
    let mut taken = Vec::new();
    for side in Side::ALL.into_iter().filter(|side| side.drive() == drive) {
        let word = of(&side.text());
        note(
            out,
            &pick(
                format!(
                    "Move {drive} to its {word} limit. Enter takes it, s keeps the old one, q \
                     gives up."
                ),
                format!(
                    "Подведите {drive}: {word} предел. Enter — принять, s — оставить прежний, q — \
                     отказаться."
                ),
            ),
        );
        loop {
            match hand.wait(connection, out).await? {
                Word::Quit => return Err(Failure::Interrupted),
                Word::Skip => break,
                Word::Take => {}
            }
            match monitor.take_limit(side).await {
                Ok(one) => {
                    let at = angle::show(drive, one.position.into());
                    note(out, &pick(format!("{word}: {at}"), format!("{word}: {at}")));
                    taken.push(one);
                    break;
                }
                // The drive most likely still moves: the engineer tries again.
                Err(error) if error.is_refused() => note(out, &error.localized(current())),
                Err(error) => return Err(error.into()),
            }
        }
    }
    monitor.confirm_limits(drive).await?;
    let limits = monitor.limits(drive).await?;
    let range = limits_text(drive, limits);
    note(
        out,
        &pick(
            format!("{drive}: limits are on: {range}."),
            format!("{drive}: пределы включены: {range}."),
        ),
    );
    Ok(json!({
        "drive": drive.to_string(),
        "taken": taken.iter().map(|one| one.side.name()).collect::<Vec<_>>(),
        "before": { "min": old.min, "max": old.max },
        "min": limits.min,
        "max": limits.max,
    }))
}

fn limits_text(drive: SubsystemId, limits: Limits) -> String {
    format!("{} … {}", angle::show(drive, limits.min), angle::show(drive, limits.max))
}

fn taken_text(taken: &Taken) -> String {
    let drive = taken.side.drive();
    let word = of(&taken.side.text());
    let at = angle::show(drive, taken.position.into());
    let range = limits_text(drive, taken.limits);
    match taken.in_force {
        true => pick(
            format!("{drive}: {word} limit {at}. Its limits are {range}."),
            format!("{drive}: {word} предел {at}. Пределы: {range}."),
        ),
        false => pick(
            format!("{drive}: {word} limit {at}, in force after `lafet limits on {drive}`."),
            format!("{drive}: {word} предел {at}, вступит в силу после `lafet limits on {drive}`."),
        ),
    }
}

fn taken_json(taken: &Taken) -> Value {
    json!({
        "drive": taken.side.drive().to_string(),
        "side": taken.side.name(),
        "position": taken.position,
        "in_force": taken.in_force,
        "min": taken.limits.min,
        "max": taken.limits.max,
    })
}

/// The engineer's decision on one limit.
enum Word {
    Take,
    Skip,
    Quit,
}

/// Source of decisions: keys that also move the drives, or lines from a program.
enum Hand {
    Keys { keys: Keys, _keyboard: Keyboard },
    Lines(mpsc::UnboundedReceiver<String>),
}

impl Hand {
    fn keyboard() -> Result<Self, Failure> {
        let keyboard = Keyboard::start()?;
        Ok(Self::Keys { keys: Keys::listen(), _keyboard: keyboard })
    }

    fn lines() -> Self {
        // A thread waits for lines, and ends with the program.
        let (sender, receiver) = mpsc::unbounded_channel();
        std::thread::spawn(move || {
            for line in io::stdin().lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Self::Lines(receiver)
    }

    async fn wait(&mut self, connection: &Connection, out: &mut Out) -> Result<Word, Failure> {
        match self {
            Self::Lines(lines) => Ok(match lines.recv().await.as_deref().map(str::trim) {
                Some("") => Word::Take,
                Some("s") => Word::Skip,
                _ => Word::Quit,
            }),
            Self::Keys { keys, .. } => wait_for_key(keys, connection, out).await,
        }
    }
}

/// Moves the drives with the keys of `lafet jog`, until Enter, s or q.
async fn wait_for_key(
    keys: &mut Keys,
    connection: &Connection,
    out: &mut Out,
) -> Result<Word, Failure> {
    let hold = Hold { lease: LEASE, first_lease: LEASE, ..Hold::default() };
    let mut hands = Hands::new(connection.monitor.clone(), hold);
    let mut watch = connection.monitor.watch(SHOW)?;
    let word = loop {
        tokio::select! {
            key = keys.next() => {
                let Some(key) = key else { break Word::Quit };
                match key.code {
                    KeyCode::Enter if key.kind == KeyEventKind::Press => break Word::Take,
                    KeyCode::Char('s') => break Word::Skip,
                    _ => {}
                }
                match hands.key(key) {
                    Pressed::End => break Word::Quit,
                    Pressed::StopAndEnd => {
                        connection.monitor.stop(SubsystemId::ALL).await?;
                        break Word::Quit;
                    }
                    Pressed::Stop => {
                        connection.monitor.stop(SubsystemId::ALL).await?;
                    }
                    Pressed::Ended(text) => note(out, &text),
                    Pressed::Nothing => {}
                }
            }
            update = watch.next() => match update {
                StatusUpdate::Value(sample) => out.progress(state(&sample.status)),
                StatusUpdate::Stale(error) => note(out, &error.localized(current())),
                _ => {}
            },
        }
        if let Some(text) = hands.ended().await {
            note(out, &text);
        }
    };
    // The drive has to be at rest before its position is taken.
    hands.release().await;
    Ok(word)
}
