//! Logging in and out.

use std::net::IpAddr;
use std::sync::atomic::Ordering;

use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::request::Parts;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use lafet_texts::{Text as _, hub as text};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, Cookie};
use super::network;
use crate::access::{AccessError, Kind, Place, Principal, Role, SESSION_MS, STALE_MS, SessionInfo};
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::store::Act;

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new()
        .routes(routes!(session))
        .routes(routes!(log_in))
        .routes(routes!(log_out))
        .routes(routes!(set_up))
        .routes(routes!(password))
}

/// Longest name, bytes: 64 characters.
const NAME_MAX: usize = 256;

/// User and password.
#[derive(Debug, Deserialize, ToSchema)]
struct Login {
    user: String,
    password: String,
}

/// The first administrator.
#[derive(Debug, Deserialize, ToSchema)]
struct Setup {
    token: String,
    user: String,
    password: String,
}

/// A new password.
#[derive(Debug, Deserialize, ToSchema)]
struct Password {
    old: String,
    new: String,
}

/// A browser keeps the cookie of a session for this time, s: longer than any session serves for Stop, as the hub
/// decides how far it still holds.
const COOKIE_S: u64 = (SESSION_MS + STALE_MS) / 1000 + 3600;
/// A device is remembered for this time, s: 400 days are what browsers allow.
const DEVICE_S: u64 = 400 * 24 * 3600;

/// Where a request comes from, before its user is known.
struct From {
    address: IpAddr,
    encrypted: bool,
    /// What a login on this device has left.
    device: Option<String>,
}

impl From {
    /// The same place, as far as it concerns a user.
    fn place(&self, hub: &Hub, user: &str) -> Place {
        let device = self.device.as_ref().is_some_and(|it| hub.access().is_device(user, it));
        // With IPv6 a client has 64 bits of addresses to guess from.
        Place { address: network(self.address).to_string(), device }
    }
}

impl FromRequestParts<Hub> for From {
    type Rejection = std::convert::Infallible;

    async fn from_request_parts(parts: &mut Parts, hub: &Hub) -> Result<Self, Self::Rejection> {
        let address = super::guard::address(parts, hub);
        let encrypted = super::guard::encrypted(parts, hub);
        let device = Cookie::Device.of(hub, &parts.headers, encrypted).map(str::to_owned);
        Ok(Self { address, encrypted, device })
    }
}

/// The session of the caller.
#[utoipa::path(get, path = "/api/session", responses((status = 200, body = Session), (status = 401)))]
async fn session(State(hub): State<Hub>, caller: Caller) -> Json<Session> {
    Json(about(&hub, &caller.principal))
}

fn about(hub: &Hub, principal: &Principal) -> Session {
    let expires_ms = match (principal.kind, principal.expires_ms) {
        (_, 0) => 0,
        (Kind::Certificate, date_ms) => date_ms,
        (_, steady_ms) => hub.access().date_ms(steady_ms),
    };
    Session {
        user: principal.user.clone(),
        role: principal.role,
        kind: principal.kind,
        csrf: principal.csrf.clone(),
        expires_ms,
        seat: principal.key.clone(),
    }
}

/// A session.
#[derive(Debug, Serialize, ToSchema)]
struct Session {
    /// Name of the user.
    user: String,
    /// Role of the user.
    role: Role,
    /// How the user has authenticated.
    kind: Kind,
    /// What goes into the header X-CSRF-Token of requests that change something.
    csrf: String,
    /// When it ends; 0: never.
    expires_ms: u64,
    /// Id of the seat.
    seat: String,
}

/// Logs in.
#[utoipa::path(post, path = "/api/login", request_body = Login,
    responses((status = 200, body = Session), (status = 400), (status = 401), (status = 429)))]
async fn log_in(
    State(hub): State<Hub>,
    from: From,
    Body(login): Body<Login>,
) -> Result<Response, ApiError> {
    let attempt = Try::begin(&hub, &from, &login.user)?;
    let known = attempt.place.device;
    begin(hub, from, login, (attempt, known)).await
}

/// Makes the first administrator with the link that the first start has printed.
#[utoipa::path(post, path = "/api/setup", request_body = Setup,
    responses((status = 200, body = Session), (status = 400), (status = 401), (status = 429)))]
