//! What a flood has sent, and how it was answered.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::kinds::Answered;

/// Whether a client takes what is answered, and whether the hub knows it.
#[derive(Clone, Copy)]
pub struct Manner {
    pub reads: bool,
    pub known: bool,
}

pub const MANNERS: [Manner; 4] = [
    Manner { reads: true, known: true },
    Manner { reads: false, known: true },
    Manner { reads: true, known: false },
    Manner { reads: false, known: false },
];

impl fmt::Display for Manner {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reads = if self.reads { "read" } else { "unread" };
        write!(out, "{reads}, {}", if self.known { "known" } else { "stranger" })
    }
}

/// Status of a message of the WebSocket that was carried out, and of one that was not.
pub const DONE: u16 = 200;
pub const REFUSED: u16 = 400;

/// Statuses of what a hub has no room or time for, and refuses.
const TOO_MUCH: [u16; 2] = [429, 503];

/// Of one manner.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Messages that were given to the system.
    pub sent: u64,
    /// Answers by status; of the WebSocket: as they would be over HTTP, or the code of its end.
    pub statuses: BTreeMap<u16, u64>,
}

impl Tally {
    /// How many were carried out.
    pub fn done(&self) -> u64 {
        self.statuses.iter().filter(|(status, _)| is_done(**status)).map(|(_, count)| count).sum()
    }
}

const fn is_done(status: u16) -> bool {
    matches!(status, 101 | 200..=299)
}

/// Of all manners, shared by the clients.
#[derive(Clone, Default)]
pub struct Tallies(Arc<[Mutex<Tally>; MANNERS.len()]>);

impl Tallies {
    /// That of a manner.
    pub fn of(&self, manner: Manner) -> MutexGuard<'_, Tally> {
        let index = usize::from(!manner.reads) + 2 * usize::from(!manner.known);
        self.0[index].lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn sent(&self, manner: Manner) {
        self.of(manner).sent += 1;
    }

    pub fn answered(&self, manner: Manner, status: u16) {
        *self.of(manner).statuses.entry(status).or_default() += 1;
    }

    /// Messages of all manners.
    pub fn all_sent(&self) -> u64 {
        MANNERS.into_iter().map(|manner| self.of(manner).sent).sum()
    }

    /// Whether the load alone may have kept a flood from being answered as it has to be: what it was answered at all says that
    /// there is too much to do.
    pub fn is_too_much(&self, manners: &[Manner]) -> bool {
        let asked = manners.iter().filter(|it| it.reads && it.known);
        asked.map(|it| self.of(*it)).all(|tally| {
            tally.sent > 0 && tally.statuses.keys().all(|status| TOO_MUCH.contains(status))
        })
    }

    /// What is wrong with a flood in these manners: one sent nothing, or what the hub knows and
    /// answers was never answered as it has to be.
    pub fn wrong(&self, manners: &[Manner], answered: Answered) -> Option<String> {
        for manner in manners {
            let tally = self.of(*manner);
            if tally.sent == 0 {
                return Some(format!("nothing is sent, {manner}"));
            }
            let refused = |status| tally.statuses.contains_key(&status);
            let fine = match answered {
                Answered::Done => tally.done() > 0,
                Answered::Refused(status) => refused(status),
                Answered::DoneOr(status) => tally.done() > 0 || refused(status),
                Answered::Silence => true,
            };
            if manner.reads && manner.known && !fine {
                return Some(format!("{answered:?} never, but {:?}", tally.statuses));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: Manner = MANNERS[0];

    #[test]
    fn a_flood_that_sends_nothing_or_is_never_answered_is_wrong() {
        let wrong = |tallies: &Tallies, answered| tallies.wrong(&[KNOWN], answered);
        let tallies = Tallies::default();
        let nothing = wrong(&tallies, Answered::Silence);
        assert_eq!(nothing.as_deref(), Some("nothing is sent, read, known"));
        tallies.sent(KNOWN);
        assert_eq!(wrong(&tallies, Answered::Silence), None);
        assert!(wrong(&tallies, Answered::Done).is_some(), "it was not answered");
        tallies.answered(KNOWN, 401);
        for lacking in [Answered::Done, Answered::Refused(404), Answered::DoneOr(409)] {
            assert!(wrong(&tallies, lacking).is_some(), "{lacking:?}");
        }
        assert_eq!(wrong(&tallies, Answered::Refused(401)), None);
        tallies.answered(KNOWN, 204);
        assert_eq!(wrong(&tallies, Answered::Done), None);
        // Of strangers and of who does not read nothing but messages is wanted.
        assert_eq!(
            tallies.wrong(&MANNERS[..2], Answered::Done).as_deref(),
            Some("nothing is sent, unread, known")
        );
        tallies.sent(MANNERS[1]);
        assert_eq!(tallies.wrong(&MANNERS[..2], Answered::Done), None);
    }

    /// Nothing but that is tried again.
    #[test]
    fn a_flood_that_is_refused_for_the_load_alone_is_known() {
        let tallies = Tallies::default();
        assert!(!tallies.is_too_much(&[KNOWN]), "nothing was sent");
        tallies.sent(KNOWN);
        assert!(tallies.is_too_much(&[KNOWN]), "nothing is answered yet");
        tallies.answered(KNOWN, 429);
        tallies.answered(KNOWN, 503);
        // What strangers get counts for nothing.
        tallies.answered(MANNERS[2], 401);
        assert!(tallies.is_too_much(&MANNERS));
        for status in [200, 400, 401, 403, 404, 409, 500] {
            let tallies = Tallies::default();
            tallies.sent(KNOWN);
            tallies.answered(KNOWN, 429);
            tallies.answered(KNOWN, status);
            assert!(!tallies.is_too_much(&[KNOWN]), "{status}");
        }
    }
}
