//! What must not move does not, and what moves is stopped: seen at the monitor's own outputs.

mod support;

use std::time::Duration;

use lafet_hub::access::Role;
use serde_json::json;
use support::{Site, hold, stays, until};

const VERTICAL: usize = 0;
const HORIZONTAL: usize = 1;
const SECOND: Duration = Duration::from_secs(1);
/// Watchdog, a poll of the answer and a step of the simulation.
const STOPS_WITHIN: Duration = Duration::from_millis(700);

#[tokio::test]
async fn the_first_beat_moves_nothing_the_second_does_and_silence_stops() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    operator.beat("Vertical", "max").await;
    assert_eq!(operator.next_of("jog").await["state"], "armed");
    let still = || site.bus.commanded(0, VERTICAL) == 0;
    assert!(stays(SECOND, still).await, "one beat is none");
    hold(&mut operator, "Vertical", "max", SECOND).await;
    assert!(site.bus.commanded(0, VERTICAL) > 0);
    let silent = tokio::time::Instant::now();
    until("it stops without beats", still).await;
    assert!(silent.elapsed() < STOPS_WITHIN, "{:?}", silent.elapsed());
    let ended = operator.next_where(|it| it["type"] == "jog" && it["state"] == "ended").await;
    assert_eq!(ended["end"], "stopped");
    assert!(stays(SECOND, still).await);
    assert!(site.bus.position(0, VERTICAL) > 30.0);
}

#[tokio::test]
async fn letting_go_and_a_lost_connection_stop_at_once() {
    let site = Site::open(1).await;
    let still = || site.bus.commanded(0, HORIZONTAL) == 0;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    hold(&mut operator, "Horizontal", "min", SECOND / 2).await;
    assert!(site.bus.commanded(0, HORIZONTAL) < 0);
    operator.send(json!({ "type": "jog_end", "monitor": "M1", "drive": "Horizontal" })).await;
    let began = tokio::time::Instant::now();
    until("released", still).await;
    assert!(began.elapsed() < Duration::from_millis(250), "{:?}", began.elapsed());
    operator.next_where(|it| it["type"] == "jog" && it["state"] == "ended").await;
    hold(&mut operator, "Horizontal", "max", SECOND / 2).await;
    assert!(site.bus.commanded(0, HORIZONTAL) > 0);
    drop(operator);
    until("connection lost", still).await;
    assert!(stays(SECOND, still).await);
}

#[tokio::test]
async fn stop_of_an_observer_ends_what_somebody_else_holds() {
    let site = Site::with(1, |_| {}).await;
    let (operator, observer) = (site.token(Role::Operator), site.token(Role::Observer));
    let mut operator = site.ws(&operator).await;
    operator.authority("M1", "take").await;
    hold(&mut operator, "Vertical", "max", SECOND / 2).await;
    assert!(site.bus.commanded(0, VERTICAL) > 0);
    let began = tokio::time::Instant::now();
    let reply = site.post(&observer, "/api/monitors/M1/stop", json!({})).await;
    assert_eq!(reply.status, 200, "{reply:?}");
    until("it stands", || site.bus.commanded(0, VERTICAL) == 0).await;
    assert!(began.elapsed() < STOPS_WITHIN, "{:?}", began.elapsed());
    // Who still holds the key has to let go first.
    hold(&mut operator, "Vertical", "max", SECOND / 2).await;
    assert_eq!(site.bus.commanded(0, VERTICAL), 0);
    operator.send(json!({ "type": "jog_end", "monitor": "M1", "drive": "Vertical" })).await;
    hold(&mut operator, "Vertical", "max", SECOND / 2).await;
    assert!(site.bus.commanded(0, VERTICAL) > 0);
}

#[tokio::test]
async fn without_authority_nothing_moves() {
    let site = Site::open(1).await;
    let (mut holder, mut other) = (site.ws("").await, site.ws("").await);
    let state = holder.authority("M1", "take").await;
    assert_eq!(state["authority"]["holder"]["seat"], holder.seat());
    assert_eq!(other.authority("M1", "take").await["error"]["code"], "held");
    let asked = json!({ "type": "request", "monitor": "M1", "request": "Move Vertical 900" });
    assert_eq!(other.ask(asked.clone()).await["error"]["code"], "no_authority");
    hold(&mut other, "Vertical", "max", SECOND / 2).await;
    assert_eq!(other.next_of("jog").await["end"], "refused");
    assert_eq!(site.bus.commanded(0, VERTICAL), 0);
    assert_eq!(holder.ask(asked).await["result"]["ok"], true);
    until("the holder's does", || site.bus.commanded(0, VERTICAL) > 0).await;
}

