//! A serial port that one program of ours has and another one needs at once: real processes on a
//! pseudo-terminal.

use std::io::Write;
use std::path::Path;
use std::process::Stdio;
use std::thread::park_timeout;
use std::time::{Duration, Instant};

use crate::support::{Run, Running, Sim, lafet};
use lafet_client::transport::port::holders;

/// A Stop is through within this time, on a machine that is busy with other tests too. A line of which
/// nothing is known is listened to for 3 s.
const AT_ONCE: Duration = Duration::from_millis(2500);

/// The port of a simulated monitor, and its URL.
fn line() -> (Sim, String, String) {
    let sim = Sim::listening(&["pty"], &[]);
    let url = sim.url().to_owned();
    let path = sim.port().to_owned();
    (sim, url, path)
}

/// Waits until a process has the port open.
fn has(running: &Running, path: &str) {
    let began = Instant::now();
    while holders(Path::new(path)).iter().all(|holder| holder.pid != running.child.id()) {
        assert!(began.elapsed() < Duration::from_secs(60), "it never opened {path}");
        park_timeout(Duration::from_millis(5));
    }
}

/// While a scan probes, too: it goes on after the Stop is answered.
#[test]
fn a_stop_does_not_wait_for_a_scan_that_probes() {
    let (_sim, url, path) = line();
    let words = ["--insist", "scan", "--addresses", "1-60"];
    let mut scan = Running::stderr(lafet().args(["--lang", "en", "-c", &url]).args(words));
    has(&scan, &path);
    while !scan.line().contains("33") {}
    let began = Instant::now();
    let stop = Run::of(&["-c", &url, "stop"]);
    let took = began.elapsed();
    assert!(stop.code == 0 && took < AT_ONCE, "{took:?} {stop:?}");
    while !scan.line().contains("starts again") {}
    assert_eq!(scan.code(), Some(0));
}

/// A program that locks nothing and has the port already is noticed and named, except by what stops.
#[test]
fn a_program_that_does_not_lock_is_noticed() {
    let (_sim, url, path) = line();
    let mut command = std::process::Command::new("sh");
    command.args(["-c", "exec 3<>\"$0\"; echo open >&2; read _", &path]).stdin(Stdio::piped());
    let other = Running::stderr(&mut command);
    assert_eq!(other.line(), "open");
    let status = Run::of(&["--lang", "en", "-c", &url, "status"]);
    let named = format!("in use by sh ({})", other.child.id());
    assert!(status.code == 3 && status.err.contains(&named), "{status:?}");
    assert_eq!(Run::of(&["-c", &url, "stop"]).code, 0);
}

/// Who keeps the port is named, with what to do; a Stop is sent as soon as it has ended.
#[test]
fn who_keeps_the_port_is_named() {
    for (lang, word) in [("en", "emergency stop"), ("ru", "аварийный останов")] {
        let (_sim, url, path) = line();
        let watch = Running::stdout(lafet().args(["-c", &url, "--insist", "watch"]));
        has(&watch, &path);
        let mut stop = Running::stderr(lafet().args(["--lang", lang, "-c", &url, "stop"]));
        let (said, pid) = (stop.line(), watch.child.id());
        for part in [word, &path, &format!("lafet ({pid})"), &format!("kill {pid}")] {
            assert!(said.contains(part), "{part}: {said}");
        }
        watch.signal("INT");
        assert_eq!(stop.code(), Some(0));
    }
}

/// A shell that was stopped while it listened finds its own port free again.
#[test]
fn a_shell_goes_on_after_a_stop_while_it_listened() {
    let (_sim, url, _) = line();
    let mut command = lafet();
    command.args(["--lang", "en", "shell", &url]).stdin(Stdio::piped());
    let mut shell = Running::stdout(&mut command);
    shell.child.stdin.take().unwrap().write_all(b"stop\nstatus general\n").unwrap();
    let shown = shell.line();
    assert!(shown.contains("General"), "{shown}");
    assert_eq!(shell.code(), Some(0));
}
