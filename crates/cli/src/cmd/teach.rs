//! `lafet limits teach`: drives the barrel to its limits and stores them (§3.17).

use std::io::{self, IsTerminal};
use std::time::Duration;

use clap::Args;
use lafet_client::teach::{Side, Taken};
use lafet_client::{Error, Hold, StatusUpdate};
use lafet_proto::SubsystemId;
use lafet_proto::flags::DriveFlags;
use lafet_proto::request::LimitsState;
use lafet_proto::status::Limits;
use lafet_texts::{Shown, Text as _, cli as text};
use ratatui::crossterm::event::{KeyCode, KeyEventKind};
use serde_json::{Value, json};
use tokio::sync::mpsc;

use super::jog::{Hands, Pressed, note, state};
use crate::angle;
use crate::cli::{Global, drive};
use crate::connect::Connection;
use crate::failure::{Failure, Outcome};
use crate::input;
use crate::interrupt::Interrupt;
use crate::keyboard::{Keyboard, Keys};
use crate::lang::current;
use crate::out::Out;
use crate::undo::{Because, States, Undo};

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
    #[arg(value_name = "DRIVE", value_parser = drive)]
    drive: Option<SubsystemId>,
    #[arg(long, value_name = "SIDE", value_parser = side, conflicts_with = "drive")]
    here: Option<Side>,
}

fn side(text: &str) -> Result<Side, String> {
    let names = Side::ALL.map(Side::name).join(", ");
    let found = Side::ALL.into_iter().find(|side| side.name().eq_ignore_ascii_case(text));
    found.ok_or_else(|| text::OneOfNames { names }.of(current()))
}

/// Runs `lafet limits teach`: takes one limit, or guides the user through all of them.
pub async fn run(args: TeachArgs, global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    if let Some(side) = args.here {
        return take_here(side, &connection, out).await;
    }
    let present = connection.monitor.limits_all().await?;
    let mut drives = vec![SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE];
    if let Some(one) = args.drive {
        drives.retain(|drive| *drive == one);
        if drives.is_empty() {
            return Err(Failure::Usage(text::DeployerWithoutLimits.str(current()).into()));
        }
        // Its own refusal says why: the drive is absent, or has limit switches.
        connection.monitor.limits(one).await?;
    }
    drives.retain(|drive| present.iter().any(|(id, _)| id == drive));
    let mut interrupt = Interrupt::catch()?;
    let mut hand = if io::stdin().is_terminal() { Hand::keyboard()? } else { Hand::lines() };
    let mut all = Vec::new();
    for drive in drives {
        let old = present.iter().find(|(id, _)| *id == drive).map(|(_, limits)| *limits);
        let taught = tokio::select! {
            // A signal between two drives keeps the limits of the next one on.
            biased;
            () = interrupt.wait() => Err(Failure::Interrupted),
            taught = teach(drive, &connection, &mut hand, out) => taught,
        };
        match taught {
            Ok(value) => all.push(value),
            Err(failure) => {
                drop(hand);
                return Err(give_up((drive, old), failure, &connection, out, &mut interrupt).await);
            }
        }
    }
    drop(hand);
    if out.json() { out.value(&Value::Array(all)) } else { Ok(()) }
}

/// Takes the position of a drive as one limit. Limits that were off before stay off.
async fn take_here(side: Side, connection: &Connection, out: &mut Out) -> Outcome {
    let drive = side.drive();
    let was_off = are_off(drive, connection).await?;
    // What it cannot report, it refuses to change, and says why.
    let old = connection.monitor.limits(drive).await.ok();
    let mut interrupt = Interrupt::catch()?;
    let taken = tokio::select! {
        biased;
        () = interrupt.wait() => Err(Failure::Interrupted),
        taken = connection.monitor.take_limit(side) => taken.map_err(Failure::from),
    };
    match taken {
        Ok(taken) => out.show(taken_text(&taken), || taken_json(&taken)),
        Err(failure) if was_off => Err(failure),
        Err(failure) => {
            // What was refused and seen to be put back needs no undo: nothing moves because of it.
            let refused = is_refused(&because(&failure));
            if refused && matches!(are_off(drive, connection).await, Ok(false)) {
                return Err(failure);
            }
            Err(give_up((drive, old), failure, connection, out, &mut interrupt).await)
        }
    }
}

/// Whether a drive is without limits.
async fn are_off(drive: SubsystemId, connection: &Connection) -> Result<bool, Error> {
    let flags = States::read(connection, &[drive]).await?.flags(drive);
    Ok(flags & DriveFlags::LIMITLESS.bits() != 0)
}

fn because(failure: &Failure) -> Because {
    match failure {
        Failure::Client(error) if error.is_no_answer() => Because::Lost(error.clone()),
        Failure::Interrupted => Because::Interrupted,
        other => Because::Failed(other.message()),
    }
}

/// The monitor or this computer has refused it, so it is known what became of it.
const fn is_refused(because: &Because) -> bool {
    matches!(because, Because::Failed(_))
}

/// Stops the drive and switches its limits on: it must not keep moving, or stay, without limits. Says which
/// limits apply then.
async fn give_up(
    (drive, old): (SubsystemId, Option<Limits>),
    failure: Failure,
    connection: &Connection,
    out: &mut Out,
    interrupt: &mut Interrupt,
) -> Failure {
    let because = because(&failure);
    // It is reported as it is.
    let refused = is_refused(&because);
    let ended = Undo::teaching(drive).carry_out(connection, out, interrupt, because).await;
    match &ended {
        Failure::BrokenOff(broken) if broken.is_at_rest() => {
            let told = out.say(in_force(drive, old, connection).await);
            told.err().unwrap_or(if refused { failure } else { ended })
        }
        _ => ended,
    }
}

/// The limits that apply, as text: SwitchLimits On may have been executed though its answer was lost.
async fn in_force(drive: SubsystemId, old: Option<Limits>, connection: &Connection) -> String {
    let now = connection.monitor.limits(drive).await;
    match now {
        Ok(now) if old == Some(now) => text::OldLimitsAgain { drive: Shown(drive) }.of(current()),
        Ok(now) => {
            let range = limits_text(drive, now);
            text::NewLimitsAlready { drive: Shown(drive), range }.of(current())
        }
        Err(_) => text::LimitsNotRead { drive: Shown(drive) }.of(current()),
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
    note(out, &text::LimitsAreOff { drive: Shown(drive), range }.of(current()));
    monitor.switch_limits(drive, LimitsState::Off).await?;
    let mut taken = Vec::new();
    for side in Side::ALL.into_iter().filter(|side| side.drive() == drive) {
        let word = side.text().str(current());
        note(out, &text::TeachKeys { drive: Shown(drive), word }.of(current()));
        loop {
            match hand.wait(connection, out).await? {
                Word::Quit => return Err(Failure::Interrupted),
                Word::Skip => break,
                Word::Take => {}
            }
            match monitor.take_limit(side).await {
                Ok(one) => {
                    let at = angle::show(drive, one.position.into());
                    note(out, &format!("{word}: {at}"));
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
    note(out, &text::LimitsAreOn { drive: Shown(drive), range }.of(current()));
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
    let word = taken.side.text().str(current());
    let at = angle::show(drive, taken.position.into());
    let range = limits_text(drive, taken.limits);
    match taken.in_force {
        true => text::LimitTaken { drive: Shown(drive), word, at, range }.of(current()),
        false => text::LimitTakenLater { drive: Shown(drive), word, at }.of(current()),
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
        Self::Lines(input::lines())
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
                match key.event.code {
                    KeyCode::Enter if key.event.kind == KeyEventKind::Press => break Word::Take,
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
