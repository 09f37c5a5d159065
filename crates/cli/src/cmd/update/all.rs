//! `lafet update --all`: the monitors of a hub's configuration, one after another, by the rules of docs/update.md.
//!
//! ```text
//! all: look ─▶ each: look, ask its zones ─▶ lock out ─▶ ask its zones ─▶ update ─▶ release ─▶ the next
//! ```

use std::fs::File;
use std::io;
use std::path::Path;
use std::time::Duration;

use lafet_client::Monitor;
use lafet_client::update::{Image, Pace, Unready, UpdateError, Updated};
use lafet_hub::Config;
use lafet_texts::{Shown, Text as _, cli as text};
use serde_json::{Value, json};
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep, timeout};

use super::course::{At, Course, Seen, end_all};
use super::site::{Lack, Ready, Site, Station, is_locked_out, of_monitor};
use super::{Sender, UpdateArgs, dotted, failed, load, patient};
use crate::cli::Global;
use crate::cmd::param::failed_to_save;
use crate::cmd::serve;
use crate::connect::{Connection, giving_way_for_long};
use crate::failure::{Failure, Outcome};
use crate::installed;
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::Out;

/// A lockout, or its release, shows within this time.
const SHOWS: Duration = Duration::from_secs(10);
/// Pause between two looks for it.
const PAUSE: Duration = Duration::from_millis(100);
/// Longest time for a last look at a monitor whose update has ended early.
const LAST_LOOK: Duration = Duration::from_secs(5);

/// Runs `lafet update --all`.
pub async fn run(args: &UpdateArgs, file: &Path, global: &Global, out: &mut Out) -> Outcome {
    let images = load(&args.images)?;
    let mut interrupt = Interrupt::catch()?;
    let config = serve::config(file, &installed::overrides(file))?;
    let _hub = keep_hub_off(file, &config)?;
    let site = Site::of(&config, &args.only)?;
    let _alone = site.occupy()?;
    // A terminal that is held must not hold what is on trial.
    let mut aside = out.aside().ok();
    let out = aside.as_mut().unwrap_or(out);
    let mut courses: Vec<Course> = site.chosen().map(|it| Course::new(&it.id)).collect();
    let (pace, proven) = (args.pace.and_then(Pace::new), args.proven());
    let how = How { images: &images, pace, proven, global: patient(global) };
    let ended = tokio::select! {
        biased;
        () = interrupt.wait() => Err(Failure::Interrupted),
        ended = each(&site, &mut courses, &how, out) => ended,
    };
    let Err(failure) = ended else {
        let (count, version) = (courses.len(), images.first().map(Image::version));
        let version = dotted(version.unwrap_or_default());
        return out.say(text::UpdateSiteDone { count, version }.of(current()));
    };
    let find = |id: &str| site.chosen().find(|it| it.id == id);
    let unfinished = courses.iter().find(|it| it.at.is_under_way());
    let seen = match unfinished.and_then(|it| find(&it.id)) {
        Some(station) => tokio::select! {
            biased;
            () = interrupt.wait() => None,
            seen = timeout(LAST_LOOK, last_look(station, &how.global)) => seen.ok().flatten(),
        },
        None => None,
    };
    let url = |id: &str| find(id).map_or_else(String::new, |it| it.endpoint.to_string());
    // The failure counts, whether all of it can be shown or not.
    let _ = end_all(&courses, &failure, seen, url, out);
    Err(failure)
}

/// The hub of the configuration has the links to the monitors while it runs, and does not start before the file is
/// dropped.
fn keep_hub_off(file: &Path, config: &Config) -> Result<Option<File>, Failure> {
    let Some(folder) = &config.data else { return Ok(None) };
    installed::keep_off(folder).map_err(|error| match error.kind() {
        io::ErrorKind::WouldBlock => {
            let file = Shown(file.display());
            Failure::Ended(text::UpdateSiteHubRuns { file }.of(current()))
        }
        _ => {
            let folder = Shown(folder.display());
            Failure::io(text::UpdateSiteHubHidden { folder }.of(current()), error)
        }
    })
}

