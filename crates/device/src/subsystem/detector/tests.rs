//! Searches and alignments on the bench: real drives, fires at known places.

use super::*;
use crate::image::Spot;
use crate::subsystem::control::bench::{BY, Bench, CYCLE_MS, one};
use crate::subsystem::drive::Drive;
use lafet_proto::flags::DetectorFlags as F;

const SEEK: Seek = Seek { start_h: 1800, end_h: -1800, start_v: 600, end_v: -600, analyse: 0 };

fn seek(bench: &mut Bench, detector: &mut Detector, seek: Seek) -> Status {
    detector.start_seek(&seek, BY, &bench.env())
}

fn run(bench: &mut Bench, detector: &mut Detector, ms: u32) {
    for _ in 0..ms / CYCLE_MS {
        bench.cycle();
        detector.step(bench.now, &mut bench.env());
    }
}

/// Until it is done; the time, ms.
fn finish(bench: &mut Bench, detector: &mut Detector) -> u32 {
    for cycle in 0..30_000 {
        if !detector.is_searching() && !detector.is_justifying() {
            return cycle * CYCLE_MS;
        }
        run(bench, detector, CYCLE_MS);
    }
    panic!("it never ends: {:?}", detector.state);
}

fn ready() -> (Bench, Detector) {
    (Bench::new(), Detector::default())
}

fn assert_at(hotbed: &Hotbed, h: i32, v: i32, within: i32) {
    let Direction { horizontal, vertical } = centre(hotbed);
    let near = (horizontal - h).abs() <= within && (vertical - v).abs() <= within;
    assert!(near, "{hotbed:?} is not at {h}' {v}'");
}

/// §3.16/1, §3.21/3 Finds what burns in the sector, and nothing else.
#[test]
fn finds_fires() {
    let (mut bench, mut detector) = ready();
    bench.fires = [(1500, -103, 100, 1400), (-900, 400, 60, 300)].to_vec();
    // Too dim, and out of the sector though in view from its edge.
    bench.fires.extend([(0, 0, 50, 49), (1900, 0, 50, 900)]);
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    assert_eq!(detector.flags(), F::SEARCHING);
    let ms = finish(&mut bench, &mut detector);
    assert!((10_000..40_000).contains(&ms), "{ms}");
    assert_eq!(detector.flags(), F::FOUND);
    let [first, second] = detector.hotbeds() else { panic!("{:?}", detector.hotbeds()) };
    assert_at(first, 1500, -103, 15);
    assert_at(second, -900, 400, 15);
    assert_eq!((first.brightness, second.brightness), (1400, 300));
    bench.fires.clear();
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    assert!(detector.hotbeds().is_empty());
    finish(&mut bench, &mut detector);
    assert!(detector.flags().is_empty() && detector.hotbeds().is_empty());
    assert!(bench.drives.iter().all(Drive::is_idle));
}

/// §3.16/5 Four, the brightest first.
#[test]
fn four_brightest() {
    let (mut bench, mut detector) = ready();
    bench.fires = [(-1500, 100), (-900, 500), (-300, 300), (300, 600), (900, 200), (1500, 400)]
        .map(|(h, brightness)| (h, 0, 40, brightness))
        .to_vec();
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    finish(&mut bench, &mut detector);
    let found: std::vec::Vec<i32> = detector.hotbeds().iter().map(|h| h.brightness).collect();
    assert_eq!(found, [600, 500, 400, 300]);
}

/// §3.16/6 The second pass measures box and brightness; what has gone out meanwhile is no hotbed.
#[test]
fn analyses() {
    let (mut bench, mut detector) = ready();
    bench.misalignment = (60, -30);
    bench.params.set_justify(60, -30);
    bench.fires = [(1500, -103, 100, 1400), (-900, 400, 60, 300)].to_vec();
    assert_eq!(seek(&mut bench, &mut detector, Seek { analyse: 1, ..SEEK }), Status::ACCEPTED);
    while !matches!(detector.state, State::Measuring { .. }) {
        run(&mut bench, &mut detector, CYCLE_MS);
    }
    bench.fires[0].3 = 1300;
    bench.fires.truncate(1);
    finish(&mut bench, &mut detector);
    let exact = Hotbed { x1: 1600, x2: 1400, y1: -203, y2: -3, brightness: 1300 };
    assert_eq!(detector.hotbeds(), [exact]);
    assert_eq!(detector.flags(), F::FOUND);
    assert!((bench.aim().0 - (-900 - 60)).abs() <= 3, "{:?}", bench.aim());
}

