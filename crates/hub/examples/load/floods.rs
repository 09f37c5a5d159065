//! Every kind of message as fast as loopback takes it, and what becomes of Stop, Close and Lockout
//! of others, of the monitors' values and of the memory meanwhile.

use std::net::SocketAddr;
use std::path::Path;
use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use lafet_hub::access::Role;
use lafet_hub::{Clock, Config, MonitorConfig, Server, text};
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;

use crate::Fallible;
use crate::client::get_json;
use crate::figures::Figures;
use crate::hub::Hub;
use crate::kinds::{self, Kind, Way};
use crate::site::Site;

const MONITORS: usize = 3;
/// Memory above that at rest, KiB.
const MEMORY_KIB: f64 = 64.0 * 1024.0;
/// How often others stop, close and lock out.
const EVERY: Duration = Duration::from_millis(20);
/// What a flood leaves is gone after this time.
const REST: Duration = Duration::from_secs(20);

/// How much, for how long, and within which bounds.
pub struct Size {
    /// Connections of a flood.
    connections: &'static [usize],
    /// Each alone (read, unread, known, stranger), or a quarter of each at the same time.
    apart: bool,
    time: Duration,
    p99_ms: f64,
    most_ms: f64,
}

pub const WHOLE: Size = Size {
    connections: &[1, 200],
    apart: true,
    time: Duration::from_secs(60),
    p99_ms: 50.0,
    most_ms: 250.0,
};
/// On a machine that does other things, too: generous in time, strict in what grows.
pub const QUICK: Size = Size {
    connections: &[48],
    apart: false,
    time: Duration::from_millis(1200),
    p99_ms: 1000.0,
    most_ms: 5000.0,
};

/// A client of a flood.
#[derive(Clone, Copy)]
struct Manner {
    reads: bool,
    known: bool,
}

const MANNERS: [Manner; 4] = [
    Manner { reads: true, known: true },
    Manner { reads: false, known: true },
    Manner { reads: true, known: false },
    Manner { reads: false, known: false },
];

/// A hub as a process of its own: prints where it listens, and tokens.
pub async fn serve(folder: &Path, monitors: &[&str]) -> Fallible<()> {
    let mut config = Config {
        listen: SocketAddr::from(([127, 0, 0, 1], 0)),
        data: Some(folder.to_owned()),
        ..Config::default()
    };
    for (index, place) in monitors.iter().enumerate() {
        let id = format!("M{}", index + 1);
        let endpoint = format!("tcp://{place}?addr=1").parse()?;
        let name = text::both(id.clone(), id.clone());
        config.monitors.push(MonitorConfig { id, name, endpoint, poll_ms: 100 });
    }
    let hub = lafet_hub::Hub::new(config, Clock::System, json!({}))?;
    let token = |role: Role| hub.access.add_token(1, role.name(), role).map(|(_, token)| token);
    let (flood, other) = (token(Role::Administrator)?, token(Role::Operator)?);
    let server = Server::bind(hub).await?;
    println!("{}", json!({ "listening": server.url()?, "flood": flood, "other": other }));
    server.serve(std::future::pending()).await;
    Ok(())
}

pub async fn run(folder: &Path, size: &Size) -> Fallible<()> {
    let kinds = kinds::all()?;
    std::fs::create_dir_all(folder)?;
    let site = Site::start(MONITORS);
    let (hub, said) = Hub::own(folder, site.places())?;
    let token = |name: &str| said[name].as_str().unwrap_or_default().to_owned();
    let (flood, other) = (token("flood"), token("other"));
    while get_json(&hub.place, "/health").await?["monitors"]["M1"] != "up" {
        sleep(Duration::from_millis(50)).await;
    }
    let mut others = Others::open(&hub.place, &other).await?;
    others.work(Duration::from_secs(3)).await?;
    let rest_kib = hub.used()?.memory_kib;
    let mut failed = Vec::new();
    println!(
        "| flood | connections | requests of others | p50, ms | p99 | most | memory above rest, MiB |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for kind in &kinds {
        for (count, manners, name) in parts(size) {
            let flood = Flood { place: &hub.place, token: &flood, kind };
            let mut tasks = JoinSet::new();
            for index in 0..count {
                tasks.spawn(flood.run(manners[index % manners.len()]));
            }
            let (figures, stale) = others.work(size.time).await?;
            let above_kib = hub.used()?.memory_kib - rest_kib;
            drop(tasks);
            println!(
                "| {}{name} | {count} | {} | {} | {:.1} |",
                kind.name,
                figures.count(),
                figures.cells(),
                above_kib / 1024.0
            );
            let slow =
                figures.percentile(99) > size.p99_ms || figures.percentile(100) > size.most_ms;
            if slow || stale > 0 || above_kib > MEMORY_KIB {
                failed.push(format!("{}{name} × {count} (stale {stale})", kind.name));
            }
        }
    }
    let began = Instant::now();
    while hub.used()?.memory_kib - rest_kib > MEMORY_KIB && began.elapsed() < REST {
        sleep(Duration::from_secs(1)).await;
    }
    let left_kib = hub.used()?.memory_kib - rest_kib;
    println!("{} kinds; {:.1} MiB above rest at the end", kinds.len(), left_kib / 1024.0);
    hub.kill()?;
    std::fs::remove_dir_all(folder)?;
    if failed.is_empty() {
        Ok(())
    } else {
        Err(format!("out of bounds: {}", failed.join("; ")).into())
    }
}

