//! History: each change of each value, then minutes; both are kept for some days. And what alarms
//! did.

use std::collections::HashMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rusqlite::params;
use serde::Serialize;
use tokio::sync::oneshot;
use tokio::time::timeout;
use utoipa::ToSchema;

use super::current::Current;
use super::db::{Db, READ_WAIT, StoreError, open_or_begin_anew};
use super::postgres::{Address, Postgres};
use super::series::{self, Ids, SCHEMA, Sweep};
use super::thin::{self, Rows};
use super::torn::{Hole, Torn};
use super::work::Work;
use crate::monitor::link_series::PREFIX;
use crate::sync::lock;

/// The end of the hub waits so long for PostgreSQL.
const LAST_WAIT: Duration = Duration::from_secs(4);
/// The time until which values are known is stored so often.
const KNOWN_EVERY_MS: u64 = 10_000;
/// A day.
pub const DAY_MS: u64 = 86_400_000;
/// Ranges longer than this are answered in minutes.
pub const RAW_RANGE_MS: u64 = 2 * 3_600_000;

/// Name of a series of a monitor: `Vertical.position`.
pub type Series = String;

/// A series of a monitor.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key {
    /// Id of the monitor.
    pub monitor: String,
    /// Name of the series.
    pub series: Series,
}

/// The history.
#[derive(Debug)]
pub struct History {
    base: Base,
    /// Current values by monitor and series.
    now: HashMap<String, HashMap<Series, Current>>,
    pending: Vec<Row>,
    known_ms: u64,
    known_stored_ms: u64,
    file: Arc<File>,
}

/// How storing in the file goes.
#[derive(Debug, Default)]
struct File {
    failing: AtomicBool,
    lost: AtomicU64,
    ids: Mutex<Ids>,
    torn: Torn,
}

impl File {
    /// The file does not have these rows: what came before them seems to hold there.
    fn lose(&self, rows: &[Row]) {
        self.failing.store(true, Ordering::Relaxed);
        self.lost.fetch_add(rows.len() as u64, Ordering::Relaxed);
        self.torn.lose(rows);
    }
}

/// The database of the history.
#[derive(Clone, Debug)]
pub enum Base {
    /// SQLite, in a file or in memory.
    Sqlite(Db),
    /// A PostgreSQL server.
    Postgres(Postgres),
}

/// A series, since when, its value; `None`: it is not known.
pub type Change = (Series, u64, Option<f64>);

/// A change of an alarm.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct AlarmChange {
    /// Time, ms since 1970.
    pub at_ms: u64,
    /// Id of the alarm.
    pub id: String,
    /// State before the change.
    pub from: String,
    /// State after the change.
    pub to: String,
    /// Whose action it was, if it was one.
    #[schema(required)]
    pub user: Option<String>,
    /// The reason given.
    #[schema(required)]
    pub reason: Option<String>,
}

/// A row to store.
#[derive(Clone, Debug)]
pub enum Row {
    /// A value, or that it is not known.
    Raw(Arc<Key>, u64, Option<f64>),
    /// Mean, least and greatest value from a time on.
    Minute(Arc<Key>, u64, [f64; 3]),
    /// From here on there are no minutes.
    Gap(Arc<Key>, u64),
    /// Values are known until this time.
    Known(u64),
}

impl History {
    /// Opens it in a folder, or in memory.
    pub fn open(folder: Option<&Path>) -> Result<Self, StoreError> {
        let db = Db::new("history", open_or_begin_anew(folder, "history.db", SCHEMA)?)?;
        db.post(|db| {
            if let Err(error) = series::resume(db) {
                tracing::warn!(%error, "the end of the last history is not marked");
            }
        });
        Ok(Self::of(Base::Sqlite(db)))
    }

    /// In the place of a file that the disk does not let be read: until the hub is started again, nothing is stored.
    pub fn unread() -> Self {
        let history = Self::of(Base::Sqlite(Db::unread()));
        history.file.failing.store(true, Ordering::Relaxed);
        history
    }

