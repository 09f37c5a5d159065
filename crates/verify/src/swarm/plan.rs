//! The life of a seed: what the world is, and what is done to the monitor.

use std::collections::VecDeque;

use lafet_device::image::{Axis, Place, ValveNo};
use lafet_device::{Composition, Source};
use lafet_proto::flags::{Button, GeneralFlags};
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Ints, ParamId, Request, SubsystemId};
use lafet_sim::detector::{Glare, Wall};
use lafet_sim::fault::{DriveFault, Fault, Post, SingleFault, ValveFault};
use lafet_sim::fire::FireSpec;
use lafet_sim::rng::Rng;
use lafet_sim::sim::Config;

use super::LIFE_MS;
use super::mission::{self, Step};
use super::pairs::Pair;
use super::requests::{frame, payload, pick};
use super::tally::Seen;
use super::watched::Watched;

/// The sequence of the plan is not that of the world's noise.
const PLAN_SEED: u64 = 0x5EED_0F7A_11E5_0000;
/// Frames of a flood, all within one step.
const FLOOD: usize = 100;
/// Most faults that the swarm keeps in force at a time.
const FAULTS_MAX: usize = 6;
/// How long a reset takes, and a little: requests are sent all the while, ms.
const RESET_MS: u64 = 400;

/// Its position sensors count from where the program has started: homed at one end or the other, where
/// the switches of the simulator's drives are.
const COUNTING: Composition = Composition {
    name: "counting",
    settings: &[
        (Param::VerticalHoming, 1),
        (Param::VerticalHomePosition, -915),
        (Param::HorizontalHoming, 2),
        (Param::HorizontalHomePosition, 10_815),
        (Param::NozzleHoming, 2),
        (Param::NozzleHomePosition, 60),
    ],
    ..Composition::FULL
};
/// Bits of InputFaults: the position of a drive is not known.
const NOT_HOMED: i32 = 0b111 << 8;
/// One seed of so many has it in place of its own composition.
const COUNTING_EACH: u64 = 7;

/// What a seed's world is built from.
pub fn setting(seed: u64) -> Config {
    if let Some(pair) = Pair::of(seed) {
        return pair.setting();
    }
    let mut rng = Rng::new(seed ^ PLAN_SEED.rotate_left(17));
    let counting = seed.is_multiple_of(COUNTING_EACH);
    let composition = match counting {
        true => COUNTING,
        false => Composition::ALL[(seed % Composition::ALL.len() as u64) as usize],
    };
    let between = |rng: &mut Rng, min: f64, max: f64| min + (max - min) * rng.unit();
    let fires = (0..rng.bits() % 4)
        .map(|index| FireSpec {
            azimuth_deg: libm::round(between(&mut rng, -60.0, 60.0)),
            range_m: libm::round(between(&mut rng, 18.0, 38.0)),
            size_m: between(&mut rng, 0.5, 1.5),
            growth_mps: if rng.chance(0.2) { 0.005 } else { 0.0 },
            reignites: rng.chance(0.2),
            lit: index == 0 || rng.chance(0.7),
            ..FireSpec::default()
        })
        .collect();
    let glares = (0..u64::from(rng.chance(0.3))).map(|_| Glare {
        azimuth_deg: between(&mut rng, -60.0, 60.0),
        elevation_deg: between(&mut rng, -5.0, 20.0),
        size_deg: 1.0,
        brightness: between(&mut rng, 50.0, 2000.0),
    });
    let glares = glares.collect();
    let walls = (0..u64::from(rng.chance(0.2))).map(|_| {
        let from_deg = between(&mut rng, -60.0, 40.0);
        Wall { from_deg, to_deg: from_deg + 20.0, range_m: 15.0, height_m: 3.0 }
    });
    let walls = walls.collect();
    // One life in three sees the monitor's clock wrap.
    let clock_ms = match rng.bits() % 3 {
        0 => u32::MAX - (rng.bits() % LIFE_MS) as u32,
        _ => rng.bits() as u32,
    };
    let ambient_c = pick(&mut rng, &[20.0, 20.0, 4.0, -25.0, 45.0]);
    let wind = if rng.chance(0.5) {
        (between(&mut rng, -6.0, 6.0), between(&mut rng, -6.0, 6.0))
    } else {
        (0.0, 0.0)
    };
    let misalignment = (between(&mut rng, -30.0, 30.0), between(&mut rng, -30.0, 30.0));
    Config {
        seed,
        composition,
        fires,
        ambient_c,
        wind,
        misalignment,
        glares,
        walls,
        clock_ms,
        relative: [counting, counting, counting, false],
        ..Config::default()
    }
}

/// How rough a life is.
#[derive(Clone, Copy, Debug)]
struct Temper {
    /// Of ten actions, how many are those of an operator.
    operator: u64,
    /// How often something breaks.
    faults: f64,
    /// How often the power goes.
    cuts: f64,
}

const TEMPERS: [Temper; 4] = [
    Temper { operator: 10, faults: 0.0, cuts: 0.0 },
    Temper { operator: 8, faults: 0.15, cuts: 0.01 },
    Temper { operator: 4, faults: 0.1, cuts: 0.02 },
    Temper { operator: 1, faults: 0.1, cuts: 0.02 },
];

