//! What a question for the history costs, whatever has been kept: makes a history of so many
//! megabytes in a temporary folder, and prints the processor time of each question.
//!
//! `cargo run --release -p lafet-hub --example history -- 100`

use std::error::Error;
use std::time::Duration;

use lafet_hub::store::{Base, History, resolution_ms};

const MINUTE_MS: u64 = 60_000;
const DAY_MS: u64 = 86_400_000;
const MONITORS: u64 = 3;
const SERIES: u64 = 40;
const TIMES: u32 = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let megabytes: u64 = std::env::args().nth(1).unwrap_or("100".into()).parse()?;
    let folder = std::env::temp_dir().join(format!("lafet-history-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let runtime = tokio::runtime::Builder::new_current_thread().build()?;
    let result = runtime.block_on(measure(&folder, megabytes));
    std::fs::remove_dir_all(&folder)?;
    result
}

async fn measure(folder: &std::path::Path, megabytes: u64) -> Result<(), Box<dyn Error>> {
    let mut history = History::open(Some(folder))?;
    let file = folder.join("history.db");
    let mut at_ms = 0;
    while std::fs::metadata(&file)?.len() < megabytes * 1_000_000 {
        for _ in 0..600 {
            at_ms += 6_000;
            for monitor in 1..=MONITORS {
                for series in 1..=SERIES {
                    let value = (at_ms / 6_000 * series % 97) as f64;
                    history.note(at_ms, &format!("M{monitor}"), &format!("s{series}"), value);
                }
            }
        }
        history.flushed().await;
    }
    let base = history.base();
    println!("{megabytes} MB: {} days of {MONITORS} monitors", at_ms / DAY_MS);
    let last = at_ms - 10 * MINUTE_MS;
    cost("the last 10 minutes of a series", || values(&base, (last, at_ms), 600)).await?;
    let month = at_ms.saturating_sub(30 * DAY_MS);
    cost("a month of a series in 600 points", || values(&base, (month, at_ms), 600)).await?;
    cost("what held of a monitor", || async {
        Ok(base.changes("M1", (last, last), true).await?.len())
    })
    .await?;
    cost("10 minutes of all series of a monitor", || async {
        Ok(base.changes("M1", (last, at_ms), false).await?.len())
    })
    .await
}

async fn values(base: &Base, range: (u64, u64), points: usize) -> Result<usize, Box<dyn Error>> {
    let resolution = (range.1 - range.0 > DAY_MS).then(|| resolution_ms(range, points));
    Ok(match base.values("M1", "s7", range, resolution, points).await? {
        lafet_hub::store::Rows::Changes(rows) => rows.len(),
        lafet_hub::store::Rows::Spans(rows) => rows.len(),
    })
}

/// Processor time of one question, of all threads, the first left out.
async fn cost<T: Future<Output = Result<usize, Box<dyn Error>>>>(
    what: &str,
    ask: impl Fn() -> T,
) -> Result<(), Box<dyn Error>> {
    let rows = ask().await?;
    let before = processor()?;
    for _ in 0..TIMES {
        ask().await?;
    }
    let each = (processor()? - before) / TIMES;
    println!("{what}: {:.2} ms of processor, {rows} rows", each.as_secs_f64() * 1e3);
    Ok(())
}

/// Processor time that this process has used, where Linux shows it.
fn processor() -> Result<Duration, Box<dyn Error>> {
    let mut all = Duration::ZERO;
    for task in std::fs::read_dir("/proc/self/task")? {
        let text = std::fs::read_to_string(task?.path().join("schedstat"))?;
        let nanos = text.split_whitespace().next().unwrap_or("0").parse()?;
        all += Duration::from_nanos(nanos);
    }
    Ok(all)
}
