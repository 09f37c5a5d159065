//! Clients that ask for more than they could need: others do not notice, and nothing grows.

use std::time::{Duration, Instant};

use crate::support::{PATIENCE, Site, until};
use futures_util::SinkExt;
use futures_util::future::join_all;
use lafet_hub::access::Role;
use lafet_proto::RequestId;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::Message;

/// Frames with this request that go out, as long as the count is wanted.
fn count_frames(site: &Site, request: RequestId) -> std::sync::Arc<std::sync::atomic::AtomicU64> {
    use std::sync::atomic::{AtomicU64, Ordering};
    let count = std::sync::Arc::new(AtomicU64::new(0));
    let client = site.hub.station("M1").unwrap().client().unwrap();
    let (mut frames, own) = (client.trace(), count.clone());
    tokio::spawn(async move {
        while let Ok(frame) = frames.recv().await {
            let sent = frame.direction() == lafet_client::Direction::Sent;
            if sent && frame.payload.first() == Some(&request.0) {
                own.fetch_add(1, Ordering::Relaxed);
            }
        }
    });
    count
}

#[tokio::test]
async fn equal_stops_share_their_frames_and_each_is_answered() {
    const STOPS: u64 = 150;
    let site = Site::with(1, |_| {}).await;
    let (one, other) = (site.token(Role::Observer), site.token(Role::Operator));
    let mut flood = site.ws(&one).await;
    let mut operator = site.ws(&other).await;
    let frames = count_frames(&site, RequestId::STOP);
    for id in 0..STOPS {
        flood.send(json!({ "type": "stop", "monitor": "M1", "id": id })).await;
    }
    let stopped = operator.ask(json!({ "type": "stop", "monitor": "M1" })).await;
    assert_eq!(stopped["result"]["ok"], true, "{stopped}");
    let mut answered = Vec::new();
    while answered.len() < STOPS as usize {
        let answer = flood.next_of("answer").await;
        assert_eq!(answer["result"]["ok"], true, "{answer}");
        answered.push(answer["id"].as_u64().unwrap());
    }
    answered.sort_unstable();
    assert!(answered.into_iter().eq(0..STOPS));
    let sent = frames.load(std::sync::atomic::Ordering::Relaxed);
    assert!((2..STOPS).contains(&sent), "{sent} frames for {STOPS} Stops");
    // Each is in the log: by itself, or counted with those that it repeats.
    let log = || site.hub.audit().latest(None, 1000, Some("M1".into()), Some("observer".into()));
    let stops = |log: Vec<lafet_hub::store::Entry>| {
        let of = |entry: &lafet_hub::store::Entry| match entry.record.outcome.as_str() {
            "asked" => 1,
            "repeated" => entry.record.details["count"].as_u64().unwrap(),
            _ => 0,
        };
        log.iter().map(of).sum::<u64>()
    };
    timeout(PATIENCE, async { while stops(log().await.unwrap()) < STOPS {} }).await.unwrap();
    let log = log().await.unwrap();
    let repeated = log.iter().find(|it| it.record.outcome == "repeated").unwrap();
    let (first, last) = (&repeated.record.details["first_ms"], &repeated.record.details["last_ms"]);
    assert!(first.as_u64().unwrap() <= last.as_u64().unwrap());
    assert_eq!(stops(log), STOPS);
}

#[tokio::test]
async fn a_stop_after_a_motion_is_sent_and_noted_by_itself() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    for round in 1..=5 {
        let moved =
            json!({ "type": "request", "monitor": "M1", "request": "Move Horizontal 5000" });
        assert_eq!(operator.ask(moved).await["result"]["ok"], true);
        until("it moves", || site.bus.commanded(0, 1) != 0).await;
        let stopped = operator.ask(json!({ "type": "stop", "monitor": "M1" })).await;
        assert_eq!(stopped["result"]["ok"], true);
        until("it stops", || site.bus.commanded(0, 1) == 0).await;
        until("stored", || site.hub.audit().waiting() == 0).await;
        let log = site.hub.audit().latest(None, 1000, None, None).await.unwrap();
        let asked = log.iter().filter(|it| it.record.what == "Stop All");
        assert_eq!(asked.filter(|it| it.record.outcome == "asked").count(), round);
    }
}

