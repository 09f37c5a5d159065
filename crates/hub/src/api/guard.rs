//! Who asks: cookie, token, certificate; and that a browser asks on behalf of our own page.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::{self, FromRequest, FromRequestParts, Query, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, Method, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use lafet_texts::{Text as _, hub as text};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use tokio::time::{Instant, timeout};
use utoipa::IntoParams;

use super::BODY_MAX;
use super::packed::refuse_packed;
use super::places::Place;
use crate::access::{Kind, Principal, Role, STALE_MS, Standing};
use crate::error::{ApiError, Details};
use crate::hub::{Caller, Hub};

/// The cookies of the hub.
#[derive(Clone, Copy, Debug)]
pub enum Cookie {
    /// The session.
    Session,
    /// The device: a user has logged in on it before.
    Device,
}

impl Cookie {
    /// Its name at this hub, by the port: browsers give the cookies of a host to all of its ports, and two hubs on one
    /// host must not take each other's session away. Over TLS a browser takes one of this prefix from this host over
    /// TLS alone, so that it cannot be injected on the network.
    fn name(self, hub: &Hub, encrypted: bool) -> String {
        let prefix = if encrypted { "__Host-" } else { "" };
        let what = match self {
            Self::Session => "session",
            Self::Device => "device",
        };
        format!("{prefix}lafet_{what}_{}", hub.config().listen.port())
    }

    /// The header that sets it.
    pub fn set(self, hub: &Hub, value: &str, age_s: u64, encrypted: bool) -> String {
        let (name, secure) = (self.name(hub, encrypted), if encrypted { "; Secure" } else { "" });
        format!("{name}={value}; Path=/; HttpOnly; SameSite=Strict; Max-Age={age_s}{secure}")
    }

    /// Its value in these headers.
    pub fn of<'a>(self, hub: &Hub, headers: &'a HeaderMap, encrypted: bool) -> Option<&'a str> {
        let name = self.name(hub, encrypted);
        let all = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
        all.flat_map(|value| value.split(';')).find_map(|pair| {
            let (named, value) = pair.trim().split_once('=')?;
            (named == name).then_some(value)
        })
    }
}

/// Stop, Close and Lockout do not wait longer for what is said besides.
const LENIENT: Duration = Duration::from_secs(1);
/// Bytes of a reason that an answer has: it may quote what was sent.
const REASON_MAX: usize = 256;
/// Bodies of this size or less are read at once; longer ones beside, as reading them takes milliseconds.
const SHORT: usize = 4096;

/// The other side of a connection.
#[derive(Clone, Debug)]
pub struct Peer {
    /// Address of the client.
    pub address: SocketAddr,
    /// Common name of its certificate.
    pub name: Option<String>,
    /// When that ends, ms since 1970.
    pub ends_ms: Option<u64>,
    /// Whether the connection is encrypted.
    pub tls: bool,
    /// Counts the connection, also when it has become a WebSocket.
    pub place: Arc<Place>,
}

/// A client that may at least stop: an expired session without a CSRF token is enough.
#[derive(Debug)]
pub struct Urgent(pub Caller);

/// Who may send a Stop as often as wanted.
#[derive(Clone, Debug)]
struct Uncounted(Principal);

/// A body of JSON.
#[derive(Debug)]
pub struct Body<T>(pub T);

/// What the address names.
#[derive(Debug)]
pub struct Path<T>(pub T);

/// A body as far as it is any use: what cannot be read, or is not short, is empty.
#[derive(Debug)]
pub struct Lenient(pub Bytes);

/// A caller whose order has to come in time, and whole: a network that was dead delivers what was sent meanwhile.
pub struct InTime {
    /// Who gives it.
    pub caller: Caller,
    up_ms: Option<f64>,
}

impl InTime {
    /// When it was sent, at the earliest. To be asked once its body is there, which may be under way for longer than
    /// its head.
    ///
    /// # Errors
    ///
    /// 409, `late`; 400: it says that it was sent in the future.
    pub fn sent(&self, hub: &Hub) -> Result<Option<Instant>, ApiError> {
        hub.sent_at(self.up_ms)
    }
}

/// When an order was sent.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct Sent {
    /// So long after the start of the hub, ms, as the client knows that from `up_ms` of its messages: an order that was
    /// under way for 2 s is refused (409 `late`), and one that was sent before an abort or a lock that came meanwhile
    /// (409 `void`). Without it, it counts whenever it comes.
    up_ms: Option<f64>,
}

