//! The session on virtual time, against a monitor and a network that misbehave.

use lafet_proto::link::{self, Decoder, Frame, wire_max};
use lafet_proto::record::Writer;
use lafet_proto::request::Body;
use lafet_proto::{Ints, ParamId, Request, Status, SubsystemId};

use super::*;
use crate::answers::RequestBuf;
use numbered::{Unknown, answer, number_of};

mod late;
#[path = "../../tests/fake/numbered.rs"]
mod numbered;

const MS: Duration = Duration::from_millis(1);

fn buf(request: Request<'_>) -> RequestBuf {
    RequestBuf::new(&request).expect("fits a record")
}

fn to(to: SubsystemId, body: Body<'_>) -> RequestBuf {
    buf(Request::new(to, body))
}

fn status_all() -> RequestBuf {
    to(SubsystemId::ALL, Body::GetStatus)
}

fn param(id: u16) -> RequestBuf {
    to(SubsystemId::CONTROL, Body::GetParam { id: ParamId(id) })
}

fn moving() -> RequestBuf {
    to(SubsystemId::VERTICAL, Body::Move { destination: 1200 })
}

fn stop() -> RequestBuf {
    to(SubsystemId::ALL, Body::Stop)
}

/// The number that an answer carries.
fn number_in(answer: &crate::AnswerBuf) -> Option<u32> {
    number_of(answer.request(), answer.data())
}

fn frame(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut wire = vec![0; wire_max(payload.len())];
    let len = link::encode(&Frame { dst, src, payload }, &mut wire).expect("room");
    wire.truncate(len);
    wire
}

fn payload_of(bytes: &[u8]) -> Vec<u8> {
    let mut decoder: Decoder = Decoder::new();
    let (_, frame) = decoder.push_slice(bytes);
    frame.expect("a frame").payload.to_vec()
}

fn after(first: Ticket) -> Terms {
    Terms { first: Some(first), ..Terms::default() }
}

fn connected(config: Config) -> Session {
    let mut session = Session::new(config);
    session.handle_connected(Now::ZERO);
    session
}

/// Sends what is due and returns the payload of the frame.
fn sent(session: &mut Session, now: Now) -> Vec<u8> {
    payload_of(&session.poll_transmit(now).expect("a frame is due"))
}

/// The monitor answers the frame.
fn reply(session: &mut Session, now: Now, payload: &[u8], serial: u32) {
    session.handle_bytes(now, &frame(129, 1, &answer(payload, serial, Unknown::Answered)));
}

#[test]
fn a_frame_goes_out_plain_while_nothing_is_in_doubt() {
    let mut session = connected(Config::default());
    for serial in 0..3 {
        let now = serial * MS;
        let ticket = session.submit(now, vec![param(1)]).unwrap();
        let payload = sent(&mut session, now);
        assert_eq!(payload, [0x9D, 0x45, 0, 2, 1, 0]);
        assert_eq!(session.poll_transmit(now), None, "one frame at a time");
        reply(&mut session, now + MS, &payload, serial);
        let (ended, outcome) = session.poll_outcome().expect("answered");
        assert!(ended == ticket && matches!(outcome, Outcome::Answered(_)));
    }
    assert_eq!(session.stats().rtt_average, Some(MS));
    assert!(session.is_idle() && session.poll_timeout(3 * MS).is_none());
}

#[test]
fn reads_are_repeated_commands_are_not() {
    let second = Duration::from_secs(1);
    for (request, tries) in [(param(1), 3), (moving(), 1)] {
        let mut session = connected(Config::default());
        session.submit(Now::ZERO, vec![request]).unwrap();
        let first = sent(&mut session, Now::ZERO);
        for n in 1..tries {
            assert_eq!(session.poll_timeout(Now::ZERO), Some(n * second));
            session.handle_timeout(n * second - MS);
            assert_eq!(session.poll_transmit(n * second - MS), None);
            session.handle_timeout(n * second);
            assert_eq!(sent(&mut session, n * second), first);
        }
        session.handle_timeout(tries * second);
        assert_eq!(
            session.poll_outcome().map(|(_, end)| end),
            Some(Outcome::Silence { tries, stray: None })
        );
        assert_eq!(session.stats().timeouts, u64::from(tries));
    }
}

