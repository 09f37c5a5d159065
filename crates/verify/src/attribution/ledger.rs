//! What really happened: requests delivered and answered, buttons held, time.

use lafet_device::Source;
use lafet_device::cause::{Asked, Cause, Program, Rule};
use lafet_device::guard::SETTLE_MS;
use lafet_device::image::{AXES, Axis, PLACES, VALVES, ValveNo, ValveOutput};
use lafet_device::params::Params;
use lafet_proto::flags::{ControlFlags, DeployerFlags, DetectorFlags, GeneralFlags};
use lafet_proto::id::key;
use lafet_proto::param::{DriveParam, Param};
use lafet_proto::record::{Record, Records};
use lafet_proto::request::{Body, LimitsState};
use lafet_proto::{RequestId, Status, SubsystemId};
use lafet_sim::world::STEP_MS;

use super::answers;
use super::buttons::{Button, Posts};
use super::closing::Closing;
pub use super::grants::{Lock, Move, Start, Work};
use super::homing::Homings;
use super::rules::Step;
use super::units::Units;
use super::view::{View, axis_of};
use super::{Output, Told};

mod follow;

/// The ledger of a monitor.
#[derive(Clone, Debug)]
pub struct Ledger {
    now_ms: u64,
    /// When the program has started.
    pub powered_ms: u64,
    /// Whether it is locked out.
    pub lock: Lock,
    /// It survives a power cut: all that the monitor had to store is in the flash.
    lock_is_stored: bool,
    /// All has been given to the flash, which may be at it still.
    lock_is_written: bool,
    /// When the program has last looked at its inputs, and when before that.
    sensed_ms: u64,
    before_ms: u64,
    /// Positions as the monitor reports them.
    positions: [i32; AXES],
    /// Drives that are remote units.
    remote: [bool; AXES],
    /// Waiting for a reset since.
    pub restart_ms: Option<u64>,
    /// The Move in force, by [`Axis`].
    pub moves: [Option<Move>; AXES],
    /// Programs that have been started and not stopped.
    pub starts: Vec<Start>,
    /// Rights to drive the valves.
    pub works: [Vec<Work>; VALVES],
    /// Requests that were accepted since the last step.
    pub recent: Vec<(Asked, Status)>,
    /// Whether limits are off, by [`Axis`].
    pub limitless: [bool; AXES],
    /// §D/7 Which positions are known.
    pub homings: Homings,
    /// §D/6 Which remote units are heard.
    pub units: Units,
    /// When the monitor was last aimed by hand.
    manual_ms: Option<u64>,
    /// For how long each drive has drawn more than MaxCurrent, less the time it has not, ms.
    pub over_ms: [u64; AXES],
    /// Whether each drive drew so much in the last step that it was cut off: it draws nothing now, and
    /// is overloaded all the same.
    cut_off: [bool; AXES],
    /// For how long each valve has drawn more than MaxCurrent, less the time it has not, ms.
    pub valve_over_ms: [u64; VALVES],
    /// How each valve is being closed.
    closings: [Closing; VALVES],
    /// Its unit was lost while it opened, or has not been heard since the start: it may be open, whatever its last picture
    /// says.
    strays: [bool; VALVES],
    /// For how long it has not been opened, ms.
    unopened_ms: [u64; VALVES],
    /// Why each valve is to close: it has not since, and no request has said what else it is to do.
    pub owed: [Option<Cause>; VALVES],
    /// §D/8 When a client has last confirmed the water of each valve, or it was last closed.
    confirmed_ms: [u64; VALVES],
    /// Its closing for want of that has started.
    unconfirmed: [bool; VALVES],
    /// For how long each heater has been sensed as faulty, ms.
    pub heater_fault_ms: [u64; PLACES],
    /// When the detector was last not ready.
    pub blind_ms: Option<u64>,
    /// When a fault was last in force at a drive or its unit.
    pub broken_ms: [Option<u64>; AXES],
    /// When a fault was last in force at a valve or its unit.
    pub valve_broken_ms: [Option<u64>; VALVES],
    /// Until then the monitor may have seen water that lets it doubt what its valves say.
    doubts_until_ms: u64,
    memory_is_sound: bool,
    /// The button posts.
    pub buttons: Posts,
    told: Told,
    /// Limits of each drive before the last change of them, and those of the last step.
    pub past_limits: [[Option<i32>; 4]; AXES],
    move_timeout_ms: u32,
    /// MoveHold set since the last step, for the Move in the same frame.
    holds: [Option<(u64, u32)>; AXES],
    deployer_travel_ms: u32,
    /// TravelTime of each valve, ms.
    pub valve_travel_ms: [u32; VALVES],
    chain_known: bool,
    chain: Vec<SubsystemId>,
}

