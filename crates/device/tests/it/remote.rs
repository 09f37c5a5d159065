//! Remote units (explosion-proof execution): their parameters, and what a lost unit means.

use crate::common::{self, Reply, Rig};
use lafet_device::Composition;
use lafet_device::image::{Axis, Outputs, Unit, UnitError, ValveOutput};
use lafet_proto::flags::{Button, ButtonState, DeployerFlags, DriveFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Quench};
use lafet_proto::{Status, SubsystemId};

const OPEN: Body<'static> = Body::Open { key: key::OPEN };
const CLOSE: Body<'static> = Body::Close { key: key::CLOSE };

/// Explosion-proof and deployed; the units hold the defaults.
fn rig() -> Rig {
    let mut rig = Rig::new(Composition::EX);
    let units = [
        (Unit::Vertical, SubsystemId::VERTICAL),
        (Unit::Horizontal, SubsystemId::HORIZONTAL),
        (Unit::Nozzle, SubsystemId::NOZZLE),
        (Unit::Deployer, SubsystemId::DEPLOYER),
        (Unit::Valve1, SubsystemId::VALVE1),
        (Unit::Valve2, SubsystemId::VALVE2),
    ];
    for (unit, id) in units {
        for param in Param::of(id) {
            let spec = param.spec();
            rig.plant.units[unit as usize].params.insert(spec.id.0, spec.default);
        }
    }
    rig.deploy();
    rig
}

/// §3.4/2 The first GetParam starts the fetch; Ok once the unit has answered, for a while; then the
/// value is stale and fetched again.
#[test]
fn not_cached_then_ok_then_stale() {
    let mut rig = rig();
    for (param, value) in [
        (Param::VerticalSpeed, 12),
        (Param::NozzleTrvPosition, -1),
        (Param::DeployerTravelTime, 20_000),
        (Param::Valve1TravelTime, 12_000),
        (Param::Valve2MaxCurrent, 60),
    ] {
        assert_eq!(rig.get(param), Err(Status::NOT_CACHED), "{param:?}");
        rig.run(20);
        assert_eq!(rig.get(param), Err(Status::NOT_CACHED), "{param:?}");
        rig.run(100);
        for _ in 0..3 {
            assert_eq!(rig.get(param), Ok(vec![value]), "{param:?}");
            rig.run(1000);
        }
        rig.run(3000);
        assert_eq!(rig.get(param), Err(Status::NOT_CACHED), "{param:?}");
        rig.run(100);
        assert_eq!(rig.get(param), Ok(vec![value]), "{param:?}");
    }
    // What is kept here needs no unit.
    assert_eq!(rig.get(Param::VerticalDriveType), Ok(vec![1]));
    assert_eq!(rig.get(Param::Valve1ValveType), Ok(vec![1]));
}

/// §3.5/7, §2 Cached until the unit has got it; the repeated request is Accepted, and only then acts.
#[test]
fn cached_then_accepted() {
    let mut rig = rig();
    for (param, unit, value) in [
        (Param::VerticalMaxLimit, Unit::Vertical, 600),
        (Param::NozzleTrvPosition, Unit::Nozzle, 3),
        (Param::DeployerTravelTime, Unit::Deployer, 15_000),
        (Param::Valve1TravelTime, Unit::Valve1, 9000),
    ] {
        assert_eq!(rig.set(param, value), Status::CACHED, "{param:?}");
        rig.run(20);
        assert_eq!(rig.set(param, value), Status::CACHED, "{param:?}");
        rig.run(100);
        // Looking does not lose the result.
        assert_eq!(rig.get(param), Ok(vec![value]), "{param:?}");
        assert_eq!(rig.set(param, value), Status::ACCEPTED, "{param:?}");
        let id = param.spec().id.0;
        assert_eq!(rig.plant.units[unit as usize].writes, [(id, value)], "{param:?}");
        assert_eq!(rig.device.params().get(param), value, "{param:?}");
    }
    assert_eq!(rig.limits(Axis::Vertical).max, 600);
    // A value out of range does not even reach the unit (§3.5/3).
    assert_eq!(rig.set(Param::VerticalSpeed, 256), Status::INVALID_VALUE);
    rig.run(200);
    assert_eq!(rig.plant.units[Unit::Vertical as usize].writes.len(), 1);
}

