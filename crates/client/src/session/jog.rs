//! A motion that lasts only as long as it is held: a dead-man switch over a wire.
//!
//! The document has no request "move until released": a drive is sent far away and stopped (§3.1). If
//! the Stop is lost, or its sender is gone, the drive goes on to its limit. So (ours) a motion is held
//! by a lease, and ends twice over:
//!
//! - **By Stop.** When the lease lapses, is released, or the link was lost, Stop is sent until the Move
//!   flag clears.
//! - **By itself**, when no Stop comes any more: the program was killed, the cable cut. A monitor with
//!   the parameter MoveHold (ours, §D/4) is given it in the frame of the Move, and again every
//!   [`Hold::repeat`] together with a look at the drive: a renewal never sets a drive in motion that
//!   something else has stopped. To any other monitor the motion goes as short steps, each a Move
//!   to a place just ahead, sent only while the drive moves. With limits off such a drive does not stop
//!   at its destination (§3.17): then the motion is refused unless MoveTimeout is set (§D/4).
//!
//! ```text
//!          MoveHold? limits?            accepted           still moving
//!   Ask ──────────────────────▶ Move ───────────▶ Held ◀────────────▶ Renew ─▶ Standing (limit, Stop
//!    │ can not end by itself      │ refused         │ released, lapsed,                   by another)
//!    ▼                            ▼                 │ link lost, no answer
//!  Unbounded                    Refused             ▼          Move flag clear
//!                                                 Stop ⇄ Check ───────────────▶ Stopped
//!                                                   │ Denied by Control (§3.2/4): Move to where it is
//! ```

mod steps;

use std::time::Duration;

use lafet_proto::answer::Reply;
use lafet_proto::flags::DriveFlags;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::status::DriveStatus;
use lafet_proto::{Ints, ParamId, Request, RequestId, Status, SubsystemId};

use super::Now;
use crate::answers::{Answers, RequestBuf};
use crate::error::Error;
use steps::Steps;

/// Far away, as the document has it (§3.1).
const FAR_AWAY: i16 = 21_600;
/// MoveHold: the same id in every drive.
pub(crate) const MOVE_HOLD: ParamId = Param::HorizontalMoveHold.id();
/// MoveHold where answers are quick: Stop of the drive included, less than half a second.
pub const HOLD_LEAST: Duration = Duration::from_millis(300);
/// The greatest MoveHold that a monitor takes.
const HOLD_MOST: Duration = Duration::from_secs(10);
/// MoveHold exceeds two and a half round trips by this.
const HOLD_SPARE: Duration = Duration::from_millis(50);
/// How often a motion is renewed unless the caller says otherwise.
const REPEAT: Duration = Duration::from_millis(100);
/// Pause between two looks at a drive that is to stop.
const CHECK: Duration = Duration::from_millis(100);
/// A drive whose Move was accepted shows it within this time.
const START: Duration = Duration::from_secs(1);
/// A Move without answer may arrive this long after the drive was seen to stand.
const LINGER: Duration = Duration::from_secs(1);
/// A drive that answers and does not stop for so long is told to the caller.
const STOPPING_MAX: Duration = Duration::from_secs(30);
/// A monitor that does not answer for so long is given up.
const SILENCE_MAX: Duration = Duration::from_secs(600);

/// Which way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Toward {
    /// The greater positions: up, left, narrow (§3.1, §3.3.4).
    Max,
    /// The lesser positions: down, right, wide.
    Min,
}

impl Toward {
    /// Vertical.
    pub const UP: Self = Self::Max;
    /// Vertical.
    pub const DOWN: Self = Self::Min;
    /// Horizontal.
    pub const LEFT: Self = Self::Max;
    /// Horizontal.
    pub const RIGHT: Self = Self::Min;
    /// Nozzle.
    pub const NARROW: Self = Self::Max;
    /// Nozzle.
    pub const WIDE: Self = Self::Min;
}

/// How a motion is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hold {
    /// It goes on for this long after each renewal.
    pub lease: Duration,
    /// The same after the start: a keyboard waits before it repeats a key.
    pub first_lease: Duration,
    /// How often the motion is renewed at the monitor: MoveHold, or the next step.
    pub repeat: Duration,
    /// How fast the monitor's clock runs, 1000 = as ours: only a simulated monitor differs. MoveHold
    /// is in its time.
    pub clock_permille: u32,
}

impl Default for Hold {
    fn default() -> Self {
        let lease = Duration::from_millis(300);
        Self { lease, first_lease: lease, repeat: REPEAT, clock_permille: 1000 }
    }
}

/// Why a motion was to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Reason {
    /// It was let go.
    Released,
    /// It was not renewed in time.
    Lapsed,
    /// The connection was lost, or the monitor did not answer.
    LinkLost,
    /// The monitor refused to go on: somebody else has the drive, or it is at fault.
    Refused,
    /// This client was asked for a Stop or Lockout that concerns the drive.
    StopAsked,
}

