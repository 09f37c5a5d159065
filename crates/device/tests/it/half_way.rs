//! §D/6 The switches of Deployer against its position: what is half-way is in between.

use crate::common::Rig;
use crate::deployer::{DEPLOYER, deploying, position, wrapped};
use lafet_device::Composition;
use lafet_device::image::{Axis, ValveOutput};
use lafet_proto::flags::{ControlFlags, DeployerFlags as F, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Quench};
use lafet_proto::{Status, SubsystemId};

/// §D/6 A barrel that is stopped half-way is in between, though a switch says otherwise: nothing aims, nothing opens, and
/// it is reported. In every profile, wherever it is stopped, by Stop or by Move Deployer.
#[test]
fn a_switch_that_sticks_half_way() {
    const WATER: Body<'static> = Body::Open { key: key::OPEN };
    for composition in [Composition::FULL, Composition::EX, Composition::LIMIT_SWITCH] {
        for upper in [true, false] {
            for run_ms in [800_u32, 1500, 3000, 5000] {
                for moves in [true, false] {
                    let mut rig = Rig::new(composition);
                    if upper {
                        rig.deploy();
                    }
                    let switches = &mut rig.plant.drive(Axis::Deployer).switches;
                    if upper {
                        switches.1 = -9000
                    } else {
                        switches.0 = 9000
                    }
                    rig.run(100);
                    let body = match (upper, moves) {
                        (true, true) => Body::Move { destination: 0 },
                        (true, false) => Body::Wrap,
                        (false, _) => Body::Deploy,
                    };
                    rig.accepts(DEPLOYER, body);
                    rig.run(run_ms);
                    let stop = rig.status(DEPLOYER, Body::Stop);
                    assert!(stop == Status::OK || !upper, "{stop:?}");
                    rig.run(200);
                    let what = format!("{} {upper} {run_ms} {moves}", composition.name);
                    assert_eq!(position(&mut rig), F::empty(), "{what}");
                    assert!(rig.deployer().contains(F::INTERNAL_FAULT), "{what}");
                    assert_eq!(rig.get(Param::GeneralInputFaults), Ok(vec![1 << 16]), "{what}");
                    let denied = (DEPLOYER, Status::DENIED);
                    for (to, body) in [
                        (SubsystemId::VERTICAL, Body::Move { destination: 60 }),
                        (SubsystemId::VALVE1, WATER),
                    ] {
                        assert_eq!(rig.one(to, body), denied, "{what}");
                    }
                    for body in [Body::Deploy, Body::Wrap] {
                        assert_eq!(rig.status(DEPLOYER, body), Status::MODULE_FAULT, "{what}");
                    }
                    rig.run_while(500, |rig| {
                        rig.is_still() && rig.valve_output(0) != ValveOutput::Opening
                    });
                }
            }
        }
    }
}

/// §D/6 Nor is it after a reset, half-way with a switch that sticks; a position that does not agree with a switch is reported in 40 ms.
#[test]
fn a_switch_that_sticks_over_a_reset() {
    for (at, switches, reported) in [
        (2700, (0, -9000), true),
        (2700, (9000, 5400), true),
        // A sixteenth of the way is 337'.
        (5064, (0, -9000), false),
        (5062, (0, -9000), true),
        (337, (9000, 5400), false),
        (338, (9000, 5400), true),
    ] {
        let mut rig = wrapped();
        rig.plant.place(Axis::Deployer, at);
        rig.plant.drive(Axis::Deployer).switches = switches;
        rig.power_cycle();
        // Its switch counts 30 ms later, and has to be contradicted for as long.
        rig.run(70);
        assert_eq!(position(&mut rig).is_empty(), reported, "{at}");
        assert_eq!(rig.deployer().contains(F::INTERNAL_FAULT), reported, "{at}");
        rig.run_while(500, |rig| position(rig).is_empty() == reported && rig.is_still());
    }
}

/// §D/6 A switch that blips half-way is no contradiction.
#[test]
fn a_blip_half_way_is_no_contradiction() {
    let mut rig = deploying();
    for ms in 0..300 {
        rig.now_ms += 1;
        rig.plant.advance(1);
        if ms % 100 < 30 {
            rig.plant.inputs.drives[Axis::Deployer as usize].max_switch = true;
        }
        rig.device.step(rig.now_ms, &mut rig.plant);
        assert_eq!(position(&mut rig), F::DEPLOYING, "{ms}");
    }
    assert!(!rig.deployer().contains(F::INTERNAL_FAULT));
}

/// §D/6 What extinguishes goes on when the position of a deployed barrel jumps or its sensor is lost: it has arrived, and has
/// not been driven. When it has been, the switch alone is not enough.
#[test]
fn a_position_that_is_lost_where_it_rests() {
    let losses: [fn(&mut Rig); 2] = [
        |rig| rig.plant.drive(Axis::Deployer).encoder_offset = -2700,
        |rig| {
            rig.plant.inputs.drives[Axis::Deployer as usize].position_sensor_fault = true;
        },
    ];
    for lose in losses {
        let mut rig = Rig::deployed();
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::OPEN);
        let quench = Quench::Program { program: 0, centre_h: 0, centre_v: 0, nozzle: 30 };
        rig.accepts(SubsystemId::CONTROL, Body::StartQuench(quench));
        rig.run(200);
        lose(&mut rig);
        rig.run_while(2000, |rig| {
            let flags = ControlFlags::from_bits_retain(rig.flags(SubsystemId::CONTROL));
            flags.contains(ControlFlags::QUENCH) && position(rig) == F::DEPLOYED
        });
    }
    // Lost on the way, with a switch that sticks: in between.
    let mut rig = Rig::deployed();
    rig.accepts(DEPLOYER, Body::Wrap);
    rig.run(200);
    rig.plant.drive(Axis::Deployer).switches.1 = -9000;
    rig.plant.inputs.drives[Axis::Deployer as usize].position_sensor_fault = true;
    rig.run(100);
    rig.run_while(500, |rig| rig.is_still() && position(rig) == F::empty());
    // It is back, and says where the barrel is.
    rig.plant.inputs.drives[Axis::Deployer as usize].position_sensor_fault = false;
    rig.run_until(200, |rig| position(rig) == F::DEPLOYED);
}
