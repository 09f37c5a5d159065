//! Breaking off a command that moves or opens: brings what it started to rest.
//!
//! One mechanism for all such commands, for Ctrl-C and for a cut line:
//!
//! ```text
//!  request out ──▶ following ──▶ done
//!       │  Ctrl-C, line cut │
//!       ▼                   ▼
//!   Stop (or Close) ◀──▶ look        until it is seen at rest,
//!       │ no answer          │       or REACH has passed, or Ctrl-C once more, a second later
//!       ▼                    ▼
//!   try again            at rest | still moving | not known
//! ```
//!
//! Motion is stopped. A valve is closed: Stop would leave it half open, with water running (§3.2).

use std::time::Duration;

use lafet_client::{AnswerBuf, Error};
use lafet_proto::flags::{
    ControlFlags, DeployerFlags, DetectorFlags, DriveFlags, SetFlag, ValveFlags, flags_of,
};
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::{Shown, Text as _, cli as text};
use tokio::time::{Instant, sleep, timeout_at};

use crate::connect::{Connection, words_of};
use crate::describe::values;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::Out;

/// For how long the monitor is tried when the line is cut.
pub const REACH: Duration = Duration::from_secs(30);
/// A motion that was stopped is at rest within this time.
const SETTLE: Duration = Duration::from_secs(10);
/// A valve is closed within this time: the longest TravelTime plus the request.
const SETTLE_VALVE: Duration = Duration::from_secs(65);
/// Pause between two polls, and between two attempts.
const PAUSE: Duration = Duration::from_millis(100);

/// States of the watched subsystems.
pub struct States(Vec<AnswerBuf>);

impl States {
    /// Reads them. A subsystem that does not exist is left out; an answer that is not a state is a
    /// client error.
    pub async fn read(connection: &Connection, whose: &[SubsystemId]) -> Result<Self, Error> {
        let request = |who: &SubsystemId| Request::new(*who, Body::GetStatus);
        let requests: Vec<Request<'_>> = whose.iter().map(request).collect();
        let mut states = Vec::new();
        for answers in connection.client.batch(&requests).await {
            let answers = answers?;
            let answers = match answers.refusal() {
                Some(refusal) if refusal.status() == lafet_proto::Status::MODULE_NOT_EXIST => {
                    continue;
                }
                _ => answers.accepted()?,
            };
            states.extend(answers);
        }
        Ok(Self(states))
    }

    /// Status flags of a subsystem; 0 if it does not exist.
    pub fn flags(&self, subsystem: SubsystemId) -> u32 {
        self.of(subsystem).and_then(|answer| answer.decode().ok()?.data.flags_bits()).unwrap_or(0)
    }

    /// All answers.
    pub fn all(&self) -> impl Iterator<Item = &AnswerBuf> {
        self.0.iter()
    }

    /// The answer of a subsystem, if it exists.
    pub fn of(&self, subsystem: SubsystemId) -> Option<&AnswerBuf> {
        self.0.iter().find(|answer| answer.from() == subsystem && answer.status().is_success())
    }
}

/// How to bring to rest what requests have started.
#[derive(Clone, Debug, Default)]
pub struct Undo {
    requests: Vec<Request<'static>>,
    /// Drives and programs that may be moving.
    moving: Vec<SubsystemId>,
    /// Valves that may be open.
    flowing: Vec<SubsystemId>,
    /// Drives whose limits may be off.
    limitless: Vec<SubsystemId>,
    /// The command itself only stops or closes, so being at rest is its success.
    wanted: bool,
}

/// How an undo ended.
#[derive(Clone, Debug)]
pub enum End {
    /// It was seen at rest.
    AtRest {
        /// The state as text.
        state: String,
        /// Valves that are not closed, which Stop All leaves as they are (§3.2).
        open: Vec<SubsystemId>,
    },
    /// The monitor answers, and is not at rest.
    StillActive(String),
    /// The state is not known; the error says why.
    Unknown(Error),
    /// Ctrl-C ended the attempts.
    GivenUp,
}

