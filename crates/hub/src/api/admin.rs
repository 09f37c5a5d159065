//! Users and tokens.

use std::pin::pin;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use tokio::time::timeout;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, Path};
use super::session::{aside, slowly};
use crate::access::{AccessError, Role, Token, User};
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::store::Act;

/// Sessions have ended by this time, whether or not the disk has answered.
const AT_ONCE: Duration = Duration::from_millis(200);

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new()
        .routes(routes!(users, add_user))
        .routes(routes!(change_user, remove_user))
        .routes(routes!(tokens, add_token))
        .routes(routes!(remove_token))
}

/// A new user.
#[derive(Debug, Deserialize, ToSchema)]
struct NewUser {
    user: String,
    role: Role,
    password: String,
}

/// What changes of a user.
#[derive(Debug, Deserialize, ToSchema)]
struct UserChange {
    role: Option<Role>,
    password: Option<String>,
}

/// A new token.
#[derive(Debug, Deserialize, ToSchema)]
struct NewToken {
    name: String,
    role: Role,
}

/// A token that was made.
#[derive(Debug, Serialize, ToSchema)]
struct MadeToken {
    /// Number of the token.
    id: u64,
    /// The token itself; it is not kept.
    token: String,
}

/// All users.
#[utoipa::path(get, path = "/api/users",
    responses((status = 200, body = Vec<User>), (status = 401), (status = 403)))]
async fn users(State(hub): State<Hub>, caller: Caller) -> Result<Json<Vec<User>>, ApiError> {
    only_administrators(&caller)?;
    Ok(Json(aside(&hub, |hub| hub.access().users()).await?))
}

/// Adds a user.
#[utoipa::path(post, path = "/api/users", request_body = NewUser,
    responses((status = 201), (status = 400), (status = 401), (status = 403), (status = 409)))]
async fn add_user(
    State(hub): State<Hub>,
    caller: Caller,
    Body(new): Body<NewUser>,
) -> Result<StatusCode, ApiError> {
    let what = format!("add user {} as {}", new.user, new.role.name());
    let act = Act::AddUser { user: new.user.clone(), role: new.role };
    let now_ms = hub.clock().now_ms();
    change_slowly(&hub, &caller, (what, act), move |hub| {
        hub.access().add(now_ms, &new.user, new.role, &new.password)
    })
    .await?;
    Ok(StatusCode::CREATED)
}

/// Changes role or password; the user's sessions end.
#[utoipa::path(patch, path = "/api/users/{user}", params(("user" = String, Path)),
    request_body = UserChange,
    responses((status = 204), (status = 400), (status = 401), (status = 403), (status = 404), (status = 409)))]
async fn change_user(
    State(hub): State<Hub>,
    caller: Caller,
    Path(user): Path<String>,
    Body(new): Body<UserChange>,
) -> Result<StatusCode, ApiError> {
    let role = new.role.map_or("", Role::name);
    let password = if new.password.is_some() { " with a new password" } else { "" };
    let what = format!("change user {user} {role}{password}");
    let act =
        Act::ChangeUser { user: user.clone(), role: new.role, password: new.password.is_some() };
    let now_ms = hub.clock().steady_ms();
    let hashes = new.password.is_some();
    let work = move |hub: &Hub| {
        hub.access().change(now_ms, &user, new.role, new.password.as_deref(), None)
    };
    match hashes {
        true => change_slowly(&hub, &caller, (what, act), work).await?,
        false => change(&hub, &caller, (what, act), work).await?,
    }
    Ok(StatusCode::NO_CONTENT)
}

/// Removes a user.
#[utoipa::path(delete, path = "/api/users/{user}", params(("user" = String, Path)),
    responses((status = 204), (status = 401), (status = 403), (status = 404), (status = 409)))]
async fn remove_user(
    State(hub): State<Hub>,
    caller: Caller,
    Path(user): Path<String>,
) -> Result<StatusCode, ApiError> {
    let what = format!("remove user {user}");
    let act = Act::RemoveUser { user: user.clone() };
    let now_ms = hub.clock().steady_ms();
    change(&hub, &caller, (what, act), move |hub| hub.access().remove(now_ms, &user)).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// All tokens.
#[utoipa::path(get, path = "/api/tokens",
    responses((status = 200, body = Vec<Token>), (status = 401), (status = 403)))]
