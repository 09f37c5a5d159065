//! A simulated monitor: the real `Device` in the simulated [`World`], on virtual time.
//!
//! Everything is a function of configuration, seed and requests; nothing reads a clock.

use std::sync::OnceLock;

use lafet_device::composition::Composition;
use lafet_device::image::AXES;
use lafet_device::port::{Port, RecordPort};
use lafet_device::{Device, Source};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::status::FaultInfo;
use lafet_proto::{Answer, Request, SubsystemId};
use lafet_update::Started;

use crate::detector::{Glare, Wall};
use crate::fire::FireSpec;
use crate::flash::{Cut, Flash};
use crate::obstacle::Obstacle;
use crate::software;
use crate::world::{STEP_MS, World, WorldConfig};

mod monitor;
mod rest;
mod trace;

use monitor::Monitor;

pub use crate::software::{Software, SoftwareFlash, Trial};

/// Steps made before it is looked whether the monitor rests, at first and at most.
const PATIENCE: [u32; 2] = [64, 4096];
/// How far ahead that is looked, in steps: ten seconds.
const AHEAD: u64 = 1_000;
/// How many steps of a monitor that moves are made at once, when nothing reads its state.
const WAITING: u32 = 32;
/// Steps made one by one after a state was read while others waited.
const WATCHED: u16 = 512;

/// What a simulation is built from.
#[derive(Clone, Debug)]
pub struct Config {
    /// Everything random comes from this.
    pub seed: u64,
    /// What the monitor is built of.
    pub composition: Composition,
    /// Its address, as the factory sets it.
    pub address: u8,
    /// What burns from the start.
    pub fires: Vec<FireSpec>,
    /// Air, °C.
    pub ambient_c: f64,
    /// Mean wind 10 m above ground, m/s: forward (azimuth 0) and left.
    pub wind: (f64, f64),
    /// Gusts: standard deviation of the wind's speed over its mean, 0.15 over open country.
    pub gusts: f64,
    /// Diameter of the nozzle's outlet, mm. The monitor's own figure is its parameter
    /// NozzleDiameter.
    pub nozzle_mm: f64,
    /// Optical axis of the detector minus barrel axis, arc-minutes: left, up.
    pub misalignment: (f64, f64),
    /// What shines without burning: the sun, a hot machine.
    pub glares: Vec<Glare>,
    /// What hides fires from the detector.
    pub walls: Vec<Wall>,
    /// True positions at the start, by axis.
    pub start: [f64; AXES],
    /// Drives whose position sensor counts from where the program has started, by axis; no remote units.
    pub relative: [bool; AXES],
    /// The monitor's clock at power-up, ms: near 2³² it soon wraps.
    pub clock_ms: u32,
    /// Memory to start with; without one it is a new monitor with the factory's parameters.
    pub flash: Option<Flash>,
    /// Software that can be updated over the link; without it the monitor does not know the request.
    pub software: Option<Software>,
    /// Keep a line of trace for each 100 ms.
    pub trace: bool,
    /// Height of the nozzle above ground, m. The monitor's own figure is its parameter Height.
    pub height_m: f64,
    /// What is around it, in its own coordinates.
    pub obstacles: Vec<Obstacle>,
    /// The ground is a [site](crate::site)'s.
    pub shared_ground: bool,
}

impl Default for Config {
    fn default() -> Self {
        let world = WorldConfig::default();
        Self {
            seed: world.seed,
            composition: Composition::FULL,
            address: 1,
            fires: Vec::new(),
            ambient_c: world.ambient_c,
            wind: world.wind,
            gusts: world.gusts,
            nozzle_mm: world.nozzle_mm,
            misalignment: world.detector.misalignment,
            glares: Vec::new(),
            walls: Vec::new(),
            start: world.start,
            relative: [false; AXES],
            clock_ms: 0,
            flash: None,
            software: None,
            trace: false,
            height_m: world.height_m,
            obstacles: Vec::new(),
            shared_ground: false,
        }
    }
}

impl Config {
    /// Takes the composition of a profile; `None` when there is none of this name.
    pub fn profile(&mut self, name: &str) -> Option<()> {
        self.composition = *Composition::by_name(name)?;
        Some(())
    }

