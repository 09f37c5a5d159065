//! QEMU's mps2-an385, whose software can be updated over the link: the line is its first UART, the plant's its
//! second; parameters, record and slots are in the memory that outlives power.

use super::Handler;
use super::emulated::{Chip, Emulated, Serial};
use lafet_device::hal::Software;
use lafet_mps2::{Flash, Lamp, Psram, Uart, Watchdog, handover, software};
use lafet_plant::flash::PARAMS_PAGES;
use lafet_update::Receiver;

/// How many interrupts the chip has. The watchdog's is the NMI.
pub const INTERRUPTS: usize = 32;
/// Interrupts that are no faults: none.
pub const HANDLERS: [Handler; 0] = [];

/// The chip.
pub struct Mps2 {
    watchdog: Watchdog,
    /// `None` without a bootloader.
    receiver: Option<Receiver<'static, Flash<Psram>>>,
    /// Lit while anything is driven.
    lamp: Lamp,
}

/// Starts the board.
// Apart: what it takes meanwhile must not lie below the monitor.
#[inline(never)]
pub fn start() -> Emulated<Mps2> {
    let watchdog = Watchdog::start();
    let receiver = handover::take().and_then(software::receiver);
    let chip = Mps2 { watchdog, receiver, lamp: Lamp::default() };
    Emulated::new(chip, Uart::line(), Uart::plant(), Flash::of_chip(), PARAMS_PAGES)
}

impl Serial for Uart {
    fn read(&self) -> Option<u8> {
        Self::read(self)
    }

    fn put(&mut self, byte: u8) {
        Self::put(self, byte);
    }
}

impl Chip for Mps2 {
    type Serial = Uart;
    type Flash = Flash<Psram>;
    const PERIPHERALS: usize = 0x4000_4000;

    /// It leaves a record by its first call; the chip itself does not say what has reset it.
    fn reset_by_watchdog(&self) -> bool {
        false
    }

    fn feed_watchdog(&mut self) {
        self.watchdog.feed();
    }

    fn software(&mut self) -> Option<&mut dyn Software> {
        self.receiver.as_mut().map(|receiver| receiver as &mut dyn Software)
    }

    fn drives(&mut self, anything: bool) {
        self.lamp.show(anything);
    }
}
