//! Exclusive use of serial ports: a second program on a port takes bytes away, or transmits in
//! between.
//!
//! An exclusive lock (flock) excludes programs that lock as well, even root's; TIOCEXCL excludes
//! those that do not, unless they have CAP_SYS_ADMIN. Ports opened with `shared=1` share the lock,
//! so that one program alone cannot decide to share.
//!
//! The lock ends with its program, however that ends, and with its claim: a fork of the program has the
//! locked file as well, so it is unlocked, not only closed. A fork of a program that was killed gives it up
//! ([`super::lines`]). TIOCEXCL is a mark on the terminal, and ends when no
//! program has it open any more: after a kill it would keep a Stop out for as long as another one has. So
//! it is not set where that is usual (a pseudo-terminal, which its other end keeps), nor by what is urgent.

use std::io;
use std::path::Path;

use tokio::task::spawn_blocking;

pub use crate::port_error::{Holder, PortError};

#[cfg(unix)]
pub use unix::{Claim, holders, may_open, user_of};

#[cfg(target_os = "linux")]
pub(super) use unix::{lock_owners, named, own_number};

#[cfg(not(unix))]
pub use elsewhere::{Claim, holders, may_open, user_of};

/// [`holders`] beside the runtime, which it would hold up.
pub async fn holders_beside(path: &Path) -> Vec<Holder> {
    let path = path.to_owned();
    spawn_blocking(move || holders(&path)).await.unwrap_or_default()
}

/// An error with the program that uses the port, if it is about that. Looks at all processes.
pub(crate) fn with_user(error: io::Error) -> io::Error {
    of_user(&error).unwrap_or(error)
}

/// The same of an error that others have, if it is about that.
pub(crate) fn of_user(error: &io::Error) -> Option<io::Error> {
    let Some(PortError::InUse { path, by: None }) = PortError::of(error) else { return None };
    Some(PortError::InUse { path: path.clone(), by: user_of(path) }.into())
}

