//! A run that is stopped, or loses its hub, at any moment: what it has started is ended.

use std::time::Duration;

use lafet_acceptance::{End, Outcome, Run, Stage};

use crate::bench::{Http, Running, Site, shown};
use crate::person::Beside;

/// Runs it with a wire of its own.
async fn ended(change: impl FnOnce(&mut Http)) -> (Running, Outcome, Http) {
    let running = Running::start(Site::good()).await;
    let mut wire = running.wire();
    change(&mut wire);
    let mut person = Beside::of(&running);
    let plan = running.world.site.planned();
    let stages = [Stage::Dry].into();
    let outcome = Run::all(&mut wire, &mut person, &plan, &stages).await;
    (running, outcome, wire)
}

/// Given back, closed, and no drive turns.
async fn is_at_rest(name: &str, running: &Running, outcome: &Outcome) {
    assert!(outcome.left.is_empty(), "{name}: {}", shown(outcome));
    let monitors = running.ask("/api/monitors").await;
    for (id, monitor) in monitors.as_object().unwrap() {
        let holder = &monitor["authority"]["holder"];
        assert!(holder.is_null(), "{name}: {id} {holder}");
        let flags = monitor["status"]["subsystems"]["Valve1"]["flags"].to_string();
        assert!(flags.contains("Closed"), "{name}: {id} {flags}");
    }
    // Brakes need their time.
    tokio::time::sleep(Duration::from_secs(1)).await;
    let at = running.positions();
    tokio::time::sleep(Duration::from_millis(700)).await;
    assert!(running.rests_at(at), "{name}: {at:?} {:?}", running.positions());
    assert!(!running.world.was_wet(), "{name}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stop_in_the_middle_of_a_motion_ends_it() {
    let (running, outcome, _) = ended(|wire| wire.stop_after = Some(7)).await;
    assert_eq!(outcome.ended, Some(End::Stopped), "{}", shown(&outcome));
    is_at_rest("7", &running, &outcome).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "minutes: a stop after each order"]
async fn a_stop_after_any_order_leaves_nothing_behind() {
    let all: Vec<usize> = (3..30).collect();
    crate::wrong::side_by_side(all, |after| async move {
        let (running, outcome, wire) = ended(|wire| wire.stop_after = Some(after)).await;
        let name = format!("after {after} of {}", wire.sent.len());
        is_at_rest(&name, &running, &outcome).await;
        println!("{name}: {:?}", outcome.ended);
    })
    .await;
}

/// The connection is lost for a few postings and comes back while what was started is being ended.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_lost_connection_ends_the_run_and_what_it_has_started() {
    let (running, outcome, _) = ended(|wire| wire.lost_after = Some((8, 10))).await;
    assert!(matches!(outcome.ended, Some(End::Lost(_))), "{}", shown(&outcome));
    is_at_rest("lost", &running, &outcome).await;
}

/// An order that the hub has carried out, but whose answer is lost, is ended as well.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_was_carried_out_without_an_answer_is_ended() {
    for unheard in [("/authority", "take"), ("/requests", "Move")] {
        let (running, outcome, wire) = ended(|wire| wire.unheard = Some(unheard)).await;
        assert!(matches!(outcome.ended, Some(End::Lost(_))), "{unheard:?}: {}", shown(&outcome));
        is_at_rest(unheard.1, &running, &outcome).await;
        let stops = wire.sent.iter().filter(|it| it.path().ends_with("/stop")).count();
        assert_eq!(stops, 1, "{unheard:?}");
    }
}
