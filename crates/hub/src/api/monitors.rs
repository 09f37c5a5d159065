//! Monitors: their state, requests to them, authority, jog, parameters.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use lafet_client::{Monitor, Toward};
use lafet_proto::request::Body as RequestBody;
use lafet_proto::{Ints, ParamId, Request, SubsystemId};
use lafet_texts::{Text as _, hub as text};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tokio::time::timeout;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::crash::Crash;
use super::guard::{Body, Lenient, Path, Urgent};
use crate::command::outcome::{OfAll, OfOne, Outcome, Pending};
use crate::command::request::MonitorRequest;
use crate::command::urgent::Joined;
use crate::control::jogs::Heard;
use crate::control::motion::Beat;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::owner;
use crate::monitor::station::{Params, Station};
use crate::monitor::view::{Control, MonitorView};
use crate::sync::lock;
use crate::text::Both;
use crate::words::MotionWord;

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new()
        .routes(routes!(monitors))
        .routes(routes!(one))
        .routes(routes!(request))
        .routes(routes!(stop_one))
        .routes(routes!(close_one))
        .routes(routes!(lockout))
        .routes(routes!(stop_all))
        .routes(routes!(lockout_all))
        .routes(routes!(authority))
        .routes(routes!(jog))
        .routes(routes!(params))
        .routes(routes!(read_params))
        .routes(routes!(set_param))
        .routes(routes!(crash))
}

/// A request in the text form.
#[derive(Debug, Deserialize, ToSchema)]
#[schema(as = RequestText)]
pub struct Asked {
    /// Text form of the request, `Move Vertical 1200`.
    pub request: String,
    /// The monitor's id, where it is needed.
    pub confirm: Option<String>,
    /// When it was sent, by the sender's clock, ms: late arrival is recognized by it, and a Stop that was
    /// sent later.
    pub t: Option<f64>,
    /// The same in ms since the hub's start, as far as the sender knows them.
    pub up_ms: Option<f64>,
}

/// A change of control authority.
#[derive(Debug, Deserialize, ToSchema)]
#[schema(as = AuthorityChange)]
pub struct Change {
    /// `take`, `release`, `request`, `grant`, `deny`, `force`.
    pub action: String,
    /// Reason, required with `force`.
    pub reason: Option<String>,
}

/// A beat of a motion that is held, or its end.
#[derive(Debug, Deserialize, ToSchema)]
pub struct JogBeat {
    /// `Vertical`, `Horizontal`, `Nozzle`.
    pub drive: String,
    /// `max` (up, left, narrow) or `min`.
    pub toward: Option<String>,
    /// Clock of the sender, ms; beats that arrive late are recognized by it.
    pub t: Option<f64>,
    /// The same in ms since the hub's start, as far as the sender knows them.
    pub up_ms: Option<f64>,
    /// The drive is released: the motion ends.
    #[serde(default)]
    pub end: bool,
}

/// The state of a motion that is held.
#[derive(Debug, Serialize, ToSchema)]
struct JogState {
    /// State of the motion.
    state: MotionWord,
}

/// Stop, Close and Lockout of one monitor are answered within this time with what is known.
const URGENT_WAIT: Duration = Duration::from_secs(1);
/// An answer waits this long for all parameters.
const READ_WAIT: Duration = Duration::from_secs(8);

/// New values of a parameter.
#[derive(Debug, Deserialize, ToSchema)]
struct Values {
    values: Vec<i32>,
}

/// All monitors by id.
#[utoipa::path(get, path = "/api/monitors", responses((status = 200, body = BTreeMap<String, MonitorView>), (status = 401)))]
async fn monitors(State(hub): State<Hub>, _: Caller) -> Json<BTreeMap<String, MonitorView>> {
    Json(hub.stations().iter().map(|it| (it.id().to_owned(), it.view(&hub))).collect())
}

/// One monitor.
#[utoipa::path(get, path = "/api/monitors/{id}", params(("id" = String, Path)),
    responses((status = 200, body = MonitorView), (status = 401), (status = 404)))]
async fn one(
    State(hub): State<Hub>,
    _: Caller,
    Path(id): Path<String>,
) -> Result<Json<MonitorView>, ApiError> {
    Ok(Json(hub.station(&id)?.view(&hub)))
}

