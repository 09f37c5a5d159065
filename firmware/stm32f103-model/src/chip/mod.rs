//! The chip: memory, registers, time, and what they do to each other.
//!
//! A register that has no rule here keeps what is written. What a rule of the manual forbids, and a real
//! chip would answer with something unforeseen, is noted in [`Chip::violations`].

mod clocks;
mod flash;
mod pins;
mod timers;
mod usart;
mod watchdog;

pub use flash::{FLASH_SIZE, FLASH_START};
pub use pins::at as pin;
pub use timers::Counter;
pub use usart::Byte;

use std::collections::{BTreeSet, VecDeque};

/// Where RAM begins.
pub const RAM_START: u32 = 0x2000_0000;
const RAM_SIZE: usize = 48 * 1024;
const REGISTERS: u32 = 0x4000_0000;
const REGISTERS_SIZE: u32 = 0x2_4000;
/// RM §10, table 63: the interrupt of USART1, in the second register of the NVIC.
const NVIC_ENABLE: u32 = 0xE000_E104;
const USART1_BIT: u32 = 1 << 5;

/// A period of the PWM, which starts a scan of the ADC.
const SCAN_NS: u64 = 50_000;

const BKP: u32 = 0x4000_6C00;
const PWR: u32 = 0x4000_7000;
const IWDG: u32 = 0x4000_3000;
const ADC: u32 = 0x4001_2400;
const DMA: u32 = 0x4002_0000;
const RCC: u32 = 0x4002_1000;

/// What ends a run of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reset {
    /// The program itself.
    Software,
    /// The independent watchdog.
    Watchdog,
    /// The interrupt of the clock's watch, whose handler records and resets.
    Clock,
    /// The supply.
    Power,
}

/// The chip.
#[derive(Clone, Debug)]
pub struct Chip {
    /// Time since the model began, ns.
    pub now_ns: u64,
    /// Rules of the manual that the program has broken.
    pub violations: BTreeSet<String>,
    /// What has ended the run, until the next begins.
    pub reset: Option<Reset>,
    /// The crystal swings when it is switched on.
    pub crystal: bool,
    /// The supply of the chip is below the level of its detector.
    pub supply_low: bool,
    /// The option bytes have every reset start the watchdog.
    pub watchdog_at_reset: bool,
    /// The internal oscillator of the watchdog, Hz: 30,000 to 60,000.
    pub lsi_hz: u64,
    /// Twelve bits at each input of the ADC.
    pub analog: [u16; 16],
    /// What drives the pins from outside: which of each port, and how.
    outside: [(u16, u16); 5],
    /// Since when each pin of each port has been held by its pull-up alone, ns.
    pulled_since_ns: [[Option<u64>; 16]; 5],
    /// Bytes that come over the line, and when each has come.
    pub incoming: VecDeque<Byte>,
    /// Bytes that have left over the line.
    pub outgoing: Vec<Byte>,
    /// When the program released the line last, ns.
    pub released_ns: u64,
    /// How long it has held the line behind a last stop bit, at most, ns.
    pub held_ns: u64,
    /// The processor waits for its flash, and interrupts with it.
    pub is_stalled: bool,
    /// What the other side of the line runs at.
    pub line_baud: u64,
    /// Pages of the flash that the program has erased.
    pub erasures: u32,
    words: Vec<u32>,
    ram: Vec<u8>,
    flash: Vec<u8>,
    flash_keys: u8,
    watchdog: watchdog::State,
    interrupts: u32,
    pll_since_ns: u64,
    hse_since_ns: u64,
    calibrated: bool,
    leaving: Option<Byte>,
    left_ns: u64,
    receive_size: u32,
    encoders: [i64; 4],
    time_base_ns: u64,
    scanned_ns: u64,
}

