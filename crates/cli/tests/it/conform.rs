//! `lafet conform` over TCP: what it prints, writes and returns.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread::{park_timeout, spawn};
use std::time::{Duration, Instant};

use crate::support::{Run, Running, Sim};
use lafet_proto::RequestId;
use lafet_proto::link::{BODY_MAX, Decoder, Frame, WIRE_MAX, encode};
use lafet_proto::record::Records;
use serde_json::json;

/// A simulated monitor with a fast clock.
const FAST: [&str; 2] = ["--speed", "20"];

fn file(name: &str) -> String {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    folder.join(name).to_string_lossy().into_owned()
}

#[test]
fn a_right_monitor_passes() {
    let sim = Sim::start(&FAST);
    let url = sim.url();
    let (html, junit) = (file("conform.html"), file("conform.xml"));
    let only = ["--only", "§1", "--only", "3.2", "--only", "probe"];
    let args = ["conform", url, "--html", &html, "--junit", &junit];
    let run = Run::of(&[&args[..], &only, &FAST].concat());
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.out.contains("pass         §1/1     chain-order"), "{run:?}");
    assert!(run.out.contains("0 failed"), "{run:?}");
    assert!(!run.out.contains("§3.3"), "{run:?}");
    let page = std::fs::read_to_string(html).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.contains("Nothing failed"), "{page}");
    let xml = std::fs::read_to_string(junit).unwrap();
    assert!(xml.contains("failures=\"0\"") && xml.contains("classname=\"§1/1\""), "{xml}");

    let run = Run::of(&[&["--lang", "ru", "conform", url, "-q"][..], &only, &FAST].concat());
    assert!(run.code == 0 && run.out.contains("ошибок 0"), "{run:?}");
}

/// A full run says how long it takes.
#[test]
fn a_full_run_says_how_long_it_takes() {
    for (lang, words) in [("en", "About ten minutes"), ("ru", "десяти минут")] {
        let all = ["--lang", lang, "conform", "sim:?speed=20", "--full", "--only", "layout"];
        let run = Run::of(&all);
        assert!(run.code == 0 && run.err.contains(words), "{run:?}");
        let quick = Run::of(&[&all[..4], &all[5..]].concat());
        assert!(quick.code == 0 && !quick.err.contains(words), "{quick:?}");
    }
}

#[test]
fn json_holds_the_bytes() {
    let sim = Sim::start(&FAST);
    let report = sim.value(&[&["conform", "--only", "layout"][..], &FAST].concat());
    assert_eq!((&report["good"], &report["passed"]), (&json!(true), &json!(1)), "{report}");
    let test = &report["tests"][0];
    assert_eq!((&test["item"], &test["label"]), (&json!("§2"), &json!("read")));
    assert_eq!(test["log"][0]["sent"], "FF C0 01 81 D4 C2 00 00 A5 D8 C0", "{test}");
    assert!(report["not_tested"].as_array().unwrap().len() > 5, "{report}");
}

/// Its frames have no numbers, so it listens until what a program before it has asked is answered: what
/// is late then is heard, and nothing is sent.
#[test]
fn a_late_answer_of_another_program_is_not_believed() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("tcp://{}?addr=1", listener.local_addr().unwrap());
    let served = std::thread::spawn(move || {
        let (mut line, _) = listener.accept().unwrap();
        std::thread::park_timeout(Duration::from_millis(4500));
        let mut wire = [0; WIRE_MAX];
        // Climatics is absent.
        let payload = [0xFA, 0x34, 0x02, 0];
        let len = encode(&Frame { dst: 129, src: 1, payload: &payload }, &mut wire).unwrap();
        line.write_all(&wire[..len]).unwrap();
        let mut sent = Vec::new();
        line.read_to_end(&mut sent).map(|_| sent)
    });
    let run = Run::of(&["--lang", "en", "conform", &url]);
    assert!(run.code == 3 && run.err.contains("console 129"), "{run:?}");
    let sent = served.join().unwrap().unwrap();
    assert!(sent.is_empty(), "{sent:02X?}");
}

#[test]
fn wrong_usage_and_no_monitor() {
    assert_eq!(Run::of(&["conform"]).code, 2);
    assert_eq!(Run::of(&["conform", "sim:", "--only", "no-such-test"]).code, 2);
    assert_eq!(Run::of(&["conform", "sim:", "--full", "--motion"]).code, 2);
    let sim = Sim::start(&FAST);
    let other = format!("{}?addr=9", sim.url());
    let run = Run::of(&["--timeout", "0.2", "conform", &other]);
    assert_eq!(run.code, 3, "{run:?}");
}

