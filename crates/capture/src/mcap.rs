//! MCAP: the raw frames, and their contents as JSON with schemas.
//!
//! Topics: `/frames` (the raw bytes, from which a recording is replayed), `/monitor/A/S` (states of
//! subsystem S of the monitor at address A, in SI or customary units), `/monitor/A/log` (requests
//! and answers as text), `/note/…` (remarks beside the traffic, as JSON).

use std::collections::{BTreeMap, HashMap};
use std::io::{self, Read, Write};

use ::mcap::parse_record;
use ::mcap::records::{MessageHeader, Record};
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{Compression, McapError, WriteOptions};
use lafet_proto::bus::MONITORS;
use lafet_proto::link::{Decoder, Frame};

use crate::messages::{self, Message, Schema};
use crate::read::ReadError;
use crate::whole::{End, Medium, Whole};
use crate::{Captured, Direction, Note, Piece};

/// Topic of the raw frames.
const FRAMES: &str = "/frames";
/// Encoding of their messages: a byte for the direction, then the bytes.
const ENCODING: &str = "lafet";
/// Prefix of the topics of notes.
const NOTE: &str = "/note/";
/// A chunk is closed at this size, or when the recorder flushes.
const CHUNK: u64 = 256 * 1024;
/// Longest record that is read, bytes; most channels of a file; bytes read at once.
const RECORD_MAX: usize = 4 << 20;
const CHANNELS_MAX: usize = 10_000;
const PART: usize = 64 * 1024;

/// Writes MCAP.
pub struct Writer<W: Medium> {
    out: ::mcap::Writer<Whole<W>>,
    /// Bytes of messages since the last flush.
    since: u64,
    frames: u16,
    schemas: HashMap<&'static str, u16>,
    channels: HashMap<String, u16>,
    sequence: u32,
}

impl<W: Medium> Writer<W> {
    pub fn new(out: W) -> io::Result<Self> {
        let options = WriteOptions::new()
            .compression(Some(Compression::Zstd))
            .chunk_size(Some(CHUNK))
            // A hub writes sixteen recordings at a time: threads or a window of megabytes are too much
            // for chunks of this size.
            .compression_threads(0)
            .compression_level(1)
            // Chunks are built in memory, so that the file receives them whole.
            .disable_seeking(true)
            .profile("")
            .library(concat!("lafet ", env!("CARGO_PKG_VERSION")));
        let mut out = options.create(Whole::new(out, End::Mcap)).map_err(to_io)?;
        let about = BTreeMap::from([(
            "about".to_owned(),
            "direction (0 heard, 1 to a monitor, 2 from a monitor), then bytes of the wire".into(),
        )]);
        let frames = out.add_channel(0, FRAMES, ENCODING, &about).map_err(to_io)?;
        let (schemas, channels) = Default::default();
        out.flush().map_err(to_io)?;
        Ok(Self { out, since: 0, frames, schemas, channels, sequence: 0 })
    }

    pub fn write(&mut self, captured: &Captured) -> io::Result<()> {
        let mut data = vec![captured.direction as u8];
        data.extend_from_slice(&captured.bytes);
        self.message(self.frames, captured.at_ns, &data)?;
        let mut decoder: Box<Decoder> = Box::default();
        let mut rest = &captured.bytes[..];
        while !rest.is_empty() {
            let (taken, frame) = decoder.push_slice(rest);
            if let Some(frame) = frame {
                let Some(address) = monitor_of(&frame) else { break };
                for Message { topic, schema, json } in messages::of_frame(&frame, captured.at_ns) {
                    let topic = format!("/monitor/{address}/{topic}");
                    let channel = self.channel(topic, &schema)?;
                    self.message(channel, captured.at_ns, json.to_string().as_bytes())?;
                }
            }
            rest = &rest[taken..];
        }
        Ok(())
    }

    pub fn note(&mut self, note: &Note) -> io::Result<()> {
        let any = Schema { name: "lafet.Note", json: serde_json::json!({ "type": "object" }) };
        let channel = self.channel(format!("{NOTE}{}", note.topic), &any)?;
        self.message(channel, note.at_ns, note.json.as_bytes())
    }

