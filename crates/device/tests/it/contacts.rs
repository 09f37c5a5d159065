//! §D/6 Contacts that bounce and blip, in what they decide: for 1 to 30 ms nothing, then everything.

use crate::common::Rig;
use lafet_device::Composition;
use lafet_device::image::{Axis, DriveInput, Inputs, Place, ValveOutput};
use lafet_proto::flags::{ControlFlags, DeployerFlags, DriveFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::param::Param;
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

/// §D/1, §D/2 A blip of the closed switch at power-up does not make a valve that is half-way count as closed: it is
/// closed, whatever ResetValves says.
#[test]
fn closed_switch_at_power_up() {
    for (keep, ms) in [0, 1].into_iter().flat_map(|keep| [0, 1, 10, 29].map(|ms| (keep, ms))) {
        let mut rig = half_way(OPEN);
        rig.set(Param::GeneralResetValves, keep);
        rig.run(20);
        rig.plant.inputs.valves[0].close_switch = true;
        rig.power_cycle();
        assert!(!rig.valve(VALVE).contains(ValveFlags::CLOSED));
        blip(&mut rig, ms, |inputs| inputs.valves[0].close_switch = true);
        rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::CLOSED);
        rig.run(20);
        assert_eq!(rig.plant.valves[0].opening_ms, 0, "{keep} {ms}");
    }
}

/// §D/2 A blip of the open switch, whenever after power-up it comes, closes no valve that is kept open.
#[test]
fn open_switch_at_power_up() {
    for (ms, at) in
        [1, 10, 30].into_iter().flat_map(|ms| (0..300).step_by(5).map(move |at| (ms, at)))
    {
        let mut rig = half_way(OPEN);
        rig.set(Param::GeneralResetValves, 1);
        rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::OPEN);
        if at == 0 {
            rig.plant.inputs.valves[0].open_switch = false;
        }
        rig.power_cycle();
        blip(&mut rig, at, |_| {});
        blip(&mut rig, ms, |inputs| inputs.valves[0].open_switch = false);
        rig.run_while(5000, |rig| rig.valve_output(0) == ValveOutput::Off);
        assert_eq!(rig.valve(VALVE), ValveFlags::OPEN, "{ms} ms at {at}");
    }
}

/// §D/2 Nor does a blip of it at power-up keep a valve open that is half-way.
#[test]
fn open_switch_of_a_valve_half_way() {
    for (ms, at) in
        [1, 10, 30].into_iter().flat_map(|ms| (0..300).step_by(30).map(move |at| (ms, at)))
    {
        let mut rig = half_way(OPEN);
        rig.set(Param::GeneralResetValves, 1);
        rig.run(20);
        rig.plant.inputs.valves[0].open_switch = at == 0;
        rig.power_cycle();
        blip(&mut rig, at, |_| {});
        blip(&mut rig, ms, |inputs| inputs.valves[0].open_switch = true);
        rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::CLOSED);
    }
}

/// §D/2, §3.12/2 One that comes while the reset waits for a Close does not have the Close forgotten, nor does one in
/// which the Close comes.
#[test]
fn open_switch_before_the_reset() {
    for (ms, before) in
        [1, 10, 30].into_iter().flat_map(|ms| [true, false].map(|before| (ms, before)))
    {
        let mut rig = half_way(OPEN);
        rig.set(Param::GeneralResetValves, 1);
        rig.run_until(5000, |rig| rig.valve(VALVE) == ValveFlags::OPEN);
        rig.all_accept(Body::Restart);
        rig.plant.valves[0].jammed = true;
        let open = |inputs: &mut Inputs| inputs.valves[0].open_switch = false;
        if before {
            rig.accepts(VALVE, CLOSE);
            rig.run(250);
            blip(&mut rig, ms, open);
        } else {
            rig.run(180);
            blip(&mut rig, ms.min(15), open);
            rig.accepts(VALVE, CLOSE);
            blip(&mut rig, ms.saturating_sub(15), open);
        }
        rig.run(100);
        assert_eq!((rig.plant.resets, rig.valve_output(0)), (0, ValveOutput::Closing), "{ms}");
        rig.plant.valves[0].jammed = false;
        rig.run_until(6000, |rig| rig.valve(VALVE) == ValveFlags::CLOSED);
        assert_eq!(rig.plant.resets, 1);
    }
}

