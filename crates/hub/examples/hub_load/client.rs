//! Clients of the hub.

use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;

use crate::Fallible;

/// Nothing that is waited for takes so long.
const PATIENCE: Duration = Duration::from_secs(30);

/// A WebSocket.
pub struct Socket {
    pub stream: WebSocketStream<TcpStream>,
    next_id: u64,
}

impl Socket {
    pub async fn open(place: &str) -> Fallible<Self> {
        let stream = TcpStream::connect(place).await?;
        stream.set_nodelay(true)?;
        Self::over(place, stream).await
    }

    pub async fn over(place: &str, stream: TcpStream) -> Fallible<Self> {
        let request = format!("ws://{place}/api/ws");
        let (stream, _) =
            timeout(PATIENCE, tokio_tungstenite::client_async(request, stream)).await??;
        Ok(Self { stream, next_id: 0 })
    }

    pub async fn send(&mut self, message: &Value) -> Fallible<()> {
        Ok(self.stream.send(Message::Text(message.to_string().into())).await?)
    }

    /// The next message's text.
    pub async fn next(&mut self) -> Fallible<String> {
        loop {
            match timeout(PATIENCE, self.stream.next()).await?.ok_or("closed")?? {
                Message::Text(text) => return Ok(text.to_string()),
                Message::Close(frame) => return Err(format!("closed: {frame:?}").into()),
                _ => {}
            }
        }
    }

    /// Sends a request; the number under which it is answered.
    pub async fn ask(&mut self, mut message: Value) -> Fallible<u64> {
        self.next_id += 1;
        message["id"] = self.next_id.into();
        self.send(&message).await?;
        Ok(self.next_id)
    }

    /// The answer to a request.
    pub async fn answer(&mut self, id: u64) -> Fallible<Value> {
        loop {
            let text = self.next().await?;
            if text.starts_with("{\"type\":\"answer\"") || text.contains("\"type\":\"answer\"") {
                let answer: Value = serde_json::from_str(&text)?;
                if answer["id"] == json!(id) {
                    return Ok(answer);
                }
            }
        }
    }

    pub async fn request(&mut self, message: Value) -> Fallible<Value> {
        let id = self.ask(message).await?;
        self.answer(id).await
    }

    /// Reads until the hub closes; how many messages there were.
    pub async fn read_on(mut self, count: &std::sync::atomic::AtomicU64) {
        while let Some(Ok(_)) = self.stream.next().await {
            count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        }
    }
}

/// A request over HTTP, on a connection of its own: the body.
pub async fn get(place: &str, path: &str) -> Fallible<String> {
    let mut stream = TcpStream::connect(place).await?;
    let head = format!("GET {path} HTTP/1.0\r\nHost: {place}\r\nConnection: close\r\n\r\n");
    stream.write_all(head.as_bytes()).await?;
    let mut all = Vec::new();
    timeout(PATIENCE, stream.read_to_end(&mut all)).await??;
    let text = String::from_utf8_lossy(&all).into_owned();
    let (head, body) = text.split_once("\r\n\r\n").ok_or("no answer")?;
    if head.contains(" 200 ") { Ok(body.to_owned()) } else { Err(head.to_owned().into()) }
}

/// The same as JSON.
pub async fn get_json(place: &str, path: &str) -> Fallible<Value> {
    Ok(serde_json::from_str(&get(place, path).await?)?)
}
