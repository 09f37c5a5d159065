//! Programs of extinguishing on the bench: real drives, motors that obey.

use super::bench::{BY, Bench, CYCLE_MS, damaged_params, one};
use super::*;
use lafet_ballistics::{Jet, Solver, Target};
use lafet_proto::flags::ControlFlags as F;
use lafet_proto::param::Param;
use lafet_proto::request::{Points, Sector, TrajectoryPoint};
use lafet_proto::{Bytes, Ints};
use std::vec::Vec;

const SECTOR: Sector =
    Sector { centre_h: 1800, centre_v: -120, nozzle: 60, width: 600, height: 300, step: 2 };
const POINT: Sector = Sector { width: 0, height: 0, step: 0, ..SECTOR };

fn full(sector: Sector, distance: i8) -> Quench<'static> {
    Quench::Full { sector, distance }
}

fn quench(bench: &mut Bench, control: &mut Control, quench: &Quench<'_>) -> Status {
    control.start_quench(quench, BY, &bench.env())
}

fn run(bench: &mut Bench, control: &mut Control, ms: u32) {
    watch(bench, control, ms, |_, _| ());
}

fn watch(
    bench: &mut Bench,
    control: &mut Control,
    ms: u32,
    mut each: impl FnMut(&Bench, &Control),
) {
    for _ in 0..ms / CYCLE_MS {
        bench.cycle();
        control.step(bench.now, &mut bench.env());
        each(bench, control);
    }
}

/// A program that has been accepted on a bench.
fn started(request: &Quench<'_>) -> (Bench, Control) {
    let (mut bench, mut control) = (Bench::new(), Control::default());
    assert_eq!(quench(&mut bench, &mut control, request), Status::ACCEPTED);
    (bench, control)
}

fn assert_near(aim: (i32, i32), expected: (i32, i32)) {
    let near = (aim.0 - expected.0).abs() <= 3 && (aim.1 - expected.1).abs() <= 3;
    assert!(near, "{aim:?}, not {expected:?}");
}

/// The elevation that ballistics give at 79 and a nozzle of 28 mm.
fn elevation(sight: i32, distance: u8, nozzle: i32) -> i32 {
    let mut solver =
        Solver::new(Jet::new(79, 280, nozzle).unwrap(), Target::new(sight, distance, 150));
    (0..100).find_map(|_| solver.step()).unwrap().unwrap()
}

/// §3.14/1 The jet goes over the sector in lines, each to and fro, and out of it nowhere.
#[test]
fn scans_line_by_line() {
    let (mut bench, mut control) = started(&full(SECTOR, 0));
    assert_eq!(control.flags(), F::QUENCH);
    run(&mut bench, &mut control, 15_000);
    let mut lines: Vec<i32> = Vec::new();
    let (mut right, mut left, mut top, mut bottom) = (i32::MAX, i32::MIN, i32::MIN, i32::MAX);
    let mut ends = 0;
    watch(&mut bench, &mut control, 60_000, |bench, _| {
        let (h, v) = bench.aim();
        (right, left) = (right.min(h), left.max(h));
        (bottom, top) = (bottom.min(v), top.max(v));
        assert!(bench.drives[1].output().speed_tenths.abs() <= 50);
        if (h - 1800).abs() > 290 {
            ends += 1;
        }
        let line = (v + 120 + 60).div_euclid(120) * 120 - 120;
        if (v - line).abs() <= 3 && lines.last() != Some(&line) {
            lines.push(line);
        }
    });
    assert!((1500 - 5..=1503).contains(&right) && (2097..=2105).contains(&left), "{right} {left}");
    assert!((-245..=-237).contains(&bottom) && (-3..=5).contains(&top), "{bottom} {top}");
    assert!(lines.len() > 10 && ends > 100, "{lines:?}");
    assert!(lines.windows(2).all(|pair| (pair[0] - pair[1]).abs() == 120), "{lines:?}");
    assert!([-240, -120, 0].iter().all(|line| lines.contains(line)));
    assert_eq!(control.flags(), F::QUENCH);
}

