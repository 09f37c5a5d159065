//! §3.14, §3.15: extinguishing in a sector and along a trajectory. Nothing here opens a valve.

use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::conform as text;

use super::motion::{limits, room};
use super::{bits, le, les};
use crate::bench::Bench;
use crate::raw::Rec;
use crate::safety::VALVES;
use crate::verdict::{Step, must, not_applicable};

pub const START_MS: u64 = 3000;

pub fn centre(b: &mut Bench<'_>) -> Step<(i32, i32)> {
    b.needs(S::HORIZONTAL)?;
    b.needs(S::VERTICAL)?;
    let (_, h) = b.drive(S::HORIZONTAL)?;
    let (_, v) = b.drive(S::VERTICAL)?;
    let (h_min, h_max) = limits(b, S::HORIZONTAL)?;
    let (v_min, v_max) = limits(b, S::VERTICAL)?;
    Ok((h.clamp(h_min + 400, h_max - 400), v.clamp(v_min + 300, v_max - 300)))
}

/// Data of a full StartQuench: seven numbers, of which the last two are bytes.
pub fn program(h: i32, v: i32, width: i32, height: i32, step: u8, distance: u8) -> Vec<u8> {
    let mut data = les(&[h, v, 30, width, height]);
    data.extend([step, distance]);
    data
}

pub fn movers(b: &mut Bench<'_>) {
    b.moves(&[S::HORIZONTAL, S::VERTICAL, S::NOZZLE, S::DEPLOYER]);
}

/// Starts a program; returns its centre.
pub fn quench(b: &mut Bench<'_>) -> Step<(i32, i32)> {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (h, v) = centre(b)?;
    movers(b);
    let data = program(h, v, 300, 120, 1, 0);
    b.want(R::START_QUENCH, S::CONTROL, &data, S::CONTROL, &[Status::ACCEPTED, Status::OK])?;
    b.until_flags(S::CONTROL, bits::QUENCH, 0, START_MS)?;
    Ok((h, v))
}

pub fn ends(b: &mut Bench<'_>) -> Step {
    b.done(R::STOP, S::CONTROL, &[])?;
    b.until_flags(S::CONTROL, 0, bits::QUENCH | bits::TRAJECTORY, START_MS)
}

/// §3.14/1: the jet covers the sector.
pub fn quench_scans(b: &mut Bench<'_>) -> Step {
    let (h, v) = quench(b)?;
    let (mut left, mut right, mut low, mut high) = (i32::MIN, i32::MAX, i32::MAX, i32::MIN);
    b.until(60_000, text::WholeSector, |b| {
        let (_, x) = b.drive(S::HORIZONTAL)?;
        let (_, y) = b.drive(S::VERTICAL)?;
        left = left.max(x);
        right = right.min(x);
        low = low.min(y);
        high = high.max(y);
        must(
            x.abs_diff(h) <= 150 + 60,
            text::WithinSector,
            format!("{x}' of {h}' ± 150', {y}' of {v}'"),
        )
        .or_else(|halt| if left == x || right == x { Ok(()) } else { Err(halt) })?;
        Ok(left >= h + 120 && right <= h - 120 && high - low >= 40)
    })?;
    ends(b)
}

/// §3.14/7: a program does not open the valve.
pub fn quench_leaves_closed(b: &mut Bench<'_>) -> Step {
    b.one_of(&VALVES)?;
    quench(b)?;
    b.wait(1500)?;
    ends(b)?;
    for id in VALVES {
        if b.has(id) {
            let flags = b.flags(id)?;
            must(
                flags & bits::CLOSED != 0,
                text::ClosedValveStaysClosed,
                format!("{flags:#010x}"),
            )?;
        }
    }
    Ok(())
}

/// §3.14, §3.14/4
pub fn quench_sizes(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    for size in [0, 1, 7, 9, 10, 11] {
        b.refused(R::START_QUENCH, S::CONTROL, &vec![0; size], S::CONTROL, Status::WRONG_DATA)?;
    }
    idle(b)
}

fn idle(b: &mut Bench<'_>) -> Step {
    let flags = b.flags(S::CONTROL)?;
    must(
        flags & (bits::QUENCH | bits::TRAJECTORY) == 0,
        text::NoProgramRuns,
        format!("{flags:#010x}"),
    )
}

