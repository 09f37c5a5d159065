//! The history in PostgreSQL: written by a thread of its own, which waits when the server is away.

mod address;
mod verify;

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{mpsc, watch};
use tokio::time::{sleep, timeout};
use tokio_postgres::error::SqlState;
use tokio_postgres::types::ToSql;
use tokio_postgres::{Client, Row as PgRow};

pub use address::Address;

use super::db::StoreError;
use super::history::{AlarmChange, Change, Key, Row, signed};
use super::series::{Sweep, ends, pieces};
use super::thin::{Piece, Point};
use super::torn::{Hole, Torn};
use super::work::Work;

/// What waits for the server: pieces of a second each.
const QUEUE_MAX: usize = 256;
/// Rows that wait while it is away; the oldest are lost then.
const ROWS_MAX: usize = 500_000;
/// Pause between attempts to connect, and the longest wait for an answer of the server.
const PAUSE: Duration = Duration::from_secs(1);
const PATIENCE: Duration = Duration::from_secs(10);

/// The server ends a statement before [`PATIENCE`] does: none goes on without its client. A session whose client has
/// vanished ends within half a minute, and with it its [`OCCUPY`]. Servers before version 12 lack the last setting.
const SESSION: &str = "SET statement_timeout = 9000; SET tcp_keepalives_idle = 10;
SET tcp_keepalives_interval = 5; SET tcp_keepalives_count = 3;
SELECT set_config(name, '25000', false) FROM pg_settings WHERE name = 'tcp_user_timeout';";
/// Takes the tables for this hub, as long as the session lasts. The number is ours; beside it is the schema.
const OCCUPY: &str = "SELECT pg_try_advisory_lock(1818322533,
  COALESCE((SELECT oid::INT4 FROM pg_namespace WHERE nspname = current_schema()), 0))";
const IN_USE: &str = "another hub uses this database, or this hub's last session has not ended yet";

const SCHEMA: &str = "
CREATE TABLE IF NOT EXISTS lafet_series (
  id SERIAL PRIMARY KEY, monitor TEXT NOT NULL, name TEXT NOT NULL, UNIQUE (monitor, name));
CREATE TABLE IF NOT EXISTS lafet_raw (
  series INTEGER NOT NULL REFERENCES lafet_series, t BIGINT NOT NULL, value DOUBLE PRECISION,
  PRIMARY KEY (series, t));
CREATE TABLE IF NOT EXISTS lafet_minute (
  series INTEGER NOT NULL REFERENCES lafet_series, t BIGINT NOT NULL,
  mean DOUBLE PRECISION NOT NULL, least DOUBLE PRECISION NOT NULL, most DOUBLE PRECISION NOT NULL,
  PRIMARY KEY (series, t));
CREATE TABLE IF NOT EXISTS lafet_gap (
  series INTEGER NOT NULL REFERENCES lafet_series, t BIGINT NOT NULL, PRIMARY KEY (series, t));
CREATE TABLE IF NOT EXISTS lafet_mark (name TEXT PRIMARY KEY, t BIGINT NOT NULL);
CREATE TABLE IF NOT EXISTS lafet_alarm (
  n BIGSERIAL PRIMARY KEY, at_ms BIGINT NOT NULL, id TEXT NOT NULL, monitor TEXT NOT NULL,
  before TEXT NOT NULL, after TEXT NOT NULL, by TEXT, reason TEXT, event TEXT UNIQUE);
DO $$ BEGIN
  IF NOT EXISTS (SELECT FROM pg_attribute
      WHERE attrelid = 'lafet_alarm'::regclass AND attname = 'event' AND NOT attisdropped) THEN
    ALTER TABLE lafet_alarm ADD COLUMN event TEXT UNIQUE;
  END IF;
END $$;
CREATE INDEX IF NOT EXISTS lafet_alarm_by_time ON lafet_alarm (at_ms);
CREATE INDEX IF NOT EXISTS lafet_alarm_by_monitor ON lafet_alarm (monitor, at_ms);";

