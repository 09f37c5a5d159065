//! The board as the monitor's program sees it.

use crate::analog::{self, Analog};
use crate::bus::{Bus, Registers};
use crate::clock::{self, Clock};
use crate::contacts::Contacts;
use crate::drives::{Drives, filtered};
use crate::flash::{self, InternalFlash};
use crate::line::Line;
use crate::record::Record;
use crate::{pins, power, watchdog};
use lafet_device::Composition;
use lafet_device::composition::ChainSet;
use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{Inputs, UnitInput};
use lafet_device::store::Store;
use lafet_proto::SubsystemId;
use lafet_turn::{Board, Start};
use stm32_metapac::timer::vals::{Sms, Ts};
use stm32_metapac::{TIM2, TIM6};

/// What this board has: no detector, no radio and no posts of buttons are connected, so they are not in
/// the chain.
pub const CHAIN: ChainSet = ChainSet::ALL.without(&[
    SubsystemId::DETECTOR,
    SubsystemId::RADIO,
    SubsystemId::BUTTONS,
    SubsystemId::EXT_BUTTONS,
]);
/// As [`CHAIN`], for a monitor whose parameters are blank.
static COMPOSITION: Composition =
    Composition { name: "stm32f103", chain: CHAIN, ..Composition::FULL };
/// A monitor whose parameters are blank answers to this address.
const ADDRESS: u8 = 1;
/// A board without a record speaks at the baud that a monitor of §L has.
const BAUD: u32 = 19_200;
/// Ticks of the time in a ms.
const TICKS: u16 = 10;
/// Time over which the flow meter's pulses are counted, ms.
const FLOW_MS: u32 = 500;
/// Ticks from the pull-ups on until contacts are read: 5 ms. With 10 nF in front of each pin a pull-up of
/// 50 kΩ takes 0.55 ms; the wires to the contact take some, too.
const SETTLING: u16 = 5 * TICKS;
/// Looks until that time must be over, if the timer runs.
const SETTLING_LOOKS: u32 = 100_000;
/// Ticks for which no encoder may move before a reset: 20 ms.
const RESTING: u16 = 20 * TICKS;
/// Time that an answer has to leave before a reset, in looks of a µs or so.
const LEAVING_LOOKS: u32 = 300_000;

/// Where the memory is that the DMA fills and empties.
#[derive(Clone, Copy, Debug)]
pub struct Memory {
    /// [`crate::line::RECEIVED`] bytes.
    pub received: u32,
    /// [`crate::line::SENT`] bytes.
    pub sent: u32,
    /// [`analog::BYTES`] bytes in whole words, at the address of one.
    pub samples: u32,
}

/// Ticks of TIM6 as milliseconds.
#[derive(Clone, Copy, Debug, Default)]
struct Time {
    /// Ticks that the ms up to now took.
    ticks: u16,
    now_ms: u32,
}

impl Time {
    /// The ms, after a look at the counter within 6.5 s of the last.
    fn advance(&mut self, count: u16) -> u32 {
        let ms = count.wrapping_sub(self.ticks) / TICKS;
        self.ticks = self.ticks.wrapping_add(ms * TICKS);
        self.now_ms = self.now_ms.wrapping_add(ms.into());
        self.now_ms
    }
}

/// Pulses of the flow meter as l/s.
#[derive(Clone, Copy, Debug, Default)]
struct Flow {
    last: u16,
    since_ms: u32,
    lps: u16,
}

/// The board.
#[derive(Clone, Debug)]
pub struct Stm32f103<B> {
    bus: B,
    clock: Clock,
    record: Option<Record>,
    store: Store<InternalFlash<B>>,
    line: Line<B>,
    analog: Analog<B>,
    drives: Drives<B>,
    contacts: Contacts<B>,
    time: Time,
    stepped_ms: u32,
    dt_ms: u32,
    flow: Flow,
    sampled: bool,
    reset_by_watchdog: bool,
}

