//! The answer buffer: any size of it, and what still happens when it is full.

use crate::common::{self, ROOM, Rig, payload, replies};
use lafet_device::Composition;
use lafet_device::image::{Axis, ValveOutput};
use lafet_proto::flags::GeneralFlags;
use lafet_proto::id::key;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Ints, Request, Status, SubsystemId};

/// A monitor with both hands full: a drive under way, water on.
fn busy() -> Rig {
    let mut rig = Rig::deployed();
    rig.accepts(SubsystemId::VALVE1, Body::Open { key: key::OPEN });
    rig.run(5000);
    rig.move_to(Axis::Horizontal, 9000);
    rig.run(500);
    assert!(rig.speed(Axis::Horizontal) > 0);
    rig
}

/// Answers into a buffer of this size; nothing is written behind it.
fn handle(rig: &mut Rig, payload: &[u8], room: usize) -> Vec<common::Reply> {
    let mut out = [0xEE; ROOM];
    let len = rig.device.handle(rig.now_ms, rig.source, payload, &mut out[..room]);
    assert!(len <= room);
    assert!(out[len..].iter().all(|byte| *byte == 0xEE));
    replies(&out[..len])
}

/// §1/9 GetStatus All: as many whole answers as fit, then NoRoom from whose did not, and from General;
/// 8 bytes are kept for these two.
#[test]
fn get_status_all_into_every_buffer() {
    let mut rig = Rig::deployed();
    let asked = payload(&[Request::new(SubsystemId::ALL, Body::GetStatus)]);
    let whole = handle(&mut rig, &asked, ROOM);
    assert_eq!(whole.len(), 14);
    for room in 0..=200 {
        let answers = handle(&mut rig, &asked, room);
        let mut used = 0;
        let fitting = whole
            .iter()
            .take_while(|answer| {
                used += 4 + answer.data.len();
                used + 8 <= room
            })
            .count();
        assert_eq!(answers[..fitting], whole[..fitting], "{room}");
        let refusals = &answers[fitting..];
        if fitting == whole.len() {
            assert!(refusals.is_empty(), "{room}");
            continue;
        }
        assert!(refusals.iter().all(|no| no.status == Status::NO_ROOM && no.data.is_empty()));
        let from: Vec<_> = refusals.iter().map(|no| no.from).collect();
        let both = [whole[fitting].from, SubsystemId::GENERAL];
        assert_eq!(from, both[..(room / 4).min(2)], "{room}");
    }
}

/// §1/8, §1/9 Several requests: those answered have been executed, the others not; the client repeats
/// from the first NoRoom on.
#[test]
fn several_requests_into_every_buffer() {
    let rig = Rig::deployed();
    let moves = [(Axis::Vertical, 600), (Axis::Horizontal, 900), (Axis::Nozzle, 40)];
    let requests =
        moves.map(|(axis, destination)| Request::new(axis.id(), Body::Move { destination }));
    for room in 0..=64 {
        let mut rig = rig.clone();
        let answers = handle(&mut rig, &payload(&requests), room);
        let accepted: Vec<_> =
            answers.iter().filter(|a| a.status == Status::ACCEPTED).map(|a| a.from).collect();
        let fitting = (room.saturating_sub(8) / 4).min(3);
        assert_eq!(accepted, requests.map(|request| request.to)[..fitting], "{room}");
        if fitting < 3 && room >= 8 {
            let no_room: Vec<_> = answers[fitting..].iter().map(|a| (a.from, a.status)).collect();
            let from = requests[fitting].to;
            assert_eq!(no_room, [(from, Status::NO_ROOM), (SubsystemId::GENERAL, Status::NO_ROOM)]);
        }
        rig.run(100);
        for (number, (axis, _)) in moves.into_iter().enumerate() {
            assert_eq!(rig.speed(axis) != 0, number < fitting, "{axis:?} {room}");
        }
    }
}

/// §1/9 What changes something is not executed when its answer does not fit: it would be repeated.
#[test]
fn no_room_is_not_executed() {
    let requests = [
        Request::open(SubsystemId::VALVE2),
        Request::new(SubsystemId::HORIZONTAL, Body::Move { destination: -9000 }),
        Request::new(SubsystemId::GENERAL, Body::CleanFlash { key: key::CLEAN_FLASH }),
        Request::new(SubsystemId::MOTORS, Body::SwitchLimits { new_state: 0 }),
        Request::close(SubsystemId::VALVE1),
        Request::new(SubsystemId::DEPLOYER, Body::Wrap),
    ];
    for request in requests {
        let mut rig = busy();
        let answers = handle(&mut rig, &payload(&[request]), 11);
        assert!(answers.iter().all(|a| !a.status.is_success()), "{request:?}: {answers:?}");
        rig.run(1000);
        assert!(rig.speed(Axis::Horizontal) > 0, "{request:?}");
        assert_eq!(rig.valve_output(0), ValveOutput::Off, "{request:?}");
        assert_eq!(rig.valve_output(1), ValveOutput::Off, "{request:?}");
        assert_eq!(rig.plant.resets, 0);
        assert!(
            !rig.drive_flags(Axis::Horizontal).contains(lafet_proto::flags::DriveFlags::LIMITLESS)
        );
    }
}

