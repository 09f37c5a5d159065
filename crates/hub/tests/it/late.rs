//! What was on its way when a person has said Stop, or when another connection has taken the seat.

use std::time::Duration;

use serde_json::json;

use crate::support::{PATIENCE, Site, stays, until};

const VERTICAL: usize = 0;

#[tokio::test]
async fn a_connection_whose_seat_was_resumed_commands_nothing_any_more() {
    let site = Site::open(1).await;
    let mut old = site.ws("").await;
    old.authority("M1", "take").await;
    let resume = old.hello["resume"].as_str().unwrap().to_owned();
    let mut new = site.ws_at("", &format!("/api/ws?resume={resume}")).await;
    assert_eq!(new.seat(), old.seat());
    // These were stuck in the network, and arrive now.
    let up = json!({ "type": "request", "id": 1, "monitor": "M1", "request": "Move Vertical 900" });
    old.send(up.clone()).await;
    for _ in 0..10 {
        old.beat("Vertical", "max").await;
        tokio::time::sleep(Duration::from_millis(60)).await;
    }
    let rests = || site.bus.commanded(0, VERTICAL) == 0;
    assert!(stays(Duration::from_millis(300), rests).await, "the old connection moves it");
    // A Stop that was stuck with them is one all the same.
    assert_eq!(new.ask(up).await["result"]["ok"], true);
    until("it moves", || !rests()).await;
    old.send(json!({ "type": "stop", "monitor": "M1" })).await;
    until("it stops", rests).await;
    assert!(site.bus.position(0, VERTICAL) < 900.0);
    let closed = old.next_of("closed").await;
    assert_eq!(closed["code"], 4410);
}

#[tokio::test]
async fn a_request_that_was_on_its_way_for_too_long_is_refused() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    let ask = |request: &str, t: f64| json!({ "type": "request", "monitor": "M1", "request": request, "t": t });
    assert_eq!(operator.ask(ask("Move Vertical 300", 100_000.0)).await["result"]["ok"], true);
    until("it is there", || site.bus.position(0, VERTICAL) > 299.0).await;
    // Sent two seconds before the first one, by the client's clock.
    let late = operator.ask(ask("Move Vertical 900", 98_000.0)).await;
    assert_eq!(late["error"]["code"], "late", "{late}");
    assert!(late["error"]["ru"].as_str().unwrap().contains("отправьте её снова"), "{late}");
    let stop = operator.ask(ask("Stop All", 98_000.0)).await;
    assert_eq!(stop["result"]["ok"], true, "what is urgent is never late: {stop}");
    assert!(site.bus.position(0, VERTICAL) < 301.0);
    assert_eq!(operator.ask(ask("Move Vertical 600", 200_000.0)).await["result"]["ok"], true);
}

/// A network that holds one client's request back while another client stops the monitor.
#[tokio::test]
async fn what_was_sent_before_a_stop_is_void_after_it() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    let began = tokio::time::Instant::now();
    let now = || began.elapsed().as_secs_f64() * 1000.0;
    let up = |t: f64| json!({ "type": "request", "monitor": "M1", "request": "Move Vertical 900", "t": t });
    let read =
        |t: f64| json!({ "type": "request", "monitor": "M1", "request": "GetStatus All", "t": t });
    assert_eq!(operator.ask(read(now())).await["result"]["ok"], true);
    let sent = now();
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(site.post("", "/api/monitors/M1/stop", json!({})).await.status, 200);
    let answer = operator.ask(up(sent)).await;
    let code = answer["error"]["code"].as_str().unwrap_or_default();
    // A pause of the machine makes it late besides.
    assert!(["void", "late"].contains(&code), "{answer}");
    assert_eq!(site.bus.commanded(0, VERTICAL), 0);
    // Asked for after the Stop; a pause of the machine may make one late.
    let started = tokio::time::Instant::now();
    while operator.ask(up(now())).await["result"]["ok"] != true {
        assert!(started.elapsed() < PATIENCE);
    }
    operator.authority("M1", "release").await;

    // The same over HTTP.
    let ask = |t: f64| json!({ "request": "Move Vertical 100", "t": t });
    let place = "/api/monitors/M1/requests";
    assert_eq!(
        site.post("", "/api/monitors/M1/authority", json!({ "action": "take" })).await.status,
        200
    );
    let done = async || site.post("", place, ask(now())).await.status == 200;
    assert!(done().await);
    let reply = site.post("", place, ask(now() - 2000.0)).await;
    assert_eq!((reply.status, reply.code()), (409, "late"), "{reply:?}");
    let sent = now();
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(site.post("", "/api/stop", json!({})).await.status, 200);
    let reply = site.post("", place, ask(sent)).await;
    assert!(["void", "late"].contains(&reply.code()), "{reply:?}");
    let started = tokio::time::Instant::now();
    while !done().await {
        assert!(started.elapsed() < PATIENCE);
    }
}

