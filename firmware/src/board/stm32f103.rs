//! STM32F103VC: `lafet-stm32f103` on the chip itself.

use super::Handler;
use core::cell::UnsafeCell;
use cortex_m::peripheral::SCB;
use lafet_stm32f103::line::{self, RECEIVED, SENT};
use lafet_stm32f103::{Bus, Memory, Stm32f103, analog};

/// How many interrupts the chip has.
pub const INTERRUPTS: usize = 60;
/// The line's.
pub const HANDLERS: [Handler; 1] = [(line::IRQ as usize, usart1)];

/// Memory that the DMA fills and empties.
#[repr(C, align(4))]
struct Shared<const N: usize>(UnsafeCell<[u8; N]>);

// SAFETY: it is reached by address alone, in accesses that are whole on this chip.
unsafe impl<const N: usize> Sync for Shared<N> {}

impl<const N: usize> Shared<N> {
    const fn new() -> Self {
        Self(UnsafeCell::new([0; N]))
    }

    fn address(&self) -> u32 {
        self.0.get() as u32
    }
}

static RECEIVE_RING: Shared<RECEIVED> = Shared::new();
static SEND_RING: Shared<SENT> = Shared::new();
static SAMPLES: Shared<{ analog::BYTES }> = Shared::new();

/// The chip.
#[derive(Clone, Copy)]
pub struct Chip;

impl Bus for Chip {
    fn read(&self, address: u32) -> u32 {
        // SAFETY: the address is that of a register or of a word of shared memory or flash, always readable.
        unsafe { (address as *const u32).read_volatile() }
    }

    fn write(&self, address: u32, value: u32) {
        // SAFETY: the address is a register's, always writable.
        unsafe { (address as *mut u32).write_volatile(value) }
    }

    fn read8(&self, address: u32) -> u8 {
        // SAFETY: inside of memory that is shared with the DMA, or of the flash.
        unsafe { (address as *const u8).read_volatile() }
    }

    fn write8(&self, address: u32, value: u8) {
        // SAFETY: inside of memory that is shared with the DMA.
        unsafe { (address as *mut u8).write_volatile(value) }
    }

    fn write16(&self, address: u32, value: u16) {
        // SAFETY: inside of the pages of the parameters, aligned, and unlocked.
        unsafe { (address as *mut u16).write_volatile(value) }
    }

    fn reset(&self) {
        SCB::sys_reset()
    }
}

/// Starts the board.
// Apart: what it takes meanwhile must not lie below the monitor.
#[inline(never)]
pub fn start() -> Stm32f103<Chip> {
    let memory = Memory {
        received: RECEIVE_RING.address(),
        sent: SEND_RING.address(),
        samples: SAMPLES.address(),
    };
    Stm32f103::start(Chip, memory)
}

unsafe extern "C" fn usart1() {
    line::on_interrupt(&Chip);
}
