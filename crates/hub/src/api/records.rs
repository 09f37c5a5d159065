//! Alarms, the audit log, history.

use axum::Json;
use axum::body::Body as HttpBody;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use lafet_proto::dictionary::layouts::{Kind, of_answer};
use lafet_proto::{RequestId, SubsystemId};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, not_understood};
use super::state::Wanted;
use crate::access::Role;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::store::{RAW_RANGE_MS, StoreError};
use crate::sync::lock;
use crate::text::{Both, both};

/// Longest time on the shelf, minutes.
const SHELVE_MAX_MIN: u64 = 480;
/// Entries in one answer.
pub const LIMIT_MAX: u32 = 1000;
/// Series in one answer.
const SERIES_MAX: usize = 32;
/// Points of a series in one answer.
const POINTS_MAX: usize = 10_000;

pub type Asked<T> = Result<Query<T>, QueryRejection>;

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new()
        .routes(routes!(alarms))
        .routes(routes!(acknowledge))
        .routes(routes!(shelve))
        .routes(routes!(unshelve))
        .routes(routes!(alarm_log))
        .routes(routes!(audit))
        .routes(routes!(verify))
        .routes(routes!(export))
        .routes(routes!(series))
        .routes(routes!(history))
        .routes(routes!(history_csv))
        .routes(routes!(history_parquet))
}

/// Which alarms.
#[derive(Debug, Deserialize, ToSchema)]
struct Ids {
    ids: Option<Vec<String>>,
}

/// An alarm, for how long, why.
#[derive(Debug, Deserialize, ToSchema)]
struct Shelve {
    id: String,
    minutes: u64,
    reason: String,
}

/// An alarm.
#[derive(Debug, Deserialize, ToSchema)]
struct Id {
    id: String,
}

/// Part of a log.
#[derive(Debug, Deserialize, IntoParams)]
struct Range {
    monitor: Option<String>,
    from_ms: Option<u64>,
    to_ms: Option<u64>,
    limit: Option<u32>,
}

/// Part of the history.
#[derive(Debug, Deserialize, IntoParams)]
struct Part {
    monitor: String,
    /// Names with commas between them.
    series: Option<String>,
    from_ms: Option<u64>,
    to_ms: Option<u64>,
    points: Option<usize>,
}

/// The caller has this role at least.
pub fn needs(caller: &Caller, role: Role) -> Result<(), ApiError> {
    if caller.principal.role < role { Err(ApiError::role(role)) } else { Ok(()) }
}

/// The alarms that are not normal, the most urgent first.
#[utoipa::path(get, path = "/api/alarms",
    responses((status = 200, body = Vec<crate::alarms::Alarm>), (status = 401)))]
async fn alarms(State(hub): State<Hub>, _: Caller) -> Json<Value> {
    Json(json!(lock(&hub.alarms).list()))
}

/// Acknowledges alarms; without a list, all.
#[utoipa::path(post, path = "/api/alarms/ack", request_body = Ids,
    responses((status = 200, body = Vec<crate::alarms::Alarm>), (status = 400), (status = 401), (status = 403)))]
async fn acknowledge(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Ids { ids }): Body<Ids>,
) -> Result<Json<Value>, ApiError> {
    needs(&caller, Role::Operator)?;
    let (now_ms, user) = (hub.clock.now_ms(), &caller.principal.user);
    let changes: Vec<_> = {
        let mut alarms = lock(&hub.alarms);
        let ids = ids.unwrap_or_else(|| alarms.unacknowledged());
        ids.iter().filter_map(|id| alarms.acknowledge(now_ms, id, user)).collect()
    };
    for change in &changes {
        let what = format!("acknowledge {}", change.id);
        drop(hub.audit.note(hub.record(&caller, &change.monitor, &what, "Ok")));
    }
    hub.publish_alarms(changes);
    Ok(Json(json!(lock(&hub.alarms).list())))
}

/// Puts an alarm on the shelf.
#[utoipa::path(post, path = "/api/alarms/shelve", request_body = Shelve,
    responses((status = 200, body = Object), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn shelve(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Shelve { id, minutes, reason }): Body<Shelve>,
) -> Result<Json<Value>, ApiError> {
    needs(&caller, Role::Operator)?;
    if !(1..=SHELVE_MAX_MIN).contains(&minutes) || reason.trim().is_empty() {
        return Err(ApiError::bad_request(both(
            format!("It takes a reason and 1…{SHELVE_MAX_MIN} minutes."),
            format!("Нужны причина и 1…{SHELVE_MAX_MIN} минут."),
        )));
    }
    let until_ms = hub.clock.now_ms() + minutes * 60_000;
    let change = lock(&hub.alarms).shelve(&id, &caller.principal.user, until_ms, reason.trim());
    let change = change.ok_or_else(ApiError::not_found)?;
    let mut record = hub.record(&caller, &change.monitor, &format!("shelve {id}"), "Ok");
    record.details = json!({ "minutes": minutes, "reason": reason.trim() });
    drop(hub.audit.note(record));
    hub.publish_alarms(vec![change]);
    Ok(Json(json!(lock(&hub.alarms).get(&id))))
}

