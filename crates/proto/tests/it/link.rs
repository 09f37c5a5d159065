//! §L: link frames on a byte stream and in datagrams.

use lafet_proto::link::{self, BODY_MAX, Counters, Decoder, Frame, PAYLOAD_MAX, WIRE_MAX};
use lafet_proto::{DecodeError, Expected};
use proptest::prelude::*;

type Owned = (u8, u8, Vec<u8>);

fn wire((dst, src, payload): &Owned) -> Vec<u8> {
    let mut out = [0; WIRE_MAX];
    let len = link::encode(&Frame { dst: *dst, src: *src, payload }, &mut out).unwrap();
    out[..len].to_vec()
}

fn decode(decoder: &mut Decoder, mut bytes: &[u8]) -> Vec<Owned> {
    let mut frames = Vec::new();
    while !bytes.is_empty() {
        let (taken, frame) = decoder.push_slice(bytes);
        frames.extend(frame.map(|frame| (frame.dst, frame.src, frame.payload.to_vec())));
        bytes = &bytes[taken..];
    }
    frames
}

/// Frames in which the bytes that need escaping are frequent.
fn frames() -> impl Strategy<Value = Vec<Owned>> {
    let byte = prop_oneof![Just(0xC0), Just(0xDB), Just(0xFF), Just(0xDC), any::<u8>()];
    let payload = prop::collection::vec(byte.clone(), 0..60);
    prop::collection::vec((byte.clone(), byte, payload), 1..6)
}

proptest! {
    /// §L/1, §L/3: any chunking of the stream gives the same frames.
    #[test]
    fn any_chunking(frames in frames(), cuts in prop::collection::vec(1usize..40, 0..80)) {
        let stream: Vec<u8> = frames.iter().flat_map(wire).collect();
        let mut decoder = Decoder::new();
        let mut got = Vec::new();
        let mut rest = stream.as_slice();
        for cut in cuts {
            let (chunk, tail) = rest.split_at(cut.min(rest.len()));
            got.extend(decode(&mut decoder, chunk));
            rest = tail;
        }
        got.extend(decode(&mut decoder, rest));
        prop_assert_eq!(&got, &frames);
        let count = frames.len() as u64;
        let mut expected = Counters::default();
        expected.frames = count;
        prop_assert_eq!(*decoder.counters(), expected);
    }

    /// §L/3: noise before, between and inside frames costs at most the frame that it hits.
    #[test]
    fn noise_costs_the_frame_it_hits(
        frames in frames(),
        hit in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        noise in prop::collection::vec(any::<u8>(), 1..20),
        replace in any::<bool>(),
    ) {
        let hit = hit.index(frames.len());
        let mut stream = Vec::new();
        for (index, frame) in frames.iter().enumerate() {
            let mut bytes = wire(frame);
            if index == hit {
                let at = at.index(bytes.len());
                let end = if replace { (at + noise.len()).min(bytes.len()) } else { at };
                bytes.splice(at..end, noise.iter().copied());
            }
            stream.extend(bytes);
        }
        let got = decode(&mut Decoder::new(), &stream);
        // A frame after the noise needs its start byte untouched, which noise in another has.
        let others = frames.iter().enumerate().filter(|(index, _)| *index != hit);
        let mut got = got.iter();
        for (index, frame) in others {
            prop_assert!(got.any(|found| found == frame), "frame {} is lost", index);
        }
    }

    /// §C/1: one datagram is one frame.
    #[test]
    fn datagrams(frame in frames().prop_map(|mut frames| frames.remove(0))) {
        let bytes = wire(&frame);
        let mut body = [0; BODY_MAX];
        let got = link::decode_datagram(&bytes, &mut body).unwrap();
        prop_assert_eq!((got.dst, got.src, got.payload.to_vec()), frame);
        for end in 0..bytes.len() {
            let got = link::decode_datagram(&bytes[..end], &mut body);
            prop_assert!(got.is_err(), "cut at {}", end);
        }
    }

    /// Garbage is never a reason to stop: afterwards a good frame is received.
    #[test]
    fn garbage_then_a_frame(garbage in prop::collection::vec(any::<u8>(), 0..2000)) {
        let mut decoder = Decoder::new();
        decode(&mut decoder, &garbage);
        let good = (1, 129, vec![0xD4, 0x5D, 0, 0]);
        prop_assert!(decode(&mut decoder, &wire(&good)).contains(&good));
        let mut body = [0; BODY_MAX];
        let _ = link::decode_datagram(&garbage, &mut body);
    }
}

