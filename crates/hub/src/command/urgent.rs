//! Stop, Close and Lockout on: they overtake everything, and so must not crowd anything out.
//!
//! Equal requests to one monitor share their frames. At most one frame is on the line and one batch
//! waits behind it; a client that asks meanwhile joins that batch and gets its result. A request is thus
//! always honoured by a frame that is sent after it has arrived.
//!
//! ```text
//!          first request          answered              rest over, nothing waits
//!  (idle) ──────────────▶ on the line ────────▶ resting ──────────────────────▶ (idle)
//!                             ▲                   │ a batch waits, or a user that is new here
//!                             └───────────────────┘
//! ```
//!
//! The rest is as long as the exchange took, and longer while other kinds of requests are repeated too: however
//! often Stop, Close and Lockout are, the line keeps half of its time for everything else. A user or token that is
//! new here ends the rest; another connection of one that is not does not.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_client::RequestBuf;
use lafet_proto::RequestId;
use serde::Serialize;
use tokio::sync::{Notify, oneshot, watch};
use tokio::time::{Instant, sleep, timeout};

use crate::access::Standing;
use crate::command::outcome::Outcome;
use crate::command::request::MonitorRequest;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::sync::lock;

/// Shortest and longest rest before an equal request is sent again.
const REST: Duration = Duration::from_millis(20);
const REST_MAX: Duration = Duration::from_millis(250);
/// Clients of a request that are noted by name at the same time; more are counted together.
pub(super) const CALLERS_MAX: usize = 256;
/// Repetitions are noted this often while they go on.
pub const REPEATS_NOTED: Duration = Duration::from_secs(10);
/// An answer waits this long for the numbers of its entries, and then goes without.
const NUMBERED: Duration = Duration::from_millis(25);
/// A client learns after this time that a request is sent and not answered yet.
pub const UNANSWERED: Duration = Duration::from_millis(200);

/// The urgent requests to a monitor that are under way.
#[derive(Debug, Default)]
pub struct Lane(Mutex<BTreeMap<RequestBuf, Slot>>);

/// A request that is on the line or has been lately.
#[derive(Debug)]
struct Slot {
    request: MonitorRequest,
    waits: Option<Batch>,
    resting: bool,
    wake: Arc<Notify>,
    /// Who has asked since the slot is busy, by session.
    noted: BTreeMap<String, (Caller, Repeats)>,
    /// Sessions of users, and tokens, that have asked.
    users: BTreeSet<String>,
    /// Repetitions of clients beyond [`CALLERS_MAX`].
    others: Repeats,
}

/// Requests that share a frame.
#[derive(Debug)]
struct Batch {
    outcome: watch::Sender<Option<Arc<Shared>>>,
    since: Instant,
    /// A user is among them that is new here.
    new_user: bool,
    /// Clients whose entries this frame gets.
    callers: Vec<Caller>,
}

/// How an urgent request was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Taken {
    /// Not at all: the session was ended by others.
    Refused,
    /// Its client has sent the same while that is under way.
    Again,
    /// It is the client's first.
    First,
}

/// Repetitions, as they are noted in the audit log.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Repeats {
    pub(super) count: u64,
    first_ms: u64,
    last_ms: u64,
}

/// What a frame of urgent requests has come to.
#[derive(Debug)]
struct Shared {
    result: Result<Outcome, ApiError>,
    /// The result as the audit log has it.
    word: String,
    /// The numbers of the audit entries, by session.
    numbers: BTreeMap<String, u64>,
}

/// The result of a request that is under way; it goes on if this is dropped.
#[derive(Clone, Debug)]
pub struct Joined {
    outcome: watch::Receiver<Option<Arc<Shared>>>,
    entry: Entry,
}

/// Where the number of the audit entry of a request comes from.
#[derive(Clone, Debug)]
pub(super) enum Entry {
    /// The entry of a session for one monitor.
    Session(String),
    /// The entry of a request to every monitor; `None` of a repetition.
    Everywhere(Option<watch::Receiver<Option<u64>>>),
}

impl Repeats {
    pub(super) fn again(&mut self, now_ms: u64) {
        if self.count == 0 {
            self.first_ms = now_ms;
        }
        (self.count, self.last_ms) = (self.count + 1, now_ms);
    }
}

impl Joined {
    /// The result, once there is one.
    pub async fn result(&mut self) -> Result<Outcome, ApiError> {
        let closed = || Err(ApiError::from(&lafet_client::Error::Closed));
        let Some(outcome) = self.shared().await else { return closed() };
        let number = match &mut self.entry {
            Entry::Session(session) => outcome.numbers.get(session).copied(),
            Entry::Everywhere(None) => None,
            Entry::Everywhere(Some(number)) => {
                let number = timeout(NUMBERED, number.wait_for(Option::is_some)).await;
                number.ok().and_then(Result::ok).and_then(|it| *it)
            }
        };
        match &outcome.result {
            Ok(outcome) => Ok(Outcome { audit: number, ..outcome.clone() }),
            Err(error) => Err(error.clone().noted(number)),
        }
    }

