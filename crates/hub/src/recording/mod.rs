//! Recordings of frames: a ring of what was last, and files around alarms and on demand.
//!
//! ```text
//! owner ─▶ ring of each monitor ─┬─▶ what is being written ─▶ thread ─▶ NAME.mcap, NAME.mcap.json
//!                alarm, request ─┘
//! ```

mod files;
pub mod player;

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use lafet_capture::{Captured, Direction, Note, Piece};
use lafet_client::{Direction as Way, Traced};
use lafet_proto::link::{Frame, WIRE_MAX, encode};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::clock::shifted;
use crate::config::RecordingConfig;
use crate::simulation::Scene;
use crate::store::StoreError;
use crate::sync::lock;
use files::Work;
pub use files::{Folder, UNPACKED_MAX, Unfit, is_name};

/// The topic of what only a simulation knows.
pub const SCENE: &str = "scene";
/// Frames that are kept of a monitor: 5 minutes at 20 polls a second.
const RING_MAX: usize = 12_000;
/// Scenes of a simulation that are kept: 5 minutes at 5 a second.
const SCENES_MAX: usize = 1500;
/// Frames that wait for the disk; more are lost.
const QUEUE_MAX: usize = 10_000;
/// A recording that alarms extend ends after this time at the latest.
const LONGEST_MS: u64 = 3_600_000;
/// Recordings that are written at the same time.
const AT_ONCE_MAX: usize = 16;

/// A recording, as the API lists it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Recording {
    /// Name of the file.
    pub name: String,
    /// `alarm`, `asked` or `uploaded`.
    pub cause: String,
    /// User who started it.
    #[schema(required)]
    pub by: Option<String>,
    /// Id of the alarm that started it.
    #[schema(required)]
    pub alarm: Option<String>,
    /// Ids of the monitors whose frames it has.
    pub monitors: Vec<String>,
    /// Which address is which of them.
    #[serde(default)]
    #[schema(value_type = BTreeMap<String, String>)]
    pub addresses: BTreeMap<u8, String>,
    /// Time of the first frame, ms since 1970.
    pub from_ms: u64,
    /// Time of the last frame, ms since 1970.
    pub to_ms: u64,
    /// Size, bytes.
    pub size: u64,
    /// Whether it is being written.
    #[serde(default)]
    pub recording: bool,
}

/// The recordings of the hub.
#[derive(Debug)]
pub struct Recordings {
    /// Folder of the files.
    pub folder: Folder,
    config: RecordingConfig,
    inner: Mutex<Inner>,
    work: SyncSender<Work>,
    thread: Mutex<Option<JoinHandle<()>>>,
    /// Held while a file is sent: one after the other.
    pub sending: Arc<tokio::sync::Semaphore>,
}

/// What was last, with its time, ms since 1970. Recordings share it.
type Ring = VecDeque<(u64, Arc<Piece>)>;

#[derive(Debug, Default)]
struct Inner {
    rings: BTreeMap<String, Ring>,
    scenes: Ring,
    running: Vec<Running>,
}

#[derive(Debug)]
struct Running {
    meta: Recording,
    until_ms: u64,
}

/// Which monitors a recording is of, with their addresses.
pub type Whose = BTreeMap<u8, String>;

impl Recordings {
    /// Opens the folder of recordings.
    pub fn open(config: &RecordingConfig) -> Result<Self, StoreError> {
        let folder = Folder::open(config.folder.clone())?;
        let (work, queue) = sync_channel(QUEUE_MAX);
        let (own, keep) = (folder.path().to_owned(), (config.keep_days, config.keep_mb));
        let thread = std::thread::Builder::new()
            .name("lafet-recording".into())
            .spawn(move || files::write(&own, keep, &queue))?;
        let (inner, thread) = (Mutex::default(), Mutex::new(Some(thread)));
        let sending = Arc::new(tokio::sync::Semaphore::new(1));
        Ok(Self { folder, config: config.clone(), inner, work, thread, sending })
    }

