//! Stop, Close and Lockout on: they overtake everything, and so must not crowd anything out.
//!
//! Equal requests to one monitor share their frames. At most one frame is on the line and one batch
//! waits behind it; whoever asks meanwhile joins that batch and gets its result. A request is thus
//! always honoured by a frame that is sent after it has arrived.
//!
//! ```text
//!          first request          answered              rest over, nothing waits
//!  (idle) ──────────────▶ on the line ────────▶ resting ──────────────────────▶ (idle)
//!                             ▲                   │ a batch waits, or a client that is new here
//!                             └───────────────────┘
//! ```
//!
//! The rest is as long as the exchange took: however often Stop is repeated, the line keeps half of
//! its time for everything else.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use serde::Serialize;
use serde_json::{Value, json};
use tokio::sync::{Notify, oneshot, watch};
use tokio::time::{Instant, sleep, timeout};

use crate::access::Standing;
use crate::command::act_of;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::station::Station;
use crate::sync::lock;

/// Shortest and longest rest before an equal request is sent again.
const REST: Duration = Duration::from_millis(20);
const REST_MAX: Duration = Duration::from_millis(250);
/// Clients of a request that are noted by name at the same time; more are counted together.
const CALLERS_MAX: usize = 256;
/// Repetitions are noted this often while they go on.
const REPEATS_NOTED: Duration = Duration::from_secs(10);
/// An answer waits this long for the numbers of its entries, and then goes without.
const NUMBERED: Duration = Duration::from_millis(25);
/// A client learns after this time that a request is sent and not answered yet.
pub const UNANSWERED: Duration = Duration::from_millis(200);

/// The urgent requests to a monitor that are under way, by their text.
#[derive(Debug, Default)]
pub struct Lane(Mutex<BTreeMap<String, Slot>>);

/// A request that is on the line or has been lately.
#[derive(Debug, Default)]
struct Slot {
    waits: Option<Batch>,
    resting: bool,
    wake: Arc<Notify>,
    /// Who has asked since the slot is busy, by session.
    noted: BTreeMap<String, (Caller, Repeats)>,
    /// Those beyond [`CALLERS_MAX`].
    others: Repeats,
}

/// Requests that share a frame.
#[derive(Debug)]
struct Batch {
    outcome: watch::Sender<Option<Arc<Outcome>>>,
    since: Instant,
    /// Clients whose entries this frame gets.
    callers: Vec<Caller>,
}

/// Repetitions, as they are noted in the audit log.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Repeats {
    count: u64,
    first_ms: u64,
    last_ms: u64,
}

/// What a frame of urgent requests has come to.
#[derive(Debug)]
pub struct Outcome {
    result: Result<Value, ApiError>,
    /// The numbers of the audit entries, by session.
    numbers: BTreeMap<String, u64>,
}

/// The result of a request that is under way; it goes on if this is dropped.
#[derive(Debug)]
pub struct Joined {
    outcome: watch::Receiver<Option<Arc<Outcome>>>,
    session: String,
}

impl Repeats {
    fn again(&mut self, now_ms: u64) {
        if self.count == 0 {
            self.first_ms = now_ms;
        }
        (self.count, self.last_ms) = (self.count + 1, now_ms);
    }
}

impl Joined {
    /// The result, once there is one.
    pub async fn result(&mut self) -> Result<Value, ApiError> {
        let closed = || Err(ApiError::from(&lafet_client::Error::Closed));
        let Ok(outcome) = self.outcome.wait_for(Option::is_some).await else { return closed() };
        let Some(outcome) = outcome.as_ref() else { return closed() };
        let number = outcome.numbers.get(&self.session).copied();
        match &outcome.result {
            Ok(value) => {
                let mut value = value.clone();
                value["audit"] = number.into();
                Ok(value)
            }
            Err(error) => Err(error.clone().with("audit", number)),
        }
    }

    /// The result, if it comes within [`UNANSWERED`].
    pub async fn soon(&mut self) -> Option<Result<Value, ApiError>> {
        timeout(UNANSWERED, self.result()).await.ok()
    }
}

impl Hub {
    /// Sends an urgent request, or joins the equal one that waits. It is carried out whether or not
    /// the result is waited for.
    pub fn urgent(&self, caller: &Caller, station: &Arc<Station>, text: &str) -> Joined {
        use std::sync::atomic::Ordering;
        if caller.principal.standing == Standing::Ended && !text.starts_with("Stop ") {
            return self.refused_as_ended(caller, station, text);
        }
        self.counts.commands.fetch_add(1, Ordering::Relaxed);
        let (now_ms, session) = (self.clock.now_ms(), caller.seat.seat.clone());
        let mut slots = lock(&station.urgent.0);
        let busy = slots.contains_key(text);
        let slot = slots.entry(text.to_owned()).or_default();
        let batch = slot.waits.get_or_insert_with(Batch::new);
        let outcome = batch.outcome.subscribe();
        if let Some((_, repeats)) = slot.noted.get_mut(&session) {
            repeats.again(now_ms);
        } else if slot.noted.len() < CALLERS_MAX {
            slot.noted.insert(session.clone(), (caller.clone(), Repeats::default()));
            batch.callers.push(caller.clone());
            if slot.resting {
                slot.wake.notify_one();
            }
        } else {
            slot.others.again(now_ms);
        }
        if !busy {
            tokio::spawn(run(self.clone(), station.clone(), text.to_owned()));
        }
        Joined { outcome, session }
    }
}

