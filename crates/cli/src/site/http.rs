//! The API of a hub: one request at a time, with a token, over HTTP or HTTPS.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use http_body_util::{BodyExt, Full, Limited};
use hyper::body::Bytes;
use hyper::client::conn::http1;
use hyper::header::{ACCEPT, AUTHORIZATION, CONTENT_TYPE, HOST};
use hyper::{Method, Request, Uri};
use hyper_util::rt::TokioIo;
use lafet_acceptance::order::Posting;
use lafet_acceptance::{Failed, Stopped, Wire};
use lafet_texts::{Shown, Text as _, Words, cli as text};
use serde_json::Value;
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep, timeout};
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore, crypto};

use super::console::Shared;

/// An answer is waited for so long; the parameters of a monitor may take 8 s; what ends something is sent again soon.
const ANSWER: Duration = Duration::from_secs(5);
const PARAMS: Duration = Duration::from_secs(15);
const ENDS: Duration = Duration::from_secs(2);
/// Longest answer that is read, bytes.
const ANSWER_MAX: usize = 16 << 20;

/// Where the hub is, and who asks.
#[derive(Clone, Debug, Default)]
pub struct Access {
    /// `http://HOST:PORT` or `https://…`.
    pub url: String,
    /// A token of the hub.
    pub token: Option<String>,
    /// Certificate of the authority that the hub's is signed by, PEM; without it the system's.
    pub ca: Option<PathBuf>,
}

/// The hub.
pub struct Hub {
    uri: Uri,
    token: Option<String>,
    tls: Option<TlsConnector>,
    console: Shared,
    began: Instant,
    /// What was started is being ended: no stop cuts a request short.
    ending: bool,
}

impl Hub {
    /// Checks what was given; nothing is connected yet.
    pub fn new(access: &Access, console: Shared) -> Result<Self, Words> {
        let wrong = || text::SiteBadUrl { url: &access.url }.words();
        let uri: Uri = access.url.trim_end_matches('/').parse().map_err(|_| wrong())?;
        let tls = match uri.scheme_str() {
            Some("http") => None,
            Some("https") => Some(connector(access)?),
            _ => return Err(wrong()),
        };
        if uri.host().is_none() || !matches!(uri.path(), "" | "/") || uri.query().is_some() {
            return Err(wrong());
        }
        Ok(Self {
            uri,
            token: access.token.clone(),
            tls,
            console,
            began: Instant::now(),
            ending: false,
        })
    }

    fn host(&self) -> &str {
        self.uri.host().unwrap_or_default()
    }

    /// Whether the hub runs on this computer.
    fn is_here(&self) -> bool {
        matches!(self.host(), "localhost" | "[::1]" | "::1") || self.host().starts_with("127.")
    }

    /// Asks; a person who stops the test meanwhile is not kept waiting for the answer.
    async fn ask(&self, method: Method, path: &str, body: Option<&Value>) -> Result<Value, Failed> {
        if self.ending {
            return self.answer(method, path, body).await;
        }
        let mut console = self.console.lock().await;
        tokio::select! {
            biased;
            () = console.stopped() => Err(Failed::Stopped),
            answer = self.answer(method, path, body) => answer,
        }
    }

    async fn answer(
        &self,
        method: Method,
        path: &str,
        body: Option<&Value>,
    ) -> Result<Value, Failed> {
        let lost =
            |error: String| Failed::Lost(text::SiteLost { url: Shown(&self.uri), error }.words());
        let posted = method == Method::POST;
        let most = if self.ending { ENDS } else { patience(path) };
        let exchange = timeout(most, self.exchange(method, path, body)).await;
        let (status, bytes) = match exchange {
            Err(_) => return Err(lost(format!("{} s", most.as_secs()))),
            Ok(Err(error)) => return Err(lost(error)),
            Ok(Ok(answer)) => answer,
        };
        let value: Value = match bytes.is_empty() {
            true => Value::Null,
            false => serde_json::from_slice(&bytes).map_err(|error| lost(error.to_string()))?,
        };
        // A hub that keeps nothing says so with 503, and what it knows.
        if status < 400 || path == "/health" {
            return match value["ok"] == false {
                // Not all of its answers say that it is done.
                true => Err(Failed::Lost(text::SiteNotDone.words())),
                false => Ok(value),
            };
        }
        let error = &value["error"];
        let of = |key: &str| error[key].as_str().unwrap_or_default().to_owned();
        let code = of("code");
        let words = Words { en: of("en"), ru: of("ru") };
        // Without access nothing can be tested: that is no refusal of one request.
        // An order that has no answer of its monitor may be carried out.
        let unsure = posted && status >= 500 && !path.ends_with("/params/read");
        if status == 401 || unsure {
            return Err(Failed::Lost(words));
        }
        Err(Failed::Refused { code, text: words })
    }

