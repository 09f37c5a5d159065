//! Bytes of a line, split anywhere: the decoder must find the same frames as a slow one, which sees
//! the whole stream at once and shares no code with it.

use crate::fuzz::feed::Feed;
use lafet_proto::link::{self, BODY_MAX, Check, Counters, Decoder, Frame, WIRE_MAX};

/// Longest stream, bytes: several of the longest frames.
const STREAM_MAX: usize = 6 * WIRE_MAX;
/// A buffer that most frames overrun, bytes.
const SMALL: usize = 12;

pub fn run(input: &[u8]) -> u64 {
    let mut feed = Feed::new(input);
    let cut = feed.u8();
    let stream = stream(&mut feed);
    compare::<BODY_MAX>(&stream, cut);
    compare::<SMALL>(&stream, cut);
    datagrams(&stream);
    3 * stream.len() as u64
}

/// Garbage, valid and damaged frames, one after another.
fn stream(feed: &mut Feed<'_>) -> Vec<u8> {
    let mut stream = Vec::new();
    while !feed.is_empty() && stream.len() < STREAM_MAX - WIRE_MAX {
        let kind = feed.u8();
        let len = feed.below(64);
        let bytes = feed.take(len);
        let frame_of = |bytes: &[u8]| frame_of(check_of(kind), bytes);
        match kind % 5 {
            0 => stream.extend_from_slice(bytes),
            1 => stream.extend(frame_of(bytes)),
            2 => {
                let mut frame = frame_of(bytes);
                let at = usize::from(feed.u16()) % frame.len();
                frame[at] ^= feed.u8();
                stream.extend(frame);
            }
            3 => {
                let frame = frame_of(bytes);
                let end = usize::from(feed.u16()) % frame.len();
                stream.extend_from_slice(&frame[..end]);
            }
            _ => {
                let times = 1 + (BODY_MAX + feed.below(8)) / bytes.len().max(1);
                let mut long = bytes.repeat(times);
                long.truncate(BODY_MAX - 4 + feed.below(8));
                stream.extend(frame_of(&long));
            }
        }
    }
    stream
}

/// Most frames have the check that every peer supports.
const fn check_of(kind: u8) -> Check {
    if kind < 0xE0 { Check::Crc16 } else { Check::Crc32c }
}

/// A frame made by the slow encoder.
fn frame_of(check: Check, body: &[u8]) -> Vec<u8> {
    let all = [body, &slow::sum(check, body)].concat();
    let mut wire = vec![0xFF, 0xC0];
    if check == Check::Crc32c {
        wire.extend([0xDB, 0xDE]);
    }
    for byte in all {
        match byte {
            0xC0 => wire.extend([0xDB, 0xDC]),
            0xDB => wire.extend([0xDB, 0xDD]),
            other => wire.push(other),
        }
    }
    wire.push(0xC0);
    wire
}

fn compare<const N: usize>(stream: &[u8], cut: u8) {
    let expected = slow::decode(stream, N);
    let mut decoder = Decoder::<N>::new();
    let mut found = Vec::new();
    for byte in stream {
        found.extend(decoder.push(*byte).map(own));
    }
    assert_eq!(found, expected.frames, "byte by byte");
    assert_eq!(*decoder.counters(), expected.counters, "byte by byte");

    let mut decoder = Decoder::<N>::new();
    let mut found = Vec::new();
    // 1 to 256 bytes at a time, of constant or varying length.
    let mut len = usize::from(cut);
    let mut rest = stream;
    while !rest.is_empty() {
        let (mut chunk, tail) = rest.split_at(rest.len().min(1 + len));
        (len, rest) = ((len * 5 + usize::from(cut & 1) * 7) % 256, tail);
        while !chunk.is_empty() {
            let (taken, frame) = decoder.push_slice(chunk);
            let is_frame = frame.is_some();
            found.extend(frame.map(own));
            assert!(taken == chunk.len() || is_frame && taken > 0, "{taken} taken");
            chunk = &chunk[taken..];
        }
    }
    assert_eq!(found, expected.frames, "in pieces");
    assert_eq!(*decoder.counters(), expected.counters, "in pieces");
    for frame in &expected.frames {
        round_trip(frame);
    }
}

