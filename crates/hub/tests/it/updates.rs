//! Updates of monitors' software through the hub: images, runs, what others may do meanwhile, and what is left when a
//! run, a monitor or the hub ends in the middle.

mod ends;
mod images;
mod killed;
mod others;
mod zones;

use std::net::SocketAddr;
use std::time::Duration;

use lafet_device::composition::Composition;
use lafet_hub::access::Role;
use lafet_hub::{Clock, Config};
use lafet_proto::SubsystemId;
use lafet_sim::sim::{Config as SimConfig, Software, Trial};
use lafet_update::{BoardName, Hash, Header, Layouts, SigningKey, Slot, Started, Version};
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep};

use crate::support::{Bus, Reply, Site, until};

const OLD: [u16; 4] = [1, 0, 0, 0];
const NEW: [u16; 4] = [2, 0, 0, 0];
/// So many bytes are sent in less than a second.
const SMALL: usize = 2_000;
/// So many take some seconds.
const LARGE: usize = 60_000;
/// No run takes so long.
const RUN: Duration = Duration::from_secs(120);

fn maker() -> SigningKey {
    SigningKey::new(3, [5; 32])
}

/// An image file that the monitors take, for either slot.
fn image(version: [u16; 4], len: usize) -> Vec<u8> {
    made(version, len, None)
}

fn made(version: [u16; 4], len: usize, place: Option<Slot>) -> Vec<u8> {
    let header = Header {
        size: 0,
        version: Version(version),
        board: BoardName::new("bench").unwrap(),
        place,
        key: 0,
        revokes: 0,
        layouts: Layouts { oldest: 1, newest: 1 },
        hash: Hash::default(),
    };
    let of_slot = place.map_or(0, Slot::code);
    let payload: Vec<u8> =
        (0..len).map(|at| (at % 251) as u8 ^ of_slot ^ version[0] as u8).collect();
    [maker().sign(&header, &payload).unwrap().as_slice(), &payload].concat()
}

fn software(trial: Trial) -> Software {
    let keys = vec![maker().public()];
    Software { board: "bench".into(), keys, version: OLD, trial, ..Software::default() }
}

/// A monitor that can be updated.
fn monitor(address: u8) -> SimConfig {
    let (composition, software) = (Composition::REMOTE, Some(software(Trial::Good)));
    SimConfig { composition, address, software, ..SimConfig::default() }
}

async fn bus(monitors: u8) -> (Bus, SocketAddr) {
    Bus::of((1..=monitors).map(monitor)).await
}

/// A hub at so many monitors; all users are administrators.
async fn open(monitors: u8) -> Site {
    with(monitors, |config| config.login = false).await
}

async fn with(monitors: u8, change: impl FnOnce(&mut Config)) -> Site {
    at(bus(monitors).await, change).await
}

/// At monitors that are there already. What is on trial is watched for a moment.
async fn at(bus: (Bus, SocketAddr), change: impl FnOnce(&mut Config)) -> Site {
    Site::on(bus, Clock::System, |config| {
        config.proven = Duration::from_millis(300);
        change(config);
    })
    .await
}

