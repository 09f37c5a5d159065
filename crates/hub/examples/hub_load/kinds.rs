//! Every kind of message that a client can send, made from the description of the API and from the
//! type of the WebSocket's messages: one that is new has no load until it gets one here.

use serde_json::{Value, json};

/// A kind of message.
#[derive(Clone, Debug)]
pub struct Kind {
    pub name: String,
    pub way: Way,
}

/// How it is sent.
#[derive(Clone, Debug)]
pub enum Way {
    /// A request over HTTP; each of `headers` with its line's end.
    Http { method: String, path: String, headers: String, body: Vec<u8> },
    /// A message of the WebSocket.
    Message(Value),
    /// A WebSocket's ping.
    Ping,
    /// A message of the WebSocket that never ends, in fragments of this text.
    Fragments(Vec<u8>),
    /// Bytes that are no whole request; the connection is left as it is.
    Bytes(Vec<u8>),
    /// A whole handshake of TLS, and the end of the connection.
    Handshake,
}

/// All kinds, or those that have no load.
pub fn all() -> Result<Vec<Kind>, String> {
    let mut kinds = Vec::new();
    let mut lacking = Vec::new();
    let mut add = |name: String, way: Option<Way>| match way {
        Some(way) => kinds.push(Kind { name, way }),
        None => lacking.push(name),
    };
    let description = lafet_hub::description();
    for (path, methods) in description["paths"].as_object().into_iter().flatten() {
        for method in methods.as_object().into_iter().flatten().map(|(it, _)| it.to_uppercase()) {
            let name = format!("{method} {path}");
            let body = match method.as_str() {
                "GET" | "DELETE" => Some(Vec::new()),
                _ => body(&name).map(|body| body.to_string().into_bytes()),
            };
            let headers = String::new();
            let way = filled(path).zip(body);
            add(name, way.map(|(path, body)| Way::Http { method, path, headers, body }));
        }
    }
    for kind in lafet_hub::messages() {
        let message = message(&kind).map(|mut message| {
            message["type"] = kind.clone().into();
            Way::Message(message)
        });
        add(format!("WebSocket {kind}"), message);
    }
    add("WebSocket ping".into(), Some(Way::Ping));
    // One grows; one is as long as it was, however often it is continued.
    add("WebSocket fragments".into(), Some(Way::Fragments(vec![b' '; 1000])));
    add("WebSocket empty fragments".into(), Some(Way::Fragments(Vec::new())));
    for (path, packed) in [("/api/alarms/ack", "body"), ("/api/recordings/upload", "file")] {
        let way = http("POST", path, "Content-Encoding: gzip\r\n", vec![0x1f; 4000]);
        add(format!("packed {packed}"), Some(way));
    }
    for path in ["/", "/api/openapi.json", "/api/dictionary", "/api/monitors", "/metrics"] {
        let way = http("GET", path, "Accept-Encoding: gzip\r\n", Vec::new());
        add(format!("GET {path}, packed"), Some(way));
    }
    let half = |head: &str| Some(Way::Bytes(head.as_bytes().to_vec()));
    let post = "POST /api/login HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99\r\n\r\n{";
    add("half a body".into(), half(post));
    add("half a head".into(), half("GET /api/hub HTTP/1.1\r\nHost: loc"));
    if lacking.is_empty() { Ok(kinds) } else { Err(format!("no load: {}", lacking.join(", "))) }
}

fn http(method: &str, path: &str, headers: &str, body: Vec<u8>) -> Way {
    let [method, path, headers] = [method, path, headers].map(str::to_owned);
    Way::Http { method, path, headers, body }
}

/// The kinds that only a hub with TLS is sent.
pub fn of_tls() -> Vec<Kind> {
    let kind = |name: &str, way| Kind { name: name.to_owned(), way };
    vec![
        kind("whole handshakes", Way::Handshake),
        // A ClientHello of TLS 1.2 as it begins.
        kind("half a handshake", Way::Bytes(b"\x16\x03\x01\x00\x7f\x01".to_vec())),
        kind("garbage for a handshake", Way::Bytes(vec![0xFF; 60_000])),
        kind("GET /api/hub over TLS", http("GET", "/api/hub", "", Vec::new())),
    ]
}

