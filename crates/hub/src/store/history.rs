//! History: each change of each value, then minutes; both are kept for some days. And what alarms
//! did.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rusqlite::{Connection, params};
use serde_json::{Value, json};

use super::db::{Db, StoreError, open_or_begin_anew};
use super::postgres::{Address, Postgres, Work};
use crate::link_series::PREFIX;

/// A value is not noted more often.
const RAW_MS: u64 = 200;
/// A minute.
const MINUTE_MS: u64 = 60_000;
/// A day.
pub const DAY_MS: u64 = 86_400_000;
/// Ranges longer than this are answered in minutes.
pub const RAW_RANGE_MS: u64 = 2 * 3_600_000;

const SCHEMA: &str = "
CREATE TABLE IF NOT EXISTS series (
  id INTEGER PRIMARY KEY, monitor TEXT NOT NULL, name TEXT NOT NULL, UNIQUE (monitor, name)
) STRICT;
CREATE TABLE IF NOT EXISTS raw (
  series INTEGER NOT NULL REFERENCES series, t INTEGER NOT NULL, value REAL,
  PRIMARY KEY (series, t)
) STRICT, WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS minute (
  series INTEGER NOT NULL REFERENCES series, t INTEGER NOT NULL,
  mean REAL NOT NULL, least REAL NOT NULL, most REAL NOT NULL, PRIMARY KEY (series, t)
) STRICT, WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS alarm (
  at_ms INTEGER NOT NULL, id TEXT NOT NULL, monitor TEXT NOT NULL, before TEXT NOT NULL,
  after TEXT NOT NULL, user TEXT, reason TEXT
) STRICT;
CREATE INDEX IF NOT EXISTS alarm_by_time ON alarm (at_ms);
PRAGMA synchronous = NORMAL;";

/// Name of a series of a monitor: `Vertical.position`.
pub type Series = String;

/// The history.
#[derive(Debug)]
pub struct History {
    base: Base,
    now: HashMap<(String, Series), Current>,
    pending: Vec<Row>,
    file: Arc<File>,
}

/// How storing in the file goes.
#[derive(Debug, Default)]
struct File {
    failing: AtomicBool,
    lost: AtomicU64,
}

/// What a series is at.
#[derive(Clone, Copy, Debug)]
struct Current {
    value: f64,
    since_ms: u64,
    noted_ms: u64,
    minute: Minute,
}

/// A minute that is not over.
#[derive(Clone, Copy, Debug)]
struct Minute {
    start_ms: u64,
    until_ms: u64,
    sum: f64,
    least: f64,
    most: f64,
}

/// Where the history is.
#[derive(Clone, Debug)]
pub enum Base {
    /// A file, or memory.
    Sqlite(Db),
    /// A server.
    Postgres(Postgres),
}

/// A series, since when, its value; `None`: it is not known.
pub type Change = (Series, u64, Option<f64>);

/// Something to store.
#[derive(Clone, Debug)]
pub enum Row {
    Raw(String, Series, u64, Option<f64>),
    Minute(String, Series, u64, [f64; 3]),
}

impl Minute {
    fn begin(at_ms: u64, value: f64) -> Self {
        let start_ms = at_ms - at_ms % MINUTE_MS;
        Self { start_ms, until_ms: at_ms, sum: 0.0, least: value, most: value }
    }

    /// The value holds until a time within the minute.
    fn hold(&mut self, value: f64, until_ms: u64) {
        let for_ms = until_ms.saturating_sub(self.until_ms);
        self.sum += value * for_ms as f64;
        self.until_ms += for_ms;
        self.least = self.least.min(value);
        self.most = self.most.max(value);
    }

    fn figures(&self, began_ms: u64, value: f64) -> [f64; 3] {
        let over_ms = self.until_ms.saturating_sub(began_ms.max(self.start_ms));
        let mean = if over_ms == 0 { value } else { self.sum / over_ms as f64 };
        [mean.clamp(self.least, self.most), self.least, self.most]
    }
}

impl History {
    /// Opens it in a folder, or in memory.
    pub fn open(folder: Option<&Path>) -> Result<Self, StoreError> {
        let db = Db::new("history", open_or_begin_anew(folder, "history.db", SCHEMA)?)?;
        Ok(Self::of(Base::Sqlite(db)))
    }

