//! How the hub is, who is signed in, what has happened.

use std::sync::atomic::Ordering;

use axum::Json;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use tokio::time::Instant;
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::admin::{change, only_administrators};
use super::guard::{Path, not_understood};
use super::records::{Asked, LIMIT_MAX, between};
use crate::access::{Kind, Role};
use crate::error::ApiError;
use crate::hub::PerSecond;
use crate::hub::{Caller, Hub, Seated, resident, room};
use crate::plugs::view::PlugView;
use crate::store::{Act, Event, Search};

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new()
        .routes(routes!(state))
        .routes(routes!(sessions))
        .routes(routes!(end_session))
        .routes(routes!(events))
}

/// Part of a log to return.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
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

/// State of the hub.
#[derive(Debug, Serialize, ToSchema)]
struct HubState {
    version: &'static str,
    started_ms: u64,
    now_ms: u64,
    /// Since the start, by a clock that does not jump.
    uptime_ms: u64,
    /// Number of monitors.
    monitors: usize,
    /// Memory of this program; null: not known.
    #[schema(required)]
    memory_bytes: Option<u64>,
    clients: Clients,
    totals: Totals,
    rates: PerSecond,
    /// Longest time from an urgent request to its answer, ms.
    stop_max_ms: f64,
    audit: AuditState,
    history: HistoryState,
    disk: Disk,
    /// Servers of other protocols and their clients, and brokers.
    plugs: Vec<PlugView>,
}

/// Open connections.
#[derive(Debug, Serialize, ToSchema)]
struct Clients {
    connections: u64,
    connections_max: usize,
    websockets: u64,
    /// Messages left out because a client reads too slowly.
    missed: u64,
}

/// Counts since the start.
#[derive(Debug, Serialize, ToSchema)]
struct Totals {
    commands: u64,
    refused: u64,
    jogs: u64,
    logins_failed: u64,
}

/// State of the audit log.
#[derive(Debug, Serialize, ToSchema)]
struct AuditState {
    entries: u64,
    /// Entries that are not on the disk yet.
    waiting: u64,
    /// Entries that were given up.
    lost: u64,
    /// The disk takes no entries.
    failing: bool,
}

/// State of the history.
#[derive(Debug, Serialize, ToSchema)]
struct HistoryState {
    /// `sqlite` or `postgresql`.
    base: &'static str,
    failing: bool,
    /// Values that were given up.
    lost: u64,
    raw_days: u32,
    minute_days: u32,
}

/// What is kept, and how much room there is; null: not known.
#[derive(Debug, Default, Serialize, ToSchema)]
struct Disk {
    #[schema(required)]
    audit_bytes: Option<u64>,
    #[schema(required)]
    history_bytes: Option<u64>,
    #[schema(required)]
    events_bytes: Option<u64>,
    #[schema(required)]
    users_bytes: Option<u64>,
    recordings_bytes: u64,
    #[schema(required)]
    free_bytes: Option<u64>,
    #[schema(required)]
    total_bytes: Option<u64>,
}

/// A session, or a token that is in use.
#[derive(Debug, Serialize, ToSchema)]
struct SessionView {
    id: String,
    user: String,
    role: Role,
    kind: Kind,
    #[schema(required)]
    created_ms: Option<u64>,
    #[schema(required)]
    used_ms: Option<u64>,
    #[schema(required)]
    expires_ms: Option<u64>,
    /// The session of the caller.
    own: bool,
    /// Its WebSockets.
    seats: Vec<SeatView>,
}

/// A WebSocket of a session.
#[derive(Debug, Serialize, ToSchema)]
struct SeatView {
    seat: String,
    /// Address of the other side.
    from: String,
    since_ms: u64,
}

/// Part of the event log.
#[derive(Debug, Serialize, ToSchema)]
struct EventPage {
    /// The events, the latest first.
    events: Vec<Event>,
    /// There may be more before this number.
    #[schema(required)]
    next: Option<u64>,
}

/// State of the hub.
#[utoipa::path(get, path = "/api/hub/state",
    responses((status = 200, body = HubState), (status = 401), (status = 503)))]
