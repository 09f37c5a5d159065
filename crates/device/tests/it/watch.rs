//! §3.3.4 What a drive is judged by: every bound of the watch on its motion.

use crate::common::Rig;
use lafet_device::Composition;
use lafet_device::image::{Axis, DriveInput};
use lafet_proto::Status;
use lafet_proto::flags::DriveFlags;
use lafet_proto::param::Param;
use lafet_proto::request::Body;

const AXIS: Axis = Axis::Horizontal;
/// The first verdict on a motion comes now: a step in which the speed is taken up, 0.25 s in which
/// the motor starts, and 0.4 s that are judged.
const FIRST_MS: u32 = 10 + 250 + 400;
/// And so long after it the next.
const NEXT_MS: u32 = 400;
/// Speed of these motions, 0.1 °/s: 60' in a stretch that is judged are a quarter of its way.
const SPEED: i32 = 100;
const FAULTS: DriveFlags = DriveFlags::POSITION_WAY_FAULT
    .union(DriveFlags::POS_ENCODER_FAULT)
    .union(DriveFlags::SPEED_WAY_FAULT)
    .union(DriveFlags::SPEED_ENCODER_FAULT)
    .union(DriveFlags::INTERNAL_FAULT);

/// A drive whose sensors say what a test wants them to.
struct Sensors {
    rig: Rig,
    axis: Axis,
    /// Since the motion began.
    ms: u32,
}

impl Sensors {
    /// Sent far away, up/left (1) or down/right (−1).
    fn new(axis: Axis, speed: Param, speed_units: i32, acceleration: Param, way: i16) -> Self {
        let mut rig = Rig::new(Composition::REMOTE);
        rig.set(speed, speed_units);
        rig.set(acceleration, 1000);
        rig.plant.place(axis, 30);
        rig.run(20);
        rig.move_to(axis, 21_600 * way);
        Self { rig, axis, ms: 0 }
    }

    fn horizontal(way: i16) -> Self {
        let (speed, acceleration) = (Param::HorizontalSpeed, Param::HorizontalAcceleration);
        Self::new(AXIS, speed, SPEED / 10, acceleration, way)
    }

    /// One step in which the sensors say this.
    fn step(&mut self, dt_ms: u32, sensed: impl Fn(&mut DriveInput)) {
        self.ms += dt_ms;
        self.rig.now_ms += dt_ms;
        self.rig.plant.advance(dt_ms);
        sensed(&mut self.rig.plant.inputs.drives[self.axis as usize]);
        self.rig.device.step(self.rig.now_ms, &mut self.rig.plant);
    }

    fn faults(&mut self) -> DriveFlags {
        self.rig.drive_flags(self.axis) & FAULTS
    }

    /// Steps until a verdict: which, and when.
    fn verdict(
        &mut self,
        dt_ms: u32,
        within_ms: u32,
        sensed: impl Fn(u32, &mut DriveInput),
    ) -> Option<(DriveFlags, u32)> {
        while self.ms < within_ms {
            let ms = self.ms + dt_ms;
            self.step(dt_ms, |input| sensed(ms, input));
            let faults = self.faults();
            if !faults.is_empty() {
                return Some((faults, self.ms));
            }
        }
        None
    }
}

/// A drive at rest although it is fed.
fn stands(_: u32, input: &mut DriveInput) {
    (input.position, input.speed_tenths) = (30, 0);
}

/// §3.3.4 The motor has 0.25 s to start, then 0.4 s are judged, whatever the step.
#[test]
fn a_verdict_takes_its_time() {
    for way in [1, -1] {
        let mut drive = Sensors::horizontal(way);
        let verdict = drive.verdict(10, 5000, stands);
        assert_eq!(verdict, Some((DriveFlags::INTERNAL_FAULT, FIRST_MS)));
    }
    // A step that is too long says nothing; the longest that does is a quarter of a second.
    let mut drive = Sensors::horizontal(1);
    assert_eq!(drive.verdict(251, 10_000, stands), None);
    let mut drive = Sensors::horizontal(1);
    assert_eq!(drive.verdict(250, 10_000, stands), Some((DriveFlags::INTERNAL_FAULT, 1000)));
}

/// §3.3.4 Slow motion takes longer until its way says something, and what does not turn is fed more.
#[test]
fn slow_motion() {
    // 1 mm/s: 4 mm take 4 s, and half of that because it is fed more while it does not turn.
    let (speed, acceleration) = (Param::NozzleSpeed, Param::NozzleAcceleration);
    let mut drive = Sensors::new(Axis::Nozzle, speed, 1, acceleration, 1);
    let verdict = drive.verdict(10, 10_000, stands);
    assert_eq!(verdict, Some((DriveFlags::INTERNAL_FAULT, 2180)));
    // The last minutes are approached ever more slowly, but not by a drive that does not turn.
    for away in [8, 7, 3, 1] {
        let mut drive = Sensors::horizontal(1);
        drive.rig.move_to(AXIS, 30 + away);
        assert!(drive.verdict(10, 2_000, stands).is_some(), "{away}' away");
    }
}