/// §3.14/1 Step 0 aims at the centre; §3.2/4 Stop ends it.
#[test]
fn aims_at_the_centre() {
    let (mut bench, mut control) = started(&full(Sector { nozzle: 30, step: 0, ..SECTOR }, 0));
    run(&mut bench, &mut control, 15_000);
    assert_near(bench.aim(), (1800, -120));
    assert_eq!(bench.at(Axis::Nozzle), 30);
    control.stop();
    assert!(!control.is_active() && control.flags().is_empty());
    bench.move_to(Axis::Horizontal, 0);
    run(&mut bench, &mut control, 15_000);
    assert_near(bench.aim(), (0, -120));
}

/// §3.14/3 Raised so that the jet comes down at the distance.
#[test]
fn corrects_for_the_distance() {
    let (mut bench, mut control) = started(&full(POINT, 25));
    run(&mut bench, &mut control, 15_000);
    let expected = elevation(-120, 25, 60);
    assert!((150..350).contains(&expected), "{expected}");
    assert_near(bench.aim(), (1800, expected));
    // The pumps weaken: higher.
    bench.pressure_datm = Some(60);
    run(&mut bench, &mut control, 5000);
    assert!(bench.at(Axis::Vertical) > expected + 30, "{}", bench.at(Axis::Vertical));
    assert_eq!(control.flags(), F::QUENCH);
}

/// §3.3.6/4, §3.3.6/5 No water yet: straight and narrow; with water the flag goes at once.
#[test]
fn waits_for_pressure() {
    let (mut bench, mut control) = started(&full(Sector { nozzle: 55, ..POINT }, 15));
    bench.pressure_datm = Some(0);
    run(&mut bench, &mut control, 15_000);
    assert_eq!(control.flags(), F::QUENCH | F::TRAJECTORY_PRESSURE_FAULT);
    assert_near(bench.aim(), (1800, -120));
    assert_eq!(bench.at(Axis::Nozzle), 60);
    bench.pressure_datm = Some(79);
    run(&mut bench, &mut control, CYCLE_MS);
    assert_eq!(control.flags(), F::QUENCH);
    run(&mut bench, &mut control, 5000);
    assert_near(bench.aim(), (1800, elevation(-120, 15, 55)));
    assert_eq!(bench.at(Axis::Nozzle), 55);
    bench.pressure_datm = None;
    run(&mut bench, &mut control, 5000);
    assert_eq!(control.flags(), F::QUENCH | F::TRAJECTORY_PRESSURE_FAULT);
    assert_near(bench.aim(), (1800, -120));
    control.stop();
    assert!(control.flags().is_empty());
}

/// §3.3.6/4 While the pressure rises, what is too far yet is reported as a pressure that does not suit.
#[test]
fn rising_pressure_sticks_no_flag() {
    let (mut bench, mut control) = started(&full(POINT, 25));
    for datm in (0..80).chain([79; 40]) {
        bench.pressure_datm = Some(datm);
        run(&mut bench, &mut control, 100);
        assert!(!control.flags().contains(F::TRAJECTORY_RANGE_FAULT), "{datm}");
    }
    assert_eq!(control.flags(), F::QUENCH);
    run(&mut bench, &mut control, 5000);
    assert_near(bench.aim(), (1800, elevation(-120, 25, 60)));
}

/// §3.3.6/4, §3.3.6/5 Too far, and too steep for the limit: the flags stay until the next start.
#[test]
fn too_far_and_too_steep() {
    let (mut bench, mut control) = started(&full(Sector { nozzle: 50, ..POINT }, 60));
    run(&mut bench, &mut control, 15_000);
    assert_eq!(control.flags(), F::QUENCH | F::TRAJECTORY_RANGE_FAULT);
    assert_near(bench.aim(), (1800, -120));
    assert_eq!(bench.at(Axis::Nozzle), 60);
    control.stop();
    assert_eq!(control.flags(), F::TRAJECTORY_RANGE_FAULT);
    bench.params.write(Param::VerticalMaxLimit, one(&120));
    assert_eq!(quench(&mut bench, &mut control, &full(POINT, 25)), Status::ACCEPTED);
    assert_eq!(control.flags(), F::QUENCH);
    run(&mut bench, &mut control, 15_000);
    assert_eq!(control.flags(), F::QUENCH | F::TRAJECTORY_ANGLE_FAULT);
    assert_near(bench.aim(), (1800, -120));
}

