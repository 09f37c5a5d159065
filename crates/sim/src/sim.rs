//! A simulated monitor: the real `Device` in the simulated [`World`], on virtual time.
//!
//! Everything is a function of configuration, seed and requests; nothing reads a clock.

use std::collections::VecDeque;

use lafet_device::composition::Composition;
use lafet_device::image::{Axis, ValveOutput};
use lafet_device::port::{self, Port, Probes, RecordPort};
use lafet_device::{Device, Source};
use lafet_proto::link::{PAYLOAD_MAX, WIRE_MAX};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::status::FaultInfo;
use lafet_proto::{Answer, Request, SubsystemId};

use crate::detector::{Glare, Wall};
use crate::event::What;
use crate::fault::axis_name;
use crate::fire::FireSpec;
use crate::flash::{Cut, Flash};
use crate::obstacle::Obstacle;
use crate::world::{STEP_MS, World, WorldConfig};

mod rest;

/// Time without power in a power cycle, ms.
const POWER_OFF_MS: u64 = 500;
const TRACE_MS: u64 = 100;

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
    /// The monitor's clock at power-up, ms: near 2³² it soon wraps.
    pub clock_ms: u32,
    /// Memory to start with; without one it is a new monitor with the factory's parameters.
    pub flash: Option<Flash>,
    /// Keep a line of trace for each 100 ms.
    pub trace: bool,
    /// Height of the nozzle above ground, m. The monitor's own figure is its parameter Height.
    pub height_m: f64,
    /// What stands around it, in its own coordinates.
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
            clock_ms: 0,
            flash: None,
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
        config.gusts = self.gusts;
        config.nozzle_mm = self.nozzle_mm;
        config.detector.misalignment = self.misalignment;
        config.detector.glares.clone_from(&self.glares);
        config.detector.walls.clone_from(&self.walls);
        config.detector.obstacles.clone_from(&self.obstacles);
        config.height_m = self.height_m;
        config.shared_ground = self.shared_ground;
        config
    }
}

/// A simulated monitor.
#[derive(Clone, Debug)]
pub struct Sim {
    device: Device,
    world: World,
    composition: Composition,
    address: u8,
    clock_ms: u32,
    booted_ms: u64,
    resets: u32,
    cuts: VecDeque<Cut>,
    powered: bool,
    stood_still: bool,
    passed_over_ms: u64,
    /// Of datagrams.
    probes: Probes,
    trace: Option<String>,
}

impl Sim {
    /// Builds the world and powers the monitor up.
    pub fn new(config: Config) -> Self {
        let mut world = World::new(config.world());
        if let Some(flash) = config.flash {
            world.flash = flash;
        } else {
            // A new chip without injected faults takes everything.
            let provisioned = Device::provision(&mut world, &config.composition, config.address);
            debug_assert_eq!(provisioned, Ok(()));
        }
        world.start_flash();
        let Config { composition, address, clock_ms, .. } = config;
        let device = Device::power_up(clock_ms, &composition, address, None, &mut world);
        world.stall();
        world.note(What::PoweredUp);
        Self {
            device,
            world,
            composition,
            address,
            clock_ms,
            booted_ms: 0,
            resets: 0,
            cuts: VecDeque::new(),
            powered: true,
            stood_still: false,
            passed_over_ms: 0,
            probes: Probes::new(),
            trace: config.trace.then(String::new),
        }
    }

    /// Virtual time since the simulation began, ms.
    pub const fn now_ms(&self) -> u64 {
        self.world.now_ms()
    }

    /// Address on the bus, as the monitor knows it.
    pub const fn address(&self) -> u8 {
        self.device.address()
    }

    /// The monitor's program.
    pub const fn device(&self) -> &Device {
        &self.device
    }

    /// The world around it.
    pub const fn world(&self) -> &World {
        &self.world
    }

    /// The world around it: fires to light, buttons to press, faults to inject.
    pub const fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// Whether the program stood still in the last step: without power, or as its flash was busy.
    pub const fn stood_still(&self) -> bool {
        self.stood_still
    }

    /// How often the program was reset by a request (§3.12, §3.19).
    pub const fn resets(&self) -> u32 {
        self.resets
    }

