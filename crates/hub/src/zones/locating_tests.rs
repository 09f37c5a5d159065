use std::time::{Duration, Instant};

use lafet_site::{Hand, Scope, Signal};

use super::super::hall::{burns, ends, hall, is_ended, locate, opens_at_the_fire, sees, until};
use super::*;
use crate::hub::Caller;

/// Does this while fires are located, however long that takes; it has to end before.
fn meanwhile(hub: &Hub, what: impl FnOnce(&Hub) + Send + 'static) {
    let zones = hub.zones().unwrap();
    let planning = lock(&zones.planning);
    ends(hub, burns);
    {
        let machine = zones.machine();
        assert!(machine.locating["hall"].since.is_some(), "they are located");
        assert!(machine.fires["hall"].is_empty(), "on another thread");
    }
    ends(hub, what);
    drop(planning);
}

fn votes(hub: &Hub) -> usize {
    hub.zones_view().unwrap().state.zones[0].votes.len()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_no_and_a_deadline_do_not_wait_until_fires_are_located() {
    let hub = hall();
    meanwhile(&hub, |hub| {
        let zones = hub.zones().unwrap();
        assert_eq!((votes(hub), zones.machine().held.len()), (1, 1), "a vote waits");
        let anna = Caller { via: "http", ..Caller::hub() };
        _ = hub.order_zones(&anna, Hand::Hold { zone: "hall".into(), on: true });
        hub.order_zones(&anna, Hand::Abort { zone: "hall".into() }).unwrap();
        hub.order_zones(&anna, Hand::Stop(Scope::Site)).unwrap();
        hub.refuse_everywhere(&anna, true);
        hub.turn(zones);
    });
    until(&hub, "what waited is with the machine", |it| it.held.is_empty());
    is_ended(&hub);
}

#[tokio::test(flavor = "multi_thread")]
async fn what_the_votes_open_aims_at_what_they_show() {
    let hub = hall();
    meanwhile(&hub, |_| {});
    opens_at_the_fire(&hub);
}

/// Without a place they open as configured.
#[tokio::test(flavor = "multi_thread")]
async fn fires_that_are_not_located_in_time_are_not_waited_for() {
    let hub = hall();
    meanwhile(&hub, |hub| {
        let zones = hub.zones().unwrap();
        let began = Instant::now();
        while !zones.machine().held.is_empty() {
            assert!(began.elapsed() < Duration::from_secs(15));
            hub.release_held(zones, &mut zones.machine());
            std::thread::park_timeout(Duration::from_millis(10));
        }
        assert_eq!(votes(hub), 2);
        let machine = zones.machine();
        let engaged = machine.lines.values().filter(|line| line.engaged.is_some());
        assert!(engaged.map(|line| line.at()).eq([None, None]), "{:?}", machine.lines);
    });
}

/// The hall with a search under way that has both bearings; the planning is held.
fn searched(hub: &Hub) -> Search {
    burns(hub);
    let zones = hub.zones().unwrap();
    let search = hub.latest_search(zones, &zones.machine(), &zones.config.site.zones[0]);
    search.expect("one is under way")
}

fn take(hub: &Hub, search: Search) {
    let zones = hub.zones().unwrap();
    hub.take_located(zones, &mut zones.machine(), &zones.config.site.zones[0], search.run());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_fire_that_is_not_seen_any_more_when_it_is_located_is_dropped() {
    let hub = hall();
    let zones = hub.zones().unwrap();
    let planning = lock(&zones.planning);
    let search = searched(&hub);
    sees(&hub, "east", Signal::Quiet, 0.0);
    take(&hub, search);
    {
        let machine = zones.machine();
        assert!(machine.fires["hall"].is_empty(), "{:?}", machine.fires);
        assert!(machine.plans["hall"].counted().next().is_none());
        assert!(machine.locating["hall"].since.is_none() && machine.held.is_empty());
    }
    drop(planning);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_report_does_not_go_by_a_place_that_is_dropped() {
    let hub = hall();
    let zones = hub.zones().unwrap();
    let planning = lock(&zones.planning);
    let search = searched(&hub);
    // Midway between them: the search has it 10 m east.
    sees(&hub, "east", Signal::Alarm, 303.69);
    take(&hub, search);
    {
        let machine = zones.machine();
        assert!(machine.fires["hall"].is_empty(), "{:?}", machine.fires);
        assert_eq!((machine.locating["hall"].number, machine.held.len()), (2, 2));
    }
    locate(&hub);
    let at = zones.machine().fires["hall"][0].at;
    assert!(at[0].abs() < 0.5, "{at:?}");
    drop(planning);
    until(&hub, "it is planned", |it| it.held.is_empty());
    let machine = zones.machine();
    assert_eq!(machine.lines["M2"].at(), Some(1));
}

/// Bearings of each report differ a little: the reports before do not wait for the one that is the last.
#[tokio::test(flavor = "multi_thread")]
async fn fires_are_located_however_often_detectors_report() {
    let hub = hall();
    let zones = hub.zones().unwrap();
    let planning = lock(&zones.planning);
    let search = searched(&hub);
    sees(&hub, "east", Signal::Alarm, 333.5);
    take(&hub, search);
    {
        let machine = zones.machine();
        assert_eq!(machine.fires["hall"].len(), 1);
        let locating = &machine.locating["hall"];
        assert_eq!((locating.number, locating.reported - locating.located), (2, 1));
    }
    sees(&hub, "west", Signal::Alarm, 56.31);
    locate(&hub);
    let locating = &zones.machine().locating["hall"];
    assert_eq!((locating.since, locating.reported), (None, locating.located), "a repetition");
    drop(planning);
}

/// A search that has ended after it was given up, or after another one, is none.
#[tokio::test(flavor = "multi_thread")]
async fn a_search_that_is_not_the_latest_is_dropped() {
    let hub = hall();
    let zones = hub.zones().unwrap();
    let planning = lock(&zones.planning);
    let search = searched(&hub);
    zones.machine().locating.get_mut("hall").unwrap().end_lost(hub.now() + LOST);
    let again = searched(&hub);
    take(&hub, search);
    assert!(zones.machine().fires["hall"].is_empty());
    take(&hub, again);
    assert_eq!(zones.machine().fires["hall"].len(), 1);
    drop(planning);
}
