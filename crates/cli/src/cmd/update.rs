//! `lafet update`: new software for a monitor, over its link (ours; docs/update.md).

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use lafet_client::update::{Image, Pace, Stage, UpdateError, Updated, Word};
use lafet_client::{Endpoint, Role};
use lafet_proto::update::{Phase, Report};
use lafet_texts::{Fixed, Shown, Text as _, cli as text};
use lafet_update::Version;
use serde_json::{Value, json};

use super::image;
use crate::cli::Global;
use crate::connect::{Connection, url_of};
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::{Out, columns};
use crate::state;
use crate::word::{Kept, Note, hex, random};

/// Arguments of `lafet update`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 update program.image\n  \
                        lafet -c serial:///dev/ttyUSB0?addr=1 update program.a.image \
                        program.b.image --pace 50\n  \
                        lafet -c tcp://127.0.0.1:10485 update --state")]
pub struct UpdateArgs {
    #[arg(value_name = "IMAGE", num_args = 1..=2, required_unless_present = "state")]
    images: Vec<PathBuf>,
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(1..=100),
          conflicts_with = "state")]
    pace: Option<u8>,
    #[arg(long, conflicts_with = "images")]
    state: bool,
}

/// Runs `lafet update`.
pub async fn run(args: UpdateArgs, global: &Global, out: &mut Out) -> Outcome {
    if args.state {
        let connection = Connection::open(global).await?;
        let report = look(&connection).await?;
        return out.show(state_text(&report), || state_json(&report));
    }
    let images = load(&args.images)?;
    let connection = Connection::open(global).await?;
    let endpoint: Endpoint = url_of(global)?.parse().map_err(lafet_client::Error::from)?;
    let note = Note::new(&state::notes("update")?, &state::monitor(&endpoint));
    let taken = text::UpdateRunsAlready.str(current());
    let _alone = state::occupy(&note.file().with_extension("lock"), taken)?;
    let mut interrupt = Interrupt::catch()?;
    let pace = args.pace.and_then(Pace::new).unwrap_or_else(|| usual_pace(&endpoint));
    let mut far = Far::default();
    let sender = Sender { connection: &connection, images: &images, note: &note, pace };
    let ended = tokio::select! {
        biased;
        () = interrupt.wait() => Err(Failure::Interrupted),
        ended = sender.run(&mut far, out) => ended,
    };
    if matches!(ended, Err(Failure::Interrupted))
        && let Some(text) = far.interrupted()
    {
        out.say(text)?;
    }
    ended
}

/// How much of the time of the line an update takes unless the user says otherwise.
fn usual_pace(endpoint: &Endpoint) -> Pace {
    let line = matches!(endpoint, Endpoint::Serial { .. });
    let shared = line || endpoint.behaviour().role == Role::Active;
    if shared { Pace::SHARED } else { Pace::FULL }
}

/// Reads the images, of which one has to be for the slot that is not running.
fn load(files: &[PathBuf]) -> Result<Vec<Image>, Failure> {
    let mut images = Vec::new();
    for file in files {
        let image = Image::read(&image::read(file)?).map_err(|error| {
            Failure::Usage(format!("{}: {}", file.display(), error.localized(current())))
        })?;
        images.push(image);
    }
    if let [one, other] = images.as_slice() {
        let both = matches!((one.slot(), other.slot()), (Some(1), Some(2)) | (Some(2), Some(1)));
        if !both || one.version() != other.version() || one.board() != other.board() {
            return Err(Failure::Usage(text::UpdateTwoImages.str(current()).into()));
        }
    }
    Ok(images)
}

async fn look(connection: &Connection) -> Result<Report, Failure> {
    connection.monitor.software().await.map_err(|error| failed(UpdateError::from(error)))
}

/// What an update sends, and where it notes its word.
struct Sender<'a> {
    connection: &'a Connection,
    images: &'a [Image],
    note: &'a Note,
    pace: Pace,
}

