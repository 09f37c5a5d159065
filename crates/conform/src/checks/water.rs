//! §3.8, §3.9: the valves. Water may flow.

use lafet_proto::id::key;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_texts::conform as text;

use super::{bits, les};
use crate::bench::Bench;
use crate::safety::{Undo, VALVES};
use crate::verdict::{Step, must};

const TRAVEL_MS: u64 = 60_000;

fn valve(b: &mut Bench<'_>) -> Step<S> {
    let id = b.one_of(&VALVES)?;
    b.deployed()?;
    b.undo.push(Undo::Valve(id));
    Ok(id)
}

fn open(b: &mut Bench<'_>, id: S) -> Step {
    b.water = true;
    b.want(R::OPEN, id, &key::OPEN.to_le_bytes(), id, &[Status::ACCEPTED, Status::OK]).map(|_| ())
}

/// A valve that is open, or opening.
pub fn opened(b: &mut Bench<'_>) -> Step<S> {
    let id = valve(b)?;
    open(b, id)?;
    b.until_flags(id, bits::OPEN, bits::OPENING | bits::CLOSED, TRAVEL_MS)?;
    Ok(id)
}

/// It is closed, and half a second later too.
pub fn stays_closed(b: &mut Bench<'_>, id: S) -> Step {
    b.wait(500)?;
    let flags = b.flags(id)?;
    must(
        flags & bits::CLOSED != 0 && flags & (bits::OPENING | bits::OPEN) == 0,
        text::ValveStaysClosed,
        format!("{flags:#010x}"),
    )
}

/// §3.8/1: the most dangerous request of all.
pub fn open_wrapped(b: &mut Bench<'_>) -> Step {
    b.wrapped()?;
    let id = b.one_of(&VALVES)?;
    b.undo.push(Undo::Valve(id));
    b.refused(R::OPEN, id, &key::OPEN.to_le_bytes(), S::DEPLOYER, Status::DENIED)?;
    stays_closed(b, id)?;
    b.folds();
    b.done(R::DEPLOY, S::DEPLOYER, &[])?;
    b.wait(1500)?;
    b.refused(R::OPEN, id, &key::OPEN.to_le_bytes(), S::DEPLOYER, Status::DENIED)?;
    stays_closed(b, id)?;
    b.done(R::STOP, S::DEPLOYER, &[])?;
    b.wait(500)?;
    b.refused(R::OPEN, id, &key::OPEN.to_le_bytes(), S::DEPLOYER, Status::DENIED)?;
    stays_closed(b, id)?;
    b.deployed()
}

/// §3.8/6
pub fn open_key(b: &mut Bench<'_>) -> Step {
    let id = valve(b)?;
    for wrong in [key::OPEN ^ 1, key::OPEN.swap_bytes(), key::CLOSE, 0] {
        b.refused(R::OPEN, id, &wrong.to_le_bytes(), id, Status::NEED_CONFIRM)?;
    }
    stays_closed(b, id)
}

/// §3.8
pub fn open_layout(b: &mut Bench<'_>) -> Step {
    let id = valve(b)?;
    let data = key::OPEN.to_le_bytes();
    for wrong in [&[][..], &data[..1], &[data[0], data[1], 0]] {
        b.refused(R::OPEN, id, wrong, id, Status::WRONG_DATA)?;
    }
    stays_closed(b, id)
}

/// §3.8/4
pub fn open_wrong_addressee(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    for id in b.found.present.clone() {
        if !id.is_valve() {
            b.refused(R::OPEN, id, &key::OPEN.to_le_bytes(), id, Status::WRONG_REQUEST)?;
        }
    }
    b.refused(R::OPEN, S::ALL, &key::OPEN.to_le_bytes(), S::GENERAL, Status::WRONG_REQUEST)
}

/// §3.8/5
pub fn open_absent(b: &mut Bench<'_>) -> Step {
    for id in VALVES.into_iter().chain([S(0)]) {
        if !b.has(id) {
            b.refused(R::OPEN, id, &key::OPEN.to_le_bytes(), id, Status::MODULE_NOT_EXIST)?;
        }
    }
    Ok(())
}

