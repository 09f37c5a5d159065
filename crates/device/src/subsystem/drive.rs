//! §3.3.4 «Флаги состояния Vertical, Horizontal, Nozzle»: a drive; Deployer has one too (§3.3.8).
//!
//! ```text
//!           go / run                    arrived, stop, fault, overload, timeout
//!  Hold ─────────────▶ Position | Run ────────────────────────────────────────▶ Hold
//! ```

mod limits;

use crate::cause::{Asked, Cause, Rule};
use crate::composition::DriveKind;
use crate::image::{AXES, Axis, DriveInput, DriveOutput, UnitInput};
use crate::inputs::{Lasting, lasted};
use crate::params::Params;
use crate::subsystem::arrival::{Arrival, CREEP_TENTHS, Means, Order, Seen};
use crate::subsystem::homing::{HOMING_TENTHS, Homing};
use crate::subsystem::remote;
use crate::subsystem::watch::Watch;
use crate::time::{Millis, Timer};
use core::cmp::Ordering;
use lafet_proto::Status;
use lafet_proto::flags::DriveFlags;
use lafet_proto::param::{DriveParam, Param};
use lafet_proto::status::{DriveStatus, Limits};

/// §3.3.4: AmperageOverload clears this long after the drive has stopped.
const OVERLOAD_CLEAR_MS: u32 = 3000;
/// A motor draws more than its rated current while it starts: only a longer excess is overload.
const OVERLOAD_DELAY_MS: u16 = 200;
/// A drive that is not fed draws nothing. This part of MaxCurrent, and at least so much, 0.1 A, for this time, ms, is a
/// shorted stage at an end stop, where nothing turns. What it drew before has ended by then.
const UNFED_PART: i32 = 4;
const UNFED_LEAST_DA: i32 = 10;
const UNFED_MS: u16 = 800;
/// A longer step counts as so much, ms: one sample of a current is none that lasts.
const UNFED_STEP_MS: u16 = 100;
/// Where a drive wants to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Goal {
    Hold,
    Position(i32),
    /// §3.17 Without limits: up/left (true) or down/right until stopped.
    Run(bool),
}

/// Whether the monitor has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Presence {
    Sure,
    /// §3.3.1/2 It may be another monitor's that is addressed: it is not driven.
    Unsure,
    /// It is at rest, never faulty and never driven.
    Absent,
}

/// Taken while limits are off (§3.17): limits, in force after SwitchLimits On, and the zero point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Staged {
    min: Option<i32>,
    max: Option<i32>,
    /// Position, before the shift, at which the drive rests since its zero point was taken there:
    /// the same SetParam again is a repetition.
    zero: Option<i32>,
}

/// A drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    axis: Axis,
    presence: Presence,
    kind: DriveKind,
    goal: Goal,
    /// Of the motion, or of its end.
    cause: Cause,
    /// Of the speed now commanded: a new motion acts from the next step on.
    driven: Cause,
    speed_cap_tenths: Option<i32>,
    /// Speed now commanded, 1/1000 of 0.1 °/s: slow ramps need the fraction.
    speed_milli: i32,
    arrival: Arrival,
    seen: Seen,
    /// It rests farther from its last target than it may.
    missed: bool,
    input: DriveInput,
    /// For how long its sensors or its power stage have reported a fault, ms.
    fault_ms: u8,
    position: i32,
    latched: DriveFlags,
    homing: Homing,
    limitless: bool,
    staged: Staged,
    overload_ms: u16,
    overload: Timer,
    overload_up: bool,
    cut_off: bool,
    /// The guard holds it for water in the barrel.
    held_dry: bool,
    timeout: Timer,
    /// MoveHold set since the last step, for a Move in the same frame, ms.
    next_hold_ms: u32,
    /// MoveHold in force, ms.
    hold_ms: u32,
    hold: Timer,
    slowed: bool,
    /// It draws current though it is not fed.
    draws: Lasting,
    watch: Watch,
    /// It has turned, or drawn current, though it was not fed: without its supply until the reset.
    cut: bool,
    unit: remote::Link,
    online: bool,
    unit_flags: DriveFlags,
    faulty_config: bool,
    trv: bool,
    limits: Limits,
}

