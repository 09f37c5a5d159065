//! The oracle: what a site may and must do, computed from the events alone.
//!
//! It shares the types of events and commands with the machine, and none of its code. It keeps times as ages,
//! so two histories that make no difference any more are equal.

mod supply;

use lafet_site::config::Reduced;
use lafet_site::{
    Authority, Bypass, Condition, Config, Event, Hand, Mode, MonitorReport, Order, Phase, Reaction,
    Scope, Signal, State, Valve,
};

/// Older is old.
const OLD: u64 = 20_000;
/// A no and a release by hand at this distance are simultaneous.
const SIMULTANEOUS: u64 = 2000;
const REPEAT: u64 = 1000;
/// What opens is void if it was not delivered within this time.
const VALID: u64 = 2000;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
struct Eye {
    signal: Option<Signal>,
    condition: Condition,
    heard: u64,
    stale: bool,
    bypass: Bypass,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
struct Area {
    mode: Mode,
    mode_left: Option<u64>,
    /// A no: its age, and whether a person said it.
    no: Option<(u64, bool)>,
    /// Time without alarm or water.
    quiet: u64,
    /// Enough votes for so long while nothing else kept the release back.
    met: Option<u64>,
    held: u64,
    holds: bool,
    /// A test has just ended by itself.
    tested: bool,
    /// In force: by votes, and for so long; dry in a test.
    force: Option<(bool, u64, bool)>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
struct Barrel {
    report: MonitorReport,
    works_for: Option<usize>,
    refused: Option<u64>,
    /// Closed so long ago, and not confirmed yet.
    closing: Option<u64>,
    /// Its valve was reported closed since then.
    shut: bool,
    /// The zone that a person has released since then: it need not wait for the end of that Close.
    yields: Option<usize>,
    /// Water that was ordered by votes or before the start, and works for no zone now, for so long.
    found: Option<u64>,
    /// Its water was ordered by votes.
    ours: bool,
    /// Its water was ordered, by votes or for a release by hand.
    given: bool,
    /// A person began its water.
    hand: bool,
    /// The zone from which a person took it.
    lent: Option<usize>,
    /// A person took it so long ago, before its order had opened it: that may be on its way.
    coming: Option<u64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
struct Motor {
    on: Option<u64>,
    dry: u64,
    /// A person keeps it off, and for so long while it is needed.
    off: Option<u64>,
    /// A person has stopped it so long ago, up to what is simultaneous.
    stopped: u64,
}

impl Barrel {
    /// It is opened after a Close: it begins to open, or is open after it was closed.
    fn opens(&mut self, report: &MonitorReport) -> bool {
        let before = self.report;
        self.shut |= report.reachable && report.valve == Valve::Closed;
        let begins = report.valve == Valve::Opening && before.valve != Valve::Opening;
        let is_open = self.shut && report.valve == Valve::Open;
        before.reachable && before.valve != Valve::Open && (begins || is_open)
    }

    /// An order that has not opened it in time is void: the water that comes later is a person's.
    fn waits(&mut self, by: u64) {
        let MonitorReport { reachable, valve, extinguishing, .. } = self.report;
        let Some(age) = &mut self.coming else { return };
        *age += by;
        if *age >= VALID {
            self.coming = None;
            if reachable && valve != Valve::Open && !extinguishing {
                (self.lent, self.ours, self.given) = (None, false, false);
            }
        }
    }
}

/// The oracle.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Oracle {
    eyes: Vec<Eye>,
    areas: Vec<Area>,
    barrels: Vec<Barrel>,
    motors: Vec<Motor>,
    /// It was ordered so long ago, up to what is simultaneous.
    lockout: Option<u64>,
    /// The contacts of the zones that say no.
    pressed: [bool; 2],
    pressure: bool,
    /// Monitors that the last event has to close.
    close: Vec<usize>,
}

/// What was seen, so that a machine that does nothing fails too.
pub type Seen = std::collections::BTreeSet<&'static str>;

fn old(age: &mut u64, by: u64) {
    *age = (*age + by).min(OLD);
}

fn s(seconds: u32) -> u64 {
    u64::from(seconds) * 1000
}

impl Oracle {
    pub fn new(config: &Config) -> Self {
        Self {
            eyes: vec![Eye::default(); config.detectors.len()],
            areas: vec![Area::default(); config.zones.len()],
            barrels: vec![Barrel::default(); config.monitors.len()],
            motors: vec![Motor::default(); config.pumps.len()],
            lockout: None,
            pressed: [false; 2],
            pressure: false,
            close: Vec::new(),
        }
    }

