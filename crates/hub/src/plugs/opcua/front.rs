//! In front of the library: who may connect, how many, how much and how fast. It reads the headers of chunks, learns from
//! them which channel is whose, and reads what is not encrypted of requests for channels. The library listens on a port of
//! the loopback of its own, and has a thread of its own: what is seen here of its time is seen in steps.

use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use opcua::crypto::SecurityPolicy;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Mutex, Notify, Semaphore};
use tokio::time::{Instant, sleep, sleep_until, timeout};

use super::door::{self, No, Opening};
use super::peers::Peers;
use super::{Server, ServerConfig};
use crate::access::Bucket;
use crate::field::line::said;
use crate::hub::Hub;
use crate::sync::lock;
use crate::text::Both;

/// Longest chunk, bytes.
pub const CHUNK_MAX: usize = 65_535;
/// Shortest chunk: type, whether it is the last one, size.
const HEADER: usize = 8;
/// A chunk is complete within this time, and what is sent is taken within it.
const WITHIN: Duration = Duration::from_secs(5);
/// Requests of a connection that have no answer yet: more are read later.
const UNANSWERED_MAX: usize = 64;
/// Channels that are opened, at once and per second: each makes the hub decrypt.
const OPENED: (f64, f64) = (16.0, 4.0);
/// Connections beside those with a session.
const SPARE: usize = 8;
/// Answers to strangers are sent in such steps: longer than the library works for one.
const STEP: Duration = Duration::from_millis(100);
/// A connection without a channel that may be used ends after this time.
const STRANGER: Duration = Duration::from_secs(10);
/// Rest after a connection that could not be taken.
const REST: Duration = Duration::from_millis(100);

/// What a chunk is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chunk {
    /// The beginning of a connection.
    Hello,
    /// A channel is opened, or its keys are changed.
    Open,
    /// The last chunk of a message.
    Last,
    /// The channel is closed.
    Close,
    /// Another one.
    Other,
}

/// Reads a header: what follows it, bytes, and what it is. `None`: it is none.
pub fn header(bytes: [u8; HEADER], from_client: bool) -> Option<(Chunk, usize)> {
    let size = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize;
    let rest = size.checked_sub(HEADER).filter(|_| size <= CHUNK_MAX)?;
    let chunk = match (&bytes[..3], bytes[3]) {
        (b"HEL", b'F') if from_client => Chunk::Hello,
        (b"ACK" | b"ERR", b'F') if !from_client => Chunk::Other,
        // The number of the channel.
        (b"OPN", b'F') if rest >= 4 => Chunk::Open,
        (b"MSG", b'F') if rest >= 4 => Chunk::Last,
        (b"MSG", b'C' | b'A') if rest >= 4 => Chunk::Other,
        (b"CLO", b'F') if rest >= 4 && from_client => Chunk::Close,
        _ => return None,
    };
    Some((chunk, rest))
}

/// Whether a client of this address may connect.
fn is_allowed(config: &ServerConfig, from: IpAddr) -> bool {
    let from = from.to_canonical();
    if config.allow.is_empty() {
        from.is_loopback()
    } else {
        config.allow.iter().any(|it| it.has(from))
    }
}

/// What all connections share.
struct Shared {
    hub: Hub,
    server: Arc<Server>,
    peers: Peers,
    inner: SocketAddr,
    opened: Mutex<Bucket>,
    open: std::sync::Mutex<Vec<IpAddr>>,
}