impl Drive {
    #[inline(never)]
    pub(crate) fn all() -> [Self; AXES] {
        [
            Self::new(Axis::Vertical),
            Self::new(Axis::Horizontal),
            Self::new(Axis::Nozzle),
            Self::new(Axis::Deployer),
        ]
    }

    #[inline(never)]
    pub(crate) fn new(axis: Axis) -> Self {
        Self {
            axis,
            presence: Presence::Sure,
            kind: DriveKind::Encoder,
            goal: Goal::Hold,
            cause: Cause::Rule(Rule::Inert),
            driven: Cause::Rule(Rule::Inert),
            speed_cap_tenths: None,
            speed_milli: 0,
            arrival: Arrival::default(),
            seen: Seen::default(),
            missed: false,
            input: DriveInput::default(),
            fault_ms: 0,
            position: 0,
            latched: DriveFlags::empty(),
            homing: Homing::default(),
            limitless: false,
            staged: Staged::default(),
            overload_ms: 0,
            overload: Timer::default(),
            overload_up: false,
            cut_off: false,
            held_dry: false,
            timeout: Timer::default(),
            next_hold_ms: 0,
            hold_ms: 0,
            hold: Timer::default(),
            slowed: false,
            draws: Lasting::default(),
            watch: Watch::default(),
            cut: false,
            unit: remote::Link::default(),
            online: true,
            unit_flags: DriveFlags::empty(),
            faulty_config: false,
            trv: false,
            limits: Limits { min: 0, max: 0 },
        }
    }

    /// Takes what memory, sensors and a remote unit say at the start.
    pub(crate) fn power_up(
        &mut self,
        params: &Params,
        input: DriveInput,
        unit: &UnitInput,
        present: bool,
    ) {
        self.limits = stored_limits(self.axis, params);
        if !present {
            self.presence = Presence::Absent;
            return;
        }
        self.kind = DriveKind::from_param(params.drive(self.axis, DriveParam::DriveType));
        self.homing = Homing::starting(self.axis, self.kind, params);
        self.input = input;
        self.position = self.sensed(params);
        self.sense(0, &input, unit, params);
    }

    /// §D/7 The inputs settle: nothing has moved.
    pub(crate) fn note_start(&mut self, input: &DriveInput) {
        self.homing.note_start(input);
    }

    /// §D/7 Its position can be relied on.
    pub(crate) const fn is_homed(&self) -> bool {
        self.homing.is_known()
    }

    /// Position, arc-minutes or mm from the zero point.
    pub fn position(&self) -> i32 {
        self.position
    }

    /// The monitor has none.
    pub(crate) const fn is_absent(&self) -> bool {
        matches!(self.presence, Presence::Absent)
    }

    /// Neither moving nor about to move.
    pub fn is_idle(&self) -> bool {
        self.goal == Goal::Hold
    }

    /// Why it moves, if it moves.
    pub fn mover(&self) -> Option<Cause> {
        (self.goal != Goal::Hold).then_some(self.cause)
    }

    /// Why its output is as it is.
    pub(crate) const fn driven(&self) -> Cause {
        self.driven
    }

    /// §3.11/1 What its sensor says of its position can be relied on.
    pub(crate) fn knows_position(&self) -> bool {
        const DOUBTS: DriveFlags = DriveFlags::POSITION_WAY_FAULT
            .union(DriveFlags::POS_ENCODER_FAULT)
            .union(DriveFlags::CONFIG_INVALID)
            .union(DriveFlags::CONN_LOST);
        self.is_absent() || self.is_homed() && !self.flags().intersects(DOUBTS)
    }

    /// Its remote unit is lost.
    pub(crate) const fn is_lost(&self) -> bool {
        !self.online
    }

    /// Connected as a remote unit.
    pub fn is_remote(&self) -> bool {
        self.kind == DriveKind::Remote
    }

    /// ModuleFault is the answer to Move (§3.1/4).
    pub fn is_faulty(&self) -> bool {
        const FAULTS: DriveFlags = DriveFlags::POSITION_WAY_FAULT
            .union(DriveFlags::POS_ENCODER_FAULT)
            .union(DriveFlags::SPEED_ENCODER_FAULT)
            .union(DriveFlags::MOTOR_BROKEN)
            .union(DriveFlags::SPEED_WAY_FAULT)
            .union(DriveFlags::INTERNAL_FAULT)
            .union(DriveFlags::CONFIG_INVALID)
            .union(DriveFlags::CONN_LOST);
        !self.is_absent() && (self.presence == Presence::Unsure || self.flags().intersects(FAULTS))
    }

