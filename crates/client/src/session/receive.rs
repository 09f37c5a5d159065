//! Received frames: which are accepted as answers, and what the others are.

use lafet_proto::link::Check;
use lafet_proto::{Record, RequestId, SubsystemId};

use super::input::Incoming;
use super::matching::deal;
use super::medium::Addresses;
use super::operation::{Echo, Operation, Outstanding, Recent};
use super::{Now, Outcome, Session, Tag, Verdict};
use crate::answers::records;
use crate::deviation::mismatch;

impl Session {
    /// Takes a frame received without errors, from and to any address.
    pub(super) fn handle_incoming(&mut self, now: Now, frame: &Incoming) {
        let Addresses { monitor, source } = self.config.addresses;
        let ours = frame.addresses.is_none_or(|(dst, src)| (dst, src) == (source, monitor));
        let (dst, src) = frame.addresses.unwrap_or((source, monitor));
        if !ours {
            *self.stats.count(Verdict::Foreign) += 1;
            self.trace(Verdict::Foreign, dst, src, false, &frame.payload);
            return;
        }
        self.forget_silence();
        self.answered_at = Some(now);
        let (verdict, tagged, payload) = match self.check_heard(now, frame) {
            true => (Verdict::Believed, false, &frame.payload[..]),
            false => self.handle_payload(now, &frame.payload, frame.check),
        };
        *self.stats.count(verdict) += 1;
        self.trace(verdict, dst, src, tagged, payload);
    }

    /// Takes a frame from the monitor to this side: classifies it, splits off a tag, evaluates the
    /// rest.
    fn handle_payload<'p>(
        &mut self,
        now: Now,
        payload: &'p [u8],
        check: Check,
    ) -> (Verdict, bool, &'p [u8]) {
        let Some(all) = records(payload) else { return (Verdict::Unmatched, false, payload) };
        let framing = self.config.framing;
        // A monitor answers in the form of the request (§L/7).
        let asked = |o: &&mut Outstanding| o.tries > 0 && o.forms.has(check);
        let Some(outstanding) = self.outstanding.as_mut().filter(asked) else {
            return (self.classify(&all), false, payload);
        };
        let (rest, bytes) = match outstanding.tag {
            None => (&all[..], payload),
            Some(tag) => match split_tag(tag, &all, payload, outstanding.tag_ends(framing)) {
                Some(split) => split,
                None => {
                    outstanding.untagged |= is_untagged(&outstanding.operation, &all);
                    let verdict = self.classify(&all);
                    self.note_stray(verdict, &all);
                    return (verdict, false, payload);
                }
            },
        };
        let tagged = outstanding.tag.is_some();
        let Some(slots) = deal(&outstanding.operation.requests, rest) else {
            // With the tag, or without doubt, it must be the answer.
            if now >= outstanding.believe_from {
                let odd = mismatch(&outstanding.operation.requests, rest);
                outstanding.operation.odd = odd.map(Box::new);
            }
            return (self.classify(&all), tagged, bytes);
        };
        if now < outstanding.believe_from {
            return (Verdict::Late, tagged, bytes);
        }
        if tagged {
            self.echo = Echo::Yes;
        }
        if let Some(outstanding) = self.outstanding.take() {
            self.settle(&outstanding, true);
            if outstanding.tries == 1 {
                self.stats.note_rtt(now.saturating_sub(outstanding.sent));
            }
            self.outcomes.push_back((outstanding.operation.ticket, Outcome::Answered(slots)));
        }
        (Verdict::Believed, tagged, bytes)
    }

    /// Remembers a frame that answers nothing of this program, to report it if no answer comes.
    fn note_stray(&mut self, verdict: Verdict, all: &[Record<'_>]) {
        if let (Verdict::Unmatched, Some(first), Some(out)) =
            (verdict, all.first(), &mut self.outstanding)
        {
            out.operation.stray = Some(first.request);
        }
    }

    /// Classifies a frame that does not answer the outstanding operation.
    fn classify(&self, all: &[Record<'_>]) -> Verdict {
        let first = all.first().map(|record| record.request);
        let ends = [all.first_chunk(), all.last_chunk()];
        let of = |recent: &&Recent| match recent.tag {
            Some(tag) => ends.iter().flatten().any(|records| tag.matches(records)),
            None => recent.first == first,
        };
        match self.recent.iter().rev().find(of) {
            Some(recent) if recent.answered => Verdict::Duplicate,
            Some(_) => Verdict::Late,
            None => Verdict::Unmatched,
        }
    }
}

/// Splits the tag off a frame that has it.
fn split_tag<'r, 'a, 'p>(
    tag: Tag,
    all: &'r [Record<'a>],
    payload: &'p [u8],
    at_end: bool,
) -> Option<(&'r [Record<'a>], &'p [u8])> {
    let size = |records: &[Record<'_>; Tag::LEN]| records.iter().map(Record::size).sum::<usize>();
    if at_end {
        let (rest, end) = all.split_last_chunk()?;
        let bytes = payload.get(..payload.len() - size(end))?;
        tag.matches(end).then_some((rest, bytes))
    } else {
        let (start, rest) = all.split_first_chunk()?;
        let bytes = payload.get(size(start)..)?;
        tag.matches(start).then_some((rest, bytes))
    }
}

/// Whether a monitor that does not support tags would answer like this: without them, or with a
/// refusal of General in its own name.
fn is_untagged(operation: &Operation, all: &[Record<'_>]) -> bool {
    let refuses = |record: &Record<'_>| {
        record.request == RequestId::GET_STATUS
            && record.device == SubsystemId::GENERAL
            && !record.status.is_success()
    };
    let refused = all.first().is_some_and(refuses) || all.last().is_some_and(refuses);
    refused || deal(&operation.requests, all).is_some()
}
