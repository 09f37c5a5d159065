//! Coming in: the first start, logging in, other people's pages, certificates.

mod certificates;
mod logins;

use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use crate::support::{PASSWORD, PATIENCE, Reply, Site, http_over, until};
use futures_util::future::join_all;
use lafet_hub::access::Role;
use lafet_hub::{Clock, ManualTime, TlsConfig};
use rcgen::{BasicConstraints, CertificateParams, DnType, IsCa, Issuer, KeyPair};
use serde_json::json;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, timeout};
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::pki_types::{PrivateKeyDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore, crypto};

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
    let link = site.hub.access().setup_link().unwrap().unwrap();
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
    let log = site.hub.audit().latest(None, 10, None, None).await.unwrap();
    assert!(log.iter().any(|it| it.record.what == "login" && it.record.user == "root"));
    let csrf = made.body["csrf"].as_str().unwrap();
    let own = cookie(&made);
    let headers = [("Cookie", own.as_str()), ("X-CSRF-Token", csrf)];
    assert_eq!(site.http("POST", "/api/logout", &headers, "").await.status, 204);
    let log = site.hub.audit().latest(None, 10, None, None).await.unwrap();
    let of = |what: &str| -> Vec<(String, String)> {
        let of = log.iter().map(|it| &it.record).filter(|it| it.what == what);
        of.map(|it| (it.user.clone(), it.outcome.clone())).collect()
    };
    let [none, root] = ["", "root"].map(str::to_owned);
    let tries = [(none, "refused".to_owned()), (root.clone(), "Ok".to_owned())];
    assert_eq!(of("set up"), tries, "the latest first");
    assert_eq!(of("logout"), [(root, "Ok".to_owned())]);
}

/// Without login a proxy on this machine would make every stranger an administrator.
#[tokio::test]
async fn without_login_nothing_is_believed_that_a_proxy_passes_on() {
    let site = Site::open(1).await;
    let get = async |name: &str, value: &str| {
        site.http("GET", "/api/monitors", &[(name, value)], "").await.status
    };
    for (name, value) in [
        ("X-Forwarded-For", "127.0.0.1"),
        ("x-forwarded-proto", "https"),
        ("X-Real-IP", "127.0.0.1"),
        ("Forwarded", "for=127.0.0.1"),
        ("Via", "1.1 proxy"),
    ] {
        assert_eq!(get(name, value).await, 401, "{name}");
        let stop = site.http("POST", "/api/stop", &[(name, value)], "").await;
        assert_eq!(stop.status, 401, "{name}");
    }
    assert_eq!(get("Accept", "*/*").await, 200);
}

#[tokio::test]
async fn csrf_and_stale_sessions() {
    let time = ManualTime::at(1_000_000_000_000);
    let site = Site::at(1, Clock::Manual(time.clone()), |_| {}).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
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
    time.pass(13 * 3_600_000);
    let stop = site.http("POST", "/api/stop", &[("Cookie", &cookie)], "garbage").await;
    assert_eq!(stop.status, 200, "{stop:?}");
    assert_eq!(stop.body["M1"]["ok"], true);
    assert_eq!(site.http("POST", path, &headers, &take).await.status, 401);
    assert_eq!(site.http("GET", "/api/session", &headers, "").await.status, 401);
    let asked = site.http("POST", "/api/monitors/M1/requests", &headers, &request).await;
    assert_eq!(asked.code(), "role");
    time.pass(24 * 3_600_000);
    assert_eq!(site.http("POST", "/api/stop", &headers, "").await.status, 401);
}

