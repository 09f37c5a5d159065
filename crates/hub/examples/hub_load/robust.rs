//! Everything at once, and what becomes of Stop, of the polls, and of the audit log meanwhile.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tokio::time::{sleep, timeout};

use crate::Fallible;
use crate::client::{Socket, get, get_json};
use crate::figures::Figures;
use crate::hub::Hub;
use crate::kills;
use crate::site::Site;
use crate::trouble::{self, Done, Plan};

/// Nothing that is waited for takes so long.
const PATIENCE: Duration = Duration::from_secs(60);
/// How often the monitors are polled, ms.
const POLL_MS: u64 = 100;
const MONITORS: usize = 3;

/// The goal: half of all Stops, and 99 of 100, are through within this time.
const STOP_MS: f64 = 100.0;

/// How much, how long, and within which bound.
pub struct Size {
    plan: Plan,
    /// Within which 99 of 100 Stops are through, ms.
    p99_ms: f64,
    /// Without any trouble, s.
    quiet_s: u64,
    /// With all of it: a disk that takes writes, one that does not, and again one that does, s each.
    part_s: u64,
    kills: usize,
}

pub const WHOLE: Size = Size {
    plan: Plan { idle: 1000, slow: 50, drips: 50, garbage: 4, storms: 4 },
    p99_ms: STOP_MS,
    quiet_s: 20,
    part_s: 20,
    kills: 20,
};
/// On a machine that does other things, too: of some tens of Stops the slowest is the 99th of 100, and
/// one pause of the machine is in it. The median has the same bound as in the whole.
pub const QUICK: Size = Size {
    plan: Plan { idle: 200, slow: 10, drips: 10, garbage: 2, storms: 2 },
    p99_ms: 5000.0,
    quiet_s: 3,
    part_s: 4,
    kills: 4,
};

/// What was measured in a part.
struct Part {
    name: &'static str,
    stops: Figures,
    polls: Figures,
    cpu_percent: f64,
}

/// The operator, and what was stopped.
struct Operator {
    socket: Socket,
    toward: i32,
    sent: u64,
    /// Numbers of entries that answers have reported.
    told: BTreeSet<u64>,
    /// Answers that came before their entry was on the disk.
    untold: u64,
}

pub async fn run(lafet: PathBuf, folder: PathBuf, size: &Size) -> Fallible<()> {
    let site = Site::start(MONITORS);
    let config = folder.join("hub.toml");
    std::fs::create_dir_all(&folder)?;
    std::fs::write(&config, site.config(POLL_MS))?;
    let hub = Hub::start(&lafet, &config)?;
    let mut operator = Operator::open(&hub.place).await?;
    let done = Arc::new(Done::default());
    let quiet = Duration::from_secs(size.quiet_s);
    let mut parts = vec![part("nothing else", quiet, &hub, &site, &mut operator).await?];
    let tasks = trouble::start(&hub.place, &size.plan, &done).await?;
    for (name, full) in [("all of it", false), ("and a full disk", true), ("and room again", false)]
    {
        hub.fill_disk(full)?;
        let time = Duration::from_secs(size.part_s);
        parts.push(part(name, time, &hub, &site, &mut operator).await?);
        if full {
            let waiting = waiting(&hub.place).await?;
            println!("full disk: {waiting} entries of the audit log wait");
            if waiting == 0.0 {
                return Err("the disk was not full".into());
            }
        }
    }
    let lost = audit(&hub.place, &operator).await?;
    show(&parts, size, &done);
    drop((tasks, operator));
    println!("audit log: {lost}");
    hub.kill()?;
    println!("{}", kills::run(&lafet, &config, size.kills).await?);
    std::fs::remove_dir_all(&folder)?;
    slow(&parts, size)
}

/// An error that says in which parts Stops took too long.
fn slow(parts: &[Part], size: &Size) -> Fallible<()> {
    let mut said = Vec::new();
    for (percent, bound) in [(50, STOP_MS), (99, size.p99_ms)] {
        let over = parts.iter().filter(|it| it.stops.percentile(percent) > bound);
        said.extend(over.map(|it| format!("{}: {percent} of 100 took over {bound} ms", it.name)));
    }
    if said.is_empty() { Ok(()) } else { Err(format!("slow Stops: {}", said.join("; ")).into()) }
}

impl Operator {
    async fn open(place: &str) -> Fallible<Self> {
        let began = Instant::now();
        while get_json(place, "/health").await?["monitors"]["M1"] != "up" {
            if began.elapsed() > PATIENCE {
                return Err("the monitors do not answer".into());
            }
            sleep(Duration::from_millis(50)).await;
        }
        let mut socket = Socket::open(place).await?;
        let take = json!({ "type": "authority", "monitor": "M1", "action": "take" });
        socket.request(take).await?;
        Ok(Self { socket, toward: 1, sent: 0, told: BTreeSet::new(), untold: 0 })
    }

