//! What the DMA writes while it is read.

use std::cell::Cell;
use std::rc::Rc;

use lafet_stm32f103::Bus;
use lafet_stm32f103::analog::{Analog, CHANNELS};

const SAMPLES: u32 = 0x2000_0C00;
/// A count more than the one before, in another byte.
const BEFORE: u16 = 0x07FF;
const AFTER: u16 = 0x0800;

/// Memory in which the DMA writes all samples between any two accesses; registers read as 0.
#[derive(Clone)]
struct Busy(Rc<Cell<u16>>);

impl Busy {
    /// The bytes of a word.
    fn bytes(&self) -> [u8; 4] {
        let next = BEFORE ^ AFTER ^ self.0.get();
        let [low, high] = self.0.replace(next).to_le_bytes();
        [low, high, low, high]
    }
}

impl Bus for Busy {
    fn read(&self, address: u32) -> u32 {
        if !(SAMPLES..0x4000_0000).contains(&address) {
            return 0;
        }
        assert!(address.is_multiple_of(4), "{address:#x}");
        u32::from_le_bytes(self.bytes())
    }

    fn write(&self, _: u32, _: u32) {}

    fn read8(&self, address: u32) -> u8 {
        self.bytes()[(address & 3) as usize]
    }

    fn write8(&self, _: u32, _: u8) {}

    fn write16(&self, _: u32, _: u16) {}

    fn reset(&self) {}
}

#[test]
fn a_sample_is_never_half_of_another() {
    let analog = Analog::start(Busy(Rc::new(Cell::new(BEFORE))), SAMPLES);
    for place in (0..CHANNELS.len()).chain([0]) {
        let sample = analog.sample(place);
        assert!([BEFORE, AFTER].map(u32::from).contains(&sample), "{place}: {sample:#x}");
    }
}
