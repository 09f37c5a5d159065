//! Whether the records of a frame can be the answers to those of another (§1, §2).

use lafet_proto::record::Records;
use lafet_proto::{Asked, Record, Status};

/// Whether they are: an answer to each request in its turn, of its addressee or of a subsystem that may
/// refuse in its stead; several to All and Motors. Where the room for answers has ended (NoRoom), those behind
/// it have none.
pub fn answers(asked: &[u8], answer: &[u8]) -> bool {
    let mut rest = Records::new(answer);
    for (index, request) in Records::new(asked).flatten().enumerate() {
        if index > 0 && is_full(rest.clone()) {
            return true;
        }
        let Some(last) = take(&request, &mut rest) else { return false };
        let is_at_end = rest.rest().is_empty() || is_full(rest.clone());
        if last.status == Status::NO_ROOM && is_at_end {
            return true;
        }
    }
    rest.rest().is_empty()
}

/// Takes the answers to a request off; the last of them, if there is one.
fn take<'a>(request: &Record<'_>, rest: &mut Records<'a>) -> Option<Record<'a>> {
    let asked = Asked::of(request);
    let to_several = asked.to.is_group();
    let mut seen = [false; 256];
    let mut is_known = !to_several;
    let mut last = None;
    let mut ahead = rest.clone();
    while let Some(Ok(record)) = ahead.next() {
        let double = core::mem::replace(seen.get_mut(usize::from(record.device.0))?, true);
        if double || !asked.is_answered_by(&record) {
            break;
        }
        is_known |= record.device.name().is_some();
        last = Some(record);
        *rest = ahead.clone();
        if !to_several {
            break;
        }
    }
    // Unknown subsystems may be among them, but no monitor consists only of those.
    last.filter(|_| is_known)
}

/// Whether General's report that there is no room is all that is left.
fn is_full(mut rest: Records<'_>) -> bool {
    let only = rest.next().and_then(Result::ok);
    rest.rest().is_empty() && only.is_some_and(|it| it.is_full())
}
