//! A recording returns what was recorded, even when its recorder was killed.

use std::fs;
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::path::PathBuf;

use lafet_capture::{Captured, Direction, Format, Medium, ReadError, Recorder, read};
use lafet_proto::link::{Frame, WIRE_MAX, encode};
use serde_json::Value;

const FORMATS: [Format; 2] = [Format::Mcap, Format::Pcapng];

fn frame(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut out = [0; WIRE_MAX];
    let len = encode(&Frame { dst, src, payload }, &mut out).unwrap();
    out[..len].to_vec()
}

fn pieces() -> Vec<Captured> {
    let status = [0xD4, 0x0D, 0, 8, 1, 0, 2, 0, 0x9C, 0xFF, 15, 9];
    let noisy = [&[1, 2, 3][..], &frame(1, 129, &[0x4D, 0x0D, 0, 2, 0, 0])].concat();
    let all = [
        (Direction::ToMonitor, frame(1, 129, &[0xD4, 0x0D, 0, 0])),
        (Direction::FromMonitor, frame(129, 1, &status)),
        (Direction::Heard, noisy),
        (Direction::FromMonitor, frame(129, 1, &[0x4D, 0xA2, 3, 0])),
        (Direction::ToMonitor, vec![0xFF, 0xC0]),
    ];
    let start = 1_790_000_000_123_456_789;
    let at = |i: usize| start + 1_000_007 * i as u64;
    all.into_iter()
        .enumerate()
        .map(|(i, (direction, bytes))| Captured { at_ns: at(i), direction, bytes })
        .collect()
}

fn record(format: Format, pieces: &[Captured]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut recorder = Recorder::new(format, &mut bytes).unwrap();
    for piece in pieces {
        recorder.write(piece).unwrap();
        recorder.flush().unwrap();
    }
    recorder.finish().unwrap();
    bytes.into_inner()
}

/// The path of a file used by this test only.
struct File(PathBuf);

impl File {
    fn new(name: &str, bytes: &[u8]) -> Self {
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        fs::write(&path, bytes).unwrap();
        Self(path)
    }

    fn read(&self) -> Result<Vec<Captured>, ReadError> {
        read(&self.0)
    }
}

impl Drop for File {
    fn drop(&mut self) {
        // A file left over would only be overwritten.
        let _ = fs::remove_file(&self.0);
    }
}

#[test]
fn what_was_recorded_is_read() {
    for format in FORMATS {
        let file = File::new(&format!("whole-{format:?}"), &record(format, &pieces()));
        assert_eq!(file.read().unwrap(), pieces(), "{format:?}");
    }
}

/// A recording cut anywhere behind its head is read up to the cut, in order.
#[test]
fn a_recording_cut_short_is_read_as_far_as_it_goes() {
    // The magic bytes; the first block.
    for (format, head) in [(Format::Mcap, 8), (Format::Pcapng, 28)] {
        let bytes = record(format, &pieces());
        let mut most = 0;
        for len in head..=bytes.len() {
            let file = File::new(&format!("cut-{format:?}"), &bytes[..len]);
            let read =
                file.read().unwrap_or_else(|error| panic!("{format:?} cut at {len}: {error}"));
            assert!(pieces().starts_with(&read), "{format:?} cut at {len}");
            assert!(read.len() >= most, "{format:?} cut at {len}: less than before");
            most = read.len();
        }
        assert_eq!(most, pieces().len(), "{format:?}");
    }
}

/// A block that says to be longer than any is damage, not an end: what follows it is not silently left out.
#[test]
fn a_block_that_is_too_long_is_damage() {
    let mut bytes = record(Format::Pcapng, &pieces());
    let start = bytes.len();
    bytes.extend(6_u32.to_le_bytes());
    bytes.extend(0x7000_0000_u32.to_le_bytes());
    bytes.resize(start + 9_000_000, 0);
    let error = File::new("too-long", &bytes).read().unwrap_err();
    assert!(matches!(error, ReadError::Damaged(_)), "{error}");
}

