//! Lines typed while a command runs: `stop` acts at once, the rest waits for its turn.

#[cfg(unix)]
use std::time::Duration;

/// Interval at which the terminal is checked. It edits and keeps lines itself meanwhile.
#[cfg(unix)]
const LOOK: Duration = Duration::from_millis(30);

/// Lines typed at the terminal.
pub struct Ahead {
    wanted: bool,
}

impl Ahead {
    /// Listens if `wanted` is set.
    pub const fn listen(wanted: bool) -> Self {
        Self { wanted }
    }

    /// The next line; pending for ever when there will be none.
    #[cfg(unix)]
    pub async fn next(&mut self) -> String {
        while self.wanted {
            match unix::line() {
                unix::Typed::Line(line) => return line,
                unix::Typed::Nothing => tokio::time::sleep(LOOK).await,
                unix::Typed::Gone => self.wanted = false,
            }
        }
        std::future::pending().await
    }

    /// Pending for ever: this system does not show lines typed while a command runs.
    #[cfg(not(unix))]
    pub async fn next(&mut self) -> String {
        std::future::pending().await
    }
}

#[cfg(unix)]
mod unix {
    use std::io::stdin;

    use rustix::event::{PollFd, PollFlags, Timespec, poll};

    /// A terminal's line is not longer than this.
    const LINE_MAX: usize = 4096;

    pub enum Typed {
        Line(String),
        Nothing,
        Gone,
    }

    /// The line that the terminal holds, if any: then reading does not block.
    pub fn line() -> Typed {
        let terminal = stdin();
        let mut ready = [PollFd::new(&terminal, PollFlags::IN)];
        match poll(&mut ready, Some(&Timespec::default())) {
            Ok(0) => return Typed::Nothing,
            Ok(_) => {}
            Err(_) => return Typed::Gone,
        }
        let mut buffer = [0; LINE_MAX];
        match rustix::io::read(&terminal, &mut buffer) {
            Ok(0) | Err(_) => Typed::Gone,
            Ok(length) => {
                Typed::Line(String::from_utf8_lossy(&buffer[..length]).trim_end().to_owned())
            }
        }
    }
}
