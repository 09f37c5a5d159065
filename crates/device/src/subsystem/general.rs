//! §3.3.2 «Флаги состояния General»: configuration, supply voltage, pressure, lockout, reset.

use crate::hal::FaultInfo;
use crate::image::Inputs;
use crate::inputs::{LASTED, Lasting, lasted};
use crate::params::Params;
use crate::time::{Millis, Timer};
use lafet_proto::flags::GeneralFlags;
use lafet_proto::param::Param;
use lafet_proto::status::GeneralStatus;

/// §3.12/2 Time for the answer to leave before the reset: 512 bytes at 19200 baud, escapes aside.
pub const RESET_DELAY_MS: u32 = 200;
/// A 4–20 mA loop below this is broken, above the other shorted (NAMUR NE 43).
const LOOP_BREAK_UA: u16 = 3600;
const LOOP_SHORT_UA: u16 = 21_000;
/// A supply that sags while a motor starts comes back sooner, ms.
const WEAK_MS: u16 = 300;
const LOOP_ZERO_UA: u32 = 4000;
const LOOP_SPAN_UA: u32 = 16_000;

/// The pressure sensor's answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pressure {
    /// 0.1 atm.
    Datm(u16),
    Break,
    Short,
}

/// What resets the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reset {
    /// §3.12
    Restart,
    /// §3.19: the memory is erased first.
    CleanFlash,
}

/// The main subsystem.
#[derive(Clone, Debug, PartialEq)]
pub struct General {
    locked: bool,
    reset: Option<Reset>,
    reset_in: Timer,
    erase_failed: bool,
    pressure: Pressure,
    /// For how long its sensor has been faulty, ms.
    fault_ms: u8,
    voltage_v: u16,
    flow_lps: u16,
    bad_power: bool,
    weak: Lasting,
    crash: FaultInfo,
}

impl Default for General {
    fn default() -> Self {
        Self {
            locked: false,
            reset: None,
            reset_in: Timer::default(),
            erase_failed: false,
            pressure: Pressure::Datm(0),
            fault_ms: LASTED,
            voltage_v: 0,
            flow_lps: 0,
            bad_power: false,
            weak: Lasting::default(),
            crash: FaultInfo::NONE,
        }
    }
}

impl General {
    /// §3.20 What a fault before this start has left.
    pub(crate) fn set_crash(&mut self, crash: FaultInfo) {
        self.crash = crash;
    }

    /// §3.18 Locked out.
    pub const fn is_locked(&self) -> bool {
        self.locked
    }

    pub(crate) fn set_locked(&mut self, on: bool) {
        self.locked = on;
    }

    /// §3.12/2 Waiting for the reset.
    pub const fn is_restarting(&self) -> bool {
        self.reset.is_some()
    }

    pub(crate) fn schedule(&mut self, now: Millis, reset: Reset) {
        self.reset = Some(reset);
        self.reset_in.start(now, RESET_DELAY_MS);
    }

    /// The reset whose time has come, once.
    pub(crate) fn poll_reset(&mut self, now: Millis) -> Option<Reset> {
        if self.reset_in.poll(now) { self.reset } else { None }
    }

    /// §3.19 The memory could not be erased: no reset, and the flag says so.
    pub(crate) fn erase_failed(&mut self) {
        self.reset = None;
        self.erase_failed = true;
    }

    /// §3.3.1 The supply voltage is out of range.
    pub const fn has_bad_power(&self) -> bool {
        self.bad_power
    }

    /// §3.3.1/4 The supply has been out of range for so long that nothing may begin.
    pub(crate) const fn is_weak(&self) -> bool {
        self.weak.holds
    }

    /// Pressure, 0.1 atm; `None` when its sensor is faulty.
    pub(crate) const fn pressure_datm(&self) -> Option<u16> {
        match self.pressure {
            Pressure::Datm(value) => Some(value),
            Pressure::Break | Pressure::Short => None,
        }
    }

    /// §3.20
    pub(crate) const fn crash(&self) -> FaultInfo {
        self.crash
    }

    #[inline(never)]
    pub(crate) fn step(&mut self, dt_ms: u32, inputs: &Inputs, params: &Params) {
        let sensed = pressure(inputs.pressure_ua, params.get(Param::GeneralPressureRange));
        let faulty = !matches!(sensed, Pressure::Datm(_));
        // For a blip of its wire the barrel must not leave the fire.
        if lasted(&mut self.fault_ms, dt_ms, faulty) || !faulty {
            self.pressure = sensed;
        }
        self.voltage_v = inputs.main_voltage_dv.saturating_add(5) / 10;
        self.flow_lps = inputs.flow_lps;
        let volts = i32::from(self.voltage_v);
        // §3.3.1/4
        self.bad_power = volts < params.get(Param::GeneralMainVoltageMin)
            || volts > params.get(Param::GeneralMainVoltageMax);
        self.weak.step(dt_ms, self.bad_power, WEAK_MS);
    }

    /// §3.3 GeneralStatus; `common` holds the flags of the configuration.
    pub(crate) fn status(&self, common: u32) -> GeneralStatus {
        let mut flags = GeneralFlags::from_bits_retain(common);
        flags.set(GeneralFlags::PRESSURE_SENSOR_BREAK, self.pressure == Pressure::Break);
        flags.set(GeneralFlags::PRESSURE_SENSOR_SHORT, self.pressure == Pressure::Short);
        flags.set(GeneralFlags::LOCKED_OUT, self.locked);
        if self.erase_failed {
            flags |= GeneralFlags::CONFIG_WRITE_FAULT;
        }
        GeneralStatus {
            flags,
            main_voltage: self.voltage_v,
            // §3.3.2/1
            pressure: self.pressure_datm().unwrap_or(0),
            flowrate: self.flow_lps,
        }
    }
}

fn pressure(loop_ua: u16, range_datm: i32) -> Pressure {
    match loop_ua {
        ..LOOP_BREAK_UA => Pressure::Break,
        LOOP_BREAK_UA..=LOOP_SHORT_UA => {
            let above = u32::from(loop_ua).saturating_sub(LOOP_ZERO_UA);
            let datm = above.saturating_mul(range_datm.unsigned_abs()) + LOOP_SPAN_UA / 2;
            Pressure::Datm((datm / LOOP_SPAN_UA).min(u16::MAX.into()) as u16)
        }
        _ => Pressure::Short,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// §3.3.2/1
    #[test]
    fn pressure_loop() {
        assert_eq!(pressure(4000, 160), Pressure::Datm(0));
        assert_eq!(pressure(12_000, 160), Pressure::Datm(80));
        assert_eq!(pressure(20_000, 160), Pressure::Datm(160));
        assert_eq!(pressure(3900, 160), Pressure::Datm(0));
        // To the nearest.
        assert_eq!(pressure(4050, 160), Pressure::Datm(1));
        assert_eq!(pressure(4049, 160), Pressure::Datm(0));
        assert_eq!(pressure(3500, 160), Pressure::Break);
        assert_eq!(pressure(21_500, 160), Pressure::Short);
    }
}
