//! §3.1, §3.2, §3.7, §3.17: short, slow motions of drives, with the valves closed.

use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::conform as text;

use super::{bits, le};
use crate::bench::{Bench, list};
use crate::raw::Rec;
use crate::safety::{AIMING, REST_MS, VALVES};
use crate::verdict::{Step, must, not_applicable};

/// "Very far": the document's own value, arc-minutes.
pub const FAR: i32 = 21_600;
const SOON_MS: u64 = 400;
pub const STOP_MS: u64 = 3000;

/// Step of a small move and its tolerance, arc-minutes or mm.
pub fn small(id: S) -> (i32, i32) {
    if id == S::NOZZLE { (6, 2) } else { (150, 12) }
}

/// An aiming drive, in working position, allowed to move.
pub fn aimed(b: &mut Bench<'_>) -> Step<S> {
    let id = b.one_of(&AIMING)?;
    b.deployed()?;
    b.moves(&[id]);
    Ok(id)
}

pub fn limits(b: &mut Bench<'_>, id: S) -> Step<(i32, i32)> {
    let rec = b.read(R::RETRIEVE_LIMITS, id, &[])?;
    Ok((rec.i32_at(0).unwrap_or(0), rec.i32_at(4).unwrap_or(0)))
}

/// Direction in which there is room, and position of the drive.
pub fn room(b: &mut Bench<'_>, id: S) -> Step<(i32, i32)> {
    let (_, position) = b.drive(id)?;
    let (min, max) = limits(b, id)?;
    let up = max - position >= position - min;
    Ok((if up { 1 } else { -1 }, position))
}

pub fn go(b: &mut Bench<'_>, id: S, to: i32) -> Step {
    b.done(R::MOVE, id, &le(to))
}

pub fn arrives(b: &mut Bench<'_>, id: S, at: i32, tolerance: i32) -> Step {
    b.until(REST_MS, text::ArrivesAt { at, tolerance }, |b| {
        let (flags, position) = b.drive(id)?;
        Ok(flags & bits::MOVE == 0 && position.abs_diff(at) <= tolerance.unsigned_abs())
    })
}

fn nothing_moves(b: &mut Bench<'_>) -> Step {
    b.moves(&[]);
    b.wait(SOON_MS)?;
    b.watch()
}

/// §3.1/4, and the sign of §3.1/7: each drive moves there and back.
pub fn moves(b: &mut Bench<'_>) -> Step {
    aimed(b)?;
    for id in AIMING {
        if !b.has(id) {
            continue;
        }
        b.moves(&[id]);
        let (step, tolerance) = small(id);
        let (sign, from) = room(b, id)?;
        go(b, id, from + sign * step)?;
        arrives(b, id, from + sign * step, tolerance)?;
        go(b, id, from)?;
        arrives(b, id, from, tolerance)?;
    }
    Ok(())
}

/// §3.3.4/2
pub fn move_flag(b: &mut Bench<'_>) -> Step {
    let id = aimed(b)?;
    let (sign, from) = room(b, id)?;
    go(b, id, from + sign * 4 * small(id).0)?;
    b.until_flags(id, bits::MOVE, 0, 1000)?;
    b.until(2000, text::SpeedWhileMoves, |b| {
        Ok(b.read(R::GET_STATUS, id, &[])?.data.get(7).is_some_and(|speed| *speed > 0))
    })?;
    b.done(R::STOP, id, &[])?;
    b.until_flags(id, 0, bits::MOVE, STOP_MS)
}

/// §3.1, §2/3
pub fn move_sizes(b: &mut Bench<'_>) -> Step {
    let id = aimed(b)?;
    for size in [0, 1, 3, 4] {
        b.refused(R::MOVE, id, &vec![0x10; size], id, Status::WRONG_DATA)?;
    }
    let (_, at) = b.drive(id)?;
    go(b, id, at)?;
    nothing_moves(b)
}

/// §3.1/5
pub fn move_wrong_addressee(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    for id in b.found.present.clone() {
        if !id.is_drive() {
            b.refused(R::MOVE, id, &le(0), id, Status::WRONG_REQUEST)?;
        }
    }
    nothing_moves(b)
}

fn absent(b: &Bench<'_>) -> Vec<S> {
    S::CHAIN.into_iter().filter(|id| !b.has(*id)).chain([S(0x00)]).collect()
}

/// §3.1/6
pub fn move_absent(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    for id in absent(b) {
        b.refused(R::MOVE, id, &le(0), id, Status::MODULE_NOT_EXIST)?;
    }
    nothing_moves(b)
}

