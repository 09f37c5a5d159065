//! Two faults at once: every pair of the simulator's faults, one pair a life.
//!
//! Such a life is short. The barrel is deployed, with water on or without, or stowed. What the two
//! faults concern is set to work, again and again; each fault comes before the work or in the midst of it.
//! At last something ends it: a stop, a lockout, a stowing, a reset, a power cut, a repair.
//!
//! The seeds from [`PAIRS_SEED`] on are such lives. The first [`pairs`] of them are a round, which has each
//! pair once; the lives of later rounds are longer, and do other things.

use lafet_device::composition::DriveKind;
use lafet_device::image::{AXES, Axis, Unit, ValveNo};
use lafet_device::{Composition, Source};
use lafet_proto::flags::Button;
use lafet_proto::request::{Body, Quench, Sector, Seek};
use lafet_proto::{Ints, ParamId, Request, SubsystemId};
use lafet_sim::fault::{Fault, Post, SingleFault};
use lafet_sim::fire::FireSpec;
use lafet_sim::rng::Rng;
use lafet_sim::sim::Config;

use super::requests::{frame, number, payload, pick};
use super::watched::Watched;

/// The first life of pairs.
pub const PAIRS_SEED: u64 = 1 << 32;
/// How long the lives of a round are, ms: those of the first round, of the second, of all others.
const LIFE_MS: [u64; 3] = [4_000, 10_000, 30_000];
/// From one pair to the next, so that a part of a round has some of everything; a prime number.
const STRIDE: u64 = 7_919;
/// Until the outputs are not inert any more, ms.
const SETTLED_MS: u64 = 150;
/// Its sequence is neither that of the world's noise nor that of the other lives' plans.
const PLAN_SEED: u64 = 0xFA_1750_0F2A_1750;

/// How many pairs there are: as many lives are a round.
pub fn pairs() -> u64 {
    let faults = Fault::all().count() as u64;
    faults * (faults - 1) / 2
}

/// The two faults of a life; `None` for a seed that is no life of pairs.
pub fn pair(seed: u64) -> Option<[Fault; 2]> {
    let life = seed.checked_sub(PAIRS_SEED)?;
    let faults: Vec<Fault> = Fault::all().collect();
    let mut rest = (life % pairs() * STRIDE % pairs()) as usize;
    for (index, first) in faults.iter().enumerate() {
        let others = &faults[index + 1..];
        match others.get(rest) {
            Some(second) => return Some([*first, *second]),
            None => rest -= others.len(),
        }
    }
    None
}

/// A life with two faults.
pub(super) struct Pair {
    rng: Rng,
    faults: [Fault; 2],
    until_ms: u64,
    config: Config,
}

impl Pair {
    /// The life of a seed; `None` for a seed that is no life of pairs.
    pub fn of(seed: u64) -> Option<Self> {
        let mut faults = pair(seed)?;
        let mut rng = Rng::new(seed ^ PLAN_SEED);
        let suits = |profile: &Composition| faults.iter().all(|fault| concerns(*fault, profile));
        let profiles: Vec<Composition> = Composition::ALL.into_iter().filter(suits).collect();
        if rng.chance(0.5) {
            faults.reverse();
        }
        let round = (seed - PAIRS_SEED) / pairs();
        let until_ms = LIFE_MS[round.min(LIFE_MS.len() as u64 - 1) as usize];
        let config = setting(seed, pick(&mut rng, &profiles), until_ms, &mut rng);
        Some(Self { rng, faults, until_ms, config })
    }

    /// What its world is built from.
    pub fn setting(self) -> Config {
        self.config
    }

    /// Lives until the end, or until something that must never happen.
    pub fn live(&mut self, monitor: &mut Watched<'_>) {
        let deployed = monitor.sim.world().deployed();
        if deployed && self.rng.chance(0.3) {
            // The program begins with water on, and closes it.
            monitor.sim.world_mut().valves[ValveNo::Valve1 as usize].opening = 1.0;
        }
        monitor.run(SETTLED_MS);
        let [first, second] = self.faults;
        let late = [self.rng.chance(0.5), self.rng.chance(0.5)];
        for (fault, late) in self.faults.into_iter().zip(late) {
            if !late {
                monitor.inject(fault);
            }
        }
        self.work(monitor, first);
        self.pause(monitor);
        self.work(monitor, second);
        for (fault, late) in self.faults.into_iter().zip(late) {
            if late {
                self.pause(monitor);
                monitor.inject(fault);
            }
        }
        while monitor.sim.now_ms() < self.until_ms / 4 * 3 && !monitor.failed() {
            self.pause(monitor);
            let fault = pick(&mut self.rng, &self.faults);
            self.work(monitor, fault);
        }
        if !monitor.failed() {
            self.end(monitor);
        }
        let now_ms = monitor.sim.now_ms();
        monitor.run(self.until_ms.saturating_sub(now_ms));
    }

