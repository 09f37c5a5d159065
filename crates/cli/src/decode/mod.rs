//! Decodes captured bytes to text: frames, their records, and errors between them.

mod unhex;

use std::collections::HashMap;
use std::io::{self, Write};

use lafet_proto::bus::{CONTROLLER, MONITORS};
use lafet_proto::link::{Counters, Decoder, Frame};
use lafet_proto::record::Records;
use lafet_proto::text::{AnswerText, Exchange, RequestText};
use lafet_proto::{Answer, Record, Request, RequestId, SubsystemId};
use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};

use crate::describe::hex;
use crate::lang::current;
use crate::texts;
pub use unhex::Unhex;

/// Pairs of addresses whose last requests are kept; no bus has more.
const PAIRS_MAX: usize = 4096;

/// Form of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// One line per record.
    Text,
    /// One object per frame.
    Json,
    /// Only the counters.
    Nothing,
}

/// Decodes bytes and writes the result.
pub struct Writer<W: Write> {
    out: W,
    form: Form,
    decoder: Box<Decoder>,
    offset: u64,
    requests: HashMap<(u8, u8), Vec<(RequestId, SubsystemId)>>,
    records: u64,
    malformed: u64,
}

/// Direction of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Request,
    Answer,
}

impl<W: Write> Writer<W> {
    /// A decoder that writes to `out`.
    pub fn new(out: W, form: Form) -> Self {
        Self {
            out,
            form,
            decoder: Box::new(Decoder::new()),
            offset: 0,
            requests: HashMap::new(),
            records: 0,
            malformed: 0,
        }
    }

    /// Number of valid frames so far.
    pub fn frames(&self) -> u64 {
        self.decoder.counters().frames
    }

    /// Number of bytes so far.
    pub const fn bytes(&self) -> u64 {
        self.offset
    }

    /// Decodes more bytes.
    pub fn feed(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut rest = bytes;
        while !rest.is_empty() {
            let before = *self.decoder.counters();
            let (taken, frame) = self.decoder.push_slice(rest);
            rest = &rest[taken..];
            self.offset += taken as u64;
            let mut body = [0; lafet_proto::link::PAYLOAD_MAX];
            let frame = frame.map(|frame| {
                let payload = &mut body[..frame.payload.len()];
                payload.copy_from_slice(frame.payload);
                Frame { dst: frame.dst, src: frame.src, payload: &*payload }
            });
            let after = *self.decoder.counters();
            if errors(&before) != errors(&after) {
                self.trouble(&before, &after)?;
            }
            if let Some(frame) = frame {
                self.frame(&frame)?;
            }
        }
        Ok(())
    }

    /// Tries to decode bytes without frames as bare records; returns whether they are.
    pub fn bare_records(&mut self, bytes: &[u8]) -> io::Result<bool> {
        let records: Result<Vec<Record<'_>>, _> = Records::new(bytes).collect();
        let Ok(records) = records else { return Ok(false) };
        for record in &records {
            let request = record.status.0 == 0 && Request::decode(record).is_ok();
            let way = if request { Way::Request } else { Way::Answer };
            match self.form {
                Form::Nothing => {}
                Form::Text => writeln!(self.out, "{}", Shown { record, way, to: None })?,
                Form::Json => writeln!(self.out, "{}", record_json(record, way, None))?,
            }
        }
        self.records += records.len() as u64;
        self.offset = bytes.len() as u64;
        Ok(!records.is_empty())
    }

    /// Writes the buffered output.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    /// Flushes, and returns the counters.
    pub fn finish(mut self) -> io::Result<Summary> {
        self.flush()?;
        Ok(Summary {
            bytes: self.offset,
            counters: *self.decoder.counters(),
            records: self.records,
            malformed: self.malformed,
        })
    }

    fn frame(&mut self, frame: &Frame<'_>) -> io::Result<()> {
        let way = way(frame, &self.requests);
        if way == Way::Request {
            self.remember(frame);
        }
        match self.form {
            Form::Nothing => {
                self.records += Records::new(frame.payload).flatten().count() as u64;
                Ok(())
            }
            Form::Text => self.frame_text(frame, way),
            Form::Json => self.frame_json(frame, way),
        }
    }

    fn remember(&mut self, frame: &Frame<'_>) {
        let pair = (frame.dst, frame.src);
        if self.requests.len() >= PAIRS_MAX && !self.requests.contains_key(&pair) {
            return;
        }
        let asked = self.requests.entry(pair).or_default();
        asked.clear();
        let records = Records::new(frame.payload).flatten();
        asked.extend(records.map(|record| (record.request, record.device)));
    }

    /// The subsystem addressed by the request that this record answers.
    fn addressee(&self, frame: &Frame<'_>, record: &Record<'_>) -> Option<SubsystemId> {
        let asked = self.requests.get(&(frame.src, frame.dst))?;
        let same = asked.iter().filter(|(request, _)| *request == record.request);
        let exact = same.clone().find(|(_, to)| *to == record.device);
        exact.or_else(|| same.clone().next()).map(|(_, to)| *to)
    }

    fn frame_text(&mut self, frame: &Frame<'_>, way: Way) -> io::Result<()> {
        let Frame { dst, src, payload } = *frame;
        if frame.is_probe() {
            return writeln!(self.out, "{src:>3} → {dst:<3}  {}", text::ProbeFrame.str(current()));
        }
        for record in Records::new(payload) {
            match record {
                Ok(record) => {
                    self.records += 1;
                    let to = self.addressee(frame, &record);
                    let shown = Shown { record: &record, way, to };
                    writeln!(self.out, "{src:>3} → {dst:<3}  {shown}")?;
                }
                Err(error) => {
                    self.malformed += 1;
                    let error = texts::decode_error(&error);
                    let what = text::RecordCutShort.str(current());
                    writeln!(self.out, "{src:>3} → {dst:<3}  # {what}: {error}")?;
                }
            }
        }
        Ok(())
    }