/// A lost Stop costs 150 ms, not a second; it is given up no sooner than anything else.
#[test]
fn urgent_requests_are_repeated_sooner() {
    let mut session = connected(Config::default());
    session.submit(Now::ZERO, vec![stop()]).unwrap();
    let first = sent(&mut session, Now::ZERO);
    for at in [150, 450, 1050, 2050] {
        let at = at * MS;
        assert_eq!(session.poll_timeout(at - MS), Some(at));
        session.handle_timeout(at);
        assert_eq!(sent(&mut session, at), first);
    }
    session.handle_timeout(3050 * MS);
    let ended = session.poll_outcome().map(|(_, outcome)| outcome);
    assert_eq!(ended, Some(Outcome::Silence { tries: 5, stray: None }));
}

/// §3.1: a motion that is no longer held is not sent late.
#[test]
fn what_has_expired_is_not_sent() {
    let mut session = connected(Config::default());
    session.submit(Now::ZERO, vec![param(1)]).unwrap();
    let payload = sent(&mut session, Now::ZERO);
    let terms = Terms { expires: Some(300 * MS), ..Terms::default() };
    let moved = session.submit_on(Now::ZERO, terms, vec![moving()]).unwrap();
    assert_eq!(session.poll_timeout(Now::ZERO), Some(300 * MS));
    // The program stood still: everything comes at once, and too late.
    session.handle_timeout(900 * MS);
    reply(&mut session, 900 * MS, &payload, 1);
    assert_eq!(session.poll_transmit(900 * MS), None);
    let ends: Vec<_> = std::iter::from_fn(|| session.poll_outcome()).collect();
    assert!(ends.contains(&(moved, Outcome::Expired)), "{ends:?}");
    assert!(session.is_idle());
}

#[test]
fn after_a_timeout_frames_are_numbered_until_the_bound() {
    let mut session = connected(Config { tries: 1, ..Config::default() });
    let second = Duration::from_secs(1);
    session.submit(Now::ZERO, vec![param(1)]).unwrap();
    let lost = sent(&mut session, Now::ZERO);
    session.handle_timeout(second);
    session.poll_outcome().expect("silence");

    session.submit(second, vec![param(1)]).unwrap();
    let tagged = sent(&mut session, second);
    assert_eq!(tagged.len(), lost.len() + Tag::SIZE);
    assert_eq!(tagged[Tag::SIZE..], lost);
    reply(&mut session, second, &lost, 7);
    assert_eq!(session.poll_outcome(), None, "the late answer is not believed");
    assert_eq!(session.stats().late, 1);
    reply(&mut session, second, &tagged, 8);
    let Some((_, Outcome::Answered(slots))) = session.poll_outcome() else { panic!("answered") };
    let Slot::Answered(answers) = &slots[0] else { panic!("answered") };
    assert_eq!(number_in(answers.first()), Some(8));
    reply(&mut session, second, &tagged, 8);
    assert_eq!(session.stats().duplicates, 1);

    // Another request cannot be confused, and after the bound nothing can.
    session.submit(second, vec![moving()]).unwrap();
    let payload = sent(&mut session, second);
    assert_eq!(payload.len(), 6);
    reply(&mut session, second, &payload, 9);
    session.submit(30 * second, vec![param(1)]).unwrap();
    assert_eq!(sent(&mut session, 30 * second), lost);
}

