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
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

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
const AT_ONCE_MAX: usize = 32;
/// Those of them that were asked for: alarms find room.
const ASKED_MAX: usize = 16;
/// Names that were given last and are not given again: two recordings may begin within a second.
const NAMES_MAX: usize = 256;
/// Requests that wait for the disk of the recordings at the same time.
const DISK_MAX: usize = 8;
/// Longest wait for the disk, for what waits in front of a file that is read, and at the end.
const DISK_WAIT: Duration = Duration::from_secs(3);

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
    unusable: Arc<AtomicBool>,
    /// Held while a file is sent: one after the other.
    pub sending: Arc<tokio::sync::Semaphore>,
    /// Turns of requests that wait for the disk: each takes a thread until the disk answers.
    disk: Arc<tokio::sync::Semaphore>,
}

/// What was last, with its time, ms since 1970. Recordings share it.
type Ring = VecDeque<(u64, Arc<Piece>)>;

#[derive(Debug, Default)]
struct Inner {
    rings: BTreeMap<String, Ring>,
    scenes: Ring,
    running: Vec<Running>,
    /// What has ended, and has found no room on its way to the disk yet.
    ending: Vec<Recording>,
    /// The names that were given last.
    names: VecDeque<String>,
}

#[derive(Debug)]
struct Running {
    meta: Recording,
    until_ms: u64,
}

/// Which monitors a recording is of, with their addresses.
pub type Whose = BTreeMap<u8, String>;

impl Recordings {
    /// Starts the thread that writes them. A folder that cannot be used, or a disk that does not answer, holds
    /// nothing up: without recordings the hub stops, opens and locks out all the same.
    pub fn open(config: &RecordingConfig) -> Result<Self, StoreError> {
        let folder = Folder::at(config.folder.clone());
        let (own, keep) = (folder.clone(), (config.keep_days, config.keep_mb));
        Self::written_by(config, folder, move |unusable, queue| {
            files::write(&own, keep, unusable, queue);
        })
    }

    /// The same with what is to write.
    fn written_by(
        config: &RecordingConfig,
        folder: Folder,
        write: impl FnOnce(&AtomicBool, &Receiver<Work>) + Send + 'static,
    ) -> Result<Self, StoreError> {
        let (work, queue) = sync_channel(QUEUE_MAX);
        let unusable = Arc::new(AtomicBool::new(false));
        let own = unusable.clone();
        let thread = std::thread::Builder::new()
            .name("lafet-recording".into())
            .spawn(move || write(&own, &queue))?;
        let (inner, thread) = (Mutex::default(), Mutex::new(Some(thread)));
        let turns = |count| Arc::new(tokio::sync::Semaphore::new(count));
        let (sending, disk) = (turns(1), turns(DISK_MAX));
        Ok(Self { folder, config: config.clone(), inner, work, thread, unusable, sending, disk })
    }

    /// The folder cannot be made, read or written: nothing is recorded.
    pub fn is_failing(&self) -> bool {
        self.unusable.load(Ordering::Relaxed)
    }

    /// Does something that waits for the disk, on a thread for that. A disk that does not answer
    /// takes a few threads, and who asks then is refused.
    ///
    /// # Errors
    ///
    /// [`StoreError::Busy`]: the disk answers nothing, and others wait for it already.
    pub async fn on_disk<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, StoreError> {
        let turn = tokio::time::timeout(DISK_WAIT, self.disk.clone().acquire_owned()).await;
        let Ok(Ok(turn)) = turn else { return Err(StoreError::Busy) };
        let done = tokio::task::spawn_blocking(move || {
            let _turn = turn;
            work()
        });
        done.await.map_err(|_| StoreError::Busy)
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
        if inner.running.iter().filter(|it| it.meta.cause == "asked").count() >= ASKED_MAX {
            return None;
        }
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
        if inner.running.len() + inner.ending.len() >= AT_ONCE_MAX {
            return None;
        }
        let monitors: Vec<String> = whose.values().cloned().collect();
        let rings = monitors.iter().filter_map(|monitor| inner.rings.get(monitor));
        let kept = rings.flatten().chain(&inner.scenes);
        let mut past: Vec<(u64, Arc<Piece>)> =
            kept.filter(|(at_ms, _)| *at_ms >= from_ms).cloned().collect();
        past.sort_by_key(|(at_ms, _)| *at_ms);
        // The folder is not asked: its disk may not answer. A name that it has already, as after the
        // date has stepped back, is changed where it is written.
        let taken = |name: &str| inner.names.iter().any(|it| it == name);
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
        if inner.names.len() >= NAMES_MAX {
            inner.names.pop_front();
        }
        inner.names.push_back(meta.name.clone());
        inner.running.push(Running { meta: meta.clone(), until_ms });
        Some(meta)
    }

