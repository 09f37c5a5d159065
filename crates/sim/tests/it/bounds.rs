//! How far a drive goes before it reports that something is wrong (§3.3.4, §D/6): every fault that
//! an input contradicts shows within a second and within 10° or 50 mm of true way.

use lafet_device::Source;
use lafet_device::image::Axis;
use lafet_proto::answer::Reply;
use lafet_proto::flags::DriveFlags;
use lafet_proto::record::Writer;
use lafet_proto::request::Body;
use lafet_proto::text;
use lafet_sim::fault::{DriveFault, Fault};
use lafet_sim::sim::{Config, Sim};

/// Those that show while a drive moves. What is lived with, and switches, which are no motion, are elsewhere.
const SHOWN: [DriveFault; 14] = [
    DriveFault::MotorOpen,
    DriveFault::Jam,
    DriveFault::PowerStage,
    DriveFault::Runaway,
    DriveFault::Friction,
    DriveFault::Flicker,
    DriveFault::EncoderDead,
    DriveFault::EncoderReversed,
    DriveFault::EncoderFast,
    DriveFault::EncoderJump,
    DriveFault::EncoderFault,
    DriveFault::SpeedDead,
    DriveFault::SpeedReversed,
    DriveFault::SpeedFault,
];
const TOLD: DriveFlags = DriveFlags::INTERNAL_FAULT
    .union(DriveFlags::POS_ENCODER_FAULT)
    .union(DriveFlags::SPEED_ENCODER_FAULT)
    .union(DriveFlags::POSITION_WAY_FAULT)
    .union(DriveFlags::SPEED_WAY_FAULT)
    .union(DriveFlags::MOTOR_BROKEN)
    .union(DriveFlags::AMPERAGE_OVERLOAD);
const TOLD_MS: u64 = 1_000;

fn send(sim: &mut Sim, request: &str) {
    let (mut buffer, mut record) = ([0; text::BUFFER_SIZE], [0; 260]);
    let mut writer = Writer::new(&mut record);
    let request = text::parse(request, &mut buffer).expect("a request");
    request.encode(&mut writer).expect("it fits");
    sim.request(Source::ExternalConn, writer.written());
}

fn is_reported(sim: &mut Sim, axis: Axis) -> bool {
    let mut flags = DriveFlags::empty();
    sim.ask(axis.id(), Body::GetStatus, |answer| {
        if let Reply::Drive(status) = &answer.data {
            flags = status.flags;
        }
    });
    flags.intersects(TOLD)
}

/// Until it is reported: time and way, ms and position units. The fault comes `after_ms` of motion.
fn shows(base: &Sim, axis: Axis, fault: DriveFault, speed: i32, after_ms: u64) -> (u64, f64) {
    let mut sim = base.clone();
    send(&mut sim, &format!("SetParam {axis:?} Speed {speed}"));
    sim.advance_ms(2_000);
    // From the narrow end the nozzle goes wider, the others from the middle up or left.
    let far = if axis == Axis::Nozzle { 0 } else { 4_000 };
    send(&mut sim, &format!("Move {axis:?} {far}"));
    sim.advance_ms(after_ms);
    assert!(!is_reported(&mut sim, axis), "{axis:?} {fault:?}: it is reported before");
    let position = |sim: &Sim| sim.world().drives[axis as usize].position;
    sim.world_mut().inject(Fault::Drive(axis, fault));
    let (from_ms, from) = (sim.now_ms(), position(&sim));
    while !is_reported(&mut sim, axis) {
        assert!(sim.now_ms() - from_ms < 5_000, "{axis:?} {fault:?} at {speed} is not reported");
        sim.tick();
    }
    (sim.now_ms() - from_ms, (position(&sim) - from).abs())
}

#[test]
fn every_fault_in_motion_is_told_in_time_and_near() {
    let mut base = Sim::new(Config::default());
    base.advance_ms(1_000);
    send(&mut base, "Deploy Deployer");
    base.advance_ms(15_000);
    assert!(base.world().deployed());
    for (axis, speeds, most) in [
        (Axis::Vertical, [5, 12, 25], 600.0),
        (Axis::Horizontal, [5, 20, 25], 600.0),
        // A slower nozzle is judged over 4 mm, for which it takes longer.
        (Axis::Nozzle, [7, 9, 15], 50.0),
    ] {
        for (fault, speed) in SHOWN.into_iter().flat_map(|f| speeds.map(|speed| (f, speed))) {
            // A stage that is shorted while it is fed as much contradicts nothing before the next stop.
            if fault == DriveFault::Runaway && speed > speeds[0] && speed != 12 {
                continue;
            }
            for after_ms in [0, 150, 400, 730, 1_050, 1_290] {
                // A reading that changes as the motion starts is latent, and a nozzle, which rests at 60 mm, reads -60.
                let jumps = fault == DriveFault::EncoderJump
                    || fault == DriveFault::EncoderReversed && axis == Axis::Nozzle;
                if jumps && after_ms == 0 {
                    continue;
                }
                let (ms, way) = shows(&base, axis, fault, speed, after_ms);
                let about =
                    format!("{axis:?} {fault:?} at {speed}, {after_ms} ms: {ms} ms, {way:.0}");
                assert!(ms <= TOLD_MS && way <= most, "{about}");
            }
        }
    }
}