/// §3.3.1/3 RemotePa*: why the unit refused, until an access succeeds.
#[test]
fn the_unit_refuses() {
    let mut rig = rig();
    for (error, flag) in [
        (UnitError::Incomplete, DriveFlags::REMOTE_PA_INCOMPLETE),
        (UnitError::BadId, DriveFlags::REMOTE_PA_BAD_ID),
        (UnitError::BadValue, DriveFlags::REMOTE_PA_BAD_VAL),
        (UnitError::Internal, DriveFlags::REMOTE_PA_ERROR),
    ] {
        rig.plant.units[Unit::Horizontal as usize].error = Some(error);
        rig.plant.units[Unit::Valve1 as usize].error = Some(error);
        assert_eq!(rig.set(Param::HorizontalSpeed, 9), Status::CACHED);
        assert_eq!(rig.get(Param::Valve1TravelTime), Err(Status::NOT_CACHED));
        rig.run(100);
        assert_eq!(rig.drive_flags(Axis::Horizontal), flag);
        let common = ValveFlags::from_bits_retain(flag.bits());
        assert_eq!(rig.valve(SubsystemId::VALVE1), common | ValveFlags::CLOSED);
        assert_eq!(rig.device.params().get(Param::HorizontalSpeed), 20, "nothing changed");
        assert_eq!(rig.get(Param::Valve1TravelTime), Err(Status::NOT_CACHED));
        // A fault of the parameters does not hold up the drive.
        rig.move_to(Axis::Horizontal, 0);
    }
    rig.plant.units[Unit::Horizontal as usize].error = None;
    rig.plant.units[Unit::Valve1 as usize].error = None;
    assert_eq!(rig.get(Param::HorizontalSpeed), Err(Status::NOT_CACHED));
    assert_eq!(rig.get(Param::Valve1TravelTime), Err(Status::NOT_CACHED));
    rig.run(100);
    assert_eq!(rig.drive_flags(Axis::Horizontal), DriveFlags::empty());
    assert_eq!(rig.valve(SubsystemId::VALVE1), ValveFlags::CLOSED);
}

/// §3.3.1/3 WdtFault and ProtocolFault as long as the unit reports them; a moment of the latter is no more than that.
#[test]
fn what_the_unit_reports() {
    let mut rig = rig();
    rig.plant.inputs.units[Unit::Vertical as usize].watchdog_reset = true;
    rig.plant.inputs.units[Unit::Valve2 as usize].protocol_fault = true;
    rig.run(20);
    assert_eq!(rig.drive_flags(Axis::Vertical), DriveFlags::WDT_FAULT);
    let both = ValveFlags::PROTOCOL_FAULT | ValveFlags::CLOSED;
    assert_eq!(rig.valve(SubsystemId::VALVE2), both);
    rig.plant.inputs.units[Unit::Vertical as usize].watchdog_reset = false;
    rig.plant.inputs.units[Unit::Valve2 as usize].protocol_fault = false;
    rig.run(20);
    assert_eq!(rig.drive_flags(Axis::Vertical), DriveFlags::empty());
    assert_eq!(rig.valve(SubsystemId::VALVE2), ValveFlags::CLOSED);
}

/// §3.3.1/3 A lost drive counts as stopped; its requests answer ModuleFault, reads NotCached; back
/// again it works, and does not go on by itself.
#[test]
fn a_lost_drive() {
    let mut rig = rig();
    rig.move_to(Axis::Horizontal, 9000);
    rig.move_to(Axis::Vertical, 3000);
    rig.run(1000);
    assert_eq!(rig.set(Param::HorizontalSpeed, 9), Status::CACHED);
    rig.plant.units[Unit::Horizontal as usize].offline = true;
    rig.run(20);
    assert_eq!(rig.speed(Axis::Horizontal), 0);
    assert!(rig.speed(Axis::Vertical) > 0);
    assert_eq!(rig.drive_flags(Axis::Horizontal), DriveFlags::CONN_LOST);
    let status = rig.status(SubsystemId::HORIZONTAL, Body::Move { destination: 0 });
    assert_eq!(status, Status::MODULE_FAULT);
    assert_eq!(rig.status(SubsystemId::HORIZONTAL, Body::Stop), Status::MODULE_FAULT);
    assert_eq!(rig.get(Param::HorizontalSpeed), Err(Status::NOT_CACHED));
    assert_eq!(rig.set(Param::HorizontalSpeed, 9), Status::CACHED);
    rig.run_while(500, |rig| rig.speed(Axis::Horizontal) == 0);
    rig.plant.units[Unit::Horizontal as usize].offline = false;
    rig.run(500);
    assert!(rig.drive_flags(Axis::Horizontal).is_empty() && rig.speed(Axis::Horizontal) == 0);
    // What was asked of it while it was away does not happen behind the client's back.
    assert!(rig.plant.units[Unit::Horizontal as usize].writes.is_empty());
    rig.move_to(Axis::Horizontal, 0);
    rig.run_until(20_000, |rig| rig.drive(Axis::Horizontal).position == 0);
}

