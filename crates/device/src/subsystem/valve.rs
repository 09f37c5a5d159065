//! §3.3.5 «Флаги состояния Valve1, Valve2»: a valve.
//!
//! ```text
//!  Still ──Open──▶ Opening ──open switch, Stop, block, fault, time over──▶ Still
//!  Still ──Close─▶ Closing ──closed switch, Stop, fault, time over─▶ Still
//! ```
//! No motor is fed without end: what is repeated, after an overload too, is one attempt with one TravelTime, and
//! a valve that could not be closed in it rests for as long before it is driven that way again; one that was
//! overloaded while it opened is not opened before AmperageOverload clears. What is to close is owed until it has,
//! or a request says something else: a unit that comes back, or a block that goes, gives it one more attempt at once,
//! and from then on one behind each rest.
//!
//! What prevents water hammer is the travel itself: the motor knows three commands, and no request,
//! fault or reset makes the plug go faster than its gear does.

use crate::cause::{Cause, Rule};
use crate::guard::SETTLE_MS;
use crate::image::{UnitInput, UnitOp, VALVES, ValveInput, ValveNo, ValveOutput};
use crate::inputs::Stale;
use crate::params::Params;
use crate::subsystem::remote;
use crate::time::{Millis, Timer};
use lafet_proto::flags::ValveFlags;
use lafet_proto::param::{Param, ValveParam};
use lafet_proto::status::ValveStatus;
use lafet_proto::{Status, SubsystemId};

/// AmperageOverload clears this long after the stop, as that of drives does (§3.3.4).
const OVERLOAD_CLEAR_MS: u32 = 3000;
/// Starting current is no overload.
const OVERLOAD_DELAY_MS: u16 = 300;
/// Part of TravelTime within which a driven valve has to leave the switch where it is.
const LEAVING_PART: u32 = 15;
/// Least time for it: motors start, units answer late.
const LEAVING_MIN_MS: u32 = 400;

/// A valve is at its open switch if that has counted at any moment of so long, ms: whatever blips in it.
const KEPT_MS: u8 = 200;
const _: () = assert!(KEPT_MS as u32 == 2 * SETTLE_MS);

/// With any of these it is faulty.
const FAULTS: ValveFlags = ValveFlags::OPEN_SENSOR_FAULT
    .union(ValveFlags::CLOSE_SENSOR_FAULT)
    .union(ValveFlags::INTERNAL_FAULT)
    .union(ValveFlags::CONFIG_INVALID)
    .union(ValveFlags::CONN_LOST);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Still,
    Opening,
    Closing,
}

/// What a unit that is back, or a block that is gone, gives a closing: all its time again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Chance {
    /// It has not had it since it has rested or closed.
    Left,
    Taken,
    /// It has had it, and would have another one: when it has rested.
    Due,
}

/// A valve.
#[derive(Clone, Debug, PartialEq)]
pub struct Valve {
    no: ValveNo,
    remote: bool,
    motion: Motion,
    /// Of the motion, or of its end.
    cause: Cause,
    travel: Timer,
    /// The way for which `travel` runs, also between two attempts that were overloaded.
    tried: Motion,
    /// A request, not a rule, is its cause.
    asked: bool,
    /// Why it is to close, until it has or a request says something else: no client repeats that.
    owed: Option<Cause>,
    /// It could not be closed: it rests.
    rest: Timer,
    /// Its time for closing was over, and no Close has come since.
    spent: bool,
    /// A lockout has come while it rested: it closes when it has.
    due: bool,
    chance: Chance,
    /// Since its open switch counted last, ms.
    apart_ms: u8,
    /// Of a remote unit, since it was opening.
    stale: Stale,
    /// Runs while the valve is driven away from the end where it is; of one at rest, after an opening in vain, or
    /// until its contacts say whether it is kept open.
    leaving: Timer,
    input: ValveInput,
    /// Water flows though its switch says closed.
    doubted: bool,
    latched: ValveFlags,
    /// What is latched was found while it opened.
    opened_in_vain: bool,
    overload_ms: u16,
    overload: Timer,
    /// It was opening.
    overload_opening: bool,
    /// §D/8 Runs while it is not closed and no client confirms its water.
    water: Timer,
    /// It was closed for that, and no client has confirmed since.
    unconfirmed: bool,
    unit: remote::Link,
    unit_flags: ValveFlags,
    online: bool,
    faulty_config: bool,
    /// §3.3.1/2 It may be another monitor's that is addressed.
    unsure: bool,
}