/// So is a packet that is longer than its block, wherever it is.
#[test]
fn a_damaged_packet_is_not_the_end() {
    let mut bytes = record(Format::Pcapng, &pieces());
    let len =
        |bytes: &[u8], at: usize| u32::from_le_bytes(bytes[at + 4..at + 8].try_into().unwrap());
    let mut at = 0;
    while bytes[at..at + 4] != 6_u32.to_le_bytes() {
        at += len(&bytes, at) as usize;
    }
    // The length of its data, behind interface and time.
    bytes[at + 20..at + 24].copy_from_slice(&1_000_000_u32.to_le_bytes());
    let error = File::new("damaged-packet", &bytes).read().unwrap_err();
    assert!(matches!(error, ReadError::Damaged(_)), "{error}");
}

#[test]
fn what_is_no_recording_is_reported() {
    let error = |name: &str, bytes: &[u8]| File::new(name, bytes).read().unwrap_err().to_string();
    assert!(error("text", b"hello, world").contains("neither"));
    let mut damaged = record(Format::Pcapng, &pieces());
    damaged[4] = 7;
    assert!(error("damaged", &damaged).contains("damaged"));
    let other = {
        let mut bytes = Cursor::new(Vec::new());
        let mut writer = mcap::Writer::new(&mut bytes).unwrap();
        let channel = writer.add_channel(0, "/x", "json", &Default::default()).unwrap();
        let header = mcap::records::MessageHeader {
            channel_id: channel,
            sequence: 1,
            log_time: 1,
            publish_time: 1,
        };
        writer.write_to_known_channel(&header, b"{}").unwrap();
        writer.finish().unwrap();
        drop(writer);
        bytes.into_inner()
    };
    assert!(error("other", &other).contains("without the frames"));
}

/// The contents of frames are added as JSON, in units for plots, with a schema.
#[test]
fn mcap_has_decoded_values() {
    let bytes = record(Format::Mcap, &pieces());
    let mut messages = Vec::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        if message.channel.message_encoding == "json" {
            let schema = message.channel.schema.clone().unwrap();
            let properties: Value = serde_json::from_slice(&schema.data).unwrap();
            let json: Value = serde_json::from_slice(&message.data).unwrap();
            for (name, _) in json.as_object().unwrap() {
                assert!(properties["properties"][name].is_object(), "{name} in {}", schema.name);
            }
            messages.push((message.channel.topic.clone(), schema.name.clone(), json));
        }
    }
    let topics: Vec<&str> = messages.iter().map(|(topic, ..)| topic.as_str()).collect();
    assert_eq!(topics, ["/monitor/1/Vertical", "/monitor/1/log", "/monitor/1/log"]);
    let (_, schema, drive) = &messages[0];
    assert_eq!(schema, "DriveStatus");
    assert_eq!((&drive["position_deg"], &drive["current_a"]), (&(-1.6667).into(), &1.5.into()));
    assert_eq!(drive["flags"]["ConfigFault"], true);
    assert_eq!(drive["flags"].as_object().unwrap().values().filter(|v| **v == true).count(), 2);
    assert_eq!(messages[1].2["message"], "Move Vertical 0");
    assert_eq!(messages[2].2["level"], 3, "a refusal is a warning");
}

#[test]
fn what_is_packed_into_a_file_is_bounded_and_read_as_far_as_it_is_wanted() {
    use lafet_capture::{Note, Piece, read_each};
    let mut bytes = Cursor::new(Vec::new());
    let mut recorder = Recorder::new(Format::Mcap, &mut bytes).unwrap();
    let json = format!("\"{}\"", "x".repeat(1 << 20));
    for at_ns in 0..8 {
        recorder.note(&Note { at_ns, topic: "scene".into(), json: json.clone() }).unwrap();
    }
    recorder.finish().unwrap();
    let path = std::env::temp_dir().join(format!("lafet-packed-{}.mcap", std::process::id()));
    fs::write(&path, bytes.get_ref()).unwrap();
    assert!(bytes.get_ref().len() < 1 << 20, "it packs well");
    let count = |most: u64, wanted: usize| {
        let mut pieces = 0;
        let take = |piece: Piece| {
            assert!(matches!(piece, Piece::Note(_)));
            pieces += 1;
            pieces < wanted
        };
        (read_each(&path, most, take), pieces)
    };
    assert!(matches!(count(16 << 20, 100), (Ok(()), 8)));
    assert!(matches!(count(4 << 20, 100), (Err(ReadError::TooLarge { .. }), 3)));
    assert!(matches!(count(u64::MAX, 2), (Ok(()), 2)));
    fs::remove_file(&path).unwrap();
}

