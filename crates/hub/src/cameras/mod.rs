//! Cameras: each is watched by a process of its own, whose pictures any number of viewers share.
//!
//! ```text
//!  process ══pipe══▶ watch ─▶ feed ─▶ viewer ─▶ WebSocket
//!  lafet-eyes          │        (kept since the last key frame)
//!                      └─▶ state: topic cameras/ID
//! ```
//!
//! Nothing here waits for a viewer: the feed keeps what a decoder needs to begin, and each viewer takes from it what it
//! has time for. See [`feed`].

pub mod feed;
mod message;
pub mod view;
mod watch;

use std::ffi::OsString;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use lafet_texts::{Text as _, hub as text};
use serde::{Deserialize, Serialize};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::Instant;
use utoipa::ToSchema;

use crate::hub::Hub;
use crate::plugs::mqtt::Login;
use crate::sync::lock;
use crate::text::Both;
use feed::Feed;
use view::{CameraNow, CameraView, CameraWord};

/// Most cameras.
pub const CAMERAS_MAX: usize = 16;
/// Viewers of a camera at a time, and of all.
pub const VIEWERS_MAX: usize = 16;
pub const VIEWERS_OF_ALL_MAX: usize = 64;

/// Where a camera is mounted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[schema(as = CameraMount)]
pub enum Mount {
    /// It looks at one place.
    #[default]
    Fixed,
    /// It turns with the barrel of its monitor.
    Barrel,
    /// On a mast, from above.
    Mast,
}

/// A camera of the configuration.
#[derive(Clone, PartialEq, Eq)]
pub struct CameraConfig {
    /// Its id in the API.
    pub id: String,
    /// Name for people.
    pub name: Both,
    /// `rtsp://…`, without a user.
    pub url: String,
    /// Whom the camera knows.
    pub login: Option<Login>,
    /// The monitors that it looks at.
    pub monitors: Vec<String>,
    /// The zones that it looks at.
    pub zones: Vec<String>,
    /// Where it is mounted.
    pub mount: Mount,
}

/// Without the URL, in which some cameras want a password.
impl fmt::Debug for CameraConfig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CameraConfig").field("id", &self.id).finish_non_exhaustive()
    }
}

/// The program that watches a camera, and its arguments; empty: there is none.
pub type CameraProgram = Vec<OsString>;

/// The cameras of a hub.
#[derive(Debug)]
pub struct Cameras {
    all: Vec<Arc<Camera>>,
    room: Arc<Semaphore>,
}

/// A camera, its pictures and its viewers.
#[derive(Debug)]
pub struct Camera {
    config: CameraConfig,
    /// Its pictures.
    pub feed: Feed,
    state: Mutex<State>,
    room: Arc<Semaphore>,
    counts: Counts,
}

/// What a camera counts.
#[derive(Debug, Default)]
pub struct Counts {
    frames: AtomicU64,
    bytes: AtomicU64,
    lost: AtomicU64,
    starts: AtomicU64,
    skipped: AtomicU64,
}

impl Counts {
    fn add(of: &AtomicU64, count: usize) {
        of.fetch_add(u64::try_from(count).unwrap_or(0), Ordering::Relaxed);
    }
}

/// How a camera is.
#[derive(Clone, Debug, PartialEq, Eq)]
struct State {
    word: CameraWord,
    /// Why there is no picture.
    why: Option<Both>,
    since_ms: u64,
    picture: Option<lafet_eyes::wire::Picture>,
}

/// The place of a viewer, as long as it watches.
#[derive(Debug)]
#[expect(dead_code, reason = "held for its end")]
pub struct Watching(OwnedSemaphorePermit, OwnedSemaphorePermit);

impl Cameras {
    /// Those of the configuration; nothing is watched yet.
    pub fn new(configs: &[CameraConfig], now_ms: u64) -> Self {
        let all = configs.iter().map(|config| Arc::new(Camera::new(config.clone(), now_ms)));
        Self { all: all.collect(), room: Arc::new(Semaphore::new(VIEWERS_OF_ALL_MAX)) }
    }

