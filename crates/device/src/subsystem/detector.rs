//! §3.16 «StartSeek. Старт поиска очага загорания», §3.13 «StartJustify», §3.21 «Hotbeds».
//!
//! ```text
//!  Idle ──StartSeek, wrapped──▶ Deploying ──deployed──▶ Scanning ──analyse──▶ Measuring ──▶ Idle
//!    ├────StartSeek, deployed───────────────────────────▶   └──────no analyse──────────────▶ Idle
//!    └────StartJustify──▶ Aligning ──measured, or nothing to measure──▶ Idle
//!
//!  Stop, a fault: Idle, a search with Canceled. A StartSeek during a search starts it again.
//! ```
//! §D/6 What a detector that comes and goes has not seen is not passed by: the barrel waits for it, and what was found is
//! given up by pictures alone that show it no more. A search that could not see a part of its sector says so: Canceled,
//! or DeviceFault.

mod hotbeds;
mod samples;
#[cfg(test)]
mod tests;

use super::control::approach::{self, Approach, Direction, POINTING, Progress};
use super::control::raster::{Area, Raster};
use super::{Env, of_axis};
use crate::cause::{Asked, Cause, Program, Rule};
use crate::image::{Axis, SPOTS};
use crate::inputs::{LASTED, lasted};
use crate::params::Params;
use crate::time::{Millis, Timer};
use hotbeds::{Hotbeds, centre, joined, near};
use lafet_proto::Status;
use lafet_proto::flags::DetectorFlags;
use lafet_proto::param::Param;
use lafet_proto::request::Seek;
use lafet_proto::status::{Hotbed, Limits};
use samples::{Measured, Samples};

/// §3.13 Where the reference source is (ours): straight ahead, level with the barrel.
const REFERENCE: Direction = Direction { horizontal: 0, vertical: 0 };
/// The barrel swings a little when it stops, and the picture is from before.
const SETTLE_MS: u32 = 300;
/// Stay at each end of a line: what is seen only there is seen several times.
const DWELL_MS: u32 = 200;
/// Fastest search, 0.1 °/s: a picture is up to 20 ms old, which makes 12' at this speed.
const SCAN_TENTHS_MAX: i32 = 100;
/// A detector that is not ready for this long, less the time in which it is, ends what it does, ms.
const SILENCE_MS: u32 = 1000;
/// Largest scatter of the reference source, arc-minutes: more is not one source, or it moves.
const SCATTER_ARCMIN: i32 = 15;
/// Largest angle between detector and barrel: what JustifyHorizontal and JustifyVertical take.
const JUSTIFY_ARCMIN: i32 = 600;

/// Its programs.
pub(crate) const PROGRAMS: [Program; 2] = [Program::Seek, Program::Justify];

/// What it does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Idle,
    /// §3.16/3: the monitor deploys first.
    Deploying(Search),
    Scanning {
        search: Search,
        /// Not yet laid at the start.
        raster: Option<Raster>,
        dwell: Timer,
    },
    /// §3.16/6: the second pass, one hotbed after another.
    Measuring {
        index: usize,
    },
    /// §3.13/1
    Aligning,
}

/// What is to be searched.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Search {
    sector: Area,
    analyse: bool,
}

/// The fire detector.
#[derive(Clone, Debug, PartialEq)]
pub struct Detector {
    state: State,
    /// What is being measured, or aligned, at rest.
    samples: Option<Samples>,
    /// Of what it moves.
    cause: Cause,
    hotbeds: Hotbeds,
    approach: Approach,
    /// For how long it has shown nothing, less the time in which it has, ms.
    silence: u32,
    /// For how long it has been ready, ms.
    back_ms: u8,
    /// That has lasted.
    is_back: bool,
    ready: bool,
    saturated: bool,
    dirty_lens: bool,
    /// What only a next start clears.
    latched: DetectorFlags,
}

impl Default for Detector {
    #[inline(never)]
    fn default() -> Self {
        Self {
            state: State::Idle,
            samples: None,
            cause: Cause::Rule(Rule::Inert),
            hotbeds: Hotbeds::default(),
            approach: Approach::default(),
            silence: 0,
            back_ms: LASTED,
            is_back: true,
            ready: true,
            saturated: false,
            dirty_lens: false,
            latched: DetectorFlags::empty(),
        }
    }
}

impl Detector {
    /// A search runs, or waits for the deployment.
    pub fn is_searching(&self) -> bool {
        matches!(self.state, State::Deploying(_) | State::Scanning { .. } | State::Measuring { .. })
    }

    /// Detector and barrel are being aligned.
    pub fn is_justifying(&self) -> bool {
        self.state == State::Aligning
    }

    /// §3.21 What the last search has found, brightest first.
    pub fn hotbeds(&self) -> &[Hotbed] {
        self.hotbeds.as_slice()
    }

