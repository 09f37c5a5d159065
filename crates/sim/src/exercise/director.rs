//! What happens to a site by itself: the events of a scenario, at their times. The same whether a
//! scenario is run in virtual time or served to clients in real time.

use std::sync::Arc;

use lafet_device::Source;
use lafet_texts::{Text, Words, sim as text};

use super::plan::{Action, Exercise, FirePlan, Link, Trigger};
use crate::event::What;
use crate::fault::button_name;
use crate::fire::FireSpec;
use crate::obstacle::Shape;
use crate::site::{Site, SiteFire};

/// Events and triggers are looked at this often, ms.
pub const LOOK_MS: u64 = 100;

/// A site, and the events of its scenario.
#[derive(Clone, Debug)]
pub struct Director {
    /// The site.
    pub site: Site,
    exercise: Arc<Exercise>,
    events: Vec<Waiting>,
    /// When each mark was passed, ms.
    marks: Vec<Option<u64>>,
    links: Vec<[Link; 2]>,
    happened: Vec<(u64, Words)>,
}

/// Something that waits for its trigger.
#[derive(Clone, Copy, Debug, Default)]
pub struct Waiting {
    ready_ms: Option<u64>,
    done: bool,
}

impl Director {
    /// The site of a scenario at its beginning.
    pub fn new(exercise: Arc<Exercise>, seed: u64) -> Self {
        let mut director = Self {
            site: exercise.build(seed),
            events: vec![Waiting::default(); exercise.events.len()],
            marks: vec![None; exercise.marks.len()],
            links: vec![[Link::Up; 2]; exercise.monitors.len()],
            happened: Vec::new(),
            exercise,
        };
        director.look();
        director
    }

    /// The scenario.
    pub const fn exercise(&self) -> &Arc<Exercise> {
        &self.exercise
    }

    /// Virtual time, ms.
    pub const fn now_ms(&self) -> u64 {
        self.site.now_ms()
    }

    /// One step of 10 ms.
    pub fn tick(&mut self) {
        self.site.tick();
        if self.now_ms().is_multiple_of(LOOK_MS) {
            self.look();
        }
    }

    /// Moves time; a part of a step is left out.
    pub fn advance_ms(&mut self, ms: u64) {
        for _ in 0..ms / crate::world::STEP_MS {
            self.tick();
        }
    }

    /// What has happened since the last call.
    pub fn take_happened(&mut self) -> Vec<(u64, Words)> {
        core::mem::take(&mut self.happened)
    }

    /// What has happened to fires since the last call, for those who watch; a run takes the events
    /// of the site itself.
    pub fn take_fires(&mut self) -> Vec<(u64, Words)> {
        let events = self.site.take_events().into_iter();
        let told = events.filter(|it| it.monitor.is_none()).filter_map(|it| {
            let (index, what) = fire_news(it.event.what)?;
            let fire = &self.exercise.fires[index].name;
            Some((it.event.at_ms, text::FireNews { fire, what }.words()))
        });
        told.collect()
    }

    /// When a mark was passed, ms.
    pub fn passed(&self, mark: usize) -> Option<u64> {
        self.marks.get(mark).copied().flatten()
    }

    /// Passes a mark.
    pub fn pass(&mut self, mark: Option<usize>) {
        let now_ms = self.now_ms();
        if let Some(mark) = mark.and_then(|mark| self.marks.get_mut(mark)) {
            mark.get_or_insert(now_ms);
        }
    }

    /// The state of a link.
    pub fn link(&self, monitor: usize, over: Source) -> Link {
        self.links[monitor][of_interface(over)]
    }

    /// Sends records to a monitor as a client would; `None` when no answer comes back.
    pub fn request(&mut self, monitor: usize, over: Source, payload: &[u8]) -> Option<Vec<u8>> {
        let link = self.link(monitor, over);
        if link == Link::Lost {
            return None;
        }
        let answers = self.site.members[monitor].sim.request(over, payload);
        (link == Link::Up && !answers.is_empty()).then_some(answers)
    }

    /// Whether a trigger has fired; asks again and again until it has.
    pub fn fires(&mut self, trigger: &Trigger, waiting: &mut Waiting) -> bool {
        let now_ms = self.now_ms();
        if waiting.ready_ms.is_none() {
            let time = trigger.at_ms.is_none_or(|at_ms| now_ms >= at_ms);
            let after = trigger.after.is_none_or(|mark| self.passed(mark).is_some());
            let mut holds = || {
                let Some(when) = &trigger.when else { return true };
                when.holds(&mut self.site).is_ok_and(|(holds, _)| holds)
            };
            if time && after && holds() {
                waiting.ready_ms = Some(now_ms + trigger.delay_ms);
            }
        }
        waiting.ready_ms.is_some_and(|ready_ms| now_ms >= ready_ms)
    }

    fn look(&mut self) {
        let exercise = Arc::clone(&self.exercise);
        for (index, fire) in exercise.fires.iter().enumerate() {
            if fire.lit_ms.is_some_and(|ms| ms > 0 && ms == self.now_ms()) {
                self.site.ignite(index);
            }
        }
        for (index, event) in exercise.events.iter().enumerate() {
            let mut waiting = self.events[index];
            if !waiting.done && self.fires(&event.trigger, &mut waiting) {
                waiting.done = true;
                self.pass(event.mark);
                for action in &event.actions {
                    self.act(*action);
                }
                let text = match &event.text {
                    Some(text) => text.clone(),
                    None => self.told(&event.actions),
                };
                self.happened.push((self.now_ms(), text));
            }
            self.events[index] = waiting;
        }
    }

