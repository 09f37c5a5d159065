//! The four drives: PWM of TIM8 with its hardware break, a direction each, encoders on TIM5, TIM3, TIM4
//! and TIM1, and what of the power stages is read back (RM §14, §15).
//!
//! A stage works while it is armed: the stop chain is closed, the supply is there, what is read back is
//! what was commanded. What ends one of these ends it in hardware or within a step, and it is armed again
//! only while nothing is commanded: no motion goes on by itself.

use crate::bus::{Bus, Registers};
use crate::pins::{DIRECTION, DRIVES_ENABLE, ENDS, MOTOR_LIVE, PARKED, RELAYS, STOP_CHAIN};
use crate::power;
use crate::record::DriveRecord;
use lafet_device::image::DriveInput;
use stm32_metapac::common::{RW, Reg};
use stm32_metapac::timer::regs::{ArrCore, CcmrInput2ch, CntCore, Cr1Gp16, SmcrGp16};
use stm32_metapac::timer::vals::{
    Bkp, CcmrInputCcs, Cms, FilterValue, Lock, Mms, Ocm, Ossi, Ossr, Sms,
};
use stm32_metapac::{TIM1, TIM3, TIM4, TIM5, TIM8};

/// The PWM, Hz.
const PWM_HZ: u32 = 20_000;
/// The nozzle is measured in mm, the others in minutes of arc.
const NOZZLE: usize = 2;
/// How long what is read back may differ from what is commanded, ms.
const DIFFER_MS: u32 = 100;
/// A motor without voltage is tried again after this time, ms.
const DEAD_MS: u32 = 3_000;
/// All drives must have been at rest for this time before positions are stored, ms.
const STILL_MS: u32 = 200;
/// The integral of a speed's error takes so many ms of it for as much voltage.
const INTEGRAL_MS: i32 = 128;
/// The integral gives a third of the voltage at most.
const INTEGRAL_PART: i32 = 3;

/// A drive's encoder, speed loop and read-back.
#[derive(Clone, Copy, Debug, Default)]
struct Drive {
    record: DriveRecord,
    last: u16,
    counts: i32,
    /// Sixteen times the mean speed, counts/s.
    speed_16: i32,
    /// Sum of the speed's error, 0.1 °/s · ms.
    integral: i32,
    /// 0 to the PWM's top, as driven; and the direction.
    duty: u32,
    up: bool,
    /// Time for which the motor has had voltage without a command, or none in spite of one, ms.
    live_ms: u32,
    dead_ms: u32,
    /// Time for which it is still reported as broken, ms.
    broken_ms: u32,
}

impl Drive {
    /// To the nearest unit.
    fn position(&self) -> i32 {
        let scale = self.record.counts_per_100;
        let hundredfold = self.counts.saturating_mul(100);
        let half = scale.saturating_abs() / 2 * hundredfold.signum();
        hundredfold.saturating_add(half).checked_div(scale).unwrap_or_default()
    }

    fn speed_tenths(&self, index: usize) -> i32 {
        let of = |factor: i32| {
            let speed = (self.speed_16 / 16).saturating_mul(factor);
            speed.checked_div(self.record.counts_per_100).unwrap_or_default()
        };
        // 6' a second are 0.1 °/s; 0.1 mm a second are 0.1 mm/s.
        if index == NOZZLE { of(1_000) } else { of(100) / 6 }
    }

    /// Takes the encoder's count.
    fn sample(&mut self, count: u16, dt_ms: u32) {
        let moved = i32::from(count.wrapping_sub(self.last).cast_signed());
        self.last = count;
        self.counts = self.counts.wrapping_add(moved);
        let speed = (moved * 1_000).checked_div(dt_ms.cast_signed()).unwrap_or_default();
        self.speed_16 += speed - self.speed_16 / 16;
    }

