//! Coming in: the first start, logging in, other people's pages, certificates.

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use lafet_hub::access::Role;
use lafet_hub::{Clock, TlsConfig};
use serde_json::json;
use support::{PASSWORD, Reply, Site, http_over, until};
use tokio::net::TcpStream;

async fn log_in(site: &Site, user: &str, password: &str) -> Reply {
    let body = json!({ "user": user, "password": password }).to_string();
    site.http("POST", "/api/login", &[], &body).await
}

fn cookie(reply: &Reply) -> String {
    reply.header("set-cookie").unwrap().split(';').next().unwrap().to_owned()
}

#[tokio::test]
async fn the_first_start() {
    let site = Site::with(1, |_| {}).await;
    let nobody = site.get("", "/api/session").await;
    assert_eq!((nobody.status, nobody.code()), (401, "login_needed"));
    assert_eq!(nobody.body["error"]["setup_needed"], true);
    let link = site.hub.access.setup_link().unwrap().unwrap();
    let body =
        |token: &str| json!({ "token": token, "user": "root", "password": PASSWORD }).to_string();
    let made = site.http("POST", "/api/setup", &[], &body(&link)).await;
    assert_eq!((made.status, &made.body["role"]), (200, &json!("administrator")), "{made:?}");
    let flags = made.header("set-cookie").unwrap();
    assert!(flags.contains("HttpOnly") && flags.contains("SameSite=Strict"), "{flags}");
    let again = site.http("POST", "/api/setup", &[], &body(&link)).await;
    assert_eq!(again.status, 401);
    let session = site.http("GET", "/api/session", &[("Cookie", &cookie(&made))], "").await;
    assert_eq!(session.body["user"], "root");
    let log = site.hub.audit.latest(None, 10, None, None).await.unwrap();
    assert!(log.iter().any(|it| it.record.what == "login" && it.record.user == "root"));
}

#[tokio::test]
async fn csrf_and_stale_sessions() {
    let now_ms = Arc::new(AtomicU64::new(1_000_000_000_000));
    let site = Site::at(1, Clock::Manual(now_ms.clone()), |_| {}).await;
    site.hub.access.add(1, "anna", Role::Operator, PASSWORD).unwrap();
    let login = log_in(&site, "anna", PASSWORD).await;
    let (cookie, csrf) = (cookie(&login), login.body["csrf"].as_str().unwrap().to_owned());
    let take = json!({ "action": "take" }).to_string();
    let path = "/api/monitors/M1/authority";
    let without = site.http("POST", path, &[("Cookie", &cookie)], &take).await;
    assert_eq!((without.status, without.code()), (403, "csrf"));
    let headers = [("Cookie", cookie.as_str()), ("X-CSRF-Token", csrf.as_str())];
    assert_eq!(site.http("POST", path, &headers, &take).await.status, 200);
    let request = json!({ "request": "Move Vertical 5" }).to_string();
    let moved =
        site.http("POST", "/api/monitors/M1/requests", &[("Cookie", &cookie)], &request).await;
    assert_eq!(moved.code(), "csrf");
    // Stop needs no token, and a session that ran out lately will do; nothing else.
    now_ms.fetch_add(13 * 3_600_000, Ordering::Relaxed);
    let stop = site.http("POST", "/api/stop", &[("Cookie", &cookie)], "garbage").await;
    assert_eq!(stop.status, 200, "{stop:?}");
    assert_eq!(stop.body["M1"]["ok"], true);
    assert_eq!(site.http("POST", path, &headers, &take).await.status, 401);
    assert_eq!(site.http("GET", "/api/session", &headers, "").await.status, 401);
    let asked = site.http("POST", "/api/monitors/M1/requests", &headers, &request).await;
    assert_eq!(asked.code(), "role");
    now_ms.fetch_add(24 * 3_600_000, Ordering::Relaxed);
    assert_eq!(site.http("POST", "/api/stop", &headers, "").await.status, 401);
}

