//! Zones, end to end: detectors report over HTTP, simulated monitors open, and who says no wins.

#[cfg(target_os = "linux")]
mod flooded;
mod planned;
mod refused;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::support::{Reply, Site, stays, until};
use lafet_device::composition::Composition;
use lafet_hub::access::Role;
use lafet_hub::site::Place;
use lafet_hub::store::StateFile;
use lafet_hub::{Clock, Config, Overrides, Station, ZonesConfig};
use lafet_proto::record::Records;
use lafet_proto::{RequestId, SubsystemId};
use serde_json::{Value, json};
use tokio::time::Instant;

/// Two detectors of different kinds for one zone with these monitors.
fn hall(monitors: u8, keys: &str) -> ZonesConfig {
    let ids: Vec<String> = (1..=monitors).map(|it| format!("\"M{it}\"")).collect();
    let mut text = String::new();
    for (number, id) in (1..).zip(&ids) {
        text += &format!("[[monitor]]\nid = {id}\nurl = \"tcp://h?addr={number}\"\n");
        text += &format!(
            "[[aim]]\nzone = \"hall\"\nmonitor = {id}\nhorizontal = 600\nvertical = 300\nnozzle = 60\n"
        );
    }
    for kind in ["flame", "heat"] {
        text += &format!(
            "[[detector]]\nid = \"{kind}\"\nkind = \"{kind}\"\nzones = [\"hall\"]\nsilent_after_s = 3600\n"
        );
    }
    text += &format!(
        "[[zone]]\nid = \"hall\"\nvotes = \"2oo2\"\nwater_max_s = 600\nmonitors = [{}]\n{keys}\n",
        ids.join(", ")
    );
    let read = Config::parse("hub.toml", &text, Path::new("/"), &Overrides::default());
    read.unwrap_or_else(|problems| panic!("{problems:#?}")).zones.expect("zones")
}

/// A hub with the zone `hall`; its detectors have reported that they see nothing.
async fn quiet(monitors: u8, keys: &str) -> Site {
    quiet_of((monitors, Composition::REMOTE), keys).await
}

async fn quiet_of(monitors: (u8, Composition), keys: &str) -> Site {
    let zones = hall(monitors.0, keys);
    let site = Site::of(monitors, Clock::System, |config| {
        (config.login, config.zones) = (false, Some(zones));
    })
    .await;
    for detector in ["flame", "heat"] {
        assert_eq!(sees(&site, detector, "quiet").await.status, 204);
    }
    until_state(&site, "it is ready", |zone| zone["ready"] == true).await;
    site
}

async fn sees(site: &Site, detector: &str, signal: &str) -> Reply {
    site.post("", &format!("/api/detectors/{detector}"), json!({ "signal": signal })).await
}

async fn fire(site: &Site) {
    for detector in ["flame", "heat"] {
        assert_eq!(sees(site, detector, "alarm").await.status, 204);
    }
}

async fn order(site: &Site, path: &str, body: Value) -> Reply {
    site.post("", &format!("/api/zones/{path}"), body).await
}

