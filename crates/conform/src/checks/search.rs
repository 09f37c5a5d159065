//! §3.13, §3.16: searching and aligning. Nothing here opens a valve.

use lafet_proto::id::key;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::conform as text;

use super::motion::{limits, room};
use super::programs::{START_MS, centre, ends, movers, points, program, quench};
use super::{bits, le, les};
use crate::bench::Bench;
use crate::safety::{AIMING, Undo, VALVES};
use crate::verdict::{Step, must, not_applicable};

const SEEK_MS: u64 = 300_000;

fn sector(b: &mut Bench<'_>, width: i32, height: i32) -> Step<Vec<i32>> {
    let (h, v) = centre(b)?;
    Ok(vec![h - width / 2, h + width / 2, v - height / 2, v + height / 2, 0])
}

/// Starts a search.
fn seek(b: &mut Bench<'_>, width: i32, height: i32) -> Step {
    b.needs(S::DETECTOR)?;
    b.deployed()?;
    let data = les(&sector(b, width, height)?);
    movers(b);
    b.done(R::START_SEEK, S::DETECTOR, &data)?;
    b.until_flags(S::DETECTOR, bits::SEARCHING, 0, START_MS)
}

/// §3.16, §3.16/1, §3.21/3
pub fn seek_to_end(b: &mut Bench<'_>) -> Step {
    seek(b, 600, 300)?;
    b.until_flags(S::DETECTOR, 0, bits::SEARCHING, SEEK_MS)?;
    let flags = b.flags(S::DETECTOR)?;
    let beds = b.read(R::GET_HOTBED, S::DETECTOR, &[])?;
    let some = beds.data.len() > 2;
    must(
        (flags & bits::FOUND != 0) == some,
        text::FoundWhenHotbeds,
        format!("{flags:#010x}, {}", beds.words(true)),
    )?;
    must(flags & bits::CANCELED == 0, text::NotCanceled, format!("{flags:#010x}"))
}

/// §3.1/2, §3.2/3, §3.8/2, §3.9/1, §3.14/6, §3.11/7 each send one request while it searches.
fn while_seeking(b: &mut Bench<'_>, ask: impl Fn(&mut Bench<'_>) -> Step) -> Step {
    seek(b, 3000, 600)?;
    ask(b)?;
    let flags = b.flags(S::DETECTOR)?;
    must(flags & bits::SEARCHING != 0, text::SearchGoesOn, format!("{flags:#010x}"))?;
    b.done(R::STOP, S::DETECTOR, &[])?;
    b.until_flags(S::DETECTOR, 0, bits::SEARCHING, START_MS)
}

pub fn move_seeking(b: &mut Bench<'_>) -> Step {
    while_seeking(b, |b| {
        for id in AIMING {
            if b.has(id) {
                b.refused(R::MOVE, id, &le(60), S::DETECTOR, Status::DENIED)?;
            }
        }
        Ok(())
    })
}

pub fn stop_seeking(b: &mut Bench<'_>) -> Step {
    while_seeking(b, |b| {
        for id in [S::HORIZONTAL, S::VERTICAL, S::CONTROL, S::VALVE1] {
            if b.has(id) {
                b.refused(R::STOP, id, &[], S::DETECTOR, Status::DENIED)?;
            }
        }
        Ok(())
    })
}

pub fn open_seeking(b: &mut Bench<'_>) -> Step {
    let valve = b.one_of(&VALVES)?;
    b.undo.push(Undo::Valve(valve));
    while_seeking(b, |b| {
        b.refused(R::OPEN, valve, &key::OPEN.to_le_bytes(), S::DETECTOR, Status::DENIED)?;
        let flags = b.flags(valve)?;
        must(flags & bits::CLOSED != 0, text::ValveStays, format!("{flags:#010x}"))
    })
}

pub fn close_seeking(b: &mut Bench<'_>) -> Step {
    let valve = b.one_of(&VALVES)?;
    while_seeking(b, |b| {
        b.refused(R::CLOSE, valve, &key::CLOSE.to_le_bytes(), S::DETECTOR, Status::DENIED)
    })
}

pub fn quench_seeking(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    while_seeking(b, |b| {
        let data = program(0, 300, 100, 60, 1, 0);
        b.refused(R::START_QUENCH, S::CONTROL, &data, S::DETECTOR, Status::DENIED)?;
        let data = points(0, &[(0, 300)]);
        b.refused(R::START_TRAJECTORY, S::CONTROL, &data, S::DETECTOR, Status::DENIED)
    })
}

pub fn wrap_seeking(b: &mut Bench<'_>) -> Step {
    b.needs(S::DEPLOYER)?;
    while_seeking(b, |b| b.refused(R::WRAP, S::DEPLOYER, &[], S::DETECTOR, Status::DENIED))
}

/// §3.16/7, §3.2/3
pub fn seek_canceled(b: &mut Bench<'_>) -> Step {
    seek(b, 3000, 600)?;
    b.wait(1000)?;
    b.done(R::STOP, S::DETECTOR, &[])?;
    b.until_flags(S::DETECTOR, bits::CANCELED, bits::SEARCHING, START_MS)?;
    b.until_flags(S::HORIZONTAL, 0, bits::MOVE, START_MS)?;
    seek(b, 300, 100)?;
    let flags = b.flags(S::DETECTOR)?;
    must(flags & bits::CANCELED == 0, text::NextStartClears, format!("{flags:#010x}"))
}

