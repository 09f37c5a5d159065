//! §3.14 «StartQuench. Старт тушения», §3.15 «StartTrajectory. Программа тушения по траекториям».
//!
//! ```text
//!  Idle ──start, deployed──▶ Running ──Move, button──▶ Paused ──3 s after the last──▶ Running
//!    └────start, wrapped───▶ Deploying ──deployed──▶ Running
//!
//!  Stop, the last point, a fault: Idle. A start during a program replaces it.
//! ```
//! A direction in a request is the line of sight to the place. The barrel is raised above it by
//! what brings the jet down there (`elevation`): by the same angle all over a sector, because a
//! flat trajectory turns with the barrel as if it were rigid. The valves are not its business
//! here (§3.14/7).

pub(crate) mod approach;
#[cfg(test)]
pub(crate) mod bench;
mod elevation;
mod path;
pub(crate) mod raster;
#[cfg(test)]
mod tests;

use super::{Env, by_axis, of_axis};
use crate::cause::{Asked, Cause, Program, Rule};
use crate::image::{AXES, Axis};
use crate::time::{Millis, Timer};
use approach::{AIMING, Approach, Direction, Progress};
use elevation::{Aim, Elevation, Law, ballistics_on};
use lafet_ballistics::NARROWEST_MM;
use lafet_proto::Status;
use lafet_proto::flags::ControlFlags;
use lafet_proto::param::Param;
use lafet_proto::request::{self, Quench, Trajectory};
use path::{Path, TRAJECTORIES};
use raster::{Area, Raster};

use super::drive::Drive;

/// Its programs.
pub(crate) const PROGRAMS: [Program; 2] = [Program::Quench, Program::Trajectory];
/// §3.1/3 The program goes on this long after the last command to a drive.
const RESUME_MS: u32 = 3000;
/// Speed of the jet over the fire, 0.1 °/s. At 25 m it passes 2 m in a second, so that every place
/// stays under water for about as long as the footprint is deep in metres; a faster jet frays.
const SCAN_TENTHS: i32 = 50;
/// Longest data of a program: what a record holds after mode, flags and count of §3.15.
const DATA_MAX: usize = 252;

/// What runs, or waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Idle,
    /// §3.14/5, §3.15/4: the monitor deploys first.
    Deploying,
    Running,
    /// §3.1/3: the operator corrects the aim; which drives, as [`AIMING`].
    Paused {
        resume: Timer,
        moved: [bool; 3],
    },
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Task {
    Sector(Scan),
    Trajectory(Walk),
}

/// §3.14 A sector.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scan {
    /// Line of sight to the centre; moved by the operator's corrections.
    centre: Direction,
    /// Vertical line of sight for ballistics, as requested.
    sight: i32,
    width: i32,
    height: i32,
    step: i32,
    law: Law,
    /// Not yet laid at the start and after a correction.
    raster: Option<Raster>,
}

/// §3.15 A trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Walk {
    path: Path,
    /// The request asks for ballistics.
    ballistics: bool,
    /// The operator's corrections.
    shift: Direction,
    /// Line of sight to the point where the trajectory was paused or is.
    point: Direction,
    /// The first point has been reached: from here on the jet draws the trajectory.
    drawing: bool,
    dwell: Timer,
}

/// Bytes of the request that the program keeps: points, numbers of stored trajectories, or
/// corrections.
#[derive(Clone, PartialEq)]
pub(crate) struct Data {
    bytes: [u8; DATA_MAX],
    len: usize,
}

impl Default for Data {
    fn default() -> Self {
        Self { bytes: [0; DATA_MAX], len: 0 }
    }
}

impl core::fmt::Debug for Data {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.bytes().fmt(f)
    }
}

/// Extinguishing.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    state: State,
    task: Task,
    /// Of what it moves.
    cause: Cause,
    data: Data,
    /// Position of the nozzle as asked for, or as the operator has left it.
    nozzle: i32,
    /// The operator has set the nozzle: it stays (§3.1/3).
    nozzle_kept: bool,
    nozzle_goal: Option<i32>,
    elevation: Elevation,
    approach: Approach,
    /// What only the next start clears (§3.3.6/4).
    latched: ControlFlags,
}

impl Default for Control {
    #[inline(never)]
    fn default() -> Self {
        Self {
            state: State::Idle,
            task: Task::Sector(Scan::aim(Direction::default())),
            cause: Cause::Rule(Rule::Inert),
            data: Data::default(),
            nozzle: 0,
            nozzle_kept: false,
            nozzle_goal: None,
            elevation: Elevation::default(),
            approach: Approach::default(),
            latched: ControlFlags::empty(),
        }
    }
}

