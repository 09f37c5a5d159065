//! Requests to programs and posts as they come over the wire; connections of bare records.

use crate::common::{Rig, STEP_MS, payload, replies};
use lafet_device::cause::{Cause, Rule};
use lafet_device::image::{Axis, Spot, ValveOutput};
use lafet_device::port::RecordPort;
use lafet_device::{Composition, Source};
use lafet_proto::flags::{
    Button, ButtonState, CommonFlags, ControlFlags, DetectorFlags, DriveFlags, ValveFlags,
};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Quench, Sector, Seek};
use lafet_proto::status::Limits;
use lafet_proto::{Ints, ParamId, Request, Status, SubsystemId};

const CONTROL: SubsystemId = SubsystemId::CONTROL;
const DETECTOR: SubsystemId = SubsystemId::DETECTOR;
const DEPLOYER: SubsystemId = SubsystemId::DEPLOYER;

fn quench() -> Body<'static> {
    let sector =
        Sector { centre_h: 1800, centre_v: 0, nozzle: 30, width: 600, height: 300, step: 2 };
    Body::StartQuench(Quench::Full { sector, distance: 0 })
}

fn seek() -> Body<'static> {
    Body::StartSeek(Seek { start_h: -900, end_h: 900, start_v: 0, end_v: 600, analyse: 0 })
}

fn control(rig: &mut Rig) -> ControlFlags {
    ControlFlags::from_bits_retain(rig.flags(CONTROL))
}

fn detector(rig: &mut Rig) -> DetectorFlags {
    DetectorFlags::from_bits_retain(rig.flags(DETECTOR))
}

fn started(to: SubsystemId, body: Body<'_>) -> Rig {
    let mut rig = Rig::deployed();
    rig.accepts(to, body);
    rig.run(500);
    assert!(!rig.is_still());
    rig
}

/// §3.2/4, §3.2/3 Stop ends a program, a search and a justification when it is sent to the right one,
/// and is Denied to all others; what is stopped says so, and the drives stand.
#[test]
fn stop_of_programs() {
    for (to, body) in [(CONTROL, quench()), (DETECTOR, seek()), (DETECTOR, Body::StartJustify)] {
        let mut rig = Rig::deployed();
        rig.plant.place(Axis::Horizontal, 3000);
        rig.run(20);
        rig.accepts(to, body);
        rig.run(500);
        assert!(!rig.is_still(), "{body:?}");
        for other in [
            SubsystemId::HORIZONTAL,
            SubsystemId::VALVE1,
            DEPLOYER,
            if to == CONTROL { DETECTOR } else { CONTROL },
        ] {
            assert_eq!(rig.one(other, Body::Stop), (to, Status::DENIED), "{body:?} {other}");
        }
        assert_eq!(rig.status(to, Body::Stop), Status::OK);
        rig.run_while(500, |rig| rig.is_still());
        assert!(!control(&mut rig).contains(ControlFlags::QUENCH));
        let busy = DetectorFlags::SEARCHING | DetectorFlags::JUSTIFYING;
        assert!(!detector(&mut rig).intersects(busy));
        let canceled = detector(&mut rig).contains(DetectorFlags::CANCELED);
        assert_eq!(canceled, matches!(body, Body::StartSeek(_)));
    }
}

/// §3.2 Stop to the one that does not run leaves alone what another moves.
#[test]
fn stop_of_what_does_not_run() {
    for to in [CONTROL, DETECTOR] {
        let mut rig = Rig::deployed();
        rig.move_to(Axis::Horizontal, 3000);
        rig.run(200);
        assert_eq!(rig.status(to, Body::Stop), Status::OK);
        rig.run_while(200, |rig| rig.speed(Axis::Horizontal) > 0);
    }
}

