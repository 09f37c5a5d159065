//! A simulated site for the hub: scenarios, faults and fires on demand, and the score.

use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lafet_device::Source;
use lafet_hub::MonitorConfig;
use lafet_hub::simulation::{
    self, Act, Check, CheckState, LinkState, Loaded, Scenario, Scene, Simulated, Simulation,
};
use lafet_hub::text::{Both, both};
use lafet_sim::exercise::{self, Action, Exercise, Lang, Link, Outcome, Run, SHIPPED, Shipped};
use lafet_sim::fault::Fault;
use lafet_texts::{Fixed, Text, cli as text};
use serde_json::Value;

use super::{faults, scene};
use crate::serve::{Bus, Wire};

/// Simulated time before the first request, in which the monitors read their sensors, ms.
const POWER_UP_MS: u64 = 200;
/// Interval at which the hub polls the monitors, ms.
const POLL_MS: u64 = 100;
/// Step of the simulation, ms.
const STEP_MS: u64 = lafet_sim::world::STEP_MS;

/// A simulated site, shared by its bus and the hub.
#[derive(Clone)]
pub struct Training(Arc<Mutex<State>>);

struct State {
    scenario: &'static str,
    run: Run,
    /// Number of scenarios started so far.
    number: u64,
    seed: u64,
    automatic: bool,
    paused: bool,
    speed: f64,
    due_ms: f64,
    /// The final score, once the time of the scenario is over.
    outcome: Option<Outcome>,
    /// Number of log lines already reported.
    told: usize,
    /// Address on which its monitors listen.
    place: String,
}

impl Training {
    /// Loads a scenario; its monitors listen at `place`.
    pub fn new(scenario: &str, seed: Option<u64>, place: &str) -> Result<Self, Both> {
        let (scenario, exercise) = find(scenario)?;
        let seed = seed.unwrap_or(exercise.site.seed);
        let run = start(&exercise, seed, false);
        Ok(Self(Arc::new(Mutex::new(State {
            scenario,
            run,
            number: 1,
            seed,
            automatic: false,
            paused: false,
            speed: 1.0,
            due_ms: 0.0,
            outcome: None,
            told: 0,
            place: place.to_owned(),
        }))))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The monitors and the site of the loaded scenario.
    pub fn loaded(&self) -> Result<Loaded, Both> {
        let state = self.lock();
        let exercise = state.run.director().exercise();
        let monitors = monitors(exercise, &state.place)?;
        Ok(Loaded { monitors, site: Some(scene::site(exercise)) })
    }

    /// State that only the simulation knows.
    pub fn scene(&self) -> Scene {
        let state = self.lock();
        let speed = if state.paused { 0.0 } else { state.speed };
        scene::scene(state.run.director(), speed)
    }

    /// Events since the last call: the monitor concerned, and the text.
    pub fn news(&self) -> Vec<(Option<String>, Both)> {
        let mut state = self.lock();
        if state.outcome.is_some() {
            let director = state.run.director_mut();
            let mut all = director.take_happened();
            all.extend(director.take_fires());
            return all.into_iter().map(|(_, it)| (None, text(&it))).collect();
        }
        let exercise = state.run.director().exercise();
        let name = |index: usize| exercise.monitors.get(index).map(|it| it.name.clone());
        let lines = state.run.lines();
        // The hub itself sees the monitors' requests and answers.
        use exercise::Kind;
        let ours = |kind| matches!(kind, Kind::Event | Kind::Fire | Kind::Plant | Kind::Note);
        let news = lines.iter().skip(state.told).filter(|line| ours(line.kind));
        let news = news.map(|line| (line.monitor.and_then(name), text(&line.text))).collect();
        state.told = lines.len();
        news
    }
}

impl State {
    fn advance(&mut self, ms: u64) {
        if self.paused {
            return;
        }
        self.due_ms += ms as f64 * self.speed;
        while self.due_ms >= STEP_MS as f64 {
            self.due_ms -= STEP_MS as f64;
            self.run.tick();
            if self.outcome.is_none() && self.run.is_over() {
                self.outcome = Some(self.run.outcome());
            }
        }
    }

