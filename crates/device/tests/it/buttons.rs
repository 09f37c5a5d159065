//! Button posts: they act as requests would, and are refused where those would be.

use crate::common::Rig;
use lafet_device::Composition;
use lafet_device::image::{Axis, ValveOutput};
use lafet_proto::flags::{
    Button, ButtonState, ButtonsFlags, ControlFlags, DetectorFlags, DriveFlags, ValveFlags,
};
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::{Body, Quench, Seek};
use lafet_proto::{Status, SubsystemId};

const POSTS: [SubsystemId; 2] = [SubsystemId::BUTTONS, SubsystemId::EXT_BUTTONS];

const DIRECTIONS: [(Button, Axis, i16); 6] = [
    (Button::Left, Axis::Horizontal, 1),
    (Button::Right, Axis::Horizontal, -1),
    (Button::Up, Axis::Vertical, 1),
    (Button::Down, Axis::Vertical, -1),
    (Button::Narrow, Axis::Nozzle, 1),
    (Button::Wide, Axis::Nozzle, -1),
];

fn rig() -> Rig {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.plant.place(Axis::Nozzle, 30);
    rig.pause();
    rig.run(20);
    rig
}

fn set(rig: &mut Rig, post: usize, button: Button, state: ButtonState) {
    rig.plant.inputs.buttons[post][button as usize] = state;
}

fn press(rig: &mut Rig, post: usize, button: Button) {
    set(rig, post, button, ButtonState::Pressed);
}

fn release(rig: &mut Rig, post: usize, button: Button) {
    set(rig, post, button, ButtonState::Released);
}

/// §3.3.10, §3.3.10/1 Each button moves its drive in its direction while it is held, and no other.
#[test]
fn directions() {
    for (post, id) in POSTS.into_iter().enumerate() {
        for (button, axis, sign) in DIRECTIONS {
            let mut rig = rig();
            press(&mut rig, post, button);
            rig.run(400);
            let shown = ButtonsFlags::empty().with_button(button, ButtonState::Pressed);
            assert_eq!(rig.buttons(id), shown);
            for other in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
                let speed = if other == axis { sign } else { 0 };
                assert_eq!(rig.speed(other).signum(), speed, "{button:?} {other:?}");
            }
            assert_eq!(rig.plant.outputs.valves, [ValveOutput::Off; 2]);
            release(&mut rig, post, button);
            rig.run(20);
            assert!(rig.is_still(), "{button:?}");
            assert_eq!(rig.buttons(id), ButtonsFlags::empty());
        }
    }
}

/// §3.3.10/1, §3.3.4/2 Held at the limit it stops there, and Move is not set.
#[test]
fn held_at_the_limit() {
    let mut rig = rig();
    press(&mut rig, 0, Button::Up);
    rig.run(15_000);
    assert_eq!(rig.drive(Axis::Vertical).position, 4500);
    rig.run_while(200, |rig| rig.drive_flags(Axis::Vertical) == DriveFlags::MAX_LIMIT_REACHED);
}

/// §3.3.4/1 A held button does not hammer on against an overload; it acts again when the flag clears.
#[test]
fn held_into_an_overload() {
    let mut rig = rig();
    rig.plant.drive(Axis::Vertical).current_da = 100;
    press(&mut rig, 0, Button::Up);
    rig.run_until(1000, |rig| {
        rig.drive_flags(Axis::Vertical).contains(DriveFlags::AMPERAGE_OVERLOAD)
    });
    rig.run_while(2900, |rig| rig.is_still());
    rig.plant.drive(Axis::Vertical).current_da = 20;
    rig.run(300);
    assert!(rig.speed(Axis::Vertical) > 0);
    // Back is free at any time.
    rig.plant.drive(Axis::Vertical).current_da = 100;
    rig.run_until(1000, |rig| {
        rig.drive_flags(Axis::Vertical).contains(DriveFlags::AMPERAGE_OVERLOAD)
    });
    release(&mut rig, 0, Button::Up);
    rig.plant.drive(Axis::Vertical).current_da = 20;
    press(&mut rig, 0, Button::Down);
    rig.run(100);
    assert!(rig.speed(Axis::Vertical) < 0);
}

