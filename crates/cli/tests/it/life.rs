//! `lafet sim --replay`: the life of a seed of the swarm, the same each time.

use crate::support::Run;

#[test]
fn a_life_is_shown_with_its_causes() {
    let run = Run::of(&["sim", "--replay", "1", "--to", "60"]);
    assert_eq!(run.code, 0, "{run:?}");
    let first = run.out.lines().next().unwrap();
    assert!(first.contains("seed 1: profile remote"), "{first}");
    let moved = "= nozzle 0.0 → -0.4: request Move Nozzle (Radio)";
    for part in ["→ Radio: Move Nozzle 0", "← Nozzle Move → Accepted", moved, "output changes"]
    {
        assert!(run.out.contains(part), "{part}: {}", run.out);
    }
    let again = Run::of(&["sim", "--replay", "1", "--to", "60"]);
    assert!(run.out == again.out, "two replays of one seed differ");
}

#[test]
fn it_can_be_narrowed_and_read_by_programs() {
    let run = Run::of(&["sim", "--replay", "5", "--from", "10", "--to", "40", "--json"]);
    assert_eq!(run.code, 0, "{run:?}");
    let mut causes = 0;
    let lines: Vec<&str> = run.out.lines().collect();
    for line in &lines[1..lines.len() - 1] {
        let json: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!((10.0..=40.0).contains(&json["t"].as_f64().unwrap()), "{line}");
        causes += u32::from(json["cause"].is_string());
    }
    assert!(causes > 0, "{}", run.out);
}

#[test]
fn in_russian() {
    let run = Run::of(&["sim", "--replay", "1", "--to", "12", "--lang", "ru"]);
    assert!(run.out.contains("зерно 1: состав remote"), "{run:?}");
    assert!(run.out.contains(": запрос Move Nozzle (Radio)"), "{run:?}");
    let alone = Run::of(&["sim", "--from", "5"]);
    assert_eq!(alone.code, 2, "{alone:?}");
}
