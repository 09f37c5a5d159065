//! The simulation, where there is one: scenarios, faults, fires.

use axum::Json;
use axum::extract::{Query, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use lafet_texts::{Text as _, hub as text};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, not_understood};
use super::records::{Asked, needs};
use crate::access::Role;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::simulation::{self, Act};

/// Slower shows nothing, faster leaves the hub nothing to poll.
const SPEED: std::ops::RangeInclusive<f64> = 0.1..=20.0;
/// Diameters of a fire, m.
const SIZE: std::ops::RangeInclusive<f64> = 0.2..=30.0;
/// The farthest place of a fire from the middle of the site, m.
const FAR_M: f64 = 500.0;
/// Diameter of a fire that says none, m.
const SIZE_M: f64 = 2.0;

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new()
        .routes(routes!(sim))
        .routes(routes!(scenario))
        .routes(routes!(automatic))
        .routes(routes!(pause))
        .routes(routes!(resume))
        .routes(routes!(speed))
        .routes(routes!(fault))
        .routes(routes!(fire))
        .routes(routes!(link))
        .routes(routes!(report))
        .routes(routes!(picture))
}

/// The scenario to load.
#[derive(Debug, Deserialize, ToSchema)]
struct Scenario {
    id: String,
    seed: Option<u64>,
    #[serde(default)]
    automatic: bool,
}

/// Whether to switch on or off.
#[derive(Debug, Deserialize, ToSchema)]
struct Switch {
    on: bool,
}

/// Speed of simulated time.
#[derive(Debug, Deserialize, ToSchema)]
struct Speed {
    speed: f64,
}

/// A fault of a monitor.
#[derive(Debug, Deserialize, ToSchema)]
struct Fault {
    monitor: String,
    fault: String,
    on: bool,
}

/// A fire at a place, or one of the scenario's.
#[derive(Debug, Deserialize, ToSchema)]
#[schema(as = SimFire)]
struct Fire {
    at: Option<[f64; 2]>,
    size: Option<f64>,
    kind: Option<String>,
    name: Option<String>,
}

/// The link to a monitor.
#[derive(Debug, Deserialize, ToSchema)]
#[schema(as = SimLink)]
struct Link {
    monitor: String,
    up: bool,
}

/// Language of the picture.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Language {
    /// `en` or `ru`.
    lang: Option<String>,
}

/// What can be simulated, and what runs.
#[derive(Debug, Serialize, ToSchema)]
struct Catalogue {
    /// The scenarios that can be loaded.
    scenarios: Vec<simulation::Scenario>,
    /// The faults that can be injected.
    faults: Vec<simulation::Fault>,
    /// What runs: the topic `sim`.
    state: simulation::State,
}

type Answer = Result<Json<simulation::State>, ApiError>;

/// Scenarios, faults, and what runs.
#[utoipa::path(get, path = "/api/sim",
    responses((status = 200, body = Catalogue), (status = 401), (status = 404)))]
async fn sim(State(hub): State<Hub>, _: Caller) -> Result<Json<Catalogue>, ApiError> {
    let simulation = hub.simulation()?;
    let (scenarios, faults) = simulation.catalogue();
    Ok(Json(Catalogue { scenarios, faults, state: simulation.state() }))
}

/// Loads a scenario and starts it.
#[utoipa::path(post, path = "/api/sim/scenario", request_body = Scenario,
    responses((status = 200, body = simulation::State), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn scenario(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Scenario { id, seed, automatic }): Body<Scenario>,
) -> Answer {
    needs(&caller, Role::Engineer)?;
    Ok(Json(hub.load_scenario(&caller, &id, seed, automatic)?))
}

/// Whether the scenario's own operator acts.
#[utoipa::path(post, path = "/api/sim/automatic", request_body = Switch,
    responses((status = 200, body = simulation::State), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn automatic(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Switch { on }): Body<Switch>,
) -> Answer {
    act(&hub, &caller, &Act::Automatic(on))
}

