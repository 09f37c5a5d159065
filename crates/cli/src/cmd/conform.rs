//! `lafet conform`: tests whether a monitor does what the protocol says.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use clap::Args;
use lafet_client::{Endpoint, Error};
use lafet_conform::line::{Cut, LinkLine};
use lafet_conform::{Level, Options, Progress, Report, report};
use lafet_texts::{Text as _, cli as text};
use lafet_update::BoardName;
use serde_json::{Value, json};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio::time::Instant;

use crate::cli::Global;
use crate::cmd::image::board;
use crate::connect::{alone, url_of};
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::{Out, columns};
use crate::simulator;
use crate::undo::REACH;

/// How many times an unanswered read is sent.
const TRIES: u32 = 3;

/// Arguments of `lafet conform`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  lafet conform tcp://192.168.1.50:10485?addr=3\n  \
                        lafet conform sim:?speed=20 --full --html report.html\n  \
                        lafet -c serial:///dev/ttyUSB0?baud=19200 conform --motion --only §3.2")]
pub struct ConformArgs {
    #[arg(value_name = "URL")]
    url: Option<String>,
    #[arg(long)]
    list: bool,
    #[arg(long, group = "level")]
    read_only: bool,
    #[arg(long, group = "level")]
    motion: bool,
    #[arg(long, group = "level")]
    full: bool,
    #[arg(long, group = "level")]
    erase: bool,
    #[arg(long)]
    strict: bool,
    #[arg(long)]
    fail_fast: bool,
    #[arg(long, value_name = "ITEM")]
    only: Vec<String>,
    #[arg(short, long)]
    quiet: bool,
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    #[arg(long, value_name = "FILE")]
    text: Option<PathBuf>,
    #[arg(long, value_name = "BOARD", value_parser = board)]
    board: Option<BoardName>,
    #[arg(long, value_name = "FACTOR", value_parser = simulator::speed)]
    speed: Option<f64>,
}

impl ConformArgs {
    const fn level(&self) -> Level {
        match () {
            () if self.erase => Level::Erase,
            () if self.full => Level::Full,
            () if self.motion => Level::Motion,
            () => Level::ReadOnly,
        }
    }

    fn options(&self, endpoint: &Endpoint, global: &Global) -> Options {
        let addresses = endpoint.addresses();
        // Not every keyboard has a paragraph sign.
        let item = |text: &String| match text.chars().next() {
            Some('0'..='9' | 'A'..='Z') => format!("§{text}"),
            _ => text.clone(),
        };
        Options {
            level: self.level(),
            strict: self.strict,
            fail_fast: self.fail_fast,
            only: self.only.iter().map(item).collect(),
            monitor: addresses.monitor,
            source: addresses.source,
            framing: endpoint.framing(),
            // The timeout scales with the clock, because the time on the way does not.
            timeout_ms: (global.timeout * 1000.0 * self.clock(endpoint)) as u64,
            board: self.board.map(|board| board.as_str().to_owned()),
            ..Options::default()
        }
    }

    fn clock(&self, endpoint: &Endpoint) -> f64 {
        let of_url = match endpoint {
            Endpoint::Sim { query, .. } => query
                .iter()
                .find(|(key, _)| key == "speed")
                .and_then(|(_, value)| simulator::speed(value).ok()),
            _ => None,
        };
        self.speed.or(of_url).unwrap_or(1.0)
    }
}

/// Messages from the run to the output.
enum Told {
    Begins(String),
    Ended { line: String, passed: bool },
    PuttingBack,
    Cut,
}

/// Runs `lafet conform`.
pub async fn run(args: ConformArgs, global: &Global, out: &mut Out) -> Outcome {
    if args.list {
        return list(args.level(), out);
    }
    let connect = args.url.clone().or_else(|| global.connect.clone());
    let global = Global { connect, ..global.clone() };
    let url = url_of(&global)?.to_owned();
    let endpoint = Endpoint::from_str(&url).map_err(Error::from)?;
    let options = args.options(&endpoint, &global);
    if let Some(wrong) = options.only.iter().find(|id| !lafet_conform::is_known(id)) {
        return Err(Failure::Usage(text::NoSuchTest { wrong }.of(current())));
    }
    if options.level >= Level::Full {
        out.progress(text::ConformTakesLong.str(current()));
    }
    let (mut report, shown, given_up) = tested(&args, &endpoint, &options, &global, out).await?;
    report.url = url;
    let written = write(&args, &report);
    let shown = shown.and_then(|()| {
        out.show(report::summary(&report, current()), || report::json(&report, current()))
    });
    match outcome(&report, &options, given_up) {
        // No error of a file may hide that something still moves.
        Err(failure @ Failure::NotAtRest(_)) => Err(failure),
        outcome => written.and(shown).and(outcome),
    }
}