const MARKS: &str = "
INSERT INTO lafet_mark SELECT name, COALESCE((SELECT MAX(last) + 60000 FROM (SELECT
    (SELECT MAX(t) FROM lafet_minute WHERE series = id) AS last FROM lafet_series) AS all_last), 0)
  FROM (VALUES ('sparse'), ('known')) AS names (name) ON CONFLICT DO NOTHING";
const KNOWN: &str = "SELECT t FROM lafet_mark WHERE name = 'known'";
/// As those of the SQLite history.
const END_RAW: &str = "
INSERT INTO lafet_raw SELECT id, GREATEST((SELECT t FROM lafet_mark WHERE name = 'known'), last.t + 1),
    NULL FROM lafet_series CROSS JOIN LATERAL
    (SELECT t, value FROM lafet_raw WHERE series = id AND t <= $1 ORDER BY t DESC LIMIT 1) AS last
  WHERE last.value IS NOT NULL ON CONFLICT DO NOTHING";
const END_MINUTES: &str = "
INSERT INTO lafet_gap SELECT id, GREATEST((SELECT t FROM lafet_mark WHERE name = 'known'), last.t + 1)
  FROM lafet_series CROSS JOIN LATERAL
    (SELECT t FROM lafet_minute WHERE series = id AND t <= $1 ORDER BY t DESC LIMIT 1) AS last
  WHERE last.t >= COALESCE((SELECT MAX(t) FROM lafet_gap WHERE series = id AND t <= $1), 0)
  ON CONFLICT DO NOTHING";

const ID: &str = "SELECT id FROM lafet_series WHERE monitor = $1 AND name = $2";
const RAW: &str = "SELECT t, value FROM lafet_raw WHERE series = $1 AND t <= $3
  AND t >= COALESCE((SELECT MAX(t) FROM lafet_raw WHERE series = $1 AND t <= $2), $2) ORDER BY t";
const MINUTES: &str = "SELECT t, mean, least, most FROM lafet_minute WHERE series = $1 AND t <= $3
  AND t >= COALESCE((SELECT MAX(t) FROM lafet_minute WHERE series = $1 AND t <= $2), $2) ORDER BY t";
const GAPS: &str = "SELECT t FROM lafet_gap WHERE series = $1 AND t <= $3
  AND t >= COALESCE((SELECT MAX(t) FROM lafet_gap WHERE series = $1 AND t <= $2), $2) ORDER BY t";
const HELD: &str = "SELECT name, held.t, held.value FROM lafet_series CROSS JOIN LATERAL
  (SELECT t, value FROM lafet_raw WHERE series = id AND t <= $2 ORDER BY t DESC LIMIT 1) AS held
  WHERE monitor = $1";
const CHANGES: &str = "SELECT name, t, value FROM lafet_raw JOIN lafet_series ON id = series
  WHERE monitor = $1 AND t > $2 AND t <= $3 ORDER BY t";
/// Series of which one piece of forgetting takes care, and rows that it removes of each table.
const FORGET_SERIES: i64 = 64;
const FORGET_ROWS: i64 = 5000;

/// The history in PostgreSQL.
#[derive(Clone, Debug)]
pub struct Postgres {
    work: mpsc::Sender<Work>,
    client: watch::Receiver<Option<Arc<Client>>>,
    figures: Arc<Figures>,
}

#[derive(Debug, Default)]
struct Figures {
    failing: AtomicBool,
    lost: AtomicU64,
    torn: Torn,
}

impl Figures {
    /// The server will not have this.
    fn lose(&self, work: &Work) {
        self.failing.store(true, Ordering::Relaxed);
        self.lost.fetch_add(rows(work) as u64, Ordering::Relaxed);
        if let Work::Rows(rows) = work {
            self.torn.lose(rows);
        }
    }
}

impl Postgres {
    /// Starts the thread; whether the server is there shows later.
    pub fn open(address: Address) -> Result<Self, StoreError> {
        let (work, queue) = mpsc::channel(QUEUE_MAX);
        let (sender, client) = watch::channel(None);
        let figures = Arc::new(Figures::default());
        let own = figures.clone();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        std::thread::Builder::new()
            .name("lafet-postgres".into())
            .spawn(move || runtime.block_on(write(address, queue, sender, own)))?;
        Ok(Self { work, client, figures })
    }