impl Ledger {
    pub(super) fn new(now_ms: u64) -> Self {
        Self {
            now_ms,
            powered_ms: now_ms,
            lock: Lock::Off,
            lock_is_stored: true,
            lock_is_written: true,
            sensed_ms: now_ms,
            before_ms: now_ms,
            positions: [0; AXES],
            remote: [false; AXES],
            restart_ms: None,
            moves: [None; AXES],
            starts: Vec::new(),
            works: [power_up_work(now_ms, 0), power_up_work(now_ms, 0)],
            recent: Vec::new(),
            limitless: [false; AXES],
            homings: Homings::default(),
            units: Units::default(),
            manual_ms: None,
            over_ms: [0; AXES],
            cut_off: [false; AXES],
            valve_over_ms: [0; VALVES],
            closings: Default::default(),
            strays: [true; VALVES],
            unopened_ms: [u64::MAX; VALVES],
            owed: [Some(Cause::Rule(Rule::PowerUp)); VALVES],
            confirmed_ms: [now_ms; VALVES],
            unconfirmed: [false; VALVES],
            heater_fault_ms: [0; PLACES],
            blind_ms: None,
            broken_ms: [None; AXES],
            valve_broken_ms: [None; VALVES],
            doubts_until_ms: 0,
            memory_is_sound: true,
            buttons: Posts::default(),
            told: Told::default(),
            past_limits: [[None; 4]; AXES],
            move_timeout_ms: 0,
            holds: [None; AXES],
            deployer_travel_ms: 0,
            valve_travel_ms: [0; VALVES],
            chain_known: false,
            chain: SubsystemId::CHAIN.to_vec(),
        }
    }

    pub(super) fn powered_up(&mut self, now_ms: u64, params: &Params, memory_is_sound: bool) {
        let sure = self.memory_is_sound && memory_is_sound && self.lock_is_stored;
        let lock = if sure { self.lock } else { Lock::Unknown };
        *self = Self {
            lock,
            memory_is_sound,
            // What is asked for before the first step meets the same monitor.
            chain: core::mem::take(&mut self.chain),
            past_limits: self.past_limits,
            move_timeout_ms: self.move_timeout_ms,
            deployer_travel_ms: self.deployer_travel_ms,
            valve_travel_ms: self.valve_travel_ms,
            homings: self.homings.powered_up(params),
            units: Units::powered_up(params),
            ..Self::new(now_ms)
        };
    }

