//! Motion that no person has agreed to: others who stop, lock, take, turn or move away while a question waits, people
//! who do not answer, a hub and monitors that are not heard. Nothing turns after that, and nothing is wet.

use std::time::{Duration, Instant};

use lafet_acceptance::{End, Outcome, Run, Stage};
use serde_json::json;
use tokio::time::sleep;

use crate::bench::{Http, Running, Site, failed, shown};
use crate::person::{Beside, Deed};

/// Tests it with a person and a wire of its own.
async fn run(
    running: &Running,
    change: impl FnOnce(&mut Beside, &mut Http),
) -> (Outcome, Beside, Http) {
    let (mut person, mut wire) = (Beside::of(running), running.wire());
    change(&mut person, &mut wire);
    let plan = running.world.site.planned();
    let outcome = Run::all(&mut wire, &mut person, &plan, &[Stage::Dry].into()).await;
    (outcome, person, wire)
}

/// Orders that move.
fn moved(wire: &Http) -> usize {
    let moves = |it: &&lafet_acceptance::order::Posting| it.path().ends_with("/requests");
    wire.sent.iter().filter(moves).count()
}

/// Whatever another person does while a question waits ends the run, without an answer: nothing moves any more.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn after_the_no_of_a_person_nothing_moves() {
    let none = || json!({});
    for deed in [
        Deed::Order("/api/monitors/M1/stop", none()),
        Deed::Order("/api/monitors/M1/close", none()),
        Deed::Order("/api/monitors/M1/lockout", none()),
        Deed::Order("/api/stop", none()),
        Deed::Order("/api/zones/lock", none()),
        Deed::Order(
            "/api/monitors/M1/authority",
            json!({ "action": "force", "reason": "people in the way" }),
        ),
        Deed::Fire,
    ] {
        let running = Running::start(Site::good()).await;
        let start = Instant::now();
        let (outcome, _, _) = run(&running, |person, _| {
            person.deed = Some(("dry/M1/which", deed, 60_000));
        })
        .await;
        assert!(matches!(outcome.ended, Some(End::Unsafe(_))), "{}", shown(&outcome));
        assert!(start.elapsed() < Duration::from_secs(50), "the question ends with the run");
        // It points to the target still, where the person has seen it.
        sleep(Duration::from_secs(2)).await;
        let (at, target) = (running.world.bearing(0), running.world.wanted(0));
        assert!((at - target).abs() < 2.0, "{at} {target}: {}", shown(&outcome));
        assert!(!running.world.was_wet(), "{}", shown(&outcome));
    }
}

/// A Stop that is given before the first yes counts, too.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stop_before_anything_has_moved_counts() {
    let running = Running::start(Site::good()).await;
    let stop = Deed::Order("/api/monitors/M1/stop", json!({}));
    let (outcome, _, wire) = run(&running, |person, _| {
        person.deed = Some(("dry/M1/go", stop, 500));
    })
    .await;
    assert!(matches!(outcome.ended, Some(End::Unsafe(_))), "{}", shown(&outcome));
    assert_eq!(moved(&wire), 0, "{:#?}", wire.sent);
}

/// A Stop that is given while the answer is typed counts, too: the site is looked at after each answer.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stop_just_before_the_answer_counts() {
    let running = Running::start(Site::good()).await;
    let stop = Deed::Order("/api/monitors/M1/stop", json!({}));
    let (outcome, person, _) = run(&running, |person, _| {
        person.deed = Some(("dry/M1/back", stop, 0));
    })
    .await;
    assert!(matches!(outcome.ended, Some(End::Unsafe(_))), "{}", shown(&outcome));
    assert_eq!(person.asked.last().map(String::as_str), Some("dry/M1/back"));
    let (at, target) = (running.world.bearing(0), running.world.wanted(0));
    assert!((at - target).abs() < 2.0, "{at} {target}: {}", shown(&outcome));
}

/// A monitor that stays unheard is not moved: neither to the target nor back.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_monitor_that_is_not_heard_does_not_move() {
    let running = Running::start(Site::good()).await;
    let (outcome, _, wire) = run(&running, |person, _| {
        person.deed = Some(("dry/M1/target", Deed::Silence, 4000));
        person.skips = vec!["dry/M2/go"];
    })
    .await;
    // The last motion is the way back of the one that was stopped.
    let stop = wire.sent.iter().rposition(|it| it.path().ends_with("/stop")).unwrap();
    let after = wire.sent[stop..].iter().filter(|it| it.path().ends_with("/requests")).count();
    assert_eq!(after, 1, "{:#?}", wire.sent);
    assert!(failed(&outcome).is_empty(), "{}", shown(&outcome));
}

/// A monitor that another client holds, also another program with the same token, is not tried.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_monitor_of_another_client_is_not_tried() {
    let take = || json!({ "action": "take" });
    for deed in [
        Deed::Order("/api/monitors/M1/authority", take()),
        Deed::Own("/api/monitors/M1/authority", take()),
    ] {
        let running = Running::start(Site::good()).await;
        let (outcome, person, wire) = run(&running, |person, _| {
            person.deed = Some(("dry/M1/go", deed, 0));
            person.skips = vec!["dry/M2/go"];
        })
        .await;
        assert_eq!(moved(&wire), 0, "{:#?}", wire.sent);
        assert!(!person.asked.iter().any(|it| it == "dry/M1/target"), "{:?}", person.asked);
        assert!(outcome.ended.is_none(), "{}", shown(&outcome));
    }
}

