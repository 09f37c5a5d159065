//! In front of the library: who may connect, how many, how much and how fast. It reads no more than the headers of chunks,
//! and learns from them which channel is whose. The library listens on a port of the loopback of its own.

use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Mutex, Semaphore};
use tokio::time::{sleep, timeout};

use super::peers::Peers;
use super::{Server, ServerConfig};
use crate::access::Bucket;
use crate::hub::Hub;
use crate::sync::lock;

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
        (b"CLO", b'F') if rest >= 4 => Chunk::Other,
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
    hub: &Hub,
    server: &Arc<Server>,
    peers: &Peers,
    (listener, inner): (TcpListener, SocketAddr),
) {
    let shared = Arc::new(Shared {
        hub: hub.clone(),
        server: server.clone(),
        peers: peers.clone(),
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
            if end == End::Malformed {
                shared.server.counts.count(|it| &it.malformed);
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
}

impl From<io::Error> for End {
    fn from(_: io::Error) -> Self {
        Self::Closed
    }
}

async fn connection(shared: &Arc<Shared>, client: TcpStream, from: SocketAddr) -> End {
    let connected = timeout(WITHIN, TcpStream::connect(shared.inner)).await;
    let Ok(Ok(library)) = connected else { return End::Closed };
    if client.set_nodelay(true).and_then(|()| library.set_nodelay(true)).is_err() {
        return End::Closed;
    }
    let (client, library) = (client.into_split(), library.into_split());
    let unanswered = Arc::new(Semaphore::new(UNANSWERED_MAX));
    let ended = tokio::select! {
        ended = requests(shared, client.0, library.1, &unanswered) => ended,
        ended = answers(shared, library.0, client.1, (&unanswered, from)) => ended,
    };
    ended.err().unwrap_or(End::Closed)
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
    mut client: impl AsyncRead + Unpin,
    mut library: impl AsyncWrite + Unpin,
    unanswered: &Semaphore,
) -> Result<(), End> {
    let mut buffer = Vec::new();
    let mut first = Some(WITHIN);
    loop {
        let chunk = read(&mut client, &mut buffer, true, first.take()).await?;
        match chunk {
            Chunk::Open => shared.wait_to_open().await,
            Chunk::Last => {
                shared.server.counts.count(|it| &it.requests);
                unanswered.acquire().await.map_err(|_| End::Closed)?.forget();
            }
            Chunk::Hello | Chunk::Other => {}
        }
        write(&mut library, &buffer).await?;
    }
}

async fn answers(
    shared: &Arc<Shared>,
    mut library: impl AsyncRead + Unpin,
    mut client: impl AsyncWrite + Unpin,
    (unanswered, from): (&Semaphore, SocketAddr),
) -> Result<(), End> {
    let mut buffer = Vec::new();
    loop {
        let chunk = read(&mut library, &mut buffer, false, None).await?;
        if chunk == Chunk::Open {
            let number = [buffer[8], buffer[9], buffer[10], buffer[11]];
            shared.peers.came(u32::from_le_bytes(number), from);
        }
        write(&mut client, &buffer).await?;
        if chunk == Chunk::Last && unanswered.available_permits() < UNANSWERED_MAX {
            unanswered.add_permits(1);
        }
    }
}

impl Shared {
    async fn wait_to_open(&self) {
        // In turns: those who wait are served in their order.
        let mut opened = self.opened.lock().await;
        while let Err(wait) = opened.take(self.hub.now()) {
            sleep(wait).await;
        }
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