/// §3.14/6, §3.16/4, §3.13/2, §3.11/7 Who refuses what while something runs.
#[test]
fn what_runs_refuses() {
    let mut quenching = started(CONTROL, quench());
    assert_eq!(quenching.one(DETECTOR, seek()), (DETECTOR, Status::DENIED));
    assert_eq!(quenching.one(DETECTOR, Body::StartJustify), (CONTROL, Status::DENIED));
    let service = Body::Move { destination: 3000 };
    assert_eq!(quenching.one(DEPLOYER, service), (CONTROL, Status::DENIED));
    assert_eq!(quenching.status(CONTROL, quench()), Status::ACCEPTED);

    let mut seeking = started(DETECTOR, seek());
    for (to, body) in [
        (CONTROL, quench()),
        (DETECTOR, Body::StartJustify),
        (DEPLOYER, Body::Wrap),
        (DEPLOYER, service),
        (SubsystemId::HORIZONTAL, Body::Move { destination: 0 }),
        (SubsystemId::VALVE1, Body::Open { key: key::OPEN }),
        (SubsystemId::VALVE1, Body::Close { key: key::CLOSE }),
    ] {
        assert_eq!(seeking.one(to, body), (DETECTOR, Status::DENIED), "{body:?}");
    }
    assert_eq!(seeking.status(DETECTOR, seek()), Status::ACCEPTED);

    let mut justifying = Rig::deployed();
    justifying.plant.place(Axis::Horizontal, 3000);
    justifying.run(20);
    justifying.accepts(DETECTOR, Body::StartJustify);
    justifying.run(200);
    for (to, body) in [
        (CONTROL, quench()),
        (DETECTOR, seek()),
        (DEPLOYER, Body::Wrap),
        (SubsystemId::HORIZONTAL, Body::Move { destination: 0 }),
        (SubsystemId::VALVE1, Body::Open { key: key::OPEN }),
    ] {
        assert_eq!(justifying.one(to, body), (DETECTOR, Status::DENIED), "{body:?}");
    }
    assert_eq!(justifying.status(DETECTOR, Body::StartJustify), Status::ACCEPTED);
    // §3.9/1: a justification works without water, and does not forbid closing.
    justifying.accepts(SubsystemId::VALVE1, Body::Close { key: key::CLOSE });
}

/// §3.16/8 With an open valve nothing is looked for, whichever it is.
#[test]
fn no_search_through_water() {
    for valve in [SubsystemId::VALVE1, SubsystemId::VALVE2] {
        let mut rig = Rig::deployed();
        rig.accepts(valve, Body::Open { key: key::OPEN });
        rig.run(5000);
        assert_eq!(rig.one(DETECTOR, seek()), (valve, Status::DENIED));
    }
}

/// §3.11/7 Wrap ends a program: it does not aim a folding barrel.
#[test]
fn wrap_ends_a_program() {
    let mut rig = started(CONTROL, quench());
    assert_eq!(rig.status(DEPLOYER, Body::Wrap), Status::ACCEPTED);
    assert!(!control(&mut rig).contains(ControlFlags::QUENCH));
    // One that is wrapped already has nothing to end, and a program that deploys goes on.
    let mut rig = Rig::new(Composition::FULL);
    rig.accepts(CONTROL, quench());
    assert!(control(&mut rig).contains(ControlFlags::QUENCH));
}

/// §3.14/5, §3.16/3 What is refused does not deploy.
#[test]
fn a_refusal_does_not_deploy() {
    let mut rig = Rig::new(Composition::FULL);
    let nowhere = Seek { start_h: 20_000, end_h: 21_000, start_v: 0, end_v: 100, analyse: 0 };
    let status = rig.status(DETECTOR, Body::StartSeek(nowhere));
    assert_eq!(status, Status::INVALID_VALUE);
    rig.run_while(200, |rig| rig.is_still());
    rig.accepts(DETECTOR, seek());
    rig.run(200);
    assert!(rig.speed(Axis::Deployer) > 0);
}

