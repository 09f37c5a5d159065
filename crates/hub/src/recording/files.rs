//! The folder of recordings, and the thread that writes them.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender};
use std::sync::{Arc, LazyLock, Mutex};
use std::time::{Duration, Instant, SystemTime};

use lafet_capture::{Format, Piece, ReadError, Recorder};
use time::OffsetDateTime;

use super::{Recording, Whose, player};
use crate::store::replace;
use crate::store::reserve::try_writing;
use crate::sync::lock;

/// How often the folder is looked at for what is too old or too much.
const KEEP: Duration = Duration::from_secs(60);
/// What a folder that can be used takes at least, bytes.
const PROBE_BYTES: usize = 64 << 10;
const DAY_MS: u64 = 86_400_000;
const MEGABYTE: u64 = 1_000_000;
/// 2000-01-01: what is said to be older was dated by no clock, or by one that was never set.
const DATED_MS: u64 = 946_684_800_000;
/// Suffix of the file that describes a recording.
const ABOUT: &str = "json";
const ENDINGS: [&str; 2] = [".mcap", ".pcapng"];
/// What is packed into a recording, bytes; of more, nothing is read.
pub const UNPACKED_MAX: u64 = 256 << 20;
/// How files begin that are still being sent.
const SENT: &str = ".sent-";
const NAME_MAX: usize = 100;

/// The same of this process; a number of a process may have been that of another one.
static OWN: LazyLock<String> = LazyLock::new(|| {
    let started = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default().as_nanos();
    format!("{SENT}{}-{started}-", std::process::id())
});

/// Work for the thread that writes.
#[derive(Debug)]
pub enum Work {
    /// A recording begins with these frames.
    Begin(Recording, Vec<Arc<Piece>>),
    /// A frame, or the scene, of a recording.
    Piece(String, Arc<Piece>),
    /// A recording ends.
    End(Recording),
    /// What waits is brought to the disk.
    Flush(SyncSender<()>),
    /// A second has passed: what is too old goes.
    Keep(u64),
    /// The thread ends.
    Stop,
}

/// Why an uploaded file is refused.
#[derive(Debug)]
pub enum Unfit {
    /// Not a recording.
    Read(ReadError),
    /// Writing failed.
    Io(io::Error),
}

impl From<ReadError> for Unfit {
    fn from(error: ReadError) -> Self {
        match error {
            // The hub's own disk, not what was sent.
            ReadError::Io(error) => Self::Io(error),
            other => Self::Read(other),
        }
    }
}

/// The folder; a temporary one goes with the last clone.
#[derive(Clone, Debug)]
pub struct Folder(Arc<Place>);

#[derive(Debug)]
struct Place {
    path: PathBuf,
    temporary: bool,
    /// The names in the folder of what is being written, by the names that were given.
    written: Mutex<HashMap<String, String>>,
}

impl Drop for Place {
    fn drop(&mut self) {
        if self.temporary {
            _ = fs::remove_dir_all(&self.path);
        }
    }
}

impl Folder {
    /// This folder, or a temporary one. The disk is not touched: it may not answer.
    pub fn at(path: Option<PathBuf>) -> Self {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let temporary = path.is_none();
        let path = path.unwrap_or_else(|| {
            let number = NUMBER.fetch_add(1, Ordering::Relaxed);
            std::env::temp_dir().join(format!("lafet-recordings-{}-{number}", std::process::id()))
        });
        Self(Arc::new(Place { path, temporary, written: Mutex::default() }))
    }

    /// Makes it, if it is not there, and takes over what a hub before this one has left in it.
    ///
    /// # Errors
    ///
    /// It cannot be made, read or written.
    fn prepare(&self) -> io::Result<()> {
        self.probe()?;
        for entry in fs::read_dir(self.path())?.flatten() {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            if name.starts_with(SENT) && !name.starts_with(OWN.as_str()) {
                _ = fs::remove_file(entry.path());
            }
        }
        self.mend();
        Ok(())
    }

    /// Writes something, and removes it.
    fn probe(&self) -> io::Result<()> {
        let (path, _) = self.sent()?;
        try_writing(&path, PROBE_BYTES)
    }

