//! A hall with two monitors and two detectors, for tests.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use lafet_proto::SubsystemId;
use lafet_site::{Condition, Event, MonitorReport, Phase, Signal};
use serde_json::Value;

use super::Machine;
use super::view::{Reported, WindReported};
use crate::control::authority::Now;
use crate::hub::{Caller, Hub};
use crate::monitor::status::{Status, Subsystem};
use crate::site::{Place, Site};
use crate::{Clock, Config, Overrides};

const HALL: &str = r#"
    [[monitor]]
    id = "M1"
    url = "tcp://127.0.0.1:1?addr=1"
    [[monitor]]
    id = "M2"
    url = "tcp://127.0.0.1:1?addr=2"
    [[detector]]
    id = "west"
    kind = "flame"
    zones = ["hall"]
    at = [-20, 0, 6]
    [[detector]]
    id = "east"
    kind = "flame"
    zones = ["hall"]
    at = [20, 0, 6]
    [[aim]]
    zone = "hall"
    monitor = "M1"
    horizontal = 600
    vertical = 300
    nozzle = 60
    [[aim]]
    zone = "hall"
    monitor = "M2"
    horizontal = 600
    vertical = 300
    nozzle = 60
    [[zone]]
    id = "hall"
    votes = "2oo2"
    coincidence_s = 0
    water_max_s = 60
    monitors = ["M1", "M2"]
"#;

/// A configuration whose state is in memory.
pub fn configured(text: &str) -> Config {
    let read = Config::parse("hub.toml", text, Path::new("/"), &Overrides::default());
    Config { data: None, ..read.unwrap_or_else(|it| panic!("{it:#?}")) }
}

/// Two monitors that answer, two detectors that see nothing.
pub fn hall() -> Hub {
    let mut config = configured(HALL);
    let place = |east| Place { at: [east, 0.0], heading: 0.0, height: 2.0 };
    let monitors = [("M1".to_owned(), place(-15.0)), ("M2".to_owned(), place(15.0))].into();
    config.site = Some(Site { monitors, ..Site::default() });
    let hub = Hub::new(config, Clock::System, Value::Null).unwrap();
    {
        let machine = &mut *hub.zones().unwrap().machine();
        let valve = lafet_site::Valve::Closed;
        let report = MonitorReport { reachable: true, valve, ..MonitorReport::default() };
        for (id, line) in &mut machine.lines {
            line.report = Some(report);
            machine.site.handle(0, &Event::Monitor { monitor: id.clone(), report });
        }
        // There are none behind it to be looked at.
        machine.looked = Now::from_secs(1_000_000);
    }
    for id in ["M1", "M2"] {
        rests(&hub, id);
    }
    for detector in ["west", "east"] {
        sees(&hub, detector, Signal::Quiet, 0.0);
    }
    hub
}

/// It points north, its valve shut.
pub fn rests(hub: &Hub, monitor: &str) {
    let mut state = Status { at_ms: Some(1), ..Status::default() };
    for name in ["Horizontal", "Vertical", "Valve1"] {
        let id = SubsystemId::from_name(name).unwrap();
        let flag = (name == "Valve1").then_some("Closed");
        let bits = flag.map(|it| lafet_proto::flags::flags_of(id).by_name(it).unwrap().mask());
        let mut subsystem = Subsystem::default();
        subsystem.set_bits(id, bits.unwrap_or(0));
        subsystem.fields = [("position", 0)].into();
        state.subsystems.insert(name, Arc::new(subsystem));
    }
    hub.station(monitor).unwrap().set_status(hub, state);
}

pub fn sees(hub: &Hub, detector: &str, signal: Signal, bearing_deg: f64) {
    let reported = Reported {
        heard: hub.now(),
        at_ms: 0,
        by: String::new(),
        signal,
        condition: Condition::Ready,
        bearing_deg: (signal == Signal::Alarm).then_some(bearing_deg),
        elevation_deg: None,
        quality: None,
    };
    hub.detector_reports(&Caller::hub(), detector, reported).unwrap();
}

/// 10 m east, 20 m north.
pub fn burns(hub: &Hub) {
    sees(hub, "west", Signal::Alarm, 56.31);
    sees(hub, "east", Signal::Alarm, 333.435);
}

pub fn blows(hub: &Hub, speed_mps: f64) {
    let by = String::new();
    let wind = WindReported { heard: hub.now(), at_ms: 7, by, from_deg: 350.0, speed_mps };
    hub.wind_reports(wind).unwrap();
}

pub fn until(hub: &Hub, what: &str, wanted: impl Fn(&Machine) -> bool) {
    let began = Instant::now();
    while !wanted(&hub.zones().unwrap().machine()) {
        assert!(began.elapsed() < Duration::from_secs(30), "{what}");
        std::thread::park_timeout(Duration::from_millis(5));
    }
}

/// The votes open M2 at the fire that it is planned for.
pub fn opens_at_the_fire(hub: &Hub) {
    until(hub, "it is released", |it| it.lines.values().any(|line| line.engaged.is_some()));
    let machine = hub.zones().unwrap().machine();
    assert_eq!((machine.plans["hall"].by["M2"], machine.lines["M2"].at()), (1, Some(1)));
}

/// Both votes are counted, and a no has ended what follows from them.
pub fn is_ended(hub: &Hub) {
    let machine = hub.zones().unwrap().machine();
    assert!(machine.held.is_empty());
    let state = machine.site.state();
    assert_eq!(state.zones[0].votes.len(), 2);
    assert!(matches!(state.zones[0].phase, Phase::Ended(_)), "{:?}", state.zones[0].phase);
    assert!(machine.lines.values().all(|line| line.engaged.is_none()), "the no was heard");
}

/// Fires are located by hand, not on their thread: the lock of the planning is held.
pub fn locate(hub: &Hub) {
    let zones = hub.zones().unwrap();
    let (zone, machine) = (&zones.config.site.zones[0], &mut *zones.machine());
    let search = hub.latest_search(zones, machine, zone).expect("one is under way");
    hub.take_located(zones, machine, zone, search.run());
}

/// Does this on a thread of its own; it has to end soon.
pub fn ends(hub: &Hub, what: impl FnOnce(&Hub) + Send + 'static) {
    let (done, ended) = std::sync::mpsc::channel();
    let (runtime, its) = (tokio::runtime::Handle::current(), hub.clone());
    std::thread::spawn(move || {
        let _runtime = runtime.enter();
        what(&its);
        done.send(()).unwrap();
    });
    ended.recv_timeout(Duration::from_secs(20)).expect("it waits for the planning");
}