/// How a motion ended.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum JogEnd {
    /// Stopped, and seen to stand.
    Stopped {
        /// Why.
        reason: Reason,
        /// Where, and its flags.
        status: DriveStatus,
    },
    /// It stood by itself: at a limit, by a fault, or somebody else has stopped it.
    Standing(DriveStatus),
    /// The monitor refused to move.
    Refused(Error),
    /// Another motion of the same drive took its place.
    Replaced,
    /// Another subsystem has taken the drive, and refuses Stop (§3.2/2–3).
    TakenOver {
        /// Which.
        by: SubsystemId,
    },
    /// It answers, but goes on in spite of Stop. Use the emergency stop.
    StillMoving(DriveStatus),
    /// Nobody answers: whether it stands is not known.
    Unknown(Error),
    /// Nothing was set in motion: limits are off, and the monitor has neither MoveHold nor a
    /// MoveTimeout that would end the motion if this program did not.
    Unbounded(DriveStatus),
}

/// What is to be sent next, in one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Next {
    /// What goes before the request.
    pub before: Before,
    /// The request.
    pub body: Body<'static>,
    /// Not to be sent after this moment.
    pub expires: Option<Now>,
}

/// What goes before a request in its frame.
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
    /// [`Error::Unsendable`] for a request that fits no record; those of a motion do.
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

/// What ends a motion when nothing renews it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// Not yet known.
    Ask,
    /// MoveHold.
    Hold,
    /// The destination of its step; MoveTimeout where limits are off.
    Steps { timeout: bool },
}

#[derive(Debug)]
enum Phase {
    /// What ends the motion is to be asked.
    Ask,
    /// Move is to be sent.
    Move,
    /// Held: to be renewed at this time.
    Held(Now),
    /// To be renewed now.
    Renew,
    /// Stop is to be sent at this time.
    Stop(Now),
    /// To be looked at, at this time, to see whether it stands.
    Check(Now),
    /// Stop is denied during a program: to be sent where it is.
    StayAt(i16),
    Ended,
}

/// A motion that is held: no I/O, no clock.
#[derive(Debug)]
pub struct JogCore {
    drive: SubsystemId,
    toward: Toward,
    hold: Hold,
    ends: End,
    steps: Steps,
    phase: Phase,
    /// When the last frame was sent, and how long an answer takes.
    sent: Now,
    rtt: Duration,
    limitless: bool,
    lease_until: Now,
    /// When Move was sent first.
    began: Now,
    seen_moving: bool,
    reason: Option<Reason>,
    stopping_since: Now,
    /// The last answer to anything.
    heard: Now,
    /// A Move may still arrive.
    stray_move: bool,
    stands_since: Option<Now>,
    denied_by: Option<SubsystemId>,
    end: Option<JogEnd>,
}

