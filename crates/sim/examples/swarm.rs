//! Runs the swarm on all cores and prints what was seen: `cargo xtask swarm`.
//!
//! `--seeds A..B`, `--minutes N` or `--hours N`; `--from SEED` begins elsewhere than at 0,
//! `--threads N` uses fewer cores. `--pairs N` is N rounds of short lives with two faults each, in
//! which every pair of faults has its own. Fails when something must never happen has happened, and when
//! something that must happen has not been seen in a run of at least [`WITNESS_SEEDS`] seeds.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use lafet_sim::swarm::{Outcome, PAIRS_SEED, Tally, pairs, run};

/// From so many seeds on everything must have been witnessed.
const WITNESS_SEEDS: u64 = 600;
/// Of these everything must have been witnessed in a round of pairs.
const WITNESS_PAIRS: [&str; 4] = ["fault ", "output ", "profile ", "several faults at once"];
/// Most rounds of pairs.
const ROUNDS_MAX: u64 = 1_000;
/// A run ends after so many failures: more say nothing new.
const FAILURES_MAX: usize = 20;
/// Time between two lines of progress.
const PROGRESS: Duration = Duration::from_secs(10);

struct Plan {
    from: u64,
    to: u64,
    time: Option<Duration>,
    threads: usize,
    pairs: bool,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match plan(&arguments) {
        Ok(plan) => swarm(&plan),
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

fn plan(arguments: &[String]) -> Result<Plan, String> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let mut plan = Plan { from: 0, to: u64::MAX, time: None, threads: cores, pairs: false };
    let mut bounded = false;
    let mut rest = arguments.iter();
    while let Some(name) = rest.next() {
        let value = rest.next().ok_or_else(|| format!("{name} wants a value"))?;
        let number = || value.parse::<f64>().ok().filter(|n| n.is_finite() && *n > 0.0);
        let wrong = || format!("{name} cannot be `{value}`");
        match name.as_str() {
            "--seeds" => {
                let (from, to) = value.split_once("..").ok_or_else(wrong)?;
                plan.from = from.parse().map_err(|_| wrong())?;
                plan.to = to.parse().map_err(|_| wrong())?;
                if plan.to <= plan.from {
                    return Err(wrong());
                }
                bounded = true;
            }
            "--pairs" => {
                let rounds = value.parse().ok().filter(|n| (1..=ROUNDS_MAX).contains(n));
                (plan.from, plan.pairs, bounded) = (PAIRS_SEED, true, true);
                plan.to = PAIRS_SEED + pairs() * rounds.ok_or_else(wrong)?;
            }
            "--minutes" | "--hours" => {
                let unit = if name == "--hours" { 3600.0 } else { 60.0 };
                plan.time = Some(Duration::from_secs_f64(number().ok_or_else(wrong)? * unit));
                bounded = true;
            }
            "--from" => plan.from = value.parse().map_err(|_| wrong())?,
            "--threads" => {
                plan.threads = value.parse().ok().filter(|n| *n > 0).ok_or_else(wrong)?
            }
            _ => return Err(format!("unknown argument {name}")),
        }
    }
    match bounded {
        true => Ok(plan),
        false => Err("one of --seeds A..B, --pairs N, --minutes N, --hours N is wanted".into()),
    }
}

/// What all threads have in common.
struct Shared {
    next: AtomicU64,
    stop: AtomicBool,
    ended: Mutex<(Option<Tally>, BTreeMap<u64, Outcome>)>,
}

fn swarm(plan: &Plan) -> ExitCode {
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
    let Some(tally) = tally else { return ExitCode::FAILURE };
    report(plan, &tally, &failures, began.elapsed())
}

fn work(plan: &Plan, shared: &Shared, began: Instant) {
    loop {
        let late = plan.time.is_some_and(|time| began.elapsed() >= time);
        let seed = shared.next.fetch_add(1, Ordering::Relaxed);
        if late || seed >= plan.to || shared.stop.load(Ordering::Relaxed) {
            return;
        }
        let outcome = run(seed, &mut ());
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
) -> ExitCode {
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
    let idle = enough && !missing.is_empty();
    if failures.is_empty() && !idle { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
