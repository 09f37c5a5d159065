//! Callers that serve the line themselves: what becomes of the line when they do not go on.

use std::future::Future;
use std::pin::{Pin, pin};
use std::sync::{Arc, Mutex};
use std::task::{Context, Waker};
use std::time::Duration;

use crate::fake::{answer, frame};
use lafet_client::{Client, Config, Error};
use lafet_proto::link::Decoder;
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};
use tokio::task::yield_now;
use tokio::time::{Instant, sleep, timeout};

const VERTICAL: SubsystemId = SubsystemId::VERTICAL;
const MS: Duration = Duration::from_millis(1);
/// Longest delay by a caller that is not polled.
const LOOK: Duration = Duration::from_millis(20);
/// A Stop waits that long for the answer to a frame that is on the line.
const PATIENCE: Duration = Duration::from_millis(150);
const STATUS: u8 = RequestId::GET_STATUS.0;
const LIMITS: u8 = RequestId::RETRIEVE_LIMITS.0;
const STOP: u8 = RequestId::STOP.0;

/// When the monitor received what.
type Times = Arc<Mutex<Vec<(Instant, u8)>>>;

/// The request of a frame, without its number.
fn request_of(payload: &[u8]) -> Option<u8> {
    let mut records = Records::new(payload).flatten();
    Some(records.find(|record| record.device.name().is_some())?.request.0)
}

/// Answers all requests whose first byte `answers` accepts, at once.
async fn serve(mut stream: DuplexStream, times: Times, answers: impl Fn(u8) -> bool + Send) {
    let mut decoder: Decoder = Decoder::new();
    while let Ok(byte) = stream.read_u8().await {
        let Some(asked) = decoder.push(byte) else { continue };
        let Some(request) = request_of(asked.payload) else { continue };
        times.lock().unwrap().push((Instant::now(), request));
        if answers(request) && stream.write_all(&frame(&answer(asked.payload))).await.is_err() {
            return;
        }
    }
}

fn start(answers: impl Fn(u8) -> bool + Send + 'static) -> (Client, Times) {
    let (ours, theirs) = lafet_client::transport::memory::pair();
    let times = Times::default();
    tokio::spawn(serve(theirs, times.clone(), answers));
    (Client::over("sim:", ours, Config::default()), times)
}

fn status() -> Request<'static> {
    Request::new(VERTICAL, Body::GetStatus)
}

fn limits() -> Request<'static> {
    Request::new(VERTICAL, Body::RetrieveLimits)
}

fn stop() -> Request<'static> {
    Request::new(SubsystemId::ALL, Body::Stop)
}

/// Asks quickly, so that callers may lead.
async fn hurry(client: &Client) {
    for _ in 0..5 {
        client.request(&status()).await.unwrap();
    }
}

/// Polls it so often, at once, without a waker that wakes anything.
fn poll<F: Future>(future: &mut Pin<&mut F>, times: u32) -> bool {
    let mut context = Context::from_waker(Waker::noop());
    (0..times).any(|_| future.as_mut().poll(&mut context).is_ready())
}

/// Lets everything run that needs no time.
async fn settle() {
    for _ in 0..20 {
        yield_now().await;
    }
}

fn received(times: &Times) -> Vec<u8> {
    times.lock().unwrap().iter().map(|(_, request)| *request).collect()
}

async fn takes(client: &Client) -> Duration {
    let began = Instant::now();
    client.request(&limits()).await.unwrap();
    began.elapsed()
}

/// The bound: it sent its frame, was woken for the answer, and is not polled any more.
#[tokio::test(start_paused = true)]
async fn one_that_is_not_polled_delays_others_by_20_ms_once() {
    let (client, times) = start(|_| true);
    hurry(&client).await;
    let asked = status();
    let mut asleep = pin!(client.request(&asked));
    assert!(!poll(&mut asleep, 2));
    settle().await;
    assert_eq!(received(&times), [STATUS; 6], "sent by its caller");
    let took = takes(&client).await;
    assert!(
        took > Duration::ZERO && took <= LOOK,
        "{took:?}: its caller did not lead, or too long"
    );
    // After that the task serves the line for a second, whatever callers do.
    for _ in 0..50 {
        let mut next = pin!(client.request(&asked));
        assert!(!poll(&mut next, 2));
        assert_eq!(takes(&client).await, Duration::ZERO);
        sleep(19 * MS).await;
        assert!(poll(&mut next, 1));
    }
    assert!(poll(&mut asleep, 1), "its answer was kept");
}

/// Polled once: nothing of it was sent by itself. It is sent all the same.
#[tokio::test(start_paused = true)]
async fn one_that_was_polled_once_is_sent() {
    for quick in [true, false] {
        let (client, times) = start(|_| true);
        if quick {
            hurry(&client).await;
        }
        let (asked, before) = (limits(), Instant::now());
        let mut once = pin!(client.request(&asked));
        assert!(!poll(&mut once, 1));
        sleep(LOOK + MS).await;
        let (at, request) = *times.lock().unwrap().last().unwrap();
        assert_eq!(request, LIMITS);
        assert!(at - before <= if quick { LOOK } else { Duration::ZERO });
        sleep(LOOK).await;
        assert!(poll(&mut once, 1));
    }
}