/// §1/7
pub fn move_all(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    for to in [S::ALL, S::MOTORS] {
        b.refused(R::MOVE, to, &le(300), S::GENERAL, Status::WRONG_REQUEST)?;
        b.refused(R::DEPLOY, to, &[], S::GENERAL, Status::WRONG_REQUEST)?;
        b.refused(R::SET_PARAM, to, &[1, 0, 0, 0, 0, 0], S::GENERAL, Status::WRONG_REQUEST)?;
    }
    nothing_moves(b)
}

/// Brings the limits close to the drive's position, in both directions.
pub fn narrow(b: &mut Bench<'_>, id: S) -> Step<(i32, i32, i32)> {
    let (step, _) = small(id);
    b.param(id, "MinLimit")?;
    b.param(id, "MaxLimit")?;
    let (_, position) = b.drive(id)?;
    let (min, max) = limits(b, id)?;
    let (min, max) = (min.max(position - step), max.min(position + step));
    b.set(id, "MinLimit", min)?;
    b.set(id, "MaxLimit", max)?;
    Ok((min, position, max))
}

/// §3.1/7, §3.3.4/2: up to the limit and no further.
pub fn to_the_limit(b: &mut Bench<'_>) -> Step {
    aimed(b)?;
    for id in AIMING {
        if !b.has(id) {
            continue;
        }
        b.moves(&[id]);
        let (min, from, max) = narrow(b, id)?;
        must(limits(b, id)? == (min, max), text::NewLimits, "")?;
        let tolerance = small(id).1;
        for (far, limit, flag) in [(FAR, max, bits::MAX_LIMIT), (-FAR, min, bits::MIN_LIMIT)] {
            go(b, id, far)?;
            arrives(b, id, limit, tolerance)?;
            b.until_flags(id, flag, bits::MOVE, 1000)?;
            b.wait(SOON_MS)?;
            arrives(b, id, limit, tolerance)?;
        }
        // Away from both limits, neither flag is set.
        let middle = (min + max) / 2;
        go(b, id, middle)?;
        arrives(b, id, middle, tolerance)?;
        b.until_flags(id, 0, bits::MAX_LIMIT | bits::MIN_LIMIT, 1000)?;
        go(b, id, from)?;
        arrives(b, id, from, tolerance)?;
    }
    Ok(())
}

/// §3.2/5
pub fn stop_drive(b: &mut Bench<'_>) -> Step {
    let id = aimed(b)?;
    let (sign, _) = room(b, id)?;
    go(b, id, sign * FAR)?;
    b.until_flags(id, bits::MOVE, 0, 1000)?;
    b.done(R::STOP, id, &[])?;
    b.until_flags(id, 0, bits::MOVE, STOP_MS)?;
    let (_, at) = b.drive(id)?;
    b.wait(600)?;
    let (_, later) = b.drive(id)?;
    must(at.abs_diff(later) <= 2, text::StaysAtRest, format!("{at}, {later}"))
}

/// §3.2/5: the other drives go on.
pub fn stop_one_of_two(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    b.needs(S::HORIZONTAL)?;
    b.needs(S::VERTICAL)?;
    b.moves(&[S::HORIZONTAL, S::VERTICAL]);
    let mut from = Vec::new();
    for id in [S::HORIZONTAL, S::VERTICAL] {
        let (sign, position) = room(b, id)?;
        from.push((id, position, sign));
        go(b, id, position + sign * 600)?;
    }
    b.until_flags(S::VERTICAL, bits::MOVE, 0, 1000)?;
    b.done(R::STOP, S::VERTICAL, &[])?;
    b.until_flags(S::VERTICAL, 0, bits::MOVE, STOP_MS)?;
    let (_, position, sign) = from[0];
    arrives(b, S::HORIZONTAL, position + sign * 600, 12)?;
    for (id, position, _) in from {
        go(b, id, position)?;
    }
    b.until_flags(S::HORIZONTAL, 0, bits::MOVE, REST_MS)?;
    b.until_flags(S::VERTICAL, 0, bits::MOVE, REST_MS)
}

/// §3.2/1
pub fn stop_all(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    b.one_of(&AIMING)?;
    b.moves(&AIMING);
    let mut moved = Vec::new();
    for id in [S::HORIZONTAL, S::VERTICAL] {
        if b.has(id) {
            let (sign, _) = room(b, id)?;
            go(b, id, sign * FAR)?;
            moved.push(id);
        }
    }
    b.wait(SOON_MS)?;
    let records = b.frame(&Rec::new(R::STOP, S::ALL, &[]).bytes())?;
    must(
        records.iter().all(|rec| rec.status.is_success()),
        text::OkOrAcceptedFromAll,
        list(&records),
    )?;
    for id in moved {
        b.until_flags(id, 0, bits::MOVE, STOP_MS)?;
    }
    nothing_moves(b)
}

