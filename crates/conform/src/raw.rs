//! Link frames and records, implemented independently: the tester must not rely on the encoder and
//! decoder that it may be testing.

use lafet_proto::answer::Reply;
use lafet_proto::text::AnswerText;
use lafet_proto::{Answer, Record, RequestId, Status, SubsystemId};

/// §L/1 Delimits frames.
pub const END: u8 = 0xC0;
/// §L/1 Starts an escape.
pub const ESC: u8 = 0xDB;
/// §L/7 Follows the opening C0 of a frame with CRC-32C.
const MARK: [u8; 2] = [ESC, 0xDE];
const ESC_END: u8 = 0xDC;
const ESC_ESC: u8 = 0xDD;
/// Shortest body: two addresses and the CRC, bytes.
const BODY_MIN: usize = 4;
/// Longest body, bytes; anything longer is noise, which must not fill the memory.
const BODY_MAX: usize = 4096;

/// §L/2 CRC-16/MODBUS, bit by bit.
pub fn crc(bytes: &[u8]) -> u16 {
    let mut crc: u16 = 0xFFFF;
    for byte in bytes {
        crc ^= u16::from(*byte);
        for _ in 0..8 {
            let carry = crc & 1 != 0;
            crc >>= 1;
            if carry {
                crc ^= 0xA001;
            }
        }
    }
    crc
}

/// Body of a frame, unescaped: dst, src, payload, CRC.
pub fn body(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut body = vec![dst, src];
    body.extend_from_slice(payload);
    let crc = crc(&body);
    body.extend_from_slice(&crc.to_le_bytes());
    body
}

/// A body, escaped, between its two C0.
pub fn wire(body: &[u8]) -> Vec<u8> {
    let mut wire = vec![0xFF, END];
    wire.extend(escaped(body));
    wire.push(END);
    wire
}

fn escaped(body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(body.len());
    for byte in body {
        match *byte {
            END => bytes.extend_from_slice(&[ESC, ESC_END]),
            ESC => bytes.extend_from_slice(&[ESC, ESC_ESC]),
            byte => bytes.push(byte),
        }
    }
    bytes
}

/// §L/7 CRC-32C, bit by bit.
pub fn crc32c(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            let carry = crc & 1 != 0;
            crc >>= 1;
            if carry {
                crc ^= 0x82F6_3B78;
            }
        }
    }
    !crc
}

/// §L/7 A whole frame with CRC-32C; `spoil` is added to the CRC.
pub fn frame_crc32c(dst: u8, src: u8, payload: &[u8], spoil: u32) -> Vec<u8> {
    let mut body = vec![dst, src];
    body.extend_from_slice(payload);
    let crc = crc32c(&body).wrapping_add(spoil);
    body.extend_from_slice(&crc.to_le_bytes());
    [&[0xFF, END][..], &MARK, &escaped(&body), &[END]].concat()
}

/// §L/7 Decodes the bytes between the two C0 of a frame with CRC-32C; `None` when they are not such
/// a frame.
pub fn decode_crc32c(raw: &[u8]) -> Option<(u8, u8, Vec<u8>)> {
    let body = unescaped(raw.strip_prefix(&MARK)?)?;
    let (rest, sum) = body.split_at_checked(body.len().checked_sub(4)?)?;
    let [dst, src, payload @ ..] = rest else { return None };
    (crc32c(rest).to_le_bytes() == sum).then(|| (*dst, *src, payload.to_vec()))
}

/// A whole frame.
pub fn frame(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    wire(&body(dst, src, payload))
}

/// A frame, or bytes that are not a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Incoming {
    /// A frame with a correct CRC.
    Frame {
        /// Address of the receiver.
        dst: u8,
        /// Address of the sender.
        src: u8,
        /// Its records.
        payload: Vec<u8>,
    },
    /// Bytes between two C0 that are not a frame: a wrong CRC or escape.
    Broken(Vec<u8>),
}

impl Incoming {
    /// Addresses and payload, or the bytes, as text.
    pub fn words(&self) -> String {
        match self {
            Self::Frame { dst, src, payload } if payload.is_empty() => {
                format!("dst {dst}, src {src}")
            }
            Self::Frame { dst, src, payload } => format!("dst {dst}, src {src}: {}", hex(payload)),
            Self::Broken(raw) => hex(raw),
        }
    }
}

/// Splits a stream of bytes into frames.
#[derive(Clone, Debug, Default)]
pub struct Splitter {
    raw: Vec<u8>,
    open: bool,
}