impl Chip {
    /// A chip without power, with this flash.
    pub fn new(flash: Vec<u8>) -> Self {
        let mut chip = Self {
            now_ns: 0,
            violations: BTreeSet::new(),
            reset: None,
            crystal: true,
            supply_low: false,
            watchdog_at_reset: false,
            lsi_hz: 40_000,
            analog: [0; 16],
            outside: [(0, 0); 5],
            pulled_since_ns: [[None; 16]; 5],
            incoming: VecDeque::new(),
            outgoing: Vec::new(),
            released_ns: 0,
            held_ns: 0,
            is_stalled: false,
            line_baud: 115_200,
            erasures: 0,
            words: vec![0; (REGISTERS_SIZE / 4) as usize],
            ram: vec![0; RAM_SIZE],
            flash,
            flash_keys: 0,
            watchdog: watchdog::State::AT_RESET,
            interrupts: 0,
            pll_since_ns: 0,
            hse_since_ns: 0,
            calibrated: false,
            leaving: None,
            left_ns: 0,
            receive_size: 0,
            encoders: [0; 4],
            time_base_ns: 0,
            scanned_ns: 0,
        };
        chip.start(Reset::Power);
        chip
    }

    /// Brings every register to its state after a reset; those of the battery stay.
    pub fn start(&mut self, cause: Reset) {
        let kept: Vec<u32> = (0..=42).map(|n| self.word(BKP + 4 * n)).collect();
        self.words.fill(0);
        for (n, word) in (0..).zip(kept) {
            self.store(BKP + 4 * n, word);
        }
        // RM §7.3.1, §7.3.10, §3.4, §27.6.1, §9.2: reset values that are not 0.
        self.store(RCC, 0x83);
        self.store(RCC + 0x14, 0x14);
        let flag = match cause {
            Reset::Power => 1 << 27,
            Reset::Software | Reset::Clock => 1 << 28,
            Reset::Watchdog => 1 << 29,
        };
        self.store(RCC + 0x24, 1 << 26 | flag);
        self.store(flash::CONTROL + 0x10, 1 << 7);
        self.store(usart::USART, 0xC0);
        self.store(IWDG + 0x08, 0xFFF);
        for port in 0..5 {
            for half in 0..2 {
                self.store(pins::PORTS + 0x400 * port + 4 * half, 0x4444_4444);
            }
        }
        self.pulled_since_ns = [[None; 16]; 5];
        self.flash_keys = 0;
        self.watchdog = watchdog::State::AT_RESET;
        self.interrupts = 0;
        self.calibrated = false;
        self.leaving = None;
        self.reset = None;
        if self.watchdog_at_reset {
            self.write_watchdog(IWDG, watchdog::START);
        }
    }

    /// The bytes of the flash.
    pub fn flash(&self) -> &[u8] {
        &self.flash
    }

    /// Writes to the flash from outside, by SWD.
    pub fn program(&mut self, address: u32, bytes: &[u8]) {
        for (at, byte) in (address - FLASH_START..).zip(bytes) {
            self.flash[at as usize] = *byte;
        }
    }

    /// A register as the program reads it.
    pub fn read(&mut self, address: u32) -> u32 {
        if address == NVIC_ENABLE {
            return self.interrupts;
        }
        if !self.has_clock(address) {
            // RM §7.3.7: without its clock a peripheral reads as 0.
            return 0;
        }
        // Two steps in one ms, as behind a write to the flash, have scans between them as well.
        if address == DMA && self.now_ns >= self.scanned_ns + SCAN_NS {
            self.convert();
        }
        match address {
            RCC => self.clock_control(),
            _ if address == RCC + 0x04 => self.clock_config(),
            _ if pins::is_input(address) => self.port_input(address),
            timers::TIME_COUNT => self.time_count(),
            _ if address == PWR + 0x04 => self.supply_status(),
            watchdog::STATUS => self.watchdog_status(),
            _ if address < REGISTERS => {
                u32::from_le_bytes([0, 1, 2, 3].map(|n| self.read8(address + n)))
            }
            _ => self.word(address),
        }
    }

