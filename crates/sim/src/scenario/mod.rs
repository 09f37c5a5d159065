//! Scenarios: readable text that drives a simulated monitor and says what must come.
//!
//! `conformance/scenarios/README.md` describes the format. A file has a heading and cases; each
//! case runs on a fresh simulator, on virtual time. The tests run every file.

mod run;

use lafet_device::Source;
use lafet_device::hal::Key;
use lafet_device::image::Axis;
use lafet_proto::flags::Button;
use lafet_proto::record::Writer;
use lafet_proto::text as wire;
use lafet_texts::{Argument, Lang, Shown, Text, Words, parse_error_text, sim as text};

use crate::condition::Condition;
use crate::fault::{Fault, Post, axis_name, button_name};
use crate::fire::FireSpec;
use crate::flash::{Cut, Torn};
use crate::sim::Config;
use run::Run;
pub(crate) use run::answers_text;

/// Longest time that a line may take, ms.
const WAIT_MAX_MS: u64 = 3_600_000;

/// A scenario file, understood.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Name of the file, as failures show it.
    pub file: String,
    /// Its cases.
    pub cases: Vec<Case>,
}

/// A case: what is set up, and what happens.
#[derive(Clone, Debug)]
pub struct Case {
    /// What follows `case`.
    pub title: String,
    /// Line of the file on which it starts.
    pub line: usize,
    setup: Config,
    steps: Vec<(usize, Step)>,
}

#[derive(Clone, Debug)]
enum Step {
    State(State),
    Ask { text: String, payload: Vec<u8>, expected: Vec<(usize, String)> },
    Prepare { text: String, payload: Vec<u8> },
    Source(Source),
    After(u64),
    Until(Condition, u64),
    Expect(Condition),
    Watch { condition: Condition, forbidden: bool },
    EndWatch,
    Press(Post, Button, bool),
    Inject(Fault),
    Clear(Option<Fault>),
    PowerCycle,
    PowerCut(Cut),
    Crash,
    Damage(Key),
    Fire(FireSpec),
}

/// A state that `state NAME` brings about by real requests.
type State = &'static [Reach];

#[derive(Clone, Copy, Debug)]
enum Reach {
    Ask(&'static str),
    After(u64),
    Until(&'static str),
    /// Only where the monitor has this subsystem.
    With(&'static str, State),
}

const DEPLOYED: State = &[Reach::With(
    "Deployer",
    &[
        Reach::Until("Deployer flags lacks Move"),
        Reach::Ask("Deploy Deployer"),
        Reach::Until("Deployer flags has Deployed"),
    ],
)];
const UP: Reach = Reach::With("Deployer", DEPLOYED);

/// Names of the states, and how each is reached from the state after power-up.
const STATES: &[(&str, State)] = &[
    ("wrapped", &[Reach::Until("Deployer flags has Wrapped")]),
    ("deployed", DEPLOYED),
    ("deploying", &[Reach::Ask("Deploy Deployer"), Reach::After(1_000)]),
    ("wrapping", &[UP, Reach::Ask("Wrap Deployer"), Reach::After(1_000)]),
    (
        "seeking",
        &[
            UP,
            Reach::Ask("StartSeek Detector -5400 5400 -600 600"),
            Reach::Until("Detector flags has Searching"),
            Reach::After(500),
        ],
    ),
    ("justifying", &[UP, Reach::Ask("StartJustify Detector"), Reach::After(100)]),
    (
        "quenching",
        &[
            UP,
            Reach::Ask(
                "StartQuench Control centre=0,300 nozzle=60 sector=600,300 step=2 distance=0",
            ),
            Reach::Until("Control flags has Quench"),
            Reach::After(500),
        ],
    ),
    ("moving", &[UP, Reach::Ask("Move Horizontal 9000"), Reach::After(500)]),
    ("open", &[UP, Reach::Ask("Open Valve1"), Reach::Until("Valve1 flags has Open")]),
    ("limits-off", &[UP, Reach::Ask("SwitchLimits Horizontal off")]),
    ("locked-out", &[Reach::Ask("Lockout All on"), Reach::After(100)]),
    ("erased", &[Reach::Ask("CleanFlash General"), Reach::Until("world resets = 1")]),
];

/// What a scenario that held has checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Cases run.
    pub cases: usize,
    /// Answers and conditions checked; a watch counts once.
    pub checks: usize,
    /// Virtual time that passed, ms.
    pub virtual_ms: u64,
    /// Virtual time that the last `until` waited, ms.
    pub last_wait_ms: u64,
}

/// A scenario that does not hold, or cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// File.
    pub file: String,
    /// Line in it.
    pub line: usize,
    /// What was expected there.
    pub expected: Box<Words>,
    /// What came.
    pub came: Box<Words>,
    /// The last lines of the transcript, and the monitor's state.
    pub tail: Vec<String>,
}

impl Argument for Failure {
    fn write(&self, lang: Lang, out: &mut dyn core::fmt::Write) -> core::fmt::Result {
        let Self { file, line, expected, came, .. } = self;
        text::FailureExpected { file, line: Shown(line), expected: &**expected }
            .write(lang, out)?;
        out.write_str("\n    ")?;
        text::FailureCame { came: &**came }.write(lang, out)?;
        self.tail.iter().try_for_each(|line| write!(out, "\n    | {line}"))
    }
}

impl Text for Failure {}

impl core::fmt::Display for Failure {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.write(Lang::En, f)
    }
}