/// §3.3.6/4 The same of an elevation that only the rising pressure needs: no AngleFault sticks.
#[test]
fn rising_pressure_sticks_no_angle() {
    let (mut bench, mut control) = (Bench::new(), Control::default());
    bench.params.write(Param::VerticalMaxLimit, one(&elevation(-120, 25, 60)));
    bench.pressure_datm = Some(20);
    run(&mut bench, &mut control, 1000);
    assert_eq!(quench(&mut bench, &mut control, &full(POINT, 25)), Status::ACCEPTED);
    let mut told = 0;
    for datm in (20..80).chain([79; 40]) {
        bench.pressure_datm = Some(datm);
        run(&mut bench, &mut control, 100);
        let flags = control.flags();
        assert!(!flags.contains(F::TRAJECTORY_ANGLE_FAULT), "{datm}");
        told += u32::from(flags.contains(F::TRAJECTORY_PRESSURE_FAULT));
    }
    assert!(told > 10, "{told}");
    // The limit itself is in reach.
    assert_eq!(control.flags(), F::QUENCH);
    run(&mut bench, &mut control, 5000);
    assert_near(bench.aim(), (1800, elevation(-120, 25, 60)));
}

/// §3.3.6/4 A pressure that has stood since before the start need not settle again: what is too far
/// is reported as that at once.
#[test]
fn steady_pressure_is_known_at_the_start() {
    let (mut bench, mut control) = (Bench::new(), Control::default());
    run(&mut bench, &mut control, 3000);
    assert_eq!(quench(&mut bench, &mut control, &full(POINT, 60)), Status::ACCEPTED);
    for _ in 0..100 {
        run(&mut bench, &mut control, CYCLE_MS);
        assert!(!control.flags().contains(F::TRAJECTORY_PRESSURE_FAULT));
    }
    assert_eq!(control.flags(), F::QUENCH | F::TRAJECTORY_RANGE_FAULT);
}

/// §3.3.6/2, §3.3.6/5 Ballistics off: straight and narrow, none of their flags.
#[test]
fn ballistics_off() {
    for distance in [60, 25] {
        let (mut bench, mut control) = (Bench::new(), Control::default());
        bench.params = damaged_params();
        bench.params.write(Param::ControlBallistics, one(&0));
        let request = full(Sector { nozzle: 40, ..POINT }, distance);
        assert_eq!(quench(&mut bench, &mut control, &request), Status::ACCEPTED);
        bench.pressure_datm = Some(0);
        run(&mut bench, &mut control, 15_000);
        assert_eq!(control.flags(), F::QUENCH);
        assert_near(bench.aim(), (1800, -120));
        assert_eq!(bench.at(Axis::Nozzle), 60);
    }
}

/// §3.14/3 The entry at the pressure; beyond the last, the last.
#[test]
fn corrects_by_the_table_given() {
    let corrections: Vec<u8> = (0..80).map(|datm| if datm < 50 { 0 } else { datm / 10 }).collect();
    let request = Quench::Corrected { sector: POINT, corrections: Bytes(&corrections) };
    let (mut bench, mut control) = started(&request);
    for (datm, degrees) in [(79, 7), (62, 6), (200, 7), (10, 0)] {
        bench.pressure_datm = Some(datm);
        run(&mut bench, &mut control, 12_000);
        assert_near(bench.aim(), (1800, -120 + degrees * 60));
        assert_eq!(control.flags(), F::QUENCH);
    }
}

/// §3.6/1, §3.6/3 The stored table holds where no distance is given; damage is reported.
#[test]
fn corrects_by_the_stored_table() {
    let (mut bench, mut control) = started(&full(POINT, 0));
    bench.params.set_corrections(79, Bytes(&[4, 4, -2_i8 as u8]));
    run(&mut bench, &mut control, 12_000);
    assert_near(bench.aim(), (1800, 120));
    bench.pressure_datm = Some(81);
    run(&mut bench, &mut control, 5000);
    assert_near(bench.aim(), (1800, -240));
    assert_eq!(control.flags(), F::QUENCH);
    // Without a sensor there is no correction, and no fault of ballistics that were not requested.
    bench.pressure_datm = None;
    run(&mut bench, &mut control, 5000);
    assert_near(bench.aim(), (1800, -120));
    assert_eq!(control.flags(), F::QUENCH);
    bench.params = damaged_params();
    assert_eq!(quench(&mut bench, &mut control, &full(POINT, 0)), Status::ACCEPTED);
    bench.pressure_datm = Some(80);
    run(&mut bench, &mut control, 5000);
    assert_eq!(control.flags(), F::QUENCH | F::TRAJECTORY_CRC_FAULT);
    assert_near(bench.aim(), (1800, -120));
}