    /// Whether the server takes nothing.
    pub fn is_failing(&self) -> bool {
        self.figures.failing.load(Ordering::Relaxed)
    }

    /// Rows that were given up.
    pub fn lost(&self) -> u64 {
        self.figures.lost.load(Ordering::Relaxed)
    }

    /// What the server lacks of each series; it is the caller's to mark.
    pub fn torn(&self) -> HashMap<Arc<Key>, Hole> {
        self.figures.torn.take()
    }

    /// Stores something when the server can; `false`: it was not taken.
    pub fn post(&self, work: Work) -> bool {
        match self.work.try_send(work) {
            Ok(()) => true,
            Err(TrySendError::Full(work) | TrySendError::Closed(work)) => {
                self.figures.lose(&work);
                false
            }
        }
    }

    async fn query(
        &self,
        query: &str,
        values: &[&(dyn ToSql + Sync)],
    ) -> Result<Vec<PgRow>, StoreError> {
        let client = self.client.borrow().clone().ok_or(StoreError::Away)?;
        let rows = timeout(PATIENCE, client.query(query, values)).await;
        Ok(rows.map_err(|_| StoreError::Away)??)
    }

    async fn id(&self, monitor: &str, series: &str) -> Result<Option<i32>, StoreError> {
        Ok(self.query(ID, &[&monitor, &series]).await?.first().map(|row| row.get(0)))
    }

    /// Like the same method of the SQLite history.
    pub async fn changes_of(
        &self,
        monitor: &str,
        series: &str,
        (from_ms, to_ms): (u64, u64),
    ) -> Result<Vec<Point>, StoreError> {
        let Some(id) = self.id(monitor, series).await? else { return Ok(Vec::new()) };
        let rows = self.query(RAW, &[&id, &signed(from_ms), &signed(to_ms)]).await?;
        Ok(rows.iter().map(|row| (time(row, 0), row.get(1))).collect())
    }

    /// Like the same method of the SQLite history.
    pub async fn minutes_of(
        &self,
        monitor: &str,
        series: &str,
        (from_ms, to_ms): (u64, u64),
    ) -> Result<Vec<Piece>, StoreError> {
        let Some(id) = self.id(monitor, series).await? else { return Ok(Vec::new()) };
        let (from, to) = (signed(from_ms), signed(to_ms));
        let range: [&(dyn ToSql + Sync); 3] = [&id, &from, &to];
        let (minutes, gaps) = (self.query(MINUTES, &range).await?, self.query(GAPS, &range).await?);
        let mark = self.query("SELECT t FROM lafet_mark WHERE name = 'sparse'", &[]).await?;
        let minute = |row: &PgRow| (time(row, 0), [row.get(1), row.get(2), row.get(3)]);
        let minutes: Vec<_> = minutes.iter().map(minute).collect();
        let gaps: Vec<u64> = gaps.iter().map(|row| time(row, 0)).collect();
        Ok(pieces(series, &minutes, &gaps, mark.first().map_or(0, |row| time(row, 0))))
    }

    /// Like the same method of the SQLite history.
    pub async fn changes(
        &self,
        monitor: &str,
        (from_ms, to_ms): (u64, u64),
        held: bool,
    ) -> Result<Vec<Change>, StoreError> {
        let (from, to) = (signed(from_ms), signed(to_ms));
        let rows = match held {
            true => self.query(HELD, &[&monitor, &from]).await?,
            false => self.query(CHANGES, &[&monitor, &from, &to]).await?,
        };
        Ok(rows.iter().map(|row| (row.get(0), time(row, 1), row.get(2))).collect())
    }