#[tokio::test]
async fn a_holder_who_is_lost_is_released_and_its_motion_stopped() {
    let site = Site::open(1).await;
    let (mut holder, mut other) = (site.ws("").await, site.ws("").await);
    holder.authority("M1", "take").await;
    let asked = json!({ "type": "request", "monitor": "M1", "request": "Move Horizontal 10000" });
    holder.ask(asked).await;
    until("it moves", || site.bus.commanded(0, HORIZONTAL) > 0).await;
    drop(holder);
    let free = other.next_where(|it| it["set"]["monitors/M1/authority"]["state"] == "free").await;
    assert!(free["now_ms"].is_u64());
    until("it stands", || site.bus.commanded(0, HORIZONTAL) == 0).await;
    assert!(site.bus.position(0, HORIZONTAL) < 9_000.0);
    assert!(other.authority("M1", "take").await["error"].is_null());
}

#[tokio::test]
async fn a_holder_may_come_back_in_time() {
    let site = Site::with(1, |config| {
        config.login = false;
        config.lost_ms = 5_000;
    })
    .await;
    let mut holder = site.ws("").await;
    holder.authority("M1", "take").await;
    let (seat, resume) =
        (holder.seat().to_owned(), holder.hello["resume"].as_str().unwrap().to_owned());
    drop(holder);
    let mut other = site.ws("").await;
    assert_eq!(other.authority("M1", "take").await["error"]["code"], "held");
    let mut again = site.ws_at("", &format!("/api/ws?resume={resume}")).await;
    assert_eq!(again.seat(), seat);
    let asked = json!({ "type": "request", "monitor": "M1", "request": "Move Vertical 900" });
    assert_eq!(again.ask(asked).await["result"]["ok"], true);
}

#[tokio::test]
async fn a_take_over_by_force_stops_what_the_other_holds_and_tells_why() {
    let site = Site::with(1, |_| {}).await;
    let (operator, engineer) = (site.token(Role::Operator), site.token(Role::Engineer));
    let (mut first, mut second) = (site.ws(&operator).await, site.ws(&engineer).await);
    first.authority("M1", "take").await;
    hold(&mut first, "Vertical", "max", SECOND / 2).await;
    assert!(site.bus.commanded(0, VERTICAL) > 0);
    second.authority("M1", "force").await;
    let lost = first.next_of("authority_lost").await;
    assert_eq!((&lost["how"], &lost["reason"]), (&json!("forced"), &json!("for the test")));
    until("it stands", || site.bus.commanded(0, VERTICAL) == 0).await;
    assert_eq!(first.authority("M1", "force").await["error"]["code"], "role");
}

#[tokio::test]
async fn jog_over_http_is_the_same() {
    let site = Site::open(1).await;
    let beat = json!({ "drive": "Vertical", "toward": "max" });
    let refused = site.post("", "/api/monitors/M1/jog", beat.clone()).await;
    assert_eq!((refused.status, refused.code()), (409, "no_authority"));
    site.post("", "/api/monitors/M1/authority", json!({ "action": "take" })).await;
    let mut states = Vec::new();
    for _ in 0..5 {
        let reply = site.post("", "/api/monitors/M1/jog", beat.clone()).await;
        states.push(reply.body["state"].as_str().unwrap_or_default().to_owned());
    }
    assert_eq!(states, ["armed", "moving", "moving", "moving", "moving"]);
    until("it moves", || site.bus.commanded(0, VERTICAL) > 0).await;
    until("and stops without beats", || site.bus.commanded(0, VERTICAL) == 0).await;
}

#[tokio::test]
async fn stop_reaches_every_monitor_and_lockout_closes() {
    let site = Site::open(2).await;
    let mut operator = site.ws("").await;
    for monitor in ["M1", "M2"] {
        operator.authority(monitor, "take").await;
        for request in ["Move Horizontal 9000", "Open Valve1"] {
            let asked = json!({ "type": "request", "monitor": monitor, "request": request });
            assert_eq!(operator.ask(asked).await["result"]["ok"], true);
        }
    }
    let moving = |monitor| site.bus.commanded(monitor, HORIZONTAL) != 0;
    until("both move", || moving(0) && moving(1)).await;
    let stopped = operator.ask(json!({ "type": "stop" })).await;
    assert_eq!(stopped["results"]["M2"]["ok"], true, "{stopped}");
    // A drive ramps its speed down.
    until("both stand", || !moving(0) && !moving(1)).await;
    operator.ask(json!({ "type": "lockout" })).await;
    let open = |monitor: usize| site.bus.lock()[monitor].world().valves[0].opening;
    until("both close", || open(0) < 0.01 && open(1) < 0.01).await;
    let asked = json!({ "type": "request", "monitor": "M1", "request": "Move Horizontal 0" });
    let refused = operator.ask(asked).await["error"].take();
    assert_eq!(refused["code"], "refused");
    // Why it is refused here, not what the status means anywhere.
    let why = "The monitor is locked out: only reads and SetParam are done.";
    assert_eq!(refused["answers"][0]["meaning"]["en"], why, "{refused}");
    assert!(refused["en"].as_str().is_some_and(|text| text.contains(why)), "{refused}");
    let release = json!({ "type": "request", "monitor": "M1", "request": "Lockout All off" });
    assert_eq!(operator.ask(release.clone()).await["error"]["code"], "confirm_needed");
    let mut release = release;
    release["confirm"] = json!("M1");
    assert_eq!(operator.ask(release).await["result"]["ok"], true);
}
