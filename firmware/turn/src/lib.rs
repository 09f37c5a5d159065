//! The loop of the monitor's program: what has come over the line is answered, a step that is due is
//! made. It is the same on every board, and on a model of one.
#![no_std]

pub mod fault;
pub mod float;

use lafet_device::hal::Hal;
use lafet_device::port::Port;
use lafet_device::{Composition, Device};

/// Bytes of the line that are taken at a time.
const CHUNK: usize = 32;
/// So often between two steps at most: 576 bytes are what a board keeps while its flash is busy.
const CHUNKS: usize = 18;

/// How the program starts.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The clock, ms.
    pub now_ms: u32,
    /// What the monitor is built from.
    pub composition: &'static Composition,
    /// The address it has while its memory says none.
    pub address: u8,
}

/// A board: its process image and memory, the line, the clock, the watchdog. `Hal::reset` of a board
/// does not come back.
pub trait Board: Hal {
    /// Waits until the program may begin; it may have ended with a fault before.
    fn start(&mut self, after_fault: bool) -> Start;

    /// The watchdog has ended the last run.
    fn reset_by_watchdog(&mut self) -> bool;

    /// The board runs without the crystal that it should run on.
    fn lacks_crystal(&self) -> bool {
        false
    }

    /// The program has started.
    fn started(&mut self) {}

    /// The clock, ms.
    fn now_ms(&self) -> u32;

    /// The time of the step that is due now.
    fn due(&mut self) -> Option<u32>;

    /// The step is over.
    fn stepped(&mut self) {}

    /// What has come over the line and fits.
    fn receive<'b>(&mut self, buffer: &'b mut [u8]) -> &'b [u8];

    /// Sends a byte of a frame.
    fn put(&mut self, byte: u8);

    /// Releases the line, when all that was sent has left.
    fn release(&mut self) {}

    /// The program is alive, whether it makes steps or not.
    fn feed_watchdog(&mut self) {}
}

/// Once round the loop. Whether a step was made.
///
/// All that has come is answered before the step: behind a write to the flash much has, and a Move in it
/// must not begin when a Stop follows.
// In two calls: an answer must not lie on top of a step.
pub fn once(board: &mut impl Board, device: &mut Device, port: &mut Port<()>) -> bool {
    board.feed_watchdog();
    for _ in 0..CHUNKS {
        if !serve(board, device, port) {
            break;
        }
    }
    let due = board.due();
    if let Some(now_ms) = due {
        device.step(now_ms, board);
        board.stepped();
    }
    due.is_some()
}

/// Answers what has come over the line. Whether there may be more.
#[inline(never)]
fn serve(board: &mut impl Board, device: &mut Device, port: &mut Port<()>) -> bool {
    let mut chunk = [0; CHUNK];
    let bytes = board.receive(&mut chunk);
    if !bytes.is_empty() {
        port.serve(board.now_ms(), device, bytes, &mut |byte| board.put(byte));
        board.release();
    }
    bytes.len() == CHUNK
}
