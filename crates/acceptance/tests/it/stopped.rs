//! A run that is stopped, or loses its hub, at any moment: what it began is ended, and the zone is back in its mode.

use std::sync::Arc;

use lafet_acceptance::{End, Outcome, Run, Stage};
use serde_json::Value;

use crate::bench::{Http, Running, Site, failed, http, shown};
use crate::person::Beside;

const STAGES: [Stage; 3] = [Stage::Read, Stage::Dry, Stage::Outlet];

/// Runs it with a wire of its own; what the hub says afterwards.
async fn ended(change: impl FnOnce(&mut Http)) -> (Outcome, Value, Value, usize) {
    let running = Running::start(Site::good()).await;
    let mut wire = running.wire();
    change(&mut wire);
    let mut person = Beside::of(Arc::clone(&running.world));
    let plan = running.world.site.planned();
    let stages = STAGES.into_iter().collect();
    let outcome = Run::all(&mut wire, &mut person, &plan, &stages).await;
    let ask =
        async |path: &str| http(running.address, &running.token, "GET", path, "").await.unwrap().1;
    let (zones, monitors) = (ask("/api/zones").await, ask("/api/monitors").await);
    (outcome, zones, monitors, wire.sent.len())
}

fn is_at_rest(name: &str, outcome: &Outcome, zones: &Value, monitors: &Value) {
    let zone = &zones["state"]["zones"][0];
    let sees_fire = zone["alarms"].as_array().is_some_and(|it| !it.is_empty());
    if sees_fire {
        // Put back it would let the votes count: it stays ended, and that is said.
        assert_eq!(zone["phase"]["ended"], "abort", "{name}: {zone:#}");
        assert_eq!(outcome.left.len(), 1, "{name}: {}", shown(outcome));
    } else {
        assert_eq!(zone["mode"], "automatic", "{name}: {zone:#}");
        assert!(outcome.left.is_empty(), "{name}: {}", shown(outcome));
    }
    for (id, monitor) in monitors.as_object().unwrap() {
        let holder = &monitor["authority"]["holder"]["user"];
        assert!(holder.is_null() || holder == "zones", "{name}: {id} {holder}");
        let flags = monitor["status"]["subsystems"]["Valve1"]["flags"].to_string();
        assert!(flags.contains("Closed"), "{name}: {id} {flags}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stop_in_the_middle_of_a_motion_ends_it() {
    let (outcome, zones, monitors, _) = ended(|wire| wire.stop_after = Some(6)).await;
    assert_eq!(outcome.ended, Some(End::Stopped), "{}", shown(&outcome));
    is_at_rest("6", &outcome, &zones, &monitors);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "minutes: a stop after each order"]
async fn a_stop_after_any_order_leaves_nothing_behind() {
    let all: Vec<usize> = (3..60).collect();
    crate::wrong::side_by_side(all, |after| async move {
        let (outcome, zones, monitors, sent) = ended(|wire| wire.stop_after = Some(after)).await;
        let name = format!("after {after} of {sent}");
        is_at_rest(&name, &outcome, &zones, &monitors);
        println!("{name}: {:?}", outcome.ended);
    })
    .await;
}

/// The connection is lost for a few postings and comes back while what was started is being ended.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_lost_connection_ends_the_run_and_what_it_began() {
    let (outcome, zones, monitors, _) = ended(|wire| wire.lost_after = Some((8, 10))).await;
    assert!(matches!(outcome.ended, Some(End::Lost(_))), "{}", shown(&outcome));
    is_at_rest("lost", &outcome, &zones, &monitors);
}

/// An alarm without a test source ends the test at once: the zone controller needs the monitors.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_alarm_that_was_not_asked_for_ends_the_run() {
    let running = Running::start(Site::good()).await;
    let world = running.world.clone();
    let mut wire = running.wire();
    let mut person = Beside::of(world.clone());
    let plan = running.world.site.planned();
    tokio::spawn(async move {
        tokio::time::sleep(std::time::Duration::from_secs(2)).await;
        world.sources()[0] = true;
    });
    let stages = [Stage::Dry].into_iter().collect();
    let outcome = Run::all(&mut wire, &mut person, &plan, &stages).await;
    assert!(matches!(outcome.ended, Some(End::Unsafe(_))), "{}", shown(&outcome));
    let monitors =
        http(running.address, &running.token, "GET", "/api/monitors", "").await.unwrap().1;
    assert_eq!(monitors["M1"]["authority"]["holder"], Value::Null);
    assert!(failed(&outcome).is_empty(), "{}", shown(&outcome));
}
