//! `lafet jog`: moves the barrel while an arrow key is held.
//!
//! A terminal shows that a key is held by repeating it, so each repetition renews the motion's
//! lease. Some terminals also report the release of a key; then the drive stops at once.

use std::collections::HashMap;
use std::io::{self, IsTerminal, Write};
use std::pin::pin;
use std::time::Duration;

use clap::Args;
use lafet_client::{Error, Hold, Jog, JogEnd, Monitor, MonitorStatus, StatusUpdate, Toward};
use lafet_proto::SubsystemId;
use lafet_proto::flags::DriveFlags;
use lafet_texts::{Shown, Text as _, cli as text};
use ratatui::crossterm::event::{KeyCode, KeyEventKind, KeyModifiers};
use serde_json::json;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep};

use crate::angle;
use crate::cli::{Global, seconds};
use crate::connect::Connection;
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::keyboard::{Key, Keyboard, Keys};
use crate::lang::current;
use crate::out::Out;
use crate::undo::REACH;

/// A drive that takes longer than this to come to rest after a release gets a message.
const SLOW: Duration = Duration::from_secs(2);
/// Stops under way at a time: more of them say nothing new.
const STOPS_MAX: usize = 8;
/// Interval at which the state is shown.
const SHOW: Duration = Duration::from_millis(250);
/// A refused motion is not requested again sooner than this, however often the key repeats.
const AGAIN: Duration = Duration::from_secs(1);
/// The lease after the first press where the terminal reports releases: keyboards wait up to this
/// long before they repeat.
const FIRST: Duration = Duration::from_millis(800);

/// Arguments of `lafet jog`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 jog\n  \
                        lafet -c tcp://127.0.0.1:10485 jog --first 0.7")]
pub struct JogArgs {
    #[arg(long, value_name = "SECONDS", default_value_t = 0.3, value_parser = lease)]
    lease: f64,
    #[arg(long, value_name = "SECONDS", value_parser = lease)]
    first: Option<f64>,
}

fn lease(text: &str) -> Result<f64, String> {
    match seconds(text, 0.05)? {
        lease if lease <= 2.0 => Ok(lease),
        _ => Err(text::LeaseExpected.str(current()).into()),
    }
}

/// Moves drives while keys are held, until q or Ctrl-C.
pub async fn run(args: JogArgs, global: &Global, out: &mut Out) -> Outcome {
    if !io::stdin().is_terminal() {
        return Err(Failure::Usage(text::JogNeedsKeyboard.str(current()).into()));
    }
    let connection = Connection::open(global).await?;
    let mut interrupt = Interrupt::catch()?;
    // The monitor has to answer before a motion can begin.
    connection.monitor.status_all().await?;
    let mut watch = connection.monitor.watch(SHOW)?;
    let keyboard = Keyboard::start()?;
    let lease = Duration::from_secs_f64(args.lease);
    let usual = if keyboard.tells_release { FIRST } else { lease };
    let first_lease = args.first.map_or(usual, Duration::from_secs_f64);
    let hold = Hold { lease, first_lease, ..Hold::default() };
    let mut hands = Hands::new(connection.monitor.clone(), hold);
    let mut keys = Keys::listen();
    let (mut stops, mut unanswered) = (JoinSet::new(), None);
    note(out, help());
    loop {
        let mut shown = None;
        let notice = tokio::select! {
            () = interrupt.wait() => break,
            key = keys.next() => match key.map(|key| hands.key(key)) {
                None | Some(Pressed::End) => break,
                Some(Pressed::Nothing) => None,
                Some(Pressed::Ended(text)) => Some(text),
                // Keys are heard until it is answered.
                Some(Pressed::Stop) => {
                    if stops.len() < STOPS_MAX {
                        stops.spawn(stop_all(connection.monitor.clone()));
                    }
                    None
                }
                Some(Pressed::StopAndEnd) => {
                    stops.spawn(stop_all(connection.monitor.clone()));
                    break;
                }
            },
            Some(stopped) = next_of(&mut stops, &mut unanswered) => Some(stopped),
            update = watch.next() => match update {
                StatusUpdate::Value(sample) => {
                    shown = Some(state(&sample.status));
                    None
                }
                StatusUpdate::Stale(error) => Some(error.localized(current())),
                _ => None,
            },
        };
        let ended = hands.ended().await;
        for text in notice.into_iter().chain(ended) {
            note(out, &text);
        }
        if let Some(state) = shown {
            out.progress(state);
        }
    }
    let ends = let_go(hands, &mut keys, &mut interrupt, out).await;
    see_through(&mut stops, &mut unanswered, out).await;
    drop(keys);
    drop(keyboard);
    match unanswered {
        Some(text) => Err(Failure::NotAtRest(text)),
        None => report(&ends?, out),
    }
}

/// Waits for the Stops that are under way; each has the time limits of a Stop.
async fn see_through(
    stops: &mut JoinSet<(String, bool)>,
    unanswered: &mut Option<String>,
    out: &mut Out,
) {
    while let Some(stopped) = next_of(stops, unanswered).await {
        note(out, &stopped);
    }
}

