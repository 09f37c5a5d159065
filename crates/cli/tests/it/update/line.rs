//! `lafet update` gives way: a Stop passes it on a serial line, and output that is not read does not hold it.

use std::process::Stdio;
use std::time::{Duration, Instant};

use rustix::pipe::fcntl_setpipe_size;
use serde_json::{Value, json};

use super::{Maker, state};
use crate::support::{Run, Running, Sim, lafet};

/// Longest time for a Stop beside an update: the answer of its last order is awaited before.
const SOON: Duration = Duration::from_secs(5);

/// It runs this version, confirmed.
fn is_updated(sim: &Sim) -> bool {
    let state = state(sim);
    state["version"] == "1.1.0.0" && state["on_trial"] == json!(false)
}

/// A Stop on the same serial line, amid the data, is sent at once; the update goes on behind it.
#[test]
fn a_stop_passes() {
    let maker = Maker::new("update-door");
    let image = maker.image("1.1", 24 * 1024);
    let key = format!("0={}", maker.path("key0.pub"));
    let options = ["--board", "bench", "--update-key", &key];
    let sim = Sim::listening(&["pty"], &options);
    let url = format!("serial://{}?addr=1&late=0", sim.port());
    let lock = Run::of(&["-c", &url, "lockout", "on"]);
    assert_eq!(lock.code, 0, "{lock:?}");
    let mut command = lafet();
    command.args(["-c", &url, "--json", "update", &image, "--watch", "5"]);
    let mut update = Running::stdout(&mut command);
    let done = |line: &str| serde_json::from_str::<Value>(line).unwrap()["done"].as_u64();
    while done(&update.line()).is_none_or(|done| done < 1000) {}
    let started = Instant::now();
    let stop = Run::of(&["-c", &url, "stop"]);
    // It has reached the monitor, which is locked out.
    assert!(stop.code == 1 && stop.err.contains("Denied"), "{stop:?}");
    assert!(started.elapsed() < SOON, "{:?}", started.elapsed());
    while !update.line().contains("\"updated\"") {}
    assert_eq!(update.code(), Some(0));
}

/// No program reads what it prints.
#[test]
fn output_that_is_not_read() {
    for ended in [false, true] {
        let maker = Maker::new(if ended { "update-held-int" } else { "update-held" });
        let image = maker.image("1.1", 24 * 1024);
        let sim = maker.monitor(&["--speed", "10"]);
        sim.done(&["lockout", "on"]);
        let (_unread, output) = std::io::pipe().unwrap();
        fcntl_setpipe_size(&output, 4096).unwrap();
        let mut command = lafet();
        command.args(["-c", sim.url(), "--json", "update", &image, "--watch", "5"]);
        command.stdout(output).stderr(Stdio::null());
        let mut update = command.spawn().unwrap();
        drop(command);
        let since = Instant::now();
        let is_there = |sim: &Sim| match ended {
            // More than a page of lines by then.
            true => {
                let state = state(sim);
                state["on_trial"] == json!(true) || state["received"].as_u64() > Some(20 * 1024)
            }
            false => is_updated(sim),
        };
        while !is_there(&sim) {
            assert!(since.elapsed() < Duration::from_secs(90), "{:?}", state(&sim));
        }
        if ended {
            let id = update.id().to_string();
            let kill = std::process::Command::new("kill").args(["-INT", &id]).status().unwrap();
            assert!(kill.success());
        }
        let since = Instant::now();
        let status = update.wait().unwrap();
        assert!(since.elapsed() < Duration::from_secs(10), "{:?}", since.elapsed());
        assert_eq!(status.code(), Some(if ended { 130 } else { 0 }));
    }
}