    /// The duty for a speed: what it takes without load, and the integral of what is missing.
    fn duty(&mut self, wanted: i32, measured: i32, dt_ms: u32, top: u32) -> u32 {
        let full = i32::from(self.record.full_tenths).max(1);
        let up = wanted > 0;
        // A change of direction goes through a step without voltage.
        if wanted == 0 || self.duty > 0 && up != self.up {
            self.integral = 0;
            return 0;
        }
        self.up = up;
        let missing = if up { wanted - measured } else { measured - wanted };
        let most = full * INTEGRAL_MS / INTEGRAL_PART;
        let more = missing.saturating_mul(dt_ms.min(10).cast_signed());
        self.integral = self.integral.saturating_add(more).clamp(-most, most);
        let speed = wanted.abs().min(full) * INTEGRAL_MS + self.integral;
        // 1,000 · 128 · 4/3 · 1,800 are 3 · 10⁸ at most.
        let duty = speed.max(0).cast_unsigned() * top;
        duty.checked_div((full * INTEGRAL_MS).cast_unsigned()).unwrap_or_default().min(top)
    }
}

/// The drives.
#[derive(Clone, Debug)]
pub struct Drives<B> {
    bus: B,
    drives: [Drive; 4],
    top: u32,
    armed: bool,
    /// A motor has had voltage that nothing had commanded: over until the next start.
    tripped: bool,
    /// The counts mean ways.
    has_record: bool,
    /// The positions are known.
    referenced: bool,
    still_ms: u32,
}

impl<B: Bus> Drives<B> {
    /// Starts PWM and encoders, with nothing driven. The positions are those kept, or those of a parked
    /// barrel where the jumper says so, or unknown; without a record no count means a position.
    pub fn start(bus: B, hz: u32, records: &[DriveRecord; 4], has_record: bool) -> Self {
        let top = hz / PWM_HZ / 2;
        pwm(&bus, top);
        encoders(&bus);
        let mut drives = [Drive::default(); 4];
        let parked = !PARKED.is_high(&bus);
        let kept = power::kept(&bus);
        let places = drives.iter_mut().zip(records).zip(kept.unwrap_or_default());
        for (index, ((drive, record), count_kept)) in places.enumerate() {
            drive.record = *record;
            drive.last = count(&bus, index);
            drive.counts = match parked {
                true => record.parked.saturating_mul(record.counts_per_100) / 100,
                false => count_kept,
            };
        }
        let referenced = has_record && (parked || kept.is_some());
        Self { bus, drives, top, armed: false, tripped: false, has_record, referenced, still_ms: 0 }
    }

    /// Samples encoders, end switches and what is read back. `current` gives 0.1 A of a drive.
    pub fn read(
        &mut self,
        dt_ms: u32,
        inputs: &mut [DriveInput; 4],
        current: impl Fn(usize) -> u16,
    ) {
        let armed = self.armed;
        let (bus, top) = (&self.bus, self.top);
        let mut still = true;
        let parts = self.drives.iter_mut().zip(inputs).zip(ENDS.iter().zip(MOTOR_LIVE));
        for (index, ((drive, input), ([lower, upper], live))) in parts.enumerate() {
            drive.sample(count(bus, index), dt_ms);
            let position = drive.position();
            let (min, max) = drive.record.ends;
            // A chain that is open is an end, or a broken wire: both stop it.
            let (at_min, at_max) = (lower.is_high(bus), upper.is_high(bus));
            // An end where there is none: a sixteenth of the travel is more than any overshoot.
            let margin = (max - min) / 16;
            let far_from_min = at_min && position > min + margin;
            let far_from_max = at_max && position < max - margin;
            let far = self.referenced && (far_from_min || far_from_max);
            let absurd = (at_min && at_max) || far;
            let has_voltage = !live.is_high(bus);
            drive.live_ms = if has_voltage && drive.duty == 0 { drive.live_ms + dt_ms } else { 0 };
            let must = armed && drive.duty > top / 8;
            drive.dead_ms = if must && !has_voltage { drive.dead_ms + dt_ms } else { 0 };
            drive.broken_ms = match drive.dead_ms > DIFFER_MS {
                true => DEAD_MS,
                false => drive.broken_ms.saturating_sub(dt_ms),
            };
            self.tripped |= drive.live_ms > DIFFER_MS;
            still &= drive.duty == 0 && drive.speed_16 / 16 == 0;
            let tenths = drive.speed_tenths(index);
            *input = DriveInput::default();
            input.position = position;
            input.speed_tenths = tenths.clamp(i16::MIN.into(), i16::MAX.into()) as i16;
            input.current_da = current(index);
            (input.min_switch, input.max_switch) = (at_min, at_max);
            input.motor_open = !armed || drive.broken_ms > 0;
            input.position_sensor_fault = !self.has_record || absurd;
            input.unreferenced = !self.referenced;
        }
        self.keep(still, dt_ms);
    }