#[tokio::test]
async fn a_clock_that_jumps_ends_no_session_and_is_recorded() {
    let time = ManualTime::at(1_700_000_000_000);
    let site = Site::at(1, Clock::Manual(time.clone()), |_| {}).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    let cookie = cookie(&log_in(&site, "anna", PASSWORD).await);
    let headers = [("Cookie", cookie.as_str())];
    let mut socket = site.ws_as(&[("Cookie", &cookie)]).await;
    let month = 30 * 24 * 3_600_000;
    let recorded = |by_ms: i64| {
        let hub = site.hub.clone();
        async move {
            let log = hub.audit().latest(None, 50, None, None).await.unwrap();
            let step = json!({ "v": 1, "type": "clock_step", "by_ms": by_ms });
            let acts: Vec<_> = log.iter().filter_map(|it| it.record.act.clone()).collect();
            assert!(acts.contains(&step), "{acts:?}");
        }
    };
    for (date_ms, by_ms) in
        [(1_700_000_000_000 + month, 30), (1_700_000_000_000, -30), (1_600_000_000_000, 0)]
    {
        time.set_date(date_ms);
        let event = socket.next_of("event").await;
        assert!(event["what"]["en"].as_str().unwrap().contains("clock"), "{event}");
        if by_ms != 0 {
            recorded(by_ms * 24 * 3_600_000).await;
        }
        let session = site.http("GET", "/api/session", &headers, "").await;
        assert_eq!(session.status, 200, "{session:?}");
        assert_eq!(site.http("POST", "/api/stop", &headers, "").await.status, 200);
        let stop = socket.ask(json!({ "type": "stop", "monitor": "M1" })).await;
        assert_eq!(stop["result"]["ok"], true, "{stop}");
    }
}

/// What has a time left has the same time left after the date was set.
#[tokio::test]
async fn a_clock_that_jumps_moves_what_is_under_way() {
    let start_ms = 1_700_000_000_000;
    let time = ManualTime::at(start_ms);
    let site = Site::at(1, Clock::Manual(time.clone()), |_| {}).await;
    let token = site.token(Role::Engineer);
    let mut socket = site.ws(&token).await;
    site.post(&token, "/api/monitors/M1/lockout", json!({})).await;
    socket.until("locked out", |it| it.contains_key("alarms/M1/General/LockedOut")).await;
    let shelf = json!({ "id": "M1/General/LockedOut", "minutes": 5, "reason": "exercise" });
    let shelved = site.post(&token, "/api/alarms/shelve", shelf).await;
    assert_eq!(shelved.status, 200, "{shelved:?}");
    let until_ms = shelved.body["shelved"]["until_ms"].as_u64().unwrap();
    let begun = site.post(&token, "/api/recordings", json!({ "seconds": 60 })).await;
    assert_eq!(begun.status, 201, "{begun:?}");
    let month_ms = 30 * 24 * 3_600_000;
    time.set_date(start_ms + month_ms);
    let told = |known: &serde_json::Map<String, serde_json::Value>| {
        known["alarms/M1/General/LockedOut"]["shelved"]["until_ms"] == until_ms + month_ms
    };
    socket.until("the shelf is as long as it was", told).await;
    assert_eq!(socket.known["alarms/M1/General/LockedOut"]["state"], "shelved");
    let recordings = site.get(&token, "/api/recordings").await;
    assert_eq!(recordings.body[0]["recording"], true, "{recordings:?}");
    // And back: the shelf does not last for a month more.
    time.set_date(start_ms);
    let told = |known: &serde_json::Map<String, serde_json::Value>| {
        known["alarms/M1/General/LockedOut"]["shelved"]["until_ms"] == until_ms
    };
    socket.until("the shelf is as long as it was", told).await;
}

