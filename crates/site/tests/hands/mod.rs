//! Hands against each other and against the machine: at a post, at a key, at a pump, at two consoles at once.

use super::hazards::{OPEN, SHUT, of, of_orders, restarted};
use super::*;

fn pump(pump: &str, on: bool) -> Hand {
    Hand::Pump { pump: pump.to_owned(), on }
}

fn abort() -> Hand {
    Hand::Abort { zone: zone() }
}

/// A button of its post takes a monitor while its order is on its way: the water of that order has its end.
#[test]
fn water_of_an_order_that_was_on_its_way_when_a_person_took_the_monitor_ends() {
    let person = MonitorReport { authority: Authority::Person, ..SHUT };
    let flows = MonitorReport { valve: Valve::Open, ..person };
    let taken = || {
        let mut hall = Hall::with(|config| config.zones[0].jets = Some(1));
        hall.fire();
        assert_eq!(of(&hall.wait(15_000), "Engage"), ["Engage north Some(60000)"]);
        let taken = orders(&hall.monitor("north", person));
        assert!(taken.contains(&"Engage south Some(60000)".to_owned()), "{taken:?}");
        hall.monitor("south", OPEN);
        hall
    };
    for site in [Authority::Site, Authority::Free] {
        let ours = MonitorReport { authority: site, ..OPEN };
        let mut hall = taken();
        hall.wait(200);
        hall.monitor("north", flows);
        hall.wait(30_000);
        hall.monitor("north", ours);
        let all = hall.wait(60_000);
        assert!(all.contains(&(75_000, "Close north".to_owned())), "{all:?}");
        // Given back before it opens.
        let mut hall = taken();
        hall.wait(100);
        hall.monitor("north", MonitorReport { authority: site, ..SHUT });
        hall.wait(100);
        hall.monitor("north", ours);
        let all = hall.wait(60_000);
        assert!(all.contains(&(75_000, "Close north".to_owned())), "{all:?}");
    }
    // What opens after the order is void was opened by the person.
    let mut hall = taken();
    assert!(of(&hall.wait(2000), "Close").is_empty());
    hall.monitor("north", flows);
    hall.wait(5000);
    hall.monitor("north", OPEN);
    let all = hall.wait(100_000);
    assert!(of(&all, "Close north").is_empty(), "{all:?}");
    // One that did not open is free again.
    let mut hall = taken();
    hall.wait(3000);
    hall.monitor("north", SHUT);
    hall.monitor("south", MonitorReport { failure: true, ..OPEN });
    assert_eq!(hall.site.state().zones[0].monitors, ["north", "south"]);
}

/// The order that it had would be accepted when its lockout is lifted.
#[test]
fn a_monitor_that_is_locked_out_before_it_opens_is_closed_at_once() {
    let mut hall = Hall::new();
    hall.fire();
    hall.wait(15_000);
    let locked = hall.monitor("north", MonitorReport { lockout: true, ..SHUT });
    assert_eq!(orders(&locked), ["Close north"]);
    hall.wait(5000);
    hall.monitor("north", SHUT);
    let later = hall.wait(40_000);
    assert!(of(&later, "Engage north").is_empty(), "{later:?}");
}

