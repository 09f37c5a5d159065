//! prost: Protocol Buffers.

use prost::Message;

use super::State;
use crate::case;
use crate::case::Case;
use crate::values::{Drive, ROOM, Whole};

#[derive(Clone, PartialEq, Message)]
struct DriveWire {
    #[prost(uint32, tag = "1")]
    request: u32,
    #[prost(uint32, tag = "2")]
    device: u32,
    #[prost(uint32, tag = "3")]
    status: u32,
    #[prost(fixed32, tag = "4")]
    flags: u32,
    #[prost(sint32, tag = "5")]
    position: i32,
    #[prost(uint32, tag = "6")]
    current: u32,
    #[prost(uint32, tag = "7")]
    speed: u32,
}

#[derive(Clone, PartialEq, Message)]
struct WholeWire {
    #[prost(fixed32, tag = "1")]
    general_flags: u32,
    #[prost(uint32, repeated, tag = "2")]
    general: Vec<u32>,
    #[prost(fixed32, tag = "3")]
    climatics_flags: u32,
    #[prost(sint32, repeated, tag = "4")]
    climatics: Vec<i32>,
    #[prost(message, repeated, tag = "5")]
    drives: Vec<DriveWire>,
    #[prost(fixed32, repeated, tag = "6")]
    flags: Vec<u32>,
}

pub fn cases() -> Vec<Case> {
    let drive = wire(&Drive::SAMPLE).encode_to_vec();
    let whole = wire_whole(&Whole::SAMPLE).encode_to_vec();
    vec![
        case!(prost::drive_decode, drive.len(), State::blank(&drive), State::seen_drive),
        case!(prost::drive_encode, drive.len(), State::new(&drive), State::made),
        case!(prost::whole_decode, whole.len(), State::blank(&whole), State::seen_whole),
        case!(prost::whole_encode, whole.len(), State::new(&whole), State::made),
    ]
}

#[inline(always)]
fn wire(drive: &Drive) -> DriveWire {
    DriveWire {
        request: drive.request.into(),
        device: drive.device.into(),
        status: drive.status.into(),
        flags: drive.flags,
        position: drive.position.into(),
        current: drive.current.into(),
        speed: drive.speed.into(),
    }
}

#[inline(always)]
fn wire_whole(whole: &Whole) -> WholeWire {
    let drive = |(flags, position, current, speed)| {
        wire(&Drive { request: 0, device: 0, status: 0, flags, position, current, speed })
    };
    WholeWire {
        general_flags: whole.general_flags,
        general: whole.general.map(Into::into).to_vec(),
        climatics_flags: whole.climatics_flags,
        climatics: whole.climatics.map(Into::into).to_vec(),
        drives: whole.drives.map(drive).to_vec(),
        flags: whole.flags.to_vec(),
    }
}

#[inline(never)]
fn drive_decode(state: &mut State) {
    let Ok(wire) = DriveWire::decode(state.input.as_slice()) else { return };
    state.drive = Drive {
        request: wire.request as u8,
        device: wire.device as u8,
        status: wire.status as u8,
        flags: wire.flags,
        position: wire.position as i16,
        current: wire.current as u8,
        speed: wire.speed as u8,
    };
}

#[inline(never)]
fn drive_encode(state: &mut State) {
    let mut out = state.out.as_mut_slice();
    if wire(&state.drive).encode(&mut out).is_ok() {
        state.len = ROOM - out.len();
    }
}

#[inline(never)]
fn whole_decode(state: &mut State) {
    let Ok(wire) = WholeWire::decode(state.input.as_slice()) else { return };
    let mut whole = Whole {
        general_flags: wire.general_flags,
        climatics_flags: wire.climatics_flags,
        ..Whole::default()
    };
    whole.general.iter_mut().zip(&wire.general).for_each(|(to, from)| *to = *from as u16);
    whole.climatics.iter_mut().zip(&wire.climatics).for_each(|(to, from)| *to = *from as i16);
    whole.flags.iter_mut().zip(&wire.flags).for_each(|(to, from)| *to = *from);
    for (to, from) in whole.drives.iter_mut().zip(&wire.drives) {
        *to = (from.flags, from.position as i16, from.current as u8, from.speed as u8);
    }
    state.whole = whole;
}

#[inline(never)]
fn whole_encode(state: &mut State) {
    let mut out = state.out.as_mut_slice();
    if wire_whole(&state.whole).encode(&mut out).is_ok() {
        state.len = ROOM - out.len();
    }
}
