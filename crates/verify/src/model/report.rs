//! Runs the checker and reports its findings.

use crate::model::configuration::Configuration;
use crate::model::interlock::Interlock;
use crate::model::law::Law;
use crate::model::monitor::Monitor;
use crate::model::world::{Action, World};
use stateright::{Checker, Expectation, HasDiscoveries, Model, Path};
use std::fmt::{self, Display};
use std::time::{Duration, Instant};

/// Limits of a run.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Threads.
    pub threads: usize,
    /// Stop after about this many states, repeats included.
    pub states: Option<usize>,
    /// Longest path.
    pub depth: Option<usize>,
    /// Longest time.
    pub timeout: Option<Duration>,
    /// Look for a path that breaks this law; otherwise the first broken law ends the run.
    pub until: Option<Law>,
}

impl Effort {
    /// Everything, on one thread: the shortest paths.
    pub const ALL: Self =
        Self { threads: 1, states: None, depth: None, timeout: None, until: None };
}

/// Results of a run.
#[derive(Debug)]
pub struct Outcome {
    /// The configuration.
    pub configuration: &'static Configuration,
    /// States generated, repeats included.
    pub states: usize,
    /// Different states.
    pub unique: usize,
    /// Length of the longest path explored.
    pub depth: usize,
    /// Properties: laws and witnesses.
    pub properties: usize,
    /// Whether every state has been explored.
    pub exhausted: bool,
    /// Duration of the run.
    pub time: Duration,
    /// Broken laws, with the paths to them.
    pub broken: Vec<Finding>,
    /// Witnesses that should have been seen and were not.
    pub unseen: Vec<&'static str>,
}

/// A path to a broken law.
#[derive(Debug)]
pub struct Finding {
    /// Statement of the law.
    pub law: &'static str,
    /// The path, one action per line.
    pub path: Vec<String>,
}

impl Outcome {
    /// Whether no law is broken and everything was seen.
    pub fn is_good(&self) -> bool {
        self.broken.is_empty() && self.unseen.is_empty()
    }
}

/// Explores the states of a configuration with this monitor.
pub fn run<M: Monitor>(configuration: &'static Configuration, effort: Effort) -> Outcome {
    let start = Instant::now();
    let model = Interlock::<M>::new(configuration, effort.timeout.map(|timeout| start + timeout));
    let clock = model.clock();
    let properties = model.properties();
    let mut builder = model.checker().threads(effort.threads);
    builder = builder.finish_when(match effort.until {
        Some(law) => HasDiscoveries::AnyOf([law.text()].into()),
        None => HasDiscoveries::AnyFailures,
    });
    if let Some(states) = effort.states {
        builder = builder.target_state_count(states);
    }
    if let Some(depth) = effort.depth {
        builder = builder.target_max_depth(depth);
    }
    let checker = builder.spawn_bfs().join();
    clock.stop();
    let (states, depth) = (checker.state_count(), checker.max_depth());
    let time = start.elapsed();
    let mut found = checker.discoveries();
    let mut outcome = Outcome {
        configuration,
        states,
        unique: checker.unique_state_count(),
        depth,
        properties: properties.len(),
        exhausted: effort.states.is_none_or(|most| states < most)
            && effort.depth.is_none_or(|most| depth < most)
            && !clock.has_cut(),
        time,
        broken: Vec::new(),
        unseen: Vec::new(),
    };
    for property in properties {
        let path = found.remove(property.name);
        match (property.expectation, path) {
            (Expectation::Sometimes, None) => outcome.unseen.push(property.name),
            (Expectation::Always, Some(path)) => {
                outcome.broken.push(Finding { law: property.name, path: lines(path) });
            }
            _ => {}
        }
    }
    outcome
}

/// A path as text.
fn lines<M: Monitor>(path: Path<World<M>, Action>) -> Vec<String> {
    let steps = path.into_vec();
    let first = steps.first().map(|(world, _)| world);
    let deployed = first.is_some_and(|world| world.view().is_deployed());
    let place = if deployed { "deployed" } else { "wrapped, just switched on" };
    let mut lines = vec![format!("start     {place}")];
    let mut steps = steps.into_iter().peekable();
    while let Some((_, action)) = steps.next() {
        let (Some(action), Some((after, _))) = (action, steps.peek()) else { break };
        let mut line = action.to_string();
        if let [Some((from, status))] = after.answers {
            line += &format!("  → {status} from {from}");
        }
        let seen: Vec<&str> = after.happened.texts().collect();
        if !seen.is_empty() {
            line += &format!("  ({})", seen.join(", "));
        }
        lines.push(line);
        if !after.broken.is_empty() {
            let (places, valves, ways, outputs) = after.plant.sight();
            lines.push(format!("broken    {}", after.broken));
            lines.push(format!(
                "          vertical, horizontal, nozzle, deployer at {places:?}, driven {ways:?}; \
                 valves at {valves:?}, driven {outputs:?}"
            ));
        }
    }
    lines
}

impl Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { configuration, states, unique, depth, properties, time, .. } = self;
        let whole = if self.exhausted { "all" } else { "not all" };
        write!(
            f,
            "{:<13}{states:>10} states {unique:>10} unique ({whole})  depth {depth:>3}  \
             {properties} properties  {:.1} s",
            configuration.name,
            time.as_secs_f64()
        )?;
        for Finding { law, path } in &self.broken {
            write!(f, "\n  BROKEN: {law}")?;
            for (number, line) in path.iter().enumerate() {
                write!(f, "\n  {:>4}  {line}", number + 1)?;
            }
        }
        self.unseen.iter().try_for_each(|text| write!(f, "\n  NEVER SEEN: {text}"))
    }
}
