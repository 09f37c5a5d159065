//! Runs the swarm on all cores and prints what was seen: `cargo xtask swarm`.
//!
//! Fails when something must never happen has happened, and when something that must happen has not been
//! seen in a run of at least [`WITNESS_SEEDS`] seeds.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use lafet_verify::swarm::{Outcome, PAIRS_SEED, Tally, pairs, run as live};

/// From so many seeds on everything must have been witnessed. The rarest, a drive that loses its unit while it
/// moves, is not seen in the first 600.
const WITNESS_SEEDS: u64 = 1_400;
/// Of these everything must have been witnessed in a round of pairs.
const WITNESS_PAIRS: [&str; 4] = ["fault ", "output ", "profile ", "several faults at once"];
/// Steps that a round of pairs makes at least: shorter lives would show less.
const PAIRS_STEPS: u64 = 10_000_000;
/// Most rounds of pairs.
const ROUNDS_MAX: u64 = 1_000;
/// Longest time of a run, in either unit.
const TIME_MAX: f64 = 1e6;
/// A run ends after so many failures: more say nothing new.
const FAILURES_MAX: usize = 20;
/// Time between two lines of progress.
const PROGRESS: Duration = Duration::from_secs(10);

#[derive(Args)]
#[group(id = "length", required = true, multiple = true)]
pub struct Options {
    /// Seeds A up to B, without B
    #[arg(long, value_name = "A..B", value_parser = range, group = "length")]
    seeds: Option<Range<u64>>,
    /// Rounds of short lives with two faults each, in which every pair of faults has its own
    #[arg(long, value_name = "N", group = "length", conflicts_with = "seeds",
          value_parser = clap::value_parser!(u64).range(1..=ROUNDS_MAX))]
    pairs: Option<u64>,
    /// Longest time, minutes
    #[arg(long, value_name = "N", value_parser = duration, group = "length")]
    minutes: Option<f64>,
    /// Longest time, hours
    #[arg(long, value_name = "N", value_parser = duration, group = "length", conflicts_with = "minutes")]
    hours: Option<f64>,
    /// First seed
    #[arg(long, value_name = "SEED", conflicts_with = "seeds")]
    from: Option<u64>,
    /// Threads (default: one for each core)
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

fn range(text: &str) -> Result<Range<u64>, &'static str> {
    let ends =
        text.split_once("..").and_then(|(from, to)| Some((from.parse().ok()?, to.parse().ok()?)));
    match ends {
        Some((from, to)) if from < to => Ok(from..to),
        _ => Err("expected seeds A..B, like 0..600"),
    }
}

fn duration(text: &str) -> Result<f64, &'static str> {
    let time = text.parse().ok().filter(|time: &f64| *time > 0.0 && *time <= TIME_MAX);
    time.ok_or("expected a time, like 2.5")
}

struct Plan {
    from: u64,
    to: u64,
    time: Option<Duration>,
    threads: usize,
    pairs: bool,
}

impl Options {
    fn plan(&self) -> Plan {
        let cores = || thread::available_parallelism().map_or(1, usize::from);
        let Range { start, end } = match (&self.seeds, self.pairs) {
            (Some(seeds), _) => seeds.clone(),
            (None, Some(rounds)) => PAIRS_SEED..PAIRS_SEED + pairs() * rounds,
            (None, None) => 0..u64::MAX,
        };
        let minutes = self.minutes.or(self.hours.map(|hours| hours * 60.0));
        Plan {
            from: self.from.unwrap_or(start),
            to: end,
            time: minutes.map(|minutes| Duration::from_secs_f64(minutes * 60.0)),
            threads: self.threads.map_or_else(cores, NonZeroUsize::get),
            pairs: self.pairs.is_some(),
        }
    }
}

/// What all threads have in common.
struct Shared {
    next: AtomicU64,
    stop: AtomicBool,
    ended: Mutex<(Option<Tally>, BTreeMap<u64, Outcome>)>,
}

/// Runs the seeds and prints what was seen.
pub fn run(options: &Options) -> Result<(), String> {
    let plan = &options.plan();
    let began = Instant::now();
    let shared = Shared {
        next: AtomicU64::new(plan.from),
        stop: AtomicBool::new(false),
        ended: Mutex::new((None, BTreeMap::new())),
    };
    thread::scope(|scope| {
        let workers: Vec<_> =
            (0..plan.threads).map(|_| scope.spawn(|| work(plan, &shared, began))).collect();
        let mut told = Instant::now();
        while workers.iter().any(|worker| !worker.is_finished()) {
            thread::park_timeout(Duration::from_millis(100));
            if told.elapsed() >= PROGRESS {
                told = Instant::now();
                progress(&shared, began);
            }
        }
    });
    let (tally, failures) = shared.ended.into_inner().unwrap_or_else(|e| e.into_inner());
    let Some(tally) = tally else { return Err("no seed was run".into()) };
    report(plan, &tally, &failures, began.elapsed())
}

