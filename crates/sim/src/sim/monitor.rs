//! The device in its world, made step by step.

use std::collections::VecDeque;

use lafet_device::composition::Composition;
use lafet_device::port::{self, Port, Probes, RecordPort};
use lafet_device::{Device, Source};
use lafet_proto::link::{PAYLOAD_MAX, WIRE_MAX};
use lafet_proto::status::FaultInfo;

use super::Config;
use super::trace::trace_line;
use crate::event::What;
use crate::flash::{Chip, Cut};
use crate::software::Programs;
use crate::world::{STEP_MS, World};

/// Time without power in a power cycle, ms.
const POWER_OFF_MS: u64 = 500;
const TRACE_MS: u64 = 100;

/// The device in its world, step by step.
#[derive(Clone, Debug)]
pub(super) struct Monitor {
    pub(super) device: Device,
    pub(super) world: World,
    pub(super) composition: Composition,
    pub(super) address: u8,
    pub(super) clock_ms: u32,
    pub(super) booted_ms: u64,
    pub(super) resets: u32,
    pub(super) cuts: VecDeque<Cut>,
    /// In the flash of the software.
    pub(super) software_cuts: VecDeque<Cut>,
    /// Nothing runs until a reset at this time.
    pub(super) hung_until_ms: Option<u64>,
    pub(super) powered: bool,
    pub(super) stood_still: bool,
    pub(super) passed_over_ms: u64,
    /// Of datagrams.
    pub(super) probes: Probes,
    pub(super) trace: Option<String>,
}