/// A path with values in place of its names.
fn filled(path: &str) -> Option<String> {
    let id = if path.contains("/monitors/") { "M1" } else { "1" };
    let mut filled = path.to_owned();
    for (name, value) in [("id", id), ("name", "Speed"), ("subsystem", "Vertical"), ("user", "u")] {
        filled = filled.replace(&format!("{{{name}}}"), value);
    }
    (!filled.contains('{')).then_some(filled)
}

/// What is sent with a request that has a body.
fn body(name: &str) -> Option<Value> {
    Some(match name.split_once(' ').map(|(_, path)| path)? {
        "/api/stop" | "/api/lockout" | "/api/logout" | "/api/alarms/ack" => json!({}),
        "/api/monitors/{id}/stop" | "/api/monitors/{id}/close" => json!({ "of": "x".repeat(9000) }),
        "/api/monitors/{id}/lockout" | "/api/monitors/{id}/params/read" => json!({}),
        "/api/monitors/{id}/requests" => json!({ "request": "GetStatus General" }),
        "/api/monitors/{id}/authority" => {
            json!({ "action": "force", "reason": "x".repeat(60_000) })
        }
        "/api/monitors/{id}/jog" => json!({ "drive": "Vertical", "toward": "max" }),
        "/api/monitors/{id}/aim" => json!({ "way_m": 30.0, "rise_m": 0.0 }),
        "/api/monitors/{id}/params/{subsystem}/{name}" => json!({ "values": [5] }),
        "/api/jets" => json!({ "jets": [] }),
        "/api/login" | "/api/setup" => {
            json!({ "user": "u", "password": "wrong and long", "token": "x" })
        }
        "/api/password" => json!({ "old": "wrong and long", "new": "another long one" }),
        "/api/users" | "/api/users/{user}" => json!({ "name": "u", "role": "observer" }),
        "/api/tokens" => json!({ "name": "x".repeat(1000), "role": "observer" }),
        "/api/alarms/shelve" | "/api/alarms/unshelve" => {
            json!({ "id": "x", "minutes": 1, "reason": "x" })
        }
        "/api/detectors/{id}" => json!({ "signal": "alarm" }),
        "/api/detectors/{id}/bypass" => json!({ "bypass": "masked" }),
        "/api/wind" => json!({ "from_deg": 90, "speed_mps": 3 }),
        "/api/pumps/{id}" => json!({ "on": true }),
        "/api/zones/{id}/hold" => json!({ "on": true }),
        "/api/zones/{id}/release" => json!({ "confirm": "1" }),
        "/api/zones/{id}/mode" => json!({ "mode": "manual" }),
        path if path.starts_with("/api/zones/") => json!({}),
        "/api/recordings" => json!({ "seconds": 1 }),
        "/api/recordings/upload" => json!("no recording"),
        path if path.starts_with("/api/sim/") => json!({ "speed": 1, "on": true }),
        _ => return None,
    })
}

/// What is said with a message.
fn message(kind: &str) -> Option<Value> {
    Some(match kind {
        "request" => json!({ "monitor": "M1", "request": "GetStatus All" }),
        "stop" => json!({ "monitor": "M1", "id": "x".repeat(14_000) }),
        "close" | "lockout" => json!({ "monitor": "M1" }),
        "authority" => json!({ "monitor": "M1", "action": "take" }),
        "jog" => json!({ "monitor": "M1", "drive": "Vertical", "toward": "max" }),
        "jog_end" => json!({ "monitor": "M9", "drive": "Vertical" }),
        "tune" => json!({ "monitor": "M1", "drive": "Vertical" }),
        "tune_beat" => json!({ "monitor": "M9" }),
        "subscribe" => json!({ "monitors": ["M1"] }),
        "watch" => json!({ "frames": ["M1", "M2", "M3"] }),
        _ => return None,
    })
}
