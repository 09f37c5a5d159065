//! What is published: state, changes, alarms, history, figures; slow readers and many of them.

use std::time::Duration;

use crate::support::{self, Site, hold_until, until};
use futures_util::future::join_all;
use futures_util::{SinkExt, StreamExt};
use lafet_hub::access::Role;
use lafet_hub::simulation::{Burning, Scene};
use serde_json::{Value, json};
use tokio::time::Instant;
use tokio_tungstenite::tungstenite::Message;

#[tokio::test]
async fn everything_first_then_what_changes() {
    let site = Site::open(2).await;
    let mut operator = site.ws("").await;
    operator.next_of("state").await;
    let parts = [
        "info",
        "status",
        "link",
        "authority",
        "readiness",
        "limits",
        "hotbeds",
        "params",
        "params_progress",
        "program",
    ];
    for part in parts {
        for monitor in ["M1", "M2"] {
            let topic = format!("monitors/{monitor}/{part}");
            assert!(operator.known.contains_key(&topic), "{topic}");
        }
    }
    let position = |known: &serde_json::Map<String, Value>| {
        known["monitors/M1/status"]["subsystems"]["Vertical"]["position"].clone()
    };
    assert_eq!(position(&operator.known), 0);
    operator.authority("M1", "take").await;
    operator
        .ask(json!({ "type": "request", "monitor": "M1", "request": "Move Vertical 300" }))
        .await;
    operator.until("it gets there", |known| position(known) == 300).await;
    assert_eq!(operator.known["monitors/M1/authority"]["holder"]["seat"], operator.seat());
    let limits = &site.get("", "/api/monitors/M1").await.body["limits"];
    assert!(limits["Vertical"]["max"].as_i64().unwrap() > 300);
    let params = site.post("", "/api/monitors/M1/params/read", json!({})).await;
    assert!(params.body["values"]["Vertical"]["Speed"]["values"][0].is_i64(), "{params:?}");
    let set = "/api/monitors/M1/params/Vertical/Speed";
    let reply = site.http("PUT", set, &[], r#"{"values":[5]}"#).await;
    assert_eq!(reply.code(), "no_authority", "the seat over HTTP is another one");
}

#[tokio::test]
async fn a_silent_monitor_is_stale_and_an_alarm() {
    let site = Site::open(1).await;
    let mut socket = site.ws("").await;
    socket.next_of("state").await;
    let good = socket.known["monitors/M1/status"]["at_ms"].clone();
    site.bus.lock()[0].power_off();
    let alarm = "alarms/M1/Link/Stale";
    let told = |known: &serde_json::Map<String, Value>| {
        known["monitors/M1/status"]["stale"] == true && known.contains_key(alarm)
    };
    socket.until("it is stale, and an alarm", told).await;
    let known = socket.known.clone();
    let status = &known["monitors/M1/status"];
    assert!(status["at_ms"].as_u64() >= good.as_u64());
    assert!(status["subsystems"]["Vertical"].is_object(), "the last known stays");
    assert_eq!(
        (&known[alarm]["state"], &known[alarm]["priority"]),
        (&json!("unack"), &json!("high"))
    );
    assert_eq!(site.get("", "/health").await.body["monitors"]["M1"], "stale");
    let reply = site.post("", "/api/stop", json!({})).await;
    assert_eq!(reply.body["M1"], json!({ "pending": true }), "{reply:?}");
    let reply = site.post("", "/api/monitors/M1/stop", json!({})).await;
    assert_eq!((reply.status, &reply.body), (202, &json!({ "pending": true })), "{reply:?}");
    site.bus.lock()[0].power_on();
    let back = |message: &Value| message["set"]["alarms/M1/Link/Stale"]["state"] == "rtn_unack";
    socket.next_where(back).await;
    let acknowledged = site.post("", "/api/alarms/ack", json!({})).await;
    assert_eq!(acknowledged.status, 200);
    let id = json!("alarms/M1/Link/Stale");
    let gone = |message: &Value| message["gone"].as_array().is_some_and(|it| it.contains(&id));
    socket.next_where(gone).await;
    let history = site.get("", "/api/alarms/history").await;
    let all = history.body.as_array().unwrap();
    let last = all.iter().find(|it| it["id"] == "M1/Link/Stale").unwrap();
    assert_eq!((&last["from"], &last["to"]), (&json!("rtn_unack"), &json!("normal")));
    assert_eq!(last["user"], "demo");
}

#[tokio::test]
async fn a_flag_becomes_an_alarm_and_a_shelf_holds_it() {
    let site = Site::open(1).await;
    let mut socket = site.ws("").await;
    site.post("", "/api/monitors/M1/lockout", json!({})).await;
    let id = "M1/General/LockedOut";
    let came = socket.next_where(|it| !it["set"]["alarms/M1/General/LockedOut"].is_null()).await;
    let alarm = &came["set"]["alarms/M1/General/LockedOut"];
    for text in ["what", "cause", "consequence", "remedy"] {
        assert!(alarm[text]["ru"].as_str().unwrap().len() > 10, "{alarm}");
    }
    let ready = site.get("", "/api/monitors/M1").await.body["readiness"].clone();
    assert_eq!(
        (&ready["ready"], &ready["reasons"][0]["flag"]),
        (&json!(false), &json!("LockedOut"))
    );
    let shelved = site
        .post("", "/api/alarms/shelve", json!({ "id": id, "minutes": 5, "reason": "exercise" }))
        .await;
    assert_eq!(
        (&shelved.body["state"], &shelved.body["shelved"]["user"]),
        (&json!("shelved"), &json!("demo"))
    );
    for (minutes, reason) in [(9999, "x"), (5, "a\0b"), (5, "two\nlines")] {
        let body = json!({ "id": id, "minutes": minutes, "reason": reason });
        let refused = site.post("", "/api/alarms/shelve", body).await;
        assert_eq!((refused.status, refused.code()), (400, "bad_request"), "{reason:?}");
    }
    let taken = site.post("", "/api/alarms/unshelve", json!({ "id": id })).await;
    assert_eq!(taken.body["state"], "unack");
}

#[tokio::test]
async fn who_reads_slowly_gets_the_latest_and_holds_up_nobody() {
    let site = Site::open(1).await;
    let mut slow = site.ws("").await;
    let mut quick = site.ws("").await;
    quick.authority("M1", "take").await;
    let filler = vec![Burning { name: "x".repeat(20_000), ..Burning::default() }];
    let published = 3_000;
    for number in 0..published {
        let (t_s, fires) = (f64::from(number), filler.clone());
        site.hub.publish_scene(&Scene { t_s, fires, ..Scene::default() });
        if number % 500 == 0 {
            // Meanwhile another user works undisturbed.
            hold_until(&mut quick, "Vertical", "max", || site.bus.commanded(0, 0) > 0).await;
            quick.ask(json!({ "type": "stop" })).await;
            // One message in all that time: a client that takes nothing at all is cut off after 10 s.
            slow.next().await.expect("it stays connected");
            quick.send(json!({ "type": "jog_end", "monitor": "M1", "drive": "Vertical" })).await;
        }
    }
    let mut received = 0;
    loop {
        let message = slow.next().await.expect("it stays connected");
        received += u32::from(!message["set"]["scene"].is_null());
        if message["set"]["scene"]["t_s"] == f64::from(published - 1) {
            break;
        }
    }
    assert!(received < 200, "{received} of {published}");
}

#[tokio::test]
async fn many_idle_connections_do_not_hold_up_a_stop() {
    let site = Site::open(1).await;
    let mut idle = join_all((0..300).map(|_| site.ws(""))).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    for round in 0..10 {
        let toward = if round % 2 == 0 { "max" } else { "min" };
        hold_until(&mut operator, "Horizontal", toward, || site.bus.commanded(0, 1) != 0).await;
        let stopped = operator.ask(json!({ "type": "stop", "monitor": "M1" })).await;
        assert_eq!(stopped["result"]["ok"], true);
        until("it is at rest", || site.bus.commanded(0, 1) == 0).await;
        operator.send(json!({ "type": "jog_end", "monitor": "M1", "drive": "Horizontal" })).await;
    }
    let metrics = site.get("", "/metrics").await.text;
    assert!(metrics.contains("lafet_stop_seconds_max"), "{metrics}");
    assert!(idle[299].next().await.is_some());
}

#[tokio::test]
async fn garbage_and_floods() {
    let site = Site::open(1).await;
    let mut socket = site.ws("").await;
    socket.send(json!({ "type": "dance", "id": 5 })).await;
    let answer = socket.next_of("answer").await;
    assert_eq!((&answer["id"], &answer["error"]["code"]), (&json!(5), &json!("bad_request")));
    use futures_util::SinkExt;
    use tokio_tungstenite::tungstenite::Message;
    let text = json!({ "type": "watch", "frames": [] }).to_string();
    // More than any user types, and faster than it is allowed.
    for _ in 0..20_000 {
        if socket.socket.feed(Message::Text(text.clone().into())).await.is_err() {
            break;
        }
    }
    _ = socket.socket.flush().await;
    let began = Instant::now();
    let closed = loop {
        assert!(began.elapsed() < support::PATIENCE, "it is not closed");
        match socket.next().await {
            Some(message) if message["type"] == "closed" => break message["code"].clone(),
            Some(_) => {}
            None => break Value::Null,
        }
    };
    // The close may be cut off by what we were still sending.
    assert!(closed == 4429 || closed.is_null(), "{closed}");
    assert_eq!(site.get("", "/health").await.status, 200);
}

/// Each ping is answered: more of them than messages, of a client that reads nothing, would wait to be taken.
#[tokio::test]
async fn what_says_nothing_counts_as_well() {
    const SENT: usize = 20_000;
    let site = Site::open(1).await;
    let payload = vec![0; 100];
    let kinds: [fn(Vec<u8>) -> Message; 3] = [
        |it| Message::Ping(it.into()),
        |it| Message::Pong(it.into()),
        |it| Message::Binary(it.into()),
    ];
    for kind in kinds {
        let began = Instant::now();
        let mut socket = site.ws("").await;
        for _ in 0..SENT {
            if socket.socket.feed(kind(payload.clone())).await.is_err() {
                break;
            }
        }
        _ = socket.socket.flush().await;
        let (mut pongs, mut closed) = (0, Value::Null);
        while let Some(Ok(message)) = socket.socket.next().await {
            assert!(began.elapsed() < support::PATIENCE, "it is not closed");
            match message {
                Message::Pong(_) => pongs += 1,
                Message::Close(frame) => closed = json!(frame.map(|it| u16::from(it.code))),
                _ => {}
            }
        }
        // The close may be cut off by what we were still sending.
        assert!(closed == 4429 || closed.is_null(), "{closed}");
        let allowed = 400.0 + 200.0 * began.elapsed().as_secs_f64();
        assert!(f64::from(pongs) <= allowed, "{pongs} are answered");
    }
}

#[tokio::test]
async fn frames_are_shown() {
    let site = Site::open(2).await;
    let mut socket = site.ws("").await;
    socket.send(json!({ "type": "watch", "frames": ["M2"] })).await;
    // What is read at the start may be sent as well.
    let is_poll = |it: &Value| it["direction"] == "out" && it["text"] == "GetStatus All";
    let sent = socket.next_where(|it| it["type"] == "frame" && is_poll(it)).await;
    assert_eq!(sent["monitor"], "M2");
    let is_status = |it: &Value| {
        it["direction"] == "in" && it["text"].as_str().unwrap().contains("Vertical GetStatus → Ok")
    };
    let heard = socket.next_where(|it| it["type"] == "frame" && is_status(it)).await;
    assert_eq!(heard["monitor"], "M2");
    socket.send(json!({ "type": "watch", "frames": [] })).await;
}

#[tokio::test]
async fn history_and_figures() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    hold_until(&mut operator, "Vertical", "max", || site.bus.position(0, 0) > 240.0).await;
    until("it is polled", || {
        let status = site.hub.stations()[0].status();
        status.subsystems["Vertical"].fields["position"] > 200
    })
    .await;
    let path = "/api/history?monitor=M1&series=Vertical.position,Vertical.bits";
    let body = site.get("", path).await.body;
    let positions = body["series"]["Vertical.position"].as_array().unwrap();
    assert!(positions.len() >= 3, "{body}");
    let values: Vec<f64> = positions.iter().map(|point| point[1].as_f64().unwrap()).collect();
    assert!(values.is_sorted() && values[values.len() - 1] > 60.0, "{values:?}");
    let csv = site.get("", "/api/history.csv?monitor=M1&series=Vertical.position").await;
    assert!(csv.text.starts_with("series,t_ms,value\nVertical.position,"), "{}", csv.text);
    let series = site.get("", "/api/history/series?monitor=M1").await.body;
    let names: Vec<&str> =
        series.as_array().unwrap().iter().map(|it| it["series"].as_str().unwrap()).collect();
    assert!(names.contains(&"Vertical.position") && names.contains(&"General.pressure"));
    let metrics = site.get("", "/metrics").await.text;
    let mut series = std::collections::HashSet::new();
    for line in metrics.lines().filter(|line| !line.starts_with("# ")) {
        let (name, value) = line.rsplit_once(' ').unwrap();
        assert!(value.parse::<f64>().is_ok() && series.insert(name), "{line}");
    }
    for line in [
        "lafet_monitor_up{monitor=\"M1\"} 1",
        "lafet_websockets 1",
        "lafet_status{monitor=\"M1\",subsystem=\"Nozzle\",field=\"position\"} 60",
        "# TYPE lafet_commands_total counter",
    ] {
        assert!(metrics.contains(line), "{line}: {metrics}");
    }
}