/// §1/5, §1/6, §3.17/1 Limits off for all drives at once: each does it and answers, in chain order.
#[test]
fn limits_off_for_all() {
    let drives = [DEPLOYER, SubsystemId::NOZZLE, SubsystemId::HORIZONTAL, SubsystemId::VERTICAL];
    for to in [SubsystemId::ALL, SubsystemId::MOTORS] {
        let mut rig = Rig::deployed();
        let answers = rig.ask(to, Body::SwitchLimits { new_state: 0 });
        let brief: Vec<_> = answers.iter().map(|answer| (answer.from, answer.status)).collect();
        assert_eq!(brief, drives.map(|drive| (drive, Status::OK)));
        for axis in Axis::ALL {
            assert!(rig.drive_flags(axis).contains(DriveFlags::LIMITLESS), "{axis:?}");
        }
    }
}

/// §3.7/1, §1/5 Each drive answers its limits, and to All and Motors all of them do, in chain order.
#[test]
fn limits_are_told() {
    let mut rig = Rig::deployed();
    let drives = [DEPLOYER, SubsystemId::NOZZLE, SubsystemId::HORIZONTAL, SubsystemId::VERTICAL];
    let each = drives.map(|drive| {
        let [answer] = &rig.ask(drive, Body::RetrieveLimits)[..] else { panic!("{drive}") };
        assert_eq!(
            (answer.from, answer.status, answer.data.len()),
            (drive, Status::OK, Limits::SIZE)
        );
        answer.data.clone()
    });
    let nozzle = Limits::from_bytes(each[1].as_slice().try_into().unwrap());
    assert_eq!(nozzle, Limits { min: 0, max: 60 });
    for to in [SubsystemId::ALL, SubsystemId::MOTORS] {
        let answers = rig.ask(to, Body::RetrieveLimits);
        assert_eq!(answers.iter().map(|answer| answer.from).collect::<Vec<_>>(), drives);
        assert!(answers.iter().map(|answer| &answer.data).eq(&each), "{to}");
    }
    let valve = rig.one(SubsystemId::VALVE1, Body::RetrieveLimits);
    assert_eq!(valve, (SubsystemId::VALVE1, Status::WRONG_REQUEST));
    assert!(rig.is_still());
}

/// §1/6 What may not be broadcast is WrongRequest from General, to All and to Motors, and does nothing.
#[test]
fn what_is_no_broadcast() {
    let id = Param::VerticalSpeed.spec().id;
    for to in [SubsystemId::ALL, SubsystemId::MOTORS] {
        let mut rig = Rig::deployed();
        for body in [
            Body::Move { destination: 600 },
            Body::GetParam { id },
            Body::SetParam { id, values: Ints::Values(&[5]) },
            Body::Open { key: key::OPEN },
            Body::Deploy,
            Body::Wrap,
            quench(),
            seek(),
            Body::StartJustify,
            Body::GetHotbed,
            Body::CleanFlash { key: key::CLEAN_FLASH },
        ] {
            let refused = (SubsystemId::GENERAL, Status::WRONG_REQUEST);
            assert_eq!(rig.one(to, body), refused, "{body:?} to {to}");
        }
        rig.run_while(300, |rig| {
            rig.is_still() && rig.plant.outputs.valves == [ValveOutput::Off; 2]
        });
    }
    // All, but not Motors.
    let mut rig = Rig::deployed();
    for body in [Body::GetCrashData, Body::Restart, Body::Lockout { key: key::ENABLE }] {
        let refused = (SubsystemId::GENERAL, Status::WRONG_REQUEST);
        assert_eq!(rig.one(SubsystemId::MOTORS, body), refused, "{body:?}");
    }
    assert_eq!(rig.one(SubsystemId::ALL, Body::GetCrashData), (SubsystemId::GENERAL, Status::OK));
}

/// §2/3, §1/5 A broadcast of a wrong size: all that would do it answer WrongData, and none does it.
#[test]
fn a_broadcast_of_a_wrong_size() {
    let mut rig = Rig::deployed();
    let answers = rig.handle(&[0xD9, SubsystemId::MOTORS.0, 0, 1, 0]);
    let brief: Vec<_> = answers.iter().map(|answer| (answer.from, answer.status)).collect();
    let drives = [DEPLOYER, SubsystemId::NOZZLE, SubsystemId::HORIZONTAL, SubsystemId::VERTICAL];
    assert_eq!(brief, drives.map(|drive| (drive, Status::WRONG_DATA)));
    assert!(!rig.drive_flags(Axis::Vertical).contains(DriveFlags::LIMITLESS));
}

