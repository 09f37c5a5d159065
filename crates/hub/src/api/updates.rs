//! Updates of monitors' software: images, and the run that sends them.

use std::time::Duration;

use axum::Json;
use axum::body::Body as HttpBody;
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use futures_util::StreamExt;
use lafet_client::update::FILE_MAX;
use lafet_texts::{Shown, Text as _, hub as text};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, InTime, Path, Sent, still_good};
use super::packed::refuse_packed;
use super::records::needs;
use crate::access::Role;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::store::StoreError;
use crate::updates::view::{StartUpdate, StoredImage, UpdateRun, Updates};

/// Who sends an image while another one comes is asked to wait.
const SENDING: Duration = Duration::from_secs(5);

pub fn routes() -> OpenApiRouter<Hub> {
    let upload = OpenApiRouter::new().routes(routes!(upload_image));
    OpenApiRouter::new()
        .routes(routes!(updates, start_update))
        .routes(routes!(stop_update))
        .routes(routes!(remove_image))
        .merge(upload.layer(DefaultBodyLimit::disable()))
}

/// The stored images, and the run that goes on or was the last one.
#[utoipa::path(get, path = "/api/updates", responses((status = 200, body = Updates), (status = 401)))]
async fn updates(State(hub): State<Hub>, _: Caller) -> Json<Updates> {
    Json(hub.updates())
}

/// Stores an image: a header of 160 bytes, and the payload.
#[utoipa::path(post, path = "/api/updates/images",
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 201, body = StoredImage), (status = 200, body = StoredImage, description = "It was stored already"),
    (status = 400), (status = 401), (status = 403), (status = 409), (status = 413), (status = 429), (status = 503)))]
async fn upload_image(
    State(hub): State<Hub>,
    caller: Caller,
    headers: HeaderMap,
    body: HttpBody,
) -> Result<Response, ApiError> {
    needs(&caller, Role::Engineer)?;
    refuse_packed(&headers)?;
    let Ok(_turn) = hub.updating().sending.clone().try_acquire_owned() else {
        return Err(ApiError::slow_down(SENDING));
    };
    let bytes = receive(&hub, &caller, body).await?;
    still_good(&hub, &caller.principal)?;
    let (image, is_new) = to_its_end(async move { hub.store_image(&caller, bytes).await }).await?;
    let status = if is_new { StatusCode::CREATED } else { StatusCode::OK };
    Ok((status, Json(image)).into_response())
}

/// Carries something out that is noted, even if its client has gone.
async fn to_its_end<T: Send + 'static>(
    work: impl Future<Output = Result<T, ApiError>> + Send + 'static,
) -> Result<T, ApiError> {
    tokio::spawn(work).await.unwrap_or_else(|_| Err(StoreError::Busy.into()))
}

/// Takes a body as it comes, as long as its sender may send it: others wait for the turn.
async fn receive(hub: &Hub, caller: &Caller, body: HttpBody) -> Result<Vec<u8>, ApiError> {
    let mut body = body.into_data_stream();
    let mut bytes = Vec::new();
    while let Some(part) = body.next().await {
        let part = part.map_err(|error| {
            ApiError::bad_request(text::UploadBroken { error: Shown(error) }.words())
        })?;
        still_good(hub, &caller.principal)?;
        if bytes.len() + part.len() > FILE_MAX {
            let megabytes = FILE_MAX >> 20;
            let text = text::UploadTooLarge { megabytes }.words();
            return Err(ApiError::new(StatusCode::PAYLOAD_TOO_LARGE, "too_large", text));
        }
        bytes.extend_from_slice(&part);
    }
    Ok(bytes)
}

/// Removes a stored image.
#[utoipa::path(delete, path = "/api/updates/images/{digest}", params(("digest" = String, Path)),
    responses((status = 204), (status = 401), (status = 403), (status = 404), (status = 409), (status = 503)))]
async fn remove_image(
    State(hub): State<Hub>,
    caller: Caller,
    Path(digest): Path<String>,
) -> Result<StatusCode, ApiError> {
    needs(&caller, Role::Engineer)?;
    to_its_end(async move { hub.remove_image(&caller, &digest).await }).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Updates monitors, one after the other, or goes on with what was cut off.
#[utoipa::path(post, path = "/api/updates", params(Sent), request_body = StartUpdate,
    responses((status = 202, body = UpdateRun), (status = 400), (status = 401), (status = 403), (status = 409), (status = 503)))]
async fn start_update(
    State(hub): State<Hub>,
    order: InTime,
    Body(wanted): Body<StartUpdate>,
) -> Result<Response, ApiError> {
    needs(&order.caller, Role::Engineer)?;
    order.sent(&hub)?;
    let run = hub.start_update(&order.caller, wanted).await?;
    Ok((StatusCode::ACCEPTED, Json(run)).into_response())
}

/// Ends the run before its next order.
#[utoipa::path(post, path = "/api/updates/stop",
    responses((status = 200, body = UpdateRun), (status = 401), (status = 403), (status = 404)))]
async fn stop_update(State(hub): State<Hub>, caller: Caller) -> Result<Json<UpdateRun>, ApiError> {
    needs(&caller, Role::Operator)?;
    Ok(Json(hub.stop_update(&caller)?))
}