/// §3.16/2, §3.16/6 Either way round; not wholly inside the limits it is refused.
#[test]
fn sectors() {
    let (mut bench, mut detector) = ready();
    for bad in [
        Seek { end_h: 10_801, ..SEEK },
        Seek { start_v: -901, ..SEEK },
        Seek { start_h: 12_000, end_h: 11_000, ..SEEK },
    ] {
        assert_eq!(seek(&mut bench, &mut detector, bad), Status::INVALID_VALUE);
        assert_eq!(detector.flags(), F::BAD_SECTOR);
    }
    for analyse in [-1, 2] {
        let status = seek(&mut bench, &mut detector, Seek { analyse, ..SEEK });
        assert_eq!(status, Status::INVALID_VALUE);
    }
    let turned = Seek { start_h: -1800, end_h: 1800, start_v: -600, end_v: 600, analyse: 0 };
    assert_eq!(seek(&mut bench, &mut detector, turned), Status::ACCEPTED);
    assert_eq!(detector.flags(), F::SEARCHING);
    let bad = Seek { end_h: 10_801, ..SEEK };
    assert_eq!(seek(&mut bench, &mut detector, bad), Status::INVALID_VALUE);
    assert_eq!(detector.flags(), F::SEARCHING);
    bench.fires = [(1750, 550, 40, 100)].to_vec();
    finish(&mut bench, &mut detector);
    assert_eq!(detector.flags(), F::FOUND);
}

/// §3.16/4 A new sector replaces the old; a point is a sector too.
#[test]
fn replaced() {
    let (mut bench, mut detector) = ready();
    bench.fires = [(1500, -103, 100, 1400)].to_vec();
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    run(&mut bench, &mut detector, 5000);
    let point = Seek { start_h: -600, end_h: -600, start_v: 0, end_v: 0, analyse: 0 };
    assert_eq!(seek(&mut bench, &mut detector, point), Status::ACCEPTED);
    finish(&mut bench, &mut detector);
    assert_eq!((detector.flags(), detector.hotbeds().len()), (F::empty(), 0));
    assert!((bench.aim().0 + 600).abs() <= 3, "{:?}", bench.aim());
}

/// §3.16/3, §3.16/7 Deploys first; a Stop, a deployment or a drive that fails: Canceled.
#[test]
fn canceled() {
    let (mut bench, mut detector) = ready();
    bench.deployed = false;
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    run(&mut bench, &mut detector, 8000);
    assert_eq!((detector.flags(), bench.aim()), (F::SEARCHING, (0, 0)));
    bench.deploy_failed = true;
    run(&mut bench, &mut detector, CYCLE_MS);
    assert_eq!(detector.flags(), F::CANCELED);
    (bench.deployed, bench.deploy_failed) = (true, false);
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    run(&mut bench, &mut detector, 2000);
    assert!(bench.aim() != (0, 0));
    detector.stop();
    assert_eq!(detector.flags(), F::CANCELED);
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    bench.jammed[1] = true;
    finish(&mut bench, &mut detector);
    assert_eq!(detector.flags(), F::CANCELED | F::INTERNAL_FAULT);
    assert!(bench.drives.iter().all(Drive::is_idle));
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::MODULE_FAULT);
}

/// §3.16/3, §3.16/7 It begins when the monitor is deployed, and ends with the working position, or when
/// a drive does not count its way any more.
#[test]
fn needs_the_working_position() {
    let (mut bench, mut detector) = ready();
    bench.deployed = false;
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    run(&mut bench, &mut detector, 1000);
    bench.deployed = true;
    run(&mut bench, &mut detector, 2000);
    assert!(bench.aim() != (0, 0));
    bench.deployed = false;
    run(&mut bench, &mut detector, CYCLE_MS);
    assert_eq!(detector.flags(), F::CANCELED);
    bench.deployed = true;
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    run(&mut bench, &mut detector, 2000);
    let off = lafet_proto::request::LimitsState::Off;
    assert_eq!(bench.drives[1].switch_limits(off, &mut bench.params, BY), Status::OK);
    run(&mut bench, &mut detector, CYCLE_MS);
    assert_eq!(detector.flags(), F::CANCELED);
    assert!(bench.drives.iter().all(Drive::is_idle));
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::DENIED);
}

