//! A state of the model and its successors: the real device in the plant, a request or a cycle at a
//! time, and the judgement of each.

use crate::interlock::{Drive, Moment, Travel, Valve};
use crate::model::ask::Ask;
use crate::model::fingerprint;
use crate::model::law::{Law, Laws};
use crate::model::mandate::{Mandate, due_refusal, is_paused};
use crate::model::monitor::Monitor;
use crate::model::plant::{Fault, Plant};
use crate::model::view::{Replies, View};
use crate::model::witness::{Activity, Disturbance, Event, Happened, Witness};
use lafet_device::Composition;
use lafet_device::image::{Axis, ValveNo, ValveOutput};
use lafet_proto::flags::{
    Button, ControlFlags, DeployerFlags, DetectorFlags, DriveFlags, GeneralFlags, ValveFlags,
};
use lafet_proto::param::DriveParam;
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};
use std::fmt;
use std::hash::{DefaultHasher, Hash, Hasher};

/// A cycle of the device, ms.
const CYCLE_MS: u32 = 100;
/// Most cycles of a wait for something to happen: longer than any timer of the device.
const CYCLES_MAX: u32 = 150;
/// How far beyond a limit a drive may be, arc-minutes or mm.
const ALLOWANCE: f64 = 2.0;

/// What may happen next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// A request is sent; no cycle passes.
    Ask(Ask),
    /// Cycles pass until something can be seen to happen.
    Wait,
    /// A button of the post is pressed and held.
    Press(Button),
    /// The button is released.
    Release,
    /// A fire starts, or goes out.
    Fire(bool),
    /// The pressure sensor answers, or stops answering.
    Pressure(bool),
    /// A fault occurs.
    Break(Fault),
    /// The fault is fixed.
    Mend,
    /// The power fails and comes back.
    PowerLoss,
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ask(ask) => write!(f, "request   {ask}"),
            Self::Wait => f.write_str("time      until something happens"),
            Self::Press(button) => write!(f, "button    {button:?} is pressed"),
            Self::Release => f.write_str("button    is released"),
            Self::Fire(true) => f.write_str("fire      breaks out"),
            Self::Fire(false) => f.write_str("fire      goes out"),
            Self::Pressure(true) => f.write_str("pressure  comes back"),
            Self::Pressure(false) => f.write_str("pressure  is no longer known"),
            Self::Break(fault) => write!(f, "fault     {fault:?}"),
            Self::Mend => f.write_str("fault     is fixed"),
            Self::PowerLoss => f.write_str("power     fails and comes back"),
        }
    }
}

/// A state of the model.
#[derive(Clone, Debug)]
pub struct World<M> {
    monitor: M,
    /// The world around the monitor.
    pub plant: Plant,
    now_ms: u32,
    mandate: Mandate,
    /// Number of faults that may still occur.
    pub faults_left: u8,
    /// Whether a fault has been fixed.
    mended: bool,
    /// Laws broken by the step into this state.
    pub broken: Laws,
    /// Witnesses just seen.
    pub happened: Happened,
    /// The last answers, for readers of a path.
    pub answers: [Option<(SubsystemId, Status)>; 1],
    fingerprint: u64,
}

impl<M> Hash for World<M> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.fingerprint.hash(state);
    }
}

impl<M> PartialEq for World<M> {
    fn eq(&self, other: &Self) -> bool {
        self.fingerprint == other.fingerprint
    }
}

impl<M: Monitor> World<M> {
    /// Switched on for the first time, stowed.
    pub fn new(composition: &Composition, fire_at: i32, faults: u8) -> Self {
        let mut plant = Plant::new(composition, fire_at);
        let monitor = M::power_up(0, composition, &mut plant);
        let mandate = Mandate::after_reset(false);
        let mut world = Self {
            monitor,
            plant,
            now_ms: 0,
            mandate,
            faults_left: faults,
            mended: false,
            broken: Laws::default(),
            happened: Happened::default(),
            answers: [None],
            fingerprint: 0,
        };
        world.take_fingerprint();
        world
    }