    /// Opens the history in PostgreSQL.
    pub fn open_postgres(address: Address) -> Result<Self, StoreError> {
        Ok(Self::of(Base::Postgres(Postgres::open(address)?)))
    }

    fn of(base: Base) -> Self {
        let (now, pending, file) = (HashMap::new(), Vec::new(), Arc::default());
        Self { base, now, pending, known_ms: 0, known_stored_ms: 0, file }
    }

    /// Where it is, to read from.
    pub fn base(&self) -> Base {
        self.base.clone()
    }

    /// Whether it cannot be stored.
    pub fn is_failing(&self) -> bool {
        match &self.base {
            Base::Sqlite(_) => self.file.failing.load(Ordering::Relaxed),
            Base::Postgres(postgres) => postgres.is_failing(),
        }
    }

    /// Values that were given up, as the disk took none or the server was away for too long.
    pub fn given_up(&self) -> u64 {
        match &self.base {
            Base::Sqlite(_) => self.file.lost.load(Ordering::Relaxed),
            Base::Postgres(postgres) => postgres.lost(),
        }
    }

    /// A value of a series is known; `false`: it comes too soon after the last change, and has to
    /// be noted again if it stays.
    pub fn note(&mut self, at_ms: u64, monitor: &str, series: &str, value: f64) -> bool {
        self.known_ms = at_ms;
        let pending = &mut self.pending;
        if let Some(current) = self.now.get_mut(monitor).and_then(|it| it.get_mut(series)) {
            if let Some(noted) = current.note(at_ms, value, pending) {
                return noted;
            }
            let end_ms = current.until_ms();
            current.clone().lose(end_ms, pending);
        }
        let key = Arc::new(Key { monitor: monitor.to_owned(), series: series.to_owned() });
        pending.push(Row::Raw(key.clone(), at_ms, Some(value)));
        let current = Current::begin(key, at_ms, value);
        self.now.entry(monitor.to_owned()).or_default().insert(series.to_owned(), current);
        true
    }

    /// A value of a series is not known any more.
    pub fn lost_series(&mut self, at_ms: u64, monitor: &str, series: &str) {
        self.known_ms = at_ms;
        if let Some(current) = self.now.get_mut(monitor).and_then(|all| all.remove(series)) {
            current.lose(at_ms, &mut self.pending);
        }
    }

    /// The values of a monitor are not known any more.
    pub fn lost(&mut self, at_ms: u64, monitor: &str) {
        self.lose(at_ms, monitor, |series| !series.starts_with(PREFIX));
    }

    /// The figures of its link are not known any more.
    pub fn lost_link(&mut self, at_ms: u64, monitor: &str) {
        self.lose(at_ms, monitor, |series| series.starts_with(PREFIX));
    }

    fn lose(&mut self, at_ms: u64, monitor: &str, which: impl Fn(&str) -> bool) {
        let Some(all) = self.now.get_mut(monitor) else { return };
        for (_, current) in all.extract_if(|series, _| which(series)) {
            current.lose(at_ms, &mut self.pending);
        }
    }

    /// Stores what has come together; `false`: the disk takes nothing, it is dropped.
    pub fn flush(&mut self) -> bool {
        self.store(None)
    }

    /// As [`History::flush`]; the base can be read when what was noted until now is stored.
    pub fn flushed(&mut self) -> impl Future<Output = Base> + Send + use<> {
        let (done, stored) = oneshot::channel();
        self.store(Some(done));
        let base = self.base();
        async move {
            // PostgreSQL may be away, and a disk may hang: what is stored already can be read.
            _ = timeout(READ_WAIT, stored).await;
            base
        }
    }

    /// Stores everything, in the file itself; for PostgreSQL it waits a few seconds.
    pub fn settle(&mut self) -> impl Future<Output = Result<(), StoreError>> + Send + use<> {
        self.flush();
        let base = self.base();
        async move {
            match base {
                Base::Sqlite(db) => db.checkpoint().await,
                Base::Postgres(postgres) => {
                    let (done, stored) = oneshot::channel();
                    let taken = postgres.post(Work::Stored(done));
                    if !taken || !matches!(timeout(LAST_WAIT, stored).await, Ok(Ok(()))) {
                        tracing::warn!("PostgreSQL has not taken the end of the history");
                    }
                    Ok(())
                }
            }
        }
    }

