//! The text form of requests and answers, both ways.

use lafet_proto::id::{RequestId, key};
use lafet_proto::param::{MAX_VALUES, Param, Unit};
use lafet_proto::record::{DATA_MAX, Record, Records, Writer};
use lafet_proto::request::{
    Body, Path, Points, Quench, Request, Sector, Seek, Trajectory, TrajectoryPoint,
};
use lafet_proto::text::{self, AnswerText, Exchange, RequestText, Wanted};
use lafet_proto::{Answer, Bytes, Ints, ParamId, Status, SubsystemId};
use proptest::collection::vec;
use proptest::prelude::*;

fn parse(text: &str) -> Vec<u8> {
    let mut buf = [0; text::BUFFER_SIZE];
    let request = text::parse(text, &mut buf).unwrap_or_else(|e| panic!("{text}: {e}"));
    bytes(&request)
}

fn bytes(request: &Request<'_>) -> Vec<u8> {
    let mut buffer = [0; 4 + DATA_MAX];
    let mut writer = Writer::new(&mut buffer);
    request.encode(&mut writer).expect("255 bytes of data fit");
    writer.written().to_vec()
}

fn record(bytes: &[u8]) -> Record<'_> {
    Records::new(bytes).next().expect("a record").expect("a whole record")
}

/// Text → request → text gives this form.
fn shown(text: &str) -> String {
    let mut buf = [0; text::BUFFER_SIZE];
    text::parse(text, &mut buf).unwrap_or_else(|e| panic!("{text}: {e}")).to_string()
}

fn error(text: &str) -> text::ParseError {
    let mut buf = [0; text::BUFFER_SIZE];
    match text::parse(text, &mut buf) {
        Ok(request) => panic!("{text} is {request}"),
        Err(error) => error,
    }
}

#[test]
fn case_order_and_spaces_do_not_matter() {
    for (loose, strict) in [
        ("  move   VERTICAL\t-21600 ", "Move Vertical -21600"),
        ("Move Vertical 0x10", "Move Vertical 16"),
        ("getparam detector hotbeds", "GetParam Detector Hotbeds"),
        ("GetParam Detector 0x23FE", "GetParam Detector Hotbeds"),
        ("GetParam Detector @Hotbeds", "GetParam Detector Hotbeds"),
        ("SetParam General Chain 16383", "SetParam General Chain 0x3fff"),
        ("SetParam Vertical MinLimit 0xffffffff", "SetParam Vertical MinLimit -1"),
        ("SetParam All Speed 5", "SetParam All Speed 5"),
        (
            "startquench distance=25 step=2 sector=600,300 nozzle=60 center=1200,300",
            "StartQuench Control centre=1200,300 nozzle=60 sector=600,300 step=2 distance=25",
        ),
        ("StartTrajectory stored=7,0 repeat", "StartTrajectory Control repeat stored=7,0"),
        ("StartSeek 1 2 3 4 ANALYSE # both passes", "StartSeek Detector 1 2 3 4 analyse"),
        ("lockout ON", "Lockout All on"),
        ("Lockout All key=0x7353", "Lockout All off"),
        ("SwitchLimits motors state=2", "SwitchLimits Motors reject"),
        ("Open Valve1 key=19568", "Open Valve1"),
        ("0x4d 0x0d a0 ab", "Move Vertical -21600"),
        ("0xd4 All", "GetStatus All"),
        ("0x12 0x34 DEADbe", "0x12 0x34 de ad be"),
        ("0x12 0x34", "0x12 0x34"),
    ] {
        assert_eq!(shown(loose), strict);
        assert_eq!(parse(loose), parse(strict), "{loose}");
    }
}

/// Only where the document knows one addressee may it be left out.
#[test]
fn a_single_addressee_is_implied() {
    for (short, long) in [
        ("Deploy", "Deploy Deployer"),
        ("Wrap", "Wrap Deployer"),
        ("Restart", "Restart All"),
        ("StartJustify", "StartJustify Detector"),
        ("CleanFlash", "CleanFlash General"),
        ("GetHotbed", "GetHotbed Detector"),
        ("CleanFlash key=1", "CleanFlash General key=0x0001"),
    ] {
        assert_eq!(shown(short), long);
    }
    assert_eq!(error("Stop").expected, Wanted::Addressee(RequestId::STOP));
    assert_eq!(error("Open").expected, Wanted::Addressee(RequestId::OPEN));
}