#[tokio::test]
async fn failures_make_the_next_try_wait() {
    let site = Site::with(1, |_| {}).await;
    site.hub.access.add(1, "anna", Role::Operator, PASSWORD).unwrap();
    assert_eq!(log_in(&site, "anna", "wrong").await.code(), "login_failed");
    let second = log_in(&site, "anna", PASSWORD).await;
    assert_eq!((second.status, second.code()), (429, "slow_down"));
    assert!(second.header("retry-after").is_some());
    assert_eq!(
        log_in(&site, "boris", "wrong").await.code(),
        "login_failed",
        "others are not held up"
    );
}

#[tokio::test]
async fn other_peoples_pages_and_names() {
    let site = Site::with(1, |config| {
        config.login = false;
        config.origins = vec!["https://scada.example".into()];
        config.names = vec!["hub.example".into()];
    })
    .await;
    let own = format!("http://{}", site.address);
    let cases: &[(&[(&str, &str)], &str)] = &[
        (&[("Origin", &own)], ""),
        (&[("Origin", "https://scada.example")], ""),
        (&[("Origin", "https://evil.example")], "bad_origin"),
        (&[("Origin", "null")], "bad_origin"),
        (&[("Host", "hub.example:8480")], ""),
        (&[("Host", "localhost")], ""),
        (&[("Host", "[::1]:80")], ""),
        (&[("Host", "rebound.example")], "bad_host"),
        (&[("Host", "hub.example"), ("Origin", "http://hub.example")], ""),
    ];
    for (headers, code) in cases {
        for (method, path) in [("GET", "/api/session"), ("POST", "/api/stop"), ("GET", "/api/ws")] {
            let reply = site.http(method, path, headers, "").await;
            assert_eq!(reply.code(), *code, "{headers:?} {path}: {reply:?}");
        }
    }
}

