//! `lafet sim` as a server: several clients, faulty ones, other media, signals.

use std::io::{Read, Write};
use std::net::{TcpStream, UdpSocket};
use std::time::Duration;

use crate::support::{Run, Running, Sim, lafet};
use lafet_proto::link::{self, Decoder, Frame};

const PATIENCE: Option<Duration> = Some(Duration::from_secs(30));
const STATUS_VALVE1: &[u8] = &[0xD4, 0xA6, 0, 0];

fn frame(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut wire = vec![0; link::wire_max(payload.len())];
    let len = link::encode(&Frame { dst, src, payload }, &mut wire).expect("it fits");
    wire.truncate(len);
    wire
}

fn connect(sim: &Sim) -> TcpStream {
    let stream = TcpStream::connect(sim.place()).expect("it listens");
    stream.set_read_timeout(PATIENCE).unwrap();
    stream
}

/// Waits for a frame; returns receiver, sender, payload.
fn receive(stream: &mut impl Read) -> (u8, u8, Vec<u8>) {
    let mut decoder: Decoder = Decoder::new();
    loop {
        let mut byte = [0];
        stream.read_exact(&mut byte).expect("an answer");
        if let Some(frame) = decoder.push(byte[0]) {
            return (frame.dst, frame.src, frame.payload.to_vec());
        }
    }
}

#[test]
fn each_client_gets_its_own_answers() {
    let sim = Sim::start(&[]);
    let (mut first, mut second) = (connect(&sim), connect(&sim));
    first.write_all(&frame(1, 130, STATUS_VALVE1)).unwrap();
    second.write_all(&frame(1, 200, &[0x46, 0x5D, 0, 0])).unwrap();
    second.write_all(&frame(1, 200, &[])).unwrap();
    let (dst, src, payload) = receive(&mut first);
    assert_eq!((dst, src, &payload[..2]), (130, 1, &[0xD4, 0xA6][..]));
    let (dst, _, payload) = receive(&mut second);
    assert_eq!((dst, payload[0]), (200, 0x46));
    assert_eq!(receive(&mut second), (200, 1, vec![]));
    assert_eq!(sim.run(&["status"]).code, 0);
}

#[test]
fn garbage_is_not_answered_and_disturbs_no_other_client() {
    let sim = Sim::start(&[]);
    let mut garbage = connect(&sim);
    let noise: Vec<u8> =
        (0..100_000_u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    garbage.write_all(&noise).unwrap();
    // Half a frame, a frame for another address, one with a wrong CRC.
    garbage.write_all(&frame(2, 129, STATUS_VALVE1)).unwrap();
    let mut wrong = frame(1, 129, STATUS_VALVE1);
    wrong[4] ^= 4;
    garbage.write_all(&wrong).unwrap();
    garbage.write_all(&[0xFF, 0xC0, 1, 129]).unwrap();
    let mut good = connect(&sim);
    good.write_all(&frame(1, 129, STATUS_VALVE1)).unwrap();
    assert_eq!(receive(&mut good).0, 129);
    // The first bytes that the other client receives answer its first valid frame.
    garbage.write_all(&frame(1, 140, &[])).unwrap();
    assert_eq!(receive(&mut garbage), (140, 1, vec![]));
}

#[test]
fn silent_and_greedy_connections_hold_up_no_other_client() {
    let sim = Sim::start(&[]);
    // More than the simulator keeps: they send nothing, or send for ever and never read.
    let silent: Vec<TcpStream> = (0..80).map(|_| connect(&sim)).collect();
    let mut greedy = connect(&sim);
    greedy.set_write_timeout(Some(Duration::from_millis(200))).unwrap();
    let many = frame(1, 129, &[0xD4, 0x5D, 0, 0]).repeat(1000);
    while greedy.write_all(&many).is_ok() {}
    let mut good = connect(&sim);
    good.write_all(&frame(1, 129, STATUS_VALVE1)).unwrap();
    assert_eq!(receive(&mut good).0, 129);
    assert_eq!(sim.run(&["status"]).code, 0);
    drop(silent);
}

#[test]
fn ends_with_code_0_at_sigterm_and_sigint() {
    for signal in ["TERM", "INT"] {
        let mut sim = Sim::start(&[]);
        let mut client = connect(&sim);
        sim.running.signal(signal);
        assert_eq!(sim.running.code(), Some(0), "{signal}");
        assert_eq!(client.read(&mut [0]).unwrap_or(0), 0);
    }
}

#[test]
fn datagrams_are_answered_to_their_sender() {
    let sim = Sim::listening(&["udp://127.0.0.1:0", "radio+udp://127.0.0.1:0"], &[]);
    let ask = |url: &str| {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.set_read_timeout(PATIENCE).unwrap();
        socket.connect(url.strip_prefix("udp://").unwrap()).unwrap();
        socket.send(b"no frame").unwrap();
        socket.send(&frame(1, 150, STATUS_VALVE1)).unwrap();
        let mut answer = [0; 1100];
        let len = socket.recv(&mut answer).expect("an answer");
        receive(&mut &answer[..len])
    };
    for url in &sim.urls {
        assert_eq!(ask(url).0, 150, "{url}");
        assert_eq!(Run::of(&["-c", url, "status"]).code, 0, "{url}");
    }
}

/// §C/3
#[test]
fn bare_records_over_tcp() {
    let sim = Sim::listening(&["tcp://127.0.0.1:0?framing=records"], &[]);
    let run = sim.done(&["send", "GetStatus Valve1"]);
    assert_eq!(run.out, "Valve1 GetStatus → Ok: [Closed]\n");
    let run = sim.done(&["send", "GetParam Vertical Speed", "Deploy"]);
    assert!(run.out.ends_with("Deployer Deploy → Accepted\n"), "{run:?}");
    let place = sim.url().strip_prefix("tcp://").and_then(|url| url.split('?').next());
    let mut stream = TcpStream::connect(place.unwrap()).unwrap();
    stream.set_read_timeout(PATIENCE).unwrap();
    // However the bytes are split.
    for byte in STATUS_VALVE1 {
        stream.write_all(&[*byte]).unwrap();
    }
    let mut answer = [0; 8];
    stream.read_exact(&mut answer).expect("an answer");
    assert_eq!(answer[..4], [0xD4, 0xA6, 0, 4]);
}

/// §3.3.9: a request over the radio counts as control of the radio interface alone.
#[test]
fn radio_is_an_interface_of_its_own() {
    let sim = Sim::listening(&["tcp://127.0.0.1:0", "radio+tcp://127.0.0.1:0"], &[]);
    let run = Run::of(&["-c", &sim.urls[1], "send", "Stop All", "GetStatus All"]);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.out.contains("Radio GetStatus → Ok: []"), "{run:?}");
    assert!(run.out.contains("ExternalConn GetStatus → Ok: [ConnLost]"), "{run:?}");
}

