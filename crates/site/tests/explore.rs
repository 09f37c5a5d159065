//! The states of a small site, explored: 3 detectors, 2 zones, 2 monitors, faults and hands.
//!
//! Time goes by in steps of a second, to which all times of the site are multiples. After each event the oracle
//! judges; machines with one wrong rule each show that it can.

mod oracle;

use std::collections::{HashSet, VecDeque};
use std::hash::{DefaultHasher, Hash, Hasher};

use lafet_site::rules::Rules;
use lafet_site::{
    Authority, Bypass, Condition, Config, Event, Hand, Mode, MonitorReport, Order, Reaction, Scope,
    Signal, Site, Valve,
};
use oracle::{Oracle, Seen};

const SECOND: u64 = 1000;

fn config() -> Config {
    toml::from_str(
        r#"
        monitors = ["m1", "m2"]
        detector = [
            { id = "d1", kind = "flame", zones = ["a", "b"], silent_after_s = 2 },
            { id = "d2", kind = "heat", zones = ["a", "b"], silent_after_s = 2 },
            { id = "d3", kind = "flame", zones = ["a", "b"], silent_after_s = 2 },
        ]
        input = [
            { id = "abort", kind = "abort", zones = ["a"], debounce_ms = 0 },
            { id = "stop", kind = "stop", zones = ["b"], debounce_ms = 0 },
            { id = "gauge", kind = "pressure", debounce_ms = 0 },
        ]
        output = [{ id = "va", kind = "valve" }]
        pump = [
            { id = "p1", pressure = "gauge", start_timeout_s = 2 },
            { id = "p2", start_delay_s = 1 },
            { id = "p3", standby = true },
        ]
        [[zone]]
        id = "a"
        votes = "2oo3"
        kinds = 2
        when_failed = ["2oo2"]
        coincidence_s = 1
        delay_s = 1
        hold_max_s = 1
        water_max_s = 3
        return_after_s = 3
        act_within_s = 300
        monitors = ["m1", "m2"]
        jets = 1
        valve = "va"
        [[zone]]
        id = "b"
        votes = "2oo3"
        coincidence_s = 1
        water_max_s = 2
        act_within_s = 300
        monitors = ["m2"]
        "#,
    )
    .unwrap()
}

/// A step of the exploration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Act {
    Second,
    Signal(usize),
    Fault,
    Dead,
    Mask,
    Abort,
    AbortContact,
    StopContact,
    Stop,
    CloseMonitor,
    OwnLockout,
    PersonOpens,
    PumpOff,
    Release(&'static str),
    Hold,
    Mode(Mode),
    Lockout,
    Reset,
    Lost,
    Person,
    Gauge,
    Restart,
}

const ACTS: [Act; 27] = [
    Act::Second,
    Act::Signal(0),
    Act::Signal(1),
    Act::Signal(2),
    Act::Fault,
    Act::Dead,
    Act::Mask,
    Act::Abort,
    Act::AbortContact,
    Act::StopContact,
    Act::Stop,
    Act::CloseMonitor,
    Act::OwnLockout,
    Act::PersonOpens,
    Act::PumpOff,
    Act::Release("a"),
    Act::Release("b"),
    Act::Hold,
    Act::Mode(Mode::Manual),
    Act::Mode(Mode::Off),
    Act::Mode(Mode::TestDry),
    Act::Lockout,
    Act::Reset,
    Act::Lost,
    Act::Person,
    Act::Gauge,
    Act::Restart,
];

/// The world around the machine.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct Around {
    alarm: [bool; 3],
    fault: bool,
    dead: bool,
    masked: bool,
    abort: bool,
    stop: bool,
    held: bool,
    locked: bool,
    /// The own lockout of the first monitor.
    own: bool,
    lost: bool,
    person: bool,
    gauge: bool,
    /// What the monitors will do by the next second.
    ordered: [Option<bool>; 2],
    open: [bool; 2],
}

#[derive(Clone)]
struct World {
    now: u64,
    site: Site,
    oracle: Oracle,
    around: Around,
}

struct Run {
    config: Config,
    rules: Rules,
    seen: Seen,
}

impl Run {
    fn new(rules: Rules) -> Self {
        Self { config: config(), rules, seen: Seen::new() }
    }

    fn first(&mut self) -> World {
        let (site, _) = Site::with_rules(self.config.clone(), 0, None, self.rules).unwrap();
        let oracle = Oracle::new(&self.config);
        let mut world = World { now: 0, site, oracle, around: Around::default() };
        self.reports(&mut world).unwrap();
        world
    }

