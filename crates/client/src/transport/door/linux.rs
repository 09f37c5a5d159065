//! Doors as sockets without a file.

use std::collections::BTreeSet;
use std::fs::{self, File, Metadata};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, BufRead, BufReader};
use std::os::fd::OwnedFd;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

use rustix::io::Errno;
use rustix::net::{
    AddressFamily, RecvFlags, SocketAddrUnix, SocketFlags, SocketType, connect, recv, socket_with,
    sockopt::socket_peercred,
};
use rustix::process::geteuid;
use tokio::io::AsyncReadExt;
use tokio::net::{UnixListener, UnixStream};
use tokio::time::{sleep, timeout};

use super::VISIT_MAX;
use crate::port_error::{Holder, PortError};
use crate::shared::lock;
use crate::transport::port::{Claim, lock_owners, named, own_number};

/// How soon a visitor has to have opened the port, and how often it is looked whether it still has it.
const USES: Duration = Duration::from_secs(1);
/// Pause after a knock that could not be accepted.
const AGAIN: Duration = Duration::from_millis(100);
/// The kernel's list of sockets, and the most of them that are looked at.
const SOCKETS: &str = "/proc/net/unix";
const SOCKETS_MAX: usize = 1 << 20;

/// The ports at which this process waits at a door: which of two it had to wait at would be chance.
static DOORS: Mutex<BTreeSet<(u64, u64)>> = Mutex::new(BTreeSet::new());

/// A socket at which urgent commands knock.
pub struct Door {
    socket: UnixListener,
    path: PathBuf,
    _place: Place,
}

/// An entry of [`DOORS`].
struct Place((u64, u64));

impl Place {
    fn take(port: &Metadata) -> Option<Self> {
        let port = (port.rdev(), port.ino());
        lock(&DOORS).insert(port).then(|| Self(port))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        lock(&DOORS).remove(&self.0);
    }
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
        let rights = Rights::of(&fs::metadata(path).ok()?);
        let others = || groups(pid, by.uid());
        rights.permit(by.uid(), by.gid(), others).then(|| Self { stream, who: named(pid) })
    }

    /// The process.
    pub const fn who(&self) -> &Holder {
        &self.who
    }
}

impl Door {
    /// `None` if this process has a door at the port already, or there is no port, which opening it shows.
    pub fn open(path: &Path) -> io::Result<Option<Self>> {
        let Ok(port) = fs::metadata(path) else { return Ok(None) };
        let Some(place) = Place::take(&port) else { return Ok(None) };
        let own = own_number().unwrap_or_else(std::process::id);
        // The keys of the standard library's hash maps are random numbers of the operating system.
        let random = RandomState::new().hash_one(());
        let socket = UnixListener::bind(format!("\0{}{random:016x}", name(&port, own)));
        let missing = |error: io::Error| {
            let code = error.raw_os_error().unwrap_or(0);
            PortError::NoDoor { path: path.into(), code }
        };
        Ok(Some(Self { socket: socket.map_err(missing)?, path: path.to_owned(), _place: place }))
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

/// Who may open a port. A right that an access control list gives is not seen.
#[derive(Clone, Copy)]
struct Rights {
    own: u32,
    user: u32,
    group: u32,
    mode: u32,
}

impl Rights {
    fn of(port: &Metadata) -> Self {
        let own = geteuid().as_raw();
        Self { own, user: port.uid(), group: port.gid(), mode: port.mode() }
    }

    fn permit(self, user: u32, group: u32, others: impl FnOnce() -> Vec<u32>) -> bool {
        let gives = |shift: u32| (self.mode >> shift) & 0o6 == 0o6;
        user == self.own
            || user == 0
            || (user == self.user && gives(6))
            || (gives(3) && (group == self.group || others().contains(&self.group)))
            || gives(0)
    }
}

/// The groups of a process besides its own. The number may be another process's by now: of another user's
/// nothing is said.
fn groups(pid: u32, user: u32) -> Vec<u32> {
    groups_in(&fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default(), user)
}

/// The same of the kernel's text about it.
fn groups_in(status: &str, user: u32) -> Vec<u32> {
    let numbers = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name));
        let words = line.unwrap_or_default().split_whitespace();
        words.filter_map(|id| id.parse().ok()).collect::<Vec<u32>>()
    };
    // Real, effective, saved, of the file system.
    match numbers("Uid:").get(1) {
        Some(effective) if *effective == user => numbers("Groups:"),
        _ => Vec::new(),
    }
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

/// Knocks at the door of a process.
fn visit(path: &Path, pid: u32) -> Option<OwnedFd> {
    let port = fs::metadata(path).ok()?;
    doors(&name(&port, pid)).find_map(|door| knock_at(&door).filter(|door| is_of(door, &port, pid)))
}