    fn frame_json(&mut self, frame: &Frame<'_>, way: Way) -> io::Result<()> {
        let Frame { dst, src, payload } = *frame;
        let mut records = Vec::new();
        let mut error = None;
        for record in Records::new(payload) {
            match record {
                Ok(record) => {
                    self.records += 1;
                    let to = self.addressee(frame, &record).filter(|_| way == Way::Answer);
                    records.push(record_json(&record, way, to));
                }
                Err(cut) => {
                    self.malformed += 1;
                    error = Some(texts::decode_error(&cut));
                }
            }
        }
        let kind = match way {
            _ if frame.is_probe() => "probe",
            Way::Request => "request",
            Way::Answer => "answer",
        };
        let json = json!({
            "end": self.offset,
            "src": src,
            "dst": dst,
            "kind": kind,
            "records": records,
            "error": error,
        });
        writeln!(self.out, "{json}")
    }

    fn trouble(&mut self, before: &Counters, after: &Counters) -> io::Result<()> {
        let offset = self.offset;
        let skipped = after.bytes_skipped - before.bytes_skipped;
        match self.form {
            Form::Nothing => Ok(()),
            Form::Json => {
                let json = json!({
                    "before": offset,
                    "kind": "noise",
                    "bytes_skipped": skipped,
                    "crc_errors": after.crc_errors - before.crc_errors,
                    "escape_errors": after.escape_errors - before.escape_errors,
                    "overruns": after.overruns - before.overruns,
                    "resyncs": after.resyncs - before.resyncs,
                });
                writeln!(self.out, "{json}")
            }
            Form::Text => {
                let why = reasons(before, after);
                let place = text::BeforeByte.str(current());
                let skip = text::CountSkipped.str(current());
                writeln!(self.out, "# {place} {offset}: {skip}: {skipped}{why}")
            }
        }
    }
}

impl Writer<Vec<u8>> {
    /// Takes the output written since the last call.
    pub fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }
}

const fn errors(counters: &Counters) -> (u64, u64) {
    let Counters { crc_errors, escape_errors, overruns, resyncs, bytes_skipped, .. } = *counters;
    (bytes_skipped, crc_errors + escape_errors + overruns + resyncs)
}

fn reasons(before: &Counters, after: &Counters) -> String {
    let all = [
        (after.crc_errors - before.crc_errors, text::CountCrc.str(current())),
        (after.escape_errors - before.escape_errors, text::CountEscapes.str(current())),
        (after.overruns - before.overruns, text::CountTooLong.str(current())),
        (after.resyncs - before.resyncs, text::CountCutShort.str(current())),
    ];
    all.iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, name)| format!(", {name}: {count}"))
        .collect()
}

/// Direction of a frame: requests go to a monitor, answers come from it; between controller and
/// consoles it depends on what was requested.
fn way(frame: &Frame<'_>, asked: &HashMap<(u8, u8), Vec<(RequestId, SubsystemId)>>) -> Way {
    let Frame { dst, src, payload } = *frame;
    if MONITORS.contains(&src) {
        return Way::Answer;
    }
    if MONITORS.contains(&dst) || dst == CONTROLLER {
        return Way::Request;
    }
    let first = Records::new(payload).flatten().next();
    let known = asked.get(&(src, dst)).zip(first);
    match known {
        Some((asked, first)) if asked.iter().any(|(id, _)| *id == first.request) => Way::Answer,
        _ => Way::Request,
    }
}

/// Displays a record as text.
struct Shown<'a> {
    record: &'a Record<'a>,
    way: Way,
    to: Option<SubsystemId>,
}

impl std::fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.way, self.to) {
            (Way::Request, _) => RequestText(*self.record).fmt(f),
            (Way::Answer, Some(to)) if let Ok(answer) = Answer::decode(self.record) => {
                Exchange { to, answer }.fmt(f)
            }
            (Way::Answer, _) => AnswerText(*self.record).fmt(f),
        }
    }
}

fn record_json(record: &Record<'_>, way: Way, to: Option<SubsystemId>) -> Value {
    let mut json = json!({
        "request": crate::exchange::name(record.request),
        "device": record.device.to_string(),
        "data": hex(record.data),
        "text": Shown { record, way, to }.to_string(),
    });
    if way == Way::Answer {
        json["status"] = json!(record.status.to_string());
    }
    json
}

/// Counters of a capture.
#[derive(Clone, Copy, Debug)]
pub struct Summary {
    bytes: u64,
    counters: Counters,
    records: u64,
    malformed: u64,
}

impl Summary {
    /// The counters as text.
    pub fn text(&self) -> String {
        let Counters { frames, bytes_skipped, .. } = self.counters;
        let Self { bytes, records, malformed, .. } = *self;
        let why = reasons(&Counters::default(), &self.counters);
        text::DecodeSummary { bytes, frames, records, malformed, bytes_skipped, why }.of(current())
    }

    /// The counters as JSON.
    pub fn json(&self) -> Value {
        let counters = self.counters;
        json!({
            "summary": {
                "bytes": self.bytes,
                "frames": counters.frames,
                "records": self.records,
                "malformed": self.malformed,
                "crc_errors": counters.crc_errors,
                "escape_errors": counters.escape_errors,
                "overruns": counters.overruns,
                "resyncs": counters.resyncs,
                "bytes_skipped": counters.bytes_skipped,
            }
        })
    }
}
