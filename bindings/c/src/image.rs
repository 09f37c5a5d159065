//! The process image for C: what a monitor senses and drives.

use ::lafet_device::image::{
    self, AXES, Inputs, Outputs, PLACES, SPOTS, UNITS, VALVES, ValveOutput,
};
use lafet_proto::flags::ButtonState;

/// A temperature whose sensor is faulty.
pub const LAFET_NO_TEMPERATURE: i16 = i16::MIN;
/// Relative humidity whose sensor is faulty.
pub const LAFET_NO_HUMIDITY: u8 = 255;

/// A drive as sensed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct lafet_drive_input {
    /// Position from the encoder's own zero, arc-minutes or mm.
    pub position: i32,
    /// Measured speed, signed, 0.1 °/s or 0.1 mm/s.
    pub speed_tenths: i16,
    /// Motor current, 0.1 A.
    pub current_da: u16,
    /// End switch at the lower / right / wider / wrapped end.
    pub min_switch: bool,
    /// End switch at the upper / left / narrower / deployed end.
    pub max_switch: bool,
    /// The power stage finds the motor circuit open.
    pub motor_open: bool,
    /// The position sensor's own diagnosis.
    pub position_sensor_fault: bool,
    /// The speed sensor's own diagnosis.
    pub speed_sensor_fault: bool,
}

/// A valve as sensed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct lafet_valve_input {
    /// Limit switch "open".
    pub open_switch: bool,
    /// Limit switch "closed".
    pub close_switch: bool,
    /// Circuit of the "open" switch broken or shorted.
    pub open_sensor_fault: bool,
    /// Circuit of the "closed" switch broken or shorted.
    pub close_sensor_fault: bool,
    /// Motor current, 0.1 A.
    pub current_da: u16,
    /// The hardware block of the valve is on.
    pub blocked: bool,
}

/// A hot spot in the detector's field of view, offsets from its axis in arc-minutes.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct lafet_spot {
    /// Left edge (positive is left).
    pub left: i16,
    /// Right edge.
    pub right: i16,
    /// Lower edge.
    pub bottom: i16,
    /// Upper edge.
    pub top: i16,
    /// Brightness.
    pub brightness: i32,
}

/// What a monitor senses. Drives: vertical, horizontal, nozzle, deployer. Places: horizontal,
/// vertical, nozzle, deployer, housing. Remote units are not in it: drives and valves are wired.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct lafet_inputs {
    /// The drives.
    pub drives: [lafet_drive_input; 4],
    /// The valves.
    pub valves: [lafet_valve_input; 2],
    /// Temperatures, 0.1 °C.
    pub temperatures_dc: [i16; 5],
    /// A heater draws no current when on, or draws it when off.
    pub heater_faults: [bool; 5],
    /// Relative humidity, %.
    pub humidity_percent: u8,
    /// Supply voltage, 0.1 V.
    pub main_voltage_dv: u16,
    /// Current of the pressure sensor's loop, µA.
    pub pressure_ua: u16,
    /// Flow, l/s.
    pub flow_lps: u16,
    /// The detector answers and its self-test passes.
    pub detector_ready: bool,
    /// Its glass is dirty.
    pub detector_dirty: bool,
    /// Hot spots, brightest first.
    pub spots: [lafet_spot; 4],
    /// How many of them there are.
    pub spot_count: u8,
    /// Buttons of both posts in the order of §3.3.10: 0 released, 1 pressed, 2 shorted, 3 open circuit.
    pub buttons: [[u8; 8]; 2],
}
const _: () = assert!(AXES == 4 && VALVES == 2 && PLACES == 5 && SPOTS == 4 && UNITS == 6);

/// What a monitor drives.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct lafet_outputs {
    /// Speeds of the drives, signed, 0.1 °/s or 0.1 mm/s; 0 = stopped and held.
    pub speeds_tenths: [i16; 4],
    /// Motors of the valves: 1 towards open, -1 towards closed, 0 off.
    pub valves: [i8; 2],
    /// Heaters, by place.
    pub heaters: [bool; 5],
    /// Supplies of drives that are to be cut: they turn though they are not fed.
    pub cut: [bool; 4],
}

pub(crate) fn sense(from: &lafet_inputs, to: &mut Inputs) {
    for (to, from) in to.drives.iter_mut().zip(&from.drives) {
        to.position = from.position;
        to.speed_tenths = from.speed_tenths;
        to.current_da = from.current_da;
        to.min_switch = from.min_switch;
        to.max_switch = from.max_switch;
        to.motor_open = from.motor_open;
        to.position_sensor_fault = from.position_sensor_fault;
        to.speed_sensor_fault = from.speed_sensor_fault;
    }
    for (to, from) in to.valves.iter_mut().zip(&from.valves) {
        to.open_switch = from.open_switch;
        to.close_switch = from.close_switch;
        to.open_sensor_fault = from.open_sensor_fault;
        to.close_sensor_fault = from.close_sensor_fault;
        to.current_da = from.current_da;
        to.blocked = from.blocked;
    }
    let places = from.temperatures_dc.iter().zip(&from.heater_faults);
    for (to, (temperature, fault)) in to.places.iter_mut().zip(places) {
        to.temperature_dc = Some(*temperature).filter(|t| *t != LAFET_NO_TEMPERATURE);
        to.heater_fault = *fault;
    }
    to.humidity_percent = Some(from.humidity_percent).filter(|h| *h != LAFET_NO_HUMIDITY);
    to.main_voltage_dv = from.main_voltage_dv;
    to.pressure_ua = from.pressure_ua;
    to.flow_lps = from.flow_lps;
    let count = usize::from(from.spot_count);
    to.detector.ready = from.detector_ready;
    to.detector.dirty_lens = from.detector_dirty;
    for (index, (to, from)) in to.detector.spots.iter_mut().zip(&from.spots).enumerate() {
        let &lafet_spot { left, right, bottom, top, brightness } = from;
        let spot = image::Spot { left, right, bottom, top, brightness };
        *to = Some(spot).filter(|_| index < count);
    }
    let buttons = to.buttons.as_flattened_mut().iter_mut().zip(from.buttons.as_flattened());
    for (to, from) in buttons {
        *to = ButtonState::of(u32::from(*from));
    }
}

pub(crate) fn drive(from: &Outputs) -> lafet_outputs {
    lafet_outputs {
        speeds_tenths: from.drives.map(|drive| drive.speed_tenths),
        valves: from.valves.map(|valve| match valve {
            ValveOutput::Off => 0,
            ValveOutput::Opening => 1,
            ValveOutput::Closing => -1,
        }),
        heaters: from.heaters,
        cut: from.drives.map(|drive| drive.cut),
    }
}
