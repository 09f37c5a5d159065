//! Where jets go, and how high to aim.

use axum::Json;
use axum::extract::State;
use lafet_texts::{Text as _, hub as text};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, Path};
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::site::jet::{Aim, Aimed, Computed, JETS_MAX, Jets};

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new().routes(routes!(jets)).routes(routes!(aim))
}

/// Flight, landing, reach and throw of jets.
#[utoipa::path(post, path = "/api/jets", request_body = Jets,
    responses((status = 200, body = Vec<Computed>), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn jets(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Jets { jets }): Body<Jets>,
) -> Result<Json<Vec<Computed>>, ApiError> {
    hub.count_reading(&caller.principal)?;
    if jets.len() > JETS_MAX {
        return Err(ApiError::bad_request(text::JetsTooMany { jets_max: JETS_MAX }.words()));
    }
    let own = hub.clone();
    let compute = move || jets.iter().map(|asked| asked.jet(&own)).collect::<Result<_, _>>();
    let who = Some(&*caller.principal.key);
    hub.answering().beside(who, compute).await?.map(Json)
}

/// The elevation with which a monitor's jet hits a place.
#[utoipa::path(post, path = "/api/monitors/{id}/aim", params(("id" = String, Path)), request_body = Aim,
    responses((status = 200, body = Aimed), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn aim(
    State(hub): State<Hub>,
    caller: Caller,
    Path(id): Path<String>,
    Body(aim): Body<Aim>,
) -> Result<Json<Aimed>, ApiError> {
    hub.count_reading(&caller.principal)?;
    let station = hub.station(&id)?;
    let own = hub.clone();
    let who = Some(&*caller.principal.key);
    hub.answering().beside(who, move || aim.at(&own, &station)).await?.map(Json)
}
