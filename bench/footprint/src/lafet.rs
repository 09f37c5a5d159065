//! What both programs of lafet have in common.

use core::hint::black_box;

use lafet_proto::flags::DriveFlags;
use lafet_proto::link::{self, BODY_MAX, Check, Decoder, Frame};
use lafet_proto::record::Record;
use lafet_proto::status::DriveStatus;
use lafet_proto::{RequestId, Status, SubsystemId};

/// An answer to GetStatus, without its data.
pub const DRIVE: Record<'_> = Record {
    request: RequestId::GET_STATUS,
    device: SubsystemId::VERTICAL,
    status: Status::OK,
    data: &[],
};

const WIRE_LEN: usize = 40;
static mut WIRE: [u8; WIRE_LEN] = [0; WIRE_LEN];
static mut DECODER: Decoder<BODY_MAX, ()> = Decoder::counting();

/// What a drive says of itself.
pub fn state() -> DriveStatus {
    DriveStatus {
        flags: DriveFlags::from_bits_retain(black_box(0x41_0000)),
        position: black_box(1200),
        current: 21,
        speed: 9,
    }
}

/// Sends a payload in a frame, and gives what is received to `read`.
#[inline(always)]
pub fn over_the_line<T>(payload: &[u8], read: impl FnOnce(&[u8]) -> Option<T>) -> Option<T> {
    // SAFETY: nothing else uses it; there is one thread, and no interrupt.
    let decoder = unsafe { &mut *(&raw mut DECODER) };
    // SAFETY: as above.
    let wire = unsafe { &mut *(&raw mut WIRE) };
    let mut places = wire.iter_mut();
    let frame = Frame { dst: 129, src: 1, payload };
    link::send(Check::Crc16, &frame, &mut |byte| {
        if let Some(place) = places.next() {
            *place = byte;
        }
    });
    let free = places.len();
    let sent = black_box(wire.get(..WIRE_LEN - free)?);
    let (_, received) = decoder.push_slice(sent);
    received.and_then(|frame| read(frame.payload))
}