/// Sends a request to a monitor.
#[utoipa::path(post, path = "/api/monitors/{id}/requests", params(("id" = String, Path)),
    request_body = Asked, responses((status = 200, body = Outcome), (status = 202, body = Pending), (status = 400),
    (status = 401), (status = 403), (status = 404), (status = 409), (status = 422), (status = 429), (status = 502),
    (status = 503)))]
async fn request(
    State(hub): State<Hub>,
    Urgent(caller): Urgent,
    Path(id): Path<String>,
    headers: axum::http::HeaderMap,
    Body(asked): Body<Asked>,
) -> Result<Response, ApiError> {
    let request = MonitorRequest::parse(&asked.request);
    let station = hub.station(&id).map_err(|error| match &request {
        Ok(request) if request.need().urgent => ApiError::nothing_stopped(&id),
        _ => error,
    })?;
    // Stop written as a request is as urgent as its own address.
    if let Ok(request) = &request
        && request.need().urgent
    {
        return soon(vec![hub.urgent(&caller, &station, request)]).await;
    }
    csrf(&caller, &headers)?;
    let request = request?;
    let longer = asked.t.map(|t| hub.longer(&caller, t));
    hub.in_time(&station, &request, longer, asked.up_ms)?;
    let outcome = hub.command(&caller, &station, request, asked.confirm.as_deref()).await?;
    Ok(Json(outcome).into_response())
}

/// What the extractor of `Caller` looks at, where it comes after the body.
fn csrf(caller: &Caller, headers: &axum::http::HeaderMap) -> Result<(), ApiError> {
    let principal = &caller.principal;
    let sent = headers.get("x-csrf-token").and_then(|value| value.to_str().ok());
    if principal.kind == crate::access::Kind::Session && sent != Some(principal.csrf.as_str()) {
        let text = text::CsrfMissing.words();
        return Err(ApiError::new(axum::http::StatusCode::FORBIDDEN, "csrf", text));
    }
    Ok(())
}

/// Stops everything, or one subsystem.
#[utoipa::path(post, path = "/api/monitors/{id}/stop", params(("id" = String, Path)),
    request_body = Option<Object>, responses((status = 200, body = Outcome), (status = 202, body = Pending),
    (status = 401), (status = 404), (status = 422), (status = 502), (status = 503)))]
async fn stop_one(
    State(hub): State<Hub>,
    Urgent(caller): Urgent,
    Path(id): Path<String>,
    Lenient(body): Lenient,
) -> Result<Response, ApiError> {
    let body: Value = serde_json::from_slice(&body).unwrap_or_default();
    let station = hub.station(&id).map_err(|_| ApiError::nothing_stopped(&id))?;
    let request = stop(body["of"].as_str())?;
    soon(vec![hub.urgent(&caller, &station, &request)]).await
}

/// Closes one valve, or all that the monitor has.
#[utoipa::path(post, path = "/api/monitors/{id}/close", params(("id" = String, Path)),
    request_body = Option<Object>, responses((status = 200, body = Outcome), (status = 202, body = Pending),
    (status = 401), (status = 404), (status = 422), (status = 502), (status = 503)))]
async fn close_one(
    State(hub): State<Hub>,
    Urgent(caller): Urgent,
    Path(id): Path<String>,
    Lenient(body): Lenient,
) -> Result<Response, ApiError> {
    let body: Value = serde_json::from_slice(&body).unwrap_or_default();
    let station = hub.station(&id).map_err(|_| ApiError::nothing_stopped(&id))?;
    let requests = close(&station, body["valve"].as_str())?;
    soon(requests.iter().map(|it| hub.urgent(&caller, &station, it)).collect()).await
}

/// Locks a monitor out.
#[utoipa::path(post, path = "/api/monitors/{id}/lockout", params(("id" = String, Path)),
    responses((status = 200, body = Outcome), (status = 202, body = Pending), (status = 401), (status = 404),
    (status = 422), (status = 502), (status = 503)))]
async fn lockout(
    State(hub): State<Hub>,
    Urgent(caller): Urgent,
    Path(id): Path<String>,
) -> Result<Response, ApiError> {
    let station = hub.station(&id).map_err(|_| ApiError::nothing_stopped(&id))?;
    soon(vec![hub.urgent(&caller, &station, &MonitorRequest::lockout()?)]).await
}