impl Control {
    /// A program runs, is paused, or waits for the deployment.
    pub fn is_active(&self) -> bool {
        self.state != State::Idle
    }

    /// §3.14 StartQuench.
    pub(crate) fn start_quench(&mut self, quench: &Quench<'_>, by: Asked, env: &Env<'_>) -> Status {
        let on = ballistics_on(env.params);
        let (sector, law) = match quench {
            // §3.14/2
            Quench::Program { program, centre_h, centre_v, nozzle } => {
                let stored = usize::try_from(*program).ok().and_then(|n| env.params.program(n));
                let Some([_, _, _, width, height, step, distance]) = stored else {
                    return Status::INVALID_VALUE;
                };
                // What was lost is not the direct aim that was never set.
                if is_lost(Param::ControlProgram0, *program, env) {
                    return Status::MODULE_FAULT;
                }
                let step = i8::try_from(step).unwrap_or(i8::MAX);
                let (centre_h, centre_v, nozzle) = (*centre_h, *centre_v, *nozzle);
                let sector = request::Sector { centre_h, centre_v, nozzle, width, height, step };
                (sector, law_of_distance(on, u8::try_from(distance).ok()))
            }
            Quench::Full { sector, distance } => {
                (*sector, law_of_distance(on, u8::try_from(*distance).ok()))
            }
            Quench::Corrected { sector, .. } => {
                (*sector, Some(if on { Law::Given } else { Law::Off }))
            }
        };
        // §3.14/4
        let (Some(law), Some(scan)) = (law, Scan::of(&sector)) else {
            return Status::INVALID_VALUE;
        };
        let limits =
            [Axis::Horizontal, Axis::Vertical].map(|axis| of_axis(env.drives, axis).limits());
        let [horizontal, vertical] = limits;
        let area = Area::around(scan.centre, scan.width, scan.height);
        let inside = area.clip(horizontal, vertical);
        // §3.14/8
        if inside.is_none() {
            let flags = ControlFlags::OUTSIDE_LIMITS | ControlFlags::MODE_FAULT;
            return self.refuse(Status::INVALID_VALUE, flags);
        }
        if let Err(status) = self.check_drives(env) {
            return status;
        }
        let data = match quench {
            Quench::Corrected { corrections, .. } => corrections.0,
            Quench::Program { .. } | Quench::Full { .. } => &[],
        };
        self.begin(Task::Sector(scan.with(law)), env);
        self.data.set(&mut data.iter().copied());
        self.cause = Cause::Program(Program::Quench, by);
        self.nozzle = i32::from(sector.nozzle);
        self.latched.set(ControlFlags::OUTSIDE_LIMITS, inside != Some(area));
        Status::ACCEPTED
    }

    /// §3.15 StartTrajectory.
    pub(crate) fn start_trajectory(
        &mut self,
        trajectory: &Trajectory<'_>,
        by: Asked,
        env: &Env<'_>,
    ) -> Status {
        if let request::Path::Stored(numbers) = trajectory.path {
            // §3.15/3, §3.15/2
            if numbers.iter().any(|number| *number >= TRAJECTORIES) {
                return Status::INVALID_VALUE;
            }
            if numbers.iter().any(|it| is_lost(Param::ControlTrajectory0, i16::from(*it), env)) {
                return Status::MODULE_FAULT;
            }
            let empty = |number: &u8| env.params.trajectory(usize::from(*number)).is_empty();
            if numbers.iter().any(empty) {
                return Status::INVALID_ID;
            }
        }
        if let Err(status) = self.check_drives(env) {
            return status;
        }
        let stored = matches!(trajectory.path, request::Path::Stored(_));
        let walk = Walk {
            path: Path::new(stored, trajectory.repeat),
            ballistics: trajectory.ballistics,
            shift: Direction::default(),
            point: Direction::default(),
            drawing: false,
            dwell: Timer::default(),
        };
        self.begin(Task::Trajectory(walk), env);
        match trajectory.path {
            request::Path::Points(points) => {
                self.data.set(&mut points.iter().flat_map(|point| point.to_bytes()));
            }
            request::Path::Stored(numbers) => self.data.set(&mut numbers.iter().copied()),
        }
        self.cause = Cause::Program(Program::Trajectory, by);
        self.nozzle = NARROWEST_MM;
        Status::ACCEPTED
    }