    pub(crate) fn world(&self) -> WorldConfig {
        let mut config = WorldConfig::of(&self.composition);
        config.seed = self.seed;
        config.fires.clone_from(&self.fires);
        config.ambient_c = self.ambient_c;
        config.wind = self.wind;
        config.start = self.start;
        config.gusts = self.gusts;
        config.nozzle_mm = self.nozzle_mm;
        config.detector.misalignment = self.misalignment;
        config.detector.glares.clone_from(&self.glares);
        config.detector.walls.clone_from(&self.walls);
        config.detector.obstacles.clone_from(&self.obstacles);
        for (drive, relative) in config.drives.iter_mut().zip(self.relative) {
            drive.relative = relative;
        }
        config.height_m = self.height_m;
        config.shared_ground = self.shared_ground;
        config
    }
}

/// A simulated monitor.
///
/// A step may only count itself: that leaves thousands of monitors in the processor's cache. While
/// the monitor rests, many steps are passed over at once; while it moves, its steps wait for each
/// other, so that it is fetched from memory once for all of them. What has been counted is made up
/// for, to the very same state, before anything is looked at or changed.
#[derive(Clone, Debug)]
pub struct Sim {
    /// Steps that may be counted from now on.
    ahead: u32,
    /// Steps counted and not yet made up for.
    counted: u32,
    /// In the steps that are counted nothing happens by itself.
    rests: bool,
    /// Steps to be made before any may wait.
    watched: u16,
    /// Steps to be made before it is looked again whether it rests, and after the next time.
    patience: [u32; 2],
    /// As it was before what is counted.
    monitor: Box<Monitor>,
    /// As it is now, for who only looks, while steps are counted.
    shown: OnceLock<Box<Monitor>>,
}

impl Sim {
    /// Builds the world and powers the monitor up.
    pub fn new(config: Config) -> Self {
        // Monitors that are stepped together do not all make up for their steps in the same one.
        let apart = config.seed.wrapping_add(config.address.into()) % u64::from(WAITING);
        Self {
            ahead: 0,
            counted: 0,
            rests: false,
            watched: apart as u16,
            patience: [PATIENCE[0]; 2],
            monitor: Box::new(Monitor::new(config)),
            shown: OnceLock::new(),
        }
    }

    /// Virtual time since the simulation began, ms.
    pub fn now_ms(&self) -> u64 {
        self.monitor.world.now_ms() + u64::from(self.counted) * STEP_MS
    }

    /// Address on the bus, as the monitor knows it.
    pub fn address(&self) -> u8 {
        self.look().device.address()
    }

    /// The monitor's program.
    pub fn device(&self) -> &Device {
        &self.look().device
    }

    /// The world around it.
    pub fn world(&self) -> &World {
        &self.look().world
    }

