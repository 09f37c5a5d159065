//! What a poll costs the hub: processor time of its process alone, while so many simulated monitors
//! in a process of their own are polled at a rate; and how many of the polls were made.
//!
//! `cargo run --release -p lafet-hub --example polls -- 100 10`; with `--clients 5` as many pages
//! look at all monitors meanwhile, from the other process. Instructions a poll:
//! `valgrind --tool=callgrind target/release/examples/polls 100 10`, less those of a run of half the
//! time (a third argument, s).

#![allow(missing_docs, dead_code, reason = "a program; it uses part of the site")]

#[path = "hub_load/client.rs"]
mod client;
#[path = "hub_load/site.rs"]
mod site;

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use lafet_hub::config::Overrides;
use lafet_hub::{Clock, Config, Hub, Server};
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};

pub type Fallible<T> = Result<T, Box<dyn std::error::Error + Send + Sync>>;

/// The first argument of the process that simulates.
const SIMULATE: &str = "--simulate";
/// The end of what that prints.
const END: &str = "# end";
/// A second of `/proc/self/stat`.
const TICKS_PER_S: f64 = 100.0;
/// Requests for `/metrics` that are measured, and how often they come.
const ASKED: u32 = 50;
const ASKED_EVERY: Duration = Duration::from_millis(100);
/// Until limits and parameters of all monitors are read.
const SETTLING: Duration = Duration::from_secs(5);

#[tokio::main]
async fn main() -> Fallible<()> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.first().is_some_and(|it| it == SIMULATE) {
        return simulate(arguments[1].parse()?, arguments[2].parse()?, arguments[3].parse()?).await;
    }
    let mut clients = "0".to_owned();
    if let Some(at) = arguments.iter().position(|it| it == "--clients") {
        clients = arguments.drain(at..at + 2).nth(1).unwrap_or_default();
    }
    let number = |at: usize, or: f64| arguments.get(at).map_or(Ok(or), |it| it.parse());
    let (monitors, hertz, seconds) = (number(0, 100.0)?, number(1, 10.0)?, number(2, 10.0)?);
    let poll_ms = (1000.0 / hertz) as u64;

    let mut simulators = Command::new(std::env::current_exe()?)
        .args([SIMULATE, &monitors.to_string(), &poll_ms.to_string(), &clients])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let printed = BufReader::new(simulators.stdout.take().ok_or("no output")?).lines();
    let text: Vec<String> = printed
        .take_while(|it| it.as_deref().is_ok_and(|it| it != END))
        .collect::<Result<_, _>>()?;
    let folder = std::env::temp_dir().join(format!("lafet-polls-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    // Recordings as they are kept without a word in the configuration.
    let text = text.join("\n").replace("[recording]\nalarms = false\n", "");
    let config = Config::parse("hub.toml", &text, &folder, &Overrides::default());
    let hub = Hub::new(config.map_err(|it| format!("{it:?}"))?, Clock::System, json!({}))?;
    let server = Server::bind(hub.clone()).await?;
    let place = server.address()?.to_string();
    writeln!(simulators.stdin.as_mut().ok_or("no input")?, "{place}")?;
    let (end, ending) = tokio::sync::oneshot::channel::<()>();
    let serving = tokio::spawn(server.serve(async { _ = ending.await }));
    let mut ticks = tokio::time::interval(Duration::from_millis(100));
    while !hub.stations().iter().all(|station| station.health() == "up") {
        ticks.tick().await;
    }
    tokio::time::sleep(SETTLING).await;

    let (before, start) = ((polls(&hub), processor()?), Instant::now());
    let (mut late, until) = (0_usize, start + Duration::from_secs_f64(seconds));
    while Instant::now() < until {
        ticks.tick().await;
        late = late.max(hub.stations().iter().filter(|it| it.health() != "up").count());
    }
    let (took, polls, after) =
        (start.elapsed().as_secs_f64(), polls(&hub) - before.0, processor()?);
    let each = |index: usize| (after[index] - before.1[index]) / TICKS_PER_S / polls as f64 * 1e6;
    let wanted = monitors * hertz * took;
    println!(
        "{monitors} monitors at {hertz} Hz, {clients} clients: {polls} polls in {took:.1} s ({:.1} % of those wanted, at most {late} monitors \
         stale); {:.1} µs of processor a poll (user {:.1}, system {:.1})",
        polls as f64 / wanted * 100.0,
        each(0) + each(1),
        each(0),
        each(1),
    );
    for coding in ["identity", "gzip"] {
        println!("{}", metrics(&place, coding).await?);
    }
    _ = end.send(());
    serving.await?;
    simulators.kill()?;
    simulators.wait()?;
    Ok(std::fs::remove_dir_all(&folder)?)
}

/// What a whole request for `/metrics` costs the processor, alarms, HTTP and packing included: what this
/// process uses while they are asked for, less what it uses without them.
async fn metrics(place: &str, coding: &str) -> Fallible<String> {
    let all = || processor().map(|it| (it[0] + it[1]) / TICKS_PER_S * 1e3);
    let (before, start) = (all()?, Instant::now());
    tokio::time::sleep(SETTLING).await;
    let rest = (all()? - before) / start.elapsed().as_secs_f64();
    let (before, start, mut size) = (all()?, Instant::now(), 0);
    let mut ticks = tokio::time::interval(ASKED_EVERY);
    for _ in 0..ASKED {
        ticks.tick().await;
        let mut stream = tokio::net::TcpStream::connect(place).await?;
        let request = format!(
            "GET /metrics HTTP/1.1\r\nHost: {place}\r\nConnection: close\r\n\
             Accept-Encoding: {coding}\r\n\r\n"
        );
        stream.write_all(request.as_bytes()).await?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).await?;
        if !answer.starts_with(b"HTTP/1.1 200") {
            return Err(String::from_utf8_lossy(&answer).into());
        }
        size = answer.len();
    }
    let each = (all()? - before - rest * start.elapsed().as_secs_f64()) / f64::from(ASKED);
    Ok(format!("/metrics, {coding}: {size} bytes, {each:.1} ms of processor each"))
}

/// Monitors, and pages that look at all of them, until the input ends.
async fn simulate(monitors: usize, poll_ms: u64, clients: usize) -> Fallible<()> {
    let site = site::Site::start(monitors);
    println!("{}{END}", site.config(poll_ms));
    let mut place = String::new();
    std::io::stdin().read_line(&mut place)?;
    for _ in 0..clients {
        let page = client::Socket::open(place.trim()).await?;
        tokio::spawn(page.read_on(&COUNT));
    }
    std::future::pending().await
}

static COUNT: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);

fn polls(hub: &Hub) -> u64 {
    hub.counts().polls.load(std::sync::atomic::Ordering::Relaxed)
}

/// What this process has used of processors, by itself and in the system, ticks.
fn processor() -> Fallible<[f64; 2]> {
    let text = std::fs::read_to_string("/proc/self/stat")?;
    let fields = text.rsplit(") ").next().ok_or("no fields")?;
    let field = |index: usize| fields.split(' ').nth(index).ok_or("a field is missing");
    Ok([field(11)?.parse()?, field(12)?.parse()?])
}
