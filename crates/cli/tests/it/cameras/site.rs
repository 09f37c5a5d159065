//! A hub with a simulated monitor and one camera; requests to it, and a viewer.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::support::{self, Running, Sim};

/// Longer than anything here takes on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// GStreamer's RTSP server.
pub struct Camera {
    child: Child,
    port: u16,
}

impl Camera {
    /// On a free port. `login`: `user:password`, or `-`.
    pub fn start(profile: &str, login: &str) -> Self {
        let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let port = free.local_addr().unwrap().port();
        drop(free);
        Self::at(port, profile, login)
    }

    /// On this port: one that is started again.
    pub fn at(port: u16, profile: &str, login: &str) -> Self {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/cameras/camera.py");
        // That of the system, which has the bindings.
        let child = Command::new("/usr/bin/python3")
            .args([script, &port.to_string(), profile, login])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("Python is there");
        let camera = Self { child, port };
        until("the camera listens", || TcpStream::connect(("127.0.0.1", port)).is_ok());
        camera
    }

    pub fn port(&self) -> u16 {
        self.port
    }

    pub fn place(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    pub fn signal(&self, name: &str) {
        signal(self.child.id(), name);
    }
}

impl Drop for Camera {
    fn drop(&mut self) {
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

pub fn signal(process: u32, name: &str) {
    let sent = Command::new("kill").args([format!("-{name}"), process.to_string()]).status();
    assert!(sent.expect("kill is there").success());
}

/// Waits for something.
pub fn until(what: &str, mut is: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is() {
        assert!(Instant::now() < deadline, "{what}");
        pause(Duration::from_millis(30));
    }
}

pub fn pause(time: Duration) {
    let (_keep, wait) = std::sync::mpsc::channel::<()>();
    _ = wait.recv_timeout(time);
}

/// A hub.
pub struct Site {
    pub hub: Running,
    pub place: String,
    folder: PathBuf,
    _sim: Sim,
}

impl Site {
    /// With a camera at a place; `keys`: further lines of `[[camera]]`.
    pub fn open(name: &str, camera: Option<&str>, keys: &str) -> Self {
        let sim = Sim::start(&["--profile", "remote"]);
        let folder = std::env::temp_dir().join(format!("lafet-eyes-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let config = folder.join("hub.toml");
        let camera = camera.map(|place| {
            format!(
                "[[camera]]\nid = \"C1\"\nurl = \"rtsp://{place}/live\"\nmonitors = [\"M1\"]\n{keys}"
            )
        });
        let text = format!(
            "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\ndata = \"data\"\n\
             [[monitor]]\nid = \"M1\"\nurl = \"tcp://{}?addr=1\"\n{}",
            sim.place(),
            camera.unwrap_or_default()
        );
        std::fs::write(&config, text).unwrap();
        let (hub, url) = support::hub(&config);
        let place = url.split_once("://").expect("a URL").1.trim_end_matches('/').to_owned();
        Self { hub, place, folder, _sim: sim }
    }

    /// Status and body of an answer, and how long it took.
    pub fn ask(&self, method: &str, path: &str) -> (u16, String, Duration) {
        let began = Instant::now();
        let mut stream = TcpStream::connect(&self.place).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Length: 2\r\n\r\n{{}}",
            self.place
        );
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let status = answer.split(' ').nth(1).and_then(|it| it.parse().ok()).unwrap_or(0);
        let body = answer.split_once("\r\n\r\n").map(|(_, body)| body.to_owned());
        (status, body.unwrap_or_default(), began.elapsed())
    }

    /// The camera as the hub sees it.
    pub fn camera(&self) -> Value {
        let (status, body, _) = self.ask("GET", "/api/cameras");
        assert_eq!(status, 200, "{body}");
        serde_json::from_str::<Value>(&body).expect("JSON")[0].take()
    }

    /// Waits until the camera is so; returns how long that took.
    pub fn comes_to(&self, state: &str) -> Duration {
        let began = Instant::now();
        let mut last = Value::Null;
        while last["state"] != state {
            last = self.camera();
            assert!(began.elapsed() < PATIENCE, "{state}: {last}");
            pause(Duration::from_millis(20));
        }
        began.elapsed()
    }

    /// How long a Stop takes until it is answered.
    pub fn stop(&self) -> Duration {
        let (status, body, took) = self.ask("POST", "/api/monitors/M1/stop");
        assert!((200..300).contains(&status), "{status} {body}");
        took
    }

    /// The process of the camera.
    pub fn process(&self) -> Option<u32> {
        children_of(self.hub.child.id()).first().copied()
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        _ = self.hub.child.kill();
        _ = self.hub.child.wait();
        _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Processes of this parent.
pub fn children_of(parent: u32) -> Vec<u32> {
    let of = |entry: std::io::Result<std::fs::DirEntry>| {
        let process: u32 = entry.ok()?.file_name().to_str()?.parse().ok()?;
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
        let mut rest = stat.rsplit(") ").next()?.split(' ');
        let (state, of) = (rest.next()?, rest.next()?);
        (of == parent.to_string() && state != "Z").then_some(process)
    };
    std::fs::read_dir("/proc").unwrap().filter_map(of).collect()
}

/// A picture as a viewer gets it.
#[derive(Clone, Debug)]
pub struct Seen {
    pub key: bool,
    pub number: u32,
    pub shown_us: i64,
    pub at_ms: u64,
    pub captured_us: Option<u64>,
    pub size: (u16, u16),
    pub codec: String,
    pub data: Vec<u8>,
}

/// A WebSocket to the pictures.
pub struct Viewer(TcpStream);

impl Viewer {
    pub fn open(site: &Site) -> Self {
        let mut stream = TcpStream::connect(&site.place).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let head = format!(
            "GET /api/cameras/C1/stream HTTP/1.1\r\nHost: {}\r\nConnection: Upgrade\r\n\
             Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
            site.place
        );
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            answer.push(byte[0]);
        }
        assert!(answer.starts_with(b"HTTP/1.1 101"), "{}", String::from_utf8_lossy(&answer));
        Self(stream)
    }

    /// The next picture, which is said to be seen.
    pub fn next(&mut self) -> Seen {
        loop {
            let mut head = [0; 2];
            self.0.read_exact(&mut head).unwrap();
            let len = match head[1] & 0x7F {
                126 => u64::from(u16::from_be_bytes(self.read())),
                127 => u64::from_be_bytes(self.read()),
                short => u64::from(short),
            };
            let mut body = vec![0; usize::try_from(len).unwrap()];
            self.0.read_exact(&mut body).unwrap();
            if head[0] & 0x0F == 2 {
                // Masked with zeros.
                let seen = [&[0x82, 0x84, 0, 0, 0, 0][..], &body[4..8]].concat();
                self.0.write_all(&seen).unwrap();
                return seen_of(&body);
            }
        }
    }

    fn read<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        self.0.read_exact(&mut bytes).unwrap();
        bytes
    }
}

fn seen_of(bytes: &[u8]) -> Seen {
    let u16_at = |at: usize| u16::from_be_bytes(bytes[at..at + 2].try_into().unwrap());
    let u64_at = |at: usize| u64::from_be_bytes(bytes[at..at + 8].try_into().unwrap());
    assert_eq!(bytes[0], 1, "the layout");
    let codec = 36 + usize::from(u16_at(2));
    Seen {
        key: bytes[1] & 1 != 0,
        number: u32::from_be_bytes(bytes[4..8].try_into().unwrap()),
        shown_us: i64::from_be_bytes(bytes[8..16].try_into().unwrap()),
        at_ms: u64_at(16),
        captured_us: (bytes[1] & 2 != 0).then(|| u64_at(24)),
        size: (u16_at(32), u16_at(34)),
        codec: String::from_utf8(bytes[36..codec].to_vec()).unwrap(),
        data: bytes[codec..].to_vec(),
    }
}
