//! What the boards have in common that QEMU emulates: sensors, drives and the clock are those of a simulated
//! plant at a line of its own.

use crate::register::Register;
use crate::stack;
use core::arch::asm;
use cortex_m::peripheral::SCB;
use embedded_storage::nor_flash::NorFlash;
use lafet_device::guard::Passed;
#[cfg(feature = "mps2")]
use lafet_device::hal::Software;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::Inputs;
use lafet_device::store::Store;
use lafet_device::{Composition, Device};
use lafet_plant::{Decoder, Failure, GAUGE, Image, Order, Report, Unknown};
use lafet_turn::{Board, Start};

/// A serial line of a chip.
pub trait Serial {
    /// The byte that has come.
    fn read(&self) -> Option<u8>;

    /// Sends a byte.
    fn put(&mut self, byte: u8);
}

/// What belongs to one of the chips.
pub trait Chip {
    /// Its lines.
    type Serial: Serial;
    /// Where it keeps the parameters.
    type Flash: NorFlash;
    /// An address among its peripherals.
    const PERIPHERALS: usize;

    /// The watchdog has ended the last run, and the chip says so.
    fn reset_by_watchdog(&self) -> bool;

    /// The program is alive.
    fn feed_watchdog(&mut self);

    /// The part that updates its software.
    #[cfg(feature = "mps2")]
    fn software(&mut self) -> Option<&mut dyn Software>;

    /// Anything is driven from now on, or nothing.
    #[cfg(feature = "mps2")]
    fn drives(&mut self, anything: bool);
}

/// A program with the feature `panics` does so at this time of its clock, ms.
const PANICS_MS: u32 = 5_000;

const SYSTICK_CONTROL: Register = Register::at(0xE000_E010);
const SYSTICK_RELOAD: Register = Register::at(0xE000_E014);
const SYSTICK_VALUE: Register = Register::at(0xE000_E018);
const SYSTICK_MAX: u32 = 0xFF_FFFF;

/// How long the monitor takes, in ticks of a timer that counts down.
#[derive(Default)]
struct Meter {
    since: u32,
    steps: u32,
    answers: u32,
}

impl Meter {
    fn run() -> Self {
        SYSTICK_RELOAD.write(SYSTICK_MAX);
        SYSTICK_CONTROL.write(0b101);
        Self::default()
    }

    fn start(&mut self) {
        self.since = SYSTICK_VALUE.read();
    }

    fn taken(&self) -> u32 {
        self.since.wrapping_sub(SYSTICK_VALUE.read()) & SYSTICK_MAX
    }

    /// What has been taken since this was asked last.
    fn report(&mut self) -> Report {
        self.start();
        // SAFETY: counts a register down, by two instructions.
        unsafe {
            asm!("1: subs {0}, {0}, #1", "bne 1b", inout(reg) GAUGE / 2 => _);
        }
        let gauge = self.taken();
        let Self { steps, answers, .. } = core::mem::take(self);
        Report::Time { steps, answers, gauge }
    }
}

/// The board.
pub struct Emulated<C: Chip> {
    line: C::Serial,
    plant: C::Serial,
    decoder: Decoder,
    store: Store<C::Flash>,
    now_ms: u32,
    chip: C,
    meter: Meter,
    /// What was sensed made no sense.
    garbled: bool,
}

impl<C: Chip> Emulated<C> {
    /// On a chip that runs; the parameters are in so many of the first pages of its flash.
    // Made where it stays: a board takes much of the stack.
    #[inline(always)]
    pub fn new(chip: C, line: C::Serial, plant: C::Serial, flash: C::Flash, pages: u16) -> Self {
        Self {
            line,
            plant,
            decoder: Decoder::counting(),
            store: Store::mount(flash, 0, pages),
            now_ms: 0,
            chip,
            meter: Meter::run(),
            garbled: false,
        }
    }

    #[inline(never)]
    fn report(&mut self, report: &Report) {
        report.send(&mut |byte| self.plant.put(byte));
    }

    /// The order that has come now.
    fn order(&mut self) -> Option<Order<Image<'_>>> {
        while let Some(byte) = self.plant.read() {
            if self.decoder.push(byte).is_some() {
                return self.last_order();
            }
        }
        None
    }

    /// The order that came last, until another begins.
    fn last_order(&self) -> Option<Order<Image<'_>>> {
        self.decoder.last().and_then(|frame| Order::decode(frame.payload).ok())
    }

    // Apart: what it works with must not lie on top of everything else that happens at the start.
    #[inline(never)]
    fn provision(&mut self, composition: u8, address: u8) {
        let done = composition_of(composition)
            .is_some_and(|it| Device::provision(&mut self.store, it, address).is_ok());
        self.report(if done { &Report::Done } else { &Report::Failed });
    }
}

