//! Recordings: the list, starting one, playing one back.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::path::{Path as FilePath, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

use axum::Json;
use axum::body::{Body as HttpBody, Bytes};
use axum::extract::{DefaultBodyLimit, Query, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use futures_util::{Stream, StreamExt};
use lafet_texts::{Shown, Text as _, hub as text};
use serde::Deserialize;
use tokio::sync::{Semaphore, mpsc};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, Path, not_understood, still_good};
use super::packed::refuse_packed;
use super::records::{Asked, between, needs};
use crate::access::Role;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::recording::player::Player;
use crate::recording::{Recording, UNPACKED_MAX, Whose, is_name};
use crate::store::{Act, StoreError};
use crate::sync::lock;
use crate::text::Both;

/// Largest file that is taken.
const UPLOAD_MAX: usize = 64 << 20;
/// Who sends a file while another one comes is asked to wait.
const SENDING: Duration = Duration::from_secs(5);
/// Longest recording that is asked for, s.
const SECONDS: std::ops::RangeInclusive<u64> = 1..=3600;
/// So much of what was before is recorded, s.
const BEFORE_S: u64 = 10;
/// Most lines of one answer.
pub const LINES_MAX: usize = 200_000;
/// Lines that are sent together.
const CHUNK: usize = 64 * 1024;
/// Held by who plays a recording: that takes a processor, and all others are for what has to be quick.
static PLAYS: Mutex<()> = Mutex::new(());
/// Recordings that are being played, each on its thread; of clients that have gone, too, until that is noticed.
static PLAYED: Semaphore = Semaphore::const_new(PLAYED_MAX);
const PLAYED_MAX: usize = 16;

pub fn routes() -> OpenApiRouter<Hub> {
    let upload = OpenApiRouter::new().routes(routes!(upload));
    OpenApiRouter::new()
        .routes(routes!(recordings))
        .routes(routes!(record))
        .routes(routes!(download))
        .routes(routes!(remove))
        .routes(routes!(recording_changes))
        .merge(upload.layer(DefaultBodyLimit::disable()))
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
#[into_params(parameter_in = Query)]
struct Named {
    name: Option<String>,
}

/// Part of a recording to return.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Part {
    from_ms: Option<u64>,
    to_ms: Option<u64>,
    /// Also return the frames.
    frames: Option<bool>,
}

/// All recordings, the latest first.
#[utoipa::path(get, path = "/api/recordings",
    responses((status = 200, body = Vec<Recording>), (status = 401), (status = 503)))]
async fn recordings(State(hub): State<Hub>, _: Caller) -> Result<Json<Vec<Recording>>, ApiError> {
    let own = hub.clone();
    Ok(Json(hub.recordings().on_disk(move || own.recordings().list()).await?))
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
        return Err(ApiError::bad_request(text::SecondsRange { from, to }.words()));
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
    let now_ms = hub.clock().now_ms();
    let times = (
        now_ms.saturating_sub(before_s.unwrap_or(BEFORE_S).saturating_mul(1000)),
        now_ms,
        now_ms + seconds * 1000,
    );
    let by = &caller.principal.user;
    let begun: Vec<Recording> =
        groups.into_iter().filter_map(|whose| hub.recordings().ask(times, whose, by)).collect();
    if begun.is_empty() {
        return Err(ApiError::slow_down(Duration::from_secs(seconds)));
    }
    for recording in &begun {
        let what = format!("record {}", recording.name);
        let act = Act::StartRecording { recording: recording.name.clone() };
        drop(hub.audit().note(hub.record(&caller, "", &what, "Ok").about(&act)));
    }
    Ok((StatusCode::CREATED, Json(begun)).into_response())
}

/// Downloads a recording.
#[utoipa::path(get, path = "/api/recordings/{name}", params(("name" = String, Path)),
    responses((status = 200, content_type = "application/octet-stream"), (status = 401), (status = 404), (status = 503)))]
async fn download(
    State(hub): State<Hub>,
    _: Caller,
    Path(name): Path<String>,
) -> Result<Response, ApiError> {
    let path = path(&hub, &name).await?;
    let own = hub.clone();
    let (file, size) = blocking(&hub, move || {
        own.recordings().flush();
        let file = std::fs::File::open(path)?;
        let size = file.metadata()?.len();
        Ok((file, size))
    })
    .await?;
    let headers = [
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
        (header::CONTENT_DISPOSITION, format!("attachment; filename=\"{name}\"")),
        (header::CONTENT_LENGTH, size.to_string()),
    ];
    Ok((headers, HttpBody::from_stream(parts(file, size))).into_response())
}