    /// What was being written when the hub was killed is complete as it is.
    fn mend(&self) {
        for meta in self.list().into_iter().filter(|it| it.recording) {
            let mut to_ms = meta.to_ms;
            _ = lafet_capture::read_each(&self.path().join(&meta.name), u64::MAX, |piece| {
                to_ms = piece.at_ns() / 1_000_000;
                true
            });
            _ = tell(self.path(), &Recording { to_ms, recording: false, ..meta });
        }
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.0.path
    }

    /// The name in the folder of a recording that is being written, by the name that it was given; `None`: it has no
    /// file.
    pub fn written(&self, given: &str) -> Option<String> {
        lock(&self.0.written).get(given).cloned()
    }

    /// Whether there is a file of this name.
    pub fn has(&self, name: &str) -> bool {
        self.path().join(name).is_file()
    }

    /// Size of a recording, bytes.
    pub fn size(&self, name: &str) -> u64 {
        fs::metadata(self.path().join(name)).map_or(0, |it| it.len())
    }

    /// All recordings that are in it.
    pub fn list(&self) -> Vec<Recording> {
        let Ok(entries) = fs::read_dir(self.path()) else { return Vec::new() };
        let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
        names.filter(|name| is_name(name)).map(|name| self.about(&name)).collect()
    }

    /// The description of a recording. Of one that was copied here, or whose description is lost, its
    /// file gives the time: it was written last after its last frame.
    pub fn about(&self, name: &str) -> Recording {
        let text = fs::read(about(self.path(), name)).unwrap_or_default();
        let told = serde_json::from_slice(&text).unwrap_or_else(|_| {
            let written_ms = self.written_ms(name);
            let (from_ms, to_ms) = (written_ms, written_ms);
            Recording { cause: "uploaded".into(), from_ms, to_ms, ..Recording::default() }
        });
        Recording { name: name.to_owned(), size: self.size(name), ..told }
    }

    /// When a file was written last; 0: that is not known.
    fn written_ms(&self, name: &str) -> u64 {
        let at = fs::metadata(self.path().join(name)).and_then(|it| it.modified());
        let since = at.ok().and_then(|at| at.duration_since(SystemTime::UNIX_EPOCH).ok());
        since.and_then(|it| u64::try_from(it.as_millis()).ok()).unwrap_or(0)
    }

    /// From when on the age of a recording counts: its last frame. A file that was sent is as old as it is here,
    /// whatever its frames say.
    fn aged_from_ms(&self, meta: &Recording) -> u64 {
        if meta.cause == "uploaded" { self.written_ms(&meta.name) } else { meta.to_ms }
    }

    /// Removes a recording.
    pub fn remove(&self, name: &str) -> io::Result<()> {
        _ = fs::remove_file(about(self.path(), name));
        fs::remove_file(self.path().join(name))
    }

    /// A file for an upload; [`Folder::list`] does not show it.
    pub fn sent(&self) -> io::Result<(PathBuf, File)> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        fs::create_dir_all(self.path())?;
        let path = self.path().join(format!("{}{number}", *OWN));
        let file = File::create(&path)?;
        Ok((path, file))
    }

    /// Takes a file that was sent, if it is a recording.
    pub fn add(
        &self,
        now_ms: u64,
        name: &str,
        sent: &Path,
        by: &str,
        known: &Whose,
    ) -> Result<Recording, Unfit> {
        let about = About::read(sent, known)?;
        let mut first = [0; 8];
        let mut file = File::open(sent).map_err(Unfit::Io)?;
        let len = file.read(&mut first).map_err(Unfit::Io)?;
        let format = Format::of_bytes(first.get(..len).unwrap_or_default());
        let ending = if format == Some(Format::Mcap) { ".mcap" } else { ".pcapng" };
        let stem = ENDINGS.iter().find_map(|it| name.strip_suffix(it)).unwrap_or(name);
        let fine = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
        let stem: String = stem.chars().map(|c| if fine(c) { c } else { '_' }).take(60).collect();
        let stem = stem.trim_matches(['.', '_']);
        let stem = if stem.is_empty() { date(now_ms) } else { stem.to_owned() };
        // A recording may begin by the same name: it is made sure of before it is replaced.
        let (name, _) = create(self.path(), &(stem + ending)).map_err(Unfit::Io)?;
        if let Err(error) = fs::rename(sent, self.path().join(&name)) {
            _ = fs::remove_file(self.path().join(&name));
            return Err(Unfit::Io(error));
        }
        let meta = Recording {
            size: self.size(&name),
            cause: "uploaded".into(),
            by: Some(by.to_owned()),
            monitors: about.addresses.values().cloned().collect(),
            addresses: about.addresses,
            from_ms: about.first_ms.unwrap_or(now_ms),
            to_ms: about.last_ms.unwrap_or(now_ms),
            name,
            ..Recording::default()
        };
        tell(self.path(), &meta).map_err(Unfit::Io)?;
        Ok(meta)
    }
}

