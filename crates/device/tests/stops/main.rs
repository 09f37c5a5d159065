//! §3.2/1, §3.18/1 Stop All and Lockout, §3.12, §D/2 resets and §D/4 MoveTimeout: the outputs are off in
//! the very next step, in every state and under any load.
//!
//! `LAFET_STOP_CASES` says how many cases are tried (`cargo xtask stops`), `LAFET_STOP_SEED` is the
//! first seed and replays a failure.

#[path = "../common/mod.rs"]
mod common;

/// The rules that all harnesses share. The package of the device cannot depend on theirs.
#[path = "../../../verify/src/interlock.rs"]
#[allow(dead_code, reason = "other harnesses use the rest")]
mod interlock;

mod case;
mod flood;
mod lives;

use case::{CASES_OF_A_SEED, Tally, run};

/// Tried in the test suite.
const CASES: u64 = 50_000;
/// The longest step of the cycle that a firmware may make, µs.
const CYCLE_MAX_US: u64 = 10_000;

fn from_environment(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |value| value.parse().expect("a number"))
}

/// §3.2/1, §3.18/1 From the last byte of the frame to the outputs: never more than one step.
#[test]
fn stop_and_lockout_act_in_the_next_step() {
    let first = from_environment("LAFET_STOP_SEED", 0);
    let seeds = from_environment("LAFET_STOP_CASES", CASES).div_ceil(CASES_OF_A_SEED);
    let next = std::sync::atomic::AtomicU64::new(first);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let tally = std::thread::scope(|scope| {
        let worker = || {
            let mut tally = Tally::default();
            loop {
                let seed = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                if seed >= first + seeds {
                    return tally;
                }
                tally.add(&run(seed));
            }
        };
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().map(|worker| worker.join().unwrap()).fold(
            Tally::default(),
            |mut sum, one| {
                sum.add(&one);
                sum
            },
        )
    });
    println!("{tally}");
    assert_eq!(tally.cases, seeds * CASES_OF_A_SEED);
    assert!(tally.longest_us <= CYCLE_MAX_US, "{tally}");
    // What shows that there was something to stop.
    assert!(tally.running * 2 > tally.cases, "{tally}");
    for (what, count) in tally.witnesses() {
        assert!(count > tally.cases / 1000, "{what}: {count}\n{tally}");
    }
    for (name, count) in &tally.ran {
        let ran = *count > 0 || name.starts_with("at rest");
        assert!(ran, "{name} never ran when it was stopped\n{tally}");
    }
}