/// The names of sockets that begin so.
fn doors(start: &str) -> impl Iterator<Item = String> {
    let lines = File::open(SOCKETS).ok().map(|list| BufReader::new(list).split(b'\n'));
    let lines = lines.into_iter().flatten().take(SOCKETS_MAX).map_while(Result::ok);
    lines.filter_map(move |line| {
        let line = String::from_utf8(line).ok()?;
        let (_, name) = line.rsplit_once(" @")?;
        name.starts_with(start).then(|| name.to_owned())
    })
}

/// It does not wait: a socket that accepts nothing is no door.
fn knock_at(name: &str) -> Option<OwnedFd> {
    let address = SocketAddrUnix::new_abstract_name(name.as_bytes()).ok()?;
    let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
    let socket = socket_with(AddressFamily::UNIX, SocketType::STREAM, flags, None).ok()?;
    connect(&socket, &address).ok()?;
    Some(socket)
}

/// Whether a socket is that of this process, and not of one that gave it the same name.
fn is_of(socket: &OwnedFd, port: &Metadata, pid: u32) -> bool {
    let Ok(peer) = socket_peercred(socket) else { return false };
    if own_number() == Some(std::process::id()) {
        return u32::try_from(peer.pid.as_raw_nonzero().get()) == Ok(pid);
    }
    // /proc numbers processes otherwise.
    Rights::of(port).permit(peer.uid.as_raw(), peer.gid.as_raw(), Vec::new)
}

/// Whether the other side has not closed it.
fn is_open(visit: &OwnedFd) -> bool {
    let received = recv(visit, &mut [0_u8; 1], RecvFlags::DONTWAIT);
    received.is_err_and(|error| error == Errno::WOULDBLOCK)
}

/// What the name of a process's door at a port begins with: of the device, whatever path leads to it. The
/// socket is in no folder and ends with its process.
fn name(port: &Metadata, pid: u32) -> String {
    format!("lafet-port-{:x}-{:x}-{pid}-", port.rdev(), port.ino())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A user, a group, and other groups; whether they may open ports of these modes.
    #[test]
    fn who_may_open_a_port_may_ask_for_it() {
        let port = |mode: u32| Rights { own: 1000, user: 7, group: 20, mode: 0o20_000 | mode };
        let asks =
            |mode, user, group, others: &[u32]| port(mode).permit(user, group, || others.to_vec());
        for mode in [0, 0o600, 0o660, 0o666] {
            assert!(asks(mode, 1000, 1000, &[]) && asks(mode, 0, 0, &[]), "{mode:o}");
        }
        assert!(asks(0o600, 7, 7, &[]) && !asks(0o060, 7, 7, &[]));
        assert!(!asks(0o400, 7, 7, &[]) && !asks(0o200, 7, 7, &[]));
        for (mode, permits) in [(0o600, false), (0o640, false), (0o660, true)] {
            assert_eq!(asks(mode, 1001, 20, &[]), permits, "{mode:o}");
            assert_eq!(asks(mode, 1001, 1001, &[4, 20]), permits, "{mode:o}");
            assert!(!asks(mode, 1001, 1001, &[4, 21]), "{mode:o}");
        }
        assert!(asks(0o666, 1001, 1001, &[]) && !asks(0o664, 1001, 1001, &[]));
    }

    /// A process that has got the number of the one that knocked lends it no groups.
    #[test]
    fn groups_are_those_of_the_same_user() {
        let status = |effective| {
            format!("Name:\tlafet\nUid:\t0\t{effective}\t0\t0\nGid:\t1\nGroups:\t4 20 \n")
        };
        assert_eq!(groups_in(&status(1001), 1001), [4, 20]);
        assert!(groups_in(&status(1000), 1001).is_empty());
        assert!(groups_in("", 1001).is_empty());
    }

    /// A second door at a port would be chosen by chance.
    #[tokio::test]
    async fn a_process_has_one_door_at_a_port() {
        let port = std::env::temp_dir().join(format!("lafet-door-{}", std::process::id()));
        fs::write(&port, "").unwrap();
        let own = name(&fs::metadata(&port).unwrap(), own_number().unwrap());
        let first = Door::open(&port).unwrap().expect("a door");
        assert!(Door::open(&port).unwrap().is_none());
        assert_eq!(doors(&own).count(), 1);
        drop(first);
        assert_eq!(doors(&own).count(), 0);
        assert!(Door::open(&port).unwrap().is_some());
        fs::remove_file(port).unwrap();
    }
}