/// §3.3.1/3 A lost valve: Open and Close answer ModuleFault; back again it closes.
#[test]
fn a_lost_valve() {
    let mut rig = rig();
    rig.accepts(SubsystemId::VALVE1, OPEN);
    rig.run(5000);
    rig.plant.units[Unit::Valve1 as usize].offline = true;
    rig.run(20);
    assert!(rig.valve(SubsystemId::VALVE1).contains(ValveFlags::CONN_LOST));
    assert_eq!(rig.status(SubsystemId::VALVE1, OPEN), Status::MODULE_FAULT);
    let close = Body::Close { key: key::CLOSE };
    assert_eq!(rig.status(SubsystemId::VALVE1, close), Status::MODULE_FAULT);
    rig.plant.units[Unit::Valve1 as usize].offline = false;
    rig.run(20);
    assert_eq!(rig.status(SubsystemId::VALVE1, close), Status::ACCEPTED);
    rig.run_until(6000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::CLOSED);
    assert_eq!(rig.valve_output(0), ValveOutput::Off);
}

type Hinder = fn(&mut Rig, bool);

/// The unit of a valve is gone; the valve is blocked.
const HINDRANCES: [Hinder; 2] =
    [|rig, on| rig.plant.units[4].offline = on, |rig, on| rig.plant.inputs.valves[0].blocked = on];

/// Jammed and hindered for longer than a closing may take, the valve is closed when both are over, once; after a Stop it
/// is not driven for so long, ms.
fn is_closed_later_once(mut rig: Rig, hinder: Hinder, stopped_ms: u32) {
    rig.run(60_000);
    assert_eq!(rig.valve_output(0), ValveOutput::Off);
    rig.plant.valves[0].jammed = false;
    let mut stopped = rig.clone();
    hinder(&mut rig, false);
    rig.run_until(6000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::CLOSED);
    // Once.
    rig.plant.valves[0].opening_ms = 2000;
    hinder(&mut rig, true);
    rig.run(100);
    hinder(&mut rig, false);
    rig.run_while(1000, |rig| rig.valve_output(0) == ValveOutput::Off);
    stopped.ask(SubsystemId::VALVE1, Body::Stop);
    hinder(&mut stopped, false);
    stopped.run_while(stopped_ms, |rig| rig.valve_output(0) == ValveOutput::Off);
}

/// §D/1, §3.3.5 A unit that is back long after power-up, or a block that is gone then, finds the valve closed by the
/// rule that had closed it in vain; once, and not after a request that says something else.
#[test]
fn a_valve_that_comes_late_is_closed() {
    for hinder in HINDRANCES {
        let mut rig = rig();
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::OPEN);
        hinder(&mut rig, true);
        rig.plant.valves[0].jammed = true;
        rig.power_cycle();
        is_closed_later_once(rig, hinder, 1000);
    }
}

/// §3.9/2, §3.3.5 A Close that was accepted is owed until the valve has closed: a unit that is gone for longer than a
/// closing may take, or a block, only puts it off. A Stop or an Open that comes meanwhile ends that.
#[test]
fn a_close_is_owed() {
    let close: fn(&mut Rig) =
        |rig| rig.accepts(SubsystemId::VALVE1, Body::Close { key: key::CLOSE });
    let press: fn(&mut Rig) = |rig| {
        rig.plant.inputs.buttons[0][Button::Close as usize] = ButtonState::Pressed;
        rig.run(20);
        rig.plant.inputs.buttons[0][Button::Close as usize] = ButtonState::Released;
    };
    for (hinder, ask) in
        HINDRANCES.into_iter().flat_map(|hinder| [(hinder, close), (hinder, press)])
    {
        let mut rig = rig();
        rig.accepts(SubsystemId::VALVE1, OPEN);
        rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::OPEN);
        ask(&mut rig);
        rig.plant.valves[0].jammed = true;
        rig.run(100);
        hinder(&mut rig, true);
        is_closed_later_once(rig, hinder, 40_000);
    }
}

