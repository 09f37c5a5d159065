//! Drives: how fast, how far, with how much current, each at its bounds.

use crate::common::{Rig, STEP_MS};
use lafet_device::Composition;
use lafet_device::composition::DriveKind;
use lafet_device::image::Axis;
use lafet_proto::flags::{Button, ButtonState, DriveFlags};
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};

const OVERLOAD: DriveFlags = DriveFlags::AMPERAGE_OVERLOAD;
const LIMITS_OFF: Body<'static> = Body::SwitchLimits { new_state: 0 };
const LIMITS_ON: Body<'static> = Body::SwitchLimits { new_state: 1 };

fn rig() -> Rig {
    Rig::new(Composition::REMOTE)
}

/// A drive on its way, fast, when it is this far from its target: its next speed.
fn speed_at(axis: Axis, way: i64, away: i64) -> i16 {
    let (speed, target) = match axis {
        Axis::Nozzle => (Param::NozzleSpeed, 30 + 30 * way),
        _ => (Param::HorizontalSpeed, 9000 * way),
    };
    let mut rig = rig();
    rig.set(speed, 255);
    rig.plant.place(axis, if axis == Axis::Nozzle { 30 - 30 * way } else { 0 });
    rig.run(20);
    rig.move_to(axis, target as i16);
    rig.run(1000);
    rig.plant.place(axis, target - away * way);
    // A step that is too long for a position to have jumped in.
    rig.device.step(rig.now_ms + 4 * STEP_MS, &mut rig.plant);
    rig.speed(axis)
}

/// §3.1/4 The approach: at three quarters of the acceleration (30 °/s², 40 mm/s²), in proportion over
/// the last quarter of a second, and creeping at the end.
#[test]
fn the_approach() {
    for way in [1, -1] {
        for (away, speed) in [
            (600, 212),
            (240, 134),
            (180, 116),
            (120, 80),
            (60, 40),
            (6, 4),
            (3, 2),
            (2, 2),
            (1, 2),
        ] {
            let found = speed_at(Axis::Horizontal, way, away);
            assert_eq!(i64::from(found), speed * way, "{away}' to go");
        }
        for (away, speed) in [(10, 244), (4, 154), (3, 120), (2, 80), (1, 40)] {
            let found = speed_at(Axis::Nozzle, way, away);
            assert_eq!(i64::from(found), speed * way, "{away} mm to go");
        }
    }
}

/// §3.1/4 Three counts beyond its target it has not arrived: it comes back.
#[test]
fn too_far_beyond_is_not_arriving() {
    for (target, beyond) in [(600, 603), (-600, -603)] {
        let mut rig = rig();
        rig.move_to(Axis::Vertical, target);
        rig.run_until(10_000, |rig| {
            (rig.plant.position(Axis::Vertical) - i64::from(target)).abs() < 5
        });
        rig.plant.place(Axis::Vertical, beyond);
        rig.run(50);
        assert_eq!(rig.speed(Axis::Vertical).signum(), -target.signum());
        rig.run_until(1000, |rig| rig.drive(Axis::Vertical).position == target);
    }
}

/// §3.3 A lower speed acts at once, a higher one as fast as the acceleration allows; a turn to a
/// slower speed is a ramp too.
#[test]
fn a_new_speed() {
    let mut rig = rig();
    rig.move_to(Axis::Horizontal, 10_000);
    rig.run(2000);
    assert_eq!(rig.speed(Axis::Horizontal), 200);
    rig.set(Param::HorizontalSpeed, 5);
    rig.step(STEP_MS);
    assert_eq!(rig.speed(Axis::Horizontal), 50);
    rig.set(Param::HorizontalSpeed, 20);
    // 30 °/s² are 3 of 0.1 °/s in a step.
    for speed in [53, 56, 59] {
        rig.step(STEP_MS);
        assert_eq!(rig.speed(Axis::Horizontal), speed);
    }
    rig.run(1000);
    rig.set(Param::HorizontalSpeed, 5);
    rig.move_to(Axis::Horizontal, -10_000);
    for speed in [197, 194, 191] {
        rig.step(STEP_MS);
        assert_eq!(rig.speed(Axis::Horizontal), speed);
    }
}

/// §D/9 MinSpeed above Speed: a drive does not turn faster than it is set to.
#[test]
fn least_speed_above_the_highest() {
    let mut rig = rig();
    rig.set(Param::VerticalSpeed, 1);
    rig.set(Param::VerticalMinSpeed, 30);
    rig.move_to(Axis::Vertical, 600);
    rig.run_while(12_000, |rig| rig.speed(Axis::Vertical).abs() <= 10);
    assert_eq!(rig.drive(Axis::Vertical).position, 600);
}

