//! Every kind of message that a client can send, made from the description of the API and from the
//! type of the WebSocket's messages: one that is new has no load until it gets one here.

use serde_json::{Value, json};

use super::bodies::{NUMBER, body, message, query, refused_body};

/// A kind of message.
#[derive(Clone, Debug)]
pub struct Kind {
    pub name: String,
    pub way: Way,
    /// How a client that is logged in and reads has to be answered at least once.
    pub answered: Answered,
}

/// What a client gets.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Answered {
    /// 2xx or 101; of a message of the WebSocket: its answer is no error.
    Done,
    /// This status; of the WebSocket: 400 for an answer that is an error.
    Refused(u16),
    /// One of both, as the hub is at the moment.
    DoneOr(u16),
    /// Nothing answers it.
    Silence,
}

/// How it is sent.
#[derive(Clone, Debug)]
pub enum Way {
    /// A request over HTTP; each of `headers` with its line's end.
    Http { method: String, path: String, headers: String, body: Vec<u8> },
    /// Messages of the WebSocket: those that are sent once, and the one that is repeated.
    Messages(Vec<Value>, Value),
    /// A WebSocket's ping.
    Ping,
    /// A message of the WebSocket that never ends, in fragments of this text.
    Fragments(Vec<u8>),
    /// Bytes that are no whole request; the connection is left as it is.
    Bytes(Vec<u8>),
    /// A whole handshake of TLS, and the end of the connection.
    Handshake,
}

/// All kinds, or those that have no load. What locks is last: more is refused from then on.
pub fn all() -> Result<Vec<Kind>, String> {
    let (mut kinds, mut lacking) = (Vec::new(), Vec::new());
    let description = lafet_hub::description();
    for (path, methods) in description["paths"].as_object().into_iter().flatten() {
        for method in methods.as_object().into_iter().flatten().map(|(it, _)| it.to_uppercase()) {
            match operation(&method, path) {
                Some(own) => kinds.extend(own),
                None => lacking.push(format!("{method} {path}")),
            }
        }
    }
    for kind in lafet_hub::messages() {
        match of_socket(&kind) {
            Some(own) => kinds.push(own),
            None => lacking.push(format!("WebSocket {kind}")),
        }
    }
    kinds.extend(others());
    kinds.sort_by_key(|kind| kind.name.contains("lock"));
    if lacking.is_empty() { Ok(kinds) } else { Err(format!("no load: {}", lacking.join(", "))) }
}

/// An operation of the API as it is accepted, and with a body that is not.
fn operation(method: &str, path: &str) -> Option<Vec<Kind>> {
    let name = format!("{method} {path}");
    let has_body = !matches!(method, "GET" | "DELETE");
    let filled = filled(method, path)?;
    let asked = filled.clone() + query(&name);
    let content = if has_body { body(&name)? } else { Vec::new() };
    let headers = match path {
        "/api/ws" => {
            "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
        }
        _ => "",
    };
    let mut kinds = vec![Kind {
        answered: answer(&name),
        way: http(method, &asked, headers, content),
        name: name.clone(),
    }];
    if let Some((content, status)) = refused_body(&name) {
        kinds.push(Kind {
            name: name + ", refused",
            way: http(method, &filled, "", content),
            answered: Answered::Refused(status),
        });
    }
    Some(kinds)
}

/// How an operation is answered on the hub of the load.
fn answer(name: &str) -> Answered {
    use Answered::{Done, DoneOr, Refused};
    match name {
        // Of guesses few are looked at.
        "POST /api/login" | "POST /api/setup" => Refused(429),
        // A token has no password.
        "POST /api/password" => Refused(400),
        // No client has sessions of these numbers, and no pump is configured.
        "DELETE /api/sessions/{id}" | "POST /api/pumps/{id}" => Refused(404),
        // No monitor of the load has software of its own.
        "POST /api/updates" | "POST /api/updates/images" => Refused(400),
        "POST /api/updates/stop" | "DELETE /api/updates/images/{digest}" => Refused(404),
        // A client that does not read, or a flood before this one, has made the user, or removed it, already.
        "POST /api/users" => DoneOr(409),
        "DELETE /api/users/{user}"
        | "DELETE /api/recordings/{name}"
        | "DELETE /api/tokens/{id}" => DoneOr(404),
        // A program may be built without it.
        "GET /api/history.parquet" => DoneOr(501),
        // What is shelved or released is so for the next request, too.
        "POST /api/alarms/unshelve" => DoneOr(404),
        "POST /api/zones/reset" | "POST /api/zones/{id}/reset" => DoneOr(409),
        "POST /api/zones/{id}/release" | "POST /api/zones/{id}/hold" => DoneOr(409),
        // A simulation is in the demo alone, where all clients are one user and share its limits.
        _ if name.contains(" /api/sim") => Refused(404),
        _ => Done,
    }
}