#[cfg(target_os = "linux")]
/// A second program on a port is refused, and the first one is named.
#[cfg(target_os = "linux")]
#[test]
fn a_port_in_use_names_who_has_it() {
    let sim = Sim::listening(&["pty"], &[]);
    let mut watching = lafet();
    watching.args(["-c", sim.url(), "--json", "watch"]);
    let watching = Running::stdout(&mut watching);
    watching.line();
    let run = sim.run(&["status"]);
    let holder = format!("is in use by lafet ({})", watching.child.id());
    assert!(run.code == 3 && run.err.contains(&holder), "{run:?}");
    assert!(run.err.contains("shared=1"), "{run:?}");
}

#[test]
fn serial_ports_are_listed() {
    let run = Run::of(&["ports"]);
    assert!(run.code == 0 && !run.out.is_empty(), "{run:?}");
    let run = Run::of(&["--json", "ports"]);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.json().iter().all(|port| port["url"].as_str().unwrap().starts_with("serial:///")));
}

#[test]
fn a_pseudo_terminal_is_a_serial_line() {
    let sim = Sim::listening(&["pty"], &[]);
    assert!(sim.url().starts_with("serial:///dev/"), "{}", sim.url());
    // Clients come and go, one after another.
    for _ in 0..3 {
        let run = sim.done(&["send", "GetStatus Valve1"]);
        assert_eq!(run.out, "Valve1 GetStatus → Ok: [Closed]\n");
    }
    // A program without serial settings reads and writes the bytes unchanged.
    let mut line = std::fs::OpenOptions::new().read(true).write(true).open(sim.port()).unwrap();
    line.write_all(b"\x03\x04\x11\x13\n").unwrap();
    line.write_all(&frame(1, 13, &[])).unwrap();
    assert_eq!(receive(&mut line), (13, 1, vec![]));
}

#[test]
fn another_address() {
    let sim = Sim::start(&["--addr", "42"]);
    let at = |address: u8| format!("{}?addr={address}", sim.url());
    assert_eq!(Run::of(&["-c", &at(42), "status"]).code, 0);
    assert_eq!(Run::of(&["-c", &at(1), "--timeout", "0.05", "status"]).code, 3);
}

