//! Output that never waits: lines go through a bounded queue to a thread that writes them.
//!
//! For what carries the requests of others. A reader that pauses, a terminal held by Ctrl-S, a full
//! disk or a closed pipe must neither delay nor end it.

#[cfg(unix)]
use std::fs::File;
use std::io::{self, Write};
#[cfg(unix)]
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use lafet_texts::{Text as _, cli as text};

use crate::failure::Failure;
use crate::lang::current;

/// Most pieces that wait to be written; those that come then are left out, and counted.
const QUEUE: usize = 1024;
/// How long the end of the program waits for what is still to be written.
const LAST: Duration = Duration::from_secs(2);

/// A thread that writes. Its end waits for [`LAST`] at most until everything is written.
pub struct Aside(Queue);

/// The way to the thread. As [`Write`] it is standard error.
#[derive(Clone)]
pub struct Queue {
    pieces: SyncSender<Piece>,
    left_out: Arc<AtomicU64>,
}

enum Piece {
    Out(Vec<u8>),
    Err(Vec<u8>),
    /// Everything before it is written: answer.
    Flush(SyncSender<()>),
}

impl Aside {
    /// Starts the thread.
    pub fn start() -> Result<Self, Failure> {
        let (out, err) = unlocked()?;
        Self::writing(out, err)
    }

    fn writing(
        mut out: impl Write + Send + 'static,
        mut err: impl Write + Send + 'static,
    ) -> Result<Self, Failure> {
        let (pieces, queue) = sync_channel(QUEUE);
        let left_out = Arc::new(AtomicU64::new(0));
        let missed = left_out.clone();
        let thread = std::thread::Builder::new().name("lafet-output".into());
        thread.spawn(move || write(&queue, &missed, &mut out, &mut err))?;
        Ok(Self(Queue { pieces, left_out }))
    }

    /// The way to the thread.
    pub fn queue(&self) -> Queue {
        self.0.clone()
    }

    /// Prints to standard output.
    pub fn out(&self, text: String) {
        self.0.put(Piece::Out(text.into_bytes()));
    }

    /// Prints to standard error.
    pub fn err(&self, text: String) {
        self.0.put(Piece::Err(text.into_bytes()));
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        let (done, written) = sync_channel(1);
        // A queue that is full is not being written.
        if self.0.pieces.try_send(Piece::Flush(done)).is_ok() {
            let _ = written.recv_timeout(LAST);
        }
    }
}

impl Queue {
    fn put(&self, piece: Piece) {
        if self.pieces.try_send(piece).is_err() {
            self.left_out.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Write for Queue {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.put(Piece::Err(bytes.to_vec()));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Standard output and error without their locks: others that print wait for no line of the queue.
#[cfg(unix)]
fn unlocked() -> io::Result<(File, File)> {
    let [out, err] = [io::stdout().as_fd(), io::stderr().as_fd()].map(|fd| fd.try_clone_to_owned());
    Ok((out?.into(), err?.into()))
}

/// Other systems have other handles.
#[cfg(not(unix))]
fn unlocked() -> io::Result<(io::Stdout, io::Stderr)> {
    Ok((io::stdout(), io::stderr()))
}

/// Writes until the queue is gone. What cannot be written is left out: a disk may have room again.
fn write(queue: &Receiver<Piece>, missed: &AtomicU64, out: &mut impl Write, err: &mut impl Write) {
    for piece in queue {
        let count = missed.swap(0, Ordering::Relaxed);
        if count > 0 {
            let _ = writeln!(err, "{}", text::LinesLeftOut { count }.of(current()));
        }
        let _ = match piece {
            Piece::Out(bytes) => out.write_all(&bytes).and_then(|()| out.flush()),
            Piece::Err(bytes) => err.write_all(&bytes).and_then(|()| err.flush()),
            Piece::Flush(done) => {
                // The one that asked may have waited long enough.
                let _ = done.send(());
                Ok(())
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::time::Instant;

    use super::*;

    /// Takes a piece once it may.
    struct Slow {
        may: Receiver<()>,
        taken: std::sync::mpsc::Sender<String>,
    }

    impl Write for Slow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            // The test has ended.
            let _ = self.may.recv();
            let _ = self.taken.send(String::from_utf8_lossy(bytes).into_owned());
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_pauses_delays_nothing_and_what_it_misses_is_counted() {
        let (go, may) = channel();
        let (taken, lines) = channel();
        let (free, always) = channel();
        let (said, notes) = channel();
        drop(free);
        let aside = Aside::writing(Slow { may, taken }, Slow { may: always, taken: said }).unwrap();
        let began = Instant::now();
        for line in 0..3 * QUEUE {
            aside.out(format!("{line}\n"));
        }
        assert!(began.elapsed() < Duration::from_secs(60));
        drop(go);
        assert_eq!(lines.recv().unwrap(), "0\n");
        drop(aside);
        // They may be reported in parts.
        let note: String = notes.iter().collect();
        let numbers =
            note.split(|c: char| !c.is_ascii_digit()).filter_map(|it| it.parse::<usize>().ok());
        let left_out = 3 * QUEUE - 1 - lines.iter().count();
        assert!(left_out >= QUEUE && numbers.sum::<usize>() == left_out, "{left_out}: {note}");
    }

    /// Fails each time.
    struct Full;

    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_full_disk_ends_nothing() {
        let (free, always) = channel();
        let (said, notes) = channel();
        drop(free);
        let aside = Aside::writing(Full, Slow { may: always, taken: said }).unwrap();
        aside.out("lost\n".into());
        aside.err("kept\n".into());
        drop(aside);
        assert_eq!(notes.recv().unwrap(), "kept\n");
    }
}
