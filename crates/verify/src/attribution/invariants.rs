//! What must never be, whatever the cause: the rules of [`crate::interlock`] in the true world, and what the
//! monitor has to report.
//!
//! Allowances, and why there are any. A switch or an encoder that lies ([`Fault`]s `min-switch`,
//! `max-switch` of the deployer, `encoder-…` of a drive) cannot be seen through, so what depends on
//! it is not judged while it lies, nor for the step in which it is right again. A remote unit
//! is seen through its bus, which is polled every 20 ms and counts as online until it has been silent, or has not been
//! understood, for 100 ms: what is known of it may be [`REMOTE_LAG_MS`] old. A noisy encoder is off by what the noise
//! is at most. A contact is believed when it has lasted
//! (§D/6): [`CONTACT_LAG_MS`], [`SHAKEN_LAG_MS`]. Everything else is judged in the very
//! step in which it is sensed: the program acts on no older inputs.

use lafet_device::guard::SETTLE_MS;
use lafet_device::image::{AXES, Axis, VALVES, ValveNo};
use lafet_proto::SubsystemId;
use lafet_proto::flags::{DriveFlags, GeneralFlags, ValveFlags};
use lafet_proto::param::{DriveParam, Param, ValveParam};
use lafet_sim::fault::{DriveFault, Fault, ValveFault, noise_counts, valve_name};
use lafet_sim::world::STEP_MS;

use super::jumps::Jumps;
use super::ledger::{Ledger, Lock};
use super::{View, Violation};
use crate::interlock::{Broken, Drive, Moment, Travel, Valve};

/// Allowance of the guard beyond a limit, and what the encoder rounds off, arc-minutes or mm.
const LIMIT_ALLOWANCE: f64 = 2.5;
/// How old what is sensed of a remote unit may be: as long as it counts as online, and a poll.
const REMOTE_LAG_MS: u64 = 120;
/// §D/6 From this flow on water flows, l/s.
const FLOWING_LPS: u16 = 2;
/// §D/6 Water that flows though every valve says closed is reported when it has lasted for three seconds; their
/// contacts are believed a little later.
const UNASKED_MS: u64 = 3_100;
/// §3.3.4 A drive that turns though it is not fed is reported within a second, and a step.
const UNFED_MS: u64 = 1_010;
/// What turns slower than this may run out, 1/s: 1 ° or 1 mm, arc-minutes or mm.
const UNFED_SPEED: f64 = 60.0;
const UNFED_SPEED_NOZZLE: f64 = 1.0;
/// How much later a contact is believed: 30 ms, and a step.
const CONTACT_LAG_MS: u64 = 40;
/// How much later one that bounces and blips is: a bounce and a blip, each waited for.
const SHAKEN_LAG_MS: u64 = 130;

#[derive(Clone, Debug, Default)]
pub struct Invariants {
    lie_until_ms: [u64; AXES],
    /// Until then a position may be one that was noisy.
    noisy_until_ms: [u64; AXES],
    /// For how long water has been sensed to flow though every valve was sensed as closed.
    unasked_ms: u64,
    /// For how long each drive has turned without being fed.
    unfed_ms: [u64; AXES],
    jumps: Jumps,
    folded_ms: u64,
    wet_ms: [u64; VALVES],
    /// Valves that have opened by themselves and are not closed yet.
    opened: [bool; VALVES],
    /// Water got in while the monitor could not know.
    excused: bool,
    /// One report of each kind until it ends.
    reported: Vec<&'static str>,
}

