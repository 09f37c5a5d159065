//! A lamp of the board, lit while the monitor drives anything. As the outputs of a board it is a register of the chip's
//! surroundings, which a reset puts to rest: who looks at it sees how long something is driven.

use crate::register::write;

/// The lamps of the FPGA, a bit each.
const LAMPS: usize = 0x4002_8000;
const FIRST: u32 = 1;

/// The lamp, which a reset has put out.
#[derive(Debug, Default)]
pub struct Lamp {
    is_lit: bool,
}

impl Lamp {
    /// Lit, or not.
    pub fn show(&mut self, lit: bool) {
        if lit != self.is_lit {
            self.is_lit = lit;
            write(LAMPS, if lit { FIRST } else { 0 });
        }
    }
}