/// What is in a file that was sent.
#[derive(Debug, Default)]
struct About {
    addresses: BTreeMap<u8, String>,
    first_ms: Option<u64>,
    last_ms: Option<u64>,
}

impl About {
    fn read(path: &Path, known: &Whose) -> Result<Self, ReadError> {
        let mut about = Self::default();
        lafet_capture::read_each(path, UNPACKED_MAX, |piece| {
            if let Piece::Captured(captured) = &piece {
                let at_ms = captured.at_ns / 1_000_000;
                about.first_ms.get_or_insert(at_ms);
                about.last_ms = Some(at_ms);
                player::frames(captured, |frame| {
                    if let Some(address) = player::monitor_of(frame) {
                        let name = || player::name_of(known, address);
                        about.addresses.entry(address).or_insert_with(name);
                    }
                });
            }
            true
        })?;
        Ok(about)
    }
}

/// Whether it can be the name of a recording, and nothing else.
pub fn is_name(name: &str) -> bool {
    let fine = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    let ends = ENDINGS.iter().any(|it| name.len() > it.len() && name.ends_with(it));
    ends && name.len() <= NAME_MAX && !name.starts_with('.') && name.chars().all(fine)
}

/// A name that no other has.
pub fn fresh(name: &str, taken: impl Fn(&str) -> bool) -> String {
    let (stem, ending) = name.rsplit_once('.').unwrap_or((name, "mcap"));
    let mut names = (2..).map(|number| format!("{stem}-{number}.{ending}"));
    if taken(name) { names.find(|name| !taken(name)).unwrap_or_default() } else { name.to_owned() }
}

/// `20261121-123005`, UTC.
pub fn date(now_ms: u64) -> String {
    let seconds = i64::try_from(now_ms / 1000).unwrap_or(0);
    let at = OffsetDateTime::from_unix_timestamp(seconds).unwrap_or(OffsetDateTime::UNIX_EPOCH);
    format!(
        "{:04}{:02}{:02}-{:02}{:02}{:02}",
        at.year(),
        u8::from(at.month()),
        at.day(),
        at.hour(),
        at.minute(),
        at.second()
    )
}

fn about(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.{ABOUT}"))
}

/// Whole or not at all: a full disk or a power cut leaves the description that was there.
fn tell(folder: &Path, meta: &Recording) -> io::Result<()> {
    let path = about(folder, &meta.name);
    replace(&path, &path.with_extension("json.new"), &serde_json::to_vec(meta)?)
}

/// The recordings that are being written, by the names that they were given.
type Open = HashMap<String, Written>;

/// A recording that is being written.
struct Written {
    /// The name that it has in the folder.
    name: String,
    /// `None`: writing has failed; what could be written stays.
    recorder: Option<Recorder<File>>,
}

/// Writes recordings until there is nothing more to do. As long as the folder cannot be used, `unusable` is
/// set, and it is tried again.
pub fn write(place: &Folder, keep: (u32, u64), unusable: &AtomicBool, queue: &Receiver<Work>) {
    let mut writer = Writer::new(place, keep, unusable);
    writer.prepare();
    while let Ok(work) = queue.recv() {
        if matches!(work, Work::Stop) {
            return;
        }
        writer.handle(work);
    }
}

/// What the thread has to do with.
struct Writer<'a> {
    place: &'a Folder,
    keep: (u32, u64),
    unusable: &'a AtomicBool,
    /// What a hub before this one has left is taken over.
    prepared: bool,
    open: Open,
    /// When the folder was looked at last: the date may step back.
    kept: Option<Instant>,
}

impl<'a> Writer<'a> {
    fn new(place: &'a Folder, keep: (u32, u64), unusable: &'a AtomicBool) -> Self {
        Self { place, keep, unusable, prepared: false, open: Open::new(), kept: None }
    }

