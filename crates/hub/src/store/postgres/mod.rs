//! The history in PostgreSQL: written by a thread of its own, which waits when the server is away.

mod address;
mod verify;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use serde_json::{Value, json};
use tokio::sync::{mpsc, watch};
use tokio::time::{sleep, timeout};
use tokio_postgres::types::ToSql;
use tokio_postgres::{Client, Row as PgRow};

pub use address::Address;

use super::db::{StoreError, said};
use super::history::{Change, DAY_MS, Row, signed};

/// What waits for the server: pieces of a second each.
const QUEUE_MAX: usize = 256;
/// Rows that wait while it is away; the oldest are lost then.
const ROWS_MAX: usize = 500_000;
/// Pause between attempts to connect, and the longest wait for the server.
const PAUSE: Duration = Duration::from_secs(1);
const PATIENCE: Duration = Duration::from_secs(10);

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
CREATE TABLE IF NOT EXISTS lafet_alarm (
  n BIGSERIAL PRIMARY KEY, at_ms BIGINT NOT NULL, id TEXT NOT NULL, monitor TEXT NOT NULL,
  before TEXT NOT NULL, after TEXT NOT NULL, by TEXT, reason TEXT);
CREATE INDEX IF NOT EXISTS lafet_alarm_by_time ON lafet_alarm (at_ms);";

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
}

/// What is to be stored.
#[derive(Debug)]
pub enum Work {
    /// Values.
    Rows(Vec<Row>),
    /// What an alarm did: when; id, monitor, before, after, by, reason.
    Alarm(u64, Box<[Option<String>; 6]>),
    /// What is older than these times is forgotten: changes, minutes.
    Forget(i64, i64),
}

