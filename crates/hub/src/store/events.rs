//! The event log: what was sent to every client, kept to be looked up later.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use rusqlite::{Row, ToSql, params};
use serde::Serialize;
use utoipa::ToSchema;

use super::db::{Db, StoreError, is_malformed, open, open_or_begin_anew};
use super::history::{DAY_MS, signed};
use super::mark::{Fault, Loss, StateFile};
use crate::sync::lock;
use crate::text::Both;

/// Events that wait for a disk that takes none; older ones are given up.
const WAITING_MAX: usize = 10_000;

/// The file in the folder of the state.
const FILE: &str = StateFile::Events.name();

const SCHEMA: &str = "
CREATE TABLE IF NOT EXISTS event (
  n INTEGER PRIMARY KEY AUTOINCREMENT, at_ms INTEGER NOT NULL, monitor TEXT, en TEXT NOT NULL,
  ru TEXT NOT NULL
) STRICT;
CREATE INDEX IF NOT EXISTS event_by_time ON event (at_ms);
CREATE INDEX IF NOT EXISTS event_by_monitor ON event (monitor, n);
CREATE TABLE IF NOT EXISTS alarm_now (id TEXT PRIMARY KEY, value TEXT NOT NULL) STRICT;
PRAGMA synchronous = NORMAL;";

const FIND: &str = "SELECT n, at_ms, monitor, en, ru FROM event
  WHERE n < ?1 ORDER BY n DESC";
const FIND_IN: &str = "SELECT n, at_ms, monitor, en, ru FROM event
  WHERE at_ms BETWEEN ?2 AND ?3 AND n < ?1 ORDER BY n DESC";
const FIND_OF: &str = "SELECT n, at_ms, monitor, en, ru FROM event
  WHERE monitor = ?4 AND n < ?1 AND at_ms BETWEEN ?2 AND ?3 ORDER BY n DESC";
const FORGET: &str = "DELETE FROM event WHERE n IN
  (SELECT n FROM event WHERE at_ms < ?1 ORDER BY at_ms LIMIT ?2)";
/// Events that are forgotten at once.
const FORGET_ROWS: u32 = 1000;

/// An entry of the event log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Event {
    /// Number of the entry.
    pub n: u64,
    /// Time, ms since 1970.
    pub at_ms: u64,
    /// To which monitor; `None`: to the site.
    #[schema(required)]
    pub monitor: Option<String>,
    /// The event, in words.
    pub what: Both,
}

/// Which events, and which entries of the audit log.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// Only events of this monitor.
    pub monitor: Option<String>,
    /// Only events of this user.
    pub user: Option<String>,
    /// With this text in it, in small letters.
    pub text: Option<String>,
    /// Not before this time, ms since 1970.
    pub from_ms: Option<u64>,
    /// Not after this time, ms since 1970.
    pub to_ms: Option<u64>,
    /// Only entries before this number.
    pub before: Option<u64>,
    /// Most entries.
    pub limit: usize,
}

/// Part of what was found, the latest first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page<T> {
    /// The entries found.
    pub found: Vec<T>,
    /// There may be more before this number.
    pub next: Option<u64>,
}

/// The event log.
#[derive(Clone, Debug)]
pub struct Events {
    db: Db,
    /// What is not on the disk yet.
    waiting: Arc<Mutex<VecDeque<Event>>>,
    /// Alarms that have changed, as JSON; `None`: they are normal.
    alarms: Arc<Mutex<BTreeMap<String, Option<String>>>>,
    failing: Arc<AtomicBool>,
}

impl Events {
    /// Opens it in a folder, or in memory.
    pub fn open(folder: Option<&Path>) -> Result<Self, StoreError> {
        Ok(Self::open_with_alarms(folder)?.0)
    }