#[test]
fn urgent_requests_overtake_and_remove_what_they_undo() {
    let mut session = connected(Config::default());
    let reading = session.submit(Now::ZERO, vec![param(1)]).unwrap();
    let payload = sent(&mut session, Now::ZERO);
    let moved = session.submit(Now::ZERO, vec![moving()]).unwrap();
    let asked = session.submit(Now::ZERO, vec![status_all()]).unwrap();
    let stopped = session.submit(Now::ZERO, vec![stop()]).unwrap();
    let by = RequestId::STOP;
    let superseded = Outcome::Superseded { by, sent: false };
    assert_eq!(session.poll_outcome(), Some((moved, superseded)));

    // The outstanding frame has a moment left, then the Stop goes out.
    assert_eq!(session.poll_timeout(Now::ZERO), Some(150 * MS));
    session.handle_timeout(149 * MS);
    assert_eq!(session.poll_transmit(149 * MS), None);
    session.handle_timeout(150 * MS);
    let stop_payload = sent(&mut session, 150 * MS);
    assert_eq!(stop_payload, [0x46, 0x5D, 0, 0]);
    reply(&mut session, 151 * MS, &payload, 1);
    assert_eq!(session.stats().late, 1);
    reply(&mut session, 152 * MS, &stop_payload, 2);
    for ticket in [stopped, reading, asked] {
        if ticket != stopped {
            let payload = sent(&mut session, 160 * MS);
            reply(&mut session, 160 * MS, &payload, 3);
        }
        let (ended, outcome) = session.poll_outcome().expect("answered");
        assert!(ended == ticket && matches!(outcome, Outcome::Answered(_)), "{outcome:?}");
    }
}

#[test]
fn a_stop_overtakes_the_rest_of_a_batch() {
    let mut session = connected(Config::default());
    let first = session.submit(Now::ZERO, vec![moving()]).unwrap();
    let payload = sent(&mut session, Now::ZERO);
    reply(&mut session, MS, &payload, 0);
    session.poll_outcome().expect("answered");
    session.submit(MS, vec![stop()]).unwrap();
    let rest = session.submit_on(MS, after(first), vec![moving()]).unwrap();
    let outcome = Outcome::Superseded { by: RequestId::STOP, sent: false };
    assert_eq!(session.poll_outcome(), Some((rest, outcome)));
    // Reads of that batch, and what is asked after the Stop, are sent.
    session.submit_on(MS, after(first), vec![param(1)]).unwrap();
    let later = session.submit(MS, vec![moving()]).unwrap();
    session.submit_on(MS, after(later), vec![moving()]).unwrap();
    assert_eq!(session.poll_outcome(), None);
}

#[test]
fn a_command_overtaken_on_the_line_has_an_unknown_outcome() {
    let mut session = connected(Config::default());
    let moved = session.submit(Now::ZERO, vec![moving()]).unwrap();
    let payload = sent(&mut session, Now::ZERO);
    session.submit(10 * MS, vec![stop()]).unwrap();
    session.handle_timeout(150 * MS);
    let outcome = Outcome::Superseded { by: RequestId::STOP, sent: true };
    assert_eq!(session.poll_outcome(), Some((moved, outcome)));
    assert_eq!(sent(&mut session, 150 * MS), [0x46, 0x5D, 0, 0]);
    reply(&mut session, 160 * MS, &payload, 0);
    assert_eq!(session.poll_outcome(), None);
}

#[test]
fn what_is_cancelled_is_not_sent_but_a_stop_is() {
    let mut session = connected(Config::default());
    let moved = session.submit(Now::ZERO, vec![moving()]).unwrap();
    session.cancel(moved);
    assert!(session.is_idle());
    let stopped = session.submit(Now::ZERO, vec![stop()]).unwrap();
    session.cancel(stopped);
    assert!(session.is_urgent());
    sent(&mut session, Now::ZERO);
    session.handle_timeout(150 * MS);
    sent(&mut session, 150 * MS);

    // On the line: no retry without a caller, and the answer is still classified correctly.
    let mut session = connected(Config::default());
    let asked = session.submit(Now::ZERO, vec![param(1)]).unwrap();
    let payload = sent(&mut session, Now::ZERO);
    session.cancel(asked);
    session.submit(Now::ZERO, vec![param(1)]).unwrap();
    session.handle_timeout(Duration::from_secs(1));
    assert_ne!(sent(&mut session, Duration::from_secs(1)), payload);
}

