//! What stops is not given up at the first error of the way to the monitor.

use std::io;
use std::time::Duration;

use lafet_client::Error;
use lafet_client::transport::port::PortError;
use lafet_texts::{Text as _, cli as text};
use tokio::time::{Instant, sleep};

use crate::failure::Failure;
use crate::lang::current;
use crate::out::complain_aside;
use crate::undo::{REACH, is_of_the_line};

/// Pause between two attempts.
const PAUSE: Duration = Duration::from_millis(250);

/// Does this again, for [`REACH`] at most, as long as the way to the monitor is what fails; `words` says what is to
/// reach it. The first failure is shown at once.
pub async fn insist<T>(
    words: &str,
    mut work: impl AsyncFnMut() -> Result<T, Failure>,
) -> Result<T, Failure> {
    let until = Instant::now() + REACH;
    let mut said = false;
    loop {
        let error = match work().await {
            Err(Failure::Client(error)) if may_pass(&error) && Instant::now() < until => error,
            done => return done,
        };
        if !std::mem::replace(&mut said, true) {
            let (words, seconds) = (words.to_owned(), REACH.as_secs());
            complain_aside(move || {
                let error = error.localized(current());
                text::StopTries { error, seconds, words }.of(current())
            });
        }
        sleep(PAUSE).await;
    }
}

/// A gateway starts again, a cable is plugged in; but what another program keeps was waited for, and rights and files
/// do not change by themselves.
fn may_pass(error: &Error) -> bool {
    let Error::Link { source, .. } = error else { return is_of_the_line(error) };
    match source.get_ref().and_then(|it| it.downcast_ref::<PortError>()) {
        Some(port) => matches!(port, PortError::Missing { .. }),
        None => !matches!(
            source.kind(),
            io::ErrorKind::PermissionDenied
                | io::ErrorKind::InvalidInput
                | io::ErrorKind::Unsupported
        ),
    }
}
