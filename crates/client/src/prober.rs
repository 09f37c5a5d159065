//! A link without a session: sends probes and records everything that is received.
//!
//! A client accepts only answers to its requests. A scan or a diagnosis of a line needs all frames.

use std::io;
use std::time::Duration;

use lafet_proto::bus;
use lafet_proto::link::{Check, Counters, Decoder, Frame, WIRE_MAX, encode_with};
use tokio::time::{Instant, timeout};

use crate::transport::Link;

/// Frames and bytes that are kept from one call; the rest is only counted.
const FRAMES_MAX: usize = 256;
const SAMPLE_MAX: usize = 64;
/// Longest time in which a link takes a frame.
const SEND_MAX: Duration = Duration::from_secs(1);

/// A received frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeardFrame {
    /// Receiver.
    pub dst: u8,
    /// Sender.
    pub src: u8,
    /// Its records; empty in a presence probe and in the answer to one.
    pub payload: Vec<u8>,
    /// Checksum of the frame.
    pub check: Check,
    /// Time from the start of the call to the end of the frame.
    pub after: Duration,
}

impl HeardFrame {
    /// The address that transmits without being asked: the sender, or the receiver of a monitor's
    /// answer, which must have asked for it.
    pub fn speaker(&self) -> u8 {
        if bus::MONITORS.contains(&self.src) { self.dst } else { self.src }
    }
}

/// What was received in one call.
#[derive(Clone, Debug, Default)]
pub struct Heard {
    /// Number of bytes.
    pub bytes: usize,
    /// The first bytes.
    pub sample: Vec<u8>,
    /// Frames without errors.
    pub frames: Vec<HeardFrame>,
    /// Frames that were dropped: wrong CRC, wrong escape, too long or without an end.
    pub broken: u64,
    /// Bytes that belong to no good frame.
    pub stray_bytes: u64,
    /// Frames equal to the one sent.
    pub echoes: usize,
}

impl Heard {
    /// Whether bytes were received, but no frame could be read.
    pub fn is_garbage(&self) -> bool {
        self.bytes > 0 && self.frames.is_empty() && self.echoes == 0
    }

    /// Frames with this sender and receiver.
    pub fn from(&self, src: u8, dst: u8) -> impl Iterator<Item = &HeardFrame> {
        self.frames.iter().filter(move |frame| (frame.src, frame.dst) == (src, dst))
    }

    /// Adds what was received later.
    pub fn add(&mut self, later: Self) {
        self.bytes += later.bytes;
        let room = SAMPLE_MAX.saturating_sub(self.sample.len());
        self.sample.extend(later.sample.into_iter().take(room));
        let room = FRAMES_MAX.saturating_sub(self.frames.len());
        self.frames.extend(later.frames.into_iter().take(room));
        self.broken += later.broken;
        self.stray_bytes += later.stray_bytes;
        self.echoes += later.echoes;
    }
}

/// Sends single frames over a link and records what is received.
pub struct Prober {
    link: Link,
    source: u8,
    decoder: Box<Decoder>,
    sent: Option<HeardFrame>,
}

impl Prober {
    /// A prober with the address `source`.
    pub fn new(link: Link, source: u8) -> Self {
        Self { link, source, decoder: Box::new(Decoder::new()), sent: None }
    }

    /// Receives for this time.
    ///
    /// # Errors
    ///
    /// The error of the link when it is lost.
    pub async fn listen(&mut self, time: Duration) -> io::Result<Heard> {
        self.hear(time, |_| false).await
    }

    /// Receives until a frame has come, or for this time.
    ///
    /// # Errors
    ///
    /// The error of the link when it is lost.
    pub async fn listen_for_frame(&mut self, time: Duration) -> io::Result<Heard> {
        self.hear(time, |_| true).await
    }

    /// After bytes that were no frames: receives until a frame has come, or for this time; whether such
    /// bytes keep coming. Those that come once, as when a transceiver is switched on, are no traffic.
    pub(crate) async fn listen_on(
        &mut self,
        heard: &mut Heard,
        time: Duration,
    ) -> io::Result<bool> {
        let later = self.listen_for_frame(time).await?;
        let goes_on = later.is_garbage();
        heard.add(later);
        Ok(goes_on)
    }

    /// Gives the link back.
    pub fn into_link(self) -> Link {
        self.link
    }

