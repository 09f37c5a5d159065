//! Runs a scenario: at once in virtual time, or step by step while people act in it.

use std::collections::BTreeMap;
use std::sync::Arc;

use lafet_proto::flags::{SetFlag, Severity, set_flags};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Answer, Request, SubsystemId};
use lafet_texts::{Shown, Text, Words, sim as text};

use super::checks::{Check, Checks};
use super::controller::Controller;
use super::director::{Director, LOOK_MS, Waiting, fire_news};
use super::file::{FIRES_MAX, kind_of_fire};
use super::log::{Counts, Kind, Line, Log};
use super::plan::{Exercise, Link, OperatorLine};
use super::recording::Recording;
use crate::event::What;
use crate::fire::FireSpec;
use crate::site::{Site, SiteEvent};

/// Time in which monitors look at their sensors for the first time, ms.
const START_MS: u64 = 300;

/// What came of a scenario.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The scenario.
    pub exercise: Arc<Exercise>,
    /// The seed of this run.
    pub seed: u64,
    /// What happened, in the order of time.
    pub lines: Vec<Line>,
    /// The expectations.
    pub checks: Vec<Check>,
    /// Figures of the monitors.
    pub monitors: Vec<MonitorFigures>,
    /// Figures of the fires.
    pub fires: Vec<FireFigures>,
    /// What the pictures are made of.
    pub recording: Recording,
    /// The state of all monitors each 100 ms, if it was asked for.
    pub trace: String,
}

impl Outcome {
    /// Whether every expectation holds.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed)
    }
}

/// Figures of a monitor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MonitorFigures {
    /// Requests and answers.
    pub counts: Counts,
    /// Water out of the nozzle, l.
    pub litres: f64,
    /// When its jet began first, ms.
    pub first_water_ms: Option<u64>,
    /// How long its jet lasted, ms.
    pub water_ms: u64,
    /// Most pressure at its nozzle, atm.
    pub most_atm: f64,
    /// Way of the azimuth and of the elevation, degrees.
    pub way_deg: (f64, f64),
    /// Flags reported that are at least warnings.
    pub warnings: u32,
    /// Resets and power-ups after the first.
    pub restarts: u32,
}

/// Figures of a fire.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FireFigures {
    /// When it burned first, ms.
    pub lit_ms: Option<u64>,
    /// When water reached it first, ms.
    pub hit_ms: Option<u64>,
    /// When it was out last, ms; `None` while it burns.
    pub out_ms: Option<u64>,
    /// How often it flared up again.
    pub reignited: u32,
    /// Its greatest diameter, m.
    pub size_m: f64,
}

/// A scenario that runs.
#[derive(Clone, Debug)]
pub struct Run {
    director: Director,
    automatic: bool,
    seed: u64,
    log: Log,
    checks: Checks,
    answers: Vec<Option<Check>>,
    operators: Vec<Operator>,
    controllers: Vec<Controller>,
    recording: Recording,
    told: BTreeMap<(usize, SubsystemId), u32>,
    monitors: Vec<MonitorFigures>,
    fires: Vec<FireFigures>,
}

/// Where the operator is at a monitor.
#[derive(Clone, Debug, Default)]
struct Operator {
    /// Lines that are done.
    done: usize,
    waiting: Waiting,
    again_ms: Option<u64>,
}

/// Runs a scenario from beginning to end; `trace` keeps the state of everything.
pub fn run(exercise: &Arc<Exercise>, seed: u64, trace: bool) -> Outcome {
    let mut run = Run::new(exercise, seed);
    let mut lines = String::new();
    while !run.is_over() {
        if run.director.now_ms().is_multiple_of(LOOK_MS) {
            run.look();
            if trace {
                run.director.site.members.iter().zip(&exercise.monitors).for_each(
                    |(member, plan)| {
                        lines.push_str(&format!("{} {}\n", plan.name, member.sim.trace_line()));
                    },
                );
            }
        }
        run.director.tick();
    }
    run.finish(lines)
}

impl Run {
    /// A scenario at its beginning. The scenario's operator and controllers act.
    pub fn new(exercise: &Arc<Exercise>, seed: u64) -> Self {
        let count = exercise.monitors.len();
        let mut director = Director::new(Arc::clone(exercise), seed);
        let recording = Recording::new(exercise, &mut director.site);
        Self {
            director,
            automatic: true,
            seed,
            log: Log::new(count),
            checks: Checks::new(exercise),
            answers: vec![None; exercise.operator.len()],
            operators: vec![Operator::default(); count],
            controllers: vec![Controller::new(); exercise.controllers.len()],
            recording,
            told: BTreeMap::new(),
            monitors: vec![MonitorFigures::default(); count],
            fires: vec![FireFigures::default(); exercise.fires.len()],
        }
    }

