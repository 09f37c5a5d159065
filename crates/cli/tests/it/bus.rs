//! `lafet bus`: the controller between simulated monitors, consoles and programs, as processes.

use std::fs::File;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::Stdio;
use std::sync::{Arc, Mutex};

use crate::json::has_shape;
use crate::support::{Run, Running, Sim, lafet, serial_line};
use lafet_proto::link::{Decoder, Frame, WIRE_MAX, encode};
use lafet_sim::rng::Rng;

/// A line shared by several processes: each receives what the others send, as on RS-485.
struct Hub {
    place: String,
    stations: Arc<Mutex<Vec<TcpStream>>>,
}

impl Hub {
    fn new() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let place = listener.local_addr().unwrap().to_string();
        let hub = Self { place, stations: Arc::default() };
        let stations = hub.stations.clone();
        std::thread::spawn(move || {
            for stream in listener.incoming().map_while(Result::ok) {
                join(&stations, stream);
            }
        });
        hub
    }

    /// Connects a simulated monitor as a station.
    fn joined_by(&self, sim: &Sim) {
        join(&self.stations, TcpStream::connect(sim.place()).unwrap());
    }

    fn url(&self, options: &str) -> String {
        format!("tcp://{}?{options}", self.place)
    }
}

fn join(stations: &Arc<Mutex<Vec<TcpStream>>>, mut stream: TcpStream) {
    stream.set_nodelay(true).unwrap();
    let name = stream.peer_addr().unwrap();
    stations.lock().unwrap().push(stream.try_clone().unwrap());
    let stations = stations.clone();
    std::thread::spawn(move || {
        let mut buffer = [0; 1024];
        while let Ok(len @ 1..) = stream.read(&mut buffer) {
            // A station that has disconnected is removed.
            stations.lock().unwrap().retain_mut(|other| match other.peer_addr() {
                Ok(peer) => peer == name || other.write_all(&buffer[..len]).is_ok(),
                Err(_) => false,
            });
        }
        stations.lock().unwrap().retain(|other| other.peer_addr().is_ok_and(|peer| peer != name));
    });
}

/// What a line does to what passes.
#[derive(Clone, Copy, Default)]
struct Flaws {
    /// Thousandths of what is sent that are lost, from the first port to the second and back.
    loss: [u64; 2],
    /// The first port hears what it sends.
    echo: bool,
}

/// Connects two serial ports; returns their paths.
fn cable() -> (String, String) {
    flawed_cable(Flaws::default())
}

fn flawed_cable(flaws: Flaws) -> (String, String) {
    let ((a, kept_a, path_a), (b, kept_b, path_b)) = (serial_line(), serial_line());
    let [there, back] = flaws.loss;
    let ways = [
        (a.try_clone().unwrap(), b.try_clone().unwrap(), kept_a, there, flaws.echo),
        (b, a, kept_b, back, false),
    ];
    for (mut from, mut to, kept, loss, echo) in ways {
        std::thread::spawn(move || {
            let (_kept, mut dice, mut buffer) = (kept, Rng::new(loss), [0; 1024]);
            while let Ok(len @ 1..) = from.read(&mut buffer) {
                if echo {
                    from.write_all(&buffer[..len]).unwrap();
                }
                if dice.below(1000) >= loss {
                    to.write_all(&buffer[..len]).unwrap();
                }
            }
        });
    }
    (path_a, path_b)
}

fn controller(arguments: &[&str]) -> Running {
    Running::stdout(lafet().arg("--json").arg("bus").args(arguments))
}

/// Waits until the controller has reported all of these.
fn told(bus: &Running, mut expected: Vec<&str>) {
    while !expected.is_empty() {
        let line = bus.line();
        has_shape("bus", &line);
        expected.retain(|text| !line.contains(text));
    }
}

fn done(url: &str, arguments: &[&str]) -> Run {
    let run = Run::of(&[&["-c", url], arguments].concat());
    assert_eq!(run.code, 0, "{arguments:?}: {run:?}");
    run
}

