//! Clients of a flood: each sends one kind of message, as fast as it is taken.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use futures_util::{SinkExt, StreamExt};
use tokio::io::{AsyncReadExt, AsyncWriteExt, split};
use tokio::task::JoinSet;
use tokio_rustls::TlsConnector;
use tokio_tungstenite::tungstenite::protocol::frame::Frame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::{Data, OpCode};
use tokio_tungstenite::tungstenite::{Error, Message};

use crate::Fallible;
use crate::answers::Answers;
use crate::bodies::NUMBER;
use crate::kinds::{Kind, Way};
use crate::link::{self, Stream};
use crate::tally::{DONE, Manner, REFUSED, Tallies};

/// Numbers in requests: the load makes things of the first of them, to be removed.
pub const NUMBERS: std::ops::Range<u64> = 10..18;

/// What is flooded.
#[derive(Clone)]
pub struct Target {
    pub place: String,
    pub token: String,
    pub tls: Option<TlsConnector>,
}

/// A client.
#[derive(Clone)]
struct Client {
    target: Arc<Target>,
    manner: Manner,
    tallies: Tallies,
    next: Arc<AtomicU64>,
}

/// Sends from as many connections until what is returned is dropped.
pub fn start(
    target: &Arc<Target>,
    kind: &Kind,
    count: usize,
    manners: &[Manner],
    tallies: &Tallies,
) -> JoinSet<()> {
    let mut tasks = JoinSet::new();
    let next = Arc::<AtomicU64>::default();
    for index in 0..count {
        let client = Client {
            target: target.clone(),
            manner: manners[index % manners.len()],
            tallies: tallies.clone(),
            next: next.clone(),
        };
        let way = kind.way.clone();
        tasks.spawn(async move {
            loop {
                // How it ends is the hub's business: the client connects again.
                if let Err(error) = client.send(&way).await {
                    client.ended(&*error);
                }
                tokio::task::yield_now().await;
            }
        });
    }
    tasks
}

impl Client {
    /// Notes with which status a WebSocket was refused.
    fn ended(&self, error: &(dyn std::error::Error + Send + Sync + 'static)) {
        if let Some(Error::Http(answer)) = error.downcast_ref::<Error>() {
            self.tallies.answered(self.manner, answer.status().as_u16());
            // The message that it would have sent had no other answer.
            self.tallies.sent(self.manner);
        }
    }

    fn token(&self) -> &str {
        if self.manner.known { &self.target.token } else { "" }
    }

    async fn send(&self, way: &Way) -> Fallible<()> {
        let tls = self.target.tls.as_ref().filter(|_| !matches!(way, Way::Bytes(_)));
        let mut stream = link::connect(&self.target.place, tls).await?;
        match way {
            Way::Http { method, path, headers, body } => {
                self.pump(stream, (method, path, headers, body)).await
            }
            Way::Bytes(bytes) => {
                stream.write_all(bytes).await?;
                self.tallies.sent(self.manner);
                // Held until the hub ends it.
                stream.read_to_end(&mut Vec::new()).await?;
                Ok(())
            }
            Way::Handshake => {
                // It has been made.
                self.tallies.sent(self.manner);
                self.tallies.answered(self.manner, DONE);
                Ok(())
            }
            Way::Messages(first, then) => {
                let first: Vec<_> = first.iter().map(|it| Message::text(it.to_string())).collect();
                self.repeat(stream, &first, &[Message::text(then.to_string())]).await
            }
            Way::Ping => self.repeat(stream, &[], &[Message::Ping(vec![0; 100].into())]).await,
            Way::Fragments(text) => {
                let frame = |text: &[u8], code| {
                    Message::Frame(Frame::message(text.to_vec(), OpCode::Data(code), false))
                };
                let (first, then) = ([frame(b"{", Data::Text)], [frame(text, Data::Continue)]);
                self.repeat(stream, &first, &then).await
            }
        }
    }

    /// The first messages once, the others again and again.
    async fn repeat(&self, stream: Stream, first: &[Message], then: &[Message]) -> Fallible<()> {
        let socket = link::socket(stream, &self.target.place, self.token()).await?;
        let (mut sink, mut answers) = socket.split();
        let sending = async {
            for message in first.iter().chain(then.iter().cycle()) {
                sink.send(message.clone()).await?;
                self.tallies.sent(self.manner);
            }
            Ok(())
        };
        let taking = async {
            if !self.manner.reads {
                std::future::pending::<()>().await;
            }
            while let Some(Ok(message)) = answers.next().await {
                if let Some(status) = status_of(&message) {
                    self.tallies.answered(self.manner, status);
                }
            }
        };
        tokio::select! {
            sent = sending => sent,
            () = taking => Ok(()),
        }
    }

    /// Requests one after the other, without waiting for their answers.
    async fn pump(&self, stream: Stream, request: (&str, &str, &str, &[u8])) -> Fallible<()> {
        let (mut read, mut write) = split(stream);
        let sending = async {
            let numbered = request.1.contains(NUMBER)
                || std::str::from_utf8(request.3).is_ok_and(|body| body.contains(NUMBER));
            let mut bytes = self.request(request);
            loop {
                write.write_all(&bytes).await?;
                self.tallies.sent(self.manner);
                if numbered {
                    bytes = self.request(request);
                }
            }
        };
        let taking = async {
            if !self.manner.reads {
                std::future::pending::<()>().await;
            }
            let (mut buffer, mut answers) = (vec![0; 64 * 1024], Answers::default());
            loop {
                match read.read(&mut buffer).await? {
                    0 => return Ok::<_, std::io::Error>(()),
                    len => answers
                        .take(&buffer[..len], |status| self.tallies.answered(self.manner, status)),
                }
            }
        };
        tokio::select! {
            sent = sending => sent,
            taken = taking => Ok(taken?),
        }
    }

    /// A request, with the next number where one is wanted.
    fn request(&self, (method, path, headers, body): (&str, &str, &str, &[u8])) -> Vec<u8> {
        let span = NUMBERS.end - NUMBERS.start;
        let number = NUMBERS.start + self.next.fetch_add(1, Ordering::Relaxed) % span;
        let number = number.to_string();
        let body = match std::str::from_utf8(body) {
            Ok(text) if text.contains(NUMBER) => text.replace(NUMBER, &number).into_bytes(),
            _ => body.to_vec(),
        };
        let (path, len) = (path.replace(NUMBER, &number), body.len());
        let known = link::authorization(self.token());
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: localhost\r\n{known}{headers}Content-Length: {len}\r\n\r\n"
        );
        [head.into_bytes(), body].concat()
    }
}

/// What a message answers, as a status.
fn status_of(message: &Message) -> Option<u16> {
    match message {
        Message::Pong(_) => Some(DONE),
        Message::Close(frame) => Some(frame.as_ref().map_or(1005, |it| it.code.into())),
        // A monitor that refuses has been asked.
        Message::Text(text) if text.contains("\"type\":\"answer\"") => {
            let refused = text.contains("\"error\":{") && !text.contains("\"answers\"");
            Some(if refused { REFUSED } else { DONE })
        }
        Message::Text(text) if text.contains("\"type\":\"jog\"") => {
            let refused = text.contains("\"end\":\"refused\"");
            Some(if refused { REFUSED } else { DONE })
        }
        _ => None,
    }
}
