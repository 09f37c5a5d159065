//! Drives: arriving, limits, overload, faults that show by watching.

use crate::common::{Plant, Rig};
use lafet_device::composition::DriveKind;
use lafet_device::image::Axis;
use lafet_device::{Composition, Device};
use lafet_proto::flags::DriveFlags;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};

/// Always in working position: what forbids aiming is another test's business.
fn rig() -> Rig {
    Rig::new(Composition::REMOTE)
}

fn with_kind(kind: DriveKind) -> Rig {
    Rig::new(Composition { drives: [kind; 4], ..Composition::REMOTE })
}

/// §3.1/4, §3.1/7, §3.3.4/2 At steps of 1, 10 and 20 ms every drive comes to its target exactly, and
/// not beyond it; Move is set while it turns.
#[test]
fn arrives_without_overshoot() {
    let targets = [(0, 1200), (1200, -600), (0, 1), (0, -1), (3, 4500), (100, 130), (-900, 4500)];
    for dt_ms in [1, 10, 20] {
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            for (from, to) in targets {
                let (from, to) = if axis == Axis::Nozzle {
                    (from.clamp(0, 60), to.clamp(0, 60))
                } else {
                    (from, to)
                };
                let mut rig = rig();
                rig.plant.place(axis, from);
                rig.step(dt_ms);
                rig.move_to(axis, to as i16);
                let mut ms = 0;
                while rig.drive_flags(axis).contains(DriveFlags::MOVE) {
                    rig.step(dt_ms);
                    ms += dt_ms;
                    let beyond =
                        (rig.plant.drive(axis).position_milli - to * 1000) * (to - from).signum();
                    assert!(beyond < 500, "{axis:?} {from} to {to} at {dt_ms} ms: {beyond}");
                    assert!(ms < 60_000, "{axis:?} {from} to {to} at {dt_ms} ms: on and on");
                }
                assert_eq!(rig.plant.position(axis), to, "{axis:?} from {from} at {dt_ms} ms");
                assert_eq!(rig.drive(axis).position, to as i16);
                assert_eq!((rig.speed(axis), rig.drive(axis).speed), (0, 0));
            }
        }
    }
}

/// §3.3 It does not take longer than its speed and acceleration say, and half as long again.
#[test]
fn arrives_in_good_time() {
    for (axis, way, ideal_ms) in
        [(Axis::Vertical, 3600, 5500), (Axis::Horizontal, 9000, 8200), (Axis::Nozzle, 50, 5100)]
    {
        let mut rig = rig();
        rig.move_to(axis, way);
        let ms = rig.run_until(60_000, |rig| rig.drive(axis).position == way);
        assert!((ideal_ms..ideal_ms * 3 / 2).contains(&ms), "{axis:?}: {ms}");
    }
}

/// §3.3 «speed»: the speed commanded now, as the parameter allows; current in 0.1 A; both saturate.
#[test]
fn status_tells_speed_and_current() {
    let mut rig = rig();
    rig.set(Param::VerticalSpeed, 7);
    rig.plant.drive(Axis::Vertical).current_da = 33;
    rig.move_to(Axis::Vertical, 4500);
    rig.run(2000);
    assert_eq!((rig.drive(Axis::Vertical).speed, rig.drive(Axis::Vertical).current), (7, 33));
    rig.all_accept(Body::Stop);
    rig.step(10);
    rig.plant.place(Axis::Vertical, 40_000);
    rig.step(10);
    assert_eq!(rig.drive(Axis::Vertical).position, 32_767);
    rig.plant.place(Axis::Vertical, -40_000);
    rig.step(10);
    assert_eq!(rig.drive(Axis::Vertical).position, -32_767);
}

