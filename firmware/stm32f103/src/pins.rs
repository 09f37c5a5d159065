//! The pins: which are used, how they are set up, and which remaps that takes (RM §9).

use crate::bus::{Bus, Registers};
use stm32_metapac::afio::vals::SwjCfg;
use stm32_metapac::gpio::Gpio;
use stm32_metapac::gpio::regs::{Bsrr, Cr, Idr};
use stm32_metapac::{AFIO, GPIOA, GPIOB, GPIOC, GPIOD, GPIOE};

/// A pin of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin {
    /// A is 0.
    pub port: u8,
    /// 0 to 15.
    pub bit: u8,
}

const fn pin(port: char, bit: u8) -> Pin {
    Pin { port: port as u8 - b'A', bit }
}

/// What a pin is: the four bits of CNF and MODE (RM §9.1), at 2 MHz where it drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    /// To the ADC.
    Analogue = 0x0,
    /// Push-pull; has an external pull-down, for it floats from a reset on.
    Output = 0x2,
    /// Driven from outside at all times.
    Floating = 0x4,
    /// A contact to ground: internal pull-up.
    Contact = 0x8,
    /// A peripheral drives it; has an external pull-down too.
    Alternate = 0xA,
}

/// Drives the transmitter of RS-485.
pub const TRANSMIT: Pin = pin('A', 12);
/// The stop chain, closed to ground while all is well: TIM8_BKIN. Its pull-up of 1 kΩ is outside; that of the
/// chip would take half a ms, and is there for when the other fails.
pub const STOP_CHAIN: Pin = pin('A', 6);
/// Lets the drives' power stages work.
pub const DRIVES_ENABLE: Pin = pin('C', 10);
/// Lets the valves' relays have power.
pub const VALVES_ENABLE: Pin = pin('C', 11);
/// Direction of each drive: high is up or left.
pub const DIRECTION: [Pin; 4] = [pin('B', 12), pin('B', 13), pin('B', 14), pin('B', 15)];
/// Low while a drive's motor has voltage.
pub const MOTOR_LIVE: [Pin; 4] = [pin('E', 12), pin('E', 13), pin('E', 14), pin('E', 15)];
/// End switches of each drive, lower and upper: open at the end.
pub const ENDS: [[Pin; 2]; 4] = [
    [pin('D', 0), pin('D', 1)],
    [pin('D', 2), pin('D', 3)],
    [pin('D', 4), pin('D', 5)],
    [pin('D', 6), pin('D', 7)],
];
/// The deployer's second contacts, wrapped and deployed: closed at the end.
pub const DEPLOYER_AT: [Pin; 2] = [pin('D', 8), pin('D', 9)];
/// Each valve is open, is closed: contacts that close there.
pub const VALVE_AT: [[Pin; 2]; 2] = [[pin('D', 10), pin('D', 11)], [pin('D', 12), pin('D', 13)]];
/// Each valve's hardware block: a contact that opens.
pub const VALVE_FREE: [Pin; 2] = [pin('D', 14), pin('D', 15)];
/// Relays of each valve: open, close.
pub const RELAYS: [[Pin; 2]; 2] = [[pin('E', 0), pin('E', 1)], [pin('E', 2), pin('E', 3)]];
/// Mirror contacts of the relays: closed while the relay is on.
pub const MIRRORS: [[Pin; 2]; 2] = [[pin('A', 8), pin('A', 11)], [pin('C', 12), pin('A', 15)]];
/// Heaters, in the order of ThermoStatus.
pub const HEATERS: [Pin; 5] = [pin('E', 4), pin('E', 5), pin('E', 6), pin('E', 7), pin('E', 8)];
/// Low while a heater draws current.
pub const HEATER_LIVE: [Pin; 5] =
    [pin('B', 8), pin('B', 9), pin('B', 10), pin('B', 11), pin('E', 10)];
/// Closed at power-up: the barrel is parked where the board's record says.
pub const PARKED: Pin = pin('C', 13);