impl Valve {
    /// §D/1, §D/2 A valve starts by closing unless it is set to stay.
    #[inline(never)]
    pub(crate) fn both() -> [Self; VALVES] {
        [Self::new(ValveNo::Valve1), Self::new(ValveNo::Valve2)]
    }

    #[inline(never)]
    fn new(no: ValveNo) -> Self {
        Self {
            no,
            remote: false,
            motion: Motion::Still,
            cause: Cause::Rule(Rule::Inert),
            travel: Timer::default(),
            tried: Motion::Still,
            asked: false,
            owed: None,
            rest: Timer::default(),
            spent: false,
            due: false,
            chance: Chance::Left,
            apart_ms: u8::MAX,
            stale: Stale::default(),
            leaving: Timer::default(),
            input: ValveInput::default(),
            doubted: false,
            latched: ValveFlags::empty(),
            opened_in_vain: false,
            overload_ms: 0,
            overload: Timer::default(),
            overload_opening: false,
            water: Timer::default(),
            unconfirmed: false,
            unit: remote::Link::default(),
            unit_flags: ValveFlags::empty(),
            online: true,
            faulty_config: false,
            unsure: false,
        }
    }

    /// §D/2 Closes at the start, unless it is open and to be kept so, which its contacts have the time for that sensors
    /// take to settle, twice, to say: half-way it was on its way, and of a lost unit that is known when it is back.
    pub(crate) fn power_up(
        &mut self,
        now: Millis,
        params: &Params,
        (input, unit): (&ValveInput, &UnitInput),
        keep: bool,
    ) {
        self.remote = param(self.no, ValveParam::ValveType, params) == 1;
        self.sense(0, input, unit, params);
        if keep {
            self.owed = Some(Cause::Rule(Rule::PowerUp));
            self.leaving.start(now, KEPT_MS.into());
        } else {
            self.start(now, Motion::Closing, params, Cause::Rule(Rule::PowerUp));
        }
    }

    /// §D/2 Of a valve that may be kept open its contacts are judged.
    fn judge_kept(&mut self, now: Millis, params: &Params) {
        if self.owed != Some(Cause::Rule(Rule::PowerUp)) || !self.online {
            return;
        }
        if self.apart_ms < KEPT_MS {
            self.owed = None;
        } else {
            self.start(now, Motion::Closing, params, Cause::Rule(Rule::PowerUp));
        }
    }

    /// A remote unit.
    pub fn is_remote(&self) -> bool {
        self.remote
    }

    /// Closed by its switch and not leaving.
    pub fn is_closed(&self) -> bool {
        self.flags().contains(ValveFlags::CLOSED) && self.motion != Motion::Opening
    }

    /// §3.8/3 Open; its key has been checked.
    pub(crate) fn open(&mut self, now: Millis, params: &Params, cause: Cause) -> Status {
        self.confirm();
        if self.hinders_opening() || self.overload.is_running() && self.overload_opening {
            return Status::MODULE_FAULT;
        }
        // §3.3.5 Blocked is a state of the valve, not a fault of it.
        if self.input.blocked {
            return Status::DENIED;
        }
        self.start(now, Motion::Opening, params, cause);
        Status::ACCEPTED
    }

    /// §3.9/2 Close; its key has been checked. Every valve is driven to close; ModuleFault is the
    /// answer of one that cannot be driven (§3.3.5/1: a faulty sensor does not hinder), or has been in vain
    /// and rests.
    pub(crate) fn close(&mut self, now: Millis, params: &Params, cause: Cause) -> Status {
        let rests = self.rests();
        let driven = self.online && !self.overload.is_running() && !rests;
        if rests {
            self.owed = Some(cause);
        } else {
            self.start(now, Motion::Closing, params, cause);
        }
        if driven { Status::ACCEPTED } else { Status::MODULE_FAULT }
    }