/// §3.3.10/1 Opposite buttons at a time, a short circuit or a break act as nothing.
#[test]
fn what_acts_as_nothing() {
    for (first, second, axis) in [
        (Button::Left, Button::Right, Axis::Horizontal),
        (Button::Up, Button::Down, Axis::Vertical),
        (Button::Narrow, Button::Wide, Axis::Nozzle),
    ] {
        let mut rig = rig();
        press(&mut rig, 0, first);
        rig.run(300);
        assert!(rig.speed(axis) > 0);
        press(&mut rig, 0, second);
        rig.run(20);
        rig.run_while(200, |rig| rig.is_still());
        release(&mut rig, 0, first);
        rig.run(100);
        assert!(rig.speed(axis) < 0);
    }
    for state in [ButtonState::Short, ButtonState::Open] {
        let mut rig = rig();
        for button in Button::ALL {
            set(&mut rig, 0, button, state);
        }
        rig.run_while(300, |rig| rig.is_still() && rig.valve_output(0) == ValveOutput::Off);
        assert_eq!(rig.buttons(SubsystemId::BUTTONS).button(Button::Wide), state);
        // While held: as released. And a circuit that comes back pressed acts only after a release.
        let mut rig = self::rig();
        press(&mut rig, 0, Button::Left);
        rig.run(300);
        set(&mut rig, 0, Button::Left, state);
        rig.run(20);
        assert!(rig.is_still());
        press(&mut rig, 0, Button::Left);
        rig.run_while(300, |rig| rig.is_still());
        release(&mut rig, 0, Button::Left);
        rig.run(40);
        press(&mut rig, 0, Button::Left);
        rig.run(100);
        assert!(rig.speed(Axis::Horizontal) > 0);
    }
}

/// §D/1 A button that is held at power-up acts only after it has been released.
#[test]
fn held_at_power_up() {
    for button in Button::ALL {
        let mut rig = rig();
        press(&mut rig, 1, button);
        rig.power_cycle();
        rig.run_while(1000, |rig| rig.is_still() && rig.valve_output(0) != ValveOutput::Opening);
        release(&mut rig, 1, button);
        rig.run(40);
        press(&mut rig, 1, button);
        rig.run(50);
        let acts = !rig.is_still() || rig.valve_output(0) != ValveOutput::Off;
        // Closing a closed valve is over at once.
        assert_eq!(acts, button != Button::Close, "{button:?}");
    }
}

/// §D/1 Nor does one whose contact shows as pressed only while the inputs settle.
#[test]
fn held_at_power_up_and_sensed_late() {
    for button in Button::ALL {
        for late_ms in [10, 50, 90] {
            let mut rig = rig();
            rig.power_cycle();
            rig.run(late_ms);
            press(&mut rig, 1, button);
            let inert =
                |rig: &mut Rig| rig.is_still() && rig.valve_output(0) != ValveOutput::Opening;
            rig.run_while(1000, inert);
            release(&mut rig, 1, button);
            rig.run(40);
            press(&mut rig, 1, button);
            rig.run(50);
            assert_eq!(inert(&mut rig), button == Button::Close, "{button:?} {late_ms}");
        }
    }
}

/// §D/1, §3.9/2 Close does: it is the safe direction.
#[test]
fn close_while_the_inputs_settle() {
    let mut rig = rig();
    rig.set(Param::GeneralResetValves, 1);
    press(&mut rig, 1, Button::Open);
    rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::OPEN);
    release(&mut rig, 1, Button::Open);
    rig.power_cycle();
    rig.run(50);
    press(&mut rig, 1, Button::Close);
    rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::CLOSED);
}

/// §3.18/7 Locked out they do nothing, nor does what is held over the release.
#[test]
fn locked_out() {
    let mut rig = rig();
    press(&mut rig, 0, Button::Left);
    press(&mut rig, 1, Button::Open);
    rig.run(300);
    assert!(!rig.is_still() && rig.valve_output(0) == ValveOutput::Opening);
    rig.all_accept(Body::Lockout { key: key::ENABLE });
    rig.run(10);
    rig.run_while(1000, |rig| rig.is_still() && rig.valve_output(0) != ValveOutput::Opening);
    release(&mut rig, 1, Button::Open);
    rig.run(40);
    press(&mut rig, 1, Button::Open);
    press(&mut rig, 1, Button::Up);
    rig.run_while(300, |rig| rig.is_still() && rig.valve_output(0) != ValveOutput::Opening);
    rig.all_accept(Body::Lockout { key: key::DISABLE });
    rig.run_while(300, |rig| rig.is_still() && rig.valve_output(0) != ValveOutput::Opening);
    release(&mut rig, 1, Button::Up);
    rig.run(40);
    press(&mut rig, 1, Button::Up);
    rig.run(100);
    assert!(rig.speed(Axis::Vertical) > 0);
}

