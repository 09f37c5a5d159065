//! Recordings: what there is, what somebody asks for, and what it shows.

use std::collections::BTreeMap;

use axum::Json;
use axum::body::{Body as HttpBody, Bytes};
use axum::extract::rejection::BytesRejection;
use axum::extract::{DefaultBodyLimit, Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use lafet_capture::Piece;
use serde::Deserialize;
use tokio::sync::mpsc;
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, not_understood};
use super::records::{Asked, needs};
use crate::access::Role;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::recording::player::Player;
use crate::recording::{Recording, Whose, is_name};
use crate::store::StoreError;
use crate::text::{Both, both};

/// Largest file that is taken.
const UPLOAD_MAX: usize = 64 << 20;
/// Longest recording that is asked for, s.
const SECONDS: std::ops::RangeInclusive<u64> = 1..=3600;
/// So much of what was before is recorded, s.
const BEFORE_S: u64 = 10;
/// Lines of an answer.
pub const LINES_MAX: usize = 200_000;
/// Lines that are sent together.
const CHUNK: usize = 64 * 1024;

pub fn routes() -> OpenApiRouter<Hub> {
    let upload = OpenApiRouter::new().routes(routes!(upload));
    OpenApiRouter::new()
        .routes(routes!(list))
        .routes(routes!(record))
        .routes(routes!(download))
        .routes(routes!(remove))
        .routes(routes!(changes))
        .merge(upload.layer(DefaultBodyLimit::max(UPLOAD_MAX)))
}

/// What is to be recorded.
#[derive(Debug, Deserialize, ToSchema)]
struct Wanted {
    monitor: Option<String>,
    seconds: u64,
    before_s: Option<u64>,
}

/// What a file is to be called.
#[derive(Debug, Deserialize, IntoParams)]
struct Named {
    name: Option<String>,
}

/// Part of a recording.
#[derive(Debug, Deserialize, IntoParams)]
struct Part {
    from_ms: Option<u64>,
    to_ms: Option<u64>,
    /// The frames as well.
    frames: Option<bool>,
}

/// All recordings, the latest first.
#[utoipa::path(get, path = "/api/recordings",
    responses((status = 200, body = Vec<Recording>), (status = 401)))]
async fn list(State(hub): State<Hub>, _: Caller) -> Json<Vec<Recording>> {
    let list = tokio::task::spawn_blocking(move || hub.recordings.list()).await;
    Json(list.unwrap_or_default())
}

/// Records from now on, and a little of what was before.
#[utoipa::path(post, path = "/api/recordings", request_body = Wanted,
    responses((status = 201, body = Vec<Recording>), (status = 400), (status = 401), (status = 403),
    (status = 404), (status = 429)))]
async fn record(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Wanted { monitor, seconds, before_s }): Body<Wanted>,
) -> Result<Response, ApiError> {
    needs(&caller, Role::Operator)?;
    if !SECONDS.contains(&seconds) {
        let (from, to) = (SECONDS.start(), SECONDS.end());
        return Err(ApiError::bad_request(both(
            format!("seconds is {from}…{to}."),
            format!("seconds — {from}…{to}."),
        )));
    }
    let stations = match &monitor {
        Some(id) => vec![hub.station(id)?],
        None => hub.stations(),
    };
    let mut groups: Vec<Whose> = Vec::new();
    for station in stations {
        let (address, id) = (station.config.endpoint.addresses().monitor, station.id().to_owned());
        match groups.iter_mut().find(|group| !group.contains_key(&address)) {
            Some(group) => _ = group.insert(address, id),
            None => groups.push(Whose::from([(address, id)])),
        }
    }
    let now_ms = hub.clock.now_ms();
    let times = (
        now_ms.saturating_sub(before_s.unwrap_or(BEFORE_S).saturating_mul(1000)),
        now_ms,
        now_ms + seconds * 1000,
    );
    let by = &caller.principal.user;
    let begun: Vec<Recording> =
        groups.into_iter().filter_map(|whose| hub.recordings.ask(times, whose, by)).collect();
    if begun.is_empty() {
        return Err(ApiError::slow_down(std::time::Duration::from_secs(seconds)));
    }
    for recording in &begun {
        let what = format!("record {}", recording.name);
        drop(hub.audit.note(hub.record(&caller, "", &what, "Ok")));
    }
    Ok((StatusCode::CREATED, Json(begun)).into_response())
}

