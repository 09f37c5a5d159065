//! Figures for Prometheus, and whether the hub is well.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::request::Parts;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use lafet_client::Stats;
use serde::Serialize;
use utoipa::ToSchema;

use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::monitor::status::{self, Status};
use crate::store::Loss;
use crate::store::integrity::{ChainState, ChainWord};

/// Clients that may read metrics: all, if so configured.
pub struct Reader;

impl FromRequestParts<Hub> for Reader {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, hub: &Hub) -> Result<Self, ApiError> {
        if !hub.config().metrics_open {
            Caller::from_request_parts(parts, hub).await?;
        }
        Ok(Self)
    }
}

/// Whether the hub is well.
#[utoipa::path(get, path = "/health", responses((status = 200, body = Health), (status = 503, body = Health)))]
pub async fn health(State(hub): State<Hub>) -> (StatusCode, Json<Health>) {
    let failing = hub.audit().is_failing();
    let monitors: BTreeMap<String, &str> =
        hub.stations().iter().map(|it| (it.id().to_owned(), it.health())).collect();
    let (history, events) = (hub.history().is_failing(), hub.events().is_failing());
    let (chain, losses) = (hub.integrity().chain(), hub.integrity().losses());
    let doubt = chain.state == ChainWord::Broken || !losses.is_empty();
    let degraded =
        failing || history || events || doubt || monitors.values().any(|state| *state != "up");
    let status = if failing { StatusCode::SERVICE_UNAVAILABLE } else { StatusCode::OK };
    let word = |failing| if failing { "failing" } else { "ok" };
    let body = Health {
        status: if degraded { "degraded" } else { "ok" },
        monitors,
        storage: word(failing),
        history: word(history),
        audit_chain: chain,
        state_lost: losses,
    };
    (status, Json(body))
}

/// Whether the hub is well.
#[derive(Debug, Serialize, ToSchema)]
pub struct Health {
    /// `ok` or `degraded`.
    status: &'static str,
    /// `up`, `stale` or `down`, by monitor.
    monitors: BTreeMap<String, &'static str>,
    /// `ok` or `failing`: the audit log.
    storage: &'static str,
    /// `ok` or `failing`.
    history: &'static str,
    /// The chain of the audit log.
    audit_chain: ChainState,
    /// Files of the state that were lost or changed before this start.
    state_lost: Vec<Loss>,
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
    let counts = hub.counts();
    let alarms = hub.alarms().list().iter().filter(|alarm| alarm.active).count();
    let chain = hub.integrity().chain();
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
        ("jogs_total", "counter", "Motions by hand.", of(&counts.jogs)),
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
            hub.audit().waiting() as f64,
        ),
        (
            "audit_lost_total",
            "counter",
            "Entries of the audit log that were given up.",
            hub.audit().lost() as f64,
        ),
        (
            "audit_chain_ok",
            "gauge",
            "The audit log is as it was written, as far as it was checked.",
            f64::from(u8::from(chain.state != ChainWord::Broken)),
        ),
        (
            "audit_verified",
            "gauge",
            "Entries of the audit log up to which the chain was checked.",
            chain.verified as f64,
        ),
        (
            "history_lost_total",
            "counter",
            "Values that were given up.",
            hub.history().given_up() as f64,
        ),
        ("alarms_active", "gauge", "Alarms whose condition holds.", alarms as f64),
        ("uptime_seconds", "gauge", "Time since the start.", hub.now().as_secs_f64()),
    ];
    for (name, kind, help, value) in plain {
        head(&mut text, name, kind, help);
        _ = writeln!(text, "lafet_{name} {value}");
    }
    let all: Vec<Seen> = hub.stations().iter().map(|it| Seen::of(it)).collect();
    monitors(&mut text, &all);
    text
}

/// What is known of a monitor, read once.
struct Seen {
    id: String,
    up: bool,
    stats: Option<Stats>,
    status: Arc<Status>,
}

impl Seen {
    fn of(station: &Station) -> Self {
        Self {
            id: station.id().to_owned(),
            up: station.health() == "up",
            stats: station.client().ok().map(|client| client.stats()),
            status: station.status(),
        }
    }
}

