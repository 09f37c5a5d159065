//! Sequences in which unwanted water came, or needed water went.

use super::*;

pub const OPEN: MonitorReport = MonitorReport {
    reachable: true,
    authority: Authority::Free,
    lockout: false,
    valve: Valve::Open,
    extinguishing: false,
    failure: false,
};
pub const SHUT: MonitorReport = MonitorReport { valve: Valve::Closed, ..OPEN };

pub fn of<'a>(all: &'a [(u64, String)], beginning: &str) -> Vec<&'a str> {
    all.iter().map(|it| it.1.as_str()).filter(|it| it.starts_with(beginning)).collect()
}

/// After an abort a person opens the valve; what follows at once.
fn opened_by_person() -> (Hall, Reaction) {
    let mut hall = Hall::new();
    hall.hand(Hand::Abort { zone: zone() });
    hall.wait(3000);
    let person = MonitorReport { authority: Authority::Person, ..SHUT };
    hall.monitor("north", person);
    let opened = hall.monitor("north", MonitorReport { valve: Valve::Open, ..person });
    (hall, opened)
}

/// A person at the monitor: an abort of before, the end of automatic water and a released button take neither
/// pumps nor valve.
#[test]
fn water_of_a_person_keeps_its_pumps() {
    let (mut hall, opened) = opened_by_person();
    assert_eq!(orders(&opened), ["Valve zone-valve on", "Pump p1 on"]);
    // The button is released, and no client is in control any more.
    let left = hall.monitor("north", OPEN);
    assert!(orders(&left).is_empty(), "{left:?}");
    let later = hall.wait(300_000);
    assert!(of(&later, "Close").is_empty(), "{later:?}");
    assert!(!later.iter().any(|(_, order)| order.ends_with("off")), "{later:?}");
    // A no that comes now ends it.
    assert!(orders(&hall.hand(Hand::Abort { zone: zone() })).contains(&"Close north".to_owned()));
    // Taken over from votes: pumps go on when the greatest duration has passed.
    let mut hall = Hall::new();
    hall.extinguishes();
    hall.monitor("north", MonitorReport { authority: Authority::Person, ..OPEN });
    let end = hall.wait(70_000);
    assert!(of(&end, "Close north").is_empty(), "{end:?}");
    assert!(!end.iter().any(|(_, order)| order.ends_with("off")), "{end:?}");
    assert_eq!(hall.phase(), Phase::Ended(Why::Duration));
}

#[test]
fn a_stop_that_stays_pressed_keeps_everything_back() {
    let mut hall = Hall::new();
    hall.press("stop", true);
    hall.fire();
    let reset = hall.hand(Hand::Reset(Scope::Site));
    assert_eq!(refusal(&reset), Some(Refusal::StillPressed));
    let by_hand = hall.hand(Hand::Release { zone: zone() });
    assert_eq!(refusal(&by_hand), Some(Refusal::StillPressed));
    assert!(of(&hall.wait(400_000), "Engage").is_empty(), "nor does it lapse");
    assert!(hall.site.state().zones[0].not_released.contains(&NotReleased::StopPressed));
    hall.press("stop", false);
    hall.wait(1000);
    hall.hand(Hand::Reset(Scope::Site));
    assert_eq!(of(&hall.wait(20_000), "Engage").len(), 2);
}

/// Locked out at the monitor while it worked: its key does not open it again.
#[test]
fn a_monitor_locked_out_during_its_work_needs_a_reset() {
    let mut hall = Hall::new();
    hall.extinguishes();
    let locked = hall.monitor("north", MonitorReport { lockout: true, ..OPEN });
    assert_eq!(orders(&locked), ["Close north"]);
    hall.wait(1000);
    hall.monitor("north", SHUT);
    let later = hall.wait(40_000);
    assert!(of(&later, "Engage north").is_empty(), "{later:?}");
    // Without work there is nothing to refuse.
    let mut hall = Hall::new();
    hall.monitor("north", MonitorReport { lockout: true, ..SHUT });
    hall.monitor("north", SHUT);
    hall.fire();
    assert_eq!(of(&hall.wait(15_000), "Engage north").len(), 1);
}

#[test]
fn water_that_was_closed_unseen_does_not_come_back_at_once() {
    let mut hall = Hall::new();
    hall.extinguishes();
    hall.wait(40_000);
    hall.monitor("north", SHUT);
    let within = i64::from(Hall::within_s()) * 1000;
    let early = hall.wait(u64::try_from(within - 1).unwrap().min(19_000));
    assert!(of(&early, "Engage north").is_empty(), "{early:?}");
}