/// §3.1/7 Beyond a limit moves to the limit; there nothing moves and only the limit flag is set.
#[test]
fn beyond_a_limit_is_the_limit() {
    for (destination, limit, flag) in [
        (21_600, 4500, DriveFlags::MAX_LIMIT_REACHED),
        (-21_600, -900, DriveFlags::MIN_LIMIT_REACHED),
        (i16::MIN, -900, DriveFlags::MIN_LIMIT_REACHED),
    ] {
        let mut rig = rig();
        rig.move_to(Axis::Vertical, destination);
        rig.run(300);
        assert_eq!(rig.drive_flags(Axis::Vertical), DriveFlags::MOVE);
        rig.run_until(30_000, |rig| rig.drive_flags(Axis::Vertical) == flag);
        assert_eq!(rig.drive(Axis::Vertical).position, limit);
        rig.move_to(Axis::Vertical, destination);
        assert_eq!(rig.drive_flags(Axis::Vertical), flag);
        rig.run_while(500, |rig| rig.is_still());
        assert_eq!(rig.drive_flags(Axis::Vertical), flag);
    }
}

/// §3.5/1 New limits act at once: what was on its way out stops, what is outside stays, and it
/// only comes back in.
#[test]
fn new_limits_act_at_once() {
    let mut rig = rig();
    rig.move_to(Axis::Vertical, 3000);
    rig.run(2000);
    assert_eq!(rig.set(Param::VerticalMaxLimit, 600), Status::ACCEPTED);
    rig.run(20);
    assert!(rig.is_still());
    let at = rig.drive(Axis::Vertical).position;
    assert!(at > 700, "{at}");
    rig.run_while(500, |rig| rig.is_still());
    rig.move_to(Axis::Vertical, 2000);
    rig.run_while(1000, |rig| rig.speed(Axis::Vertical) <= 0);
    assert!(rig.drive(Axis::Vertical).position < at);
    rig.run_until(10_000, |rig| rig.drive(Axis::Vertical).position == 600);
}

/// §3.3.4/2 End switches stop a drive wherever its limits are.
#[test]
fn end_switches_stop() {
    let mut rig = rig();
    rig.plant.drive(Axis::Horizontal).switches = (-300, 300);
    rig.move_to(Axis::Horizontal, 900);
    rig.run(5000);
    assert!(rig.is_still());
    let flags = rig.drive_flags(Axis::Horizontal);
    assert_eq!(flags, DriveFlags::ABSOLUTE_MAX_LIMIT_REACHED);
    assert!((300..330).contains(&rig.plant.position(Axis::Horizontal)));
    rig.move_to(Axis::Horizontal, 900);
    rig.run_while(100, |rig| rig.is_still());
    rig.move_to(Axis::Horizontal, -900);
    rig.run(5000);
    let flags = rig.drive_flags(Axis::Horizontal);
    assert_eq!(flags, DriveFlags::ABSOLUTE_MIN_LIMIT_REACHED);
}

/// §3.1 Two Moves: the later one replaces the earlier, without a stop where the direction is the same;
/// the turn is a ramp through zero.
#[test]
fn the_later_move_replaces_the_earlier() {
    let mut rig = rig();
    rig.move_to(Axis::Horizontal, 3000);
    rig.run(1500);
    let before = rig.speed(Axis::Horizontal);
    rig.move_to(Axis::Horizontal, 6000);
    rig.run_while(100, |rig| rig.speed(Axis::Horizontal) >= before);
    rig.move_to(Axis::Horizontal, -3000);
    let mut last = before;
    rig.run(10);
    while rig.speed(Axis::Horizontal) > -150 {
        assert!((rig.speed(Axis::Horizontal) - last).abs() <= 60, "jerk");
        last = rig.speed(Axis::Horizontal);
        rig.step(10);
    }
    rig.run_until(30_000, |rig| rig.drive(Axis::Horizontal).position == -3000);
}

/// §3.2/5 Stop stops that drive at once and no other.
#[test]
fn stop_stops_one() {
    let mut rig = rig();
    rig.move_to(Axis::Vertical, 3000);
    rig.move_to(Axis::Horizontal, 3000);
    rig.run(1000);
    assert_eq!(rig.status(SubsystemId::VERTICAL, Body::Stop), Status::OK);
    rig.step(10);
    assert_eq!(rig.speed(Axis::Vertical), 0);
    assert!(rig.speed(Axis::Horizontal) > 0);
    rig.step(10);
    assert!(!rig.drive_flags(Axis::Vertical).contains(DriveFlags::MOVE));
    // Control and Detector have nothing to stop here: what an operator moves is not theirs.
    rig.accepts(SubsystemId::CONTROL, Body::Stop);
    rig.run(100);
    assert!(rig.speed(Axis::Horizontal) > 0);
}

