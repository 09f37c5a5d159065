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
/// So often is measured how quickly a drive stops. The quickest counts: a pause of the machine is in
/// one of them, not in all.
const MEASURED: usize = 3;

#[tokio::test]
async fn the_first_beat_moves_nothing_the_second_does_and_silence_stops() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    operator.beat("Vertical", "max").await;
    assert_eq!(operator.next_of("jog").await["state"], "armed");
    let still = || site.bus.commanded(0, VERTICAL) == 0;
    assert!(stays(SECOND, still).await, "one beat is none");
    let mut quickest = Duration::MAX;
    for _ in 0..MEASURED {
        hold(&mut operator, "Vertical", "max", SECOND).await;
        assert!(site.bus.commanded(0, VERTICAL) > 0);
        let silent = tokio::time::Instant::now();
        until("it stops without beats", still).await;
        quickest = quickest.min(silent.elapsed());
        let ended = operator.next_where(|it| it["type"] == "jog" && it["state"] == "ended").await;
        assert_eq!(ended["end"], "stopped");
        assert!(stays(SECOND, still).await);
    }
    assert!(quickest < STOPS_WITHIN, "{quickest:?}");
    assert!(site.bus.position(0, VERTICAL) > 30.0);
}

#[tokio::test]
async fn letting_go_and_a_lost_connection_stop_at_once() {
    let site = Site::open(1).await;
    let still = || site.bus.commanded(0, HORIZONTAL) == 0;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    let mut quickest = Duration::MAX;
    for _ in 0..MEASURED {
        hold(&mut operator, "Horizontal", "min", SECOND / 2).await;
        assert!(site.bus.commanded(0, HORIZONTAL) < 0);
        operator.send(json!({ "type": "jog_end", "monitor": "M1", "drive": "Horizontal" })).await;
        let began = tokio::time::Instant::now();
        until("released", still).await;
        quickest = quickest.min(began.elapsed());
        operator.next_where(|it| it["type"] == "jog" && it["state"] == "ended").await;
    }
    assert!(quickest < Duration::from_millis(250), "{quickest:?}");
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
    let mut quickest = Duration::MAX;
    for _ in 0..MEASURED {
        hold(&mut operator, "Vertical", "max", SECOND / 2).await;
        assert!(site.bus.commanded(0, VERTICAL) > 0);
        let began = tokio::time::Instant::now();
        let reply = site.post(&observer, "/api/monitors/M1/stop", json!({})).await;
        assert_eq!(reply.status, 200, "{reply:?}");
        until("it is at rest", || site.bus.commanded(0, VERTICAL) == 0).await;
        quickest = quickest.min(began.elapsed());
        // A user who still holds the key has to release it first.
        hold(&mut operator, "Vertical", "max", SECOND / 2).await;
        assert_eq!(site.bus.commanded(0, VERTICAL), 0);
        operator.send(json!({ "type": "jog_end", "monitor": "M1", "drive": "Vertical" })).await;
    }
    assert!(quickest < STOPS_WITHIN, "{quickest:?}");
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
    until("it is at rest", || site.bus.commanded(0, HORIZONTAL) == 0).await;
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
    until("it is at rest", || site.bus.commanded(0, VERTICAL) == 0).await;
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

/// §3.1/3 The motion ends by itself, and the program goes on from there.
#[tokio::test]
async fn a_hand_corrects_a_running_program_which_then_goes_on() {
    let site = Site::open(1).await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    let quench = "StartQuench Control centre=0,0 nozzle=60 sector=600,300 step=2 distance=25";
    let begun =
        operator.ask(json!({ "type": "request", "monitor": "M1", "request": quench })).await;
    assert_eq!(begun["result"]["ok"], true, "{begun}");
    let is_set = |flag| {
        let status = site.hub.station("M1").unwrap().status();
        status.is_set(lafet_proto::SubsystemId::CONTROL, flag)
    };
    until("the program runs", || is_set("Quench") && !is_set("Paused")).await;
    hold(&mut operator, "Vertical", "max", SECOND).await;
    until("the hand pauses it", || is_set("Paused")).await;
    let ended = operator.next_where(|it| it["type"] == "jog" && it["state"] == "ended").await;
    assert_eq!(ended["end"], "stopped", "the motion ends with its beats, in a program too");
    let still = tokio::time::Instant::now();
    assert!(is_set("Paused") && site.bus.commanded(0, VERTICAL) == 0);
    until("the program goes on", || is_set("Quench") && !is_set("Paused")).await;
    let waited = still.elapsed();
    assert!(waited > 2 * SECOND && waited < 4 * SECOND, "{waited:?} after the motion");
    until("it moves the drives again", || site.bus.commanded(0, HORIZONTAL) != 0).await;
}

/// 31 addresses of a line of 32 that do not answer take nothing from the one that does.
#[tokio::test]
async fn silent_neighbours_cost_the_living_nothing() {
    let site = Site::with(32, |config| {
        config.login = false;
        config.monitors.iter_mut().for_each(|monitor| monitor.poll_ms = 200);
    })
    .await;
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    let polls = || site.hub.station("M1").unwrap().exchanged().own.believed;
    let mut moved_arcmin = 0.0;
    for silent in [false, true] {
        if silent {
            site.bus.lock().iter_mut().skip(1).for_each(lafet_sim::sim::Sim::power_off);
            let stale = |number| site.hub.station(&format!("M{number}")).unwrap().health() != "up";
            until("31 are silent", || (2..=32).all(stale)).await;
            until("the other one has its turn", || !stale(1)).await;
        }
        let (before, alive) = (polls(), || site.hub.station("M1").unwrap().health() == "up");
        assert!(stays(3 * SECOND, alive).await, "it never appears silent");
        let count = polls() - before;
        assert!(count >= 13, "{count} of 15 polls in 3 s, 31 silent: {silent}");
        let toward = if silent { "min" } else { "max" };
        let from = site.bus.position(0, HORIZONTAL);
        hold(&mut operator, "Horizontal", toward, 5 * SECOND / 2).await;
        until("it is at rest", || site.bus.commanded(0, HORIZONTAL) == 0).await;
        operator.next_where(|it| it["type"] == "jog" && it["state"] == "ended").await;
        let way = (site.bus.position(0, HORIZONTAL) - from).abs();
        assert!(way >= 0.9 * moved_arcmin, "{way}\u{2032} by hand, {moved_arcmin}\u{2032} before");
        moved_arcmin = way;
    }
    let alarms = site.get("", "/api/alarms").await.body.to_string();
    assert!(alarms.contains("M2/Link/Stale") && !alarms.contains("M1/Link"), "{alarms}");
}