    /// What the base lacks is not known there; what is current is stored again. Not before it takes rows.
    fn close_gaps(&mut self) {
        if self.is_failing() {
            return;
        }
        let torn = match &self.base {
            Base::Sqlite(_) => self.file.torn.take(),
            Base::Postgres(postgres) => postgres.torn(),
        };
        for (key, Hole { raw_ms, minute_ms }) in torn {
            self.pending.extend(minute_ms.map(|at_ms| Row::Gap(key.clone(), at_ms)));
            self.pending.extend(raw_ms.map(|at_ms| Row::Raw(key.clone(), at_ms, None)));
            let current = self.now.get_mut(&key.monitor).and_then(|it| it.get_mut(&key.series));
            if let Some(current) = current {
                current.repeat(raw_ms.unwrap_or(0), &mut self.pending);
            }
        }
    }

    fn store(&mut self, done: Option<oneshot::Sender<()>>) -> bool {
        self.close_gaps();
        if self.known_ms.abs_diff(self.known_stored_ms) >= KNOWN_EVERY_MS {
            self.known_stored_ms = self.known_ms;
            self.pending.push(Row::Known(self.known_ms));
        }
        let rows = std::mem::take(&mut self.pending);
        if rows.is_empty() && done.is_none() {
            return true;
        }
        match &self.base {
            Base::Postgres(_) if rows.is_empty() => true,
            Base::Postgres(postgres) => postgres.post(Work::Rows(rows)),
            Base::Sqlite(db) => {
                let (file, rows) = (self.file.clone(), Arc::new(rows));
                let own = rows.clone();
                let taken = db.post(move |db| {
                    let stored = series::store(db, &mut lock(&file.ids), &own);
                    match stored {
                        Ok(()) => file.failing.store(false, Ordering::Relaxed),
                        Err(error) => {
                            lock(&file.ids).clear();
                            file.lose(&own);
                            tracing::warn!(%error, rows = own.len(), "history is not stored");
                        }
                    }
                    drop(done);
                });
                if !taken {
                    self.file.lose(&rows);
                }
                taken
            }
        }
    }

    /// Forgets what is too old.
    pub fn forget(&self, now_ms: u64, raw_days: u32, minute_days: u32) {
        let before = |days: u32| signed(now_ms.saturating_sub(u64::from(days) * DAY_MS));
        let sweep = Sweep { raw: before(raw_days), minute: before(minute_days), done: 0 };
        match &self.base {
            Base::Sqlite(db) => series::forget(db, sweep),
            Base::Postgres(postgres) => postgres.post(Work::Forget(sweep)),
        };
    }

