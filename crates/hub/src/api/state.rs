//! How the hub is, who is signed in, what has happened.

use std::path::Path as FsPath;
use std::sync::atomic::Ordering;

use axum::Json;
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::time::Instant;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::admin::{change, only_administrators};
use super::guard::not_understood;
use super::records::{Asked, LIMIT_MAX, between};
use crate::access::Kind;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::store::{Act, Search};
use crate::sync::lock;

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new()
        .routes(routes!(state))
        .routes(routes!(sessions))
        .routes(routes!(end_session))
        .routes(routes!(events))
}

/// Part of a log.
#[derive(Debug, Deserialize, IntoParams)]
pub struct Wanted {
    monitor: Option<String>,
    user: Option<String>,
    /// With this text in it, capital and small letters alike.
    text: Option<String>,
    from_ms: Option<u64>,
    to_ms: Option<u64>,
    before: Option<u64>,
    limit: Option<u32>,
}

impl TryFrom<Wanted> for Search {
    type Error = ApiError;

    fn try_from(it: Wanted) -> Result<Self, ApiError> {
        between(it.from_ms, it.to_ms)?;
        Ok(Self {
            monitor: it.monitor,
            user: it.user,
            text: it.text.map(|text| text.to_lowercase()),
            from_ms: it.from_ms,
            to_ms: it.to_ms,
            before: it.before,
            limit: it.limit.unwrap_or(100).min(LIMIT_MAX) as usize,
        })
    }
}

/// How the hub is.
#[utoipa::path(get, path = "/api/hub/state",
    responses((status = 200, body = Object), (status = 401), (status = 503)))]
async fn state(State(hub): State<Hub>, _: Caller) -> Result<Json<Value>, ApiError> {
    let entries = hub.audit.last().await?;
    let of = |count: &std::sync::atomic::AtomicU64| count.load(Ordering::Relaxed);
    let counts = &hub.counts;
    let now_ms = hub.clock.now_ms();
    let (failing, lost) = {
        let history = lock(&hub.history);
        (history.is_failing(), history.given_up())
    };
    let place = hub.clone();
    let disk = tokio::task::spawn_blocking(move || disk(&place)).await.unwrap_or_default();
    Ok(Json(json!({
        "version": env!("CARGO_PKG_VERSION"), "started_ms": hub.started_ms, "now_ms": now_ms,
        "uptime_ms": u64::try_from(hub.now().as_millis()).unwrap_or(u64::MAX),
        "monitors": hub.stations().len(), "memory_bytes": memory_bytes(),
        "clients": {
            "connections": of(&counts.connections), "connections_max": hub.config.connections_max,
            "websockets": of(&counts.sockets), "missed": of(&counts.missed),
        },
        "totals": {
            "commands": of(&counts.commands), "refused": of(&counts.refused),
            "jogs": of(&counts.jogs), "logins_failed": of(&counts.logins_failed),
        },
        "rates": hub.rates.json(Instant::now(), counts),
        "stop_max_ms": of(&counts.stop_max_us) as f64 / 1000.0,
        "audit": {
            "entries": entries, "waiting": hub.audit.waiting(), "lost": hub.audit.lost(),
            "failing": hub.audit.is_failing(),
        },
        "history": {
            "base": if hub.config.postgres.is_some() { "postgresql" } else { "sqlite" },
            "failing": failing, "lost": lost,
            "raw_days": hub.config.raw_days, "minute_days": hub.config.minute_days,
        },
        "disk": disk,
    })))
}

/// What is kept, and how much room there is.
fn disk(hub: &Hub) -> Value {
    let recordings: u64 = hub.recordings.list().iter().map(|it| it.size).sum();
    let data = hub.config.data.as_deref();
    let (free, total) = data.and_then(room).unzip();
    let size = |name: &str| {
        data.map(|folder| {
            // SQLite keeps what is new beside the file for a while.
            let one = |end: &str| std::fs::metadata(folder.join(format!("{name}.db{end}")));
            ["", "-wal"].iter().filter_map(|end| Some(one(end).ok()?.len())).sum::<u64>()
        })
    };
    json!({
        "audit_bytes": size("audit"), "history_bytes": size("history"),
        "events_bytes": size("events"), "users_bytes": size("hub"),
        "recordings_bytes": recordings, "free_bytes": free, "total_bytes": total,
    })
}

