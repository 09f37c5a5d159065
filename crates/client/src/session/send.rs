//! Transmission: which frame is sent when.

use std::time::Duration;

use lafet_proto::link::{Check, compose, wire_max};

use super::check::Forms;
use super::late_answers::{Tag, looks_like_tag};
use super::medium::{Addresses, Framing};
use super::operation::{Echo, Haste, Operation, Outstanding};
use super::{Now, Session, Verdict};
use crate::answers::RequestBuf;

impl Session {
    /// The next bytes to send.
    pub fn poll_transmit(&mut self, now: Now) -> Option<Vec<u8>> {
        if !self.connected {
            return None;
        }
        if self.outstanding.as_ref().is_none_or(|outstanding| outstanding.due) {
            self.refuse_missing(now);
            let urgent = self.next_is_urgent();
            if !urgent && let Some(probe) = self.poll_check(now) {
                return Some(probe);
            }
            if self.probed_until(urgent).is_some_and(|until| now < until) {
                return None;
            }
            self.probe_failed();
        }
        if self.outstanding.is_none() {
            self.outstanding = self.next(now);
        }
        let form = self.outstanding.as_ref().map_or(Check::Crc16, |o| self.next_form(o));
        let wait = self.outstanding.as_ref().map_or(Duration::ZERO, |o| self.wait(&o.operation));
        let outstanding = self.outstanding.as_mut().filter(|outstanding| outstanding.due)?;
        outstanding.due = false;
        outstanding.sent = now;
        // A frame sent too early for its answer to be accepted is sent again as soon as possible.
        let believable = now >= outstanding.believe_from;
        outstanding.deadline = if believable { now + wait } else { outstanding.believe_from };
        outstanding.operation.tries += u32::from(believable);
        outstanding.operation.sent = true;
        if believable {
            outstanding.operation.first_sent.get_or_insert(now);
        }
        outstanding.tries += 1;
        outstanding.forms.add(form);
        self.stats.frames_sent += 1;
        self.stats.retries += u64::from(outstanding.tries > 1);
        Some(self.frame(form))
    }

    /// The bytes of the outstanding frame.
    fn frame(&mut self, form: Check) -> Vec<u8> {
        let Some(outstanding) = &self.outstanding else { return vec![] };
        let ends = outstanding.tag_ends(self.config.framing);
        let Outstanding { operation, tag, .. } = outstanding;
        let tag = tag.map(Tag::to_bytes);
        let tagged = tag.is_some();
        let tag = tag.as_ref().map_or(&[][..], |bytes| bytes);
        let requests = operation.requests.iter().map(RequestBuf::bytes);
        let (before, behind) = if ends { (&[][..], tag) } else { (tag, &[][..]) };
        let parts = std::iter::once(before).chain(requests).chain([behind]);
        let Addresses { monitor: dst, source: src } = self.config.addresses;
        let bytes = match self.config.framing {
            Framing::Records => parts.flatten().copied().collect(),
            Framing::Link => {
                let mut wire = vec![0; wire_max(parts.clone().map(<[u8]>::len).sum())];
                let len = compose(form, dst, src, &mut wire, |mut place| {
                    let room = place.len();
                    for part in parts {
                        let (bytes, rest) = place.split_at_mut_checked(part.len())?;
                        bytes.copy_from_slice(part);
                        place = rest;
                    }
                    Some(room - place.len())
                });
                wire.truncate(len.unwrap_or(0));
                wire
            }
        };
        if self.traced.is_some() {
            let requests: Vec<&[u8]> = operation.requests.iter().map(RequestBuf::bytes).collect();
            self.trace(Verdict::Sent, dst, src, tagged, &requests.concat());
        }
        bytes
    }

