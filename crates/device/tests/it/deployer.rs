//! Deployer: from standby to the working position, back, and everything in between.

use crate::common::{self, Plant, Rig};
use lafet_device::image::{Axis, ValveOutput};
use lafet_device::{Composition, Device};
use lafet_proto::flags::{ControlFlags, DeployerFlags as F, DetectorFlags, DriveFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Path, Points, Quench, Sector, Seek, Trajectory, TrajectoryPoint};
use lafet_proto::{Request, Status, SubsystemId};

pub const DEPLOYER: SubsystemId = SubsystemId::DEPLOYER;
const WHERE: F = F::DEPLOYED.union(F::DEPLOYING).union(F::WRAPPED).union(F::WRAPPING);

/// Which of the four flags is set.
pub fn position(rig: &mut Rig) -> F {
    rig.deployer() & WHERE
}

pub fn wrapped() -> Rig {
    let mut rig = Rig::new(Composition::FULL);
    assert_eq!(position(&mut rig), F::WRAPPED);
    rig
}

pub fn deploying() -> Rig {
    let mut rig = wrapped();
    assert_eq!(rig.status(DEPLOYER, Body::Deploy), Status::ACCEPTED);
    rig.run(2000);
    assert_eq!(position(&mut rig), F::DEPLOYING);
    rig
}

fn wrapping() -> Rig {
    let mut rig = Rig::deployed();
    assert_eq!(rig.status(DEPLOYER, Body::Wrap), Status::ACCEPTED);
    rig.run(2000);
    assert_eq!(position(&mut rig), F::WRAPPING);
    rig
}

fn between() -> Rig {
    let mut rig = deploying();
    assert_eq!(rig.status(DEPLOYER, Body::Stop), Status::OK);
    rig.run(100);
    assert_eq!(position(&mut rig), F::empty());
    rig
}

fn all() -> [Rig; 5] {
    [wrapped(), deploying(), Rig::deployed(), wrapping(), between()]
}

/// §3.1/1 What aims ends with the working position: it goes on neither as a fault nor later.
#[test]
fn an_aim_ends_when_the_barrel_is_folded() {
    let mut rig = Rig::deployed();
    rig.move_to(Axis::Horizontal, 21_600);
    rig.run(200);
    assert!(rig.speed(Axis::Horizontal) > 0);
    rig.plant.place(Axis::Deployer, 4000);
    rig.pause();
    rig.run(50);
    assert_eq!(position(&mut rig), F::empty());
    let flags = rig.drive_flags(Axis::Horizontal);
    assert!(!flags.intersects(DriveFlags::MOVE | DriveFlags::INTERNAL_FAULT), "{flags:?}");
    rig.run(1000);
    rig.deploy();
    rig.run_while(500, |rig| rig.speed(Axis::Horizontal) == 0);
    rig.move_to(Axis::Horizontal, 21_600);
    rig.run(200);
    assert!(rig.speed(Axis::Horizontal) > 0);
}

/// §3.10/1, §3.10/2, §3.11/1, §3.11/2, §3.3.8/1 From each position to each end; one flag at a time.
#[test]
fn every_transition() {
    for (body, there, on_the_way) in
        [(Body::Deploy, F::DEPLOYED, F::DEPLOYING), (Body::Wrap, F::WRAPPED, F::WRAPPING)]
    {
        for mut rig in all() {
            let from = position(&mut rig);
            let status = rig.status(DEPLOYER, body);
            if from == there {
                assert_eq!(status, Status::OK);
                rig.run_while(500, |rig| rig.is_still() && position(rig) == there);
                continue;
            }
            assert_eq!(status, Status::ACCEPTED);
            assert_eq!(position(&mut rig), on_the_way, "at once");
            rig.run_until(20_000, |rig| {
                assert!(position(rig).bits().count_ones() == 1);
                position(rig) == there
            });
            assert!(rig.is_still());
            rig.run_while(500, |rig| rig.is_still() && position(rig) == there);
            let end = if there == F::DEPLOYED { 5400 } else { 0 };
            assert!((rig.plant.position(Axis::Deployer) - end).abs() < 30);
            assert_eq!(rig.deployer() & F::INTERNAL_FAULT, F::empty());
        }
    }
}

