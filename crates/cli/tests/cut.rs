//! Cuts the line in each phase of a command, between real processes: by closing the connection, by
//! a reset, and by silence. The user is warned that it may still move or flow; what was started is
//! stopped over the next connection; the exit code shows how that ended.
#![cfg(unix)]

mod support;

use std::fs::File;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use lafet_proto::RequestId;
use lafet_proto::link::Decoder;
use lafet_proto::record::Records;
use socket2::SockRef;
use support::{Running, Sim, lafet, terminal};

/// For how long a line that comes back is cut: longer than the repetitions of a read with
/// [`TIMEOUT`] take.
const AWAY: Duration = Duration::from_millis(2500);
const TIMEOUT: &str = "0.3";

/// How the line is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cut {
    /// The connection is closed (FIN).
    End,
    /// The connection is reset (RST).
    Reset,
    /// Nothing passes any more, and no error is reported.
    Silence,
}

/// When it is cut: at the first frame with this request.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// The request does not arrive.
    Request,
    /// The request arrives, its answer does not.
    Answer,
    /// After this many more answers.
    After(u32),
}

/// Relay between a program and its monitor; cut once.
struct Relay {
    url: String,
    state: Arc<State>,
}

struct State {
    request: RequestId,
    phase: Phase,
    cut: Cut,
    /// Number of answers since the request.
    answers: AtomicU32,
    seen: AtomicBool,
    is_cut: AtomicBool,
    /// When the cut began; the line carries nothing for this time.
    since: Mutex<Option<Instant>>,
    away: Duration,
    /// Both ends of the connection that is cut.
    ends: Mutex<Vec<TcpStream>>,
}

impl Relay {
    fn to(sim: &Sim, request: RequestId, phase: Phase, cut: Cut, away: Duration) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("tcp://{}?addr=1", listener.local_addr().unwrap());
        let monitor = sim.place().split('?').next().unwrap().to_owned();
        let state = Arc::new(State {
            request,
            phase,
            cut,
            answers: AtomicU32::new(0),
            seen: AtomicBool::new(false),
            is_cut: AtomicBool::new(false),
            since: Mutex::default(),
            away,
            ends: Mutex::default(),
        });
        let shared = state.clone();
        thread::spawn(move || {
            for near in listener.incoming().map_while(Result::ok) {
                let again = shared.is_cut.load(Ordering::SeqCst);
                let since = *shared.since.lock().unwrap();
                if since.is_some_and(|since| since.elapsed() < shared.away) {
                    continue;
                }
                let far = TcpStream::connect(&monitor).unwrap();
                let (near_in, far_in) = (near.try_clone().unwrap(), far.try_clone().unwrap());
                if !again {
                    let ends = [near.try_clone().unwrap(), far.try_clone().unwrap()];
                    *shared.ends.lock().unwrap() = ends.into();
                }
                let (there, back) = (shared.clone(), shared.clone());
                thread::spawn(move || copy(near_in, far, &there, !again, true));
                thread::spawn(move || copy(far_in, near, &back, !again, false));
            }
        });
        Self { url, state }
    }
}

impl State {
    fn cut_now(&self) {
        self.since.lock().unwrap().get_or_insert_with(Instant::now);
        if self.is_cut.swap(true, Ordering::SeqCst) || self.cut == Cut::Silence {
            return;
        }
        for end in self.ends.lock().unwrap().drain(..) {
            if self.cut == Cut::Reset {
                let linger = Some(Duration::ZERO);
                SockRef::from(&end).set_linger(linger).unwrap();
            }
            let _ = end.shutdown(match self.cut {
                Cut::Reset => Shutdown::Read,
                _ => Shutdown::Both,
            });
        }
    }

    fn asks(&self, decoder: &mut Decoder, bytes: &[u8]) -> bool {
        let mut asks = false;
        for byte in bytes {
            let Some(frame) = decoder.push(*byte) else { continue };
            let mut records = Records::new(frame.payload).flatten();
            asks |= records.any(|record| record.request == self.request);
        }
        asks
    }
}

/// Passes bytes on until the line is cut; `first`: over the connection to be cut.
fn copy(mut from: TcpStream, mut to: TcpStream, state: &State, first: bool, to_monitor: bool) {
    let mut decoder: Decoder = Decoder::new();
    let mut buffer = [0; 1024];
    while let Ok(len @ 1..) = from.read(&mut buffer) {
        let bytes = &buffer[..len];
        if first && to_monitor && state.asks(&mut decoder, bytes) {
            state.seen.store(true, Ordering::SeqCst);
            if state.phase == Phase::Request {
                state.cut_now();
            }
        }
        if first && !to_monitor && state.seen.load(Ordering::SeqCst) {
            let answers = state.answers.fetch_add(1, Ordering::SeqCst);
            match state.phase {
                Phase::Answer => state.cut_now(),
                Phase::After(count) if answers >= count => state.cut_now(),
                _ => {}
            }
        }
        let dead = first && state.is_cut.load(Ordering::SeqCst);
        if !dead && to.write_all(bytes).is_err() {
            return;
        }
    }
}