/// Why a command was broken off.
#[derive(Clone, Debug)]
pub enum Because {
    /// Ctrl-C or a signal.
    Interrupted,
    /// The monitor does not answer, or its answer is not valid.
    Lost(Error),
    /// It went wrong otherwise, or was accepted and not seen to begin, which it may do later where a
    /// remote unit is slow; the text says why.
    Failed(String),
}

impl Undo {
    /// What undoes a request; `None` if it starts nothing.
    pub fn of(request: &Request<'_>) -> Option<Self> {
        let stop = |who| vec![Request::new(who, Body::Stop)];
        let to = request.to;
        let barrel = [SubsystemId::DEPLOYER, SubsystemId::HORIZONTAL, SubsystemId::VERTICAL];
        let program = |who: SubsystemId| Self {
            requests: stop(who),
            moving: [who].into_iter().chain(barrel).collect(),
            ..Self::default()
        };
        match request.body {
            Body::Move { .. } if to.is_drive() => {
                Some(Self { requests: stop(to), moving: vec![to], ..Self::default() })
            }
            Body::Move { .. } => Some(Self::everything()),
            Body::Stop if to == SubsystemId::ALL => {
                Some(Self { wanted: true, ..Self::everything() })
            }
            Body::Stop => {
                let moving = match to {
                    SubsystemId::CONTROL | SubsystemId::DETECTOR => program(to).moving,
                    SubsystemId::MOTORS => Self::drives(),
                    _ => vec![to],
                };
                Some(Self { requests: stop(to), moving, wanted: true, ..Self::default() })
            }
            Body::Deploy | Body::Wrap => {
                let moving = vec![SubsystemId::DEPLOYER];
                Some(Self { requests: stop(SubsystemId::DEPLOYER), moving, ..Self::default() })
            }
            Body::Open { .. } | Body::Close { .. } if to.is_valve() => Some(Self {
                requests: vec![Request::close(to)],
                flowing: vec![to],
                wanted: matches!(request.body, Body::Close { .. }),
                ..Self::default()
            }),
            Body::StartQuench(_) | Body::StartTrajectory(_) => Some(program(SubsystemId::CONTROL)),
            Body::StartSeek(_) | Body::StartJustify => Some(program(SubsystemId::DETECTOR)),
            _ => None,
        }
    }

    /// Undo by Stop All.
    pub fn everything() -> Self {
        let moving = SubsystemId::TABLE.into_iter().filter(|who| active_bits(*who) != 0);
        Self {
            requests: vec![Request::new(SubsystemId::ALL, Body::Stop)],
            moving: moving.collect(),
            ..Self::default()
        }
    }

    fn drives() -> Vec<SubsystemId> {
        SubsystemId::TABLE.into_iter().filter(|who| who.is_drive()).collect()
    }

    /// Undo by Stop All and switching the limits of a drive back on (§3.17).
    pub fn teaching(drive: SubsystemId) -> Self {
        let Self { mut requests, moving, .. } = Self::everything();
        requests.push(Request::new(drive, Body::SwitchLimits { new_state: 2 }));
        Self { requests, moving, limitless: vec![drive], ..Self::default() }
    }

    /// Combines two undos.
    pub fn and(mut self, other: Self) -> Self {
        self.requests.extend(other.requests);
        self.moving.extend(other.moving);
        self.flowing.extend(other.flowing);
        self.limitless.extend(other.limitless);
        self.wanted &= other.wanted;
        self
    }

