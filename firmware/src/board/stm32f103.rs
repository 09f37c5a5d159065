//! STM32F103xC: the line is RS-485 on USART1; drives have a power stage (PWM and direction) and an
//! incremental encoder each, valves two relays, sensors are contacts and analogue inputs.
//!
//! | pins | what |
//! |---|---|
//! | PA9, PA10, PA12 | USART1 to the RS-485 driver, and its transmitter |
//! | PC6 … PC9 | TIM8: PWM of vertical, horizontal, nozzle, deployer |
//! | PB12 … PB15 | direction of each |
//! | PA0, PA1; PA6, PA7; PB6, PB7 | TIM2, TIM3, TIM4: encoders of vertical, horizontal, nozzle |
//! | PD0 … PD7 | end switches, lower and upper, of the four drives; closed to ground |
//! | PE0 … PE3 | valve 1 opens, closes; valve 2 opens, closes |
//! | PE4 … PE8 | heaters |
//! | PD8 … PD13 | valve 1 is open, closed, blocked; the same of valve 2; closed to ground |
//! | PC0 … PC3 | currents of the drives, 0.1 A a step of the scale below |
//! | PC4, PC5 | current loop of the pressure sensor (150 Ω), supply (1:11) |
//!
//! A barrel that stands where the encoders began to count is at 0: the zero point is taught after each
//! power-up by driving to the lower ends, or an absolute encoder takes the place of `Encoder`.

use super::{Board, Start};
use crate::register::Register;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SCB};
use cortex_m_rt::exception;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use lafet_device::guard::Passed;
use lafet_device::Composition;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{Inputs, Outputs, ValveOutput};
use lafet_device::store::Store;

/// How many interrupts the chip has.
pub const INTERRUPTS: usize = 60;
const CLOCK_HZ: u32 = 72_000_000;
const BAUD: u32 = 115_200;
const ADDRESS: u8 = 1;
/// PWM steps; 20 kHz.
const PWM_TOP: u32 = CLOCK_HZ / 20_000 - 1;
/// Speed at which the PWM is full: vertical, horizontal 12 °/s, nozzle 10 mm/s, deployer 12 °/s, in
/// tenths.
const FULL_SPEED: [u32; 4] = [120, 120, 100, 120];
/// Steps of the encoder in 100 arc-minutes, or 100 mm.
const ENCODER_STEPS: [i32; 3] = [400, 400, 4_000];

const RCC: usize = 0x4002_1000;
const FLASH_CONTROL: usize = 0x4002_2000;
const USART1: usize = 0x4001_3800;
const DMA1_CHANNEL5: usize = 0x4002_0058;
const IWDG: usize = 0x4000_3000;
const ADC1: usize = 0x4001_2400;
const TIM8: usize = 0x4001_3400;
const ENCODERS: [usize; 3] = [0x4000_0000, 0x4000_0400, 0x4000_0800];
const PORT_A: Port = Port(0x4001_0800);
const PORT_B: Port = Port(0x4001_0C00);
const PORT_C: Port = Port(0x4001_1000);
const PORT_D: Port = Port(0x4001_1400);
const PORT_E: Port = Port(0x4001_1800);
/// Drives the transmitter of RS-485.
const TRANSMIT: u32 = 1 << 12;

const ANALOGUE: u32 = 0x0;
const OUTPUT: u32 = 0x2;
const FLOATING: u32 = 0x4;
const PULLED: u32 = 0x8;
const ALTERNATE: u32 = 0xB;

static MILLIS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    // The only writer.
    MILLIS.store(MILLIS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}

/// The ring that the DMA fills: at 115200 baud what comes in 44 ms, twice the erase of a page.
const RING: usize = 512;
static mut RECEIVED: [u8; RING] = [0; RING];

/// A port of sixteen pins.
#[derive(Clone, Copy)]
struct Port(usize);

impl Port {
    /// Sets the mode of pins, four bits each.
    fn mode(self, pins: core::ops::RangeInclusive<usize>, mode: u32) {
        for pin in pins {
            let register = Register::at(self.0 + pin / 8 * 4);
            let shift = pin % 8 * 4;
            register.write(register.read() & !(0xF << shift) | mode << shift);
        }
    }

    fn is_low(self, pin: u32) -> bool {
        Register::at(self.0 + 0x08).read() >> pin & 1 == 0
    }

    /// Sets and clears pins at once.
    fn write(self, mask: u32, bits: u32) {
        Register::at(self.0 + 0x10).write((mask & !bits) << 16 | mask & bits);
    }
}

