//! Callers that serve the line themselves, on several threads and on one that is busy.

use std::future::Future;
use std::pin::pin;
use std::sync::{Arc, mpsc};
use std::task::{Context, Poll, Wake};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use crate::fake::{Log, answer, encode, frame, serve};
use lafet_client::{Client, Endpoint, Error};
use lafet_proto::link::Decoder;
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;

const VERTICAL: SubsystemId = SubsystemId::VERTICAL;
const MONITORS: u8 = 8;

fn status() -> Request<'static> {
    Request::new(VERTICAL, Body::GetStatus)
}

fn stop() -> Request<'static> {
    Request::new(SubsystemId::ALL, Body::Stop)
}

async fn listen() -> (TcpListener, Endpoint) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    (listener, format!("tcp://127.0.0.1:{port}?addr=1&late=0").parse().unwrap())
}

/// A client, and a monitor that answers at once.
async fn start() -> (Client, Log) {
    let (listener, endpoint) = listen().await;
    let log = Log::default();
    let received = log.clone();
    tokio::spawn(async move {
        let (stream, _) = listener.accept().await.unwrap();
        serve(stream, received, |payload| frame(&answer(payload))).await;
    });
    (Client::connect(&endpoint).await.unwrap(), log)
}

async fn hurry(client: &Client) {
    for _ in 0..5 {
        client.request(&status()).await.unwrap();
    }
}

/// Holds the thread.
fn busy(time: Duration) {
    let began = Instant::now();
    while began.elapsed() < time {
        std::hint::spin_loop();
    }
}

/// Several monitors; each answer takes a while.
async fn serve_several(mut stream: TcpStream, log: Log) {
    let mut decoder: Decoder = Decoder::new();
    let mut buffer = [0; 2048];
    while let Ok(len @ 1..) = stream.read(&mut buffer).await {
        for byte in &buffer[..len] {
            let Some(asked) = decoder.push(*byte) else { continue };
            log.lock().unwrap().push(asked.payload.to_vec());
            tokio::time::sleep(Duration::from_millis(1)).await;
            let reply = encode(129, asked.dst, &answer(asked.payload));
            stream.write_all(&reply).await.unwrap();
        }
    }
}

/// §3.2: a thousand callers on several threads, each polled in its own task: all are answered, and a
/// Stop goes before all that have not been sent.
#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn a_stop_overtakes_a_thousand_callers() {
    let (listener, endpoint) = listen().await;
    let log = Log::default();
    let received = log.clone();
    tokio::spawn(async move {
        let (stream, _) = listener.accept().await.unwrap();
        serve_several(stream, received).await;
    });
    let client = Client::connect(&endpoint).await.unwrap();
    let mut callers = JoinSet::new();
    for n in 0..1000_u16 {
        let client = client.at(n as u8 % MONITORS + 1).unwrap();
        callers.spawn(async move { client.request(&status()).await.map(|_| ()) });
    }
    let mut answered = 0;
    while answered < 300 {
        callers.join_next().await.unwrap().unwrap().unwrap();
        answered += 1;
    }
    let before = log.lock().unwrap().len();
    client.request(&stop()).await.unwrap();
    let after = log.lock().unwrap().len();
    while let Some(result) = callers.join_next().await {
        result.unwrap().unwrap();
        answered += 1;
    }
    assert_eq!(answered, 1000);
    let log = log.lock().unwrap();
    let place = log.iter().position(|payload| payload[0] == RequestId::STOP.0).unwrap();
    assert!(place <= before + 3 && place < after, "sent as {place}, asked for at {before}");
    assert_eq!(log.len(), 1001);
    assert_eq!(client.link_stats().retries, 0);
}