    /// §3.2/4 Ends the program; the caller stops the drives.
    pub(crate) fn stop(&mut self) {
        self.state = State::Idle;
        self.elevation.forget();
    }

    /// §3.1/3 A request or a button has moved a drive that aims.
    pub(crate) fn note_manual(&mut self, now: Millis) {
        let moved = match self.state {
            State::Idle | State::Deploying => return,
            State::Running => [false; 3],
            State::Paused { moved, .. } => moved,
        };
        let mut resume = Timer::default();
        resume.start(now, RESUME_MS);
        self.state = State::Paused { resume, moved };
    }

    /// Runs the program.
    #[inline(never)]
    pub(crate) fn step(&mut self, now: Millis, env: &mut Env<'_>) {
        self.elevation.follow(now, env.pressure_datm);
        match self.state {
            State::Idle => {}
            // §3.14/10
            State::Deploying if env.deploy_failed => self.end(ControlFlags::MODE_FAULT, env),
            State::Deploying if !env.deployed => {}
            State::Deploying => self.state = State::Running,
            State::Running | State::Paused { .. } if !env.deployed => {
                self.end(ControlFlags::MODE_FAULT, env);
            }
            // §3.3.6/1
            State::Running | State::Paused { .. } if approach::is_faulty(env.drives, &AIMING) => {
                self.end(ControlFlags::INTERNAL_FAULT, env);
            }
            State::Running | State::Paused { .. } if !approach::can_aim(env.drives, &AIMING) => {
                self.end(ControlFlags::MODE_FAULT, env);
            }
            State::Running => self.run(now, env),
            State::Paused { resume, moved } => self.wait(now, resume, moved, env),
        }
    }

    /// Flags but the common ones of the configuration.
    pub(crate) fn flags(&self) -> ControlFlags {
        let mut flags = self.latched | self.elevation.flags();
        let active = self.is_active();
        flags.set(ControlFlags::QUENCH, active);
        let trajectory = matches!(self.task, Task::Trajectory(_));
        flags.set(ControlFlags::TRAJECTORY, active && trajectory);
        flags.set(ControlFlags::PAUSED, matches!(self.state, State::Paused { .. }));
        if !active {
            flags -= ControlFlags::TRAJECTORY_PRESSURE_FAULT;
        }
        flags
    }

    /// A refused start leaves a program that runs as it is, and its flags with it.
    fn refuse(&mut self, status: Status, flags: ControlFlags) -> Status {
        if !self.is_active() {
            self.latched |= flags;
        }
        status
    }

    fn check_drives(&mut self, env: &Env<'_>) -> Result<(), Status> {
        if approach::is_faulty(env.drives, &AIMING) {
            return Err(Status::MODULE_FAULT);
        }
        if !approach::can_aim(env.drives, &AIMING) {
            return Err(self.refuse(Status::DENIED, ControlFlags::MODE_FAULT));
        }
        Ok(())
    }

    /// §3.14/1, §3.14/5, §3.14/9
    fn begin(&mut self, task: Task, env: &Env<'_>) {
        self.state = if env.deployed { State::Running } else { State::Deploying };
        self.task = task;
        self.nozzle_kept = false;
        self.nozzle_goal = None;
        self.elevation.restart();
        self.approach = Approach::default();
        // §3.3.6/2, §3.6/3
        let damaged = ballistics_on(env.params) && !env.params.correction_valid();
        self.latched = ControlFlags::empty();
        self.latched.set(ControlFlags::TRAJECTORY_CRC_FAULT, damaged);
    }

    fn end(&mut self, flags: ControlFlags, env: &mut Env<'_>) {
        self.stop();
        self.latched |= flags;
        approach::stop(env.drives, &PROGRAMS, Cause::Rule(Rule::ProgramEnd));
    }

    fn run(&mut self, now: Millis, env: &mut Env<'_>) {
        match self.task {
            Task::Sector(mut scan) => {
                let aim = self.aim(now, scan.law, scan.sight, env);
                self.scan(now, &mut scan, aim, env);
                self.task = Task::Sector(scan);
            }
            Task::Trajectory(mut walk) => {
                self.walk(now, &mut walk, env);
                self.task = Task::Trajectory(walk);
            }
        }
    }