pub fn quench_values(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (h, v) = centre(b)?;
    for number in [8, -1, 255] {
        let data = les(&[number, h, v, 30]);
        b.refused(R::START_QUENCH, S::CONTROL, &data, S::CONTROL, Status::INVALID_VALUE)?;
    }
    let data = program(h, v, -1, 100, 1, 0);
    b.refused(R::START_QUENCH, S::CONTROL, &data, S::CONTROL, Status::INVALID_VALUE)?;
    idle(b)
}

/// §3.14/2
pub fn simplified(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (h, v) = centre(b)?;
    movers(b);
    b.done(R::START_QUENCH, S::CONTROL, &les(&[7, h + 60, v, 30]))?;
    b.until_flags(S::CONTROL, bits::QUENCH, 0, START_MS)?;
    ends(b)
}

/// §3.14/3: distance 0 aims along the line of sight, a distance raises the barrel; so does a table.
pub fn elevation(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (h, v) = centre(b)?;
    movers(b);
    // A correction of 5° at any pressure: the last entry applies to all higher ones.
    let mut data = les(&[h, v, 30, 0, 0]);
    data.push(0);
    data.extend([5, 5]);
    b.done(R::START_QUENCH, S::CONTROL, &data)?;
    b.until(20_000, text::RaisedByCorrection, |b| {
        Ok((b.drive(S::VERTICAL)?.1 - (v + 300)).abs() <= 15)
    })?;
    ends(b)
}

/// §3.14/1: with step 0 and no size, the centre.
pub fn aims_at_centre(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (h, v) = centre(b)?;
    let (sign, _) = room(b, S::HORIZONTAL)?;
    let target = h + sign * 120;
    movers(b);
    if b.get(S::CONTROL, "Ballistics")?.is_some() {
        b.set(S::CONTROL, "Ballistics", 0)?;
    }
    b.done(R::START_QUENCH, S::CONTROL, &program(target, v, 0, 0, 0, 0))?;
    b.until(20_000, text::AimedAtCentre, |b| {
        let (_, x) = b.drive(S::HORIZONTAL)?;
        let (_, y) = b.drive(S::VERTICAL)?;
        Ok(x.abs_diff(target) <= 15 && y.abs_diff(v) <= 15)
    })?;
    let faults = b.flags(S::CONTROL)? & bits::BALLISTICS;
    must(faults == 0, text::NoBallisticsFault, format!("{faults:#010x}"))?;
    ends(b)
}

/// §3.3.6/5: along a path without ballistics the jet is the narrowest.
pub fn narrowest(b: &mut Bench<'_>) -> Step {
    b.needs(S::NOZZLE)?;
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (h, v) = centre(b)?;
    let (_, max) = limits(b, S::NOZZLE)?;
    movers(b);
    if b.drive(S::NOZZLE)?.1.abs_diff(max) <= 2 {
        b.done(R::MOVE, S::NOZZLE, &le(max - 20))?;
        b.until_flags(S::NOZZLE, 0, bits::MOVE, 60_000)?;
    }
    b.done(R::START_TRAJECTORY, S::CONTROL, &points(2, &[(h + 60, v), (h - 60, v)]))?;
    b.until(30_000, text::NarrowestJet, |b| Ok(b.drive(S::NOZZLE)?.1.abs_diff(max) <= 2))?;
    ends(b)
}

/// §3.1/3
pub fn pause(b: &mut Bench<'_>) -> Step {
    quench(b)?;
    b.wait(1500)?;
    let (_, from) = b.drive(S::HORIZONTAL)?;
    let asked_ms = b.now_ms();
    b.done(R::MOVE, S::HORIZONTAL, &le(from + 30))?;
    b.until_flags(S::CONTROL, bits::PAUSED | bits::QUENCH, 0, 1000)?;
    b.wait(2000)?;
    let flags = b.flags(S::CONTROL)?;
    must(
        flags & bits::PAUSED != 0 || b.now_ms() - asked_ms > 2900,
        text::PausedFor3S,
        format!("{flags:#010x}"),
    )?;
    b.until_flags(S::CONTROL, bits::QUENCH, bits::PAUSED, 2500)?;
    ends(b)
}

/// §3.1/3: the addressee of Move moves.
pub fn pause_moves(b: &mut Bench<'_>) -> Step {
    let (h, _) = quench(b)?;
    b.wait(1000)?;
    let (sign, _) = room(b, S::HORIZONTAL)?;
    let to = h + sign * 330;
    b.done(R::MOVE, S::HORIZONTAL, &le(to))?;
    b.until(6000, text::WhereMoveSent, |b| Ok(b.drive(S::HORIZONTAL)?.1.abs_diff(to) <= 15))?;
    let mut away = false;
    b.until(15_000, text::OnAroundPointReached, |b| {
        let x = b.drive(S::HORIZONTAL)?.1;
        away |= x.abs_diff(to) > 60;
        Ok(away && (x - to) * sign > 60)
    })?;
    ends(b)
}

