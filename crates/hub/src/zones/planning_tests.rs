use std::time::Instant;

use lafet_place::planner::Offer;
use lafet_site::{Hand, Phase, Scope};

use super::super::hall::{
    blows, burns, ends, hall, is_ended, locate, opens_at_the_fire, sees, until,
};
use super::*;
use crate::store::Search;

/// Does this while a plan is computed; it has to end before the plan does.
fn meanwhile(hub: &Hub, what: impl FnOnce(&Hub) + Send + 'static) {
    let zones = hub.zones().unwrap();
    let planning = lock(&zones.planning);
    burns(hub);
    locate(hub);
    assert!(zones.machine().plans["hall"].computing.is_some());
    ends(hub, what);
    drop(planning);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_no_and_a_hold_do_not_wait_for_a_plan_and_votes_do() {
    let hub = hall();
    meanwhile(&hub, |hub| {
        let zones = hub.zones().unwrap();
        let votes = || hub.zones_view().unwrap().state.zones[0].votes.len();
        assert_eq!((votes(), zones.machine().held.len()), (1, 1), "one waits for the plan");
        let anna = Caller { via: "http", ..Caller::hub() };
        // Nothing is held yet; that it is answered is what counts.
        _ = hub.order_zones(&anna, Hand::Hold { zone: "hall".into(), on: true });
        hub.order_zones(&anna, Hand::Abort { zone: "hall".into() }).unwrap();
        hub.order_zones(&anna, Hand::Stop(Scope::Site)).unwrap();
        hub.refuse_everywhere(&anna, true);
        let began = Instant::now();
        hub.turn(zones);
        assert!(began.elapsed() < Duration::from_secs(1), "deadlines are looked at");
    });
    until(&hub, "the plan is there", |it| it.plans["hall"].computing.is_none());
    is_ended(&hub);
}

#[tokio::test(flavor = "multi_thread")]
async fn what_the_votes_open_aims_by_the_plan_that_they_waited_for() {
    let hub = hall();
    meanwhile(&hub, |_| {});
    opens_at_the_fire(&hub);
}

/// A zone is planned once a second; a fire that comes within it has its plan all the same.
#[tokio::test(flavor = "multi_thread")]
async fn votes_for_a_fire_soon_after_another_wait_for_its_plan() {
    let hub = hall();
    let zones = hub.zones().unwrap();
    {
        let _planning = lock(&zones.planning);
        burns(&hub);
        locate(&hub);
        ["west", "east"].iter().for_each(|it| sees(&hub, it, Signal::Quiet, 0.0));
        assert!(zones.machine().held.is_empty());
        burns(&hub);
        locate(&hub);
        let machine = zones.machine();
        assert!(machine.plans["hall"].waits);
        assert_eq!(machine.held.len(), 1, "the second vote");
    }
    let began = Instant::now();
    while zones.machine().lines.values().all(|line| line.engaged.is_none()) {
        assert!(began.elapsed() < Duration::from_secs(20), "it is not released");
        hub.look_at_fires(zones, &mut zones.machine(), hub.now());
        std::thread::park_timeout(Duration::from_millis(10));
    }
    let machine = zones.machine();
    let fire = machine.plans["hall"].by["M2"];
    assert_eq!(machine.lines["M2"].at(), Some(fire));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_plan_of_what_has_changed_meanwhile_is_not_taken() {
    let hub = hall();
    meanwhile(&hub, |hub| blows(hub, 9.0));
    until(&hub, "it is planned again", |it| {
        let plan = &it.plans["hall"];
        plan.computing.is_none() && plan.basis.is_some()
    });
    let machine = hub.zones().unwrap().machine();
    let plan = &machine.plans["hall"];
    assert_eq!((plan.computed, plan.basis.as_ref().unwrap().wind.speed_mps), (2, 9.0));
    assert!(machine.held.is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_plan_that_does_not_come_is_not_waited_for() {
    let hub = hall();
    meanwhile(&hub, |hub| {
        let zones = hub.zones().unwrap();
        let began = Instant::now();
        while !zones.machine().held.is_empty() {
            assert!(began.elapsed() < Duration::from_secs(15));
            hub.release_held(zones, &mut zones.machine());
            std::thread::park_timeout(Duration::from_millis(10));
        }
        assert!(began.elapsed() >= WAITS / 2);
        assert_eq!(hub.zones_view().unwrap().state.zones[0].votes.len(), 2);
    });
}

/// However many reports come while a plan is computed.
#[tokio::test(flavor = "multi_thread")]
async fn reports_that_wait_are_bounded_and_keep_their_order() {
    let hub = hall();
    meanwhile(&hub, |hub| {
        let zones = hub.zones().unwrap();
        for number in 0..3 * HELD_MAX {
            let (signal, condition) = (Signal::Alarm, Condition::Ready);
            let mut machine = zones.machine();
            let detector = if number % 2 == 0 { "west" } else { "east" }.to_owned();
            let event = Event::Detector { detector, signal, condition };
            hub.report(zones, &mut machine, &Caller::hub(), event, vec!["hall".into()]);
            assert!(machine.held.len() <= HELD_MAX);
        }
    });
    until(&hub, "none waits", |it| it.held.is_empty());
    let machine = hub.zones().unwrap().machine();
    assert_eq!(machine.site.state().detectors[1].signal, Some(Signal::Alarm), "the last one");
}

/// What takes a vote back, or is a hand's, is not too late for a delay that ends.
#[tokio::test(flavor = "multi_thread")]
async fn what_withdraws_water_does_not_wait() {
    let hub = hall();
    meanwhile(&hub, |hub| {
        let zones = hub.zones().unwrap();
        let mut machine = zones.machine();
        assert_eq!(machine.held.len(), 1, "the alarm of the east waits");
        let of = || vec!["hall".to_owned()];
        let report = |hub: &Hub, machine: &mut Machine, event| {
            hub.report(zones, machine, &Caller::hub(), event, of());
        };
        let (detector, condition) = ("east".to_owned(), Condition::Fault);
        report(hub, &mut machine, Event::Detector { detector, signal: Signal::Alarm, condition });
        assert!(machine.held.is_empty(), "its alarm goes first");
        assert_eq!(machine.site.state().zones[0].votes.len(), 1);
        let post = MonitorReport {
            reachable: true,
            authority: Authority::Person,
            ..MonitorReport::default()
        };
        report(hub, &mut machine, Event::Monitor { monitor: "M1".into(), report: post });
        assert!(machine.held.is_empty());
        let lost = MonitorReport { reachable: false, ..MonitorReport::default() };
        report(hub, &mut machine, Event::Monitor { monitor: "M2".into(), report: lost });
        assert_eq!(machine.held.len(), 1, "who takes its place has to know its fire");
    });
}

/// The fires that were planned for are gone, and so is the plan.
#[tokio::test(flavor = "multi_thread")]
async fn a_report_does_not_overtake_an_earlier_one() {
    let hub = hall();
    meanwhile(&hub, |hub| {
        let zones = hub.zones().unwrap();
        assert_eq!(zones.machine().held.len(), 1, "the alarm of the east waits");
        zones.machine().plans.get_mut("hall").unwrap().computing = None;
        let mut machine = zones.machine();
        let (detector, condition) = ("east".to_owned(), Condition::Ready);
        let event = Event::Detector { detector, signal: Signal::Quiet, condition };
        hub.report(zones, &mut machine, &Caller::hub(), event, vec!["hall".into()]);
        assert_eq!(machine.site.state().detectors[1].signal, Some(Signal::Quiet));
    });
}

/// The reach of each monitor of a zone takes milliseconds: it was computed with the plan.
#[tokio::test(flavor = "multi_thread")]
async fn a_plan_is_taken_in_the_order_that_was_computed_with_it() {
    let hub = hall();
    meanwhile(&hub, |hub| {
        let zones = hub.zones().unwrap();
        let (zone, machine) = (&zones.config.site.zones[0], &mut *zones.machine());
        let plan = machine.plans.remove("hall").unwrap();
        let able = hub.able(zones, machine, &machine.site.state(), zone);
        let basis = hub.basis(machine, &plan, &able);
        let job = hub.job(zones, machine, zone, (&plan, basis, able));
        machine.plans.insert("hall".into(), plan);
        let mut chosen = hub.chosen(job);
        assert_eq!(chosen.order, ["M2", "M1"]);
        chosen.order.reverse();
        hub.accept(zones, machine, chosen);
        assert_eq!(machine.preferred["hall"].0, ["M1", "M2"]);
    });
}

/// A plan that cannot be computed is reported once, with the reason; the zone goes on without one.
#[tokio::test]
async fn a_zone_that_cannot_be_planned_is_an_event() {
    let hub = hall();
    // More than the planner takes.
    blows(&hub, 45.0);
    burns(&hub);
    until(&hub, "it is not planned", |it| it.plans["hall"].failed.is_some());
    {
        let (zones, machine) = (hub.zones().unwrap(), &mut *hub.zones().unwrap().machine());
        let plan = machine.plans.get_mut("hall").unwrap();
        (plan.basis, plan.planned) = (None, None);
        hub.plan_fires(zones, machine, &zones.config.site.zones[0]);
    }
    until(&hub, "it is planned again", |it| {
        it.plans["hall"].computed >= 2 && it.plans["hall"].computing.is_none()
    });
    let search = Search { limit: 100, ..Search::default() };
    let events = hub.events().find(search).await.unwrap().found;
    let told: Vec<_> = events.iter().filter(|it| it.what.en.contains("be assigned")).collect();
    assert_eq!(told.len(), 1, "{events:?}");
    assert!(told[0].what.en.contains("wind") && told[0].what.ru.contains("hall"), "{told:?}");
    let machine = hub.zones().unwrap().machine();
    assert!(machine.plans["hall"].by.is_empty());
    let phase = machine.site.state().zones[0].phase;
    assert!(matches!(phase, Phase::Released { wet: true, .. }), "votes release it all the same");
}

/// The wind of the last report is planned with, also where nothing was planned before.
#[tokio::test]
async fn a_wind_that_is_old_is_kept_and_none_is_said_in_words() {
    let hub = hall();
    let zones = hub.zones().unwrap();
    let none = hub.zones_view().unwrap().planned_wind;
    assert_eq!((none.at_ms, none.speed_mps), (None, 0.0));
    assert!(none.text.en.contains("still air") && none.text.en.contains("90 %"), "{none:?}");
    assert!(none.text.ru.contains("штил"), "{none:?}");
    blows(&hub, 6.5);
    let mut machine = zones.machine();
    let later = hub.now() + super::super::WIND_COUNTS;
    hub.end_wind(&mut machine, later);
    let view = machine.view(later, true);
    assert!(view.wind.is_none());
    assert_eq!((view.planned_wind.at_ms, view.planned_wind.speed_mps), (Some(7), 6.5));
    assert!(view.planned_wind.text.ru.contains("6,5"), "{view:?}");
    let basis = hub.basis(&machine, &Plan::default(), &[]);
    assert_eq!(basis.wind.speed_mps, 6.5);
}

/// Offers of each monitor for one fire: while at most so many flow.
fn task(reaches_while: &[usize]) -> Task {
    let offer = Some(Offer { brings_lpm: 100.0, turn_s: 1.0, aim: None });
    let level = |flowing| Level {
        flowing,
        offers: reaches_while.iter().map(|most| vec![offer.filter(|_| flowing <= *most)]).collect(),
    };
    Task { needs_lpm: vec![1000.0], levels: (1..=reaches_while.len()).map(level).collect() }
}

/// The numbers of the monitors that votes may open.
fn opened(reaches_while: &[usize], chosen: &[usize], jets: usize, flows: &[usize]) -> Vec<String> {
    let task = task(reaches_while);
    let place = Place { at: [0.0, 0.0], heading: 0.0, height: 2.0 };
    let able: Vec<_> =
        (0..reaches_while.len()).map(|it| (it.to_string(), place, Built::as_delivered())).collect();
    let water = |it| Water { stays: None, flows: flows.contains(&it) };
    let job = Job {
        zone: "hall".into(),
        number: 1,
        basis: Basis::default(),
        fires: Vec::new(),
        water: (0..able.len()).map(water).collect(),
        before: vec![None; able.len()],
        able,
        jets,
        others: Vec::new(),
        monitors: Vec::new(),
    };
    let chosen = (0..reaches_while.len()).map(|it| chosen.contains(&it).then_some(0)).collect();
    opens(&task, &chosen, &job)
}

#[test]
fn votes_open_what_the_water_suffices_for() {
    const ALL: usize = usize::MAX;
    // Two of three reach the fire together; a third one would take the pressure from them.
    assert_eq!(opened(&[2, 2, 2], &[0, 1], ALL, &[]), ["0", "1"]);
    assert_eq!(opened(&[3, 3, 2], &[0, 1], ALL, &[]), ["0", "1"], "it would fall short itself");
    // One that reaches no fire aims as configured while the others have enough.
    assert_eq!(opened(&[3, 3, 0], &[0, 1], ALL, &[]), ["0", "1", "2"]);
    assert_eq!(opened(&[2, 2, 0], &[0, 1], ALL, &[]), ["0", "1"]);
    assert_eq!(opened(&[3, 3, 0, 0], &[0, 1], ALL, &[]), ["0", "1", "2"]);
    // In place of one that is lost, where as many flow as are wanted.
    assert_eq!(opened(&[2, 2, 2], &[0, 1], 2, &[]), ["0", "1", "2"]);
    assert_eq!(opened(&[2, 2, 1], &[0, 1], 2, &[]), ["0", "1"]);
    // Water that flows counts, wherever it goes.
    assert_eq!(opened(&[3, 0, 0, 0], &[0], ALL, &[2, 3]), ["0", "2", "3"]);
    assert_eq!(opened(&[3, 0, 0, 0], &[0], ALL, &[3]), ["0", "1", "3"]);
}
