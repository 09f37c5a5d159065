//! rmodbus: a request for four registers comes in, the answer goes out; RTU.
#![no_std]
#![no_main]

use core::hint::black_box;

use rmodbus::ModbusProto;
use rmodbus::server::ModbusFrame;
use rmodbus::server::storage::ModbusStorage;

static mut REGISTERS: ModbusStorage<1, 1, 1, 16> = ModbusStorage::new();

#[cortex_m_rt::entry]
fn main() -> ! {
    lafet_bench_footprint::measure(message)
}

fn message() -> bool {
    let mut request = [0; 256];
    request[..8].copy_from_slice(black_box(&[1, 3, 0, 0, 0, 4, 0x44, 0x09]));
    let mut answer: heapless::Vec<u8, 256> = heapless::Vec::new();
    let mut frame = ModbusFrame::new(1, &request, ModbusProto::Rtu, &mut answer);
    // SAFETY: nothing else uses it; there is one thread, and no interrupt.
    let registers = unsafe { &*(&raw const REGISTERS) };
    let read = frame.parse().and_then(|()| frame.process_read(registers));
    let done = read.and_then(|()| frame.finalize_response()).is_ok();
    done && black_box(answer).len() == 13
}
