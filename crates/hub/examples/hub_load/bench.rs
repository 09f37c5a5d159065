//! What the hub can do: commands, clients, monitors. Prints sections for docs/performance.md.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use lafet_hub::Clock;
use serde_json::{Value, json};
use tokio::task::JoinSet;
use tokio::time::sleep;

use crate::Fallible;
use crate::client::{Socket, get_json};
use crate::figures::Figures;
use crate::hub::{Hub, Used};
use crate::site::Site;

/// How long something is measured.
const TIME: Duration = Duration::from_secs(10);
/// Before that, so that what begins is over.
const SETTLE: Duration = Duration::from_secs(3);
/// Ten polls a second.
const POLL_MS: u64 = 100;
/// Starts of the demo.
const STARTS: usize = 10;
const CLIENTS: [usize; 3] = [1, 100, 1000];
const MONITORS: [usize; 3] = [1, 10, 100];

pub async fn run(lafet: PathBuf, folder: PathBuf) -> Fallible<()> {
    std::fs::create_dir_all(&folder)?;
    first_view(&lafet).await?;
    commands(&lafet, &folder).await?;
    fan_out(&lafet, &folder).await?;
    monitors(&lafet, &folder).await?;
    Ok(std::fs::remove_dir_all(&folder)?)
}

/// From the start of the demo to what a browser shows first.
async fn first_view(lafet: &Path) -> Fallible<()> {
    let mut all: [Vec<f64>; 3] = Default::default();
    for _ in 0..STARTS {
        let began = Instant::now();
        let mut note = |index: usize| all[index].push(began.elapsed().as_secs_f64() * 1000.0);
        let hub = Hub::demo(lafet)?;
        note(0);
        let mut socket = Socket::open(&hub.place).await?;
        note(1);
        while !socket.next().await?.contains("\"at_ms\":1") {}
        note(2);
    }
    let mut table = String::from(
        "| `lafet demo`, ms from its start | p50 | p99 | most |\n|---|---:|---:|---:|\n",
    );
    let names = [
        "it prints its address",
        "a browser is connected",
        "the first state of a monitor is there",
    ];
    for (name, times) in names.into_iter().zip(all) {
        table += &format!("| {name} | {} |\n", Figures::new(times).cells());
    }
    println!("== hub-start\n{table}");
    Ok(())
}

/// A hub with so many monitors, all of which answer.
async fn open(lafet: &Path, folder: &Path, monitors: usize) -> Fallible<(Hub, Site)> {
    let site = Site::start(monitors);
    let own = folder.join(format!("{monitors}"));
    std::fs::create_dir_all(&own)?;
    let config = own.join("hub.toml");
    std::fs::write(&config, site.config(POLL_MS))?;
    let hub = Hub::start(lafet, &config)?;
    loop {
        let health = get_json(&hub.place, "/health").await?;
        let all = health["monitors"].as_object().into_iter().flatten();
        if all.filter(|(_, it)| **it == "up").count() == monitors {
            break;
        }
        sleep(Duration::from_millis(100)).await;
    }
    sleep(SETTLE).await;
    Ok((hub, site))
}

/// What was used in a second, and the memory at the end.
async fn used(hub: &Hub) -> Fallible<Used> {
    let (before, began) = (hub.used()?, Instant::now());
    sleep(TIME).await;
    let after = hub.used()?;
    let cpu_s = (after.cpu_s - before.cpu_s) / began.elapsed().as_secs_f64();
    Ok(Used { cpu_s, ..after })
}

async fn commands(lafet: &Path, folder: &Path) -> Fallible<()> {
    let (hub, _site) = open(lafet, folder, 3).await?;
    let mut table = String::from(
        "| | commands a second | answered within, ms: p50 | p99 | most | processor, ms a command |\n\
         |---|---:|---:|---:|---:|---:|\n",
    );
    for (name, outstanding) in [("one after the other", 1), ("32 at a time", 32)] {
        let mut socket = Socket::open(&hub.place).await?;
        let (mut times, began, before) = (Vec::new(), Instant::now(), hub.used()?.cpu_s);
        while began.elapsed() < TIME {
            let asked = Instant::now();
            let mut last = 0;
            for number in 0..outstanding {
                let monitor = format!("M{}", number % 3 + 1);
                last = socket.ask(json!({ "type": "stop", "monitor": monitor })).await?;
            }
            let mut open = outstanding;
            while open > 0 {
                let answer = answered(&mut socket, last + 1 - outstanding).await?;
                if answer["result"]["ok"] != true {
                    return Err(format!("{answer}").into());
                }
                open -= 1;
                times.push(asked.elapsed().as_secs_f64() * 1000.0);
            }
        }
        let (over_s, figures) = (began.elapsed().as_secs_f64(), Figures::new(times));
        let cpu_ms = (hub.used()?.cpu_s - before) * 1000.0 / figures.count() as f64;
        table += &format!(
            "| {name} | {:.0} | {} | {cpu_ms:.2} |\n",
            figures.count() as f64 / over_s,
            figures.cells(),
        );
    }
    println!("== hub-commands\n{table}");
    Ok(())
}

