//! lafet: the state of a drive into a frame, and out of it, byte by byte as a line brings it.
#![no_std]
#![no_main]

use core::hint::black_box;

use lafet_proto::answer::Reply;
use lafet_proto::flags::DriveFlags;
use lafet_proto::link::{self, Decoder, Frame};
use lafet_proto::record::{Records, Writer};
use lafet_proto::status::DriveStatus;
use lafet_proto::{Answer, RequestId, Status, SubsystemId};

static mut DECODER: Decoder = Decoder::new();

#[cortex_m_rt::entry]
fn main() -> ! {
    lafet_bench_footprint::measure(message)
}

fn message() -> bool {
    let status = DriveStatus {
        flags: DriveFlags::from_bits_retain(black_box(0x41_0000)),
        position: black_box(1200),
        current: 21,
        speed: 9,
    };
    let answer = Answer {
        from: SubsystemId::VERTICAL,
        request: RequestId::GET_STATUS,
        status: Status::OK,
        data: Reply::Drive(status),
    };
    let mut payload = [0; 16];
    let mut wire = [0; 48];
    let mut writer = Writer::new(&mut payload);
    let written = answer.encode(&mut writer);
    let frame = Frame { dst: 129, src: 1, payload: writer.written() };
    let Some(len) = link::encode(&frame, &mut wire).filter(|_| written.is_ok()) else {
        return false;
    };
    let wire = black_box(&wire);
    // SAFETY: nobody else uses it; there is one thread, and no interrupt.
    let decoder = unsafe { &mut *(&raw mut DECODER) };
    let (_, received) = decoder.push_slice(wire.get(..len).unwrap_or_default());
    let record = received.and_then(|frame| Records::new(frame.payload).next());
    let Some(Ok(record)) = record else { return false };
    match Answer::decode(&record) {
        Ok(Answer { data: Reply::Drive(seen), .. }) => black_box(seen) == status,
        _ => false,
    }
}