impl<B: Bus> Stm32f103<B> {
    /// Starts everything, with nothing driven, from the state after a reset.
    pub fn start(bus: B, memory: Memory) -> Self {
        let reset_by_watchdog = watchdog::has_bitten(&bus);
        let clock = clock::start(&bus);
        watchdog::start(&bus);
        pins::start(&bus);
        power::start(&bus);
        time(&bus, clock.hz);
        // The jumper is read once: a pin that is not charged yet would say "parked".
        bus.wait(TIM6.cnt(), SETTLING_LOOKS, |count| count.cnt() >= SETTLING);
        let record = Record::read(&bus);
        let known = record.unwrap_or(Record { baud: BAUD, ..Record::NOMINAL });
        let analog = Analog::start(bus.clone(), memory.samples);
        let drives = Drives::start(bus.clone(), clock.hz, &known.drives, record.is_some());
        flow(&bus);
        let line = Line::start(bus.clone(), clock.hz, known.baud, memory.received, memory.sent);
        analog.wait();
        let store = Store::mount(InternalFlash::new(bus.clone()), 0, flash::PAGES);
        Self {
            contacts: Contacts::new(bus.clone()),
            bus,
            clock,
            record,
            store,
            line,
            analog,
            drives,
            time: Time::default(),
            stepped_ms: 0,
            dt_ms: 0,
            flow: Flow::default(),
            sampled: false,
            reset_by_watchdog,
        }
    }

    /// What it runs on.
    pub const fn clock(&self) -> Clock {
        self.clock
    }

    /// Whether the factory's record is there: nothing is driven without.
    pub const fn has_record(&self) -> bool {
        self.record.is_some()
    }

    fn count(&self) -> u16 {
        self.bus.get(TIM6.cnt()).cnt()
    }

    /// Drives and heaters may have power, and valves may open.
    fn may_drive(&self) -> bool {
        self.record.is_some() && self.sampled && !power::is_failing(&self.bus)
    }

    fn read_flow(&mut self, now_ms: u32, pulses_per_10_l: u32) -> u16 {
        let passed = now_ms.wrapping_sub(self.flow.since_ms);
        if passed >= FLOW_MS {
            let count = self.bus.get(TIM2.cnt()).cnt();
            let pulses = u32::from(count.wrapping_sub(self.flow.last));
            // 10 l a 1000 ms, in rounded l/s.
            let scale = pulses_per_10_l.saturating_mul(passed);
            let lps = (pulses.saturating_mul(10_000) + scale / 2).checked_div(scale);
            self.flow = Flow { last: count, since_ms: now_ms, lps: lps.unwrap_or_default() as u16 };
        }
        self.flow.lps
    }
}

/// The flow meter's pulses on TIM2's second channel clock its counter (RM §15.3.3).
fn flow(bus: &impl Bus) {
    bus.set(TIM2.ccmr_input(0), filtered);
    bus.set(TIM2.smcr(), |smcr| {
        smcr.set_sms(Sms::EXT_CLOCK_MODE);
        smcr.set_ts(Ts::TI2FP2);
    });
    bus.set(TIM2.arr(), |arr| arr.set_arr(u16::MAX));
    bus.set(TIM2.cr1(), |cr1| cr1.set_cen(true));
}

/// TIM6 counts tenths of a ms, without any interrupt: a step that takes long loses none.
fn time(bus: &impl Bus, hz: u32) {
    bus.put(TIM6.psc(), (hz / 10_000 - 1) as u16);
    bus.set(TIM6.arr(), |arr| arr.set_arr(u16::MAX));
    bus.set(TIM6.egr(), |egr| egr.set_ug(true));
    bus.set(TIM6.cr1(), |cr1| cr1.set_cen(true));
}

impl<B: Bus> Board for Stm32f103<B> {
    fn start(&mut self, _after_fault: bool) -> Start {
        Start { now_ms: self.time.now_ms, composition: &COMPOSITION, address: ADDRESS }
    }

    fn reset_by_watchdog(&mut self) -> bool {
        self.reset_by_watchdog
    }

