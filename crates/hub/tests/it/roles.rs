//! Who may ask what of whom, over which interface: roles × requests × subsystems × interfaces, with
//! and without control authority.

use crate::support::{self, Site};
use lafet_hub::access::Role;
use lafet_proto::dictionary::REQUESTS;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// The least role of a request, and whether it needs authority; Stop, Close and Lockout on need
/// neither. Written out once more, on purpose: the code must agree with this.
const TABLE: &[(&str, &[&str], Role, bool)] = &[
    ("GetStatus", &["All", "Vertical", "Valve1", "General", "Control"], Role::Observer, false),
    ("GetParam", &["Vertical Speed", "General Address"], Role::Observer, false),
    ("RetrieveLimits", &["All", "Horizontal"], Role::Observer, false),
    ("GetHotbed", &["Detector"], Role::Observer, false),
    ("GetCrashData", &["General", "All"], Role::Observer, false),
    ("GetNetworkStatus", &["General"], Role::Observer, false),
    ("GetLog", &["General first=0 count=1"], Role::Observer, false),
    (
        "Stop",
        &["All", "Vertical", "Horizontal", "Nozzle", "Valve1", "Control", "Detector", "Deployer"],
        Role::Observer,
        false,
    ),
    ("Close", &["Valve1", "Valve2"], Role::Observer, false),
    ("Lockout", &["All on"], Role::Observer, false),
    ("Lockout", &["All off"], Role::Operator, true),
    ("Move", &["Vertical 10", "Horizontal -10", "Nozzle 5", "Deployer 0"], Role::Operator, true),
    ("Open", &["Valve1", "Valve2"], Role::Operator, true),
    ("Deploy", &["Deployer"], Role::Operator, true),
    ("Wrap", &["Deployer"], Role::Operator, true),
    ("StartSeek", &["Detector -60 60 -60 60"], Role::Operator, true),
    ("StartQuench", &["Control program=0 centre=0,0 nozzle=60"], Role::Operator, true),
    ("StartTrajectory", &["Control stored=0"], Role::Operator, true),
    ("SetParam", &["Vertical Speed 5", "General MoveTimeout 0"], Role::Engineer, true),
    ("SetupCorrectionTable", &["Control first=0 corrections=0,0"], Role::Engineer, true),
    ("SwitchLimits", &["Vertical on", "All on"], Role::Engineer, true),
    ("StartJustify", &["Detector"], Role::Engineer, true),
    ("Restart", &["All"], Role::Engineer, true),
    ("0x12", &["0x34 de ad"], Role::Engineer, true),
    // In numbers: Move, Open, CleanFlash with its key, Stop with data that are not its own.
    ("0x4d", &["Vertical 0a 00"], Role::Operator, true),
    ("0x21", &["Valve1 70 4c"], Role::Operator, true),
    ("0x16", &["General f6 a4", "General 00"], Role::Administrator, true),
    ("0x46", &["All 00"], Role::Engineer, true),
    ("CleanFlash", &["General"], Role::Administrator, true),
];

/// What the hub itself says; anything the monitor says means that it was sent.
fn verdict(error: &Value) -> &'static str {
    match error["code"].as_str() {
        Some("role") => "role",
        Some("no_authority") => "no_authority",
        Some("bad_request" | "confirm_needed" | "csrf" | "login_needed" | "slow_down") => "other",
        _ => "sent",
    }
}

fn expected(role: Role, least: Role, authority: bool, held: bool) -> &'static str {
    match () {
        () if role < least => "role",
        () if authority && !held => "no_authority",
        () => "sent",
    }
}

#[test]
fn every_request_is_in_the_table() {
    for info in &REQUESTS {
        // The controller's own belongs to no user.
        let listed = TABLE.iter().any(|(name, ..)| *name == info.name);
        assert!(listed || info.name == "AccessGranted", "{}", info.name);
    }
}

