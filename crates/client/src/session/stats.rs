//! What a session counts, and what it shows of every frame.

use std::sync::Arc;
use std::time::Duration;

/// What a session has seen since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Stats {
    /// Frames sent, retries included.
    pub frames_sent: u64,
    /// Frames received without errors, whoever sent them.
    pub frames_received: u64,
    /// Frames that were answers to what was outstanding.
    pub believed: u64,
    /// Frames dropped because of their CRC.
    pub crc_errors: u64,
    /// Frames dropped because of a wrong escape, their length, or because they had no end.
    pub framing_errors: u64,
    /// Frames sent again.
    pub retries: u64,
    /// Times an answer did not come in time.
    pub timeouts: u64,
    /// Answers that came after their time.
    pub late: u64,
    /// Answers that came twice.
    pub duplicates: u64,
    /// Frames from or to somebody else.
    pub foreign: u64,
    /// Frames from the monitor that answer nothing that was asked.
    pub unmatched: u64,
    /// Times the connection was made again.
    pub reconnects: u64,
    /// Frames whose echo was not what was sent: two spoke at once (`echo=verify`).
    pub collisions: u64,
    /// Frames whose echo did not come (`echo=verify`).
    pub echoes_missing: u64,
    /// Monitors with which frames bear a CRC-32C now (`check=`).
    pub crc32c: u32,
    /// Round trip of the last frame that was answered at the first try.
    pub rtt_last: Option<Duration>,
    /// The shortest.
    pub rtt_min: Option<Duration>,
    /// The longest.
    pub rtt_max: Option<Duration>,
    /// A running average: an eighth of each new one (as TCP does it).
    pub rtt_average: Option<Duration>,
}

impl Stats {
    /// Frames that came and were not believed.
    pub const fn strays(&self) -> u64 {
        self.late + self.duplicates + self.foreign + self.unmatched
    }

    /// The counts of two sessions together; round trips are those of `self`.
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

/// Which way a frame went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// To the monitor.
    Sent,
    /// From the link.
    Received,
}

/// What a frame was taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Verdict {
    /// We sent it.
    Sent,
    /// The answer to what was outstanding.
    Believed,
    /// An answer that came after its time.
    Late,
    /// An answer that came twice.
    Duplicate,
    /// From or to somebody else.
    Foreign,
    /// From the monitor, but the answer to nothing that was asked.
    Unmatched,
}

/// A frame that was sent or received.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Traced {
    /// What it was taken for.
    pub verdict: Verdict,
    /// Receiver.
    pub dst: u8,
    /// Sender.
    pub src: u8,
    /// The frame was numbered because a late answer could have been taken for its own.
    pub tagged: bool,
    /// The records, without the tag.
    pub payload: Arc<[u8]>,
}

impl Traced {
    /// Which way it went.
    pub const fn direction(&self) -> Direction {
        match self.verdict {
            Verdict::Sent => Direction::Sent,
            _ => Direction::Received,
        }
    }
}