/// A mechanic may work on it: it stays off until a reset of all zones.
#[test]
fn a_pump_that_is_kept_off_stays_off_over_a_stop_a_lockout_and_a_restart() {
    let hand = |hall: &Hall| hall.site.state().pumps[0].hand;
    for lockout in [false, true] {
        let mut hall = Hall::new();
        assert!(hall.hand(pump("p1", false)).persist);
        hall.hand(match lockout {
            true => Hand::Lockout { on: true },
            false => Hand::Stop(Scope::Site),
        });
        hall.wait(3000);
        hall.hand(Hand::Lockout { on: false });
        assert_eq!(hand(&hall), Some(false), "lockout: {lockout}");
        let mut again = restarted(&hall, |_| {});
        again.monitors(Valve::Closed);
        again.wait(3000);
        for hall in [&mut hall, &mut again] {
            let released = orders(&hall.hand(Hand::Release { zone: zone() }));
            assert!(!of_orders(&released, "Engage").is_empty(), "{released:?}");
            let all = hall.wait(30_000);
            assert!(of_orders(&released, "Pump p1").is_empty() && of(&all, "Pump p1").is_empty());
            hall.hand(abort());
            hall.wait(3000);
            hall.hand(Hand::Reset(Scope::Site));
            assert_eq!(hand(hall), None);
        }
    }
    // What a person has started ends, and is not started again.
    let mut hall = Hall::new();
    assert_eq!(orders(&hall.hand(pump("p1", true))), ["Pump p1 on"]);
    assert!(orders(&hall.hand(Hand::Stop(Scope::Site))).contains(&"Pump p1 off".to_owned()));
    assert_eq!(hand(&hall), None);
}

/// One detector sees the fire, and the other one cannot: its vote comes after the lockout.
#[test]
fn what_is_in_alarm_when_lockout_ends_needs_a_reset_although_a_vote_is_missing() {
    for by_key in [true, false] {
        let mut hall = Hall::new();
        let lock = |hall: &mut Hall, on| match by_key {
            true => hall.press("key", on),
            false => hall.hand(Hand::Lockout { on }),
        };
        lock(&mut hall, true);
        hall.wait(3000);
        hall.sees("flame", Signal::Alarm);
        lock(&mut hall, false);
        hall.wait(100);
        assert_eq!(hall.phase(), Phase::Ended(Why::Lockout));
        hall.sees("heat", Signal::Alarm);
        let later = hall.wait(60_000);
        assert!(of(&later, "Engage").is_empty(), "{later:?}");
        hall.hand(Hand::Reset(Scope::Site));
        assert_eq!(of(&hall.wait(15_000), "Engage").len(), 2);
    }
    // The end of the lockout is no no: a reset may follow at once.
    let mut hall = Hall::new();
    hall.hand(Hand::Lockout { on: true });
    hall.fire();
    hall.wait(3000);
    hall.hand(Hand::Lockout { on: false });
    assert_eq!(refusal(&hall.hand(Hand::Reset(Scope::Site))), None);
    assert_eq!(hall.phase(), Phase::Coincidence);
}

/// Two persons at two consoles: the one who says no is heard.
#[test]
fn a_reset_or_an_unlock_at_the_same_time_as_a_no_is_refused() {
    let resets = [Scope::Site, Scope::Zone(zone()), Scope::Monitor("north".to_owned())];
    for (no, refuses) in [
        (abort(), [true, true, false]),
        (Hand::Stop(Scope::Site), [true, true, false]),
        (Hand::Close(Scope::Monitor("north".to_owned())), [true, true, true]),
        (pump("p1", false), [true, false, false]),
    ] {
        for (reset, refuses) in resets.iter().zip(refuses) {
            let mut hall = Hall::new();
            hall.hand(no.clone());
            let before = hall.site.state().disablements;
            hall.wait(1999);
            let just = hall.hand(Hand::Reset(reset.clone()));
            let expected = refuses.then_some(Refusal::JustRefused);
            assert_eq!(refusal(&just), expected, "{no:?} {reset:?}");
            assert_eq!(hall.site.state().disablements, before, "{no:?} {reset:?}");
            hall.wait(1);
            assert_eq!(refusal(&hall.hand(Hand::Reset(reset.clone()))), None, "{no:?} {reset:?}");
        }
    }
    // The second one who locks counts as well.
    let mut hall = Hall::new();
    for _ in 0..2 {
        hall.hand(Hand::Lockout { on: true });
        hall.wait(1999);
        let just = hall.hand(Hand::Lockout { on: false });
        assert_eq!(refusal(&just), Some(Refusal::JustRefused));
        assert!(hall.site.state().lockout);
        hall.now += 5000;
    }
    assert_eq!(refusal(&hall.hand(Hand::Lockout { on: false })), None);
    assert!(!hall.site.state().lockout);
}