/// Takes it down.
#[utoipa::path(post, path = "/api/alarms/unshelve", request_body = Id,
    responses((status = 200, body = Object), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn unshelve(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Id { id }): Body<Id>,
) -> Result<Json<Value>, ApiError> {
    needs(&caller, Role::Operator)?;
    let change = lock(&hub.alarms).unshelve(&id, Some(&caller.principal.user));
    let change = change.ok_or_else(ApiError::not_found)?;
    drop(hub.audit.note(hub.record(&caller, &change.monitor, &format!("unshelve {id}"), "Ok")));
    hub.publish_alarms(vec![change]);
    Ok(Json(json!(lock(&hub.alarms).get(&id))))
}

/// What alarms did.
#[utoipa::path(get, path = "/api/alarms/history", params(Range),
    responses((status = 200, body = Vec<Object>), (status = 400), (status = 401), (status = 503)))]
async fn alarm_log(
    State(hub): State<Hub>,
    _: Caller,
    range: Asked<Range>,
) -> Result<Json<Value>, ApiError> {
    let Query(range) = range.map_err(|error| not_understood(&error))?;
    let base = lock(&hub.history).base();
    let times = (range.from_ms.unwrap_or(0), range.to_ms.unwrap_or(u64::MAX));
    let limit = range.limit.unwrap_or(100).min(LIMIT_MAX);
    Ok(Json(Value::Array(base.alarms(range.monitor, times, limit).await?)))
}

/// The latest entries of the audit log.
#[utoipa::path(get, path = "/api/audit", params(Wanted),
    responses((status = 200, body = Object), (status = 400), (status = 401), (status = 403)))]
async fn audit(
    State(hub): State<Hub>,
    caller: Caller,
    wanted: Asked<Wanted>,
) -> Result<Json<Value>, ApiError> {
    needs(&caller, Role::Operator)?;
    let Query(wanted) = wanted.map_err(|error| not_understood(&error))?;
    let page = hub.audit.find(wanted.into()).await?;
    Ok(Json(json!({
        "entries": page.found, "next": page.next, "waiting": hub.audit.waiting(),
    })))
}

/// Checks the chain of the audit log.
#[utoipa::path(get, path = "/api/audit/verify",
    responses((status = 200, body = crate::store::Verified), (status = 401), (status = 403)))]
async fn verify(State(hub): State<Hub>, caller: Caller) -> Result<Json<Value>, ApiError> {
    needs(&caller, Role::Operator)?;
    Ok(Json(json!(hub.audit.verify().await?)))
}

/// The whole audit log: an entry in each line.
#[utoipa::path(get, path = "/api/audit/export",
    responses((status = 200, content_type = "application/x-ndjson"), (status = 401), (status = 403)))]
async fn export(State(hub): State<Hub>, caller: Caller) -> Result<Response, ApiError> {
    needs(&caller, Role::Engineer)?;
    drop(hub.audit.note(hub.record(&caller, "", "export audit log", "Ok")));
    // Read in pieces as they are taken: a long log does not have to fit into memory.
    let pieces = futures_util::stream::try_unfold((hub, 1_u64), |(hub, next)| async move {
        let entries = hub.audit.from(next, LIMIT_MAX).await.map_err(std::io::Error::other)?;
        let Some(last) = entries.last() else { return Ok(None) };
        let after = last.n + 1;
        let lines = entries.iter().filter_map(|entry| serde_json::to_string(entry).ok());
        let text: String = lines.map(|line| line + "\n").collect();
        Ok::<_, std::io::Error>(Some((text, (hub, after))))
    });
    let kind = (header::CONTENT_TYPE, "application/x-ndjson");
    let name = (header::CONTENT_DISPOSITION, "attachment; filename=\"lafet-audit.jsonl\"");
    Ok(([kind, name], HttpBody::from_stream(pieces)).into_response())
}

/// The series of a monitor.
#[utoipa::path(get, path = "/api/history/series", params(Part),
    responses((status = 200, body = Vec<Object>), (status = 400), (status = 401), (status = 404)))]
