//! What must be answered: §1/11 and the sections, independent of the device's code.

use crate::states::{Gate, Operation, Place, State};
use crate::tables::*;

/// An answer that may come: from whom, with which of these statuses, with how much data.
pub struct Expected {
    pub from: u8,
    pub statuses: &'static [u8],
    pub size: usize,
}

pub const OK: &[u8] = &[0];
pub const ACCEPTED: &[u8] = &[1];
pub const NEED_CONFIRM: &[u8] = &[2];
pub const DENIED: &[u8] = &[3];
pub const MODULE_NOT_EXIST: &[u8] = &[4];
pub const MODULE_FAULT: &[u8] = &[5];
pub const BUSY: &[u8] = &[6];
pub const WRONG_REQUEST: &[u8] = &[7];
pub const WRONG_DATA: &[u8] = &[8];
pub const INVALID_ID: &[u8] = &[10];
pub const INVALID_VALUE: &[u8] = &[11];
pub const ACCESS_DENIED: &[u8] = &[12];
pub const INCOMPLETE: &[u8] = &[14];
pub const NOT_SUPPORTED: &[u8] = &[18];
/// Whether the values suit is not this test's business.
pub const ACCEPTED_OR_INVALID: &[u8] = &[1, 11];
/// §3.5/9: Ok when just this value is stored already.
pub const STORED_OR_INVALID: &[u8] = &[0, 1, 11];
pub const STORED_BUSY_OR_INVALID: &[u8] = &[0, 1, 6, 11];
pub const INCOMPLETE_OR_INVALID: &[u8] = &[1, 11, 14];

/// §3.12/2: what ends something is carried out before a reset, too.
pub fn is_safe(request: u8, data: &[u8]) -> bool {
    matches!(request, STOP | CLOSE) || request == LOCKOUT && data == [0xFA, 0x2F]
}

/// §1/11: the order of checks.
pub fn expected(state: &State, request: u8, device: u8, data: &[u8]) -> Vec<Expected> {
    let bare = |from, statuses| vec![Expected { from, statuses, size: 0 }];
    let passes = READS.contains(&request) || matches!(request, SET_PARAM | LOCKOUT);
    match state.gate {
        Gate::Locked if !passes => return bare(GENERAL, DENIED),
        Gate::Restarting if !READS.contains(&request) && !is_safe(request, data) => {
            return bare(GENERAL, BUSY);
        }
        _ => {}
    }
    if !KNOWN.contains(&request) {
        return bare(GENERAL, WRONG_REQUEST);
    }
    let who = addressees(request);
    if device == ALL || device == MOTORS {
        let who = if device == ALL { who.all } else { who.motors };
        let answering = CHAIN.iter().filter(|(id, _)| who.contains(id) && state.has(*id));
        let answers: Vec<_> =
            answering.map(|(id, _)| execution(state, request, *id, data, true)).collect();
        return if answers.is_empty() { bare(GENERAL, WRONG_REQUEST) } else { answers };
    }
    if !state.has(device) {
        return bare(device, MODULE_NOT_EXIST);
    }
    if !who.one.contains(&device) {
        return bare(device, WRONG_REQUEST);
    }
    if let Some(by) = interceptor(state, request, device) {
        return bare(by, DENIED);
    }
    // What would have to deploy first is refused by a Deployer that cannot (without parameters).
    if state.erased && matches!(request, START_QUENCH | START_TRAJECTORY | START_SEEK) {
        return bare(DEPLOYER, MODULE_FAULT);
    }
    vec![execution(state, request, device, data, false)]
}

/// The table "Who intercepts what" of protocol.md, column by column from the left.
pub fn interceptor(state: &State, request: u8, device: u8) -> Option<u8> {
    let deployed = state.place == Place::Deployed;
    let still = matches!(state.place, Place::Deployed | Place::Between);
    let on_the_way = state.place == Place::OnTheWay;
    let search = state.operation == Operation::Search;
    let justification = state.operation == Operation::Justification;
    let program = state.operation == Operation::Program;
    let detector = (search || justification).then_some(DETECTOR);
    let unless_deployed = (!deployed).then_some(DEPLOYER);
    match request {
        MOVE if device == DEPLOYER => {
            (!still).then_some(DEPLOYER).or(detector).or(program.then_some(CONTROL)).or(state.open)
        }
        MOVE | OPEN => unless_deployed.or(detector),
        // What waits for the deployment does not intercept Stop.
        STOP if on_the_way => (device != DEPLOYER).then_some(DEPLOYER),
        STOP => detector.or(program.then_some(CONTROL)).filter(|by| *by != device),
        CLOSE => search.then_some(DETECTOR),
        WRAP => detector.or(state.open),
        START_JUSTIFY => {
            unless_deployed.or(search.then_some(DETECTOR)).or(program.then_some(CONTROL))
        }
        START_QUENCH | START_TRAJECTORY => detector,
        START_SEEK => (justification || program).then_some(DETECTOR).or(state.open),
        _ => None,
    }
}

