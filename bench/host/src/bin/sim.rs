//! Simulated seconds per second: one monitor, a hundred, ten thousand, on one core.

use lafet_bench_host::own_s;
use lafet_bench_report::{Goals, Lines, Table, number, section};
use lafet_device::Source;
use lafet_proto::link::{self, Frame, WIRE_MAX};
use lafet_proto::record::Writer;
use lafet_proto::text;
use lafet_sim::sim::{Config, Sim};

const STEP_MS: u64 = lafet_sim::world::STEP_MS;
const NUMBERS: [usize; 5] = [1, 10, 100, 1_000, 10_000];
/// Steps of each monitor, at least: at rest it looks ten seconds ahead, and that is to count.
const STEPS: usize = 1_500;
/// Processor time of one measurement, at least: the system counts it in ticks of 4 ms.
const LEAST_S: f64 = 0.4;
/// The best of so many counts: others use the caches, too.
const TRIES: usize = 3;
/// Steps from one question to a monitor to the next: the hub asks five times a second.
const POLL_STEPS: usize = 20;
const ADDRESS: u8 = 1;
const CONTROLLER: u8 = 128;

/// What monitors do, by turns.
struct Scene {
    name: &'static str,
    monitors: Vec<Sim>,
    /// What each is asked five times a second.
    question: Option<Vec<u8>>,
}

/// Nanoseconds of a step of one monitor, by [`NUMBERS`].
type Costs = Vec<f64>;

fn main() {
    let (rest, motion) = (at_rest(), in_motion());
    let mixed = [vec![stowed(); 4], vec![rest.clone(); 4], vec![motion.clone(), in_action()]];
    let scenes = [
        Scene { name: "at rest", monitors: vec![rest], question: None },
        Scene { name: "drives in motion", monitors: vec![motion], question: None },
        Scene { name: "mixed", monitors: mixed.concat(), question: Some(poll()) },
    ];
    let costs = scenes.each_ref().map(Scene::costs);
    show(&scenes, &costs);
    let [rest, _, mixed] = &costs;
    let ([one, .., most], [first, .., last]) = (&rest[..], &mixed[..]) else { return };
    let mut goals = Goals::default();
    goals.at_least("one monitor at rest, × real time", 10_000.0, pace(*one, 1), "");
    goals.at_most("at rest, a step of each of 10,000, against one alone", 1.25, most / one, "×");
    goals.at_most("mixed, the same", 1.25, last / first, "×");
    goals.at_least("10,000 mixed, × real time", 1.0, pace(*last, 10_000), "");
    section("sim-goals", goals.text());
}

fn show(scenes: &[Scene], costs: &[Costs]) {
    let mut columns = vec!["monitors on one core".to_owned()];
    let mut plot = Lines::new("nanoseconds a step and monitor, by the number of monitors");
    for (scene, costs) in scenes.iter().zip(costs) {
        columns.push(format!("{}, ns a step", scene.name));
        columns.push("× real time, all together".into());
        let points = NUMBERS.iter().zip(costs).map(|(count, ns)| (*count as f64, *ns));
        plot.line(scene.name, points.collect());
    }
    let mut table = Table::new(&columns);
    for (index, count) in NUMBERS.into_iter().enumerate() {
        let mut row = vec![number(count as f64)];
        for ns in costs.iter().map(|costs| costs[index]) {
            row.extend([number(ns), number(pace(ns, count))]);
        }
        table.row(&row);
    }
    section("sim", table.text());
    section("sim.svg", &plot.svg());
}

/// How many times as fast as life so many monitors run together.
fn pace(ns: f64, count: usize) -> f64 {
    STEP_MS as f64 * 1e6 / ns / count as f64
}

impl Scene {
    fn costs(&self) -> Costs {
        let best = |count| (0..TRIES).map(|_| self.cost_ns(count)).fold(f64::INFINITY, f64::min);
        NUMBERS.into_iter().map(best).collect()
    }

    /// Of a step of one monitor, when they are stepped one after the other, as a site does. Where
    /// there are fewer monitors than kinds of them, all kinds have their turn.
    fn cost_ns(&self, count: usize) -> f64 {
        let kinds = self.monitors.len();
        let turns: Vec<usize> = (0..kinds).step_by(count).collect();
        let costs = turns.iter().map(|first| {
            let monitors = self.monitors.iter().cycle().skip(*first);
            self.run_ns(&mut monitors.take(count).cloned().collect::<Vec<_>>())
        });
        costs.sum::<f64>() / turns.len() as f64
    }

    fn run_ns(&self, sims: &mut [Sim]) -> f64 {
        let (start, mut rounds, mut took_s) = (own_s(), 0, 0.0);
        while took_s < LEAST_S {
            (rounds..rounds + STEPS).for_each(|round| self.step(sims, round));
            rounds += STEPS;
            // Steps that wait are made before the clock is looked at.
            sims.iter_mut().for_each(|sim| assert_eq!(sim.now_ms(), sim.world_mut().now_ms()));
            took_s = own_s() - start;
        }
        took_s * 1e9 / (rounds * sims.len()) as f64
    }

    /// A step of each monitor. They are not all asked in the same one.
    fn step(&self, sims: &mut [Sim], round: usize) {
        for (index, sim) in sims.iter_mut().enumerate() {
            sim.advance_ms(STEP_MS);
            let Some(question) = &self.question else { continue };
            if (round + index).is_multiple_of(POLL_STEPS) {
                let answer = sim.datagram(Source::ExternalConn, question);
                assert!(answer.is_some(), "a monitor that does not answer");
            }
        }
    }
}

/// In the position in which it waits for years.
fn stowed() -> Sim {
    let mut sim = Sim::new(Config { address: ADDRESS, ..Config::default() });
    sim.advance_ms(60_000);
    sim
}

fn at_rest() -> Sim {
    let mut sim = stowed();
    ask(&mut sim, "Deploy");
    sim.advance_ms(30_000);
    sim
}

/// A program that swings the barrel for ever.
fn in_motion() -> Sim {
    let mut sim = at_rest();
    ask(&mut sim, "StartQuench centre=600,100 nozzle=60 sector=2000,60 step=1 distance=25");
    sim.advance_ms(20_000);
    sim
}

/// The same with water.
fn in_action() -> Sim {
    let mut sim = in_motion();
    ask(&mut sim, "Open Valve1");
    sim.advance_ms(20_000);
    sim
}

fn ask(sim: &mut Sim, request: &str) {
    let mut buffer = [0; text::BUFFER_SIZE];
    let request = text::parse(request, &mut buffer).expect("a request");
    sim.ask(request.to, request.body, |answer| assert!(answer.status.0 <= 1, "{answer}"));
}

/// The frame that asks for the state of everything.
fn poll() -> Vec<u8> {
    let (mut buffer, mut records) = ([0; text::BUFFER_SIZE], [0; 64]);
    let request = text::parse("GetStatus All", &mut buffer).expect("a request");
    let mut writer = Writer::new(&mut records);
    request.encode(&mut writer).expect("room");
    let frame = Frame { dst: ADDRESS, src: CONTROLLER, payload: writer.written() };
    let mut wire = [0; WIRE_MAX];
    let len = link::encode(&frame, &mut wire).expect("room");
    wire[..len].to_vec()
}
