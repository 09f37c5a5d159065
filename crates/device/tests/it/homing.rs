//! §D/7 A position that a reset forgets: not homed, homed at an end switch, and what relies on neither.

use crate::common::Rig;
use lafet_device::Composition;
use lafet_device::image::Axis;
use lafet_proto::flags::{Button, ButtonState, ControlFlags, DriveFlags};
use lafet_proto::param::{DriveParam, Param};
use lafet_proto::request::{Body, Quench};
use lafet_proto::{Status, SubsystemId};

const AIMING: [Axis; 3] = [Axis::Vertical, Axis::Horizontal, Axis::Nozzle];
/// Where the end switches are, in the coordinates of an absolute sensor, and the limits inside them.
const ENDS: (i64, i64) = (-80, 80);
const LIMITS: (i32, i32) = (-60, 60);
/// The sensor reads this at the true zero after the next start.
const FORGOTTEN: i32 = 777;

fn param(axis: Axis, name: &str) -> Param {
    Param::by_name(axis.id(), name).unwrap()
}

/// A monitor whose drive was homed at this end before it was switched off at this place.
fn forgotten(axis: Axis, up: bool, at: i64) -> Rig {
    let mut rig = Rig::deployed();
    forget(&mut rig, axis, up, at);
    rig
}

fn forget(rig: &mut Rig, axis: Axis, up: bool, at: i64) {
    for (which, value) in [(DriveParam::MinLimit, LIMITS.0), (DriveParam::MaxLimit, LIMITS.1)] {
        rig.set(Param::of_drive(axis.id(), which).unwrap(), value);
    }
    rig.set(param(axis, "Homing"), if up { 2 } else { 1 });
    rig.set(param(axis, "HomePosition"), (if up { ENDS.1 } else { ENDS.0 }) as i32);
    rig.run(500);
    assert!(rig.device.params().is_stored());
    rig.plant.drive(axis).switches = ENDS;
    rig.plant.drive(axis).stops = (ENDS.0 - 2, ENDS.1 + 2);
    rig.plant.drive(axis).encoder_offset = FORGOTTEN;
    rig.plant.place(axis, at);
    rig.power_cycle_and_settle();
}

fn not_homed(rig: &mut Rig, axis: Axis) -> bool {
    let bits = rig.get(Param::GeneralInputFaults).unwrap()[0];
    let told = bits & 1 << (8 + axis as i32) != 0;
    assert_eq!(rig.drive_flags(axis).contains(DriveFlags::LIMITLESS), told);
    told
}

/// Both end switches at a time are a broken wire, and no end.
#[test]
fn not_homed_at_both_ends() {
    for (axis, up) in AIMING.into_iter().flat_map(|axis| [(axis, false), (axis, true)]) {
        let mut rig = forgotten(axis, up, 0);
        rig.move_to(axis, if up { i16::MAX } else { -i16::MAX });
        rig.run_until(20_000, |rig| rig.speed(axis) != 0);
        rig.plant.drive(axis).switches = (1000, -1000);
        rig.run(500);
        assert!(not_homed(&mut rig, axis), "{axis:?} {up}");
    }
}

/// After a start nothing moves by itself, Limitless and InputFaults tell it. A Move towards the switch, slow,
/// ends there and homes; then the position is that of an absolute sensor, and limits hold.
#[test]
fn homed_at_the_switch() {
    for (axis, up) in AIMING.into_iter().flat_map(|axis| [(axis, false), (axis, true)]) {
        for at in [-10, 0, 20] {
            let mut rig = forgotten(axis, up, at);
            assert!(not_homed(&mut rig, axis));
            rig.run_while(2000, |rig| rig.is_still());
            // The way does not matter: Move runs to the end (§3.17).
            rig.move_to(axis, if up { i16::MAX } else { -i16::MAX });
            rig.run_while(500, |rig| rig.speed(axis).abs() <= 30);
            rig.run_until(60_000, |rig| rig.is_still() && !not_homed(rig, axis));
            let end = if up { ENDS.1 } else { ENDS.0 };
            assert!((rig.plant.position(axis) - end).abs() <= 2, "{axis:?}");
            rig.run(500);
            let reported = i64::from(rig.drive(axis).position);
            assert!((reported - rig.plant.position(axis)).abs() <= 2, "{axis:?} {reported}");
            assert!(rig.drive_flags(axis).is_sound());
            // Limits hold, on both sides.
            for (destination, limit) in [(i16::MAX, LIMITS.1), (-i16::MAX, LIMITS.0)] {
                rig.move_to(axis, destination);
                rig.run_until(60_000, |rig| rig.is_still() && rig.drive_flags(axis).is_idle());
                let at = rig.plant.position(axis);
                assert!((at - i64::from(limit)).abs() <= 3, "{axis:?} {at}");
            }
        }
    }
}