/// Free and total bytes of the disk that has a folder.
#[cfg(unix)]
fn room(folder: &FsPath) -> Option<(u64, u64)> {
    let disk = rustix::fs::statvfs(folder).ok()?;
    Some((disk.f_bavail.saturating_mul(disk.f_frsize), disk.f_blocks.saturating_mul(disk.f_frsize)))
}

/// Other systems are not asked.
#[cfg(not(unix))]
fn room(_: &FsPath) -> Option<(u64, u64)> {
    None
}

/// Memory that this program has, where Linux tells it.
fn memory_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

/// Who is signed in.
#[utoipa::path(get, path = "/api/sessions",
    responses((status = 200, body = Vec<Object>), (status = 401), (status = 403)))]
async fn sessions(State(hub): State<Hub>, caller: Caller) -> Result<Json<Value>, ApiError> {
    only_administrators(&caller)?;
    let known = hub.access.sessions(hub.clock.steady_ms());
    let date = |ms| hub.access.date_ms(ms);
    let seated = hub.seated();
    let seats = |key: &str| -> Vec<Value> {
        let own = seated.iter().filter(|it| it.principal.key == key && it.open);
        own.map(|it| json!({ "seat": it.seat, "from": it.from, "since_ms": it.since_ms })).collect()
    };
    let own = |id: &str| caller.principal.key == id;
    let mut all: Vec<Value> = known
        .iter()
        .map(|it| {
            json!({
                "id": it.key, "user": it.user, "role": it.role, "kind": Kind::Session,
                "created_ms": date(it.created_ms), "used_ms": date(it.used_ms),
                "expires_ms": date(it.expires_ms()),
                "own": own(&it.key), "seats": seats(&it.key),
            })
        })
        .collect();
    let mut others: Vec<_> =
        seated.iter().filter(|it| it.principal.kind != Kind::Session && it.open).collect();
    others.sort_by(|a, b| a.principal.key.cmp(&b.principal.key));
    others.dedup_by(|a, b| a.principal.key == b.principal.key);
    for it in others.into_iter().map(|it| &it.principal) {
        all.push(json!({
            "id": it.key, "user": it.user, "role": it.role, "kind": it.kind, "created_ms": null,
            "used_ms": null, "expires_ms": null, "own": own(&it.key), "seats": seats(&it.key),
        }));
    }
    Ok(Json(Value::Array(all)))
}

/// Ends somebody's session; its WebSockets are closed.
#[utoipa::path(delete, path = "/api/sessions/{id}", params(("id" = String, Path)),
    responses((status = 204), (status = 401), (status = 403), (status = 404)))]
async fn end_session(
    State(hub): State<Hub>,
    caller: Caller,
    Path(id): Path<String>,
) -> Result<StatusCode, ApiError> {
    let what = (format!("end session {id}"), Act::EndSession { session: id.clone() });
    let now_ms = hub.clock.steady_ms();
    change(&hub, &caller, what, move |hub| hub.access.end_session(now_ms, &id)).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// What has happened, the latest first.
#[utoipa::path(get, path = "/api/events", params(Wanted),
    responses((status = 200, body = Object), (status = 400), (status = 401), (status = 503)))]
async fn events(
    State(hub): State<Hub>,
    _: Caller,
    wanted: Asked<Wanted>,
) -> Result<Json<Value>, ApiError> {
    let Query(wanted) = wanted.map_err(|error| not_understood(&error))?;
    let page = hub.events.find(wanted.try_into()?).await?;
    Ok(Json(json!({ "events": page.found, "next": page.next })))
}