/// Takes connections, for the library that listens at `inner`.
pub async fn run(
    hub: Hub,
    server: Arc<Server>,
    peers: Peers,
    (listener, inner): (std::net::TcpListener, SocketAddr),
) -> Both {
    let listener = match TcpListener::from_std(listener) {
        Ok(listener) => listener,
        Err(error) => return said(&error),
    };
    let shared = Arc::new(Shared {
        hub: hub.clone(),
        server: server.clone(),
        peers,
        inner,
        opened: Mutex::new(Bucket::new(hub.now(), OPENED.0, OPENED.1)),
        open: std::sync::Mutex::default(),
    });
    loop {
        let (stream, from) = match listener.accept().await {
            Ok(accepted) => accepted,
            // As when no file descriptor is left: the open ones go on.
            Err(_) => {
                sleep(REST).await;
                continue;
            }
        };
        let Some(place) = Place::take(&shared, from) else {
            server.counts.count(|it| &it.rejected);
            tracing::warn!(server = server.config.name, %from, "an OPC UA connection is rejected");
            continue;
        };
        let shared = shared.clone();
        tokio::spawn(async move {
            let end = connection(&shared, stream, from).await;
            shared.peers.went(from);
            match end {
                End::Closed => {}
                End::Malformed | End::Refused(No::Malformed) => {
                    shared.server.counts.count(|it| &it.malformed);
                }
                End::Refused(why) => {
                    shared.server.counts.count(|it| &it.rejected);
                    let (server, why) = (&shared.server.config.name, why.words());
                    tracing::warn!(server, %from, why, "an OPC UA channel is refused");
                }
            }
            drop(place);
        });
    }
}

/// A place for a connection.
struct Place {
    shared: Arc<Shared>,
    from: IpAddr,
}