/// §3.10/1, §1 The same request again and again, as from a bus that repeats it, does not hold it up.
#[test]
fn repeated_requests_do_no_harm() {
    for (mut rig, body, there) in
        [(wrapped(), Body::Deploy, F::DEPLOYED), (Rig::deployed(), Body::Wrap, F::WRAPPED)]
    {
        for _ in 0..100 {
            rig.accepts(DEPLOYER, body);
            rig.run(100);
        }
        assert_eq!(position(&mut rig), there);
    }
}

/// §D/1, §3.3.8/1 The sensors tell at power-up; in between it stays, and so it does when both switches
/// are on, which cannot be.
#[test]
fn power_up() {
    for (at, flag) in [(0, F::WRAPPED), (2700, F::empty()), (5400, F::DEPLOYED)] {
        let mut plant = Plant::of(&Composition::FULL);
        Device::provision(&mut plant, &Composition::FULL, 1).unwrap();
        plant.place(Axis::Deployer, at);
        let mut rig = Rig::power_up(Composition::FULL, plant, 0);
        // §D/6 The switches count when they have lasted.
        assert_eq!(position(&mut rig), F::empty());
        rig.run(30);
        rig.run_while(2000, |rig| rig.is_still() && position(rig) == flag);
    }
    let mut rig = wrapped();
    rig.plant.drive(Axis::Deployer).switches = (5400, 0);
    rig.power_cycle_and_settle();
    assert_eq!(position(&mut rig), F::empty());
    let (from, status) = rig.one(SubsystemId::VERTICAL, Body::Move { destination: 60 });
    assert_eq!((from, status), (DEPLOYER, Status::DENIED));
}

/// §3.1/1, §3.8/1 In no position but deployed may one aim or open; its state goes on. §3.9/6 Close
/// always.
#[test]
fn aiming_and_opening_are_denied() {
    for mut rig in all() {
        let from = position(&mut rig);
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            let (by, status) = rig.one(axis.id(), Body::Move { destination: 30 });
            let allowed = (axis.id(), Status::ACCEPTED);
            let denied = (DEPLOYER, Status::DENIED);
            assert_eq!((by, status), if from == F::DEPLOYED { allowed } else { denied });
        }
        if from != F::DEPLOYED {
            let (by, status) = rig.one(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
            assert_eq!((by, status), (DEPLOYER, Status::DENIED));
            let (by, status) = rig.one(SubsystemId::DETECTOR, Body::StartJustify);
            assert_eq!((by, status), (DEPLOYER, Status::DENIED));
            assert_eq!(position(&mut rig), from);
            rig.run_while(300, |rig| {
                let aiming = [Axis::Vertical, Axis::Horizontal, Axis::Nozzle];
                aiming.into_iter().all(|axis| rig.speed(axis) == 0)
                    && rig.valve_output(0) != ValveOutput::Opening
            });
            assert_eq!(position(&mut rig), from);
        }
        let close = rig.status(SubsystemId::VALVE1, Body::Close { key: key::CLOSE });
        assert_eq!(close, Status::ACCEPTED);
    }
}

/// §3.2/2, §3.2/1 On the way Stop is Denied to others; to Deployer, to All and to Motors it ends it in
/// between.
#[test]
fn stop_on_the_way() {
    for rig in [deploying(), wrapping()] {
        let mut other = rig.clone();
        for to in [SubsystemId::VERTICAL, SubsystemId::VALVE1, SubsystemId::CONTROL] {
            assert_eq!(other.one(to, Body::Stop), (DEPLOYER, Status::DENIED));
        }
        other.run(100);
        assert!(other.speed(Axis::Deployer) != 0);
        for to in [DEPLOYER, SubsystemId::ALL, SubsystemId::MOTORS] {
            let mut rig = rig.clone();
            let answers = rig.ask(to, Body::Stop);
            assert!(answers.iter().all(|answer| answer.status == Status::OK), "{answers:?}");
            rig.run_while(1000, |rig| rig.is_still() && position(rig) == F::empty());
        }
    }
}