/// §3.3.4/1 More than MaxCurrent for 0.2 s is a start, for longer an overload; MaxCurrent itself never.
#[test]
fn starting_current() {
    for (current_da, overload) in [(80, false), (81, true)] {
        let mut rig = rig();
        rig.set(Param::VerticalSlowCurrent, 0);
        rig.plant.drive(Axis::Vertical).current_da = 81;
        rig.move_to(Axis::Vertical, 3000);
        // In the first step it is fed, in the next the current shows: 20 of these are 0.2 s.
        rig.run_while(210, |rig| rig.drive_flags(Axis::Vertical) == DriveFlags::MOVE);
        rig.plant.drive(Axis::Vertical).current_da = current_da;
        rig.step(STEP_MS);
        assert_eq!(rig.drive_flags(Axis::Vertical).contains(OVERLOAD), overload);
        assert_eq!(rig.speed(Axis::Vertical) == 0, overload);
    }
}

/// §3.3.4/1 Overload adds up over single samples without it; less than half of the time is none.
#[test]
fn overload_with_gaps() {
    for (over, of, overload) in
        [(149, 150, true), (3, 4, true), (2, 3, true), (1, 2, false), (1, 4, false)]
    {
        let mut rig = rig();
        rig.set(Param::VerticalSlowCurrent, 0);
        rig.move_to(Axis::Vertical, 4500);
        rig.run(500);
        let mut found = false;
        for step in 0..200 {
            rig.plant.drive(Axis::Vertical).current_da = if step % of < over { 99 } else { 0 };
            rig.step(STEP_MS);
            found |= rig.drive_flags(Axis::Vertical).contains(OVERLOAD);
        }
        assert_eq!(found, overload, "{over} of {of}");
    }
}

/// §3.3.4/1 While it turns round, the direction that is refused is the one in which it still went.
#[test]
fn overload_in_a_turn() {
    for way in [1, -1] {
        let mut rig = rig();
        rig.plant.place(Axis::Vertical, 1800);
        rig.run(20);
        rig.move_to(Axis::Vertical, 1800 + 2000 * way);
        rig.run(1500);
        rig.set(Param::VerticalAcceleration, 5);
        rig.plant.drive(Axis::Vertical).current_da = 100;
        rig.move_to(Axis::Vertical, 1800 - 2000 * way);
        rig.run(100);
        assert_eq!(rig.speed(Axis::Vertical).signum(), way);
        rig.run_until(300, |rig| rig.drive_flags(Axis::Vertical).contains(OVERLOAD));
        rig.plant.drive(Axis::Vertical).current_da = 20;
        let on = Body::Move { destination: 1800 + 2000 * way };
        assert_eq!(rig.status(SubsystemId::VERTICAL, on), Status::MODULE_FAULT);
        rig.move_to(Axis::Vertical, 1800 - 2000 * way);
        rig.run(100);
        assert_eq!(rig.speed(Axis::Vertical).signum(), -way);
    }
}

/// §3.3.4/1, §3.17/1 A cut-off is an overload whether the drive just turned or just stood, whatever the
/// steps are; also of a drive that runs without limits.
#[test]
fn overload_by_cutting_off() {
    for step_ms in [10, 40, 50] {
        for way in [1_i16, -1] {
            for limitless in [false, true] {
                let mut rig = rig();
                if limitless {
                    rig.accepts(SubsystemId::VERTICAL, LIMITS_OFF);
                }
                rig.plant.drive(Axis::Vertical).current_da = 170;
                rig.move_to(Axis::Vertical, 600 * way);
                while !rig.drive_flags(Axis::Vertical).contains(OVERLOAD) {
                    assert!(rig.now_ms < 2000, "never");
                    rig.step(step_ms);
                }
                rig.plant.drive(Axis::Vertical).current_da = 20;
                let again =
                    rig.status(SubsystemId::VERTICAL, Body::Move { destination: 600 * way });
                assert_eq!(again, Status::MODULE_FAULT, "{step_ms} ms, {way}, {limitless}");
                rig.move_to(Axis::Vertical, -600 * way);
                rig.run(100);
                assert_eq!(rig.speed(Axis::Vertical).signum(), -way);
            }
        }
    }
}