    /// Positions are stored once all drives are at rest, and invalid from the next motion on.
    fn keep(&mut self, still: bool, dt_ms: u32) {
        let before = self.still_ms;
        self.still_ms = if still { before.saturating_add(dt_ms) } else { 0 };
        if !still && before > 0 {
            power::forget(&self.bus);
        } else if before < STILL_MS && self.still_ms >= STILL_MS && self.referenced {
            power::keep(&self.bus, &self.drives.map(|drive| drive.counts));
        }
    }

    /// The encoders' counts at this moment.
    pub fn counts(&self) -> [u16; 4] {
        [0, 1, 2, 3].map(|index| count(&self.bus, index))
    }

    /// Stores the positions before a reset, after everything has stopped: `resting` are the counts of a
    /// while ago. A drive that still coasts has lost its position.
    pub fn keep_before_reset(&mut self, resting: [u16; 4]) {
        if self.counts() == resting && self.referenced {
            for (drive, count) in self.drives.iter_mut().zip(resting) {
                drive.sample(count, 1);
            }
            power::keep(&self.bus, &self.drives.map(|drive| drive.counts));
        }
    }

    /// Drives these speeds, 0.1 °/s or 0.1 mm/s, if the stages are armed. `may` says whether they may be.
    pub fn write(&mut self, wanted: [i16; 4], dt_ms: u32, may: bool) {
        let may = may && !self.tripped && !STOP_CHAIN.is_high(&self.bus);
        // The break has taken MOE away by itself (RM §14.3.12).
        if self.armed && (!may || !self.bus.get(TIM8.bdtr()).moe()) {
            self.disarm();
        } else if !self.armed && may && wanted == [0; 4] {
            self.arm();
        }
        let (bus, top, armed) = (&self.bus, self.top, self.armed);
        let parts = self.drives.iter_mut().zip(wanted).zip(DIRECTION);
        for (index, ((drive, wanted), direction)) in parts.enumerate() {
            let measured = drive.speed_tenths(index);
            let wanted = if armed { i32::from(wanted) } else { 0 };
            drive.duty = drive.duty(wanted, measured, dt_ms, top);
            if drive.duty > 0 {
                direction.drive(bus, drive.up != drive.record.is_reversed);
            }
            bus.set(TIM8.ccr(index & 3), |ccr| ccr.set_ccr(drive.duty as u16));
        }
    }

    /// Nothing is driven, at once.
    pub fn disarm(&mut self) {
        self.armed = false;
        DRIVES_ENABLE.drive(&self.bus, false);
        self.bus.change(TIM8.bdtr(), |bdtr| bdtr.set_moe(false));
    }

    fn arm(&mut self) {
        self.armed = true;
        self.bus.change(TIM8.bdtr(), |bdtr| bdtr.set_moe(true));
        DRIVES_ENABLE.drive(&self.bus, true);
    }
}

