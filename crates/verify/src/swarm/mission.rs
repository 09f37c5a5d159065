//! What an operator does, step by step: so that what a monitor is for is seen too.

use lafet_device::Composition;
use lafet_proto::request::{Body, Quench, Sector, Seek, Trajectory, TrajectoryPoint};
use lafet_proto::request::{Path, Points};
use lafet_proto::{Ints, ParamId, Request, SubsystemId};
use lafet_sim::fire::FireSpec;
use lafet_sim::rng::Rng;

use super::requests::{factory, number, payload, pick};

/// A step: records to deliver, and how long to look on.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub payload: Vec<u8>,
    pub ms: u64,
}

fn step(to: SubsystemId, body: Body<'_>, ms: u64) -> Step {
    Step { payload: payload(&Request::new(to, body)), ms }
}

fn request(request: Request<'_>, ms: u64) -> Step {
    Step { payload: payload(&request), ms }
}

/// Deploy, search, extinguish, wrap.
pub(super) fn extinguish(rng: &mut Rng, fires: &[FireSpec]) -> Vec<Step> {
    let fire = if fires.is_empty() { FireSpec::default() } else { pick(rng, fires) };
    let azimuth = libm::round(fire.azimuth_deg * 60.0) as i16;
    let mut steps = vec![step(SubsystemId::DEPLOYER, Body::Deploy, 12_000)];
    if rng.chance(0.5) {
        let seek = Seek {
            start_h: azimuth - 600,
            end_h: azimuth + 600,
            start_v: -300,
            end_v: 120,
            analyse: number(rng, 0, 1) as i16,
        };
        steps.push(step(SubsystemId::DETECTOR, Body::StartSeek(seek), 25_000));
    }
    // The line of sight to the foot of the fire, from 1.5 m above the ground.
    let down = libm::round(libm::atan2(-1.5, fire.range_m).to_degrees() * 60.0) as i16;
    let swept = rng.chance(0.4);
    let sector = Sector {
        centre_h: azimuth,
        centre_v: down,
        nozzle: 60,
        width: if swept { 240 } else { 0 },
        height: if swept { 60 } else { 0 },
        step: i8::from(swept),
    };
    let full = Quench::Full { sector, distance: fire.range_m as i8 };
    let point = TrajectoryPoint {
        horizontal: azimuth,
        vertical: down,
        distance: fire.range_m as u8,
        dwell: 20,
    };
    let beside = TrajectoryPoint { horizontal: azimuth.saturating_add(60), ..point };
    let points = [point, beside];
    let trajectory =
        Trajectory { ballistics: true, repeat: true, path: Path::Points(Points::Values(&points)) };
    steps.push(match rng.bits() % 4 {
        0 => step(SubsystemId::CONTROL, Body::StartTrajectory(trajectory), 4_000),
        _ => step(SubsystemId::CONTROL, Body::StartQuench(full), 4_000),
    });
    steps.push(request(Request::open(SubsystemId::VALVE1), 30_000 + rng.bits() % 30_000));
    if rng.chance(0.4) {
        let destination = azimuth.saturating_add(120);
        steps.push(step(SubsystemId::HORIZONTAL, Body::Move { destination }, 8_000));
    }
    steps.push(request(Request::close(SubsystemId::VALVE1), 5_000));
    steps.push(step(SubsystemId::CONTROL, Body::Stop, 500));
    steps.push(step(SubsystemId::DEPLOYER, Body::Wrap, 25_000));
    steps
}