impl Invariants {
    pub fn check(&mut self, ledger: &Ledger, view: &View<'_>, found: &mut Vec<Violation>) {
        self.follow(view);
        self.jumps.follow(ledger, view);
        let rules = self.moment(ledger, view).judge();
        let mut broken: Vec<(&'static str, String)> =
            rules.iter().map(|rule| (kind(*rule), rule.to_string())).collect();
        broken.extend(lockout_reported(ledger, view).map(|text| ("reported", text)));
        broken.extend(self.unasked(ledger, view).map(|text| ("unasked", text)));
        broken.extend(self.unfed(ledger, view).map(|text| ("unfed", text)));
        broken.extend(ledger.units.judge(view).map(|text| ("unit", text)));
        broken.extend(self.jumps.judge(view).map(|text| ("jump", text)));
        self.reported.retain(|kind| broken.iter().any(|(other, _)| other == kind));
        for (kind, text) in broken {
            if !self.reported.contains(&kind) {
                self.reported.push(kind);
                found.push(Violation { at_ms: view.now_ms, unexplained: false, text });
            }
        }
    }

    fn follow(&mut self, view: &View<'_>) {
        for fault in view.faults {
            let Fault::Drive(axis, fault) = fault else { continue };
            if *fault == DriveFault::EncoderNoise {
                self.noisy_until_ms[*axis as usize] = view.now_ms + STEP_MS + lag_ms(view, *axis);
            }
            let lies = match axis {
                // A runaway leaves the working position by itself, whatever is driven.
                Axis::Deployer => matches!(
                    fault,
                    DriveFault::MinSwitch | DriveFault::MaxSwitch | DriveFault::Runaway
                ),
                _ => matches!(
                    fault,
                    DriveFault::EncoderDead
                        | DriveFault::EncoderReversed
                        | DriveFault::EncoderFast
                        | DriveFault::EncoderJump
                        | DriveFault::EncoderFault
                ),
            };
            if lies {
                let lag_ms = match axis {
                    Axis::Deployer => position_lag_ms(view),
                    _ => lag_ms(view, *axis),
                };
                self.lie_until_ms[*axis as usize] = view.now_ms + STEP_MS + lag_ms;
            }
        }
        // What is less than the meter shows cannot be known.
        let stuck = ValveNo::ALL.into_iter().any(|valve| is_stuck(view, valve));
        let unknown =
            stuck && view.inputs.flow_lps < FLOWING_LPS || !self.believes(Axis::Deployer, view);
        // What opens by itself, no output can hold; it stays open until it is closed.
        for (valve, opened) in ValveNo::ALL.into_iter().zip(&mut self.opened) {
            let opens = view.faults.contains(&Fault::Valve(valve, ValveFault::OpenRelay));
            *opened = opens || *opened && view.wet[valve as usize];
        }
        let opened = self.opened.contains(&true);
        self.excused = view.flooded && (self.excused || unknown || opened);
        self.folded_ms = if view.deployed { 0 } else { self.folded_ms + STEP_MS };
        self.unasked_ms = if is_unasked(view) { self.unasked_ms + STEP_MS } else { 0 };
        for (axis, ms) in Axis::ALL.into_iter().zip(&mut self.unfed_ms) {
            *ms = if turns_unfed(view, axis) { *ms + STEP_MS } else { 0 };
        }
        for (ms, wet) in self.wet_ms.iter_mut().zip(view.wet) {
            *ms = if wet { *ms + STEP_MS } else { 0 };
        }
    }

    fn believes(&self, axis: Axis, view: &View<'_>) -> bool {
        view.now_ms > self.lie_until_ms[axis as usize]
    }

    /// What is driven, in the true situation as far as the monitor can know it.
    fn moment<'v>(&self, ledger: &Ledger, view: &'v View<'_>) -> Moment<'v> {
        let folds = view.device.has(SubsystemId::DEPLOYER);
        let believed = folds && self.believes(Axis::Deployer, view);
        Moment {
            settling: !is_settled(ledger, view),
            locked: ledger.lock == Lock::On,
            stowed: believed && self.folded_ms > position_lag_ms(view),
            flooded: believed && view.flooded && !self.excused,
            // End switches and blocks that are sensed now may be newer than what the program acted on.
            drives: Axis::ALL
                .map(|axis| Drive { travel: self.travel(ledger, view, axis), ..Drive::default() }),
            valves: ValveNo::ALL.map(|valve| self.valve(ledger, view, valve, folds)),
            ..Moment::new(view.outputs)
        }
    }

    fn valve(&self, ledger: &Ledger, view: &View<'_>, valve: ValveNo, folds: bool) -> Valve {
        let index = valve as usize;
        let input = &view.inputs.valves[index];
        let remote = Param::of_valve(valve.id(), ValveParam::ValveType)
            .is_some_and(|param| view.params.get(param) == 1);
        let shaken = view.faults.contains(&Fault::Valve(valve, ValveFault::CloseBounce));
        let lag_ms =
            if remote { REMOTE_LAG_MS } else { 0 } + if shaken { SHAKEN_LAG_MS } else { 0 };
        // What is less than the meter shows cannot be known.
        let unknown = is_stuck(view, valve) && view.inputs.flow_lps < FLOWING_LPS;
        Valve {
            open: folds && !unknown && self.wet_ms[index] > lag_ms,
            blocked: false,
            must_close: view.device.has(valve.id())
                && is_settled(ledger, view)
                && !input.close_switch
                && !is_in_vain(ledger, view, valve),
        }
    }

    fn travel(&self, ledger: &Ledger, view: &View<'_>, axis: Axis) -> Option<Travel> {
        if axis == Axis::Deployer || ledger.has_no_limits(axis) || !self.believes(axis, view) {
            return None;
        }
        let zero = view.params.drive(axis, DriveParam::ZeroPoint) - view.offsets[axis as usize];
        let lag_s = lag_ms(view, axis) as f64 / 1000.0;
        let is_noisy = view.now_ms <= self.noisy_until_ms[axis as usize];
        let noise = if is_noisy { f64::from(noise_counts(axis)) } else { 0.0 };
        Some(Travel {
            at: view.positions[axis as usize],
            min: f64::from(view.params.drive(axis, DriveParam::MinLimit) + zero),
            max: f64::from(view.params.drive(axis, DriveParam::MaxLimit) + zero),
            allowance: LIMIT_ALLOWANCE + noise + view.speeds[axis as usize].abs() * lag_s,
        })
    }

    /// §3.3.4: a drive that turns though it is not fed is reported.
    fn unfed(&self, ledger: &Ledger, view: &View<'_>) -> Option<String> {
        const TOLD: DriveFlags = DriveFlags::INTERNAL_FAULT
            .union(DriveFlags::POS_ENCODER_FAULT)
            .union(DriveFlags::SPEED_ENCODER_FAULT)
            .union(DriveFlags::POSITION_WAY_FAULT)
            .union(DriveFlags::SPEED_WAY_FAULT)
            .union(DriveFlags::CONN_LOST);
        let silent = |axis: &Axis| {
            let told = DriveFlags::from_bits_retain(view.told.drives[*axis as usize]);
            let ms = self.unfed_ms[*axis as usize].min(view.now_ms - ledger.powered_ms);
            ms > UNFED_MS && view.device.has(axis.id()) && !told.intersects(TOLD)
        };
        let axis = Axis::ALL.into_iter().find(silent)?;
        Some(format!("{axis:?} reports nothing, and turns though it is not fed"))
    }

    /// §D/6: water that flows though every valve is sensed as closed is reported, at each of them.
    fn unasked(&self, ledger: &Ledger, view: &View<'_>) -> Option<String> {
        let lasts_ms = self.unasked_ms.min(view.now_ms - ledger.powered_ms);
        let silent = |valve: &ValveNo| {
            let told = ValveFlags::from_bits_retain(view.told.valves[*valve as usize]);
            view.device.has(valve.id()) && !told.contains(ValveFlags::CLOSE_SENSOR_FAULT)
        };
        let valve = ValveNo::ALL.into_iter().find(silent).filter(|_| lasts_ms > UNASKED_MS)?;
        let name = valve_name(valve);
        Some(format!("{name} reports nothing of water that flows though it is sensed as closed"))
    }
}

/// It turns though it is not fed, as its sensors can see.
fn turns_unfed(view: &View<'_>, axis: Axis) -> bool {
    let has = |fault| view.faults.contains(&Fault::Drive(axis, fault));
    let blind = has(DriveFault::SpeedDead) && has(DriveFault::EncoderDead);
    let least = if axis == Axis::Nozzle { UNFED_SPEED_NOZZLE } else { UNFED_SPEED };
    let fed = view.outputs.drives[axis as usize].speed_tenths != 0;
    !fed && !blind && view.speeds[axis as usize].abs() > least
}

/// Of each kind one violation is reported until it ends.
const fn kind(rule: Broken) -> &'static str {
    match rule {
        Broken::DrivenBeforeSettled => "settling",
        Broken::MovesLockedOut(_) => "lockout",
        Broken::OpensLockedOut(_) | Broken::LeftOpenLockedOut(_) => "valve under lockout",
        Broken::MovesStopped(_) | Broken::OpensStopped(_) => "stop",
        Broken::AimsStowed(_) => "aim",
        Broken::OpensStowed(_) => "water",
        Broken::OpensBlocked(_) => "block",
        Broken::StowsWithWater(_) => "stowing",
        Broken::Flooded => "flood",
        Broken::LeavesLimits(..) => "limits",
        Broken::IntoEndSwitch(_) => "end switch",
    }
}

