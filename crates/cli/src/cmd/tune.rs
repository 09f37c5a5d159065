//! `lafet tune`: measures how a drive answers its motor, and sets StopLag and MinSpeed (ours, §D/9).

use std::io;

use clap::Args;
use lafet_client::Endpoint;
use lafet_client::tune::kept::{self, Kept, Note};
use lafet_client::tune::{self, Bench, Judged, Look, Pair, Trouble, Tuned, Tuning};
use lafet_proto::request::Body;
use lafet_proto::status::Limits;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::{Shown, Text as _, cli as text};
use serde_json::{Value, json};

use super::param::failed_to_save;
use crate::angle;
use crate::cli::{Global, drive};
use crate::connect::{Connection, url_of};
use crate::failure::{Failure, Outcome};
use crate::follow::{Follow, Step};
use crate::interrupt::Interrupt;
use crate::lang::{current, decimals};
use crate::out::{Out, columns};
use crate::state;
use crate::undo::{Because, States, Undo};

/// Arguments of `lafet tune`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet -c tcp://127.0.0.1:10485 tune\n  \
                        lafet -c tcp://127.0.0.1:10485 tune horizontal --dry-run")]
pub struct TuneArgs {
    #[arg(value_name = "DRIVE", value_parser = drive)]
    drive: Option<SubsystemId>,
    #[arg(long)]
    dry_run: bool,
}

/// Runs `lafet tune`: moves each drive with the valves closed, and sets what was measured.
pub async fn run(args: TuneArgs, global: &Global, out: &mut Out) -> Outcome {
    let connection = Connection::open(global).await?;
    if args.drive == Some(SubsystemId::DEPLOYER) {
        return Err(Failure::Usage(text::TuneNotDeployer.str(current()).into()));
    }
    let note = note_of(global)?;
    let taken = text::TuneRunsAlready.str(current());
    let _alone = state::occupy(&note.file().with_extension("lock"), taken)?;
    // One for all motions: what comes between two of them keeps the next from starting.
    let mut interrupt = Interrupt::catch()?;
    recover(&mut Terminal::new(&connection, out, &note, &mut interrupt)).await?;
    let present = connection.monitor.limits_all().await?;
    let wanted = |drive: &SubsystemId| args.drive.is_none_or(|one| one == *drive);
    let mut all = Vec::new();
    for drive in tune::DRIVES.into_iter().filter(wanted) {
        let Some((_, limits)) = present.iter().find(|(id, _)| *id == drive) else {
            if args.drive.is_some() {
                // Its own refusal says why it has no limits.
                connection.monitor.limits(drive).await?;
            }
            continue;
        };
        let mut bench = Terminal::new(&connection, out, &note, &mut interrupt);
        all.push(one(&mut bench, (drive, *limits), args.dry_run).await?);
    }
    out.show(table(&all, args.dry_run), || {
        let drives: Vec<Value> = all.iter().map(shown).collect();
        json!({ "drives": drives, "written": !args.dry_run })
    })
}

/// Tunes one drive; sets the parameters back when it does not come to its end.
async fn one(
    bench: &mut Terminal<'_>,
    (drive, limits): (SubsystemId, Limits),
    dry_run: bool,
) -> Result<Tuned, Failure> {
    let mut tuning = Tuning::new(bench, drive, limits).await?;
    let tuned = tuning.measure(bench).await;
    if (dry_run || tuned.is_err())
        && let Err(failure) = tune::write(bench, drive, tuning.before()).await
    {
        // The note stays: the next tuning puts the values back.
        bench.out.warn(&text::TuneNotPutBack { drive: Shown(drive) }.of(current()));
        return tuned.and(Err(failure));
    }
    bench.note.remove().map_err(|error| in_file(bench.note, error))?;
    tuned
}

/// Puts back what a tuning of this monitor that was killed has left in it, and says so.
async fn recover(bench: &mut Terminal<'_>) -> Result<(), Failure> {
    let note = bench.note;
    let Some(kept) = note.read().map_err(|error| in_file(note, error))? else { return Ok(()) };
    for put in kept::put_back(bench, &kept).await? {
        let kept::PutBack { name, from, to } = put;
        let drive = Shown(kept.drive);
        bench.out.warn(&text::TunePutBack { drive, name, from, to }.of(current()));
    }
    note.remove().map_err(|error| in_file(note, error))
}

/// The note of this monitor.
fn note_of(global: &Global) -> Result<Note, Failure> {
    let endpoint: Endpoint = url_of(global)?.parse().map_err(lafet_client::Error::from)?;
    Ok(Note::new(&state::notes("tune")?, &state::monitor(&endpoint)))
}

fn in_file(note: &Note, error: io::Error) -> Failure {
    Failure::io(note.file().display().to_string(), error)
}

