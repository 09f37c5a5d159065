//! Valves: travel, stop, faults, block, power-up.

use crate::common::{Plant, Rig, STEP_MS};
use lafet_device::image::ValveOutput;
use lafet_device::{Composition, Device};
use lafet_proto::flags::{Button, ButtonState, GeneralFlags, ValveFlags as F};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};

const VALVE: SubsystemId = SubsystemId::VALVE1;
const OPEN: Body<'static> = Body::Open { key: key::OPEN };
const CLOSE: Body<'static> = Body::Close { key: key::CLOSE };

fn rig() -> Rig {
    Rig::new(Composition::REMOTE)
}

fn open() -> Rig {
    let mut rig = rig();
    rig.accepts(VALVE, OPEN);
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::OPEN);
    rig
}

/// §3.8/3, §3.9/2 It opens and closes, and the motor is off at the end; the other valve stays.
#[test]
fn opens_and_closes() {
    let mut rig = Rig::deployed();
    for (valve, other) in [(0, SubsystemId::VALVE2), (1, SubsystemId::VALVE1)] {
        let id = [SubsystemId::VALVE1, SubsystemId::VALVE2][valve];
        assert_eq!(rig.valve(id), F::CLOSED);
        assert_eq!(rig.status(id, OPEN), Status::ACCEPTED);
        rig.run(100);
        assert_eq!(rig.valve(id), F::OPENING);
        assert_eq!(rig.valve_output(valve), ValveOutput::Opening);
        assert_eq!(rig.valve(other), F::CLOSED);
        let ms = rig.run_until(5000, |rig| rig.valve(id) == F::OPEN);
        assert!((3800..4000).contains(&ms));
        assert_eq!(rig.valve_output(valve), ValveOutput::Off);
        assert_eq!(rig.status(id, CLOSE), Status::ACCEPTED);
        rig.run(100);
        assert_eq!(rig.valve(id), F::CLOSING);
        rig.run_until(5000, |rig| rig.valve(id) == F::CLOSED);
        assert_eq!(rig.valve_output(valve), ValveOutput::Off);
        // Again is no harm.
        assert_eq!(rig.status(id, CLOSE), Status::ACCEPTED);
        rig.run(20);
        assert_eq!((rig.valve(id), rig.valve_output(valve)), (F::CLOSED, ValveOutput::Off));
    }
}

/// §3.8/6, §3.9/5 Another key, also the other request's: NeedConfirm, it stays.
#[test]
fn keys() {
    let mut rig = open();
    for wrong in [0, 0xFFFF, key::OPEN, key::CLOSE.swap_bytes(), key::ENABLE] {
        assert_eq!(rig.status(VALVE, Body::Close { key: wrong }), Status::NEED_CONFIRM);
        rig.run_while(50, |rig| rig.valve_output(0) == ValveOutput::Off);
    }
    rig.accepts(VALVE, CLOSE);
    rig.run(5000);
    assert_eq!(rig.status(VALVE, Body::Open { key: key::CLOSE }), Status::NEED_CONFIRM);
    rig.run_while(50, |rig| rig.valve_output(0) == ValveOutput::Off);
}

/// §3.2/5, §3.2/1 Stop leaves it where it is: neither open nor closed; it goes on from there.
#[test]
fn stop_in_travel() {
    for to in [VALVE, SubsystemId::ALL] {
        let mut rig = rig();
        rig.accepts(VALVE, OPEN);
        rig.run(2000);
        assert!(rig.ask(to, Body::Stop).iter().all(|answer| answer.status == Status::OK));
        rig.run(20);
        assert_eq!(rig.valve(VALVE), F::empty());
        let at = rig.plant.valves[0].opening_ms;
        rig.run(5000);
        assert_eq!(rig.plant.valves[0].opening_ms, at);
        rig.accepts(VALVE, OPEN);
        rig.run_until(3000, |rig| rig.valve(VALVE) == F::OPEN);
    }
    // §1/6: the drives' broadcast does not touch water.
    let mut rig = rig();
    rig.accepts(VALVE, OPEN);
    rig.run(100);
    rig.ask(SubsystemId::MOTORS, Body::Stop);
    rig.run(100);
    assert_eq!(rig.valve(VALVE), F::OPENING);
}