#[tokio::test]
async fn what_was_asked_answered_and_came_of_it_is_in_the_log() {
    let site = Site::with(1, |_| {}).await;
    let token = site.token(Role::Engineer);
    let mut operator = site.ws(&token).await;
    operator.authority("M1", "take").await;
    let asked = json!({ "type": "request", "monitor": "M1", "request": "Move Vertical 300" });
    let result = operator.ask(asked).await["result"].clone();
    let has = |outcome: &'static str, log: &[lafet_hub::store::Entry]| {
        log.iter()
            .find(|it| it.record.what == "Move Vertical 300" && it.record.outcome == outcome)
            .cloned()
    };
    let began = Instant::now();
    let log = loop {
        let log = site.hub.audit().latest(None, 100, Some("M1".into()), None).await.unwrap();
        if has("effect", &log).is_some() {
            break log;
        }
        assert!(began.elapsed() < support::PATIENCE, "{log:?}");
        operator.next().await;
    };
    let (asked, answered) =
        (has("asked", &log).unwrap(), has("Accepted", &log).or(has("Ok", &log)).unwrap());
    assert_eq!(answered.record.details["asked"], asked.n);
    assert_eq!(result["audit"], answered.n);
    assert_eq!((answered.record.via.as_str(), answered.record.user.as_str()), ("ws", "engineer"));
    let effect = has("effect", &log).unwrap();
    assert!(
        effect.record.details["state"]["Vertical"]["position"].as_i64().unwrap() > 0,
        "{effect:?}"
    );
    let verified = site.get(&token, "/api/audit/verify").await.body;
    assert_eq!(verified["ok"], true);
    let export = site.get(&token, "/api/audit/export").await;
    assert!(export.text.lines().count() >= 4);
    until("the log is stored", || site.hub.audit().waiting() == 0).await;
}

