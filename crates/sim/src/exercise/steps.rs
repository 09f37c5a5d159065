//! From the text of a scenario file to a plan: events, the operator's part, expectations.

use lafet_device::Source as Interface;
use lafet_proto::SubsystemId;
use lafet_proto::flags::Button;
use lafet_texts::{Text as _, sim as text};

use super::condition::{Names, SiteCondition, not_understood};
use super::effect;
use super::file::payload;
use super::plan::{
    Action, ControllerPlan, EventPlan, Exercise, Expectation, Link, Moment, OperatorLine, Rule,
    Trigger,
};
use super::reader::{Problem, Table, a_time, one_of, time_ms};
use crate::fault::{Fault, Post, button_name};
use crate::site::{Site, WindSpec};

const INTERFACES: [(&str, Interface); 2] =
    [("external", Interface::ExternalConn), ("radio", Interface::Radio)];
const LINKS: [(&str, Link); 3] =
    [("up", Link::Up), ("lost", Link::Lost), ("answers-lost", Link::AnswersLost)];
const VALVES: [(&str, &str); 2] = [("Valve1", "Valve1"), ("Valve2", "Valve2")];

/// Reads `[[event]]`, `[[operator]]`, `[[controller]]` and `[[expect]]`.
pub fn read(exercise: &mut Exercise, root: &Table<'_>) -> Result<(), Problem> {
    for list in ["event", "operator", "controller"] {
        for table in root.tables(list)? {
            if table.has("name") {
                exercise.marks.push(super::file::fresh_name(&table, &exercise.marks)?);
            }
        }
    }
    let mut reader = Steps {
        monitors: exercise.monitors.iter().map(|it| it.name.clone()).collect(),
        fires: exercise.fires.iter().map(|it| it.name.clone()).collect(),
        site: exercise.build(exercise.site.seed),
        exercise,
    };
    // The first look of the monitors at their sensors.
    reader.site.advance_ms(500);
    for table in root.tables("event")? {
        let event = reader.event(table)?;
        reader.exercise.events.push(event);
    }
    for table in root.tables("operator")? {
        let line = reader.operator(table)?;
        reader.exercise.operator.push(line);
    }
    for table in root.tables("controller")? {
        let controller = reader.controller(table)?;
        reader.exercise.controllers.push(controller);
    }
    for table in root.tables("expect")? {
        let expectation = reader.expectation(table)?;
        reader.exercise.expectations.push(expectation);
    }
    effect::of_steps(reader.exercise, root)?;
    if reader.exercise.expectations.is_empty() {
        let what = text::NeedsExpect.words();
        return Err(root.wrong("expect", what));
    }
    Ok(())
}

/// The wind that a table gives, if it gives any.
pub fn wind(table: &Table<'_>, before: WindSpec) -> Result<Option<WindSpec>, Problem> {
    let from_deg = table.number("wind_from", 0.0, 360.0)?;
    let speed_mps = table.number("wind", 0.0, 40.0)?;
    let gusts_mps = table.number("gusts", 0.0, 30.0)?;
    let given = from_deg.is_some() || speed_mps.is_some() || gusts_mps.is_some();
    let wind = WindSpec {
        from_deg: from_deg.unwrap_or(before.from_deg),
        speed_mps: speed_mps.unwrap_or(before.speed_mps),
        gusts_mps: gusts_mps.unwrap_or(before.gusts_mps),
    };
    let calm = wind.speed_mps <= 0.0 && wind.gusts_mps <= 0.0;
    if calm && from_deg.is_some() && speed_mps.is_none() {
        return Err(table.wrong("wind_from", effect::without("wind")));
    }
    Ok(given.then_some(wind))
}

struct Steps<'e> {
    exercise: &'e mut Exercise,
    monitors: Vec<String>,
    fires: Vec<String>,
    /// For trying out whether conditions make sense.
    site: Site,
}