/// §3.16/1 The barrel stays at each end of a line, so that what is seen only there is seen for certain.
#[test]
fn stays_at_the_ends() {
    let (mut bench, mut detector) = ready();
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    let (mut stays, mut stay) = (std::vec::Vec::new(), 0);
    let (mut right, mut left) = (0, 0);
    while detector.is_searching() {
        run(&mut bench, &mut detector, CYCLE_MS);
        (right, left) = (right.min(bench.aim().0), left.max(bench.aim().0));
        // It creeps the last 3'.
        if bench.drives.iter().all(|drive| drive.output().speed_tenths.abs() <= 2) {
            stay += CYCLE_MS;
        } else if stay > 0 {
            stays.push(core::mem::take(&mut stay));
        }
    }
    assert!(stays.len() >= 4, "{stays:?}");
    // The ends need not be looked straight at: a quarter of the field of view is enough.
    let end = 1800 - bench.params.get(Param::DetectorFieldOfView) / 4;
    assert!((left - end).abs() <= 3 && (right + end).abs() <= 3, "{right} {left}");
    // Without a stay it would creep for 180 ms; the first is the start.
    assert!(stays[1..].iter().all(|stay| (300..500).contains(stay)), "{stays:?}");
}

/// §3.3.7/1 A detector that does not answer; one picture that is missing ends nothing.
#[test]
fn device_fault() {
    let (mut bench, mut detector) = ready();
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    run(&mut bench, &mut detector, 1000);
    bench.inputs.detector.ready = false;
    run(&mut bench, &mut detector, 500);
    bench.inputs.detector.ready = true;
    bench.inputs.detector.dirty_lens = true;
    run(&mut bench, &mut detector, 1000);
    assert_eq!(detector.flags(), F::SEARCHING | F::DIRTY_LENS);
    bench.inputs.detector.ready = false;
    run(&mut bench, &mut detector, 1100);
    assert_eq!(detector.flags(), F::CANCELED | F::DEVICE_FAULT | F::DIRTY_LENS);
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::MODULE_FAULT);
    assert_eq!(detector.start_justify(BY, &bench.env()), Status::MODULE_FAULT);
    bench.inputs.detector.ready = true;
    run(&mut bench, &mut detector, CYCLE_MS);
    assert_eq!(detector.flags(), F::CANCELED | F::DIRTY_LENS);
}

/// §3.13/1 The angle between detector and barrel is measured and stored, whatever it was before.
#[test]
fn justifies() {
    let (mut bench, mut detector) = ready();
    bench.misalignment = (60, -30);
    bench.params.set_justify(-17, 5);
    bench.fires = [(0, 0, 30, 800)].to_vec();
    bench.move_to(Axis::Horizontal, 900);
    run(&mut bench, &mut detector, 5000);
    assert_eq!(detector.start_justify(BY, &bench.env()), Status::ACCEPTED);
    assert_eq!(detector.flags(), F::JUSTIFYING);
    run(&mut bench, &mut detector, 500);
    assert_eq!(detector.start_justify(BY, &bench.env()), Status::ACCEPTED);
    finish(&mut bench, &mut detector);
    assert_eq!(detector.flags(), F::JUSTIFIED);
    let found = justification(&bench.params);
    assert!((found.horizontal - 60).abs() <= 3 && (found.vertical + 30).abs() <= 3, "{found:?}");
}