    /// The world around it: fires to light, buttons to press, faults to inject.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.wake().world
    }

    /// Whether the program stood still in the last step: without power, or as its flash was busy.
    pub fn stood_still(&self) -> bool {
        self.look().stood_still
    }

    /// How often the program was reset by a request (§3.12, §3.19).
    pub fn resets(&self) -> u32 {
        self.look().resets
    }

    /// One step of 10 ms. While the flash is being written or erased the program is stopped.
    #[inline]
    pub fn tick(&mut self) {
        if self.ahead > 0 && self.shown.get().is_none() {
            self.ahead -= 1;
            self.counted += 1;
        } else {
            self.step();
        }
    }

    /// Moves time; a part of a step is left out.
    #[inline]
    pub fn advance_ms(&mut self, ms: u64) {
        for _ in 0..ms / STEP_MS {
            self.tick();
        }
    }

    #[inline(never)]
    fn step(&mut self) {
        let [left, next] = &mut self.patience;
        if self.shown.get().is_some() {
            // Who looks at each step makes it dearer to rest or to wait than to step.
            if self.rests {
                *next = PATIENCE[1].min(*next * 2);
                *left = *next;
            }
            self.watched = WATCHED;
        } else if self.rests && self.counted > 0 {
            *left = 1;
        }
        self.catch_up().tick();
        self.watched = self.watched.saturating_sub(1);
        let [left, next] = &mut self.patience;
        *left = left.saturating_sub(1);
        let mut resting = 0;
        if *left == 0 {
            *left = *next;
            resting = self.monitor.rests_for(AHEAD) as u32;
        }
        self.rests = resting > 0;
        self.ahead = match () {
            () if self.rests => resting,
            () if self.watched == 0 && self.monitor.may_wait() => WAITING - 1,
            () => 0,
        };
    }

    /// Makes up for the steps that were counted.
    fn catch_up(&mut self) -> &mut Monitor {
        let counted = core::mem::take(&mut self.counted);
        if !self.rests {
            self.patience[0] = self.patience[0].saturating_sub(counted);
        }
        match self.shown.take() {
            Some(shown) => self.monitor = shown,
            None => self.monitor.make_up_for(counted, self.rests),
        }
        &mut self.monitor
    }

    /// The monitor as it is now, to be changed: it no longer rests, nor may steps wait before one
    /// has been made.
    fn wake(&mut self) -> &mut Monitor {
        self.ahead = 0;
        self.catch_up()
    }

    /// The monitor as it is now.
    fn look(&self) -> &Monitor {
        if self.counted == 0 {
            return &self.monitor;
        }
        self.shown.get_or_init(|| {
            let mut shown = self.monitor.clone();
            shown.make_up_for(self.counted, self.rests);
            shown
        })
    }

    /// Gives the monitor's program something to answer. A poll leaves it as it is: it rests on.
    fn answer<T>(&mut self, answer: impl FnOnce(&mut Monitor) -> T) -> T {
        let monitor = self.catch_up();
        let answered = answer(monitor);
        if monitor.device.is_disturbed() {
            self.ahead = 0;
        } else if self.ahead > 0 && !self.rests {
            // None waits now, so as many may wait again, until it is looked whether it rests.
            self.ahead = self.patience[0].min(WAITING - 1);
        }
        answered
    }

    /// Gives the monitor the records of a frame; returns the records that it answers. Time passes
    /// when the program is stopped.
    pub fn request(&mut self, source: Source, payload: &[u8]) -> Vec<u8> {
        self.answer(|monitor| monitor.request(source, payload))
    }

    /// The program's answer at this very moment, whatever the flash is at.
    pub fn handle(&mut self, source: Source, payload: &[u8]) -> Vec<u8> {
        self.answer(|monitor| monitor.handle(source, payload))
    }

    /// Gives the monitor bytes of a stream of link frames (serial line, TCP connection), however
    /// they are cut; returns the bytes of its answer frames. Each medium has a `Port` of its own.
    pub fn receive(&mut self, port: &mut Port, bytes: &[u8]) -> Vec<u8> {
        self.answer(|monitor| monitor.receive(port, bytes))
    }

    /// The same for a connection that carries bare records.
    pub fn receive_records(&mut self, port: &mut RecordPort, bytes: &[u8]) -> Vec<u8> {
        self.answer(|monitor| monitor.receive_records(port, bytes))
    }

    /// Gives the monitor a datagram, which is one link frame; returns that of its answer.
    pub fn datagram(&mut self, source: Source, bytes: &[u8]) -> Option<Vec<u8>> {
        self.answer(|monitor| monitor.datagram(source, bytes))
    }

    /// Asks a subsystem over the wired interface and shows its first answer to `see`.
    pub fn ask(&mut self, to: SubsystemId, body: Body<'_>, mut see: impl FnMut(&Answer<'_>)) {
        let mut buffer = [0; 260];
        let mut writer = Writer::new(&mut buffer);
        if Request::new(to, body).encode(&mut writer).is_err() {
            return;
        }
        let bytes = self.request(Source::ExternalConn, writer.written());
        if let Some(Ok(record)) = Records::new(&bytes).next()
            && let Ok(answer) = Answer::decode(&record)
        {
            see(&answer);
        }
    }

    /// Moves time as [`Self::advance_ms`] does, to the very same state, but passes over times in
    /// which neither the world nor the monitor changes.
    ///
    /// The monitor rests when a step now and a step at the end of the time, with the inputs as
    /// they are, leave it as it is and drive the same: what waits for a moment in between would
    /// have come by the end. With a trace to keep, every step is made.
    pub fn pass_ms(&mut self, ms: u64) {
        self.wake().pass_ms(ms);
    }

    /// Time that has not been stepped through, ms.
    pub fn passed_over_ms(&self) -> u64 {
        self.monitor.passed_over_ms
    }

    /// Takes the supply away for half a second. What is stored survives, what was being written is
    /// torn; time in the monitor starts again.
    pub fn power_cycle(&mut self) {
        self.wake().power_cycle();
    }

    /// Power will fail in words or erases of the flash to come, for half a second each: each cut
    /// counts from the one before, the next start included. None takes back those that have not
    /// come yet.
    pub fn cut_power_at(&mut self, cuts: &[Cut]) {
        self.wake().cut_power_at(cuts);
    }

    /// The same as [`Self::cut_power_at`] in words and erases of the flash that has the software.
    pub fn cut_software_at(&mut self, cuts: &[Cut]) {
        self.wake().cut_software_at(cuts);
    }

    /// Which software runs, of software that can be updated. `None` without such, and while nothing
    /// runs: no power, no image that may be started, or one that hangs.
    pub fn running(&self) -> Option<Started> {
        if self.is_powered() { self.world().running() } else { None }
    }

    /// The flash of software that can be updated, to be kept in a file: both slots and the record. It
    /// has changed when [`World::software_chip`] counts other steps.
    pub fn software_flash(&self) -> Option<Vec<u8>> {
        self.world().software_chip().map(software::to_bytes)
    }

    /// Takes the supply away, until [`Sim::power_on`]: nothing is driven, nothing is answered.
    pub fn power_off(&mut self) {
        self.wake().power_off();
    }

    /// Gives the supply back. What is stored has survived; time in the monitor starts again.
    pub fn power_on(&mut self) {
        self.wake().power_on();
    }

    /// Whether the monitor has power.
    pub fn is_powered(&self) -> bool {
        self.monitor.powered
    }

    /// The program fails as on a hard fault: nothing is driven any more, and it starts again with
    /// what the fault handler has kept (§3.20).
    pub fn crash(&mut self, info: FaultInfo) {
        self.wake().crash(info);
    }

    /// The state in one line: true positions (° or mm), commanded speeds (°/s or mm/s), valves,
    /// water, jet, the brightest spot in the detector's view (° from its axis), fires.
    pub fn trace_line(&self) -> String {
        trace::trace_line(self.world())
    }

    /// The trace so far, if the configuration asked for one.
    pub fn trace(&self) -> Option<&str> {
        self.monitor.trace.as_deref()
    }

    /// The trace since the last call, if the configuration asked for one.
    pub fn take_trace(&mut self) -> Option<String> {
        self.monitor.trace.as_mut().map(core::mem::take)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::What;
    use lafet_device::image::Axis;
    use lafet_proto::Status;
    use lafet_proto::link::{self, Frame, WIRE_MAX};

    fn ask(sim: &mut Sim, request: Request<'_>) -> Vec<(SubsystemId, Status)> {
        let mut buffer = [0; 260];
        let mut writer = Writer::new(&mut buffer);
        request.encode(&mut writer).unwrap();
        let bytes = sim.request(Source::ExternalConn, writer.written());
        Records::new(&bytes).flatten().map(|record| (record.device, record.status)).collect()
    }

    fn wire(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
        let mut out = [0; WIRE_MAX];
        let len = link::encode(&Frame { dst, src, payload }, &mut out).unwrap();
        out[..len].to_vec()
    }

    /// §L/5, §L/6: a probe is answered with the addresses swapped; a frame for another address by
    /// no answer; a stream in single bytes gives the same as a datagram.
    #[test]
    fn frames() {
        let mut sim = Sim::new(Config { address: 5, ..Config::default() });
        assert_eq!(sim.address(), 5);
        let probe = sim.datagram(Source::Radio, &wire(5, 200, &[]));
        assert_eq!(probe, Some(wire(200, 5, &[])));
        assert_eq!(sim.datagram(Source::Radio, &wire(6, 200, &[])), None);
        let move_vertical = wire(5, 200, &[0x4D, 0x0D, 0, 2, 0, 0]);
        let denied = wire(200, 5, &[0x4D, 0xA2, 3, 0]);
        assert_eq!(sim.datagram(Source::Radio, &move_vertical), Some(denied.clone()));
        let mut port = Port::new(Source::ExternalConn);
        let mut answers = Vec::new();
        for byte in [move_vertical.clone(), wire(6, 200, &[]), move_vertical].concat() {
            answers.extend(sim.receive(&mut port, &[byte]));
        }
        assert_eq!(answers, [denied.clone(), denied].concat());
    }

    /// §3.12: the program resets, what is stored survives, the drives stand still.
    #[test]
    fn restart_and_power_cycle() {
        let mut sim = Sim::new(Config::default());
        sim.advance_ms(1000);
        let speed = [Request::new(
            SubsystemId::VERTICAL,
            Body::SetParam {
                id: lafet_proto::ParamId::of("Speed"),
                values: lafet_proto::Ints::Values(&[7]),
            },
        )];
        assert_eq!(ask(&mut sim, speed[0]), [(SubsystemId::VERTICAL, Status::ACCEPTED)]);
        sim.advance_ms(100);
        assert!(!ask(&mut sim, Request::new(SubsystemId::ALL, Body::Restart)).is_empty());
        sim.advance_ms(1000);
        assert_eq!(sim.resets(), 1);
        sim.power_cycle();
        sim.advance_ms(1000);
        let mut value = None;
        let body = Body::GetParam { id: lafet_proto::ParamId::of("Speed") };
        sim.ask(SubsystemId::VERTICAL, body, |answer| {
            if let lafet_proto::answer::Reply::Param { values, .. } = answer.data {
                value = values.iter().next();
            }
        });
        assert_eq!((value, sim.resets()), (Some(7), 1));
        let events = sim.world_mut().take_events();
        assert_eq!(events.iter().filter(|event| event.what == What::PoweredUp).count(), 2);
    }

    /// The memory can be carried over to another simulation.
    #[test]
    fn memory_is_carried_over() {
        let mut first = Sim::new(Config { address: 9, ..Config::default() });
        first.advance_ms(200);
        let flash = Flash::from_bytes(&first.world().flash.to_bytes()).unwrap();
        let second = Sim::new(Config { flash: Some(flash), ..Config::default() });
        assert_eq!(second.address(), 9);
    }

    /// The monitor's clock wraps during deployment, and nothing happens.
    #[test]
    fn clock_wraps() {
        let mut sim = Sim::new(Config { clock_ms: u32::MAX - 3000, ..Config::default() });
        sim.advance_ms(1000);
        let deploy = Request::new(SubsystemId::DEPLOYER, Body::Deploy);
        assert_eq!(ask(&mut sim, deploy), [(SubsystemId::DEPLOYER, Status::ACCEPTED)]);
        sim.advance_ms(15_000);
        assert!(sim.world().deployed());
        assert_eq!(sim.world().outputs().drives[Axis::Deployer as usize].speed_tenths, 0);
    }

    /// Steps of a monitor that does not rest wait, for each other and for nothing else.
    #[test]
    fn steps_wait_until_a_state_is_read() {
        let windy = Config { gusts: 0.2, wind: (3.0, 1.0), ..Config::default() };
        let longest = |sim: &mut Sim, steps: u16| {
            let counted = (0..steps).map(|_| {
                sim.tick();
                sim.counted
            });
            counted.max()
        };
        let mut sim = Sim::new(windy.clone());
        assert_eq!((longest(&mut sim, 1_000), sim.rests), (Some(WAITING - 1), false));
        assert_eq!(sim.now_ms(), 1_000 * STEP_MS);
        // Between polls they wait, too: of 20 steps one at most is made at once.
        for _ in 0..100 {
            assert!(longest(&mut sim, 20) >= Some(10), "{}", sim.counted);
            assert!(!sim.handle(Source::Radio, &[0xD4, 0x00, 0, 0]).is_empty());
            assert_eq!(sim.counted, 0);
        }
        assert!((0..WAITING).any(|_| longest(&mut sim, 1) == Some(5)));
        assert_eq!(sim.world().now_ms(), sim.now_ms());
        assert_eq!(longest(&mut sim, WATCHED - 1), Some(0), "after a look");
        assert_eq!(longest(&mut sim, 100), Some(WAITING - 1));
        sim.cut_power_at(&[Cut { step: 1_000, torn: crate::flash::Torn::Old }]);
        assert_eq!(longest(&mut sim, 100), Some(0), "power will fail");
        let mut traced = Sim::new(Config { trace: true, ..windy });
        assert_eq!(longest(&mut traced, 100), Some(0), "with a trace");
    }

    #[test]
    fn a_simulation_can_move_to_another_thread() {
        fn is_send<T: Send>() {}
        is_send::<Sim>();
    }
}
