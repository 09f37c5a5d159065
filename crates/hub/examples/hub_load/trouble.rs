//! Clients that do everything wrong, as long as they are kept.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use lafet_sim::rng::Rng;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use crate::Fallible;
use crate::client::Socket;

/// A client that sends nonsense does not wait longer for what comes of it.
const BRIEFLY: Duration = Duration::from_millis(200);
/// Storms are no faster than this: the load must not be the machine's whole time.
const PAUSE: Duration = Duration::from_millis(5);

/// How many of each kind.
pub struct Plan {
    /// WebSockets that read and say nothing.
    pub idle: usize,
    /// WebSockets that never read.
    pub slow: usize,
    /// Connections that send their headers a byte a second.
    pub drips: usize,
    /// Tasks that send nonsense.
    pub garbage: usize,
    /// Tasks that connect and break off, one after the other.
    pub storms: usize,
}

/// What they have done.
#[derive(Default)]
pub struct Done {
    pub messages: AtomicU64,
    pub garbage: AtomicU64,
    pub reconnects: AtomicU64,
}

/// Starts them; dropping what is returned ends them.
pub async fn start(place: &str, plan: &Plan, done: &Arc<Done>) -> Fallible<JoinSet<()>> {
    let mut tasks = JoinSet::new();
    for _ in 0..plan.idle {
        let (socket, done) = (Socket::open(place).await?, done.clone());
        tasks.spawn(async move { socket.read_on(&done.messages).await });
    }
    let mut each = |count: usize, kind: fn(String, u64, Arc<Done>) -> Task| {
        for number in 0..count as u64 {
            tasks.spawn(kind(place.to_owned(), number, done.clone()));
        }
    };
    each(plan.slow, |place, _, _| Box::pin(never_read(place)));
    each(plan.drips, |place, _, _| Box::pin(drip(place)));
    each(plan.garbage, |place, seed, done| Box::pin(garbage(place, seed, done)));
    each(plan.storms, |place, seed, done| Box::pin(storm(place, seed, done)));
    Ok(tasks)
}

type Task = std::pin::Pin<Box<dyn Future<Output = ()> + Send>>;

/// Opens a WebSocket with little room, and takes nothing. When the hub closes it, again.
async fn never_read(place: String) {
    loop {
        let opened = async {
            let socket = TcpSocket::new_v4()?;
            socket.set_recv_buffer_size(4096)?;
            socket.connect(place.parse().map_err(std::io::Error::other)?).await
        };
        if let Ok(stream) = opened.await
            && let Ok(socket) = Socket::over(&place, stream).await
        {
            sleep(Duration::from_secs(30)).await;
            drop(socket);
        }
        sleep(PAUSE).await;
    }
}

async fn drip(place: String) {
    loop {
        if let Ok(mut stream) = TcpStream::connect(&place).await {
            for byte in b"GET /api/hub HTTP/1.1\r\nHost: 127.0.0.1\r\n" {
                if stream.write_all(&[*byte]).await.is_err() {
                    break;
                }
                sleep(Duration::from_secs(1)).await;
            }
        }
        sleep(PAUSE).await;
    }
}

async fn garbage(place: String, seed: u64, done: Arc<Done>) {
    let mut rng = Rng::new(seed + 1);
    loop {
        // What comes of it is the hub's business, not ours.
        _ = timeout(BRIEFLY, nonsense(&place, &mut rng)).await;
        done.garbage.fetch_add(1, Ordering::Relaxed);
        sleep(PAUSE).await;
    }
}

async fn nonsense(place: &str, rng: &mut Rng) -> Fallible<()> {
    let mut bytes: Vec<u8> = (0..below(rng, 2000)).map(|_| below(rng, 256) as u8).collect();
    let mut stream = TcpStream::connect(place).await?;
    let upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                   Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n";
    let head = match below(rng, 6) {
        0 => String::new(),
        1 => format!("GET /{} HTTP/1.1\r\nHost: {place}\r\n\r\n", "x".repeat(60_000)),
        2 => {
            format!("POST /api/login HTTP/1.1\r\nHost: {place}\r\nContent-Length: 99999999\r\n\r\n")
        }
        3 => format!(
            "POST /api/monitors/M1/requests HTTP/1.1\r\nHost: {place}\r\nContent-Length: {}\r\n\r\n",
            bytes.len()
        ),
        // Frames of the WebSocket that are none.
        4 => format!("GET /api/ws HTTP/1.1\r\nHost: {place}\r\n{upgrade}\r\n"),
        _ => {
            bytes = b"{\"type\":\"request\",\"monitor\":\"M1\",\"request\":\"Fly All\"}".to_vec();
            return talk(place, &bytes).await;
        }
    };
    stream.write_all(head.as_bytes()).await?;
    stream.write_all(&bytes).await?;
    stream.read_to_end(&mut Vec::new()).await?;
    Ok(())
}

async fn talk(place: &str, bytes: &[u8]) -> Fallible<()> {
    let mut socket = Socket::open(place).await?;
    let sound: serde_json::Value = serde_json::from_slice(bytes)?;
    socket.send(&sound).await?;
    socket.send(&serde_json::json!([{ "type": 5 }])).await?;
    Ok(())
}

async fn storm(place: String, seed: u64, done: Arc<Done>) {
    let mut rng = Rng::new(seed + 1000);
    loop {
        if let Ok(mut socket) = Socket::open(&place).await {
            if below(&mut rng, 2) == 0 {
                // Some look at what there is before they break off.
                _ = socket.next().await;
            }
            done.reconnects.fetch_add(1, Ordering::Relaxed);
        }
        sleep(PAUSE).await;
    }
}

/// A number below a bound.
pub fn below(rng: &mut Rng, bound: u64) -> u64 {
    (rng.unit() * bound as f64) as u64
}