/// §3.3.10/1 Refused where the request would be: folded, in between, on the way.
#[test]
fn refused_unless_deployed() {
    let mut wrapped = Rig::new(Composition::FULL);
    let mut deploying = wrapped.clone();
    deploying.accepts(SubsystemId::DEPLOYER, Body::Deploy);
    deploying.run(1000);
    let mut between = deploying.clone();
    between.accepts(SubsystemId::DEPLOYER, Body::Stop);
    for rig in [&mut wrapped, &mut deploying, &mut between] {
        for button in Button::ALL {
            press(rig, 0, button);
            rig.run_while(50, |rig| {
                [Axis::Vertical, Axis::Horizontal, Axis::Nozzle]
                    .iter()
                    .all(|axis| rig.speed(*axis) == 0)
                    && rig.valve_output(0) != ValveOutput::Opening
            });
            release(rig, 0, button);
            rig.run(20);
        }
    }
    // Held until it is deployed it acts then: it is held on purpose.
    press(&mut deploying, 0, Button::Left);
    deploying.run_until(20_000, |rig| rig.speed(Axis::Horizontal) > 0);
}

/// §3.3.10/1, §3.9/1, §3.16 During a search every button is refused, Close too, and it goes on.
#[test]
fn refused_while_searching() {
    let mut rig = Rig::deployed();
    let seek = Seek { start_h: -900, end_h: 900, start_v: 0, end_v: 600, analyse: 0 };
    rig.accepts(SubsystemId::DETECTOR, Body::StartSeek(seek));
    rig.run(300);
    let mut alone = rig.clone();
    for button in Button::ALL {
        press(&mut rig, 0, button);
        for _ in 0..10 {
            rig.step(10);
            alone.step(10);
            assert_eq!(rig.plant.outputs, alone.plant.outputs, "{button:?}");
        }
        release(&mut rig, 0, button);
        rig.step(10);
        alone.step(10);
    }
    assert!(rig.flags(SubsystemId::DETECTOR) & DetectorFlags::SEARCHING.bits() != 0);
}

/// §3.3.10/1 Open and Close act once when pressed, on Valve1, or on Valve2 where there is no Valve1.
#[test]
fn open_and_close() {
    for (chain, valve, id) in [
        (Composition::REMOTE.chain, 0, SubsystemId::VALVE1),
        (
            Composition::FULL.chain.without(&[SubsystemId::DEPLOYER, SubsystemId::VALVE1]),
            1,
            SubsystemId::VALVE2,
        ),
    ] {
        let mut rig = Rig::new(Composition { chain, ..Composition::REMOTE });
        press(&mut rig, 0, Button::Open);
        rig.run_until(5000, |rig| rig.valve(id) == ValveFlags::OPEN);
        assert_eq!(rig.valve_output(1 - valve), ValveOutput::Off);
        // Held on, it does not fight a Close that comes by request.
        rig.accepts(id, Body::Close { key: key::CLOSE });
        rig.run_until(5000, |rig| rig.valve(id) == ValveFlags::CLOSED);
        release(&mut rig, 0, Button::Open);
        rig.run(40);
        press(&mut rig, 0, Button::Open);
        rig.run(1000);
        press(&mut rig, 0, Button::Close);
        rig.run_until(5000, |rig| rig.valve(id) == ValveFlags::CLOSED);
        // Open and Close together are no wish for water.
        release(&mut rig, 0, Button::Open);
        rig.run(40);
        press(&mut rig, 0, Button::Open);
        rig.run_while(100, |rig| rig.valve_output(valve) != ValveOutput::Opening);
    }
}

/// §3.3.10/1 Blocked or faulty valves refuse the button as they refuse the request.
#[test]
fn open_is_refused_by_the_valve() {
    let faults: [fn(&mut Rig); 2] = [
        |rig| rig.plant.inputs.valves[0].blocked = true,
        |rig| rig.plant.inputs.valves[0].open_sensor_fault = true,
    ];
    for fault in faults {
        let mut rig = rig();
        fault(&mut rig);
        rig.run(50);
        press(&mut rig, 0, Button::Open);
        rig.run_while(200, |rig| rig.valve_output(0) == ValveOutput::Off);
    }
}

