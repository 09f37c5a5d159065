//! The history in SQLite: each statement finds its rows by a key.

use std::collections::HashMap;
use std::sync::Arc;

use rusqlite::{Connection, params};

use super::db::Db;
use super::history::{AlarmChange, Change, Key, Row, signed};
use super::thin::{MINUTE_MS, Piece, Point};

/// A series whose value stays is written so often: a gap differs from a constant, and what is
/// forgotten takes no value with it that still holds.
pub const HEARTBEAT_MS: u64 = 3_600_000;
/// How long a constant holds without a word of it: the next heartbeat may be that late.
const HOLD_MS: u64 = HEARTBEAT_MS + 2 * MINUTE_MS;
/// Series of which one piece of forgetting takes care, and rows that it removes of each.
const FORGET_SERIES: u32 = 64;
const FORGET_ROWS: u32 = 1000;

/// `minute` has a row when something changes, and each hour; `gap` has the time from which a series is
/// not known. Files without `gap` and `mark` have a row each minute.
pub const SCHEMA: &str = "
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
CREATE TABLE IF NOT EXISTS gap (
  series INTEGER NOT NULL REFERENCES series, t INTEGER NOT NULL, PRIMARY KEY (series, t)
) STRICT, WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS mark (name TEXT PRIMARY KEY, t INTEGER NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS alarm (
  at_ms INTEGER NOT NULL, id TEXT NOT NULL, monitor TEXT NOT NULL, before TEXT NOT NULL,
  after TEXT NOT NULL, user TEXT, reason TEXT
) STRICT;
CREATE INDEX IF NOT EXISTS alarm_by_time ON alarm (at_ms);
CREATE INDEX IF NOT EXISTS alarm_by_monitor ON alarm (monitor, at_ms);
PRAGMA synchronous = NORMAL;";

const ID: &str = "SELECT id FROM series WHERE monitor = ?1 AND name = ?2";
const RAW: &str = "SELECT t, value FROM raw WHERE series = ?1 AND t <= ?3
  AND t >= COALESCE((SELECT MAX(t) FROM raw WHERE series = ?1 AND t <= ?2), ?2) ORDER BY t";
const MINUTES: &str = "SELECT t, mean, least, most FROM minute WHERE series = ?1 AND t <= ?3
  AND t >= COALESCE((SELECT MAX(t) FROM minute WHERE series = ?1 AND t <= ?2), ?2) ORDER BY t";
const GAPS: &str = "SELECT t FROM gap WHERE series = ?1 AND t <= ?3
  AND t >= COALESCE((SELECT MAX(t) FROM gap WHERE series = ?1 AND t <= ?2), ?2) ORDER BY t";
const MARK: &str = "SELECT t FROM mark WHERE name = ?1";
const HELD: &str = "SELECT series.name, raw.t, raw.value FROM series CROSS JOIN raw
  ON raw.series = series.id
  AND raw.t = (SELECT MAX(t) FROM raw AS held WHERE held.series = series.id AND held.t <= ?2)
  WHERE series.monitor = ?1";
const CHANGES: &str = "SELECT series.name, raw.t, raw.value FROM series CROSS JOIN raw
  ON raw.series = series.id AND raw.t > ?2 AND raw.t <= ?3 WHERE series.monitor = ?1 ORDER BY raw.t";
const ALARMS: &str = "SELECT at_ms, id, before, after, user, reason FROM alarm
  WHERE at_ms BETWEEN ?1 AND ?2 ORDER BY at_ms DESC, rowid DESC LIMIT ?3";
const ALARMS_OF: &str = "SELECT at_ms, id, before, after, user, reason FROM alarm
  WHERE monitor = ?4 AND at_ms BETWEEN ?1 AND ?2 ORDER BY at_ms DESC, rowid DESC LIMIT ?3";
const NEXT_SERIES: &str = "SELECT id FROM series WHERE id > ?1 ORDER BY id LIMIT ?2";
const FORGET: [&str; 3] = [
    "DELETE FROM raw WHERE series = ?1 AND t < ?2 AND t <= (SELECT MAX(t) FROM
       (SELECT t FROM raw WHERE series = ?1 ORDER BY t LIMIT ?3))",
    "DELETE FROM minute WHERE series = ?1 AND t < ?2 AND t <= (SELECT MAX(t) FROM
       (SELECT t FROM minute WHERE series = ?1 ORDER BY t LIMIT ?3))",
    "DELETE FROM gap WHERE series = ?1 AND t < ?2 AND t <= (SELECT MAX(t) FROM
       (SELECT t FROM gap WHERE series = ?1 ORDER BY t LIMIT ?3))",
];
const FORGET_ALARMS: &str = "DELETE FROM alarm WHERE rowid IN
  (SELECT rowid FROM alarm WHERE at_ms < ?1 ORDER BY at_ms LIMIT ?2)";