/// The page of a session that was ended by others is open, a user looks at a monitor: Stop works,
/// what shuts the water of a fire does not.
#[tokio::test]
async fn who_was_signed_out_by_others_can_stop_for_ten_minutes() {
    let time = ManualTime::at(1_000_000_000_000);
    let site = Site::at(1, Clock::Manual(time.clone()), |_| {}).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    let login = log_in(&site, "anna", PASSWORD).await;
    let cookie = cookie(&login);
    let headers = [("Cookie", cookie.as_str())];
    let mut socket = site.ws_as(&[("Cookie", &cookie)]).await;
    let root = site.token(Role::Administrator);
    let path = format!("/api/sessions/{}", login.body["seat"].as_str().unwrap());
    let authorization = format!("Bearer {root}");
    let ended = site.http("DELETE", &path, &[("Authorization", &authorization)], "").await;
    assert_eq!(ended.status, 204);
    assert_eq!(socket.next_of("closed").await["code"], 4401);
    let session = site.http("GET", "/api/session", &headers, "").await;
    assert_eq!((session.status, &session.body["error"]["standing"]), (401, &json!("ended")));
    assert_eq!(session.body["error"]["left_ms"], 600_000);
    let post = |path: &'static str, body: &'static str| site.http("POST", path, &headers, body);
    let stop = post("/api/stop", "").await;
    assert_eq!((stop.status, &stop.body["M1"]["ok"]), (200, &json!(true)));
    assert_eq!(post("/api/monitors/M1/stop", "").await.status, 200);
    for (path, body) in [
        ("/api/monitors/M1/close", ""),
        ("/api/monitors/M1/lockout", ""),
        ("/api/monitors/M1/requests", r#"{"request":"Close Valve1"}"#),
        ("/api/monitors/M1/requests", r#"{"request":"Move Vertical 5"}"#),
    ] {
        let refused = post(path, body).await;
        assert!(matches!(refused.status, 401 | 403), "{path}: {refused:?}");
    }
    assert_eq!(post("/api/lockout", "").await.body["M1"]["error"]["code"], "login_needed");
    time.pass(10 * 60_000);
    assert_eq!(post("/api/stop", "").await.status, 401);
}

#[tokio::test]
async fn a_password_that_is_guessed_first_is_refused_with_words() {
    let site = Site::with(1, |config| config.login = false).await;
    for password in ["aaaaaaaaaa", "1234567890", "short"] {
        let body = json!({ "user": "anna", "role": "operator", "password": password });
        let reply = site.post("", "/api/users", body).await;
        assert_eq!((reply.status, &reply.body["error"]["field"]), (400, &json!("password")));
        let ru = reply.body["error"]["ru"].as_str().unwrap();
        assert!(ru.to_lowercase().contains("пароль"), "{ru}");
    }
    let body = json!({ "user": "r\u{43e}ot", "role": "operator", "password": PASSWORD });
    let reply = site.post("", "/api/users", body).await;
    assert_eq!((reply.status, &reply.body["error"]["field"]), (400, &json!("user")));
    let added = json!({ "user": "root", "role": "administrator", "password": PASSWORD });
    assert_eq!(site.post("", "/api/users", added).await.status, 201);
    let token = json!({ "name": "root", "role": "operator" });
    assert_eq!(site.post("", "/api/tokens", token).await.status, 409, "it would pass for the user");
    let log = site.hub.audit().latest(None, 9, None, None).await.unwrap();
    let act = json!({ "v": 1, "type": "add_user", "user": "root", "role": "administrator" });
    let entry = log.iter().find(|it| it.record.act.as_ref() == Some(&act)).unwrap();
    assert_eq!(entry.record.kind, Some(lafet_hub::access::Kind::Demo));
}

/// Guesses from everywhere hold up strangers; not a device on which the user has logged in.
#[tokio::test]
async fn guesses_shut_nobody_out_who_was_here_before() {
    let site = Site::with(1, |config| config.proxies = vec!["127.0.0.1".parse().unwrap()]).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    let log_in = |password: &str, address: String, device: String| {
        let body = json!({ "user": "anna", "password": password }).to_string();
        let site = &site;
        async move {
            let headers = [("X-Forwarded-For", address.as_str()), ("Cookie", device.as_str())];
            site.http("POST", "/api/login", &headers, &body).await
        }
    };
    let first = log_in(PASSWORD, "10.0.0.1".into(), String::new()).await;
    let device = first.headers.lines().find_map(|it| it.split_once("lafet_device_0=")).unwrap().1;
    let device = format!("lafet_device_0={}", device.split(';').next().unwrap());
    for n in 0..12 {
        log_in("wrong", format!("6.6.6.{n}"), String::new()).await;
    }
    let elsewhere = log_in(PASSWORD, "7.7.7.7".into(), String::new()).await;
    assert_eq!(elsewhere.code(), "slow_down");
    assert_eq!(log_in(PASSWORD, "8.8.8.8".into(), device).await.status, 200);
    assert_eq!(log_in(PASSWORD, "10.0.0.1".into(), String::new()).await.status, 200);
    let alarm = || site.hub.alarms().get("hub/Logins").is_some_and(|it| it.active);
    until("it is an alarm", alarm).await;
}

/// Guesses at many accounts from many addresses, all at once: who logs in from a device of his own
/// waits for the hash that is under way, who logs in for the first time for at most those that have
/// failed as rarely as he.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_right_login_is_not_behind_wrong_tries() {
    const WRONG: usize = 320;
    let site = Site::with(1, |config| config.proxies = vec!["127.0.0.1".parse().unwrap()]).await;
    for user in ["anna", "boris"] {
        site.hub.access().add(1, user, Role::Operator, PASSWORD).unwrap();
    }
    let log_in = async |user: &str, password: &str, address: &str, device: &str| {
        let body = json!({ "user": user, "password": password }).to_string();
        let headers = [("X-Forwarded-For", address), ("Cookie", device)];
        site.http("POST", "/api/login", &headers, &body).await
    };
    let began = Instant::now();
    let first = log_in("anna", PASSWORD, "10.0.0.1", "").await;
    let alone = began.elapsed();
    let device = first.headers.lines().find_map(|it| it.split_once("lafet_device_0=")).unwrap().1;
    let device = format!("lafet_device_0={}", device.split(';').next().unwrap());
    let wrong = async |number: usize| {
        let (user, from) = (format!("somebody{}", number % 80), format!("6.6.6.{}", number % 40));
        log_in(&user, "wrong and long enough", &from, "").await.status
    };
    let right = async {
        let failed = &site.hub.counts().logins_failed;
        until("they are under way", || failed.load(Ordering::Relaxed) > 0).await;
        let began = Instant::now();
        assert_eq!(log_in("anna", PASSWORD, "8.8.8.8", &device).await.status, 200);
        let known = began.elapsed();
        let began = Instant::now();
        assert_eq!(log_in("boris", PASSWORD, "9.9.9.9", "").await.status, 200);
        (known, began.elapsed())
    };
    let (statuses, (known, new)) = tokio::join!(join_all((0..WRONG).map(wrong)), right);
    println!("alone {alone:?}; among {WRONG} wrong tries: known {known:?}, new {new:?}");
    assert!(statuses.iter().all(|it| matches!(it, 401 | 429)), "{statuses:?}");
    let hashed = statuses.iter().filter(|it| **it == 401).count();
    assert!(hashed >= 40, "{hashed} of {WRONG} were tried");
    // The hash under way, its own, and some room for a busy machine.
    assert!(known < alone * 5 + Duration::from_secs(1), "{known:?}, alone {alone:?}");
    assert!(new < alone * 60 + Duration::from_secs(1), "{new:?}, alone {alone:?}");
}

#[tokio::test]
async fn failures_make_the_next_try_wait() {
    let site = Site::with(1, |_| {}).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
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

/// An authority for certificates of a test.
struct Authority {
    certificate: rcgen::Certificate,
    issuer: Issuer<'static, KeyPair>,
}

impl Authority {
    fn new() -> Self {
        let mut params = CertificateParams::new(vec![]).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let key = KeyPair::generate().unwrap();
        let certificate = params.self_signed(&key).unwrap();
        Self { certificate, issuer: Issuer::new(params, key) }
    }

    /// A certificate with its key.
    fn leaf(&self, name: &str) -> (rcgen::Certificate, KeyPair) {
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(vec!["localhost".into()]).unwrap();
        params.distinguished_name.push(DnType::CommonName, name);
        (params.signed_by(&key, &self.issuer).unwrap(), key)
    }

    /// The files of a hub, in a folder.
    fn write(&self, folder: &Path) -> TlsConfig {
        let file = |name: &str, text: String| {
            std::fs::write(folder.join(name), text).unwrap();
            folder.join(name)
        };
        let (server, key) = self.leaf("hub");
        TlsConfig {
            cert: file("cert.pem", server.pem()),
            key: file("key.pem", key.serialize_pem()),
            client_ca: Some(file("ca.pem", self.certificate.pem())),
            client_roles: [("scada".to_owned(), Role::Operator)].into(),
        }
    }

    /// A connection, with a certificate of this name if there is one.
    async fn connect(
        &self,
        address: SocketAddr,
        client: Option<&str>,
    ) -> std::io::Result<TlsStream<TcpStream>> {
        let mut roots = RootCertStore::empty();
        roots.add(self.certificate.der().clone()).unwrap();
        let builder =
            ClientConfig::builder_with_provider(Arc::new(crypto::ring::default_provider()))
                .with_safe_default_protocol_versions()
                .unwrap()
                .with_root_certificates(roots);
        let config = match client {
            None => builder.with_no_client_auth(),
            Some(name) => {
                let (certificate, key) = self.leaf(name);
                let key = PrivateKeyDer::try_from(key.serialize_der()).unwrap();
                builder.with_client_auth_cert(vec![certificate.der().clone()], key).unwrap()
            }
        };
        let stream = TcpStream::connect(address).await.unwrap();
        let name = ServerName::try_from("localhost").unwrap();
        TlsConnector::from(Arc::new(config)).connect(name, stream).await
    }
}

/// Sends all of a body that is refused before it is read, and only then reads the answer.
async fn refused_while_sending(mut stream: impl AsyncRead + AsyncWrite + Unpin) -> String {
    let body = vec![b'x'; 16 << 20];
    let head = format!(
        "POST /api/monitors/M1/requests HTTP/1.1\r\nHost: localhost\r\nContent-Length: {}\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    stream.write_all(&body).await.expect("what is sent is taken");
    stream.flush().await.unwrap();
    let mut answer = Vec::new();
    let read = timeout(PATIENCE, stream.read_to_end(&mut answer)).await.expect("in time");
    assert!(read.is_ok(), "the connection ends in good order: {read:?}");
    String::from_utf8(answer).unwrap()
}

#[tokio::test]
async fn who_sends_a_whole_body_without_waiting_reads_why_it_is_refused() {
    let site = Site::open(1).await;
    let stream = TcpStream::connect(site.address).await.unwrap();
    let answer = refused_while_sending(stream).await;
    assert!(answer.starts_with("HTTP/1.1 413 "), "{answer}");
    let folder = std::env::temp_dir().join(format!("lafet-linger-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let authority = Authority::new();
    let tls = authority.write(&folder);
    let site = Site::with(1, |config| config.tls = Some(tls)).await;
    let stream = authority.connect(site.address, Some("stranger")).await.unwrap();
    let answer = refused_while_sending(stream).await;
    assert!(answer.starts_with("HTTP/1.1 401 "), "{answer}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Its connections outlast it: they may stop, and command nothing.
#[tokio::test]
async fn a_certificate_of_a_client_ends() {
    let folder = std::env::temp_dir().join(format!("lafet-ends-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let authority = Authority::new();
    let tls = authority.write(&folder);
    let time = ManualTime::at(1_000_000_000_000);
    let site = Site::at(1, Clock::Manual(time.clone()), |config| config.tls = Some(tls)).await;
    let connect = async || authority.connect(site.address, Some("scada")).await.unwrap();
    let [good, asks, stops, late] =
        [connect().await, connect().await, connect().await, connect().await];
    let get = async |stream, path| http_over(stream, "localhost", "GET", path, &[], "").await;
    let reply = get(good, "/api/session").await;
    assert_eq!(
        (reply.status, reply.body["expires_ms"].as_u64() > Some(0)),
        (200, true),
        "{reply:?}"
    );
    let ends_ms = reply.body["expires_ms"].as_u64().unwrap();
    time.set_date(ends_ms + 1000);
    assert_eq!(get(asks, "/api/monitors").await.status, 401);
    let stop = http_over(stops, "localhost", "POST", "/api/stop", &[], "").await;
    assert_eq!((stop.status, &stop.body["M1"]["ok"]), (200, &json!(true)), "{stop:?}");
    time.set_date(ends_ms + 25 * 3_600_000);
    let stop = http_over(late, "localhost", "POST", "/api/stop", &[], "").await;
    assert_eq!(stop.status, 401);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[tokio::test]
async fn certificates_of_our_own_and_of_clients() {
    let folder = std::env::temp_dir().join(format!("lafet-tls-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let authority = Authority::new();
    let tls = authority.write(&folder);
    let site = Site::with(1, |config| config.tls = Some(tls)).await;
    let stream = authority.connect(site.address, Some("scada")).await.unwrap();
    let reply = http_over(stream, "localhost", "GET", "/api/session", &[], "").await;
    assert_eq!(
        (&reply.body["user"], &reply.body["kind"]),
        (&json!("scada"), &json!("certificate"))
    );
    assert_eq!(reply.body["role"], "operator");
    assert_eq!(reply.header("strict-transport-security"), Some("max-age=31536000"));
    let policy = reply.header("content-security-policy").unwrap();
    assert!(policy.contains("style-src 'self';") && !policy.contains("unsafe"), "{policy}");
    for (origin, status) in [("https://localhost", 200), ("http://localhost", 403)] {
        let stream = authority.connect(site.address, Some("scada")).await.unwrap();
        let headers = [("Origin", origin)];
        let reply = http_over(stream, "localhost", "GET", "/api/session", &headers, "").await;
        assert_eq!(reply.status, status, "{origin}");
    }
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    let body = json!({ "user": "anna", "password": PASSWORD }).to_string();
    let stream = authority.connect(site.address, Some("stranger")).await.unwrap();
    let login = http_over(stream, "localhost", "POST", "/api/login", &[], &body).await;
    let cookie = login.header("set-cookie").unwrap();
    assert!(cookie.starts_with("__Host-lafet_session_0=") && cookie.ends_with("; Secure"));
    let value = cookie.split(';').next().unwrap();
    for (cookie, status) in [(value, 200), (value.trim_start_matches("__Host-"), 401)] {
        let stream = authority.connect(site.address, Some("stranger")).await.unwrap();
        let headers = [("Cookie", cookie)];
        let reply = http_over(stream, "localhost", "GET", "/api/session", &headers, "").await;
        assert_eq!(reply.status, status, "{cookie}");
    }
    let stream = authority.connect(site.address, Some("stranger")).await.unwrap();
    let reply = http_over(stream, "localhost", "GET", "/api/session", &[], "").await;
    assert_eq!(reply.code(), "login_needed");
    // Without a certificate the connection ends, at the latest when it is used.
    if let Ok(stream) = authority.connect(site.address, None).await {
        assert_eq!(http_over(stream, "localhost", "GET", "/health", &[], "").await.status, 0);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Logs in, and returns from where, as the audit log has it.
async fn origin_of(site: &Site, headers: &[(&str, &str)]) -> String {
    let body = json!({ "user": "anna", "password": PASSWORD }).to_string();
    assert_eq!(site.http("POST", "/api/login", headers, &body).await.status, 200);
    let log = site.hub.audit().latest(None, 1, None, None).await.unwrap();
    log[0].record.from.clone()
}

#[tokio::test]
async fn a_proxy_of_ours_tells_for_whom_it_asks_and_nobody_else_does() {
    let told = [("X-Forwarded-For", "6.6.6.6, 10.0.0.5, 127.0.0.1")];
    let site = Site::with(1, |_| {}).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    assert_eq!(origin_of(&site, &told).await, "127.0.0.1");
    let site = Site::with(1, |config| config.proxies = vec!["127.0.0.1".parse().unwrap()]).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    assert_eq!(origin_of(&site, &told).await, "10.0.0.5", "6.6.6.6 may be a lie");
    assert_eq!(origin_of(&site, &[("X-Forwarded-For", "rubbish")]).await, "127.0.0.1");
    assert_eq!(origin_of(&site, &[]).await, "127.0.0.1");
    let https = [("X-Forwarded-Proto", "https"), ("X-Forwarded-For", "10.0.0.8")];
    let body = json!({ "user": "anna", "password": PASSWORD }).to_string();
    let login = site.http("POST", "/api/login", &https, &body).await;
    assert!(login.header("set-cookie").unwrap().ends_with("; Secure"), "{login:?}");
    // A client that fails behind the proxy shuts no other out.
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
    let reader = site.hub.access().by_token(1, &token).unwrap();
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
    assert!(refused, "reading too much is refused");
    while site.hub.count_reading(&reader).is_ok() {}
    drop(site.ws(&token).await);
    let stop = site.post(&token, "/api/monitors/M1/stop", json!({})).await;
    assert_eq!(stop.status, 200, "{stop:?}");
    let take = site.post(&token, "/api/monitors/M1/authority", json!({ "action": "take" })).await;
    assert_eq!(take.status, 200, "{take:?}");
}

#[tokio::test]
async fn strangers_do_not_take_every_connection() {
    let site = Site::with(1, |config| config.connections_max = 16).await;
    let token = site.token(Role::Observer);
    let open = || site.hub.counts().connections.load(Ordering::Relaxed);
    assert_eq!(open(), 0);
    // Half a login each, and no more.
    let mut held = Vec::new();
    for _ in 0..40 {
        let mut stream = TcpStream::connect(site.address).await.unwrap();
        let head = "POST /api/login HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99\r\n\r\n{";
        tokio::io::AsyncWriteExt::write_all(&mut stream, head.as_bytes()).await.unwrap();
        held.push(stream);
    }
    until("the oldest have given way", || open() <= 8).await;
    // A known client comes through from the same address and from others, and logs in.
    assert_eq!(site.post(&token, "/api/stop", json!({})).await.status, 200);
    let mut socket = site.ws(&token).await;
    let other = tokio::net::TcpSocket::new_v4().unwrap();
    other.bind("127.0.0.2:0".parse().unwrap()).unwrap();
    let other = other.connect(site.address).await.unwrap();
    let authorization = format!("Bearer {token}");
    let headers = [("Authorization", authorization.as_str())];
    let stop = http_over(other, "127.0.0.1", "POST", "/api/stop", &headers, "").await;
    assert_eq!(stop.status, 200, "{stop:?}");
    // A client that is known does not give way, whether it has a WebSocket or asks now and then.
    let mut known = TcpStream::connect(site.address).await.unwrap();
    let ask = format!("GET /api/hub HTTP/1.1\r\nHost: localhost\r\n{authorization}\r\n\r\n");
    let ask = ask.replace("Bearer", "Authorization: Bearer");
    assert!(answers(&mut known, &ask).await);
    for _ in 0..20 {
        held.push(TcpStream::connect(site.address).await.unwrap());
    }
    until("the oldest have given way", || open() <= 10).await;
    assert!(answers(&mut known, &ask).await);
    drop(known);
    assert_eq!(socket.ask(json!({ "type": "stop", "monitor": "M1" })).await["result"]["ok"], true);
    drop((held, socket));
    until("they are given back", || open() == 0).await;
}

/// Whether a connection that stays open is answered.
async fn answers(stream: &mut TcpStream, ask: &str) -> bool {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let mut answer = [0; 4096];
    stream.write_all(ask.as_bytes()).await.is_ok()
        && matches!(stream.read(&mut answer).await, Ok(1..) if answer.starts_with(b"HTTP/1.1 200"))
}

/// The rest of a body is waited for, but not as long as its client likes.
#[tokio::test]
async fn half_a_body_ends_its_connection() {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let site = Site::with(1, |_| {}).await;
    for path in ["/api/login", "/api/stop"] {
        let mut stream = TcpStream::connect(site.address).await.unwrap();
        let head =
            format!("POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99\r\n\r\n{{");
        stream.write_all(head.as_bytes()).await.unwrap();
        let mut answer = Vec::new();
        let ended = stream.read_to_end(&mut answer);
        let ended = tokio::time::timeout(std::time::Duration::from_secs(12), ended).await;
        assert!(ended.is_ok(), "{path}: {}", String::from_utf8_lossy(&answer));
    }
}

#[tokio::test]
async fn authority_has_a_rate_and_its_reason_a_length() {
    let site = Site::with(1, |_| {}).await;
    let token = site.token(Role::Operator);
    let entries = site.hub.audit().last().await.unwrap();
    let mut socket = site.ws(&token).await;
    let mut codes = Vec::new();
    for _ in 0..150 {
        let message = json!({ "type": "authority", "monitor": "M1", "action": "take", "id": 1 });
        socket.send(message).await;
    }
    for _ in 0..150 {
        let answer = socket.next_of("answer").await;
        codes.push(answer["error"]["code"].as_str().unwrap_or_default().to_owned());
    }
    let slowed = codes.iter().filter(|code| *code == "slow_down").count() as u64;
    assert!(slowed > 0, "{codes:?}");
    until("they are stored", || site.hub.audit().waiting() == 0).await;
    let noted = site.hub.audit().last().await.unwrap() - entries;
    assert!(noted <= 150 - slowed, "{noted} entries, {slowed} refused");
    let engineer = site.token(Role::Engineer);
    let long = json!({ "action": "force", "reason": "ж".repeat(501) });
    let refused = site.post(&engineer, "/api/monitors/M1/authority", long).await;
    assert_eq!((refused.status, refused.code()), (400, "bad_request"));
}

/// What is answered before its body has come ends the connection, and says so: what is sent next, a Stop perhaps, goes
/// over another one.
#[tokio::test]
async fn an_early_answer_says_that_the_connection_ends() {
    let site = Site::with(1, |_| {}).await;
    let token = site.token(Role::Observer);
    let early = [
        (
            "POST",
            "/api/users",
            format!("Authorization: Bearer {token}\r\nOrigin: http://evil.example"),
            403,
        ),
        ("POST", "/api/users", "X-None: 1".to_owned(), 401),
        ("POST", "/api/nothing", format!("Authorization: Bearer {token}"), 404),
        ("DELETE", "/api/hub", format!("Authorization: Bearer {token}"), 405),
        (
            "POST",
            "/api/users",
            format!("Authorization: Bearer {token}\r\nContent-Encoding: gzip"),
            415,
        ),
    ];
    for (method, path, header, status) in early {
        let mut stream = TcpStream::connect(site.address).await.unwrap();
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: localhost\r\n{header}\r\nContent-Length: 2\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).await.unwrap();
        let mut answer = vec![0; 4096];
        let read = timeout(PATIENCE, stream.read(&mut answer)).await.unwrap();
        let answer = String::from_utf8_lossy(&answer[..read.unwrap()]).to_lowercase();
        assert!(answer.starts_with(&format!("http/1.1 {status}")), "{method} {path}: {answer}");
        assert!(answer.contains("\r\nconnection: close\r\n"), "{method} {path}: {answer}");
    }
    // One whose body is read stays, refused or not.
    let mut stream = TcpStream::connect(site.address).await.unwrap();
    for (path, body, status) in
        [("monitors/M1/requests", "{}", 400), ("stop", "{}", 200), ("stop", "", 200)]
    {
        let ask = format!(
            "POST /api/{path} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {token}\r\n\
             Content-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        stream.write_all(ask.as_bytes()).await.unwrap();
        let mut answer = vec![0; 65536];
        let read = timeout(PATIENCE, stream.read(&mut answer)).await.unwrap();
        let answer = String::from_utf8_lossy(&answer[..read.unwrap()]).to_lowercase();
        assert!(answer.starts_with(&format!("http/1.1 {status}")), "{path}: {answer}");
        assert!(!answer.contains("connection: close"), "{path}: {answer}");
    }
}

#[tokio::test]
async fn an_address_that_is_no_text_is_refused_as_everything_else() {
    let site = Site::open(1).await;
    let reply = site.post("", "/api/monitors/%ff/stop", json!({})).await;
    assert_eq!((reply.status, reply.code()), (400, "bad_request"), "{reply:?}");
    assert!(reply.body["error"]["ru"].is_string(), "{reply:?}");
}
