//! Stop and Lockout of every monitor: one entry when it is asked for, one for all answers, one for what came of it,
//! however many monitors there are.

use std::collections::BTreeMap;
use std::sync::Arc;

use futures_util::future::join_all;
use serde::Serialize;
use tokio::sync::{oneshot, watch};
use tokio::time::Instant;

use super::millis;
use super::outcome::{OfAll, OfOne};
use super::request::MonitorRequest;
use super::series::Said;
use super::urgent::{Entry, Joined, may_not};
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::store::Record;

/// Every monitor, in an entry of the audit log.
pub const EVERY_MONITOR: &str = "*";
/// Details of the entry of the answers.
#[derive(Debug, Serialize)]
struct Answered {
    asked: Option<u64>,
    took_ms: u64,
    /// The monitors by their results.
    monitors: BTreeMap<String, Vec<String>>,
}

/// Details of the entry of what came of it.
#[derive(Debug, Serialize)]
struct Effect {
    answered: Option<u64>,
    /// The monitors with water, or that may have it.
    flowing: Vec<String>,
    /// The monitors that move.
    moving: Vec<String>,
    /// The monitors of which nothing new is known.
    silent: Vec<String>,
}

impl Hub {
    /// The same urgent request to every monitor at the same time, with what is known of each soon
    /// after: the worst one does not keep back what the others have answered.
    pub async fn everywhere(&self, caller: &Caller, request: &MonitorRequest) -> OfAll {
        let all = self.overtake_everywhere(caller, request);
        let each = all
            .into_iter()
            .map(async |(monitor, mut joined)| (monitor, OfOne::new(joined.soon().await)));
        join_all(each).await.into_iter().collect()
    }

    /// An urgent request to every monitor; then it is a no for all zones.
    pub fn overtake_everywhere(
        &self,
        caller: &Caller,
        request: &MonitorRequest,
    ) -> Vec<(String, Joined)> {
        let stations = self.stations();
        let named = |joined: Joined, station: &Arc<Station>| (station.id().to_owned(), joined);
        if stations.is_empty() {
            return Vec::new();
        }
        if may_not(caller, request) {
            drop(self.audit().note(self.record_everywhere(caller, request, "not allowed")));
            return stations.iter().map(|it| named(Joined::refused_as_ended(), it)).collect();
        }
        let said = Said::Request(request.buf().clone());
        let noted = |by: &Caller| self.record_everywhere(by, request, "repeated");
        let first = self.urgent_series().take(self, caller, said, noted);
        let (number, numbered) = watch::channel(None);
        let asked = || self.audit().note(self.record_everywhere(caller, request, "asked"));
        let asked = first.then(asked);
        let entry = Entry::Everywhere(first.then_some(numbered));
        let join = |station| named(self.join(caller, station, request, entry.clone()).0, station);
        let all: Vec<(String, Joined)> = stations.iter().map(join).collect();
        if let Some(asked) = asked {
            let (hub, caller, request) = (self.clone(), caller.clone(), request.clone());
            tokio::spawn(hub.note_all(caller, request, (asked, number), all.clone()));
        }
        self.refuse_everywhere(caller, first);
        all
    }

    /// Notes how all have answered, and later what came of it.
    async fn note_all(
        self,
        caller: Caller,
        request: MonitorRequest,
        (asked, number): (oneshot::Receiver<u64>, watch::Sender<Option<u64>>),
        all: Vec<(String, Joined)>,
    ) {
        let began = Instant::now();
        let asked = self.number_of(asked).await;
        number.send_replace(asked);
        drop(number);
        let each = all.into_iter().map(async |(id, mut joined)| (joined.word().await, id));
        let mut monitors = BTreeMap::<String, Vec<String>>::new();
        for (word, id) in join_all(each).await {
            monitors.entry(word).or_default().push(id);
        }
        let worst = monitors.keys().max_by_key(|word| badness(word)).cloned().unwrap_or_default();
        let details = Answered { asked, took_ms: millis(began.elapsed()), monitors };
        let record = self.record_everywhere(&caller, &request, &worst).with(&details);
        let answered = self.number_of(self.audit().note(record)).await;
        self.effect_is_due().await;
        let record = self.record_everywhere(&caller, &request, "effect");
        drop(self.audit().note(record.with(&self.effect_everywhere(answered))));
    }

    fn effect_everywhere(&self, answered: Option<u64>) -> Effect {
        let (mut flowing, mut moving, mut silent) = (Vec::new(), Vec::new(), Vec::new());
        for station in self.stations() {
            let (status, id) = (station.status(), station.id().to_owned());
            if status.stale || status.at_ms.is_none() {
                silent.push(id);
                continue;
            }
            if status.flows() {
                flowing.push(id.clone());
            }
            if status.moves() {
                moving.push(id);
            }
        }
        Effect { answered, flowing, moving, silent }
    }

    fn record_everywhere(
        &self,
        caller: &Caller,
        request: &MonitorRequest,
        outcome: &str,
    ) -> Record {
        self.record(caller, EVERY_MONITOR, request.text(), outcome).about(&request.act())
    }
}

/// The greater, the more it has to be known: no answer, a refusal, Denied (locked out already, §3.18/2), success.
fn badness(word: &str) -> u8 {
    match word {
        "Ok" | "Accepted" | "Cached" => 0,
        "Denied" => 1,
        _ if word.starts_with(char::is_uppercase) => 2,
        _ => 3,
    }
}