    fn monitor(&self, name: &str) -> Result<usize, Both> {
        let monitors = &self.run.director().exercise().monitors;
        let found = monitors.iter().position(|monitor| monitor.name == name);
        found.ok_or_else(|| none(text::KindMonitor, name))
    }

    fn act(&mut self, act: &Act) -> Result<(), Both> {
        let action = match act {
            Act::Automatic(on) => {
                self.automatic = *on;
                self.run.set_automatic(*on);
                return Ok(());
            }
            Act::Pause(paused) => {
                self.paused = *paused;
                return Ok(());
            }
            Act::Speed(speed) => {
                self.speed = *speed;
                return Ok(());
            }
            Act::Fire { at: [x, y], size, kind } => {
                let lit = self.run.light((*x, *y), *size, kind);
                return lit.map(|_| ()).ok_or_else(|| text::FireKindUnknown { kind }.words());
            }
            Act::Ignite(name) => {
                let fires = &self.run.director().exercise().fires;
                let found = fires.iter().position(|fire| fire.name == *name);
                Action::Ignite(found.ok_or_else(|| none(text::KindFire, name))?)
            }
            Act::Link { monitor, up } => {
                let link = if *up { Link::Up } else { Link::Lost };
                Action::Link(self.monitor(monitor)?, Source::ExternalConn, link)
            }
            Act::Fault { monitor, fault, on } => {
                let monitor = self.monitor(monitor)?;
                match Fault::from_name(fault) {
                    Some(fault) if *on => Action::Inject(monitor, fault),
                    Some(fault) => Action::Clear(monitor, Some(fault)),
                    None if fault == "all" && !on => Action::Clear(monitor, None),
                    None => return Err(none(text::KindFault, fault)),
                }
            }
        };
        self.run.director_mut().act(action);
        Ok(())
    }

    fn shown(&self) -> simulation::State {
        let director = self.run.director();
        let exercise = director.exercise();
        let members = exercise.monitors.iter().zip(&director.site.members).enumerate();
        let monitors = members.map(|(index, (plan, member))| {
            let faults = member.sim.world().faults.active();
            let link = match director.link(index, Source::ExternalConn) {
                Link::Up => LinkState::Up,
                Link::Lost => LinkState::Lost,
                Link::AnswersLost => LinkState::AnswersLost,
            };
            let faults = faults.iter().map(|fault| fault.name()).collect();
            (plan.name.clone(), Simulated { faults, link })
        });
        simulation::State {
            scenario: self.scenario.to_owned(),
            run: self.number,
            seed: self.seed,
            automatic: self.automatic,
            t_s: seconds(director.now_ms()),
            duration_s: seconds(exercise.duration_ms),
            over: self.outcome.is_some(),
            paused: self.paused,
            speed: self.speed,
            monitors: monitors.collect(),
            score: self.checks().into(),
        }
    }

    fn checks(&self) -> Vec<Check> {
        let Some(outcome) = &self.outcome else {
            let checks = self.run.checks();
            let open = checks.iter().map(|(text_of, check)| {
                let (text, state) = (text(text_of), CheckState::Open);
                let open = || Check { text, state, at_s: None, came: None };
                check.as_ref().map_or_else(open, decided)
            });
            return open.collect();
        };
        outcome.checks.iter().map(decided).collect()
    }
}

impl Simulation for Training {
    fn catalogue(&self) -> (Vec<Scenario>, Vec<simulation::Fault>) {
        let scenario = |shipped: &Shipped| {
            let exercise = shipped.exercise().ok()?;
            Some(Scenario {
                id: shipped.name.to_owned(),
                title: text(&exercise.title),
                about: text(&exercise.about),
                duration_s: seconds(exercise.duration_ms),
                monitors: exercise.monitors.iter().map(|it| it.name.clone()).collect(),
            })
        };
        (SHIPPED.iter().filter_map(scenario).collect(), faults::catalogue())
    }

    fn state(&self) -> simulation::State {
        self.lock().shown()
    }

    fn speed(&self) -> f64 {
        self.lock().speed
    }

