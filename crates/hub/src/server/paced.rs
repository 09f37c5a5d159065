//! A connection that takes no more than its share: reading is paced, and who takes nothing of what
//! is sent to it is closed.
//!
//! Every connection has a small allowance of its own, which no other connection can use up while it
//! is open; what it reads beyond that comes out of the allowance that its address shares. So one
//! that is quiet is served at once, whatever the others do.
//!
//! At its end what the client still sends is read and dropped: closing with bytes unread resets the
//! connection, and the client would lose the answer that it has not read yet.
//!
//! Over a WebSocket that cannot be written any more, what is written is dropped: its protocol answers pings while it reads,
//! and would end with the first answer that fails, before a Stop that has come behind the ping. The end of such a connection
//! is read.

use std::io;
use std::mem::MaybeUninit;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep};

use crate::api::places::{Ending, Place};
use crate::server::allowances::Allowance;
use crate::sync::lock;

/// A connection that takes nothing for this time is closed.
const STALLED: Duration = Duration::from_secs(15);
/// At its end a connection is closed when nothing has come for this time, or after the longest.
const LINGERS: Duration = Duration::from_secs(2);
const LINGERS_MAX: Duration = Duration::from_secs(30);
/// What is read and dropped at once.
const DROPPED: usize = 16 * 1024;

/// A connection that reads no faster than its allowance.
#[derive(Debug)]
pub struct Paced<S> {
    stream: S,
    /// The moment from which the time of its allowance is counted.
    start: Instant,
    allowance: Allowance,
    /// Among which connections it counts.
    place: Option<Arc<Place>>,
    /// Pause until it owes nothing.
    pause: Option<Pin<Box<Sleep>>>,
    stalled: Option<Pin<Box<Sleep>>>,
    /// Nothing can be written any more: what is, is dropped.
    mute: bool,
    /// All is sent; what still comes is dropped.
    linger: Option<Linger>,
}

/// When a connection that has ended on this side is closed.
#[derive(Debug)]
struct Linger {
    due: Pin<Box<Sleep>>,
    latest: Instant,
    #[expect(dead_code, reason = "held for its end")]
    ending: Option<Ending>,
}

impl Linger {
    fn new(ending: Option<Ending>) -> Self {
        Self { due: Box::pin(sleep(LINGERS)), latest: Instant::now() + LINGERS_MAX, ending }
    }

    /// Something has come.
    fn go_on(&mut self) {
        self.due.as_mut().reset(self.latest.min(Instant::now() + LINGERS));
    }
}

impl<S> Paced<S> {
    /// Paces a connection. What an earlier one owes is waited for first.
    pub fn new(stream: S, allowance: Allowance, start: Instant) -> Self {
        let (place, pause, stalled, linger) = (None, None, None, None);
        let mute = false;
        let mut paced = Self { stream, start, allowance, place, pause, stalled, mute, linger };
        paced.owe(0.0);
        paced
    }

    /// Paces the connection of this place.
    pub fn of(stream: S, place: &Arc<Place>, start: Instant) -> Self {
        let paced = Self::new(stream, place.allowance.clone(), start);
        Self { place: Some(place.clone()), ..paced }
    }

    /// The same, with so many readings taken before the first.
    #[must_use]
    pub fn charged(mut self, readings: f64) -> Self {
        self.turn(readings);
        self
    }

    /// So many readings more: its own, those of its address, or owed, and waited for before the next.
    fn turn(&mut self, readings: f64) {
        let now = self.start.elapsed();
        if lock(&self.allowance.readings).take_so_many(now, readings).is_ok() {
            return;
        }
        let shared = self.allowance.shared.as_ref();
        if shared.is_some_and(|it| lock(it).take_so_many(now, readings).is_err()) {
            self.owe(readings);
        }
    }

    fn owe(&mut self, readings: f64) {
        let wait = lock(&self.allowance.readings).owe(self.start.elapsed(), readings);
        self.pause = wait.map(|wait| Box::pin(sleep(wait)));
    }

    /// Watches that what is written is taken; `dropped`: what is said of it once it is dropped.
    fn watch<T>(
        &mut self,
        cx: &mut Context<'_>,
        written: Poll<io::Result<T>>,
        dropped: T,
    ) -> Poll<io::Result<T>> {
        let written = if written.is_ready() {
            self.stalled = None;
            written
        } else {
            let stalled = self.stalled.get_or_insert_with(|| Box::pin(sleep(STALLED)));
            stalled.as_mut().poll(cx).map(|()| Err(io::ErrorKind::TimedOut.into()))
        };
        let reads_on = self.place.as_ref().is_some_and(|it| it.reads_on());
        match written {
            Poll::Ready(Err(_)) if reads_on => {
                self.mute = true;
                Poll::Ready(Ok(dropped))
            }
            written => written,
        }
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Paced<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if let Some(pause) = &mut self.pause {
            ready!(pause.as_mut().poll(cx));
            self.pause = None;
        }
        let before = buffer.filled().len();
        ready!(Pin::new(&mut self.stream).poll_read(cx, buffer))?;
        // What has come is passed on; the next reading waits for its turn.
        if buffer.filled().len() > before {
            self.turn(1.0);
        }
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncRead + Unpin> Paced<S> {
    /// Reads and drops what comes until the client closes, is quiet, or has had its time.
    fn poll_linger(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        let mut dropped = [MaybeUninit::uninit(); DROPPED];
        loop {
            let over = |it: &mut Linger| it.due.as_mut().poll(cx).is_ready();
            if self.linger.as_mut().is_none_or(over) {
                return Poll::Ready(());
            }
            let mut buffer = ReadBuf::uninit(&mut dropped);
            let read = ready!(Pin::new(&mut *self).poll_read(cx, &mut buffer));
            if read.is_err() || buffer.filled().is_empty() {
                return Poll::Ready(());
            }
            self.linger.iter_mut().for_each(Linger::go_on);
        }
    }
}

impl<S: AsyncRead + AsyncWrite + Unpin> AsyncWrite for Paced<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        if self.mute {
            return Poll::Ready(Ok(bytes.len()));
        }
        let written = Pin::new(&mut self.stream).poll_write(cx, bytes);
        self.watch(cx, written, bytes.len())
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let len = parts.iter().map(|part| part.len()).sum();
        if self.mute {
            return Poll::Ready(Ok(len));
        }
        let written = Pin::new(&mut self.stream).poll_write_vectored(cx, parts);
        self.watch(cx, written, len)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        if self.mute {
            return Poll::Ready(Ok(()));
        }
        let flushed = Pin::new(&mut self.stream).poll_flush(cx);
        self.watch(cx, flushed, ())
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        if self.mute {
            return Poll::Ready(Ok(()));
        }
        if self.linger.is_none() {
            let shut = Pin::new(&mut self.stream).poll_shutdown(cx);
            ready!(self.watch(cx, shut, ()))?;
            self.linger = Some(Linger::new(self.place.as_ref().map(Place::ending)));
        }
        self.poll_linger(cx).map(Ok)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::allowances::{READINGS, SHARED};
    use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};