    /// Sees whether the folder can be used.
    fn prepare(&mut self) {
        let usable = if self.prepared { self.place.probe() } else { self.place.prepare() };
        if let Err(error) = &usable {
            let folder = self.place.path().display();
            tracing::error!(%error, %folder, "nothing can be recorded");
        }
        self.prepared |= usable.is_ok();
        self.unusable.store(usable.is_err(), Ordering::Relaxed);
    }

    fn try_again(&mut self) {
        if self.unusable.load(Ordering::Relaxed) {
            self.prepare();
        }
    }

    fn failed(&self, error: &io::Error) {
        self.unusable.store(true, Ordering::Relaxed);
        tracing::warn!(%error, "a recording is not stored");
    }

    fn handle(&mut self, work: Work) {
        match work {
            Work::Begin(meta, past) => {
                self.try_again();
                let given = meta.name.clone();
                match begin(self.place.path(), meta) {
                    Ok((name, file)) => {
                        let recorder = start(file, &past);
                        if let Err(error) = &recorder {
                            self.failed(error);
                        }
                        lock(&self.place.0.written).insert(given.clone(), name.clone());
                        self.open.insert(given, Written { name, recorder: recorder.ok() });
                    }
                    Err(error) => self.failed(&error),
                }
            }
            Work::Piece(name, piece) => {
                let Some(written) = self.open.get_mut(&name) else { return };
                let put = written.recorder.as_mut().map_or(Ok(()), |it| put(it, &piece));
                if let Err(error) = put {
                    // A full disk is not tried for each frame.
                    written.recorder = None;
                    self.failed(&error);
                }
            }
            Work::End(meta) => {
                // Of one that has no file there is nothing to describe: its name may be another's.
                let Some(Written { name, recorder }) = self.open.remove(&meta.name) else { return };
                lock(&self.place.0.written).remove(&meta.name);
                let ended = recorder.map_or(Ok(()), Recorder::finish);
                let meta = Recording { name, ..meta };
                if let Err(error) = ended.and_then(|()| tell(self.place.path(), &meta)) {
                    self.failed(&error);
                }
            }
            Work::Flush(done) => {
                self.flush();
                _ = done.send(());
            }
            Work::Keep(now_ms) => {
                // A hub that is killed loses what has come since: a second.
                self.flush();
                if self.kept.is_none_or(|at| at.elapsed() >= KEEP) {
                    self.kept = Some(Instant::now());
                    self.try_again();
                    forget(self.place, now_ms, self.keep, &self.open);
                }
            }
            Work::Stop => {}
        }
    }

    fn flush(&mut self) {
        let recorders = self.open.values_mut().filter_map(|it| it.recorder.as_mut());
        let flushed = recorders.filter_map(|it| it.flush().err());
        if let Some(error) = flushed.last()
            && !self.unusable.swap(true, Ordering::Relaxed)
        {
            tracing::warn!(%error, "recordings are not stored");
        }
    }
}

/// Makes the file of a recording and its description, by another name if there is one of its name.
fn begin(folder: &Path, meta: Recording) -> io::Result<(String, File)> {
    let (name, file) = create(folder, &meta.name)?;
    let meta = Recording { name, ..meta };
    if let Err(error) = tell(folder, &meta) {
        _ = fs::remove_file(folder.join(&meta.name));
        return Err(error);
    }
    Ok((meta.name, file))
}

/// Makes a file by this name, or by one that no other has: others may make one at the same time.
fn create(folder: &Path, name: &str) -> io::Result<(String, File)> {
    let mut tried = BTreeSet::new();
    loop {
        let name = fresh(name, |name| tried.contains(name) || folder.join(name).exists());
        match File::create_new(folder.join(&name)) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => _ = tried.insert(name),
            made => return Ok((name, made?)),
        }
    }
}

/// Writes what was before.
fn start(file: File, past: &[Arc<Piece>]) -> io::Result<Recorder<File>> {
    let mut recorder = Recorder::new(Format::Mcap, file)?;
    past.iter().try_for_each(|piece| put(&mut recorder, piece))?;
    Ok(recorder)
}

fn put(recorder: &mut Recorder<File>, piece: &Piece) -> io::Result<()> {
    match piece {
        Piece::Captured(captured) => recorder.write(captured),
        Piece::Note(note) => recorder.note(note),
    }
}