impl FromRequestParts<Hub> for Caller {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, hub: &Hub) -> Result<Self, ApiError> {
        let principal = principal(parts, hub).ok_or_else(|| login_needed(hub, None))?;
        if !principal.is_good() {
            return Err(login_needed(hub, Some(&principal)));
        }
        let safe = matches!(parts.method, Method::GET | Method::HEAD);
        // A WebSocket carries Stop: a client that reconnects many is not refused.
        if let Some(detector) = reporting(parts, hub) {
            hub.count_report(&principal, detector)?;
        } else if !safe {
            hub.count_change(&principal)?;
        } else if parts.uri.path() != "/api/ws" {
            hub.count_reading(&principal)?;
        }
        if principal.kind == Kind::Session && !safe {
            let sent = parts.headers.get("x-csrf-token").and_then(|value| value.to_str().ok());
            if sent != Some(principal.csrf.as_str()) {
                let text = text::CsrfMissing.words();
                return Err(ApiError::new(StatusCode::FORBIDDEN, "csrf", text));
            }
        }
        parts.extensions.insert(principal.clone());
        Ok(Caller::http(principal, address(parts, hub)))
    }
}

/// The detector that a request reports: one that there is, so that no name is invented.
fn reporting<'a>(parts: &'a Parts, hub: &Hub) -> Option<&'a str> {
    let id = parts.uri.path().strip_prefix("/api/detectors/")?;
    (parts.method == Method::POST && hub.detector_kind(id).is_ok()).then_some(id)
}

impl FromRequestParts<Hub> for Urgent {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, hub: &Hub) -> Result<Self, ApiError> {
        let principal = principal(parts, hub).ok_or_else(|| login_needed(hub, None))?;
        if principal.is_good() {
            parts.extensions.insert(principal.clone());
        }
        parts.extensions.insert(Uncounted(principal.clone()));
        Ok(Self(Caller::http(principal, address(parts, hub))))
    }
}

impl FromRequestParts<Hub> for InTime {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, hub: &Hub) -> Result<Self, ApiError> {
        let caller = Caller::from_request_parts(parts, hub).await?;
        let Query(Sent { up_ms }) =
            Query::try_from_uri(&parts.uri).map_err(|error| not_understood(&error))?;
        Ok(Self { caller, up_ms })
    }
}

impl<T: DeserializeOwned + Send> FromRequestParts<Hub> for Path<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, hub: &Hub) -> Result<Self, ApiError> {
        let named = extract::Path::from_request_parts(parts, hub).await;
        named.map(|extract::Path(named)| Self(named)).map_err(|error| not_understood(&error))
    }
}

impl<T: DeserializeOwned + Send + 'static> FromRequest<Hub> for Body<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, hub: &Hub) -> Result<Self, ApiError> {
        refuse_packed(request.headers())?;
        let len = request.headers().get(header::CONTENT_LENGTH);
        let len = len.and_then(|len| len.to_str().ok()?.parse::<usize>().ok());
        let (parts, body) = request.into_parts();
        let who = len.is_none_or(|len| len > SHORT).then(|| key(&parts, hub));
        // What stops is short.
        if let Some(Uncounted(sender)) = parts.extensions.get().filter(|_| who.is_some()) {
            hub.count_change(sender)?;
        }
        // Of who was identified by the head.
        let before = parts.extensions.get::<Principal>().cloned();
        let request = Request::from_parts(parts, body);
        let bytes = Bytes::from_request(request, hub).await.map_err(|error| {
            let text = text::BodyUnreadable { body_max: BODY_MAX }.words();
            let status = error.into_response().status();
            let code =
                if status == StatusCode::PAYLOAD_TOO_LARGE { "too_large" } else { "bad_request" };
            ApiError::new(status, code, text)
        })?;
        let read = |bytes: &[u8]| serde_json::from_slice(bytes).map(Self);
        let read = match who {
            _ if bytes.is_empty() => read(b"{}"),
            Some(who) if bytes.len() > SHORT => {
                hub.answering().beside(who.as_deref(), move || read(&bytes)).await?
            }
            _ => read(&bytes),
        };
        if let Some(before) = before {
            still_good(hub, &before)?;
        }
        read.map_err(|error| not_understood(&error))
    }
}

impl FromRequest<Hub> for Lenient {
    type Rejection = std::convert::Infallible;

    async fn from_request(request: Request, _: &Hub) -> Result<Self, Self::Rejection> {
        let body = timeout(LENIENT, axum::body::to_bytes(request.into_body(), SHORT)).await;
        Ok(Self(body.ok().and_then(Result::ok).unwrap_or_default()))
    }
}