#[test]
fn a_valve_that_only_moves_has_not_opened() {
    let mut hall = Hall::with(|config| config.zones[0].water_max_s = 600);
    hall.fire();
    hall.wait(15_000);
    hall.monitors(Valve::Moving);
    let later = hall.wait(u64::from(Hall::within_s()) * 1000);
    assert!(hall.has(Trouble::MonitorIdle, true));
    assert_eq!(of(&later, "Engage north").len(), 1, "{later:?}");
}

#[test]
fn a_pump_that_is_kept_off_is_replaced_and_none_is_a_trouble() {
    let mut hall = Hall::new();
    let keep_off = |pump: &str| Hand::Pump { pump: pump.to_owned(), on: false };
    hall.hand(keep_off("p1"));
    hall.hand(Hand::Release { zone: zone() });
    let all = hall.wait(10_000);
    assert_eq!(of(&all, "Pump"), ["Pump p2 on", "Pump p3 on"], "{all:?}");
    assert!(!hall.has(Trouble::NoPressure, true));
    let mut hall = Hall::new();
    for pump in ["p1", "p2", "p3"] {
        hall.hand(keep_off(pump));
    }
    hall.hand(Hand::Release { zone: zone() });
    assert!(hall.has(Trouble::NoPressure, true));
}

/// A broken contact of the valve does not make the machine close what a person opens.
#[test]
fn a_close_without_an_end_gives_way_to_people_and_to_the_next_fire() {
    let mut hall = Hall::new();
    let between = MonitorReport { valve: Valve::Moving, ..OPEN };
    hall.extinguishes();
    hall.hand(Hand::Abort { zone: zone() });
    hall.monitor("north", between);
    assert!(!of(&hall.wait(5000), "Close north").is_empty());
    let person = MonitorReport { authority: Authority::Person, ..between };
    hall.monitor("north", person);
    assert!(!of(&hall.wait(3000), "Close north").is_empty(), "taken, and not opened");
    hall.monitor("north", MonitorReport { valve: Valve::Opening, ..person });
    hall.monitor("north", MonitorReport { valve: Valve::Open, ..person });
    assert!(of(&hall.wait(5000), "Close north").is_empty());
    // The next fire, ten seconds after a Close whose end was never reported.
    let mut hall = Hall::new();
    hall.extinguishes();
    hall.sees("flame", Signal::Quiet);
    hall.sees("heat", Signal::Quiet);
    hall.wait(31_000);
    hall.monitor("north", between);
    hall.wait(20_000);
    hall.fire();
    assert_eq!(of(&hall.wait(16_000), "Engage north").len(), 1);
}

/// A valve takes seconds to open: a Close of before is not sent into what a person has started meanwhile.
#[test]
fn a_person_who_begins_to_open_is_stronger_than_a_close_of_before() {
    let person = MonitorReport { authority: Authority::Person, ..SHUT };
    let opening = MonitorReport { valve: Valve::Opening, ..person };
    let aborted = || {
        let mut hall = Hall::new();
        hall.extinguishes();
        hall.hand(Hand::Abort { zone: zone() });
        hall
    };
    for before in [Valve::Closed, Valve::Moving] {
        let mut hall = aborted();
        hall.monitor("north", MonitorReport { valve: before, ..OPEN });
        hall.wait(300);
        hall.monitor("north", MonitorReport { valve: before, ..person });
        hall.monitor("north", opening);
        let all = hall.wait(9000);
        assert!(of(&all, "Close north").is_empty(), "{before:?} {all:?}");
        hall.monitor("north", MonitorReport { valve: Valve::Open, ..person });
        assert!(of(&hall.wait(5000), "Close north").is_empty(), "{before:?}");
        // A no that comes now ends it.
        let no = hall.hand(Hand::Abort { zone: zone() });
        assert!(orders(&no).contains(&"Close north".to_owned()), "{before:?}");
    }
    // What opened before the person took it is ours, and so is what opens in no hands.
    let mut hall = aborted();
    hall.monitor("north", MonitorReport { authority: Authority::Free, ..opening });
    hall.monitor("north", opening);
    assert!(!of(&hall.wait(3000), "Close north").is_empty());
    // Lockout is stronger.
    let mut hall = aborted();
    hall.monitor("north", MonitorReport { lockout: true, ..person });
    hall.monitor("north", MonitorReport { lockout: true, ..opening });
    assert!(!of(&hall.wait(3000), "Close north").is_empty());
}

#[test]
fn who_is_blind_does_not_say_that_the_fire_is_out() {
    let mut hall = Hall::with(|config| config.zones[0].water_max_s = 600);
    hall.extinguishes();
    hall.sees("heat", Signal::Quiet);
    let (detector, signal) = ("flame".to_owned(), Signal::Quiet);
    let blind = Event::Detector { detector, signal, condition: Condition::Fault };
    hall.event(blind);
    assert!(of(&hall.wait(100_000), "Close").is_empty());
    hall.sees("flame", Signal::Quiet);
    assert!(!of(&hall.wait(31_000), "Close").is_empty());
}