/// A life.
pub(super) struct Life {
    rng: Rng,
    config: Config,
    temper: Temper,
    mission: VecDeque<Step>,
    next_fault: usize,
    faults: Vec<Fault>,
}

impl Life {
    pub fn new(seed: u64) -> Self {
        let mut rng = Rng::new(seed ^ PLAN_SEED);
        let temper = pick(&mut rng, &TEMPERS);
        let faults: Vec<Fault> = Fault::all().collect();
        // Consecutive seeds of a profile go through all faults.
        let next_fault = (seed / 5 * 3) as usize % faults.len();
        let config = setting(seed);
        Self { rng, config, temper, mission: VecDeque::new(), next_fault, faults }
    }

    /// Lives until the end, or until something that must never happen.
    pub fn live(&mut self, monitor: &mut Watched<'_>) {
        monitor.run(300);
        while monitor.sim.now_ms() < LIFE_MS && !monitor.failed() {
            self.disturb(monitor);
            if self.rng.bits() % 10 < self.temper.operator {
                self.operate(monitor);
            } else {
                self.harass(monitor);
            }
        }
    }

    fn operate(&mut self, monitor: &mut Watched<'_>) {
        let Some(Step { payload, ms }) = self.mission.pop_front() else {
            let mission = self.next_mission(monitor);
            self.mission.extend(mission);
            return;
        };
        let source = self.source();
        monitor.request(source, &payload);
        // Looked on in parts, so that something can come between.
        let mut left_ms = ms;
        while left_ms > 0 && !monitor.failed() {
            let part_ms = left_ms.min(4_000);
            monitor.run(part_ms);
            left_ms -= part_ms;
            if left_ms > 0 {
                self.disturb(monitor);
            }
        }
    }

    fn next_mission(&mut self, monitor: &Watched<'_>) -> Vec<Step> {
        let locked = monitor.told().general & GeneralFlags::LOCKED_OUT.bits() != 0;
        if locked {
            return mission::lock_out(&mut self.rng);
        }
        let not_homed = monitor.sim.device().input_faults() & NOT_HOMED != 0;
        let rng = &mut self.rng;
        if not_homed && rng.chance(0.5) {
            return mission::home();
        }
        match rng.bits() % 20 {
            0 => mission::service(&self.config.composition),
            1 => mission::erase(&self.config.composition),
            2 | 3 => mission::lock_out(rng),
            4 => mission::justify(),
            5..=7 => mission::fold(rng),
            8..=10 => mission::aim(rng),
            11 => mission::leave_open(rng),
            _ => mission::extinguish(rng, &self.config.fires),
        }
    }

    /// Something breaks, is repaired, or the power goes.
    fn disturb(&mut self, monitor: &mut Watched<'_>) {
        if self.rng.chance(self.temper.faults) {
            for _ in 0..1 + self.rng.bits() % 2 {
                self.breaks(monitor);
            }
        }
        let active = monitor.sim.world().faults.active();
        if !active.is_empty() && self.rng.chance(0.2) {
            let fault = pick(&mut self.rng, active);
            match self.rng.bits() % 3 {
                0 => monitor.clear_all(),
                _ => monitor.clear(fault),
            }
        }
        if self.rng.chance(self.temper.cuts) {
            match self.rng.bits() % 3 {
                0 => monitor.crash(),
                _ => monitor.power_cut(),
            }
        }
    }

    fn breaks(&mut self, monitor: &mut Watched<'_>) {
        if monitor.sim.world().faults.active().len() >= FAULTS_MAX {
            return monitor.clear_all();
        }
        let fault = match self.rng.bits() % 4 {
            0 => self.faults[self.rng.bits() as usize % self.faults.len()],
            1 => telling(&mut self.rng),
            _ => {
                self.next_fault = (self.next_fault + 1) % self.faults.len();
                self.faults[self.next_fault]
            }
        };
        monitor.inject(fault);
    }

