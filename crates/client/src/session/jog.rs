//! A motion that goes on only as long as somebody holds it: a dead-man switch over a wire.
//!
//! The document has no request "move until I let go": a drive is sent far away and stopped (§3.1).
//! If the Stop is lost, or who was to send it is gone, it goes on to its limit. So (ours): a motion
//! is held by a lease. When it lapses, is let go, or the link was lost, Stop is sent until the
//! Move flag clears. While it is held, the drive is looked at and Move repeated every
//! [`Hold::repeat`]: a monitor with MoveTimeout then stops by itself should this program die, a
//! program of extinguishing stays paused (§3.1/3), and a drive that somebody else has stopped is not
//! set in motion again.
//!
//! ```text
//!            accepted           still moving
//!   Move ───────────────▶ Held ◀────────────▶ Look ─▶ Standing (limit, Stop by another)
//!    │ refused              │ let go, lapsed, link lost, no answer
//!    ▼                      ▼          Move flag clear
//!  Refused                Stop ⇄ Check ───────────────▶ Stopped
//!                           │ Denied by Control (§3.2/4): Move to where it is
//! ```

use std::time::Duration;

use lafet_proto::answer::Reply;
use lafet_proto::flags::DriveFlags;
use lafet_proto::request::Body;
use lafet_proto::status::DriveStatus;
use lafet_proto::{Request, RequestId, Status, SubsystemId};

use super::Now;
use crate::answers::Answers;
use crate::error::Error;

/// Far away, as the document has it (§3.1).
const FAR_AWAY: i16 = 21_600;
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
    /// How often the drive is looked at, and Move repeated.
    pub repeat: Duration,
}

impl Default for Hold {
    fn default() -> Self {
        let lease = Duration::from_millis(300);
        Self { lease, first_lease: lease, repeat: lease }
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
}

/// What is to be sent next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Next {
    /// The request.
    pub body: Body<'static>,
    /// Not to be sent after this moment.
    pub expires: Option<Now>,
}

#[derive(Debug)]
enum Phase {
    /// Move is to be sent.
    Move,
    /// Held: to be looked at again at this time.
    Held(Now),
    /// To be looked at now.
    Look,
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
    destination: i16,
    hold: Hold,
    phase: Phase,
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
    /// A motion that begins now.
    pub fn new(now: Now, drive: SubsystemId, toward: Toward, hold: Hold) -> Self {
        let destination = match toward {
            Toward::Max => FAR_AWAY,
            Toward::Min => -FAR_AWAY,
        };
        Self {
            drive,
            destination,
            hold,
            phase: Phase::Move,
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

    /// The drive.
    pub const fn drive(&self) -> SubsystemId {
        self.drive
    }

    /// Move, as it is sent.
    pub const fn request(&self) -> Request<'static> {
        Request::new(self.drive, Body::Move { destination: self.destination })
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
            Phase::Held(at) if now >= at => self.phase = Phase::Look,
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

    /// The next request, when none of this motion is under way. [`JogCore::handle_result`] wants
    /// its result.
    pub fn poll_next(&mut self, now: Now) -> Option<Next> {
        self.handle_timeout(now);
        let (body, expires) = match self.phase {
            Phase::Move => {
                self.stray_move = true;
                (Body::Move { destination: self.destination }, Some(self.lease_until))
            }
            Phase::Look => (Body::GetStatus, Some(self.lease_until)),
            Phase::Stop(at) if now >= at => (Body::Stop, None),
            Phase::Check(at) if now >= at => (Body::GetStatus, None),
            Phase::StayAt(position) => (Body::Move { destination: position }, None),
            Phase::Held(_) | Phase::Stop(_) | Phase::Check(_) | Phase::Ended => return None,
        };
        Some(Next { body, expires })
    }

    /// What came of the request that [`JogCore::poll_next`] gave last.
    pub fn handle_result(&mut self, now: Now, result: Result<Answers, Error>) {
        let answers = match result {
            Ok(answers) => answers,
            Err(error) => return self.unanswered(now, error),
        };
        self.heard = now;
        let answer = answers.first();
        let (request, status, by) = (answer.request(), answer.status(), answer.from());
        match (request, self.reason) {
            (RequestId::MOVE, None) => {
                self.stray_move = false;
                match answers.accepted() {
                    Ok(_) => {
                        let pause = if self.seen_moving { self.hold.repeat } else { CHECK };
                        self.phase = Phase::Held(now + pause);
                    }
                    // The first Move refused: nothing moves. A repeated one: somebody else has the
                    // drive now, or it is at fault.
                    Err(error) if !self.seen_moving => self.finish(JogEnd::Refused(error)),
                    Err(_) => self.stop(now, Reason::Refused),
                }
            }
            (RequestId::GET_STATUS, None) => self.looked(now, drive_status(&answers)),
            (RequestId::GET_STATUS, Some(reason)) => {
                self.checked(now, reason, drive_status(&answers));
            }
            // To where it is: refused means that somebody else has it.
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
        let moving = status.flags.contains(DriveFlags::MOVE);
        self.seen_moving |= moving;
        if moving {
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
