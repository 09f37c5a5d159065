//! §3.3.6 notes 1–5: how much higher than the line of sight the barrel is aimed.

use super::Data;
use crate::image::Axis;
use crate::params::Params;
use crate::subsystem::{Env, of_axis};
use crate::time::{Millis, Timer};
use lafet_ballistics::{Fault, Jet, NARROWEST_MM, PRESSURE_DATM, Solver, Target};
use lafet_proto::flags::ControlFlags;
use lafet_proto::param::Param;

/// The elevation is not corrected more often, ms: the barrel should not hunt after the pumps.
const INTERVAL_MS: u32 = 500;
/// Change of the pressure that is worth a new calculation, 0.1 atm: a quarter of a metre at 40 m.
const DEADBAND_DATM: u16 = 2;
/// Pressure counts as risen when it has stayed within the dead band for this long, ms. Before,
/// what is too far now may soon be in reach, and a flag would stick (note 4).
const SETTLED_MS: u32 = 2000;

/// Steps of a shot's flight in a cycle: so many for each millisecond that it takes, and at most. A board
/// that makes a cycle each millisecond has no long one because of them.
const PIECES_PER_MS: u32 = 4;
const PIECES_MOST: u32 = 16;

/// Where the correction comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Law {
    /// Nowhere; ballistics were not asked for.
    Straight,
    /// Nowhere; ballistics were asked for, but the parameter has them off.
    Off,
    /// Ballistics over a distance, m.
    Distance(u8),
    /// The table sent with the program (§3.14/3).
    Given,
    /// The stored table (§3.6), where no distance is given.
    Stored,
}

/// How to aim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Aim {
    /// Higher by this much, arc-minutes, with the nozzle as asked.
    Raised(i32),
    /// Straight, with the narrowest jet.
    Direct,
}

/// What ballistics depend on, besides the place; a table, on the pressure alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Basis {
    pressure_datm: u16,
    nozzle_mm: i32,
    diameter_dmm: i32,
    above_ground_cm: i32,
}

impl Basis {
    fn still_holds(&self, now: &Self) -> bool {
        self.pressure_datm.abs_diff(now.pressure_datm) < DEADBAND_DATM
            && self.nozzle_mm == now.nozzle_mm
            && self.diameter_dmm == now.diameter_dmm
            && self.above_ground_cm == now.above_ground_cm
    }
}

/// The correction in force, and the calculation of the next one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Elevation {
    aim: Option<Aim>,
    /// That is for the present point; otherwise it is how the barrel was last raised.
    fresh: bool,
    /// What the last calculation, or that under way, is for.
    basis: Option<Basis>,
    solver: Option<Solver>,
    interval: Timer,
    level: Option<(u16, Millis)>,
    /// There is no pressure, or one that suits no jet.
    unsuited: bool,
    /// There was no solution, but the pressure has not been steady: it may still rise.
    rising: bool,
    /// RangeFault and AngleFault, until the next start (note 4).
    faults: ControlFlags,
}

impl Elevation {
    /// A program starts: nothing of the last one holds, but for how long the pressure has stood, and how it
    /// has raised the barrel.
    pub(super) fn restart(&mut self) {
        *self = Self { level: self.level, aim: self.aim, ..Self::default() };
    }

    /// The program ends: where the barrel points from now on is not its doing.
    pub(super) fn forget(&mut self) {
        self.aim = None;
    }

    /// Another point is to be hit: what is in force does not hold for it. The barrel is still raised by it: who
    /// corrects the aim now has that in view.
    pub(super) fn renew(&mut self) {
        self.fresh = false;
        self.basis = None;
        self.solver = None;
        self.interval.stop();
    }

    /// The last correction, arc-minutes.
    pub(super) fn raised(&self) -> i32 {
        match self.aim {
            Some(Aim::Raised(raised)) => raised,
            Some(Aim::Direct) | None => 0,
        }
    }

    /// PressureFault, RangeFault, AngleFault.
    pub(super) fn flags(&self) -> ControlFlags {
        let mut flags = self.faults;
        flags.set(ControlFlags::TRAJECTORY_PRESSURE_FAULT, self.unsuited || self.rising);
        flags
    }

