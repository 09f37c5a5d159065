//! The controlling side of one monitor, without I/O: bytes to send and bytes received go through it,
//! and the time. One frame is out at a time; it is repeated until it is answered or given up.
//!
//! For a controller on a chip; what a PC wants more (queues, redialling, batches, the bus) is the Rust
//! crate `lafet-client`.

use lafet_proto::RequestId;
use lafet_proto::link::{self, Decoder, Frame, PAYLOAD_MAX};
use lafet_proto::record::Records;

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

/// A session with one monitor.
#[repr(C)]
pub struct lafet_session {
    /// For lafet alone.
    pub opaque: [u64; 160],
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
    sent: u8,
    deadline_ms: u32,
    decoder: Decoder,
}

impl Session {
    fn is_answer(&self, frame: &Frame<'_>) -> bool {
        let asked = Records::new(self.payload.get(..self.size).unwrap_or_default());
        let requests = |records: Records<'_>, id: RequestId| {
            records.flatten().any(|record| record.request == id)
        };
        let mut answers = Records::new(frame.payload);
        frame.dst == self.own
            && frame.src == self.monitor
            && frame.payload.is_empty() == (self.size == 0)
            && answers.all(|a| a.is_ok_and(|a| requests(asked.clone(), a.request)))
    }
}

/// Makes a session: `own` is the controller's address (129…254). An answer is waited for
/// `timeout_ms`, and the request sent at most `tries` times.
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
        timeout_ms,
        tries,
        payload: [0; PAYLOAD_MAX],
        size: 0,
        outcome: lafet_outcome::LAFET_IDLE,
        sent: 0,
        deadline_ms: 0,
        decoder: Decoder::new(),
    };
    // SAFETY: large enough and aligned, as asserted above; not null.
    unsafe { session.cast::<Session>().write(new) }
}

/// Asks: `payload` has one record or more, none for a presence probe. False while another request
/// waits, or if it is too long.
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
    let Some(session) = session.filter(|s| s.outcome != lafet_outcome::LAFET_WAITING) else {
        return false;
    };
    let Some(place) = session.payload.get_mut(..asked.len()) else { return false };
    place.copy_from_slice(asked);
    session.size = asked.len();
    session.outcome = lafet_outcome::LAFET_WAITING;
    session.sent = 0;
    true
}

/// Bytes to send now, if any: writes them to `out` and returns their number. Call it after
/// each of the other functions, and when time passes.
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
    let Some(session) = session.filter(|s| s.outcome == lafet_outcome::LAFET_WAITING) else {
        return 0;
    };
    let waits = session.deadline_ms.wrapping_sub(now_ms) as i32 > 0;
    if session.sent > 0 && waits {
        return 0;
    }
    if session.sent >= session.tries {
        session.outcome = lafet_outcome::LAFET_SILENCE;
        return 0;
    }
    let Session { monitor, own, payload, size, .. } = session;
    let payload = payload.get(..*size).unwrap_or_default();
    let Some(len) = link::encode(&Frame { dst: *monitor, src: *own, payload }, out) else {
        return 0;
    };
    session.sent += 1;
    session.deadline_ms = now_ms.wrapping_add(session.timeout_ms);
    len
}

/// Takes bytes that were received; returns how many: call it again with the rest. After
/// `LAFET_ANSWERED` the answers stand in `answer` until the next call.
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
    let (Some(session), Some(answer)) = (session, unsafe { answer.as_mut() }) else { return 0 };
    let (taken, found) = session.decoder.push_slice(data);
    let found = found.is_some();
    let frame = session.decoder.last().filter(|_| found && session.sent > 0);
    let waiting = session.outcome == lafet_outcome::LAFET_WAITING;
    if let Some(frame) = frame.filter(|frame| waiting && session.is_answer(frame)) {
        let Frame { dst, src, payload } = frame;
        *answer = lafet_frame { dst, src, payload: payload.as_ptr(), size: payload.len() };
        session.outcome = lafet_outcome::LAFET_ANSWERED;
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
