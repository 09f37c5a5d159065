//! `lafet decode`: captures as text.

use crate::support::Run;
use lafet_proto::link::{self, Frame};
use serde_json::json;

fn frame(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut wire = vec![0; link::wire_max(payload.len())];
    let len = link::encode(&Frame { dst, src, payload }, &mut wire).expect("it fits");
    wire.truncate(len);
    wire
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x} ")).collect()
}

/// A request and its answer, with noise before, between and inside.
fn capture() -> Vec<u8> {
    let mut bytes = vec![0x55; 7];
    bytes.extend(frame(1, 129, &[0x4D, 0x0D, 0, 2, 0xB0, 0x04]));
    let mut broken = frame(1, 129, &[0x46, 0x5D, 0, 0]);
    broken[5] ^= 1;
    bytes.extend(broken);
    bytes.extend(frame(129, 1, &[0x4D, 0xA2, 3, 0]));
    bytes.extend(frame(1, 129, &[]));
    bytes
}

#[test]
fn hexadecimal_from_the_command_line() {
    let run = Run::of(&["decode", &hex(&frame(1, 129, &[0x9D, 0xC8, 0, 2, 0xFE, 0x23]))]);
    assert_eq!(run.code, 0, "{run:?}");
    assert_eq!(run.out, "129 → 1    GetParam Detector Hotbeds\n");
    assert!(run.err.contains("frames: 1"), "{run:?}");
    // The example of `lafet decode --help`.
    let help = Run::of(&["decode", "--help"]).out;
    let example = help.split('"').nth(1).expect("an example in quotes");
    assert_eq!(Run::of(&["decode", example]).out, run.out);
    let bare = Run::of(&["decode", "9dc80002fe23"]);
    assert_eq!(bare.out, "GetParam Detector Hotbeds\n");
    let answer = Run::of(&["decode", "4d", "a2", "03", "00"]);
    assert_eq!(answer.out, "Deployer Move → Denied\n");
}

#[test]
fn a_capture_with_noise() {
    let file = std::env::temp_dir().join(format!("lafet-decode-{}.bin", std::process::id()));
    std::fs::write(&file, capture()).unwrap();
    let run = Run::of(&["decode", file.to_str().unwrap()]);
    std::fs::remove_file(&file).unwrap();
    assert_eq!(run.code, 0, "{run:?}");
    let lines: Vec<&str> = run.out.lines().filter(|line| !line.starts_with('#')).collect();
    let expected = [
        "129 → 1    Move Vertical 1200",
        "  1 → 129  Vertical Move → Denied (Deployer)",
        "129 → 1    (probe)",
    ];
    assert_eq!(lines, expected);
    assert!(run.out.contains("CRC errors: 1"), "{run:?}");
    assert!(run.err.contains("frames: 3, records: 2"), "{run:?}");
}

#[test]
fn standard_input_raw_or_hexadecimal() {
    let raw = Run::fed(&["decode", "--json"], &capture());
    let text = Run::fed(&["decode", "--json"], hex(&capture()).as_bytes());
    assert_eq!(raw.out, text.out);
    let lines = raw.json();
    let summary = &lines.last().unwrap()["summary"];
    assert_eq!((&summary["frames"], &summary["crc_errors"]), (&json!(3), &json!(1)));
    let answer = lines.iter().find(|line| line["kind"] == "answer").unwrap();
    assert_eq!(answer["records"][0]["status"], "Denied");
    let quiet = Run::fed(&["decode", "-q"], &capture());
    assert!(quiet.out.is_empty() && quiet.err.contains("records: 2"), "{quiet:?}");
}

/// More frames than any buffer holds: all are decoded.
#[test]
fn a_long_capture() {
    let one = frame(1, 129, &[0x4D, 0x0D, 0, 2, 0xC0, 0xDB]);
    let bytes: Vec<u8> = one.iter().copied().cycle().take(20_000 * one.len()).collect();
    let run = Run::fed(&["decode"], &bytes);
    assert_eq!(run.out.lines().count(), 20_000);
    assert!(run.out.lines().all(|line| line == "129 → 1    Move Vertical -9280"));
}

/// One frame with a wrong checksum is named as that, with its place.
#[test]
fn a_wrong_checksum_is_named() {
    let right = frame(1, 129, &[0x4D, 0x0D, 0, 2, 0xA0, 0xAB]);
    let mut wrong = right.clone();
    wrong[5] ^= 1;
    for (lang, words) in [("en", "byte 0 is broken"), ("ru", "CRC")] {
        let run = Run::of(&["--lang", lang, "decode", &hex(&wrong)]);
        assert!(run.code == 2 && run.err.contains(words) && run.err.contains("CRC"), "{run:?}");
    }
    assert_eq!(Run::of(&["decode", &hex(&right)]).code, 0);
}
