//! Checks the interlock and prints the coverage and findings: `cargo xtask model`.

use clap::Args;
use lafet_device::Device;
use lafet_verify::model::configuration::{ALL, Configuration};
use lafet_verify::model::report::{Effort, Outcome, run as explore};
use std::cmp::Reverse;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

#[derive(Args)]
pub struct Options {
    /// Configurations to check (default all)
    names: Vec<String>,
    /// Longest time for each configuration, s
    #[arg(long, value_name = "S")]
    seconds: Option<u64>,
    /// Stop each configuration after about this many states, repeats included
    #[arg(long, value_name = "N")]
    states: Option<usize>,
    /// Stop each configuration after the states it needs to see what it must see: a minute on two
    /// cores
    #[arg(long, conflicts_with = "states")]
    quick: bool,
    /// Longest path
    #[arg(long, value_name = "N")]
    depth: Option<usize>,
    /// Threads; with one, paths to a broken law are the shortest possible
    #[arg(long, value_name = "N", default_value_t = 2)]
    threads: usize,
    /// List the configurations
    #[arg(long)]
    list: bool,
}

/// Explores the configurations.
pub fn run(options: &Options) -> Result<(), String> {
    if options.list {
        for configuration in ALL {
            println!("{:<13}{}", configuration.name, configuration.about);
        }
        return Ok(());
    }
    let unknown = options.names.iter().find(|name| Configuration::by_name(name).is_none());
    if let Some(name) = unknown {
        return Err(format!("no configuration `{name}`; --list shows them"));
    }
    let effort = Effort {
        threads: options.threads.max(1),
        states: options.states,
        depth: options.depth,
        timeout: options.seconds.map(Duration::from_secs),
        until: None,
    };
    let chosen = |configuration: &&Configuration| {
        options.names.is_empty() || options.names.iter().any(|n| n == configuration.name)
    };
    let chosen: Vec<_> = ALL.iter().filter(chosen).collect();
    let (mut good, mut all, mut unique) = (true, 0, 0);
    let mut show = |outcome: Outcome| {
        println!("{outcome}");
        good &= outcome.is_good();
        all += outcome.states;
        unique += outcome.unique;
    };
    if options.quick {
        quickly(&chosen, effort).into_iter().for_each(show);
    } else {
        chosen.into_iter().for_each(|configuration| show(explore::<Device>(configuration, effort)));
    }
    println!("together     {all:>10} states {unique:>10} unique");
    if good { Ok(()) } else { Err("a law is broken, or what must be seen is not".into()) }
}

/// Runs each configuration on one thread, so that every run explores the same states; `threads` of
/// them at a time, those that take longest first.
fn quickly(chosen: &[&'static Configuration], effort: Effort) -> Vec<Outcome> {
    let mut turns: Vec<_> = chosen.iter().copied().enumerate().collect();
    turns.sort_by_key(|(_, configuration)| Reverse(configuration.quick_states));
    let next = AtomicUsize::new(0);
    let work = || {
        let mut outcomes = Vec::new();
        loop {
            let turn = next.fetch_add(1, Ordering::Relaxed);
            let Some((place, configuration)) = turns.get(turn) else { return outcomes };
            let effort = Effort { threads: 1, states: Some(configuration.quick_states), ..effort };
            outcomes.push((*place, explore::<Device>(configuration, effort)));
        }
    };
    let mut outcomes = thread::scope(|scope| {
        let workers: Vec<_> = (0..effort.threads).map(|_| scope.spawn(work)).collect();
        let joined = workers.into_iter().map(|worker| worker.join().expect("a walk ends"));
        joined.flatten().collect::<Vec<_>>()
    });
    outcomes.sort_by_key(|(place, _)| *place);
    outcomes.into_iter().map(|(_, outcome)| outcome).collect()
}
