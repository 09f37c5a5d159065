//! The monitor as a whole: lockout, restart, crash data, supply, climate, interfaces, links.

use crate::common::{ADDRESS, Plant, Rig, payload};
use lafet_device::image::{Axis, Outputs, Place, PlaceInput, ValveOutput};
use lafet_device::port::{Port, Probes, datagram};
use lafet_device::{Composition, Device, Source};
use lafet_proto::flags::{
    Button, ButtonState, ClimaticsFlags, CommonFlags, ConnFlags, DeployerFlags, GeneralFlags,
    ValveFlags,
};
use lafet_proto::id::key;
use lafet_proto::link::{self, Check, Frame, WIRE_MAX};
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::status::{FaultInfo, ThermoStatus};
use lafet_proto::{Request, RequestId, Status, SubsystemId};

const ENABLE: Body<'static> = Body::Lockout { key: key::ENABLE };
const DISABLE: Body<'static> = Body::Lockout { key: key::DISABLE };

/// Water on, a drive under way.
fn busy() -> Rig {
    let mut rig = Rig::deployed();
    rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    rig.run(5000);
    rig.move_to(Axis::Horizontal, 9000);
    rig.run(500);
    rig
}

/// Something is wrong with everything that is sensed.
fn spoil(plant: &mut Plant) {
    let inputs = &mut plant.inputs;
    for place in &mut inputs.places {
        (place.temperature_dc, place.heater_fault) = (None, true);
    }
    (inputs.humidity_percent, inputs.main_voltage_dv, inputs.pressure_ua) = (None, 100, 3_000);
    inputs.flow_lps = 40;
    (inputs.detector.ready, inputs.detector.dirty_lens) = (false, true);
    let states = [ButtonState::Pressed, ButtonState::Short, ButtonState::Open];
    for (button, state) in inputs.buttons.iter_mut().flatten().zip(states.into_iter().cycle()) {
        *button = state;
    }
    for drive in &mut inputs.drives {
        (drive.motor_open, drive.position_sensor_fault) = (true, true);
    }
    for valve in &mut inputs.valves {
        (valve.blocked, valve.open_sensor_fault) = (true, true);
    }
    for unit in &mut plant.units {
        unit.offline = true;
    }
    plant.advance(0);
}

/// §D/1 What is asked before the first step is answered as behind it: by what the sensors say, and that no contact
/// counts yet.
#[test]
fn asked_before_the_first_step() {
    for composition in Composition::ALL {
        for broken in [false, true] {
            let mut rig = Rig::new(composition);
            // Else they begin to close and have arrived a step later.
            rig.set(Param::GeneralResetValves, 1);
            rig.set(Param::NozzleTrvPosition, 10);
            rig.run(100);
            if broken {
                spoil(&mut rig.plant);
            }
            rig.power_cycle();
            let before = rig.ask(SubsystemId::ALL, Body::GetStatus);
            let general = rig.general();
            rig.step(1);
            for (before, behind) in before.iter().zip(rig.ask(SubsystemId::ALL, Body::GetStatus)) {
                assert_eq!(*before, behind, "{}, broken: {broken}", composition.name);
            }
            assert_eq!(general.main_voltage, if broken { 10 } else { 24 });
            if rig.device.has(SubsystemId::CLIMATICS) {
                let flags = rig.flags(SubsystemId::CLIMATICS);
                assert_eq!(flags != 0, broken, "{flags:#x}");
            }
        }
    }
}

/// §3.18/1, §3.18/8 Everything stops, valves close, every subsystem answers in chain order; a closing valve
/// has only accepted it, and General as long as the lockout is not stored.
#[test]
fn lockout_on() {
    let mut rig = busy();
    let answers = rig.ask(SubsystemId::ALL, ENABLE);
    let from: Vec<_> = answers.iter().map(|answer| answer.from).collect();
    assert_eq!(from, SubsystemId::CHAIN);
    for answer in &answers {
        let lasts = matches!(answer.from, SubsystemId::VALVE1 | SubsystemId::GENERAL);
        let expected = if lasts { Status::ACCEPTED } else { Status::OK };
        assert_eq!(answer.status, expected, "{}", answer.from);
    }
    rig.run_while(8000, |rig| rig.is_still() && rig.valve_output(0) != ValveOutput::Opening);
    assert_eq!(rig.valve(SubsystemId::VALVE1), ValveFlags::CLOSED);
    assert_eq!(rig.general().flags, GeneralFlags::LOCKED_OUT);
    // Repeated it is no harm, and says that it is stored.
    let answers = rig.ask(SubsystemId::ALL, ENABLE);
    assert!(answers.iter().all(|answer| answer.status == Status::OK), "{answers:?}");
}