fn work(plan: &Plan, shared: &Shared, began: Instant) {
    loop {
        let late = plan.time.is_some_and(|time| began.elapsed() >= time);
        let seed = shared.next.fetch_add(1, Ordering::Relaxed);
        if late || seed >= plan.to || shared.stop.load(Ordering::Relaxed) {
            return;
        }
        let outcome = live(seed, &mut ());
        let mut ended = shared.ended.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        match &mut ended.0 {
            Some(tally) => tally.add(&outcome.tally),
            none => *none = Some(outcome.tally.clone()),
        }
        if let Some(text) = outcome.failure_text() {
            println!("FAILED {text}");
            ended.1.insert(seed, outcome);
            if ended.1.len() >= FAILURES_MAX {
                shared.stop.store(true, Ordering::Relaxed);
            }
        }
    }
}

fn progress(shared: &Shared, began: Instant) {
    let ended = shared.ended.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let Some(tally) = &ended.0 else { return };
    let line = format!(
        "{:>5.0} s: {} seeds, {:.1} virtual hours, {} output changes, {} failures",
        began.elapsed().as_secs_f64(),
        tally.seeds,
        hours(tally.virtual_ms),
        tally.changes,
        ended.1.len(),
    );
    let mut stderr = std::io::stderr().lock();
    // Progress that cannot be shown must not end the run.
    let _ = match stderr.is_terminal() {
        true => write!(stderr, "\r{line}").and_then(|()| stderr.flush()),
        false => writeln!(stderr, "{line}"),
    };
}

fn hours(ms: u64) -> f64 {
    ms as f64 / 3_600_000.0
}

fn report(
    plan: &Plan,
    tally: &Tally,
    failures: &BTreeMap<u64, Outcome>,
    took: Duration,
) -> Result<(), String> {
    if std::io::stderr().is_terminal() {
        eprintln!();
    }
    let counts = |name: &str| !plan.pairs || WITNESS_PAIRS.iter().any(|it| name.starts_with(it));
    let missing: Vec<&str> = tally.missing().into_iter().filter(|name| counts(name)).collect();
    let all = tally.witnessed().filter(|(name, _)| counts(name)).count();
    let together = if plan.pairs { pairs().min(tally.seeds) } else { 0 };
    let speed = tally.virtual_ms as f64 / 1000.0 / took.as_secs_f64() / plan.threads as f64;
    let rows = [
        ("seeds", format!("{} from {}", tally.seeds, plan.from)),
        ("pairs of faults", together.to_string()),
        ("steps of the program", tally.steps.to_string()),
        ("virtual hours", format!("{:.1}", hours(tally.virtual_ms))),
        ("frames, all answered", tally.frames.to_string()),
        ("requests in them", tally.requests.to_string()),
        ("output changes", tally.changes.to_string()),
        ("unexplained", tally.unexplained.to_string()),
        ("violations", tally.violations.to_string()),
        ("resets by requests", tally.resets.to_string()),
        ("witnessed", format!("{} of {all}", all - missing.len())),
        ("took", format!("{:.0} s on {} threads", took.as_secs_f64(), plan.threads)),
        ("faster than life", format!("{speed:.0} times a thread")),
    ];
    println!("| what | figure |\n|---|---|");
    for (name, value) in rows {
        println!("| {name} | {value} |");
    }
    let mut rare: Vec<(&str, u64)> = tally.witnessed().filter(|(_, count)| *count > 0).collect();
    rare.sort_by_key(|(_, count)| *count);
    let rare: Vec<String> =
        rare.iter().take(8).map(|(name, count)| format!("{name} {count}")).collect();
    println!("\nrarest: {}", rare.join(", "));
    if !missing.is_empty() {
        println!("never witnessed: {}", missing.join(", "));
    }
    for outcome in failures.values() {
        println!("FAILED {}", outcome.failure_text().unwrap_or_default());
    }
    let enough = tally.seeds >= if plan.pairs { pairs() } else { WITNESS_SEEDS };
    if !failures.is_empty() {
        return Err(format!("{} seeds have failed", failures.len()));
    }
    if enough && !missing.is_empty() {
        return Err("not everything that must happen has been seen".into());
    }
    if enough && plan.pairs && tally.steps < PAIRS_STEPS {
        return Err(format!("fewer than {PAIRS_STEPS} steps of the program"));
    }
    Ok(())
}