    /// The camera of this id.
    pub fn find(&self, id: &str) -> Option<&Arc<Camera>> {
        self.all.iter().find(|it| it.config.id == id)
    }

    /// All of them, as they are now.
    pub fn views(&self) -> Vec<CameraNow> {
        self.all.iter().map(|it| it.now()).collect()
    }

    /// A place for one viewer more, if there is one.
    pub fn place(&self, camera: &Camera) -> Option<Watching> {
        let own = camera.room.clone().try_acquire_owned().ok()?;
        Some(Watching(own, self.room.clone().try_acquire_owned().ok()?))
    }
}

impl Camera {
    fn new(config: CameraConfig, now_ms: u64) -> Self {
        let word = CameraWord::Connecting;
        Self {
            config,
            feed: Feed::default(),
            state: Mutex::new(State { word, why: None, since_ms: now_ms, picture: None }),
            room: Arc::new(Semaphore::new(VIEWERS_MAX)),
            counts: Counts::default(),
        }
    }

    /// Its id.
    pub fn id(&self) -> &str {
        &self.config.id
    }

    /// A viewer has gone that was sent on to a key frame so many times.
    pub fn skipped(&self, times: u64) {
        self.counts.skipped.fetch_add(times, Ordering::Relaxed);
    }

    /// What clients see of it.
    pub fn view(&self) -> CameraView {
        let state = lock(&self.state).clone();
        let CameraConfig { id, name, monitors, zones, mount, .. } = self.config.clone();
        let (codec, size) = match state.picture {
            Some(picture) => (Some(picture.codec), Some([picture.width, picture.height])),
            None => (None, None),
        };
        CameraView {
            id,
            name,
            monitors,
            zones,
            mount,
            state: state.word,
            why: state.why,
            since_ms: state.since_ms,
            codec,
            size,
        }
    }

    fn now(&self) -> CameraNow {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        CameraNow {
            camera: self.view(),
            viewers: VIEWERS_MAX - self.room.available_permits(),
            frames: of(&self.counts.frames),
            bytes: of(&self.counts.bytes),
            packets_lost: of(&self.counts.lost),
            skipped: of(&self.counts.skipped),
            starts: of(&self.counts.starts),
        }
    }

    /// Its state is this now: published if that is news. Returns what it was before, then.
    fn set(&self, hub: &Hub, word: CameraWord, why: Option<Both>) -> Option<CameraWord> {
        let before = {
            let mut state = lock(&self.state);
            if (state.word, &state.why) == (word, &why) {
                return None;
            }
            let before = state.word;
            (state.word, state.why, state.since_ms) = (word, why, hub.clock().now_ms());
            before
        };
        self.publish(hub);
        Some(before)
    }

    /// A key frame says how its stream is decoded. Returns whether that is news.
    fn shows(&self, picture: &lafet_eyes::wire::Picture) -> bool {
        let mut state = lock(&self.state);
        let news = state.picture.as_ref() != Some(picture);
        if news {
            state.picture = Some(picture.clone());
        }
        news
    }

    fn publish(&self, hub: &Hub) {
        hub.topics().set(&format!("cameras/{}", self.config.id), &self.view());
    }
}

/// Watches all cameras of the configuration.
pub fn start(hub: &Hub) {
    for camera in &hub.cameras().all {
        camera.publish(hub);
        if hub.config().camera_program.is_empty() {
            camera.set(hub, CameraWord::Failed, Some(text::CameraNoProgram.words()));
            continue;
        }
        let (own, camera) = (hub.clone(), camera.clone());
        drop(hub.again("camera", move || watch::watch(own.clone(), camera.clone())));
    }
}

/// Whether what began then has lasted for longer than this.
fn waited(since: Option<Instant>, now: Instant, most: std::time::Duration) -> bool {
    since.is_some_and(|since| now.saturating_duration_since(since) > most)
}