impl Sender<'_> {
    /// Brings the update to its end, and removes the note when nothing depends on it any more.
    async fn run(&self, far: &mut Far, out: &mut Out) -> Outcome {
        let report = look(self.connection).await?;
        let word = self.word(&report, out)?;
        let monitor = &self.connection.monitor;
        let told = |stage: Stage| far.show(&stage, out);
        let ended = monitor.update(self.images, &word, self.pace, told).await;
        let over = match &ended {
            Ok(_) | Err(UpdateError::AlreadyRunning(_) | UpdateError::WentBack { .. }) => true,
            Err(UpdateError::Changed { back, .. }) => back.is_some(),
            Err(_) => false,
        };
        if over && let Err(error) = self.note.remove() {
            out.warn(&in_file(self.note, error).message());
        }
        match ended {
            Ok(Updated { from, to }) => {
                let (from, to) = (dotted(from), dotted(to));
                let text = match from == to {
                    // It was on trial already: what ran before is not known.
                    true => text::UpdateDoneTrial { to: &to }.of(current()),
                    false => text::UpdateDone { from: &from, to: &to }.of(current()),
                };
                out.show(text, || json!({ "stage": "updated", "from": from, "to": to }))
            }
            // As a command does that was killed before it could say so.
            Err(UpdateError::AlreadyRunning(version)) => {
                let text = UpdateError::AlreadyRunning(version).localized(current());
                out.show(text, || json!({ "stage": "running-already", "to": dotted(version) }))
            }
            Err(error) => {
                let failure = failed(error);
                if failure.exit_code() == 3 && !far.words.is_empty() {
                    out.warn(&text::UpdateGoesOn { far: &far.words }.of(current()));
                }
                Err(failure)
            }
        }
    }

    /// The word: that of the update which goes on, or a new one, which is on the disk then.
    fn word(&self, report: &Report, out: &mut Out) -> Result<Word, Failure> {
        let Report { trial, pending, waits, phase, .. } = *report;
        let goes_to_trial = phase == Phase::COMMITTED || (phase == Phase::VERIFIED && waits);
        let depends = trial || pending || goes_to_trial;
        let file = || Shown(self.note.file().display());
        let ended = |why: String| Err(Failure::Ended(why));
        match self.note.read() {
            Ok(Some(kept)) if self.is_of(&kept) => {
                // A word whose trial has failed was on the line.
                let spent = report.failed && phase == Phase::IDLE && !depends;
                if !spent {
                    return Ok(kept.word);
                }
            }
            Ok(Some(_)) if depends => return ended(text::UpdateOtherImage.str(current()).into()),
            Ok(Some(_)) => {}
            // A trial that nothing confirms and that has nothing to go back to takes another image.
            Ok(None) if depends && (!trial || self.is_running(report)) => {
                return ended(text::UpdateWordElsewhere.str(current()).into());
            }
            Ok(None) => {}
            Err(_) if depends => {
                return ended(text::UpdateNoteUnreadable { file: file() }.of(current()));
            }
            Err(_) => out.warn(&text::UpdateNoteDamaged { file: file() }.of(current())),
        }
        let images = self.images.iter().map(Image::digest).collect();
        let kept = Kept { word: random()?, images };
        self.note.write(&kept).map_err(|error| in_file(self.note, error))?;
        Ok(kept.word)
    }

    /// Whether a note is of one of the images.
    fn is_of(&self, kept: &Kept) -> bool {
        self.images.iter().any(|image| kept.images.contains(&image.digest()))
    }

    /// Whether one of the images is, by its version, what runs.
    fn is_running(&self, report: &Report) -> bool {
        self.images.iter().any(|image| image.version() == report.version)
    }
}

fn in_file(note: &Note, error: std::io::Error) -> Failure {
    Failure::io(note.file().display().to_string(), error)
}