    /// Follows the pressure; `None` while the first calculation for a point is under way.
    pub(super) fn step(
        &mut self,
        now: Millis,
        law: Law,
        sight_arcmin: i32,
        nozzle_mm: i32,
        data: &Data,
        env: &Env<'_>,
    ) -> Option<Aim> {
        self.interval.poll(now);
        match law {
            Law::Straight => self.decide(Aim::Raised(0)),
            // §3.3.6/5
            Law::Off => self.decide(Aim::Direct),
            // A distance of 0 asks for no ballistics: without a pressure there is no correction.
            Law::Stored => match env.pressure_datm {
                // §3.6/1
                Some(pressure) => {
                    self.look_up(now, pressure, |pressure| env.params.correction(pressure));
                }
                None => self.decide(Aim::Raised(0)),
            },
            Law::Given => match env.pressure_datm {
                Some(pressure) => self.look_up(now, pressure, |pressure| data.correction(pressure)),
                None => self.lose_pressure(),
            },
            Law::Distance(distance) => {
                match env.pressure_datm.filter(|pressure| PRESSURE_DATM.contains(pressure)) {
                    Some(pressure) => {
                        self.calculate(now, pressure, sight_arcmin, distance, nozzle_mm, env);
                    }
                    None => self.lose_pressure(),
                }
            }
        }
        self.aim.filter(|_| self.fresh)
    }

    fn put(&mut self, aim: Aim) {
        (self.aim, self.fresh) = (Some(aim), true);
    }

    fn decide(&mut self, aim: Aim) {
        self.put(aim);
        self.unsuited = false;
        self.rising = false;
    }

    /// §3.3.6/5, and note 4: the flag goes as soon as the pressure is back.
    fn lose_pressure(&mut self) {
        self.put(Aim::Direct);
        self.basis = None;
        self.solver = None;
        self.unsuited = true;
        self.rising = false;
    }

    /// §3.14/3, §3.6: degrees by pressure.
    fn look_up(&mut self, now: Millis, pressure: u16, table: impl Fn(u16) -> Option<i8>) {
        self.unsuited = false;
        if self.interval.is_running() {
            return;
        }
        self.interval.start(now, INTERVAL_MS);
        // The table is in whole degrees: at a step of it noise must not make the barrel nod. It may be replaced
        // meanwhile, so it is asked again.
        let held = self.basis.map(|basis| basis.pressure_datm);
        let held = held.filter(|held| held.abs_diff(pressure) < DEADBAND_DATM).unwrap_or(pressure);
        self.basis = Some(Basis { pressure_datm: held, ..Basis::default() });
        self.put(Aim::Raised(table(held).map_or(0, |degrees| i32::from(degrees) * 60)));
    }

    fn calculate(
        &mut self,
        now: Millis,
        pressure: u16,
        sight_arcmin: i32,
        distance_m: u8,
        nozzle_mm: i32,
        env: &Env<'_>,
    ) {
        self.unsuited = false;
        if let Some(solver) = &mut self.solver {
            let pieces = env.dt_ms.saturating_mul(PIECES_PER_MS).clamp(PIECES_PER_MS, PIECES_MOST);
            if let Some(result) = solver.steps(pieces as u8) {
                self.solver = None;
                self.conclude(now, sight_arcmin, within_limits(result, env));
            }
            return;
        }
        let basis = Basis {
            pressure_datm: pressure,
            nozzle_mm,
            diameter_dmm: env.params.get(Param::ControlNozzleDiameter),
            above_ground_cm: env.params.get(Param::ControlHeight),
        };
        let current = self.basis.is_some_and(|old| old.still_holds(&basis));
        if current || self.interval.is_running() {
            return;
        }
        self.interval.start(now, INTERVAL_MS);
        self.basis = Some(basis);
        match Jet::new(pressure, basis.diameter_dmm, nozzle_mm) {
            Ok(jet) => {
                let target = Target::new(sight_arcmin, distance_m, basis.above_ground_cm);
                self.solver = Some(Solver::new(jet, target));
            }
            Err(fault) => self.conclude(now, sight_arcmin, Err(fault)),
        }
    }

