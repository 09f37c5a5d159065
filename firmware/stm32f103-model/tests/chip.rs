//! The rules of the model's chip, each by the section of the reference manual that says so (RM0008).

use lafet_stm32f103_model::chip::{Byte, Chip, Counter, RAM_START, Reset, pin};
use lafet_stm32f103_model::image::flash;

const RCC: u32 = 0x4002_1000;
const AFIO_MAPR: u32 = 0x4001_0004;
const PORT_A: u32 = 0x4001_0800;
const PORT_C: u32 = 0x4001_1000;
const TIM5: u32 = 0x4000_0C00;
const TIM8: u32 = 0x4001_3400;
const IWDG: u32 = 0x4000_3000;
const USART: u32 = 0x4001_3800;
const DMA: u32 = 0x4002_0000;
const FLASH: u32 = 0x4002_2000;
const MS: u64 = 1_000_000;

/// A chip whose peripherals all have their clock.
fn chip() -> Chip {
    let mut chip = Chip::new(flash(None));
    chip.write(RCC + 0x14, 0x15);
    chip.write(RCC + 0x18, 0x7EFD);
    chip.write(RCC + 0x1C, 0x1800_001F);
    chip
}

fn pass(chip: &mut Chip, ns: u64) {
    let until = chip.now_ns + ns;
    chip.advance(until);
}

/// RM §7.3.7: without its clock a peripheral takes nothing and reads as 0.
#[test]
fn a_peripheral_without_clock_is_not_there() {
    let mut chip = Chip::new(flash(None));
    chip.write(TIM8 + 0x2C, 1_800);
    assert_eq!(chip.read(TIM8 + 0x2C), 0);
    chip.write(RCC + 0x18, 1 << 13);
    chip.write(TIM8 + 0x2C, 1_800);
    assert_eq!(chip.read(TIM8 + 0x2C), 1_800);
}

/// RM §7.2, §7.3.1: the crystal and the PLL take their time; the clock is not in use before.
#[test]
fn clocks_take_their_time() {
    let mut chip = chip();
    chip.write(FLASH, 0x12);
    chip.write(RCC, 1 << 16 | 1);
    assert_eq!(chip.read(RCC) >> 17 & 1, 0);
    pass(&mut chip, 3 * MS);
    assert_eq!(chip.read(RCC) >> 17 & 1, 1);
    chip.write(RCC + 4, 7 << 18 | 1 << 16 | 0b10 << 14 | 0b100 << 8);
    chip.write(RCC, 1 << 24 | 1 << 16 | 1);
    chip.write(RCC + 4, 7 << 18 | 1 << 16 | 0b10 << 14 | 0b100 << 8 | 0b10);
    assert_eq!((chip.read(RCC + 4) >> 2 & 0b11, chip.hz()), (0, 8_000_000));
    pass(&mut chip, MS);
    assert_eq!((chip.read(RCC + 4) >> 2 & 0b11, chip.hz()), (0b10, 72_000_000));
    assert!(chip.violations.is_empty(), "{:?}", chip.violations);
}

/// A crystal that does not swing is never ready.
#[test]
fn a_dead_crystal_is_never_ready() {
    let mut chip = chip();
    chip.crystal = false;
    chip.write(RCC, 1 << 16 | 1);
    pass(&mut chip, 100 * MS);
    assert_eq!(chip.read(RCC) >> 17 & 1, 0);
}

/// RM §3.3.3, §7.3.2
#[test]
fn speeds_have_limits() {
    let mut chip = chip();
    chip.write(RCC + 4, 14 << 18);
    chip.write(RCC, 1 << 24 | 1);
    pass(&mut chip, MS);
    chip.write(RCC + 4, 14 << 18 | 0b10);
    assert_eq!(chip.hz(), 64_000_000);
    assert_eq!(chip.violations.len(), 3, "{:?}", chip.violations);
}