    /// §3.16 StartSeek.
    pub(crate) fn start_seek(&mut self, seek: &Seek, by: Asked, env: &Env<'_>) -> Status {
        let Seek { start_h, end_h, start_v, end_v, analyse } = *seek;
        // §3.16/6
        let analyse = match analyse {
            0 => false,
            1 => true,
            _ => return Status::INVALID_VALUE,
        };
        // §3.16/2
        let sector = Area {
            right: start_h.min(end_h).into(),
            left: start_h.max(end_h).into(),
            bottom: start_v.min(end_v).into(),
            top: start_v.max(end_v).into(),
        };
        let limits = |axis| of_axis(env.drives, axis).limits();
        if sector.clip(limits(Axis::Horizontal), limits(Axis::Vertical)) != Some(sector) {
            // A search that runs goes on, and its flags are its own.
            if !self.is_searching() {
                self.latched |= DetectorFlags::BAD_SECTOR;
            }
            return Status::INVALID_VALUE;
        }
        if let Err(status) = check(env) {
            return status;
        }
        let search = Search { sector, analyse };
        self.cause = Cause::Program(Program::Seek, by);
        self.state = if env.deployed { State::scanning(search) } else { State::Deploying(search) };
        self.samples = None;
        self.hotbeds = Hotbeds::default();
        self.approach = Approach::default();
        self.silence = 0;
        // §3.13: Justified reports the last alignment, whatever is searched.
        self.latched &= DetectorFlags::JUSTIFIED;
        Status::ACCEPTED
    }

    /// §3.13 StartJustify.
    pub(crate) fn start_justify(&mut self, by: Asked, env: &Env<'_>) -> Status {
        // §3.13/2
        if self.is_justifying() {
            return Status::ACCEPTED;
        }
        if let Err(status) = check(env) {
            return status;
        }
        self.cause = Cause::Program(Program::Justify, by);
        self.state = State::Aligning;
        self.samples = None;
        self.approach = Approach::default();
        self.silence = 0;
        self.latched -=
            DetectorFlags::JUSTIFIED | DetectorFlags::DEVICE_FAULT | DetectorFlags::INTERNAL_FAULT;
        Status::ACCEPTED
    }

    /// §3.16/7, §3.13/3 Ends the search or the alignment; the caller stops the drives.
    pub(crate) fn stop(&mut self) {
        if self.is_searching() {
            self.latched |= DetectorFlags::CANCELED;
        }
        self.state = State::Idle;
        self.samples = None;
    }

    /// §D/6 Its picture cannot be of fires.
    pub(crate) const fn is_saturated(&self) -> bool {
        self.saturated
    }

    /// What its flags say of the detector itself.
    pub(crate) fn sense(&mut self, env: &Env<'_>) {
        self.saturated = is_saturated(env);
        self.ready = env.inputs.detector.ready && !self.saturated;
        self.dirty_lens = env.inputs.detector.dirty_lens;
        self.is_back = lasted(&mut self.back_ms, env.dt_ms, env.inputs.detector.ready);
    }

    /// Runs the search or the alignment.
    #[inline(never)]
    pub(crate) fn step(&mut self, now: Millis, env: &mut Env<'_>) {
        self.sense(env);
        match self.state {
            State::Idle => return,
            // §3.16/7
            State::Deploying(_) if env.deploy_failed => {
                return self.fail(DetectorFlags::empty(), env);
            }
            State::Deploying(_) if !env.deployed => return,
            State::Deploying(search) => self.state = State::scanning(search),
            State::Scanning { .. } | State::Measuring { .. } | State::Aligning => {}
        }
        if approach::is_faulty(env.drives, &POINTING) {
            self.fail(DetectorFlags::INTERNAL_FAULT, env);
        } else if !env.deployed
            || !approach::can_aim(env.drives, &POINTING)
            || self.is_silent(env.dt_ms)
        {
            self.fail(DetectorFlags::empty(), env);
        } else if !self.is_back {
            approach::stop(env.drives, &PROGRAMS, Cause::Rule(Rule::Fault));
        } else {
            self.run(now, env);
        }
    }

    /// Flags but the common ones of the configuration.
    pub(crate) fn flags(&self) -> DetectorFlags {
        let mut flags = self.latched;
        flags.set(DetectorFlags::SEARCHING, self.is_searching());
        flags.set(DetectorFlags::JUSTIFYING, self.is_justifying());
        flags.set(DetectorFlags::FOUND, !self.hotbeds().is_empty());
        flags.set(DetectorFlags::DIRTY_LENS, self.dirty_lens);
        if !self.ready {
            flags |= DetectorFlags::DEVICE_FAULT;
        }
        flags
    }