    /// The next operation, if it may be sent now.
    pub(super) fn next(&mut self, now: Now) -> Option<Outstanding> {
        let urgent = !self.urgent.is_empty();
        let place = self.first_queued();
        let operation = self.urgent.front().or(self.queue.get(place))?;
        let doubtful = self.is_doubtful(now, operation);
        if !urgent && doubtful && self.drained(now, operation).is_some() {
            return None;
        }
        let (mut question, repeatable) = (None, operation.is_repeatable());
        let (tag, believe_from) = if !doubtful {
            (None, Now::ZERO)
        } else if self.tags_work() {
            let unknown = matches!(self.echo, Echo::Unknown { .. });
            if unknown && !repeatable && self.config.framing == Framing::Link {
                question = Some(Operation::question(now));
            }
            (Some(self.tags.issue()), Now::ZERO)
        } else {
            let until = self.suspicion.until(operation.first(), now, self.config.drain_bound);
            (None, until.unwrap_or(Now::ZERO))
        };
        let waiting = || self.urgent.pop_front().or_else(|| self.queue.remove(place));
        let operation = question.or_else(waiting)?;
        Some(Outstanding {
            operation,
            tag,
            tries: 0,
            sent: now,
            deadline: now,
            due: true,
            believe_from,
            untagged: false,
            forms: Forms::default(),
        })
    }

    /// Index in the queue of the next operation: those of a held motion come before the others.
    pub(super) fn first_queued(&self) -> usize {
        self.queue.iter().position(Operation::is_held).unwrap_or(0)
    }

    /// The priority of the frame to be sent now, if any.
    pub(super) fn wants(&self, now: Now) -> Option<Haste> {
        let wants = self.wants_now(now)?;
        // Operations that wait for the answer to a probe keep waiting, except urgent ones.
        (wants == Haste::Urgent || !self.check.is_probing()).then_some(wants)
    }

    /// Whether the next operation is urgent.
    pub(super) fn next_is_urgent(&self) -> bool {
        match &self.outstanding {
            Some(outstanding) => outstanding.operation.is_urgent(),
            None => !self.urgent.is_empty(),
        }
    }

    fn wants_now(&self, now: Now) -> Option<Haste> {
        match &self.outstanding {
            _ if !self.connected => None,
            Some(outstanding) => outstanding.due.then(|| outstanding.operation.haste()),
            None if !self.urgent.is_empty() => Some(Haste::Urgent),
            None => {
                let operation = self.queue.get(self.first_queued())?;
                self.drained(now, operation).is_none().then_some(operation.haste())
            }
        }
    }

    /// Start and end of the time in which an outstanding frame takes the line.
    pub(super) fn occupies(&self, now: Now) -> Option<(Now, Now)> {
        if let Some(probe) = self.check.occupies().filter(|(_, until)| now < *until) {
            return Some(probe);
        }
        let outstanding = self.outstanding.as_ref().filter(|outstanding| !outstanding.due)?;
        let until = outstanding.deadline.min(outstanding.sent + self.config.timeout);
        (now < until).then_some((outstanding.sent, until))
    }

    /// Whether an answer to another frame could be taken for one to this operation.
    fn is_doubtful(&self, now: Now, operation: &Operation) -> bool {
        if self.config.framing == Framing::Records {
            return true;
        }
        let bound = if self.tags_work() { self.config.late_bound } else { self.config.drain_bound };
        let mut requests = operation.requests.iter();
        let own_tag = requests.any(|request| looks_like_tag(request.id(), request.to()));
        self.suspicion.until(operation.first(), now, bound).is_some()
            || (own_tag && self.tags_work())
    }

    pub(super) fn tags_work(&self) -> bool {
        self.config.framing == Framing::Records || (self.config.tags && self.echo != Echo::No)
    }

    /// Time until which an operation waits because its answer could be confused with another.
    pub(super) fn drained(&self, now: Now, operation: &Operation) -> Option<Now> {
        if self.tags_work() || !self.is_doubtful(now, operation) {
            return None;
        }
        self.suspicion.until(operation.first(), now, self.config.drain_bound)
    }

    /// Time until which waiting operations are held back because the monitor does not answer tags.
    pub fn held_until(&self, now: Now) -> Option<Now> {
        self.drained(now, self.queue.front()?)
    }
}
