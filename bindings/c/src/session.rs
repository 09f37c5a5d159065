//! The controlling side of one monitor, without I/O: bytes to send and bytes received go through it,
//! and the time. One frame is out at a time; it is repeated until it is answered or given up.
//!
//! An answer is believed if it can be to what was asked ([`answers`]). The protocol has no numbers, so a
//! late answer to an earlier request of the same kind would look like that of the present one. While one may
//! come, a request of that kind waits; an urgent one is sent, but believed only when it has been sent once
//! more after that.
//!
//! For a controller on a chip; what a PC wants more (queues, redialling, batches, the bus) is the Rust
//! crate `lafet-client`.

mod answers;

use lafet_proto::Request;
use lafet_proto::id::key;
use lafet_proto::link::{self, Decoder, Frame, PAYLOAD_MAX};
use lafet_proto::record::Records;
use lafet_proto::request::Body;

use crate::link::lafet_frame;
use crate::{bytes, room};

/// What has become of the request.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum lafet_outcome {
    /// Nothing was asked, or the outcome has been reported.
    LAFET_IDLE,
    /// Waiting for the answer.
    LAFET_WAITING,
    /// Answered: the frame has the answers.
    LAFET_ANSWERED,
    /// Sent as often as allowed, and silence. Whether it was carried out is unknown.
    LAFET_SILENCE,
}

/// The longest time that an answer is waited for, ms.
pub const LAFET_TIMEOUT_MAX_MS: u32 = 60000;

/// A session with one monitor.
#[repr(C)]
pub struct lafet_session {
    /// For lafet alone.
    pub opaque: [u64; 168],
}
const _: () = assert!(size_of::<lafet_session>() >= size_of::<Session>());
const _: () = assert!(align_of::<lafet_session>() >= align_of::<Session>());

struct Session {
    monitor: u8,
    own: u8,
    timeout_ms: u32,
    tries: u8,
    payload: [u8; PAYLOAD_MAX],
    size: usize,
    outcome: lafet_outcome,
    /// Tries so far, without those while a late answer may come.
    tried: u8,
    /// Frames on the wire, each of which may be answered.
    sent: u8,
    /// A frame was sent while no late answer could come.
    believes: bool,
    sent_ms: u32,
    /// Time of the next try; at once if there is none.
    next_ms: Option<u32>,
    /// Requests to which late answers may come until `late_until_ms`.
    late: Kinds,
    late_until_ms: u32,
    decoder: Decoder,
}

/// A set of request ids. Id 0, which no request has, represents a probe.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Kinds([u32; 8]);

impl Kinds {
    const NONE: Self = Self([0; 8]);

    fn of(payload: &[u8]) -> Self {
        let mut kinds = Self::NONE;
        let mut add = |id: u8| kinds.0[usize::from(id >> 5)] |= 1 << (id & 31);
        if payload.is_empty() {
            add(0);
        }
        Records::new(payload).flatten().for_each(|record| add(record.request.0));
        kinds
    }

    fn with(mut self, other: Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(own, other)| *own |= other);
        self
    }

    fn has_any_of(&self, other: Self) -> bool {
        self.0.iter().zip(other.0).any(|(own, other)| own & other != 0)
    }
}

/// Whether `time` has not come yet. One that is further away than it can be has passed: nothing was called
/// for weeks, or the clock was set.
const fn is_ahead(time: u32, now: u32, longest: u32) -> bool {
    let left = time.wrapping_sub(now);
    left != 0 && left <= longest
}

/// Whether all of it is Stop, Close or Lockout on.
fn is_urgent(payload: &[u8]) -> bool {
    let urgent = |request: Request<'_>| {
        matches!(request.body, Body::Stop | Body::Close { .. } | Body::Lockout { key: key::ENABLE })
    };
    let mut records = Records::new(payload).flatten();
    !payload.is_empty() && records.all(|record| Request::decode(&record).is_ok_and(urgent))
}

impl Session {
    fn asked(&self) -> &[u8] {
        self.payload.get(..self.size).unwrap_or_default()
    }

    const fn waits(&self) -> bool {
        matches!(self.outcome, lafet_outcome::LAFET_WAITING)
    }

