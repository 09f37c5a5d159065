//! Who asks: cookie, token, certificate; and that a browser asks on behalf of our own page.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use axum::body::Bytes;
use axum::extract::{FromRequest, FromRequestParts, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, Method, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::BODY_MAX;
use crate::access::{Kind, Principal, Role};
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::sync::lock;
use crate::text::both;

/// The browser's cookie.
pub const COOKIE: &str = "lafet_session";

/// The other side of a connection.
#[derive(Clone, Debug)]
pub struct Peer {
    /// Its address.
    pub address: SocketAddr,
    /// Common name of its certificate.
    pub name: Option<String>,
    /// The connection is encrypted.
    pub tls: bool,
    /// Counts the connection, also when it has become a WebSocket.
    #[expect(dead_code, reason = "held for its end")]
    pub place: Arc<Place>,
}

/// One of the connections that the hub has room for.
#[derive(Debug)]
pub struct Place {
    hub: Hub,
    address: IpAddr,
    #[expect(dead_code, reason = "held for its end")]
    permit: OwnedSemaphorePermit,
}

impl Place {
    /// A place for a connection, if there is one. A quarter of them is for other addresses than
    /// the one that has the most, so that nobody takes them all.
    pub fn take(hub: &Hub, room: &Arc<Semaphore>, address: IpAddr) -> Option<Self> {
        let address = address.to_canonical();
        let permit = room.clone().try_acquire_owned().ok()?;
        let mut addresses = lock(&hub.addresses);
        let count = addresses.entry(address).or_default();
        let most = hub.config.connections_max - hub.config.connections_max / 4;
        if *count >= most && !hub.config.proxies.contains(&address) {
            return None;
        }
        *count += 1;
        hub.counts.connections.fetch_add(1, Ordering::Relaxed);
        Some(Self { hub: hub.clone(), address, permit })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.hub.counts.connections.fetch_sub(1, Ordering::Relaxed);
        let mut addresses = lock(&self.hub.addresses);
        if let Some(count) = addresses.get_mut(&self.address) {
            *count -= 1;
            if *count == 0 {
                addresses.remove(&self.address);
            }
        }
    }
}

/// Somebody who may at least stop: a session that ran out lately, and no CSRF token, will do.
#[derive(Debug)]
pub struct Urgent(pub Caller);

/// A body of JSON.
#[derive(Debug)]
pub struct Body<T>(pub T);

/// A body as far as it is any use: what cannot be read is empty.
#[derive(Debug)]
pub struct Lenient(pub Bytes);

impl FromRequestParts<Hub> for Caller {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, hub: &Hub) -> Result<Self, ApiError> {
        let principal = principal(parts, hub).filter(|principal| !principal.stale);
        let principal = principal.ok_or_else(|| login_needed(hub))?;
        let safe = matches!(parts.method, Method::GET | Method::HEAD);
        // A WebSocket is how one stops: whoever comes back with many is not kept out.
        if safe && parts.uri.path() != "/api/ws" {
            hub.count_reading(&principal)?;
        }
        if principal.kind == Kind::Session && !safe {
            let sent = parts.headers.get("x-csrf-token").and_then(|value| value.to_str().ok());
            if sent != Some(principal.csrf.as_str()) {
                let text = both(
                    "The header X-CSRF-Token is missing or wrong: take it from /api/session.",
                    "Нет заголовка X-CSRF-Token или он неверен: возьмите его из /api/session.",
                );
                return Err(ApiError::new(StatusCode::FORBIDDEN, "csrf", text));
            }
        }
        Ok(Caller::http(principal, address(parts, hub)))
    }
}

impl FromRequestParts<Hub> for Urgent {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, hub: &Hub) -> Result<Self, ApiError> {
        let principal = principal(parts, hub).ok_or_else(|| login_needed(hub))?;
        Ok(Self(Caller::http(principal, address(parts, hub))))
    }
}

impl<T: DeserializeOwned> FromRequest<Hub> for Body<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, hub: &Hub) -> Result<Self, ApiError> {
        let bytes = Bytes::from_request(request, hub).await.map_err(|error| {
            let text = both(
                format!("The body cannot be read; at most {BODY_MAX} bytes."),
                format!("Тело запроса не читается; не более {BODY_MAX} байт."),
            );
            let status = error.into_response().status();
            let code =
                if status == StatusCode::PAYLOAD_TOO_LARGE { "too_large" } else { "bad_request" };
            ApiError::new(status, code, text)
        })?;
        let bytes: &[u8] = if bytes.is_empty() { b"{}" } else { &bytes };
        serde_json::from_slice(bytes).map(Self).map_err(|error| not_understood(&error))
    }
}

impl FromRequest<Hub> for Lenient {
    type Rejection = std::convert::Infallible;

    async fn from_request(request: Request, _: &Hub) -> Result<Self, Self::Rejection> {
        let body = axum::body::to_bytes(request.into_body(), BODY_MAX).await;
        Ok(Self(body.unwrap_or_default()))
    }
}

