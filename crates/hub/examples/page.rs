//! What the hub sends to a page: bytes a second for Operate of one monitor and for the overview, at
//! sites of so many simulated monitors, all of which are at rest or, with `--moving`, moving.
//!
//! `cargo run -p lafet-hub --example page -- 3 100`

#![allow(missing_docs, dead_code, reason = "a program; it uses part of the site")]

#[path = "hub_load/client.rs"]
mod client;
#[path = "hub_load/site.rs"]
mod site;

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use lafet_hub::config::Overrides;
use lafet_hub::{Clock, Config, Hub, Server};
use lafet_proto::SubsystemId;
use serde_json::{Value, json};
use tokio::time::{Instant, timeout_at};

use client::Socket;
use site::Site;

pub type Fallible<T> = Result<T, Box<dyn std::error::Error + Send + Sync>>;

/// As the configuration has it where it says nothing.
const POLL_MS: u64 = 200;
const FOR: Duration = Duration::from_secs(10);
/// A monitor that moves is sent the other way so often.
const TURN: Duration = Duration::from_secs(4);

#[tokio::main]
async fn main() -> Fallible<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let moving = arguments.iter().any(|it| it == "--moving");
    for count in arguments.iter().filter(|it| *it != "--moving") {
        measure(count.parse()?, moving).await?;
    }
    Ok(())
}

async fn measure(count: usize, moving: bool) -> Fallible<()> {
    let site = Site::start(count);
    let text = site.config(POLL_MS);
    let config = Config::parse("hub.toml", &text, Path::new("."), &Overrides::default());
    let mut config = config.map_err(|problems| format!("{problems:?}"))?;
    config.data = None;
    let hub = Hub::new(config, Clock::System, json!({}))?;
    let server = Server::bind(hub.clone()).await?;
    let place = server.address()?.to_string();
    let (end, ending) = tokio::sync::oneshot::channel::<()>();
    tokio::spawn(server.serve(async { _ = ending.await }));
    let mut ticks = tokio::time::interval(Duration::from_millis(100));
    while !hub.stations().iter().all(|station| station.health() == "up") {
        ticks.tick().await;
    }
    let mut page = Socket::open(&place).await?;
    if moving {
        tokio::spawn(keep_moving(Socket::open(&place).await?, count));
        while !hub.stations().iter().all(|it| it.status().is_set(SubsystemId::HORIZONTAL, "Move")) {
            ticks.tick().await;
        }
    }
    let others = if moving { "moving" } else { "at rest" };
    let pages =
        [("Overview", json!([])), ("Operate of M1", json!(["M1"])), ("all of all", Value::Null)];
    for (what, monitors) in pages {
        page.request(json!({ "type": "subscribe", "monitors": monitors })).await?;
        let bytes = bytes(&mut page).await?;
        let rate = |bytes: usize| bytes as f64 / 1e3 / FOR.as_secs_f64();
        let parts: Vec<String> =
            bytes.iter().map(|(part, bytes)| format!("{part} {:.1}", rate(*bytes))).collect();
        let all = rate(bytes.values().sum());
        println!("{count} monitors {others}, {what}: {all:.1} kB/s ({})", parts.join(", "));
    }
    drop(end);
    Ok(())
}

/// Sends every monitor to and fro, and to the other side before it has arrived.
async fn keep_moving(mut hand: Socket, count: usize) -> Fallible<()> {
    let monitors: Vec<String> = (1..=count).map(|number| format!("M{number}")).collect();
    for monitor in &monitors {
        let take = json!({ "type": "authority", "monitor": monitor, "action": "take" });
        hand.request(take).await?;
    }
    let mut ticks = tokio::time::interval(TURN / u32::try_from(count)?);
    for side in [6000, -6000].into_iter().cycle() {
        for monitor in &monitors {
            ticks.tick().await;
            let request = format!("Move Horizontal {side}");
            let moved = json!({ "type": "request", "monitor": monitor, "request": request });
            let answer = hand.request(moved).await?;
            assert_eq!(answer["result"]["ok"], true, "{answer}");
        }
    }
    Ok(())
}

/// Bytes of the topics of some time by their last part, after what comes at once.
async fn bytes(page: &mut Socket) -> Fallible<BTreeMap<String, usize>> {
    page.next().await?;
    let until = Instant::now() + FOR;
    let mut bytes = BTreeMap::new();
    while let Ok(text) = timeout_at(until, page.next()).await {
        let text = text?;
        let message: Value = serde_json::from_str(&text)?;
        let mut rest = text.len();
        for (topic, value) in message["set"].as_object().into_iter().flatten() {
            let (part, size) = (topic.rsplit('/').next().unwrap_or(topic), value.to_string().len());
            *bytes.entry(part.to_owned()).or_default() += size;
            rest -= size.min(rest);
        }
        *bytes.entry("around them".to_owned()).or_default() += rest;
    }
    Ok(bytes)
}
