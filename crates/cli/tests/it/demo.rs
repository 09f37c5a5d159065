//! `lafet demo`: it extinguishes the fire, and the same seed gives the same trace.

use std::path::PathBuf;

use crate::support::Run;

fn trace(name: &str, arguments: &[&str]) -> (Run, String) {
    let file: PathBuf =
        std::env::temp_dir().join(format!("lafet-demo-{name}-{}.txt", std::process::id()));
    let path = file.to_str().unwrap().to_owned();
    let run = Run::of(&[&["demo", "--speed", "0", "--trace", &path], arguments].concat());
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::remove_file(&file).unwrap();
    (run, text)
}

#[test]
fn the_same_seed_gives_the_same_trace() {
    let (first, one) = trace("one", &["--seed", "7"]);
    let (second, two) = trace("two", &["--seed", "7", "--json"]);
    assert_eq!((first.code, second.code), (0, 0), "{first:?}");
    assert!(one == two, "two runs of one seed differ");
    let (_, other) = trace("other", &["--seed", "8"]);
    assert!(one != other, "two seeds give the same trace");
}

/// §3.16, §3.21, §3.14, §3.8, §3.9, §3.11 in this order.
#[test]
fn from_standby_to_standby() {
    let (run, trace) = trace("story", &["--fire", "az=30,range=25,size=1.5"]);
    assert_eq!(run.code, 0, "{run:?}");
    let mut rest = trace.as_str();
    for event in [
        "Wrapped]",
        "* FireLit(0)",
        "→ StartSeek Detector",
        "← Detector StartSeek → Accepted",
        "Deploying]",
        "Deployed]",
        "→ GetParam Detector Hotbeds  [9d c8 00 02 fe 23]",
        "← Detector GetParam → Ok: Hotbeds 1 [h ",
        "→ StartQuench Control centre=",
        "→ Open Valve1  [21 a6 00 02 70 4c]",
        "* JetOn",
        "* FireHit(0)",
        "* FireOut(0)",
        "→ Close Valve1",
        "→ Stop Control",
        "→ Wrap Deployer",
        "Wrapping]",
        "Wrapped]",
    ] {
        let at = rest.find(event).unwrap_or_else(|| panic!("`{event}` does not follow"));
        rest = &rest[at + event.len()..];
    }
    for line in ["time to detect", "time to water", "time to out", "fires out: 1 of 1"] {
        assert!(run.out.contains(line), "{line}: {run:?}");
    }
    assert!(run.out.contains("25 m away"), "{run:?}");
    assert!(!trace.contains("FoldedBarrelFlooded"));
}

#[test]
fn many_seeds_come_to_a_good_end() {
    for seed in 0..12 {
        let run = Run::of(&["demo", "--speed", "0", "--json", "--seed", &seed.to_string()]);
        assert_eq!(run.code, 0, "seed {seed}: {run:?}");
        let summary = &run.json()[0];
        let time = |name: &str| summary[name].as_f64().unwrap();
        assert!(time("time_to_detect_s") < time("time_to_water_s"), "{summary}");
        assert!(time("time_to_water_s") < time("time_to_out_s"), "{summary}");
        assert!(time("water_l") > 100.0, "{summary}");
    }
}

#[test]
fn two_fires_one_after_the_other() {
    let run = Run::of(&[
        "demo",
        "--speed=0",
        "--json",
        "--fire=az=-30,range=20",
        "--fire=az=40,range=30,size=2",
    ]);
    assert_eq!((run.code, &run.json()[0]["fires_out"]), (0, &serde_json::json!(2)), "{run:?}");
}

/// A fire behind the monitor is not found; that is reported in both languages, and is a failure.
#[test]
fn what_cannot_be_seen_is_not_found() {
    for (lang, word) in [("en", "found nothing"), ("ru", "ничего не нашёл")] {
        let run = Run::of(&["--lang", lang, "demo", "--speed", "0", "--fire", "az=170,range=20"]);
        assert_eq!(run.code, 1, "{run:?}");
        assert!(run.err.contains(word), "{run:?}");
    }
}