/// The tuning at a terminal: Ctrl-C ends it.
struct Terminal<'a> {
    connection: &'a Connection,
    out: &'a mut Out,
    note: &'a Note,
    interrupt: &'a mut Interrupt,
}

impl<'a> Terminal<'a> {
    const fn new(
        connection: &'a Connection,
        out: &'a mut Out,
        note: &'a Note,
        interrupt: &'a mut Interrupt,
    ) -> Self {
        Self { connection, out, note, interrupt }
    }
}

impl From<Trouble> for Failure {
    fn from(trouble: Trouble) -> Self {
        Self::Ended(trouble.of(current()))
    }
}

impl Bench for Terminal<'_> {
    type Error = Failure;

    async fn param(&mut self, drive: SubsystemId, name: &'static str) -> Result<i32, Failure> {
        let values = self.connection.monitor.param(drive, name).await?;
        Ok(values.first().copied().unwrap_or_default())
    }

    async fn set_param(
        &mut self,
        drive: SubsystemId,
        name: &'static str,
        value: i32,
    ) -> Result<(), Failure> {
        failed_to_save(self.connection.monitor.save_param(drive, name, &[value]).await?)
    }

    async fn keep(&mut self, kept: &Kept) -> Result<(), Failure> {
        self.note.write(kept).map_err(|error| in_file(self.note, error))
    }

    async fn look(&mut self, drive: SubsystemId) -> Result<Look, Failure> {
        let states = States::read(self.connection, &tune::watched(drive)).await?;
        Ok(Look::of(drive, states.all())?)
    }

    async fn follow(
        &mut self,
        drive: SubsystemId,
        request: Request<'static>,
        mut judge: impl FnMut(&Look) -> Judged + Send,
    ) -> Result<Look, Failure> {
        let watch = tune::watched(drive);
        let undo = match request.body {
            Body::Stop => Undo::everything(),
            _ => Undo::of(&request).unwrap_or_default(),
        };
        let follow = Follow { connection: self.connection, watch: &watch, undo };
        let words = |trouble: Trouble| trouble.of(current());
        let mut must_end = None;
        let judge = |states: &States| {
            let look = match Look::of(drive, states.all()) {
                Ok(look) => look,
                Err(trouble) => return Step::Ended(words(trouble)),
            };
            match judge(&look) {
                Judged::Running => Step::Running(progress(drive, look.position, &request)),
                Judged::Idle(trouble) => Step::Idle(words(trouble)),
                Judged::Done => Step::Done,
                Judged::Ended(trouble) => {
                    must_end = Some(trouble);
                    Step::Done
                }
            }
        };
        let start = self.connection.send(&request);
        let states = follow.run_until(self.interrupt, self.out, start, judge).await?;
        if let Some(trouble) = must_end {
            let because = Because::Failed(words(trouble));
            let stop = Undo::everything();
            let ended = stop.carry_out(self.connection, self.out, self.interrupt, because).await;
            return Err(match ended {
                Failure::BrokenOff(broken) if broken.is_at_rest() => trouble.into(),
                moves => moves,
            });
        }
        Ok(Look::of(drive, states.all())?)
    }
}

fn progress(drive: SubsystemId, at: i32, request: &Request<'_>) -> String {
    let at = angle::show(drive, at);
    match request.body {
        Body::Move { destination } => {
            format!("{drive} {at} → {}", angle::show(drive, destination.into()))
        }
        _ => format!("{drive} {at}"),
    }
}

fn table(all: &[Tuned], dry_run: bool) -> String {
    let min_speed = decimals("MinSpeed, ×0.1".to_owned());
    let titles = [text::TunedDrive.fixed(), text::TunedLag.fixed(), text::TunedError.fixed()];
    let [drive, lag, error] = titles.map(|title| title.of(current()));
    let mut rows = vec![vec![drive, lag, min_speed, error]];
    rows.extend(all.iter().map(|tuned| {
        let Tuned { drive, before, found, errors } = tuned;
        let worst = errors.iter().copied().max().unwrap_or_default();
        vec![
            drive.to_string(),
            format!("{} → {}", before.lag_ms, found.lag_ms),
            format!("{} → {}", before.min_tenths, found.min_tenths),
            angle::show(*drive, worst),
        ]
    }));
    let end = match dry_run {
        true => text::NothingWritten.str(current()),
        false => text::WrittenToMonitor.str(current()),
    };
    format!("{}\n{end}", columns(&rows))
}

fn shown(tuned: &Tuned) -> Value {
    let pair = |pair: Pair| json!({ "StopLag": pair.lag_ms, "MinSpeed": pair.min_tenths });
    json!({
        "drive": tuned.drive.to_string(),
        "before": pair(tuned.before),
        "found": pair(tuned.found),
        "errors": tuned.errors,
    })
}