/// The only thread of the runtime does something else for 100 ms: nothing is lost, and nothing is
/// taken for silence.
#[tokio::test]
async fn a_busy_thread() {
    for polls in 0..3 {
        let (client, log) = start().await;
        hurry(&client).await;
        let asked = status();
        let mut waiting = pin!(client.request(&asked));
        let mut result = None;
        for _ in 0..polls {
            std::future::poll_fn(|cx| {
                if result.is_none()
                    && let Poll::Ready(end) = waiting.as_mut().poll(cx)
                {
                    result = Some(end);
                }
                Poll::Ready(())
            })
            .await;
        }
        busy(Duration::from_millis(100));
        let began = Instant::now();
        client.request(&stop()).await.unwrap();
        let answer = match result {
            Some(result) => result,
            None => waiting.await,
        };
        assert_eq!(answer.unwrap().first().from(), VERTICAL);
        assert!(began.elapsed() < Duration::from_millis(100), "{:?}", began.elapsed());
        assert_eq!(log.lock().unwrap().len(), 7);
        assert_eq!((client.stats().timeouts, client.stats().retries), (0, 0));
    }
}

/// The thread of the caller that leads is busy: others go on. It is the one that looked at the link, now and then.
#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn a_leader_whose_thread_is_busy() {
    for _ in 0..8 {
        others_go_on_beside(Duration::from_millis(400)).await;
    }
}

async fn others_go_on_beside(time: Duration) {
    let (client, log) = start().await;
    hurry(&client).await;
    let (other, (leads, is_busy)) = (client.clone(), tokio::sync::oneshot::channel());
    let leader = tokio::spawn(async move {
        let asked = status();
        let mut waiting = pin!(other.request(&asked));
        let (mut polls, mut leads) = (0, Some(leads));
        std::future::poll_fn(|cx| {
            let end = waiting.as_mut().poll(cx);
            polls += 1;
            if polls == 2
                && let Some(leads) = leads.take()
            {
                leads.send(()).unwrap();
                busy(time);
            }
            end
        })
        .await
    });
    is_busy.await.unwrap();
    let began = Instant::now();
    client.request(&stop()).await.unwrap();
    client.request(&status()).await.unwrap();
    assert!(began.elapsed() < time / 2, "{:?}", began.elapsed());
    assert_eq!(log.lock().unwrap().len(), 8);
    leader.await.unwrap().unwrap();
}

/// Any executor may poll a caller: here one that only parks its thread.
#[test]
fn a_caller_outside_the_runtime() {
    struct Unpark(Thread);
    impl Wake for Unpark {
        fn wake(self: Arc<Self>) {
            self.0.unpark();
        }
    }
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let (client, log) = runtime.block_on(start());
    let waker = Arc::new(Unpark(thread::current())).into();
    let asked = status();
    for _ in 0..2000 {
        let mut waiting = pin!(client.request(&asked));
        let result = loop {
            match waiting.as_mut().poll(&mut Context::from_waker(&waker)) {
                Poll::Ready(result) => break result,
                Poll::Pending => thread::park(),
            }
        };
        assert_eq!(result.unwrap().first().from(), VERTICAL);
    }
    assert_eq!(log.lock().unwrap().len(), 2000);
}

/// The runtime of the client ends while callers wait elsewhere: that is an error, not for ever.
#[test]
fn a_runtime_that_ends() {
    for quick in [false, true] {
        let theirs = tokio::runtime::Runtime::new().unwrap();
        let (listener, endpoint) = theirs.block_on(listen());
        theirs.spawn(async move {
            let (stream, _) = listener.accept().await.unwrap();
            let mut count = 0;
            let some = |payload: &[u8]| {
                count += 1;
                if quick && count <= 5 { frame(&answer(payload)) } else { vec![] }
            };
            serve(stream, Log::default(), some).await;
        });
        let ours = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
        let client = ours.block_on(Client::connect(&endpoint)).unwrap();
        theirs.block_on(async {
            if quick {
                hurry(&client).await;
            }
        });
        let (done, results) = mpsc::channel();
        for _ in 0..3 {
            let (client, done) = (client.clone(), done.clone());
            theirs.spawn(async move {
                let read = client.request(&Request::new(VERTICAL, Body::RetrieveLimits)).await;
                done.send((read, client.request(&stop()).await)).unwrap();
            });
        }
        drop(ours);
        for _ in 0..3 {
            let (read, stop) = results.recv_timeout(Duration::from_secs(10)).unwrap();
            assert!(matches!(read, Err(Error::Closed)), "{read:?}");
            assert!(matches!(stop, Err(Error::Closed)), "{stop:?}");
        }
    }
}
