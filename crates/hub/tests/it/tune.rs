//! Tuning a drive through the hub: it ends with a Stop of any client and without the beats of its own, the drive
//! is at rest then, and the values are as they were.

use std::time::{Duration, Instant};

use lafet_client::tune::Pair;
use lafet_client::tune::kept::{Kept, Note};
use lafet_proto::SubsystemId;
use serde_json::{Value, json};

use crate::support::{self, Site, Socket};

const TOPIC: &str = "monitors/M1/tune";
/// Drive 1 of the bus.
const DRIVE: &str = "Horizontal";

/// Sends beats until the tuning is as wanted.
async fn beat_until(socket: &mut Socket, wanted: impl Fn(&Value) -> bool) -> Value {
    let began = Instant::now();
    while !socket.known.get(TOPIC).is_some_and(&wanted) {
        assert!(began.elapsed() < Duration::from_secs(90), "{:?}", socket.known.get(TOPIC));
        socket.send(json!({ "type": "tune_beat", "monitor": "M1" })).await;
        socket.next().await.expect("the connection stays");
    }
    socket.known[TOPIC].clone()
}

async fn begin(socket: &mut Socket) {
    socket.authority("M1", "take").await;
    let answer = socket.ask(json!({ "type": "tune", "monitor": "M1", "drive": DRIVE })).await;
    assert!(answer["error"].is_null(), "{answer}");
}

fn ended(known: &serde_json::Map<String, Value>) -> bool {
    known.get(TOPIC).is_some_and(|it| it["state"] == "ended")
}

fn moves(site: &Site) -> bool {
    site.bus.commanded(0, 1) != 0
}

async fn value(site: &Site, name: &str) -> Value {
    let request = json!({ "request": format!("GetParam {DRIVE} {name}") });
    let body = site.post("", "/api/monitors/M1/requests", request).await.body;
    body["answers"][0]["values"]["values"].clone()
}

#[tokio::test]
async fn a_stop_of_another_client_ends_it_and_the_values_are_as_before() {
    let site = Site::open(1).await;
    let mut engineer = site.ws("").await;
    let before = value(&site, "StopLag").await;
    begin(&mut engineer).await;
    beat_until(&mut engineer, |it| it["done"].as_u64() >= Some(2)).await;
    assert_eq!(engineer.known[TOPIC]["restored"], false);
    support::until("it moves", || moves(&site)).await;
    site.post("", "/api/monitors/M1/stop", json!({})).await;
    let ended = beat_until(&mut engineer, |it| it["state"] != "running").await;
    assert_eq!(ended["state"], "ended", "{ended}");
    assert!(ended["text"]["en"].as_str().unwrap().contains("STOP"), "{ended}");
    assert_eq!(ended["restored"], true, "{ended}");
    assert_eq!(value(&site, "StopLag").await, before);
    support::until("noted", || site.hub.audit().waiting() == 0).await;
    let log = site.hub.audit().latest(None, 1000, Some("M1".into()), None).await.unwrap();
    for name in ["StopLag", "MinSpeed"] {
        let set = format!("SetParam {DRIVE} {name}");
        let saved = log.iter().filter(|it| it.record.what.starts_with(&set));
        let saved = saved.filter(|it| it.record.details["saved"].is_string());
        assert!(saved.count() > 0, "{name}: that it is stored is waited for: {log:?}");
    }
    assert!(
        support::stays(Duration::from_secs(2), || !moves(&site)).await,
        "nothing moves after it"
    );
    let again = engineer.ask(json!({ "type": "tune_beat", "monitor": "M1" }));
    _ = tokio::time::timeout(Duration::from_millis(300), again).await;
    assert!(!moves(&site), "a beat begins nothing");
}