/// §3.3.5 A valve that does not leave its end in a fifteenth of TravelTime: InternalFault, the motor
/// is off. One that leaves and does not arrive in time: the fault of the sensor there. Also while the
/// clock wraps (§D/3).
#[test]
fn time_over() {
    type Break = fn(&mut Plant);
    let cases: [(Break, F, u32); 2] = [
        (|plant| plant.valves[0].jammed = true, F::INTERNAL_FAULT | F::CLOSED, 400),
        (|plant| plant.valves[0].open_switch_dead = true, F::OPEN_SENSOR_FAULT, 9000),
    ];
    for now_ms in [0, u32::MAX - 3000, u32::MAX - 200] {
        for (break_it, flags, after_ms) in cases {
            let mut rig = Rig::at(Composition::REMOTE, now_ms);
            rig.set(Param::Valve1TravelTime, 6000);
            break_it(&mut rig.plant);
            rig.accepts(VALVE, OPEN);
            rig.run_while(after_ms - 100, |rig| rig.valve_output(0) == ValveOutput::Opening);
            rig.run(150);
            assert_eq!(rig.valve(VALVE), flags);
            rig.run_while(1000, |rig| rig.valve_output(0) == ValveOutput::Off);
            assert_eq!(rig.status(VALVE, OPEN), Status::MODULE_FAULT);
            // §3.9/2: closing is the safe direction, it is tried, and clears what was found.
            assert_eq!(rig.status(VALVE, CLOSE), Status::ACCEPTED);
            rig.plant.valves[0].jammed = false;
            rig.run_until(6000, |rig| rig.valve(VALVE) == F::CLOSED);
        }
    }
}

/// §3.3.5, §3.8/3 An opening in vain is tried again with the next Open behind a rest; what a sensor says now, or what
/// a closing has found, still refuses it.
#[test]
fn an_opening_in_vain_can_be_repeated() {
    let mut rig = rig();
    rig.plant.valves[0].jammed = true;
    rig.accepts(VALVE, OPEN);
    rig.run_until(1000, |rig| rig.valve(VALVE).contains(F::INTERNAL_FAULT));
    let fed_ms = fed_ms(&mut rig, 17_900, 100, |rig| {
        assert_eq!(rig.status(VALVE, OPEN), Status::MODULE_FAULT);
    });
    assert_eq!(fed_ms, 0);
    rig.run(200);
    let mut doubtful = rig.clone();
    doubtful.plant.inputs.valves[0].open_sensor_fault = true;
    doubtful.run(20);
    assert_eq!(doubtful.status(VALVE, OPEN), Status::MODULE_FAULT);
    rig.plant.valves[0].jammed = false;
    assert_eq!(rig.status(VALVE, OPEN), Status::ACCEPTED);
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::OPEN);
    rig.plant.valves[0].jammed = true;
    rig.accepts(VALVE, CLOSE);
    rig.run(60_000);
    assert_eq!(rig.status(VALVE, OPEN), Status::MODULE_FAULT);
}

/// §3.3.5 A valve that does not leave "open": InternalFault, and closing is tried to the end; when
/// the plug comes loose it closes.
#[test]
fn stuck_open() {
    let mut rig = open();
    rig.plant.valves[0].jammed = true;
    rig.accepts(VALVE, CLOSE);
    rig.run_until(1000, |rig| rig.valve(VALVE) == F::INTERNAL_FAULT | F::OPEN | F::CLOSING);
    rig.run_while(10_000, |rig| rig.valve_output(0) == ValveOutput::Closing);
    rig.plant.valves[0].jammed = false;
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::INTERNAL_FAULT | F::CLOSED);
    rig.accepts(VALVE, CLOSE);
    rig.run(20);
    assert_eq!(rig.valve(VALVE), F::CLOSED);
}