/// §3.14/2 A stored program with another centre and nozzle; one never set is a direct aim.
#[test]
fn stored_programs() {
    let (mut bench, mut control) = (Bench::new(), Control::default());
    bench.params.write(Param::ControlProgram3, Ints::Values(&[9, 9, 9, 400, 0, 5, 20]));
    let program = |program| Quench::Program { program, centre_h: 600, centre_v: 60, nozzle: 60 };
    assert_eq!(quench(&mut bench, &mut control, &program(3)), Status::ACCEPTED);
    run(&mut bench, &mut control, 10_000);
    let (mut right, mut left) = (i32::MAX, i32::MIN);
    watch(&mut bench, &mut control, 10_000, |bench, _| {
        let (h, v) = bench.aim();
        (right, left) = (right.min(h), left.max(h));
        assert!((v - elevation(60, 20, 60)).abs() <= 3);
    });
    assert!((395..=403).contains(&right) && (797..=805).contains(&left), "{right} {left}");
    assert_eq!(quench(&mut bench, &mut control, &program(7)), Status::ACCEPTED);
    run(&mut bench, &mut control, 10_000);
    assert_near(bench.aim(), (600, 60));
    for number in [-1, 8, i16::MAX] {
        assert_eq!(quench(&mut bench, &mut control, &program(number)), Status::INVALID_VALUE);
    }
    assert!(control.is_active());
}

/// §3.14/4, §3.14/8 What is refused, and that a refusal leaves a program alone.
#[test]
fn values() {
    let (mut bench, mut control) = (Bench::new(), Control::default());
    for sector in [
        Sector { width: -1, ..SECTOR },
        Sector { height: -1, ..SECTOR },
        Sector { step: -1, ..SECTOR },
    ] {
        assert_eq!(quench(&mut bench, &mut control, &full(sector, 0)), Status::INVALID_VALUE);
    }
    assert_eq!(quench(&mut bench, &mut control, &full(SECTOR, -1)), Status::INVALID_VALUE);
    assert!(control.flags().is_empty());
    let outside = full(Sector { centre_v: 6000, ..SECTOR }, 0);
    assert_eq!(quench(&mut bench, &mut control, &outside), Status::INVALID_VALUE);
    assert_eq!(control.flags(), F::OUTSIDE_LIMITS | F::MODE_FAULT);
    assert_eq!(quench(&mut bench, &mut control, &full(SECTOR, 0)), Status::ACCEPTED);
    assert_eq!(quench(&mut bench, &mut control, &outside), Status::INVALID_VALUE);
    assert_eq!(control.flags(), F::QUENCH);
    bench.inputs.drives[0].motor_open = true;
    run(&mut bench, &mut control, 5 * CYCLE_MS);
    assert_eq!(quench(&mut bench, &mut control, &full(SECTOR, 0)), Status::MODULE_FAULT);
}

/// §3.14/8 Partly outside: OutsideLimits, and on inside.
#[test]
fn clipped_sector() {
    let request = full(Sector { centre_h: 10_700, nozzle: 1000, ..SECTOR }, 0);
    let (mut bench, mut control) = started(&request);
    assert_eq!(control.flags(), F::QUENCH | F::OUTSIDE_LIMITS);
    let (mut right, mut left) = (i32::MAX, i32::MIN);
    run(&mut bench, &mut control, 20_000);
    watch(&mut bench, &mut control, 20_000, |bench, _| {
        (right, left) =
            (right.min(bench.at(Axis::Horizontal)), left.max(bench.at(Axis::Horizontal)));
    });
    assert!((10_395..=10_403).contains(&right), "{right}");
    assert!((10_797..=10_801).contains(&left), "{left}");
    assert_eq!(bench.at(Axis::Nozzle), 60);
}

