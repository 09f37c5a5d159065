//! A monitor as clients see it, besides its state.

use std::sync::Arc;
use std::time::Duration;

use lafet_client::Stats;
use lafet_proto::status::{Hotbed, Limits};
use serde::Serialize;
use serde_json::value::RawValue;
use utoipa::ToSchema;

use crate::control::authority::Seat;
use crate::control::tuning::TuneView;
use crate::monitor::program::Program;
use crate::monitor::status::{Exchanged, Readiness, Status, received, strays};
use crate::text::Both;
use crate::words::{ControlWord, LinkWord};

/// Id, name and address of a monitor.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Info {
    /// Id from the configuration.
    pub id: String,
    /// Name for people.
    pub name: Both,
    /// Its address on the bus; null: a recording does not have it.
    #[schema(required)]
    pub address: Option<u8>,
}

/// Everything about a monitor: the published values as they are.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct MonitorView {
    /// Id, name and address.
    #[serde(flatten)]
    pub info: Info,
    /// State, as the topic `status`.
    #[schema(value_type = Option<Status>, required)]
    pub status: Option<Arc<RawValue>>,
    /// Link, as the topic `link`.
    #[schema(value_type = Option<Link>, required)]
    pub link: Option<Arc<RawValue>>,
    /// Authority, as the topic `authority`.
    #[schema(value_type = Option<Control>, required)]
    pub authority: Option<Arc<RawValue>>,
    /// Whether it can do its work.
    #[schema(value_type = Option<Readiness>, required)]
    pub readiness: Option<Arc<RawValue>>,
    /// Limits by drive.
    #[schema(value_type = Option<BTreeMap<String, Bounds>>, required)]
    pub limits: Option<Arc<RawValue>>,
    /// What its detector has found.
    #[schema(value_type = Option<Hotbeds>, required)]
    pub hotbeds: Option<Arc<RawValue>>,
    /// What it does by itself.
    #[schema(value_type = Option<Program>, required)]
    pub program: Option<Arc<RawValue>>,
    /// The tuning of a drive that runs, or the last one.
    #[schema(value_type = Option<TuneView>, required)]
    pub tune: Option<Arc<RawValue>>,
    /// Urgent requests so far.
    #[schema(value_type = Option<UrgentCounts>, required)]
    pub urgent: Option<Arc<RawValue>>,
    /// When its parameters were read.
    #[schema(required)]
    pub params_at_ms: Option<u64>,
}

/// How many urgent requests have come for a monitor since the hub was started, from all clients: what is held on a
/// page ends when one of them grows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct UrgentCounts {
    /// Stop, of the monitor or of a part of it.
    pub stop: u64,
    /// Close.
    pub close: u64,
    /// Lockout.
    pub lockout: u64,
}

/// The authority over a monitor.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Control {
    /// Whether it is held.
    pub state: ControlWord,
    /// The client that holds it.
    #[schema(required)]
    pub holder: Option<Holder>,
    /// The client that asks for it.
    #[schema(required)]
    pub request: Option<Asking>,
}

/// The holder of a monitor.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Holder {
    /// The client.
    #[serde(flatten)]
    pub seat: Seat,
    /// When it took the authority, ms since 1970.
    pub since_ms: u64,
}

/// A client that asks for control.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Asking {
    /// The client.
    #[serde(flatten)]
    pub seat: Seat,
    /// It is granted then, unless it is denied before.
    pub until_ms: u64,
}

/// Limits of a drive, arc-minutes; of the nozzle mm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Bounds {
    /// Lower, right or wider limit.
    pub min: i32,
    /// Upper, left or narrower limit.
    pub max: i32,
}

/// What a detector has found.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Hotbeds {
    /// When they were read, ms since 1970.
    pub at_ms: u64,
    /// The fire spots, in the order of the monitor.
    pub list: Vec<Spot>,
}

/// A fire spot, edges in arc-minutes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Spot {
    /// Left edge, arc-minutes.
    pub x1: i32,
    /// Right edge, arc-minutes.
    pub x2: i32,
    /// Lower edge, arc-minutes.
    pub y1: i32,
    /// Upper edge, arc-minutes.
    pub y2: i32,
    /// Brightness.
    pub brightness: i32,
}