/// Pins of one kind.
type Group = (Mode, &'static [Pin]);

/// Every pin that is used, by its mode.
pub const WIRING: [Group; 5] = [
    (
        Mode::Analogue,
        &[
            pin('C', 0),
            pin('C', 1),
            pin('C', 2),
            pin('C', 3),
            pin('C', 4),
            pin('C', 5),
            pin('B', 0),
            pin('B', 1),
            pin('A', 2),
            pin('A', 3),
            pin('A', 4),
            pin('A', 5),
            pin('A', 7),
        ],
    ),
    (
        Mode::Output,
        &[
            TRANSMIT,
            DRIVES_ENABLE,
            VALVES_ENABLE,
            DIRECTION[0],
            DIRECTION[1],
            DIRECTION[2],
            DIRECTION[3],
            RELAYS[0][0],
            RELAYS[0][1],
            RELAYS[1][0],
            RELAYS[1][1],
            HEATERS[0],
            HEATERS[1],
            HEATERS[2],
            HEATERS[3],
            HEATERS[4],
        ],
    ),
    // The receiver of RS-485, the encoders, the flow meter: TIM5, TIM3, TIM4, TIM1, TIM2.
    (
        Mode::Floating,
        &[
            pin('A', 10),
            pin('A', 0),
            pin('A', 1),
            pin('B', 4),
            pin('B', 5),
            pin('B', 6),
            pin('B', 7),
            pin('E', 9),
            pin('E', 11),
            pin('B', 3),
        ],
    ),
    (
        Mode::Contact,
        &[
            STOP_CHAIN,
            MOTOR_LIVE[0],
            MOTOR_LIVE[1],
            MOTOR_LIVE[2],
            MOTOR_LIVE[3],
            ENDS[0][0],
            ENDS[0][1],
            ENDS[1][0],
            ENDS[1][1],
            ENDS[2][0],
            ENDS[2][1],
            ENDS[3][0],
            ENDS[3][1],
            DEPLOYER_AT[0],
            DEPLOYER_AT[1],
            VALVE_AT[0][0],
            VALVE_AT[0][1],
            VALVE_AT[1][0],
            VALVE_AT[1][1],
            VALVE_FREE[0],
            VALVE_FREE[1],
            MIRRORS[0][0],
            MIRRORS[0][1],
            MIRRORS[1][0],
            MIRRORS[1][1],
            HEATER_LIVE[0],
            HEATER_LIVE[1],
            HEATER_LIVE[2],
            HEATER_LIVE[3],
            HEATER_LIVE[4],
            PARKED,
        ],
    ),
    // The transmitter of USART1, and the PWM of TIM8.
    (Mode::Alternate, &[pin('A', 9), pin('C', 6), pin('C', 7), pin('C', 8), pin('C', 9)]),
];

impl Pin {
    fn gpio(self) -> Gpio {
        match self.port {
            0 => GPIOA,
            1 => GPIOB,
            2 => GPIOC,
            3 => GPIOD,
            _ => GPIOE,
        }
    }

    /// Drives it.
    pub fn drive(self, bus: &impl Bus, high: bool) {
        // RM §9.2.5: the lower half sets, the upper clears, and no other pin is touched.
        bus.put(self.gpio().bsrr(), Bsrr(1 << (self.bit + if high { 0 } else { 16 })));
    }

    /// Whether it is high.
    pub fn is_high(self, bus: &impl Bus) -> bool {
        let Idr(bits) = bus.get(self.gpio().idr());
        bits >> self.bit & 1 != 0
    }

    /// Whether it is driven high.
    pub fn is_driven(self, bus: &impl Bus) -> bool {
        bus.get(self.gpio().odr()).0 >> self.bit & 1 != 0
    }

    fn set_mode(self, bus: &impl Bus, mode: Mode) {
        let shift = self.bit % 8 * 4;
        let register = self.gpio().cr(usize::from((self.bit / 8) & 1));
        bus.change(register, |Cr(bits)| *bits = *bits & !(0xF << shift) | (mode as u32) << shift);
    }
}

/// Sets up every pin: outputs low before they drive, contacts with their pull-ups.
pub fn start(bus: &impl Bus) {
    // RM §9.4.2. JTAG gives PA15, PB3 and PB4 away; SWD stays.
    bus.set(AFIO.mapr(), |mapr| {
        mapr.set_swj_cfg(SwjCfg::JTAG_DISABLE);
        mapr.set_tim1_remap(0b11);
        mapr.set_tim2_remap(0b01);
        mapr.set_tim3_remap(0b10);
        mapr.set_adc1_etrgreg_remap(true);
    });
    for (mode, pins) in WIRING {
        for pin in pins {
            // In a contact's pin the same bit chooses the pull-up (RM §9.1, table 20).
            pin.drive(bus, mode == Mode::Contact);
            pin.set_mode(bus, mode);
        }
    }
}
