//! `lafet limits teach` on simulated monitors (§3.17).

use std::io::{Read, Write};
use std::process::Stdio;

use crate::between::{Asked, Fate, between};
use crate::support::{Run, Running, Sim, lafet};
use lafet_proto::RequestId;
use serde_json::{Value, json};

fn limits(sim: &Sim, drive: &str) -> (Value, Value) {
    let all = sim.value(&["limits", drive]);
    let one = all.as_object().unwrap().values().next().unwrap().clone();
    (one["min"].clone(), one["max"].clone())
}

#[test]
fn the_present_position_becomes_a_limit() {
    let sim = Sim::start(&["--speed", "40"]);
    sim.done(&["deploy"]);
    sim.done(&["move", "horizontal", "30deg"]);
    let taken = sim.value(&["limits", "teach", "--here", "left"]);
    let at = taken["position"].clone();
    assert_eq!((&taken["in_force"], &taken["max"]), (&json!(true), &at), "{taken}");
    assert!((at.as_i64().unwrap() - 1800).abs() <= 2);
    assert_eq!(limits(&sim, "horizontal").1, at);
    assert!(!sim.flags("horizontal").contains(&"Limitless".to_owned()));
    // The same while limits are off: they stay off, and the new limit waits for `limits on`.
    sim.done(&["limits", "off", "vertical"]);
    let run = sim.done(&["limits", "teach", "--here", "down"]);
    assert!(run.out.contains("after `lafet limits on Vertical`"), "{run:?}");
    assert!(sim.flags("vertical").contains(&"Limitless".to_owned()));
    sim.done(&["limits", "on", "vertical"]);
    assert_eq!(limits(&sim, "vertical").0, json!(0));
    // The left limit cannot be the right one as well: the old ones stay.
    let before = limits(&sim, "horizontal");
    let run = sim.run(&["limits", "teach", "--here", "right"]);
    assert!(run.code == 1 && run.err.contains("InvalidValue"), "{run:?}");
    assert_eq!(limits(&sim, "horizontal"), before);
    assert!(!sim.flags("horizontal").contains(&"Limitless".to_owned()));
}

/// The URL of a line to the monitor on which the first SwitchLimits with this state has this fate.
fn losing(sim: &Sim, state: u8, fate: Fate) -> String {
    let mut done = false;
    between(sim, move |asked| {
        let switches =
            |one: &Asked| one.request == RequestId::SWITCH_LIMITS && one.data == [state, 0];
        if done || !asked.iter().any(switches) {
            return Fate::Passed;
        }
        done = true;
        fate
    })
}

/// Limits that a refused change has switched off are on again, although the first Reject is lost.
#[test]
fn a_lost_reject_leaves_no_limits_off() {
    let sim = Sim::start(&["--speed", "40"]);
    sim.done(&["deploy"]);
    sim.done(&["move", "horizontal", "30deg"]);
    sim.done(&["limits", "teach", "--here", "left"]);
    let before = limits(&sim, "horizontal");
    let url = losing(&sim, 2, Fate::Lost);
    // The left limit cannot be the right one as well.
    let run = Run::of(&["-c", &url, "--lang", "en", "limits", "teach", "--here", "right"]);
    assert_ne!(run.code, 0, "{run:?}");
    assert!(!sim.flags("horizontal").contains(&"Limitless".to_owned()), "{run:?}");
    assert_eq!(limits(&sim, "horizontal"), before);
    assert!(format!("{}{}", run.out, run.err).contains("keeps its old limits"), "{run:?}");
}

/// If the answer that switches the new limits on is lost, it is not said that the old ones apply.
#[test]
fn limits_that_came_into_force_are_named() {
    let sim = Sim::start(&["--speed", "40"]);
    sim.done(&["deploy"]);
    sim.done(&["move", "horizontal", "30deg"]);
    let before = limits(&sim, "horizontal");
    let url = losing(&sim, 1, Fate::AnswerLost);
    let run = Run::of(&["-c", &url, "--lang", "en", "limits", "teach", "--here", "left"]);
    assert_ne!(run.code, 0, "{run:?}");
    assert_ne!(limits(&sim, "horizontal"), before, "it was executed");
    let said = format!("{}{}", run.out, run.err);
    assert!(said.contains("the new limits are in force"), "{run:?}");
    assert!(!said.contains("old limits"), "{run:?}");
}