/// The floods of a kind.
fn parts(size: &Size) -> Vec<(usize, Vec<Manner>, String)> {
    let mut parts = Vec::new();
    for count in size.connections {
        if !size.apart {
            parts.push((*count, MANNERS.to_vec(), String::new()));
            continue;
        }
        for manner in MANNERS {
            let reads = if manner.reads { "read" } else { "unread" };
            let known = if manner.known { "known" } else { "stranger" };
            parts.push((*count, vec![manner], format!(", {reads}, {known}")));
        }
    }
    parts
}

struct Flood<'a> {
    place: &'a str,
    token: &'a str,
    kind: &'a Kind,
}

impl Flood<'_> {
    /// Sends on, and connects again whenever the hub ends the connection.
    fn run(&self, manner: Manner) -> impl Future<Output = ()> + Send + 'static {
        let (place, kind) = (self.place.to_owned(), self.kind.clone());
        let token = if manner.known { self.token.to_owned() } else { String::new() };
        async move {
            loop {
                // How it ends is the hub's business.
                _ = send(&place, &token, &kind.way, manner.reads).await;
                tokio::task::yield_now().await;
            }
        }
    }
}

async fn send(place: &str, token: &str, way: &Way, reads: bool) -> Fallible<()> {
    let stream = TcpStream::connect(place).await?;
    stream.set_nodelay(true)?;
    let bearer = format!("Authorization: Bearer {token}\r\n");
    let message = match way {
        Way::Http(method, path, body) => {
            let len = body.len();
            let head = format!(
                "{method} {path} HTTP/1.1\r\nHost: localhost\r\n{bearer}Content-Length: {len}\r\n\r\n"
            );
            return pump(stream, &[head.as_bytes(), body].concat(), reads).await;
        }
        Way::Bytes(bytes) => {
            let (mut read, mut write) = stream.into_split();
            write.write_all(bytes).await?;
            // Held until the hub ends it.
            read.read_to_end(&mut Vec::new()).await?;
            return Ok(());
        }
        Way::Message(message) => Message::text(message.to_string()),
        Way::Ping => Message::Ping(vec![0; 100].into()),
    };
    let mut request = format!("ws://{place}/api/ws").into_client_request()?;
    request.headers_mut().insert("Authorization", format!("Bearer {token}").parse()?);
    let (socket, _) = tokio_tungstenite::client_async(request, stream).await?;
    let (mut sink, mut answers) = socket.split();
    let sending = async {
        loop {
            sink.send(message.clone()).await?;
        }
    };
    let taking = async {
        if !reads {
            std::future::pending::<()>().await;
        }
        while let Some(Ok(_)) = answers.next().await {}
    };
    tokio::select! {
        sent = sending => sent,
        () = taking => Ok(()),
    }
}

/// Requests one after the other, without waiting for their answers.
async fn pump(stream: TcpStream, request: &[u8], reads: bool) -> Fallible<()> {
    let (mut read, mut write) = stream.into_split();
    let sending = async {
        loop {
            write.write_all(request).await?;
        }
    };
    let taking = async {
        if !reads {
            std::future::pending::<()>().await;
        }
        let mut buffer = vec![0; 64 * 1024];
        while read.read(&mut buffer).await? > 0 {}
        Ok::<_, std::io::Error>(())
    };
    tokio::select! {
        sent = sending => sent,
        taken = taking => Ok(taken?),
    }
}

/// Those who go on with their work.
struct Others {
    socket: tokio_tungstenite::WebSocketStream<TcpStream>,
    next: u64,
}

impl Others {
    async fn open(place: &str, token: &str) -> Fallible<Self> {
        let mut request = format!("ws://{place}/api/ws").into_client_request()?;
        request.headers_mut().insert("Authorization", format!("Bearer {token}").parse()?);
        let stream = TcpStream::connect(place).await?;
        stream.set_nodelay(true)?;
        let (socket, _) = tokio_tungstenite::client_async(request, stream).await?;
        Ok(Self { socket, next: 0 })
    }

    /// Stops, closes and locks out in turn; how long each took, and how often a value was stale.
    async fn work(&mut self, time: Duration) -> Fallible<(Figures, usize)> {
        let (began, mut times, mut stale) = (Instant::now(), Vec::new(), 0);
        while began.elapsed() < time {
            self.next += 1;
            let kind = ["stop", "close", "lockout"][self.next as usize % 3];
            let monitor = format!("M{}", self.next % MONITORS as u64 + 1);
            let message = json!({ "type": kind, "monitor": monitor, "id": self.next });
            let asked = Instant::now();
            self.socket.send(Message::text(message.to_string())).await?;
            loop {
                let message = timeout(Duration::from_secs(60), self.socket.next()).await?;
                let Message::Text(text) = message.ok_or("closed")?? else { continue };
                stale += usize::from(text.contains("\"stale\":true"));
                if text.contains("\"type\":\"answer\"") {
                    let answer: Value = serde_json::from_str(&text)?;
                    if answer["id"] == self.next {
                        break;
                    }
                }
            }
            times.push(asked.elapsed().as_secs_f64() * 1000.0);
            sleep(EVERY).await;
        }
        Ok((Figures::new(times), stale))
    }
}