/// §3.3.10/1 A held button takes precedence: Move to its drive, and Wrap, are Denied from the post;
/// Stop is not, and other drives are free.
#[test]
fn precedence_over_requests() {
    let mut rig = Rig::deployed();
    rig.move_to(Axis::Horizontal, -9000);
    rig.run(500);
    press(&mut rig, 1, Button::Left);
    rig.run(1500);
    assert!(rig.speed(Axis::Horizontal) > 0, "the button turns it round");
    let denied = (SubsystemId::EXT_BUTTONS, Status::DENIED);
    assert_eq!(rig.one(SubsystemId::HORIZONTAL, Body::Move { destination: 0 }), denied);
    assert_eq!(rig.one(SubsystemId::DEPLOYER, Body::Wrap), denied);
    rig.move_to(Axis::Vertical, 600);
    rig.accepts(SubsystemId::VERTICAL, Body::Stop);
    release(&mut rig, 1, Button::Left);
    rig.run(50);
    assert!(rig.is_still(), "the Move is over");
    rig.move_to(Axis::Horizontal, 0);
}

/// §1/1 A post that is not part of the monitor does nothing.
#[test]
fn an_absent_post() {
    let mut rig = Rig::new(Composition::MINI);
    press(&mut rig, 1, Button::Left);
    rig.run_while(300, |rig| rig.is_still());
    rig.move_to(Axis::Horizontal, 300);
    rig.run(100);
    assert!(rig.speed(Axis::Horizontal) > 0);
    rig.all_accept(Body::Stop);
    rig.run(100);
    press(&mut rig, 0, Button::Left);
    rig.run(100);
    assert!(rig.speed(Axis::Horizontal) > 0);
}

/// §3.3.4, §3.1/4 A faulty drive does not run for a button either.
#[test]
fn a_faulty_drive() {
    let mut rig = rig();
    press(&mut rig, 0, Button::Left);
    rig.run(300);
    rig.plant.inputs.drives[Axis::Horizontal as usize].motor_open = true;
    rig.run(40);
    rig.run_while(200, |rig| rig.is_still());
    assert_eq!(rig.drive_flags(Axis::Horizontal), DriveFlags::MOTOR_BROKEN);
}

/// §3.3.10/1, §3.3.4 What is held while its drive is faulty, lost or has no supply, or while a search has it,
/// does not begin when that ends: an E-stop that is pulled out starts nothing. Pressed again it acts.
#[test]
fn held_until_a_fault_ends() {
    type Hinder = fn(&mut Rig, bool);
    let hindrances: [(&str, Hinder); 4] = [
        ("motor", |rig, on| rig.plant.inputs.drives[Axis::Horizontal as usize].motor_open = on),
        ("sensor", |rig, on| {
            rig.plant.inputs.drives[Axis::Horizontal as usize].position_sensor_fault = on;
        }),
        ("supply", |rig, on| rig.plant.inputs.main_voltage_dv = if on { 90 } else { 240 }),
        ("search", |rig, on| {
            let seek = Seek { start_h: -900, end_h: 900, start_v: 0, end_v: 600, analyse: 0 };
            let body = if on { Body::StartSeek(seek) } else { Body::Stop };
            rig.accepts(SubsystemId::DETECTOR, body);
        }),
    ];
    for (name, hinder) in hindrances {
        for held_before in [false, true] {
            let mut rig = Rig::deployed();
            if held_before && name != "supply" && name != "search" {
                press(&mut rig, 0, Button::Left);
                rig.run(300);
                assert!(rig.speed(Axis::Horizontal) > 0);
            }
            hinder(&mut rig, true);
            rig.run(500);
            press(&mut rig, 0, Button::Left);
            rig.run(300);
            hinder(&mut rig, false);
            rig.run(20);
            rig.run_while(2000, |rig| rig.speed(Axis::Horizontal) == 0);
            // Another drive is free.
            press(&mut rig, 0, Button::Up);
            rig.run(200);
            assert!(rig.speed(Axis::Vertical) > 0, "{name}");
            release(&mut rig, 0, Button::Left);
            rig.run(50);
            press(&mut rig, 0, Button::Left);
            rig.run(200);
            assert!(rig.speed(Axis::Horizontal) > 0, "{name}");
        }
    }
}

