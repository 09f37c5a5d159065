//! Timers: PWM with break, encoders, the time (RM §14, §15, §17).

use super::{Chip, pins};

pub(super) const TIM1: u32 = 0x4001_2C00;
pub(super) const TIM2: u32 = 0x4000_0000;
const TIM3: u32 = 0x4000_0400;
const TIM4: u32 = 0x4000_0800;
const TIM5: u32 = 0x4000_0C00;
const TIM6: u32 = 0x4000_1000;
pub(super) const TIM8: u32 = 0x4001_3400;
pub(super) const TIME_COUNT: u32 = TIM6 + 0x24;
pub(super) const ALL: [u32; 7] = [TIM1, TIM2, TIM3, TIM4, TIM5, TIM6, TIM8];

const MOE: u32 = 1 << 15;
const BREAK_ENABLE: u32 = 1 << 12;
const BREAK_HIGH: u32 = 1 << 13;
const BREAK_PIN: (usize, u32) = pins::at(b"PA 6");
const PWM_PINS: [(usize, u32); 4] =
    [pins::at(b"PC 6"), pins::at(b"PC 7"), pins::at(b"PC 8"), pins::at(b"PC 9")];

/// A counter that follows pulses from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counter {
    /// TIM5 on PA0 and PA1.
    Tim5,
    /// TIM3 on PB4 and PB5.
    Tim3,
    /// TIM4 on PB6 and PB7.
    Tim4,
    /// TIM1 on PE9 and PE11.
    Tim1,
}

impl Counter {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Tim5, Self::Tim3, Self::Tim4, Self::Tim1];

    const fn base(self) -> u32 {
        match self {
            Self::Tim5 => TIM5,
            Self::Tim3 => TIM3,
            Self::Tim4 => TIM4,
            Self::Tim1 => TIM1,
        }
    }
}

pub(super) fn is_timer(address: u32) -> bool {
    ALL.contains(&(address & !0x3FF))
}

impl Chip {
    pub(super) fn write_timer(&mut self, address: u32, value: u32) {
        let base = address & !0x3FF;
        match (base, address & 0x3FF) {
            (TIM1 | TIM8, 0x44) => self.write_break(address, value),
            // RM §14.4.5: flags are cleared by zeros.
            (_, 0x10) => {
                let flags = self.word(address);
                self.store(address, flags & value);
            }
            // RM §14.4.6: an update by hand restarts the counter.
            (TIM6, 0x14) => self.time_base_ns = self.now_ns,
            (_, 0x14) => {}
            (TIM6, 0x24) => self.time_base_ns = self.now_ns,
            _ => self.store(address, value),
        }
    }

    /// RM §14.4.18
    fn write_break(&mut self, address: u32, value: u32) {
        let before = self.word(address);
        // From the first lock on, break and idle states stay as they are; the lock itself is written once.
        let locked = if before >> 8 & 0b11 != 0 { 0x73FF } else { 0 };
        let upper = if before >> 8 & 0b11 >= 2 { 0x0C00 } else { 0 };
        let fixed = (locked & !0x0C00) | upper;
        self.store(address, before & fixed | value & !fixed);
        self.watch_break();
    }

    /// RM §14.3.12: the break input takes MOE away, without the program.
    pub(super) fn watch_break(&mut self) {
        let control = self.word(TIM8 + 0x44);
        let active = self.level(BREAK_PIN) == (control & BREAK_HIGH != 0);
        if control & BREAK_ENABLE != 0 && active && control & MOE != 0 {
            self.break_pwm();
        }
    }

    pub(super) fn break_pwm(&mut self) {
        let control = self.word(TIM8 + 0x44);
        if control & BREAK_ENABLE != 0 {
            self.store(TIM8 + 0x44, control & !MOE);
            let flags = self.word(TIM8 + 0x10);
            self.store(TIM8 + 0x10, flags | 1 << 7);
        }
    }