#[test]
fn what_was_in_alarm_under_lockout_or_in_a_test_does_not_release_by_itself() {
    let mut hall = Hall::new();
    hall.press("key", true);
    hall.wait(1000);
    hall.fire();
    hall.press("key", false);
    let later = hall.wait(60_000);
    assert!(of(&later, "Engage").is_empty(), "{later:?}");
    assert_eq!(hall.phase(), Phase::Ended(Why::Lockout));
    assert!(orders(&hall.hand(Hand::Release { zone: zone() }))[0].starts_with("Engage"));
    let mut hall = Hall::new();
    hall.hand(Hand::Mode { zone: zone(), mode: Mode::TestDry, for_s: Some(60) });
    hall.fire();
    let later = hall.wait(120_000);
    assert!(of(&later, "Engage").is_empty(), "{later:?}");
    assert_eq!(hall.phase(), Phase::Ended(Why::TestOver));
}

/// The key is on, and so it counts after a restart, until its line is read again.
#[test]
fn contacts_that_say_no_last_over_a_restart() {
    let mut hall = Hall::new();
    hall.press("key", true);
    hall.press("stop", true);
    let json = serde_json::to_string(&hall.site.persisted()).unwrap();
    let stored = serde_json::from_str(&json).unwrap();
    let (site, _) = Site::new(toml::from_str(HALL).unwrap(), 0, Some(&stored)).unwrap();
    let mut hall = Hall { site, now: 0 };
    hall.sees("flame", Signal::Quiet);
    hall.sees("heat", Signal::Quiet);
    hall.monitors(Valve::Closed);
    hall.fire();
    assert!(of(&hall.wait(60_000), "Engage").is_empty() && hall.site.state().lockout);
    hall.press("key", false);
    hall.press("stop", false);
    hall.wait(1000);
    assert!(!hall.site.state().lockout);
}

#[test]
fn kinds_that_cannot_be_met_any_more_are_shown_as_not_ready() {
    let mut hall = Hall::with(|config| {
        let mut third = config.detectors[0].clone();
        third.id = "flame2".to_owned();
        config.detectors.push(third);
        config.zones[0].votes.of = 3;
        config.zones[0].when_failed =
            toml::from_str::<std::collections::BTreeMap<String, Vec<_>>>("it = [\"2oo2\"]")
                .unwrap()
                .remove("it")
                .unwrap();
    });
    hall.sees("flame2", Signal::Quiet);
    assert!(hall.site.state().zones[0].ready);
    let (detector, signal) = ("heat".to_owned(), Signal::Quiet);
    hall.event(Event::Detector { detector, signal, condition: Condition::Fault });
    let state = hall.site.state();
    assert_eq!((state.zones[0].ready, state.zones[0].need), (false, None));
}

#[test]
fn a_line_that_is_well_again_gets_its_command_again() {
    let mut hall = Hall::with(|config| config.outputs[0].feedback = false);
    hall.hand(Hand::Release { zone: zone() });
    let path = |path: &str, fault| Event::Path { path: path.to_owned(), fault };
    for (line, order) in [("zone-valve", "Valve zone-valve on"), ("p1", "Pump p1 on")] {
        assert!(orders(&hall.event(path(line, None))).is_empty());
        hall.event(path(line, Some(PathFault::Lost)));
        assert_eq!(orders(&hall.event(path(line, None))), [order]);
    }
}

/// Taken over from votes before a restart: it still ends in its time when the person has left, and has its pumps
/// until then.
#[test]
fn water_taken_over_before_a_restart_ends_in_its_time_and_keeps_its_pumps() {
    let mut hall = Hall::new();
    hall.extinguishes();
    let person = MonitorReport { authority: Authority::Person, ..OPEN };
    hall.monitor("north", person);
    hall.wait(20_000);
    let stored = hall.site.persisted();
    let (site, _) = Site::new(toml::from_str(HALL).unwrap(), 0, Some(&stored)).unwrap();
    let mut hall = Hall { site, now: 0 };
    let taken = hall.monitor("north", person);
    assert!(orders(&taken).contains(&"Pump p1 on".to_owned()), "{taken:?}");
    hall.wait(10_000);
    let left = hall.monitor("north", OPEN);
    assert!(orders(&left).is_empty(), "{left:?}");
    assert_eq!(hall.site.state().monitors[0].found_left_ms, Some(30_000));
    let flows = hall.wait(29_999);
    assert!(!flows.iter().any(|(_, order)| order.ends_with("off")), "{flows:?}");
    let end = hall.wait(10_000);
    assert_eq!(end[0], (40_000, "Close north".to_owned()));
    assert_eq!(of(&end, "Pump p1"), ["Pump p1 off"]);
}

