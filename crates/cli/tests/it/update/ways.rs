//! `lafet update` by radio, and through a bus controller.

use serde_json::json;

use super::{Maker, state};
use crate::support::{Run, Running, Sim, lafet};

/// A monitor with these listeners that takes the images.
fn monitor(maker: &Maker, places: &[&str], more: &[&str]) -> Sim {
    let key = format!("0={}", maker.path("key0.pub"));
    Sim::listening(places, &[&["--board", "bench", "--update-key", &key], more].concat())
}

#[track_caller]
fn is_updated(sim: &Sim) {
    let state = state(sim);
    assert_eq!((&state["version"], &state["on_trial"]), (&json!("1.1.0.0"), &json!(false)));
    assert!(sim.flags("general").contains(&"LockedOut".to_owned()));
}

/// Modems at 19200 bit/s with 0.4 s each way that lose a frame of fifty, ten times as fast.
#[test]
fn by_radio() {
    let maker = Maker::new("update-radio");
    let image = maker.image("1.1", 1000);
    let places = ["tcp://127.0.0.1:0", "radio+tcp://127.0.0.1:0"];
    let modems = ["--radio", "rate=19200,latency=400,loss=0.02", "--speed", "10"];
    let sim = monitor(&maker, &places, &modems);
    sim.done(&["lockout", "on"]);
    let run = Run::of(&["-c", &sim.urls[1], "update", &image, "--watch", "5"]);
    assert_eq!(run.code, 0, "{run:?}");
    is_updated(&sim);
}

/// On a bus whose controller grants turns, to a program that has its turns from the controller.
#[test]
fn through_a_controller() {
    let maker = Maker::new("update-controller");
    let image = maker.image("1.1", 3000);
    let sim = monitor(&maker, &["tcp://127.0.0.1:0"], &["--addr", "1", "--speed", "10"]);
    sim.done(&["lockout", "on"]);
    let place = sim.url().to_owned();
    let bus = ["--json", "bus", &place, "--addresses", "1", "--watch", "0.2"];
    let bus = Running::stdout(lafet().args(bus).args(["--listen", "127.0.0.1:0"]));
    let listens: serde_json::Value = serde_json::from_str(&bus.line()).unwrap();
    while !bus.line().contains(r#""appeared":1}"#) {}
    let url = listens["listening"].as_str().unwrap();
    let run = Run::of(&["-c", url, "update", &image, "--watch", "5"]);
    assert_eq!(run.code, 0, "{run:?}");
    drop(bus);
    is_updated(&sim);
}