    /// The program writes a register. Returns the ns for which the processor is stalled.
    pub fn write(&mut self, address: u32, value: u32) -> u64 {
        if address == NVIC_ENABLE {
            self.interrupts |= value;
            return 0;
        }
        if !self.has_clock(address) {
            return 0;
        }
        match address {
            _ if (flash::CONTROL..flash::CONTROL + 0x400).contains(&address) => {
                return self.write_flash_control(address, value);
            }
            _ if (RCC..RCC + 0x400).contains(&address) => self.write_clocks(address, value),
            _ if (IWDG..IWDG + 0x400).contains(&address) => self.write_watchdog(address, value),
            // RM §5.1.2: protected after a reset.
            _ if (BKP..BKP + 0x400).contains(&address) => {
                if self.word(PWR) & 1 << 8 != 0 {
                    self.store(address, value & 0xFFFF);
                }
            }
            _ if (DMA..DMA + 0x400).contains(&address) => self.write_dma(address, value),
            _ if pins::is_port(address) => {
                let held = self.holds_line();
                self.write_port(address, value);
                if held && !self.holds_line() {
                    self.released_ns = self.now_ns;
                    self.held_ns = self.held_ns.max(self.now_ns - self.left_ns);
                }
            }
            _ if timers::is_timer(address) => self.write_timer(address, value),
            _ if (usart::USART..usart::USART + 0x400).contains(&address) => {
                self.write_usart(address, value);
            }
            _ if address == ADC + 0x08 => self.write_adc(value),
            _ => self.store(address, value),
        }
        0
    }

    /// A byte of RAM or flash.
    pub fn read8(&self, address: u32) -> u8 {
        let at = |start: u32| address.wrapping_sub(start) as usize;
        let found = self.ram.get(at(RAM_START)).or_else(|| self.flash.get(at(FLASH_START)));
        found.copied().unwrap_or(0xFF)
    }

    /// Writes a byte of RAM.
    pub fn write8(&mut self, address: u32, value: u8) {
        if let Some(byte) = self.ram.get_mut(address.wrapping_sub(RAM_START) as usize) {
            *byte = value;
        }
    }

    /// Moves time, at most to this moment; it ends early when an interrupt is to be served.
    pub fn advance(&mut self, until_ns: u64) {
        while self.now_ns < until_ns && !self.has_interrupt() {
            let next = self.next_byte_ns().unwrap_or(u64::MAX).max(self.now_ns + 1);
            self.now_ns = next.min(until_ns);
            self.move_bytes();
        }
        self.watch();
    }

    /// RM §27.4: the transmission is complete, and its interrupt is let through. Its handler is in the flash, so
    /// it waits for that (PM0075 §2.3).
    pub fn has_interrupt(&self) -> bool {
        let enabled = self.word(usart::USART + 0x0C) & 1 << 6 != 0;
        let complete = self.word(usart::USART) & 1 << 6 != 0;
        enabled && complete && !self.is_stalled && self.interrupts & USART1_BIT != 0
    }

    /// The handler has returned: an interrupt whose cause is still there comes again at once, for ever.
    pub fn served(&mut self) {
        if self.has_interrupt() {
            self.violations.insert("an interrupt that its handler does not end".into());
            self.interrupts = 0;
        }
    }