#[tokio::test]
async fn the_history_is_played_and_exported() {
    let site = Site::open(2).await;
    let mut socket = site.ws("").await;
    site.post("", "/api/monitors/M1/lockout", json!({})).await;
    socket.next_where(|it| !it["set"]["alarms/M1/General/LockedOut"].is_null()).await;
    // A change that follows another one closely is noted with the next poll but one.
    let began = tokio::time::Instant::now();
    let mut ticks = tokio::time::interval(Duration::from_millis(50));
    let reply = loop {
        ticks.tick().await;
        let reply = site.get("", "/api/history/changes?monitor=M1").await;
        if reply.text.contains("LockedOut") {
            break reply;
        }
        assert!(began.elapsed() < support::PATIENCE, "{reply:?}");
    };
    assert_eq!(reply.header("content-type"), Some("application/x-ndjson"));
    let lines: Vec<Value> =
        reply.text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let lines: Vec<&Value> = lines.iter().filter(|it| it["at_ms"].is_u64()).collect();
    let has = |topic: &str| lines.iter().rev().find_map(|it| it["set"].get(topic));
    let status = has("monitors/M1/status").unwrap();
    let flags = status["subsystems"]["General"]["flags"].to_string();
    assert!(flags.contains("LockedOut"), "{status}");
    assert_eq!(has("alarms/M1/General/LockedOut").unwrap()["state"], "unack");
    assert_eq!(has("monitors/M1/info").unwrap()["address"], 1);
    assert!(has("monitors/M2/status").is_none(), "only M1 was asked for");
    let long = site.get("", "/api/history/changes?from_ms=0&to_ms=9999999999").await;
    assert_eq!((long.status, long.code()), (400, "bad_request"));
    assert_eq!(site.get("", "/api/history/changes?monitor=M9").await.code(), "no_monitor");

    let series = "monitor=M1&series=General.bits,General.pressure";
    let parquet = site.get("", &format!("/api/history.parquet?{series}")).await;
    assert_eq!(parquet.header("content-type"), Some("application/vnd.apache.parquet"));
    assert!(parquet.text.starts_with("PAR1") && parquet.text.ends_with("PAR1"));
}