    /// What is read after a start and in every second.
    fn reports(&mut self, world: &mut World) -> Result<(), String> {
        for index in 0..3 {
            if !(index == 1 && world.around.dead) {
                let event = self.detector(world, index);
                self.event(world, &event)?;
            }
        }
        for index in 0..2 {
            let event = self.monitor(world, index);
            self.event(world, &event)?;
        }
        Ok(())
    }

    fn detector(&self, world: &World, index: usize) -> Event {
        let fault = index == 0 && world.around.fault;
        Event::Detector {
            detector: self.config.detectors[index].id.clone(),
            signal: if world.around.alarm[index] { Signal::Alarm } else { Signal::Quiet },
            condition: if fault { Condition::Fault } else { Condition::Ready },
        }
    }

    fn monitor(&self, world: &World, index: usize) -> Event {
        let Around { open, lost, person, own, .. } = world.around;
        let person = index == 0 && person;
        let report = MonitorReport {
            reachable: !(index == 0 && lost),
            authority: if person { Authority::Person } else { Authority::Free },
            lockout: index == 0 && own,
            valve: if open[index] { Valve::Open } else { Valve::Closed },
            ..MonitorReport::default()
        };
        Event::Monitor { monitor: self.config.monitors[index].clone(), report }
    }

    fn event(&mut self, world: &mut World, event: &Event) -> Result<(), String> {
        world.oracle.event(&self.config, event);
        let reaction = world.site.handle(world.now, event);
        self.judge(world, &reaction)
    }

    fn judge(&mut self, world: &mut World, reaction: &Reaction) -> Result<(), String> {
        for command in &reaction.commands {
            let (monitor, open) = match &command.order {
                Order::Engage { monitor, .. } => (monitor, true),
                Order::Close { monitor } => (monitor, false),
                _ => continue,
            };
            let index = self.config.monitors.iter().position(|it| it == monitor).unwrap();
            world.around.ordered[index] = Some(open);
        }
        world.oracle.judge(&self.config, reaction, &world.site.state(), &mut self.seen)
    }

    fn hand(&mut self, world: &mut World, order: Hand) -> Result<(), String> {
        self.event(world, &Event::Hand { by: "x".to_owned(), order })
    }

    fn contact(&mut self, world: &mut World, input: &str, pressed: bool) -> Result<(), String> {
        self.event(world, &Event::Contact { input: input.to_owned(), pressed })
    }

    fn act(&mut self, world: &mut World, act: Act) -> Result<(), String> {
        let a = || "a".to_owned();
        match act {
            Act::Second => self.second(world),
            Act::Signal(index) => {
                world.around.alarm[index] ^= true;
                if index == 1 && world.around.dead {
                    return Ok(());
                }
                let event = self.detector(world, index);
                self.event(world, &event)
            }
            Act::Fault => {
                world.around.fault ^= true;
                let event = self.detector(world, 0);
                self.event(world, &event)
            }
            Act::Dead => {
                world.around.dead ^= true;
                Ok(())
            }
            Act::Mask => {
                world.around.masked ^= true;
                let bypass = if world.around.masked { Bypass::Masked } else { Bypass::None };
                self.hand(world, Hand::Bypass { detector: "d3".to_owned(), bypass })
            }
            Act::Abort => {
                self.seen.insert("abort");
                self.hand(world, Hand::Abort { zone: a() })
            }
            Act::AbortContact => {
                world.around.abort ^= true;
                self.contact(world, "abort", world.around.abort)
            }
            Act::StopContact => {
                world.around.stop ^= true;
                self.contact(world, "stop", world.around.stop)
            }
            Act::PumpOff => self.hand(world, Hand::Pump { pump: "p1".to_owned(), on: false }),
            Act::PersonOpens if !world.around.person || world.around.lost => Ok(()),
            Act::Stop => self.hand(world, Hand::Stop(Scope::Site)),
            Act::CloseMonitor => self.hand(world, Hand::Close(Scope::Monitor("m1".to_owned()))),
            Act::Release(zone) => self.hand(world, Hand::Release { zone: zone.to_owned() }),
            Act::Hold => {
                world.around.held ^= true;
                let on = world.around.held;
                self.hand(world, Hand::Hold { zone: a(), on })
            }
            Act::Mode(mode) => {
                self.hand(world, Hand::Mode { zone: a(), mode, for_s: mode.is_test().then_some(3) })
            }
            Act::Lockout => {
                world.around.locked ^= true;
                let on = world.around.locked;
                self.hand(world, Hand::Lockout { on })
            }
            Act::Reset => self.hand(world, Hand::Reset(Scope::Site)),
            Act::Lost | Act::Person | Act::OwnLockout | Act::PersonOpens => {
                world.around.open[0] ^= act == Act::PersonOpens;
                world.around.lost ^= act == Act::Lost;
                world.around.own ^= act == Act::OwnLockout;
                world.around.person ^= act == Act::Person;
                let event = self.monitor(world, 0);
                self.event(world, &event)
            }
            Act::Gauge => {
                world.around.gauge ^= true;
                self.contact(world, "gauge", world.around.gauge)
            }
            Act::Restart => self.restart(world),
        }
    }

