//! The flash behind the parameters: nothing is written or erased while anything is driven.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_storage::nor_flash::NorFlash;
use lafet_stm32f103::Bus;
use lafet_stm32f103::flash::{InternalFlash, PAGE, START};
use lafet_stm32f103_model::chip::{Chip, Reset};
use lafet_stm32f103_model::image::flash;

const TIM8: u32 = 0x4001_3400;
const PORT_E: u32 = 0x4001_1800;
const RCC: u32 = 0x4002_1000;

/// What it is, the registers that make it so, whether the flash may be written.
type State = (&'static str, [(u32, u32); 2], bool);

/// The model's chip alone.
#[derive(Clone)]
struct Direct(Rc<RefCell<Chip>>);

impl Bus for Direct {
    fn read(&self, address: u32) -> u32 {
        self.0.borrow_mut().read(address)
    }

    fn write(&self, address: u32, value: u32) {
        self.0.borrow_mut().write(address, value);
    }

    fn read8(&self, address: u32) -> u8 {
        self.0.borrow().read8(address)
    }

    fn write8(&self, address: u32, value: u8) {
        self.0.borrow_mut().write8(address, value);
    }

    fn write16(&self, address: u32, value: u16) {
        self.0.borrow_mut().write16(address, value);
    }

    fn reset(&self) {
        self.0.borrow_mut().reset = Some(Reset::Software);
    }
}

fn chip() -> Direct {
    let bus = Direct(Rc::new(RefCell::new(Chip::new(flash(None)))));
    bus.write(RCC + 0x18, 0x7EFD);
    bus
}

#[test]
fn nothing_is_written_while_a_drive_has_voltage_or_a_valve_opens() {
    let page = PAGE as u32;
    let states: [State; 5] = [
        ("at rest", [(TIM8 + 0x34, 0), (TIM8 + 0x44, 1 << 15)], true),
        ("a drive runs", [(TIM8 + 0x38, 9), (TIM8 + 0x44, 1 << 15)], false),
        ("stages off", [(TIM8 + 0x38, 9), (TIM8 + 0x44, 0)], true),
        ("valve 2 opens", [(PORT_E, 0x4444_4222), (PORT_E + 0x10, 1 << 2)], false),
        // A lockout is stored while its valves close.
        ("valve 2 closes", [(PORT_E, 0x4444_2222), (PORT_E + 0x10, 1 << 3)], true),
    ];
    for (state, writes, may) in states {
        let bus = chip();
        for (address, value) in writes {
            bus.write(address, value);
        }
        let mut pages = InternalFlash::new(bus.clone());
        assert_eq!(pages.write(6, &[1, 2]).is_ok(), may, "{state}");
        assert_eq!(bus.read8(START + 6), if may { 1 } else { 0xFF }, "{state}");
        assert_eq!(pages.erase(page, 2 * page).is_ok(), may, "{state}");
        assert!(bus.0.borrow().violations.is_empty(), "{state}");
    }
}

#[test]
fn a_word_that_is_not_erased_is_an_error() {
    let bus = chip();
    let mut pages = InternalFlash::new(bus.clone());
    assert!(pages.write(0, &[1, 2, 3, 4]).is_ok());
    assert!(pages.write(2, &[5, 6]).is_err());
    assert!(pages.erase(0, PAGE as u32).is_ok() && pages.write(2, &[5, 6]).is_ok());
    assert_eq!((bus.read8(START), bus.read8(START + 2)), (0xFF, 5));
}