    fn lacks_crystal(&self) -> bool {
        !self.clock.is_external
    }

    fn now_ms(&self) -> u32 {
        self.time.now_ms
    }

    fn due(&mut self) -> Option<u32> {
        let count = self.count();
        let now_ms = self.time.advance(count);
        (now_ms != self.stepped_ms).then_some(now_ms)
    }

    /// The watchdog is fed by finished steps alone.
    fn stepped(&mut self) {
        watchdog::feed(&self.bus);
    }

    fn receive<'b>(&mut self, buffer: &'b mut [u8]) -> &'b [u8] {
        self.line.send();
        self.line.receive(buffer)
    }

    fn put(&mut self, byte: u8) {
        self.line.put(byte);
    }

    fn release(&mut self) {
        self.line.send();
    }
}

impl<B: Bus> Hal for Stm32f103<B> {
    fn read(&mut self, inputs: &mut Inputs) {
        let now_ms = self.time.now_ms;
        self.dt_ms = now_ms.wrapping_sub(self.stepped_ms);
        self.stepped_ms = now_ms;
        let (dt_ms, analog) = (self.dt_ms, &self.analog);
        // At 20 kHz a ms without a scan is one without an ADC: what it gave last says nothing.
        self.sampled = analog.is_alive();
        let record = self.record.unwrap_or(Record::NOMINAL);
        let current_da = |place: usize| {
            let tenths = analog.sample(place) * 10;
            tenths.checked_div(record.counts_per_ampere).unwrap_or_default() as u16
        };
        let scaled = |place: usize, full: u32| (analog.sample(place) * full / 4_096) as u16;
        self.drives.read(dt_ms, &mut inputs.drives, current_da);
        let [_, _, _, deployer] = &mut inputs.drives;
        self.contacts.read_deployer(dt_ms, deployer);
        // Without scales or samples it is none: a valve is to close all the same.
        let known = self.record.is_some() && self.sampled;
        let valves_da = if known { current_da(analog::VALVES) } else { 0 };
        self.contacts.read_valves(dt_ms, &mut inputs.valves, valves_da);
        self.contacts.read_heaters(dt_ms, &mut inputs.places);
        for (place, input) in (analog::PLACES..).zip(&mut inputs.places) {
            input.temperature_dc = analog::temperature_dc(analog.sample(place));
        }
        inputs.humidity_percent = analog::humidity_percent(analog.sample(analog::HUMIDITY));
        inputs.pressure_ua = scaled(analog::LOOP, record.loop_full_ua);
        inputs.main_voltage_dv = scaled(analog::SUPPLY, record.supply_full_dv);
        inputs.flow_lps = self.read_flow(now_ms, record.pulses_per_10_l);
        inputs.units = [UnitInput::default(); 6];
        for unit in &mut inputs.units {
            // There is no internal bus: what is on it is on this board.
            unit.online = true;
        }
    }

    fn write(&mut self, outputs: &Passed) {
        let may = self.may_drive();
        // The stages have one enable: a drive that turns though it is not fed takes it from all of them.
        let may_drive = may && !outputs.drives.iter().any(|drive| drive.cut);
        let speeds = outputs.drives.map(|drive| drive.speed_tenths);
        self.drives.write(speeds, self.dt_ms, may_drive);
        // A relay needs neither scale nor sample, and the core bounds its time: Close and Lockout always act.
        let may_close = !power::is_failing(&self.bus);
        self.contacts.write(outputs.valves, outputs.heaters, may, may_close);
    }

    fn reset(&mut self) {
        self.drives.disarm();
        let resting = self.drives.counts();
        let began = self.count();
        // The answer to Restart leaves first, if it does in its time.
        for _ in 0..LEAVING_LOOKS {
            self.line.send();
            let waited = self.count().wrapping_sub(began);
            if self.line.is_idle() && waited >= RESTING {
                break;
            }
        }
        self.drives.keep_before_reset(resting);
        self.bus.reset();
    }
}

impl<B: Bus> Storage for Stm32f103<B> {
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