/// §3.3.4 A quarter of the commanded way is enough, by the position and by the speed; less the wrong
/// way round, or nothing, says which sensor it is.
#[test]
fn verdicts_at_their_bounds() {
    let good = DriveFlags::empty();
    // Position at the end of the stretch, speed sensed all the while, 0.1 °/s.
    for (moved, speed_tenths, flag) in [
        (60, 25, good),
        (60, 26, good),
        (60, 24, DriveFlags::SPEED_ENCODER_FAULT),
        (60, -25, DriveFlags::SPEED_ENCODER_FAULT),
        (60, -26, DriveFlags::SPEED_WAY_FAULT),
        (240, 100, good),
        (59, 100, DriveFlags::POS_ENCODER_FAULT),
        (0, 26, DriveFlags::POS_ENCODER_FAULT),
        (0, 25, DriveFlags::INTERNAL_FAULT),
        (-60, 26, DriveFlags::POS_ENCODER_FAULT),
        (-60, 25, DriveFlags::INTERNAL_FAULT),
        (-61, 100, DriveFlags::POSITION_WAY_FAULT),
    ] {
        for way in [1_i16, -1] {
            let mut drive = Sensors::horizontal(way);
            let verdict = drive.verdict(10, FIRST_MS, |ms, input| {
                // What it did while the motor started does not count.
                let moved = if ms < FIRST_MS { 0 } else { moved };
                input.position = 30 + moved * i32::from(way);
                input.speed_tenths = speed_tenths * way;
            });
            let expected = (!flag.is_empty()).then_some((flag, FIRST_MS));
            assert_eq!(verdict, expected, "{moved}' at {speed_tenths} towards {way}");
        }
    }
}

/// §3.3.4 A speed sensor that turns round within a stretch sums up to nothing: what it says at the
/// end shows that it is connected the wrong way round.
#[test]
fn a_speed_that_turns_round() {
    for (last, flag) in [(-26, DriveFlags::SPEED_WAY_FAULT), (-25, DriveFlags::SPEED_ENCODER_FAULT)]
    {
        for way in [1_i16, -1] {
            let mut drive = Sensors::horizontal(way);
            let verdict = drive.verdict(10, FIRST_MS, |ms, input| {
                input.speed_tenths = if ms < FIRST_MS { 0 } else { last * way };
            });
            assert_eq!(verdict, Some((flag, FIRST_MS)), "{last} towards {way}");
        }
    }
    // A quarter in sum is enough, whatever the last step says; a little less is not.
    for (last_but_one, flag) in [(27, None), (26, Some(DriveFlags::SPEED_WAY_FAULT))] {
        let mut drive = Sensors::horizontal(1);
        let verdict = drive.verdict(10, FIRST_MS, |ms, input| {
            // 40 steps of 2.5 °/s: none, 37 of 2.7, the last but one, and −2.6.
            input.speed_tenths = match FIRST_MS - ms {
                0 => -26,
                10 => last_but_one,
                20..390 => 27,
                _ => 0,
            };
        });
        assert_eq!(verdict, flag.map(|flag| (flag, FIRST_MS)));
    }
    // A sound one may waver.
    let mut drive = Sensors::horizontal(1);
    let verdict = drive.verdict(10, FIRST_MS, |ms, input| {
        if ms == FIRST_MS {
            input.speed_tenths = -100;
        }
    });
    assert_eq!(verdict, None);
}

/// §3.3.4 Each stretch is judged by itself: what breaks later is reported at the end of the next one, and
/// a weak drive is not summed up to a broken one.
#[test]
fn each_stretch_by_itself() {
    for way in [1_i16, -1] {
        let mut drive = Sensors::horizontal(way);
        assert_eq!(drive.verdict(10, FIRST_MS, |_, _| {}), None);
        let at = drive.rig.plant.inputs.drives[AXIS as usize].position;
        let stuck = drive.verdict(10, 2000, |_, input| input.position = at);
        assert_eq!(stuck, Some((DriveFlags::POS_ENCODER_FAULT, FIRST_MS + NEXT_MS)));

        let mut drive = Sensors::horizontal(way);
        assert_eq!(drive.verdict(10, FIRST_MS, |_, _| {}), None);
        let dead = drive.verdict(10, 2000, |_, input| input.speed_tenths = 0);
        assert_eq!(dead, Some((DriveFlags::SPEED_ENCODER_FAULT, FIRST_MS + NEXT_MS)));

        let mut drive = Sensors::horizontal(way);
        let weak = drive.verdict(10, 5000, |ms, input| {
            // A third of the way: 200' a second.
            input.position = 30 + (ms / 5) as i32 * i32::from(way);
            input.speed_tenths = 33 * way;
        });
        assert_eq!(weak, None);
    }
}