type Owned = (u8, u8, Vec<u8>);

fn own(frame: Frame<'_>) -> Owned {
    (frame.dst, frame.src, frame.payload.to_vec())
}

/// A decoded frame is encoded as by the slow encoder, and decoded as a datagram.
fn round_trip((dst, src, payload): &Owned) {
    let frame = Frame { dst: *dst, src: *src, payload };
    let body = [&[*dst, *src], payload.as_slice()].concat();
    for check in [Check::Crc16, Check::Crc32c] {
        let mut wire = vec![0; link::wire_max(payload.len())];
        let len = link::encode_with(check, &frame, &mut wire).expect("room enough");
        assert_eq!(wire[..len], frame_of(check, &body), "encoded");
        let mut sent = Vec::new();
        link::send(check, &frame, &mut |byte| sent.push(byte));
        assert_eq!(sent, wire[..len], "byte by byte");
        let mut short = vec![0; len - 1];
        assert_eq!(link::encode_with(check, &frame, &mut short), None, "one byte short");
        let mut room = [0; BODY_MAX + 2];
        assert_eq!(link::decode_datagram(&wire[..len], &mut room), Ok(frame), "as a datagram");
        assert_eq!(link::check_of(&wire[..len]), check);
    }
    assert!(payload.len() <= BODY_MAX - 4 && frame.is_probe() == payload.is_empty());
}

/// A datagram is a frame exactly when the slow decoder finds one frame and nothing else in it.
fn datagrams(stream: &[u8]) {
    let mut body = [0; BODY_MAX];
    let got = link::decode_datagram(stream, &mut body);
    let slow = slow::decode(stream, BODY_MAX);
    let inside = stream.iter().position(|byte| *byte != 0xFF).unwrap_or(stream.len());
    let ends = stream[inside..].iter().filter(|byte| **byte == 0xC0).count();
    let whole = ends == 2 && stream[inside] == 0xC0 && stream.last() == Some(&0xC0);
    match (whole, &slow.frames[..]) {
        (true, [frame]) => assert_eq!(got.map(own), Ok(frame.clone())),
        _ => {
            let error = got.expect_err("more or less than a frame");
            assert!(error.offset <= stream.len(), "{error}");
        }
    }
}

/// A second, slow implementation of the link frame.
mod slow {
    use super::{Check, Counters, Owned};

    pub struct Decoded {
        pub frames: Vec<Owned>,
        pub counters: Counters,
    }

    /// A reflected CRC that starts with all ones, bit by bit.
    fn crc(bytes: &[u8], ones: u32, polynomial: u32) -> u32 {
        let mut crc = ones;
        for byte in bytes {
            crc ^= u32::from(*byte);
            for _ in 0..8 {
                crc = if crc & 1 == 0 { crc >> 1 } else { crc >> 1 ^ polynomial };
            }
        }
        crc
    }

    /// CRC-16/MODBUS or CRC-32C, as it goes on the wire.
    pub fn sum(check: Check, bytes: &[u8]) -> Vec<u8> {
        match check {
            Check::Crc16 => crc(bytes, 0xFFFF, 0xA001).to_le_bytes()[..2].to_vec(),
            Check::Crc32c => (!crc(bytes, u32::MAX, 0x82F6_3B78)).to_le_bytes().to_vec(),
        }
    }

    enum Inside {
        /// A valid frame: its check, and its body, unescaped.
        Good(Check, Vec<u8>),
        /// The piece ends in the middle of an escape.
        Escape,
        /// DB is followed by a byte other than DC or DD, or DE is not at the start; the number of
        /// bytes in the corrupt frame.
        BadEscape(usize),
        /// The piece is longer than the room; the number of bytes in the corrupt frame.
        Overrun(usize),
    }