    fn second(&mut self, world: &mut World) -> Result<(), String> {
        let before: Vec<Mode> = world.site.state().zones.iter().map(|it| it.mode).collect();
        world.now += SECOND;
        world.oracle.pass(&self.config, SECOND);
        for index in 0..2 {
            let lost = index == 0 && world.around.lost;
            if let Some(open) = world.around.ordered[index].filter(|_| !lost) {
                world.around.open[index] = open;
                world.around.ordered[index] = None;
            }
        }
        // A report at the time of a deadline comes before it.
        self.reports(world)?;
        let reaction = world.site.step(world.now);
        if !reaction.commands.is_empty() {
            return Err("a step after an event at the same time does more".to_owned());
        }
        let state = world.site.state();
        if before.iter().zip(&state.zones).any(|(old, it)| *old != it.mode) {
            self.seen.insert("mode returns");
        }
        Ok(())
    }

    fn restart(&mut self, world: &mut World) -> Result<(), String> {
        let stored = world.site.persisted();
        let made = Site::with_rules(self.config.clone(), world.now, Some(&stored), self.rules);
        let (site, reaction) = made.unwrap();
        if !reaction.commands.is_empty() {
            return Err(format!("a start acts: {:?}", reaction.commands));
        }
        world.site = site;
        world.oracle.restart();
        world.around.held = false;
        world.around.ordered = [None; 2];
        if world.around.open[1] {
            self.seen.insert("water found");
        }
        let Around { abort, stop, gauge, .. } = world.around;
        for (input, pressed) in [("abort", abort), ("stop", stop), ("gauge", gauge)] {
            self.contact(world, input, pressed)?;
        }
        self.reports(world)
    }
}

fn key(world: &World) -> u64 {
    let mut hash = DefaultHasher::new();
    world.site.fingerprint(&mut hash);
    (&world.oracle, &world.around).hash(&mut hash);
    hash.finish()
}

/// Explores breadth first from a few situations; the number of states, or what went wrong and how.
fn explore(run: &mut Run, most: usize) -> Result<usize, String> {
    let first = run.first();
    let mut known = HashSet::from([key(&first)]);
    let mut paths: Vec<(usize, Option<Act>)> = vec![(0, None)];
    let mut queue = VecDeque::from([(0, first)]);
    while let Some((from, world)) = queue.pop_front() {
        for act in ACTS {
            let mut next = world.clone();
            if let Err(what) = run.act(&mut next, act) {
                return Err(format!("{what}\nafter {:?} {act:?}", path(&paths, from)));
            }
            if known.len() < most && known.insert(key(&next)) {
                paths.push((from, Some(act)));
                queue.push_back((paths.len() - 1, next));
            }
        }
    }
    Ok(known.len())
}

fn path(paths: &[(usize, Option<Act>)], mut at: usize) -> Vec<Act> {
    let mut acts = Vec::new();
    while let (from, Some(act)) = paths[at] {
        acts.push(act);
        at = from;
    }
    acts.reverse();
    acts
}

/// A small generator, so that a seed gives the same walk everywhere.
fn random(seed: &mut u64) -> usize {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 33) as usize
}

/// Random walks: deep where the exploration is wide. Half of the steps are seconds and signals.
fn walks(run: &mut Run, seeds: std::ops::Range<u64>, length: usize) -> Result<(), String> {
    let first = run.first();
    for seed in seeds {
        let mut state = seed;
        let mut world = first.clone();
        let mut acts = Vec::new();
        for _ in 0..length {
            let roll = random(&mut state);
            let act = match roll % 5 {
                0 | 1 => Act::Second,
                2 => ACTS[1 + roll / 5 % 3],
                _ => ACTS[roll / 5 % ACTS.len()],
            };
            acts.push(act);
            if let Err(what) = run.act(&mut world, act) {
                return Err(format!("seed {seed}: {what}\nafter {acts:?}"));
            }
        }
    }
    Ok(())
}

