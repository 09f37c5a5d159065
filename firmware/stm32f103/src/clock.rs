//! 72 MHz from the crystal; 64 MHz from the internal oscillator when there is none (RM §7.2).

use crate::bus::{Bus, Registers};
use stm32_metapac::flash::vals::Latency;
use stm32_metapac::rcc::vals::{Adcpre, Pllmul, Pllsrc, Ppre, Sw};
use stm32_metapac::{FLASH, RCC};

/// Looks until the crystal must swing: it starts within some milliseconds (tSU(HSE) of the datasheet),
/// and a look takes about 1 µs at 8 MHz.
const CRYSTAL_LOOKS: u32 = 50_000;
/// Looks until the PLL must have locked: 200 µs.
const PLL_LOOKS: u32 = 10_000;

/// What the chip runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clock {
    /// Processor, timers and APB2, Hz.
    pub hz: u32,
    /// The crystal swings; watched from now on, a failure breaks the PWM and resets the program.
    pub is_external: bool,
}

/// Starts the clocks, from the state after a reset: HSI, 8 MHz.
pub fn start(bus: &impl Bus) -> Clock {
    // RM §3.3.3: two wait states above 48 MHz, before the clock rises.
    bus.set(FLASH.acr(), |acr| {
        acr.set_latency(Latency::WS2);
        acr.set_prftbe(true);
    });
    bus.change(RCC.cr(), |cr| cr.set_hseon(true));
    let is_external = bus.wait(RCC.cr(), CRYSTAL_LOOKS, |cr| cr.hserdy());
    let (source, factor, hz) = match is_external {
        true => (Pllsrc::HSE_DIV_PREDIV, Pllmul::MUL9, 72_000_000),
        false => (Pllsrc::HSI_DIV2, Pllmul::MUL16, 64_000_000),
    };
    bus.set(RCC.cfgr(), |cfgr| {
        cfgr.set_pllsrc(source);
        cfgr.set_pllmul(factor);
        // RM §7.3.2: APB1 36 MHz at most, the ADC 14 MHz.
        cfgr.set_ppre1(Ppre::DIV2);
        cfgr.set_adcpre(Adcpre::DIV6);
    });
    bus.change(RCC.cr(), |cr| cr.set_pllon(true));
    let locked = bus.wait(RCC.cr(), PLL_LOOKS, |cr| cr.pllrdy());
    if locked {
        bus.change(RCC.cfgr(), |cfgr| cfgr.set_sw(Sw::PLL1_P));
        bus.wait(RCC.cfgr(), PLL_LOOKS, |cfgr| cfgr.sws() == Sw::PLL1_P);
    }
    bus.change(RCC.cr(), |cr| match is_external {
        true => cr.set_csson(true),
        false => cr.set_hseon(false),
    });
    peripherals(bus);
    Clock { hz: if locked { hz } else { 8_000_000 }, is_external: is_external && locked }
}

/// Gives their clocks to the peripherals that are used.
fn peripherals(bus: &impl Bus) {
    bus.change(RCC.ahbenr(), |enable| enable.set_dma1en(true));
    bus.set(RCC.apb2enr(), |enable| {
        enable.set_afioen(true);
        enable.set_gpioaen(true);
        enable.set_gpioben(true);
        enable.set_gpiocen(true);
        enable.set_gpioden(true);
        enable.set_gpioeen(true);
        enable.set_adc1en(true);
        enable.set_tim1en(true);
        enable.set_tim8en(true);
        enable.set_usart1en(true);
    });
    bus.set(RCC.apb1enr(), |enable| {
        enable.set_tim2en(true);
        enable.set_tim3en(true);
        enable.set_tim4en(true);
        enable.set_tim5en(true);
        enable.set_tim6en(true);
        enable.set_bkpen(true);
        enable.set_pwren(true);
    });
}