    /// Brings it to rest, and returns a failure that describes the outcome.
    pub async fn carry_out(
        &self,
        connection: &Connection,
        out: &mut Out,
        interrupt: &mut Interrupt,
        because: Because,
    ) -> Failure {
        // A reader that pauses must not hold up what stops.
        let mut aside = out.aside().ok();
        let out = aside.as_mut().unwrap_or(out);
        let mut since = None;
        match &because {
            Because::Interrupted => {
                since = Some(Instant::now());
                out.progress(text::InterruptedWhile { words: self.words() }.of(current()));
            }
            Because::Lost(error) => out.warn(&self.trying(error)),
            Because::Failed(_) => {}
        }
        let told = matches!(because, Because::Lost(_));
        let end = tokio::select! {
            end = self.bring_to_rest(connection, out, told) => end,
            () = interrupt.give_up(since) => End::GivenUp,
        };
        out.end_progress();
        Failure::BrokenOff(Box::new(BrokenOff { because, end, undo: self.clone() }))
    }

    /// Retries until it is at rest, for [`REACH`] at most.
    async fn bring_to_rest(&self, connection: &Connection, out: &mut Out, told: bool) -> End {
        let until = Instant::now() + REACH;
        let mut told = told;
        let mut last = None;
        loop {
            // An attempt in which the monitor answers may finish, however late it came back.
            let attempt = timeout_at(until + self.settle(), self.attempt(connection));
            let error = match attempt.await {
                Ok(Ok(end)) => return end,
                Ok(Err(error)) => error,
                Err(_) => return End::Unknown(last.unwrap_or_else(|| silent(connection))),
            };
            let gone = connection.client.link_state().borrow().gone;
            if !is_of_the_line(&error) || gone || Instant::now() >= until {
                return End::Unknown(error);
            }
            if !std::mem::replace(&mut told, true) {
                out.warn(&self.trying(&error));
            }
            last = Some(error);
            sleep(PAUSE).await;
        }
    }