    fn ask(&mut self, asked: &[u8]) -> bool {
        // What is cut short is not carried out, nor is anything behind it.
        if asked.len() > PAYLOAD_MAX || Records::new(asked).any(|record| record.is_err()) {
            return false;
        }
        if self.waits() {
            if !is_urgent(asked) {
                return false;
            }
            if is_urgent(self.asked()) {
                return self.join(asked);
            }
            if self.sent > 0 {
                self.expect_late(self.sent_ms.wrapping_add(self.timeout_ms));
            }
        }
        let Some(place) = self.payload.get_mut(..asked.len()) else { return false };
        place.copy_from_slice(asked);
        self.size = asked.len();
        self.outcome = lafet_outcome::LAFET_WAITING;
        self.sent = 0;
        self.begin();
        true
    }

    /// Adds what is urgent to something urgent that waits: neither is given up for the other.
    fn join(&mut self, asked: &[u8]) -> bool {
        let before = self.size;
        let mut rest = asked;
        for record in Records::new(asked).flatten() {
            let Some((bytes, others)) = rest.split_at_checked(record.size()) else { break };
            rest = others;
            let known = Records::new(self.asked()).flatten().any(|other| other == record);
            if known {
                continue;
            }
            let Some(place) = self.payload.get_mut(self.size..self.size + bytes.len()) else {
                self.size = before;
                return false;
            };
            place.copy_from_slice(bytes);
            self.size += bytes.len();
        }
        if self.size > before {
            self.begin();
        }
        true
    }

    fn begin(&mut self) {
        self.tried = 0;
        self.believes = false;
        self.next_ms = None;
    }

    /// Answers to what was asked may come until then, and not be to what is asked next.
    fn expect_late(&mut self, until_ms: u32) {
        let longest = 2 * self.timeout_ms;
        let is_later = self.late == Kinds::NONE || is_ahead(until_ms, self.late_until_ms, longest);
        if is_later {
            self.late_until_ms = until_ms;
        }
        self.late = self.late.with(Kinds::of(self.asked()));
    }

    fn transmit(&mut self, now_ms: u32, out: &mut [u8]) -> usize {
        let longest = 2 * self.timeout_ms;
        if !is_ahead(self.late_until_ms, now_ms, longest) {
            self.late = Kinds::NONE;
        }
        if !self.waits() || self.next_ms.is_some_and(|next| is_ahead(next, now_ms, longest)) {
            return 0;
        }
        if self.tried >= self.tries {
            self.outcome = lafet_outcome::LAFET_SILENCE;
            if self.sent > 0 {
                self.expect_late(now_ms.wrapping_add(self.timeout_ms));
            }
            return 0;
        }
        let is_in_doubt = self.late.has_any_of(Kinds::of(self.asked()));
        if is_in_doubt && !is_urgent(self.asked()) {
            self.next_ms = Some(self.late_until_ms);
            return 0;
        }
        let frame = Frame { dst: self.monitor, src: self.own, payload: self.asked() };
        let len = link::encode(&frame, out).unwrap_or(0);
        let mut wait = self.timeout_ms;
        if is_in_doubt && len > 0 {
            wait = wait.min(self.late_until_ms.wrapping_sub(now_ms));
        } else {
            // One for which there is no room is a try as well, so that there is an end.
            self.tried += 1;
        }
        self.next_ms = Some(now_ms.wrapping_add(wait));
        if len > 0 {
            self.sent = self.sent.saturating_add(1);
            self.sent_ms = now_ms;
            self.believes |= !is_in_doubt;
        }
        len
    }

    /// Takes bytes; how many, and whether they complete the answer.
    fn receive(&mut self, data: &[u8]) -> (usize, bool) {
        let (taken, found) = self.decoder.push_slice(data);
        let is_answer = found.is_some_and(|frame| {
            let asked = self.payload.get(..self.size).unwrap_or_default();
            (frame.dst, frame.src) == (self.own, self.monitor)
                && answers::answers(asked, frame.payload)
        });
        let is_answered = self.waits() && self.believes && is_answer;
        if is_answered {
            self.outcome = lafet_outcome::LAFET_ANSWERED;
            if self.sent > 1 {
                self.expect_late(self.sent_ms.wrapping_add(self.timeout_ms));
            }
        }
        (taken, is_answered)
    }
}