/// §3.1, §3.3.4/1 A Move to where the drive is is no way into its overload.
#[test]
fn staying_is_no_direction() {
    let mut rig = rig();
    rig.plant.drive(Axis::Vertical).current_da = 100;
    rig.move_to(Axis::Vertical, 3000);
    rig.run_until(1000, |rig| rig.drive_flags(Axis::Vertical).contains(OVERLOAD));
    let here = rig.drive(Axis::Vertical).position;
    let status = rig.status(SubsystemId::VERTICAL, Body::Move { destination: here });
    assert_eq!(status, Status::ACCEPTED);
    rig.run_while(200, |rig| rig.is_still());
}

/// §3.3.4 SpeedSlowAmp: above SlowCurrent, until the current has fallen by more than an eighth of it.
#[test]
fn slowing_at_its_bounds() {
    let mut rig = rig();
    rig.move_to(Axis::Horizontal, 10_800);
    for (current_da, slow) in [(60, false), (61, true), (54, true), (53, false), (60, false)] {
        rig.plant.drive(Axis::Horizontal).current_da = current_da;
        rig.run(200);
        let flags = rig.drive_flags(Axis::Horizontal);
        assert_eq!(flags.contains(DriveFlags::SPEED_SLOW_AMP), slow, "{current_da}");
    }
}

/// §3.3.4/2 Move: also while it runs out, but not for the noise of a speed sensor at rest.
#[test]
fn a_drive_that_runs_out_moves() {
    let mut rig = rig();
    for (speed_tenths, moves) in [(1, false), (-1, false), (2, true), (-2, true), (0, false)] {
        rig.plant.inputs.drives[Axis::Vertical as usize].speed_tenths = speed_tenths;
        rig.device.step(rig.now_ms, &mut rig.plant);
        let flags = rig.drive_flags(Axis::Vertical);
        assert_eq!(flags.contains(DriveFlags::MOVE), moves, "{speed_tenths}");
    }
}

/// §3.17/1 A direct drive is not counted while it runs without limits, nor while it runs out; one that
/// is at rest is, and with limits on every one.
#[test]
fn what_counts_without_limits() {
    for (limitless, speed_tenths, shown) in
        [(true, 50, 0), (true, -50, 0), (true, 0, 700), (false, 50, 700), (false, 0, 700)]
    {
        let mut rig = rig();
        if limitless {
            rig.accepts(SubsystemId::VERTICAL, LIMITS_OFF);
        }
        rig.plant.place(Axis::Vertical, 700);
        rig.plant.inputs.drives[Axis::Vertical as usize].speed_tenths = speed_tenths;
        rig.device.step(rig.now_ms + STEP_MS, &mut rig.plant);
        assert_eq!(rig.drive(Axis::Vertical).position, shown, "{limitless} {speed_tenths}");
    }
}

/// §3.17/1 Without limits no limit is reached.
#[test]
fn no_limit_is_reached_without_limits() {
    for (at, flag) in [(4500, DriveFlags::MAX_LIMIT_REACHED), (-900, DriveFlags::MIN_LIMIT_REACHED)]
    {
        let mut rig = rig();
        rig.plant.place(Axis::Vertical, at);
        rig.run(20);
        assert_eq!(rig.drive_flags(Axis::Vertical), flag);
        rig.accepts(SubsystemId::VERTICAL, LIMITS_OFF);
        assert_eq!(rig.drive_flags(Axis::Vertical), DriveFlags::LIMITLESS);
    }
}

/// §3.17/2 On where limits are on changes nothing: what moves goes on.
#[test]
fn limits_on_where_they_are_on() {
    let mut rig = rig();
    rig.move_to(Axis::Vertical, 3000);
    rig.run(500);
    for new_state in [1, 2] {
        rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state });
        rig.run_while(200, |rig| rig.speed(Axis::Vertical) > 0);
    }
}

/// §3.5/1 A new limit that the way does not reach stops nothing.
#[test]
fn a_limit_out_of_the_way() {
    for (param, limit) in [
        (Param::VerticalMaxLimit, 600),
        (Param::VerticalMaxLimit, 700),
        (Param::VerticalMinLimit, -100),
    ] {
        let mut rig = rig();
        rig.move_to(Axis::Vertical, 600);
        rig.run(500);
        rig.set(param, limit);
        rig.run_until(10_000, |rig| rig.drive(Axis::Vertical).position == 600);
    }
    let mut rig = rig();
    rig.plant.place(Axis::Vertical, 600);
    rig.run(20);
    rig.move_to(Axis::Vertical, 100);
    rig.run(300);
    rig.set(Param::VerticalMinLimit, 200);
    rig.run(20);
    assert!(rig.is_still());
}