async fn send(site: &Site, token: &str, file: &[u8]) -> Reply {
    let mut stream = TcpStream::connect(site.address).await.unwrap();
    let authorization = match token {
        "" => String::new(),
        token => format!("Authorization: Bearer {token}\r\n"),
    };
    let head = format!(
        "POST /api/updates/images HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n{authorization}\
         Content-Length: {}\r\n\r\n",
        site.address,
        file.len()
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    // One that is refused for its length is not read to its end.
    _ = stream.write_all(file).await;
    let mut all = Vec::new();
    _ = stream.read_to_end(&mut all).await;
    let text = String::from_utf8_lossy(&all).into_owned();
    let (headers, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
    Reply {
        status: headers.split(' ').nth(1).and_then(|it| it.parse().ok()).unwrap_or(0),
        headers: headers.to_owned(),
        body: serde_json::from_str(body).unwrap_or_default(),
        text: body.to_owned(),
    }
}

/// Stores an image; its digest.
async fn store(site: &Site, file: &[u8]) -> String {
    let reply = send(site, "", file).await;
    assert!([200, 201].contains(&reply.status), "{reply:?}");
    reply.body["digest"].as_str().unwrap().to_owned()
}

async fn start(site: &Site, body: Value) -> Reply {
    site.post("", "/api/updates", body).await
}

/// Starts an update of all monitors to this image.
async fn begin(site: &Site, digest: &str) {
    let reply = start(site, json!({ "images": [digest], "pace": 100 })).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    assert_eq!(reply.body["state"], "running", "{reply:?}");
}

async fn run_now(site: &Site) -> Value {
    site.get("", "/api/updates").await.body["run"].clone()
}

/// The run as soon as it is as wanted.
async fn run_until(site: &Site, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
    let began = Instant::now();
    loop {
        let run = run_now(site).await;
        if wanted(&run) {
            return run;
        }
        assert!(began.elapsed() < RUN, "{what}: {run:#}");
        sleep(Duration::from_millis(20)).await;
    }
}

/// The run when it has ended.
async fn ended(site: &Site) -> Value {
    run_until(site, "it ends", |run| run["state"] != "running").await
}

/// The run has sent data and is not at their end.
fn sends(run: &Value) -> bool {
    run["monitors"][0]["stage"] == "sending" && run["monitors"][0]["done"].as_u64() > Some(0)
}

fn states(run: &Value) -> Vec<&str> {
    run["monitors"].as_array().unwrap().iter().map(|it| it["state"].as_str().unwrap()).collect()
}

fn text(of: &Value) -> &str {
    assert!(of["text"]["ru"].is_string(), "{of:#}");
    of["text"]["en"].as_str().unwrap()
}

/// What monitor 0, 1 … runs: version and trial.
fn runs(site: &Site, monitor: usize) -> ([u16; 4], bool) {
    let Started { version, trial, .. } = site.bus.lock()[monitor].running().unwrap();
    (version.0, trial)
}

fn is_locked(site: &Site, id: &str) -> bool {
    site.hub.station(id).unwrap().status().is_set(SubsystemId::GENERAL, "LockedOut")
}

/// Nothing is driven.
fn is_still(site: &Site) -> bool {
    site.bus.lock().iter().all(|sim| {
        let outputs = sim.world().outputs();
        outputs.drives.iter().all(|drive| drive.speed_tenths == 0)
    })
}

async fn release(site: &Site, id: &str) {
    let take = json!({ "action": "take" });
    site.post("", &format!("/api/monitors/{id}/authority"), take).await;
    let off = json!({ "request": "Lockout All off", "confirm": id });
    let reply = site.post("", &format!("/api/monitors/{id}/requests"), off).await;
    assert_eq!(reply.status, 200, "{reply:?}");
    let give = json!({ "action": "release" });
    site.post("", &format!("/api/monitors/{id}/authority"), give).await;
    until("it is released", || !is_locked(site, id)).await;
}

/// The acts of the audit log, the first one first: type, monitor, outcome.
async fn acts(site: &Site) -> Vec<(String, String, String)> {
    until("all is noted", || site.hub.audit().waiting() == 0).await;
    let mut log = site.hub.audit().latest(None, 1000, None, None).await.unwrap();
    log.reverse();
    log.into_iter()
        .map(|entry| {
            let record = entry.record;
            let act = record.act.unwrap_or_default();
            (act["type"].as_str().unwrap_or_default().to_owned(), record.monitor, record.outcome)
        })
        .collect()
}

/// From an image to monitors that run it: one after the other, locked out by the run and released by it, and nothing
/// moves. The log has all of it.
#[tokio::test]
async fn an_update_of_all_monitors() {
    let site = open(2).await;
    // Of a size that is sent for longer than a busy page is without news.
    let new = image(NEW, LARGE);
    let digest = store(&site, &new).await;
    let again = send(&site, "", &new).await;
    assert_eq!((again.status, again.body["digest"].as_str()), (200, Some(digest.as_str())));
    let mut page = site.ws("").await;
    begin(&site, &digest).await;
    let mut stages = Vec::new();
    let is_running = |known: &serde_json::Map<String, Value>| {
        known.get("updates").is_some_and(|it| it["run"]["state"] == "running")
    };
    page.until("it runs", is_running).await;
    let mut locked = Vec::new();
    while is_running(&page.known) {
        let run = &page.known["updates"]["run"];
        stages.extend(run["monitors"][0]["stage"].as_str().map(str::to_owned));
        locked.push([is_locked(&site, "M1"), is_locked(&site, "M2")]);
        assert!(is_still(&site));
        page.next().await.expect("the connection stays");
    }
    let run = ended(&site).await;
    assert_eq!(page.known["updates"]["run"], run, "the topic is what is answered");
    assert_eq!((states(&run), &run["state"]), (vec!["done", "done"], &json!("done")), "{run:#}");
    for monitor in run["monitors"].as_array().unwrap() {
        let versions = (&monitor["from"], &monitor["to"], &monitor["text"]);
        assert_eq!(versions, (&json!("1.0.0.0"), &json!("2.0.0.0"), &Value::Null), "{run:#}");
    }
    assert!(run["text"].is_null() && run["ended_ms"].as_u64() >= run["began_ms"].as_u64());
    for stage in ["sending", "restarting"] {
        assert!(stages.iter().any(|it| it == stage), "{stage}: {stages:?}");
    }
    assert!(!locked.contains(&[true, true]), "one at a time: {locked:?}");
    assert!(locked.contains(&[true, false]) && locked.contains(&[false, true]), "{locked:?}");
    assert_eq!((runs(&site, 0), runs(&site, 1)), ((NEW, false), (NEW, false)));
    assert!(!is_locked(&site, "M1") && !is_locked(&site, "M2"));
    let authority = site.get("", "/api/monitors/M1").await.body["authority"].clone();
    assert_eq!(authority["state"], "free", "{authority}");

    let log = acts(&site).await;
    let has = |kind: &str, monitor: &str, outcome: &str| {
        log.iter().any(|it| *it == (kind.to_owned(), monitor.to_owned(), outcome.to_owned()))
    };
    assert!(
        has("store_image", "", "Ok")
            && has("start_update", "", "Ok")
            && has("end_update", "", "done")
    );
    for monitor in ["M1", "M2"] {
        assert!(has("update_monitor", monitor, "Ok") && has("request", monitor, "Ok"), "{log:?}");
    }
    assert!(site.hub.audit().verify().await.unwrap().ok);
    let entries = site.hub.audit().latest(None, 1000, Some("M1".into()), None).await.unwrap();
    let locks = entries.iter().filter(|it| it.record.what.starts_with("Lockout All"));
    assert!(locks.clone().all(|it| it.record.via == "update" && it.record.user == "demo"));
    assert!(locks.count() >= 4, "on and off, asked and answered");

    // Once more: nothing is locked out for it.
    let before = site.hub.station("M1").unwrap().urgent_counts().lockout;
    begin(&site, &digest).await;
    let run = ended(&site).await;
    assert_eq!((states(&run), &run["state"]), (vec!["same", "same"], &json!("done")), "{run:#}");
    assert_eq!(site.hub.station("M1").unwrap().urgent_counts().lockout, before);
}

/// Images for slots: the one for the slot that is not running is sent. Then back in the other one.
#[tokio::test]
async fn an_image_for_each_slot() {
    let site = open(1).await;
    for version in [NEW, [3, 0, 0, 0]] {
        let mut digests = Vec::new();
        for slot in [Slot::A, Slot::B] {
            digests.push(store(&site, &made(version, SMALL, Some(slot))).await);
        }
        let lone = start(&site, json!({ "images": [digests[0], digests[0]] })).await;
        assert_eq!((lone.status, lone.code()), (400, "bad_request"), "{lone:?}");
        let reply = start(&site, json!({ "images": digests, "monitors": ["M1"] })).await;
        assert_eq!(reply.status, 202, "{reply:?}");
        let run = ended(&site).await;
        assert_eq!(states(&run), ["done"], "{run:#}");
        assert_eq!(runs(&site, 0), (version, false));
    }
    // Only the image for the slot that is running.
    let lone = store(&site, &made([4, 0, 0, 0], SMALL, Some(Slot::A))).await;
    begin(&site, &lone).await;
    let run = ended(&site).await;
    assert_eq!(states(&run), ["failed"], "{run:#}");
    assert!(text(&run["monitors"][0]).contains("slot B") && is_locked(&site, "M1"), "{run:#}");
}

/// Before a run starts.
#[tokio::test]
async fn what_makes_no_sense_starts_nothing() {
    let site = open(2).await;
    let (digest, other) =
        (store(&site, &image(NEW, SMALL)).await, store(&site, &image([3, 0, 0, 0], SMALL)).await);
    let none = "0".repeat(64);
    for (body, status, code) in [
        (json!({}), 400, "bad_request"),
        (json!({ "images": [] }), 400, "bad_request"),
        (json!({ "images": [none] }), 400, "bad_request"),
        (json!({ "images": ["../../hub.db"] }), 400, "bad_request"),
        (json!({ "images": [digest, other] }), 400, "bad_request"),
        (json!({ "images": [digest, other, digest] }), 400, "bad_request"),
        (json!({ "images": [digest], "monitors": [] }), 400, "bad_request"),
        (json!({ "images": [digest], "monitors": ["M9"] }), 400, "bad_request"),
        (json!({ "images": [digest], "pace": 0 }), 400, "bad_request"),
        (json!({ "images": [digest], "pace": 101 }), 400, "bad_request"),
        (json!({ "images": [digest], "force": true }), 400, "bad_request"),
    ] {
        let reply = start(&site, body.clone()).await;
        assert_eq!((reply.status, reply.code()), (status, code), "{body}: {reply:?}");
    }
    let stop = site.post("", "/api/updates/stop", json!({})).await;
    assert_eq!((stop.status, stop.code()), (404, "no_update"), "{stop:?}");
    assert!(run_now(&site).await.is_null());
    // A page of an engineer holds M2.
    let mut page = site.ws("").await;
    page.authority("M2", "take").await;
    let held = start(&site, json!({ "images": [digest] })).await;
    assert_eq!((held.status, held.code()), (409, "held"), "{held:?}");
    assert!(held.text.contains("M2"), "{held:?}");
    assert!(run_now(&site).await.is_null());
    let one = start(&site, json!({ "images": [digest], "monitors": ["M1", "M1"] })).await;
    assert_eq!(one.status, 202, "the other one is free: {one:?}");
    assert_eq!(ended(&site).await["monitors"].as_array().unwrap().len(), 1);
    assert_eq!((runs(&site, 0).0, runs(&site, 1).0), (NEW, OLD));
}

/// Who may look, send, start and stop.
#[tokio::test]
async fn each_step_has_its_role() {
    let site = with(1, |_| {}).await;
    for (role, token) in site.tokens() {
        let reply = site.get(&token, "/api/updates").await;
        assert_eq!(reply.status, 200, "{role:?}: {reply:?}");
        let is_engineer = role >= Role::Engineer;
        let sent = send(&site, &token, b"no image").await;
        assert_eq!(sent.code() == "role", !is_engineer, "{role:?}: {sent:?}");
        let started = site.post(&token, "/api/updates", json!({ "images": [] })).await;
        assert_eq!(started.code() == "role", !is_engineer, "{role:?}: {started:?}");
        let stopped = site.post(&token, "/api/updates/stop", json!({})).await;
        assert_eq!(stopped.code() == "role", role < Role::Operator, "{role:?}: {stopped:?}");
        let path = format!("/api/updates/images/{}", "0".repeat(64));
        let header = format!("Bearer {token}");
        let removed = site.http("DELETE", &path, &[("Authorization", &header)], "").await;
        assert_eq!(removed.code() == "role", !is_engineer, "{role:?}: {removed:?}");
    }
    for (method, path) in [
        ("GET", "/api/updates"),
        ("POST", "/api/updates"),
        ("POST", "/api/updates/stop"),
        ("POST", "/api/updates/images"),
        ("DELETE", "/api/updates/images/0"),
    ] {
        let reply = site.http(method, path, &[], "").await;
        assert_eq!((reply.status, reply.code()), (401, "login_needed"), "{method} {path}");
    }
}