trait Judged {
    fn is_sound(&self) -> bool;
    fn is_idle(&self) -> bool;
}

impl Judged for DriveFlags {
    fn is_sound(&self) -> bool {
        let faults = DriveFlags::INTERNAL_FAULT
            | DriveFlags::POS_ENCODER_FAULT
            | DriveFlags::SPEED_ENCODER_FAULT
            | DriveFlags::LIMITLESS;
        !self.intersects(faults)
    }

    fn is_idle(&self) -> bool {
        !self.contains(DriveFlags::MOVE)
    }
}

/// The other end homes nothing, nor does a switch that is closed from the start, or opens for a moment; one
/// that was left and reached again does.
#[test]
fn what_does_not_home() {
    for axis in AIMING {
        let mut rig = forgotten(axis, false, 20);
        rig.move_to(axis, i16::MAX);
        rig.run_until(60_000, |rig| rig.is_still());
        rig.run(500);
        assert!(not_homed(&mut rig, axis));

        let mut rig = forgotten(axis, false, ENDS.0);
        rig.move_to(axis, -i16::MAX);
        rig.run_while(1000, |rig| rig.is_still());
        assert!(not_homed(&mut rig, axis));
        // A contact that opens for 50 ms: the drive runs on, and has not come from anywhere.
        rig.plant.drive(axis).switches.0 = ENDS.0 - 100;
        rig.move_to(axis, -i16::MAX);
        rig.run(50);
        rig.plant.drive(axis).switches.0 = ENDS.0;
        rig.run(500);
        assert!(not_homed(&mut rig, axis), "{axis:?}");

        // Left and reached again.
        let mut rig = forgotten(axis, false, ENDS.0);
        let far = if axis == Axis::Nozzle { 5 } else { 65 };
        rig.move_to(axis, i16::MAX);
        rig.run_until(60_000, |rig| rig.plant.position(axis) >= ENDS.0 + far);
        rig.all_accept(Body::Stop);
        rig.move_to(axis, -i16::MAX);
        rig.run_until(60_000, |rig| rig.is_still());
        rig.run(500);
        assert!(!not_homed(&mut rig, axis), "{axis:?}");
    }
}

/// §D/6 A drive that starts on its switch has to leave it, also when the contact there blips at power-up and a Move comes
/// before anything counts.
#[test]
fn a_blip_at_the_start_homes_nothing() {
    for (axis, ms) in AIMING.into_iter().flat_map(|axis| [0, 10, 30].map(|ms| (axis, ms))) {
        let mut rig = Rig::new(Composition::REMOTE);
        forget(&mut rig, axis, false, ENDS.0);
        rig.plant.drive(axis).switches.0 = if ms > 0 { ENDS.0 - 100 } else { ENDS.0 };
        rig.plant.place(axis, ENDS.0);
        rig.power_cycle();
        rig.move_to(axis, -i16::MAX);
        rig.run(ms);
        rig.plant.drive(axis).switches.0 = ENDS.0;
        rig.run(1000);
        assert!(not_homed(&mut rig, axis), "{axis:?} {ms}");
    }
}