const fn phases() -> [(Phase, Cut); 9] {
    [
        (Phase::Request, Cut::End),
        (Phase::Request, Cut::Reset),
        (Phase::Request, Cut::Silence),
        (Phase::Answer, Cut::Reset),
        (Phase::Answer, Cut::Silence),
        (Phase::After(1), Cut::Silence),
        (Phase::After(2), Cut::End),
        (Phase::After(2), Cut::Reset),
        (Phase::After(2), Cut::Silence),
    ]
}

/// A simulated monitor in working position, with a stored program.
fn monitor() -> Sim {
    let sim = Sim::start(&["--profile", "remote"]);
    let program = ["program", "set", "3", "--centre", "30deg,-2deg", "--distance", "25"];
    sim.done(&program);
    sim
}

/// Stop was answered; the drives come to rest a moment later.
fn comes_to_rest(sim: &Sim) {
    let began = Instant::now();
    while sim.flags("horizontal").contains(&"Move".to_owned()) {
        assert!(began.elapsed() < Duration::from_secs(10), "it goes on");
    }
}

fn at_rest(sim: &Sim) {
    for drive in ["horizontal", "vertical"] {
        let flags = sim.flags(drive);
        assert!(!flags.contains(&"Move".to_owned()), "{drive}: {flags:?}");
    }
    let flags = sim.flags("valve1");
    assert!(flags.contains(&"Closed".to_owned()), "{flags:?}");
    assert!(!sim.flags("control").contains(&"Quench".to_owned()));
}

/// Commands: arguments, request, and the warning to the user.
const COMMANDS: [(&[&str], RequestId, &str); 3] = [
    (&["move", "horizontal", "170deg"], RequestId::MOVE, "Horizontal may still move"),
    (&["open"], RequestId::OPEN, "Valve1 may be open, and water may flow"),
    (
        &["program", "run", "3", "--follow"],
        RequestId::START_QUENCH,
        "The extinguishing program may still run",
    ),
];

#[test]
fn what_was_started_is_stopped_over_the_next_connection() {
    thread::scope(|scope| {
        for (phase, cut) in phases() {
            for (words, request, risk) in COMMANDS {
                scope.spawn(move || broken_off(words, request, risk, phase, cut));
            }
        }
    });
}

fn broken_off(words: &[&str], request: RequestId, risk: &str, phase: Phase, cut: Cut) {
    let sim = monitor();
    let relay = Relay::to(&sim, request, phase, cut, AWAY);
    let mut command = lafet();
    command.args(["-c", &relay.url, "--lang", "en", "--timeout", TIMEOUT]).args(words);
    let run = support::Run::of_command(&mut command);
    let what = format!("{words:?} {phase:?} {cut:?}: {run:?}");
    assert!(relay.state.is_cut.load(Ordering::SeqCst), "{what}");
    assert_eq!(run.code, 1, "{what}");
    assert!(run.err.contains(risk), "{what}");
    assert!(run.err.contains("emergency stop now"), "{what}");
    assert!(run.err.contains("at rest now"), "{what}");
    at_rest(&sim);
}

/// A deployment, on a monitor with a Deployer.
#[test]
fn a_deployment_is_stopped_over_the_next_connection() {
    thread::scope(|scope| {
        for (phase, cut) in phases() {
            scope.spawn(move || {
                let sim = Sim::start(&[]);
                let relay = Relay::to(&sim, RequestId::DEPLOY, phase, cut, AWAY);
                let words = ["-c", &relay.url, "--lang", "en", "--timeout", TIMEOUT, "deploy"];
                let run = support::Run::of(&words);
                let what = format!("{phase:?} {cut:?}: {run:?}");
                assert!(relay.state.is_cut.load(Ordering::SeqCst), "{what}");
                assert_eq!(run.code, 1, "{what}");
                assert!(run.err.contains("Deployer may still move"), "{what}");
                assert!(run.err.contains("at rest now"), "{what}");
                let flags = sim.flags("deployer");
                let moves =
                    |flag: &String| ["Move", "Deploying", "Wrapping"].contains(&flag.as_str());
                assert!(!flags.iter().any(moves), "{what}: {flags:?}");
            });
        }
    });
}

