//! `lafet param backup|diff|restore`: a monitor's parameters in a file.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use lafet_client::backup::{Backup, Difference, Restored, Step, Verdict, of_title, title};
use lafet_device::Composition;
use lafet_proto::param::Param;
use lafet_texts::{Shown, Text as _, cli as text};
use serde_json::{Value, json};

use super::param::{saved_text, shown};
use crate::cli::Global;
use crate::connect::Connection;
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::{Out, columns};
use crate::whole::Whole;

/// Arguments of `lafet param backup`.
#[derive(Debug, Args)]
pub struct BackupArgs {
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[arg(long, value_name = "TEXT")]
    firmware: Option<String>,
    #[arg(long)]
    force: bool,
}

/// Arguments of `lafet param diff`.
#[derive(Debug, Args)]
pub struct DiffArgs {
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[arg(value_name = "FILE")]
    other: Option<PathBuf>,
}

/// Arguments of `lafet param restore`.
#[derive(Debug, Args)]
pub struct RestoreArgs {
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[arg(long)]
    dry_run: bool,
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = param)]
    except: Vec<Param>,
    #[arg(long)]
    force: bool,
}

fn param(text: &str) -> Result<Param, String> {
    of_title(text).ok_or_else(|| text::SubsystemAndNameExpected.str(current()).into())
}

/// Runs `lafet param backup`: reads all parameters and writes them to the file.
pub async fn run_backup(args: BackupArgs, global: &Global, out: &mut Out) -> Outcome {
    // An end by a signal removes the file beside as well.
    let mut interrupt = Interrupt::catch()?;
    tokio::select! {
        biased;
        () = interrupt.wait() => Err(Failure::Interrupted),
        ended = back_up(args, global, out) => ended,
    }
}

async fn back_up(args: BackupArgs, global: &Global, out: &mut Out) -> Outcome {
    let to_stdout = args.file.as_os_str() == "-";
    let is_free = || match !to_stdout && !args.force && args.file.exists() {
        true => {
            let name = args.file.display();
            Err(Failure::Usage(text::FileExists { name: Shown(name) }.of(current())))
        }
        false => Ok(()),
    };
    is_free()?;
    // What a link leads to is replaced, not the link.
    let target = fs::canonicalize(&args.file).unwrap_or_else(|_| args.file.clone());
    // Makes sure that the file can be written, before the monitor is asked anything.
    let reserved = match to_stdout {
        true => None,
        false => Some(Whole::beside(&target).map_err(|e| cannot_write(&args.file, e))?),
    };
    let backup = read(&Connection::open(global).await?, args.firmware.clone(), out).await?;
    let text = backup.to_toml();
    let Some(reserved) = reserved else {
        return out.show(text.trim_end(), || json!({ "toml": text }));
    };
    // Another backup may have been made meanwhile.
    is_free()?;
    let former = fs::metadata(&target).ok();
    reserved.place(text.as_bytes()).map_err(|error| cannot_write(&args.file, error))?;
    if let Some(former) = former {
        let kept = fs::set_permissions(&target, former.permissions());
        kept.map_err(|error| cannot_write(&args.file, error))?;
    }
    let (name, count) = (args.file.display().to_string(), backup.values.len());
    let unread: Vec<String> = backup.unread.iter().map(|(param, _)| title(*param)).collect();
    let mut told = text::ParametersSaved { name: &name, count }.of(current());
    if !unread.is_empty() {
        let list = unread.join(", ");
        told.push_str(&text::ParametersNotSet { list }.of(current()));
    }
    out.show(told, || json!({ "file": name, "parameters": count, "not_set": unread }))
}

