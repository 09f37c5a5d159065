//! How far each monitor of `lafet update --all` is, and how that is shown.

use lafet_proto::update::Report;
use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};

use super::all::note;
use super::{Far, dotted, phase, phase_name, running};
use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::Out;

/// Where the update of a monitor is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum At {
    /// Another one is before it.
    Waiting,
    /// It and its zones are asked once more. Nothing has been changed.
    Checking,
    /// It is being locked out.
    Locking,
    /// It is being updated.
    Updating,
    /// The lockout of this command is being ended.
    Releasing,
    /// It runs the version.
    Done,
}

impl At {
    /// Whether something was changed, and it is not at its end.
    pub const fn is_under_way(self) -> bool {
        matches!(self, Self::Locking | Self::Updating | Self::Releasing)
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Checking => "checking",
            Self::Locking => "locking",
            Self::Updating => "updating",
            Self::Releasing => "unlocking",
            Self::Done => "done",
        }
    }
}

/// The update of a monitor.
pub struct Course {
    /// Its id.
    pub id: String,
    /// Where it is.
    pub at: At,
    /// This command has locked it out, or has tried to, and has not seen it released since.
    pub locked_here: bool,
    /// Its line was given to another program since, which may have locked it out as well.
    pub shared: bool,
    /// How far the update itself is.
    pub far: Far,
}

impl Course {
    /// One that waits.
    pub fn new(id: &str) -> Self {
        let far = Far::of(id);
        Self { id: id.to_owned(), at: At::Waiting, locked_here: false, shared: false, far }
    }

    /// Shows where it is now.
    pub fn enter(&mut self, at: At, out: &mut Out) {
        self.at = at;
        let id = &self.id;
        match at {
            At::Locking => out.progress(text::UpdateSiteLocking { id }.of(current())),
            At::Releasing => out.progress(text::UpdateSiteReleasing { id }.of(current())),
            _ => {}
        }
        note(out, json!({ "monitor": id, "state": at.name() }));
    }

    /// It is updated; `before`: it was locked out before, and still is.
    pub fn done(&mut self, from: [u16; 4], to: [u16; 4], before: bool, out: &mut Out) {
        self.at = At::Done;
        let (id, from, to) = (&self.id, dotted(from), dotted(to));
        let lockout = match before {
            true => text::UpdateSiteLockedBefore.str(current()),
            false => text::UpdateSiteReleased.str(current()),
        };
        let text = match from == to {
            true => text::UpdateSiteTrialDone { id, to: &to, lockout }.of(current()),
            false => text::UpdateSiteOneDone { id, from: &from, to: &to, lockout }.of(current()),
        };
        // Where the reader is gone, the next one is updated all the same.
        let _ = out.show(text, || {
            json!({ "monitor": id, "state": "done", "from": from, "to": to, "locked_out": before })
        });
    }

    /// It runs the version already.
    pub fn same(&mut self, version: [u16; 4], out: &mut Out) {
        self.at = At::Done;
        let (id, to) = (&self.id, dotted(version));
        let text = text::UpdateSiteSame { id, to: &to }.of(current());
        let _ = out.show(text, || json!({ "monitor": id, "state": "same", "to": to }));
    }

    /// What the update that has not come to its end leaves.
    fn unfinished(&self, seen: Option<Seen>, url: &str) -> Vec<String> {
        let id = &self.id;
        let lockout = match (seen, self.locked_here) {
            (Some(Seen { locked_out: false, .. }), _) => text::UpdateSiteUnlocked.str(current()),
            (_, true) => text::UpdateSiteLockedHere.str(current()),
            (_, false) => text::UpdateSiteLockedBefore.str(current()),
        };
        let mut lines = vec![match seen {
            Some(Seen { report, .. }) => {
                let (version, running) = (dotted(report.version), running(&report));
                let phase = phase(&report);
                text::UpdateSiteSeen { id, version, running, phase, lockout }.of(current())
            }
            None => text::UpdateSiteUnseen { id, lockout }.of(current()),
        }];
        let released = seen.is_some_and(|seen| !seen.locked_out);
        if self.locked_here && !released {
            lines.push(text::UpdateSiteGoOn { id, url }.of(current()));
        }
        lines
    }
}

/// What a monitor says of itself at the end.
#[derive(Clone, Copy)]
pub struct Seen {
    /// How its software is.
    pub report: Report,
    /// Whether it is locked out.
    pub locked_out: bool,
}

/// Says where each monitor is when the command ends early. `url` is where a monitor is.
pub fn end_all(
    courses: &[Course],
    failure: &Failure,
    seen: Option<Seen>,
    url: impl Fn(&str) -> String,
    out: &mut Out,
) -> Outcome {
    let interrupted = matches!(failure, Failure::Interrupted);
    let ids = |wanted: fn(At) -> bool| {
        let all: Vec<&str> =
            courses.iter().filter(|it| wanted(it.at)).map(|it| it.id.as_str()).collect();
        if all.is_empty() { "—".to_owned() } else { all.join(", ") }
    };
    let rest = |at| matches!(at, At::Waiting | At::Checking);
    let mut lines = Vec::new();
    if courses.iter().all(|it| it.at == At::Waiting) {
        return match interrupted {
            true => out.say(text::UpdateSiteUntouched.str(current())),
            false => Ok(()),
        };
    }
    for course in courses {
        let one = match course.at {
            At::Done => continue,
            at if rest(at) => json!({ "monitor": course.id, "state": "skipped" }),
            _ => {
                let mut said = course.unfinished(seen, &url(&course.id));
                if let Some(far) = course.far.interrupted().filter(|_| interrupted) {
                    said.insert(0, format!("{}: {far}", course.id));
                }
                let state = if interrupted { "ended" } else { "failed" };
                let one = of_unfinished(&course.id, state, seen, &said.join("\n"));
                lines.extend(said);
                one
            }
        };
        note(out, one);
    }
    let (done, rest) = (ids(|at| at == At::Done), ids(rest));
    lines.push(text::UpdateSiteSummary { done, rest }.of(current()));
    out.say(lines.join("\n"))
}

fn of_unfinished(id: &str, state: &str, seen: Option<Seen>, text: &str) -> Value {
    let report = seen.map(|seen| seen.report);
    json!({
        "monitor": id,
        "state": state,
        "version": report.map(|report| dotted(report.version)),
        "on_trial": report.map(|report| report.trial),
        "phase": report.map(|report| phase_name(&report)),
        "locked_out": seen.map(|seen| seen.locked_out),
        "text": text,
    })
}