/// §3.18/8 General's Ok says that the lockout, or its release, outlives a power loss; a memory that
/// takes nothing never lets it say so, and is reported by ConfigWriteFault.
#[test]
fn lockout_accepted_and_stored() {
    let general = |rig: &mut Rig, body| {
        let answers = rig.ask(SubsystemId::ALL, body);
        answers.iter().find(|answer| answer.from == SubsystemId::GENERAL).unwrap().status
    };
    let mut rig = Rig::deployed();
    assert_eq!(general(&mut rig, DISABLE), Status::OK);
    assert_eq!(general(&mut rig, ENABLE), Status::ACCEPTED);
    assert_eq!(general(&mut rig, ENABLE), Status::ACCEPTED);
    rig.step(10);
    assert_eq!(general(&mut rig, ENABLE), Status::OK);
    let mut locked = rig.clone();
    locked.power_cycle();
    assert!(locked.general().flags.contains(GeneralFlags::LOCKED_OUT));
    rig.plant.store_fails = true;
    assert_eq!(general(&mut rig, DISABLE), Status::ACCEPTED);
    rig.run(1000);
    assert_eq!(general(&mut rig, DISABLE), Status::ACCEPTED);
    assert!(rig.general().flags.contains(GeneralFlags::CONFIG_WRITE_FAULT));
    rig.power_cycle();
    assert!(rig.general().flags.contains(GeneralFlags::LOCKED_OUT));
}

/// §3.18/4 The release: nothing resumes by itself, everything works.
#[test]
fn lockout_off() {
    let mut rig = busy();
    rig.all_accept(ENABLE);
    rig.run(8000);
    rig.all_accept(DISABLE);
    assert_eq!(rig.general().flags, GeneralFlags::empty());
    let off = rig.plant.outputs.valves;
    rig.run_while(2000, |rig| rig.is_still() && rig.plant.outputs.valves == off);
    rig.move_to(Axis::Horizontal, 0);
    rig.run(100);
    assert!(rig.speed(Axis::Horizontal) < 0);
    rig.all_accept(DISABLE);
    rig.run(100);
    assert!(rig.speed(Axis::Horizontal) < 0, "a release stops nothing");
}

/// §3.18/3 Locked out, nothing that SetParam sets moves anything before the release.
#[test]
fn set_param_under_lockout() {
    let mut rig = Rig::deployed();
    rig.all_accept(ENABLE);
    rig.run(100);
    for (param, value) in [
        (Param::VerticalMinLimit, 600),
        (Param::VerticalZeroPoint, -2000),
        (Param::DeployerMaxLimit, 9000),
        (Param::GeneralMoveTimeout, 100),
    ] {
        assert_eq!(rig.set(param, value), Status::ACCEPTED);
        assert_eq!(rig.get(param), Ok(vec![value]));
        rig.run_while(300, |rig| rig.is_still());
    }
}

/// §3.18/5 Another key changes nothing, whether locked or not.
#[test]
fn lockout_with_another_key() {
    let mut rig = busy();
    for wrong in [0, key::OPEN, key::ENABLE.swap_bytes()] {
        let answers = rig.ask(SubsystemId::ALL, Body::Lockout { key: wrong });
        assert!(answers.iter().all(|answer| answer.status == Status::INVALID_VALUE));
    }
    rig.run(50);
    assert!(rig.speed(Axis::Horizontal) > 0);
    rig.all_accept(ENABLE);
    rig.ask(SubsystemId::ALL, Body::Lockout { key: 0 });
    assert_eq!(rig.general().flags, GeneralFlags::LOCKED_OUT);
}

/// §3.18/1 A lockout while it deploys stops in between; a wrapped monitor stays wrapped.
#[test]
fn lockout_while_deploying() {
    let mut rig = Rig::new(Composition::FULL);
    rig.accepts(SubsystemId::DEPLOYER, Body::Deploy);
    rig.run(1000);
    rig.all_accept(ENABLE);
    rig.run(10);
    rig.run_while(1000, |rig| rig.is_still());
    let position = DeployerFlags::DEPLOYED | DeployerFlags::DEPLOYING | DeployerFlags::WRAPPED;
    assert!((rig.deployer() & position).is_empty());
}