    fn pause(&mut self, monitor: &mut Watched<'_>) {
        monitor.run(10 + self.rng.below(self.until_ms / 6));
    }

    /// Sets to work what a fault concerns.
    fn work(&mut self, monitor: &mut Watched<'_>, fault: Fault) {
        match fault {
            _ if self.rng.chance(0.15) => {
                let frame = frame(&mut self.rng);
                let source = self.source();
                monitor.request(source, &frame);
            }
            Fault::Drive(axis, _) => self.drive(monitor, axis),
            Fault::Valve(valve, _) => self.water(monitor, valve.id()),
            Fault::Unit(unit, _) => self.unit(monitor, unit),
            Fault::Temperature(_)
            | Fault::TemperatureFrozen(_)
            | Fault::TemperatureDrift(_)
            | Fault::Heater(_) => self.drive(monitor, Axis::Horizontal),
            Fault::Button(post, button, _) => {
                let pressed = self.rng.chance(0.6);
                monitor.press(post, button, pressed);
            }
            Fault::Single(fault) => self.plant(monitor, fault),
        }
    }

    fn drive(&mut self, monitor: &mut Watched<'_>, axis: Axis) {
        let destination = number(&mut self.rng, -12_000, 12_000) as i16;
        let body = match (axis, self.rng.bits() % 6) {
            (Axis::Deployer, 0..=2) => Body::Wrap,
            (Axis::Deployer, 3 | 4) => Body::Deploy,
            (Axis::Deployer, _) => Body::Move { destination: destination / 2 },
            (_, 0) => {
                let (post, pressed) = (pick(&mut self.rng, Post::ALL), self.rng.chance(0.6));
                let button = pick(&mut self.rng, &buttons(axis));
                return monitor.press(post, button, pressed);
            }
            (_, 1) => return self.ask(monitor, SubsystemId::CONTROL, quench(destination / 4)),
            (_, 2) => Body::Stop,
            _ => Body::Move { destination },
        };
        self.ask(monitor, axis.id(), body);
    }

    fn water(&mut self, monitor: &mut Watched<'_>, id: SubsystemId) {
        let request = match self.rng.bits() % 5 {
            0..=2 => Request::open(id),
            3 => Request::close(id),
            _ => Request::new(SubsystemId::DEPLOYER, Body::Wrap),
        };
        let source = self.source();
        monitor.request(source, &payload(&request));
    }

    fn unit(&mut self, monitor: &mut Watched<'_>, unit: Unit) {
        let axis = Axis::ALL.into_iter().find(|axis| axis.unit() == unit);
        let valve = ValveNo::ALL.into_iter().find(|valve| valve.unit() == unit);
        let name = if axis.is_some() { "Speed" } else { "TravelTime" };
        let id = match (axis, valve) {
            (Some(axis), _) => axis.id(),
            (_, valve) => valve.unwrap_or(ValveNo::Valve1).id(),
        };
        match (self.rng.bits() % 4, axis) {
            (0, _) => self.ask(monitor, id, Body::GetParam { id: ParamId::of(name) }),
            (_, Some(axis)) => self.drive(monitor, axis),
            (_, None) => self.water(monitor, id),
        }
    }

    /// What exists once.
    fn plant(&mut self, monitor: &mut Watched<'_>, fault: SingleFault) {
        match fault {
            SingleFault::DetectorDead | SingleFault::DetectorSaturated | SingleFault::DirtyLens => {
                let seek =
                    Seek { start_h: -300, end_h: 1_500, start_v: -300, end_v: 120, analyse: 0 };
                self.ask(monitor, SubsystemId::DETECTOR, Body::StartSeek(seek));
            }
            SingleFault::FlashRead | SingleFault::FlashWrite => {
                let values = [number(&mut self.rng, 1, 25)];
                let (id, values) = (ParamId::of("Speed"), Ints::Values(&values));
                match self.rng.bits() % 4 {
                    0 => monitor.power_cut(),
                    1 => self.lock(monitor, true),
                    2 => self.lock(monitor, false),
                    _ => self.ask(monitor, SubsystemId::VERTICAL, Body::SetParam { id, values }),
                }
            }
            SingleFault::Humidity
            | SingleFault::VoltageLow
            | SingleFault::VoltageHigh
            | SingleFault::SupplyDip
            | SingleFault::SupplySag => {
                let axis = pick(&mut self.rng, &Axis::ALL);
                self.drive(monitor, axis);
            }
            SingleFault::PressureBreak
            | SingleFault::PressureShort
            | SingleFault::PressureFrozen
            | SingleFault::PressureDrift
            | SingleFault::FlowFrozen
            | SingleFault::FlowDrift
            | SingleFault::PumpOff
            | SingleFault::PumpWeak => self.water(monitor, SubsystemId::VALVE1),
        }
    }

