//! §3.1/3 Who has the drives when a program, a search or an alignment starts while a Move runs.

use crate::common::Rig;
use lafet_device::Composition;
use lafet_device::cause::{Asked, Cause};
use lafet_device::image::Axis;
use lafet_proto::flags::{ButtonState, ControlFlags, DetectorFlags, DriveFlags};
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Path, Points, Quench, Sector, Seek, Trajectory};
use lafet_proto::{RequestId, Status, SubsystemId};

const CONTROL: SubsystemId = SubsystemId::CONTROL;
const DETECTOR: SubsystemId = SubsystemId::DETECTOR;
const AIMING: [Axis; 3] = [Axis::Vertical, Axis::Horizontal, Axis::Nozzle];

fn quench(centre_h: i16, centre_v: i16) -> Body<'static> {
    let sector = Sector { centre_h, centre_v, nozzle: 30, width: 0, height: 0, step: 0 };
    Body::StartQuench(Quench::Full { sector, distance: 0 })
}

fn seek() -> Body<'static> {
    Body::StartSeek(Seek { start_h: -900, end_h: 900, start_v: 0, end_v: 600, analyse: 0 })
}

fn control(rig: &mut Rig) -> ControlFlags {
    ControlFlags::from_bits_retain(rig.flags(CONTROL))
}

/// Whether its output is that of a Move.
fn is_moved(rig: &Rig, axis: Axis) -> bool {
    let cause = rig.device.causes().drives[axis as usize];
    matches!(cause, Cause::Request(Asked { request: RequestId::MOVE, .. }))
}

/// A monitor that looks at 600', 600', its nozzle at 30 mm.
fn aimed() -> Rig {
    let mut rig = Rig::deployed();
    for (axis, position) in [(Axis::Vertical, 600), (Axis::Horizontal, 600), (Axis::Nozzle, 30)] {
        rig.plant.place(axis, position);
    }
    rig.pause();
    rig.run(20);
    rig
}

/// The vertical drive has been overloaded on its way up, and goes down by a Move.
fn overloaded_upwards() -> Rig {
    let mut rig = aimed();
    rig.plant.drive(Axis::Vertical).current_da = 81;
    rig.move_to(Axis::Vertical, 3000);
    let overload = DriveFlags::AMPERAGE_OVERLOAD;
    rig.run_until(1000, |rig| rig.drive_flags(Axis::Vertical).contains(overload));
    rig.plant.drive(Axis::Vertical).current_da = 20;
    rig.move_to(Axis::Vertical, -600);
    rig.run_until(500, |rig| rig.speed(Axis::Vertical) < 0);
    rig
}

/// §3.14/1, §3.15/1, §3.16/1, §3.13/1 A Move ends with the start that is accepted after it, on each of
/// the drives that aim: where the program is already, goes the other way or the same, and where
/// it has no use for the drive.
#[test]
fn a_move_ends_with_a_start() {
    let points = [0x58, 0x02, 0x58, 0x02, 0, 0];
    let trajectory = Body::StartTrajectory(Trajectory {
        ballistics: false,
        repeat: false,
        path: Path::Points(Points::Wire(&points)),
    });
    let starts = [
        (CONTROL, quench(600, 600)),
        (CONTROL, quench(1800, 1800)),
        (CONTROL, trajectory),
        (DETECTOR, seek()),
        (DETECTOR, Body::StartJustify),
    ];
    for (to, body) in &starts {
        for (axis, destination) in AIMING.into_iter().zip([4000, 10_000, 60]) {
            let mut rig = aimed();
            rig.move_to(axis, destination);
            rig.run(100);
            assert!(rig.speed(axis) > 0);
            rig.accepts(*to, *body);
            rig.step(10);
            assert_eq!(rig.speed(axis), 0, "{axis:?} {body:?}");
            for _ in 0..100 {
                assert!(!is_moved(&rig, axis), "{axis:?} {body:?}");
                rig.step(10);
            }
        }
    }
}

/// §3.3.4/1 The program's own way is refused after an overload: what goes the other way by a Move ends
/// all the same, the drive says what bars it, and the program goes on when that has cleared.
#[test]
fn a_start_against_an_overload() {
    let mut rig = overloaded_upwards();
    rig.accepts(CONTROL, quench(600, 1800));
    rig.step(10);
    assert!(rig.is_still());
    let overload = DriveFlags::AMPERAGE_OVERLOAD;
    let mut waited_ms = 0;
    while rig.drive_flags(Axis::Vertical).contains(overload) {
        rig.step(10);
        assert_eq!(rig.speed(Axis::Vertical), 0);
        assert_eq!(control(&mut rig), ControlFlags::QUENCH);
        waited_ms += 10;
    }
    assert!((1000..3000).contains(&waited_ms), "{waited_ms}");
    rig.run(20);
    assert!(rig.speed(Axis::Vertical) > 0);
    rig.run_until(20_000, |rig| (1797..=1803).contains(&rig.drive(Axis::Vertical).position));
    assert_eq!(control(&mut rig), ControlFlags::QUENCH);
}

