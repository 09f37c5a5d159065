//! Boards that are wrong in one thing each, as a mistake in the program, in the record or at the
//! soldering iron makes them. The checks must notice every one.

use crate::chip::Counter;
use crate::rig::{Wires, Wrong};
use lafet_device::Device;
use lafet_device::hal::{Key, Storage};
use lafet_device::port::Port;
use lafet_stm32f103::Stm32f103;
use lafet_stm32f103::record::CRC as RECORD_CRC;
use lafet_turn::{Board, once};

const RCC_CR: u32 = 0x4002_1000;
const RCC_CFGR: u32 = 0x4002_1004;
const RCC_CSR: u32 = 0x4002_1024;
const RCC_APB1: u32 = 0x4002_101C;
const RCC_APB2: u32 = 0x4002_1018;
const FLASH_ACR: u32 = 0x4002_2000;
const FLASH_KEY: u32 = 0x4002_2004;
const FLASH_CR: u32 = 0x4002_2010;
const MAPR: u32 = 0x4001_0004;
const IWDG_KEY: u32 = 0x4000_3000;
const IWDG_PR: u32 = 0x4000_3004;
const IWDG_SR: u32 = 0x4000_300C;
const PWR_CR: u32 = 0x4000_7000;
const ADC_CR1: u32 = 0x4001_2404;
const ADC_CR2: u32 = 0x4001_2408;
const ADC_SQR2: u32 = 0x4001_2430;
const ADC_SQR3: u32 = 0x4001_2434;
const DMA_ADC: u32 = 0x4002_0008;
const DMA_TX: u32 = 0x4002_0044;
const DMA_RX: u32 = 0x4002_0058;
const USART_BRR: u32 = 0x4001_3808;
const USART_CR1: u32 = 0x4001_380C;
const USART_CR3: u32 = 0x4001_3814;
const TIM2_SMCR: u32 = 0x4000_0008;
const TIM3: u32 = 0x4000_0400;
const TIM4: u32 = 0x4000_0800;
const TIM5: u32 = 0x4000_0C00;
const TIM1: u32 = 0x4001_2C00;
const TIM8: u32 = 0x4001_3400;
const TIM6: u32 = 0x4000_1000;
const TIM6_PSC: u32 = 0x4000_1028;
const TIM6_CNT: u32 = 0x4000_1024;
const PORT_A: u32 = 0x4001_0800;
const PORT_B: u32 = 0x4001_0C00;
const PORT_C: u32 = 0x4001_1000;
const PORT_D: u32 = 0x4001_1400;
const PORT_E: u32 = 0x4001_1800;
const IDR: u32 = 0x08;
const BSRR: u32 = 0x10;
const NVIC: u32 = 0xE000_E104;

type Alter = fn(bool, u32, u32) -> Option<u32>;

const fn alter(name: &'static str, alter: Alter) -> (&'static str, Wrong) {
    (name, Wrong { alter, ..Wrong::NOTHING })
}

const fn route(name: &'static str, route: fn(u32) -> u32) -> (&'static str, Wrong) {
    (name, Wrong { route, ..Wrong::NOTHING })
}

const fn record(
    name: &'static str,
    record: fn(&mut lafet_stm32f103::record::Record),
) -> (&'static str, Wrong) {
    (name, Wrong { record, ..Wrong::NOTHING })
}

const fn wires(name: &'static str, wires: fn(&mut crate::plant::Plant)) -> (&'static str, Wrong) {
    (name, Wrong { wires, ..Wrong::NOTHING })
}

/// A step behind each 32 bytes, whatever else has come.
fn step_by_step(board: &mut Stm32f103<Wires>, device: &mut Device, port: &mut Port<()>) {
    let mut chunk = [0; 32];
    let bytes = board.receive(&mut chunk);
    port.serve(board.now_ms(), device, bytes, &mut |byte| board.put(byte));
    board.release();
    if let Some(now_ms) = board.due() {
        device.step(now_ms, board);
        board.stepped();
    }
}

/// Something is written each ms, in motion as well.
fn writes(board: &mut Stm32f103<Wires>, device: &mut Device, port: &mut Port<()>) {
    if once(board, device, port) && !device.outputs().is_still() {
        // It is refused, or it is not: that is the question.
        let _ = board.store(Key(0xF0), &[device.outputs().drives[1].speed_tenths as u8]);
    }
}

