//! Rejection of late answers that could be taken for answers to other requests.
//!
//! The protocol has no numbers: an answer repeats the id of its request, but does not show which
//! *instance* of it is answered. After a timeout a late answer to the last GetStatus looks like the
//! answer to the next one, and a copy made by the medium looks like the original. A serial port, or
//! a TCP or UDP socket of a serial server, even delivers answers to a program that has ended. Each
//! of them would be a wrong value without any sign. So (ours):
//!
//! - **Suspicion.** For each request id the session remembers when a frame whose answer has not
//!   come was last sent. Answers to frames with different first requests cannot be confused, because
//!   an answer repeats the id of its request (§2). On a connection that outlives programs
//!   ([`super::Config::outlives`]) every request is in doubt for `late_bound` after connecting.
//! - **Tags.** In doubt, a frame has four GetStatus to subsystems that do not exist. By §1 General
//!   answers them with ModuleNotExist *on behalf of the addressee*, so the answer repeats the four
//!   ids: they number the frame. GetStatus changes nothing, so the tag is harmless for any monitor.
//!   240 unused ids make 240⁴ = 3.3·10⁹ tags; the first one is random, from the operating system, so
//!   that consecutive programs use different numbers. Frames without doubt have no tag. The tag is at
//!   the start, so that its answer always fits the monitor's buffer. After Stop, Close and Lockout on
//!   it is at the end: a monitor that fails on an unknown subsystem has stopped by then.
//! - **Question.** While it is not known whether the monitor answers tags, a request that must not
//!   be repeated waits for the answer to a frame that has only the tag. Reads and urgent requests
//!   serve as the question themselves.
//! - **Drain.** If the monitor turns out not to answer tags, a suspicious request waits until
//!   `drain_bound` has passed.
//!
//! The property, which tests check with random delays, losses and copies, within a session and over
//! thousands of them: no answer to another frame is accepted as long as none comes later than the
//! bound after its request. Only chance remains: an answer to another program that has our tag.
//! With n such answers under way while an operation waits, the probability is n / 3.3·10⁹.

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;
use std::sync::LazyLock;
use std::time::Duration;

use lafet_proto::record::HEADER_SIZE;
use lafet_proto::{Record, RequestId, SubsystemId};

use super::Now;

/// The number of a frame: ids of subsystems that do not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tag([SubsystemId; Self::LEN]);

impl Tag {
    /// Number of records of a tag.
    pub const LEN: usize = 4;
    /// Bytes that a tag adds to a frame.
    pub const SIZE: usize = Self::LEN * HEADER_SIZE;

    /// The tag with this number.
    fn numbered(mut number: u32) -> Self {
        let ids = &*UNUSED;
        Self(std::array::from_fn(|_| {
            let digit = number as usize % ids.len();
            number /= ids.len() as u32;
            ids[digit]
        }))
    }

    /// The bytes of the tag's requests.
    pub fn to_bytes(self) -> [u8; Self::SIZE] {
        let mut bytes = [0; Self::SIZE];
        for (record, id) in bytes.chunks_exact_mut(HEADER_SIZE).zip(self.0) {
            record[..2].copy_from_slice(&[RequestId::GET_STATUS.0, id.0]);
        }
        bytes
    }

