//! Alarms, the audit log, history.

use std::collections::BTreeMap;
use std::fmt::Write;

use axum::Json;
use axum::body::Body as HttpBody;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use lafet_proto::dictionary::layouts::{Kind, of_answer};
use lafet_proto::{RequestId, SubsystemId};
use lafet_texts::{Text as _, hub as text};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, not_understood};
use super::state::Wanted;
use crate::access::Role;
use crate::alarms::{Alarm, SHELVE_MAX_MIN, are_words};
use crate::control::authority::REASON_MAX;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::link_series::{self, SeriesInfo};
use crate::store::{Act, AlarmChange, DAY_MS, Entry, RAW_RANGE_MS, Rows, Verified, resolution_ms};

/// Most entries of one answer.
pub const LIMIT_MAX: u32 = 1000;
/// Most series of one answer.
const SERIES_MAX: usize = 32;
/// Points of a series in one answer.
const POINTS_MIN: usize = 4;
const POINTS_MAX: usize = 10_000;
/// Points of an answer that is written at once. What is longer takes milliseconds, and is written beside.
const FEW_POINTS: usize = 1000;

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

/// Ids of alarms.
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

/// Part of the audit log.
#[derive(Debug, Serialize, ToSchema)]
struct AuditPage {
    /// The entries, the latest first.
    entries: Vec<Entry>,
    /// There may be more before this number.
    #[schema(required)]
    next: Option<u64>,
    /// Entries that are not on the disk yet.
    waiting: u64,
}

/// Id of an alarm.
#[derive(Debug, Deserialize, ToSchema)]
struct Id {
    id: String,
}

/// Part of a log to return.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Range {
    monitor: Option<String>,
    from_ms: Option<u64>,
    to_ms: Option<u64>,
    limit: Option<u32>,
}

/// Part of the history to return.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Part {
    monitor: String,
    /// Names with commas between them.
    series: Option<String>,
    from_ms: Option<u64>,
    to_ms: Option<u64>,
    /// At most so many points of a series: 4…10000.
    points: Option<usize>,
}

/// The caller has this role at least.
pub fn needs(caller: &Caller, role: Role) -> Result<(), ApiError> {
    if caller.principal.role < role { Err(ApiError::role(role)) } else { Ok(()) }
}

/// The alarms that are not normal, the most urgent first.
#[utoipa::path(get, path = "/api/alarms",
    responses((status = 200, body = Vec<Alarm>), (status = 401)))]
async fn alarms(State(hub): State<Hub>, _: Caller) -> Json<Vec<Alarm>> {
    Json(hub.alarms().list().into_iter().cloned().collect())
}

/// Acknowledges alarms; without a list, all.
#[utoipa::path(post, path = "/api/alarms/ack", request_body = Ids,
    responses((status = 200, body = Vec<Alarm>), (status = 400), (status = 401), (status = 403)))]
async fn acknowledge(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Ids { ids }): Body<Ids>,
) -> Result<Json<Vec<Alarm>>, ApiError> {
    needs(&caller, Role::Operator)?;
    hub.acknowledge_alarms(&caller, ids, "");
    Ok(Json(hub.alarms().list().into_iter().cloned().collect()))
}

/// Puts an alarm on the shelf.
#[utoipa::path(post, path = "/api/alarms/shelve", request_body = Shelve,
    responses((status = 200, body = Option<Alarm>), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn shelve(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Shelve { id, minutes, reason }): Body<Shelve>,
) -> Result<Json<Option<Alarm>>, ApiError> {
    needs(&caller, Role::Operator)?;
    if !(1..=SHELVE_MAX_MIN).contains(&minutes)
        || !(1..=REASON_MAX).contains(&reason.trim().chars().count())
    {
        return Err(ApiError::bad_request(
            text::ShelveRange { reason_max: REASON_MAX, shelve_max_min: SHELVE_MAX_MIN }.words(),
        ));
    }
    if !are_words(reason.trim()) {
        return Err(ApiError::bad_request(text::ReasonControl.words()));
    }
    if !hub.shelve_alarm(&caller, &id, minutes, reason.trim()) {
        return Err(ApiError::not_found());
    }
    Ok(Json(hub.alarms().get(&id).cloned()))
}