/// §3.3.5/1 A faulty "closed" sensor: Open is refused, Close is driven for its time, and Closed is
/// never believed.
#[test]
fn faulty_closed_sensor() {
    for closed in [false, true] {
        let mut rig = open();
        if closed {
            // It is, and says so; but its circuit is not sound.
            rig.plant.valves[0].opening_ms = 0;
        }
        let fault = F::CLOSE_SENSOR_FAULT;
        rig.plant.inputs.valves[0].close_sensor_fault = true;
        rig.run(20);
        assert!(rig.valve(VALVE).contains(fault) && !rig.valve(VALVE).contains(F::CLOSED));
        assert_eq!(rig.status(VALVE, OPEN), Status::MODULE_FAULT);
        assert_eq!(rig.status(VALVE, CLOSE), Status::ACCEPTED);
        rig.run_while(17_000, |rig| rig.valve_output(0) == ValveOutput::Closing);
        rig.run(1500);
        assert_eq!(rig.valve_output(0), ValveOutput::Off);
        assert_eq!(rig.plant.valves[0].opening_ms, 0);
        assert!(!rig.valve(VALVE).contains(F::CLOSED));
        rig.plant.inputs.valves[0].close_sensor_fault = false;
        rig.run(20);
        rig.accepts(VALVE, CLOSE);
        rig.run(50);
        assert_eq!(rig.valve(VALVE), F::CLOSED);
        rig.accepts(VALVE, OPEN);
    }
}

/// §3.3.5/1, §3.11/6 Both switches closed cannot be: neither is believed.
#[test]
fn both_switches() {
    let mut rig = Rig::deployed();
    rig.plant.valves[0].open_switch_stuck = true;
    rig.run(50);
    assert_eq!(rig.valve(VALVE), F::OPEN_SENSOR_FAULT | F::CLOSE_SENSOR_FAULT);
    assert_eq!(rig.status(VALVE, OPEN), Status::MODULE_FAULT);
    assert_eq!(rig.one(SubsystemId::DEPLOYER, Body::Wrap), (VALVE, Status::DENIED));
    assert_eq!(rig.status(VALVE, CLOSE), Status::ACCEPTED);
    rig.run_while(15_000, |rig| rig.valve_output(0) == ValveOutput::Closing);
    rig.plant.valves[0].open_switch_stuck = false;
    rig.run(50);
    assert_eq!(rig.valve(VALVE), F::CLOSED);
}

/// §3.3.5/1 Blocked: Open is Denied by the valve itself; Close is tried; unblocked, it opens.
#[test]
fn blocked() {
    let mut rig = rig();
    rig.plant.inputs.valves[0].blocked = true;
    rig.run(50);
    assert_eq!(rig.valve(VALVE), F::BLOCKED | F::CLOSED);
    assert_eq!(rig.one(VALVE, OPEN), (VALVE, Status::DENIED));
    rig.run_while(100, |rig| rig.valve_output(0) == ValveOutput::Off);
    assert_eq!(rig.status(VALVE, CLOSE), Status::ACCEPTED);
    rig.plant.inputs.valves[0].blocked = false;
    rig.run(50);
    rig.accepts(VALVE, OPEN);
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::OPEN);
}

/// §3.3.5 Overload: the motor stops; the flag clears 3 s later (§D/3 also while the clock wraps).
#[test]
fn overload() {
    for now_ms in [0, u32::MAX - 2500] {
        let mut rig = Rig::at(Composition::REMOTE, now_ms);
        rig.plant.valves[0].current_da = 61;
        rig.accepts(VALVE, OPEN);
        let ms = rig.run_until(1000, |rig| rig.valve(VALVE).contains(F::AMPERAGE_OVERLOAD));
        assert!((300..400).contains(&ms), "{ms}");
        assert_eq!(rig.valve_output(0), ValveOutput::Off);
        rig.plant.valves[0].current_da = 0;
        assert_eq!(rig.run_until(4000, |rig| rig.valve(VALVE) == F::empty()), 3000);
        rig.plant.valves[0].current_da = 60;
        rig.accepts(VALVE, OPEN);
        rig.run_until(5000, |rig| rig.valve(VALVE) == F::OPEN);
    }
}