    /// Like the same method of the SQLite history.
    pub async fn alarms(
        &self,
        monitor: Option<&str>,
        (from_ms, to_ms): (u64, u64),
        limit: u32,
    ) -> Result<Vec<AlarmChange>, StoreError> {
        let (from, to) = (signed(from_ms), signed(to_ms));
        let query = "SELECT at_ms, id, before, after, by, reason FROM lafet_alarm
            WHERE ($1::TEXT IS NULL OR monitor = $1) AND at_ms BETWEEN $2 AND $3
            ORDER BY at_ms DESC, n DESC LIMIT $4";
        let rows = self.query(query, &[&monitor, &from, &to, &i64::from(limit)]).await?;
        let row = |row: &PgRow| AlarmChange {
            at_ms: time(row, 0),
            id: row.get(1),
            from: row.get(2),
            to: row.get(3),
            user: row.get(4),
            reason: row.get(5),
        };
        Ok(rows.iter().map(row).collect())
    }
}

fn time(row: &PgRow, index: usize) -> u64 {
    row.get::<_, i64>(index).cast_unsigned()
}

/// Connects, and stores rows until every sender is gone.
async fn write(
    address: Address,
    mut queue: mpsc::Receiver<Work>,
    shared: watch::Sender<Option<Arc<Client>>>,
    figures: Arc<Figures>,
) {
    let mut waiting: VecDeque<Work> = VecDeque::new();
    let mut resumed = false;
    loop {
        match connect(&address, &mut resumed).await {
            Ok((client, reader)) => {
                let reader = Arc::new(reader);
                shared.send_replace(Some(reader.clone()));
                tracing::info!("PostgreSQL takes the history");
                let clients = (&client, &*reader);
                let ended = store(clients, &mut queue, &mut waiting, &figures).await;
                shared.send_replace(None);
                match ended {
                    Ok(()) => return,
                    Err(error) => tracing::warn!(%error, "PostgreSQL does not take the history"),
                }
            }
            Err(error) => tracing::warn!(error, "no connection to PostgreSQL"),
        }
        figures.failing.store(true, Ordering::Relaxed);
        let pause = sleep(PAUSE);
        tokio::pin!(pause);
        loop {
            tokio::select! {
                () = &mut pause => break,
                work = queue.recv() => match work {
                    Some(work) => keep(&mut waiting, work, &figures),
                    None => return,
                }
            }
        }
    }
}

/// Keeps what cannot be stored yet; the oldest gives way.
fn keep(waiting: &mut VecDeque<Work>, work: Work, figures: &Figures) {
    waiting.push_back(work);
    let mut kept: usize = waiting.iter().map(rows).sum();
    while kept > ROWS_MAX
        && let Some(old) = waiting.pop_front()
    {
        kept -= rows(&old);
        figures.lose(&old);
    }
}

/// A client that writes, whose tables are there, and one that reads: neither waits for the other.
async fn connect(address: &Address, resumed: &mut bool) -> Result<(Client, Client), String> {
    let client = address.client().await?;
    batch(&client, SESSION).await?;
    let free = timeout(PATIENCE, client.query_one(OCCUPY, &[])).await;
    let free = free.map_err(|_| StoreError::Away.to_string())?.map_err(|error| said(&error))?;
    if !free.get::<_, bool>(0) {
        return Err(IN_USE.to_owned());
    }
    batch(&client, SCHEMA).await?;
    if !*resumed {
        resume(&client).await.map_err(|error| match error {
            StoreError::Postgres(error) => said(&error),
            error => error.to_string(),
        })?;
    }
    *resumed = true;
    let reader = address.client().await?;
    batch(&reader, SESSION).await?;
    Ok((client, reader))
}

/// As [`resume`](super::series::resume) of the SQLite history. What is done twice changes nothing.
async fn resume(client: &Client) -> Result<(), StoreError> {
    run(client, MARKS, &[]).await?;
    let known = timeout(PATIENCE, client.query_one(KNOWN, &[])).await;
    let known_ms: i64 = known.map_err(|_| StoreError::Away)??.get(0);
    for until_ms in ends(known_ms) {
        run(client, END_RAW, &[&until_ms]).await?;
        run(client, END_MINUTES, &[&until_ms]).await?;
    }
    Ok(())
}

/// Executes statements; the wait is for all of them.
async fn batch(client: &Client, statements: &str) -> Result<(), String> {
    match timeout(PATIENCE, client.batch_execute(statements)).await {
        Ok(done) => done.map_err(|error| said(&error)),
        Err(_) => Err(StoreError::Away.to_string()),
    }
}