/// §3.3.4 A turn begins a new watch: what was done the other way round does not count.
#[test]
fn a_turn_begins_anew() {
    let mut drive = Sensors::horizontal(1);
    assert_eq!(drive.verdict(10, 500, |_, _| {}), None);
    drive.rig.move_to(AXIS, -9000);
    let at = drive.rig.plant.inputs.drives[AXIS as usize].position;
    drive.ms = 0;
    let stuck = drive.verdict(10, 2000, |_, input| input.position = at);
    // A step more: it turns through standstill.
    assert_eq!(stuck, Some((DriveFlags::POS_ENCODER_FAULT, FIRST_MS + 10)));
    // So does a new Move after a stop.
    let mut drive = Sensors::horizontal(1);
    assert_eq!(drive.verdict(10, 500, stands), None);
    drive.rig.accepts(AXIS.id(), lafet_proto::request::Body::Stop);
    drive.rig.move_to(AXIS, 9000);
    drive.ms = 0;
    assert_eq!(drive.verdict(10, 2000, stands), Some((DriveFlags::INTERNAL_FAULT, FIRST_MS)));
}

/// §3.3.4 A switch behind the drive, stuck or not left yet, does not hide what it does.
#[test]
fn a_switch_behind_hides_nothing() {
    for (way, min, max) in [(1, true, false), (-1, false, true)] {
        let mut drive = Sensors::horizontal(way);
        let verdict = drive.verdict(10, 5000, |ms, input| {
            stands(ms, input);
            (input.min_switch, input.max_switch) = (min, max);
        });
        assert_eq!(verdict, Some((DriveFlags::INTERNAL_FAULT, FIRST_MS)));
        let mut drive = Sensors::horizontal(way);
        let verdict = drive.verdict(10, 5000, |_, input| {
            (input.min_switch, input.max_switch) = (min, max);
        });
        assert_eq!(verdict, None);
    }
}

/// §D/6 Both ends cannot be closed: a fault as long as they are.
#[test]
fn both_ends() {
    for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
        let mut rig = Rig::new(Composition::REMOTE);
        let switches = rig.plant.drive(axis).switches;
        rig.plant.drive(axis).switches = (100, -100);
        rig.run(50);
        assert!(rig.drive_flags(axis).contains(DriveFlags::INTERNAL_FAULT));
        let status = rig.status(axis.id(), Body::Move { destination: 10 });
        assert_eq!(status, Status::MODULE_FAULT);
        rig.plant.drive(axis).switches = switches;
        rig.run(50);
        assert!(!rig.drive_flags(axis).contains(DriveFlags::INTERNAL_FAULT));
        rig.move_to(axis, 10);
    }
}

/// §3.3.4 A position that counts four times is reported at the end of a stretch, by the speed sensor; so is a
/// speed that is four times as much.
#[test]
fn counting_too_much() {
    for way in [1_i16, -1] {
        let mut drive = Sensors::horizontal(way);
        let from = 30;
        let verdict = drive.verdict(10, 2000, |_, input| {
            input.position = from + 4 * (input.position - from);
        });
        assert_eq!(verdict, Some((DriveFlags::POS_ENCODER_FAULT, FIRST_MS)));
        let mut drive = Sensors::horizontal(way);
        let verdict = drive.verdict(10, 2000, |_, input| {
            input.speed_tenths = 4 * input.speed_tenths + 30 * way;
        });
        assert_eq!(verdict, Some((DriveFlags::SPEED_ENCODER_FAULT, FIRST_MS)));
    }
}

/// §3.3.4 A position that jumps by 5° or more while the drive turns is reported at once.
#[test]
fn jumping() {
    for (jump, flag) in [(1200, true), (-1200, true), (330, true), (-370, true), (150, false)] {
        let mut drive = Sensors::horizontal(1);
        assert_eq!(drive.verdict(10, 400, |_, _| {}), None);
        let verdict = drive.verdict(10, 600, |_, input| input.position += jump);
        assert_eq!(verdict, flag.then_some((DriveFlags::POS_ENCODER_FAULT, 410)), "{jump}");
    }
}
