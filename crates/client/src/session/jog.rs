//! A motion that lasts only while it is held: a hold-to-run control over a link.
//!
//! The document has no request "move until released": a drive is sent far away and stopped (§3.1).
//! If the Stop is lost, or its sender fails, the drive continues to its limit. So (ours) a motion
//! is held by a lease, and ends in two ways:
//!
//! - **By Stop.** When the lease expires or is released, or the link was lost, Stop is sent until
//!   the Move flag clears.
//! - **By itself**, when no Stop comes any more: the program was killed, the cable cut. A monitor
//!   with the parameter MoveHold (ours, §D/4) receives it in the frame of the Move, and again every
//!   [`Hold::repeat`] together with a read of the drive's state: a renewal never moves a drive that
//!   something else has stopped. For any other monitor the motion consists of short steps, each a
//!   Move to a position just ahead, sent only while the drive moves. With limits off such a drive
//!   does not stop at its destination (§3.17): then the motion is refused unless MoveTimeout is set
//!   (§D/4).
//!
//! ```text
//!          MoveHold? limits?            accepted           still moving
//!   Ask ──────────────────────▶ Move ───────────▶ Held ◀────────────▶ Renew ─▶ Standing (limit, Stop
//!    │ can not end by itself      │ refused         │ released, lapsed,                   by another)
//!    ▼                            ▼                 │ link lost, no answer
//!  Unbounded                    Refused             ▼          Move flag clear
//!                                                 Stop ⇄ Check ───────────────▶ Stopped
//!                                                   │ Denied by Control (§3.2/4): Move to its
//! present position
//! ```
//!
//! Assumed: Stop and Check take time, up to minutes without a link, in which others may send the drive somewhere. Once that is
//! accepted this motion is over: nothing more is stopped for it.

mod steps;

use std::time::Duration;

use lafet_proto::answer::Reply;
use lafet_proto::flags::DriveFlags;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::status::DriveStatus;
use lafet_proto::{Ints, ParamId, Request, RequestId, Status, SubsystemId};

use super::{LONGEST, Now};
use crate::answers::{Answers, RequestBuf};
use crate::error::{Cause, Error};
use steps::Steps;

/// A destination far away, as in the document (§3.1).
const FAR_AWAY: i16 = 21_600;
/// Id of MoveHold, the same in every drive.
pub(crate) const MOVE_HOLD: ParamId = Param::HorizontalMoveHold.id();
/// MoveHold on a fast link: with the Stop of the drive less than half a second.
pub const HOLD_LEAST: Duration = Duration::from_millis(300);
/// The greatest MoveHold that a monitor accepts.
const HOLD_MOST: Duration = Duration::from_secs(10);
/// Margin of MoveHold over two and a half round trips.
const HOLD_SPARE: Duration = Duration::from_millis(50);
/// Default time between two renewals of a motion.
const REPEAT: Duration = Duration::from_millis(100);
/// Pause between two checks of a drive that is to stop.
const CHECK: Duration = Duration::from_millis(100);
/// A drive whose Move was accepted shows it within this time.
const START: Duration = Duration::from_secs(1);
/// Time for which a Move without answer may still arrive after the drive was seen at rest.
const LINGER: Duration = Duration::from_secs(1);
/// Time after which a drive that answers and does not stop is reported to the caller.
const STOPPING_MAX: Duration = Duration::from_secs(30);
/// Time after which a monitor that does not answer is given up.
const SILENCE_MAX: Duration = Duration::from_secs(600);

/// Direction of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Toward {
    /// Greater positions: up, left, narrow (§3.1, §3.3.4).
    Max,
    /// Smaller positions: down, right, wide.
    Min,
}

impl Toward {
    /// Up, for Vertical.
    pub const UP: Self = Self::Max;
    /// Down, for Vertical.
    pub const DOWN: Self = Self::Min;
    /// Left, for Horizontal.
    pub const LEFT: Self = Self::Max;
    /// Right, for Horizontal.
    pub const RIGHT: Self = Self::Min;
    /// Narrow, for Nozzle.
    pub const NARROW: Self = Self::Max;
    /// Wide, for Nozzle.
    pub const WIDE: Self = Self::Min;
}

/// Times of a held motion. A time of more than a day counts as a day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hold {
    /// Duration of the motion after each renewal.
    pub lease: Duration,
    /// Duration after the start: a keyboard waits before it repeats a key.
    pub first_lease: Duration,
    /// Time between two renewals at the monitor: MoveHold, or the next step.
    pub repeat: Duration,
    /// Speed of the monitor's clock, 1000 = ours: only a simulated monitor differs. MoveHold is in
    /// the monitor's time.
    pub clock_permille: u32,
    /// Position at which the drive stops by itself, ahead of where it is. With limits off it does not
    /// (§3.17).
    pub no_farther: Option<i16>,
}