/// A query or a body does not fit.
pub fn not_understood(error: &dyn std::fmt::Display) -> ApiError {
    ApiError::bad_request(both(
        format!("Not understood: {error}. See /api/openapi.json."),
        format!("Не понято: {error}. См. /api/openapi.json."),
    ))
}

/// Whether the browser's side is encrypted: ours, or that of a proxy of ours.
pub fn encrypted(parts: &Parts, hub: &Hub) -> bool {
    let Some(peer) = parts.extensions.get::<Peer>() else { return false };
    let told = || parts.headers.get("x-forwarded-proto").is_some_and(|it| it == "https");
    peer.tls || (hub.config.proxies.contains(&peer.address.ip().to_canonical()) && told())
}

/// Where a request comes from; one of our proxies is believed for whom it asks.
pub fn address(parts: &Parts, hub: &Hub) -> IpAddr {
    let peer = parts.extensions.get::<Peer>();
    let peer = peer.map_or(IpAddr::from([0, 0, 0, 0]), |peer| peer.address.ip().to_canonical());
    if !hub.config.proxies.contains(&peer) {
        return peer;
    }
    // Each proxy appends whom it has heard; what stands before the first stranger anybody may
    // have written.
    let told = parts.headers.get_all("x-forwarded-for").iter().filter_map(|it| it.to_str().ok());
    let told: Vec<&str> = told.flat_map(|it| it.split(',')).map(str::trim).collect();
    let mut known = told.iter().rev().map_while(|it| it.parse::<IpAddr>().ok());
    known.find(|it| !hub.config.proxies.contains(it)).map_or(peer, |it| it.to_canonical())
}

fn principal(parts: &Parts, hub: &Hub) -> Option<Principal> {
    let now_ms = hub.clock.now_ms();
    if let Some(value) = parts.headers.get(header::AUTHORIZATION) {
        let secret = value.to_str().ok().and_then(|value| value.strip_prefix("Bearer "));
        return hub.access.by_token(now_ms, secret?.trim());
    }
    if let Some(secret) = cookie(&parts.headers)
        && let Some(principal) = hub.access.by_session(now_ms, secret)
    {
        return Some(principal);
    }
    let roles = hub.config.tls.as_ref().map(|tls| &tls.client_roles);
    let name = parts.extensions.get::<Peer>().and_then(|peer| peer.name.as_ref());
    if let Some((name, role)) = name.and_then(|name| Some((name, roles?.get(name)?))) {
        return Some(known(name, *role, Kind::Certificate));
    }
    if !hub.config.login && address(parts, hub).is_loopback() {
        return Some(known("demo", Role::Administrator, Kind::Demo));
    }
    None
}

fn known(name: &str, role: Role, kind: Kind) -> Principal {
    Principal {
        user: name.to_owned(),
        role,
        kind,
        key: format!("c-{name}"),
        csrf: String::new(),
        expires_ms: 0,
        stale: false,
    }
}

/// The session's secret.
pub fn cookie(headers: &HeaderMap) -> Option<&str> {
    let all = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
    all.flat_map(|value| value.split(';')).find_map(|pair| {
        let (name, value) = pair.trim().split_once('=')?;
        (name == COOKIE).then_some(value)
    })
}

/// Nobody is logged in.
pub fn login_needed(hub: &Hub) -> ApiError {
    let text = both("Log in first.", "Сначала войдите.");
    let setup = hub.config.login && hub.access.is_empty();
    ApiError::new(StatusCode::UNAUTHORIZED, "login_needed", text).with("setup_needed", setup)
}

/// Turns away what another page asks in the name of its visitor, and names that are not ours (a
/// page whose name was pointed here).
pub async fn same_origin(State(hub): State<Hub>, request: Request, next: Next) -> Response {
    let ours = ours(&hub, request.uri(), request.headers());
    match ours {
        Ok(()) => next.run(request).await,
        Err(error) => error.into_response(),
    }
}

fn ours(hub: &Hub, uri: &Uri, headers: &HeaderMap) -> Result<(), ApiError> {
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
    let host = uri.authority().map(|it| it.as_str()).or_else(|| text(header::HOST));
    let Some(host) = host.filter(|host| is_ours(hub, host)) else {
        let text = both(
            "The hub has no such name. Add it to names in [server], or use its address.",
            "У центра управления нет такого имени. Добавьте его в names раздела [server] или \
             используйте адрес.",
        );
        return Err(ApiError::new(StatusCode::FORBIDDEN, "bad_host", text));
    };
    let fine = text(header::ORIGIN).is_none_or(|origin| {
        let same = origin.split_once("://").is_some_and(|(_, place)| place == host);
        same || hub.config.origins.iter().any(|allowed| allowed == origin)
    });
    if !fine {
        let text = both(
            "Another page asks. If it may, add it to origins in [server].",
            "Запрос от другой страницы. Если это допустимо, добавьте её в origins раздела [server].",
        );
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
    let given = hub.config.names.iter().any(|known| known.eq_ignore_ascii_case(name));
    given || name.eq_ignore_ascii_case("localhost") || bare.parse::<IpAddr>().is_ok()
}