/// Marks the end of values that were current: the last row of a series until a time says that it is known.
const END_RAW: &str = "INSERT OR IGNORE INTO raw
  SELECT id, MAX((SELECT t FROM mark WHERE name = 'known'), last + 1), NULL
  FROM (SELECT id, (SELECT MAX(t) FROM raw WHERE series = id AND t <= ?1) AS last FROM series)
  WHERE (SELECT value FROM raw WHERE series = id AND t = last) IS NOT NULL";
const END_MINUTES: &str = "INSERT OR IGNORE INTO gap
  SELECT id, MAX((SELECT t FROM mark WHERE name = 'known'), last + 1)
  FROM (SELECT id, (SELECT MAX(t) FROM minute WHERE series = id AND t <= ?1) AS last FROM series)
  WHERE last IS NOT NULL
  AND last >= COALESCE((SELECT MAX(t) FROM gap WHERE series = id AND t <= ?1), 0)";
/// What a hub has stored last is at most so much later than the time until which it says that values are known.
/// What is later still was stored before the date was put back.
const KNOWN_LATE_MS: i64 = 2 * MINUTE_MS as i64;

/// Up to where the ends of values are looked for, if they are known until this time.
pub fn ends(known_ms: i64) -> [i64; 2] {
    [known_ms.saturating_add(KNOWN_LATE_MS), i64::MAX]
}

/// Numbers of series that are known, for the thread that writes.
pub type Ids = HashMap<Arc<Key>, i64>;

/// After the hub ended: nothing is known from when it last stored until it notes values again. A
/// file without marks was written by a hub that stored each minute: what it has holds for a minute.
pub fn resume(db: &mut Connection) -> Result<(), rusqlite::Error> {
    let transaction = db.transaction()?;
    let dense_ms: Option<i64> = transaction.query_row(
        "SELECT MAX((SELECT MAX(t) FROM minute WHERE series = id)) FROM series",
        [],
        |row| row.get(0),
    )?;
    let dense_ms = dense_ms.map_or(0, |t| t.saturating_add(MINUTE_MS as i64));
    transaction.execute("INSERT OR IGNORE INTO mark VALUES ('sparse', ?1)", [dense_ms])?;
    transaction.execute("INSERT OR IGNORE INTO mark VALUES ('known', ?1)", [dense_ms])?;
    let known_ms: i64 = transaction.query_row(MARK, ["known"], |row| row.get(0))?;
    for until_ms in ends(known_ms) {
        transaction.execute(END_RAW, [until_ms])?;
        transaction.execute(END_MINUTES, [until_ms])?;
    }
    transaction.commit()
}

/// Stores rows; the numbers are good only if it succeeds.
pub fn store(db: &mut Connection, ids: &mut Ids, rows: &[Row]) -> Result<(), rusqlite::Error> {
    let transaction = db.transaction()?;
    for row in rows {
        match row {
            Row::Raw(key, t, value) => transaction
                .prepare_cached("INSERT OR REPLACE INTO raw VALUES (?1, ?2, ?3)")?
                .execute(params![id(&transaction, ids, key)?, signed(*t), value])?,
            Row::Minute(key, t, [mean, least, most]) => transaction
                .prepare_cached("INSERT OR REPLACE INTO minute VALUES (?1, ?2, ?3, ?4, ?5)")?
                .execute(params![id(&transaction, ids, key)?, signed(*t), mean, least, most])?,
            Row::Gap(key, t) => transaction
                .prepare_cached("INSERT OR IGNORE INTO gap VALUES (?1, ?2)")?
                .execute(params![id(&transaction, ids, key)?, signed(*t)])?,
            Row::Known(t) => transaction
                .prepare_cached("INSERT OR REPLACE INTO mark VALUES ('known', ?1)")?
                .execute([signed(*t)])?,
        };
    }
    transaction.commit()
}