    /// The hub starts again: people's decisions stay, what was seen does not.
    pub fn restart(&mut self) {
        for eye in &mut self.eyes {
            *eye = Eye { bypass: eye.bypass, ..Eye::default() };
        }
        for area in &mut self.areas {
            let no = area.no.map(|(_, person)| (0, person));
            *area = Area { mode: area.mode, mode_left: area.mode_left, no, ..Area::default() };
        }
        for barrel in &mut self.barrels {
            let refused = barrel.refused.map(|_| 0);
            let Barrel { ours, given, hand, .. } = *barrel;
            *barrel = Barrel { refused, ours, given, hand, ..Barrel::default() };
        }
        for motor in &mut self.motors {
            *motor = Motor { off: motor.off.map(|_| 0), ..Motor::default() };
        }
        self.lockout = self.lockout.map(|_| 0);
        self.pressure = false;
        self.close.clear();
    }

    /// Time passes.
    pub fn pass(&mut self, config: &Config, by: u64) {
        for (eye, it) in self.eyes.iter_mut().zip(&config.detectors) {
            eye.heard = (eye.heard + by).min(s(it.silent_after_s));
        }
        for (zone, area) in self.areas.iter_mut().enumerate() {
            old(&mut area.quiet, by);
            if let Some((age, _)) = &mut area.no {
                old(age, by);
            }
            if let Some(met) = &mut area.met {
                let most = s(config.zones[zone].hold_max_s);
                let coincided = (*met + by).saturating_sub(s(config.zones[zone].coincidence_s));
                *met += by;
                if area.holds {
                    area.held = (area.held + by.min(coincided)).min(most);
                }
            }
            if let Some((_, age, _)) = &mut area.force {
                old(age, by);
            }
            if let Some(left) = &mut area.mode_left {
                *left = left.saturating_sub(by);
                if *left == 0 {
                    area.tested = area.mode.is_test();
                    (area.mode, area.mode_left) = (Mode::Automatic, None);
                }
            }
        }
        for barrel in &mut self.barrels {
            for age in [&mut barrel.closing, &mut barrel.found, &mut barrel.refused] {
                age.iter_mut().for_each(|age| old(age, by));
            }
            barrel.waits(by);
        }
        if let Some(age) = &mut self.lockout {
            *age = (*age + by).min(SIMULTANEOUS);
        }
        for motor in &mut self.motors {
            motor.off.iter_mut().for_each(|age| old(age, by));
            if motor.off.is_some() {
                motor.stopped = (motor.stopped + by).min(SIMULTANEOUS);
            }
            if let Some(age) = &mut motor.on {
                old(age, by);
                if self.pressure { motor.dry = 0 } else { old(&mut motor.dry, by) }
            }
        }
    }