/// §3.12/1, §3.12/2 Restart: everything ends, 200 ms later the program resets; until then Restarting,
/// and Terminated where nothing moves. Also while the clock wraps (§D/3).
#[test]
fn restart() {
    for now_ms in [0, u32::MAX - 100] {
        let mut rig = Rig::at(Composition::FULL, now_ms);
        rig.deploy();
        rig.now_ms = now_ms;
        rig.device.step(now_ms, &mut rig.plant);
        rig.move_to(Axis::Horizontal, 9000);
        rig.run(20);
        rig.all_accept(Body::Restart);
        rig.run(20);
        let both = CommonFlags::RESTARTING | CommonFlags::TERMINATED;
        for id in SubsystemId::TABLE {
            let flags = CommonFlags::from_bits_retain(rig.flags(id) & 0xFFFF);
            assert_eq!(flags - CommonFlags::CONN_LOST, both, "{id}");
        }
        rig.run_while(160, |rig| rig.is_still() && rig.plant.resets == 0);
        rig.run(30);
        assert_eq!(rig.plant.resets, 1);
        assert_eq!(rig.flags(SubsystemId::GENERAL), 0);
        rig.run_while(1000, |rig| rig.is_still());
    }
}

/// §3.12/2 While a reset is awaited Stop, Close and Lockout are carried out; a release, or anything that begins, is
/// Busy. With ResetValves the water would run on over the reset.
#[test]
fn what_ends_is_carried_out_before_a_reset() {
    let restarting = || {
        let mut rig = Rig::deployed();
        rig.set(Param::GeneralResetValves, 1);
        rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
        rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::OPEN);
        rig.all_accept(Body::Restart);
        rig.run(20);
        rig
    };
    let mut closed = restarting();
    let close = Body::Close { key: key::CLOSE };
    assert_eq!(closed.status(SubsystemId::VALVE1, close), Status::ACCEPTED);
    let release = Body::Lockout { key: key::DISABLE };
    for (to, body) in [
        (SubsystemId::ALL, release),
        (SubsystemId::ALL, Body::Restart),
        (SubsystemId::VALVE2, Body::Open { key: key::OPEN }),
        (SubsystemId::VERTICAL, Body::Move { destination: 60 }),
    ] {
        assert_eq!(closed.one(to, body), (SubsystemId::GENERAL, Status::BUSY), "{body:?}");
    }
    closed.all_accept(Body::Stop);
    let mut locked = restarting();
    let mut full = locked.clone();
    locked.all_accept(Body::Lockout { key: key::ENABLE });
    // Behind more than the answers have room for.
    let mut frame = payload(&[Request::new(SubsystemId::ALL, Body::GetStatus); 8]);
    frame.extend(payload(&[Request::lockout(true)]));
    full.handle(&frame);
    for rig in [&mut locked, &mut full] {
        rig.run(500);
        assert_eq!(rig.plant.resets, 1);
        assert!(rig.general().flags.contains(GeneralFlags::LOCKED_OUT));
        rig.run_until(6000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::CLOSED);
    }
}

/// §3.19/1, §3.18/1, §3.18/6 A lockout that comes before the memory is erased is not erased with it, and its valve
/// closes without a moment's rest.
#[test]
fn a_lockout_before_the_memory_is_erased() {
    let mut rig = Rig::deployed();
    rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    rig.run_until(6000, |rig| rig.valve(SubsystemId::VALVE1).contains(ValveFlags::OPEN));
    rig.accepts(SubsystemId::GENERAL, Body::CleanFlash { key: key::CLEAN_FLASH });
    rig.run(50);
    rig.all_accept(Body::Lockout { key: key::ENABLE });
    rig.run_while(500, |rig| rig.valve_output(0) == ValveOutput::Closing);
    let flags = GeneralFlags::LOCKED_OUT | GeneralFlags::CONFIG_WRITE_FAULT;
    assert_eq!((rig.plant.resets, rig.general().flags), (0, flags));
    rig.power_cycle_and_settle();
    assert!(rig.general().flags.contains(GeneralFlags::LOCKED_OUT));
}

/// §3.12 Before the reset everything is driven inert once more.
#[test]
fn the_reset_leaves_nothing_driven() {
    let mut rig = busy();
    rig.all_accept(Body::Restart);
    for _ in 0..19 {
        rig.step(10);
        assert_eq!(rig.valve_output(0), ValveOutput::Closing);
    }
    let mut plant = rig.plant.clone();
    rig.device.step(rig.now_ms + 50, &mut plant);
    assert!(plant.reset_requested);
    assert_eq!(plant.outputs, Outputs::default());
}

