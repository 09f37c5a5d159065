//! The monitor: what it consists of, how it powers up, and what happens in a step.

use crate::cause::{Cause, Causes, Rule};
use crate::composition::{ChainSet, Composition};
use crate::guard::{self, Passed, Rules};
use crate::hal::{FaultInfo, Hal, Storage, StorageError};
use crate::image::{AXES, Axis, Inputs, Outputs, UNITS, VALVES, ValveNo};
use crate::inputs::{Contacts, Debounce, FLOWING_LPS, Heard, Water, bit};
use crate::params::Params;
use crate::subsystem::buttons::{ButtonPost, Demand, Held};
use crate::subsystem::climatics::Climatics;
use crate::subsystem::conn::{Conn, Source};
use crate::subsystem::control::Control;
use crate::subsystem::control::approach::AIMING;
use crate::subsystem::deployer::Deployer;
use crate::subsystem::detector::Detector;
use crate::subsystem::drive::Drive;
use crate::subsystem::general::{General, Reset};
use crate::subsystem::valve::Valve;
use crate::subsystem::{Env, by_axis, of_axis};
use crate::time::{Millis, Timer};
use lafet_proto::param::{DriveParam, Param};
use lafet_proto::status::Limits;
use lafet_proto::{RequestId, SubsystemId};

/// Allowance of the guard beyond a limit: what a drive needs to arrive there, ' or mm.
const LIMIT_ALLOWANCE: i32 = 2;
/// The guard cuts a drive off at this many times MaxCurrent, before overload is judged.
const CUT_OFF_FACTOR: i32 = 2;

/// A fire monitor.
///
/// `handle` answers frames, `step` runs it; the caller passes the same clock to both, and makes
/// a new `Device` when the HAL has been asked to reset.
#[derive(Clone, Debug, PartialEq)]
pub struct Device {
    pub(crate) chain: ChainSet,
    pub(crate) address: u8,
    pub(crate) inputs: Inputs,
    contacts: Debounce,
    heard: Heard,
    water: Water,
    pub(crate) outputs: Passed,
    causes: Causes,
    pub(crate) params: Params,
    pub(crate) general: General,
    pub(crate) climatics: Climatics,
    pub(crate) drives: [Drive; AXES],
    pub(crate) valves: [Valve; VALVES],
    pub(crate) control: Control,
    pub(crate) detector: Detector,
    pub(crate) deployer: Deployer,
    pub(crate) external_conn: Conn,
    pub(crate) radio: Conn,
    pub(crate) buttons: ButtonPost,
    pub(crate) ext_buttons: ButtonPost,
    pub(crate) settling: Timer,
    last_step: Millis,
    /// A request since the last step was not GetStatus.
    pub(crate) disturbed: bool,
    #[cfg(feature = "update")]
    pub(crate) software: crate::software::Updating,
}

impl Device {
    /// Starts the monitor: inert, the valves commanded closed, position taken from the sensors.
    ///
    /// `composition` and `address` are what the hardware says; stored parameters precede them.
    /// `crash` is what a fault before this start has left (§3.20).
    pub fn power_up(
        now_ms: u32,
        composition: &Composition,
        address: u8,
        crash: Option<FaultInfo>,
        hal: &mut impl Hal,
    ) -> Self {
        let mut device = Self::at_rest(composition, address);
        device.wake(now_ms, crash, hal);
        device
    }

    /// A monitor before its power-up: nothing is driven, and nothing known. [`Self::wake`] goes on; a
    /// chip, on which there is no room for two, calls both by itself.
    #[inline(never)]
    pub fn at_rest(composition: &Composition, address: u8) -> Self {
        // Greatest parts last, each by a call: then each is made in its place, none on the stack.
        Self {
            chain: composition.chain,
            address,
            inputs: Inputs::default(),
            contacts: Debounce::default(),
            heard: Heard::NOTHING,
            water: Water::default(),
            outputs: Passed::default(),
            causes: Causes::all(Rule::Inert),
            general: General::default(),
            climatics: Climatics::default(),
            deployer: Deployer::default(),
            external_conn: Conn::default(),
            radio: Conn::default(),
            buttons: ButtonPost::default(),
            ext_buttons: ButtonPost::default(),
            settling: Timer::default(),
            last_step: Millis::default(),
            disturbed: false,
            #[cfg(feature = "update")]
            software: crate::software::Updating::default(),
            params: Params::BLANK,
            drives: Drive::all(),
            valves: Valve::both(),
            control: Control::default(),
            detector: Detector::default(),
        }
    }

