//! Ctrl-C and the signals that end a program.

use lafet_texts::cli as text;

use crate::failure::Failure;
#[cfg(unix)]
use crate::lang::current;

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

/// Catches signals from its creation on, so that none is lost before it is awaited.
pub struct Interrupt {
    #[cfg(unix)]
    signals: [tokio::signal::unix::Signal; 4],
    #[cfg(test)]
    pressed: tokio::sync::broadcast::Receiver<()>,
}

impl Interrupt {
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
            signals,
            #[cfg(test)]
            pressed: tests::listen(),
        })
    }

    /// Starts to catch Ctrl-C.
    #[cfg(not(unix))]
    pub fn catch() -> Result<Self, Failure> {
        Ok(Self {})
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