async fn read(
    connection: &Connection,
    firmware: Option<String>,
    out: &mut Out,
) -> Result<Backup, Failure> {
    let reading = text::ReadingParameters.str(current());
    let progress =
        |p: lafet_client::Progress| out.progress(format!("{reading} {}/{}", p.done, p.total));
    let mut backup = connection.monitor.backup(progress).await?;
    if !backup.missed.is_empty() {
        let one = |(param, why): &(Param, String)| format!("{} ({why})", title(*param));
        let list = backup.missed.iter().map(one).collect::<Vec<_>>().join(", ");
        return Err(Failure::Ended(text::ParametersMissed { list }.of(current())));
    }
    backup.about.made_by = format!("lafet {}", env!("CARGO_PKG_VERSION"));
    backup.about.firmware = firmware;
    backup.about.profile = profile(&backup).map(str::to_owned);
    Ok(backup)
}

/// Name of our profile with these subsystems and drives, if there is one.
fn profile(backup: &Backup) -> Option<&'static str> {
    let value = |param: Param| backup.get(param).and_then(|values| values.first().copied());
    let chain = value(Param::GeneralChain)?;
    let same = |profile: &&Composition| {
        let drives = [
            Param::VerticalDriveType,
            Param::HorizontalDriveType,
            Param::NozzleDriveType,
            Param::DeployerDriveType,
        ];
        let kinds = drives.iter().zip(profile.drives);
        i32::from(profile.chain.bits()) == chain
            && kinds.into_iter().all(|(param, kind)| value(*param).is_none_or(|v| v == kind as i32))
    };
    Composition::ALL.iter().find(same).map(|profile| profile.name)
}

/// Runs `lafet param diff`: shows the differences, and fails with exit code 1 if there are any.
pub async fn run_diff(args: DiffArgs, global: &Global, out: &mut Out) -> Outcome {
    let here = load(&args.file, out)?;
    let there = match &args.other {
        Some(file) => load(file, out)?,
        None => read(&Connection::open(global).await?, None, out).await?,
    };
    let mut differences = here.differences(&there);
    if args.other.is_none() {
        // Restore leaves alone what the file does not list, so diff does not report it.
        differences.retain(|difference| difference.here.is_some());
    }
    if differences.is_empty() {
        return out.show(text::NoDifferences.str(current()), || json!([]));
    }
    let mut rows = vec![vec![
        text::HeadingParameter.str(current()).to_owned(),
        args.file.display().to_string(),
        args.other.as_ref().map_or_else(
            || text::HeadingMonitor.str(current()).into(),
            |file| file.display().to_string(),
        ),
    ]];
    rows.extend(differences.iter().map(|Difference { param, here, there }| {
        vec![title(*param), value(*param, here.as_deref()), value(*param, there.as_deref())]
    }));
    let json = || {
        let one = |d: &Difference| json!({ "parameter": title(d.param), "file": d.here, "other": d.there });
        differences.iter().map(one).collect()
    };
    out.show(columns(&rows), json)?;
    // Like diff(1): exit code 1 means that there are differences.
    Err(Failure::Ended(String::new()))
}

fn value(param: Param, values: Option<&[i32]>) -> String {
    values.map_or_else(|| "—".into(), |values| shown(Some(param.spec()), values))
}

/// Runs `lafet param restore`: writes what differs from the file.
pub async fn run_restore(args: RestoreArgs, global: &Global, out: &mut Out) -> Outcome {
    let file = load(&args.file, out)?;
    let connection = Connection::open(global).await?;
    let mut interrupt = Interrupt::catch()?;
    let wanted = tokio::select! {
        biased;
        () = interrupt.wait() => return Err(Failure::Interrupted),
        wanted = prepare(&args, &file, &connection, out) => wanted?,
    };
    let Some(wanted) = wanted else { return Ok(()) };
    let journal = Journal::open(&args.file, connection.client.endpoint())?;
    let anyway = journal.unfinished.clone();
    let told = |step: Step| {
        journal.note(step);
        if let Some(text) = progress(step) {
            out.progress(text);
        }
    };
    let restored = tokio::select! {
        restored = connection.monitor.restore(&wanted, &anyway, told) => restored?,
        () = interrupt.wait() => {
            out.say(text::RestoreInterrupted.str(current()))?;
            return Err(Failure::Interrupted);
        }
    };
    let done = restored.iter().all(Restored::is_done);
    if done {
        journal.remove();
    }
    show(&restored, out)?;
    if done {
        return Ok(());
    }
    Err(Failure::Ended(text::RestoreIncomplete.str(current()).into()))
}