    /// Opens it in PostgreSQL.
    pub fn open_postgres(address: Address) -> Result<Self, StoreError> {
        Ok(Self::of(Base::Postgres(Postgres::open(address)?)))
    }

    fn of(base: Base) -> Self {
        Self { base, now: HashMap::new(), pending: Vec::new(), file: Arc::default() }
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

    /// A value of a series is known.
    pub fn note(&mut self, at_ms: u64, monitor: &str, series: &str, value: f64) {
        let key = (monitor.to_owned(), series.to_owned());
        let Some(current) = self.now.get_mut(&key) else {
            let minute = Minute::begin(at_ms, value);
            let current = Current { value, since_ms: at_ms, noted_ms: at_ms, minute };
            self.now.insert(key.clone(), current);
            return self.pending.push(Row::Raw(key.0, key.1, at_ms, Some(value)));
        };
        let old = current.value;
        let end_ms = current.minute.start_ms + MINUTE_MS;
        if at_ms >= end_ms {
            current.minute.hold(old, end_ms);
            let figures = current.minute.figures(current.since_ms, old);
            self.pending.push(Row::Minute(
                key.0.clone(),
                key.1.clone(),
                current.minute.start_ms,
                figures,
            ));
            current.minute = Minute::begin(at_ms, old);
            current.since_ms = current.minute.start_ms;
            current.minute.until_ms = current.minute.start_ms;
        }
        current.minute.hold(old, at_ms);
        current.minute.least = current.minute.least.min(value);
        current.minute.most = current.minute.most.max(value);
        if (value - old).abs() > f64::EPSILON && at_ms >= current.noted_ms + RAW_MS {
            current.value = value;
            current.noted_ms = at_ms;
            self.pending.push(Row::Raw(key.0, key.1, at_ms, Some(value)));
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
        let gone = self.now.keys().filter(|(of, series)| of == monitor && which(series));
        let gone: Vec<_> = gone.cloned().collect();
        for key in gone {
            self.now.remove(&key);
            self.pending.push(Row::Raw(key.0, key.1, at_ms, None));
        }
    }

    /// Stores what has come together; `false`: the disk takes nothing, it is dropped.
    pub fn flush(&mut self) -> bool {
        let rows = std::mem::take(&mut self.pending);
        if rows.is_empty() {
            return true;
        }
        match &self.base {
            Base::Postgres(postgres) => postgres.post(Work::Rows(rows)),
            Base::Sqlite(db) => {
                let file = self.file.clone();
                db.post(move |db| {
                    let stored = store(db, &rows);
                    file.failing.store(stored.is_err(), Ordering::Relaxed);
                    if let Err(error) = stored {
                        file.lost.fetch_add(rows.len() as u64, Ordering::Relaxed);
                        tracing::warn!(%error, rows = rows.len(), "history is not stored");
                    }
                })
            }
        }
    }

    /// Forgets what is too old.
    pub fn forget(&self, now_ms: u64, raw_days: u32, minute_days: u32) {
        let before = |days: u32| signed(now_ms.saturating_sub(u64::from(days) * DAY_MS));
        let (raw, minute) = (before(raw_days), before(minute_days));
        let db = match &self.base {
            Base::Sqlite(db) => db,
            Base::Postgres(postgres) => {
                postgres.post(Work::Forget(raw, minute));
                return;
            }
        };
        db.post(move |db| {
            let forgotten = db
                .execute("DELETE FROM raw WHERE t < ?1", [raw])
                .and_then(|_| db.execute("DELETE FROM minute WHERE t < ?1", [minute]))
                .and_then(|_| db.execute("DELETE FROM alarm WHERE at_ms < ?1", [minute]));
            if let Err(error) = forgotten {
                tracing::warn!(%error, "old history is not removed");
            }
        });
    }

    /// What an alarm did.
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
                let texts = [Some(id), Some(monitor), Some(before), Some(after), user, reason];
                postgres.post(Work::Alarm(at_ms, Box::new(texts)));
                return;
            }
        };
        db.post(move |db| {
            let row = params![signed(at_ms), id, monitor, before, after, user, reason];
            if let Err(error) = db.execute("INSERT INTO alarm VALUES (?1,?2,?3,?4,?5,?6,?7)", row) {
                tracing::warn!(%error, "history of alarms is not stored");
            }
        });
    }
}

