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
//! The visitor finds the door by the process that has locked the port, so that a socket of that name in
//! another process is never asked. It asks again when another process has taken the port meanwhile. A
//! program without a door, and one that is slow, is waited for as long.
//!
//! A door opens to those who may open the port, by its owner, group and mode: they could keep the line
//! from this program anyway, and a Stop must not wait because another operator's program listens. Others
//! are not heard. Each visit lasts as long as the visitor has the port, [`VISIT_MAX`] at most, and there
//! are [`VISITS_MAX`] of them.

use std::future::ready;
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

/// The door of an endpoint's port, if it is a port and can have one.
fn door_of(endpoint: &Endpoint) -> Option<Door> {
    match endpoint {
        Endpoint::Serial { path, .. } => Door::open(path),
        _ => None,
    }
}

/// Does `work` on a link. When an urgent command wants its port meanwhile, the work is dropped, which
/// has to close the port, `gave` is called, and the work is done again after that command has ended.
/// `None` after [`VISITS_MAX`] such commands.
///
/// What the work has sent last may still be answered: for `answer`, the longest time that it waits itself, though
/// never for more than [`ANSWER_MAX`], it keeps the port without doing anything, so that the answer does not
/// come to the other command.
pub async fn giving_way<F: Future>(
    endpoint: &Endpoint,
    answer: Duration,
    mut gave: impl FnMut(&Holder),
    mut work: impl FnMut() -> F,
) -> Option<F::Output> {
    let Some(door) = door_of(endpoint) else { return Some(work().await) };
    for _ in 0..VISITS_MAX {
        let visitor = match until_knock(&door, answer, work()).await {
            Ok(done) => return Some(done),
            Err(visitor) => visitor,
        };
        gave(visitor.who());
        door.ended(visitor).await;
    }
    None
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
/// dropped, which has to close the port, and the error is that command. What moves or opens something must not
/// start behind a Stop.
///
/// # Errors
///
/// The program that wants the port.
pub async fn unless_wanted<F: Future>(endpoint: &Endpoint, work: F) -> Result<F::Output, Holder> {
    let Some(door) = door_of(endpoint) else { return Ok(work.await) };
    let done = tokio::select! {
        done = work => done,
        visitor = door.knocked() => return Err(visitor.who().clone()),
    };
    // Of a knock at the same moment it is known now.
    tokio::select! {
        biased;
        visitor = door.knocked() => Err(visitor.who().clone()),
        () = ready(()) => Ok(done),
    }
}

#[cfg(target_os = "linux")]
mod linux {
    use std::fs::{self, Metadata};
    use std::io;
    use std::os::fd::OwnedFd;
    use std::os::unix::fs::MetadataExt;
    use std::path::{Path, PathBuf};
    use std::time::Duration;

    use rustix::io::Errno;
    use rustix::net::{
        AddressFamily, RecvFlags, SocketAddrUnix, SocketFlags, SocketType, connect, recv,
        socket_with,
    };
    use rustix::process::geteuid;
    use tokio::io::AsyncReadExt;
    use tokio::net::unix::UCred;
    use tokio::net::{UnixListener, UnixStream};
    use tokio::time::{sleep, timeout};

    use super::VISIT_MAX;
    use crate::port_error::Holder;
    use crate::transport::port::{Claim, lock_owners, named, own_number};

    /// How soon a visitor has to have opened the port, and how often it is looked whether it still has it.
    const USES: Duration = Duration::from_secs(1);
    /// Pause after a knock that could not be accepted.
    const AGAIN: Duration = Duration::from_millis(100);

    /// A socket at which urgent commands knock.
    pub struct Door {
        socket: UnixListener,
        path: PathBuf,
    }

    /// An urgent command that waits for the port.
    pub struct Visitor {
        stream: UnixStream,
        who: Holder,
    }

    impl Visitor {
        /// `None` for who may not open the port.
        fn of(stream: UnixStream, path: &Path) -> Option<Self> {
            let by = stream.peer_cred().ok()?;
            let pid = by.pid().and_then(|pid| u32::try_from(pid).ok()).unwrap_or(0);
            let port = fs::metadata(path).ok()?;
            may_open(&port, &by, pid).then(|| Self { stream, who: named(pid) })
        }

        /// The process.
        pub const fn who(&self) -> &Holder {
            &self.who
        }
    }

    impl Door {
        /// `None` if this process has a door at the port already, its name is taken, or the system gives none.
        pub fn open(path: &Path) -> Option<Self> {
            let name = format!("\0{}", name(path, own_number()?)?);
            let socket = UnixListener::bind(name).ok()?;
            Some(Self { socket, path: path.to_owned() })
        }

        /// The next visitor.
        pub async fn knocked(&self) -> Visitor {
            loop {
                match self.socket.accept().await {
                    Ok((stream, _)) => {
                        if let Some(visitor) = Visitor::of(stream, &self.path) {
                            return visitor;
                        }
                    }
                    // Without a door the work is not disturbed.
                    Err(_) => sleep(AGAIN).await,
                }
            }
        }

        /// Waits until a visitor has ended, or does not use the port any more, and while a further urgent
        /// command has it.
        pub async fn ended(&self, mut visitor: Visitor) {
            let unused = async {
                loop {
                    sleep(USES).await;
                    if !is_in_use(&self.path) {
                        return;
                    }
                }
            };
            let visit = async {
                let mut nothing = [0];
                tokio::select! {
                    _ = visitor.stream.read(&mut nothing) => {}
                    () = unused => {}
                }
                while is_in_use(&self.path) {
                    sleep(LOOKS).await;
                }
            };
            // Longer than that, it is as any other program that has the port.
            let _ = timeout(VISIT_MAX, visit).await;
        }
    }

    /// How often it is looked whether the port is free again.
    const LOOKS: Duration = Duration::from_millis(200);

    fn is_in_use(path: &Path) -> bool {
        Claim::lock(path, false).is_err_and(|error| error.kind() == io::ErrorKind::ResourceBusy)
    }

    /// Whether a process may open a port. A right that an access control list gives is not seen.
    fn may_open(port: &Metadata, by: &UCred, pid: u32) -> bool {
        let (user, own) = (by.uid(), geteuid().as_raw());
        let gives = |shift: u32| (port.mode() >> shift) & 0o6 == 0o6;
        user == own
            || user == 0
            || (user == port.uid() && gives(6))
            || (gives(3) && (by.gid() == port.gid() || groups(pid).contains(&port.gid())))
            || gives(0)
    }

    /// The groups of a process besides its own.
    fn groups(pid: u32) -> Vec<u32> {
        let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
        let groups = status.lines().find_map(|line| line.strip_prefix("Groups:"));
        groups.unwrap_or_default().split_whitespace().filter_map(|id| id.parse().ok()).collect()
    }

    /// Knocks at the doors of the processes that have a port; kept until the port has been closed again.
    #[derive(Debug, Default)]
    pub struct Visits(Vec<(u32, OwnedFd)>);

    impl Visits {
        /// Knocks at the door of each process that has the port and has not let this one in.
        pub fn knock(&mut self, path: &Path) {
            self.0.retain(|(_, visit)| is_open(visit));
            for pid in lock_owners(path) {
                if self.0.iter().all(|(at, _)| *at != pid) {
                    // It may have no door.
                    self.0.extend(visit(path, pid).map(|visit| (pid, visit)));
                }
            }
        }
    }

    /// It does not wait: a socket that accepts nothing is no door.
    fn visit(path: &Path, pid: u32) -> Option<OwnedFd> {
        let address = SocketAddrUnix::new_abstract_name(name(path, pid)?.as_bytes()).ok()?;
        let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
        let socket = socket_with(AddressFamily::UNIX, SocketType::STREAM, flags, None).ok()?;
        connect(&socket, &address).ok()?;
        Some(socket)
    }

    /// Whether the other side has not closed it.
    fn is_open(visit: &OwnedFd) -> bool {
        let received = recv(visit, &mut [0_u8; 1], RecvFlags::DONTWAIT);
        received.is_err_and(|error| error == Errno::WOULDBLOCK)
    }

    /// The name of a process's door at a port: of the device, whatever path leads to it. It is in no folder and
    /// ends with its process.
    fn name(path: &Path, pid: u32) -> Option<String> {
        let port = fs::metadata(path).ok()?;
        Some(format!("lafet-port-{:x}-{:x}-{pid}", port.rdev(), port.ino()))
    }
}

/// These systems have no name of a socket that goes away with its program: ports have no doors.
#[cfg(not(target_os = "linux"))]
mod elsewhere {
    use std::convert::Infallible;
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
        pub const fn open(_: &Path) -> Option<Self> {
            None
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
