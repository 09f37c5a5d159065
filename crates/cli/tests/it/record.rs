//! Records a monitor, replays the recording, and taps a program's connection.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::Stdio;
use std::time::Duration;

use lafet_proto::link::{Frame, WIRE_MAX, encode};
use lafet_proto::record::Writer;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use serde_json::{Value, json};

use crate::support::{Run, Running, Sim, lafet};

/// The path of a file used by this test only.
fn file(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    // A file left by an earlier run would be refused.
    let _ = std::fs::remove_file(&path);
    path.display().to_string()
}

#[test]
fn a_monitor_is_recorded_and_replayed() {
    let sim = Sim::start(&[]);
    for name in ["polled.mcap", "polled.pcapng"] {
        let recording = file(name);
        let record = sim.value(&["record", &recording, "--for", "1"]);
        let frames = record["frames"].as_u64().unwrap();
        assert!(frames >= 4, "{record}");
        let replay = Run::of(&["--json", "replay", &recording, "--speed", "0"]);
        assert_eq!(replay.code, 0, "{replay:?}");
        let lines = replay.json();
        assert_eq!(lines.len() as u64, frames);
        let kinds: Vec<&str> =
            lines[..2].iter().map(|line| line["kind"].as_str().unwrap()).collect();
        assert_eq!(kinds, ["request", "answer"]);
        assert!(lines.is_sorted_by_key(|line| line["t_s"].as_f64().unwrap()));
        let decoded = Run::of(&["decode", &recording, "--quiet"]);
        assert!(decoded.err.contains(&format!("frames: {frames}")), "{decoded:?}");
    }
}

/// What is no frame is recorded too, when the time is over and when the link is lost: on a line with the wrong speed there
/// is nothing else.
#[test]
fn noise_is_recorded() {
    for lost in [false, true] {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("tcp://{}", listener.local_addr().unwrap());
        let recording = file(&format!("noise-{lost}.mcap"));
        let end = if lost { "2" } else { "1" };
        let arguments = ["-c", &url, "--json", "record", &recording, "--listen", "--for", end];
        let recorder = lafet().args(arguments).stdout(Stdio::piped()).spawn().unwrap();
        let (mut line, _) = listener.accept().unwrap();
        line.write_all(&[0x55; 100]).unwrap();
        let kept = if lost { None } else { Some(line) };
        let output = recorder.wait_with_output().unwrap();
        drop(kept);
        let record: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((&record["frames"], &record["bytes"]), (&json!(0), &json!(100)), "{lost}");
        let decoded = Run::of(&["--json", "decode", &recording]);
        assert_eq!(decoded.json()[0]["bytes_skipped"], 100, "{decoded:?}");
    }
}

/// A program uses the tap like the monitor itself, and every frame is recorded.
#[test]
fn a_tap_passes_everything_on() {
    let sim = Sim::start(&[]);
    let recording = file("tapped.mcap");
    let mut tap = Running::stdout(lafet().args([
        "-c",
        sim.url(),
        "--json",
        "record",
        &recording,
        "--tap",
        "127.0.0.1:0",
    ]));
    let place: serde_json::Value = serde_json::from_str(&tap.line()).unwrap();
    let through = place["url"].as_str().unwrap();
    let moved = Run::of(&["-c", through, "send", "Deploy Deployer"]);
    assert_eq!(moved.code, 0, "{moved:?}");
    let refused = Run::of(&["-c", through, "send", "Open Valve1"]);
    assert_eq!(refused.code, 1, "{refused:?}");
    tap.signal("INT");
    assert_eq!(tap.code(), Some(0));
    let replay = Run::of(&["replay", &recording, "--speed", "0"]);
    for words in ["Deploy Deployer", "Deployer Deploy → Accepted", "Open Valve1", "→ Denied"] {
        assert!(replay.out.contains(words), "{words}: {}", replay.out);
    }
}