    /// Lights a new fire at a place; on a tank, if one is there. Its name.
    pub fn light(&mut self, at: (f64, f64), spec: FireSpec) -> String {
        let mut tanks = self.site.obstacles().iter().enumerate();
        let on = tanks.find_map(|(index, it)| match it.shape {
            Shape::Tank((x, y), diameter_m) => {
                let inside = libm::hypot(at.0 - x, at.1 - y) <= diameter_m / 2.0;
                inside.then_some((index, it.height_m))
            }
            Shape::Wall(..) => None,
        });
        let base_m = on.map_or(spec.base_m, |(_, height_m)| height_m);
        let fire =
            SiteFire { at, spec: FireSpec { base_m, lit: true, ..spec }, on: on.map(|it| it.0) };
        let exercise = Arc::make_mut(&mut self.exercise);
        let mut names = (1..).map(|number| format!("fire-{number}"));
        let taken = |name: &String| exercise.fires.iter().any(|fire| fire.name == *name);
        let name = names.find(|name| !taken(name)).unwrap_or_default();
        exercise.fires.push(FirePlan { name: name.clone(), lit_ms: None });
        exercise.site.fires.push(fire);
        self.site.add_fire(fire);
        name
    }

    /// Does something to the site.
    pub fn act(&mut self, action: Action) {
        let site = &mut self.site;
        match action {
            Action::Inject(monitor, fault) => {
                site.members[monitor].sim.world_mut().inject(fault);
            }
            Action::Clear(monitor, Some(fault)) => {
                site.members[monitor].sim.world_mut().clear(fault);
            }
            Action::Clear(monitor, None) => site.members[monitor].sim.world_mut().clear_all(),
            Action::Wind(wind) => site.wind.set(wind),
            Action::Temperature(celsius) => site.set_ambient_c(celsius),
            Action::Ignite(fire) => site.ignite(fire),
            Action::Link(monitor, over, link) => self.links[monitor][of_interface(over)] = link,
            Action::Power(monitor, true) => site.members[monitor].sim.power_on(),
            Action::Power(monitor, false) => site.members[monitor].sim.power_off(),
            Action::Press(monitor, post, button, pressed) => {
                site.members[monitor].sim.world_mut().press(post, button, pressed);
            }
            Action::Supply(supply, share) => site.supplies[supply].share = share,
        }
    }

    fn told(&self, actions: &[Action]) -> Words {
        let all: Vec<Words> = actions.iter().map(|action| self.told_one(*action)).collect();
        let join = |of: fn(&Words) -> &str| all.iter().map(of).collect::<Vec<_>>().join("; ");
        Words { en: join(|text| &text.en), ru: join(|text| &text.ru) }
    }

    fn told_one(&self, action: Action) -> Words {
        let exercise = &self.exercise;
        let name = |monitor: usize| &exercise.monitors[monitor].name;
        match action {
            Action::Inject(monitor, fault) => {
                let (name, fault) = (name(monitor), fault.name());
                text::FaultInjected { name, fault }.words()
            }
            Action::Clear(monitor, Some(fault)) => {
                let (name, fault) = (name(monitor), fault.name());
                text::FaultRepaired { name, fault }.words()
            }
            Action::Clear(monitor, None) => {
                let name = name(monitor);
                text::AllRepaired { name }.words()
            }
            Action::Wind(wind) => {
                let (from, speed) = (wind.from_deg, wind.speed_mps);
                text::WindFrom { from, speed }.words()
            }
            Action::Temperature(c) => text::AirTemperature { celsius: c }.words(),
            Action::Ignite(fire) => {
                let name = &exercise.fires[fire].name;
                text::FireIgnited { name }.words()
            }
            Action::Link(monitor, over, link) => {
                let what: &dyn Text = match link {
                    Link::Up => &text::LinkBack,
                    Link::Lost => &text::LinkLost,
                    Link::AnswersLost => &text::LinkLosesAnswers,
                };
                let interface = interface_name(over);
                text::LinkNews { monitor: name(monitor), interface, what }.words()
            }
            Action::Power(monitor, on) => {
                let name = name(monitor);
                match on {
                    true => text::PowerBack { name }.words(),
                    false => text::PowerCut { name }.words(),
                }
            }
            Action::Press(monitor, post, button, pressed) => {
                let (name, button) = (name(monitor), button_name(button));
                let post = post.name();
                match pressed {
                    true => text::ButtonPressed { name, post, button }.words(),
                    false => text::ButtonReleased { name, post, button }.words(),
                }
            }
            Action::Supply(supply, share) => {
                let (name, percent) = (&exercise.supplies[supply], share * 100.0);
                text::SupplyAt { name, percent: format_args!("{percent:.0}") }.words()
            }
        }
    }
}

/// Which fire an event is about, and what has happened to it.
pub const fn fire_news(what: What) -> Option<(usize, &'static dyn Text)> {
    Some(match what {
        What::FireLit(index) => (index, &text::FireBurns),
        What::FireHit(index) => (index, &text::FireHit),
        What::FireOut(index) => (index, &text::FireOut),
        What::FireReignited(index) => (index, &text::FireReignited),
        _ => return None,
    })
}

/// What an interface is called.
pub const fn interface_name(over: Source) -> &'static dyn Text {
    match over {
        Source::Radio => &text::InterfaceRadio,
        _ => &text::InterfaceWired,
    }
}

/// The place of an interface in a list of both.
pub const fn of_interface(over: Source) -> usize {
    match over {
        Source::Radio => 1,
        _ => 0,
    }
}
