//! postcard: serde's structures, and COBS with a CRC-32 as its frame.

use postcard::ser_flavors::Slice;
use serde::{Deserialize, Serialize};

use super::State;
use crate::case;
use crate::case::Case;
use crate::values::{Drive, ROOM, Whole};

#[derive(Serialize, Deserialize)]
struct DriveWire {
    request: u8,
    device: u8,
    status: u8,
    flags: u32,
    position: i16,
    current: u8,
    speed: u8,
}

#[derive(Serialize, Deserialize)]
struct WholeWire {
    general_flags: u32,
    general: [u16; 3],
    climatics_flags: u32,
    climatics: [i16; 6],
    drives: [(u32, i16, u8, u8); 4],
    flags: [u32; 8],
}

pub fn cases() -> Vec<Case> {
    let mut buffer = [0; ROOM];
    let drive = postcard::to_slice(&wire(&Drive::SAMPLE), &mut buffer).expect("room").to_vec();
    let whole =
        postcard::to_slice(&wire_whole(&Whole::SAMPLE), &mut buffer).expect("room").to_vec();
    let mut framed = State::new(&[]);
    drive_send(&mut framed);
    let drive_frame = framed.out[..framed.len].to_vec();
    whole_send(&mut framed);
    let whole_frame = framed.out[..framed.len].to_vec();
    vec![
        case!(postcard::drive_decode, drive.len(), State::blank(&drive), State::seen_drive),
        case!(postcard::drive_encode, drive.len(), State::new(&drive), State::made),
        case!(postcard::whole_decode, whole.len(), State::blank(&whole), State::seen_whole),
        case!(postcard::whole_encode, whole.len(), State::new(&whole), State::made),
        case!(
            postcard::drive_receive,
            drive_frame.len(),
            State::blank(&drive_frame),
            State::seen_drive
        ),
        case!(postcard::drive_send, drive_frame.len(), State::new(&drive_frame), State::made),
        case!(
            postcard::whole_receive,
            whole_frame.len(),
            State::blank(&whole_frame),
            State::seen_whole
        ),
        case!(postcard::whole_send, whole_frame.len(), State::new(&whole_frame), State::made),
    ]
}

#[inline(always)]
fn wire(drive: &Drive) -> DriveWire {
    let &Drive { request, device, status, flags, position, current, speed } = drive;
    DriveWire { request, device, status, flags, position, current, speed }
}

#[inline(always)]
fn wire_whole(whole: &Whole) -> WholeWire {
    let &Whole { general_flags, general, climatics_flags, climatics, drives, flags } = whole;
    WholeWire { general_flags, general, climatics_flags, climatics, drives, flags }
}

#[inline(always)]
fn see(seen: &mut Drive, wire: DriveWire) {
    let DriveWire { request, device, status, flags, position, current, speed } = wire;
    *seen = Drive { request, device, status, flags, position, current, speed };
}

#[inline(always)]
fn see_whole(seen: &mut Whole, wire: WholeWire) {
    let WholeWire { general_flags, general, climatics_flags, climatics, drives, flags } = wire;
    *seen = Whole { general_flags, general, climatics_flags, climatics, drives, flags };
}

#[inline(never)]
fn drive_decode(state: &mut State) {
    if let Ok(wire) = postcard::from_bytes(&state.input) {
        see(&mut state.drive, wire);
    }
}

#[inline(never)]
fn drive_encode(state: &mut State) {
    let made = postcard::to_slice(&wire(&state.drive), &mut state.out);
    state.len = made.map_or(0, |bytes| bytes.len());
}

#[inline(never)]
fn whole_decode(state: &mut State) {
    if let Ok(wire) = postcard::from_bytes(&state.input) {
        see_whole(&mut state.whole, wire);
    }
}

#[inline(never)]
fn whole_encode(state: &mut State) {
    let made = postcard::to_slice(&wire_whole(&state.whole), &mut state.out);
    state.len = made.map_or(0, |bytes| bytes.len());
}

/// The accumulator copies a frame together; in it, COBS is undone in place.
#[inline(always)]
fn unframe<'b>(input: &[u8], room: &'b mut [u8]) -> Option<&'b [u8]> {
    let place = room.get_mut(..input.len())?;
    place.copy_from_slice(input);
    let len = cobs::decode_in_place(place).ok()?;
    place.get(..len)
}

#[inline(never)]
fn drive_receive(state: &mut State) {
    let mut room = [0; ROOM];
    let Some(frame) = unframe(&state.input, &mut room) else { return };
    if let Ok(wire) = postcard::from_bytes_crc32(frame, digest()) {
        see(&mut state.drive, wire);
    }
}

#[inline(never)]
fn whole_receive(state: &mut State) {
    let mut room = [0; ROOM];
    let Some(frame) = unframe(&state.input, &mut room) else { return };
    if let Ok(wire) = postcard::from_bytes_crc32(frame, digest()) {
        see_whole(&mut state.whole, wire);
    }
}

#[inline(never)]
fn drive_send(state: &mut State) {
    let wire = wire(&state.drive);
    state.len = frame(&wire, &mut state.out);
}

#[inline(never)]
fn whole_send(state: &mut State) {
    let wire = wire_whole(&state.whole);
    state.len = frame(&wire, &mut state.out);
}

#[inline(always)]
fn frame(wire: &impl Serialize, out: &mut [u8]) -> usize {
    let Ok(flavor) = postcard::ser_flavors::Cobs::try_new(Slice::new(out)) else { return 0 };
    let flavor = postcard::ser_flavors::crc::CrcModifier::new(flavor, digest());
    postcard::serialize_with_flavor(wire, flavor).map_or(0, |bytes| bytes.len())
}

#[inline(always)]
fn digest() -> crc::Digest<'static, u32> {
    static CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISCSI);
    CRC.digest()
}