    /// §D/8 A client confirms its water: the time starts again.
    pub(crate) const fn confirm(&mut self) {
        self.water = Timer::STOPPED;
        self.unconfirmed = false;
        if matches!(self.owed, Some(Cause::Rule(Rule::Unconfirmed))) {
            self.owed = None;
        }
    }

    /// §D/8 It was closed because no client did.
    pub(crate) const fn is_unconfirmed(&self) -> bool {
        self.unconfirmed
    }

    /// It is open, was closed in vain, and is not driven now.
    pub(crate) fn rests(&self) -> bool {
        self.rest.is_running() && !self.is_at(Motion::Closing)
    }

    /// §3.18/1 Locked out while it rests, it closes when it has.
    pub(crate) fn note_lockout(&mut self) {
        self.due = self.rests();
    }

    /// §3.18/1 Locked out it is closed again, should it leave its switch, and driven on through an overload, as
    /// the guard does: keeping the water off is more important than the motor.
    pub(crate) fn keep_closed(&mut self, now: Millis, params: &Params) {
        let waits = self.spent && (!self.due || self.rests());
        if self.motion == Motion::Still && !waits && !self.is_at(Motion::Closing) {
            self.start(now, Motion::Closing, params, Cause::Rule(Rule::Lockout));
        }
    }

    /// It was driven towards closed for all its time and has not got there: the lockout does not drive it
    /// on. The flags say why.
    pub(crate) const fn is_spent(&self) -> bool {
        self.spent
    }

    /// §3.2/5 Stays where it is.
    pub(crate) fn stop(&mut self, why: Cause) {
        if self.motion != Motion::Still {
            self.cause = why;
            self.leaving.stop();
        }
        let goes_on = self.motion == Motion::Closing && why == Cause::Rule(Rule::Overload);
        self.motion = Motion::Still;
        if !matches!(why, Cause::Rule(_)) {
            self.owed = None;
        }
        if !goes_on {
            self.end_attempt();
        }
    }

    fn end_attempt(&mut self) {
        self.travel.stop();
        self.tried = Motion::Still;
        self.asked = false;
    }

    pub(crate) fn unit(&mut self) -> &mut remote::Link {
        &mut self.unit
    }

    pub(crate) const fn unit_op(&self) -> Option<UnitOp> {
        self.unit.op()
    }

    #[inline(never)]
    pub(crate) fn step(
        &mut self,
        now: Millis,
        dt_ms: u32,
        input: &ValveInput,
        unit: &UnitInput,
        params: &Params,
    ) {
        let freed = unit.online && !self.online || self.input.blocked && !input.blocked;
        self.sense(dt_ms, input, unit, params);
        if self.input.blocked {
            self.end_opening(Cause::Rule(Rule::Blocked));
        }
        if !self.online {
            self.end_opening(Cause::Rule(Rule::ConnLost));
        }
        if self.is_at(Motion::Closing) {
            self.rest.stop();
            (self.spent, self.chance, self.owed) = (false, Chance::Left, None);
        }
        if freed {
            self.give_chance(now, params);
        }
        self.end_rest(now, params);
        self.watch_current(now, dt_ms, params);
        self.take_up(now, params);
        self.watch_leaving(now, params);
        self.watch_travel(now, params);
        self.watch_water(now, params);
    }

    #[inline(never)]
    fn sense(&mut self, dt_ms: u32, input: &ValveInput, unit: &UnitInput, params: &Params) {
        self.faulty_config = params.is_incomplete(self.no.id());
        self.unsure = params.is_stand_in();
        self.online = !self.remote || unit.online;
        if self.remote {
            self.unit_flags = ValveFlags::from_bits_retain(self.unit.step(dt_ms, unit));
        }
        if self.online {
            self.input = *input;
        }
        if self.remote {
            self.doubt_closed(dt_ms);
        }
        let dt_ms = dt_ms.min(u8::MAX.into()) as u8;
        let open = self.is_at(Motion::Opening);
        self.apart_ms = if open { 0 } else { self.apart_ms.saturating_add(dt_ms) };
    }

