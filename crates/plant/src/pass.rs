//! One description of the image for both directions: a value is passed by reference, and either
//! written or replaced.

use lafet_device::image::{
    DetectorInput, DriveInput, Inputs, Outputs, PlaceInput, Spot, UnitError, UnitInput, UnitOp,
    UnitReply, ValveInput, ValveOutput,
};
use lafet_proto::flags::ButtonState;

/// A direction of the exchange.
pub trait Pass {
    /// Writes the byte, or replaces it with the one that was read.
    fn byte(&mut self, value: &mut u8);

    /// Marks the input as invalid.
    fn refuse(&mut self);
}

/// Writes to a buffer.
pub struct Writer<'b> {
    buffer: &'b mut [u8],
    len: usize,
    full: bool,
}

impl<'b> Writer<'b> {
    pub const fn new(buffer: &'b mut [u8]) -> Self {
        Self { buffer, len: 0, full: false }
    }

    pub fn put(&mut self, value: u8) {
        match self.buffer.get_mut(self.len) {
            Some(place) => *place = value,
            None => self.full = true,
        }
        self.len += 1;
    }

    /// The bytes written; `None` when they did not fit.
    pub fn written(self) -> Option<&'b [u8]> {
        self.buffer.get(..self.len).filter(|_| !self.full)
    }
}

impl Pass for Writer<'_> {
    fn byte(&mut self, value: &mut u8) {
        self.put(*value);
    }

    fn refuse(&mut self) {}
}

/// Reads from a buffer.
pub struct Reader<'b> {
    rest: &'b [u8],
    bad: bool,
}

impl<'b> Reader<'b> {
    pub const fn new(bytes: &'b [u8]) -> Self {
        Self { rest: bytes, bad: false }
    }

    pub fn take(&mut self) -> u8 {
        match self.rest.split_first() {
            Some((byte, rest)) => {
                self.rest = rest;
                *byte
            }
            None => {
                self.bad = true;
                0
            }
        }
    }

    /// The bytes not yet read.
    pub const fn rest(&self) -> &'b [u8] {
        self.rest
    }

    /// Whether the input was invalid or too short.
    pub const fn is_bad(&self) -> bool {
        self.bad
    }

    /// Whether the input was valid and has been read completely.
    pub const fn is_whole(&self) -> bool {
        !self.bad && self.rest.is_empty()
    }
}

impl Pass for Reader<'_> {
    fn byte(&mut self, value: &mut u8) {
        *value = self.take();
    }

    fn refuse(&mut self) {
        self.bad = true;
    }
}

pub fn word(pass: &mut impl Pass, value: &mut u16) {
    let mut bytes = value.to_le_bytes();
    bytes.iter_mut().for_each(|byte| pass.byte(byte));
    *value = u16::from_le_bytes(bytes);
}

pub fn number(pass: &mut impl Pass, value: &mut u32) {
    let mut bytes = value.to_le_bytes();
    bytes.iter_mut().for_each(|byte| pass.byte(byte));
    *value = u32::from_le_bytes(bytes);
}

fn signed_word(pass: &mut impl Pass, value: &mut i16) {
    let mut bits = value.cast_unsigned();
    word(pass, &mut bits);
    *value = bits.cast_signed();
}

fn signed(pass: &mut impl Pass, value: &mut i32) {
    let mut bits = value.cast_unsigned();
    number(pass, &mut bits);
    *value = bits.cast_signed();
}

fn choice(pass: &mut impl Pass, value: u8, count: u8) -> u8 {
    let mut byte = value;
    pass.byte(&mut byte);
    if byte >= count {
        pass.refuse();
    }
    byte
}

fn flag(pass: &mut impl Pass, value: &mut bool) {
    *value = choice(pass, u8::from(*value), 2) == 1;
}

/// Packs up to eight flags into one byte.
fn flags<const N: usize>(pass: &mut impl Pass, values: [&mut bool; N]) {
    let mut byte =
        values.iter().enumerate().fold(0, |byte, (n, value)| byte | u8::from(**value) << n);
    pass.byte(&mut byte);
    for (n, value) in values.into_iter().enumerate() {
        *value = byte >> n & 1 != 0;
    }
}

fn option<T: Default, P: Pass>(
    pass: &mut P,
    value: &mut Option<T>,
    inner: impl FnOnce(&mut P, &mut T),
) {
    let mut some = value.is_some();
    flag(pass, &mut some);
    *value = if some {
        let mut held = value.take().unwrap_or_default();
        inner(pass, &mut held);
        Some(held)
    } else {
        None
    };
}

