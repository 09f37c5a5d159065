//! Operations that end without an answer, and what is remembered of them.

use std::time::Duration;

use lafet_proto::RequestId;

use super::operation::{Echo, Haste, Operation, Outstanding, Recent};
use super::{Config, Now, Outcome, RECENT_MAX, Session, Ticket, UNTAGGED_PROOF};

/// Most frames without answer whose times are remembered: a read that may be sent more often has
/// all its tries.
const SILENCES_MAX: u32 = 32;
/// A monitor is known to be silent when so many requests in a row had all their tries in vain. Two
/// are too few: one may be a request that it never answers.
const SILENT_REQUESTS: u32 = 3;
/// The fewest frames in a row without answer that show it, if a request has few tries.
const SILENT_FRAMES_LEAST: u32 = 9;

/// For how long a monitor was not heard, in timeouts that were waited for, however short the wait for each frame was.
#[derive(Debug, Default)]
pub(super) struct Unheard {
    /// When the first frame of the present one was sent.
    from: Option<Now>,
    /// The same of the latest two that are over.
    over: [Option<Now>; 2],
}

impl Unheard {
    /// A frame that was sent then has no answer by now.
    fn note(&mut self, sent: Now, now: Now, timeout: Duration) {
        let from = *self.from.get_or_insert(sent);
        if now >= from + timeout {
            self.over = [self.over[1], Some(from)];
            self.from = None;
        }
    }

    /// How many of them began after this time.
    pub(super) fn since(&self, time: Option<Now>) -> u32 {
        let after = |from: &&Now| time.is_none_or(|time| **from > time);
        self.over.iter().flatten().filter(after).count() as u32
    }
}

impl Session {
    pub(super) fn requeue(&mut self, operation: Operation) {
        let queue = if operation.is_urgent() { &mut self.urgent } else { &mut self.queue };
        queue.push_front(operation);
    }

    /// Ends waiting operations; urgent ones only if `urgent`.
    pub(super) fn refuse_waiting(&mut self, outcome: &Outcome, urgent: bool) {
        let due = |o: &mut Outstanding| o.due && (urgent || !o.operation.is_urgent());
        let mut refused = Vec::new();
        if let Some(outstanding) = self.outstanding.take_if(due) {
            refused.push(self.give_up(outstanding).operation);
        }
        if urgent {
            refused.extend(self.urgent.drain(..));
        }
        refused.extend(self.queue.drain(..));
        for Operation { ticket, sent, tries, .. } in refused {
            let outcome =
                if sent { Outcome::Silence { tries, stray: None } } else { outcome.clone() };
            self.outcomes.push_back((ticket, outcome));
        }
    }

    /// Until when an operation waits without connection: no longer than for an answer. A Stop, Close or Lockout
    /// does no harm late, and has all the time of its tries.
    pub(super) fn waits_until(config: &Config, operation: &Operation) -> Now {
        let tries = if operation.is_urgent() { config.tries.max(1) } else { 1 };
        operation.began.unwrap_or(operation.submitted) + config.timeout * tries
    }

    /// Ends what has waited too long for a connection.
    pub(super) fn expire(&mut self, now: Now) {
        let (config, outcomes) = (&self.config, &mut self.outcomes);
        for queue in [&mut self.urgent, &mut self.queue] {
            queue.retain(|operation| {
                let alive = now < Self::waits_until(config, operation);
                if !alive {
                    let outcome =
                        if operation.sent { Outcome::LinkLost } else { Outcome::NotConnected };
                    outcomes.push_back((operation.ticket, outcome));
                }
                alive
            });
        }
    }

    /// Handles a frame without answer in time.
    pub(super) fn try_failed(&mut self, now: Now, mut outstanding: Outstanding) {
        let blind = outstanding.sent < outstanding.believe_from;
        if blind {
            outstanding.due = true;
            self.outstanding = Some(outstanding);
            return;
        }
        self.stats.timeouts += 1;
        self.misses = self.misses.saturating_add(1);
        self.missed_at = Some(outstanding.sent);
        self.count_silence(now, &mut outstanding);
        self.unheard.note(outstanding.sent, now, self.config.timeout);
        self.check.silence(now);
        let again = self.may_try_again(now, &outstanding.operation);
        self.note_untagged(&mut outstanding, !again);
        let hopeless = outstanding.tag.is_some() && !self.tags_work();
        // Urgent ones take turns: one that is never answered does not hold back the others.
        let others = outstanding.operation.is_urgent() && !self.urgent.is_empty();
        if again && !hopeless && !others {
            outstanding.due = true;
            self.outstanding = Some(outstanding);
            return;
        }
        let Outstanding { mut operation, .. } = self.give_up(outstanding);
        if again && others {
            self.urgent.push_back(operation);
        } else if again {
            self.requeue(operation);
        } else if operation.ticket == Ticket::QUESTION {
            self.question_failed(hopeless, operation.tries);
        } else if hopeless && operation.is_repeatable() && !operation.cancelled {
            // Its answers could not be accepted: it starts again, without a tag.
            operation.tries = 0;
            self.requeue(operation);
        } else {
            self.outcomes.push_back((operation.ticket, operation.unanswered()));
        }
        self.end_vain_reads();
        self.overtake(now);
    }

