//! Answers packed with gzip, for clients that take them so.
//!
//! What never changes is packed once and kept. Of the rest, whole answers to readings are packed, one
//! at a time: a client that comes meanwhile gets the plain text, so that packing takes one processor at
//! most. Nothing that changes something is answered packed, nor is what holds a secret: the size of a
//! packed text shows how much of it repeats (BREACH).

use std::io::{Read as _, Write as _};
use std::sync::{Arc, OnceLock};

use axum::body::{Body, Bytes, to_bytes};
use axum::extract::{Request, State};
use axum::http::response::Parts;
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use hyper::body::Body as _;
use lafet_texts::{Text as _, hub as text};
use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

use super::JSON;
use crate::error::ApiError;
use crate::hub::Hub;

/// A smaller answer is a packet in any case; a larger one is made in parts.
const SIZES: std::ops::RangeInclusive<u64> = 1024..=16 * 1024 * 1024;
/// The answer that contains a secret: the CSRF token of a session.
const SECRET: &str = "/api/session";

/// Held by who packs or unpacks what never changes: others that ask for the same meanwhile take no thread.
static LASTING: Semaphore = Semaphore::const_new(1);

/// Who packs an answer now.
#[derive(Debug)]
pub struct Packing(Semaphore);

impl Default for Packing {
    fn default() -> Self {
        Self(Semaphore::new(1))
    }
}

/// What never changes, as it is or packed; the other form is made when it is first asked for. Clones share both.
#[derive(Clone, Debug, Default)]
pub struct Lasting {
    plain: Arc<OnceLock<Bytes>>,
    packed: Arc<OnceLock<Bytes>>,
}

impl Lasting {
    /// Of a text as it is.
    pub fn new(plain: impl Into<Bytes>) -> Self {
        Self { plain: Arc::new(OnceLock::from(plain.into())), ..Self::default() }
    }

    /// Of a text that is packed with gzip.
    pub fn of_packed(packed: impl Into<Bytes>) -> Self {
        Self { packed: Arc::new(OnceLock::from(packed.into())), ..Self::default() }
    }

    /// As an answer of this kind. One that is still packed gets its body from [`packed()`].
    pub fn answer(&self, kind: &'static str) -> Response {
        let body = self.plain.get().cloned().unwrap_or_default();
        let mut response = ([(header::CONTENT_TYPE, kind)], body).into_response();
        response.extensions_mut().insert(self.clone());
        response
    }

    /// As an answer of JSON.
    pub fn json(&self) -> Response {
        self.answer(JSON.1)
    }

    /// What was packed before takes no thread.
    async fn packed(self) -> Option<Bytes> {
        let Self { plain, packed } = self;
        if let Some(packed) = packed.get() {
            return Some(packed.clone());
        }
        let turn = LASTING.acquire().await;
        let pack = move || {
            let _turn = turn;
            let plain = plain.get().map(Bytes::as_ref).unwrap_or_default();
            packed.get_or_init(|| gzip(plain, Compression::best())).clone()
        };
        spawn_blocking(pack).await.ok()
    }

    /// What was unpacked before takes no thread.
    async fn plain(self) -> Option<Bytes> {
        let Self { plain, packed } = self;
        if let Some(plain) = plain.get() {
            return Some(plain.clone());
        }
        let turn = LASTING.acquire().await;
        let unpack = move || {
            let _turn = turn;
            let unpacked = unpacked(packed.get()?)?;
            Some(plain.get_or_init(|| unpacked).clone())
        };
        spawn_blocking(unpack).await.ok().flatten()
    }
}

/// Packs an answer if that is of use.
pub async fn packed(State(hub): State<Hub>, request: Request, next: Next) -> Response {
    let packs = takes_gzip(request.headers())
        && request.method() == Method::GET
        && request.uri().path() != SECRET;
    let mut response = next.run(request).await;
    let plain = response.status() == StatusCode::OK
        && is_text(response.headers())
        && !response.headers().contains_key(header::SET_COOKIE);
    if !plain {
        return response;
    }
    response.headers_mut().append(header::VARY, HeaderValue::from_static("accept-encoding"));
    let lasting = response.extensions_mut().remove::<Lasting>();
    match lasting {
        Some(lasting) if packs => {
            return with(response.into_parts().0, lasting.packed().await);
        }
        Some(lasting) => return as_it_is(response.into_parts().0, lasting.plain().await),
        None if !packs => return response,
        None => {}
    }
    let whole = response.body().size_hint().exact().is_some_and(|size| SIZES.contains(&size));
    let Ok(_turn) = hub.packing().0.try_acquire() else { return response };
    if !whole {
        return response;
    }
    let (parts, body) = response.into_parts();
    let Ok(plain) = to_bytes(body, usize::MAX).await else { return with(parts, None) };
    let packed = spawn_blocking(move || gzip(&plain, Compression::fast())).await;
    with(parts, packed.ok())
}

