//! The hub that is flooded: a zone, a history, a recording, users and tokens, so that messages reach
//! what they are for.

use std::path::Path;
use std::time::{Duration, Instant};

use lafet_hub::Clock;
use lafet_hub::store::History;
use serde_json::{Value, json};
use tokio::time::sleep;

use crate::Fallible;
use crate::bodies::{ALARM, recording};
use crate::client::get_json;
use crate::flood::NUMBERS;
use crate::hub::Hub;
use crate::link;

/// Where it is: what the hub counts by address is not that of the floods.
const ADDRESS: &str = "127.0.0.3";
const PASSWORD: &str = "correct horse battery";
/// A day of a few series.
const HISTORY_MS: u64 = 24 * 3_600_000;
const STEP_MS: u64 = 10_000;
const PATIENCE: Duration = Duration::from_secs(20);

/// So many zones with so many monitors each. The detectors of the first are heard; those of others never report, so that
/// alarms are there.
pub fn zones(count: usize, of_each: usize) -> String {
    let mut text = String::new();
    for zone in 1..=count {
        let id = if zone == 1 { "hall".to_owned() } else { format!("hall{zone}") };
        let number = if zone == 1 { String::new() } else { zone.to_string() };
        for kind in ["flame", "heat"] {
            text += &format!(
                "[[detector]]\nid = \"{kind}{number}\"\nkind = \"{kind}\"\nzones = [\"{id}\"]\n\
                 silent_after_s = 3600\n"
            );
        }
        let its = (0..of_each).map(|it| format!("M{}", (zone - 1) * of_each + it + 1));
        let its: Vec<String> = its.collect();
        text += &format!(
            "[[zone]]\nid = \"{id}\"\nvotes = \"2oo2\"\nwater_max_s = 60\nmonitors = {its:?}\n"
        );
        for monitor in its {
            text += &format!(
                "[[aim]]\nzone = \"{id}\"\nmonitor = \"{monitor}\"\nhorizontal = 600\nvertical = 300\nnozzle = 60\n"
            );
        }
    }
    text
}

/// Tokens of a prepared hub.
pub struct Tokens {
    /// Of the operator who goes on with his work.
    pub others: String,
    /// Of the administrator who looks.
    pub watch: String,
}

/// The values of a day, as the hub would have kept them; it must not run.
pub async fn history(data: &Path) -> Fallible<()> {
    std::fs::create_dir_all(data)?;
    let mut history = History::open(Some(data))?;
    let now_ms = Clock::System.now_ms();
    for (number, at_ms) in (now_ms - HISTORY_MS..now_ms).step_by(STEP_MS as usize).enumerate() {
        for series in ["Vertical.position", "Horizontal.position", "General.pressure"] {
            history.note(at_ms, "M1", series, (number % 97) as f64);
        }
        if number % 500 == 0 {
            history.flushed().await;
        }
    }
    history.flushed().await;
    Ok(())
}

/// Makes users, tokens and recordings.
pub async fn fill(hub: &Hub, secret: &str) -> Fallible<Tokens> {
    let setup = json!({ "token": secret, "user": "anna", "password": PASSWORD });
    let (head, session) = post(&hub.place, "/api/setup", "", &setup).await?;
    let cookies = head.lines().filter_map(|line| line.strip_prefix("set-cookie: "));
    let cookie = cookies.filter_map(|it| it.split(';').next()).collect::<Vec<_>>().join("; ");
    let csrf = session["csrf"].as_str().ok_or("no session")?;
    let known = format!("Cookie: {cookie}\r\nX-CSRF-Token: {csrf}\r\n");
    let token = async |name: String, role: &str| -> Fallible<String> {
        let wanted = json!({ "name": name, "role": role });
        let made = post(&hub.place, "/api/tokens", &known, &wanted).await?.1;
        Ok(made["token"].as_str().ok_or_else(|| format!("{made}"))?.to_owned())
    };
    let tokens = Tokens {
        others: token("the others".into(), "operator").await?,
        watch: token("the watch".into(), "administrator").await?,
    };
    // Until the numbers of requests are those of tokens.
    for number in 0..NUMBERS.end {
        token(format!("spare {number}"), "observer").await?;
    }
    for user in NUMBERS.map(|it| format!("user{it}")).chain(["olga".to_owned()]) {
        let wanted = json!({ "user": user, "role": "observer", "password": PASSWORD });
        post(&hub.place, "/api/users", &known, &wanted).await?;
    }
    for name in NUMBERS.map(|it| format!("load{it}")).chain(["seed".to_owned()]) {
        let path = format!("/api/recordings/upload?name={name}");
        made(&hub.place, &path, &known, &recording()).await?;
    }
    Ok(tokens)
}

/// Waits until the monitors answer, the detectors are heard and the alarm is there.
pub async fn ready(hub: &Hub, tokens: &Tokens, monitors: usize) -> Fallible<()> {
    let known = &link::authorization(&tokens.watch);
    // The memory of a hash is kept: it is there before the floods.
    let wrong = br#"{"user":"anna","password":"wrong and long"}"#;
    let stream = link::connect_from(ADDRESS, &hub.place, None).await?;
    link::ask(stream, ("POST", "/api/login"), "", wrong).await?;
    for detector in ["flame", "heat"] {
        let path = format!("/api/detectors/{detector}");
        made(&hub.place, &path, known, br#"{"signal":"quiet"}"#).await?;
    }
    up(hub, monitors).await?;
    let began = Instant::now();
    loop {
        let stream = link::connect_from(ADDRESS, &hub.place, None).await?;
        let alarms = link::ask(stream, ("GET", "/api/alarms"), known, b"").await?.2;
        if String::from_utf8_lossy(&alarms).contains(ALARM) {
            return Ok(());
        }
        if began.elapsed() > PATIENCE {
            return Err(format!("no {ALARM}: {}", String::from_utf8_lossy(&alarms)).into());
        }
        sleep(Duration::from_millis(50)).await;
    }
}

/// Waits until the monitors answer.
async fn up(hub: &Hub, monitors: usize) -> Fallible<()> {
    let began = Instant::now();
    let are_up = |health: &Value| {
        let up = |it: &Value| {
            it.as_object().into_iter().flatten().filter(|(_, it)| **it == "up").count()
        };
        up(&health["monitors"]) >= monitors
    };
    while !are_up(&get_json(&hub.place, "/health").await?) {
        if began.elapsed() > PATIENCE {
            return Err("the monitors do not answer".into());
        }
        sleep(Duration::from_millis(50)).await;
    }
    Ok(())
}

/// The head of an answer, and its body.
async fn post(place: &str, path: &str, headers: &str, body: &Value) -> Fallible<(String, Value)> {
    let (head, answer) = made(place, path, headers, body.to_string().as_bytes()).await?;
    Ok((head, serde_json::from_slice(&answer).unwrap_or_default()))
}

async fn made(place: &str, path: &str, headers: &str, body: &[u8]) -> Fallible<(String, Vec<u8>)> {
    let stream = link::connect_from(ADDRESS, place, None).await?;
    let (status, head, answer) = link::ask(stream, ("POST", path), headers, body).await?;
    match status {
        200..=299 => Ok((head, answer)),
        _ => Err(format!("{path}: {status} {}", String::from_utf8_lossy(&answer)).into()),
    }
}