/// Values with their parameters.
type Values = Vec<(Param, Vec<i32>)>;

/// What is to be written; `None` after a dry run, which shows it. Nothing is changed.
async fn prepare(
    args: &RestoreArgs,
    file: &Backup,
    connection: &Connection,
    out: &mut Out,
) -> Result<Option<Values>, Failure> {
    let present = connection.monitor.status_all().await?;
    let present: Vec<String> = present.present().map(|who| who.to_string()).collect();
    let (mut wanted, absent) = file.of(&present);
    wanted.retain(|(param, _)| !args.except.contains(param));
    if !absent.is_empty() {
        let absent: Vec<String> = absent.iter().map(|param| title(*param)).collect();
        let absent = absent.join(", ");
        out.say(text::ParametersAbsent { absent }.of(current()))?;
    }
    let objection = match args.force {
        true => None,
        false => objection(file, &present, &wanted, connection).await?,
    };
    if args.dry_run {
        plan(connection, &wanted, out).await?;
    }
    match objection {
        Some(text) => Err(Failure::Usage(text)),
        None => Ok((!args.dry_run).then_some(wanted)),
    }
}

/// Why the file seems to be of another monitor: it would give this one other subsystems, or the address of
/// that one.
async fn objection(
    file: &Backup,
    present: &[String],
    wanted: &[(Param, Vec<i32>)],
    connection: &Connection,
) -> Result<Option<String>, Failure> {
    let is_wanted = |param: Param| wanted.iter().any(|(one, _)| *one == param);
    if file.about.subsystems != present && is_wanted(Param::GeneralChain) {
        return Ok(Some(another_kind(&file.about.subsystems, present)));
    }
    let address = Param::GeneralAddress;
    let Some([theirs]) = file.get(address).filter(|_| is_wanted(address)) else { return Ok(None) };
    let now = connection.monitor.params(&[address]).await.pop();
    Ok(match now {
        Some(Ok(now)) if now != [*theirs] => {
            let (file, monitor) = (*theirs, now.first().copied().unwrap_or_default());
            Some(text::OtherAddress { file, monitor }.of(current()))
        }
        Some(Err(error)) if !error.is_refused() => return Err(error.into()),
        // One that was erased has no address.
        _ => None,
    })
}

fn another_kind(file: &[String], present: &[String]) -> String {
    let (file, present) = (file.join(" "), present.join(" "));
    text::OtherSubsystems { file, present }.of(current())
}

fn progress(step: Step) -> Option<String> {
    Some(match step {
        Step::Plan(0) => return None,
        Step::Plan(count) => text::ParametersDiffer { count }.of(current()),
        Step::Begun(param) => text::WritingParameter { name: title(param) }.of(current()),
        Step::Again(param) => text::RetryingParameter { name: title(param) }.of(current()),
        Step::Stored(_) => return None,
        Step::Verifying => text::ReadingBack.str(current()).into(),
    })
}

async fn plan(connection: &Connection, wanted: &[(Param, Vec<i32>)], out: &mut Out) -> Outcome {
    let params: Vec<Param> = wanted.iter().map(|(param, _)| *param).collect();
    let mut rows = Vec::new();
    let mut all = Vec::new();
    for ((param, wanted), now) in wanted.iter().zip(connection.monitor.params(&params).await) {
        let now = match now {
            Ok(now) => Some(now),
            Err(error) if error.is_refused() => None,
            Err(error) => return Err(error.into()),
        };
        if now.as_ref() != Some(wanted) {
            let to = value(*param, Some(wanted));
            rows.push(vec![title(*param), value(*param, now.as_deref()), "→".into(), to]);
            all.push(json!({ "parameter": title(*param), "before": now, "wanted": wanted }));
        }
    }
    if rows.is_empty() {
        return out.show(nothing(), || json!([]));
    }
    out.show(columns(&rows), || Value::Array(all))
}

