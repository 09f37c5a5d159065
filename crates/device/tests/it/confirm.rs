//! §D/8 Water that no client confirms, and what is never fed without end.

use crate::common::Rig;
use lafet_device::Composition;
use lafet_device::cause::{Cause, Rule};
use lafet_device::image::{Axis, ValveOutput};
use lafet_proto::flags::{Button, ButtonState, DriveFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Quench};
use lafet_proto::{Status, SubsystemId};

const VALVE: SubsystemId = SubsystemId::VALVE1;
const OPEN: Body<'static> = Body::Open { key: key::OPEN };
const CLOSE: Body<'static> = Body::Close { key: key::CLOSE };
const LIMIT_MS: u32 = 20_000;
const PROGRAM: Body<'static> =
    Body::StartQuench(Quench::Program { program: 0, centre_h: 0, centre_v: 0, nozzle: 30 });

/// A monitor whose valve has just been driven to open, with a limit of 20 s, at this time.
fn limited(now_ms: u32) -> Rig {
    let mut rig = Rig::at(Composition::REMOTE, now_ms);
    assert_eq!(rig.set(Param::GeneralWaterTimeout, 20), Status::ACCEPTED);
    rig.accepts(VALVE, OPEN);
    rig
}

fn closes(rig: &Rig) -> bool {
    rig.valve_output(0) == ValveOutput::Closing
}

fn told(rig: &mut Rig) -> bool {
    rig.get(Param::GeneralInputFaults).unwrap()[0] & 8 != 0
}

/// 20 s after the Open, not a step sooner, also while the clock wraps; its cause and the bit tell why, until
/// the next Open.
#[test]
fn closed_when_nobody_confirms() {
    for now_ms in [0, u32::MAX - 10_000] {
        let mut rig = limited(now_ms);
        let ms = rig.run_until(LIMIT_MS + 100, |rig| closes(rig));
        assert!((LIMIT_MS..LIMIT_MS + 30).contains(&ms), "{ms}");
        assert_eq!(rig.device.causes().valves[0], Cause::Rule(Rule::Unconfirmed));
        rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::CLOSED);
        assert!(told(&mut rig));
        rig.run_while(2 * LIMIT_MS, |rig| rig.valve_output(0) == ValveOutput::Off);
        rig.accepts(VALVE, OPEN);
        assert!(!told(&mut rig));
        rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::OPEN);
    }
}

/// What confirms, and what does not.
#[test]
fn what_confirms() {
    type Act = fn(&mut Rig);
    let acts: [(Act, bool); 9] = [
        (|rig| rig.accepts(VALVE, OPEN), true),
        (|rig| rig.accepts(SubsystemId::CONTROL, PROGRAM), true),
        (|rig| assert_eq!(rig.set(Param::GeneralWaterTimeout, 20), Status::OK), true),
        (
            |rig| {
                rig.plant.inputs.valves[0].open_sensor_fault = true;
                rig.run(20);
                assert_eq!(rig.status(VALVE, OPEN), Status::MODULE_FAULT);
            },
            true,
        ),
        (
            |rig| {
                rig.plant.inputs.main_voltage_dv = 90;
                rig.run(500);
                assert_eq!(rig.one(VALVE, OPEN).1, Status::DENIED);
                assert_eq!(rig.set(Param::GeneralWaterTimeout, 20), Status::OK);
            },
            true,
        ),
        (|rig| rig.plant.inputs.buttons[0][Button::Open as usize] = ButtonState::Pressed, true),
        (|rig| rig.move_to(Axis::Horizontal, 60), false),
        (|rig| assert_eq!(rig.status(VALVE, Body::Open { key: 1 }), Status::NEED_CONFIRM), false),
        (|rig| assert_eq!(rig.set(Param::GeneralMoveTimeout, 0), Status::OK), false),
    ];
    for (index, (act, confirms)) in acts.into_iter().enumerate() {
        let mut rig = limited(0);
        rig.run(15_000);
        act(&mut rig);
        rig.run_while(4000, |rig| !closes(rig));
        rig.run(2000);
        assert_eq!(
            closes(&rig) || rig.valve(VALVE).contains(ValveFlags::CLOSED),
            !confirms,
            "{index}"
        );
        let ms = rig.run_until(LIMIT_MS, |rig| closes(rig) || told(rig));
        assert_eq!(ms > 0, confirms, "{index}");
    }
}

