//! Whether the records of a frame can be the answers to those of another (§1, §2).

use lafet_proto::record::Records;
use lafet_proto::{ParamId, Record, RequestId, Status, SubsystemId};

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
    let to_several = is_group(request.device);
    let mut seen = [false; 256];
    let mut is_known = !to_several;
    let mut last = None;
    let mut ahead = rest.clone();
    while let Some(Ok(record)) = ahead.next() {
        let double = core::mem::replace(seen.get_mut(usize::from(record.device.0))?, true);
        if double || !may_answer(request, &record) {
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

fn may_answer(request: &Record<'_>, answer: &Record<'_>) -> bool {
    let from = answer.device;
    answer.request == request.request
        && fits_param(request, answer)
        && match is_group(request.device) {
            true => !is_group(from),
            false => {
                from == request.device || (!answer.status.is_success() && may_refuse(request, from))
            }
        }
}

/// All and Motors are only addressees; no answer comes from them (§1).
const fn is_group(id: SubsystemId) -> bool {
    matches!(id, SubsystemId::ALL | SubsystemId::MOTORS)
}

/// Whether another subsystem may refuse a request in its addressee's stead (§1).
fn may_refuse(request: &Record<'_>, from: SubsystemId) -> bool {
    match from {
        SubsystemId::GENERAL => true,
        SubsystemId::DEPLOYER
        | SubsystemId::DETECTOR
        | SubsystemId::CONTROL
        | SubsystemId::EXTERNAL_CONN
        | SubsystemId::RADIO => !request.request.is_read(),
        // An open valve forbids folding the barrel (ours).
        SubsystemId::VALVE1 | SubsystemId::VALVE2 => request.device == SubsystemId::DEPLOYER,
        _ => false,
    }
}

/// §3.4, §3.5, §3.21: an answer repeats the id of the parameter; a refusal may omit it.
fn fits_param(request: &Record<'_>, answer: &Record<'_>) -> bool {
    let id = |data: &[u8]| data.first_chunk().map(|id| ParamId(u16::from_le_bytes(*id)));
    let asked = match request.request {
        RequestId::GET_PARAM | RequestId::SET_PARAM => id(request.data),
        RequestId::GET_HOTBED => Some(ParamId::HOTBEDS),
        _ => None,
    };
    let refuses = answer.data.is_empty() && !answer.status.is_success();
    asked.is_none() || refuses || id(answer.data) == asked
}

/// Whether General's report that there is no room is all that is left.
fn is_full(mut rest: Records<'_>) -> bool {
    let only = rest.next().and_then(Result::ok);
    rest.rest().is_empty()
        && only.is_some_and(|it| it.device == SubsystemId::GENERAL && it.status == Status::NO_ROOM)
}
