//! A run: reads, judges, turns monitors one at a time, and looks on while people try a test outlet (`outlet`).
//! Whatever ends it, what it has started is ended.
//!
//! Nothing moves without a look right before it that shows that it may (`look`), and that look is what the order is
//! dated by: what a person has stopped since, the hub refuses. No question and nothing else is waited for without
//! looking, and each wait has an end (`ask`).

mod ask;
mod look;
mod motion;
mod outlet;
mod reads;
mod undo;
mod watch;

use std::collections::{BTreeMap, BTreeSet};

use lafet_texts::{Text, Words, acceptance as text};
use serde::Serialize;

use crate::check::{self, Check, Stage};
use crate::facts::{Facts, Monitor, Urgent};
use crate::finding::{Findings, Verdict};
use crate::judge;
use crate::order::Order;
use crate::plan::Plan;
use crate::wire::{Failed, Person, Wire};

use watch::Trial;

/// Between two looks at the site, ms.
const POLL_MS: u64 = 100;

/// Why a run ends early.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// The person has stopped it.
    Stopped,
    /// The hub is not reached any more.
    Lost(Words),
    /// Something else needs the installation, or is not as it has to be for a test.
    Unsafe(Words),
}

impl End {
    /// What a failed request means for the run.
    fn of(failed: Failed) -> Self {
        match failed {
            Failed::Stopped => Self::Stopped,
            Failed::Refused { text, .. } | Failed::Lost(text) => Self::Lost(text),
        }
    }

    /// In words.
    pub fn words(&self) -> Words {
        match self {
            Self::Stopped => text::EndStopped.words(),
            Self::Lost(why) => text::EndLost { why }.words(),
            Self::Unsafe(why) => text::EndUnsafe { why }.words(),
        }
    }
}

type Step<T = ()> = Result<T, End>;
/// Monitors by id.
type Monitors = BTreeMap<String, Monitor>;

/// What was asked, and what was answered.
#[derive(Clone, Debug, Serialize)]
pub struct Answered {
    /// Id of the question.
    pub question: String,
    /// What was asked.
    pub text: Words,
    /// What was answered: `yes`, `no`, a number, a name; none: no answer.
    pub answer: Option<String>,
}

/// What was ordered that moves.
#[derive(Clone, Debug, Serialize)]
pub struct Did {
    /// Since the start of the run, ms.
    pub after_ms: u64,
    /// What.
    pub what: Words,
}

/// What came of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The findings, of every check at least one.
    pub findings: Findings,
    /// Questions and answers.
    pub answers: Vec<Answered>,
    /// What was ordered.
    pub did: Vec<Did>,
    /// What could not be put back: a person has to.
    pub left: Vec<Words>,
    /// Why it ended early.
    pub ended: Option<End>,
    /// Version of the hub.
    pub version: String,
    /// The monitors are simulated.
    pub simulation: bool,
    /// It lasted so long, ms.
    pub took_ms: u64,
}

/// A monitor that is held. It is noted before it is taken: the answer to that may be lost.
#[derive(Debug)]
struct Held {
    id: String,
    /// It was last taken, ms.
    taken_ms: u64,
    /// It was stowed before.
    stowed: bool,
    /// Urgent requests of all clients for it, as they were; none before the first look.
    urgent: Option<Urgent>,
    /// So many Stops of this run are not among them yet.
    stopping: u64,
    /// Its state was known in each look.
    watched: bool,
    /// A person has locked it out.
    locked: bool,
}

/// A run.
#[derive(Debug)]
pub struct Run<'a, W, P> {
    wire: &'a mut W,
    person: &'a mut P,
    plan: &'a Plan,
    facts: Facts,
    out: Outcome,
    held: Option<Held>,
    /// The zone whose test outlet people try.
    trial: Option<Trial>,
    /// The hub has no zones.
    zoneless: bool,
    /// Time of the hub since its start at the last look, ms.
    up_ms: u64,
    started_ms: u64,
}