/// §2/2, §3.18/2, §3.12/2 A record cut short: General refuses it first, under lockout and before a
/// reset.
#[test]
fn cut_short_under_lockout() {
    for (body, status) in
        [(Body::Lockout { key: key::ENABLE }, Status::DENIED), (Body::Restart, Status::BUSY)]
    {
        let mut rig = Rig::deployed();
        rig.all_accept(body);
        let answers = rig.handle(&[0x4D, SubsystemId::VERTICAL.0, 0, 2, 0x10]);
        assert_eq!((answers[0].from, answers[0].status), (SubsystemId::GENERAL, status));
        // What is read is of the wrong size, as ever.
        let answers = rig.handle(&[0x9D, SubsystemId::VERTICAL.0, 0, 2, 0x10]);
        assert_eq!(
            (answers[0].from, answers[0].status),
            (SubsystemId::VERTICAL, Status::WRONG_DATA)
        );
    }
}

/// §2/3, §2/4, §3.15 A trajectory of a mode, flags or a number of points that there is not:
/// InvalidValue; of another size than it says: WrongData.
#[test]
fn values_and_sizes_of_a_trajectory() {
    for (data, status) in [
        (&[1, 0, 1, 8][..], Status::INVALID_VALUE),
        (&[2, 0, 1, 0], Status::INVALID_VALUE),
        (&[0, 4, 1, 0, 0, 0, 0, 0, 0], Status::INVALID_VALUE),
        (&[0, 0, 0], Status::INVALID_VALUE),
        (&[0, 0, 1, 0], Status::WRONG_DATA),
        (&[1, 0, 1], Status::WRONG_DATA),
        (&[0, 0], Status::WRONG_DATA),
        (&[0, 0, 1, 0, 0, 0, 0, 0, 0], Status::ACCEPTED),
    ] {
        let mut rig = Rig::deployed();
        let mut record = vec![0x5C, CONTROL.0, 0, data.len() as u8];
        record.extend(data);
        let answers = rig.handle(&record);
        assert_eq!((answers[0].from, answers[0].status), (CONTROL, status), "{data:?}");
        let runs = control(&mut rig).contains(ControlFlags::TRAJECTORY);
        assert_eq!(runs, status == Status::ACCEPTED, "{data:?}");
    }
}

/// §3.1/3 Move pauses a program, Move Deployer would; Stop to a drive does not.
#[test]
fn move_pauses_a_program() {
    let mut rig = started(CONTROL, quench());
    assert!(!control(&mut rig).contains(ControlFlags::PAUSED));
    rig.move_to(Axis::Nozzle, 10);
    rig.run(20);
    assert!(control(&mut rig).contains(ControlFlags::PAUSED));
    // A Move that is refused does not.
    let mut rig = started(CONTROL, quench());
    rig.plant.inputs.drives[Axis::Nozzle as usize].motor_open = true;
    rig.run(40);
    rig.ask(SubsystemId::NOZZLE, Body::Move { destination: 10 });
    rig.step(STEP_MS);
    assert!(!control(&mut rig).contains(ControlFlags::PAUSED));
}