/// A file in parts, each read when the one before is taken.
fn parts(file: std::fs::File, size: u64) -> impl Stream<Item = std::io::Result<Bytes>> {
    let state = (file.take(size), size);
    futures_util::stream::try_unfold(state, |(mut file, left)| async move {
        if left == 0 {
            return Ok(None);
        }
        let read = move || {
            let mut part = Vec::with_capacity(CHUNK);
            file.by_ref().take(CHUNK as u64).read_to_end(&mut part)?;
            Ok::<_, std::io::Error>((part, file))
        };
        let (part, file) = tokio::task::spawn_blocking(read).await??;
        if part.is_empty() {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        let left = left.saturating_sub(part.len() as u64);
        Ok(Some((Bytes::from(part), (file, left))))
    })
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
    path(&hub, &name).await?;
    let act = Act::RemoveRecording { recording: name.clone() };
    let (own, what) = (hub.clone(), format!("remove {name}"));
    let removed = blocking(&hub, move || {
        own.recordings().end_one(&name);
        own.recordings().flush();
        own.recordings().folder.remove(&name)
    })
    .await;
    let outcome = removed.as_ref().map_or_else(|error| error.code, |()| "Ok");
    drop(hub.audit().note(hub.record(&caller, "", &what, outcome).about(&act)));
    removed.map(|()| StatusCode::NO_CONTENT)
}

/// Takes a file that was recorded elsewhere.
#[utoipa::path(post, path = "/api/recordings/upload", params(Named),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 201, body = Recording), (status = 400), (status = 401), (status = 403), (status = 413), (status = 429), (status = 503)))]
async fn upload(
    State(hub): State<Hub>,
    caller: Caller,
    named: Asked<Named>,
    headers: HeaderMap,
    body: HttpBody,
) -> Result<Response, ApiError> {
    needs(&caller, Role::Operator)?;
    refuse_packed(&headers)?;
    let Query(Named { name }) = named.map_err(|error| not_understood(&error))?;
    let Ok(turn) = hub.recordings().sending.clone().try_acquire_owned() else {
        return Err(ApiError::slow_down(SENDING));
    };
    let own = hub.clone();
    let (path, file) = blocking(&hub, move || own.recordings().folder.sent()).await?;
    let sent = Sent(path.clone());
    store(&hub, &caller, body, file).await?;
    still_good(&hub, &caller.principal)?;
    let known = whose(&hub);
    let (by, now_ms) = (caller.principal.user.clone(), hub.clock().now_ms());
    let own = hub.clone();
    let added = hub.recordings().on_disk(move || {
        let added = own.recordings().add(now_ms, &name.unwrap_or_default(), &path, &by, &known);
        drop((sent, turn));
        added
    });
    use crate::recording::Unfit;
    let recording = match added.await? {
        Ok(recording) => recording,
        Err(Unfit::Read(error)) => {
            return Err(ApiError::bad_request(text::RecordingNotFrames { error }.words()));
        }
        Err(Unfit::Io(error)) => return Err(StoreError::Io(error).into()),
    };
    let what = format!("upload {}", recording.name);
    let act = Act::UploadRecording { recording: recording.name.clone() };
    drop(hub.audit().note(hub.record(&caller, "", &what, "Ok").about(&act)));
    Ok((StatusCode::CREATED, Json(recording)).into_response())
}

/// A file that was sent. It is removed, unless it has become a recording.
struct Sent(PathBuf);

impl Drop for Sent {
    fn drop(&mut self) {
        let path = std::mem::take(&mut self.0);
        let remove = move || _ = std::fs::remove_file(path);
        // The disk is waited for elsewhere.
        match tokio::runtime::Handle::try_current() {
            Ok(runtime) => _ = runtime.spawn_blocking(remove),
            Err(_) => remove(),
        }
    }
}

/// Writes a body to the disk as it comes, as long as its sender may send it: others wait for the turn.
async fn store(
    hub: &Hub,
    caller: &Caller,
    body: HttpBody,
    mut file: std::fs::File,
) -> Result<(), ApiError> {
    let (mut body, mut size) = (body.into_data_stream(), 0);
    while let Some(part) = body.next().await {
        let part = part.map_err(|error| {
            ApiError::bad_request(text::UploadBroken { error: Shown(error) }.words())
        })?;
        still_good(hub, &caller.principal)?;
        size += part.len();
        if size > UPLOAD_MAX {
            let megabytes = UPLOAD_MAX >> 20;
            let text = text::UploadTooLarge { megabytes }.words();
            return Err(ApiError::new(StatusCode::PAYLOAD_TOO_LARGE, "too_large", text));
        }
        file = blocking(hub, move || file.write_all(&part).map(|()| file)).await?;
    }
    Ok(())
}

/// What the topics of the WebSocket were.
#[utoipa::path(get, path = "/api/recordings/{name}/changes", params(("name" = String, Path), Part),
    responses((status = 200, content_type = "application/x-ndjson"), (status = 400), (status = 401), (status = 404), (status = 503)))]