/// §3.11/6 A valve that is not closed denies Wrap: open, opening, closing, its sensor faulty, or both
/// switches on.
#[test]
fn an_open_valve_denies_wrap() {
    let ways: [fn(&mut Rig); 5] = [
        |rig| rig.plant.valves[1].opening_ms = 4000,
        |rig| rig.accepts(SubsystemId::VALVE2, Body::Open { key: key::OPEN }),
        |rig| rig.plant.valves[1].opening_ms = 2000,
        |rig| rig.plant.inputs.valves[1].close_sensor_fault = true,
        |rig| rig.plant.valves[1].open_switch_dead = false,
    ];
    for (number, way) in ways.into_iter().enumerate() {
        let mut rig = Rig::deployed();
        way(&mut rig);
        rig.run(if number == 1 { 0 } else { 20 });
        let denied = rig.one(DEPLOYER, Body::Wrap);
        if number == 4 {
            assert_eq!(denied, (DEPLOYER, Status::ACCEPTED), "the witness");
            continue;
        }
        assert_eq!(denied, (SubsystemId::VALVE2, Status::DENIED), "{number}");
        rig.run_while(200, |rig| rig.speed(Axis::Deployer) == 0);
        assert_eq!(position(&mut rig), F::DEPLOYED);
    }
}

/// §3.11/1 A barrel that is turned aside goes to its rest first; then the unit folds.
#[test]
fn the_barrel_rests_before_it_folds() {
    let mut rig = Rig::deployed();
    rig.move_to(Axis::Horizontal, 3000);
    rig.move_to(Axis::Vertical, -600);
    rig.run(12_000);
    rig.accepts(DEPLOYER, Body::Wrap);
    while rig.plant.position(Axis::Horizontal) != 0 || rig.plant.position(Axis::Vertical) != 0 {
        rig.step(10);
        assert_eq!(rig.speed(Axis::Deployer), 0);
        assert_eq!(position(&mut rig), F::WRAPPING);
    }
    rig.run_until(20_000, |rig| position(rig) == F::WRAPPED);
    assert_eq!(rig.plant.position(Axis::Horizontal), 0);
}

/// §3.17/1, §3.11/1 Limits off do not send the barrel round and round on its way to rest.
#[test]
fn the_barrel_rests_with_limits_off() {
    let mut rig = Rig::deployed();
    rig.move_to(Axis::Horizontal, 3000);
    rig.run(12_000);
    rig.ask(SubsystemId::MOTORS, Body::SwitchLimits { new_state: 0 });
    rig.accepts(DEPLOYER, Body::Wrap);
    rig.run_until(20_000, |rig| {
        assert!(rig.plant.position(Axis::Horizontal) > -30);
        position(rig) == F::WRAPPED
    });
    assert_eq!(rig.plant.position(Axis::Horizontal), 0);
}

/// §3.11/1 Deploy while the barrel goes to its rest: it stays deployed.
#[test]
fn deploy_takes_the_rest_back() {
    let mut rig = Rig::deployed();
    rig.move_to(Axis::Horizontal, 3000);
    rig.run(12_000);
    rig.accepts(DEPLOYER, Body::Wrap);
    rig.run(500);
    assert!(rig.speed(Axis::Horizontal) < 0);
    rig.accepts(DEPLOYER, Body::Deploy);
    rig.run(50);
    assert_eq!(position(&mut rig), F::DEPLOYED);
    rig.run_while(500, |rig| rig.is_still());
}

/// §3.1/9 Move Deployer: a service motion, deployed or in between; it is in between then, and
/// Deploy and Wrap lead out of it.
#[test]
fn move_deployer() {
    for mut rig in all() {
        let from = position(&mut rig);
        let answer = rig.one(DEPLOYER, Body::Move { destination: 3000 });
        if from != F::DEPLOYED && from != F::empty() {
            assert_eq!(answer, (DEPLOYER, Status::DENIED));
            assert_eq!(position(&mut rig), from);
            continue;
        }
        assert_eq!(answer, (DEPLOYER, Status::ACCEPTED));
        rig.run_until(20_000, |rig| rig.drive(Axis::Deployer).position == 3000);
        rig.run_while(100, |rig| rig.is_still() && position(rig) == F::empty());
        rig.accepts(DEPLOYER, Body::Deploy);
        rig.run_until(20_000, |rig| position(rig) == F::DEPLOYED);
    }
    let mut rig = Rig::deployed();
    rig.plant.valves[0].opening_ms = 4000;
    rig.run(20);
    let answer = rig.one(DEPLOYER, Body::Move { destination: 3000 });
    assert_eq!(answer, (SubsystemId::VALVE1, Status::DENIED));
}

