//! §3.3.8 «Флаги состояния Deployer»: between the standby (wrapped) and the working position.
//!
//! ```text
//!   Wrapped ──Deploy──▶ Deploying ──deployed switch──▶ Deployed
//!      ▲                 │    ▲                           │
//!      │               Wrap  Deploy                  Wrap │
//!      │                 ▼    │                           ▼
//!      └─wrapped switch─ Wrapping: barrel to its rest, then folding
//!
//!   Stop, Move, a fault or the time over: Between, or where the switches say it is.
//! ```
//! §D/6 A switch that says it has arrived is believed if the position agrees. Of a barrel that rests where it was
//! believed to be, the position may jump: what is being extinguished goes on.

use crate::cause::{Asked, Cause, Program, Rule};
use crate::image::{AXES, Axis, DriveInput};
use crate::inputs::{Stale, lasted};
use crate::params::Params;
use crate::subsystem::control::approach::PATIENCE_MS;
use crate::subsystem::drive::Drive;
use crate::subsystem::{by_axis, of_axis};
use crate::time::{Millis, Timer};
use lafet_proto::Status;
use lafet_proto::flags::{DeployerFlags, DriveFlags};
use lafet_proto::param::{DriveParam, Param};
use lafet_proto::status::DeployerStatus;

/// Direction of the barrel in which it can be folded (ours): straight ahead, level.
const REST_ARCMIN: i32 = 0;
/// A barrel this far off its direction can still be folded (ours), arc-minutes: more than drives with play
/// and lag miss it by.
const NEAR_ARCMIN: u32 = 30;
/// The drives that go there.
const RESTING: [Axis; 2] = [Axis::Horizontal, Axis::Vertical];

/// Where the monitor is between its two positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Position {
    /// Standby.
    Wrapped,
    /// On the way to work.
    Deploying,
    /// In working position.
    Deployed,
    /// The barrel goes to its rest before it is folded.
    Resting,
    /// On the way to standby.
    Folding,
    /// Neither, and standing still.
    Between,
}

/// Deployment.
#[derive(Clone, Debug, PartialEq)]
pub struct Deployer {
    position: Position,
    /// Of what it moves.
    cause: Cause,
    /// For the motion of its drive; for a barrel that goes to its rest, until it has come nearer.
    travel: Timer,
    /// Resting: how far the barrel was from its rest when it last came nearer, '. Folding: what is left of
    /// TravelTime for the other of the two, to fold and to be held, ms.
    left: u32,
    /// Water in the barrel holds it: for TravelTime at most.
    held: bool,
    failed: bool,
    internal_fault: bool,
    /// Where its switches say it rests, as far as they are believed.
    seen: Position,
    /// For how long its position has contradicted a switch, ms.
    differs_ms: u8,
    /// It has for longer than a contact may blip: no switch is believed until the reset.
    doubted: bool,
    /// It has been driven since its switches were last believed.
    strayed: bool,
    /// Of a remote unit.
    stale: Stale,
}

impl Default for Deployer {
    /// §D/1 The sensors tell where the monitor is, as soon as they can be believed.
    fn default() -> Self {
        Self {
            position: Position::Between,
            cause: Cause::Rule(Rule::Inert),
            travel: Timer::default(),
            left: u32::MAX,
            held: false,
            failed: false,
            internal_fault: false,
            seen: Position::Between,
            differs_ms: 0,
            doubted: false,
            strayed: false,
            stale: Stale::default(),
        }
    }
}

impl Deployer {
    /// In working position.
    pub fn is_deployed(&self) -> bool {
        self.position == Position::Deployed
    }

    /// In standby, and not about to leave it.
    #[cfg(feature = "update")]
    pub(crate) fn is_wrapped(&self) -> bool {
        self.position == Position::Wrapped
    }

    /// Between the two, or about to be.
    pub fn is_moving(&self) -> bool {
        matches!(self.position, Position::Deploying | Position::Resting | Position::Folding)
    }

