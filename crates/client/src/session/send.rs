//! Transmission: which frame is sent when.

use lafet_proto::link::{self, Check};

use super::check::Forms;
use super::late_answers::{Tag, looks_like_tag};
use super::medium::{Addresses, Framing};
use super::operation::{Echo, Haste, Operation, Outstanding};
use super::{Now, Session, Verdict};
use crate::answers::RequestBuf;

/// How an operation is sent whose answer could be confused with another.
struct Doubt {
    /// First it is found out whether the monitor answers tags.
    asks: bool,
    tag: Option<Tag>,
    /// See [`Outstanding`].
    believe_from: Now,
}

impl Session {
    /// The next bytes to send.
    pub fn poll_transmit(&mut self, now: Now) -> Option<Vec<u8>> {
        let mut wire = Vec::new();
        self.transmit(now, &mut wire).then_some(wire)
    }

    /// Replaces the contents of `wire` by the next bytes to send, if there are any.
    pub(super) fn transmit(&mut self, now: Now, wire: &mut Vec<u8>) -> bool {
        if !self.connected {
            return false;
        }
        let due = self.outstanding.as_ref().is_none_or(|outstanding| outstanding.due);
        if due
            && self.check.negotiates()
            && let Some(sends) = self.transmit_check(now, wire)
        {
            return sends;
        }
        if self.outstanding.is_none() {
            self.take_next(now);
        }
        let Some(outstanding) = self.outstanding.as_ref().filter(|o| o.due) else { return false };
        let (form, wait) = (self.next_form(outstanding), self.wait(now, outstanding));
        let Some(outstanding) = &mut self.outstanding else { return false };
        outstanding.due = false;
        outstanding.sent = now;
        // A frame sent too early for its answer to be accepted is sent again as soon as possible.
        let believable = now >= outstanding.believe_from;
        outstanding.deadline = if believable { now + wait } else { outstanding.believe_from };
        outstanding.operation.tries += u32::from(believable);
        outstanding.operation.sent = true;
        if believable {
            let operation = &mut outstanding.operation;
            operation.first_sent.get_or_insert(now);
            if operation.is_urgent() {
                operation.began.get_or_insert(now);
                operation.silent_from.get_or_insert(now);
            }
        }
        outstanding.tries += 1;
        outstanding.forms.add(form);
        self.stats.frames_sent += 1;
        self.stats.retries += u64::from(outstanding.tries > 1);
        self.encode(form, wire);
        true
    }

    /// Sends a probe first, or waits for its answer; `None`: waiting operations may be sent.
    #[cold]
    fn transmit_check(&mut self, now: Now, wire: &mut Vec<u8>) -> Option<bool> {
        self.refuse_missing(now);
        let urgent = self.next_is_urgent();
        if !urgent && self.poll_check(now, wire) {
            return Some(true);
        }
        if self.probed_until(urgent).is_some_and(|until| now < until) {
            return Some(false);
        }
        self.probe_failed();
        None
    }

    /// Encodes the outstanding frame.
    fn encode(&mut self, form: Check, wire: &mut Vec<u8>) {
        let Some(outstanding) = &self.outstanding else { return };
        let requests = &outstanding.operation.requests;
        let size: usize = requests.iter().map(|request| request.bytes().len()).sum();
        let tag = outstanding.tag.map(Tag::to_bytes);
        let ends = outstanding.tag_ends(self.config.framing);
        let (first, last) = if ends { (None, tag.as_ref()) } else { (tag.as_ref(), None) };
        let size = size + tag.map_or(0, |tag| tag.len());
        // Written where it is sent.
        let fill = |place: &mut [u8]| {
            let mut rest = place.get_mut(..size)?;
            let mut put = |part: &[u8]| {
                let (start, others) = std::mem::take(&mut rest).split_at_mut_checked(part.len())?;
                start.copy_from_slice(part);
                rest = others;
                Some(())
            };
            if let Some(tag) = first {
                put(tag)?;
            }
            requests.iter().try_for_each(|request| put(request.bytes()))?;
            if let Some(tag) = last {
                put(tag)?;
            }
            Some(size)
        };
        let Addresses { monitor: dst, source: src } = self.config.addresses;
        wire.clear();
        let len = match self.config.framing {
            Framing::Records => {
                wire.resize(size, 0);
                fill(wire)
            }
            Framing::Link => {
                wire.resize(link::wire_max(size), 0);
                link::compose(form, dst, src, wire, fill)
            }
        };
        wire.truncate(len.unwrap_or(0));
        if self.traced.is_some() {
            self.trace_sent();
        }
    }

    #[cold]
    fn trace_sent(&mut self) {
        let Some(outstanding) = &self.outstanding else { return };
        let requests = outstanding.operation.requests.iter().map(RequestBuf::bytes);
        let (bytes, tagged) = (requests.collect::<Vec<_>>().concat(), outstanding.tag.is_some());
        let Addresses { monitor: dst, source: src } = self.config.addresses;
        self.trace(Verdict::Sent, dst, src, tagged, &bytes);
    }

    /// Makes the next operation the outstanding one, if it may be sent now.
    fn take_next(&mut self, now: Now) {
        let place = self.first_queued();
        let Some(operation) = self.urgent.front().or(self.queue.get(place)) else { return };
        let mut doubt = Doubt { asks: false, tag: None, believe_from: Now::ZERO };
        if self.is_doubtful(now, operation) {
            let Some(found) = self.doubt(now, place) else { return };
            doubt = found;
        }
        let Doubt { asks, tag, believe_from } = doubt;
        let operation = match self.urgent.is_empty() {
            _ if asks => Some(Operation::question(now)),
            true if place == 0 => self.queue.pop_front(),
            true => self.queue.remove(place),
            false => self.urgent.pop_front(),
        };
        self.outstanding = operation.map(|operation| Outstanding {
            operation,
            tag,
            tries: 0,
            sent: now,
            deadline: now,
            due: true,
            believe_from,
            untagged: false,
            forms: Forms::default(),
        });
    }

    /// How the next operation, which is in doubt, is sent; `None`: it waits.
    #[cold]
    fn doubt(&mut self, now: Now, place: usize) -> Option<Doubt> {
        let urgent = self.urgent.front();
        let operation = urgent.or(self.queue.get(place))?;
        if urgent.is_none() && self.drained(now, operation).is_some() {
            return None;
        }
        let until = self.suspicion.until(operation.first(), now, self.config.drain_bound);
        if !self.tags_work() {
            let believe_from = until.unwrap_or(Now::ZERO);
            return Some(Doubt { asks: false, tag: None, believe_from });
        }
        let asks = matches!(self.echo, Echo::Unknown { .. })
            && !operation.is_repeatable()
            && self.config.framing == Framing::Link;
        Some(Doubt { asks, tag: Some(self.tags.issue()), believe_from: Now::ZERO })
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
        let longest = self.wait_in_vain(&outstanding.operation).unwrap_or(self.config.timeout);
        let until = outstanding.deadline.min(outstanding.sent + longest);
        (now < until).then_some((outstanding.sent, until))
    }

    /// Whether an answer to another frame could be taken for one to this operation.
    fn is_doubtful(&self, now: Now, operation: &Operation) -> bool {
        if self.config.framing == Framing::Records {
            return true;
        }
        let bound = if self.tags_work() { self.config.late_bound } else { self.config.drain_bound };
        let looks_like_tag = |request: &RequestBuf| looks_like_tag(request.id(), request.to());
        self.suspicion.until(operation.first(), now, bound).is_some()
            || (operation.requests.iter().any(looks_like_tag) && self.tags_work())
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
