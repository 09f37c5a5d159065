//! How an answer that comes late is kept from being taken for another's.
//!
//! The protocol numbers nothing: an answer says which request it answers, not which *instance* of
//! it. After a timeout a late answer to the last GetStatus looks like the answer to the next one,
//! and a copy made by the medium looks like the original. A serial port, or a TCP or UDP socket of
//! a serial server, even delivers answers that were made for a program that has ended. All of them
//! would be silently wrong values. So (ours):
//!
//! - **Suspicion.** Of each request id we remember when a frame whose answer is still unaccounted
//!   for was last sent. Answers to frames with different first requests cannot be confused, since
//!   an answer repeats its request's id (§2). On a way that outlives programs
//!   ([`super::Config::outlives`]) every request is in doubt for `late_bound` after connecting.
//! - **Tags.** In doubt, a frame has four GetStatus to subsystems that do not exist. §1 has General
//!   answer them ModuleNotExist *on behalf of the addressee*, which repeats the four ids: they
//!   number the frame. GetStatus changes nothing, so the tag is harmless to any monitor. 240 unused
//!   ids make 240⁴ = 3.3·10⁹ tags; the first one is chosen by the operating system's randomness, so
//!   that programs that follow each other number differently. Frames without doubt go out plain.
//!   The tag comes first, so that its answer fits the monitor's buffer whatever else does. Behind
//!   Stop, Close and Lockout on it comes last: a monitor that stumbles over an unknown subsystem
//!   has stopped by then.
//! - **Question.** As long as it is not known whether the monitor answers tags, a request that must
//!   not be repeated waits for the answer to a frame that has only the tag. Reads and urgent
//!   requests are the question themselves.
//! - **Drain.** A monitor that does not answer tags is found out, and then a suspicious request
//!   waits until `drain_bound` has passed.
//!
//! The claim, which tests drive with random delays, losses and copies, within a session and over
//! thousands of them: no answer is believed that was made for another frame, as long as none comes
//! later than the bound after its request. What remains is chance: an answer of another program
//! that has our tag. With n such answers under way while an operation waits, it is n / 3.3·10⁹.

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;
use std::sync::LazyLock;
use std::time::Duration;

use lafet_proto::record::HEADER_SIZE;
use lafet_proto::{Record, RequestId, SubsystemId};

use super::Now;

/// Ids of subsystems that do not exist: the number of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tag([SubsystemId; Self::LEN]);

impl Tag {
    /// Records of a tag.
    pub const LEN: usize = 4;
    /// Bytes that a tag adds to a frame.
    pub const SIZE: usize = Self::LEN * HEADER_SIZE;

    /// The tag with a number.
    fn numbered(mut number: u32) -> Self {
        let ids = &*UNUSED;
        Self(std::array::from_fn(|_| {
            let digit = number as usize % ids.len();
            number /= ids.len() as u32;
            ids[digit]
        }))
    }

    /// The tag's requests.
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

/// Whether a record could be part of a tag, or of its answer.
pub fn looks_like_tag(request: RequestId, device: SubsystemId) -> bool {
    request == RequestId::GET_STATUS && device.name().is_none()
}

/// The ids that name no subsystem of the document (§1).
static UNUSED: LazyLock<Vec<SubsystemId>> =
    LazyLock::new(|| (0..=u8::MAX).map(SubsystemId).filter(|id| id.name().is_none()).collect());

/// How many tags there are: [`UNUSED`] has 240 ids.
const TAGS: u32 = 240_u32.pow(Tag::LEN as u32);

/// Gives out tags. At 100,000 frames a second, one comes again after 9 hours.
#[derive(Debug)]
pub struct Tags {
    next: u32,
}

impl Tags {
    /// Tags from a number on, or from one that the operating system's randomness chooses.
    pub fn new(first: Option<u32>) -> Self {
        // The keys of the standard library's hash maps are the system's randomness.
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

/// When frames whose answers are unaccounted for were last sent, by the id of their first request.
#[derive(Debug)]
pub struct Suspicion {
    /// One place for each request id, and one for probes.
    since: [Option<Now>; 257],
    /// Whatever was sent by whomever.
    all: Option<Now>,
}

impl Default for Suspicion {
    fn default() -> Self {
        Self { since: [None; 257], all: None }
    }
}

impl Suspicion {
    /// An answer to such a frame, sent at `sent`, may still come. A probe has no first request.
    pub fn raise(&mut self, first: Option<RequestId>, sent: Now) {
        let since = &mut self.since[index(first)];
        *since = (*since).max(Some(sent));
    }

    /// Answers to anything, sent by others until now, may still come.
    pub fn raise_all(&mut self, now: Now) {
        self.all = Some(now);
    }

    /// Until when an answer to such a frame may come, if that is in the future.
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
        // Over the end of the numbers, too.
        let mut tags = Tags::new(Some(TAGS - 100_000));
        let mut seen = std::collections::HashSet::new();
        for _ in 0..200_000 {
            let tag = tags.issue();
            assert!(tag.0.iter().all(|id| id.name().is_none()));
            assert!(seen.insert(tag.to_bytes()));
        }
    }

    /// A thousand programs: none begins where another does.
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