/// The value with these bits exchanged, in both halves of it.
fn exchanged(value: u32, one: u32, other: u32) -> u32 {
    [0, 16].into_iter().fold(value, |value, half| {
        let (one, other) = (one + half, other + half);
        let differ = (value >> one ^ value >> other) & 1;
        value ^ (differ << one | differ << other)
    })
}

/// What is written to a register, changed.
fn written(
    is_write: bool,
    address: u32,
    value: u32,
    register: u32,
    change: impl Fn(u32) -> u32,
) -> Option<u32> {
    Some(if is_write && address == register { change(value) } else { value })
}

/// What is read from a register, changed.
fn seen(
    is_write: bool,
    address: u32,
    value: u32,
    register: u32,
    change: impl Fn(u32) -> u32,
) -> Option<u32> {
    Some(if !is_write && address == register { change(value) } else { value })
}

fn lost(is_write: bool, address: u32, value: u32, is_lost: bool, register: u32) -> Option<u32> {
    (!(is_write && address == register && is_lost)).then_some(value)
}

fn swapped(address: u32, one: u32, other: u32) -> u32 {
    match address {
        _ if address == one => other,
        _ if address == other => one,
        _ => address,
    }
}

fn of_timers(address: u32, offset: u32) -> bool {
    [TIM1, TIM3, TIM4, TIM5].iter().any(|timer| timer + offset == address)
}

