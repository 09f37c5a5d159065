//! Carries out a case of a scenario, line by line.

use lafet_device::Source;
use lafet_proto::record::{Record, Records};
use lafet_proto::status::FaultInfo;
use lafet_proto::text::{AnswerText, Exchange};
use lafet_proto::{Answer, Request, Status};
use lafet_texts::{Shown, Text as _, Words, sim as text};

use super::{Case, Failure, Reach, Scenario, State, Step, payload, quoted};
use crate::condition::Condition;
use crate::sim::Sim;

/// What `crash` leaves (§3.20): each word shows which one it is.
const CRASH: FaultInfo = FaultInfo::from_words([
    0xC0DE_0000,
    0xC0DE_0001,
    0xC0DE_0002,
    0xC0DE_0003,
    0xC0DE_0004,
    0xC0DE_0005,
    0xC0DE_0006,
    0xC0DE_0007,
    0xC0DE_0008,
    0xC0DE_0009,
    0xC0DE_000A,
    0xC0DE_000B,
    0xC0DE_000C,
    0xC0DE_000D,
    0xC0DE_000E,
    0xC0DE_000F,
    0xC0DE_0010,
    0xC0DE_0011,
    0xC0DE_0012,
    0xC0DE_0013,
]);
/// Transcript lines shown with a failure.
const TAIL: usize = 12;
/// Longest time that a state may take to be reached, ms.
const REACH_MAX_MS: u64 = 60_000;

pub(super) struct Run<'a> {
    file: &'a str,
    pub(super) line: usize,
    pub(super) sim: Sim,
    source: Source,
    watches: Vec<(usize, &'a Condition, bool)>,
    pub(super) checks: usize,
    pub(super) last_wait_ms: u64,
    tail: Vec<String>,
    log: &'a mut dyn FnMut(&str),
}

impl<'a> Run<'a> {
    pub(super) fn new(
        scenario: &'a Scenario,
        case: &'a Case,
        log: &'a mut dyn FnMut(&str),
    ) -> Self {
        Self {
            file: &scenario.file,
            line: case.line,
            sim: Sim::new(case.setup.clone()),
            source: Source::ExternalConn,
            watches: Vec::new(),
            checks: 0,
            last_wait_ms: 0,
            tail: vec![format!("case {}", case.title)],
            log,
        }
    }

    pub(super) fn step(&mut self, step: &'a Step) -> Result<(), Failure> {
        match step {
            Step::State(state) => self.reach(state)?,
            Step::Ask { text, payload, expected } => {
                let answers = self.ask(text, payload);
                self.check_answers(text, &answers, expected)?;
            }
            Step::Prepare { text, payload } => self.prepare(text, payload)?,
            Step::Source(source) => self.source = *source,
            Step::After(ms) => self.advance(*ms)?,
            Step::Until(condition, ms) => self.until(condition, *ms)?,
            Step::Expect(condition) => {
                self.checks += 1;
                let (holds, came) = self.holds(condition)?;
                if !holds {
                    return Err(self.failure(Words::same(condition.to_string()), Words::same(came)));
                }
            }
            Step::Watch { condition, forbidden } => {
                self.checks += 1;
                self.watches.push((self.line, condition, *forbidden));
                self.check_watches()?;
            }
            Step::EndWatch => self.watches.clear(),
            Step::Press(post, button, pressed) => {
                self.sim.world_mut().press(*post, *button, *pressed);
            }
            Step::Inject(fault) => self.sim.world_mut().inject(*fault),
            Step::Clear(Some(fault)) => self.sim.world_mut().clear(*fault),
            Step::Clear(None) => self.sim.world_mut().clear_all(),
            Step::Damage(key) => {
                if !self.sim.world_mut().flash.damage(*key) {
                    let expected = text::RunStoredValue { key: key.0 }.words();
                    return Err(self.failure(expected, text::RunNothingStored.words()));
                }
            }
            Step::Crash => self.sim.crash(CRASH),
            Step::PowerCycle => self.sim.power_cycle(),
            Step::PowerCut(cut) => self.sim.cut_power_at(&[*cut]),
            Step::Fire(spec) => {
                self.sim.world_mut().light(*spec);
            }
        }
        Ok(())
    }

    fn say(&mut self, line: String) {
        let line = format!("{:>9.2} {line}", self.sim.now_ms() as f64 / 1000.0);
        (self.log)(&line);
        if self.tail.len() > TAIL {
            self.tail.remove(1);
        }
        self.tail.push(line);
    }

    fn failure(&mut self, expected: Words, came: Words) -> Failure {
        let mut tail = core::mem::take(&mut self.tail);
        tail.push(self.sim.trace_line());
        Failure {
            file: self.file.to_owned(),
            line: self.line,
            expected: expected.into(),
            came: came.into(),
            tail,
        }
    }

    /// Sends a frame; the answers as text.
    fn ask(&mut self, text: &str, payload: &[u8]) -> Vec<String> {
        self.say(format!("> {text}"));
        let bytes = self.sim.request(self.source, payload);
        let answers = answers_text(payload, &bytes);
        for answer in &answers {
            self.say(format!("< {answer}"));
        }
        answers
    }