    /// Whether these records answer the tag.
    pub fn matches(self, records: &[Record<'_>; Self::LEN]) -> bool {
        records
            .iter()
            .zip(self.0)
            .all(|(record, id)| record.request == RequestId::GET_STATUS && record.device == id)
    }
}

/// Whether a record could belong to a tag or its answer.
pub fn looks_like_tag(request: RequestId, device: SubsystemId) -> bool {
    request == RequestId::GET_STATUS && device.name().is_none()
}

/// The ids that are not subsystems of the document (§1).
static UNUSED: LazyLock<Vec<SubsystemId>> =
    LazyLock::new(|| (0..=u8::MAX).map(SubsystemId).filter(|id| id.name().is_none()).collect());

/// Number of tags: [`UNUSED`] has 240 ids.
const TAGS: u32 = 240_u32.pow(Tag::LEN as u32);

/// Issues tags. At 100,000 frames a second, one is repeated after 9 hours.
#[derive(Debug)]
pub struct Tags {
    next: u32,
}

impl Tags {
    /// Tags from this number on, or from a random one of the operating system.
    pub fn new(first: Option<u32>) -> Self {
        // The keys of the standard library's hash maps are random numbers of the operating system.
        let chosen = || RandomState::new().hash_one(()) as u32;
        Self { next: first.unwrap_or_else(chosen) % TAGS }
    }

    /// The next tag.
    pub fn issue(&mut self) -> Tag {
        let tag = Tag::numbered(self.next);
        self.next = (self.next + 1) % TAGS;
        tag
    }
}

/// Times of the last frames whose answers have not come, by the id of their first request.
#[derive(Debug)]
pub struct Suspicion {
    /// One entry for each request id, and one for probes.
    since: [Option<Now>; 257],
    /// Time until which frames of any kind were sent by other programs.
    all: Option<Now>,
}

impl Default for Suspicion {
    fn default() -> Self {
        Self { since: [None; 257], all: None }
    }
}

impl Suspicion {
    /// Records that an answer to a frame sent at `sent` may still come. A probe has no first
    /// request.
    pub fn raise(&mut self, first: Option<RequestId>, sent: Now) {
        let since = &mut self.since[index(first)];
        *since = (*since).max(Some(sent));
    }

    /// Records that answers to any frames, sent by other programs until now, may still come.
    pub fn raise_all(&mut self, now: Now) {
        self.all = Some(now);
    }

    /// Time until which an answer to such a frame may come, if it is in the future.
    pub fn until(&self, first: Option<RequestId>, now: Now, bound: Duration) -> Option<Now> {
        let until = self.since[index(first)].max(self.all)? + bound;
        (now < until).then_some(until)
    }
}

fn index(first: Option<RequestId>) -> usize {
    first.map_or(256, |request| usize::from(request.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUND: Duration = Duration::from_secs(30);

    #[test]
    fn tags_are_all_different_and_name_no_subsystem() {
        assert_eq!(u64::from(TAGS), (UNUSED.len() as u64).pow(4));
        // Also across the wrap of the numbers.
        let mut tags = Tags::new(Some(TAGS - 100_000));
        let mut seen = std::collections::HashSet::new();
        for _ in 0..200_000 {
            let tag = tags.issue();
            assert!(tag.0.iter().all(|id| id.name().is_none()));
            assert!(seen.insert(tag.to_bytes()));
        }
    }

    /// A thousand programs, each with another first number.
    #[test]
    fn every_program_numbers_from_somewhere_else() {
        let first = |_| Tags::new(None).issue().to_bytes();
        let seen: std::collections::HashSet<_> = (0..1000).map(first).collect();
        assert_eq!(seen.len(), 1000);
    }

    #[test]
    fn suspicion_passes() {
        let mut suspicion = Suspicion::default();
        let (stop, at) = (Some(RequestId::STOP), Duration::from_secs(5));
        suspicion.raise(stop, at);
        suspicion.raise(stop, Duration::from_secs(1));
        assert_eq!(suspicion.until(stop, at, BOUND), Some(at + BOUND));
        assert_eq!(suspicion.until(stop, at + BOUND, BOUND), None);
        assert_eq!(suspicion.until(Some(RequestId::MOVE), at, BOUND), None);
        assert_eq!(suspicion.until(None, at, BOUND), None);
        let later = Duration::from_secs(10);
        suspicion.raise_all(later);
        for first in [stop, Some(RequestId::MOVE), None] {
            assert_eq!(suspicion.until(first, later, BOUND), Some(later + BOUND));
        }
    }
}