    /// §D/1 Takes what memory and sensors say at the start.
    pub fn wake(&mut self, now_ms: u32, crash: Option<FaultInfo>, hal: &mut impl Hal) {
        let now = Millis(now_ms);
        self.last_step = now;
        if let Some(crash) = crash {
            self.general.set_crash(crash);
        }
        let Self { params, inputs, contacts, .. } = self;
        params.restore(hal);
        hal.read(inputs);
        // §D/6 None counts yet: neither folded nor deployed, and no valve closed.
        contacts.step(0, Contacts::of(inputs)).put(inputs);
        // §3.19/3 What is not stored is as compiled in, the address as the hardware has it.
        if params.has_lost_general() {
            params.stand_in(self.address, self.chain);
        } else if !params.is_incomplete(SubsystemId::GENERAL) {
            self.chain = ChainSet::from_bits(params.get(Param::GeneralChain) as u16);
            self.address = params.get(Param::GeneralAddress) as u8;
        }
        let locked = params.lockout();
        let keep_valves = params.get(Param::GeneralResetValves) != 0 && !locked;
        self.general.set_locked(locked);
        // A request may come before the first step: each subsystem has its inputs by then.
        self.general.step(0, inputs, params);
        self.climatics.power_up(inputs);
        let chain = self.chain;
        for ((drive, axis), input) in self.drives.iter_mut().zip(&Axis::ALL).zip(&inputs.drives) {
            let unit = unit_of(&inputs.units, axis.unit());
            drive.power_up(params, *input, unit, chain.contains(axis.id()));
        }
        for ((valve, no), input) in self.valves.iter_mut().zip(&ValveNo::ALL).zip(&inputs.valves) {
            let unit = unit_of(&inputs.units, no.unit());
            valve.power_up(now, params, (input, unit), keep_valves);
        }
        let [first, second] = &inputs.buttons;
        self.buttons.power_up(first);
        self.ext_buttons.power_up(second);
        self.settling.start(now, guard::SETTLE_MS);
        #[cfg(feature = "update")]
        self.wake_software(hal);
        let (_, detector, env) = self.programs();
        detector.sense(&env);
    }

    /// Stores the parameters with which a monitor of this composition leaves the factory.
    ///
    /// # Errors
    ///
    /// [`StorageError`] of the first value that the memory does not take; values before it are
    /// stored.
    pub fn provision(
        storage: &mut impl Storage,
        composition: &Composition,
        address: u8,
    ) -> Result<(), StorageError> {
        Params::provision(storage, composition, address)
    }

    /// The address it answers to.
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// §L/7 Whether frames without a CRC-32C are left alone on an interface.
    pub fn wants_crc32c(&self, source: Source) -> bool {
        let param = match source {
            Source::ExternalConn => Param::ExternalConnCheck,
            Source::Radio => Param::RadioCheck,
        };
        self.params.get(param) != 0
    }

    /// The parameters' values.
    pub const fn params(&self) -> &Params {
        &self.params
    }

    /// What was driven in the last step.
    pub const fn outputs(&self) -> &Outputs {
        self.outputs.outputs()
    }

    /// Why each output was driven as it was in the last step.
    pub const fn causes(&self) -> &Causes {
        &self.causes
    }

    /// What was sensed in the last step, as it was judged (§D/6).
    pub const fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Whether a subsystem is part of this monitor.
    pub const fn has(&self, id: SubsystemId) -> bool {
        self.chain.contains(id)
    }

    /// Whether `other` is this monitor in the same state, but for the moment of its last step and
    /// the noise of the pressure sensor: a simulator passes over the time in which nothing changes.
    pub fn is_same_state(&self, other: &Self) -> bool {
        let mut other = other.clone();
        other.last_step = self.last_step;
        other.inputs.pressure_ua = self.inputs.pressure_ua;
        *self == other
    }