/// What has become of the next Stop; `None`: there is none under way. Notes whether it was answered.
async fn next_of(
    stops: &mut JoinSet<(String, bool)>,
    unanswered: &mut Option<String>,
) -> Option<String> {
    let stopped = stops.join_next().await?;
    let (text, answered) = stopped.unwrap_or_else(|error| (error.to_string(), false));
    *unanswered = (!answered).then(|| text.clone());
    Some(text)
}

/// How what was held has ended.
fn report(ends: &[(SubsystemId, JogEnd)], out: &mut Out) -> Outcome {
    let unknown = |end: &JogEnd| matches!(end, JogEnd::Unknown(_) | JogEnd::StillMoving(_));
    if ends.iter().any(|(_, end)| unknown(end)) {
        let texts: Vec<String> = ends.iter().map(|(drive, end)| tell(*drive, end)).collect();
        return Err(Failure::NotAtRest(texts.join("\n")));
    }
    let all_stand = ends.iter().all(|(_, end)| stands(end));
    let texts: Vec<String> = ends.iter().map(|(drive, end)| tell(*drive, end)).collect();
    let stopped = text::AllMotionsEnded.str(current());
    let text = if texts.is_empty() { stopped.to_owned() } else { texts.join("\n") };
    match all_stand {
        true => out.show(&text, || json!({ "ended": texts })),
        false => Err(Failure::Ended(text)),
    }
}

/// Waits until all drives that were held are at rest; over a cut line, for [`REACH`] at most.
async fn let_go(
    hands: Hands,
    keys: &mut Keys,
    interrupt: &mut Interrupt,
    out: &mut Out,
) -> Result<Vec<(SubsystemId, JogEnd)>, Failure> {
    let drives: Vec<String> = hands.held.keys().map(ToString::to_string).collect();
    let drives = drives.join(", ");
    let mut release = pin!(hands.release());
    let (mut slow, mut end) = (pin!(sleep(SLOW)), pin!(sleep(REACH)));
    let since = Some(Instant::now());
    let mut told = false;
    loop {
        tokio::select! {
            ends = &mut release => return Ok(ends),
            () = &mut slow, if !told => {
                told = true;
                note(out, &stopping(&drives));
            }
            () = &mut end => break,
            () = interrupt.give_up(since) => break,
            key = keys.next() => match key {
                Some(key) if key.event.modifiers.contains(KeyModifiers::CONTROL) && told => break,
                Some(_) => {}
                // No key can arrive any more: Stop is repeated until the deadline.
                None => sleep(SLOW).await,
            },
        }
    }
    Err(Failure::NotAtRest(text::DrivesNotSeenAtRest { drives }.of(current())))
}

fn stopping(drives: &str) -> String {
    let seconds = REACH.as_secs();
    text::DrivesStopNotAnswered { drives, seconds }.of(current())
}

/// Sends Stop All; returns the outcome as a text for the user, and whether it was answered.
async fn stop_all(monitor: Monitor) -> (String, bool) {
    match monitor.stop(SubsystemId::ALL).await {
        Ok(_) => ("Stop All".into(), true),
        Err(error) => (error.localized(current()), false),
    }
}

/// Drives in motion: for each, the direction of its key and the motion.
pub struct Hands {
    monitor: Monitor,
    hold: Hold,
    held: HashMap<SubsystemId, (Toward, Jog)>,
    /// Refused motions, with the time of the refusal.
    refused: HashMap<(SubsystemId, Toward), Instant>,
}

/// What a key press leads to.
pub enum Pressed {
    /// Nothing to report.
    Nothing,
    /// A motion ended or could not begin; the text says why.
    Ended(String),
    /// Send Stop All.
    Stop,
    /// Send Stop All and end: Ctrl-C during a motion.
    StopAndEnd,
    /// End.
    End,
}

impl Hands {
    /// No drive in motion yet.
    pub fn new(monitor: Monitor, hold: Hold) -> Self {
        Self { monitor, hold, held: HashMap::new(), refused: HashMap::new() }
    }