/// A test keeps votes dry, never a person: the release ends the test, also where votes have released dry before,
/// and from a station as from a console.
#[test]
fn a_release_by_hand_is_wet_in_a_test_too() {
    for votes_before in [false, true] {
        for station in [false, true] {
            let mut hall = Hall::new();
            hall.hand(Hand::Mode { zone: zone(), mode: Mode::TestDry, for_s: Some(600) });
            if votes_before {
                hall.fire();
                hall.wait(20_000);
                assert_eq!(hall.phase(), Phase::Released { automatic: true, wet: false });
            }
            let released = if station {
                hall.press("station", false);
                hall.press("station", true);
                hall.now += 50;
                hall.site.step(hall.now)
            } else {
                hall.hand(Hand::Release { zone: zone() })
            };
            let all = orders(&released);
            assert!(all.contains(&"Engage north None".to_owned()), "{votes_before} {all:?}");
            assert_eq!(hall.phase(), Phase::Released { automatic: false, wet: true });
            let over = Entry::Mode { zone: zone(), mode: Mode::Automatic, returns_in_ms: None };
            assert!(released.records.iter().any(|it| it.entry == over), "{released:?}");
            // The time of the test ends nothing any more.
            hall.monitors(Valve::Open);
            assert!(of(&hall.wait(700_000), "Close").is_empty());
        }
    }
    // What is stronger than a hand stays so.
    let mut hall = Hall::new();
    hall.hand(Hand::Mode { zone: zone(), mode: Mode::TestDry, for_s: None });
    hall.hand(Hand::Lockout { on: true });
    let refused = hall.hand(Hand::Release { zone: zone() });
    assert_eq!(refusal(&refused), Some(Refusal::Lockout));
    assert_eq!(hall.site.state().zones[0].mode, Mode::TestDry);
}

/// A hold that was pressed before the alarm is a stuck contact, which would delay each fire.
#[test]
fn a_stuck_hold_is_a_trouble_and_holds_nothing() {
    let mut hall = Hall::new();
    hall.press("hold", true);
    hall.wait(1000);
    hall.fire();
    assert!(!hall.has(Trouble::ContactStuck, true), "nothing is held yet");
    let all = hall.wait(15_000);
    assert!(hall.has(Trouble::ContactStuck, true));
    assert!(all.contains(&(16_000, "Engage north Some(60000)".to_owned())), "{all:?}");
    hall.press("hold", false);
    hall.wait(1000);
    assert!(hall.has(Trouble::ContactStuck, false));
    // Pressed for longer than a countdown takes that is held it is a trouble without any fire too.
    let mut hall = Hall::new();
    hall.press("hold", true);
    hall.wait(34_999);
    assert!(!hall.has(Trouble::ContactStuck, true));
    hall.wait(1);
    assert!(hall.has(Trouble::ContactStuck, true));
    // One detector is in alarm: who presses then means it.
    let mut hall = Hall::new();
    hall.sees("flame", Signal::Alarm);
    hall.wait(1000);
    hall.press("hold", true);
    hall.wait(1000);
    hall.sees("heat", Signal::Alarm);
    hall.wait(6000);
    assert_eq!(hall.phase(), Phase::Held);
    assert!(!hall.has(Trouble::ContactStuck, true));
    // A person at a console holds, whatever the contact does.
    let mut hall = Hall::new();
    hall.press("hold", true);
    hall.wait(1000);
    hall.fire();
    hall.hand(Hand::Hold { zone: zone(), on: true });
    hall.wait(6000);
    assert_eq!(hall.phase(), Phase::Held);
}

#[test]
fn fewer_jets_than_wanted_is_a_trouble() {
    let mut hall = Hall::with(|config| config.zones[0].jets = Some(2));
    hall.hand(Hand::Release { zone: zone() });
    hall.monitors(Valve::Open);
    assert!(!hall.has(Trouble::FewJets, true));
    hall.monitor("north", MonitorReport { reachable: false, ..OPEN });
    assert!(hall.has(Trouble::FewJets, true) && !hall.has(Trouble::NoMonitor, true));
    hall.monitor("south", MonitorReport { reachable: false, ..OPEN });
    assert!(hall.has(Trouble::NoMonitor, true) && !hall.has(Trouble::FewJets, true));
    hall.monitors(Valve::Open);
    assert!(hall.has(Trouble::FewJets, false));
    // Without `jets`, as with enough of them, there is none.
    let mut hall = Hall::with(|config| config.zones[0].jets = Some(1));
    hall.hand(Hand::Release { zone: zone() });
    hall.monitor("north", MonitorReport { reachable: false, ..OPEN });
    assert!(!hall.has(Trouble::FewJets, true));
}