/// §3.13/1 No source, several, one that moves: DeviceFault until the next start, the values kept.
#[test]
fn nothing_to_justify_by() {
    let scenes: [&[(i32, i32, i32, i32)]; 3] =
        [&[], &[(0, 0, 30, 800), (200, 0, 30, 100)], &[(0, 0, 30, 20)]];
    for fires in scenes {
        let (mut bench, mut detector) = ready();
        bench.params.set_justify(7, 8);
        bench.fires = fires.to_vec();
        assert_eq!(detector.start_justify(BY, &bench.env()), Status::ACCEPTED);
        finish(&mut bench, &mut detector);
        assert_eq!(detector.flags(), F::DEVICE_FAULT);
        assert_eq!(justification(&bench.params), Direction { horizontal: 7, vertical: 8 });
        assert_eq!(detector.start_justify(BY, &bench.env()), Status::ACCEPTED);
        assert_eq!(detector.flags(), F::JUSTIFYING);
        detector.stop();
        assert!(detector.flags().is_empty());
    }
    let (mut bench, mut detector) = ready();
    assert_eq!(detector.start_justify(BY, &bench.env()), Status::ACCEPTED);
    for shift in 0..300 {
        bench.fires = [(shift, 0, 30, 800)].to_vec();
        run(&mut bench, &mut detector, CYCLE_MS);
    }
    assert_eq!(detector.flags(), F::DEVICE_FAULT);
}

/// §3.13/1 The largest angle that can be stored is the largest that is measured; more is a DeviceFault.
#[test]
fn largest_angle() {
    for (left, up, fits) in [(-600, 600, true), (-601, 0, false), (0, 601, false)] {
        let (mut bench, mut detector) = ready();
        assert_eq!(detector.start_justify(BY, &bench.env()), Status::ACCEPTED);
        for _ in 0..300 {
            bench.cycle();
            bench.inputs.detector.spots[0] = Some(crate::image::Spot {
                left: left + 10,
                right: left - 10,
                bottom: up - 10,
                top: up + 10,
                brightness: 800,
            });
            detector.step(bench.now, &mut bench.env());
        }
        assert_eq!(detector.flags(), if fits { F::JUSTIFIED } else { F::DEVICE_FAULT });
        let found = justification(&bench.params);
        let expected = if fits { (600, -600) } else { (0, 0) };
        assert_eq!((found.horizontal, found.vertical), expected);
    }
}

/// A narrow field of view slows the search down, so that nothing is passed by.
#[test]
fn narrow_field() {
    let (mut bench, mut detector) = ready();
    bench.params.write(Param::DetectorFieldOfView, one(&60));
    assert_eq!(scan_tenths(&bench.params), 10);
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    run(&mut bench, &mut detector, 20_000);
    let speed = bench.drives[1].output().speed_tenths.abs();
    assert!((9..=10).contains(&speed), "{speed}");
}

/// §D/6 What a detector shows that is not ready is an old picture: nothing is found in it.
#[test]
fn an_old_picture() {
    let (mut bench, mut detector) = ready();
    assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
    run(&mut bench, &mut detector, 2000);
    for cycle in 0..400 {
        bench.cycle();
        bench.inputs.detector.ready = cycle % 100 < 80;
        if !bench.inputs.detector.ready {
            let old = Spot { left: 60, right: -60, bottom: -60, top: 60, brightness: 900 };
            bench.inputs.detector.spots[0] = Some(old);
        }
        detector.step(bench.now, &mut bench.env());
    }
    assert_eq!(detector.flags() - F::DEVICE_FAULT, F::SEARCHING);
    assert!(detector.hotbeds().is_empty(), "{:?}", detector.hotbeds());
    bench.inputs.detector.ready = true;
    finish(&mut bench, &mut detector);
    assert!(detector.flags().is_empty());
}

