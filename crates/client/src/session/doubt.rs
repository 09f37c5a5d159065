//! How an answer that comes late is kept from being taken for another's.
//!
//! The protocol numbers nothing: an answer says which request it answers, not which *instance* of
//! it. After a timeout a late answer to the last GetStatus looks like the answer to the next one,
//! and a copy made by the medium looks like the original. Both would be silently wrong values.
//! So (ours):
//!
//! - **Suspicion.** Of each request id we remember when a frame whose answer is still unaccounted
//!   for was last sent. Answers to frames with different first requests cannot be confused, since
//!   an answer repeats its request's id (§2).
//! - **Tags.** While there is suspicion, a frame begins with two GetStatus to subsystems that do
//!   not exist. §1 has General answer them ModuleNotExist *on behalf of the addressee*, which
//!   repeats the two ids: they number the frame. GetStatus changes nothing, so the tag is harmless
//!   to any monitor. 240 unused ids make 57,600 tags; none is used again before `late_bound` has
//!   passed since its last use. Frames without suspicion go out plain.
//! - **Drain.** A monitor that does not answer tags is found out, and then a suspicious request
//!   waits until `drain_bound` has passed.
//!
//! The claim, which a test drives with random delays, losses and copies: no answer is believed
//! that was made for another frame, as long as none comes later than the bound after its request.

use std::sync::LazyLock;
use std::time::Duration;

use lafet_proto::record::HEADER_SIZE;
use lafet_proto::{Record, RequestId, SubsystemId};

use super::Now;

/// Two ids of subsystems that do not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tag([SubsystemId; 2]);

impl Tag {
    /// Bytes that a tag adds to a frame.
    pub const SIZE: usize = 2 * HEADER_SIZE;

    /// The tag's requests.
    pub fn to_bytes(self) -> [u8; Self::SIZE] {
        let [a, b] = self.0;
        let get_status = RequestId::GET_STATUS.0;
        [get_status, a.0, 0, 0, get_status, b.0, 0, 0]
    }

    /// Whether these two records answer the tag.
    pub fn matches(self, [first, second]: &[Record<'_>; 2]) -> bool {
        let answers = |record: &Record<'_>, id| {
            record.request == RequestId::GET_STATUS && record.device == id
        };
        answers(first, self.0[0]) && answers(second, self.0[1])
    }
}

/// Whether a record could be half a tag, or its answer.
pub fn looks_like_tag(request: RequestId, device: SubsystemId) -> bool {
    request == RequestId::GET_STATUS && device.name().is_none()
}

/// The ids that name no subsystem of the document (§1).
static UNUSED: LazyLock<Vec<SubsystemId>> =
    LazyLock::new(|| (0..=u8::MAX).map(SubsystemId).filter(|id| id.name().is_none()).collect());

/// Gives out tags; half of them rests while the other half is in use.
#[derive(Debug, Default)]
pub struct Tags {
    next: usize,
    /// When a tag of each half was last sent.
    last_use: [Option<Now>; 2],
}

impl Tags {
    /// When the next tag will be free, if it is not.
    pub fn resting_until(&self, now: Now, late_bound: Duration) -> Option<Now> {
        let entered = !self.next.is_multiple_of(half_size());
        let until = self.last_use[half_of(self.next)]? + late_bound;
        (!entered && now < until).then_some(until)
    }

    /// The next tag, or the time when there will be one.
    pub fn issue(&mut self, now: Now, late_bound: Duration) -> Result<Tag, Now> {
        if let Some(until) = self.resting_until(now, late_bound) {
            return Err(until);
        }
        let half = half_of(self.next);
        let ids = &*UNUSED;
        let tag = Tag([ids[self.next / ids.len()], ids[self.next % ids.len()]]);
        self.next = (self.next + 1) % (ids.len() * ids.len());
        self.last_use[half] = Some(now);
        Ok(tag)
    }

    /// The tag has been sent (again).
    pub fn sent(&mut self, now: Now, tag: Tag) {
        let high = UNUSED.iter().position(|id| *id == tag.0[0]).unwrap_or(0);
        self.last_use[half_of(high * UNUSED.len())] = Some(now);
    }
}

fn half_size() -> usize {
    UNUSED.len() * UNUSED.len() / 2
}

fn half_of(number: usize) -> usize {
    usize::from(number >= half_size())
}

/// When frames whose answers are unaccounted for were last sent, by the id of their first request.
#[derive(Debug)]
pub struct Suspicion {
    /// One place for each request id, and one for probes.
    since: [Option<Now>; 257],
}

impl Default for Suspicion {
    fn default() -> Self {
        Self { since: [None; 257] }
    }
}

impl Suspicion {
    /// An answer to such a frame, sent at `sent`, may still come. A probe has no first request.
    pub fn raise(&mut self, first: Option<RequestId>, sent: Now) {
        let since = &mut self.since[index(first)];
        *since = (*since).max(Some(sent));
    }

    /// Until when an answer to such a frame may come, if that is in the future.
    pub fn until(&self, first: Option<RequestId>, now: Now, bound: Duration) -> Option<Now> {
        let until = self.since[index(first)]? + bound;
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
        assert_eq!(UNUSED.len(), 240);
        let mut tags = Tags::default();
        let mut seen = std::collections::HashSet::new();
        for _ in 0..57_600 {
            let tag = tags.issue(Now::ZERO, BOUND).expect("a fresh one");
            assert!(tag.0.iter().all(|id| id.name().is_none()));
            assert!(seen.insert(tag.to_bytes()));
        }
    }

    #[test]
    fn no_tag_comes_again_before_the_bound() {
        let mut tags = Tags::default();
        let mut last_use = std::collections::HashMap::new();
        let mut now = Now::ZERO;
        for n in 0..300_000u32 {
            // Slow at first, then bursts, now and then a tag that is sent again.
            now += Duration::from_micros(if n % 3000 < 100 { 20_000 } else { 50 });
            let tag = match tags.issue(now, BOUND) {
                Ok(tag) => tag,
                Err(until) => {
                    assert!(until > now);
                    now = until;
                    tags.issue(now, BOUND).expect("the time has come")
                }
            };
            if let Some(before) = last_use.insert(tag.to_bytes(), now) {
                assert!(now >= before + BOUND);
            }
            if n % 7 == 0 {
                now += Duration::from_millis(1);
                tags.sent(now, tag);
                last_use.insert(tag.to_bytes(), now);
            }
        }
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
    }
}