#[tokio::test]
async fn without_beats_it_ends_and_without_authority_it_does_not_begin() {
    let site = Site::open(1).await;
    let mut engineer = site.ws("").await;
    let refused = engineer.ask(json!({ "type": "tune", "monitor": "M1", "drive": DRIVE })).await;
    assert_eq!(refused["error"]["code"], "no_authority", "{refused}");
    begin(&mut engineer).await;
    let twice = engineer.ask(json!({ "type": "tune", "monitor": "M1", "drive": "Vertical" })).await;
    assert_eq!(twice["error"]["code"], "bad_request", "{twice}");
    support::until("it moves", || moves(&site)).await;
    let began = Instant::now();
    engineer.until("it ends", ended).await;
    assert!(began.elapsed() > Duration::from_millis(1000), "it lasts as long as a beat counts");
    assert!(!moves(&site));
    assert_eq!(engineer.known[TOPIC]["restored"], true);
}

#[tokio::test]
async fn a_lost_connection_ends_it() {
    let site = Site::open(1).await;
    let mut engineer = site.ws("").await;
    let mut other = site.ws("").await;
    begin(&mut engineer).await;
    support::until("it moves", || moves(&site)).await;
    drop(engineer);
    other.until("it ends", ended).await;
    assert!(!moves(&site));
    let text = other.known[TOPIC]["text"]["en"].as_str().unwrap().to_owned();
    assert!(text.contains("control of the monitor was lost"), "{text}");
}

#[tokio::test]
async fn what_was_measured_is_told_and_not_set() {
    let site = Site::open(1).await;
    let mut engineer = site.ws("").await;
    begin(&mut engineer).await;
    let done = beat_until(&mut engineer, |it| it["state"] != "running").await;
    assert_eq!(done["state"], "done", "{done}");
    assert_eq!((done["done"].as_u64(), done["total"].as_u64()), (Some(20), Some(20)), "{done}");
    assert!(done["found"]["stop_lag"].is_i64() && done["error"].as_i64() <= Some(2), "{done}");
    assert_eq!(done["restored"], true);
    assert_eq!(value(&site, "StopLag").await[0], done["before"]["stop_lag"]);
}

/// A hub was killed while it measured; the next one finds its note.
#[tokio::test]
async fn what_a_killed_hub_has_set_is_put_back() {
    let data = std::env::temp_dir().join(format!("lafet-tune-{}", std::process::id()));
    let note = Note::new(&data.join("tune"), "M1");
    let before = Pair { lag_ms: 123, min_tenths: 7 };
    let kept = Kept { drive: SubsystemId::HORIZONTAL, before, set: vec![Pair::default()] };
    note.write(&kept).unwrap();
    let own = data.clone();
    let site = Site::with(1, |config| (config.login, config.data) = (false, Some(own))).await;
    let mut engineer = site.ws("").await;
    let began = Instant::now();
    while engineer.known.get(TOPIC).is_none() {
        assert!(began.elapsed() < Duration::from_secs(20), "nothing is put back");
        engineer.next().await.expect("the connection stays");
    }
    let known = &engineer.known[TOPIC];
    assert_eq!((&known["restored"], &known["state"]), (&json!(true), &json!("ended")), "{known}");
    assert_eq!(value(&site, "StopLag").await, json!([123]));
    assert_eq!(value(&site, "MinSpeed").await, json!([7]));
    assert_eq!(note.read().unwrap(), None);

    begin(&mut engineer).await;
    beat_until(&mut engineer, |it| it["done"].as_u64() >= Some(1)).await;
    let kept = note.read().unwrap().expect("a note while it measures");
    assert_eq!((kept.before, kept.set), (before, vec![Pair::default()]));
    site.post("", "/api/monitors/M1/stop", json!({})).await;
    let ended = beat_until(&mut engineer, |it| it["state"] != "running").await;
    assert_eq!(ended["restored"], true, "{ended}");
    assert_eq!((value(&site, "StopLag").await, note.read().unwrap()), (json!([123]), None));
    std::fs::remove_dir_all(data).unwrap();
}