async fn state(State(hub): State<Hub>, _: Caller) -> Result<Json<HubState>, ApiError> {
    let entries = hub.audit().last().await?;
    let of = |count: &std::sync::atomic::AtomicU64| count.load(Ordering::Relaxed);
    let counts = hub.counts();
    let (failing, lost) = {
        let history = hub.history();
        (history.is_failing(), history.given_up())
    };
    let place = hub.clone();
    let disk = hub.recordings().on_disk(move || disk(&place)).await.unwrap_or_default();
    Ok(Json(HubState {
        version: env!("CARGO_PKG_VERSION"),
        started_ms: hub.started_ms(),
        now_ms: hub.clock().now_ms(),
        uptime_ms: hub.up_ms(),
        monitors: hub.stations().len(),
        memory_bytes: resident("self"),
        clients: Clients {
            connections: of(&counts.connections),
            connections_max: hub.config().connections_max,
            websockets: of(&counts.sockets),
            missed: of(&counts.missed),
        },
        totals: Totals {
            commands: of(&counts.commands),
            refused: of(&counts.refused),
            jogs: of(&counts.jogs),
            logins_failed: of(&counts.logins_failed),
        },
        rates: hub.rates().per_second(Instant::now(), counts),
        stop_max_ms: of(&counts.stop_max_us) as f64 / 1000.0,
        audit: AuditState {
            entries,
            waiting: hub.audit().waiting(),
            lost: hub.audit().lost(),
            failing: hub.audit().is_failing(),
        },
        history: HistoryState {
            base: if hub.config().postgres.is_some() { "postgresql" } else { "sqlite" },
            failing,
            lost,
            raw_days: hub.config().raw_days,
            minute_days: hub.config().minute_days,
        },
        disk,
        plugs: crate::plugs::views(&hub),
    }))
}

fn disk(hub: &Hub) -> Disk {
    let data = hub.config().data.as_deref();
    let (free_bytes, total_bytes) = data.and_then(room).unzip();
    let size = |name: &str| {
        data.map(|folder| {
            // SQLite keeps what is new beside the file for a while.
            let one = |end: &str| std::fs::metadata(folder.join(format!("{name}.db{end}")));
            ["", "-wal"].iter().filter_map(|end| Some(one(end).ok()?.len())).sum::<u64>()
        })
    };
    Disk {
        audit_bytes: size("audit"),
        history_bytes: size("history"),
        events_bytes: size("events"),
        users_bytes: size("hub"),
        recordings_bytes: hub.recordings().list().iter().map(|it| it.size).sum(),
        free_bytes,
        total_bytes,
    }
}

/// Sessions and tokens in use.
#[utoipa::path(get, path = "/api/sessions",
    responses((status = 200, body = Vec<SessionView>), (status = 401), (status = 403)))]
async fn sessions(
    State(hub): State<Hub>,
    caller: Caller,
) -> Result<Json<Vec<SessionView>>, ApiError> {
    only_administrators(&caller)?;
    let known = hub.access().sessions(hub.clock().steady_ms());
    let date = |ms| Some(hub.access().date_ms(ms));
    let seated = hub.connected();
    let seats = |key: &str| -> Vec<SeatView> {
        let own = seated.iter().filter(|it| it.principal.key == key && it.open);
        let view = |it: &Seated| {
            let (seat, from) = (it.seat.clone(), it.from.clone());
            SeatView { seat, from, since_ms: it.since_ms }
        };
        own.map(view).collect()
    };
    let mut all: Vec<SessionView> = known
        .iter()
        .map(|it| SessionView {
            id: it.key.clone(),
            user: it.user.clone(),
            role: it.role,
            kind: Kind::Session,
            created_ms: date(it.created_ms),
            used_ms: date(it.used_ms),
            expires_ms: date(it.expires_ms()),
            own: caller.principal.key == it.key,
            seats: seats(&it.key),
        })
        .collect();
    let mut others: Vec<_> =
        seated.iter().filter(|it| it.principal.kind != Kind::Session && it.open).collect();
    others.sort_by(|a, b| a.principal.key.cmp(&b.principal.key));
    others.dedup_by(|a, b| a.principal.key == b.principal.key);
    all.extend(others.into_iter().map(|it| &it.principal).map(|it| SessionView {
        id: it.key.clone(),
        user: it.user.clone(),
        role: it.role,
        kind: it.kind,
        created_ms: None,
        used_ms: None,
        expires_ms: None,
        own: caller.principal.key == it.key,
        seats: seats(&it.key),
    }));
    Ok(Json(all))
}

/// Ends a session; its WebSockets are closed.
#[utoipa::path(delete, path = "/api/sessions/{id}", params(("id" = String, Path)),
    responses((status = 204), (status = 401), (status = 403), (status = 404)))]
async fn end_session(
    State(hub): State<Hub>,
    caller: Caller,
    Path(id): Path<String>,
) -> Result<StatusCode, ApiError> {
    let what = (format!("end session {id}"), Act::EndSession { session: id.clone() });
    let now_ms = hub.clock().steady_ms();
    change(&hub, &caller, what, move |hub| hub.access().end_session(now_ms, &id)).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// What has happened, the latest first.
#[utoipa::path(get, path = "/api/events", params(Wanted),
    responses((status = 200, body = EventPage), (status = 400), (status = 401), (status = 503)))]
async fn events(
    State(hub): State<Hub>,
    _: Caller,
    wanted: Asked<Wanted>,
) -> Result<Json<EventPage>, ApiError> {
    let Query(wanted) = wanted.map_err(|error| not_understood(&error))?;
    let page = hub.events().find(wanted.try_into()?).await?;
    Ok(Json(EventPage { events: page.found, next: page.next }))
}