    /// Opens it, and returns the alarms that were not normal. A file whose alarms cannot be read is moved
    /// aside, as one that is no database is: the hub works without its contents, and reports the loss.
    pub fn open_with_alarms(
        folder: Option<&Path>,
    ) -> Result<(Self, Vec<String>, Option<Loss>), StoreError> {
        let db = open_or_begin_anew(folder, FILE, SCHEMA)?;
        let (db, alarms, loss) = match (alarms_of(&db), folder) {
            (Ok(alarms), _) => (db, alarms, None),
            (Err(error), Some(folder)) if is_malformed(&error) => {
                tracing::error!(file = FILE, %error, "cannot be read");
                drop(db);
                let fault = Fault::Malformed { error: error.to_string(), aside: None };
                let mut loss = Loss { file: StateFile::Events, fault };
                loss.set_aside(folder)?;
                (open(Some(folder), FILE, SCHEMA)?, Vec::new(), Some(loss))
            }
            (Err(error), _) => return Err(error.into()),
        };
        let db = Db::new("events", db)?;
        let (waiting, failing) = Default::default();
        Ok((Self { db, waiting, alarms: Arc::default(), failing }, alarms, loss))
    }

    /// In the place of a file that the disk does not let be read: until the hub is started again, events wait and none
    /// is found, and no alarm of before is known.
    pub fn unread() -> Self {
        let (waiting, alarms) = Default::default();
        Self { db: Db::unread(), waiting, alarms, failing: Arc::new(true.into()) }
    }

    /// Notes what an alarm is now; `None`: it is normal. Written with the next flush.
    pub fn note_alarm(&self, id: &str, alarm: Option<String>) {
        lock(&self.alarms).insert(id.to_owned(), alarm);
    }

    /// Notes that something has happened; written with the next [`Events::flush`].
    pub fn note(&self, at_ms: u64, monitor: Option<&str>, what: &Both) {
        let event = Event { n: 0, at_ms, monitor: monitor.map(str::to_owned), what: what.clone() };
        let mut waiting = lock(&self.waiting);
        if waiting.len() == WAITING_MAX {
            waiting.pop_front();
        }
        waiting.push_back(event);
    }

    /// Whether the disk takes nothing.
    pub fn is_failing(&self) -> bool {
        self.failing.load(Ordering::Relaxed)
    }

    /// Stores what has come together; what the disk does not take stays.
    pub fn flush(&self) {
        let (waiting, alarms) = (self.waiting.clone(), self.alarms.clone());
        let failing = self.failing.clone();
        if lock(&waiting).is_empty() && lock(&alarms).is_empty() {
            return;
        }
        let taken = self.db.post(move |db| {
            let changed = std::mem::take(&mut *lock(&alarms));
            let stored = store_alarms(db, &changed);
            let mut fails = stored.is_err();
            if let Err(error) = stored {
                tracing::warn!(%error, "alarms are not stored");
                let mut alarms = lock(&alarms);
                let newer = std::mem::replace(&mut *alarms, changed);
                alarms.extend(newer);
            }
            let mut all = std::mem::take(&mut *lock(&waiting));
            let stored = store(db, &all);
            fails |= stored.is_err();
            failing.store(fails, Ordering::Relaxed);
            if let Err(error) = stored {
                tracing::warn!(%error, events = all.len(), "events are not stored");
                let mut waiting = lock(&waiting);
                all.append(&mut waiting);
                all.drain(..all.len().saturating_sub(WAITING_MAX));
                *waiting = all;
            }
        });
        if !taken {
            self.failing.store(true, Ordering::Relaxed);
        }
    }

    /// Stores everything, in the file itself.
    pub async fn settle(&self) -> Result<(), StoreError> {
        self.flush();
        self.db.checkpoint().await
    }

    /// Looks events up.
    pub async fn find(&self, search: Search) -> Result<Page<Event>, StoreError> {
        self.flush();
        // What was noted is stored before it is looked for, on a connection of its own.
        self.db.look(|_| Ok(())).await?;
        self.db.read(move |db| find(db, &search)).await
    }

