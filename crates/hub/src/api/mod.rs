//! HTTP: who asks, what for, and what comes back.

mod admin;
mod answers;
mod assets;
mod crash;
mod guard;
mod installation;
mod jets;
mod metrics;
mod monitors;
mod packed;
#[cfg_attr(not(feature = "parquet"), path = "no_parquet.rs")]
mod parquet;
mod past;
pub mod places;
mod recordings;
mod records;
mod session;
pub(crate) use session::slowly;
mod sim;
mod state;
mod unread;
mod updates;
mod ws;
mod zones;

use std::sync::LazyLock;

use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderName, HeaderValue, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::{Json, Router};
use serde::Serialize;
use serde_json::Value;
use utoipa::openapi::path::Operation;
use utoipa::openapi::{Content, Ref, RefOr, Response as Answer};
use utoipa::{OpenApi, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::error::{ApiError, Failed};
use crate::hub::{About, Caller, Hub};
use crate::publish::messages::Message;
pub use answers::Answering;
pub use guard::Peer;
pub use packed::{Lasting, Packing};
pub use places::{Place, Places, network};
pub use ws::{Id, kinds as messages, show_frame};

/// Largest body of a request.
pub const BODY_MAX: usize = 64 * 1024;

const JSON: (HeaderName, &str) = (axum::http::header::CONTENT_TYPE, "application/json");

#[derive(OpenApi)]
#[openapi(
    info(
        title = "lafet hub",
        description = "Fire monitors over HTTP. Times are ms since 1970, angles arc-minutes. See docs/hub-api.md."
    ),
    components(schemas(crate::store::Act, crate::simulation::Scene, Failed, Message, ws::Said))
)]
struct Description;

/// All routes.
pub fn router(hub: Hub) -> Router {
    let (router, _) = routes_and_description();
    router
        .fallback(assets::serve)
        .layer(DefaultBodyLimit::max(BODY_MAX))
        .layer(middleware::from_fn_with_state(hub.clone(), packed::packed))
        .layer(middleware::from_fn_with_state(hub.clone(), answers::bounded))
        .layer(middleware::from_fn_with_state(hub.clone(), guard::same_origin))
        .layer(middleware::from_fn_with_state(hub.clone(), headers))
        .layer(middleware::from_fn(unread::ends_the_connection))
        .with_state(hub)
}

fn routes_and_description() -> (Router<Hub>, utoipa::openapi::OpenApi) {
    OpenApiRouter::with_openapi(Description::openapi())
        .routes(routes!(about))
        .routes(routes!(dictionary))
        .routes(routes!(openapi))
        .routes(routes!(metrics::health))
        .routes(routes!(metrics::metrics))
        .routes(routes!(ws::upgrade))
        .merge(session::routes())
        .merge(monitors::routes())
        .merge(jets::routes())
        .merge(zones::routes())
        .merge(installation::routes())
        .merge(records::routes())
        .merge(past::routes())
        .merge(recordings::routes())
        .merge(updates::routes())
        .merge(sim::routes())
        .merge(state::routes())
        .merge(admin::routes())
        .split_for_parts()
}

/// The description of the API.
pub fn description() -> Value {
    let mut api = routes_and_description().1;
    for path in api.paths.paths.values_mut() {
        let operations =
            [&mut path.get, &mut path.put, &mut path.post, &mut path.patch, &mut path.delete];
        operations.into_iter().flatten().for_each(describe_failures);
    }
    serde_json::to_value(api).unwrap_or_default()
}

/// Adds the answers that any operation of its kind can have.
fn describe_failures(operation: &mut Operation) {
    let answers = &mut operation.responses.responses;
    // Clients that are logged in are counted.
    if answers.contains_key("401") {
        answers.entry("429".into()).or_insert_with(|| RefOr::T(Answer::new("slow_down")));
    }
    if operation.request_body.is_some() {
        answers.entry("415".into()).or_insert_with(|| RefOr::T(Answer::new("packed")));
    }
    for (_, answer) in answers.iter_mut().filter(|(status, _)| status.as_str() >= "400") {
        if let RefOr::T(answer) = answer
            && answer.content.is_empty()
        {
            let content = Content::new(Some(Ref::from_schema_name("Failed")));
            answer.content.insert("application/json".into(), RefOr::T(content));
        }
    }
}

/// The hub, its version and its site.
#[utoipa::path(get, path = "/api/hub", responses((status = 200, body = Now), (status = 401)))]
async fn about(State(hub): State<Hub>, _: Caller) -> Json<Now> {
    Json(Now { about: hub.about(), now_ms: hub.clock().now_ms(), up_ms: hub.up_ms() })
}

/// What the hub is, with its date.
#[derive(Debug, Serialize, ToSchema)]
struct Now {
    #[serde(flatten)]
    about: About,
    /// Date of the hub, ms since 1970.
    now_ms: u64,
    /// Since its start, ms, by a clock that does not jump: a client says by it when it has sent something.
    up_ms: u64,
}

/// The dictionary of the protocol.
#[utoipa::path(get, path = "/api/dictionary", responses((status = 200, body = Object), (status = 401)))]
async fn dictionary(State(hub): State<Hub>, _: Caller) -> Response {
    hub.dictionary().json()
}

/// This description, as OpenAPI 3.1.
#[utoipa::path(get, path = "/api/openapi.json", responses((status = 200, body = Object)))]
async fn openapi() -> Response {
    // The same for all, and asked for without login.
    static TEXT: LazyLock<Lasting> = LazyLock::new(|| Lasting::new(description().to_string()));
    TEXT.json()
}

/// What browsers have to keep to, and what is new is asked for.
async fn headers(State(hub): State<Hub>, request: axum::extract::Request, next: Next) -> Response {
    hub.counts().requests.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let api = request.uri().path().starts_with("/api");
    let encrypted =
        guard::is_encrypted(&hub, request.extensions().get::<Peer>(), request.headers());
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    let fixed = [
        ("x-content-type-options", "nosniff"),
        ("referrer-policy", "no-referrer"),
        (
            "content-security-policy",
            "default-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
             worker-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'",
        ),
    ];
    for (name, value) in fixed {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    if encrypted {
        let year = HeaderValue::from_static("max-age=31536000");
        headers.insert(header::STRICT_TRANSPORT_SECURITY, year);
    }
    if api {
        headers.insert("cache-control", HeaderValue::from_static("no-store"));
    }
    response
}

/// 404 for an unknown path.
fn nothing() -> Response {
    ApiError::not_found().into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Who asks often without login costs no time: both answers are the same bytes in memory.
    #[tokio::test]
    async fn the_description_is_written_once() {
        let body = async || axum::body::to_bytes(openapi().await.into_body(), usize::MAX).await;
        let [first, second] = [body().await.unwrap(), body().await.unwrap()];
        let read: Value = serde_json::from_slice(&first).unwrap();
        assert!(read["openapi"].is_string() && read["paths"].is_object());
        assert_eq!((first.as_ptr(), first.len()), (second.as_ptr(), second.len()));
    }
}
