//! Simulated seconds per second: one monitor, a hundred, ten thousand, on one core.

use lafet_bench_host::own_s;
use lafet_bench_report::{Goals, Lines, Table, number, section};
use lafet_proto::text;
use lafet_sim::sim::{Config, Sim};

const STEP_MS: u64 = lafet_sim::world::STEP_MS;
const NUMBERS: [usize; 5] = [1, 10, 100, 1_000, 10_000];
/// Steps of all monitors together in one measurement.
const STEPS: usize = 200_000;
/// The best of so many counts: others use the caches, too.
const TRIES: usize = 3;

/// What a monitor does, and how it is brought to that.
type State = (&'static str, fn() -> Sim);

fn main() {
    let states: [State; 2] = [("at rest", at_rest), ("drives in motion", in_motion)];
    let mut table = Table::new(&[
        "monitors on one core",
        "at rest, ns a step",
        "× real time, all together",
        "drives in motion, ns a step",
        "× real time, all together",
    ]);
    let mut rows = vec![Vec::new(); NUMBERS.len()];
    let mut plot = Lines::new("nanoseconds a step and monitor, by the number of monitors");
    let mut rest = Vec::new();
    for (name, make) in states {
        let mut points = Vec::new();
        for (row, count) in rows.iter_mut().zip(NUMBERS) {
            let ns = (0..TRIES).map(|_| cost_ns(&make(), count)).fold(f64::INFINITY, f64::min);
            let pace = STEP_MS as f64 * 1e6 / ns / count as f64;
            row.extend([number(ns), number(pace)]);
            points.push((count as f64, ns));
        }
        if rest.is_empty() {
            rest = points.iter().map(|(_, ns)| *ns).collect();
        }
        plot.line(name, points);
    }
    for (cells, count) in rows.into_iter().zip(NUMBERS) {
        let mut row = vec![number(count as f64)];
        row.extend(cells);
        table.row(&row);
    }
    let mut goals = Goals::default();
    let [one, .., most] = &rest[..] else { return };
    goals.at_least("one monitor at rest, × real time", 10_000.0, STEP_MS as f64 * 1e6 / one, "");
    goals.at_most("a step of each of 10,000, against one alone", 1.25, most / one, "×");
    section("sim-goals", goals.text());
    section("sim", table.text());
    section("sim.svg", &plot.svg());
}

fn at_rest() -> Sim {
    let mut sim = Sim::new(Config::default());
    sim.advance_ms(60_000);
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

fn ask(sim: &mut Sim, request: &str) {
    let mut buffer = [0; text::BUFFER_SIZE];
    let request = text::parse(request, &mut buffer).expect("a request");
    sim.ask(request.to, request.body, |answer| assert!(answer.status.0 <= 1, "{answer}"));
}

/// Of a step of one monitor, when they are stepped one after the other, as a site does.
fn cost_ns(sim: &Sim, count: usize) -> f64 {
    let mut sims = vec![sim.clone(); count];
    let rounds = (STEPS / count).max(20);
    let start = own_s();
    for _ in 0..rounds {
        sims.iter_mut().for_each(|sim| sim.advance_ms(STEP_MS));
    }
    (own_s() - start) * 1e9 / (rounds * count) as f64
}