    /// §3.3.4/1 It cannot go up/left (true) or down/right: after an overload the same direction is
    /// refused until the flag clears.
    pub(crate) fn refuses(&self, up: bool) -> bool {
        self.is_faulty() || self.overload.is_running() && up == self.overload_up
    }

    /// The end switch up/left (true) or down/right is closed.
    const fn is_at_end(&self, up: bool) -> bool {
        if up { self.input.max_switch } else { self.input.min_switch }
    }

    /// Limits in force; `None` while they are off (§3.17), or its position is not known (§D/7).
    pub fn limits(&self) -> Option<Limits> {
        (!self.limitless && self.is_homed()).then_some(self.limits)
    }

    /// What its sensor reads at position zero.
    pub(crate) fn reading_at_zero(&self, params: &Params) -> i32 {
        params.drive(self.axis, DriveParam::ZeroPoint).saturating_sub(self.homing.offset())
    }

    /// §3.7 The limits that are set, in force or not.
    pub(crate) const fn retrieve_limits(&self) -> Limits {
        self.limits
    }

    /// A target brought inside the limits, if there are any.
    pub fn clamp(&self, target: i32) -> i32 {
        match self.limits() {
            // What cannot be turned points where it points; of a nozzle any position may be asked for.
            _ if self.is_absent() && self.axis != Axis::Nozzle => self.position,
            Some(Limits { min, max }) => target.min(max).max(min),
            None => target,
        }
    }

    /// Goes to a target within its limits, not faster than requested.
    pub(crate) fn go(&mut self, target: i32, speed_tenths: Option<i32>, cause: Cause) {
        self.begin(Goal::Position(self.clamp(target)), speed_tenths, cause);
    }

    /// Goes to a target that may lie beyond the limits, where an end switch stops it (§3.10).
    pub(crate) fn seat(&mut self, target: i32, cause: Cause) {
        self.begin(Goal::Position(target), None, cause);
    }

    /// §3.17 Runs up/left or down/right until stopped. Beyond a limit that has been moved inward
    /// there is nowhere to go outward: the drive must not turn back instead.
    pub(crate) fn run(&mut self, up: bool, cause: Cause) {
        match self.limits() {
            Some(Limits { max, .. }) if up && self.position > max => self.stop(cause),
            Some(Limits { min, .. }) if !up && self.position < min => self.stop(cause),
            Some(Limits { min, max }) => self.go(if up { max } else { min }, None, cause),
            None => self.begin(Goal::Run(up), None, cause),
        }
    }

    /// §3.2/5 Stops at once.
    pub(crate) fn stop(&mut self, why: Cause) {
        if self.goal != Goal::Hold {
            (self.cause, self.driven) = (why, why);
        }
        self.goal = Goal::Hold;
        self.speed_milli = 0;
        self.end_times();
    }

    /// What limited the motion before concerns the next one no longer.
    fn end_times(&mut self) {
        self.timeout.stop();
        self.hold.stop();
        self.hold_ms = 0;
    }

    /// §D/4 MoveHold is set: for the Move in the same frame, or for longer. True while the drive moves
    /// under one.
    pub(crate) fn hold(&mut self, now: Millis, hold_ms: u32, timeout_ms: u32) -> bool {
        let held = self.hold.is_running();
        self.next_hold_ms = hold_ms;
        if held {
            self.hold_ms = hold_ms;
            self.hold.start(now, hold_ms);
            // It counts as the Move repeated.
            if self.timeout.is_running() {
                self.timeout.start(now, timeout_ms);
            }
        }
        held
    }

    /// Which way a Move to there leads. Deployer comes to rest at its switches, a little beyond its limits:
    /// outward of them there is nowhere to go, and it must not turn back instead (§3.1/9).
    pub(crate) fn way(&self, destination: i32) -> Ordering {
        let way = self.clamp(destination).cmp(&self.position);
        let turned = self.axis == Axis::Deployer && way != destination.cmp(&self.position);
        if turned { Ordering::Equal } else { way }
    }

