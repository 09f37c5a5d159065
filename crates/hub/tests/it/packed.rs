//! Answers packed with gzip: which are, which are not, and that nothing packed is taken.

use std::io::Read;

use crate::support::{PASSWORD, Site};
use flate2::read::GzDecoder;
use lafet_hub::access::Role;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// The head of an answer, and its body as it came.
async fn ask(site: &Site, what: &str, headers: &str) -> (String, Vec<u8>) {
    let mut stream = TcpStream::connect(site.address).await.unwrap();
    let request =
        format!("{what} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{headers}\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut all = Vec::new();
    stream.read_to_end(&mut all).await.unwrap();
    let end = all.windows(4).position(|it| it == b"\r\n\r\n").unwrap();
    (String::from_utf8_lossy(&all[..end]).to_lowercase(), all.split_off(end + 4))
}

async fn packed(site: &Site, path: &str, headers: &str) -> Option<Vec<u8>> {
    let headers = format!("{headers}Accept-Encoding: br, gzip\r\n");
    let (head, body) = ask(site, &format!("GET {path}"), &headers).await;
    assert!(head.starts_with("http/1.1 200"), "{path}: {head}");
    if !head.contains("content-encoding: gzip") {
        return None;
    }
    assert!(head.contains("vary: accept-encoding"), "{head}");
    assert!(head.contains(&format!("content-length: {}", body.len())), "{head}");
    let (mut plain, len) = (Vec::new(), body.len());
    GzDecoder::new(body.as_slice()).read_to_end(&mut plain).unwrap();
    assert!(len * 2 < plain.len(), "{path}: {len} of {}", plain.len());
    Some(plain)
}

#[tokio::test]
async fn texts_are_packed_for_who_takes_them() {
    let site = Site::open(3).await;
    for path in ["/api/openapi.json", "/api/monitors", "/metrics"] {
        let (head, plain) = ask(&site, &format!("GET {path}"), "").await;
        assert!(!head.contains("content-encoding"), "{head}");
        assert!(head.contains("vary: accept-encoding"), "{head}");
        let unpacked = packed(&site, path, "").await.unwrap();
        if path == "/api/openapi.json" {
            assert!(unpacked == plain && packed(&site, path, "").await == Some(plain));
        }
    }
}

/// What reveals a secret, what is small, what changes something.
#[tokio::test]
async fn the_rest_is_not() {
    let site = Site::with(1, |_| {}).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    let login = json!({ "user": "anna", "password": PASSWORD }).to_string();
    let reply = site.http("POST", "/api/login", &[("Accept-Encoding", "gzip")], &login).await;
    assert_eq!((reply.status, reply.header("content-encoding")), (200, None));
    let cookie = reply.header("set-cookie").unwrap().split(';').next().unwrap().to_owned();
    let cookie = format!("Cookie: {cookie}\r\n");
    assert!(packed(&site, "/api/session", &cookie).await.is_none());
    assert!(packed(&site, "/api/tokens", &bearer(&site)).await.is_none(), "small");
}

fn bearer(site: &Site) -> String {
    format!("Authorization: Bearer {}\r\n", site.token(Role::Administrator))
}

#[tokio::test]
async fn packed_bodies_are_refused_and_hold_no_stop_up() {
    let site = Site::open(1).await;
    let packed = [("Content-Encoding", "gzip")];
    for path in ["/api/alarms/ack", "/api/recordings/upload", "/api/monitors/M1/authority"] {
        let reply = site.http("POST", path, &packed, "\u{1f}").await;
        assert_eq!((reply.status, reply.code()), (415, "packed"), "{path}: {reply:?}");
        let both = ["en", "ru"].map(|it| reply.body["error"][it].is_string());
        assert_eq!(both, [true, true]);
    }
    let stopped = site.http("POST", "/api/monitors/M1/stop", &packed, "\u{1f}").await;
    assert_eq!((stopped.status, &stopped.body["ok"]), (200, &Value::Bool(true)), "{stopped:?}");
    let plain = [("Content-Encoding", "identity")];
    let taken =
        site.http("POST", "/api/monitors/M1/authority", &plain, r#"{"action":"take"}"#).await;
    assert_eq!(taken.status, 200, "{taken:?}");
}
