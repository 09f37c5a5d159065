//! Stop, Close and Lockout on against lines, monitors and connections that fail, on virtual time.

use std::time::Duration;

use crate::fake::{Log, answer, encode, frame, serve};
use lafet_client::bus::{Controller, ControllerConfig, Port, Ports};
use lafet_client::session::line::Line;
use lafet_client::session::{Config, Now, Outcome, Terms, Ticket};
use lafet_client::transport::memory::pair;
use lafet_client::{Client, RequestBuf};
use lafet_proto::id::key;
use lafet_proto::link::Decoder;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use tokio::time::{Instant, sleep};

const MS: Duration = Duration::from_millis(1);
const STOP: &[u8] = &[0x46, 0x5D, 0, 0];

/// Whether a frame has a Stop; one that is repeated has a number as well.
fn stops(payload: &[u8]) -> bool {
    payload.windows(STOP.len()).any(|record| record == STOP)
}

fn connected(config: Config) -> Line {
    let mut line = Line::new(config);
    line.handle_connected(Now::ZERO);
    line
}

fn ask(line: &mut Line, now: Now, to: SubsystemId, body: Body<'_>) -> Ticket {
    let request = RequestBuf::new(&Request::new(to, body)).unwrap();
    line.submit(now, 1, Terms::default(), vec![request]).unwrap()
}

/// Runs the line until a time, with what each frame is answered; the frames sent, with their times.
fn run(
    line: &mut Line,
    (from, until): (Now, Now),
    answers: impl Fn(&[u8]) -> bool,
) -> Vec<(Now, Vec<u8>)> {
    let (mut now, mut sent) = (from, Vec::new());
    while now < until {
        line.handle_timeout(now);
        while let Some(bytes) = line.poll_transmit(now) {
            let payload = payload(&bytes);
            if answers(&payload) {
                line.handle_bytes(now, &encode(129, 1, &answer(&payload)));
            }
            sent.push((now, payload));
        }
        now = line.poll_timeout(now).unwrap_or(until).max(now + MS);
    }
    sent
}

fn payload(bytes: &[u8]) -> Vec<u8> {
    let mut decoder: Decoder = Decoder::new();
    decoder.push_slice(bytes).1.expect("a frame").payload.to_vec()
}

fn ends(line: &mut Line) -> Vec<(Ticket, Outcome)> {
    std::iter::from_fn(|| line.poll_outcome()).collect()
}

/// A connection that is lost between two tries of a Stop: it goes out over the next one.
#[test]
fn a_stop_outlives_its_connection() {
    for lost_at in [0, 100, 449, 500, 1_500, 2_900].map(|ms| MS * ms) {
        let mut line = connected(Config::default());
        let stop = ask(&mut line, Now::ZERO, SubsystemId::ALL, Body::Stop);
        let before = run(&mut line, (Now::ZERO, lost_at + MS), |_| false);
        assert!(!before.is_empty());
        line.handle_disconnected(lost_at + MS);
        assert_eq!(ends(&mut line), [], "lost at {lost_at:?}");
        let back = lost_at + 50 * MS;
        line.handle_connected(back);
        let after = run(&mut line, (back, back + 100 * MS), stops);
        assert_eq!(after[0].0, back, "lost at {lost_at:?}");
        let ends = ends(&mut line);
        assert!(
            matches!(&ends[..], [(ticket, Outcome::Answered(_))] if *ticket == stop),
            "lost at {lost_at:?}: {ends:?}"
        );
    }
}