/// Removes what is too old, and the oldest while all are too much. What is written stays. A file of
/// unknown age is never too old, and goes last when there is too much.
fn forget(place: &Folder, now_ms: u64, (days, megabytes): (u32, u64), open: &Open) {
    let before_ms = now_ms.saturating_sub(u64::from(days) * DAY_MS);
    let mut all = place.list();
    all.retain(|it| open.values().all(|written| written.name != it.name));
    all.sort_by_cached_key(|it| {
        let from_ms = place.aged_from_ms(it);
        (from_ms < DATED_MS, from_ms)
    });
    let mut total: u64 = all.iter().map(|it| it.size).sum();
    for meta in all {
        let old = (DATED_MS..before_ms).contains(&place.aged_from_ms(&meta));
        if !old && total <= megabytes.saturating_mul(MEGABYTE) {
            return;
        }
        total = total.saturating_sub(meta.size);
        tracing::info!(name = %meta.name, "recording is removed: too old, or there are too many");
        _ = place.remove(&meta.name);
    }
}

#[cfg(test)]
impl Folder {
    /// A temporary one that is there.
    pub fn fresh() -> Self {
        let folder = Self::at(None);
        folder.prepare().unwrap();
        folder
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_nowhere_else() {
        for name in ["a.mcap", "20261121-123005-M1-alarm-2.mcap", "x.pcapng"] {
            assert!(is_name(name), "{name}");
        }
        for name in
            ["", ".mcap", "../a.mcap", "a/b.mcap", "a.json", "a.mcap.json", "б.mcap", ".a.mcap"]
        {
            assert!(!is_name(name), "{name}");
        }
        assert_eq!(fresh("a.mcap", |name| name != "a-3.mcap"), "a-3.mcap");
        assert_eq!(date(1_763_712_000_000), "20251121-080000");
    }

    /// A file that the hub itself cannot read says nothing about what was sent.
    #[test]
    fn a_disk_that_fails_is_no_fault_of_the_sender() {
        let folder = Folder::fresh();
        let (sent, none) = (folder.path().join("sent"), Whose::default());
        let add = || folder.add(0, "a.mcap", &sent, "anna", &none);
        assert!(matches!(add(), Err(Unfit::Io(_))));
        fs::write(&sent, "text").unwrap();
        assert!(matches!(add(), Err(Unfit::Read(ReadError::Unknown))));
    }

    /// Recordings that begin at the same time, and a name that looks free until a file is made by it.
    #[test]
    fn no_recording_takes_the_place_of_another() {
        let folder = Folder::fresh();
        let meta = || Recording { name: "a.mcap".into(), ..Recording::default() };
        #[cfg(unix)]
        std::os::unix::fs::symlink("nowhere", folder.path().join("a.mcap")).unwrap();
        let mut names: Vec<String> = std::thread::scope(|scope| {
            let begin = || begin(folder.path(), meta()).unwrap().0;
            let all: Vec<_> = (0..8).map(|_| scope.spawn(begin)).collect();
            all.into_iter().map(|it| it.join().unwrap()).collect()
        });
        names.sort();
        names.dedup();
        assert_eq!((names.len(), left(&folder).len()), (8, 8 + usize::from(cfg!(unix))));
        // What is sent meanwhile.
        let sent = folder.path().join("sent");
        let mut recorder = Recorder::new(Format::Mcap, File::create(&sent).unwrap()).unwrap();
        let (at_ns, direction) = (1_000_000_000, lafet_capture::Direction::ToMonitor);
        let bytes = vec![1, 2, 3];
        recorder.write(&lafet_capture::Captured { at_ns, direction, bytes }).unwrap();
        recorder.finish().unwrap();
        let added = folder.add(0, "a.mcap", &sent, "anna", &Whose::default()).unwrap();
        assert!(!names.contains(&added.name) && added.name != "a.mcap", "{}", added.name);
        #[cfg(unix)]
        assert!(folder.path().join("a.mcap").is_symlink());
    }

    /// A recording of 0.6 MB that ends so many days after 2000, if its word is there.
    fn put_one(folder: &Folder, name: &str, day: Option<u64>) {
        fs::write(folder.path().join(name), vec![0; 600_000]).unwrap();
        let Some(day) = day else { return };
        let to_ms = DATED_MS + day * DAY_MS;
        let meta = Recording { name: name.into(), to_ms, ..Recording::default() };
        tell(folder.path(), &meta).unwrap();
    }

    /// A file was written so many days after 1970.
    fn set_written(folder: &Folder, name: &str, days: u64) {
        let file = File::options().write(true).open(folder.path().join(name)).unwrap();
        let at = SystemTime::UNIX_EPOCH + Duration::from_millis(days * DAY_MS);
        file.set_modified(at).unwrap();
    }

    fn left(folder: &Folder) -> Vec<String> {
        let mut names: Vec<String> = folder.list().into_iter().map(|it| it.name).collect();
        names.sort();
        names
    }

    #[test]
    fn the_oldest_goes_when_there_is_too_much() {
        let folder = Folder::fresh();
        for (name, day) in [("old.mcap", 1), ("older.mcap", 0), ("new.mcap", 10)] {
            put_one(&folder, name, Some(day));
        }
        let after = |days: u64| DATED_MS + days * DAY_MS;
        forget(&folder, after(10), (100, 2), &Open::new());
        assert_eq!(left(&folder).len(), 3);
        forget(&folder, after(10), (100, 1), &Open::new());
        assert_eq!(left(&folder), ["new.mcap"], "1.2 MB are more than 1 MB, too");
        forget(&folder, after(20), (5, 1), &Open::new());
        assert!(left(&folder).is_empty());
        let path = folder.path().to_owned();
        drop(folder);
        assert!(!path.exists());
    }

    /// An exercise of years ago, and one that a wrong clock dated ahead.
    #[test]
    fn what_was_sent_is_as_old_as_it_is_here() {
        let folder = Folder::fresh();
        let days = 11_000;
        for (name, frames, here) in [("old.mcap", 1, days - 1), ("ahead.mcap", days, days - 10)] {
            put_one(&folder, name, None);
            let to_ms = DATED_MS + frames * DAY_MS;
            let meta = Recording { name: name.into(), to_ms, ..Recording::default() };
            tell(folder.path(), &Recording { cause: "uploaded".into(), ..meta }).unwrap();
            set_written(&folder, name, here);
        }
        forget(&folder, days * DAY_MS, (5, 100), &Open::new());
        assert_eq!(left(&folder), ["old.mcap"]);
    }

    /// A folder that was there at the start and goes, as a disk that is pulled out.
    #[test]
    fn a_folder_that_fails_later_shows_and_is_tried_again() {
        let (folder, unusable) = (Folder::fresh(), AtomicBool::new(false));
        let path = folder.path().to_owned();
        let mut writer = Writer::new(&folder, (10, 100), &unusable);
        let failing = || unusable.load(Ordering::Relaxed);
        let meta = |name: &str| Recording { name: name.into(), ..Recording::default() };
        writer.prepare();
        let begin = |name: &str| Work::Begin(meta(name), Vec::new());
        writer.handle(begin("a.mcap"));
        assert!(!failing());
        // Its end cannot be written.
        fs::remove_dir_all(&path).unwrap();
        writer.handle(Work::End(meta("a.mcap")));
        assert!(failing());
        writer.handle(begin("b.mcap"));
        assert!(!failing() && folder.has("b.mcap"), "the folder is made");
        fs::remove_dir_all(&path).unwrap();
        fs::write(&path, "no folder").unwrap();
        writer.handle(begin("c.mcap"));
        assert!(failing());
        fs::remove_file(&path).unwrap();
        writer.kept = None;
        writer.handle(Work::Keep(0));
        assert!(!failing(), "each minute it is tried again");
    }

    /// Assumed: the clock starts in 1970 each time, so that names come again, and the disk fails meanwhile.
    #[test]
    fn what_could_not_be_written_changes_no_other() {
        let (folder, unusable) = (Folder::fresh(), AtomicBool::new(false));
        let path = folder.path().to_owned();
        put_one(&folder, "a.mcap", Some(7));
        let old = folder.about("a.mcap");
        let meta = Recording { name: "a.mcap".into(), recording: true, ..Recording::default() };
        let ended = Recording { recording: false, to_ms: 5, ..meta.clone() };
        let mut writer = Writer::new(&folder, (10, 100), &unusable);
        writer.prepare();
        writer.handle(Work::Begin(meta.clone(), Vec::new()));
        assert!(folder.about("a-2.mcap").recording);
        // Its writing fails.
        writer.open.get_mut("a.mcap").unwrap().recorder = None;
        writer.handle(Work::End(ended.clone()));
        let two = folder.about("a-2.mcap");
        assert_eq!((two.recording, two.to_ms), (false, 5), "what could be written is complete");
        assert_eq!(folder.about("a.mcap"), old);
        // It has no file at all.
        let aside = path.with_extension("aside");
        fs::rename(&path, &aside).unwrap();
        fs::write(&path, "no folder").unwrap();
        writer.handle(Work::Begin(meta, Vec::new()));
        fs::remove_file(&path).unwrap();
        fs::rename(&aside, &path).unwrap();
        writer.handle(Work::End(ended));
        assert_eq!(folder.about("a.mcap"), old);
        assert_eq!(left(&folder), ["a-2.mcap", "a.mcap"]);
    }

    /// Assumed: the date steps back by years.
    #[test]
    fn a_date_that_steps_back_stops_no_forgetting() {
        let (folder, unusable) = (Folder::fresh(), AtomicBool::new(false));
        let mut writer = Writer::new(&folder, (5, 100), &unusable);
        let at = |days: u64| DATED_MS + days * DAY_MS;
        writer.handle(Work::Keep(at(5000)));
        put_one(&folder, "a.mcap", Some(1));
        writer.handle(Work::Keep(at(100)));
        assert_eq!(left(&folder), ["a.mcap"], "once a minute");
        writer.kept = writer.kept.and_then(|it| it.checked_sub(KEEP));
        writer.handle(Work::Keep(at(100)));
        assert!(left(&folder).is_empty());
    }

    /// Who has opened a description reads that one to its end.
    #[test]
    fn a_description_is_replaced_whole() {
        let folder = Folder::fresh();
        put_one(&folder, "a.mcap", Some(1));
        let mut opened = File::open(about(folder.path(), "a.mcap")).unwrap();
        let before = fs::read_to_string(about(folder.path(), "a.mcap")).unwrap();
        put_one(&folder, "a.mcap", Some(20_000));
        let mut read = String::new();
        opened.read_to_string(&mut read).unwrap();
        assert_eq!(read, before);
        assert_eq!(folder.about("a.mcap").to_ms, DATED_MS + 20_000 * DAY_MS);
        let beside = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(beside, 2, "nothing is left beside them");
        // One that cannot be written leaves what is there.
        fs::create_dir(about(folder.path(), "a.mcap").with_extension("json.new")).unwrap();
        let meta = Recording { name: "a.mcap".into(), ..Recording::default() };
        assert!(tell(folder.path(), &meta).is_err());
        assert_eq!(folder.about("a.mcap").to_ms, DATED_MS + 20_000 * DAY_MS);
    }

    /// Assumed: a word may be missing, cut off by a full disk, or from a clock that was never set.
    #[test]
    fn a_recording_without_its_word_is_as_old_as_its_file() {
        let folder = Folder::fresh();
        let days = 11_000;
        for (name, age) in [("lost.mcap", 10), ("cut.mcap", 10), ("recent.mcap", 2)] {
            put_one(&folder, name, None);
            set_written(&folder, name, days - age);
        }
        fs::write(about(folder.path(), "cut.mcap"), "{\"name\":\"cut").unwrap();
        for name in ["undated.mcap", "unset.mcap"] {
            put_one(&folder, name, None);
            set_written(&folder, name, 0);
        }
        let unset = Recording { name: "unset.mcap".into(), to_ms: 5000, ..Recording::default() };
        tell(folder.path(), &unset).unwrap();
        assert_eq!(folder.about("recent.mcap").to_ms, (days - 2) * DAY_MS);
        forget(&folder, days * DAY_MS, (20, 100), &Open::new());
        assert_eq!(left(&folder).len(), 5, "none is older than 20 days");
        forget(&folder, days * DAY_MS, (5, 100), &Open::new());
        assert_eq!(left(&folder), ["recent.mcap", "undated.mcap", "unset.mcap"]);
        forget(&folder, days * DAY_MS, (5, 1), &Open::new());
        assert_eq!(left(&folder), ["unset.mcap"], "too much: what has an age goes first");
    }
}