impl Default for Hold {
    fn default() -> Self {
        let lease = Duration::from_millis(300);
        Self { lease, first_lease: lease, repeat: REPEAT, clock_permille: 1000, no_farther: None }
    }
}

impl Hold {
    /// Without times that are too long to be added to others.
    fn bounded(self) -> Self {
        let most = |time: Duration| time.min(LONGEST);
        Self {
            lease: most(self.lease),
            first_lease: most(self.first_lease),
            repeat: most(self.repeat),
            ..self
        }
    }
}

/// Why a motion was ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Reason {
    /// It was released.
    Released,
    /// It was not renewed in time.
    Lapsed,
    /// The connection was lost, or the monitor did not answer.
    LinkLost,
    /// The monitor refused to continue: another client controls the drive, or it is faulty.
    Refused,
    /// This client sent a Stop or Lockout that concerns the drive.
    StopAsked,
}

/// How a motion ended.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum JogEnd {
    /// Stopped, and known to be at rest.
    Stopped {
        /// Why it was stopped.
        reason: Reason,
        /// Position and flags of the drive.
        status: DriveStatus,
    },
    /// At rest for another reason: a limit, a fault, or a Stop of another client.
    Standing(DriveStatus),
    /// The monitor refused to move.
    Refused(Error),
    /// Another motion of the same drive replaced it: a held one, or what others have sent the drive to while this one was
    /// being stopped.
    Replaced,
    /// Another subsystem controls the drive and refuses Stop (§3.2/2–3).
    TakenOver {
        /// The subsystem.
        by: SubsystemId,
    },
    /// The drive answers, but does not stop. Use the emergency stop.
    StillMoving(DriveStatus),
    /// No answer: whether the drive is at rest is not known.
    Unknown(Error),
    /// No motion was started: limits are off, and the monitor has neither MoveHold nor a
    /// MoveTimeout that would end the motion if this program did not.
    Unbounded(DriveStatus),
}

/// The next frame to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Next {
    /// Requests before the main one.
    pub before: Before,
    /// The main request.
    pub body: Body<'static>,
    /// Time after which it must not be sent.
    pub expires: Option<Now>,
}

/// Requests before the main one in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Before {
    /// Nothing.
    Nothing,
    /// GetParam MoveHold of the drive and MoveTimeout of General.
    Ask,
    /// SetParam MoveHold, ms.
    Hold(u32),
}

impl Next {
    /// The requests of the frame.
    ///
    /// # Errors
    ///
    /// [`Error::Unsendable`] for a request that does not fit a record; those of a motion do.
    pub fn requests(&self, drive: SubsystemId) -> Result<Vec<RequestBuf>, Error> {
        let mut all = Vec::with_capacity(3);
        match self.before {
            Before::Nothing => {}
            Before::Ask => {
                let timeout = Param::GeneralMoveTimeout.id();
                for (to, id) in [(drive, MOVE_HOLD), (SubsystemId::GENERAL, timeout)] {
                    all.push(RequestBuf::new(&Request::new(to, Body::GetParam { id }))?);
                }
            }
            Before::Hold(ms) => {
                let values = [ms.cast_signed()];
                let body = Body::SetParam { id: MOVE_HOLD, values: Ints::Values(&values) };
                all.push(RequestBuf::new(&Request::new(drive, body))?);
            }
        }
        all.push(RequestBuf::new(&Request::new(drive, self.body))?);
        Ok(all)
    }
}

/// What ends a motion that is not renewed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// Not known yet.
    Ask,
    /// MoveHold ends it.
    Hold,
    /// The destination of its step ends it; MoveTimeout if limits are off.
    Steps { timeout: bool },
}

#[derive(Debug)]
enum Phase {
    /// Ask what ends the motion.
    Ask,
    /// Send Move.
    Move,
    /// Held; renew at this time.
    Held(Now),
    /// Renew now.
    Renew,
    /// Send Stop at this time.
    Stop(Now),
    /// Check at this time whether the drive is at rest.
    Check(Now),
    /// Stop is denied during a program: send Move to the present position.
    StayAt(i16),
    Ended,
}

