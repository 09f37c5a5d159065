//! Has another thread of the runtime look at the connections again and again.
//!
//! The thread that looks at them and finds a single task to do does it itself, and tokio leaves the connections and the
//! clock to it until it is done, though others are idle. Work that took long there would hold up a Stop for as long.

use std::io;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use tokio::runtime::Handle;

/// The longest time for which a thread that is busy has the connections.
const EVERY: Duration = Duration::from_millis(10);

/// Looks until it is dropped.
#[derive(Debug)]
pub struct Looks {
    _ends: Sender<()>,
}

/// Starts to look.
///
/// # Errors
///
/// No thread can be started.
pub fn start(runtime: &Handle) -> io::Result<Looks> {
    let (ends, ended) = channel();
    let runtime = runtime.clone();
    thread::Builder::new().name("lafet-looks".into()).spawn(move || {
        while ended.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
            // What wakes a thread that waits; when it has nothing to do, it looks.
            drop(runtime.spawn(std::future::ready(())));
        }
    })?;
    Ok(Looks { _ends: ends })
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use tokio::time::sleep;

    use super::*;

    /// The clock goes on beside a thread that it has woken and that is busy then.
    #[test]
    fn a_busy_thread_does_not_keep_the_clock() {
        const BUSY: Duration = Duration::from_millis(600);
        let mut builder = tokio::runtime::Builder::new_multi_thread();
        let runtime = builder.worker_threads(2).enable_all().build().unwrap();
        let _looks = start(runtime.handle()).unwrap();
        for _ in 0..3 {
            let busy = runtime.spawn(async {
                sleep(Duration::from_millis(30)).await;
                let began = Instant::now();
                while began.elapsed() < BUSY {
                    std::hint::spin_loop();
                }
            });
            let began = Instant::now();
            runtime.block_on(async {
                sleep(Duration::from_millis(60)).await;
            });
            assert!(began.elapsed() < BUSY / 2, "{:?}", began.elapsed());
            runtime.block_on(busy).unwrap();
        }
    }
}
