//! What must never be, whatever the cause; looked at in the true world.
//!
//! Allowances, and why there are any. A switch or an encoder that lies ([`Fault`]s `min-switch`,
//! `max-switch` of the deployer, `encoder-…` of a drive) cannot be seen through, so what depends on
//! it is not judged while it lies, nor for the step in which it tells the truth again. A remote unit
//! is seen through its bus, which is polled every 20 ms and counts as online until it has been silent
//! for 100 ms: what is told of it may be [`REMOTE_LAG_MS`] old. A noisy encoder is off by what the noise
//! is at most. A contact is believed when it has lasted
//! (§D/6): [`CONTACT_LAG_MS`], [`SHAKEN_LAG_MS`]. Everything else is judged in the very
//! step in which it is sensed: the program acts on no older inputs.

use lafet_device::guard::SETTLE_MS;
use lafet_device::image::{AXES, Axis, Outputs, VALVES, ValveNo, ValveOutput};
use lafet_proto::SubsystemId;
use lafet_proto::flags::{GeneralFlags, ValveFlags};
use lafet_proto::param::{DriveParam, Param, ValveParam};
use lafet_texts::{Text as _, Words, sim as text};

use super::ledger::{Ledger, Lock};
use super::{View, Violation};
use crate::fault::noise_counts;
use crate::fault::{DriveFault, Fault, ValveFault, axis_name, valve_name};
use crate::world::STEP_MS;

/// Allowance of the guard beyond a limit, and what the encoder rounds off, arc-minutes or mm.
const LIMIT_ALLOWANCE: f64 = 2.5;
/// How old what is sensed of a remote unit may be: as long as it counts as online, and a poll.
const REMOTE_LAG_MS: u64 = 120;
/// §D/6 From this flow on water flows, l/s.
const FLOWING_LPS: u16 = 2;
/// §D/6 Water that flows though every valve says closed is told when it has lasted for three seconds; their
/// contacts are believed a little later.
const UNASKED_MS: u64 = 3_100;
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
    folded_ms: u64,
    wet_ms: [u64; VALVES],
    /// Valves that have opened by themselves and are not closed yet.
    opened: [bool; VALVES],
    /// Water got in while nobody could know.
    excused: bool,
    /// One report of each kind until it ends.
    reported: Vec<&'static str>,
}

impl Invariants {
    pub fn check(&mut self, ledger: &Ledger, view: &View<'_>, found: &mut Vec<Violation>) {
        self.follow(view);
        let mut broken: Vec<(&'static str, Words)> = Vec::new();
        inert(ledger, view, &mut broken);
        self.water(view, &mut broken);
        self.folding(view, &mut broken);
        self.lockout(ledger, view, &mut broken);
        self.limits(ledger, view, &mut broken);
        self.unasked(ledger, view, &mut broken);
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
        // What is less than the meter says, nobody can know.
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
        for (ms, wet) in self.wet_ms.iter_mut().zip(view.wet) {
            *ms = if wet { *ms + STEP_MS } else { 0 };
        }
    }

    fn believes(&self, axis: Axis, view: &View<'_>) -> bool {
        view.now_ms > self.lie_until_ms[axis as usize]
    }

    /// §3.8/1, §3.11/6: no water into a barrel that does not stand in its working position.
    fn water(&self, view: &View<'_>, broken: &mut Vec<(&'static str, Words)>) {
        if !view.device.has(SubsystemId::DEPLOYER) || !self.believes(Axis::Deployer, view) {
            return;
        }
        let lag_ms = position_lag_ms(view);
        for valve in ValveNo::ALL {
            let opens = view.outputs.valves[valve as usize] == ValveOutput::Opening;
            if opens && self.folded_ms > lag_ms {
                let name = valve_name(valve);
                broken.push(("water", text::OpenedNotDeployed { name }.words()));
            }
        }
        if view.flooded && !self.excused {
            broken.push(("flood", text::Flood.words()));
        }
    }

