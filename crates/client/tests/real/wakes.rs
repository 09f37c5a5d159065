//! Callers that are woken for their answers, whatever the order in which things happen.
//!
//! Both ends are in one thread, which makes their steps in a chosen order. Time is virtual: it
//! passes only when nothing is left to do, so that a wake that is lost shows as the 20 ms after
//! which the task looks at the line by itself.

use std::future::{Future, poll_fn};
use std::io::{ErrorKind, Read, Write};
use std::pin::Pin;
use std::task::Poll;

use crate::fake::{answer, frame};
use lafet_client::{Answers, Client, Endpoint, Error};
use lafet_proto::link::Decoder;
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::task::yield_now;
use tokio::time::Instant;

type Waiting<'a> = Pin<Box<dyn Future<Output = Result<Answers, Error>> + 'a>>;

/// A monitor that reads and answers step by step.
struct Peer {
    stream: std::net::TcpStream,
    decoder: Decoder,
    asked: Vec<RequestId>,
    /// Bytes of answers that were not sent.
    due: Vec<u8>,
}

impl Peer {
    /// A peer, and a client that may serve the line itself. From here on time is virtual.
    async fn connected() -> (Self, Client) {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let endpoint: Endpoint = format!("tcp://127.0.0.1:{port}?late=0").parse().unwrap();
        let client = Client::connect(&endpoint).await.unwrap();
        let (stream, _) = listener.accept().unwrap();
        stream.set_nonblocking(true).unwrap();
        stream.set_nodelay(true).unwrap();
        tokio::time::pause();
        let mut peer = Self { stream, decoder: Decoder::new(), asked: Vec::new(), due: Vec::new() };
        for _ in 0..3 {
            let mut waiting: Waiting<'_> = Box::pin(client.request(&STATUS));
            while step(&mut waiting).await.is_none() {
                yield_now().await;
                peer.listen();
                peer.say(usize::MAX);
            }
        }
        (peer, client)
    }

    fn listen(&mut self) {
        let mut buffer = [0; 512];
        loop {
            match self.stream.read(&mut buffer) {
                Ok(len) => self.heard(&buffer[..len]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(error) => panic!("{error}"),
            }
        }
    }

    fn heard(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if let Some(asked) = self.decoder.push(*byte) {
                self.asked.push(RequestId(asked.payload[0]));
                self.due.extend(frame(&answer(asked.payload)));
            }
        }
    }

    /// Sends so many bytes of what it has to say.
    fn say(&mut self, bytes: usize) {
        let bytes = bytes.min(self.due.len());
        self.stream.write_all(&self.due[..bytes]).unwrap();
        self.due.drain(..bytes);
    }

    /// Answers everything from now on, by itself.
    fn go_on(mut self) -> tokio::task::JoinHandle<Vec<RequestId>> {
        tokio::spawn(async move {
            let mut stream =
                tokio::net::TcpStream::from_std(self.stream.try_clone().unwrap()).unwrap();
            let mut buffer = [0; 512];
            loop {
                let due = std::mem::take(&mut self.due);
                if stream.write_all(&due).await.is_err() {
                    return self.asked;
                }
                match stream.read(&mut buffer).await {
                    Ok(len @ 1..) => self.heard(&buffer[..len]),
                    _ => return self.asked,
                }
            }
        })
    }
}

const STATUS: Request<'_> = Request::new(SubsystemId::VERTICAL, Body::GetStatus);
const STOP: Request<'_> = Request::new(SubsystemId::ALL, Body::Stop);
const MOVE: Request<'_> = Request::new(SubsystemId::VERTICAL, Body::Move { destination: 7 });

/// Polls once.
async fn step(waiting: &mut Waiting<'_>) -> Option<Result<Answers, Error>> {
    poll_fn(|cx| match waiting.as_mut().poll(cx) {
        Poll::Ready(end) => Poll::Ready(Some(end)),
        Poll::Pending => Poll::Ready(None),
    })
    .await
}

/// Pseudo-random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % end
    }
}

/// Up to three callers and the peer, step by step; then all that is left has to end by wakes alone.
/// Returns how many callers were left; an error says what went wrong.
async fn run(seed: u64) -> Result<usize, String> {
    let (mut peer, client) = Peer::connected().await;
    let mut random = Random(seed);
    let mut waiting: Vec<Waiting<'_>> = Vec::new();
    for _ in 0..6 + random.below(20) {
        let which = random.below(waiting.len().max(1) as u64) as usize;
        match random.below(11) {
            0..3 if waiting.len() < 3 => {
                let request = [&STATUS, &STATUS, &STATUS, &MOVE, &STOP][random.below(5) as usize];
                waiting.push(Box::pin(client.request(request)));
            }
            3..6 if which < waiting.len() => {
                if let Some(end) = step(&mut waiting[which]).await {
                    drop(waiting.swap_remove(which));
                    expected(end)?;
                }
            }
            6 if which < waiting.len() && random.below(3) == 0 => {
                drop(waiting.swap_remove(which));
            }
            7 => yield_now().await,
            8 => peer.listen(),
            9 => peer.say(usize::MAX),
            10 => peer.say(random.below(30) as usize),
            _ => {}
        }
    }
    let (start, left) = (Instant::now(), waiting.len());
    let server = peer.go_on();
    // All of them: a caller that is woken and not polled may keep the line for 20 ms.
    let mut ends = Vec::new();
    poll_fn(|cx| {
        waiting.retain_mut(|caller| match caller.as_mut().poll(cx) {
            Poll::Ready(end) => {
                ends.push(end);
                false
            }
            Poll::Pending => true,
        });
        if waiting.is_empty() { Poll::Ready(()) } else { Poll::Pending }
    })
    .await;
    drop(waiting);
    ends.into_iter().try_for_each(expected)?;
    expected(client.request(&STATUS).await)?;
    let took = start.elapsed();
    drop(client);
    server.await.map_err(|error| error.to_string())?;
    if took.is_zero() { Ok(left) } else { Err(format!("it took {took:?}")) }
}

/// A move may be revoked by a stop.
fn expected(end: Result<Answers, Error>) -> Result<(), String> {
    match end {
        Ok(_) | Err(Error::NotSent { .. }) => Ok(()),
        Err(error) => Err(error.to_string()),
    }
}

/// Whatever the order of steps, each caller is woken for its answer.
#[test]
fn no_wake_is_lost() {
    const RUNS: u64 = 2000;
    let once = |seed| {
        let mut runtime = tokio::runtime::Builder::new_current_thread();
        runtime.enable_all().build().unwrap().block_on(run(seed))
    };
    let mut left = 0;
    for seed in 0..RUNS {
        // The kernel may take a moment to pass a byte on; a wake that is lost is lost each time.
        let mut end = once(seed);
        for _ in 0..4 {
            if end.is_err() {
                end = once(seed);
            }
        }
        left += end.unwrap_or_else(|error| panic!("seed {seed}: {error}"));
    }
    assert!(left > RUNS as usize / 2, "{left} callers were left to wait");
}