    /// Whether a request since the last step may have changed something: any but GetStatus.
    pub const fn is_disturbed(&self) -> bool {
        self.disturbed
    }

    /// One cycle: inputs, subsystems, guard, outputs; then what has to be stored or reset.
    #[inline(never)]
    pub fn step(&mut self, now_ms: u32, hal: &mut impl Hal) {
        let now = Millis(now_ms);
        let dt_ms = now.since(self.last_step);
        self.last_step = now;
        self.disturbed = false;
        hal.read(&mut self.inputs);
        // §D/6
        self.heard.step(dt_ms, &mut self.inputs.units);
        let sensed = Contacts::of(&mut self.inputs);
        let judged = self.contacts.step(dt_ms, sensed);
        let judged = self.judge_water(dt_ms, judged);
        judged.put(&mut self.inputs);
        let starts = self.settling.is_running();
        self.settling.poll(now);
        self.run(now, dt_ms, starts);
        let (wanted, mut causes) = (self.wanted(), self.wanted_causes());
        let believed = if self.deployer.is_doubted() { judged.without_deployed() } else { judged };
        believed.with_ends_of(sensed).put(&mut self.inputs);
        self.outputs = guard::filter(&self.rules(), &self.inputs, &wanted, &mut causes);
        judged.put(&mut self.inputs);
        hal.write(&self.outputs);
        let passed = self.outputs.drives.iter().zip(&wanted.drives).zip(&causes.drives);
        for (drive, ((passed, wanted), why)) in self.drives.iter_mut().zip(passed) {
            if passed != wanted {
                drive.restrain(*why);
            }
        }
        self.causes = causes;
        self.params.poll_retry(now);
        self.store(now, hal);
        #[cfg(feature = "update")]
        self.step_software(now, dt_ms, hal);
        // §D/2 A closing that has not left the open switch yet would be forgotten.
        let keeps = self.params.get(Param::GeneralResetValves) != 0;
        let leaves = keeps && self.valves.iter().any(Valve::leaves_open);
        if !leaves && let Some(reset) = self.general.poll_reset(now) {
            self.reset(now, reset, hal);
        }
    }

    /// §D/6 Water that flows is believed more than the switches of valves.
    #[inline(never)]
    fn judge_water(&mut self, dt_ms: u32, judged: Contacts) -> Contacts {
        let valves = judged.of_valves(ValveNo::ALL.map(|no| self.has(no.id())));
        let pressure_datm = self.general.pressure_datm();
        self.water.step(dt_ms, valves, self.inputs.flow_lps, pressure_datm);
        if self.water.is_unasked() { judged.without_closed() } else { judged }
    }

    /// §D/6 Water flows, whatever the valves say.
    pub(crate) const fn flows(&self) -> bool {
        self.inputs.flow_lps >= FLOWING_LPS
    }

    /// §D/6 What the inputs contradict, as the parameter InputFaults of General reports it.
    pub fn input_faults(&self) -> i32 {
        let mut bits = 0;
        if self.water.is_unasked() {
            bits |= bit::WATER_UNASKED;
        }
        if self.water.is_missing() {
            bits |= bit::WATER_MISSING;
        }
        if self.detector.is_saturated() {
            bits |= bit::SATURATED;
        }
        if self.deployer.is_doubted() {
            bits |= bit::DEPLOYER_DOUBTED;
        }
        let mut valves = self.valves.iter().zip(ValveNo::ALL);
        if valves.any(|(valve, no)| self.has(no.id()) && valve.is_unconfirmed()) {
            bits |= bit::UNCONFIRMED;
        }
        for (axis, drive) in self.drives.iter().enumerate() {
            if drive.output().cut {
                bits |= bit::RUNAWAY << axis;
            }
            if !drive.is_homed() {
                bits |= bit::NOT_HOMED << axis;
            }
            if drive.has_missed() {
                bits |= bit::MISSED << axis;
            }
        }
        bits
    }

    /// §3.5/10 Flash stops the program while it is written or erased. Nothing may run on unguarded
    /// meanwhile, nor a Stop come late; under lockout there is nothing left to stop. On a bad supply the
    /// lockout alone is written (§3.3.1/4).
    fn store(&mut self, now: Millis, hal: &mut impl Storage) {
        let locked = self.general.is_locked();
        match self.keeps_to_lockout() {
            true if locked => self.params.flush_lockout(now, hal),
            false if locked || self.outputs.is_still() => self.params.flush(now, hal),
            _ => {}
        }
    }