/// One that is given while there is no connection goes out at once over the next, as long as its tries would
/// have taken. What starts something is not sent so late.
#[test]
fn a_stop_waits_for_a_line_that_is_away() {
    let close = Body::Close { key: key::CLOSE };
    let open = Body::Open { key: key::OPEN };
    for body in [Body::Stop, close, open] {
        let (urgent, valve) = (!matches!(body, Body::Open { .. }), SubsystemId::VALVE1);
        for away in [500, 1_001, 2_999, 3_001].map(|ms| MS * ms) {
            let mut line = connected(Config::default());
            line.handle_disconnected(Now::ZERO);
            let asked = ask(&mut line, Now::ZERO, valve, body);
            assert_eq!(run(&mut line, (Now::ZERO, away), |_| true), [], "{body:?}");
            line.handle_connected(away);
            let sent = run(&mut line, (away, away + 100 * MS), |_| true);
            let ends = ends(&mut line);
            if away < MS * if urgent { 3_000 } else { 1_000 } {
                assert_eq!(sent[0].0, away, "{body:?}");
                assert!(matches!(&ends[..], [(ticket, Outcome::Answered(_))] if *ticket == asked));
            } else {
                assert_eq!((sent, ends), (vec![], vec![(asked, Outcome::NotConnected)]));
            }
        }
    }
}

/// However often the connection is lost, a Stop that is never answered ends.
#[test]
fn a_stop_without_any_answer_ends() {
    let mut line = connected(Config::default());
    ask(&mut line, Now::ZERO, SubsystemId::ALL, Body::Stop);
    let mut now = Now::ZERO;
    for _ in 0..20 {
        run(&mut line, (now, now + 300 * MS), |_| false);
        now += 300 * MS;
        line.handle_disconnected(now);
        line.handle_connected(now);
    }
    assert!(matches!(&ends(&mut line)[..], [(_, Outcome::LinkLost | Outcome::Silence { .. })]));
    assert!(line.is_idle());
}

/// A half-open connection shows before a Stop is given up: silence counts by time, not by tries.
#[test]
fn a_stop_without_answers_shows_a_half_open_connection() {
    let mut line = connected(Config::default());
    ask(&mut line, Now::ZERO, SubsystemId::ALL, Body::Stop);
    run(&mut line, (Now::ZERO, 1_000 * MS), |_| false);
    assert_eq!(line.silent_tries(), 0, "not before its time");
    run(&mut line, (1_000 * MS, 2_500 * MS), |_| false);
    assert!(line.silent_tries() >= 2, "{}", line.silent_tries());
    assert_eq!(ends(&mut line), [], "it is still tried");
}

/// An urgent request that is never answered does not hold back another one, in either order.
#[test]
fn urgent_requests_take_turns() {
    let valve = SubsystemId::VALVE1;
    let mut line = connected(Config { timeout: 10_000 * MS, ..Config::default() });
    ask(&mut line, Now::ZERO, valve, Body::Close { key: key::CLOSE });
    run(&mut line, (Now::ZERO, MS), |_| false);
    let stop = ask(&mut line, 10 * MS, SubsystemId::ALL, Body::Stop);
    let sent = run(&mut line, (10 * MS, 200 * MS), stops);
    assert!(sent.iter().any(|(at, it)| *at <= 150 * MS && stops(it)), "{sent:?}");
    let ends = ends(&mut line);
    assert!(matches!(&ends[..], [(ticket, Outcome::Answered(_))] if *ticket == stop), "{ends:?}");
    // Without any answer both are repeated.
    let mut line = connected(Config::default());
    ask(&mut line, Now::ZERO, valve, Body::Close { key: key::CLOSE });
    ask(&mut line, Now::ZERO, SubsystemId::ALL, Body::Stop);
    let sent = run(&mut line, (Now::ZERO, 3_000 * MS), |_| false);
    let count = sent.iter().filter(|(_, payload)| stops(payload)).count();
    assert!(count >= 2 && sent.len() - count >= 2, "{count} of {sent:x?}");
    // A later one goes before the repetitions of both.
    let mut line = connected(Config::default());
    ask(&mut line, Now::ZERO, valve, Body::Close { key: key::CLOSE });
    ask(&mut line, Now::ZERO, SubsystemId::ALL, Body::Stop);
    run(&mut line, (Now::ZERO, 400 * MS), |_| false);
    let lockout = Body::Lockout { key: key::ENABLE };
    ask(&mut line, 400 * MS, SubsystemId::ALL, lockout);
    let sent = run(&mut line, (400 * MS, 560 * MS), |_| false);
    assert!(sent.iter().any(|(_, it)| it.starts_with(&[0xE9])), "{sent:?}");
}