/// §3.1/9, §3.11/1 Once it has left its working position turned aside, the barrel is not folded: neither by
/// Wrap, nor by Move Deployer in one go or in two; nor while it turns. Deploy leads out of it.
#[test]
fn a_barrel_turned_aside_is_not_folded() {
    let fold = Body::Move { destination: -32_767 };
    let nothing_folds = |rig: &mut Rig, body: Body<'_>| {
        assert_eq!(rig.one(DEPLOYER, body), (DEPLOYER, Status::DENIED), "{body:?}");
        rig.run_while(300, |rig| rig.speed(Axis::Deployer) >= 0);
    };
    for (axis, aside, folds) in [
        (Axis::Horizontal, 5400, false),
        (Axis::Vertical, -300, false),
        (Axis::Horizontal, 31, false),
        (Axis::Horizontal, -30, true),
        (Axis::Nozzle, 40, true),
    ] {
        let mut rig = Rig::deployed();
        rig.plant.place(axis, aside);
        rig.pause();
        rig.run(500);
        let mut wrapped = rig.clone();
        if folds {
            rig.accepts(DEPLOYER, fold);
            rig.run(500);
            assert!(rig.speed(Axis::Deployer) < 0, "{axis:?} {aside}");
            continue;
        }
        nothing_folds(&mut rig, fold);
        nothing_folds(&mut rig, Body::Move { destination: 5000 });
        // Its switch is lost: the sensor still says where the barrel is.
        rig.plant.drive(Axis::Deployer).switches = (0, 9000);
        rig.run(100);
        assert_eq!(position(&mut rig), F::empty());
        nothing_folds(&mut rig, Body::Wrap);
        nothing_folds(&mut rig, fold);
        rig.accepts(DEPLOYER, Body::Deploy);
        nothing_folds(&mut rig, Body::Wrap);
        // With the switch it goes to its rest first.
        wrapped.accepts(DEPLOYER, Body::Wrap);
        wrapped.run_until(40_000, |rig| position(rig) == F::WRAPPED);
        assert_eq!(wrapped.plant.position(axis), 0);
    }
    // Where the sensor cannot be believed, what it says is no rest.
    for lie in [0, 1] {
        let mut rig = between();
        if lie == 1 {
            rig.plant.inputs.drives[Axis::Vertical as usize].position_sensor_fault = true;
        } else {
            rig.plant.drive(Axis::Horizontal).runaway_tenths = 40;
        }
        rig.run(50);
        nothing_folds(&mut rig, Body::Wrap);
        nothing_folds(&mut rig, fold);
    }
    let mut rig = Rig::deployed();
    rig.plant.inputs.drives[Axis::Vertical as usize].position_sensor_fault = true;
    rig.run(50);
    rig.accepts(DEPLOYER, Body::Wrap);
    rig.run_while(300, |rig| rig.speed(Axis::Deployer) == 0);
    assert_eq!(position(&mut rig), F::DEPLOYED);
}

/// §3.3.8, §D/3 Too long: it stops in between with InternalFault, whatever the clock does.
#[test]
fn time_over() {
    for now_ms in [0, u32::MAX - 2000] {
        for body in [Body::Deploy, Body::Wrap] {
            let mut rig = Rig::at(Composition::FULL, now_ms);
            if matches!(body, Body::Wrap) {
                rig.plant.place(Axis::Deployer, 5400);
                rig.pause();
                rig.run(100);
            }
            rig.set(Param::DeployerTravelTime, 3000);
            rig.accepts(DEPLOYER, body);
            rig.run(2900);
            assert!(rig.speed(Axis::Deployer) != 0);
            rig.run(200);
            assert_eq!(rig.deployer() & (WHERE | F::INTERNAL_FAULT), F::INTERNAL_FAULT);
            rig.run_while(1000, |rig| rig.is_still());
            assert_eq!(rig.status(DEPLOYER, Body::Deploy), Status::MODULE_FAULT);
            assert_eq!(rig.status(DEPLOYER, Body::Wrap), Status::MODULE_FAULT);
        }
    }
}