    /// Sends the requests of the undo, all of them whatever becomes of one; returns the first
    /// error after which it is worth trying again.
    ///
    /// What stops valves goes first, because it would stop a Close halfway; then what closes them,
    /// then the rest.
    async fn send(&self, connection: &Connection) -> Result<(), Error> {
        let order = |request: &&Request<'_>| match request.body {
            Body::Stop if request.to == SubsystemId::ALL || request.to.is_valve() => 0,
            Body::Close { .. } => 1,
            _ => 2,
        };
        let mut requests: Vec<&Request<'_>> = self.requests.iter().collect();
        requests.sort_by_key(order);
        let mut first = Ok(());
        let mut send = async |request: &Request<'_>| match connection.client.request(request).await
        {
            Ok(answers) => answers.refusal().is_some(),
            Err(error) => {
                // After an answer that is not valid, the state shows what has become of it.
                if first.is_ok() && is_of_the_line(&error) {
                    first = Err(error);
                }
                false
            }
        };
        let mut again = false;
        for request in &requests {
            let refused = send(request).await;
            match request.body {
                Body::Stop if refused && request.to != SubsystemId::ALL => {
                    // Another subsystem has taken over (§3.2/2–4): Stop All, which is never denied.
                    send(&Request::new(SubsystemId::ALL, Body::Stop)).await;
                    again = true;
                }
                // A program that works the valve itself is stopped behind the Close (§3.2/2).
                Body::Stop => again |= request.to == SubsystemId::CONTROL,
                Body::Close { .. } => again |= refused,
                _ => {}
            }
        }
        for close in requests.iter().filter(|it| again && matches!(it.body, Body::Close { .. })) {
            send(close).await;
        }
        first
    }

    /// Sends the undo once, and polls until it is at rest.
    async fn attempt(&self, connection: &Connection) -> Result<End, Error> {
        self.send(connection).await?;
        let mut whose = self.moving.clone();
        whose.extend(self.flowing.iter().chain(&self.limitless));
        let until = Instant::now() + self.settle();
        loop {
            let states = States::read(connection, &whose).await?;
            if self.is_at_rest(&states) {
                return Ok(End::AtRest { state: self.told(&states), open: self.open(&states) });
            }
            if Instant::now() >= until {
                return Ok(End::StillActive(self.told(&states)));
            }
            sleep(PAUSE).await;
        }
    }

    const fn settle(&self) -> Duration {
        if self.flowing.is_empty() { SETTLE } else { SETTLE_VALVE }
    }

    /// The valves among those stopped that are not closed.
    fn open(&self, states: &States) -> Vec<SubsystemId> {
        let valves = self.moving.iter().filter(|who| who.is_valve());
        valves.filter(|who| !is_closed(states, **who)).copied().collect()
    }

    fn is_at_rest(&self, states: &States) -> bool {
        let stands = |who: &SubsystemId| states.flags(*who) & active_bits(*who) == 0;
        let closed = |who: &SubsystemId| is_closed(states, *who);
        let limited = |who: &SubsystemId| states.flags(*who) & DriveFlags::LIMITLESS.bits() == 0;
        self.moving.iter().all(stands)
            && self.flowing.iter().all(closed)
            && self.limitless.iter().all(limited)
    }

    /// The present state as text: only of what was addressed, not of everything polled.
    fn told(&self, states: &States) -> String {
        let first = self.moving.iter().take(1).filter(|_| !self.is_everything());
        let active = |who: &&SubsystemId| states.flags(**who) & active_bits(**who) != 0;
        let mut whose: Vec<SubsystemId> =
            first.chain(&self.flowing).chain(self.moving.iter().filter(active)).copied().collect();
        whose.dedup();
        let one = |who: SubsystemId| {
            let answer = states.of(who)?.decode().ok()?;
            let flags = flags_of(who).set(answer.data.flags_bits()?);
            let flags: Vec<String> = flags.map(|flag: SetFlag| flag.to_string()).collect();
            Some(format!("{who} {} {}", flags.join(" "), values(&answer)).trim_end().to_owned())
        };
        whose.into_iter().filter_map(one).collect::<Vec<_>>().join("; ")
    }

    fn is_everything(&self) -> bool {
        self.requests.first().is_some_and(|request| request.to == SubsystemId::ALL)
    }

    /// The requests as text.
    pub fn words(&self) -> String {
        words_of(&self.requests)
    }

    /// What may still be going on.
    pub fn risk(&self) -> String {
        let join = |all: &[SubsystemId]| {
            all.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
        };
        let mut risks = Vec::new();
        if self.is_everything() {
            risks.push(text::RiskBarrel.str(current()).into());
        } else if let Some(who) = self.moving.first() {
            risks.push(match *who {
                SubsystemId::CONTROL => text::RiskProgram.str(current()).into(),
                valve if valve.is_valve() => {
                    text::RiskValveMoves { valve: Shown(valve) }.of(current())
                }
                SubsystemId::DETECTOR => text::RiskBarrel.str(current()).into(),
                _ => {
                    let drives: Vec<SubsystemId> =
                        self.moving.iter().filter(|who| who.is_drive()).copied().collect();
                    let drives = join(&drives);
                    text::RiskDrives { drives }.of(current())
                }
            });
        }
        if !self.flowing.is_empty() {
            let valves = join(&self.flowing);
            risks.push(text::RiskValvesOpen { valves }.of(current()));
        }
        if !self.limitless.is_empty() {
            let drives = join(&self.limitless);
            risks.push(text::RiskLimitsOff { drives }.of(current()));
        }
        let text = risks.join("; ");
        let mut letters = text.chars();
        letters
            .next()
            .map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
    }

    fn trying(&self, error: &Error) -> String {
        let (risk, words) = (self.risk(), self.words());
        let (error, seconds) = (error.localized(current()), REACH.as_secs());
        text::UndoTries { error, risk, seconds, words }.of(current())
    }
}

/// A command that was broken off, and the outcome of undoing it.
#[derive(Clone, Debug)]
pub struct BrokenOff {
    because: Because,
    end: End,
    undo: Undo,
}

impl BrokenOff {
    /// 130 interrupted, 1 the line was cut or else, both with everything at rest; 4 it may still move or
    /// flow.
    pub const fn exit_code(&self) -> u8 {
        match (&self.end, &self.because) {
            (End::AtRest { .. }, Because::Interrupted) => 130,
            (End::AtRest { .. }, _) => 1,
            _ => 4,
        }
    }