    /// Takes over what was asked for and answered; otherwise says what is wrong with the answers.
    pub(super) fn delivered(
        &mut self,
        now_ms: u64,
        source: Source,
        payload: &[u8],
        answer: &[u8],
    ) -> Result<(), &'static str> {
        self.now_ms = now_ms;
        let answers: Vec<Record<'_>> = Records::new(answer).flatten().collect();
        let mut rest = answers.as_slice();
        let mut full = false;
        let mut whole = Ok(());
        for record in Records::new(payload).flatten() {
            let asked = Asked { request: record.request, to: record.device, source };
            let taken = answers::count(&self.chain, &asked, rest);
            let (mine, others) = rest.split_at(taken);
            rest = others;
            let behind = full;
            full |= mine.iter().any(|answer| answer.status == Status::NO_ROOM);
            if !behind && !full {
                whole = whole.and(answers::complete(&self.chain, &asked, mine));
            }
            self.judge(&record, &asked, mine, full);
        }
        let cut = usize::from(Records::new(payload).any(|record| record.is_err()));
        whole.and_then(|()| answers::nothing_more(rest, if full { 1 } else { cut }))
    }

    /// What a request and its answers permit and end.
    fn judge(&mut self, record: &Record<'_>, asked: &Asked, mine: &[Record<'_>], full: bool) {
        let Ok(body) = Body::decode(record.request, record.data) else { return };
        let as_a_whole =
            matches!(record.request, RequestId::STOP | RequestId::LOCKOUT | RequestId::RESTART)
                && matches!(record.device, SubsystemId::ALL | SubsystemId::MOTORS);
        // §1/9 Stop All and Lockout on take effect though their answers find no room.
        if full && as_a_whole && !self.refuses(record.request, &body) {
            if self.lock == Lock::Unknown {
                // Carried out or refused: it depends on a lockout that is not reported yet.
                return self.recent.push((*asked, Status::OK));
            }
            return self.accepted(asked, &body, asked.to, Status::OK);
        }
        for answer in mine {
            // §D/8 Who asks for the water wants it, though the valve cannot be opened further.
            let refused = matches!(answer.status, Status::MODULE_FAULT | Status::DENIED);
            if record.request == RequestId::OPEN && refused && answer.device == record.device {
                let index = usize::from(answer.device == SubsystemId::VALVE2);
                self.confirmed_ms[index] = self.now_ms;
            }
            let closes = record.request == RequestId::CLOSE || record.request == RequestId::STOP;
            // A faulty valve is driven to close all the same, a faulty drive stops.
            let acts =
                answer.status.is_success() || closes && answer.status == Status::MODULE_FAULT;
            if acts && as_a_whole_or(record.device, answer.device) {
                self.accepted(asked, &body, answer.device, answer.status);
                if as_a_whole {
                    return;
                }
            }
        }
    }

    fn refuses(&self, request: RequestId, body: &Body<'_>) -> bool {
        // §3.12/2 What ends something is carried out before a reset, too.
        let ends = matches!(body, Body::Stop | Body::Lockout { key: key::ENABLE });
        self.lock == Lock::On && request != RequestId::LOCKOUT || self.restart_ms.is_some() && !ends
    }

    /// What an accepted request permits and ends.
    fn accepted(&mut self, asked: &Asked, body: &Body<'_>, by: SubsystemId, status: Status) {
        let whole = matches!(asked.to, SubsystemId::ALL | SubsystemId::MOTORS);
        self.recent.push((*asked, status));
        match body {
            Body::Move { destination } => self.moved(asked, i32::from(*destination)),
            Body::Stop if whole => {
                let valves = asked.to == SubsystemId::ALL;
                self.stop_everything(valves);
                if valves {
                    self.closings.iter_mut().for_each(|closing| closing.stop(self.now_ms));
                }
            }
            Body::Stop => self.stop(by),
            Body::Open { .. } => self.work(by, ValveOutput::Opening, Cause::Request(*asked)),
            Body::Close { .. } => self.work(by, ValveOutput::Closing, Cause::Request(*asked)),
            Body::Deploy if status == Status::ACCEPTED => self.deploy(asked),
            Body::Wrap if status == Status::ACCEPTED => {
                self.end(&[Program::Quench, Program::Trajectory, Program::Deploy]);
                self.moves = [None; AXES];
                self.start(Program::Wrap, asked, &[]);
            }
            Body::StartQuench(_) => {
                self.confirmed_ms = [self.now_ms; VALVES];
                self.start_deploying(Program::Quench, asked);
            }
            Body::StartTrajectory(_) => {
                self.confirmed_ms = [self.now_ms; VALVES];
                self.start_deploying(Program::Trajectory, asked);
            }
            Body::StartSeek(_) => self.start_deploying(Program::Seek, asked),
            Body::StartJustify => self.start(Program::Justify, asked, &[]),
            Body::SwitchLimits { new_state } => self.switch_limits(by, *new_state),
            Body::Lockout { key: key::ENABLE } => {
                self.close_everything(asked);
                self.set_lock(Lock::On);
            }
            Body::Lockout { .. } => self.set_lock(Lock::Off),
            Body::SetParam { id, values } => {
                if let Some(param) = Param::find(by, *id) {
                    let ms = values.iter().next().unwrap_or(0).unsigned_abs();
                    self.set_time(param, ms);
                    if param.name() == "MoveHold" {
                        self.hold(by, ms);
                    }
                    if param == Param::GeneralWaterTimeout {
                        self.confirmed_ms = [self.now_ms; VALVES];
                    }
                }
            }
            Body::Restart | Body::CleanFlash { .. } => {
                // With ResetValves what closes goes on for the reason it had.
                let mut closing = self.works.clone();
                self.close_everything(asked);
                for (works, before) in self.works.iter_mut().zip(&mut closing) {
                    before.retain(|work| work.output == ValveOutput::Closing);
                    works.append(before);
                }
                self.restart_ms = Some(self.now_ms);
            }
            _ => {}
        }
    }

    fn set_lock(&mut self, lock: Lock) {
        self.lock = lock;
        (self.lock_is_stored, self.lock_is_written) = (false, false);
    }

    /// What the requests behind this one, in the same step too, will be judged by.
    fn set_time(&mut self, param: Param, ms: u32) {
        match param {
            Param::GeneralMoveTimeout => self.move_timeout_ms = ms,
            Param::DeployerTravelTime => self.deployer_travel_ms = ms,
            Param::Valve1TravelTime => self.valve_travel_ms[0] = ms,
            Param::Valve2TravelTime => self.valve_travel_ms[1] = ms,
            _ => {}
        }
    }

    /// §D/4 MoveHold: for the Move in the same frame, or a held one for longer.
    fn hold(&mut self, id: SubsystemId, ms: u32) {
        let Some(axis) = axis_of(id) else { return };
        let hold = (self.now_ms, ms);
        self.holds[axis as usize] = Some(hold);
        if let Some(granted) = &mut self.moves[axis as usize]
            && granted.hold.is_some()
        {
            granted.hold = Some(hold);
            (granted.at_ms, granted.timeout_ms) = (self.now_ms, self.move_timeout_ms);
            if axis != Axis::Deployer {
                self.manual_ms = Some(self.now_ms);
            }
        }
    }

    fn moved(&mut self, asked: &Asked, destination: i32) {
        let Some(axis) = axis_of(asked.to) else { return };
        let [.., min, max] = self.past_limits[axis as usize];
        let limitless = self.has_no_limits(axis);
        let target = match limitless {
            true => destination,
            false => destination.min(max.unwrap_or(i32::MAX)).max(min.unwrap_or(i32::MIN)),
        };
        let runs = limitless && !self.remote[axis as usize];
        self.moves[axis as usize] = Some(Move {
            asked: *asked,
            destination,
            target,
            at_ms: self.now_ms,
            timeout_ms: self.move_timeout_ms,
            hold: self.holds[axis as usize].take(),
            limitless,
            runs: (runs && destination != self.positions[axis as usize])
                .then_some(destination > self.positions[axis as usize]),
        });
        if axis == Axis::Deployer {
            self.end(&[Program::Deploy, Program::Wrap]);
        } else {
            self.manual_ms = Some(self.now_ms);
        }
    }

    fn stop_everything(&mut self, valves: bool) {
        self.starts.clear();
        self.moves = [None; AXES];
        for axis in Axis::ALL {
            self.buttons.disarm(axis);
        }
        if valves {
            self.works = Default::default();
            self.owed = [None; VALVES];
        }
    }

    fn stop(&mut self, id: SubsystemId) {
        match id {
            SubsystemId::CONTROL => self.end(&[Program::Quench, Program::Trajectory]),
            SubsystemId::DETECTOR => self.end(&[Program::Seek, Program::Justify]),
            SubsystemId::DEPLOYER => self.end(&[Program::Deploy, Program::Wrap]),
            SubsystemId::VALVE1 | SubsystemId::VALVE2 => {
                let index = usize::from(id == SubsystemId::VALVE2);
                self.works[index].clear();
                self.owed[index] = None;
                self.closings[index].stop(self.now_ms);
            }
            _ => {}
        }
        if let Some(axis) = axis_of(id) {
            self.moves[axis as usize] = None;
            self.buttons.disarm(axis);
        }
    }

    fn close_everything(&mut self, asked: &Asked) {
        self.stop_everything(true);
        for valve in ValveNo::ALL {
            self.work(valve.id(), ValveOutput::Closing, Cause::Request(*asked));
        }
    }

    fn work(&mut self, id: SubsystemId, output: ValveOutput, cause: Cause) {
        let index = usize::from(id == SubsystemId::VALVE2);
        let (at_ms, travel_ms) = (self.now_ms, self.valve_travel_ms[index]);
        let works = &mut self.works[index];
        works.retain(|work| work.output == output);
        works.push(Work { output, cause, at_ms, travel_ms });
        self.owed[index] = (output == ValveOutput::Closing).then_some(cause);
        match output {
            ValveOutput::Opening => {
                self.closings[index].open();
                self.confirmed_ms[index] = at_ms;
            }
            _ => self.closings[index].begin(at_ms, travel_ms, true),
        }
    }

    fn deploy(&mut self, asked: &Asked) {
        self.end(&[Program::Wrap]);
        self.moves[Axis::Deployer as usize] = None;
        self.start(Program::Deploy, asked, &[]);
    }

    /// §3.14/5, §3.16/3 What is started while folded deploys first.
    fn start_deploying(&mut self, program: Program, asked: &Asked) {
        let flags = self.told.drives[Axis::Deployer as usize];
        let deployed = flags & DeployerFlags::DEPLOYED.bits() != 0;
        let leaving = self.starts.iter().any(|start| start.program == Program::Wrap)
            || self.moves[Axis::Deployer as usize].is_some();
        if !deployed || leaving {
            self.deploy(asked);
        }
        self.start(program, asked, &[Program::Quench, Program::Trajectory, Program::Seek]);
    }

    fn start(&mut self, program: Program, asked: &Asked, replaces: &[Program]) {
        if program != Program::Deploy {
            // It takes the drives over from what moves them.
            for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
                self.moves[axis as usize] = None;
            }
        }
        let now_ms = self.now_ms;
        for start in &mut self.starts {
            if replaces.contains(&start.program) {
                start.replaced_ms.get_or_insert(now_ms);
            }
        }
        let (asked, travel_ms) = (*asked, self.deployer_travel_ms);
        self.starts.push(Start { program, asked, at_ms: now_ms, replaced_ms: None, travel_ms });
    }

    fn end(&mut self, programs: &[Program]) {
        self.starts.retain(|start| !programs.contains(&start.program));
    }

    fn switch_limits(&mut self, id: SubsystemId, new_state: u16) {
        let Some(axis) = axis_of(id) else { return };
        let limitless = &mut self.limitless[axis as usize];
        let off = LimitsState::from_wire(new_state) == Some(LimitsState::Off);
        if *limitless && !off {
            // What ran without limits stops.
            self.moves[axis as usize] = None;
        }
        *limitless = off;
    }

    /// Limits are switched off, or the position they would be judged by is not known.
    pub fn has_no_limits(&self, axis: Axis) -> bool {
        self.limitless[axis as usize] || self.homings.is_unknown(axis)
    }

    /// Takes over what is sensed in this step, before it is judged; says which drives tell wrongly
    /// whether their position is known.
    pub(super) fn sense(&mut self, view: &View<'_>) -> Vec<Axis> {
        self.now_ms = view.now_ms;
        // The program runs on when the flash has done its work.
        self.lock_is_stored |= self.lock_is_written;
        if self.lock == Lock::Unknown {
            let locked = view.told.general & GeneralFlags::LOCKED_OUT.bits() != 0;
            self.lock = if locked { Lock::On } else { Lock::Off };
        }
        if !self.chain_known {
            let is_built_in = |id: &SubsystemId| view.device.has(*id);
            self.chain = SubsystemId::CHAIN.into_iter().filter(is_built_in).collect();
            self.chain_known = true;
            self.note_params(view);
            self.homings.start(view);
            self.free_early_moves(view);
            for (works, travel_ms) in self.works.iter_mut().zip(self.valve_travel_ms) {
                let by_power_up = |work: &&mut Work| work.cause == Cause::Rule(Rule::PowerUp);
                for work in works.iter_mut().filter(by_power_up) {
                    work.travel_ms = travel_ms;
                }
            }
            // §D/2 What is not kept closes from the start on; of the rest, that is seen when it closes.
            let keeps = view.params.get(Param::GeneralResetValves) != 0 && self.lock != Lock::On;
            let valves = self.closings.iter_mut().zip(self.valve_travel_ms);
            for (closing, travel_ms) in valves.filter(|_| !keeps) {
                closing.begin_by_rule(self.powered_ms, travel_ms);
            }
        }
        let passed_ms = view.now_ms - self.sensed_ms;
        self.units.sense(passed_ms, view.params, &view.inputs.units);
        self.follow_valves(view);
        let restarting = self.restart_ms.is_some();
        let locked = self.lock == Lock::On;
        self.buttons.sense(passed_ms, &view.inputs.buttons, locked, restarting);
        if self.now_ms <= self.powered_ms + u64::from(SETTLE_MS) {
            self.note_early_buttons();
        }
        if self.buttons.aims() {
            self.manual_ms = Some(self.now_ms);
        }
        self.follow_currents(view);
        self.follow_faults(view);
        let wrong = self.homings.follow(view);
        (self.before_ms, self.sensed_ms) = (self.sensed_ms, view.now_ms);
        wrong
    }

    /// A Move that was accepted before the first step of a drive whose position is not known.
    fn free_early_moves(&mut self, view: &View<'_>) {
        for (axis, granted) in Axis::ALL.into_iter().zip(&mut self.moves) {
            if let Some(granted) = granted
                && self.homings.is_unknown(axis)
            {
                let at = i32::from(view.told.positions[axis as usize]);
                granted.limitless = true;
                granted.target = granted.destination;
                granted.runs = (granted.destination != at).then_some(granted.destination > at);
            }
        }
    }

    /// Takes over what an output has done: what has come to its end is not permitted any more.
    pub(super) fn settle(&mut self, step: &Step, view: &View<'_>) {
        match step.output {
            Output::Drive(axis) => {
                let holds = match step.cause {
                    Cause::Request(asked) => {
                        self.moves[axis as usize].is_some_and(|granted| granted.asked == asked)
                    }
                    // What the guard holds back may go on when it releases it.
                    Cause::Rule(rule) => is_passing(rule),
                    Cause::Program(..) | Cause::Button(_) => false,
                };
                if !holds {
                    self.moves[axis as usize] = None;
                }
            }
            Output::Valve(valve) => {
                // Off by a rule: also what was asked for and has ended before it began.
                let ended = step.after == 0;
                if ended && matches!(step.cause, Cause::Rule(rule) if !is_passing(rule)) {
                    self.works[valve as usize].clear();
                }
                let way = view.outputs.valves[valve as usize];
                self.unconfirmed[valve as usize] = step.cause == Cause::Rule(Rule::Unconfirmed);
                if way == ValveOutput::Closing {
                    let travel_ms = self.valve_travel_ms[valve as usize];
                    self.closings[valve as usize].begin_by_rule(self.now_ms, travel_ms);
                }
                if let Cause::Button(post) = step.cause
                    && self.buttons.pressed(post, valve_button(way))
                {
                    self.work(valve.id(), way, step.cause);
                }
            }
            Output::Heater(_) => {}
        }
    }

    /// Drops what the step has used up: programs that say that they have ended.
    pub(super) fn forget(&mut self, view: &View<'_>) {
        self.told = view.told;
        self.lock_is_written |= view.params.is_stored();
        // A memory that cannot be erased ends the wait for the reset (§3.19).
        if view.told.general & GeneralFlags::RESTARTING.bits() == 0 {
            self.restart_ms = None;
        }
        self.recent.clear();
        self.note_params(view);
        let runs = |start: &Start| is_running(start.program, &view.told);
        let now_ms = self.now_ms;
        self.starts.retain(|start| {
            runs(start) && start.replaced_ms.is_none_or(|at_ms| now_ms <= at_ms + STEP_MS)
        });
    }

    /// What requests of the next step will be judged by.
    fn note_params(&mut self, view: &View<'_>) {
        self.holds = [None; AXES];
        self.positions = view.told.positions.map(i32::from);
        for axis in Axis::ALL {
            self.remote[axis as usize] = view.params.drive(axis, DriveParam::DriveType) == 1;
            let min = Some(view.params.drive(axis, DriveParam::MinLimit));
            let max = Some(view.params.drive(axis, DriveParam::MaxLimit));
            let [.., last_min, last_max] = self.past_limits[axis as usize];
            if (last_min, last_max) != (min, max) {
                self.past_limits[axis as usize] = [last_min, last_max, min, max];
            }
        }
        const TIMES: [Param; 4] = [
            Param::GeneralMoveTimeout,
            Param::DeployerTravelTime,
            Param::Valve1TravelTime,
            Param::Valve2TravelTime,
        ];
        for param in TIMES {
            self.set_time(param, view.params.get(param).unsigned_abs());
        }
    }

    /// Whether such a program was started and has not been stopped.
    pub fn start_of(&self, program: Program, asked: Asked) -> Option<&Start> {
        self.starts.iter().find(|start| start.program == program && start.asked == asked)
    }

    /// Whether any post of this monitor asks for this direction of a drive, and none for the other.
    pub fn is_asked_by_button(&self, axis: Axis, up: bool) -> bool {
        let posts = || {
            let all = [SubsystemId::BUTTONS, SubsystemId::EXT_BUTTONS].into_iter();
            all.filter(|post| self.chain.contains(post))
        };
        posts().any(|post| self.buttons.holds(post, axis, up))
            && !posts().any(|post| self.buttons.shows(post, axis, !up))
    }

    /// Whether the monitor was aimed by hand since the last step of the program.
    pub fn has_just_aimed(&self) -> bool {
        self.manual_ms.is_some_and(|at_ms| at_ms >= self.before_ms)
    }
}