/// A recorder that is killed after any flush leaves a file that a strict reader reads to its end.
#[test]
fn mcap_is_whole_after_every_flush() {
    for count in 0..=pieces().len() {
        let mut bytes = Cursor::new(Vec::new());
        let mut recorder = Recorder::new(Format::Mcap, &mut bytes).unwrap();
        for piece in &pieces()[..count] {
            recorder.write(piece).unwrap();
            recorder.flush().unwrap();
        }
        // This piece is not flushed.
        if let Some(next) = pieces().get(count) {
            recorder.write(next).unwrap();
        }
        std::mem::forget(recorder);
        let messages = mcap::MessageStream::new(bytes.get_ref()).expect("magic at both ends");
        let messages: Result<Vec<_>, _> = messages.collect();
        let messages = messages.unwrap_or_else(|error| panic!("{count}: {error}"));
        let frames = messages.iter().filter(|message| message.channel.topic == "/frames").count();
        assert_eq!(frames, count);
    }
}

/// A medium that takes so many bytes and no more.
struct Full<'a> {
    bytes: &'a mut Cursor<Vec<u8>>,
    most: u64,
}

impl Write for Full<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let room = usize::try_from(self.most.saturating_sub(self.bytes.position())).unwrap();
        match bytes.get(..room).unwrap_or(bytes) {
            [] if !bytes.is_empty() => Err(io::ErrorKind::StorageFull.into()),
            some => self.bytes.write(some),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Full<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.bytes.seek(to)
    }
}

impl Medium for Full<'_> {
    fn cut(&mut self, len: u64) -> io::Result<()> {
        self.bytes.cut(len)
    }
}

/// Wherever the disk becomes full, the file has whole records, and all that were flushed before.
#[test]
fn on_a_disk_that_becomes_full_everything_flushed_stays_whole() {
    for format in FORMATS {
        let all = record(format, &pieces()).len() as u64;
        let mut counts = Vec::new();
        for most in 0..all {
            let mut bytes = Cursor::new(Vec::new());
            let mut flushed = 0;
            if let Ok(mut recorder) = Recorder::new(format, Full { bytes: &mut bytes, most }) {
                let mut put = |piece| recorder.write(piece).and_then(|()| recorder.flush());
                flushed = pieces().iter().map_while(|piece| put(piece).ok()).count();
                if flushed < pieces().len() {
                    // What is dropped or ended later changes nothing.
                    _ = recorder.finish();
                }
            }
            let bytes = bytes.into_inner();
            counts.push(flushed);
            if bytes.is_empty() {
                assert_eq!(flushed, 0);
                continue;
            }
            let frames = match format {
                Format::Mcap => {
                    let messages = mcap::MessageStream::new(&bytes).expect("magic at both ends");
                    let of = |it: &mcap::Message<'_>| it.channel.topic == "/frames";
                    let all: Vec<_> = messages.map(Result::unwrap).collect();
                    all.iter().filter(|it| of(it)).count()
                }
                Format::Pcapng => packets(&bytes),
            };
            assert_eq!(frames, flushed, "{format:?}: {most} of {all} bytes");
        }
        assert!(counts.contains(&0) && counts.contains(&(pieces().len() - 1)), "{counts:?}");
    }
}

/// Packets of a file that has nothing behind its last whole block.
fn packets(bytes: &[u8]) -> usize {
    let (mut rest, mut count) = (bytes, 0);
    while !rest.is_empty() {
        let word = |at: usize| rest[at..at + 4].try_into().unwrap();
        // The byte order is in the first block.
        let big = bytes[8] == 0x1A;
        let read =
            |at| if big { u32::from_be_bytes(word(at)) } else { u32::from_le_bytes(word(at)) };
        count += usize::from(read(0) == 6);
        rest = &rest[read(4) as usize..];
    }
    count
}
