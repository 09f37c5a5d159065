//! A client that connects and sends nothing, or connects again and again, keeps no other out.

use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use crate::support::{PATIENCE, Site, http_over};
use futures_util::SinkExt;
use lafet_hub::TlsConfig;
use lafet_hub::access::Role;
use serde_json::json;
use tokio::io::AsyncWriteExt;
use tokio::net::{TcpSocket, TcpStream};
use tokio::time::{Instant, sleep, timeout};
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore, crypto};
use tokio_tungstenite::tungstenite::Message;

/// Bounds of the hub: handshakes at a time, in all and of an address.
const HANDSHAKES_MAX: usize = 256;
const HANDSHAKES_OF_MAX: usize = 64;

/// A hub with TLS, and how its clients come in.
struct Encrypted {
    site: Site,
    roots: Arc<ClientConfig>,
    folder: PathBuf,
}

impl Encrypted {
    async fn open(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("lafet-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let made = rcgen::generate_simple_self_signed(["localhost".to_owned()]).unwrap();
        std::fs::write(folder.join("cert.pem"), made.cert.pem()).unwrap();
        std::fs::write(folder.join("key.pem"), made.signing_key.serialize_pem()).unwrap();
        let (cert, key) = (folder.join("cert.pem"), folder.join("key.pem"));
        let tls = TlsConfig { cert, key, client_ca: None, client_roles: [].into() };
        let site = Site::with(1, |config| config.tls = Some(tls)).await;
        let der: CertificateDer<'_> = made.cert.der().clone();
        let mut roots = RootCertStore::empty();
        roots.add(der).unwrap();
        let provider = Arc::new(crypto::ring::default_provider());
        let roots = ClientConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()
            .unwrap()
            .with_root_certificates(roots)
            .with_no_client_auth();
        Self { site, roots: Arc::new(roots), folder }
    }

    /// The status of an answer to a client at an address, and how long that took.
    async fn health(&self, from: [u8; 4]) -> (u16, Duration) {
        let began = Instant::now();
        let name = ServerName::try_from("localhost").unwrap();
        let stream = connect(from, self.site.address).await;
        let connected = TlsConnector::from(self.roots.clone()).connect(name, stream);
        let Ok(stream) = timeout(PATIENCE, connected).await.unwrap() else {
            return (0, began.elapsed());
        };
        let reply = http_over(stream, "localhost", "GET", "/health", &[], "").await;
        (reply.status, began.elapsed())
    }
}

impl Drop for Encrypted {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.folder);
    }
}

async fn connect(from: [u8; 4], to: SocketAddr) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.bind((IpAddr::from(from), 0).into()).unwrap();
    socket.connect(to).await.unwrap()
}

/// The beginning of a handshake, whose rest never comes.
async fn half(from: [u8; 4], to: SocketAddr) -> TcpStream {
    let mut stream = connect(from, to).await;
    stream.write_all(&[0x16, 3, 1, 2, 0, 1, 0, 1]).await.unwrap();
    stream
}

/// Those that the hub has not closed.
fn open(streams: &[TcpStream]) -> usize {
    let is_open = |it: &&TcpStream| {
        it.try_read(&mut [0; 16]).is_err_and(|it| it.kind() == std::io::ErrorKind::WouldBlock)
    };
    streams.iter().filter(is_open).count()
}

/// Until the hub has closed what it is going to close.
async fn settled(streams: &[TcpStream], most: usize) -> usize {
    let began = Instant::now();
    while open(streams) > most && began.elapsed() < PATIENCE {
        sleep(Duration::from_millis(10)).await;
    }
    open(streams)
}