/// §1/6
pub fn stop_motors(b: &mut Bench<'_>) -> Step {
    let id = aimed(b)?;
    let (sign, _) = room(b, id)?;
    go(b, id, sign * FAR)?;
    b.wait(SOON_MS)?;
    b.frame(&Rec::new(R::STOP, S::MOTORS, &[]).bytes())?;
    b.until_flags(id, 0, bits::MOVE, STOP_MS)
}

/// §1/9: requests without room for an answer are not executed, except Stop All.
pub fn no_room(b: &mut Bench<'_>) -> Step {
    b.several()?;
    let id = aimed(b)?;
    let (sign, _) = room(b, id)?;
    let many = Rec::new(R::GET_STATUS, S::ALL, &[]).bytes().repeat(60);
    let answers = b.frame(&many)?;
    if answers.iter().all(|rec| rec.status != Status::NO_ROOM) {
        return not_applicable(text::BufferHoldsAllAnswers);
    }
    let far = Rec::new(R::MOVE, id, &le(sign * FAR)).bytes();
    b.frame(&[many.clone(), far.clone()].concat())?;
    b.moves(&[]);
    b.wait(SOON_MS)?;
    let moving = b.drive(id)?.0 & bits::MOVE != 0;
    must(!moving, text::MoveAfterNoRoom, "Move")?;
    b.moves(&[id]);
    go(b, id, sign * FAR)?;
    b.until_flags(id, bits::MOVE, 0, 1000)?;
    b.frame(&[many, Rec::new(R::STOP, S::ALL, &[]).bytes()].concat())?;
    b.until_flags(id, 0, bits::MOVE, STOP_MS)
}

/// §1/8, §2/2: in their order, and nothing after a cut record.
pub fn in_order(b: &mut Bench<'_>) -> Step {
    b.several()?;
    let id = aimed(b)?;
    let (sign, _) = room(b, id)?;
    let far = Rec::new(R::MOVE, id, &le(sign * FAR)).bytes();
    let stop = Rec::new(R::STOP, id, &[]).bytes();
    let records = b.frame(&[far, stop].concat())?;
    must(records.len() == 2, text::TwoAnswers, list(&records))?;
    b.until_flags(id, 0, bits::MOVE, STOP_MS)?;
    nothing_moves(b)
}

/// §2/2
pub fn cut_move(b: &mut Bench<'_>) -> Step {
    b.framed()?;
    let id = aimed(b)?;
    let (sign, _) = room(b, id)?;
    let far = Rec::new(R::MOVE, id, &le(sign * FAR)).bytes();
    let records = b.frame(&far[..5])?;
    let good =
        matches!(&records[..], [rec] if rec.status == Status::WRONG_DATA && rec.device == id);
    must(good, text::WrongDataFromAddressee, list(&records))?;
    let hidden = [&[R::GET_STATUS.0, S::GENERAL.0, 0, 200][..], &far].concat();
    let records = b.frame(&hidden)?;
    must(records.len() == 1, text::OneWrongData, list(&records))?;
    nothing_moves(b)
}

/// §3.1/4: a later Move replaces an earlier one (ours).
pub fn replaced(b: &mut Bench<'_>) -> Step {
    let id = aimed(b)?;
    let (step, tolerance) = small(id);
    let (sign, from) = room(b, id)?;
    go(b, id, from + sign * 4 * step)?;
    b.wait(300)?;
    go(b, id, from + sign * step)?;
    arrives(b, id, from + sign * step, tolerance)?;
    go(b, id, from)?;
    arrives(b, id, from, tolerance)
}

/// §3.3.4/1
pub fn overload(b: &mut Bench<'_>) -> Step {
    let step = overloaded(b);
    super::service::clean(b).and(step)
}

/// Current that a drive draws during most of a motion, 0.1 A: the lower quartile, for one reading may be
/// a peak of a ripple. The start, which draws more, is left out.
fn drawn(b: &mut Bench<'_>, id: S, to: i32) -> Step<i32> {
    go(b, id, to)?;
    b.wait(200)?;
    let mut drawn = Vec::new();
    for _ in 0..30 {
        b.wait(30)?;
        let rec = b.read(R::GET_STATUS, id, &[])?;
        if rec.flags().unwrap_or(0) & bits::MOVE != 0 {
            drawn.extend(rec.data.get(6).copied().map(i32::from));
        }
    }
    b.done(R::STOP, id, &[])?;
    b.until_flags(id, 0, bits::MOVE, STOP_MS)?;
    drawn.sort_unstable();
    Ok(drawn.get(drawn.len() / 4).copied().unwrap_or(0))
}

