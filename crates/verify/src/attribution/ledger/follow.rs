//! What is sensed in each step: buttons, contacts, currents, faults.

use lafet_device::cause::Cause;
use lafet_device::image::{AXES, Axis, ValveNo, ValveOutput};
use lafet_proto::SubsystemId;
use lafet_proto::param::{DriveParam, Param, ValveParam};
use lafet_sim::fault::{Fault, SingleFault, ValveFault};

use super::{Button, Ledger, View, Work, is_cut_off};
use crate::attribution::closing::Passing;

/// §D/6 What water has shown of the valves is believed for so long after it has ended, ms.
const DOUBT_MS: u64 = 3_100;
/// §D/6 From this flow on water flows, l/s.
const FLOWING_LPS: u16 = 2;
/// §D/6 What is sensed of a unit may be so old, ms, in steps of which each counts as so much at most.
const OLD_MS: u64 = 200;
const STEP_MS: u64 = 50;

impl Ledger {
    /// What is asked for while the outputs are still inert may be done afterwards.
    pub(super) fn note_early_buttons(&mut self) {
        for post in [SubsystemId::BUTTONS, SubsystemId::EXT_BUTTONS] {
            for (button, output) in
                [(Button::Open, ValveOutput::Opening), (Button::Close, ValveOutput::Closing)]
            {
                if self.buttons.pressed(post, button) {
                    let (cause, at_ms) = (Cause::Button(post), self.now_ms);
                    let valves = self.works.iter_mut().zip(&mut self.closings);
                    for ((works, closing), travel_ms) in valves.zip(self.valve_travel_ms) {
                        works.push(Work { output, cause, at_ms, travel_ms });
                        if output == ValveOutput::Closing {
                            closing.begin(at_ms, travel_ms, true);
                        }
                    }
                }
            }
        }
    }

    pub(super) fn follow_valves(&mut self, view: &View<'_>) {
        let passed_ms = view.now_ms - self.sensed_ms;
        // Water against the valves: a contact or a flow meter that lies.
        let lies = |fault: &Fault| {
            let meter = [SingleFault::FlowFrozen, SingleFault::FlowDrift].map(Fault::Single);
            matches!(fault, Fault::Valve(_, ValveFault::CloseStuck)) || meter.contains(fault)
        };
        // A valve that was taken out of the chain while it stood open: no command can close it, and its water runs
        // past those that are.
        let stray = |valve: &ValveNo| {
            !view.device.has(valve.id()) && !view.inputs.valves[*valve as usize].close_switch
        };
        let strays = view.inputs.flow_lps >= FLOWING_LPS && ValveNo::ALL.iter().any(stray);
        if strays || view.faults.iter().any(lies) {
            self.doubts_until_ms = view.now_ms + DOUBT_MS;
        }
        let sound = view.now_ms >= self.doubts_until_ms;
        for valve in ValveNo::ALL {
            let remote = Param::of_valve(valve.id(), ValveParam::ValveType)
                .is_some_and(|param| view.params.get(param) == 1);
            let online = !remote || !self.units.is_lost(valve.unit() as usize);
            let opens = view.outputs.valves[valve as usize] == ValveOutput::Opening;
            let strays = &mut self.strays[valve as usize];
            let unopened_ms = &mut self.unopened_ms[valve as usize];
            let old = *unopened_ms < OLD_MS;
            *unopened_ms =
                if opens { 0 } else { unopened_ms.saturating_add(passed_ms.min(STEP_MS)) };
            *strays = !online && (*strays || opens || old);
            let mut input = view.inputs.valves[valve as usize];
            input.close_switch &= !(*strays || remote && old && !opens);
            let time = Passing {
                now_ms: view.now_ms,
                passed_ms,
                travel_ms: self.valve_travel_ms[valve as usize],
            };
            self.closings[valve as usize].sense(time, &input, online, sound);
            // Who has it opened has confirmed its water then, and not when it leaves its switch.
            let works = &self.works[valve as usize];
            let opens = works.iter().any(|work| work.output == ValveOutput::Opening);
            let sound = !input.open_switch && !input.close_sensor_fault;
            let closed = self.closings[valve as usize].is_closed();
            if closed {
                self.owed[valve as usize] = None;
            }
            if closed && sound && !opens {
                self.confirmed_ms[valve as usize] = view.now_ms;
            }
        }
    }

