//! A run: reads, judges, and tries step by step. Whatever ends it, what it has started is ended and put back.

mod contacts;
mod drill;
mod motion;
mod outlet;
mod reads;
mod station;
mod undo;
mod water;
mod zone;

use std::collections::{BTreeMap, BTreeSet};

use lafet_texts::{Text, Words, acceptance as text};
use serde::Serialize;

use crate::check::{self, Check, Stage};
use crate::facts::{Facts, Monitor, Zones};
use crate::finding::{Findings, Verdict};
use crate::judge;
use crate::order::{Dry, Former, Posting};
use crate::plan::Plan;
use crate::wire::{Answer, Asks, Failed, Person, Question, Wire};

/// Between two looks at the site, ms.
const POLL_MS: u64 = 100;
/// A monitor that is held is taken again so often, ms: it is lost 10 s after the last request.
const RENEW_MS: u64 = 3000;
/// A person does what was asked within, ms.
const PERSON_MS: u64 = 60_000;

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

/// What was started and has to be ended.
#[derive(Debug, Default)]
struct Begun {
    /// Monitors that are held, and when each was last taken.
    held: BTreeMap<String, u64>,
    /// Monitors that were stowed before.
    deployed: BTreeSet<String>,
    /// Zones under test.
    zones: BTreeMap<String, Under>,
    /// Monitors that give water.
    water: BTreeSet<String>,
    /// Zones that a station was to release, for the test of it.
    released: BTreeSet<String>,
    /// Monitors that were closed: the zone controller uses them again after a reset.
    closed: BTreeSet<String>,
}

/// A zone under test.
#[derive(Clone, Debug)]
struct Under {
    /// The mode that it had.
    former: Former,
    /// The mode that it is in.
    mode: &'static str,
    /// Its detectors are in alarm by test sources, or may be.
    sources: bool,
}

/// A run.
#[derive(Debug)]
pub struct Run<'a, W, P> {
    wire: &'a mut W,
    person: &'a mut P,
    plan: &'a Plan,
    facts: Facts,
    out: Outcome,
    begun: Begun,
    /// Detectors that may be in alarm.
    expected: BTreeSet<String>,
    /// The last two looks, by the time of the hub, ms.
    looked: [u64; 2],
    /// The phase of each zone, and the looks between which it last changed into each.
    phases: BTreeMap<String, (String, BTreeMap<String, [u64; 2]>)>,
    began_ms: u64,
}

