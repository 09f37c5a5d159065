//! `cargo xtask mutants`: mutation testing of the device.
//!
//! cargo-mutants lists the changes. It would build the tests for each of 2,000 mutants; here all of
//! them are woven into one copy of the device, each behind a switch, and only those that cannot be
//! switched (in code evaluated by the compiler) get a build of their own.

mod explained;
mod list;
mod tree;
mod trial;
mod weave;

use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::run::verdict;
use crate::{TaskResult, setup};
use explained::Explained;
use list::Mutant;
use tree::Tree;
use trial::{Outcome, Trial};

/// Least share of the mutants of the device that must be noticed, percent.
const NOTICED_PERCENT: f64 = 95.0;
/// Name for all files of the device.
const DEVICE: &str = "device";
/// Files in which every mutant must be noticed.
const WHOLE: [&str; 2] = ["guard", "chain"];

/// Stride for sampling: a prime larger than the number of mutants.
const SPREAD: usize = 7919;

/// Every `n`th mutant, starting with the `k`th.
#[derive(Clone, Copy)]
struct Shard {
    k: usize,
    n: usize,
}

impl Shard {
    fn of(self, ids: Vec<usize>) -> Vec<usize> {
        ids.into_iter().skip(self.k).step_by(self.n).collect()
    }
}

struct Options {
    /// Files, or `device` for all of them.
    areas: Vec<String>,
    shard: Shard,
    apart: Shard,
    /// Time limit for the woven mutants, minutes.
    minutes: Option<f64>,
    /// Leave out the tests that take minutes.
    quick: bool,
}

pub fn mutants(arguments: &[String]) -> TaskResult {
    let options = options(arguments)?;
    setup::rust()?;
    let mutants = mutants_of(&options.areas)?;
    let ids = options.shard.of(mutants.keys().copied().collect());
    let mutants: BTreeMap<usize, Mutant> =
        mutants.into_iter().filter(|(id, _)| ids.contains(id)).collect();
    let explained = Explained::read()?;
    let tree = Tree::new()?;
    let start = Instant::now();
    let woven = tree.weave(&mutants)?;
    println!("   {} mutants, {} of them woven", mutants.len(), woven.len());
    let tests = tree.tests()?;
    let files: Vec<&str> = mutants.values().map(Mutant::short_file).collect();
    let trial = Trial::new(&tests, &files, options.quick)?;
    let mut outcomes = try_all(&trial, &mutants, &woven, options.minutes);
    let apart: Vec<usize> = mutants.keys().copied().filter(|id| !woven.contains(id)).collect();
    let count = apart.len();
    let apart = options.apart.of(apart);
    println!("   {} of {count} others, each with a build of its own", apart.len());
    for id in apart {
        let Some(mutant) = mutants.get(&id) else { continue };
        // Most are noticed by the short tests, which are built in a fraction of the time.
        let mut outcome = Outcome::Survived;
        for tests in [&tree::FEW[..], &[]] {
            if outcome == Outcome::Survived {
                outcome = match tree.build_apart(mutant, tests)? {
                    None => Outcome::Unviable,
                    Some(tests) => Trial::unproved(&tests, options.quick).outcome(None, mutant),
                };
            }
        }
        report(mutant, outcome);
        outcomes.insert(id, outcome);
    }
    println!("   {:.0} s\n", start.elapsed().as_secs_f64());
    judge(&options, &mutants, &outcomes, &explained)
}

fn options(arguments: &[String]) -> Result<Options, String> {
    let all = Shard { k: 0, n: 1 };
    let mut options =
        Options { areas: Vec::new(), shard: all, apart: all, minutes: None, quick: false };
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        let mut shard = || -> Result<Shard, String> {
            let text = rest.next().map(String::as_str).unwrap_or_default();
            let numbers =
                text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
            numbers
                .filter(|(k, n)| k < n)
                .map(|(k, n)| Shard { k, n })
                .ok_or_else(|| format!("{argument}: expected K/N with K from 0 to N - 1"))
        };
        match argument.as_str() {
            "--shard" => options.shard = shard()?,
            "--apart" => options.apart = shard()?,
            "--quick" => options.quick = true,
            "--minutes" => {
                let number = rest.next().and_then(|text| text.parse().ok());
                let number = number.filter(|minutes: &f64| *minutes > 0.0 && minutes.is_finite());
                options.minutes = Some(number.ok_or("--minutes: expected a number")?);
            }
            flag if flag.starts_with('-') => return Err(format!("unexpected `{flag}`")),
            area => options.areas.push(area.trim_end_matches(".rs").into()),
        }
    }
    if options.areas.is_empty() {
        options.areas.push(DEVICE.into());
    }
    Ok(options)
}

/// Mutants by number; the numbers are the same whichever part is tried.
fn mutants_of(areas: &[String]) -> Result<BTreeMap<usize, Mutant>, String> {
    let all: BTreeMap<usize, Mutant> = list::mutants()?.into_iter().enumerate().collect();
    let is_of =
        |mutant: &Mutant, area: &str| area == DEVICE || mutant.short_file() == format!("{area}.rs");
    for area in areas {
        if !all.values().any(|mutant| is_of(mutant, area)) {
            return Err(format!("no mutants in {area}: guard, chain, device or a file of it"));
        }
    }
    let wanted = |mutant: &Mutant| areas.iter().any(|area| is_of(mutant, area));
    Ok(all.into_iter().filter(|(_, mutant)| wanted(mutant)).collect())
}