/// §3.3.1/3 Nor when a lost unit is back.
#[test]
fn held_until_a_unit_is_back() {
    let mut rig = Rig::new(Composition::EX);
    rig.deploy();
    press(&mut rig, 0, Button::Left);
    rig.run(500);
    assert!(rig.speed(Axis::Horizontal) > 0);
    rig.plant.units[Axis::Horizontal as usize].offline = true;
    rig.run(300);
    rig.plant.units[Axis::Horizontal as usize].offline = false;
    rig.run_while(2000, |rig| rig.speed(Axis::Horizontal) == 0);
}

/// A contact that opens for so long, ms, has not been released.
const BLIPS_MS: [u32; 3] = [10, 20, 30];

fn blip(rig: &mut Rig, button: Button, ms: u32) {
    release(rig, 0, button);
    rig.run(ms);
    press(rig, 0, button);
}

/// Held on it does nothing, however often its contact blips; released for longer it acts again.
fn acts_after_a_release_alone(rig: &mut Rig, button: Button, acts: impl Fn(&mut Rig) -> bool) {
    for ms in BLIPS_MS {
        for _ in 0..3 {
            blip(rig, button, ms);
            rig.run_while(60, |rig| !acts(rig));
        }
        // One that bounces is not released either, however long in all.
        for _ in 0..20 {
            blip(rig, button, ms);
            rig.step(10);
            assert!(!acts(rig), "{button:?} {ms}");
        }
        rig.run_while(300, |rig| !acts(rig));
    }
    blip(rig, button, 40);
    rig.run_until(300, acts);
}

/// §3.2/1, §3.18/7, §3.3.4 A blip of a held button undoes neither Stop nor the release of a lockout, and starts
/// nothing when a motor's circuit is whole again.
#[test]
fn a_blip_is_no_release() {
    type Hinder = fn(&mut Rig, Axis, bool);
    let hindrances: [Hinder; 4] = [
        |rig, _, on| {
            if on {
                rig.all_accept(Body::Stop);
            }
        },
        |rig, axis, on| {
            if on {
                rig.accepts(axis.id(), Body::Stop);
            }
        },
        |rig, _, on| {
            rig.all_accept(Body::Lockout { key: if on { key::ENABLE } else { key::DISABLE } });
        },
        |rig, axis, on| rig.plant.inputs.drives[axis as usize].motor_open = on,
    ];
    for hinder in hindrances {
        for (button, axis, sign) in DIRECTIONS {
            let mut rig = rig();
            press(&mut rig, 0, button);
            rig.run(200);
            hinder(&mut rig, axis, true);
            rig.run(20);
            blip(&mut rig, button, 20);
            rig.run_while(100, |rig| rig.is_still());
            hinder(&mut rig, axis, false);
            acts_after_a_release_alone(&mut rig, button, |rig| rig.speed(axis).signum() == sign);
        }
    }
}

/// §3.3.10/1 Open that is held on is no wish for water any more once it has acted or was refused; a step that
/// is longer than a blip shows a release.
#[test]
fn open_acts_once() {
    let opens = |rig: &mut Rig| rig.valve_output(0) == ValveOutput::Opening;
    let mut rig = rig();
    press(&mut rig, 0, Button::Open);
    rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::OPEN);
    rig.accepts(SubsystemId::VALVE1, Body::Close { key: key::CLOSE });
    rig.run_until(5000, |rig| rig.valve(SubsystemId::VALVE1) == ValveFlags::CLOSED);
    acts_after_a_release_alone(&mut rig, Button::Open, opens);

    let mut rig = self::rig();
    rig.plant.inputs.valves[0].blocked = true;
    rig.run(50);
    press(&mut rig, 0, Button::Open);
    rig.run(50);
    rig.plant.inputs.valves[0].blocked = false;
    rig.run(50);
    let mut slow = rig.clone();
    acts_after_a_release_alone(&mut rig, Button::Open, opens);
    release(&mut slow, 0, Button::Open);
    slow.step(31);
    press(&mut slow, 0, Button::Open);
    slow.run_until(50, opens);
}

/// Stopping waits for nothing; a press that begins a motion has to last.
#[test]
fn a_blip_stops_at_once() {
    let mut rig = rig();
    press(&mut rig, 0, Button::Left);
    rig.run(300);
    let ends: [fn(&mut Rig); 5] = [
        |rig| release(rig, 0, Button::Left),
        |rig| set(rig, 0, Button::Left, ButtonState::Short),
        |rig| set(rig, 0, Button::Left, ButtonState::Open),
        |rig| press(rig, 0, Button::Right),
        |rig| press(rig, 1, Button::Right),
    ];
    for stops in ends {
        let mut rig = rig.clone();
        assert!(rig.speed(Axis::Horizontal) > 0);
        stops(&mut rig);
        rig.step(1);
        assert!(rig.is_still());
    }
    release(&mut rig, 0, Button::Left);
    rig.step(1);
    press(&mut rig, 0, Button::Left);
    rig.run_while(30, |rig| rig.is_still());
    rig.run(30);
    assert!(rig.speed(Axis::Horizontal) > 0);
}