/// §3.2: with the line idle, a Stop is sent within its first poll, not by another's.
#[tokio::test(start_paused = true)]
async fn a_stop_is_sent_by_its_first_poll() {
    for quick in [true, false] {
        let (client, times) = start(|_| true);
        if quick {
            hurry(&client).await;
        }
        let (asked, before) = (stop(), Instant::now());
        let mut stopping = pin!(client.request(&asked));
        assert!(!poll(&mut stopping, 1));
        settle().await;
        assert_eq!(received(&times).last(), Some(&STOP));
        assert_eq!(before.elapsed(), Duration::ZERO);
        assert!(poll(&mut stopping, 1));
    }
}

/// A read that nothing waits for is sent by its first poll; a motion by the next, so that a Stop of
/// the same moment goes first.
#[tokio::test(start_paused = true)]
async fn a_motion_waits_for_a_stop_of_the_same_moment_a_read_does_not() {
    let motion = Request::new(VERTICAL, Body::Move { destination: 1 });
    for (asked, sent) in [(limits(), [LIMITS, STOP].as_slice()), (motion, &[STOP])] {
        let (client, times) = start(|_| true);
        hurry(&client).await;
        times.lock().unwrap().clear();
        let (mut first, halt) = (pin!(client.request(&asked)), stop());
        assert!(!poll(&mut first, 1));
        client.request(&halt).await.unwrap();
        sleep(LOOK).await;
        assert!(poll(&mut first, 1));
        assert_eq!(received(&times), sent, "{asked:?}");
    }
}

/// A Stop goes before 30 requests of callers that are not polled any more, one of which is on the
/// line: after its answer, or after 150 ms.
#[tokio::test(start_paused = true)]
async fn a_stop_overtakes_callers_that_are_not_polled() {
    for answered in [true, false] {
        let (client, times) = start(move |request| answered || request != LIMITS);
        hurry(&client).await;
        let asked = limits();
        let mut asleep: Vec<_> = (0..30).map(|_| Box::pin(client.request(&asked))).collect();
        for _ in 0..2 {
            for one in &mut asleep {
                assert!(!poll(&mut one.as_mut(), 1));
            }
        }
        let began = Instant::now();
        client.request(&stop()).await.unwrap();
        assert_eq!(began.elapsed(), if answered { Duration::ZERO } else { PATIENCE });
        let sent = received(&times);
        let place = sent.iter().position(|request| *request == STOP).unwrap();
        assert_eq!(sent[5..place], [LIMITS], "{sent:x?}");
        drop(asleep);
        sleep(Duration::from_secs(2)).await;
        let began = Instant::now();
        client.request(&status()).await.unwrap();
        assert_eq!(began.elapsed(), Duration::ZERO);
        assert_eq!(received(&times).len(), place + 3, "one went out after the Stop, none later");
    }
}

/// Dropped after each number of polls, with each pause between them: others lose nothing.
#[tokio::test(start_paused = true)]
async fn dropped_at_each_step() {
    for (asked, urgent) in [(status(), false), (stop(), true)] {
        for polls in 0..6 {
            for pause in [Duration::ZERO, MS, 30 * MS] {
                let (client, times) = start(|_| true);
                hurry(&client).await;
                let (mut done, mut sent) = (false, false);
                {
                    let mut dropped = pin!(client.request(&asked));
                    for _ in 0..polls {
                        done = done || poll(&mut dropped, 1);
                        sleep(pause).await;
                        settle().await;
                        sent = received(&times).len() > 5;
                        if done {
                            break;
                        }
                    }
                }
                assert!(sent || !urgent || polls == 0);
                let took = takes(&client).await;
                assert_eq!(took, Duration::ZERO, "{polls} {pause:?}");
                let sent = usize::from(sent);
                assert_eq!(received(&times).len(), 6 + sent, "{polls} {pause:?}");
                sleep(Duration::from_secs(5)).await;
                assert_eq!(received(&times).len(), 6 + sent, "nothing is sent later");
                assert_eq!(client.stats().unmatched, 0);
            }
        }
    }
}

/// Its frame is half written when the caller is dropped: the rest follows, then a Stop.
#[tokio::test(start_paused = true)]
async fn half_a_frame_is_completed() {
    for quick in [true, false] {
        let (ours, mut theirs) = duplex(8);
        let client = Client::over("sim:", ours, Config::default());
        let times = Times::default();
        let log = times.clone();
        // A byte each millisecond.
        tokio::spawn(async move {
            let mut decoder: Decoder = Decoder::new();
            while let Ok(byte) = theirs.read_u8().await {
                sleep(MS / 4).await;
                let Some(asked) = decoder.push(byte) else { continue };
                log.lock().unwrap().push((Instant::now(), request_of(asked.payload).unwrap()));
                if theirs.write_all(&frame(&answer(asked.payload))).await.is_err() {
                    return;
                }
            }
        });
        if quick {
            hurry(&client).await;
        }
        times.lock().unwrap().clear();
        let asked = limits();
        {
            let mut half = pin!(client.request(&asked));
            assert!(!poll(&mut half, 1));
            settle().await;
            assert!(!poll(&mut half, 1));
        }
        client.request(&stop()).await.unwrap();
        assert_eq!(received(&times), [LIMITS, STOP]);
        assert_eq!(client.link_stats().errors(), 0);
    }
}

