//! Every output says why it is as it is, and what the swarm has found stays fixed.

use crate::common::Rig;
use lafet_device::Source;
use lafet_device::cause::{Asked, Cause, Program, Rule};
use lafet_device::image::{Axis, ValveOutput};
use lafet_proto::flags::{ButtonState, ValveFlags};
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Quench, Sector};
use lafet_proto::{Request, RequestId, SubsystemId};

fn asked(request: RequestId, to: SubsystemId) -> Asked {
    Asked { request, to, source: Source::ExternalConn }
}

fn cause(rig: &Rig, axis: Axis) -> Cause {
    rig.device.causes().drives[axis as usize]
}

const POINT: Sector =
    Sector { centre_h: 600, centre_v: -100, nozzle: 30, width: 0, height: 0, step: 0 };

fn quench(rig: &mut Rig, sector: Sector) {
    let quench = Quench::Full { sector, distance: 0 };
    rig.accepts(SubsystemId::CONTROL, Body::StartQuench(quench));
}

/// §3.1/4, §3.2/5, §3.10/1, §3.14/1 A drive by a request, by programs, and at its end.
#[test]
fn a_drive_says_who_moves_it() {
    let mut rig = Rig::new(lafet_device::Composition::FULL);
    assert_eq!(cause(&rig, Axis::Horizontal), Cause::Rule(Rule::Inert));
    quench(&mut rig, POINT);
    rig.run(500);
    let by = asked(RequestId::START_QUENCH, SubsystemId::CONTROL);
    assert_eq!(cause(&rig, Axis::Deployer), Cause::Program(Program::Deploy, by));
    rig.run_until(20_000, |rig| rig.speed(Axis::Horizontal) != 0);
    assert_eq!(cause(&rig, Axis::Horizontal), Cause::Program(Program::Quench, by));
    rig.source = Source::Radio;
    rig.move_to(Axis::Horizontal, 3000);
    rig.run(50);
    let moved = Asked { source: Source::Radio, ..asked(RequestId::MOVE, SubsystemId::HORIZONTAL) };
    assert_eq!(cause(&rig, Axis::Horizontal), Cause::Request(moved));
    assert_eq!(cause(&rig, Axis::Vertical), Cause::Rule(Rule::Paused));
    rig.all_accept(Body::Stop);
    rig.run(10);
    let stopped = Asked { to: SubsystemId::ALL, request: RequestId::STOP, ..moved };
    assert_eq!(cause(&rig, Axis::Horizontal), Cause::Request(stopped));
    assert!(rig.is_still());
}

/// §3.8/3, §3.18/1, §D/1 A valve by power-up, by a request, by a button, by the lockout.
#[test]
fn a_valve_says_who_drives_it() {
    let mut rig = Rig::deployed();
    let valve = |rig: &Rig| rig.device.causes().valves[0];
    let open = Request::open(SubsystemId::VALVE1);
    rig.accepts(open.to, open.body);
    rig.run(10);
    let by = Cause::Request(asked(RequestId::OPEN, SubsystemId::VALVE1));
    assert_eq!((valve(&rig), rig.valve_output(0)), (by, ValveOutput::Opening));
    rig.run(3_000);
    rig.plant.inputs.buttons[1][7] = ButtonState::Pressed;
    rig.run(10);
    let button = Cause::Button(SubsystemId::EXT_BUTTONS);
    assert_eq!((valve(&rig), rig.valve_output(0)), (button, ValveOutput::Closing));
    rig.power_cycle_and_settle();
    assert_eq!(rig.valve_output(0), ValveOutput::Closing);
    assert_eq!(valve(&rig), Cause::Rule(Rule::PowerUp));
}

/// §3.3.3/1 A heater by the cold, off by the warmth, its own fault, or a sensor that reports nothing.
#[test]
fn a_heater_says_why_it_heats() {
    let mut rig = Rig::new(lafet_device::Composition::FULL);
    for (temperature_dc, heater_fault, rule, on) in [
        (Some(200), false, Rule::Warm, false),
        (Some(-100), false, Rule::Cold, true),
        (Some(-100), true, Rule::HeaterFault, false),
        (None, true, Rule::NoTemperature, false),
        (Some(200), true, Rule::Warm, false),
    ] {
        rig.plant.inputs.places[1].temperature_dc = temperature_dc;
        rig.plant.inputs.places[1].heater_fault = heater_fault;
        rig.run(50);
        assert_eq!(rig.device.causes().heaters[1], Cause::Rule(rule), "{temperature_dc:?}");
        assert_eq!(rig.device.causes().heaters[0], Cause::Rule(Rule::Warm));
        assert_eq!(rig.plant.outputs.heaters, [false, on, false, false, false]);
    }
}