    /// Whether everything was seen at rest.
    pub const fn is_at_rest(&self) -> bool {
        matches!(self.end, End::AtRest { .. })
    }

    /// Whether a command that undoes itself (Stop, Close) has succeeded in spite of the line: it
    /// was seen at rest, not only answered.
    pub fn is_done(&self) -> bool {
        let seen = match &self.end {
            End::AtRest { state, .. } => self.undo.flowing.is_empty() || !state.is_empty(),
            _ => false,
        };
        seen && matches!(self.because, Because::Lost(_))
    }

    /// The message for the user.
    pub fn message(&self) -> String {
        let Self { because, end, undo } = self;
        let (words, risk) = (undo.words(), undo.risk());
        let began = match because {
            Because::Interrupted => text::Interrupted.str(current()).to_owned(),
            Because::Lost(error) => error.localized(current()),
            Because::Failed(why) => why.clone(),
        };
        let ended = match end {
            End::AtRest { state, open } => {
                let state = if state.is_empty() { String::new() } else { format!(" {state}.") };
                let mut ended = text::UndoDone { words, state }.of(current());
                for valve in open {
                    let name = valve.to_string().to_lowercase();
                    let valve = Shown(valve);
                    ended.push('\n');
                    ended.push_str(&text::UndoLeavesOpen { valve, name }.of(current()));
                }
                ended
            }
            End::StillActive(state) => {
                text::UndoNotAtRest { words, state, emergency: emergency() }.of(current())
            }
            End::Unknown(error) => {
                let why = match because {
                    Because::Lost(first)
                        if first.localized(current()) == error.localized(current()) =>
                    {
                        String::new()
                    }
                    _ => format!(" {}", error.localized(current())),
                };
                text::UndoNotSeen { risk, words, emergency: emergency(), why }.of(current())
            }
            End::GivenUp => text::UndoGaveUp { risk, emergency: emergency() }.of(current()),
        };
        format!("{began}\n{ended}")
    }
}

fn emergency() -> &'static str {
    text::UseEmergencyStop.str(current())
}

/// Whether a valve is closed, or does not exist.
fn is_closed(states: &States, valve: SubsystemId) -> bool {
    let flags = ValveFlags::from_bits_retain(states.flags(valve));
    let moves = ValveFlags::OPENING | ValveFlags::CLOSING | ValveFlags::OPEN;
    states.of(valve).is_none() || flags & (moves | ValveFlags::CLOSED) == ValveFlags::CLOSED
}

/// Whether another attempt may help.
pub fn is_of_the_line(error: &Error) -> bool {
    matches!(
        error,
        Error::NoAnswer { .. }
            | Error::Absent { .. }
            | Error::OutcomeUnknown { .. }
            | Error::NotSent { .. }
            | Error::Link { .. }
    )
}

impl Undo {
    /// Whether the command is itself the undo.
    pub const fn is_wanted(&self) -> bool {
        self.wanted
    }

    /// Whether a request that ended with this error has to be undone: it may have been executed, or
    /// is itself the undo.
    pub fn is_needed_after(&self, error: &Error) -> bool {
        may_be_executed(error) || (self.wanted && is_of_the_line(error))
    }
}

/// Whether a request that ended with this error may have been executed.
const fn may_be_executed(error: &Error) -> bool {
    matches!(error, Error::OutcomeUnknown { .. } | Error::Protocol { .. })
}

fn silent(connection: &Connection) -> Error {
    let endpoint = connection.client.endpoint().into();
    Error::Absent { endpoint, tries: 0 }
}

/// Whether any of these subsystems is doing something that Stop ends.
pub fn is_anything_active(states: &[AnswerBuf]) -> bool {
    states.iter().any(|state| {
        let bits = state.decode().ok().and_then(|answer| answer.data.flags_bits());
        bits.unwrap_or(0) & active_bits(state.from()) != 0
    })
}

/// The flags of a subsystem that mean it is doing something that Stop ends.
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

#[cfg(test)]
mod tests;
