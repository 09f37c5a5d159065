//! The line: RS-485 on USART1. Bytes come and go by DMA, so that neither a step nor an answer waits for
//! them; an interrupt switches the transmitter off with the last stop bit.

use crate::bus::{Bus, Registers, address};
use crate::pins::TRANSMIT;
use stm32_metapac::bdma::regs::Isr;
use stm32_metapac::bdma::vals::Dir;
use stm32_metapac::usart::regs::{Brr, Sr};
use stm32_metapac::{DMA1, USART1};

/// The ring that is received into: at 115,200 baud what comes in 50 ms. A page is erased in 44 ms, and the step
/// before it may have left some: what is written over takes all with it, as only the place of the last byte is known.
pub const RECEIVED: usize = 576;
/// The ring that is sent from: the greatest answer, and as much again for those behind it.
pub const SENT: usize = 2_048;
/// RM §13.3.7, table 78: USART1_TX and USART1_RX, counted from 0.
const TX: usize = 3;
const RX: usize = 4;
/// Looks until a transmission that is waited for must be over: it takes 47 ms at most, these 0.1 s or so, of
/// which the watchdog has time for several.
const LOOKS: u32 = 500_000;
/// CTS, LBD and RXNE.
const STATUS_KEPT: u32 = 1 << 9 | 1 << 8 | 1 << 5;
/// The interrupt of USART1, its number and its place in the NVIC's second register.
pub const IRQ: u16 = 37;
const NVIC_ENABLE: u32 = 0xE000_E104;

/// The line.
#[derive(Clone, Debug)]
pub struct Line<B> {
    bus: B,
    received: u32,
    sent: u32,
    /// Next byte to be taken of what was received.
    taken: usize,
    /// Next byte to be sent, and the next to be filled.
    first: usize,
    end: usize,
    /// Bytes that the DMA is at.
    sending: usize,
}

impl<B: Bus> Line<B> {
    /// Starts it; the rings, of [`RECEIVED`] and [`SENT`] bytes, are at these addresses.
    pub fn start(bus: B, hz: u32, baud: u32, received: u32, sent: u32) -> Self {
        // RM §27.3.4: in sixteenths, which makes it the ratio itself.
        let divider = (hz + baud / 2).checked_div(baud).unwrap_or_default();
        bus.put(USART1.brr(), Brr(divider));
        bus.set(USART1.cr3(), |cr3| {
            cr3.set_dmar(true);
            cr3.set_dmat(true);
        });
        bus.set(USART1.cr1(), |cr1| {
            cr1.set_ue(true);
            cr1.set_te(true);
            cr1.set_re(true);
        });
        let channel = DMA1.ch(RX);
        bus.put(channel.par(), address(USART1.dr()));
        bus.put(channel.mar(), received);
        bus.set(channel.ndtr(), |ndtr| ndtr.set_ndt(RECEIVED as u16));
        bus.set(channel.cr(), |cr| {
            cr.set_minc(true);
            cr.set_circ(true);
            cr.set_en(true);
        });
        bus.put(DMA1.ch(TX).par(), address(USART1.dr()));
        bus.write(NVIC_ENABLE, 1 << (IRQ - 32));
        Self { bus, received, sent, taken: 0, first: 0, end: 0, sending: 0 }
    }

    /// What has come and fits.
    pub fn receive<'b>(&mut self, buffer: &'b mut [u8]) -> &'b [u8] {
        let status = self.bus.get(USART1.sr());
        if status.ore() || status.ne() || status.fe() {
            // RM §27.6.1: reading status and data clears them; the frame's checksum judges the bytes.
            let _ = self.bus.get(USART1.dr());
        }
        let left = usize::from(self.bus.get(DMA1.ch(RX).ndtr()).ndt());
        let filled = RECEIVED.saturating_sub(left) % RECEIVED;
        let mut len = 0;
        for place in &mut *buffer {
            if self.taken == filled {
                break;
            }
            *place = self.bus.read8(self.received + self.taken as u32);
            self.taken = (self.taken + 1) % RECEIVED;
            len += 1;
        }
        buffer.get(..len).unwrap_or_default()
    }

    /// Adds a byte to what is to be sent. Where there is no room left it is lost, and with it the frame.
    pub fn put(&mut self, byte: u8) {
        let next = (self.end + 1) % SENT;
        if next != self.first {
            self.bus.write8(self.sent + self.end as u32, byte);
            self.end = next;
        }
    }

    /// Sends on, if there is something to be sent and the line is free.
    pub fn send(&mut self) {
        if self.bus.get(USART1.cr1()).tcie() {
            return;
        }
        self.first = (self.first + self.sending) % SENT;
        // Up to the end of the ring; the rest goes out behind it.
        let until = if self.end < self.first { SENT } else { self.end };
        self.sending = until - self.first;
        if self.sending == 0 {
            return;
        }
        let channel = DMA1.ch(TX);
        self.bus.put(channel.cr(), stm32_metapac::bdma::regs::Cr(0));
        self.bus.put(DMA1.ifcr(), Isr(0xF << (4 * TX)));
        self.bus.put(channel.mar(), self.sent + self.first as u32);
        self.bus.set(channel.ndtr(), |ndtr| ndtr.set_ndt(self.sending as u16));
        TRANSMIT.drive(&self.bus, true);
        // RM §27.3.13, §27.6.1: TC is cleared before the transfer, or it would end it at once. A zero
        // clears, so the flags of the receiver are written as ones.
        self.bus.put(USART1.sr(), Sr(STATUS_KEPT));
        self.bus.set(channel.cr(), |cr| {
            cr.set_dir(Dir::FROM_MEMORY);
            cr.set_minc(true);
            cr.set_en(true);
        });
        self.bus.change(USART1.cr1(), |cr1| cr1.set_tcie(true));
    }

    /// Whether everything has left.
    pub fn is_idle(&self) -> bool {
        !self.bus.get(USART1.cr1()).tcie() && (self.first + self.sending) % SENT == self.end
    }
}

/// Before the processor is stalled for so many of its cycles: waits for a transmission that would end
/// meanwhile. Its interrupt would come late, and the driver would hold the line against its next sender.
pub fn end_before(bus: &impl Bus, cycles: u32) {
    // RM §27.3.4: a bit takes as many cycles as the divider says. Beside these bytes one is in the data
    // register where there are any: longer than it takes from here to the stall.
    let Brr(divider) = bus.get(USART1.brr());
    let left = u32::from(bus.get(DMA1.ch(TX).ndtr()).ndt());
    if left * 10 * divider < cycles {
        bus.wait(USART1.cr1(), LOOKS, |cr1| !cr1.tcie());
    }
}

/// The interrupt of USART1: all that was given to the DMA has left.
pub fn on_interrupt(bus: &impl Bus) {
    if bus.get(USART1.sr()).tc() && bus.get(DMA1.ch(TX).ndtr()).ndt() == 0 {
        TRANSMIT.drive(bus, false);
        bus.change(USART1.cr1(), |cr1| cr1.set_tcie(false));
    }
}