    /// Forgets what is older than some days.
    pub fn forget(&self, now_ms: u64, days: u32) {
        let before = signed(now_ms.saturating_sub(u64::from(days) * DAY_MS));
        forget(&self.db, before);
    }
}

/// The alarms that were not normal. Opening the file reads its schema alone: a damaged page shows here.
fn alarms_of(db: &rusqlite::Connection) -> Result<Vec<String>, rusqlite::Error> {
    let mut query = db.prepare("SELECT value FROM alarm_now")?;
    query.query_map([], |row| row.get(0))?.collect()
}

/// Forgets piece by piece; what is to be stored is stored between two pieces.
fn forget(db: &Db, before: i64) -> bool {
    let again = db.clone();
    db.post(move |db| match db.execute(FORGET, params![before, FORGET_ROWS]) {
        Ok(rows) if rows == FORGET_ROWS as usize => _ = forget(&again, before),
        Ok(_) => {}
        Err(error) => tracing::warn!(%error, "old events are not removed"),
    })
}

fn store_alarms(
    db: &mut rusqlite::Connection,
    changed: &BTreeMap<String, Option<String>>,
) -> Result<(), rusqlite::Error> {
    let transaction = db.transaction()?;
    for (id, alarm) in changed {
        match alarm {
            Some(alarm) => transaction
                .execute("INSERT OR REPLACE INTO alarm_now VALUES (?1, ?2)", [id, alarm])?,
            None => transaction.execute("DELETE FROM alarm_now WHERE id = ?1", [id])?,
        };
    }
    transaction.commit()
}

fn store(db: &mut rusqlite::Connection, all: &VecDeque<Event>) -> Result<(), rusqlite::Error> {
    let transaction = db.transaction()?;
    for it in all {
        transaction
            .prepare_cached("INSERT INTO event (at_ms, monitor, en, ru) VALUES (?1, ?2, ?3, ?4)")?
            .execute(params![signed(it.at_ms), it.monitor, it.what.en, it.what.ru])?;
    }
    transaction.commit()
}

fn find(db: &rusqlite::Connection, search: &Search) -> Result<Page<Event>, rusqlite::Error> {
    let (before, from_ms, to_ms) = search.bounds();
    let of = search.monitor.as_ref();
    let ranged = search.from_ms.or(search.to_ms).is_some();
    let mut query = db.prepare_cached(match of {
        Some(_) => FIND_OF,
        None if ranged => FIND_IN,
        None => FIND,
    })?;
    let mut values: Vec<&dyn ToSql> = vec![&before];
    if of.is_some() || ranged {
        values.extend([&from_ms as &dyn ToSql, &to_ms]);
    }
    values.extend(of.map(|monitor| monitor as &dyn ToSql));
    let rows = query.query_map(&values[..], event)?;
    search.page(rows, |it| it.n, |it| format!("{} {}", it.what.en, it.what.ru))
}

fn event(row: &Row<'_>) -> Result<Event, rusqlite::Error> {
    let unsigned = |index| row.get::<_, i64>(index).map(i64::cast_unsigned);
    Ok(Event {
        n: unsigned(0)?,
        at_ms: unsigned(1)?,
        monitor: row.get(2)?,
        what: Both { en: row.get(3)?, ru: row.get(4)? },
    })
}

/// Rows that one search looks at: the rest is for the next page.
const LOOKED_AT_MAX: usize = 100_000;

impl Search {
    /// The number before which, the first and the last time, as databases have it.
    pub fn bounds(&self) -> (i64, i64, i64) {
        let number = |value: Option<u64>, none| value.map_or(none, signed);
        (number(self.before, i64::MAX), number(self.from_ms, 0), number(self.to_ms, i64::MAX))
    }

