//! Parameters: reading, setting, storing, and a memory that fails.

use crate::common::{Plant, Rig, payload};
use lafet_device::image::{Axis, ValveOutput};
use lafet_device::{Composition, Device};
use lafet_proto::flags::{CommonFlags, ControlFlags, DriveFlags, GeneralFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::param::{Access, Param, Storage};
use lafet_proto::request::{Body, Quench};
use lafet_proto::{Bytes, Ints, ParamId, Request, Status, SubsystemId};

/// Where the values of each subsystem are stored, by its place in the table of §1; then programs,
/// trajectories, the correction table, the lockout.
const KEY_GENERAL: u16 = 1;
const KEY_VERTICAL: u16 = 3;
const KEY_CONTROL: u16 = 8;
const KEY_PROGRAM0: u16 = 15;
const KEY_TRAJECTORY0: u16 = 23;
const KEY_CORRECTION: u16 = 31;
const KEY_LOCKOUT: u16 = 32;

fn rig() -> Rig {
    Rig::new(Composition::FULL)
}

/// Nothing stored, as after CleanFlash.
fn erased() -> Rig {
    let plant = Plant::of(&Composition::FULL);
    let mut rig = Rig::power_up(Composition::FULL, plant, 0);
    rig.run(200);
    rig
}

fn set_values(rig: &mut Rig, param: Param, values: &[i32]) -> Status {
    let spec = param.spec();
    rig.status(spec.subsystem, Body::SetParam { id: spec.id, values: Ints::Values(values) })
}

fn common(rig: &mut Rig, id: SubsystemId) -> CommonFlags {
    // ConnLost of the interfaces is another test's business.
    CommonFlags::from_bits_retain(rig.flags(id) & 0xFFFF) - CommonFlags::CONN_LOST
}

/// Values that a parameter can have: the lowest or the highest.
fn extreme(param: Param, highest: bool) -> Vec<i32> {
    let spec = param.spec();
    (0..usize::from(spec.max_len))
        .map(|index| spec.element(index))
        .map(|element| if highest { element.max } else { element.min })
        .collect()
}

/// §3.3.1/4 A supply that is good when this bound of it has this value: on a bad one nothing is stored.
fn suit_supply(rig: &mut Rig, param: Param, value: i32) {
    let other = match param {
        Param::GeneralMainVoltageMin => Param::GeneralMainVoltageMax,
        Param::GeneralMainVoltageMax => Param::GeneralMainVoltageMin,
        _ => return,
    };
    rig.plant.inputs.main_voltage_dv = u16::try_from(10 * value).unwrap();
    assert_eq!(rig.set(other, value), Status::ACCEPTED);
}

/// The parameters of a monitor that has no update: the others of §U/9 are tested where there is one.
fn known() -> impl Iterator<Item = Param> {
    Param::ALL.into_iter().filter(|param| !param.name().starts_with("Software"))
}

/// §3.4, §3.5/1, §P/1 Every parameter reads its default; every value of its range is Accepted, reads
/// back at once, and is kept over power loss.
#[test]
fn every_parameter_is_kept() {
    let mut fresh = rig();
    for param in known() {
        let spec = param.spec();
        let default = match param {
            Param::GeneralAddress => vec![1],
            _ => vec![spec.default; usize::from(spec.min_len)],
        };
        assert_eq!(fresh.get(param), Ok(default), "{param:?}");
        // What is not stored is MoveHold, which lasts as long as its motion (§D/4).
        if spec.access == Access::ReadOnly || spec.storage == Storage::Volatile {
            continue;
        }
        for highest in [false, true] {
            let mut rig = fresh.clone();
            let values = extreme(param, highest);
            suit_supply(&mut rig, param, values[0]);
            let stored = spec.max_len == 1 && fresh.get(param).as_ref() == Ok(&values);
            let status = if stored { Status::OK } else { Status::ACCEPTED };
            assert_eq!(set_values(&mut rig, param, &values), status, "{param:?}");
            assert_eq!(rig.get(param).as_ref(), Ok(&values), "{param:?}");
            rig.run(20);
            assert!(rig.device.params().is_stored(), "{param:?}");
            // §3.5/9
            let written = rig.plant.written.len();
            assert_eq!(set_values(&mut rig, param, &values), Status::OK, "{param:?}");
            rig.run(20);
            assert_eq!(rig.plant.written.len(), written, "{param:?}");
            let general = param.spec().subsystem == SubsystemId::GENERAL;
            rig.power_cycle_and_settle();
            if rig.device.has(spec.subsystem) || general {
                assert_eq!(rig.get(param).as_ref(), Ok(&values), "{param:?}");
            }
        }
    }
}

/// §3.5/3, §3.5/4, §3.5/5, §3.5/2 What is not taken changes nothing and is not stored.
#[test]
fn what_is_refused() {
    let mut rig = rig();
    rig.run(100);
    let (memory, written) = (rig.plant.memory.clone(), rig.plant.written.len());
    for param in known() {
        let spec = param.spec();
        let before = rig.get(param);
        if spec.access == Access::ReadOnly {
            let values = vec![0; usize::from(spec.max_len)];
            assert_eq!(set_values(&mut rig, param, &values), Status::ACCESS_DENIED);
            assert_eq!(
                set_values(&mut rig, param, &[]),
                Status::ACCESS_DENIED,
                "before the number"
            );
            continue;
        }
        for index in 0..usize::from(spec.max_len) {
            for (highest, beyond) in [(true, 1), (false, -1)] {
                let mut values = extreme(param, highest);
                values[index] += beyond;
                assert_eq!(
                    set_values(&mut rig, param, &values),
                    Status::INVALID_VALUE,
                    "{param:?}"
                );
            }
        }
        for len in (0..=63).filter(|len| !spec.allows_len(*len)) {
            let wrong = set_values(&mut rig, param, &vec![spec.max; len]);
            assert_eq!(wrong, Status::WRONG_DATA, "{param:?} {len}");
        }
        assert_eq!(rig.get(param), before, "{param:?}");
    }
    for id in SubsystemId::TABLE {
        let unknown = ParamId(0xFFFF);
        let set = Body::SetParam { id: unknown, values: Ints::Values(&[1]) };
        for (body, size) in [(Body::GetParam { id: unknown }, 2), (set, 2)] {
            let answers = rig.ask(id, body);
            assert_eq!((answers[0].from, answers[0].status), (id, Status::INVALID_ID));
            assert_eq!(answers[0].data.len(), size);
        }
    }
    rig.run(500);
    assert_eq!((rig.plant.memory, rig.plant.written.len()), (memory, written));
}

/// §3.4/1 The same name is another parameter in another subsystem.
#[test]
fn ids_belong_to_their_subsystem() {
    let mut rig = rig();
    rig.set(Param::VerticalSpeed, 5);
    assert_eq!(rig.get(Param::HorizontalSpeed), Ok(vec![20]));
    let id = Param::GeneralMoveTimeout.spec().id;
    assert_eq!(rig.status(SubsystemId::VERTICAL, Body::GetParam { id }), Status::INVALID_ID);
}

/// §3.5/8 Marked "after Restart": nothing changes before it.
#[test]
fn effect_after_restart() {
    let mut rig = rig();
    assert_eq!(rig.set(Param::GeneralAddress, 77), Status::ACCEPTED);
    assert_eq!(rig.set(Param::GeneralChain, 0x3FBF), Status::ACCEPTED);
    assert_eq!(rig.set(Param::NozzleDriveType, 2), Status::ACCEPTED);
    rig.run(500);
    assert_eq!(rig.device.address(), 1);
    assert!(rig.device.has(SubsystemId::VALVE2));
    let off = Body::SwitchLimits { new_state: 1 };
    assert_eq!(rig.status(SubsystemId::NOZZLE, off), Status::OK);
    rig.all_accept(Body::Restart);
    rig.run(500);
    assert_eq!((rig.device.address(), rig.plant.resets), (77, 1));
    let status = rig.one(SubsystemId::VALVE2, Body::GetStatus);
    assert_eq!(status, (SubsystemId::VALVE2, Status::MODULE_NOT_EXIST));
    assert_eq!(rig.status(SubsystemId::NOZZLE, off), Status::NOT_SUPPORTED);
}

/// §3.12 Restart stores first whatever has been accepted: nothing is lost between answer and reset.
#[test]
fn restart_loses_nothing() {
    let mut rig = rig();
    let mut requests = Vec::new();
    for (param, value) in [
        (Param::VerticalSpeed, &[3][..]),
        (Param::HorizontalSpeed, &[4]),
        (Param::ClimaticsHeatOn, &[-100]),
        (Param::RadioTimeout, &[900]),
        (Param::ControlProgram7, &[1, 2, 3, 4, 5, 6, 7]),
    ] {
        let spec = param.spec();
        let body = Body::SetParam { id: spec.id, values: Ints::Values(value) };
        requests.push(Request::new(spec.subsystem, body));
    }
    requests.push(Request::new(SubsystemId::ALL, Body::Restart));
    rig.handle(&payload(&requests));
    // One long step: the reset is due before the queue could be written at its usual pace.
    rig.step(1000);
    assert_eq!(rig.plant.resets, 1);
    rig.run(200);
    assert_eq!(rig.get(Param::VerticalSpeed), Ok(vec![3]));
    assert_eq!(rig.get(Param::HorizontalSpeed), Ok(vec![4]));
    assert_eq!(rig.get(Param::ClimaticsHeatOn), Ok(vec![-100]));
    assert_eq!(rig.get(Param::RadioTimeout), Ok(vec![900]));
    assert_eq!(rig.get(Param::ControlProgram7), Ok(vec![1, 2, 3, 4, 5, 6, 7]));
}

/// §3.14/2, §3.15/2 Programs and trajectories: all eight of each, apart from one another; a shorter
/// trajectory replaces a longer one.
#[test]
fn programs_and_trajectories() {
    let programs = [
        Param::ControlProgram0,
        Param::ControlProgram1,
        Param::ControlProgram2,
        Param::ControlProgram3,
        Param::ControlProgram4,
        Param::ControlProgram5,
        Param::ControlProgram6,
        Param::ControlProgram7,
    ];
    let trajectories = [
        Param::ControlTrajectory0,
        Param::ControlTrajectory1,
        Param::ControlTrajectory2,
        Param::ControlTrajectory3,
        Param::ControlTrajectory4,
        Param::ControlTrajectory5,
        Param::ControlTrajectory6,
        Param::ControlTrajectory7,
    ];
    let program = |n: i32| [-n, 10 * n, 20 + n, 100 * n, 50 * n, n, 2 * n];
    let path = |n: i32, points: i32| -> Vec<i32> {
        (0..points).flat_map(|point| [-100 * n, 30 * point, 20 + point, n]).collect()
    };
    let mut rig = rig();
    for n in 0..8 {
        assert_eq!(set_values(&mut rig, programs[n], &program(n as i32)), Status::ACCEPTED);
        assert_eq!(set_values(&mut rig, trajectories[n], &path(n as i32, 15)), Status::ACCEPTED);
    }
    assert_eq!(set_values(&mut rig, trajectories[3], &path(3, 2)), Status::ACCEPTED);
    assert_eq!(set_values(&mut rig, trajectories[5], &[]), Status::ACCEPTED);
    rig.run(500);
    rig.power_cycle_and_settle();
    for n in 0..8 {
        assert_eq!(rig.get(programs[n]), Ok(program(n as i32).to_vec()));
        let points = [15, 15, 15, 2, 15, 0, 15, 15][n];
        assert_eq!(rig.get(trajectories[n]), Ok(path(n as i32, points)));
        assert_eq!(rig.device.params().trajectory(n).len(), points as usize);
    }
    assert!(common(&mut rig, SubsystemId::CONTROL).is_empty());
}

fn corrections(rig: &mut Rig, first: u8, values: &[u8]) -> Status {
    let corrections = Bytes(values);
    rig.status(SubsystemId::CONTROL, Body::SetupCorrectionTable { first, corrections })
}

/// §3.6/1, §3.6/2 The correction table: entries by 0.1 atm, kept; what reaches beyond it is not taken.
#[test]
fn correction_table() {
    let mut rig = rig();
    assert_eq!(rig.device.params().correction(80), Some(0));
    let whole: Vec<u8> = (0..=255).collect();
    assert_eq!(corrections(&mut rig, 0, &whole[..254]), Status::ACCEPTED);
    assert_eq!(corrections(&mut rig, 254, &whole[254..]), Status::ACCEPTED);
    assert_eq!(corrections(&mut rig, 254, &[7, 7, 7]), Status::INVALID_VALUE);
    assert_eq!(corrections(&mut rig, 255, &[7, 7]), Status::INVALID_VALUE);
    assert_eq!(corrections(&mut rig, 10, &[9, 0xF7]), Status::ACCEPTED);
    let empty = rig.handle(&[0x86, 0x45, 0, 1, 0]);
    assert_eq!(empty[0].status, Status::WRONG_DATA);
    let check = |rig: &Rig| {
        for pressure in 0..300_u16 {
            let expected = match pressure {
                10 => 9,
                11 => -9,
                other => (other.min(255) as u8).cast_signed(),
            };
            assert_eq!(rig.device.params().correction(pressure), Some(expected));
        }
    };
    check(&rig);
    rig.run(100);
    rig.power_cycle_and_settle();
    check(&rig);
    // The first entry is enough, and so is the last.
    assert_eq!(corrections(&mut rig, 255, &[1]), Status::ACCEPTED);
    assert_eq!(rig.device.params().correction(999), Some(1));
}

/// §3.6/3 A damaged table is not used; a new one is whole again.
#[test]
fn damaged_correction_table() {
    let mut rig = rig();
    corrections(&mut rig, 0, &[5; 100]);
    rig.run(50);
    rig.plant.damage(KEY_CORRECTION);
    rig.power_cycle_and_settle();
    assert_eq!(rig.device.params().correction(50), None);
    assert!(!rig.device.params().correction_valid());
    assert_eq!(common(&mut rig, SubsystemId::CONTROL), CommonFlags::CONFIG_FAULT);
    assert_eq!(corrections(&mut rig, 0, &[6; 100]), Status::ACCEPTED);
    assert_eq!(rig.device.params().correction(50), Some(6));
    rig.run(50);
    rig.power_cycle_and_settle();
    assert_eq!(rig.device.params().correction(50), Some(6));
    assert!(common(&mut rig, SubsystemId::CONTROL).is_empty());
}

/// §3.3.1/1, §3.3.1/2 A damaged set: ConfigFault and ConfigInvalid of that subsystem alone; its drive
/// answers ModuleFault and everything else works. Without General's nothing moves: whose address it has is
/// not known.
#[test]
fn damaged_set() {
    for (key, id) in [
        (KEY_GENERAL, SubsystemId::GENERAL),
        (KEY_VERTICAL, SubsystemId::VERTICAL),
        (KEY_CONTROL, SubsystemId::CONTROL),
    ] {
        let mut rig = Rig::new(Composition::REMOTE);
        rig.plant.damage(key);
        rig.power_cycle_and_settle();
        for other in SubsystemId::TABLE {
            // Without General's set the composition is the compiled one: it is the same here.
            if rig.device.has(other) {
                let expected = if other == id {
                    CommonFlags::CONFIG_FAULT | CommonFlags::CONFIG_INVALID
                } else {
                    CommonFlags::empty()
                };
                assert_eq!(common(&mut rig, other), expected, "{other} with {id} damaged");
            }
        }
        let vertical = rig.status(SubsystemId::VERTICAL, Body::Move { destination: 60 });
        let unsure = id == SubsystemId::GENERAL;
        let status = |works| if works { Status::ACCEPTED } else { Status::MODULE_FAULT };
        assert_eq!(vertical, status(id == SubsystemId::CONTROL));
        let horizontal = rig.status(SubsystemId::HORIZONTAL, Body::Move { destination: 60 });
        assert_eq!(horizontal, status(!unsure));
        assert_eq!(rig.device.address(), 1);
    }
}

/// §3.3.1/2 A monitor that has lost General's set answers to the address that is compiled in, which is that of
/// another one on the same line: nothing moves or opens, and Close is carried out.
#[test]
fn nothing_moves_in_the_name_of_another() {
    const OPEN: Body<'static> = Body::Open { key: key::OPEN };
    let mut plant = Plant::of(&Composition::REMOTE);
    Device::provision(&mut plant, &Composition::REMOTE, 7).unwrap();
    let mut rig = Rig::power_up(Composition::REMOTE, plant, 0);
    rig.run(200);
    assert_eq!(rig.device.address(), 7);
    rig.move_to(Axis::Vertical, 60);
    rig.run(5000);
    rig.plant.damage(KEY_GENERAL);
    rig.power_cycle_and_settle();
    assert_eq!(rig.device.address(), 1);
    let refuses = |rig: &mut Rig| {
        let quench = Quench::Program { program: 0, centre_h: 600, centre_v: 600, nozzle: 30 };
        for (to, body) in [
            (SubsystemId::VERTICAL, Body::Move { destination: 600 }),
            (SubsystemId::HORIZONTAL, Body::Move { destination: 600 }),
            (SubsystemId::VALVE1, OPEN),
            (SubsystemId::CONTROL, Body::StartQuench(quench)),
        ] {
            assert_eq!(rig.status(to, body), Status::MODULE_FAULT, "{to}");
        }
        rig.run_while(200, |rig| rig.is_still() && rig.valve_output(0) == ValveOutput::Off);
    };
    refuses(&mut rig);
    rig.plant.valves[0].opening_ms = 2000;
    rig.run(20);
    rig.accepts(SubsystemId::VALVE1, Body::Close { key: key::CLOSE });
    rig.run_until(3000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::CLOSED);
    // Its own address has effect after a Restart: until then it answers to the other.
    for param in Param::of(SubsystemId::GENERAL).filter(|param| param.spec().required) {
        let chain = i32::from(Composition::REMOTE.chain.bits());
        let value = match param {
            Param::GeneralAddress => 7,
            Param::GeneralChain => chain,
            param => param.spec().default,
        };
        rig.set(param, value);
    }
    rig.run(20);
    assert!(!common(&mut rig, SubsystemId::GENERAL).contains(CommonFlags::CONFIG_INVALID));
    refuses(&mut rig);
    rig.all_accept(Body::Restart);
    rig.run(500);
    assert_eq!((rig.plant.resets, rig.device.address()), (1, 7));
    rig.move_to(Axis::Vertical, 600);
    rig.accepts(SubsystemId::VALVE1, OPEN);
}

/// §3.3.1/2 Where the set that comes says what is in force, nothing has to be restarted.
#[test]
fn a_set_that_says_the_same() {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.plant.damage(KEY_GENERAL);
    rig.power_cycle_and_settle();
    let chain = i32::from(Composition::REMOTE.chain.bits());
    for param in Param::of(SubsystemId::GENERAL).filter(|param| param.spec().required) {
        let moved = rig.status(SubsystemId::VERTICAL, Body::Move { destination: 60 });
        assert_eq!(moved, Status::MODULE_FAULT, "{param:?}");
        let is_chain = param == Param::GeneralChain;
        rig.set(param, if is_chain { chain } else { param.spec().default });
    }
    rig.run(20);
    rig.move_to(Axis::Vertical, 60);
    rig.set(Param::GeneralAddress, 9);
    rig.run_while(50, |rig| rig.speed(Axis::Vertical) != 0);
}

/// §3.19/3, §3.5/6 A blank memory has lost nothing, also locked out meanwhile: a drive works as soon as its own set
/// is complete. Where a start finds sets, and not General's, part of the memory is gone.
#[test]
fn blank_is_not_lost() {
    let mut plant = Plant::of(&Composition::REMOTE);
    Device::provision(&mut plant, &Composition::REMOTE, 7).unwrap();
    plant.memory.clear();
    let mut rig = Rig::power_up(Composition::REMOTE, plant, 0);
    rig.run(200);
    for key in [key::ENABLE, key::DISABLE] {
        rig.ask(SubsystemId::ALL, Body::Lockout { key });
        rig.run(200);
    }
    rig.power_cycle_and_settle();
    assert!(rig.plant.memory.contains_key(&KEY_LOCKOUT));
    for param in Param::of(SubsystemId::VERTICAL).filter(|param| param.spec().required) {
        let moved = rig.status(SubsystemId::VERTICAL, Body::Move { destination: 60 });
        assert_eq!(moved, Status::MODULE_FAULT, "{param:?}");
        rig.set(param, Composition::REMOTE.factory_value(param));
    }
    rig.run(20);
    assert!(common(&mut rig, SubsystemId::GENERAL).contains(CommonFlags::CONFIG_INVALID));
    rig.move_to(Axis::Vertical, 60);
    rig.run(5000);
    rig.power_cycle_and_settle();
    let moved = rig.status(SubsystemId::VERTICAL, Body::Move { destination: 600 });
    assert_eq!(moved, Status::MODULE_FAULT);
}

/// §3.3.1/1 A program damaged: its values are lost, ConfigFault reports it, the others are whole.
#[test]
fn damaged_program() {
    let mut rig = rig();
    set_values(&mut rig, Param::ControlProgram0, &[1, 2, 3, 4, 5, 6, 7]);
    set_values(&mut rig, Param::ControlProgram1, &[7, 6, 5, 4, 3, 2, 1]);
    rig.run(50);
    rig.plant.damage(KEY_PROGRAM0);
    rig.power_cycle_and_settle();
    assert_eq!(rig.get(Param::ControlProgram0), Ok(vec![0; 7]));
    assert_eq!(rig.get(Param::ControlProgram1), Ok(vec![7, 6, 5, 4, 3, 2, 1]));
    assert_eq!(common(&mut rig, SubsystemId::CONTROL), CommonFlags::CONFIG_FAULT);
}

/// §3.14/2, §3.15/2, §3.3.1/1 A stored program or trajectory that is lost is refused with ModuleFault, until it is set
/// again; one that was never set is a direct aim, or InvalidId, and the others run.
#[test]
fn a_lost_program_is_not_run() {
    const CONTROL: SubsystemId = SubsystemId::CONTROL;
    let mut rig = rig();
    rig.deploy();
    let program = [0, 0, 30, 600, 300, 2, 0];
    set_values(&mut rig, Param::ControlProgram0, &program);
    set_values(&mut rig, Param::ControlProgram1, &program);
    set_values(&mut rig, Param::ControlTrajectory0, &[60, 60, 0, 5]);
    set_values(&mut rig, Param::ControlTrajectory1, &[60, 60, 0, 5]);
    rig.run(500);
    rig.plant.damage(KEY_PROGRAM0);
    rig.plant.damage(KEY_TRAJECTORY0);
    rig.power_cycle_and_settle();
    let quench = |program| {
        Body::StartQuench(Quench::Program { program, centre_h: 60, centre_v: 60, nozzle: 30 })
    };
    let trajectory =
        |rig: &mut Rig, number: u8| rig.handle(&[0x5C, CONTROL.0, 0, 4, 1, 0, 1, number])[0].status;
    assert_eq!(rig.status(CONTROL, quench(0)), Status::MODULE_FAULT);
    assert_eq!(trajectory(&mut rig, 0), Status::MODULE_FAULT);
    rig.run_while(100, |rig| rig.is_still());
    for number in [1, 2] {
        assert_eq!(rig.status(CONTROL, quench(number)), Status::ACCEPTED);
    }
    assert_eq!(trajectory(&mut rig, 1), Status::ACCEPTED);
    assert_eq!(trajectory(&mut rig, 2), Status::INVALID_ID);
    // Set again it holds at once, though nothing is stored while the barrel moves.
    set_values(&mut rig, Param::ControlProgram0, &program);
    set_values(&mut rig, Param::ControlTrajectory0, &[60, 60, 0, 5]);
    assert_eq!(rig.status(CONTROL, quench(0)), Status::ACCEPTED);
    assert_eq!(trajectory(&mut rig, 0), Status::ACCEPTED);
    rig.accepts(CONTROL, Body::Stop);
    rig.run(500);
    assert_eq!(rig.status(CONTROL, quench(0)), Status::ACCEPTED);
    assert!(common(&mut rig, CONTROL).is_empty());
}

/// §3.3.1/1 A memory that cannot be read at all: nothing moves, the lockout is assumed, and it is reported.
#[test]
fn unreadable_memory() {
    let mut rig = rig();
    rig.plant.load_fails = true;
    rig.power_cycle_and_settle();
    let general = rig.general().flags;
    let expected =
        GeneralFlags::CONFIG_FAULT | GeneralFlags::CONFIG_INVALID | GeneralFlags::LOCKED_OUT;
    assert_eq!(general, expected);
    let answer = rig.one(SubsystemId::DEPLOYER, Body::Deploy);
    assert_eq!(answer, (SubsystemId::GENERAL, Status::DENIED));
    assert_eq!(rig.get(Param::VerticalSpeed), Err(Status::INCOMPLETE_CONFIG));
}

/// §3.3.1/1, §3.5 Accepted but not stored: ConfigWriteFault of that subsystem, until a write succeeds.
#[test]
fn write_fault() {
    let mut rig = rig();
    rig.plant.store_fails = true;
    assert_eq!(rig.set(Param::VerticalSpeed, 5), Status::ACCEPTED);
    rig.run(50);
    assert_eq!(common(&mut rig, SubsystemId::VERTICAL), CommonFlags::CONFIG_WRITE_FAULT);
    assert_eq!(common(&mut rig, SubsystemId::HORIZONTAL), CommonFlags::empty());
    assert_eq!(rig.get(Param::VerticalSpeed), Ok(vec![5]));
    // A fault of the memory does not hold up a Restart for ever.
    let mut restarting = rig.clone();
    restarting.all_accept(Body::Restart);
    restarting.run(500);
    assert_eq!(restarting.plant.resets, 1);
    assert_eq!(restarting.get(Param::VerticalSpeed), Ok(vec![12]));
    // §3.5/9 What failed is never said to be stored.
    assert_eq!(rig.set(Param::VerticalSpeed, 5), Status::ACCEPTED);
    rig.run(50);
    rig.plant.store_fails = false;
    rig.run(500);
    assert_eq!(common(&mut rig, SubsystemId::VERTICAL), CommonFlags::CONFIG_WRITE_FAULT);
    // A minute later it is tried again; a client need not wait for that.
    let mut waiting = rig.clone();
    waiting.run(60_000);
    assert_eq!(common(&mut waiting, SubsystemId::VERTICAL), CommonFlags::empty());
    assert_eq!(waiting.set(Param::VerticalSpeed, 5), Status::OK);
    assert_eq!(rig.set(Param::VerticalSpeed, 5), Status::ACCEPTED);
    rig.run(50);
    assert_eq!(common(&mut rig, SubsystemId::VERTICAL), CommonFlags::empty());
    assert_eq!(rig.set(Param::VerticalSpeed, 5), Status::OK);
}

/// §3.3.1/1 A write that succeeds clears the flags of what it has written, of nothing else.
#[test]
fn faults_are_those_of_a_value() {
    let mut rig = rig();
    rig.plant.store_fails = true;
    assert_eq!(set_values(&mut rig, Param::ControlProgram0, &[1; 7]), Status::ACCEPTED);
    rig.run(50);
    rig.plant.store_fails = false;
    assert_eq!(set_values(&mut rig, Param::ControlProgram1, &[2; 7]), Status::ACCEPTED);
    rig.run(50);
    assert_eq!(set_values(&mut rig, Param::ControlProgram1, &[2; 7]), Status::OK);
    assert_eq!(common(&mut rig, SubsystemId::CONTROL), CommonFlags::CONFIG_WRITE_FAULT);
    assert_eq!(set_values(&mut rig, Param::ControlProgram0, &[1; 7]), Status::ACCEPTED);
    rig.run(50);
    assert_eq!(common(&mut rig, SubsystemId::CONTROL), CommonFlags::empty());
}

/// §3.5/10 Nothing is written while a drive turns or a valve's motor runs, the lockout excepted: it
/// has stopped them. Restart stops them too, and loses nothing.
#[test]
fn stored_at_rest() {
    let mut rig = Rig::deployed();
    rig.move_to(Axis::Horizontal, 9000);
    rig.run(50);
    let written = rig.plant.written.len();
    assert_eq!(rig.set(Param::VerticalSpeed, 7), Status::ACCEPTED);
    rig.run_while(2000, |rig| rig.plant.written.len() == written);
    assert_eq!(rig.set(Param::VerticalSpeed, 7), Status::ACCEPTED);
    let mut restarted = rig.clone();
    restarted.all_accept(Body::Restart);
    restarted.run(300);
    assert_eq!((restarted.plant.resets, restarted.get(Param::VerticalSpeed)), (1, Ok(vec![7])));
    let mut locked = rig.clone();
    locked.all_accept(Body::Lockout { key: key::ENABLE });
    locked.step(10);
    assert_eq!(locked.plant.written[written..], [KEY_LOCKOUT]);
    rig.all_accept(Body::Stop);
    rig.run(20);
    assert_eq!(rig.set(Param::VerticalSpeed, 7), Status::OK);
    rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    rig.run(50);
    assert_eq!(rig.set(Param::VerticalSpeed, 8), Status::ACCEPTED);
    rig.run(3000);
    assert_eq!(rig.set(Param::VerticalSpeed, 8), Status::ACCEPTED);
    // Open: its motor is at rest.
    rig.run(3000);
    assert_eq!(rig.set(Param::VerticalSpeed, 8), Status::OK);
}

/// §3.5/6, §3.19/3, §3.4/3 Nothing stored: IncompleteConfig until the subsystem's set is complete, then
/// all of it is written; others are not touched.
#[test]
fn incomplete_until_complete() {
    let mut rig = erased();
    assert_eq!(rig.device.address(), 1);
    let required: Vec<Param> =
        Param::of(SubsystemId::VERTICAL).filter(|param| param.spec().required).collect();
    let last = required.len() - 1;
    for (number, param) in required.iter().enumerate() {
        assert_eq!(rig.get(*param), Err(Status::INCOMPLETE_CONFIG), "{param:?}");
        let invalid = common(&mut rig, SubsystemId::VERTICAL);
        assert!(invalid.contains(CommonFlags::CONFIG_INVALID));
        let faulty = rig.one(SubsystemId::DEPLOYER, Body::Deploy);
        assert_eq!(faulty.1, Status::MODULE_FAULT);
        let status = rig.set(*param, param.spec().default);
        let expected = if number == last { Status::ACCEPTED } else { Status::INCOMPLETE_CONFIG };
        assert_eq!(status, expected, "{param:?}");
        assert_eq!(rig.get(*param), Ok(vec![param.spec().default]), "kept in RAM");
        if number < last {
            rig.run(50);
            assert!(rig.plant.memory.is_empty());
        }
    }
    rig.run(50);
    assert!(common(&mut rig, SubsystemId::VERTICAL).is_empty());
    assert_eq!(rig.plant.memory.keys().copied().collect::<Vec<_>>(), [KEY_VERTICAL]);
    rig.power_cycle_and_settle();
    assert!(common(&mut rig, SubsystemId::VERTICAL).is_empty());
    assert!(common(&mut rig, SubsystemId::HORIZONTAL).contains(CommonFlags::CONFIG_INVALID));
    assert_eq!(rig.get(Param::VerticalSpeed), Ok(vec![12]));
}

/// §3.5/6 Programs are kept in RAM too until Control's set is complete, and are then written with it.
#[test]
fn optional_parameters_wait_for_the_set() {
    let mut rig = erased();
    let values = [1, 2, 3, 4, 5, 6, 7];
    let status = set_values(&mut rig, Param::ControlProgram2, &values);
    assert_eq!(status, Status::INCOMPLETE_CONFIG);
    assert_eq!(rig.get(Param::ControlProgram2), Ok(values.to_vec()));
    rig.run(50);
    assert!(rig.plant.memory.is_empty());
    rig.set(Param::ControlBallistics, 1);
    rig.set(Param::ControlHeight, 150);
    assert_eq!(rig.set(Param::ControlNozzleDiameter, 280), Status::ACCEPTED);
    rig.run(500);
    rig.power_cycle_and_settle();
    assert_eq!(rig.get(Param::ControlProgram2), Ok(values.to_vec()));
    assert!(common(&mut rig, SubsystemId::CONTROL).is_empty());
}

/// §3.3.1/2 Values that contradict each other are taken one by one; ConfigInvalid shows it, and the
/// drive does not move.
#[test]
fn contradicting_values() {
    let mut rig = Rig::new(Composition::REMOTE);
    assert_eq!(rig.set(Param::VerticalMinLimit, 4500), Status::ACCEPTED);
    assert!(rig.drive_flags(Axis::Vertical).contains(DriveFlags::CONFIG_INVALID));
    let status = rig.status(SubsystemId::VERTICAL, Body::Move { destination: 0 });
    assert_eq!(status, Status::MODULE_FAULT);
    rig.set(Param::VerticalMinLimit, -900);
    assert_eq!(rig.drive_flags(Axis::Vertical), DriveFlags::empty());
    rig.move_to(Axis::Vertical, 60);
}

/// §3.19/1, §3.19/2, §3.19/3 CleanFlash: with its key everything is erased and the program resets; the
/// compiled composition and the hardware's address remain.
#[test]
fn clean_flash() {
    let mut rig = rig();
    rig.set(Param::GeneralAddress, 99);
    rig.set(Param::GeneralChain, 0x0001);
    rig.run(50);
    rig.power_cycle_and_settle();
    assert_eq!(rig.device.address(), 99);
    assert!(!rig.device.has(SubsystemId::VERTICAL));
    for wrong in [0, key::OPEN, key::CLEAN_FLASH.swap_bytes()] {
        let status = rig.status(SubsystemId::GENERAL, Body::CleanFlash { key: wrong });
        assert_eq!(status, Status::NEED_CONFIRM);
    }
    rig.run(500);
    assert_eq!((rig.plant.resets, rig.device.address()), (0, 99));
    let right = Body::CleanFlash { key: key::CLEAN_FLASH };
    assert_eq!(rig.status(SubsystemId::GENERAL, right), Status::OK);
    assert_eq!(rig.one(SubsystemId::GENERAL, right), (SubsystemId::GENERAL, Status::BUSY));
    assert!(!rig.plant.memory.is_empty());
    rig.run(500);
    assert!(rig.plant.memory.is_empty() && rig.plant.resets == 1);
    assert_eq!(rig.device.address(), 1);
    for id in SubsystemId::TABLE {
        let has_set = Param::of(id).any(|param| param.spec().required);
        let invalid = common(&mut rig, id).contains(CommonFlags::CONFIG_INVALID);
        assert_eq!(invalid, has_set, "{id}");
    }
}

/// §3.19/1, §3.3.1/1 A memory that cannot be erased: no reset, ConfigWriteFault, and it works on.
#[test]
fn clean_flash_fails() {
    let mut rig = rig();
    rig.plant.erase_fails = true;
    rig.accepts(SubsystemId::GENERAL, Body::CleanFlash { key: key::CLEAN_FLASH });
    rig.run(500);
    assert_eq!(rig.plant.resets, 0);
    assert_eq!(rig.general().flags, GeneralFlags::CONFIG_WRITE_FAULT);
    rig.deploy();
    assert_eq!(rig.get(Param::VerticalSpeed), Ok(vec![12]));
}

/// §3.18/6 The lockout is kept; one that cannot be read counts as on.
#[test]
fn lockout_is_kept() {
    let mut rig = rig();
    rig.all_accept(Body::Lockout { key: key::ENABLE });
    rig.run(20);
    rig.power_cycle_and_settle();
    assert!(rig.general().flags.contains(GeneralFlags::LOCKED_OUT));
    rig.all_accept(Body::Lockout { key: key::DISABLE });
    rig.run(20);
    rig.power_cycle_and_settle();
    assert_eq!(rig.general().flags, GeneralFlags::empty());
    rig.plant.damage(KEY_LOCKOUT);
    rig.power_cycle_and_settle();
    let expected = GeneralFlags::LOCKED_OUT | GeneralFlags::CONFIG_FAULT;
    assert_eq!(rig.general().flags, expected);
    rig.all_accept(Body::Lockout { key: key::DISABLE });
    rig.run(20);
    rig.power_cycle_and_settle();
    assert_eq!(rig.general().flags, GeneralFlags::empty());
}

/// §3.3.1/2 A stored value out of its range, as of another version, counts as unset; a parameter that
/// this version does not know is passed over.
#[test]
fn values_of_another_version() {
    let mut rig = rig();
    let value = rig.plant.memory.get_mut(&KEY_VERTICAL).unwrap();
    value.truncate(value.len() - 2);
    let speed = Param::VerticalSpeed.spec().id.0.to_le_bytes();
    let (entries, _) = value.as_chunks_mut::<6>();
    let entry = entries.iter_mut().find(|entry| entry.starts_with(&speed)).unwrap();
    entry[2..].copy_from_slice(&256_i32.to_le_bytes());
    value.extend([0xFF, 0xFF, 1, 0, 0, 0]);
    let crc = lafet_proto::link::crc16(value);
    value.extend(crc.to_le_bytes());
    rig.power_cycle_and_settle();
    assert_eq!(common(&mut rig, SubsystemId::VERTICAL), CommonFlags::CONFIG_INVALID);
    assert_eq!(rig.get(Param::VerticalSpeed), Err(Status::INCOMPLETE_CONFIG));
    assert_eq!(rig.get(Param::VerticalMaxLimit), Ok(vec![4500]));
    assert_eq!(rig.set(Param::VerticalSpeed, 12), Status::ACCEPTED);
    assert!(common(&mut rig, SubsystemId::VERTICAL).is_empty());
}

/// §1/1, §3.3.1/2 What the factory stores: each profile's chain and address, every set complete; a
/// memory that takes nothing is reported at once.
#[test]
fn provisioning() {
    for composition in Composition::ALL {
        let mut plant = Plant::of(&composition);
        Device::provision(&mut plant, &composition, 42).unwrap();
        let mut rig = Rig::power_up(composition, plant, 0);
        assert_eq!(rig.device.address(), 42);
        for id in SubsystemId::TABLE {
            assert_eq!(rig.device.has(id), composition.chain.contains(id), "{}", composition.name);
            if rig.device.has(id) {
                assert!(common(&mut rig, id).is_empty(), "{id} of {}", composition.name);
            }
        }
        let mut full = Plant { store_fails: true, ..Plant::of(&composition) };
        assert!(Device::provision(&mut full, &composition, 42).is_err());
    }
}

/// §3.5/9 SetParam with the values that are there says so, moves nothing and starts nothing.
#[test]
fn set_param_starts_nothing() {
    let mut rig = Rig::deployed();
    for param in Param::ALL {
        let spec = param.spec();
        if spec.access == Access::ReadWrite && spec.max_len == 1 {
            let value = rig.get(param).unwrap()[0];
            assert_eq!(rig.set(param, value), Status::OK, "{param:?}");
        }
    }
    rig.run_while(500, |rig| rig.is_still());
    assert_eq!(rig.flags(SubsystemId::CONTROL), ControlFlags::empty().bits());
}