/// An existing file is kept unless it is to be replaced; then nothing of it remains.
#[test]
fn an_existing_file_is_replaced_by_force_alone() {
    let sim = Sim::start(&[]);
    for name in ["kept.mcap", "kept.pcapng"] {
        let recording = file(name);
        let old = vec![b'x'; 1 << 20];
        std::fs::write(&recording, &old).unwrap();
        let record = ["record", &recording, "--for", "0.5"];
        let refused = sim.run(&record);
        assert!(refused.code == 2 && refused.err.contains("--force"), "{refused:?}");
        assert!(std::fs::read(&recording).unwrap() == old, "it was touched");
        let frames = sim.value(&[&record[..], &["--force"]].concat())["frames"].as_u64().unwrap();
        let replay = Run::of(&["--json", "replay", &recording, "--speed", "0"]);
        assert!(replay.code == 0 && frames >= 2, "{replay:?}");
        assert_eq!(replay.json().len() as u64, frames);
        let fresh = file(&format!("of-a-folder-{name}"));
        std::fs::create_dir_all(&fresh).unwrap();
        assert_eq!(sim.run(&["record", &fresh, "--force"]).code, 2, "a folder is no recording");
        std::fs::remove_dir(&fresh).unwrap();
    }
}

/// The number of frames in a recording.
fn frames(recording: &str) -> usize {
    let run = Run::of(&["--json", "replay", recording, "--speed", "0"]);
    run.out.lines().filter(|line| line.contains("\"dst\"")).count()
}

/// Records until there are some frames, and kills the recorder; returns how many there were at least.
fn killed(sim: &Sim, recording: &str) -> usize {
    // One of an earlier run would be counted.
    let _ = std::fs::remove_file(recording);
    let words = ["-c", sim.url(), "record", recording, "--interval", "0.02"];
    let mut recorder = Running::stderr(lafet().args(words));
    let mut seen = 0;
    while seen < 4 {
        seen = frames(recording);
    }
    recorder.signal("KILL");
    recorder.child.wait().unwrap();
    seen
}

/// A recorder that is killed leaves a readable recording.
#[test]
fn a_killed_recorder_leaves_a_recording() {
    let sim = Sim::start(&[]);
    for name in ["killed.mcap", "killed.pcapng"] {
        let recording = file(name);
        let seen = killed(&sim, &recording);
        assert!(frames(&recording) >= seen, "{name}");
    }
}

mod foreign {
    use super::*;

    const READER: &str = "import sys; from mcap.reader import make_reader; \
                          reader = make_reader(open(sys.argv[1], 'rb')); \
                          print(len(list(reader.iter_messages(topics=['/frames']))))";

    /// So can a reader that is not ours.
    #[test]
    #[ignore = "needs Python with mcap: cargo xtask plugs"]
    fn a_reader_of_others_opens_what_a_killed_recorder_left() {
        let sim = Sim::start(&[]);
        let recording = file("killed-foreign.mcap");
        let seen = killed(&sim, &recording);
        let mut python = std::process::Command::new("python3");
        let read = Run::of_command(python.args(["-c", READER, &recording]));
        let count = read.out.trim().parse::<usize>();
        assert!(count.is_ok_and(|count| count >= seen), "{seen} frames: {read:?}");
    }
}

#[test]
fn a_replay_is_served() {
    let sim = Sim::start(&[]);
    let recording = file("served.mcap");
    sim.done(&["record", &recording, "--for", "0.5"]);
    let server = Running::stdout(lafet().args([
        "--json",
        "replay",
        &recording,
        "--speed",
        "0",
        "--serve",
        "127.0.0.1:0",
    ]));
    let place: serde_json::Value = serde_json::from_str(&server.line()).unwrap();
    let address = place["url"].as_str().unwrap().strip_prefix("tcp://").unwrap().to_owned();
    let mut stream = std::net::TcpStream::connect(address).unwrap();
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut stream, &mut bytes).unwrap();
    let mut decoder: lafet_proto::link::Decoder = lafet_proto::link::Decoder::new();
    let frames = bytes.iter().filter(|byte| decoder.push(**byte).is_some()).count();
    assert!(frames >= 2, "{frames} frames in {} bytes", bytes.len());
}

#[test]
fn what_is_wrong_is_reported() {
    let wrong = Run::of(&["-c", "sim:", "record", "x.txt"]);
    assert!(wrong.code == 2 && wrong.err.contains(".mcap"), "{wrong:?}");
    let none = Run::of(&["replay", "/nowhere/x.mcap"]);
    assert!(none.code == 2 && none.err.contains("/nowhere/x.mcap"), "{none:?}");
    let text = Run::of(&["--lang", "ru", "replay", "Cargo.toml"]);
    assert!(text.code == 2 && text.err.contains("MCAP"), "{text:?}");
}