/// §D/1, §D/2 At power-up the valves are closed, unless ResetValves leaves them; a lockout closes them
/// even then (§3.18/1).
#[test]
fn power_up_closes() {
    for (keep, locked) in [(0, false), (1, false), (1, true)] {
        let mut rig = open();
        rig.set(Param::GeneralResetValves, keep);
        rig.run(100);
        if locked {
            rig.all_accept(Body::Lockout { key: key::ENABLE });
            rig.run(20);
        }
        rig.power_cycle();
        rig.run_while(90, |rig| rig.valve_output(0) == ValveOutput::Off);
        rig.run(6000);
        let closed = keep == 0 || locked;
        assert_eq!(rig.valve(VALVE), if closed { F::CLOSED } else { F::OPEN });
        assert_eq!(rig.general().flags.contains(GeneralFlags::LOCKED_OUT), locked);
    }
}

/// §D/2, §3.12/1 Restart closes the valves; with ResetValves they stay as they are.
#[test]
fn restart() {
    for (keep, status) in [(0, Status::ACCEPTED), (1, Status::OK)] {
        let mut rig = open();
        rig.set(Param::GeneralResetValves, keep);
        let answers = rig.ask(SubsystemId::ALL, Body::Restart);
        let valve = answers.iter().find(|answer| answer.from == VALVE).unwrap();
        assert_eq!(valve.status, status);
        rig.run(8000);
        assert_eq!(rig.plant.resets, 1);
        assert_eq!(rig.valve(VALVE), if keep == 1 { F::OPEN } else { F::CLOSED });
    }
}

/// §D/2 With ResetValves a valve that is open stays so; one that was on its way, either way, closes: a Close under
/// way is not forgotten.
#[test]
fn a_close_goes_on_behind_the_reset() {
    let on_its_way = |body| {
        let mut rig = if matches!(body, Body::Close { .. }) { open() } else { rig() };
        rig.set(Param::GeneralResetValves, 1);
        rig.accepts(VALVE, body);
        rig.run(2000);
        rig
    };
    for body in [OPEN, CLOSE] {
        let mut rig = on_its_way(body);
        rig.power_cycle();
        rig.run_until(6000, |rig| rig.valve(VALVE) == F::CLOSED);
    }
    let mut rig = on_its_way(CLOSE);
    rig.plant.valves[0].opening_ms = 3500;
    let answers = rig.ask(SubsystemId::ALL, Body::Restart);
    let valve = answers.iter().find(|answer| answer.from == VALVE).unwrap();
    assert_eq!(valve.status, Status::ACCEPTED);
    rig.run_while(150, |rig| rig.valve_output(0) == ValveOutput::Closing);
    rig.run_until(6000, |rig| rig.valve(VALVE) == F::CLOSED);
    let mut rig = on_its_way(OPEN);
    rig.all_accept(Body::Restart);
    rig.run_while(150, |rig| rig.valve_output(0) == ValveOutput::Off);
}

/// §D/2 A blip of the open switch at power-up closes no valve that is to be kept open, and one that is never sensed as
/// open closes.
#[test]
fn a_kept_valve_is_judged_when_its_contacts_have_settled() {
    for (dead_ms, stays) in [(10, true), (50, true), (200, false)] {
        let mut rig = open();
        rig.set(Param::GeneralResetValves, 1);
        rig.run(100);
        rig.plant.valves[0].open_switch_dead = true;
        rig.run(10);
        rig.power_cycle();
        rig.run(dead_ms);
        rig.plant.valves[0].open_switch_dead = false;
        rig.run(6000);
        assert_eq!(rig.valve(VALVE), if stays { F::OPEN } else { F::CLOSED }, "{dead_ms} ms");
    }
}

/// §D/2, §3.12/2 A Close that has been accepted while the monitor waits for its reset is not forgotten: the reset waits
/// until the plug has left the open switch, and no longer than a closing may take.
#[test]
fn a_close_before_the_reset_is_not_forgotten() {
    let press = |rig: &mut Rig| {
        rig.plant.inputs.buttons[0][Button::Close as usize] = ButtonState::Pressed;
        rig.run(20);
    };
    let close = |rig: &mut Rig| rig.accepts(VALVE, CLOSE);
    for (ask, breaks) in
        [(&close as &dyn Fn(&mut Rig), false), (&press, false), (&close, true), (&press, true)]
    {
        let mut rig = open();
        rig.set(Param::GeneralResetValves, 1);
        rig.all_accept(Body::Restart);
        rig.run(100);
        rig.plant.valves[0].jammed = true;
        ask(&mut rig);
        rig.run(200);
        assert_eq!((rig.plant.resets, rig.valve_output(0)), (0, ValveOutput::Closing));
        if breaks {
            rig.run_while(5000, |rig| rig.plant.resets == 0);
            rig.run_until(15_000, |rig| rig.plant.resets == 1);
        } else {
            rig.plant.valves[0].jammed = false;
            rig.run_until(6000, |rig| rig.valve(VALVE) == F::CLOSED);
            assert_eq!(rig.plant.resets, 1);
        }
    }
}

