//! The program of a robotic fire monitor on a Cortex-M3: `lafet-device`, unchanged, on a board.
//!
//! Everything that belongs to the board is in [`board`]; the rest of the monitor is the library.

#![no_std]
#![no_main]

mod board;
mod crash;
mod float;
mod memory;
mod register;
#[cfg(feature = "emulated")]
mod stack;

use cortex_m_rt::entry;
use lafet_device::port::Port;
use lafet_device::{Device, Source};
use lafet_proto::status::FaultInfo;
use lafet_turn::{Board, Start, once};

#[entry]
fn main() -> ! {
    // Where a plant asks how deep it has been.
    #[cfg(feature = "emulated")]
    stack::paint();
    let mut board = board::start();
    let fault = crash::take(board.reset_by_watchdog(), board.lacks_crystal());
    let start = board.start(fault.is_some());
    run(&mut board, start, fault)
}

// Apart, so that what a board does at its start does not lie on top of the monitor.
#[inline(never)]
fn run(board: &mut impl Board, start: Start, fault: Option<FaultInfo>) -> ! {
    let mut device = Device::at_rest(start.composition, start.address);
    device.wake(start.now_ms, fault, board);
    board.started();
    let mut port = Port::counting(Source::ExternalConn);
    loop {
        once(board, &mut device, &mut port);
    }
}

/// The library that verifies signatures checks its indices, which `cargo xtask firmware update` lists. Were one of
/// them wrong, it would be a fault like any other: recorded, and outputs fall to rest with the reset.
#[cfg(feature = "mps2")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    cortex_m::asm::udf()
}

/// No path leads here: were there one, the program would not link, for want of this function.
#[cfg(not(feature = "mps2"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        fn a_panic_can_be_reached() -> !;
    }
    // SAFETY: never linked.
    unsafe { a_panic_can_be_reached() }
}