/// RM §19.3.2: 0x5555 opens the two registers, any other key closes them; it resets the chip in its time.
#[test]
fn the_watchdog_protects_its_registers() {
    let mut chip = chip();
    for key in [0x5555, 0xCCCC] {
        chip.write(IWDG, key);
    }
    chip.write(IWDG + 4, 4);
    chip.write(IWDG + 8, 625);
    assert_eq!((chip.read(IWDG + 4), chip.read(IWDG + 8)), (0, 0xFFF));
    pass(&mut chip, 405 * MS);
    assert_eq!(chip.reset, None);
    pass(&mut chip, 6 * MS);
    assert_eq!(chip.reset, Some(Reset::Watchdog));
    chip.start(Reset::Watchdog);
    assert_eq!(chip.read(RCC + 0x24) >> 29 & 1, 1);
    chip.write(IWDG, 0x5555);
    chip.write(IWDG + 4, 4);
    chip.write(IWDG + 8, 625);
    chip.write(IWDG, 0xCCCC);
    pass(&mut chip, 990 * MS);
    chip.write(IWDG, 0xAAAA);
    pass(&mut chip, 990 * MS);
    assert_eq!(chip.reset, None);
    pass(&mut chip, 20 * MS);
    assert_eq!(chip.reset, Some(Reset::Watchdog));
}

/// RM §19.3, §19.4.4: a new value is in use after five cycles of the oscillator; a reload before takes the old
/// one, the start the greatest.
#[test]
fn the_watchdog_takes_its_time_for_new_values() {
    let set = |chip: &mut Chip| {
        chip.write(RCC + 0x24, 1);
        chip.write(IWDG, 0x5555);
        chip.write(IWDG + 4, 4);
        chip.write(IWDG + 8, 625);
        assert_eq!(chip.read(IWDG + 12), 0b11);
    };
    // In use when it is reloaded, or not: 626 and 4,096 ticks of 1.6 ms.
    for (wait_ns, bites_ms) in [(126_000, 1_001), (0, 6_553)] {
        let mut chip = chip();
        set(&mut chip);
        pass(&mut chip, wait_ns);
        assert_eq!(chip.read(IWDG + 12) == 0, wait_ns > 0);
        chip.write(IWDG, 0xCCCC);
        chip.write(IWDG, 0xAAAA);
        pass(&mut chip, bites_ms * MS);
        assert_eq!(chip.reset, None);
        pass(&mut chip, MS);
        assert_eq!(chip.reset, Some(Reset::Watchdog));
        assert!(chip.violations.is_empty(), "{:?}", chip.violations);
    }
    let mut never_reloaded = chip();
    set(&mut never_reloaded);
    pass(&mut never_reloaded, MS);
    never_reloaded.write(IWDG, 0xCCCC);
    pass(&mut never_reloaded, 6_500 * MS);
    assert_eq!(never_reloaded.reset, None);
    let mut hasty = chip();
    set(&mut hasty);
    hasty.write(IWDG + 8, 100);
    assert_eq!((hasty.read(IWDG + 8), hasty.violations.len()), (625, 1));
}

/// RM §19.3.1: the option bytes may have it run from each reset on, with its shortest prescaler.
#[test]
fn the_watchdog_may_start_with_the_chip() {
    let mut chip = chip();
    chip.watchdog_at_reset = true;
    chip.start(Reset::Power);
    pass(&mut chip, 409 * MS);
    assert_eq!(chip.reset, None);
    pass(&mut chip, MS);
    assert_eq!(chip.reset, Some(Reset::Watchdog));
}

/// Without its oscillator nothing is in use until the start, which switches it on.
#[test]
fn the_watchdog_without_oscillator_takes_nothing() {
    let mut chip = chip();
    chip.write(IWDG, 0x5555);
    chip.write(IWDG + 8, 625);
    pass(&mut chip, 1_000 * MS);
    assert_eq!(chip.read(IWDG + 12), 0b10);
    chip.write(IWDG, 0xCCCC);
    pass(&mut chip, MS);
    assert_eq!(chip.read(IWDG + 12), 0);
}