#[cfg(target_os = "linux")]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn half_handshakes_are_bounded_and_keep_nobody_out() {
    let encrypted = Encrypted::open("half").await;
    let address = encrypted.site.address;
    let mut of_one = Vec::new();
    for _ in 0..200 {
        of_one.push(half([127, 0, 1, 1], address).await);
    }
    assert_eq!(settled(&of_one, HANDSHAKES_OF_MAX).await, HANDSHAKES_OF_MAX);
    let mut all = of_one;
    for host in 2..=6 {
        for _ in 0..100 {
            all.push(half([127, 0, 1, host], address).await);
        }
    }
    assert_eq!(settled(&all, HANDSHAKES_MAX).await, HANDSHAKES_MAX);
    // While they keep coming: an operator elsewhere, and one behind the same address.
    for round in 0..10 {
        for host in 1..=6 {
            all.push(half([127, 0, 1, host], address).await);
        }
        for from in [[127, 0, 2, 1], [127, 0, 1, 1]] {
            let (status, took) = encrypted.health(from).await;
            assert_eq!(status, 200, "{round}: {from:?}");
            assert!(took < Duration::from_secs(5), "{round}: {from:?} {took:?}");
        }
    }
    assert!(settled(&all, HANDSHAKES_MAX).await <= HANDSHAKES_MAX);
    // Those that say nothing at all count as well.
    let mut silent = Vec::new();
    for _ in 0..100 {
        silent.push(connect([127, 0, 3, 1], address).await);
    }
    assert!((1..=HANDSHAKES_OF_MAX).contains(&settled(&silent, HANDSHAKES_OF_MAX).await));
}

/// Messages of one session that are answered, one after the other, until the connection is closed.
async fn flood(site: &Site, token: &str) -> usize {
    let mut socket = site.ws(token).await;
    let stop = socket.ask(json!({ "type": "stop", "monitor": "M1" })).await;
    assert_eq!(stop["result"]["ok"], true, "{stop}");
    for id in 0..2000 {
        let subscribe = json!({ "type": "subscribe", "id": id, "monitors": [] });
        if socket.socket.send(Message::text(subscribe.to_string())).await.is_err() {
            return id;
        }
        loop {
            match socket.next().await {
                Some(message) if message["id"] == id => break,
                Some(message) if message["type"] != "closed" => {}
                _ => return id,
            }
        }
    }
    panic!("it is never too many");
}

#[tokio::test]
async fn a_session_that_comes_back_goes_on_with_what_it_has_left() {
    let site = Site::with(1, |_| {}).await;
    let (one, other) = (site.token(Role::Observer), site.token(Role::Operator));
    let began = Instant::now();
    let mut answered = Vec::new();
    for _ in 0..4 {
        answered.push(flood(&site, &one).await);
    }
    // 400 at once and 200 a second.
    let most = 400 + (200.0 * began.elapsed().as_secs_f64()) as usize;
    assert!(answered[0] >= 390, "{answered:?}");
    assert!(answered.iter().sum::<usize>() <= most + 4, "{answered:?} of {most}");
    assert!(answered[1] < 300, "{answered:?}");
    let mut operator = site.ws(&other).await;
    for _ in 0..300 {
        let answer = operator.ask(json!({ "type": "subscribe", "monitors": [] })).await;
        assert_eq!(answer["subscribed"], json!({ "monitors": [] }));
    }
}

/// What is sent at once: so many messages that the connection ends, and a Stop behind them; also of who has authority
/// and may come back to its seat.
#[tokio::test]
async fn a_stop_behind_too_many_messages_is_carried_out() {
    for takes in [false, true] {
        let site = Site::with(1, |_| {}).await;
        let mut socket = site.ws(&site.token(Role::Operator)).await;
        if takes {
            let answer = socket.authority("M1", "take").await;
            assert!(answer["authority"].is_object(), "{answer}");
        }
        let subscribe = json!({ "type": "subscribe", "monitors": [] }).to_string();
        for _ in 0..600 {
            socket.socket.feed(Message::text(subscribe.clone())).await.unwrap();
        }
        socket.send(json!({ "type": "stop", "monitor": "M1" })).await;
        while socket.next().await.is_some() {}
        let admin = site.token(Role::Administrator);
        let began = Instant::now();
        while site.get(&admin, "/api/audit?text=stop").await.body["entries"][0]["via"] != "ws" {
            assert!(began.elapsed() < PATIENCE, "no Stop was sent, authority: {takes}");
            sleep(Duration::from_millis(20)).await;
        }
    }
}
