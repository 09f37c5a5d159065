//! §3.3.4 A drive that turns though it is not fed: a shorted transistor, a welded relay.

use crate::common::{Rig, STEP_MS};
use lafet_device::Composition;
use lafet_device::image::{Axis, DriveInput};
use lafet_proto::flags::DriveFlags;
use lafet_proto::id::key;
use lafet_proto::param::{DriveParam, Param};
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};

const AIMING: [Axis; 3] = [Axis::Vertical, Axis::Horizontal, Axis::Nozzle];
const FAULTS: DriveFlags = DriveFlags::INTERNAL_FAULT
    .union(DriveFlags::POS_ENCODER_FAULT)
    .union(DriveFlags::SPEED_ENCODER_FAULT);

/// How far it may go before it is found, thousandths of ' or mm: 10 °, 50 mm.
const fn far_milli(axis: Axis) -> i64 {
    if matches!(axis, Axis::Nozzle) { 50_000 } else { 600_000 }
}

/// §3.3.4 Whatever its speed, from rest and out of a stop, and though it is stopped again and again: a
/// fault within a second and 10 ° or 50 mm; its supply is cut, and that of no other.
#[test]
fn found_soon_and_near() {
    for axis in AIMING {
        for tenths in [5_i16, 20, 100, 150, 250] {
            for runaway_tenths in [tenths, -tenths] {
                for stops in [false, true] {
                    runs_away(axis, runaway_tenths, stops);
                }
            }
        }
    }
}

fn runs_away(axis: Axis, runaway_tenths: i16, stops: bool) {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.plant.place(axis, 30);
    rig.pause();
    rig.run(500);
    if stops {
        rig.move_to(axis, if runaway_tenths > 0 { 60 } else { 0 });
        rig.run(200);
        rig.all_accept(Body::Stop);
    }
    rig.plant.drive(axis).runaway_tenths = runaway_tenths;
    let from_milli = rig.plant.drive(axis).position_milli;
    let mut ms = 0;
    while !rig.drive_flags(axis).intersects(FAULTS) {
        assert!(ms < 1000, "{axis:?} at {runaway_tenths} is not found");
        if stops {
            rig.ask(SubsystemId::ALL, Body::Stop);
        }
        rig.step(STEP_MS);
        ms += STEP_MS;
    }
    let way_milli = (rig.plant.drive(axis).position_milli - from_milli).abs();
    assert!(way_milli <= far_milli(axis), "{axis:?} at {runaway_tenths}: {way_milli}");
    for other in Axis::ALL {
        assert_eq!(rig.plant.outputs.drives[other as usize].cut, other == axis);
    }
    assert_eq!(rig.get(Param::GeneralInputFaults), Ok(vec![1 << (4 + axis as i32)]));
    // It stays so, and is not moved any more.
    rig.run_while(2000, |rig| rig.plant.outputs.drives[axis as usize].cut && rig.is_still());
    assert!((rig.plant.drive(axis).position_milli - from_milli).abs() <= far_milli(axis));
    assert_eq!(rig.status(axis.id(), Body::Move { destination: 0 }), Status::MODULE_FAULT);
}

type Flag = fn(&mut DriveInput) -> &mut bool;

/// What says that a position means nothing now, or something else than before.
const UNKNOWN: [Flag; 2] =
    [|input| &mut input.position_sensor_fault, |input| &mut input.unreferenced];

fn set(rig: &mut Rig, axis: Axis, flag: Flag, on: bool) {
    *flag(&mut rig.plant.inputs.drives[axis as usize]) = on;
}