    async fn exchange(
        &self,
        method: Method,
        path: &str,
        body: Option<&Value>,
    ) -> Result<(u16, Bytes), String> {
        let port = self.uri.port_u16().unwrap_or(if self.tls.is_some() { 443 } else { 80 });
        let host = self.host().trim_start_matches('[').trim_end_matches(']');
        let stream = TcpStream::connect((host, port)).await.map_err(said)?;
        stream.set_nodelay(true).map_err(said)?;
        let mut request = Request::builder().method(method).uri(path);
        let authority = self.uri.authority().map_or("", |it| it.as_str());
        request = request.header(HOST, authority).header(ACCEPT, "application/json");
        if let Some(token) = &self.token {
            request = request.header(AUTHORIZATION, format!("Bearer {token}"));
        }
        if body.is_some() {
            request = request.header(CONTENT_TYPE, "application/json");
        }
        let body = body.map(Value::to_string).unwrap_or_default();
        let request = request.body(Full::new(Bytes::from(body))).map_err(said)?;
        match &self.tls {
            None => send(stream, request).await,
            Some(tls) => {
                let name = ServerName::try_from(host.to_owned()).map_err(said)?;
                send(tls.connect(name, stream).await.map_err(said)?, request).await
            }
        }
    }
}

/// How long the answer to a request may take.
fn patience(path: &str) -> Duration {
    let is = |end: &str| path.ends_with(end);
    match () {
        () if is("/params/read") => PARAMS,
        () if is("/stop") => ENDS,
        () => ANSWER,
    }
}

fn said(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// Sends a request over a connection of its own, and reads the answer.
async fn send(
    stream: impl tokio::io::AsyncRead + tokio::io::AsyncWrite + Unpin,
    request: Request<Full<Bytes>>,
) -> Result<(u16, Bytes), String> {
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await.map_err(said)?;
    let exchange = async {
        let answer = sender.send_request(request).await.map_err(said)?;
        let status = answer.status().as_u16();
        let body = Limited::new(answer.into_body(), ANSWER_MAX).collect().await.map_err(said)?;
        Ok((status, body.to_bytes()))
    };
    let mut connection = std::pin::pin!(connection);
    let mut exchange = std::pin::pin!(exchange);
    tokio::select! {
        answer = &mut exchange => answer,
        ended = &mut connection => match ended {
            Ok(()) => exchange.await,
            Err(error) => Err(error.to_string()),
        },
    }
}

fn connector(access: &Access) -> Result<TlsConnector, Words> {
    let mut roots = RootCertStore::empty();
    match &access.ca {
        Some(path) => {
            let file = path.display();
            let wrong = |error: String| text::SiteBadCa { file: Shown(&file), error }.words();
            let all = CertificateDer::pem_file_iter(path).map_err(|it| wrong(it.to_string()))?;
            for certificate in all {
                let certificate = certificate.map_err(|it| wrong(it.to_string()))?;
                roots.add(certificate).map_err(|it| wrong(it.to_string()))?;
            }
        }
        None => {
            let found = rustls_native_certs::load_native_certs();
            roots.add_parsable_certificates(found.certs);
        }
    }
    let config = ClientConfig::builder_with_provider(Arc::new(crypto::ring::default_provider()))
        .with_safe_default_protocol_versions()
        .map_err(|error| Words::same(error.to_string()))?
        .with_root_certificates(roots)
        .with_no_client_auth();
    Ok(TlsConnector::from(Arc::new(config)))
}

impl Wire for Hub {
    async fn get(&mut self, path: &str) -> Result<Value, Failed> {
        self.ask(Method::GET, path, None).await
    }

    fn ends(&mut self) {
        self.ending = true;
    }

    async fn post(&mut self, posting: &Posting) -> Result<Value, Failed> {
        self.ask(Method::POST, posting.path(), Some(posting.body())).await
    }

    async fn pause(&mut self, ms: u64) -> Result<(), Stopped> {
        let mut console = self.console.lock().await;
        tokio::select! {
            biased;
            () = console.stopped() => Err(Stopped),
            () = sleep(Duration::from_millis(ms)) => Ok(()),
        }
    }

    async fn settle(&mut self, ms: u64) -> Result<(), Stopped> {
        let mut console = self.console.lock().await;
        tokio::select! {
            biased;
            () = console.gives_up() => Err(Stopped),
            () = sleep(Duration::from_millis(ms)) => Ok(()),
        }
    }

    fn now_ms(&self) -> u64 {
        u64::try_from(self.began.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    fn date_ms(&self) -> Option<u64> {
        (!self.is_here()).then(|| lafet_hub::Clock::System.now_ms())
    }
}