async fn store(
    (client, reader): (&Client, &Client),
    queue: &mut mpsc::Receiver<Work>,
    waiting: &mut VecDeque<Work>,
    figures: &Figures,
) -> Result<(), StoreError> {
    loop {
        while let Some(work) = waiting.pop_front() {
            let stored = put(client, &work).await;
            let rest = match stored {
                Ok(rest) => {
                    if let Work::Stored(done) = work {
                        // At the end of the hub it may wait no more.
                        _ = done.send(());
                    }
                    rest
                }
                Err(error) if matches!(work, Work::Forget(_)) => {
                    // It comes again within the hour; what is behind it is not held up.
                    tracing::warn!(%error, "old history is not removed");
                    if !is_answered(&error) {
                        return Err(error);
                    }
                    None
                }
                Err(StoreError::Postgres(error)) if error.code().is_some_and(is_for_good) => {
                    for part in refused(work, &error, figures).into_iter().rev() {
                        waiting.push_front(part);
                    }
                    None
                }
                Err(error) => {
                    waiting.push_front(work);
                    return Err(error);
                }
            };
            // Behind what has come meanwhile.
            while let Ok(work) = queue.try_recv() {
                keep(waiting, work, figures);
            }
            waiting.extend(rest);
        }
        figures.failing.store(false, Ordering::Relaxed);
        tokio::select! {
            work = queue.recv() => match work {
                Some(work) => waiting.push_back(work),
                None => return Ok(()),
            },
            // When nothing changes there is nothing to store, and nothing that fails.
            () = sleep(PAUSE) => if client.is_closed() || reader.is_closed() {
                return Err(StoreError::Away);
            },
        }
    }
}

/// Whether what was sent is at fault: a value or a text that no column takes, or a rule that it breaks. It would
/// be refused again, and hold up what comes behind it.
fn is_for_good(code: &SqlState) -> bool {
    ["22", "23"].iter().any(|class| code.code().starts_with(class))
}

/// Whether the server has said that: it can be asked another thing.
fn is_answered(error: &StoreError) -> bool {
    matches!(error, StoreError::Postgres(error) if error.code().is_some())
}

/// What is put in the place of something refused for good: of rows the halves, until the one at fault is alone;
/// of that one, that its value is not known.
fn refused(work: Work, error: &tokio_postgres::Error, figures: &Figures) -> Vec<Work> {
    let Work::Rows(mut rows) = work else {
        figures.lost.fetch_add(1, Ordering::Relaxed);
        tracing::warn!(error = said(error), "PostgreSQL refuses a change of an alarm");
        return Vec::new();
    };
    if rows.len() > 1 {
        let second = rows.split_off(rows.len() / 2);
        return vec![Work::Rows(rows), Work::Rows(second)];
    }
    let row = rows.pop();
    tracing::warn!(error = said(error), ?row, "PostgreSQL refuses a row");
    let Some(unknown) = row.and_then(unknown) else { return Vec::new() };
    figures.lost.fetch_add(1, Ordering::Relaxed);
    vec![Work::Rows(vec![unknown])]
}

/// That the value of a row is not known.
fn unknown(row: Row) -> Option<Row> {
    match row {
        Row::Raw(key, at_ms, Some(_)) => Some(Row::Raw(key, at_ms, None)),
        Row::Minute(key, at_ms, _) => Some(Row::Gap(key, at_ms)),
        Row::Raw(..) | Row::Gap(..) | Row::Known(_) => None,
    }
}

/// What PostgreSQL says, with its reasons: an error of its own names the kind alone.
pub fn said(error: &tokio_postgres::Error) -> String {
    let mut text = error.to_string();
    let mut reason = std::error::Error::source(error);
    while let Some(why) = reason {
        text = format!("{text}: {why}");
        reason = why.source();
    }
    text
}

const fn rows(work: &Work) -> usize {
    match work {
        Work::Rows(rows) => rows.len(),
        Work::Alarm(..) | Work::Forget(_) => 1,
        Work::Stored(_) => 0,
    }
}