/// What goes to a position is refused until then: programs, Wrap, limits and the zero point. What is moved
/// by hand is moved, slowly, and an end switch stops it.
#[test]
fn what_waits_for_it() {
    for axis in [Axis::Vertical, Axis::Horizontal] {
        let mut rig = forgotten(axis, true, 0);
        let quench = Quench::Program { program: 0, centre_h: 0, centre_v: 0, nozzle: 30 };
        for (to, body) in [
            (SubsystemId::DEPLOYER, Body::Wrap),
            (SubsystemId::CONTROL, Body::StartQuench(quench)),
            (SubsystemId::DETECTOR, Body::StartJustify),
            (axis.id(), Body::SwitchLimits { new_state: 1 }),
        ] {
            assert_eq!(rig.one(to, body).1, Status::DENIED, "{body:?}");
        }
        rig.run_while(1000, |rig| rig.is_still());
        assert!(
            !ControlFlags::from_bits_retain(rig.flags(SubsystemId::CONTROL))
                .contains(ControlFlags::QUENCH)
        );
        rig.accepts(axis.id(), Body::SwitchLimits { new_state: 0 });
        for which in [DriveParam::MinLimit, DriveParam::MaxLimit, DriveParam::ZeroPoint] {
            let position = i32::from(rig.drive(axis).position);
            let param = Param::of_drive(axis.id(), which).unwrap();
            assert_eq!(rig.set(param, position), Status::DENIED);
        }
        let button = if axis == Axis::Vertical { Button::Up } else { Button::Left };
        rig.plant.inputs.buttons[0][button as usize] = ButtonState::Pressed;
        rig.run(200);
        assert!((1..=30).contains(&rig.speed(axis)));
        rig.run_until(60_000, |rig| rig.is_still());
        assert!((rig.plant.position(axis) - ENDS.1).abs() <= 2);
    }
}

/// §D/1 An absolute sensor needs none of it, whatever HomePosition says; nor has a remote unit.
#[test]
fn an_absolute_sensor() {
    for composition in [Composition::FULL, Composition::REMOTE] {
        let mut rig = Rig::new(composition);
        for axis in AIMING {
            rig.set(param(axis, "HomePosition"), 500);
        }
        rig.run(500);
        rig.power_cycle_and_settle();
        for axis in AIMING {
            assert!(!not_homed(&mut rig, axis));
            assert_eq!(rig.drive(axis).position, 0);
        }
    }
}

/// §D/7 A sensor that says it does not know where it counts from is faulty where the position is relied on, and as it
/// should be where the drive is homed.
#[test]
fn a_sensor_that_has_lost_its_place() {
    for homing in [0, 1] {
        let mut rig = Rig::new(Composition::REMOTE);
        rig.set(Param::HorizontalHoming, homing);
        rig.run(100);
        rig.plant.inputs.drives[Axis::Horizontal as usize].unreferenced = true;
        rig.plant.place(Axis::Horizontal, 300);
        rig.plant.drive(Axis::Horizontal).switches = (0, 90_000);
        rig.power_cycle_and_settle();
        let status = rig.status(SubsystemId::HORIZONTAL, Body::Move { destination: -32_767 });
        let lost = rig.drive_flags(Axis::Horizontal).contains(DriveFlags::POS_ENCODER_FAULT);
        assert_eq!(
            (status, lost),
            match homing {
                0 => (Status::MODULE_FAULT, true),
                _ => (Status::ACCEPTED, false),
            }
        );
        if homing == 1 {
            rig.run_until(10_000, |rig| {
                !rig.drive_flags(Axis::Horizontal).contains(DriveFlags::LIMITLESS)
            });
            rig.move_to(Axis::Horizontal, 60);
        }
    }
}

/// §D/7, §3.1/8 A Move to where a drive says it is leads nowhere, whether that is known or not.
#[test]
fn not_homed_it_stays_where_it_is() {
    for (axis, up) in AIMING.into_iter().flat_map(|axis| [(axis, false), (axis, true)]) {
        let mut rig = forgotten(axis, up, 20);
        assert!(not_homed(&mut rig, axis), "{axis:?} {up}");
        let said = rig.drive(axis).position;
        rig.move_to(axis, said);
        rig.run_while(500, |rig| rig.is_still());
        assert_eq!(rig.plant.position(axis), 20);
    }
}
