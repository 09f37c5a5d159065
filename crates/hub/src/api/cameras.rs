//! The cameras, and the pictures of one of them over a WebSocket of its own: the one that carries Stop never waits for
//! a picture.

use std::future::ready;
use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use lafet_texts::{Text as _, hub as text};
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::Path;
use super::ws::{ENDED, GOING_AWAY, PING, SILENT, SLOW, standing};
use crate::access::Standing;
use crate::cameras::feed::Viewer;
use crate::cameras::view::CameraNow;
use crate::cameras::{Camera, Watching};
use crate::error::ApiError;
use crate::hub::{Caller, Hub};

/// Longest message of a viewer: it says what it has seen.
const MESSAGE_MAX: usize = 128;
/// Messages of a viewer between two pings, 5 s: each picture of 60 a second that it has seen, and pongs.
const MESSAGES_MAX: u32 = 400;
/// At the end, what still comes is read for so long: closing with bytes unread resets the connection, and the viewer
/// would not learn why it was closed.
const LINGERS: Duration = Duration::from_secs(2);
const READ_BUFFER: usize = 1024;

const SILENT_VIEWER: (u16, &str) = (4408, "silent");
const TOO_SLOW: (u16, &str) = (4409, "too slow");
const TOO_MANY: (u16, &str) = (4429, "too many messages");

/// Why a connection is closed; `None`: the other side has done it.
type Close = Option<(u16, &'static str)>;

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new().routes(routes!(cameras)).routes(routes!(camera_stream))
}

/// The cameras and their states.
#[utoipa::path(get, path = "/api/cameras",
    responses((status = 200, body = Vec<CameraNow>), (status = 401)))]
async fn cameras(State(hub): State<Hub>, _: Caller) -> Json<Vec<CameraNow>> {
    Json(hub.cameras().views())
}

/// The pictures of a camera, as binary messages of a WebSocket.
#[utoipa::path(get, path = "/api/cameras/{id}/stream", params(("id" = String, Path)),
    responses((status = 101), (status = 400), (status = 401), (status = 403), (status = 404), (status = 503)))]
async fn camera_stream(
    State(hub): State<Hub>,
    caller: Caller,
    Path(id): Path<String>,
    socket: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Result<Response, ApiError> {
    let camera = hub.cameras().find(&id).ok_or_else(|| ApiError::no_camera(&id))?.clone();
    let socket = socket.map_err(|_| ApiError::bad_request(text::OnlyWebsocket.words()))?;
    let place = hub.cameras().place(&camera).ok_or_else(ApiError::too_many_viewers)?;
    let socket = socket.read_buffer_size(READ_BUFFER);
    let socket = socket.max_message_size(MESSAGE_MAX).max_frame_size(MESSAGE_MAX);
    Ok(socket.on_upgrade(move |socket| serve(hub, caller, camera, place, socket)))
}

async fn serve(hub: Hub, caller: Caller, camera: Arc<Camera>, place: Watching, socket: WebSocket) {
    let (sink, mut stream) = socket.split();
    let (viewer, heard) = (Viewer::default(), Instant::now());
    let mut own = View { hub, caller, camera, sink, viewer, heard, messages: 0 };
    let mut shutdown = own.hub.shutdown();
    let close = tokio::select! {
        close = own.run(&mut stream) => close,
        () = shutdown.requested() => Some(GOING_AWAY),
    };
    own.camera.skipped(own.viewer.skipped);
    drop(place);
    if let Some((code, reason)) = close {
        let frame = CloseFrame { code, reason: Utf8Bytes::from_static(reason) };
        _ = timeout(LINGERS, own.sink.send(Message::Close(Some(frame)))).await;
        let rest = async { while let Some(Ok(_)) = stream.next().await {} };
        _ = timeout(LINGERS, rest).await;
    }
}

/// The connection of a viewer.
struct View {
    hub: Hub,
    caller: Caller,
    camera: Arc<Camera>,
    sink: SplitSink<WebSocket, Message>,
    viewer: Viewer,
    /// When it has said something last.
    heard: Instant,
    /// Its messages since the last ping.
    messages: u32,
}

impl View {
    async fn run(&mut self, stream: &mut SplitStream<WebSocket>) -> Close {
        let mut news = self.camera.feed.news();
        let mut sessions = self.hub.access_changes();
        let mut ping = interval(PING);
        ping.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let next = self.camera.feed.next(&mut self.viewer, Instant::now());
            let has_more = next.is_some();
            // Not beside other branches: a picture whose sending is broken off would be lost.
            if let Some(picture) = next
                && let Err(close) = self.send(Message::Binary(picture)).await
            {
                return close;
            }
            let went_on = tokio::select! {
                biased;
                said = stream.next() => self.heed(said),
                _ = ping.tick() => self.ping().await,
                Ok(()) = sessions.changed() => self.may_go_on(),
                () = ready(()), if has_more => Ok(()),
                Ok(()) = news.changed(), if !has_more => Ok(()),
            };
            if let Err(close) = went_on {
                return close;
            }
        }
    }

    /// What it says: the number of a picture that it has seen, or nothing that matters.
    fn heed(&mut self, said: Option<Result<Message, axum::Error>>) -> Result<(), Close> {
        let Some(Ok(said)) = said else { return Err(None) };
        self.heard = Instant::now();
        self.messages += 1;
        if self.messages > MESSAGES_MAX {
            return Err(Some(TOO_MANY));
        }
        match said {
            Message::Close(_) => Err(None),
            Message::Binary(bytes) => {
                if let Ok(number) = <[u8; 4]>::try_from(&bytes[..]) {
                    self.viewer.has_seen(u32::from_be_bytes(number));
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    async fn ping(&mut self) -> Result<(), Close> {
        self.messages = 0;
        if self.heard.elapsed() >= SILENT {
            return Err(Some(SILENT_VIEWER));
        }
        self.may_go_on()?;
        self.send(Message::Ping(Vec::new().into())).await
    }

    /// A user who has logged out, or was removed, sees nothing any more.
    fn may_go_on(&self) -> Result<(), Close> {
        match standing(&self.hub, &self.caller.principal) {
            Some(Standing::Good) => Ok(()),
            _ => Err(Some(ENDED)),
        }
    }

    async fn send(&mut self, message: Message) -> Result<(), Close> {
        match timeout(SLOW, self.sink.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(None),
            Err(_) => Err(Some(TOO_SLOW)),
        }
    }
}
