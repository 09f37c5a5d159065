//! Figures for Prometheus, and whether the hub is well.

use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::request::Parts;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::{Map, Value, json};

use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::model;
use crate::sync::lock;

/// Who may see metrics: everybody if so configured.
pub struct Reader;

impl FromRequestParts<Hub> for Reader {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, hub: &Hub) -> Result<Self, ApiError> {
        if !hub.config.metrics_open {
            Caller::from_request_parts(parts, hub).await?;
        }
        Ok(Self)
    }
}

/// Whether the hub is well.
#[utoipa::path(get, path = "/health", responses((status = 200, body = Object), (status = 503)))]
pub async fn health(State(hub): State<Hub>) -> (StatusCode, Json<Value>) {
    let failing = hub.audit.is_failing();
    let monitors: Map<String, Value> =
        hub.stations().iter().map(|it| (it.id().to_owned(), it.health().into())).collect();
    let history = lock(&hub.history).is_failing();
    let degraded = failing || history || monitors.values().any(|state| state != "up");
    let status = if failing { StatusCode::SERVICE_UNAVAILABLE } else { StatusCode::OK };
    let body = json!({
        "status": if degraded { "degraded" } else { "ok" }, "monitors": monitors,
        "storage": if failing { "failing" } else { "ok" },
        "history": if history { "failing" } else { "ok" },
    });
    (status, Json(body))
}

/// Figures for Prometheus.
#[utoipa::path(get, path = "/metrics",
    responses((status = 200, content_type = "text/plain"), (status = 401)))]
pub async fn metrics(State(hub): State<Hub>, _: Reader) -> Response {
    let kind = (header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8");
    ([kind], text(&hub)).into_response()
}

fn text(hub: &Hub) -> String {
    let mut text = String::new();
    let of = |count: &AtomicU64| count.load(Ordering::Relaxed) as f64;
    let counts = &hub.counts;
    let alarms = lock(&hub.alarms).list().iter().filter(|alarm| alarm.active).count();
    let plain = [
        ("connections", "gauge", "Connections that are open.", of(&counts.connections)),
        ("websockets", "gauge", "WebSockets that are open.", of(&counts.sockets)),
        ("commands_total", "counter", "Requests to monitors.", of(&counts.commands)),
        (
            "commands_refused_total",
            "counter",
            "Requests that were not allowed.",
            of(&counts.refused),
        ),
        ("jogs_total", "counter", "Motions held by somebody.", of(&counts.jogs)),
        (
            "messages_missed_total",
            "counter",
            "Messages dropped for slow connections.",
            of(&counts.missed),
        ),
        ("logins_failed_total", "counter", "Logins that failed.", of(&counts.logins_failed)),
        (
            "stop_seconds_max",
            "gauge",
            "Longest Stop, Close or Lockout, answer included.",
            of(&counts.stop_max_us) / 1e6,
        ),
        (
            "audit_waiting",
            "gauge",
            "Entries of the audit log that are not on the disk.",
            hub.audit.waiting() as f64,
        ),
        (
            "audit_lost_total",
            "counter",
            "Entries of the audit log that were given up.",
            hub.audit.lost() as f64,
        ),
        (
            "history_lost_total",
            "counter",
            "Values that were given up.",
            lock(&hub.history).given_up() as f64,
        ),
        ("alarms_active", "gauge", "Alarms whose condition holds.", alarms as f64),
        ("uptime_seconds", "gauge", "Time since the start.", hub.now().as_secs_f64()),
    ];
    for (name, kind, help, value) in plain {
        family(&mut text, name, kind, help, [(String::new(), value)]);
    }
    let all = hub.stations();
    let stations = || all.iter();
    let label = |id: &str| format!("{{monitor=\"{id}\"}}");
    let up = stations().map(|it| (label(it.id()), f64::from(u8::from(it.health() == "up"))));
    family(&mut text, "monitor_up", "gauge", "The monitor answers.", up);
    type Figure = fn(&lafet_client::Stats) -> f64;
    let figures: [(&str, &str, &str, Figure); 6] = [
        ("frames_sent_total", "counter", "Frames sent.", |it| it.frames_sent as f64),
        ("frames_received_total", "counter", "Frames received.", |it| model::received(it) as f64),
        ("frame_errors_total", "counter", "Frames with errors on its line.", |it| {
            it.errors() as f64
        }),
        ("retries_total", "counter", "Frames sent again.", |it| it.retries as f64),
        ("timeouts_total", "counter", "Answers that did not come.", |it| it.timeouts as f64),
        ("round_trip_seconds", "gauge", "Smoothed round trip.", |it| {
            it.rtt_average.map_or(f64::NAN, |rtt| rtt.as_secs_f64())
        }),
    ];
    for (name, kind, help, figure) in figures {
        let values =
            stations().filter_map(|it| Some((label(it.id()), figure(&it.client().ok()?.stats()))));
        family(&mut text, name, kind, help, values);
    }
    let fields = stations().flat_map(|station| {
        let (id, status) = (station.id().to_owned(), station.status());
        let values = status.subsystems.iter().flat_map(|(name, state)| {
            let field = |(field, value): (&&str, &i64)| {
                let labels = format!("{{monitor=\"{id}\",subsystem=\"{name}\",field=\"{field}\"}}");
                (labels, *value as f64)
            };
            state.fields.iter().map(field).collect::<Vec<_>>()
        });
        if status.stale { Vec::new() } else { values.collect::<Vec<_>>() }
    });
    family(&mut text, "status", "gauge", "Fields of GetStatus, in the protocol's units.", fields);
    text
}

fn family(
    text: &mut String,
    name: &str,
    kind: &str,
    help: &str,
    values: impl IntoIterator<Item = (String, f64)>,
) {
    // Writing into a string does not fail.
    _ = writeln!(text, "# HELP lafet_{name} {help}\n# TYPE lafet_{name} {kind}");
    for (labels, value) in values {
        _ = writeln!(text, "lafet_{name}{labels} {value}");
    }
}