/// §3.17/1, §3.1/8 Limits off, a direct drive runs until it is stopped, its coordinate not counted
/// meanwhile.
#[test]
fn limitless_runs_until_stopped() {
    let mut rig = rig();
    rig.move_to(Axis::Vertical, 60);
    rig.run(3000);
    rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 0 });
    assert_eq!(rig.drive_flags(Axis::Vertical), DriveFlags::LIMITLESS);
    rig.move_to(Axis::Vertical, 61);
    rig.run_while(10_000, |rig| {
        rig.speed(Axis::Vertical) > 0 && rig.drive(Axis::Vertical).position == 60
    });
    assert!(rig.plant.position(Axis::Vertical) > 4500);
    rig.accepts(SubsystemId::VERTICAL, Body::Stop);
    rig.run(50);
    let true_position = rig.plant.position(Axis::Vertical);
    assert_eq!(i64::from(rig.drive(Axis::Vertical).position), true_position);
    rig.move_to(Axis::Vertical, -21_600);
    rig.run(1000);
    assert!(rig.speed(Axis::Vertical) < 0);
    // On while it runs: it stops, and from outside it only comes back in.
    rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 1 });
    rig.run(50);
    assert!(rig.is_still());
    assert!(rig.plant.position(Axis::Vertical) > 4500);
    rig.move_to(Axis::Vertical, 21_600);
    rig.run_until(20_000, |rig| rig.drive(Axis::Vertical).position == 4500);
    assert_eq!(rig.drive_flags(Axis::Vertical) - DriveFlags::MOVE, DriveFlags::MAX_LIMIT_REACHED);
}

/// §3.17/1, §3.1/8 Limits off, a Move to where the drive says it is has no direction: it stays, and stops what
/// runs.
#[test]
fn limitless_stays_where_it_is() {
    for kind in [DriveKind::Encoder, DriveKind::Remote] {
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            let mut rig = with_kind(kind);
            rig.plant.place(axis, 30);
            rig.pause();
            rig.run(100);
            rig.accepts(axis.id(), Body::SwitchLimits { new_state: 0 });
            rig.move_to(axis, 30);
            rig.run_while(300, |rig| rig.is_still());
            if kind == DriveKind::Remote {
                continue;
            }
            rig.move_to(axis, 31);
            rig.run(500);
            assert!(rig.speed(axis) > 0);
            // While it runs it is not counted.
            let said = rig.drive(axis).position;
            rig.move_to(axis, said);
            rig.run_while(300, |rig| rig.is_still());
            let said = rig.drive(axis).position;
            assert_eq!(i64::from(said), rig.plant.position(axis));
            rig.move_to(axis, said);
            rig.run_while(300, |rig| rig.is_still());
        }
    }
}

/// §3.17/2, §3.17/3, §3.17/5 Limits taken while limits are off come into force with On, are dropped by
/// Reject; only the present position is taken, and only at rest.
#[test]
fn teaching_limits() {
    for (new_state, min, max) in [(1, -300, 900), (2, -900, 4500)] {
        let mut rig = rig();
        rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 0 });
        for (param, at) in [(Param::VerticalMaxLimit, 900), (Param::VerticalMinLimit, -300)] {
            rig.move_to(Axis::Vertical, if at > 0 { 21_600 } else { -21_600 });
            rig.run_until(20_000, |rig| (rig.plant.position(Axis::Vertical) - at).abs() < 4);
            let shown = rig.drive(Axis::Vertical).position;
            assert_eq!(rig.set(param, shown.into()), Status::BUSY);
            rig.accepts(SubsystemId::VERTICAL, Body::Stop);
            rig.run(20);
            rig.plant.place(Axis::Vertical, at);
            rig.run(20);
            assert_eq!(rig.set(param, at as i32 + 1), Status::INVALID_VALUE);
            assert_eq!(rig.set(param, at as i32), Status::ACCEPTED);
            assert_eq!(rig.get(param), Ok(vec![at as i32]));
        }
        let limits = rig.limits(Axis::Vertical);
        assert_eq!((limits.min, limits.max), (-900, 4500), "not in force yet");
        rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state });
        rig.run(100);
        rig.power_cycle_and_settle();
        let limits = rig.limits(Axis::Vertical);
        assert_eq!((limits.min, limits.max), (min, max));
        rig.move_to(Axis::Vertical, 1200);
        rig.run(10_000);
        assert_eq!(i32::from(rig.drive(Axis::Vertical).position), max.min(1200));
    }
}

