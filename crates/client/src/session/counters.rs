//! Counters of a session, and the record of a frame.

use std::sync::Arc;
use std::time::Duration;

/// Counters since the session was created.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Stats {
    /// Frames sent, with repetitions.
    pub frames_sent: u64,
    /// Frames received without errors, from any sender.
    pub frames_received: u64,
    /// Frames accepted as answers.
    pub believed: u64,
    /// Frames dropped because of their CRC.
    pub crc_errors: u64,
    /// Frames dropped because of a wrong escape, their length, or a missing end.
    pub framing_errors: u64,
    /// Frames sent again.
    pub retries: u64,
    /// Frames without answer in time.
    pub timeouts: u64,
    /// Answers that came too late.
    pub late: u64,
    /// Answers that came twice.
    pub duplicates: u64,
    /// Frames from or to another device.
    pub foreign: u64,
    /// Frames from the monitor that answer no request of this program.
    pub unmatched: u64,
    /// Times the connection was reopened.
    pub reconnects: u64,
    /// Frames whose echo differed: a collision (`echo=verify`).
    pub collisions: u64,
    /// Frames whose echo did not come (`echo=verify`).
    pub echoes_missing: u64,
    /// Monitors with which frames have a CRC-32C at present (`check=`).
    pub crc32c: u32,
    /// Round trip of the last frame that was answered at the first try.
    pub rtt_last: Option<Duration>,
    /// The shortest round trip.
    pub rtt_min: Option<Duration>,
    /// The longest round trip.
    pub rtt_max: Option<Duration>,
    /// Running average of the round trip with a weight of 1/8 for each new one (as in TCP).
    pub rtt_average: Option<Duration>,
}

impl Stats {
    /// Received frames that were not accepted.
    pub const fn strays(&self) -> u64 {
        self.late + self.duplicates + self.foreign + self.unmatched
    }

    /// The sum of the counts of two sessions; round trips are those of `self`.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            frames_sent: self.frames_sent + other.frames_sent,
            frames_received: self.frames_received + other.frames_received,
            believed: self.believed + other.believed,
            crc_errors: self.crc_errors + other.crc_errors,
            framing_errors: self.framing_errors + other.framing_errors,
            retries: self.retries + other.retries,
            timeouts: self.timeouts + other.timeouts,
            late: self.late + other.late,
            duplicates: self.duplicates + other.duplicates,
            foreign: self.foreign + other.foreign,
            unmatched: self.unmatched + other.unmatched,
            reconnects: self.reconnects + other.reconnects,
            collisions: self.collisions + other.collisions,
            echoes_missing: self.echoes_missing + other.echoes_missing,
            crc32c: self.crc32c + other.crc32c,
            ..self
        }
    }

    pub(super) fn note_rtt(&mut self, rtt: Duration) {
        self.rtt_last = Some(rtt);
        self.rtt_min = Some(self.rtt_min.map_or(rtt, |min| min.min(rtt)));
        self.rtt_max = Some(self.rtt_max.map_or(rtt, |max| max.max(rtt)));
        self.rtt_average = Some(self.rtt_average.map_or(rtt, |average| (average * 7 + rtt) / 8));
    }

    pub(super) fn count(&mut self, verdict: Verdict) -> &mut u64 {
        match verdict {
            Verdict::Sent => &mut self.frames_sent,
            Verdict::Believed => &mut self.believed,
            Verdict::Late => &mut self.late,
            Verdict::Duplicate => &mut self.duplicates,
            Verdict::Foreign => &mut self.foreign,
            Verdict::Unmatched => &mut self.unmatched,
        }
    }
}

/// Direction of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// To the monitor.
    Sent,
    /// From the link.
    Received,
}

/// Classification of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Verdict {
    /// Sent by this side.
    Sent,
    /// The answer to the outstanding operation.
    Believed,
    /// An answer that came too late.
    Late,
    /// A duplicate of an answer.
    Duplicate,
    /// From or to another device.
    Foreign,
    /// From the monitor, but not the answer to any request of this program.
    Unmatched,
}

/// A frame that was sent or received.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Traced {
    /// Its classification.
    pub verdict: Verdict,
    /// Receiver.
    pub dst: u8,
    /// Sender.
    pub src: u8,
    /// Whether the frame was numbered because a late answer could be taken for its own.
    pub tagged: bool,
    /// The records, without the tag.
    pub payload: Arc<[u8]>,
}

impl Traced {
    /// Direction of the frame.
    pub const fn direction(&self) -> Direction {
        match self.verdict {
            Verdict::Sent => Direction::Sent,
            _ => Direction::Received,
        }
    }
}