    /// The same monitor after a deployment.
    pub fn deployed(&self, composition: &Composition) -> Self {
        let mut world = self.after(&Action::Ask(crate::model::ask::DEPLOY), composition);
        for _ in 0..CYCLES_MAX {
            world = world.after(&Action::Wait, composition);
            if world.view().is_deployed() {
                break;
            }
        }
        world.happened = Happened::default();
        world.take_fingerprint();
        world
    }

    /// The state after an action.
    pub fn after(&self, action: &Action, composition: &Composition) -> Self {
        let mut world = self.clone();
        world.broken = Laws::default();
        world.happened = Happened::default();
        world.answers = [None];
        match action {
            Action::Ask(ask) => world.ask(ask),
            Action::Wait => world.wait(composition),
            Action::Press(button) => world.plant.held = Some(*button),
            Action::Release => world.plant.held = None,
            Action::Fire(on) => world.plant.fire = *on,
            Action::Pressure(on) => world.plant.pressure = *on,
            Action::Break(fault) => {
                world.note_disturbance(Disturbance::Fault);
                world.faults_left = world.faults_left.saturating_sub(1);
                world.plant.break_down(*fault);
            }
            Action::Mend => {
                world.mended = true;
                world.plant.mend();
            }
            Action::PowerLoss => {
                world.note_disturbance(Disturbance::PowerLoss);
                let _seen = world.reset(composition, true);
            }
        }
        world.take_fingerprint();
        world
    }

    /// The status words.
    pub fn view(&self) -> View {
        View::of(&mut self.monitor.clone(), self.now_ms)
    }

    /// What distinguishes the device in this state from others, as text.
    pub fn device_text(&self) -> String {
        fingerprint::text(self.monitor.device(), self.now_ms)
    }

    fn take_fingerprint(&mut self) {
        let mut hasher = DefaultHasher::new();
        fingerprint::of(self.monitor.device(), self.now_ms).hash(&mut hasher);
        self.monitor.extra().hash(&mut hasher);
        self.plant.key().hash(&mut hasher);
        self.mandate.hash(&mut hasher);
        (self.faults_left, self.mended, self.broken, self.happened).hash(&mut hasher);
        self.fingerprint = hasher.finish();
    }

    fn look(&mut self) -> View {
        View::of(&mut self.monitor, self.now_ms)
    }

    fn ask(&mut self, ask: &Ask) {
        let before = self.look();
        match ask.body {
            Body::Lockout { key } if key == lafet_proto::id::key::ENABLE => {
                self.note_disturbance(Disturbance::Lockout);
            }
            Body::Stop if ask.to == SubsystemId::ALL => self.note_disturbance(Disturbance::Stop),
            Body::Restart if !self.mandate.locked => self.note_disturbance(Disturbance::Restart),
            _ => {}
        }
        let replies = Replies::ask(&mut self.monitor, self.now_ms, ask);
        let first = replies.iter().next();
        let alone = ask.to != SubsystemId::ALL;
        let answered = if alone { replies.only().is_some() } else { first.is_some() };
        self.broken.judge(Law::OneAnswer, answered);
        let Some(first) = first else { return };
        self.answers = [Some((first.from, first.status))];
        // §1/11: a restarting subsystem is Busy, and one that is absent or not addressed cannot
        // deny.
        let other = [Status::MODULE_NOT_EXIST, Status::WRONG_REQUEST, Status::BUSY];
        let due = due_refusal(ask, &before);
        if !due.is_empty() && !other.contains(&first.status) {
            let denied = first.status == Status::DENIED && due.contains(&first.from);
            self.broken.judge(Law::DeniedWhereDue, denied);
        }
        let was_locked = self.mandate.locked;
        self.mandate.note_answer(ask, first, &before);
        self.happened.note(Event::Released, was_locked && !self.mandate.locked);
        let taken = matches!(ask.body, Body::SetParam { .. }) && first.status.is_success();
        self.happened.note(Event::LimitTaken, taken);
        let now = self.look();
        self.happened.note(Event::LimitsOff, !before.is_limitless() && now.is_limitless());
        self.happened.note(Event::LimitsOn, before.is_limitless() && !now.is_limitless());
    }