/// RM §9.1, §9.2.5: a contact needs its pull-up, which takes its time to charge what is in front of the pin;
/// setting has priority.
#[test]
fn pins() {
    let mut chip = chip();
    let contact = pin(b"PA 6");
    chip.drive(contact, None);
    assert!(!chip.level(contact), "floating is noise");
    chip.write(PORT_A, 0x4844_4444);
    chip.write(PORT_A + 0x10, 1 << 6);
    let after = |chip: &mut Chip, ns: u64| {
        pass(chip, ns);
        chip.read(PORT_A + 0x08) >> 6 & 1
    };
    assert_eq!((after(&mut chip, 550_000), after(&mut chip, 50_000)), (0, 1));
    chip.drive(contact, Some(false));
    assert_eq!(after(&mut chip, 0), 0);
    chip.drive(contact, None);
    chip.write(PORT_A + 0x10, 1 << 3);
    assert_eq!((after(&mut chip, 550_000), after(&mut chip, 50_000)), (0, 1));
    chip.start(Reset::Power);
    chip.write(RCC + 0x18, 0x7EFD);
    chip.write(PORT_A, 0x4844_4444);
    chip.write(PORT_A + 0x10, 1 << 6);
    assert_eq!((after(&mut chip, 550_000), after(&mut chip, 50_000)), (0, 1));
    chip.drive(contact, Some(false));
    chip.write(PORT_A + 0x10, 1 << 22 | 1 << 6);
    assert_eq!(chip.read(PORT_A + 0x0C) >> 6 & 1, 1);
    assert!(!chip.drives_high(contact), "it is an input");
}

fn pwm(chip: &mut Chip, control: u32) {
    chip.write(PORT_A, 0x4844_4444);
    chip.write(PORT_A + 0x10, 1 << 6);
    chip.write(PORT_C, 0xAA44_4444);
    chip.write(TIM8 + 0x2C, 1_000);
    chip.write(TIM8 + 0x18, 0x6868);
    chip.write(TIM8 + 0x20, 0x0011);
    chip.write(TIM8 + 0x34, 250);
    chip.write(TIM8, 1);
    chip.write(TIM8 + 0x44, control);
}

/// RM §14.3.9, §14.3.12: without the main output there is none; the break takes it away by itself, and
/// it does not come back while the break lasts.
#[test]
fn the_break_needs_no_program() {
    let mut chip = chip();
    chip.drive(pin(b"PA 6"), Some(false));
    pwm(&mut chip, 1 << 12 | 1 << 13);
    assert_eq!(chip.pwm(0), 0.0);
    chip.write(TIM8 + 0x44, 1 << 15 | 1 << 12 | 1 << 13);
    assert!((chip.pwm(0) - 0.25).abs() < 1e-9 && chip.pwm(1) == 0.0);
    chip.drive(pin(b"PA 6"), Some(true));
    pass(&mut chip, 1_000);
    assert_eq!((chip.pwm(0), chip.read(TIM8 + 0x10) >> 7 & 1), (0.0, 1));
    chip.write(TIM8 + 0x44, 1 << 15 | 1 << 12 | 1 << 13);
    assert_eq!(chip.pwm(0), 0.0);
    chip.drive(pin(b"PA 6"), Some(false));
    pass(&mut chip, 1_000);
    assert_eq!(chip.pwm(0), 0.0, "not by itself");
    chip.write(TIM8 + 0x44, 1 << 15 | 1 << 12 | 1 << 13);
    assert!(chip.pwm(0) > 0.0);
}

/// RM §14.4.18: a locked break cannot be switched off.
#[test]
fn a_locked_break_stays() {
    let mut chip = chip();
    chip.drive(pin(b"PA 6"), Some(false));
    pwm(&mut chip, 1 << 13 | 1 << 12 | 1 << 8);
    chip.write(TIM8 + 0x44, 1 << 15);
    assert_eq!(chip.read(TIM8 + 0x44), 1 << 15 | 1 << 13 | 1 << 12 | 1 << 8);
}