    /// Ends what is complete; called each second.
    pub fn handle_time(&self, now_ms: u64, cautious_ms: u64) {
        let mut inner = lock(&self.inner);
        self.end(&mut inner, |it| it.until_ms <= now_ms);
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

    /// Ends a recording that is being written, by its name in the folder.
    pub fn end_one(&self, name: &str) {
        self.end(&mut lock(&self.inner), |it| {
            let written = self.folder.written(&it.meta.name);
            written.as_deref().unwrap_or(&it.meta.name) == name
        });
    }

    /// Ends all, as the hub ends, and waits for the disk, but not for one that does not answer.
    pub fn end_all(&self) {
        let Some(thread) = lock(&self.thread).take() else { return };
        let until = Instant::now() + DISK_WAIT;
        loop {
            let mut inner = lock(&self.inner);
            self.end(&mut inner, |_| true);
            if inner.ending.is_empty() && !self.is_full(Work::Stop) {
                break;
            }
            drop(inner);
            if !rest(until) {
                break;
            }
        }
        while !thread.is_finished() && rest(until) {}
        match thread.is_finished() {
            true => _ = thread.join(),
            false => tracing::warn!("the disk of the recordings does not answer"),
        }
    }

    /// Other monitors come: what was heard of the old ones is not theirs.
    pub fn forget(&self) {
        let mut inner = lock(&self.inner);
        inner.rings.clear();
        inner.scenes.clear();
        self.end(&mut inner, |_| true);
    }

    /// Ends recordings, and those that have found no room before. The end of a file is not lost to a full
    /// queue: it has the index.
    fn end(&self, inner: &mut Inner, ends: impl Fn(&Running) -> bool) {
        let ended = inner.running.extract_if(.., |it| ends(it));
        let ended = ended.map(|it| Recording { recording: false, ..it.meta });
        inner.ending.extend(ended);
        inner.ending.retain(|meta| self.is_full(Work::End(meta.clone())));
    }

    /// Hands work to the thread, or to none if it has ended; `true`: there is no room just now.
    fn is_full(&self, work: Work) -> bool {
        matches!(self.work.try_send(work), Err(TrySendError::Full(_)))
    }

    /// All recordings that are in the folder, the latest first; of those that are being written, how far they are.
    /// Waits for the disk.
    pub fn list(&self) -> Vec<Recording> {
        // What was started before has its file and its name then.
        self.flush();
        let running: Vec<Recording> =
            lock(&self.inner).running.iter().map(|it| it.meta.clone()).collect();
        let mut all = self.folder.list();
        for meta in running {
            let Some(name) = self.folder.written(&meta.name) else { continue };
            if let Some(it) = all.iter_mut().find(|it| it.name == name) {
                *it = Recording { name, size: it.size, ..meta };
            }
        }
        all.sort_by(|a, b| (b.from_ms, &b.name).cmp(&(a.from_ms, &a.name)));
        all
    }

    /// Writes to the disk what waits, so that a file that is being written can be read. A disk that does
    /// not answer is waited for only so long.
    pub fn flush(&self) {
        let (done, wait) = sync_channel(1);
        if self.work.try_send(Work::Flush(done)).is_ok() {
            _ = wait.recv_timeout(DISK_WAIT);
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

/// A short pause; `false`: it is late.
fn rest(until: Instant) -> bool {
    std::thread::park_timeout(Duration::from_millis(5));
    Instant::now() < until
}

fn address_of(piece: &Piece) -> Option<u8> {
    let Piece::Captured(captured) = piece else { return None };
    let mut address = None;
    player::frames(captured, |frame| address = player::monitor_of(frame));
    address
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use lafet_client::Verdict;

    use super::*;

    fn frame() -> Traced {
        let payload = vec![1, 2, 3].into();
        Traced { verdict: Verdict::Sent, dst: 1, src: 0, tagged: false, payload }
    }

    /// A disk that has stopped answering: what waits for it fills its queue, and nothing that the hub
    /// asks waits.
    #[tokio::test(flavor = "multi_thread", worker_threads = 1)]
    async fn a_disk_that_does_not_answer_holds_nothing_up() {
        let config = RecordingConfig { alarms: true, ..RecordingConfig::default() };
        let (answers, hung) = channel::<()>();
        let folder = Folder::fresh();
        let write = move |_: &AtomicBool, queue: &Receiver<Work>| {
            _ = hung.recv();
            queue.try_iter().for_each(drop);
        };
        let recordings = Arc::new(Recordings::written_by(&config, folder, write).unwrap());
        let own = recordings.clone();
        let (done, asked) = channel();
        std::thread::spawn(move || {
            own.frame(1, "M1", &frame());
            own.alarm(2, "M1", "M1/General/Fault");
            for at_ms in 0..QUEUE_MAX as u64 + 10 {
                own.frame(at_ms, "M1", &frame());
            }
            own.handle_time(u64::MAX, 0);
            let refused = own.ask((0, 3, 4), Whose::from([(1, "M1".into())]), "anna");
            let inner = lock(&own.inner);
            _ = done.send((inner.running.len(), inner.ending.len(), refused));
        });
        let patience = Duration::from_secs(60);
        assert_eq!(
            asked.recv_timeout(patience).unwrap(),
            (0, 1, None),
            "it ends when there is room"
        );
        answers.send(()).unwrap();
    }

    /// Two that begin within a second have names of their own, whatever the folder says.
    #[test]
    fn names_are_given_once() {
        let folder = Folder::fresh();
        let own = folder.clone();
        let write = move |unusable: &AtomicBool, queue: &Receiver<Work>| {
            files::write(&own, (10, 100), unusable, queue);
        };
        let recordings =
            Recordings::written_by(&RecordingConfig::default(), folder, write).unwrap();
        let (at_ms, whose) = (1_763_712_000_000, Whose::from([(1, "M1".to_owned())]));
        // Of another run, before the date was set back.
        let old = recordings.folder.path().join("20251121-080000-M1.mcap");
        std::fs::write(&old, "old").unwrap();
        let ask = || recordings.ask((at_ms, at_ms, at_ms), whose.clone(), "anna").unwrap().name;
        assert_eq!([ask(), ask()], ["20251121-080000-M1.mcap", "20251121-080000-M1-2.mcap"]);
        let listed = || {
            let all = recordings.list().into_iter();
            let mut all: Vec<String> =
                all.map(|it| format!("{} {} {}", it.name, it.cause, it.recording)).collect();
            all.sort();
            all
        };
        let [first, second] =
            ["20251121-080000-M1-2.mcap asked", "20251121-080000-M1-2-2.mcap asked"];
        let before = "20251121-080000-M1.mcap uploaded false".to_owned();
        let expected = [format!("{second} true"), format!("{first} true"), before.clone()];
        assert_eq!(listed(), expected, "by the names that they have");
        recordings.end_one("20251121-080000-M1-2.mcap");
        let expected = [format!("{second} true"), format!("{first} false"), before];
        assert_eq!(listed(), expected, "it ends the one that has this name");
        recordings.end_all();
        assert_eq!(std::fs::read_to_string(old).unwrap(), "old");
        let mut names: Vec<String> = recordings
            .list()
            .into_iter()
            .filter(|it| it.cause == "asked")
            .map(|it| it.name)
            .collect();
        names.sort();
        assert_eq!(names, ["20251121-080000-M1-2-2.mcap", "20251121-080000-M1-2.mcap"]);
    }

    /// What is asked for leaves room for alarms, and what alarms take is bounded too.
    #[test]
    fn alarms_find_room_beside_what_is_asked_for() {
        let config = RecordingConfig { alarms: true, ..RecordingConfig::default() };
        let write = |_: &AtomicBool, queue: &Receiver<Work>| {
            while !matches!(queue.recv(), Ok(Work::Stop) | Err(_)) {}
        };
        let recordings = Recordings::written_by(&config, Folder::fresh(), write).unwrap();
        let ask = || recordings.ask((0, 3, 9_000), Whose::from([(1, "M".into())]), "anna");
        assert_eq!(std::iter::from_fn(ask).take(1000).count(), ASKED_MAX);
        for number in 0..1000 {
            let monitor = format!("M{number}");
            recordings.frame(1, &monitor, &frame());
            recordings.alarm(2, &monitor, "Fault");
        }
        assert_eq!(lock(&recordings.inner).running.len(), AT_ONCE_MAX);
        let one = lock(&recordings.inner).running[0].meta.name.clone();
        recordings.end_one(&one);
        assert!(ask().is_some());
    }
}