/// A request that no addressee would take can still be said: negative tests need it.
#[test]
fn unsound_requests_have_a_form() {
    let short = [0x4D, 0x0D, 0x00, 0x01, 0xB0];
    assert_eq!(parse("0x4d Vertical b0"), short);
    let shown = RequestText(record(&short)).to_string();
    assert_eq!(
        shown,
        "0x4d Vertical b0 # Move: at byte 0: 1 data bytes are not a size this record can have"
    );
    assert_eq!(parse(&shown), short);
    assert_eq!(shown_of(&[0x46, 0x85, 0, 0]), "Stop Horizontal");
    assert_eq!(parse("Move Valve1 5"), [0x4D, 0xA6, 0, 2, 5, 0]);
}

fn shown_of(bytes: &[u8]) -> String {
    RequestText(record(bytes)).to_string()
}

#[test]
fn errors_say_where_and_what() {
    let cases: [(&str, usize, usize, &str); 22] = [
        ("", 0, 0, "column 1: expected a request (0x and two digits, or one of Move, Stop, "),
        ("Mvoe Vertical 5", 0, 4, "did you mean `Move`?"),
        ("Move Vertcal 5", 5, 7, "did you mean `Vertical`?"),
        ("Move", 4, 0, "(0x and two digits, or one of Vertical, Horizontal, Nozzle, Deployer)"),
        ("Move Vertical", 13, 0, "expected destination, a number from -32768 to 32767"),
        ("Move Vertical 32768", 14, 5, "expected destination, a number from -32768 to 32767"),
        ("Move Vertical 5 6", 16, 1, "column 17: expected nothing more"),
        ("GetParam Vertical MinLimt", 18, 7, "did you mean `MinLimit`?"),
        ("GetParam Buttons Foo", 17, 3, "parameter of Buttons (0x and four digits, @AnyName)"),
        ("SetParam Vertical MinLimit 5x", 27, 2, "a number from -2147483648 to 2147483647"),
        ("Open Valve1 0x4c70", 12, 6, "expected key="),
        ("Open Valve1 key=70000", 16, 5, "expected key, a number from 0 to 65535"),
        ("Lockout All", 11, 0, "expected on or off or key="),
        ("SwitchLimits Vertical maybe", 22, 5, "expected off or on or reject or state="),
        ("StartSeek 1 2 3", 15, 0, "expected end, vertical, a number"),
        ("StartQuench program=1 centre=0,0", 32, 0, "nozzle= is missing"),
        ("StartQuench centre=0 nozzle=1", 19, 1, "expected centre h,v, 2 numbers"),
        ("StartQuench step=1 step=2", 19, 6, "given twice"),
        (
            "StartQuench program=1 centre=0,0 nozzle=5 step=2",
            42,
            6,
            "program= and step= belong to different variants",
        ),
        ("StartQuench centre=0,0 nozzle=1 sector=1,1 step=1", 49, 0, "distance= or corrections="),
        ("StartTrajectory point=1,2,3,4 stored=5", 30, 8, "point= and stored= belong to different"),
        ("0x12 0x34 abc", 10, 3, "expected bytes in hexadecimal"),
    ];
    for (text, column, len, message) in cases {
        let error = error(text);
        assert_eq!((error.column, error.len), (column, len), "{text}: {error}");
        assert!(error.to_string().contains(message), "{text}: {error}");
    }
    assert_eq!(error("Frobnicate All").suggestion, None);
}

#[test]
fn too_many_data_are_refused() {
    let many = |count: usize| format!("SetParam Control Trajectory0{}", " 1".repeat(count));
    assert_eq!(parse(&many(MAX_VALUES)).len(), 4 + 2 + 4 * MAX_VALUES);
    assert_eq!(error(&many(MAX_VALUES + 1)).expected, Wanted::FewerData);
    let raw = |count: usize| format!("0x12 0x34 {}", "ab".repeat(count));
    assert_eq!(parse(&raw(255)).len(), 259);
    assert_eq!(error(&raw(256)).expected, Wanted::FewerData);
    assert_eq!(text::parse("SetParam Vertical Speed 5", &mut []).map_err(|e| e.expected), {
        Err(Wanted::FewerData)
    });
}

/// A single correction would be read as the distance (§3.14).
#[test]
fn corrections_come_at_least_in_twos() {
    let one = "StartQuench centre=0,0 nozzle=0 sector=0,0 step=0 corrections=1";
    let wanted = Wanted::Numbers { what: "corrections", count: 2 };
    assert_eq!(error(one).expected, wanted);
    assert_eq!(parse(&format!("{one},2")).len(), 4 + 13);
}