    /// Standing between the two positions.
    pub fn is_between(&self) -> bool {
        self.position == Position::Between
    }

    /// §D/6 A switch has said that it is where its position says it is not.
    pub(crate) const fn is_doubted(&self) -> bool {
        self.doubted
    }

    /// Deployment was asked for and did not succeed.
    pub(crate) fn has_failed(&self) -> bool {
        self.failed
    }

    /// §3.10/3, §3.11/3 ModuleFault is the answer to Deploy (up) or Wrap.
    pub(crate) fn refuses(&self, drive: &Drive, up: bool) -> bool {
        self.internal_fault || drive.refuses(up)
    }

    /// §3.10 Deploy.
    pub(crate) fn deploy(
        &mut self,
        now: Millis,
        drives: &mut [Drive; AXES],
        params: &Params,
        by: Asked,
    ) -> Status {
        let drive = by_axis(drives, Axis::Deployer);
        if self.refuses(drive, true) {
            return Status::MODULE_FAULT;
        }
        // §3.10/2
        if self.is_deployed() {
            return Status::OK;
        }
        // §3.10/1
        if self.position == Position::Deploying {
            return Status::ACCEPTED;
        }
        drive.stop(Cause::Request(by));
        self.failed = false;
        if self.position == Position::Resting {
            by_axis(drives, Axis::Horizontal).stop(Cause::Request(by));
            by_axis(drives, Axis::Vertical).stop(Cause::Request(by));
        }
        self.cause = Cause::Program(Program::Deploy, by);
        self.begin(now, Position::Deploying, params);
        Status::ACCEPTED
    }

    /// §3.11 Wrap; that the valves are closed has been checked.
    pub(crate) fn wrap(
        &mut self,
        now: Millis,
        drives: &mut [Drive; AXES],
        params: &Params,
        by: Asked,
    ) -> Status {
        if self.refuses(by_axis(drives, Axis::Deployer), false) {
            return Status::MODULE_FAULT;
        }
        match self.position {
            // §3.11/2
            Position::Wrapped => return Status::OK,
            // §3.11/1
            Position::Resting | Position::Folding => return Status::ACCEPTED,
            // §D/7 Where its rest is, is not known.
            Position::Deployed if !can_rest(drives) => return Status::DENIED,
            Position::Deployed => self.begin(now, Position::Resting, params),
            // Nothing brings it to its rest here.
            _ if !is_straight(drives) => return Status::DENIED,
            Position::Deploying | Position::Between => self.begin(now, Position::Folding, params),
        }
        for drive in drives {
            drive.stop(Cause::Request(by));
        }
        self.cause = Cause::Program(Program::Wrap, by);
        Status::ACCEPTED
    }

    /// §3.2/2 Stays in between.
    pub(crate) fn stop(&mut self, drives: &mut [Drive; AXES], why: Cause) {
        if self.is_moving() {
            self.end(drives, why);
            self.failed = true;
        }
        by_axis(drives, Axis::Deployer).stop(why);
    }

    /// §3.1/9 Move Deployer: it is between its positions from now on.
    pub(crate) fn note_move(&mut self) {
        self.position = Position::Between;
        self.strayed = true;
        self.travel.stop();
    }

    #[inline(never)]
    pub(crate) fn step(
        &mut self,
        now: Millis,
        dt_ms: u32,
        input: &DriveInput,
        drives: &mut [Drive; AXES],
        params: &Params,
    ) {
        self.judge(dt_ms, input, by_axis(drives, Axis::Deployer), params);
        match (self.position, self.seen) {
            (Position::Deploying, Position::Deployed) | (Position::Folding, Position::Wrapped) => {
                self.arrive(self.seen, drives);
            }
            _ => self.go_on(now, drives, params),
        }
        let late = self.travel.poll(now);
        if late || self.is_hindered(drives) {
            // That the barrel comes no nearer, or is not dry, says nothing of Deployer's own drive.
            self.internal_fault |= late && self.position != Position::Resting && !self.held;
            self.failed = true;
            let why = if late { Rule::Timeout } else { Rule::ProgramEnd };
            self.end(drives, Cause::Rule(why));
        }
        let drive = by_axis(drives, Axis::Deployer);
        if !drive.is_idle() && drive.is_remote() {
            self.stale = Stale::DRIVEN;
        } else {
            self.stale.step(dt_ms);
        }
    }

