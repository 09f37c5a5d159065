//! The golden vectors of conformance/vectors: bytes ⇄ meaning ⇄ text.
//!
//! They were worked out from the document by another hand than this crate. When one of these
//! tests fails, the crate is wrong: do not change the vectors.

use lafet_proto::answer::Reply;
use lafet_proto::bus::Log;
use lafet_proto::link;
use lafet_proto::param::{Access, Effect, Param, Storage};
use lafet_proto::record::{DATA_MAX, Record, Records, Writer};
use lafet_proto::request::{Body, Path, Quench, Request, Sector};
use lafet_proto::status::FaultArch;
use lafet_proto::text::{self, AnswerText, Exchange};
use lafet_proto::{Answer, DecodeError, Expected, Ints, RequestId, Status, SubsystemId};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::path::Path as FilePath;

fn file(name: &str) -> Value {
    let folder = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/vectors");
    let text = std::fs::read_to_string(folder.join(name)).expect("the vectors are in the project");
    serde_json::from_str(&text).expect("the vectors are JSON")
}

fn list(file: &Value, name: &str) -> Vec<Value> {
    let items = file[name].as_array().expect("a list").clone();
    assert!(items.len() > 10, "{name} has only {} vectors", items.len());
    items
}

fn text_of<'a>(vector: &'a Value, field: &str) -> &'a str {
    vector[field].as_str().unwrap_or_else(|| panic!("{vector} has no {field}"))
}

fn bytes_of(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).expect("hex")).collect()
}

fn record(bytes: &[u8]) -> Record<'_> {
    let mut records = Records::new(bytes);
    let record = records.next().expect("a record").expect("a whole record");
    assert!(records.next().is_none(), "one record only");
    record
}