/// Stops every monitor.
#[utoipa::path(post, path = "/api/stop", responses((status = 200, body = BTreeMap<String, OfOne>), (status = 401)))]
async fn stop_all(State(hub): State<Hub>, Urgent(caller): Urgent) -> Result<Json<OfAll>, ApiError> {
    Ok(Json(hub.everywhere(&caller, &MonitorRequest::stop(SubsystemId::ALL)?).await))
}

/// Locks every monitor out.
#[utoipa::path(post, path = "/api/lockout", responses((status = 200, body = BTreeMap<String, OfOne>), (status = 401)))]
async fn lockout_all(
    State(hub): State<Hub>,
    Urgent(caller): Urgent,
) -> Result<Json<OfAll>, ApiError> {
    Ok(Json(hub.everywhere(&caller, &MonitorRequest::lockout()?).await))
}

/// Takes, releases, requests, grants, denies or forces control authority.
#[utoipa::path(post, path = "/api/monitors/{id}/authority", params(("id" = String, Path)),
    request_body = Change, responses((status = 200, body = Control), (status = 400), (status = 401),
    (status = 403), (status = 404), (status = 409)))]
async fn authority(
    State(hub): State<Hub>,
    caller: Caller,
    Path(id): Path<String>,
    Body(change): Body<Change>,
) -> Result<Json<Control>, ApiError> {
    let station = hub.station(&id)?;
    let state =
        hub.change_authority(&caller, &station, &change.action, change.reason.as_deref())?;
    Ok(Json(state))
}

/// A beat of a motion that is held.
#[utoipa::path(post, path = "/api/monitors/{id}/jog", params(("id" = String, Path)),
    request_body = JogBeat, responses((status = 200, body = JogState), (status = 400), (status = 401),
    (status = 403), (status = 404), (status = 409), (status = 503)))]
async fn jog(
    State(hub): State<Hub>,
    caller: Caller,
    Path(id): Path<String>,
    Body(beat): Body<JogBeat>,
) -> Result<Json<JogState>, ApiError> {
    let station = hub.station(&id)?;
    Ok(Json(JogState { state: hub.beat(&caller, &station, &beat)? }))
}

/// Parameters as last read.
#[utoipa::path(get, path = "/api/monitors/{id}/params", params(("id" = String, Path)),
    responses((status = 200, body = Params), (status = 401), (status = 404)))]
async fn params(
    State(hub): State<Hub>,
    _: Caller,
    Path(id): Path<String>,
) -> Result<Json<Params>, ApiError> {
    Ok(Json(lock(&hub.station(&id)?.params).clone()))
}

/// Reads all parameters from the monitor; what takes longer goes on (`reading`).
#[utoipa::path(post, path = "/api/monitors/{id}/params/read", params(("id" = String, Path)),
    responses((status = 200, body = Params), (status = 401), (status = 403), (status = 404), (status = 503)))]
async fn read_params(
    State(hub): State<Hub>,
    caller: Caller,
    Path(id): Path<String>,
) -> Result<Json<Params>, ApiError> {
    hub.count_request(&caller.principal)?;
    let station = hub.station(&id)?;
    let (monitor, own) = (Monitor::new(station.client()?), station.clone());
    // It is read to its end, even if the client has gone.
    let reading = tokio::spawn(async move { owner::read_params(&hub, &own, &monitor).await });
    _ = timeout(READ_WAIT, reading).await;
    let params = lock(&station.params).clone();
    Ok(Json(params))
}

/// Sets a parameter, and waits until it is stored.
#[utoipa::path(put, path = "/api/monitors/{id}/params/{subsystem}/{name}",
    params(("id" = String, Path), ("subsystem" = String, Path), ("name" = String, Path)),
    request_body = Values, responses((status = 200, body = Outcome), (status = 400), (status = 401),
    (status = 403), (status = 404), (status = 409), (status = 422), (status = 502), (status = 503)))]