/// Ends the shelving of an alarm.
#[utoipa::path(post, path = "/api/alarms/unshelve", request_body = Id,
    responses((status = 200, body = Option<Alarm>), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn unshelve(
    State(hub): State<Hub>,
    caller: Caller,
    Body(Id { id }): Body<Id>,
) -> Result<Json<Option<Alarm>>, ApiError> {
    needs(&caller, Role::Operator)?;
    if !hub.unshelve_alarm(&caller, &id) {
        return Err(ApiError::not_found());
    }
    Ok(Json(hub.alarms().get(&id).cloned()))
}

/// Changes of alarms in a range of time.
#[utoipa::path(get, path = "/api/alarms/history", params(Range),
    responses((status = 200, body = Vec<AlarmChange>), (status = 400), (status = 401), (status = 503)))]
async fn alarm_log(
    State(hub): State<Hub>,
    _: Caller,
    range: Asked<Range>,
) -> Result<Json<Vec<AlarmChange>>, ApiError> {
    let Query(range) = range.map_err(|error| not_understood(&error))?;
    let base = hub.history().base();
    let times = between(range.from_ms, range.to_ms)?;
    let limit = range.limit.unwrap_or(100).min(LIMIT_MAX);
    Ok(Json(base.alarms(range.monitor, times, limit).await?))
}

/// The latest entries of the audit log.
#[utoipa::path(get, path = "/api/audit", params(Wanted),
    responses((status = 200, body = AuditPage), (status = 400), (status = 401), (status = 403)))]
async fn audit(
    State(hub): State<Hub>,
    caller: Caller,
    wanted: Asked<Wanted>,
) -> Result<Json<AuditPage>, ApiError> {
    needs(&caller, Role::Operator)?;
    let Query(wanted) = wanted.map_err(|error| not_understood(&error))?;
    let page = hub.audit().find(wanted.try_into()?).await?;
    let waiting = hub.audit().waiting();
    let entries = page.found.into_iter().map(Entry::shown).collect();
    Ok(Json(AuditPage { entries, next: page.next, waiting }))
}

/// Checks the chain of the audit log.
#[utoipa::path(get, path = "/api/audit/verify",
    responses((status = 200, body = Verified), (status = 401), (status = 403)))]
async fn verify(State(hub): State<Hub>, caller: Caller) -> Result<Json<Verified>, ApiError> {
    needs(&caller, Role::Operator)?;
    Ok(Json(hub.audit().verify().await?))
}

/// The whole audit log: an entry in each line.
#[utoipa::path(get, path = "/api/audit/export",
    responses((status = 200, content_type = "application/x-ndjson"), (status = 401), (status = 403)))]
async fn export(State(hub): State<Hub>, caller: Caller) -> Result<Response, ApiError> {
    needs(&caller, Role::Engineer)?;
    let record = hub.record(&caller, "", "export audit log", "Ok");
    drop(hub.audit().note(record.about(&Act::ExportAudit)));
    // Read in pieces as they are taken: a long log does not have to fit into memory.
    let pieces = futures_util::stream::try_unfold((hub, 1_u64), |(hub, next)| async move {
        let piece = hub.audit().lines(next).await.map_err(std::io::Error::other)?;
        Ok::<_, std::io::Error>(piece.map(|(lines, next)| (lines, (hub, next))))
    });
    let kind = (header::CONTENT_TYPE, "application/x-ndjson");
    let name = (header::CONTENT_DISPOSITION, "attachment; filename=\"lafet-audit.jsonl\"");
    Ok(([kind, name], HttpBody::from_stream(pieces)).into_response())
}

/// The series of a monitor.
#[utoipa::path(get, path = "/api/history/series", params(Part),
    responses((status = 200, body = Vec<SeriesInfo>), (status = 400), (status = 401), (status = 404)))]