#[tokio::test]
async fn beats_that_come_late_say_why_nothing_moves() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    let beat = |t: f64| json!({ "type": "jog", "monitor": "M1", "drive": "Vertical", "toward": "max", "t": t });
    operator.send(beat(100_000.0)).await;
    operator.next_where(|it| it["type"] == "jog" && it["state"] == "armed").await;
    operator.send(json!({ "type": "jog_end", "monitor": "M1", "drive": "Vertical" })).await;
    operator.send(beat(99_000.0)).await;
    let ended = operator.next_where(|it| it["type"] == "jog" && it["state"] == "ended").await;
    assert_eq!(ended["end"], "refused", "{ended}");
    assert!(ended["text"]["en"].as_str().unwrap().contains("arrive late"), "{ended}");
}

/// Another client stops the monitor between the first beat, which arms a motion, and the second.
#[tokio::test]
async fn a_motion_that_is_armed_does_not_begin_after_a_stop_of_another() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    let end = json!({ "type": "jog_end", "monitor": "M1", "drive": "Vertical" });
    let began = tokio::time::Instant::now();
    loop {
        operator.beat("Vertical", "max").await;
        operator.next_where(|it| it["type"] == "jog" && it["state"] == "armed").await;
        let armed = tokio::time::Instant::now();
        assert_eq!(site.post("", "/api/monitors/M1/stop", json!({})).await.status, 200);
        operator.beat("Vertical", "max").await;
        // After a pause of the machine it would be the first beat of another motion.
        if armed.elapsed() < Duration::from_millis(200) {
            break;
        }
        assert!(began.elapsed() < PATIENCE);
        operator.send(end.clone()).await;
        tokio::time::sleep(Duration::from_millis(400)).await;
    }
    let said = operator.next_where(|it| it["type"] == "jog" && it["state"] != "armed").await;
    assert_eq!(said["state"], "ended", "{said}");
    assert_eq!(site.bus.commanded(0, VERTICAL), 0);
    // Released, it is asked for once more.
    operator.send(end).await;
    while site.bus.commanded(0, VERTICAL) == 0 {
        assert!(began.elapsed() < PATIENCE);
        operator.beat("Vertical", "max").await;
        tokio::time::sleep(Duration::from_millis(60)).await;
    }
}

/// A page from before a rename.
#[tokio::test]
async fn an_urgent_request_to_a_name_that_is_gone_says_that_nothing_was_stopped() {
    let site = Site::open(1).await;
    for path in ["stop", "close", "lockout"] {
        let reply = site.post("", &format!("/api/monitors/OLD/{path}"), json!({})).await;
        assert_eq!((reply.status, reply.code()), (404, "no_monitor"), "{path}");
        let text = |lang: &str| reply.body["error"][lang].as_str().unwrap().to_owned();
        assert!(text("en").contains("nothing was stopped"), "{path}: {}", text("en"));
        assert!(text("ru").contains("ничего не остановлено"), "{path}: {}", text("ru"));
        assert!(text("en").contains("/api/stop") && text("ru").contains("/api/stop"));
    }
    let mut operator = site.ws("").await;
    for message in [
        json!({ "type": "stop", "monitor": "OLD" }),
        json!({ "type": "request", "monitor": "OLD", "request": "Stop All" }),
    ] {
        let answer = operator.ask(message).await;
        assert_eq!(answer["error"]["code"], "no_monitor");
        assert!(answer["error"]["en"].as_str().unwrap().contains("/api/stop"), "{answer}");
    }
    let read = operator
        .ask(json!({ "type": "request", "monitor": "OLD", "request": "GetStatus All" }))
        .await;
    assert!(!read["error"]["en"].as_str().unwrap().contains("/api/stop"), "{read}");
}