    /// The result as the audit log has it.
    pub(super) async fn word(&mut self) -> String {
        match self.shared().await {
            Some(outcome) => outcome.word.clone(),
            None => ApiError::from(&lafet_client::Error::Closed).code.to_owned(),
        }
    }

    async fn shared(&mut self) -> Option<Arc<Shared>> {
        self.outcome.wait_for(Option::is_some).await.ok()?.clone()
    }

    /// What a session gets that others have ended.
    pub(super) fn refused_as_ended() -> Self {
        let error = ApiError::ended();
        let word = error.code.to_owned();
        let outcome = Shared { result: Err(error), word, numbers: BTreeMap::new() };
        let (_, outcome) = watch::channel(Some(Arc::new(outcome)));
        Self { outcome, entry: Entry::Everywhere(None) }
    }

    /// The result, if it comes within [`UNANSWERED`].
    pub async fn soon(&mut self) -> Option<Result<Outcome, ApiError>> {
        timeout(UNANSWERED, self.result()).await.ok()
    }
}

impl Hub {
    /// Sends an urgent request, or joins the equal one that waits. It is carried out whether or not
    /// the result is waited for, and is a no for the zones of the monitor.
    pub fn urgent(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        request: &MonitorRequest,
    ) -> Joined {
        let (joined, taken) = self.overtake(caller, station, request);
        if taken != Taken::Refused {
            self.refuse_for_zones(caller, station, request, taken == Taken::First);
        }
        joined
    }

    /// The same for the wire alone.
    pub fn overtake(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        request: &MonitorRequest,
    ) -> (Joined, Taken) {
        if may_not(caller, request) {
            return (self.refused_as_ended(caller, station, request), Taken::Refused);
        }
        self.join(caller, station, request, Entry::Session(caller.seat.seat.clone()))
    }

    /// Puts an urgent request into the batch that waits, or into a new one.
    pub(super) fn join(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        request: &MonitorRequest,
        entry: Entry,
    ) -> (Joined, Taken) {
        station.withdraw(request);
        station.publish_urgent(self);
        station.interrupt_tuning(caller);
        self.counts().commands.fetch_add(1, Ordering::Relaxed);
        let now_ms = self.clock().now_ms();
        let mut slots = lock(&station.urgent.0);
        let busy = slots.contains_key(request.buf());
        let slot = slots.entry(request.buf().clone()).or_insert_with(|| Slot::new(request.clone()));
        let batch = slot.waits.get_or_insert_with(Batch::new);
        let outcome = batch.outcome.subscribe();
        let users = &mut slot.users;
        if users.len() < CALLERS_MAX && users.insert(caller.principal.key.clone()) {
            batch.new_user = true;
            if slot.resting {
                slot.wake.notify_one();
            }
        }
        let taken = match &entry {
            Entry::Session(session) => slot.count(caller, session, now_ms),
            Entry::Everywhere(Some(_)) => Taken::First,
            Entry::Everywhere(None) => Taken::Again,
        };
        if !busy {
            tokio::spawn(run(self.clone(), station.clone(), request.clone()));
        }
        (Joined { outcome, entry }, taken)
    }

    /// Another request goes to a monitor: the next Stop is no repetition of those before it.
    pub fn other_sent(&self, station: &Station) {
        lock(&station.urgent.0).values_mut().for_each(|slot| slot.renew(self, station));
        self.urgent_series().end(self);
    }

    /// Sends an urgent request once more, without an entry of its own: its first one was noted.
    pub fn overtake_again(&self, station: &Arc<Station>, request: &MonitorRequest) -> Joined {
        station.withdraw(request);
        self.send_again(station, request)
    }

    /// The same, as long as it is to be repeated: that is asked in the moment in which it is sent.
    pub fn overtake_while(
        &self,
        station: &Arc<Station>,
        request: &MonitorRequest,
        goes_on: impl FnOnce() -> bool,
    ) -> Option<Joined> {
        station.withdraw_if(request, goes_on).then(|| self.send_again(station, request))
    }

    fn send_again(&self, station: &Arc<Station>, request: &MonitorRequest) -> Joined {
        station.interrupt_tuning(&Caller::hub());
        let mut slots = lock(&station.urgent.0);
        let busy = slots.contains_key(request.buf());
        let slot = slots.entry(request.buf().clone()).or_insert_with(|| Slot::new(request.clone()));
        let outcome = slot.waits.get_or_insert_with(Batch::new).outcome.subscribe();
        if !busy {
            tokio::spawn(run(self.clone(), station.clone(), request.clone()));
        }
        Joined { outcome, entry: Entry::Everywhere(None) }
    }
}

/// A session that others have ended may stop; what shuts the water of a fire is not its any more.
pub(super) fn may_not(caller: &Caller, request: &MonitorRequest) -> bool {
    caller.principal.standing == Standing::Ended && request.id() != RequestId::STOP
}

