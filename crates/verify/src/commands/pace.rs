//! How much faster than real time one monitor runs on one core: step by step, and passing over rest.

use std::time::Instant;

use lafet_proto::text;
use lafet_sim::sim::{Config, Sim};

fn ask(sim: &mut Sim, request: &str) {
    let mut buffer = [0; text::BUFFER_SIZE];
    let request = text::parse(request, &mut buffer).expect("a request");
    sim.ask(request.to, request.body, |answer| assert!(answer.status.0 <= 1, "{answer}"));
}

fn measure(name: &str, sim: &Sim, seconds: u64) {
    let times = [Sim::advance_ms, Sim::pass_ms].map(|pass: fn(&mut Sim, u64)| {
        let mut sim = sim.clone();
        let start = Instant::now();
        pass(&mut sim, seconds * 1_000);
        start.elapsed().as_secs_f64()
    });
    let [plain, fast] = times.map(|time| seconds as f64 / time);
    let tick_ns = times[0] * 1e7 / seconds as f64;
    println!("{name:<28} {tick_ns:>6.0} ns a step {plain:>9.0} × {fast:>12.0} ×");
}

/// Prints the figures.
pub fn run() -> Result<(), String> {
    println!("{:<28} {:>16} {:>11} {:>14}", "", "step by step", "real time", "passing over");
    for profile in ["full", "ex"] {
        let mut config = Config::default();
        config.profile(profile).expect("a profile");
        let mut sim = Sim::new(config);
        sim.advance_ms(60_000);
        measure(&format!("{profile}: wrapped"), &sim, 2_000);
        ask(&mut sim, "Deploy");
        measure(&format!("{profile}: deploys"), &sim, 8);
        sim.advance_ms(30_000);
        measure(&format!("{profile}: deployed"), &sim, 2_000);
        ask(&mut sim, "Open Valve1");
        sim.advance_ms(10_000);
        measure(&format!("{profile}: water"), &sim, 100);
        ask(&mut sim, "StartQuench centre=600,100 nozzle=60 sector=240,60 step=1 distance=25");
        measure(&format!("{profile}: program with water"), &sim, 100);
        sim.world_mut().light("az=10,range=25,size=1".parse().expect("a fire"));
        measure(&format!("{profile}: the same with a fire"), &sim, 100);
    }
    Ok(())
}