#[tokio::test]
async fn over_http() {
    for held in [false, true] {
        for role in Role::ALL {
            let site = Site::with(1, |_| {}).await;
            let token = site.token(role);
            if held && role >= Role::Operator {
                let taken = site
                    .post(&token, "/api/monitors/M1/authority", json!({ "action": "take" }))
                    .await;
                assert_eq!(taken.status, 200);
            }
            for (name, addressees, least, authority) in TABLE {
                for addressee in *addressees {
                    // Sent last, each to a fresh hub below: it restarts the monitor.
                    if ["Restart", "CleanFlash", "0x16"].contains(name) && role >= *least && held {
                        continue;
                    }
                    let request = format!("{name} {addressee}");
                    let body = json!({ "request": request, "confirm": "M1" });
                    let reply = site.post(&token, "/api/monitors/M1/requests", body).await;
                    let expected = expected(role, *least, *authority, held);
                    assert_eq!(
                        verdict(&reply.body["error"]),
                        expected,
                        "{request} {role:?} {held}: {reply:?}"
                    );
                }
            }
        }
    }
}

#[tokio::test]
async fn over_the_websocket() {
    for held in [false, true] {
        for role in Role::ALL {
            let site = Site::with(1, |_| {}).await;
            let token = site.token(role);
            let mut socket = site.ws(&token).await;
            if held {
                let taken = socket.authority("M1", "take").await;
                assert_eq!(taken["error"]["code"] == json!("role"), role < Role::Operator);
            }
            for (name, addressees, least, authority) in TABLE {
                for addressee in *addressees {
                    if ["Restart", "CleanFlash", "0x16"].contains(name) && role >= *least && held {
                        continue;
                    }
                    let request = format!("{name} {addressee}");
                    let asked = json!({
                        "type": "request", "monitor": "M1", "request": request, "confirm": "M1",
                    });
                    let answer = socket.ask(asked).await;
                    let expected = expected(role, *least, *authority, held);
                    assert_eq!(
                        verdict(&answer["error"]),
                        expected,
                        "{request} {role:?} {held}: {answer}"
                    );
                }
            }
        }
    }
}

/// The writer of the connection may wait for a slow client before it sees that.
#[tokio::test]
async fn who_was_removed_commands_nothing_more() {
    let site = Site::with(1, |_| {}).await;
    let (id, token) = site.hub.access().add_token(1, "scada", Role::Operator).unwrap();
    let mut socket = site.ws(&token).await;
    socket.authority("M1", "take").await;
    let up = json!({ "type": "request", "monitor": "M1", "request": "Move Vertical 900", "id": 1 });
    site.hub.access().remove_token(id).unwrap();
    socket.send(up).await;
    let closed = socket.next_where(|it| it["type"] == "closed" || it["type"] == "answer").await;
    assert_eq!(closed["code"], 4401, "{closed}");
    assert_eq!(site.bus.commanded(0, 0), 0);
}

#[tokio::test]
async fn what_restarts_the_monitor_is_sent_for_those_who_may() {
    for (request, role) in [
        ("Restart All", Role::Engineer),
        ("CleanFlash General", Role::Administrator),
        ("0x16 General f6 a4", Role::Administrator),
    ] {
        let site = Site::with(1, |_| {}).await;
        let token = site.token(role);
        site.post(&token, "/api/monitors/M1/authority", json!({ "action": "take" })).await;
        let ask = |body| site.post(&token, "/api/monitors/M1/requests", body);
        let refused = ask(json!({ "request": request })).await;
        if !request.starts_with("0x") {
            assert_eq!(refused.code(), "confirm_needed", "{refused:?}");
        }
        ask(json!({ "request": request, "confirm": "M1" })).await;
        support::until("it restarts", || site.bus.lock()[0].resets() > 0).await;
    }
}

