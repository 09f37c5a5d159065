//! What the kinds of messages say.

use std::io::Cursor;

use lafet_capture::{Captured, Direction, Format, Recorder};
use lafet_proto::link::{BODY_MAX, Frame, encode};
use lafet_proto::{RequestId, SubsystemId};
use serde_json::{Value, json};

/// In a path or a body: another number in each request.
pub const NUMBER: &str = "%NUMBER%";
/// An alarm that there is all the time.
pub const ALARM: &str = "zones/hall/ZoneNotReady";

/// What is asked with a path.
pub fn query(name: &str) -> &'static str {
    match name {
        "GET /api/history" | "GET /api/history.csv" | "GET /api/history.parquet" => {
            "?monitor=M1&series=Vertical.position,General.pressure&points=1000"
        }
        "GET /api/history/series" => "?monitor=M1",
        "GET /api/history/changes" => "?monitor=M1",
        "GET /api/audit" | "GET /api/events" => "?text=stop&limit=100",
        "GET /api/alarms/history" => "?limit=100",
        "GET /api/recordings/{name}/changes" => "?frames=true",
        "POST /api/recordings/upload" => "?name=load%NUMBER%",
        _ => "",
    }
}

/// What is sent with a request that has a body, as the hub accepts it.
pub fn body(name: &str) -> Option<Vec<u8>> {
    let value = match name.split_once(' ').map(|(_, path)| path)? {
        "/api/recordings/upload" => return Some(recording()),
        "/api/stop" | "/api/lockout" | "/api/logout" | "/api/alarms/ack" => json!({}),
        "/api/monitors/{id}/stop" | "/api/monitors/{id}/close" => json!({}),
        "/api/monitors/{id}/lockout" | "/api/monitors/{id}/params/read" => json!({}),
        "/api/monitors/{id}/requests" => json!({ "request": "GetStatus General" }),
        "/api/monitors/{id}/authority" => json!({ "action": "force", "reason": "the load" }),
        "/api/monitors/{id}/jog" => json!({ "drive": "Vertical", "toward": "max" }),
        "/api/monitors/{id}/aim" => json!({ "way_m": 30.0, "rise_m": 0.0 }),
        "/api/monitors/{id}/params/{subsystem}/{name}" => json!({ "values": [5] }),
        "/api/jets" => json!({ "jets": [{ "monitor": "M1" }] }),
        "/api/login" => json!({ "user": "u", "password": "wrong and long" }),
        "/api/setup" => json!({ "token": "x", "user": "u", "password": "wrong and long" }),
        "/api/password" => json!({ "old": "wrong and long", "new": "another long one" }),
        "/api/users" => {
            let user = format!("new{NUMBER}");
            json!({ "user": user, "role": "observer", "password": "correct horse battery" })
        }
        "/api/users/{user}" => json!({ "role": "observer" }),
        "/api/tokens" => json!({ "name": format!("token{NUMBER}"), "role": "observer" }),
        "/api/alarms/shelve" => json!({ "id": ALARM, "minutes": 1, "reason": "the load" }),
        "/api/alarms/unshelve" => json!({ "id": ALARM }),
        "/api/detectors/{id}" => json!({ "signal": "quiet" }),
        "/api/detectors/{id}/bypass" => json!({ "bypass": "none" }),
        "/api/wind" => json!({ "from_deg": 90, "speed_mps": 3 }),
        "/api/pumps/{id}" | "/api/zones/{id}/hold" | "/api/sim/automatic" => json!({ "on": true }),
        "/api/zones/{id}/release" => json!({ "confirm": "hall" }),
        "/api/zones/{id}/mode" => json!({ "mode": "automatic" }),
        path if path.starts_with("/api/zones/") => json!({}),
        "/api/recordings" => json!({ "seconds": 1 }),
        "/api/updates" => json!({ "images": ["0".repeat(64)] }),
        "/api/updates/images" => json!("no image"),
        "/api/updates/stop" => json!({}),
        "/api/sim/fire" => json!({ "at": [5, -8] }),
        "/api/sim/faults" => json!({ "monitor": "M1", "fault": "vertical-jam", "on": false }),
        "/api/sim/link" => json!({ "monitor": "M1", "up": true }),
        "/api/sim/speed" => json!({ "speed": 1 }),
        "/api/sim/scenario" => json!({ "id": "hangar" }),
        "/api/sim/pause" | "/api/sim/resume" => json!({}),
        _ => return None,
    };
    Some(value.to_string().into_bytes())
}

