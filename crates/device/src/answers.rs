//! §2 NoRoom: the answer buffer, and what happens when it is full.

use lafet_proto::record::{HEADER_SIZE, Record, Writer};
use lafet_proto::{Answer, RequestId, Status, SubsystemId};

/// Kept free at the end for the two NoRoom headers.
const RESERVE: usize = 2 * HEADER_SIZE;

/// Collects the answers of one frame.
#[derive(Debug)]
pub(crate) struct Answers<'a> {
    writer: Writer<'a>,
    full: bool,
}

impl<'a> Answers<'a> {
    pub fn new(out: &'a mut [u8]) -> Self {
        let mut writer = Writer::new(out);
        writer.reserve(RESERVE);
        Self { writer, full: false }
    }

    /// Bytes written.
    pub fn len(&self) -> usize {
        self.writer.len()
    }

    /// An answer did not fit: nothing more is executed (§1/9).
    pub const fn is_full(&self) -> bool {
        self.full
    }

    /// Whether an answer with this much data would fit; otherwise says NoRoom.
    ///
    /// Asked before a request is executed: nothing is done whose answer would be lost.
    pub fn has_room(&mut self, from: SubsystemId, request: RequestId, data_size: usize) -> bool {
        if !self.full && self.writer.room() < HEADER_SIZE + data_size {
            self.no_room(from, request);
        }
        !self.full
    }

    /// Adds an answer, or says NoRoom.
    pub fn push(&mut self, answer: &Answer<'_>) {
        if !self.full && answer.encode(&mut self.writer).is_err() {
            self.no_room(answer.from, answer.request);
        }
    }

    /// Adds an answer without data, or says NoRoom.
    pub fn bare(&mut self, from: SubsystemId, request: RequestId, status: Status) {
        if !self.full && self.writer.push(&bare(from, request, status)).is_err() {
            self.no_room(from, request);
        }
    }

    #[cold]
    fn no_room(&mut self, from: SubsystemId, request: RequestId) {
        self.full = true;
        self.writer.reserve(0);
        for id in [from, SubsystemId::GENERAL] {
            // The reserve holds both; a buffer smaller than that holds what it can.
            let _ = self.writer.push(&bare(id, request, Status::NO_ROOM));
        }
    }
}

const fn bare(device: SubsystemId, request: RequestId, status: Status) -> Record<'static> {
    Record { request, device, status, data: &[] }
}