/// Stops simulated time.
#[utoipa::path(post, path = "/api/sim/pause",
    responses((status = 200, body = simulation::State), (status = 401), (status = 403), (status = 404)))]
async fn pause(State(hub): State<Hub>, caller: Caller) -> Answer {
    act(&hub, &caller, &Act::Pause(true))
}

/// Lets simulated time go on.
#[utoipa::path(post, path = "/api/sim/resume",
    responses((status = 200, body = simulation::State), (status = 401), (status = 403), (status = 404)))]
async fn resume(State(hub): State<Hub>, caller: Caller) -> Answer {
    act(&hub, &caller, &Act::Pause(false))
}

/// Sets the speed of simulated time.
#[utoipa::path(post, path = "/api/sim/speed", request_body = Speed,
    responses((status = 200, body = simulation::State), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn speed(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Speed { speed }): Body<Speed>,
) -> Answer {
    within("speed", speed, &SPEED)?;
    act(&hub, &caller, &Act::Speed(speed))
}

/// Injects a fault, or clears it.
#[utoipa::path(post, path = "/api/sim/faults", request_body = Fault,
    responses((status = 200, body = simulation::State), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn fault(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Fault { monitor, fault, on }): Body<Fault>,
) -> Answer {
    act(&hub, &caller, &Act::Fault { monitor, fault, on })
}

/// Lights a fire.
#[utoipa::path(post, path = "/api/sim/fire", request_body = Fire,
    responses((status = 200, body = simulation::State), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn fire(State(hub): State<Hub>, caller: Caller, Body(fire): Body<Fire>) -> Answer {
    let lit = match fire {
        Fire { name: Some(name), .. } => Act::Ignite(name),
        Fire { at: Some(at), size, kind, .. } => {
            at.into_iter().try_for_each(|it| within("at", it, &(-FAR_M..=FAR_M)))?;
            let size = size.unwrap_or(SIZE_M);
            within("size", size, &SIZE)?;
            Act::Fire { at, size, kind: kind.unwrap_or_else(|| "pool".into()) }
        }
        _ => {
            let text = text::SimAtOrName.words();
            return Err(ApiError::bad_request(text));
        }
    };
    act(&hub, &caller, &lit)
}

/// Cuts the link to a monitor, or restores it.
#[utoipa::path(post, path = "/api/sim/link", request_body = Link,
    responses((status = 200, body = simulation::State), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn link(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Link { monitor, up }): Body<Link>,
) -> Answer {
    act(&hub, &caller, &Act::Link { monitor, up })
}

/// The report so far.
#[utoipa::path(get, path = "/api/sim/report",
    responses((status = 200, body = Object), (status = 401), (status = 404)))]
async fn report(State(hub): State<Hub>, _: Caller) -> Result<Json<Value>, ApiError> {
    Ok(Json(hub.simulation()?.report()))
}

/// The report so far as a picture.
#[utoipa::path(get, path = "/api/sim/report.svg", params(Language),
    responses((status = 200, content_type = "image/svg+xml"), (status = 400), (status = 401), (status = 404)))]
async fn picture(
    State(hub): State<Hub>,
    _: Caller,
    language: Asked<Language>,
) -> Result<Response, ApiError> {
    let Query(Language { lang }) = language.map_err(|error| not_understood(&error))?;
    let svg = hub.simulation()?.picture(lang.as_deref() == Some("ru"));
    Ok(([(header::CONTENT_TYPE, "image/svg+xml")], svg).into_response())
}

fn act(hub: &Hub, caller: &Caller, act: &Act) -> Answer {
    needs(caller, Role::Engineer)?;
    Ok(Json(hub.act(caller, act)?))
}

fn within(name: &str, value: f64, range: &std::ops::RangeInclusive<f64>) -> Result<(), ApiError> {
    if range.contains(&value) {
        return Ok(());
    }
    let (from, to) = (range.start(), range.end());
    Err(ApiError::bad_request(text::SimOutOfRange { name, value, from, to }.words()))
}