    fn channel(&mut self, topic: String, schema: &Schema) -> io::Result<u16> {
        if let Some(channel) = self.channels.get(&topic) {
            return Ok(*channel);
        }
        let schema_id = match self.schemas.get(schema.name) {
            Some(id) => *id,
            None => {
                let text = schema.json.to_string();
                let id = self.out.add_schema(schema.name, "jsonschema", text.as_bytes());
                *self.schemas.entry(schema.name).or_insert(id.map_err(to_io)?)
            }
        };
        let channel = self.out.add_channel(schema_id, &topic, "json", &BTreeMap::new());
        Ok(*self.channels.entry(topic).or_insert(channel.map_err(to_io)?))
    }

    fn message(&mut self, channel_id: u16, at_ns: u64, data: &[u8]) -> io::Result<()> {
        self.sequence = self.sequence.wrapping_add(1);
        let sequence = self.sequence;
        let header = MessageHeader { channel_id, sequence, log_time: at_ns, publish_time: at_ns };
        self.out.write_to_known_channel(&header, data).map_err(to_io)?;
        self.since += data.len() as u64;
        // A caller that never flushes must not fill the memory.
        if self.since > CHUNK { self.flush() } else { Ok(()) }
    }

    pub fn flush(&mut self) -> io::Result<()> {
        self.since = 0;
        self.out.flush().map_err(to_io)
    }

    pub fn finish(mut self) -> io::Result<()> {
        self.out.finish().map_err(to_io)?;
        self.out.into_inner().flush()
    }
}

/// Address of the monitor that a frame comes from or goes to.
fn monitor_of(frame: &Frame<'_>) -> Option<u8> {
    [frame.src, frame.dst].into_iter().find(|address| MONITORS.contains(address))
}

/// Reads the frames and notes of MCAP, one at a time; `take` returns whether to continue.
pub fn read(
    mut file: impl Read,
    unpacked_max: u64,
    mut take: impl FnMut(Piece) -> bool,
) -> Result<(), ReadError> {
    let options = LinearReaderOptions::default()
        .with_skip_end_magic(true)
        .with_record_length_limit(RECORD_MAX);
    let mut reader = LinearReader::new_with_options(options);
    let mut channels: HashMap<u16, Kind> = HashMap::new();
    let (mut taken, mut others, mut unpacked) = (0, 0, 0);
    while let Some(event) = reader.next_event() {
        let (opcode, data) = match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let read = file.read(reader.insert(wanted.min(PART)))?;
                reader.notify_read(read);
                continue;
            }
            Ok(LinearReadEvent::Record { opcode, data }) => (opcode, data),
            // A recording cut short by the end of the recorder is read up to the last complete
            // record.
            Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) => break,
            Err(error) => return Err(damaged(error)),
        };
        unpacked += data.len() as u64;
        if unpacked > unpacked_max {
            return Err(ReadError::TooLarge { most: unpacked_max });
        }
        match parse_record(opcode, data).map_err(damaged)? {
            Record::Channel(channel) if channels.len() < CHANNELS_MAX => {
                let note = channel.topic.strip_prefix(NOTE).map(|it| Kind::Note(it.to_owned()));
                let frames = channel.topic == FRAMES && channel.message_encoding == ENCODING;
                let kind = note.unwrap_or(if frames { Kind::Frames } else { Kind::Other });
                channels.insert(channel.id, kind);
            }
            Record::Message { header, data } => {
                let at_ns = header.log_time;
                let goes_on = match (channels.get(&header.channel_id), data.split_first()) {
                    (Some(Kind::Note(topic)), _) => take(Piece::Note(Note {
                        at_ns,
                        topic: topic.clone(),
                        json: String::from_utf8_lossy(&data).into_owned(),
                    })),
                    (Some(Kind::Frames), Some((direction, bytes))) => {
                        taken += 1;
                        let (direction, bytes) = (direction_of(*direction), bytes.to_vec());
                        take(Piece::Captured(Captured { at_ns, direction, bytes }))
                    }
                    (Some(Kind::Frames), None) => true,
                    _ => {
                        others += 1;
                        true
                    }
                };
                if !goes_on {
                    return Ok(());
                }
            }
            _ => {}
        }
    }
    if taken == 0 && others > 0 { Err(ReadError::NoFrames) } else { Ok(()) }
}

/// Content of a channel.
enum Kind {
    Frames,
    Note(String),
    Other,
}

const fn direction_of(byte: u8) -> Direction {
    match byte {
        1 => Direction::ToMonitor,
        2 => Direction::FromMonitor,
        _ => Direction::Heard,
    }
}

fn damaged(error: McapError) -> ReadError {
    ReadError::Damaged(error.to_string())
}

fn to_io(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