#[test]
fn a_pump_is_not_started_by_hand_against_a_stop() {
    let mut hall = Hall::new();
    hall.hand(Hand::Stop(Scope::Site));
    assert!(hall.site.is_refused(&Scope::Site), "one more changes nothing");
    hall.wait(1999);
    assert_eq!(refusal(&hall.hand(pump("p1", true))), Some(Refusal::JustRefused));
    assert_eq!(refusal(&hall.hand(pump("p2", false))), None);
    hall.wait(1);
    assert_eq!(orders(&hall.hand(pump("p1", true))), ["Pump p1 on"]);
    assert!(!hall.site.is_refused(&Scope::Site), "a repeated Stop ends it");
    assert!(orders(&hall.hand(Hand::Stop(Scope::Site))).contains(&"Pump p1 off".to_owned()));
    assert!(hall.site.is_refused(&Scope::Site));
    // As long as the contact is pressed.
    let mut hall = Hall::new();
    hall.press("stop", true);
    hall.wait(5000);
    assert_eq!(refusal(&hall.hand(pump("p1", true))), Some(Refusal::StillPressed));
    hall.press("stop", false);
    hall.wait(1000);
    assert_eq!(orders(&hall.hand(pump("p1", true))), ["Pump p1 on"]);
    // One of a zone alone ends no pumps, nor does it keep them off.
    let mut hall = Hall::with(|config| {
        config
            .contacts
            .iter_mut()
            .filter(|it| it.id == "stop")
            .for_each(|it| it.zones = vec![zone()]);
    });
    hall.press("stop", true);
    assert_eq!(orders(&hall.hand(pump("p1", true))), ["Pump p1 on"]);
}

/// Its zone was taken out of the file while its water ran: nothing else would end it.
#[test]
fn water_of_a_monitor_whose_zone_is_gone_ends_in_its_time() {
    let alone = |config: &mut Config| config.zones[0].monitors.truncate(1);
    let mut running = Hall::new();
    running.extinguishes();
    running.wait(20_000);
    let mut hall = restarted(&running, alone);
    let found = hall.monitor("south", OPEN);
    let left = Entry::WaterFound { monitor: "south".to_owned(), left_ms: 40_000 };
    assert!(found.records.iter().any(|it| it.entry == left), "{found:?}");
    assert!(of(&hall.wait(39_999), "Close south").is_empty());
    let all = hall.wait(3001);
    assert_eq!(of(&all, "Close south").len(), 4, "until it is closed: {all:?}");
    // A person takes it meanwhile, and leaves it on.
    let mut hall = restarted(&running, alone);
    hall.monitor("south", OPEN);
    hall.monitor("south", MonitorReport { authority: Authority::Person, ..OPEN });
    assert!(of(&hall.wait(30_000), "Close south").is_empty());
    hall.monitor("south", OPEN);
    let all = hall.wait(10_000);
    assert_eq!(of(&all, "Close south"), ["Close south"], "{all:?}");
    // Its end was ordered before, and was not confirmed.
    running.hand(abort());
    let mut hall = restarted(&running, alone);
    assert_eq!(of_orders(&orders(&hall.monitor("south", OPEN)), "Close south").len(), 1);
    hall.wait(500);
    hall.monitor("south", SHUT);
    hall.wait(1000);
    let stored = hall.site.persisted();
    assert!(!stored.monitors.contains_key("south"), "it is over: {stored:?}");
    // Without any such water what runs there is no business of the zones.
    let mut hall = restarted(&hall, alone);
    assert!(of_orders(&orders(&hall.monitor("south", OPEN)), "Close").is_empty());
}