    /// Brings elevation and nozzle up to date.
    fn aim(&mut self, now: Millis, law: Law, sight: i32, env: &mut Env<'_>) -> Option<Aim> {
        let asked = of_axis(env.drives, Axis::Nozzle).clamp(self.nozzle);
        let aim = self.elevation.step(now, law, sight, asked, &self.data, env);
        let wanted = if self.nozzle_kept { self.nozzle } else { elevation::nozzle_for(aim, asked) };
        let nozzle = env.drive(Axis::Nozzle);
        let goal = nozzle.clamp(wanted);
        let other = self.nozzle_goal != Some(goal);
        // §D/9 It has arrived within 1 mm, and what could not come nearer stays.
        let off = goal.abs_diff(nozzle.position()) > 1 && !nozzle.has_missed();
        if other || off && nozzle.is_idle() {
            // Where it is there already, it must not go on to where another program sent it.
            nozzle.go(goal, None, self.cause);
        }
        self.nozzle_goal = Some(goal);
        aim
    }

    /// §3.14/1 Line by line over the sector, or at its centre.
    #[inline(never)]
    fn scan(&mut self, now: Millis, scan: &mut Scan, aim: Option<Aim>, env: &mut Env<'_>) {
        if aim.is_none() {
            // What a program that this one replaces has started ends before the new aim is known.
            if scan.raster.is_none() {
                approach::stop(env.drives, &PROGRAMS, self.cause);
            }
            return;
        }
        let raised = self.elevation.raised();
        let mut raster = scan.raster.unwrap_or_else(|| scan.lay(raised, env.drives));
        let (point, speed) = if scan.step > 0 {
            (raster.point(), raster.on_line().then_some(SCAN_TENTHS))
        } else {
            (scan.centre, None)
        };
        if self.approach(now, point, raised, speed, env) == Some(Progress::There) {
            raster.advance();
        }
        scan.raster = Some(raster);
    }

    /// §3.15/1 Point by point, each for its dwell.
    #[inline(never)]
    fn walk(&mut self, now: Millis, walk: &mut Walk, env: &mut Env<'_>) {
        let Some(point) = walk.path.point(&self.data, env.params) else {
            return self.end(ControlFlags::empty(), env);
        };
        let on = ballistics_on(env.params);
        let law = match point.distance {
            // §3.3.6/5
            _ if !walk.ballistics || !on => Law::Off,
            0 => Law::Stored,
            distance => Law::Distance(distance),
        };
        walk.point =
            Direction { horizontal: point.horizontal.into(), vertical: point.vertical.into() };
        if self.aim(now, law, walk.point.vertical, env).is_none() {
            if !walk.drawing {
                approach::stop(env.drives, &PROGRAMS, self.cause);
            }
            return;
        }
        let sight = walk.point.plus(walk.shift);
        let speed = walk.drawing.then_some(SCAN_TENTHS);
        if self.approach(now, sight, self.elevation.raised(), speed, env) != Some(Progress::There) {
            return;
        }
        walk.drawing = true;
        if !walk.dwell.is_running() && point.dwell > 0 {
            walk.dwell.start(now, u32::from(point.dwell) * 100);
        } else if walk.dwell.poll(now) || point.dwell == 0 {
            walk.path.advance();
            self.elevation.renew();
        }
    }

    /// Takes the barrel towards a line of sight; `None` when the program has ended over it.
    fn approach(
        &mut self,
        now: Millis,
        sight: Direction,
        raised: i32,
        speed: Option<i32>,
        env: &mut Env<'_>,
    ) -> Option<Progress> {
        let barrel = sight.plus(Direction { horizontal: 0, vertical: raised });
        // §3.3.6/3
        if approach::clamp(env.drives, barrel) != barrel {
            self.latched |= ControlFlags::OUTSIDE_LIMITS;
        }
        let progress = self.approach.step(now, env.drives, barrel, speed, self.cause);
        if progress == Progress::Stuck {
            self.end(ControlFlags::INTERNAL_FAULT, env);
            return None;
        }
        Some(progress)
    }

    /// §3.1/3 Paused: nothing moves but what the operator moves.
    #[inline(never)]
    fn wait(&mut self, now: Millis, mut resume: Timer, mut moved: [bool; 3], env: &mut Env<'_>) {
        approach::stop(env.drives, &PROGRAMS, Cause::Rule(Rule::Paused));
        for (moved, axis) in moved.iter_mut().zip(AIMING) {
            let mover = of_axis(env.drives, axis).mover();
            *moved |= matches!(mover, Some(Cause::Request(_) | Cause::Button(_)));
        }
        if resume.poll(now) {
            self.resume(moved, env);
        } else {
            self.state = State::Paused { resume, moved };
        }
    }

