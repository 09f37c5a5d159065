//! The WebSocket: what changes, as it changes, and what has to be quick.

mod frames;
mod reader;
mod said;
mod writer;

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, WebSocketUpgrade};
use axum::extract::{Extension, Query, State};
use axum::response::Response;
use futures_util::{SinkExt, StreamExt};
use serde::Deserialize;
use tokio::sync::{Semaphore, mpsc, watch};
use tokio::time::timeout;
use utoipa::IntoParams;

use super::Place;
use super::guard::Peer;
use crate::access::{Principal, Standing};
use crate::api::network;
use crate::control::beats::Delay;
use crate::hub::{Caller, Hub};
use crate::publish::broadcast::Own;
use crate::publish::topics::Audience;
use crate::server::allowances::Talk;
pub use frames::show_frame;
use reader::{REQUESTS_MAX, Reader, URGENT_MAX};
pub use said::{Id, Said, kinds};
use writer::Writer;
pub use writer::{ENDED, PING, SILENT, SLOW};

/// Longest message of a client.
const MESSAGE_MAX: usize = 16 * 1024;
/// What a connection reads into; each has one, and clients say little.
const READ_BUFFER: usize = 4 * 1024;
/// How long what is left of a connection is read when the hub ends: it waits for its connections.
const FAREWELL: Duration = Duration::from_secs(1);
/// Answers that wait to be sent.
const ANSWERS_MAX: usize = 64;
/// What is written and not taken yet: many times what changes at once on a large site. A message beyond that ends the
/// connection, and of pongs beyond that the last one is sent.
const UNTAKEN_MAX: usize = 16 * 1024 * 1024;

/// How to resume a seat.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Resume {
    /// The secret of `hello`.
    resume: Option<String>,
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
    let socket = socket.read_buffer_size(READ_BUFFER).max_write_buffer_size(UNTAKEN_MAX);
    socket.max_message_size(MESSAGE_MAX).max_frame_size(MESSAGE_MAX).on_upgrade(
        move |socket| async move {
            serve(hub, socket, principal, (from, &peer.place), resume).await;
        },
    )
}

async fn serve(
    hub: Hub,
    socket: WebSocket,
    principal: Principal,
    (from, place): (IpAddr, &Arc<Place>),
    resume: Option<String>,
) {
    hub.counts().sockets.fetch_add(1, Ordering::Relaxed);
    place.read_on();
    let mut key = hub.connect(&principal, &from.to_string(), resume.as_deref());
    let caller = Caller::socket(principal, from, key.seat.clone());
    // Another session does not notice, wherever it is; nor does another place of this one.
    let talker = (caller.principal.key.clone(), network(from));
    let talk = hub.places().talks.take(hub.now(), &talker);
    let talk = talk.unwrap_or_else(|| Talk::new(hub.now()));
    let (sink, mut stream) = socket.split();
    let (answers, waiting) = mpsc::channel(ANSWERS_MAX);
    let pings = Arc::new(Pings::default());
    let (audience, turning) = watch::channel(Audience::default());
    let has = key.has.clone();
    let mut reader = Reader {
        hub: hub.clone(),
        caller: caller.clone(),
        answers,
        pings: pings.clone(),
        room: Arc::new(Semaphore::new(REQUESTS_MAX)),
        urgent_room: Arc::new(Semaphore::new(URGENT_MAX)),
        watching: HashMap::new(),
        told: HashMap::new(),
        audience,
        talk: talk.clone(),
        has: has.clone(),
        delay: Delay::default(),
        rest: None,
        full: false,
    };
    let mut writer = Writer {
        hub: hub.clone(),
        caller,
        sink,
        own: Own::default(),
        audience: Audience::default(),
        turning,
    };
    let close = tokio::select! {
        close = reader.run(&mut stream) => close,
        close = writer.run(&mut key, waiting, &pings) => close,
        () = has.clone().lost() => Some(RESUMED),
    };
    // Its motions end first; then the WebSocket is closed in order.
    hub.disconnect(&key);
    hub.places().talks.put(hub.now(), talker, talk);
    hub.counts().sockets.fetch_sub(1, Ordering::Relaxed);
    if let Some((code, reason)) = close {
        let frame = CloseFrame { code, reason: Utf8Bytes::from_static(reason) };
        let patience = if code == GOING_AWAY.0 { FAREWELL } else { SLOW };
        let closing = timeout(patience, writer.sink.send(Message::Close(Some(frame))));
        // A Stop that is stuck in it is one all the same.
        reader.close();
        let _ending = place.ending();
        let rest = async { tokio::join!(closing, timeout(patience, reader.run(&mut stream))) };
        tokio::select! {
            _ = rest => {}
            () = place.given_up() => {}
        }
    }
}

/// What is known of the other side by pings and by what it sends.
#[derive(Debug, Default)]
struct Pings {
    /// It has sent something since the last ping.
    heard: AtomicBool,
    /// The last ping waits for its pong.
    unanswered: AtomicBool,
}

/// How far the client of a connection may go on; `None`: not at all. Memory is asked, no disk.
pub(super) fn standing(hub: &Hub, principal: &Principal) -> Option<Standing> {
    let now_ms = hub.now_for(principal);
    match hub.access().is_valid(now_ms, principal) {
        true => Some(Standing::Good),
        false => principal.outlasted(now_ms).map(|left| left.standing),
    }
}

/// The hub ends.
pub(super) const GOING_AWAY: (u16, &str) = (1001, "the hub ends");
/// Another connection has resumed the seat.
const RESUMED: (u16, &str) = (4410, "resumed elsewhere");

/// Why a connection is closed; `None`: the other side has done it.
type Close = Option<(u16, &'static str)>;
