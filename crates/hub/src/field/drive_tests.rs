//! Outputs in virtual time, against a device that fails in every way, judged by an oracle that shares
//! nothing with the code but the words.

use super::super::point::Point;
use super::*;

const UNIT: u8 = 1;
const VALID: Duration = Duration::from_secs(2);

fn output(id: &str, drives: Drives, set: &str) -> OutputConfig {
    let target = Target::parse(set).unwrap();
    let id = id.to_owned();
    OutputConfig { id, drives, unit: UNIT, target, on: None, fault: None, read_back: true }
}

fn at(ms: u64) -> Now {
    Duration::from_millis(ms)
}

fn drive(outputs: &[OutputConfig], reads: u8) -> Drive {
    let mut drive = Drive::new(outputs, &[], Duration::from_secs(2), reads);
    drive.connects(true);
    drive
}

fn valve() -> Drive {
    drive(&[output("V", Drives::Valve, "coil:3")], 1)
}

fn opens(number: u64, now: u64) -> Order {
    Order { on: true, number, not_after: Some(at(now) + VALID) }
}

fn closes(number: u64) -> Order {
    Order { on: false, number, not_after: None }
}

fn reads(drive: &mut Drive, ms: u64, value: u16) {
    drive.read(at(ms), UNIT, (Table::Coil, 3), value);
}

fn writes(drive: &mut Drive, ms: u64, failure: Option<&Failure>) -> bool {
    let job = drive.next(at(ms)).expect("something is to be written");
    drive.wrote(at(ms), &job, failure);
    job.on
}

fn reported(drive: &mut Drive, ms: u64) -> Option<bool> {
    drive.reports(at(ms)).into_iter().find_map(|it| it.on)
}

#[test]
fn nothing_is_written_without_an_order_and_what_is_found_is_reported() {
    let mut drive = valve();
    reads(&mut drive, 0, 1);
    assert_eq!((drive.next(at(0)), drive.due(at(0))), (None, None));
    assert_eq!(reported(&mut drive, 0), Some(true));
    drive.connects(false);
    drive.connects(true);
    assert_eq!(drive.next(at(100)), None);
}

#[test]
fn a_write_counts_when_it_was_answered_and_read_back() {
    let mut drive = valve();
    drive.order("V", opens(1, 0));
    reads(&mut drive, 5, 1);
    // It was so before the write: that confirms nothing.
    assert_eq!(reported(&mut drive, 5), Some(false));
    assert!(writes(&mut drive, 10, None));
    assert_eq!((reported(&mut drive, 10), drive.next(at(10))), (None, None));
    reads(&mut drive, 20, 1);
    assert_eq!(reported(&mut drive, 20), Some(true));
    // On a serial line one more read has to show it.
    let mut serial = super::tests::drive(&[output("V", Drives::Valve, "coil:3")], 2);
    serial.order("V", closes(1));
    writes(&mut serial, 0, None);
    reads(&mut serial, 10, 0);
    assert_eq!(reported(&mut serial, 10), Some(true), "not as wanted yet");
    reads(&mut serial, 20, 0);
    assert_eq!(reported(&mut serial, 20), Some(false));
}

#[test]
fn an_opening_is_void_after_its_time_also_when_a_retry_is_due() {
    let mut drive = valve();
    drive.order("V", opens(1, 0));
    assert!(writes(&mut drive, 1900, Some(&Failure::Timeout)));
    assert_eq!(drive.next(at(1999)), None, "a pause after a failure");
    assert!(drive.next(at(2000)).is_some());
    assert_eq!((drive.next(at(2001)), drive.due(at(2001))), (None, None));
    // A job that was taken in time is looked at once more before it goes on the wire.
    let mut late = valve();
    late.order("V", opens(1, 0));
    let job = late.next(at(2000)).unwrap();
    assert!(late.is_current(&job, at(2000)) && !late.is_current(&job, at(2001)));
    late.order("V", closes(2));
    assert!(!late.is_current(&job, at(100)));
}