/// §3.16/2
pub fn bad_sector(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    b.deployed()?;
    let mut data = sector(b, 600, 200)?;
    let (_, max) = limits(b, S::VERTICAL)?;
    data[3] = max + 600;
    b.refused(R::START_SEEK, S::DETECTOR, &les(&data), S::DETECTOR, Status::INVALID_VALUE)?;
    b.until_flags(S::DETECTOR, bits::BAD_SECTOR, bits::SEARCHING, 1000)
}

/// §3.16/2: start and end may be exchanged.
pub fn turned_sector(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    b.deployed()?;
    let data = sector(b, 600, 200)?;
    let turned = [data[1], data[0], data[3], data[2], 0];
    movers(b);
    b.done(R::START_SEEK, S::DETECTOR, &les(&turned))?;
    b.until_flags(S::DETECTOR, bits::SEARCHING, bits::BAD_SECTOR, START_MS)?;
    b.done(R::STOP, S::DETECTOR, &[])
}

/// §3.16/6
pub fn analyse_value(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    b.deployed()?;
    let mut data = sector(b, 600, 200)?;
    for analyse in [2, -1, 256] {
        data[4] = analyse;
        b.refused(R::START_SEEK, S::DETECTOR, &les(&data), S::DETECTOR, Status::INVALID_VALUE)?;
    }
    Ok(())
}

/// §3.16
pub fn seek_sizes(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    b.deployed()?;
    for size in [0, 8, 9, 11, 12] {
        b.refused(R::START_SEEK, S::DETECTOR, &vec![0; size], S::DETECTOR, Status::WRONG_DATA)?;
    }
    let to = S::GENERAL;
    b.refused(R::START_SEEK, to, &[0; 10], to, Status::WRONG_REQUEST)
}

/// §3.16/3
pub fn seek_wrapped(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    b.wrapped()?;
    let data = les(&sector(b, 600, 200)?);
    movers(b);
    b.done(R::START_SEEK, S::DETECTOR, &data)?;
    b.until_flags(S::DEPLOYER, bits::DEPLOYED, bits::DEPLOYING, 90_000)?;
    b.until_flags(S::DETECTOR, bits::SEARCHING, 0, START_MS)?;
    b.done(R::STOP, S::DETECTOR, &[])
}

/// §3.16/4
pub fn seek_quenching(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    quench(b)?;
    let data = les(&sector(b, 600, 200)?);
    b.refused(R::START_SEEK, S::DETECTOR, &data, S::DETECTOR, Status::DENIED)?;
    ends(b)
}

pub fn seek_replaced(b: &mut Bench<'_>) -> Step {
    seek(b, 3000, 600)?;
    let data = les(&sector(b, 300, 100)?);
    b.done(R::START_SEEK, S::DETECTOR, &data)?;
    b.done(R::STOP, S::DETECTOR, &[])
}

/// §3.13, §3.13/1
pub fn justify(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    b.deployed()?;
    b.refused(R::START_JUSTIFY, S::DETECTOR, &[0], S::DETECTOR, Status::WRONG_DATA)?;
    let old = (b.get(S::DETECTOR, "JustifyHorizontal")?, b.get(S::DETECTOR, "JustifyVertical")?);
    for (name, values) in [("JustifyHorizontal", old.0), ("JustifyVertical", old.1)] {
        if let Some([value, ..]) = values.as_deref() {
            b.undo.push(Undo::Param(S::DETECTOR, name, *value));
        }
    }
    movers(b);
    b.done(R::START_JUSTIFY, S::DETECTOR, &[])?;
    b.until(120_000, text::JustifiedOrFault, |b| {
        let flags = b.flags(S::DETECTOR)?;
        Ok(flags & bits::JUSTIFYING == 0 && flags & (bits::JUSTIFIED | bits::DEVICE_FAULT) != 0)
    })
}

/// §3.13/2
pub fn justify_denied(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    quench(b)?;
    b.refused(R::START_JUSTIFY, S::DETECTOR, &[], S::CONTROL, Status::DENIED)?;
    ends(b)
}

pub fn justify_wrapped(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    b.wrapped()?;
    b.refused(R::START_JUSTIFY, S::DETECTOR, &[], S::DEPLOYER, Status::DENIED)
}

/// §3.13/3
pub fn while_justifying(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    b.deployed()?;
    // Away from the target it must turn first, which leaves time for requests.
    movers(b);
    let (sign, at) = room(b, S::HORIZONTAL)?;
    b.done(R::MOVE, S::HORIZONTAL, &le(at + sign * 600))?;
    b.until_flags(S::HORIZONTAL, 0, bits::MOVE, 60_000)?;
    b.done(R::START_JUSTIFY, S::DETECTOR, &[])?;
    if b.flags(S::DETECTOR)? & bits::JUSTIFYING == 0 {
        return not_applicable(text::EndsAtOnce);
    }
    b.refused(R::MOVE, S::HORIZONTAL, &le(0), S::DETECTOR, Status::DENIED)?;
    b.refused(R::STOP, S::HORIZONTAL, &[], S::DETECTOR, Status::DENIED)?;
    b.done(R::STOP, S::DETECTOR, &[])?;
    b.until_flags(S::DETECTOR, 0, bits::JUSTIFYING, START_MS)
}
