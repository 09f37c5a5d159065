//! What the hub sends over a WebSocket: answers, events, and what changes.

use std::future::ready;
use std::sync::atomic::Ordering;
use std::time::Duration;

use axum::extract::ws::{Message, Utf8Bytes, WebSocket};
use futures_util::SinkExt;
use futures_util::stream::SplitSink;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, interval, timeout};

use super::{Close, GOING_AWAY, Pings, standing};
use crate::access::Standing;
use crate::control::beats::{BEAT_MS, WATCHDOG};
use crate::hub::{Caller, Hub, SeatKey};
use crate::publish::broadcast::{Own, Shared};
use crate::publish::messages::{self, Hello, JogTimes};
use crate::publish::topics::Audience;

/// How often the other side is pinged.
pub const PING: Duration = Duration::from_secs(5);
/// A silent connection is closed after this time.
pub const SILENT: Duration = Duration::from_secs(15);
/// A connection that takes nothing is closed after this time.
pub const SLOW: Duration = Duration::from_secs(10);

/// It does not take what is sent to it.
pub const TOO_SLOW: (u16, &str) = (4409, "too slow");
pub const ENDED: (u16, &str) = (4401, "session ended");

pub struct Writer {
    pub hub: Hub,
    pub caller: Caller,
    pub sink: SplitSink<WebSocket, Message>,
    pub own: Own,
    pub audience: Audience,
    /// What the client begins to look at.
    pub turning: watch::Receiver<Audience>,
}

impl Writer {
    pub async fn run(
        &mut self,
        key: &mut SeatKey,
        mut answers: mpsc::Receiver<Utf8Bytes>,
        pings: &Pings,
    ) -> Close {
        let mut changes = self.hub.audiences().join(&self.audience);
        match self.begin(key).await {
            Ok(()) => {}
            Err(close) => return close,
        }
        let mut shutdown = self.hub.shutdown();
        let mut sessions = self.hub.access_changes();
        let mut ping = interval(PING);
        let mut silent_since = Instant::now();
        loop {
            let sent = tokio::select! {
                Some(answer) = answers.recv() => self.put(Message::Text(answer)).await,
                Some(event) = key.events.recv() => self.event(key, event).await,
                event = key.common.recv() => match event {
                    Ok(event) => self.put(Message::Text(event)).await,
                    Err(RecvError::Lagged(count)) => self.missed(count).await,
                    Err(RecvError::Closed) => return Some(GOING_AWAY),
                },
                () = shutdown.requested() => return Some(GOING_AWAY),
                _ = ping.tick() => {
                    if pings.heard.swap(false, Ordering::Relaxed) {
                        silent_since = Instant::now();
                    } else if silent_since.elapsed() >= SILENT {
                        return Some((4408, "silent"));
                    }
                    if !self.goes_on(key) {
                        return Some(ENDED);
                    }
                    pings.unanswered.store(true, Ordering::Relaxed);
                    self.put(Message::Ping(Vec::new().into())).await
                }
                Ok(()) = sessions.changed() => match self.goes_on(key) {
                    true => Ok(()),
                    false => return Some(ENDED),
                },
                Ok(()) = self.turning.changed(), if self.own.is_whole() => {
                    self.audience = self.turning.borrow_and_update().clone();
                    changes = self.hub.audiences().join(&self.audience);
                    self.own.turn(&self.hub, &self.audience);
                    self.piece().await
                }
                () = ready(()), if self.own.behind => self.piece().await,
                Ok(()) = changes.changed() => {
                    let shared = changes.borrow_and_update().clone();
                    self.publish(&shared).await
                }
            };
            if let Err(close) = sent {
                return close;
            }
        }
    }

    /// Whether the connection stays open. One that outlasts the certificate of its client loses what it holds, as if it
    /// were closed: it commands nothing, and others wait for the monitor.
    fn goes_on(&self, key: &SeatKey) -> bool {
        let standing = standing(&self.hub, &self.caller.principal);
        if standing == Some(Standing::Expired) && key.has.still() {
            self.hub.seat_is_silent_everywhere(&key.seat);
        }
        standing.is_some()
    }

    async fn begin(&mut self, key: &SeatKey) -> Result<(), Close> {
        let principal = &self.caller.principal;
        let watchdog_ms = u64::try_from(WATCHDOG.as_millis()).unwrap_or(300);
        let hello = Hello {
            now_ms: self.hub.clock().now_ms(),
            up_ms: self.hub.up_ms(),
            seat: key.seat.clone(),
            resume: key.resume.clone(),
            user: principal.user.clone(),
            role: principal.role,
            kind: principal.kind,
            hub: self.hub.about(),
            jog: JogTimes { beat_ms: BEAT_MS, watchdog_ms },
        };
        self.send(&messages::Message::Hello(hello.into())).await?;
        let text = self.own.state(&self.hub);
        self.put(Message::Text(text)).await
    }

    async fn event(&mut self, key: &SeatKey, event: Utf8Bytes) -> Result<(), Close> {
        let missed = key.missed.swap(0, Ordering::Relaxed);
        if missed > 0 {
            self.send(&messages::Message::Missed { count: missed }).await?;
        }
        self.put(Message::Text(event)).await
    }

    /// Messages to all came faster than the client takes them.
    async fn missed(&mut self, count: u64) -> Result<(), Close> {
        self.hub.count_missed(count);
        self.send(&messages::Message::Missed { count }).await
    }

    /// Who has kept up is sent what all are sent; who has not, what is new to them alone.
    async fn publish(&mut self, shared: &Shared) -> Result<(), Close> {
        let seen = &mut self.own.seen;
        if seen.version > shared.to.version {
            return Ok(());
        }
        let kept_up = seen.version == shared.from.version && seen.has_news_of(&shared.from);
        match &shared.text {
            Some(text) if kept_up => {
                *seen = seen.with(&shared.to);
                match text.is_empty() {
                    true => Ok(()),
                    false => self.put(Message::Text(text.clone())).await,
                }
            }
            _ if seen.version == shared.to.version => Ok(()),
            _ => self.piece().await,
        }
    }

    /// Sends what is new to this client alone.
    async fn piece(&mut self) -> Result<(), Close> {
        let text = self.own.piece(&self.hub, &self.audience);
        self.put(Message::Text(text)).await
    }

    async fn send(&mut self, message: &messages::Message) -> Result<(), Close> {
        self.put(Message::Text(message.written())).await
    }

    async fn put(&mut self, message: Message) -> Result<(), Close> {
        let counts = self.hub.counts();
        counts.messages.fetch_add(1, Ordering::Relaxed);
        let bytes = match &message {
            Message::Text(text) => text.len(),
            _ => 0,
        };
        let bytes = u64::try_from(bytes).unwrap_or(0);
        counts.message_bytes.fetch_add(bytes, Ordering::Relaxed);
        match timeout(SLOW, self.sink.send(message)).await {
            Ok(Ok(())) => Ok(()),
            // It takes nothing, or is gone. What it has sent before is read all the same.
            Ok(Err(_)) | Err(_) => Err(Some(TOO_SLOW)),
        }
    }
}