/// A counter that follows an encoder; the board extends its sixteen bits.
#[derive(Clone, Copy, Default)]
struct Encoder {
    last: u16,
    steps: i32,
    speed: i32,
}

impl Encoder {
    /// Steps so far, after so many ms.
    fn sample(&mut self, base: usize, dt_ms: u32) -> i32 {
        let now = Register::at(base + 0x24).read() as u16;
        let moved = i32::from(now.wrapping_sub(self.last).cast_signed());
        self.last = now;
        self.steps = self.steps.wrapping_add(moved);
        let speed = moved.wrapping_mul(1000).checked_div(dt_ms.cast_signed()).unwrap_or(0);
        // Over about 16 samples: single steps would make it jump.
        self.speed = self.speed.wrapping_add(speed.wrapping_sub(self.speed) / 16);
        self.steps
    }
}

/// The board.
pub struct Stm32f103 {
    store: Store<InternalFlash>,
    encoders: [Encoder; 3],
    taken: usize,
    stepped_ms: u32,
    reset_by_watchdog: bool,
}

impl Stm32f103 {
    pub fn new() -> Self {
        let reset_by_watchdog = Register::at(RCC + 0x24).read() & 1 << 29 != 0;
        Register::at(RCC + 0x24).write(1 << 24);
        clock();
        pins();
        line();
        drives();
        analogue();
        tick();
        watchdog();
        Self {
            store: Store::mount(InternalFlash, 0, InternalFlash::PAGES),
            encoders: [Encoder::default(); 3],
            taken: 0,
            stepped_ms: 0,
            reset_by_watchdog,
        }
    }
}

/// HSE 8 MHz × 9; two wait states; everything that is used gets its clock.
fn clock() {
    Register::at(FLASH_CONTROL).write(0x12);
    Register::at(RCC).write(1 << 16 | 1);
    while Register::at(RCC).read() & 1 << 17 == 0 {}
    Register::at(RCC + 0x04).write(7 << 18 | 1 << 16 | 0b10 << 14 | 0b100 << 8);
    Register::at(RCC).write(1 << 24 | 1 << 16 | 1);
    while Register::at(RCC).read() & 1 << 25 == 0 {}
    Register::at(RCC + 0x04).write(7 << 18 | 1 << 16 | 0b10 << 14 | 0b100 << 8 | 0b10);
    Register::at(RCC + 0x14).write(0x15);
    Register::at(RCC + 0x18).write(1 << 14 | 1 << 13 | 1 << 9 | 0x7D);
    Register::at(RCC + 0x1C).write(0b111);
}

fn pins() {
    PORT_A.mode(0..=1, FLOATING);
    PORT_A.mode(6..=7, FLOATING);
    PORT_A.mode(9..=9, ALTERNATE);
    PORT_A.mode(10..=10, FLOATING);
    PORT_A.mode(12..=12, OUTPUT);
    PORT_B.mode(6..=7, FLOATING);
    PORT_B.mode(12..=15, OUTPUT);
    PORT_C.mode(0..=5, ANALOGUE);
    PORT_C.mode(6..=9, ALTERNATE);
    PORT_D.mode(0..=13, PULLED);
    PORT_D.write(0x3FFF, 0x3FFF);
    PORT_E.mode(0..=8, OUTPUT);
}

/// 8N1; received bytes go to the ring by DMA, so that none is lost however long a step takes.
fn line() {
    Register::at(USART1 + 0x08).write(CLOCK_HZ / BAUD);
    Register::at(USART1 + 0x14).write(1 << 6);
    Register::at(USART1 + 0x0C).write(1 << 13 | 0b11 << 2);
    Register::at(DMA1_CHANNEL5 + 0x08).write((USART1 + 0x04) as u32);
    Register::at(DMA1_CHANNEL5 + 0x0C).write(&raw mut RECEIVED as u32);
    Register::at(DMA1_CHANNEL5 + 0x04).write(RING as u32);
    Register::at(DMA1_CHANNEL5).write(1 << 7 | 1 << 5 | 1);
}

fn drives() {
    Register::at(TIM8 + 0x2C).write(PWM_TOP);
    Register::at(TIM8 + 0x18).write(0x6868);
    Register::at(TIM8 + 0x1C).write(0x6868);
    Register::at(TIM8 + 0x20).write(0x1111);
    Register::at(TIM8 + 0x44).write(1 << 15);
    Register::at(TIM8).write(1);
    for base in ENCODERS {
        Register::at(base + 0x18).write(0x0101);
        Register::at(base + 0x08).write(3);
        Register::at(base + 0x2C).write(0xFFFF);
        Register::at(base).write(1);
    }
}

