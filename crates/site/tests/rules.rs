//! The rules one by one.

mod hands;
mod hazards;

use lafet_site::{
    Authority, Bypass, Condition, Config, Disablement, Entry, Event, Hand, Mode, MonitorReport,
    NotReleased, Order, PathFault, Phase, Reaction, Refusal, Scope, Signal, Site, Tone, Trouble,
    Unable, Valve, Voteless, Why, Withheld,
};

const HALL: &str = r#"
    monitors = ["north", "south"]
    paths = ["mains"]
    run_on_s = 5
    detector = [
        { id = "flame", kind = "flame", zones = ["hall"], silent_after_s = 3600 },
        { id = "heat", kind = "heat", zones = ["hall"], silent_after_s = 3600 },
    ]
    input = [
        { id = "station", kind = "release", zones = ["hall"] },
        { id = "hold", kind = "hold" },
        { id = "key", kind = "lockout" },
        { id = "stop", kind = "stop" },
        { id = "switch", kind = "manual_switch" },
        { id = "gauge", kind = "pressure" },
    ]
    output = [
        { id = "zone-valve", kind = "valve", feedback = true },
        { id = "outlet", kind = "valve" },
        { id = "horn", kind = "sounder" },
        { id = "trouble", kind = "trouble_lamp" },
    ]
    pump = [
        { id = "p1", pressure = "gauge", start_timeout_s = 4 },
        { id = "p2", start_delay_s = 2 },
        { id = "p3", standby = true },
    ]
    [[zone]]
    id = "hall"
    votes = "2oo2"
    kinds = 2
    coincidence_s = 5
    delay_s = 10
    hold_max_s = 20
    water_max_s = 60
    quiet_ends_s = 30
    return_after_s = 100
    monitors = ["north", "south"]
    valve = "zone-valve"
    test_outlet = "outlet"
"#;

struct Hall {
    site: Site,
    now: u64,
}

impl Hall {
    fn new() -> Self {
        Self::with(|_| {})
    }

    fn with(change: impl FnOnce(&mut Config)) -> Self {
        let mut config: Config = toml::from_str(HALL).unwrap();
        change(&mut config);
        let (site, reaction) = Site::new(config, 0, None).unwrap();
        assert!(orders(&reaction).is_empty(), "{reaction:?}");
        let mut hall = Self { site, now: 0 };
        hall.sees("flame", Signal::Quiet);
        hall.sees("heat", Signal::Quiet);
        hall.monitors(Valve::Closed);
        hall
    }

    /// The time in which a monitor has to act.
    fn within_s() -> u32 {
        toml::from_str::<Config>(HALL).unwrap().zones[0].act_within_s
    }

    fn event(&mut self, event: Event) -> Reaction {
        self.site.handle(self.now, &event)
    }

    fn sees(&mut self, detector: &str, signal: Signal) -> Reaction {
        let (detector, condition) = (detector.to_owned(), Condition::Ready);
        self.event(Event::Detector { detector, signal, condition })
    }

    fn monitor(&mut self, monitor: &str, report: MonitorReport) -> Reaction {
        self.event(Event::Monitor { monitor: monitor.to_owned(), report })
    }

    fn monitors(&mut self, valve: Valve) {
        for monitor in ["north", "south"] {
            self.monitor(monitor, MonitorReport { reachable: true, valve, ..Default::default() });
        }
    }

    fn press(&mut self, input: &str, pressed: bool) -> Reaction {
        self.event(Event::Contact { input: input.to_owned(), pressed })
    }

    fn hand(&mut self, order: Hand) -> Reaction {
        self.event(Event::Hand { by: "anna".to_owned(), order })
    }

    fn fire(&mut self) {
        self.sees("flame", Signal::Alarm);
        self.sees("heat", Signal::Alarm);
    }

    /// It burns, the countdown passes, and both monitors give water.
    fn extinguishes(&mut self) {
        self.fire();
        self.wait(15_000);
        self.monitors(Valve::Open);
    }