#[test]
fn the_dissector_is_installed_for_the_user() {
    let home = file("home");
    let output = lafet().args(["dissector", "--install"]).env("HOME", &home).output().unwrap();
    assert!(output.status.success());
    let path = PathBuf::from(home).join(".local/lib/wireshark/plugins/lafet.lua");
    assert!(std::fs::read_to_string(path).unwrap().contains("Proto(\"lafet\""));
}

/// Bytes of a pcapng file behind its last whole block.
fn behind_the_last_block(bytes: &[u8]) -> usize {
    let mut rest = bytes;
    while let Some(len) = rest.get(4..8) {
        let len = u32::from_ne_bytes(len.try_into().unwrap()) as usize;
        let Some(next) = rest.get(len.max(12)..) else { break };
        rest = next;
    }
    rest.len()
}

/// What the disk does not take whole is not in the file, and the user is informed.
#[cfg(unix)]
#[test]
fn on_a_full_disk_a_recording_ends_with_a_whole_record() {
    let sim = Sim::start(&[]);
    for name in ["full.mcap", "full.pcapng"] {
        let recording = file(name);
        let lafet = lafet();
        let mut limited = std::process::Command::new("sh");
        // Blocks of 512 or 1024 bytes, by the shell.
        limited.args(["-c", "trap '' XFSZ; ulimit -f 240; exec \"$@\"", "sh"]);
        limited.arg(lafet.get_program()).args(["--lang", "en", "-c", sim.url()]);
        let run = Run::of_command(limited.args([
            "record",
            &recording,
            "--interval",
            "0.02",
            "--for",
            "60",
        ]));
        assert!(run.code != 0 && run.err.contains(name), "{run:?}");
        let bytes = std::fs::read(&recording).unwrap();
        match name {
            "full.mcap" => assert!(bytes.ends_with(b"\x89MCAP0\r\n"), "{} bytes", bytes.len()),
            _ => assert_eq!(behind_the_last_block(&bytes), 0, "{} bytes", bytes.len()),
        }
        let replay = Run::of(&["--json", "replay", &recording, "--speed", "0"]);
        assert!(replay.code == 0 && replay.json().len() >= 20, "{replay:?}");
    }
}

/// A tap, and the place where it listens.
fn tapped(url: &str, name: &str) -> (Running, String) {
    let recording = file(name);
    let arguments = ["-c", url, "--json", "record", &recording, "--tap", "127.0.0.1:0"];
    let tap = Running::stdout(lafet().args(arguments));
    let place: serde_json::Value = serde_json::from_str(&tap.line()).unwrap();
    let place = place["url"].as_str().unwrap().strip_prefix("tcp://").unwrap().to_owned();
    (tap, place)
}

fn frame(request: &Request<'_>) -> Vec<u8> {
    let mut payload = [0; 64];
    let mut writer = Writer::new(&mut payload);
    request.encode(&mut writer).unwrap();
    let mut wire = [0; WIRE_MAX];
    let frame = Frame { dst: 1, src: 129, payload: writer.written() };
    let len = encode(&frame, &mut wire).unwrap();
    wire[..len].to_vec()
}

/// Whether this end was disconnected; waits for it.
fn is_disconnected(stream: &mut TcpStream) -> bool {
    let mut rest = Vec::new();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    match stream.read_to_end(&mut rest) {
        Ok(_) => rest.is_empty(),
        Err(error) => error.kind() == std::io::ErrorKind::ConnectionReset,
    }
}