async fn tokens(State(hub): State<Hub>, caller: Caller) -> Result<Json<Vec<Token>>, ApiError> {
    only_administrators(&caller)?;
    Ok(Json(aside(&hub, |hub| hub.access().tokens()).await?))
}

/// Makes a token, which is shown this once.
#[utoipa::path(post, path = "/api/tokens", request_body = NewToken,
    responses((status = 201, body = MadeToken), (status = 400), (status = 401), (status = 403)))]
async fn add_token(
    State(hub): State<Hub>,
    caller: Caller,
    Body(new): Body<NewToken>,
) -> Result<(StatusCode, Json<MadeToken>), ApiError> {
    let what = format!("add token {} as {}", new.name, new.role.name());
    let now_ms = hub.clock().now_ms();
    let act = Act::AddToken { name: new.name.clone(), role: new.role };
    let (id, token) = change(&hub, &caller, (what, act), move |hub| {
        hub.access().add_token(now_ms, &new.name, new.role)
    })
    .await?;
    Ok((StatusCode::CREATED, Json(MadeToken { id, token })))
}

/// Revokes a token.
#[utoipa::path(delete, path = "/api/tokens/{id}", params(("id" = u64, Path)),
    responses((status = 204), (status = 401), (status = 403), (status = 404)))]
async fn remove_token(
    State(hub): State<Hub>,
    caller: Caller,
    Path(id): Path<String>,
) -> Result<StatusCode, ApiError> {
    // The role is checked first.
    let id: u64 = match id.parse() {
        Ok(id) => id,
        Err(_) if caller.principal.role < Role::Administrator => 0,
        Err(_) => return Err(ApiError::not_found()),
    };
    let what = (format!("remove token {id}"), Act::RemoveToken { id });
    change(&hub, &caller, what, move |hub| hub.access().remove_token(id)).await?;
    Ok(StatusCode::NO_CONTENT)
}

pub fn only_administrators(caller: &Caller) -> Result<(), ApiError> {
    match caller.principal.role {
        Role::Administrator => Ok(()),
        _ => Err(ApiError::role(Role::Administrator)),
    }
}

/// Changes something, if the caller may, and notes it. It waits for no one who hashes: what is revoked is so at once.
pub async fn change<T: Send + 'static>(
    hub: &Hub,
    caller: &Caller,
    what: (String, Act),
    work: impl FnOnce(&Hub) -> Result<T, AccessError> + Send + 'static,
) -> Result<T, ApiError> {
    changed(hub, caller, what, aside(hub, rightfully(caller, work))).await
}

/// The same of what hashes a password. It does not wait behind those who guess passwords.
async fn change_slowly<T: Send + 'static>(
    hub: &Hub,
    caller: &Caller,
    what: (String, Act),
    work: impl FnOnce(&Hub) -> Result<T, AccessError> + Send + 'static,
) -> Result<T, ApiError> {
    changed(hub, caller, what, slowly(hub, 0, rightfully(caller, work))).await
}

/// This work, unless the rights of who asks for it are revoked until its turn comes.
fn rightfully<T, W: FnOnce(&Hub) -> Result<T, AccessError>>(
    caller: &Caller,
    work: W,
) -> impl FnOnce(&Hub) -> Result<T, AccessError> + use<T, W> {
    let by = caller.principal.clone();
    move |hub| if hub.is_still_good(&by) { work(hub) } else { Err(AccessError::Ended) }
}

/// Has this done, if the caller may, and notes it.
async fn changed<T>(
    hub: &Hub,
    caller: &Caller,
    (what, act): (String, Act),
    work: impl Future<Output = Result<T, AccessError>>,
) -> Result<T, ApiError> {
    only_administrators(caller)?;
    hub.count_request(&caller.principal)?;
    let mut work = pin!(work);
    let result = match timeout(AT_ONCE, &mut work).await {
        Ok(result) => result,
        Err(_) => {
            hub.access_changed();
            work.await
        }
    };
    let outcome = if result.is_ok() { "Ok" } else { "refused" };
    drop(hub.audit().note(hub.record(caller, "", &what, outcome).about(&act)));
    // WebSockets of revoked users and tokens are closed.
    hub.access_changed();
    Ok(result?)
}