    /// Nothing but the lockout is stored: on a bad supply, and on trial, since the old program has to be able
    /// to read what is stored.
    fn keeps_to_lockout(&self) -> bool {
        #[cfg(feature = "update")]
        if self.software.is_on_trial() {
            return true;
        }
        self.general.has_bad_power()
    }

    /// In working position, or without a Deployer.
    pub(crate) fn is_deployed(&self) -> bool {
        !self.has(SubsystemId::DEPLOYER) || self.deployer.is_deployed()
    }

    /// Control, Detector and what they work with.
    pub(crate) fn programs(&mut self) -> (&mut Control, &mut Detector, Env<'_>) {
        let deployed = self.is_deployed();
        let env = Env {
            inputs: &self.inputs,
            params: &mut self.params,
            drives: &mut self.drives,
            deployed,
            deploy_failed: !deployed && self.deployer.has_failed(),
            dt_ms: 0,
            pressure_datm: self.general.pressure_datm(),
        };
        (&mut self.control, &mut self.detector, env)
    }

    /// Ends every operation of the drives; valves are stopped too when `valves` says so.
    pub(crate) fn stop_motion(&mut self, valves: bool, why: Cause) {
        self.control.stop();
        self.detector.stop();
        self.deployer.stop(&mut self.drives, why);
        for (drive, axis) in self.drives.iter_mut().zip(&Axis::ALL) {
            drive.stop(why);
            self.buttons.disarm(*axis);
            self.ext_buttons.disarm(*axis);
        }
        if valves {
            for valve in &mut self.valves {
                valve.stop(why);
            }
        }
    }

    /// §D/8 A client confirms the water that flows.
    pub(crate) fn confirm_water(&mut self) {
        self.valves.iter_mut().for_each(Valve::confirm);
    }

    /// §3.18/1, §3.12/1 Ends everything and closes the valves.
    pub(crate) fn close_everything(&mut self, now: Millis, why: Cause) {
        self.stop_motion(false, why);
        for valve in &mut self.valves {
            valve.close(now, &self.params, why);
        }
    }

    /// `starts`: the inputs settle, or have in this step.
    fn run(&mut self, now: Millis, dt_ms: u32, starts: bool) {
        let Self { inputs, params, .. } = self;
        self.general.step(dt_ms, inputs, params);
        self.climatics.step(dt_ms, inputs, params);
        let sensed = inputs.drives.iter().zip(&Axis::ALL);
        for (drive, (input, axis)) in self.drives.iter_mut().zip(sensed) {
            if starts {
                drive.note_start(input);
            }
            drive.step(now, dt_ms, input, unit_of(&inputs.units, axis.unit()), params);
        }
        for ((valve, no), input) in self.valves.iter_mut().zip(&ValveNo::ALL).zip(&inputs.valves) {
            valve.doubt(self.water.is_unasked());
            valve.step(now, dt_ms, input, unit_of(&inputs.units, no.unit()), params);
        }
        if self.general.is_locked() {
            self.valves.iter_mut().for_each(|valve| valve.keep_closed(now, params));
        }
        self.external_conn.step(now);
        self.radio.step(now);
        if self.chain.contains(SubsystemId::DEPLOYER) {
            let [_, _, _, deployer] = &inputs.drives;
            self.deployer.step(now, dt_ms, deployer, &mut self.drives, params);
        }
        if !self.is_deployed() {
            self.end_aims();
        }
        self.run_buttons(now, dt_ms);
        let (control, detector, mut env) = self.programs();
        env.dt_ms = dt_ms;
        detector.step(now, &mut env);
        control.step(now, &mut env);
    }

    /// §3.1/1 What aims ends with the working position, and does not go on when that is reached
    /// again; nor does what opens (§3.8/1). Programs end by themselves.
    #[inline(never)]
    fn end_aims(&mut self) {
        for valve in &mut self.valves {
            valve.end_opening(Cause::Rule(Rule::NotDeployed));
        }
        self.end_moves(Cause::Rule(Rule::NotDeployed));
    }

