//! Clients of a flood: each sends one kind of message, as fast as it is taken.

use std::sync::Arc;

use futures_util::{SinkExt, StreamExt};
use tokio::io::{AsyncReadExt, AsyncWriteExt, split};
use tokio::task::JoinSet;
use tokio_rustls::TlsConnector;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::protocol::frame::Frame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::{Data, OpCode};

use crate::Fallible;
use crate::kinds::{Kind, Way};
use crate::link::{self, Stream};

/// Whether a client takes what is answered, and whether the hub knows it.
#[derive(Clone, Copy)]
pub struct Manner {
    pub reads: bool,
    pub known: bool,
}

pub const MANNERS: [Manner; 4] = [
    Manner { reads: true, known: true },
    Manner { reads: false, known: true },
    Manner { reads: true, known: false },
    Manner { reads: false, known: false },
];

/// What is flooded.
pub struct Target {
    pub place: String,
    pub token: String,
    pub tls: Option<TlsConnector>,
}

/// Sends from as many connections until what is returned is dropped.
pub fn start(target: &Arc<Target>, kind: &Kind, count: usize, manners: &[Manner]) -> JoinSet<()> {
    let mut tasks = JoinSet::new();
    for index in 0..count {
        let (target, way) = (target.clone(), kind.way.clone());
        let manner = manners[index % manners.len()];
        tasks.spawn(async move {
            loop {
                // How it ends is the hub's business: the client connects again.
                _ = send(&target, &way, manner).await;
                tokio::task::yield_now().await;
            }
        });
    }
    tasks
}

async fn send(target: &Target, way: &Way, manner: Manner) -> Fallible<()> {
    let tls = target.tls.as_ref().filter(|_| !matches!(way, Way::Bytes(_)));
    let mut stream = link::connect(&target.place, tls).await?;
    let token = if manner.known { target.token.as_str() } else { "" };
    match way {
        Way::Http { method, path, headers, body } => {
            let len = body.len();
            let head = format!(
                "{method} {path} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {token}\r\n\
                 {headers}Content-Length: {len}\r\n\r\n"
            );
            pump(stream, &[head.as_bytes(), body].concat(), manner.reads).await
        }
        Way::Bytes(bytes) => {
            stream.write_all(bytes).await?;
            // Held until the hub ends it.
            stream.read_to_end(&mut Vec::new()).await?;
            Ok(())
        }
        // The handshake has been made.
        Way::Handshake => Ok(()),
        Way::Message(message) => {
            let messages = [Message::text(message.to_string())];
            repeat(target, stream, token, (&[], &messages), manner).await
        }
        Way::Ping => {
            let messages = [Message::Ping(vec![0; 100].into())];
            repeat(target, stream, token, (&[], &messages), manner).await
        }
        Way::Fragments(text) => {
            let frame = |text: &[u8], code| {
                Message::Frame(Frame::message(text.to_vec(), OpCode::Data(code), false))
            };
            let (first, then) = ([frame(b"{", Data::Text)], [frame(text, Data::Continue)]);
            repeat(target, stream, token, (&first, &then), manner).await
        }
    }
}

/// The first messages once, the others again and again.
async fn repeat(
    target: &Target,
    stream: Stream,
    token: &str,
    (first, then): (&[Message], &[Message]),
    manner: Manner,
) -> Fallible<()> {
    let (mut sink, mut answers) = link::socket(stream, &target.place, token).await?.split();
    let sending = async {
        for message in first.iter().chain(then.iter().cycle()) {
            sink.send(message.clone()).await?;
        }
        Ok(())
    };
    let taking = async {
        if !manner.reads {
            std::future::pending::<()>().await;
        }
        while let Some(Ok(_)) = answers.next().await {}
    };
    tokio::select! {
        sent = sending => sent,
        () = taking => Ok(()),
    }
}

/// Requests one after the other, without waiting for their answers.
async fn pump(stream: Stream, request: &[u8], reads: bool) -> Fallible<()> {
    let (mut read, mut write) = split(stream);
    let sending = async {
        loop {
            write.write_all(request).await?;
        }
    };
    let taking = async {
        if !reads {
            std::future::pending::<()>().await;
        }
        let mut buffer = vec![0; 64 * 1024];
        while read.read(&mut buffer).await? > 0 {}
        Ok::<_, std::io::Error>(())
    };
    tokio::select! {
        sent = sending => sent,
        taken = taking => Ok(taken?),
    }
}