/// Sampled for 28.5 cycles of 12 MHz: 3.4 µs an input, from sources of 25 kΩ at most.
fn analogue() {
    Register::at(ADC1 + 0x08).write(1);
    Register::at(ADC1 + 0x0C).write(0o333_333);
    Register::at(ADC1 + 0x08).write(1 << 20 | 0b111 << 17 | 1);
}

/// 12 bits of an input: 10 to 15 are PC0 to PC5.
fn sample(channel: u32) -> u32 {
    Register::at(ADC1 + 0x34).write(channel);
    Register::at(ADC1 + 0x08).write(1 << 22 | 1 << 20 | 0b111 << 17 | 1);
    while Register::at(ADC1).read() & 0b10 == 0 {}
    Register::at(ADC1 + 0x4C).read() & 0xFFF
}

fn tick() {
    let Some(core) = Peripherals::take() else { return };
    let mut systick = core.SYST;
    systick.set_clock_source(SystClkSource::Core);
    systick.set_reload(CLOCK_HZ / 1000 - 1);
    systick.clear_current();
    systick.enable_interrupt();
    systick.enable_counter();
}

/// About a second.
fn watchdog() {
    for word in [0x5555, 0xCCCC] {
        Register::at(IWDG).write(word);
    }
    Register::at(IWDG + 0x04).write(4);
    Register::at(IWDG + 0x08).write(625);
}

impl Board for Stm32f103 {
    fn start(&mut self, _after_fault: bool) -> Start {
        Start { now_ms: self.now_ms(), composition: &Composition::FULL, address: ADDRESS }
    }

    fn reset_by_watchdog(&mut self) -> bool {
        self.reset_by_watchdog
    }

    fn now_ms(&self) -> u32 {
        MILLIS.load(Ordering::Relaxed)
    }

    fn due(&mut self) -> Option<u32> {
        let now_ms = self.now_ms();
        (now_ms != self.stepped_ms).then_some(now_ms)
    }

    fn receive<'b>(&mut self, buffer: &'b mut [u8]) -> &'b [u8] {
        let filled = RING - (Register::at(DMA1_CHANNEL5 + 0x04).read() as usize).min(RING);
        let mut len = 0;
        for place in &mut *buffer {
            if self.taken == filled {
                break;
            }
            // SAFETY: inside the ring, and the DMA has gone on.
            *place = unsafe { (&raw const RECEIVED).cast::<u8>().add(self.taken).read_volatile() };
            self.taken = (self.taken + 1) % RING;
            len += 1;
        }
        buffer.get(..len).unwrap_or_default()
    }

    fn put(&mut self, byte: u8) {
        PORT_A.write(TRANSMIT, TRANSMIT);
        while Register::at(USART1).read() & 1 << 7 == 0 {}
        Register::at(USART1 + 0x04).write(byte.into());
    }

    fn release(&mut self) {
        // The transmitter lets go of the line with the last stop bit.
        while Register::at(USART1).read() & 1 << 6 == 0 {}
        PORT_A.write(TRANSMIT, 0);
    }

    fn feed_watchdog(&mut self) {
        Register::at(IWDG).write(0xAAAA);
    }
}

impl Hal for Stm32f103 {
    fn read(&mut self, inputs: &mut Inputs) {
        let now_ms = self.now_ms();
        let dt_ms = now_ms.wrapping_sub(self.stepped_ms);
        self.stepped_ms = now_ms;
        for (index, drive) in (0..).zip(&mut inputs.drives) {
            drive.min_switch = PORT_D.is_low(2 * index);
            drive.max_switch = PORT_D.is_low(2 * index + 1);
            // 10 A are full scale.
            drive.current_da = (sample(10 + index) * 100 / 4096) as u16;
        }
        let scaled = self.encoders.iter_mut().zip(ENCODERS).zip(ENCODER_STEPS);
        for (drive, ((encoder, base), steps)) in inputs.drives.iter_mut().zip(scaled) {
            let of = |counted: i32| counted.saturating_mul(100).checked_div(steps).unwrap_or(0);
            drive.position = of(encoder.sample(base, dt_ms));
            // 60 arc-minutes are a degree: 6' a second are a tenth.
            let tenths = of(encoder.speed) / 6;
            drive.speed_tenths = tenths.clamp(i16::MIN.into(), i16::MAX.into()) as i16;
        }
        for (index, valve) in (0..).zip(&mut inputs.valves) {
            valve.open_switch = PORT_D.is_low(8 + 3 * index);
            valve.close_switch = PORT_D.is_low(9 + 3 * index);
            valve.blocked = PORT_D.is_low(10 + 3 * index);
        }
        // 3.3 V over 150 Ω are 22 mA.
        inputs.pressure_ua = (sample(14) * 22_000 / 4096) as u16;
        inputs.main_voltage_dv = (sample(15) * 363 / 4096) as u16;
    }