    /// A frame of a monitor.
    pub fn frame(&self, now_ms: u64, monitor: &str, frame: &Traced) {
        let mut wire = [0; WIRE_MAX];
        let frame_of = Frame { dst: frame.dst, src: frame.src, payload: &frame.payload };
        let Some(len) = encode(&frame_of, &mut wire) else { return };
        let direction = match frame.direction() {
            Way::Sent => Direction::ToMonitor,
            Way::Received => Direction::FromMonitor,
        };
        let bytes = wire.get(..len).unwrap_or_default().to_vec();
        let captured = Captured { at_ns: now_ms.saturating_mul(1_000_000), direction, bytes };
        let piece = Arc::new(Piece::Captured(captured));
        let mut inner = lock(&self.inner);
        for running in &mut inner.running {
            if running.meta.monitors.iter().any(|it| it == monitor) {
                running.meta.to_ms = now_ms;
                let name = running.meta.name.clone();
                // A disk that is too slow for it loses frames, not the hub its time.
                _ = self.work.try_send(Work::Piece(name, piece.clone()));
            }
        }
        let before_ms = self.config.before_s * 1000;
        if !inner.rings.contains_key(monitor) {
            inner.rings.insert(monitor.to_owned(), VecDeque::new());
        }
        let Some(ring) = inner.rings.get_mut(monitor) else { return };
        ring.push_back((now_ms, piece));
        let old = |(at_ms, _): &(u64, Arc<Piece>)| now_ms.saturating_sub(*at_ms) > before_ms;
        while ring.len() > RING_MAX || ring.front().is_some_and(old) {
            ring.pop_front();
        }
    }

    /// What only a simulation knows: the replay shows it as well.
    pub fn scene(&self, now_ms: u64, scene: &Scene) {
        let at_ns = now_ms.saturating_mul(1_000_000);
        let json = serde_json::to_string(scene).unwrap_or_default();
        let piece = Arc::new(Piece::Note(Note { at_ns, topic: SCENE.into(), json }));
        let mut inner = lock(&self.inner);
        for running in &inner.running {
            let name = running.meta.name.clone();
            _ = self.work.try_send(Work::Piece(name, piece.clone()));
        }
        let before_ms = self.config.before_s * 1000;
        inner.scenes.push_back((now_ms, piece));
        let old = |(at_ms, _): &(u64, Arc<Piece>)| now_ms.saturating_sub(*at_ms) > before_ms;
        while inner.scenes.len() > SCENES_MAX || inner.scenes.front().is_some_and(old) {
            inner.scenes.pop_front();
        }
    }

    /// An alarm of a monitor: what was before it and what comes after it is recorded.
    pub fn alarm(&self, now_ms: u64, monitor: &str, id: &str) {
        if !self.config.alarms {
            return;
        }
        let until_ms = now_ms + self.config.after_s * 1000;
        let mut inner = lock(&self.inner);
        let running = inner.running.iter_mut().find(|it| {
            it.meta.cause == "alarm" && it.meta.monitors.first().is_some_and(|it| it == monitor)
        });
        if let Some(running) = running {
            running.until_ms = until_ms.min(running.meta.from_ms + LONGEST_MS);
            return;
        }
        // Of a monitor that was never heard there is nothing to record.
        let heard = inner.rings.get(monitor).and_then(|ring| ring.back());
        let Some(address) = heard.and_then(|(_, piece)| address_of(piece)) else { return };
        let whose = Whose::from([(address, monitor.to_owned())]);
        let meta = Recording {
            name: format!("{}-{monitor}-alarm.mcap", files::date(now_ms)),
            cause: "alarm".into(),
            alarm: Some(id.to_owned()),
            ..Recording::default()
        };
        self.begin(
            &mut inner,
            meta,
            whose,
            (now_ms.saturating_sub(self.config.before_s * 1000), now_ms, until_ms),
        );
    }

    /// Starts a recording on request; `None`: too many are being written.
    pub fn ask(
        &self,
        (from_ms, now_ms, until_ms): (u64, u64, u64),
        whose: Whose,
        by: &str,
    ) -> Option<Recording> {
        let mut inner = lock(&self.inner);
        let one = match whose.values().next() {
            Some(one) if whose.len() == 1 => format!("-{one}"),
            _ => String::new(),
        };
        let meta = Recording {
            name: format!("{}{one}.mcap", files::date(now_ms)),
            cause: "asked".into(),
            by: Some(by.to_owned()),
            ..Recording::default()
        };
        self.begin(&mut inner, meta, whose, (from_ms, now_ms, until_ms))
    }

