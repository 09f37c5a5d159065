//! §D/6 Water that flows against valves that say closed, and a folded barrel.

use crate::common::Rig;
use lafet_device::Composition;
use lafet_device::image::{Axis, ValveOutput};
use lafet_proto::flags::{DeployerFlags, ValveFlags as F};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};

const VALVE: SubsystemId = SubsystemId::VALVE1;
const OPEN: Body<'static> = Body::Open { key: key::OPEN };
const CLOSE: Body<'static> = Body::Close { key: key::CLOSE };

/// §D/6, §3.11/6 What flows forbids to fold, from the first step on; less than the meter knows does not.
#[test]
fn flow_forbids_folding() {
    for (flow_lps, folds) in [(0, true), (1, true), (2, false), (40, false)] {
        let mut rig = Rig::deployed();
        rig.plant.inputs.flow_lps = flow_lps;
        rig.run(10);
        let (from, status) = rig.one(SubsystemId::DEPLOYER, Body::Wrap);
        let expected = match folds {
            true => (SubsystemId::DEPLOYER, Status::ACCEPTED),
            false => (VALVE, Status::DENIED),
        };
        assert_eq!((from, status), expected, "{flow_lps}");
        rig.run(500);
        assert_eq!(rig.speed(Axis::Deployer) < 0, folds, "{flow_lps}");
    }
}

/// §D/5 A barrel that folds when water comes stays where it is, until there is none.
#[test]
fn flow_holds_a_folding_barrel() {
    let mut rig = Rig::deployed();
    rig.accepts(SubsystemId::DEPLOYER, Body::Wrap);
    rig.run(1000);
    assert!(rig.speed(Axis::Deployer) < 0);
    rig.plant.inputs.flow_lps = 20;
    rig.run_while(2000, |rig| rig.speed(Axis::Deployer) == 0);
    rig.plant.inputs.flow_lps = 0;
    rig.run_until(20_000, |rig| rig.deployer().contains(DeployerFlags::WRAPPED));
}

/// §D/5, §3.11/6 Water that lasts ends the wrapping in between, and is no fault of Deployer: when it has ended, Wrap
/// goes on. Water that ends in time takes nothing of the time to fold.
#[test]
fn water_is_no_fault_of_the_deployer() {
    let folding = || {
        let mut rig = Rig::deployed();
        rig.accepts(SubsystemId::DEPLOYER, Body::Wrap);
        rig.run(1000);
        rig.plant.inputs.flow_lps = 20;
        rig
    };
    let dry = |rig: &mut Rig| {
        rig.plant.inputs.flow_lps = 0;
        let closed = [VALVE, SubsystemId::VALVE2];
        rig.run_until(5000, |rig| closed.iter().all(|id| rig.valve(*id) == F::CLOSED));
        rig.accepts(SubsystemId::DEPLOYER, Body::Wrap);
        rig.run_until(20_000, |rig| rig.deployer().contains(DeployerFlags::WRAPPED));
    };
    let mut rig = folding();
    rig.run_while(19_000, |rig| rig.deployer().contains(DeployerFlags::WRAPPING));
    let mut in_time = rig.clone();
    rig.run(3000);
    let none = DeployerFlags::WRAPPING | DeployerFlags::INTERNAL_FAULT;
    assert!(!rig.deployer().intersects(none), "{:?}", rig.deployer());
    // What was given up does not begin by itself when the water ends.
    rig.plant.inputs.flow_lps = 0;
    rig.run_while(1000, |rig| rig.speed(Axis::Deployer) == 0);
    dry(&mut rig);
    dry(&mut in_time);
    assert!(!in_time.deployer().contains(DeployerFlags::INTERNAL_FAULT));
}

/// §D/5 A flow that flickers about what a meter shows gives no time back: wrapping ends after TravelTime of folding and
/// TravelTime of waiting at the latest.
#[test]
fn a_flow_that_flickers_ends_the_wrapping() {
    let mut rig = Rig::deployed();
    rig.accepts(SubsystemId::DEPLOYER, Body::Wrap);
    rig.run(1000);
    let mut ms = 1000;
    while rig.deployer().contains(DeployerFlags::WRAPPING) {
        rig.plant.inputs.flow_lps = if ms % 400 < 20 { 0 } else { 20 };
        rig.run(10);
        ms += 10;
        assert!(ms < 41_000, "{:?}", rig.deployer());
    }
    assert!(ms > 20_000, "{ms}");
    let wrong = DeployerFlags::WRAPPED | DeployerFlags::INTERNAL_FAULT;
    assert!(!rig.deployer().intersects(wrong), "{:?}", rig.deployer());
}

/// §3.1/9, §D/5 A Move of Deployer towards the standby position ends where water holds it: nothing folds by itself when
/// the water has ended, however late that is.
#[test]
fn water_ends_a_move_of_the_deployer() {
    let mut rig = Rig::deployed();
    rig.move_to(Axis::Deployer, 0);
    rig.run(1000);
    assert!(rig.speed(Axis::Deployer) < 0);
    rig.plant.inputs.flow_lps = 20;
    rig.run_while(60_000, |rig| rig.speed(Axis::Deployer) == 0);
    rig.plant.inputs.flow_lps = 0;
    rig.run_while(5000, |rig| rig.speed(Axis::Deployer) == 0);
    rig.move_to(Axis::Deployer, 0);
    rig.run(500);
    assert!(rig.speed(Axis::Deployer) < 0);
}

/// §D/6 Its lasting is a fault of the switches, which ends with it; and does not refuse Open.
#[test]
fn flow_contradicts_the_switches() {
    let mut rig = Rig::deployed();
    rig.plant.inputs.flow_lps = 40;
    rig.run_while(2900, |rig| rig.valve(VALVE) == F::CLOSED);
    rig.run(200);
    for id in [SubsystemId::VALVE1, SubsystemId::VALVE2] {
        assert_eq!(rig.valve(id), F::CLOSE_SENSOR_FAULT);
    }
    assert_eq!(rig.get(Param::GeneralInputFaults), Ok(vec![1]));
    // §3.9/2 A stuck switch does not end the Close.
    rig.accepts(VALVE, CLOSE);
    rig.run_while(1000, |rig| rig.valve_output(0) == ValveOutput::Closing);
    // Nor does it keep the water off, should it be the meter that is wrong.
    rig.accepts(VALVE, OPEN);
    rig.run_until(5000, |rig| rig.valve(VALVE).contains(F::OPEN));
    rig.accepts(VALVE, CLOSE);
    rig.run(5000);
    rig.plant.inputs.flow_lps = 0;
    rig.run_until(4000, |rig| rig.valve(VALVE) == F::CLOSED);
    assert_eq!(rig.get(Param::GeneralInputFaults), Ok(vec![0]));
}

/// §D/6 A valve that is open without flow and pressure is reported, and goes on as it is.
#[test]
fn no_water() {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.accepts(VALVE, OPEN);
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::OPEN);
    rig.run(9900);
    assert_eq!(rig.get(Param::GeneralInputFaults), Ok(vec![0]));
    rig.run(200);
    assert_eq!(rig.get(Param::GeneralInputFaults), Ok(vec![2]));
    assert_eq!(rig.valve(VALVE), F::OPEN);
    rig.plant.inputs.flow_lps = 20;
    rig.run(10_100);
    assert_eq!(rig.get(Param::GeneralInputFaults), Ok(vec![0]));
}
