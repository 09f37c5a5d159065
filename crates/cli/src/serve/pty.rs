//! A pseudo-terminal in raw mode: a serial line that ends in the simulator.

use std::io;
use std::os::fd::OwnedFd;

use rustix::fs::{Mode, OFlags};
use rustix::pty::OpenptFlags;
use rustix::termios::OptionalActions;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::unix::pipe::{Receiver, Sender};

/// The simulator's end. The client's end is kept open as well, so that clients may come and go.
pub struct Pty {
    ours: tokio::io::Join<Receiver, Sender>,
    theirs: OwnedFd,
}

impl Pty {
    /// Opens a pair; returns the path of the client's end.
    pub fn open() -> io::Result<(Self, String)> {
        let ours = rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        rustix::pty::grantpt(&ours)?;
        rustix::pty::unlockpt(&ours)?;
        rustix::io::fcntl_setfd(&ours, rustix::io::FdFlags::CLOEXEC)?;
        let name = rustix::pty::ptsname(&ours, Vec::new())?;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let theirs = rustix::fs::open(name.as_c_str(), flags, Mode::empty())?;
        let mut settings = rustix::termios::tcgetattr(&theirs)?;
        settings.make_raw();
        rustix::termios::tcsetattr(&theirs, OptionalActions::Now, &settings)?;
        let status = rustix::fs::fcntl_getfl(&ours)?;
        rustix::fs::fcntl_setfl(&ours, status | OFlags::NONBLOCK)?;
        let path = name.to_string_lossy().into_owned();
        // Tokio's pipes work with any descriptor that can be polled.
        let writer = Sender::from_owned_fd_unchecked(ours.try_clone()?)?;
        let reader = Receiver::from_owned_fd_unchecked(ours)?;
        Ok((Self { ours: tokio::io::join(reader, writer), theirs }, path))
    }

    /// The byte stream, and a descriptor that keeps the line open.
    pub fn split(self) -> (impl AsyncRead + AsyncWrite + Unpin, OwnedFd) {
        (self.ours, self.theirs)
    }
}