fn failed(error: UpdateError) -> Failure {
    let text = error.localized(current());
    match error {
        UpdateError::Client(error) => Failure::Client(error),
        UpdateError::Silent(_) => Failure::Silent(text),
        UpdateError::NoImage { .. } => Failure::Usage(text),
        _ => Failure::Ended(text),
    }
}

/// How far an update is, as it was shown last.
#[derive(Default)]
struct Far {
    words: String,
    /// Of the data, as a program has been shown it.
    percent: Option<u64>,
    on_trial: bool,
}

impl Far {
    fn show(&mut self, stage: &Stage, out: &mut Out) {
        let words = words(stage);
        let sending = matches!(stage, Stage::Sending { .. });
        self.on_trial = matches!(
            stage,
            Stage::Committed | Stage::Restarting | Stage::OnTrial | Stage::Confirming
        );
        if out.json() {
            let percent = percent(stage);
            if words != self.words && (percent.is_none() || percent != self.percent) {
                // Where the reader is gone, the update goes on.
                let _ = out.value(&stage_json(stage));
            }
            self.percent = percent;
        } else if sending {
            out.seldom(&words);
        } else if words != self.words {
            out.progress(&words);
        }
        self.words = words;
    }

    /// What a user reads who has ended the command; `None` before anything was sent.
    fn interrupted(&self) -> Option<String> {
        let far = &self.words;
        match (far.is_empty(), self.on_trial) {
            (true, _) => None,
            (false, true) => Some(text::UpdateInterruptedTrial { far }.of(current())),
            (false, false) => Some(text::UpdateInterrupted { far }.of(current())),
        }
    }
}

/// Percent of the data that are there.
fn percent(stage: &Stage) -> Option<u64> {
    let Stage::Sending { done, size, .. } = stage else { return None };
    Some(u64::from(*done) * 100 / u64::from(*size).max(1))
}

fn words(stage: &Stage) -> String {
    let percent = percent(stage).unwrap_or_default();
    let fixed = match *stage {
        Stage::Sending { size, left: None, .. } => {
            return text::UpdateSending { percent, size }.of(current());
        }
        Stage::Sending { size, left: Some(left), .. } => {
            let left = minutes(left);
            return text::UpdateSendingLeft { percent, size, left }.of(current());
        }
        Stage::Verifying => text::UpdateVerifying.fixed(),
        Stage::Committed => text::UpdateCommitted.fixed(),
        Stage::Restarting => text::UpdateRestarting.fixed(),
        Stage::OnTrial => text::UpdateOnTrial.fixed(),
        Stage::Confirming => text::UpdateConfirming.fixed(),
        Stage::Confirmed => text::UpdateConfirmed.fixed(),
    };
    fixed.str(current()).to_owned()
}