/// §3.2/4
pub fn stop_while_quenching(b: &mut Bench<'_>) -> Step {
    quench(b)?;
    for id in [S::HORIZONTAL, S::VERTICAL, S::NOZZLE, S::VALVE1, S::DETECTOR] {
        if b.has(id) {
            b.refused(R::STOP, id, &[], S::CONTROL, Status::DENIED)?;
        }
    }
    let flags = b.flags(S::CONTROL)?;
    must(flags & bits::QUENCH != 0, text::ProgramGoesOn, format!("{flags:#010x}"))?;
    ends(b)?;
    for id in [S::HORIZONTAL, S::VERTICAL] {
        b.until_flags(id, 0, bits::MOVE, START_MS)?;
    }
    Ok(())
}

/// §3.2/1
pub fn stop_all_while_quenching(b: &mut Bench<'_>) -> Step {
    quench(b)?;
    b.frame(&Rec::new(R::STOP, S::ALL, &[]).bytes())?;
    b.until_flags(S::CONTROL, 0, bits::QUENCH, START_MS)?;
    b.until_flags(S::HORIZONTAL, 0, bits::MOVE, START_MS)
}

/// §3.14/8, §3.3.6/3, §3.3.6/4
pub fn outside(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (_, v) = centre(b)?;
    let (_, max) = limits(b, S::HORIZONTAL)?;
    let (_, at) = b.drive(S::HORIZONTAL)?;
    b.param(S::HORIZONTAL, "MaxLimit")?;
    b.set(S::HORIZONTAL, "MaxLimit", (at + 200).min(max))?;
    let max = (at + 200).min(max);
    movers(b);
    b.done(R::START_QUENCH, S::CONTROL, &program(max, v, 400, 60, 1, 0))?;
    b.until_flags(S::CONTROL, bits::QUENCH | bits::OUTSIDE, 0, 20_000)?;
    b.stays(6000, text::InsideLimits, |b| Ok(b.drive(S::HORIZONTAL)?.1 <= max + 10))?;
    ends(b)?;
    let flags = b.flags(S::CONTROL)?;
    must(flags & bits::OUTSIDE != 0, text::OutsideLimitsStays, format!("{flags:#010x}"))?;
    quench_inside(b)?;
    ends(b)
}

fn quench_inside(b: &mut Bench<'_>) -> Step {
    let (_, v) = centre(b)?;
    let (_, at) = b.drive(S::HORIZONTAL)?;
    b.done(R::START_QUENCH, S::CONTROL, &program(at - 300, v, 60, 60, 1, 0))?;
    b.until_flags(S::CONTROL, bits::QUENCH, bits::OUTSIDE, START_MS)
}

/// §3.14/8
pub fn wholly_outside(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (_, v) = centre(b)?;
    let (_, max) = limits(b, S::HORIZONTAL)?;
    if max > 30_000 {
        return not_applicable(text::NoSectorIsOutside);
    }
    let data = program(max + 1500, v, 100, 60, 1, 0);
    b.refused(R::START_QUENCH, S::CONTROL, &data, S::CONTROL, Status::INVALID_VALUE)?;
    b.until_flags(S::CONTROL, bits::OUTSIDE | bits::MODE_FAULT, bits::QUENCH, 1000)
}

/// §3.14/9
pub fn replaced(b: &mut Bench<'_>) -> Step {
    let (h, v) = quench(b)?;
    let (sign, _) = room(b, S::HORIZONTAL)?;
    let target = h + sign * 360;
    b.done(R::START_QUENCH, S::CONTROL, &program(target, v, 0, 0, 0, 0))?;
    b.until(20_000, text::NewSector, |b| Ok(b.drive(S::HORIZONTAL)?.1.abs_diff(target) <= 15))?;
    ends(b)
}

/// §3.14/5
pub fn quench_wrapped(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.wrapped()?;
    let (h, v) = centre(b)?;
    movers(b);
    b.done(R::START_QUENCH, S::CONTROL, &program(h, v, 200, 60, 1, 0))?;
    b.until_flags(S::DEPLOYER, bits::DEPLOYED, bits::DEPLOYING, 90_000)?;
    b.until_flags(S::CONTROL, bits::QUENCH, 0, START_MS)?;
    b.until_flags(S::HORIZONTAL, bits::MOVE, 0, 20_000)?;
    ends(b)
}

