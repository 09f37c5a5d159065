//! A remote unit that is lost just after its valve or drive was driven: its last picture is from before.

use crate::common::Rig;
use lafet_device::Composition;
use lafet_device::image::{Axis, Inputs, Unit, ValveOutput};
use lafet_proto::flags::{Button, ButtonState, DeployerFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};

const OPEN: Body<'static> = Body::Open { key: key::OPEN };
const CLOSE: Body<'static> = Body::Close { key: key::CLOSE };
const VALVE: SubsystemId = SubsystemId::VALVE1;
const DEPLOYER: SubsystemId = SubsystemId::DEPLOYER;

/// How a unit goes, and comes back.
type Goes = fn(&mut Rig, Unit, bool);
const WAYS: [Goes; 2] = [
    |rig, unit, gone| rig.plant.units[unit as usize].offline = gone,
    |rig, unit, gone| rig.plant.inputs.units[unit as usize].protocol_fault = gone,
];

/// What a monitor does behind an opening.
type Then = fn(&mut Rig);
const STOPS: [Then; 2] = [
    |rig| rig.accepts(VALVE, Body::Stop),
    |rig| {
        rig.ask(SubsystemId::ALL, Body::Stop);
    },
];
const CLOSES: [Then; 2] = [
    |rig| rig.accepts(VALVE, CLOSE),
    |rig| rig.plant.inputs.buttons[0][Button::Close as usize] = ButtonState::Pressed,
];

fn rig() -> Rig {
    let mut rig = Rig::new(Composition::EX);
    rig.deploy();
    rig.run(500);
    rig
}

/// Time passes, and the pictures of the valve and of Deployer stay.
fn stale(rig: &mut Rig, ms: u32) {
    let Inputs { valves: [valve, _], drives: [.., deployer], .. } = rig.plant.inputs.clone();
    for _ in 0..ms / 10 {
        rig.now_ms += 10;
        rig.plant.advance(10);
        (rig.plant.inputs.valves[0], rig.plant.inputs.drives[3]) = (valve, deployer);
        rig.device.step(rig.now_ms, &mut rig.plant);
    }
}

/// A valve that was opened for 20 ms, and what came then, and whose unit is lost so long after it, ms.
fn opened_and_lost(then: Then, goes: Goes, after_ms: u32) -> Rig {
    let mut rig = rig();
    rig.accepts(VALVE, OPEN);
    stale(&mut rig, 20);
    assert!(rig.plant.valves[0].opening_ms > 0 && rig.valve_output(0) == ValveOutput::Opening);
    then(&mut rig);
    stale(&mut rig, after_ms);
    assert!(rig.plant.inputs.valves[0].close_switch);
    goes(&mut rig, Unit::Valve1, true);
    stale(&mut rig, 110);
    rig
}

/// How long after it a unit may be lost: a bus that waits has waited, and broken exchanges count from the first on.
fn afters() -> impl Iterator<Item = (Goes, u32)> {
    let [silent, broken] = WAYS;
    [(silent, 10), (silent, 100), (silent, 190), (broken, 10), (broken, 90)].into_iter()
}

/// Opened and stopped it may be open, whatever its last picture says: nothing folds until it is seen closed.
#[test]
fn a_valve_that_was_opened_and_stopped() {
    for (then, (goes, after_ms)) in
        STOPS.into_iter().flat_map(|then| afters().map(move |it| (then, it)))
    {
        let mut rig = opened_and_lost(then, goes, after_ms);
        let flags = rig.valve(VALVE) - ValveFlags::PROTOCOL_FAULT;
        assert_eq!(flags, ValveFlags::CONN_LOST, "{after_ms}");
        assert_eq!(rig.one(DEPLOYER, Body::Wrap), (VALVE, Status::DENIED), "{after_ms}");
        stale(&mut rig, 5000);
        assert!(!rig.valve(VALVE).contains(ValveFlags::CLOSED), "{after_ms}");
        goes(&mut rig, Unit::Valve1, false);
        rig.run(50);
        assert!(rig.valve(VALVE).is_empty(), "it stays where it is");
        rig.accepts(VALVE, CLOSE);
        rig.run_until(500, |rig| rig.valve(VALVE) == ValveFlags::CLOSED);
        rig.accepts(DEPLOYER, Body::Wrap);
    }
}

