//! `lafet calibrate` on a simulated monitor: fits, shows, writes.

use crate::support::{Run, Sim};
use serde_json::json;

const SHOTS: &[&str] = &["--shot", "7.9,5,28.5", "--shot", "7.9,15,38.6", "--shot", "5.9,10,31.4"];

#[test]
fn shots_change_the_monitor() {
    let sim = Sim::start(&[]);
    let arguments = [&["--json", "calibrate", "--distance", "25"], SHOTS].concat();
    let run = sim.run(&arguments);
    let result = &run.json()[0];
    assert_eq!((run.code, &result["written"]), (0, &json!(true)), "{run:?}");
    let fitted = result["nozzle_diameter_mm"].as_f64().unwrap();
    assert!((25.0..27.9).contains(&fitted) && result["worst_m"].as_f64().unwrap() < 1.0, "{run:?}");
    assert_eq!(result["corrections"].as_array().map(Vec::len), Some(256), "{run:?}");
    let run = sim.run(&["--json", "param", "get", "control", "NozzleDiameter"]);
    let stored = run.json()[0]["values"][0].as_f64();
    assert_eq!(stored, Some((fitted * 10.0).round()), "{run:?}");
}

#[test]
fn dry_runs_and_refusals() {
    let sim = Sim::start(&[]);
    let run = sim.run(&["calibrate", "--outlet", "40", "--dry-run"]);
    assert!(run.code == 0 && run.out.contains("NozzleDiameter 40."), "{run:?}");
    let run = sim.run(&["--json", "param", "get", "control", "NozzleDiameter"]);
    assert_eq!(run.json()[0]["values"][0], json!(280), "{run:?}");
    // Without a connection it only computes.
    let run = Run::of(&["--lang", "ru", "calibrate", "--outlet", "28"]);
    assert!(run.code == 0 && run.out.contains("Ничего не записано"), "{run:?}");
    let run = Run::of(&["calibrate", "--shot", "7.9,5,15", "--shot", "7.9,15,37"]);
    assert!(run.code == 1 && run.err.contains("nothing was written"), "{run:?}");
    let run = Run::of(&["calibrate", "--outlet", "28", "--distance", "90"]);
    assert!(run.code == 1 && run.err.contains("--distance"), "{run:?}");
    assert_eq!(Run::of(&["calibrate"]).code, 2);
    assert_eq!(Run::of(&["calibrate", "--shot", "7.9,5"]).code, 2);
}
