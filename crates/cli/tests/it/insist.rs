//! Stop, Close and Lockout on are tried again while the way to the monitor does not work.

use std::net::TcpListener;
use std::process::Command;
use std::thread::park_timeout;
use std::time::{Duration, Instant};

use crate::support::{Running, Sim, lafet};

const URGENT: [&[&str]; 4] =
    [&["stop"], &["close"], &["lockout", "on"], &["send", "Stop All", "GetStatus General"]];

/// A place at which nothing listens.
fn nowhere() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    format!("tcp://{}", listener.local_addr().unwrap())
}

fn command(url: &str, words: &[&str]) -> Command {
    let mut command = lafet();
    command.args(["--lang", "en", "-c", url]).args(words);
    command
}

/// Its complaint: what is wrong, and that it goes on.
fn complains(running: &Running) {
    while !running.line().contains("Trying for up to 30 s") {}
}

#[test]
fn a_port_that_refuses() {
    for words in URGENT {
        let url = nowhere();
        let mut running = Running::stderr(&mut command(&url, words));
        complains(&running);
        park_timeout(Duration::from_millis(600));
        assert!(running.child.try_wait().unwrap().is_none(), "{words:?} goes on");
        let sim = Sim::listening(&[&url], &[]);
        assert_eq!(running.code(), Some(0), "{words:?} on {}", sim.url());
    }
}

/// What moves is not tried again: it would come when it is not expected any more.
#[test]
fn what_is_not_urgent_fails_at_once() {
    for words in [&["lockout", "off"] as &[&str], &["open"], &["send", "Open Valve1"], &["status"]]
    {
        let since = Instant::now();
        assert_ne!(command(&nowhere(), words).output().unwrap().status.code(), Some(0));
        assert!(since.elapsed() < Duration::from_secs(10), "{words:?}");
    }
}

/// `send` is what it says: each request has its tries.
#[test]
fn a_monitor_that_does_not_answer() {
    for words in &URGENT[..3] {
        let sim = Sim::start(&[]);
        sim.running.signal("STOP");
        let mut running = Running::stderr(command(sim.url(), words).args(["--timeout", "0.3"]));
        complains(&running);
        sim.running.signal("CONT");
        assert_eq!(running.code(), Some(0), "{words:?}");
    }
}
