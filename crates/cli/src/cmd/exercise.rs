//! `lafet sim run`: a scenario in virtual time; `lafet sim --site`: its monitors on the network.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, ValueEnum};
use lafet_sim::exercise::{self, Director, Exercise, SHIPPED, Shipped};
use lafet_sim::radio::RadioConfig;
use lafet_texts::{Shown, Text as _, cli as text};
use serde_json::json;
use tokio::task::JoinSet;

use super::sim::{by_radio, cannot_listen};
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::{Out, columns};
use crate::serve::{Listen, SharedSite, pace};

/// Simulated time before the first request, in which the monitors read their sensors, ms.
const POWER_UP_MS: u64 = 200;

/// Arguments of `lafet sim run`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  lafet sim run --list\n  lafet sim run tank-farm --svg tank-farm.svg\n  \
                  lafet sim run my-site.toml --seed 3 --report json"
)]
pub struct RunArgs {
    #[arg(value_name = "SCENARIO", required_unless_present = "list")]
    file: Option<String>,
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    #[arg(long, value_name = "FORM", value_enum, default_value_t = Form::Text)]
    report: Form,
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    #[arg(long)]
    list: bool,
    #[arg(long)]
    show: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Form {
    Text,
    Json,
}

/// Runs a scenario; succeeds if every expectation holds.
pub fn run(args: &RunArgs, out: &mut Out) -> Outcome {
    let Some(name) = args.file.as_deref().filter(|_| !args.list) else { return list(out) };
    if args.show {
        let text = text_of(name)?.1;
        return out.show(text.trim_end(), || json!({ "scenario": text }));
    }
    let exercise = Arc::new(read(name)?);
    let seed = args.seed.unwrap_or(exercise.site.seed);
    let outcome = exercise::run(&exercise, seed, args.trace.is_some());
    if let Some(path) = &args.svg {
        write(path, &exercise::svg(&outcome, current()))?;
    }
    if let Some(path) = &args.trace {
        write(path, &outcome.trace)?;
    }
    match args.report {
        Form::Json => out.value(&exercise::json(&outcome))?,
        Form::Text => {
            out.show(exercise::text(&outcome, current()), || exercise::json(&outcome))?;
        }
    }
    if outcome.passed() {
        return Ok(());
    }
    let failed = outcome.checks.iter().filter(|check| !check.passed).count();
    Err(Failure::Ended(text::ExpectationsFailed { failed }.of(current())))
}

/// Settings of `lafet sim --site`.
pub struct Serving<'a> {
    /// A file, or the name of a scenario that comes with lafet.
    pub scenario: &'a str,
    /// Seed; `None` takes the scenario's.
    pub seed: Option<u64>,
    /// Simulated seconds per second of real time.
    pub speed: f64,
    /// Addresses to listen on; empty takes the scenario's.
    pub listen: Vec<Listen>,
    /// The radio channel between the radio interfaces and their clients.
    pub radio: Option<RadioConfig>,
}

/// Serves the monitors of a scenario until SIGINT or SIGTERM.
pub async fn serve(serving: Serving<'_>, out: &mut Out) -> Outcome {
    let Serving { scenario, seed, speed, listen, radio } = serving;
    let mut interrupt = Interrupt::catch()?;
    let exercise = Arc::new(read(scenario)?);
    let seed = seed.unwrap_or(exercise.site.seed);
    let mut places = places(&exercise, listen)?;
    let members: Vec<usize> = (0..exercise.monitors.len()).collect();
    let mut radios: Vec<Listen> =
        places.iter().map(|(place, _)| place.clone()).filter(Listen::is_radio).collect();
    let listed = radios.len();
    let air = by_radio(radio, seed, &mut radios)?;
    places.extend(radios.into_iter().skip(listed).map(|place| (place, members.clone())));
    let mut director = Director::new(Arc::clone(&exercise), seed);
    director.advance_ms(POWER_UP_MS);
    let site = SharedSite::new(director);
    let mut tasks = JoinSet::new();
    if let Some(air) = &air {
        tasks.spawn(air.clone().carry(site.tap(members)));
    }
    for (place, members) in places {
        let listening = place.open().await.map_err(|error| cannot_listen(&place, error))?;
        for member in &members {
            let name = &exercise.monitors[*member].name;
            let address = exercise.site.monitors[*member].sim.address;
            let sign = if listening.url().contains('?') { '&' } else { '?' };
            let url = format!("{}{sign}addr={address}", listening.url());
            out.show(
                format!("listening {name} {url}"),
                || json!({ "listening": url, "monitor": name, "address": address }),
            )?;
        }
        tasks.spawn(listening.serve_over(air.clone(), site.tap(members)));
    }
    let all = site.tap(Vec::new());
    tasks.spawn(async move {
        pace(all, speed).await;
        Ok(())
    });
    let told = tell(&site, out);
    let ended = tokio::select! {
        () = interrupt.wait() => return Ok(()),
        ended = told => ended.err(),
        Some(ended) = tasks.join_next() => match ended {
            Ok(Err(error)) => Some(Failure::io(text::TheSimulator.str(current()), error)),
            _ => None,
        },
    };
    let failed = || Failure::Ended(text::SimulatorFailed.str(current()).into());
    Err(ended.unwrap_or_else(failed))
}