    /// Starts, renews or ends motions for a key event. A key that was pressed too long ago moves nothing: the hand
    /// may have gone since.
    pub fn key(&mut self, Key { event: key, at }: Key) -> Pressed {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        let let_go = key.kind == KeyEventKind::Release;
        let (drive, toward) = match key.code {
            KeyCode::Up => (SubsystemId::VERTICAL, Toward::UP),
            KeyCode::Down => (SubsystemId::VERTICAL, Toward::DOWN),
            KeyCode::Left => (SubsystemId::HORIZONTAL, Toward::LEFT),
            KeyCode::Right => (SubsystemId::HORIZONTAL, Toward::RIGHT),
            KeyCode::Char('+' | '=') => (SubsystemId::NOZZLE, Toward::NARROW),
            KeyCode::Char('-') => (SubsystemId::NOZZLE, Toward::WIDE),
            _ if let_go => return Pressed::Nothing,
            KeyCode::Char(' ') => {
                self.held.clear();
                return Pressed::Stop;
            }
            KeyCode::Esc | KeyCode::Char('q') => return Pressed::End,
            KeyCode::Char('c' | 'с') if control => {
                let moves = !self.held.is_empty();
                self.held.clear();
                return if moves { Pressed::StopAndEnd } else { Pressed::End };
            }
            KeyCode::Char('d') if control => return Pressed::End,
            // Any other key ends all motions.
            _ => {
                self.held.clear();
                return Pressed::Nothing;
            }
        };
        if let_go {
            self.held.retain(|id, (way, _)| (*id, *way) != (drive, toward));
            return Pressed::Nothing;
        }
        if at.elapsed() > self.hold.lease {
            return Pressed::Nothing;
        }
        self.press(drive, toward)
    }

    fn press(&mut self, drive: SubsystemId, toward: Toward) -> Pressed {
        if let Some((way, jog)) = self.held.get(&drive)
            && *way == toward
            && jog.renew()
        {
            return Pressed::Nothing;
        }
        let refused = self.refused.get(&(drive, toward));
        if refused.is_some_and(|refused| refused.elapsed() < AGAIN) {
            return Pressed::Nothing;
        }
        let handle = match drive {
            SubsystemId::VERTICAL => self.monitor.vertical(),
            SubsystemId::HORIZONTAL => self.monitor.horizontal(),
            _ => self.monitor.nozzle(),
        };
        match handle.jog_with(toward, self.hold) {
            Ok(jog) => {
                // Dropping the previous motion releases it; the monitor already has the new one.
                self.held.insert(drive, (toward, jog));
                Pressed::Nothing
            }
            Err(error) => Pressed::Ended(error.localized(current())),
        }
    }

    /// Reports a motion that ended for a reason the operator should know.
    pub async fn ended(&mut self) -> Option<String> {
        let over = self.held.iter().find(|(_, (_, jog))| !jog.is_held()).map(|(id, _)| *id)?;
        let (toward, jog) = self.held.get_mut(&over)?;
        let toward = *toward;
        // A motion that is being stopped continues to do so by itself.
        let end = tokio::time::timeout(Duration::ZERO, jog.ended()).await.ok()?;
        self.held.remove(&over);
        match end {
            JogEnd::Stopped { .. } | JogEnd::Replaced => None,
            end => {
                self.refused.insert((over, toward), Instant::now());
                Some(tell(over, &end))
            }
        }
    }

    /// Releases all motions at once and waits until the drives are at rest.
    pub async fn release(self) -> Vec<(SubsystemId, JogEnd)> {
        let mut ends = JoinSet::new();
        for (drive, (_, jog)) in self.held {
            ends.spawn(async move { (drive, jog.release().await) });
        }
        ends.join_all().await
    }
}

fn stands(end: &JogEnd) -> bool {
    end.stands() || matches!(end, JogEnd::Replaced | JogEnd::TakenOver { .. })
}

fn tell(drive: SubsystemId, end: &JogEnd) -> String {
    match end {
        JogEnd::Stopped { status, .. } | JogEnd::Standing(status) => {
            let at = angle::show(drive, i32::from(status.position));
            text::DriveAtRest { drive: Shown(drive), at }.of(current())
        }
        JogEnd::Refused(error) => error.localized(current()),
        JogEnd::TakenOver { by } => {
            text::DriveTakenOver { drive: Shown(drive), by: Shown(by) }.of(current())
        }
        JogEnd::StillMoving(_) => text::DriveMovesInSpite { drive: Shown(drive) }.of(current()),
        JogEnd::Unbounded(_) => text::DriveNotMoved { drive: Shown(drive) }.of(current()),
        JogEnd::Unknown(error) => {
            let error: &Error = error;
            text::DriveStateUnknown { drive: Shown(drive), error }.of(current())
        }
        _ => drive.to_string(),
    }
}

/// Prints a line that stays on the screen. The terminal is raw, so a line feed alone does not
/// return to the left.
pub fn note(out: &mut Out, text: &str) {
    if io::stderr().is_terminal() && !out.json() {
        // A failure to print must not end a motion.
        let _ = write!(io::stderr(), "\r\x1b[K{text}\r\n");
    } else {
        out.progress(text);
    }
}

fn help() -> &'static str {
    text::JogKeys.str(current())
}

/// Positions of the drives, and which of them move.
pub fn state(status: &MonitorStatus) -> String {
    let drives = [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE];
    let one = |id: SubsystemId| {
        let status = status.drive(id)?;
        let moves = if status.flags.contains(DriveFlags::MOVE) { "*" } else { " " };
        Some(format!("{id} {}{moves}", angle::show(id, i32::from(status.position))))
    };
    let drives: Vec<String> = drives.into_iter().filter_map(one).collect();
    drives.join("  ")
}
