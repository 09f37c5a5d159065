//! `lafet tune` on a simulated monitor whose drive follows late and does not turn slowly.

use std::sync::mpsc::channel;

use crate::between::{Fate, between};
use crate::support::{Running, Sim, lafet};
use lafet_proto::RequestId;

/// The fault `lag` is 300 ms, `dead-band` 1 °/s.
#[test]
fn a_poor_drive_is_measured() {
    let sim = Sim::start(&[
        "--speed",
        "20",
        "--fault",
        "horizontal-lag",
        "--fault",
        "horizontal-dead-band",
    ]);
    let run = sim.run(&["deploy"]);
    assert_eq!(run.code, 0, "{run:?}");
    let run = sim.run(&["--json", "tune", "horizontal"]);
    assert_eq!(run.code, 0, "{run:?}");
    let found = &run.json()[0]["drives"][0];
    let lag = found["found"]["StopLag"].as_i64().unwrap();
    let least = found["found"]["MinSpeed"].as_i64().unwrap();
    assert!((240..=360).contains(&lag), "{run:?}");
    assert!((10..=16).contains(&least), "{run:?}");
    let errors = found["errors"].as_array().unwrap();
    assert!(
        errors.len() == 4 && errors.iter().all(|error| error.as_i64().unwrap() <= 2),
        "{run:?}"
    );
    let run = sim.run(&["--json", "param", "get", "horizontal", "StopLag"]);
    assert_eq!(run.json()[0]["values"][0].as_i64(), Some(lag), "{run:?}");
}

#[test]
fn nothing_moves_with_an_open_valve_and_a_dry_run_changes_nothing() {
    let sim = Sim::start(&["--speed", "20"]);
    assert_eq!(sim.run(&["deploy"]).code, 0);
    let run = sim.run(&["tune", "vertical", "--dry-run"]);
    assert!(run.code == 0 && run.out.contains("Nothing was written"), "{run:?}");
    assert_eq!(sim.run(&["open"]).code, 0);
    let run = sim.run(&["tune", "vertical"]);
    assert!(run.code != 0 && run.err.contains("Valve1 is not closed"), "{run:?}");
    let run = sim.run(&["tune", "deployer"]);
    assert!(run.code == 2 && run.err.contains("nothing to tune"), "{run:?}");
}

/// §3.1/8 With its limits off a drive would go on to the end of its travel.
#[test]
fn a_drive_without_limits_does_not_move() {
    let sim = Sim::start(&["--speed", "20"]);
    sim.done(&["deploy"]);
    sim.done(&["limits", "off", "horizontal"]);
    let position = || sim.value(&["status", "horizontal"])["Horizontal"]["position_arcmin"].clone();
    let before = position();
    let run = sim.run(&["tune", "horizontal"]);
    assert!(run.code == 1 && run.err.contains("The limits of Horizontal are off"), "{run:?}");
    assert!(!sim.flags("horizontal").contains(&"Move".to_owned()));
    assert_eq!(position(), before);
}

/// Killed while it measures, it leaves values of its own in the monitor; the next start puts those before back.
#[test]
fn what_kill_9_leaves_is_put_back() {
    let sim = Sim::start(&["--speed", "20"]);
    assert_eq!(sim.run(&["deploy"]).code, 0);
    let of = |name| {
        let run = sim.run(&["--json", "param", "get", "horizontal", name]);
        run.json()[0]["values"][0].as_i64().unwrap()
    };
    for (name, value) in [("StopLag", "321"), ("MinSpeed", "9")] {
        sim.done(&["param", "set", "horizontal", name, value]);
    }
    let mut command = lafet();
    command.args(["-c", sim.url(), "tune", "horizontal"]);
    let mut tuning = Running::stdout(&mut command);
    for _ in 0..400 {
        if of("StopLag") == 0 && of("MinSpeed") == 0 {
            break;
        }
    }
    tuning.signal("KILL");
    assert_eq!(tuning.code(), None, "it was ended by a signal");
    assert_eq!(of("StopLag"), 0, "killed in the middle");
    let run = sim.run(&["tune", "horizontal", "--dry-run"]);
    assert_eq!(run.code, 0, "{run:?}");
    for words in ["StopLag 0 → 321", "MinSpeed 0 → 9"] {
        assert!(run.err.contains(words), "{run:?}");
    }
    assert_eq!((of("StopLag"), of("MinSpeed")), (321, 9));
    let run = sim.run(&["tune", "horizontal", "--dry-run"]);
    assert!(run.code == 0 && !run.err.contains("→ 321"), "it is said once: {run:?}");
}

/// A second tuning leaves the first, its note and its drive alone.
#[test]
fn one_tuning_at_a_time() {
    let sim = Sim::start(&["--speed", "20"]);
    sim.done(&["deploy"]);
    let lag = || sim.value(&["param", "get", "horizontal", "StopLag"])["values"][0].clone();
    sim.done(&["param", "set", "horizontal", "StopLag", "321"]);
    let mut command = lafet();
    command.args(["-c", sim.url(), "tune", "horizontal"]);
    let mut tuning = Running::stdout(&mut command);
    assert!((0..400).any(|_| lag() == 0), "it measures");
    let run = sim.run(&["tune", "horizontal"]);
    assert!(run.code == 1 && run.err.contains("Another lafet tune"), "{run:?}");
    tuning.signal("INT");
    assert_eq!(tuning.code(), Some(130));
    assert_eq!(lag(), 321);
}

/// What the monitor cannot store is not reported as written.
#[test]
fn values_that_are_not_stored_are_no_success() {
    let faulty = ["--speed", "20", "--fault", "horizontal-lag", "--fault", "flash-write"];
    let sim = Sim::start(&faulty);
    sim.done(&["deploy"]);
    let run = sim.run(&["tune", "horizontal"]);
    assert!(run.code == 1 && run.err.contains("ConfigWriteFault"), "{run:?}");
    assert!(!run.out.contains("Written to the monitor"), "{run:?}");
}

/// Ctrl-C between two motions keeps the next one from starting.
#[cfg(unix)]
#[test]
fn a_signal_between_two_motions_is_not_lost() {
    let sim = Sim::start(&["--speed", "20"]);
    sim.done(&["deploy"]);
    let (held, holds) = channel();
    let (go, may) = channel::<()>();
    let mut sets = 0;
    let url = between(&sim, move |asked| {
        let writes = asked.iter().any(|one| one.request == RequestId::SET_PARAM);
        sets += u32::from(writes);
        // The first two are set before anything moves.
        if writes && sets == 3 {
            held.send(()).unwrap();
            may.recv().unwrap();
        }
        Fate::Passed
    });
    let mut command = lafet();
    command.args(["-c", &url, "--lang", "en", "--timeout", "30", "tune", "horizontal"]);
    let mut tuning = Running::stderr(&mut command);
    holds.recv().unwrap();
    tuning.signal("INT");
    go.send(()).unwrap();
    assert_eq!(tuning.code(), Some(130));
}