async fn recording_changes(
    State(hub): State<Hub>,
    _: Caller,
    Path(name): Path<String>,
    part: Asked<Part>,
) -> Result<Response, ApiError> {
    let Query(part) = part.map_err(|error| not_understood(&error))?;
    between(part.from_ms, part.to_ms)?;
    let path = path(&hub, &name).await?;
    let own = hub.clone();
    // Its beginning is read first: what is no recording is refused with its status.
    let begins = path.clone();
    let noted = blocking(&hub, move || {
        own.recordings().flush();
        lafet_capture::read_each(&begins, UNPACKED_MAX, |_| false)
            .map_err(std::io::Error::other)?;
        Ok(own.recordings().folder.about(&name).addresses)
    })
    .await?;
    let mut addresses = whose(&hub);
    // Addresses noted when it was made take precedence over the configuration.
    addresses.extend(noted);
    let mut player = Player::new(addresses, names(&hub));
    player.frames = part.frames.unwrap_or(false);
    let (to, lines) = mpsc::channel(4);
    begin(player, path, part, Sender::new(to)).await;
    Ok(lines_of(lines))
}

/// Begins to play a file when there is a thread for it.
async fn begin(player: Player, path: PathBuf, part: Part, to: Sender) {
    let one = PLAYED.acquire().await;
    tokio::task::spawn_blocking(move || {
        let _one = one;
        play(player, &path, &part, &to)
    });
}

/// Plays a file, as long as the client takes it; how many pieces of it were looked at. Others play while it is taken.
fn play(mut player: Player, path: &FilePath, part: &Part, to: &Sender) -> usize {
    let mut turn = Some(lock(&PLAYS));
    let to_ms = part.to_ms.unwrap_or(u64::MAX);
    let mut from_ms = None;
    let (mut begun, mut looked_at) = (false, 0);
    let (mut chunk, mut count) = (String::new(), 0);
    let read = lafet_capture::read_each(path, UNPACKED_MAX, |piece| {
        let at_ms = piece.at_ns() / 1_000_000;
        let from_ms = *from_ms.get_or_insert(part.from_ms.unwrap_or(at_ms).max(at_ms));
        looked_at += 1;
        // Before its beginning nothing is sent: who has gone would not be missed.
        if at_ms > to_ms || count >= LINES_MAX || to.is_gone() {
            return false;
        }
        if !begun && at_ms > from_ms {
            chunk += &player.everything(from_ms);
            begun = true;
        }
        if let Some(line) = player.piece(&piece).filter(|_| begun) {
            chunk += &line;
            count += 1;
        }
        if chunk.len() <= CHUNK {
            return true;
        }
        drop(turn.take());
        let goes_on = to.send(&mut chunk);
        turn = Some(lock(&PLAYS));
        goes_on
    });
    drop(turn);
    if let Err(error) = read {
        to.fail(std::io::Error::other(error));
        return looked_at;
    }
    chunk += &match begun {
        true => player.take().unwrap_or_default(),
        false => player.everything(from_ms.unwrap_or(0)),
    };
    to.send(&mut chunk);
    looked_at
}

/// Sends lines to an answer.
#[derive(Debug)]
pub struct Sender(mpsc::Sender<Result<String, std::io::Error>>);

impl Sender {
    /// Lines that are sent to this channel.
    pub const fn new(to: mpsc::Sender<Result<String, std::io::Error>>) -> Self {
        Self(to)
    }

    /// Sends what was collected; `false`: the client has gone.
    fn send(&self, chunk: &mut String) -> bool {
        self.0.blocking_send(Ok(std::mem::take(chunk))).is_ok()
    }

    fn is_gone(&self) -> bool {
        self.0.is_closed()
    }

    fn fail(&self, error: std::io::Error) {
        _ = self.0.blocking_send(Err(error));
    }
}

/// An answer of JSON lines.
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

async fn path(hub: &Hub, name: &str) -> Result<PathBuf, ApiError> {
    if !is_name(name) {
        return Err(ApiError::not_found());
    }
    let (own, name) = (hub.clone(), name.to_owned());
    let path = hub.recordings().on_disk(move || own.recordings().path(&name)).await?;
    path.ok_or_else(ApiError::not_found)
}