async fn series(
    State(hub): State<Hub>,
    _: Caller,
    part: Asked<Part>,
) -> Result<Json<Value>, ApiError> {
    let Query(part) = part.map_err(|error| not_understood(&error))?;
    let status = hub.station(&part.monitor)?.status();
    let mut list = Vec::new();
    for name in status.subsystems.keys() {
        let Some(id) = SubsystemId::from_name(name) else { continue };
        for field in of_answer(RequestId::GET_STATUS, id).iter().flat_map(|layout| layout.fields) {
            let field_name = if field.kind == Kind::Flags { "bits" } else { field.name };
            list.push(json!({
                "series": format!("{name}.{field_name}"), "unit": Both::from(field.unit.name()),
                "text": Both::from(field.text),
            }));
        }
    }
    list.extend(crate::link_series::list());
    Ok(Json(Value::Array(list)))
}

/// Values over time.
#[utoipa::path(get, path = "/api/history", params(Part),
    responses((status = 200, body = Object), (status = 400), (status = 401), (status = 404), (status = 503)))]
async fn history(
    State(hub): State<Hub>,
    _: Caller,
    part: Asked<Part>,
) -> Result<Json<Value>, ApiError> {
    let (minutes, all) = read(&hub, part).await?;
    let all: Map<String, Value> = all.into_iter().map(|(name, rows)| (name, json!(rows))).collect();
    let resolution_ms = if minutes { 60_000 } else { 0 };
    Ok(Json(json!({ "resolution_ms": resolution_ms, "series": all })))
}

/// The same as CSV.
#[utoipa::path(get, path = "/api/history.csv", params(Part),
    responses((status = 200, content_type = "text/csv"), (status = 400), (status = 401), (status = 404), (status = 503)))]
async fn history_csv(
    State(hub): State<Hub>,
    _: Caller,
    part: Asked<Part>,
) -> Result<Response, ApiError> {
    let (minutes, all) = read(&hub, part).await?;
    let mut text =
        String::from(if minutes { "series,t_ms,mean,least,most\n" } else { "series,t_ms,value\n" });
    for (name, rows) in all {
        for row in rows {
            let cell =
                |value: &Value| if value.is_null() { String::new() } else { value.to_string() };
            let cells: Vec<String> = row.iter().map(cell).collect();
            text.push_str(&format!("{name},{}\n", cells.join(",")));
        }
    }
    let headers = [
        (header::CONTENT_TYPE, "text/csv; charset=utf-8"),
        (header::CONTENT_DISPOSITION, "attachment; filename=\"lafet-history.csv\""),
    ];
    Ok((headers, text).into_response())
}

/// The same as Parquet.
#[utoipa::path(get, path = "/api/history.parquet", params(Part),
    responses((status = 200, content_type = "application/vnd.apache.parquet"), (status = 400), (status = 401),
    (status = 404), (status = 503)))]
async fn history_parquet(
    State(hub): State<Hub>,
    _: Caller,
    part: Asked<Part>,
) -> Result<Response, ApiError> {
    let (minutes, all) = read(&hub, part).await?;
    let file = super::parquet::file(minutes, &all).map_err(StoreError::Io)?;
    let kind = (header::CONTENT_TYPE, "application/vnd.apache.parquet");
    let name = (header::CONTENT_DISPOSITION, "attachment; filename=\"lafet-history.parquet\"");
    Ok(([kind, name], file).into_response())
}

/// Series with their rows.
pub type Rows = Vec<(String, Vec<Vec<Value>>)>;

async fn read(hub: &Hub, part: Asked<Part>) -> Result<(bool, Rows), ApiError> {
    let Query(part) = part.map_err(|error| not_understood(&error))?;
    hub.station(&part.monitor)?;
    let to_ms = part.to_ms.unwrap_or_else(|| hub.clock.now_ms());
    let from_ms = part.from_ms.unwrap_or_else(|| to_ms.saturating_sub(RAW_RANGE_MS));
    let minutes = to_ms.saturating_sub(from_ms) > RAW_RANGE_MS;
    let names: Vec<String> =
        part.series.unwrap_or_default().split(',').take(SERIES_MAX).map(str::to_owned).collect();
    let points = part.points.unwrap_or(POINTS_MAX).clamp(1, POINTS_MAX);
    let base = {
        let mut history = lock(&hub.history);
        history.flush();
        history.base()
    };
    let mut rows = Vec::new();
    for name in names.into_iter().filter(|name| !name.is_empty()) {
        let range = (from_ms, to_ms);
        let values = base.values(&part.monitor, &name, range, minutes, points).await?;
        rows.push((name, values));
    }
    Ok((minutes, rows))
}