    /// An event: what is known, and what has to be done at once.
    pub fn event(&mut self, config: &Config, event: &Event) {
        self.close.clear();
        let monitor_of = |id: &str| config.monitors.iter().position(|it| it == id).unwrap();
        let detector_of = |id: &str| config.detectors.iter().position(|it| it.id == id).unwrap();
        match event {
            Event::Detector { detector, signal, condition } => {
                let eye = &mut self.eyes[detector_of(detector)];
                eye.stale = *signal == Signal::Alarm && (eye.stale || eye.signal.is_none());
                (eye.signal, eye.condition, eye.heard) = (Some(*signal), *condition, 0);
            }
            Event::Contact { input, pressed } if input != "gauge" => {
                let zone = usize::from(input == "stop");
                if *pressed && !self.pressed[zone] {
                    self.no(config, Some(zone), true);
                }
                self.pressed[zone] = *pressed;
            }
            Event::Contact { pressed, .. } => {
                self.pressure = *pressed;
                self.motors.iter_mut().for_each(|motor| motor.dry = 0);
            }
            Event::Monitor { monitor, report } => {
                self.reported(config, monitor_of(monitor), report);
            }
            Event::Hand { order, .. } => self.hand(config, order),
            _ => {}
        }
    }

    fn reported(&mut self, config: &Config, index: usize, report: &MonitorReport) {
        let barrel = &mut self.barrels[index];
        let water = report.valve == Valve::Open || report.extinguishing;
        let person = report.authority == Authority::Person;
        let before = barrel.report;
        let flowed = before.valve == Valve::Open || before.extinguishing;
        if report.reachable && !water {
            barrel.hand = false;
        } else if person && report.reachable && water && !(before.reachable && flowed) {
            barrel.hand = !barrel.given;
        }
        let locked = self.lockout.is_some() || report.lockout;
        if barrel.opens(report) && person && !locked {
            barrel.closing = None;
        }
        if report.lockout && !before.lockout {
            let id = &config.monitors[index];
            let mut zones = config.zones.iter().zip(&self.areas);
            let under_way = zones.any(|(zone, area)| {
                zone.monitors.contains(id) && (area.force.is_some() || area.met.is_some())
            });
            if barrel.works_for.is_some() || under_way {
                barrel.refused = Some(0);
            }
            // Nor is the order carried out later that it works by.
            if (water || barrel.works_for.is_some()) && barrel.closing.is_none() {
                self.close.push(index);
                barrel.works_for = None;
            }
        }
        if water {
            barrel.coming = None;
        }
        if person {
            let ordered = barrel.works_for.is_some() && barrel.given;
            if ordered && !water && !flowed {
                barrel.coming = Some(0);
            }
            barrel.lent = barrel.works_for.take().or(barrel.lent);
        } else if let Some(zone) = barrel.lent.take_if(|_| barrel.coming.is_none()) {
            let wet = self.areas[zone].force.is_some_and(|(_, _, wet)| wet);
            let free = barrel.closing.is_none() && barrel.refused.is_none();
            barrel.works_for = Some(zone).filter(|_| wet && free);
        }
        if report.reachable && !water {
            if barrel.coming.is_none() {
                (barrel.ours, barrel.lent) = (false, None);
            }
            // Before it flows for the first time it is ordered all the same.
            barrel.given &= !(before.reachable && flowed);
        }
        let works = barrel.works_for.is_some() || barrel.closing.is_some();
        let found = water && !person && !works && barrel.ours;
        barrel.found = found.then(|| barrel.found.unwrap_or(0));
        barrel.report = *report;
    }

