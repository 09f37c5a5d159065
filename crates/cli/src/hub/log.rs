//! The log of the hub, on standard error. A thread of its own writes it: a reader that stops, as a terminal
//! after Ctrl-S or a pipe that is not read, holds up that thread and nothing else.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::time::{Duration, Instant};

use tracing_subscriber::filter::Targets;
use tracing_subscriber::prelude::*;

/// Environment variable of the log filter: `LAFET_LOG=info`, `LAFET_LOG=lafet_hub=debug`.
const LOG: &str = "LAFET_LOG";
/// Lines that wait for the reader; more are given up and counted.
const LINES_MAX: usize = 4096;
/// Longest wait at the end for a reader that takes what waits.
const FAREWELL: Duration = Duration::from_secs(1);

/// The log, until it is dropped: what waits then is written, if the reader takes it.
#[derive(Debug)]
#[must_use = "the last lines are written when it is dropped"]
pub struct Log(Arc<Counts>);

#[derive(Debug, Default)]
struct Counts {
    /// Lines that are not written yet.
    waiting: AtomicU64,
    /// Lines that were given up and not reported yet.
    lost: AtomicU64,
}

/// Takes a line and waits for nothing.
#[derive(Clone, Debug)]
struct Line {
    to: SyncSender<Vec<u8>>,
    counts: Arc<Counts>,
}

impl Write for Line {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        self.counts.waiting.fetch_add(1, Ordering::AcqRel);
        if self.to.try_send(line.to_vec()).is_err() {
            self.counts.waiting.fetch_sub(1, Ordering::AcqRel);
            self.counts.lost.fetch_add(1, Ordering::AcqRel);
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        let until = Instant::now() + FAREWELL;
        while self.0.waiting.load(Ordering::Acquire) > 0 && Instant::now() < until {
            std::thread::park_timeout(Duration::from_millis(2));
        }
    }
}

/// Logs to standard error, as text or as JSON.
pub fn log(json: bool, usual: &str) -> io::Result<Log> {
    let wanted = std::env::var(LOG).unwrap_or_else(|_| usual.to_owned());
    let targets = wanted.parse::<Targets>().unwrap_or_default();
    let (to, lines) = sync_channel(LINES_MAX);
    let counts = Arc::new(Counts::default());
    let (line, own) = (Line { to, counts: counts.clone() }, counts.clone());
    let error = standard_error()?;
    let thread = std::thread::Builder::new().name("lafet-log".into());
    thread.spawn(move || write(&lines, error, &own))?;
    let layer = tracing_subscriber::fmt::layer().with_writer(move || line.clone());
    let registry = tracing_subscriber::registry();
    // A logger that was set before stays.
    _ = if json {
        registry.with(layer.json().with_filter(targets)).try_init()
    } else {
        registry.with(layer.with_target(false).with_filter(targets)).try_init()
    };
    // A panic writes by itself, and would wait for the reader.
    std::panic::set_hook(Box::new(|panic| tracing::error!("{panic}")));
    Ok(Log(counts))
}

/// Standard error without its lock: who else writes there, as at the end, waits for no line of the log.
#[cfg(unix)]
fn standard_error() -> io::Result<std::fs::File> {
    use std::os::fd::AsFd;
    io::stderr().as_fd().try_clone_to_owned().map(std::fs::File::from)
}

/// Other systems have other handles.
#[cfg(not(unix))]
fn standard_error() -> io::Result<io::Stderr> {
    Ok(io::stderr())
}

/// Writes lines as the reader takes them, and reports those that were given up once it does again.
fn write(lines: &Receiver<Vec<u8>>, mut to: impl Write, counts: &Counts) {
    loop {
        let line = match lines.try_recv() {
            Ok(line) => line,
            Err(TryRecvError::Empty) => {
                let lost = counts.lost.swap(0, Ordering::AcqRel);
                if lost > 0 {
                    tracing::warn!(lost, "lines of the log were given up: nothing read them");
                }
                match lines.recv() {
                    Ok(line) => line,
                    Err(_) => return,
                }
            }
            Err(TryRecvError::Disconnected) => return,
        };
        // Without a reader the hub goes on.
        _ = to.write_all(&line);
        counts.waiting.fetch_sub(1, Ordering::AcqRel);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Sender, channel};

    use super::*;

    /// A reader that takes a line each time that it is asked to.
    struct Reader {
        asked: Receiver<()>,
        read: Sender<Vec<u8>>,
    }

    impl Write for Reader {
        fn write(&mut self, line: &[u8]) -> io::Result<usize> {
            _ = self.asked.recv();
            _ = self.read.send(line.to_vec());
            Ok(line.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_stops_loses_lines_and_holds_nothing_up() {
        let (to, lines) = sync_channel(LINES_MAX);
        let counts = Arc::new(Counts::default());
        let mut line = Line { to, counts: counts.clone() };
        let (ask, asked) = channel();
        let (read, had) = channel();
        let own = counts.clone();
        let thread = std::thread::spawn(move || write(&lines, Reader { asked, read }, &own));
        for _ in 0..LINES_MAX + 100 {
            line.write_all(b"line").unwrap();
        }
        let lost = counts.lost.load(Ordering::Acquire);
        assert!((99..=100).contains(&lost), "one may be with the reader already: {lost}");
        drop(line);
        drop(ask);
        thread.join().unwrap();
        assert_eq!(had.iter().count() as u64 + lost, LINES_MAX as u64 + 100);
        assert_eq!(counts.waiting.load(Ordering::Acquire), 0);
    }
}
