//! What releases, what undoes a no, and what says no, at the same time and in every order: the no wins.

use lafet_site::{
    Condition, Config, Event, Hand, MonitorReport, Order, Phase, Reaction, Scope, Signal, Site,
    Valve,
};

const HALL: &str = r#"
    monitors = ["m1", "m2"]
    detector = [
        { id = "d1", kind = "flame", zones = ["hall"], silent_after_s = 3600 },
        { id = "d2", kind = "heat", zones = ["hall"], silent_after_s = 3600 },
    ]
    input = [
        { id = "station", kind = "release", zones = ["hall"], debounce_ms = 0 },
        { id = "abort", kind = "abort", zones = ["hall"], debounce_ms = 0 },
        { id = "stop", kind = "stop", debounce_ms = 0 },
        { id = "key", kind = "lockout", debounce_ms = 0 },
    ]
    output = [{ id = "valve", kind = "valve" }]
    pump = [{ id = "p1" }]
    [[zone]]
    id = "hall"
    votes = "2oo2"
    coincidence_s = 0
    delay_s = 1
    water_max_s = 60
    monitors = ["m1", "m2"]
    valve = "valve"
"#;

/// Seeded numbers: xorshift.
struct Draw(u64);

impl Draw {
    fn below(&mut self, most: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % most
    }
}

fn sees(detector: &str, signal: Signal) -> Event {
    Event::Detector { detector: detector.to_owned(), signal, condition: Condition::Ready }
}

fn reports(monitor: &str, valve: Valve) -> Event {
    let report = MonitorReport { reachable: true, valve, ..Default::default() };
    Event::Monitor { monitor: monitor.to_owned(), report }
}

fn hand(order: Hand) -> Event {
    Event::Hand { by: "anna".to_owned(), order }
}

fn pressed(input: &str, pressed: bool) -> Event {
    Event::Contact { input: input.to_owned(), pressed }
}

fn zone() -> String {
    "hall".to_owned()
}

/// What says no: to all that the zone has.
fn no(draw: &mut Draw) -> Event {
    match draw.below(8) {
        0 => hand(Hand::Stop(Scope::Site)),
        1 => hand(Hand::Stop(Scope::Zone(zone()))),
        2 => hand(Hand::Close(Scope::Zone(zone()))),
        3 => hand(Hand::Abort { zone: zone() }),
        4 => hand(Hand::Lockout { on: true }),
        5 => pressed("abort", true),
        6 => pressed("stop", true),
        _ => pressed("key", true),
    }
}

/// What releases: votes, a hand, a station; `None`: the end of the delay.
fn release(draw: &mut Draw) -> Option<Event> {
    match draw.below(4) {
        0 => Some(sees("d2", Signal::Alarm)),
        1 => Some(hand(Hand::Release { zone: zone() })),
        2 => Some(pressed("station", true)),
        _ => None,
    }
}

/// What would undo a no, from another console.
fn undo(draw: &mut Draw) -> Event {
    match draw.below(3) {
        0 => hand(Hand::Reset(Scope::Site)),
        1 => hand(Hand::Reset(Scope::Zone(zone()))),
        _ => hand(Hand::Lockout { on: false }),
    }
}

fn opens(order: &Order) -> bool {
    matches!(
        order,
        Order::Engage { .. } | Order::Pump { on: true, .. } | Order::Valve { open: true, .. }
    )
}

/// A race: some releases and a no within so many milliseconds, among reports of the monitors.
fn race(first: &Site, draw: &mut Draw) {
    let mut site = first.clone();
    let start = 10_000;
    let votes_before = draw.below(2) == 0;
    site.handle(start, &sees("d1", Signal::Alarm));
    if votes_before {
        site.handle(start, &sees("d2", Signal::Alarm));
    }
    // About the end of the delay, which is due a second after the second vote.
    let at = start + 998 + draw.below(5);
    let mut events: Vec<Option<Event>> = vec![Some(no(draw))];
    for _ in 0..=draw.below(3) {
        events.push(release(draw));
    }
    for _ in 0..draw.below(3) {
        events.push(Some(undo(draw)));
    }
    for monitor in ["m1", "m2"] {
        if draw.below(2) == 0 {
            events.push(Some(reports(monitor, Valve::Open)));
        }
    }
    for last in (1..events.len()).rev() {
        events.swap(last, draw.below(last as u64 + 1) as usize);
    }
    let mut refused = false;
    let mut last: Vec<(Reaction, bool)> = Vec::new();
    for (number, event) in events.iter().enumerate() {
        let now = at + number as u64 / 3;
        let reaction = match event {
            Some(event) => site.handle(now, event),
            None => site.step(now),
        };
        let says_no = event.as_ref().is_some_and(|event| {
            matches!(
                event,
                Event::Hand {
                    order: Hand::Stop(_)
                        | Hand::Close(_)
                        | Hand::Abort { .. }
                        | Hand::Lockout { on: true },
                    ..
                }
            ) || matches!(event, Event::Contact { input, .. } if input != "station")
        });
        refused |= says_no;
        last.push((reaction, refused));
    }
    // Longer than everything that was under way, and shorter than a hand has to wait.
    for after in [500, 1500] {
        last.push((site.step(at + after), refused));
    }
    for (reaction, refused) in &last {
        let opened = reaction.commands.iter().find(|it| opens(&it.order));
        assert!(!refused || opened.is_none(), "{opened:?} in spite of a no: {events:?}");
    }
    // What was opened before it was closed by it.
    let all = || last.iter().flat_map(|it| &it.0.commands);
    for monitor in ["m1", "m2"] {
        let engaged = |it: &Order| matches!(it, Order::Engage { monitor: m, .. } if m == monitor);
        let closed = |it: &Order| matches!(it, Order::Close { monitor: m } if m == monitor);
        let opened = all().rposition_of(engaged);
        assert!(opened <= all().rposition_of(closed), "{monitor}: {events:?}");
    }
    let state = site.state();
    let over = matches!(state.zones[0].phase, Phase::Ended(_)) || state.lockout;
    assert!(over && state.zones[0].monitors.is_empty(), "{events:?}");
}

/// The place of the last order of a kind.
trait LastOf<'a>: Iterator<Item = &'a lafet_site::Command> + Sized {
    fn rposition_of(self, of: impl Fn(&Order) -> bool) -> Option<usize> {
        self.enumerate().filter(|it| of(&it.1.order)).map(|it| it.0).last()
    }
}

impl<'a, I: Iterator<Item = &'a lafet_site::Command>> LastOf<'a> for I {}

fn races(count: u32) {
    let config: Config = toml::from_str(HALL).unwrap();
    let (mut site, _) = Site::new(config, 0, None).unwrap();
    for detector in ["d1", "d2"] {
        site.handle(0, &sees(detector, Signal::Quiet));
    }
    for input in ["station", "abort", "stop", "key"] {
        site.handle(0, &pressed(input, false));
    }
    for monitor in ["m1", "m2"] {
        site.handle(0, &reports(monitor, Valve::Closed));
    }
    let mut draw = Draw(0x9E37_79B9_7F4A_7C15);
    for _ in 0..count {
        race(&site, &mut draw);
    }
    println!("{count} of {count} races were won by the no");
}

#[test]
fn a_no_wins_every_race() {
    races(20_000);
}

#[test]
#[ignore = "a minute: a million races"]
fn a_no_wins_a_million_races() {
    races(1_000_000);
}