/// §3.16/5, §3.21/1, §3.21/2 What a search has found is reported brightest first, the same by both requests,
/// twenty bytes each.
#[test]
fn hotbeds_are_told() {
    // Horizontal and vertical middle, brightness; each 60' wide and high.
    let fires = [(-600_i64, 300_i64, 700), (600, 300, 900)];
    let mut rig = started(DETECTOR, seek());
    let empty = rig.get(Param::DetectorHotbeds);
    assert_eq!(empty, Ok(vec![]));
    while detector(&mut rig).contains(DetectorFlags::SEARCHING) {
        assert!(rig.now_ms < 200_000);
        let [h, v] = [Axis::Horizontal, Axis::Vertical].map(|axis| rig.plant.position(axis));
        let spots = fires.map(|(fire_h, fire_v, brightness)| {
            let (left, up) = ((fire_h - h) as i16, (fire_v - v) as i16);
            let (sides, ends) = ((left + 30, left - 30), (up - 30, up + 30));
            let spot =
                Spot { left: sides.0, right: sides.1, bottom: ends.0, top: ends.1, brightness };
            (left.abs() < 450 && up.abs() < 450).then_some(spot)
        });
        rig.plant.inputs.detector.spots[..2].copy_from_slice(&spots);
        rig.step(STEP_MS);
    }
    assert_eq!(detector(&mut rig), DetectorFlags::FOUND);
    let told = rig.get(Param::DetectorHotbeds).unwrap();
    let [first, second] = told.as_chunks::<5>().0 else { panic!("{told:?}") };
    for ([x1, x2, y1, y2, brightness], (h, v, expected)) in [(first, fires[1]), (second, fires[0])]
    {
        let (h, v) = (h as i32, v as i32);
        let near = |edge: &i32, expected: i32| (edge - expected).abs() <= 15;
        assert!(near(x1, h + 30) && near(x2, h - 30), "{told:?}");
        assert!(near(y1, v - 30) && near(y2, v + 30), "{told:?}");
        assert_eq!(*brightness, expected);
    }
    let by_id = rig.ask(DETECTOR, Body::GetParam { id: ParamId::HOTBEDS });
    assert_eq!(rig.ask(DETECTOR, Body::GetHotbed), by_id);
    assert_eq!(by_id[0].data.len(), 2 + 2 * 20);
}

/// §3.4/1, §3.5/2–§3.5/5 Refusals of parameters carry the id, but for a wrong size, where there may be
/// none.
#[test]
fn what_a_refused_parameter_carries() {
    let mut rig = Rig::deployed();
    let spec = Param::HorizontalSpeed.spec();
    let id = spec.id.0.to_le_bytes().to_vec();
    let mut set = |id, values: &[i32]| {
        let body = Body::SetParam { id, values: Ints::Values(values) };
        let answer = rig.ask(spec.subsystem, body).remove(0);
        (answer.status, answer.data)
    };
    assert_eq!(set(spec.id, &[0]), (Status::INVALID_VALUE, id.clone()));
    assert_eq!(set(spec.id, &[5]), (Status::ACCEPTED, id));
    assert_eq!(set(spec.id, &[5, 5]), (Status::WRONG_DATA, vec![]));
    assert_eq!(set(ParamId(1), &[5]), (Status::INVALID_ID, vec![1, 0]));
}

/// §3.2/5 Stop to a valve that is faulty: it stops and says ModuleFault.
#[test]
fn stop_of_a_faulty_valve() {
    let mut rig = Rig::deployed();
    rig.accepts(SubsystemId::VALVE2, Body::Open { key: key::OPEN });
    rig.run(500);
    rig.plant.inputs.valves[1].open_sensor_fault = true;
    rig.step(STEP_MS);
    assert_eq!(rig.status(SubsystemId::VALVE2, Body::Stop), Status::MODULE_FAULT);
    rig.step(STEP_MS);
    assert_eq!(rig.valve_output(1), ValveOutput::Off);
    assert_eq!(rig.status(SubsystemId::VALVE1, Body::Stop), Status::OK);
}

/// §3.3.10/1, §3.2/5 A button that is held over a Stop of its drive acts only when pressed again; one
/// of another drive goes on.
#[test]
fn stop_disarms_the_buttons_of_its_drive() {
    for post in 0..2 {
        for (button, other, axis) in [
            (Button::Left, Button::Up, Axis::Horizontal),
            (Button::Down, Button::Right, Axis::Vertical),
            (Button::Wide, Button::Up, Axis::Nozzle),
        ] {
            let mut rig = Rig::new(Composition::REMOTE);
            rig.plant.place(Axis::Nozzle, 30);
            rig.pause();
            rig.run(20);
            for held in [button, other] {
                rig.plant.inputs.buttons[post][held as usize] = ButtonState::Pressed;
            }
            rig.run(200);
            assert_eq!(rig.status(axis.id(), Body::Stop), Status::OK);
            rig.step(STEP_MS);
            rig.run_while(300, |rig| rig.speed(axis) == 0);
            assert!(!rig.is_still(), "{other:?} is held on");
        }
    }
}