    /// Counts a frame that was not answered in all the time for it. An urgent one is repeated before
    /// a missing answer proves anything: all its frames in that time count as one.
    fn count_silence(&mut self, now: Now, outstanding: &mut Outstanding) {
        let (sent, operation) = (outstanding.sent, &mut outstanding.operation);
        let since = operation.silent_from.filter(|_| operation.is_urgent()).unwrap_or(sent);
        if now >= since + self.config.timeout {
            operation.silent_from = None;
            self.note_silence(sent);
        }
    }

    /// Remembers a frame that was not answered in all the time for it.
    fn note_silence(&mut self, sent: Now) {
        self.silent_frames = self.silent_frames.saturating_add(1);
        if self.silences.len() >= self.config.tries.clamp(1, SILENCES_MAX) as usize {
            self.silences.pop_front();
        }
        self.silences.push_back(sent);
    }

    /// A frame of the monitor was received, or the connection is new.
    pub(super) fn forget_silence(&mut self) {
        (self.misses, self.missed_at, self.silent_frames) = (0, None, 0);
        self.silences.clear();
        self.unheard = Unheard::default();
    }

    /// If the monitor is known to be silent: reads that wait since then have waited for as many
    /// answers in vain as they have tries.
    fn vain_since(&self) -> Option<Now> {
        let tries = self.config.tries.max(1);
        let proof = tries.saturating_mul(SILENT_REQUESTS).max(SILENT_FRAMES_LEAST);
        let known = tries <= SILENCES_MAX && self.silent_frames >= proof;
        self.silences.front().copied().filter(|_| known)
    }

    /// Whether a read need not be sent again: what its answer would show is known.
    pub(super) fn is_vain(&self, operation: &Operation) -> bool {
        let since = self.vain_since();
        ends_with_others(operation) && since.is_some_and(|since| operation.waits_since(since))
    }

    /// Ends the reads that other frames have waited in vain for, so that they need not do it one
    /// after the other.
    fn end_vain_reads(&mut self) {
        let Some(since) = self.vain_since() else { return };
        self.end_reads(|operation| operation.waits_since(since));
    }

    /// Ends those of the waiting reads that are over.
    pub(super) fn end_reads(&mut self, over: impl Fn(&Operation) -> bool) {
        let outcomes = &mut self.outcomes;
        self.queue.retain(|operation| {
            let waits = !(ends_with_others(operation) && over(operation));
            if !waits {
                outcomes.push_back((operation.ticket, operation.unanswered()));
            }
            waits
        });
    }

    /// Ends the question whether the monitor answers tags: it does not answer at all, or not with
    /// tags.
    fn question_failed(&mut self, answered: bool, tries: u32) {
        if answered {
            return;
        }
        let outcomes = &mut self.outcomes;
        self.queue.retain(|operation| {
            let waits = operation.is_repeatable();
            if !waits {
                outcomes.push_back((operation.ticket, Outcome::Unheard { tries }));
            }
            waits
        });
    }

    /// Handles an answer without the expected tag: the monitor may not support tags. The answer is
    /// accepted when that happened often, or when no other came. A wrong conclusion only costs
    /// time.
    fn note_untagged(&mut self, outstanding: &mut Outstanding, last: bool) {
        let Echo::Unknown { untagged } = &mut self.echo else { return };
        *untagged += u32::from(std::mem::take(&mut outstanding.untagged));
        let all = last && outstanding.tag.is_some() && *untagged > 0;
        if all || *untagged >= UNTAGGED_PROOF {
            self.echo = Echo::No;
        }
    }

    /// Gives up a frame whose answer may still come.
    pub(super) fn give_up(&mut self, outstanding: Outstanding) -> Outstanding {
        if outstanding.tries > 0 {
            self.settle(&outstanding, false);
        }
        outstanding
    }

    /// Remembers an answer that may still come.
    pub(super) fn settle(&mut self, outstanding: &Outstanding, answered: bool) {
        let first = outstanding.operation.first();
        let accounted = answered && outstanding.tries == 1 && !self.config.duplicates;
        if !accounted {
            // The first request decides which answers can be confused: if the tag is at the start,
            // that is a GetStatus.
            let in_front = outstanding.tag.is_some() && !outstanding.tag_ends(self.config.framing);
            if in_front {
                self.suspicion.raise(Some(RequestId::GET_STATUS), outstanding.sent);
            }
            if !in_front || self.echo != Echo::Yes {
                self.suspicion.raise(first, outstanding.sent);
            }
        }
        if self.recent.len() >= RECENT_MAX {
            self.recent.pop_front();
        }
        self.recent.push_back(Recent { tag: outstanding.tag, first, answered });
    }
}

/// Whether an operation may end because others were not answered. The question ends with its own
/// tries: commands wait for it.
pub(super) fn ends_with_others(operation: &Operation) -> bool {
    let read = operation.haste() == Haste::Usual && operation.is_repeatable();
    read && operation.ticket != Ticket::QUESTION
}