fn id(db: &Connection, ids: &mut Ids, key: &Arc<Key>) -> Result<i64, rusqlite::Error> {
    if let Some(id) = ids.get(key) {
        return Ok(*id);
    }
    let names = [&key.monitor, &key.series];
    db.prepare_cached("INSERT OR IGNORE INTO series (monitor, name) VALUES (?1, ?2)")?
        .execute(names)?;
    let id = db.prepare_cached(ID)?.query_row(names, |row| row.get(0))?;
    ids.insert(key.clone(), id);
    Ok(id)
}

fn known(db: &Connection, monitor: &str, series: &str) -> Result<Option<i64>, rusqlite::Error> {
    let mut rows = db.prepare_cached(ID)?;
    let mut rows = rows.query([monitor, series])?;
    rows.next()?.map(|row| row.get(0)).transpose()
}

/// Each change in a range, and what held when it began.
pub fn changes_of(
    db: &Connection,
    monitor: &str,
    series: &str,
    range: (u64, u64),
) -> Result<Vec<Point>, rusqlite::Error> {
    let Some(id) = known(db, monitor, series)? else { return Ok(Vec::new()) };
    let range = params![id, signed(range.0), signed(range.1)];
    let point = |row: &rusqlite::Row<'_>| Ok((time(row, 0)?, row.get(1)?));
    db.prepare_cached(RAW)?.query_map(range, point)?.collect()
}

/// The minutes of a range, each with the time for which it holds.
pub fn minutes_of(
    db: &Connection,
    monitor: &str,
    series: &str,
    range: (u64, u64),
) -> Result<Vec<Piece>, rusqlite::Error> {
    let Some(id) = known(db, monitor, series)? else { return Ok(Vec::new()) };
    let range = params![id, signed(range.0), signed(range.1)];
    let minute = |row: &rusqlite::Row<'_>| {
        Ok((time(row, 0)?, [row.get(1)?, row.get(2)?, row.get::<_, f64>(3)?]))
    };
    let minutes: Vec<_> =
        db.prepare_cached(MINUTES)?.query_map(range, minute)?.collect::<Result<_, _>>()?;
    let gaps: Vec<u64> =
        db.prepare_cached(GAPS)?.query_map(range, |row| time(row, 0))?.collect::<Result<_, _>>()?;
    let sparse_ms = db.prepare_cached(MARK)?.query_map(["sparse"], |row| time(row, 0))?.next();
    Ok(pieces(series, &minutes, &gaps, sparse_ms.transpose()?.unwrap_or(0)))
}

/// Minutes and gaps, both in order of time, as pieces. Before `sparse_ms` there was a row each
/// minute.
pub fn pieces(
    series: &str,
    minutes: &[(u64, [f64; 3])],
    gaps: &[u64],
    sparse_ms: u64,
) -> Vec<Piece> {
    let mut gaps = gaps.iter().copied().peekable();
    let piece = |(index, (from_ms, figures)): (usize, &(u64, [f64; 3]))| {
        let [_, least, most] = *figures;
        let bucket_ms = if *from_ms < sparse_ms { MINUTE_MS } else { bucket_ms(series) };
        let constant = least.total_cmp(&most).is_eq() && *from_ms >= sparse_ms;
        let longest_ms = if constant { HOLD_MS } else { bucket_ms - from_ms % bucket_ms };
        let next_ms = minutes.get(index + 1).map_or(u64::MAX, |it| it.0);
        while gaps.next_if(|gap| gap <= from_ms).is_some() {}
        let gap_ms = gaps.peek().copied().unwrap_or(u64::MAX);
        let until_ms = from_ms.saturating_add(longest_ms).min(next_ms).min(gap_ms);
        Piece { from_ms: *from_ms, until_ms, figures: *figures }
    };
    minutes.iter().enumerate().map(piece).collect()
}

/// How long a stored minute of a series is: figures of a link change all the time and matter less.
pub fn bucket_ms(series: &str) -> u64 {
    if series.starts_with(crate::monitor::link_series::PREFIX) { 10 * MINUTE_MS } else { MINUTE_MS }
}