/// §3.17/5 The zero point is taken at rest, as far as the parameter can tell it.
#[test]
fn the_zero_point_at_its_bounds() {
    for (zero, at, status) in [
        (30_000, 2767, Status::ACCEPTED),
        (30_000, 2768, Status::INVALID_VALUE),
        (-30_000, -2767, Status::ACCEPTED),
        (-30_000, -2768, Status::INVALID_VALUE),
    ] {
        let mut rig = rig();
        rig.set(Param::HorizontalZeroPoint, zero);
        rig.accepts(SubsystemId::HORIZONTAL, LIMITS_OFF);
        rig.plant.place(Axis::Horizontal, i64::from(zero + at));
        rig.run(20);
        assert_eq!(rig.set(Param::HorizontalZeroPoint, at), status, "{at}");
    }
    let mut rig = rig();
    rig.move_to(Axis::Vertical, 3000);
    rig.run(200);
    assert_eq!(rig.set(Param::VerticalZeroPoint, 10), Status::BUSY);
    rig.accepts(SubsystemId::VERTICAL, Body::Stop);
    assert_eq!(rig.set(Param::VerticalZeroPoint, 10), Status::ACCEPTED);
}

/// §3.17/5 What has been taken as a limit stays where it is when the zero point is taken after it.
#[test]
fn a_limit_taken_before_the_zero_point() {
    let mut rig = rig();
    rig.accepts(SubsystemId::VERTICAL, LIMITS_OFF);
    for (at, param) in [(-300, Param::VerticalMinLimit), (900, Param::VerticalMaxLimit)] {
        rig.plant.place(Axis::Vertical, at);
        rig.run(20);
        assert_eq!(rig.set(param, at as i32), Status::ACCEPTED);
    }
    rig.plant.place(Axis::Vertical, 100);
    rig.run(20);
    assert_eq!(rig.set(Param::VerticalZeroPoint, 100), Status::ACCEPTED);
    rig.accepts(SubsystemId::VERTICAL, LIMITS_ON);
    let limits = rig.limits(Axis::Vertical);
    assert_eq!((limits.min, limits.max), (-400, 800));
}

/// §3.3.4/2 At an end switch, where there is nowhere to go, Move is not even set.
#[test]
fn no_move_into_an_end_switch() {
    for (at, destination) in [(300, 900), (-300, -900)] {
        for kind in [DriveKind::Encoder, DriveKind::LimitSwitches] {
            let mut rig = Rig::new(Composition { drives: [kind; 4], ..Composition::REMOTE });
            rig.plant.drive(Axis::Vertical).switches = (-300, 300);
            rig.plant.place(Axis::Vertical, at);
            rig.run(50);
            rig.move_to(Axis::Vertical, destination);
            assert!(!rig.drive_flags(Axis::Vertical).contains(DriveFlags::MOVE));
            rig.move_to(Axis::Vertical, -destination.clamp(-600, 600));
            assert!(rig.drive_flags(Axis::Vertical).contains(DriveFlags::MOVE));
        }
    }
}

/// §3.3.4 A request that is repeated does not put off the judgement of the motion.
#[test]
fn repeated_moves_put_nothing_off() {
    let mut rig = rig();
    rig.plant.drive(Axis::Horizontal).jammed = true;
    for _ in 0..10 {
        rig.ask(SubsystemId::HORIZONTAL, Body::Move { destination: 9000 });
        rig.run(100);
    }
    assert!(rig.drive_flags(Axis::Horizontal).contains(DriveFlags::INTERNAL_FAULT));
}

/// §3.3.4 TRVEngage at a TrvPosition of 0.
#[test]
fn trv_at_zero() {
    let mut rig = Rig::new(Composition::MINI);
    rig.set(Param::NozzleTrvPosition, 0);
    rig.run(20);
    assert!(rig.drive_flags(Axis::Nozzle).contains(DriveFlags::TRV_ENGAGE));
    assert!(!rig.drive_flags(Axis::Vertical).contains(DriveFlags::TRV_ENGAGE));
}

/// §3.3.10/1, §3.17/1 A held button runs on when limits are switched off, past the limit.
#[test]
fn a_held_button_when_limits_are_switched_off() {
    let mut rig = rig();
    rig.plant.place(Axis::Vertical, 4000);
    rig.plant.inputs.buttons[0][Button::Up as usize] = ButtonState::Pressed;
    rig.run(500);
    rig.accepts(SubsystemId::VERTICAL, LIMITS_OFF);
    rig.run_while(5000, |rig| rig.speed(Axis::Vertical) > 0);
    assert!(rig.plant.position(Axis::Vertical) > 4500);
}