/// §3.17/2 Limits that contradict each other do not come into force.
#[test]
fn contradicting_limits_are_not_taken() {
    let mut rig = rig();
    rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 0 });
    rig.plant.place(Axis::Vertical, 300);
    rig.run(20);
    assert_eq!(rig.set(Param::VerticalMaxLimit, 300), Status::ACCEPTED);
    assert_eq!(rig.set(Param::VerticalMinLimit, 300), Status::ACCEPTED);
    let status = rig.status(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 1 });
    assert_eq!(status, Status::INVALID_VALUE);
    assert!(rig.drive_flags(Axis::Vertical).contains(DriveFlags::LIMITLESS));
    rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 2 });
    assert_eq!(rig.limits(Axis::Vertical).max, 4500);
}

/// §3.17/5, §3.17/3 The present position becomes zero; the limits keep their numbers; Reject leaves it.
#[test]
fn teaching_the_zero_point() {
    let mut rig = rig();
    rig.move_to(Axis::Vertical, 1200);
    rig.run(10_000);
    rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 0 });
    assert_eq!(rig.set(Param::VerticalZeroPoint, 1199), Status::INVALID_VALUE);
    assert_eq!(rig.set(Param::VerticalZeroPoint, 1200), Status::ACCEPTED);
    assert_eq!(rig.drive(Axis::Vertical).position, 0);
    assert_eq!(rig.get(Param::VerticalZeroPoint), Ok(vec![1200]));
    // Repeated on the way, it is the same; from elsewhere, or with another value, it is not.
    assert!(rig.set(Param::VerticalZeroPoint, 1200).is_success());
    assert_eq!(rig.drive(Axis::Vertical).position, 0);
    assert_eq!(rig.get(Param::VerticalZeroPoint), Ok(vec![1200]));
    assert_eq!(rig.set(Param::VerticalZeroPoint, 1201), Status::INVALID_VALUE);
    rig.plant.place(Axis::Vertical, 1300);
    rig.run(20);
    assert_eq!(rig.drive(Axis::Vertical).position, 100);
    assert_eq!(rig.set(Param::VerticalZeroPoint, 1200), Status::INVALID_VALUE);
    rig.plant.place(Axis::Vertical, 1200);
    rig.run(20);
    assert_eq!(rig.drive(Axis::Vertical).position, 0);
    rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 2 });
    rig.run(100);
    rig.power_cycle_and_settle();
    assert_eq!(rig.drive(Axis::Vertical).position, 0);
    rig.move_to(Axis::Vertical, 21_600);
    rig.run(20_000);
    // The guard counts in the encoder's own coordinates.
    assert_eq!(rig.plant.position(Axis::Vertical), 5700);
    assert_eq!(rig.drive(Axis::Vertical).position, 4500);
}

/// §3.17/5, §D/5 A zero point above the sensor's own: the guard lets the drive to its lower limit too.
#[test]
fn limits_move_with_the_zero_point() {
    for (zero, destination, limit) in [(-1200, -21_600, -900), (1200, 21_600, 4500)] {
        let mut rig = rig();
        assert_eq!(rig.set(Param::VerticalZeroPoint, zero), Status::ACCEPTED);
        rig.run(20);
        assert_eq!(i32::from(rig.drive(Axis::Vertical).position), -zero);
        rig.move_to(Axis::Vertical, destination);
        rig.run_until(30_000, |rig| rig.drive(Axis::Vertical).position == limit);
        assert_eq!(rig.plant.position(Axis::Vertical), i64::from(zero) + i64::from(limit));
    }
}