/// §3.12, §3.3.10 While the monitor waits for its reset, no button but Close acts.
#[test]
fn buttons_before_the_reset() {
    for button in [Button::Left, Button::Up, Button::Wide, Button::Open] {
        let mut rig = rig();
        rig.all_accept(Body::Restart);
        rig.run(20);
        rig.plant.inputs.buttons[0][button as usize] = ButtonState::Pressed;
        rig.run_while(150, |rig| rig.is_still() && rig.valve_output(0) == ValveOutput::Off);
    }
}

/// §D/1 A valve found open at power-up with nothing stored is closed all the same.
#[test]
fn power_up_without_parameters() {
    let mut plant = Plant::of(&Composition::REMOTE);
    plant.valves[0].opening_ms = 4000;
    let mut rig = Rig::power_up(Composition::REMOTE, plant, 0);
    rig.run(5000);
    assert_eq!(rig.valve(VALVE), F::CLOSED | F::CONFIG_INVALID);
    assert_eq!(rig.status(VALVE, OPEN), Status::MODULE_FAULT);
    rig.plant.valves[0].opening_ms = 1000;
    rig.run(20);
    assert_eq!(rig.status(VALVE, CLOSE), Status::ACCEPTED);
    rig.run(2000);
    assert_eq!(rig.plant.valves[0].opening_ms, 0);
    let _ = Device::provision(&mut rig.plant, &Composition::REMOTE, 1);
    rig.power_cycle_and_settle();
    rig.accepts(VALVE, OPEN);
}

/// §3.3.5 How long a valve may stay at its end: a fifteenth of TravelTime, 0.4 s at least.
#[test]
fn leaving_takes_a_part_of_the_travel() {
    for (travel_ms, leaves_ms) in [(12_000, 800), (7500, 500), (6000, 400), (1000, 400)] {
        let mut rig = rig();
        rig.set(Param::Valve1TravelTime, travel_ms);
        rig.plant.valves[0].jammed = true;
        rig.accepts(VALVE, OPEN);
        let ms = rig.run_until(2000, |rig| rig.valve(VALVE).contains(F::INTERNAL_FAULT));
        assert_eq!(ms, leaves_ms + STEP_MS, "{travel_ms}");
    }
}

/// §3.3.5 A blocked valve cannot leave its end, which is no fault of its own; the time for it begins
/// when the block is off.
#[test]
fn a_blocked_valve_is_not_judged() {
    let mut rig = open();
    rig.plant.valves[0].jammed = true;
    rig.plant.inputs.valves[0].blocked = true;
    rig.run(50);
    rig.accepts(VALVE, CLOSE);
    rig.run_while(3000, |rig| rig.valve(VALVE) == F::BLOCKED | F::CLOSING | F::OPEN);
    rig.plant.inputs.valves[0].blocked = false;
    let ms = rig.run_until(2000, |rig| rig.valve(VALVE).contains(F::INTERNAL_FAULT));
    // §D/6 That it is off counts when it has lasted for 30 ms.
    assert_eq!(ms, 30 + 800 + STEP_MS);
}

/// §3.8/3, §3.9/2 A request that is repeated does not put off what the valve is judged by.
#[test]
fn repeated_requests_put_nothing_off() {
    let found = |rig: &mut Rig, body, flag: F, within_ms: u32| {
        (0..within_ms / 100).any(|_| {
            let before = rig.valve(VALVE).contains(flag);
            rig.ask(VALVE, body);
            (0..10).fold(before, |found, _| {
                rig.step(STEP_MS);
                found | rig.valve(VALVE).contains(flag)
            })
        })
    };
    let mut rig = rig();
    rig.plant.valves[0].jammed = true;
    assert!(found(&mut rig, OPEN, F::INTERNAL_FAULT, 1000));
    let mut rig = open();
    rig.plant.valves[0].jammed = true;
    assert!(found(&mut rig, CLOSE, F::INTERNAL_FAULT, 1000));
    let mut rig = self::rig();
    rig.plant.valves[0].current_da = 61;
    assert!(found(&mut rig, OPEN, F::AMPERAGE_OVERLOAD, 500));
}