/// What is sent, and how.
struct How<'a> {
    images: &'a [Image],
    /// As the user says it.
    pace: Option<Pace>,
    /// How long an image has to be as the monitor was before.
    proven: Duration,
    global: Global,
}

/// Looks at all, then updates one after another; ends at the first failure.
async fn each(site: &Site, courses: &mut [Course], how: &How<'_>, out: &mut Out) -> Outcome {
    preflight(site, how, out).await?;
    for course in courses {
        let Some(station) = site.chosen().find(|it| it.id == course.id) else { continue };
        let ended = turn(site, station, course, how, out).await;
        ended.map_err(|failure| of_monitor(&station.id, failure))?;
    }
    Ok(())
}

/// Looks at all that are to be updated. If one of them lacks anything, nothing is changed at any.
async fn preflight(site: &Site, how: &How<'_>, out: &mut Out) -> Outcome {
    let (mut lines, mut silent) = (Vec::new(), true);
    for (station, looked) in site.survey(how.images, &how.global).await {
        let id = &station.id;
        let lacks = match looked {
            Ok(ready) => {
                say_ready(id, &ready, out);
                continue;
            }
            Err(lacks) => lacks,
        };
        silent &= lacks.iter().all(|lack| lack.silent);
        let missing: Vec<String> = lacks.into_iter().map(|lack| lack.text).collect();
        lines.push(format!("  {id}: {}", missing.join(" ")));
        note(out, json!({ "monitor": id, "state": "not-ready", "missing": missing }));
    }
    if lines.is_empty() {
        return Ok(());
    }
    let text = text::UpdateSiteNotReady { lines: lines.join("\n") }.of(current());
    Err(if silent { Failure::Silent(text) } else { Failure::Ended(text) })
}

fn say_ready(id: &str, ready: &Ready, out: &mut Out) {
    let version = dotted(ready.version);
    out.progress(text::UpdateSiteReady { id, version: &version }.of(current()));
    let locked_out = ready.locked_out;
    note(
        out,
        json!({ "monitor": id, "state": "ready", "version": version, "locked_out": locked_out }),
    );
}

/// Prints a line for a program. Where the reader is gone, the update goes on.
pub fn note(out: &mut Out, json: Value) {
    if out.json() {
        let _ = out.value(&json);
    }
}

fn lacking(lacks: &[Lack]) -> Failure {
    let text = lacks.iter().map(|lack| lack.text.as_str()).collect::<Vec<_>>().join(" ");
    match lacks.iter().all(|lack| lack.silent) {
        true => Failure::Silent(text),
        false => Failure::Ended(text),
    }
}

/// The turn of a monitor, on its line. Stop for another one of the line does not wait for it: then it is dropped, and
/// goes on where it was.
async fn turn(
    site: &Site,
    station: &Station,
    course: &mut Course,
    how: &How<'_>,
    out: &mut Out,
) -> Outcome {
    let shown = Mutex::new((course, out));
    let attempt = || async {
        let mut shown = shown.lock().await;
        let (course, out) = &mut *shown;
        // It was dropped before: the other program may have locked it out as well.
        course.shared |= course.locked_here;
        let line = station.open(&how.global).await?;
        one(site, station, course, &line, how, out).await
    };
    let (url, wait) = (station.endpoint.to_string(), Duration::from_secs_f64(how.global.timeout));
    giving_way_for_long(&url, &station.endpoint, wait, attempt).await.and_then(|it| it)
}

