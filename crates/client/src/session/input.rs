//! Extracts the payloads of frames from received bytes.

use lafet_proto::link::{self, BODY_MAX, Check, Decoder};
use lafet_proto::record::Records;
use lafet_proto::{Expected, Record};

use smallvec::SmallVec;

use super::Stats;
use super::late_answers::{Tag, looks_like_tag};
use super::medium::Framing;

/// Most bytes of bare records kept while the end of the answer has not come.
const RECORDS_MAX: usize = 4096;
/// Bytes of most answers of one subsystem; they need no allocation.
pub const PAYLOAD_USUAL: usize = 64;

/// Received bytes, until they form a frame.
#[derive(Debug)]
pub struct Input {
    framing: Framing,
    decoder: Box<Decoder>,
    /// Bare records.
    stream: Vec<u8>,
    datagram_errors: Stats,
    dropped: u64,
    records_frames: u64,
}

/// A frame received without errors.
#[derive(Debug)]
pub struct Incoming {
    /// Receiver and sender, if the framing has them.
    pub addresses: Option<(u8, u8)>,
    /// Its records.
    pub payload: SmallVec<[u8; PAYLOAD_USUAL]>,
    /// Its checksum.
    pub check: Check,
}

impl Input {
    pub fn new(framing: Framing) -> Self {
        Self {
            framing,
            decoder: Box::default(),
            stream: Vec::new(),
            datagram_errors: Stats::default(),
            dropped: 0,
            records_frames: 0,
        }
    }

    /// Drops bytes that do not form a frame yet.
    pub fn reset(&mut self) {
        self.decoder.reset();
        self.stream.clear();
    }

    /// Takes bytes of a stream up to the end of a frame, and returns the frame. `end`, the tag of
    /// the outstanding operation, marks the end of an answer of bare records.
    pub fn take(&mut self, bytes: &mut &[u8], end: Option<Tag>) -> Option<Incoming> {
        if self.framing == Framing::Records {
            self.stream.extend_from_slice(std::mem::take(bytes));
            return self.take_records(end);
        }
        let (taken, frame) = self.decoder.push_slice(bytes);
        *bytes = &bytes[taken..];
        let frame = frame?;
        let addresses = Some((frame.dst, frame.src));
        let payload = SmallVec::from_slice(frame.payload);
        Some(Incoming { addresses, payload, check: self.decoder.check() })
    }

    /// Takes a datagram: one frame.
    pub fn take_datagram(&mut self, datagram: &[u8]) -> Option<Incoming> {
        let mut body = [0; BODY_MAX];
        match link::decode_datagram(datagram, &mut body) {
            Ok(frame) => {
                self.datagram_errors.frames_received += 1;
                let addresses = Some((frame.dst, frame.src));
                let payload = SmallVec::from_slice(frame.payload);
                return Some(Incoming { addresses, payload, check: link::check_of(datagram) });
            }
            Err(error) if matches!(error.expected, Expected::Crc(_) | Expected::Crc32c(_)) => {
                self.datagram_errors.crc_errors += 1;
            }
            Err(_) => self.datagram_errors.framing_errors += 1,
        }
        None
    }

    fn take_records(&mut self, end: Option<Tag>) -> Option<Incoming> {
        let found = answer_range(&self.stream, end);
        let payload = match found {
            Some((start, end)) => {
                let payload = SmallVec::from_slice(self.stream.get(start..end)?);
                self.stream.drain(..end);
                payload
            }
            None if self.stream.len() > RECORDS_MAX => {
                self.dropped += 1;
                self.stream.clear();
                return None;
            }
            None => return None,
        };
        self.records_frames += 1;
        Some(Incoming { addresses: None, payload, check: Check::Crc16 })
    }

    /// Adds the counters of the decoder.
    pub fn counted(&self, stats: Stats) -> Stats {
        let counters = self.decoder.counters();
        Stats {
            frames_received: counters.frames
                + self.datagram_errors.frames_received
                + self.records_frames,
            crc_errors: counters.crc_errors + self.datagram_errors.crc_errors,
            framing_errors: counters.escape_errors
                + counters.overruns
                + counters.resyncs
                + self.datagram_errors.framing_errors
                + self.dropped,
            ..stats
        }
    }
}

/// The range of the answer that the tag ends in a stream of bare records: it starts after the last
/// complete tag before it, which ended an earlier answer.
fn answer_range(stream: &[u8], end: Option<Tag>) -> Option<(usize, usize)> {
    let tag = end?;
    let mut records = Records::new(stream);
    // The latest consecutive records that look like a tag, with their offsets.
    let mut run: Vec<(usize, Record<'_>)> = Vec::with_capacity(Tag::LEN);
    // Ends of tags of earlier answers.
    let mut ends = vec![0];
    while let Some(Ok(record)) = records.next() {
        let offset = records.offset();
        if !looks_like_tag(record.request, record.device) {
            run.clear();
            continue;
        }
        if run.len() == Tag::LEN {
            run.remove(0);
        }
        run.push((offset - record.size(), record));
        let Ok(found) = <[_; Tag::LEN]>::try_from(&run[..]) else { continue };
        let (at, _) = found[0];
        if tag.matches(&found.map(|(_, record)| record)) {
            let start = ends.into_iter().rev().find(|end| *end <= at)?;
            return Some((start, offset));
        }
        ends.push(offset);
    }
    None
}
