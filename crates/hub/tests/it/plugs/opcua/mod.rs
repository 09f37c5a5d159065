//! OPC UA, end to end: clients that are not ours, and what such clients do wrong.

#[cfg(target_os = "linux")]
mod foreign;

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, timeout};

use super::{Clock, free, servers};
use crate::support::{PATIENCE, Site};
use lafet_device::composition::Composition;

/// A folder of certificates, which is removed at the end.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("lafet-opcua-it-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

/// `[[opcua]]` as hub.toml has it.
fn table(address: SocketAddr, folder: &Folder, more: &str) -> String {
    let folder = folder.0.display();
    format!(
        "[[opcua]]\nname = \"site\"\nlisten = \"{address}\"\ncertificates = \"{folder}\"\n{more}\n"
    )
}

async fn site_with(monitors: u8, text: &str, login: bool) -> Site {
    let read = servers(monitors, text);
    Site::of((monitors, Composition::REMOTE), Clock::System, |config| {
        (config.login, config.opcua) = (login, read.opcua);
    })
    .await
}

async fn plug(site: &Site) -> Value {
    site.get("", "/api/hub/state").await.body["plugs"][0].clone()
}

/// A server without users, on the loopback.
async fn open(monitors: u8, more: &str) -> (Site, SocketAddr, Folder) {
    let (address, folder) = (free(), Folder::new());
    let text = table(address, &folder, &format!("plain = true\n{more}"));
    let site = site_with(monitors, &text, false).await;
    listening(&site).await;
    (site, address, folder)
}

async fn listening(site: &Site) {
    listening_for(site, "").await;
}

/// Its key is made at the first start.
async fn listening_for(site: &Site, token: &str) {
    let began = Instant::now();
    loop {
        let state = site.get(token, "/api/hub/state").await.body;
        if state["plugs"][0]["error"].is_null() {
            return;
        }
        assert!(began.elapsed() < PATIENCE, "{:#}", state["plugs"]);
    }
}

#[tokio::test]
async fn a_server_is_shown_and_its_key_is_for_the_hub_alone() {
    let (site, address, folder) = open(1, "anonymous = \"observer\"").await;
    let shown = plug(&site).await;
    assert_eq!((&shown["protocol"], &shown["name"]), (&"opcua".into(), &"site".into()));
    assert_eq!(shown["address"], format!("opc.tcp://{address}/"));
    let key = std::fs::read_to_string(folder.0.join("private/private.pem")).unwrap();
    assert!(key.contains("PRIVATE KEY"));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = std::fs::metadata(folder.0.join("private")).unwrap().permissions().mode();
        assert_eq!(mode & 0o077, 0);
    }
}

/// A connection that ends, or says nothing more.
async fn answered(address: SocketAddr, bytes: &[u8]) -> Option<Vec<u8>> {
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(bytes).await.unwrap();
    let mut answer = Vec::new();
    let read = timeout(Duration::from_secs(8), stream.read_to_end(&mut answer)).await;
    read.is_ok().then_some(answer)
}

#[tokio::test]
async fn what_is_no_opc_ua_is_closed_and_counted() {
    let (site, address, _folder) = open(1, "anonymous = \"observer\"").await;
    let huge = [b"HELF".as_slice(), &u32::MAX.to_le_bytes(), &[0; 64]].concat();
    for bytes in [&b"GET / HTTP/1.1\r\n\r\n"[..], &huge, b"MSGF\0\0\0\0", b"HELF\x10\0\0\0"] {
        assert!(answered(address, bytes).await.is_some(), "{bytes:?} is closed");
    }
    let began = Instant::now();
    while plug(&site).await["malformed"].as_u64() < Some(4) {
        assert!(began.elapsed() < PATIENCE, "{:#}", plug(&site).await);
    }
    // Consoles are served as ever.
    let mut console = site.ws("").await;
    assert!(console.authority("M1", "take").await["error"].is_null());
}

#[tokio::test]
async fn connections_are_bounded() {
    let (site, address, _folder) = open(1, "anonymous = \"observer\"\nsessions_max = 1").await;
    let mut open = Vec::new();
    for _ in 0..12 {
        open.push(TcpStream::connect(address).await.unwrap());
    }
    let began = Instant::now();
    while plug(&site).await["rejected"].as_u64() < Some(7) {
        assert!(began.elapsed() < PATIENCE, "{:#}", plug(&site).await);
    }
}