/// §3.3.5 No motor is fed without end, also when its unit comes and goes: it is one attempt, one more, and then a rest
/// as long as an attempt, whatever closes the valve. A valve that comes loose is closed.
#[test]
fn a_unit_that_comes_and_goes() {
    type Begin = fn(&mut Rig);
    let begins: [Begin; 3] = [
        |rig| rig.accepts(SubsystemId::VALVE1, Body::Close { key: key::CLOSE }),
        |rig| rig.all_accept(Body::Lockout { key: key::ENABLE }),
        |rig| rig.power_cycle(),
    ];
    for (begin, every_ms) in begins.into_iter().flat_map(|begin| [(begin, 1000), (begin, 7000)]) {
        let mut rig = rig();
        rig.accepts(SubsystemId::VALVE1, OPEN);
        rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::OPEN);
        rig.plant.valves[0].jammed = true;
        begin(&mut rig);
        let (mut fed_ms, mut longest_ms, mut run_ms) = (0, 0, 0);
        for at_ms in (0..600_000).step_by(10) {
            rig.plant.units[4].offline = at_ms % every_ms < 200;
            rig.step(10);
            let fed = rig.valve_output(0) != ValveOutput::Off;
            run_ms = if fed { run_ms + 10 } else { 0 };
            fed_ms += if fed { 10 } else { 0 };
            longest_ms = longest_ms.max(run_ms);
        }
        assert!(longest_ms <= 36_100 && fed_ms <= 410_000, "{longest_ms} {fed_ms}");
        rig.plant.units[4].offline = true;
        rig.run(100);
        rig.plant.units[4].offline = false;
        rig.plant.valves[0].jammed = false;
        rig.run_until(40_000, |rig| rig.valve(SubsystemId::VALVE1).contains(ValveFlags::CLOSED));
    }
}

/// §D/2 With ResetValves a valve whose unit is lost at power-up is judged when the unit is back and its contacts have
/// settled: open it stays so.
#[test]
fn a_lost_valve_is_kept() {
    for (opening_ms, stays) in [(4000, true), (2000, false)] {
        let mut rig = rig();
        rig.set(Param::GeneralResetValves, 1);
        rig.run(100);
        rig.plant.valves[0].opening_ms = opening_ms;
        rig.plant.units[4].offline = true;
        rig.plant.valves[0].open_switch_dead = true;
        rig.run(20);
        rig.power_cycle();
        rig.run_while(30_000, |rig| rig.valve_output(0) == ValveOutput::Off);
        rig.plant.units[4].offline = false;
        rig.run(20);
        rig.plant.valves[0].open_switch_dead = false;
        rig.run(6000);
        let expected = if stays { ValveFlags::OPEN } else { ValveFlags::CLOSED };
        assert_eq!(rig.valve(SubsystemId::VALVE1), expected);
    }
}

/// §3.3.1/3, §3.10/3 The Deployer's unit is lost on the way: it stops in between.
#[test]
fn a_lost_deployer() {
    let mut rig = rig();
    rig.accepts(SubsystemId::DEPLOYER, Body::Wrap);
    rig.run(2000);
    rig.plant.units[Unit::Deployer as usize].offline = true;
    rig.run(50);
    let position = DeployerFlags::WRAPPING | DeployerFlags::WRAPPED | DeployerFlags::DEPLOYED;
    assert_eq!(rig.deployer() & (position | DeployerFlags::CONN_LOST), DeployerFlags::CONN_LOST);
    assert_eq!(rig.status(SubsystemId::DEPLOYER, Body::Deploy), Status::MODULE_FAULT);
    rig.plant.units[Unit::Deployer as usize].offline = false;
    rig.run(50);
    rig.deploy();
}

/// §3.17/1, §3.1/8 Limits off, a remote drive still goes to its destination, past the limits, and counts.
#[test]
fn limitless_goes_to_the_destination() {
    let mut rig = rig();
    rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 0 });
    rig.move_to(Axis::Vertical, 5000);
    rig.run(2000);
    assert!(rig.drive(Axis::Vertical).position > 500);
    rig.run_until(20_000, |rig| rig.drive(Axis::Vertical).position == 5000);
    rig.run_while(200, |rig| rig.is_still());
}

/// §3.17/2 Limits taken reach the unit before they come into force: Busy until it has got them.
#[test]
fn teaching_limits() {
    let mut rig = rig();
    rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 0 });
    for (param, at) in [(Param::VerticalMinLimit, -300), (Param::VerticalMaxLimit, 900)] {
        rig.move_to(Axis::Vertical, at);
        rig.run_until(20_000, |rig| rig.drive(Axis::Vertical).position == at);
        rig.run(50);
        assert_eq!(rig.set(param, at.into()), Status::ACCEPTED);
    }
    let on = Body::SwitchLimits { new_state: 1 };
    for _ in 0..2 {
        assert_eq!(rig.status(SubsystemId::VERTICAL, on), Status::BUSY);
        assert!(rig.drive_flags(Axis::Vertical).contains(DriveFlags::LIMITLESS));
        rig.run(100);
    }
    assert_eq!(rig.status(SubsystemId::VERTICAL, on), Status::OK);
    assert!(!rig.drive_flags(Axis::Vertical).contains(DriveFlags::LIMITLESS));
    let limits = rig.limits(Axis::Vertical);
    assert_eq!((limits.min, limits.max), (-300, 900));
    rig.run(100);
    let limits = rig.limits(Axis::Vertical);
    assert_eq!((limits.min, limits.max), (-300, 900), "they stay");
    assert_eq!(rig.plant.units[Unit::Vertical as usize].writes.len(), 2);
}