    /// §D/6 It may have been opened since it was seen closed; and what has reached a lost unit is not known.
    fn doubt_closed(&mut self, dt_ms: u32) {
        let opens = self.motion == Motion::Opening;
        if self.stale.may_be() && !(self.online && opens) {
            self.input.close_switch = false;
        }
        if !opens {
            self.stale.step(dt_ms);
        }
    }

    /// §D/6 Whether water flows through valves that all say closed: then its switch is reported as faulty,
    /// and not judged as such: where the meter lies, the valve has to open all the same.
    pub(crate) const fn doubt(&mut self, doubted: bool) {
        self.doubted = doubted;
    }

    /// What forbids Open also ends it: an opening that waits behind a block, for the working position, or for a
    /// unit that is lost, would come by itself when it is not expected any more.
    pub(crate) fn end_opening(&mut self, why: Cause) {
        if self.motion == Motion::Opening {
            self.stop(why);
        }
    }

    pub(crate) fn output(&self) -> ValveOutput {
        match self.motion {
            Motion::Still => ValveOutput::Off,
            Motion::Opening => ValveOutput::Opening,
            Motion::Closing => ValveOutput::Closing,
        }
    }

    /// Why it moves, or why it has stopped.
    pub(crate) const fn cause(&self) -> Cause {
        self.cause
    }

    /// Flags but BadPower, which General adds.
    pub fn flags(&self) -> ValveFlags {
        let doubt = if self.doubted { ValveFlags::CLOSE_SENSOR_FAULT } else { ValveFlags::empty() };
        self.own_flags() | doubt
    }

    fn own_flags(&self) -> ValveFlags {
        self.latched | self.present_flags()
    }

    /// Those that show now, whatever an attempt has found.
    fn present_flags(&self) -> ValveFlags {
        let input = &self.input;
        let both = input.open_switch && input.close_switch;
        let mut flags = self.unit_flags;
        flags.set(ValveFlags::OPENING, self.motion == Motion::Opening);
        flags.set(ValveFlags::CLOSING, self.motion == Motion::Closing);
        flags.set(ValveFlags::AMPERAGE_OVERLOAD, self.overload.is_running());
        flags.set(ValveFlags::BLOCKED, input.blocked);
        if input.open_sensor_fault || both {
            flags |= ValveFlags::OPEN_SENSOR_FAULT;
        }
        if input.close_sensor_fault || both {
            flags |= ValveFlags::CLOSE_SENSOR_FAULT;
        }
        flags.set(ValveFlags::OPEN, self.is_at(Motion::Opening));
        flags.set(ValveFlags::CLOSED, self.is_at(Motion::Closing));
        flags.set(ValveFlags::CONFIG_INVALID, self.faulty_config);
        flags.set(ValveFlags::CONN_LOST, !self.online);
        flags
    }

    /// It is to close and may still be at its open switch; ends with its time for closing.
    pub(crate) fn leaves_open(&self) -> bool {
        self.is_being_closed() && self.apart_ms < KEPT_MS
    }

    fn is_being_closed(&self) -> bool {
        self.tried == Motion::Closing && self.travel.is_running()
    }

    /// §3.3 ValveStatus.
    pub(crate) fn status(&self) -> ValveStatus {
        ValveStatus { flags: self.flags() }
    }

    /// Something is wrong with it.
    pub fn is_faulty(&self) -> bool {
        self.unsure || self.own_flags().intersects(FAULTS)
    }

    /// ModuleFault is the answer to Open (§3.8/3). What an opening has found is tried again once it has rested.
    fn hinders_opening(&self) -> bool {
        let again = self.opened_in_vain && !self.leaving.is_running();
        let flags = if again { self.present_flags() } else { self.own_flags() };
        self.unsure || flags.intersects(FAULTS)
    }

    fn opens_in_vain(&mut self, now: Millis, params: &Params) {
        self.opened_in_vain = true;
        self.leaving.start(now, self.limit_ms(params));
    }

