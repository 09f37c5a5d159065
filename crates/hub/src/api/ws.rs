//! The WebSocket: what changes, as it changes, and what has to be quick.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, WebSocketUpgrade};
use axum::extract::{Extension, Query, State};
use axum::response::Response;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use lafet_client::{Direction, Traced};
use lafet_proto::Request;
use lafet_proto::link::Frame;
use lafet_proto::record::Records;
use lafet_proto::text::AnswerText;
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::sync::{Semaphore, mpsc};
use tokio::task::AbortHandle;
use tokio::time::{Instant, interval, timeout};
use utoipa::IntoParams;

use super::guard::Peer;
use super::monitors::{JogBeat, LOCKOUT, STOP};
use crate::access::{Bucket, Principal};
use crate::beats::{BEAT_MS, WATCHDOG};
use crate::broadcast::{self, Shared};
use crate::error::ApiError;
use crate::hub::{Caller, Hub, SeatKey};
use crate::station::Station;

/// Longest message of a client.
const MESSAGE_MAX: usize = 16 * 1024;
/// What a connection reads into; each has one, and clients say little.
const READ_BUFFER: usize = 4 * 1024;
/// How often the other side is pinged.
const PING: Duration = Duration::from_secs(5);
/// A connection that is silent for so long is closed.
const SILENT: Duration = Duration::from_secs(15);
/// So is one that takes nothing for so long.
const SLOW: Duration = Duration::from_secs(10);
/// Messages of a connection: so many at once, so many a second.
const MESSAGES: (f64, f64) = (400.0, 200.0);
/// Requests of a connection that wait for their answers; Stop, Close, Lockout are not counted.
const REQUESTS_MAX: usize = 32;
/// Answers that wait to be sent.
const ANSWERS_MAX: usize = 64;

/// How to come back.
#[derive(Debug, Deserialize, IntoParams)]
pub struct Resume {
    /// The secret of `hello`.
    resume: Option<String>,
}

/// What clients say.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Said {
    Request {
        id: Option<Value>,
        monitor: String,
        request: String,
        confirm: Option<String>,
        /// A parameter is waited for until it is stored.
        #[serde(default)]
        save: bool,
    },
    Stop {
        id: Option<Value>,
        monitor: Option<String>,
        of: Option<String>,
    },
    Close {
        id: Option<Value>,
        monitor: String,
        valve: Option<String>,
    },
    Lockout {
        id: Option<Value>,
        monitor: Option<String>,
    },
    Authority {
        id: Option<Value>,
        monitor: String,
        action: String,
        reason: Option<String>,
    },
    Jog {
        monitor: String,
        #[serde(flatten)]
        beat: JogBeat,
    },
    JogEnd {
        monitor: String,
        drive: String,
    },
    Watch {
        frames: Vec<String>,
    },
}

/// What a message says. Stop, Close and Lockout are understood as far as they can be, as over HTTP:
/// what makes no sense in them is left out.
fn understand(text: &str) -> Result<Said, serde_json::Error> {
    let error = match serde_json::from_str(text) {
        Ok(said) => return Ok(said),
        Err(error) => error,
    };
    let Ok(value) = serde_json::from_str::<Value>(text) else { return Err(error) };
    let word = |name: &str| value[name].as_str().map(str::to_owned);
    let id = value.get("id").cloned();
    match (value["type"].as_str(), word("monitor")) {
        (Some("stop"), monitor) => Ok(Said::Stop { id, monitor, of: word("of") }),
        (Some("lockout"), monitor) => Ok(Said::Lockout { id, monitor }),
        (Some("close"), Some(monitor)) => Ok(Said::Close { id, monitor, valve: word("valve") }),
        _ => Err(error),
    }
}

/// Opens the WebSocket.
#[utoipa::path(get, path = "/api/ws", params(Resume),
    responses((status = 101), (status = 400), (status = 401), (status = 403), (status = 426)))]