impl Hub {
    /// A session that others have ended may stop; what shuts the water of a fire is not its any more.
    fn refused_as_ended(&self, caller: &Caller, station: &Station, text: &str) -> Joined {
        let record = self.record(caller, station.id(), text, "not allowed");
        drop(self.audit.note(record.about(&act_of(text))));
        let outcome = Outcome { result: Err(ApiError::ended()), numbers: BTreeMap::new() };
        let (_, outcome) = watch::channel(Some(Arc::new(outcome)));
        Joined { outcome, session: caller.seat.seat.clone() }
    }
}

impl Lane {
    /// Another request goes to the monitor: the next Stop is no repetition of those before it.
    pub fn other_sent(&self, hub: &Hub, station: &Station) {
        for (text, slot) in lock(&self.0).iter_mut() {
            std::mem::take(slot).renew(hub, station, text, slot);
        }
    }
}

impl Batch {
    fn new() -> Self {
        Self { outcome: watch::Sender::new(None), since: Instant::now(), callers: Vec::new() }
    }
}

/// Sends batches until none waits after a rest.
async fn run(hub: Hub, station: Arc<Station>, text: String) {
    let mut since = Instant::now();
    loop {
        let batch = {
            let mut slots = lock(&station.urgent.0);
            let Some(slot) = slots.get_mut(&text) else { return };
            slot.resting = false;
            match slot.waits.take() {
                Some(batch) => batch,
                None => {
                    if let Some(slot) = slots.remove(&text) {
                        slot.note(&hub, &station, &text);
                    }
                    return;
                }
            }
        };
        let began = Instant::now();
        let Batch { outcome, since: asked, callers } = batch;
        let result = send(&hub, &station, &text, callers, asked).await;
        outcome.send_replace(Some(Arc::new(result)));
        let wake = {
            let mut slots = lock(&station.urgent.0);
            let Some(slot) = slots.get_mut(&text) else { return };
            if since.elapsed() >= REPEATS_NOTED {
                since = Instant::now();
                std::mem::take(slot).renew(&hub, &station, &text, slot);
            }
            // A client that has not asked before does not wait behind one that repeats itself.
            if slot.waits.as_ref().is_some_and(|batch| !batch.callers.is_empty()) {
                continue;
            }
            slot.resting = true;
            slot.wake.clone()
        };
        tokio::select! {
            () = sleep(began.elapsed().clamp(REST, REST_MAX)) => {}
            () = wake.notified() => {}
        }
    }
}

impl Slot {
    /// Notes what was repeated.
    fn note(&self, hub: &Hub, station: &Station, text: &str) {
        let hub_itself = Caller::hub();
        let all = self.noted.values().map(|(caller, repeats)| (caller, repeats));
        for (caller, repeats) in all.chain([(&hub_itself, &self.others)]) {
            if repeats.count > 0 {
                let mut record = hub.record(caller, station.id(), text, "repeated");
                record.details = json!(repeats);
                drop(hub.audit.note(record.about(&act_of(text))));
            }
        }
    }

    /// Notes what was repeated, and leaves in `slot` what still waits.
    fn renew(self, hub: &Hub, station: &Station, text: &str, slot: &mut Self) {
        self.note(hub, station, text);
        (slot.waits, slot.resting, slot.wake) = (self.waits, self.resting, self.wake);
    }
}

/// Sends one frame for all that share it.
async fn send(
    hub: &Hub,
    station: &Arc<Station>,
    text: &str,
    callers: Vec<Caller>,
    since: Instant,
) -> Outcome {
    let note = |caller: &Caller| {
        let record = hub.record(caller, station.id(), text, "asked");
        hub.audit.note(record.about(&act_of(text)))
    };
    let asked: Vec<oneshot::Receiver<u64>> = callers.iter().map(note).collect();
    let sent = hub.send_urgent(station, text, since).await;
    let numbers = if callers.is_empty() {
        BTreeMap::new()
    } else {
        let noting = hub.clone().note_urgent(station.clone(), callers, asked, sent.noted);
        let noting = tokio::spawn(noting);
        let patience = if hub.audit.is_failing() { Duration::ZERO } else { NUMBERED };
        timeout(patience, noting).await.ok().and_then(Result::ok).unwrap_or_default()
    };
    Outcome { result: sent.result, numbers }
}