    fn run(&mut self, now: Millis, env: &mut Env<'_>) {
        match self.state {
            State::Idle | State::Deploying(_) => {}
            State::Scanning { search, raster, dwell } => {
                let raster = raster.unwrap_or_else(|| search.lay(env));
                self.scan(now, search, raster, dwell, env);
            }
            State::Measuring { index } => self.measure(now, index, env),
            State::Aligning => self.align(now, env),
        }
    }

    /// §3.16/1 One pass over the sector.
    fn scan(
        &mut self,
        now: Millis,
        search: Search,
        mut raster: Raster,
        mut dwell: Timer,
        env: &mut Env<'_>,
    ) {
        let speed = raster.on_line().then(|| scan_tenths(env.params));
        let Some(there) = self.approach(now, raster.point(), speed, env) else {
            return;
        };
        if there || raster.on_line() {
            // As long as it stays at the end of a line.
            if self.saturated && self.silence > DWELL_MS {
                self.latched |= DetectorFlags::DEVICE_FAULT;
            }
            for seen in sightings(env, &mut Default::default()) {
                if search.covers(seen) {
                    self.hotbeds.see(*seen);
                }
            }
        }
        if there && dwell.poll(now) {
            if !raster.advance() {
                match search.analyse {
                    true => self.state = State::Measuring { index: 0 },
                    false => self.end(env),
                }
                return;
            }
        } else if there && !dwell.is_running() {
            dwell.start(now, DWELL_MS);
        }
        self.state = State::Scanning { search, raster: Some(raster), dwell };
    }

    /// §3.16/6 Looks straight at a hotbed and measures it at rest.
    fn measure(&mut self, now: Millis, index: usize, env: &mut Env<'_>) {
        let Some(expected) = self.hotbeds().get(index).copied() else {
            self.hotbeds.sort();
            return self.end(env);
        };
        let to = centre(&expected).minus(justification(env.params));
        let Some(there) = self.approach(now, to, None, env) else { return };
        // A hotbed may be several flames; what it was made of, it is measured by.
        let done = self.sample(now, there, &mut || {
            let mut list = Default::default();
            let flames = sightings(env, &mut list).iter().filter(|seen| near(seen, &expected));
            flames.copied().reduce(|a, b| joined(&a, &b))
        });
        let next = match done {
            None => return,
            Some(Some(measured)) => {
                self.hotbeds.replace(index, measured.mean);
                index + 1
            }
            // It flickers: it stays as it was found.
            Some(None) if self.samples.as_ref().is_some_and(Samples::have_shown) => index + 1,
            // It is not there any more: a spark, a reflection, or it has gone out.
            Some(None) => {
                self.hotbeds.remove(index);
                index
            }
        };
        self.samples = None;
        self.state = State::Measuring { index: next };
    }

    /// §3.13/1 Looks where the reference source is and measures where it seems to be.
    fn align(&mut self, now: Millis, env: &mut Env<'_>) {
        let Some(there) = self.approach(now, REFERENCE, None, env) else { return };
        let done = self.sample(now, there, &mut || match sightings(env, &mut Default::default()) {
            [one] => Some(*one),
            _ => None,
        });
        let Some(done) = done else { return };
        let found = done.filter(|measured| measured.scatter <= SCATTER_ARCMIN).map(|measured| {
            // As seen with the old values; the new ones make it seem where it is.
            REFERENCE.minus(centre(&measured.mean)).plus(justification(env.params))
        });
        match found {
            Some(Direction { horizontal, vertical })
                if horizontal.saturating_abs().max(vertical.saturating_abs()) <= JUSTIFY_ARCMIN =>
            {
                env.params.set_justify(horizontal, vertical);
                self.latched |= DetectorFlags::JUSTIFIED;
                self.end(env);
            }
            _ => self.fail(DetectorFlags::empty(), env),
        }
    }

    /// Measures once the barrel is there: the result, `None` in it without any.
    fn sample(
        &mut self,
        now: Millis,
        there: bool,
        picture: &mut dyn FnMut() -> Option<Hotbed>,
    ) -> Option<Option<Measured>> {
        if self.samples.is_none() && there {
            self.samples = Some(Samples::after(now, SETTLE_MS));
        }
        self.samples.as_mut()?.step(now, picture)
    }

    /// Takes the barrel to a direction; whether it is there, `None` when all has ended over it.
    fn approach(
        &mut self,
        now: Millis,
        to: Direction,
        speed: Option<i32>,
        env: &mut Env<'_>,
    ) -> Option<bool> {
        match self.approach.step(now, env.drives, to, speed, self.cause) {
            Progress::Going => Some(false),
            Progress::There => Some(true),
            Progress::Stuck => {
                self.fail(DetectorFlags::INTERNAL_FAULT, env);
                None
            }
        }
    }