/// All series of a monitor: what held at the beginning of a range, or each change after that.
pub fn changes(
    db: &Connection,
    monitor: &str,
    (from_ms, to_ms): (u64, u64),
    held: bool,
) -> Result<Vec<Change>, rusqlite::Error> {
    let row = |row: &rusqlite::Row<'_>| Ok((row.get(0)?, time(row, 1)?, row.get(2)?));
    if held {
        let mut query = db.prepare_cached(HELD)?;
        return query.query_map(params![monitor, signed(from_ms)], row)?.collect();
    }
    let mut query = db.prepare_cached(CHANGES)?;
    query.query_map(params![monitor, signed(from_ms), signed(to_ms)], row)?.collect()
}

/// What alarms did, the latest first.
pub fn alarms(
    db: &Connection,
    monitor: Option<&str>,
    range: (u64, u64),
    limit: u32,
) -> Result<Vec<AlarmChange>, rusqlite::Error> {
    let (from, to) = (signed(range.0), signed(range.1));
    let row = |row: &rusqlite::Row<'_>| {
        Ok(AlarmChange {
            at_ms: time(row, 0)?,
            id: row.get(1)?,
            from: row.get(2)?,
            to: row.get(3)?,
            user: row.get(4)?,
            reason: row.get(5)?,
        })
    };
    match monitor {
        None => db.prepare_cached(ALARMS)?.query_map(params![from, to, limit], row)?.collect(),
        Some(monitor) => {
            let mut query = db.prepare_cached(ALARMS_OF)?;
            query.query_map(params![from, to, limit, monitor], row)?.collect()
        }
    }
}

fn time(row: &rusqlite::Row<'_>, index: usize) -> Result<u64, rusqlite::Error> {
    row.get::<_, i64>(index).map(i64::cast_unsigned)
}

/// How far old rows are forgotten.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    /// Changes before this time go,
    pub raw: i64,
    /// minutes, gaps and what alarms did before this one.
    pub minute: i64,
    /// Series up to this number are done.
    pub done: i64,
}

/// Forgets piece by piece; what is to be stored is stored between two pieces.
pub fn forget(db: &Db, mut sweep: Sweep) -> bool {
    let again = db.clone();
    db.post(move |connection| match piece_of(connection, &mut sweep) {
        Ok(true) => {}
        Ok(false) => _ = forget(&again, sweep),
        Err(error) => tracing::warn!(%error, "old history is not removed"),
    })
}

/// One piece; whether it was the last.
fn piece_of(db: &mut Connection, sweep: &mut Sweep) -> Result<bool, rusqlite::Error> {
    let transaction = db.transaction()?;
    let series: Vec<i64> = transaction
        .prepare_cached(NEXT_SERIES)?
        .query_map(params![sweep.done, FORGET_SERIES], |row| row.get(0))?
        .collect::<Result<_, _>>()?;
    let mut removed = 0;
    for id in &series {
        let mut full = false;
        for (statement, before) in FORGET.into_iter().zip([sweep.raw, sweep.minute, sweep.minute]) {
            let mut statement = transaction.prepare_cached(statement)?;
            let rows = statement.execute(params![id, before, FORGET_ROWS])?;
            full |= rows >= FORGET_ROWS as usize;
            removed += rows;
        }
        sweep.done = if full { *id - 1 } else { *id };
        if full || removed > FORGET_ROWS as usize {
            return transaction.commit().map(|()| false);
        }
    }
    let mut statement = transaction.prepare_cached(FORGET_ALARMS)?;
    let alarms = statement.execute(params![sweep.minute, FORGET_ROWS])?;
    drop(statement);
    transaction.commit()?;
    Ok(series.len() < FORGET_SERIES as usize && alarms < FORGET_ROWS as usize)
}

#[cfg(test)]
mod tests {
    use super::super::history::DAY_MS;
    use super::*;