/// The first command of a connection has nothing to be compared with, nor have those that a stall delivers together.
#[tokio::test]
async fn the_first_command_of_a_connection_is_late_by_the_hubs_clock() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    let up_ms = operator.hello["up_ms"].as_f64().unwrap();
    let sent = tokio::time::Instant::now();
    let up = |ago_ms: f64| up_ms + sent.elapsed().as_secs_f64() * 1000.0 - ago_ms;
    let open = |up_ms: f64, t: f64| json!({ "type": "request", "monitor": "M1", "request": "Move Vertical 900", "up_ms": up_ms, "t": t });
    let late = operator.ask(open(up(5000.0), 0.0)).await;
    assert_eq!(late["error"]["code"], "late", "{late}");
    let together = operator.ask(open(up(4000.0), 1000.0)).await;
    assert_eq!(together["error"]["code"], "late", "it is the quickest so far: {together}");
    let ahead = operator.ask(open(up(-60_000.0), 2000.0)).await;
    assert_eq!(ahead["error"]["code"], "bad_request", "{ahead}");
    for lang in ["en", "ru"] {
        assert!(ahead["error"][lang].as_str().unwrap().contains("up_ms"), "{ahead}");
    }
    tokio::time::sleep(Duration::from_millis(1000)).await;
    assert_eq!(site.post("", "/api/monitors/M1/stop", json!({})).await.status, 200);
    let void = operator.ask(open(up(800.0), 60_000.0)).await;
    assert_eq!(void["error"]["code"], "void", "a Stop came meanwhile: {void}");
    assert!(stays(Duration::from_millis(200), || site.bus.commanded(0, VERTICAL) == 0).await);
    // What is urgent is never refused for its time.
    let mut stop = open(up(-60_000.0), 60_500.0);
    stop["request"] = json!("Stop All");
    let stopped = operator.ask(stop).await;
    assert_eq!(stopped["result"]["ok"], true, "{stopped}");
    tokio::time::sleep(Duration::from_millis(300)).await;
    let sent_now = operator.ask(open(up(0.0), 61_000.0)).await;
    assert_eq!(sent_now["result"]["ok"], true, "{sent_now}");
}

#[tokio::test]
async fn over_http_the_first_command_is_late_by_the_hubs_clock() {
    let site = Site::open(1).await;
    let about = site.get("", "/api/hub").await.body;
    let up_ms = about["up_ms"].as_f64().unwrap();
    let take = json!({ "action": "take" });
    assert_eq!(site.post("", "/api/monitors/M1/authority", take).await.status, 200);
    let asked = tokio::time::Instant::now();
    let up = |ago_ms: f64| up_ms + asked.elapsed().as_secs_f64() * 1000.0 - ago_ms;
    let post = async |path: &str, mut body: serde_json::Value, up_ms: f64| {
        body["up_ms"] = json!(up_ms);
        site.post("", &format!("/api/monitors/M1/{path}"), body).await
    };
    let request = json!({ "request": "Move Vertical 900", "t": 1.0 });
    let reply = post("requests", request.clone(), up(5000.0)).await;
    assert_eq!((reply.status, reply.code()), (409, "late"), "{reply:?}");
    let beat = json!({ "drive": "Vertical", "toward": "max", "t": 1.0 });
    for _ in 0..4 {
        let reply = post("jog", beat.clone(), up(5000.0)).await;
        assert_eq!((reply.status, reply.code()), (409, "late"), "{reply:?}");
    }
    assert!(stays(Duration::from_millis(200), || site.bus.commanded(0, VERTICAL) == 0).await);
    assert_eq!(post("requests", request, up(0.0)).await.status, 200);
}

/// A burst of heartbeats that a stall has kept, the first ones of their connection.
#[tokio::test]
async fn the_first_heartbeats_of_a_connection_are_late_by_the_hubs_clock() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    let up_ms = operator.hello["up_ms"].as_f64().unwrap();
    let began = tokio::time::Instant::now();
    let up = |ago_ms: f64| up_ms + began.elapsed().as_secs_f64() * 1000.0 - ago_ms;
    let beat = |ago_ms: f64| json!({ "type": "jog", "monitor": "M1", "drive": "Vertical", "toward": "max", "t": 10_000.0 - ago_ms, "up_ms": up(ago_ms) });
    let rests = || site.bus.commanded(0, VERTICAL) == 0;
    for beats in 0..20 {
        operator.send(beat(5000.0 - f64::from(beats) * 60.0)).await;
    }
    assert!(stays(Duration::from_millis(300), rests).await, "the burst moves it");
    operator.send(json!({ "type": "jog_end", "monitor": "M1", "drive": "Vertical" })).await;
    // Tuning moves as well.
    let tune = json!({ "type": "tune", "monitor": "M1", "drive": "Vertical", "up_ms": up(5000.0) });
    assert_eq!(operator.ask(tune).await["error"]["code"], "late");
    for _ in 0..5 {
        operator.send(beat(0.0)).await;
        tokio::time::sleep(Duration::from_millis(60)).await;
    }
    until("it moves", || !rests()).await;
}
