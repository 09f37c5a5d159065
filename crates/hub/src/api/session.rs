//! Logging in and out.

use std::sync::atomic::Ordering;

use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::request::Parts;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::{Value, json};
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, COOKIE};
use crate::access::{AccessError, Kind, Principal, SessionInfo};
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::sync::lock;
use crate::text::both;

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new()
        .routes(routes!(session))
        .routes(routes!(log_in))
        .routes(routes!(log_out))
        .routes(routes!(set_up))
        .routes(routes!(password))
}

/// Longest name that somebody may have, bytes: 64 characters.
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

/// Where a request comes from, before anybody is known.
struct From(String, bool);

impl FromRequestParts<Hub> for From {
    type Rejection = std::convert::Infallible;

    async fn from_request_parts(parts: &mut Parts, hub: &Hub) -> Result<Self, Self::Rejection> {
        let address = super::guard::address(parts, hub).to_string();
        Ok(Self(address, super::guard::encrypted(parts, hub)))
    }
}

/// Who is logged in.
#[utoipa::path(get, path = "/api/session", responses((status = 200, body = Object), (status = 401)))]
async fn session(caller: Caller) -> Json<Value> {
    Json(about(&caller.principal))
}

fn about(principal: &Principal) -> Value {
    json!({
        "user": principal.user, "role": principal.role, "kind": principal.kind,
        "csrf": principal.csrf, "expires_ms": principal.expires_ms, "seat": principal.key,
    })
}

/// Logs in.
#[utoipa::path(post, path = "/api/login", request_body = Login,
    responses((status = 200, body = Object), (status = 400), (status = 401), (status = 429)))]
async fn log_in(
    State(hub): State<Hub>,
    from: From,
    Body(login): Body<Login>,
) -> Result<Response, ApiError> {
    let attempt = Try::begin(&hub, &from.0, &login.user)?;
    begin(hub, from, login, attempt).await
}

/// Makes the first administrator with the link that the first start has printed.
#[utoipa::path(post, path = "/api/setup", request_body = Setup,
    responses((status = 200, body = Object), (status = 400), (status = 401), (status = 429)))]
async fn set_up(
    State(hub): State<Hub>,
    from: From,
    Body(setup): Body<Setup>,
) -> Result<Response, ApiError> {
    let attempt = Try::begin(&hub, &from.0, "")?;
    let now_ms = hub.clock.now_ms();
    let login = Login { user: setup.user.clone(), password: setup.password.clone() };
    let result = slowly(&hub, move |hub| {
        hub.access.set_up(now_ms, &setup.token, &setup.user, &setup.password)
    })
    .await;
    attempt.end(!matches!(result, Err(AccessError::Wrong)));
    result?;
    let attempt = Try::begin(&hub, &from.0, &login.user)?;
    begin(hub, from, login, attempt).await
}

/// Logs out.
#[utoipa::path(post, path = "/api/logout", responses((status = 204), (status = 401), (status = 403)))]
async fn log_out(State(hub): State<Hub>, caller: Caller) -> Result<Response, ApiError> {
    let key = caller.principal.key;
    aside(&hub, move |hub| hub.access.log_out(&key)).await?;
    hub.sessions.send_modify(|changes| *changes += 1);
    let cookie = format!("{COOKIE}=; Path=/; HttpOnly; SameSite=Strict; Max-Age=0");
    Ok((StatusCode::NO_CONTENT, [(header::SET_COOKIE, cookie)]).into_response())
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
        return Err(ApiError::bad_request(both(
            "Only who has logged in with a password has one.",
            "Пароль есть только у того, кто вошёл с паролем.",
        )));
    }
    let (user, key) = (caller.principal.user.clone(), caller.principal.key.clone());
    let attempt = Try::begin(&hub, &from.0, &user)?;
    let result = slowly(&hub, move |hub| {
        hub.access.check_password(&user, &password.old)?;
        hub.access.change(&user, None, Some(&password.new), Some(&key))
    })
    .await;
    attempt.end(!matches!(result, Err(AccessError::Wrong)));
    let outcome = if result.is_ok() { "Ok" } else { "refused" };
    drop(hub.audit.note(hub.record(&caller, "", "change own password", outcome)));
    hub.sessions.send_modify(|changes| *changes += 1);
    result?;
    Ok(StatusCode::NO_CONTENT)
}

/// A try with a password. One that is given up counts as one that has failed.
struct Try {
    hub: Hub,
    user: String,
    from: String,
    ended: bool,
}

impl Try {
    fn begin(hub: &Hub, from: &str, user: &str) -> Result<Self, ApiError> {
        // Nobody has such a name, and it would have to be remembered.
        if user.len() > NAME_MAX {
            return Err(AccessError::Wrong.into());
        }
        lock(&hub.logins).begin(hub.now(), user, from).map_err(ApiError::slow_down)?;
        Ok(Self { hub: hub.clone(), user: user.into(), from: from.into(), ended: false })
    }

    /// How it ended; whether that is to be noted.
    fn end(mut self, right: bool) -> bool {
        self.ended = true;
        if right {
            lock(&self.hub.logins).succeeded(&self.user, &self.from);
            return true;
        }
        self.failed()
    }

    fn failed(&self) -> bool {
        self.hub.counts.logins_failed.fetch_add(1, Ordering::Relaxed);
        lock(&self.hub.logins).failed(self.hub.now(), &self.user, &self.from)
    }
}

impl Drop for Try {
    fn drop(&mut self) {
        if !self.ended {
            self.failed();
        }
    }
}

async fn begin(hub: Hub, from: From, login: Login, attempt: Try) -> Result<Response, ApiError> {
    let (now_ms, user) = (hub.clock.now_ms(), login.user.clone());
    let result =
        slowly(&hub, move |hub| hub.access.log_in(now_ms, &login.user, &login.password)).await;
    let noted = attempt.end(result.is_ok());
    let mut record = hub.record(&Caller::hub(), "", "login", "Ok");
    (record.user, record.from, record.via) = (user, from.0, "http".into());
    record.role.clear();
    match result {
        Ok(SessionInfo { secret, principal }) => {
            record.role = principal.role.name().into();
            drop(hub.audit.note(record));
            let secure = if from.1 { "; Secure" } else { "" };
            let cookie = format!(
                "{COOKIE}={secret}; Path=/; HttpOnly; SameSite=Strict; Max-Age=604800{secure}"
            );
            Ok(([(header::SET_COOKIE, cookie)], Json(about(&principal))).into_response())
        }
        Err(error) => {
            record.outcome = "login_failed".into();
            if noted {
                drop(hub.audit.note(record));
            }
            Err(error.into())
        }
    }
}

/// Passwords are hashed on threads of their own, few at a time: commands need the processor, too.
pub async fn slowly<T: Send + 'static>(
    hub: &Hub,
    work: impl FnOnce(&Hub) -> Result<T, AccessError> + Send + 'static,
) -> Result<T, AccessError> {
    let Ok(turn) = hub.hashing.clone().acquire_owned().await else {
        return Err(AccessError::Unfit);
    };
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
    tokio::task::spawn_blocking(move || work(&hub)).await.unwrap_or(Err(AccessError::Unfit))
}