/// Limits that were off to be taught are on again, and it is not said that nothing was started.
#[test]
fn a_teaching_is_undone_over_the_next_connection() {
    thread::scope(|scope| {
        for request in [RequestId::SWITCH_LIMITS, RequestId::SET_PARAM] {
            for (phase, cut) in
                phases().into_iter().filter(|(it, _)| !matches!(it, Phase::After(_)))
            {
                scope.spawn(move || {
                    let sim = monitor();
                    let relay = Relay::to(&sim, request, phase, cut, AWAY);
                    let words = ["--lang", "en", "--timeout", TIMEOUT, "--json", "-c", &relay.url];
                    let words = [&words[..], &["limits", "teach", "horizontal"]].concat();
                    let run = support::Run::fed(&words, b"\n");
                    let what = format!("{request} {phase:?} {cut:?}: {run:?}");
                    assert!(relay.state.is_cut.load(Ordering::SeqCst), "{what}");
                    assert_eq!(run.code, 1, "{what}");
                    assert_eq!(run.json()[0]["error"]["at_rest"], true, "{what}");
                    assert!(run.err.contains("limits of Horizontal may still be off"), "{what}");
                    let flags = sim.flags("horizontal");
                    assert!(!flags.contains(&"Limitless".to_owned()), "{what}: {flags:?}");
                    at_rest(&sim);
                });
            }
        }
    });
}

/// A drive that is being measured, and a motion of a shell's script.
#[test]
fn tuning_and_shell_stop_over_the_next_connection() {
    thread::scope(|scope| {
        for (phase, cut) in phases() {
            for words in [&["tune", "horizontal"][..], &["shell"]] {
                scope.spawn(move || {
                    let sim = monitor();
                    let relay = Relay::to(&sim, RequestId::MOVE, phase, cut, AWAY);
                    let all = ["-c", &relay.url, "--lang", "en", "--timeout", TIMEOUT];
                    let script = b"move horizontal 170deg\n";
                    let run = support::Run::fed(&[&all[..], words].concat(), script);
                    let what = format!("{words:?} {phase:?} {cut:?}: {run:?}");
                    assert!(relay.state.is_cut.load(Ordering::SeqCst), "{what}");
                    assert_eq!(run.code, 1, "{what}");
                    assert!(run.err.contains("Horizontal may still move"), "{what}");
                    assert!(run.err.contains("at rest now"), "{what}");
                    at_rest(&sim);
                });
            }
        }
    });
}

/// A Stop is repeated until it is answered, and is then complete.
#[test]
fn a_stop_goes_on_until_it_has_arrived() {
    let sim = monitor();
    for (phase, cut) in phases().into_iter().filter(|(phase, _)| !matches!(phase, Phase::After(_)))
    {
        sim.done(&["move", "horizontal", "170deg", "--no-wait"]);
        let relay = Relay::to(&sim, RequestId::STOP, phase, cut, AWAY);
        let run =
            support::Run::of(&["-c", &relay.url, "--lang", "en", "--timeout", TIMEOUT, "stop"]);
        assert_eq!(run.code, 0, "{phase:?} {cut:?}: {run:?}");
        comes_to_rest(&sim);
        sim.done(&["move", "horizontal", "0"]);
    }
}

/// So is a Close, which is complete once the valve was seen closed. An absent valve is never seen
/// closed.
#[test]
fn a_close_goes_on_until_the_valve_is_closed() {
    thread::scope(|scope| {
        for (phase, cut) in phases() {
            scope.spawn(move || {
                let sim = monitor();
                sim.done(&["open"]);
                let relay = Relay::to(&sim, RequestId::CLOSE, phase, cut, AWAY);
                let words = ["-c", &relay.url, "--timeout", TIMEOUT, "--json", "close"];
                let run = support::Run::of(&words);
                let what = format!("{phase:?} {cut:?}: {run:?}");
                assert!(relay.state.is_cut.load(Ordering::SeqCst), "{what}");
                assert_eq!(run.code, 0, "{what}");
                assert_eq!(run.json()[0]["done"], true, "{what}");
                at_rest(&sim);
            });
        }
    });
    let sim = monitor();
    let relay = Relay::to(&sim, RequestId::CLOSE, Phase::Answer, Cut::Reset, AWAY);
    let run = support::Run::of(&["-c", &relay.url, "--timeout", TIMEOUT, "close", "valve2"]);
    assert_ne!(run.code, 0, "{run:?}");
}

/// A valve that stays open was not closed, whatever the line does meanwhile.
#[test]
fn a_close_that_is_given_up_is_not_done() {
    let sim = monitor();
    sim.done(&["open"]);
    let relay = Relay::to(&sim, RequestId::CLOSE, Phase::Request, Cut::Silence, Duration::MAX);
    let mut command = lafet();
    command.args(["-c", &relay.url, "--lang", "en", "close"]);
    let mut running = Running::stderr(&mut command);
    while !running.line().contains("Ctrl-C gives up") {}
    running.signal("INT");
    assert_eq!(running.code(), Some(4));
    assert!(sim.flags("valve1").contains(&"Open".to_owned()));
}

