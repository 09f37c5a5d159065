//! The echo of an RS-485 line: a transceiver may receive what it sends.
//!
//! Received bytes are compared with the bytes sent. While they are equal, they are the echo and are
//! removed. From the first byte that differs, all bytes go to the decoder: they may be an answer on
//! a line without echo, or the remains of a collision, which no CRC accepts.

use std::borrow::Cow;
use std::collections::VecDeque;

use super::medium::Echo;

/// Sent bytes whose echo has not come; several frames if no device answers.
const PENDING_MAX: usize = 8 * lafet_proto::link::WIRE_MAX;

/// Removes the echo from received bytes.
#[derive(Debug)]
pub struct EchoFilter {
    mode: Echo,
    pending: VecDeque<u8>,
    /// The part of the pending frame that has come back already.
    same: Vec<u8>,
    /// Lengths of the pending frames.
    frames: VecDeque<usize>,
    collisions: u64,
    missing: u64,
}

impl EchoFilter {
    /// A filter for a line of this kind.
    pub const fn new(mode: Echo) -> Self {
        Self {
            mode,
            pending: VecDeque::new(),
            same: Vec::new(),
            frames: VecDeque::new(),
            collisions: 0,
            missing: 0,
        }
    }

    /// Frames whose echo differed: another device transmitted (only when verified).
    pub const fn collisions(&self) -> u64 {
        self.collisions
    }

    /// Frames whose echo has not come (only when verified): the line has no echo, or the adapter
    /// does not send.
    pub const fn missing(&self) -> u64 {
        self.missing
    }

    /// Drops pending echoes, for a new connection.
    pub fn reset(&mut self) {
        self.pending.clear();
        self.same.clear();
        self.frames.clear();
    }

    /// Records bytes that are being sent.
    pub fn sent(&mut self, bytes: &[u8]) {
        if self.mode == Echo::Off {
            return;
        }
        // A frame whose echo has not come before the next one is sent has none.
        if !self.frames.is_empty() && self.same.is_empty() {
            self.give_up(|filter| &mut filter.missing);
        }
        if self.pending.len() + bytes.len() <= PENDING_MAX {
            self.pending.extend(bytes);
            self.frames.push_back(bytes.len());
        }
    }

    /// The received bytes without echo.
    pub fn received<'b>(&mut self, bytes: &'b [u8]) -> Cow<'b, [u8]> {
        if self.pending.is_empty() {
            return Cow::Borrowed(bytes);
        }
        let mut rest = bytes.iter();
        let mut others = Vec::new();
        while let Some(expected) = self.pending.front() {
            let Some(byte) = rest.next() else { return others.into() };
            if byte == expected {
                self.same.extend(self.pending.pop_front());
                if self.frames.front().is_some_and(|len| *len == self.same.len()) {
                    self.frames.pop_front();
                    self.same.clear();
                }
                continue;
            }
            // Both directions start their frames equally: an answer goes to our own address.
            let ours = self.pending.get(1) == Some(byte);
            let answer = self.same.len() == ADDRESSES_AT && ours;
            others.append(&mut self.same);
            others.push(*byte);
            self.give_up(|filter| match answer {
                true => &mut filter.missing,
                false => &mut filter.collisions,
            });
        }
        others.extend(rest);
        others.into()
    }

    fn give_up(&mut self, counter: impl FnOnce(&mut Self) -> &mut u64) {
        self.reset();
        let verified = self.mode == Echo::Verify;
        *counter(self) += u64::from(verified);
    }
}

/// Bytes of a frame before its addresses: FF, C0 (observed).
const ADDRESSES_AT: usize = 2;

#[cfg(test)]
mod tests {
    use super::*;

    const ASKED: &[u8] = &[0xFF, 0xC0, 1, 129, 0xD4, 0x0D, 0, 0, 0x12, 0x34, 0xC0];
    const ANSWER: &[u8] = &[0xFF, 0xC0, 129, 1, 0xD4, 0x0D, 0, 0, 0x56, 0x78, 0xC0];

    fn filter(mode: Echo) -> EchoFilter {
        let mut filter = EchoFilter::new(mode);
        filter.sent(ASKED);
        filter
    }

    fn counts(filter: &EchoFilter) -> (u64, u64) {
        (filter.collisions(), filter.missing())
    }

    #[test]
    fn the_echo_is_taken_away_however_it_is_cut() {
        for mode in [Echo::Strip, Echo::Verify] {
            for cut in 1..ASKED.len() + ANSWER.len() {
                let mut filter = filter(mode);
                let line = [ASKED, ANSWER].concat();
                let parts = line.chunks(cut).flat_map(|chunk| filter.received(chunk).into_owned());
                assert_eq!(parts.collect::<Vec<u8>>(), ANSWER);
                assert_eq!(counts(&filter), (0, 0));
            }
        }
        assert_eq!(filter(Echo::Off).received(ANSWER), ANSWER);
    }

    #[test]
    fn an_echo_that_differs_is_a_collision_and_the_answer_still_gets_through() {
        for byte in 0..ASKED.len() {
            let mut garbled = ASKED.to_vec();
            garbled[byte] ^= 0x10;
            let mut filter = filter(Echo::Verify);
            let together = [&garbled, ANSWER].concat();
            let through = filter.received(&together);
            assert_eq!(counts(&filter), (1, 0), "byte {byte}");
            assert!(through.ends_with(ANSWER));
            // The next frame is compared again.
            filter.sent(ASKED);
            assert!(filter.received(ASKED).is_empty());
        }
    }

    #[test]
    fn a_line_without_echo_loses_nothing() {
        let mut filter = filter(Echo::Verify);
        assert_eq!(filter.received(ANSWER), ANSWER);
        assert_eq!(counts(&filter), (0, 1));
        filter.sent(ASKED);
        filter.sent(ASKED);
        assert_eq!(counts(&filter), (0, 2), "neither echo nor answer");
        assert!(filter.received(ASKED).is_empty());
        let mut strip = self::filter(Echo::Strip);
        assert_eq!(strip.received(ANSWER), ANSWER);
        assert_eq!(counts(&strip), (0, 0));
    }
}