/// §3.14/10
pub fn deploy_stopped(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.wrapped()?;
    let (h, v) = centre(b)?;
    movers(b);
    b.done(R::START_QUENCH, S::CONTROL, &program(h, v, 200, 60, 1, 0))?;
    b.wait(1500)?;
    b.done(R::STOP, S::DEPLOYER, &[])?;
    b.until_flags(S::CONTROL, bits::MODE_FAULT, bits::QUENCH, START_MS)
}

/// §3.11/7
pub fn wrap_quenching(b: &mut Bench<'_>) -> Step {
    b.needs(S::DEPLOYER)?;
    quench(b)?;
    b.done(R::WRAP, S::DEPLOYER, &[])?;
    b.until_flags(S::CONTROL, 0, bits::QUENCH, START_MS)?;
    b.until_flags(S::DEPLOYER, bits::WRAPPED, bits::WRAPPING, 90_000)
}

pub fn points(flags: u8, points: &[(i32, i32)]) -> Vec<u8> {
    let mut data = vec![0, flags, u8::try_from(points.len()).unwrap_or(0)];
    for (h, v) in points {
        data.extend(les(&[*h, *v]));
        data.extend([0, 2]);
    }
    data
}

/// §3.15, §3.15/1, §3.3.6/2
pub fn trajectory(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (h, v) = centre(b)?;
    movers(b);
    b.done(R::START_TRAJECTORY, S::CONTROL, &points(0, &[(h + 90, v), (h - 90, v)]))?;
    b.until_flags(S::CONTROL, bits::TRAJECTORY, 0, START_MS)?;
    let mut first = false;
    b.until(30_000, text::PointAfterPointThenEnd, |b| {
        let x = b.drive(S::HORIZONTAL)?.1;
        let faults = b.flags(S::CONTROL)? & bits::BALLISTICS;
        must(faults == 0, text::NoBallisticsFault, format!("{faults:#010x}"))?;
        first |= x.abs_diff(h + 90) <= 15;
        let over = b.flags(S::CONTROL)? & bits::TRAJECTORY == 0;
        Ok(first && over && x.abs_diff(h - 90) <= 15)
    })
}

/// §3.15/1 repeat
pub fn trajectory_repeats(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (h, v) = centre(b)?;
    movers(b);
    b.done(R::START_TRAJECTORY, S::CONTROL, &points(2, &[(h + 40, v), (h - 40, v)]))?;
    b.wait(6000)?;
    let flags = b.flags(S::CONTROL)?;
    must(flags & bits::TRAJECTORY != 0, text::StartsOver, format!("{flags:#010x}"))?;
    ends(b)
}

/// §3.15/2
pub fn trajectory_empty(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    if b.get(S::CONTROL, "Trajectory7")?.is_none_or(|values| !values.is_empty()) {
        return not_applicable(text::TrajectoryInUse);
    }
    b.refused(R::START_TRAJECTORY, S::CONTROL, &[1, 0, 1, 7], S::CONTROL, Status::INVALID_ID)
}

/// §3.15/3
pub fn trajectory_refused(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    for (data, status) in [
        (&[0, 0, 2, 0, 0, 0, 0, 0, 0][..], Status::WRONG_DATA),
        (&[0, 0], Status::WRONG_DATA),
        (&[2, 0, 1, 0], Status::INVALID_VALUE),
        (&[1, 0, 1, 8], Status::INVALID_VALUE),
    ] {
        let rec = b.ask(R::START_TRAJECTORY, S::CONTROL, data)?;
        let good = [status, Status::WRONG_DATA].contains(&rec.status);
        must(good && rec.device == S::CONTROL, text::WrongDataOrInvalidValue, rec.words(true))?;
    }
    idle(b)
}

/// §3.15/4
pub fn trajectory_pause(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    b.deployed()?;
    let (h, v) = centre(b)?;
    movers(b);
    b.done(R::START_TRAJECTORY, S::CONTROL, &points(2, &[(h + 90, v), (h - 90, v)]))?;
    b.until_flags(S::CONTROL, bits::TRAJECTORY, 0, START_MS)?;
    b.done(R::MOVE, S::HORIZONTAL, &le(h))?;
    b.until_flags(S::CONTROL, bits::PAUSED, 0, 1000)?;
    b.refused(R::STOP, S::HORIZONTAL, &[], S::CONTROL, Status::DENIED)?;
    ends(b)
}