impl Place {
    fn take(shared: &Arc<Shared>, from: SocketAddr) -> Option<Self> {
        let config = &shared.server.config;
        let (from, most) = (from.ip(), config.sessions_max + SPARE);
        let mut open = lock(&shared.open);
        let own = open.iter().filter(|it| **it == from).count();
        // Those of one address leave room for others.
        let is_full = open.len() >= most || own >= most.div_ceil(2);
        if is_full || !is_allowed(config, from) {
            return None;
        }
        open.push(from);
        Some(Self { shared: shared.clone(), from })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut open = lock(&self.shared.open);
        if let Some(at) = open.iter().position(|it| *it == self.from) {
            open.swap_remove(at);
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Closed,
    Malformed,
    /// The client is to know why.
    Refused(No),
}

impl From<io::Error> for End {
    fn from(_: io::Error) -> Self {
        Self::Closed
    }
}

async fn connection(shared: &Arc<Shared>, mut client: TcpStream, from: SocketAddr) -> End {
    let connected = timeout(WITHIN, TcpStream::connect(shared.inner)).await;
    let Ok(Ok(library)) = connected else { return End::Closed };
    if client.set_nodelay(true).and_then(|()| library.set_nodelay(true)).is_err() {
        return End::Closed;
    }
    let line = Line::new(from);
    let library = library.into_split();
    let ended = {
        let (asks, hears) = client.split();
        tokio::select! {
            ended = requests(shared, &line, asks, library.1) => ended,
            ended = answers(shared, &line, library.0, hears) => ended,
            () = line.lapse() => Err(End::Closed),
            () = line.end.notified() => Err(End::Closed),
        }
    };
    let end = ended.err().unwrap_or(End::Closed);
    if let End::Refused(no) = end {
        _ = timeout(WITHIN, say(&mut client, no)).await;
    }
    end
}

/// A connection.
struct Line {
    from: SocketAddr,
    /// Requests that may still be sent before an answer.
    unanswered: Semaphore,
    /// The security with which the channel was opened.
    policy: OnceLock<SecurityPolicy>,
    /// The library has opened the channel for who may use it.
    known: AtomicBool,
    began: Instant,
    /// When the library was asked last for what it does for strangers.
    asked: std::sync::Mutex<Instant>,
    /// The connection is to end.
    end: Arc<Notify>,
}

impl Line {
    fn new(from: SocketAddr) -> Self {
        let now = Instant::now();
        Self {
            from,
            unanswered: Semaphore::new(UNANSWERED_MAX),
            policy: OnceLock::new(),
            known: AtomicBool::new(false),
            began: now,
            asked: std::sync::Mutex::new(now),
            end: Arc::default(),
        }
    }

    fn is_known(&self) -> bool {
        self.known.load(Ordering::Relaxed)
    }

    /// A stranger's connection ends.
    async fn lapse(&self) {
        sleep_until(self.began + STRANGER).await;
        if self.is_known() {
            std::future::pending().await
        }
    }

    /// Until the time of an answer to a stranger: whole steps after the question, so that it does not show for how
    /// long the library has worked with its key.
    async fn wait_to_answer(&self) {
        let asked = *lock(&self.asked);
        let steps = asked.elapsed().as_nanos() / STEP.as_nanos() + 1;
        sleep_until(asked + STEP * u32::try_from(steps).unwrap_or(1)).await;
    }
}

/// Says why a connection ends, and lets the client read it.
async fn say(client: &mut TcpStream, no: No) -> io::Result<()> {
    let words = no.words().as_bytes();
    let size = HEADER + 8 + words.len();
    let mut message = b"ERRF".to_vec();
    message.extend(u32::try_from(size).unwrap_or_default().to_le_bytes());
    message.extend(no.status().to_le_bytes());
    message.extend(u32::try_from(words.len()).unwrap_or_default().to_le_bytes());
    message.extend(words);
    client.write_all(&message).await?;
    client.shutdown().await?;
    let (mut buffer, mut left) = ([0; 1024], CHUNK_MAX);
    while left > 0 {
        match client.read(&mut buffer).await? {
            0 => break,
            read => left = left.saturating_sub(read),
        }
    }
    Ok(())
}

/// Reads a chunk. Its beginning is waited for: `first`, for so long.
async fn read(
    stream: &mut (impl AsyncRead + Unpin),
    buffer: &mut Vec<u8>,
    from_client: bool,
    first: Option<Duration>,
) -> Result<Chunk, End> {
    let mut bytes = [0; HEADER];
    let begin = stream.read_exact(&mut bytes[..1]);
    match first {
        Some(within) => _ = timeout(within, begin).await.map_err(|_| End::Malformed)??,
        None => _ = begin.await?,
    }
    let rest = async {
        stream.read_exact(&mut bytes[1..]).await?;
        let (chunk, rest) = header(bytes, from_client).ok_or(End::Malformed)?;
        buffer.clear();
        buffer.extend_from_slice(&bytes);
        buffer.resize(HEADER + rest, 0);
        stream.read_exact(&mut buffer[HEADER..]).await?;
        Ok::<_, End>(chunk)
    };
    timeout(WITHIN, rest).await.map_err(|_| End::Malformed)?
}

async fn write(stream: &mut (impl AsyncWrite + Unpin), buffer: &[u8]) -> Result<(), End> {
    timeout(WITHIN, stream.write_all(buffer)).await.map_err(|_| End::Closed)??;
    Ok(())
}

async fn requests(
    shared: &Arc<Shared>,
    line: &Line,
    mut client: impl AsyncRead + Unpin,
    mut library: impl AsyncWrite + Unpin,
) -> Result<(), End> {
    let mut buffer = Vec::new();
    let mut first = Some(WITHIN);
    loop {
        let chunk = read(&mut client, &mut buffer, true, first.take()).await?;
        if chunk == Chunk::Open {
            shared.open(line, &buffer[HEADER..]).await?;
        } else if !line.is_known() && !may_be_asked(chunk, &buffer[HEADER..]) {
            return Err(End::Refused(No::Policy));
        }
        if chunk == Chunk::Last {
            shared.server.counts.count(|it| &it.requests);
            line.unanswered.acquire().await.map_err(|_| End::Closed)?.forget();
        }
        if chunk == Chunk::Open || !line.is_known() {
            *lock(&line.asked) = Instant::now();
        }
        write(&mut library, &buffer).await?;
    }
}

/// Whether a stranger may send it.
fn may_be_asked(chunk: Chunk, body: &[u8]) -> bool {
    match chunk {
        Chunk::Hello | Chunk::Open | Chunk::Close => true,
        Chunk::Last => door::is_discovery(body),
        Chunk::Other => false,
    }
}

async fn answers(
    shared: &Arc<Shared>,
    line: &Line,
    mut library: impl AsyncRead + Unpin,
    mut client: impl AsyncWrite + Unpin,
) -> Result<(), End> {
    let mut buffer = Vec::new();
    loop {
        let chunk = read(&mut library, &mut buffer, false, None).await;
        if !line.is_known() || !matches!(chunk, Ok(Chunk::Last | Chunk::Other)) {
            line.wait_to_answer().await;
        }
        let chunk = chunk?;
        if chunk == Chunk::Open {
            let number = [buffer[8], buffer[9], buffer[10], buffer[11]];
            shared.peers.came(u32::from_le_bytes(number), line.from, &line.end);
            let plain = shared.server.config.plain;
            let known = |it: &SecurityPolicy| *it != SecurityPolicy::None || plain;
            line.known.store(line.policy.get().is_some_and(known), Ordering::Relaxed);
        }
        write(&mut client, &buffer).await?;
        if chunk == Chunk::Last && line.unanswered.available_permits() < UNANSWERED_MAX {
            line.unanswered.add_permits(1);
        }
    }
}

impl Shared {
    /// A channel is to be opened, or its keys changed: with the same security.
    async fn open(&self, line: &Line, body: &[u8]) -> Result<(), End> {
        let opening = Opening::read(body).map_err(End::Refused)?;
        if *line.policy.get_or_init(|| opening.policy) != opening.policy {
            return Err(End::Refused(No::Policy));
        }
        opening.check(&self.server.config).map_err(End::Refused)?;
        if opening.policy == SecurityPolicy::None {
            return Ok(());
        }
        // In turns: those who wait are served in their order.
        let mut opened = self.opened.lock().await;
        while let Err(wait) = opened.take(self.hub.now()) {
            sleep(wait).await;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(kind: &[u8; 4], size: u32) -> [u8; HEADER] {
        let mut bytes = [0; HEADER];
        bytes[..4].copy_from_slice(kind);
        bytes[4..].copy_from_slice(&size.to_le_bytes());
        bytes
    }

    #[test]
    fn headers_are_read_and_their_sizes_are_bounded() {
        assert_eq!(header(head(b"HELF", 40), true), Some((Chunk::Hello, 32)));
        assert_eq!(header(head(b"OPNF", 132), true), Some((Chunk::Open, 124)));
        assert_eq!(header(head(b"MSGF", 65_535), true), Some((Chunk::Last, 65_527)));
        assert_eq!(header(head(b"MSGC", 100), false), Some((Chunk::Other, 92)));
        for (bytes, from_client) in [
            (head(b"MSGF", 65_536), true),
            (head(b"MSGF", u32::MAX), true),
            (head(b"MSGF", 0), true),
            (head(b"MSGF", 11), true),
            (head(b"HELF", 7), true),
            (head(b"HELF", 40), false),
            (head(b"ACKF", 28), true),
            (head(b"RHEF", 28), true),
            (head(b"GET ", 28), true),
            (head(b"MSGX", 28), true),
        ] {
            assert_eq!(header(bytes, from_client), None, "{bytes:?}");
        }
    }

    #[tokio::test]
    async fn a_chunk_that_never_ends_is_given_up() {
        tokio::time::pause();
        let (mut client, mut server) = tokio::io::duplex(1024);
        client.write_all(&head(b"MSGF", 1000)).await.unwrap();
        let mut buffer = Vec::new();
        let result = read(&mut server, &mut buffer, true, None).await;
        assert_eq!(result, Err(End::Malformed));
        assert!(buffer.len() <= 1000);
        let result = read(&mut server, &mut buffer, true, Some(WITHIN)).await;
        assert_eq!(result, Err(End::Malformed), "nothing comes at all");
    }
}