/// Lists the tests up to a level; needs no monitor.
fn list(level: Level, out: &mut Out) -> Outcome {
    let tests: Vec<_> = lafet_conform::tests().filter(|test| test.2 <= level).collect();
    let rows: Vec<Vec<String>> = tests
        .iter()
        .map(|(item, name, level)| vec![(*item).into(), (*name).into(), level.name().into()])
        .collect();
    out.show(columns(&rows), || {
        let one = |(item, name, level): &(&str, &str, Level)| {
            json!({ "item": item, "name": name, "level": level.name() })
        };
        Value::Array(tests.iter().map(one).collect())
    })
}

/// Runs the tests; returns the report, whether all of it could be shown, and whether the user gave up. A
/// reader that is gone ends the tests like Ctrl-C: everything is restored.
async fn tested(
    args: &ConformArgs,
    endpoint: &Endpoint,
    options: &Options,
    global: &Global,
    out: &mut Out,
) -> Result<(Report, Outcome, bool), Failure> {
    let mut interrupt = Interrupt::catch()?;
    let url = url_of(global)?;
    let open = tokio::select! {
        open = alone(url, endpoint, global) => open?,
        () = interrupt.wait() => return Err(Failure::Interrupted),
    };
    let handle = tokio::runtime::Handle::current();
    let again = Some(endpoint.clone());
    let (told, mut hear) = unbounded_channel();
    let (of_cut, give_up) = (told.clone(), Arc::default());
    let cut = Cut {
        tell: Some(Arc::new(move || _ = of_cut.send(Told::Cut))),
        give_up: Arc::clone(&give_up),
    };
    let line = LinkLine::new(open, again, handle, args.clock(endpoint));
    let mut line = line.when_cut(cut);
    let of_thread = options.clone();
    let mut running = tokio::task::spawn_blocking(move || {
        lafet_conform::run(&mut line, &of_thread, &mut |progress| tell(&told, progress))
    });
    let mut all = Ok(());
    let mut since = None;
    let report = loop {
        tokio::select! {
            biased;
            Some(told) = hear.recv() => {
                all = all.and(show(told, args.quiet, out));
                options.interrupt.fetch_or(all.is_err(), Ordering::Relaxed);
            }
            caught = interrupt.next() => {
                give_up.fetch_or(caught.gives_up(since), Ordering::Relaxed);
                since.get_or_insert_with(Instant::now);
                options.interrupt.store(true, Ordering::Relaxed);
                out.progress(text::InterruptedRestoring.str(current()));
            }
            report = &mut running => break report,
        }
    };
    while let Ok(told) = hear.try_recv() {
        all = all.and(show(told, args.quiet, out));
    }
    let given_up = since.is_some() && give_up.load(Ordering::Relaxed);
    report.map(|report| (report, all, given_up)).map_err(|error| Failure::Ended(error.to_string()))
}

/// Sends a message; the receiver may be gone when the command is about to end.
fn tell(told: &UnboundedSender<Told>, progress: Progress<'_>) {
    let _ = told.send(match progress {
        Progress::Begins { number, of, test: (name, item) } => {
            Told::Begins(format!("{number}/{of}  {item} {name}"))
        }
        Progress::Ended(test) => Told::Ended {
            line: report::test_lines(test, current()),
            passed: test.outcome == lafet_conform::Outcome::Pass,
        },
        Progress::PuttingBack => Told::PuttingBack,
    });
}

fn show(told: Told, quiet: bool, out: &mut Out) -> Outcome {
    match told {
        // Only a live line is overwritten; otherwise the result line that follows repeats the name.
        Told::Begins(text) if out.is_live() => out.progress(text),
        Told::Begins(_) => {}
        Told::Ended { passed: true, .. } if quiet => {}
        Told::Ended { line, .. } => out.say(line)?,
        Told::Cut => out.warn(&cut_off()),
        Told::PuttingBack => out.progress(text::RestoringEverything.str(current())),
    }
    Ok(())
}

fn cut_off() -> String {
    let seconds = REACH.as_secs();
    text::ConformLostMonitor { seconds }.of(current())
}

fn write(args: &ConformArgs, found: &Report) -> Outcome {
    let lang = current();
    let write = |path: &Option<PathBuf>, make: fn(&Report, lafet_client::Lang) -> String| {
        path.as_deref().map_or(Ok(()), |path| save(path, &make(found, lang)))
    };
    write(&args.html, report::html)?;
    write(&args.junit, report::junit)?;
    write(&args.text, report::text)
}

fn save(path: &Path, text: &str) -> Outcome {
    let what = || text::CannotWrite.str(current());
    std::fs::write(path, text)
        .map_err(|error| Failure::io(format!("{} {}", what(), path.display()), error))
}

fn outcome(report: &Report, options: &Options, given_up: bool) -> Outcome {
    if report.cut {
        let why = match given_up {
            true => text::ConformGivenUp.str(current()),
            false => text::ConformCutOff.str(current()),
        };
        return Err(Failure::NotAtRest(why.into()));
    }
    if options.interrupt.load(Ordering::Relaxed) {
        return Err(Failure::Interrupted);
    }
    match report.exit_code() {
        0 => Ok(()),
        3 => Err(Error::Absent { endpoint: Arc::from(report.url.as_str()), tries: TRIES }.into()),
        _ => Err(Failure::Ended(String::new())),
    }
}