/// §3.3.4 A sensor that fails or is back somewhere else, that has found or lost its place, sets the position of a drive at
/// rest: that is no jump of it, and the drive works again.
#[test]
fn a_position_that_is_set() {
    for (axis, sets) in AIMING.into_iter().flat_map(|axis| UNKNOWN.map(|sets| (axis, sets))) {
        let far = if axis == Axis::Nozzle { 20 } else { 600 };
        for (first, then) in [(0, far), (far, 0), (-far, far), (far, -far)] {
            let mut rig = Rig::new(Composition::REMOTE);
            rig.plant.place(axis, 30);
            rig.pause();
            rig.run(500);
            rig.plant.drive(axis).encoder_offset += first;
            set(&mut rig, axis, sets, true);
            rig.run(300);
            assert_eq!(rig.drive_flags(axis) & FAULTS, DriveFlags::POS_ENCODER_FAULT);
            rig.plant.drive(axis).encoder_offset += then;
            set(&mut rig, axis, sets, false);
            rig.run_while(2000, |rig| !rig.drive_flags(axis).intersects(FAULTS));
            let at = rig.drive(axis).position;
            rig.move_to(axis, at + 5);
            rig.run_until(5000, |rig| (rig.drive(axis).position - at - 5).abs() <= 1);
        }
    }
    // Without such a flag it is one.
    let mut rig = Rig::new(Composition::REMOTE);
    rig.run(500);
    rig.plant.drive(Axis::Horizontal).encoder_offset += 1200;
    rig.run(500);
    assert!(rig.drive_flags(Axis::Horizontal).contains(DriveFlags::POS_ENCODER_FAULT));
}

/// §3.3.4 A flag that comes and goes hides no drive that turns though it is not fed.
#[test]
fn a_flag_that_flickers_hides_nothing() {
    for (sets, tenths) in
        UNKNOWN.into_iter().flat_map(|sets| [(sets, 20_i16), (sets, -100), (sets, 250)])
    {
        for (on_ms, every_ms) in [(50, 100), (30, 60), (100, 110)] {
            let mut rig = Rig::new(Composition::REMOTE);
            rig.run(500);
            rig.plant.drive(Axis::Horizontal).runaway_tenths = tenths;
            let from_milli = rig.plant.drive(Axis::Horizontal).position_milli;
            let mut ms = 0;
            while !rig.plant.outputs.drives[Axis::Horizontal as usize].cut {
                assert!(ms < 10_000, "{tenths} {on_ms} {every_ms}");
                set(&mut rig, Axis::Horizontal, sets, ms % every_ms < on_ms);
                rig.step(STEP_MS);
                ms += STEP_MS;
            }
            let way_milli = rig.plant.drive(Axis::Horizontal).position_milli - from_milli;
            assert!(way_milli.abs() <= far_milli(Axis::Horizontal), "{tenths}: {way_milli}");
        }
    }
}

/// §3.3.4 What is too slow to be a runaway, a barrel that sinks or that the jet turns, is a fault after 5° or 5 mm; and its
/// supply is cut. Swaying to and fro, however long, is none.
#[test]
fn creeping() {
    for axis in AIMING {
        for tenths in [1_i16, 2, 3, 4] {
            for creep_tenths in [tenths, -tenths] {
                let mut rig = Rig::new(Composition::REMOTE);
                rig.plant.place(axis, 30);
                rig.pause();
                rig.run(1000);
                let from_milli = rig.plant.drive(axis).position_milli;
                rig.plant.drive(axis).runaway_tenths = creep_tenths;
                rig.run_until(60_000, |rig| rig.drive_flags(axis).intersects(FAULTS));
                let way_milli = (rig.plant.drive(axis).position_milli - from_milli).abs();
                let most = if axis == Axis::Nozzle { 5500 } else { 301_000 };
                assert!(way_milli <= most, "{axis:?} at {creep_tenths}: {way_milli}");
                assert!(rig.plant.outputs.drives[axis as usize].cut);
                assert_eq!(
                    rig.status(axis.id(), Body::Move { destination: 0 }),
                    Status::MODULE_FAULT
                );
            }
        }
        let mut rig = Rig::new(Composition::REMOTE);
        rig.plant.place(axis, 30);
        rig.pause();
        rig.run(1000);
        for turn in 0..40 {
            rig.plant.drive(axis).runaway_tenths = if turn % 2 == 0 { 3 } else { -3 };
            rig.run(5000);
            assert!(!rig.drive_flags(axis).intersects(FAULTS), "{axis:?}");
        }
    }
}