    /// The part of the time that a channel of TIM8 is on, as it reaches its pin.
    pub fn pwm(&self, channel: usize) -> f64 {
        let word = |offset: u32| self.word(TIM8 + offset);
        let n = channel as u32;
        let mode = word(0x18 + 4 * (n / 2)) >> (8 * (n % 2)) & 0xFF;
        let counts = word(0x00) & 1 != 0 && word(0x2C) > 0;
        let enabled = word(0x20) >> (4 * n) & 1 != 0 && word(0x44) & MOE != 0;
        if !counts || !enabled || !self.is_alternate(PWM_PINS[channel]) {
            return 0.0;
        }
        let part = (f64::from(word(0x34 + 4 * n)) / f64::from(word(0x2C))).min(1.0);
        let part = if word(0x20) >> (4 * n + 1) & 1 != 0 { 1.0 - part } else { part };
        match mode >> 4 & 0b111 {
            0b110 => part,
            0b111 => 1.0 - part,
            0b101 => 1.0,
            _ => 0.0,
        }
    }

    /// Periods of the PWM in a second.
    pub fn pwm_hz(&self) -> f64 {
        let word = |offset: u32| self.word(TIM8 + offset);
        let slopes = if word(0x00) >> 5 & 0b11 != 0 { 2.0 } else { 1.0 };
        self.hz() as f64 / (f64::from(word(0x28)) + 1.0) / f64::from(word(0x2C).max(1)) / slopes
    }

    /// Whether TIM8 gives a trigger in each period (RM §14.4.2).
    pub(super) fn pwm_triggers(&self) -> bool {
        self.word(TIM8) & 1 != 0 && self.word(TIM8 + 0x04) >> 4 & 0b111 == 0b010
    }

    /// An encoder has moved to this count; `noisy` when a power stage switches beside its cable.
    pub fn turn(&mut self, counter: Counter, count: i64, noisy: bool) {
        let moved = count - self.encoders[counter as usize];
        self.encoders[counter as usize] = count;
        let base = counter.base();
        let remaps = self.word(pins::AFIO + 0x04);
        let reaches = match counter {
            Counter::Tim5 => true,
            Counter::Tim3 => remaps >> 10 & 0b11 == 0b10 && self.jtag_is_off(),
            Counter::Tim4 => remaps >> 12 & 1 == 0,
            Counter::Tim1 => remaps >> 6 & 0b11 == 0b11,
        };
        let inputs = self.word(base + 0x18);
        let both = inputs & 0b11 == 0b01 && inputs >> 8 & 0b11 == 0b01;
        if self.word(base) & 1 == 0 || !reaches || !both {
            return;
        }
        // RM §15.3.12: one track alone gives half of the edges.
        let edges = match self.word(base + 0x08) & 0b111 {
            0b011 => moved,
            0b001 | 0b010 => moved / 2,
            _ => return,
        };
        // RM §15.4.7: without the filter what a power stage radiates counts too.
        let noise = i64::from(noisy && (inputs >> 4 & 0xF < 3 || inputs >> 12 & 0xF < 3));
        // RM §15.4.12: with nothing to reload it is blocked. (Editions differ on its value after a reset:
        // 0 here.)
        let top = i64::from(self.word(base + 0x2C) & 0xFFFF);
        let count = i64::from(self.word(base + 0x24)) + edges + noise;
        self.store(base + 0x24, count.rem_euclid(top + 1) as u32);
    }

    /// Pulses have come at PB3: TIM2's second channel, as the clock of its counter (RM §15.3.3).
    pub fn pulse(&mut self, pulses: u32) {
        let remapped = self.word(pins::AFIO + 0x04) >> 8 & 0b11 == 0b01 && self.jtag_is_off();
        let mode = self.word(TIM2 + 0x08);
        let clocked = mode & 0b111 == 0b111 && mode >> 4 & 0b111 == 0b110;
        let input = self.word(TIM2 + 0x18) >> 8 & 0b11 == 0b01;
        if remapped && clocked && input && self.word(TIM2) & 1 != 0 {
            let count = self.word(TIM2 + 0x24) + pulses;
            self.store(TIM2 + 0x24, count % ((self.word(TIM2 + 0x2C) & 0xFFFF) + 1));
        }
    }

    pub(super) fn time_count(&self) -> u32 {
        if self.word(TIM6) & 1 == 0 {
            return 0;
        }
        const SECOND_NS: u64 = 1_000_000_000;
        let (passed_ns, hz) = (self.now_ns - self.time_base_ns, self.timer_hz());
        let cycles = passed_ns / SECOND_NS * hz + passed_ns % SECOND_NS * hz / SECOND_NS;
        let ticks = cycles / (u64::from(self.word(TIM6 + 0x28)) + 1);
        (ticks % (u64::from(self.word(TIM6 + 0x2C)) + 1)) as u32
    }
}