    fn hand(&mut self, config: &Config, order: &Hand) {
        let zone_of = |id: &str| config.zones.iter().position(|it| it.id == id).unwrap();
        let monitor_of = |id: &str| config.monitors.iter().position(|it| it == id).unwrap();
        let detector_of = |id: &str| config.detectors.iter().position(|it| it.id == id).unwrap();
        match order {
            Hand::Mode { zone, mode, for_s } => {
                let index = zone_of(zone);
                let area = &mut self.areas[index];
                if !(mode.is_test() && area.force.is_some_and(|(_, _, wet)| wet)) {
                    let preset = config.zones[index].return_after_s;
                    if area.mode.is_test() != mode.is_test() {
                        (area.met, area.held) = (None, 0);
                    }
                    area.mode = *mode;
                    area.mode_left = match mode {
                        Mode::Automatic => None,
                        Mode::Manual | Mode::Off => for_s.or(preset).map(s),
                        _ => Some(s(for_s.unwrap_or(900))),
                    };
                }
            }
            Hand::Hold { zone, on } => {
                let area = &mut self.areas[zone_of(zone)];
                area.holds = *on && area.force.is_none();
            }
            Hand::Abort { zone } => self.no(config, Some(zone_of(zone)), true),
            Hand::Release { zone } => self.release(config, zone_of(zone)),
            Hand::Close(Scope::Monitor(id)) => {
                let index = monitor_of(id);
                self.barrels[index].refused = Some(0);
                self.close.push(index);
            }
            Hand::Stop(_) | Hand::Close(_) => {
                self.no(config, None, true);
            }
            Hand::Lockout { on: true } => {
                self.lockout = Some(0);
                self.no(config, None, false);
            }
            Hand::Lockout { on: false } => {
                // At the same time as the lockout it is refused.
                let Some(age) = self.lockout.take_if(|age| *age >= SIMULTANEOUS) else { return };
                for zone in 0..self.areas.len() {
                    if self.alarms(zone, config) && self.areas[zone].no.is_none() {
                        self.areas[zone].no = Some((age, true));
                    }
                }
            }
            Hand::Reset(_) => {
                let water = self.areas.iter().any(|area| area.force.is_some());
                let locked = self.lockout.is_some();
                if !water && !locked && self.pressed == [false; 2] && !self.just_said() {
                    self.motors.iter_mut().for_each(|motor| motor.off = None);
                    self.areas.iter_mut().for_each(|area| area.no = None);
                    self.barrels.iter_mut().for_each(|barrel| barrel.refused = None);
                }
            }
            Hand::Bypass { detector, bypass } => {
                self.eyes[detector_of(detector)].bypass = *bypass;
            }
            Hand::Pump { pump, on } => {
                let index = config.pumps.iter().position(|it| it.id == *pump).unwrap();
                assert!(!on, "no test starts a pump by hand");
                (self.motors[index].off, self.motors[index].stopped) = (Some(0), 0);
            }
            Hand::Silence => {}
        }
    }

    /// A person has just said no, to anything: no reset is meant to withdraw that.
    fn just_said(&self) -> bool {
        let area = |it: &Area| it.no.is_some_and(|(age, person)| person && age < SIMULTANEOUS);
        let barrel = |it: &Barrel| it.refused.is_some_and(|age| age < SIMULTANEOUS);
        let motor = |it: &Motor| it.off.is_some() && it.stopped < SIMULTANEOUS;
        self.areas.iter().any(area)
            || self.barrels.iter().any(barrel)
            || self.motors.iter().any(motor)
    }

    fn no(&mut self, config: &Config, zone: Option<usize>, latches: bool) {
        for index in 0..self.areas.len() {
            if zone.is_none_or(|zone| zone == index) {
                let area = &mut self.areas[index];
                if latches || area.force.is_some() || area.met.is_some() {
                    area.no = Some((0, true));
                }
                if area.force.is_some() {
                    area.quiet = 0;
                }
                (area.force, area.met, area.held, area.holds) = (None, None, 0, false);
                for (monitor, barrel) in self.barrels.iter().enumerate() {
                    let serves = config.zones[index].monitors.contains(&config.monitors[monitor]);
                    let elsewhere = barrel.works_for.is_some_and(|it| it != index);
                    if serves && (zone.is_none() || !elsewhere) {
                        self.close.push(monitor);
                    }
                }
            }
        }
    }

    fn release(&mut self, config: &Config, zone: usize) {
        let pressed = self.pressed[zone];
        let area = &mut self.areas[zone];
        let just = area.no.is_some_and(|(age, person)| person && age < SIMULTANEOUS);
        if self.lockout.is_some() || area.mode == Mode::Off || pressed || just {
            return;
        }
        if area.force.is_some_and(|(automatic, ..)| !automatic) {
            return;
        }
        // A test is no reason to keep water from a person.
        if area.mode.is_test() {
            (area.mode, area.mode_left) = (Mode::Automatic, None);
        }
        (area.no, area.met, area.held, area.holds) = (None, None, 0, false);
        area.force = Some((false, 0, true));
        for (barrel, id) in self.barrels.iter_mut().zip(&config.monitors) {
            let serves = config.zones[zone].monitors.contains(id);
            if serves && barrel.works_for.is_none() && barrel.refused.is_none() {
                barrel.yields = Some(zone);
            }
        }
    }