fn store(db: &mut Connection, rows: &[Row]) -> Result<(), rusqlite::Error> {
    let transaction = db.transaction()?;
    for row in rows {
        let (Row::Raw(monitor, series, ..) | Row::Minute(monitor, series, ..)) = row;
        transaction
            .prepare_cached("INSERT OR IGNORE INTO series (monitor, name) VALUES (?1, ?2)")?
            .execute([monitor, series])?;
        let id: i64 = transaction
            .prepare_cached("SELECT id FROM series WHERE monitor = ?1 AND name = ?2")?
            .query_row([monitor, series], |row| row.get(0))?;
        match row {
            Row::Raw(_, _, t, value) => transaction
                .prepare_cached("INSERT OR REPLACE INTO raw VALUES (?1, ?2, ?3)")?
                .execute(params![id, signed(*t), value])?,
            Row::Minute(_, _, t, [mean, least, most]) => transaction
                .prepare_cached("INSERT OR REPLACE INTO minute VALUES (?1, ?2, ?3, ?4, ?5)")?
                .execute(params![id, signed(*t), mean, least, most])?,
        };
    }
    transaction.commit()
}

impl Base {
    /// The values of a series between two times; `minutes` instead of each change. Of more than
    /// `points`, every so many are given.
    pub async fn values(
        &self,
        monitor: &str,
        series: &str,
        range: (u64, u64),
        minutes: bool,
        points: usize,
    ) -> Result<Vec<Vec<Value>>, StoreError> {
        let rows = match self {
            Self::Postgres(postgres) => postgres.values(monitor, series, range, minutes).await?,
            Self::Sqlite(db) => {
                let (monitor, series) = (monitor.to_owned(), series.to_owned());
                db.call(move |db| values(db, &monitor, &series, range, minutes)).await?
            }
        };
        let step = rows.len().div_ceil(points.max(1)).max(1);
        Ok(rows.into_iter().step_by(step).collect())
    }

    /// What alarms did, the latest first.
    pub async fn alarms(
        &self,
        monitor: Option<String>,
        range: (u64, u64),
        limit: u32,
    ) -> Result<Vec<Value>, StoreError> {
        match self {
            Self::Postgres(postgres) => postgres.alarms(monitor.as_deref(), range, limit).await,
            Self::Sqlite(db) => {
                db.call(move |db| alarms(db, monitor.as_deref(), range, limit)).await
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
                db.call(move |db| changes(db, &monitor, range, held)).await
            }
        }
    }
}

fn changes(
    db: &Connection,
    monitor: &str,
    (from_ms, to_ms): (u64, u64),
    held: bool,
) -> Result<Vec<Change>, rusqlite::Error> {
    // SQLite gives the other columns of the row that has the greatest one.
    let query = if held {
        "SELECT name, MAX(t), value FROM raw JOIN series ON series.id = series
         WHERE monitor = ?1 AND t <= ?2 AND ?3 >= ?2 GROUP BY name"
    } else {
        "SELECT name, t, value FROM raw JOIN series ON series.id = series
         WHERE monitor = ?1 AND t > ?2 AND t <= ?3 ORDER BY t"
    };
    let mut query = db.prepare_cached(query)?;
    let row = |row: &rusqlite::Row<'_>| {
        let at: i64 = row.get(1)?;
        Ok((row.get(0)?, at.cast_unsigned(), row.get(2)?))
    };
    query.query_map(params![monitor, signed(from_ms), signed(to_ms)], row)?.collect()
}