/// `3:05`: minutes and seconds.
fn minutes(time: Duration) -> String {
    let seconds = time.as_secs();
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

fn stage_json(stage: &Stage) -> Value {
    match *stage {
        Stage::Sending { done, size, left } => {
            let left = left.map(|left| left.as_secs());
            json!({ "stage": "sending", "done": done, "size": size, "left_s": left })
        }
        Stage::Verifying => json!({ "stage": "verifying" }),
        Stage::Committed => json!({ "stage": "committed" }),
        Stage::Restarting => json!({ "stage": "restarting" }),
        Stage::OnTrial => json!({ "stage": "on-trial" }),
        Stage::Confirming => json!({ "stage": "confirming" }),
        Stage::Confirmed => json!({ "stage": "confirmed" }),
    }
}

/// `1.2.0.7`
fn dotted(version: [u16; 4]) -> String {
    Version(version).to_string()
}

/// A report in words.
fn state_text(report: &Report) -> String {
    let words = |text: Fixed| text.str(current()).to_owned();
    let Report { received: done, size, reason: n, .. } = *report;
    let running = match report.trial {
        true => text::UpdateIsOnTrial.fixed(),
        false => text::UpdateInService.fixed(),
    };
    let phase = match report.phase {
        Phase::IDLE => words(text::UpdatePhaseIdle.fixed()),
        Phase::RECEIVING => text::UpdatePhaseReceiving { done, size }.of(current()),
        Phase::VERIFYING => text::UpdatePhaseVerifying { size }.of(current()),
        Phase::VERIFIED => words(text::UpdatePhaseVerified.fixed()),
        Phase::COMMITTED => words(text::UpdatePhaseCommitted.fixed()),
        Phase(n) => text::UpdatePhaseUnknown { n }.of(current()),
    };
    let order = match n {
        _ if report.waits => words(text::UpdateOrderWaits.fixed()),
        0 => words(text::UpdateOrderDone.fixed()),
        n => text::UpdateOrderRefused { n, why: why(n) }.of(current()),
    };
    let mut rows = vec![
        (text::UpdateRowVersion.fixed(), dotted(report.version)),
        (text::UpdateRowSlot.fixed(), slot(report).to_owned()),
        (text::UpdateRowRunning.fixed(), words(running)),
        (text::UpdateRowPhase.fixed(), phase),
        (text::UpdateRowOrder.fixed(), order),
    ];
    if report.failed {
        rows.push((text::UpdateRowTrial.fixed(), words(text::UpdateTrialFailed.fixed())));
    }
    if report.pending {
        rows.push((text::UpdateRowPending.fixed(), words(text::UpdateCommitPending.fixed())));
    }
    let rows: Vec<Vec<String>> =
        rows.into_iter().map(|(title, value)| vec![words(title), value]).collect();
    columns(&rows)
}

/// Why the last order was not carried out.
fn why(reason: u8) -> String {
    UpdateError::Refused(reason).localized(current())
}

/// The slot that is running.
const fn slot(report: &Report) -> &'static str {
    match report.slot {
        1 => "A",
        2 => "B",
        _ => "?",
    }
}

fn state_json(report: &Report) -> Value {
    let phase = match report.phase {
        Phase::IDLE => "idle",
        Phase::RECEIVING => "receiving",
        Phase::VERIFYING => "verifying",
        Phase::VERIFIED => "verified",
        Phase::COMMITTED => "committed",
        _ => "unknown",
    };
    json!({
        "version": dotted(report.version),
        "slot": slot(report),
        "on_trial": report.trial,
        "last_trial_failed": report.failed,
        "order_waits": report.waits,
        "commit_pending": report.pending,
        "phase": phase,
        "received": report.received,
        "size": report.size,
        "image": hex(&report.image),
        "reason": report.reason,
        "why": (report.reason != 0).then(|| why(report.reason)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_and_the_share() {
        assert_eq!(minutes(Duration::from_millis(185_900)), "3:05");
        let sending = |done, size| Stage::Sending { done, size, left: None };
        assert_eq!(percent(&sending(0, 0)), Some(0));
        assert_eq!(percent(&sending(u32::MAX, u32::MAX)), Some(100));
        assert_eq!(percent(&Stage::Verifying), None);
        for (url, share) in [
            ("tcp://127.0.0.1:10485", Pace::FULL),
            ("serial:///dev/ttyUSB0?addr=1", Pace::SHARED),
            ("tcp://127.0.0.1:10485?role=active&src=130", Pace::SHARED),
        ] {
            assert_eq!(usual_pace(&url.parse().unwrap()), share, "{url}");
        }
    }

    /// Every state of a report has words, whatever the monitor says.
    #[test]
    fn any_report_is_shown() {
        for bits in 0..=u8::MAX {
            let report = Report {
                phase: Phase(bits % 7),
                slot: bits,
                trial: bits & 1 != 0,
                failed: bits & 2 != 0,
                waits: bits & 4 != 0,
                pending: bits & 8 != 0,
                reason: bits,
                ..Report::default()
            };
            let text = state_text(&report);
            assert!(text.lines().all(|line| line.contains("  ")), "{text}");
            assert_eq!(state_json(&report)["reason"], bits);
        }
    }
}