#[test]
fn a_closing_is_tried_until_it_is_answered_and_read_back() {
    let mut drive = valve();
    drive.order("V", closes(1));
    let mut tried = Vec::new();
    for ms in 0..10_000 {
        if drive.next(at(ms)).is_some() {
            writes(&mut drive, ms, Some(&Failure::Timeout));
            tried.push(ms);
        }
    }
    assert_eq!(tried[..6], [0, 100, 300, 700, 1500, 2500], "{tried:?}");
    assert_eq!(tried.len(), 13, "{tried:?}");
    assert!(!writes(&mut drive, 20_000, None));
    reads(&mut drive, 20_010, 1);
    assert!(drive.due(at(20_010)).is_some_and(|at| at <= self::at(21_010)), "it is not so yet");
    writes(&mut drive, 22_000, None);
    reads(&mut drive, 22_010, 0);
    assert_eq!((drive.next(at(30_000)), drive.due(at(22_010))), (None, None));
    // The device opens it by itself.
    reads(&mut drive, 30_000, 1);
    assert!(!writes(&mut drive, 30_000, None));
}

#[test]
fn what_is_new_does_not_wait_for_a_silent_device() {
    let mut drive = valve();
    drive.order("V", opens(1, 0));
    for ms in [0, 100, 300, 700, 1500] {
        writes(&mut drive, ms, Some(&Failure::Timeout));
    }
    assert_eq!(drive.next(at(1600)), None);
    drive.order("V", closes(2));
    let job = drive.next(at(1600)).unwrap();
    assert!(!job.on && !job.again, "as urgent as any other: {job:?}");
}

#[test]
fn a_closing_goes_before_an_opening_and_is_not_overtaken_by_one() {
    let two = [output("V", Drives::Valve, "coil:3"), output("W", Drives::Valve, "coil:4")];
    let horn = output("H", Drives::Signal, "coil:5");
    let mut drive = super::tests::drive(&[horn, two[0].clone(), two[1].clone()], 1);
    drive.order("H", Order { on: true, number: 1, not_after: None });
    drive.order("V", opens(2, 0));
    drive.order("W", closes(3));
    let mut order = Vec::new();
    while let Some(job) = drive.next(at(10)) {
        drive.wrote(at(10), &job, None);
        order.push((job.of, job.on));
    }
    assert_eq!(order, [(Of::Output(2), false), (Of::Output(1), true), (Of::Output(0), true)]);
    // Closing replaces an opening that waits; an opening waits for the closing before it.
    let mut drive = valve();
    drive.order("V", opens(1, 0));
    drive.order("V", closes(2));
    assert!(!drive.next(at(1)).unwrap().on);
    drive.order("V", opens(3, 1));
    drive.order("V", opens(4, 1));
    assert!(!writes(&mut drive, 2, Some(&Failure::Timeout)));
    assert!(!writes(&mut drive, 200, None));
    assert!(writes(&mut drive, 201, None));
    assert_eq!(drive.next(at(202)), None);
}

#[test]
fn a_lost_line_restores_what_is_closed_or_lit_and_opens_nothing() {
    let lamp = output("L", Drives::Signal, "coil:4");
    let outputs = [output("V", Drives::Valve, "coil:3"), lamp, output("P", Drives::Pump, "coil:5")];
    let mut drive = super::tests::drive(&outputs, 1);
    drive.order("V", closes(1));
    drive.order("L", Order { on: true, number: 2, not_after: None });
    drive.order("P", opens(3, 0));
    for _ in 0..3 {
        writes(&mut drive, 10, None);
    }
    drive.connects(false);
    drive.connects(true);
    let mut again = Vec::new();
    while let Some(job) = drive.next(at(500)) {
        drive.wrote(at(500), &job, None);
        again.push((job.of, job.on));
    }
    assert_eq!(again, [(Of::Output(0), false), (Of::Output(1), true)]);
    // So does a device that was silent behind its gateway.
    drive.breaks(UNIT);
    reads(&mut drive, 6000, 0);
    assert_eq!(drive.next(at(6000)).map(|job| job.of), Some(Of::Output(0)));
}

#[test]
fn a_device_that_drops_its_coils_is_noticed_and_the_zones_hear_it() {
    let mut drive = valve();
    drive.order("V", opens(1, 0));
    writes(&mut drive, 10, None);
    reads(&mut drive, 20, 1);
    drive.reports(at(20));
    reads(&mut drive, 1500, 0);
    let [news] = drive.reports(at(1500))[..] else { panic!("one output") };
    assert_eq!((news.on, news.trouble), (Some(false), Some(Some(Trouble::Dropped))));
    assert_eq!(drive.next(at(1500)), None, "whether it is still wanted the zones know");
    drive.order("V", opens(2, 1500));
    writes(&mut drive, 1510, None);
    reads(&mut drive, 1520, 1);
    let [news] = drive.reports(at(1520))[..] else { panic!("one output") };
    assert_eq!((news.on, news.trouble), (Some(true), Some(None)));
}