/// Ctrl-C without an answer gives up, and names the emergency stop; over an intact line the motion
/// is stopped.
#[test]
fn ctrl_c_with_the_line_cut() {
    let sim = monitor();
    for (cut, words, request) in [
        (Cut::Reset, &["move", "horizontal", "170deg"][..], RequestId::MOVE),
        (Cut::Silence, &["move", "horizontal", "-170deg"][..], RequestId::MOVE),
        (Cut::End, &["stop"][..], RequestId::STOP),
    ] {
        let relay = Relay::to(&sim, request, Phase::Answer, cut, Duration::MAX);
        let mut command = lafet();
        command.args(["-c", &relay.url, "--lang", "en"]).args(words);
        let mut running = Running::stderr(&mut command);
        while !running.line().contains("Ctrl-C gives up") {}
        running.signal("INT");
        assert_eq!(running.code(), Some(4), "{cut:?} {words:?}");
        let mut said = running.line();
        while !said.contains("Use the emergency stop.") {
            said = running.line();
        }
        sim.done(&["stop"]);
    }
}

/// A motion held by a key ends by itself, and the program reports how.
#[test]
fn a_jog_ends_when_the_line_is_cut() {
    let sim = monitor();
    for cut in [Cut::End, Cut::Reset, Cut::Silence] {
        let relay = Relay::to(&sim, RequestId::MOVE, Phase::After(2), cut, AWAY);
        let (mut keys, path) = terminal();
        let mut screen = keys.try_clone().unwrap();
        thread::spawn(move || {
            let mut buffer = [0; 1024];
            while let Ok(1..) = screen.read(&mut buffer) {}
        });
        let mut command = lafet();
        let end = File::options().read(true).write(true).open(&path).unwrap();
        command.args(["-c", &relay.url, "jog", "--lease", "0.5"]).stdin(end);
        let mut jog = Running::stderr(&mut command);
        assert!(jog.line().contains("Stop All"));
        let began = Instant::now();
        while !relay.state.is_cut.load(Ordering::SeqCst) {
            keys.write_all(b"\x1b[D").unwrap();
            jog.line();
            assert!(began.elapsed() < Duration::from_secs(30), "{cut:?}: never cut");
        }
        while sim.flags("horizontal").contains(&"Move".to_owned()) {
            assert!(began.elapsed() < Duration::from_secs(60), "{cut:?}: no key is held");
        }
        keys.write_all(b"q").unwrap();
        assert_eq!(jog.code(), Some(0), "{cut:?}");
        at_rest(&sim);
        sim.done(&["move", "horizontal", "0"]);
    }
}

/// The tester tries to reach the monitor again, stops it, and restores everything.
#[test]
fn conform_restores_everything() {
    let sim = monitor();
    let speed = || sim.value(&["param", "get", "horizontal", "Speed"])[0]["values"][0].clone();
    let before = speed();
    for cut in [Cut::End, Cut::Reset, Cut::Silence] {
        let relay = Relay::to(&sim, RequestId::MOVE, Phase::After(2), cut, AWAY);
        let args = ["--lang", "en", "conform", &relay.url, "--motion", "--only", "moves"];
        let run = support::Run::of(&args);
        let what = format!("{cut:?}: {run:?}");
        assert_eq!(run.code, 1, "{what}");
        assert!(run.err.contains("may still move"), "{what}");
        assert!(!run.out.contains("NOT RESTORED"), "{what}");
        at_rest(&sim);
        assert_eq!(speed(), before, "{what}");
    }
    let relay = Relay::to(&sim, RequestId::MOVE, Phase::After(2), Cut::Reset, Duration::MAX);
    let mut command = lafet();
    command.args(["--lang", "en", "conform", &relay.url, "--motion", "--only", "moves"]);
    let mut running = Running::stderr(&mut command);
    while !running.line().contains("Ctrl-C twice gives up") {}
    running.signal("INT");
    while !running.line().contains("Interrupted: restoring") {}
    // Not one that bounces.
    thread::park_timeout(Duration::from_millis(1200));
    running.signal("INT");
    assert_eq!(running.code(), Some(4));
}

/// A terminal that closes sends SIGHUP once more when its shell ends: the valve is closed for all
/// that.
#[test]
fn a_terminal_that_closes_does_not_give_up_the_close() {
    let sim = monitor();
    for second in ["HUP", "TERM"] {
        let mut command = lafet();
        command.args(["-c", sim.url(), "--lang", "en", "open"]);
        let mut running = Running::stderr(&mut command);
        while !running.line().contains("Opening") {}
        running.signal("HUP");
        while !running.line().contains("Interrupted: Close Valve1") {}
        running.signal(second);
        assert_eq!(running.code(), Some(130), "{second}");
        at_rest(&sim);
    }
}
