//! How a program that only listens gives its port to one that must send at once.
//!
//! A line is listened to for seconds before its first frame, and probed for longer; a Stop does not
//! wait that long. So who listens waits at a *door*, a socket named after the port. One that only looks (scan,
//! doctor) begins again afterwards; one that was to send something ends:
//!
//! ```text
//! listens at its door ──▶ a knock ──▶ closes the port ──▶ waits for the visitor's end ──▶ begins again
//! Stop: port in use ────▶ knocks ──▶ opens the port, again and again, for PATIENCE ──▶ closes both
//! ```

use std::time::Duration;

use crate::url::Endpoint;

/// How long an urgent command tries to open a port that is in use.
pub const PATIENCE: Duration = Duration::from_secs(10);

pub(crate) use system::Visit;
use system::{Door, ended};

#[cfg(target_os = "linux")]
use linux as system;

#[cfg(not(target_os = "linux"))]
use elsewhere as system;

/// The door of an endpoint's port, if it is a port and can have one.
fn door_of(endpoint: &Endpoint) -> Option<Door> {
    match endpoint {
        Endpoint::Serial { path, .. } => Door::open(path),
        _ => None,
    }
}

/// Does `work` on a link. When an urgent command wants its port meanwhile, the work is dropped, which
/// has to close the port, and done again after that command has ended.
pub async fn giving_way<F: Future>(endpoint: &Endpoint, mut work: impl FnMut() -> F) -> F::Output {
    let Some(door) = door_of(endpoint) else { return work().await };
    loop {
        tokio::select! {
            biased;
            visitor = door.knocked() => ended(visitor).await,
            done = work() => return done,
        }
    }
}

/// Does `work` on a link, unless an urgent command wants its port meanwhile: then `work` is dropped, which has to
/// close the port. A command that moves or opens something must not begin again behind a Stop.
pub async fn unless_wanted<F: Future>(endpoint: &Endpoint, work: F) -> Option<F::Output> {
    let Some(door) = door_of(endpoint) else { return Some(work.await) };
    tokio::select! {
        biased;
        _ = door.knocked() => None,
        done = work => Some(done),
    }
}

#[cfg(target_os = "linux")]
mod linux {
    use std::fs;
    use std::future::pending;
    use std::os::unix::fs::MetadataExt;
    use std::path::{Path, PathBuf};
    use std::time::Duration;

    use tokio::io::AsyncReadExt;
    use tokio::net::{UnixListener, UnixStream};
    use tokio::time::timeout;

    /// Longest wait for a visitor to end: the port is opened again then, if it is free.
    const VISIT: Duration = Duration::from_secs(60);

    /// A socket at which urgent commands knock.
    pub struct Door(UnixListener);

    impl Door {
        /// `None` if this port has a door already, or the system gives none.
        pub fn open(path: &Path) -> Option<Self> {
            UnixListener::bind(name(path)?).ok().map(Self)
        }

        /// The next visitor.
        pub async fn knocked(&self) -> UnixStream {
            match self.0.accept().await {
                Ok((visitor, _)) => visitor,
                // Without a door the work is not disturbed.
                Err(_) => pending().await,
            }
        }
    }

    /// Waits until a visitor has ended.
    pub async fn ended(mut visitor: UnixStream) {
        // It sends nothing.
        let _ = timeout(VISIT, visitor.read(&mut [0])).await;
    }

    /// A knock at the door of a port; kept until the port has been closed again.
    #[derive(Debug)]
    pub struct Visit(#[expect(dead_code, reason = "closed when dropped")] UnixStream);

    impl Visit {
        /// `None` if this port has no door.
        pub async fn to(path: &Path) -> Option<Self> {
            UnixStream::connect(name(path)?).await.ok().map(Self)
        }
    }

    /// The name of a port's door: of the device, whatever path leads to it. It is in no folder and
    /// ends with its program.
    fn name(path: &Path) -> Option<PathBuf> {
        let port = fs::metadata(path).ok()?;
        Some(format!("\0lafet-port-{:x}-{:x}", port.rdev(), port.ino()).into())
    }
}

/// These systems have no name of a socket that goes away with its program: ports have no doors.
#[cfg(not(target_os = "linux"))]
mod elsewhere {
    use std::convert::Infallible;
    use std::path::Path;

    /// There is none.
    #[derive(Debug)]
    pub enum Door {}

    impl Door {
        /// `None`.
        pub fn open(_: &Path) -> Option<Self> {
            None
        }

        /// Never called.
        pub async fn knocked(&self) -> Infallible {
            match *self {}
        }
    }

    /// Never called.
    pub async fn ended(visitor: Infallible) {
        match visitor {}
    }

    /// There is none.
    #[derive(Debug)]
    pub enum Visit {}

    impl Visit {
        /// `None`.
        pub async fn to(_: &Path) -> Option<Self> {
            None
        }
    }
}