async fn set_up(
    State(hub): State<Hub>,
    from: From,
    Body(setup): Body<Setup>,
) -> Result<Response, ApiError> {
    let token = setup.token.clone();
    // The link cannot be guessed: who has it does not wait because of those who try. Once there are users no link is
    // looked for: each thread that waits for the disk takes memory and the processor.
    let is_link = hub.access().is_empty()
        && aside(&hub, move |hub| hub.access().is_setup_link(&token)).await?;
    if !is_link {
        Try::begin(&hub, &from, "")?.end(false);
        note_set_up(&hub, &from, None);
        return Err(AccessError::Wrong.into());
    }
    let now_ms = hub.clock().now_ms();
    let login = Login { user: setup.user.clone(), password: setup.password.clone() };
    let result = slowly(&hub, 0, move |hub| {
        hub.access().set_up(now_ms, &setup.token, &setup.user, &setup.password)
    })
    .await;
    note_set_up(&hub, &from, result.is_ok().then_some(&login.user));
    result?;
    // Nor because of those who have guessed at this name before.
    let place = Place { device: true, ..from.place(&hub, &login.user) };
    let attempt = Try::begin_at(&hub, place, &login.user)?;
    begin(hub, from, login, (attempt, false)).await
}

/// Notes who has become the first administrator; `None`: the request was refused.
fn note_set_up(hub: &Hub, from: &From, user: Option<&String>) {
    let outcome = if user.is_some() { "Ok" } else { "refused" };
    let mut record = hub.record(&Caller::hub(), "", "set up", outcome);
    // What is no name of a user is not noted as one.
    let user = user.cloned().unwrap_or_default();
    (record.user, record.from, record.via) =
        (user.clone(), from.address.to_string(), "http".into());
    record.role = Role::Administrator.name().to_owned();
    drop(hub.audit().note(record.about(&Act::SetUp { user })));
}

/// Logs out.
#[utoipa::path(post, path = "/api/logout", responses((status = 204), (status = 401), (status = 403)))]
async fn log_out(State(hub): State<Hub>, caller: Caller, from: From) -> Result<Response, ApiError> {
    let record = hub.record(&caller, "", "logout", "Ok");
    let key = caller.principal.key;
    aside(&hub, move |hub| hub.access().log_out(&key)).await?;
    drop(hub.audit().note(record.about(&Act::Logout)));
    hub.access_changed();
    let gone = Cookie::Session.set(&hub, "", 0, from.encrypted);
    Ok((StatusCode::NO_CONTENT, [(header::SET_COOKIE, gone)]).into_response())
}

/// Changes one's own password; other sessions end.
#[utoipa::path(post, path = "/api/password", request_body = Password,
    responses((status = 204), (status = 400), (status = 401), (status = 403), (status = 429)))]
async fn password(
    State(hub): State<Hub>,
    caller: Caller,
    from: From,
    Body(password): Body<Password>,
) -> Result<StatusCode, ApiError> {
    if caller.principal.kind != Kind::Session {
        return Err(ApiError::bad_request(text::NoPassword.words()));
    }
    let (user, key) = (caller.principal.user.clone(), caller.principal.key.clone());
    let attempt = Try::begin(&hub, &from, &user)?;
    let now_ms = hub.clock().steady_ms();
    let result = slowly(&hub, attempt.rank, move |hub| {
        hub.access().check_password(&user, &password.old)?;
        hub.access().change(now_ms, &user, None, Some(&password.new), Some(&key))
    })
    .await;
    attempt.end(!matches!(result, Err(AccessError::Wrong)));
    let outcome = if result.is_ok() { "Ok" } else { "refused" };
    let record = hub.record(&caller, "", "change own password", outcome);
    drop(hub.audit().note(record.about(&Act::ChangeOwnPassword)));
    hub.access_changed();
    result?;
    Ok(StatusCode::NO_CONTENT)
}

/// A try with a password. One that is given up counts as one that has failed.
struct Try {
    hub: Hub,
    user: String,
    place: Place,
    /// Its place among those who wait for a turn.
    rank: u32,
    ended: bool,
}

impl Try {
    fn begin(hub: &Hub, from: &From, user: &str) -> Result<Self, ApiError> {
        Self::begin_at(hub, from.place(hub, user), user)
    }

    fn begin_at(hub: &Hub, place: Place, user: &str) -> Result<Self, ApiError> {
        // No user has such a name, and its failures would take memory.
        if user.len() > NAME_MAX {
            return Err(AccessError::Wrong.into());
        }
        let begun = hub.logins().begin(hub.now(), user, &place);
        let rank = begun.map_err(ApiError::slow_down)?;
        Ok(Self { hub: hub.clone(), user: user.into(), place, rank, ended: false })
    }