/// Who has been asked and does not say yes keeps the barrel where it is; and the long way needs a yes of its own.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_way_needs_a_yes() {
    let running = Running::start(Site::good()).await;
    let (outcome, _, _) = run(&running, |person, _| {
        person.skips = vec!["dry/M1/back", "dry/M2/target"];
    })
    .await;
    assert!(outcome.ended.is_none(), "{}", shown(&outcome));
    let (at, target) = (running.world.bearing(0), running.world.wanted(0));
    assert!((at - target).abs() < 2.0, "it does not turn back: {at} {target}");
    assert!(running.world.bearing(1).abs() < 2.0, "it does not turn there");
}

/// A monitor that a person has locked out is not touched: neither taken nor moved, nor stopped.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_monitor_that_is_locked_out_is_not_touched() {
    let mut site = Site::good();
    site.before = vec![("/api/monitors/M2/lockout", json!({}))];
    let running = Running::start(site).await;
    let (outcome, person, wire) = run(&running, |_, _| {}).await;
    let touched = wire.sent.iter().filter(|it| it.path().starts_with("/api/monitors/M2/"));
    assert!(touched.clone().all(|it| it.path().ends_with("/params/read")), "{:#?}", wire.sent);
    assert!(!person.asked.iter().any(|it| it.starts_with("dry/M2/")), "{:?}", person.asked);
    let of = |it: &&lafet_acceptance::Finding| it.check.id == "motion" && it.subject == "M2";
    let motion = outcome.findings.0.iter().find(of).unwrap();
    assert_eq!(motion.why.as_ref().unwrap().en, "it is locked out", "{}", shown(&outcome));
}

/// What is locked out while it is tried, over the hub or at its post, is at rest: nothing more is sent that moves,
/// and no one is called to stop it.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_lockout_ends_the_run_and_leaves_nothing_to_do() {
    for deed in [Deed::Post, Deed::Order("/api/monitors/M1/lockout", json!({}))] {
        let running = Running::start(Site::good()).await;
        let (outcome, person, wire) = run(&running, |person, _| {
            person.deed = Some(("dry/M1/target", deed, 60_000));
        })
        .await;
        assert!(matches!(outcome.ended, Some(End::Unsafe(_))), "{}", shown(&outcome));
        assert_eq!(outcome.left, Vec::new(), "{}", shown(&outcome));
        assert_eq!(person.asked.last().map(String::as_str), Some("dry/M1/target"));
        let stop = wire.sent.iter().position(|it| it.path().ends_with("/stop")).unwrap();
        let after = wire.sent[stop..].iter().filter(|it| it.path().ends_with("/requests"));
        assert_eq!(after.count(), 1, "the way back of the motion that was stopped is the last");
        assert!(!person.heard.iter().any(|it| it.contains("not reached")), "{:?}", person.heard);
    }
}

/// A drive that goes the wrong way is stopped at once, and not after its time.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_drive_that_goes_astray_is_stopped() {
    let mut site = Site::good();
    site.faults = vec![(0, "horizontal-encoder-reversed")];
    let running = Running::start(site).await;
    let (outcome, _, _) = run(&running, |person, _| {
        person.skips = vec!["dry/M2/go", "dry/M1/target"];
    })
    .await;
    assert_eq!(failed(&outcome), ["motion M1"], "{}", shown(&outcome));
    // Three times as fast as the time of the hub, with its reaction and its brake.
    let off = running.world.bearing(0).abs();
    assert!(off < 60.0, "{off}°: {}", shown(&outcome));
}

/// The monitors of another hub than that of the plan do not move, nor those of a site that is not at rest.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn at_another_site_nothing_moves() {
    let mut other = Site::good();
    other.plan = other
        .plan
        .replacen("id = \"M2\"", "id = \"M9\"", 1)
        .replace("monitors = [\"M1\", \"M2\"]", "monitors = [\"M1\", \"M9\"]");
    other.plan = other.plan.replace("monitor = \"M2\"", "monitor = \"M9\"");
    let mut locked = Site::good();
    locked.before = vec![("/api/zones/lock", json!({}))];
    for site in [other, locked] {
        let running = Running::start(site).await;
        let (outcome, _, wire) = run(&running, |_, _| {}).await;
        assert!(matches!(outcome.ended, Some(End::Unsafe(_))), "{}", shown(&outcome));
        assert_eq!(moved(&wire), 0, "{:#?}", wire.sent);
    }
}

/// What is held up for longer than the hub takes it is refused by the hub, and not sent again.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_order_that_comes_late_moves_nothing() {
    let running = Running::start(Site::good()).await;
    let before = running.positions();
    let (outcome, _, _) = run(&running, |person, wire| {
        wire.slow = true;
        person.skips = vec!["dry/M2/go"];
    })
    .await;
    assert!(running.rests_at(before), "{:?} {:?}", before, running.positions());
    assert_eq!(failed(&outcome), ["motion M1"], "{}", shown(&outcome));
}

/// An answer in which a zone or a monitor is missing is none.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_not_known_is_not_safe() {
    for (path, pointer, value) in [
        ("/api/zones", "/state/zones", json!([])),
        ("/api/monitors", "/M2", json!(null)),
        ("/api/hub", "/up_ms", json!(0)),
    ] {
        let running = Running::start(Site::good()).await;
        let (outcome, _, wire) = run(&running, |_, wire| {
            wire.answers_later = Some((path, pointer, value));
        })
        .await;
        assert!(outcome.ended.is_some(), "{path}: {}", shown(&outcome));
        assert_eq!(moved(&wire), 0, "{path}: {:#?}", wire.sent);
    }
}