/// All inputs.
pub fn inputs(pass: &mut impl Pass, image: &mut Inputs) {
    image.drives.iter_mut().for_each(|input| drive(pass, input));
    image.valves.iter_mut().for_each(|input| valve(pass, input));
    image.places.iter_mut().for_each(|input| place(pass, input));
    option(pass, &mut image.humidity_percent, |pass, value| pass.byte(value));
    word(pass, &mut image.main_voltage_dv);
    word(pass, &mut image.pressure_ua);
    word(pass, &mut image.flow_lps);
    detector(pass, &mut image.detector);
    image.buttons.iter_mut().flatten().for_each(|state| button(pass, state));
    image.units.iter_mut().for_each(|input| unit(pass, input));
}

/// All outputs.
pub fn outputs(pass: &mut impl Pass, image: &mut Outputs) {
    image.drives.iter_mut().for_each(|output| signed_word(pass, &mut output.speed_tenths));
    image.valves.iter_mut().for_each(|output| {
        *output = match choice(pass, *output as u8, 3) {
            1 => ValveOutput::Opening,
            2 => ValveOutput::Closing,
            _ => ValveOutput::Off,
        };
    });
    image.heaters.iter_mut().for_each(|heater| flag(pass, heater));
    flags(pass, image.drives.each_mut().map(|drive| &mut drive.cut));
    image.units.iter_mut().for_each(|operation| unit_operation(pass, operation));
}

fn drive(pass: &mut impl Pass, input: &mut DriveInput) {
    signed(pass, &mut input.position);
    signed_word(pass, &mut input.speed_tenths);
    word(pass, &mut input.current_da);
    let DriveInput {
        min_switch,
        max_switch,
        motor_open,
        position_sensor_fault,
        speed_sensor_fault,
        ..
    } = input;
    flags(pass, [min_switch, max_switch, motor_open, position_sensor_fault, speed_sensor_fault]);
}

fn valve(pass: &mut impl Pass, input: &mut ValveInput) {
    word(pass, &mut input.current_da);
    let ValveInput {
        open_switch,
        close_switch,
        open_sensor_fault,
        close_sensor_fault,
        blocked,
        ..
    } = input;
    flags(pass, [open_switch, close_switch, open_sensor_fault, close_sensor_fault, blocked]);
}

fn place(pass: &mut impl Pass, input: &mut PlaceInput) {
    option(pass, &mut input.temperature_dc, signed_word);
    flag(pass, &mut input.heater_fault);
}

fn detector(pass: &mut impl Pass, input: &mut DetectorInput) {
    flags(pass, [&mut input.ready, &mut input.dirty_lens]);
    input.spots.iter_mut().for_each(|spot| {
        option(pass, spot, |pass, Spot { left, right, bottom, top, brightness }| {
            [left, right, bottom, top].into_iter().for_each(|edge| signed_word(pass, edge));
            signed(pass, brightness);
        });
    });
}

fn button(pass: &mut impl Pass, state: &mut ButtonState) {
    const STATES: [ButtonState; 4] =
        [ButtonState::Released, ButtonState::Pressed, ButtonState::Short, ButtonState::Open];
    let place = STATES.iter().position(|known| known == state).unwrap_or_default();
    let read = choice(pass, place as u8, STATES.len() as u8);
    *state = STATES.get(usize::from(read)).copied().unwrap_or_default();
}

fn unit(pass: &mut impl Pass, input: &mut UnitInput) {
    let UnitInput { online, protocol_fault, watchdog_reset, .. } = input;
    flags(pass, [online, protocol_fault, watchdog_reset]);
    let mut reply = input.reply.map(|reply| (reply.seq, reply.result));
    let mut some = reply.is_some();
    flag(pass, &mut some);
    if !some {
        input.reply = None;
        return;
    }
    let (mut seq, result) = reply.take().unwrap_or((0, Ok(0)));
    pass.byte(&mut seq);
    const ERRORS: [UnitError; 4] =
        [UnitError::Incomplete, UnitError::BadId, UnitError::BadValue, UnitError::Internal];
    let kind = match result {
        Ok(_) => 0,
        Err(error) => 1 + ERRORS.iter().position(|known| *known == error).unwrap_or_default() as u8,
    };
    let read = choice(pass, kind, 1 + ERRORS.len() as u8);
    let result = match usize::from(read).checked_sub(1).and_then(|index| ERRORS.get(index)) {
        Some(error) => Err(*error),
        None => {
            let mut value = result.unwrap_or_default();
            signed(pass, &mut value);
            Ok(value)
        }
    };
    input.reply = Some(UnitReply { seq, result });
}

fn unit_operation(pass: &mut impl Pass, operation: &mut Option<UnitOp>) {
    let mut held = operation.map(|UnitOp { seq, param, write }| (seq, param, write));
    option(pass, &mut held, |pass, (seq, param, write)| {
        pass.byte(seq);
        word(pass, param);
        option(pass, write, signed);
    });
    *operation = held.map(|(seq, param, write)| UnitOp { seq, param, write });
}