/// Prints the events of the site as they happen.
async fn tell(site: &SharedSite, out: &mut Out) -> Outcome {
    let mut ticks = tokio::time::interval(std::time::Duration::from_millis(100));
    loop {
        ticks.tick().await;
        let happened = {
            let mut director = site.lock();
            let mut happened = director.take_happened();
            happened.extend(director.take_fires());
            happened
        };
        for (at_ms, text) in happened {
            let at_s = at_ms as f64 / 1000.0;
            let text = text.of(current());
            out.show(format!("{at_s:8.1} {text}"), || json!({ "at_s": at_s, "event": text }))?;
        }
    }
}

/// Each address to listen on, with the indices of the monitors behind it.
fn places(exercise: &Exercise, listen: Vec<Listen>) -> Result<Vec<(Listen, Vec<usize>)>, Failure> {
    let all: Vec<usize> = (0..exercise.monitors.len()).collect();
    if !listen.is_empty() {
        return Ok(listen.into_iter().map(|place| (place, all.clone())).collect());
    }
    let wrong = |text: &str, why: String| {
        Failure::Usage(format!("{}: listen = \"{text}\": {why}", exercise.file))
    };
    let mut places = Vec::new();
    for text in &exercise.bus {
        places.push((text.parse().map_err(|why| wrong(text, why))?, all.clone()));
    }
    for (index, monitor) in exercise.monitors.iter().enumerate() {
        for text in &monitor.listen {
            places.push((text.parse().map_err(|why| wrong(text, why))?, vec![index]));
        }
    }
    if places.is_empty() {
        let port = lafet_proto::bus::PORT_EXTERNAL_CONN;
        places.push((Listen::tcp(format!("127.0.0.1:{port}")), all));
    }
    Ok(places)
}

fn list(out: &mut Out) -> Outcome {
    let mut rows = Vec::new();
    let mut values = Vec::new();
    for shipped in SHIPPED {
        let exercise =
            shipped.exercise().map_err(|problem| Failure::Usage(problem.told(current())))?;
        values.push(json!({
            "name": shipped.name,
            "title": { "en": exercise.title.en, "ru": exercise.title.ru },
            "monitors": exercise.monitors.len(),
            "duration_s": exercise.duration_ms as f64 / 1000.0,
        }));
        let monitors = exercise.monitors.len();
        let minutes = exercise.duration_ms as f64 / 60_000.0;
        rows.push(vec![
            shipped.name.to_owned(),
            text::MonitorsCount { monitors }.of(current()),
            text::MinutesCount { minutes: format_args!("{minutes:.1}") }.of(current()),
            exercise.title.of(current()).to_owned(),
        ]);
    }
    out.show(columns(&rows), || json!({ "scenarios": values }))
}

fn read(name: &str) -> Result<Exercise, Failure> {
    let (file, text) = text_of(name)?;
    Exercise::parse(&file, &text).map_err(|problem| Failure::Usage(problem.told(current())))
}

/// Name of the scenario for error messages, and its text. A file takes precedence over a name.
fn text_of(name: &str) -> Result<(String, String), Failure> {
    match std::fs::read_to_string(name) {
        Ok(text) => Ok((name.to_owned(), text)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => match Shipped::by_name(name) {
            Some(shipped) => Ok((format!("{}.toml", shipped.name), shipped.text.to_owned())),
            None => Err(Failure::Usage(unknown(name))),
        },
        Err(error) => Err(Failure::io(text::CannotReadScenario { name }.of(current()), error)),
    }
}

fn unknown(name: &str) -> String {
    let known: Vec<&str> = SHIPPED.iter().map(|shipped| shipped.name).collect();
    let known = known.join(", ");
    text::NoSuchScenario { name, known }.of(current())
}

/// Writes a file.
pub fn write(path: &Path, text: &str) -> Outcome {
    std::fs::write(path, text).map_err(|error| {
        let path = path.display();
        let what = text::CannotWritePath { path: Shown(path) }.of(current());
        Failure::io(what, error)
    })
}