/// Orders it until it is not at the same time as a no any more.
async fn insist(site: &Site, path: &str) {
    let began = Instant::now();
    loop {
        let reply = order(site, path, json!({})).await;
        if reply.status == 200 {
            return;
        }
        assert_eq!(reply.code(), "zone_refused", "{reply:?}");
        assert!(began.elapsed() < Duration::from_secs(10), "{reply:?}");
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
}

async fn state(site: &Site) -> Value {
    site.get("", "/api/zones").await.body["state"].clone()
}

/// The zone, as soon as it is as wanted.
async fn until_state(site: &Site, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
    let began = Instant::now();
    loop {
        let zone = state(site).await["zones"][0].clone();
        if wanted(&zone) {
            return zone;
        }
        assert!(began.elapsed() < Duration::from_secs(20), "{what}: {zone:#}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

fn is_set(site: &Site, monitor: &str, flag: &str) -> bool {
    site.hub.station(monitor).unwrap().status().is_set(SubsystemId::VALVE1, flag)
}

fn is_open(site: &Site, monitor: &str) -> bool {
    is_set(site, monitor, "Open")
}

fn is_closed(site: &Site, monitor: &str) -> bool {
    is_set(site, monitor, "Closed")
}

/// The acts of the audit log, the latest first.
async fn acts(site: &Site) -> Vec<Value> {
    let log = site.hub.audit().latest(None, 200, None, None).await.unwrap();
    log.into_iter().filter_map(|entry| entry.record.act).collect()
}

#[tokio::test]
async fn two_votes_open_the_valve_and_one_does_not() {
    let site = quiet(1, "coincidence_s = 1").await;
    sees(&site, "flame", "alarm").await;
    let closed = stays(Duration::from_millis(1500), || is_closed(&site, "M1")).await;
    assert!(closed, "one vote of two opens nothing");
    let zone = state(&site).await["zones"][0].clone();
    assert_eq!(zone["phase"], "alarm");
    assert_eq!(zone["not_released"][0], json!({ "votes": { "have": 1, "need": 2 } }));
    sees(&site, "heat", "alarm").await;
    until("the valve opens", || is_open(&site, "M1")).await;
    let zone = until_state(&site, "it is released", |zone| zone["monitors"][0] == "M1").await;
    assert_eq!(zone["phase"], json!({ "released": { "automatic": true, "wet": true } }));
    let authority = site.get("", "/api/monitors/M1").await.body["authority"].clone();
    assert_eq!(
        (&authority["state"], &authority["holder"]["user"]),
        (&json!("held"), &json!("zones"))
    );
    let acts = acts(&site).await;
    let order =
        acts.iter().find(|act| act["order"]["engage"].is_object()).expect("the order is noted");
    let causes = order["cause"].as_array().unwrap();
    for detector in ["flame", "heat"] {
        assert!(causes.iter().any(|it| it["vote"]["detector"] == detector), "{order:#}");
    }
    assert!(acts.iter().any(|act| act["type"] == "request" && act["request"] == "Open"));
}

/// Reports fire in this direction.
async fn sees_at(site: &Site, detector: &str, bearing_deg: f64) {
    let report = json!({ "signal": "alarm", "bearing_deg": bearing_deg });
    let reply = site.post("", &format!("/api/detectors/{detector}"), report).await;
    assert_eq!(reply.status, 204, "{reply:?}");
}

/// Two monitors; detectors at both ends of the wall behind them.
async fn placed() -> Site {
    let mut zones = hall(2, "coincidence_s = 0\njets = 1");
    for (id, east) in [("flame", -20.0), ("heat", 20.0)] {
        let station = Station { at: [east, 0.0, 6.0], sigma: 0.5_f64.to_radians() };
        zones.stations.insert(id.into(), station);
    }
    let place = |east: f64| Place { at: [east, 0.0], heading: 0.0, height: 2.0 };
    let monitors = [("M1".to_owned(), place(-15.0)), ("M2".to_owned(), place(15.0))].into();
    let map = lafet_hub::site::Site { monitors, ..Default::default() };
    Site::of((2, Composition::REMOTE), Clock::System, |config| {
        (config.login, config.zones, config.site) = (false, Some(zones), Some(map));
    })
    .await
}

/// M1 is the configured first; M2 is nearer, and aims where the lines of sight cross.
#[tokio::test]
async fn the_nearer_monitor_aims_at_the_place_of_the_fire() {
    let site = placed().await;
    for detector in ["flame", "heat"] {
        assert_eq!(sees(&site, detector, "quiet").await.status, 204);
    }
    until_state(&site, "it is ready", |zone| zone["ready"] == true).await;
    // A fire at 10 m east, 20 m north.
    sees_at(&site, "flame", 56.31).await;
    assert_eq!(site.get("", "/api/zones").await.body["fires"], json!([]), "one bearing is a line");
    sees_at(&site, "heat", 333.435).await;
    // They are located beside the report.
    let located = || site.hub.zones_view().is_ok_and(|it| !it.fires.is_empty());
    until("the fire is located", located).await;
    let fires = site.get("", "/api/zones").await.body["fires"].clone();
    let at = |axis: usize| fires[0]["at"][axis].as_f64().unwrap();
    assert!((at(0) - 10.0).abs() < 0.1 && (at(1) - 20.0).abs() < 0.1, "{fires:#}");
    assert_eq!((&fires[0]["standing"], &fires[0]["zone"]), (&json!("sure"), &json!("hall")));
    until("the nearer valve opens", || is_open(&site, "M2")).await;
    assert!(is_closed(&site, "M1"), "one jet was asked for");
    // 5 m to the left of M2 on 20 m: 14°, not the 10° of its [[aim]].
    let began = Instant::now();
    loop {
        let status = site.hub.station("M2").unwrap().status();
        let at = status.valid(SubsystemId::HORIZONTAL, "position").unwrap();
        if (842 - 130..=842 + 130).contains(&at) {
            break;
        }
        assert!(began.elapsed() < Duration::from_secs(20), "it aims at {at}'");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let noted = site.hub.audit().latest(None, 200, None, None).await.unwrap();
    let aimed = noted.iter().any(|it| it.record.what.contains("centre=842,-332"));
    assert!(aimed, "{:#?}", noted.iter().map(|it| &it.record.what).collect::<Vec<_>>());
}

#[tokio::test]
async fn a_stowed_monitor_is_deployed_before_its_valve_opens() {
    let site = quiet_of((1, Composition::FULL), "coincidence_s = 0").await;
    let status = || site.hub.station("M1").unwrap().status();
    assert!(status().is_set(SubsystemId::DEPLOYER, "Wrapped"), "it is stowed at first");
    fire(&site).await;
    until("it deploys", || status().is_set(SubsystemId::DEPLOYER, "Deploying")).await;
    until("the valve opens", || {
        let deployed = status().is_set(SubsystemId::DEPLOYER, "Deployed");
        assert!(deployed || is_closed(&site, "M1"));
        is_open(&site, "M1")
    })
    .await;
    assert!(status().is_set(SubsystemId::CONTROL, "Quench"));
    // The other valve is not that of the water.
    site.post("", "/api/monitors/M1/close", json!({ "valve": "Valve2" })).await;
    assert!(stays(Duration::from_millis(700), || is_open(&site, "M1")).await);
    site.post("", "/api/monitors/M1/close", json!({ "valve": "Valve1" })).await;
    until("it closes", || is_closed(&site, "M1")).await;
    assert_eq!(state(&site).await["monitors"][0]["withheld"], "refused");
}

#[tokio::test]
async fn a_monitor_that_deploys_does_not_turn_when_the_votes_are_withdrawn() {
    let site = quiet_of((1, Composition::FULL), "coincidence_s = 0\ndelay_s = 60").await;
    let station = site.hub.station("M1").unwrap();
    let is = |of: SubsystemId, flag: &str| station.status().is_set(of, flag);
    fire(&site).await;
    until("it deploys", || is(SubsystemId::DEPLOYER, "Deploying")).await;
    for detector in ["flame", "heat"] {
        assert_eq!(sees(&site, detector, "quiet").await.status, 204);
    }
    until_state(&site, "no votes", |zone| zone["phase"] == "quiet").await;
    until("it is deployed", || is(SubsystemId::DEPLOYER, "Deployed")).await;
    let turns =
        || [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL].iter().any(|it| is(*it, "Move"));
    assert!(stays(Duration::from_secs(3), || !turns()).await, "for what it turns is over");
    let authority = site.get("", "/api/monitors/M1").await.body["authority"]["state"].clone();
    assert_eq!(authority, "free");
}

/// The best of some tries: the machine of the tests has other work too.
#[tokio::test]
async fn the_first_command_is_sent_within_200_ms() {
    let site = quiet(1, "coincidence_s = 0").await;
    let mut frames = site.hub.station("M1").unwrap().client().unwrap().trace();
    let mut best = Duration::MAX;
    for _ in 0..5 {
        sees(&site, "flame", "alarm").await;
        let began = Instant::now();
        sees(&site, "heat", "alarm").await;
        let sent = loop {
            let Ok(frame) = frames.recv().await else { continue };
            let mut records = Records::new(&frame.payload).map_while(Result::ok);
            if frame.dst == 1 && records.any(|it| it.request == RequestId::START_QUENCH) {
                break began.elapsed();
            }
        };
        best = best.min(sent);
        if best <= Duration::from_millis(200) {
            break;
        }
        order(&site, "hall/abort", json!({})).await;
        for detector in ["flame", "heat"] {
            sees(&site, detector, "quiet").await;
        }
        until("it closes", || is_closed(&site, "M1")).await;
        insist(&site, "reset").await;
    }
    assert!(best <= Duration::from_millis(200), "{best:?}");
}

/// The same of many, with a plan that is computed between the last vote and the command.
#[tokio::test]
#[ignore = "minutes: a hundred releases"]
async fn the_first_command_of_a_hundred_planned_releases() {
    let site = placed().await;
    let mut frames = site.hub.station("M2").unwrap().client().unwrap().trace();
    let mut took = Vec::new();
    for _ in 0..100 {
        for detector in ["flame", "heat"] {
            sees(&site, detector, "quiet").await;
        }
        until_state(&site, "it is ready", |zone| zone["ready"] == true).await;
        sees_at(&site, "flame", 56.31).await;
        let began = Instant::now();
        sees_at(&site, "heat", 333.435).await;
        loop {
            let Ok(frame) = frames.recv().await else { continue };
            let mut records = Records::new(&frame.payload).map_while(Result::ok);
            if frame.dst == 2 && records.any(|it| it.request == RequestId::START_QUENCH) {
                break;
            }
            assert!(began.elapsed() < Duration::from_secs(20), "M2 is not engaged");
        }
        took.push(began.elapsed());
        order(&site, "hall/abort", json!({})).await;
        for detector in ["flame", "heat"] {
            sees(&site, detector, "quiet").await;
        }
        until("it closes", || is_closed(&site, "M2")).await;
        let closing = async || state(&site).await["monitors"][1]["closing"] == true;
        while closing().await {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        insist(&site, "reset").await;
    }
    took.sort();
    println!("from the last vote to the first command: median {:?}, p99 {:?}", took[50], took[98]);
    assert!(took[98] <= Duration::from_millis(200), "{took:?}");
}

#[tokio::test]
async fn an_abort_closes_and_wins_against_votes_and_hands() {
    let site = quiet(1, "coincidence_s = 0").await;
    fire(&site).await;
    until("the valve opens", || is_open(&site, "M1")).await;
    assert_eq!(order(&site, "hall/abort", json!({})).await.status, 200);
    let refused = order(&site, "hall/release", json!({ "confirm": "hall" })).await;
    assert_eq!((refused.status, refused.code()), (409, "zone_refused"), "{refused:?}");
    until("the valve closes", || is_closed(&site, "M1")).await;
    let zone = state(&site).await["zones"][0].clone();
    assert_eq!(zone["phase"], json!({ "ended": "abort" }));
    assert!(
        stays(Duration::from_millis(1500), || is_closed(&site, "M1")).await,
        "votes are there still"
    );
    until_state(&site, "the authority is given back", |_| {
        site.hub.station("M1").unwrap().control(&site.hub).holder.is_none()
    })
    .await;
    // Not at the same time any more: a hand may release again.
    let released = order(&site, "hall/release", json!({ "confirm": "hall" })).await;
    assert_eq!(released.status, 200, "{released:?}");
    until("the valve opens again", || is_open(&site, "M1")).await;
}

#[tokio::test]
async fn lockout_wins_against_votes_and_hands_until_it_is_released() {
    let site = quiet(1, "coincidence_s = 0").await;
    let locked = order(&site, "lock", json!({})).await;
    assert_eq!(
        (locked.status, &locked.body["state"]["lockout"]),
        (200, &json!(true)),
        "{locked:?}"
    );
    fire(&site).await;
    let refused = order(&site, "hall/release", json!({ "confirm": "hall" })).await;
    assert_eq!((refused.status, refused.code()), (409, "zone_refused"));
    assert!(stays(Duration::from_secs(1), || is_closed(&site, "M1")).await);
    insist(&site, "unlock").await;
    assert!(stays(Duration::from_secs(1), || is_closed(&site, "M1")).await, "nor with the key");
    assert_eq!(state(&site).await["zones"][0]["phase"], json!({ "ended": "lockout" }));
    assert_eq!(order(&site, "reset", json!({})).await.status, 200);
    until("votes that are there release after a reset", || is_open(&site, "M1")).await;
}

#[tokio::test]
async fn a_persons_stop_ends_the_water_and_stop_of_a_drive_does_not() {
    let site = quiet(2, "coincidence_s = 0\njets = 1").await;
    fire(&site).await;
    until("the valve opens", || is_open(&site, "M1")).await;
    site.post("", "/api/monitors/M1/stop", json!({ "of": "Vertical" })).await;
    assert!(
        stays(Duration::from_millis(700), || is_open(&site, "M1")).await,
        "a motion by hand ends so"
    );
    site.post("", "/api/monitors/M1/close", json!({})).await;
    until("it closes", || is_closed(&site, "M1")).await;
    until("the other one takes its place", || is_open(&site, "M2")).await;
    let monitors = state(&site).await["monitors"].clone();
    assert_eq!(
        (&monitors[0]["withheld"], &monitors[1]["engaged_for"]),
        (&json!("refused"), &json!("hall"))
    );
    site.post("", "/api/stop", json!({})).await;
    until("all close", || is_closed(&site, "M1") && is_closed(&site, "M2")).await;
    assert_eq!(state(&site).await["zones"][0]["phase"], json!({ "ended": "stop" }));
    assert!(stays(Duration::from_millis(1500), || is_closed(&site, "M2")).await);
}

/// A Stop that its client has sent before is still a no: the zone may have been reset between.
#[tokio::test]
async fn a_stop_that_is_repeated_is_a_no_after_a_reset_too() {
    let site = quiet(1, "coincidence_s = 0").await;
    for _ in 0..3 {
        for path in ["/api/stop", "/api/monitors/M1/stop"] {
            site.post("", path, json!({})).await;
        }
        let now = state(&site).await;
        assert_eq!(now["zones"][0]["phase"], json!({ "ended": "stop" }));
        assert_eq!(now["monitors"][0]["withheld"], json!("refused"));
        insist(&site, "reset").await;
        assert_eq!(state(&site).await["monitors"][0]["withheld"], Value::Null);
    }
}

#[tokio::test]
async fn a_monitor_in_a_persons_hands_is_left_alone() {
    let site = quiet(2, "coincidence_s = 0\njets = 1").await;
    let take = json!({ "action": "take" });
    assert_eq!(site.post("", "/api/monitors/M1/authority", take).await.status, 200);
    until_state(&site, "it is known", |_| true).await;
    let began = Instant::now();
    while state(&site).await["monitors"][0]["withheld"] != "person" {
        assert!(began.elapsed() < Duration::from_secs(10));
    }
    fire(&site).await;
    until("the other one opens", || is_open(&site, "M2")).await;
    assert!(is_closed(&site, "M1"));
    // Who asks for the one that the zone works with gets it at once.
    let ask = json!({ "action": "request" });
    site.post("", "/api/monitors/M2/authority", ask).await;
    until("it is granted", || {
        let control = site.hub.station("M2").unwrap().control(&site.hub);
        control.holder.is_some_and(|it| it.seat.user == "demo")
    })
    .await;
    assert!(is_open(&site, "M2"), "water goes on in the person's hands");
}

#[tokio::test]
async fn a_failed_detector_never_votes() {
    let site = quiet(1, "coincidence_s = 0").await;
    let failed = json!({ "signal": "alarm", "condition": "fault" });
    assert_eq!(site.post("", "/api/detectors/flame", failed).await.status, 204);
    sees(&site, "heat", "alarm").await;
    assert!(stays(Duration::from_millis(1500), || is_closed(&site, "M1")).await);
    let state = state(&site).await;
    let zone = &state["zones"][0];
    assert_eq!((&zone["need"], &zone["ready"]), (&Value::Null, &json!(false)));
    assert_eq!(zone["unable"][0], json!({ "detector": "flame", "why": { "condition": "fault" } }));
    assert_eq!(state["troubles"][0]["trouble"], "detector_fault");
}

/// What a killed hub has stored, in a folder of its own.
fn after_a_kill(folder: &Path) -> PathBuf {
    let copy = folder.with_extension("copy");
    _ = fs::remove_dir_all(&copy);
    fs::create_dir(&copy).unwrap();
    for name in ["hub.db", "hub.db-wal"] {
        fs::copy(folder.join(name), copy.join(name)).unwrap();
    }
    copy
}

#[tokio::test]
async fn a_hub_that_starts_again_opens_nothing_by_stale_votes_and_knows_its_masks() {
    let folder = std::env::temp_dir().join(format!("lafet-zones-{}", std::process::id()));
    _ = fs::remove_dir_all(&folder);
    let start = async |data: PathBuf| {
        let zones = hall(1, "coincidence_s = 0\nwhen_failed = [\"alarm\"]");
        Site::with(1, |config| {
            (config.login, config.zones, config.data) = (false, Some(zones), Some(data));
            config.accept_lost = vec![StateFile::Audit, StateFile::Hub];
        })
        .await
    };
    let site = start(folder.clone()).await;
    for detector in ["flame", "heat"] {
        sees(&site, detector, "quiet").await;
    }
    let off = json!({ "mode": "manual", "for_s": 3600 });
    assert_eq!(order(&site, "hall/mode", off).await.status, 200);
    let masked = json!({ "bypass": "masked" });
    assert_eq!(site.post("", "/api/detectors/heat/bypass", masked).await.status, 200);
    let stored = || {
        let db = rusqlite::Connection::open(folder.join("hub.db")).unwrap();
        let text: Result<String, _> = db.query_row("SELECT value FROM zones", [], |row| row.get(0));
        text.is_ok_and(|text| text.contains("masked") && text.contains("manual"))
    };
    until("it is stored", stored).await;
    let copy = after_a_kill(&folder);
    drop(site);
    let site = start(copy.clone()).await;
    let known = state(&site).await["disablements"].to_string();
    assert!(known.contains("masked") && known.contains("manual"), "{known}");
    let automatic = json!({ "mode": "automatic" });
    assert_eq!(order(&site, "hall/mode", automatic).await.status, 200);
    let voting = json!({ "bypass": "none" });
    assert_eq!(site.post("", "/api/detectors/heat/bypass", voting).await.status, 200);
    // Alarms that are there when the detectors are first heard.
    fire(&site).await;
    assert!(stays(Duration::from_millis(1500), || is_closed(&site, "M1")).await);
    let zone = state(&site).await["zones"][0].clone();
    assert!(zone["not_released"].as_array().unwrap().contains(&json!("stale")), "{zone:#}");
    for signal in ["quiet", "alarm"] {
        for detector in ["flame", "heat"] {
            sees(&site, detector, signal).await;
        }
    }
    until("votes of after the start open", || is_open(&site, "M1")).await;
    drop(site);
    for folder in [folder, copy] {
        _ = fs::remove_dir_all(folder);
    }
}

#[tokio::test]
async fn a_hold_ends_when_its_holder_does_not_renew_it() {
    let site = quiet(1, "coincidence_s = 0\ndelay_s = 2\nhold_max_s = 600").await;
    fire(&site).await;
    assert_eq!(order(&site, "hall/hold", json!({ "on": true })).await.status, 200);
    until_state(&site, "it is held", |zone| zone["phase"] == "held").await;
    assert!(
        stays(Duration::from_secs(4), || is_closed(&site, "M1")).await,
        "longer than the delay"
    );
    // Ten seconds after the last time, the delay goes on and is over.
    until("it opens", || is_open(&site, "M1")).await;
}

#[tokio::test]
async fn bad_requests_are_answered_in_words() {
    let site = quiet(1, "").await;
    let post = async |path: &str, body: Value| site.post("", path, body).await;
    for (path, body, status, code) in [
        ("/api/detectors/nothing", json!({ "signal": "alarm" }), 404, "no_detector"),
        ("/api/detectors/flame", json!({}), 400, "bad_request"),
        ("/api/detectors/flame", json!({ "signal": "fire" }), 400, "bad_request"),
        ("/api/detectors/flame", json!({ "signal": "alarm", "kind": "heat" }), 400, "bad_request"),
        (
            "/api/detectors/flame",
            json!({ "signal": "alarm", "bearing_deg": 400 }),
            400,
            "bad_request",
        ),
        ("/api/detectors/flame", json!({ "signal": "alarm", "sure": 1 }), 400, "bad_request"),
        ("/api/detectors/flame/bypass", json!({ "bypass": "gone" }), 400, "bad_request"),
        ("/api/wind", json!({ "from_deg": 90 }), 400, "bad_request"),
        ("/api/wind", json!({ "from_deg": 400, "speed_mps": 3 }), 400, "bad_request"),
        ("/api/wind", json!({ "from_deg": 90, "speed_mps": 41 }), 400, "bad_request"),
        ("/api/zones/cellar/abort", json!({}), 404, "zone_refused"),
        ("/api/zones/hall/release", json!({}), 400, "confirm_needed"),
        ("/api/zones/hall/mode", json!({ "mode": "automtic" }), 400, "bad_request"),
        ("/api/zones/hall/mode", json!({ "mode": "test_outlet" }), 409, "zone_refused"),
        ("/api/zones/hall/mode", json!({ "mode": "off", "for_s": 0 }), 409, "zone_refused"),
        ("/api/zones/hall/hold", json!({ "on": "yes" }), 400, "bad_request"),
    ] {
        let reply = post(path, body.clone()).await;
        assert_eq!((reply.status, reply.code()), (status, code), "{path} {body}: {reply:?}");
        let error = &reply.body["error"];
        assert!(["en", "ru"].iter().all(|it| error[*it].as_str().is_some_and(|it| it.len() > 10)));
    }
    assert_eq!(state(&site).await["zones"][0]["phase"], "quiet");
    let without = Site::open(1).await;
    let reply = without.get("", "/api/zones").await;
    assert_eq!((reply.status, reply.code()), (404, "no_zones"));
}

/// Orders that count only when they come in time, with their bodies.
const IN_TIME: [(&str, &str); 8] = [
    ("zones/hall/release", r#"{"confirm":"hall"}"#),
    ("zones/hall/hold", r#"{"on":true}"#),
    ("zones/hall/mode", r#"{"mode":"off"}"#),
    ("zones/hall/reset", "{}"),
    ("zones/reset", "{}"),
    ("zones/unlock", "{}"),
    ("detectors/flame/bypass", r#"{"bypass":"disabled"}"#),
    ("pumps/p1", r#"{"on":true}"#),
];

/// A network that was dead delivers what was sent meanwhile, when people have walked up to the monitor.
#[tokio::test]
async fn an_order_that_comes_late_is_refused() {
    let site = quiet(1, "").await;
    tokio::time::sleep(Duration::from_millis(2100)).await;
    let late = site.hub.up_ms() - 2000;
    for (path, body) in IN_TIME {
        let body: Value = serde_json::from_str(body).unwrap();
        let post =
            async |query: &str| site.post("", &format!("/api/{path}?{query}"), body.clone()).await;
        let reply = post(&format!("up_ms={late}")).await;
        assert_eq!((reply.status, reply.code()), (409, "late"), "{path}: {reply:?}");
        let future = format!("up_ms={}", site.hub.up_ms() + 60_000);
        for query in ["up_ms=soon", "up_ms=NaN", "not_after_ms=1", &future] {
            assert_eq!(post(query).await.status, 400, "{path} {query}");
        }
    }
    assert_eq!(state(&site).await["zones"][0]["phase"], "quiet");
    assert!(is_closed(&site, "M1"));
    let now = format!("hall/release?up_ms={}", site.hub.up_ms());
    assert_eq!(order(&site, &now, json!({ "confirm": "hall" })).await.status, 200);
    let abort = format!("hall/abort?up_ms={late}");
    assert_eq!(order(&site, &abort, json!({})).await.status, 200, "what ends water is never late");
}

/// Nor does one count that was under way when another person ended the zone, or locked all: what that ended would be
/// ready again.
#[tokio::test]
async fn an_order_that_was_under_way_when_someone_said_no_is_void() {
    for (no, ends_all) in [("zones/hall/abort", false), ("zones/lock", true)] {
        let site = quiet(1, "").await;
        let sent = site.hub.up_ms();
        tokio::time::sleep(Duration::from_millis(20)).await;
        assert_eq!(site.post("", &format!("/api/{no}"), json!({})).await.status, 200);
        let before = state(&site).await;
        let undone = |it: &(&str, &str)| !it.0.ends_with("hold") && !it.0.ends_with("mode");
        for (path, body) in IN_TIME.into_iter().filter(undone) {
            let body: Value = serde_json::from_str(body).unwrap();
            let reply = site.post("", &format!("/api/{path}?up_ms={sent}"), body).await;
            // A slow machine takes its time.
            let late = site.hub.up_ms() - sent >= 1900 && reply.code() == "late";
            assert_eq!(reply.status, 409, "{no} {path}: {reply:?}");
            assert!(reply.code() == "void" || late, "{no} {path}: {reply:?}");
        }
        let after = state(&site).await;
        assert_eq!(after["lockout"], before["lockout"]);
        assert_eq!(after["zones"][0]["phase"], before["zones"][0]["phase"]);
        // Nor is one at the same time as a no; later than that it counts.
        tokio::time::sleep(Duration::from_millis(2100)).await;
        let again = if ends_all { "zones/unlock" } else { "zones/hall/reset" };
        let again = format!("/api/{again}?up_ms={}", site.hub.up_ms());
        assert_eq!(site.post("", &again, json!({})).await.status, 200, "{no}");
    }
}

#[tokio::test]
async fn each_order_has_its_role() {
    let zones = hall(1, "");
    let site = Site::with(1, |config| config.zones = Some(zones)).await;
    let tokens = site.tokens();
    for (path, body, least) in [
        ("/api/detectors/flame", json!({ "signal": "quiet" }), Role::Operator),
        ("/api/wind", json!({ "from_deg": 90, "speed_mps": 3 }), Role::Operator),
        ("/api/zones/hall/abort", json!({}), Role::Observer),
        ("/api/zones/lock", json!({}), Role::Observer),
        ("/api/zones/unlock", json!({}), Role::Operator),
        ("/api/zones/silence", json!({}), Role::Operator),
        ("/api/zones/hall/reset", json!({}), Role::Operator),
        ("/api/zones/hall/hold", json!({ "on": false }), Role::Operator),
        ("/api/zones/hall/release", json!({ "confirm": "hallo" }), Role::Operator),
        ("/api/zones/hall/mode", json!({ "mode": "automatic" }), Role::Engineer),
        ("/api/detectors/flame/bypass", json!({ "bypass": "none" }), Role::Engineer),
    ] {
        for (role, token) in &tokens {
            let reply = site.post(token, path, body.clone()).await;
            assert_eq!(reply.code() == "role", *role < least, "{path} {role:?}: {reply:?}");
        }
        let reply = site.http("POST", path, &[], &body.to_string()).await;
        assert_eq!((reply.status, reply.code()), (401, "login_needed"), "{path}");
    }
}

#[tokio::test]
async fn the_websocket_has_what_becomes_of_the_zones() {
    let site = quiet(1, "coincidence_s = 0\ndelay_s = 1").await;
    let mut socket = site.ws("").await;
    socket.next_of("state").await;
    fire(&site).await;
    let phase = |known: &serde_json::Map<String, Value>| {
        known.get("zones").map_or(Value::Null, |zones| zones["state"]["zones"][0]["phase"].clone())
    };
    socket.until("the countdown", |known| phase(known) == "countdown").await;
    socket.until("the release", |known| phase(known)["released"]["automatic"] == true).await;
    assert_eq!(socket.known["zones"]["reported"]["flame"]["signal"], "alarm");
}

#[tokio::test]
async fn clients_learn_what_belongs_to_a_zone_and_a_mode_that_returns_is_sent_each_second() {
    let site = quiet(2, "delay_s = 7\nhold = false\nreturn_after_s = 900").await;
    let expected = json!({
        "zones": [{
            "zone": "hall", "detectors": ["flame", "heat"], "monitors": ["M1", "M2"], "votes": "2oo2", "kinds": 1,
            "coincidence_s": 5, "delay_s": 7, "hold_max_s": null, "water_max_s": 600, "return_after_s": 900,
        }],
        "detectors": { "flame": "flame", "heat": "heat" },
    });
    assert_eq!(site.get("", "/api/zones/configured").await.body, expected);
    let mut socket = site.ws("").await;
    socket.next_of("state").await;
    socket.until("its topic", |known| known.get("zones/configured") == Some(&expected)).await;
    order(&site, "hall/mode", json!({ "mode": "manual" })).await;
    let left = |known: &serde_json::Map<String, Value>| {
        known.get("zones").and_then(|it| it["state"]["zones"][0]["returns_in_ms"].as_u64())
    };
    for most in [900_000, 899_000, 898_000] {
        socket.until("time passes", |known| left(known).is_some_and(|left| left <= most)).await;
    }
}

#[tokio::test]
async fn an_alarm_is_silenced_until_something_new_and_a_countdown_is_not() {
    let site = quiet(1, "coincidence_s = 0\ndelay_s = 30").await;
    sees(&site, "flame", "alarm").await;
    assert_eq!(state(&site).await["tone"], "alarm");
    let silenced = order(&site, "silence", Value::Null).await;
    assert_eq!((silenced.status, &silenced.body["state"]["tone"]), (200, &json!("off")));
    sees(&site, "heat", "alarm").await;
    until_state(&site, "it counts", |zone| zone["phase"] == "countdown").await;
    assert_eq!(order(&site, "silence", Value::Null).await.body["state"]["tone"], "countdown");
}

/// The example of the documents is read without a problem.
#[test]
fn the_example_of_the_document_is_right() {
    let documents = [
        include_str!("../../../../docs/installation.md"),
        include_str!("../../../../docs/installation.ru.md"),
    ];
    let examples = documents.map(|text| {
        let example = text.split("```toml\n").nth(1).and_then(|it| it.split("```").next());
        example.expect("an example").to_owned()
    });
    assert_eq!(examples[0], examples[1]);
    let read = Config::parse("hub.toml", &examples[0], Path::new("/"), &Overrides::default());
    let zones = read.unwrap_or_else(|problems| panic!("{problems:#?}")).zones.expect("zones");
    assert_eq!((zones.site.zones.len(), zones.site.detectors.len()), (1, 3));
}

/// A console that is left open with the control of a monitor does not keep it from a fire: it is asked, as by
/// another operator, and what it answers counts. Nothing is taken by force.
#[tokio::test]
async fn who_holds_a_monitor_is_asked_when_votes_need_it() {
    let site = quiet(1, "coincidence_s = 0\ndelay_s = 60").await;
    let mut anna = site.ws("").await;
    anna.authority("M1", "take").await;
    let held = |value: &Value| value["holder"]["user"] == "demo";
    until_state(&site, "it is seen", |zone| zone["ready"] == false).await;
    fire(&site).await;
    let asked = anna.next_of("asked").await;
    assert_eq!((&asked["monitor"], &asked["by"]["user"]), (&json!("M1"), &json!("zones")));
    // The votes are gone: no zone needs it any more, and she keeps it.
    sees(&site, "heat", "quiet").await;
    let station = site.hub.station("M1").unwrap();
    let control = || serde_json::to_value(station.control(&site.hub)).unwrap();
    until("the request is withdrawn", || control()["request"].is_null()).await;
    assert!(held(&control()), "{:#}", control());
    // The next time she refuses: she is not asked again for the same votes.
    sees(&site, "heat", "alarm").await;
    anna.next_of("asked").await;
    anna.authority("M1", "deny").await;
    assert!(stays(Duration::from_secs(1), || control()["request"].is_null()).await);
    assert!(held(&control()));
    // Once the zone is released she is asked again, and gives way.
    assert_eq!(order(&site, "hall/release", json!({ "confirm": "hall" })).await.status, 200);
    anna.next_of("asked").await;
    anna.authority("M1", "grant").await;
    until("it gives water", || is_open(&site, "M1")).await;
}