    fn load(&self, scenario: &str, seed: Option<u64>, automatic: bool) -> Result<Loaded, Both> {
        let (scenario, exercise) = find(scenario)?;
        let seed = seed.unwrap_or(exercise.site.seed);
        let mut state = self.lock();
        let loaded = Loaded {
            monitors: monitors(&exercise, &state.place)?,
            site: Some(scene::site(&exercise)),
        };
        state.run = start(&exercise, seed, automatic);
        (state.scenario, state.seed, state.automatic) = (scenario, seed, automatic);
        (state.outcome, state.told, state.due_ms, state.paused) = (None, 0, 0.0, false);
        state.number += 1;
        Ok(loaded)
    }

    fn act(&self, act: &Act) -> Result<(), Both> {
        self.lock().act(act)
    }

    fn commanded(&self, monitor: &str, request: &str) {
        let mut state = self.lock();
        if let Ok(monitor) = state.monitor(monitor) {
            state.run.commanded(monitor, request);
        }
    }

    fn report(&self) -> Value {
        exercise::json(&self.outcome())
    }

    fn picture(&self, russian: bool) -> String {
        exercise::svg(&self.outcome(), if russian { Lang::Ru } else { Lang::En })
    }
}

impl Training {
    /// The outcome, or what it would be if the exercise ended now.
    fn outcome(&self) -> Outcome {
        let state = self.lock();
        if let Some(outcome) = &state.outcome {
            return outcome.clone();
        }
        // Commands must not wait while a report is made.
        let run = state.run.clone();
        drop(state);
        run.outcome()
    }
}

impl Bus for Training {
    fn receive(&self, wire: &mut Wire, bytes: &[u8]) -> Vec<u8> {
        let mut state = self.lock();
        let director = state.run.director_mut();
        let mut answers = Vec::new();
        for index in 0..director.site.members.len() {
            let link = director.link(index, wire.source());
            if link == Link::Lost {
                continue;
            }
            let own = wire.receive(index, &mut director.site.members[index].sim, bytes);
            if link == Link::Up {
                answers.extend(own);
            }
        }
        answers
    }

    fn datagram(&self, _: Source, _: &[u8]) -> Option<Vec<u8>> {
        None
    }

    fn advance_ms(&self, ms: u64) {
        self.lock().advance(ms);
    }
}

impl fmt::Debug for Training {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Training")
    }
}

fn find(scenario: &str) -> Result<(&'static str, Arc<Exercise>), Both> {
    let shipped = Shipped::by_name(scenario).ok_or_else(|| none(text::KindScenario, scenario))?;
    let exercise = shipped.exercise().map_err(|_| none(text::KindScenario, scenario))?;
    Ok((shipped.name, Arc::new(exercise)))
}

fn start(exercise: &Arc<Exercise>, seed: u64, automatic: bool) -> Run {
    let mut run = Run::new(exercise, seed);
    run.set_automatic(automatic);
    for _ in 0..POWER_UP_MS / STEP_MS {
        run.tick();
    }
    run
}

fn monitors(exercise: &Exercise, place: &str) -> Result<Vec<MonitorConfig>, Both> {
    let one = |(plan, monitor): (&exercise::MonitorPlan, &lafet_sim::site::MonitorConfig)| {
        let url = format!("{place}?addr={}", monitor.sim.address);
        let endpoint = url.parse().map_err(|_| none(text::KindPlace, &url))?;
        let name = side(monitor.pose.at);
        Ok(MonitorConfig { id: plan.name.clone(), name, endpoint, poll_ms: POLL_MS })
    };
    exercise.monitors.iter().zip(&exercise.site.monitors).map(one).collect()
}

/// Title of a monitor: the side of the site on which it is placed.
fn side((east, north): (f64, f64)) -> Both {
    const SIDES: [Fixed; 8] = [
        text::SideNorth.fixed(),
        text::SideNorthEast.fixed(),
        text::SideEast.fixed(),
        text::SideSouthEast.fixed(),
        text::SideSouth.fixed(),
        text::SideSouthWest.fixed(),
        text::SideWest.fixed(),
        text::SideNorthWest.fixed(),
    ];
    if east.hypot(north) < 1.0 {
        return text::SideMiddle.words();
    }
    let eighths = (east.atan2(north).to_degrees() / 45.0).round().rem_euclid(8.0);
    SIDES.get(eighths as usize).unwrap_or(&SIDES[0]).words()
}