/// What the addressee answers: size, key, values, then the execution.
pub fn execution(state: &State, request: u8, from: u8, data: &[u8], broadcast: bool) -> Expected {
    let bare = |statuses| Expected { from, statuses, size: 0 };
    let with_data = |size| Expected { from, statuses: OK, size };
    let size = data.len();
    let right = match request {
        MOVE | GET_PARAM | OPEN | CLOSE | SWITCH_LIMITS | LOCKOUT | CLEAN_FLASH => size == 2,
        SET_PARAM => size >= 2 && (size - 2).is_multiple_of(4),
        SETUP_CORRECTION_TABLE => size >= 2,
        START_QUENCH => size == 8 || size >= 12,
        START_TRAJECTORY => match data {
            [0, _, count, rest @ ..] => rest.len() == 6 * usize::from(*count),
            [1, _, count, rest @ ..] => rest.len() == usize::from(*count),
            _ => size >= 3,
        },
        START_SEEK => size == 10,
        _ => size == 0,
    };
    if !right {
        return bare(WRONG_DATA);
    }
    let word = || u16::from_le_bytes([data[0], data[1]]);
    match request {
        GET_STATUS => {
            with_data(CHAIN.iter().find(|(id, _)| *id == from).map(|(_, size)| *size).unwrap())
        }
        STOP if broadcast || !state.erased => bare(OK),
        // The monitor is at rest, but a drive or valve without parameters is faulty (§3.2/5).
        STOP if matches!(from, CONTROL | DETECTOR | DEPLOYER) => bare(&[0, 5]),
        STOP => bare(MODULE_FAULT),
        GET_CRASH_DATA => with_data(80),
        GET_HOTBED => with_data(2),
        RETRIEVE_LIMITS => with_data(8),
        GET_PARAM => get_param(state, from, word()),
        SET_PARAM => set_param(state, from, data),
        SETUP_CORRECTION_TABLE if usize::from(data[0]) + size - 1 > 256 => bare(INVALID_VALUE),
        SETUP_CORRECTION_TABLE => bare(ACCEPTED),
        OPEN if word() != 0x4C70 => bare(NEED_CONFIRM),
        CLOSE if word() != 0x7456 => bare(NEED_CONFIRM),
        CLEAN_FLASH if word() != 0xA4F6 => bare(NEED_CONFIRM),
        LOCKOUT if ![0x2FFA, 0x7353].contains(&word()) => bare(INVALID_VALUE),
        SWITCH_LIMITS if word() > 2 => bare(INVALID_VALUE),
        SWITCH_LIMITS if state.switches => bare(NOT_SUPPORTED),
        WRAP | DEPLOY if state.erased => bare(MODULE_FAULT),
        WRAP => bare(if state.place == Place::Wrapped { OK } else { ACCEPTED }),
        DEPLOY => bare(if state.place == Place::Deployed { OK } else { ACCEPTED }),
        START_QUENCH | START_TRAJECTORY | START_SEEK => start(request, data),
        // §3.12/1, §3.18/1: a valve that has to close has only accepted it.
        RESTART if state.open == Some(from) => bare(ACCEPTED),
        LOCKOUT if state.open == Some(from) && word() == 0x2FFA => bare(ACCEPTED),
        // §3.18/8: a change of the lockout is not stored yet.
        LOCKOUT if from == GENERAL && (state.gate == Gate::Locked) != (word() == 0x2FFA) => {
            bare(ACCEPTED)
        }
        RESTART | LOCKOUT | SWITCH_LIMITS | CLEAN_FLASH => bare(OK),
        _ => bare(ACCEPTED),
    }
}

pub fn get_param(state: &State, from: u8, id: u16) -> Expected {
    let (statuses, size) = match param_of(from, id) {
        None => (INVALID_ID, 0),
        Some(Known::ReadOnly(size)) => (OK, size),
        Some(Known::Settable(fits)) if fits(7) => (OK, 28),
        Some(Known::Settable(fits)) if fits(0) => (OK, 0),
        Some(Known::Settable(_)) if state.erased => (INCOMPLETE, 0),
        Some(Known::Settable(_)) => (OK, 4),
    };
    Expected { from, statuses, size: 2 + size }
}

pub fn set_param(state: &State, from: u8, data: &[u8]) -> Expected {
    let id = u16::from_le_bytes([data[0], data[1]]);
    let (statuses, size) = match param_of(from, id) {
        None => (INVALID_ID, 2),
        Some(Known::ReadOnly(_)) => (ACCESS_DENIED, 2),
        Some(Known::Settable(fits)) if !fits((data.len() - 2) / 4) => (WRONG_DATA, 0),
        Some(Known::Settable(_)) if state.erased => (INCOMPLETE_OR_INVALID, 2),
        // A zero point is taken at rest only.
        Some(Known::Settable(_)) if id == hash16("ZeroPoint") => (STORED_BUSY_OR_INVALID, 2),
        Some(Known::Settable(_)) => (STORED_OR_INVALID, 2),
    };
    Expected { from, statuses, size }
}

/// §3.14–§3.16: values that cannot be right must be InvalidValue; whether the rest suits the
/// limits is not this test's business.
pub fn start(request: u8, data: &[u8]) -> Expected {
    let word = |at: usize| i16::from_le_bytes([data[at], data[at + 1]]);
    let (from, statuses) = match request {
        START_QUENCH if data.len() == 8 => {
            (CONTROL, if (0..8).contains(&word(0)) { ACCEPTED_OR_INVALID } else { INVALID_VALUE })
        }
        START_QUENCH => {
            let step = data[10].cast_signed();
            let distance = if data.len() == 12 { data[11].cast_signed() } else { 0 };
            let negative = word(6) < 0 || word(8) < 0 || step < 0 || distance < 0;
            (CONTROL, if negative { INVALID_VALUE } else { ACCEPTED_OR_INVALID })
        }
        START_SEEK => {
            (DETECTOR, if [0, 1].contains(&word(8)) { ACCEPTED_OR_INVALID } else { INVALID_VALUE })
        }
        _ => {
            let wrong = data[0] > 1 || data[1] > 3 || data[2] == 0;
            let numbers = data[0] == 1 && data[3..].iter().any(|number| *number > 7);
            (
                CONTROL,
                match data[0] {
                    _ if wrong || numbers => INVALID_VALUE,
                    1 => INVALID_ID,
                    _ => ACCEPTED,
                },
            )
        }
    };
    Expected { from, statuses, size: 0 }
}
