//! A hub that is killed again and again, at any moment, while commands are answered.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use lafet_sim::rng::Rng;
use serde_json::json;
use tokio::time::sleep;

use crate::Fallible;
use crate::client::{Socket, get, get_json};
use crate::hub::Hub;
use crate::trouble::below;

/// Clients that command at the same time.
const CLIENTS: usize = 4;
/// It is killed so long after its start at the latest, ms.
const LATEST_MS: u64 = 1500;

/// Numbers of entries that answers have reported.
type Told = Arc<Mutex<BTreeSet<u64>>>;

/// Kills it so many times; what came of it.
pub async fn run(lafet: &Path, config: &Path, kills: usize) -> Fallible<String> {
    let (told, mut rng) = (Told::default(), Rng::new(7));
    for _ in 0..kills {
        let hub = Hub::start(lafet, config)?;
        let clients = (0..CLIENTS).map(|_| tokio::spawn(command(hub.place.clone(), told.clone())));
        let clients: Vec<_> = clients.collect();
        sleep(Duration::from_millis(below(&mut rng, LATEST_MS))).await;
        hub.kill()?;
        for client in clients {
            // It ends with the connection.
            _ = client.await;
        }
    }
    let hub = Hub::start(lafet, config)?;
    let text = get(&hub.place, "/api/audit/export").await?;
    let numbers = text
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok()?["n"].as_u64());
    let numbers: BTreeSet<u64> = numbers.collect();
    let verified = get_json(&hub.place, "/api/audit/verify").await?;
    let told = told.lock().unwrap_or_else(PoisonError::into_inner);
    let missing = told.difference(&numbers).count();
    let whole = verified["ok"] == true;
    let chain = if whole { "whole" } else { "broken" };
    let text = format!(
        "kill -9, {kills} times: {missing} of {} entries that were reported are missing, chain {chain}",
        told.len()
    );
    if whole && missing == 0 && !told.is_empty() { Ok(text) } else { Err(text.into()) }
}

async fn command(place: String, told: Told) -> Fallible<()> {
    let mut socket = Socket::open(&place).await?;
    loop {
        let answer = socket.request(json!({ "type": "stop", "monitor": "M1" })).await?;
        let number = answer["result"]["audit"].as_u64().or(answer["error"]["audit"].as_u64());
        if let Some(number) = number {
            told.lock().unwrap_or_else(PoisonError::into_inner).insert(number);
        }
    }
}
