//! Stop and Lockout of every monitor, as the audit log has them.

use std::time::Duration;

use lafet_hub::access::Role;
use lafet_hub::store::Record;
use serde_json::json;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;

use crate::support::{PATIENCE, Site};

/// The entries about all monitors, the oldest first, once there are so many with this outcome.
async fn entries(site: &Site, outcome: &str, count: usize) -> Vec<Record> {
    let began = tokio::time::Instant::now();
    loop {
        let log = site.hub.audit().latest(None, 1000, None, None).await.unwrap();
        let all = log.into_iter().rev().map(|it| it.record);
        let all: Vec<Record> = all.filter(|it| it.monitor == "*").collect();
        if all.iter().filter(|it| it.outcome == outcome).count() >= count {
            return all;
        }
        assert!(began.elapsed() < PATIENCE, "{all:?}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

fn outcomes(all: &[Record]) -> Vec<&str> {
    all.iter().map(|it| it.outcome.as_str()).collect()
}

#[tokio::test]
async fn it_has_three_entries_however_many_monitors_there_are() {
    let site = Site::open(5).await;
    site.bus.silence(3);
    let reply = site.post("", "/api/stop", json!({})).await;
    let number = reply.body["M1"]["audit"].as_u64().expect("its entry");
    assert_eq!(reply.body["M2"]["audit"].as_u64(), Some(number));
    let all = entries(&site, "effect", 1).await;
    assert_eq!(outcomes(&all), ["asked", "outcome_unknown", "effect"]);
    let answered = &all[1].details;
    assert_eq!(answered["asked"], number);
    let monitors = json!({ "Ok": ["M1", "M2", "M4", "M5"], "outcome_unknown": ["M3"] });
    assert_eq!(answered["monitors"], monitors);
    let effect = &all[2].details;
    assert_eq!(effect["silent"], json!(["M3"]), "{effect}");
    assert_eq!((&effect["moving"], &effect["flowing"]), (&json!([]), &json!([])));
    let log = site.hub.audit().latest(None, 1000, Some("M2".into()), None).await.unwrap();
    assert_eq!(
        log.iter().filter(|it| it.record.what == "Stop All").count(),
        3,
        "found by a monitor"
    );
    let log = site.hub.audit().latest(None, 1000, Some(String::new()), None).await.unwrap();
    assert!(log.iter().all(|it| it.record.what != "Stop All"), "what is about the hub is apart");
}

/// Assumed: who asks waits for nothing, as a script does that ends, or a page that is closed.
#[tokio::test]
async fn a_stop_of_who_has_gone_at_once_is_carried_out() {
    let site = Site::open(1).await;
    for (number, gone) in [false, true].into_iter().enumerate() {
        let mut stream = TcpStream::connect(site.address).await.unwrap();
        let head = "POST /api/stop HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json";
        let request = format!("{head}\r\nContent-Length: 2\r\n\r\n{{}}");
        stream.write_all(request.as_bytes()).await.unwrap();
        stream.shutdown().await.unwrap();
        let _kept = (!gone).then_some(stream);
        let all = entries(&site, "effect", number + 1).await;
        assert_eq!(outcomes(&all).len(), 3 * (number + 1), "{gone}");
    }
}

#[tokio::test]
async fn what_moves_and_flows_all_the_same_is_named() {
    let site = Site::open(2).await;
    let mut operator = site.ws("").await;
    operator.authority("M2", "take").await;
    assert_eq!(site.post("", "/api/stop", json!({})).await.status, 200);
    // Between the Stop and the look at what came of it.
    let ask = |request| json!({ "type": "request", "monitor": "M2", "request": request });
    assert_eq!(operator.ask(ask("Move Horizontal 3000")).await["result"]["ok"], true);
    let all = entries(&site, "effect", 1).await;
    assert_eq!(all.last().unwrap().details["moving"], json!(["M2"]), "{all:?}");
}

#[tokio::test]
async fn repetitions_are_counted_until_another_request_comes() {
    let site = Site::open(3).await;
    let mut socket = site.ws("").await;
    for id in 0..30 {
        socket.send(json!({ "type": "stop", "id": id })).await;
    }
    let all = entries(&site, "repeated", 1).await;
    assert_eq!(outcomes(&all).iter().filter(|it| **it == "asked").count(), 1, "{all:?}");
    let repeated = all.iter().find(|it| it.outcome == "repeated").unwrap();
    assert_eq!(repeated.details["count"], 29);

    let other = site.token(Role::Operator);
    socket.authority("M1", "take").await;
    socket.send(json!({ "type": "stop", "id": 100 })).await;
    socket.send(json!({ "type": "stop", "id": 101 })).await;
    // One that is under way would overtake what follows.
    socket.next_where(|it| it["type"] == "answer" && it["id"] == 101).await;
    let ask = json!({ "type": "request", "monitor": "M1", "request": "Move Vertical 300" });
    let answer = socket.ask(ask).await;
    assert!(answer["error"].is_null(), "{answer}");
    socket.send(json!({ "type": "stop", "id": 102 })).await;
    site.post(&other, "/api/stop", json!({})).await;
    let all = entries(&site, "effect", 4).await;
    let asked =
        |seat: &str| all.iter().filter(|it| it.outcome == "asked" && (it.seat == seat)).count();
    assert_eq!(asked(socket.seat()), 3, "the first series, the second, and after the request");
    assert_eq!(outcomes(&all).iter().filter(|it| **it == "asked").count(), 4, "another user's");
}

/// Many users at once, on many monitors.
#[tokio::test]
async fn a_flood_leaves_entries_of_its_users_not_of_its_monitors() {
    let site = Site::open(8).await;
    let users: Vec<String> = (0..6).map(|_| site.token(Role::Observer)).collect();
    let flood = users.iter().map(async |token| {
        for _ in 0..40 {
            site.post(token, "/api/lockout", json!({})).await;
        }
    });
    futures_util::future::join_all(flood).await;
    entries(&site, "repeated", 6).await;
    let log = site.hub.audit().latest(None, 1000, None, None).await.unwrap();
    let of_one =
        log.iter().filter(|it| it.record.what.starts_with("Lockout") && it.record.monitor != "*");
    assert_eq!(of_one.count(), 0);
    assert_eq!(site.hub.audit().lost(), 0);
}
