//! Reset and clock control (RM §7).

use super::{BKP, Chip, DMA, PWR, RCC, Reset, flash, pins, timers, usart};

/// The crystal swings after this time (datasheet, tSU(HSE)), the PLL is locked after this.
const CRYSTAL_NS: u64 = 2_000_000;
const PLL_NS: u64 = 200_000;

const HSE_ON: u32 = 1 << 16;
const HSE_READY: u32 = 1 << 17;
const CSS_ON: u32 = 1 << 19;
const PLL_ON: u32 = 1 << 24;
const PLL_READY: u32 = 1 << 25;

impl Chip {
    /// RM §7.3.1: control, with what is ready.
    pub(super) fn clock_control(&mut self) -> u32 {
        let mut value = self.word(RCC) & !(HSE_READY | PLL_READY) | 0b10;
        let after = |since: u64, ns: u64| self.now_ns >= since + ns;
        let crystal = value & HSE_ON != 0 && self.crystal && after(self.hse_since_ns, CRYSTAL_NS);
        let from_crystal = self.word(RCC + 4) & 1 << 16 != 0;
        if crystal {
            value |= HSE_READY;
        }
        let fed = crystal || !from_crystal;
        if value & PLL_ON != 0 && fed && after(self.pll_since_ns, PLL_NS) {
            value |= PLL_READY;
        }
        self.store(RCC, value);
        value
    }

    /// RM §7.3.2: configuration, with the clock that is in use.
    pub(super) fn clock_config(&mut self) -> u32 {
        let value = self.word(RCC + 4) & !(0b11 << 2);
        let ready = self.clock_control();
        let wanted = value & 0b11;
        let runs = match wanted {
            0b10 => ready & PLL_READY != 0,
            0b01 => ready & HSE_READY != 0,
            _ => true,
        };
        let value = value | if runs { wanted << 2 } else { 0 };
        self.store(RCC + 4, value);
        value
    }

    pub(super) fn write_clocks(&mut self, address: u32, value: u32) {
        match address - RCC {
            0x00 => {
                let before = self.word(RCC);
                if value & HSE_ON != 0 && before & HSE_ON == 0 {
                    self.hse_since_ns = self.now_ns;
                }
                if value & PLL_ON != 0 && before & PLL_ON == 0 {
                    self.pll_since_ns = self.now_ns;
                }
                self.store(address, value);
            }
            0x04 => {
                let before = self.word(address);
                // RM §7.3.2: source and factor of the PLL are fixed while it is on.
                let fixed = if self.word(RCC) & PLL_ON != 0 { 0x3F << 16 } else { 0 };
                self.store(address, before & fixed | value & !fixed);
                self.clock_config();
                self.check_speeds();
            }
            // RM §7.3.10: the flags of resets go together, the oscillator of the watchdog is ready soon.
            0x24 => {
                let before = self.word(address);
                let flags = if value & 1 << 24 != 0 { 0 } else { before & 0xFC00_0000 };
                let on = value & 1;
                self.store(address, flags | on << 1 | on);
            }
            _ => self.store(address, value),
        }
    }

    /// The processor's clock, Hz.
    pub fn hz(&self) -> u64 {
        let config = self.word(RCC + 4);
        let factor = u64::from(config >> 18 & 0xF) + 2;
        match config >> 2 & 0b11 {
            0b10 if config & 1 << 16 != 0 => 8_000_000 * factor.min(16),
            0b10 => 4_000_000 * factor.min(16),
            _ => 8_000_000,
        }
    }

    /// The clock of timers on APB1, Hz (RM §7.2): twice that of the bus where that is divided.
    pub(super) fn timer_hz(&self) -> u64 {
        match self.word(RCC + 4) >> 8 & 0b111 {
            divided @ 0b101..=0b111 => self.hz() >> (divided & 0b11),
            _ => self.hz(),
        }
    }

    fn check_speeds(&mut self) {
        let (hz, config) = (self.hz(), self.word(RCC + 4));
        // RM §3.3.3
        let states = u64::from(self.word(flash::CONTROL) & 0b111);
        if hz > 24_000_000 * (states + 1) {
            self.violations.insert("flash read faster than its wait states allow".into());
        }
        let divided = match config >> 8 & 0b111 {
            0b000..=0b011 => hz,
            divider => hz >> (divider - 3),
        };
        if divided > 36_000_000 {
            self.violations.insert("APB1 faster than 36 MHz".into());
        }
        let adc = hz / (2 * (u64::from(config >> 14 & 0b11) + 1));
        if adc > 14_000_000 {
            self.violations.insert("ADC faster than 14 MHz".into());
        }
    }

    /// RM §7.2.7: a watched crystal that fails breaks the PWM and interrupts.
    pub(super) fn watch_crystal(&mut self) {
        let control = self.word(RCC);
        if control & CSS_ON != 0 && control & HSE_READY != 0 && !self.crystal {
            self.store(RCC, control & !(CSS_ON | HSE_ON | HSE_READY | PLL_ON | PLL_READY));
            let config = self.word(RCC + 4);
            self.store(RCC + 4, config & !0b1111);
            self.break_pwm();
            self.reset.get_or_insert(Reset::Clock);
        }
    }

    /// RM §7.3.6 to §7.3.8
    pub(super) fn has_clock(&self, address: u32) -> bool {
        let (register, bit) = match address & !0x3FF {
            DMA => (0x14, 0),
            pins::AFIO => (0x18, 0),
            port @ pins::PORTS..=0x4001_1BFF => (0x18, 2 + (port - pins::PORTS) / 0x400),
            super::ADC => (0x18, 9),
            timers::TIM1 => (0x18, 11),
            timers::TIM8 => (0x18, 13),
            usart::USART => (0x18, 14),
            timer @ 0x4000_0000..=0x4000_17FF => (0x1C, (timer - 0x4000_0000) / 0x400),
            BKP => (0x1C, 27),
            PWR => (0x1C, 28),
            _ => return true,
        };
        self.word(RCC + register) >> bit & 1 != 0
    }
}