/// Where the output cannot be written, the test ends like one that is interrupted: everything is
/// restored.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing_changed() {
    let sim = Sim::start(&["--profile", "remote", "--speed", "20"]);
    let speed = || sim.value(&["param", "get", "vertical", "Speed"])["values"][0].clone();
    let before = speed();
    let mut command = crate::support::lafet();
    command.args(["--lang", "en", "conform", sim.url(), "--motion", "--speed", "20"]);
    command.stdout(std::fs::File::options().write(true).open("/dev/full").unwrap());
    let ended = command.stderr(std::process::Stdio::piped()).output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(2), "{said}");
    assert!(said.contains("Restoring everything"), "{said}");
    assert_eq!(speed(), before, "{said}");
    for drive in ["horizontal", "vertical"] {
        assert!(!sim.flags(drive).contains(&"Move".to_owned()), "{drive}: {said}");
    }
}

/// A monitor behind a relay that passes no answer on once something was to move.
struct Mute {
    url: String,
    /// The requests that were passed on.
    asked: Arc<Mutex<Vec<RequestId>>>,
}

impl Mute {
    fn to(sim: &Sim) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("tcp://{}?addr=1", listener.local_addr().unwrap());
        let monitor = sim.place().split('?').next().unwrap().to_owned();
        let asked: Arc<Mutex<Vec<RequestId>>> = Arc::default();
        let seen = asked.clone();
        spawn(move || {
            for near in listener.incoming().map_while(Result::ok) {
                let far = TcpStream::connect(&monitor).unwrap();
                let (back, to) = (far.try_clone().unwrap(), near.try_clone().unwrap());
                let (there, here) = (seen.clone(), seen.clone());
                spawn(move || ask(near, far, &there));
                spawn(move || answer(back, to, &here));
            }
        });
        Self { url, asked }
    }

    fn stops(&self) -> usize {
        self.asked.lock().unwrap().iter().filter(|id| **id == RequestId::STOP).count()
    }

    fn waits(&self, time: Duration, is: impl Fn(&[RequestId]) -> bool) -> bool {
        let start = Instant::now();
        while !is(&self.asked.lock().unwrap()) {
            if start.elapsed() > time {
                return false;
            }
            park_timeout(Duration::from_millis(5));
        }
        true
    }
}

fn ask(mut near: TcpStream, mut far: TcpStream, asked: &Mutex<Vec<RequestId>>) {
    let (mut decoder, mut buffer) = (Decoder::<BODY_MAX>::new(), [0; 512]);
    while let Ok(len @ 1..) = near.read(&mut buffer) {
        for byte in &buffer[..len] {
            let Some(frame) = decoder.push(*byte) else { continue };
            let ids = Records::new(frame.payload).flatten().map(|record| record.request);
            asked.lock().unwrap().extend(ids);
        }
        if far.write_all(&buffer[..len]).is_err() {
            return;
        }
    }
}

fn answer(mut far: TcpStream, mut near: TcpStream, asked: &Mutex<Vec<RequestId>>) {
    let mut buffer = [0; 512];
    while let Ok(len @ 1..) = far.read(&mut buffer) {
        let mute = asked.lock().unwrap().contains(&RequestId::MOVE);
        if !mute && near.write_all(&buffer[..len]).is_err() {
            return;
        }
    }
}

/// However long an answer is waited for, Ctrl-C stops the monitor within a second, and a second one ends the
/// program within one; the last that it has sent is a Stop.
#[cfg(unix)]
#[test]
fn a_second_ctrl_c_ends_it() {
    let sim = Sim::start(&[]);
    let relay = Mute::to(&sim);
    let mut command = crate::support::lafet();
    command.args(["--lang", "en", "--timeout", "8", "conform", &relay.url, "--motion"]);
    let mut running = Running::stderr(command.args(["--only", "§3.1"]));
    let moves = |asked: &[RequestId]| asked.contains(&RequestId::MOVE);
    assert!(relay.waits(Duration::from_secs(60), moves), "it moves nothing");
    let before = relay.stops();
    running.signal("INT");
    // Twice that, on a machine that is busy with other tests.
    let soon = Duration::from_secs(2);
    assert!(relay.waits(soon, |asked| {
        asked.iter().filter(|id| **id == RequestId::STOP).count() > before
    }));
    // Sooner it would belong to the first.
    park_timeout(Duration::from_millis(1100));
    let (before, again) = (relay.stops(), Instant::now());
    running.signal("INT");
    assert_eq!(running.code(), Some(4));
    assert!(again.elapsed() < soon, "{:?}", again.elapsed());
    assert!(relay.waits(soon, |asked| asked.last() == Some(&RequestId::STOP)));
    assert!(relay.stops() > before);
    while !running.line().contains("Given up") {}
}
