//! The ADC: thirteen inputs, sampled at the same moment of each period of the PWM and brought to memory
//! by DMA (RM §11, §13).

use crate::bus::{Bus, Registers, address};
use stm32_metapac::adc::vals::SampleTime;
use stm32_metapac::bdma::regs::Isr;
use stm32_metapac::bdma::vals::Size;
use stm32_metapac::{ADC1, DMA1};

/// Inputs in the order in which they are sampled: the four currents first, next to the PWM's trigger.
pub const CHANNELS: [u8; 13] = [10, 11, 12, 13, 8, 14, 15, 9, 2, 3, 4, 5, 7];
/// Bytes that the samples take.
pub const BYTES: usize = 2 * CHANNELS.len();
/// Places of what is sampled.
pub const VALVES: usize = 4;
/// The loop of the pressure sensor.
pub const LOOP: usize = 5;
/// The supply.
pub const SUPPLY: usize = 6;
/// Humidity.
pub const HUMIDITY: usize = 7;
/// The first of five temperatures.
pub const PLACES: usize = 8;
/// RM §11.12.3, table 70, with the remap of AFIO: TIM8_TRGO.
const BY_TIM8: u8 = 0b110;
/// Looks until a calibration must be over: some microseconds.
const LOOKS: u32 = 10_000;

/// The ADC.
#[derive(Clone, Debug)]
pub struct Analog<B> {
    bus: B,
    samples: u32,
}

impl<B: Bus> Analog<B> {
    /// Calibrates and arms it: the PWM starts each scan. The samples, [`BYTES`], are at this address.
    pub fn start(bus: B, samples: u32) -> Self {
        bus.set(ADC1.cr2(), |cr2| cr2.set_adon(true));
        // RM §11.4
        bus.change(ADC1.cr2(), |cr2| cr2.set_rstcal(true));
        bus.wait(ADC1.cr2(), LOOKS, |cr2| !cr2.rstcal());
        bus.change(ADC1.cr2(), |cr2| cr2.set_cal(true));
        bus.wait(ADC1.cr2(), LOOKS, |cr2| !cr2.cal());
        // 13.5 cycles of 12 MHz: 2.2 µs an input with the conversion, 28 µs for all, from 10 kΩ at most.
        bus.set(ADC1.smpr1(), |smpr| {
            for n in 0..8 {
                smpr.set_smp(n, SampleTime::CYCLES13_5);
            }
        });
        bus.set(ADC1.smpr2(), |smpr| {
            for n in 0..10 {
                smpr.set_smp(n, SampleTime::CYCLES13_5);
            }
        });
        let order = |from: usize, count: usize| {
            let channels = CHANNELS.iter().skip(from).take(count);
            channels.rev().fold(0, |bits, channel| bits << 5 | u32::from(*channel))
        };
        bus.write(address(ADC1.sqr3()), order(0, 6));
        bus.write(address(ADC1.sqr2()), order(6, 6));
        bus.write(address(ADC1.sqr1()), order(12, 1) | (CHANNELS.len() as u32 - 1) << 20);
        bus.set(ADC1.cr1(), |cr1| cr1.set_scan(true));
        let channel = DMA1.ch(0);
        bus.put(channel.par(), address(ADC1.dr()));
        bus.put(channel.mar(), samples);
        bus.set(channel.ndtr(), |ndtr| ndtr.set_ndt(CHANNELS.len() as u16));
        bus.set(channel.cr(), |cr| {
            cr.set_minc(true);
            cr.set_circ(true);
            cr.set_psize(Size::BITS16);
            cr.set_msize(Size::BITS16);
            cr.set_en(true);
        });
        bus.change(ADC1.cr2(), |cr2| {
            cr2.set_dma(true);
            cr2.set_extsel(BY_TIM8);
            cr2.set_exttrig(true);
        });
        Self { bus, samples }
    }

    /// Waits for the first scan: what is read before it says nothing.
    pub fn wait(&self) {
        self.bus.wait(DMA1.isr(), LOOKS, |isr| isr.tcif(0));
    }

    /// Whether a scan has ended since this was asked last.
    pub fn is_alive(&self) -> bool {
        let alive = self.bus.get(DMA1.isr()).tcif(0);
        self.bus.put(DMA1.ifcr(), Isr(0xF));
        alive
    }

    /// Twelve bits of an input, by its place.
    pub fn sample(&self, place: usize) -> u32 {
        let at = self.samples + 2 * place as u32;
        // In one access: between two the DMA may write another sample, half of which would be taken.
        self.bus.read(at & !3) >> (8 * (at & 2)) & 0xFFFF
    }
}

/// 0.1 °C of a sensor that gives 500 mV at 0 °C and 10 mV more a degree (TMP235), with 3.3 V full scale;
/// `None` outside of −40 to 125 °C: broken or shorted.
pub fn temperature_dc(sample: u32) -> Option<i16> {
    let millivolts = (sample * 3_300 / 4_096) as i16;
    let tenths = millivolts - 500;
    (-400..=1_250).contains(&tenths).then_some(tenths)
}

/// Per cent of a sensor that gives 0 to 3 V, 100 mV above ground when dry.
pub fn humidity_percent(sample: u32) -> Option<u8> {
    let millivolts = sample * 3_300 / 4_096;
    let percent = millivolts.checked_sub(100)? / 29;
    (percent <= 105).then_some(percent.min(100) as u8)
}
