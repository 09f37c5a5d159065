//! The program of a robotic fire monitor on a Cortex-M3: `lafet-device`, unchanged, on a board.
//!
//! Everything that belongs to the board stands in [`board`]; the rest of the monitor is the library.

#![no_std]
#![no_main]

mod board;
mod crash;
mod float;
mod memory;
mod register;
mod stack;

use board::{Board, Chosen, Start};
use cortex_m_rt::entry;
use lafet_device::port::Port;
use lafet_device::{Device, Source};
use lafet_proto::status::FaultInfo;

#[entry]
fn main() -> ! {
    stack::paint();
    let mut board = Chosen::new();
    let fault = crash::take(board.reset_by_watchdog());
    let start = board.start(fault.is_some());
    run(&mut board, start, fault)
}

/// Bytes of the line that are taken at a time.
const CHUNK: usize = 32;

// Apart, so that what a board does at its start does not lie on top of the monitor.
#[inline(never)]
fn run(board: &mut impl Board, start: Start, fault: Option<FaultInfo>) -> ! {
    let mut device = Device::at_rest(start.composition, start.address);
    device.wake(start.now_ms, fault, board);
    board.started();
    let mut port = Port::counting(Source::ExternalConn);
    loop {
        board.feed_watchdog();
        serve(board, &mut device, &mut port);
        if let Some(now_ms) = board.due() {
            device.step(now_ms, board);
            board.stepped();
        }
    }
}

/// Answers what has come over the line.
// Apart: its answer must not lie on top of a step.
#[inline(never)]
fn serve(board: &mut impl Board, device: &mut Device, port: &mut Port<()>) {
    let mut chunk = [0; CHUNK];
    let bytes = board.receive(&mut chunk);
    if !bytes.is_empty() {
        port.serve(board.now_ms(), device, bytes, &mut |byte| board.put(byte));
        board.release();
    }
}

/// No path leads here: were there one, the program would not link, for want of this function.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        fn a_panic_can_be_reached() -> !;
    }
    // SAFETY: never linked.
    unsafe { a_panic_can_be_reached() }
}