/// §3.14/5, §3.14/10 Deploys first; a deployment that fails ends it.
#[test]
fn deploys_first() {
    let (mut bench, mut control) = (Bench::new(), Control::default());
    bench.deployed = false;
    assert_eq!(quench(&mut bench, &mut control, &full(POINT, 0)), Status::ACCEPTED);
    run(&mut bench, &mut control, 8000);
    assert_eq!((control.flags(), bench.aim()), (F::QUENCH, (0, 0)));
    control.note_manual(bench.now);
    assert_eq!(control.flags(), F::QUENCH);
    bench.deployed = true;
    run(&mut bench, &mut control, 15_000);
    assert_near(bench.aim(), (1800, -120));
    bench.deployed = false;
    run(&mut bench, &mut control, CYCLE_MS);
    assert_eq!(control.flags(), F::MODE_FAULT);
    assert_eq!(quench(&mut bench, &mut control, &full(POINT, 0)), Status::ACCEPTED);
    assert_eq!(control.flags(), F::QUENCH);
    bench.deploy_failed = true;
    run(&mut bench, &mut control, CYCLE_MS);
    assert_eq!(control.flags(), F::MODE_FAULT);
}

/// §3.1/3 Move pauses; 3 s after the last one it goes on around the point reached.
#[test]
fn pauses_for_the_operator() {
    let (mut bench, mut control) = started(&full(Sector { height: 0, ..SECTOR }, 25));
    run(&mut bench, &mut control, 20_000);
    let raised = bench.at(Axis::Vertical) + 120;
    for (axis, to) in [(Axis::Horizontal, 600), (Axis::Nozzle, 45)] {
        bench.move_to(axis, to);
        control.note_manual(bench.now);
        assert_eq!(control.flags(), F::QUENCH | F::PAUSED);
        run(&mut bench, &mut control, 2500);
    }
    assert_eq!(control.flags(), F::QUENCH | F::PAUSED);
    assert!(bench.at(Axis::Horizontal) < 700 && bench.at(Axis::Nozzle) == 45);
    run(&mut bench, &mut control, 490);
    let before = bench.aim();
    assert_eq!(control.flags(), F::QUENCH | F::PAUSED);
    run(&mut bench, &mut control, 20);
    assert_eq!(control.flags(), F::QUENCH);
    let (mut right, mut left) = (i32::MAX, i32::MIN);
    watch(&mut bench, &mut control, 20_000, |bench, _| {
        (right, left) =
            (right.min(bench.at(Axis::Horizontal)), left.max(bench.at(Axis::Horizontal)));
    });
    assert_near((left, right), (before.0 + 300, before.0 - 300));
    assert_eq!(bench.at(Axis::Nozzle), 45);
    // Raised more, because the wider jet falls nearer; the line of sight has not been touched.
    assert!(bench.at(Axis::Vertical) > raised - 120 + 60, "{:?}", bench.aim());
}

/// §3.1/3 A raised barrel stays where the operator has put it.
#[test]
fn keeps_what_the_operator_raised() {
    let (mut bench, mut control) = started(&full(POINT, 25));
    run(&mut bench, &mut control, 15_000);
    let (h, v) = bench.aim();
    bench.move_to(Axis::Vertical, v + 300);
    control.note_manual(bench.now);
    run(&mut bench, &mut control, 10_000);
    assert_near(bench.aim(), (h, v + 300));
    assert_eq!(control.flags(), F::QUENCH);
}

/// §3.3.6/1 A drive fault ends it; limits off on a drive that then does not count, too.
#[test]
fn drive_faults() {
    let (mut bench, mut control) = started(&full(SECTOR, 0));
    run(&mut bench, &mut control, 12_000);
    bench.jammed[1] = true;
    run(&mut bench, &mut control, 15_000);
    assert_eq!(control.flags(), F::INTERNAL_FAULT);
    assert!(bench.drives.iter().all(Drive::is_idle));

    let (mut bench, mut control) = started(&full(SECTOR, 0));
    run(&mut bench, &mut control, 5000);
    let off = lafet_proto::request::LimitsState::Off;
    assert_eq!(bench.drives[1].switch_limits(off, &mut bench.params, BY), Status::OK);
    run(&mut bench, &mut control, CYCLE_MS);
    assert_eq!(control.flags(), F::MODE_FAULT);
    assert!(bench.drives.iter().all(Drive::is_idle));
    assert_eq!(quench(&mut bench, &mut control, &full(SECTOR, 0)), Status::DENIED);
}