    /// Sends a frame (a presence probe when `payload` is empty), and receives until its receiver
    /// has answered, or for `time`.
    ///
    /// # Errors
    ///
    /// The error of the link when it is lost; `TimedOut` when it takes no bytes for a second;
    /// `InvalidInput` for more than 512 bytes of payload.
    pub async fn ask(
        &mut self,
        dst: u8,
        payload: &[u8],
        check: Check,
        time: Duration,
    ) -> io::Result<Heard> {
        let src = self.source;
        let mut wire = [0; WIRE_MAX];
        let frame = Frame { dst, src, payload };
        let len = encode_with(check, &frame, &mut wire).ok_or(io::ErrorKind::InvalidInput)?;
        let payload = payload.to_vec();
        self.sent = Some(HeardFrame { dst, src, payload, check, after: Duration::ZERO });
        self.send(wire.get(..len).unwrap_or_default()).await?;
        self.hear(time, |frame| (frame.src, frame.dst) == (dst, src)).await
    }

    /// Sends bytes unchanged, and receives for `time`.
    ///
    /// # Errors
    ///
    /// The error of the link when it is lost.
    pub async fn say(&mut self, bytes: &[u8], time: Duration) -> io::Result<Heard> {
        self.sent = None;
        self.send(bytes).await?;
        self.listen(time).await
    }

    /// A port may take no bytes: an adapter that hangs.
    async fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let sent = timeout(SEND_MAX, self.link.send(bytes)).await;
        sent.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
    }

    async fn hear(
        &mut self,
        time: Duration,
        enough: impl Fn(&HeardFrame) -> bool,
    ) -> io::Result<Heard> {
        let start = Instant::now();
        let before = *self.decoder.counters();
        let mut heard = Heard::default();
        let mut buffer = [0; 2 * WIRE_MAX];
        let mut done = false;
        while !done {
            let left = time.saturating_sub(start.elapsed());
            // Where bytes come without a pause, no read has to wait until its time is over.
            if left.is_zero() && heard.bytes > 0 {
                break;
            }
            let Ok(read) = timeout(left, self.link.recv(&mut buffer)).await else { break };
            let bytes = buffer.get(..read?).unwrap_or_default();
            heard.bytes += bytes.len();
            let room = SAMPLE_MAX.saturating_sub(heard.sample.len());
            heard.sample.extend(bytes.iter().take(room));
            if self.link.is_datagram() {
                // One datagram is one frame: the next one does not continue a broken frame.
                self.decoder.reset();
            }
            for byte in bytes {
                let Some(Frame { dst, src, payload }) = self.decoder.push(*byte) else { continue };
                let payload = payload.to_vec();
                let check = self.decoder.check();
                let frame = HeardFrame { dst, src, payload, check, after: start.elapsed() };
                if self.sent.as_ref().is_some_and(|sent| is_same(sent, &frame)) {
                    heard.echoes += 1;
                    continue;
                }
                done |= enough(&frame);
                if heard.frames.len() < FRAMES_MAX {
                    heard.frames.push(frame);
                }
            }
        }
        let Counters { crc_errors, escape_errors, overruns, resyncs, bytes_skipped, .. } =
            *self.decoder.counters();
        let broken = |c: &Counters| c.crc_errors + c.escape_errors + c.overruns + c.resyncs;
        heard.broken = crc_errors + escape_errors + overruns + resyncs - broken(&before);
        heard.stray_bytes = bytes_skipped - before.bytes_skipped;
        Ok(heard)
    }
}

fn is_same(one: &HeardFrame, other: &HeardFrame) -> bool {
    (one.dst, one.src, &one.payload) == (other.dst, other.src, &other.payload)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The other side takes no bytes.
    #[tokio::test(start_paused = true)]
    async fn a_link_that_takes_nothing() {
        let (ours, _theirs) = crate::transport::memory::pair();
        let mut prober =
            Prober::new(Link::Memory(crate::transport::memory::Memory::new(ours)), 129);
        let start = Instant::now();
        let full = loop {
            if let Err(error) = prober.say(&[0x55; WIRE_MAX], Duration::ZERO).await {
                break error;
            }
            assert!(start.elapsed() < 60 * SEND_MAX, "it takes everything");
        };
        assert_eq!(full.kind(), io::ErrorKind::TimedOut);
    }
}
