//! How a program that only listens gives its port to one that must send at once.
//!
//! A line is listened to for seconds before its first frame, and probed for longer; a Stop does not
//! wait that long. So who listens waits at a *door*, a socket named after the port and its process. One that
//! only looks (scan, doctor) starts again afterwards; one that was to send something ends:
//!
//! ```text
//! listens at its door ──▶ a knock ──▶ closes the port ──▶ waits for the visitor's end ──▶ starts again
//! Stop: port in use ────▶ knocks ──▶ opens the port, again and again, for PATIENCE ──▶ closes both
//! ```
//!
//! The visitor finds the door by the process that has locked the port, and asks no socket of another process,
//! whatever its name. Each name ends with a random number, so that no other program can take it before. The
//! visitor asks again when another process has taken the port meanwhile. A program without a door, and one
//! that is slow, is waited for as long; none of ours listens without one.
//!
//! A door opens to those who may open the port, by its owner, group and mode: they could keep the line
//! from this program anyway, and a Stop must not wait because another operator's program listens. Others
//! are not heard. Each visit lasts as long as the visitor has the port, [`VISIT_MAX`] at most, and there
//! are [`VISITS_MAX`] of them.

use std::future::ready;
use std::io;
use std::time::Duration;

use tokio::time::sleep;

use crate::port_error::Holder;
use crate::url::Endpoint;

/// How long an urgent command tries to open a port that is in use.
pub const PATIENCE: Duration = Duration::from_secs(10);
/// How often work gives way before it is given up: it would never end where commands come again and again.
pub const VISITS_MAX: u32 = 8;
/// Longest visit. Afterwards the port is opened again if it is free.
pub const VISIT_MAX: Duration = Duration::from_secs(60);
/// Longest time for which giving way waits for an answer that may be on its way.
pub const ANSWER_MAX: Duration = Duration::from_secs(1);
/// Shortest such time: a bus allows a device this long.
const ANSWER_LEAST: Duration = Duration::from_millis(lafet_proto::bus::REPLY_TIMEOUT_MS as u64);
/// How often a visitor knocks: who has the port may change.
pub(super) const KNOCKS: Duration = Duration::from_millis(50);

pub(crate) use system::Visits;
use system::{Door, Visitor};

#[cfg(target_os = "linux")]
use linux as system;

#[cfg(not(target_os = "linux"))]
use elsewhere as system;

/// The door of an endpoint's port; `None` if it is no port, or this process waits at a door of it already.
fn door_of(endpoint: &Endpoint) -> io::Result<Option<Door>> {
    match endpoint {
        Endpoint::Serial { path, .. } => Door::open(path),
        _ => Ok(None),
    }
}

/// Does `work` on a link. When an urgent command wants its port meanwhile, the work is dropped, which
/// has to close the port, `gave` is called, and the work is done again after that command has ended.
/// `None` after [`VISITS_MAX`] such commands.
///
/// What the work has sent last may still be answered: for `answer`, the longest time that it waits itself, though
/// never for more than [`ANSWER_MAX`], it keeps the port without doing anything, so that the answer does not
/// come to the other command.
///
/// # Errors
///
/// With [`PortError::NoDoor`](crate::PortError::NoDoor) inside if the system gives no door: then the work is
/// not done, for a Stop would wait for it.
pub async fn giving_way<F: Future>(
    endpoint: &Endpoint,
    answer: Duration,
    mut gave: impl FnMut(&Holder),
    mut work: impl FnMut() -> F,
) -> io::Result<Option<F::Output>> {
    let Some(door) = door_of(endpoint)? else { return Ok(Some(work().await)) };
    for _ in 0..VISITS_MAX {
        let visitor = match until_knock(&door, answer, work()).await {
            Ok(done) => return Ok(Some(done)),
            Err(visitor) => visitor,
        };
        gave(visitor.who());
        door.ended(visitor).await;
    }
    Ok(None)
}

/// After a knock the work is not polled any more, so that it sends nothing, and dropped after `answer`.
async fn until_knock<F: Future>(
    door: &Door,
    answer: Duration,
    work: F,
) -> Result<F::Output, Visitor> {
    // It has the port for as long as it is not dropped.
    tokio::pin!(work);
    tokio::select! {
        // In any order: many knocks do not keep the work from going on.
        done = &mut work => Ok(done),
        visitor = door.knocked() => {
            sleep(answer.clamp(ANSWER_LEAST, ANSWER_MAX)).await;
            Err(visitor)
        }
    }
}

/// Does `work` on a link, which must not send, unless an urgent command wants its port meanwhile: then `work` is
/// dropped, which has to close the port, and that command is returned. What moves or opens something must not
/// start behind a Stop.
///
/// # Errors
///
/// As [`giving_way`].
pub async fn unless_wanted<F: Future>(
    endpoint: &Endpoint,
    work: F,
) -> io::Result<Result<F::Output, Holder>> {
    let Some(door) = door_of(endpoint)? else { return Ok(Ok(work.await)) };
    let done = tokio::select! {
        done = work => done,
        visitor = door.knocked() => return Ok(Err(visitor.who().clone())),
    };
    // Of a knock at the same moment it is known now.
    Ok(tokio::select! {
        biased;
        visitor = door.knocked() => Err(visitor.who().clone()),
        () = ready(()) => Ok(done),
    })
}

#[cfg(target_os = "linux")]
mod linux;

/// These systems have no name of a socket that goes away with its program: ports have no doors.
#[cfg(not(target_os = "linux"))]
mod elsewhere {
    use std::convert::Infallible;
    use std::io;
    use std::path::Path;

    use crate::port_error::Holder;

    /// There is none.
    pub enum Door {}

    /// There is none.
    pub struct Visitor(Infallible);

    impl Visitor {
        /// Never called.
        pub const fn who(&self) -> &Holder {
            match self.0 {}
        }
    }

    impl Door {
        /// `None`.
        pub const fn open(_: &Path) -> io::Result<Option<Self>> {
            Ok(None)
        }

        /// Never called.
        pub async fn knocked(&self) -> Visitor {
            match *self {}
        }

        /// Never called.
        pub async fn ended(&self, _: Visitor) {
            match *self {}
        }
    }

    /// No port has a door.
    #[derive(Debug, Default)]
    pub struct Visits;

    impl Visits {
        /// Does nothing.
        pub const fn knock(&mut self, _: &Path) {}
    }
}
