//! What a payload asks for, and which frames can answer it (§1, §2).

use lafet_proto::id::key;
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{ParamId, Record, Request, RequestId, Status, SubsystemId};

/// Whether all requests may be carried out twice: reads, and what stops or closes. A probe may.
pub fn is_repeatable(payload: &[u8]) -> bool {
    every(payload, |request| is_read(request) || stops(request))
}

/// Whether a payload stops, closes or locks out, and does nothing else besides reading: it must not
/// wait for anything.
pub fn is_urgent(payload: &[u8]) -> bool {
    let mut urgent = false;
    let harmless = every(payload, |request| {
        urgent |= stops(request);
        stops(request) || is_read(request)
    });
    urgent && harmless
}

/// Whether these answers can be those to this payload: each belongs to one of its requests, and each
/// request has one, unless the monitor had no room for the rest (§2).
pub fn is_answered_by(payload: &[u8], answers: &[u8]) -> bool {
    if payload.is_empty() || answers.is_empty() {
        return payload.is_empty() && answers.is_empty();
    }
    let valid = |bytes| Records::new(bytes).all(|record| record.is_ok());
    let records = |bytes| Records::new(bytes).flatten();
    let full = records(answers).any(|answer| answer.status == Status::NO_ROOM);
    valid(answers)
        && records(answers).all(|answer| records(payload).any(|asked| fits(&asked, &answer)))
        && records(payload)
            .all(|asked| full || records(answers).any(|answer| fits(&asked, &answer)))
}

fn every(payload: &[u8], mut is: impl FnMut(&Request<'_>) -> bool) -> bool {
    Records::new(payload).all(|record| {
        let request = record.ok().and_then(|record| Request::decode(&record).ok());
        request.is_some_and(|request| is(&request))
    })
}

fn is_read(request: &Request<'_>) -> bool {
    request.body.id().is_read()
}

fn stops(request: &Request<'_>) -> bool {
    matches!(request.body, Body::Stop | Body::Close { .. } | Body::Lockout { key: key::ENABLE })
}

fn fits(asked: &Record<'_>, answer: &Record<'_>) -> bool {
    let full = answer.device == SubsystemId::GENERAL && answer.status == Status::NO_ROOM;
    full || (answer.request == asked.request
        && may_answer(asked, answer.device, answer.status)
        && fits_param(asked, answer))
}

/// The addressee may answer anything, each subsystem for All or Motors; others may only refuse in
/// its stead (§1).
fn may_answer(asked: &Record<'_>, from: SubsystemId, status: Status) -> bool {
    let is_group = |id| matches!(id, SubsystemId::ALL | SubsystemId::MOTORS);
    if from == asked.device || (is_group(asked.device) && !is_group(from)) {
        return true;
    }
    if status.is_success() {
        return false;
    }
    match from {
        SubsystemId::GENERAL => true,
        // «Обработчики» of §3.1, §3.2, §3.8–§3.11, §3.14, §3.16.
        SubsystemId::DEPLOYER
        | SubsystemId::DETECTOR
        | SubsystemId::CONTROL
        | SubsystemId::EXTERNAL_CONN
        | SubsystemId::RADIO => is_control(asked.request),
        // An open valve forbids folding the barrel (ours).
        SubsystemId::VALVE1 | SubsystemId::VALVE2 => {
            asked.request == RequestId::WRAP
                || (asked.request == RequestId::MOVE && asked.device == SubsystemId::DEPLOYER)
        }
        _ => false,
    }
}

const fn is_control(request: RequestId) -> bool {
    matches!(
        request,
        RequestId::MOVE
            | RequestId::STOP
            | RequestId::OPEN
            | RequestId::CLOSE
            | RequestId::DEPLOY
            | RequestId::WRAP
            | RequestId::START_JUSTIFY
            | RequestId::START_QUENCH
            | RequestId::START_TRAJECTORY
            | RequestId::START_SEEK
            | RequestId::SWITCH_LIMITS
    )
}

/// §3.4, §3.5, §3.21: an answer repeats the id of the parameter. A refusal may omit it.
fn fits_param(asked: &Record<'_>, answer: &Record<'_>) -> bool {
    let param = match (asked.request, asked.data) {
        (RequestId::GET_PARAM | RequestId::SET_PARAM, [a, b, ..]) => [*a, *b],
        (RequestId::GET_HOTBED, _) => ParamId::HOTBEDS.0.to_le_bytes(),
        _ => return true,
    };
    match answer.data {
        [a, b, ..] => [*a, *b] == param,
        [_] => false,
        [] => !answer.status.is_success(),
    }
}