    /// How it ended; whether that is to be noted.
    fn end(mut self, right: bool) -> bool {
        self.ended = true;
        if right {
            self.hub.logins().succeeded(&self.user, &self.place);
            return true;
        }
        self.failed()
    }

    fn failed(&self) -> bool {
        self.hub.counts().logins_failed.fetch_add(1, Ordering::Relaxed);
        self.hub.logins().failed(self.hub.now(), &self.user, &self.place)
    }
}

impl Drop for Try {
    fn drop(&mut self) {
        if !self.ended {
            self.failed();
        }
    }
}

/// `known`: the user has logged in on this device before.
async fn begin(
    hub: Hub,
    from: From,
    login: Login,
    (attempt, known): (Try, bool),
) -> Result<Response, ApiError> {
    let (now_ms, user) = (hub.clock().steady_ms(), login.user.clone());
    let rank = attempt.rank;
    let result = slowly(&hub, rank, move |hub| {
        let session = hub.access().log_in(now_ms, &login.user, &login.password)?;
        let device = if known { None } else { hub.access().add_device(now_ms, &login.user).ok() };
        Ok((session, device))
    })
    .await;
    let noted = attempt.end(result.is_ok());
    let mut record = hub.record(&Caller::hub(), "", "login", "Ok").about(&Act::Login);
    (record.user, record.from, record.via) = (user, from.address.to_string(), "http".into());
    record.kind = Some(Kind::Session);
    record.role.clear();
    match result {
        Ok((SessionInfo { secret, principal }, device)) => {
            record.role = principal.role.name().into();
            drop(hub.audit().note(record));
            let session = Cookie::Session.set(&hub, &secret, COOKIE_S, from.encrypted);
            let device = device.map(|it| Cookie::Device.set(&hub, &it, DEVICE_S, from.encrypted));
            let mut response = Json(about(&hub, &principal)).into_response();
            for cookie in [Some(session), device].into_iter().flatten() {
                if let Ok(value) = cookie.parse() {
                    response.headers_mut().append(header::SET_COOKIE, value);
                }
            }
            Ok(response)
        }
        Err(error) => {
            record.outcome = "login_failed".into();
            if noted {
                drop(hub.audit().note(record));
            }
            Err(error.into())
        }
    }
}

/// Passwords are hashed on threads of their own, few at a time: commands need the processor, too.
/// Of those who wait, the lower rank goes first.
pub async fn slowly<T: Send + 'static>(
    hub: &Hub,
    rank: u32,
    work: impl FnOnce(&Hub) -> Result<T, AccessError> + Send + 'static,
) -> Result<T, AccessError> {
    let turn = hub.hashing().take(rank).await.ok_or(AccessError::Busy)?;
    aside(hub, move |hub| {
        let _turn = turn;
        work(hub)
    })
    .await
}

/// The disk is waited for on a thread of its own.
pub async fn aside<T: Send + 'static>(
    hub: &Hub,
    work: impl FnOnce(&Hub) -> Result<T, AccessError> + Send + 'static,
) -> Result<T, AccessError> {
    let hub = hub.clone();
    tokio::task::spawn_blocking(move || work(&hub)).await.unwrap_or(Err(AccessError::Busy))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use tokio::time::timeout;

    use super::*;

    /// Who guesses the link of the first start takes no thread: as many as ask would take one each.
    #[test]
    fn a_link_is_looked_for_as_long_as_there_is_one() {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(1)
            .build()
            .unwrap();
        runtime.block_on(async {
            let (hub, _) = Hub::of_one(None);
            let link = hub.access().setup_link().unwrap().unwrap();
            hub.access().set_up(1, &link, "root", "correct horse").unwrap();
            let (go, hung) = std::sync::mpsc::channel::<()>();
            let hangs = tokio::task::spawn_blocking(move || hung.recv());
            let from = From { address: [127, 0, 0, 1].into(), encrypted: false, device: None };
            let token = "x".to_owned();
            let setup = Setup { token, user: "u".into(), password: "wrong and long".into() };
            let asked = set_up(State(hub), from, Body(setup));
            let refused = timeout(Duration::from_secs(10), asked).await;
            let refused = refused.expect("it waits for no thread").unwrap_err();
            assert_eq!(refused.status, StatusCode::UNAUTHORIZED);
            drop(go);
            assert!(hangs.await.unwrap().is_err());
        });
    }
}