/// Stores something; what is left of it.
async fn put(client: &Client, work: &Work) -> Result<Option<Work>, StoreError> {
    match work {
        Work::Rows(rows) => put_rows(client, rows).await.map(|()| None),
        Work::Alarm(at_ms, texts) => {
            let at = signed(*at_ms);
            let [id, monitor, before, after, by, reason, event] = &**texts;
            // Where the answer was lost, it is stored already.
            let query = "INSERT INTO lafet_alarm
                (at_ms, id, monitor, before, after, by, reason, event)
                VALUES ($1, $2, $3, $4, $5, $6, $7, $8) ON CONFLICT (event) DO NOTHING";
            let values: [&(dyn ToSql + Sync); 8] =
                [&at, id, monitor, before, after, by, reason, event];
            run(client, query, &values).await.map(|_| None)
        }
        Work::Forget(sweep) => Ok(forget(client, *sweep).await?.map(Work::Forget)),
        Work::Stored(_) => Ok(None),
    }
}

/// Executes a statement; how many rows it has changed.
async fn run(
    client: &Client,
    query: &str,
    values: &[&(dyn ToSql + Sync)],
) -> Result<u64, StoreError> {
    let done = timeout(PATIENCE, client.execute(query, values)).await;
    Ok(done.map_err(|_| StoreError::Away)??)
}

/// Forgets a piece; how to go on, if it was not the last.
async fn forget(client: &Client, mut sweep: Sweep) -> Result<Option<Sweep>, StoreError> {
    let query = "SELECT id FROM lafet_series WHERE id > $1::BIGINT ORDER BY id LIMIT $2";
    let series = timeout(PATIENCE, client.query(query, &[&sweep.done, &FORGET_SERIES])).await;
    let series = series.map_err(|_| StoreError::Away)??;
    let series: Vec<i32> = series.iter().map(|row| row.get(0)).collect();
    let mut full = false;
    let tables = ["lafet_raw", "lafet_minute", "lafet_gap"];
    for (table, before) in tables.into_iter().zip([sweep.raw, sweep.minute, sweep.minute]) {
        let query = format!(
            "DELETE FROM {table} WHERE ctid = ANY (ARRAY(SELECT ctid FROM {table}
             WHERE series = ANY ($1) AND t < $2 LIMIT $3))"
        );
        let removed = run(client, &query, &[&series, &before, &FORGET_ROWS]).await?;
        full |= removed.cast_signed() == FORGET_ROWS;
    }
    let query = "DELETE FROM lafet_alarm WHERE n = ANY (ARRAY(SELECT n FROM lafet_alarm
        WHERE at_ms < $1 ORDER BY at_ms LIMIT $2))";
    let alarms = run(client, query, &[&sweep.minute, &FORGET_ROWS]).await?;
    let last = series.len() < FORGET_SERIES as usize && alarms.cast_signed() < FORGET_ROWS;
    if !full {
        sweep.done = series.last().map_or(sweep.done, |id| i64::from(*id));
    }
    Ok((full || !last).then_some(sweep))
}

/// Columns of rows, as PostgreSQL unnests them.
#[derive(Default)]
struct Columns {
    monitors: Vec<String>,
    names: Vec<String>,
    times: Vec<i64>,
    values: [Vec<Option<f64>>; 3],
}