    /// Takes rows, the latest first, in whose text the wanted one is. Letters are compared here, as
    /// SQLite takes capital and small ones for the same in English alone.
    pub fn page<T>(
        &self,
        rows: impl Iterator<Item = Result<T, rusqlite::Error>>,
        number: impl Fn(&T) -> u64,
        text: impl Fn(&T) -> String,
    ) -> Result<Page<T>, rusqlite::Error> {
        let (mut found, mut last) = (Vec::new(), None);
        for (count, row) in rows.enumerate() {
            if count == LOOKED_AT_MAX || found.len() == self.limit {
                return Ok(Page { found, next: last });
            }
            let row = row?;
            last = Some(number(&row));
            let wanted = self.text.as_deref().unwrap_or_default();
            if wanted.is_empty() || text(&row).to_lowercase().contains(wanted) {
                found.push(row);
            }
        }
        Ok(Page { found, next: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::both;

    #[tokio::test]
    async fn events_are_found_page_by_page() {
        let events = Events::open(None).unwrap();
        for number in 1..=5_u64 {
            let what = both(format!("Fire {number}"), format!("Пожар {number}"));
            events.note(number * 1000, (number == 3).then_some("M1"), &what);
        }
        let search = |change: &dyn Fn(&mut Search)| {
            let mut search = Search { limit: 2, ..Search::default() };
            change(&mut search);
            let events = events.clone();
            async move {
                let page = events.find(search).await.unwrap();
                (page.found.iter().map(|it| it.n).collect::<Vec<_>>(), page.next)
            }
        };
        assert_eq!(search(&|_| {}).await, (vec![5, 4], Some(4)));
        assert_eq!(search(&|it| it.before = Some(2)).await, (vec![1], None));
        let text = |it: &mut Search| it.text = Some("пожар 4".into());
        assert_eq!(search(&text).await, (vec![4], None));
        assert_eq!(search(&|it| it.monitor = Some("M1".into())).await, (vec![3], None));
        let range = |it: &mut Search| (it.from_ms, it.to_ms) = (Some(2000), Some(3000));
        assert_eq!(search(&range).await, (vec![3, 2], None));
        events.forget(DAY_MS + 3000, 1);
        assert_eq!(search(&|it| it.limit = 9).await, (vec![5, 4, 3], None));
    }

    #[tokio::test]
    async fn no_statement_scans_the_table() {
        let events = Events::open(None).unwrap();
        for (sql, key) in [
            (FIND, "SEARCH event USING INTEGER PRIMARY KEY (rowid<?)"),
            (FIND_IN, "SEARCH event USING INDEX event_by_time (at_ms>? AND at_ms<?)"),
            (FIND_OF, "SEARCH event USING INDEX event_by_monitor (monitor=? AND n<?)"),
            (FORGET, "SEARCH event USING COVERING INDEX event_by_time (at_ms<?)"),
        ] {
            let plan = events.db.read(move |db| super::super::db::plan(db, sql)).await.unwrap();
            assert!(plan.iter().any(|it| it == key), "{sql}: {plan:?}");
            assert!(!plan.iter().any(|it| it.starts_with("SCAN event")), "{sql}: {plan:?}");
        }
    }

    #[tokio::test]
    async fn what_the_disk_does_not_take_waits_in_order() {
        let events = Events::open(None).unwrap();
        let change = async |sql: &'static str| events.db.call(|db| db.execute_batch(sql)).await;
        change("ALTER TABLE event RENAME TO away").await.unwrap();
        events.note(1, None, &both("first", "первое"));
        assert!(events.find(Search::default()).await.is_err());
        assert!(events.is_failing());
        events.note(2, None, &both("second", "второе"));
        change("ALTER TABLE away RENAME TO event").await.unwrap();
        let page = events.find(Search { limit: 9, ..Search::default() }).await.unwrap();
        assert_eq!(page.found.iter().map(|it| it.at_ms).collect::<Vec<_>>(), [2, 1]);
        assert!(!events.is_failing());
        let go = events.db.hang();
        while events.db.post(|_| {}) {}
        events.note(3, None, &both("third", "третье"));
        events.flush();
        assert!(events.is_failing(), "the disk hangs");
        go.send(()).unwrap();
        while events.is_failing() {
            _ = events.find(Search::default()).await;
        }
    }
}