impl core::error::Error for Failure {}

impl Scenario {
    /// Reads a scenario.
    pub fn parse(file: &str, text: &str) -> Result<Self, Failure> {
        Self::from_lines(file, (1..).zip(text.lines()))
    }

    /// Reads a scenario from lines with their numbers in the file.
    pub fn from_lines<'a>(
        file: &str,
        lines: impl Iterator<Item = (usize, &'a str)>,
    ) -> Result<Self, Failure> {
        let mut heading = Config::default();
        let mut cases: Vec<Case> = Vec::new();
        for (number, line) in lines {
            let line = line.trim();
            let failed = |expected: Words| Failure {
                file: file.to_owned(),
                line: number,
                expected: expected.into(),
                came: quoted(line).into(),
                tail: Vec::new(),
            };
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            let rest = rest.trim();
            let Some(case) = cases.last_mut() else {
                match word {
                    "case" => cases.push(Case::new(rest, number, heading.clone())),
                    _ => match configure(&mut heading, word, rest) {
                        Some(done) => done.map_err(failed)?,
                        None => return Err(failed(text::LineFirst.words())),
                    },
                }
                continue;
            };
            if word == "case" {
                let next = Case::new(rest, number, heading.clone());
                cases.push(next);
            } else {
                case.read(number, word, rest).map_err(failed)?;
            }
        }
        for case in &cases {
            case.complete(file)?;
        }
        Ok(Self { file: file.to_owned(), cases })
    }

    /// Runs every case; `log` gets the transcript line by line.
    pub fn run(&self, log: &mut dyn FnMut(&str)) -> Result<Report, Failure> {
        let mut report = Report::default();
        for case in &self.cases {
            log(&format!("case {}", case.title));
            let mut run = Run::new(self, case, log);
            for (line, step) in &case.steps {
                run.line = *line;
                run.step(step)?;
            }
            report.cases += 1;
            report.checks += run.checks;
            report.virtual_ms += run.sim.now_ms();
            report.last_wait_ms = run.last_wait_ms;
        }
        Ok(report)
    }
}

impl Case {
    fn new(title: &str, line: usize, setup: Config) -> Self {
        Self { title: title.to_owned(), line, setup, steps: Vec::new() }
    }

    /// One line of the case. `Err` is what was expected.
    fn read(&mut self, number: usize, word: &str, rest: &str) -> Result<(), Words> {
        if word == "<" {
            return match self.steps.last_mut() {
                Some((_, Step::Ask { expected, .. })) => {
                    expected.push((number, rest.to_owned()));
                    Ok(())
                }
                _ => Err(text::LineAnswer.words()),
            };
        }
        // `fire` is a setting before anything has happened, and an action later.
        if self.steps.is_empty()
            && let Some(done) = configure(&mut self.setup, word, rest)
        {
            return done;
        }
        self.steps.push((number, step(word, rest)?));
        Ok(())
    }