impl JogCore {
    /// A motion that starts now. `holds`: the monitor is known to have MoveHold.
    pub fn new(now: Now, drive: SubsystemId, toward: Toward, hold: Hold, holds: bool) -> Self {
        let (ends, phase) = if holds { (End::Hold, Phase::Move) } else { (End::Ask, Phase::Ask) };
        Self {
            drive,
            toward,
            hold,
            ends,
            steps: Steps::new(drive, toward == Toward::Max, hold.repeat),
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

    /// How long an answer usually takes, as soon as that is known.
    pub fn set_rtt(&mut self, rtt: Option<Duration>) {
        self.rtt = rtt.unwrap_or(self.rtt);
    }

    /// Whether the monitor has MoveHold, if that is known.
    pub fn holds(&self) -> Option<bool> {
        (self.ends != End::Ask).then_some(self.ends == End::Hold)
    }

    /// The drive.
    pub const fn drive(&self) -> SubsystemId {
        self.drive
    }

    /// A Move as this motion sends it.
    pub const fn request(&self) -> Request<'static> {
        Request::new(self.drive, Body::Move { destination: self.far() })
    }

    const fn far(&self) -> i16 {
        match self.toward {
            Toward::Max => FAR_AWAY,
            Toward::Min => -FAR_AWAY,
        }
    }

    /// It is still held: not ended, and not about to be stopped.
    pub const fn is_held(&self) -> bool {
        self.reason.is_none() && self.end.is_none() && !matches!(self.phase, Phase::Ended)
    }

    /// Holds it for another lease. `false`: too late, it is being stopped or has ended.
    pub fn renew(&mut self, now: Now) -> bool {
        self.handle_timeout(now);
        let held = self.is_held();
        if held {
            self.lease_until = self.lease_until.max(now + self.hold.lease);
        }
        held
    }

    /// Lets it go, or takes it away.
    pub fn stop(&mut self, now: Now, reason: Reason) {
        if !self.is_held() {
            return;
        }
        self.reason = Some(reason);
        self.stopping_since = now;
        self.heard = now;
        self.phase = Phase::Stop(now);
    }

    /// Another motion of the same drive begins: nothing more is sent for this one.
    pub fn replace(&mut self) {
        self.finish(JogEnd::Replaced);
    }

    /// Time has passed.
    pub fn handle_timeout(&mut self, now: Now) {
        if now >= self.lease_until {
            self.stop(now, Reason::Lapsed);
        }
        match self.phase {
            Phase::Held(at) if now >= at => self.phase = Phase::Renew,
            _ => {}
        }
    }

    /// When [`JogCore::handle_timeout`] or [`JogCore::poll_next`] is to be called at the latest.
    pub fn poll_timeout(&self) -> Option<Now> {
        let lease = self.is_held().then_some(self.lease_until);
        let phase = match self.phase {
            Phase::Held(at) | Phase::Stop(at) | Phase::Check(at) => Some(at),
            _ => None,
        };
        lease.into_iter().chain(phase).min()
    }

    /// The next frame, when none of this motion is under way. [`JogCore::handle_result`] wants its
    /// results.
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

    /// Long enough for a renewal that is lost to be sent again, or that waits for the answer to a poll,
    /// and no longer.
    fn move_hold_ms(&self) -> u32 {
        let hold = (self.rtt * 5 / 2 + HOLD_SPARE).max(self.hold.repeat * 2).max(HOLD_LEAST);
        let theirs = hold * self.hold.clock_permille / 1000;
        u32::try_from(theirs.min(HOLD_MOST).as_millis()).unwrap_or(u32::MAX)
    }

    /// What came of the frame that [`JogCore::poll_next`] gave last: a result for each request.
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
                    // It moves, and nothing will end it: another monitor answers than before.
                    Ok(_) if !before => {
                        self.ends = End::Ask;
                        self.stop(now, Reason::Refused);
                    }
                    Ok(_) => self.phase = Phase::Held(self.next_renewal(now)),
                    // The first Move refused: nothing moves. A repeated one: another has the drive
                    // now, or it is at fault.
                    Err(error) if !self.seen_moving => self.finish(JogEnd::Refused(error)),
                    Err(_) => self.stop(now, Reason::Refused),
                }
            }
            (RequestId::GET_STATUS, None) => self.looked(now, drive_status(&answers)),
            (RequestId::GET_STATUS, Some(reason)) => {
                self.checked(now, reason, drive_status(&answers));
            }
            // To where it is: refused means that another has it.
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

    /// Renewals keep their pace: an answer that took long does not delay the next.
    fn next_renewal(&self, now: Now) -> Now {
        now.max(self.sent + self.hold.repeat)
    }

    /// What ends a motion of this monitor when nothing renews it.
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

    /// `false`: nothing ends this motion by itself.
    fn saw(&mut self, now: Now, status: DriveStatus) -> bool {
        self.limitless = status.flags.contains(DriveFlags::LIMITLESS);
        self.steps.saw(now, status);
        !self.limitless || matches!(self.ends, End::Hold | End::Steps { timeout: true })
    }

    /// The end, once.
    pub const fn poll_end(&mut self) -> Option<JogEnd> {
        self.end.take()
    }

    /// The connection is lost and will not be made again.
    pub fn gone(&mut self, error: Error) {
        self.finish(JogEnd::Unknown(error));
    }

    fn unanswered(&mut self, now: Now, error: Error) {
        // Not sent because its time was over: the lease says the rest.
        let expired = matches!(&error, Error::NotSent { .. });
        if self.reason.is_none() {
            self.handle_timeout(now);
            let reason = if expired { Reason::Lapsed } else { Reason::LinkLost };
            return self.stop(now, reason);
        }
        if matches!(error, Error::Closed) || now >= self.heard + SILENCE_MAX {
            return self.finish(JogEnd::Unknown(error));
        }
        // A Stop without answer is followed by a Stop.
        self.phase = Phase::Stop(now + CHECK);
    }

    /// A look at a drive that is held.
    fn looked(&mut self, now: Now, status: Option<DriveStatus>) {
        let Some(status) = status else { return self.stop(now, Reason::LinkLost) };
        if !self.saw(now, status) {
            return self.stop(now, Reason::Refused);
        }
        let moving = status.flags.contains(DriveFlags::MOVE);
        self.seen_moving |= moving;
        let held = self.ends == End::Hold;
        // A step that was too short has ended; the next is longer.
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

    /// A look at a drive that is to stand.
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

/// The answers, unless the monitor did not do what was asked.
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
        // The Deployer's structure is a drive's, and so is its Move flag (§3.3).
        Reply::Deployer(status) => Some(DriveStatus {
            flags: DriveFlags::from_bits_retain(status.flags.bits()),
            position: status.position,
            current: status.current,
            speed: status.speed,
        }),
        _ => None,
    }
}