/// §3.3.6/1 A fault that a drive reports of itself ends it as soon as it has lasted.
#[test]
fn drive_fault() {
    let (mut bench, mut control) = started(&full(SECTOR, 0));
    run(&mut bench, &mut control, 2000);
    bench.inputs.drives[1].motor_open = true;
    run(&mut bench, &mut control, 5 * CYCLE_MS);
    assert_eq!(control.flags(), F::INTERNAL_FAULT);
    assert!(bench.drives.iter().all(Drive::is_idle));
}

/// §3.14/9 A second one replaces the first.
#[test]
fn replaced() {
    let (mut bench, mut control) = started(&full(SECTOR, 0));
    run(&mut bench, &mut control, 5000);
    let request = full(Sector { centre_h: -600, ..POINT }, 0);
    assert_eq!(quench(&mut bench, &mut control, &request), Status::ACCEPTED);
    run(&mut bench, &mut control, 20_000);
    assert_near(bench.aim(), (-600, -120));
}

fn at(horizontal: i16, vertical: i16, distance: u8, dwell: u8) -> TrajectoryPoint {
    TrajectoryPoint { horizontal, vertical, distance, dwell }
}

fn trajectory(points: &[TrajectoryPoint], ballistics: bool, repeat: bool) -> Trajectory<'_> {
    Trajectory { ballistics, repeat, path: request::Path::Points(Points::Values(points)) }
}

/// §3.15/1 The points in order, each for its dwell; then the end.
#[test]
fn follows_a_trajectory() {
    let points = [at(300, 0, 0, 20), at(600, 300, 0, 0), at(0, 0, 0, 10)];
    let (mut bench, mut control) = (Bench::new(), Control::default());
    let request = trajectory(&points, false, false);
    assert_eq!(control.start_trajectory(&request, BY, &bench.env()), Status::ACCEPTED);
    assert_eq!(control.flags(), F::QUENCH | F::TRAJECTORY);
    let mut dwelt = [0; 3];
    watch(&mut bench, &mut control, 20_000, |bench, control| {
        for (dwelt, point) in dwelt.iter_mut().zip(&points) {
            let (h, v) = bench.aim();
            let there = (h - i32::from(point.horizontal)).abs() <= 3
                && (v - i32::from(point.vertical)).abs() <= 3;
            *dwelt += u32::from(there && control.is_active()) * CYCLE_MS;
        }
        // From the first point on the jet draws straight lines.
        let (h, v) = bench.aim();
        assert!(dwelt[0] < 2000 || dwelt[1] > 0 || (h - 300 - v).abs() < 30, "{h} {v}");
    });
    assert!((2000..2500).contains(&dwelt[0]), "{dwelt:?}");
    assert!((CYCLE_MS..500).contains(&dwelt[1]), "{dwelt:?}");
    assert!(dwelt[2] >= 1000, "{dwelt:?}");
    assert!(!control.is_active() && control.flags().is_empty());
}

/// §3.15/1 Repeat; §3.15/4 Move pauses and shifts it all.
#[test]
fn repeats_and_is_shifted() {
    let points = [at(0, 0, 0, 5), at(600, 0, 0, 5)];
    let (mut bench, mut control) = (Bench::new(), Control::default());
    let request = trajectory(&points, false, true);
    assert_eq!(control.start_trajectory(&request, BY, &bench.env()), Status::ACCEPTED);
    run(&mut bench, &mut control, 60_000);
    assert!(control.is_active());
    bench.move_to(Axis::Vertical, 240);
    control.note_manual(bench.now);
    run(&mut bench, &mut control, 4000);
    let (mut right, mut left) = (i32::MAX, i32::MIN);
    watch(&mut bench, &mut control, 20_000, |bench, _| {
        let (h, v) = bench.aim();
        (right, left) = (right.min(h), left.max(h));
        assert!((v - 240).abs() <= 3, "{v}");
    });
    assert_near((left, right), (600, 0));
}

