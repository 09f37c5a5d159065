//! §D/6 Contacts that bounce and blip, in what they decide: for 1 to 30 ms nothing, then everything.

use crate::common::Rig;
use lafet_device::Composition;
use lafet_device::image::{Axis, Inputs, ValveOutput};
use lafet_proto::flags::{ControlFlags, DeployerFlags, DriveFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::request::{Body, Quench};
use lafet_proto::{Status, SubsystemId};

const VALVE: SubsystemId = SubsystemId::VALVE1;
const OPEN: Body<'static> = Body::Open { key: key::OPEN };
const CLOSE: Body<'static> = Body::Close { key: key::CLOSE };

/// What is sensed is changed like this for some milliseconds, a millisecond a step.
fn blip(rig: &mut Rig, ms: u32, change: impl Fn(&mut Inputs)) {
    for _ in 0..ms {
        rig.now_ms += 1;
        rig.plant.advance(1);
        change(&mut rig.plant.inputs);
        rig.device.step(rig.now_ms, &mut rig.plant);
    }
}

/// Half-way through an opening or a closing.
fn half_way(body: Body<'_>) -> Rig {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.accepts(VALVE, OPEN);
    if body == CLOSE {
        rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::OPEN);
        rig.accepts(VALVE, CLOSE);
    }
    rig.run(500);
    rig
}

/// §3.9/2 A blip of the closed switch does not end a Close, one of the open switch no Open; a switch that
/// stays does.
#[test]
fn valve_switches() {
    for ms in [1, 2, 10, 29, 30] {
        let mut rig = half_way(CLOSE);
        blip(&mut rig, ms, |inputs| inputs.valves[0].close_switch = true);
        assert_eq!(rig.valve_output(0), ValveOutput::Closing, "{ms}");
        rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::CLOSED);
        assert_eq!(rig.plant.valves[0].opening_ms, 0);

        let mut rig = half_way(OPEN);
        blip(&mut rig, ms, |inputs| inputs.valves[0].open_switch = true);
        assert_eq!(rig.valve_output(0), ValveOutput::Opening, "{ms}");
        rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::OPEN);
    }
    let mut rig = half_way(CLOSE);
    blip(&mut rig, 31, |inputs| inputs.valves[0].close_switch = true);
    assert_eq!(rig.valve_output(0), ValveOutput::Off);
}

/// §3.9/2 A valve that has just left its switch is not closed: a Close that comes then drives it.
#[test]
fn close_just_after_open() {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.accepts(VALVE, OPEN);
    rig.run(30);
    assert!(rig.plant.valves[0].opening_ms > 0);
    rig.accepts(VALVE, CLOSE);
    rig.run(200);
    assert_eq!((rig.plant.valves[0].opening_ms, rig.valve(VALVE)), (0, ValveFlags::CLOSED));
}

/// §3.3.5/1 A blip of the hardware block ends no opening; a block that stays does, and nothing opens by
/// itself when it is gone.
#[test]
fn blocked() {
    for (ms, opens) in [(1, true), (10, true), (30, true), (31, false), (100, false)] {
        let mut rig = half_way(OPEN);
        blip(&mut rig, ms, |inputs| inputs.valves[0].blocked = true);
        rig.plant.inputs.valves[0].blocked = false;
        rig.run(100);
        assert_eq!(rig.valve_output(0) == ValveOutput::Opening, opens, "{ms}");
    }
}

/// §3.3.4/2 An end switch that blips holds the drive for that moment and ends nothing; one that stays ends
/// the Move, and the drive has not gone on meanwhile.
#[test]
fn end_switches() {
    for (ms, goes_on) in [(1, true), (10, true), (30, true), (31, false)] {
        for way in [1_i16, -1] {
            let mut rig = Rig::new(Composition::REMOTE);
            rig.move_to(Axis::Horizontal, 9000 * way);
            rig.run(1000);
            let at = rig.plant.position(Axis::Horizontal);
            let up = way > 0;
            for _ in 0..ms {
                rig.now_ms += 1;
                rig.plant.advance(1);
                let input = &mut rig.plant.inputs.drives[Axis::Horizontal as usize];
                (input.min_switch, input.max_switch) = (!up, up);
                rig.device.step(rig.now_ms, &mut rig.plant);
                assert_eq!(rig.speed(Axis::Horizontal), 0);
            }
            assert!((rig.plant.position(Axis::Horizontal) - at).abs() <= 2);
            rig.run(100);
            let moves = rig.drive_flags(Axis::Horizontal).contains(DriveFlags::MOVE);
            assert_eq!(moves, goes_on, "{ms}");
        }
    }
}

/// §3.14 The deployed switch blips while extinguishing: the program goes on, and so does the water. Gone for
/// longer, it ends with ModeFault.
#[test]
fn deployed_switch() {
    for (ms, goes_on) in [(1, true), (10, true), (30, true), (31, false)] {
        let mut rig = Rig::deployed();
        rig.accepts(VALVE, OPEN);
        rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::OPEN);
        let quench = Quench::Program { program: 0, centre_h: 0, centre_v: 0, nozzle: 30 };
        rig.accepts(SubsystemId::CONTROL, Body::StartQuench(quench));
        rig.run(500);
        blip(&mut rig, ms, |inputs| {
            inputs.drives[Axis::Deployer as usize].max_switch = false;
        });
        rig.run(100);
        let control = ControlFlags::from_bits_retain(rig.flags(SubsystemId::CONTROL));
        assert_eq!(control.contains(ControlFlags::QUENCH), goes_on, "{ms}: {control:?}");
        assert_eq!(control.contains(ControlFlags::MODE_FAULT), !goes_on, "{ms}: {control:?}");
        assert!(rig.deployer().contains(DeployerFlags::DEPLOYED));
    }
}

/// §3.10/1 A barrel that bounces into its working position is deployed once.
#[test]
fn bounce_at_the_end() {
    for bounce_ms in [1, 7, 30] {
        let mut rig = Rig::new(Composition::FULL);
        rig.accepts(SubsystemId::DEPLOYER, Body::Deploy);
        rig.run_until(20_000, |rig| rig.plant.inputs.drives[Axis::Deployer as usize].max_switch);
        let (mut was, mut changes) = (false, 0);
        for ms in 0..200_u32 {
            rig.now_ms += 1;
            rig.plant.advance(1);
            let switch = &mut rig.plant.inputs.drives[Axis::Deployer as usize].max_switch;
            *switch = ms >= bounce_ms || ms.is_multiple_of(2);
            rig.device.step(rig.now_ms, &mut rig.plant);
            let is = rig.deployer().contains(DeployerFlags::DEPLOYED);
            changes += u32::from(is != was);
            was = is;
        }
        assert_eq!((was, changes), (true, 1), "{bounce_ms}");
        assert_eq!(rig.status(SubsystemId::DEPLOYER, Body::Deploy), Status::OK);
    }
}