/// Reads a figure of a link.
type Figure = fn(&Stats) -> f64;

/// Name, kind, what it is, and the figure.
const LINK: [(&str, &str, &str, Figure); 6] = [
    ("frames_sent_total", "counter", "Frames sent.", |it| it.frames_sent as f64),
    ("frames_received_total", "counter", "Frames received.", |it| status::received(it) as f64),
    ("frame_errors_total", "counter", "Frames with errors on its line.", |it| it.errors() as f64),
    ("retries_total", "counter", "Frames sent again.", |it| it.retries as f64),
    ("timeouts_total", "counter", "Answers that did not come.", |it| it.timeouts as f64),
    ("round_trip_seconds", "gauge", "Smoothed round trip.", |it| {
        it.rtt_average.map_or(f64::NAN, |rtt| rtt.as_secs_f64())
    }),
];

/// Figures of the monitors, written where they belong without copies of states.
fn monitors(text: &mut String, all: &[Seen]) {
    // What a monitor with all subsystems takes.
    text.reserve(all.len() * 4096);
    head(text, "monitor_up", "gauge", "The monitor answers.");
    for Seen { id, up, .. } in all {
        _ = writeln!(text, "lafet_monitor_up{{monitor=\"{id}\"}} {}", u8::from(*up));
    }
    for (name, kind, help, figure) in LINK {
        head(text, name, kind, help);
        for (id, stats) in all.iter().filter_map(|it| Some((&it.id, it.stats.as_ref()?))) {
            _ = writeln!(text, "lafet_{name}{{monitor=\"{id}\"}} {}", figure(stats));
        }
    }
    head(text, "status", "gauge", "Fields of GetStatus, in the protocol's units.");
    for Seen { id, status, .. } in all.iter().filter(|it| !it.status.stale) {
        for (subsystem, state) in &status.subsystems {
            for (field, value) in &state.fields {
                let labels = ["monitor=\"", id, "\",subsystem=\"", subsystem, "\",field=\"", field];
                text.push_str("lafet_status{");
                labels.into_iter().for_each(|part| text.push_str(part));
                _ = writeln!(text, "\"}} {value}");
            }
        }
    }
}

/// What a figure is. Writing into a string does not fail.
fn head(text: &mut String, name: &str, kind: &str, help: &str) {
    _ = writeln!(text, "# HELP lafet_{name} {help}\n# TYPE lafet_{name} {kind}");
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use lafet_proto::SubsystemId;

    use super::*;
    use crate::monitor::status::Subsystem;

    /// Processor time that this thread has used.
    fn processor() -> Duration {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
        Duration::from_nanos(text.split_whitespace().next().unwrap().parse().unwrap())
    }

    #[test]
    fn a_thousand_monitors_are_written_in_a_moment() {
        let fields = ["position", "current", "speed"].map(|name| (name, 1234_i64));
        let one = Subsystem { fields: fields.into(), ..Subsystem::default() };
        let names = SubsystemId::KNOWN.iter().take(14).map(|(_, name)| *name);
        let subsystems = names.map(|name| (name, Arc::new(one.clone()))).collect();
        let status = Arc::new(Status { subsystems, ..Status::default() });
        let seen = |id| Seen {
            id: format!("M{id}"),
            up: true,
            stats: Some(Stats::default()),
            status: status.clone(),
        };
        let all: Vec<Seen> = (0..1000).map(seen).collect();
        let (mut text, before) = (String::new(), processor());
        monitors(&mut text, &all);
        let took = processor() - before;
        println!("{} lines, {took:?} of processor", text.lines().count());
        assert_eq!(text.lines().count(), 1000 * (1 + 6 + 14 * 3) + 2 * (1 + 6 + 1));
        // Ten times what a debug build takes.
        assert!(took < Duration::from_millis(200), "{took:?}");
        let line = "lafet_status{monitor=\"M7\",subsystem=\"Vertical\",field=\"speed\"} 1234\n";
        assert!(text.contains(line));
    }
}