    /// §3.1/4, §3.1/7, §3.1/8 Move.
    pub(crate) fn move_to(
        &mut self,
        now: Millis,
        destination: i32,
        timeout_ms: u32,
        by: Asked,
    ) -> Status {
        let (way, cause) = (self.way(destination), Cause::Request(by));
        let hold_ms = core::mem::take(&mut self.next_hold_ms);
        if self.refuses(destination > self.position) {
            return Status::MODULE_FAULT;
        }
        let runs = self.limits().is_none() && self.kind != DriveKind::Remote;
        match way {
            // Here a run would have no direction: to where it is leads no way.
            Ordering::Equal if runs || self.clamp(destination) != self.position => self.stop(cause),
            _ if runs => self.run(way.is_gt(), cause),
            _ => self.go(destination, None, cause),
        }
        if timeout_ms > 0 {
            self.timeout.start(now, timeout_ms);
        }
        if hold_ms > 0 && self.goal != Goal::Hold {
            self.hold_ms = hold_ms;
            self.hold.start(now, hold_ms);
        }
        Status::ACCEPTED
    }

    /// The internal bus to this drive's remote unit.
    pub(crate) fn unit(&mut self) -> &mut remote::Link {
        &mut self.unit
    }

    pub(crate) const fn unit_op(&self) -> Option<crate::image::UnitOp> {
        self.unit.op()
    }

    /// Senses and decides; the result is what the drive wants, the guard has the last word.
    #[inline(never)]
    pub(crate) fn step(
        &mut self,
        now: Millis,
        dt_ms: u32,
        input: &DriveInput,
        unit: &UnitInput,
        params: &Params,
    ) {
        if self.is_absent() {
            return;
        }
        // Otherwise the guard had stopped it.
        self.held_dry &= self.output().speed_tenths == 0;
        self.sense(dt_ms, input, unit, params);
        self.limits = stored_limits(self.axis, params);
        self.watch_current(now, dt_ms, params);
        // §D/4
        let over = self.timeout.poll(now) | self.hold.poll(now);
        if over && matches!(self.cause, Cause::Request(_)) {
            self.stop(Cause::Rule(Rule::Timeout));
        }
        self.next_hold_ms = 0;
        self.watch_motion(dt_ms);
        if self.is_faulty() {
            self.stop(Cause::Rule(if self.online { Rule::Fault } else { Rule::ConnLost }));
        }
        self.advance(dt_ms, params);
    }

    /// The guard has not let its output pass: it is at rest, and starts from standstill. A Move that water holds
    /// ends: it would go on when it is not expected any more.
    pub(crate) fn restrain(&mut self, why: Cause) {
        self.speed_milli = 0;
        self.arrival.begin();
        self.cut_off = matches!(why, Cause::Rule(Rule::CutOff));
        if matches!(why, Cause::Rule(Rule::Water)) {
            self.held_dry = true;
            if matches!(self.cause, Cause::Request(_)) {
                self.stop(why);
            }
        }
    }

    /// The guard holds it for water in the barrel: it has not been fed since.
    pub(crate) const fn is_held_dry(&self) -> bool {
        self.held_dry
    }

    /// What the drive wants of its motor.
    pub(crate) fn output(&self) -> DriveOutput {
        DriveOutput { speed_tenths: (self.speed_milli / 1000) as i16, cut: self.cut }
    }

    /// Flags but BadPower, which General adds.
    pub fn flags(&self) -> DriveFlags {
        let Limits { min, max } = self.limits;
        let mut flags = self.latched | self.unit_flags;
        flags.set(DriveFlags::MOVE, self.is_moving());
        flags.set(DriveFlags::AMPERAGE_OVERLOAD, self.overload.is_running());
        flags.set(DriveFlags::MOTOR_BROKEN, self.input.motor_open);
        let lost = self.input.unreferenced && !self.homing.is_used();
        if self.input.position_sensor_fault || lost {
            flags |= DriveFlags::POS_ENCODER_FAULT;
        }
        if self.input.speed_sensor_fault {
            flags |= DriveFlags::SPEED_ENCODER_FAULT;
        }
        // §D/6 It cannot be at both its ends. Of Deployer that says nothing of its drive.
        if self.input.min_switch && self.input.max_switch && self.axis != Axis::Deployer {
            flags |= DriveFlags::INTERNAL_FAULT;
        }
        let limitless = self.limits().is_none();
        flags.set(DriveFlags::LIMITLESS, limitless);
        flags.set(DriveFlags::MIN_LIMIT_REACHED, !limitless && self.position <= min);
        flags.set(DriveFlags::MAX_LIMIT_REACHED, !limitless && self.position >= max);
        flags.set(DriveFlags::ABSOLUTE_MIN_LIMIT_REACHED, self.input.min_switch);
        flags.set(DriveFlags::ABSOLUTE_MAX_LIMIT_REACHED, self.input.max_switch);
        flags.set(DriveFlags::SPEED_SLOW_AMP, self.slowed);
        flags.set(DriveFlags::TRV_ENGAGE, self.trv);
        flags.set(DriveFlags::CONFIG_INVALID, self.faulty_config);
        flags.set(DriveFlags::CONN_LOST, !self.online);
        flags
    }