    fn write(&mut self, outputs: &Passed) {
        let mut directions = 0;
        for (index, (drive, full)) in outputs.drives.iter().zip(FULL_SPEED).enumerate() {
            let speed = u32::from(drive.speed_tenths.unsigned_abs()).min(full);
            if drive.speed_tenths > 0 {
                directions |= 1 << (12 + index);
            }
            let duty = (PWM_TOP * speed).checked_div(full).unwrap_or(0);
            Register::at(TIM8 + 0x34 + 4 * index).write(duty);
        }
        PORT_B.write(0xF000, directions);
        let mut relays = 0;
        for (index, valve) in outputs.valves.iter().enumerate() {
            relays |= match valve {
                ValveOutput::Off => 0,
                ValveOutput::Opening => 1 << (2 * index),
                ValveOutput::Closing => 2 << (2 * index),
            };
        }
        for (index, heater) in outputs.heaters.iter().enumerate() {
            relays |= u32::from(*heater) << (4 + index);
        }
        PORT_E.write(0x1FF, relays);
    }

    fn reset(&mut self) {
        SCB::sys_reset()
    }
}

impl Storage for Stm32f103 {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        self.store.load(key, buffer)
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        self.store.store(key, value)
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.store.erase()
    }
}

/// The last pages of the chip's own flash.
struct InternalFlash;

/// The flash has reported an error.
#[derive(Clone, Copy, Debug)]
struct Refused;

impl NorFlashError for Refused {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl InternalFlash {
    const PAGES: u16 = 4;
    const START: usize = 0x0803_E000;

    fn unlock() {
        for key in [0x4567_0123, 0xCDEF_89AB] {
            Register::at(FLASH_CONTROL + 0x04).write(key);
        }
    }

    /// Waits for the operation; the registers are left as they were.
    fn finish() -> Result<(), Refused> {
        while Register::at(FLASH_CONTROL + 0x0C).read() & 1 != 0 {}
        let status = Register::at(FLASH_CONTROL + 0x0C).read();
        Register::at(FLASH_CONTROL + 0x0C).write(0x34);
        if status & 0x14 == 0 { Ok(()) } else { Err(Refused) }
    }

    fn lock() {
        Register::at(FLASH_CONTROL + 0x10).write(1 << 7);
    }
}

impl ErrorType for InternalFlash {
    type Error = Refused;
}

impl ReadNorFlash for InternalFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        for (index, byte) in bytes.iter_mut().enumerate() {
            let address = Self::START + offset as usize + index;
            // SAFETY: inside the pages of the parameters.
            *byte = unsafe { (address as *const u8).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        usize::from(Self::PAGES) * Self::ERASE_SIZE
    }
}

impl NorFlash for InternalFlash {
    const WRITE_SIZE: usize = 2;
    const ERASE_SIZE: usize = 2048;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        Self::unlock();
        let mut result = Ok(());
        for page in (from..to).step_by(Self::ERASE_SIZE) {
            Register::at(IWDG).write(0xAAAA);
            Register::at(FLASH_CONTROL + 0x10).write(1 << 1);
            Register::at(FLASH_CONTROL + 0x14).write(Self::START as u32 + page);
            Register::at(FLASH_CONTROL + 0x10).write(1 << 6 | 1 << 1);
            result = result.and(Self::finish());
        }
        Self::lock();
        result
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        Self::unlock();
        Register::at(FLASH_CONTROL + 0x10).write(1);
        let mut result = Ok(());
        for (index, pair) in bytes.as_chunks::<2>().0.iter().enumerate() {
            let address = Self::START + offset as usize + 2 * index;
            // SAFETY: inside the pages of the parameters, aligned, and unlocked.
            unsafe { (address as *mut u16).write_volatile(u16::from_le_bytes(*pair)) };
            result = result.and(Self::finish());
        }
        Self::lock();
        result
    }
}