/// §3.10/3, §3.11/3 A faulty drive: ModuleFault, nothing moves; on the way it ends in between.
#[test]
fn faulty() {
    for mut rig in all() {
        let from = position(&mut rig);
        rig.plant.inputs.drives[Axis::Deployer as usize].motor_open = true;
        rig.run(50);
        assert!(rig.is_still());
        for body in [Body::Deploy, Body::Wrap] {
            assert_eq!(rig.status(DEPLOYER, body), Status::MODULE_FAULT);
        }
        rig.run_while(200, |rig| rig.is_still());
        let moving = [F::DEPLOYING, F::WRAPPING].contains(&from);
        assert_eq!(position(&mut rig), if moving { F::empty() } else { from });
        assert!(rig.drive_flags(Axis::Deployer).contains(DriveFlags::MOTOR_BROKEN));
        // Fixed, it works again.
        rig.plant.inputs.drives[Axis::Deployer as usize].motor_open = false;
        rig.run(20);
        rig.accepts(DEPLOYER, Body::Deploy);
        rig.run_until(20_000, |rig| position(rig) == F::DEPLOYED);
    }
}

/// §3.3.8 An end switch that sticks at the other end is not believed: it does not count as arrived.
#[test]
fn a_switch_that_sticks() {
    let mut rig = wrapped();
    rig.set(Param::DeployerTravelTime, 9000);
    // The lower switch stays closed all the way.
    rig.plant.drive(Axis::Deployer).switches.0 = 6000;
    rig.run(20);
    rig.accepts(DEPLOYER, Body::Deploy);
    rig.run_while(12_000, |rig| position(rig) != F::DEPLOYED);
    assert!(rig.is_still());
    assert_eq!(position(&mut rig), F::empty());
}