    fn check_answers(
        &mut self,
        asked: &str,
        answers: &[String],
        expected: &[(usize, String)],
    ) -> Result<(), Failure> {
        let mut answers = answers.iter();
        for (line, wanted) in expected {
            self.checks += 1;
            self.line = *line;
            match wanted.as_str() {
                "…" | "..." => return Ok(()),
                "none" => {}
                _ => {
                    let came = answers.next();
                    if !came.is_some_and(|came| fits(wanted, came)) {
                        let came = came.map_or_else(|| text::RunNoAnswer.words(), |it| quoted(it));
                        let expected = text::RunAnswerAfter { wanted, asked }.words();
                        return Err(self.failure(expected, came));
                    }
                }
            }
        }
        match answers.next() {
            None => Ok(()),
            Some(more) => Err(self.failure(text::RunNoneAfter { asked }.words(), quoted(more))),
        }
    }

    fn prepare(&mut self, asked: &str, payload: &[u8]) -> Result<(), Failure> {
        self.say(format!("! {asked}"));
        let bytes = self.sim.request(self.source, payload);
        let refused = Records::new(&bytes)
            .flatten()
            .find(|record| !record.status.is_success() && record.status != Status::WRONG_REQUEST);
        match refused {
            Some(record) => {
                let came = quoted(&AnswerText(record).to_string());
                Err(self.failure(text::RunTaken { asked }.words(), came))
            }
            None => Ok(()),
        }
    }

    fn reach(&mut self, state: State) -> Result<(), Failure> {
        for way in state {
            match way {
                Reach::Ask(asked) => {
                    let payload =
                        payload(asked).map_err(|error| self.failure(error, quoted(asked)))?;
                    self.prepare(asked, &payload)?;
                }
                Reach::After(ms) => self.advance(*ms)?,
                Reach::Until(condition) => {
                    let condition = Condition::parse(condition)
                        .map_err(|error| self.failure(error, quoted(condition)))?;
                    self.until(&condition, REACH_MAX_MS)?;
                }
                Reach::With(subsystem, ways) => {
                    let there = Condition::parse(&format!("{subsystem} flags != none"))
                        .is_ok_and(|exists| exists.holds(&mut self.sim).is_ok());
                    if there {
                        self.reach(ways)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn advance(&mut self, ms: u64) -> Result<(), Failure> {
        let end_ms = self.sim.now_ms() + ms;
        while self.sim.now_ms() < end_ms {
            self.sim.tick();
            self.check_watches()?;
        }
        Ok(())
    }

    fn until(&mut self, condition: &Condition, ms: u64) -> Result<(), Failure> {
        self.checks += 1;
        let start_ms = self.sim.now_ms();
        let end_ms = start_ms + ms;
        loop {
            let (holds, came) = self.holds(condition)?;
            if holds {
                self.last_wait_ms = self.sim.now_ms() - start_ms;
                self.say(format!("until {condition}"));
                return Ok(());
            }
            if self.sim.now_ms() >= end_ms {
                let expected = text::RunWithin { condition: Shown(condition), ms };
                return Err(self.failure(expected.words(), Words::same(came)));
            }
            self.sim.tick();
            self.check_watches()?;
        }
    }

    fn holds(&mut self, condition: &Condition) -> Result<(bool, String), Failure> {
        let expected = || Words::same(condition.to_string());
        condition.holds(&mut self.sim).map_err(|error| self.failure(expected(), error))
    }

    fn check_watches(&mut self) -> Result<(), Failure> {
        for index in 0..self.watches.len() {
            let (line, condition, forbidden) = self.watches[index];
            let (holds, came) = self.holds(condition)?;
            if holds == forbidden {
                self.line = line;
                let word = if forbidden { "never" } else { "always" };
                let expected = Words::same(format!("{word} {condition}"));
                return Err(self.failure(expected, Words::same(came)));
            }
        }
        Ok(())
    }
}

/// Answers as text; each beside its request where it is clear which one that is.
pub(crate) fn answers_text(payload: &[u8], bytes: &[u8]) -> Vec<String> {
    let requests: Vec<Record<'_>> = Records::new(payload).flatten().collect();
    let answers: Vec<Record<'_>> = Records::new(bytes).flatten().collect();
    let paired = requests.len() == answers.len() || requests.len() == 1;
    let mut lines = Vec::new();
    for (index, record) in answers.iter().enumerate() {
        let request = requests.get(index).or(requests.first());
        let request = request.filter(|request| paired && request.request == record.request);
        lines.push(match (request.map(Request::decode), Answer::decode(record)) {
            (Some(Ok(request)), Ok(answer)) => Exchange::new(&request, answer).to_string(),
            _ => AnswerText(*record).to_string(),
        });
    }
    lines
}

/// Whether a line is the expected one; `*` at its end matches anything.
fn fits(wanted: &str, came: &str) -> bool {
    let plain = wanted.replace("->", "→");
    match plain.strip_suffix('*') {
        Some(start) => came.starts_with(start.trim_end()),
        None => came == plain,
    }
}