#[test]
fn monitors_and_consoles_on_one_line() {
    let (one, two) = (Sim::start(&["--addr", "1"]), Sim::start(&["--addr", "2"]));
    let hub = Hub::new();
    hub.joined_by(&one);
    hub.joined_by(&two);
    let bus = controller(&[&hub.url(""), "--addresses", "1-2,130-131"]);
    told(&bus, vec![r#""appeared":1}"#, r#""appeared":2}"#]);
    let console = hub.url("role=active&src=130&addr=2");
    done(&console, &["deploy", "--no-wait"]);
    let status = done(&console, &["--json", "status", "Deployer"]);
    assert!(status.out.contains("Deploying"), "{status:?}");
    told(&bus, vec![r#""request":"Deploy Deployer""#]);
    // The controller itself reports another console.
    let other = hub.url("role=active&src=131");
    let who = done(&other, &["--json", "bus", "who"]);
    has_shape("bus-who", &who.out);
    assert_eq!(who.json()[0]["present"].as_array().unwrap()[..2], [1, 2]);
    let log = done(&other, &["--json", "bus", "log"]).json();
    assert_eq!(log.len(), 1, "{log:?}");
    has_shape("bus-log", &log[0].to_string());
    assert_eq!((&log[0]["src"], &log[0]["dst"]), (&130.into(), &2.into()));
    // Two at a time, each in its turn.
    std::thread::scope(|scope| {
        for (src, addr) in [(130, 1), (131, 2)] {
            let url = hub.url(&format!("role=active&src={src}&addr={addr}"));
            scope.spawn(move || {
                let watch = ["--json", "watch", "Valve1", "--count", "3", "--interval", "0.1"];
                assert_eq!(done(&url, &watch).json().len(), 3);
            });
        }
    });
    // A console on a healthy bus finds no fault.
    let well = done(&console, &["--json", "doctor", "--requests", "5"]).json();
    assert_eq!(well[0]["findings"][0]["finding"], "well", "{well:?}");
    // A client that does not wait for its turn is shown what is missing.
    let direct = Run::of(&["-c", &hub.url("src=131"), "bus", "who"]);
    assert!(direct.code == 3 && direct.err.contains("role=active"), "{direct:?}");
    // With a monitor on a line of its own, no controller grants access.
    let alone = Run::of(&["-c", &format!("{}?role=active", one.url()), "status"]);
    assert!(alone.code == 3 && alone.err.contains("role=direct"), "{alone:?}");
    bus.signal("INT");
    let mut last = bus.line();
    while !last.contains("programs_dropped") {
        last = bus.line();
    }
    has_shape("bus-totals", &last);
}

/// Where a controller grants access, a recorder without an address of its own only listens, and
/// records what others send.
#[test]
fn a_recorder_beside_a_controller_only_listens() {
    let one = Sim::start(&["--addr", "1"]);
    let hub = Hub::new();
    hub.joined_by(&one);
    let bus = controller(&[&hub.url(""), "--addresses", "1,130"]);
    told(&bus, vec![r#""appeared":1}"#]);
    let console = hub.url("role=active&src=130&addr=1");
    std::thread::scope(|scope| {
        // The console has its turns while the recorder runs.
        let asks = scope.spawn(|| {
            let watch = ["--json", "watch", "General", "--count", "40", "--interval", "0.1"];
            assert_eq!(done(&console, &watch).json().len(), 40);
        });
        let recording = format!("{}/beside.mcap", env!("CARGO_TARGET_TMPDIR"));
        let url = hub.url("addr=1&src=129");
        told(&bus, vec![r#""appeared":130}"#]);
        let run = Run::of(&["-c", &url, "record", &recording, "--force", "--for", "2"]);
        assert_eq!(run.code, 0, "{run:?}");
        assert!(run.err.contains("A controller gives access"), "{run:?}");
        let frames = Run::of(&["--json", "replay", &recording, "--speed", "0"]).json();
        let from = |src: u8| frames.iter().filter(|frame| frame["src"] == src).count();
        assert_eq!(from(129), 0, "it sent requests: {frames:?}");
        assert!(from(1) > 0 && from(130) > 0, "{frames:?}");
        asks.join().unwrap();
    });
}

#[test]
fn consoles_on_a_serial_line_of_their_own() {
    let sim = Sim::listening(&["pty"], &["--addr", "5"]);
    let (ours, theirs) = cable();
    let mut bus =
        controller(&[sim.url(), &format!("serial://{ours}"), "--addresses", "4-5,129-130"]);
    told(&bus, vec![r#""appeared":5}"#]);
    let console = format!("serial://{theirs}?role=active&src=129&addr=5");
    assert_eq!(done(&console, &["lockout", "on"]).code, 0);
    let absent = format!("serial://{theirs}?role=active&src=129&addr=4");
    assert_eq!(Run::of(&["-c", &absent, "status"]).code, 3);
    told(&bus, vec![r#""request":"Lockout All on""#]);
    bus.signal("TERM");
    let last = loop {
        let line = bus.line();
        if line.contains("passed_on") {
            break line;
        }
    };
    let last: serde_json::Value = serde_json::from_str(&last).unwrap();
    assert!(last["passed_on"].as_u64().unwrap() >= 4, "{last}");
    assert_eq!(bus.code(), Some(0));
}

/// A monitor that disappears is dropped and found again; programs share the controller's turns.
#[test]
fn programs_and_a_monitor_that_disappears() {
    let sim = Sim::listening(&["tcp://127.0.0.1:0"], &["--addr", "1"]);
    let arguments = [sim.url(), "--addresses", "1", "--watch", "0.2", "--listen", "127.0.0.1:0"];
    let bus = controller(&arguments);
    let place = bus.line();
    let place: serde_json::Value = serde_json::from_str(&place).unwrap();
    let url = place["listening"].as_str().unwrap().to_owned();
    told(&bus, vec![r#""appeared":1}"#]);
    std::thread::scope(|scope| {
        for name in ["Vertical", "Horizontal", "Valve1", "Control"] {
            let url = &url;
            scope.spawn(move || {
                for _ in 0..3 {
                    assert!(done(url, &["status", name]).out.starts_with(name));
                }
            });
        }
    });
    let checked = done(&format!("{url}?check=crc32c"), &["--json", "status", "Vertical"]);
    assert_eq!(checked.json().len(), 1);
    assert_eq!(done(&url, &["--json", "bus", "who"]).json()[0]["present"][0], 1);
    let well = done(&url, &["--json", "doctor", "--requests", "5"]).json();
    assert_eq!(well[0]["findings"][0]["finding"], "well", "{well:?}");
    sim.running.signal("STOP");
    told(&bus, vec![r#""dropped":1}"#]);
    assert_eq!(
        done(&url, &["--json", "bus", "who"]).json()[0]["present"][0],
        serde_json::Value::Null
    );
    sim.running.signal("CONT");
    told(&bus, vec![r#""appeared":1}"#]);
    done(&url, &["stop"]);
}

/// Programs reach the monitors while the line of the consoles is lost.
#[test]
fn a_lost_line_of_consoles_keeps_no_program_out() {
    let sim = Sim::listening(&["tcp://127.0.0.1:0"], &["--addr", "1"]);
    let consoles = TcpListener::bind("127.0.0.1:0").unwrap();
    let theirs = format!("tcp://{}", consoles.local_addr().unwrap());
    let bus = controller(&[sim.url(), &theirs, "--addresses", "1", "--listen", "127.0.0.1:0"]);
    let place: serde_json::Value = serde_json::from_str(&bus.line()).unwrap();
    let url = place["listening"].as_str().unwrap().to_owned();
    let (line, _) = consoles.accept().unwrap();
    told(&bus, vec![r#""appeared":1}"#]);
    done(&url, &["stop"]);
    drop((line, consoles));
    told(&bus, vec![r#""lost":"#]);
    done(&url, &["stop"]);
}

#[test]
fn wrong_usage() {
    let usage = |arguments: &[&str], expected: &str| {
        let run = Run::of(&[&["bus"], arguments].concat());
        assert!(run.code == 2 && run.err.contains(expected), "{arguments:?}: {run:?}");
    };
    usage(&["sim:"], "lafet sim");
    usage(&["tcp://h?framing=records"], "cannot form a bus");
    usage(&["tcp://h?role=active"], "for consoles");
    usage(&["tcp://h", "--addresses", "0"], "1-8,129");
    usage(&["tcp://h", "--addresses", "240", "--listen", "127.0.0.1:0"], "lent to programs");
    usage(&["tcp://a", "tcp://b", "tcp://c"], "");
    usage(&[], "-c");
    let run = Run::of(&["--lang", "ru", "bus", "serial:///dev/nope"]);
    assert!(run.err.contains("Порта /dev/nope нет. ") && !run.err.contains(".."), "{run:?}");
}

/// A device on a serial line that reads and writes bytes directly.
struct Device {
    port: File,
    decoder: Box<Decoder>,
}

impl Device {
    fn new(path: &str) -> Self {
        let port = File::options().read(true).write(true).open(path).unwrap();
        Self { port, decoder: Box::default() }
    }

    /// The frames of one read: receiver, sender, records. A simple program takes only the first.
    fn read(&mut self) -> Vec<(u8, u8, Vec<u8>)> {
        let mut buffer = [0; 1024];
        let len = self.port.read(&mut buffer).unwrap_or(0);
        let mut all = Vec::new();
        for byte in &buffer[..len] {
            if let Some(Frame { dst, src, payload }) = self.decoder.push(*byte) {
                all.push((dst, src, payload.to_vec()));
            }
        }
        all
    }

    fn say(&mut self, dst: u8, src: u8, payload: &[u8]) {
        let mut wire = [0; WIRE_MAX];
        let len = encode(&Frame { dst, src, payload }, &mut wire).unwrap();
        self.port.write_all(&wire[..len]).unwrap();
    }
}

/// Two pseudo-terminals: a monitor that counts, and a console that takes one frame per read.
#[test]
fn between_two_serial_lines_each_request_is_passed_once() {
    let passed = between_two_serial_lines(Flaws::default(), Flaws::default());
    assert_eq!(passed.requests, passed.executed as u64);
    assert!(passed.answered > REQUESTS / 2, "{passed:?}");
    // A grant read together with the previous answer would be lost, and the answer repeated.
    assert!(passed.repeated < u64::from(REQUESTS) / 2, "{passed:?}");
}

/// The same where each port of the controller hears itself and frames are lost, which is when one is repeated.
#[test]
fn between_two_lines_that_lose_and_echo_none_is_passed_twice() {
    // All that the controller sends to the monitors arrives, so that what it sends twice is seen.
    let monitors = Flaws { loss: [0, 100], echo: true };
    let consoles = Flaws { loss: [50, 50], echo: true };
    let passed = between_two_serial_lines(monitors, consoles);
    assert_eq!(passed.requests, passed.executed as u64, "{passed:?}");
    assert!(passed.executed > usize::from(REQUESTS) / 2, "{passed:?}");
    assert!(passed.repeated > 0, "nothing was lost: {passed:?}");
}

/// Requests of the console.
const REQUESTS: u8 = 60;

/// What came of a console's requests.
#[derive(Debug)]
struct Passed {
    answered: u8,
    /// Different requests that the monitor has received; none more than once.
    executed: usize,
    /// What the controller says: requests that it has passed on, and frames that it has repeated.
    requests: u64,
    repeated: u64,
}

fn between_two_serial_lines(of_monitors: Flaws, of_consoles: Flaws) -> Passed {
    /// Grants without an answer after which the console sends the next request.
    const PATIENCE: u32 = 30;
    let ((monitors, far), (consoles, near)) =
        (flawed_cable(of_monitors), flawed_cable(of_consoles));
    let executed: Arc<Mutex<Vec<u8>>> = Arc::default();
    let counted = executed.clone();
    std::thread::spawn(move || {
        let mut monitor = Device::new(&far);
        loop {
            for (_, src, payload) in monitor.read().into_iter().filter(|(dst, ..)| *dst == 5) {
                match payload[..] {
                    [request, to, _, _, number, ..] => {
                        counted.lock().unwrap().push(number);
                        monitor.say(src, 5, &[request, to, 0, 0]);
                    }
                    _ => monitor.say(src, 5, &[]),
                }
            }
        }
    });
    let url = |path: &str, flaws: Flaws| {
        format!("serial://{path}?echo={}", if flaws.echo { "strip" } else { "off" })
    };
    let urls = [url(&monitors, of_monitors), url(&consoles, of_consoles)];
    let mut bus = controller(&[&urls[0], &urls[1], "--addresses", "5,130"]);
    told(&bus, vec![r#""appeared":5}"#]);
    let mut console = Device::new(&near);
    let (mut asked, mut answered, mut waiting) = (0, 0, None);
    while asked < REQUESTS || waiting.is_some() {
        let Some((130, src, payload)) = console.read().into_iter().next() else { continue };
        if src == 5 {
            answered += u8::from(waiting.take().is_some());
        } else if payload.is_empty() {
            console.say(128, 130, &[]);
        } else if asked < REQUESTS && waiting.is_none_or(|grants| grants > PATIENCE) {
            console.say(5, 130, &[0x4D, 0x0D, 0, 2, asked, 0]);
            asked += 1;
            waiting = Some(0);
        } else {
            waiting = waiting.map(|grants| grants + 1).filter(|grants| *grants <= PATIENCE);
            console.say(128, 130, &[]);
        }
    }
    bus.signal("TERM");
    let last = loop {
        let line = bus.line();
        if line.contains("passed_on") {
            break line;
        }
    };
    let last: serde_json::Value = serde_json::from_str(&last).unwrap();
    assert_eq!(bus.code(), Some(0));
    let mut executed = executed.lock().unwrap().clone();
    let count = executed.len();
    executed.sort_unstable();
    executed.dedup();
    assert_eq!(executed.len(), count, "executed twice");
    let number = |name: &str| last[name].as_u64().unwrap();
    let (requests, repeated) = (number("requests"), number("repeated"));
    Passed { answered, executed: count, requests, repeated }
}

/// A controller works on whatever becomes of its output: on a full disk, and beside a reader that
/// pauses.
#[test]
fn a_controller_outlives_its_output() {
    let (unread, full) = std::io::pipe().unwrap();
    // As much as a pipe holds.
    (&full).write_all(&[b' '; 1 << 16]).unwrap();
    let disk = File::options().write(true).open("/dev/full").unwrap();
    for stdout in [Stdio::from(full), Stdio::from(disk)] {
        let sim = Sim::start(&["--addr", "1"]);
        let hub = Hub::new();
        hub.joined_by(&sim);
        let mut command = lafet();
        command.args(["bus", &hub.url(""), "--addresses", "1,130"]).stdout(stdout);
        let mut bus = command.stderr(Stdio::null()).spawn().unwrap();
        let console = hub.url("role=active&src=130&addr=1");
        let stops = || Run::of(&["-c", &console, "--timeout", "2", "stop"]).code == 0;
        assert!((0..30).any(|_| stops()), "no console gets its turn");
        assert!((0..3).all(|_| stops()), "nor later");
        assert_eq!(bus.try_wait().unwrap(), None, "it has ended");
        // It may not end by itself: its last line waits.
        let _ = bus.kill();
        let _ = bus.wait();
    }
    drop(unread);
}