/// §3.3.5 Starting current: 0.3 s of it are no overload, whichever way it starts, and what it drew one
/// way is not held against the other. MaxCurrent itself may be drawn as long as it takes.
#[test]
fn starting_current() {
    let mut rig = rig();
    rig.plant.valves[0].opening_ms = 2000;
    rig.plant.valves[0].current_da = 61;
    for body in [OPEN, CLOSE, OPEN, CLOSE] {
        rig.accepts(VALVE, body);
        rig.run(290);
        assert!(!rig.valve(VALVE).contains(F::AMPERAGE_OVERLOAD));
    }
    for (current_da, flags) in [(60, F::OPENING), (61, F::AMPERAGE_OVERLOAD)] {
        let mut rig = self::rig();
        rig.plant.valves[0].opening_ms = 100;
        rig.plant.valves[0].current_da = 61;
        rig.accepts(VALVE, OPEN);
        // In the first step it is fed, in the next the current shows: 30 of these are 0.3 s.
        rig.run_while(310, |rig| rig.valve(VALVE) == F::OPENING);
        rig.plant.valves[0].current_da = current_da;
        rig.step(STEP_MS);
        assert_eq!(rig.valve(VALVE), flags);
    }
}

/// §3.9/2 An overloaded valve says ModuleFault to Close, and is driven all the same.
#[test]
fn closing_an_overloaded_valve() {
    let mut rig = open();
    rig.plant.valves[0].current_da = 61;
    rig.accepts(VALVE, CLOSE);
    rig.run_until(1000, |rig| rig.valve(VALVE).contains(F::AMPERAGE_OVERLOAD));
    rig.plant.valves[0].current_da = 20;
    assert_eq!(rig.status(VALVE, CLOSE), Status::MODULE_FAULT);
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::CLOSED);
}

/// §D/1, §3.3.5 What closes without being asked goes on after an overload, within its one attempt; a Stop, an Open or a
/// Close of a client ends that.
#[test]
fn an_overload_does_not_leave_it_open() {
    let overloaded = || {
        let mut rig = open();
        rig.plant.valves[0].current_da = 80;
        rig.power_cycle();
        rig.run_until(2000, |rig| rig.valve(VALVE).contains(F::AMPERAGE_OVERLOAD));
        assert_eq!(rig.valve_output(0), ValveOutput::Off);
        rig.plant.valves[0].current_da = 20;
        rig
    };
    let mut rig = overloaded();
    rig.run_while(2900, |rig| rig.valve_output(0) == ValveOutput::Off);
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::CLOSED);
    rig.accepts(VALVE, OPEN);
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::OPEN);
    rig.run_while(60_000, |rig| rig.valve(VALVE) == F::OPEN);
    for (body, output) in [(OPEN, ValveOutput::Opening), (Body::Stop, ValveOutput::Off)] {
        let mut rig = overloaded();
        rig.accepts(VALVE, body);
        rig.run_while(1000, |rig| {
            rig.valve_output(0) == output || rig.valve(VALVE).contains(F::OPEN)
        });
        rig.run_while(10_000, |rig| rig.valve_output(0) != ValveOutput::Closing);
    }
    // Overloaded for ever, it is one attempt.
    let mut rig = open();
    rig.plant.valves[0].current_da = 80;
    rig.plant.valves[0].jammed = true;
    rig.power_cycle();
    let fed_ms = fed_ms(&mut rig, 120_000, 1_000_000, |_| {});
    assert!((1500..3000).contains(&fed_ms), "{fed_ms}");
    assert!(rig.valve(VALVE).contains(F::INTERNAL_FAULT));
}