impl Work {
    const fn rows(&self) -> usize {
        match self {
            Self::Rows(rows) => rows.len(),
            _ => 1,
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

    /// Stores something when the server can; `false`: it was not taken.
    pub fn post(&self, work: Work) -> bool {
        let rows = work.rows() as u64;
        let taken = self.work.try_send(work).is_ok();
        if !taken {
            self.figures.lost.fetch_add(rows, Ordering::Relaxed);
        }
        taken
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

    /// As the SQLite history's.
    pub async fn values(
        &self,
        monitor: &str,
        series: &str,
        (from_ms, to_ms): (u64, u64),
        minutes: bool,
    ) -> Result<Vec<Vec<Value>>, StoreError> {
        let (from, to) = (signed(from_ms), signed(to_ms));
        let values: [&(dyn ToSql + Sync); 4] = [&monitor, &series, &from, &to];
        let query = if minutes {
            "SELECT t, mean, least, most FROM lafet_minute JOIN lafet_series ON id = series
             WHERE monitor = $1 AND name = $2 AND t BETWEEN $3 AND $4 ORDER BY t"
        } else {
            "SELECT t, value FROM lafet_raw AS raw JOIN lafet_series ON id = series
             WHERE monitor = $1 AND name = $2 AND t <= $4 AND t >= COALESCE(
               (SELECT MAX(t) FROM lafet_raw AS before WHERE before.series = raw.series AND t <= $3), $3)
             ORDER BY t"
        };
        let columns = if minutes { 4 } else { 2 };
        let row = |row: PgRow| {
            let mut cells = vec![json!(row.get::<_, i64>(0))];
            cells.extend((1..columns).map(|it| json!(row.get::<_, Option<f64>>(it))));
            cells
        };
        Ok(self.query(query, &values).await?.into_iter().map(row).collect())
    }

    /// As the SQLite history's.
    pub async fn changes(
        &self,
        monitor: &str,
        (from_ms, to_ms): (u64, u64),
        held: bool,
    ) -> Result<Vec<Change>, StoreError> {
        let (from, to) = (signed(from_ms), signed(to_ms));
        let rows = if held {
            let query = "SELECT DISTINCT ON (name) name, t, value FROM lafet_raw
                JOIN lafet_series ON id = series WHERE monitor = $1 AND t <= $2
                ORDER BY name, t DESC";
            self.query(query, &[&monitor, &from]).await?
        } else {
            let query = "SELECT name, t, value FROM lafet_raw JOIN lafet_series ON id = series
                WHERE monitor = $1 AND t > $2 AND t <= $3 ORDER BY t";
            self.query(query, &[&monitor, &from, &to]).await?
        };
        let change = |row: PgRow| (row.get(0), row.get::<_, i64>(1).cast_unsigned(), row.get(2));
        Ok(rows.into_iter().map(change).collect())
    }

    /// As the SQLite history's.
    pub async fn alarms(
        &self,
        monitor: Option<&str>,
        (from_ms, to_ms): (u64, u64),
        limit: u32,
    ) -> Result<Vec<Value>, StoreError> {
        let (from, to) = (signed(from_ms), signed(to_ms));
        let query = "SELECT at_ms, id, before, after, by, reason FROM lafet_alarm
            WHERE ($1::TEXT IS NULL OR monitor = $1) AND at_ms BETWEEN $2 AND $3
            ORDER BY at_ms DESC, n DESC LIMIT $4";
        let rows = self.query(query, &[&monitor, &from, &to, &i64::from(limit)]).await?;
        let row = |row: PgRow| {
            let text = |index| row.get::<_, Option<String>>(index);
            json!({
                "at_ms": row.get::<_, i64>(0), "id": text(1), "from": text(2), "to": text(3),
                "user": text(4), "reason": text(5),
            })
        };
        Ok(rows.into_iter().map(row).collect())
    }
}

/// Connects, and stores what comes, until nobody has anything more to store.
async fn write(
    address: Address,
    mut queue: mpsc::Receiver<Work>,
    shared: watch::Sender<Option<Arc<Client>>>,
    figures: Arc<Figures>,
) {
    let mut waiting: VecDeque<Work> = VecDeque::new();
    loop {
        match connect(&address).await {
            Ok(client) => {
                let client = Arc::new(client);
                shared.send_replace(Some(client.clone()));
                tracing::info!("PostgreSQL takes the history");
                let ended = store(&client, &mut queue, &mut waiting, &figures).await;
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
    let mut rows: usize = waiting.iter().map(Work::rows).sum();
    while rows > ROWS_MAX
        && let Some(old) = waiting.pop_front()
    {
        rows -= old.rows();
        figures.lost.fetch_add(old.rows() as u64, Ordering::Relaxed);
    }
}

/// A client whose tables are there.
async fn connect(address: &Address) -> Result<Client, String> {
    let client = address.client().await?;
    match timeout(PATIENCE, client.batch_execute(SCHEMA)).await {
        Ok(made) => made.map(|()| client).map_err(|error| said(&error)),
        Err(_) => Err(StoreError::Away.to_string()),
    }
}

async fn store(
    client: &Client,
    queue: &mut mpsc::Receiver<Work>,
    waiting: &mut VecDeque<Work>,
    figures: &Figures,
) -> Result<(), StoreError> {
    loop {
        while let Some(work) = waiting.front() {
            timeout(PATIENCE, put(client, work)).await.map_err(|_| StoreError::Away)??;
            waiting.pop_front();
        }
        figures.failing.store(false, Ordering::Relaxed);
        tokio::select! {
            work = queue.recv() => match work {
                Some(work) => waiting.push_back(work),
                None => return Ok(()),
            },
            // When nothing changes there is nothing to store, and nothing that fails.
            () = sleep(PAUSE) => if client.is_closed() {
                return Err(StoreError::Away);
            },
        }
    }
}

async fn put(client: &Client, work: &Work) -> Result<(), tokio_postgres::Error> {
    match work {
        Work::Rows(rows) => put_rows(client, rows).await,
        Work::Alarm(at_ms, texts) => {
            let at = signed(*at_ms);
            let [id, monitor, before, after, by, reason] = &**texts;
            let query = "INSERT INTO lafet_alarm (at_ms, id, monitor, before, after, by, reason)
                VALUES ($1, $2, $3, $4, $5, $6, $7)";
            client.execute(query, &[&at, id, monitor, before, after, by, reason]).await.map(|_| ())
        }
        Work::Forget(raw, minute) => {
            client.execute("DELETE FROM lafet_raw WHERE t < $1", &[raw]).await?;
            client.execute("DELETE FROM lafet_minute WHERE t < $1", &[minute]).await?;
            client.execute("DELETE FROM lafet_alarm WHERE at_ms < $1", &[minute]).await?;
            tracing::debug!(days = (minute - raw) / signed(DAY_MS), "old history is removed");
            Ok(())
        }
    }
}

/// Columns of rows, as PostgreSQL unnests them.
#[derive(Default)]
struct Columns {
    monitors: Vec<String>,
    names: Vec<String>,
    times: Vec<i64>,
    values: [Vec<Option<f64>>; 3],
}

async fn put_rows(client: &Client, rows: &[Row]) -> Result<(), tokio_postgres::Error> {
    // One statement must not touch a row twice; the last one is right.
    let (mut raw, mut minute) = (BTreeMap::new(), BTreeMap::new());
    for row in rows {
        match row {
            Row::Raw(monitor, series, t, value) => {
                raw.insert((monitor, series, signed(*t)), [*value, None, None]);
            }
            Row::Minute(monitor, series, t, figures) => {
                minute.insert((monitor, series, signed(*t)), figures.map(Some));
            }
        }
    }
    let columns = |rows: BTreeMap<(&String, &String, i64), [Option<f64>; 3]>| {
        let mut columns = Columns::default();
        for ((monitor, name, t), values) in rows {
            columns.monitors.push(monitor.clone());
            columns.names.push(name.clone());
            columns.times.push(t);
            for (column, value) in columns.values.iter_mut().zip(values) {
                column.push(value);
            }
        }
        columns
    };
    let (raw, minute) = (columns(raw), columns(minute));
    for of in [&raw, &minute] {
        let query = "INSERT INTO lafet_series (monitor, name)
            SELECT DISTINCT m, n FROM UNNEST($1::TEXT[], $2::TEXT[]) AS u (m, n)
            ON CONFLICT DO NOTHING";
        client.execute(query, &[&of.monitors, &of.names]).await?;
    }
    let query = "INSERT INTO lafet_raw (series, t, value)
        SELECT s.id, t, v FROM UNNEST($1::TEXT[], $2::TEXT[], $3::BIGINT[], $4::FLOAT8[])
        AS u (m, n, t, v) JOIN lafet_series AS s ON s.monitor = m AND s.name = n
        ON CONFLICT (series, t) DO UPDATE SET value = EXCLUDED.value";
    let [values, ..] = &raw.values;
    client.execute(query, &[&raw.monitors, &raw.names, &raw.times, values]).await?;
    let query = "INSERT INTO lafet_minute (series, t, mean, least, most)
        SELECT s.id, t, a, b, c FROM
        UNNEST($1::TEXT[], $2::TEXT[], $3::BIGINT[], $4::FLOAT8[], $5::FLOAT8[], $6::FLOAT8[])
        AS u (m, n, t, a, b, c) JOIN lafet_series AS s ON s.monitor = m AND s.name = n
        ON CONFLICT (series, t) DO UPDATE
        SET mean = EXCLUDED.mean, least = EXCLUDED.least, most = EXCLUDED.most";
    let [mean, least, most] = &minute.values;
    let values: [&(dyn ToSql + Sync); 6] =
        [&minute.monitors, &minute.names, &minute.times, mean, least, most];
    client.execute(query, &values).await.map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_waits_is_bounded_and_the_oldest_goes() {
        let (mut waiting, figures) = (VecDeque::new(), Figures::default());
        let rows = |t| Work::Rows(vec![Row::Raw("M1".into(), "a".into(), t, None); 200_000]);
        (1..=3).for_each(|t| keep(&mut waiting, rows(t), &figures));
        assert_eq!((waiting.len(), figures.lost.load(Ordering::Relaxed)), (2, 200_000));
        let Some(Work::Rows(first)) = waiting.front() else { panic!("rows wait") };
        assert!(matches!(first[0], Row::Raw(_, _, 2, _)));
    }
}