    /// Whether the scenario's operator and controllers act, or people do.
    pub const fn set_automatic(&mut self, automatic: bool) {
        self.automatic = automatic;
    }

    /// Whether its time is over.
    pub fn is_over(&self) -> bool {
        self.director.now_ms() >= self.director.exercise().duration_ms
    }

    /// One step of 10 ms.
    pub fn tick(&mut self) {
        if !self.is_over() && self.director.now_ms().is_multiple_of(LOOK_MS) {
            self.look();
        }
        self.director.tick();
    }

    /// The site and its events.
    pub const fn director(&self) -> &Director {
        &self.director
    }

    /// The same, to change something.
    pub const fn director_mut(&mut self) -> &mut Director {
        &mut self.director
    }

    /// What has happened so far.
    pub fn lines(&self) -> &[Line] {
        &self.log.lines
    }

    /// What became of the expectations so far; those that are open have none.
    pub fn checks(&self) -> Vec<(Words, Option<Check>)> {
        let exercise = self.director.exercise();
        let texts = exercise.expectations.iter().map(|it| it.text.clone());
        texts.zip(self.checks.decided().iter().cloned()).collect()
    }

    /// A monitor has accepted a request: what waits for this line of the scenario's
    /// operator has it now. Request and addressee count; how it is aimed is up to them.
    pub fn commanded(&mut self, monitor: usize, request: &str) {
        let head = |text: &str| text.split_whitespace().take(2).map(str::to_owned).collect();
        let sent: Vec<String> = head(request);
        let exercise = Arc::clone(self.director.exercise());
        let own = exercise.operator.iter().filter(|line| line.monitor == monitor);
        for line in own {
            let same = line.request.split(';').any(|one| head(one) == sent);
            if same && line.mark.is_some_and(|mark| self.director.passed(mark).is_none()) {
                self.director.pass(line.mark);
                break;
            }
        }
    }

    /// Lights a fire at a place; on a tank, if one is there. Its name.
    pub fn light(&mut self, at: (f64, f64), size_m: f64, kind: &str) -> Option<String> {
        let spec = FireSpec { size_m, ..kind_of_fire(kind)? };
        if self.director.exercise().fires.len() >= FIRES_MAX {
            return None;
        }
        let name = self.director.light(at, spec);
        self.fires.push(FireFigures::default());
        self.recording.add_fire();
        Some(name)
    }

    /// What came of it, if it ended now.
    pub fn outcome(&self) -> Outcome {
        self.clone().finish(String::new())
    }

    fn look(&mut self) {
        self.events();
        self.statuses();
        if self.automatic {
            self.act();
        }
        self.checks.look(&mut self.director, false);
        self.record();
    }

    fn act(&mut self) {
        self.operate();
        let exercise = Arc::clone(self.director.exercise());
        for (controller, plan) in self.controllers.iter_mut().zip(&exercise.controllers) {
            controller.step(plan, &mut self.director, &mut self.log);
        }
    }

    fn record(&mut self) {
        let mut told = Vec::new();
        for ((monitor, subsystem), bits) in &self.told {
            for flag in set_flags(*subsystem, *bits).filter(|flag| is_news(*subsystem, flag)) {
                told.push((*monitor, format!("{subsystem} {flag}"), flag.severity()));
            }
        }
        self.recording.keep(&self.director, &told);
        for (figures, member) in self.monitors.iter_mut().zip(&self.director.site.members) {
            let world = member.sim.world();
            figures.most_atm = figures.most_atm.max(world.water.pressure_atm());
            if world.water.jet_lps() > 0.1 {
                figures.water_ms += LOOK_MS;
            }
            let speed =
                |axis: usize| world.drives[axis].speed.abs() / 60.0 * LOOK_MS as f64 / 1000.0;
            figures.way_deg.0 += speed(1);
            figures.way_deg.1 += speed(0);
        }
        for (figures, fire) in self.fires.iter_mut().zip(self.director.site.fires.iter()) {
            if fire.burns() {
                figures.size_m = figures.size_m.max(fire.size_m);
            }
        }
    }