/// §3.8/3, §3.9/2: each valve opens and closes, and the other does not move.
pub fn open_and_close(b: &mut Bench<'_>) -> Step {
    b.deployed()?;
    b.one_of(&VALVES)?;
    for id in VALVES {
        if !b.has(id) {
            continue;
        }
        b.undo.push(Undo::Valve(id));
        open(b, id)?;
        b.until_flags(id, bits::OPENING, bits::CLOSING, 1500)?;
        b.until_flags(id, bits::OPEN, bits::OPENING | bits::CLOSED | bits::CLOSING, TRAVEL_MS)?;
        for other in VALVES {
            if other != id && b.has(other) {
                stays_closed(b, other)?;
            }
        }
        b.done(R::CLOSE, id, &key::CLOSE.to_le_bytes())?;
        b.until_flags(id, bits::CLOSING, bits::OPENING, 1500)?;
        b.until_flags(id, bits::CLOSED, bits::CLOSING | bits::OPEN | bits::OPENING, TRAVEL_MS)?;
    }
    Ok(())
}

/// §3.9/5 with an open valve.
pub fn close_key_open(b: &mut Bench<'_>) -> Step {
    let id = opened(b)?;
    b.refused(R::CLOSE, id, &key::OPEN.to_le_bytes(), id, Status::NEED_CONFIRM)?;
    b.wait(500)?;
    let flags = b.flags(id)?;
    must(flags & bits::OPEN != 0, text::ValveStaysOpen, format!("{flags:#010x}"))
}

/// §3.2/5
pub fn stop_valve(b: &mut Bench<'_>) -> Step {
    let id = valve(b)?;
    open(b, id)?;
    b.wait(1500)?;
    b.done(R::STOP, id, &[])?;
    b.until_flags(id, 0, bits::OPENING, 2000)?;
    b.wait(1000)?;
    let flags = b.flags(id)?;
    must(flags & bits::OPEN == 0, text::StaysAtRest, format!("{flags:#010x}"))
}

/// §3.2/1
pub fn stop_all_valve(b: &mut Bench<'_>) -> Step {
    let id = valve(b)?;
    open(b, id)?;
    b.wait(1500)?;
    b.frame(&crate::raw::Rec::new(R::STOP, S::ALL, &[]).bytes())?;
    b.until_flags(id, 0, bits::OPENING, 2000)?;
    b.wait(1000)?;
    let flags = b.flags(id)?;
    must(
        flags & (bits::OPEN | bits::CLOSED) == 0,
        text::StopAllStopsValve,
        format!("{flags:#010x}"),
    )
}

/// §1/6
pub fn stop_motors_valve(b: &mut Bench<'_>) -> Step {
    let id = valve(b)?;
    open(b, id)?;
    b.wait(1000)?;
    b.frame(&crate::raw::Rec::new(R::STOP, S::MOTORS, &[]).bytes())?;
    b.until_flags(id, bits::OPEN, bits::OPENING, TRAVEL_MS)
}

/// §3.11/6
pub fn wrap_open(b: &mut Bench<'_>) -> Step {
    b.needs(S::DEPLOYER)?;
    let id = opened(b)?;
    b.refused(R::WRAP, S::DEPLOYER, &[], id, Status::DENIED)?;
    b.wait(500)?;
    let flags = b.flags(S::DEPLOYER)?;
    must(flags & bits::DEPLOYED != 0, text::StaysDeployed, format!("{flags:#010x}"))
}

/// §3.16/8
pub fn seek_open(b: &mut Bench<'_>) -> Step {
    b.needs(S::DETECTOR)?;
    let id = opened(b)?;
    b.refused(R::START_SEEK, S::DETECTOR, &les(&[-300, 300, 0, 200, 0]), id, Status::DENIED)
}

/// §3.1/9 with an open valve.
pub fn move_deployer_open(b: &mut Bench<'_>) -> Step {
    b.needs(S::DEPLOYER)?;
    let id = opened(b)?;
    b.refused(R::MOVE, S::DEPLOYER, &les(&[2000]), id, Status::DENIED)
}

/// §3.14/7: start, pause and end of a program leave the valve as it is.
pub fn program_leaves_valve(b: &mut Bench<'_>) -> Step {
    b.needs(S::CONTROL)?;
    let id = opened(b)?;
    super::programs::quench(b)?;
    b.wait(1500)?;
    b.done(R::STOP, S::CONTROL, &[])?;
    b.wait(800)?;
    let flags = b.flags(id)?;
    must(
        flags & bits::OPEN != 0 && flags & bits::CLOSING == 0,
        text::OpenValveStaysOpen,
        format!("{flags:#010x}"),
    )
}