/// §D/1 A barrel between its positions is neither folded nor deployed for a blip at power-up: nothing aims, opens or
/// folds, and Move Deployer and Wrap wait until the inputs have settled.
#[test]
fn deployer_at_power_up() {
    let deployer = Axis::Deployer as usize;
    for (ms, up) in [1, 10, 29].into_iter().flat_map(|ms| [true, false].map(|up| (ms, up))) {
        let shows = |inputs: &mut Inputs| {
            (inputs.drives[deployer].min_switch, inputs.drives[deployer].max_switch) = (!up, up);
        };
        let mut rig = Rig::new(Composition::FULL);
        rig.plant.place(Axis::Deployer, 2000);
        shows(&mut rig.plant.inputs);
        rig.power_cycle();
        for at in 0..200 {
            assert!(rig.deployer().is_empty(), "{:?}", rig.deployer());
            for (to, body) in
                [(VALVE, OPEN), (SubsystemId::VERTICAL, Body::Move { destination: 60 })]
            {
                assert_eq!(rig.one(to, body), (SubsystemId::DEPLOYER, Status::DENIED));
            }
            if at < 100 {
                for body in [Body::Wrap, Body::Move { destination: 0 }] {
                    assert_eq!(rig.one(SubsystemId::DEPLOYER, body).1, Status::DENIED);
                }
            }
            blip(&mut rig, 1, |inputs| {
                if at < ms {
                    shows(inputs)
                }
            });
        }
        rig.run_while(500, |rig| rig.is_still() && rig.valve_output(0) == ValveOutput::Off);
    }
}

/// §D/6 For 30 ms after power-up no contact counts, and then all do.
#[test]
fn contacts_at_power_up() {
    let mut rig = Rig::new(Composition::FULL);
    rig.power_cycle();
    for at in 0..40 {
        let wrapped = rig.deployer()
            == DeployerFlags::WRAPPED
                | DeployerFlags::MIN_LIMIT_REACHED
                | DeployerFlags::ABSOLUTE_MIN_LIMIT_REACHED;
        let closed = rig.valve(VALVE).contains(ValveFlags::CLOSED);
        assert_eq!((wrapped, closed), (at >= 30, at >= 30), "{at} {:?}", rig.deployer());
        if at < 30 {
            assert_eq!(rig.one(SubsystemId::DEPLOYER, Body::Wrap).1, Status::DENIED);
        }
        blip(&mut rig, 1, |_| {});
    }
}

/// §D/6 What a drive's sensors or its power stage say of themselves for a moment ends no extinguishing; what stays
/// does.
#[test]
fn faults_of_a_drive() {
    type Fault = fn(&mut DriveInput) -> &mut bool;
    let faults: [Fault; 3] = [
        |input| &mut input.motor_open,
        |input| &mut input.position_sensor_fault,
        |input| &mut input.speed_sensor_fault,
    ];
    let cases = [(1, true), (10, true), (30, true), (31, false)];
    for (fault, (ms, goes_on)) in
        faults.into_iter().flat_map(|fault| cases.map(|case| (fault, case)))
    {
        let mut rig = Rig::new(Composition::REMOTE);
        let quench = Quench::Program { program: 0, centre_h: 0, centre_v: 0, nozzle: 30 };
        rig.accepts(SubsystemId::CONTROL, Body::StartQuench(quench));
        rig.run(500);
        blip(&mut rig, ms, |inputs| *fault(&mut inputs.drives[Axis::Horizontal as usize]) = true);
        *fault(&mut rig.plant.inputs.drives[Axis::Horizontal as usize]) = false;
        rig.run(100);
        let control = ControlFlags::from_bits_retain(rig.flags(SubsystemId::CONTROL));
        assert_eq!(control.contains(ControlFlags::QUENCH), goes_on, "{ms}: {control:?}");
        assert_eq!(control.contains(ControlFlags::INTERNAL_FAULT), !goes_on, "{ms}: {control:?}");
    }
}

/// §3.3.3 A heater that is reported as broken for a moment heats on; one that stays so is off until no heat is asked
/// for.
#[test]
fn fault_of_a_heater() {
    let place = Place::Box as usize;
    for (ms, heats) in [(1, true), (10, true), (30, true), (31, false)] {
        let mut rig = Rig::new(Composition::FULL);
        rig.plant.inputs.places[place].temperature_dc = Some(-200);
        rig.plant.inputs.places[place].heater_fault = true;
        rig.power_cycle();
        rig.plant.inputs.places[place].heater_fault = false;
        rig.run(200);
        assert!(rig.plant.outputs.heaters[place]);
        blip(&mut rig, ms, |inputs| inputs.places[place].heater_fault = true);
        rig.plant.inputs.places[place].heater_fault = false;
        rig.run(5000);
        assert_eq!(rig.plant.outputs.heaters[place], heats, "{ms}");
    }
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