impl Monitor {
    /// Builds the world and powers the monitor up.
    pub(super) fn new(config: Config) -> Self {
        let mut world = World::new(config.world());
        if let Some(flash) = config.flash {
            world.flash = flash;
        } else {
            // A new chip without injected faults takes everything.
            let provisioned = Device::provision(&mut world, &config.composition, config.address);
            debug_assert_eq!(provisioned, Ok(()));
        }
        let software = config.software.and_then(|software| Programs::new(software, config.seed));
        world.software = software.map(Box::new);
        let hung_ms = world.start_software();
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
            software_cuts: VecDeque::new(),
            hung_until_ms: hung_ms,
            powered: true,
            stood_still: false,
            passed_over_ms: 0,
            probes: Probes::new(),
            trace: config.trace.then(String::new),
        }
    }

    /// One step of 10 ms. While the flash is being written or erased the program is stopped.
    pub(super) fn tick(&mut self) {
        self.world.advance(STEP_MS);
        self.stood_still = !self.powered || self.world.is_stalled() || self.is_hung();
        if !self.stood_still {
            self.run();
        } else if self.powered && self.is_over() {
            self.start(None);
        }
        if self.world.now_ms().is_multiple_of(TRACE_MS) && self.trace.is_some() {
            let line = trace_line(&self.world);
            if let Some(trace) = &mut self.trace {
                trace.push_str(&line);
                trace.push('\n');
            }
        }
    }

    /// Whether it can make its steps later: each takes its 10 ms, and none adds to the trace.
    pub(super) fn may_wait(&self) -> bool {
        // Where power fails by itself a step takes as long as the cut.
        let ahead = self.world.software_chip().is_some_and(Chip::is_cut_ahead);
        self.trace.is_none() && !ahead && !self.world.flash.chip().is_cut_ahead()
    }

    /// Nothing runs: the bootloader has found nothing to start, or what it has started hangs.
    pub(super) const fn is_hung(&self) -> bool {
        self.hung_until_ms.is_some()
    }

    /// The reset that ends this comes now.
    fn is_over(&self) -> bool {
        self.hung_until_ms.is_some_and(|at_ms| at_ms <= self.world.now_ms())
    }

    /// It does not answer, though it has power.
    fn is_deaf(&self) -> bool {
        let software = self.world.software.as_deref();
        self.is_hung() || software.is_some_and(Programs::has_dead_link)
    }

    /// Makes up for so many steps that were counted: it has rested through them, or they have
    /// waited.
    pub(super) fn make_up_for(&mut self, steps: u32, rested: bool) {
        match rested {
            true if steps > 0 => self.rest(steps.into()),
            true => {}
            false => (0..steps).for_each(|_| self.tick()),
        }
    }

    fn run(&mut self) {
        self.world.begin_flash();
        self.device.step(self.device_ms(), &mut self.world);
        self.world.stall();
        if self.world.is_off() {
            self.power_cycle();
        } else if self.world.take_reset() {
            self.resets += 1;
            self.world.note(What::Reset);
            self.start(None);
        }
    }

    /// Whether a frame is looked at: one that comes while the flash is busy, when the program runs again.
    fn listens(&mut self) -> bool {
        if !self.powered || self.is_deaf() {
            return false;
        }
        while self.world.stays_stalled() {
            self.tick();
        }
        !self.is_deaf()
    }

    /// Gives the monitor the records of a frame; returns the records that it answers. Time passes
    /// when the program is stopped.
    pub(super) fn request(&mut self, source: Source, payload: &[u8]) -> Vec<u8> {
        if self.listens() { self.handle(source, payload) } else { Vec::new() }
    }

    /// The program's answer at this very moment, whatever the flash is at.
    pub(super) fn handle(&mut self, source: Source, payload: &[u8]) -> Vec<u8> {
        if self.is_deaf() {
            return Vec::new();
        }
        let mut out = [0; PAYLOAD_MAX];
        let len = self.device.handle(self.device_ms(), source, payload, &mut out);
        out[..len].to_vec()
    }

    /// Gives the monitor bytes of a stream of link frames (serial line, TCP connection), however
    /// they are cut; returns the bytes of its answer frames. Each medium has a `Port` of its own.
    pub(super) fn receive(&mut self, port: &mut Port, bytes: &[u8]) -> Vec<u8> {
        self.answers_to(bytes, |now_ms, device, rest, out| port.receive(now_ms, device, rest, out))
    }

    /// The same for a connection that carries bare records.
    pub(super) fn receive_records(&mut self, port: &mut RecordPort, bytes: &[u8]) -> Vec<u8> {
        self.answers_to(bytes, |now_ms, device, rest, out| port.receive(now_ms, device, rest, out))
    }

    /// Gives all bytes to `receive`, which takes some of them and answers some.
    fn answers_to(
        &mut self,
        mut bytes: &[u8],
        mut receive: impl FnMut(u32, &mut Device, &[u8], &mut [u8]) -> (usize, usize),
    ) -> Vec<u8> {
        if !self.listens() {
            return Vec::new();
        }
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
    pub(super) fn datagram(&mut self, source: Source, bytes: &[u8]) -> Option<Vec<u8>> {
        if !self.listens() {
            return None;
        }
        let mut out = [0; WIRE_MAX];
        let now_ms = self.device_ms();
        let len =
            port::datagram(now_ms, source, &mut self.probes, &mut self.device, bytes, &mut out)?;
        Some(out[..len].to_vec())
    }

    /// Takes the supply away for half a second. What is stored survives, what was being written is
    /// torn; time in the monitor starts again.
    pub(super) fn power_cycle(&mut self) {
        self.world.cut_power();
        self.world.advance(POWER_OFF_MS);
        self.world.note(What::PoweredUp);
        self.start(None);
    }

    /// Power will fail in words or erases of the flash to come, for half a second each: each cut
    /// counts from the one before, the next start included. None takes back those that have not
    /// come yet.
    pub(super) fn cut_power_at(&mut self, cuts: &[Cut]) {
        self.cuts = cuts.iter().copied().collect();
        let next = self.cuts.pop_front();
        self.world.flash.cut(next);
    }

    /// The same for the flash of the software.
    pub(super) fn cut_software_at(&mut self, cuts: &[Cut]) {
        self.software_cuts = cuts.iter().copied().collect();
        self.arm_software();
    }

    fn arm_software(&mut self) {
        let next = self.software_cuts.pop_front();
        if let Some(chip) = self.world.software_chip_mut() {
            chip.arm(next);
        }
    }

    /// Takes the supply away, until [`Sim::power_on`]: nothing is driven, nothing is answered.
    pub(super) fn power_off(&mut self) {
        self.world.cut_power();
        self.powered = false;
    }

    /// Gives the supply back. What is stored has survived; time in the monitor starts again.
    pub(super) fn power_on(&mut self) {
        if !self.powered {
            self.powered = true;
            self.world.note(What::PoweredUp);
            self.start(None);
        }
    }

    /// The program fails as on a hard fault: nothing is driven any more, and it starts again with
    /// what the fault handler has kept (§3.20).
    pub(super) fn crash(&mut self, info: FaultInfo) {
        self.world.cut_power();
        self.world.note(What::Crashed);
        self.start(Some(info));
    }

    fn start(&mut self, crash: Option<FaultInfo>) {
        let is_cut = |chip: &Chip| chip.is_off() && !chip.is_cut_ahead();
        if is_cut(self.world.flash.chip()) {
            let next = self.cuts.pop_front();
            self.world.flash.cut(next);
        }
        if self.world.software_chip().is_some_and(is_cut) {
            self.arm_software();
        }
        let hung_ms = self.world.start_software();
        if !self.world.software_chip().is_some_and(Chip::is_off) {
            self.world.start_flash();
        }
        if self.world.is_off() {
            return self.power_cycle();
        }
        self.hung_until_ms = hung_ms.map(|ms| self.world.now_ms() + ms);
        if !self.is_hung() {
            self.booted_ms = self.world.now_ms();
            let Self { clock_ms, composition, address, world, .. } = self;
            self.device = Device::power_up(*clock_ms, composition, *address, crash, world);
        }
        self.world.stall();
    }

    pub(super) fn device_ms(&self) -> u32 {
        // The monitor's clock has 32 bits and wraps.
        self.clock_ms.wrapping_add((self.world.now_ms() - self.booted_ms) as u32)
    }
}