    fn votes(&self, detector: usize, config: &Config) -> (bool, bool) {
        let eye = &self.eyes[detector];
        let silent = eye.heard >= s(config.detectors[detector].silent_after_s);
        let able = eye.signal.is_some()
            && !silent
            && eye.bypass == Bypass::None
            && eye.condition == Condition::Ready;
        (able, able && eye.signal == Some(Signal::Alarm) && !eye.stale)
    }

    fn enough(&self, zone: usize, config: &Config) -> bool {
        let configured = &config.zones[zone];
        let members: Vec<usize> = (0..self.eyes.len())
            .filter(|it| config.detectors[*it].zones.contains(&configured.id))
            .collect();
        let failed = members.iter().filter(|it| !self.votes(**it, config).0).count();
        let need = match failed {
            0 => configured.votes.need,
            failed => match configured.when_failed.get(failed - 1) {
                Some(Reduced::Votes(votes)) => votes.need,
                _ => return false,
            },
        };
        let votes: Vec<usize> =
            members.into_iter().filter(|it| self.votes(*it, config).1).collect();
        let kinds: std::collections::BTreeSet<_> =
            votes.iter().map(|it| config.detectors[*it].kind).collect();
        votes.len() >= usize::from(need) && kinds.len() >= usize::from(configured.kinds)
    }

    /// A detector of the zone sees a fire, with or without a vote.
    fn alarms(&self, zone: usize, config: &Config) -> bool {
        let of = &config.zones[zone].id;
        let mut members = self.eyes.iter().zip(&config.detectors);
        members.any(|(eye, it)| {
            let sees = eye.signal == Some(Signal::Alarm) && eye.bypass != Bypass::Disabled;
            sees && it.zones.contains(of)
        })
    }

    /// What follows from votes and time; the zones whose water has to end now.
    fn conclude(&mut self, config: &Config, seen: &mut Seen) -> Vec<usize> {
        let mut over = Vec::new();
        for zone in 0..self.areas.len() {
            let configured = &config.zones[zone];
            let enough = self.enough(zone, config);
            let alarm = self.alarms(zone, config);
            let pressed = self.pressed[zone];
            let locked = self.lockout.is_some();
            let area = &mut self.areas[zone];
            if std::mem::take(&mut area.tested) && enough && area.no.is_none() {
                area.no = Some((0, false));
                seen.insert("a test ends among votes");
            }
            if alarm || area.force.is_some() {
                area.quiet = 0;
            }
            if let Some((age, _)) = area.no
                && let Some(after) = configured.return_after_s
                && !pressed
                && area.quiet.min(age) >= s(after)
            {
                area.no = None;
                seen.insert("a no lapses");
            }
            if let Some((automatic, age, wet)) = area.force {
                let spent = automatic && age >= s(configured.water_max_s);
                if spent || (!wet && !area.mode.is_test()) {
                    area.force = None;
                    area.no =
                        (spent && (wet || area.mode.is_test())).then_some((0, false)).or(area.no);
                    area.quiet = 0;
                    over.push(zone);
                    if wet {
                        seen.insert("greatest duration");
                    }
                }
                continue;
            }
            let automatic = area.mode == Mode::Automatic || area.mode.is_test();
            if !enough || !automatic || pressed || locked || area.no.is_some() {
                (area.met, area.held) = (None, 0);
                continue;
            }
            let met = *area.met.get_or_insert(0);
            let from = s(configured.coincidence_s);
            let holding = area.holds && met >= from && area.held < s(configured.hold_max_s);
            if holding {
                seen.insert("hold");
            }
            if !holding && met >= from + s(configured.delay_s) + area.held {
                area.force = Some((true, 0, !area.mode.is_test()));
                (area.met, area.held, area.holds) = (None, 0, false);
                seen.insert("release by vote");
            }
        }
        over
    }

