//! What comes over the line while the processor waits for its flash, and when the flash is written.

use lafet_proto::id::key;
use lafet_proto::request::Body;
use lafet_proto::{Ints, ParamId, SubsystemId};
use lafet_stm32f103::record::Record;

use super::starts::restart;
use super::{MS_NS, STEP_NS, deployed, ensure, fresh, is_live, request, sound};
use crate::rig::{Rig, Wrong};

/// A page is erased in the meantime of so many writes at most.
const WRITES: i32 = 60;
/// From a SetParam to a frame that comes when the step behind it has started to write, ns.
const STARTED_NS: u64 = 4 * MS_NS;
/// From a SetParam to the last frame: a page is being erased still, or what has come meanwhile has started
/// and is stopped.
const ENDING_NS: [u64; 2] = [30 * MS_NS, 60 * MS_NS];
const OFF_NS: u64 = 2 * MS_NS;
/// From a last stop bit until the line is free for another sender, ns.
const HELD_NS: u64 = 10_000;

/// A parameter is written. `round` makes its value another one each time.
fn set(round: i32) -> Result<Vec<u8>, String> {
    let values = [5 + round % 5];
    let body = Body::SetParam { id: ParamId::of("Speed"), values: Ints::Values(&values) };
    request(SubsystemId::VERTICAL, body)
}

/// What energises a drive, to either side, and what energises a valve.
fn start(is_valve: bool, round: i32) -> Result<Vec<u8>, String> {
    if is_valve {
        return request(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    }
    let destination = if round % 2 == 0 { 6_000 } else { -6_000 };
    request(SubsystemId::HORIZONTAL, Body::Move { destination })
}

fn erasures(rig: &Rig) -> u32 {
    rig.parts(|parts| parts.chip.erasures)
}

/// A Move or an Open that comes while the flash is written, or while a page is erased, begins nothing
/// when a Stop, a Lockout or a Restart has come behind it, however much lies between: nothing is energised
/// later than 2 ms behind the last byte.
pub(super) fn stop(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    let at_rest = rig.save();
    for body in [Body::Stop, Body::Lockout { key: key::ENABLE }, Body::Restart] {
        for is_valve in [false, true] {
            for ending_ns in ENDING_NS {
                rig.restore(&at_rest);
                stopped_in_time(&mut rig, is_valve, ending_ns, body)?;
            }
        }
    }
    rig.restore(&at_rest);
    started(&mut rig)
}

/// Parameters are written until a page was erased.
fn stopped_in_time(
    rig: &mut Rig,
    is_valve: bool,
    ending_ns: u64,
    body: Body<'_>,
) -> Result<(), String> {
    rig.set_step_ns(STEP_NS);
    let before = erasures(rig);
    for round in 0..WRITES {
        let first = start(is_valve, round)?;
        stopped(rig, round, &first, ending_ns, body)?;
        if erasures(rig) > before {
            return Ok(());
        }
    }
    Err(format!("no page was erased in {WRITES} writes"))
}

fn stopped(
    rig: &mut Rig,
    round: i32,
    first: &[u8],
    ending_ns: u64,
    body: Body<'_>,
) -> Result<(), String> {
    let written_ns = rig.send(&set(round)?);
    rig.send_from(written_ns + STARTED_NS, first);
    let poll = request(SubsystemId::ALL, Body::GetStatus)?;
    while rig.send(&poll) < written_ns + ending_ns {}
    let last_ns = rig.send(&request(SubsystemId::ALL, body)?);
    while rig.now_ns() < last_ns + 100 * MS_NS {
        rig.round();
        let late = rig.now_ns() > last_ns + OFF_NS && rig.parts(|parts| parts.off_ns.is_none());
        ensure(!late, format!("energised {OFF_NS} ns after {body:?}"))?;
    }
    let off_ns = rig.parts(|parts| parts.off_ns).unwrap_or(u64::MAX);
    let late_ns = off_ns.saturating_sub(last_ns);
    ensure(late_ns <= OFF_NS, format!("off {late_ns} ns after {body:?}"))?;
    let broken = rig.parts(|parts| parts.chip.violations.clone());
    ensure(broken.is_empty(), format!("{broken:?}"))?;
    if body == Body::Restart {
        rig.run(1_000);
    }
    rig.order(SubsystemId::ALL, Body::Lockout { key: key::DISABLE })?;
    rig.order(SubsystemId::VALVE1, Body::Close { key: key::CLOSE })?;
    let at_rest = rig.run_until(6_000, |rig| {
        rig.parts(|parts| parts.off_ns.is_some() && parts.plant.is_at_rest(&parts.chip))
    });
    ensure(at_rest, format!("not at rest 6 s after {body:?} and Close"))
}

/// Without a Stop it begins once the flash is ready.
fn started(rig: &mut Rig) -> Result<(), String> {
    for (round, is_valve) in [(0, false), (1, true)] {
        let written_ns = rig.send(&set(round)?);
        rig.send_from(written_ns + STARTED_NS, &start(is_valve, round)?);
        rig.run(200);
        ensure(rig.parts(|parts| parts.is_energised()), "what came meanwhile is not done")?;
        rig.order(SubsystemId::ALL, Body::Stop)?;
        rig.run(500);
    }
    sound(rig)
}

/// What is set while a drive runs is written once it is at rest, and not before.
pub(super) fn motion(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 6_000 })?;
    rig.run(500);
    let flash = |rig: &Rig| rig.parts(|parts| parts.chip.flash().to_vec());
    let before = flash(&rig);
    rig.send(&set(1)?);
    rig.run(300);
    ensure(is_live(&rig), "the drive does not run")?;
    ensure(flash(&rig) == before, "the flash was written in motion")?;
    sound(&rig)?;
    rig.order(SubsystemId::ALL, Body::Stop)?;
    rig.run(300);
    ensure(flash(&rig) != before, "what was set in motion is not written")?;
    sound(&rig)
}

/// The line is free behind the last stop bit of an answer, though a page is erased or something written while
/// it ends: the answer to what is written, and one that takes longer than a page.
pub(super) fn release(wrong: Wrong) -> Result<(), String> {
    for baud in [19_200, 115_200] {
        for beside in [false, true] {
            released(wrong, baud, beside).map_err(|why| format!("{baud} baud: {why}"))?;
        }
    }
    Ok(())
}

fn released(wrong: Wrong, baud: u32, beside: bool) -> Result<(), String> {
    let mut rig = fresh(wrong);
    let mut record = Record::NOMINAL;
    (wrong.record)(&mut record);
    record.baud = baud;
    rig.parts(|parts| parts.chip.line_baud = baud.into());
    restart(&mut rig, &record.encode(), true);
    // The first write behind a start erases a page.
    let (before, poll) = (erasures(&rig), request(SubsystemId::ALL, Body::GetStatus)?);
    for round in 0..4 {
        if beside {
            rig.send(&poll);
        }
        rig.send(&set(round)?);
        rig.run(300);
        let answers = rig.frames().len();
        ensure(answers == 1 + usize::from(beside), format!("{answers} answers"))?;
    }
    ensure(erasures(&rig) > before, "no page was erased")?;
    let broken = rig.parts(|parts| parts.chip.violations.clone());
    ensure(broken.is_empty(), format!("{broken:?}"))?;
    let held_ns = rig.parts(|parts| parts.chip.held_ns);
    ensure(held_ns <= HELD_NS, format!("the line was held {held_ns} ns behind an answer"))
}
