//! A serial line on tokio's virtual clock: what one station writes, the others read byte group by
//! byte group at the line's speed. Frames are lost, and two that send at once garble each other.

use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use lafet_proto::link::{Decoder, Frame, WIRE_MAX, encode};
use lafet_sim::rng::Rng;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, ReadBuf};
use tokio::time::{Instant, Sleep, sleep_until, timeout};

/// Bytes that arrive together take this part of a second.
const GROUPS_PER_SECOND: u32 = 500;

/// A write of a station.
#[derive(Clone, Debug)]
pub struct Written {
    pub at: Instant,
    pub bytes: Vec<u8>,
}

#[derive(Debug, Default)]
struct Ear {
    groups: VecDeque<(Instant, Vec<u8>)>,
    waker: Option<Waker>,
    echo: bool,
}

#[derive(Debug)]
struct Wires {
    baud: u32,
    loss_permille: u64,
    dice: Rng,
    ears: Vec<Ear>,
    /// Who has sent last, and until when.
    busy: (usize, Instant),
    log: Vec<Written>,
}

/// The line.
#[derive(Clone, Debug)]
pub struct Medium(Arc<Mutex<Wires>>);

impl Medium {
    pub fn new(baud: u32, loss_permille: u64, seed: u64) -> Self {
        let (dice, busy) = (Rng::new(seed), (usize::MAX, Instant::now()));
        let (ears, log) = (Vec::new(), Vec::new());
        Self(Arc::new(Mutex::new(Wires { baud, loss_permille, dice, ears, busy, log })))
    }

    /// Another station; with `echo` it hears itself.
    pub fn station(&self, echo: bool) -> Station {
        let mut wires = self.0.lock().unwrap();
        wires.ears.push(Ear { echo, ..Ear::default() });
        let number = wires.ears.len() - 1;
        let timer = Box::pin(sleep_until(Instant::now()));
        Station { medium: self.clone(), number, timer }
    }

    /// Everything that was written.
    pub fn log(&self) -> Vec<Written> {
        self.0.lock().unwrap().log.clone()
    }
}

impl Wires {
    fn write(&mut self, station: usize, bytes: &[u8]) {
        let now = Instant::now();
        self.log.push(Written { at: now, bytes: bytes.to_vec() });
        let (who, until) = self.busy;
        let start = if who == station { now.max(until) } else { now };
        let mut heard = bytes.to_vec();
        let collides = who != station && until > now;
        if collides || self.dice.below(1000) < self.loss_permille {
            // A byte is hit, or all of it is lost.
            match self.dice.below(2) {
                0 => heard.clear(),
                _ => {
                    let at = self.dice.below(heard.len() as u64) as usize;
                    heard[at] ^= 0x10;
                }
            }
        }
        let byte = Duration::from_secs(10) / self.baud;
        self.busy = (station, start + byte * bytes.len() as u32);
        let size = (self.baud / 10 / GROUPS_PER_SECOND).max(1) as usize;
        for (number, group) in heard.chunks(size).enumerate() {
            let bytes = number * size + group.len();
            let at = start + byte * bytes as u32;
            for (other, ear) in self.ears.iter_mut().enumerate() {
                if other != station || ear.echo {
                    ear.groups.push_back((at, group.to_vec()));
                    ear.waker.take().into_iter().for_each(Waker::wake);
                }
            }
        }
    }
}

/// Someone on the line.
#[derive(Debug)]
pub struct Station {
    medium: Medium,
    number: usize,
    timer: Pin<Box<Sleep>>,
}

impl AsyncRead for Station {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let next = {
            let mut wires = self.medium.0.lock().unwrap();
            let ear = &mut wires.ears[self.number];
            match ear.groups.front() {
                Some((at, _)) if *at <= Instant::now() => {
                    let (_, bytes) = ear.groups.pop_front().unwrap();
                    buffer.put_slice(&bytes);
                    return Poll::Ready(Ok(()));
                }
                Some((at, _)) => *at,
                None => {
                    ear.waker = Some(cx.waker().clone());
                    return Poll::Pending;
                }
            }
        };
        self.timer.as_mut().reset(next);
        match self.timer.as_mut().poll(cx) {
            Poll::Ready(()) => {
                cx.waker().wake_by_ref();
                Poll::Pending
            }
            Poll::Pending => Poll::Pending,
        }
    }
}

impl AsyncWrite for Station {
    fn poll_write(
        self: Pin<&mut Self>,
        _: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        self.medium.0.lock().unwrap().write(self.number, bytes);
        Poll::Ready(Ok(bytes.len()))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}

/// A frame: receiver, sender, records.
pub type Said = (u8, u8, Vec<u8>);

/// Bytes between which there is less silence than this are one read.
const GAP: Duration = Duration::from_micros(2500);

/// A program on the line. What comes between two silences is one read to it.
#[derive(Debug)]
pub struct Program {
    station: Station,
    /// It looks at the first frame of a read only.
    simple: bool,
    heard: VecDeque<Said>,
}

impl Program {
    /// One that takes a read for a frame.
    pub const fn simple(station: Station) -> Self {
        Self { station, simple: true, heard: VecDeque::new() }
    }

    /// One that takes each frame.
    pub const fn thorough(station: Station) -> Self {
        Self { station, simple: false, heard: VecDeque::new() }
    }

    /// The next frame, or `None` at this time.
    pub async fn frame(&mut self, until: Option<Instant>) -> Option<Said> {
        loop {
            if let Some(frame) = self.heard.pop_front() {
                return Some(frame);
            }
            let mut read = Vec::new();
            let mut buffer = [0; 64];
            let first = self.station.read(&mut buffer);
            let len = match until {
                Some(until) => tokio::time::timeout_at(until, first).await.ok()?.unwrap(),
                None => first.await.unwrap(),
            };
            read.extend(&buffer[..len]);
            while let Ok(more) = timeout(GAP, self.station.read(&mut buffer)).await {
                read.extend(&buffer[..more.unwrap()]);
            }
            let count = if self.simple { 1 } else { usize::MAX };
            self.heard.extend(frames(&read).into_iter().take(count));
        }
    }

    pub async fn say(&mut self, dst: u8, src: u8, payload: &[u8]) {
        self.station.write_all(&encoded(dst, src, payload)).await.unwrap();
    }
}

pub fn encoded(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut wire = [0; WIRE_MAX];
    let len = encode(&Frame { dst, src, payload }, &mut wire).unwrap();
    wire[..len].to_vec()
}

/// The frames in some bytes.
pub fn frames(bytes: &[u8]) -> Vec<Said> {
    let mut decoder: Box<Decoder> = Box::default();
    let mut all = Vec::new();
    for byte in bytes {
        if let Some(Frame { dst, src, payload }) = decoder.push(*byte) {
            all.push((dst, src, payload.to_vec()));
        }
    }
    all
}