    /// A case that checks nothing proves nothing.
    fn complete(&self, file: &str) -> Result<(), Failure> {
        let is_watch = |step: &Step| matches!(step, Step::Watch { .. });
        let watch = self.steps.iter().position(|(_, step)| is_watch(step));
        let failed = |line, expected: Words, came: Words| Failure {
            file: file.to_owned(),
            line,
            expected: expected.into(),
            came: came.into(),
            tail: Vec::new(),
        };
        for (line, step) in &self.steps {
            if let Step::Ask { text: asked, expected, .. } = step
                && expected.is_empty()
            {
                let needed = text::LineNeedsAnswer.words();
                return Err(failed(*line, needed, Words::same(asked)));
            }
        }
        let before = watch.unwrap_or(self.steps.len());
        let early = self.steps[..before].iter().find(|(_, step)| matches!(step, Step::EndWatch));
        if let Some((line, _)) = early {
            let (begun, nothing) = (text::LineEarlyEnd.words(), text::LineNothingToEnd.words());
            return Err(failed(*line, begun, nothing));
        }
        let checks = |step: &Step| {
            matches!(
                step,
                Step::Ask { .. } | Step::Expect(_) | Step::Until(..) | Step::Watch { .. }
            )
        };
        if self.steps.iter().any(|(_, step)| checks(step)) {
            Ok(())
        } else {
            Err(failed(self.line, text::LineChecks.words(), text::LineNothing.words()))
        }
    }
}

/// A line as it is, in quotes.
fn quoted(line: &str) -> Words {
    Words::same(format!("`{line}`"))
}

/// A setting; `None` when the word is none.
fn configure(config: &mut Config, word: &str, rest: &str) -> Option<Result<(), Words>> {
    let finite = |text: &str| text.trim().parse().ok().filter(|it: &f64| it.is_finite());
    let number = || finite(rest).ok_or_else(|| text::LineNumber.words());
    let pair = || {
        let both = rest.split_once(' ').and_then(|(a, b)| Some((finite(a)?, finite(b)?)));
        both.ok_or_else(|| text::LineTwoNumbers.words())
    };
    Some(match word {
        "profile" => config.profile(rest).ok_or_else(|| text::LineProfile.words()),
        "seed" => read(rest, text::LineNumber).map(|seed| config.seed = seed),
        "address" => read(rest, text::LineAddress).map(|address| config.address = address),
        "clock" => read(rest, text::LineMilliseconds).map(|ms| config.clock_ms = ms),
        "fire" => rest.parse().map(|fire| config.fires.push(fire)),
        "glare" => rest.parse().map(|glare| config.glares.push(glare)),
        "wall" => rest.parse().map(|wall| config.walls.push(wall)),
        "ambient" => number().map(|celsius| config.ambient_c = celsius),
        "nozzle" => number().map(|mm| config.nozzle_mm = mm),
        "wind" => pair().map(|wind| config.wind = wind),
        "gusts" => number().map(|gusts| config.gusts = gusts),
        "relative" => {
            let axis = Axis::ALL.into_iter().find(|axis| axis_name(*axis) == rest);
            axis.map(|axis| config.relative[axis as usize] = true)
                .ok_or_else(|| text::LineDrive.words())
        }
        "misalignment" => pair().map(|angles| config.misalignment = angles),
        _ => return None,
    })
}

/// A value, or what was expected instead.
fn read<T: core::str::FromStr>(rest: &str, expected: impl Text) -> Result<T, Words> {
    rest.parse().map_err(|_| expected.words())
}

/// The words that a line of a case begins with.
const WORDS: &str = "> ! < state source after until expect never always end press release inject \
                     clear power crash damage fire";

