//! The history as what the topics of the WebSocket were.

use std::collections::BTreeMap;
use std::mem::take;
use std::sync::Arc;

use axum::extract::{Query, State};
use axum::response::Response;
use lafet_proto::RequestId;
use lafet_proto::SubsystemId;
use lafet_proto::dictionary::layouts::{Kind, of_answer};
use lafet_texts::{Text as _, hub as text};
use serde::Deserialize;
use tokio::sync::mpsc;
use tokio::task::yield_now;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::not_understood;
use super::recordings::{LINES_MAX, lines_of, names, whose};
use super::records::{Asked, between};
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::link_series::PREFIX;
use crate::monitor::status::Status;
use crate::recording::player::Player;
use crate::store::{Base, Change, StoreError};

/// Longest range, and how much of it is read at a time.
const RANGE_MS: u64 = 24 * 3_600_000;
const PART_MS: u64 = 600_000;
/// Lines are sent when they are so long together.
const CHUNK_BYTES: usize = 64 * 1024;
/// Range without `from_ms`, ms.
const USUAL_MS: u64 = 600_000;

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new().routes(routes!(history_changes))
}

/// Part of the history to return.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Part {
    monitor: Option<String>,
    from_ms: Option<u64>,
    to_ms: Option<u64>,
}

/// The history as topics.
#[utoipa::path(get, path = "/api/history/changes", params(Part),
    responses((status = 200, content_type = "application/x-ndjson"), (status = 400), (status = 401), (status = 404), (status = 503)))]
async fn history_changes(
    State(hub): State<Hub>,
    _: Caller,
    part: Asked<Part>,
) -> Result<Response, ApiError> {
    let Query(part) = part.map_err(|error| not_understood(&error))?;
    let to_ms = part.to_ms.unwrap_or_else(|| hub.clock().now_ms());
    let from_ms = part.from_ms.unwrap_or_else(|| to_ms.saturating_sub(USUAL_MS));
    let (from_ms, to_ms) = between(Some(from_ms), Some(to_ms))?;
    if to_ms - from_ms > RANGE_MS {
        return Err(ApiError::bad_request(text::PastTooLong.words()));
    }
    let addresses = whose(&hub);
    let monitors: Vec<String> = match part.monitor {
        Some(id) => vec![hub.station(&id)?.id().to_owned()],
        None => hub.stations().iter().map(|it| it.id().to_owned()).collect(),
    };
    let stored = hub.history().flushed();
    let base = stored.await;
    let mut player = Player::new(addresses.clone(), names(&hub));
    player.values_hold = true;
    let mut past = Past {
        player,
        addresses: addresses.into_iter().map(|(address, id)| (id, address)).collect(),
        states: BTreeMap::new(),
        base,
        monitors,
    };
    // An error of the storage is reported by the HTTP status, not in the middle of the lines.
    past.begin(from_ms).await?;
    let (to, lines) = mpsc::channel(4);
    tokio::spawn(async move { past.play(from_ms, to_ms, to).await });
    Ok(lines_of(lines))
}

struct Past {
    player: Player,
    addresses: BTreeMap<String, u8>,
    /// The states as they are, by monitor.
    states: BTreeMap<String, Status>,
    base: Base,
    monitors: Vec<String>,
}

impl Past {
    /// What held at the beginning.
    async fn begin(&mut self, from_ms: u64) -> Result<(), StoreError> {
        for monitor in self.monitors.clone() {
            let mut held = self.base.changes(&monitor, (from_ms, from_ms), true).await?;
            held.retain(|(series, ..)| !series.starts_with(PREFIX));
            let last_ms = held.iter().map(|(_, t, _)| *t).max();
            let status = self.states.entry(monitor.clone()).or_default();
            held.iter().for_each(|change| apply(status, change));
            if last_ms.is_some() {
                status.at_ms = Some(from_ms);
                let status = status.clone();
                let address = self.addresses.get(&monitor).copied();
                self.player.status(from_ms, &monitor, address, status);
            }
        }
        Ok(())
    }

    async fn play(
        mut self,
        from_ms: u64,
        to_ms: u64,
        to: mpsc::Sender<Result<String, std::io::Error>>,
    ) {
        let mut chunk = self.player.everything(from_ms);
        let (mut part_ms, mut count) = (from_ms, 0);
        while part_ms < to_ms && count < LINES_MAX && !to.is_closed() {
            let end_ms = to_ms.min(part_ms + PART_MS);
            let mut all: Vec<(u64, usize, Change)> = Vec::new();
            for (index, monitor) in self.monitors.iter().enumerate() {
                match self.base.changes(monitor, (part_ms, end_ms), false).await {
                    Ok(changes) => all.extend(changes.into_iter().map(|it| (it.1, index, it))),
                    Err(error) => {
                        _ = to.send(Err(std::io::Error::other(error))).await;
                        return;
                    }
                }
            }
            all.retain(|(.., (series, ..))| !series.starts_with(PREFIX));
            all.sort_by_key(|(at_ms, index, _)| (*at_ms, *index));
            let groups = all.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
            for group in groups {
                if count >= LINES_MAX || to.is_closed() {
                    break;
                }
                if let Some(line) = self.moment(group) {
                    chunk += &line;
                    count += 1;
                }
                if chunk.len() >= CHUNK_BYTES && to.send(Ok(take(&mut chunk))).await.is_err() {
                    return;
                }
                // A part of a large site takes seconds of the processor.
                yield_now().await;
            }
            part_ms = end_ms;
            if to.send(Ok(take(&mut chunk))).await.is_err() {
                return;
            }
        }
        chunk += &self.player.take().unwrap_or_default();
        _ = to.send(Ok(chunk)).await;
    }

    /// What changed of a monitor at once; the line before it, if it is complete.
    fn moment(&mut self, group: &[(u64, usize, Change)]) -> Option<String> {
        let (at_ms, index, _) = group.first()?;
        let monitor = self.monitors.get(*index)?.clone();
        let line = self.player.time(*at_ms);
        let status = self.states.entry(monitor.clone()).or_default();
        (status.stale, status.at_ms) = (false, Some(*at_ms));
        group.iter().for_each(|(.., change)| apply(status, change));
        let status = status.clone();
        let address = self.addresses.get(&monitor).copied();
        self.player.status(*at_ms, &monitor, address, status);
        line
    }
}

/// Puts a value into a state. A status word that is not known makes it stale, a field is left out.
fn apply(status: &mut Status, (series, _, value): &Change) {
    let Some((name, field)) = series.split_once('.') else { return };
    let Some(id) = SubsystemId::from_name(name) else { return };
    let Some(name) = id.name() else { return };
    let state = status.subsystems.entry(name).or_default();
    let state = Arc::make_mut(state);
    let value = match (field, value) {
        ("bits", Some(bits)) => return state.set_bits(id, *bits as u32),
        ("bits", None) => return status.stale = true,
        (_, Some(value)) => value,
        // Its sensor was faulty.
        (_, None) => {
            state.fields.remove(field);
            return;
        }
    };
    let fields = of_answer(RequestId::GET_STATUS, id).iter().flat_map(|layout| layout.fields);
    let mut known = fields.filter(|it| it.kind != Kind::Flags);
    if let Some(known) = known.find(|it| it.name == field) {
        state.fields.insert(known.name, *value as i64);
    }
}
