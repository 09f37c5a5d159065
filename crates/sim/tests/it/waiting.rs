//! Steps that wait for each other are made as if they had never waited: monitors that move, with the same
//! seed, requests, faults, buttons and failures of power, one stepped plainly, the others left alone, asked as
//! a hub asks, or looked at now and then. No answer shows which is which.

use lafet_device::Source;
use lafet_device::composition::Composition;
use lafet_proto::status::FaultInfo;
use lafet_sim::fault::Fault;
use lafet_sim::flash::{Cut, Torn};
use lafet_sim::rng::Rng;
use lafet_sim::sim::{Config, Sim};

use crate::rest::{act, payload, shown};

const SEEDS: u64 = 24;
const ACTIONS: u32 = 40;
/// Steps from one question of a hub to the next.
const POLL_STEPS: u64 = 20;

/// Does to a monitor what a test of rest does, or lets it move, or takes its power away.
fn disturb(sim: &mut Sim, rng: &mut Rng, faults: &[Fault]) -> Vec<u8> {
    let torn = [Torn::Old, Torn::New, Torn::Mixed, Torn::Random][rng.bits() as usize % 4];
    match rng.bits() % 16 {
        0 => sim.power_off(),
        1 | 2 => sim.power_on(),
        3 => sim.crash(FaultInfo::from_words([0; 20])),
        4 => sim.cut_power_at(&[Cut { step: rng.bits() % 12, torn }, Cut { step: 3, torn }]),
        5 => sim.cut_power_at(&[]),
        6..=9 => {
            let motion = "StartQuench centre=600,100 nozzle=60 sector=2000,60 step=1 distance=25";
            let request = ["Deploy", "Open Valve1", motion, motion][rng.bits() as usize % 4];
            return sim.request(Source::ExternalConn, &payload(request));
        }
        _ => return act(sim, rng, faults),
    }
    Vec::new()
}

/// All that a monitor shows to who only looks.
fn seen(sim: &Sim) -> String {
    format!(
        "{} {} {} {} {}\n{}\n{:?}",
        sim.now_ms(),
        sim.address(),
        sim.stood_still(),
        sim.resets(),
        sim.is_powered(),
        sim.trace_line(),
        sim.world().inputs(),
    )
}

/// Monitors with the same seed: one that makes every step at once, one whose state is not read, one that a hub
/// asks, one that is looked at.
struct Four {
    plain: Sim,
    alone: Sim,
    asked: Sim,
    watched: Sim,
    steps: u64,
}

impl Four {
    fn new(seed: u64) -> Self {
        let composition = Composition::ALL[(seed % 5) as usize];
        let clock_ms = if seed.is_multiple_of(2) { 0 } else { u32::MAX - 20_000 };
        // Gusts leave no rest; without them steps wait or are passed over by turns.
        let gusts = if seed % 4 == 3 { 0.0 } else { 0.2 };
        let wind = (3.0, 1.0);
        let config = Config { seed, composition, clock_ms, gusts, wind, ..Config::default() };
        let alone = Sim::new(config.clone());
        // Who keeps a trace makes every step at once.
        let plain = Sim::new(Config { trace: true, ..config });
        Self { plain, asked: alone.clone(), watched: alone.clone(), alone, steps: 0 }
    }

    /// One step of each. Where a question finds the flash busy it waits, and time goes on.
    fn tick(&mut self, looks: &mut Rng, what: &str) {
        self.steps += 1;
        for sim in [&mut self.plain, &mut self.alone, &mut self.asked, &mut self.watched] {
            sim.tick();
        }
        assert_eq!(self.alone.now_ms(), self.plain.now_ms(), "{what}");
        let busy = self.plain.world().stays_stalled();
        if self.steps.is_multiple_of(POLL_STEPS) && !busy {
            let answers = [&mut self.plain, &mut self.asked]
                .map(|sim| sim.request(Source::Radio, &payload("GetStatus All")));
            assert_eq!(answers[0], answers[1], "{what}");
        }
        if looks.chance(0.04) {
            assert_eq!(seen(&self.watched), seen(&self.plain), "{what}");
        }
    }

    fn compare(&mut self, what: &str) {
        let shows = shown(&mut self.plain);
        let memory = self.plain.world().flash.to_bytes();
        for sim in [&mut self.alone, &mut self.asked, &mut self.watched] {
            assert_eq!(shown(sim), shows, "{what}");
            assert_eq!(sim.device(), self.plain.device(), "{what}");
            assert!(sim.world().flash.to_bytes() == memory, "{what}: the memory");
            assert_eq!(seen(sim), seen(&self.plain), "{what}");
        }
    }

    fn disturb(&mut self, rng: &mut Rng, faults: &[Fault], what: &str) {
        let after = &mut rng.clone();
        let answer = disturb(&mut self.plain, after, faults);
        for sim in [&mut self.alone, &mut self.asked, &mut self.watched] {
            assert_eq!(disturb(sim, &mut rng.clone(), faults), answer, "{what}");
        }
        *rng = after.clone();
    }
}

#[test]
fn the_same_as_if_none_had_waited() {
    let faults: Vec<Fault> = Fault::all().collect();
    let mut moved = 0;
    for seed in 0..SEEDS {
        let mut four = Four::new(seed);
        let (mut rng, mut looks) = (Rng::new(seed), Rng::new(!seed));
        for action in 0..ACTIONS {
            let steps = [1, 7, 31, 32, 33, 150, 1_234][rng.bits() as usize % 7];
            let what = format!("seed {seed}, action {action}, after {steps} steps");
            for _ in 0..steps {
                four.tick(&mut looks, &what);
                moved += u64::from(!four.plain.world().outputs().is_still());
            }
            four.compare(&what);
            four.disturb(&mut rng, &faults, &what);
        }
    }
    assert!(moved > 20_000, "{moved} steps in motion");
}