/// The boards, each with what is wrong.
pub const BOARDS: [(&str, Wrong); 91] = [
    // The clock.
    alter("flash without wait states", |w, a, v| written(w, a, v, FLASH_ACR, |v| v & !7)),
    alter("APB1 undivided", |w, a, v| written(w, a, v, RCC_CFGR, |v| v & !(7 << 8))),
    alter("ADC at 36 MHz", |w, a, v| written(w, a, v, RCC_CFGR, |v| v & !(3 << 14))),
    alter("PLL by 8", |w, a, v| written(w, a, v, RCC_CFGR, |v| v & !(0xF << 18) | 6 << 18)),
    alter("crystal not watched", |w, a, v| written(w, a, v, RCC_CR, |v| v & !(1 << 19))),
    alter("no clock for TIM4", |w, a, v| written(w, a, v, RCC_APB1, |v| v & !(1 << 2))),
    alter("no clock for the ADC", |w, a, v| written(w, a, v, RCC_APB2, |v| v & !(1 << 9))),
    alter("time ten times too fast", |w, a, v| written(w, a, v, TIM6_PSC, |v| v / 10)),
    alter("time does not run", |w, a, v| lost(w, a, v, v & 1 != 0, TIM6)),
    // The watchdog.
    alter("watchdog started before it is set", |w, a, v| lost(w, a, v, v == 0x5555, IWDG_KEY)),
    alter("values of the watchdog not waited for", |w, a, v| seen(w, a, v, IWDG_SR, |_| 0)),
    alter("oscillator of the watchdog off", |w, a, v| written(w, a, v, RCC_CSR, |v| v & !1)),
    alter("watchdog never started", |w, a, v| lost(w, a, v, v == 0xCCCC, IWDG_KEY)),
    alter("watchdog at four seconds", |w, a, v| written(w, a, v, IWDG_PR, |_| 6)),
    alter("watchdog not fed", |w, a, v| lost(w, a, v, v == 0xAAAA, IWDG_KEY)),
    // The line.
    alter("half the baud", |w, a, v| written(w, a, v, USART_BRR, |v| v * 2)),
    alter("receiver off", |w, a, v| written(w, a, v, USART_CR1, |v| v & !(1 << 2))),
    alter("sent without DMA", |w, a, v| written(w, a, v, USART_CR3, |v| v & !(1 << 7))),
    alter("receiving ring not circular", |w, a, v| written(w, a, v, DMA_RX, |v| v & !(1 << 5))),
    alter("receiving to one byte", |w, a, v| written(w, a, v, DMA_RX, |v| v & !(1 << 7))),
    alter("sending from one byte", |w, a, v| written(w, a, v, DMA_TX, |v| v & !(1 << 7))),
    alter("transmitter never on", |w, a, v| lost(w, a, v, v == 1 << 12, PORT_A + BSRR)),
    alter("transmitter never off", |w, a, v| lost(w, a, v, v == 1 << 28, PORT_A + BSRR)),
    alter("interrupt of the line not let through", |w, a, v| lost(w, a, v, true, NVIC)),
    // Pins.
    alter("JTAG keeps its pins", |w, a, v| written(w, a, v, MAPR, |v| v & !(7 << 24))),
    alter("TIM1 not remapped", |w, a, v| written(w, a, v, MAPR, |v| v & !(3 << 6))),
    alter("TIM2 not remapped", |w, a, v| written(w, a, v, MAPR, |v| v & !(3 << 8))),
    alter("TIM3 not remapped", |w, a, v| written(w, a, v, MAPR, |v| v & !(3 << 10))),
    alter("PWM pins not alternate", |w, a, v| written(w, a, v, PORT_C, |v| v & !(8 << 24))),
    alter("no pull-ups at the end switches", |w, a, v| {
        lost(w, a, v, v & 0xFFFF != 0, PORT_D + BSRR)
    }),
    wires("stop chain wired as the other contacts", |it| it.is_chain_fast = false),
    alter("jumper read at once", |w, a, v| seen(w, a, v, TIM6_CNT, |v| v.max(50))),
    alter("current input not analogue", |w, a, v| written(w, a, v, PORT_C, |v| v | 4)),
    // Drives.
    route("PWM of vertical and horizontal exchanged", |a| swapped(a, TIM8 + 0x34, TIM8 + 0x38)),
    route("PWM of nozzle and deployer exchanged", |a| swapped(a, TIM8 + 0x3C, TIM8 + 0x40)),
    alter("directions exchanged", |w, a, v| {
        written(w, a, v, PORT_B + BSRR, |v| exchanged(v, 12, 13))
    }),
    alter("direction of vertical inverted", |w, a, v| {
        written(w, a, v, PORT_B + BSRR, |v| match v & (1 << 12 | 1 << 28) {
            0 => v,
            _ => v ^ (1 << 12 | 1 << 28),
        })
    }),
    alter("PWM inverted", |w, a, v| written(w, a, v, TIM8 + 0x20, |v| v | 0x2222)),
    alter("PWM mode 2", |w, a, v| written(w, a, v, TIM8 + 0x18, |v| v | 0x1010)),
    alter("one channel not enabled", |w, a, v| written(w, a, v, TIM8 + 0x20, |v| v & !0x100)),
    alter("PWM at 5 kHz", |w, a, v| written(w, a, v, TIM8 + 0x2C, |v| v * 4)),
    alter("duty of 60 times less", |w, a, v| written(w, a, v, TIM8 + 0x38, |v| v / 60)),
    alter("no break", |w, a, v| written(w, a, v, TIM8 + 0x44, |v| v & !(1 << 12))),
    alter("break of the wrong polarity", |w, a, v| {
        written(w, a, v, TIM8 + 0x44, |v| v & !(1 << 13))
    }),
    alter("main output never on", |w, a, v| written(w, a, v, TIM8 + 0x44, |v| v & !(1 << 15))),
    alter("stages never enabled", |w, a, v| lost(w, a, v, v == 1 << 10, PORT_C + BSRR)),
    alter("voltage of motors not read back", |w, a, v| seen(w, a, v, PORT_E + IDR, |v| v | 0xF000)),
    alter("voltage of motors read inverted", |w, a, v| seen(w, a, v, PORT_E + IDR, |v| v ^ 0xF000)),
    // Encoders.
    route("encoders of vertical and horizontal exchanged", |a| {
        swapped(a, TIM5 + 0x24, TIM3 + 0x24)
    }),
    route("encoders of nozzle and deployer exchanged", |a| swapped(a, TIM4 + 0x24, TIM1 + 0x24)),
    alter("one track of the encoders", |w, a, v| Some(if w && of_timers(a, 0x08) { 1 } else { v })),
    alter("encoders have nothing to reload", |w, a, v| (!(w && of_timers(a, 0x2C))).then_some(v)),
    alter("encoders not filtered", |w, a, v| {
        Some(if w && of_timers(a, 0x18) { v & !0xF0F0 } else { v })
    }),
    record("nozzle 60 times too slow", |it| it.drives[2].counts_per_100 = 67),
    record("half the counts", |it| it.drives[1].counts_per_100 = 200),
    record("vertical counts down", |it| it.drives[0].counts_per_100 = -400),
    record("full speed four times too high", |it| it.drives[1].full_tenths = 1_000),
    record("motor reversed", |it| it.drives[1].is_reversed = true),
    record("ends of another drive", |it| it.drives[0].ends = (-100, 100)),
    wires("motors exchanged", |it| it.motors.swap(0, 1)),
    wires("encoders exchanged", |it| it.encoders.swap(0, 1)),
    wires("tracks of an encoder exchanged", |it| it.crossed[1] = true),
    wires("two encoders at one counter", |it| it.encoders[2] = Counter::Tim3),
    // Sensors.
    alter("ADC not started by the PWM", |w, a, v| written(w, a, v, MAPR, |v| v & !(1 << 18))),
    alter("ADC does not scan", |w, a, v| written(w, a, v, ADC_CR1, |v| v & !(1 << 8))),
    alter("ADC not calibrated", |w, a, v| written(w, a, v, ADC_CR2, |v| v & !(1 << 2))),
    alter("samples end with the first", |w, a, v| written(w, a, v, DMA_ADC, |v| v & !(1 << 5))),
    alter("currents exchanged", |w, a, v| {
        written(w, a, v, ADC_SQR3, |v| v & !0x3FF | (v & 0x1F) << 5 | v >> 5 & 0x1F)
    }),
    alter("supply and humidity exchanged", |w, a, v| {
        written(w, a, v, ADC_SQR2, |v| v & !0x3FF | (v & 0x1F) << 5 | v >> 5 & 0x1F)
    }),
    record("currents end at 10 A", |it| it.counts_per_ampere = 410),
    record("loop of another resistor", |it| it.loop_full_ua = 33_000),
    alter("flow meter at the wrong trigger", |w, a, v| {
        written(w, a, v, TIM2_SMCR, |v| v & !0x70 | 0x50)
    }),
    // Valves, heaters, supply, memory.
    alter("relays of a valve exchanged", |w, a, v| {
        written(w, a, v, PORT_E + BSRR, |v| exchanged(v, 0, 1))
    }),
    alter("valves exchanged", |w, a, v| {
        written(w, a, v, PORT_E + BSRR, |v| exchanged(exchanged(v, 0, 2), 1, 3))
    }),
    alter("contacts of a valve exchanged", |w, a, v| {
        seen(w, a, v, PORT_D + IDR, |v| exchanged(v, 10, 11))
    }),
    alter("end switches of a drive not read", |w, a, v| {
        seen(w, a, v, PORT_D + IDR, |v| v & !0b1100)
    }),
    alter("end switches read inverted", |w, a, v| seen(w, a, v, PORT_D + IDR, |v| v ^ 0b11)),
    alter("heaters exchanged", |w, a, v| written(w, a, v, PORT_E + BSRR, |v| exchanged(v, 4, 5))),
    alter("mirror contacts not read", |w, a, v| {
        seen(w, a, v, PORT_A + IDR, |v| v | 1 << 8 | 1 << 11)
    }),
    alter("supply not watched", |w, a, v| written(w, a, v, PWR_CR, |v| v & !(1 << 4))),
    alter("battery's registers closed", |w, a, v| written(w, a, v, PWR_CR, |v| v & !(1 << 8))),
    alter("positions kept for any record", |w, a, v| seen(w, a, v, RECORD_CRC, |_| 0)),
    alter("flash opened with a wrong key", |w, a, v| {
        let wrong = |v| if v == 0xCDEF_89AB { 0xCDEF_89AA } else { v };
        written(w, a, v, FLASH_KEY, wrong)
    }),
    alter("page erased while an answer ends", |w, a, v| seen(w, a, v, USART_BRR, |_| 0xFFFF)),
    ("a step behind each 32 bytes", Wrong { turn: step_by_step, ..Wrong::NOTHING }),
    (
        "flash written in motion",
        Wrong {
            turn: writes,
            alter: |w, a, v| seen(w, a, v, TIM8 + 0x38, |_| 0),
            ..Wrong::NOTHING
        },
    ),
    alter("flash not set to be programmed", |w, a, v| written(w, a, v, FLASH_CR, |v| v & !1)),
    // What shows behind iron alone.
    wires("voltage seen at a motor that coasts", |it| it.generates = true),
    record("full speed a third of what it is", |it| it.drives[1].full_tenths = 85),
    alter("mirror contact of valve 2 not read", |w, a, v| {
        seen(w, a, v, PORT_C + IDR, |v| v | 1 << 12)
    }),
    alter("current of the nozzle's heater not read", |w, a, v| {
        seen(w, a, v, PORT_B + IDR, |v| v | 1 << 10)
    }),
];