    /// One step of 10 ms. While the flash is being written or erased the program stands still.
    pub fn tick(&mut self) {
        self.world.advance(STEP_MS);
        self.stood_still = !self.powered || self.world.is_stalled();
        if !self.stood_still {
            self.run();
        }
        if self.now_ms().is_multiple_of(TRACE_MS) && self.trace.is_some() {
            let line = self.trace_line();
            if let Some(trace) = &mut self.trace {
                trace.push_str(&line);
                trace.push('\n');
            }
        }
    }

    fn run(&mut self) {
        self.world.flash.begin();
        self.device.step(self.device_ms(), &mut self.world);
        self.world.stall();
        if self.world.flash.chip().is_off() {
            self.power_cycle();
        } else if self.world.take_reset() {
            self.resets += 1;
            self.world.note(What::Reset);
            self.start(None);
        }
    }

    /// Moves time; a part of a step is left out.
    pub fn advance_ms(&mut self, ms: u64) {
        for _ in 0..ms / STEP_MS {
            self.tick();
        }
    }

    /// A frame that comes while the flash is busy is looked at when the program runs again.
    fn wait_for_flash(&mut self) {
        while self.world.stays_stalled() {
            self.tick();
        }
    }

    /// Gives the monitor the records of a frame; returns the records that it answers. Time passes
    /// when the program stands still.
    pub fn request(&mut self, source: Source, payload: &[u8]) -> Vec<u8> {
        if !self.powered {
            return Vec::new();
        }
        self.wait_for_flash();
        self.handle(source, payload)
    }

    /// The program's answer at this very moment, whatever the flash is at.
    pub(crate) fn handle(&mut self, source: Source, payload: &[u8]) -> Vec<u8> {
        let mut out = [0; PAYLOAD_MAX];
        let len = self.device.handle(self.device_ms(), source, payload, &mut out);
        out[..len].to_vec()
    }

    /// Gives the monitor bytes of a stream of link frames (serial line, TCP connection), however
    /// they are cut; returns the bytes of its answer frames. Each medium has a `Port` of its own.
    pub fn receive(&mut self, port: &mut Port, bytes: &[u8]) -> Vec<u8> {
        self.answers_to(bytes, |now_ms, device, rest, out| port.receive(now_ms, device, rest, out))
    }

    /// The same for a connection that carries bare records.
    pub fn receive_records(&mut self, port: &mut RecordPort, bytes: &[u8]) -> Vec<u8> {
        self.answers_to(bytes, |now_ms, device, rest, out| port.receive(now_ms, device, rest, out))
    }

    /// Gives all bytes to `receive`, which takes some of them and answers some.
    fn answers_to(
        &mut self,
        mut bytes: &[u8],
        mut receive: impl FnMut(u32, &mut Device, &[u8], &mut [u8]) -> (usize, usize),
    ) -> Vec<u8> {
        if !self.powered {
            return Vec::new();
        }
        self.wait_for_flash();
        let (mut answers, mut out) = (Vec::with_capacity(WIRE_MAX), [0; WIRE_MAX]);
        while !bytes.is_empty() {
            let now_ms = self.device_ms();
            let (taken, len) = receive(now_ms, &mut self.device, bytes, &mut out);
            answers.extend_from_slice(&out[..len]);
            bytes = &bytes[taken..];
        }
        answers
    }

