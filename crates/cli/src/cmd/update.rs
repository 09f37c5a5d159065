//! `lafet update`: new software for a monitor, over its link (ours; docs/update.md).

mod all;
mod course;
mod site;

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use lafet_client::Endpoint;
use lafet_client::update::{
    Before, Choice, Image, Kept, Note, PROVEN, Pace, Stage, Trial, UpdateError, Updated, Wordless,
    are_a_set, choose, hex, is_of_others, is_over,
};
use lafet_proto::update::{Phase, Report};
use lafet_texts::{Fixed, Shown, Text as _, cli as text};
use lafet_update::Version;
use serde_json::{Value, json};
use tokio::sync::Mutex;

use super::image;
use crate::cli::{Global, TIMEOUT_S};
use crate::connect::{Connection, giving_way_for_long, url_of};
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::{Out, columns};
use crate::state;
use crate::word::random;

/// Arguments of `lafet update`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 update program.image\n  \
                        lafet -c serial:///dev/ttyUSB0?addr=1 update program.a.image \
                        program.b.image --pace 50\n  \
                        lafet -c tcp://127.0.0.1:10485 update --state\n  \
                        lafet update program.image --all /etc/lafet/hub.toml --only M1 --only M2")]
pub struct UpdateArgs {
    #[arg(value_name = "IMAGE", num_args = 1..=2, required_unless_present = "state")]
    images: Vec<PathBuf>,
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(1..=100),
          conflicts_with = "state")]
    pace: Option<u8>,
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(5..=120),
          conflicts_with = "state")]
    watch: Option<u64>,
    #[arg(long, conflicts_with = "images")]
    state: bool,
    #[arg(long, value_name = "FILE", conflicts_with = "state")]
    all: Option<PathBuf>,
    #[arg(long, value_name = "ID", requires = "all")]
    only: Vec<String>,
}

/// Runs `lafet update`.
pub async fn run(args: UpdateArgs, global: &Global, out: &mut Out) -> Outcome {
    if args.state {
        let connection = Connection::open(global).await?;
        let report = look(&connection).await?;
        return out.show(state_text(&report), || state_json(&report));
    }
    if let Some(file) = &args.all {
        return all::run(&args, file, global, out).await;
    }
    let images = load(&args.images)?;
    let global = &patient(global);
    let url = url_of(global)?;
    let endpoint: Endpoint = url.parse().map_err(lafet_client::Error::from)?;
    let note = Note::new(&state::notes("update")?, &state::monitor(&endpoint));
    let taken = text::UpdateRunsAlready.str(current());
    let _alone = state::occupy(&note.file().with_extension("lock"), taken)?;
    let mut interrupt = Interrupt::catch()?;
    let pace = args.pace.and_then(Pace::new).unwrap_or_else(|| Pace::usual(&endpoint));
    // A terminal that is held must not hold what is on trial.
    let mut aside = out.aside().ok();
    let out = aside.as_mut().unwrap_or(out);
    let shown = Mutex::new((Far::default(), out));
    let attempt = || async {
        let mut shown = shown.lock().await;
        let (far, out) = &mut *shown;
        let connection = Connection::open(global).await?;
        let (images, proven) = (images.as_slice(), args.proven());
        let sender = Sender { connection: &connection, images, note: &note, pace, proven };
        sender.run(far, out).await
    };
    let wait = Duration::from_secs_f64(global.timeout);
    // What is dropped goes on where it was: Stop for another monitor of the line does not wait for it. The shell
    // keeps its port.
    let work = async {
        match global.open.is_some() {
            true => attempt().await,
            false => giving_way_for_long(url, &endpoint, wait, attempt).await.and_then(|it| it),
        }
    };
    let ended = tokio::select! {
        biased;
        () = interrupt.wait() => Err(Failure::Interrupted),
        ended = work => ended,
    };
    let (far, out) = shown.into_inner();
    if matches!(ended, Err(Failure::Interrupted))
        && let Some(text) = far.interrupted()
    {
        out.say(text)?;
    }
    ended
}

/// An answer may take so long by radio: of all that is asked here, nothing is urgent.
const BY_RADIO_S: f64 = 3.0;

/// The same with more time for an answer, unless the user has said how much.
fn patient(global: &Global) -> Global {
    let usual = (global.timeout - TIMEOUT_S).abs() < f64::EPSILON;
    let timeout = if usual { BY_RADIO_S } else { global.timeout };
    Global { timeout, ..global.clone() }
}

