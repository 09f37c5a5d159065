//! USART1 and its two channels of the DMA (RM §27, §13).

use super::{Chip, DMA, pins};

pub(super) const USART: u32 = 0x4001_3800;
const TRANSMIT: (usize, u32) = pins::at(b"PA12");
const TX_PIN: (usize, u32) = pins::at(b"PA 9");
const TX_CHANNEL: u32 = DMA + 8 + 20 * 3;
const RX_CHANNEL: u32 = DMA + 8 + 20 * 4;
const COMPLETE: u32 = 1 << 6;
/// RM §27.3.5: with ten bits, and clocks of both sides.
const TOLERANCE: f64 = 0.03;

/// A byte on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Byte {
    /// When its stop bit ends, ns.
    pub at_ns: u64,
    /// Its bits.
    pub value: u8,
}

impl Chip {
    pub(super) fn write_usart(&mut self, address: u32, value: u32) {
        match address - USART {
            // RM §27.6.1: TC is cleared by a zero.
            0x00 => {
                let status = self.word(address);
                self.store(address, status & (value | !COMPLETE));
            }
            _ => self.store(address, value),
        }
        self.feed_transmitter();
    }

    /// Bits a second.
    fn baud(&self) -> f64 {
        self.hz() as f64 / f64::from(self.word(USART + 0x08).max(1))
    }

    fn byte_ns(&self) -> u64 {
        (10e9 / self.baud()) as u64
    }

    fn is_in_step(&self) -> bool {
        let line = self.line_baud as f64;
        (self.baud() - line).abs() / line < TOLERANCE
    }

    /// The driver of RS-485 drives the line.
    pub fn holds_line(&self) -> bool {
        self.drives_high(TRANSMIT)
    }

    /// When something happens on the line next.
    pub(super) fn next_byte_ns(&mut self) -> Option<u64> {
        self.feed_transmitter();
        let out = self.leaving.map(|byte| byte.at_ns);
        let coming = self.incoming.front().map(|byte| byte.at_ns);
        match (out, coming) {
            (Some(out), Some(coming)) => Some(out.min(coming)),
            (one, other) => one.or(other),
        }
    }

    pub(super) fn move_bytes(&mut self) {
        if let Some(byte) = self.leaving.filter(|byte| byte.at_ns <= self.now_ns) {
            self.leaving = None;
            self.left_ns = byte.at_ns;
            if self.holds_line() && self.is_alternate(TX_PIN) && self.is_in_step() {
                self.outgoing.push(byte);
            }
            self.feed_transmitter();
            if self.leaving.is_none() {
                let status = self.word(USART);
                self.store(USART, status | COMPLETE);
            }
        }
        while let Some(byte) = self.incoming.front().copied().filter(|it| it.at_ns <= self.now_ns) {
            self.incoming.pop_front();
            self.take_in(byte.value);
        }
    }

    /// RM §27.3.13: the DMA gives the next byte.
    fn feed_transmitter(&mut self) {
        let sends = self.word(USART + 0x0C) & (1 << 13 | 1 << 3) == 1 << 13 | 1 << 3;
        let by_dma = self.word(USART + 0x14) & 1 << 7 != 0;
        let channel = self.word(TX_CHANNEL);
        let left = self.word(TX_CHANNEL + 4) & 0xFFFF;
        let reads = channel & 1 != 0 && channel & 1 << 4 != 0;
        if self.leaving.is_some() || !sends || !by_dma || !reads || left == 0 {
            return;
        }
        let from = self.word(TX_CHANNEL + 0x0C);
        let value = self.read8(from);
        // The address counts inside of the channel; the register itself stays as written on a chip.
        let next = if channel & 1 << 7 != 0 { from + 1 } else { from };
        self.store(TX_CHANNEL + 0x0C, next);
        self.store(TX_CHANNEL + 4, left - 1);
        let status = self.word(USART);
        self.store(USART, status & !COMPLETE);
        self.leaving = Some(Byte { at_ns: self.now_ns + self.byte_ns(), value });
    }

    fn take_in(&mut self, value: u8) {
        let receives = self.word(USART + 0x0C) & (1 << 13 | 1 << 2) == 1 << 13 | 1 << 2;
        let by_dma = self.word(USART + 0x14) & 1 << 6 != 0;
        let channel = self.word(RX_CHANNEL);
        if !receives || !by_dma || channel & 1 == 0 || !self.is_in_step() {
            return;
        }
        let left = self.word(RX_CHANNEL + 4) & 0xFFFF;
        if left == 0 {
            return;
        }
        let at = if channel & 1 << 7 != 0 { self.receive_size - left } else { 0 };
        let to = self.word(RX_CHANNEL + 0x0C) + at;
        self.write8(to, value);
        // RM §13.3.3: a circular channel starts again by itself.
        let circular = channel & 1 << 5 != 0;
        let next = if left == 1 && circular { self.receive_size } else { left - 1 };
        self.store(RX_CHANNEL + 4, next);
    }
}
