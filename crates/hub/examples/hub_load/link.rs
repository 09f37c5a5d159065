//! Connections to the hub, in the clear and over TLS.

use std::path::Path;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use rustls_pki_types::pem::PemObject;
use rustls_pki_types::{CertificateDer, ServerName};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, ReadBuf};
use tokio::net::{TcpSocket, TcpStream};
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::{ClientConfig, RootCertStore};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;

use crate::Fallible;

/// Nothing that is waited for takes so long.
const PATIENCE: Duration = Duration::from_secs(60);

/// A connection.
pub enum Stream {
    Plain(TcpStream),
    Tls(Box<TlsStream<TcpStream>>),
}

/// A WebSocket.
pub type Socket = WebSocketStream<Stream>;

/// What connects to a hub with this certificate; `None`: in the clear.
pub fn connector(certificate: Option<&Path>) -> Fallible<Option<TlsConnector>> {
    let Some(path) = certificate else { return Ok(None) };
    let mut roots = RootCertStore::empty();
    roots.add(CertificateDer::from_pem_file(path)?)?;
    let mut config = ClientConfig::builder().with_root_certificates(roots).with_no_client_auth();
    // Each handshake is a whole one.
    config.resumption = tokio_rustls::rustls::client::Resumption::disabled();
    Ok(Some(TlsConnector::from(Arc::new(config))))
}

pub async fn connect(place: &str, tls: Option<&TlsConnector>) -> Fallible<Stream> {
    connect_from("127.0.0.1", place, tls).await
}

/// Connects from an address of this machine: what the hub counts by address, it counts apart.
pub async fn connect_from(own: &str, place: &str, tls: Option<&TlsConnector>) -> Fallible<Stream> {
    let socket = TcpSocket::new_v4()?;
    socket.bind(std::net::SocketAddr::new(own.parse()?, 0))?;
    let stream = socket.connect(place.parse()?).await?;
    stream.set_nodelay(true)?;
    let Some(tls) = tls else { return Ok(Stream::Plain(stream)) };
    let stream = tls.connect(ServerName::try_from("localhost")?, stream).await?;
    Ok(Stream::Tls(Box::new(stream)))
}

/// A request on a connection, which ends with it: the status of the answer, its head and its body.
pub async fn ask(
    mut stream: Stream,
    (method, path): (&str, &str),
    headers: &str,
    body: &[u8],
) -> Fallible<(u16, String, Vec<u8>)> {
    let head = format!(
        "{method} {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{headers}\
         Content-Length: {}\r\n\r\n",
        body.len()
    );
    let mut answer = Vec::new();
    timeout(PATIENCE, async {
        stream.write_all(&[head.as_bytes(), body].concat()).await?;
        stream.read_to_end(&mut answer).await
    })
    .await??;
    let end = answer.windows(4).position(|it| it == b"\r\n\r\n").ok_or("no answer")?;
    let body = answer.split_off(end + 4);
    let head = String::from_utf8_lossy(&answer).into_owned();
    let status = head.split(' ').nth(1).and_then(|it| it.parse().ok()).ok_or("no status")?;
    Ok((status, head, body))
}

/// The header of a token; none, where no client logs in.
pub fn authorization(token: &str) -> String {
    if token.is_empty() { String::new() } else { format!("Authorization: Bearer {token}\r\n") }
}

/// A WebSocket over a connection.
pub async fn socket(stream: Stream, place: &str, token: &str) -> Fallible<Socket> {
    let mut request = format!("ws://{place}/api/ws").into_client_request()?;
    if !token.is_empty() {
        request.headers_mut().insert("Authorization", format!("Bearer {token}").parse()?);
    }
    Ok(tokio_tungstenite::client_async(request, stream).await?.0)
}

impl AsyncRead for Stream {
    fn poll_read(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<std::io::Result<()>> {
        match self.get_mut() {
            Self::Plain(stream) => Pin::new(stream).poll_read(cx, buffer),
            Self::Tls(stream) => Pin::new(stream).poll_read(cx, buffer),
        }
    }
}

impl AsyncWrite for Stream {
    fn poll_write(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<std::io::Result<usize>> {
        match self.get_mut() {
            Self::Plain(stream) => Pin::new(stream).poll_write(cx, bytes),
            Self::Tls(stream) => Pin::new(stream).poll_write(cx, bytes),
        }
    }

    fn poll_flush(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<std::io::Result<()>> {
        match self.get_mut() {
            Self::Plain(stream) => Pin::new(stream).poll_flush(cx),
            Self::Tls(stream) => Pin::new(stream).poll_flush(cx),
        }
    }

    fn poll_shutdown(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<std::io::Result<()>> {
        match self.get_mut() {
            Self::Plain(stream) => Pin::new(stream).poll_shutdown(cx),
            Self::Tls(stream) => Pin::new(stream).poll_shutdown(cx),
        }
    }
}
