//! `lafet program` on a simulated monitor.

use crate::support::Sim;
use serde_json::json;

#[test]
fn programs_are_stored_shown_run_and_cleared() {
    let sim = Sim::start(&["--speed", "40"]);
    let all = sim.value(&["program", "list"]);
    let empty = |all: &serde_json::Value| {
        all.as_array().unwrap().iter().filter(|one| one["empty"] == true).count()
    };
    assert_eq!((all.as_array().unwrap().len(), empty(&all)), (16, 16), "{all}");
    let set = sim.value(&[
        "program",
        "set",
        "3",
        "--centre",
        "30deg,-2deg",
        "--sector",
        "6deg,2deg",
        "--step",
        "1",
        "--distance",
        "25",
    ]);
    assert_eq!((&set["centre_arcmin"], &set["saved"]), (&json!([1800, -120]), &json!("stored")));
    let shown = sim.done(&["program", "show", "3"]);
    for word in ["centre 30.0°", "6.0° wide", "nozzle 60 mm", "fire 25 m away"] {
        assert!(shown.out.contains(word), "{word}: {shown:?}");
    }
    assert_eq!(sim.value(&["param", "get", "control", "Program3"])["values"][6], 25);
    let run = sim.done(&["program", "run", "3"]);
    assert!(run.out.contains("StartQuench → Accepted"), "{run:?}");
    assert!(sim.flags("control").contains(&"Quench".to_owned()));
    sim.done(&["stop"]);
    sim.done(&["program", "clear", "3"]);
    assert_eq!(empty(&sim.value(&["program", "list"])), 16);
}

#[test]
fn trajectories_too_and_an_empty_one_cannot_run() {
    let sim = Sim::start(&["--speed", "40"]);
    sim.done(&["deploy"]);
    let points = ["--point", "20deg,-2deg,25,10", "--point", "24deg,-2deg,25,15"];
    sim.done(&[&["program", "set", "0"][..], &points].concat());
    let shown = sim.done(&["program", "show", "0", "--trajectory"]);
    assert!(shown.out.contains("2: 24.0° -2.0°, 25 m, stays 1.5 s"), "{shown:?}");
    assert_eq!(sim.value(&["program", "show", "0"])["empty"], true, "program 0 is separate");
    let run = sim.done(&["program", "run", "0", "--trajectory", "--follow"]);
    assert!(run.out.contains("done"), "{run:?}");
    // §3.15/2
    let run = sim.run(&["program", "run", "1", "--trajectory"]);
    assert!(run.code == 1 && run.err.contains("InvalidId"), "{run:?}");
    for wrong in [&["program", "run", "8"][..], &["program", "set", "0"]] {
        assert_eq!(sim.run(wrong).code, 2, "{wrong:?}");
    }
    let out_of_range = ["program", "set", "1", "--centre", "0,0", "--distance=-1"];
    assert_eq!(sim.run(&out_of_range).code, 1);
    let russian = sim.done(&["--lang", "ru", "program", "list"]);
    assert!(russian.out.contains("траектория 0") && russian.out.contains("пусто"), "{russian:?}");
}

/// An empty program aims at 0°, 0°: nothing is sent unless the user says so.
#[test]
fn an_empty_program_is_asked_about() {
    let sim = Sim::start(&["--speed", "40"]);
    for words in [&["quench", "--program", "5"][..], &["program", "run", "5"]] {
        let run = sim.run(words);
        assert!(run.code == 2 && run.err.contains("--empty"), "{words:?}: {run:?}");
        assert!(!sim.flags("control").contains(&"Quench".to_owned()), "{words:?}");
        let run = sim.done(&[words, &["--empty"]].concat());
        assert!(run.out.contains("StartQuench → Accepted"), "{words:?}: {run:?}");
        sim.done(&["stop"]);
    }
}