/// §3.3.5/1 A faulty "open" sensor: Open is refused, and Open never believed.
#[test]
fn faulty_open_sensor() {
    let mut rig = open();
    rig.plant.inputs.valves[0].open_sensor_fault = true;
    rig.run(20);
    assert_eq!(rig.valve(VALVE), F::OPEN_SENSOR_FAULT);
    assert_eq!(rig.status(VALVE, OPEN), Status::MODULE_FAULT);
    rig.accepts(VALVE, CLOSE);
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::OPEN_SENSOR_FAULT | F::CLOSED);
    rig.plant.inputs.valves[0].open_sensor_fault = false;
    rig.run(20);
    rig.accepts(VALVE, OPEN);
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::OPEN);
}

/// §3.3.5 The time for closing is over: a dead "closed" sensor where it has left the other end,
/// InternalFault where it cannot be known.
#[test]
fn closing_time_over() {
    let mut rig = open();
    rig.plant.valves[0].close_switch_dead = true;
    rig.accepts(VALVE, CLOSE);
    rig.run_while(17_900, |rig| rig.valve(VALVE).contains(F::CLOSING));
    rig.run(200);
    assert_eq!((rig.valve(VALVE), rig.valve_output(0)), (F::CLOSE_SENSOR_FAULT, ValveOutput::Off));
    let mut rig = self::rig();
    rig.plant.valves[0].open_switch_stuck = true;
    rig.run(50);
    rig.accepts(VALVE, CLOSE);
    rig.run_while(17_900, |rig| rig.valve_output(0) == ValveOutput::Closing);
    rig.run(200);
    let both = F::OPEN_SENSOR_FAULT | F::CLOSE_SENSOR_FAULT;
    assert_eq!(rig.valve(VALVE), both | F::INTERNAL_FAULT);
    assert_eq!(rig.valve_output(0), ValveOutput::Off);
}

/// How long the motor is fed at most in this time, in which requests keep on coming.
fn fed_ms(rig: &mut Rig, ms: u32, every_ms: u32, ask: impl Fn(&mut Rig)) -> u32 {
    let mut fed_ms = 0;
    for at_ms in (0..ms).step_by(STEP_MS as usize) {
        if at_ms.is_multiple_of(every_ms) {
            ask(rig);
        }
        rig.step(STEP_MS);
        fed_ms += if rig.valve_output(0) == ValveOutput::Off { 0 } else { STEP_MS };
    }
    fed_ms
}

/// §3.9/2 A Close that is repeated is one attempt; after one in vain the motor rests for as long, and so says
/// the answer. The fault is reported all the while.
#[test]
fn closing_in_vain() {
    for every_ms in [10, 100, 3000] {
        let mut rig = open();
        rig.plant.valves[0].close_switch_dead = true;
        let fed_ms = fed_ms(&mut rig, 35_900, every_ms, |rig| {
            rig.ask(VALVE, CLOSE);
        });
        assert!((17_900..18_200).contains(&fed_ms), "{every_ms}: {fed_ms}");
        assert_eq!(rig.valve(VALVE), F::CLOSE_SENSOR_FAULT);
        assert_eq!(rig.status(VALVE, CLOSE), Status::MODULE_FAULT);
        rig.run(200);
        rig.accepts(VALVE, CLOSE);
        rig.run(100);
        assert_eq!(rig.valve_output(0), ValveOutput::Closing);
    }
    // Overloaded again and again, it is the same attempt.
    let mut rig = open();
    rig.plant.valves[0].jammed = true;
    rig.plant.valves[0].current_da = 80;
    let fed_ms = fed_ms(&mut rig, 35_900, 10, |rig| {
        rig.ask(VALVE, CLOSE);
    });
    assert!(fed_ms <= 18_200, "{fed_ms}");
    assert!(rig.valve(VALVE).contains(F::INTERNAL_FAULT));
    // Rested and free, it closes.
    rig.plant.valves[0] = Default::default();
    rig.plant.valves[0].opening_ms = 2000;
    rig.run(18_000);
    rig.accepts(VALVE, CLOSE);
    rig.run_until(5000, |rig| rig.valve(VALVE) == F::CLOSED);
}

