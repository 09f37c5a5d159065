//! deku: structures with derived readers and writers.

use deku::DekuWriter;
use deku::no_std_io::Cursor;
use deku::writer::Writer;
use deku::{DekuContainerRead, DekuRead, DekuWrite};

use super::State;
use crate::case;
use crate::case::Case;
use crate::values::Drive;

#[derive(DekuRead, DekuWrite)]
#[deku(endian = "little")]
struct DriveWire {
    request: u8,
    device: u8,
    status: u8,
    size: u8,
    flags: u32,
    position: i16,
    current: u8,
    speed: u8,
}

pub fn cases() -> Vec<Case> {
    let mut state = State::new(&[]);
    drive_encode(&mut state);
    let drive = state.out[..state.len].to_vec();
    vec![
        case!(deku::drive_decode, drive.len(), State::blank(&drive), State::seen_drive),
        case!(deku::drive_encode, drive.len(), State::new(&drive), State::made),
    ]
}

#[inline(never)]
fn drive_decode(state: &mut State) {
    let Ok((_, wire)) = DriveWire::from_bytes((&state.input, 0)) else { return };
    let DriveWire { request, device, status, flags, position, current, speed, .. } = wire;
    state.drive = Drive { request, device, status, flags, position, current, speed };
}

#[inline(never)]
fn drive_encode(state: &mut State) {
    let &Drive { request, device, status, flags, position, current, speed } = &state.drive;
    let wire = DriveWire { request, device, status, size: 8, flags, position, current, speed };
    let mut writer = Writer::new(Cursor::new(&mut state.out[..]));
    if wire.to_writer(&mut writer, ()).is_ok() {
        state.len = writer.bits_written / 8;
    }
}