    /// §3.3.4/2
    pub(crate) fn is_moving(&self) -> bool {
        self.online && (self.goal != Goal::Hold || self.input.speed_tenths.unsigned_abs() > 1)
    }

    /// §3.3 DriveStatus.
    pub(crate) fn status(&self) -> DriveStatus {
        DriveStatus {
            flags: self.flags(),
            position: self.position.clamp(-i32::from(i16::MAX), i16::MAX.into()) as i16,
            current: self.input.current_da.min(u8::MAX.into()) as u8,
            speed: (self.speed_milli.unsigned_abs().div_ceil(10_000)).min(u8::MAX.into()) as u8,
        }
    }

    /// Where there is nowhere to go, nothing begins: Move would be set without any motion.
    fn begin(&mut self, goal: Goal, speed_tenths: Option<i32>, cause: Cause) {
        let up = match goal {
            Goal::Hold => return self.stop(cause),
            Goal::Run(up) => up,
            Goal::Position(target) if target == self.position && self.rests() => {
                self.missed = false;
                return self.stop(cause);
            }
            Goal::Position(target) => target > self.position,
        };
        if self.is_absent() || self.refuses(up) || self.is_at_end(up) {
            return self.stop(cause);
        }
        self.end_times();
        self.held_dry = false;
        self.arrival.begin();
        self.missed = false;
        self.staged.zero = None;
        self.goal = goal;
        self.speed_cap_tenths = speed_tenths;
        self.cause = cause;
    }

    /// Whether it is more than a sixteenth of its whole way off its upper (true) or its lower limit, if its sensor
    /// knows.
    pub(crate) fn is_far_off(&self, upper: bool, params: &Params) -> Option<bool> {
        let Limits { min, max } = self.limits;
        let limit = if upper { max } else { min };
        let far = self.sensed(params).abs_diff(limit) > max.abs_diff(min) / 16;
        self.knows_position().then_some(far)
    }

    fn sensed(&self, params: &Params) -> i32 {
        self.input.position.saturating_sub(self.reading_at_zero(params))
    }

    #[inline(never)]
    fn sense(&mut self, dt_ms: u32, input: &DriveInput, unit: &UnitInput, params: &Params) {
        self.faulty_config = config_invalid(self.axis, params);
        self.presence = if params.is_stand_in() { Presence::Unsure } else { Presence::Sure };
        self.online = self.kind != DriveKind::Remote || unit.online;
        if self.kind == DriveKind::Remote {
            self.unit_flags = DriveFlags::from_bits_retain(self.unit.step(dt_ms, unit));
        }
        let DriveInput { position_sensor_fault, unreferenced, .. } = self.input;
        // §3.3.1/3: the last picture of a lost unit stays, but nothing in it moves.
        self.input = if self.online {
            *input
        } else {
            DriveInput { speed_tenths: 0, current_da: 0, ..self.input }
        };
        self.judge_faults(dt_ms);
        // A sensor that fails, is back, or has found or lost its place sets its position: nothing has turned.
        if self.input.position_sensor_fault != position_sensor_fault
            || self.input.unreferenced != unreferenced
        {
            self.watch.again(self.input.position);
        }
        let way = (self.goal != Goal::Hold).then(|| self.is_bound_up());
        self.homing.step(self.axis, way, &self.input, params);
        // §3.17: a direct drive that runs without limits does not count. Programs, which go to a
        // position, could not arrive without counting.
        let counting = !(self.limits().is_none()
            && self.kind == DriveKind::Encoder
            && (matches!(self.goal, Goal::Run(_)) || self.input.speed_tenths != 0)
            && !matches!(self.goal, Goal::Position(_)));
        if counting {
            self.position = self.sensed(params);
        }
        let trv = params.get(Param::NozzleTrvPosition);
        self.trv = self.axis == Axis::Nozzle && trv >= 0 && self.position <= trv;
    }

