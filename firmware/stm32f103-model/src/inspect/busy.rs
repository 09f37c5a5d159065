//! What comes over the line while the processor waits for its flash, and when the flash is written.

use lafet_proto::id::key;
use lafet_proto::request::Body;
use lafet_proto::{Ints, ParamId, SubsystemId};

use super::{MS_NS, STEP_NS, deployed, ensure, is_live, request, sound};
use crate::rig::{Rig, Wrong};

/// A page is erased in the meantime of so many writes at most.
const WRITES: i32 = 60;
/// From a SetParam to a frame that comes when the step behind it has started to write, ns.
const STARTED_NS: u64 = 4 * MS_NS;
/// From a SetParam to the last frame: a page that is erased then is being erased still.
const ENDING_NS: u64 = 30 * MS_NS;
const OFF_NS: u64 = 2 * MS_NS;

/// A parameter is written. `round` makes its value another one each time.
fn set(round: i32) -> Result<Vec<u8>, String> {
    let values = [5 + round % 5];
    let body = Body::SetParam { id: ParamId::of("Speed"), values: Ints::Values(&values) };
    request(SubsystemId::VERTICAL, body)
}

/// What would energise something: a drive, or in every other round a valve.
fn start(round: i32) -> Result<Vec<u8>, String> {
    match round % 2 {
        0 => {
            let destination = if round % 4 == 0 { 6_000 } else { -6_000 };
            request(SubsystemId::HORIZONTAL, Body::Move { destination })
        }
        _ => request(SubsystemId::VALVE1, Body::Open { key: key::OPEN }),
    }
}

fn erasures(rig: &Rig) -> u32 {
    rig.parts(|parts| parts.chip.erasures)
}

/// A Move or an Open that comes while the flash is written, or while a page is erased, begins nothing
/// when a Stop, a Lockout or a Restart has come behind it, however much lies between: nothing is energised
/// later than 2 ms behind the last byte.
pub(super) fn stop(wrong: Wrong) -> Result<(), String> {
    for body in [Body::Stop, Body::Lockout { key: key::ENABLE }, Body::Restart] {
        let mut rig = deployed(wrong)?;
        rig.set_step_ns(STEP_NS);
        let before = erasures(&rig);
        for round in 0..WRITES {
            if erasures(&rig) > before {
                break;
            }
            stopped(&mut rig, round, body)?;
        }
        ensure(erasures(&rig) > before, format!("no page was erased in {WRITES} writes"))?;
    }
    started(wrong)
}

fn stopped(rig: &mut Rig, round: i32, body: Body<'_>) -> Result<(), String> {
    let written_ns = rig.send(&set(round)?);
    rig.send_from(written_ns + STARTED_NS, &start(round)?);
    let poll = request(SubsystemId::ALL, Body::GetStatus)?;
    while rig.send(&poll) < written_ns + ENDING_NS {}
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
    rig.run(6_000);
    Ok(())
}

/// Without a Stop it begins once the flash is ready.
fn started(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    for round in 0..2 {
        let written_ns = rig.send(&set(round)?);
        rig.send_from(written_ns + STARTED_NS, &start(round)?);
        rig.run(200);
        ensure(rig.parts(|parts| parts.is_energised()), "what came meanwhile is not done")?;
        rig.order(SubsystemId::ALL, Body::Stop)?;
        rig.run(500);
    }
    sound(&rig)
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
