//! Contacts and relays: valves, deployer, heaters. Each contact is of the kind whose broken wire reads as
//! the safe side: an end switch opens at the end, a valve's switch closes where it is.

use crate::bus::Bus;
use crate::pins::{
    DEPLOYER_AT, HEATER_LIVE, HEATERS, MIRRORS, Pin, RELAYS, VALVE_AT, VALVE_FREE, VALVES_ENABLE,
};
use lafet_device::image::{DriveInput, PlaceInput, ValveInput, ValveOutput};

/// How long what is read back may differ from what is commanded, and two contacts of one place from each
/// other, ms.
const DIFFER_MS: u32 = 100;

/// What is read back of relays and contacts.
#[derive(Clone, Debug)]
pub struct Contacts<B> {
    bus: B,
    relays: [[bool; 2]; 2],
    relay_ms: u32,
    /// A relay has been on that nothing had commanded: over until the next start.
    welded: bool,
    heaters: [bool; 5],
    heater_ms: [u32; 5],
    deployer_ms: u32,
}

fn is_closed(bus: &impl Bus, pin: Pin) -> bool {
    !pin.is_high(bus)
}

/// Time for which something is so.
fn lasting(ms: &mut u32, dt_ms: u32, is_so: bool) -> bool {
    *ms = if is_so { ms.saturating_add(dt_ms) } else { 0 };
    *ms > DIFFER_MS
}

impl<B: Bus> Contacts<B> {
    /// Everything off.
    pub const fn new(bus: B) -> Self {
        Self {
            bus,
            relays: [[false; 2]; 2],
            relay_ms: 0,
            welded: false,
            heaters: [false; 5],
            heater_ms: [0; 5],
            deployer_ms: 0,
        }
    }

    /// Samples the valves; `current_da` is that of all that are driven, so it is believed of one that is
    /// driven alone: a valve that jams must not keep the other from closing.
    pub fn read_valves(&mut self, dt_ms: u32, inputs: &mut [ValveInput; 2], current_da: u16) {
        let bus = &self.bus;
        let mirrors = MIRRORS.map(|pair| pair.map(|pin| is_closed(bus, pin)));
        let stray = mirrors.iter().flatten().zip(self.relays.iter().flatten());
        let stray = stray.into_iter().any(|(mirror, relay)| *mirror && !relay);
        self.welded |= lasting(&mut self.relay_ms, dt_ms, stray);
        let alone = self.relays.iter().flatten().filter(|relay| **relay).count() == 1;
        let parts = inputs.iter_mut().zip(VALVE_AT).zip(VALVE_FREE.iter().zip(self.relays));
        for ((input, [open, closed]), (free, relays)) in parts {
            // Which of the two contacts is wrong cannot be seen here; the core finds a contradiction.
            *input = ValveInput::default();
            input.open_switch = is_closed(bus, open);
            input.close_switch = is_closed(bus, closed);
            input.current_da = if alone && relays != [false; 2] { current_da } else { 0 };
            input.blocked = self.welded || !is_closed(bus, *free);
        }
    }

    /// The deployer has a second contact at each end, of the other kind: where the two disagree it is at
    /// neither.
    pub fn read_deployer(&mut self, dt_ms: u32, input: &mut DriveInput) {
        let [wrapped, deployed] = DEPLOYER_AT.map(|pin| is_closed(&self.bus, pin));
        let differ = wrapped != input.min_switch || deployed != input.max_switch;
        input.position_sensor_fault |= lasting(&mut self.deployer_ms, dt_ms, differ);
        input.min_switch &= wrapped;
        input.max_switch &= deployed;
    }

    /// Whether each heater draws current as it should.
    pub fn read_heaters(&mut self, dt_ms: u32, inputs: &mut [PlaceInput; 5]) {
        let parts =
            inputs.iter_mut().zip(HEATER_LIVE).zip(self.heaters.iter().zip(&mut self.heater_ms));
        for ((input, live), (on, ms)) in parts {
            input.heater_fault = lasting(ms, dt_ms, is_closed(&self.bus, live) != *on);
        }
    }

    /// Drives relays and heaters; with a welded relay none has power. `may` is for all of them, `may_close` for
    /// valves that close.
    pub fn write(
        &mut self,
        valves: [ValveOutput; 2],
        heaters: [bool; 5],
        may: bool,
        may_close: bool,
    ) {
        let (may, may_close) = (may && !self.welded, may_close && !self.welded);
        self.relays = valves.map(|valve| match valve {
            ValveOutput::Opening => [may, false],
            ValveOutput::Closing => [false, may_close],
            ValveOutput::Off => [false; 2],
        });
        let closes = self.relays.iter().any(|[_, closes]| *closes);
        VALVES_ENABLE.drive(&self.bus, may || closes);
        for (pins, states) in RELAYS.iter().zip(self.relays) {
            // What goes off goes first: the two of a valve are never on together.
            for on in [false, true] {
                for (pin, state) in pins.iter().zip(states) {
                    if state == on {
                        pin.drive(&self.bus, on);
                    }
                }
            }
        }
        self.heaters = heaters.map(|heater| heater && may);
        for (pin, on) in HEATERS.iter().zip(self.heaters) {
            pin.drive(&self.bus, on);
        }
    }
}
