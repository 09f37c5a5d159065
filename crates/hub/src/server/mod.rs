//! The listener: connections, TLS, limits; each connection on a task of its own.

pub mod allowances;
pub mod paced;
pub mod tls;

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use hyper::body::{Body, Frame, Incoming, SizeHint};
use hyper_util::rt::{TokioIo, TokioTimer};
use rustls_pki_types::CertificateDer;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::Semaphore;
use tokio::time::{Instant, Sleep, sleep, timeout};
use tokio_rustls::TlsAcceptor;
use tower::ServiceExt;

use crate::api::{self, Peer, Place};
use crate::hub::{Hub, Shutdown};
use crate::monitor::owner;
use crate::server::paced::Paced;
use crate::sync::lock;

/// Longest TLS handshake, and longest time until the headers of a request are complete.
const PATIENCE: Duration = Duration::from_secs(15);
/// The body of a request begins within this time, and then comes at this rate, bytes a second.
const BODY_PATIENCE: Duration = Duration::from_secs(5);
const BODY_RATE: f64 = 16384.0;
/// Readings that a handshake of TLS counts as: it costs the processor as much as many requests.
const HANDSHAKE: f64 = 20.0;
/// What is read and written at once, and the longest head of a request: a connection that is flooded keeps two of them.
const BUFFER_MAX: usize = 32 * 1024;
/// What the system keeps of what a connection has sent, until it is read: by itself it would keep MiB of each.
const UNREAD: u32 = 128 * 1024;
/// Connections that wait to be accepted.
const WAITING_MAX: u32 = 4096;
/// Rest after a connection that could not be taken, as when no file descriptor is left.
const REST: Duration = Duration::from_millis(100);
/// How long open requests have when the hub ends.
const FAREWELL: Duration = Duration::from_secs(3);

/// A hub that listens.
#[derive(Debug)]
pub struct Server {
    hub: Hub,
    listener: TcpListener,
    tls: Option<Arc<tls::Reloading>>,
}

impl Server {
    /// Listens. Nothing is polled yet.
    pub async fn bind(hub: Hub) -> io::Result<Self> {
        let tls = hub.config().tls.as_ref().map(tls::Reloading::new).transpose();
        let tls = tls.map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
        let tls = tls.map(Arc::new);
        let listener = listener(hub.config().listen)?;
        Ok(Self { hub, listener, tls })
    }

    /// Address of the listener.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// What to open in a browser.
    pub fn url(&self) -> io::Result<String> {
        let scheme = if self.tls.is_some() { "https" } else { "http" };
        let address = self.address()?;
        if !address.ip().is_unspecified() {
            return Ok(format!("{scheme}://{address}"));
        }
        // A browser cannot open 0.0.0.0: the hub's own name, or this machine.
        let name = self.hub.config().names.first().map_or("localhost", String::as_str);
        Ok(format!("{scheme}://{name}:{}", address.port()))
    }

    /// The hub.
    pub const fn hub(&self) -> &Hub {
        &self.hub
    }

    /// Owns the links and serves clients until `end` is done, or a part of the hub that always runs has ended.
    pub async fn serve(self, end: impl Future<Output = ()>) {
        let Self { hub, listener, tls } = self;
        owner::start(&hub);
        let (own, certificates) = (hub.clone(), tls.clone());
        drop(hub.again("upkeep", move || own.clone().look_after(certificates.clone())));
        let router = api::router(hub.clone());
        let room = Arc::new(Semaphore::new(hub.config().connections_max));
        tokio::pin!(end);
        loop {
            let accepted = tokio::select! {
                accepted = listener.accept() => accepted,
                () = &mut end => break,
                () = hub.failed() => break,
            };
            let (stream, address) = match accepted {
                Ok(accepted) => accepted,
                Err(error) if is_of_one(&error) => continue,
                Err(_) => {
                    sleep(REST).await;
                    continue;
                }
            };
            let Some(place) = Place::take(&hub, &room, address.ip()) else {
                tracing::warn!(%address, "too many connections");
                continue;
            };
            let router = router.clone();
            let acceptor = tls.as_ref().map(|tls| tls.acceptor());
            let shutdown = hub.shutdown();
            let place = Arc::new(place);
            let (name, ends_ms) = (None, None);
            let peer = Peer { address, name, ends_ms, tls: acceptor.is_some(), place };
            // An error of a connection concerns its client alone.
            let start = hub.start();
            tokio::spawn(async move {
                let place = peer.place.clone();
                let served = connection(stream, start, peer, acceptor, router, shutdown);
                tokio::select! {
                    _ = served => {}
                    () = place.given_up() => {}
                }
            });
        }
        hub.begin_shutdown();
        crate::plugs::mqtt::ended(&hub).await;
        crate::plugs::opcua::ended(&hub).await;
        let all = u32::try_from(hub.config().connections_max).unwrap_or(u32::MAX);
        _ = timeout(FAREWELL, room.acquire_many(all)).await;
        // What is noted now is stored before the program ends.
        _ = timeout(FAREWELL, hub.audit().note(hub.record_of_end())).await;
        _ = timeout(FAREWELL, hub.note_end()).await;
        _ = timeout(FAREWELL, hub.log_head()).await;
        hub.settle().await;
    }
}