impl<'a, W: Wire, P: Person> Run<'a, W, P> {
    /// Tests the installation behind a hub against a plan.
    pub async fn all(
        wire: &'a mut W,
        person: &'a mut P,
        plan: &'a Plan,
        stages: &BTreeSet<Stage>,
    ) -> Outcome {
        let started_ms = wire.now_ms();
        let mut run = Self {
            wire,
            person,
            plan,
            facts: Facts::default(),
            out: Outcome::default(),
            held: None,
            trial: None,
            zoneless: false,
            up_ms: 0,
            started_ms,
        };
        run.out.ended = run.stages(stages).await.err();
        run.undo().await;
        run.complete(stages);
        run.out.took_ms = run.wire.now_ms().saturating_sub(started_ms);
        run.out
    }

    async fn stages(&mut self, stages: &BTreeSet<Stage>) -> Step {
        self.read().await?;
        let hub = self.facts.hub.clone().unwrap_or_default();
        (self.out.version, self.out.simulation) = (hub.version, hub.simulation);
        let judged = judge::read(self.plan, &self.facts);
        if stages.contains(&Stage::Read) {
            self.out.findings.0.extend(judged.0.clone());
        }
        if stages.iter().all(|it| *it == Stage::Read) {
            return Ok(());
        }
        let fails = |check: &Check| judged.failed().any(|it| it.check.id == check.id);
        if fails(&check::QUIET) || fails(&check::REST) {
            return Err(End::Unsafe(text::NotAtRest.words()));
        }
        // It may be the hub of another site.
        if fails(&check::MONITORS_KNOWN) {
            return Err(End::Unsafe(text::OtherSite.words()));
        }
        if stages.contains(&Stage::Dry) {
            self.dry().await?;
        }
        if stages.contains(&Stage::Outlet) {
            self.outlets().await?;
        }
        Ok(())
    }

    /// Checks without any finding were not tried: each says so.
    fn complete(&mut self, stages: &BTreeSet<Stage>) {
        let ended = self.out.ended.as_ref().map(End::words);
        for check in check::ALL {
            if self.out.findings.0.iter().any(|it| it.check.id == check.id) {
                continue;
            }
            let why = match &ended {
                _ if !stages.contains(&check.stage) => text::StepNotChosen.words(),
                Some(why) => why.clone(),
                None => text::NothingToTry.words(),
            };
            self.out.findings.not_tried(check, "", why);
        }
        let place = |id: &str| check::ALL.iter().position(|it| it.id == id);
        self.out.findings.0.sort_by_key(|it| place(it.check.id));
    }

    /// Notes what was measured.
    fn tried(
        &mut self,
        check: &'static Check,
        subject: &str,
        good: bool,
        limit: impl Text,
        measured: impl Text,
    ) {
        self.out.findings.tried(check, subject, good, limit, measured);
    }

    fn not_tried(&mut self, check: &'static Check, subject: &str, why: impl Text) {
        self.out.findings.not_tried(check, subject, why);
    }

    fn none_tried(&mut self, checks: &[&'static Check], subject: &str, why: &Words) {
        checks.iter().for_each(|it| self.not_tried(it, subject, why.clone()));
    }

    /// Whether a check of a subject has failed.
    fn has_failed(&self, check: &Check, subject: &str) -> bool {
        let all = self.out.findings.0.iter();
        let mut of = all.filter(|it| it.check.id == check.id && it.subject == subject);
        of.any(|it| it.verdict == Verdict::Fail)
    }

    fn announce(&mut self, what: Words) {
        self.person.hear(&what);
        let after_ms = self.wire.now_ms().saturating_sub(self.started_ms);
        self.out.did.push(Did { after_ms, what });
    }

    /// Sends an order, dated by the last look. `Some`: the hub or the monitor refuses, and nothing has happened.
    async fn send(&mut self, id: &str, order: &Order) -> Step<Option<Words>> {
        match self.wire.post(&order.posting(id).seen_at(self.up_ms)).await {
            Ok(_) => Ok(None),
            Err(Failed::Refused { text, .. }) => Ok(Some(text)),
            Err(failed) => Err(End::of(failed)),
        }
    }

    async fn pause(&mut self, ms: u64) -> Step {
        self.wire.pause(ms).await.map_err(|_| End::Stopped)
    }
}