/// §3.18/1: the monitor reports the lockout that was accepted, and no other.
fn lockout_reported(ledger: &Ledger, view: &View<'_>) -> Option<String> {
    let reported = view.told.general & GeneralFlags::LOCKED_OUT.bits() != 0;
    let differs = reported != (ledger.lock == Lock::On);
    differs.then(|| format!("LockedOut is reported as {reported}, against what was accepted"))
}

fn is_settled(ledger: &Ledger, view: &View<'_>) -> bool {
    view.now_ms >= ledger.powered_ms + u64::from(SETTLE_MS)
}

/// Every valve of the monitor is sensed as closed, and water flows.
fn is_unasked(view: &View<'_>) -> bool {
    let mut valves =
        ValveNo::ALL.into_iter().filter(|valve| view.device.has(valve.id())).peekable();
    valves.peek().is_some()
        && valves.all(|valve| view.inputs.valves[valve as usize].close_switch)
        && view.inputs.flow_lps >= FLOWING_LPS
}

/// The valve has been driven towards closed for all its time and is not closed, and says so: its motor is not
/// fed without end.
pub fn is_in_vain(ledger: &Ledger, view: &View<'_>, valve: ValveNo) -> bool {
    let told = ValveFlags::from_bits_retain(view.told.valves[valve as usize]);
    let tells = told.intersects(ValveFlags::INTERNAL_FAULT | ValveFlags::CLOSE_SENSOR_FAULT);
    tells && ledger.is_in_vain(valve)
}

/// The switch "closed" of this valve says so whatever the valve does.
fn is_stuck(view: &View<'_>, valve: ValveNo) -> bool {
    view.faults.contains(&Fault::Valve(valve, ValveFault::CloseStuck))
}

/// How much later a remote drive is heard.
fn lag_ms(view: &View<'_>, axis: Axis) -> u64 {
    let remote = view.params.drive(axis, DriveParam::DriveType) == 1;
    if remote { REMOTE_LAG_MS } else { 0 }
}

/// How much later it is known that the barrel has left or reached its working position.
fn position_lag_ms(view: &View<'_>) -> u64 {
    let shaken = [DriveFault::MinBounce, DriveFault::MaxBounce]
        .iter()
        .any(|fault| view.faults.contains(&Fault::Drive(Axis::Deployer, *fault)));
    let contact_ms = if shaken { SHAKEN_LAG_MS } else { CONTACT_LAG_MS };
    lag_ms(view, Axis::Deployer) + contact_ms
}
