//! lafet: the state of a drive into a frame, byte by byte as a line takes it, and out of what a receiver
//! has collected.
#![no_std]
#![no_main]

use core::hint::black_box;

use lafet_bench_footprint::lafet::{DRIVE, over_the_line, state};
use lafet_proto::record::{Record, Records, Writer};
use lafet_proto::status::DriveStatus;

#[cortex_m_rt::entry]
fn main() -> ! {
    lafet_bench_footprint::measure(message)
}

fn message() -> bool {
    let state = state();
    let mut payload = [0; 16];
    let mut writer = Writer::new(&mut payload);
    let written = writer.push(&Record { data: &state.to_bytes(), ..DRIVE });
    let seen = over_the_line(writer.written(), |payload| {
        let record = Records::new(payload).next()?.ok()?;
        Some((record.request, record.device, DriveStatus::from_bytes(*record.data.as_array()?)))
    });
    written.is_ok() && black_box(seen) == Some((DRIVE.request, DRIVE.device, state))
}