/// Tries the woven mutants, on all cores.
fn try_all(
    trial: &Trial,
    mutants: &BTreeMap<usize, Mutant>,
    woven: &BTreeSet<usize>,
    minutes: Option<f64>,
) -> BTreeMap<usize, Outcome> {
    let end = minutes.map(|minutes| Instant::now() + Duration::from_secs_f64(60.0 * minutes));
    let ids: Vec<usize> = woven.iter().copied().collect();
    // With a time limit, the order spreads over the files, so that those tried are a sample of all.
    let step = if minutes.is_some() { SPREAD } else { 1 };
    let queue = Mutex::new((0..ids.len()).map(|i| ids[i * step % ids.len()]));
    let outcomes = Mutex::new(BTreeMap::new());
    let next = || {
        let over = end.is_some_and(|end| Instant::now() >= end);
        queue.lock().ok()?.next().filter(|_| !over)
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(id) = next() {
                    let Some(mutant) = mutants.get(&id) else { continue };
                    let outcome = trial.outcome(Some(id), mutant);
                    report(mutant, outcome);
                    if let Ok(mut outcomes) = outcomes.lock() {
                        outcomes.insert(id, outcome);
                    }
                }
            });
        }
    });
    outcomes.into_inner().unwrap_or_default()
}

fn report(mutant: &Mutant, outcome: Outcome) {
    if outcome == Outcome::Survived {
        println!("   not noticed: {mutant}");
    }
}

/// Results for the mutants of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Count {
    caught: usize,
    endless: usize,
    explained: usize,
    survived: usize,
    unviable: usize,
    untried: usize,
}

impl Count {
    fn noticed(self) -> usize {
        self.caught + self.endless
    }

    /// Share noticed of the mutants that change anything, percent.
    fn percent(self) -> f64 {
        100.0 * self.noticed() as f64 / (self.noticed() + self.survived).max(1) as f64
    }

    fn row(self, name: &str) -> String {
        let Self { caught, endless, explained, survived, unviable, untried } = self;
        let percent = self.percent();
        format!(
            "| {name} | {caught} | {endless} | {survived} | {explained} | {unviable} | {untried} | {percent:.1} % |"
        )
    }
}

fn judge(
    options: &Options,
    mutants: &BTreeMap<usize, Mutant>,
    outcomes: &BTreeMap<usize, Outcome>,
    explained: &Explained,
) -> TaskResult {
    let mut files: BTreeMap<&str, Count> = BTreeMap::new();
    let mut sum = Count::default();
    let mut problems = Vec::new();
    for (id, mutant) in mutants {
        let outcome = outcomes.get(id).copied();
        let known = explained.has(mutant);
        if outcome == Some(Outcome::Survived) && !known {
            problems.push(mutant.to_string());
        }
        if known && matches!(outcome, Some(Outcome::Caught | Outcome::Endless)) {
            problems.push(format!("{mutant}: explained in mutants.toml, but noticed"));
        }
        for count in [files.entry(mutant.short_file()).or_default(), &mut sum] {
            *match outcome {
                Some(Outcome::Caught) => &mut count.caught,
                Some(Outcome::Endless) => &mut count.endless,
                Some(Outcome::Survived) if known => &mut count.explained,
                Some(Outcome::Survived) => &mut count.survived,
                Some(Outcome::Unviable) => &mut count.unviable,
                None => &mut count.untried,
            } += 1;
        }
    }
    println!(
        "| file | caught | endless | not noticed | explained | does not build | not tried | noticed |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|");
    files.iter().for_each(|(name, count)| println!("{}", count.row(name)));
    println!("{}\n", sum.row("together"));
    let whole = options.shard.n == 1 && options.minutes.is_none() && !options.quick;
    if whole {
        problems.extend(explained.stale(mutants.values(), &options.areas));
    }
    if options.areas.iter().any(|area| area == DEVICE) && sum.percent() >= NOTICED_PERCENT {
        problems
            .retain(|problem| WHOLE.iter().any(|name| problem.contains(&format!("/{name}.rs"))));
    }
    verdict("mutants", &problems)?;
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_disjoint_and_whole() {
        let ids: Vec<usize> = (0..10).collect();
        let mut all: Vec<usize> = (0..3).flat_map(|k| Shard { k, n: 3 }.of(ids.clone())).collect();
        all.sort_unstable();
        assert_eq!(all, ids);
    }

    #[test]
    fn options_are_read() {
        let read =
            |text: &str| options(&text.split_whitespace().map(String::from).collect::<Vec<_>>());
        let all = read("chain.rs").ok().map(|options| (options.areas, options.shard.n));
        assert_eq!(all, Some((vec!["chain".into()], 1)));
        let files = read("guard store/mount").map(|options| options.areas);
        assert_eq!(files, Ok(vec!["guard".into(), "store/mount".into()]));
        assert_eq!(read("--quick").map(|options| options.areas), Ok(vec!["device".into()]));
        assert_eq!(read("--shard 2/5").ok().map(|o| (o.shard.k, o.shard.n)), Some((2, 5)));
        assert!(read("--shard 5/5").is_err());
        assert!(read("--sard 1/5").is_err());
    }

    #[test]
    fn what_changes_nothing_does_not_count() {
        let count = Count { caught: 18, endless: 1, survived: 1, explained: 7, ..Count::default() };
        assert!((count.percent() - 95.0).abs() < 1e-9);
    }
}