/// §3.20/1 Crash data: the words of the fault in GetCrashData, to General and to All, and in GetParam
/// FaultInfo; nothing recorded: all zero.
#[test]
fn crash_data() {
    let words: [u32; 20] = std::array::from_fn(|number| 0xC0DE_0000 + number as u32);
    for (crash, words) in [(Some(FaultInfo::from_words(words)), words), (None, [0; 20])] {
        let mut plant = Plant::of(&Composition::MINI);
        Device::provision(&mut plant, &Composition::MINI, 1).unwrap();
        let device = Device::power_up(0, &Composition::MINI, 1, crash, &mut plant);
        let mut rig = Rig { device, ..Rig::power_up(Composition::MINI, plant, 0) };
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        for to in [SubsystemId::GENERAL, SubsystemId::ALL] {
            let answers = rig.ask(to, Body::GetCrashData);
            assert_eq!(answers.len(), 1);
            assert_eq!((answers[0].from, answers[0].status), (SubsystemId::GENERAL, Status::OK));
            assert_eq!(answers[0].data, bytes);
        }
        let values: Vec<i32> = words.iter().map(|word| word.cast_signed()).collect();
        assert_eq!(rig.get(Param::GeneralFaultInfo), Ok(values));
    }
}

/// §3.3.1/4 BadPower outside the limits, in General alone.
#[test]
fn supply() {
    let mut rig = Rig::new(Composition::REMOTE);
    for (volts, bad) in [(18, false), (17, true), (32, false), (33, true), (24, false)] {
        rig.plant.inputs.main_voltage_dv = volts * 10;
        rig.run(20);
        let general = rig.general();
        assert_eq!(general.main_voltage, volts);
        assert_eq!(general.flags.contains(GeneralFlags::BAD_POWER), bad, "{volts} V");
        assert_eq!(rig.flags(SubsystemId::VERTICAL) & 0xFFFF, 0);
    }
    rig.set(Param::GeneralMainVoltageMin, 25);
    rig.run(20);
    assert!(rig.general().flags.contains(GeneralFlags::BAD_POWER));
}

/// §3.3.1/4 A supply that is bad for 0.3 s forbids what would begin, until it has been good for as long: by
/// General. What goes on goes on; Stop, Close and Lockout are carried out, and the lockout alone is written.
#[test]
fn what_a_bad_supply_forbids() {
    const GENERAL: SubsystemId = SubsystemId::GENERAL;
    const OPEN: Body<'static> = Body::Open { key: key::OPEN };
    for volts in [9, 40] {
        let mut rig = Rig::deployed();
        let written = rig.plant.written.len();
        rig.move_to(Axis::Horizontal, 9000);
        rig.run(500);
        rig.plant.inputs.main_voltage_dv = volts * 10;
        rig.run(290);
        // A sag of a starting motor.
        rig.accepts(SubsystemId::VALVE1, OPEN);
        rig.run(20);
        for (to, body) in [
            (SubsystemId::VERTICAL, Body::Move { destination: 60 }),
            (SubsystemId::DEPLOYER, Body::Move { destination: 60 }),
            (SubsystemId::VALVE2, OPEN),
            (SubsystemId::DEPLOYER, Body::Deploy),
            (SubsystemId::DETECTOR, Body::StartJustify),
            (GENERAL, Body::CleanFlash { key: key::CLEAN_FLASH }),
        ] {
            let (from, status) = rig.one(to, body);
            let water = to == SubsystemId::DEPLOYER && matches!(body, Body::Move { .. });
            let expected = if water { SubsystemId::VALVE1 } else { GENERAL };
            assert_eq!((from, status), (expected, Status::DENIED), "{body:?}");
        }
        assert!(rig.speed(Axis::Horizontal) > 0 && rig.valve_output(0) != ValveOutput::Off);
        rig.accepts(SubsystemId::VALVE1, Body::Close { key: key::CLOSE });
        rig.all_accept(Body::Stop);
        rig.run(20);
        assert!(rig.is_still());
        assert_eq!(rig.set(Param::GeneralMoveTimeout, 5000), Status::ACCEPTED);
        rig.run(1000);
        assert_eq!(rig.plant.written.len(), written);
        rig.plant.inputs.main_voltage_dv = 240;
        rig.run(250);
        assert_eq!(rig.one(SubsystemId::VALVE2, OPEN), (GENERAL, Status::DENIED));
        rig.run(100);
        rig.accepts(SubsystemId::VALVE2, OPEN);
        rig.all_accept(Body::Stop);
        rig.run(100);
        assert!(rig.plant.written.len() > written);
        // The lockout is as binding on a bad supply, over a loss of it too.
        rig.plant.inputs.main_voltage_dv = volts * 10;
        rig.run(400);
        rig.all_accept(ENABLE);
        rig.run(100);
        rig.power_cycle_and_settle();
        assert!(rig.general().flags.contains(GeneralFlags::LOCKED_OUT));
    }
}