#[test]
fn a_zone_without_its_pumps_valve_or_supply_is_not_ready() {
    let ready = |hall: &Hall| hall.site.state().zones[0].ready;
    let path = |hall: &mut Hall, id: &str, fault: bool| {
        let fault = fault.then_some(PathFault::Open);
        hall.event(Event::Path { path: id.to_owned(), fault });
    };
    let mut hall = Hall::with(|config| config.paths = vec!["main".to_owned()]);
    assert!(ready(&hall));
    for id in ["p1", "zone-valve", "main"] {
        if id == "p1" {
            // The pump in reserve takes its place.
            path(&mut hall, id, true);
            assert!(ready(&hall), "p3 is there");
            path(&mut hall, "p2", true);
            assert!(!ready(&hall), "and no other");
            path(&mut hall, "p2", false);
        } else {
            path(&mut hall, id, true);
            assert!(!ready(&hall), "{id}");
        }
        path(&mut hall, id, false);
        assert!(ready(&hall), "{id} is well again");
    }
    for (pump, is_ready) in [("p1", true), ("p2", false)] {
        hall.hand(Hand::Pump { pump: pump.to_owned(), on: false });
        assert_eq!(ready(&hall), is_ready, "{pump} is kept off");
    }
    hall.wait(2000);
    hall.hand(Hand::Reset(Scope::Site));
    assert!(ready(&hall));
    // One that needs no pumps does not care.
    let mut hall = Hall::with(|config| config.zones[0].pumps = false);
    for pump in ["p1", "p2", "p3"] {
        hall.hand(Hand::Pump { pump: pump.to_owned(), on: false });
    }
    assert!(ready(&hall));
}

/// A valve that jams while it closes and falls back to open was not opened by who holds the monitor.
#[test]
fn a_valve_that_jams_while_it_closes_was_opened_by_no_person() {
    for taken_later in [false, true] {
        let mut hall = Hall::new();
        let person = MonitorReport { authority: Authority::Person, ..OPEN };
        let first = if taken_later { OPEN } else { person };
        hall.monitor("north", first);
        hall.hand(Hand::Stop(Scope::Site));
        hall.monitor("north", MonitorReport { valve: Valve::Moving, ..first });
        hall.monitor("north", MonitorReport { valve: Valve::Moving, ..person });
        let jammed = hall.monitor("north", person);
        assert!(orders(&jammed).is_empty(), "{jammed:?}");
        let all = hall.wait(3000);
        assert_eq!(of(&all, "Close north").len(), 3, "{all:?}");
        assert!(of(&all, "Pump p1 on").is_empty(), "{all:?}");
        hall.wait(7000);
        assert!(hall.has(Trouble::NotClosed, true));
    }
    // Closed since, and opened within the second in which that report does not count yet.
    let mut hall = Hall::new();
    let person = MonitorReport { authority: Authority::Person, ..OPEN };
    hall.monitor("north", person);
    hall.hand(Hand::Stop(Scope::Site));
    for valve in [Valve::Closed, Valve::Moving, Valve::Open] {
        hall.monitor("north", MonitorReport { valve, ..person });
    }
    assert!(of(&hall.wait(3000), "Close north").is_empty());
}

/// A site with a second zone that shares the monitor `north`.
fn share(config: &mut Config) {
    config.zones[0].monitors.truncate(1);
    let mut second = config.zones[0].clone();
    second.id = "yard".to_owned();
    (second.valve, second.test_outlet) = (None, None);
    config.zones.push(second);
    let detectors = config.detectors.clone();
    config.detectors.extend(detectors.into_iter().map(|mut it| {
        it.id = format!("{}-yard", it.id);
        it.zones = vec!["yard".to_owned()];
        it
    }));
}

fn shared() -> Hall {
    Hall::with(share)
}

/// It burns in the second zone, and the countdown passes.
fn burns_in_the_yard(hall: &mut Hall) -> Vec<(u64, String)> {
    for signal in [Signal::Quiet, Signal::Alarm] {
        hall.sees("flame-yard", signal);
        hall.sees("heat-yard", signal);
    }
    hall.wait(15_000)
}

