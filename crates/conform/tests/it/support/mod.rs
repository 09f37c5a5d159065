//! A simulated monitor on virtual time, with a layer between it and the tester where any rule can
//! be broken.

use std::io;

use lafet_conform::line::Line;
use lafet_conform::raw::{Incoming, Splitter};
use lafet_device::Source;
use lafet_sim::sim::{Config, Sim, Software};
use lafet_sim::world::STEP_MS;

/// Simulated time before the first request, ms.
const POWER_UP_MS: u64 = 200;
/// Time that an answer takes, steps.
const ANSWER_STEPS: u64 = 2;
/// §L/6
const PAYLOAD_MAX: usize = 512;
/// §L/8 Number of probes answered at once, and the time after which one more is answered, ms.
const PROBES_AT_ONCE: u64 = 255;
const PROBE_AGAIN_MS: u64 = 512;

/// The profile `full`, with software that can be updated.
pub const UPDATED: &str = "updated";
/// The board of that monitor.
pub const BOARD: &str = "bench";

/// A monitor with the configuration of a profile.
pub fn monitor(profile: &str) -> Sim {
    let mut config = Config::default();
    let updated = profile == UPDATED;
    config.profile(if updated { "full" } else { profile }).expect("a known profile");
    config.software = updated.then(|| Software { board: BOARD.to_owned(), ..Software::default() });
    let mut sim = Sim::new(config);
    sim.advance_ms(POWER_UP_MS);
    sim
}

/// The layer between the bytes and the monitor.
pub trait Between {
    /// Bytes have arrived; returns the answer.
    fn receive(&mut self, sim: &mut Sim, bytes: &[u8]) -> Vec<u8>;
    /// A step of time has passed; returns what is sent unasked.
    fn tick(&mut self, _sim: &mut Sim) -> Vec<u8> {
        Vec::new()
    }
}

/// A line on virtual time.
pub struct SimLine<B> {
    pub sim: Sim,
    pub between: B,
    out: Vec<u8>,
}

impl<B: Between> SimLine<B> {
    pub fn new(sim: Sim, between: B) -> Self {
        Self { sim, between, out: Vec::new() }
    }

    fn step(&mut self) {
        self.sim.tick();
        let more = self.between.tick(&mut self.sim);
        self.out.extend(more);
    }
}

impl<B: Between> Line for SimLine<B> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let answer = self.between.receive(&mut self.sim, bytes);
        self.out.extend(answer);
        for _ in 0..ANSWER_STEPS {
            self.step();
        }
        Ok(())
    }

    fn recv(&mut self, wait_ms: u64) -> io::Result<Vec<u8>> {
        for _ in 0..wait_ms.div_ceil(STEP_MS) {
            if !self.out.is_empty() {
                break;
            }
            self.step();
        }
        Ok(std::mem::take(&mut self.out))
    }

    fn now_ms(&self) -> u64 {
        self.sim.now_ms()
    }
}

/// §L/8 Decides which frames are answered, like the monitor's own port.
#[derive(Default)]
pub struct Ear {
    /// The monitor that was addressed in this monitor's name.
    asked: Option<u8>,
    /// Number of probes answered without a pause.
    probes: u64,
    probed_ms: u64,
}

impl Ear {
    /// Another device addressed `other` in the monitor's name.
    pub const fn note_asked(&mut self, other: u8) {
        self.asked = Some(other);
    }

    /// Whether a frame from `src` is that answer.
    pub fn is_answer(&mut self, src: u8) -> bool {
        self.asked.take_if(|other| *other == src).is_some()
    }

    /// Whether one more probe is answered.
    pub const fn admits_probe(&mut self, now_ms: u64) -> bool {
        let more = (now_ms - self.probed_ms) / PROBE_AGAIN_MS;
        self.probes = self.probes.saturating_sub(more);
        self.probed_ms += more * PROBE_AGAIN_MS;
        let admits = self.probes < PROBES_AT_ONCE;
        self.probes += admits as u64;
        admits
    }
}

/// Frames handled by the tester's own code, records by the monitor: the place where a wrong monitor
/// differs.
#[derive(Default)]
pub struct Frames {
    splitter: Splitter,
    ear: Ear,
}

impl Frames {
    /// The frames in these bytes that are for this monitor: sender and payload.
    pub fn take(&mut self, sim: &Sim, bytes: &[u8]) -> Vec<(u8, Vec<u8>)> {
        let mut taken = Vec::new();
        for incoming in bytes.iter().filter_map(|byte| self.splitter.push(*byte)) {
            let Incoming::Frame { dst, src, payload } = incoming else { continue };
            if src == sim.address() {
                self.ear.note_asked(dst);
                continue;
            }
            let for_us = dst == sim.address() && payload.len() <= PAYLOAD_MAX;
            if for_us
                && !self.ear.is_answer(src)
                && (!payload.is_empty() || self.ear.admits_probe(sim.now_ms()))
            {
                taken.push((src, payload));
            }
        }
        taken
    }
}

/// Sends a payload to the monitor itself.
pub fn ask(sim: &mut Sim, payload: &[u8]) -> Vec<u8> {
    sim.request(Source::ExternalConn, payload)
}