    fn usable(&self, monitor: usize) -> bool {
        let Barrel { report, refused, .. } = &self.barrels[monitor];
        let free = report.reachable && !report.failure && !report.lockout;
        let person = report.authority == Authority::Person;
        free && refused.is_none() && !person && self.lockout.is_none()
    }

    /// Judges what the machine did.
    pub fn judge(
        &mut self,
        config: &Config,
        reaction: &Reaction,
        state: &State,
        seen: &mut Seen,
    ) -> Result<(), String> {
        let over = self.conclude(config, seen);
        let mut closed = Vec::new();
        let mut must: Vec<usize> = std::mem::take(&mut self.close);
        let mut stopped = Vec::new();
        must.extend(
            (0..self.barrels.len())
                .filter(|it| self.barrels[*it].works_for.is_some_and(|zone| over.contains(&zone))),
        );
        for command in &reaction.commands {
            let index = |id: &String| config.monitors.iter().position(|it| it == id).unwrap();
            match &command.order {
                Order::Engage { monitor, zone, .. } => {
                    let zone = config.zones.iter().position(|it| it.id == *zone).unwrap();
                    self.engaged(index(monitor), zone, seen)?;
                }
                Order::Close { monitor } => closed.push(index(monitor)),
                Order::Valve { output, open: true } => self.opened(config, output)?,
                Order::Valve { output, open: false } => stopped.push(output),
                Order::Pump { pump, on } => {
                    let index = config.pumps.iter().position(|it| it.id == *pump).unwrap();
                    let duty = !config.pumps[index].standby && self.motors[index].off.is_none();
                    if !on && duty {
                        stopped.push(pump);
                    }
                    let pump = index;
                    self.pump(config, pump, *on, seen)?;
                }
                _ => {}
            }
        }
        for monitor in &must {
            if !closed.contains(monitor) {
                return Err(format!("{} is not closed at once", config.monitors[*monitor]));
            }
        }
        for (index, barrel) in self.barrels.iter_mut().enumerate() {
            let valve = barrel.report.reachable && barrel.report.valve == Valve::Closed;
            let shut = valve && !barrel.report.extinguishing;
            if closed.contains(&index) && (barrel.closing.is_none() || must.contains(&index)) {
                (barrel.shut, barrel.yields) = (valve, None);
            }
            if closed.contains(&index) {
                let kept = barrel.hand && barrel.closing.is_none() && barrel.works_for.is_none();
                let locked = self.lockout.is_some() || barrel.report.lockout;
                if kept && !must.contains(&index) && !locked {
                    return Err(format!("a person's water is closed ({})", config.monitors[index]));
                }
                (barrel.hand, barrel.given) = (false, false);
                (barrel.works_for, barrel.closing, barrel.found) = (None, Some(0), None);
                (barrel.lent, barrel.coming) = (None, None);
            }
            if barrel.closing.is_some_and(|age| age >= REPEAT) {
                if !shut {
                    return Err(format!("Close of {} is not repeated", config.monitors[index]));
                }
                barrel.closing = None;
            }
            let longest = config.zones.iter().map(|it| s(it.water_max_s)).max().unwrap();
            if barrel.found.is_some_and(|age| age > longest) {
                return Err(format!("water found at {} never ends", config.monitors[index]));
            }
        }
        if !self.is_wet() {
            self.motors.iter_mut().flat_map(|motor| &mut motor.off).for_each(|age| *age = 0);
        }
        self.supplied(config, &stopped, seen)?;
        self.lapse(config);
        self.served(config)?;
        self.pumped(config)?;
        self.shown(state)
    }

