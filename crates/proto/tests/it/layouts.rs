//! The tables of layouts say what the typed structures do.

use lafet_proto::answer::Answer;
use lafet_proto::dictionary::layouts::{self, Layout};
use lafet_proto::id::{RequestId, Status, SubsystemId};
use lafet_proto::record::{Record, Records, Writer};
use lafet_proto::request::{Body, Path, Request};
use lafet_proto::text;
use proptest::prelude::*;

fn fitting(layouts: &'static [Layout], data: &[u8]) -> Option<&'static Layout> {
    layouts.iter().find(|layout| layout.fits(data))
}

/// The structure of a request and its fields as `name=value`.
fn request(words: &str) -> (&'static str, String) {
    let (mut buffer, mut bytes) = ([0; text::BUFFER_SIZE], [0; 260]);
    let mut writer = Writer::new(&mut bytes);
    text::parse(words, &mut buffer).expect(words).encode(&mut writer).expect("it fits");
    let record = Records::new(writer.written()).next().expect("a record").expect("whole");
    let layout = fitting(layouts::of_request(record.request), record.data).expect(words);
    (layout.name, values(layout, record.data))
}

fn values(layout: &Layout, data: &[u8]) -> String {
    let values = layout.values(data).map(|(_, field, value)| format!("{}={value}", field.name));
    values.collect::<Vec<_>>().join(" ")
}

#[test]
fn requests() {
    let is = |words, name, fields: &str| assert_eq!(request(words), (name, fields.into()));
    is("Move Vertical -90", "Move", "destination=-90");
    is("Stop All", "Empty", "");
    is("SwitchLimits Vertical reject", "SwitchLimits", "new_state=2");
    is(
        "StartSeek Detector -1800 1800 -300 300",
        "Seek",
        "start_h=-1800 end_h=1800 start_v=-300 end_v=300 analyse=0",
    );
    is(
        "StartQuench Control centre=600,-100 nozzle=60 sector=240,60 step=1 distance=25",
        "QuenchFull",
        "centre_h=600 centre_v=-100 nozzle=60 width=240 height=60 step=1 distance=25",
    );
    is(
        "StartTrajectory Control ballistics repeat point=0,5,20,10 point=-600,0,25,10",
        "TrajectoryPoints",
        "mode=0 flags=3 count=2 horizontal=0 vertical=5 distance=20 dwell=10 \
         horizontal=-600 vertical=0 distance=25 dwell=10",
    );
    let (name, fields) = request("SetParam Vertical Speed 5");
    assert_eq!((name, fields.split(' ').nth(1)), ("Param", Some("value=5")));
    let keys = [("Open Valve1", 0x4C70), ("Lockout All off", 0x7353)];
    for (words, key) in keys {
        is(words, "Key", &format!("key={key}"));
    }
}

#[test]
fn answers() {
    let find = |request, from, data: &[u8]| {
        fitting(layouts::of_answer(request, from), data).map(|l| (l.name, values(l, data)))
    };
    let drive =
        find(RequestId::GET_STATUS, SubsystemId::VERTICAL, &[1, 0, 2, 0, 0x9C, 0xFF, 15, 9]);
    let fields = "flags=131073 position=-100 current=15 speed=9";
    assert_eq!(drive, Some(("DriveStatus", fields.into())));
    let mut hotbeds = vec![0xFE, 0x23];
    hotbeds.extend((1..=5).flat_map(|value: i32| value.to_le_bytes()));
    let found = find(RequestId::GET_PARAM, SubsystemId::DETECTOR, &hotbeds);
    assert_eq!(found, Some(("Hotbeds", "id=9214 x1=1 x2=2 y1=3 y2=4 brightness=5".into())));
    hotbeds[0] = 0;
    let other = find(RequestId::GET_PARAM, SubsystemId::DETECTOR, &hotbeds);
    assert_eq!(other.map(|(name, _)| name), Some("Param"));
    let sizes = [(80, Some("FaultInfo")), (48, Some("FaultInfoArm7tdmi")), (44, None)];
    for (size, name) in sizes {
        let fault = find(RequestId::GET_CRASH_DATA, SubsystemId::GENERAL, &vec![0; size]);
        assert_eq!(fault.map(|(name, _)| name), name);
    }
}

fn any_request() -> impl Strategy<Value = RequestId> {
    let all: Vec<RequestId> =
        RequestId::KNOWN.iter().chain(RequestId::BUS).map(|(id, _)| *id).collect();
    prop::sample::select(all)
}

proptest! {
    /// What the types take has a layout that covers every byte, and the other way round. The
    /// types look at two values too: count and flags of a trajectory.
    #[test]
    fn types_and_layouts_agree(
        id in any_request(),
        from in prop::sample::select(SubsystemId::TABLE.to_vec()),
        data in prop::collection::vec(prop_oneof![Just(0u8), Just(1), any::<u8>()], 0..100),
    ) {
        let record = Record { request: id, device: from, status: Status::OK, data: &data };
        let layout = fitting(layouts::of_request(id), &data);
        match Request::decode(&record) {
            Ok(Request { body: Body::StartTrajectory(trajectory), .. }) => {
                let points = matches!(trajectory.path, Path::Points(_));
                let name = if points { "TrajectoryPoints" } else { "TrajectoryStored" };
                prop_assert_eq!(layout.map(|l| l.name), Some(name));
            }
            Ok(_) => prop_assert!(layout.is_some(), "{} {:?}", id, data),
            Err(_) if id == RequestId::START_TRAJECTORY => {}
            Err(_) => prop_assert!(layout.is_none(), "{} {:?}", id, data),
        }
        let answer = fitting(layouts::of_answer(id, from), &data);
        let has_data = !data.is_empty() && !layouts::of_answer(id, from).is_empty();
        if has_data && id != RequestId::GET_LOG {
            prop_assert_eq!(Answer::decode(&record).is_ok(), answer.is_some(), "{} {:?}", id, data);
        }
        for layout in layout.into_iter().chain(answer) {
            let covered: usize = layout.values(&data).map(|(_, field, _)| field.kind.size()).sum();
            prop_assert_eq!(covered, data.len());
        }
    }
}