/// §3.3.6/3, §3.3.6/5 Beyond the limits as far as possible; with ballistics each point its own
/// elevation; always the narrowest jet.
#[test]
fn trajectory_with_ballistics() {
    let points = [at(0, -60, 30, 50), at(0, -60, 90, 50), at(0, 5000, 0, 50)];
    let (mut bench, mut control) = (Bench::new(), Control::default());
    bench.drives[2].go(30, None, Cause::Request(BY));
    run(&mut bench, &mut control, 10_000);
    let request = trajectory(&points, true, false);
    assert_eq!(control.start_trajectory(&request, BY, &bench.env()), Status::ACCEPTED);
    run(&mut bench, &mut control, 5500);
    assert_near(bench.aim(), (0, elevation(-60, 30, 60)));
    assert_eq!((control.flags(), bench.at(Axis::Nozzle)), (F::QUENCH | F::TRAJECTORY, 60));
    run(&mut bench, &mut control, 6500);
    assert_near(bench.aim(), (0, -60));
    assert_eq!(control.flags(), F::QUENCH | F::TRAJECTORY | F::TRAJECTORY_RANGE_FAULT);
    run(&mut bench, &mut control, 60_000);
    assert_near(bench.aim(), (0, 4500));
    assert_eq!(control.flags(), F::TRAJECTORY_RANGE_FAULT | F::OUTSIDE_LIMITS);
}

/// §3.3.6/5 Ballistics not asked for, or off: straight, whatever the distance and the stored table.
#[test]
fn trajectory_without_ballistics() {
    for (asked, on, distance) in [(false, 1, 30), (false, 1, 0), (true, 0, 30), (true, 0, 0)] {
        let (mut bench, mut control) = (Bench::new(), Control::default());
        bench.params.set_corrections(79, Bytes(&[4]));
        bench.params.write(Param::ControlBallistics, one(&on));
        let points = [at(300, -60, distance, 100)];
        let request = trajectory(&points, asked, false);
        assert_eq!(control.start_trajectory(&request, BY, &bench.env()), Status::ACCEPTED);
        run(&mut bench, &mut control, 6000);
        assert_near(bench.aim(), (300, -60));
        assert_eq!(control.flags(), F::QUENCH | F::TRAJECTORY);
    }
}

/// §3.14/9, §3.15/1 A trajectory that replaces a program: nothing goes on while its aim is calculated;
/// points without a dwell are passed, one in a cycle.
#[test]
fn trajectory_replaces() {
    let (mut bench, mut control) = started(&full(SECTOR, 0));
    run(&mut bench, &mut control, 3000);
    assert!(!bench.drives[1].is_idle());
    let points = [at(300, -60, 30, 10)];
    let request = trajectory(&points, true, false);
    assert_eq!(control.start_trajectory(&request, BY, &bench.env()), Status::ACCEPTED);
    run(&mut bench, &mut control, CYCLE_MS);
    assert!(bench.drives.iter().all(Drive::is_idle));

    let (mut bench, mut control) = (Bench::new(), Control::default());
    let points = [at(0, 0, 0, 0); 20];
    let request = trajectory(&points, false, false);
    assert_eq!(control.start_trajectory(&request, BY, &bench.env()), Status::ACCEPTED);
    run(&mut bench, &mut control, 19 * CYCLE_MS);
    assert!(control.is_active());
    run(&mut bench, &mut control, 3 * CYCLE_MS);
    assert!(!control.is_active());
}

/// §3.14/1 The corner to begin with is the nearest to where the jet goes, not the raised barrel.
#[test]
fn begins_where_the_jet_is() {
    let mut bench = Bench::new();
    bench.move_to(Axis::Vertical, 300);
    let mut control = Control::default();
    run(&mut bench, &mut control, 10_000);
    let sector = Sector { centre_h: 0, centre_v: 0, ..SECTOR };
    let request = Quench::Corrected { sector, corrections: Bytes(&[7]) };
    assert_eq!(quench(&mut bench, &mut control, &request), Status::ACCEPTED);
    let mut highest = i32::MIN;
    // The lines lie 120' apart, the lowest at −120' + 7°, where the barrel is; a line takes 2 s.
    watch(&mut bench, &mut control, 2500, |bench, _| highest = highest.max(bench.aim().1));
    assert!((297..=310).contains(&highest), "{highest}");
    watch(&mut bench, &mut control, 30_000, |bench, _| highest = highest.max(bench.aim().1));
    assert!(highest > 530, "{highest}");
}

/// Only the bytes there are.
#[test]
fn data_shows_what_it_holds() {
    assert_eq!(std::format!("{:?}", Data::of([1, 2].into_iter())), "[1, 2]");
}

