//! Keep-outs, end to end: no client gets water to where it must not go.

use std::time::Duration;

use crate::support::{Reply, Site, hold, hold_until, stand_for_people, stays, until};
use lafet_client::{Client, Endpoint};
use lafet_device::composition::Composition;
use lafet_hub::Clock;
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, SubsystemId};
use serde_json::json;

/// Azimuths −30° … −60° are kept clear; a motion by hand ends 1.5° before that.
const BORDER: i64 = -1710;

/// A monitor that looks north, and a stand for people in the north-east. The monitor is held by `""`.
async fn stand() -> Site {
    let map = stand_for_people();
    let site = Site::of((1, Composition::REMOTE), Clock::System, |config| {
        (config.login, config.site) = (false, Some(map));
    })
    .await;
    let taken = site.post("", "/api/monitors/M1/authority", json!({ "action": "take" })).await;
    assert_eq!(taken.status, 200);
    site
}

async fn asks(site: &Site, request: &str) -> Reply {
    site.post("", "/api/monitors/M1/requests", json!({ "request": request })).await
}

async fn accepted(site: &Site, request: &str) {
    let reply = asks(site, request).await;
    assert_eq!((reply.status, &reply.body["ok"]), (200, &json!(true)), "{request}: {reply:?}");
}

async fn kept_out(site: &Site, request: &str) {
    let reply = asks(site, request).await;
    assert_eq!((reply.status, reply.code()), (409, "keep_out"), "{request}: {reply:?}");
}

fn position(site: &Site) -> i64 {
    let status = site.hub.station("M1").unwrap().status();
    status.valid(SubsystemId::HORIZONTAL, "position").unwrap()
}

fn is_set(site: &Site, id: SubsystemId, flag: &str) -> bool {
    site.hub.station("M1").unwrap().status().is_set(id, flag)
}

async fn rests_at(site: &Site, at: i64) {
    until("it is at rest there", || {
        (position(site) - at).abs() <= 3 && !is_set(site, SubsystemId::HORIZONTAL, "Move")
    })
    .await;
    // What was sent counts for a second, whatever the state says.
    tokio::time::sleep(Duration::from_millis(1100)).await;
}

async fn opened(site: &Site) {
    accepted(site, "Open Valve1").await;
    until("the valve opens", || is_set(site, SubsystemId::VALVE1, "Open")).await;
}

#[tokio::test]
async fn a_dry_barrel_passes_and_water_does_not() {
    let site = stand().await;
    accepted(&site, "Move Horizontal -2700").await;
    kept_out(&site, "Open Valve1").await;
    rests_at(&site, -2700).await;
    kept_out(&site, "Open Valve1").await;
    assert!(is_set(&site, SubsystemId::VALVE1, "Closed"));
    accepted(&site, "Move Horizontal 0").await;
    rests_at(&site, 0).await;
    opened(&site).await;
    kept_out(&site, "Move Horizontal -2700").await;
    kept_out(&site, "Move Horizontal -4800").await;
    accepted(&site, "Move Horizontal 600").await;
    accepted(&site, "Move Vertical 300").await;
    accepted(&site, "Move Nozzle 20").await;
    let log = site.hub.audit().latest(None, 50, None, None).await.unwrap();
    let noted = log.iter().filter(|it| it.record.outcome == "keep_out").count();
    assert_eq!(noted, 4);
}

#[tokio::test]
async fn a_motion_by_hand_ends_before_it() {
    let site = stand().await;
    opened(&site).await;
    let released =
        site.post("", "/api/monitors/M1/authority", json!({ "action": "release" })).await;
    assert_eq!(released.status, 200);
    let mut operator = site.ws("").await;
    operator.authority("M1", "take").await;
    hold(&mut operator, "Horizontal", "min", Duration::from_secs(4)).await;
    let ended = operator.next_where(|it| it["type"] == "jog" && it["state"] == "ended").await;
    assert_eq!(ended["end"], "standing", "{ended}");
    rests_at(&site, BORDER).await;
    assert!(site.bus.position(0, 1) >= (BORDER - 5) as f64);
    // From there it only goes back.
    hold(&mut operator, "Horizontal", "min", Duration::from_millis(400)).await;
    let refused = operator.next_where(|it| it["type"] == "jog" && it["end"] == "refused").await;
    assert!(refused["text"]["en"].as_str().is_some_and(|it| it.contains("stand")), "{refused}");
    hold_until(&mut operator, "Horizontal", "max", || position(&site) > BORDER + 100).await;
}

#[tokio::test]
async fn a_program_into_it_is_not_begun() {
    let site = stand().await;
    kept_out(
        &site,
        "StartQuench Control centre=-2700,0 nozzle=60 sector=600,300 step=1 distance=30",
    )
    .await;
    kept_out(
        &site,
        "StartQuench Control centre=-1200,0 nozzle=60 sector=1800,300 step=1 distance=30",
    )
    .await;
    accepted(
        &site,
        "StartQuench Control centre=1200,0 nozzle=60 sector=600,300 step=1 distance=30",
    )
    .await;
    until("it runs", || is_set(&site, SubsystemId::CONTROL, "Quench")).await;
    opened(&site).await;
    kept_out(&site, "Move Horizontal -2700").await;
}