    /// Runs cycles until an observer or a client sees a change.
    fn wait(&mut self, composition: &Composition) {
        let mut view = self.look();
        let start = (self.plant.sight(), view);
        for _ in 0..CYCLES_MAX {
            view = self.cycle(composition, &view);
            if (self.plant.sight(), view) != start || !self.broken.is_empty() {
                return;
            }
        }
    }

    /// Runs a cycle from what a client sees before it; returns what a client sees after it.
    fn cycle(&mut self, composition: &Composition, before: &View) -> View {
        let (wet_before, up_before) = (self.plant.is_wet(), self.plant.is_deployed());
        self.now_ms = self.now_ms.wrapping_add(CYCLE_MS);
        self.plant.advance();
        let restarting = before.general().contains(GeneralFlags::RESTARTING);
        self.mandate.note_buttons(self.plant.held, restarting);
        self.monitor.step(self.now_ms, &mut self.plant);
        if self.plant.stored > 0 {
            self.mandate.sure = true;
            self.plant.stored = 0;
        }
        let now = self.look();
        self.judge(before, &now);
        if self.plant.reset {
            self.happened.note(Event::Restarted, true);
            return self.reset(composition, false);
        }
        self.note_events(before, &now, wet_before, up_before);
        self.judge_view(&now);
        self.mandate.note_cycle(before, &now);
        now
    }

    /// The program starts again; stored values survive. Returns what a client sees then.
    fn reset(&mut self, composition: &Composition, by_power: bool) -> View {
        self.plant.outputs = Default::default();
        self.plant.reset = false;
        let sure = self.mandate.sure || !by_power;
        self.monitor = M::power_up(self.now_ms, composition, &mut self.plant);
        self.plant.stored = 0;
        let view = self.look();
        let locked = view.general().contains(GeneralFlags::LOCKED_OUT);
        self.broken.judge(Law::LockoutStays, !sure || locked == self.mandate.locked);
        self.mandate = Mandate::after_reset(locked);
        view
    }

    /// Judges the present outputs by the present situation.
    fn judge(&mut self, before: &View, now: &View) {
        for rule in self.moment(before, now).judge() {
            self.broken.add(rule);
        }
        let Self { plant, mandate, broken, .. } = self;
        for valve in ValveNo::ALL {
            let output = plant.outputs.valves[valve as usize];
            let opens = output == ValveOutput::Opening;
            broken.judge(Law::NoOpeningWhereForbidden, !(opens && before.is_searching()));
            broken.judge(Law::NothingUnasked, !opens || mandate.allows_opening(valve));
            let closes = output == ValveOutput::Closing;
            broken.judge(Law::NothingUnasked, !closes || mandate.allows_closing(valve));
        }
        for axis in Axis::ALL {
            broken.judge(Law::NothingUnasked, mandate.allows_drive(axis, plant.way(axis)));
        }
    }