    /// §D/6 Where its switches say it has arrived it has, unless its position contradicts them; or it is not known,
    /// and the barrel was driven.
    fn judge(&mut self, dt_ms: u32, input: &DriveInput, drive: &Drive, params: &Params) {
        // Of a lost unit they may be from before it was driven: then it is where nothing says.
        if drive.is_lost() && self.stale.may_be() && !self.is_moving() {
            (self.position, self.strayed) = (Position::Between, true);
        }
        let said = at_rest(input);
        let arrives = said != self.position && said != Position::Between;
        let far = drive.is_far_off(said == Position::Deployed, params);
        let differs = arrives && far == Some(true);
        self.doubted |= lasted(&mut self.differs_ms, dt_ms, differs);
        self.internal_fault |= self.doubted;
        self.strayed = match self.position {
            Position::Wrapped | Position::Deployed => false,
            Position::Deploying | Position::Folding => true,
            Position::Resting | Position::Between => self.strayed,
        };
        let denied = self.doubted || arrives && far.unwrap_or(self.strayed);
        self.seen = if denied { Position::Between } else { said };
    }

    fn go_on(&mut self, now: Millis, drives: &mut [Drive; AXES], params: &Params) {
        match self.position {
            Position::Deploying => self.drive_to(DriveParam::MaxLimit, drives, params),
            Position::Folding => {
                let held = by_axis(drives, Axis::Deployer).is_held_dry();
                // Neither is the time to wait for it that of the drive, nor the other way round; and a flow that
                // flickers gives none of them back.
                if held != core::mem::replace(&mut self.held, held) {
                    let left_ms = self.travel.left_ms(now);
                    self.travel.start(now, core::mem::replace(&mut self.left, left_ms));
                }
                self.drive_to(DriveParam::MinLimit, drives, params);
            }
            Position::Resting => self.rest(now, drives, params),
            Position::Wrapped | Position::Deployed | Position::Between => {
                if by_axis(drives, Axis::Deployer).is_idle() {
                    self.position = self.seen;
                }
            }
        }
    }

    /// §3.3 DeployerStatus: that of its drive, with the flags of deployment.
    pub(crate) fn status(&self, drive: &Drive, common: u32) -> DeployerStatus {
        use DeployerFlags as F;
        let status = drive.status();
        // Bits 16–27 are those of drives; TRVEngage and SpeedSlowAmp have no place here.
        let of_drive = status.flags - DriveFlags::SPEED_SLOW_AMP - DriveFlags::TRV_ENGAGE;
        let mut flags = F::from_bits_retain(of_drive.bits() | common);
        // The limits of this drive are its two positions, and the switches there tell them.
        if !flags.contains(F::LIMITLESS) {
            flags.set(F::MIN_LIMIT_REACHED, self.position == Position::Wrapped);
            flags.set(F::MAX_LIMIT_REACHED, self.position == Position::Deployed);
        }
        // §3.3.8/1
        flags.set(F::DEPLOYED, self.position == Position::Deployed);
        flags.set(F::DEPLOYING, self.position == Position::Deploying);
        flags.set(F::WRAPPED, self.position == Position::Wrapped);
        flags.set(F::WRAPPING, matches!(self.position, Position::Resting | Position::Folding));
        if self.internal_fault {
            flags |= F::INTERNAL_FAULT;
        }
        let lafet_proto::status::DriveStatus { position, current, speed, .. } = status;
        DeployerStatus { flags, position, current, speed }
    }