#[tokio::test]
async fn too_much_and_nonsense() {
    let site = Site::open(1).await;
    let long = format!("{{\"request\": \"{}\"}}", "x".repeat(100_000));
    let reply = site.http("POST", "/api/monitors/M1/requests", &[], &long).await;
    assert_eq!((reply.status, reply.code()), (413, "too_large"));
    let stop = site.http("POST", "/api/monitors/M1/stop", &[], &long).await;
    assert_eq!(stop.status, 200, "Stop is not refused for its size: {stop:?}");
    for (path, body) in [
        ("/api/monitors/M1/requests", "{"),
        ("/api/monitors/M1/requests", "{}"),
        ("/api/monitors/M1/requests", r#"{"request":"Dance All"}"#),
        ("/api/monitors/M1/authority", r#"{"action":"steal"}"#),
        ("/api/monitors/M1/jog", r#"{"drive":"Deployer","toward":"up"}"#),
    ] {
        let reply = site.http("POST", path, &[], body).await;
        assert_eq!((reply.status, reply.code()), (400, "bad_request"), "{path} {body}");
        assert!(reply.body["error"]["ru"].as_str().unwrap().contains(|c| ('а'..='я').contains(&c)));
    }
    assert_eq!(site.http("POST", "/api/monitors/M9/stop", &[], "").await.code(), "no_monitor");
    assert_eq!(site.get("", "/api/nothing").await.code(), "not_found");
}

#[tokio::test]
async fn many_requests_are_slowed_down_but_never_stop() {
    let site = Site::with(1, |_| {}).await;
    let token = site.token(Role::Observer);
    // All at once: one after the other they would not come too fast on a slow machine.
    let body = json!({ "request": "GetStatus General" });
    let asks = (0..300).map(|_| site.post(&token, "/api/monitors/M1/requests", body.clone()));
    let replies = futures_util::future::join_all(asks).await;
    let slowed = replies.iter().filter(|reply| reply.code() == "slow_down").count();
    assert!(slowed > 50, "{slowed}");
    let stop = site.post(&token, "/api/monitors/M1/stop", json!({})).await;
    assert_eq!(stop.status, 200);
    let stop = json!({ "request": "Stop All" });
    for _ in 0..150 {
        assert_eq!(site.post(&token, "/api/monitors/M1/requests", stop.clone()).await.status, 200);
    }
    assert!(site.hub.count_of_commands() >= 250);
}

#[tokio::test]
async fn certificates_of_our_own_and_of_clients() {
    use rcgen::{BasicConstraints, CertificateParams, DnType, IsCa, Issuer, KeyPair};
    use tokio_rustls::TlsConnector;
    use tokio_rustls::rustls::pki_types::{PrivateKeyDer, ServerName};
    use tokio_rustls::rustls::{ClientConfig, RootCertStore, crypto};

    let folder = std::env::temp_dir().join(format!("lafet-tls-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut params = CertificateParams::new(vec![]).unwrap();
    params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let ca_key = KeyPair::generate().unwrap();
    let ca = params.self_signed(&ca_key).unwrap();
    let issuer = Issuer::new(params, ca_key);
    let leaf = |name: &str| {
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(vec!["localhost".into()]).unwrap();
        params.distinguished_name.push(DnType::CommonName, name);
        (params.signed_by(&key, &issuer).unwrap(), key)
    };
    let (server, server_key) = leaf("hub");
    std::fs::write(folder.join("ca.pem"), ca.pem()).unwrap();
    std::fs::write(folder.join("cert.pem"), server.pem()).unwrap();
    std::fs::write(folder.join("key.pem"), server_key.serialize_pem()).unwrap();
    let site = Site::with(1, |config| {
        config.tls = Some(TlsConfig {
            cert: folder.join("cert.pem"),
            key: folder.join("key.pem"),
            client_ca: Some(folder.join("ca.pem")),
            client_roles: [("scada".to_owned(), Role::Operator)].into(),
        });
    })
    .await;
    let connect = |client: Option<&str>| {
        let mut roots = RootCertStore::empty();
        roots.add(ca.der().clone()).unwrap();
        let builder =
            ClientConfig::builder_with_provider(Arc::new(crypto::ring::default_provider()))
                .with_safe_default_protocol_versions()
                .unwrap()
                .with_root_certificates(roots);
        let config = match client {
            None => builder.with_no_client_auth(),
            Some(name) => {
                let (certificate, key) = leaf(name);
                let key = PrivateKeyDer::try_from(key.serialize_der()).unwrap();
                builder.with_client_auth_cert(vec![certificate.der().clone()], key).unwrap()
            }
        };
        let address = site.address;
        async move {
            let stream = TcpStream::connect(address).await.unwrap();
            let name = ServerName::try_from("localhost").unwrap();
            TlsConnector::from(Arc::new(config)).connect(name, stream).await
        }
    };
    let stream = connect(Some("scada")).await.unwrap();
    let reply = http_over(stream, "localhost", "GET", "/api/session", &[], "").await;
    assert_eq!(
        (&reply.body["user"], &reply.body["kind"]),
        (&json!("scada"), &json!("certificate"))
    );
    assert_eq!(reply.body["role"], "operator");
    let stream = connect(Some("stranger")).await.unwrap();
    let reply = http_over(stream, "localhost", "GET", "/api/session", &[], "").await;
    assert_eq!(reply.code(), "login_needed");
    // Without a certificate the connection ends, at the latest when it is used.
    if let Ok(stream) = connect(None).await {
        assert_eq!(http_over(stream, "localhost", "GET", "/health", &[], "").await.status, 0);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Logs in, and tells whom that comes from, as the audit log has it.
async fn origin_of(site: &Site, headers: &[(&str, &str)]) -> String {
    let body = json!({ "user": "anna", "password": PASSWORD }).to_string();
    assert_eq!(site.http("POST", "/api/login", headers, &body).await.status, 200);
    until("it is noted", || site.hub.audit.waiting() == 0).await;
    let log = site.hub.audit.latest(None, 1, None, None).await.unwrap();
    log[0].record.from.clone()
}

#[tokio::test]
async fn a_proxy_of_ours_tells_for_whom_it_asks_and_nobody_else_does() {
    let told = [("X-Forwarded-For", "6.6.6.6, 10.0.0.5, 127.0.0.1")];
    let site = Site::with(1, |_| {}).await;
    site.hub.access.add(1, "anna", Role::Operator, PASSWORD).unwrap();
    assert_eq!(origin_of(&site, &told).await, "127.0.0.1");
    let site = Site::with(1, |config| config.proxies = vec!["127.0.0.1".parse().unwrap()]).await;
    site.hub.access.add(1, "anna", Role::Operator, PASSWORD).unwrap();
    assert_eq!(origin_of(&site, &told).await, "10.0.0.5", "6.6.6.6 may be a lie");
    assert_eq!(origin_of(&site, &[("X-Forwarded-For", "rubbish")]).await, "127.0.0.1");
    assert_eq!(origin_of(&site, &[]).await, "127.0.0.1");
    let https = [("X-Forwarded-Proto", "https"), ("X-Forwarded-For", "10.0.0.8")];
    let body = json!({ "user": "anna", "password": PASSWORD }).to_string();
    let login = site.http("POST", "/api/login", &https, &body).await;
    assert!(login.header("set-cookie").unwrap().ends_with("; Secure"), "{login:?}");
    // Who fails behind the proxy shuts nobody else out.
    let from = |address| [("X-Forwarded-For", address)];
    let wrong = json!({ "user": "anna", "password": "wrong" }).to_string();
    let failed = site.http("POST", "/api/login", &from("10.0.0.6"), &wrong).await;
    let again = site.http("POST", "/api/login", &from("10.0.0.6"), &wrong).await;
    assert_eq!((failed.status, again.status), (401, 429));
    assert_eq!(origin_of(&site, &from("10.0.0.7")).await, "10.0.0.7");
}

#[tokio::test]
async fn reading_has_its_own_limit_and_stops_have_none() {
    let site = Site::with(1, |_| {}).await;
    let token = site.token(Role::Operator);
    let reader = site.hub.access.by_token(1, &token).unwrap();
    let mut refused = false;
    for _ in 0..200 {
        // The bucket is filled again while this machine does something else.
        while site.hub.count_reading(&reader).is_ok() {}
        let reply = site.get(&token, "/api/hub").await;
        refused |= (reply.status, reply.code()) == (429, "slow_down");
        if refused {
            break;
        }
    }
    assert!(refused, "who reads too much is told so");
    while site.hub.count_reading(&reader).is_ok() {}
    drop(site.ws(&token).await);
    let stop = site.post(&token, "/api/monitors/M1/stop", json!({})).await;
    assert_eq!(stop.status, 200, "{stop:?}");
    let take = site.post(&token, "/api/monitors/M1/authority", json!({ "action": "take" })).await;
    assert_eq!(take.status, 200, "{take:?}");
}

#[tokio::test]
async fn one_address_does_not_take_every_connection() {
    let site = Site::with(1, |config| config.connections_max = 8).await;
    let token = site.token(Role::Observer);
    let before = site.hub.counts.connections.load(Ordering::Relaxed);
    assert_eq!(before, 0);
    let mut held = Vec::new();
    for _ in 0..6 {
        held.push(TcpStream::connect(site.address).await.unwrap());
    }
    let open = || site.hub.counts.connections.load(Ordering::Relaxed);
    until("they are taken", || open() == 6).await;
    let mut seventh = TcpStream::connect(site.address).await.unwrap();
    let closed = tokio::io::AsyncReadExt::read(&mut seventh, &mut [0; 1]).await;
    assert!(!matches!(closed, Ok(1..)), "closed at once");
    // Another machine still comes through.
    let other = tokio::net::TcpSocket::new_v4().unwrap();
    other.bind("127.0.0.2:0".parse().unwrap()).unwrap();
    let other = other.connect(site.address).await.unwrap();
    let authorization = format!("Bearer {token}");
    let headers = [("Authorization", authorization.as_str())];
    let stop = http_over(other, "127.0.0.1", "POST", "/api/stop", &headers, "").await;
    assert_eq!(stop.status, 200, "{stop:?}");
    drop(held);
    until("they are given back", || open() == 0).await;
    assert_eq!(site.post(&token, "/api/stop", json!({})).await.status, 200);
}