/// What a program sends that has to wait would reach the monitor minutes later: it is disconnected.
#[test]
fn a_tap_keeps_no_request_of_a_further_program() {
    let sim = Sim::start(&["--profile", "remote"]);
    let (_tap, place) = tapped(sim.url(), "further.mcap");
    let mut first = TcpStream::connect(&place).unwrap();
    let mut answer = [0; 64];
    let mut read = |first: &mut TcpStream| {
        first.write_all(&frame(&Request::new(SubsystemId::VALVE1, Body::GetStatus))).unwrap();
        assert!(first.read(&mut answer).unwrap() > 0);
    };
    read(&mut first);
    let mut further = TcpStream::connect(&place).unwrap();
    let moves = Request::new(SubsystemId::HORIZONTAL, Body::Move { destination: 3000 });
    // It may have been disconnected already.
    let _ = further.write_all(&frame(&moves));
    let mut rest = [0; 64];
    further.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    match further.read(&mut rest) {
        Ok(count) => assert_eq!(count, 0, "it is not served"),
        Err(error) => assert_eq!(error.kind(), std::io::ErrorKind::ConnectionReset),
    }
    drop(further);
    read(&mut first);
    drop(first);
    let status = Run::of(&["-c", &format!("tcp://{place}"), "--json", "status", "horizontal"]);
    assert_eq!(status.code, 0, "{status:?}");
    let flags = sim.flags("horizontal");
    assert!(!flags.contains(&"Move".to_owned()), "{flags:?}");
}

/// Nor does it keep what a program sends while the link is lost.
#[test]
fn a_tap_keeps_no_request_for_the_next_link() {
    let monitor = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("tcp://{}", monitor.local_addr().unwrap());
    let (_tap, place) = tapped(&url, "links.mcap");
    let (mut link, _) = monitor.accept().unwrap();
    let mut program = TcpStream::connect(&place).unwrap();
    let moves = frame(&Request::new(SubsystemId::HORIZONTAL, Body::Move { destination: 3000 }));
    program.write_all(&moves).unwrap();
    let mut passed = vec![0; moves.len()];
    link.read_exact(&mut passed).unwrap();
    assert_eq!(passed, moves);
    drop(link);
    let late = program.write_all(&moves);
    let (mut link, _) = monitor.accept().unwrap();
    link.set_read_timeout(Some(Duration::from_millis(500))).unwrap();
    let status = frame(&Request::new(SubsystemId::VALVE1, Body::GetStatus));
    let mut passed = vec![0; status.len()];
    let mut programs = Vec::new();
    while link.read_exact(&mut passed).is_err() {
        assert!(programs.len() < 100, "no program is served");
        let mut next = TcpStream::connect(&place).unwrap();
        // It may come before the tap has seen its new link.
        let _ = next.write_all(&status);
        programs.push(next);
    }
    assert_eq!(passed, status, "{late:?}");
    assert!(is_disconnected(&mut program), "it learns that the link was lost");
}

/// Nothing in bare records shows where a request ends, so each is passed on as it comes.
#[test]
fn a_tap_passes_bare_records_on_at_once() {
    let sim = Sim::listening(&["tcp://127.0.0.1:0?framing=records"], &["--profile", "remote"]);
    let (mut tap, place) = tapped(sim.url(), "records.mcap");
    let through = format!("tcp://{place}?framing=records");
    let run = Run::of(&["-c", &through, "--timeout", "20", "stop"]);
    assert_eq!(run.code, 0, "{run:?}");
    tap.signal("INT");
    assert_eq!(tap.code(), Some(0));
    let end: serde_json::Value = serde_json::from_str(&tap.line()).unwrap();
    assert!(end["frames"].as_u64().unwrap() >= 2, "{end}");
}

/// A tap goes on without its recording: the program behind it still reaches the monitor.
#[cfg(unix)]
#[test]
fn a_tap_outlives_a_full_disk() {
    let sim = Sim::start(&["--profile", "remote"]);
    let recording = file("tap-full.mcap");
    let lafet = lafet();
    let mut limited = std::process::Command::new("sh");
    limited.args(["-c", "trap '' XFSZ; ulimit -f 96; exec \"$@\"", "sh"]);
    limited.arg(lafet.get_program()).args(["-c", sim.url(), "--json", "record", &recording]);
    let mut tap = Running::stdout(limited.args(["--tap", "127.0.0.1:0"]));
    let place: serde_json::Value = serde_json::from_str(&tap.line()).unwrap();
    let through = place["url"].as_str().unwrap();
    let watch = ["-c", through, "--json", "watch", "All", "--count", "400", "--interval", "0.02"];
    assert_eq!(Run::of(&watch).json().len(), 400);
    assert_eq!(Run::of(&["-c", through, "stop"]).code, 0);
    tap.signal("INT");
    assert_eq!(tap.code(), Some(2), "that nothing more was recorded is an error");
}