/// By default nothing is closed; a valve left half open by Stop is; one that is closed is not driven; and a
/// shorter limit counts at once.
#[test]
fn what_it_concerns() {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.accepts(VALVE, OPEN);
    rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::OPEN);
    for _ in 0..100 {
        rig.step(60_000);
        assert_eq!(rig.valve_output(0), ValveOutput::Off);
    }
    assert_eq!(rig.set(Param::GeneralWaterTimeout, 60), Status::ACCEPTED);
    rig.run(10_000);
    assert_eq!(rig.set(Param::GeneralWaterTimeout, 5), Status::ACCEPTED);
    let ms = rig.run_until(6000, |rig| closes(rig));
    assert!((5000..5050).contains(&ms), "{ms}");
    rig.run(500);
    rig.accepts(VALVE, Body::Stop);
    rig.run_while(4000, |rig| rig.valve_output(0) == ValveOutput::Off);
    rig.run_until(1100, |rig| closes(rig));
    rig.run_until(6000, |rig| rig.valve(VALVE) == ValveFlags::CLOSED);
    rig.run_while(20_000, |rig| rig.valve_output(0) == ValveOutput::Off);
}

/// §3.3.5 The closing of what no client confirms goes on after an overload.
#[test]
fn an_overload_does_not_end_it() {
    let mut rig = limited(0);
    rig.run_until(LIMIT_MS + 100, |rig| closes(rig));
    rig.plant.valves[0].current_da = 80;
    rig.run_until(1000, |rig| rig.valve(VALVE).contains(ValveFlags::AMPERAGE_OVERLOAD));
    rig.plant.valves[0].current_da = 20;
    rig.run_until(8000, |rig| rig.valve(VALVE) == ValveFlags::CLOSED);
}

/// §1/3 A valve that the monitor does not have has no water to confirm, whatever its contacts say.
#[test]
fn an_absent_valve() {
    let chain = Composition::REMOTE.chain.without(&[SubsystemId::VALVE2]);
    let mut rig = Rig::new(Composition { chain, ..Composition::REMOTE });
    rig.plant.valves[1].opening_ms = 2000;
    assert_eq!(rig.set(Param::GeneralWaterTimeout, 20), Status::ACCEPTED);
    rig.run_while(2 * LIMIT_MS, |rig| !told(rig));
}

/// §3.3.5 One that cannot close is driven for one attempt, however short the limit is.
#[test]
fn in_vain() {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.set(Param::Valve1TravelTime, 4000);
    rig.accepts(VALVE, OPEN);
    rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::OPEN);
    rig.plant.valves[0].jammed = true;
    rig.set(Param::GeneralWaterTimeout, 1);
    let mut fed_ms = 0;
    for _ in 0..60_000 {
        rig.step(1);
        fed_ms += u32::from(rig.valve_output(0) != ValveOutput::Off);
    }
    assert!((5900..6100).contains(&fed_ms), "{fed_ms}");
    assert!(rig.valve(VALVE).contains(ValveFlags::INTERNAL_FAULT) && told(&mut rig));
}

/// §3.3.5 Open asked for again and again while the motor is overloaded, and Close too: it is fed for a
/// small part of the time only.
#[test]
fn a_valve_is_not_fed_without_end() {
    for (body, most) in [(OPEN, 12), (CLOSE, 50)] {
        let mut rig = Rig::new(Composition::REMOTE);
        rig.set(Param::Valve1TravelTime, 4000);
        rig.accepts(VALVE, OPEN);
        rig.run(2000);
        rig.all_accept(Body::Stop);
        rig.plant.valves[0].jammed = true;
        rig.plant.valves[0].current_da = 100;
        let mut fed = 0;
        for ms in 0..60_000_u32 {
            if ms % 100 == 0 {
                rig.one(VALVE, body);
            }
            rig.step(1);
            fed += u32::from(rig.valve_output(0) != ValveOutput::Off);
        }
        assert!(fed * 100 / 60_000 <= most, "{body:?}: {fed} ms");
    }
}

/// §D/9 A drive that sticks on its last stretch is fed more, and reported when that does not move it.
#[test]
fn a_drive_is_not_fed_without_end() {
    for axis in [Axis::Vertical, Axis::Horizontal] {
        let mut rig = Rig::new(Composition::REMOTE);
        rig.move_to(axis, 300);
        rig.run_until(20_000, |rig| rig.plant.position(axis) > 290 && rig.speed(axis) < 5);
        rig.plant.drive(axis).jammed = true;
        rig.plant.drive(axis).current_da = 20;
        let ms = rig.run_until(6000, |rig| rig.is_still());
        assert!((500..1000).contains(&ms), "{ms}");
        assert_eq!(rig.device.causes().drives[axis as usize], Cause::Rule(Rule::Fault));
        rig.run_while(5000, |rig| rig.is_still());
        assert!(rig.drive_flags(axis).contains(DriveFlags::INTERNAL_FAULT));
    }
}