async fn put_rows(client: &Client, rows: &[Row]) -> Result<(), StoreError> {
    // One statement must not touch a row twice; the last one is right.
    let (mut raw, mut minute, mut gap) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    let mut known = None;
    for row in rows {
        match row {
            Row::Raw(key, t, value) => {
                raw.insert((&**key, signed(*t)), [*value, None, None]);
            }
            Row::Minute(key, t, figures) => {
                minute.insert((&**key, signed(*t)), figures.map(Some));
            }
            Row::Gap(key, t) => _ = gap.insert((&**key, signed(*t)), [None; 3]),
            Row::Known(t) => known = Some(signed(*t)),
        }
    }
    let columns = |rows: BTreeMap<(&Key, i64), [Option<f64>; 3]>| {
        let mut columns = Columns::default();
        for ((key, t), values) in rows {
            columns.monitors.push(key.monitor.clone());
            columns.names.push(key.series.clone());
            columns.times.push(t);
            for (column, value) in columns.values.iter_mut().zip(values) {
                column.push(value);
            }
        }
        columns
    };
    let (raw, minute, gap) = (columns(raw), columns(minute), columns(gap));
    for of in [&raw, &minute, &gap] {
        let query = "INSERT INTO lafet_series (monitor, name)
            SELECT DISTINCT m, n FROM UNNEST($1::TEXT[], $2::TEXT[]) AS u (m, n)
            ON CONFLICT DO NOTHING";
        run(client, query, &[&of.monitors, &of.names]).await?;
    }
    let query = "INSERT INTO lafet_raw (series, t, value)
        SELECT s.id, t, v FROM UNNEST($1::TEXT[], $2::TEXT[], $3::BIGINT[], $4::FLOAT8[])
        AS u (m, n, t, v) JOIN lafet_series AS s ON s.monitor = m AND s.name = n
        ON CONFLICT (series, t) DO UPDATE SET value = EXCLUDED.value";
    let [values, ..] = &raw.values;
    run(client, query, &[&raw.monitors, &raw.names, &raw.times, values]).await?;
    let query = "INSERT INTO lafet_minute (series, t, mean, least, most)
        SELECT s.id, t, a, b, c FROM
        UNNEST($1::TEXT[], $2::TEXT[], $3::BIGINT[], $4::FLOAT8[], $5::FLOAT8[], $6::FLOAT8[])
        AS u (m, n, t, a, b, c) JOIN lafet_series AS s ON s.monitor = m AND s.name = n
        ON CONFLICT (series, t) DO UPDATE
        SET mean = EXCLUDED.mean, least = EXCLUDED.least, most = EXCLUDED.most";
    let [mean, least, most] = &minute.values;
    let values: [&(dyn ToSql + Sync); 6] =
        [&minute.monitors, &minute.names, &minute.times, mean, least, most];
    run(client, query, &values).await?;
    let query = "INSERT INTO lafet_gap (series, t)
        SELECT s.id, t FROM UNNEST($1::TEXT[], $2::TEXT[], $3::BIGINT[])
        AS u (m, n, t) JOIN lafet_series AS s ON s.monitor = m AND s.name = n
        ON CONFLICT DO NOTHING";
    run(client, query, &[&gap.monitors, &gap.names, &gap.times]).await?;
    // Last: until then values are known only if what came before is stored.
    if let Some(known) = known {
        let query = "INSERT INTO lafet_mark VALUES ('known', $1)
            ON CONFLICT (name) DO UPDATE SET t = EXCLUDED.t";
        run(client, query, &[&known]).await?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_waits_is_bounded_and_the_oldest_goes() {
        let (mut waiting, figures) = (VecDeque::new(), Figures::default());
        let key = Arc::new(Key { monitor: "M1".into(), series: "a".into() });
        let rows = |t| Work::Rows(vec![Row::Raw(key.clone(), t, None); 200_000]);
        (1..=3).for_each(|t| keep(&mut waiting, rows(t), &figures));
        assert_eq!((waiting.len(), figures.lost.load(Ordering::Relaxed)), (2, 200_000));
        let Some(Work::Rows(first)) = waiting.front() else { panic!("rows wait") };
        assert!(matches!(first[0], Row::Raw(_, 2, _)));
        let hole = Hole { raw_ms: Some(1), minute_ms: None };
        assert_eq!(figures.torn.take(), HashMap::from([(key, hole)]));
    }

    #[test]
    fn in_the_place_of_a_value_that_is_never_taken_comes_a_gap() {
        let key = Arc::new(Key { monitor: "M1".into(), series: "a".into() });
        assert!(matches!(unknown(Row::Raw(key.clone(), 1, Some(5.0))), Some(Row::Raw(_, 1, None))));
        assert!(matches!(unknown(Row::Minute(key.clone(), 2, [0.0; 3])), Some(Row::Gap(_, 2))));
        for row in [Row::Raw(key.clone(), 3, None), Row::Gap(key, 4), Row::Known(5)] {
            assert!(unknown(row).is_none(), "it would be refused for ever");
        }
    }
}
