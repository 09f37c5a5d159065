//! MQTT, end to end: a broker and clients that are not ours, and what such brokers do wrong.

#[cfg(target_os = "linux")]
pub mod broker;
#[cfg(target_os = "linux")]
mod foreign;

use std::net::SocketAddr;
use std::time::Duration;

use serde_json::Value;
use tokio::io::AsyncReadExt;
use tokio::net::{TcpListener, TcpStream};
use tokio::time::Instant;

use super::{Clock, free, servers};
use crate::support::{PATIENCE, Site, until};
use lafet_device::composition::Composition;

/// `[[mqtt]]` as hub.toml has it.
fn table(address: SocketAddr, more: &str) -> String {
    format!("[[mqtt]]\nname = \"site\"\nurl = \"mqtt://{address}\"\n{more}\n")
}

async fn site_with(monitors: u8, text: &str) -> Site {
    let read = servers(monitors, text);
    Site::of((monitors, Composition::REMOTE), Clock::System, |config| {
        (config.login, config.mqtt) = (false, read.mqtt);
    })
    .await
}

async fn plug(site: &Site) -> Value {
    site.get("", "/api/hub/state").await.body["plugs"][0].clone()
}

async fn until_plug(site: &Site, what: &str, wanted: impl Fn(&Value) -> bool) {
    let began = Instant::now();
    loop {
        let plug = plug(site).await;
        if wanted(&plug) {
            return;
        }
        assert!(began.elapsed() < PATIENCE, "{what}: {plug:#}");
    }
}

fn says(plug: &Value, en: &str) -> bool {
    plug["error"]["en"].as_str().is_some_and(|it| it.contains(en))
        && plug["error"]["ru"].is_string()
}

#[tokio::test]
async fn a_broker_that_is_not_there_is_reported_and_tried_again() {
    let address = free();
    let site = site_with(1, &table(address, "")).await;
    let state = plug(&site).await;
    assert_eq!((&state["protocol"], &state["name"]), (&"mqtt".into(), &"site".into()));
    assert_eq!(state["address"], format!("mqtt://{address}"));
    until_plug(&site, "it is refused", |it| says(it, "refused")).await;
    let listener = TcpListener::bind(address).await.unwrap();
    let (_, from) = tokio::time::timeout(PATIENCE, listener.accept()).await.unwrap().unwrap();
    assert!(from.ip().is_loopback());
    let events = site.get("", "/api/events").await.body.to_string();
    assert!(events.contains("is not connected"), "{events}");
}

/// A broker that takes connections and never says a word, and ones that say what is no MQTT.
#[tokio::test]
async fn a_broker_that_never_answers_holds_up_nothing() {
    for says_so in [&b""[..], b"HTTP/1.1 400 Bad Request\r\n\r\n", &[0x20, 0xFF, 0xFF, 0xFF, 0x7F]]
    {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        tokio::spawn(async move {
            let mut held = Vec::new();
            while let Ok((mut stream, _)) = listener.accept().await {
                _ = tokio::io::AsyncWriteExt::write_all(&mut stream, says_so).await;
                held.push(stream);
            }
        });
        let site = site_with(1, &table(address, "role = \"operator\"")).await;
        if says_so.is_empty() {
            until_plug(&site, "it is silent", |it| says(it, "does not answer")).await;
        } else {
            let is_new = |it: &Value| it["error"].is_object() && !says(it, "Not connected yet");
            until_plug(&site, "it is no broker", is_new).await;
        }
        // Consoles are served as ever.
        let mut console = site.ws("").await;
        let began = Instant::now();
        assert!(console.authority("M1", "take").await["error"].is_null());
        assert!(began.elapsed() < Duration::from_secs(2));
    }
}

/// A broker of which only the first answer comes, and which then takes nothing more.
#[tokio::test]
async fn a_broker_that_takes_nothing_loses_its_connection_and_delays_no_console() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let accepted = tokio::spawn(async move {
        let (mut stream, _) = listener.accept().await.unwrap();
        let mut buffer = [0; 1024];
        _ = stream.read(&mut buffer).await;
        // CONNACK: no session, success, no properties.
        _ = tokio::io::AsyncWriteExt::write_all(&mut stream, &[0x20, 3, 0, 0, 0]).await;
        let again: (TcpStream, SocketAddr) = listener.accept().await.unwrap();
        drop((stream, again));
    });
    let site = site_with(3, &table(address, "interval_ms = 250")).await;
    until_plug(&site, "it is connected", |it| it["error"].is_null()).await;
    let mut console = site.ws("").await;
    let began = Instant::now();
    for monitor in ["M1", "M2", "M3"] {
        assert!(console.authority(monitor, "take").await["error"].is_null());
    }
    assert!(began.elapsed() < Duration::from_secs(2));
    until_plug(&site, "it is given up", |it| says(it, "does not answer")).await;
    until("it is tried again", || accepted.is_finished()).await;
}