    /// What is driven, in the true situation. With its reset the program ends inert (§3.12/2, §D/1), also where a lockout
    /// has come before it: the next one closes the valves.
    fn moment(&self, before: &View, now: &View) -> Moment<'_> {
        let Self { plant, mandate, mended, .. } = self;
        let stowed = before.has_deployer() && !plant.is_deployed();
        let valve = |valve: ValveNo| {
            // One that a fault has kept from closing in its time rests, and says so.
            let in_vain = ValveFlags::INTERNAL_FAULT | ValveFlags::CLOSE_SENSOR_FAULT;
            let kept = *mended || plant.keeps(valve);
            let rests = kept && now.valve(valve).intersects(in_vain);
            let open = !plant.is_closed(valve);
            Valve {
                open: open && before.has_deployer(),
                blocked: plant.fault == Some(Fault::ValveBlocked(valve)),
                must_close: open && before.has_valve(valve) && !rests && !plant.reset,
            }
        };
        Moment {
            settling: plant.reset,
            locked: mandate.locked,
            stopped: mandate.stopped,
            stowed,
            flooded: stowed && plant.is_wet(),
            drives: Axis::ALL
                .map(|axis| Drive { travel: self.travel(axis, before), ..Drive::default() }),
            valves: ValveNo::ALL.map(valve),
            ..Moment::new(&plant.outputs)
        }
    }

    fn travel(&self, axis: Axis, before: &View) -> Option<Travel> {
        let off = before.drive(axis).contains(DriveFlags::LIMITLESS);
        // Where the encoder is faulty, only the end switches show the position.
        let blind = matches!(self.plant.fault, Some(Fault::Encoder(_) | Fault::Offline(_)));
        if axis == Axis::Deployer || off || blind {
            return None;
        }
        let value = |param| self.monitor.device().params().drive(axis, param);
        Some(Travel {
            at: f64::from(self.plant.position(axis) - value(DriveParam::ZeroPoint)),
            min: f64::from(value(DriveParam::MinLimit)),
            max: f64::from(value(DriveParam::MaxLimit)),
            allowance: ALLOWANCE,
        })
    }

    /// Judges the status words after a cycle.
    fn judge_view(&mut self, now: &View) {
        let Self { plant, mandate, broken, .. } = self;
        broken.judge(Law::NothingUnasked, mandate.allows_programs(now));
        let locked = now.general().contains(GeneralFlags::LOCKED_OUT);
        broken.judge(Law::LockoutStays, locked == mandate.locked);
        let positions = DeployerFlags::DEPLOYED
            | DeployerFlags::DEPLOYING
            | DeployerFlags::WRAPPED
            | DeployerFlags::WRAPPING;
        let flags = now.deployer();
        let one = (flags & positions).bits().count_ones() <= 1;
        let agree = (!flags.contains(DeployerFlags::DEPLOYED) || plant.is_deployed())
            && (!flags.contains(DeployerFlags::WRAPPED) || plant.is_wrapped());
        broken.judge(Law::OnePosition, one && agree);
    }

    fn note_events(&mut self, before: &View, now: &View, wet_before: bool, up_before: bool) {
        let Self { plant, mandate, happened, mended, .. } = self;
        let is_new = |old: bool, new: bool| !old && new;
        let deployed = is_new(up_before, plant.is_deployed()) && now.is_deployed();
        happened.note(Event::Deployed, deployed);
        happened.note(Event::DeployedForProgram, deployed && now.is_quenching());
        happened.note(Event::DeployedForSearch, deployed && now.is_searching());
        let wrapped = now.deployer().contains(DeployerFlags::WRAPPED);
        happened.note(Event::Wrapped, wrapped && before.is_on_the_way());
        let opened = |valve| {
            is_new(
                before.valve(valve).contains(ValveFlags::OPEN),
                now.valve(valve).contains(ValveFlags::OPEN),
            )
        };
        happened.note(Event::WaterOn, opened(ValveNo::Valve1));
        happened.note(Event::FoamOn, opened(ValveNo::Valve2));
        happened.note(
            Event::OpenedByButton,
            opened(ValveNo::Valve1) && plant.held == Some(Button::Open),
        );
        happened.note(Event::WaterOff, wet_before && !plant.is_wet());
        let aims = |axis| mandate.moves(axis) && plant.way(axis) != 0;
        let aimed = aims(Axis::Horizontal) || aims(Axis::Vertical) || aims(Axis::Nozzle);
        happened.note(Event::Aimed, aimed);
        let held = |axis| mandate.is_held(axis) && plant.way(axis) != 0;
        happened.note(Event::AimedByButton, held(Axis::Horizontal) || held(Axis::Vertical));
        let sweeps = now.is_quenching() && !is_paused(now) && plant.way(Axis::Horizontal) != 0;
        let trajectory = ControlFlags::TRAJECTORY;
        let program = before.control().contains(trajectory);
        happened.note(Event::QuenchRuns, sweeps && !now.control().contains(trajectory));
        let faults = ControlFlags::MODE_FAULT | ControlFlags::INTERNAL_FAULT;
        let sound = !now.control().intersects(faults);
        let ended = before.is_quenching() && !now.is_quenching() && mandate.has_program();
        happened.note(Event::TrajectoryFinished, ended && program && sound);
        happened.note(
            Event::Paused,
            is_new(is_paused(before), is_paused(now)) || is_paused(now) && aimed,
        );
        happened.note(Event::Resumed, is_paused(before) && !is_paused(now) && now.is_quenching());
        let pressure = ControlFlags::TRAJECTORY_PRESSURE_FAULT;
        happened.note(
            Event::DirectAim,
            now.control().contains(pressure) && plant.way(Axis::Nozzle) > 0,
        );
        let searched = before.is_searching() && !now.is_searching();
        let canceled = now.detector().contains(DetectorFlags::CANCELED);
        let found = now.detector().contains(DetectorFlags::FOUND);
        happened.note(Event::Found, searched && found && !canceled);
        happened.note(Event::NothingFound, searched && !found && !canceled);
        let justified = |view: &View| view.detector().contains(DetectorFlags::JUSTIFIED);
        happened.note(Event::Justified, is_new(justified(before), justified(now)));
        let beyond = plant.position(Axis::Horizontal).abs() > 300;
        happened.note(Event::BeyondLimits, now.is_limitless() && beyond);
        happened.note(Event::RecoveredDeployed, *mended && deployed);
        happened.note(Event::RecoveredAimed, *mended && aimed);
        happened.note(Event::RecoveredWater, *mended && opened(ValveNo::Valve1));
        happened.note(Event::ToldFault, is_new(reports_fault(before), reports_fault(now)));
    }

    fn note_disturbance(&mut self, disturbance: Disturbance) {
        let view = self.look();
        for activity in Activity::ALL {
            if self.is_in_the_middle_of(activity, &view) {
                self.happened.add(Witness::disturbed(disturbance, activity));
            }
        }
    }

    fn is_in_the_middle_of(&self, activity: Activity, view: &View) -> bool {
        let Self { plant, mandate, .. } = self;
        let turning = |axis| plant.way(axis) != 0;
        match activity {
            Activity::Deploying => {
                view.deployer().contains(DeployerFlags::DEPLOYING) && turning(Axis::Deployer)
            }
            Activity::Wrapping => view.deployer().contains(DeployerFlags::WRAPPING),
            Activity::Moving => mandate.moves(Axis::Horizontal) && turning(Axis::Horizontal),
            Activity::Opening => plant.outputs.valves.contains(&ValveOutput::Opening),
            Activity::Water => view.valve(ValveNo::Valve1).contains(ValveFlags::OPEN),
            Activity::Waiting => view.is_quenching() && !view.is_deployed(),
            Activity::Program => {
                view.is_quenching() && !is_paused(view) && turning(Axis::Horizontal)
            }
            Activity::Paused => is_paused(view),
            Activity::Searching => view.is_searching() && turning(Axis::Horizontal),
            Activity::Justifying => view.is_justifying(),
            Activity::Limitless => view.is_limitless(),
        }
    }
}

/// Whether a flag is set that the faults of the plant raise.
fn reports_fault(view: &View) -> bool {
    view.drive(Axis::Horizontal).intersects(
        DriveFlags::POS_ENCODER_FAULT
            | DriveFlags::MOTOR_BROKEN
            | DriveFlags::AMPERAGE_OVERLOAD
            | DriveFlags::INTERNAL_FAULT
            | DriveFlags::CONN_LOST,
    ) || view.general().contains(GeneralFlags::CONFIG_WRITE_FAULT)
        || view.detector().contains(DetectorFlags::DEVICE_FAULT)
        || view
            .valve(ValveNo::Valve1)
            .intersects(ValveFlags::INTERNAL_FAULT | ValveFlags::BLOCKED | ValveFlags::CONN_LOST)
        || view.deployer().contains(DeployerFlags::INTERNAL_FAULT)
}