/// §3.12/2, §3.3.10/1 Restarting, a monitor takes no buttons either.
#[test]
fn buttons_while_restarting() {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.all_accept(Body::Restart);
    rig.plant.inputs.buttons[0][Button::Left as usize] = ButtonState::Pressed;
    rig.plant.inputs.buttons[1][Button::Open as usize] = ButtonState::Pressed;
    rig.run_while(1000, |rig| rig.is_still() && rig.valve_output(0) != ValveOutput::Opening);
    assert_eq!(rig.plant.resets, 1);
}

/// §3.3.10/1 Why a drive under a button is at rest: released, or refused while it is held on.
#[test]
fn why_a_button_ends() {
    let mut rig = Rig::deployed();
    let left = |rig: &mut Rig, state| {
        rig.plant.inputs.buttons[0][Button::Left as usize] = state;
        rig.run(100);
        rig.device.causes().drives[Axis::Horizontal as usize]
    };
    assert_eq!(left(&mut rig, ButtonState::Pressed), Cause::Button(SubsystemId::BUTTONS));
    assert_eq!(left(&mut rig, ButtonState::Released), Cause::Rule(Rule::Released));
    assert_eq!(left(&mut rig, ButtonState::Pressed), Cause::Button(SubsystemId::BUTTONS));
    rig.accepts(DETECTOR, Body::Stop);
    rig.plant.inputs.drives[Axis::Horizontal as usize].motor_open = true;
    assert_eq!(left(&mut rig, ButtonState::Pressed), Cause::Rule(Rule::Fault));
    // A drive that the monitor does not have is not moved, and pauses no program.
    let chain = Composition::REMOTE.chain.without(&[SubsystemId::NOZZLE]);
    let mut rig = Rig::new(Composition { chain, ..Composition::REMOTE });
    rig.accepts(CONTROL, quench());
    rig.run(500);
    rig.plant.inputs.buttons[0][Button::Narrow as usize] = ButtonState::Pressed;
    rig.run(100);
    assert!(!control(&mut rig).contains(ControlFlags::PAUSED));
}

/// §1/3, §3.14/1, §3.15/1 A program has no business with a drive that the monitor does not have: it runs on,
/// whatever its inputs say, and the others go where they are to go.
#[test]
fn programs_without_a_drive() {
    let absent = |id: SubsystemId| {
        let chain = Composition::REMOTE.chain.without(&[id]);
        let mut rig = Rig::new(Composition { chain, ..Composition::REMOTE });
        let axis = Axis::ALL.into_iter().find(|axis| axis.id() == id).unwrap();
        let input = &mut rig.plant.inputs.drives[axis as usize];
        (input.motor_open, input.position_sensor_fault) = (true, true);
        rig.power_cycle_and_settle();
        rig
    };
    // One point, 10° to the left and up, for 10 s.
    let trajectory = [0x5C, CONTROL.0, 0, 9, 0, 0, 1, 0x58, 0x02, 0x58, 0x02, 0, 100];
    for id in [SubsystemId::NOZZLE, SubsystemId::HORIZONTAL, SubsystemId::VERTICAL] {
        for start in [payload(&[Request::new(CONTROL, quench())]), trajectory.to_vec()] {
            let mut rig = absent(id);
            assert_eq!(rig.handle(&start)[0].status, Status::ACCEPTED, "{id}");
            rig.run_while(5000, |rig| rig.plant.outputs.drives.iter().all(|drive| !drive.cut));
            let flags = control(&mut rig);
            let faults = ControlFlags::INTERNAL_FAULT | ControlFlags::MODE_FAULT;
            let runs = flags.contains(ControlFlags::QUENCH) && !flags.intersects(faults);
            assert!(runs, "{id} {flags:?}");
            assert_eq!(rig.get(Param::GeneralInputFaults), Ok(vec![0]), "{id}");
            for axis in [Axis::Horizontal, Axis::Vertical] {
                let aimed = rig.plant.position(axis) != 0;
                assert_eq!(aimed, axis.id() != id, "{axis:?} without {id}");
            }
        }
    }
}