    /// What ends it.
    fn end(&mut self, monitor: &mut Watched<'_>) {
        match self.rng.bits() % 10 {
            0 | 1 => self.ask(monitor, SubsystemId::ALL, Body::Stop),
            2 => self.lock(monitor, true),
            3 => self.ask(monitor, SubsystemId::DEPLOYER, Body::Wrap),
            4 => {
                let source = self.source();
                monitor.request(source, &payload(&Request::close(SubsystemId::VALVE1)));
            }
            5 => self.ask(monitor, SubsystemId::ALL, Body::Restart),
            6 => monitor.power_cut(),
            7 => monitor.crash(),
            8 => monitor.clear_all(),
            _ => {}
        }
    }

    fn lock(&mut self, monitor: &mut Watched<'_>, on: bool) {
        let source = self.source();
        monitor.request(source, &payload(&Request::lockout(on)));
    }

    fn ask(&mut self, monitor: &mut Watched<'_>, to: SubsystemId, body: Body<'_>) {
        let source = self.source();
        monitor.request(source, &payload(&Request::new(to, body)));
    }

    fn source(&mut self) -> Source {
        if self.rng.chance(0.5) { Source::Radio } else { Source::ExternalConn }
    }
}

fn setting(seed: u64, composition: Composition, until_ms: u64, rng: &mut Rng) -> Config {
    let mut start = Config::default().start;
    start[Axis::Vertical as usize] = f64::from(number(rng, 0, 3_000));
    start[Axis::Horizontal as usize] = f64::from(number(rng, -6_000, 6_000));
    start[Axis::Nozzle as usize] = f64::from(number(rng, 0, 60));
    if rng.chance(0.8) {
        start[Axis::Deployer as usize] = 5_400.0;
    }
    let clock_ms = match rng.bits() % 3 {
        0 => u32::MAX - rng.below(until_ms) as u32,
        _ => rng.bits() as u32,
    };
    let fire = FireSpec { azimuth_deg: 10.0, range_m: 25.0, size_m: 1.0, ..FireSpec::default() };
    Config {
        seed,
        composition,
        fires: vec![fire],
        ambient_c: pick(rng, &[20.0, 4.0, -25.0]),
        start,
        clock_ms,
        ..Config::default()
    }
}

/// Whether a monitor has the part that a fault concerns.
fn concerns(fault: Fault, profile: &Composition) -> bool {
    let has = |id| profile.chain.contains(id);
    match fault {
        Fault::Drive(axis, _) => has(axis.id()),
        Fault::Valve(valve, _) => has(valve.id()),
        Fault::Temperature(_)
        | Fault::TemperatureFrozen(_)
        | Fault::TemperatureDrift(_)
        | Fault::Heater(_) => has(SubsystemId::CLIMATICS),
        Fault::Unit(unit, _) => match (unit as usize).checked_sub(AXES) {
            None => profile.drives[unit as usize] == DriveKind::Remote,
            Some(valve) => profile.remote_valves[valve],
        },
        Fault::Button(Post::Buttons, ..) => has(SubsystemId::BUTTONS),
        Fault::Button(Post::ExtButtons, ..) => has(SubsystemId::EXT_BUTTONS),
        Fault::Single(
            SingleFault::DetectorDead | SingleFault::DetectorSaturated | SingleFault::DirtyLens,
        ) => has(SubsystemId::DETECTOR),
        Fault::Single(SingleFault::Humidity) => has(SubsystemId::CLIMATICS),
        Fault::Single(_) => true,
    }
}

const fn buttons(axis: Axis) -> [Button; 2] {
    match axis {
        Axis::Vertical | Axis::Deployer => [Button::Up, Button::Down],
        Axis::Horizontal => [Button::Left, Button::Right],
        Axis::Nozzle => [Button::Wide, Button::Narrow],
    }
}

/// A sector beside the fire, or on it.
const fn quench(azimuth: i16) -> Body<'static> {
    let sector =
        Sector { centre_h: azimuth, centre_v: 0, nozzle: 40, width: 240, height: 60, step: 1 };
    Body::StartQuench(Quench::Full { sector, distance: 25 })
}
