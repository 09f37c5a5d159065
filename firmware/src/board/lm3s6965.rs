//! LM3S6965 as QEMU emulates it: the line on UART0; sensors, drives and the clock are those of a
//! simulated plant at UART1; the flash is a file of the host, through semihosting.

use super::Handler;
use crate::register::Register;
use crate::stack;
use core::arch::asm;
use cortex_m::peripheral::{NVIC, SCB};
use cortex_m_semihosting::syscall;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::Inputs;
use lafet_device::store::Store;
use lafet_device::{Composition, Device};
use lafet_plant::{Decoder, Failure, GAUGE, Image, Order, Report, Unknown};
use lafet_turn::{Board, Start};

const RESET_CAUSE: Register = Register::at(0x400F_E05C);
const RESET_BY_WATCHDOG: u32 = 1 << 3;
const CLOCK_GATES_0: Register = Register::at(0x400F_E100);
const CLOCK_GATES_1: Register = Register::at(0x400F_E104);

const WATCHDOG: usize = 0x4000_0000;
const WATCHDOG_LOAD: Register = Register::at(WATCHDOG);
const WATCHDOG_CONTROL: Register = Register::at(WATCHDOG + 0x008);
const WATCHDOG_CLEAR: Register = Register::at(WATCHDOG + 0x00C);
/// How many interrupts the chip has.
pub const INTERRUPTS: usize = 44;
/// Interrupts that are no faults: none.
pub const HANDLERS: [Handler; 0] = [];
const WATCHDOG_IRQ: Irq = Irq(18);
/// About a second: the first time it runs out it interrupts, the second time it resets.
const WATCHDOG_TICKS: u32 = 12_000_000;

/// Where the flash is kept on the host.
const FILE: &[u8] = b"flash.bin\0";
const PAGES: u16 = 8;

#[derive(Clone, Copy)]
struct Irq(u16);

// SAFETY: numbers of the chip's own table.
unsafe impl cortex_m::interrupt::InterruptNumber for Irq {
    fn number(self) -> u16 {
        self.0
    }
}

const UART0: usize = 0x4000_C000;
const UART1: usize = 0x4000_D000;

/// A serial line; what the FIFO cannot take waits in the emulator.
struct Uart(usize);

impl Uart {
    fn on(base: usize) -> Self {
        Register::at(base + 0x2C).write(0x70);
        Register::at(base + 0x30).write(0x301);
        Self(base)
    }

    fn read(&self) -> Option<u8> {
        let is_empty = Register::at(self.0 + 0x18).read() & 1 << 4 != 0;
        (!is_empty).then(|| Register::at(self.0).read() as u8)
    }

    fn put(&self, byte: u8) {
        while Register::at(self.0 + 0x18).read() & 1 << 5 != 0 {}
        Register::at(self.0).write(byte.into());
    }
}

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
pub struct Lm3s6965 {
    line: Uart,
    plant: Uart,
    decoder: Decoder,
    store: Store<File>,
    now_ms: u32,
    reset_by_watchdog: bool,
    meter: Meter,
    /// What was sensed made no sense.
    garbled: bool,
}

/// Starts the board.
// Apart: what it takes meanwhile must not lie below the monitor.
#[inline(never)]
pub fn start() -> Lm3s6965 {
    CLOCK_GATES_0.write(1 << 3);
    CLOCK_GATES_1.write(0b11);
    let reset_by_watchdog = RESET_CAUSE.read() & RESET_BY_WATCHDOG != 0;
    RESET_CAUSE.write(0);
    WATCHDOG_LOAD.write(WATCHDOG_TICKS);
    WATCHDOG_CONTROL.write(0b11);
    SYSTICK_RELOAD.write(SYSTICK_MAX);
    SYSTICK_CONTROL.write(0b101);
    // SAFETY: no critical section depends on this interrupt being masked.
    unsafe { NVIC::unmask(WATCHDOG_IRQ) };
    Lm3s6965 {
        line: Uart::on(UART0),
        plant: Uart::on(UART1),
        decoder: Decoder::counting(),
        store: Store::mount(File::open(), 0, PAGES),
        now_ms: 0,
        reset_by_watchdog,
        meter: Meter::default(),
        garbled: false,
    }
}

impl Lm3s6965 {
    #[inline(never)]
    fn report(&self, report: &Report) {
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

fn fail(failure: Failure) {
    match failure {
        Failure::Astray => {
            let nowhere = (UART0 | 1) as *const ();
            // SAFETY: meant to fail: nothing can be executed among the peripherals.
            unsafe { core::mem::transmute::<*const (), extern "C" fn()>(nowhere)() }
        }
        Failure::UndefinedInstruction => cortex_m::asm::udf(),
        Failure::Hang => loop {
            cortex_m::asm::nop();
        },
    }
}

impl Board for Lm3s6965 {
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
        self.reset_by_watchdog
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
                self.now_ms = now_ms;
                self.meter.start();
                return Some(now_ms);
            }
            Order::MeasureTime => {
                let report = self.meter.report();
                self.report(&report);
            }
            Order::MeasureStack => self.report(&Report::Stack(stack::deepest())),
            Order::Fail(failure) => fail(failure),
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
        WATCHDOG_CLEAR.write(1);
    }
}

impl Hal for Lm3s6965 {
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
        self.report(&Report::Driven(**outputs));
        self.meter.start();
    }

    fn reset(&mut self) {
        SCB::sys_reset()
    }
}

impl Storage for Lm3s6965 {
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

/// A NOR flash in a file of the host.
struct File(usize);

/// The host refused.
#[derive(Clone, Copy, Debug)]
struct Refused;

impl NorFlashError for Refused {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

const OPEN_BOTH_WAYS: usize = 3;

impl File {
    fn open() -> Self {
        // SAFETY: name, mode and length, as the call wants them.
        Self(unsafe { syscall!(OPEN, FILE.as_ptr(), OPEN_BOTH_WAYS, FILE.len() - 1) })
    }

    fn seek(&self, offset: u32) -> Result<(), Refused> {
        // SAFETY: handle and offset, as the call wants them.
        let result = unsafe { syscall!(SEEK, self.0, offset) };
        if result == 0 { Ok(()) } else { Err(Refused) }
    }

    fn put(&self, bytes: &[u8]) -> Result<(), Refused> {
        // SAFETY: the buffer is ours and that long.
        let left = unsafe { syscall!(WRITE, self.0, bytes.as_ptr(), bytes.len()) };
        if left == 0 { Ok(()) } else { Err(Refused) }
    }
}

impl ErrorType for File {
    type Error = Refused;
}

impl ReadNorFlash for File {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        self.seek(offset)?;
        // SAFETY: the buffer is ours and that long.
        let left = unsafe { syscall!(READ, self.0, bytes.as_mut_ptr(), bytes.len()) };
        if left == 0 { Ok(()) } else { Err(Refused) }
    }

    fn capacity(&self) -> usize {
        usize::from(PAGES) * Self::ERASE_SIZE
    }
}

impl NorFlash for File {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 1024;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        const ERASED: [u8; 64] = [0xFF; 64];
        self.seek(from)?;
        for _ in (from..to).step_by(ERASED.len()) {
            self.put(&ERASED)?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        self.seek(offset)?;
        self.put(bytes)
    }
}
