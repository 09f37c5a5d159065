//! The dissector in tshark, against the golden vectors: Wireshark shows what they mean.
//!
//! These tests need tshark: `cargo xtask dissector` installs it where possible, and runs them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lafet_capture::dissector::{Language, lua};
use lafet_capture::{Captured, Direction, Format, Recorder};
use lafet_proto::link::{Check, Frame, WIRE_MAX, encode, encode_with};
use lafet_proto::{RequestId, SubsystemId};
use serde_json::Value;

fn temporary(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn vectors(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/vectors").join(name);
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn unhex(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

fn wire(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut out = [0; WIRE_MAX];
    let len = encode(&Frame { dst, src, payload }, &mut out).unwrap();
    out[..len].to_vec()
}

/// Runs tshark with the dissector on a file.
fn tshark(test: &str, language: Language, capture: &Path, arguments: &[&str]) -> String {
    let script = temporary(&format!("{test}.lua"));
    fs::write(&script, lua(language)).unwrap();
    let output = Command::new("tshark")
        .arg("-X")
        .arg(format!("lua_script:{}", script.display()))
        .arg("-r")
        .arg(capture)
        .args(arguments)
        .output()
        .expect("tshark is installed: cargo xtask dissector");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !errors.contains("Lua"), "{errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// A recording of a line with these pieces.
fn line(test: &str, pieces: &[Vec<u8>]) -> PathBuf {
    let path = temporary(&format!("{test}.pcapng"));
    let mut recorder = Recorder::new(Format::Pcapng, fs::File::create(&path).unwrap()).unwrap();
    for (i, bytes) in pieces.iter().enumerate() {
        let at_ns = 1_790_000_000_000_000_000 + 1_000_000 * i as u64;
        let captured = Captured { at_ns, direction: Direction::Heard, bytes: bytes.clone() };
        recorder.write(&captured).unwrap();
    }
    recorder.finish().unwrap();
    path
}

/// The same bytes as payload of TCP segments or UDP datagrams.
fn network(test: &str, pieces: &[Vec<u8>], port: [&str; 2]) -> PathBuf {
    let (text, path) = (temporary(&format!("{test}.txt")), temporary(&format!("{test}.pcapng")));
    let hex = |piece: &Vec<u8>| {
        let bytes: Vec<String> = piece.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("000000 {}\n\n", bytes.join(" "))
    };
    fs::write(&text, pieces.iter().map(hex).collect::<String>()).unwrap();
    let done = Command::new("text2pcap").arg("-q").args(port).args([&text, &path]).status();
    assert!(done.expect("text2pcap comes with tshark").success());
    path
}

/// Columns of fields, one line per packet.
fn fields(test: &str, capture: &Path, names: &[&str]) -> Vec<Vec<String>> {
    let mut arguments = vec!["-T", "fields"];
    arguments.extend(names.iter().flat_map(|name| ["-e", *name]));
    let printed = tshark(test, Language::En, capture, &arguments);
    printed.lines().map(|line| line.split('\t').map(String::from).collect()).collect()
}

#[test]
#[ignore = "needs tshark: cargo xtask dissector"]
fn every_vector_is_named_as_it_is() {
    let mut pieces = Vec::new();
    let mut expected = Vec::new();
    for (file, dst, src) in [("requests", 1, 129), ("answers", 129, 1)] {
        for vector in vectors(&format!("{file}.json"))[file].as_array().unwrap() {
            let (Some(bytes), Some(text)) = (vector["bytes"].as_str(), vector["text"].as_str())
            else {
                continue;
            };
            pieces.push(wire(dst, src, &unhex(bytes)));
            expected.push((bytes.to_owned(), text.to_owned()));
        }
    }
    assert!(pieces.len() > 100);
    let capture = line("vectors", &pieces);
    let info = fields("vectors", &capture, &["_ws.col.Info", "lafet.size", "_ws.expert.message"]);
    assert_eq!(info.len(), pieces.len());
    for (columns, (bytes, text)) in info.iter().zip(&expected) {
        let data = unhex(bytes).len() - 4;
        assert_eq!(columns[1], data.to_string(), "{text}");
        // tshark names the subsystem that answers; the vectors name the addressee first.
        let request = text.split(" → ").next().unwrap().split_whitespace().nth(1).unwrap();
        assert!(columns[0].contains(request), "{} for {text}", columns[0]);
        if let Some(status) = text.split(" → ").nth(1) {
            let status = status.split([' ', ':']).next().unwrap();
            assert!(columns[0].ends_with(status), "{} for {text}", columns[0]);
        }
    }
}

#[test]
#[ignore = "needs tshark: cargo xtask dissector"]
fn fields_have_their_values() {
    let status = [0xD4, 0x0D, 0, 8, 1, 0, 2, 0, 0x9C, 0xFF, 0xC0, 0xDB];
    let quench = [RequestId::START_QUENCH.0, SubsystemId::CONTROL.0, 0, 12];
    let sector = [0x58, 2, 0x9C, 0xFF, 60, 0, 240, 0, 60, 0, 1, 25];
    let pieces = [
        wire(129, 1, &status),
        wire(1, 129, &[&quench[..], &sector].concat()),
        wire(1, 129, &[0x4D, 0x0D, 0, 1, 0]),
        wire(1, 129, &[]),
    ];
    let capture = line("fields", &pieces);
    let names = [
        "lafet.dst",
        "lafet.src",
        "lafet.kind",
        "lafet.drive_status.position",
        "lafet.drive_status.current",
        "lafet.drive_status.speed",
        "lafet.drive_flags.config_fault",
        "lafet.drive_flags.disabled",
        "lafet.quench_full.centre_v",
        "lafet.quench_full.distance",
        "lafet.data",
    ];
    let found = fields("fields", &capture, &names);
    let drive = ["129", "1", "2", "-100", "192", "219", "1", "0", "", "", ""];
    assert_eq!(found[0], drive);
    assert_eq!(found[1][..3], ["1", "129", "1"]);
    assert_eq!(found[1][8..10], ["-100", "25"]);
    assert_eq!(found[2][10], "00", "data of a wrong size are shown raw");
    assert_eq!(found[3][..3], ["1", "129", "0"]);
}

#[test]
#[ignore = "needs tshark: cargo xtask dissector"]
fn frames_with_a_crc32c() {
    let long = |payload: &[u8]| {
        let mut out = [0; WIRE_MAX];
        let frame = Frame { dst: 1, src: 129, payload };
        let len = encode_with(Check::Crc32c, &frame, &mut out).unwrap();
        out[..len].to_vec()
    };
    let plain = long(&[0x46, 0x5D, 0, 0]);
    let mut bad = plain.clone();
    bad[6] ^= 1;
    let pieces = [plain, long(&[0x4D, 0x0D, 0, 2, 0xC0, 0xDB]), bad];
    let names = ["lafet.request", "lafet.move.destination", "lafet.crc32c", "lafet.crc.bad"];
    let found = fields("crc32c", &line("crc32c", &pieces), &names);
    assert_eq!((&found[0][0][..], &found[1][0][..], &found[1][1][..]), ("0x46", "0x4d", "-9280"));
    let bad: Vec<bool> = found.iter().map(|columns| !columns[3].is_empty()).collect();
    assert_eq!(bad, [false, false, true]);
    assert!(found.iter().all(|columns| columns[2].len() == 10), "{found:?}");
}

#[test]
#[ignore = "needs tshark: cargo xtask dissector"]
fn errors_are_shown() {
    let good = wire(1, 129, &[0x46, 0x5D, 0, 0]);
    let mut bad = good.clone();
    bad[4] ^= 1;
    let cut = wire(1, 129, &[0x4D, 0x0D, 0, 2, 0]);
    let noisy = [&[1, 2, 3][..], &good].concat();
    let refused = wire(129, 1, &[0x4D, 0xA2, 3, 0]);
    let capture = line("errors", &[good, bad, cut, noisy, refused]);
    let found = fields(
        "errors",
        &capture,
        &["lafet.crc.bad", "lafet.record.cut", "lafet.noise", "lafet.refused"],
    );
    let set: Vec<Vec<bool>> =
        found.iter().map(|columns| columns.iter().map(|c| !c.is_empty()).collect()).collect();
    assert_eq!(set[0], [false; 4]);
    assert_eq!(set[1], [true, false, false, false]);
    assert_eq!(set[2], [false, true, false, false]);
    assert_eq!(set[3], [false, false, true, false]);
    assert_eq!(set[4], [false, false, false, true]);
}

/// A TCP stream is split anywhere; a datagram is one frame.
#[test]
#[ignore = "needs tshark: cargo xtask dissector"]
fn network_captures() {
    let frames = [
        wire(1, 129, &[0x46, 0x5D, 0, 0]),
        wire(1, 129, &[0xD4, 0x0D, 0, 0]),
        wire(1, 129, &[0x4D, 0x0D, 0, 2, 0xC0, 0xDB]),
    ];
    let stream = frames.concat();
    let segments: Vec<Vec<u8>> = stream.chunks(7).map(<[u8]>::to_vec).collect();
    let capture = network("tcp", &segments, ["-T", "50001,10485"]);
    let named = |columns: Vec<Vec<String>>| {
        let shown = columns.concat().into_iter().filter(|column| !column.is_empty());
        shown.collect::<Vec<_>>().join(",")
    };
    assert_eq!(named(fields("tcp", &capture, &["lafet.request"])), "0x46,0xd4,0x4d");
    let capture = network("udp", &frames, ["-u", "50001,10486"]);
    assert_eq!(named(fields("udp", &capture, &["lafet.request"])), "0x46,0xd4,0x4d");
}

#[test]
#[ignore = "needs tshark: cargo xtask dissector"]
fn in_russian() {
    let capture = line("russian", &[wire(1, 129, &[0xD4, 0x0D, 0, 0])]);
    let shown = tshark("russian", Language::Ru, &capture, &["-V"]);
    assert!(shown.contains("Получатель") && shown.contains("Подсистема"), "{shown}");
}
