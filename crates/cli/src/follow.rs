//! Following what a request has started until it ends; Ctrl-C stops it.

use std::future::Future;
use std::time::Duration;

use lafet_client::AnswerBuf;
use lafet_proto::flags::{ControlFlags, DeployerFlags, DetectorFlags, DriveFlags, ValveFlags};
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use tokio::time::{Instant, sleep};

use crate::connect::Connection;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::lang::pick;
use crate::out::Out;

/// Pause between two looks at the state.
const POLL: Duration = Duration::from_millis(100);
/// What has been accepted shows in the state within this time.
const START: Duration = Duration::from_secs(1);
/// What has been stopped stands within this time.
const STOP: Duration = Duration::from_secs(10);

/// What a look at the state tells.
pub enum Step {
    /// It goes on.
    Running(String),
    /// Nothing goes on: it has not begun yet, or was over before the first look.
    Idle(String),
    /// It is done.
    Done,
    /// It ended without being done, and why.
    Ended(String),
}

/// States of the subsystems that are watched.
pub struct States(Vec<AnswerBuf>);

impl States {
    /// The flags of a subsystem; none when it does not exist.
    pub fn flags(&self, subsystem: SubsystemId) -> u32 {
        self.of(subsystem).and_then(|answer| answer.decode().ok()?.data.flags_bits()).unwrap_or(0)
    }

    /// The answer of a subsystem that exists.
    pub fn of(&self, subsystem: SubsystemId) -> Option<&AnswerBuf> {
        self.0.iter().find(|answer| answer.from() == subsystem && answer.status().is_success())
    }
}

/// What is watched, and what Ctrl-C stops.
pub struct Follow<'a> {
    /// The monitor.
    pub connection: &'a Connection,
    /// Whose state tells how far it is.
    pub watch: &'a [SubsystemId],
    /// Who is stopped.
    pub stop: SubsystemId,
}

impl Follow<'_> {
    /// Runs `start`, then looks at the state until `judge` says that it is over.
    pub async fn run<T>(
        &self,
        out: &mut Out,
        start: impl Future<Output = Result<T, Failure>>,
        mut judge: impl FnMut(&States) -> Step,
    ) -> Result<States, Failure> {
        let mut interrupt = Interrupt::catch()?;
        tokio::select! {
            started = start => started?,
            () = interrupt.wait() => return self.halt(out, &mut interrupt).await,
        };
        let mut running = false;
        let mut shown = String::new();
        let began = Instant::now();
        loop {
            let states = tokio::select! {
                states = self.look() => states?,
                () = interrupt.wait() => return self.halt(out, &mut interrupt).await,
            };
            let progress = match judge(&states) {
                Step::Done => return Ok(states),
                Step::Ended(why) => return Err(Failure::Ended(why)),
                Step::Idle(why) if running || began.elapsed() > START => {
                    return Err(Failure::Ended(why));
                }
                Step::Idle(_) => None,
                Step::Running(progress) => {
                    running = true;
                    Some(progress)
                }
            };
            if let Some(progress) = progress.filter(|progress| *progress != shown) {
                out.progress(&progress);
                shown = progress;
            }
            tokio::select! {
                () = sleep(POLL) => {}
                () = interrupt.wait() => return self.halt(out, &mut interrupt).await,
            }
        }
    }

    async fn look(&self) -> Result<States, Failure> {
        let request = |subsystem: &SubsystemId| Request::new(*subsystem, Body::GetStatus);
        let requests: Vec<Request<'_>> = self.watch.iter().map(request).collect();
        let mut states = Vec::new();
        for answers in self.connection.client.batch(&requests).await {
            states.extend(answers?);
        }
        Ok(States(states))
    }

    /// Stops, and waits until all stands; a second Ctrl-C does not wait.
    async fn halt<T>(&self, out: &mut Out, interrupt: &mut Interrupt) -> Result<T, Failure> {
        let stop = Request::new(self.stop, Body::Stop);
        out.progress(pick(format!("Interrupted: {stop}"), format!("Прервано: {stop}")));
        let stopped = tokio::select! {
            stopped = self.stop_and_wait(&stop) => stopped,
            () = interrupt.wait() => Err(Failure::Interrupted),
        };
        stopped.and(Err(Failure::Interrupted))
    }

    async fn stop_and_wait(&self, stop: &Request<'_>) -> Result<(), Failure> {
        let answers = self.connection.client.request(stop).await?;
        if answers.refusal().is_some() && self.stop != SubsystemId::ALL {
            // Somebody else has taken over (§3.2/2–4): then everything stops, which is never denied.
            self.connection.ask(SubsystemId::ALL, Body::Stop).await?;
        }
        let began = Instant::now();
        while began.elapsed() < STOP {
            let states = self.look().await?;
            let active = self.watch.iter().any(|who| states.flags(*who) & active_bits(*who) != 0);
            if !active {
                break;
            }
            sleep(POLL).await;
        }
        Ok(())
    }
}

/// Whether any of these subsystems is doing something which Stop ends.
pub fn is_anything_active(states: &[AnswerBuf]) -> bool {
    states.iter().any(|state| {
        let bits = state.decode().ok().and_then(|answer| answer.data.flags_bits());
        bits.unwrap_or(0) & active_bits(state.from()) != 0
    })
}

/// The flags that say that a subsystem is doing something which Stop ends.
fn active_bits(subsystem: SubsystemId) -> u32 {
    match subsystem {
        SubsystemId::VERTICAL | SubsystemId::HORIZONTAL | SubsystemId::NOZZLE => {
            DriveFlags::MOVE.bits()
        }
        SubsystemId::VALVE1 | SubsystemId::VALVE2 => {
            (ValveFlags::OPENING | ValveFlags::CLOSING).bits()
        }
        SubsystemId::CONTROL => (ControlFlags::QUENCH | ControlFlags::TRAJECTORY).bits(),
        SubsystemId::DETECTOR => (DetectorFlags::SEARCHING | DetectorFlags::JUSTIFYING).bits(),
        SubsystemId::DEPLOYER => {
            (DeployerFlags::MOVE | DeployerFlags::DEPLOYING | DeployerFlags::WRAPPING).bits()
        }
        _ => 0,
    }
}