/// Whether an error of accepting concerns the one connection that was given up before it was taken: with a rest after
/// each, a client that connects and gives up would keep the others out.
fn is_of_one(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionReset, Interrupted};
    matches!(error.kind(), ConnectionAborted | ConnectionReset | Interrupted)
}

/// Listens, with more room for those who connect than by default: one for whom there is none tries again a second later.
fn listener(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    // As the default: a restart does not wait for connections that have ended. Windows means another thing by it.
    #[cfg(not(windows))]
    socket.set_reuseaddr(true)?;
    // Those that are accepted have the same.
    socket.set_recv_buffer_size(UNREAD)?;
    socket.bind(address)?;
    socket.listen(WAITING_MAX)
}

async fn connection(
    stream: TcpStream,
    start: Instant,
    peer: Peer,
    acceptor: Option<TlsAcceptor>,
    router: Router,
    shutdown: Shutdown,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let stream = Paced::of(stream, &peer.place, start);
    let Some(acceptor) = acceptor else {
        return requests(stream, start, peer, router, shutdown).await;
    };
    let under_way = peer.place.handshake();
    let stream = timeout(PATIENCE, acceptor.accept(stream.charged(HANDSHAKE))).await??;
    drop(under_way);
    let certificates = stream.get_ref().1.peer_certificates();
    let first = certificates.and_then(|chain| chain.first());
    let (name, ends_ms) = (first.and_then(common_name), first.and_then(tls::end_ms));
    requests(stream, start, Peer { name, ends_ms, ..peer }, router, shutdown).await
}

async fn requests<S>(
    stream: S,
    start: Instant,
    peer: Peer,
    router: Router,
    mut shutdown: Shutdown,
) -> io::Result<()>
where
    S: AsyncRead + AsyncWrite + Send + Unpin + 'static,
{
    // Many requests may come in one reading.
    let own = peer.place.allowance.requests.clone();
    let service = hyper::service::service_fn(move |mut request: hyper::Request<Incoming>| {
        request.extensions_mut().insert(peer.clone());
        let wait = lock(&own).take(start.elapsed()).err();
        let answered = router.clone().oneshot(request.map(Timely::new));
        async move {
            // A connection does one request in its turn, however many have come in one reading.
            tokio::task::yield_now().await;
            let answer = answered.await;
            // What was asked is done at once; the next request is what waits.
            if let Some(wait) = wait {
                sleep(wait).await;
            }
            answer
        }
    });
    let connection = hyper::server::conn::http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(PATIENCE)
        // Who asks and closes at once, as a script with a short patience does, has asked all the same.
        .half_close(true)
        .max_buf_size(BUFFER_MAX)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    tokio::pin!(connection);
    tokio::select! {
        result = connection.as_mut() => return result.map_err(io::Error::other),
        () = shutdown.requested() => {}
    }
    connection.as_mut().graceful_shutdown();
    connection.await.map_err(io::Error::other)
}

/// A body that comes in time.
struct Timely<B> {
    body: B,
    bytes: f64,
    start: Instant,
    due: Pin<Box<Sleep>>,
}

impl<B> Timely<B> {
    fn new(body: B) -> Self {
        let start = Instant::now();
        Self { body, bytes: 0.0, start, due: Box::pin(sleep(BODY_PATIENCE)) }
    }
}