/// State of a held motion, without I/O and clock.
#[derive(Debug)]
pub struct JogCore {
    drive: SubsystemId,
    toward: Toward,
    hold: Hold,
    ends: End,
    steps: Steps,
    phase: Phase,
    /// Time of the last frame, and the usual duration of an answer.
    sent: Now,
    rtt: Duration,
    limitless: bool,
    lease_until: Now,
    /// Time of the first Move.
    began: Now,
    seen_moving: bool,
    reason: Option<Reason>,
    stopping_since: Now,
    /// Time of the last answer.
    heard: Now,
    /// A Move may still arrive at the monitor.
    stray_move: bool,
    stands_since: Option<Now>,
    denied_by: Option<SubsystemId>,
    end: Option<JogEnd>,
}

impl JogCore {
    /// A motion that starts now. `holds`: the monitor is known to have MoveHold.
    pub fn new(now: Now, drive: SubsystemId, toward: Toward, hold: Hold, holds: bool) -> Self {
        let hold = hold.bounded();
        let (ends, phase) = if holds { (End::Hold, Phase::Move) } else { (End::Ask, Phase::Ask) };
        Self {
            drive,
            toward,
            hold,
            ends,
            steps: Steps::new(drive, toward == Toward::Max, hold.repeat, hold.no_farther),
            phase,
            sent: now,
            rtt: Duration::ZERO,
            limitless: false,
            lease_until: now + hold.first_lease,
            began: now,
            seen_moving: false,
            reason: None,
            stopping_since: now,
            heard: now,
            stray_move: false,
            stands_since: None,
            denied_by: None,
            end: None,
        }
    }

    /// Sets the usual round trip, once it is known.
    pub fn set_rtt(&mut self, rtt: Option<Duration>) {
        self.rtt = rtt.unwrap_or(self.rtt);
    }

    /// Whether the monitor has MoveHold, if known.
    pub fn holds(&self) -> Option<bool> {
        (self.ends != End::Ask).then_some(self.ends == End::Hold)
    }

    /// The drive.
    pub const fn drive(&self) -> SubsystemId {
        self.drive
    }