/// The file.
#[utoipa::path(get, path = "/api/recordings/{name}", params(("name" = String, Path)),
    responses((status = 200, content_type = "application/octet-stream"), (status = 401), (status = 404)))]
async fn download(
    State(hub): State<Hub>,
    _: Caller,
    Path(name): Path<String>,
) -> Result<Response, ApiError> {
    let bytes = bytes(&hub, &name).await?;
    let kind = (header::CONTENT_TYPE, "application/octet-stream".to_owned());
    let name = (header::CONTENT_DISPOSITION, format!("attachment; filename=\"{name}\""));
    Ok(([kind, name], bytes).into_response())
}

/// Removes a recording.
#[utoipa::path(delete, path = "/api/recordings/{name}", params(("name" = String, Path)),
    responses((status = 204), (status = 401), (status = 403), (status = 404), (status = 503)))]
async fn remove(
    State(hub): State<Hub>,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<StatusCode, ApiError> {
    needs(&caller, Role::Engineer)?;
    path(&hub, &name)?;
    drop(hub.audit.note(hub.record(&caller, "", &format!("remove {name}"), "Ok")));
    blocking(move || {
        hub.recordings.end_one(&name);
        hub.recordings.flush();
        hub.recordings.folder.remove(&name)
    })
    .await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Takes a file that was recorded elsewhere.
#[utoipa::path(post, path = "/api/recordings/upload", params(Named),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 201, body = Recording), (status = 400), (status = 401), (status = 403), (status = 413), (status = 503)))]
async fn upload(
    State(hub): State<Hub>,
    caller: Caller,
    named: Asked<Named>,
    body: Result<Bytes, BytesRejection>,
) -> Result<Response, ApiError> {
    needs(&caller, Role::Operator)?;
    let Query(Named { name }) = named.map_err(|error| not_understood(&error))?;
    let body = body.map_err(|error| {
        let megabytes = UPLOAD_MAX >> 20;
        let text = both(
            format!("The file cannot be taken ({error}); at most {megabytes} MiB."),
            format!("Файл не принят ({error}); не более {megabytes} МиБ."),
        );
        match error.into_response().status() {
            status @ StatusCode::PAYLOAD_TOO_LARGE => ApiError::new(status, "too_large", text),
            _ => ApiError::bad_request(text),
        }
    })?;
    let known = whose(&hub);
    let (by, now_ms) = (caller.principal.user.clone(), hub.clock.now_ms());
    let own = hub.clone();
    let added = tokio::task::spawn_blocking(move || {
        own.recordings.add(now_ms, &name.unwrap_or_default(), &body, &by, &known)
    });
    use crate::recording::Unfit;
    let recording = match added.await {
        Ok(Ok(recording)) => recording,
        Ok(Err(Unfit::Read(error))) => {
            return Err(ApiError::bad_request(both(
                format!("This is no recording of frames: {error}."),
                format!("Это не запись кадров: {error}."),
            )));
        }
        Ok(Err(Unfit::Io(error))) => return Err(StoreError::Io(error).into()),
        Err(_) => return Err(StoreError::Busy.into()),
    };
    let what = format!("upload {}", recording.name);
    drop(hub.audit.note(hub.record(&caller, "", &what, "Ok")));
    Ok((StatusCode::CREATED, Json(recording)).into_response())
}

/// What the topics of the WebSocket were.
#[utoipa::path(get, path = "/api/recordings/{name}/changes", params(("name" = String, Path), Part),
    responses((status = 200, content_type = "application/x-ndjson"), (status = 400), (status = 401), (status = 404), (status = 503)))]