/// §3.4/2, §1/9 An answer that finds no room does not lose what the unit has said.
#[test]
fn no_room_keeps_the_value() {
    let mut rig = rig();
    assert_eq!(rig.get(Param::VerticalSpeed), Err(Status::NOT_CACHED));
    rig.run(100);
    let id = Param::VerticalSpeed.spec().id;
    let request = lafet_proto::Request::new(SubsystemId::VERTICAL, Body::GetParam { id });
    let mut out = [0; 12];
    rig.device.handle(rig.now_ms, rig.source, &common::payload(&[request]), &mut out);
    assert_eq!(out[2], Status::NO_ROOM.0);
    assert_eq!(rig.get(Param::VerticalSpeed), Ok(vec![12]));
}

/// §3.4/2 A client that asks for all parameters of a unit in every frame gets all of them.
#[test]
fn all_parameters_of_a_unit_come() {
    let mut rig = rig();
    let params = [
        Param::VerticalMinLimit,
        Param::VerticalMaxLimit,
        Param::VerticalZeroPoint,
        Param::VerticalSpeed,
        Param::VerticalAcceleration,
        Param::VerticalMaxCurrent,
        Param::VerticalSlowCurrent,
    ];
    for param in params {
        assert_eq!(rig.get(param), Err(Status::NOT_CACHED), "{param:?}");
    }
    rig.run(2000);
    for param in params {
        assert_eq!(rig.get(param), Ok(vec![param.spec().default]), "{param:?}");
    }
}

/// §3.4/2 What a unit has said counts for 5 s to the millisecond, whatever the steps are; then it is
/// asked for again.
#[test]
fn how_long_a_value_counts() {
    for step_ms in [7, 10, 50] {
        let mut rig = rig();
        assert_eq!(rig.get(Param::VerticalSpeed), Err(Status::NOT_CACHED));
        let mut steps = 0..100;
        while rig.get(Param::VerticalSpeed).is_err() {
            assert!(steps.next().is_some(), "never");
            rig.step(step_ms);
        }
        for _ in 0..5000 / step_ms {
            rig.step(step_ms);
            assert_eq!(rig.get(Param::VerticalSpeed), Ok(vec![12]), "{step_ms}");
        }
        rig.step(step_ms);
        assert_eq!(rig.get(Param::VerticalSpeed), Err(Status::NOT_CACHED), "{step_ms}");
    }
}

/// §3.5/7 So does that a unit has taken a value: a client that comes later has it sent again.
#[test]
fn how_long_a_write_counts() {
    let writes = |rig: &Rig| rig.plant.units[Unit::Vertical as usize].writes.len();
    for step_ms in [7, 10, 50] {
        for (late, status, sent) in [(false, Status::ACCEPTED, 1), (true, Status::CACHED, 2)] {
            let mut rig = rig();
            assert_eq!(rig.set(Param::VerticalSpeed, 9), Status::CACHED);
            let mut steps = 0..100;
            while writes(&rig) == 0 {
                assert!(steps.next().is_some(), "never");
                rig.step(step_ms);
            }
            // The step in which the unit's answer is taken.
            for _ in 0..5000 / step_ms + u32::from(late) {
                rig.step(step_ms);
            }
            assert_eq!(rig.set(Param::VerticalSpeed, 9), status, "{step_ms}");
            rig.run(200);
            assert_eq!(writes(&rig), sent, "{step_ms}");
        }
    }
}