async fn series(
    State(hub): State<Hub>,
    _: Caller,
    part: Asked<Part>,
) -> Result<Json<Vec<SeriesInfo>>, ApiError> {
    let Query(part) = part.map_err(|error| not_understood(&error))?;
    let status = hub.station(&part.monitor)?.status();
    let mut list = Vec::new();
    for name in status.subsystems.keys() {
        let Some(id) = SubsystemId::from_name(name) else { continue };
        for field in of_answer(RequestId::GET_STATUS, id).iter().flat_map(|layout| layout.fields) {
            let field_name = if field.kind == Kind::Flags { "bits" } else { field.name };
            list.push(SeriesInfo {
                series: format!("{name}.{field_name}"),
                unit: field.unit.name().map(|it| it.words()).unwrap_or_default(),
                text: field.text.words(),
            });
        }
    }
    list.extend(link_series::list());
    Ok(Json(list))
}

/// Values over time.
#[utoipa::path(get, path = "/api/history", params(Part),
    responses((status = 200, body = Read), (status = 400), (status = 401), (status = 404), (status = 503)))]
async fn history(
    State(hub): State<Hub>,
    caller: Caller,
    part: Asked<Part>,
) -> Result<Response, ApiError> {
    let read = read(&hub, part).await?;
    written(&hub, &caller, read, |read| Json(read).into_response()).await
}

/// The same as CSV.
#[utoipa::path(get, path = "/api/history.csv", params(Part),
    responses((status = 200, content_type = "text/csv"), (status = 400), (status = 401), (status = 404), (status = 503)))]
async fn history_csv(
    State(hub): State<Hub>,
    caller: Caller,
    part: Asked<Part>,
) -> Result<Response, ApiError> {
    let read = read(&hub, part).await?;
    let text = written(&hub, &caller, read, csv).await?;
    let headers = [
        (header::CONTENT_TYPE, "text/csv; charset=utf-8"),
        (header::CONTENT_DISPOSITION, "attachment; filename=\"lafet-history.csv\""),
    ];
    Ok((headers, text).into_response())
}

fn csv(read: &Read) -> String {
    let mut text = String::from(match read.resolution_ms {
        0 => "series,t_ms,value\n",
        _ => "series,t_ms,mean,least,most\n",
    });
    for (name, rows) in &read.series {
        // Writing into a string does not fail.
        match rows {
            Rows::Changes(rows) => rows.iter().for_each(|(t, value)| {
                let value = value.map(|it| it.to_string()).unwrap_or_default();
                _ = writeln!(text, "{name},{t},{value}");
            }),
            Rows::Spans(rows) => rows.iter().for_each(|(t, mean, least, most)| {
                _ = writeln!(text, "{name},{t},{mean},{least},{most}");
            }),
        }
    }
    text
}

/// The same as Parquet. A program built without the feature `parquet` answers 501.
#[utoipa::path(get, path = "/api/history.parquet", params(Part),
    responses((status = 200, content_type = "application/vnd.apache.parquet"), (status = 400), (status = 401),
    (status = 404), (status = 501), (status = 503)))]
async fn history_parquet(
    State(hub): State<Hub>,
    caller: Caller,
    part: Asked<Part>,
) -> Result<Response, ApiError> {
    let read = read(&hub, part).await?;
    let file = written(&hub, &caller, read, super::parquet::file).await??;
    let kind = (header::CONTENT_TYPE, "application/vnd.apache.parquet");
    let name = (header::CONTENT_DISPOSITION, "attachment; filename=\"lafet-history.parquet\"");
    Ok(([kind, name], file).into_response())
}

/// Values of series over time.
#[derive(Debug, Serialize, ToSchema)]
pub struct Read {
    /// 0: each change, a value holds until the next one; otherwise the length of the spans, ms.
    pub resolution_ms: u64,
    /// `[t, value]` (null: not known), or `[t, mean, least, greatest]`, by series.
    #[schema(value_type = BTreeMap<String, Vec<Vec<Option<f64>>>>)]
    pub series: BTreeMap<String, Rows>,
}

/// Writes an answer; a long one on a thread of its own, in the turn of its client.
async fn written<T: Send + 'static>(
    hub: &Hub,
    caller: &Caller,
    read: Read,
    write: impl FnOnce(&Read) -> T + Send + 'static,
) -> Result<T, ApiError> {
    let points = read.series.values().map(|rows| match rows {
        Rows::Changes(rows) => rows.len(),
        Rows::Spans(rows) => rows.len(),
    });
    if points.sum::<usize>() <= FEW_POINTS {
        return Ok(write(&read));
    }
    let who = Some(&*caller.principal.key);
    hub.answering().beside(who, move || write(&read)).await
}