/// The next answer whose number is not less than this.
async fn answered(socket: &mut Socket, least: u64) -> Fallible<Value> {
    loop {
        let text = socket.next().await?;
        if text.contains("\"type\":\"answer\"") {
            let answer: Value = serde_json::from_str(&text)?;
            if answer["id"].as_u64() >= Some(least) {
                return Ok(answer);
            }
        }
    }
}

async fn fan_out(lafet: &Path, folder: &Path) -> Fallible<()> {
    let (hub, _site) = open(lafet, folder, 3).await?;
    let mut table = String::from(
        "| clients | messages a second | state of a monitor is there after, ms: p50 | p99 | most | \
         processor, % | memory, MiB | of it a client, KiB |\n\
         |---:|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    let alone_kib = hub.used()?.memory_kib;
    let (mut tasks, messages) = (JoinSet::new(), Arc::new(AtomicU64::new(0)));
    for clients in CLIENTS {
        while tasks.len() + 1 < clients {
            let (socket, messages) = (Socket::open(&hub.place).await?, messages.clone());
            tasks.spawn(async move { socket.read_on(&messages).await });
        }
        let watch = tokio::spawn(ages(hub.place.clone()));
        sleep(SETTLE).await;
        let before = messages.load(Ordering::Relaxed);
        let used = used(&hub).await?;
        let others = (messages.load(Ordering::Relaxed) - before) as f64 / TIME.as_secs_f64();
        let (own, figures) = watch.await??;
        table += &format!(
            "| {clients} | {:.0} | {} | {:.0} | {:.1} | {:.0} |\n",
            others + own,
            figures.cells(),
            used.cpu_s * 100.0,
            used.memory_kib / 1024.0,
            (used.memory_kib - alone_kib) / clients as f64,
        );
    }
    println!("== hub-clients\n{table}");
    Ok(())
}

/// Messages a second, and how old the states in them are when they come, ms: of one client.
async fn ages(place: String) -> Fallible<(f64, Figures)> {
    let mut socket = Socket::open(&place).await?;
    socket.next().await?;
    socket.next().await?;
    let (began, mut ages, mut count) = (Instant::now(), Vec::new(), 0);
    let mut seen = [0; 3];
    while began.elapsed() < SETTLE + TIME {
        let message: Value = serde_json::from_str(&socket.next().await?)?;
        let now_ms = Clock::System.now_ms();
        count += 1;
        for (number, seen) in seen.iter_mut().enumerate() {
            let status = &message["set"][format!("monitors/M{}/status", number + 1)];
            if let Some(at_ms) = status["at_ms"].as_u64().filter(|at_ms| at_ms > seen) {
                *seen = at_ms;
                ages.push(now_ms.saturating_sub(at_ms) as f64);
            }
        }
    }
    Ok((count as f64 / began.elapsed().as_secs_f64(), Figures::new(ages)))
}

async fn monitors(lafet: &Path, folder: &Path) -> Fallible<()> {
    let mut table = String::from(
        "| monitors at 10 Hz | polls a second | late by p99, ms | processor, % | memory, MiB |\n\
         |---:|---:|---:|---:|---:|\n",
    );
    let mut memory = Vec::new();
    for count in MONITORS {
        let (hub, site) = open(lafet, folder, count).await?;
        drop(site.take_polls());
        let used = used(&hub).await?;
        let polls = site.take_polls();
        let rate = polls.len() as f64 / TIME.as_secs_f64();
        let late = Figures::new(polls.into_iter().map(|it| it - POLL_MS as f64).collect());
        memory.push(used.memory_kib);
        table += &format!(
            "| {count} | {rate:.0} | {:.1} | {:.1} | {:.1} |\n",
            late.percentile(99),
            used.cpu_s * 100.0,
            used.memory_kib / 1024.0,
        );
    }
    let span = MONITORS[MONITORS.len() - 1] - MONITORS[0];
    let each = memory.last().zip(memory.first()).map(|(last, first)| (last - first) / span as f64);
    println!("== hub-monitors\n{table}\nA monitor takes {:.0} KiB.", each.unwrap_or(f64::NAN));
    Ok(())
}
