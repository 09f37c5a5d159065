//! Which answers belong to which request, and whether all that are due are there (§1).

use lafet_device::cause::Asked;
use lafet_proto::record::Record;
use lafet_proto::{RequestId, SubsystemId, dictionary};

/// How many of the answers belong to this request: one, or those of all who handle it.
pub fn count(chain: &[SubsystemId], asked: &Asked, answers: &[Record<'_>]) -> usize {
    let Some(first) = answers.first() else { return 0 };
    if first.request != asked.request {
        return 0;
    }
    if !is_broadcast(asked) {
        return 1;
    }
    let place = |id: SubsystemId| SubsystemId::CHAIN.iter().position(|known| *known == id);
    let mut last = None;
    answers
        .iter()
        .take_while(|answer| {
            let at = place(answer.device);
            let next = answer.request == asked.request
                && handles(chain, answer.device, asked)
                && (last.is_none() || at > last);
            last = at;
            next
        })
        .count()
        .max(1)
}

/// A request has its answer; one to All or Motors those of all who handle it, or a refusal from
/// General.
pub fn complete(
    chain: &[SubsystemId],
    asked: &Asked,
    mine: &[Record<'_>],
) -> Result<(), &'static str> {
    let Some(first) = mine.first() else {
        return Err("a request is not answered");
    };
    let refused =
        mine.len() == 1 && first.device == SubsystemId::GENERAL && !first.status.is_success();
    let all = chain.iter().filter(|id| handles(chain, **id, asked)).count();
    if is_broadcast(asked) && !refused && mine.len() != all {
        return Err("not all have answered");
    }
    Ok(())
}

/// Nothing is answered that was not asked for, but so many.
pub fn nothing_more(rest: &[Record<'_>], but: usize) -> Result<(), &'static str> {
    match rest.len() <= but {
        true => Ok(()),
        false => Err("an answer to no request"),
    }
}

const fn is_broadcast(asked: &Asked) -> bool {
    matches!(asked.to, SubsystemId::ALL | SubsystemId::MOTORS)
}

fn handles(chain: &[SubsystemId], id: SubsystemId, asked: &Asked) -> bool {
    let whole = matches!(asked.request, RequestId::RESTART | RequestId::LOCKOUT);
    let known = dictionary::request(asked.request)
        .is_some_and(|info| info.addressees.is_empty() || info.addressees.contains(&id));
    let motors = asked.to != SubsystemId::MOTORS || id.is_drive();
    chain.contains(&id) && (whole || known) && motors
}