#[test]
fn feedback_faults_and_refusals_are_said() {
    let mut config = output("V", Drives::Valve, "coil:3");
    config.on = Some(Point::parse("discrete:1").unwrap());
    config.fault = Some(Point::parse("!discrete:2").unwrap());
    let mut drive = super::tests::drive(&[config], 1);
    let discretes = |drive: &mut Drive, ms: u64, on: u16, well: u16| {
        drive.read(at(ms), UNIT, (Table::Discrete, 1), on);
        drive.read(at(ms), UNIT, (Table::Discrete, 2), well);
    };
    drive.order("V", opens(1, 0));
    writes(&mut drive, 0, Some(&Failure::Exception(4)));
    reads(&mut drive, 1, 0);
    discretes(&mut drive, 1, 0, 1);
    let troubles = |drive: &mut Drive, ms| drive.reports(at(ms)).pop().and_then(|it| it.trouble);
    assert_eq!(troubles(&mut drive, 1), Some(Some(Trouble::Refused)));
    writes(&mut drive, 200, None);
    reads(&mut drive, 210, 1);
    assert_eq!(troubles(&mut drive, 210), Some(None));
    assert_eq!(drive.outputs[0].state(), Some(false), "the valve has not moved");
    discretes(&mut drive, 220, 1, 0);
    let news = drive.reports(at(220)).pop().unwrap();
    assert_eq!((news.on, news.trouble), (Some(true), Some(Some(Trouble::Fault))));
    assert_eq!(troubles(&mut drive, 2221), Some(Some(Trouble::Lost)));
}

#[test]
fn heartbeats_change_every_second_and_stop_with_the_zone_controller() {
    let target = Target::parse("coil:15").unwrap();
    let mut drive = Drive::new(&[], &[(UNIT, target)], Duration::from_secs(2), 1);
    drive.connects(true);
    assert_eq!(drive.next(at(0)), None);
    drive.beats(true);
    let mut beats = Vec::new();
    for ms in 0..3500 {
        if let Some(job) = drive.next(at(ms)) {
            drive.wrote(at(ms), &job, None);
            beats.push((ms, job.on));
        }
    }
    assert_eq!(beats, [(0, true), (1000, false), (2000, true), (3000, false)]);
    drive.beats(false);
    assert_eq!((drive.next(at(9000)), drive.due(at(9000))), (None, None));
}

/// A device with three coils, and the machine and the line beside it.
struct World {
    drive: Drive,
    coils: [bool; 3],
    seed: u64,
    now: u64,
    number: u64,
    /// The latest order of each output, and when the direction was last changed.
    orders: [Option<(Order, u64)>; 3],
    /// When a write of off, or of on, was last answered.
    answered: [[Option<u64>; 2]; 3],
    /// A closing that has to be answered before anything opens: since when.
    must_close: [Option<u64>; 3],
    reported: [Option<bool>; 3],
    repeat: [u64; 3],
    opened: u32,
    confirmed: u32,
}

const DRIVES: [Drives; 3] = [Drives::Valve, Drives::Pump, Drives::Signal];

impl World {
    fn new(seed: u64) -> Self {
        let outputs: Vec<OutputConfig> = DRIVES
            .iter()
            .enumerate()
            .map(|(index, drives)| output(&index.to_string(), *drives, &format!("coil:{index}")))
            .collect();
        Self {
            drive: drive(&outputs, 1),
            coils: [false; 3],
            seed,
            now: 0,
            number: 0,
            orders: [None; 3],
            answered: [[None; 2]; 3],
            must_close: [None; 3],
            reported: [None; 3],
            repeat: [0; 3],
            opened: 0,
            confirmed: 0,
        }
    }

