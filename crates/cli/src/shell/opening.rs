//! What is typed until a shell has its connection: `stop` does not wait until the line was listened to.

use std::collections::VecDeque;
use std::str::FromStr;

use lafet_client::Endpoint;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::{Text as _, cli as text};
use tokio::sync::mpsc::UnboundedReceiver;

use super::ahead::Ahead;
use super::words::{is_stop, only_ends};
use crate::cli::Global;
use crate::connect::{Connection, url_of};
use crate::exchange;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::complain;

/// Where the lines of a shell come from.
pub enum Lines {
    /// The terminal, of which every line is read.
    Typed(Ahead),
    /// A script, and whether a line of it waits for its turn: a `stop` behind it is not its first.
    Script(UnboundedReceiver<String>, bool),
}

impl Lines {
    /// The next line that may be a `stop`; pending for ever when there will be none.
    async fn next(&mut self) -> String {
        match self {
            Self::Typed(ahead) => return ahead.next().await,
            Self::Script(lines, false) => {
                if let Some(line) = lines.recv().await {
                    return line;
                }
            }
            Self::Script(..) => {}
        }
        std::future::pending().await
    }

    /// A line waits for its turn.
    const fn keep(&mut self) {
        if let Self::Script(_, kept) = self {
            *kept = true;
        }
    }
}

/// A connection, and what happened until it was there.
pub struct Opening {
    /// The connection.
    pub connection: Connection,
    /// Lines that wait for their turn.
    pub ahead: VecDeque<String>,
    /// A signal was caught: everything is to be stopped, and the shell ends.
    pub interrupted: bool,
}

/// Connects. On a serial line a `stop` and a signal end the listening; after a `stop` it is listened to
/// again.
pub async fn open(
    global: &Global,
    interrupt: &mut Interrupt,
    lines: &mut Lines,
) -> Result<Opening, Failure> {
    let mut ahead = VecDeque::new();
    // A wrong URL is reported by the attempt to connect.
    let listens = matches!(Endpoint::from_str(url_of(global)?), Ok(Endpoint::Serial { .. }));
    loop {
        let mut opening = Box::pin(Connection::new(global));
        let interrupted = loop {
            tokio::select! {
                biased;
                _ = interrupt.next(), if listens => break true,
                line = lines.next(), if listens => {
                    if is_stop(&line) {
                        drop_lines(&mut ahead);
                        break false;
                    }
                    lines.keep();
                    ahead.push_back(line);
                }
                connection = &mut opening => {
                    return Ok(Opening { connection: connection?, ahead, interrupted: false });
                }
            }
        };
        // The port is opened again only after it is closed.
        drop(opening);
        let connection = Connection::open_urgently(global).await?;
        if interrupted {
            return Ok(Opening { connection, ahead, interrupted });
        }
        stop_all(&connection, matches!(lines, Lines::Typed(_))).await;
    }
}

/// Lines that wait for their turn are revoked by what stops: they would move again, or open. What only closes, locks out
/// or leaves stays.
pub fn drop_lines(ahead: &mut VecDeque<String>) {
    ahead.retain(|line| {
        let stays = only_ends(line);
        if !stays {
            complain(text::LineDropped { line }.of(current()));
        }
        stays
    });
}

/// Sends Stop All once, and shows the outcome. `clear`: a command may have printed its progress on this
/// line of the terminal.
pub async fn stop_all(connection: &Connection, clear: bool) {
    let stop = Request::new(SubsystemId::ALL, Body::Stop);
    let text = match connection.client.request(&stop).await {
        Ok(answers) => exchange::stop_all(&answers),
        Err(error) => error.localized(current()),
    };
    let clear = if clear { "\r\x1b[K" } else { "" };
    complain(format_args!("{clear}{text}"));
}