#[cfg(unix)]
mod unix {
    use std::fs::{self, File, OpenOptions};
    use std::ops::RangeInclusive;
    use std::os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt};
    use std::time::{Duration, Instant};

    use rustix::fs::{Access, FlockOperation, OFlags, access, flock, major, minor};
    use rustix::io::Errno;
    use rustix::termios::{ioctl_tiocexcl, ioctl_tiocnxcl, isatty};

    use super::super::lines::Listed;
    use super::{Holder, Path, PortError, io};

    /// Open files of a process that are looked at.
    const FILES_MAX: usize = 4096;
    /// Longest look at processes; those after it are not seen.
    const LOOK_MAX: Duration = Duration::from_secs(1);
    /// Major numbers of the ends of pseudo-terminals that programs open (Linux).
    const PSEUDO_TERMINALS: RangeInclusive<u32> = 136..=143;

    /// The right to use a port, until it is dropped.
    #[derive(Debug)]
    pub struct Claim {
        file: File,
        exclusive: bool,
        /// Its process: a fork has the file too, and must not unlock it.
        process: u32,
        _listed: Listed,
    }

    impl Claim {
        /// Locks a port before it is opened for use.
        ///
        /// # Errors
        ///
        /// With a [`PortError`] inside if another program uses the port, which is not looked for,
        /// permission is missing, or it is no serial port or does not exist.
        pub fn lock(path: &Path, shared: bool) -> io::Result<Self> {
            let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits() as i32;
            let opened = OpenOptions::new().read(true).write(true).custom_flags(flags).open(path);
            let file = opened.map_err(|error| explained(path, error))?;
            if !isatty(&file) {
                return Err(PortError::NotSerial { path: path.into() }.into());
            }
            let lock = match shared {
                true => FlockOperation::NonBlockingLockShared,
                false => FlockOperation::NonBlockingLockExclusive,
            };
            match flock(&file, lock) {
                Err(Errno::WOULDBLOCK) => Err(in_use(path)),
                Err(error) => Err(error.into()),
                Ok(()) => Ok(Self::of(file)),
            }
        }

        fn of(file: File) -> Self {
            let listed = Listed::new(&file);
            Self { file, exclusive: false, process: std::process::id(), _listed: listed }
        }

        /// Excludes programs that do not lock, once the port is open, unless it is a pseudo-terminal.
        ///
        /// # Errors
        ///
        /// The error of the system if it is not a terminal.
        pub fn keep_others_out(&mut self) -> io::Result<()> {
            let is_pseudo = PSEUDO_TERMINALS.contains(&major(self.file.metadata()?.rdev()));
            if is_pseudo { Ok(()) } else { self.mark() }
        }

        fn mark(&mut self) -> io::Result<()> {
            ioctl_tiocexcl(&self.file)?;
            self.exclusive = true;
            Ok(())
        }
    }

    impl Drop for Claim {
        fn drop(&mut self) {
            if self.process != std::process::id() {
                return;
            }
            // While another program keeps the port open, the terminal persists, and the mark would
            // remain.
            if self.exclusive {
                let _ = ioctl_tiocnxcl(&self.file);
            }
            // To close the file would not unlock it while a fork has it.
            let _ = flock(&self.file, FlockOperation::Unlock);
        }
    }

    fn explained(path: &Path, error: io::Error) -> io::Error {
        match error.kind() {
            io::ErrorKind::ResourceBusy => in_use(path),
            io::ErrorKind::IsADirectory => PortError::NotSerial { path: path.into() }.into(),
            io::ErrorKind::NotFound => PortError::Missing { path: path.into() }.into(),
            io::ErrorKind::PermissionDenied => {
                PortError::Permission { path: path.into(), group: group(path) }.into()
            }
            _ => error,
        }
    }

    fn in_use(path: &Path) -> io::Error {
        PortError::InUse { path: path.into(), by: None }.into()
    }

    /// The other program that uses a port, as far as this user may see it.
    pub fn user_of(path: &Path) -> Option<Holder> {
        let owner = lock_owners(path).into_iter().next().map(named);
        owner.or_else(|| holders(path).into_iter().next())
    }

    /// The number of this process as /proc has it, which may be that of another namespace.
    pub fn own_number() -> Option<u32> {
        fs::read_link("/proc/self").ok()?.to_str()?.parse().ok()
    }

    /// The other processes that have locked a port.
    pub fn lock_owners(path: &Path) -> Vec<u32> {
        let Ok(port) = fs::metadata(path) else { return Vec::new() };
        let place = format!("{:02x}:{:02x}:{}", major(port.dev()), minor(port.dev()), port.ino());
        let locks = fs::read_to_string("/proc/locks").unwrap_or_default();
        let owner = |line: &str| {
            let fields: Vec<&str> = line.split_whitespace().collect();
            let is_it = fields.get(1) == Some(&"FLOCK") && fields.get(5) == Some(&place.as_str());
            is_it.then(|| fields.get(4)?.parse().ok()).flatten()
        };
        let own = own_number();
        // Without a number of its own this process cannot be distinguished from others.
        locks.lines().filter_map(owner).filter(|pid| own.is_some_and(|own| own != *pid)).collect()
    }

    /// A process with its name.
    pub fn named(pid: u32) -> Holder {
        let program = fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
        Holder { pid, program: program.trim().to_owned() }
    }

    /// The name of the group that has permission for a port.
    fn group(path: &Path) -> Option<String> {
        let metadata = fs::metadata(path).ok()?;
        if metadata.mode() & 0o060 != 0o060 {
            return None;
        }
        let groups = fs::read_to_string("/etc/group").ok()?;
        let named = groups.lines().find_map(|line| {
            let mut fields = line.split(':');
            let (name, id) = (fields.next()?, fields.nth(1)?);
            (id.parse() == Ok(metadata.gid())).then(|| name.to_owned())
        });
        named.filter(|name| name != "root")
    }

    /// Whether this user may open a port.
    pub fn may_open(path: &Path) -> bool {
        access(path, Access::READ_OK | Access::WRITE_OK).is_ok()
    }

    /// The programs that have a port open, as far as this user may see them and within a second; not this
    /// one.
    pub fn holders(path: &Path) -> Vec<Holder> {
        let (Ok(port), Some(own)) = (fs::metadata(path), own_number()) else { return Vec::new() };
        let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
        let numbered = processes.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        let until = Instant::now() + LOOK_MAX;
        let others = numbered.filter(|pid| *pid != own).take_while(|_| Instant::now() < until);
        let is_port = |file: &Path| {
            let open = fs::metadata(file);
            open.is_ok_and(|open| open.file_type().is_char_device() && open.rdev() == port.rdev())
        };
        let real = fs::canonicalize(path).unwrap_or_default();
        let number = real.strip_prefix("/dev/pts").ok().and_then(Path::to_str);
        // Who has the other end of a pseudo-terminal is the line itself.
        let is_other_end = |pid: u32, file: &fs::DirEntry| {
            let about = format!("/proc/{pid}/fdinfo/{}", file.file_name().display());
            let about = number.and_then(|number| Some((number, fs::read_to_string(about).ok()?)));
            about.is_some_and(|(number, about)| {
                let indexes = about.lines().filter_map(|line| line.strip_prefix("tty-index:"));
                indexes.map(str::trim).any(|index| index == number)
            })
        };
        let has_it = |pid: &u32| {
            let files = fs::read_dir(format!("/proc/{pid}/fd")).into_iter().flatten().flatten();
            let (mut has, mut is_line) = (false, false);
            for file in files.take(FILES_MAX) {
                // A file of a disk that is away is not touched.
                let name = fs::read_link(file.path()).unwrap_or_default();
                if !name.starts_with("/dev") {
                    continue;
                }
                is_line |= name.ends_with("ptmx") && is_other_end(*pid, &file);
                has |= is_port(&file.path());
            }
            has && !is_line
        };
        let mut found: Vec<u32> = others.filter(has_it).collect();
        found.sort_unstable();
        found.into_iter().map(named).collect()
    }

    #[cfg(test)]
    mod tests {
        use std::os::unix::fs::{PermissionsExt, chown};

        use lafet_texts::Lang;

        use super::*;

        /// Whether a program that locks nothing can open a port, without root's right to open any.
        #[cfg(target_os = "linux")]
        fn opens(path: &Path) -> bool {
            use std::process::Command;
            let mut command = Command::new("sh");
            if rustix::process::geteuid().is_root() {
                command = Command::new("setpriv");
                command.args(["--bounding-set=-all", "--inh-caps=-all", "sh"]);
            }
            command.args(["-c", "exec 2>&- 3<>\"$0\""]).arg(path).status().unwrap().success()
        }

        /// A line with its other end.
        #[cfg(target_os = "linux")]
        fn line() -> (std::os::fd::OwnedFd, std::path::PathBuf) {
            use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
            let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
            let line = openpt(flags).unwrap();
            grantpt(&line).unwrap();
            unlockpt(&line).unwrap();
            let path = ptsname(&line, Vec::new()).unwrap().into_string().unwrap();
            (line, path.into())
        }

        /// A fork has the locked file, as a second handle of it has: it neither keeps the lock nor ends it.
        #[cfg(target_os = "linux")]
        #[test]
        fn a_lock_ends_with_its_claim_and_not_in_a_fork() {
            let (_line, path) = line();
            let claim = Claim::lock(&path, false).unwrap();
            let of_fork = claim.file.try_clone().unwrap();
            drop(claim);
            let mut claim = Claim::lock(&path, false).expect("free while a fork has the file");
            drop(of_fork);
            assert!(Claim::lock(&path, false).is_err());
            let kept = claim.file.try_clone().unwrap();
            claim.process += 1;
            drop(claim);
            assert!(Claim::lock(&path, false).is_err(), "the lock of the parent");
            drop(kept);
        }

        /// Where the mark is set, it ends with the claim; on a pseudo-terminal it is not.
        #[cfg(target_os = "linux")]
        #[test]
        fn a_program_that_does_not_lock_is_kept_out() {
            let (_line, path) = line();
            let path = path.as_path();
            let mut claim = Claim::lock(path, false).unwrap();
            assert!(opens(path));
            claim.keep_others_out().unwrap();
            assert!(opens(path), "a Stop would not either, if this program was killed");
            claim.mark().unwrap();
            assert!(!opens(path));
            drop(claim);
            assert!(opens(path));
        }

        /// What the system says about a port becomes what is wrong with it.
        #[test]
        fn an_error_of_the_system_is_explained() {
            let path = std::env::temp_dir().join(format!("lafet-port-{}", std::process::id()));
            fs::write(&path, "").unwrap();
            let of = |kind: io::ErrorKind| {
                let error = explained(&path, kind.into());
                PortError::of(&error).cloned()
            };
            let groups = fs::read_to_string("/etc/group").unwrap();
            let own = fs::metadata(&path).unwrap().gid();
            let (name, id) = groups
                .lines()
                .filter_map(|line| {
                    let mut fields = line.split(':');
                    Some((fields.next()?, fields.nth(1)?.parse::<u32>().ok()?))
                })
                .find(|(name, id)| if own == 0 { *name == "dialout" } else { *id == own })
                .unwrap();
            chown(&path, None, Some(id)).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o660)).unwrap();
            let denied = of(io::ErrorKind::PermissionDenied).unwrap();
            for lang in [Lang::En, Lang::Ru] {
                assert!(denied.localized(lang).contains(&format!("usermod -aG {name}")));
            }
            fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
            let denied = of(io::ErrorKind::PermissionDenied);
            assert_eq!(denied, Some(PortError::Permission { path: path.clone(), group: None }));
            let busy = of(io::ErrorKind::ResourceBusy);
            assert_eq!(busy, Some(PortError::InUse { path: path.clone(), by: None }));
            let missing = of(io::ErrorKind::NotFound);
            assert_eq!(missing, Some(PortError::Missing { path: path.clone() }));
            let folder = of(io::ErrorKind::IsADirectory);
            assert_eq!(folder, Some(PortError::NotSerial { path: path.clone() }));
            assert_eq!(of(io::ErrorKind::OutOfMemory), None);
            fs::remove_file(path).unwrap();
        }
    }
}

#[cfg(not(unix))]
mod elsewhere {
    use super::{Holder, Path, io};

    /// A placeholder: these systems open a port for one program only.
    #[derive(Debug)]
    pub struct Claim;

    impl Claim {
        /// Does nothing.
        ///
        /// # Errors
        ///
        /// None.
        pub fn lock(_: &Path, _: bool) -> io::Result<Self> {
            Ok(Self)
        }

        /// Does nothing.
        ///
        /// # Errors
        ///
        /// None.
        pub fn keep_others_out(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// None: these systems do not show it.
    pub fn holders(_: &Path) -> Vec<Holder> {
        Vec::new()
    }

    /// None: this system does not say.
    pub fn user_of(_: &Path) -> Option<Holder> {
        None
    }

    /// Always true: opening the port shows it.
    pub fn may_open(_: &Path) -> bool {
        true
    }
}
