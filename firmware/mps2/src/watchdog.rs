//! The watchdog: it interrupts when it has not been fed for 2 s, and resets after 2 s more.

use crate::register::write;

const LOAD: usize = 0x4000_8000;
const CONTROL: usize = LOAD + 0x008;
const CLEAR: usize = LOAD + 0x00C;
/// Interrupt (an NMI), then reset.
const BOTH: u32 = 0b11;
/// 2 s at 25 MHz: a signature takes a good part of one.
const TICKS: u32 = 50_000_000;

/// The watchdog, running.
#[derive(Debug)]
pub struct Watchdog(());

impl Watchdog {
    /// Starts it; one that runs goes on with its full time.
    pub fn start() -> Self {
        write(LOAD, TICKS);
        write(CONTROL, BOTH);
        let watchdog = Self(());
        watchdog.feed();
        watchdog
    }

    /// The program is alive.
    pub fn feed(&self) {
        feed();
    }
}

/// The same where the watchdog is not at hand; nothing before it runs.
pub fn feed() {
    write(CLEAR, 1);
}
