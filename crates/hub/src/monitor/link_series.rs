//! The figures of a link, second by second, as series of the history.

use lafet_client::Stats;
use lafet_texts::{Text, hub as text};
use serde::Serialize;
use utoipa::ToSchema;

use crate::hub::Hub;
use crate::monitor::status;
use crate::text::Both;

/// A series of the history.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct SeriesInfo {
    /// Its name, `Vertical.position`.
    pub series: String,
    /// Unit; empty if there is none.
    pub unit: Both,
    /// What the series shows.
    pub text: Both,
}

/// What their names begin with.
pub const PREFIX: &str = "Link.";

type Figure = fn(&Stats) -> Option<f64>;

/// Name, what it counts, and the figure.
const SERIES: [(&str, &(dyn Text + Sync), Figure); 6] = [
    ("sent", &text::FigureSent, |it| Some(it.frames_sent as f64)),
    ("received", &text::FigureReceived, |it| Some(status::received(it) as f64)),
    ("retries", &text::FigureRetries, |it| Some(it.retries as f64)),
    ("timeouts", &text::FigureTimeouts, |it| Some(it.timeouts as f64)),
    ("errors", &text::FigureErrors, |it| Some(it.errors() as f64)),
    ("rtt_ms", &text::FigureRtt, |it| {
        let rtt = it.rtt_average?;
        Some((rtt.as_secs_f64() * 10_000.0).round() / 10.0)
    }),
];

/// How exactly figures of a link are noted: they change each second by amounts that mean nothing.
#[derive(Clone, Copy, Debug)]
pub struct Grain {
    /// Not more often than this,
    pub every_ms: u64,
    /// and only if they differ by more than this.
    pub band: f64,
}

/// The grain of a series at a value; `None`: it is no figure of a link, or one that counts trouble,
/// of which every bit matters.
pub fn grain(series: &str, value: f64) -> Option<Grain> {
    match series.strip_prefix(PREFIX)? {
        "sent" | "received" => Some(Grain { every_ms: 10_000, band: (value * 0.1).max(1.0) }),
        "rtt_ms" => Some(Grain { every_ms: 10_000, band: (value * 0.2).max(0.5) }),
        _ => None,
    }
}

/// Notes the figures of the last second; of a link that is down nothing is known.
pub fn note(hub: &Hub, monitor: &str, last: &Stats, up: bool) {
    let (at_ms, mut history) = (hub.clock().now_ms(), hub.history());
    if !up {
        return history.lost_link(at_ms, monitor);
    }
    for (name, _, figure) in SERIES {
        if let Some(value) = figure(last) {
            history.note(at_ms, monitor, &format!("{PREFIX}{name}"), value);
        }
    }
}

/// The series, as the API lists them.
pub fn list() -> impl Iterator<Item = SeriesInfo> {
    SERIES.iter().map(|(name, what, _)| {
        let unit = if *name == "rtt_ms" { text::FigureMs.words() } else { Both::default() };
        SeriesInfo { series: format!("{PREFIX}{name}"), unit, text: what.words() }
    })
}