/// RM §15.3.12: counts both ways, wraps, and needs its mode and both inputs.
#[test]
fn encoders_count() {
    let mut chip = chip();
    chip.turn(Counter::Tim5, 10, false);
    assert_eq!(chip.read(TIM5 + 0x24), 0);
    chip.write(TIM5 + 0x18, 0xF1F1);
    chip.write(TIM5 + 0x08, 3);
    chip.write(TIM5 + 0x2C, 0xFFFF);
    chip.write(TIM5, 1);
    chip.turn(Counter::Tim5, 7, false);
    assert_eq!(chip.read(TIM5 + 0x24), 0xFFFD);
    chip.turn(Counter::Tim5, 17, false);
    assert_eq!(chip.read(TIM5 + 0x24), 7);
    // RM §9.3.7: TIM1's inputs are elsewhere until they are remapped.
    chip.write(0x4001_2C18, 0xF1F1);
    chip.write(0x4001_2C08, 3);
    chip.write(0x4001_2C2C, 0xFFFF);
    chip.write(0x4001_2C00, 1);
    chip.turn(Counter::Tim1, 5, false);
    assert_eq!(chip.read(0x4001_2C24), 0);
    chip.write(AFIO_MAPR, 0b11 << 6);
    chip.turn(Counter::Tim1, 10, false);
    assert_eq!(chip.read(0x4001_2C24), 5);
}

/// RM §27.3.13, §13.3.3: bytes go round the ring by themselves; TC comes with the last stop bit.
#[test]
fn bytes_come_and_go_by_dma() {
    let mut chip = chip();
    chip.line_baud = 1_000_000;
    chip.write(USART + 0x08, 8);
    chip.write(USART + 0x14, 1 << 7 | 1 << 6);
    chip.write(USART + 0x0C, 1 << 13 | 0b11 << 2);
    chip.write(DMA + 0x64, RAM_START);
    chip.write(DMA + 0x5C, 4);
    chip.write(DMA + 0x58, 1 << 7 | 1 << 5 | 1);
    for n in 1..=6 {
        chip.incoming.push_back(Byte { at_ns: n * 10_000, value: n as u8 });
    }
    pass(&mut chip, 100_000);
    let ring: Vec<_> = (0..4).map(|at| chip.read8(RAM_START + at)).collect();
    assert_eq!((ring, chip.read(DMA + 0x5C)), (vec![5, 6, 3, 4], 2));
    chip.write(PORT_A + 4, 0x4442_44A4);
    chip.write(PORT_A + 0x10, 1 << 12);
    chip.write(DMA + 0x50, RAM_START);
    chip.write(DMA + 0x48, 3);
    chip.write(USART, !(1 << 6));
    chip.write(DMA + 0x44, 1 << 7 | 1 << 4 | 1);
    pass(&mut chip, 29_000);
    assert_eq!((chip.outgoing.len(), chip.read(USART) >> 6 & 1), (2, 0));
    pass(&mut chip, 2_000);
    assert_eq!((chip.outgoing.len(), chip.read(USART) >> 6 & 1), (3, 1));
}

/// RM §27.3.5: a byte at another baud is none.
#[test]
fn baud_must_fit() {
    let mut chip = chip();
    chip.write(USART + 0x08, 8_000_000 / 112_000);
    chip.write(USART + 0x14, 1 << 6);
    chip.write(USART + 0x0C, 1 << 13 | 1 << 2);
    chip.write(DMA + 0x64, RAM_START);
    chip.write(DMA + 0x5C, 4);
    chip.line_baud = 120_000;
    chip.write(DMA + 0x58, 1 << 7 | 1 << 5 | 1);
    chip.incoming.push_back(Byte { at_ns: 10, value: 7 });
    pass(&mut chip, 1_000);
    assert_eq!(chip.read(DMA + 0x5C), 4);
    chip.line_baud = 112_500;
    chip.incoming.push_back(Byte { at_ns: 2_000, value: 7 });
    pass(&mut chip, 5_000);
    assert_eq!((chip.read(DMA + 0x5C), chip.read8(RAM_START)), (3, 7));
}

