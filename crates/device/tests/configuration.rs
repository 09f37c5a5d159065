//! §3.3.1 What the common flags tell of the configuration: values that contradict each other, and a
//! memory that fails twice.

mod common;

use common::Rig;
use lafet_device::Composition;
use lafet_proto::flags::CommonFlags;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Ints, Status, SubsystemId};

/// Where the first program of Control is stored.
const KEY_PROGRAM0: u16 = 15;

fn common(rig: &mut Rig, id: SubsystemId) -> CommonFlags {
    CommonFlags::from_bits_retain(rig.flags(id) & 0xFFFF) - CommonFlags::BAD_POWER
}

/// §3.3.1/2 The lower one above the higher shows as ConfigInvalid, of that subsystem alone; equal they
/// contradict nothing, and it goes when they agree again.
#[test]
fn thresholds_that_contradict() {
    let pairs = [
        (SubsystemId::GENERAL, Param::GeneralMainVoltageMin, Param::GeneralMainVoltageMax),
        (SubsystemId::CLIMATICS, Param::ClimaticsHeatOn, Param::ClimaticsHeatOff),
    ];
    for (id, low, high) in pairs {
        let mut rig = Rig::new(Composition::FULL);
        let most = rig.get(high).unwrap()[0];
        for (value, invalid) in [(most, false), (most + 1, true), (most - 1, false)] {
            assert_eq!(rig.set(low, value), Status::ACCEPTED);
            rig.run(50);
            let expected = if invalid { CommonFlags::CONFIG_INVALID } else { CommonFlags::empty() };
            assert_eq!(common(&mut rig, id), expected, "{low:?} {value}");
            assert!(common(&mut rig, SubsystemId::VERTICAL).is_empty());
        }
        // Also beside another fault of the memory.
        rig.set(low, most + 1);
        rig.run(50);
        rig.plant.store_fails = true;
        rig.set(Param::VerticalSpeed, 5);
        rig.run(50);
        assert_eq!(common(&mut rig, id), CommonFlags::CONFIG_INVALID);
    }
}

/// §3.3.1/1 What could neither be read nor be written again tells both.
#[test]
fn neither_read_nor_written() {
    let mut rig = Rig::new(Composition::FULL);
    let spec = Param::ControlProgram0.spec();
    let program = Body::SetParam { id: spec.id, values: Ints::Values(&[1, 2, 3, 4, 5, 6, 7]) };
    assert_eq!(rig.status(SubsystemId::CONTROL, program), Status::ACCEPTED);
    rig.run(50);
    rig.plant.damage(KEY_PROGRAM0);
    rig.power_cycle_and_settle();
    rig.plant.store_fails = true;
    assert_eq!(rig.status(SubsystemId::CONTROL, program), Status::ACCEPTED);
    rig.run(50);
    let both = CommonFlags::CONFIG_FAULT | CommonFlags::CONFIG_WRITE_FAULT;
    assert_eq!(common(&mut rig, SubsystemId::CONTROL), both);
    rig.plant.store_fails = false;
    assert_eq!(rig.status(SubsystemId::CONTROL, program), Status::ACCEPTED);
    rig.run(50);
    assert!(common(&mut rig, SubsystemId::CONTROL).is_empty());
}