/// §3.3.1/4, §3.3.10/1 A button that is held on goes on, one that is pressed then does nothing.
#[test]
fn buttons_on_a_bad_supply() {
    let pressed = ButtonState::Pressed;
    let mut rig = Rig::new(Composition::REMOTE);
    rig.plant.inputs.buttons[0][Button::Left as usize] = pressed;
    rig.run(200);
    rig.plant.inputs.main_voltage_dv = 90;
    rig.run(400);
    rig.plant.inputs.buttons[0][Button::Up as usize] = pressed;
    rig.plant.inputs.buttons[0][Button::Open as usize] = pressed;
    rig.run_while(300, |rig| {
        rig.speed(Axis::Horizontal) > 0
            && rig.speed(Axis::Vertical) == 0
            && rig.valve_output(0) == ValveOutput::Off
    });
}

/// §3.3.2/1 A broken or shorted pressure sensor: its flag, and the pressure reads 0.
#[test]
fn pressure() {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.plant.inputs.flow_lps = 21;
    for (microamps, datm, flags) in [
        (4000, 0, GeneralFlags::empty()),
        (12_000, 80, GeneralFlags::empty()),
        (20_000, 160, GeneralFlags::empty()),
        (3000, 0, GeneralFlags::PRESSURE_SENSOR_BREAK),
        (0, 0, GeneralFlags::PRESSURE_SENSOR_BREAK),
        (22_000, 0, GeneralFlags::PRESSURE_SENSOR_SHORT),
        (8000, 40, GeneralFlags::empty()),
    ] {
        rig.plant.inputs.pressure_ua = microamps;
        rig.run(40);
        let general = rig.general();
        assert_eq!((general.pressure, general.flags), (datm, flags), "{microamps} µA");
        assert_eq!(general.flowrate, 21);
    }
    rig.set(Param::GeneralPressureRange, 400);
    rig.run(20);
    assert_eq!(rig.general().pressure, 100);
}

/// §3.3.2/1 A wire that blips is not broken: the pressure stays what it was, and a barrel that extinguishes where it is.
#[test]
fn a_pressure_that_blips() {
    let mut rig = Rig::new(Composition::REMOTE);
    for microamps in [0, 22_000] {
        for ms in 0..1000 {
            rig.plant.inputs.pressure_ua = if ms % 60 < 30 { microamps } else { 12_000 };
            rig.step(1);
            if ms > 100 {
                let general = rig.general();
                assert_eq!((general.pressure, general.flags), (80, GeneralFlags::empty()));
            }
        }
        rig.plant.inputs.pressure_ua = microamps;
        for ms in 1..=40 {
            rig.step(1);
            assert_eq!(rig.general().flags.is_empty(), ms <= 30, "{ms}");
        }
        // Of what is faulty from the start on there is no pressure that was.
        rig.power_cycle();
        assert!(!rig.general().flags.is_empty());
        rig.plant.inputs.pressure_ua = 12_000;
        rig.run(100);
    }
}

fn climate(rig: &mut Rig) -> ThermoStatus {
    let data = rig.ask(SubsystemId::CLIMATICS, Body::GetStatus)[0].data.clone();
    ThermoStatus::from_bytes(data.try_into().unwrap())
}

/// §3.3.3, §3.3.3/1 Each place heats for itself: on below HeatOn, off above HeatOff, between as it was; a
/// fault switches it off and shows.
#[test]
fn heating() {
    use ClimaticsFlags as F;
    const OF: [(Place, F, F, F); 5] = [
        (Place::Horizontal, F::HORIZONTAL_HEAT, F::HORIZONTAL_FAULT, F::HORIZONTAL_SENSOR_FAULT),
        (Place::Vertical, F::VERTICAL_HEAT, F::VERTICAL_FAULT, F::VERTICAL_SENSOR_FAULT),
        (Place::Nozzle, F::NOZZLE_HEAT, F::NOZZLE_FAULT, F::NOZZLE_SENSOR_FAULT),
        (Place::Deployer, F::DEPLOYER_HEAT, F::DEPLOYER_FAULT, F::DEPLOYER_SENSOR_FAULT),
        (Place::Box, F::BOX_HEAT, F::BOX_FAULT, F::BOX_SENSOR_FAULT),
    ];
    for (place, heat, fault, sensor) in OF {
        let mut rig = Rig::new(Composition::FULL);
        assert_eq!(climate(&mut rig).flags, F::empty());
        for (temperature_dc, on) in [
            (50, false),
            (49, true),
            (60, true),
            (80, true),
            (81, false),
            (50, false),
            (-300, true),
        ] {
            rig.plant.inputs.places[place as usize].temperature_dc = Some(temperature_dc);
            rig.run(20);
            let mut heaters = [false; 5];
            heaters[place as usize] = on;
            assert_eq!(rig.plant.outputs.heaters, heaters, "{temperature_dc}");
            assert_eq!(climate(&mut rig).flags, if on { heat } else { F::empty() });
        }
        let shown = climate(&mut rig);
        let all = [shown.horizontal, shown.vertical, shown.nozzle, shown.deployer, shown.housing];
        assert_eq!((all[place as usize], shown.humidity), (-300, 40));
        rig.plant.inputs.places[place as usize].heater_fault = true;
        rig.run(50);
        assert_eq!((rig.plant.outputs.heaters, climate(&mut rig).flags), ([false; 5], fault));
        rig.plant.inputs.places[place as usize] = PlaceInput::default();
        rig.plant.inputs.humidity_percent = None;
        rig.run(20);
        let shown = climate(&mut rig);
        assert_eq!(shown.flags, sensor | F::HUMIDITY_SENSOR_FAULT);
        assert_eq!((rig.plant.outputs.heaters, shown.humidity), ([false; 5], 0));
    }
}