/// §3.5/7 One value is written at a time: another one waits for its turn, and what the unit has taken
/// is believed of just that parameter and value.
#[test]
fn one_write_at_a_time() {
    let mut rig = rig();
    assert_eq!(rig.set(Param::VerticalSpeed, 9), Status::CACHED);
    assert_eq!(rig.set(Param::VerticalMaxLimit, 600), Status::CACHED);
    rig.run(200);
    let speed = Param::VerticalSpeed.spec().id.0;
    assert_eq!(rig.plant.units[Unit::Vertical as usize].writes, [(speed, 9)]);
    // The same parameter with another value, and another with the same, are sent.
    assert_eq!(rig.set(Param::VerticalSpeed, 10), Status::CACHED);
    rig.run(200);
    assert_eq!(rig.set(Param::VerticalMaxCurrent, 10), Status::CACHED);
    rig.run(200);
    let current = Param::VerticalMaxCurrent.spec().id.0;
    let sent = [(speed, 9), (speed, 10), (current, 10)];
    assert_eq!(rig.plant.units[Unit::Vertical as usize].writes, sent);
    assert_eq!(rig.set(Param::VerticalMaxCurrent, 10), Status::ACCEPTED);
    // Reported once: the next one is sent again.
    assert_eq!(rig.set(Param::VerticalMaxCurrent, 10), Status::CACHED);
}

/// §3.5/7 A write goes first; then the parameter that has waited longest.
#[test]
fn the_order_at_the_unit() {
    let mut rig = rig();
    let id = |param: Param| param.spec().id.0;
    let under_way = |rig: &Rig| rig.plant.outputs.units[Unit::Vertical as usize].map(|op| op.param);
    assert_eq!(rig.get(Param::VerticalSpeed), Err(Status::NOT_CACHED));
    rig.step(10);
    assert_eq!(rig.get(Param::VerticalMinLimit), Err(Status::NOT_CACHED));
    rig.step(10);
    assert_eq!(rig.get(Param::VerticalMaxLimit), Err(Status::NOT_CACHED));
    assert_eq!(rig.set(Param::VerticalMaxCurrent, 70), Status::CACHED);
    let mut order = vec![];
    for _ in 0..100 {
        rig.step(10);
        if let Some(param) = under_way(&rig).filter(|param| order.last() != Some(param)) {
            order.push(param);
        }
    }
    let expected = [
        Param::VerticalSpeed,
        Param::VerticalMaxCurrent,
        Param::VerticalMinLimit,
        Param::VerticalMaxLimit,
    ];
    assert_eq!(order, expected.map(id));
}

/// §3.4/2 More parameters than there are places for: the oldest value makes room.
#[test]
fn the_oldest_value_makes_room() {
    let mut rig = rig();
    let mut params: Vec<Param> = Param::of(SubsystemId::NOZZLE).collect();
    params.retain(|param| rig.get(*param) == Err(Status::NOT_CACHED));
    assert_eq!(params.len(), 8);
    rig.run(1000);
    for param in &params {
        assert_eq!(rig.get(*param), Ok(vec![param.spec().default]), "{param:?}");
    }
}

/// §3.5/1 What is kept here is set without the unit, also when that is lost.
#[test]
fn local_parameters_need_no_unit() {
    let mut rig = rig();
    for unit in &mut rig.plant.units {
        unit.offline = true;
    }
    rig.run(20);
    for param in [Param::VerticalDriveType, Param::Valve1ValveType, Param::Valve2ValveType] {
        assert_eq!(rig.set(param, 0), Status::ACCEPTED, "{param:?}");
        assert_eq!(rig.get(param), Ok(vec![0]), "{param:?}");
    }
    assert_eq!(rig.set(Param::Valve1TravelTime, 9000), Status::CACHED);
}

/// §3.3.1/3, §3.3.5 A valve that is lost at its end is not judged by not leaving it: the time for it
/// begins when it is back.
#[test]
fn a_lost_valve_is_not_judged() {
    let mut rig = rig();
    rig.accepts(SubsystemId::VALVE1, OPEN);
    rig.run(5000);
    rig.accepts(SubsystemId::VALVE1, Body::Close { key: key::CLOSE });
    rig.plant.valves[0].jammed = true;
    rig.run(200);
    rig.plant.units[Unit::Valve1 as usize].offline = true;
    rig.run(3000);
    rig.plant.units[Unit::Valve1 as usize].offline = false;
    rig.run_while(700, |rig| {
        let flags = rig.valve(SubsystemId::VALVE1);
        flags == ValveFlags::OPEN | ValveFlags::CLOSING
    });
    rig.run(200);
    assert!(rig.valve(SubsystemId::VALVE1).contains(ValveFlags::INTERNAL_FAULT));
}

/// §3.3.1/3, §3.3.4/2 A lost drive that still turns is not shown as moving; what is sensed of it is
/// the last picture.
#[test]
fn the_last_picture_of_a_lost_drive() {
    let mut rig = rig();
    rig.move_to(Axis::Vertical, 3000);
    rig.run(1000);
    let at = rig.drive(Axis::Vertical).position;
    rig.plant.units[Unit::Vertical as usize].offline = true;
    rig.run(10);
    rig.plant.place(Axis::Vertical, 900);
    rig.run(50);
    let status = rig.drive(Axis::Vertical);
    assert!((at..at + 20).contains(&status.position), "{}", status.position);
    assert_eq!((status.flags, status.current), (DriveFlags::CONN_LOST, 0));
}

