//! §D/4: a Move that ends by itself.

use lafet_proto::{RequestId as R, SubsystemId as S};
use lafet_texts::conform as text;

use super::motion::{FAR, aimed, arrives, go, room, small};
use super::{bits, le};
use crate::bench::{Bench, list, param_data};
use crate::raw::Rec;
use crate::verdict::{Step, must};

/// MoveHold of the test, ms; also the interval of its renewal.
const HOLD_MS: u64 = 1000;
const RENEW_MS: u64 = 600;
/// Time for a drive to stop, ms.
const STOP_MS: u64 = 3000;

/// §D/4
pub fn move_timeout(b: &mut Bench<'_>) -> Step {
    let id = aimed(b)?;
    b.param(S::GENERAL, "MoveTimeout")?;
    let (sign, from) = room(b, id)?;
    b.set(S::GENERAL, "MoveTimeout", 2000)?;
    let mut last_ms = b.now_ms();
    go(b, id, sign * FAR)?;
    b.wait(1200)?;
    let mut in_time = b.now_ms() - last_ms < 1900;
    last_ms = b.now_ms();
    go(b, id, sign * FAR)?;
    b.wait(1200)?;
    let moving = b.drive(id)?.0 & bits::MOVE != 0;
    in_time &= b.now_ms() - last_ms < 1900;
    let moving = moving || !in_time;
    must(moving, text::MovesWhileRepeated, "")?;
    b.until_flags(id, 0, bits::MOVE, 4000)?;
    b.put(S::GENERAL, "MoveTimeout", 0)?;
    go(b, id, from)?;
    arrives(b, id, from, small(id).1)
}

/// §D/4 The Move lasts as long as the MoveHold in its frame is renewed; a renewal starts nothing.
pub fn move_hold(b: &mut Bench<'_>) -> Step {
    b.several()?;
    let id = aimed(b)?;
    b.param(id, "MoveHold")?;
    let (sign, from) = room(b, id)?;
    let hold = i32::try_from(HOLD_MS).unwrap_or_default();
    let held = Rec::new(R::SET_PARAM, id, &param_data("MoveHold", &[hold]));
    let far = Rec::new(R::MOVE, id, &le(sign * FAR));
    let answers = b.frame(&[held.bytes(), far.bytes()].concat())?;
    let good = answers.len() == 2 && answers.iter().all(|rec| rec.status.is_success());
    must(good, text::SetParamAndMoveTaken, list(&answers))?;
    let (mut last_ms, mut in_time) = (b.now_ms(), true);
    for _ in 0..2 {
        b.wait(RENEW_MS)?;
        b.put(id, "MoveHold", hold)?;
        in_time &= b.now_ms() - last_ms < HOLD_MS;
        last_ms = b.now_ms();
    }
    b.wait(RENEW_MS)?;
    let moving = b.drive(id)?.0 & bits::MOVE != 0;
    in_time &= b.now_ms() - last_ms < HOLD_MS;
    must(moving || !in_time, text::MovesWhileRenewed, "")?;
    b.until_flags(id, 0, bits::MOVE, HOLD_MS + STOP_MS)?;
    b.put(id, "MoveHold", hold)?;
    b.stays(RENEW_MS, text::RenewalStartsNothing, |b| Ok(b.drive(id)?.0 & bits::MOVE == 0))?;
    go(b, id, from)?;
    arrives(b, id, from, small(id).1)
}