/// §3.17/3 What was rejected does not come back with the next On.
#[test]
fn rejected_is_forgotten() {
    let mut rig = rig();
    rig.plant.place(Axis::Vertical, 300);
    rig.run(20);
    rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 0 });
    assert_eq!(rig.set(Param::VerticalMaxLimit, 300), Status::ACCEPTED);
    for new_state in [2, 0, 1] {
        rig.accepts(SubsystemId::VERTICAL, Body::SwitchLimits { new_state });
        assert_eq!(rig.get(Param::VerticalMaxLimit), Ok(vec![4500]));
    }
    assert_eq!(rig.limits(Axis::Vertical).max, 4500);
}

/// §3.1/4 A drive that rolls a count beyond its target has arrived: it does not turn back and hunt.
#[test]
fn rolling_on_is_arriving() {
    for (target, beyond) in [(600, 602), (-600, -601)] {
        let mut rig = rig();
        rig.move_to(Axis::Vertical, target);
        rig.run_until(10_000, |rig| {
            (rig.plant.position(Axis::Vertical) - i64::from(target)).abs() < 5
        });
        rig.plant.drive(Axis::Vertical).position_milli = beyond * 1000;
        rig.run(20);
        rig.run_while(300, |rig| rig.is_still());
        assert!(!rig.drive_flags(Axis::Vertical).contains(DriveFlags::MOVE));
    }
}

/// §3.17/5 A zero point that the parameter could not tell is not taken.
#[test]
fn a_zero_point_too_far_away() {
    let mut rig = rig();
    assert_eq!(rig.set(Param::HorizontalZeroPoint, 30_000), Status::ACCEPTED);
    rig.accepts(SubsystemId::HORIZONTAL, Body::SwitchLimits { new_state: 0 });
    rig.plant.place(Axis::Horizontal, 35_000);
    rig.run(20);
    assert_eq!(rig.drive(Axis::Horizontal).position, 5000);
    assert_eq!(rig.set(Param::HorizontalZeroPoint, 5000), Status::INVALID_VALUE);
    rig.run(100);
    rig.power_cycle_and_settle();
    assert_eq!(rig.get(Param::HorizontalZeroPoint), Ok(vec![30_000]));
}

/// §3.17/4 With limit switches the limits cannot be switched.
#[test]
fn limit_switches_know_no_limitless() {
    let mut rig = with_kind(DriveKind::LimitSwitches);
    for new_state in 0..3 {
        let status = rig.status(SubsystemId::VERTICAL, Body::SwitchLimits { new_state });
        assert_eq!(status, Status::NOT_SUPPORTED);
    }
    assert_eq!(rig.drive_flags(Axis::Vertical), DriveFlags::empty());
    let wrong = rig.status(SubsystemId::VERTICAL, Body::SwitchLimits { new_state: 3 });
    assert_eq!(wrong, Status::INVALID_VALUE);
}

/// §3.3.4/1 Overload: the drive stops; the flag clears 3 s after the stop; that direction is refused
/// meanwhile, the other is free. Also while the clock wraps (§D/3).
#[test]
fn overload() {
    for now_ms in [0, u32::MAX - 500, u32::MAX - 1500] {
        let mut rig = Rig::at(Composition::REMOTE, now_ms);
        rig.plant.drive(Axis::Vertical).current_da = 81;
        rig.move_to(Axis::Vertical, 3000);
        let overload = DriveFlags::AMPERAGE_OVERLOAD;
        let ms = rig.run_until(1000, |rig| rig.drive_flags(Axis::Vertical).contains(overload));
        assert!((200..300).contains(&ms), "{ms}");
        assert!(rig.is_still());
        let stopped_ms = rig.now_ms;
        rig.plant.drive(Axis::Vertical).current_da = 20;
        rig.run(1000);
        let again = rig.status(SubsystemId::VERTICAL, Body::Move { destination: 3000 });
        assert_eq!(again, Status::MODULE_FAULT);
        rig.run_while(100, |rig| rig.is_still());
        rig.move_to(Axis::Vertical, -600);
        rig.run_until(1000, |rig| rig.speed(Axis::Vertical) < 0);
        rig.run_until(5000, |rig| {
            !rig.drive_flags(Axis::Vertical).contains(DriveFlags::AMPERAGE_OVERLOAD)
        });
        assert_eq!(rig.now_ms.wrapping_sub(stopped_ms), 3000);
        rig.move_to(Axis::Vertical, 600);
        rig.run_until(10_000, |rig| rig.drive(Axis::Vertical).position == 600);
    }
}