#[test]
fn foreign_garbled_and_unasked_frames_are_counted() {
    let mut session = connected(Config::default());
    session.submit(Now::ZERO, vec![param(1)]).unwrap();
    let payload = sent(&mut session, Now::ZERO);
    let good = answer(&payload, 5, Unknown::Answered);
    session.handle_bytes(MS, &frame(129, 2, &good));
    session.handle_bytes(MS, &frame(130, 1, &good));
    session.handle_bytes(MS, &frame(129, 1, &answer(param(2).bytes(), 5, Unknown::Answered)));
    let mut broken = frame(129, 1, &good);
    broken[6] ^= 1;
    session.handle_bytes(MS, &broken);
    session.handle_bytes(MS, b"\xC0garbage\xDB\x00");
    assert_eq!(session.poll_outcome(), None);
    let Stats { foreign, unmatched, crc_errors, framing_errors, .. } = session.stats();
    assert_eq!((foreign, unmatched, crc_errors, framing_errors), (2, 1, 1, 1));
    // Byte by byte, after all that, the answer is found.
    for byte in frame(129, 1, &good) {
        session.handle_bytes(2 * MS, &[byte]);
    }
    assert!(matches!(session.poll_outcome(), Some((_, Outcome::Answered(_)))));
}

#[test]
fn a_lost_link_tells_what_may_have_been_executed() {
    let mut session = connected(Config::default());
    let moved = session.submit(Now::ZERO, vec![moving()]).unwrap();
    sent(&mut session, Now::ZERO);
    let waiting = session.submit(Now::ZERO, vec![moving()]).unwrap();
    session.handle_disconnected(100 * MS);
    assert_eq!(session.poll_outcome(), Some((moved, Outcome::LinkLost)));
    assert_eq!(session.poll_transmit(100 * MS), None);
    assert_eq!(session.poll_timeout(100 * MS), Some(Duration::from_secs(1)));
    session.handle_timeout(Duration::from_secs(1));
    assert_eq!(session.poll_outcome(), Some((waiting, Outcome::NotConnected)));

    // A read is asked again over the next connection.
    let mut session = connected(Config::default());
    session.submit(Now::ZERO, vec![param(1)]).unwrap();
    sent(&mut session, Now::ZERO);
    session.handle_disconnected(MS);
    session.handle_connected(Now::ZERO);
    let payload = sent(&mut session, 2 * MS);
    reply(&mut session, 3 * MS, &payload, 1);
    assert!(matches!(session.poll_outcome(), Some((_, Outcome::Answered(_)))));
    assert_eq!(session.stats().reconnects, 1);
}

#[test]
fn queues_have_limits() {
    let mut session = Session::new(Config::default());
    for _ in 0..QUEUE_MAX {
        session.submit(Now::ZERO, vec![param(1)]).unwrap();
    }
    assert_eq!(session.submit(Now::ZERO, vec![param(1)]), Err(QueueFull));
    for _ in 0..URGENT_MAX {
        session.submit(Now::ZERO, vec![stop()]).unwrap();
    }
    assert_eq!(session.submit(Now::ZERO, vec![stop()]), Err(QueueFull));
}

#[test]
fn a_probe_is_an_empty_frame_and_numbered_in_doubt() {
    let mut session = connected(Config { tries: 1, ..Config::default() });
    session.submit(Now::ZERO, vec![]).unwrap();
    assert!(sent(&mut session, Now::ZERO).is_empty());
    session.handle_timeout(Duration::from_secs(1));
    session.poll_outcome().expect("silence");
    session.submit(Duration::from_secs(1), vec![]).unwrap();
    let tag = sent(&mut session, Duration::from_secs(1));
    assert_eq!(tag.len(), Tag::SIZE);
    reply(&mut session, Duration::from_secs(1), &[], 0);
    assert_eq!(session.poll_outcome(), None);
    reply(&mut session, Duration::from_secs(1), &tag, 0);
    assert!(matches!(session.poll_outcome(), Some((_, Outcome::Answered(_)))));
}