/// A query or a body does not fit.
pub fn not_understood(error: &dyn std::fmt::Display) -> ApiError {
    let error = error.to_string();
    let error = error.get(..error.floor_char_boundary(REASON_MAX)).unwrap_or_default();
    ApiError::bad_request(text::NotUnderstood { error }.words())
}

/// Whether the browser's side is encrypted: ours, or that of a proxy of ours.
pub fn encrypted(parts: &Parts, hub: &Hub) -> bool {
    is_encrypted(hub, parts.extensions.get::<Peer>(), &parts.headers)
}

/// The same of what a request consists of.
pub fn is_encrypted(hub: &Hub, peer: Option<&Peer>, headers: &HeaderMap) -> bool {
    let Some(peer) = peer else { return false };
    let told = || headers.get("x-forwarded-proto").is_some_and(|it| it == "https");
    peer.tls || (hub.config().proxies.contains(&peer.address.ip().to_canonical()) && told())
}

/// Where a request comes from; one of our proxies is believed for whom it asks.
pub fn address(parts: &Parts, hub: &Hub) -> IpAddr {
    let peer = parts.extensions.get::<Peer>();
    let peer = peer.map_or(IpAddr::from([0, 0, 0, 0]), |peer| peer.address.ip().to_canonical());
    if !hub.config().proxies.contains(&peer) {
        return peer;
    }
    // Each proxy appends the address of its client; what comes before the first unknown address
    // may be forged.
    let told = parts.headers.get_all("x-forwarded-for").iter().filter_map(|it| it.to_str().ok());
    let told: Vec<&str> = told.flat_map(|it| it.split(',')).map(str::trim).collect();
    let mut known = told.iter().rev().map_while(|it| it.parse::<IpAddr>().ok());
    known.find(|it| !hub.config().proxies.contains(it)).map_or(peer, |it| it.to_canonical())
}

fn principal(parts: &Parts, hub: &Hub) -> Option<Principal> {
    let principal = identify(parts, hub);
    if let (Some(_), Some(peer)) = (&principal, parts.extensions.get::<Peer>()) {
        peer.place.known();
    }
    principal
}

/// What a known client is counted by.
pub fn key(parts: &Parts, hub: &Hub) -> Option<String> {
    principal(parts, hub).map(|it| format!("{}/{}", it.user, it.key))
}

fn identify(parts: &Parts, hub: &Hub) -> Option<Principal> {
    let now_ms = hub.clock().steady_ms();
    if let Some(value) = parts.headers.get(header::AUTHORIZATION) {
        let secret = value.to_str().ok().and_then(|value| value.strip_prefix("Bearer "));
        return hub.access().by_token(now_ms, secret?.trim());
    }
    if let Some(secret) = Cookie::Session.of(hub, &parts.headers, encrypted(parts, hub))
        && let Some(principal) = hub.access().by_session(now_ms, secret)
    {
        return Some(principal);
    }
    let roles = hub.config().tls.as_ref().map(|tls| &tls.client_roles);
    let peer = parts.extensions.get::<Peer>();
    let name = peer.and_then(|peer| peer.name.as_ref());
    if let Some((name, role)) = name.and_then(|name| Some((name, roles?.get(name)?))) {
        return certified(known(name, *role, Kind::Certificate), peer?.ends_ms?, hub);
    }
    // A proxy of this machine passes on what strangers ask.
    let by_itself = || address(parts, hub).is_loopback() && !is_passed_on(&parts.headers);
    if !hub.config().login && by_itself() {
        return Some(known("demo", Role::Administrator, Kind::Demo));
    }
    None
}

/// The owner of a certificate that ends at this date: on a connection that outlasts it, it is as good as a session
/// that has run out.
fn certified(principal: Principal, ends_ms: u64, hub: &Hub) -> Option<Principal> {
    let date_ms = hub.clock().now_ms();
    let (standing, expires_ms) = match date_ms < ends_ms {
        true => (Standing::Good, ends_ms),
        false => (Standing::Expired, ends_ms.saturating_add(STALE_MS)),
    };
    (date_ms < expires_ms).then_some(Principal { standing, expires_ms, ..principal })
}

/// Whether a proxy has passed a request on, as far as it says so.
fn is_passed_on(headers: &HeaderMap) -> bool {
    let names = headers.keys().map(header::HeaderName::as_str);
    let mut of_proxies = names.filter(|it| {
        it.starts_with("x-forwarded-") || ["forwarded", "via", "x-real-ip"].contains(it)
    });
    of_proxies.next().is_some()
}