const CAPABILITIES: [&str; 15] = [
    "a hand takes from votes",
    "a no lapses",
    "a person's water",
    "a test ends among votes",
    "abort",
    "degraded vote",
    "greatest duration",
    "hold",
    "mode returns",
    "pump replaced",
    "pumps in sequence",
    "release by vote",
    "water by hand",
    "water by vote",
    "water found",
];

fn all_seen(run: &Run) {
    for capability in CAPABILITIES {
        assert!(run.seen.contains(capability), "never seen: {capability}");
    }
}

#[test]
fn a_part_of_the_states() {
    let mut run = Run::new(Rules::RIGHT);
    let states = explore(&mut run, 12_000).unwrap_or_else(|what| panic!("{what}"));
    assert_eq!(states, 12_000);
}

#[test]
#[ignore = "minutes: all states up to 1.5 million"]
fn more_than_a_million_states() {
    let mut run = Run::new(Rules::RIGHT);
    let states = explore(&mut run, 1_500_000).unwrap_or_else(|what| panic!("{what}"));
    println!("{states} states, {:?}", run.seen);
    assert!(states >= 1_000_000, "{states}");
}

#[test]
fn random_walks_keep_the_order_and_show_every_capability() {
    let mut run = Run::new(Rules::RIGHT);
    walks(&mut run, 0..1000, 100).unwrap_or_else(|what| panic!("{what}"));
    all_seen(&run);
}

#[test]
#[ignore = "minutes: 10 million steps"]
fn many_random_walks() {
    let mut run = Run::new(Rules::RIGHT);
    walks(&mut run, 0..50_000, 200).unwrap_or_else(|what| panic!("{what}"));
    all_seen(&run);
}

/// A machine with one wrong rule, and the change that makes it.
type Wrong = (&'static str, fn(&mut Rules));

const WRONG: [Wrong; 27] = [
    ("a vote may be missing", |r| r.missing_votes = 1),
    ("a faulty detector votes", |r| r.fault_has_no_vote = false),
    ("a silent detector votes", |r| r.silent_has_no_vote = false),
    ("a masked detector votes", |r| r.masked_has_no_vote = false),
    ("an old alarm votes", |r| r.stale_has_no_vote = false),
    ("a failure changes nothing", |r| r.failure_reduces = false),
    ("kinds do not count", |r| r.kinds_count = false),
    ("no coincidence", |r| r.coincidence = false),
    ("no delay", |r| r.delay = false),
    ("no hold", |r| r.hold = false),
    ("an endless hold", |r| r.hold_ends = false),
    ("a no is forgotten", |r| r.no_lasts = false),
    ("a no does not end water", |r| r.no_ends_water = false),
    ("abort does not bind a hand", |r| r.abort_before_hand = false),
    ("lockout does not bind a hand", |r| r.lockout_before_hand = false),
    ("Close is said once", |r| r.close_repeats = false),
    ("endless water", |r| r.water_ends = false),
    ("the mode does not count", |r| r.mode_counts = false),
    ("the mode never returns", |r| r.mode_returns = false),
    ("a wet test", |r| r.test_is_dry = false),
    ("a person's monitor is taken", |r| r.person_keeps = false),
    ("manual binds a hand", |r| r.hand_is_free = false),
    ("a lost monitor is not replaced", |r| r.lost_is_replaced = false),
    ("pumps start at once", |r| r.pumps_wait = false),
    ("a failed pump is not replaced", |r| r.pump_is_replaced = false),
    ("a start closes", |r| r.start_is_inert = false),
    ("a test keeps water from a hand", |r| r.hand_ends_test = false),
];

#[test]
fn every_wrong_machine_is_found() {
    for (name, change) in WRONG {
        let mut rules = Rules::RIGHT;
        change(&mut rules);
        let mut run = Run::new(rules);
        let found = walks(&mut run, 0..3000, 100);
        assert!(found.is_err(), "not found: {name}");
    }
}

#[test]
fn a_no_that_does_not_outlast_a_hand_is_found() {
    let rules = Rules { no_holds_ms: 0, ..Rules::RIGHT };
    assert!(walks(&mut Run::new(rules), 0..3000, 100).is_err());
    let rules = Rules { repeat_ms: 5000, ..Rules::RIGHT };
    assert!(walks(&mut Run::new(rules), 0..3000, 100).is_err());
}
