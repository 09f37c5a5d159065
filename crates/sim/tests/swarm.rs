//! Random requests, buttons, faults, resets and power cuts, with checks in every step of 10 ms.
//!
//! A failure names the seed that replays it. Beside what must never happen stands what must have
//! happened in some run: a monitor that does nothing would pass the first part.

use lafet_device::Source;
use lafet_device::composition::Composition;
use lafet_device::image::{Axis, ValveOutput};
use lafet_proto::SubsystemId;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{Button, GeneralFlags};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::text;
use lafet_sim::event::What;
use lafet_sim::fault::{DriveFault, Fault, Post};
use lafet_sim::rng::Rng;
use lafet_sim::sim::{Config, Sim};

const SEEDS: u64 = 60;
const ACTIONS: u32 = 120;

const REQUESTS: &[&str] = &[
    "Deploy Deployer",
    "Deploy Deployer",
    "Deploy Deployer",
    "Wrap Deployer",
    "Move Vertical 900",
    "Move Vertical -21600",
    "Move Horizontal 3000",
    "Move Horizontal -21600",
    "Move Nozzle 20",
    "Move Deployer 2700",
    "Open Valve1",
    "Open Valve1",
    "Open Valve2",
    "Close Valve1",
    "Close Valve2",
    "Stop All",
    "Stop Deployer",
    "Stop Valve1",
    "Stop Control",
    "Stop Detector",
    "StartSeek Detector -1800 1800 -300 300",
    "StartQuench Control centre=600,-100 nozzle=60 sector=240,60 step=1 distance=25",
    "StartTrajectory Control ballistics repeat point=0,0,20,10 point=600,0,25,10",
    "StartJustify Detector",
    "SwitchLimits Horizontal off",
    "SwitchLimits Horizontal on",
    "SetParam Vertical Speed 5",
    "Lockout All on",
    "Lockout All off",
    "Lockout All off",
    "Lockout All off",
    "Restart All",
    "GetStatus All",
    "Deploy Deployer ; Open Valve1",
];

/// What was seen in all runs together.
#[derive(Default)]
struct Seen {
    jet: u32,
    deployed: u32,
    wrapped_again: u32,
    locked: u32,
    resets: u32,
    extinguished: u32,
}

struct Run {
    seed: u64,
    sim: Sim,
    rng: Rng,
    locked_ms: u64,
    was_deployed: bool,
}

#[test]
fn nothing_forbidden_happens_and_everything_possible_does() {
    let mut seen = Seen::default();
    for seed in 0..SEEDS {
        let composition = Composition::ALL[(seed % 5) as usize];
        let fires = vec!["az=10,range=25,size=1,reignites=1".parse().expect("a fire")];
        let sim = Sim::new(Config { seed, composition, fires, ..Config::default() });
        let mut run = Run { seed, sim, rng: Rng::new(seed), locked_ms: 0, was_deployed: false };
        for _ in 0..ACTIONS {
            run.act();
            let ms = 50 + run.rng.bits() % 4_000;
            for _ in 0..ms / 10 {
                run.sim.tick();
                run.check(&mut seen);
            }
        }
        seen.resets += run.sim.resets();
    }
    let Seen { jet, deployed, wrapped_again, locked, resets, extinguished } = seen;
    let counts = [jet, deployed, wrapped_again, locked, resets, extinguished];
    assert!(counts.iter().all(|count| *count > 0), "never witnessed: {counts:?}");
}

impl Run {
    fn act(&mut self) {
        match self.rng.bits() % 40 {
            0 => self.sim.power_cycle(),
            1 => {
                let faults: Vec<Fault> = Fault::all().filter(|fault| !lies(*fault)).collect();
                let fault = faults[self.rng.bits() as usize % faults.len()];
                self.sim.world_mut().inject(fault);
            }
            2..=4 => self.sim.world_mut().clear_all(),
            5..=8 => {
                let post = Post::ALL[self.rng.bits() as usize % 2];
                let button = Button::ALL[self.rng.bits() as usize % 8];
                let pressed = self.rng.chance(0.5);
                self.sim.world_mut().press(post, button, pressed);
            }
            9 => {
                let bytes: Vec<u8> =
                    (0..self.rng.bits() % 40).map(|_| self.rng.bits() as u8).collect();
                self.ask(&bytes);
            }
            _ => {
                let request = REQUESTS[self.rng.bits() as usize % REQUESTS.len()];
                self.ask(&payload(request));
            }
        }
    }

    /// Every frame gets an answer, and the answer is made of whole records.
    fn ask(&mut self, payload: &[u8]) {
        let source = if self.rng.chance(0.5) { Source::Radio } else { Source::ExternalConn };
        let answer = self.sim.request(source, payload);
        let seed = self.seed;
        assert_eq!(answer.is_empty(), payload.is_empty(), "seed {seed}: {payload:02x?}");
        assert!(Records::new(&answer).all(|record| record.is_ok()), "seed {seed}: {answer:02x?}");
    }

    fn check(&mut self, seen: &mut Seen) {
        let seed = self.seed;
        let events = self.sim.world_mut().take_events();
        let sim = &self.sim;
        let at = || sim.trace_line();
        let world = sim.world();
        let outputs = world.outputs();
        let opening = outputs.valves.contains(&ValveOutput::Opening);
        let speed = |axis: Axis| outputs.drives[axis as usize].speed_tenths;
        let still = Axis::ALL.iter().all(|axis| speed(*axis) == 0);
        if !world.deployed() {
            let aims = speed(Axis::Vertical) != 0 || speed(Axis::Horizontal) != 0;
            // The guard sees the switch of the step before.
            assert!(!opening || self.was_deployed, "seed {seed}: water while folded\n{}", at());
            assert!(!aims || self.was_deployed, "seed {seed}: aims while folded\n{}", at());
        }
        let (deployed, jet) = (world.deployed(), world.water.jet_lps() > 0.0);
        seen.deployed += u32::from(deployed && !self.was_deployed);
        seen.wrapped_again += u32::from(!deployed && self.was_deployed);
        seen.jet += u32::from(jet);
        self.was_deployed = deployed;
        for event in events {
            assert_ne!(event.what, What::FoldedBarrelFlooded, "seed {seed}: flooded\n{}", at());
            seen.extinguished += u32::from(matches!(event.what, What::FireOut(_)));
        }
        let locked = self.is_locked();
        self.locked_ms = if locked { self.locked_ms + 10 } else { 0 };
        // The step after the request is the first that obeys it; a remote unit hears it later.
        if self.locked_ms > 10 {
            assert!(
                still && !opening,
                "seed {seed}: moves while locked out\n{}",
                self.sim.trace_line()
            );
            seen.locked += 1;
        }
    }

    fn is_locked(&mut self) -> bool {
        let mut locked = false;
        self.sim.ask(SubsystemId::GENERAL, Body::GetStatus, |answer| {
            if let Reply::General(status) = answer.data {
                locked = status.flags.contains(GeneralFlags::LOCKED_OUT);
            }
        });
        locked
    }
}

/// Switches that lie about deployment: nobody can know better.
fn lies(fault: Fault) -> bool {
    matches!(fault, Fault::Drive(Axis::Deployer, DriveFault::MinSwitch | DriveFault::MaxSwitch))
}

fn payload(requests: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    for request in requests.split(';') {
        let (mut buffer, mut record) = ([0; text::BUFFER_SIZE], [0; 260]);
        let mut writer = Writer::new(&mut record);
        let request = text::parse(request.trim(), &mut buffer).expect("a request");
        request.encode(&mut writer).expect("it fits");
        bytes.extend_from_slice(writer.written());
    }
    bytes
}