fn known(name: &str, role: Role, kind: Kind) -> Principal {
    Principal {
        user: name.to_owned(),
        role,
        kind,
        key: format!("c-{name}"),
        csrf: String::new(),
        expires_ms: 0,
        standing: Standing::Good,
    }
}

/// The client is not logged in, or not any more; then, what still works and until when.
pub fn login_needed(hub: &Hub, left: Option<&Principal>) -> ApiError {
    let text = text::LoginFirst.words();
    let setup = hub.config().login && hub.access().is_empty();
    let details = Details {
        setup_needed: Some(setup),
        standing: left.map(|left| left.standing),
        left_ms: left.map(|left| left.expires_ms.saturating_sub(hub.now_for(left))),
        ..Details::default()
    };
    ApiError::new(StatusCode::UNAUTHORIZED, "login_needed", text).with(details)
}

/// A body that is kept back does not keep the rights of its sender.
///
/// # Errors
///
/// 401: they were revoked, or have ended.
pub fn still_good(hub: &Hub, sender: &Principal) -> Result<(), ApiError> {
    if hub.is_still_good(sender) { Ok(()) } else { Err(login_needed(hub, None)) }
}

/// Turns away what another page asks in the name of its visitor, and names that are not ours (a
/// page whose name was pointed here).
pub async fn same_origin(State(hub): State<Hub>, request: Request, next: Next) -> Response {
    let encrypted = is_encrypted(&hub, request.extensions().get::<Peer>(), request.headers());
    let ours = ours(&hub, request.uri(), request.headers(), encrypted);
    match ours {
        Ok(()) => next.run(request).await,
        Err(error) => error.into_response(),
    }
}

fn ours(hub: &Hub, uri: &Uri, headers: &HeaderMap, encrypted: bool) -> Result<(), ApiError> {
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
    let host = uri.authority().map(|it| it.as_str()).or_else(|| text(header::HOST));
    let Some(host) = host.filter(|host| is_ours(hub, host)) else {
        let text = text::HostUnknown.words();
        return Err(ApiError::new(StatusCode::FORBIDDEN, "bad_host", text));
    };
    let fine = text(header::ORIGIN).is_none_or(|origin| {
        // A page that came in the clear may be forged. The other way round it is ours,
        // behind a proxy with TLS that does not say so.
        let scheme = |it: &str| it == "https" || it == "http" && !encrypted;
        let same = origin.split_once("://").is_some_and(|(it, place)| scheme(it) && place == host);
        same || hub.config().origins.iter().any(|allowed| allowed == origin)
    });
    if !fine {
        let text = text::OriginUnknown.words();
        return Err(ApiError::new(StatusCode::FORBIDDEN, "bad_origin", text));
    }
    Ok(())
}

fn is_ours(hub: &Hub, host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    let bare = name.trim_start_matches('[').trim_end_matches(']');
    let given = hub.config().names.iter().any(|known| known.eq_ignore_ascii_case(name));
    given || name.eq_ignore_ascii_case("localhost") || bare.parse::<IpAddr>().is_ok()
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    fn at(port: u16) -> Hub {
        let mut config = crate::Config::default();
        config.listen.set_port(port);
        Hub::new(config, crate::Clock::System, Value::Null).unwrap()
    }

    /// A browser sends the cookies of a host to each of its ports, and keeps one of a name.
    #[tokio::test]
    async fn two_hubs_on_one_host_leave_each_other_their_sessions() {
        let (one, other) = (at(8480), at(8481));
        for encrypted in [false, true] {
            let mut kept = std::collections::BTreeMap::new();
            for (hub, secret) in [(&one, "of-one"), (&other, "of-other")] {
                let set = Cookie::Session.set(hub, secret, 60, encrypted);
                let (name, value) = set.split(';').next().unwrap().split_once('=').unwrap();
                kept.insert(name.to_owned(), value.to_owned());
            }
            let sent: Vec<String> =
                kept.iter().map(|(name, value)| format!("{name}={value}")).collect();
            let headers =
                HeaderMap::from_iter([(header::COOKIE, sent.join("; ").parse().unwrap())]);
            let of = |hub| Cookie::Session.of(hub, &headers, encrypted);
            assert_eq!((of(&one), of(&other)), (Some("of-one"), Some("of-other")));
            assert_eq!(Cookie::Session.of(&one, &headers, !encrypted), None);
        }
    }
}