impl UpdateArgs {
    /// How long the image has to be as the monitor was before.
    fn proven(&self) -> Duration {
        self.watch.map_or(PROVEN, Duration::from_secs)
    }
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
    match are_a_set(&images) {
        true => Ok(images),
        false => Err(Failure::Usage(text::UpdateTwoImages.str(current()).into())),
    }
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
    /// How long an image has to be as the monitor was before.
    proven: Duration,
}

impl Sender<'_> {
    /// Brings the update to its end, and removes the note when nothing depends on it any more.
    async fn bring(
        &self,
        far: &mut Far,
        out: &mut Out,
    ) -> Result<Result<Updated, UpdateError>, Failure> {
        let report = look(self.connection).await?;
        let (kept, fresh) = self.word(&report, out)?;
        let monitor = &self.connection.monitor;
        let told = |stage: Stage| far.show(&stage, out);
        let keep = |before: &Before| {
            let noted = self.note.write(&Kept { before: Some(before.clone()), ..kept.clone() });
            let file = self.note.file().display();
            noted.map_err(|error| io::Error::new(error.kind(), format!("{file}: {error}")))
        };
        let trial = Trial {
            word: &kept.word,
            fresh,
            before: kept.before.as_ref(),
            keep: &keep,
            proven: self.proven,
            pace: self.pace,
        };
        let ended = monitor.update_with(self.images, &trial, told).await;
        // It is on trial, and has something to go back to.
        let elsewhere = fresh && is_of_others(&report, &ended);
        if (is_over(&ended) || elsewhere)
            && let Err(error) = self.note.remove()
        {
            out.warn(&in_file(self.note, error).message());
        }
        if elsewhere {
            return Err(Failure::Ended(wordless(Wordless::Elsewhere, self.note)));
        }
        Ok(ended)
    }

    async fn run(&self, far: &mut Far, out: &mut Out) -> Outcome {
        match self.bring(far, out).await? {
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
                    let far_words = &far.words;
                    out.warn(&match far.on_trial {
                        true => text::UpdateInterruptedTrial { far: far_words }.of(current()),
                        false => text::UpdateGoesOn { far: far_words }.of(current()),
                    });
                }
                Err(failure)
            }
        }
    }

    /// The word, with what is noted beside it: that of the update which goes on, or a new one, which is on the disk
    /// then. Whether it is new.
    fn word(&self, report: &Report, out: &mut Out) -> Result<(Kept, bool), Failure> {
        let file = || Shown(self.note.file().display());
        let noted = self.note.read();
        let choice = choose(report, self.images, &noted)
            .map_err(|why| Failure::Ended(wordless(why, self.note)))?;
        match choice {
            Choice::Noted(word) => {
                let kept = noted.ok().flatten();
                let images = self.images.iter().map(Image::digest).collect();
                return Ok((kept.unwrap_or(Kept { word, images, before: None }), false));
            }
            Choice::New { damaged: false } => {}
            Choice::New { damaged: true } => {
                out.warn(&text::UpdateNoteDamaged { file: file() }.of(current()));
            }
        }
        let images = self.images.iter().map(Image::digest).collect();
        let kept = Kept { word: random()?, images, before: None };
        self.note.write(&kept).map_err(|error| in_file(self.note, error))?;
        Ok((kept, true))
    }
}