fn values(
    db: &Connection,
    monitor: &str,
    series: &str,
    (from_ms, to_ms): (u64, u64),
    minutes: bool,
) -> Result<Vec<Vec<Value>>, rusqlite::Error> {
    let query = if minutes {
        "SELECT t, mean, least, most FROM minute JOIN series ON series.id = series
         WHERE monitor = ?1 AND name = ?2 AND t BETWEEN ?3 AND ?4 ORDER BY t"
    } else {
        // With the value that held when the range began.
        "SELECT t, value FROM raw JOIN series ON series.id = series
         WHERE monitor = ?1 AND name = ?2 AND t <= ?4 AND t >= COALESCE(
           (SELECT MAX(t) FROM raw AS before WHERE before.series = raw.series AND t <= ?3), ?3)
         ORDER BY t"
    };
    let columns = if minutes { 4 } else { 2 };
    let mut query = db.prepare_cached(query)?;
    let rows =
        query.query_map(params![monitor, series, signed(from_ms), signed(to_ms)], |row| {
            let one = |index| -> Result<Value, rusqlite::Error> {
                Ok(match index {
                    0 => json!(row.get::<_, i64>(0)?),
                    index => json!(row.get::<_, Option<f64>>(index)?),
                })
            };
            (0..columns).map(one).collect::<Result<Vec<Value>, _>>()
        })?;
    rows.collect()
}

fn alarms(
    db: &Connection,
    monitor: Option<&str>,
    (from_ms, to_ms): (u64, u64),
    limit: u32,
) -> Result<Vec<Value>, rusqlite::Error> {
    let mut query = db.prepare_cached(
        "SELECT at_ms, id, before, after, user, reason FROM alarm
         WHERE (?1 IS NULL OR monitor = ?1) AND at_ms BETWEEN ?2 AND ?3
         ORDER BY at_ms DESC, rowid DESC LIMIT ?4",
    )?;
    query
        .query_map(params![monitor, signed(from_ms), signed(to_ms), limit], |row| {
            let text = |index| row.get::<_, Option<String>>(index);
            Ok(json!({
                "at_ms": row.get::<_, i64>(0)?, "id": text(1)?, "from": text(2)?, "to": text(3)?,
                "user": text(4)?, "reason": text(5)?,
            }))
        })?
        .collect()
}

/// As databases have it.
pub fn signed(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn read(history: &History, range: (u64, u64), minutes: bool) -> Vec<Vec<Value>> {
        history.base().values("M1", "a", range, minutes, 100).await.unwrap()
    }

    #[tokio::test]
    async fn changes_are_noted_and_minutes_made() {
        let mut history = History::open(None).unwrap();
        let start = 600_000;
        for second in 0..=120_u64 {
            let value = if second < 30 { 10.0 } else { 20.0 };
            history.note(start + second * 1000, "M1", "a", value);
        }
        assert!(history.flush());
        let raw = read(&history, (0, u64::MAX), false).await;
        assert_eq!(json!(raw), json!([[600_000, 10.0], [630_000, 20.0]]));
        let minutes = read(&history, (0, u64::MAX), true).await;
        assert_eq!(
            json!(minutes),
            json!([[600_000, 15.0, 10.0, 20.0], [660_000, 20.0, 20.0, 20.0]])
        );
        let held = read(&history, (640_000, 650_000), false).await;
        assert_eq!(json!(held), json!([[630_000, 20.0]]), "the value that holds is given as well");
    }

    #[tokio::test]
    async fn a_gap_is_a_gap_and_old_values_go() {
        let mut history = History::open(None).unwrap();
        history.note(1000, "M1", "a", 1.0);
        history.lost(2000, "M1");
        history.note(DAY_MS * 3, "M1", "a", 1.0);
        history.flush();
        let raw = read(&history, (0, u64::MAX), false).await;
        assert_eq!(json!(raw), json!([[1000, 1.0], [2000, null], [DAY_MS * 3, 1.0]]));
        history.forget(DAY_MS * 3, 1, 1);
        assert_eq!(read(&history, (0, u64::MAX), false).await.len(), 1);
    }

    #[tokio::test]
    async fn alarms_are_listed_the_latest_first() {
        let history = History::open(None).unwrap();
        for (at_ms, after) in [(1, "unack"), (2, "ack")] {
            let alarm = ["M1/x", "M1", "normal", after].map(str::to_owned);
            history.alarm(at_ms, alarm, None, None);
        }
        let list = history.base().alarms(Some("M1".into()), (0, 9), 10).await.unwrap();
        assert_eq!((list[0]["to"].as_str(), list.len()), (Some("ack"), 2));
    }
}