fn step(word: &str, rest: &str) -> Result<Step, Words> {
    let condition = || Condition::parse(rest);
    Ok(match word {
        ">" => Step::Ask { text: rest.to_owned(), payload: payload(rest)?, expected: Vec::new() },
        "!" => Step::Prepare { text: rest.to_owned(), payload: payload(rest)? },
        "state" => {
            let state = STATES.iter().find(|(name, _)| *name == rest);
            let names: Vec<&str> = STATES.iter().map(|(name, _)| *name).collect();
            let known = || text::LineOneOf { known: names.join(", ") }.words();
            Step::State(state.ok_or_else(known)?.1)
        }
        "source" => Step::Source(match rest {
            "external" => Source::ExternalConn,
            "radio" => Source::Radio,
            _ => return Err(text::LineSource.words()),
        }),
        "after" => Step::After(duration(rest)?),
        "until" => {
            let parts = rest.rsplit_once(" within ");
            let (condition, time) = parts.ok_or_else(|| text::LineUntil.words())?;
            Step::Until(Condition::parse(condition)?, duration(time)?)
        }
        "expect" => Step::Expect(condition()?),
        "never" => Step::Watch { condition: condition()?, forbidden: true },
        "always" => Step::Watch { condition: condition()?, forbidden: false },
        "end" if matches!(rest, "never" | "always" | "") => Step::EndWatch,
        "press" | "release" => {
            let (post, button) = button(rest).ok_or_else(|| text::LineButton.words())?;
            Step::Press(post, button, word == "press")
        }
        "inject" | "clear" => {
            let name = rest.strip_prefix("fault ").unwrap_or(rest);
            match (word, name) {
                ("clear", "all") => Step::Clear(None),
                (_, name) => {
                    let fault = Fault::from_name(name).ok_or_else(|| text::LineFault.words())?;
                    if word == "inject" { Step::Inject(fault) } else { Step::Clear(Some(fault)) }
                }
            }
        }
        "power" if rest == "cycle" => Step::PowerCycle,
        "power" => Step::PowerCut(power_cut(rest).ok_or_else(|| text::LinePower.words())?),
        "crash" if rest.is_empty() => Step::Crash,
        "crash" => return Err(text::LineCrash.words()),
        "damage" => Step::Damage(Key(read(rest, text::LineDamage)?)),
        "fire" => Step::Fire(rest.parse::<FireSpec>()?),
        _ => return Err(text::LineWord { known: WORDS }.words()),
    })
}

fn power_cut(text: &str) -> Option<Cut> {
    let (step, torn) = text.strip_prefix("cut ")?.split_once(' ')?;
    let torn = Torn::ALL.into_iter().find(|known| known.name() == torn)?;
    Some(Cut { step: step.parse().ok()?, torn })
}

/// Records of `A ; B`, or the bytes of `hex 4d 0d …` as they are.
fn payload(requests: &str) -> Result<Vec<u8>, Words> {
    if let Some(bytes) = requests.strip_prefix("hex") {
        let not_hex = |word: &str| text::LineHex { word }.words();
        let byte = |word: &str| u8::from_str_radix(word, 16).map_err(|_| not_hex(word));
        return bytes.split_whitespace().map(byte).collect();
    }
    let mut bytes = Vec::new();
    for part in requests.split(';').map(str::trim) {
        let (mut buffer, mut record) = ([0; wire::BUFFER_SIZE], [0; 260]);
        let not_read = |error| Words::each(|lang| parse_error_text(part, &error, lang));
        let request = wire::parse(part, &mut buffer).map_err(not_read)?;
        let mut writer = Writer::new(&mut record);
        request.encode(&mut writer).map_err(|error| Shown(error).words())?;
        bytes.extend_from_slice(writer.written());
    }
    Ok(bytes)
}

/// A time of at most an hour, ms: `500ms`, `2.5s`.
///
/// # Errors
///
/// What is expected instead.
pub fn duration(time: &str) -> Result<u64, Words> {
    let time = time.trim();
    let in_seconds = || time.strip_suffix('s').map(|number| (number, 1000.0));
    let parts = time.strip_suffix("ms").map(|number| (number, 1.0)).or_else(in_seconds);
    let value = |number: &str| number.trim().parse().ok().filter(|it: &f64| *it >= 0.0);
    let ms = parts.and_then(|(number, factor)| Some((value(number)? * factor) as u64));
    match ms {
        Some(ms) if ms <= WAIT_MAX_MS => Ok(ms),
        Some(_) => Err(text::LineHour.words()),
        None => Err(text::LineTime.words()),
    }
}

fn button(text: &str) -> Option<(Post, Button)> {
    let (post, button) = text.split_once(' ')?;
    let post = Post::ALL.iter().find(|known| known.name() == post)?;
    let button = Button::ALL.into_iter().find(|known| button_name(*known) == button.trim())?;
    Some((*post, button))
}