/// Runs work that waits for the disk on a thread for it.
async fn blocking<T: Send + 'static>(
    hub: &Hub,
    work: impl FnOnce() -> std::io::Result<T> + Send + 'static,
) -> Result<T, ApiError> {
    Ok(hub.recordings().on_disk(work).await?.map_err(StoreError::Io)?)
}

#[cfg(test)]
mod tests {
    use lafet_capture::{Captured, Direction, Format, Recorder};
    use lafet_proto::link::{BODY_MAX, Frame, encode};
    use lafet_proto::{RequestId, SubsystemId};

    use super::*;

    #[test]
    fn who_has_gone_is_played_nothing() {
        let path = std::env::temp_dir().join(format!("lafet-gone-{}.mcap", std::process::id()));
        let file = std::fs::File::create(&path).unwrap();
        let mut recorder = Recorder::new(Format::Mcap, file).unwrap();
        for second in 1..=100 {
            let (at_ns, direction) = (second * 1_000_000_000, Direction::ToMonitor);
            recorder.write(&Captured { at_ns, direction, bytes: vec![1, 2, 3] }).unwrap();
        }
        recorder.finish().unwrap();
        let (to, lines) = mpsc::channel(4);
        let part = Part { from_ms: Some(100_000), to_ms: None, frames: None };
        let play = || {
            let player = Player::new(Whose::new(), BTreeMap::new());
            play(player, &path, &part, &Sender::new(to.clone()))
        };
        assert_eq!(play(), 100);
        drop(lines);
        assert_eq!(play(), 1);
        std::fs::remove_file(path).unwrap();
    }

    /// As many as are asked for and given up again would take all threads.
    #[tokio::test]
    async fn few_recordings_are_played_at_a_time() {
        let player = || Player::new(Whose::new(), BTreeMap::new());
        let part = || Part { from_ms: None, to_ms: None, frames: None };
        let all = PLAYED.acquire_many(u32::try_from(PLAYED_MAX).unwrap()).await.unwrap();
        let (to, mut lines) = mpsc::channel(4);
        let mut begins = Box::pin(begin(player(), "/none".into(), part(), Sender::new(to)));
        let early = tokio::time::timeout(Duration::from_millis(50), &mut begins).await;
        assert!(early.is_err(), "it takes a thread");
        drop(all);
        begins.await;
        assert!(lines.recv().await.expect("it is played").is_err(), "there is no such file");
    }

    /// Playing takes one processor, whatever is played; and a client that takes nothing keeps no other from it.
    #[test]
    fn recordings_are_played_one_at_a_time() {
        let path = std::env::temp_dir().join(format!("lafet-plays-{}.mcap", std::process::id()));
        let mut recorder =
            Recorder::new(Format::Mcap, std::fs::File::create(&path).unwrap()).unwrap();
        let payload = [RequestId::STOP.0, SubsystemId::ALL.0, 0, 0];
        let mut out = [0; BODY_MAX * 2];
        let len = encode(&Frame { dst: 1, src: 129, payload: &payload }, &mut out).unwrap();
        for second in 1..=2000 {
            let (at_ns, direction) = (second * 1_000_000_000, Direction::ToMonitor);
            recorder.write(&Captured { at_ns, direction, bytes: out[..len].to_vec() }).unwrap();
        }
        recorder.finish().unwrap();
        let part = || Part { from_ms: None, to_ms: None, frames: Some(true) };
        let play = |to: mpsc::Sender<_>| {
            let mut player = Player::new(Whose::new(), BTreeMap::new());
            player.frames = true;
            play(player, &path, &part(), &Sender::new(to))
        };
        std::thread::scope(|threads| {
            let held = lock(&PLAYS);
            let ((unread, mut first), (read, mut second)) = (mpsc::channel(1), mpsc::channel(64));
            let waits = threads.spawn(|| play(unread));
            let other = threads.spawn(|| play(read));
            // Long enough to play both.
            std::thread::park_timeout(Duration::from_millis(300));
            assert!(first.try_recv().is_err() && second.try_recv().is_err(), "nothing is played");
            drop(held);
            assert_eq!(other.join().unwrap(), 2000, "it waits for no other client");
            assert!(second.try_recv().unwrap().unwrap().len() > CHUNK, "in several parts");
            while first.blocking_recv().is_some() {}
            assert_eq!(waits.join().unwrap(), 2000);
        });
        std::fs::remove_file(path).unwrap();
    }
}