/// A link and its figures.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Link {
    /// Whether there is a connection.
    pub state: LinkWord,
    /// When the link came up or went down, ms since 1970.
    pub since_ms: u64,
    /// Why it is down.
    #[schema(required)]
    pub error: Option<Both>,
    /// URL of the link.
    pub endpoint: String,
    /// The state is asked for this often.
    pub poll_ms: u64,
    /// Frames sent since the start.
    pub sent: u64,
    /// Frames that came from the monitor.
    pub received: u64,
    /// Frames received with errors.
    pub errors: u64,
    /// Frames sent again.
    pub retries: u64,
    /// Answers that did not come in time.
    pub timeouts: u64,
    /// Answers that came too late.
    pub late: u64,
    /// Frames from the monitor that answer nothing that is outstanding.
    pub strays: u64,
    /// Collisions on a line with two wires.
    pub collisions: u64,
    /// Number of reconnections.
    pub reconnects: u64,
    /// The last round trip, ms.
    #[schema(required)]
    pub rtt_ms: Option<f64>,
    /// The smoothed round trip, ms.
    #[schema(required)]
    pub srtt_ms: Option<f64>,
    /// Exchanges without answer, of a thousand.
    pub loss_permille: u32,
    /// Figures of the last second.
    pub last: Second,
    /// The line that it shares with other monitors.
    pub line: Line,
    /// The line in the last second.
    pub line_last: Line,
}

/// A link in the last second.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
pub struct Second {
    /// Frames sent.
    pub sent: u64,
    /// Frames that came from the monitor.
    pub received: u64,
    /// Frames received with errors.
    pub errors: u64,
    /// Frames sent again.
    pub retries: u64,
    /// Answers that did not come in time.
    pub timeouts: u64,
    /// Exchanges without answer, of a thousand.
    pub loss_permille: u32,
}

/// Figures of a line.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
pub struct Line {
    /// Frames sent.
    pub sent: u64,
    /// Frames received.
    pub received: u64,
    /// Frames received with errors.
    pub errors: u64,
    /// Frames between other nodes.
    pub foreign: u64,
    /// Collisions heard.
    pub collisions: u64,
}

/// How a link is, besides its figures.
#[derive(Clone, Debug)]
pub struct LinkState {
    /// Whether there is a connection.
    pub up: bool,
    /// When the link came up or went down, ms since 1970.
    pub since_ms: u64,
    /// Why the link is down.
    pub error: Option<Both>,
    /// URL of the link.
    pub endpoint: String,
    /// The state is asked for this often.
    pub poll_ms: u64,
}

impl Link {
    /// A link with the figures since the start and those of the last second.
    pub fn new(state: LinkState, all: &Exchanged, last: &Exchanged) -> Self {
        let own = &all.own;
        Self {
            state: if state.up { LinkWord::Up } else { LinkWord::Down },
            since_ms: state.since_ms,
            error: state.error,
            endpoint: state.endpoint,
            poll_ms: state.poll_ms,
            sent: own.frames_sent,
            received: received(own),
            errors: own.errors(),
            retries: own.retries,
            timeouts: own.timeouts,
            late: own.late,
            strays: strays(own),
            collisions: own.collisions,
            reconnects: own.reconnects,
            rtt_ms: own.rtt_last.map(tenths),
            srtt_ms: own.rtt_average.map(tenths),
            loss_permille: own.loss_permille(),
            last: Second::from(&last.own),
            line: Line::from(&all.line),
            line_last: Line::from(&last.line),
        }
    }
}

/// In ms, to a tenth.
fn tenths(time: Duration) -> f64 {
    (time.as_secs_f64() * 10_000.0).round() / 10.0
}

impl From<&Stats> for Second {
    fn from(it: &Stats) -> Self {
        Self {
            sent: it.frames_sent,
            received: received(it),
            errors: it.errors(),
            retries: it.retries,
            timeouts: it.timeouts,
            loss_permille: it.loss_permille(),
        }
    }
}

impl From<&Stats> for Line {
    fn from(it: &Stats) -> Self {
        Self {
            sent: it.frames_sent,
            received: it.frames_received,
            errors: it.errors(),
            foreign: it.foreign,
            collisions: it.collisions,
        }
    }
}

impl From<Limits> for Bounds {
    fn from(Limits { min, max }: Limits) -> Self {
        Self { min, max }
    }
}

impl Hotbeds {
    /// What was read at this time.
    pub fn new(at_ms: u64, hotbeds: &[Hotbed]) -> Self {
        let spot = |it: &Hotbed| {
            let Hotbed { x1, x2, y1, y2, brightness } = *it;
            Spot { x1, x2, y1, y2, brightness }
        };
        Self { at_ms, list: hotbeds.iter().map(spot).collect() }
    }
}