#[test]
fn an_answer_names_who_answered_instead() {
    let answer = |from, request, status| Answer::bare(from, request, status);
    let denied = answer(SubsystemId::DEPLOYER, RequestId::MOVE, Status::DENIED);
    let request = Request::new(SubsystemId::VERTICAL, Body::Move { destination: 5 });
    assert_eq!(Exchange::new(&request, denied).to_string(), "Vertical Move → Denied (Deployer)");
    assert_eq!(denied.to_string(), "Deployer Move → Denied");
    let stopped = answer(SubsystemId::CONTROL, RequestId::STOP, Status::ACCEPTED);
    let all = Request::new(SubsystemId::ALL, Body::Stop);
    assert_eq!(Exchange::new(&all, stopped).to_string(), "Control Stop → Accepted");
    let odd = answer(SubsystemId(0x33), RequestId(0x12), Status(0x99));
    assert_eq!(odd.to_string(), "0x33 0x12 → 0x99");
    let short = [0xD4, 0x0D, 0, 3, 1, 2, 3];
    let text = AnswerText(record(&short)).to_string();
    assert!(text.starts_with("Vertical GetStatus → Ok: 01 02 03 # at byte 0: 3 data"), "{text}");
}

#[test]
fn values_carry_their_units() {
    for (unit, value, text) in [
        (Unit::Arcmin, -900, "-900'"),
        (Unit::Degree, 3, "3°"),
        (Unit::DeciAmpere, 80, "8.0 A"),
        (Unit::DeciCelsius, -5, "-0.5 °C"),
        (Unit::DeciCelsius, i32::MIN, "-214748364.8 °C"),
        (Unit::Millisecond, 20_000, "20000 ms"),
        (Unit::Bits, -1, "0xffffffff"),
        (Unit::Choice, 2, "2"),
    ] {
        assert_eq!(unit.show(value).to_string(), text);
    }
}

fn subsystem() -> impl Strategy<Value = SubsystemId> {
    prop_oneof![
        4 => proptest::sample::select(SubsystemId::KNOWN).prop_map(|(id, _)| id),
        1 => any::<u8>().prop_map(SubsystemId),
    ]
}

fn param_id() -> impl Strategy<Value = ParamId> {
    prop_oneof![
        4 => proptest::sample::select(Param::ALL.to_vec()).prop_map(|param| param.spec().id),
        1 => any::<u16>().prop_map(ParamId),
    ]
}

fn a_key() -> impl Strategy<Value = u16> {
    let known = [key::OPEN, key::CLOSE, key::CLEAN_FLASH, key::ENABLE, key::DISABLE];
    prop_oneof![proptest::sample::select(known.to_vec()), any::<u16>()]
}

fn sector() -> impl Strategy<Value = Sector> {
    (any::<[i16; 5]>(), any::<i8>()).prop_map(|([h, v, n, w, t], step)| Sector {
        centre_h: h,
        centre_v: v,
        nozzle: n,
        width: w,
        height: t,
        step,
    })
}

/// The data of a request that need memory to lend from.
#[derive(Clone, Debug)]
struct Memory {
    values: Vec<i32>,
    bytes: Vec<u8>,
    points: Vec<TrajectoryPoint>,
}

fn memory() -> impl Strategy<Value = Memory> {
    let point = any::<(i16, i16, u8, u8)>().prop_map(|(horizontal, vertical, distance, dwell)| {
        TrajectoryPoint { horizontal, vertical, distance, dwell }
    });
    (vec(any::<i32>(), 0..=63), vec(any::<u8>(), 2..=244), vec(point, 1..=42))
        .prop_map(|(values, bytes, points)| Memory { values, bytes, points })
}

/// Every shape of a request, chosen by `shape`.
#[derive(Clone, Debug)]
struct Shape {
    shape: usize,
    id: ParamId,
    key: u16,
    sector: Sector,
    small: (i16, u8, i8, bool, bool),
}

fn shape() -> impl Strategy<Value = Shape> {
    (0..SHAPES, param_id(), a_key(), sector(), any::<(i16, u8, i8, bool, bool)>())
        .prop_map(|(shape, id, key, sector, small)| Shape { shape, id, key, sector, small })
}

const SHAPES: usize = 28;