/// §3.18/1 The heating goes on under lockout: it protects and moves nothing.
#[test]
fn heating_under_lockout() {
    let mut rig = Rig::new(Composition::FULL);
    rig.all_accept(ENABLE);
    rig.plant.inputs.places[Place::Box as usize].temperature_dc = Some(-200);
    rig.run(20);
    assert!(rig.plant.outputs.heaters[Place::Box as usize]);
}

/// §3.3.9, §3.3.9/1, §D/3 ConnLost until the first control request and 3 s after the last, of that
/// interface alone; reads do not count, a Denied request does; also while the clock wraps.
#[test]
fn conn_lost() {
    let lost = ConnFlags::CONN_LOST;
    let empty = ConnFlags::empty();
    for now_ms in [0, u32::MAX - 1000] {
        let mut rig = Rig::at(Composition::FULL, now_ms);
        assert_eq!(rig.conn(SubsystemId::EXTERNAL_CONN), lost);
        rig.get(Param::VerticalSpeed).unwrap();
        rig.ask(SubsystemId::ALL, Body::GetStatus);
        rig.ask(SubsystemId::ALL, DISABLE);
        rig.set(Param::VerticalSpeed, 9);
        rig.run(100);
        assert_eq!(rig.conn(SubsystemId::EXTERNAL_CONN), lost);
        let denied = rig.one(SubsystemId::VERTICAL, Body::Move { destination: 0 });
        assert_eq!(denied.1, Status::DENIED);
        assert_eq!(rig.conn(SubsystemId::EXTERNAL_CONN), empty);
        assert_eq!(rig.conn(SubsystemId::RADIO), lost);
        rig.run(2990);
        assert_eq!(rig.conn(SubsystemId::EXTERNAL_CONN), empty);
        rig.run(10);
        assert_eq!(rig.conn(SubsystemId::EXTERNAL_CONN), lost);
        rig.source = Source::Radio;
        rig.set(Param::RadioTimeout, 500);
        rig.ask(SubsystemId::ALL, Body::Stop);
        rig.run(490);
        assert_eq!(rig.conn(SubsystemId::RADIO), empty);
        assert_eq!(rig.conn(SubsystemId::EXTERNAL_CONN), lost);
        rig.run(10);
        assert_eq!(rig.conn(SubsystemId::RADIO), lost);
    }
}

/// §3.3.9/1 Which requests count as control.
#[test]
fn what_counts_as_control() {
    let control = [
        RequestId::MOVE,
        RequestId::STOP,
        RequestId::OPEN,
        RequestId::CLOSE,
        RequestId::DEPLOY,
        RequestId::WRAP,
        RequestId::START_QUENCH,
        RequestId::START_SEEK,
        RequestId::START_TRAJECTORY,
    ];
    let rig = Rig::new(Composition::FULL);
    for request in 0..=255 {
        let mut rig = rig.clone();
        rig.handle(&[request, 0xC2, 0, 0]);
        let counts = control.contains(&RequestId(request));
        let flags = rig.conn(SubsystemId::EXTERNAL_CONN);
        assert_eq!(!flags.contains(ConnFlags::CONN_LOST), counts, "{request:#04x}");
    }
}