impl Splitter {
    /// Takes a byte; returns what it completes.
    pub fn push(&mut self, byte: u8) -> Option<Incoming> {
        if byte != END {
            if self.open && self.raw.len() < BODY_MAX {
                self.raw.push(byte);
            }
            return None;
        }
        let raw = std::mem::take(&mut self.raw);
        if !self.open || raw.len() < BODY_MIN {
            self.open = true;
            return None;
        }
        let incoming = decode(&raw).unwrap_or(Incoming::Broken(raw));
        // The C0 that ends an invalid frame may start the next one.
        self.open = matches!(incoming, Incoming::Broken(_));
        Some(incoming)
    }
}

fn unescaped(raw: &[u8]) -> Option<Vec<u8>> {
    let mut body = Vec::with_capacity(raw.len());
    let mut bytes = raw.iter();
    while let Some(byte) = bytes.next() {
        body.push(match *byte {
            ESC => match *bytes.next()? {
                ESC_END => END,
                ESC_ESC => ESC,
                _ => return None,
            },
            byte => byte,
        });
    }
    Some(body)
}

fn decode(raw: &[u8]) -> Option<Incoming> {
    let body = unescaped(raw)?;
    let (rest, sum) = body.split_at_checked(body.len().checked_sub(2)?)?;
    let [dst, src, payload @ ..] = rest else { return None };
    (crc(rest).to_le_bytes() == sum).then(|| Incoming::Frame {
        dst: *dst,
        src: *src,
        payload: payload.to_vec(),
    })
}

/// A record (§2).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rec {
    /// Request id.
    pub request: RequestId,
    /// Addressee, or the subsystem that answers.
    pub device: SubsystemId,
    /// Status of an answer; 0 in a request.
    pub status: Status,
    /// Data of the record.
    pub data: Vec<u8>,
}

impl Rec {
    /// A request, with status 0.
    pub fn new(request: RequestId, device: SubsystemId, data: &[u8]) -> Self {
        Self { request, device, status: Status::OK, data: data.to_vec() }
    }

    /// The record as bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let size = u8::try_from(self.data.len()).unwrap_or(u8::MAX);
        let mut bytes = vec![self.request.0, self.device.0, self.status.0, size];
        bytes.extend_from_slice(&self.data);
        bytes
    }

    /// The records of a payload; `None` when the last is cut short.
    pub fn all(payload: &[u8]) -> Option<Vec<Self>> {
        let (mut records, mut rest) = (Vec::new(), payload);
        while !rest.is_empty() {
            let (header, tail) = rest.split_at_checked(4)?;
            let (data, tail) = tail.split_at_checked(usize::from(header[3]))?;
            records.push(Self {
                request: RequestId(header[0]),
                device: SubsystemId(header[1]),
                status: Status(header[2]),
                data: data.to_vec(),
            });
            rest = tail;
        }
        Some(records)
    }

    /// Request, subsystem, status and data, as text.
    pub fn words(&self, answer: bool) -> String {
        let request = name(self.request.name(), self.request.0);
        let device = name(self.device.name(), self.device.0);
        let data = match (self.data.is_empty(), self.values().filter(|_| answer)) {
            (true, _) => String::new(),
            (false, Some(values)) => format!(" {values} [{}]", hex(&self.data)),
            (false, None) => format!(" {}", hex(&self.data)),
        };
        if !answer {
            return format!("{request} → {device}{data}");
        }
        let status = name(self.status.name(), self.status.0);
        format!("{request} ← {device}: {status}{data}")
    }

    /// The data of an answer with their units; `None` if the protocol does not know them.
    fn values(&self) -> Option<String> {
        let Self { request, device, status, data } = self;
        let record = Record { request: *request, device: *device, status: *status, data };
        Answer::decode(&record).ok().filter(|answer| !matches!(answer.data, Reply::Raw(_)))?;
        let text = AnswerText(record).to_string();
        text.split_once(": ").map(|(_, values)| values.to_owned())
    }

    /// First word of the data: the flags of a status.
    pub fn flags(&self) -> Option<u32> {
        self.data.first_chunk().map(|bytes| u32::from_le_bytes(*bytes))
    }

    /// A 16-bit field of the data.
    pub fn i16_at(&self, at: usize) -> Option<i16> {
        Some(i16::from_le_bytes(self.data.get(at..at + 2)?.try_into().ok()?))
    }

    /// A 32-bit field of the data.
    pub fn i32_at(&self, at: usize) -> Option<i32> {
        Some(i32::from_le_bytes(self.data.get(at..at + 4)?.try_into().ok()?))
    }
}

/// A name, or the number if there is none.
pub fn name(name: Option<&str>, number: u8) -> String {
    name.map_or_else(|| format!("0x{number:02X}"), str::to_owned)
}

/// Several values as a list, as text.
pub fn several<T: ToString>(all: &[T]) -> String {
    match all {
        [] => "—".to_owned(),
        all => all.iter().map(T::to_string).collect::<Vec<_>>().join(" "),
    }
}

