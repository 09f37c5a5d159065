//! Ctrl-C and the signals that end a program.

use crate::failure::Failure;
#[cfg(unix)]
use crate::lang::pick;

/// Catches the signals from the moment it is made, so that none is lost before it is awaited.
pub struct Interrupt {
    #[cfg(unix)]
    signals: [tokio::signal::unix::Signal; 3],
}

impl Interrupt {
    /// Starts to catch Ctrl-C, SIGTERM and SIGHUP.
    #[cfg(unix)]
    pub fn catch() -> Result<Self, Failure> {
        use tokio::signal::unix::{SignalKind, signal};
        let catch = |kind| signal(kind).map_err(|error| Failure::io(what(), error));
        let signals = [
            catch(SignalKind::interrupt())?,
            catch(SignalKind::terminate())?,
            catch(SignalKind::hangup())?,
        ];
        Ok(Self { signals })
    }

    /// Starts to catch Ctrl-C.
    #[cfg(not(unix))]
    pub fn catch() -> Result<Self, Failure> {
        Ok(Self {})
    }

    /// Waits for the next one.
    #[cfg(unix)]
    pub async fn wait(&mut self) {
        let [interrupt, terminate, hangup] = &mut self.signals;
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
            _ = hangup.recv() => {}
        }
    }

    /// Waits for the next one.
    #[cfg(not(unix))]
    pub async fn wait(&mut self) {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    }
}

#[cfg(unix)]
fn what() -> &'static str {
    pick("cannot catch signals", "не удаётся перехватить сигналы")
}