/// With MaxCurrent below the current of a motion, so that any motion is an overload.
fn overloaded(b: &mut Bench<'_>) -> Step {
    let id = aimed(b)?;
    b.param(id, "MaxCurrent")?;
    let (sign, from) = room(b, id)?;
    let drawn = drawn(b, id, from + sign * 8 * small(id).0)?;
    if drawn < 2 {
        return not_applicable(text::DriveDrawsTooLittle);
    }
    b.set(id, "MaxCurrent", drawn * 2 / 3)?;
    let (_, from) = b.drive(id)?;
    let sign = room(b, id)?.0;
    go(b, id, from + sign * 8 * small(id).0)?;
    let (mut over, mut before_ms) = (false, 0);
    for _ in 0..25 {
        before_ms = b.now_ms();
        over |= b.drive(id)?.0 & bits::OVERLOAD != 0;
        if over {
            break;
        }
        b.wait(100)?;
    }
    must(over, text::OverloadOverMaxCurrent, "")?;
    b.until_flags(id, 0, bits::MOVE, 1000)?;
    let rec = b.ask(R::MOVE, id, &le(from + sign * 8 * small(id).0))?;
    must(
        !rec.status.is_success() || b.now_ms() - before_ms > 2900,
        text::DirectionRefused,
        rec.words(true),
    )?;
    b.wait(1800)?;
    let still = b.drive(id)?.0 & bits::OVERLOAD != 0 || b.now_ms() - before_ms > 2900;
    must(still, text::FlagAfterStop, "")?;
    b.until_flags(id, 0, bits::OVERLOAD, 2500)
}

/// §3.9/3, §3.9/4, §3.10/4…: addressees that do not support the request, and absent ones.
pub fn close_wrong_addressee(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    let data = lafet_proto::id::key::CLOSE.to_le_bytes();
    for id in b.found.present.clone() {
        if !id.is_valve() {
            b.refused(R::CLOSE, id, &data, id, Status::WRONG_REQUEST)?;
        }
    }
    nothing_moves(b)
}

pub fn close_absent(b: &mut Bench<'_>) -> Step {
    let data = lafet_proto::id::key::CLOSE.to_le_bytes();
    for id in absent(b) {
        b.refused(R::CLOSE, id, &data, id, Status::MODULE_NOT_EXIST)?;
    }
    Ok(())
}

/// §3.9/5, §3.9
pub fn close_key(b: &mut Bench<'_>) -> Step {
    let id = b.one_of(&VALVES)?;
    b.refused(R::CLOSE, id, &[0x56, 0x75], id, Status::NEED_CONFIRM)?;
    let open = lafet_proto::id::key::OPEN.to_le_bytes();
    b.refused(R::CLOSE, id, &open, id, Status::NEED_CONFIRM)
}

pub fn close_layout(b: &mut Bench<'_>) -> Step {
    let id = b.one_of(&VALVES)?;
    for size in [0, 1, 3] {
        b.refused(R::CLOSE, id, &vec![0x74; size], id, Status::WRONG_DATA)?;
    }
    Ok(())
}

/// §3.9/2 with a closed valve.
pub fn close_closed(b: &mut Bench<'_>) -> Step {
    let id = b.one_of(&VALVES)?;
    b.done(R::CLOSE, id, &lafet_proto::id::key::CLOSE.to_le_bytes())?;
    b.until_flags(id, bits::CLOSED, bits::OPEN, 30_000)
}

/// §1/4 and the codes of §1: the monitor supports each request of the table.
pub fn requests_known(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    for (request, to) in [
        (R::MOVE, S::HORIZONTAL),
        (R::SET_PARAM, S::GENERAL),
        (R::SETUP_CORRECTION_TABLE, S::CONTROL),
        (R::OPEN, S::VALVE1),
        (R::CLOSE, S::VALVE1),
        (R::DEPLOY, S::DEPLOYER),
        (R::WRAP, S::DEPLOYER),
        (R::START_SEEK, S::DETECTOR),
        (R::START_QUENCH, S::CONTROL),
        (R::SWITCH_LIMITS, S::HORIZONTAL),
    ] {
        if b.has(to) {
            // One byte is a wrong size for all of them, so none is executed.
            b.refused(request, to, &[0], to, Status::WRONG_DATA)?;
        }
    }
    nothing_moves(b)
}