#[tokio::test]
async fn who_looks_at_one_monitor_is_not_sent_the_figures_of_the_others() {
    let site = Site::open(3).await;
    let mut socket = site.ws("").await;
    let status =
        |id: &str, it: &Value| it["set"][format!("monitors/{id}/status")]["at_ms"].as_u64();
    let first = socket.next_where(|it| status("M2", it).is_some()).await;
    assert!(status("M2", &first).is_some(), "without a subscription, everything");
    for monitors in [json!(["M1", "M9"]), json!(vec!["M1"; 33]), json!("M1")] {
        let refused = socket.ask(json!({ "type": "subscribe", "monitors": monitors })).await;
        assert!(refused["error"].is_object(), "{refused}");
    }
    let answer = socket.ask(json!({ "type": "subscribe", "monitors": ["M1"] })).await;
    assert_eq!(answer["subscribed"], json!({ "monitors": ["M1"] }));
    // What was on its way comes first.
    let own = |it: &Value| status("M1", it).is_some() && status("M2", it).is_none();
    socket.next_where(own).await;
    let (mut own, mut others) = (0, 0);
    while own < 30 {
        let told = socket.next_of("change").await;
        own += usize::from(status("M1", &told).is_some());
        let other = ["M2", "M3"].map(|id| usize::from(status(id, &told).is_some()));
        others += other.iter().sum::<usize>();
    }
    assert_eq!(others, 0, "states of others beside {own} of its own");

    // News of others come all the same.
    site.post("", "/api/monitors/M3/lockout", json!({})).await;
    let locked = |it: &Value| {
        let state = &it["set"]["monitors/M3/summary"]["subsystems"]["General"];
        state["flags"].to_string().contains("LockedOut")
    };
    socket.next_where(locked).await;

    // A client that turns to another one gets its present state at once.
    let id = json!({ "type": "subscribe", "monitors": ["M2"] });
    socket.send(id).await;
    socket.next_where(|it| status("M2", it).is_some()).await;
    let all = socket.ask(json!({ "type": "subscribe" })).await;
    assert_eq!(all["subscribed"], json!({ "monitors": null }));
    for id in ["M1", "M2", "M3"] {
        let (mut last, mut grown) = (0, 0);
        while grown < 3 {
            let told = socket.next_where(|it| status(id, it).is_some()).await;
            let at_ms = status(id, &told).unwrap();
            grown += usize::from(at_ms > last);
            last = at_ms;
        }
    }
}