    fn events(&mut self) {
        for (at_ms, text) in self.director.take_happened() {
            self.log.add(at_ms, None, Kind::Event, text);
        }
        for SiteEvent { monitor, event } in self.director.site.take_events() {
            match monitor {
                None => self.fire_event(event.at_ms, event.what),
                Some(monitor) => self.plant_event(event.at_ms, monitor, event.what),
            }
        }
    }

    fn fire_event(&mut self, at_ms: u64, what: What) {
        let Some((index, news)) = fire_news(what) else { return };
        let figures = &mut self.fires[index];
        match what {
            What::FireHit(_) => figures.hit_ms = figures.hit_ms.or(Some(at_ms)),
            What::FireOut(_) => figures.out_ms = Some(at_ms),
            _ => {
                figures.lit_ms.get_or_insert(at_ms);
                figures.out_ms = None;
                figures.reignited += u32::from(matches!(what, What::FireReignited(_)));
            }
        }
        let fire = &self.director.exercise().fires[index].name;
        let text = text::FireNews { fire, what: news }.words();
        self.log.add(at_ms, None, Kind::Fire, text);
    }

    fn plant_event(&mut self, at_ms: u64, monitor: usize, what: What) {
        let figures = &mut self.monitors[monitor];
        let text: &dyn Text = match what {
            What::JetOn => {
                figures.first_water_ms.get_or_insert(at_ms);
                &text::JetBegins
            }
            What::JetOff => &text::JetEnds,
            What::FoldedBarrelFlooded => &text::WaterInFoldedBarrel,
            What::PoweredUp if at_ms == 0 => return,
            What::PoweredUp | What::Reset | What::Crashed => {
                figures.restarts += 1;
                &text::ProgramStarts
            }
            _ => return,
        };
        self.log.add(at_ms, Some(monitor), Kind::Plant, text.words());
    }

    /// What the monitors report, whether or not it can be received.
    fn statuses(&mut self) {
        for monitor in 0..self.monitors.len() {
            for (subsystem, bits) in statuses(&mut self.director.site, monitor) {
                let before = self.told.insert((monitor, subsystem), bits);
                // The first look at the sensors clears what is set at power-up.
                let started = self.director.now_ms() > START_MS;
                if let Some(before) = before.filter(|before| started && *before != bits) {
                    self.changed(monitor, subsystem, before, bits);
                }
            }
        }
    }

    fn changed(&mut self, monitor: usize, subsystem: SubsystemId, before: u32, now: u32) {
        let at_ms = self.director.now_ms();
        let news = |bits: u32| {
            let flags = set_flags(subsystem, bits).filter(move |flag| is_news(subsystem, flag));
            flags.collect::<Vec<SetFlag>>()
        };
        let is_in = |list: &[SetFlag], flag: &SetFlag| {
            list.iter().any(|other| other.to_string() == flag.to_string())
        };
        let (old, new) = (news(before), news(now));
        let link_up = |over| self.director.link(monitor, over) == Link::Up;
        // Without a lost link it only says that no request came for 3 s.
        let idle = match subsystem {
            SubsystemId::EXTERNAL_CONN => link_up(lafet_device::Source::ExternalConn),
            SubsystemId::RADIO => link_up(lafet_device::Source::Radio),
            _ => false,
        };
        if idle {
            return;
        }
        for flag in new.iter().filter(|flag| !is_in(&old, flag)) {
            let severity = flag.severity();
            self.monitors[monitor].warnings += u32::from(severity >= Severity::Warning);
            let meaning = flag.info.meaning;
            let flag = Shown(flag);
            let text = text::LogFlag { subsystem: Shown(subsystem), flag, meaning }.words();
            self.log.add(at_ms, Some(monitor), Kind::Flag(severity), text);
        }
        for flag in old.iter().filter(|flag| !is_in(&new, flag)) {
            let text = Words::same(format!("{subsystem} {flag}"));
            self.log.add(at_ms, Some(monitor), Kind::Cleared, text);
        }
    }

    fn operate(&mut self) {
        let exercise = Arc::clone(self.director.exercise());
        for monitor in 0..self.operators.len() {
            // Several lines may be due at once.
            loop {
                let own =
                    exercise.operator.iter().enumerate().filter(|(_, it)| it.monitor == monitor);
                let Some((index, line)) = own.clone().nth(self.operators[monitor].done) else {
                    break;
                };
                let mut operator = self.operators[monitor].clone();
                let now_ms = self.director.now_ms();
                let due = match operator.again_ms {
                    Some(again_ms) => now_ms >= again_ms,
                    None => self.director.fires(&line.trigger, &mut operator.waiting),
                };
                if due {
                    self.send(index, line, &mut operator);
                }
                let done = operator.done > self.operators[monitor].done;
                self.operators[monitor] = operator;
                if !done {
                    break;
                }
            }
        }
    }