/// Who resets one zone does not open a monitor that was closed in the other one.
#[test]
fn the_reset_of_a_zone_does_not_open_for_another() {
    let reset = |scope| Hand::Reset(scope);
    let hall_alone = || Scope::Zone(zone());
    let north = || Scope::Monitor("north".to_owned());
    let refused = |hall: &Hall| hall.site.state().monitors[0].withheld == Some(Withheld::Refused);
    let mut hall = shared();
    hall.hand(Hand::Release { zone: "yard".to_owned() });
    hall.monitor("north", OPEN);
    hall.hand(Hand::Close(north()));
    hall.wait(500);
    hall.monitor("north", SHUT);
    hall.wait(2000);
    assert!(orders(&hall.hand(reset(hall_alone()))).is_empty());
    assert!(of(&hall.wait(5000), "Engage").is_empty() && refused(&hall));
    assert_eq!(orders(&hall.hand(reset(north()))), ["Engage north None"]);
    // Votes of the other zone count down: the same.
    let mut hall = shared();
    hall.hand(Hand::Close(north()));
    hall.wait(2000);
    burns_in_the_yard(&mut hall);
    hall.hand(Hand::Abort { zone: "yard".to_owned() });
    hall.wait(2000);
    hall.hand(reset(Scope::Zone("yard".to_owned())));
    assert!(!refused(&hall), "its own zone counts");
    hall.hand(Hand::Close(north()));
    hall.hand(reset(hall_alone()));
    assert!(refused(&hall), "the yard counts down");
    // Nothing is under way in the other zone.
    let mut hall = shared();
    hall.hand(Hand::Close(north()));
    hall.wait(2000);
    hall.hand(reset(hall_alone()));
    assert!(!refused(&hall));
}

/// A person who releases a zone gets the monitors that the release takes; the Close of the others goes on.
#[test]
fn a_release_by_hand_ends_the_close_of_none_but_its_monitors() {
    let lost = MonitorReport { reachable: false, ..OPEN };
    let mut hall = Hall::with(|config| config.zones[0].jets = Some(1));
    hall.hand(Hand::Release { zone: zone() });
    hall.monitor("north", OPEN);
    hall.monitor("north", lost);
    hall.hand(Hand::Stop(Scope::Zone(zone())));
    hall.wait(2000);
    let released = orders(&hall.hand(Hand::Release { zone: zone() }));
    assert!(released.contains(&"Engage south None".to_owned()), "{released:?}");
    hall.monitor("south", OPEN);
    assert_eq!(of(&hall.wait(2000), "Close north").len(), 2);
    hall.monitor("north", OPEN);
    let all = hall.wait(12_000);
    assert_eq!(of(&all, "Close north").len(), 12, "{all:?}");
    assert!(of(&all, "Engage").is_empty() && hall.has(Trouble::NotClosed, true));
    hall.monitor("north", SHUT);
    hall.wait(1000);
    assert!(of(&hall.wait(5000), "Close").is_empty());
    // One that the zone takes opens at once, though its Close was not confirmed; a Close that comes later counts.
    let mut hall = Hall::with(|config| config.zones[0].jets = Some(1));
    hall.hand(Hand::Release { zone: zone() });
    hall.monitor("north", OPEN);
    hall.hand(Hand::Stop(Scope::Zone(zone())));
    hall.wait(2000);
    let released = orders(&hall.hand(Hand::Release { zone: zone() }));
    assert!(released.contains(&"Engage north None".to_owned()), "{released:?}");
    hall.hand(Hand::Close(Scope::Monitor("north".to_owned())));
    let all = hall.wait(3000);
    assert!(of(&all, "Engage north").is_empty() && of(&all, "Close north").len() == 3, "{all:?}");
}

/// The Close of another zone, after a release by hand, is not taken back by that release.
#[test]
fn a_close_that_comes_after_a_release_by_hand_goes_on() {
    let mut hall = shared();
    burns_in_the_yard(&mut hall);
    hall.monitor("north", OPEN);
    hall.sees("heat-yard", Signal::Quiet);
    hall.sees("flame-yard", Signal::Quiet);
    // The hall takes it; then its own water ends, and the yard may not have it before it is closed.
    hall.hand(Hand::Release { zone: zone() });
    hall.hand(Hand::Release { zone: "yard".to_owned() });
    hall.monitor("north", OPEN);
    let no = orders(&hall.hand(Hand::Abort { zone: zone() }));
    assert!(
        no.contains(&"Close north".to_owned()) && of_orders(&no, "Engage").is_empty(),
        "{no:?}"
    );
    let all = hall.wait(3000);
    assert!(of(&all, "Engage north").is_empty() && of(&all, "Close north").len() == 3, "{all:?}");
}

pub fn of_orders<'a>(all: &'a [String], beginning: &str) -> Vec<&'a str> {
    all.iter().map(String::as_str).filter(|it| it.starts_with(beginning)).collect()
}

