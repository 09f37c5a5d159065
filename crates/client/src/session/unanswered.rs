//! Operations that end without an answer, and what is remembered of them.

use lafet_proto::RequestId;

use super::operation::{Echo, Operation, Outstanding, Recent};
use super::{Now, Outcome, RECENT_MAX, Session, Ticket, UNTAGGED_PROOF};

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

    /// Without connection no operation waits longer than for an answer.
    pub(super) fn expire(&mut self, now: Now) {
        let (timeout, outcomes) = (self.config.timeout, &mut self.outcomes);
        for queue in [&mut self.urgent, &mut self.queue] {
            queue.retain(|operation| {
                let alive = now < operation.submitted + timeout;
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
        // An urgent frame is repeated before a missing answer proves anything.
        let long = now >= outstanding.sent + self.config.timeout;
        self.silent_tries += u32::from(long);
        self.check.silence(now);
        let again = self.may_try_again(now, &outstanding.operation);
        self.note_untagged(&mut outstanding, !again);
        let hopeless = outstanding.tag.is_some() && !self.tags_work();
        if again && !hopeless {
            outstanding.due = true;
            self.outstanding = Some(outstanding);
            return;
        }
        let Outstanding { mut operation, .. } = self.give_up(outstanding);
        if again {
            self.requeue(operation);
        } else if operation.ticket == Ticket::QUESTION {
            self.question_failed(hopeless, operation.tries);
        } else if hopeless && operation.is_repeatable() && !operation.cancelled {
            // Its answers could not be accepted: it starts again, without a tag.
            operation.tries = 0;
            self.requeue(operation);
        } else {
            let Operation { ticket, tries, odd, stray, .. } = operation;
            let silence = Outcome::Silence { tries, stray };
            let outcome = odd.map_or(silence, |what| Outcome::Odd { what });
            self.outcomes.push_back((ticket, outcome));
        }
        self.overtake(now);
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