    /// §3.1/3 Goes on around the point that the operator has reached, from where the drives are.
    fn resume(&mut self, [vertical, horizontal, nozzle]: [bool; 3], env: &mut Env<'_>) {
        let mut reached = approach::direction(env.drives);
        reached.vertical = reached.vertical.saturating_sub(self.elevation.raised());
        if nozzle {
            self.nozzle = of_axis(env.drives, Axis::Nozzle).position();
            self.nozzle_kept = true;
        }
        match &mut self.task {
            Task::Sector(scan) => {
                if vertical {
                    scan.centre.vertical = reached.vertical;
                }
                if horizontal {
                    scan.centre.horizontal = reached.horizontal;
                }
                if vertical || horizontal {
                    scan.raster = None;
                }
            }
            Task::Trajectory(walk) => {
                if vertical {
                    walk.shift.vertical = reached.vertical.saturating_sub(walk.point.vertical);
                }
                if horizontal {
                    walk.shift.horizontal =
                        reached.horizontal.saturating_sub(walk.point.horizontal);
                }
                walk.dwell.stop();
            }
        }
        for axis in AIMING {
            by_axis(env.drives, axis).stop(self.cause);
        }
        self.nozzle_goal = None;
        self.approach = Approach::default();
        self.state = State::Running;
    }
}

impl Scan {
    const fn aim(centre: Direction) -> Self {
        Self {
            centre,
            sight: centre.vertical,
            width: 0,
            height: 0,
            step: 0,
            law: Law::Straight,
            raster: None,
        }
    }

    /// `None` when a value is negative that must not be (§3.14/4).
    fn of(sector: &request::Sector) -> Option<Self> {
        let request::Sector { centre_h, centre_v, width, height, step, .. } = *sector;
        if width < 0 || height < 0 || step < 0 {
            return None;
        }
        let centre = Direction { horizontal: centre_h.into(), vertical: centre_v.into() };
        Some(Self {
            width: width.into(),
            height: height.into(),
            step: i32::from(step) * 60,
            ..Self::aim(centre)
        })
    }

    const fn with(self, law: Law) -> Self {
        Self { law, ..self }
    }

    /// Lays the lines over what of the sector is inside the limits; beyond them, where only a
    /// correction can lead, over the nearest point inside.
    fn lay(&self, raised: i32, drives: &[Drive; AXES]) -> Raster {
        let limits = [Axis::Horizontal, Axis::Vertical].map(|axis| of_axis(drives, axis).limits());
        let [horizontal, vertical] = limits;
        let area = Area::around(self.centre, self.width, self.height)
            .clip(horizontal, vertical)
            .unwrap_or_else(|| Area::around(approach::clamp(drives, self.centre), 0, 0));
        let from = approach::direction(drives);
        let from = Direction { vertical: from.vertical.saturating_sub(raised), ..from };
        Raster::stepping(area, self.step, from)
    }
}

/// §3.3.1/1 Whether this program or trajectory, counted from the first, could not be read.
fn is_lost(first: Param, number: i16, env: &Env<'_>) -> bool {
    let place =
        usize::try_from(number).ok().and_then(|number| (first as usize).checked_add(number));
    place.and_then(|place| Param::ALL.get(place)).is_some_and(|param| env.params.is_lost(*param))
}

/// §3.14/3; `None` for a negative distance. The distance 0 asks for no ballistics.
fn law_of_distance(on: bool, distance_m: Option<u8>) -> Option<Law> {
    Some(match (distance_m?, on) {
        (0, false) => Law::Straight,
        (0, true) => Law::Stored,
        (_, false) => Law::Off,
        (distance, true) => Law::Distance(distance),
    })
}

impl Data {
    #[cfg(test)]
    pub(crate) fn of(mut bytes: impl Iterator<Item = u8>) -> Self {
        let mut data = Self::default();
        data.set(&mut bytes);
        data
    }

    /// Keeps these bytes instead.
    fn set(&mut self, bytes: &mut dyn Iterator<Item = u8>) {
        *self = Self::default();
        for (place, byte) in self.bytes.iter_mut().zip(bytes) {
            *place = byte;
            self.len += 1;
        }
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }

    /// §3.14/3 The entry at a pressure; beyond the last, the last.
    pub(crate) fn correction(&self, pressure_datm: u16) -> Option<i8> {
        let entries = self.bytes();
        let entry = entries.get(usize::from(pressure_datm)).or(entries.last())?;
        Some(i8::from_le_bytes([*entry]))
    }
}