    fn conclude(&mut self, now: Millis, sight_arcmin: i32, result: Result<i32, Fault>) {
        let fault = match result {
            Ok(elevation) => {
                return self.decide(Aim::Raised(elevation.saturating_sub(sight_arcmin)));
            }
            Err(fault) => fault,
        };
        let risen = self.level.is_some_and(|(_, since)| now.since(since) >= SETTLED_MS);
        self.decide(Aim::Direct);
        match fault {
            Fault::Range if risen => self.faults |= ControlFlags::TRAJECTORY_RANGE_FAULT,
            Fault::Angle if risen => self.faults |= ControlFlags::TRAJECTORY_ANGLE_FAULT,
            Fault::Pressure | Fault::Range | Fault::Angle => {
                self.rising = true;
                self.basis = None;
            }
        }
    }

    /// Keeps the moment since when the pressure has been what it is, whether a program runs or not.
    pub(super) fn follow(&mut self, now: Millis, pressure: Option<u16>) {
        let Some(pressure) = pressure else {
            self.level = None;
            return;
        };
        let same = self.level.is_some_and(|(level, _)| level.abs_diff(pressure) <= DEADBAND_DATM);
        if !same {
            self.level = Some((pressure, now));
        }
    }
}

/// §3.3.6 TrajectoryAngleFault: the barrel cannot be raised that far.
fn within_limits(result: Result<i32, Fault>, env: &Env<'_>) -> Result<i32, Fault> {
    let elevation = result?;
    let limits = of_axis(env.drives, Axis::Vertical).limits();
    if limits.is_some_and(|limits| elevation > limits.max) {
        return Err(Fault::Angle);
    }
    Ok(elevation)
}

/// §3.3.6/2 Ballistics are on.
pub(super) fn ballistics_on(params: &Params) -> bool {
    params.get(Param::ControlBallistics) != 0
}

/// The nozzle for an aim: as asked, or the narrowest jet (§3.3.6/5).
pub(super) fn nozzle_for(aim: Option<Aim>, asked_mm: i32) -> i32 {
    if aim == Some(Aim::Direct) { NARROWEST_MM } else { asked_mm }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subsystem::control::bench::{Bench, CYCLE_MS, one};

    /// Aims over 25 m for a time; how many calculations have started.
    fn begun(bench: &mut Bench, elevation: &mut Elevation, nozzle_mm: i32, ms: u32) -> u32 {
        let data = Data::of(core::iter::empty());
        let mut begun = 0;
        for _ in 0..ms / CYCLE_MS {
            bench.cycle();
            elevation.follow(bench.now, bench.pressure_datm);
            let before = elevation.solver.is_some();
            let now = bench.now;
            elevation.step(now, Law::Distance(25), -120, nozzle_mm, &data, &bench.env());
            begun += u32::from(!before && elevation.solver.is_some());
        }
        begun
    }

    /// §3.14/3 It is calculated when something has changed that matters, and then once.
    #[test]
    fn calculates_when_something_changes() {
        let (mut bench, mut elevation) = (Bench::new(), Elevation::default());
        assert_eq!(begun(&mut bench, &mut elevation, 60, 5000), 1);
        bench.pressure_datm = Some(80);
        assert_eq!(begun(&mut bench, &mut elevation, 60, 5000), 0, "within the dead band");
        bench.pressure_datm = Some(81);
        assert_eq!(begun(&mut bench, &mut elevation, 60, 5000), 1);
        assert_eq!(begun(&mut bench, &mut elevation, 50, 5000), 1);
        bench.params.write(Param::ControlNozzleDiameter, one(&300));
        assert_eq!(begun(&mut bench, &mut elevation, 50, 5000), 1);
        bench.params.write(Param::ControlHeight, one(&200));
        assert_eq!(begun(&mut bench, &mut elevation, 50, 5000), 1);
    }

    /// The barrel does not hunt after the pumps: two calculations in a second at most.
    #[test]
    fn calculates_twice_a_second_at_most() {
        let (mut bench, mut elevation) = (Bench::new(), Elevation::default());
        let mut count = 0;
        for cycle in 0..1000 {
            bench.pressure_datm = Some(if cycle % 2 == 0 { 70 } else { 79 });
            count += begun(&mut bench, &mut elevation, 60, CYCLE_MS);
        }
        assert!((5..=20).contains(&count), "{count}");
    }
}