impl<'a, W: Wire, P: Person> Run<'a, W, P> {
    /// Tests the installation behind a hub against a plan.
    pub async fn all(
        wire: &'a mut W,
        person: &'a mut P,
        plan: &'a Plan,
        stages: &BTreeSet<Stage>,
    ) -> Outcome {
        let began_ms = wire.now_ms();
        let mut run = Self {
            wire,
            person,
            plan,
            facts: Facts::default(),
            out: Outcome::default(),
            begun: Begun::default(),
            expected: BTreeSet::new(),
            looked: [0; 2],
            phases: BTreeMap::new(),
            began_ms,
        };
        run.out.ended = run.stages(stages).await.err();
        run.undo().await;
        run.complete(stages);
        run.out.took_ms = run.wire.now_ms().saturating_sub(began_ms);
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
        let moves = stages.iter().any(|it| *it > Stage::Read);
        let fails = |check: &Check| judged.failed().any(|it| it.check.id == check.id);
        if moves && (fails(&check::QUIET) || fails(&check::REST)) {
            return Err(End::Unsafe(text::NotAtRest.words()));
        }
        if stages.contains(&Stage::Dry) {
            self.dry().await?;
        }
        if stages.contains(&Stage::Drill) {
            self.drills().await?;
        }
        if stages.contains(&Stage::Outlet) {
            self.outlets().await?;
        }
        if stages.contains(&Stage::Water) {
            self.waters().await?;
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

    /// Whether a check of a subject has passed.
    fn has_passed(&self, check: &Check, subject: &str) -> bool {
        let all = self.out.findings.0.iter();
        let mut of = all.filter(|it| it.check.id == check.id && it.subject == subject);
        of.any(|it| it.verdict == Verdict::Pass)
    }

    /// Whether a check of a subject has failed.
    fn has_failed(&self, check: &Check, subject: &str) -> bool {
        let all = self.out.findings.0.iter();
        let mut of = all.filter(|it| it.check.id == check.id && it.subject == subject);
        of.any(|it| it.verdict == Verdict::Fail)
    }

    /// Asks, and notes the answer.
    async fn ask(&mut self, id: String, words: Words, asks: Asks) -> Step<Answer> {
        let question = Question { id, text: words, asks };
        let answer = self.person.answer(&question).await;
        let noted = match &answer {
            Answer::Yes => Some("yes".to_owned()),
            Answer::No => Some("no".to_owned()),
            Answer::Number(value) => Some(value.to_string()),
            Answer::Name(name) => Some(name.clone()),
            Answer::Skip => None,
            Answer::Stop => return Err(End::Stopped),
        };
        let Question { id, text, .. } = question;
        self.out.answers.push(Answered { question: id, text, answer: noted });
        Ok(answer)
    }

    /// Whether the person says yes.
    async fn agrees(&mut self, id: String, words: Words, asks: Asks) -> Step<bool> {
        Ok(self.ask(id, words, asks).await? == Answer::Yes)
    }

    /// Orders what a dry step may; says before what moves. `Some`: the hub or the monitor refuses.
    async fn order(&mut self, order: Dry) -> Step<Option<Words>> {
        if let Some(words) = order.words() {
            self.announce(words);
        }
        self.send(&order.posting()).await
    }

    fn announce(&mut self, what: Words) {
        self.person.hear(&what);
        let after_ms = self.wire.now_ms().saturating_sub(self.began_ms);
        self.out.did.push(Did { after_ms, what });
    }

    async fn send(&mut self, posting: &Posting) -> Step<Option<Words>> {
        match self.wire.post(posting).await {
            Ok(_) => Ok(None),
            Err(Failed::Refused { text, .. }) => Ok(Some(text)),
            Err(Failed::Lost(why)) => Err(End::Lost(why)),
        }
    }

    async fn pause(&mut self, ms: u64) -> Step {
        self.wire.pause(ms).await.map_err(|_| End::Stopped)
    }

    /// Looks at the site: zones and monitors. What must not be during a test ends it.
    async fn look(&mut self) -> Step<(Zones, BTreeMap<String, Monitor>)> {
        self.renew().await?;
        let zones = self.get::<Zones>("/api/zones").await?.unwrap_or_default();
        let monitors = self.get::<BTreeMap<String, Monitor>>("/api/monitors").await?;
        let monitors = monitors.unwrap_or_default();
        self.looked = [self.looked[1], zones.state.at_ms];
        for zone in &zones.state.zones {
            let (last, changed) = self.phases.entry(zone.zone.clone()).or_default();
            if last != zone.phase() {
                zone.phase().clone_into(last);
                changed.insert(last.clone(), self.looked);
            }
        }
        let strange = zones.alarms().into_iter().find(|it| !self.expected.contains(*it));
        if let Some(detector) = strange {
            return Err(End::Unsafe(text::StrangeAlarm { detector }.words()));
        }
        let open = |(id, it): &(&String, &Monitor)| {
            !self.begun.water.contains(*id) && !it.status.stale && !it.not_closed().is_empty()
        };
        if let Some((id, _)) = monitors.iter().find(open) {
            let words = text::ValveNotClosed { monitor: id }.words();
            self.tried(&check::CLOSED, id, false, text::RestLimit, words.clone());
            return Err(End::Unsafe(words));
        }
        for (id, under) in &self.begun.zones {
            if zones.zone(id).is_none_or(|it| it.mode != under.mode) {
                return Err(End::Unsafe(text::TestModeLost { zone: id }.words()));
            }
        }
        Ok((zones, monitors))
    }

    /// Monitors that are held stay so.
    async fn renew(&mut self) -> Step {
        let now = self.wire.now_ms();
        let due = self.begun.held.iter().filter(|(_, at)| now.saturating_sub(**at) >= RENEW_MS);
        let due: Vec<String> = due.map(|(id, _)| id.clone()).collect();
        for monitor in due {
            let refused = self.send(&Dry::Take { monitor: monitor.clone() }.posting()).await?;
            if let Some(why) = refused {
                self.begun.held.remove(&monitor);
                return Err(End::Unsafe(text::MonitorLost { monitor: &monitor, why }.words()));
            }
            self.begun.held.insert(monitor, now);
        }
        Ok(())
    }

    /// Looks until something is so, `ms` at most; how long it took.
    async fn until<T>(
        &mut self,
        ms: u64,
        mut so: impl FnMut(&Zones, &BTreeMap<String, Monitor>) -> Option<T>,
    ) -> Step<Option<(T, u64)>> {
        let began = self.wire.now_ms();
        loop {
            let (zones, monitors) = self.look().await?;
            let took = self.wire.now_ms().saturating_sub(began);
            if let Some(it) = so(&zones, &monitors) {
                return Ok(Some((it, took)));
            }
            if took >= ms {
                return Ok(None);
            }
            self.pause(POLL_MS).await?;
        }
    }
}