/// §3.3.4/1 The direction that is refused is that of the overload, down as well as up.
#[test]
fn overload_downwards() {
    let mut rig = rig();
    rig.plant.place(Axis::Vertical, 3000);
    rig.plant.drive(Axis::Vertical).current_da = 81;
    rig.run(20);
    rig.move_to(Axis::Vertical, 0);
    let overload = DriveFlags::AMPERAGE_OVERLOAD;
    rig.run_until(1000, |rig| rig.drive_flags(Axis::Vertical).contains(overload));
    rig.plant.drive(Axis::Vertical).current_da = 20;
    let again = rig.status(SubsystemId::VERTICAL, Body::Move { destination: 0 });
    assert_eq!(again, Status::MODULE_FAULT);
    rig.move_to(Axis::Vertical, 4000);
    rig.run(100);
    assert!(rig.speed(Axis::Vertical) > 0);
}

/// §3.3.4/1 A current so high that the guard takes the output away: the drive is at rest then, and the
/// direction that is refused is the one it was to go.
#[test]
fn overload_cut_off() {
    for (to, back) in [(3000, -600), (-600, 3000)] {
        let mut rig = Rig::new(Composition::REMOTE);
        rig.move_to(Axis::Vertical, to);
        rig.run(50);
        rig.plant.drive(Axis::Vertical).current_da = 170;
        let overload = DriveFlags::AMPERAGE_OVERLOAD;
        rig.run_until(1000, |rig| rig.drive_flags(Axis::Vertical).contains(overload));
        rig.plant.drive(Axis::Vertical).current_da = 20;
        let again = rig.status(SubsystemId::VERTICAL, Body::Move { destination: to });
        assert_eq!(again, Status::MODULE_FAULT, "{to}");
        rig.move_to(Axis::Vertical, back);
        rig.run_until(1000, |rig| rig.speed(Axis::Vertical).signum() == back.signum());
    }
}

/// §3.3.4/1 What a drive draws at its limit value, or for a moment, is no overload.
#[test]
fn no_overload() {
    let mut rig = rig();
    rig.set(Param::VerticalSlowCurrent, 0);
    rig.plant.drive(Axis::Vertical).current_da = 80;
    rig.move_to(Axis::Vertical, 3000);
    rig.run(1000);
    rig.plant.drive(Axis::Vertical).current_da = 150;
    rig.run(150);
    rig.plant.drive(Axis::Vertical).current_da = 80;
    rig.run(1000);
    assert_eq!(rig.drive_flags(Axis::Vertical), DriveFlags::MOVE);
    assert!(rig.speed(Axis::Vertical) > 0);
}

/// §3.3.4 SpeedSlowAmp: above SlowCurrent the drive runs at half speed until the current has fallen.
#[test]
fn slows_with_the_load() {
    let mut rig = rig();
    rig.move_to(Axis::Horizontal, 10_800);
    rig.run(2000);
    assert_eq!(rig.speed(Axis::Horizontal), 200);
    rig.plant.drive(Axis::Horizontal).current_da = 61;
    rig.run(500);
    let slow = DriveFlags::MOVE | DriveFlags::SPEED_SLOW_AMP;
    assert_eq!((rig.speed(Axis::Horizontal), rig.drive_flags(Axis::Horizontal)), (100, slow));
    rig.plant.drive(Axis::Horizontal).current_da = 55;
    rig.run(500);
    assert_eq!(rig.drive_flags(Axis::Horizontal), slow, "hysteresis");
    rig.plant.drive(Axis::Horizontal).current_da = 50;
    rig.run(1000);
    let normal = (rig.speed(Axis::Horizontal), rig.drive_flags(Axis::Horizontal));
    assert_eq!(normal, (200, DriveFlags::MOVE));
    rig.plant.drive(Axis::Horizontal).current_da = 61;
    rig.run(100);
    rig.accepts(SubsystemId::HORIZONTAL, Body::Stop);
    rig.run(20);
    assert_eq!(rig.drive_flags(Axis::Horizontal), DriveFlags::empty());
}