fn of_socket(kind: &str) -> Option<Kind> {
    let mut then = message(kind)?;
    then["type"] = kind.into();
    then["id"] = 1.into();
    let force =
        json!({ "type": "authority", "monitor": "M1", "action": "force", "reason": "the load" });
    let first = if matches!(kind, "jog" | "tune") { vec![force] } else { Vec::new() };
    let silent = matches!(kind, "jog_end" | "tune_beat" | "watch");
    let answered = if silent { Answered::Silence } else { Answered::Done };
    let (name, way) = (format!("WebSocket {kind}"), Way::Messages(first, then));
    Some(Kind { name, way, answered })
}

/// What is neither an operation nor a message by its type.
fn others() -> Vec<Kind> {
    use Answered::{Done, Refused, Silence};
    let kind = |name: &str, way, answered| Kind { name: name.to_owned(), way, answered };
    let long = json!({ "type": "stop", "monitor": "M1", "id": "x".repeat(14_000) });
    let unknown = json!({ "type": "stop", "monitor": "M9", "id": "x".repeat(14_000) });
    let post = "POST /api/login HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99\r\n\r\n{";
    let half = "GET /api/hub HTTP/1.1\r\nHost: loc";
    let mut kinds = vec![
        kind("WebSocket stop with a long id", Way::Messages(Vec::new(), long), Done),
        kind("WebSocket stop of nothing", Way::Messages(Vec::new(), unknown), Refused(400)),
        kind("WebSocket ping", Way::Ping, Done),
        // One grows; one is as long as it was, however often it is continued.
        kind("WebSocket fragments", Way::Fragments(vec![b' '; 1000]), Silence),
        kind("WebSocket empty fragments", Way::Fragments(Vec::new()), Silence),
        kind("half a body", Way::Bytes(post.as_bytes().to_vec()), Silence),
        kind("half a head", Way::Bytes(half.as_bytes().to_vec()), Silence),
    ];
    for (path, packed) in [("/api/alarms/ack", "body"), ("/api/recordings/upload", "file")] {
        let way = http("POST", path, "Content-Encoding: gzip\r\n", vec![0x1f; 4000]);
        kinds.push(kind(&format!("packed {packed}"), way, Refused(415)));
    }
    for path in ["/", "/api/openapi.json", "/api/dictionary", "/api/monitors", "/metrics"] {
        let way = http("GET", path, "Accept-Encoding: gzip\r\n", Vec::new());
        kinds.push(kind(&format!("GET {path}, packed"), way, Done));
    }
    kinds
}

fn http(method: &str, path: &str, headers: &str, body: Vec<u8>) -> Way {
    let [method, path, headers] = [method, path, headers].map(str::to_owned);
    Way::Http { method, path, headers, body }
}

/// The kinds that only a hub with TLS is sent.
pub fn of_tls() -> Vec<Kind> {
    let kind = |name: &str, way, answered| Kind { name: name.to_owned(), way, answered };
    vec![
        kind("whole handshakes", Way::Handshake, Answered::Done),
        // A ClientHello of TLS 1.2 as it begins.
        kind(
            "half a handshake",
            Way::Bytes(b"\x16\x03\x01\x00\x7f\x01".to_vec()),
            Answered::Silence,
        ),
        kind("garbage for a handshake", Way::Bytes(vec![0xFF; 60_000]), Answered::Silence),
        kind("GET /api/hub over TLS", http("GET", "/api/hub", "", Vec::new()), Answered::Done),
    ]
}

/// A path with values in place of its names. What is removed is what the load made to be removed,
/// never what it needs itself.
fn filled(method: &str, path: &str) -> Option<String> {
    let number = |prefix: &str, suffix: &str| format!("{prefix}{NUMBER}{suffix}");
    let value = match (method, path.split('{').next()?) {
        ("DELETE", "/api/tokens/" | "/api/sessions/") => number("", ""),
        ("DELETE", "/api/users/") => number("user", ""),
        ("DELETE", "/api/recordings/") => number("load", ".mcap"),
        ("DELETE", "/api/updates/images/") => number("", ""),
        (_, "/api/users/") => "olga".to_owned(),
        (_, "/api/recordings/") => "seed.mcap".to_owned(),
        (_, "/api/monitors/") => "M1".to_owned(),
        (_, "/api/zones/") => "hall".to_owned(),
        (_, "/api/detectors/") => "flame".to_owned(),
        (_, "/api/pumps/") => "P".to_owned(),
        (_, whole) if whole == path => String::new(),
        _ => return None,
    };
    let names = path.split(['{', '}']).skip(1).step_by(2);
    let more = ["Vertical", "Speed"].map(str::to_owned);
    let mut filled = path.to_owned();
    for (name, value) in names.zip(std::iter::once(value).chain(more)) {
        filled = filled.replace(&format!("{{{name}}}"), &value);
    }
    (!filled.contains('{')).then_some(filled)
}
