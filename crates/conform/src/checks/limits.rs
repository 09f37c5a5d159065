//! §3.17: limits switched off, set to the present position, and switched on; with the valves
//! closed.

use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::conform as text;

use super::motion::{STOP_MS, arrives, go, limits, narrow, room, small};
use super::{bits, le};
use crate::bench::Bench;
use crate::raw::range;
use crate::safety::Undo;
use crate::verdict::{Step, must, not_applicable};

/// A drive of one of these types (0 encoder, 1 remote, 2 limit switches), and its type.
fn kind(b: &mut Bench<'_>, wanted: &[i32]) -> Step<(S, i32)> {
    b.deployed()?;
    for id in [S::HORIZONTAL, S::VERTICAL, S::NOZZLE] {
        if b.has(id) {
            let kind = b.param(id, "DriveType")?;
            if wanted.contains(&kind) {
                b.moves(&[id]);
                return Ok((id, kind));
            }
        }
    }
    not_applicable(text::NoSuchDrive)
}

fn switch(b: &mut Bench<'_>, id: S, state: i32) -> Step {
    if state == 0 {
        b.undo.push(Undo::Limits);
    }
    for _ in 0..20 {
        let rec = b.ask(R::SWITCH_LIMITS, id, &le(state))?;
        if rec.status != Status::BUSY {
            return must(
                rec.status.is_success() && rec.device == id,
                text::TakenOnceUnitFree,
                rec.words(true),
            );
        }
        b.wait(100)?;
    }
    must(false, text::BusyForMomentOnly, "Busy")
}

/// §3.17
pub fn switch_layout(b: &mut Bench<'_>) -> Step {
    let (id, _) = kind(b, &[0, 1])?;
    b.undo.push(Undo::Limits);
    for size in [0, 1, 3] {
        b.refused(R::SWITCH_LIMITS, id, &vec![0; size], id, Status::WRONG_DATA)?;
    }
    b.refused(R::SWITCH_LIMITS, S::GENERAL, &le(1), S::GENERAL, Status::WRONG_REQUEST)?;
    let limitless = b.flags(id)? & bits::LIMITLESS != 0;
    must(!limitless, text::LimitsStayOn, "Limitless")
}

/// §2/4
pub fn switch_value(b: &mut Bench<'_>) -> Step {
    let (id, _) = kind(b, &[0, 1])?;
    b.undo.push(Undo::Limits);
    for value in [3, 255, -1] {
        b.refused(R::SWITCH_LIMITS, id, &le(value), id, Status::INVALID_VALUE)?;
    }
    let limitless = b.flags(id)? & bits::LIMITLESS != 0;
    must(!limitless, text::NothingChanges, "Limitless")
}

/// §3.17/1
pub fn limits_off(b: &mut Bench<'_>) -> Step {
    let (id, _) = kind(b, &[0, 1])?;
    let before = limits(b, id)?;
    switch(b, id, 0)?;
    b.until_flags(id, bits::LIMITLESS, 0, 1000)?;
    must(limits(b, id)? == before, text::PreviousLimitsAreReported, "")?;
    switch(b, id, 1)?;
    b.until_flags(id, 0, bits::LIMITLESS, 1000)?;
    must(limits(b, id)? == before, text::SameLimitsAgain, "")
}

/// A limit that was set to the present position.
struct Taken {
    id: S,
    before: (i32, i32),
    after: (i32, i32),
    at: i32,
}

/// §3.17/2, §3.17/3: a limit set while limits are off comes into force with On, not with Reject.
fn take_limit(b: &mut Bench<'_>, end: i32) -> Step<Taken> {
    let (id, _) = kind(b, &[0, 1])?;
    let before = limits(b, id)?;
    let (_, at) = b.drive(id)?;
    b.undo.push(Undo::Param(id, "MinLimit", before.0));
    switch(b, id, 0)?;
    b.put(id, "MinLimit", at)?;
    let meanwhile = limits(b, id)?;
    must(meanwhile == before, text::OldLimitsUntilOn, range(id, meanwhile))?;
    switch(b, id, end)?;
    b.until_flags(id, 0, bits::LIMITLESS, 1000)?;
    Ok(Taken { id, before, after: limits(b, id)?, at })
}

pub fn limits_on(b: &mut Bench<'_>) -> Step {
    let Taken { id, before, after, at } = take_limit(b, 1)?;
    must(after == (at, before.1), text::LimitTakenIsInForce, range(id, after))
}

pub fn limits_reject(b: &mut Bench<'_>) -> Step {
    let Taken { id, before, after, .. } = take_limit(b, 2)?;
    must(after == before, text::OldLimits, range(id, after))
}

/// §3.17/4
pub fn switches_not_supported(b: &mut Bench<'_>) -> Step {
    let (id, _) = kind(b, &[2])?;
    for state in [0, 1, 2] {
        b.undo.push(Undo::Limits);
        b.refused(R::SWITCH_LIMITS, id, &le(state), id, Status::NOT_SUPPORTED)?;
    }
    Ok(())
}

/// §3.17/5
pub fn only_here(b: &mut Bench<'_>) -> Step {
    let (id, _) = kind(b, &[0, 1])?;
    let before = limits(b, id)?;
    let (_, at) = b.drive(id)?;
    b.undo.push(Undo::Param(id, "MaxLimit", before.1));
    b.undo.push(Undo::Param(id, "MinLimit", before.0));
    switch(b, id, 0)?;
    for (name, value) in [("MinLimit", at - 100), ("MaxLimit", at + 100)] {
        let rec = b.try_set(id, name, &[value])?;
        must(rec.status == Status::INVALID_VALUE, text::OnlyPresentPosition, rec.words(true))?;
    }
    Ok(())
}

/// §3.1/8
pub fn limitless(b: &mut Bench<'_>) -> Step {
    let (id, kind) = kind(b, &[0, 1])?;
    let (step, tolerance) = small(id);
    let (sign, from) = room(b, id)?;
    if kind == 1 {
        let (_, _, max) = narrow(b, id)?;
        switch(b, id, 0)?;
        go(b, id, max + step)?;
        arrives(b, id, max + step, tolerance)?;
        go(b, id, from)?;
        return arrives(b, id, from, tolerance);
    }
    let (min, max) = limits(b, id)?;
    if (max - from).max(from - min) < 10 * step {
        return not_applicable(text::TooLittleRoom);
    }
    switch(b, id, 0)?;
    go(b, id, from + sign)?;
    b.wait(1000)?;
    let moving = b.drive(id)?.0 & bits::MOVE != 0;
    must(moving, text::RunsOnUntilStopped, "")?;
    b.done(R::STOP, id, &[])?;
    b.until_flags(id, 0, bits::MOVE, STOP_MS)
}