/// §3.18/1 Under lockout a valve that cannot be closed is driven for its time and no longer; one that leaves its
/// switch is closed again.
#[test]
fn lockout_ends_too() {
    for jammed in [false, true] {
        let mut rig = open();
        rig.plant.valves[0].close_switch_dead = !jammed;
        rig.plant.valves[0].jammed = jammed;
        rig.plant.valves[0].current_da = if jammed { 80 } else { 20 };
        rig.all_accept(Body::Lockout { key: key::ENABLE });
        let fed_ms = fed_ms(&mut rig, 600_000, 1_000_000, |_| {});
        assert!((17_900..18_200).contains(&fed_ms), "{jammed}: {fed_ms}");
        let fault = if jammed { F::INTERNAL_FAULT } else { F::CLOSE_SENSOR_FAULT };
        assert!(rig.valve(VALVE).contains(fault));
        // Requested again, it is tried again.
        rig.plant.valves[0].close_switch_dead = false;
        rig.plant.valves[0].jammed = false;
        rig.plant.valves[0].current_da = 20;
        rig.all_accept(Body::Lockout { key: key::ENABLE });
        rig.run_until(6000, |rig| rig.valve(VALVE) == F::CLOSED);
        rig.plant.valves[0].opening_ms = 1000;
        rig.run(50);
        assert_eq!(rig.valve_output(0), ValveOutput::Closing);
        rig.run_until(3000, |rig| rig.valve(VALVE) == F::CLOSED);
    }
}

/// §3.18/1, §3.3.5 A lockout in the rest after a Close in vain: the valve says ModuleFault, and is driven for one
/// attempt when it has rested; not if the lockout is released before.
#[test]
fn lockout_while_it_rests() {
    let resting = || {
        let mut rig = open();
        rig.plant.valves[0].jammed = true;
        rig.accepts(VALVE, CLOSE);
        rig.run(20_000);
        assert_eq!(rig.status(VALVE, CLOSE), Status::MODULE_FAULT);
        let answers = rig.ask(SubsystemId::ALL, Body::Lockout { key: key::ENABLE });
        let valve = answers.iter().find(|answer| answer.from == VALVE).unwrap();
        assert_eq!(valve.status, Status::MODULE_FAULT);
        rig.run_while(15_000, |rig| rig.valve_output(0) == ValveOutput::Off);
        rig
    };
    let mut rig = resting();
    let mut loose = rig.clone();
    let mut released = rig.clone();
    let fed_ms = fed_ms(&mut rig, 600_000, 1_000_000, |_| {});
    assert!((17_900..18_200).contains(&fed_ms), "{fed_ms}");
    loose.plant.valves[0].jammed = false;
    loose.run_until(10_000, |rig| rig.valve(VALVE) == F::CLOSED);
    let answers = released.ask(SubsystemId::ALL, Body::Lockout { key: key::DISABLE });
    assert!(answers.iter().all(|answer| answer.status.is_success()), "{answers:?}");
    released.run_while(20_000, |rig| rig.valve_output(0) == ValveOutput::Off);
}

/// §3.18/1, §3.3.5 Under lockout an overloaded motor is fed on, and the valve says so.
#[test]
fn what_an_overloaded_valve_says_under_lockout() {
    let mut rig = open();
    rig.plant.valves[0].jammed = true;
    rig.plant.valves[0].current_da = 80;
    rig.all_accept(Body::Lockout { key: key::ENABLE });
    rig.run(500);
    let driven = F::CLOSING | F::AMPERAGE_OVERLOAD;
    rig.run_while(10_000, |rig| {
        rig.valve_output(0) == ValveOutput::Closing && rig.valve(VALVE).contains(driven)
    });
}

/// §3.18/1 What could not be closed behind a block is closed when that is gone.
#[test]
fn lockout_behind_a_block() {
    let mut rig = open();
    rig.plant.inputs.valves[0].blocked = true;
    rig.plant.valves[0].jammed = true;
    rig.all_accept(Body::Lockout { key: key::ENABLE });
    rig.run(30_000);
    assert_eq!(rig.valve_output(0), ValveOutput::Off);
    rig.plant.inputs.valves[0].blocked = false;
    rig.plant.valves[0].jammed = false;
    rig.run_until(6000, |rig| rig.valve(VALVE) == F::CLOSED);
}