pub async fn upgrade(
    State(hub): State<Hub>,
    caller: Caller,
    Query(Resume { resume }): Query<Resume>,
    Extension(peer): Extension<Peer>,
    socket: WebSocketUpgrade,
) -> Response {
    let from: IpAddr = caller.seat.from.parse().unwrap_or(IpAddr::from([0, 0, 0, 0]));
    let principal = caller.principal;
    let socket = socket.read_buffer_size(READ_BUFFER);
    socket.max_message_size(MESSAGE_MAX).max_frame_size(MESSAGE_MAX).on_upgrade(
        move |socket| async move {
            serve(hub, socket, principal, from, resume).await;
            drop(peer);
        },
    )
}

async fn serve(
    hub: Hub,
    socket: WebSocket,
    principal: Principal,
    from: IpAddr,
    resume: Option<String>,
) {
    hub.counts.sockets.fetch_add(1, Ordering::Relaxed);
    let mut key = hub.sit_down(&principal, &from.to_string(), resume.as_deref());
    let caller = Caller::socket(principal, from, key.seat.clone());
    let (sink, stream) = socket.split();
    let (answers, waiting) = mpsc::channel(ANSWERS_MAX);
    let heard = Arc::new(AtomicBool::new(true));
    let reader = Reader {
        hub: hub.clone(),
        caller: caller.clone(),
        answers,
        heard: heard.clone(),
        room: Arc::new(Semaphore::new(REQUESTS_MAX)),
        watching: HashMap::new(),
        told: HashMap::new(),
    };
    let mut writer = Writer { hub: hub.clone(), caller, sink, version: 0 };
    let close = tokio::select! {
        close = reader.run(stream) => close,
        close = writer.run(&mut key, waiting, &heard) => close,
    };
    // What it moves is let go first; then good manners.
    hub.stand_up(&key);
    hub.counts.sockets.fetch_sub(1, Ordering::Relaxed);
    if let Some((code, reason)) = close {
        let frame = CloseFrame { code, reason: Utf8Bytes::from_static(reason) };
        _ = timeout(SLOW, writer.sink.send(Message::Close(Some(frame)))).await;
    }
}