    fn start(&mut self, now: Millis, motion: Motion, params: &Params, cause: Cause) {
        // What it drew on the way back says nothing about the way ahead; but a repeated request
        // must not put off the judgement.
        if self.motion != motion {
            self.overload_ms = 0;
            self.leaving.stop();
        }
        if self.tried != motion {
            self.travel.stop();
            self.tried = motion;
        }
        self.travel.hasten(now, self.limit_ms(params));
        self.motion = motion;
        self.cause = cause;
        self.latched = ValveFlags::empty();
        self.opened_in_vain = false;
        (self.spent, self.due) = (false, false);
        self.asked |= !matches!(cause, Cause::Rule(_));
        match (motion, cause) {
            // It is owed for what had come before.
            (Motion::Closing, Cause::Rule(Rule::Lockout)) => {}
            (Motion::Closing, _) => self.owed = Some(cause),
            _ => {
                (self.owed, self.chance) = (None, Chance::Left);
                if self.remote {
                    self.stale = Stale::DRIVEN;
                }
            }
        }
    }

    /// Its unit is back, or its block is gone: what was in vain meanwhile says nothing of the motor. A closing that runs
    /// has all its time again, and what is owed is closed now; once until it has rested, for a unit may come and go.
    fn give_chance(&mut self, now: Millis, params: &Params) {
        let runs = self.is_being_closed();
        if runs || self.spent {
            match self.chance {
                Chance::Left => self.chance = Chance::Taken,
                Chance::Taken | Chance::Due if runs => return,
                Chance::Taken | Chance::Due => return self.chance = Chance::Due,
            }
            self.rest.stop();
            self.spent = false;
        }
        let keeps = params.get(Param::GeneralResetValves) != 0;
        match self.owed {
            _ if runs => self.travel.start(now, self.limit_ms(params)),
            _ if self.motion != Motion::Still => {}
            Some(Cause::Rule(Rule::PowerUp)) if keeps => self.leaving.start(now, KEPT_MS.into()),
            Some(cause) => self.start(now, Motion::Closing, params, cause),
            None => {}
        }
    }

    /// It has rested: a chance that has come meanwhile is taken.
    fn end_rest(&mut self, now: Millis, params: &Params) {
        if self.rest.poll(now) {
            let due = core::mem::replace(&mut self.chance, Chance::Left) == Chance::Due;
            self.spent &= !due;
            if due
                && self.motion == Motion::Still
                && let Some(cause) = self.owed
            {
                self.start(now, Motion::Closing, params, cause);
            }
        }
    }

    /// What a rule closes goes on after an overload, in the time that it has: ice or grit must not leave it open
    /// with no client there to repeat a Close.
    fn take_up(&mut self, now: Millis, params: &Params) {
        if let Some(cause @ Cause::Rule(_)) = self.owed
            && self.is_being_closed()
            && self.motion == Motion::Still
            && !self.overload.is_running()
        {
            self.start(now, Motion::Closing, params, cause);
        }
    }

    /// A valve in the cold is slower than its nameplate: half as much again is allowed, ms.
    fn limit_ms(&self, params: &Params) -> u32 {
        let travel_ms = param(self.no, ValveParam::TravelTime, params).unsigned_abs();
        travel_ms.saturating_add(travel_ms / 2)
    }

    fn watch_current(&mut self, now: Millis, dt_ms: u32, params: &Params) {
        self.overload.poll(now);
        let max = param(self.no, ValveParam::MaxCurrent, params);
        // As that of drives: moments without it take away as much as they last.
        let dt_ms = dt_ms.min(u16::MAX.into()) as u16;
        self.overload_ms = match self.motion {
            Motion::Still => 0,
            _ if i32::from(self.input.current_da) > max => self.overload_ms.saturating_add(dt_ms),
            _ => self.overload_ms.saturating_sub(dt_ms),
        };
        if self.overload_ms > OVERLOAD_DELAY_MS {
            self.overload_opening = self.motion == Motion::Opening;
            self.stop(Cause::Rule(Rule::Overload));
            self.overload.start(now, OVERLOAD_CLEAR_MS);
        }
    }