fn decided(check: &exercise::Check) -> Check {
    Check {
        text: text(&check.text),
        state: if check.passed { CheckState::Passed } else { CheckState::Failed },
        at_s: Some(seconds(check.at_ms)),
        came: Some(text(&check.came)),
    }
}

fn text(text: &exercise::Words) -> Both {
    both(text.en.trim(), text.ru.trim())
}

fn none(kind: impl Text, name: &str) -> Both {
    text::NoSuchOne { kind, name }.words()
}

fn seconds(ms: u64) -> f64 {
    ms as f64 / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn training(scenario: &str) -> Training {
        Training::new(scenario, Some(7), "tcp://127.0.0.1:1").unwrap()
    }

    #[test]
    fn a_scenario_that_acts_by_itself_is_that_of_sim_run() {
        let training = training("tank-farm");
        training.load("two-fires", None, true).unwrap();
        training.act(&Act::Speed(20.0)).unwrap();
        let whole_ms = 8 * 60 * 1000;
        training.advance_ms(whole_ms / 20 + 10);
        let state = training.state();
        assert_eq!((state.over, state.run), (true, 2));
        let (_, exercise) = find("two-fires").unwrap();
        let run = exercise::run(&exercise, exercise.site.seed, false);
        assert_eq!(training.report()["passed"], Value::from(run.passed()));
        assert_eq!(training.report()["fires"], exercise::json(&run)["fires"]);
        assert_eq!(state.score.open, 0);
    }

    #[test]
    fn people_act_and_what_they_send_counts() {
        let training = training("tank-farm");
        training.advance_ms(40_000);
        let found = |training: &Training| {
            let checks = training.state().score.checks;
            checks.iter().find(|it| it.text.en.contains("a minute")).unwrap().state
        };
        assert_eq!(found(&training), CheckState::Open);
        training.commanded("M2", "StartSeek Detector -100 100 0 10");
        training.commanded("M1", "StartSeek Control");
        training.advance_ms(61_000);
        assert_eq!(found(&training), CheckState::Open, "no alarm has been given");
        training.commanded("M1", "StartSeek Detector -100 100 0 10");
        training.advance_ms(61_000);
        assert_eq!(
            found(&training),
            CheckState::Failed,
            "a minute after the alarm nothing was found"
        );
        training.act(&Act::Pause(true)).unwrap();
        let at = training.state().t_s;
        training.advance_ms(5000);
        assert_eq!(training.state().t_s, at);
    }

    #[test]
    fn faults_links_and_fires() {
        let training = training("hangar");
        let fault = |fault: &str, on| {
            let (monitor, fault) = ("M1".to_owned(), fault.to_owned());
            training.act(&Act::Fault { monitor, fault, on })
        };
        fault("vertical-jam", true).unwrap();
        training.act(&Act::Link { monitor: "M2".into(), up: false }).unwrap();
        let monitors = training.state().monitors;
        let jammed = Simulated { faults: vec!["vertical-jam".into()], link: LinkState::Up };
        let lost = Simulated { faults: vec![], link: LinkState::Lost };
        assert_eq!((&monitors["M1"], &monitors["M2"]), (&jammed, &lost));
        fault("all", false).unwrap();
        assert!(training.state().monitors["M1"].faults.is_empty());
        assert!(fault("all", true).is_err() && fault("teapot", true).is_err());
        let fires = training.scene().fires.len();
        let fire = |kind: &str| Act::Fire { at: [3.0, 4.0], size: 2.0, kind: kind.into() };
        training.act(&fire("spray")).unwrap();
        assert!(training.act(&fire("candle")).is_err());
        training.advance_ms(1000);
        let scene = training.scene();
        assert_eq!(scene.fires.len(), fires + 1);
        assert!(scene.fires[fires].burns);
        assert!(training.act(&Act::Ignite("nothing".into())).is_err());
        training.report();
        assert!(training.picture(true).starts_with("<svg"));
    }
}