/// A guided run in which a program answers in lines.
#[test]
fn it_guides_to_each_limit_and_gives_up_cleanly() {
    let sim = Sim::start(&["--speed", "10", "--profile", "ex"]);
    sim.run(&["deploy"]);
    let start = || {
        let mut command = lafet();
        command.args(["-c", sim.url(), "limits", "teach", "horizontal"]).stdin(Stdio::piped());
        let mut running = Running::stderr(&mut command);
        let stdin = running.child.stdin.take().unwrap();
        (running, stdin)
    };
    let until = |running: &Running, word: &str| while !running.line().contains(word) {};
    let before = limits(&sim, "horizontal");
    let (mut running, mut stdin) = start();
    until(&running, "its left limit");
    assert!(sim.flags("horizontal").contains(&"Limitless".to_owned()));
    sim.done(&["move", "horizontal", "20deg"]);
    stdin.write_all(b"\n").unwrap();
    until(&running, "its right limit");
    sim.done(&["move", "horizontal", "-25deg"]);
    stdin.write_all(b"\n").unwrap();
    until(&running, "limits are on");
    assert_eq!(running.code(), Some(0));
    let (min, max) = limits(&sim, "horizontal");
    let near = |value: &Value, wanted: i64| (value.as_i64().unwrap() - wanted).abs() <= 2;
    assert!(near(&min, -1500) && near(&max, 1200) && before.1 != max, "{min} {max}");

    let (mut running, mut stdin) = start();
    until(&running, "its left limit");
    stdin.write_all(b"\n").unwrap();
    until(&running, "its right limit");
    stdin.write_all(b"q\n").unwrap();
    assert_eq!(running.code(), Some(130));
    assert_eq!(limits(&sim, "horizontal"), (min, max), "what was abandoned is discarded");
    assert!(!sim.flags("horizontal").contains(&"Limitless".to_owned()));
}

#[test]
fn what_cannot_be_taught_says_why() {
    let switches = Sim::start(&["--profile", "limit-switch"]);
    let run = switches.run(&["limits", "teach", "--here", "left"]);
    assert!(run.code == 1 && run.err.contains("NotSupported"), "{run:?}");
    for (arguments, word) in [
        (&["limits", "teach", "--here", "behind"][..], "left, right, up, down"),
        (&["limits", "teach", "deployer"], "Deployer"),
        (&["limits", "teach", "left"], "Vertical"),
    ] {
        let run = switches.run(arguments);
        assert!(run.code == 2 && run.err.contains(word), "{arguments:?}: {run:?}");
    }
}

/// At a terminal the arrow keys move the drive, and Enter takes its position.
#[cfg(unix)]
#[test]
fn the_arrow_keys_move_it() {
    use std::fs::File;

    use crate::support::terminal;

    let sim = Sim::start(&["--speed", "10"]);
    sim.done(&["deploy"]);
    let (mut keys, path) = terminal();
    let mut screen = keys.try_clone().unwrap();
    std::thread::spawn(move || {
        let mut buffer = [0; 1024];
        while let Ok(1..) = screen.read(&mut buffer) {}
    });
    let terminal = File::options().read(true).write(true).open(&path).unwrap();
    let mut command = lafet();
    command.args(["-c", sim.url(), "limits", "teach", "horizontal"]).stdin(terminal);
    let mut running = Running::stderr(&mut command);
    while !running.line().contains("its left limit") {}
    let position = || {
        let status = sim.value(&["status", "horizontal"]);
        status["Horizontal"]["position_arcmin"].as_i64().unwrap()
    };
    let moved = (0..200).any(|_| {
        keys.write_all(b"\x1b[D").unwrap();
        sim.flags("horizontal").contains(&"Move".to_owned())
    });
    assert!(moved, "the key moves the drive");
    keys.write_all(b"\r").unwrap();
    while !running.line().contains("its right limit") {}
    let left = position();
    assert!(left > 0, "{left}");
    keys.write_all(b"s").unwrap();
    assert_eq!(running.code(), Some(0));
    assert_eq!(limits(&sim, "horizontal").1, json!(left));
}