/// RM §13.4.4: not while the channel is enabled.
#[test]
fn a_running_channel_is_left_alone() {
    let mut chip = chip();
    chip.write(DMA + 0x08, 1);
    chip.write(DMA + 0x0C, 5);
    assert_eq!((chip.read(DMA + 0x0C), chip.violations.len()), (0, 1));
}

/// PM0075 §2.3: keys in turn, half words to what is erased alone, whole pages.
#[test]
fn flash_is_written_as_it_must() {
    let mut chip = chip();
    let at = 0x0803_E000;
    assert_eq!(chip.write16(at, 1), 0);
    assert_eq!((chip.read8(at), chip.violations.len()), (0xFF, 1));
    chip.write(FLASH + 4, 0x4567_0123);
    chip.write(FLASH + 4, 0xCDEF_89AB);
    chip.write(FLASH + 0x10, 1);
    assert!(chip.write16(at, 0x1234) > 50_000);
    assert_eq!((chip.read8(at), chip.read(FLASH + 0x0C)), (0x34, 1 << 5));
    chip.write16(at, 0x5678);
    assert_eq!((chip.read8(at), chip.read(FLASH + 0x0C) >> 2 & 1), (0x34, 1));
    chip.write(FLASH + 0x10, 0b10);
    chip.write(FLASH + 0x14, at + 100);
    let busy_ns = chip.write(FLASH + 0x10, 1 << 6 | 0b10);
    assert_eq!((busy_ns, chip.read8(at)), (40 * MS, 0xFF));
    // A wrong key: locked until the next reset.
    chip.write(FLASH + 0x10, 1 << 7);
    for key in [1, 0x4567_0123, 0xCDEF_89AB] {
        chip.write(FLASH + 4, key);
    }
    assert_eq!(chip.read(FLASH + 0x10) >> 7, 1);
}

/// RM §5.1.2, §6: the battery's registers are closed after a reset, and survive it.
#[test]
fn what_the_battery_keeps() {
    let mut chip = chip();
    let register = 0x4000_6C04;
    chip.write(register, 7);
    assert_eq!(chip.read(register), 0);
    chip.write(0x4000_7000, 1 << 8);
    chip.write(register, 7);
    chip.start(Reset::Power);
    chip.write(RCC + 0x1C, 1 << 27);
    assert_eq!(chip.read(register), 7);
}

/// RM §5.2.3
#[test]
fn the_supply_is_watched_when_asked() {
    let mut chip = chip();
    chip.supply_low = true;
    assert_eq!(chip.read(0x4000_7004), 0);
    chip.write(0x4000_7000, 1 << 4);
    assert_eq!(chip.read(0x4000_7004), 1 << 2);
}

/// RM §11.3, §11.7, §11.4: a scan by the PWM's trigger, in order; uncalibrated it is off.
#[test]
fn the_adc_scans() {
    let mut chip = chip();
    let adc = 0x4001_2400;
    chip.analog[10] = 1_000;
    chip.analog[11] = 2_000;
    chip.write(PORT_C, 0);
    chip.write(adc + 0x34, 11 | 10 << 5);
    chip.write(adc + 0x2C, 1 << 20);
    chip.write(adc + 0x04, 1 << 8);
    chip.write(DMA + 0x14, RAM_START);
    chip.write(DMA + 0x0C, 2);
    chip.write(DMA + 0x08, 0x5A1);
    chip.write(adc + 0x08, 1 << 20 | 0b110 << 17 | 1 << 8 | 1);
    chip.convert();
    assert_eq!(chip.read(DMA) >> 1 & 1, 0, "no trigger");
    chip.write(AFIO_MAPR, 1 << 18);
    chip.write(TIM8 + 0x04, 0b010 << 4);
    chip.write(TIM8, 1);
    chip.convert();
    assert_eq!(chip.read(DMA) >> 1 & 1, 1);
    let sample = |chip: &Chip, n: u32| {
        u16::from_le_bytes([chip.read8(RAM_START + 2 * n), chip.read8(RAM_START + 2 * n + 1)])
    };
    assert_eq!((sample(&chip, 0), sample(&chip, 1)), (2_060, 1_060));
    chip.write(adc + 0x08, 1 << 20 | 0b110 << 17 | 1 << 8 | 1 << 2 | 1);
    chip.convert();
    assert_eq!((sample(&chip, 0), sample(&chip, 1)), (2_000, 1_000));
    assert_eq!(chip.read(RAM_START), 1_000 << 16 | 2_000, "a word has two");
}