async fn set_param(
    State(hub): State<Hub>,
    caller: Caller,
    Path((id, subsystem, name)): Path<(String, String, String)>,
    Body(Values { values }): Body<Values>,
) -> Result<Json<Outcome>, ApiError> {
    let station = hub.station(&id)?;
    let (to, id) = parameter(&subsystem, &name)?;
    let request = Request::new(to, RequestBody::SetParam { id, values: Ints::Values(&values) });
    Ok(Json(hub.save(&caller, &station, MonitorRequest::new(&request)?).await?))
}

/// A parameter by the names of a path, as people type them. `@Name` is one that the dictionary does
/// not have.
fn parameter(subsystem: &str, name: &str) -> Result<(SubsystemId, ParamId), ApiError> {
    let is_word = |text: &str| text.chars().all(|c| c.is_ascii_alphanumeric() || c == '@');
    if !is_word(subsystem) || !is_word(name) {
        return Err(ApiError::not_found());
    }
    let named = MonitorRequest::parse(&format!("GetParam {subsystem} {name}"))?;
    match named.buf().request() {
        Request { to, body: RequestBody::GetParam { id } } => Ok((to, id)),
        _ => Err(ApiError::not_found()),
    }
}

/// What the last hardware fault has left.
#[utoipa::path(get, path = "/api/monitors/{id}/crash", params(("id" = String, Path)),
    responses((status = 200, body = Crash), (status = 401), (status = 404), (status = 502), (status = 503)))]
async fn crash(
    State(hub): State<Hub>,
    _: Caller,
    Path(id): Path<String>,
) -> Result<Json<Crash>, ApiError> {
    let monitor = Monitor::new(hub.station(&id)?.client()?);
    let info = timeout(READ_WAIT, monitor.crash_data()).await;
    let info = info.map_err(|_| ApiError::no_answer_within(&id, READ_WAIT))?;
    let info = info.map_err(|error| ApiError::from(&error))?;
    Ok(Json(Crash::from(&info)))
}

/// The request that stops a subsystem; for an unknown name, everything.
pub fn stop(of: Option<&str>) -> Result<MonitorRequest, ApiError> {
    MonitorRequest::stop(of.and_then(SubsystemId::from_name).unwrap_or(SubsystemId::ALL))
}

/// The requests that close a valve, or all.
pub fn close(station: &Station, valve: Option<&str>) -> Result<Vec<MonitorRequest>, ApiError> {
    let named = valve.and_then(SubsystemId::from_name).filter(|id| id.is_valve());
    let valves = match named {
        Some(valve) => vec![valve],
        None => station.status().valves_to_close(),
    };
    valves.into_iter().map(MonitorRequest::close).collect()
}

/// What urgent requests to one monitor have come to; after [`URGENT_WAIT`], that they are sent. They
/// go on.
async fn soon(all: Vec<Joined>) -> Result<Response, ApiError> {
    match timeout(URGENT_WAIT, together(all)).await {
        Ok(outcome) => Ok(Json(outcome?).into_response()),
        Err(_) => Ok((StatusCode::ACCEPTED, Json(Pending { pending: true })).into_response()),
    }
}

/// The results of several urgent requests to one monitor as one.
pub async fn together(mut all: Vec<Joined>) -> Result<Outcome, ApiError> {
    let results = futures_util::future::join_all(all.iter_mut().map(Joined::result)).await;
    let mut results = results.into_iter();
    let mut all = results.next().unwrap_or_else(|| Ok(Outcome::default()))?;
    for result in results {
        all.join(result?);
    }
    Ok(all)
}

impl Hub {
    /// A beat, or the end, of a motion that is held.
    pub fn beat(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        beat: &JogBeat,
    ) -> Result<MotionWord, ApiError> {
        let drive = SubsystemId::from_name(&beat.drive).unwrap_or(SubsystemId::ALL);
        if beat.end {
            station.end_jog(&caller.seat.seat, drive);
            return Ok(MotionWord::Ended);
        }
        let toward = match beat.toward.as_deref() {
            Some("max") => Toward::Max,
            Some("min") => Toward::Min,
            _ => {
                let text: Both = text::TowardWrong.words();
                return Err(ApiError::bad_request(text));
            }
        };
        self.may_jog(caller, station)?;
        let late = self.is_late_beat(station, drive, beat.up_ms)?;
        let heard = Heard { sent_ms: beat.t, late, sleep: self.last_sleep() };
        station.beat(self, caller, Beat { drive, toward, heard })
    }
}