    /// The layout of files before there were gaps and marks.
    const FORMER: &str = "
        CREATE TABLE series (id INTEGER PRIMARY KEY, monitor TEXT NOT NULL, name TEXT NOT NULL,
          UNIQUE (monitor, name)) STRICT;
        CREATE TABLE raw (series INTEGER NOT NULL REFERENCES series, t INTEGER NOT NULL, value REAL,
          PRIMARY KEY (series, t)) STRICT, WITHOUT ROWID;
        CREATE TABLE minute (series INTEGER NOT NULL REFERENCES series, t INTEGER NOT NULL,
          mean REAL NOT NULL, least REAL NOT NULL, most REAL NOT NULL, PRIMARY KEY (series, t)
        ) STRICT, WITHOUT ROWID;
        CREATE TABLE alarm (at_ms INTEGER NOT NULL, id TEXT NOT NULL, monitor TEXT NOT NULL,
          before TEXT NOT NULL, after TEXT NOT NULL, user TEXT, reason TEXT) STRICT;
        CREATE INDEX alarm_by_time ON alarm (at_ms);
        INSERT INTO series VALUES (1, 'M1', 'a'), (2, 'M1', 'b');
        INSERT INTO raw VALUES (1, 5000, 7.0), (2, 5000, 1.0), (2, 6000, NULL);
        INSERT INTO minute VALUES (1, 0, 7.0, 7.0, 7.0), (1, 60000, 7.0, 7.0, 7.0),
          (1, 240000, 7.0, 6.0, 8.0), (2, 0, 1.0, 1.0, 1.0);
        INSERT INTO alarm VALUES (1, 'M1/x', 'M1', 'normal', 'unack', NULL, NULL);";

    fn key(series: &str) -> Arc<Key> {
        Arc::new(Key { monitor: "M1".into(), series: series.into() })
    }

    fn new() -> Connection {
        super::super::db::open(None, "", SCHEMA).unwrap()
    }

    #[test]
    fn every_statement_finds_its_rows_by_a_key() {
        let db = new();
        let all = [ID, RAW, MINUTES, GAPS, MARK, HELD, CHANGES, ALARMS, ALARMS_OF, NEXT_SERIES];
        for sql in all.into_iter().chain(FORGET).chain([FORGET_ALARMS]) {
            let plan = super::super::db::plan(&db, sql).unwrap();
            let tables = ["series", "raw", "minute", "gap", "mark", "alarm", "held"];
            let scans =
                |it: &&String| tables.iter().any(|table| it.starts_with(&format!("SCAN {table}")));
            let of_index = |it: &String| it.contains("USING INDEX alarm_by_time");
            let scan = plan.iter().find(|it| scans(it) && !of_index(it));
            assert!(scan.is_none() && !plan.is_empty(), "{sql}: {plan:#?}");
        }
        let plan = super::super::db::plan(&db, RAW).unwrap();
        let by_key = "SEARCH raw USING PRIMARY KEY (series=? AND t>? AND t<?)";
        assert!(plan.iter().any(|it| it == by_key), "{plan:#?}");
        let plan = super::super::db::plan(&db, HELD).unwrap();
        assert!(plan.iter().any(|it| it.contains("series=? AND t=?")), "{plan:#?}");
    }