    fn send(&mut self, index: usize, line: &OperatorLine, operator: &mut Operator) {
        let OperatorLine { monitor, over, request, payload, .. } = line;
        let now_ms = self.director.now_ms();
        let answers = self.director.request(*monitor, *over, payload);
        let texts =
            self.log.exchange(now_ms, *monitor, *over, request, payload, answers.as_deref());
        self.director.pass(line.mark);
        let came = texts.first().cloned();
        if came.is_none()
            && let Some(repeat_ms) = line.repeat_ms
        {
            operator.again_ms = Some(now_ms + repeat_ms);
            return;
        }
        *operator = Operator { done: operator.done + 1, ..Operator::default() };
        if let Some(wanted) = &line.answer {
            let passed = match &came {
                Some(came) => answers_so(came, wanted),
                None => wanted == "none",
            };
            let came = came.map_or_else(|| text::NoAnswer.words(), Words::same);
            self.answers[index] = Some(self.answer_check(line, passed, came));
        }
    }

    fn answer_check(&self, line: &OperatorLine, passed: bool, came: Words) -> Check {
        let name = &self.director.exercise().monitors[line.monitor].name;
        let request = &line.request;
        let text = match line.answer.as_deref() {
            None => Words::same(format!("{name}: {request}")),
            Some("none") => text::RequestWithoutAnswer { monitor: name, request }.words(),
            Some(answer) => Words::same(format!("{name}: {request} → {answer}")),
        };
        Check {
            line: line.line,
            is_answer: true,
            text,
            passed,
            at_ms: self.director.now_ms(),
            came,
        }
    }

    fn finish(mut self, trace: String) -> Outcome {
        self.look();
        self.checks.look(&mut self.director, true);
        let exercise = Arc::clone(self.director.exercise());
        let undone = if self.automatic { self.operators.len() } else { 0 };
        for monitor in 0..undone {
            let own = exercise.operator.iter().enumerate().filter(|(_, it)| it.monitor == monitor);
            for (index, line) in own.skip(self.operators[monitor].done) {
                let came = text::TurnNeverCame.words();
                self.answers[index] = Some(self.answer_check(line, false, came));
            }
        }
        for (index, figures) in self.monitors.iter_mut().enumerate() {
            figures.counts = self.log.counts[index];
            figures.litres = self.director.site.members[index].litres;
        }
        let mut checks: Vec<Check> = self.answers.into_iter().flatten().collect();
        checks.extend(self.checks.finish());
        Outcome {
            exercise,
            seed: self.seed,
            lines: self.log.lines,
            checks,
            monitors: self.monitors,
            fires: self.fires,
            recording: self.recording,
            trace,
        }
    }
}

/// Whether an answer, as text, has the status that was wanted.
fn answers_so(came: &str, wanted: &str) -> bool {
    let status = came.rsplit_once("→ ").map_or(came, |(_, status)| status);
    let status = status.split(':').next().unwrap_or(status).trim();
    status == wanted.trim()
}

/// The status words of all subsystems of a monitor; none without power.
fn statuses(site: &mut Site, monitor: usize) -> Vec<(SubsystemId, u32)> {
    let mut buffer = [0; 16];
    let mut writer = Writer::new(&mut buffer);
    if Request::new(SubsystemId::ALL, Body::GetStatus).encode(&mut writer).is_err() {
        return Vec::new();
    }
    let sim = &mut site.members[monitor].sim;
    let answers = sim.request(lafet_device::Source::ExternalConn, writer.written());
    let status = |record| {
        let answer = Answer::decode(&record).ok()?;
        Some((answer.from, answer.data.flags_bits()?))
    };
    Records::new(&answers).flatten().filter_map(status).collect()
}

/// Whether a change of a flag is worth a line: motion and its ends come and go all the time.
fn is_news(subsystem: SubsystemId, flag: &SetFlag) -> bool {
    let name = flag.info.name;
    let ordinary = [
        "Move",
        "Opening",
        "Closing",
        "Deploying",
        "Wrapping",
        "MinLimitReached",
        "MaxLimitReached",
        "AbsoluteMinLimitReached",
        "AbsoluteMaxLimitReached",
    ];
    let idle = matches!(subsystem, SubsystemId::EXTERNAL_CONN | SubsystemId::RADIO);
    !ordinary.contains(&name) || (idle && name != "ConnLost")
}