/// §D/6 Pressed for 1 to 30 ms, whatever the step, no button begins anything: no drive turns, no valve opens, no Move
/// ends, and no program pauses. Pressed for longer it acts, and Close at once.
#[test]
fn a_blip_begins_nothing() {
    for (post, step_ms) in [(0, 1), (1, 10)] {
        for button in Button::ALL {
            for blip_ms in [1, 2, 10, 20, 30, 31, 40] {
                let mut rig = Rig::deployed();
                rig.plant.place(Axis::Nozzle, 30);
                rig.pause();
                rig.run(50);
                press(&mut rig, post, button);
                let mut acted = false;
                for at_ms in (0..100).step_by(step_ms) {
                    if at_ms >= blip_ms {
                        release(&mut rig, post, button);
                    }
                    rig.step(step_ms as u32);
                    acted |= DIRECTIONS
                        .iter()
                        .any(|(_, axis, _)| rig.drive_flags(*axis).contains(DriveFlags::MOVE))
                        || rig.valve_output(0) == ValveOutput::Opening;
                }
                // The 31st sample of 1 ms is 30 ms after the first.
                let lasts = blip_ms > 30 && button != Button::Close;
                assert_eq!(acted, lasts, "{button:?} {blip_ms} ms, a sample each {step_ms} ms");
            }
        }
    }
}

/// §D/6, §3.1/3 Nor does a contact that blips again and again turn a drive under a Move round, or pause an extinguishing
/// whose water then runs on at one place.
#[test]
fn blips_pause_nothing() {
    let quench = Quench::Program { program: 0, centre_h: 0, centre_v: 0, nozzle: 30 };
    for blip_ms in [1, 10, 30] {
        for (button, ..) in DIRECTIONS {
            let mut rig = Rig::deployed();
            rig.accepts(SubsystemId::CONTROL, Body::StartQuench(quench));
            rig.run(500);
            for ms in 0..2000 {
                let state = [ButtonState::Released, ButtonState::Pressed];
                set(&mut rig, 0, button, state[usize::from(ms % 100 < blip_ms)]);
                rig.step(1);
                let flags = ControlFlags::from_bits_retain(rig.flags(SubsystemId::CONTROL));
                assert!(!flags.contains(ControlFlags::PAUSED), "{button:?} {blip_ms} ms");
            }
        }
    }
    let mut rig = rig();
    rig.move_to(Axis::Horizontal, 9000);
    rig.run(500);
    for ms in 0..2000 {
        let state = [ButtonState::Released, ButtonState::Pressed];
        set(&mut rig, 0, Button::Right, state[usize::from(ms % 100 < 30)]);
        rig.step(1);
        assert!(rig.speed(Axis::Horizontal) > 0);
    }
}

/// §3.3.10 A line that breaks or is shorted passes through "pressed": nothing begins.
#[test]
fn a_line_that_breaks_presses_nothing() {
    for end in [ButtonState::Short, ButtonState::Open] {
        for button in Button::ALL {
            let mut rig = rig();
            rig.run(50);
            for _ in 0..20 {
                press(&mut rig, 0, button);
                rig.step(1);
                assert!(rig.is_still() && rig.valve_output(0) != ValveOutput::Opening);
            }
            set(&mut rig, 0, button, end);
            rig.run_while(200, |rig| rig.is_still() && rig.valve_output(0) != ValveOutput::Opening);
        }
    }
}

/// §3.3.4 What is pressed for a moment while its drive is faulty does not act when the fault ends, however soon.
#[test]
fn pressed_just_before_a_fault_ends() {
    let mut rig = rig();
    rig.plant.inputs.drives[Axis::Horizontal as usize].motor_open = true;
    rig.run(100);
    press(&mut rig, 0, Button::Left);
    rig.run(20);
    rig.plant.inputs.drives[Axis::Horizontal as usize].motor_open = false;
    rig.run_while(1000, |rig| rig.is_still());
}
