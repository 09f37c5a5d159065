//! Runs the tests of the device against a mutant.

use std::collections::BTreeMap;
use std::process::{Command, Stdio};
use std::time::Instant;

use super::list::Mutant;
use super::tree::Test;
use crate::run::root;

/// Result for a mutant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// A test failed.
    Caught,
    /// A test did not end.
    Endless,
    Survived,
    /// It does not build.
    Unviable,
}

/// Long tests, in the order in which they are tried on mutants that the others do not notice.
const LONG: [Long; 4] = [
    Long { name: "store", filter: "behaviour reported", only: &["store/", "params"], seconds: 10 },
    Long { name: "stops", filter: "", only: &[""], seconds: 60 },
    Long { name: "every_request", filter: "", only: &ASKED, seconds: 400 },
    Long { name: "store", filter: "", only: &["store/"], seconds: 1000 },
];
/// Files that determine the answer to a single request.
const ASKED: [&str; 6] = ["answers", "chain", "composition", "device", "execute", "guard"];
/// The test binary of the unit tests.
const UNIT: &str = "lafet_device";
/// Limit of processor time for the other tests, of which none needs a second.
const SHORT_SECONDS: u32 = 5;
/// Number of cases for long tests: enough of every situation.
const CASES: [(&str, &str); 1] = [("LAFET_STOP_CASES", "20000")];
/// Memory limit of a test, KiB.
const MEMORY_KIB: u32 = 4 << 20;
/// Number of SIGXCPU.
const OUT_OF_TIME: i32 = 24;

struct Long {
    name: &'static str,
    /// Parts of the names of tests to run; if empty, all.
    filter: &'static str,
    /// Only for mutants in files whose path starts with one of these.
    only: &'static [&'static str],
    seconds: u32,
}

impl Long {
    /// Whether it takes seconds, and concerns few files.
    fn is_own(&self) -> bool {
        self.seconds <= QUICK_SECONDS && self.only != [""]
    }
}

/// Longest time of a test that counts as quick, seconds.
const QUICK_SECONDS: u32 = 60;

pub struct Trial<'a> {
    /// Tests, the quickest first.
    tests: Vec<&'a Test>,
    /// Leave out the tests that take minutes, so that the result is a lower bound.
    quick: bool,
}

impl<'a> Trial<'a> {
    /// Fails if a test fails without a mutant.
    pub fn new(tests: &'a [Test], files: &[&str], quick: bool) -> Result<Self, String> {
        let mut trial = Self::unproved(tests, quick);
        let mut runs: Vec<_> = trial.short().map(|test| (test, "", SHORT_SECONDS)).collect();
        for (test, long) in files.iter().flat_map(|file| trial.long(file)) {
            if !runs.iter().any(|run| (&run.0.name, run.1) == (&test.name, long.filter)) {
                runs.push((test, long.filter, long.seconds));
            }
        }
        let mut took = BTreeMap::new();
        for (test, filter, seconds) in runs {
            let start = Instant::now();
            if run(test, filter, seconds, None) != Outcome::Survived {
                return Err(format!("{} fails without any mutant", test.name));
            }
            took.insert(&test.name, start.elapsed());
        }
        trial.tests.sort_by_key(|test| took.get(&test.name).copied());
        Ok(trial)
    }

    pub fn unproved(tests: &'a [Test], quick: bool) -> Self {
        Self { tests: tests.iter().collect(), quick }
    }

    /// Runs the test likeliest to notice it, then the quick ones; ends at the first failure.
    pub fn outcome(&self, id: Option<usize>, mutant: &Mutant) -> Outcome {
        let name = mutant.short_file();
        let module = name.trim_end_matches(".rs").replace('/', "::");
        let unit = self.tests.iter().filter(|test| test.name == UNIT);
        let unit = unit.map(|test| (*test, module.as_str(), SHORT_SECONDS));
        let short = self.short().map(|test| (test, "", SHORT_SECONDS));
        let (own, last): (Vec<_>, Vec<_>) = self.long(name).partition(|(_, long)| long.is_own());
        let long = |(test, long): (&'a Test, &Long)| (test, long.filter, long.seconds);
        let all = unit.chain(own.into_iter().map(long)).chain(short);
        let mut outcomes = all
            .chain(last.into_iter().map(long))
            .map(|(test, filter, seconds)| run(test, filter, seconds, id));
        outcomes.find(|outcome| *outcome != Outcome::Survived).unwrap_or(Outcome::Survived)
    }

    fn short(&self) -> impl Iterator<Item = &'a Test> {
        self.tests.iter().copied().filter(|test| !LONG.iter().any(|long| long.name == test.name))
    }

    fn long(&self, file: &str) -> impl Iterator<Item = (&'a Test, &'static Long)> {
        let Self { tests, quick } = self;
        LONG.iter()
            .filter(move |long| !*quick || long.seconds <= QUICK_SECONDS)
            .filter(move |long| long.only.iter().any(|start| file.starts_with(start)))
            .filter_map(move |long| {
                Some((*tests.iter().find(|test| test.name == long.name)?, long))
            })
    }
}

fn run(test: &Test, filter: &str, seconds: u32, id: Option<usize>) -> Outcome {
    let mut command = Command::new("sh");
    // Limits processor time, so that a busy machine does not change the result.
    let limits = format!(
        "set -e; ulimit -c 0; ulimit -v {MEMORY_KIB}; ulimit -S -t {seconds}; exec \"$0\" -q $1"
    );
    let filter = if filter.is_empty() { &test.filter } else { filter };
    command.args(["-c", &limits]).arg(&test.path).arg(filter);
    command.current_dir(root().join("crates/device")).envs(CASES).env("RUST_BACKTRACE", "0");
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if let Some(id) = id {
        command.env("LAFET_MUTANT", id.to_string());
    }
    let Ok(status) = command.status() else { return Outcome::Caught };
    let signal = std::os::unix::process::ExitStatusExt::signal(&status);
    match signal {
        _ if status.success() => Outcome::Survived,
        Some(OUT_OF_TIME) => Outcome::Endless,
        _ => Outcome::Caught,
    }
}