#[test]
fn the_memory_outlives_the_simulator() {
    let file = std::env::temp_dir().join(format!("lafet-flash-{}", std::process::id()));
    let path = file.to_str().unwrap();
    let mut sim = Sim::start(&["--flash", path]);
    sim.done(&["param", "set", "vertical", "Speed", "9"]);
    sim.done(&["lockout", "on"]);
    sim.running.signal("TERM");
    assert_eq!(sim.running.code(), Some(0));
    let again = Sim::start(&["--flash", path]);
    assert_eq!(again.value(&["param", "get", "vertical", "Speed"])["values"][0], 9);
    assert!(again.flags("general").contains(&"LockedOut".to_owned()));
    drop(again);
    // A damaged file is reported, and left unchanged.
    let mut image = std::fs::read(&file).unwrap();
    image[4000] ^= 1;
    std::fs::write(&file, &image).unwrap();
    let run = Run::of(&["sim", "--listen", "tcp://127.0.0.1:0", "--flash", path]);
    assert_eq!(run.code, 2, "{run:?}");
    assert!(run.err.contains(path) && run.err.contains("Remove it"), "{run:?}");
    assert_eq!(std::fs::read(&file).unwrap(), image);
    std::fs::remove_file(&file).unwrap();
}

/// Ctrl-C while a drive moves: Stop is sent, and the drive is at rest when the command ends.
#[test]
fn ctrl_c_stops_the_drive() {
    let sim = Sim::start(&[]);
    let fast = Sim::start(&["--speed", "50"]);
    fast.done(&["deploy"]);
    let mut deploying = Running::stderr(lafet().args(["-c", sim.url(), "deploy"]));
    assert!(deploying.line().contains("Deploying"));
    deploying.signal("INT");
    assert_eq!(deploying.code(), Some(130));
    let flags = sim.flags("deployer");
    assert!(!flags.iter().any(|flag| flag == "Move" || flag == "Deploying"), "{flags:?}");
    assert!(!flags.contains(&"Deployed".to_owned()), "{flags:?}");

    // Another program may already have started something else: then everything stops.
    let slow = fast.value(&["param", "set", "horizontal", "Speed", "1"]);
    assert_eq!(slow["saved"], "stored");
    let mut moving =
        Running::stderr(lafet().args(["-c", fast.url(), "move", "horizontal", "170deg"]));
    assert!(moving.line().contains("Horizontal"));
    moving.signal("INT");
    assert_eq!(moving.code(), Some(130));
    let status = fast.value(&["status", "horizontal"]);
    let position = status["Horizontal"]["position_arcmin"].as_i64().unwrap();
    assert!(position < 10_000, "{status}");
    assert_eq!(status["Horizontal"]["flags"].as_array().unwrap().len(), 0, "{status}");
}

#[test]
fn modems_carry_frames_of_every_medium_or_lose_them() {
    let places = ["radio+tcp://127.0.0.1:0", "radio+udp://127.0.0.1:0", "tcp://127.0.0.1:0"];
    let sim = Sim::listening(&places, &["--radio", "rate=115200,latency=5"]);
    for url in &sim.urls {
        assert_eq!(Run::of(&["-c", url, "status", "Vertical"]).code, 0, "{url}");
    }
    // All on the channel receive all.
    let (mut first, mut second) = (connect(&sim), connect(&sim));
    second.write_all(&frame(7, 133, &[])).unwrap();
    assert_eq!(receive(&mut first), (7, 133, vec![]));
    first.write_all(&frame(1, 130, STATUS_VALVE1)).unwrap();
    assert_eq!(receive(&mut second).1, 130, "the request");
    assert_eq!(receive(&mut second).1, 1, "and its answer");
    // Nothing arrives by radio; the wired interface still works.
    let sim = Sim::listening(&places, &["--radio", "loss=1"]);
    let status = |url: &str| Run::of(&["-c", url, "--timeout", "0.1", "status", "Vertical"]).code;
    assert_eq!([status(&sim.urls[0]), status(&sim.urls[1]), status(&sim.urls[2])], [3, 3, 0]);
}

#[test]
fn a_site_by_radio() {
    let mut command = lafet();
    command.args(["sim", "--site", "tank-farm", "--listen", "radio+tcp://127.0.0.1:0"]);
    let running = Running::stdout(command.args(["--radio", "rate=115200,latency=5"]));
    let urls: Vec<String> = (0..2)
        .map(|_| running.line().split(' ').next_back().unwrap_or_default().to_owned())
        .collect();
    for url in urls {
        let run = Run::of(&["-c", &url, "status", "Vertical"]);
        assert_eq!(run.code, 0, "{url}: {run:?}");
    }
}

/// A client that shares no code with ours talks to the simulated monitor.
#[test]
fn an_independent_client_is_answered_as_the_page_says() {
    let sim = Sim::start(&[]);
    let (host, port) = sim.place().split_once(':').unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../conformance/interop/link.py");
    let output = std::process::Command::new("python3").args([script, "talk", host, port]).output();
    let output = output.expect("python3 is needed; `cargo xtask test` installs it");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("12 frames"));
}
