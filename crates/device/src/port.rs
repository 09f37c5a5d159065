//! Link frames on one medium of the monitor: bytes in, the bytes of the answer out.

use crate::device::Device;
use crate::ear::Ear;
pub use crate::ear::Probes;
use crate::subsystem::conn::Source;
use lafet_proto::link::{self, BODY_MAX, Check, Counters, Decoder, Frame, PAYLOAD_MAX, Tally};
use lafet_proto::record::{DATA_MAX, HEADER_SIZE};

/// §L/4 A frame that has not been finished for so long, without a byte, is none any more, ms (ours): noise that
/// looks like its end must not carry out minutes later what it asks for.
const STALE_MS: u32 = 1000;

/// One medium: an RS-485 line, a TCP connection, a radio modem. `C` is what is counted: `()` is nothing.
#[derive(Clone, Debug)]
pub struct Port<C = Counters> {
    source: Source,
    decoder: Decoder<BODY_MAX, C>,
    /// When the last bytes came.
    heard_ms: u32,
    ear: Ear,
}

impl Port {
    /// A medium that belongs to this interface.
    pub const fn new(source: Source) -> Self {
        Self::counting(source)
    }

    /// What has been received so far.
    pub const fn counters(&self) -> &Counters {
        self.decoder.counters()
    }

    /// Takes bytes until a frame for this monitor is complete: returns how many were taken, and
    /// how many bytes of answer stand in `out` ([`link::WIRE_MAX`] bytes suffice).
    ///
    /// Call it again with the rest until all bytes are taken.
    #[inline(never)]
    pub fn receive(
        &mut self,
        now_ms: u32,
        device: &mut Device,
        bytes: &[u8],
        out: &mut [u8],
    ) -> (usize, usize) {
        let mut taken = 0;
        if !bytes.is_empty() {
            self.hear(now_ms);
        }
        while let Some(rest) = bytes.get(taken..).filter(|rest| !rest.is_empty()) {
            let (used, frame) = self.decoder.push_slice(rest);
            let found = frame.is_some();
            taken += used;
            let (check, frame) = (self.decoder.check(), self.decoder.last());
            let Some(frame) = frame.filter(|_| found) else { continue };
            if !is_strong(self.source, check, device)
                || !self.ear.admits(now_ms, device.address(), &frame)
            {
                continue;
            }
            if let Some(len) = respond(now_ms, self.source, check, device, &frame, out) {
                return (taken, len);
            }
        }
        (taken, 0)
    }
}

impl<C: Tally> Port<C> {
    /// A medium that belongs to this interface, whatever it counts.
    pub const fn counting(source: Source) -> Self {
        Self { source, decoder: Decoder::counting(), heard_ms: 0, ear: Ear::new() }
    }

    /// Bytes come now: of what came long before them nothing is left.
    fn hear(&mut self, now_ms: u32) {
        if is_stale(&mut self.heard_ms, now_ms) {
            self.decoder.reset();
        }
    }

    /// Takes all these bytes, and puts those of the answers on the line one by one: no room for
    /// them is needed.
    pub fn serve(
        &mut self,
        now_ms: u32,
        device: &mut Device,
        bytes: &[u8],
        put: &mut dyn FnMut(u8),
    ) {
        if !bytes.is_empty() {
            self.hear(now_ms);
        }
        for byte in bytes {
            if self.decoder.push(*byte).is_none() {
                continue;
            }
            let (source, check) = (self.source, self.decoder.check());
            let address = device.address();
            let Some(frame) = self.decoder.last() else { continue };
            if !is_strong(source, check, device) || !self.ear.admits(now_ms, address, &frame) {
                continue;
            }
            let mut answer = [0; PAYLOAD_MAX];
            let len = device.handle(now_ms, source, frame.payload, &mut answer);
            let payload = answer.get(..len).unwrap_or_default();
            let reply = Frame { dst: frame.src, src: address, payload };
            link::send(check, &reply, put);
        }
    }
}

/// §C/3 A connection that carries bare records instead of frames: one monitor, no address, no CRC.
#[derive(Clone, Debug)]
pub struct RecordPort {
    source: Source,
    record: [u8; HEADER_SIZE + DATA_MAX],
    len: usize,
    /// When the last bytes came.
    heard_ms: u32,
}

impl RecordPort {
    /// A connection that belongs to this interface.
    pub const fn new(source: Source) -> Self {
        Self { source, record: [0; HEADER_SIZE + DATA_MAX], len: 0, heard_ms: 0 }
    }

    /// Takes bytes until a record is complete: returns how many were taken, and how many bytes of
    /// answer stand in `out` ([`PAYLOAD_MAX`] bytes suffice).
    ///
    /// Call it again with the rest until all bytes are taken. Each record is answered by itself. One that was cut
    /// short is dropped as an unfinished frame is: what comes later is not its rest.
    pub fn receive(
        &mut self,
        now_ms: u32,
        device: &mut Device,
        bytes: &[u8],
        out: &mut [u8],
    ) -> (usize, usize) {
        if !bytes.is_empty() && is_stale(&mut self.heard_ms, now_ms) {
            self.len = 0;
        }
        for (index, byte) in bytes.iter().enumerate() {
            if let Some(place) = self.record.get_mut(self.len) {
                *place = *byte;
                self.len += 1;
            }
            let [_, _, _, data_size, ..] = self.record;
            if self.len >= HEADER_SIZE + usize::from(data_size) {
                let record = self.record.get(..self.len).unwrap_or_default();
                let answer = device.handle(now_ms, self.source, record, out);
                self.len = 0;
                return (index + 1, answer);
            }
        }
        (bytes.len(), 0)
    }
}

/// One datagram, one frame (ours): the length of the answer in `out`, if there is one.
pub fn datagram(
    now_ms: u32,
    source: Source,
    probes: &mut Probes,
    device: &mut Device,
    datagram: &[u8],
    out: &mut [u8],
) -> Option<usize> {
    let mut body = [0; BODY_MAX];
    let frame = link::decode_datagram(datagram, &mut body).ok()?;
    let check = link::check_of(datagram);
    let to_us = frame.dst == device.address() && frame.src != frame.dst;
    if !to_us || !is_strong(source, check, device) || !probes.admit(now_ms, &frame) {
        return None;
    }
    respond(now_ms, source, check, device, &frame, out)
}

/// Bytes come now: whether what came before them is too old to go on.
const fn is_stale(heard_ms: &mut u32, now_ms: u32) -> bool {
    now_ms.wrapping_sub(core::mem::replace(heard_ms, now_ms)) >= STALE_MS
}

/// §L/7 The answer goes the way the frame came.
fn respond(
    now_ms: u32,
    source: Source,
    check: Check,
    device: &mut Device,
    frame: &Frame<'_>,
    out: &mut [u8],
) -> Option<usize> {
    // A new address holds for the answers after this one.
    let address = device.address();
    link::compose(check, frame.src, address, out, |place| {
        let room = place.len().min(PAYLOAD_MAX);
        Some(device.handle(now_ms, source, frame.payload, place.get_mut(..room)?))
    })
}

/// §L/7 Noise that spoils the mark of a CRC-32C leaves a CRC-16 to judge by; who wants none of that
/// says so.
fn is_strong(source: Source, check: Check, device: &Device) -> bool {
    check != Check::Crc16 || !device.wants_crc32c(source)
}