impl<B> Body for Timely<B>
where
    B: Body<Data = Bytes, Error: std::error::Error + Send + Sync + 'static> + Unpin,
{
    type Data = Bytes;
    type Error = io::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, io::Error>>> {
        let frame = Pin::new(&mut self.body).poll_frame(cx).map_err(io::Error::other);
        if frame.is_pending() {
            return self.due.as_mut().poll(cx).map(|()| Some(Err(io::ErrorKind::TimedOut.into())));
        }
        if let Poll::Ready(Some(Ok(frame))) = &frame
            && let Some(data) = frame.data_ref()
        {
            self.bytes += data.len() as f64;
            let allowed = Duration::from_secs_f64(self.bytes / BODY_RATE);
            let due = self.start + BODY_PATIENCE + allowed;
            self.due.as_mut().reset(due);
        }
        frame
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

fn common_name(certificate: &CertificateDer<'_>) -> Option<String> {
    let (_, certificate) = x509_parser::parse_x509_certificate(certificate).ok()?;
    let name = certificate.subject().iter_common_name().next()?.as_str().ok()?;
    Some(name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::body::Body as AxumBody;
    use futures_util::{StreamExt, stream};
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    #[test]
    fn who_gives_up_before_being_taken_does_not_hold_up_others() {
        use io::ErrorKind::{ConnectionAborted, ConnectionReset, Interrupted, OutOfMemory};
        for kind in [ConnectionAborted, ConnectionReset, Interrupted] {
            assert!(is_of_one(&kind.into()), "{kind}");
        }
        assert!(!is_of_one(&OutOfMemory.into()));
        // EMFILE: accepting again at once would fail again and again.
        #[cfg(unix)]
        assert!(!is_of_one(&io::Error::from_raw_os_error(24)));
    }

    /// A client that has sent much, and was read as fast, is given no more room for what is not read.
    #[tokio::test]
    async fn the_system_keeps_little_of_what_is_not_read() {
        const PARTS: usize = 256;
        let listener = listener("127.0.0.1:0".parse().unwrap()).unwrap();
        let socket = TcpSocket::new_v4().unwrap();
        socket.set_send_buffer_size(16 * 1024).unwrap();
        let connect = socket.connect(listener.local_addr().unwrap());
        let (client, accepted) = tokio::join!(connect, listener.accept());
        let (mut client, (mut stream, _)) = (client.unwrap(), accepted.unwrap());
        let part = vec![0; 64 * 1024];
        let sends = async {
            for _ in 0..PARTS {
                client.write_all(&part).await.unwrap();
            }
        };
        let reads = async {
            let (mut buffer, mut left) = (vec![0; 1 << 20], PARTS * part.len());
            while left > 0 {
                left -= stream.read(&mut buffer).await.unwrap();
            }
        };
        tokio::join!(sends, reads);
        let (mut kept, rest) = (0, Duration::from_millis(300));
        while let Ok(Ok(len)) = timeout(rest, client.write(&part)).await {
            kept += len;
        }
        assert!(kept < 512 * 1024, "{kept} bytes");
        drop(stream);
    }

    /// How long a body is read until it fails, and what came of it: a part at each of these times.
    async fn read(parts: &[u64]) -> (Duration, usize) {
        let start = Instant::now();
        let parts = stream::iter(parts.to_vec()).then(move |at_s| async move {
            tokio::time::sleep_until(start + Duration::from_secs(at_s)).await;
            Ok::<_, io::Error>(Bytes::from(vec![0; 16 * 1024]))
        });
        let body = AxumBody::from_stream(parts.chain(stream::pending()));
        let mut body = AxumBody::new(Timely::new(body)).into_data_stream();
        let mut count = 0;
        let read = async {
            while let Some(Ok(_)) = body.next().await {
                count += 1;
            }
        };
        let ended = timeout(Duration::from_secs(3600), read).await;
        assert!(ended.is_ok(), "it is read for ever");
        (start.elapsed(), count)
    }

    #[tokio::test(start_paused = true)]
    async fn a_body_that_does_not_come_is_given_up() {
        assert_eq!(read(&[]).await, (BODY_PATIENCE, 0));
        // A second more for each 16 KiB.
        assert_eq!(read(&[4, 5, 6, 7, 8]).await, (BODY_PATIENCE + Duration::from_secs(5), 5));
        assert_eq!(read(&[4, 7]).await.1, 1);
    }
}