/// Makes a session: `own` is the controller's address (129…254). An answer is waited for
/// `timeout_ms` (1 to `LAFET_TIMEOUT_MAX_MS`; what is outside counts as the nearer of the two), and
/// the request sent at most `tries` times, 0 counting as 1.
///
/// # Safety
/// `session` is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_session_init(
    session: *mut lafet_session,
    monitor: u8,
    own: u8,
    timeout_ms: u32,
    tries: u8,
) {
    if session.is_null() {
        return;
    }
    let new = Session {
        monitor,
        own,
        timeout_ms: timeout_ms.clamp(1, LAFET_TIMEOUT_MAX_MS),
        tries: tries.max(1),
        payload: [0; PAYLOAD_MAX],
        size: 0,
        outcome: lafet_outcome::LAFET_IDLE,
        tried: 0,
        sent: 0,
        believes: false,
        sent_ms: 0,
        next_ms: None,
        late: Kinds::NONE,
        late_until_ms: 0,
        decoder: Decoder::new(),
    };
    // SAFETY: large enough and aligned, as asserted above; not null.
    unsafe { session.cast::<Session>().write(new) }
}

/// Asks: `payload` has one record or more, none for a presence probe. False while another request
/// waits, or if it is too long or its last record is cut short.
///
/// What is urgent (all of it Stop, Close or Lockout on) does not wait: it takes the place of another request,
/// which is not sent again and has no outcome; whether that was carried out is unknown. If one that waits is
/// urgent as well, they become one: the answers of both are in one frame. False only if they are too long.
///
/// # Safety
/// The session was initialised; `size` is that of `payload`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_session_ask(
    session: *mut lafet_session,
    payload: *const u8,
    size: usize,
) -> bool {
    // SAFETY: the caller's promise.
    let (session, asked) = unsafe { (session.cast::<Session>().as_mut(), bytes(payload, size)) };
    let (Some(session), Some(asked)) = (session, asked) else { return false };
    session.ask(asked)
}

/// Bytes to send now, if any: writes them to `out` (`LAFET_WIRE_MAX` suffices) and returns their number.
/// Call it after each of the other functions, and when time passes.
///
/// While an answer to an earlier request of the same kind may still come (for `timeout_ms` after
/// `LAFET_SILENCE`, and after the last time that it was sent), a request waits; what is urgent is sent, and
/// once more after that time.
///
/// # Safety
/// The session was initialised; `out_size` is that of `out`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_session_transmit(
    session: *mut lafet_session,
    now_ms: u32,
    out: *mut u8,
    out_size: usize,
) -> usize {
    // SAFETY: the caller's promise.
    let (session, out) = unsafe { (session.cast::<Session>().as_mut(), room(out, out_size)) };
    let (Some(session), Some(out)) = (session, out) else { return 0 };
    session.transmit(now_ms, out)
}

/// Takes bytes that were received; returns how many: call it again with the rest. After
/// `LAFET_ANSWERED` the answers are in `answer` until the next call.
///
/// # Safety
/// The session was initialised; `size` is that of `data`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_session_receive(
    session: *mut lafet_session,
    data: *const u8,
    size: usize,
    answer: *mut lafet_frame,
) -> usize {
    // SAFETY: the caller's promise.
    let (session, data) = unsafe { (session.cast::<Session>().as_mut(), bytes(data, size)) };
    // SAFETY: null or writable, says the caller.
    let answer = unsafe { answer.as_mut() };
    let (Some(session), Some(data), Some(answer)) = (session, data, answer) else { return 0 };
    let (taken, is_answered) = session.receive(data);
    if let Some(frame) = session.decoder.last().filter(|_| is_answered) {
        let Frame { dst, src, payload } = frame;
        *answer = lafet_frame { dst, src, payload: payload.as_ptr(), size: payload.len() };
    }
    taken
}

/// What has become of the request; an outcome is reported once.
///
/// # Safety
/// The session was initialised.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lafet_session_outcome(session: *mut lafet_session) -> lafet_outcome {
    // SAFETY: the caller's promise.
    let Some(session) = (unsafe { session.cast::<Session>().as_mut() }) else {
        return lafet_outcome::LAFET_IDLE;
    };
    let outcome = session.outcome;
    if outcome != lafet_outcome::LAFET_WAITING {
        session.outcome = lafet_outcome::LAFET_IDLE;
    }
    outcome
}