    fn chance(&mut self, of: u64) -> bool {
        self.seed = self.seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.seed >> 33).is_multiple_of(of)
    }

    fn order(&mut self, index: usize, on: bool) {
        self.number += 1;
        let lasts = DRIVES[index] == Drives::Signal || !on;
        let not_after = (!lasts).then(|| at(self.now) + VALID);
        let order = Order { on, number: self.number, not_after };
        let since = match self.orders[index] {
            Some((before, since)) if before.on == on => since,
            _ => self.now,
        };
        self.orders[index] = Some((order, since));
        if !on {
            self.must_close[index] = Some(self.now);
        }
        self.repeat[index] = self.now + 1000;
        assert!(self.drive.order(&index.to_string(), order));
    }

    /// One write; the line may fail.
    fn write(&mut self, faults: bool) {
        let Some(job) = self.drive.next(at(self.now)) else { return };
        let Of::Output(index) = job.of else { return };
        // Orders come while the line is waited for.
        if faults && self.chance(8) {
            let on = self.chance(2);
            self.order(index, on);
        }
        if !self.drive.is_current(&job, at(self.now)) {
            return;
        }
        self.judge_write(index, job.on);
        let (fails, executes) = (faults && self.chance(3), !faults || !self.chance(4));
        if executes || !fails {
            self.coils[index] = job.on;
        }
        let failure =
            [Failure::Timeout, Failure::Exception(4), Failure::WrongEcho, Failure::GivenUp];
        let failure = match fails {
            true if executes => Some(Failure::Timeout),
            true => failure.get((self.seed % 4) as usize).cloned(),
            false => None,
        };
        self.now += if failure == Some(Failure::Timeout) { 200 } else { 5 };
        if failure.is_none() {
            self.answered[index][usize::from(job.on)] = Some(self.now);
            if !job.on {
                self.must_close[index] = None;
            }
        }
        self.drive.wrote(at(self.now), &job, failure.as_ref());
    }

    /// What is on the wire is what is wanted now, and in its time.
    fn judge_write(&mut self, index: usize, on: bool) {
        let (order, _) = self.orders[index].expect("nothing is written without an order");
        if on && DRIVES[index] != Drives::Signal {
            assert!(order.on, "{index}: opened against the latest order at {}", self.now);
            assert!(order.not_after >= Some(at(self.now)), "{index}: a void order at {}", self.now);
            assert_eq!(self.must_close[index], None, "{index}: a closing was overtaken");
            self.opened += 1;
        } else if !on && order.on {
            assert!(self.must_close[index].is_some(), "{index}: closed against the latest order");
        }
    }

    fn read(&mut self, faults: bool) {
        if faults && self.chance(6) {
            self.now += 200;
            self.drive.breaks(UNIT);
            return;
        }
        for (index, coil) in self.coils.into_iter().enumerate() {
            self.drive.read(at(self.now), UNIT, (Table::Coil, index as u16), u16::from(coil));
        }
        for report in self.drive.reports(at(self.now)) {
            let (index, Some(on)) = (report.output, report.on) else { continue };
            self.reported[index] = Some(on);
            let Some((order, since)) = self.orders[index].filter(|(order, _)| order.on == on)
            else {
                continue;
            };
            // Confirmed: answered after the order, and so in the device now.
            let answered = self.answered[index][usize::from(on)];
            assert!(answered >= Some(since), "{index}: {order:?} {since} {answered:?}");
            assert_eq!(self.coils[index], on, "{index}");
            self.confirmed += 1;
        }
    }

    /// The machine orders again what is not reported.
    fn repeat(&mut self) {
        for index in 0..3 {
            let Some((order, _)) = self.orders[index] else { continue };
            if self.reported[index] != Some(order.on) && self.now >= self.repeat[index] {
                self.order(index, order.on);
            }
        }
    }

    fn step(&mut self, faults: bool) {
        self.write(faults);
        if self.chance(3) {
            self.read(faults);
        }
        self.repeat();
        self.now += 10;
    }
}

#[test]
fn whatever_the_line_does_nothing_opens_late_and_everything_closes_in_the_end() {
    let (mut opened, mut confirmed) = (0, 0);
    for seed in 0..300 {
        let mut world = World::new(seed * 7919 + 1);
        for _ in 0..6 {
            for _ in 0..200 {
                if world.chance(25) {
                    let index = (world.seed >> 40) as usize % 3;
                    let on = world.chance(2);
                    world.order(index, on);
                }
                if world.chance(80) {
                    world.coils = [false; 3];
                }
                if world.chance(80) {
                    world.drive.connects(false);
                    world.now += 700;
                    world.drive.connects(true);
                }
                world.step(true);
            }
            // The line is well again: everything is as it is wanted, and reported so.
            for _ in 0..500 {
                world.step(false);
            }
            for (index, order) in world.orders.into_iter().enumerate() {
                let Some((order, _)) = order else { continue };
                assert_eq!(world.coils[index], order.on, "seed {seed} output {index}");
                assert_eq!(world.reported[index], Some(order.on), "seed {seed} output {index}");
            }
        }
        opened += world.opened;
        confirmed += world.confirmed;
    }
    // It was not idle.
    assert!(opened > 5000 && confirmed > 5000, "{opened} {confirmed}");
}