    #[test]
    fn a_file_of_the_former_layout_keeps_its_meaning() {
        let folder = std::env::temp_dir().join(format!("lafet-former-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let former = Connection::open(folder.join("history.db")).unwrap();
        former.execute_batch(FORMER).unwrap();
        drop(former);
        for open in 0..2 {
            let mut db = super::super::db::open(Some(&folder), "history.db", SCHEMA).unwrap();
            if open == 0 {
                // The hub is killed before this is on the disk: the next one does it.
                let cut = db.unchecked_transaction().unwrap();
                cut.execute("INSERT INTO mark VALUES ('sparse', 1)", []).unwrap();
                drop(cut);
            }
            resume(&mut db).unwrap();
            // A row is a minute, and what is missing was not known.
            let all = minutes_of(&db, "M1", "a", (0, 999_999)).unwrap();
            let times: Vec<_> = all.iter().map(|it| (it.from_ms, it.until_ms)).collect();
            assert_eq!(times, [(0, 60_000), (60_000, 120_000), (240_000, 300_000)]);
            assert_eq!(all[2].figures, [7.0, 6.0, 8.0]);
            let raw = changes_of(&db, "M1", "a", (0, 999_999)).unwrap();
            assert_eq!(raw, [(5000, Some(7.0)), (300_000, None)], "the hub was off");
            let raw = changes_of(&db, "M1", "b", (0, 999_999)).unwrap();
            assert_eq!(raw, [(5000, Some(1.0)), (6000, None)]);
            assert_eq!(alarms(&db, Some("M1"), (0, 9), 9).unwrap()[0].to, "unack");
        }
        // What is stored from now on is sparse.
        let mut db = super::super::db::open(Some(&folder), "history.db", SCHEMA).unwrap();
        let row = Row::Minute(key("a"), 600_000, [7.0; 3]);
        store(&mut db, &mut Ids::new(), &[row]).unwrap();
        let all = minutes_of(&db, "M1", "a", (0, u64::MAX)).unwrap();
        assert_eq!(all[3].until_ms, 600_000 + HOLD_MS);
        drop(db);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn after_a_kill_nothing_is_known_from_when_it_was_stored_last() {
        let mut db = new();
        resume(&mut db).unwrap();
        let rows = [
            Row::Raw(key("a"), 1000, Some(1.0)),
            Row::Minute(key("a"), 1000, [1.0; 3]),
            Row::Raw(key("b"), 1000, Some(1.0)),
            Row::Raw(key("b"), 2000, None),
            Row::Known(500_000),
        ];
        store(&mut db, &mut Ids::new(), &rows).unwrap();
        for _ in 0..2 {
            resume(&mut db).unwrap();
            let raw = |series| changes_of(&db, "M1", series, (0, u64::MAX)).unwrap();
            assert_eq!(raw("a"), [(1000, Some(1.0)), (500_000, None)]);
            assert_eq!(raw("b"), [(1000, Some(1.0)), (2000, None)]);
            let all = minutes_of(&db, "M1", "a", (0, u64::MAX)).unwrap();
            assert_eq!((all.len(), all[0].until_ms), (1, 500_000));
        }
    }

    /// What was stored at later dates, before the date was put back, hides no end.
    #[test]
    fn after_a_kill_nothing_is_known_though_later_dates_have_values() {
        let mut db = new();
        resume(&mut db).unwrap();
        let rows = [
            Row::Raw(key("a"), DAY_MS, Some(1.0)),
            Row::Minute(key("a"), DAY_MS, [1.0; 3]),
            Row::Raw(key("a"), DAY_MS + 5000, None),
            Row::Gap(key("a"), DAY_MS + 5000),
            Row::Raw(key("a"), 1000, Some(2.0)),
            Row::Minute(key("a"), 1000, [2.0; 3]),
            Row::Known(500_000),
        ];
        store(&mut db, &mut Ids::new(), &rows).unwrap();
        for _ in 0..2 {
            resume(&mut db).unwrap();
            let expected =
                [(1000, Some(2.0)), (500_000, None), (DAY_MS, Some(1.0)), (DAY_MS + 5000, None)];
            assert_eq!(changes_of(&db, "M1", "a", (0, u64::MAX)).unwrap(), expected);
            let all = minutes_of(&db, "M1", "a", (0, u64::MAX)).unwrap();
            assert_eq!((all.len(), all[0].until_ms), (2, 500_000));
        }
    }

    #[test]
    fn old_rows_are_forgotten_in_bounded_pieces() {
        let mut db = new();
        let mut rows = Vec::new();
        for series in 0..200 {
            let key = key(&series.to_string());
            let count = if series == 3 { 3 * u64::from(FORGET_ROWS) } else { 3 };
            rows.extend((0..count).map(|t| Row::Raw(key.clone(), t, Some(0.0))));
            rows.push(Row::Raw(key.clone(), DAY_MS, Some(1.0)));
            rows.push(Row::Minute(key.clone(), 5, [0.0; 3]));
            rows.push(Row::Gap(key, 6));
        }
        store(&mut db, &mut Ids::new(), &rows).unwrap();
        let mut sweep = Sweep { raw: signed(DAY_MS), minute: 6, done: 0 };
        let (mut pieces, mut before) = (0, db.total_changes());
        while !piece_of(&mut db, &mut sweep).unwrap() {
            let after = db.total_changes();
            assert!(after - before <= 5 * u64::from(FORGET_ROWS), "{}", after - before);
            (pieces, before) = (pieces + 1, after);
            assert!(pieces < 100, "it comes to an end");
        }
        assert!(pieces >= 4, "{pieces}");
        let count = |table: &str| -> i64 {
            db.query_row(&format!("SELECT COUNT(*) FROM {table}"), [], |row| row.get(0)).unwrap()
        };
        assert_eq!((count("raw"), count("minute"), count("gap")), (200, 0, 200));
    }
}
