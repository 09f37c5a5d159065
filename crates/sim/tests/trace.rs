//! The same seed and the same requests give the same trace, byte for byte.

use lafet_device::Source;
use lafet_proto::record::Writer;
use lafet_proto::text;
use lafet_sim::event::What;
use lafet_sim::sim::{Config, Sim};

fn send(sim: &mut Sim, request: &str) {
    let (mut buffer, mut record) = ([0; text::BUFFER_SIZE], [0; 260]);
    let mut writer = Writer::new(&mut record);
    let request = text::parse(request, &mut buffer).expect("a request");
    request.encode(&mut writer).expect("it fits");
    sim.request(Source::ExternalConn, writer.written());
}

/// Deploys, aims at a fire 25 m away at 30° left, opens, sweeps it, closes, wraps.
fn extinguish(seed: u64) -> Sim {
    let fires = vec!["az=30,range=25,size=1.5".parse().expect("a fire")];
    let mut sim = Sim::new(Config { seed, fires, trace: true, ..Config::default() });
    sim.advance_ms(1_000);
    for (request, ms) in [
        ("Deploy Deployer", 15_000),
        ("StartSeek Detector 1200 2400 -300 0", 30_000),
        ("StartQuench Control centre=1800,-100 nozzle=60 sector=120,60 step=1 distance=25", 10_000),
        ("Open Valve1", 90_000),
        ("Close Valve1", 8_000),
        ("Stop Control", 500),
        ("Wrap Deployer", 30_000),
    ] {
        send(&mut sim, request);
        sim.advance_ms(ms);
    }
    sim
}

/// The first line in which two traces differ.
fn difference(a: &Sim, b: &Sim) -> Option<(String, String)> {
    let (a, b) = (a.trace().expect("asked for"), b.trace().expect("asked for"));
    assert_eq!(a.lines().count(), b.lines().count());
    let mut pairs = a.lines().zip(b.lines());
    pairs.find(|(a, b)| a != b).map(|(a, b)| (a.to_owned(), b.to_owned()))
}

#[test]
fn same_seed_same_trace() {
    let first = extinguish(7);
    assert_eq!(first.trace().map(|trace| trace.lines().count()), Some(1_845));
    assert_eq!(difference(&first, &extinguish(7)), None);
    assert!(difference(&first, &extinguish(8)).is_some(), "the seed has no effect");
}

/// What the demo shows, on its way: the fire is hit, goes out, no water in the folded barrel.
#[test]
fn a_fire_is_put_out() {
    let mut sim = extinguish(7);
    let events = sim.world_mut().take_events();
    let at = |what| events.iter().find(|event| event.what == what).map(|event| event.at_ms);
    let (on, hit, out, off) =
        (at(What::JetOn), at(What::FireHit(0)), at(What::FireOut(0)), at(What::JetOff));
    assert!(on.is_some() && on < hit && hit < out && out < off, "{events:?}");
    assert_eq!(at(What::FoldedBarrelFlooded), None);
    assert!(!sim.world().deployed());
}