/// §3.15/2, §3.15/3 Stored ones by number.
#[test]
fn stored_trajectories() {
    let (mut bench, mut control) = (Bench::new(), Control::default());
    bench.params.write(Param::ControlTrajectory2, Ints::Values(&[480, 0, 0, 5, 240, 0, 0, 5]));
    let stored = |numbers| Trajectory {
        ballistics: false,
        repeat: false,
        path: request::Path::Stored(numbers),
    };
    for (numbers, status) in [
        (&[2, 8][..], Status::INVALID_VALUE),
        (&[2, 3], Status::INVALID_ID),
        (&[2, 2], Status::ACCEPTED),
    ] {
        assert_eq!(control.start_trajectory(&stored(numbers), BY, &bench.env()), status);
    }
    let mut visits: Vec<i32> = Vec::new();
    watch(&mut bench, &mut control, 30_000, |bench, _| {
        let h = bench.at(Axis::Horizontal);
        let point = if h > 360 { 480 } else { 240 };
        if (h - point).abs() <= 3 && visits.last() != Some(&point) && bench.drives[1].is_idle() {
            visits.push(point);
        }
    });
    assert_eq!(visits, [480, 240, 480, 240]);
    assert!(!control.is_active());
}

/// §3.1/3, §3.15/4 A correction by hand in the cycles in which the elevation for the next point is calculated
/// is a correction of the raised barrel as any other.
#[test]
fn corrected_between_two_points() {
    let points = [at(0, -60, 30, 5), at(0, -60, 30, 250)];
    let request = trajectory(&points, true, false);
    let raised = elevation(-60, 30, 60);
    for later in 0..80 {
        let (mut bench, mut control) = (Bench::new(), Control::default());
        assert_eq!(control.start_trajectory(&request, BY, &bench.env()), Status::ACCEPTED);
        while (bench.at(Axis::Vertical) - raised).abs() > 3 {
            run(&mut bench, &mut control, CYCLE_MS);
        }
        run(&mut bench, &mut control, later * CYCLE_MS);
        bench.move_to(Axis::Vertical, raised + 90);
        control.note_manual(bench.now);
        run(&mut bench, &mut control, 10_000);
        assert_near(bench.aim(), (0, raised + 90));
        assert_eq!(control.flags(), F::QUENCH | F::TRAJECTORY);
    }
}

/// §3.1/3, §3.14/9 The same of the first cycles of a program that has replaced another; after Stop nothing is
/// known of how the barrel was raised.
#[test]
fn corrected_as_the_next_program_begins() {
    for stopped in [false, true] {
        let (mut bench, mut control) = started(&full(POINT, 25));
        run(&mut bench, &mut control, 15_000);
        let (h, v) = bench.aim();
        if stopped {
            control.stop();
        }
        assert_eq!(quench(&mut bench, &mut control, &full(POINT, 25)), Status::ACCEPTED);
        bench.move_to(Axis::Vertical, v + 120);
        control.note_manual(bench.now);
        run(&mut bench, &mut control, 10_000);
        let raised = if stopped { v + 120 } else { 0 };
        assert_near(bench.aim(), (h, v + 120 + raised));
    }
}

/// §3.14/3, §3.6/1 Noise of one count at a step of a table, stored or given, does not make the barrel nod; a
/// table that is replaced counts at once.
#[test]
fn noise_at_a_step_of_the_table() {
    let corrections: Vec<u8> = (0..=81).map(|datm| if datm < 80 { 5 } else { 3 }).collect();
    let given = Quench::Corrected { sector: POINT, corrections: Bytes(&corrections) };
    for request in [full(POINT, 0), given] {
        let (mut bench, mut control) = started(&request);
        bench.params.set_corrections(79, Bytes(&[5, 3, 3]));
        run(&mut bench, &mut control, 12_000);
        assert_near(bench.aim(), (1800, 180));
        for ms in (0..20_000).step_by(CYCLE_MS as usize) {
            bench.pressure_datm = Some(if ms / 700 % 2 == 0 { 80 } else { 79 });
            run(&mut bench, &mut control, CYCLE_MS);
            assert_near(bench.aim(), (1800, 180));
        }
        bench.pressure_datm = Some(81);
        run(&mut bench, &mut control, 5000);
        assert_near(bench.aim(), (1800, 60));
    }
    let (mut bench, mut control) = started(&full(POINT, 0));
    run(&mut bench, &mut control, 12_000);
    bench.params.set_corrections(79, Bytes(&[2]));
    run(&mut bench, &mut control, 5000);
    assert_near(bench.aim(), (1800, 0));
}
