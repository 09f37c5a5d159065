//! What is stored, what is said of it (§3.5/9), and what the common flags tell (§3.3.1): values that
//! contradict each other, and a memory that fails twice.

use crate::common::{Plant, Rig};
use lafet_device::Composition;
use lafet_proto::flags::{CommonFlags, GeneralFlags};
use lafet_proto::id::key;
use lafet_proto::param::{Param, Storage};
use lafet_proto::request::Body;
use lafet_proto::{Ints, Status, SubsystemId};

/// Where the first program of Control is stored.
const KEY_PROGRAM0: u16 = 15;
/// Where the lockout is.
const KEY_LOCKOUT: u16 = 32;

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

/// §3.5/1, §3.5/9 Ok is said only of what is in the memory: not of a program that was never stored,
/// nor twice in a row before it could be; a program of which one number changes is stored again.
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
        // A damaged one reads zeros, which are not what is there.
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

/// §3.3.1/1 What could neither be read nor be written again reports both.
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

/// §3.3.1/2, §3.19/3 That parameters are unset is reported from the first moment, before anything has been
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

/// §3.3.1/4, §3.5 A bound that makes the supply bad, even one that was stored while it was good, can always
/// be set back, locked out too: it takes effect in the next step, and is stored then.
#[test]
fn a_bound_of_the_supply_does_not_lock_itself() {
    const OPEN: Body<'static> = Body::Open { key: key::OPEN };
    let bad = |rig: &mut Rig| rig.general().flags.contains(GeneralFlags::BAD_POWER);
    let bounds = [(Param::GeneralMainVoltageMin, 30), (Param::GeneralMainVoltageMax, 20)];
    for ((bound, value), locked) in bounds.into_iter().flat_map(|b| [(b, false), (b, true)]) {
        let mut rig = Rig::new(Composition::REMOTE);
        let good = rig.get(bound).unwrap()[0];
        rig.plant.inputs.main_voltage_dv = u16::try_from(10 * value).unwrap();
        assert_eq!(rig.set(bound, value), Status::ACCEPTED);
        rig.run(50);
        assert_eq!(rig.set(bound, value), Status::OK, "stored");
        rig.plant.inputs.main_voltage_dv = 240;
        if locked {
            rig.all_accept(Body::Lockout { key: key::ENABLE });
        }
        rig.power_cycle_and_settle();
        rig.run(500);
        assert!(bad(&mut rig));
        assert_eq!(rig.get(bound), Ok(vec![value]));
        assert_eq!(rig.one(SubsystemId::VALVE1, OPEN).1, Status::DENIED);
        assert_eq!(rig.set(bound, good), Status::ACCEPTED);
        rig.run(50);
        assert!(!bad(&mut rig));
        assert_eq!(rig.set(bound, good), Status::OK, "stored");
        rig.power_cycle_and_settle();
        assert!(!bad(&mut rig));
        assert_eq!(rig.get(bound), Ok(vec![good]));
        if locked {
            rig.all_accept(Body::Lockout { key: key::DISABLE });
        }
        rig.run(300);
        rig.accepts(SubsystemId::VALVE1, OPEN);
    }
}

/// §3.3.1/4 On a bad supply nothing is written but the lockout, at a Restart too, and nothing is erased.
#[test]
fn what_is_written_on_a_bad_supply() {
    for locked in [false, true] {
        let mut rig = Rig::new(Composition::REMOTE);
        rig.plant.inputs.main_voltage_dv = 90;
        rig.run(50);
        let mut memory = rig.plant.memory.clone();
        if locked {
            rig.all_accept(Body::Lockout { key: key::ENABLE });
        }
        assert_eq!(rig.set(Param::GeneralMoveTimeout, 5000), Status::ACCEPTED);
        rig.run(1000);
        if locked {
            let stored = rig.plant.memory.get(&KEY_LOCKOUT).cloned().unwrap();
            assert_ne!(memory.insert(KEY_LOCKOUT, stored.clone()), Some(stored));
        } else {
            rig.all_accept(Body::Restart);
        }
        rig.run(1000);
        assert_eq!(rig.plant.memory, memory);
        assert_eq!(rig.plant.resets, u32::from(!locked));
        assert_eq!(rig.get(Param::GeneralMoveTimeout), Ok(vec![if locked { 5000 } else { 0 }]));
        rig.plant.inputs.main_voltage_dv = 240;
        rig.run(100);
        assert_eq!(rig.plant.memory == memory, !locked);
    }
    let mut rig = Rig::new(Composition::REMOTE);
    let memory = rig.plant.memory.clone();
    rig.accepts(SubsystemId::GENERAL, Body::CleanFlash { key: key::CLEAN_FLASH });
    rig.plant.inputs.main_voltage_dv = 90;
    rig.run(1000);
    assert_eq!((&rig.plant.memory, rig.plant.resets), (&memory, 0));
    assert!(rig.general().flags.contains(GeneralFlags::CONFIG_WRITE_FAULT));
}