async fn changes(
    State(hub): State<Hub>,
    _: Caller,
    Path(name): Path<String>,
    part: Asked<Part>,
) -> Result<Response, ApiError> {
    let Query(part) = part.map_err(|error| not_understood(&error))?;
    let path = path(&hub, &name)?;
    let own = hub.clone();
    let pieces = blocking(move || {
        own.recordings.flush();
        lafet_capture::read_pieces(&path).map_err(std::io::Error::other)
    })
    .await?;
    let mut addresses = whose(&hub);
    // What was told when it was made counts more than what is configured now.
    addresses.extend(hub.recordings.folder.about(&name).addresses);
    let mut player = Player::new(addresses, names(&hub));
    player.frames = part.frames.unwrap_or(false);
    let (to, lines) = mpsc::channel(4);
    tokio::task::spawn_blocking(move || play(player, &pieces, &part, &Sender::new(to)));
    Ok(lines_of(lines))
}

fn play(mut player: Player, pieces: &[Piece], part: &Part, to: &Sender) {
    let at = |piece: &Piece| piece.at_ns() / 1_000_000;
    let first_ms = pieces.first().map_or(0, at);
    let from_ms = part.from_ms.unwrap_or(first_ms).max(first_ms);
    let to_ms = part.to_ms.unwrap_or(u64::MAX);
    let mut begun = false;
    let (mut chunk, mut count) = (String::new(), 0);
    for piece in pieces {
        let at_ms = at(piece);
        if at_ms > to_ms || count >= LINES_MAX {
            break;
        }
        if !begun && at_ms > from_ms {
            chunk += &player.everything(from_ms);
            begun = true;
        }
        if let Some(line) = player.piece(piece).filter(|_| begun) {
            chunk += &line;
            count += 1;
        }
        if chunk.len() > CHUNK && !to.send(&mut chunk) {
            return;
        }
    }
    chunk += &match begun {
        true => player.take().unwrap_or_default(),
        false => player.everything(from_ms),
    };
    to.send(&mut chunk);
}

/// Sends lines to an answer.
#[derive(Debug)]
pub struct Sender(mpsc::Sender<Result<String, std::io::Error>>);

impl Sender {
    /// To this answer.
    pub const fn new(to: mpsc::Sender<Result<String, std::io::Error>>) -> Self {
        Self(to)
    }

    /// Sends what has come together; `false`: nobody reads any more.
    fn send(&self, chunk: &mut String) -> bool {
        self.0.blocking_send(Ok(std::mem::take(chunk))).is_ok()
    }
}

/// An answer of lines.
pub fn lines_of(lines: mpsc::Receiver<Result<String, std::io::Error>>) -> Response {
    let stream = futures_util::stream::unfold(lines, |mut lines| async move {
        lines.recv().await.map(|chunk| (chunk, lines))
    });
    let kind = (header::CONTENT_TYPE, "application/x-ndjson");
    ([kind], HttpBody::from_stream(stream)).into_response()
}

/// The monitors by address; of several with the same, the first.
pub fn whose(hub: &Hub) -> Whose {
    let mut all = Whose::new();
    for station in hub.stations() {
        let address = station.config.endpoint.addresses().monitor;
        all.entry(address).or_insert_with(|| station.id().to_owned());
    }
    all
}

/// What the monitors are called.
pub fn names(hub: &Hub) -> BTreeMap<String, Both> {
    let all = hub.stations();
    all.iter().map(|it| (it.id().to_owned(), it.config.name.clone())).collect()
}

fn path(hub: &Hub, name: &str) -> Result<std::path::PathBuf, ApiError> {
    if !is_name(name) {
        return Err(ApiError::not_found());
    }
    hub.recordings.path(name).ok_or_else(ApiError::not_found)
}

async fn bytes(hub: &Hub, name: &str) -> Result<Vec<u8>, ApiError> {
    let (path, hub) = (path(hub, name)?, hub.clone());
    blocking(move || {
        hub.recordings.flush();
        std::fs::read(path)
    })
    .await
}

/// Work with the disk.
async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> std::io::Result<T> + Send + 'static,
) -> Result<T, ApiError> {
    let done = tokio::task::spawn_blocking(work).await.map_err(|_| StoreError::Busy)?;
    Ok(done.map_err(StoreError::Io)?)
}