/// Opened and closed again it is driven on, and what is owed is done when the unit is back.
#[test]
fn a_valve_that_was_opened_and_closed() {
    for (then, (goes, after_ms)) in
        CLOSES.into_iter().flat_map(|then| afters().map(move |it| (then, it)))
    {
        let mut rig = opened_and_lost(then, goes, after_ms);
        let flags = rig.valve(VALVE) - ValveFlags::PROTOCOL_FAULT;
        assert_eq!(flags, ValveFlags::CONN_LOST | ValveFlags::CLOSING, "{after_ms}");
        assert_eq!(rig.one(DEPLOYER, Body::Wrap), (VALVE, Status::DENIED), "{after_ms}");
        // What the unit has not heard of has left the valve open.
        rig.plant.valves[0].opening_ms = 300;
        rig.plant.valves[0].jammed = true;
        stale(&mut rig, 60_000);
        rig.plant.valves[0].jammed = false;
        goes(&mut rig, Unit::Valve1, false);
        rig.run_until(1000, |rig| rig.valve(VALVE) == ValveFlags::CLOSED);
    }
}

/// A picture from before an opening ends no Close: the valve is driven until it has been seen closed since.
#[test]
fn a_close_that_an_old_picture_ends() {
    for then in CLOSES {
        let mut rig = rig();
        rig.accepts(VALVE, OPEN);
        stale(&mut rig, 100);
        then(&mut rig);
        stale(&mut rig, 50);
        assert_eq!(rig.valve(VALVE), ValveFlags::CLOSING);
        rig.plant.valves[0].opening_ms = 500;
        rig.run_until(1000, |rig| rig.valve(VALVE) == ValveFlags::CLOSED);
        rig.run_while(500, |rig| rig.valve_output(0) == ValveOutput::Off);
    }
}

/// What has been seen closed for long enough is closed, lost or not.
#[test]
fn a_valve_that_was_opened_long_ago() {
    let [silent, _] = WAYS;
    let mut rig = rig();
    rig.accepts(VALVE, OPEN);
    rig.run(10);
    rig.accepts(VALVE, CLOSE);
    rig.run(250);
    assert_eq!(rig.valve(VALVE), ValveFlags::CLOSED);
    silent(&mut rig, Unit::Valve1, true);
    rig.run(50);
    assert_eq!(rig.valve(VALVE), ValveFlags::CLOSED | ValveFlags::CONN_LOST);
}

/// An opening has ended with its unit: that it does not arrive in its time is no fault of the switch there.
#[test]
fn no_false_sensor_fault() {
    let faults = ValveFlags::OPEN_SENSOR_FAULT | ValveFlags::INTERNAL_FAULT;
    for goes in WAYS {
        for (at_ms, lost_ms) in [(10, 200), (100, 20_000), (1000, 40_000), (3900, 20_000)] {
            let mut rig = rig();
            rig.accepts(VALVE, OPEN);
            rig.run(at_ms);
            goes(&mut rig, Unit::Valve1, true);
            rig.run_while(lost_ms, |rig| !rig.valve(VALVE).intersects(faults));
            goes(&mut rig, Unit::Valve1, false);
            rig.run_while(20_000, |rig| !rig.valve(VALVE).intersects(faults));
            rig.accepts(VALVE, OPEN);
            rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::OPEN);
        }
    }
}

/// A Deployer that has just been driven out of its position and is lost is in between: nothing aims, nothing opens.
#[test]
fn a_deployer_that_was_driven() {
    let shown = DeployerFlags::DEPLOYED | DeployerFlags::WRAPPED;
    for (goes, after_ms) in afters() {
        let mut rig = rig();
        rig.accepts(DEPLOYER, Body::Wrap);
        while rig.speed(Axis::Deployer) == 0 {
            stale(&mut rig, 10);
        }
        stale(&mut rig, 20);
        rig.accepts(DEPLOYER, Body::Stop);
        stale(&mut rig, after_ms);
        goes(&mut rig, Unit::Deployer, true);
        stale(&mut rig, 110);
        assert!(!rig.deployer().intersects(shown), "{after_ms}");
        assert_eq!(rig.one(VALVE, OPEN), (DEPLOYER, Status::DENIED), "{after_ms}");
        stale(&mut rig, 1000);
        assert!(!rig.deployer().intersects(shown), "{after_ms}");
        goes(&mut rig, Unit::Deployer, false);
        rig.plant.place(Axis::Deployer, 5400);
        rig.run_until(500, |rig| rig.deployer().contains(DeployerFlags::DEPLOYED));
    }
    // At rest where it was, it is believed.
    let mut rig = rig();
    rig.plant.units[Unit::Deployer as usize].offline = true;
    rig.run(200);
    assert!(rig.deployer().contains(DeployerFlags::DEPLOYED | DeployerFlags::CONN_LOST));
}
