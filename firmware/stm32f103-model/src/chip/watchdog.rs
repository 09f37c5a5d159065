//! The independent watchdog (RM §19).

use super::{Chip, IWDG, RCC};

const KEY: u32 = IWDG;
const PRESCALER: u32 = IWDG + 0x04;
const RELOAD: u32 = IWDG + 0x08;
pub(super) const STATUS: u32 = IWDG + 0x0C;
/// RM §19.4.1: the key that starts the counter.
pub(super) const START: u32 = 0xCCCC;
/// RM §19.4.4: a new value is in use after so many cycles of the oscillator at most.
const UPDATE_CYCLES: u64 = 5;
const SECOND_NS: u64 = 1_000_000_000;

/// What is behind the registers.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    unlocked: bool,
    /// What the counter is reloaded with.
    reload: u32,
    /// When a new prescaler and a new reload value are in use, ns.
    updated_ns: [u64; 2],
    /// When it resets the chip, ns; `None` until it is started.
    pub(super) bites_ns: Option<u64>,
}

impl State {
    pub(super) const AT_RESET: Self =
        Self { unlocked: false, reload: 0xFFF, updated_ns: [0; 2], bites_ns: None };
}

impl Chip {
    /// RM §19.4.4: PVU and RVU, an update of the prescaler or of the reload value is going on.
    pub(super) fn watchdog_status(&self) -> u32 {
        let [prescaler, reload] = self.watchdog.updated_ns.map(|at_ns| self.now_ns < at_ns);
        u32::from(prescaler) | u32::from(reload) << 1
    }

    pub(super) fn write_watchdog(&mut self, address: u32, value: u32) {
        let status = self.watchdog_status();
        if status & 0b10 == 0 {
            self.watchdog.reload = self.word(RELOAD) & 0xFFF;
        }
        let place = match address {
            KEY => return self.take_key(value),
            PRESCALER => 0,
            RELOAD => 1,
            _ => return,
        };
        if !self.watchdog.unlocked {
            return;
        }
        if status >> place & 1 != 0 {
            self.violations.insert("the watchdog set again during an update".into());
            return;
        }
        self.store(address, value);
        let runs = self.word(RCC + 0x24) & 1 != 0 || self.watchdog.bites_ns.is_some();
        self.watchdog.updated_ns[place] = if runs { self.update_ends_ns() } else { u64::MAX };
    }

    /// RM §19.3, §19.3.2, §19.4.1: 0x5555 opens the two registers and any other key closes them, 0xCCCC starts
    /// the counter at 0xFFF and the oscillator with it, 0xAAAA reloads it.
    fn take_key(&mut self, value: u32) {
        self.watchdog.unlocked = value == 0x5555;
        match (value, self.watchdog.bites_ns) {
            (START, None) => {
                let ends_ns = self.update_ends_ns();
                for at_ns in &mut self.watchdog.updated_ns {
                    *at_ns = ends_ns.min(*at_ns);
                }
                self.count_down(0xFFF);
            }
            (0xAAAA, Some(_)) => self.count_down(self.watchdog.reload),
            _ => {}
        }
    }

    fn update_ends_ns(&self) -> u64 {
        self.now_ns + UPDATE_CYCLES * SECOND_NS / self.lsi_hz
    }

    /// With the prescaler that was written: one that is not in use yet soon will be.
    fn count_down(&mut self, from: u32) {
        let prescaler = 4_u64 << (self.word(PRESCALER) & 0b111).min(6);
        let ticks = u64::from(from) + 1;
        self.watchdog.bites_ns = Some(self.now_ns + ticks * prescaler * SECOND_NS / self.lsi_hz);
    }
}