/// §D/5 What the guard holds back starts from standstill when it passes again, the right way round.
#[test]
fn no_speed_is_gathered_while_the_guard_holds() {
    let composition = lafet_device::Composition::REMOTE;
    let mut rig = Rig::new(composition);
    rig.power_cycle();
    rig.step(10);
    rig.move_to(Axis::Horizontal, -9000);
    rig.run(70);
    rig.move_to(Axis::Horizontal, 9000);
    for _ in 0..10 {
        rig.step(10);
        let speed = rig.speed(Axis::Horizontal);
        assert!((0..=40).contains(&speed), "{speed}");
    }
    assert!(rig.speed(Axis::Horizontal) > 0);
}

/// §3.3.10/1, §3.5 A limit moved inward past the drive: a held button does not turn it back.
#[test]
fn a_button_never_moves_the_other_way() {
    let limits = [(Param::VerticalMaxLimit, 2, 3, 1), (Param::VerticalMinLimit, 3, 2, -1)];
    for (limit, outward, inward, side) in limits {
        let mut rig = Rig::deployed();
        assert!(rig.set(Param::VerticalMinLimit, -1800).is_success());
        rig.move_to(Axis::Vertical, 1200 * side);
        rig.run(20_000);
        assert!(rig.set(limit, i32::from(600 * side)).is_success());
        rig.plant.inputs.buttons[0][outward] = ButtonState::Pressed;
        rig.run_while(1_000, |rig| rig.speed(Axis::Vertical) == 0);
        rig.plant.inputs.buttons[0][outward] = ButtonState::Released;
        rig.plant.inputs.buttons[0][inward] = ButtonState::Pressed;
        rig.run(500);
        assert!(rig.speed(Axis::Vertical) * side < 0, "{limit:?}");
    }
}

/// §3.14/9 A program that replaces another: nothing goes on to where the old one sent it.
#[test]
fn a_replaced_program_moves_nothing() {
    let mut rig = Rig::deployed();
    quench(&mut rig, Sector { nozzle: 60, ..POINT });
    rig.run(2_000);
    assert!(rig.speed(Axis::Nozzle) != 0);
    rig.source = Source::Radio;
    let nozzle = rig.drive(Axis::Nozzle).position;
    quench(&mut rig, Sector { nozzle, ..POINT });
    rig.run(20);
    for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
        let by =
            Asked { source: Source::Radio, ..asked(RequestId::START_QUENCH, SubsystemId::CONTROL) };
        let held = rig.speed(axis) == 0;
        assert!(held || cause(&rig, axis) == Cause::Program(Program::Quench, by), "{axis:?}");
    }
    assert_eq!(rig.speed(Axis::Nozzle), 0);
}

/// §3.8/1, §3.3.5/1 What opens ends with the working position, and with a block; it neither waits
/// for them nor is called faulty for having waited.
#[test]
fn an_opening_does_not_wait() {
    fn lies(rig: &mut Rig, on: bool) {
        rig.plant.drive(Axis::Deployer).switches.0 = if on { i64::MAX } else { i64::MIN };
    }
    fn blocks(rig: &mut Rig, on: bool) {
        rig.plant.inputs.valves[0].blocked = on;
    }
    type Hold = fn(&mut Rig, bool);
    let holds: [(Hold, Rule); 2] = [(lies, Rule::NotDeployed), (blocks, Rule::Blocked)];
    for (hold, rule) in holds {
        for opens_for_ms in [0, 1_000] {
            let mut rig = Rig::deployed();
            let open = Request::open(SubsystemId::VALVE1);
            rig.accepts(open.to, open.body);
            rig.run(opens_for_ms);
            hold(&mut rig, true);
            rig.run(50);
            assert_eq!(rig.valve_output(0), ValveOutput::Off);
            assert_eq!(rig.device.causes().valves[0], Cause::Rule(rule));
            rig.run(1_000);
            hold(&mut rig, false);
            rig.run_while(2_000, |rig| rig.valve_output(0) == ValveOutput::Off);
            let flags = rig.valve(SubsystemId::VALVE1);
            assert!((flags - ValveFlags::CLOSED).is_empty(), "{flags:?}");
            let open = Request::open(SubsystemId::VALVE1);
            rig.accepts(open.to, open.body);
            rig.run_until(6_000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::OPEN);
        }
    }
}
