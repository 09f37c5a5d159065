//! The listener: connections, TLS, limits; each connection on a task of its own.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper_util::rt::{TokioIo, TokioTimer};
use rustls_pki_types::CertificateDer;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, watch};
use tokio::time::timeout;
use tokio_rustls::TlsAcceptor;
use tower::ServiceExt;

use crate::api::{self, Peer, Place};
use crate::hub::Hub;
use crate::{owner, tls};

/// A client has so long for the handshake of TLS, and for the headers of a request.
const PATIENCE: Duration = Duration::from_secs(15);
/// Rest after a connection that could not be taken, as when no file descriptor is left.
const REST: Duration = Duration::from_millis(100);
/// How long open requests have when the hub ends.
const FAREWELL: Duration = Duration::from_secs(3);

/// A hub that listens.
#[derive(Debug)]
pub struct Server {
    hub: Hub,
    listener: TcpListener,
    tls: Option<TlsAcceptorBox>,
}

/// An acceptor, which has no Debug of its own.
struct TlsAcceptorBox(TlsAcceptor);

impl std::fmt::Debug for TlsAcceptorBox {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("TlsAcceptor")
    }
}

impl Server {
    /// Listens. Nothing is polled yet.
    pub async fn bind(hub: Hub) -> io::Result<Self> {
        let tls = hub.config.tls.as_ref().map(tls::acceptor).transpose();
        let tls = tls.map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
        let tls = tls.map(TlsAcceptorBox);
        let listener = TcpListener::bind(hub.config.listen).await?;
        Ok(Self { hub, listener, tls })
    }

    /// Where it listens.
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
        // Nobody can open 0.0.0.0: the hub's own name, or this machine.
        let name = self.hub.config.names.first().map_or("localhost", String::as_str);
        Ok(format!("{scheme}://{name}:{}", address.port()))
    }

    /// The hub.
    pub const fn hub(&self) -> &Hub {
        &self.hub
    }

    /// Owns the links and serves clients until `end` is done.
    pub async fn serve(self, end: impl Future<Output = ()>) {
        let Self { hub, listener, tls } = self;
        owner::start(&hub);
        let router = api::router(hub.clone());
        let room = Arc::new(Semaphore::new(hub.config.connections_max));
        tokio::pin!(end);
        loop {
            let accepted = tokio::select! {
                accepted = listener.accept() => accepted,
                () = &mut end => break,
            };
            let Ok((stream, address)) = accepted else {
                tokio::time::sleep(REST).await;
                continue;
            };
            let Some(place) = Place::take(&hub, &room, address.ip()) else {
                tracing::warn!(%address, "too many connections");
                continue;
            };
            let router = router.clone();
            let acceptor = tls.as_ref().map(|tls| tls.0.clone());
            let ending = hub.ending.subscribe();
            let place = Arc::new(place);
            let peer = Peer { address, name: None, tls: acceptor.is_some(), place };
            // A connection that breaks concerns nobody but its client.
            tokio::spawn(
                async move { _ = connection(stream, peer, acceptor, router, ending).await },
            );
        }
        hub.ending.send_replace(true);
        let all = u32::try_from(hub.config.connections_max).unwrap_or(u32::MAX);
        _ = timeout(FAREWELL, room.acquire_many(all)).await;
        // What is noted now is stored before the program ends.
        _ = timeout(FAREWELL, hub.audit.note(hub.record_of_end())).await;
    }
}

async fn connection(
    stream: TcpStream,
    peer: Peer,
    acceptor: Option<TlsAcceptor>,
    router: Router,
    ending: watch::Receiver<bool>,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let Some(acceptor) = acceptor else {
        return requests(stream, peer, router, ending).await;
    };
    let stream = timeout(PATIENCE, acceptor.accept(stream)).await??;
    let certificates = stream.get_ref().1.peer_certificates();
    let name = certificates.and_then(|chain| common_name(chain.first()?));
    requests(stream, Peer { name, ..peer }, router, ending).await
}

async fn requests<S>(
    stream: S,
    peer: Peer,
    router: Router,
    mut ending: watch::Receiver<bool>,
) -> io::Result<()>
where
    S: AsyncRead + AsyncWrite + Send + Unpin + 'static,
{
    let service = hyper::service::service_fn(move |mut request: hyper::Request<_>| {
        request.extensions_mut().insert(peer.clone());
        router.clone().oneshot(request)
    });
    let connection = hyper::server::conn::http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(PATIENCE)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    tokio::pin!(connection);
    tokio::select! {
        result = connection.as_mut() => return result.map_err(io::Error::other),
        () = async { _ = ending.wait_for(|ending| *ending).await } => {}
    }
    connection.as_mut().graceful_shutdown();
    connection.await.map_err(io::Error::other)
}

fn common_name(certificate: &CertificateDer<'_>) -> Option<String> {
    let (_, certificate) = x509_parser::parse_x509_certificate(certificate).ok()?;
    let name = certificate.subject().iter_common_name().next()?.as_str().ok()?;
    Some(name.to_owned())
}