/// §1/1, §1/5, §3.3/1 The chain's order, whole and with gaps.
#[test]
fn chain_order() {
    for composition in Composition::ALL {
        let mut rig = Rig::new(composition);
        let from: Vec<_> =
            rig.ask(SubsystemId::ALL, Body::GetStatus).iter().map(|a| a.from).collect();
        let present: Vec<_> =
            SubsystemId::CHAIN.into_iter().filter(|id| composition.chain.contains(*id)).collect();
        assert_eq!(from, present, "{}", composition.name);
        let motors: Vec<_> =
            rig.ask(SubsystemId::MOTORS, Body::GetStatus).iter().map(|a| a.from).collect();
        assert!(motors.iter().all(|id| id.is_drive()));
        assert_eq!(Composition::by_name(composition.name), Some(&composition));
    }
    assert_eq!(Composition::by_name("none"), None);
    // §1/7 No subsystem to answer: General does.
    let chain = Composition::FULL.chain.without(&[
        SubsystemId::VERTICAL,
        SubsystemId::HORIZONTAL,
        SubsystemId::NOZZLE,
        SubsystemId::DEPLOYER,
    ]);
    let mut rig = Rig::new(Composition { chain, ..Composition::FULL });
    let answer = rig.one(SubsystemId::MOTORS, Body::GetStatus);
    assert_eq!(answer, (SubsystemId::GENERAL, Status::WRONG_REQUEST));
}

/// §1/8 Requests of a frame are executed in their order.
#[test]
fn requests_in_their_order() {
    let mut rig = Rig::new(Composition::REMOTE);
    let requests = [
        Request::new(SubsystemId::VERTICAL, Body::Move { destination: 3000 }),
        Request::lockout(true),
        Request::new(SubsystemId::VERTICAL, Body::Move { destination: 600 }),
        Request::lockout(false),
        Request::new(SubsystemId::HORIZONTAL, Body::Move { destination: 600 }),
    ];
    let answers = rig.handle(&payload(&requests));
    let moves: Vec<_> = answers
        .iter()
        .filter(|answer| answer.data.is_empty() && answer.status != Status::OK)
        .map(|answer| (answer.from, answer.status))
        .collect();
    assert_eq!(
        moves,
        [
            (SubsystemId::VERTICAL, Status::ACCEPTED),
            (SubsystemId::GENERAL, Status::ACCEPTED),
            (SubsystemId::GENERAL, Status::DENIED),
            (SubsystemId::GENERAL, Status::ACCEPTED),
            (SubsystemId::HORIZONTAL, Status::ACCEPTED),
        ]
    );
    rig.run(100);
    assert_eq!(rig.speed(Axis::Vertical), 0, "the lockout in between has ended it");
    assert!(rig.speed(Axis::Horizontal) > 0);
}

fn frame(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut wire = vec![0; WIRE_MAX];
    let len = link::encode(&Frame { dst, src, payload }, &mut wire).unwrap();
    wire.truncate(len);
    wire
}

/// §1/10, §L/3, §L/5, §L/6 A port answers each frame for this monitor once, however the bytes come; to
/// other frames, noise and its own address it keeps silent. Byte by byte it says the same.
#[test]
fn a_port_answers_its_own_frames() {
    let mut rig = Rig::new(Composition::REMOTE);
    let status = payload(&[Request::new(SubsystemId::VERTICAL, Body::GetStatus)]);
    let mut bytes = vec![0x00, 0xC0, 0x55];
    bytes.extend(frame(ADDRESS, 129, &status));
    bytes.extend(frame(2, 129, &status));
    bytes.extend(frame(ADDRESS, ADDRESS, &status));
    bytes.extend([0xFF, 0xFF]);
    bytes.extend(frame(ADDRESS, 130, &[]));
    let mut damaged = frame(ADDRESS, 131, &status);
    damaged[5] ^= 1;
    bytes.extend(damaged);
    bytes.extend(frame(ADDRESS, 132, &status));
    for piece in [1, 2, 7, bytes.len()] {
        let mut port = Port::new(Source::ExternalConn);
        let mut out = [0; WIRE_MAX];
        let (mut to, mut said) = (Vec::new(), Vec::new());
        for piece in bytes.chunks(piece) {
            let mut rest = piece;
            while !rest.is_empty() {
                let (taken, len) = port.receive(rig.now_ms, &mut rig.device, rest, &mut out);
                assert!(taken > 0);
                rest = &rest[taken..];
                if len > 0 {
                    let mut body = [0; link::BODY_MAX];
                    let answer = link::decode_datagram(&out[..len], &mut body).unwrap();
                    assert_eq!(answer.src, ADDRESS);
                    to.push((answer.dst, answer.payload.len()));
                    said.extend(&out[..len]);
                }
            }
        }
        assert_eq!(to, [(129, 12), (130, 0), (132, 12)], "in pieces of {piece}");
        assert!(port.counters().crc_errors > 0);
        let mut port = Port::new(Source::ExternalConn);
        let mut put = Vec::new();
        for piece in bytes.chunks(piece) {
            port.serve(rig.now_ms, &mut rig.device, piece, &mut |byte| put.push(byte));
        }
        assert_eq!(put, said);
        assert!(port.counters().crc_errors > 0);
    }
}