/// The subsystems of the units.
const OF_UNITS: [SubsystemId; 6] = [
    SubsystemId::VERTICAL,
    SubsystemId::HORIZONTAL,
    SubsystemId::NOZZLE,
    SubsystemId::DEPLOYER,
    SubsystemId::VALVE1,
    SubsystemId::VALVE2,
];
const BOTH: DriveFlags = DriveFlags::CONN_LOST.union(DriveFlags::PROTOCOL_FAULT);

/// The exchanges with a unit are broken, or good again.
fn breaks(rig: &mut Rig, unit: usize, broken: bool) {
    rig.plant.inputs.units[unit].protocol_fault = broken;
}

fn both(rig: &mut Rig, unit: usize) -> DriveFlags {
    DriveFlags::from_bits_retain(rig.flags(OF_UNITS[unit])) & BOTH
}

/// What a monitor drives and says, but for ProtocolFault.
fn shown(rig: &mut Rig) -> (Outputs, Vec<Reply>) {
    let mut replies = rig.ask(SubsystemId::ALL, Body::GetStatus);
    let [_, mask, ..] = (!DriveFlags::PROTOCOL_FAULT.bits()).to_le_bytes();
    replies.iter_mut().filter_map(|reply| reply.data.get_mut(1)).for_each(|byte| *byte &= mask);
    (rig.plant.outputs, replies)
}

type Begin = fn(&mut Rig);

/// What a monitor may be at.
const ACTIVITIES: [Begin; 6] = [
    |_| (),
    |rig| {
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            rig.move_to(axis, if axis == Axis::Nozzle { 60 } else { 4000 });
        }
    },
    |rig| {
        let quench = Quench::Program { program: 0, centre_h: 3000, centre_v: 600, nozzle: 30 };
        rig.accepts(SubsystemId::CONTROL, Body::StartQuench(quench));
    },
    |rig| rig.accepts(SubsystemId::DEPLOYER, Body::Wrap),
    |rig| {
        rig.accepts(SubsystemId::VALVE1, OPEN);
        rig.accepts(SubsystemId::VALVE2, OPEN);
    },
    |rig| {
        rig.accepts(SubsystemId::VALVE1, OPEN);
        rig.run(5000);
        rig.accepts(SubsystemId::VALVE1, CLOSE);
    },
];

/// §3.3.1/3, §D/6 A unit whose exchanges have been broken for as long as one may be silent is lost as one that is silent,
/// whatever the monitor is at: the same outputs, flags and answers, but for ProtocolFault. With the first good one it is
/// back as that is.
#[test]
fn not_understood_is_lost() {
    for (begin, unit) in ACTIVITIES.into_iter().flat_map(|begin| (0..6).map(move |u| (begin, u))) {
        let mut silent = rig();
        begin(&mut silent);
        silent.run(200);
        let mut broken = silent.clone();
        breaks(&mut broken, unit, true);
        for ms in (10..=2000).step_by(10) {
            silent.plant.units[unit].offline = ms >= 100;
            silent.step(10);
            broken.step(10);
            assert_eq!(silent.plant.outputs, broken.plant.outputs, "{unit} after {ms} ms");
            let expected = if ms >= 100 { BOTH } else { DriveFlags::PROTOCOL_FAULT };
            assert_eq!(both(&mut broken, unit), expected, "{unit} after {ms} ms");
        }
        assert_eq!(shown(&mut silent), shown(&mut broken), "{unit}");
        let to = OF_UNITS[unit];
        for body in [Body::Move { destination: 10 }, Body::Stop, Body::Deploy, OPEN, CLOSE] {
            assert_eq!(silent.ask(to, body), broken.ask(to, body), "{body:?} {to}");
        }
        silent.plant.units[unit].offline = false;
        breaks(&mut broken, unit, false);
        for ms in (10..=2000).step_by(10) {
            silent.step(10);
            broken.step(10);
            assert_eq!(silent.plant.outputs, broken.plant.outputs, "{unit} back for {ms} ms");
            assert_eq!(both(&mut broken, unit), DriveFlags::empty(), "{unit} back for {ms} ms");
        }
        assert_eq!(shown(&mut silent), shown(&mut broken), "{unit}");
    }
}

