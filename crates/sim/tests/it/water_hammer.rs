//! §3.8, §3.9 Water hammer: whatever closes a valve, it takes its travel time, and the surge that the
//! flow's fall makes in the pipe stays within the limit of a PN16 pipe.

use lafet_device::Source;
use lafet_proto::Request;
use lafet_proto::SubsystemId;
use lafet_proto::id::key;
use lafet_proto::record::Writer;
use lafet_proto::request::Body;
use lafet_sim::sim::{Config, Sim};

/// Steel pipe DN100, 100 m from the pump: ρ·L/A, MPa per m³/s².
const INERTANCE: f64 = 1000.0 * 100.0 / 0.007_85 / 1e6;
/// The pump at no flow, and the limit of a PN16 pipe, MPa.
const PUMP_MPA: f64 = 1.0;
const PIPE_MPA: f64 = 1.6;

fn ask(sim: &mut Sim, to: SubsystemId, body: Body<'_>) {
    let mut buffer = [0; 260];
    let mut writer = Writer::new(&mut buffer);
    Request::new(to, body).encode(&mut writer).expect("it fits");
    assert!(!sim.request(Source::ExternalConn, writer.written()).is_empty());
}

/// A monitor without Deployer at full flow.
fn flowing() -> Sim {
    let mut config = Config::default();
    config.profile("remote").expect("a profile");
    let mut sim = Sim::new(config);
    sim.advance_ms(500);
    ask(&mut sim, SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    sim.advance_ms(15_000);
    assert!(sim.world().water.flow_lps > 19.0, "{}", sim.world().water.flow_lps);
    sim
}

/// Time until the flow has stopped, ms, and the greatest surge on the way, MPa.
fn close(by: impl FnOnce(&mut Sim)) -> (u64, f64) {
    let mut sim = flowing();
    by(&mut sim);
    let (start_ms, mut surge) = (sim.now_ms(), 0.0_f64);
    let mut flow = sim.world().water.flow_lps;
    while flow > 0.1 {
        sim.tick();
        let now = sim.world().water.flow_lps;
        surge = surge.max((flow - now) / 1000.0 / 0.01 * INERTANCE);
        flow = now;
        assert!(sim.now_ms() < start_ms + 20_000, "it must close");
    }
    (sim.now_ms() - start_ms, surge)
}

#[test]
fn every_way_of_closing_is_slow_enough() {
    type Way = (&'static str, fn(&mut Sim));
    let ways: [Way; 4] = [
        ("Close", |sim| ask(sim, SubsystemId::VALVE1, Body::Close { key: key::CLOSE })),
        ("Lockout", |sim| ask(sim, SubsystemId::ALL, Body::Lockout { key: key::ENABLE })),
        ("Restart", |sim| ask(sim, SubsystemId::ALL, Body::Restart)),
        ("power cycle", Sim::power_cycle),
    ];
    for (name, way) in ways {
        let (ms, surge) = close(way);
        println!("{name}: {ms} ms, surge {surge:.2} MPa");
        assert!(ms >= 3500, "{name}: the flow stops in {ms} ms");
        assert!(surge > 0.05 && PUMP_MPA + surge < PIPE_MPA, "{name}: surge {surge:.2} MPa");
    }
}

/// A valve without power stays where it is: the supply's failure is no hammer.
#[test]
fn without_power_the_water_flows_on() {
    let mut sim = flowing();
    sim.world_mut().cut_power();
    let before = sim.world().water.flow_lps;
    sim.world_mut().advance(5000);
    assert!((sim.world().water.flow_lps - before).abs() < 0.5);
}