    /// Random and hostile things.
    fn harass(&mut self, monitor: &mut Watched<'_>) {
        match self.rng.bits() % 24 {
            0..=2 => self.buttons_against(monitor),
            3 => {
                let frame = frame(&mut self.rng);
                let garbage = self.garbage();
                monitor.request_behind(&garbage, &frame);
            }
            4 => self.flood(monitor),
            5 => self.during_reset(monitor),
            6 => {
                // More answers than fit, and a stop behind them.
                let status = payload(&Request::new(SubsystemId::ALL, Body::GetStatus));
                let last = pick(&mut self.rng, &[Body::Stop, Body::GetStatus]);
                let mut frame: Vec<u8> = status.repeat(4 + (self.rng.bits() % 4) as usize);
                frame.extend(payload(&Request::new(SubsystemId::ALL, last)));
                let source = self.source();
                monitor.request(source, &frame);
            }
            7 => {
                // Both interfaces at once, one against the other.
                for source in [Source::Radio, Source::ExternalConn] {
                    let far = pick(&mut self.rng, &[21_600, -21_600]);
                    let to = pick(&mut self.rng, &[SubsystemId::VERTICAL, SubsystemId::HORIZONTAL]);
                    let destination = Body::Move { destination: far };
                    monitor.request(source, &payload(&Request::new(to, destination)));
                }
            }
            8 => self.narrow_the_limits(monitor),
            9 => {
                let to = pick(&mut self.rng, &[SubsystemId::ALL, SubsystemId::MOTORS]);
                let source = self.source();
                monitor.request(source, &payload(&Request::new(to, Body::Stop)));
            }
            _ => {
                let source = self.source();
                let frame = frame(&mut self.rng);
                monitor.request(source, &frame);
            }
        }
        let ms = match self.rng.bits() % 4 {
            0 => 10,
            1 => self.rng.bits() % 300,
            _ => self.rng.bits() % 3_000,
        };
        monitor.run(ms);
        let locked = monitor.told().general & GeneralFlags::LOCKED_OUT.bits() != 0;
        if locked && self.rng.chance(0.3) {
            let source = self.source();
            monitor.request(source, &payload(&Request::lockout(false)));
        }
    }

    /// Buttons of both posts, against each other and against requests.
    fn buttons_against(&mut self, monitor: &mut Watched<'_>) {
        for _ in 0..1 + self.rng.bits() % 3 {
            let post = pick(&mut self.rng, Post::ALL);
            let button = pick(&mut self.rng, &Button::ALL);
            monitor.press(post, button, true);
            monitor.run(self.rng.bits() % 1_500);
        }
        if self.rng.chance(0.5) {
            let source = self.source();
            let frame = frame(&mut self.rng);
            monitor.request(source, &frame);
            monitor.run(self.rng.bits() % 500);
        }
        if self.rng.chance(0.8) {
            for post in Post::ALL {
                for button in Button::ALL {
                    monitor.press(*post, button, false);
                }
            }
        }
    }

    /// Turns a drive back, and takes the limits in behind it, while it still runs on.
    fn narrow_the_limits(&mut self, monitor: &mut Watched<'_>) {
        let axis = pick(&mut self.rng, &[Axis::Vertical, Axis::Horizontal]);
        let source = self.source();
        let moved = |destination| payload(&Request::new(axis.id(), Body::Move { destination }));
        monitor.request(source, &moved(i16::MAX));
        monitor.run(500 + self.rng.bits() % 2_000);
        let at = monitor.sim.world().inputs().drives[axis as usize].position;
        let values = [at.saturating_add(10)];
        let (id, values) = (ParamId::of("MaxLimit"), Ints::Values(&values));
        let narrower = payload(&Request::new(axis.id(), Body::SetParam { id, values }));
        let back = moved(at.saturating_sub(100).clamp(i16::MIN.into(), i16::MAX.into()) as i16);
        monitor.request(source, &[back, narrower].concat());
    }

    fn flood(&mut self, monitor: &mut Watched<'_>) {
        monitor.see(Seen::Flood);
        for _ in 0..FLOOD {
            let source = self.source();
            let frame = frame(&mut self.rng);
            monitor.request(source, &frame);
        }
    }

    /// Requests in every step of a reset.
    fn during_reset(&mut self, monitor: &mut Watched<'_>) {
        let source = self.source();
        monitor.request(source, &payload(&Request::new(SubsystemId::ALL, Body::Restart)));
        for _ in 0..RESET_MS / lafet_sim::world::STEP_MS {
            let source = self.source();
            let frame = frame(&mut self.rng);
            monitor.request(source, &frame);
            monitor.run(lafet_sim::world::STEP_MS);
        }
    }

    fn garbage(&mut self) -> Vec<u8> {
        let len = self.rng.bits() % 64;
        let special = [0xC0, 0xDB, 0xDC, 0xDD, 0xFF, 0];
        (0..len)
            .map(|_| match self.rng.bits() % 3 {
                0 => pick(&mut self.rng, &special),
                _ => self.rng.bits() as u8,
            })
            .collect()
    }

    fn source(&mut self) -> Source {
        if self.rng.chance(0.5) { Source::Radio } else { Source::ExternalConn }
    }
}

/// Faults whose rules are hard to meet otherwise.
fn telling(rng: &mut Rng) -> Fault {
    let axis = pick(rng, &Axis::ALL);
    let valve = pick(rng, &ValveNo::ALL);
    pick(
        rng,
        &[
            Fault::Drive(axis, DriveFault::Jam),
            Fault::Drive(axis, DriveFault::Friction),
            Fault::Valve(valve, ValveFault::Jam),
            Fault::Valve(valve, ValveFault::Blocked),
            Fault::Valve(valve, ValveFault::CloseSwitch),
            Fault::Valve(valve, ValveFault::CloseStuck),
            Fault::Drive(Axis::Deployer, DriveFault::MinSwitch),
            Fault::Heater(Place::Box),
            Fault::Temperature(Place::Vertical),
            Fault::Single(SingleFault::PumpWeak),
        ],
    )
}