/// Whether a drive has voltage or a valve is opening.
pub fn may_move(bus: &impl Bus) -> bool {
    let driven = (0..4).any(|index| bus.get(TIM8.ccr(index)).ccr() != 0);
    driven && bus.get(TIM8.bdtr()).moe() || RELAYS.iter().any(|[open, _]| open.is_driven(bus))
}

/// Centre-aligned, so that a period begins and ends in the middle of what is off; its trigger starts the
/// ADC once a period.
fn pwm(bus: &impl Bus, top: u32) {
    bus.set(TIM8.arr(), |arr| arr.set_arr(top as u16));
    for half in 0..2 {
        bus.set(TIM8.ccmr_output(half), |ccmr| {
            for channel in 0..2 {
                ccmr.set_ocm(channel, Ocm::PWM_MODE1);
                ccmr.set_ocpe(channel, true);
            }
        });
    }
    bus.set(TIM8.ccer(), |ccer| {
        for channel in 0..4 {
            ccer.set_cce(channel, true);
        }
    });
    bus.set(TIM8.cr2(), |cr2| cr2.set_mms(Mms::UPDATE));
    // RM §14.4.18: outputs are held low while MOE is off, the break cannot be switched off any more.
    bus.set(TIM8.bdtr(), |bdtr| {
        bdtr.set_ossi(Ossi::IDLE_LEVEL);
        bdtr.set_ossr(Ossr::IDLE_LEVEL);
        bdtr.set_bke(0, true);
        bdtr.set_bkp(0, Bkp::ACTIVE_HIGH);
        bdtr.set_lock(Lock::LEVEL1);
    });
    bus.set(TIM8.egr(), |egr| egr.set_ug(true));
    bus.set(TIM8.cr1(), |cr1| {
        cr1.set_cms(Cms::CENTER_ALIGNED1);
        cr1.set_arpe(true);
        cr1.set_cen(true);
    });
    // RM §14.3.3: written while it counts, so that updates come in the middle of what is on.
    bus.set(TIM8.rcr(), |rcr| rcr.set_rep(1));
}

/// The counters, both edges of both tracks, each level held for 3.5 µs before it counts (RM §15.3.12).
fn encoders(bus: &impl Bus) {
    type Timer = (Reg<CcmrInput2ch, RW>, Reg<ArrCore, RW>, Reg<SmcrGp16, RW>, Reg<Cr1Gp16, RW>);
    let timers: [Timer; 4] = [
        (TIM5.ccmr_input(0), TIM5.arr(), TIM5.smcr(), TIM5.cr1()),
        (TIM3.ccmr_input(0), TIM3.arr(), TIM3.smcr(), TIM3.cr1()),
        (TIM4.ccmr_input(0), TIM4.arr(), TIM4.smcr(), TIM4.cr1()),
        (TIM1.ccmr_input(0), TIM1.arr(), TIM1.smcr(), TIM1.cr1()),
    ];
    for (inputs, top, mode, control) in timers {
        bus.set(inputs, filtered);
        bus.set(top, |arr| arr.set_arr(u16::MAX));
        bus.set(mode, |smcr| smcr.set_sms(Sms::ENCODER_MODE_3));
        bus.set(control, |cr1| cr1.set_cen(true));
    }
}

/// Both channels are inputs, and their longest filter.
pub(crate) fn filtered(ccmr: &mut CcmrInput2ch) {
    for channel in 0..2 {
        ccmr.set_ccs(channel, CcmrInputCcs::TI4);
        ccmr.set_icf(channel, FilterValue::FDTS_DIV32_N8);
    }
}

fn count(bus: &impl Bus, index: usize) -> u16 {
    let register: Reg<CntCore, RW> = match index {
        0 => TIM5.cnt(),
        1 => TIM3.cnt(),
        2 => TIM4.cnt(),
        _ => TIM1.cnt(),
    };
    bus.get(register).cnt()
}