/// §L/2, §L/4, §L/6: what spoils a frame is counted by its kind.
#[test]
fn counters_tell_what_was_wrong() {
    let good = wire(&(1, 129, vec![0xD4, 0x5D, 0, 0]));
    let mut bad_crc = good.clone();
    bad_crc[4] ^= 1;
    let counted = |bytes: &[u8]| {
        let mut decoder = Decoder::<BODY_MAX>::new();
        let frames = decode(&mut decoder, bytes).len();
        (frames, *decoder.counters())
    };
    let (frames, counters) = counted(&bad_crc);
    assert_eq!((frames, counters.crc_errors, counters.bytes_skipped), (0, 1, 9));
    let (frames, counters) = counted(&[0xFF, 0xC0, 1, 0xDB, 7, 0xC0]);
    assert_eq!((frames, counters.escape_errors), (0, 1));
    let (frames, counters) = counted(&[0xFF, 0xC0, 1, 2, 3, 0xC0]);
    assert_eq!((frames, counters.resyncs), (0, 1));
    let (frames, counters) = counted(&[9, 9, 9]);
    assert_eq!((frames, counters.bytes_skipped), (0, 3));
    let long = wire(&(1, 2, vec![7; PAYLOAD_MAX]));
    assert_eq!(counted(&long).0, 1);
    let mut longer = vec![0xFF, 0xC0];
    longer.extend([7; BODY_MAX + 1]);
    longer.extend(&good);
    let (frames, counters) = counted(&longer);
    assert_eq!((frames, counters.overruns), (1, 1));
}

/// §L/4: C0 after fewer than four bytes starts a new frame.
#[test]
fn a_short_frame_starts_anew() {
    let good = (1, 129, vec![0xD4, 0x5D, 0, 0]);
    let mut bytes = vec![0xFF, 0xC0, 1, 2];
    bytes.extend(&wire(&good)[1..]);
    assert_eq!(decode(&mut Decoder::new(), &bytes), [good]);
}

/// §L/5: the shortest frame is a presence probe.
#[test]
fn probe() {
    let bytes = wire(&(3, 128, vec![]));
    assert_eq!(bytes, [0xFF, 0xC0, 3, 128, 0, 0xE0, 0xC0]);
    let mut decoder = Decoder::<BODY_MAX>::new();
    let (_, frame) = decoder.push_slice(&bytes);
    assert!(frame.unwrap().is_probe());
}

/// A datagram's error says where and what.
#[test]
fn datagram_errors() {
    let mut body = [0; BODY_MAX];
    let mut error = |bytes: &[u8]| link::decode_datagram(bytes, &mut body).unwrap_err();
    assert_eq!(error(&[1]), DecodeError { offset: 0, expected: Expected::FrameStart, got: 1 });
    assert_eq!(
        error(&[0xFF, 0xC0, 1, 0xDB, 7]),
        DecodeError { offset: 4, expected: Expected::Escape, got: 7 }
    );
    assert_eq!(
        error(&[0xC0, 3, 128, 0, 0xE1, 0xC0]),
        DecodeError { offset: 2, expected: Expected::Crc(0xE000), got: 0xE100 }
    );
    assert_eq!(error(&[0xC0, 3, 128, 0, 0xE0, 0xC0, 5]).expected, Expected::FrameEnd);
}

fn wire_crc32c((dst, src, payload): &Owned) -> Vec<u8> {
    let mut out = [0; WIRE_MAX];
    let frame = Frame { dst: *dst, src: *src, payload };
    let len = link::encode_with(link::Check::Crc32c, &frame, &mut out).unwrap();
    out[..len].to_vec()
}

