//! Recordings: around alarms, on demand, from elsewhere; and what they show.

use std::collections::BTreeMap;

use crate::support::{self, PATIENCE, Site, until};
use lafet_capture::Direction;
use lafet_hub::access::Role;
use lafet_hub::simulation::Scene;
use serde_json::{Value, json};

async fn list(site: &Site, token: &str) -> Vec<Value> {
    site.get(token, "/api/recordings").await.body.as_array().unwrap().clone()
}

/// Waits until a recording is complete.
async fn complete(site: &Site, token: &str, cause: &str) -> Value {
    let began = tokio::time::Instant::now();
    let mut ticks = tokio::time::interval(std::time::Duration::from_millis(50));
    loop {
        ticks.tick().await;
        assert!(began.elapsed() < PATIENCE, "no recording becomes complete");
        let all = list(site, token).await;
        let done = all.iter().find(|it| it["cause"] == cause && it["recording"] == json!(false));
        if let Some(done) = done {
            return done.clone();
        }
    }
}

async fn bytes(site: &Site, token: &str, name: &str) -> Vec<u8> {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let mut stream = tokio::net::TcpStream::connect(site.address).await.unwrap();
    let head = format!(
        "GET /api/recordings/{name} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\
         Authorization: Bearer {token}\r\n\r\n",
        site.address
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    let mut all = Vec::new();
    stream.read_to_end(&mut all).await.unwrap();
    let end = all.windows(4).position(|it| it == b"\r\n\r\n").unwrap();
    all.split_off(end + 4)
}

async fn upload(site: &Site, token: &str, name: &str, file: &[u8]) -> support::Reply {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let mut stream = tokio::net::TcpStream::connect(site.address).await.unwrap();
    let head = format!(
        "POST /api/recordings/upload?name={name} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\
         Authorization: Bearer {token}\r\nContent-Length: {}\r\n\r\n",
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
    support::Reply {
        status: headers.split(' ').nth(1).and_then(|it| it.parse().ok()).unwrap_or(0),
        headers: headers.to_owned(),
        body: serde_json::from_str(body).unwrap_or_default(),
        text: body.to_owned(),
    }
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// What all lines together leave.
fn played(lines: &[Value]) -> BTreeMap<String, Value> {
    let mut all = BTreeMap::new();
    for line in lines {
        for (topic, value) in line["set"].as_object().unwrap() {
            all.insert(topic.clone(), value.clone());
        }
        for gone in line["gone"].as_array().into_iter().flatten() {
            all.remove(gone.as_str().unwrap());
        }
    }
    all
}

#[tokio::test]
async fn on_demand_with_what_was_before() {
    let site = Site::with(2, |_| {}).await;
    let token = site.token(Role::Operator);
    let begun = site.post(&token, "/api/recordings", json!({ "seconds": 1 })).await;
    assert_eq!(begun.status, 201, "{begun:?}");
    assert_eq!(begun.body[0]["monitors"], json!(["M1", "M2"]), "one recording of both");
    assert_eq!(
        (&begun.body[0]["recording"], &begun.body[0]["by"]),
        (&json!(true), &json!("operator"))
    );
    let name = begun.body[0]["name"].as_str().unwrap().to_owned();
    site.post(&token, "/api/monitors/M1/stop", json!({})).await;
    let done = complete(&site, &token, "asked").await;
    assert_eq!(done["name"], json!(name));
    assert!(done["to_ms"].as_u64().unwrap() >= done["from_ms"].as_u64().unwrap() + 500, "{done}");

    let file = bytes(&site, &token, &name).await;
    let path = std::env::temp_dir().join(format!("lafet-hub-test-{}.mcap", std::process::id()));
    std::fs::write(&path, &file).unwrap();
    let pieces = lafet_capture::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    for direction in [Direction::ToMonitor, Direction::FromMonitor] {
        let count = pieces.iter().filter(|it| it.direction == direction).count();
        assert!(count > 20, "two monitors are polled 20 times a second: {count}");
    }

    let place = format!("/api/recordings/{name}/changes?frames=true");
    let reply = site.get(&token, &place).await;
    assert_eq!(reply.header("content-type"), Some("application/x-ndjson"));
    let text = unchunked(&reply.text);
    let lines = lines(&text);
    assert!(
        lines.len() > 10
            && lines.windows(2).all(|it| it[0]["at_ms"].as_u64() <= it[1]["at_ms"].as_u64())
    );
    let all = played(&lines);
    assert_eq!(all["monitors/M1/status"]["subsystems"]["General"]["bits"], 0);
    assert_eq!(all["monitors/M2/info"]["name"]["ru"], "М2");
    assert!(all.contains_key("monitors/M2/readiness"), "{:?}", all.keys());
    let frames: Vec<&Value> =
        lines.iter().filter_map(|it| it["frames"].as_array()).flatten().collect();
    assert!(frames.iter().any(|it| it["text"] == "Stop All" && it["direction"] == "out"));
    let middle = lines[lines.len() / 2]["at_ms"].as_u64().unwrap();
    let place = format!("/api/recordings/{name}/changes?from_ms={middle}");
    let later = unchunked(&site.get(&token, &place).await.text);
    let first: Value = serde_json::from_str(later.lines().next().unwrap()).unwrap();
    assert_eq!(first["at_ms"], json!(middle));
    assert!(first["set"]["monitors/M1/status"].is_object(), "everything as it was: {first}");
}

/// The body of an answer in pieces.
fn unchunked(text: &str) -> String {
    let (mut rest, mut all) = (text, String::new());
    while let Some((size, more)) = rest.split_once("\r\n") {
        let Ok(size) = usize::from_str_radix(size, 16) else { return text.to_owned() };
        all += &more[..size];
        rest = more.get(size + 2..).unwrap_or_default();
    }
    all
}

#[tokio::test]
async fn an_alarm_is_recorded_from_before_it() {
    let site = Site::with(1, |config| config.recording.after_s = 1).await;
    let token = site.token(Role::Observer);
    until("it is polled", || site.hub.station("M1").unwrap().status().at_ms.is_some()).await;
    site.post(&token, "/api/monitors/M1/lockout", json!({})).await;
    let done = complete(&site, &token, "alarm").await;
    let alarm = done["alarm"].as_str().unwrap();
    assert_eq!(alarm, "M1/General/LockedOut", "{done}");
    assert!(done["name"].as_str().unwrap().ends_with("-M1-alarm.mcap"), "{done}");
    let place = format!("/api/recordings/{}/changes", done["name"].as_str().unwrap());
    let lines = lines(&unchunked(&site.get(&token, &place).await.text));
    assert!(!lines[0]["set"].as_object().unwrap().contains_key(&format!("alarms/{alarm}")));
    assert_eq!(played(&lines)[&format!("alarms/{alarm}")]["state"], "unack");
}

#[tokio::test]
async fn files_from_elsewhere() {
    let site = Site::with(1, |_| {}).await;
    let (operator, engineer) = (site.token(Role::Operator), site.token(Role::Engineer));
    site.post(&operator, "/api/recordings", json!({ "seconds": 1, "monitor": "M1" })).await;
    let own = complete(&site, &operator, "asked").await;
    let file = bytes(&site, &operator, own["name"].as_str().unwrap()).await;

    let added = upload(&site, &operator, "..%2Fnight%20run.mcap", &file).await;
    assert_eq!(added.status, 201, "{added:?}");
    assert_eq!(added.body["name"], "night_run.mcap");
    assert_eq!(added.body["monitors"], json!(["M1"]));
    assert_eq!(added.body["cause"], "uploaded");
    let again = upload(&site, &operator, "night%20run.mcap", &file).await;
    assert_eq!(again.body["name"], "night_run-2.mcap");
    let played_back = site.get(&operator, "/api/recordings/night_run.mcap/changes").await;
    assert!(played(&lines(&unchunked(&played_back.text))).contains_key("monitors/M1/status"));

    let refused = upload(&site, &operator, "a.mcap", b"no recording").await;
    assert_eq!((refused.status, refused.code()), (400, "bad_request"), "{refused:?}");
    let torn = upload(&site, &operator, "torn.mcap", &file[..40]).await;
    assert!(torn.status == 400 || torn.status == 201, "{torn:?}");
    let observer = site.token(Role::Observer);
    assert_eq!(upload(&site, &observer, "a.mcap", &file).await.code(), "role");
    let remove = |token: String, name: &'static str| {
        let site = &site;
        async move {
            let header = format!("Bearer {token}");
            let headers = [("Authorization", header.as_str())];
            site.http("DELETE", &format!("/api/recordings/{name}"), &headers, "").await
        }
    };
    assert_eq!(remove(operator.clone(), "night_run.mcap").await.code(), "role");
    assert_eq!(remove(engineer.clone(), "night_run.mcap").await.status, 204);
    assert_eq!(remove(engineer.clone(), "night_run.mcap").await.status, 404);
    assert_eq!(remove(engineer, "..%2Fhub.db").await.status, 404);
    let names: Vec<Value> =
        list(&site, &operator).await.iter().map(|it| it["name"].clone()).collect();
    assert!(!names.contains(&json!("night_run.mcap")) && names.contains(&own["name"]));
}

#[tokio::test]
async fn what_makes_no_sense_is_refused() {
    let site = Site::with(1, |_| {}).await;
    let token = site.token(Role::Operator);
    for (body, code) in [
        (json!({}), "bad_request"),
        (json!({ "seconds": 0 }), "bad_request"),
        (json!({ "seconds": 99999 }), "bad_request"),
        (json!({ "seconds": 1, "monitor": "M9" }), "no_monitor"),
    ] {
        assert_eq!(site.post(&token, "/api/recordings", body.clone()).await.code(), code, "{body}");
    }
    let observer = site.token(Role::Observer);
    let reply = site.post(&observer, "/api/recordings", json!({ "seconds": 1 })).await;
    assert_eq!(reply.code(), "role");
    assert_eq!(site.get(&token, "/api/recordings/nothing.mcap").await.status, 404);
    assert_eq!(list(&site, &token).await.len(), 0);
}

#[tokio::test]
async fn the_scene_of_a_simulation_is_played_back() {
    let site = Site::with(1, |_| {}).await;
    let token = site.token(Role::Operator);
    site.hub.publish_scene(&Scene { t_s: 1.0, ..Scene::default() });
    let begun = site.post(&token, "/api/recordings", json!({ "seconds": 1 })).await;
    let name = begun.body[0]["name"].as_str().unwrap().to_owned();
    // What changes twice in a millisecond is played back once.
    let first_ms = site.hub.clock().now_ms();
    until("the next millisecond", || site.hub.clock().now_ms() > first_ms).await;
    site.hub.publish_scene(&Scene { t_s: 2.0, ..Scene::default() });
    complete(&site, &token, "asked").await;
    let reply = site.get(&token, &format!("/api/recordings/{name}/changes")).await;
    let lines = lines(&unchunked(&reply.text));
    let scenes: Vec<&Value> = lines.iter().filter_map(|it| it["set"].get("scene")).collect();
    assert_eq!(scenes[0]["t_s"], 1.0, "what was before is there: {scenes:?}");
    assert_eq!(scenes[scenes.len() - 1]["t_s"], 2.0);
    assert!(played(&lines).contains_key("monitors/M1/status"));
}

/// Who sends slowly has the only turn: it is another's as soon as the sender may not send any more.
#[tokio::test]
async fn an_upload_does_not_outlast_the_rights_of_its_sender() {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let site = Site::with(1, |_| {}).await;
    let operator = site.token(Role::Operator);
    let (id, secret) = site.hub.access().add_token(1, "late", Role::Operator).unwrap();
    let head = format!(
        "POST /api/recordings/upload?name=late.mcap HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\
         Authorization: Bearer {secret}\r\nContent-Length: 1000\r\n\r\nthe first part"
    );
    let mut stream = tokio::net::TcpStream::connect(site.address).await.unwrap();
    stream.write_all(head.as_bytes()).await.unwrap();
    let other = async || upload(&site, &operator, "a.mcap", b"no recording").await;
    let began = tokio::time::Instant::now();
    while other().await.code() != "slow_down" {
        assert!(began.elapsed() < PATIENCE, "it has no turn");
    }
    site.hub.access().remove_token(id).unwrap();
    stream.write_all(b"the second part").await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    assert!(answer.starts_with("HTTP/1.1 401 "), "{answer}");
    let next = other().await;
    assert_eq!((next.status, next.code()), (400, "bad_request"), "{next:?}");
    assert_eq!(list(&site, &operator).await, Vec::<Value>::new());
}

/// Without a folder for recordings the hub works, and says so; it records when there is one.
#[tokio::test]
async fn a_folder_that_cannot_be_used_keeps_no_hub_from_its_work() {
    let place = std::env::temp_dir().join(format!("lafet-no-folder-{}", std::process::id()));
    std::fs::write(&place, "a file where the folder should be").unwrap();
    let own = place.clone();
    let site = Site::with(1, |config| config.recording.folder = Some(own)).await;
    let token = site.token(Role::Engineer);
    let active = || site.hub.alarms().get("hub/Recordings").is_some_and(|it| it.active);
    until("it is an alarm", active).await;
    let stopped = site.post(&token, "/api/monitors/M1/stop", json!({ "of": "All" })).await;
    assert_eq!(stopped.status, 200, "{stopped:?}");
    assert_eq!(list(&site, &token).await, Vec::<Value>::new());
    std::fs::remove_file(&place).unwrap();
    let reply = site.post(&token, "/api/recordings", json!({ "seconds": 1 })).await;
    assert_eq!(reply.status, 201, "{reply:?}");
    complete(&site, &token, "asked").await;
    until("the alarm ends", || !active()).await;
    drop(site);
    std::fs::remove_dir_all(&place).unwrap();
}

/// What a hub that was killed was writing is completed while the next one works already.
#[tokio::test]
async fn an_unfinished_recording_is_mended() {
    let place = std::env::temp_dir().join(format!("lafet-unfinished-{}", std::process::id()));
    let own = place.clone();
    let site = Site::with(1, |config| config.recording.folder = Some(own)).await;
    let token = site.token(Role::Engineer);
    let reply = site.post(&token, "/api/recordings", json!({ "seconds": 1 })).await;
    let name = reply.body[0]["name"].as_str().unwrap().to_owned();
    let done = complete(&site, &token, "asked").await;
    drop(site);
    let about = place.join(format!("{name}.json"));
    let mut meta: Value = serde_json::from_slice(&std::fs::read(&about).unwrap()).unwrap();
    (meta["recording"], meta["to_ms"]) = (json!(true), meta["from_ms"].clone());
    std::fs::write(&about, meta.to_string()).unwrap();
    let own = place.clone();
    let site = Site::with(1, |config| config.recording.folder = Some(own)).await;
    let token = site.token(Role::Engineer);
    let mended = complete(&site, &token, "asked").await;
    assert_eq!((&mended["name"], &mended["size"]), (&done["name"], &done["size"]));
    let apart = mended["to_ms"].as_u64().unwrap().abs_diff(done["to_ms"].as_u64().unwrap());
    assert!(apart < 1000, "{mended} after {done}");
    drop(site);
    std::fs::remove_dir_all(&place).unwrap();
}
