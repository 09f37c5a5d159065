//! Ports and alternate functions (RM §9).

use super::Chip;

pub(super) const AFIO: u32 = 0x4001_0000;
pub(super) const PORTS: u32 = 0x4001_0800;
/// A pull-up of 30 to 50 kΩ (datasheet) takes so long to bring the 10 nF in front of a pin to 0.65
/// of the supply.
const RISE_NS: u64 = 600_000;

/// Port and bit: `at(b"PA6")`.
pub const fn at(name: &[u8; 4]) -> (usize, u32) {
    let bit = match name[2] {
        b' ' => 0,
        tens => 10 * (tens - b'0') as u32,
    };
    ((name[1] - b'A') as usize, bit + (name[3] - b'0') as u32)
}

pub(super) fn is_port(address: u32) -> bool {
    (PORTS..PORTS + 5 * 0x400).contains(&address)
}

pub(super) fn is_input(address: u32) -> bool {
    is_port(address) && address & 0x3FF == 0x08
}

impl Chip {
    pub(super) fn write_port(&mut self, address: u32, value: u32) {
        let base = address & !0x3FF;
        let odr = self.word(base + 0x0C);
        match address & 0x3FF {
            // RM §9.2.5, §9.2.6: setting has priority over clearing.
            0x10 => self.store(base + 0x0C, odr & !(value >> 16) | value & 0xFFFF),
            0x14 => self.store(base + 0x0C, odr & !(value & 0xFFFF)),
            _ => self.store(address, value),
        }
        let port = ((address - PORTS) / 0x400) as usize;
        (0..16).for_each(|bit| self.pull((port, bit)));
    }

    /// Notes since when nothing but its pull-up has held a pin.
    fn pull(&mut self, pin: (usize, u32)) {
        let (port, bit) = pin;
        let (driven, _) = self.outside[port];
        let pulled = self.mode(pin) == 0x8 && self.odr(pin) && driven >> bit & 1 == 0;
        let since = &mut self.pulled_since_ns[port][bit as usize];
        *since = pulled.then(|| since.unwrap_or(self.now_ns));
    }

    /// CNF and MODE of a pin.
    pub fn mode(&self, (port, bit): (usize, u32)) -> u32 {
        let register = PORTS + 0x400 * port as u32 + 4 * (bit / 8);
        self.word(register) >> (4 * (bit % 8)) & 0xF
    }

    fn odr(&self, (port, bit): (usize, u32)) -> bool {
        self.word(PORTS + 0x400 * port as u32 + 0x0C) >> bit & 1 != 0
    }

    /// Whether the pin drives high as an output of the program's.
    pub fn drives_high(&self, pin: (usize, u32)) -> bool {
        matches!(self.mode(pin), 1..=3) && self.odr(pin)
    }

    /// Whether a peripheral may drive the pin (RM §9.1.9).
    pub fn is_alternate(&self, pin: (usize, u32)) -> bool {
        matches!(self.mode(pin), 0x9..=0xB)
    }

    /// RM §9.3.3: JTAG keeps PA15, PB3 and PB4 until it is given up.
    pub(super) fn jtag_is_off(&self) -> bool {
        self.word(AFIO + 0x04) >> 24 & 0b111 == 0b010
    }

    /// Drives a pin from outside; `None` leaves it open.
    pub fn drive(&mut self, (port, bit): (usize, u32), level: Option<bool>) {
        let (mask, value) = &mut self.outside[port];
        let pin = 1 << bit;
        *mask = *mask & !pin | if level.is_some() { pin } else { 0 };
        *value = *value & !pin | if level == Some(true) { pin } else { 0 };
        self.pull((port, bit));
    }

    /// The level at a pin: what drives it, else its pull-up, in its time, or pull-down, else noise, which is
    /// low here.
    pub fn level(&self, pin: (usize, u32)) -> bool {
        let (port, bit) = pin;
        let (mask, value) = self.outside[port];
        match self.mode(pin) {
            1..=3 => self.odr(pin),
            _ if mask >> bit & 1 != 0 => value >> bit & 1 != 0,
            _ => self.pulled_since_ns[port][bit as usize]
                .is_some_and(|since| self.now_ns >= since + RISE_NS),
        }
    }

    pub(super) fn port_input(&self, address: u32) -> u32 {
        let port = ((address - PORTS) / 0x400) as usize;
        let jtag = !self.jtag_is_off();
        (0..16).fold(0, |bits, bit| {
            let taken = jtag && matches!((port, bit), (0, 15) | (1, 3..=4));
            bits | u32::from(!taken && self.level((port, bit))) << bit
        })
    }

    /// Whether the pin of an input of the ADC is analogue (RM §9.1.1).
    pub(super) fn is_analogue(&self, input: u32) -> bool {
        let pin = match input {
            0..=7 => (0, input),
            8..=9 => (1, input - 8),
            _ => (2, input - 10),
        };
        self.mode(pin) == 0
    }
}
