//! lafet: the same, read as whatever answer it may be.
#![no_std]
#![no_main]

use core::hint::black_box;

use lafet_bench_footprint::lafet::{DRIVE, over_the_line, state};
use lafet_proto::Answer;
use lafet_proto::answer::Reply;
use lafet_proto::record::{Records, Writer};

#[cortex_m_rt::entry]
fn main() -> ! {
    lafet_bench_footprint::measure(message)
}

fn message() -> bool {
    let state = state();
    let data = Reply::Drive(state);
    let answer = Answer { from: DRIVE.device, request: DRIVE.request, status: DRIVE.status, data };
    let mut payload = [0; 16];
    let mut writer = Writer::new(&mut payload);
    let written = answer.encode(&mut writer);
    let seen = over_the_line(writer.written(), |payload| {
        let record = Records::new(payload).next()?.ok()?;
        match Answer::decode(&record).ok()?.data {
            Reply::Drive(seen) => Some(seen),
            _ => None,
        }
    });
    written.is_ok() && black_box(seen) == Some(state)
}
