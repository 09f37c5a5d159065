//! The controller's journal (§B/1 GetLog): every control request with its time, s.

use std::collections::VecDeque;

use lafet_proto::bus::LogLine;
use lafet_proto::record::{Data, NoRoom, Record, Records, Writer};
use lafet_proto::{RequestId, Status, SubsystemId};

/// Lines that are kept; the oldest are dropped.
const LINES_MAX: usize = 4096;

/// A control request in the journal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Unix time, s.
    pub time_s: u32,
    /// Address of the monitor.
    pub dst: u8,
    /// Address of the sender.
    pub src: u8,
    /// The request.
    pub request: RequestId,
    /// The addressee.
    pub device: SubsystemId,
    /// The data of the request.
    pub data: Vec<u8>,
}

/// The journal of a bus controller.
#[derive(Clone, Debug, Default)]
pub struct Journal {
    lines: VecDeque<Entry>,
    dropped: u64,
}

impl Journal {
    /// The lines, the oldest first.
    pub fn lines(&self) -> impl Iterator<Item = &Entry> {
        self.lines.iter()
    }

    /// Number of lines that were dropped.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Records the control requests of a frame.
    pub fn note(&mut self, time_s: u32, dst: u8, src: u8, payload: &[u8]) {
        for record in Records::new(payload).map_while(Result::ok) {
            if !is_control(record.request) {
                continue;
            }
            if self.lines.len() == LINES_MAX {
                self.lines.pop_front();
                self.dropped += 1;
            }
            let Record { request, device, data, .. } = record;
            self.lines.push_back(Entry { time_s, dst, src, request, device, data: data.to_vec() });
        }
    }

    /// The answer to GetLog: the lines asked for, as many as fit a record. Line 0 is the oldest
    /// line kept.
    ///
    /// # Errors
    ///
    /// [`NoRoom`], and nothing is written, when the record does not fit what is left of `out`.
    pub fn answer(&self, first: u16, count: u16, out: &mut Writer<'_>) -> Result<(), NoRoom> {
        let asked = self.lines.iter().skip(first.into()).take(count.into());
        let mut room = usize::from(u8::MAX) - RANGE;
        let lines: Vec<&Entry> = asked
            .take_while(|line| {
                let left = room.checked_sub(LINE + line.data.len());
                room = left.unwrap_or(0);
                left.is_some()
            })
            .collect();
        out.push_with(RequestId::GET_LOG, SubsystemId::GENERAL, Status::OK, |data| {
            data.put(&first.to_le_bytes())?;
            data.put(&(lines.len() as u16).to_le_bytes())?;
            lines.iter().try_for_each(|line| put(line, data))
        })
    }
}

/// Bytes of the range before the lines.
const RANGE: usize = 4;
/// Bytes of a line without the data of its record: time, dst, src, header.
const LINE: usize = 4 + 2 + 4;

fn put(line: &Entry, data: &mut Data<'_>) -> Result<(), NoRoom> {
    let Entry { time_s, dst, src, request, device, data: bytes } = line;
    let record = Record { request: *request, device: *device, status: Status::OK, data: bytes };
    LogLine { time_s: *time_s, dst: *dst, src: *src, record }.encode(data)
}

/// Whether a request changes something: all except reads.
const fn is_control(request: RequestId) -> bool {
    !request.is_read() && !matches!(request, RequestId::ACCESS_GRANTED)
}