    /// §D/6 What its sensors and its power stage say of themselves counts when it has lasted: a blip must not end an
    /// extinguishing.
    fn judge_faults(&mut self, dt_ms: u32) {
        let DriveInput { motor_open, position_sensor_fault, speed_sensor_fault, .. } = self.input;
        let sensed = motor_open || position_sensor_fault || speed_sensor_fault;
        if !lasted(&mut self.fault_ms, dt_ms, sensed) {
            let input = &mut self.input;
            (input.motor_open, input.position_sensor_fault) = (false, false);
            input.speed_sensor_fault = false;
        }
    }

    /// §3.3.4 AmperageOverload and SpeedSlowAmp. What is drawn too long adds up over moments in which it is
    /// not: these take away as much, so a motor that is overloaded for more than half of its time stops.
    #[inline(never)]
    fn watch_current(&mut self, now: Millis, dt_ms: u32, params: &Params) {
        self.overload.poll(now);
        let max = params.drive(self.axis, DriveParam::MaxCurrent);
        let slow = params.drive(self.axis, DriveParam::SlowCurrent);
        let current = i32::from(self.input.current_da);
        // Cut off by the guard it draws nothing, and is overloaded all the same.
        let cut_off = core::mem::replace(&mut self.cut_off, false);
        let dt_ms = dt_ms.min(u16::MAX.into()) as u16;
        self.overload_ms = match self.goal {
            Goal::Hold => 0,
            _ if current > max || cut_off => self.overload_ms.saturating_add(dt_ms),
            _ => self.overload_ms.saturating_sub(dt_ms),
        };
        if self.overload_ms > OVERLOAD_DELAY_MS {
            self.overload_up = self.is_bound_up();
            // The other direction is free at once: its current is judged again.
            self.overload_ms = 0;
            self.stop(Cause::Rule(Rule::Overload));
            self.overload.start(now, OVERLOAD_CLEAR_MS);
        }
        // Hysteresis of an eighth: a speed that falls with the current must not rise at once.
        let threshold = if self.slowed { slow - slow / 8 } else { slow };
        self.slowed = slow > 0 && self.goal != Goal::Hold && current > threshold;
        let unfed = self.goal == Goal::Hold;
        let draws = unfed && current >= (max / UNFED_PART).max(UNFED_LEAST_DA);
        self.draws.step(dt_ms.min(UNFED_STEP_MS).into(), draws, UNFED_MS);
        if self.draws.holds {
            self.latched |= DriveFlags::INTERNAL_FAULT;
            self.cut = true;
        }
    }

    /// §3.3.4 Does it do what it is driven to, and nothing when it is not fed? An overload is judged by its
    /// current alone, of a lost unit nothing is known, and one that is fed more is judged again.
    fn watch_motion(&mut self, dt_ms: u32) {
        if self.overload_ms > 0 || !self.online {
            self.watch = Watch::default();
            return;
        }
        if self.arrival.is_kicked() {
            self.watch.again(self.input.position);
        }
        let (speed_tenths, per_tenth) =
            (self.output().speed_tenths, self.way_per_tenth().cast_signed());
        self.latched |= self.watch.step(dt_ms, speed_tenths, per_tenth, &self.input);
        self.cut |= self.watch.is_away();
    }

    /// It turns, or is to turn, up/left: held by the guard, it has no speed.
    const fn is_bound_up(&self) -> bool {
        match self.goal {
            _ if self.speed_milli != 0 => self.speed_milli > 0,
            Goal::Hold => false,
            Goal::Run(up) => up,
            Goal::Position(target) => target > self.position,
        }
    }

    /// Tenths of a milli-unit of position that a speed of one tenth makes in a millisecond.
    const fn way_per_tenth(&self) -> u32 {
        match self.axis {
            Axis::Nozzle => 1,
            Axis::Vertical | Axis::Horizontal | Axis::Deployer => 60,
        }
    }

