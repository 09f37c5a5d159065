//! The open lines of this process, for a program that forks.
//!
//! A fork has all open files of its parent. One of a line would keep the line from others for as long as the
//! fork runs, even when its parent has been killed: a port stays locked, a serial server that takes one
//! connection stays occupied, and a Stop of another program is kept out. So the fork gives them up, by what
//! [`Fork`] returns. A program that a fork turns into (`exec`) has none of them: they are closed then.

pub use system::{Fork, Identity};

pub(crate) use system::Listed;

#[cfg(unix)]
mod system {
    use std::os::fd::AsFd;
    use std::sync::{Mutex, MutexGuard};

    use rustix::fs::fstat;

    use crate::shared::lock;

    /// What distinguishes an open file from others: device and number of its node, as `fstat` has them. A port
    /// that was opened twice has one; so has a socket.
    pub type Identity = (u64, u64);

    static OPEN: Mutex<Vec<Identity>> = Mutex::new(Vec::new());

    #[allow(clippy::unnecessary_cast, reason = "systems have numbers of different sizes")]
    fn identity(line: &impl AsFd) -> Option<Identity> {
        let about = fstat(line).ok()?;
        Some((about.st_dev as u64, about.st_ino as u64))
    }

    /// An entry in the list of open lines.
    #[derive(Debug)]
    pub struct Listed(Option<Identity>);

    impl Listed {
        /// Adds a line that has just been opened.
        pub fn new(line: &impl AsFd) -> Self {
            let identity = identity(line);
            lock(&OPEN).extend(identity);
            Self(identity)
        }
    }

    impl Drop for Listed {
        fn drop(&mut self) {
            let mut open = lock(&OPEN);
            if let Some(at) = open.iter().position(|it| Some(*it) == self.0) {
                open.swap_remove(at);
            }
        }
    }

    /// Keeps the list as it is while the process forks. The thread that forks makes it before and gives it up
    /// after, in both processes: in the fork, too, the list is locked until then.
    #[derive(Debug)]
    pub struct Fork(MutexGuard<'static, Vec<Identity>>);

    impl Fork {
        /// Before the fork.
        pub fn begin() -> Self {
            Self(lock(&OPEN))
        }

        /// In the fork: what distinguishes the lines of its parent among the open files. Replace them by
        /// `/dev/null`; their numbers remain in use.
        pub fn inherited(mut self) -> Vec<Identity> {
            std::mem::take(&mut *self.0)
        }
    }

    #[cfg(test)]
    mod tests {
        use std::net::UdpSocket;

        use super::*;

        /// Two handles of a socket are one line; it is listed for as long as one entry exists.
        #[test]
        fn a_line_is_listed_while_it_is_open() {
            let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
            let own = identity(&socket).unwrap();
            let listed = || Fork::begin().0.iter().filter(|it| **it == own).count();
            assert_eq!(listed(), 0);
            let first = Listed::new(&socket);
            let second = Listed::new(&socket.try_clone().unwrap());
            assert_eq!(listed(), 2);
            drop(first);
            assert_eq!(listed(), 1);
            drop(second);
            assert_eq!(listed(), 0);
        }
    }
}

/// These systems do not fork.
#[cfg(not(unix))]
mod system {
    /// Never used.
    pub type Identity = (u64, u64);

    /// A placeholder.
    #[derive(Debug)]
    pub struct Listed;

    impl Listed {
        /// Does nothing.
        pub const fn new<L>(_: &L) -> Self {
            Self
        }
    }

    /// A placeholder.
    #[derive(Debug)]
    pub struct Fork;

    impl Fork {
        /// Does nothing.
        pub const fn begin() -> Self {
            Self
        }

        /// None.
        pub const fn inherited(self) -> Vec<Identity> {
            Vec::new()
        }
    }
}