    /// §D/8 Whether a valve has not been closed for WaterTimeout, and no client has confirmed its water; that it
    /// is being closed for that goes on.
    pub fn is_unconfirmed(&self, view: &View<'_>, valve: ValveNo) -> bool {
        let limit_ms = 1000 * u64::from(view.params.get(Param::GeneralWaterTimeout).unsigned_abs());
        let over = view.now_ms >= self.confirmed_ms[valve as usize] + limit_ms;
        self.unconfirmed[valve as usize] || limit_ms > 0 && over
    }

    /// Whether a valve is still to close for this cause: by power-up, or by a request or a button. Between a Restart and its
    /// reset for that, or for what was before it.
    pub fn owes(&self, valve: ValveNo, cause: Cause) -> bool {
        self.owed[valve as usize].is_some_and(|owed| {
            let same = |is: fn(&Cause) -> bool| is(&owed) && is(&cause);
            let asked = same(|cause| matches!(cause, Cause::Request(_)));
            owed == cause
                || same(|cause| matches!(cause, Cause::Button(_)))
                || asked && self.restart_ms.is_some()
        })
    }

    /// Whether a valve has been driven towards closed for all its time, and has not closed.
    pub fn is_in_vain(&self, valve: ValveNo) -> bool {
        self.closings[valve as usize].is_in_vain(self.now_ms)
    }

    pub(super) fn follow_currents(&mut self, view: &View<'_>) {
        let passed_ms = view.now_ms - self.sensed_ms;
        for axis in Axis::ALL {
            let max = view.params.drive(axis, DriveParam::MaxCurrent);
            let current = i32::from(view.inputs.drives[axis as usize].current_da);
            let was_cut_off =
                std::mem::replace(&mut self.cut_off[axis as usize], is_cut_off(current, max));
            let ms = &mut self.over_ms[axis as usize];
            *ms = match current > max || was_cut_off {
                true => *ms + passed_ms,
                false => ms.saturating_sub(passed_ms),
            };
        }
        for valve in ValveNo::ALL {
            let max = Param::of_valve(valve.id(), ValveParam::MaxCurrent)
                .map_or(0, |param| view.params.get(param));
            let over = i32::from(view.inputs.valves[valve as usize].current_da) > max;
            let ms = &mut self.valve_over_ms[valve as usize];
            *ms = if over { *ms + passed_ms } else { ms.saturating_sub(passed_ms) };
        }
    }

    pub(super) fn follow_faults(&mut self, view: &View<'_>) {
        let now = Some(view.now_ms);
        let passed_ms = view.now_ms - self.sensed_ms;
        for (ms, place) in self.heater_fault_ms.iter_mut().zip(&view.inputs.places) {
            *ms = if place.heater_fault { *ms + passed_ms } else { 0 };
        }
        if !view.inputs.detector.ready {
            self.blind_ms = now;
        }
        for fault in view.faults {
            match fault {
                Fault::Drive(axis, _) => self.broken_ms[*axis as usize] = now,
                Fault::Valve(valve, _) => self.valve_broken_ms[*valve as usize] = now,
                Fault::Unit(unit, _) => {
                    let index = *unit as usize;
                    match index.checked_sub(AXES) {
                        None => self.broken_ms[index] = now,
                        Some(valve) => self.valve_broken_ms[valve] = now,
                    }
                }
                Fault::Single(SingleFault::FlashRead | SingleFault::FlashWrite) => {
                    self.memory_is_sound = false;
                }
                _ => {}
            }
        }
    }
}