    /// §D/8 Closes what no client wants open any more; once, when that is in vain (§3.3.5).
    fn watch_water(&mut self, now: Millis, params: &Params) {
        let limit_s = params.get(Param::GeneralWaterTimeout).unsigned_abs();
        if limit_s == 0 || self.is_at(Motion::Closing) && self.motion != Motion::Opening {
            self.water.stop();
        } else if self.water.poll(now) && self.motion != Motion::Closing && !self.spent {
            self.unconfirmed = true;
            self.start(now, Motion::Closing, params, Cause::Rule(Rule::Unconfirmed));
        } else {
            self.water.hasten(now, limit_s.saturating_mul(1000));
        }
    }

    /// Whether it is where this motion leads, by a switch that can be believed: one whose circuit
    /// is sound, and not both at a time.
    fn is_at(&self, motion: Motion) -> bool {
        let ValveInput { open_switch, close_switch, .. } = self.input;
        match motion {
            Motion::Still => false,
            Motion::Opening => open_switch && !close_switch && !self.input.open_sensor_fault,
            Motion::Closing => close_switch && !open_switch && !self.input.close_sensor_fault,
        }
    }

    /// A valve that does not even leave the switch where it is is not driven: its motor, fuse or
    /// gear is broken. Opening ends here; closing, the safe direction, is tried to the end.
    fn watch_leaving(&mut self, now: Millis, params: &Params) {
        let from = match self.motion {
            Motion::Still => {
                if self.leaving.poll(now) {
                    self.judge_kept(now, params);
                }
                return;
            }
            Motion::Opening => Motion::Closing,
            Motion::Closing => Motion::Opening,
        };
        if !self.is_at(from) || self.input.blocked || !self.online {
            self.leaving.stop();
        } else if self.leaving.poll(now) {
            if self.motion == Motion::Opening {
                self.stop(Cause::Rule(Rule::Fault));
                self.opens_in_vain(now, params);
            }
            self.latched |= ValveFlags::INTERNAL_FAULT;
        } else if !self.leaving.is_running() && self.latched.is_empty() {
            let travel_ms = param(self.no, ValveParam::TravelTime, params).unsigned_abs();
            self.leaving.start(now, (travel_ms / LEAVING_PART).max(LEAVING_MIN_MS));
        }
    }

    /// Ends the motion at its switch, or reports what is wrong when the time is over.
    fn watch_travel(&mut self, now: Millis, params: &Params) {
        let ValveInput { open_switch, close_switch, .. } = self.input;
        let (way, over) = (self.tried, self.travel.poll(now));
        if self.motion != Motion::Still && self.is_at(self.motion) {
            return self.stop(Cause::Rule(Rule::Arrived));
        }
        // Overloaded at its end, it is where it was to go.
        if self.motion == Motion::Still && self.is_at(way) {
            return self.end_attempt();
        }
        if !over {
            return;
        }
        let asked = self.asked;
        self.stop(Cause::Rule(Rule::Timeout));
        let (left, fault) = match way {
            Motion::Opening => (!close_switch, ValveFlags::OPEN_SENSOR_FAULT),
            Motion::Closing | Motion::Still => (!open_switch, ValveFlags::CLOSE_SENSOR_FAULT),
        };
        // It has left the one end and not shown at the other: the sensor there; otherwise the valve itself
        // has not moved.
        self.latched |= if left { fault } else { ValveFlags::INTERNAL_FAULT };
        if way == Motion::Opening {
            self.opens_in_vain(now, params);
        }
        if way == Motion::Closing {
            self.spent = true;
            // The first Close after a power-up that could not close it is not a repetition.
            if asked || self.chance != Chance::Left {
                self.rest.start(now, self.limit_ms(params));
            }
        }
    }
}

fn param(no: ValveNo, which: ValveParam, params: &Params) -> i32 {
    Param::of_valve(no.id(), which).map_or(0, |param| params.get(param))
}

/// Whether Wrap and Move Deployer must be refused by this valve (§3.11/6).
pub(crate) fn forbids_folding(valve: &Valve, present: bool) -> Option<SubsystemId> {
    (present && !valve.is_closed()).then_some(valve.no.id())
}