    /// Neither fed nor turning.
    const fn rests(&self) -> bool {
        self.speed_milli == 0 && self.input.speed_tenths.unsigned_abs() <= 1
    }

    /// It rests farther from its last target than it may: it could not come nearer.
    pub(crate) const fn has_missed(&self) -> bool {
        self.missed
    }

    /// The speed of this step: a ramp up, and a ramp down that ends at the target.
    #[inline(never)]
    fn advance(&mut self, dt_ms: u32, params: &Params) {
        let (position, sensed) = (self.position, self.input.speed_tenths);
        self.arrival.sense(dt_ms, sensed);
        self.seen.step(dt_ms, self.speed_milli != 0, position, sensed, self.way_per_tenth());
        let order = match self.order(dt_ms, params) {
            Ok(order) => order,
            Err(end) => return self.stop(Cause::Rule(end)),
        };
        self.driven = self.cause;
        self.speed_milli = match order {
            Order::Pulse(speed) => speed,
            Order::Ramp(speed) => self.ramp(speed, dt_ms, params),
            Order::Arrived => {
                self.missed = self.arrival.has_given_up();
                self.seen.arrived(&self.arrival, &self.means(params));
                return self.stop(Cause::Rule(Rule::Arrived));
            }
        };
    }

    /// What the goal asks of the motor, or the rule that ends the motion.
    fn order(&mut self, dt_ms: u32, params: &Params) -> Result<Order, Rule> {
        let (way, up) = match self.goal {
            Goal::Hold => return Err(Rule::Arrived),
            Goal::Run(up) => (0, up),
            Goal::Position(target) => {
                (target.saturating_sub(self.position), target > self.position)
            }
        };
        if self.is_at_end(up) {
            return Err(Rule::EndSwitch);
        }
        let means = self.means(params);
        if let Goal::Run(up) = self.goal {
            let speed = means.cap.max(CREEP_TENTHS).cast_signed() * 1000;
            return Ok(Order::Ramp(if up { speed } else { -speed }));
        }
        let seen = (self.speed_milli, self.input.speed_tenths);
        Ok(self.arrival.step(dt_ms, (self.position, way), seen, &means))
    }

    fn means(&self, params: &Params) -> Means {
        let of = |param| params.drive(self.axis, param).unsigned_abs();
        let set = of(DriveParam::Speed).saturating_mul(10);
        let cap = self.speed_cap_tenths.map_or(set, |cap| set.min(cap.unsigned_abs()));
        let cap = if self.is_homed() { cap } else { cap.min(HOMING_TENTHS.unsigned_abs()) };
        Means {
            cap: if self.slowed { cap / 2 } else { cap },
            acceleration: self.acceleration(params),
            lag_ms: of(DriveParam::StopLag),
            // What it needs to turn at all must not make it faster than it is set to.
            least: of(DriveParam::MinSpeed).min(set),
            nozzle: self.axis == Axis::Nozzle,
        }
    }

    /// Braking is not limited: the approach is already slow enough, and a stop is a stop.
    fn ramp(&self, wanted: i32, dt_ms: u32, params: &Params) -> i32 {
        let change = self.acceleration(params).saturating_mul(dt_ms).clamp(1, 1_000_000_000);
        let (change, speed) = (change.cast_signed(), self.speed_milli);
        if wanted == 0 || wanted.signum() == speed.signum() && wanted.abs() < speed.abs() {
            wanted
        } else {
            wanted.max(speed.saturating_sub(change)).min(speed.saturating_add(change))
        }
    }

    /// 0.1 °/s² or 0.1 mm/s².
    fn acceleration(&self, params: &Params) -> u32 {
        params.drive(self.axis, DriveParam::Acceleration).unsigned_abs().saturating_mul(10)
    }
}

/// §3.3.1/2 Values are checked one by one; limits that contradict each other show here.
fn config_invalid(axis: Axis, params: &Params) -> bool {
    let Limits { min, max } = stored_limits(axis, params);
    params.is_incomplete(axis.id()) || min >= max
}

fn stored_limits(axis: Axis, params: &Params) -> Limits {
    Limits {
        min: params.drive(axis, DriveParam::MinLimit),
        max: params.drive(axis, DriveParam::MaxLimit),
    }
}