/// A client that takes no answers is not read from any more: what it sends stays where it is.
#[tokio::test]
async fn answers_that_are_not_taken_hold_up_their_own_client_alone() {
    let site = Site::open(2).await;
    let id = "x".repeat(15_000);
    let message = json!({ "type": "stop", "monitor": "M9", "id": id }).to_string();
    let mut floods = join_all((0..4).map(|_| site.ws(""))).await;
    for flood in &mut floods {
        let mut sent = 0_usize;
        let feed = async {
            while sent < 256 << 20
                && flood.socket.feed(Message::text(message.clone())).await.is_ok()
            {
                sent += message.len();
            }
        };
        _ = timeout(Duration::from_secs(1), feed).await;
        // What the system buffers of a connection is some MiB.
        assert!(sent < 64 << 20, "{sent} bytes");
    }
    let mut operator = site.ws("").await;
    for _ in 0..10 {
        let stopped = operator.ask(json!({ "type": "stop" })).await;
        assert_eq!(stopped["results"]["M1"]["ok"], true, "{stopped}");
        assert_eq!(stopped["results"]["M2"]["ok"], true, "{stopped}");
    }
    assert!(site.hub.stations().iter().all(|station| station.health() == "up"));
}

#[tokio::test]
async fn what_is_echoed_is_short() {
    let site = Site::open(1).await;
    let mut socket = site.ws("").await;
    let long = "ж".repeat(3000);
    for message in [
        json!({ "type": "stop", "monitor": long, "id": 1 }),
        json!({ "type": long, "id": 1 }),
        json!({ "type": "authority", "monitor": "M1", "action": long, "id": 1 }),
        json!({ "type": "request", "monitor": "M1", "request": "Stop All", "id": long }),
    ] {
        socket.send(message).await;
        let answer = socket.next_of("answer").await;
        assert!(answer.to_string().len() < 2000, "{answer}");
    }
    socket.send(json!({ "type": "jog", "monitor": long, "drive": long, "toward": "max" })).await;
    let jog = socket.next_of("jog").await;
    assert!(jog.to_string().len() < 2000 && jog["end"] == "refused", "{jog}");
}

/// What is known is said at once, and the worst monitor keeps back no other's result.
#[tokio::test]
async fn each_result_is_sent_as_it_comes() {
    let site = Site::open(3).await;
    site.bus.lock()[1].power_off();
    let mut socket = site.ws("").await;
    socket.send(json!({ "type": "stop", "id": 7 })).await;
    let (mut seen, mut answer) = (Vec::new(), Value::Null);
    while answer.is_null() {
        let message = socket.next().await.unwrap();
        match message["type"].as_str() {
            Some("progress") => seen.push(message),
            Some("answer") => answer = message,
            _ => {}
        }
    }
    let of = |monitor: &str| -> Vec<(bool, bool)> {
        let own = seen.iter().filter(|it| it["monitor"] == monitor && it["id"] == 7);
        own.map(|it| (it["answered"] == true, it["result"]["ok"] == true)).collect()
    };
    assert_eq!((of("M1"), of("M3")), (vec![(true, true)], vec![(true, true)]), "{seen:?}");
    assert_eq!(of("M2"), [(false, false), (true, false)], "{seen:?}");
    let silent = seen.iter().position(|it| it["monitor"] == "M2" && it["answered"] == true);
    assert_eq!(silent, Some(seen.len() - 1), "the silent one is the last");
    assert_eq!(answer["results"]["M1"]["ok"], true);
    assert_eq!(answer["results"]["M2"]["error"]["code"], "outcome_unknown");
    // Of one monitor: first that there is no answer yet.
    socket.send(json!({ "type": "stop", "monitor": "M2", "id": 8 })).await;
    let first = socket.next_where(|it| it["id"] == 8).await;
    assert_eq!((&first["type"], &first["answered"]), (&json!("progress"), &json!(false)));
    let then = socket.next_where(|it| it["id"] == 8).await;
    assert_eq!(then["error"]["code"], "outcome_unknown", "{then}");
    // Over HTTP: all that is known soon.
    let reply = site.post("", "/api/stop", json!({})).await;
    assert_eq!(reply.body["M2"], json!({ "pending": true }), "{reply:?}");
    assert_eq!((&reply.body["M1"]["ok"], &reply.body["M3"]["ok"]), (&json!(true), &json!(true)));
}