    /// §3.1/1, §3.11/6: a folded barrel is not aimed, and none is folded with water in it.
    fn folding(&self, view: &View<'_>, broken: &mut Vec<(&'static str, Words)>) {
        if !view.device.has(SubsystemId::DEPLOYER) {
            return;
        }
        let speed = |axis: Axis| view.outputs.drives[axis as usize].speed_tenths;
        let believed = self.believes(Axis::Deployer, view);
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            let folded = self.folded_ms > position_lag_ms(view);
            if believed && folded && speed(axis) != 0 {
                let name = axis_name(axis);
                broken.push(("aim", text::DrivenNotDeployed { name }.words()));
            }
        }
        for valve in ValveNo::ALL {
            let index = valve as usize;
            // What is less than the meter says, nobody can know.
            if is_stuck(view, valve) && view.inputs.flow_lps < FLOWING_LPS {
                continue;
            }
            let remote = Param::of_valve(valve.id(), ValveParam::ValveType)
                .is_some_and(|param| view.params.get(param) == 1);
            let shaken = view.faults.contains(&Fault::Valve(valve, ValveFault::CloseBounce));
            let lag_ms =
                if remote { REMOTE_LAG_MS } else { 0 } + if shaken { SHAKEN_LAG_MS } else { 0 };
            if self.wet_ms[index] > lag_ms && speed(Axis::Deployer) < 0 {
                let name = valve_name(valve);
                broken.push(("folding", text::FoldedWhileOpen { name }.words()));
            }
        }
    }

    /// §3.18/1: nothing moves, nothing opens, what is not closed closes; and it is told.
    fn lockout(&self, ledger: &Ledger, view: &View<'_>, broken: &mut Vec<(&'static str, Words)>) {
        let told = view.told.general & GeneralFlags::LOCKED_OUT.bits() != 0;
        if told != (ledger.lock == Lock::On) {
            broken.push(("told", text::LockoutReportedWrong { reported: told }.words()));
        }
        if ledger.lock != Lock::On {
            return;
        }
        for axis in Axis::ALL {
            if view.outputs.drives[axis as usize].speed_tenths != 0 {
                let name = axis_name(axis);
                broken.push(("lockout", text::MovesUnderLockout { name }.words()));
            }
        }
        let settled = view.now_ms >= ledger.powered_ms + u64::from(SETTLE_MS);
        for valve in ValveNo::ALL {
            let output = view.outputs.valves[valve as usize];
            let left_open = view.device.has(valve.id())
                && settled
                && !view.inputs.valves[valve as usize].close_switch
                && output != ValveOutput::Closing
                && !is_in_vain(ledger, view, valve);
            if output == ValveOutput::Opening || left_open {
                let name = valve_name(valve);
                broken.push(("valve under lockout", text::OpenUnderLockout { name }.words()));
            }
        }
    }

    /// §D/6: water that flows though every valve says closed is told, at each of them.
    fn unasked(&self, ledger: &Ledger, view: &View<'_>, broken: &mut Vec<(&'static str, Words)>) {
        let lasts_ms = self.unasked_ms.min(view.now_ms - ledger.powered_ms);
        let untold = |valve: ValveNo| {
            let told = ValveFlags::from_bits_retain(view.told.valves[valve as usize]);
            view.device.has(valve.id()) && !told.contains(ValveFlags::CLOSE_SENSOR_FAULT)
        };
        if lasts_ms > UNASKED_MS
            && let Some(valve) = ValveNo::ALL.into_iter().find(|valve| untold(*valve))
        {
            let name = valve_name(valve);
            broken.push(("unasked", text::LeakUnreported { name }.words()));
        }
    }

    /// §3.17, §D/5: no drive is driven further out of its limits while they are on.
    fn limits(&self, ledger: &Ledger, view: &View<'_>, broken: &mut Vec<(&'static str, Words)>) {
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            if ledger.has_no_limits(axis) || !self.believes(axis, view) {
                continue;
            }
            let zero = view.params.drive(axis, DriveParam::ZeroPoint) - view.offsets[axis as usize];
            let min = f64::from(view.params.drive(axis, DriveParam::MinLimit) + zero);
            let max = f64::from(view.params.drive(axis, DriveParam::MaxLimit) + zero);
            let lag_s = lag_ms(view, axis) as f64 / 1000.0;
            let is_noisy = view.now_ms <= self.noisy_until_ms[axis as usize];
            let noise = if is_noisy { f64::from(noise_counts(axis)) } else { 0.0 };
            let allowance = LIMIT_ALLOWANCE + noise + view.speeds[axis as usize].abs() * lag_s;
            let (at, speed) =
                (view.positions[axis as usize], view.outputs.drives[axis as usize].speed_tenths);
            let beyond = speed > 0 && at > max + allowance || speed < 0 && at < min - allowance;
            if beyond {
                let name = axis_name(axis);
                broken.push((
                    "limits",
                    text::DrivenOutOfLimits {
                        name,
                        at: format_args!("{at:.1}"),
                        least: format_args!("{min:.0}"),
                        most: format_args!("{max:.0}"),
                    }
                    .words(),
                ));
            }
        }
    }
}

/// Every valve of the monitor is sensed as closed, and water flows.
fn is_unasked(view: &View<'_>) -> bool {
    let mut valves =
        ValveNo::ALL.into_iter().filter(|valve| view.device.has(valve.id())).peekable();
    valves.peek().is_some()
        && valves.all(|valve| view.inputs.valves[valve as usize].close_switch)
        && view.inputs.flow_lps >= FLOWING_LPS
}

/// §D/1: all off until the sensors have settled.
fn inert(ledger: &Ledger, view: &View<'_>, broken: &mut Vec<(&'static str, Words)>) {
    let settling = view.now_ms < ledger.powered_ms + u64::from(SETTLE_MS);
    let Outputs { drives, valves, heaters, .. } = view.outputs;
    let idle = drives.iter().all(|drive| drive.speed_tenths == 0)
        && valves.iter().all(|valve| *valve == ValveOutput::Off)
        && heaters.iter().all(|heater| !heater);
    if settling && !idle {
        broken.push(("inert", text::OnBeforeSettled.words()));
    }
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