/// RM §7.2.7: a watched crystal that fails breaks the PWM, and the chip goes on with its own oscillator.
#[test]
fn a_failing_crystal_breaks_the_pwm() {
    for watched in [true, false] {
        let mut chip = chip();
        chip.drive(pin(b"PA 6"), Some(false));
        pwm(&mut chip, 1 << 13 | 1 << 12);
        chip.write(TIM8 + 0x44, 1 << 15 | 1 << 13 | 1 << 12);
        chip.write(RCC, 1 << 16 | 1);
        pass(&mut chip, 3 * MS);
        let control = chip.read(RCC);
        chip.write(RCC, control | u32::from(watched) << 19);
        chip.crystal = false;
        pass(&mut chip, 1_000);
        assert_eq!(chip.pwm(0) == 0.0, watched);
        assert_eq!(chip.reset, watched.then_some(Reset::Clock));
    }
}

/// RM §15.3.3, §9.3.7, §9.3.3: pulses clock TIM2 once its pin is its own, free of JTAG, and chosen.
#[test]
fn pulses_are_counted() {
    let tim2 = 0x4000_0000;
    for (remaps, mode, counted) in [
        (0b010 << 24 | 0b01 << 8, 0x67, 5),
        (0b01 << 8, 0x67, 0),
        (0b010 << 24, 0x67, 0),
        (0b010 << 24 | 0b01 << 8, 0x57, 0),
    ] {
        let mut chip = chip();
        chip.write(AFIO_MAPR, remaps);
        chip.write(tim2 + 0x18, 1 << 8);
        chip.write(tim2 + 0x08, mode);
        chip.write(tim2 + 0x2C, 0xFFFF);
        chip.write(tim2, 1);
        chip.pulse(5);
        assert_eq!(chip.read(tim2 + 0x24), counted, "{remaps:#x} {mode:#x}");
    }
}

/// RM §9.3.3: JTAG keeps its pins until it is given up.
#[test]
fn jtag_keeps_its_pins() {
    let mut chip = chip();
    chip.drive(pin(b"PA15"), Some(true));
    assert_eq!(chip.read(PORT_A + 0x08) >> 15, 0);
    chip.write(AFIO_MAPR, 0b010 << 24);
    assert_eq!(chip.read(PORT_A + 0x08) >> 15, 1);
}

/// RM §17.4, §7.2: TIM6 counts at twice the clock of a divided APB1.
#[test]
fn tim6_counts_the_time() {
    let mut chip = chip();
    let tim6 = 0x4000_1000;
    chip.write(tim6 + 0x28, 799);
    chip.write(tim6 + 0x2C, 0xFFFF);
    chip.write(tim6 + 0x14, 1);
    chip.write(tim6, 1);
    pass(&mut chip, 25 * MS);
    assert_eq!(chip.read(tim6 + 0x24), 250);
    chip.write(RCC + 4, 0b100 << 8);
    assert_eq!(chip.hz(), 8_000_000);
    pass(&mut chip, 25 * MS);
    assert_eq!(chip.read(tim6 + 0x24), 500);
    pass(&mut chip, 6_550 * MS);
    assert_eq!(chip.read(tim6 + 0x24), 464, "it wraps");
}