/// A line that is never quiet does not hold back a Stop; it does hold back a read.
#[test]
fn a_babbling_line_does_not_hold_back_a_stop() {
    for urgent in [true, false] {
        let mut line = connected(Config { turnaround: 2 * MS, ..Config::default() });
        line.handle_bytes(Now::ZERO, &[0x55]);
        match urgent {
            true => ask(&mut line, Now::ZERO, SubsystemId::ALL, Body::Stop),
            false => ask(&mut line, Now::ZERO, SubsystemId::VERTICAL, Body::GetStatus),
        };
        let mut first = None;
        for ms in 1..500 {
            let now = MS * ms;
            line.handle_bytes(now, &[0x55]);
            line.handle_timeout(now);
            if line.poll_transmit(now).is_some() {
                first.get_or_insert(now);
            }
        }
        assert_eq!(first, urgent.then_some(150 * MS));
    }
}

/// A console's line that is never quiet holds back neither the controller's own Stop on the line of
/// the monitors nor, without end, the grants of the consoles.
#[test]
fn a_babbling_line_does_not_hold_back_the_controller() {
    let stop = encode(1, 128, STOP);
    for babbles in [Port::Consoles, Port::Monitors] {
        let turnaround = 2 * MS;
        let config = ControllerConfig { ports: Ports::Two, turnaround, ..Default::default() };
        let mut controller = Controller::new(config);
        let (mut own, mut first, mut others) = (Some(stop.clone()), None, 0);
        controller.set_urgent(true);
        for ms in 0..3_000 {
            let now = MS * ms;
            controller.handle_bytes(now, babbles, &[0x55]);
            controller.handle_timeout(now);
            while let Some(sent) = controller.poll_transmit(now, || own.take()) {
                if sent.bytes == stop {
                    first.get_or_insert(now);
                    controller.set_urgent(false);
                } else {
                    others += 1;
                }
            }
        }
        // On the monitors' own line each wait may be that for the longest frame.
        let (limit, least) = if babbles == Port::Consoles { (MS, 10) } else { (600 * MS, 2) };
        assert!(first.is_some_and(|at| at <= limit), "{babbles:?}: {first:?}");
        assert!(others > least, "{babbles:?}: {others} frames after it");
    }
}

/// A Stop does not wait for an attempt to connect that was made before it, nor for the pause before the next.
#[tokio::test(start_paused = true)]
async fn a_stop_does_not_wait_for_an_earlier_attempt() {
    let (first, far) = pair();
    let mut first = Some(first);
    let mut attempts = 0;
    let dial = move || {
        let (first, attempt) = (first.take(), attempts);
        attempts += 1;
        async move {
            match (first, attempt) {
                (Some(first), _) => Ok(first),
                (None, ..=5) => Err(std::io::ErrorKind::ConnectionRefused.into()),
                // A peer that does not react.
                (None, 6) => std::future::pending().await,
                _ => {
                    let (ours, theirs) = pair();
                    tokio::spawn(serve(theirs, Log::default(), |asked| frame(&answer(asked))));
                    Ok(ours)
                }
            }
        }
    };
    let client = Client::dial("test", dial, Config::default()).await.unwrap();
    drop(far);
    // Until it hangs, by pauses of 2 s at the end.
    sleep(MS * 20_000).await;
    assert!(!client.link_state().borrow().up);
    let start = Instant::now();
    let stop = Request::new(SubsystemId::ALL, Body::Stop);
    assert!(client.request(&stop).await.unwrap().refusal().is_none());
    assert!(start.elapsed() <= MS * 200, "{:?}", start.elapsed());
}
