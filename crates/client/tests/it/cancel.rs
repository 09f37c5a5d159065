//! A future dropped at any of its await points leaves nothing behind.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Waker};
use std::time::Duration;

use crate::fake::{self, Log, answer, frame};
use lafet_client::{Client, Config, Monitor, Toward};
use lafet_proto::link::Decoder;
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, Status, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::{Instant, sleep, sleep_until};

const VERTICAL: SubsystemId = SubsystemId::VERTICAL;

/// Answers after 20 ms; the first answers of some kinds are lost, others come late.
async fn serve(mut stream: DuplexStream, log: Log) {
    let mut decoder: Decoder = Decoder::new();
    let mut count = 0;
    while let Ok(byte) = stream.read_u8().await {
        let Some(asked) = decoder.push(byte) else { continue };
        log.lock().unwrap().push(asked.payload.to_vec());
        count += 1;
        if count % 4 == 0 {
            continue;
        }
        let mut reply = answer(asked.payload);
        // §2: fetched from a remote unit at first.
        if asked.payload.starts_with(&[RequestId::GET_PARAM.0]) && count % 3 == 0 {
            reply = [&reply[..2], &[Status::NOT_CACHED.0, 2], &asked.payload[4..6]].concat();
        }
        sleep(Duration::from_millis(20)).await;
        if stream.write_all(&frame(&reply)).await.is_err() {
            return;
        }
    }
}

fn start() -> (Client, Log) {
    let (ours, theirs) = lafet_client::transport::memory::pair();
    let log = Log::default();
    tokio::spawn(serve(theirs, log.clone()));
    (Client::over("sim:", ours, Config::default()), log)
}

/// Polls a future `steps` times, a few milliseconds apart, and drops it. Whether it was done.
async fn for_a_while<T>(future: impl Future<Output = T>, steps: u32) -> bool {
    let mut future = pin!(future);
    for _ in 0..steps {
        let mut context = Context::from_waker(Waker::noop());
        if future.as_mut().poll(&mut context).is_ready() {
            return true;
        }
        sleep_until(Instant::now() + Duration::from_millis(7)).await;
    }
    false
}

/// Drops the future after each number of polls until it is done before that; after each, the
/// client works as if nothing had been.
async fn everywhere<F: Future>(name: &str, mut make: impl FnMut(Monitor) -> F) {
    for steps in 0..2000 {
        let (client, log) = start();
        let done = for_a_while(make(Monitor::new(client.clone())), steps).await;
        let before = log.lock().unwrap().len();
        // The right answer to the next requests, whatever of the former is still under way.
        for request in [
            Request::new(VERTICAL, Body::GetStatus),
            Request::new(VERTICAL, Body::RetrieveLimits),
            Request::new(SubsystemId::GENERAL, Body::GetStatus),
        ] {
            let answers = client.request(&request).await.unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!(answers.first().request(), request.body.id(), "{name} {steps}");
            assert_eq!(answers.first().from(), request.to, "{name} {steps}");
        }
        // What was dropped is not sent, but for urgent requests and what ends a motion.
        let log = log.lock().unwrap();
        let later = log[before..].iter().filter(|payload| moves(payload)).count();
        assert_eq!(later, 0, "{name} {steps}: an unwanted motion: {log:x?}");
        if done {
            assert!(steps > 1, "{name} has no await point");
            return;
        }
    }
    panic!("{name} is never done");
}

fn moves(payload: &[u8]) -> bool {
    payload.starts_with(&[RequestId::MOVE.0])
        || payload[8.min(payload.len())..].starts_with(&[RequestId::MOVE.0])
}

fn read() -> Request<'static> {
    Request::new(VERTICAL, Body::GetStatus)
}

#[tokio::test(start_paused = true)]
async fn requests() {
    everywhere("request", |m| async move { m.client().request(&read()).await.is_ok() }).await;
    everywhere("status_all", |m| async move { m.status_all().await.is_ok() }).await;
    everywhere("move", |m| async move { m.move_to(VERTICAL, 1).await.is_ok() }).await;
    everywhere("stop", |m| async move { m.stop(SubsystemId::ALL).await.is_ok() }).await;
    everywhere("probe", |m| async move { m.client().probe().await.is_ok() }).await;
    everywhere("param", |m| async move { m.param(VERTICAL, "Speed").await.is_ok() }).await;
}

#[tokio::test(start_paused = true)]
async fn batches() {
    let body = Body::GetParam { id: lafet_proto::ParamId::of("Speed") };
    let many = [Request::new(VERTICAL, body); 60];
    everywhere("batch", |m| async move { m.client().batch(&many).await.len() }).await;
    everywhere("complete", |m| async move { m.client().complete(&many, |_| {}).await.len() }).await;
    let mixed = [read(), Request::new(VERTICAL, Body::Move { destination: 1 }), read()];
    everywhere("mixed", |m| async move { m.client().complete(&mixed, |_| {}).await.len() }).await;
}

#[tokio::test(start_paused = true)]
async fn several_at_once() {
    everywhere("join", |m| async move {
        tokio::join!(m.status(VERTICAL), m.move_to(VERTICAL, 1), m.limits(VERTICAL), m.hotbeds())
    })
    .await;
    everywhere("subscription", |m| async move {
        let mut watch = m.watch(Duration::from_millis(50)).unwrap();
        for _ in 0..5 {
            watch.next().await;
        }
    })
    .await;
}

/// §3.2: a Stop that was polled once is sent, whatever becomes of its future.
#[tokio::test(start_paused = true)]
async fn a_stop_is_sent_from_its_first_poll_on() {
    for steps in 1..30 {
        let (client, log) = start();
        let monitor = Monitor::new(client);
        for_a_while(monitor.stop(SubsystemId::ALL), steps).await;
        drop(monitor);
        sleep(Duration::from_secs(5)).await;
        let log = log.lock().unwrap();
        assert!(log.iter().any(|payload| payload == &[0x46, 0x5D, 0, 0]), "{steps}: {log:x?}");
    }
}

/// A motion whose handle, or whose release, is dropped at any moment ends with a Stop.
#[tokio::test(start_paused = true)]
async fn a_motion_that_is_dropped_is_stopped() {
    for steps in 0..60 {
        let plant = fake::plant::plant();
        let (ours, theirs) = lafet_client::transport::memory::pair();
        tokio::spawn(fake::plant::serve(theirs, plant.clone()));
        let monitor = Monitor::new(Client::over("sim:", ours, Config::default()));
        let using = async {
            let jog = monitor.vertical().jog(Toward::UP).unwrap();
            for _ in 0..3 {
                sleep(Duration::from_millis(50)).await;
                jog.renew();
            }
            jog.release().await
        };
        for_a_while(using, steps).await;
        drop(monitor);
        sleep(Duration::from_secs(1)).await;
        assert!(!plant.lock().unwrap().is_moving(VERTICAL), "{steps}");
    }
}