impl Steps<'_> {
    fn condition(
        &mut self,
        table: &Table<'_>,
        key: &'static str,
    ) -> Result<Option<SiteCondition>, Problem> {
        let Some(text) = table.text(key)? else { return Ok(None) };
        let names = Names { monitors: &self.monitors, fires: &self.fires };
        let wrong = |what| table.wrong(key, what);
        let condition = SiteCondition::parse(text, names).map_err(wrong)?;
        condition.holds(&mut self.site).map_err(|error| wrong(not_understood(&error)))?;
        Ok(Some(condition))
    }

    fn mark(&self, table: &Table<'_>) -> Result<Option<usize>, Problem> {
        table.one_of_names("name", &self.exercise.marks)
    }

    fn trigger(&mut self, table: &Table<'_>) -> Result<Trigger, Problem> {
        Ok(Trigger {
            at_ms: table.time("at")?,
            when: self.condition(table, "when")?,
            after: table.one_of_names("after", &self.exercise.marks)?,
            delay_ms: table.time("delay")?.unwrap_or(0),
        })
    }

    /// The monitor that a table is about; where there is one alone it need not be named.
    fn monitor(&self, table: &Table<'_>) -> Result<usize, Problem> {
        match table.one_of_names("monitor", &self.monitors)? {
            Some(monitor) => Ok(monitor),
            None if self.monitors.len() == 1 => Ok(0),
            None => {
                let known = self.monitors.join(", ");
                let what = text::WhichMonitor { known }.words();
                Err(table.wrong("monitor", what))
            }
        }
    }

    fn event(&mut self, table: Table<'_>) -> Result<EventPlan, Problem> {
        let trigger = self.trigger(&table)?;
        if trigger.at_ms.is_none() && trigger.when.is_none() && trigger.after.is_none() {
            let what = text::NeedsTrigger.words();
            return Err(table.wrong("at", what));
        }
        effect::trigger_in_time(&table, &trigger, self.exercise.duration_ms)?;
        let mut actions = Vec::new();
        self.plant_actions(&table, &mut actions)?;
        if actions.is_empty() {
            let what = "inject, clear, radio, external, power, press, release";
            table.none_of(&["monitor"], || effect::without(what))?;
        }
        self.site_actions(&table, &mut actions)?;
        for action in &actions {
            effect::reaches(&table, self.exercise, &mut self.site, *action)?;
        }
        if actions.is_empty() {
            let what = text::NeedsAction.words();
            return Err(table.wrong("", what));
        }
        let (line, mark, text) = (table.line(), self.mark(&table)?, table.both("text")?);
        table.finish()?;
        Ok(EventPlan { line, mark, trigger, text, actions })
    }

    /// Faults, links, power and buttons: what happens to one monitor.
    fn plant_actions(&self, table: &Table<'_>, actions: &mut Vec<Action>) -> Result<(), Problem> {
        for name in table.texts_of("inject")? {
            actions.push(Action::Inject(self.monitor(table)?, fault(table, "inject", name)?));
        }
        for name in table.texts_of("clear")? {
            let fault = match name {
                "all" => None,
                name => Some(fault(table, "clear", name)?),
            };
            actions.push(Action::Clear(self.monitor(table)?, fault));
        }
        for (key, interface) in [("radio", Interface::Radio), ("external", Interface::ExternalConn)]
        {
            if let Some(link) = table.choice(key, &LINKS)? {
                actions.push(Action::Link(self.monitor(table)?, interface, link));
            }
        }
        if let Some(on) = table.choice("power", &[("on", true), ("off", false)])? {
            actions.push(Action::Power(self.monitor(table)?, on));
        }
        for (key, pressed) in [("press", true), ("release", false)] {
            for text in table.texts_of(key)? {
                let (post, button) = button(text).ok_or_else(|| {
                    let what = "buttons left, ext-buttons open …";
                    table.wrong(key, text::AButton { known: what }.words())
                })?;
                actions.push(Action::Press(self.monitor(table)?, post, button, pressed));
            }
        }
        Ok(())
    }

    /// Wind, air, fires, water: what happens to the site.
    fn site_actions(&self, table: &Table<'_>, actions: &mut Vec<Action>) -> Result<(), Problem> {
        if let Some(wind) = wind(table, self.exercise.site.wind)? {
            actions.push(Action::Wind(wind));
        }
        if let Some(celsius) = table.number("temperature", -60.0, 60.0)? {
            actions.push(Action::Temperature(celsius));
        }
        if let Some(fire) = table.one_of_names("ignite", &self.fires)? {
            actions.push(Action::Ignite(fire));
        }
        if !table.has("supply") {
            table.none_of(&["percent"], || effect::without("supply"))?;
        }
        if let Some(supply) = table.one_of_names("supply", &self.exercise.supplies)? {
            let percent = table.needed("percent", 0.0, 150.0)?;
            actions.push(Action::Supply(supply, percent / 100.0));
        }
        Ok(())
    }

    fn operator(&mut self, table: Table<'_>) -> Result<OperatorLine, Problem> {
        let request = table.needed_text("send")?;
        let payload = payload(request).map_err(|what| table.wrong("send", what))?;
        let line = OperatorLine {
            line: table.line(),
            mark: self.mark(&table)?,
            monitor: self.monitor(&table)?,
            trigger: self.trigger(&table)?,
            over: table.choice("over", &INTERFACES)?.unwrap_or(Interface::ExternalConn),
            request: request.to_owned(),
            payload,
            answer: effect::answer(&table)?,
            repeat_ms: table.time("repeat")?,
        };
        effect::interface(&table, "over", self.exercise, &mut self.site, line.monitor, line.over)?;
        table.finish()?;
        Ok(line)
    }

    fn controller(&mut self, table: Table<'_>) -> Result<ControllerPlan, Problem> {
        let monitor = self.monitor(&table)?;
        let folds = effect::has(&mut self.site, monitor, SubsystemId::DEPLOYER);
        let controller = ControllerPlan {
            line: table.line(),
            mark: self.mark(&table)?,
            monitor,
            trigger: self.trigger(&table)?,
            over: table.choice("over", &INTERFACES)?.unwrap_or(Interface::ExternalConn),
            sector: table.numbers("sector")?.unwrap_or([-60.0, 60.0, -10.0, 5.0]),
            quench_ms: table.time("quench")?.unwrap_or(40_000),
            distance_m: table.number("distance", 1.0, 127.0)?,
            valve: table.choice("valve", &VALVES)?.unwrap_or("Valve1"),
            margin_deg: table.number("margin", 0.0, 30.0)?.unwrap_or(0.5),
            ignore: if table.has("ignore") { table.places("ignore")? } else { Vec::new() },
            wrap: table.truth("wrap")?.unwrap_or(folds),
        };
        effect::controller(&table, self.exercise, &mut self.site, &controller)?;
        table.finish()?;
        Ok(controller)
    }

    /// A time or the name of a mark.
    fn moment(&self, table: &Table<'_>, key: &'static str) -> Result<Option<Moment>, Problem> {
        let Some(text) = table.text(key)? else { return Ok(None) };
        if let Some(ms) = time_ms(text) {
            return Ok(Some(Moment::At(ms)));
        }
        let marks = &self.exercise.marks;
        let mark = marks.iter().position(|mark| mark == text).map(Moment::Mark);
        mark.map(Some).ok_or_else(|| {
            let names: Vec<&str> = marks.iter().map(String::as_str).collect();
            match text.starts_with(|c: char| c.is_ascii_digit()) {
                true => table.wrong(key, a_time(text)),
                false => table.wrong(key, one_of(text, &names)),
            }
        })
    }

    fn expectation(&mut self, table: Table<'_>) -> Result<Expectation, Problem> {
        let conditions = [
            self.condition(&table, "that")?,
            self.condition(&table, "never")?,
            self.condition(&table, "always")?,
        ];
        let (from, until) = (self.moment(&table, "from")?, self.moment(&table, "until")?);
        let (after, by) = (self.moment(&table, "after")?, self.moment(&table, "by")?);
        let (at, within_ms) = (self.moment(&table, "at")?, table.time("within")?);
        let wrong = || table.wrong("that", text::NeedsExpectation.words());
        let (that, rule) = match conditions {
            [Some(that), None, None] => {
                table.none_of(&["from", "until"], || effect::beside("that"))?;
                if at.is_some() {
                    table.none_of(&["after", "by", "within"], || effect::beside("at"))?;
                }
                let rule = match (at, after.is_some() || by.is_some() || within_ms.is_some()) {
                    (Some(at), _) => Rule::At(at),
                    (None, true) => Rule::By { after, within_ms, by },
                    (None, false) => Rule::End,
                };
                (that, rule)
            }
            [None, never, always] if never.is_some() != always.is_some() => {
                let key = if never.is_some() { "never" } else { "always" };
                table.none_of(&["at", "after", "by", "within"], || effect::beside(key))?;
                match (never, always) {
                    (Some(never), _) => (never, Rule::Never(from, until)),
                    (None, always) => (always.ok_or_else(wrong)?, Rule::Always(from, until)),
                }
            }
            _ => return Err(wrong()),
        };
        let expectation =
            Expectation { line: table.line(), text: table.needed_both("text")?, that, rule };
        table.finish()?;
        Ok(expectation)
    }
}

fn fault(table: &Table<'_>, key: &str, name: &str) -> Result<Fault, Problem> {
    Fault::from_name(name).ok_or_else(|| {
        // The list is long: those that begin alike help most.
        let begins = name.split('-').next().unwrap_or(name);
        let all: Vec<String> = Fault::all().map(Fault::name).collect();
        let alike = all.iter().filter(|known| known.starts_with(begins));
        let mut alike: Vec<&str> = alike.map(String::as_str).collect();
        if alike.is_empty() {
            alike = all.iter().map(String::as_str).collect();
        }
        table.wrong(key, one_of(name, &alike))
    })
}

fn button(text: &str) -> Option<(Post, Button)> {
    let (post, button) = text.split_once(' ')?;
    let post = Post::ALL.iter().find(|known| known.name() == post)?;
    let button = Button::ALL.into_iter().find(|known| button_name(*known) == button.trim())?;
    Some((*post, button))
}