    fn engaged(&mut self, monitor: usize, zone: usize, seen: &mut Seen) -> Result<(), String> {
        let area = &self.areas[zone];
        let barrel = self.barrels[monitor];
        let Some((automatic, _, wet)) = area.force else {
            let why = if area.no.is_some() { "after a no" } else { "without votes or hand" };
            return Err(format!("water {why} (zone {zone}, monitor {monitor})"));
        };
        if self.lockout.is_some() || barrel.refused.is_some() {
            return Err("water in spite of lockout or a refused monitor".to_owned());
        }
        if !wet {
            return Err("water in a test".to_owned());
        }
        if barrel.report.authority == Authority::Person {
            return Err("a person's monitor is taken".to_owned());
        }
        if let Some(other) = barrel.works_for.filter(|other| *other != zone) {
            let theirs = self.areas[other].force.is_some_and(|(automatic, ..)| automatic);
            if automatic || !theirs {
                return Err("a monitor is taken from another zone".to_owned());
            }
            seen.insert("a hand takes from votes");
        }
        seen.insert(if automatic { "water by vote" } else { "water by hand" });
        if automatic && self.eyes.iter().any(|eye| eye.condition == Condition::Fault) {
            seen.insert("degraded vote");
        }
        let barrel = &mut self.barrels[monitor];
        (barrel.works_for, barrel.found, barrel.ours) = (Some(zone), None, automatic);
        (barrel.given, barrel.hand, barrel.closing) = (true, false, None);
        (barrel.lent, barrel.coming) = (None, None);
        Ok(())
    }

    /// A refused monitor is free again when its zones were quiet for long enough.
    fn lapse(&mut self, config: &Config) {
        for (index, barrel) in self.barrels.iter_mut().enumerate() {
            let Some(age) = barrel.refused else { continue };
            let mut zones = config.zones.iter().zip(&self.areas);
            let all = zones.all(|(zone, area)| {
                let serves = zone.monitors.contains(&config.monitors[index]);
                let after = zone.return_after_s.map(s);
                !serves || after.is_some_and(|after| area.quiet.min(age) >= after)
            });
            if all {
                barrel.refused = None;
            }
        }
    }

    /// Every zone in force has the monitors that it can have.
    fn served(&self, config: &Config) -> Result<(), String> {
        for (zone, area) in self.areas.iter().enumerate() {
            let Some((automatic, _, true)) = area.force else { continue };
            let configured = &config.zones[zone];
            let of_zone: Vec<usize> = (0..self.barrels.len())
                .filter(|it| configured.monitors.contains(&config.monitors[*it]))
                .filter(|it| self.usable(*it))
                .collect();
            let works = |it: &&usize| self.barrels[**it].works_for == Some(zone);
            let free = |it: &&usize| {
                let barrel = &self.barrels[**it];
                let closes = barrel.closing.is_some() && (automatic || barrel.yields != Some(zone));
                barrel.works_for.is_none() && !closes
            };
            let have = of_zone.iter().filter(works).count();
            let could = have + of_zone.iter().filter(free).count();
            let jets = configured.jets.map_or(of_zone.len(), usize::from);
            if have < jets.min(could) {
                return Err(format!("zone {zone} is released and lacks a monitor"));
            }
        }
        Ok(())
    }

    /// The state says what is.
    fn shown(&self, state: &State) -> Result<(), String> {
        for (zone, (area, shown)) in self.areas.iter().zip(&state.zones).enumerate() {
            if shown.mode != area.mode {
                return Err(format!("zone {zone} is in {:?}, shown {:?}", area.mode, shown.mode));
            }
            let released = matches!(shown.phase, Phase::Released { .. });
            if released != area.force.is_some() {
                return Err(format!(
                    "zone {zone}: in force {:?}, shown {:?}",
                    area.force, shown.phase
                ));
            }
            let ended = matches!(shown.phase, Phase::Ended(_));
            if !released && ended != area.no.is_some() {
                return Err(format!("zone {zone}: no {:?}, shown {:?}", area.no, shown.phase));
            }
        }
        Ok(())
    }
}