fn written(write: impl FnOnce(&mut Writer<'_>)) -> Vec<u8> {
    let mut buffer = [0; 4 + DATA_MAX];
    let mut writer = Writer::new(&mut buffer);
    write(&mut writer);
    writer.written().to_vec()
}

/// Every vector says where it comes from.
fn check_label(vector: &Value) {
    let label = text_of(vector, "label");
    assert!(["read", "observed", "ours"].contains(&label), "{label}");
    let section = text_of(vector, "section");
    assert!(section == "bus" || section.starts_with(['1', '2', '3']), "{section}");
    assert_eq!(section == "bus", label == "observed", "{vector}");
}

#[test]
fn requests() {
    for vector in list(&file("requests.json"), "requests") {
        let (name, text) = (text_of(&vector, "name"), text_of(&vector, "text"));
        let bytes = bytes_of(text_of(&vector, "bytes"));
        check_label(&vector);

        let request = Request::decode(&record(&bytes)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(request.to_string(), text, "{name}");
        assert_eq!(request_fields(&request.body), vector["fields"], "{name}");
        assert_eq!(written(|out| request.encode(out).expect("it fits")), bytes, "{name}");

        let mut buf = [0; text::BUFFER_SIZE];
        let parsed = text::parse(text, &mut buf).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(parsed, request, "{name}");
    }
}

/// A request of an impossible size or value is WrongData or InvalidValue, never a request.
#[test]
fn malformed_requests() {
    for vector in list(&file("requests.json"), "malformed") {
        let bytes = bytes_of(text_of(&vector, "bytes"));
        let error = Request::decode(&record(&bytes)).expect_err(text_of(&vector, "name"));
        assert_eq!(Some(error.offset as u64), vector["offset"].as_u64(), "{vector}: {error}");
        let size = DecodeError { offset: 0, expected: Expected::Size, got: bytes.len() - 4 };
        assert!(error == size || error.expected == Expected::Value, "{vector}: {error:?}");
    }
}

/// §3: each request, and each of its variants, has a vector and a malformed one where it has data.
#[test]
fn every_request_has_vectors() {
    let file = file("requests.json");
    let ids = |name: &str| -> BTreeSet<u8> {
        list(&file, name).iter().map(|vector| bytes_of(text_of(vector, "bytes"))[0]).collect()
    };
    let (sound, malformed) = (ids("requests"), ids("malformed"));
    for (id, name) in RequestId::KNOWN {
        assert!(sound.contains(&id.0), "{name}");
        assert!(malformed.contains(&id.0), "{name}");
    }
    for (id, name) in RequestId::BUS {
        assert!(sound.contains(&id.0), "{name}");
    }
}

#[test]
fn answers() {
    for vector in list(&file("answers.json"), "answers") {
        let (name, text) = (text_of(&vector, "name"), text_of(&vector, "text"));
        let bytes = bytes_of(text_of(&vector, "bytes"));
        check_label(&vector);

        let answer = Answer::decode(&record(&bytes)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let to = text_of(&vector, "to");
        let number = || to.strip_prefix("0x").map(|hex| u8::from_str_radix(hex, 16).expect("hex"));
        let to = SubsystemId::from_name(to).or_else(|| number().map(SubsystemId)).expect("a name");
        assert_eq!(Exchange { to, answer }.to_string(), text, "{name}");
        assert_eq!(answer_fields(&answer.data), vector["fields"], "{name}");
        assert_eq!(written(|out| answer.encode(out).expect("it fits")), bytes, "{name}");
    }
}

#[test]
fn malformed_answers() {
    for vector in list(&file("answers.json"), "malformed") {
        let bytes = bytes_of(text_of(&vector, "bytes"));
        let error = Answer::decode(&record(&bytes)).expect_err(text_of(&vector, "name"));
        assert_eq!(error.expected, Expected::Size, "{vector}: {error}");
        assert!(AnswerText(record(&bytes)).to_string().contains(" # "), "{vector}");
    }
}

/// §2, §3.3: each status and the status structure of each subsystem has a vector.
#[test]
fn every_answer_has_vectors() {
    let vectors = list(&file("answers.json"), "answers");
    let records: Vec<Vec<u8>> =
        vectors.iter().map(|vector| bytes_of(text_of(vector, "bytes"))).collect();
    for (status, name) in Status::KNOWN {
        assert!(records.iter().any(|bytes| bytes[2] == status.0), "{name}");
    }
    for id in SubsystemId::TABLE {
        let state = [RequestId::GET_STATUS.0, id.0, 0];
        assert!(records.iter().any(|bytes| bytes[..3] == state), "{id}");
    }
}

/// The link frame, both ways, as a stream and as a datagram.
#[test]
fn link_frames() {
    for vector in list(&file("link.json"), "frames") {
        let name = text_of(&vector, "name");
        let body = bytes_of(text_of(&vector, "body"));
        let wire = bytes_of(text_of(&vector, "wire"));
        let frame = link::Frame { dst: body[0], src: body[1], payload: &body[2..] };

        let mut out = vec![0; link::wire_max(frame.payload.len())];
        let len = link::encode(&frame, &mut out).expect("wire_max suffices");
        assert_eq!(out[..len], wire, "{name}");

        let mut decoder: link::Decoder = link::Decoder::new();
        let (last, before) = wire.split_last().expect("bytes");
        assert!(before.iter().all(|byte| decoder.push(*byte).is_none()), "{name}");
        assert_eq!(decoder.push(*last), Some(frame), "{name}");

        let mut unescaped = vec![0; body.len() + 2];
        assert_eq!(link::decode_datagram(&wire, &mut unescaped), Ok(frame), "{name}");
        assert!(link::decode_datagram(&wire, &mut unescaped[1..]).is_err(), "{name}");

        if vector["label"] == "derived" {
            let mut records = Records::new(frame.payload).map(|record| record.expect("whole"));
            assert!(records.all(|record| Request::decode(&record).is_ok()), "{name}");
        }
    }
}

/// Names and ids of parameters are a promise: who changes a name makes another parameter.
#[test]
fn parameters() {
    let vectors = list(&file("params.json"), "params");
    for (place, param) in Param::ALL.into_iter().enumerate() {
        let spec = param.spec();
        let access = if spec.access == Access::ReadOnly { "ro" } else { "rw" };
        let effect = if spec.effect == Effect::Restart { "restart" } else { "now" };
        let actual = json!({
            "subsystem": spec.subsystem.to_string(),
            "name": param.name(),
            "id": spec.id.to_string(),
            "min_len": spec.min_len,
            "max_len": spec.max_len,
            "min": spec.min,
            "max": spec.max,
            "default": spec.default,
            "access": access,
            "effect": effect,
            "stored": spec.storage == Storage::Stored,
        });
        assert_eq!(
            vectors.get(place),
            Some(&actual),
            "conformance/vectors/params.json, entry {place}, should read:\n{actual}"
        );
    }
    assert_eq!(vectors.len(), Param::COUNT, "conformance/vectors/params.json has more");
}

fn ints(values: Ints<'_>) -> Vec<i32> {
    values.iter().collect()
}

/// `null` where there are no data, as in the vectors.
fn request_fields(body: &Body<'_>) -> Value {
    match *body {
        Body::Move { destination } => json!({ "destination": destination }),
        Body::GetParam { id } => json!({ "id": id.0 }),
        Body::SetParam { id, values } => json!({ "id": id.0, "values": ints(values) }),
        Body::SetupCorrectionTable { first, corrections } => {
            json!({ "first": first, "corrections": corrections.iter().collect::<Vec<i8>>() })
        }
        Body::Open { key }
        | Body::Close { key }
        | Body::Lockout { key }
        | Body::CleanFlash { key } => json!({ "key": key }),
        Body::StartQuench(quench) => quench_fields(&quench),
        Body::StartTrajectory(trajectory) => {
            let mut fields =
                json!({ "ballistics": trajectory.ballistics, "repeat": trajectory.repeat });
            match trajectory.path {
                Path::Stored(numbers) => fields["stored"] = json!(numbers),
                Path::Points(points) => {
                    let points = points.iter();
                    let point =
                        points.map(|p| json!([p.horizontal, p.vertical, p.distance, p.dwell]));
                    fields["points"] = point.collect();
                }
            }
            fields
        }
        Body::StartSeek(seek) => json!({
            "start_h": seek.start_h,
            "end_h": seek.end_h,
            "start_v": seek.start_v,
            "end_v": seek.end_v,
            "analyse": seek.analyse,
        }),
        Body::SwitchLimits { new_state } => json!({ "new_state": new_state }),
        Body::GetLog { first, count } => json!({ "first": first, "count": count }),
        Body::Unknown { request, data } => json!({ "request": request.0, "data": hex(data) }),
        _ => Value::Null,
    }
}

fn quench_fields(quench: &Quench<'_>) -> Value {
    let place = |sector: &Sector| {
        let Value::Object(fields) = json!({
            "centre_h": sector.centre_h,
            "centre_v": sector.centre_v,
            "nozzle": sector.nozzle,
            "width": sector.width,
            "height": sector.height,
            "step": sector.step,
        }) else {
            return Map::new();
        };
        fields
    };
    match quench {
        Quench::Program { program, centre_h, centre_v, nozzle } => json!({
            "program": program,
            "centre_h": centre_h,
            "centre_v": centre_v,
            "nozzle": nozzle,
        }),
        Quench::Full { sector, distance } => {
            let mut fields = place(sector);
            fields.insert("distance".into(), json!(distance));
            Value::Object(fields)
        }
        Quench::Corrected { sector, corrections } => {
            let mut fields = place(sector);
            fields.insert("corrections".into(), json!(corrections.iter().collect::<Vec<i8>>()));
            Value::Object(fields)
        }
    }
}

fn answer_fields(reply: &Reply<'_>) -> Value {
    match reply {
        Reply::None => Value::Null,
        Reply::General(s) => json!({
            "flags": s.flags.bits(),
            "main_voltage": s.main_voltage,
            "pressure": s.pressure,
            "flowrate": s.flowrate,
        }),
        Reply::Thermo(s) => json!({
            "flags": s.flags.bits(),
            "horizontal": s.horizontal,
            "vertical": s.vertical,
            "nozzle": s.nozzle,
            "deployer": s.deployer,
            "housing": s.housing,
            "humidity": s.humidity,
        }),
        Reply::Drive(s) => drive_fields(s.flags.bits(), s.position, s.current, s.speed),
        Reply::Deployer(s) => drive_fields(s.flags.bits(), s.position, s.current, s.speed),
        Reply::Valve(s) => json!({ "flags": s.flags.bits() }),
        Reply::Control(s) => json!({ "flags": s.flags.bits() }),
        Reply::Detector(s) => json!({ "flags": s.flags.bits() }),
        Reply::Conn(s) => json!({ "flags": s.flags.bits() }),
        Reply::Buttons(s) => json!({ "flags": s.flags.bits() }),
        Reply::Param { id, values } => json!({ "id": id.0, "values": ints(*values) }),
        Reply::Limits(limits) => json!({ "min": limits.min, "max": limits.max }),
        Reply::Fault(info) => {
            let count = if matches!(info.arch, FaultArch::Arm7Tdmi(_)) { 12 } else { 20 };
            json!({ "words": info.to_words()[..count] })
        }
        Reply::Network(status) => json!({ "addresses": status.iter().collect::<Vec<u8>>() }),
        Reply::Log(Log { first, count, .. }) => json!({ "first": first, "count": count }),
        Reply::Raw(data) => json!({ "data": hex(data) }),
        other => panic!("no vector has {other:?}"),
    }
}

fn drive_fields(flags: u32, position: i16, current: u8, speed: u8) -> Value {
    json!({ "flags": flags, "position": position, "current": current, "speed": speed })
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ")
}