    /// Stores a change of an alarm.
    pub fn alarm(
        &self,
        at_ms: u64,
        alarm: [String; 4],
        user: Option<String>,
        reason: Option<String>,
    ) {
        let [id, monitor, before, after] = alarm;
        let db = match &self.base {
            Base::Sqlite(db) => db,
            Base::Postgres(postgres) => {
                let known_by = random_id();
                let texts =
                    [Some(id), Some(monitor), Some(before), Some(after), user, reason, known_by];
                let texts = texts.map(|text| text.map(storable));
                postgres.post(Work::Alarm(at_ms, Box::new(texts)));
                return;
            }
        };
        let file = self.file.clone();
        let taken = db.post(move |db| {
            let row = params![signed(at_ms), id, monitor, before, after, user, reason];
            if let Err(error) = db.execute("INSERT INTO alarm VALUES (?1,?2,?3,?4,?5,?6,?7)", row) {
                file.lost.fetch_add(1, Ordering::Relaxed);
                tracing::warn!(%error, "history of alarms is not stored");
            }
        });
        if !taken {
            self.file.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Base {
    /// The values of a series between two times: each change, or spans of `resolution_ms`; of more
    /// than `points` changes the extreme ones.
    pub async fn values(
        &self,
        monitor: &str,
        series: &str,
        range: (u64, u64),
        resolution_ms: Option<u64>,
        points: usize,
    ) -> Result<Rows, StoreError> {
        let (monitor, series) = (monitor.to_owned(), series.to_owned());
        let Some(resolution_ms) = resolution_ms else {
            let all = match self {
                Self::Postgres(postgres) => postgres.changes_of(&monitor, &series, range).await?,
                Self::Sqlite(db) => {
                    db.read(move |db| series::changes_of(db, &monitor, &series, range)).await?
                }
            };
            return Ok(Rows::Changes(thin::changes(all, points)));
        };
        let pieces = match self {
            Self::Postgres(postgres) => postgres.minutes_of(&monitor, &series, range).await?,
            Self::Sqlite(db) => {
                db.read(move |db| series::minutes_of(db, &monitor, &series, range)).await?
            }
        };
        Ok(Rows::Spans(thin::spans(pieces.into_iter(), range, resolution_ms)))
    }

    /// What alarms did, the latest first.
    pub async fn alarms(
        &self,
        monitor: Option<String>,
        range: (u64, u64),
        limit: u32,
    ) -> Result<Vec<AlarmChange>, StoreError> {
        match self {
            Self::Postgres(postgres) => postgres.alarms(monitor.as_deref(), range, limit).await,
            Self::Sqlite(db) => {
                db.read(move |db| series::alarms(db, monitor.as_deref(), range, limit)).await
            }
        }
    }

    /// All series of a monitor: what held at the beginning of a range, or each change after that.
    pub async fn changes(
        &self,
        monitor: &str,
        range: (u64, u64),
        held: bool,
    ) -> Result<Vec<Change>, StoreError> {
        match self {
            Self::Postgres(postgres) => postgres.changes(monitor, range, held).await,
            Self::Sqlite(db) => {
                let monitor = monitor.to_owned();
                db.read(move |db| series::changes(db, &monitor, range, held)).await
            }
        }
    }
}

/// A text as PostgreSQL stores it: without zeros.
fn storable(text: String) -> String {
    text.replace('\0', "\u{fffd}")
}

/// By this PostgreSQL knows a row that comes twice; `None`: the system has no random numbers.
fn random_id() -> Option<String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).ok()?;
    Some(format!("{:032x}", u128::from_ne_bytes(bytes)))
}

/// A number as databases store it.
pub fn signed(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::store::thin::MINUTE_MS;

    async fn raw(history: &mut History) -> serde_json::Value {
        let base = history.flushed().await;
        json!(base.values("M1", "a", (0, u64::MAX), None, 100).await.unwrap())
    }

    async fn spans(
        history: &mut History,
        series: &str,
        to_ms: u64,
        resolution_ms: u64,
    ) -> Vec<thin::Span> {
        let base = history.flushed().await;
        match base.values("M1", series, (0, to_ms), Some(resolution_ms), 100).await.unwrap() {
            Rows::Spans(spans) => spans,
            Rows::Changes(_) => panic!("spans were asked for"),
        }
    }

    #[tokio::test]
    async fn a_value_that_is_left_out_is_a_gap_and_one_that_comes_too_soon_is_asked_for_again() {
        let mut history = History::open(None).unwrap();
        assert!(history.note(1000, "M1", "a", 5.0));
        assert!(!history.note(1100, "M1", "a", 6.0), "too soon");
        assert!(history.note(1300, "M1", "a", 6.0));
        history.lost_series(2000, "M1", "a");
        history.lost_series(2100, "M1", "a");
        assert!(history.note(9000, "M1", "a", 7.0));
        let changes = json!([[1000, 5.0], [1300, 6.0], [2000, null], [9000, 7.0]]);
        assert_eq!(raw(&mut history).await, changes);
    }

    /// Assumed: the disk takes nothing for a while. Until when a value held before that is not known.
    #[tokio::test]
    async fn what_the_disk_did_not_take_is_a_gap_and_no_value_that_held() {
        let mut history = History::open(None).unwrap();
        let Base::Sqlite(db) = history.base() else { panic!("it is a file") };
        let change = async |sql: &'static str| db.call(|db| db.execute_batch(sql)).await.unwrap();
        for series in ["a", "b", "c"] {
            history.note(1000, "M1", series, 1.0);
        }
        history.flushed().await;
        change("ALTER TABLE raw RENAME TO away").await;
        history.note(2000, "M1", "a", 2.0);
        history.note(2000, "M1", "b", 2.0);
        history.flushed().await;
        assert!(history.is_failing());
        history.note(3000, "M1", "a", 3.0);
        history.lost_series(3000, "M1", "b");
        history.flushed().await;
        let lost = history.given_up();
        change("ALTER TABLE away RENAME TO raw").await;
        history.note(4000, "M1", "c", 4.0);
        history.flushed().await;
        assert_eq!((history.is_failing(), history.given_up()), (false, lost));
        history.flushed().await;
        let base = history.base();
        let of = async |series| {
            json!(base.values("M1", series, (0, u64::MAX), None, 100).await.unwrap())
        };
        assert_eq!(of("a").await, json!([[1000, 1.0], [2000, null], [3000, 3.0]]));
        assert_eq!(of("b").await, json!([[1000, 1.0], [2000, null]]));
        assert_eq!(of("c").await, json!([[1000, 1.0], [4000, 4.0]]), "nothing of it was lost");
    }

    #[tokio::test]
    async fn minutes_that_are_lost_are_a_gap() {
        let mut history = History::open(None).unwrap();
        let Base::Sqlite(db) = history.base() else { panic!("it is a file") };
        let change = async |sql: &'static str| db.call(|db| db.execute_batch(sql)).await.unwrap();
        for second in 0..=360_u64 {
            let value = if (150..=270).contains(&second) { second as f64 } else { 1.0 };
            history.note(second * 1000, "M1", "a", value);
            match second {
                // The constant of the first minutes is stored, what came after it is not.
                130 => _ = history.flushed().await,
                131 => change("ALTER TABLE minute RENAME TO away").await,
                250 => {
                    history.flushed().await;
                    change("ALTER TABLE away RENAME TO minute").await;
                    history.note(251_000, "M1", "b", 1.0);
                    history.flushed().await;
                }
                _ => {}
            }
        }
        let all = spans(&mut history, "a", 360_000, MINUTE_MS).await;
        let minutes: Vec<_> = all.iter().map(|it| it.0).collect();
        assert_eq!(minutes, [0, 60_000, 240_000, 300_000], "{all:?}");
    }

    #[tokio::test]
    async fn what_a_full_queue_refuses_is_counted() {
        let mut history = History::open(None).unwrap();
        let Base::Sqlite(db) = history.base() else { panic!("it is a file") };
        let go = db.hang();
        while db.post(|_| {}) {}
        history.note(1000, "M1", "a", 1.0);
        assert!(!history.flush());
        history.alarm(1000, ["M1/x", "M1", "normal", "unack"].map(str::to_owned), None, None);
        assert_eq!(history.given_up(), 2);
        go.send(()).unwrap();
        while db.call(|_| Ok(())).await.is_err() {}
        history.note(2000, "M1", "b", 2.0);
        history.flushed().await;
        assert_eq!(raw(&mut history).await, json!([[1000, 1.0]]), "it is stored all the same");
    }

    #[test]
    fn each_row_of_an_alarm_is_known_by_an_id_of_its_own() {
        let (one, other) = (random_id().unwrap(), random_id().unwrap());
        assert!(one != other && one.len() == 32, "{one} {other}");
    }

    #[test]
    fn a_text_without_zeros_stays_as_it_is() {
        assert_eq!(["a\0b", "а б"].map(|it| storable(it.into())), ["a\u{fffd}b", "а б"]);
    }

    #[tokio::test]
    async fn changes_are_noted_and_minutes_made() {
        let mut history = History::open(None).unwrap();
        let start = 600_000;
        for second in 0..=120_u64 {
            let value = if second < 30 { 10.0 } else { 20.0 };
            history.note(start + second * 1000, "M1", "a", value);
        }
        assert_eq!(raw(&mut history).await, json!([[600_000, 10.0], [630_000, 20.0]]));
        let minutes = spans(&mut history, "a", 720_000, MINUTE_MS).await;
        assert_eq!(minutes, [(600_000, 15.0, 10.0, 20.0), (660_000, 20.0, 20.0, 20.0)]);
        let base = history.base();
        let held = base.values("M1", "a", (640_000, 650_000), None, 100).await.unwrap();
        assert_eq!(held, Rows::Changes(vec![(630_000, Some(20.0))]), "what holds is given as well");
    }

    #[tokio::test]
    async fn a_gap_is_a_gap_and_old_values_go() {
        let mut history = History::open(None).unwrap();
        history.note(1000, "M1", "a", 1.0);
        history.lost(2000, "M1");
        history.note(DAY_MS * 3, "M1", "a", 1.0);
        assert_eq!(raw(&mut history).await, json!([[1000, 1.0], [2000, null], [DAY_MS * 3, 1.0]]));
        let known = spans(&mut history, "a", DAY_MS * 4, MINUTE_MS).await;
        assert_eq!(known, [(0, 1.0, 1.0, 1.0)]);
        history.forget(DAY_MS * 3, 1, 1);
        assert_eq!(raw(&mut history).await, json!([[DAY_MS * 3, 1.0]]));
    }

    #[tokio::test]
    async fn a_constant_is_written_seldom_and_told_from_a_gap() {
        let mut history = History::open(None).unwrap();
        let day = (0..DAY_MS).step_by(5000);
        for at_ms in day.clone().filter(|at_ms| !(40_000_000..50_000_000).contains(at_ms)) {
            history.note(at_ms, "M1", "a", 3.0);
        }
        let rows = |which: fn(&Row) -> bool| history.pending.iter().filter(|it| which(it)).count();
        assert!(rows(|it| matches!(it, Row::Minute(..))) <= 26, "one an hour");
        assert!(
            rows(|it| matches!(it, Row::Raw(..))) <= 28,
            "so that what is kept for days shows it"
        );
        let all = spans(&mut history, "a", DAY_MS, MINUTE_MS).await;
        let gap = all.windows(2).find(|it| it[1].0 - it[0].0 > MINUTE_MS).unwrap();
        assert_eq!((gap[0].0, gap[1].0), (39_960_000, 49_980_000), "the gap shows to the minute");
        assert_eq!(all.len(), 1440 - (49_980_000 - 39_960_000) / 60_000 + 1);
    }

    #[tokio::test]
    async fn a_month_in_600_points_has_the_peak_of_a_second() {
        let mut history = History::open(None).unwrap();
        let month = 30 * DAY_MS;
        for at_ms in (0..month).step_by(30_000) {
            history.note(at_ms, "M1", "a", (at_ms / 30_000 % 3) as f64);
            if at_ms == 1_234_560_000 {
                history.note(at_ms + 1000, "M1", "a", 99.0);
                history.note(at_ms + 2000, "M1", "a", -99.0);
                history.note(at_ms + 3000, "M1", "a", 1.0);
            }
        }
        let resolution_ms = thin::resolution_ms((0, month), 600);
        let all = spans(&mut history, "a", month, resolution_ms).await;
        assert!(all.len() <= 600, "{}", all.len());
        let least = all.iter().map(|it| it.2).fold(f64::INFINITY, f64::min);
        let most = all.iter().map(|it| it.3).fold(f64::NEG_INFINITY, f64::max);
        assert_eq!((least, most), (-99.0, 99.0));
    }

    #[tokio::test]
    async fn figures_of_a_link_are_thinned_and_trouble_is_not() {
        let mut history = History::open(None).unwrap();
        for second in 0..36_000_u64 {
            let at_ms = second * 1000;
            let jitter = (second * 7 % 5) as f64;
            history.note(at_ms, "M1", "Link.sent", 50.0 + jitter);
            history.note(at_ms, "M1", "Link.rtt_ms", 3.0 + jitter);
            history.note(at_ms, "M1", "Link.timeouts", f64::from(u8::from(second == 5000)));
        }
        let rows = |series: &str| {
            let of = |it: &&Row| match it {
                Row::Raw(key, ..) | Row::Minute(key, ..) | Row::Gap(key, ..) => {
                    key.series == series
                }
                Row::Known(_) => false,
            };
            history.pending.iter().filter(of).count()
        };
        assert!(rows("Link.sent") <= 22, "what varies by a tenth is constant");
        assert!(rows("Link.rtt_ms") <= 3600 + 62, "every ten seconds, and minutes by ten");
        let timeouts = spans(&mut history, "Link.timeouts", 36_000_000, 600_000).await;
        assert!(timeouts.iter().any(|it| it.3 > 0.5), "{timeouts:?}");
    }

    /// Idle: 40 fields stay, the temperature goes up and down, the link's figures jitter.
    #[tokio::test]
    async fn an_idle_monitor_takes_less_than_30_megabytes_in_400_days() {
        let folder = std::env::temp_dir().join(format!("lafet-idle-{}", std::process::id()));
        let mut history = History::open(Some(&folder)).unwrap();
        let names: Vec<String> = (0..40).map(|it| format!("Subsystem{it}.field")).collect();
        for second in (0..86_400_u64).step_by(10) {
            let (at_ms, jitter) = (second * 1000, (second * 7919 % 101) as f64);
            for (index, name) in names.iter().enumerate() {
                history.note(at_ms, "M1", name, index as f64 * 100.0);
            }
            let temperature = (second as f64 / 6000.0).sin() * 50.0;
            history.note(at_ms, "M1", "Climatics.temperature", temperature.round());
            for (name, of) in [("sent", 9.0), ("received", 9.0), ("rtt_ms", 2.0)] {
                history.note(at_ms, "M1", &format!("{PREFIX}{name}"), of + jitter / 60.0);
            }
            for name in ["retries", "timeouts", "errors"] {
                history.note(at_ms, "M1", &format!("{PREFIX}{name}"), 0.0);
            }
            if second % 600 == 0 {
                history.flush();
            }
        }
        let base = history.flushed().await;
        let Base::Sqlite(db) = base else { panic!("it is a file") };
        let bytes = async |table: &'static str| {
            let query = "SELECT SUM(pgsize) FROM dbstat WHERE name = ?1";
            db.read(move |db| db.query_row(query, [table], |row| row.get::<_, f64>(0))).await
        };
        let (raw, minute) = (bytes("raw").await.unwrap(), bytes("minute").await.unwrap());
        let all = raw * 7.0 + minute * 400.0;
        println!("{:.1} MB: {raw} + {minute} bytes a day", all / 1e6);
        assert!(all <= 30e6, "{all} bytes: {raw} of changes, {minute} of minutes a day");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[tokio::test]
    async fn a_clock_that_is_put_back_does_not_stop_the_history() {
        let mut history = History::open(None).unwrap();
        for (at_ms, value) in [(DAY_MS * 30, 1.0), (DAY_MS * 30 + 1000, 2.0), (DAY_MS, 3.0)] {
            history.note(at_ms, "M1", "a", value);
        }
        history.note(DAY_MS + 1000, "M1", "a", 4.0);
        let values = raw(&mut history).await.to_string();
        assert!(values.contains("3.0") && values.contains("4.0"), "{values}");
    }

    #[tokio::test]
    async fn alarms_are_listed_the_latest_first() {
        let history = History::open(None).unwrap();
        for (at_ms, after) in [(1, "unack"), (2, "ack")] {
            let alarm = ["M1/x", "M1", "normal", after].map(str::to_owned);
            history.alarm(at_ms, alarm, None, None);
        }
        let list = history.base().alarms(Some("M1".into()), (0, 9), 10).await.unwrap();
        assert_eq!((list[0].to.as_str(), list.len()), ("ack", 2));
    }
}