    /// Sets the drive in motion and stops it: the time from the sending of Stop until the monitor
    /// does not command the drive any more, ms.
    async fn stop(&mut self, site: &Site) -> Fallible<f64> {
        self.toward = -self.toward;
        let request = format!("Move Horizontal {}", self.toward * 20_000);
        let moved =
            self.socket.request(json!({ "type": "request", "monitor": "M1", "request": request }));
        let moved = moved.await?;
        if moved["error"].is_object() {
            return Err(format!("{moved}").into());
        }
        until(|| site.monitor(0).still_since.is_none()).await?;
        let began = Instant::now();
        let id = self.socket.ask(json!({ "type": "stop", "monitor": "M1" })).await?;
        self.sent += 1;
        until(|| site.monitor(0).still_since.is_some()).await?;
        let still = site.monitor(0).still_since.unwrap_or(began);
        let answer = self.socket.answer(id).await?;
        match answer["result"]["audit"].as_u64() {
            Some(number) => _ = self.told.insert(number),
            None => self.untold += 1,
        }
        Ok(still.saturating_duration_since(began).as_secs_f64() * 1000.0)
    }
}

async fn until(condition: impl Fn() -> bool) -> Fallible<()> {
    let wait = async {
        while !condition() {
            sleep(Duration::from_millis(1)).await;
        }
    };
    Ok(timeout(PATIENCE, wait).await?)
}

async fn part(
    name: &'static str,
    time: Duration,
    hub: &Hub,
    site: &Site,
    operator: &mut Operator,
) -> Fallible<Part> {
    drop(site.take_polls());
    let (began, before) = (Instant::now(), hub.used()?.cpu_s);
    let mut stops = Vec::new();
    while began.elapsed() < time {
        stops.push(operator.stop(site).await?);
    }
    let cpu_percent = (hub.used()?.cpu_s - before) / began.elapsed().as_secs_f64() * 100.0;
    let late = site.take_polls().into_iter().map(|it| it - POLL_MS as f64);
    Ok(Part { name, stops: Figures::new(stops), polls: Figures::new(late.collect()), cpu_percent })
}

/// Every Stop has its entry, every number that was reported is in the log, and the chain holds.
async fn audit(place: &str, operator: &Operator) -> Fallible<String> {
    let began = Instant::now();
    // A Stop's effect is noted 2 s after it.
    sleep(Duration::from_secs(3)).await;
    while waiting(place).await? > 0.0 {
        if began.elapsed() > PATIENCE {
            return Err("entries still wait for the disk".into());
        }
        sleep(Duration::from_millis(100)).await;
    }
    let text = get(place, "/api/audit/export").await?;
    let log: Vec<Value> = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let own = |it: &&Value| it["what"] == "Stop All" && it["monitor"] == "M1" && it["via"] == "ws";
    let count =
        |outcome: &str| log.iter().filter(own).filter(|it| it["outcome"] == outcome).count() as u64;
    let (asked, effects) = (count("asked"), count("effect"));
    let all = log.iter().filter(own).count() as u64;
    let numbers: BTreeSet<u64> = log.iter().filter_map(|it| it["n"].as_u64()).collect();
    let missing = operator.told.difference(&numbers).count();
    let verified = get_json(place, "/api/audit/verify").await?;
    let Operator { sent, untold, .. } = operator;
    let text = format!(
        "{sent} Stops, {asked} entries asked, {} answered, {effects} effects; {missing} of {} numbers \
         that were told are missing, {untold} were told none; {} entries in all, chain {}",
        all - asked - effects,
        operator.told.len(),
        verified["entries"],
        if verified["ok"] == true { "whole" } else { "broken" },
    );
    let whole = asked == *sent && all == 3 * sent && missing == 0 && verified["ok"] == true;
    if whole { Ok(text) } else { Err(text.into()) }
}

/// Entries that are not on the disk.
async fn waiting(place: &str) -> Fallible<f64> {
    let text = get(place, "/metrics").await?;
    let value = text.lines().find_map(|line| line.strip_prefix("lafet_audit_waiting "));
    Ok(value.ok_or("no figure")?.parse()?)
}

fn show(parts: &[Part], size: &Size, done: &Done) {
    use std::sync::atomic::Ordering::Relaxed;
    let Plan { idle, slow, drips, garbage, storms } = &size.plan;
    println!(
        "{idle} idle WebSockets ({} messages), {slow} that never read, {drips} that drip, {garbage} × \
         garbage ({}), {storms} × reconnect storm ({})",
        done.messages.load(Relaxed),
        done.garbage.load(Relaxed),
        done.reconnects.load(Relaxed),
    );
    println!(
        "| beside | Stops | p50, ms | p99 | most | polls | late by p50, ms | p99 | most | processor, % |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for it in parts {
        println!(
            "| {} | {} | {} | {} | {} | {:.0} |",
            it.name,
            it.stops.count(),
            it.stops.cells(),
            it.polls.count(),
            it.polls.cells(),
            it.cpu_percent
        );
    }
}
