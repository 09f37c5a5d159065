//! The test outlet: people act, the program looks. It orders nothing, ends with what must not be, and says what is left.

use lafet_acceptance::{End, Outcome, Run, Stage, Verdict, check};
use serde_json::json;

use crate::bench::{Http, Running, Site, failed, shown};
use crate::person::{Beside, Deed};

async fn run(change: impl FnOnce(&mut Beside)) -> (Running, Outcome, Beside, Http) {
    let running = Running::start(Site::good()).await;
    let (mut person, mut wire) = (Beside::of(&running), running.wire());
    change(&mut person);
    let plan = running.world.site.planned();
    let outcome = Run::all(&mut wire, &mut person, &plan, &[Stage::Outlet].into()).await;
    assert!(orders_nothing(&wire), "{:#?}", wire.sent);
    (running, outcome, person, wire)
}

/// Parameters are read, and nothing else is sent.
fn orders_nothing(wire: &Http) -> bool {
    wire.sent.iter().all(|it| it.path().ends_with("/params/read"))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_good_zone_passes_without_an_order_of_the_program() {
    let (running, outcome, person, _) = run(|_| {}).await;
    assert_eq!(failed(&outcome), Vec::<String>::new(), "{}", shown(&outcome));
    assert!(outcome.ended.is_none() && outcome.left.is_empty(), "{}", shown(&outcome));
    for it in check::ALL.iter().filter(|it| it.stage == Stage::Outlet) {
        let mut of = outcome.findings.0.iter().filter(|found| found.check.id == it.id);
        assert!(of.any(|found| found.verdict == Verdict::Pass), "{}: {}", it.id, shown(&outcome));
    }
    assert!(!running.world.was_wet(), "{}", shown(&outcome));
    let zones = running.ask("/api/zones").await;
    let zone = &zones["state"]["zones"][0];
    assert!(zone["mode"] == "automatic" && zone["phase"] == "quiet", "{zone}");
    println!("{} ms, {} questions", outcome.took_ms, person.asked.len());
}

/// A yes is not believed: the mode of the test is looked for, and nothing is asked for that would release without it.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn without_the_mode_of_the_test_no_source_is_asked_for() {
    let (_, outcome, person, _) = run(|person| person.idle = true).await;
    assert_eq!(person.asked, ["outlet/hall/go"]);
    assert_eq!(outcome.findings.count(Verdict::Pass), 0, "{}", shown(&outcome));
    assert!(outcome.ended.is_none() && outcome.left.is_empty(), "{}", shown(&outcome));
}

/// Who stops in the middle is reminded of the mode: there may be no automatic water until it is set back.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_left_in_the_mode_of_the_test_is_said() {
    let (_, outcome, person, _) = run(|person| person.stops = Some("outlet/hall/heat/on")).await;
    assert_eq!(outcome.ended, Some(End::Stopped), "{}", shown(&outcome));
    assert!(outcome.left.iter().any(|it| it.en.starts_with("Zone hall is not as it was")));
    assert!(
        person.heard.iter().any(|it| it.contains("set the mode automatic")),
        "{:?}",
        person.heard
    );
}

/// Water of a person, lockout, a mode that ends: the run ends, and no source is asked for any more.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_must_not_be_ends_the_trial() {
    for deed in [
        Deed::Order("/api/zones/hall/release", json!({ "confirm": "hall" })),
        Deed::Order("/api/zones/lock", json!({})),
        Deed::Order("/api/zones/hall/mode", json!({ "mode": "automatic" })),
    ] {
        let (_, outcome, person, _) = run(|person| {
            person.deed = Some(("outlet/hall/heat/off", deed, 60_000));
        })
        .await;
        assert!(matches!(outcome.ended, Some(End::Unsafe(_))), "{}", shown(&outcome));
        assert_eq!(person.asked.last().map(String::as_str), Some("outlet/hall/heat/off"));
        assert!(!outcome.left.is_empty(), "{}", shown(&outcome));
    }
}