    /// The bytes between two C0.
    fn unescape(piece: &[u8], room: usize) -> Inside {
        let mut body = Vec::new();
        let check = if piece.starts_with(&[0xDB, 0xDE]) { Check::Crc32c } else { Check::Crc16 };
        let mut at = if check == Check::Crc32c { 2 } else { 0 };
        while at < piece.len() {
            let (byte, size) = match piece[at..] {
                [0xDB, 0xDC, ..] => (0xC0, 2),
                [0xDB, 0xDD, ..] => (0xDB, 2),
                [0xDB, _, ..] => return Inside::BadEscape(at + 2),
                [0xDB] => return Inside::Escape,
                [plain, ..] => (plain, 1),
                [] => break,
            };
            at += size;
            if body.len() == room {
                return Inside::Overrun(at);
            }
            body.push(byte);
        }
        Inside::Good(check, body)
    }

    fn not_sync(bytes: &[u8]) -> u64 {
        bytes.iter().filter(|byte| **byte != 0xFF).count() as u64
    }

    /// C0 splits the stream into pieces; each piece is inside or outside of a frame.
    pub fn decode(stream: &[u8], room: usize) -> Decoded {
        let pieces: Vec<&[u8]> = stream.split(|byte| *byte == 0xC0).collect();
        let (mut frames, mut counters) = (Vec::new(), Counters::default());
        let mut inside = false;
        for (index, piece) in pieces.iter().enumerate() {
            if !inside {
                counters.bytes_skipped += not_sync(piece);
                inside = true;
                continue;
            }
            // The C0 before this piece opened a frame; there may be none after it.
            let is_last = index + 1 == pieces.len();
            let skipped = &mut counters.bytes_skipped;
            match unescape(piece, room) {
                Inside::BadEscape(len) => {
                    counters.escape_errors += 1;
                    *skipped += 1 + len as u64 + not_sync(&piece[len..]);
                }
                Inside::Overrun(len) => {
                    counters.overruns += 1;
                    *skipped += 1 + len as u64 + not_sync(&piece[len..]);
                }
                _ if is_last => {}
                Inside::Escape => {
                    counters.escape_errors += 1;
                    *skipped += 1 + piece.len() as u64;
                }
                Inside::Good(check, body) if body.len() < 2 + sum(check, &[]).len() => {
                    counters.resyncs += u64::from(!body.is_empty());
                    *skipped += 1 + piece.len() as u64;
                }
                Inside::Good(check, body) => {
                    let (covered, end) = body.split_at(body.len() - sum(check, &[]).len());
                    if sum(check, covered) == end {
                        counters.frames += 1;
                        frames.push((covered[0], covered[1], covered[2..].to_vec()));
                        inside = false;
                    } else {
                        counters.crc_errors += 1;
                        *skipped += 1 + piece.len() as u64;
                    }
                }
            }
        }
        Decoded { frames, counters }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        /// The published check values for CRC-16/MODBUS and CRC-32C.
        #[test]
        fn the_sums_are_the_published_ones() {
            assert_eq!(sum(Check::Crc16, b"123456789"), 0x4B37_u16.to_le_bytes());
            assert_eq!(sum(Check::Crc32c, b"123456789"), 0xE306_9283_u32.to_le_bytes());
        }

        #[test]
        fn frames_and_garbage() {
            let stream = [0xFF, 0xC0, 1, 2, 0xC0, 0xE1, 0x81, 0xC0, 7, 0xC0];
            let found = decode(&stream, 16);
            assert!(found.frames.is_empty(), "{:?}", found.frames);
            for (check, start) in
                [(Check::Crc16, vec![0xC0, 1, 2]), (Check::Crc32c, vec![0xC0, 0xDB, 0xDE, 1, 2])]
            {
                let probe = [start, sum(check, &[1, 2]), vec![0xC0, 9]];
                let found = decode(&probe.concat(), 16);
                assert_eq!(found.frames, [(1, 2, vec![])]);
                assert_eq!((found.counters.frames, found.counters.bytes_skipped), (1, 1));
            }
        }
    }
}