/// Why a connection is closed; `None`: the other side has done it.
type Close = Option<(u16, &'static str)>;

const ENDED: (u16, &str) = (4401, "session ended");
const TOO_LARGE: (u16, &str) = (1009, "message too large");

struct Writer {
    hub: Hub,
    caller: Caller,
    sink: SplitSink<WebSocket, Message>,
    version: u64,
}

impl Writer {
    async fn run(
        &mut self,
        key: &mut SeatKey,
        mut answers: mpsc::Receiver<Value>,
        heard: &AtomicBool,
    ) -> Close {
        let mut changes = self.hub.changes.subscribe();
        match self.begin(key).await {
            Ok(()) => {}
            Err(close) => return close,
        }
        let mut ending = self.hub.ending.subscribe();
        let mut sessions = self.hub.sessions.subscribe();
        let mut pings = interval(PING);
        let mut silent_since = Instant::now();
        loop {
            let sent = tokio::select! {
                biased;
                Some(answer) = answers.recv() => self.send(&answer).await,
                Some(event) = key.events.recv() => self.event(key, &event).await,
                () = async { _ = ending.wait_for(|ending| *ending).await } => {
                    return Some((1001, "the hub ends"));
                }
                _ = pings.tick() => {
                    if heard.swap(false, Ordering::Relaxed) {
                        silent_since = Instant::now();
                    } else if silent_since.elapsed() >= SILENT {
                        return Some((4408, "silent"));
                    }
                    if !self.is_valid() {
                        return Some(ENDED);
                    }
                    self.put(Message::Ping(Vec::new().into())).await
                }
                Ok(()) = sessions.changed() => match self.is_valid() {
                    true => Ok(()),
                    false => return Some(ENDED),
                },
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

    fn is_valid(&self) -> bool {
        self.hub.access.is_valid(self.hub.clock.now_ms(), &self.caller.principal)
    }

    async fn begin(&mut self, key: &SeatKey) -> Result<(), Close> {
        let principal = &self.caller.principal;
        let watchdog_ms = u64::try_from(WATCHDOG.as_millis()).unwrap_or(300);
        let hello = json!({
            "type": "hello", "now_ms": self.hub.clock.now_ms(), "seat": key.seat,
            "resume": key.resume, "user": principal.user, "role": principal.role,
            "kind": principal.kind, "hub": self.hub.about(),
            "jog": { "beat_ms": BEAT_MS, "watchdog_ms": watchdog_ms },
        });
        self.send(&hello).await?;
        let (version, text) = broadcast::since(&self.hub, 0);
        self.version = version;
        self.put(Message::Text(text)).await
    }

    async fn event(&mut self, key: &SeatKey, event: &Value) -> Result<(), Close> {
        let missed = key.missed.swap(0, Ordering::Relaxed);
        if missed > 0 {
            self.send(&json!({ "type": "missed", "count": missed })).await?;
        }
        self.send(event).await
    }

    /// Who has kept up is sent what all are sent; who has not, what is new to them alone.
    async fn publish(&mut self, shared: &Shared) -> Result<(), Close> {
        let up_to_date = self.version == shared.to && shared.from != shared.to;
        let text = match self.version {
            version if version > shared.to || up_to_date => return Ok(()),
            version if version == shared.from && !shared.text.is_empty() => {
                self.version = shared.to;
                shared.text.clone()
            }
            version => {
                let (to, text) = broadcast::since(&self.hub, version);
                self.version = to;
                text
            }
        };
        self.put(Message::Text(text)).await
    }

    async fn send(&mut self, message: &Value) -> Result<(), Close> {
        self.put(Message::Text(message.to_string().into())).await
    }

    async fn put(&mut self, message: Message) -> Result<(), Close> {
        let counts = &self.hub.counts;
        counts.messages.fetch_add(1, Ordering::Relaxed);
        let bytes = match &message {
            Message::Text(text) => text.len(),
            _ => 0,
        };
        let bytes = u64::try_from(bytes).unwrap_or(0);
        counts.message_bytes.fetch_add(bytes, Ordering::Relaxed);
        match timeout(SLOW, self.sink.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(None),
            Err(_) => Err(Some((4409, "too slow"))),
        }
    }
}

struct Reader {
    hub: Hub,
    caller: Caller,
    answers: mpsc::Sender<Value>,
    heard: Arc<AtomicBool>,
    room: Arc<Semaphore>,
    watching: HashMap<String, AbortHandle>,
    /// What was said last of a drive: beats are many, news are few.
    told: HashMap<(String, String), &'static str>,
}

impl Reader {
    async fn run(mut self, mut stream: SplitStream<WebSocket>) -> Close {
        let (most, per_s) = MESSAGES;
        let mut bucket = Bucket::new(self.hub.now(), most, per_s);
        while let Some(message) = stream.next().await {
            let message = match message {
                Ok(message) => message,
                Err(error) if error.to_string().contains("too long") => return Some(TOO_LARGE),
                Err(_) => return None,
            };
            self.heard.store(true, Ordering::Relaxed);
            let text = match message {
                Message::Text(text) => text,
                Message::Close(_) => return None,
                _ => continue,
            };
            let said = understand(&text);
            let urgent =
                matches!(&said, Ok(Said::Stop { .. } | Said::Close { .. } | Said::Lockout { .. }));
            if !urgent && bucket.take(self.hub.now()).is_err() {
                return Some((4429, "too many messages"));
            }
            match said {
                Ok(said) => self.heed(said),
                Err(error) => {
                    let id = serde_json::from_str::<Value>(&text).ok().map(|it| it["id"].clone());
                    let error = super::guard::not_understood(&error).json();
                    let answer = json!({ "type": "answer", "id": id, "error": error });
                    _ = self.answers.try_send(answer);
                }
            }
        }
        None
    }

    fn heed(&mut self, said: Said) {
        match said {
            Said::Stop { id, monitor: None, .. } => self.everywhere(id, STOP),
            Said::Lockout { id, monitor: None } => self.everywhere(id, LOCKOUT),
            Said::Stop { id, monitor: Some(monitor), of } => {
                self.urgent(id, &monitor, |hub, caller, station| async move {
                    hub.stop(&caller, &station, of.as_deref()).await
                });
            }
            Said::Close { id, monitor, valve } => {
                self.urgent(id, &monitor, |hub, caller, station| async move {
                    hub.close(&caller, &station, valve.as_deref()).await
                });
            }
            Said::Lockout { id, monitor: Some(monitor) } => {
                self.urgent(id, &monitor, |hub, caller, station| async move {
                    hub.command(&caller, &station, LOCKOUT, None).await
                });
            }
            Said::Request { id, monitor, request, confirm, save } => {
                self.request(id, &monitor, request, confirm, save);
            }
            Said::Authority { id, monitor, action, reason } => {
                let result = self.hub.station(&monitor).and_then(|station| {
                    self.hub.change_authority(&self.caller, &station, &action, reason.as_deref())
                });
                self.answer(id, "authority", result);
            }
            Said::Jog { monitor, beat } => self.beat(monitor, &beat),
            Said::JogEnd { monitor, drive } => {
                let end = JogBeat { drive: drive.clone(), toward: None, t: None, end: true };
                if let Ok(station) = self.hub.station(&monitor) {
                    _ = self.hub.beat(&self.caller, &station, &end);
                }
                self.told.remove(&(monitor, drive));
            }
            Said::Watch { frames } => self.watch(&frames),
        }
    }

    /// A beat is answered where the state is news: `moving` and its end are told by the motion.
    fn beat(&mut self, monitor: String, beat: &JogBeat) {
        let result = self.hub.station(&monitor);
        let result = result.and_then(|station| self.hub.beat(&self.caller, &station, beat));
        let key = (monitor, beat.drive.clone());
        let (state, text) = match &result {
            Ok(state) => (*state, None),
            Err(error) => ("ended", Some(&error.text)),
        };
        let news = self.told.insert(key.clone(), state) != Some(state);
        if state == "armed" && news || state == "ended" {
            let message = json!({
                "type": "jog", "monitor": key.0, "drive": key.1, "state": state,
                "end": text.map(|_| "refused"), "text": text,
            });
            self.hub.tell(&self.caller.seat.seat, message);
        }
    }

    fn everywhere(&self, id: Option<Value>, text: &'static str) {
        let (hub, caller, answers) = (self.hub.clone(), self.caller.clone(), self.answers.clone());
        tokio::spawn(async move {
            let results = hub.everywhere(&caller, text).await;
            let answer = json!({ "type": "answer", "id": id, "results": results });
            _ = answers.send(answer).await;
        });
    }

    fn urgent<F>(
        &self,
        id: Option<Value>,
        monitor: &str,
        work: impl FnOnce(Hub, Caller, Arc<Station>) -> F,
    ) where
        F: Future<Output = Result<Value, ApiError>> + Send + 'static,
    {
        match self.hub.station(monitor) {
            Ok(station) => {
                let work = work(self.hub.clone(), self.caller.clone(), station.clone());
                let answers = self.answers.clone();
                tokio::spawn(
                    async move { _ = answers.send(answer(id, "result", work.await)).await },
                );
            }
            Err(error) => self.answer(id, "result", Err(error)),
        }
    }

    fn request(
        &self,
        id: Option<Value>,
        monitor: &str,
        request: String,
        confirm: Option<String>,
        save: bool,
    ) {
        let urgent = super::monitors::is_urgent(&request);
        let room = match self.room.clone().try_acquire_owned() {
            Ok(room) => Some(room),
            Err(_) if urgent => None,
            Err(_) => {
                let error = ApiError::slow_down(Duration::from_millis(100));
                return self.answer(id, "result", Err(error));
            }
        };
        self.urgent(id, monitor, |hub, caller, station| async move {
            let result = match save {
                true => hub.save(&caller, &station, &request).await,
                false => hub.command(&caller, &station, &request, confirm.as_deref()).await,
            };
            drop(room);
            result
        });
    }

    fn answer(&self, id: Option<Value>, name: &str, result: Result<Value, ApiError>) {
        let (answers, answer) = (self.answers.clone(), answer(id, name, result));
        tokio::spawn(async move { _ = answers.send(answer).await });
    }

    fn watch(&mut self, monitors: &[String]) {
        self.watching.retain(|id, task| {
            let stays = monitors.contains(id);
            if !stays {
                task.abort();
            }
            stays
        });
        for id in monitors {
            if let Ok(station) = self.hub.station(id)
                && !self.watching.contains_key(id)
            {
                let show = show_frames(self.hub.clone(), self.caller.clone(), station.clone());
                self.watching.insert(id.clone(), tokio::spawn(show).abort_handle());
            }
        }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        self.watching.values().for_each(AbortHandle::abort);
    }
}

fn answer(id: Option<Value>, name: &str, result: Result<Value, ApiError>) -> Value {
    let (name, value) = match result {
        Ok(value) => (name, value),
        Err(error) => ("error", error.json()),
    };
    let mut answer = json!({ "type": "answer", "id": id });
    answer[name] = value;
    answer
}

/// Shows the frames of a monitor to a connection.
async fn show_frames(hub: Hub, caller: Caller, station: Arc<Station>) {
    let mut clients = station.client.subscribe();
    let Ok(client) = clients.wait_for(Option::is_some).await.map(|client| client.clone()) else {
        return;
    };
    let Some(client) = client else { return };
    let mut frames = client.trace();
    loop {
        use tokio::sync::broadcast::error::RecvError;
        match frames.recv().await {
            Ok(frame) if frame.dst == client.address() || frame.src == client.address() => {
                let message = show(station.id(), hub.clock.now_ms(), &frame);
                hub.tell(&caller.seat.seat, message);
            }
            Ok(_) => {}
            Err(RecvError::Lagged(count)) => {
                hub.tell(&caller.seat.seat, json!({ "type": "missed", "count": count }));
            }
            Err(RecvError::Closed) => return,
        }
    }
}

fn show(monitor: &str, at_ms: u64, frame: &Traced) -> Value {
    let sent = frame.direction() == Direction::Sent;
    let verdict = format!("{:?}", frame.verdict).to_lowercase();
    let frame = Frame { dst: frame.dst, src: frame.src, payload: &frame.payload };
    let mut message = show_frame(monitor, at_ms, sent, &verdict, &frame);
    message["type"] = "frame".into();
    message
}

/// A frame as text and bytes.
pub fn show_frame(
    monitor: &str,
    at_ms: u64,
    sent: bool,
    verdict: &str,
    frame: &Frame<'_>,
) -> Value {
    let texts = Records::new(frame.payload).map(|record| match record {
        Ok(record) if sent => match Request::decode(&record) {
            Ok(request) => request.to_string(),
            Err(error) => error.to_string(),
        },
        Ok(record) => AnswerText(record).to_string(),
        Err(error) => error.to_string(),
    });
    let bytes: Vec<String> = frame.payload.iter().map(|byte| format!("{byte:02x}")).collect();
    json!({
        "monitor": monitor, "at_ms": at_ms, "direction": if sent { "out" } else { "in" },
        "verdict": verdict, "dst": frame.dst, "src": frame.src, "bytes": bytes.join(" "),
        "text": texts.collect::<Vec<_>>().join(" ; "),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::both;

    #[test]
    fn what_clients_say_is_understood() {
        let said = |text: &str| serde_json::from_str::<Said>(text);
        assert!(matches!(said(r#"{"type":"stop"}"#), Ok(Said::Stop { monitor: None, .. })));
        let jog =
            said(r#"{"type":"jog","monitor":"M1","drive":"Vertical","toward":"max","t":1.5}"#);
        assert!(matches!(jog, Ok(Said::Jog { beat: JogBeat { t: Some(_), end: false, .. }, .. })));
        assert!(said(r#"{"type":"jog_end","monitor":"M1","drive":"Vertical"}"#).is_ok());
        assert!(said(r#"{"type":"dance"}"#).is_err());
        let error = both("a", "б");
        assert_eq!(answer(None, "result", Err(ApiError::bad_request(error)))["error"]["en"], "a");
    }
}
