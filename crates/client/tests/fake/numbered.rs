//! A monitor that puts the number of the frame into every answer, so that it shows whose answer was
//! believed.

use lafet_proto::record::{Record, Records, Writer};
use lafet_proto::{RequestId, Status, SubsystemId};

/// What a monitor does with a subsystem that does not exist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unknown {
    /// ModuleNotExist on behalf of the addressee (§1).
    Answered,
    /// It leaves it out.
    LeftOut,
    /// General refuses it in its own name.
    Refused,
}

/// What the monitor answers: the number of the frame is in every value.
pub fn answer(payload: &[u8], number: u32, unknown: Unknown) -> Vec<u8> {
    let mut buffer = [0; 512];
    let mut out = Writer::new(&mut buffer);
    for Record { request, device, data, .. } in Records::new(payload).map_while(Result::ok) {
        let mut push = |device, status, data: &[u8]| {
            out.push(&Record { request, device, status, data }).expect("room");
        };
        let word = number.to_le_bytes();
        match request {
            RequestId::GET_STATUS if device == SubsystemId::ALL => {
                push(SubsystemId::VALVE1, Status::OK, &word);
                push(SubsystemId::VERTICAL, Status::OK, &[&word[..], &[0; 4]].concat());
            }
            RequestId::GET_STATUS => match unknown {
                Unknown::Answered => push(device, Status::MODULE_NOT_EXIST, &[]),
                Unknown::LeftOut => {}
                Unknown::Refused => push(SubsystemId::GENERAL, Status::WRONG_REQUEST, &[]),
            },
            RequestId::GET_PARAM => push(device, Status::OK, &[data, &word].concat()),
            RequestId::MOVE => {
                let (device, status) = outcome_of(number);
                push(device, status, &[]);
            }
            _ => {
                push(SubsystemId::CONTROL, Status::OK, &[]);
                push(SubsystemId::VERTICAL, Status::ACCEPTED, &[]);
            }
        }
    }
    out.written().to_vec()
}

/// A Move does not always end the same, so that the answer to another one is found out.
pub fn outcome_of(number: u32) -> (SubsystemId, Status) {
    match number % 4 {
        0 => (SubsystemId::VERTICAL, Status::OK),
        1 => (SubsystemId::VERTICAL, Status::ACCEPTED),
        2 => (SubsystemId::DEPLOYER, Status::DENIED),
        _ => (SubsystemId::VERTICAL, Status::MODULE_FAULT),
    }
}

/// The number that an answer carries.
pub fn number_of(request: RequestId, data: &[u8]) -> Option<u32> {
    let number = match request {
        RequestId::GET_STATUS => data.first_chunk()?,
        RequestId::GET_PARAM => data.last_chunk()?,
        _ => return None,
    };
    Some(u32::from_le_bytes(*number))
}