    /// §3.16/7: a search is canceled; §3.13/1: an alignment ends in DeviceFault.
    fn fail(&mut self, flags: DetectorFlags, env: &mut Env<'_>) {
        self.latched |= flags;
        self.latched |= match self.is_justifying() {
            true => DetectorFlags::DEVICE_FAULT,
            false => DetectorFlags::CANCELED,
        };
        self.end(env);
    }

    /// The barrel stays where it is.
    fn end(&mut self, env: &mut Env<'_>) {
        self.state = State::Idle;
        self.samples = None;
        approach::stop(env.drives, &PROGRAMS, Cause::Rule(Rule::ProgramEnd));
    }

    fn is_silent(&mut self, dt_ms: u32) -> bool {
        self.silence = match self.ready && self.is_back {
            true => self.silence.saturating_sub(dt_ms),
            false => self.silence.saturating_add(dt_ms),
        };
        self.silence > SILENCE_MS
    }
}

impl State {
    fn scanning(search: Search) -> Self {
        Self::Scanning { search, raster: None, dwell: Timer::default() }
    }
}

impl Search {
    /// Lines close enough to see the whole sector; their ends need not be looked straight at.
    fn lay(&self, env: &Env<'_>) -> Raster {
        let field = env.params.get(Param::DetectorFieldOfView);
        let step = env.params.get(Param::DetectorScanStep).min(field);
        // A quarter of the field, not half: at the very edge of it nothing is seen for certain.
        let lines = self.sector.without_sides(field / 4);
        Raster::covering(lines, step, approach::direction(env.drives))
    }

    /// Whether some of it is in the sector.
    fn covers(&self, seen: &Hotbed) -> bool {
        let sector = Limits { min: self.sector.right, max: self.sector.left };
        let heights = Limits { min: self.sector.bottom, max: self.sector.top };
        Area { right: seen.x2, left: seen.x1, bottom: seen.y1, top: seen.y2 }
            .clip(Some(sector), Some(heights))
            .is_some()
    }
}

/// §3.3.7/1; a drive that cannot be taken to a position cannot search.
fn check(env: &Env<'_>) -> Result<(), Status> {
    if is_blind(env) || approach::is_faulty(env.drives, &POINTING) {
        return Err(Status::MODULE_FAULT);
    }
    if approach::can_aim(env.drives, &POINTING) { Ok(()) } else { Err(Status::DENIED) }
}

/// §D/6 What it shows says nothing: that of a detector which is not ready may be an old picture.
fn is_blind(env: &Env<'_>) -> bool {
    !env.inputs.detector.ready || is_saturated(env)
}

/// §D/6 Fires may be as wide as the field of view, and one may fill it. That all are, or two fill it, is a
/// picture of light, not of fires.
fn is_saturated(env: &Env<'_>) -> bool {
    let field = env.params.get(Param::DetectorFieldOfView);
    let (mut wide, mut full) = (0, 0);
    for spot in env.inputs.detector.spots.iter().flatten() {
        let width = i32::from(spot.left) - i32::from(spot.right);
        let height = i32::from(spot.top) - i32::from(spot.bottom);
        wide += usize::from(width >= field);
        full += usize::from(width.min(height) >= field);
    }
    wide == SPOTS || full > 1
}

/// Each place stays in the field of view for a second.
fn scan_tenths(params: &Params) -> i32 {
    (params.get(Param::DetectorFieldOfView) / 6).clamp(1, SCAN_TENTHS_MAX)
}

/// The angle of the detector's axis to the barrel.
fn justification(params: &Params) -> Direction {
    Direction {
        horizontal: params.get(Param::DetectorJustifyHorizontal),
        vertical: params.get(Param::DetectorJustifyVertical),
    }
}

/// The spots that count, where they are in the monitor's own angles.
fn sightings<'l>(env: &Env<'_>, list: &'l mut [Hotbed; SPOTS]) -> &'l [Hotbed] {
    let threshold = env.params.get(Param::DetectorThreshold);
    let axis = approach::direction(env.drives).plus(justification(env.params));
    let believed = !is_blind(env);
    let spots = env.inputs.detector.spots.iter().flatten();
    let bright = spots.filter(|spot| believed && spot.brightness >= threshold);
    let mut len = 0;
    for (place, spot) in list.iter_mut().zip(bright) {
        *place = Hotbed {
            x1: axis.horizontal.saturating_add(spot.left.into()),
            x2: axis.horizontal.saturating_add(spot.right.into()),
            y1: axis.vertical.saturating_add(spot.bottom.into()),
            y2: axis.vertical.saturating_add(spot.top.into()),
            brightness: spot.brightness,
        };
        len += 1;
    }
    list.get(..len).unwrap_or_default()
}