/// Whether so much current cuts a drive off in the same step.
pub const fn is_cut_off(current_da: i32, max_current_da: i32) -> bool {
    current_da > 2 * max_current_da
}

/// Whether a program says of itself that it runs.
pub fn is_running(program: Program, told: &Told) -> bool {
    let deployer = told.drives[Axis::Deployer as usize];
    match program {
        Program::Quench | Program::Trajectory => told.control & ControlFlags::QUENCH.bits() != 0,
        Program::Seek => told.detector & DetectorFlags::SEARCHING.bits() != 0,
        Program::Justify => told.detector & DetectorFlags::JUSTIFYING.bits() != 0,
        Program::Deploy => deployer & DeployerFlags::DEPLOYING.bits() != 0,
        Program::Wrap => deployer & DeployerFlags::WRAPPING.bits() != 0,
    }
}

/// Rules that hold something back only as long as their condition lasts. What needs the working
/// position, and what a block has stopped, does not come back by itself.
const fn is_passing(rule: Rule) -> bool {
    matches!(
        rule,
        Rule::Inert | Rule::Lockout | Rule::Water | Rule::Limit | Rule::EndSwitch | Rule::CutOff
    )
}

fn power_up_work(at_ms: u64, travel_ms: u32) -> Vec<Work> {
    let cause = Cause::Rule(Rule::PowerUp);
    vec![Work { output: ValveOutput::Closing, cause, at_ms, travel_ms }]
}

/// The addressee's own answer, or one of many.
fn as_a_whole_or(to: SubsystemId, from: SubsystemId) -> bool {
    matches!(to, SubsystemId::ALL | SubsystemId::MOTORS) || to == from
}

/// The button that asks for this way of a valve.
pub const fn valve_button(way: ValveOutput) -> Button {
    match way {
        ValveOutput::Opening => Button::Open,
        ValveOutput::Off | ValveOutput::Closing => Button::Close,
    }
}