#[tokio::test]
async fn what_no_monitor_has_does_not_overtake() {
    let site = Site::with(1, |_| {}).await;
    let observer = site.token(Role::Observer);
    let stop = json!({ "request": "Stop 0x01" });
    let refused = site.post(&observer, "/api/monitors/M1/requests", stop).await;
    assert_eq!((refused.status, refused.code()), (403, "role"), "{refused:?}");
}

/// However many requests have come in one reading: between two of them others have their turn.
#[tokio::test]
async fn requests_that_come_together_take_turns() {
    const FLOOD: usize = 190;
    let site = Site::open(1).await;
    let connect = || tokio::net::TcpStream::connect(site.address);
    let request = |path: &str| format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n");
    let (mut flood, mut other) = (connect().await.unwrap(), connect().await.unwrap());
    // Both connections are served before anything counts.
    for stream in [&mut flood, &mut other] {
        stream.write_all(request("/health").as_bytes()).await.unwrap();
        assert_ne!(stream.read(&mut [0; 4096]).await.unwrap(), 0);
    }
    flood.write_all(request("/health").repeat(FLOOD).as_bytes()).await.unwrap();
    other.write_all(request("/health").as_bytes()).await.unwrap();
    let answer = timeout(PATIENCE, other.read(&mut [0; 4096])).await;
    assert_ne!(answer.unwrap().unwrap(), 0);
    let mut answers = vec![0; 1 << 20];
    let len = flood.try_read(&mut answers).unwrap_or(0);
    let answered = String::from_utf8_lossy(&answers[..len]).matches("HTTP/1.1 200").count();
    assert!(answered < FLOOD / 2, "{answered} of {FLOOD} before another's one");
}

/// A client that sends more than it may over many connections, and leaves each of them open: few are kept while they
/// end.
#[tokio::test]
async fn few_connections_are_kept_that_sent_too_many_messages() {
    const FLOODS: usize = 90;
    /// Of an address, the reading of their number, and what is just being closed.
    const KEPT: usize = 64 + 1 + 4;
    const PING: [u8; 6] = [0x89, 0x80, 0, 0, 0, 0];
    const TOO_MANY: [u8; 2] = 4429_u16.to_be_bytes();
    let site = Site::open(1).await;
    let mut floods = Vec::new();
    let began = Instant::now();
    for _ in 0..FLOODS {
        // It has what the one before it has left, and never answers that it is closed.
        let mut flood = site.ws("").await;
        let stream = flood.socket.get_mut();
        stream.write_all(&PING.repeat(2000)).await.unwrap();
        let (mut heard, mut buffer) = (Vec::new(), [0; 4096]);
        while !heard.windows(2).any(|it| *it == TOO_MANY) {
            let len = timeout(PATIENCE, stream.read(&mut buffer)).await.unwrap().unwrap();
            assert_ne!(len, 0, "it is closed in order");
            heard.extend_from_slice(&buffer[..len]);
        }
        floods.push(flood);
    }
    let few = async {
        loop {
            let metrics = site.get("", "/metrics").await.text;
            let count = metrics.lines().find_map(|it| it.strip_prefix("lafet_connections "));
            match count.unwrap().parse::<f64>().unwrap() as usize {
                0..=KEPT => return,
                _ => tokio::time::sleep(Duration::from_millis(50)).await,
            }
        }
    };
    timeout(Duration::from_secs(1), few).await.expect("few are kept");
    // Each would be kept for 10 s otherwise.
    assert!(began.elapsed() < Duration::from_secs(10), "too slow to show anything");
    drop(floods);
}