/// §L/4 A frame whose end is lost is not carried out by noise that looks like one, a second later or at any time; a
/// pause within a frame that is shorter, also while the clock wraps, takes nothing, and the next frame is heard.
#[test]
fn an_unfinished_frame_gets_stale() {
    let request = Request::new(SubsystemId::VERTICAL, Body::Move { destination: 600 });
    let wire = frame(ADDRESS, 0x80, &payload(&[request]));
    let (most, end) = wire.split_at(wire.len() - 1);
    for (pause_ms, heard) in [(10, true), (999, true), (1000, false), (600_000, false)] {
        for now_ms in [5000, u32::MAX - 300] {
            for bytewise in [false, true] {
                let mut rig = Rig::at(Composition::REMOTE, now_ms);
                let mut port = Port::new(Source::ExternalConn);
                let mut hear = |rig: &mut Rig, after_ms: u32, bytes: &[u8]| {
                    let now_ms = now_ms.wrapping_add(after_ms);
                    let mut answer = vec![];
                    if bytewise {
                        port.serve(now_ms, &mut rig.device, bytes, &mut |byte| answer.push(byte));
                        return !answer.is_empty();
                    }
                    let mut out = [0; WIRE_MAX];
                    let (taken, len) = port.receive(now_ms, &mut rig.device, bytes, &mut out);
                    assert_eq!(taken, bytes.len());
                    len > 0
                };
                assert!(!hear(&mut rig, 0, most));
                assert!(!hear(&mut rig, pause_ms - 1, &[]), "no bytes are no sign of life");
                assert_eq!(hear(&mut rig, pause_ms, end), heard, "{pause_ms}");
                rig.run(100);
                assert_eq!(rig.speed(Axis::Vertical) != 0, heard, "{pause_ms}");
                assert!(hear(&mut rig, pause_ms + 10, &wire));
            }
        }
    }
}

/// §L/7 A frame is answered in the form in which it came; an interface that wants a CRC-32C takes
/// nothing else, and the other interface is not concerned.
#[test]
fn frames_with_a_crc32c() {
    let mut rig = Rig::new(Composition::FULL);
    let status = payload(&[Request::new(SubsystemId::VALVE1, Body::GetStatus)]);
    let wire = |check| {
        let mut out = [0; WIRE_MAX];
        let frame = Frame { dst: ADDRESS, src: 129, payload: &status };
        let len = link::encode_with(check, &frame, &mut out).unwrap();
        out[..len].to_vec()
    };
    let answered = |rig: &mut Rig, source, check| {
        let (mut out, bytes) = ([0; WIRE_MAX], wire(check));
        let stream = {
            let mut port = Port::new(source);
            let (_, len) = port.receive(rig.now_ms, &mut rig.device, &bytes, &mut out);
            out[..len].to_vec()
        };
        let len =
            datagram(rig.now_ms, source, &mut Probes::new(), &mut rig.device, &bytes, &mut out);
        assert_eq!(len.map_or(&[][..], |len| &out[..len]), stream);
        assert!(stream.is_empty() || link::check_of(&stream) == check);
        !stream.is_empty()
    };
    let (wired, radio) = (Source::ExternalConn, Source::Radio);
    for (source, check) in [(wired, Check::Crc16), (wired, Check::Crc32c), (radio, Check::Crc16)] {
        assert!(answered(&mut rig, source, check));
    }
    assert_eq!(rig.set(Param::ExternalConnCheck, 1), Status::ACCEPTED);
    assert!(!answered(&mut rig, wired, Check::Crc16));
    assert!(answered(&mut rig, wired, Check::Crc32c));
    assert!(answered(&mut rig, radio, Check::Crc16));
}

/// §C/1 A datagram is a frame; nothing else is answered.
#[test]
fn datagrams() {
    let mut rig = Rig::new(Composition::REMOTE);
    let mut out = [0; WIRE_MAX];
    let mut probes = Probes::new();
    let mut ask = |bytes: &[u8]| {
        datagram(rig.now_ms, Source::Radio, &mut probes, &mut rig.device, bytes, &mut out)
    };
    let stop = payload(&[Request::new(SubsystemId::ALL, Body::Stop)]);
    assert!(ask(&frame(ADDRESS, 200, &stop)).is_some());
    assert_eq!(ask(&frame(9, 200, &stop)), None);
    assert_eq!(ask(&[]), None);
    assert_eq!(ask(&frame(ADDRESS, 200, &stop)[..6]), None);
    assert_eq!(rig.conn(SubsystemId::RADIO), ConnFlags::empty());
}