/// §3.16/1 So does a search.
#[test]
fn a_search_against_an_overload() {
    let mut rig = overloaded_upwards();
    let (start_v, end_v) = (1500, 2100);
    let sector = Seek { start_h: 600, end_h: 900, start_v, end_v, analyse: 0 };
    rig.accepts(DETECTOR, Body::StartSeek(sector));
    rig.step(10);
    assert_eq!(rig.speed(Axis::Vertical), 0);
    let flags = |rig: &mut Rig| DetectorFlags::from_bits_retain(rig.flags(DETECTOR));
    rig.run_until(60_000, |rig| !flags(rig).contains(DetectorFlags::SEARCHING));
    assert_eq!(flags(&mut rig), DetectorFlags::empty());
    assert!(rig.drive(Axis::Vertical).position >= 1500);
}

/// §3.3.6/1 An end switch that bars the way for good: the Move ends, and the program says that it
/// gets nowhere.
#[test]
fn a_start_against_an_end_switch() {
    let mut rig = aimed();
    rig.plant.drive(Axis::Horizontal).switches = (i64::MIN, 0);
    rig.move_to(Axis::Horizontal, -3000);
    rig.run(500);
    assert!(rig.speed(Axis::Horizontal) < 0);
    rig.accepts(CONTROL, quench(1800, 600));
    rig.run_while(9_500, |rig| rig.speed(Axis::Horizontal) == 0);
    assert_eq!(control(&mut rig), ControlFlags::QUENCH);
    let at_end = DriveFlags::ABSOLUTE_MAX_LIMIT_REACHED;
    assert_eq!(rig.drive_flags(Axis::Horizontal), at_end);
    rig.run_while(1_000, |rig| rig.speed(Axis::Horizontal) == 0);
    assert_eq!(control(&mut rig), ControlFlags::INTERNAL_FAULT);
}

/// §3.14/3 While the elevation is still being calculated nothing goes on either.
#[test]
fn a_start_whose_aim_is_calculated() {
    let mut rig = aimed();
    assert!(rig.set(Param::ControlBallistics, 1).is_success());
    rig.plant.inputs.pressure_ua = 9000;
    rig.run(3000);
    rig.move_to(Axis::Horizontal, 5000);
    rig.run(100);
    let sector = Sector { centre_h: 600, centre_v: 0, nozzle: 30, width: 600, height: 0, step: 1 };
    rig.accepts(CONTROL, Body::StartQuench(Quench::Full { sector, distance: 20 }));
    rig.step(10);
    assert_eq!(rig.speed(Axis::Horizontal), 0);
    rig.run_while(2000, |rig| !is_moved(rig, Axis::Horizontal));
}

/// §3.14/8, §3.14/6 A start that is refused leaves the Move alone.
#[test]
fn a_refused_start_ends_no_move() {
    let mut rig = aimed();
    rig.move_to(Axis::Horizontal, 5000);
    rig.run(500);
    let outside = rig.status(CONTROL, quench(20_000, 0));
    assert_eq!(outside, Status::INVALID_VALUE);
    rig.run_while(500, |rig| rig.speed(Axis::Horizontal) > 0);
    // A direct drive without limits cannot be taken to a position.
    let off = Body::SwitchLimits { new_state: 0 };
    assert_eq!(rig.status(SubsystemId::VERTICAL, off), Status::OK);
    for (to, body) in [(CONTROL, quench(0, 0)), (DETECTOR, seek()), (DETECTOR, Body::StartJustify)]
    {
        assert_eq!(rig.status(to, body), Status::DENIED, "{body:?}");
        rig.run_while(100, |rig| rig.speed(Axis::Horizontal) > 0);
    }
    rig.run_until(20_000, |rig| rig.drive(Axis::Horizontal).position == 5000);
}

/// §3.3.10/1, §3.1/3 A button that is held keeps its drive: the program pauses and goes on 3 s after it
/// was released.
#[test]
fn a_held_button_keeps_its_drive() {
    let mut rig = aimed();
    rig.plant.inputs.buttons[0][0] = ButtonState::Pressed;
    rig.run(1000);
    assert!(rig.speed(Axis::Horizontal) > 0);
    rig.accepts(CONTROL, quench(-600, 600));
    rig.run_while(1000, |rig| rig.speed(Axis::Horizontal) > 0);
    assert_eq!(control(&mut rig), ControlFlags::QUENCH | ControlFlags::PAUSED);
    rig.plant.inputs.buttons[0][0] = ButtonState::Released;
    rig.run(20);
    rig.run_while(2_900, |rig| rig.is_still());
    rig.run_until(200, |rig| control(rig) == ControlFlags::QUENCH);
}

/// §3.5 Outside a limit that has been moved inward a Move and a program lead inward alike.
#[test]
fn a_start_outside_a_limit() {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.plant.place(Axis::Horizontal, 3000);
    rig.run(20);
    assert!(rig.set(Param::HorizontalMaxLimit, 1200).is_success());
    rig.move_to(Axis::Horizontal, 0);
    rig.run(500);
    assert!(rig.speed(Axis::Horizontal) < 0);
    rig.accepts(CONTROL, quench(1200, 0));
    rig.run_while(60_000, |rig| rig.speed(Axis::Horizontal) <= 0);
    assert!((1197..=1203).contains(&rig.drive(Axis::Horizontal).position));
    assert_eq!(control(&mut rig), ControlFlags::QUENCH);
}
