//! `lafet-verify replay`: the life of a seed of the swarm, the same each time.

use std::process::Command;

/// What is printed, if it succeeds.
fn replay(arguments: &[&str]) -> String {
    let program = env!("CARGO_BIN_EXE_lafet-verify");
    let output = Command::new(program).arg("replay").args(arguments).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_life_is_shown_with_its_causes() {
    let life = replay(&["1", "--to", "60"]);
    let first = life.lines().next().unwrap();
    assert!(first.contains("seed 1: profile remote"), "{first}");
    let moved = "= nozzle 0.0 → -0.4: request Move Nozzle (Radio)";
    for part in ["→ Radio: Move Nozzle 0", "← Nozzle Move → Accepted", moved, "output changes"]
    {
        assert!(life.contains(part), "{part}: {life}");
    }
    assert!(life == replay(&["1", "--to", "60"]), "two replays of one seed differ");
}

#[test]
fn it_can_be_narrowed() {
    let life = replay(&["5", "--from", "10", "--to", "40"]);
    let lines: Vec<&str> = life.lines().collect();
    let mut causes = 0;
    for line in &lines[1..lines.len() - 1] {
        let (time, what) = line.trim_start().split_once("  ").unwrap();
        assert!((10.0..=40.0).contains(&time.parse::<f64>().unwrap()), "{line}");
        causes += u32::from(what.starts_with("= "));
    }
    assert!(causes > 0, "{life}");
}
