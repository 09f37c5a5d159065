//! A connection that takes no more than its share: reading is paced, and who takes nothing of what
//! is sent to it is let go.
//!
//! Every connection has a small allowance of its own, which no other connection can use up; what it
//! reads beyond that comes out of the allowance that its address shares. So one that is quiet is
//! served at once, whatever the others do.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep};

use crate::access::Bucket;
use crate::sync::lock;

/// Readings of a connection: so many at once, so many a second.
const OWN: (f64, f64) = (50.0, 25.0);
/// And of all connections of an address beyond that.
pub const SHARED: (f64, f64) = (2000.0, 1000.0);
/// A connection that takes nothing for this time is closed.
const STALLED: Duration = Duration::from_secs(15);

/// The allowance of an address.
pub type Shared = Arc<Mutex<Bucket>>;

/// A paced connection.
#[derive(Debug)]
pub struct Paced<S> {
    stream: S,
    start: Instant,
    own: Bucket,
    /// `None`: a proxy of ours, behind which there are many.
    shared: Option<(Shared, Instant)>,
    pause: Option<Pin<Box<Sleep>>>,
    stalled: Option<Pin<Box<Sleep>>>,
}

impl<S> Paced<S> {
    /// Paces a connection; `shared` with the moment from which its time is counted.
    pub fn new(stream: S, shared: Option<(Shared, Instant)>) -> Self {
        let own = Bucket::new(Duration::ZERO, OWN.0, OWN.1);
        Self { stream, start: Instant::now(), own, shared, pause: None, stalled: None }
    }

    /// One reading more; or the time to wait for the next one.
    fn turn(&mut self) -> Result<(), Duration> {
        let Err(wait) = self.own.take(self.start.elapsed()) else { return Ok(()) };
        match &self.shared {
            Some((shared, start)) if lock(shared).take(start.elapsed()).is_err() => Err(wait),
            _ => Ok(()),
        }
    }

    /// Watches that what is written is taken.
    fn watch<T>(
        &mut self,
        cx: &mut Context<'_>,
        written: Poll<io::Result<T>>,
    ) -> Poll<io::Result<T>> {
        if written.is_ready() {
            self.stalled = None;
            return written;
        }
        let stalled = self.stalled.get_or_insert_with(|| Box::pin(sleep(STALLED)));
        match stalled.as_mut().poll(cx) {
            Poll::Ready(()) => Poll::Ready(Err(io::ErrorKind::TimedOut.into())),
            Poll::Pending => Poll::Pending,
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
            let now = self.start.elapsed();
            _ = self.own.take(now);
        }
        let before = buffer.filled().len();
        ready!(Pin::new(&mut self.stream).poll_read(cx, buffer))?;
        // What has come is passed on; the next reading waits for its turn.
        if buffer.filled().len() > before
            && let Err(wait) = self.turn()
        {
            self.pause = Some(Box::pin(sleep(wait)));
        }
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Paced<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(cx, bytes);
        self.watch(cx, written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(cx, parts);
        self.watch(cx, written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let flushed = Pin::new(&mut self.stream).poll_flush(cx);
        self.watch(cx, flushed)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let shut = Pin::new(&mut self.stream).poll_shutdown(cx);
        self.watch(cx, shut)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};

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
        let shared = Arc::new(Mutex::new(Bucket::new(Duration::ZERO, SHARED.0, SHARED.1)));
        let (mut flood, stream) = duplex(1 << 16);
        let (mut quiet, other) = duplex(64);
        let mut stream = Paced::new(stream, Some((shared.clone(), start)));
        flood.write_all(&[0; 1 << 16]).await.unwrap();
        let count = readings(&mut stream, Duration::from_secs(10)).await;
        let most = SHARED.0 + OWN.0 + 10.0 * (SHARED.1 + OWN.1);
        assert!(count > 2000 && f64::from(count) <= most + 1.0, "{count}");
        // Nothing is left of what the address shares; one that was quiet does not notice.
        let mut other = Paced::new(other, Some((shared, start)));
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
        let mut stream = Paced::new(stream, None);
        let began = Instant::now();
        let error = stream.write_all(&[0; 64]).await.unwrap_err();
        assert_eq!((error.kind(), began.elapsed()), (io::ErrorKind::TimedOut, STALLED));
        drop(client);
    }
}