/// Frames, as text.
pub fn frames(all: &[Incoming]) -> String {
    match all {
        [] => "—".to_owned(),
        all => all.iter().map(Incoming::words).collect::<Vec<_>>().join("; "),
    }
}

/// Limits of a drive, with their unit.
pub fn range(drive: SubsystemId, (min, max): (i32, i32)) -> String {
    let unit = if drive == SubsystemId::NOZZLE { " mm" } else { "'" };
    format!("{min}{unit} … {max}{unit}")
}

/// Bytes in hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_shown_with_values_and_units() {
        let limits = Rec {
            request: RequestId::RETRIEVE_LIMITS,
            device: SubsystemId::HORIZONTAL,
            status: Status::OK,
            data: vec![0x30, 0x2A, 0, 0, 0xD0, 0xD5, 0xFF, 0xFF],
        };
        let words = limits.words(true);
        assert!(words.contains("10800'") && words.contains("-10800'"), "{words}");
        assert!(words.ends_with("[30 2A 00 00 D0 D5 FF FF]"), "{words}");
        let cut = Rec { data: vec![0x30, 0x2A], ..limits };
        assert!(cut.words(true).ends_with("Ok 30 2A"), "{}", cut.words(true));
        assert_eq!(range(SubsystemId::NOZZLE, (0, 60)), "0 mm … 60 mm");
        assert_eq!((several::<i32>(&[]), several(&[1, 2])), ("—".to_owned(), "1 2".to_owned()));
    }

    fn split(bytes: &[u8]) -> Vec<Incoming> {
        let mut splitter = Splitter::default();
        bytes.iter().filter_map(|byte| splitter.push(*byte)).collect()
    }

    /// §L/2 the published check value; §L/1 the escapes, byte by byte.
    #[test]
    fn frames_are_the_observed_ones() {
        assert_eq!(crc(b"123456789"), 0x4B37);
        let wire = frame(1, 0x81, &[0xC0, 0xDB]);
        assert_eq!(&wire[..8], &[0xFF, 0xC0, 0x01, 0x81, 0xDB, 0xDC, 0xDB, 0xDD]);
        assert_eq!(
            split(&wire),
            [Incoming::Frame { dst: 1, src: 0x81, payload: vec![0xC0, 0xDB] }]
        );
    }

    /// §L/7 the published check value.
    #[test]
    fn frames_with_crc32c() {
        assert_eq!(crc32c(b"123456789"), 0xE306_9283);
        let wire = frame_crc32c(1, 0x81, &[0xC0], 0);
        assert_eq!(&wire[..8], &[0xFF, 0xC0, 0xDB, 0xDE, 0x01, 0x81, 0xDB, 0xDC]);
        let raw = &wire[2..wire.len() - 1];
        assert_eq!(decode_crc32c(raw), Some((1, 0x81, vec![0xC0])));
        assert_eq!(split(&wire), [Incoming::Broken(raw.to_vec())]);
        let spoilt = frame_crc32c(1, 0x81, &[0xC0], 1);
        assert_eq!(decode_crc32c(&spoilt[2..spoilt.len() - 1]), None);
    }

    #[test]
    fn what_is_no_frame_is_kept_apart() {
        let mut wire = frame(1, 0x81, &[1, 2, 3, 0]);
        wire[4] ^= 1;
        let mut both = wire.clone();
        both.extend_from_slice(&frame(1, 0x81, &[]));
        let found = split(&both);
        assert!(matches!(found[0], Incoming::Broken(_)));
        assert_eq!(found[1], Incoming::Frame { dst: 1, src: 0x81, payload: Vec::new() });
        assert_eq!(split(&[0xC0, 0xC0, 1, 0xC0]), []);
    }

    #[test]
    fn frames_are_shown_as_addresses_and_bytes() {
        let frame = |payload: &[u8]| Incoming::Frame { dst: 129, src: 1, payload: payload.into() };
        let all = [frame(&[]), frame(&[0xFA, 0x34]), Incoming::Broken(vec![1, 0xDB])];
        assert_eq!(frames(&all), "dst 129, src 1; dst 129, src 1: FA 34; 01 DB");
        assert_eq!(frames(&[]), "—");
    }

    #[test]
    fn records_cut_short_are_none() {
        let record = Rec::new(RequestId::MOVE, SubsystemId::VERTICAL, &[1, 2]);
        assert_eq!(Rec::all(&record.bytes()), Some(vec![record.clone()]));
        assert_eq!(Rec::all(&record.bytes()[..5]), None);
        assert_eq!(Rec::all(&record.bytes()[..3]), None);
    }
}