    fn begin(
        &self,
        inner: &mut Inner,
        meta: Recording,
        whose: Whose,
        (from_ms, now_ms, until_ms): (u64, u64, u64),
    ) -> Option<Recording> {
        if inner.running.len() >= AT_ONCE_MAX {
            return None;
        }
        let monitors: Vec<String> = whose.values().cloned().collect();
        let rings = monitors.iter().filter_map(|monitor| inner.rings.get(monitor));
        let kept = rings.flatten().chain(&inner.scenes);
        let mut past: Vec<(u64, Arc<Piece>)> =
            kept.filter(|(at_ms, _)| *at_ms >= from_ms).cloned().collect();
        past.sort_by_key(|(at_ms, _)| *at_ms);
        let taken = |name: &str| {
            inner.running.iter().any(|it| it.meta.name == name) || self.folder.has(name)
        };
        let meta = Recording {
            name: files::fresh(&meta.name, taken),
            monitors,
            addresses: whose,
            from_ms: past.first().map_or(now_ms, |(at_ms, _)| *at_ms),
            to_ms: now_ms,
            recording: true,
            ..meta
        };
        let past = past.into_iter().map(|(_, piece)| piece).collect();
        self.work.try_send(Work::Begin(meta.clone(), past)).ok()?;
        inner.running.push(Running { meta: meta.clone(), until_ms });
        Some(meta)
    }

    /// Ends what is complete; called each second.
    pub fn handle_time(&self, now_ms: u64, cautious_ms: u64) {
        let mut inner = lock(&self.inner);
        for running in inner.running.extract_if(.., |it| it.until_ms <= now_ms) {
            self.end(running);
        }
        drop(inner);
        _ = self.work.try_send(Work::Keep(cautious_ms));
    }

    /// The date has stepped: what is under way ends after the time that it was to last.
    pub fn stepped(&self, by_ms: i64) {
        let mut inner = lock(&self.inner);
        for running in &mut inner.running {
            running.until_ms = shifted(running.until_ms, by_ms);
        }
        for (at_ms, _) in inner.rings.values_mut().flatten() {
            *at_ms = shifted(*at_ms, by_ms);
        }
        for (at_ms, _) in &mut inner.scenes {
            *at_ms = shifted(*at_ms, by_ms);
        }
    }

    /// Ends a recording that is being written.
    pub fn end_one(&self, name: &str) {
        let mut inner = lock(&self.inner);
        for running in inner.running.extract_if(.., |it| it.meta.name == name) {
            self.end(running);
        }
    }

    /// Ends all, as the hub ends, and waits for the disk.
    pub fn end_all(&self) {
        let running = std::mem::take(&mut lock(&self.inner).running);
        running.into_iter().for_each(|it| self.end(it));
        _ = self.work.send(Work::Stop);
        if let Some(thread) = lock(&self.thread).take() {
            _ = thread.join();
        }
    }

    /// Other monitors come: what was heard of the old ones is not theirs.
    pub fn forget(&self) {
        let mut inner = lock(&self.inner);
        inner.rings.clear();
        inner.scenes.clear();
        let running = std::mem::take(&mut inner.running);
        running.into_iter().for_each(|it| self.end(it));
    }

    fn end(&self, running: Running) {
        let meta = Recording { recording: false, ..running.meta };
        // The end of a file is not lost to a full queue: it has the index.
        _ = self.work.send(Work::End(meta));
    }

    /// All recordings, the latest first.
    pub fn list(&self) -> Vec<Recording> {
        let running: Vec<Recording> =
            lock(&self.inner).running.iter().map(|it| it.meta.clone()).collect();
        let mut all = self.folder.list();
        for meta in running {
            let size = self.folder.size(&meta.name);
            all.retain(|it| it.name != meta.name);
            all.push(Recording { size, ..meta });
        }
        all.sort_by(|a, b| (b.from_ms, &b.name).cmp(&(a.from_ms, &a.name)));
        all
    }

    /// Writes to the disk what waits, so that a file that is being written can be read.
    pub fn flush(&self) {
        let (done, wait) = sync_channel(1);
        if self.work.send(Work::Flush(done)).is_ok() {
            _ = wait.recv();
        }
    }

    /// An uploaded file.
    pub fn add(
        &self,
        now_ms: u64,
        name: &str,
        sent: &Path,
        by: &str,
        known: &Whose,
    ) -> Result<Recording, Unfit> {
        self.folder.add(now_ms, name, sent, by, known)
    }

    /// The path of a recording.
    pub fn path(&self, name: &str) -> Option<PathBuf> {
        (is_name(name) && self.folder.has(name)).then(|| self.folder.path().join(name))
    }
}

impl Drop for Recordings {
    fn drop(&mut self) {
        self.end_all();
    }
}

fn address_of(piece: &Piece) -> Option<u8> {
    let Piece::Captured(captured) = piece else { return None };
    let mut address = None;
    player::frames(captured, |frame| address = player::monitor_of(frame));
    address
}