/// Updates a monitor: locked out if it is not, and released again if that was done here.
async fn one(
    site: &Site,
    station: &Station,
    course: &mut Course,
    line: &Connection,
    how: &How<'_>,
    out: &mut Out,
) -> Outcome {
    let under_way = course.at.is_under_way();
    let looked = match under_way {
        true => station.look(line, how.images).await,
        false => {
            course.enter(At::Checking, out);
            site.look(station, line, how.images, &how.global).await
        }
    };
    let ready = looked.map_err(|lacks| lacking(&lacks))?;
    course.locked_here &= ready.locked_out || !ready.same;
    if ready.same && !course.locked_here {
        course.same(ready.version, out);
        return Ok(());
    }
    let connection = station.on(line).map_err(Failure::Silent)?;
    let before = ready.locked_out && !course.locked_here;
    if !ready.locked_out && !ready.same {
        lock_out(site, station, course, line, how, out).await?;
    }
    let mut updated = None;
    if !ready.same {
        course.enter(At::Updating, out);
        let pace = how.pace.unwrap_or_else(|| Pace::usual(&station.endpoint));
        let (images, note, proven) = (how.images, &station.note, how.proven);
        let sender = Sender { connection: &connection, images, note, pace, proven };
        updated = match sender.bring(&mut course.far, out).await? {
            Ok(Updated { from, to }) => Some((from, to)),
            Err(UpdateError::AlreadyRunning(_)) => None,
            Err(error) => return Err(failed(error)),
        };
    }
    if course.locked_here {
        release(course, &connection.monitor, out).await?;
    }
    match updated {
        Some((from, to)) => course.done(from, to, before, out),
        None => course.same(ready.version, out),
    }
    Ok(())
}

/// Locks a monitor out before its update.
async fn lock_out(
    site: &Site,
    station: &Station,
    course: &mut Course,
    line: &Connection,
    how: &How<'_>,
    out: &mut Out,
) -> Outcome {
    if matches!(course.at, At::Updating | At::Releasing) {
        // Another program has released it while the line was given to it.
        return Err(Failure::Ended(Unready::NotLockedOut.of(current())));
    }
    let monitor = station.on(line).map_err(Failure::Silent)?.monitor;
    course.enter(At::Locking, out);
    course.locked_here = true;
    switch(&monitor, true).await?;
    // Another client may have locked another one out at the same time.
    let lacks = site.lacks_beside(station, line, &how.global).await;
    if lacks.is_empty() {
        return Ok(());
    }
    release(course, &monitor, out).await?;
    course.at = At::Checking;
    Err(lacking(&lacks))
}

/// Ends the lockout of this command, if it is certain that it is no one else's.
async fn release(course: &mut Course, monitor: &Monitor, out: &mut Out) -> Outcome {
    if course.shared {
        return Err(Failure::Ended(text::UpdateSiteLineGiven.str(current()).into()));
    }
    course.enter(At::Releasing, out);
    switch(monitor, false).await?;
    course.locked_here = false;
    Ok(())
}

/// Locks a monitor out, or releases it once, and waits until that shows: it counts, whether the answer was lost or
/// not.
async fn switch(monitor: &Monitor, on: bool) -> Outcome {
    let sent = monitor.save_lockout(on).await;
    match (shows(monitor, on).await, sent) {
        (Ok(()), Ok((_, saved))) => failed_to_save(saved),
        (Ok(()), Err(_)) => Ok(()),
        (Err(_), Err(error)) => Err(error.into()),
        (Err(failure), Ok(_)) => Err(failure),
    }
}

async fn shows(monitor: &Monitor, on: bool) -> Outcome {
    let since = Instant::now();
    loop {
        let status = monitor.status_all().await;
        let over = since.elapsed() >= SHOWS;
        match status {
            Ok(status) if is_locked_out(&status) == Some(on) => return Ok(()),
            Ok(_) if over && on => {
                return Err(Failure::Ended(text::UpdateSiteNotLocked.str(current()).into()));
            }
            Ok(_) if over => {
                return Err(Failure::Ended(text::UpdateSiteStillLocked.str(current()).into()));
            }
            Err(error) if over => return Err(error.into()),
            _ => sleep(PAUSE).await,
        }
    }
}

/// The report of a monitor whose update has ended early, and whether it is locked out.
async fn last_look(station: &Station, global: &Global) -> Option<Seen> {
    let look = async |line: &Connection| {
        let report = station.software(line).await.ok()?;
        let locked_out = is_locked_out(&station.status(line).await.ok()?)?;
        Some(Seen { report, locked_out })
    };
    station.visit(global, look).await.ok().flatten()
}