/// A peer that takes half a frame and no more: the connection is replaced after the timeout, and a
/// Stop goes out over the next one.
#[tokio::test(start_paused = true)]
async fn a_peer_that_stops_reading_is_left() {
    let times = Times::default();
    let (mut dialed, log) = (0, times.clone());
    let mut kept = Vec::new();
    let dial = move || {
        dialed += 1;
        let (ours, theirs) = duplex(if dialed == 1 { 6 } else { 4096 });
        match dialed {
            1 => kept.push(theirs),
            _ => _ = tokio::spawn(serve(theirs, log.clone(), |_| true)),
        }
        async { Ok(ours) }
    };
    let client = Client::dial("sim:", dial, Config::default()).await.unwrap();
    let (asked, began) = (limits(), Instant::now());
    let mut half = pin!(client.request(&asked));
    assert!(!poll(&mut half, 1));
    settle().await;
    client.request(&stop()).await.unwrap();
    assert_eq!(began.elapsed(), Config::default().timeout);
    assert_eq!(client.stats().reconnects, 1);
    settle().await;
    assert!(poll(&mut half, 1));
    assert_eq!(received(&times), [STOP, LIMITS]);
}

/// Where a connection ends.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cut {
    Idle,
    Asked,
    HalfAnswered,
    Answered,
}

/// The connection ends in each phase of an exchange: a read is answered over the next one, a
/// command is not sent twice.
#[tokio::test(start_paused = true)]
async fn a_link_cut_in_each_phase() {
    for cut in [Cut::Idle, Cut::Asked, Cut::HalfAnswered, Cut::Answered] {
        for moves in [false, true] {
            let times = Times::default();
            let (mut dialed, log) = (0, times.clone());
            let dial = move || {
                dialed += 1;
                let (ours, theirs) = lafet_client::transport::memory::pair();
                let cut = (dialed == 1).then_some(cut);
                tokio::spawn(serve_until(theirs, log.clone(), cut));
                async { Ok(ours) }
            };
            let client = Client::dial("sim:", dial, Config::default()).await.unwrap();
            hurry(&client).await;
            settle().await;
            let body = if moves { Body::Move { destination: 1 } } else { Body::RetrieveLimits };
            let result = client.request(&Request::new(VERTICAL, body)).await;
            let lost = matches!(cut, Cut::Asked | Cut::HalfAnswered);
            match result {
                Err(Error::OutcomeUnknown { .. }) => assert!(moves && lost, "{cut:?}"),
                result => assert!(result.is_ok() && !(moves && lost), "{cut:?} {result:?}"),
            }
            let sent = received(&times).len();
            assert_eq!(sent, if lost && !moves { 7 } else { 6 }, "{cut:?} {moves}");
            settle().await;
            takes(&client).await;
            assert_eq!(client.stats().reconnects, 1, "{cut:?}");
        }
    }
}

/// Answers five requests; cuts the connection at the sixth, if it is to.
async fn serve_until(mut stream: DuplexStream, times: Times, cut: Option<Cut>) {
    let mut decoder: Decoder = Decoder::new();
    let mut count = 0;
    while !(cut == Some(Cut::Idle) && count == 5) {
        let Ok(byte) = stream.read_u8().await else { return };
        let Some(asked) = decoder.push(byte) else { continue };
        times.lock().unwrap().push((Instant::now(), request_of(asked.payload).unwrap()));
        count += 1;
        let reply = frame(&answer(asked.payload));
        let len = match cut.filter(|_| count == 6) {
            Some(Cut::Asked) => 0,
            Some(Cut::HalfAnswered) => reply.len() / 2,
            _ => reply.len(),
        };
        if stream.write_all(&reply[..len]).await.is_err() || (count == 6 && cut.is_some()) {
            return;
        }
    }
}

/// A future that is moved to another task wakes that one.
#[tokio::test(start_paused = true)]
async fn a_caller_may_move_to_another_task() {
    let (client, _) = start(|_| true);
    hurry(&client).await;
    for polls in 0..3 {
        let other = client.clone();
        let mut moved = Box::pin(async move { other.request(&status()).await });
        assert!(!poll(&mut moved.as_mut(), polls));
        let answered = timeout(LOOK, tokio::spawn(moved)).await.expect("in time").unwrap();
        assert_eq!(answered.unwrap().first().from(), VERTICAL);
        hurry(&client).await;
    }
}