/// §D/4 MoveTimeout: a Move that is not repeated ends; 0 is off. Also while the clock wraps (§D/3).
#[test]
fn move_timeout() {
    for now_ms in [0, u32::MAX - 300] {
        let mut rig = Rig::at(Composition::REMOTE, now_ms);
        rig.set(Param::GeneralMoveTimeout, 500);
        rig.move_to(Axis::Horizontal, 10_000);
        for _ in 0..10 {
            rig.run(400);
            rig.move_to(Axis::Horizontal, 10_000);
        }
        rig.run(490);
        assert!(rig.speed(Axis::Horizontal) > 0);
        rig.run(20);
        assert!(rig.is_still());
        assert_eq!(rig.drive_flags(Axis::Horizontal), DriveFlags::empty());
        rig.set(Param::GeneralMoveTimeout, 0);
        rig.move_to(Axis::Horizontal, -10_000);
        rig.run_while(3000, |rig| !rig.is_still() || rig.now_ms == 0);
    }
}

/// A fault of the plant that only shows by watching, and the flag it leads to.
type Watched = (DriveFlags, fn(&mut Plant));

const WATCHED: [Watched; 5] = [
    (DriveFlags::POSITION_WAY_FAULT, |plant| {
        plant.drive(Axis::Horizontal).encoder_reversed = true;
    }),
    (DriveFlags::POS_ENCODER_FAULT, |plant| plant.drive(Axis::Horizontal).encoder_stuck = Some(0)),
    (DriveFlags::SPEED_WAY_FAULT, |plant| plant.drive(Axis::Horizontal).speed_reversed = true),
    (DriveFlags::SPEED_ENCODER_FAULT, |plant| plant.drive(Axis::Horizontal).speed_dead = true),
    (DriveFlags::INTERNAL_FAULT, |plant| plant.drive(Axis::Horizontal).jammed = true),
];

/// §3.3.4, §3.1/4, §3.2/5 Sensors connected the wrong way round or dead, a drive that does not turn:
/// found out within a second of motion, up and down; it stops and answers ModuleFault.
#[test]
fn faults_that_show_by_watching() {
    for (flag, break_it) in WATCHED {
        for destination in [9000, -9000] {
            let mut rig = rig();
            break_it(&mut rig.plant);
            rig.move_to(Axis::Horizontal, destination);
            let ms = rig.run_until(3000, |rig| rig.drive_flags(Axis::Horizontal).contains(flag));
            assert!((500..700).contains(&ms), "{flag:?} after {ms} ms");
            rig.run(10);
            assert_eq!(rig.drive_flags(Axis::Horizontal), flag);
            rig.run_while(1000, |rig| rig.is_still());
            let again = rig.status(SubsystemId::HORIZONTAL, Body::Move { destination });
            assert_eq!(again, Status::MODULE_FAULT);
            assert_eq!(rig.status(SubsystemId::HORIZONTAL, Body::Stop), Status::MODULE_FAULT);
            rig.run_while(100, |rig| rig.is_still());
            rig.move_to(Axis::Vertical, 600);
        }
    }
}

/// §3.3.4, §3.1/4 What sensors and power stage say themselves shows when it has lasted, and clears with it.
#[test]
fn faults_that_are_sensed() {
    type Sensed = fn(&mut lafet_device::image::DriveInput) -> &mut bool;
    let faults: [(DriveFlags, Sensed); 3] = [
        (DriveFlags::MOTOR_BROKEN, |input| &mut input.motor_open),
        (DriveFlags::POS_ENCODER_FAULT, |input| &mut input.position_sensor_fault),
        (DriveFlags::SPEED_ENCODER_FAULT, |input| &mut input.speed_sensor_fault),
    ];
    for (flag, fault) in faults {
        let mut rig = rig();
        rig.move_to(Axis::Nozzle, 50);
        rig.run(300);
        *fault(&mut rig.plant.inputs.drives[Axis::Nozzle as usize]) = true;
        rig.run(50);
        assert!(rig.is_still());
        rig.run(10);
        assert_eq!(rig.drive_flags(Axis::Nozzle), flag);
        let status = rig.status(SubsystemId::NOZZLE, Body::Move { destination: 50 });
        assert_eq!(status, Status::MODULE_FAULT);
        *fault(&mut rig.plant.inputs.drives[Axis::Nozzle as usize]) = false;
        rig.run(20);
        rig.move_to(Axis::Nozzle, 50);
        rig.run_until(10_000, |rig| rig.drive(Axis::Nozzle).position == 50);
    }
}