/// §D/6, §3.16/1 A detector that comes and goes loses nothing without a word: what burns is found as by one that stays, or the
/// search is canceled, which keeps what was found. The barrel is at rest meanwhile.
#[test]
fn it_comes_and_goes() {
    let fires = [(1500, -103, 100, 1400), (-900, 400, 60, 300), (-1700, -500, 60, 200)];
    let search = |gone_ms: u32, every_ms: u32, analyse| {
        let (mut bench, mut detector) = ready();
        bench.fires = fires.to_vec();
        assert_eq!(seek(&mut bench, &mut detector, Seek { analyse, ..SEEK }), Status::ACCEPTED);
        let mut ms = 0;
        while detector.is_searching() {
            assert!(ms < 600_000, "{gone_ms} of {every_ms} ms: it never ends");
            bench.inputs.detector.ready = ms % every_ms >= gone_ms;
            bench.cycle();
            detector.step(bench.now, &mut bench.env());
            let still = bench.drives.iter().all(|drive| drive.output().speed_tenths == 0);
            assert!(still || bench.inputs.detector.ready, "{gone_ms} of {every_ms} ms");
            ms += CYCLE_MS;
        }
        (detector.flags() - F::DEVICE_FAULT, detector.hotbeds().len())
    };
    for analyse in [0, 1] {
        assert_eq!(search(0, 1000, analyse), (F::FOUND, 3));
        for (gone_ms, every_ms) in [(10, 1000), (300, 1000), (500, 1700), (800, 2600), (900, 5000)]
        {
            assert_eq!(
                search(gone_ms, every_ms, analyse),
                (F::FOUND, 3),
                "{gone_ms} of {every_ms} ms"
            );
        }
        for (gone_ms, every_ms) in [(10, 20), (10, 40), (900, 1000), (600, 1000), (1010, 5000)] {
            let (flags, _) = search(gone_ms, every_ms, analyse);
            assert!(flags.contains(F::CANCELED), "{gone_ms} of {every_ms} ms: {flags:?}");
        }
    }
    // Canceled in the second pass, it still has what the first has found.
    let (mut bench, mut detector) = ready();
    bench.fires = fires.to_vec();
    assert_eq!(seek(&mut bench, &mut detector, Seek { analyse: 1, ..SEEK }), Status::ACCEPTED);
    while !matches!(detector.state, State::Measuring { .. }) {
        run(&mut bench, &mut detector, CYCLE_MS);
    }
    bench.inputs.detector.ready = false;
    run(&mut bench, &mut detector, 1100);
    assert_eq!(detector.flags(), F::FOUND | F::CANCELED | F::DEVICE_FAULT);
    assert_eq!(detector.hotbeds().len(), 3);
}

/// §3.16/6 Flames that show in a few pictures of the second pass alone are still there, as the first has found them.
#[test]
fn flames_that_flicker() {
    let (mut bench, mut detector) = ready();
    bench.fires = [(1500, -103, 100, 1400)].to_vec();
    assert_eq!(seek(&mut bench, &mut detector, Seek { analyse: 1, ..SEEK }), Status::ACCEPTED);
    while !matches!(detector.state, State::Measuring { .. }) {
        run(&mut bench, &mut detector, CYCLE_MS);
    }
    let found = detector.hotbeds().to_vec();
    let mut cycle = 0;
    while detector.is_searching() {
        bench.fires[0].3 = if cycle % 40 < 8 { 1400 } else { 0 };
        run(&mut bench, &mut detector, CYCLE_MS);
        cycle += 1;
    }
    assert_eq!((detector.hotbeds(), detector.flags()), (&found[..], F::FOUND));
}

/// §D/6 A part of the sector in which the picture was of light may burn: DeviceFault says so until the next start, and the
/// rest is searched. A moment of it is nothing.
#[test]
fn a_part_that_dazzles() {
    for (dazzled_ms, flags) in [(150, F::FOUND), (700, F::FOUND | F::DEVICE_FAULT)] {
        let (mut bench, mut detector) = ready();
        bench.fires = [(1500, -103, 100, 1400)].to_vec();
        assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
        run(&mut bench, &mut detector, 3000);
        for _ in 0..dazzled_ms / CYCLE_MS {
            bench.cycle();
            let light = Spot { left: 600, right: -600, bottom: -600, top: 600, brightness: 2000 };
            bench.inputs.detector.spots = [Some(light); SPOTS];
            detector.step(bench.now, &mut bench.env());
        }
        finish(&mut bench, &mut detector);
        assert_eq!(detector.flags(), flags, "{dazzled_ms}");
        assert_eq!(seek(&mut bench, &mut detector, SEEK), Status::ACCEPTED);
        assert_eq!(detector.flags(), F::SEARCHING);
    }
}