/// §1/9, §3.2/1, §3.18/1, §3.12/1 Stop All, Lockout and Restart take effect whatever room there is.
#[test]
fn a_stop_needs_no_room() {
    for room in 0..=128 {
        let mut rig = busy();
        handle(&mut rig, &payload(&[Request::new(SubsystemId::ALL, Body::Stop)]), room);
        rig.run(50);
        assert!(rig.is_still(), "{room}");
        assert_eq!(rig.valve_output(0), ValveOutput::Off);

        let mut rig = busy();
        handle(&mut rig, &payload(&[Request::lockout(true)]), room);
        rig.run(50);
        assert!(rig.is_still(), "{room}");
        assert_eq!(rig.valve_output(0), ValveOutput::Closing);
        assert!(rig.general().flags.contains(GeneralFlags::LOCKED_OUT));
    }
    let mut rig = busy();
    handle(&mut rig, &payload(&[Request::new(SubsystemId::ALL, Body::Restart)]), 3);
    rig.run(500);
    assert_eq!(rig.plant.resets, 1);
}

/// §1/9 Stop All and Lockout on stop even when they stand behind a NoRoom; nothing else behind it does
/// anything.
#[test]
fn a_stop_behind_no_room_stops() {
    let full = Request::new(SubsystemId::ALL, Body::GetStatus);
    for (stop, valve) in [
        (Request::new(SubsystemId::ALL, Body::Stop), ValveOutput::Off),
        (Request::lockout(true), ValveOutput::Closing),
    ] {
        let mut rig = busy();
        let answers = handle(&mut rig, &payload(&[full, stop]), 64);
        assert_eq!(answers.last().unwrap().status, Status::NO_ROOM);
        rig.run(50);
        assert!(rig.is_still());
        assert_eq!(rig.valve_output(0), valve);
    }
    let others = [
        Request::open(SubsystemId::VALVE2),
        Request::close(SubsystemId::VALVE1),
        Request::new(SubsystemId::HORIZONTAL, Body::Move { destination: -9000 }),
        Request::new(SubsystemId::HORIZONTAL, Body::Stop),
        Request::lockout(false),
    ];
    for other in others {
        let mut rig = busy();
        handle(&mut rig, &payload(&[full, other]), 64);
        rig.run(50);
        assert!(rig.speed(Axis::Horizontal) > 0, "{other:?}");
        assert_eq!(rig.plant.outputs.valves, [ValveOutput::Off; 2], "{other:?}");
    }
}

/// §1/9, §3.18/4 A lockout is not lifted by a request whose answer does not arrive.
#[test]
fn a_release_behind_no_room_does_not_release() {
    let mut rig = Rig::new(Composition::REMOTE);
    rig.all_accept(Body::Lockout { key: key::ENABLE });
    let full = Request::new(SubsystemId::ALL, Body::GetStatus);
    handle(&mut rig, &payload(&[full, Request::lockout(false)]), 64);
    assert!(rig.general().flags.contains(GeneralFlags::LOCKED_OUT));
    handle(&mut rig, &payload(&[Request::lockout(false)]), 64);
    assert!(!rig.general().flags.contains(GeneralFlags::LOCKED_OUT));
}

/// §2/2 A record cut short behind a NoRoom adds nothing; in front of it the records are answered.
#[test]
fn cut_records() {
    let mut rig = Rig::deployed();
    let mut bytes = payload(&[Request::new(SubsystemId::VERTICAL, Body::GetStatus)]);
    bytes.extend([0x4D, 0x0D, 0, 2, 0x10]);
    let answers = handle(&mut rig, &bytes, ROOM);
    let brief: Vec<_> = answers.iter().map(|a| (a.from, a.status)).collect();
    let vertical = SubsystemId::VERTICAL;
    assert_eq!(brief, [(vertical, Status::OK), (vertical, Status::WRONG_DATA)]);
    assert_eq!(handle(&mut rig, &bytes, 12).last().unwrap().status, Status::NO_ROOM);
    rig.run(200);
    assert!(rig.is_still());
    // The addressee is asked only when it is known and there.
    for (bytes, from) in [
        (&[0x4D][..], SubsystemId::GENERAL),
        (&[0x4D, 0x0D], vertical),
        (&[0x4D, 0x0D, 0], vertical),
        (&[0x46, 0x5D, 0, 1], SubsystemId::GENERAL),
        (&[0x4D, 0x77, 0, 2, 1], SubsystemId::GENERAL),
    ] {
        let answers = handle(&mut rig, bytes, ROOM);
        assert_eq!(answers.len(), 1, "{bytes:02x?}");
        assert_eq!((answers[0].from, answers[0].status), (from, Status::WRONG_DATA));
    }
}

/// §1/9 SetParam whose answer, an id longer than a header, does not fit: nothing is set.
#[test]
fn a_parameter_whose_answer_does_not_fit() {
    let rig = Rig::deployed();
    let spec = Param::ControlHeight.spec();
    let values = Ints::Values(&[7]);
    let asked = payload(&[Request::new(spec.subsystem, Body::SetParam { id: spec.id, values })]);
    for room in 0..=20 {
        let mut rig = rig.clone();
        let before = rig.get(Param::ControlHeight);
        let answers = handle(&mut rig, &asked, room);
        // Header, id, and 8 bytes for NoRoom.
        let fits = room >= 4 + 2 + 8;
        assert_eq!(
            answers.iter().any(|answer| answer.status == Status::NO_ROOM),
            room >= 4 && !fits
        );
        let expected = if fits { Ok(vec![7]) } else { before };
        assert_eq!(rig.get(Param::ControlHeight), expected, "{room}");
    }
}