    /// The Move request of this motion.
    pub const fn request(&self) -> Request<'static> {
        Request::new(self.drive, Body::Move { destination: self.far() })
    }

    const fn far(&self) -> i16 {
        match (self.toward, self.hold.no_farther) {
            (_, Some(position)) => position,
            (Toward::Max, None) => FAR_AWAY,
            (Toward::Min, None) => -FAR_AWAY,
        }
    }

    /// Whether it is held: not ended, and not being stopped.
    pub const fn is_held(&self) -> bool {
        self.reason.is_none() && self.end.is_none() && !matches!(self.phase, Phase::Ended)
    }

    /// Extends it by another lease; `false` if it is being stopped or has ended.
    pub fn renew(&mut self, now: Now) -> bool {
        self.handle_timeout(now);
        let held = self.is_held();
        if held {
            self.lease_until = self.lease_until.max(now + self.hold.lease);
        }
        held
    }

    /// Stops it, for this reason.
    pub fn stop(&mut self, now: Now, reason: Reason) {
        if !self.is_held() {
            return;
        }
        self.reason = Some(reason);
        self.stopping_since = now;
        self.heard = now;
        self.phase = Phase::Stop(now);
    }

    /// Ends it because another motion of the same drive starts: nothing more is sent.
    pub fn replace(&mut self) {
        self.finish(JogEnd::Replaced);
    }

    /// A request of others that sets the drive in motion was accepted; it was submitted at this time. If this motion was being
    /// stopped by then it is over: a further Stop would end theirs, and their rest is none of its own. Whether it is.
    pub fn begun_by_others(&mut self, submitted: Now) -> bool {
        let stops = self.reason.is_some() && !matches!(self.phase, Phase::Ended);
        let replaced = stops && self.stopping_since < submitted;
        if replaced {
            self.replace();
        }
        replaced
    }

    /// Handles the time: see [`JogCore::poll_timeout`].
    pub fn handle_timeout(&mut self, now: Now) {
        if now >= self.lease_until {
            self.stop(now, Reason::Lapsed);
        }
        match self.phase {
            Phase::Held(at) if now >= at => self.phase = Phase::Renew,
            _ => {}
        }
    }

    /// Latest time for the next call of [`JogCore::handle_timeout`] or [`JogCore::poll_next`].
    pub fn poll_timeout(&self) -> Option<Now> {
        let lease = self.is_held().then_some(self.lease_until);
        let phase = match self.phase {
            Phase::Held(at) | Phase::Stop(at) | Phase::Check(at) => Some(at),
            _ => None,
        };
        lease.into_iter().chain(phase).min()
    }

    /// The next frame, unless one of this motion is under way. Its results go to
    /// [`JogCore::handle_result`].
    pub fn poll_next(&mut self, now: Now) -> Option<Next> {
        self.handle_timeout(now);
        let lease = Some(self.lease_until);
        let hold = match self.ends {
            End::Hold => Before::Hold(self.move_hold_ms()),
            End::Ask | End::Steps { .. } => Before::Nothing,
        };
        let (before, body, expires) = match self.phase {
            Phase::Ask => (Before::Ask, Body::GetStatus, lease),
            Phase::Move => {
                self.stray_move = true;
                (hold, Body::Move { destination: self.destination(now) }, lease)
            }
            Phase::Renew => (hold, Body::GetStatus, lease),
            Phase::Stop(at) if now >= at => (Before::Nothing, Body::Stop, None),
            Phase::Check(at) if now >= at => (Before::Nothing, Body::GetStatus, None),
            Phase::StayAt(position) => {
                (Before::Nothing, Body::Move { destination: position }, None)
            }
            Phase::Held(_) | Phase::Stop(_) | Phase::Check(_) | Phase::Ended => return None,
        };
        self.sent = now;
        Some(Next { before, body, expires })
    }

    fn destination(&mut self, now: Now) -> i16 {
        match self.ends {
            End::Steps { .. } if !self.limitless => self.steps.next(now, self.rtt),
            _ => self.far(),
        }
    }

    /// Long enough for a lost renewal to be sent again, or for one that waits for the answer to a
    /// poll, and no longer.
    fn move_hold_ms(&self) -> u32 {
        let hold = (self.rtt * 5 / 2 + HOLD_SPARE).max(self.hold.repeat * 2).max(HOLD_LEAST);
        let theirs = hold * self.hold.clock_permille / 1000;
        u32::try_from(theirs.min(HOLD_MOST).as_millis()).unwrap_or(u32::MAX)
    }

    /// Takes the results of the last frame of [`JogCore::poll_next`], one for each request.
    pub fn handle_result(&mut self, now: Now, mut results: Vec<Result<Answers, Error>>) {
        let Some(last) = results.pop() else { return };
        let answers = match last {
            Ok(answers) => answers,
            Err(error) => return self.unanswered(now, error),
        };
        self.heard = now;
        if self.reason.is_none() && matches!(self.phase, Phase::Ask) {
            return self.asked(now, &results, drive_status(&answers));
        }
        let before = results.first().is_none_or(|result| success(result).is_some());
        let answer = answers.first();
        let (request, status, by) = (answer.request(), answer.status(), answer.from());
        match (request, self.reason) {
            (RequestId::MOVE, None) => {
                self.stray_move = false;
                match answers.accepted() {
                    // The drive moves, and nothing will end it: another monitor answers than
                    // before.
                    Ok(_) if !before => {
                        self.ends = End::Ask;
                        self.stop(now, Reason::Refused);
                    }
                    Ok(_) => self.phase = Phase::Held(self.next_renewal(now)),
                    // The first Move was refused: nothing moves. A repeated one was refused:
                    // another client controls the drive, or it is faulty.
                    Err(error) if !self.seen_moving => self.finish(JogEnd::Refused(error)),
                    Err(_) => self.stop(now, Reason::Refused),
                }
            }
            (RequestId::GET_STATUS, None) => self.looked(now, drive_status(&answers)),
            (RequestId::GET_STATUS, Some(reason)) => {
                self.checked(now, reason, drive_status(&answers));
            }
            // Move to the present position: a refusal means that another subsystem controls the
            // drive.
            (RequestId::MOVE, Some(_)) if status.is_success() => {
                self.phase = Phase::Check(now + CHECK);
            }
            (RequestId::MOVE, Some(_)) => self.finish(JogEnd::TakenOver { by }),
            _ => {
                let denied = status == Status::DENIED && by != self.drive;
                self.denied_by = denied.then_some(by);
                self.phase = Phase::Check(now + CHECK);
            }
        }
    }

    /// Renewals keep their period: a slow answer does not delay the next one.
    fn next_renewal(&self, now: Now) -> Now {
        now.max(self.sent + self.hold.repeat)
    }

    /// Evaluates what ends a motion of this monitor that is not renewed.
    fn asked(&mut self, now: Now, results: &[Result<Answers, Error>], status: Option<DriveStatus>) {
        let Some(status) = status else { return self.stop(now, Reason::LinkLost) };
        let holds = results.first().and_then(success).is_some();
        let timeout = results.get(1).and_then(success).and_then(value).is_some_and(|ms| ms > 0);
        self.ends = if holds { End::Hold } else { End::Steps { timeout } };
        if !self.saw(now, status) {
            return self.finish(JogEnd::Unbounded(status));
        }
        self.phase = Phase::Move;
    }

    /// Evaluates the drive's state; `false` if nothing ends this motion by itself.
    fn saw(&mut self, now: Now, status: DriveStatus) -> bool {
        self.limitless = status.flags.contains(DriveFlags::LIMITLESS);
        self.steps.saw(now, status);
        !self.limitless || matches!(self.ends, End::Hold | End::Steps { timeout: true })
    }

    /// The end of the motion, returned once.
    pub const fn poll_end(&mut self) -> Option<JogEnd> {
        self.end.take()
    }

    /// The connection is lost and will not be reopened.
    pub fn gone(&mut self, error: Error) {
        self.finish(JogEnd::Unknown(error));
    }

    fn unanswered(&mut self, now: Now, error: Error) {
        // Not sent because its time limit passed: the lease decides.
        let expired = matches!(&error, Error::NotSent { .. });
        if self.reason.is_none() {
            self.handle_timeout(now);
            let reason = if expired { Reason::Lapsed } else { Reason::LinkLost };
            return self.stop(now, reason);
        }
        // Stop is answered, and a check cannot be sent: a controller has appeared on the line.
        let unconnected = matches!(&error, Error::NotSent { cause: Cause::Link(_), .. });
        let refused = expired && !unconnected && now >= self.stopping_since + STOPPING_MAX;
        let silent = now >= self.heard + SILENCE_MAX;
        if matches!(error, Error::Closed) || refused || silent {
            return self.finish(JogEnd::Unknown(error));
        }
        // A Stop without answer is followed by another Stop.
        self.phase = Phase::Stop(now + CHECK);
    }

    /// Evaluates the state of a drive that is held.
    fn looked(&mut self, now: Now, status: Option<DriveStatus>) {
        let Some(status) = status else { return self.stop(now, Reason::LinkLost) };
        if !self.saw(now, status) {
            return self.stop(now, Reason::Refused);
        }
        let moving = status.flags.contains(DriveFlags::MOVE);
        self.seen_moving |= moving;
        let held = self.ends == End::Hold;
        // A step that was too short has ended; the next one is longer.
        let arrived = !held && self.steps.has_arrived(&status);
        if moving && held {
            self.phase = Phase::Held(self.next_renewal(now));
        } else if moving || arrived {
            self.phase = Phase::Move;
        } else if !self.seen_moving && now < self.began + START {
            self.phase = Phase::Held(now + CHECK);
        } else {
            self.finish(JogEnd::Standing(status));
        }
    }

    /// Evaluates the state of a drive that is to be at rest.
    fn checked(&mut self, now: Now, reason: Reason, status: Option<DriveStatus>) {
        self.phase = Phase::Stop(now);
        let Some(status) = status else { return };
        if status.flags.contains(DriveFlags::MOVE) {
            self.stands_since = None;
            match self.denied_by {
                Some(SubsystemId::CONTROL) => self.phase = Phase::StayAt(status.position),
                Some(by @ (SubsystemId::DEPLOYER | SubsystemId::DETECTOR)) => {
                    self.finish(JogEnd::TakenOver { by });
                }
                _ if now >= self.stopping_since + STOPPING_MAX => {
                    self.finish(JogEnd::StillMoving(status));
                }
                _ => {}
            }
            return;
        }
        let since = *self.stands_since.get_or_insert(now);
        if self.stray_move && now < since + LINGER {
            self.phase = Phase::Check(now + CHECK);
            return;
        }
        self.finish(JogEnd::Stopped { reason, status });
    }

    fn finish(&mut self, end: JogEnd) {
        if !matches!(self.phase, Phase::Ended) {
            self.phase = Phase::Ended;
            self.end = Some(end);
        }
    }
}

/// The answers, if the monitor executed all requests.
fn success(result: &Result<Answers, Error>) -> Option<&Answers> {
    result.as_ref().ok().filter(|answers| answers.first().status().is_success())
}

/// The value of a parameter.
fn value(answers: &Answers) -> Option<i32> {
    match answers.first().decode().ok()?.data {
        Reply::Param { values, .. } => values.get(0),
        _ => None,
    }
}

fn drive_status(answers: &Answers) -> Option<DriveStatus> {
    match answers.first().decode().ok()?.data {
        Reply::Drive(status) => Some(status),
        // The Deployer's state has the structure of a drive, with the same Move flag (§3.3).
        Reply::Deployer(status) => Some(DriveStatus {
            flags: DriveFlags::from_bits_retain(status.flags.bits()),
            position: status.position,
            current: status.current,
            speed: status.speed,
        }),
        _ => None,
    }
}