/// Why nothing here confirms what a monitor has committed or on trial.
fn wordless(why: Wordless, note: &Note) -> String {
    let file = Shown(note.file().display());
    match why {
        Wordless::OtherImage => text::UpdateOtherImage.str(current()).into(),
        Wordless::Elsewhere => text::UpdateWordElsewhere.str(current()).into(),
        Wordless::Unreadable => text::UpdateNoteUnreadable { file }.of(current()),
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
    /// Of which monitor, where there are several.
    of: Option<String>,
    words: String,
    /// Of the data, as a program has been shown it.
    percent: Option<u64>,
    on_trial: bool,
}

impl Far {
    fn of(monitor: &str) -> Self {
        Self { of: Some(monitor.to_owned()), ..Self::default() }
    }

    fn show(&mut self, stage: &Stage, out: &mut Out) {
        let words = words(stage);
        let sending = matches!(stage, Stage::Sending { .. });
        self.on_trial = stage.is_trial();
        if out.json() {
            let percent = percent(stage);
            if words != self.words && (percent.is_none() || percent != self.percent) {
                // Where the reader is gone, the update goes on.
                let mut json = stage_json(stage);
                if let Some(monitor) = &self.of {
                    json["monitor"] = json!(monitor);
                    json["state"] = json!("updating");
                }
                let _ = out.value(&json);
            }
            self.percent = percent;
        } else if sending {
            out.seldom(self.shown(&words));
        } else if words != self.words {
            out.progress(self.shown(&words));
        }
        self.words = words;
    }

    fn shown(&self, words: &str) -> String {
        match &self.of {
            Some(monitor) => format!("{monitor}: {words}"),
            None => words.to_owned(),
        }
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
        Stage::Committing => text::UpdateCommitting.fixed(),
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
        Stage::Committing => json!({ "stage": "committing" }),
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
    let order = match report.reason {
        _ if report.waits => words(text::UpdateOrderWaits.fixed()),
        0 => words(text::UpdateOrderDone.fixed()),
        n => text::UpdateOrderRefused { n, why: why(n) }.of(current()),
    };
    let mut rows = vec![
        (text::UpdateRowVersion.fixed(), dotted(report.version)),
        (text::UpdateRowSlot.fixed(), slot(report).to_owned()),
        (text::UpdateRowRunning.fixed(), running(report).to_owned()),
        (text::UpdateRowPhase.fixed(), phase(report)),
        (text::UpdateRowImage.fixed(), digest(report)),
        (text::UpdateRowOrder.fixed(), order),
    ];
    if report.failed {
        rows.push((text::UpdateRowTrial.fixed(), words(text::UpdateTrialFailed.fixed())));
    }
    if report.pending {
        rows.push((text::UpdateRowPending.fixed(), words(text::UpdateCommitPending.fixed())));
    }
    if report.lost {
        rows.push((text::UpdateRowLost.fixed(), words(text::UpdateConfirmedLost.fixed())));
    }
    let rows: Vec<Vec<String>> =
        rows.into_iter().map(|(title, value)| vec![words(title), value]).collect();
    columns(&rows)
}

/// Whether what runs is on trial, in words.
fn running(report: &Report) -> &'static str {
    match report.trial {
        true => text::UpdateIsOnTrial.str(current()),
        false => text::UpdateInService.str(current()),
    }
}

/// How far an update is, in words.
fn phase(report: &Report) -> String {
    let Report { received: done, size, .. } = *report;
    match report.phase {
        Phase::IDLE => text::UpdatePhaseIdle.str(current()).to_owned(),
        Phase::RECEIVING => text::UpdatePhaseReceiving { done, size }.of(current()),
        Phase::VERIFYING => text::UpdatePhaseVerifying { size }.of(current()),
        Phase::VERIFIED => text::UpdatePhaseVerified.str(current()).to_owned(),
        Phase::COMMITTED => text::UpdatePhaseCommitted.str(current()).to_owned(),
        Phase(n) => text::UpdatePhaseUnknown { n }.of(current()),
    }
}

/// The beginning of the SHA-256 of what is running or received, as `lafet image show` has the whole of it.
fn digest(report: &Report) -> String {
    let hash = &hex(&report.image);
    match report.phase {
        Phase::IDLE => text::UpdateDigestRunning { hash }.of(current()),
        _ => text::UpdateDigestReceived { hash }.of(current()),
    }
}

/// The same for programs.
const fn phase_name(report: &Report) -> &'static str {
    match report.phase {
        Phase::IDLE => "idle",
        Phase::RECEIVING => "receiving",
        Phase::VERIFYING => "verifying",
        Phase::VERIFIED => "verified",
        Phase::COMMITTED => "committed",
        _ => "unknown",
    }
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
    json!({
        "version": dotted(report.version),
        "slot": slot(report),
        "on_trial": report.trial,
        "last_trial_failed": report.failed,
        "order_waits": report.waits,
        "commit_pending": report.pending,
        "confirmed_lost": report.lost,
        "phase": phase_name(report),
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
            assert_eq!(Pace::usual(&url.parse().unwrap()), share, "{url}");
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
                lost: bits & 16 != 0,
                reason: bits,
                ..Report::default()
            };
            let text = state_text(&report);
            assert!(text.lines().all(|line| line.contains("  ")), "{text}");
            assert_eq!(state_json(&report)["reason"], bits);
        }
    }
}
