//! Follows what a request has started until it ends; Ctrl-C and a cut line end it too.

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

/// Pause between two polls of the state.
const POLL: Duration = Duration::from_millis(100);
/// A request that was accepted shows in the state within this time.
const START: Duration = Duration::from_secs(1);

/// Result of one poll of the state.
pub enum Step {
    /// In progress; the text shows how far.
    Running(String),
    /// Idle: it has not started yet, or was over before the first poll.
    Idle(String),
    /// Completed.
    Done,
    /// Ended without being completed; the text says why.
    Ended(String),
}

/// What to watch, and how to bring it to rest if the command is broken off.
pub struct Follow<'a> {
    /// The monitor.
    pub connection: &'a Connection,
    /// Subsystems whose state shows the progress.
    pub watch: &'a [SubsystemId],
    /// How to stop it.
    pub undo: Undo,
}

/// How a command was broken off before its end was known.
enum Broken {
    /// The motion continues, or may; it has to be undone.
    Off(Because),
    /// Nothing that this command started continues.
    Over(Failure),
}

impl Follow<'_> {
    /// Runs `start`, then polls the state until `judge` returns an end.
    pub async fn run<T>(
        &self,
        out: &mut Out,
        start: impl Future<Output = Result<T, Failure>>,
        judge: impl FnMut(&States) -> Step,
    ) -> Result<States, Failure> {
        self.run_until(&mut Interrupt::catch()?, out, start, judge).await
    }

    /// Like [`Self::run`], for one motion of several: a signal that came before it, since
    /// `interrupt` exists, keeps it from starting.
    pub async fn run_until<T>(
        &self,
        interrupt: &mut Interrupt,
        out: &mut Out,
        start: impl Future<Output = Result<T, Failure>>,
        judge: impl FnMut(&States) -> Step,
    ) -> Result<States, Failure> {
        // A terminal that is held must not hold up what stops.
        let mut aside = out.aside().ok();
        let out = aside.as_mut().unwrap_or(out);
        let broken = tokio::select! {
            biased;
            () = interrupt.wait() => Broken::Off(Because::Interrupted),
            ended = self.watch(out, start, judge) => match ended {
                Ok(states) => return Ok(states),
                Err(broken) => broken,
            },
        };
        Err(self.end(out, interrupt, broken).await)
    }

    /// Runs `start` alone: what it starts continues without the command.
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
                Step::Ended(why) => return Err(self.over(why, running)),
                Step::Idle(why) if running || began.elapsed() > START => {
                    return Err(self.over(why, running));
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

    /// What ended is over. What was not seen to begin may begin later, so it is undone.
    fn over(&self, why: String, began: bool) -> Broken {
        match began || self.undo.is_wanted() {
            true => Broken::Over(Failure::Ended(why)),
            false => Broken::Off(Because::Failed(why)),
        }
    }

    /// Without a believable answer it is not known whether the request was executed.
    fn unanswered(&self, failure: Failure) -> Broken {
        match failure {
            Failure::Client(error) if self.undo.is_needed_after(&error) => {
                Broken::Off(Because::Lost(error))
            }
            failure => Broken::Over(failure),
        }
    }
}

/// Sends a request whose effect continues without the command, and shows the answers.
pub async fn begin(request: Request<'_>, connection: &Connection, out: &mut Out) -> Outcome {
    let undo = Undo::of(&request).unwrap_or_default();
    let follow = Follow { connection, watch: &[], undo };
    let answers: Answers = follow.begin(out, connection.send(&request)).await?;
    out.show(exchange::text(request.to, &answers), || exchange::json(&request, &answers))
}
