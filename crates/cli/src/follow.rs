//! Following what a request has started until it ends; Ctrl-C and a line that is cut end it too.

use std::future::Future;
use std::time::Duration;

use lafet_client::Answers;
use lafet_proto::{Request, SubsystemId};
use tokio::time::{Instant, sleep};

use crate::connect::Connection;
use crate::exchange;
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::out::Out;
use crate::undo::{Because, States, Undo};

/// Pause between two looks at the state.
const POLL: Duration = Duration::from_millis(100);
/// What has been accepted shows in the state within this time.
const START: Duration = Duration::from_secs(1);

/// What a look at the state shows.
pub enum Step {
    /// It goes on.
    Running(String),
    /// Nothing goes on: it has not started yet, or was over before the first look.
    Idle(String),
    /// It is done.
    Done,
    /// It ended without being done, and why.
    Ended(String),
}

/// What is watched, and what is brought to rest when the command is broken off.
pub struct Follow<'a> {
    /// The monitor.
    pub connection: &'a Connection,
    /// Whose state shows how far it is.
    pub watch: &'a [SubsystemId],
    /// What stops it.
    pub undo: Undo,
}

/// How a command is broken off before its end is known.
enum Broken {
    /// The motion goes on, or may; it has to be undone.
    Off(Because),
    /// Nothing goes on that this command has started.
    Over(Failure),
}

impl Follow<'_> {
    /// Runs `start`, then looks at the state until `judge` says that it is over.
    pub async fn run<T>(
        &self,
        out: &mut Out,
        start: impl Future<Output = Result<T, Failure>>,
        judge: impl FnMut(&States) -> Step,
    ) -> Result<States, Failure> {
        let mut interrupt = Interrupt::catch()?;
        let broken = tokio::select! {
            ended = self.watch(out, start, judge) => match ended {
                Ok(states) => return Ok(states),
                Err(broken) => broken,
            },
            () = interrupt.wait() => Broken::Off(Because::Interrupted),
        };
        Err(self.end(out, &mut interrupt, broken).await)
    }

    /// Runs `start` alone: what it starts goes on by itself.
    pub async fn begin<T>(
        &self,
        out: &mut Out,
        start: impl Future<Output = Result<T, Failure>>,
    ) -> Result<T, Failure> {
        let mut interrupt = Interrupt::catch()?;
        let broken = tokio::select! {
            started = start => match started {
                Ok(started) => return Ok(started),
                Err(failure) => self.unanswered(failure),
            },
            () = interrupt.wait() => Broken::Off(Because::Interrupted),
        };
        Err(self.end(out, &mut interrupt, broken).await)
    }

    async fn end(&self, out: &mut Out, interrupt: &mut Interrupt, broken: Broken) -> Failure {
        match broken {
            Broken::Over(failure) => failure,
            Broken::Off(because) => {
                self.undo.carry_out(self.connection, out, interrupt, because).await
            }
        }
    }

    async fn watch<T>(
        &self,
        out: &mut Out,
        start: impl Future<Output = Result<T, Failure>>,
        mut judge: impl FnMut(&States) -> Step,
    ) -> Result<States, Broken> {
        start.await.map_err(|failure| self.unanswered(failure))?;
        let mut running = false;
        let mut shown = String::new();
        let began = Instant::now();
        loop {
            let states = States::read(self.connection, self.watch).await;
            let states = states.map_err(|error| Broken::Off(Because::Lost(error)))?;
            let progress = match judge(&states) {
                Step::Done => return Ok(states),
                Step::Ended(why) => return Err(Broken::Over(Failure::Ended(why))),
                Step::Idle(why) if running || began.elapsed() > START => {
                    return Err(Broken::Over(Failure::Ended(why)));
                }
                Step::Idle(_) => None,
                Step::Running(progress) => {
                    running = true;
                    Some(progress)
                }
            };
            if let Some(progress) = progress.filter(|progress| *progress != shown) {
                out.seldom(&progress);
                shown = progress;
            }
            sleep(POLL).await;
        }
    }

    /// Of a request without a believable answer it is not known whether it was executed.
    fn unanswered(&self, failure: Failure) -> Broken {
        match failure {
            Failure::Client(error) if self.undo.is_needed_after(&error) => {
                Broken::Off(Because::Lost(error))
            }
            failure => Broken::Over(failure),
        }
    }
}

/// Sends a request that goes on by itself, and shows the answers.
pub async fn begin(request: Request<'_>, connection: &Connection, out: &mut Out) -> Outcome {
    let undo = Undo::of(&request).unwrap_or_default();
    let follow = Follow { connection, watch: &[], undo };
    let answers: Answers = follow.begin(out, connection.send(&request)).await?;
    out.show(exchange::text(request.to, &answers), || exchange::json(&request, &answers))
}