    /// Steps at every deadline.
    fn wait(&mut self, time_ms: u64) -> Vec<(u64, String)> {
        let end = self.now + time_ms;
        let mut all = Vec::new();
        for _ in 0..10_000 {
            let next = self.site.next_deadline().filter(|next| *next <= end);
            assert!(next.is_none_or(|next| next > self.now), "a deadline is in the past");
            self.now = next.unwrap_or(end);
            let reaction = self.site.step(self.now);
            all.extend(orders(&reaction).into_iter().map(|order| (self.now, order)));
            assert_eq!(self.site.step(self.now), Reaction::default(), "a second step does more");
            if next.is_none() {
                return all;
            }
        }
        panic!("no end of deadlines");
    }

    fn phase(&self) -> Phase {
        self.site.state().zones[0].phase
    }

    fn has(&self, trouble: Trouble, active: bool) -> bool {
        self.site.state().troubles.iter().any(|it| it.trouble == trouble && it.active == active)
    }
}

fn zone() -> String {
    "hall".to_owned()
}

fn on(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

fn orders(reaction: &Reaction) -> Vec<String> {
    let text = |order: &Order| match order {
        Order::Prepare { monitor, .. } => format!("Prepare {monitor}"),
        Order::Engage { monitor, water_max_ms, .. } => format!("Engage {monitor} {water_max_ms:?}"),
        Order::Close { monitor } => format!("Close {monitor}"),
        Order::Stop { monitor } => format!("Stop {monitor}"),
        Order::Pump { pump, on: it } => format!("Pump {pump} {}", on(*it)),
        Order::Valve { output, open } => format!("Valve {output} {}", on(*open)),
        Order::Sound { tone, .. } => format!("Sound {tone:?}"),
        Order::Lamp { lit, .. } => format!("Lamp {}", on(*lit)),
    };
    let shown = |order: &&Order| !matches!(order, Order::Sound { .. } | Order::Lamp { .. });
    reaction.commands.iter().map(|it| &it.order).filter(shown).map(text).collect()
}

fn refusal(reaction: &Reaction) -> Option<Refusal> {
    reaction.records.iter().find_map(|record| match record.entry {
        Entry::Refused { why, .. } | Entry::StationRefused { why, .. } => Some(why),
        _ => None,
    })
}

#[test]
fn votes_coincide_then_the_delay_then_water_with_its_causes() {
    let mut hall = Hall::new();
    let first = hall.sees("flame", Signal::Alarm);
    assert!(orders(&first).is_empty(), "one detector moves nothing");
    assert_eq!(hall.site.state().zones[0].not_released, [NotReleased::Votes { have: 1, need: 2 }]);
    let turned = hall.sees("heat", Signal::Alarm);
    assert_eq!(orders(&turned), ["Prepare north", "Prepare south"]);
    assert!(hall.wait(14_999).is_empty());
    assert_eq!(hall.phase(), Phase::Countdown);
    hall.now = 15_000;
    let reaction = hall.site.step(hall.now);
    let expected = [
        "Engage north Some(60000)",
        "Engage south Some(60000)",
        "Valve zone-valve on",
        "Pump p1 on",
    ];
    assert_eq!(orders(&reaction), expected);
    let engage = &reaction.commands[0];
    assert_eq!(engage.not_after_ms, Some(17_000));
    let cause = serde_json::to_string(&engage.cause).unwrap();
    for part in ["flame", "heat", "enough", "delay_ms", "release"] {
        assert!(cause.contains(part), "{part}: {cause}");
    }
    assert_eq!(hall.site.state().zones[0].reacted_in_ms, Some(0));
}

#[test]
fn votes_that_go_end_the_countdown() {
    let mut hall = Hall::new();
    hall.fire();
    hall.wait(10_000);
    hall.sees("heat", Signal::Quiet);
    hall.sees("heat", Signal::Alarm);
    assert!(hall.wait(14_999).is_empty());
    assert!(!hall.wait(1).is_empty());
}

#[test]
fn hold_is_limited_and_only_before_the_release() {
    let mut hall = Hall::new();
    hall.fire();
    hall.press("hold", true);
    hall.wait(6000);
    assert_eq!((hall.phase(), hall.site.state().tone), (Phase::Held, Tone::Held));
    hall.hand(Hand::Silence);
    assert_eq!(hall.site.state().tone, Tone::Held);
    assert!(hall.wait(5000 + 20_000 + 10_000 - 6000 - 1).is_empty());
    assert_eq!(hall.wait(1)[0].1, "Engage north Some(60000)");
    let late = hall.hand(Hand::Hold { zone: zone(), on: true });
    assert_eq!(refusal(&late), Some(Refusal::TooLate));
}

#[test]
fn close_is_repeated_until_it_is_reported_and_nothing_opens_again() {
    let mut hall = Hall::new();
    hall.extinguishes();
    let closed = hall.hand(Hand::Close(Scope::Zone(zone())));
    let valves = ["Valve zone-valve off", "Valve outlet off"];
    assert_eq!(orders(&closed), [&["Close north", "Close south"][..], &valves].concat());
    assert_eq!(closed.commands[0].not_after_ms, None);
    let again = hall.wait(1000);
    assert_eq!(again[0], (hall.now, "Close north".to_owned()));
    hall.monitors(Valve::Closed);
    hall.event(Event::Output { output: "zone-valve".to_owned(), on: false });
    hall.wait(1000);
    let rest = hall.wait(50_000);
    assert!(rest.iter().all(|(_, order)| order.starts_with("Pump") && order.ends_with("off")));
    assert_eq!(hall.phase(), Phase::Ended(Why::Close));
    // A late order that opens it after all.
    hall.monitors(Valve::Open);
    assert!(hall.site.state().monitors.iter().all(|it| it.closing));
}

#[test]
fn a_hand_releases_without_votes_and_loses_only_to_a_no_at_the_same_time() {
    let mut hall = Hall::new();
    hall.hand(Hand::Mode { zone: zone(), mode: Mode::Manual, for_s: None });
    let reaction = hall.hand(Hand::Release { zone: zone() });
    assert_eq!(orders(&reaction)[0], "Engage north None");
    hall.hand(Hand::Abort { zone: zone() });
    hall.now += 1999;
    let just = hall.hand(Hand::Release { zone: zone() });
    let opened = orders(&just).iter().any(|order| order.starts_with("Engage"));
    assert_eq!((refusal(&just), opened), (Some(Refusal::JustRefused), false));
    hall.now += 1;
    assert_eq!(orders(&hall.hand(Hand::Release { zone: zone() }))[0], "Engage north None");
    hall.press("key", true);
    hall.now += 5000;
    let locked = hall.hand(Hand::Release { zone: zone() });
    assert_eq!(refusal(&locked), Some(Refusal::Lockout));
    assert!(orders(&hall.hand(Hand::Pump { pump: "p1".to_owned(), on: true })).is_empty());
}

#[test]
fn a_bouncing_station_releases_once_and_a_bouncing_stop_at_once() {
    let mut hall = Hall::new();
    hall.press("station", false);
    hall.press("stop", false);
    for _ in 0..10 {
        assert!(orders(&hall.press("station", true)).is_empty());
        hall.now += 10;
        assert!(orders(&hall.press("station", false)).is_empty());
        hall.now += 10;
    }
    hall.press("station", true);
    assert!(hall.wait(49).is_empty());
    assert_eq!(hall.wait(1)[0].1, "Engage north None");
    let stop = hall.press("stop", true);
    assert_eq!(orders(&stop)[..2], ["Stop north", "Close north"]);
    assert!(orders(&stop).contains(&"Pump p1 off".to_owned()));
}

#[test]
fn a_station_pressed_at_the_start_is_a_trouble() {
    let mut hall = Hall::new();
    hall.press("station", true);
    assert!(hall.wait(1000).is_empty());
    assert!(hall.has(Trouble::ContactStuck, true));
}

#[test]
fn failed_silent_dirty_and_masked_detectors_alarm_without_release() {
    for condition in [Condition::Fault, Condition::Dirty, Condition::SelfTest, Condition::Starting]
    {
        let mut hall = Hall::new();
        hall.fire();
        let detector = "heat".to_owned();
        hall.event(Event::Detector { detector, signal: Signal::Alarm, condition });
        let water = hall.wait(30_000);
        assert!(!water.iter().any(|(_, order)| order.starts_with("Engage")), "{condition:?}");
        let state = &hall.site.state().zones[0];
        assert_eq!((state.need, state.ready, state.phase), (None, false, Phase::Alarm));
        let why = Unable::Condition(condition);
        assert_eq!(state.unable, [Voteless { detector: "heat".to_owned(), why }]);
        assert!(state.not_released.contains(&NotReleased::Failed));
    }
    let mut hall = Hall::new();
    hall.hand(Hand::Bypass { detector: "heat".to_owned(), bypass: Bypass::Masked });
    hall.fire();
    assert!(hall.wait(30_000).is_empty());
}

#[test]
fn a_silence_that_a_report_ends_starts_the_coincidence_again() {
    let config = HALL.replace("silent_after_s = 3600", "silent_after_s = 4");
    let (mut site, _) = Site::new(toml::from_str(&config).unwrap(), 0, None).unwrap();
    let sees = |site: &mut Site, now, detector: &str, signal| {
        let (detector, condition) = (detector.to_owned(), Condition::Ready);
        site.handle(now, &Event::Detector { detector, signal, condition });
    };
    for (now, signal) in [(0, Signal::Quiet), (100, Signal::Alarm)] {
        sees(&mut site, now, "flame", signal);
        sees(&mut site, now, "heat", signal);
    }
    // No step in between: the report itself shows that it was silent.
    sees(&mut site, 4200, "heat", Signal::Alarm);
    sees(&mut site, 4200, "flame", Signal::Alarm);
    assert_eq!(site.state().zones[0].left_ms, Some(15_000));
}

#[test]
fn automatic_water_ends_and_a_quiet_fire_ends_it_earlier() {
    let mut hall = Hall::new();
    hall.extinguishes();
    let end = hall.wait(60_000);
    assert!(end.contains(&(75_000, "Close north".to_owned())), "{end:?}");
    assert_eq!(hall.phase(), Phase::Ended(Why::Duration));
    let mut hall = Hall::new();
    hall.extinguishes();
    hall.sees("flame", Signal::Quiet);
    hall.sees("heat", Signal::Quiet);
    let end = hall.wait(30_000);
    assert!(end.contains(&(45_000, "Close north".to_owned())), "{end:?}");
    assert_eq!(hall.phase(), Phase::Quiet);
}

#[test]
fn the_mode_returns_by_itself_also_over_a_restart() {
    let mut hall = Hall::new();
    hall.hand(Hand::Mode { zone: zone(), mode: Mode::Off, for_s: None });
    hall.wait(60_000);
    let json = serde_json::to_string(&hall.site.persisted()).unwrap();
    let stored = serde_json::from_str(&json).unwrap();
    let config: Config = toml::from_str(HALL).unwrap();
    let (mut site, _) = Site::new(config, 7, Some(&stored)).unwrap();
    assert_eq!(site.state().zones[0].returns_in_ms, Some(40_000));
    site.step(40_006);
    assert_eq!(site.state().zones[0].mode, Mode::Off);
    site.step(40_007);
    assert_eq!(site.state().zones[0].mode, Mode::Automatic);
}

#[test]
fn a_start_acts_on_nothing_and_ends_found_water_in_its_time() {
    let mut hall = Hall::new();
    hall.extinguishes();
    hall.wait(20_000);
    let stored = hall.site.persisted();
    let config: Config = toml::from_str(HALL).unwrap();
    let (site, reaction) = Site::new(config, 0, Some(&stored)).unwrap();
    assert!(orders(&reaction).is_empty());
    let mut hall = Hall { site, now: 0 };
    hall.fire();
    hall.monitors(Valve::Open);
    assert_eq!(hall.site.state().monitors[0].found_left_ms, Some(40_000));
    assert!(hall.site.state().zones[0].not_released.contains(&NotReleased::Stale));
    let all = hall.wait(40_000);
    assert_eq!(all[0], (40_000, "Close north".to_owned()));
    let stays = |order: &str| order.starts_with("Close") || order.ends_with("off");
    assert!(all.iter().all(|(_, order)| stays(order)), "{all:?}");
    assert!(all.contains(&(40_000, "Valve zone-valve off".to_owned())), "{all:?}");
}

#[test]
fn a_test_turns_and_pumps_but_wets_nothing() {
    let mut hall = Hall::new();
    hall.hand(Hand::Mode { zone: zone(), mode: Mode::TestOutlet, for_s: None });
    hall.fire();
    let all: Vec<String> = hall.wait(20_000).into_iter().map(|(_, order)| order).collect();
    assert!(all.contains(&"Valve outlet on".to_owned()) && all.contains(&"Pump p1 on".to_owned()));
    assert!(!all.iter().any(|order| order.starts_with("Engage") || order.contains("zone-valve")));
    let released = Phase::Released { automatic: true, wet: false };
    assert_eq!(hall.phase(), released);
    let back = hall.hand(Hand::Mode { zone: zone(), mode: Mode::Automatic, for_s: None });
    assert!(orders(&back).contains(&"Valve outlet off".to_owned()));
}

/// What coincided and was held in a test does not bring water earlier, nor the other way round.
#[test]
fn the_change_between_test_and_automatic_starts_the_coincidence_again() {
    let mode = |mode| Hand::Mode { zone: zone(), mode, for_s: None };
    let mut hall = Hall::new();
    hall.hand(mode(Mode::TestDry));
    hall.fire();
    hall.wait(14_900);
    let changed = hall.hand(mode(Mode::Automatic));
    let cancelled = Entry::Cancelled { zone: zone(), why: Why::Mode };
    assert!(changed.records.iter().any(|it| it.entry == cancelled), "{changed:?}");
    let since = hall.now;
    assert!(hall.wait(14_999).is_empty());
    assert_eq!(hall.wait(1)[0], (since + 15_000, "Engage north Some(60000)".to_owned()));
    // Into the test.
    let mut hall = Hall::new();
    hall.fire();
    hall.wait(14_900);
    hall.hand(mode(Mode::TestOutlet));
    assert!(hall.wait(14_999).is_empty());
    assert_eq!(hall.wait(1)[0].1, "Valve outlet on");
    // From one test to the other it goes on, as it does where nothing changes.
    let mut hall = Hall::new();
    hall.hand(mode(Mode::TestDry));
    hall.fire();
    hall.wait(10_000);
    hall.hand(mode(Mode::TestOutlet));
    hall.wait(5000);
    assert_eq!(hall.phase(), Phase::Released { automatic: true, wet: false });
    let mut hall = Hall::new();
    hall.fire();
    hall.wait(14_900);
    hall.hand(mode(Mode::Automatic));
    assert!(!hall.wait(100).is_empty());
}

#[test]
fn pumps_start_in_order_and_one_that_fails_is_replaced() {
    let mut hall = Hall::new();
    let first = hall.hand(Hand::Release { zone: zone() });
    assert!(orders(&first).contains(&"Pump p1 on".to_owned()));
    let all = hall.wait(4000);
    let pumps: Vec<_> = all.iter().filter(|(_, order)| order.starts_with("Pump")).collect();
    let expected = [(2000, "Pump p2 on".to_owned()), (4000, "Pump p3 on".to_owned())];
    assert_eq!(pumps, expected.iter().collect::<Vec<_>>());
    assert!(hall.has(Trouble::PumpFailed, true));
    hall.hand(Hand::Abort { zone: zone() });
    let all = hall.wait(5000);
    assert!(all.contains(&(9000, "Pump p1 off".to_owned())), "{all:?}");
}

#[test]
fn a_person_keeps_a_monitor_and_a_lost_one_gets_its_order_again() {
    let mut hall = Hall::new();
    let person = MonitorReport {
        reachable: true,
        authority: Authority::Person,
        valve: Valve::Closed,
        ..Default::default()
    };
    hall.monitor("north", person);
    let reaction = hall.hand(Hand::Release { zone: zone() });
    assert_eq!(orders(&reaction)[0], "Engage south None");
    hall.monitor("south", MonitorReport::default());
    assert!(hall.has(Trouble::NoMonitor, true) && hall.has(Trouble::MonitorUnreachable, true));
    let well = MonitorReport { reachable: true, ..Default::default() };
    assert_eq!(orders(&hall.monitor("south", well)), ["Engage south None"]);
}

#[test]
fn troubles_stay_until_a_reset_and_the_lamp_with_them() {
    let mut hall = Hall::new();
    let path = |fault| Event::Path { path: "mains".to_owned(), fault };
    let reaction = hall.event(path(Some(PathFault::Power)));
    let lit = |reaction: &Reaction| {
        reaction.commands.iter().find_map(|it| match it.order {
            Order::Lamp { lit, .. } => Some(lit),
            _ => None,
        })
    };
    assert_eq!((lit(&reaction), hall.site.state().tone), (Some(true), Tone::Trouble));
    hall.hand(Hand::Silence);
    assert_eq!(hall.site.state().tone, Tone::Off);
    assert_eq!(lit(&hall.event(path(None))), None);
    assert!(hall.has(Trouble::Path, false));
    assert_eq!(lit(&hall.hand(Hand::Reset(Scope::Site))), Some(false));
}

#[test]
fn names_that_are_not_configured_are_recorded_and_do_nothing() {
    let mut hall = Hall::new();
    let long = "x".repeat(10_000);
    let reaction = hall.event(Event::Contact { input: long, pressed: true });
    assert!(matches!(&reaction.records[0].entry, Entry::Unknown { name } if name.len() == 64));
    let refused = hall.hand(Hand::Abort { zone: "nowhere".to_owned() });
    assert_eq!(refusal(&refused), Some(Refusal::Unknown));
}

#[test]
fn contradictions_are_said_in_words() {
    let cases = [
        ("votes = \"2oo2\"", "votes = \"3oo2\"", "needs no vote, or more"),
        ("votes = \"2oo2\"", "votes = \"2oo3\"", "the zone has 2 detectors"),
        ("votes = \"2oo2\"", "votes = \"1oo2\"", "One detector would release"),
        ("kinds = 2", "kinds = 3", "can never be met"),
        ("delay_s = 10", "delay_s = 61", "out of range"),
        ("water_max_s = 60", "water_max_s = 0", "out of range"),
        ("monitors = [\"north\", \"south\"]\n    valve", "monitors = []\n    valve", "No monitor"),
        ("valve = \"zone-valve\"", "valve = \"horn\"", "not configured"),
        ("test_outlet = \"outlet\"", "test_outlet = \"zone-valve\"", "more than once"),
        ("id = \"p2\"", "id = \"p1\"", "used twice"),
        ("pressure = \"gauge\"", "pressure = \"hold\"", "not configured"),
        ("zones = [\"hall\"], silent", "zones = [], silent", "has no zone"),
        ("kind = \"release\", zones = [\"hall\"]", "kind = \"release\"", "whole site"),
        ("coincidence_s = 5", "when_failed = [\"2oo2\"]", "does not fit"),
    ];
    for (old, new, what) in cases {
        assert!(HALL.contains(old), "{old}");
        let config: Config = toml::from_str(&HALL.replacen(old, new, 1)).unwrap();
        let problems = config.check();
        let found = problems.iter().find(|it| it.what.en.contains(what));
        let found = found.unwrap_or_else(|| panic!("{new}: {problems:?}"));
        assert!(!found.what.ru.is_empty() && !found.remedy.en.is_empty(), "{found:?}");
        assert!(Site::new(config, 0, None).is_err());
    }
}

#[test]
fn a_pump_that_does_not_report_itself_is_commanded_again_and_replaced() {
    let text = HALL.replace("id = \"p2\",", "id = \"p2\", feedback = true,");
    let (site, _) = Site::new(toml::from_str(&text).unwrap(), 0, None).unwrap();
    let mut hall = Hall { site, now: 0 };
    hall.monitors(Valve::Closed);
    hall.press("gauge", true);
    let runs = |hall: &mut Hall, on| {
        let reaction = hall.event(Event::Pump { pump: "p2".to_owned(), on });
        orders(&reaction).into_iter().filter(|it| it.contains("p2")).collect::<Vec<_>>()
    };
    // What is found running before any command stays as found.
    assert!(runs(&mut hall, true).is_empty() && runs(&mut hall, false).is_empty());
    let start = |pump: &str| Hand::Pump { pump: pump.to_owned(), on: true };
    hall.hand(start("p2"));
    let of = |all: Vec<(u64, String)>, pump: &str| -> Vec<u64> {
        let wanted = format!("Pump {pump} on");
        all.into_iter().filter(|it| it.1 == wanted).map(|it| it.0).collect()
    };
    assert_eq!(of(hall.wait(3500), "p2"), [1000, 2000, 3000]);
    assert!(runs(&mut hall, true).is_empty());
    assert!(of(hall.wait(20_000), "p2").is_empty() && !hall.has(Trouble::PumpOverdue, true));
    // It stops by itself: the command again at once, and a trouble, as it ran long enough before.
    assert_eq!(runs(&mut hall, false), ["Pump p2 on"]);
    assert!(hall.has(Trouble::PumpOverdue, true));
    assert!(hall.site.state().pumps[1].failed);
    runs(&mut hall, true);
    assert!(!hall.has(Trouble::PumpOverdue, true) && !hall.site.state().pumps[1].failed);
    // A stop is repeated as well, until it is reported.
    hall.hand(Hand::Pump { pump: "p2".to_owned(), on: false });
    let rest = hall.wait(3000);
    let stops = rest.iter().filter(|(_, order)| order == "Pump p2 off").count();
    assert_eq!(stops, 3, "{rest:?}");
    assert!(runs(&mut hall, false).is_empty() && hall.wait(5000).is_empty());
    // It is shown as stopped by hand until a reset.
    let stopped = Disablement::Pump { pump: "p2".to_owned() };
    assert!(hall.site.state().disablements.contains(&stopped));
    assert_eq!(hall.site.state().pumps[1].hand, Some(false));
    hall.hand(Hand::Reset(Scope::Site));
    assert!(!hall.site.state().disablements.contains(&stopped));
    assert_eq!(hall.site.state().pumps[1].hand, None);
}

#[test]
fn the_line_of_a_pump_is_a_path() {
    let mut hall = Hall::new();
    let path = |fault| Event::Path { path: "p1".to_owned(), fault };
    hall.event(path(Some(PathFault::Lost)));
    assert!(hall.has(Trouble::Path, true));
    hall.event(path(None));
    assert!(!hall.has(Trouble::Path, true));
    let twice = HALL.replace("id = \"p1\"", "id = \"horn\"");
    let config: Config = toml::from_str(&twice).unwrap();
    assert!(config.check().iter().any(|it| it.place == "pump horn"), "{:?}", config.check());
}

#[test]
fn outputs_are_shown_as_commanded_and_as_reported() {
    let mut hall = Hall::new();
    let shown = |hall: &Hall, index: usize| {
        let it = hall.site.state().outputs[index].clone();
        (it.output, it.on, it.reported)
    };
    assert_eq!(shown(&hall, 0), ("zone-valve".to_owned(), None, None));
    assert_eq!(shown(&hall, 2), ("horn".to_owned(), Some(false), None));
    hall.hand(Hand::Release { zone: zone() });
    hall.event(Event::Output { output: "zone-valve".to_owned(), on: true });
    assert_eq!(shown(&hall, 0), ("zone-valve".to_owned(), Some(true), Some(true)));
    assert_eq!(shown(&hall, 2), ("horn".to_owned(), Some(true), None));
}

fn prefer(hall: &mut Hall, opens: Option<&[&str]>) -> Reaction {
    let names = |all: &[&str]| all.iter().map(ToString::to_string).collect::<Vec<_>>();
    let monitors = names(&["north", "south"]);
    hall.event(Event::Prefer { zone: zone(), monitors, opens: opens.map(names) })
}

fn engaged(hall: &Hall) -> Vec<String> {
    hall.site.state().zones[0].monitors.clone()
}

/// The water suffices for one.
#[test]
fn votes_do_not_open_what_the_water_does_not_suffice_for_and_hands_do() {
    let engages = |orders: &[(u64, String)], monitor: &str| {
        orders.iter().any(|(_, order)| order.starts_with(&format!("Engage {monitor}")))
    };
    let mut hall = Hall::new();
    prefer(&mut hall, Some(&["north"]));
    hall.fire();
    let opened = hall.wait(15_000);
    assert!(engages(&opened, "north") && !engages(&opened, "south"), "{opened:?}");
    assert_eq!(engaged(&hall), ["north"]);
    // Lost: its place is taken by who may, as soon as the plan says so.
    hall.monitor("north", MonitorReport { reachable: false, ..Default::default() });
    assert!(!engages(&hall.wait(5000), "south"));
    assert!(hall.has(Trouble::NoMonitor, true));
    let replaced = prefer(&mut hall, Some(&["south"]));
    assert_eq!(orders(&replaced), ["Engage south Some(55000)"]);
    // It comes back, and there is no water for it.
    hall.monitors(Valve::Closed);
    assert!(!engages(&hall.wait(15_000), "north"));
    assert_eq!(engaged(&hall), ["south"]);
    let all = prefer(&mut hall, None);
    assert_eq!(orders(&all), ["Engage north Some(40000)"]);
    // A person releases: both.
    let mut hall = Hall::new();
    prefer(&mut hall, Some(&[]));
    let opened = orders(&hall.hand(Hand::Release { zone: zone() }));
    assert_eq!(opened[..2], ["Engage north None", "Engage south None"]);
}

/// An order that has not opened yet is taken back, water that flows is not.
#[test]
fn water_that_flows_stays_when_it_does_not_suffice_any_more() {
    let mut hall = Hall::new();
    hall.fire();
    hall.wait(15_000);
    hall.monitor(
        "north",
        MonitorReport { reachable: true, valve: Valve::Open, ..Default::default() },
    );
    // The program that the order has started ends too.
    assert_eq!(orders(&prefer(&mut hall, Some(&[]))), ["Stop south", "Close south"]);
    assert_eq!(engaged(&hall), ["north"]);
    let again = hall.wait(30_000);
    assert!(!again.iter().any(|(_, order)| order.starts_with("Engage")), "{again:?}");
    assert!(!hall.has(Trouble::MonitorIdle, true), "nothing is asked of the other one");
    let end = hall.wait(30_000);
    assert!(end.iter().any(|(_, order)| order == "Close north"), "{end:?}");
}

/// Of two jets, one that was left out and may open again does not come in addition.
#[test]
fn who_was_left_out_has_given_up_its_place() {
    let mut hall = Hall::with(|config| config.zones[0].jets = Some(1));
    hall.fire();
    let opened = hall.wait(15_000);
    assert!(opened.iter().any(|(_, order)| order.starts_with("Engage north")), "{opened:?}");
    prefer(&mut hall, Some(&["south"]));
    hall.wait(2000);
    assert_eq!(engaged(&hall), ["south"]);
    prefer(&mut hall, None);
    let later = hall.wait(10_000);
    assert!(!later.iter().any(|(_, order)| order.starts_with("Engage north")), "{later:?}");
    assert_eq!(engaged(&hall), ["south"]);
}