fn nothing() -> &'static str {
    text::NothingToWrite.str(current())
}

fn show(restored: &[Restored], out: &mut Out) -> Outcome {
    if restored.is_empty() {
        return out.show(nothing(), || json!({ "written": [], "restart": [] }));
    }
    let mut lines: Vec<Vec<String>> = Vec::new();
    for one in restored {
        let before = value(one.param, one.before.as_deref());
        let wanted = value(one.param, Some(&one.wanted));
        lines.push(vec![title(one.param), before, "→".into(), wanted, verdict(one)]);
    }
    let mut text = columns(&lines);
    let restart: Vec<String> =
        restored.iter().filter(|one| one.needs_restart()).map(|one| title(one.param)).collect();
    if !restart.is_empty() {
        let list = restart.join(", ");
        let restart = text::TakesEffectAfterRestart { list }.of(current());
        text.push_str(&format!("\n{restart}"));
    }
    out.show(text, || {
        let one = |one: &Restored| {
            json!({
                "parameter": title(one.param),
                "before": one.before,
                "wanted": one.wanted,
                "done": one.is_done(),
                "result": match &one.verdict {
                    Verdict::Written(saved) => saved.name().to_owned(),
                    Verdict::Failed(error) => error.localized(current()),
                    Verdict::ReadsBack(values) => format!("reads back as {values:?}"),
                },
            })
        };
        let written: Vec<Value> = restored.iter().map(one).collect();
        json!({ "written": written, "restart": restart })
    })
}

fn verdict(one: &Restored) -> String {
    match &one.verdict {
        Verdict::Written(saved) => saved_text(*saved).into(),
        Verdict::Failed(error) => error.localized(current()),
        Verdict::ReadsBack(values) => {
            let values = value(one.param, Some(values));
            text::ReadsBackAs { values }.of(current())
        }
    }
}

fn load(file: &Path, out: &mut Out) -> Result<Backup, Failure> {
    let name = file.display().to_string();
    let text = fs::read_to_string(file).map_err(|error| Failure::io(name.clone(), error))?;
    let backup = Backup::from_toml(&text)
        .map_err(|error| Failure::Usage(format!("{name}: {}", error.localized(current()))))?;
    if !Backup::has_end(&text) {
        out.warn(&text::FileWithoutEnd { name }.of(current()));
    }
    Ok(backup)
}

fn cannot_write(file: &Path, error: io::Error) -> Failure {
    let name = file.display();
    let what = text::CannotWriteFile { name: Shown(name) }.of(current());
    Failure::io(what, error)
}

fn beside(file: &Path, ending: &str) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(".");
    name.push(ending);
    PathBuf::from(name)
}

/// Progress of restores, kept in a file beside the backup: which writes began and which the
/// monitor reported as stored. A value that was accepted but not stored still reads back as
/// correct. Lines of several monitors, which may be restored from the same backup, stand in any
/// order; a line `monitor URL` precedes those of each.
struct Journal {
    path: PathBuf,
    backup: PathBuf,
    endpoint: String,
    unfinished: Vec<Param>,
}

impl Journal {
    fn open(file: &Path, endpoint: &str) -> Result<Self, Failure> {
        let path = beside(file, "restoring");
        // It can be written, which is made sure of before anything is changed.
        let opened = OpenOptions::new().create(true).append(true).open(&path);
        let text = opened.and_then(|_| fs::read_to_string(&path));
        let text = text.map_err(|error| Failure::io(path.display().to_string(), error))?;
        let unfinished = unfinished(&text, endpoint);
        Ok(Self { path, backup: file.into(), endpoint: endpoint.into(), unfinished })
    }