    /// Conversions, the last of many: RM §11.3.9, §11.7, §13.3.
    pub fn convert(&mut self) {
        self.scanned_ns = self.now_ns;
        let (cr1, cr2) = (self.word(ADC + 0x04), self.word(ADC + 0x08));
        let by_tim8 = cr2 & 1 << 20 != 0 && cr2 >> 17 & 0b111 == 0b110;
        let remapped = self.word(pins::AFIO + 0x04) & 1 << 18 != 0;
        let channel = DMA + 0x08;
        let to_memory = cr2 & 1 << 8 != 0 && self.word(channel) & 1 != 0;
        let scans = cr1 & 1 << 8 != 0;
        if cr2 & 1 == 0 || !by_tim8 || !remapped || !self.pwm_triggers() || !to_memory || !scans {
            return;
        }
        let count = (self.word(ADC + 0x2C) >> 20 & 0xF) + 1;
        let to = self.word(channel + 0x0C);
        // RM §13.3.3: a channel that does not go round ends with its last item.
        let circular = self.word(channel) & 1 << 5 != 0;
        if self.word(channel + 4) == 0 {
            return;
        }
        if !circular {
            self.store(channel + 4, 0);
        }
        for n in 0..count {
            let register = ADC + 0x34 - 4 * (n / 6);
            let input = self.word(register) >> (5 * (n % 6)) & 0x1F;
            let raw = self.analog.get(input as usize).copied().unwrap_or_default();
            // RM §11.4: what calibration takes away.
            let sample = (raw + if self.calibrated { 0 } else { 60 }).min(4_095);
            // RM §9.1.1: a pin that is not analogue loads the source.
            let sample = if self.is_analogue(input) { sample } else { sample / 2 };
            let [low, high] = sample.to_le_bytes();
            let step = if self.word(channel) & 1 << 7 != 0 { 2 * n } else { 0 };
            self.write8(to + step, low);
            self.write8(to + step + 1, high);
        }
        let flags = self.word(DMA) | 0b11;
        self.store(DMA, flags);
    }

    fn write_adc(&mut self, value: u32) {
        if value & 1 << 2 != 0 && self.word(ADC + 0x08) & 1 != 0 {
            self.calibrated = true;
        }
        // Both bits of the calibration are cleared by the chip when it is over.
        self.store(ADC + 0x08, value & !(0b11 << 2));
    }

    fn write_dma(&mut self, address: u32, value: u32) {
        match address - DMA {
            // RM §13.4.2
            0x04 => {
                let mut flags = self.word(DMA);
                for channel in 0..7 {
                    let bits = value >> (4 * channel) & 0xF;
                    let cleared = if bits & 1 != 0 { 0xF } else { bits };
                    flags &= !(cleared << (4 * channel));
                }
                self.store(DMA, flags);
            }
            offset => {
                let (channel, field) = ((offset - 8) / 20, (offset - 8) % 20);
                let control = DMA + 8 + 20 * channel;
                let enabled = self.word(control) & 1 != 0;
                // RM §13.4.4 to §13.4.6: not to be written while the channel is enabled.
                if enabled && field != 0 {
                    self.violations
                        .insert(format!("DMA channel {} written while enabled", channel + 1));
                    return;
                }
                self.store(address, value);
                if field == 0 && value & 1 != 0 && channel == 4 {
                    self.receive_size = self.word(control + 4);
                }
            }
        }
    }

    /// Whether the watchdog has run out, the crystal has failed, the supply is about to.
    fn watch(&mut self) {
        if self.watchdog.bites_ns.is_some_and(|bites_ns| self.now_ns >= bites_ns) {
            self.reset.get_or_insert(Reset::Watchdog);
        }
        self.watch_crystal();
        self.watch_break();
    }

    fn supply_status(&self) -> u32 {
        let watched = self.word(PWR) & 1 << 4 != 0;
        u32::from(watched && self.supply_low) << 2
    }

    fn word(&self, address: u32) -> u32 {
        let at = address.wrapping_sub(REGISTERS) / 4;
        self.words.get(at as usize).copied().unwrap_or_default()
    }

    fn store(&mut self, address: u32, value: u32) {
        let at = address.wrapping_sub(REGISTERS) / 4;
        match self.words.get_mut(at as usize) {
            Some(word) => *word = value,
            None => _ = self.violations.insert(format!("nothing is at {address:#x}")),
        }
    }
}