/// §D/6 Broken exchanges between good ones end nothing; nor does one in a step that is long.
#[test]
fn broken_for_moments() {
    let mut rig = rig();
    rig.move_to(Axis::Horizontal, 9000);
    rig.accepts(SubsystemId::VALVE1, OPEN);
    let units = [Unit::Horizontal as usize, Unit::Valve1 as usize];
    let mut ms = 0;
    while rig.drive_flags(Axis::Horizontal).contains(DriveFlags::MOVE) {
        for unit in units {
            breaks(&mut rig, unit, ms % 100 != 0);
            assert!(!both(&mut rig, unit).contains(DriveFlags::CONN_LOST), "{unit}");
        }
        rig.step(10);
        ms += 10;
    }
    assert_eq!(rig.drive(Axis::Horizontal).position, 9000);
    assert_eq!(rig.valve(SubsystemId::VALVE1) - ValveFlags::PROTOCOL_FAULT, ValveFlags::OPEN);
    for broken in [false, true, false] {
        units.into_iter().for_each(|unit| breaks(&mut rig, unit, broken));
        rig.step(500);
        assert!(units.iter().all(|unit| !both(&mut rig, *unit).contains(DriveFlags::CONN_LOST)));
    }
}

/// §D/6 A unit that was silent, or has not been heard since the start, is not back with answers that are not understood.
#[test]
fn answers_that_are_not_understood_bring_nothing_back() {
    for starts in [false, true] {
        let mut rig = rig();
        let unit = Unit::Vertical as usize;
        breaks(&mut rig, unit, true);
        if starts {
            rig.power_cycle();
        } else {
            rig.plant.units[unit].offline = true;
            rig.run(20);
            rig.plant.units[unit].offline = false;
        }
        rig.run_while(1000, |rig| both(rig, unit) == BOTH);
        let status = rig.status(SubsystemId::VERTICAL, Body::Move { destination: 600 });
        assert_eq!(status, Status::MODULE_FAULT);
        breaks(&mut rig, unit, false);
        rig.step(10);
        assert!(both(&mut rig, unit).is_empty());
        rig.move_to(Axis::Vertical, 600);
    }
}

/// §3.8/3, §D/6 An opening ends when its unit is lost, silent or not understood: water that comes when the unit is back is
/// not expected any more. A new Open opens it.
#[test]
fn an_opening_ends_with_its_unit() {
    let unit = Unit::Valve1 as usize;
    let goes: [fn(&mut Rig, usize, bool); 2] =
        [|rig, unit, gone| rig.plant.units[unit].offline = gone, breaks];
    for goes in goes {
        let mut rig = rig();
        rig.accepts(SubsystemId::VALVE1, OPEN);
        rig.step(10);
        assert_eq!(rig.valve_output(0), ValveOutput::Opening);
        goes(&mut rig, unit, true);
        rig.run(120);
        assert_eq!(rig.valve_output(0), ValveOutput::Off);
        goes(&mut rig, unit, false);
        rig.run_while(2000, |rig| rig.valve_output(0) == ValveOutput::Off);
        rig.accepts(SubsystemId::VALVE1, OPEN);
        rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1).contains(ValveFlags::OPEN));
    }
}

/// §3.3.1/3, §3.11/6 A valve whose unit is lost while it opens may be open, whatever its last picture says: nothing folds, and
/// what closes it is owed.
#[test]
fn a_valve_that_is_lost_while_it_opens() {
    for stop in [SubsystemId::ALL, SubsystemId::VALVE1] {
        let mut rig = rig();
        rig.accepts(SubsystemId::VALVE1, OPEN);
        rig.step(10);
        assert!(rig.valve(SubsystemId::VALVE1).contains(ValveFlags::OPENING | ValveFlags::CLOSED));
        rig.plant.units[Unit::Valve1 as usize].offline = true;
        rig.run(20);
        rig.ask(stop, Body::Stop);
        rig.run(20);
        assert_eq!(rig.valve(SubsystemId::VALVE1), ValveFlags::CONN_LOST);
        let folds = rig.one(SubsystemId::DEPLOYER, Body::Wrap);
        assert_eq!(folds, (SubsystemId::VALVE1, Status::DENIED));
        rig.plant.valves[0].jammed = true;
        assert_eq!(rig.status(SubsystemId::VALVE1, CLOSE), Status::MODULE_FAULT);
        rig.run_while(1000, |rig| rig.valve_output(0) == ValveOutput::Closing);
        rig.plant.valves[0].jammed = false;
        rig.plant.units[Unit::Valve1 as usize].offline = false;
        rig.run_until(500, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::CLOSED);
        rig.accepts(SubsystemId::DEPLOYER, Body::Wrap);
    }
}