/// The site after a restart, with what was stored; it was written as JSON.
pub fn restarted(hall: &Hall, change: fn(&mut Config)) -> Hall {
    let mut config: Config = toml::from_str(HALL).unwrap();
    change(&mut config);
    let json = serde_json::to_string(&hall.site.persisted()).unwrap();
    let stored = serde_json::from_str(&json).unwrap();
    let (site, reaction) = Site::new(config, 0, Some(&stored)).unwrap();
    assert!(orders(&reaction).is_empty(), "{reaction:?}");
    Hall { site, now: 0 }
}

/// A no of one zone does not end, after a restart, what another one has in water.
#[test]
fn found_water_of_a_zone_is_not_ended_by_the_no_of_another() {
    let mut hall = shared();
    hall.hand(Hand::Abort { zone: zone() });
    hall.wait(2000);
    let opened = burns_in_the_yard(&mut hall);
    assert_eq!(of(&opened, "Engage north").len(), 1, "{opened:?}");
    hall.monitor("north", OPEN);
    hall.wait(20_000);
    // Twice, the second time before it was heard of.
    let mut hall = restarted(&restarted(&hall, share), share);
    let found = hall.monitor("north", OPEN);
    let left = Entry::WaterFound { monitor: "north".to_owned(), left_ms: 40_000 };
    assert!(found.records.iter().any(|it| it.entry == left), "{found:?}");
    assert!(of_orders(&orders(&found), "Close").is_empty(), "{found:?}");
    // A person takes it for a while.
    hall.monitor("north", MonitorReport { authority: Authority::Person, ..OPEN });
    hall.wait(5000);
    assert!(of_orders(&orders(&hall.monitor("north", OPEN)), "Close").is_empty());
    let mut hall = restarted(&hall, share);
    hall.monitor("north", OPEN);
    assert!(of(&hall.wait(34_999), "Close").is_empty());
    assert_eq!(of(&hall.wait(1), "Close north").len(), 1);
    // The no of its own zone ends it, as does one of any where no zone is stored.
    for change in ["ended", "zone"] {
        let mut hall = shared();
        hall.hand(Hand::Abort { zone: zone() });
        hall.wait(2000);
        burns_in_the_yard(&mut hall);
        hall.monitor("north", OPEN);
        let mut stored = serde_json::to_value(hall.site.persisted()).unwrap();
        if change == "ended" {
            stored["zones"]["yard"]["ended"] = "abort".into();
        } else {
            stored["monitors"]["north"].as_object_mut().unwrap().remove("zone").unwrap();
        }
        let stored = serde_json::from_value(stored).unwrap();
        let mut config: Config = toml::from_str(HALL).unwrap();
        share(&mut config);
        let (site, _) = Site::new(config, 0, Some(&stored)).unwrap();
        let found = Hall { site, now: 0 }.monitor("north", OPEN);
        assert_eq!(of_orders(&orders(&found), "Close").len(), 1, "{change}: {found:?}");
    }
}

/// What a person began after a no, and left on, goes on after a restart until a hand ends it.
#[test]
fn water_that_a_person_left_on_outlasts_a_restart() {
    let (mut hall, opened) = opened_by_person();
    assert!(opened.persist);
    hall.monitor("north", OPEN);
    let closed = restarted(&hall, |_| {});
    let mut hall = restarted(&hall, |_| {});
    let found = orders(&hall.monitor("north", OPEN));
    assert!(of_orders(&found, "Close").is_empty(), "{found:?}");
    assert!(of(&hall.wait(300_000), "Close").is_empty());
    assert!(orders(&hall.hand(Hand::Abort { zone: zone() })).contains(&"Close north".to_owned()));
    // Closed meanwhile, it is a person's no longer.
    let mut hall = restarted(&closed, |_| {});
    hall.monitor("north", SHUT);
    assert!(of_orders(&orders(&hall.monitor("north", OPEN)), "Close").len() == 1);
}

/// The end of water is not forgotten by a restart: it does not run for its whole time once more.
#[test]
fn water_whose_end_was_ordered_ends_after_a_restart() {
    let lost = MonitorReport { reachable: false, ..OPEN };
    let mut hall = Hall::new();
    hall.extinguishes();
    hall.wait(20_000);
    let mut hall = restarted(&hall, |_| {});
    hall.monitors(Valve::Open);
    hall.monitor("north", lost);
    assert_eq!(of(&hall.wait(40_000), "Close north").len(), 1);
    for restarts in [1, 2] {
        let mut again = restarted(&hall, |_| {});
        for _ in 1..restarts {
            again = restarted(&again, |_| {});
        }
        again.wait(5000);
        let found = orders(&again.monitor("north", OPEN));
        assert_eq!(of_orders(&found, "Close north").len(), 1, "{found:?}");
        assert_eq!(of(&again.wait(2000), "Close north").len(), 2);
        // A person's, meanwhile: not ours.
        let mut again = restarted(&hall, |_| {});
        again.monitor("north", MonitorReport { authority: Authority::Person, ..OPEN });
        again.monitor("north", OPEN);
        assert!(of(&again.wait(5000), "Close north").is_empty());
    }
}