/// §3.3.10/1 A monitor without valves has none to open by a button, and says nothing of one.
#[test]
fn valve_buttons_without_valves() {
    let chain = Composition::REMOTE.chain.without(&[SubsystemId::VALVE1, SubsystemId::VALVE2]);
    let mut rig = Rig::new(Composition { chain, ..Composition::REMOTE });
    rig.plant.inputs.buttons[0][Button::Open as usize] = ButtonState::Pressed;
    rig.run(100);
    let causes = rig.device.causes().valves;
    assert_eq!(causes, [Cause::Rule(Rule::Absent); 2]);
    assert_eq!(rig.plant.outputs.valves, [ValveOutput::Off; 2]);
}

/// A Stop to a valve at rest is not the cause of its rest.
#[test]
fn what_stands_keeps_its_cause() {
    let mut rig = Rig::deployed();
    rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::OPEN);
    rig.accepts(SubsystemId::VALVE1, Body::Stop);
    rig.run(50);
    assert_eq!(rig.device.causes().valves[0], Cause::Rule(Rule::Arrived));
}

/// §3.3.1, §3.3/1 Terminated, while it restarts, of every drive at rest; and of all but drives.
#[test]
fn terminated_when_it_stands() {
    let mut rig = Rig::deployed();
    rig.all_accept(Body::Restart);
    rig.plant.inputs.drives[Axis::Vertical as usize].speed_tenths = 20;
    rig.device.step(rig.now_ms, &mut rig.plant);
    for (id, terminated) in [
        (SubsystemId::VERTICAL, false),
        (SubsystemId::HORIZONTAL, true),
        (SubsystemId::GENERAL, true),
        (SubsystemId::VALVE1, true),
    ] {
        let flags = CommonFlags::from_bits_retain(rig.flags(id));
        assert!(flags.contains(CommonFlags::RESTARTING), "{id}");
        assert_eq!(flags.contains(CommonFlags::TERMINATED), terminated, "{id}");
    }
}

/// The same state is the same but for the clock and the noise of the pressure sensor.
#[test]
fn the_same_state() {
    let mut rig = Rig::deployed();
    rig.run(5000);
    let before = rig.device.clone();
    assert!(before.is_same_state(&rig.device));
    rig.plant.inputs.pressure_ua += 1;
    rig.run(100);
    assert!(before != rig.device);
    assert!(before.is_same_state(&rig.device) && rig.device.is_same_state(&before));
    rig.move_to(Axis::Horizontal, 600);
    assert!(!before.is_same_state(&rig.device));
}

/// §C/3 Bare records: each is answered when it is whole, however the bytes come; none of them is a
/// frame.
#[test]
fn a_connection_of_records() {
    let spec = Param::GeneralAddress.spec();
    let requests = [
        Request::new(SubsystemId::HORIZONTAL, Body::GetStatus),
        Request::new(SubsystemId::GENERAL, Body::GetParam { id: spec.id }),
        Request::new(SubsystemId::VERTICAL, Body::Move { destination: 600 }),
    ];
    let whole = payload(&requests);
    for piece in 1..=whole.len() {
        let mut rig = Rig::deployed();
        let mut port = RecordPort::new(Source::Radio);
        let mut answers = vec![];
        let mut out = [0; 512];
        for mut bytes in whole.chunks(piece) {
            while !bytes.is_empty() {
                let (taken, len) = port.receive(rig.now_ms, &mut rig.device, bytes, &mut out);
                let records = replies(&out[..len]);
                assert!(records.len() <= 1, "each by itself");
                answers.extend(records);
                bytes = &bytes[taken..];
            }
        }
        let brief: Vec<_> = answers.iter().map(|a| (a.from, a.status, a.data.len())).collect();
        let expected = [
            (SubsystemId::HORIZONTAL, Status::OK, 8),
            (SubsystemId::GENERAL, Status::OK, 6),
            (SubsystemId::VERTICAL, Status::ACCEPTED, 0),
        ];
        assert_eq!(brief, expected, "{piece}");
        rig.run(200);
        assert!(rig.drive_flags(Axis::Vertical).contains(DriveFlags::MOVE));
        let cause = rig.device.causes().drives[Axis::Vertical as usize];
        assert!(matches!(cause, Cause::Request(by) if by.source == Source::Radio), "{cause:?}");
    }
}

