//! A small monitor that answers as the protocol says, and streams that serve it. The wire is all
//! that it shares with the client.
#![allow(dead_code, reason = "each test file uses its own part")]

pub mod plant;
pub mod slow_line;

use std::sync::{Arc, Mutex};

use lafet_proto::answer::Reply;
use lafet_proto::flags::*;
use lafet_proto::id::key;
use lafet_proto::link::{self, Decoder, Frame};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::status::*;
use lafet_proto::{Answer, Ints, ParamId, Request, RequestId, Status, SubsystemId};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};

/// Payloads that the monitor received.
pub type Log = Arc<Mutex<Vec<Vec<u8>>>>;

/// The subsystems of this monitor: no Deployer, no Valve2, no Detector's hotbeds beyond one.
const PRESENT: [SubsystemId; 6] = [
    SubsystemId::DETECTOR,
    SubsystemId::CONTROL,
    SubsystemId::VALVE1,
    SubsystemId::HORIZONTAL,
    SubsystemId::VERTICAL,
    SubsystemId::GENERAL,
];

pub const HOTBED: Hotbed = Hotbed { x1: -60, x2: -40, y1: 10, y2: 20, brightness: 900 };

/// Answers a payload within an output buffer of `room` bytes.
pub fn answer_within(payload: &[u8], room: usize) -> Vec<u8> {
    let mut buffer = vec![0; room];
    let mut out = Writer::new(&mut buffer[..room - 8]);
    let mut full = None;
    for record in Records::new(payload) {
        let record = record.expect("a whole record");
        let request = Request::decode(&record).expect("a request");
        let id = record.request;
        for answer in answers(&request, id) {
            if full.is_none() && answer.encode(&mut out).is_err() {
                full = Some((answer.from, id));
            }
        }
    }
    let mut bytes = out.written().to_vec();
    if let Some((from, id)) = full {
        bytes.extend([id.0, from.0, Status::NO_ROOM.0, 0]);
        bytes.extend([id.0, SubsystemId::GENERAL.0, Status::NO_ROOM.0, 0]);
    }
    bytes
}

pub fn answer(payload: &[u8]) -> Vec<u8> {
    answer_within(payload, 512)
}

fn answers(request: &Request<'_>, id: RequestId) -> Vec<Answer<'static>> {
    if matches!(request.to, SubsystemId::ALL | SubsystemId::MOTORS) {
        let handles = |who: &SubsystemId| match id {
            RequestId::GET_STATUS => true,
            RequestId::STOP => *who != SubsystemId::GENERAL,
            RequestId::RETRIEVE_LIMITS | RequestId::SWITCH_LIMITS => who.is_drive(),
            _ => *who == SubsystemId::GENERAL,
        };
        return PRESENT.into_iter().filter(handles).map(|who| one(who, &request.body)).collect();
    }
    if !PRESENT.contains(&request.to) {
        return vec![Answer::bare(request.to, id, Status::MODULE_NOT_EXIST)];
    }
    vec![one(request.to, &request.body)]
}

fn one(from: SubsystemId, body: &Body<'_>) -> Answer<'static> {
    let (status, data) = match body {
        Body::GetStatus => (Status::OK, status_of(from)),
        Body::GetParam { id: ParamId::HOTBEDS } => (Status::OK, hotbeds()),
        Body::GetParam { id } if *id == ParamId::of("Speed") => (Status::OK, param(*id, &[12])),
        Body::GetParam { .. } => (Status::INVALID_ID, Reply::None),
        Body::SetParam { id, .. } => (Status::ACCEPTED, param(*id, &[])),
        Body::RetrieveLimits => (Status::OK, Reply::Limits(Limits { min: -900, max: 5400 })),
        Body::GetCrashData => (Status::OK, Reply::Fault(FaultInfo::NONE)),
        Body::Open { key: key::OPEN } | Body::Close { key: key::CLOSE } => {
            (Status::ACCEPTED, Reply::None)
        }
        Body::Open { .. } | Body::Close { .. } => (Status::NEED_CONFIRM, Reply::None),
        Body::StartJustify => {
            return Answer::bare(SubsystemId::CONTROL, body.id(), Status::DENIED);
        }
        Body::Move { .. } => (Status::ACCEPTED, Reply::None),
        _ => (Status::OK, Reply::None),
    };
    Answer { from, request: body.id(), status, data }
}

fn param(id: ParamId, values: &'static [i32]) -> Reply<'static> {
    Reply::Param { id, values: Ints::Values(values) }
}

fn hotbeds() -> Reply<'static> {
    const VALUES: [i32; 5] = HOTBED.to_values();
    param(ParamId::HOTBEDS, &VALUES)
}

fn status_of(who: SubsystemId) -> Reply<'static> {
    let drive = |position| DriveStatus { flags: DriveFlags::MOVE, position, current: 5, speed: 9 };
    match who {
        SubsystemId::DETECTOR => Reply::Detector(DetectorStatus { flags: DetectorFlags::FOUND }),
        SubsystemId::CONTROL => Reply::Control(ControlStatus { flags: ControlFlags::empty() }),
        SubsystemId::VALVE1 => Reply::Valve(ValveStatus { flags: ValveFlags::CLOSED }),
        SubsystemId::HORIZONTAL => Reply::Drive(drive(-1200)),
        SubsystemId::VERTICAL => Reply::Drive(drive(300)),
        _ => Reply::General(GeneralStatus {
            flags: GeneralFlags::empty(),
            main_voltage: 24,
            pressure: 80,
            flowrate: 40,
        }),
    }
}

/// A link frame from the monitor with address 1 to the console with address 129.
pub fn frame(payload: &[u8]) -> Vec<u8> {
    encode(129, 1, payload)
}

pub fn encode(dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut wire = vec![0; link::wire_max(payload.len())];
    let len = link::encode(&Frame { dst, src, payload }, &mut wire).expect("room");
    wire.truncate(len);
    wire
}

/// Answers every frame on a stream with the bytes that `behave` gives, until the stream ends.
pub async fn serve<S, B>(mut stream: S, log: Log, mut behave: B)
where
    S: AsyncRead + AsyncWrite + Unpin,
    B: FnMut(&[u8]) -> Vec<u8>,
{
    let mut decoder: Decoder = Decoder::new();
    let mut buffer = [0; 2048];
    while let Ok(len @ 1..) = stream.read(&mut buffer).await {
        let mut replies = Vec::new();
        for byte in &buffer[..len] {
            if let Some(frame) = decoder.push(*byte) {
                assert_eq!((frame.dst, frame.src), (1, 129));
                log.lock().unwrap().push(frame.payload.to_vec());
                replies.extend(behave(frame.payload));
            }
        }
        if stream.write_all(&replies).await.is_err() {
            return;
        }
    }
}