proptest! {
    /// §L/7: frames of both forms follow each other; the checksum of each is known.
    #[test]
    fn both_checks_on_one_line(frames in frames(), long in any::<u64>()) {
        let is_long = |index: usize| long >> index & 1 == 1;
        let wires: Vec<Vec<u8>> = frames
            .iter()
            .enumerate()
            .map(|(index, frame)| if is_long(index) { wire_crc32c(frame) } else { wire(frame) })
            .collect();
        let mut decoder: Decoder = Decoder::new();
        for (index, bytes) in wires.iter().enumerate() {
            prop_assert_eq!(&decode(&mut decoder, bytes), &frames[index..=index]);
            let check = if is_long(index) { link::Check::Crc32c } else { link::Check::Crc16 };
            prop_assert_eq!(decoder.check(), check);
            prop_assert_eq!(link::check_of(bytes), check);
            let mut body = [0; BODY_MAX];
            let found = link::decode_datagram(bytes, &mut body).unwrap();
            prop_assert_eq!((found.dst, found.src, found.payload.to_vec()), frames[index].clone());
        }
    }

    /// §L/7: a peer that does not support the form drops such a frame, whatever its content, and loses
    /// nothing else.
    #[test]
    fn a_plain_peer_is_not_disturbed(frames in frames(), others in frames()) {
        let mut plain = Plain::default();
        for (frame, other) in frames.iter().zip(&others) {
            prop_assert_eq!(plain.feed(&wire_crc32c(other)), vec![]);
            prop_assert_eq!(plain.feed(&wire(frame)), vec![frame.clone()]);
        }
    }
}

/// §L/7: reference value of the CRC-32C ("123456789" gives E3069283), here with addresses 0x31 0x32.
#[test]
fn crc32c_of_the_check_string() {
    let frame = (0x31, 0x32, b"3456789".to_vec());
    let mut expected = vec![0xFF, 0xC0, 0xDB, 0xDE];
    expected.extend(b"123456789");
    expected.extend([0x83, 0x92, 0x06, 0xE3, 0xC0]);
    assert_eq!(wire_crc32c(&frame), expected);
    let mut body = [0; BODY_MAX];
    expected[6] ^= 1;
    let error = link::decode_datagram(&expected, &mut body).unwrap_err();
    assert!(matches!(error.expected, Expected::Crc32c(right) if right != 0xE306_9283), "{error}");
    assert_eq!((error.offset, error.got), (9, 0xE306_9283));
}

/// The observed link as its description says it, written independently and without §L/7.
#[derive(Default)]
struct Plain {
    body: Option<Vec<u8>>,
    escaped: bool,
}

impl Plain {
    fn feed(&mut self, bytes: &[u8]) -> Vec<Owned> {
        bytes.iter().filter_map(|byte| self.byte(*byte)).collect()
    }

    fn byte(&mut self, byte: u8) -> Option<Owned> {
        let Some(body) = &mut self.body else {
            self.body = (byte == 0xC0).then(Vec::new);
            return None;
        };
        let escaped = std::mem::take(&mut self.escaped);
        match byte {
            0xC0 if body.len() >= 4 && !escaped => {
                let body = self.body.take()?;
                let (data, crc) = body.split_at(body.len() - 2);
                return (bitwise_crc16(data).to_le_bytes() == crc)
                    .then(|| (data[0], data[1], data[2..].to_vec()));
            }
            0xC0 => body.clear(),
            0xDC if escaped => body.push(0xC0),
            0xDD if escaped => body.push(0xDB),
            _ if escaped => self.body = None,
            0xDB => self.escaped = true,
            plain => body.push(plain),
        }
        None
    }
}

fn bitwise_crc16(data: &[u8]) -> u16 {
    data.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| {
            if crc & 1 == 1 { (crc >> 1) ^ 0xA001 } else { crc >> 1 }
        })
    })
}