/// §3.3.4 A shorted stage at an end stop turns nothing, and stalls: its current is a fault within a second, of each drive, at
/// rest or after a stop; its supply is cut, and that of no other. A quarter of MaxCurrent is enough, 1 A at least.
#[test]
fn stalls_at_an_end_stop() {
    for axis in Axis::ALL {
        for (max_da, stall_da, found) in
            [(80, 150, true), (80, 20, true), (80, 19, false), (20, 10, true), (20, 9, false)]
        {
            for stops in [false, true] {
                let mut rig = Rig::deployed();
                let of = |param| Param::of_drive(axis.id(), param).unwrap();
                assert!(rig.set(of(DriveParam::SlowCurrent), 0).is_success());
                assert!(rig.set(of(DriveParam::MaxCurrent), max_da).is_success());
                if stops && axis != Axis::Deployer {
                    rig.plant.drive(axis).current_da = 5;
                    rig.move_to(axis, 60);
                    rig.run(300);
                    rig.all_accept(Body::Stop);
                }
                rig.plant.drive(axis).stall_da = stall_da;
                let mut ms = 0;
                while ms < 3000 && !rig.drive_flags(axis).contains(DriveFlags::INTERNAL_FAULT) {
                    rig.step(STEP_MS);
                    ms += STEP_MS;
                }
                assert_eq!(ms <= 1000, found, "{axis:?} {max_da} {stall_da}: {ms}");
                for other in Axis::ALL {
                    let cut = rig.plant.outputs.drives[other as usize].cut;
                    assert_eq!(cut, found && other == axis, "{axis:?}");
                }
                let bits = if found { 1 << (4 + axis as i32) } else { 0 };
                assert_eq!(rig.get(Param::GeneralInputFaults), Ok(vec![bits]));
                rig.run_while(500, |rig| rig.is_still());
            }
        }
    }
}

/// §3.3.4 What a motor drew before it stopped has 0.8 s to end, and does not add up over stops; nor does a reading that
/// blips.
#[test]
fn current_that_ends() {
    let mut rig = Rig::new(Composition::REMOTE);
    for round in 0..20 {
        rig.move_to(Axis::Horizontal, if round % 2 == 0 { 9000 } else { -9000 });
        rig.run(500);
        rig.all_accept(Body::Stop);
        rig.plant.drive(Axis::Horizontal).stall_da = 150;
        rig.run(700);
        rig.plant.drive(Axis::Horizontal).stall_da = 0;
        rig.run(700);
    }
    for ms in (0..5000).step_by(10) {
        rig.plant.drive(Axis::Horizontal).stall_da = if ms % 100 < 40 { 150 } else { 0 };
        rig.step(10);
    }
    // One sample in a step that is long says nothing of what lasts.
    for _ in 0..6 {
        rig.plant.drive(Axis::Horizontal).stall_da = 150;
        rig.step(60_000);
        rig.plant.drive(Axis::Horizontal).stall_da = 0;
        rig.run(200);
    }
    assert!(!rig.drive_flags(Axis::Horizontal).intersects(FAULTS));
    assert!(!rig.plant.outputs.drives[Axis::Horizontal as usize].cut);
}

/// §3.3.4, §3.12/2, §3.19/1 The supply stays cut up to the reset itself: while the memory is written or erased
/// nothing watches the drive.
#[test]
fn cut_up_to_the_reset() {
    let clean = Body::CleanFlash { key: key::CLEAN_FLASH };
    for (to, body) in [(SubsystemId::ALL, Body::Restart), (SubsystemId::GENERAL, clean)] {
        let mut rig = Rig::new(Composition::REMOTE);
        rig.plant.drive(Axis::Horizontal).runaway_tenths = 100;
        rig.run_until(1000, |rig| rig.plant.outputs.drives[Axis::Horizontal as usize].cut);
        assert!(rig.ask(to, body).iter().all(|answer| answer.status.is_success()));
        while rig.plant.resets == 0 {
            rig.now_ms += STEP_MS;
            rig.plant.advance(STEP_MS);
            rig.device.step(rig.now_ms, &mut rig.plant);
            assert!(rig.plant.outputs.drives[Axis::Horizontal as usize].cut, "{body:?}");
        }
        assert!(rig.is_still());
    }
}