/// §C/3 The longest record there can be, and one that is never finished.
#[test]
fn records_of_any_length() {
    let mut rig = Rig::deployed();
    let mut port = RecordPort::new(Source::ExternalConn);
    let mut out = [0; 512];
    let mut longest = vec![0xD4, SubsystemId::GENERAL.0, 0, 255];
    longest.resize(4 + 255, 0xAA);
    longest.extend([0xD4, SubsystemId::GENERAL.0, 0, 0]);
    let (taken, len) = port.receive(rig.now_ms, &mut rig.device, &longest, &mut out);
    assert_eq!(taken, 4 + 255);
    assert_eq!(replies(&out[..len])[0].status, Status::WRONG_DATA);
    let (rest, len) = port.receive(rig.now_ms, &mut rig.device, &longest[taken..], &mut out);
    assert_eq!((rest, replies(&out[..len])[0].status), (4, Status::OK));
    let (taken, len) = port.receive(rig.now_ms, &mut rig.device, &longest[..100], &mut out);
    assert_eq!((taken, len), (100, 0));
    rig.run(100);
}

/// §C/3 A record that was cut short swallows nothing that comes a second later; one that comes in pieces is whole.
#[test]
fn a_record_cut_short() {
    let stop = payload(&[Request::new(SubsystemId::ALL, Body::Stop)]);
    let long = [0xD4, SubsystemId::GENERAL.0, 0, 255, 1, 2];
    for cut in 1..long.len() {
        for start_ms in [0, u32::MAX - 300] {
            let mut rig = Rig::at(Composition::REMOTE, start_ms);
            rig.move_to(Axis::Horizontal, 9000);
            rig.run(300);
            let mut port = RecordPort::new(Source::Radio);
            let mut out = [0; 512];
            port.receive(rig.now_ms, &mut rig.device, &long[..cut], &mut out);
            rig.run(1000);
            let (taken, len) = port.receive(rig.now_ms, &mut rig.device, &stop, &mut out);
            assert!(taken == stop.len() && len > 0, "{cut}");
            rig.run(20);
            assert!(rig.is_still());
            let (head, rest) = stop.split_at(2);
            assert_eq!(port.receive(rig.now_ms, &mut rig.device, head, &mut out), (2, 0));
            rig.run(900);
            let (_, len) = port.receive(rig.now_ms, &mut rig.device, rest, &mut out);
            assert!(len > 0);
        }
    }
}

/// §D/9 During a program a nozzle that rests within 1 mm of its position has arrived.
#[test]
fn the_nozzle_of_a_program_comes_to_rest() {
    let mut rig = Rig::new(Composition::REMOTE);
    let sector = Sector { centre_h: 0, centre_v: 0, nozzle: 40, width: 0, height: 0, step: 0 };
    rig.accepts(CONTROL, Body::StartQuench(Quench::Full { sector, distance: 0 }));
    rig.run_until(20_000, |rig| rig.drive(Axis::Nozzle).position == 40);
    rig.run(500);
    for at in [39, 41] {
        rig.plant.place(Axis::Nozzle, at);
        rig.run_while(2000, |rig| rig.speed(Axis::Nozzle) == 0);
    }
    rig.plant.place(Axis::Nozzle, 37);
    rig.run_until(5000, |rig| rig.drive(Axis::Nozzle).position == 40);
    assert!(rig.flags(CONTROL) & ControlFlags::QUENCH.bits() != 0);
}