/// What is sent with the same request and refused, and with which status: long, where it may be.
pub fn refused_body(name: &str) -> Option<(Vec<u8>, u16)> {
    let long = |length: usize| "x".repeat(length);
    let (value, status) = match name.split_once(' ').map(|(_, path)| path)? {
        "/api/monitors/{id}/authority" => {
            (json!({ "action": "force", "reason": long(60_000) }), 400)
        }
        "/api/monitors/{id}/requests" => (json!({ "request": long(60_000) }), 413),
        "/api/alarms/shelve" => (json!({ "id": long(60_000), "minutes": 1, "reason": "x" }), 404),
        "/api/users" if name.starts_with("POST") => {
            (json!({ "user": "u", "role": "observer", "password": "password" }), 400)
        }
        "/api/tokens" if name.starts_with("POST") => {
            (json!({ "name": long(60_000), "role": "observer" }), 400)
        }
        "/api/jets" => (json!({ "jets": vec![json!({}); 20_000] }), 400),
        "/api/detectors/{id}" => (json!({ "signal": long(60_000) }), 400),
        "/api/zones/{id}/release" => (json!({ "confirm": long(60_000) }), 400),
        "/api/recordings/upload" => (json!("no recording"), 400),
        _ => return None,
    };
    Some((value.to_string().into_bytes(), status))
}

/// What is said with a message.
pub fn message(kind: &str) -> Option<Value> {
    Some(match kind {
        "request" => json!({ "monitor": "M1", "request": "GetStatus All" }),
        "stop" | "close" | "lockout" => json!({ "monitor": "M1" }),
        "authority" => json!({ "monitor": "M1", "action": "force", "reason": "the load" }),
        "jog" => json!({ "monitor": "M1", "drive": "Vertical", "toward": "max" }),
        "jog_end" => json!({ "monitor": "M9", "drive": "Vertical" }),
        "tune" => json!({ "monitor": "M1", "drive": "Vertical" }),
        "tune_beat" => json!({ "monitor": "M9" }),
        "subscribe" => json!({ "monitors": ["M1"] }),
        "watch" => json!({ "frames": ["M1", "M2", "M3"] }),
        _ => return None,
    })
}

/// A recording of a monitor's states.
pub fn recording() -> Vec<u8> {
    const STATES: u64 = 200;
    let mut bytes = Cursor::new(Vec::new());
    let write = |bytes: &mut Cursor<Vec<u8>>| -> std::io::Result<()> {
        let mut recorder = Recorder::new(Format::Mcap, bytes)?;
        for number in 0..STATES {
            let [low, high] = (number as i16 * 10).to_le_bytes();
            let (request, of) = (RequestId::GET_STATUS.0, SubsystemId::VERTICAL.0);
            let payload = [request, of, 0, 8, 1, 0, 2, 0, low, high, 15, 9];
            let mut out = [0; BODY_MAX * 2];
            let frame = Frame { dst: 129, src: 1, payload: &payload };
            let len = encode(&frame, &mut out).unwrap_or(0);
            recorder.write(&Captured {
                at_ns: 1_790_000_000_000_000_000 + number * 100_000_000,
                direction: Direction::FromMonitor,
                bytes: out[..len].to_vec(),
            })?;
        }
        recorder.finish()
    };
    // It is written to memory.
    write(&mut bytes).unwrap_or_else(|error| panic!("{error}"));
    bytes.into_inner()
}
