//! LM3S6965 as QEMU emulates it: the line on UART0; sensors, drives and the clock are those of a
//! simulated plant at UART1; the flash is a file of the host, through semihosting.

use super::Handler;
use super::emulated::{Chip, Emulated, Serial};
use crate::register::Register;
use cortex_m::peripheral::NVIC;
use cortex_m_semihosting::syscall;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

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
pub struct Uart(usize);

impl Uart {
    fn on(base: usize) -> Self {
        Register::at(base + 0x2C).write(0x70);
        Register::at(base + 0x30).write(0x301);
        Self(base)
    }
}

impl Serial for Uart {
    fn read(&self) -> Option<u8> {
        let is_empty = Register::at(self.0 + 0x18).read() & 1 << 4 != 0;
        (!is_empty).then(|| Register::at(self.0).read() as u8)
    }

    fn put(&mut self, byte: u8) {
        while Register::at(self.0 + 0x18).read() & 1 << 5 != 0 {}
        Register::at(self.0).write(byte.into());
    }
}

/// The chip.
pub struct Lm3s6965 {
    reset_by_watchdog: bool,
}

/// Starts the board.
// Apart: what it takes meanwhile must not lie below the monitor.
#[inline(never)]
pub fn start() -> Emulated<Lm3s6965> {
    CLOCK_GATES_0.write(1 << 3);
    CLOCK_GATES_1.write(0b11);
    let reset_by_watchdog = RESET_CAUSE.read() & RESET_BY_WATCHDOG != 0;
    RESET_CAUSE.write(0);
    WATCHDOG_LOAD.write(WATCHDOG_TICKS);
    WATCHDOG_CONTROL.write(0b11);
    // SAFETY: no critical section depends on this interrupt being masked.
    unsafe { NVIC::unmask(WATCHDOG_IRQ) };
    let (line, plant) = (Uart::on(UART0), Uart::on(UART1));
    Emulated::new(Lm3s6965 { reset_by_watchdog }, line, plant, File::open(), PAGES)
}

impl Chip for Lm3s6965 {
    type Serial = Uart;
    type Flash = File;
    const PERIPHERALS: usize = UART0;

    fn reset_by_watchdog(&self) -> bool {
        self.reset_by_watchdog
    }

    fn feed_watchdog(&mut self) {
        WATCHDOG_CLEAR.write(1);
    }
}

/// A NOR flash in a file of the host.
pub struct File(usize);

/// The host refused.
#[derive(Clone, Copy, Debug)]
pub struct Refused;

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