fn composition_of(index: u8) -> Option<&'static Composition> {
    Composition::ALL.get(usize::from(index))
}

fn fail<C: Chip>(failure: Failure) {
    match failure {
        Failure::Astray => {
            let nowhere = (C::PERIPHERALS | 1) as *const ();
            // SAFETY: meant to fail: nothing can be executed among the peripherals.
            unsafe { core::mem::transmute::<*const (), extern "C" fn()>(nowhere)() }
        }
        Failure::UndefinedInstruction => cortex_m::asm::udf(),
        Failure::Hang => loop {
            cortex_m::asm::nop();
        },
    }
}

impl<C: Chip> Board for Emulated<C> {
    fn start(&mut self, after_fault: bool) -> Start {
        self.report(&Report::Started { after_fault });
        loop {
            self.feed_watchdog();
            match self.order() {
                Some(Order::Start { now_ms, composition, address }) => {
                    if let Some(composition) = composition_of(composition) {
                        self.now_ms = now_ms;
                        return Start { now_ms, composition, address };
                    }
                    self.report(&Report::Failed);
                }
                Some(Order::Provision { composition, address }) => {
                    self.provision(composition, address);
                }
                // From before a reset: its answer is not waited for any more.
                Some(Order::Step { .. }) | None => {}
                Some(_) => self.report(&Report::Failed),
            }
        }
    }

    fn reset_by_watchdog(&mut self) -> bool {
        self.chip.reset_by_watchdog()
    }

    fn started(&mut self) {
        self.report(&Report::Done);
    }

    fn now_ms(&self) -> u32 {
        self.now_ms
    }

    fn due(&mut self) -> Option<u32> {
        match self.order()? {
            Order::Step { now_ms, .. } => {
                assert!(!(cfg!(feature = "panics") && now_ms >= PANICS_MS), "a test");
                self.now_ms = now_ms;
                self.meter.start();
                return Some(now_ms);
            }
            Order::MeasureTime => {
                let report = self.meter.report();
                self.report(&report);
            }
            Order::MeasureStack => self.report(&Report::Stack(stack::deepest())),
            Order::Fail(failure) => fail::<C>(failure),
            // Before the start only.
            Order::Provision { .. } | Order::Start { .. } => self.report(&Report::Failed),
        }
        None
    }

    fn stepped(&mut self) {
        self.meter.steps += self.meter.taken();
        self.report(if self.garbled { &Report::Failed } else { &Report::Done });
    }

    fn receive<'b>(&mut self, buffer: &'b mut [u8]) -> &'b [u8] {
        if cfg!(feature = "dead-link") {
            return &[];
        }
        let mut len = 0;
        for place in &mut *buffer {
            let Some(byte) = self.line.read() else { break };
            *place = byte;
            len += 1;
        }
        self.meter.start();
        buffer.get(..len).unwrap_or_default()
    }

    fn put(&mut self, byte: u8) {
        self.meter.answers += self.meter.taken();
        self.line.put(byte);
        self.meter.start();
    }

    fn release(&mut self) {
        self.meter.answers += self.meter.taken();
    }

    fn feed_watchdog(&mut self) {
        self.chip.feed_watchdog();
    }
}

impl<C: Chip> Hal for Emulated<C> {
    fn read(&mut self, inputs: &mut Inputs) {
        self.meter.steps += self.meter.taken();
        // At the power-up nothing has been sensed yet.
        if let Some(Order::Step { inputs: image, .. }) = self.last_order() {
            self.garbled = image.read(inputs) == Err(Unknown);
        }
        self.meter.start();
    }

    fn write(&mut self, outputs: &Passed) {
        self.meter.steps += self.meter.taken();
        #[cfg(feature = "mps2")]
        self.chip.drives(!outputs.is_still() || outputs.heaters.contains(&true));
        self.report(&Report::Driven(**outputs));
        self.meter.start();
    }

    fn reset(&mut self) {
        SCB::sys_reset()
    }

    #[cfg(feature = "mps2")]
    fn software(&mut self) -> Option<&mut dyn Software> {
        self.chip.software()
    }
}

impl<C: Chip> Storage for Emulated<C> {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        self.store.load(key, buffer)
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        self.store.store(key, value)
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.store.erase()
    }
}
