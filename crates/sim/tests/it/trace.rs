//! The same seed and the same requests give the same trace, byte for byte.

use lafet_device::Source;
use lafet_device::image::{DriveOutput, Outputs, PLACES, ValveOutput};
use lafet_proto::hash::fnv1a32;
use lafet_proto::record::Writer;
use lafet_proto::text;
use lafet_sim::event::What;
use lafet_sim::sim::{Config, Sim};
use lafet_sim::world::{World, WorldConfig};

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

/// The world alone, under fixed outputs: the same numbers on every machine, so that a trace from
/// one can be replayed on another. Changes with the physical models, and with nothing else.
#[test]
fn the_world_is_the_same_everywhere() {
    let fires = vec!["az=5,range=30,size=1.2,growth=0.005,reignites=1".parse().expect("a fire")];
    let start = [600.0, 0.0, 60.0, 5_400.0];
    let wind = (-2.0, 1.0);
    let mut world =
        World::new(WorldConfig { seed: 42, fires, start, wind, ..WorldConfig::default() });
    let mut outputs = Outputs::default();
    outputs.valves[0] = ValveOutput::Opening;
    outputs.drives[1] = DriveOutput { speed_tenths: 7, cut: false };
    outputs.heaters = [true; PLACES];
    world.drive(outputs);
    let mut hash = 0;
    for _ in 0..300 {
        world.advance(100);
        let (inputs, fire, jet) = (world.inputs(), &world.fires[0], world.landing());
        let place = jet.map(|jet| (jet.at.0.to_bits(), jet.at.1.to_bits()));
        let text = format!(
            "{hash:08x} {} {} {:?} {:?} {:x} {:x} {:?}",
            inputs.pressure_ua,
            inputs.drives[1].position,
            inputs.detector.spots[0].map(|spot| (spot.left, spot.top, spot.brightness)),
            place,
            fire.heat.to_bits(),
            fire.density.to_bits(),
            inputs.places[0].temperature_dc,
        );
        hash = fnv1a32(&text);
    }
    assert_eq!(hash, 0x1E35_836D, "{hash:#010x}");
}