/// §3.3.4 Each sensor by itself is enough, and the flag says which of them speaks against the other.
#[test]
fn by_either_sensor() {
    for (speed_dead, stuck, flag) in [
        (false, false, DriveFlags::INTERNAL_FAULT),
        (true, false, DriveFlags::POS_ENCODER_FAULT),
        (false, true, DriveFlags::SPEED_ENCODER_FAULT),
    ] {
        let mut rig = Rig::new(Composition::REMOTE);
        rig.run(500);
        let drive = rig.plant.drive(Axis::Horizontal);
        (drive.speed_dead, drive.encoder_stuck) = (speed_dead, stuck.then_some(0));
        drive.runaway_tenths = 100;
        rig.run_until(1000, |rig| rig.drive_flags(Axis::Horizontal).contains(flag));
        assert!(rig.plant.outputs.drives[Axis::Horizontal as usize].cut);
    }
}

/// §3.3.4 A stage that lets the drive run out for 0.3 s (a lag of the first order), the swaying of a
/// barrel, a position that blips and the noise of sensors are no runaway.
#[test]
fn what_is_none() {
    type Sensed = fn(ms: f64) -> (f64, f64);
    // Position in ' and speed in 0.1 °/s after the stop.
    let cases: [(&str, Sensed); 5] = [
        ("runs out", |ms| {
            let rest = (-ms / 300.0).exp();
            (1200.0 * 0.3 * (1.0 - rest), 200.0 * rest)
        }),
        ("sways", |ms| (2.0 * (ms / 90.0).sin(), 3.0 * (ms / 90.0).cos())),
        ("blips", |ms| (if (800.0..900.0).contains(&ms) { 1200.0 } else { 0.0 }, 0.0)),
        ("noise", |ms| (if (ms as u32 / 10).is_multiple_of(3) { 1.0 } else { 0.0 }, 1.0)),
        // A sample of twelve, in each phase of a stretch.
        ("noise and blips", |ms| {
            let sample = ms as u32 / 10;
            (if sample.is_multiple_of(13) { 1200.0 } else { f64::from(sample % 2) }, 1.0)
        }),
    ];
    for (what, sensed) in cases {
        let mut rig = Rig::new(Composition::REMOTE);
        rig.move_to(Axis::Horizontal, 10_800);
        rig.run(1500);
        let at = rig.plant.inputs.drives[Axis::Horizontal as usize].position;
        rig.all_accept(Body::Stop);
        for ms in (0..4000).step_by(10) {
            rig.now_ms += 10;
            let (position, tenths) = sensed(f64::from(ms));
            let input = &mut rig.plant.inputs.drives[Axis::Horizontal as usize];
            input.position = at + position.round() as i32;
            input.speed_tenths = tenths.round() as i16;
            input.current_da = 0;
            rig.device.step(rig.now_ms, &mut rig.plant);
            let flags = rig.drive_flags(Axis::Horizontal);
            assert!(!flags.intersects(FAULTS), "{what}: {flags:?} after {ms} ms");
        }
    }
}

/// §3.3.4 A position that jumps by 5° (5 mm) or more while its drive rests is a fault of its sensor, 0.24 s later: the
/// drive refuses, and keeps its supply, for it has not turned.
#[test]
fn a_jump_at_rest() {
    for axis in AIMING {
        let far = if axis == Axis::Nozzle { 5 } else { 300 };
        for (jump, found) in [(far, true), (-far, true), (4 * far, true), (far - 1, false)] {
            let mut rig = Rig::new(Composition::REMOTE);
            rig.run(500);
            rig.plant.drive(axis).encoder_offset = jump;
            rig.run_while(230, |rig| !rig.drive_flags(axis).intersects(FAULTS));
            rig.run(10);
            let flag = DriveFlags::POS_ENCODER_FAULT;
            let expected = if found { flag } else { DriveFlags::empty() };
            assert_eq!(rig.drive_flags(axis) & FAULTS, expected, "{axis:?} by {jump}");
            rig.run_while(2000, |rig| !rig.plant.outputs.drives[axis as usize].cut);
            let status = rig.status(axis.id(), Body::Move { destination: 1 });
            assert_eq!(status == Status::MODULE_FAULT, found, "{axis:?} by {jump}");
            assert_eq!(rig.get(Param::GeneralInputFaults), Ok(vec![0]));
            // Where it is when the monitor starts it is.
            rig.power_cycle_and_settle();
            rig.run_while(500, |rig| !rig.drive_flags(axis).intersects(FAULTS));
        }
    }
}