/// §3.3.4 A sound drive is never found faulty, however it is moved about.
#[test]
fn no_false_faults() {
    let mut rig = rig();
    let mut noise = 12_345_u32;
    for _ in 0..3000 {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let axis = [Axis::Vertical, Axis::Horizontal, Axis::Nozzle][noise as usize >> 8 & 1];
        match noise >> 16 & 7 {
            0 => rig.accepts(axis.id(), Body::Stop),
            _ => rig.move_to(axis, (noise >> 17) as i16 / 4),
        }
        rig.run((noise >> 20) % 40 * 50);
        for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
            let usual =
                DriveFlags::MOVE | DriveFlags::MIN_LIMIT_REACHED | DriveFlags::MAX_LIMIT_REACHED;
            assert_eq!(rig.drive_flags(axis) - usual, DriveFlags::empty());
        }
    }
}

/// §3.3.4 TRVEngage: at and below TrvPosition, of the nozzle only; −1 is a nozzle that has none.
#[test]
fn trv() {
    let mut rig = Rig::new(Composition::MINI);
    rig.plant.place(Axis::Nozzle, 6);
    rig.run(20);
    assert_eq!(rig.drive_flags(Axis::Nozzle), DriveFlags::empty());
    rig.plant.place(Axis::Nozzle, 5);
    rig.run(20);
    assert_eq!(rig.drive_flags(Axis::Nozzle), DriveFlags::TRV_ENGAGE);
    assert_eq!(rig.drive_flags(Axis::Vertical), DriveFlags::empty());
    rig.set(Param::NozzleTrvPosition, -1);
    rig.plant.place(Axis::Nozzle, -1);
    rig.run(20);
    assert_eq!(rig.drive_flags(Axis::Nozzle), DriveFlags::MIN_LIMIT_REACHED);
}

/// §D/3 A clock that stops, leaps or goes back does no harm: no panic, and afterwards it works.
#[test]
fn any_clock() {
    for leap in [0, 1, 999, 1 << 31, u32::MAX - 1, u32::MAX] {
        let mut rig = rig();
        rig.move_to(Axis::Vertical, 3000);
        rig.run(500);
        rig.now_ms = rig.now_ms.wrapping_add(leap);
        let mut plant = rig.plant.clone();
        rig.device.step(rig.now_ms, &mut plant);
        rig.device.step(rig.now_ms, &mut plant);
        rig.plant = plant;
        rig.run(20);
        rig.all_accept(Body::Stop);
        rig.run(100);
        assert!(rig.is_still(), "{leap}");
        rig.move_to(Axis::Vertical, 0);
        rig.run_until(10_000, |rig| rig.drive(Axis::Vertical).position == 0);
    }
}

/// §D/1 The drives start where they stand, and without a goal.
#[test]
fn power_up_moves_nothing() {
    let mut plant = Plant::of(&Composition::REMOTE);
    Device::provision(&mut plant, &Composition::REMOTE, 1).unwrap();
    plant.place(Axis::Vertical, 777);
    let mut rig = Rig::power_up(Composition::REMOTE, plant, 5);
    assert_eq!(rig.drive(Axis::Vertical).position, 777);
    rig.run_while(1000, |rig| rig.is_still());
    assert_eq!(rig.drive_flags(Axis::Vertical), DriveFlags::empty());
    // Before it has settled a Move is accepted and waits.
    let mut rig = Rig::power_up(Composition::REMOTE, rig.plant, 5);
    rig.move_to(Axis::Vertical, 0);
    rig.run_while(90, |rig| rig.is_still());
    rig.run_until(10_000, |rig| rig.drive(Axis::Vertical).position == 0);
}