    fn allowance() -> Allowance {
        Allowance::new(Duration::ZERO, Some(Allowance::of_address(Duration::ZERO)))
    }

    /// Readings of one byte each until the time is over.
    async fn readings(paced: &mut Paced<tokio::io::DuplexStream>, time: Duration) -> u32 {
        let (end, mut count) = (Instant::now() + time, 0);
        while tokio::time::timeout_at(end, paced.read_u8()).await.is_ok() {
            count += 1;
        }
        count
    }

    #[tokio::test(start_paused = true)]
    async fn a_flood_uses_up_what_its_address_has_and_nobody_elses() {
        let start = Instant::now();
        let own = allowance();
        let shared = own.shared.clone();
        let (mut flood, stream) = duplex(1 << 16);
        let (mut quiet, other) = duplex(64);
        let mut stream = Paced::new(stream, own, start);
        flood.write_all(&[0; 1 << 16]).await.unwrap();
        let count = readings(&mut stream, Duration::from_secs(10)).await;
        let most = SHARED.0 + READINGS.0 + 10.0 * (SHARED.1 + READINGS.1);
        assert!(count > 2000 && f64::from(count) <= most + 1.0, "{count}");
        // Nothing is left of what the address shares; one that was quiet does not notice.
        let own = Allowance::new(start.elapsed(), shared);
        let mut other = Paced::new(other, own, start);
        quiet.write_all(&[0; 40]).await.unwrap();
        let began = Instant::now();
        for _ in 0..40 {
            other.read_u8().await.unwrap();
        }
        assert_eq!(began.elapsed(), Duration::ZERO);
    }

    #[tokio::test(start_paused = true)]
    async fn who_takes_nothing_is_let_go() {
        let (client, stream) = duplex(16);
        let mut stream = Paced::new(stream, allowance(), Instant::now());
        let began = Instant::now();
        let error = stream.write_all(&[0; 64]).await.unwrap_err();
        assert_eq!((error.kind(), began.elapsed()), (io::ErrorKind::TimedOut, STALLED));
        drop(client);
    }

    #[tokio::test(start_paused = true)]
    async fn what_comes_after_the_end_is_dropped_until_it_ends() {
        let part = Duration::from_millis(900);
        let closed_after = async |parts: u32, closes: bool| {
            let (mut client, stream) = duplex(64);
            let mut stream = Paced::new(stream, allowance(), Instant::now());
            let began = Instant::now();
            let sends = async move {
                for _ in 0..parts {
                    sleep(part).await;
                    client.write_all(&[0; 64]).await.unwrap();
                }
                if !closes {
                    sleep(2 * LINGERS_MAX).await;
                }
            };
            let sends = tokio::spawn(sends);
            stream.shutdown().await.unwrap();
            sends.abort();
            began.elapsed()
        };
        assert_eq!(closed_after(0, true).await, Duration::ZERO);
        assert_eq!(closed_after(0, false).await, LINGERS);
        assert_eq!(closed_after(5, true).await, part * 5);
        assert_eq!(closed_after(5, false).await, part * 5 + LINGERS);
        assert_eq!(closed_after(1000, true).await, LINGERS_MAX);
    }

    #[tokio::test(start_paused = true)]
    async fn what_is_charged_before_is_waited_for_when_nothing_is_left() {
        let (start, own) = (Instant::now(), allowance());
        let first_byte_after = async |readings: f64| {
            let (mut client, stream) = duplex(16);
            client.write_all(&[0]).await.unwrap();
            let began = Instant::now();
            let mut stream = Paced::new(stream, own.clone(), start).charged(readings);
            stream.read_u8().await.unwrap();
            began.elapsed()
        };
        assert_eq!(first_byte_after(20.0).await, Duration::ZERO, "its own");
        assert_eq!(first_byte_after(1000.0).await, Duration::ZERO, "those of its address");
        assert!(lock(own.shared.as_ref().unwrap()).take_so_many(start.elapsed(), 999.0).is_ok());
        assert_eq!(first_byte_after(20.0).await, Duration::ZERO, "its own");
        let waited = first_byte_after(20.0).await;
        assert!((500..900).contains(&waited.as_millis()), "{waited:?}");
    }
}