    /// Ends what Moves have started of the drives that aim; a held button is asked in each step.
    pub(crate) fn end_moves(&mut self, why: Cause) {
        for axis in AIMING {
            let drive = by_axis(&mut self.drives, axis);
            if matches!(drive.mover(), Some(Cause::Request(_))) {
                drive.stop(why);
            }
        }
    }

    /// §3.3.10/1 Buttons act as requests would, and are refused where those would be.
    #[inline(never)]
    fn run_buttons(&mut self, now: Millis, dt_ms: u32) {
        // What is held while inputs settle was held at the start, whatever the first of them said.
        let restarting = self.general.is_restarting() || self.settling.is_running();
        let locked = self.general.is_locked();
        let [first, second] = self.inputs.buttons;
        let posts = [
            (SubsystemId::BUTTONS, &mut self.buttons, first),
            (SubsystemId::EXT_BUTTONS, &mut self.ext_buttons, second),
        ];
        let mut held = [Held::NONE; 3];
        let (mut open, mut close) = (None, None);
        for (id, post, states) in posts {
            if self.chain.contains(id) {
                let demand: Demand = post.step(dt_ms, &states, locked, restarting);
                for (held, more) in held.iter_mut().zip(demand.held) {
                    held.join(id, more);
                }
                open = open.or(demand.open.then_some(id));
                close = close.or(demand.close.then_some(id));
            }
        }
        for (axis, held) in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle].into_iter().zip(held) {
            self.run_direction_button(now, axis, held);
        }
        self.run_valve_buttons(now, open, close);
    }

    #[inline(never)]
    fn run_direction_button(&mut self, now: Millis, axis: Axis, held: Held) {
        // §3.3.1/4 What is held may go on, and not begin.
        let goes_on = matches!(of_axis(&self.drives, axis).mover(), Some(Cause::Button(_)));
        let weak = !goes_on && self.general.is_weak();
        let busy = self.busy_detector().is_some();
        let faulty = of_axis(&self.drives, axis).is_faulty();
        let refused = self.refusal_of_work().is_some() || weak || faulty;
        let allowed = self.chain.contains(axis.id()) && !refused;
        // What was pressed while its drive could not run is not to start when that ends by itself: a
        // repaired wire, an E-stop pulled out. Held through a deployment or an overload it acts on purpose.
        if held.is_pressed() && (weak || busy || faulty) {
            self.buttons.disarm(axis);
            self.ext_buttons.disarm(axis);
        }
        let direction = held.direction();
        let drive = by_axis(&mut self.drives, axis);
        match direction {
            Some((up, post)) if allowed => {
                drive.run(up, Cause::Button(post));
                self.control.note_manual(now);
            }
            _ if matches!(drive.mover(), Some(Cause::Button(_))) => {
                let held = direction.is_some();
                drive.stop(Cause::Rule(if held { Rule::Refused } else { Rule::Released }));
            }
            _ => {}
        }
    }

    /// Valve1, or Valve2 where there is no Valve1.
    #[inline(never)]
    fn run_valve_buttons(
        &mut self,
        now: Millis,
        open: Option<SubsystemId>,
        close: Option<SubsystemId>,
    ) {
        let has_first = self.chain.contains(SubsystemId::VALVE1);
        let id = if has_first { SubsystemId::VALVE1 } else { SubsystemId::VALVE2 };
        if !self.chain.contains(id) {
            return;
        }
        let (close, open) = (
            close.filter(|_| self.intercept(RequestId::CLOSE, id).is_none()),
            open.filter(|_| self.intercept(RequestId::OPEN, id).is_none()),
        );
        let [valve1, valve2] = &mut self.valves;
        let valve = if id == SubsystemId::VALVE1 { valve1 } else { valve2 };
        if let Some(post) = close {
            valve.close(now, &self.params, Cause::Button(post));
        } else if let Some(post) = open {
            valve.open(now, &self.params, Cause::Button(post));
        }
    }

    #[inline(never)]
    fn rules(&self) -> Rules {
        let limits = Axis::ALL.map(|axis| {
            let zero = of_axis(&self.drives, axis).reading_at_zero(&self.params);
            // Deployment ends at switches, which stand a little beyond the limits.
            of_axis(&self.drives, axis).limits().filter(|_| axis != Axis::Deployer).map(
                |Limits { min, max }| {
                    let raw = |limit: i32| limit.saturating_add(zero);
                    (
                        raw(min).saturating_sub(LIMIT_ALLOWANCE),
                        raw(max).saturating_add(LIMIT_ALLOWANCE),
                    )
                },
            )
        });
        let current_da = Axis::ALL.map(|axis| {
            self.params.drive(axis, DriveParam::MaxCurrent).saturating_mul(CUT_OFF_FACTOR)
        });
        Rules {
            settled: !self.settling.is_running(),
            locked: self.general.is_locked(),
            deployer: self.has(SubsystemId::DEPLOYER),
            valves: ValveNo::ALL.map(|no| self.has(no.id())),
            spent: self.valves.each_ref().map(Valve::is_spent),
            limits,
            current_da,
        }
    }

    /// What the subsystems of the chain want; the others want nothing.
    #[inline(never)]
    fn wanted(&self) -> Outputs {
        let mut wanted = Outputs::default();
        let drives = Axis::ALL.iter().zip(&self.drives).zip(&mut wanted.drives);
        for ((axis, drive), output) in drives {
            if self.has(axis.id()) {
                *output = drive.output();
            }
        }
        let valves = ValveNo::ALL.iter().zip(&self.valves).zip(&mut wanted.valves);
        for ((no, valve), output) in valves {
            if self.has(no.id()) {
                *output = valve.output();
            }
        }
        if self.has(SubsystemId::CLIMATICS) {
            for (output, heater) in wanted.heaters.iter_mut().zip(self.climatics.heaters()) {
                *output = heater;
            }
        }
        let [vertical, horizontal, nozzle, deployer] = &self.drives;
        let [valve1, valve2] = &self.valves;
        wanted.units = [
            vertical.unit_op(),
            horizontal.unit_op(),
            nozzle.unit_op(),
            deployer.unit_op(),
            valve1.unit_op(),
            valve2.unit_op(),
        ];
        wanted
    }

    /// Why they want it.
    #[inline(never)]
    fn wanted_causes(&self) -> Causes {
        let mut causes = Causes::all(Rule::Absent);
        let drives = Axis::ALL.iter().zip(&self.drives).zip(&mut causes.drives);
        for ((axis, drive), cause) in drives {
            if self.has(axis.id()) {
                *cause = drive.driven();
            }
        }
        let valves = ValveNo::ALL.iter().zip(&self.valves).zip(&mut causes.valves);
        for ((no, valve), cause) in valves {
            if self.has(no.id()) {
                *cause = valve.cause();
            }
        }
        if self.has(SubsystemId::CLIMATICS) {
            for (cause, why) in causes.heaters.iter_mut().zip(self.climatics.causes()) {
                *cause = why;
            }
        }
        causes
    }

    /// §3.12/2, §3.19/1
    fn reset(&mut self, now: Millis, reset: Reset, hal: &mut impl Hal) {
        // §3.3.1/4
        let bad = self.general.has_bad_power();
        // A lockout that has come meanwhile is not erased with the rest (§3.18/6), and its valves close on.
        if reset == Reset::CleanFlash && (bad || self.general.is_locked()) {
            return self.general.erase_failed();
        }
        // Flash stops the program while it is written or erased: nothing may run on meanwhile.
        self.outputs = self.outputs.inert();
        hal.write(&self.outputs);
        self.causes = Causes::all(Rule::Inert);
        match reset {
            Reset::Restart if self.keeps_to_lockout() => self.params.flush_lockout(now, hal),
            Reset::Restart => self.params.flush_all(now, hal),
            Reset::CleanFlash if hal.erase().is_err() => return self.general.erase_failed(),
            Reset::CleanFlash => {}
        }
        hal.reset();
    }
}

fn unit_of(
    units: &[crate::image::UnitInput; UNITS],
    unit: crate::image::Unit,
) -> &crate::image::UnitInput {
    let [first, ..] = units;
    units.get(unit as usize).unwrap_or(first)
}