    /// Gives the monitor a datagram, which is one link frame; returns that of its answer.
    pub fn datagram(&mut self, source: Source, bytes: &[u8]) -> Option<Vec<u8>> {
        if !self.powered {
            return None;
        }
        self.wait_for_flash();
        let mut out = [0; WIRE_MAX];
        let now_ms = self.device_ms();
        let len =
            port::datagram(now_ms, source, &mut self.probes, &mut self.device, bytes, &mut out)?;
        Some(out[..len].to_vec())
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

    /// Takes the supply away for half a second. What is stored survives, what was being written is
    /// torn; time in the monitor begins anew.
    pub fn power_cycle(&mut self) {
        self.world.cut_power();
        self.world.advance(POWER_OFF_MS);
        self.world.note(What::PoweredUp);
        self.start(None);
    }

    /// Power will fail in words or erases of the flash to come, for half a second each: each cut
    /// counts from the one before, the next start included. None takes back those that have not
    /// come yet.
    pub fn cut_power_at(&mut self, cuts: &[Cut]) {
        self.cuts = cuts.iter().copied().collect();
        let next = self.cuts.pop_front();
        self.world.flash.cut(next);
    }

    /// Takes the supply away, until [`Sim::power_on`]: nothing is driven, nothing is answered.
    pub fn power_off(&mut self) {
        self.world.cut_power();
        self.powered = false;
    }

    /// Gives the supply back. What is stored has survived; time in the monitor begins anew.
    pub fn power_on(&mut self) {
        if !self.powered {
            self.powered = true;
            self.world.note(What::PoweredUp);
            self.start(None);
        }
    }

    /// Whether the monitor has power.
    pub const fn is_powered(&self) -> bool {
        self.powered
    }

    /// The program fails as on a hard fault: nothing is driven any more, and it starts again with
    /// what the fault handler has kept (§3.20).
    pub fn crash(&mut self, info: FaultInfo) {
        self.world.cut_power();
        self.world.note(What::Crashed);
        self.start(Some(info));
    }

    fn start(&mut self, crash: Option<FaultInfo>) {
        if self.world.flash.chip().is_off() {
            let next = self.cuts.pop_front();
            self.world.flash.cut(next);
        }
        self.world.start_flash();
        if self.world.flash.chip().is_off() {
            return self.power_cycle();
        }
        self.booted_ms = self.now_ms();
        let Self { clock_ms, composition, address, world, .. } = self;
        self.device = Device::power_up(*clock_ms, composition, *address, crash, world);
        self.world.stall();
    }

    fn device_ms(&self) -> u32 {
        // The monitor's clock has 32 bits and wraps.
        self.clock_ms.wrapping_add((self.now_ms() - self.booted_ms) as u32)
    }

    /// The state in one line: true positions (° or mm), commanded speeds (°/s or mm/s), valves,
    /// water, jet, the brightest spot in the detector's view (° from its axis), fires.
    pub fn trace_line(&self) -> String {
        use core::fmt::Write;
        let world = &self.world;
        let outputs = world.outputs();
        let mut line = format!("t={:.2}", self.now_ms() as f64 / 1000.0);
        for axis in Axis::ALL {
            let unit = if axis == Axis::Nozzle { 1.0 } else { 60.0 };
            let position = world.drives[axis as usize].position / unit;
            let speed = f64::from(outputs.drives[axis as usize].speed_tenths) / 10.0;
            let _ = write!(line, " {}={position:.2}@{speed:.1}", axis_name(axis));
        }
        for (index, valve) in world.valves.iter().enumerate() {
            let sign = match outputs.valves[index] {
                ValveOutput::Off => '=',
                ValveOutput::Opening => '+',
                ValveOutput::Closing => '-',
            };
            let _ = write!(line, " valve{}={:.2}{sign}", index + 1, valve.opening);
        }
        let water = &world.water;
        let _ = write!(line, " p={:.2}atm q={:.1}l/s", water.pressure_atm(), water.flow_lps);
        match world.landing() {
            Some(jet) => {
                let _ = write!(line, " jet={:.2},{:.2}m", jet.at.0, jet.at.1);
            }
            None => line.push_str(" jet=-"),
        }
        match world.inputs().detector.spots[0] {
            Some(spot) => {
                let middle = |a: i16, b: i16| (f64::from(a) + f64::from(b)) / 120.0;
                let (left, up) = (middle(spot.left, spot.right), middle(spot.top, spot.bottom));
                let _ = write!(line, " spot={left:.2},{up:.2}#{}", spot.brightness);
            }
            None => line.push_str(" spot=-"),
        }
        for (index, fire) in world.fires.iter().enumerate() {
            let _ = write!(line, " fire{index}={:.3}@{:.3}", fire.heat, fire.density);
        }
        let _ = write!(line, " u={:.1}V", world.climate.voltage_v);
        line
    }

    /// The trace so far, if the configuration asked for one.
    pub fn trace(&self) -> Option<&str> {
        self.trace.as_deref()
    }

    /// The trace since the last call, if the configuration asked for one.
    pub fn take_trace(&mut self) -> Option<String> {
        self.trace.as_mut().map(core::mem::take)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::Status;
    use lafet_proto::link::{self, Frame};

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
    /// nobody; a stream in single bytes gives the same as a datagram.
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

    #[test]
    fn a_simulation_can_move_to_another_thread() {
        fn is_send<T: Send>() {}
        is_send::<Sim>();
    }
}