/// Requests of two clients at the same time do not add up to water there.
#[tokio::test]
async fn two_requests_at_once_do_not_get_past_it() {
    let site = stand().await;
    for _ in 0..10 {
        let (turn, open) =
            tokio::join!(asks(&site, "Move Horizontal -2700"), asks(&site, "Open Valve1"));
        let statuses = [turn.status, open.status];
        assert!(statuses.contains(&409) && statuses.contains(&200), "{statuses:?}");
        accepted(&site, "Close Valve1").await;
        accepted(&site, "Move Horizontal 0").await;
        until("it is shut", || is_set(&site, SubsystemId::VALVE1, "Closed")).await;
        rests_at(&site, 0).await;
    }
}

/// The second of two requests is not looked at before the client has the first one: the line takes them in the
/// order in which they were let pass. The client is withheld here while both wait for it, by a thread that needs
/// none of the runtime's: all of these may wait for the client too.
#[tokio::test(flavor = "multi_thread", worker_threads = 6)]
async fn requests_reach_the_line_in_the_order_in_which_they_were_let_pass() {
    const WAITS: Duration = Duration::from_millis(50);
    let site = stand().await;
    let mut frames = site.hub.station("M1").unwrap().client().unwrap().trace();
    for round in 0..20 {
        let station = site.hub.station("M1").unwrap();
        let (_kept, never) = std::sync::mpsc::channel::<()>();
        let holder = std::thread::spawn(move || {
            station.client.send_if_modified(|_| {
                _ = never.recv_timeout(WAITS * 2);
                false
            });
        });
        let turns = [600 + round, 900 + round].map(|to| format!("Move Horizontal {to}"));
        let second = async {
            tokio::time::sleep(WAITS).await;
            accepted(&site, &turns[1]).await;
        };
        tokio::join!(accepted(&site, &turns[0]), second);
        holder.join().unwrap();
        let mut sent = Vec::new();
        while sent.len() < 2 {
            let Ok(frame) = frames.recv().await else { continue };
            let records = Records::new(&frame.payload).map_while(Result::ok);
            let moves = records.filter(|it| frame.dst == 1 && it.request == RequestId::MOVE);
            sent.extend(moves.map(|it| i16::from_le_bytes([it.data[0], it.data[1]])));
        }
        assert_eq!(sent, [600 + round, 900 + round]);
    }
}

/// The way of a program counts before the monitor has answered it: on a slow line it begins before the hub
/// hears so.
#[tokio::test]
async fn a_program_that_is_under_way_keeps_the_valve_shut() {
    const QUENCH: &str =
        "StartQuench Control centre=-5400,0 nozzle=60 sector=600,300 step=1 distance=30";
    let site = stand().await;
    site.bus.keep_back(RequestId::START_QUENCH);
    let (_, ()) = tokio::join!(accepted(&site, QUENCH), async {
        until("it is under way", || site.bus.waits()).await;
        let opening = tokio::time::timeout(Duration::from_secs(1), asks(&site, "Open Valve1"));
        let reply = opening.await;
        site.bus.let_through();
        let reply = reply.expect("it is not sent");
        assert_eq!((reply.status, reply.code()), (409, "keep_out"), "{reply:?}");
    });
    until("it runs", || is_set(&site, SubsystemId::CONTROL, "Quench")).await;
    kept_out(&site, "Open Valve1").await;
    assert!(is_set(&site, SubsystemId::VALVE1, "Closed"));
}

#[tokio::test]
async fn what_others_turn_there_is_shut_off() {
    let site = stand().await;
    opened(&site).await;
    let endpoint: Endpoint = site.hub.config().monitors[0].endpoint.clone();
    let other = Client::connect(&endpoint).await.unwrap();
    let turn = Request::new(SubsystemId::HORIZONTAL, Body::Move { destination: -2700 });
    other.request(&turn).await.unwrap().accepted().unwrap();
    until("it is ordered shut", || is_set(&site, SubsystemId::VALVE1, "Closing")).await;
    let alarm =
        || site.hub.alarms().list().iter().any(|it| it.id == "M1/KeepOut/Water" && it.active);
    until("there is an alarm", alarm).await;
    until("it is shut", || is_set(&site, SubsystemId::VALVE1, "Closed")).await;
    until("the alarm is over", || !alarm()).await;
    assert!(
        stays(Duration::from_millis(500), || is_set(&site, SubsystemId::VALVE1, "Closed")).await
    );
}

#[tokio::test]
async fn a_direction_that_is_not_known_is_not_clear() {
    let site = stand().await;
    accepted(&site, "SwitchLimits Horizontal off").await;
    until("limits are off", || is_set(&site, SubsystemId::HORIZONTAL, "Limitless")).await;
    let reply = asks(&site, "Open Valve1").await;
    assert_eq!((reply.status, reply.code()), (409, "keep_out"));
    let text = reply.body["error"]["en"].as_str().unwrap();
    assert!(text.contains("not known where the barrel points"), "{text}");
}
