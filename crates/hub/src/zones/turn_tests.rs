use std::fmt::Write as _;
use std::time::Instant;

use serde_json::Value;

use super::hall::{configured, rests};
use super::*;
use crate::Clock;
use crate::monitor::status::Status;

/// Monitors that answer, spread over zones with a detector each.
fn spread(monitors: usize, zones: usize) -> Hub {
    let mut text = String::new();
    for number in 0..monitors {
        let (port, zone) = (10_000 + number, number % zones);
        _ = write!(
            text,
            "[[monitor]]\nid = \"M{number}\"\nurl = \"tcp://127.0.0.1:{port}?addr=1\"\n\
             [[aim]]\nzone = \"Z{zone}\"\nmonitor = \"M{number}\"\n\
             horizontal = 600\nvertical = 300\nnozzle = 60\n"
        );
    }
    for zone in 0..zones {
        let of = (zone..monitors).step_by(zones).map(|it| format!("\"M{it}\""));
        let of = of.collect::<Vec<_>>().join(", ");
        _ = write!(
            text,
            "[[detector]]\nid = \"D{zone}\"\nkind = \"flame\"\nzones = [\"Z{zone}\"]\n\
             [[zone]]\nid = \"Z{zone}\"\nvotes = \"1oo1\"\none_detector_releases = true\n\
             water_max_s = 60\nmonitors = [{of}]\n"
        );
    }
    let hub = Hub::new(configured(&text), Clock::System, Value::Null).unwrap();
    for station in hub.stations() {
        station.set_link(&hub, true, None);
        rests(&hub, station.id());
    }
    let zones = hub.zones().unwrap();
    look(&hub);
    while zones.machine().hurries {
        look(&hub);
    }
    assert!(zones.machine().lines.values().all(|line| line.report().unwrap().reachable));
    hub
}

/// A turn in which the monitors are looked at; how long it takes, and the pause after it.
fn look(hub: &Hub) -> (Duration, Duration) {
    let zones = hub.zones().unwrap();
    let mut machine = zones.machine();
    machine.hurries = true;
    let began = Instant::now();
    let (pause, _) = hub.turn_machine(zones, &mut machine);
    (began.elapsed(), pause)
}

/// A quarter of them was heard again: they are polled every 200 ms.
fn heard(hub: &Hub, turn: usize) {
    for station in hub.stations().iter().skip(turn % 4).step_by(4) {
        let at_ms = Some(2 + u64::try_from(turn).unwrap());
        station.set_status(hub, Status { at_ms, ..Status::clone(&station.status()) });
    }
}

/// The shortest of some turns, their median, and the longest: the first of those in which it is published.
fn turns(hub: &Hub) -> [Duration; 3] {
    let one = |turn| {
        heard(hub, turn);
        look(hub).0
    };
    let mut took: Vec<_> = (0..21).map(one).collect();
    took.sort();
    [took[0], took[10], took[20]]
}

/// Each monitor compared with each of each zone would take 64 times as long. A machine that does other
/// things meanwhile has the smaller site in its caches and not the larger one: 26 times was seen.
#[tokio::test]
async fn a_turn_takes_in_proportion_to_the_monitors() {
    let few = turns(&spread(125, 8));
    let many = turns(&spread(1000, 64));
    println!("125 monitors: {few:?}, 1,000 monitors: {many:?}");
    assert!(many[0] < few[0] * 40, "{few:?} {many:?}");
}

/// What waits for the lock, a Stop, gets it in between.
#[tokio::test]
async fn monitors_that_are_lost_at_once_are_reported_in_parts() {
    let hub = spread(100, 4);
    let zones = hub.zones().unwrap();
    hub.stations().iter().for_each(|it| it.set_link(&hub, false, None));
    let reachable = || {
        let machine = zones.machine();
        machine.lines.values().filter(|line| line.report().unwrap().reachable).count()
    };
    let (mut turns, mut left) = (0, 100);
    while left > 0 {
        let (_, pause) = look(&hub);
        let now_left = reachable();
        assert!((1..=16).contains(&(left - now_left)), "{left} {now_left}");
        assert!(now_left == 0 || pause <= Duration::from_millis(1), "the next turn comes at once");
        (turns, left) = (turns + 1, now_left);
    }
    assert_eq!(turns, 7);
}
