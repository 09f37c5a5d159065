//! Ctrl-C and the signals that end a program.

use std::cell::Cell;
use std::time::Duration;

use lafet_texts::cli as text;
use tokio::time::Instant;

use crate::failure::Failure;
#[cfg(unix)]
use crate::lang::current;

/// A Ctrl-C within this time after a signal belongs to it: keys bounce, and a terminal that closes
/// sends several signals.
const DELIBERATE: Duration = Duration::from_secs(1);

thread_local! {
    /// How many commands of this thread watch for signals; all of a program run on one.
    static WATCHING: Cell<usize> = const { Cell::new(0) };
}

/// The signal caught.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Caught {
    /// Ctrl-C: the current command is to end.
    CtrlC,
    /// The program is to end.
    End,
    /// The terminal is gone; to a program that has none, that it is to read its files again.
    Hangup,
}

impl Caught {
    /// Whether this signal, after the one caught `since`, is meant to give up.
    pub fn gives_up(self, since: Option<Instant>) -> bool {
        self == Self::CtrlC && since.is_some_and(|since| !is_together_with(since))
    }
}

fn is_together_with(since: Instant) -> bool {
    since.elapsed() < DELIBERATE
}

/// Catches signals from its creation on, so that none is lost before it is awaited.
pub struct Interrupt {
    _watching: Watching,
    #[cfg(unix)]
    signals: [tokio::signal::unix::Signal; 4],
    #[cfg(test)]
    pressed: tokio::sync::broadcast::Receiver<()>,
}

/// Counts in [`WATCHING`] while it exists.
struct Watching;

impl Watching {
    fn start() -> Self {
        WATCHING.set(WATCHING.get() + 1);
        Self
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        WATCHING.set(WATCHING.get().saturating_sub(1));
    }
}

impl Interrupt {
    /// Whether another one exists on this thread, which then reacts to signals by itself.
    pub fn is_shared(&self) -> bool {
        WATCHING.get() > 1
    }

    /// Starts to catch Ctrl-C, Ctrl-\, SIGTERM and SIGHUP.
    #[cfg(unix)]
    pub fn catch() -> Result<Self, Failure> {
        use tokio::signal::unix::{SignalKind, signal};
        let catch = |kind| signal(kind).map_err(|error| Failure::io(what(), error));
        let signals = [
            catch(SignalKind::interrupt())?,
            catch(SignalKind::terminate())?,
            catch(SignalKind::hangup())?,
            catch(SignalKind::quit())?,
        ];
        Ok(Self {
            _watching: Watching::start(),
            signals,
            #[cfg(test)]
            pressed: tests::listen(),
        })
    }

    /// Starts to catch Ctrl-C.
    #[cfg(not(unix))]
    pub fn catch() -> Result<Self, Failure> {
        Ok(Self { _watching: Watching::start() })
    }

    /// Waits for the next signal.
    #[cfg(unix)]
    pub async fn next(&mut self) -> Caught {
        let [interrupt, terminate, hangup, quit] = &mut self.signals;
        #[cfg(test)]
        let pressed = self.pressed.recv();
        #[cfg(not(test))]
        let pressed = std::future::pending::<()>();
        tokio::select! {
            _ = pressed => Caught::CtrlC,
            _ = interrupt.recv() => Caught::CtrlC,
            _ = terminate.recv() => Caught::End,
            _ = hangup.recv() => Caught::Hangup,
            _ = quit.recv() => Caught::End,
        }
    }

    /// Waits for the next Ctrl-C.
    #[cfg(not(unix))]
    pub async fn next(&mut self) -> Caught {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
        Caught::CtrlC
    }

    /// Discards signals that have already arrived.
    pub async fn forget(&mut self) {
        loop {
            tokio::select! {
                biased;
                _ = self.next() => {}
                () = std::future::ready(()) => return,
            }
        }
    }

    /// Waits for any signal.
    pub async fn wait(&mut self) {
        self.next().await;
    }

    /// Waits for a Ctrl-C that is meant to give up what has to be brought to rest: no signal that
    /// ends the program is, nor any that comes together with the one caught `since`.
    pub async fn give_up(&mut self, since: Option<Instant>) {
        while self.next().await != Caught::CtrlC || since.is_some_and(is_together_with) {}
    }
}

#[cfg(unix)]
fn what() -> &'static str {
    text::CannotCatchSignals.str(current())
}

#[cfg(test)]
pub mod tests {
    use tokio::sync::broadcast;

    thread_local! {
        static KEY: broadcast::Sender<()> = broadcast::Sender::new(4);
    }

    pub fn listen() -> broadcast::Receiver<()> {
        KEY.with(broadcast::Sender::subscribe)
    }

    /// Simulates Ctrl-C for code on this thread.
    pub fn press() {
        KEY.with(|key| key.send(()).ok());
    }
}