/// Aim by hand, close to the ends and with the clock of MoveTimeout running.
pub(super) fn aim(rng: &mut Rng) -> Vec<Step> {
    let mut steps = vec![step(SubsystemId::DEPLOYER, Body::Deploy, 11_000)];
    if rng.chance(0.4) {
        let values = [number(rng, 300, 3000)];
        let (id, values) = (ParamId::of("MoveTimeout"), Ints::Values(&values));
        steps.push(step(SubsystemId::GENERAL, Body::SetParam { id, values }, 100));
    }
    if rng.chance(0.3) {
        // New limits while it moves.
        let values = [number(rng, 60, 900)];
        let (id, values) = (ParamId::of("MaxLimit"), Ints::Values(&values));
        let up = Body::Move { destination: 3000 };
        steps.push(step(SubsystemId::VERTICAL, up, 1_500 + rng.bits() % 3_000));
        steps.push(step(SubsystemId::VERTICAL, Body::SetParam { id, values }, 1_000));
    }
    for _ in 0..4 {
        let to = pick(rng, &[SubsystemId::VERTICAL, SubsystemId::HORIZONTAL, SubsystemId::NOZZLE]);
        let destination = pick(rng, &[21_600, -21_600, 0, 600, -600]);
        steps.push(step(to, Body::Move { destination }, 500 + rng.bits() % 6_000));
    }
    steps
}

/// Deploy, and drive each drive as far as it goes: one whose position sensor counts is homed there.
pub(super) fn home() -> Vec<Step> {
    let mut steps = vec![step(SubsystemId::DEPLOYER, Body::Deploy, 11_000)];
    for (to, destination) in [
        (SubsystemId::NOZZLE, i16::MAX),
        (SubsystemId::VERTICAL, -i16::MAX),
        (SubsystemId::HORIZONTAL, i16::MAX),
    ] {
        steps.push(step(to, Body::Move { destination }, 25_000));
    }
    steps
}

/// Fold and unfold with doubts.
pub(super) fn fold(rng: &mut Rng) -> Vec<Step> {
    let mut steps = Vec::new();
    for _ in 0..4 {
        let destination = number(rng, -100, 5500) as i16;
        let body = match rng.bits() % 5 {
            0 | 1 => Body::Deploy,
            2 | 3 => Body::Wrap,
            _ => Body::Move { destination },
        };
        steps.push(step(SubsystemId::DEPLOYER, body, 500 + rng.bits() % 14_000));
        if rng.chance(0.2) {
            steps.push(step(SubsystemId::DEPLOYER, Body::Stop, 500));
        }
    }
    steps
}

/// Water that is confirmed for a while, and then not.
pub(super) fn leave_open(rng: &mut Rng) -> Vec<Step> {
    let values = [number(rng, 5, 20)];
    let (id, values) = (ParamId::of("WaterTimeout"), Ints::Values(&values));
    let mut steps = vec![
        step(SubsystemId::DEPLOYER, Body::Deploy, 12_000),
        step(SubsystemId::GENERAL, Body::SetParam { id, values }, 100),
    ];
    for _ in 0..1 + rng.bits() % 3 {
        steps.push(request(Request::open(SubsystemId::VALVE1), 2_000 + rng.bits() % 6_000));
    }
    if let Some(last) = steps.last_mut() {
        last.ms = 25_000;
    }
    steps
}

/// Align detector and barrel.
pub(super) fn justify() -> Vec<Step> {
    vec![
        step(SubsystemId::DEPLOYER, Body::Deploy, 12_000),
        step(SubsystemId::DETECTOR, Body::StartJustify, 15_000),
    ]
}

/// Lock out, and release after a while.
pub(super) fn lock_out(rng: &mut Rng) -> Vec<Step> {
    vec![
        request(Request::lockout(true), 200 + rng.bits() % 8_000),
        request(Request::lockout(false), 500),
    ]
}

/// Set everything to what the factory has set, then restart: also the way out of an empty memory.
pub(super) fn service(composition: &Composition) -> Vec<Step> {
    let mut steps: Vec<Step> =
        factory(composition).into_iter().map(|payload| Step { payload, ms: 20 }).collect();
    steps.push(step(SubsystemId::ALL, Body::Restart, 1_000));
    steps
}

/// Erase the memory, then set everything again.
pub(super) fn erase(composition: &Composition) -> Vec<Step> {
    let body = Body::CleanFlash { key: lafet_proto::id::key::CLEAN_FLASH };
    let mut steps = vec![step(SubsystemId::GENERAL, body, 1_000)];
    steps.extend(service(composition));
    steps
}