#[tokio::test]
async fn a_range_of_time_that_cannot_be_is_refused_everywhere() {
    let site = Site::open(1).await;
    let description = site.get("", "/api/openapi.json").await.body;
    let mut tried = 0;
    for (path, what) in description["paths"].as_object().unwrap() {
        let parameters = what["get"]["parameters"].as_array();
        if !parameters.is_some_and(|all| all.iter().any(|it| it["name"] == "from_ms")) {
            continue;
        }
        // What a part of the history has and the list of series does not use.
        if path == "/api/history/series" {
            continue;
        }
        let path = path.replace("{name}", "x.mcap");
        for range in [
            "from_ms=18446744073709551614&to_ms=18446744073709551615",
            "from_ms=9223372036854775807&to_ms=9223372036854775808",
            "from_ms=2&to_ms=1",
            "from_ms=253402300800000",
        ] {
            let reply =
                site.get("", &format!("{path}?monitor=M1&series=General.bits&{range}")).await;
            assert_eq!((reply.status, reply.code()), (400, "bad_request"), "{path} {range}");
            tried += 1;
        }
    }
    assert!(tried >= 7 * 4, "{tried}");
}

/// The client knows soon that it is sent and not confirmed; what came of it is in the log.
#[tokio::test]
async fn an_urgent_request_to_a_silent_monitor_is_answered_at_once_and_goes_on() {
    let site = Site::open(1).await;
    let mut socket = site.ws("").await;
    socket.next_of("state").await;
    site.bus.lock()[0].power_off();
    // Over the WebSocket it is said that it is sent, and later what came of it.
    socket.send(json!({ "type": "stop", "monitor": "M1", "id": 7 })).await;
    let soon = tokio::time::timeout(Duration::from_secs(2), socket.next_of("progress")).await;
    let soon = soon.expect("word that it is sent");
    assert_eq!((&soon["id"], &soon["answered"]), (&json!(7), &json!(false)), "{soon}");
    assert_eq!(socket.next_of("answer").await["error"]["code"], "outcome_unknown");
    for (path, body, what) in [
        ("stop", json!({}), "Stop All"),
        ("stop", json!({ "of": "Vertical" }), "Stop Vertical"),
        ("close", json!({ "valve": "Valve1" }), "Close Valve1"),
        ("lockout", json!({}), "Lockout All on"),
        ("requests", json!({ "request": "Stop Horizontal" }), "Stop Horizontal"),
    ] {
        let began = tokio::time::Instant::now();
        let reply = site.post("", &format!("/api/monitors/M1/{path}"), body).await;
        assert!(began.elapsed() < Duration::from_secs(2), "{what}: {:?}", began.elapsed());
        assert_eq!((reply.status, &reply.body), (202, &json!({ "pending": true })), "{reply:?}");
        loop {
            let log = site.hub.audit().latest(None, 50, None, None).await.unwrap();
            let mut of = log.iter().map(|it| &it.record).filter(|it| it.what == what);
            if of.any(|it| it.outcome != "asked" && it.outcome != "repeated") {
                break;
            }
            assert!(began.elapsed() < Duration::from_secs(20), "{what}: {log:?}");
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }
}

/// A token stops, closes and locks out over a slow line, again and again and each time over new connections: the
/// monitor is polled all the same, and another token's Stop does not wait for a rest.
#[tokio::test]
async fn urgent_requests_of_one_token_leave_the_line_half_of_its_time() {
    let site = Site::with(1, |config| config.monitors[0].poll_ms = 200).await;
    let (flood, other) = (site.token(Role::Operator), site.token(Role::Engineer));
    site.bus.slow(Duration::from_millis(60));
    let end = tokio::time::Instant::now() + Duration::from_secs(6);
    let goes_on = || tokio::time::Instant::now() < end;
    let floods =
        ["stop", "close", "close", "lockout"].into_iter().zip(1..).map(async |(kind, n)| {
            let message =
                json!({ "type": kind, "monitor": "M1", "valve": format!("Valve{}", n - 1) });
            while goes_on() {
                let mut socket = site.ws(&flood).await;
                socket.ask(message.clone()).await;
            }
        });
    let watching = async {
        let (mut looks, mut stops) = (Vec::new(), Vec::new());
        while goes_on() {
            tokio::time::sleep(Duration::from_millis(100)).await;
            looks.push(site.get(&other, "/api/monitors/M1").await.body["status"]["stale"].clone());
            if looks.len() % 10 == 0 {
                let began = tokio::time::Instant::now();
                let reply = site.post(&other, "/api/monitors/M1/stop", json!({})).await;
                assert!(matches!(reply.status, 200 | 422), "{reply:?}");
                stops.push(began.elapsed());
            }
        }
        (looks, stops)
    };
    let (_, (looks, stops)) = tokio::join!(join_all(floods), watching);
    let stale = looks.iter().filter(|it| **it != json!(false)).count();
    // Seven of eight are where the line has no rest; a busy machine makes a few late.
    assert!(looks.len() > 20 && stale * 4 < looks.len(), "{stale} of {} are stale", looks.len());
    assert!(stops.iter().all(|it| *it < Duration::from_millis(500)), "{stops:?}");
}

/// One monitor is silent, and all are stopped again and again: another one is locked out all the same.
#[tokio::test]
async fn an_urgent_request_does_not_wait_for_those_before_it() {
    let site = Site::open(2).await;
    let mut socket = site.ws("").await;
    socket.next_of("state").await;
    site.bus.silence(1);
    for id in 0..20 {
        socket.send(json!({ "type": "stop", "id": id })).await;
    }
    socket.send(json!({ "type": "lockout", "id": "out", "monitor": "M2" })).await;
    let began = tokio::time::Instant::now();
    let (locked_out, given_up) = loop {
        let log = site.hub.audit().latest(None, 500, None, None).await.unwrap();
        let first = |monitor: &str, what: &str, asked: bool| {
            let of = log
                .iter()
                .rev()
                .filter(|it| it.record.monitor == monitor && it.record.what == what);
            let outcome =
                |it: &str| if asked { it == "asked" } else { !["asked", "repeated"].contains(&it) };
            of.filter(|it| outcome(&it.record.outcome)).map(|it| it.n).next()
        };
        let both = (first("M2", "Lockout All on", true), first("*", "Stop All", false));
        if let (Some(locked_out), Some(given_up)) = both {
            break (locked_out, given_up);
        }
        assert!(began.elapsed() < support::PATIENCE, "{log:?}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    };
    assert!(locked_out < given_up, "it has waited for the monitor that is silent");
}

#[tokio::test]
async fn a_stop_is_understood_as_far_as_it_can_be_and_the_end_is_told() {
    let site = Site::with(1, |_| {}).await;
    let mut seat = site.ws(&site.token(Role::Observer)).await;
    for none in ["1e400", r#""\ud800""#] {
        let stop = format!(r#"{{"type":"stop","monitor":"M1","id":{none}}}"#);
        seat.socket.send(Message::text(stop)).await.unwrap();
        let answer = seat.next_of("answer").await;
        assert_eq!(
            (&answer["id"], &answer["result"]["ok"]),
            (&Value::Null, &json!(true)),
            "{answer}"
        );
    }
    for (id, message) in [
        json!({"type": "stop", "id": 1, "monitor": "M1", "of": 5}),
        json!({"type": "close", "id": 2, "monitor": "M1", "valve": {}}),
        json!({"type": "lockout", "id": 3, "monitor": ["M1"]}),
        json!({"type": "jog", "id": 4, "monitor": 7}),
    ]
    .into_iter()
    .enumerate()
    {
        seat.send(message).await;
        let answer = seat.next_of("answer").await;
        assert_eq!(answer["id"], id + 1, "{answer}");
        assert_eq!(answer["error"].is_object(), id == 3, "{answer}");
    }
    seat.send(json!({ "type": "watch", "frames": ["x".repeat(20_000)] })).await;
    let code = loop {
        match seat.socket.next().await {
            Some(Ok(Message::Close(frame))) => break frame.map(|it| u16::from(it.code)),
            Some(Ok(_)) => {}
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(code, Some(1009));
}
