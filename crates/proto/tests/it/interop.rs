//! §L against an implementation of the link that shares nothing with this one: Python, from the page.

use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use lafet_proto::link::{Check, Decoder, Frame, WIRE_MAX, encode_with};

/// dst, src, records, check.
type Seen = (u8, u8, Vec<u8>, Check);

fn script() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../conformance/interop/link.py")
}

struct Python {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Python {
    fn start() -> Self {
        let mut child = Command::new("python3")
            .arg(script())
            .arg("echo")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("python3 is needed; `cargo xtask test` installs it");
        let (input, output) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        Self { child, input, output: BufReader::new(output) }
    }

    fn ask(&mut self, line: &str) -> String {
        writeln!(self.input, "{line}").unwrap();
        let mut answer = String::new();
        self.output.read_line(&mut answer).unwrap();
        answer.trim().to_owned()
    }

    fn decode(&mut self, bytes: &[u8]) -> Vec<Seen> {
        let frame = |text: &str| {
            let parts: Vec<&str> = text.split(',').collect();
            let check = if parts[3] == "32" { Check::Crc32c } else { Check::Crc16 };
            (parts[0].parse().unwrap(), parts[1].parse().unwrap(), bytes_of(parts[2]), check)
        };
        self.ask(&format!("d {}", hex(bytes))).split_whitespace().map(frame).collect()
    }

    fn encode(&mut self, dst: u8, src: u8, records: &[u8], check: Check) -> Vec<u8> {
        let form = if check == Check::Crc32c { "32 " } else { "" };
        bytes_of(&self.ask(&format!("e {form}{dst} {src} {}", hex(records))))
    }
}

impl Drop for Python {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes_of(hex: &str) -> Vec<u8> {
    let (pairs, []) = hex.as_bytes().as_chunks::<2>() else { panic!("{hex}") };
    let byte = |pair: &[u8; 2]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16);
    pairs.iter().map(|pair| byte(pair).unwrap()).collect()
}

fn decoded(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Seen> {
    let (mut rest, mut seen) = (bytes, Vec::new());
    while !rest.is_empty() {
        let (taken, frame) = decoder.push_slice(rest);
        rest = &rest[taken..];
        let frame = frame.map(|Frame { dst, src, payload }| (dst, src, payload.to_vec()));
        if let Some((dst, src, payload)) = frame {
            seen.push((dst, src, payload, decoder.check()));
        }
    }
    seen
}

/// Knuth's multiplier: any sequence will do.
struct Chance(u64);

impl Chance {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 33) as usize % n
    }

    /// Bytes that need escaping are frequent.
    fn byte(&mut self) -> u8 {
        const ODD: [u8; 6] = [0xC0, 0xDB, 0xDC, 0xDD, 0xDE, 0xFF];
        let odd = ODD[self.below(6)];
        if self.below(3) == 0 { odd } else { self.below(256) as u8 }
    }
}

#[test]
fn each_encodes_as_the_other_and_reads_it() {
    let mut python = Python::start();
    let mut decoder: Box<Decoder> = Box::default();
    let mut chance = Chance(1);
    for n in 0..1_000 {
        let check = if n % 2 == 0 { Check::Crc16 } else { Check::Crc32c };
        let len = if n % 100 == 99 { 512 } else { chance.below(40) };
        let payload: Vec<u8> = (0..len).map(|_| chance.byte()).collect();
        let (dst, src) = (chance.byte(), chance.byte());
        let mut wire = [0; WIRE_MAX];
        let frame = Frame { dst, src, payload: &payload };
        let size = encode_with(check, &frame, &mut wire).expect("it fits");
        let theirs = python.encode(dst, src, &payload, check);
        assert_eq!(hex(&theirs), hex(&wire[..size]), "{n}");
        let expected = [(dst, src, payload, check)];
        assert_eq!(decoded(&mut decoder, &theirs), expected);
        assert_eq!(python.decode(&wire[..size]), expected);
    }
}

/// Frames, bits turned round, bytes lost and doubled, noise: both see the same frames.
#[test]
fn both_see_the_same_in_a_spoilt_stream() {
    let mut python = Python::start();
    let mut decoder: Box<Decoder> = Box::default();
    let mut chance = Chance(2);
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for n in 0..3_000 {
        let check = if chance.below(2) == 0 { Check::Crc16 } else { Check::Crc32c };
        let payload: Vec<u8> = (0..chance.below(20)).map(|_| chance.byte()).collect();
        let frame = Frame { dst: 1, src: 129, payload: &payload };
        let mut wire = [0; WIRE_MAX];
        let size = encode_with(check, &frame, &mut wire).expect("it fits");
        let mut wire = wire[..size].to_vec();
        let at = chance.below(wire.len());
        match n % 6 {
            0 => wire[at] ^= 1 << chance.below(8),
            1 => drop(wire.remove(at)),
            2 => wire.insert(at, wire[at]),
            3 => wire.insert(at, chance.byte()),
            4 => wire.splice(0..0, (0..5).map(|_| chance.byte())).for_each(drop),
            _ => {}
        }
        ours.extend(decoded(&mut decoder, &wire));
        theirs.extend(python.decode(&wire));
    }
    assert!(ours.len() > 1_000, "{}", ours.len());
    assert_eq!(ours, theirs);
}

#[test]
fn it_agrees_with_the_golden_vectors() {
    let vectors = script().with_file_name("../vectors/link.json");
    let output = Command::new("python3").arg(script()).arg("vectors").arg(vectors).output();
    let output = output.expect("python3 is needed; `cargo xtask test` installs it");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stdout).contains("decoded and encoded alike"));
}