fn body<'a>(shape: &Shape, memory: &'a Memory) -> Body<'a> {
    let Shape { shape, id, key, sector, small: (number, first, distance, one, other) } =
        shape.clone();
    let (ballistics, repeat) = (one, other);
    let values = Ints::Values(&memory.values);
    let corrections = Bytes(&memory.bytes);
    match shape {
        0 => Body::Move { destination: number },
        1 => Body::Stop,
        2 => Body::GetStatus,
        3 => Body::GetParam { id },
        4 => Body::SetParam { id, values },
        5 => Body::SetupCorrectionTable { first, corrections },
        6 => Body::RetrieveLimits,
        7 => Body::Open { key },
        8 => Body::Close { key },
        9 => Body::Deploy,
        10 => Body::Wrap,
        11 => Body::Restart,
        12 => Body::StartJustify,
        13 => Body::StartQuench(Quench::Program {
            program: number,
            centre_h: sector.centre_h,
            centre_v: sector.centre_v,
            nozzle: sector.nozzle,
        }),
        14 => Body::StartQuench(Quench::Full { sector, distance }),
        15 => Body::StartQuench(Quench::Corrected { sector, corrections }),
        16 => {
            let path = Path::Points(Points::Values(&memory.points));
            Body::StartTrajectory(Trajectory { ballistics, repeat, path })
        }
        17 => {
            let path = Path::Stored(&memory.bytes);
            Body::StartTrajectory(Trajectory { ballistics, repeat, path })
        }
        18 => Body::StartSeek(Seek {
            start_h: sector.centre_h,
            end_h: sector.centre_v,
            start_v: sector.width,
            end_v: sector.height,
            analyse: if one { number } else { i16::from(other) },
        }),
        19 => Body::SwitchLimits { new_state: if one { key } else { u16::from(first % 4) } },
        20 => Body::GetHotbed,
        21 => Body::Lockout { key },
        22 => Body::CleanFlash { key },
        23 => Body::GetCrashData,
        24 => Body::AccessGranted,
        25 => Body::GetNetworkStatus,
        26 => Body::GetLog { first: key, count: u16::from(first) },
        // 0x77 is no request of the document.
        _ => Body::Unknown { request: RequestId(0x77), data: &memory.bytes },
    }
}

proptest! {
    /// Request → text → request → bytes → request: the same everywhere.
    #[test]
    fn text_and_bytes_say_the_same(to in subsystem(), shape in shape(), memory in memory()) {
        let request = Request::new(to, body(&shape, &memory));
        let text = request.to_string();
        let mut buf = [0; text::BUFFER_SIZE];
        let parsed = match text::parse(&text, &mut buf) {
            Ok(parsed) => parsed,
            Err(error) => return Err(TestCaseError::fail(format!("{text}: {error}"))),
        };
        prop_assert_eq!(parsed, request);
        prop_assert_eq!(parsed.to_string(), &text[..]);
        let bytes = bytes(&parsed);
        let decoded = Request::decode(&record(&bytes));
        prop_assert_eq!(decoded, Ok(request));
        prop_assert_eq!(RequestText(record(&bytes)).to_string(), text);
    }

    /// Any record that can come over the wire has a text that gives the same bytes again.
    #[test]
    fn any_record_has_a_text(
        id in proptest::sample::select(
            (0..=255).chain(RequestId::KNOWN.iter().map(|(id, _)| id.0)).collect::<Vec<u8>>()),
        device in subsystem(),
        data in vec(any::<u8>(), 0..=40),
    ) {
        let (request, status) = (RequestId(id), Status::OK);
        let record = Record { request, device, status, data: &data };
        let text = RequestText(record).to_string();
        let mut whole = vec![id, device.0, 0, data.len() as u8];
        whole.extend(&data);
        prop_assert_eq!(parse(&text), whole, "{}", text);
        prop_assert!(!AnswerText(record).to_string().is_empty());
    }

    /// No text makes the parser panic, and an error points into the text.
    #[test]
    fn any_text_is_answered(
        text in "(?s).{0,60}",
        head in 0usize..24,
        tail in "[ =,@0-9a-z#x-]{0,40}",
    ) {
        let name = lafet_proto::dictionary::REQUESTS[head].name;
        for text in [text, format!("{name} {tail}"), format!("{name} Control {tail}")] {
            let mut buf = [0; text::BUFFER_SIZE];
            if let Err(error) = text::parse(&text, &mut buf) {
                prop_assert!(text.get(error.column..error.column + error.len).is_some(), "{text}");
                prop_assert!(!error.to_string().is_empty());
            }
        }
    }
}