/// §D/5 The working position is lost by itself: the monitor says so, and neither aims nor opens.
#[test]
fn pushed_out_of_position() {
    let mut rig = Rig::deployed();
    rig.move_to(Axis::Horizontal, 9000);
    rig.run(500);
    rig.plant.place(Axis::Deployer, 5000);
    rig.run(50);
    assert_eq!(position(&mut rig), F::empty());
    assert_eq!(rig.speed(Axis::Horizontal), 0);
    let answer = rig.one(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    assert_eq!(answer, (DEPLOYER, Status::DENIED));
}

/// §3.3.5, §3.8/1 A valve whose opening ends because the working position is lost is not a broken
/// valve; it does not open by itself when the position is back, but when it is asked to.
#[test]
fn an_opening_ends_without_a_fault() {
    let mut rig = Rig::deployed();
    rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    rig.plant.place(Axis::Deployer, 5000);
    rig.pause();
    rig.run(50);
    rig.run_while(1_000, |rig| rig.valve_output(0) == ValveOutput::Off);
    assert!(!rig.valve(SubsystemId::VALVE1).contains(ValveFlags::INTERNAL_FAULT));
    rig.plant.place(Axis::Deployer, 5400);
    rig.pause();
    rig.run_while(1_000, |rig| rig.valve_output(0) == ValveOutput::Off);
    rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    rig.run(20);
    assert_eq!(rig.valve_output(0), ValveOutput::Opening);
}

/// §1/8, §3.8/1 What is opened and folded in one frame is opened only.
#[test]
fn open_and_wrap_in_one_frame() {
    let mut rig = Rig::deployed();
    let requests = [Request::open(SubsystemId::VALVE1), Request::new(DEPLOYER, Body::Wrap)];
    let answers = rig.handle(&common::payload(&requests));
    assert_eq!(answers[0].status, Status::ACCEPTED);
    assert_eq!((answers[1].from, answers[1].status), (SubsystemId::VALVE1, Status::DENIED));
    let mut rig = Rig::deployed();
    let requests = [Request::new(DEPLOYER, Body::Wrap), Request::open(SubsystemId::VALVE1)];
    let answers = rig.handle(&common::payload(&requests));
    assert_eq!(answers[0].status, Status::ACCEPTED);
    assert_eq!((answers[1].from, answers[1].status), (DEPLOYER, Status::DENIED));
    rig.run_while(10_000, |rig| rig.valve_output(0) != ValveOutput::Opening);
}

/// §3.14/5, §3.16/3 What would have to deploy first is refused by a Deployer that cannot; in working
/// position its drive is not needed.
#[test]
fn programs_and_a_faulty_deployer() {
    let sector = Sector { centre_h: 600, centre_v: 0, nozzle: 30, width: 0, height: 0, step: 0 };
    let seek = Seek { start_h: -900, end_h: 900, start_v: 0, end_v: 600, analyse: 0 };
    let points = [TrajectoryPoint { horizontal: 600, vertical: 0, distance: 0, dwell: 5 }];
    let path = Path::Points(Points::Values(&points));
    let programs = [
        (SubsystemId::CONTROL, Body::StartQuench(Quench::Full { sector, distance: 0 })),
        (
            SubsystemId::CONTROL,
            Body::StartTrajectory(Trajectory { ballistics: false, repeat: false, path }),
        ),
        (SubsystemId::DETECTOR, Body::StartSeek(seek)),
    ];
    for rig in all() {
        for (to, body) in programs {
            let mut rig = rig.clone();
            rig.plant.inputs.drives[Axis::Deployer as usize].motor_open = true;
            rig.run(50);
            let deployed = position(&mut rig) == F::DEPLOYED;
            let broken = (DEPLOYER, Status::MODULE_FAULT);
            assert_eq!(rig.one(to, body), if deployed { (to, Status::ACCEPTED) } else { broken });
            rig.run(500);
            assert_eq!(rig.speed(Axis::Deployer), 0);
            assert_eq!(rig.speed(Axis::Horizontal) != 0, deployed);
        }
    }
}

/// §3.3.8/1 The limits of this drive are its two positions: each shows just there, whatever its
/// encoder says; while limits are off neither does.
#[test]
fn its_limits_are_its_positions() {
    const LIMITS: F = F::MIN_LIMIT_REACHED.union(F::MAX_LIMIT_REACHED);
    let shown = |rig: &mut Rig| rig.deployer() & LIMITS;
    for mut rig in all() {
        let limit = match position(&mut rig) {
            F::WRAPPED => F::MIN_LIMIT_REACHED,
            F::DEPLOYED => F::MAX_LIMIT_REACHED,
            _ => F::empty(),
        };
        assert_eq!(shown(&mut rig), limit);
        rig.plant.drive(Axis::Deployer).encoder_offset = 2700;
        rig.run(20);
        assert_eq!(shown(&mut rig), limit, "given by the switches");
        if !limit.is_empty() {
            rig.accepts(DEPLOYER, Body::SwitchLimits { new_state: 0 });
            assert_eq!(shown(&mut rig), F::empty());
            assert!(rig.deployer().contains(F::LIMITLESS));
        }
    }
}

/// §3.3.8 A drive that has to go slower under its load is no other state of deployment.
#[test]
fn a_heavy_deployment() {
    let mut rig = wrapped();
    rig.plant.drive(Axis::Deployer).current_da = 70;
    rig.accepts(DEPLOYER, Body::Deploy);
    rig.run(1000);
    assert_eq!(rig.speed(Axis::Deployer), 75, "half its speed");
    assert_eq!(rig.deployer(), F::DEPLOYING | F::MOVE);
}

/// §3.11/1 Where the barrel cannot be turned back to its rest, the wrapping ends before it folds; an
/// overload the other way is nothing to it.
#[test]
fn a_barrel_that_cannot_rest() {
    let overload = DriveFlags::AMPERAGE_OVERLOAD;
    for (axis, aside) in [
        (Axis::Horizontal, 3000_i16),
        (Axis::Horizontal, -3000),
        (Axis::Vertical, 1200),
        (Axis::Vertical, -600),
    ] {
        // On its way back.
        let mut rig = Rig::deployed();
        rig.plant.place(axis, aside.into());
        rig.run(20);
        rig.plant.drive(axis).current_da = 100;
        rig.accepts(DEPLOYER, Body::Wrap);
        rig.run(100);
        assert_eq!(rig.speed(axis).signum(), -aside.signum());
        rig.run_until(1000, |rig| rig.drive_flags(axis).contains(overload));
        rig.run_while(1000, |rig| rig.is_still() && position(rig) == F::DEPLOYED);
        // On its way out.
        let mut rig = Rig::deployed();
        rig.plant.place(axis, aside.into());
        rig.run(20);
        rig.plant.drive(axis).current_da = 100;
        rig.move_to(axis, 2 * aside);
        rig.run_until(1000, |rig| rig.drive_flags(axis).contains(overload));
        rig.plant.drive(axis).current_da = 20;
        rig.accepts(DEPLOYER, Body::Wrap);
        rig.run_while(500, |rig| position(rig) == F::WRAPPING);
        assert_eq!(rig.speed(axis).signum(), -aside.signum());
    }
    // One that is at its rest has no way to go, while the other goes its own.
    let mut rig = Rig::deployed();
    rig.plant.place(Axis::Vertical, 600);
    rig.pause();
    rig.plant.drive(Axis::Horizontal).jammed = true;
    rig.plant.drive(Axis::Horizontal).current_da = 100;
    rig.move_to(Axis::Horizontal, 900);
    rig.run_until(1000, |rig| rig.drive_flags(Axis::Horizontal).contains(overload));
    rig.accepts(DEPLOYER, Body::Wrap);
    rig.run_until(20_000, |rig| position(rig) == F::WRAPPED);
}

/// §3.11/1 How long the barrel takes to its rest is not TravelTime's business; one that comes no nearer ends the
/// wrapping, deployed, and is no fault of Deployer.
#[test]
fn a_long_way_to_rest() {
    let mut rig = Rig::deployed();
    rig.set(Param::HorizontalSpeed, 3);
    rig.plant.place(Axis::Horizontal, 10_000);
    rig.pause();
    rig.run(100);
    rig.accepts(DEPLOYER, Body::Wrap);
    rig.run(50);
    rig.run_while(50_000, |rig| position(rig) == F::WRAPPING && rig.speed(Axis::Horizontal) < 0);
    let mut held = rig.clone();
    rig.run_until(40_000, |rig| position(rig) == F::WRAPPED);
    // Its end switch is closed by a stone: the drive is at rest, and says nothing.
    held.plant.drive(Axis::Horizontal).switches = (9000, 90_000);
    held.run(9000);
    assert_eq!(position(&mut held), F::WRAPPING);
    held.run(2000);
    assert_eq!(held.deployer() & (WHERE | F::INTERNAL_FAULT), F::DEPLOYED);
    assert_eq!(held.speed(Axis::Deployer), 0);
    held.plant.drive(Axis::Horizontal).switches = (-90_000, 90_000);
    held.run(50);
    held.accepts(DEPLOYER, Body::Wrap);
    held.run_until(40_000, |rig| position(rig) == F::WRAPPED);
}

/// §3.11/1 A minute beside its rest the barrel has arrived; two, and it is turned.
#[test]
fn how_near_the_rest_is() {
    for aside in [-2, -1, 0, 1, 2_i64] {
        for axis in [Axis::Horizontal, Axis::Vertical] {
            let mut rig = Rig::deployed();
            rig.plant.place(axis, aside);
            rig.run(20);
            rig.accepts(DEPLOYER, Body::Wrap);
            let mut turned = false;
            for _ in 0..50 {
                rig.step(10);
                turned |= rig.speed(axis) != 0;
            }
            rig.run_until(20_000, |rig| position(rig) == F::WRAPPED);
            assert_eq!(turned, aside.abs() > 1, "{axis:?} {aside}");
        }
    }
}

/// §3.2/2 Stop Deployer while the barrel goes to its rest: it stops too, still deployed.
#[test]
fn stop_on_the_way_to_rest() {
    let mut rig = Rig::deployed();
    rig.plant.place(Axis::Horizontal, 3000);
    rig.plant.place(Axis::Vertical, 1200);
    rig.run(20);
    rig.accepts(DEPLOYER, Body::Wrap);
    rig.run(500);
    assert!(rig.speed(Axis::Horizontal) < 0 && rig.speed(Axis::Vertical) < 0);
    assert_eq!(rig.status(DEPLOYER, Body::Stop), Status::OK);
    rig.step(10);
    rig.run_while(1000, |rig| rig.is_still() && position(rig) == F::DEPLOYED);
}

/// §3.1/9 From the acceptance of Move on it is in between.
#[test]
fn a_moved_deployer_is_in_between() {
    let mut rig = Rig::deployed();
    rig.accepts(DEPLOYER, Body::Move { destination: 5390 });
    assert_eq!(position(&mut rig), F::empty());
    let (by, status) = rig.one(SubsystemId::VERTICAL, Body::Move { destination: 60 });
    assert_eq!((by, status), (DEPLOYER, Status::DENIED));
}

/// §3.14/5 A deployment that failed once is no reason to refuse a program when the working position
/// has been reached in another way.
#[test]
fn a_program_after_a_failed_deployment() {
    let mut rig = between();
    rig.accepts(DEPLOYER, Body::Move { destination: 5400 });
    rig.run_until(20_000, |rig| position(rig) == F::DEPLOYED);
    let sector = Sector { centre_h: 600, centre_v: 0, nozzle: 30, width: 0, height: 0, step: 0 };
    let quench = Body::StartQuench(Quench::Full { sector, distance: 0 });
    rig.accepts(SubsystemId::CONTROL, quench);
    rig.run_until(20_000, |rig| rig.drive(Axis::Horizontal).position == 600);
    let flags = ControlFlags::from_bits_retain(rig.flags(SubsystemId::CONTROL));
    assert!(flags.contains(ControlFlags::QUENCH), "{flags:?}");
}

/// §3.2/2, §3.14/10, §3.16/7 A deployment that ends half-way ends what waits for it.
#[test]
fn what_waits_for_a_deployment_ends_with_it() {
    let sector = Sector { centre_h: 600, centre_v: 0, nozzle: 30, width: 0, height: 0, step: 0 };
    let seek = Seek { start_h: -900, end_h: 900, start_v: 0, end_v: 600, analyse: 0 };
    let ends: [fn(&mut Rig); 2] = [
        |rig| rig.accepts(DEPLOYER, Body::Stop),
        |rig| rig.plant.inputs.drives[Axis::Deployer as usize].motor_open = true,
    ];
    for end in ends {
        let mut rig = wrapped();
        let quench = Quench::Full { sector, distance: 0 };
        rig.accepts(SubsystemId::CONTROL, Body::StartQuench(quench));
        rig.run(1000);
        let control =
            |rig: &mut Rig| ControlFlags::from_bits_retain(rig.flags(SubsystemId::CONTROL));
        assert_eq!(control(&mut rig), ControlFlags::QUENCH);
        end(&mut rig);
        rig.run(50);
        assert_eq!(control(&mut rig), ControlFlags::MODE_FAULT);
        let mut rig = wrapped();
        rig.accepts(SubsystemId::DETECTOR, Body::StartSeek(seek));
        rig.run(1000);
        let detector =
            |rig: &mut Rig| DetectorFlags::from_bits_retain(rig.flags(SubsystemId::DETECTOR));
        assert_eq!(detector(&mut rig), DetectorFlags::SEARCHING);
        end(&mut rig);
        rig.run(50);
        assert_eq!(detector(&mut rig), DetectorFlags::CANCELED);
    }
}

/// §3.10/1, §3.11/1 The switches stand a little beyond the limits of its encoder: it goes on to them.
#[test]
fn switches_beyond_the_limits() {
    let mut rig = wrapped();
    rig.plant.drive(Axis::Deployer).switches = (-30, 5430);
    rig.plant.drive(Axis::Deployer).stops = (-40, 5440);
    rig.plant.place(Axis::Deployer, -30);
    rig.run(20);
    for (body, there) in [(Body::Deploy, F::DEPLOYED), (Body::Wrap, F::WRAPPED)] {
        rig.accepts(DEPLOYER, body);
        rig.run_until(20_000, |rig| position(rig) == there);
    }
}

/// §3.1/9 Deployed, it rests at its switch, beyond its limit: outward there is nowhere to go, and a Move there does
/// not fold it by the difference; nor does one to where it is. Both leave it deployed.
#[test]
fn outward_of_its_switch_nothing_moves() {
    for aside in [0, 5400] {
        let mut rig = wrapped();
        rig.plant.drive(Axis::Deployer).switches = (-30, 5430);
        rig.plant.drive(Axis::Deployer).stops = (-40, 5440);
        rig.plant.place(Axis::Deployer, 5431);
        rig.plant.place(Axis::Horizontal, aside);
        rig.pause();
        rig.run(100);
        assert_eq!((position(&mut rig), rig.drive(Axis::Deployer).position), (F::DEPLOYED, 5431));
        for destination in [5431, 5432, 10_800, i16::MAX] {
            rig.accepts(DEPLOYER, Body::Move { destination });
            rig.run_while(500, |rig| rig.is_still() && position(rig) == F::DEPLOYED);
        }
        for destination in [5430, 5410, 5400, 0] {
            let mut rig = rig.clone();
            let answer = rig.one(DEPLOYER, Body::Move { destination });
            rig.run(200);
            let folds = aside == 0;
            assert_eq!(answer.1, if folds { Status::ACCEPTED } else { Status::DENIED });
            assert_eq!(rig.speed(Axis::Deployer) < 0, folds, "{destination}");
        }
        // Without limits it is where it says it is, too.
        rig.accepts(DEPLOYER, Body::SwitchLimits { new_state: 0 });
        rig.accepts(DEPLOYER, Body::Move { destination: 5431 });
        rig.run_while(500, |rig| rig.is_still() && position(rig) == F::DEPLOYED);
    }
}