/// Bare records: the tag after the requests marks the end of the answers.
#[test]
fn bare_records_end_with_their_tag() {
    let mut session = connected(Config { framing: Framing::Records, ..Config::default() });
    session.set_tracing(true);
    session.submit(Now::ZERO, vec![status_all()]).unwrap();
    let late = session.poll_transmit(Now::ZERO).expect("due");
    assert_eq!(late[..4], [0xD4, 0x5D, 0, 0]);
    assert_eq!(late.len(), 4 + Tag::SIZE);
    session.handle_timeout(Duration::from_secs(1));
    // The same operation: the first answer, in pieces, answers it.
    session.poll_transmit(Duration::from_secs(1)).expect("again");
    for byte in answer(&late, 3, Unknown::Answered) {
        assert_eq!(session.poll_outcome(), None);
        session.handle_bytes(Duration::from_secs(1), &[byte]);
    }
    assert!(matches!(session.poll_outcome(), Some((_, Outcome::Answered(_)))));
    // The answer to the second try comes before that to the next request.
    session.submit(Duration::from_secs(2), vec![status_all()]).unwrap();
    let next = session.poll_transmit(Duration::from_secs(2)).expect("due");
    session.handle_bytes(Duration::from_secs(2), &answer(&late, 4, Unknown::Answered));
    assert_eq!(session.poll_outcome(), None);
    session.handle_bytes(Duration::from_secs(2), &answer(&next, 5, Unknown::Answered));
    let Some((_, Outcome::Answered(slots))) = session.poll_outcome() else { panic!("answered") };
    let Slot::Answered(answers) = &slots[0] else { panic!("answered") };
    assert!(answers.iter().all(|answer| number_in(answer) == Some(5)));
    let traced: Vec<_> = std::iter::from_fn(|| session.poll_traced()).collect();
    assert_eq!(traced.len(), 5);
    assert!(traced[0].tagged && traced[0].payload[..] == [0xD4, 0x5D, 0, 0]);
}

#[test]
fn datagrams_are_frames() {
    let mut session = connected(Config { duplicates: true, ..Config::default() });
    session.submit(Now::ZERO, vec![param(1)]).unwrap();
    let payload = sent(&mut session, Now::ZERO);
    let mut good = frame(129, 1, &answer(&payload, 1, Unknown::Answered));
    session.handle_datagram(MS, &good[..good.len() - 1]);
    good[5] ^= 4;
    session.handle_datagram(MS, &good);
    good[5] ^= 4;
    session.handle_datagram(MS, &good);
    assert!(matches!(session.poll_outcome(), Some((_, Outcome::Answered(_)))));
    let Stats { frames_received, crc_errors, framing_errors, .. } = session.stats();
    assert_eq!((frames_received, crc_errors, framing_errors), (1, 1, 1));
    // UDP may copy: the next one is numbered.
    session.submit(MS, vec![param(1)]).unwrap();
    assert_eq!(sent(&mut session, MS).len(), payload.len() + Tag::SIZE);
}

/// A monitor that refuses whatever does not fit: General has the last word (§1, §2).
#[test]
fn a_full_buffer_leaves_requests_unexecuted() {
    let mut session = connected(Config::default());
    session.submit(Now::ZERO, vec![param(1), param(2), moving()]).unwrap();
    sent(&mut session, Now::ZERO);
    let values = [7];
    let fits = lafet_proto::Answer {
        from: SubsystemId::CONTROL,
        request: RequestId::GET_PARAM,
        status: Status::OK,
        data: lafet_proto::answer::Reply::Param { id: ParamId(1), values: Ints::Values(&values) },
    };
    let bare = |from| lafet_proto::Answer::bare(from, RequestId::GET_PARAM, Status::NO_ROOM);
    let mut buffer = [0; 64];
    let mut out = Writer::new(&mut buffer);
    for answer in [fits, bare(SubsystemId::CONTROL), bare(SubsystemId::GENERAL)] {
        answer.encode(&mut out).unwrap();
    }
    session.handle_bytes(MS, &frame(129, 1, out.written()));
    let Some((_, Outcome::Answered(slots))) = session.poll_outcome() else { panic!("answered") };
    assert!(matches!(&slots[1], Slot::Answered(answers) if answers.lacks_room()));
    assert_eq!(slots[2], Slot::NotExecuted);
}
