//! What is stored, what is said of it (§3.5/9), and what the common flags tell (§3.3.1): values that
//! contradict each other, and a memory that fails twice.

use crate::common::{Plant, Rig};
use lafet_device::Composition;
use lafet_proto::flags::CommonFlags;
use lafet_proto::param::{Param, Storage};
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

fn program(values: &[i32; 7]) -> Body<'_> {
    Body::SetParam { id: Param::ControlProgram0.spec().id, values: Ints::Values(values) }
}

/// §3.5/1, §3.5/9 Ok is said only of what stands in the memory: not of a program that was never stored,
/// nor twice in a row before it could be; a program of which one number changes is stored anew.
#[test]
fn ok_only_when_stored() {
    let control = SubsystemId::CONTROL;
    for first in [[0; 7], [1, 2, 3, 4, 5, 6, 7]] {
        let mut rig = Rig::new(Composition::FULL);
        for status in [Status::ACCEPTED, Status::ACCEPTED] {
            assert_eq!(rig.status(control, program(&first)), status);
        }
        rig.run(50);
        assert_eq!(rig.status(control, program(&first)), Status::OK);
        for index in 0..7 {
            let mut other = first;
            other[index] = 9;
            assert_eq!(rig.status(control, program(&other)), Status::ACCEPTED);
            rig.run(50);
            rig.power_cycle_and_settle();
            assert_eq!(rig.get(Param::ControlProgram0), Ok(other.to_vec()));
            assert_eq!(rig.status(control, program(&first)), Status::ACCEPTED);
            rig.run(50);
        }
        // A damaged one reads zeros, which are not what stands there.
        rig.plant.damage(KEY_PROGRAM0);
        rig.power_cycle_and_settle();
        assert_eq!(rig.get(Param::ControlProgram0), Ok(vec![0; 7]));
        assert_eq!(rig.status(control, program(&[0; 7])), Status::ACCEPTED);
        rig.run(50);
        assert!(common(&mut rig, control).is_empty());
    }
}

/// §3.5 A subsystem's numbers are stored, six bytes each, and nothing besides.
#[test]
fn a_set_is_its_numbers() {
    let rig = Rig::new(Composition::FULL);
    for (place, id) in SubsystemId::TABLE.into_iter().enumerate() {
        let numbers = Param::of(id).map(Param::spec);
        let numbers = numbers.filter(|spec| spec.storage == Storage::Stored && spec.max_len == 1);
        let stored = rig.plant.memory.get(&(place as u16 + 1)).map(Vec::len);
        assert_eq!(stored, Some(6 * numbers.count() + 2), "{id}");
    }
}

/// §3.3.1/1 What could neither be read nor be written again tells both.
#[test]
fn neither_read_nor_written() {
    let mut rig = Rig::new(Composition::FULL);
    let program = program(&[1, 2, 3, 4, 5, 6, 7]);
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

/// §3.3.1/2, §3.19/3 That parameters are unset is told from the first moment, before anything has been
/// sensed, and of each subsystem that has some.
#[test]
fn unset_from_the_first_moment() {
    let plant = Plant::of(&Composition::FULL);
    let mut rig = Rig::power_up(Composition::FULL, plant, 0);
    for id in SubsystemId::CHAIN {
        let has_some = Param::ALL.iter().any(|param| {
            let spec = param.spec();
            spec.subsystem == id && spec.storage == Storage::Stored
        });
        let flags = CommonFlags::from_bits_retain(rig.flags(id) & 0xFFFF);
        assert_eq!(flags.contains(CommonFlags::CONFIG_INVALID), has_some, "{id}: {flags:?}");
    }
}