/// The latest time that is taken: the end of the year 9999.
const TIME_MAX_MS: u64 = 253_402_300_799_999;

/// A range of time that is in order: everything, where nothing is said of it.
pub fn between(from_ms: Option<u64>, to_ms: Option<u64>) -> Result<(u64, u64), ApiError> {
    let (from_ms, to_ms) = (from_ms.unwrap_or(0), to_ms.unwrap_or(TIME_MAX_MS));
    if from_ms > to_ms || to_ms > TIME_MAX_MS {
        return Err(ApiError::bad_request(text::TimesWrong { time_max_ms: TIME_MAX_MS }.words()));
    }
    Ok((from_ms, to_ms))
}

async fn read(hub: &Hub, part: Asked<Part>) -> Result<Read, ApiError> {
    let Query(part) = part.map_err(|error| not_understood(&error))?;
    hub.station(&part.monitor)?;
    let now_ms = hub.clock().now_ms();
    let to_ms = part.to_ms.unwrap_or(now_ms);
    let from_ms = part.from_ms.unwrap_or_else(|| to_ms.saturating_sub(RAW_RANGE_MS));
    let (from_ms, to_ms) = between(Some(from_ms), Some(to_ms))?;
    let minutes = to_ms - from_ms > RAW_RANGE_MS;
    // Of what is not kept and of the future there is nothing: spans are for the rest.
    let kept_ms = u64::from(hub.config().minute_days) * DAY_MS;
    let range = match minutes {
        true => (from_ms.max(now_ms.saturating_sub(kept_ms)), to_ms.min(now_ms)),
        false => (from_ms, to_ms),
    };
    let names: Vec<String> =
        part.series.unwrap_or_default().split(',').take(SERIES_MAX).map(str::to_owned).collect();
    let points = part.points.unwrap_or(POINTS_MAX).clamp(POINTS_MIN, POINTS_MAX);
    let resolution_ms = minutes.then(|| resolution_ms(range, points));
    let stored = hub.history().flushed();
    let base = stored.await;
    let mut series = BTreeMap::new();
    for name in names.into_iter().filter(|name| !name.is_empty()) {
        let values = base.values(&part.monitor, &name, range, resolution_ms, points).await?;
        series.insert(name, values);
    }
    Ok(Read { resolution_ms: resolution_ms.unwrap_or(0), series })
}

#[cfg(test)]
mod tests {
    use std::pin::pin;
    use std::time::Duration;

    use tokio::sync::oneshot;
    use tokio::time::timeout;

    use super::*;

    /// A long answer waits for its turn on another thread; a short one is there at once.
    #[tokio::test]
    async fn a_long_answer_is_written_beside() {
        let (hub, _) = Hub::of_one(None);
        let (starts, has_started) = oneshot::channel();
        let (go, hung) = std::sync::mpsc::channel::<()>();
        let own = hub.clone();
        let hangs = tokio::spawn(async move {
            let work = move || {
                _ = starts.send(());
                _ = hung.recv();
            };
            own.answering().beside(Some("a"), work).await.is_ok()
        });
        has_started.await.unwrap();
        let caller = Caller::hub();
        let of = |points: usize| {
            let rows = Rows::Changes(vec![(1, None); points]);
            let read = Read { resolution_ms: 0, series: [("a".to_owned(), rows)].into() };
            written(&hub, &caller, read, |read| csv(read).lines().count())
        };
        let short = timeout(Duration::from_secs(10), of(FEW_POINTS)).await;
        assert_eq!(short.expect("it waits for no turn").unwrap(), FEW_POINTS + 1);
        let mut long = pin!(of(FEW_POINTS + 1));
        assert!(timeout(Duration::from_millis(100), &mut long).await.is_err(), "it waits");
        go.send(()).unwrap();
        assert_eq!(long.await.unwrap(), FEW_POINTS + 2);
        assert!(hangs.await.unwrap());
    }
}
