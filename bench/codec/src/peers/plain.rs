//! The least there is: bytes copied, and bytes seen as a structure (zerocopy).

use zerocopy::little_endian::{I16, U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

use super::State;
use crate::case;
use crate::case::Case;
use crate::values::{Drive, Whole};

pub fn cases() -> Vec<Case> {
    let drive = wire(&Drive::SAMPLE);
    let drive = drive.as_bytes();
    let whole = wire_whole(&Whole::SAMPLE);
    let whole = whole.as_bytes();
    let copied: fn(&State) -> bool = State::made;
    vec![
        case!(memcpy::drive_copy, drive.len(), State::new(drive), copied),
        case!(memcpy::whole_copy, whole.len(), State::new(whole), copied),
        case!(zerocopy::drive_decode, drive.len(), State::blank(drive), State::seen_drive),
        case!(zerocopy::drive_encode, drive.len(), State::new(drive), State::made),
        case!(zerocopy::whole_decode, whole.len(), State::blank(whole), State::seen_whole),
        case!(zerocopy::whole_encode, whole.len(), State::new(whole), State::made),
    ]
}

#[inline(never)]
fn drive_copy(state: &mut State) {
    copy(state);
}

#[inline(never)]
fn whole_copy(state: &mut State) {
    copy(state);
    state.drive.status = 0;
}

#[inline(always)]
fn copy(state: &mut State) {
    let input = state.input.as_slice();
    if let Some(place) = state.out.get_mut(..input.len()) {
        place.copy_from_slice(input);
        state.len = input.len();
    }
}

#[derive(Clone, Copy, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Header {
    request: u8,
    device: u8,
    status: u8,
    size: u8,
}

#[derive(Clone, Copy, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct DriveWire {
    header: Header,
    flags: U32,
    position: I16,
    current: u8,
    speed: u8,
}

#[derive(FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct WholeWire {
    general: Header,
    general_flags: U32,
    general_values: [U16; 3],
    climatics: Header,
    climatics_flags: U32,
    climatics_values: [I16; 6],
    drives: [DriveWire; 4],
    rest: [FlagsWire; 8],
}

#[derive(Clone, Copy, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct FlagsWire {
    header: Header,
    flags: U32,
}

#[inline(always)]
fn wire(drive: &Drive) -> DriveWire {
    let &Drive { request, device, status, flags, position, current, speed } = drive;
    let header = Header { request, device, status, size: 8 };
    DriveWire { header, flags: flags.into(), position: position.into(), current, speed }
}

#[inline(always)]
fn wire_whole(whole: &Whole) -> WholeWire {
    let header = |device, size| Header { request: 0xD4, device, status: 0, size };
    let drive = |(flags, position, current, speed)| {
        wire(&Drive { request: 0xD4, device: 1, status: 0, flags, position, current, speed })
    };
    WholeWire {
        general: header(1, 10),
        general_flags: whole.general_flags.into(),
        general_values: whole.general.map(Into::into),
        climatics: header(2, 16),
        climatics_flags: whole.climatics_flags.into(),
        climatics_values: whole.climatics.map(Into::into),
        drives: whole.drives.map(drive),
        rest: whole.flags.map(|flags| FlagsWire { header: header(3, 4), flags: flags.into() }),
    }
}

#[inline(never)]
fn drive_decode(state: &mut State) {
    let Ok(wire) = DriveWire::ref_from_bytes(&state.input) else { return };
    let Header { request, device, status, .. } = wire.header;
    let (flags, position) = (wire.flags.get(), wire.position.get());
    let DriveWire { current, speed, .. } = *wire;
    state.drive = Drive { request, device, status, flags, position, current, speed };
}

#[inline(never)]
fn drive_encode(state: &mut State) {
    let wire = wire(&state.drive);
    let written = wire.write_to_prefix(&mut state.out);
    state.len = written.map_or(0, |()| size_of::<DriveWire>());
}

#[inline(never)]
fn whole_decode(state: &mut State) {
    let Ok(wire) = WholeWire::ref_from_bytes(&state.input) else { return };
    state.whole = Whole {
        general_flags: wire.general_flags.get(),
        general: wire.general_values.map(U16::get),
        climatics_flags: wire.climatics_flags.get(),
        climatics: wire.climatics_values.map(I16::get),
        drives: wire.drives.map(|d| (d.flags.get(), d.position.get(), d.current, d.speed)),
        flags: wire.rest.map(|wire| wire.flags.get()),
    };
}

#[inline(never)]
fn whole_encode(state: &mut State) {
    let wire = wire_whole(&state.whole);
    let written = wire.write_to_prefix(&mut state.out);
    state.len = written.map_or(0, |()| size_of::<WholeWire>());
}