/// The answer with its packed body.
fn with(mut parts: Parts, packed: Option<Bytes>) -> Response {
    parts.headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    as_it_is(parts, packed)
}

/// The answer with another body.
fn as_it_is(mut parts: Parts, body: Option<Bytes>) -> Response {
    let Some(body) = body else {
        return StatusCode::INTERNAL_SERVER_ERROR.into_response();
    };
    parts.headers.insert(header::CONTENT_LENGTH, HeaderValue::from(body.len()));
    Response::from_parts(parts, Body::from(body))
}

fn unpacked(packed: &[u8]) -> Option<Bytes> {
    let mut plain = Vec::new();
    // Files of the program itself.
    GzDecoder::new(packed).read_to_end(&mut plain).ok()?;
    Some(plain.into())
}

fn gzip(plain: &[u8], level: Compression) -> Bytes {
    let mut packed = GzEncoder::new(Vec::new(), level);
    // A vector takes everything.
    let written = packed.write_all(plain).and_then(|()| packed.finish());
    written.unwrap_or_default().into()
}

/// Pictures, fonts and recordings are packed already.
fn is_text(headers: &HeaderMap) -> bool {
    let kind = headers.get(header::CONTENT_TYPE).and_then(|it| it.to_str().ok());
    kind.is_some_and(|it| it.starts_with("text/") || it == JSON.1 || it == "image/svg+xml")
}

/// Whether a client says that it takes gzip.
fn takes_gzip(headers: &HeaderMap) -> bool {
    let all = headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|it| it.to_str().ok());
    all.flat_map(|it| it.split(',')).any(|coding| {
        let (name, rest) = coding.split_once(';').unwrap_or((coding, ""));
        let weight = rest.trim().strip_prefix("q=").map(|it| it.trim().parse::<f64>());
        name.trim().eq_ignore_ascii_case("gzip")
            && weight.is_none_or(|it| it.is_ok_and(|it| it > 0.0))
    })
}

/// What is sent to the hub is not unpacked: a little would become much.
pub fn refuse_packed(headers: &HeaderMap) -> Result<(), ApiError> {
    let plain = |it: &HeaderValue| it.as_bytes().eq_ignore_ascii_case(b"identity");
    if headers.get_all(header::CONTENT_ENCODING).iter().all(plain) {
        return Ok(());
    }
    let text = text::EncodingRefused.words();
    Err(ApiError::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, "packed", text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn either_form_gives_the_other() {
        let text = "lafet ".repeat(1000);
        let packed = Lasting::new(text.clone()).packed().await.unwrap();
        assert!(packed.len() < 100, "{}", packed.len());
        let lasting = Lasting::of_packed(packed.clone());
        assert_eq!(lasting.clone().packed().await.unwrap(), packed);
        assert_eq!(lasting.clone().plain().await.unwrap(), text);
        assert_eq!(lasting.plain().await.unwrap(), text);
        assert_eq!(Lasting::of_packed("no gzip").plain().await, None);
    }

    #[tokio::test]
    async fn what_never_changes_is_packed_by_one_thread_at_a_time() {
        let soon = std::time::Duration::from_millis(50);
        let turn = LASTING.acquire().await.unwrap();
        let (plain, packed) = (Lasting::new("lafet"), Lasting::of_packed("no gzip"));
        let (mut packs, mut unpacks) = (Box::pin(plain.packed()), Box::pin(packed.plain()));
        assert!(tokio::time::timeout(soon, &mut packs).await.is_err(), "it takes a thread");
        assert!(tokio::time::timeout(soon, &mut unpacks).await.is_err(), "it takes a thread");
        drop(turn);
        assert!(packs.await.is_some() && unpacks.await.is_none());
    }

    #[test]
    fn gzip_is_taken_if_it_is_named_and_not_refused() {
        let takes = |value: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::ACCEPT_ENCODING, HeaderValue::from_static(value));
            takes_gzip(&headers)
        };
        assert!(takes("gzip, deflate, br, zstd") && takes("br;q=1.0, GZIP;q=0.8"));
        assert!(!takes("") && !takes("br") && !takes("gzip;q=0") && !takes("gzip;q=0.000, *"));
        assert!(!takes_gzip(&HeaderMap::new()));
    }
}