/// Both pumps report through one contact: the pressure of the standby pump says nothing of the one that failed.
#[test]
fn a_standby_pump_stays_although_the_common_pressure_is_there_again() {
    let common = || {
        let mut hall = Hall::with(|config| {
            config.run_on_s = 0;
            config.pumps[2].pressure = Some("gauge".to_owned());
        });
        hall.hand(Hand::Release { zone: zone() });
        let all = hall.wait(4000);
        assert_eq!(of(&all, "Pump p3"), ["Pump p3 on"], "{all:?}");
        hall.press("gauge", true);
        hall
    };
    let mut hall = common();
    let all = hall.wait(30_000);
    assert!(of(&all, "Pump").is_empty(), "{all:?}");
    assert!(!hall.site.state().pumps[0].failed);
    // It ends with the water, and the next water begins with the first pump again.
    let ended = orders(&hall.hand(Hand::Abort { zone: zone() }));
    assert!(ended.contains(&"Pump p3 off".to_owned()), "{ended:?}");
    hall.wait(2000);
    hall.hand(Hand::Release { zone: zone() });
    assert_eq!(of(&hall.wait(30_000), "Pump"), ["Pump p2 on"]);
    // One that waits for its turn does not start when the pressure comes first.
    let mut hall = Hall::with(|config| {
        config.pumps[2].pressure = Some("gauge".to_owned());
        config.pumps[2].start_delay_s = 10;
    });
    hall.hand(Hand::Release { zone: zone() });
    hall.wait(5000);
    hall.press("gauge", true);
    assert!(of(&hall.wait(30_000), "Pump p3").is_empty());
    // A person's hand is stronger.
    let mut hall = common();
    hall.hand(Hand::Pump { pump: "p3".to_owned(), on: false });
    assert!(of(&hall.wait(30_000), "Pump p3 on").is_empty());
}

/// A pump that runs for no water any more stops after its time, whatever it was started for.
#[test]
fn a_pump_that_is_not_asked_for_any_more_stops_after_its_time() {
    let mut hall = Hall::new();
    hall.press("gauge", true);
    hall.hand(Hand::Pump { pump: "p1".to_owned(), on: true });
    hall.wait(20_000);
    hall.hand(Hand::Reset(Scope::Site));
    let since = hall.now;
    assert_eq!(hall.wait(6000), [(since + 5000, "Pump p1 off".to_owned())]);
    // Water of a person goes on, and needs no standby pump any more.
    let mut hall = Hall::new();
    let person = MonitorReport { authority: Authority::Person, ..OPEN };
    hall.monitor("north", person);
    hall.wait(10_000);
    hall.press("gauge", true);
    hall.wait(1000);
    hall.hand(Hand::Reset(Scope::Site));
    let since = hall.now;
    assert_eq!(of(&hall.wait(4900), "Pump"), Vec::<&str>::new());
    let all = hall.wait(6000);
    assert!(all.contains(&(since + 5000, "Pump p3 off".to_owned())), "{all:?}");
    assert_eq!(of(&all, "Pump"), ["Pump p3 off"]);
    // Asked for again before it stops, it goes on, and has its time again afterwards.
    let mut hall = Hall::new();
    hall.press("gauge", true);
    hall.monitor("north", person);
    hall.wait(5000);
    hall.monitor("north", MonitorReport { valve: Valve::Closed, ..person });
    hall.wait(4000);
    hall.monitor("north", person);
    assert!(of(&hall.wait(20_000), "Pump").is_empty());
    hall.monitor("north", MonitorReport { valve: Valve::Closed, ..person });
    assert!(of(&hall.wait(4999), "Pump").is_empty());
    assert_eq!(of(&hall.wait(1), "Pump"), ["Pump p1 off", "Pump p2 off"]);
}

/// Water that was ordered, and opened when a person had just taken the monitor, is no person's after a restart.
#[test]
fn ordered_water_that_a_person_took_is_found_after_a_restart() {
    let mut hall = Hall::new();
    hall.hand(Hand::Release { zone: zone() });
    let person = MonitorReport { authority: Authority::Person, ..SHUT };
    hall.monitor("north", person);
    hall.monitor("north", MonitorReport { valve: Valve::Open, ..person });
    let mut hall = restarted(&hall, |_| {});
    assert!(orders(&hall.monitor("north", OPEN)).is_empty());
    assert_eq!(hall.site.state().monitors[0].found_left_ms, Some(60_000));
}