impl Hub {
    fn refused_as_ended(
        &self,
        caller: &Caller,
        station: &Station,
        request: &MonitorRequest,
    ) -> Joined {
        let record = self.record(caller, station.id(), request.text(), "not allowed");
        drop(self.audit().note(record.about(&request.act())));
        Joined::refused_as_ended()
    }
}

impl Batch {
    fn new() -> Self {
        let outcome = watch::Sender::new(None);
        Self { outcome, since: Instant::now(), new_user: false, callers: Vec::new() }
    }
}

/// Sends batches until none waits after a rest.
async fn run(hub: Hub, station: Arc<Station>, request: MonitorRequest) {
    let mut since = Instant::now();
    loop {
        let batch = {
            let mut slots = lock(&station.urgent.0);
            let Some(slot) = slots.get_mut(request.buf()) else { return };
            slot.resting = false;
            match slot.waits.take() {
                Some(batch) => batch,
                None => {
                    if let Some(slot) = slots.remove(request.buf()) {
                        slot.note(&hub, &station);
                    }
                    return;
                }
            }
        };
        let began = Instant::now();
        let Batch { outcome, since: asked, callers, .. } = batch;
        let result = send(&hub, &station, &request, callers, asked).await;
        outcome.send_replace(Some(Arc::new(result)));
        let (wake, rest) = {
            let mut slots = lock(&station.urgent.0);
            // Those of other kinds have the line meanwhile.
            let kinds = u32::try_from(slots.len()).unwrap_or(u32::MAX);
            let share = kinds.saturating_mul(2).saturating_sub(1);
            let Some(slot) = slots.get_mut(request.buf()) else { return };
            if since.elapsed() >= REPEATS_NOTED {
                since = Instant::now();
                slot.renew(&hub, &station);
            }
            // A user who has not asked before does not wait behind one who repeats the same.
            if slot.waits.as_ref().is_some_and(|batch| batch.new_user) {
                continue;
            }
            slot.resting = true;
            let rest = began.elapsed().saturating_mul(share).clamp(REST, REST_MAX);
            (slot.wake.clone(), rest)
        };
        tokio::select! {
            () = sleep(rest) => {}
            () = wake.notified() => {}
        }
    }
}

impl Slot {
    fn new(request: MonitorRequest) -> Self {
        Self {
            request,
            waits: None,
            resting: false,
            wake: Arc::default(),
            noted: BTreeMap::new(),
            users: BTreeSet::new(),
            others: Repeats::default(),
        }
    }

    /// Counts a request of a session, whose first one gets an entry.
    fn count(&mut self, caller: &Caller, session: &str, now_ms: u64) -> Taken {
        if let Some((_, repeats)) = self.noted.get_mut(session) {
            repeats.again(now_ms);
            return Taken::Again;
        }
        if self.noted.len() >= CALLERS_MAX {
            self.others.again(now_ms);
            return Taken::Again;
        }
        self.noted.insert(session.to_owned(), (caller.clone(), Repeats::default()));
        self.waits.get_or_insert_with(Batch::new).callers.push(caller.clone());
        Taken::First
    }

    /// Writes the repetitions into the audit log.
    fn note(&self, hub: &Hub, station: &Station) {
        let hub_itself = Caller::hub();
        let all = self.noted.values().map(|(caller, repeats)| (caller, repeats));
        for (caller, repeats) in all.chain([(&hub_itself, &self.others)]) {
            if repeats.count > 0 {
                let record = hub.record(caller, station.id(), self.request.text(), "repeated");
                drop(hub.audit().note(record.with(repeats).about(&self.request.act())));
            }
        }
    }

    /// Notes what was repeated, and counts from here; what waits still waits.
    fn renew(&mut self, hub: &Hub, station: &Station) {
        self.note(hub, station);
        self.noted.clear();
        self.users.clear();
        self.others = Repeats::default();
    }
}

/// Sends one frame for all that share it.
async fn send(
    hub: &Hub,
    station: &Arc<Station>,
    request: &MonitorRequest,
    callers: Vec<Caller>,
    since: Instant,
) -> Shared {
    let note = |caller: &Caller| {
        let record = hub.record(caller, station.id(), request.text(), "asked");
        hub.audit().note(record.about(&request.act()))
    };
    let asked: Vec<oneshot::Receiver<u64>> = callers.iter().map(note).collect();
    let sent = hub.send_urgent(station, request.clone(), since).await;
    let word = sent.noted.outcome().to_owned();
    let numbers = if callers.is_empty() {
        BTreeMap::new()
    } else {
        let noting = hub.clone().note_urgent(station.clone(), callers, asked, sent.noted);
        let noting = tokio::spawn(noting);
        let patience = if hub.audit().is_failing() { Duration::ZERO } else { NUMBERED };
        timeout(patience, noting).await.ok().and_then(Result::ok).unwrap_or_default()
    };
    Shared { result: sent.result, word, numbers }
}