#[tokio::test]
async fn addresses_of_the_api_have_their_roles() {
    let site = Site::with(1, |_| {}).await;
    let tokens = site.tokens();
    let table: &[(&str, &str, Value, Role)] = &[
        ("GET", "/api/monitors", json!({}), Role::Observer),
        ("GET", "/api/alarms", json!({}), Role::Observer),
        ("GET", "/api/hub", json!({}), Role::Observer),
        ("GET", "/metrics", json!({}), Role::Observer),
        ("POST", "/api/stop", json!({}), Role::Observer),
        ("POST", "/api/monitors/M1/stop", json!({ "of": "nonsense" }), Role::Observer),
        ("POST", "/api/monitors/M1/close", json!({}), Role::Observer),
        ("POST", "/api/monitors/M1/lockout", json!({}), Role::Observer),
        ("GET", "/api/audit", json!({}), Role::Operator),
        ("GET", "/api/audit/verify", json!({}), Role::Operator),
        ("POST", "/api/alarms/ack", json!({}), Role::Operator),
        ("POST", "/api/pumps/P1", json!({ "on": true }), Role::Operator),
        ("GET", "/api/audit/export", json!({}), Role::Engineer),
        ("GET", "/api/users", json!({}), Role::Administrator),
        ("POST", "/api/tokens", json!({ "name": "x", "role": "observer" }), Role::Administrator),
        ("DELETE", "/api/tokens/999", json!({}), Role::Administrator),
    ];
    for (method, path, body, least) in table {
        for (role, token) in &tokens {
            let header = format!("Bearer {token}");
            let headers = [("Authorization", header.as_str())];
            let reply = site.http(method, path, &headers, &body.to_string()).await;
            assert_eq!(reply.code() == "role", role < least, "{method} {path} {role:?}: {reply:?}");
        }
        let reply = site.http(method, path, &[], &body.to_string()).await;
        assert_eq!((reply.status, reply.code()), (401, "login_needed"), "{path}");
    }
}

/// Rights that were revoked before the body of a request has come are none.
#[tokio::test]
async fn a_body_that_is_kept_back_keeps_no_rights() {
    let site = Site::open(1).await;
    let user = json!({ "user": "eve", "role": "administrator", "password": "seven tall pines" });
    let command = json!({ "request": "GetStatus All" });
    for (path, body) in [("users", user), ("monitors/M1/requests", command)] {
        let (id, secret) = site.hub.access().add_token(1, "late", Role::Administrator).unwrap();
        let body = body.to_string();
        let head = format!(
            "POST /api/{path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer {secret}\r\n\
             Content-Type: application/json\r\nContent-Length: {}\r\n\r\n",
            body.len()
        );
        let mut stream = TcpStream::connect(site.address).await.unwrap();
        stream.write_all(head.as_bytes()).await.unwrap();
        tokio::time::sleep(std::time::Duration::from_millis(200)).await;
        site.hub.access().remove_token(id).unwrap();
        stream.write_all(body.as_bytes()).await.unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).await.unwrap();
        assert!(answer.starts_with("HTTP/1.1 401 "), "{path}: {answer}");
    }
    let users = site.hub.access().users().unwrap();
    assert!(users.iter().all(|it| it.user != "eve"));
}

/// A token is revoked at once, though one who hashes a password waits for the disk.
#[tokio::test]
async fn a_revocation_waits_for_nothing_that_is_slow() {
    let site = Site::open(1).await;
    let (admin, (id, stolen)) = (
        site.token(Role::Administrator),
        site.hub.access().add_token(1, "stolen", Role::Operator).unwrap(),
    );
    let _turn = site.hub.hashing().take(0).await.unwrap();
    let path = format!("/api/tokens/{id}");
    let headers = [("Authorization", &*format!("Bearer {admin}"))];
    let removed = site.http("DELETE", &path, &headers, "");
    let removed = tokio::time::timeout(std::time::Duration::from_secs(5), removed).await;
    assert_eq!(removed.unwrap().status, 204);
    assert_eq!(site.get(&stolen, "/api/monitors").await.status, 401);
}