    fn note(&self, step: Step) {
        let line = match step {
            Step::Begun(param) => format!("started {}", title(param)),
            Step::Stored(param) => format!("stored {}", title(param)),
            _ => return,
        };
        let lines = format!("monitor {}\n{line}\n", self.endpoint);
        let _alone = self.alone();
        // Another restore of this backup, which was complete, may have removed it.
        let file = OpenOptions::new().create(true).append(true).open(&self.path);
        // A restore continues without its journal; only resuming it knows less.
        let _ = file.and_then(|mut file| {
            file.write_all(lines.as_bytes())?;
            file.sync_data()
        });
    }

    /// Keeps restores of other monitors from this backup out of the journal, as long as the file is open.
    /// Other systems than Unix would keep them from reading the backup too.
    fn alone(&self) -> Option<File> {
        let file = File::open(&self.backup).ok().filter(|_| cfg!(unix))?;
        file.lock().ok()?;
        Some(file)
    }

    /// The restore of this monitor is complete: its lines are of no further use.
    fn remove(self) {
        let _alone = self.alone();
        let text = fs::read_to_string(&self.path).unwrap_or_default();
        let others = of_others(&text, &self.endpoint);
        let _ = match others.is_empty() {
            true => fs::remove_file(&self.path),
            false => Whole::beside(&self.path).and_then(|file| file.place(others.as_bytes())),
        };
    }
}

/// The lines of a journal, each with whether it belongs to this monitor.
fn lines<'a>(journal: &'a str, endpoint: &str) -> impl Iterator<Item = (bool, &'a str)> {
    let mut own = false;
    journal.lines().map(move |line| {
        if let Some(name) = line.strip_prefix("monitor ") {
            own = name == endpoint;
        }
        (own, line)
    })
}

fn of_others(journal: &str, endpoint: &str) -> String {
    lines(journal, endpoint).filter(|(own, _)| !own).map(|(_, line)| format!("{line}\n")).collect()
}

/// Parameters whose write to this monitor began but is not known to be stored.
fn unfinished(journal: &str, endpoint: &str) -> Vec<Param> {
    let mut all: Vec<Param> = Vec::new();
    for (_, line) in lines(journal, endpoint).filter(|(own, _)| *own) {
        match line.split_once(' ').and_then(|(word, name)| Some((word, of_title(name)?))) {
            Some(("started", param)) if !all.contains(&param) => all.push(param),
            Some(("stored", param)) => all.retain(|one| *one != param),
            _ => {}
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_journal_lists_what_is_not_known_to_be_stored() {
        let journal = "monitor a\nstarted Vertical.Speed\nstored Vertical.Speed\n\
                       started Nozzle.Speed\nstarted Gene";
        assert_eq!(unfinished(journal, "a"), [Param::NozzleSpeed]);
        assert_eq!(unfinished(journal, "b"), []);
        assert_eq!(unfinished("", "a"), []);
    }

    /// A restore that is complete removes the journal, which another may have opened already.
    #[test]
    fn what_is_noted_outlives_a_journal_that_was_removed() {
        let folder = std::env::temp_dir().join(format!("lafet-journal-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("one.toml");
        fs::write(&file, "").unwrap();
        let (one, two) = (Journal::open(&file, "a").unwrap(), Journal::open(&file, "b").unwrap());
        two.remove();
        assert!(!one.path.exists());
        one.note(Step::Begun(Param::NozzleSpeed));
        assert_eq!(Journal::open(&file, "a").unwrap().unfinished, [Param::NozzleSpeed]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn monitors_restored_from_one_backup_share_its_journal() {
        let journal = "monitor a\nstarted Nozzle.Speed\nmonitor b\nstarted Vertical.Speed\n\
                       monitor a\nstarted Horizontal.Speed\nmonitor b\nstored Vertical.Speed\n";
        assert_eq!(unfinished(journal, "a"), [Param::NozzleSpeed, Param::HorizontalSpeed]);
        assert_eq!(unfinished(journal, "b"), []);
        let others = of_others(journal, "b");
        assert_eq!(unfinished(&others, "a"), unfinished(journal, "a"));
        assert!(!others.contains("Vertical"), "{others}");
        assert_eq!(of_others(&others, "a"), "");
    }
}