    /// A drive that is needed now cannot go: hammering on would only heat its motor.
    fn is_hindered(&self, drives: &mut [Drive; AXES]) -> bool {
        match self.position {
            _ if self.doubted => self.is_moving(),
            Position::Deploying => by_axis(drives, Axis::Deployer).refuses(true),
            Position::Folding => by_axis(drives, Axis::Deployer).refuses(false),
            Position::Resting => RESTING.iter().any(|axis| {
                let drive = by_axis(drives, *axis);
                let back = drive.position() < drive.clamp(REST_ARCMIN);
                drive.refuses(back)
            }),
            Position::Wrapped | Position::Deployed | Position::Between => false,
        }
    }

    fn begin(&mut self, now: Millis, position: Position, params: &Params) {
        self.position = position;
        let travel_ms = travel_ms(params);
        self.travel.start(now, travel_ms);
        self.left = if position == Position::Resting { u32::MAX } else { travel_ms };
        self.held = false;
    }

    fn arrive(&mut self, position: Position, drives: &mut [Drive; AXES]) {
        self.position = position;
        self.travel.stop();
        by_axis(drives, Axis::Deployer).stop(Cause::Rule(Rule::Arrived));
    }

    fn end(&mut self, drives: &mut [Drive; AXES], why: Cause) {
        if self.position == Position::Resting {
            by_axis(drives, Axis::Horizontal).stop(why);
            by_axis(drives, Axis::Vertical).stop(why);
        }
        by_axis(drives, Axis::Deployer).stop(why);
        self.position = self.seen;
        self.travel.stop();
    }

    /// The barrel goes to its rest, as long as it comes nearer: how long that takes is a matter of its own
    /// drives. Then folding begins, with the time it is given.
    fn rest(&mut self, now: Millis, drives: &mut [Drive; AXES], params: &Params) {
        let (mut there, mut far) = (true, 0_u32);
        for axis in RESTING {
            let drive = by_axis(drives, axis);
            let rest = drive.clamp(REST_ARCMIN);
            let way = drive.position().abs_diff(rest);
            far = far.saturating_add(way);
            let off = way > 1;
            if off && drive.is_idle() {
                drive.go(rest, None, self.cause);
            }
            there &= !off && drive.is_idle() && drive.knows_position();
        }
        if far < self.left {
            self.left = far;
            self.travel.start(now, PATIENCE_MS);
        }
        if there {
            self.begin(now, Position::Folding, params);
        }
    }

    fn drive_to(&self, end: DriveParam, drives: &mut [Drive; AXES], params: &Params) {
        let drive = by_axis(drives, Axis::Deployer);
        // A little beyond the limit, so that the switch there is reached for certain.
        let beyond = if end == DriveParam::MaxLimit { 60 } else { -60 };
        let target = params.drive(Axis::Deployer, end).saturating_add(beyond);
        if drive.is_idle() {
            drive.seat(target, self.cause);
        }
    }
}

fn can_rest(drives: &[Drive; AXES]) -> bool {
    RESTING.iter().all(|axis| of_axis(drives, *axis).is_homed())
}

fn travel_ms(params: &Params) -> u32 {
    params.get(Param::DeployerTravelTime).unsigned_abs()
}

/// The barrel is where it can be folded, as far as that is known.
pub(crate) fn is_straight(drives: &[Drive; AXES]) -> bool {
    RESTING.iter().all(|axis| {
        let drive = of_axis(drives, *axis);
        let off = drive.position().abs_diff(drive.clamp(REST_ARCMIN));
        drive.knows_position() && off <= NEAR_ARCMIN && !drive.is_moving()
    })
}

fn at_rest(input: &DriveInput) -> Position {
    match (input.min_switch, input.max_switch) {
        (true, false) => Position::Wrapped,
        (false, true) => Position::Deployed,
        // Both switches on contradict each other: neither is believed.
        (false, false) | (true, true) => Position::Between,
    }
}
