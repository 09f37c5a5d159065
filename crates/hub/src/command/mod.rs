//! A client's request to a monitor: permission, audit log, answer.

pub mod everywhere;
pub mod keep_out;
pub mod outcome;
pub mod request;
pub mod series;
pub mod under_way;
pub mod urgent;
pub mod withdrawn;

use std::collections::BTreeMap;
use std::future::{Future, poll_fn};
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::task::Poll;
use std::time::Duration;

use lafet_client::{Answers, Error, Monitor, MonitorStatus, Saved};
use lafet_proto::{RequestId, Status, SubsystemId};
use lafet_texts::{Text as _, hub as text};
use serde::Serialize;
use tokio::sync::oneshot;
use tokio::time::{Instant, sleep, timeout};

use crate::access::Role;
use crate::command::outcome::{Outcome, answer_text};
use crate::command::request::MonitorRequest;
use crate::command::withdrawn::Accepted;
use crate::control::tuning::TUNE;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::owner::read_ahead;
use crate::monitor::program;
use crate::monitor::station::Station;
use crate::monitor::status::Subsystem;
use crate::monitor::stored::may_change;
use crate::plugs::is_plug;
use crate::sync::lock;

/// Longest wait for what a stored program sweeps: it is judged without it then.
const AHEAD: Duration = Duration::from_secs(1);
/// Longest wait of a command for its entry to be on the disk; then it goes first.
const NOTED: Duration = Duration::from_millis(50);
/// Longest wait of an answer for the number of its entry.
pub const NUMBERED: Duration = Duration::from_millis(500);
/// Longest wait of a refusal for the state that explains it.
const EXPLAINED: Duration = Duration::from_millis(500);
/// Time from the answer to the look at the effect of a command.
const EFFECT: Duration = Duration::from_secs(2);

impl Hub {
    /// Sends a request to a monitor. It is carried through even if the client does not wait any
    /// more.
    pub async fn command(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        request: MonitorRequest,
        confirm: Option<&str>,
    ) -> Result<Outcome, ApiError> {
        let terms = Terms::of(station, &request);
        self.send(caller, station, request, confirm, terms).await
    }

    /// The same for a request that was read earlier; `save`: as [`Hub::save`].
    pub async fn command_accepted(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        request: MonitorRequest,
        (confirm, save): (Option<&str>, bool),
        accepted: Accepted,
    ) -> Result<Outcome, ApiError> {
        only_parameters(&request, save)?;
        let terms = Terms { save, valid: None, accepted };
        self.send(caller, station, request, confirm, terms).await
    }

    /// The same; right before it is sent `valid` is asked whether it still is to be.
    pub async fn command_while(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        request: MonitorRequest,
        valid: Arc<dyn Fn() -> bool + Send + Sync>,
    ) -> Result<Outcome, ApiError> {
        let terms = Terms { valid: Some(valid), ..Terms::of(station, &request) };
        self.send(caller, station, request, None, terms).await
    }

    /// Sets a parameter, and waits until it is stored.
    pub async fn save(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        request: MonitorRequest,
    ) -> Result<Outcome, ApiError> {
        only_parameters(&request, true)?;
        let terms = Terms { save: true, ..Terms::of(station, &request) };
        self.send(caller, station, request, None, terms).await
    }

    async fn send(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        request: MonitorRequest,
        confirm: Option<&str>,
        terms: Terms,
    ) -> Result<Outcome, ApiError> {
        let began = Instant::now();
        if request.need().urgent {
            return self.urgent(caller, station, &request).result().await;
        }
        if let Err(error) = self.allow(caller, station, &request, confirm) {
            self.counts().refused.fetch_add(1, Ordering::Relaxed);
            // A program that has gone wild must not fill the disk with what was not done.
            if error.status != axum::http::StatusCode::TOO_MANY_REQUESTS {
                let record = self.record(caller, station.id(), request.text(), "not allowed");
                let record = record.with(&NotAllowed { code: error.code });
                drop(self.audit().note(record.about(&request.act())));
            }
            return Err(error);
        }
        self.counts().commands.fetch_add(1, Ordering::Relaxed);
        let (hub, caller, station) = (self.clone(), caller.clone(), station.clone());
        let run =
            tokio::spawn(
                async move { hub.carry_out(&caller, &station, request, terms, began).await },
            );
        run.await.unwrap_or_else(|_| Err(ApiError::from(&lafet_client::Error::Closed)))
    }

    /// Why the client may not do this.
    fn allow(
        &self,
        caller: &Caller,
        station: &Station,
        request: &MonitorRequest,
        confirm: Option<&str>,
    ) -> Result<(), ApiError> {
        if caller.via == "hub" {
            return Ok(());
        }
        let needs = request.need();
        let principal = &caller.principal;
        self.count_request(principal)?;
        if principal.role < needs.role || !principal.is_good() {
            return Err(ApiError::role(needs.role));
        }
        if needs.authority {
            station.refuse_while_updated(caller)?;
            let mut authority = lock(&station.authority);
            // What the hub sends for a client does not keep it from being lost.
            let present = authority.is_present(&caller.seat.seat);
            let tuned = caller.via == TUNE && present;
            // A command of a plug whose sign of life was lost meanwhile does not bring it back.
            let held = authority.holder().is_some_and(|(seat, _)| seat.seat == caller.seat.seat);
            if is_plug(caller.via) && held && !present {
                return Err(ApiError::void());
            }
            if !tuned {
                let held = authority.command(self.now(), &caller.seat.seat);
                held.map_err(|refusal| ApiError::authority(station.id(), refusal))?;
            }
        }
        if needs.confirm && confirm != Some(station.id()) {
            return Err(ApiError::confirm_needed(station.id()));
        }
        Ok(())
    }

    /// Checks that the client may move this monitor by hand, and counts it as a command.
    pub fn may_jog(&self, caller: &Caller, station: &Station) -> Result<(), ApiError> {
        if caller.principal.role < Role::Operator || !caller.principal.is_good() {
            return Err(ApiError::role(Role::Operator));
        }
        station.refuse_while_updated(caller)?;
        let mut authority = lock(&station.authority);
        let held = authority.command(self.now(), &caller.seat.seat);
        held.map_err(|refusal| ApiError::authority(station.id(), refusal))
    }

    async fn carry_out(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        request: MonitorRequest,
        terms: Terms,
        began: Instant,
    ) -> Result<Outcome, ApiError> {
        let reads = request.need().role == Role::Observer;
        let mut asked = None;
        if !reads {
            station.interrupt_tuning(caller);
            self.other_sent(station);
            let record = self.record(caller, station.id(), request.text(), "asked");
            let mut note = self.audit().note(record.about(&request.act()));
            asked = timeout(NOTED.min(self.patience()), &mut note).await.ok().and_then(Result::ok);
        }
        let request = &request;
        self.know_stored(station, request).await;
        let (passed, exchanged) = match self.pass_and_send(station, request, &terms).await {
            Ok(sent) => sent,
            Err(error) => {
                let record = self.record(caller, station.id(), request.text(), error.code);
                drop(self.audit().note(record.about(&request.act())));
                return Err(error);
            }
        };
        let done = exchanged.as_ref().is_ok_and(|(answers, _)| keep_out::was_done(answers));
        if done {
            station.begun.accepted(caller, request);
        }
        let passed = match (passed, &exchanged) {
            (Some(passed), Ok((answers, _))) => passed.answered(request, answers),
            (Some(passed), Err(it)) if it.unsent => {
                passed.refused();
                None
            }
            // It may have started.
            (_, Err(_)) | (None, _) => None,
        };
        let exchanged = exchanged.map_err(|it| it.error);
        let took_ms = millis(began.elapsed());
        let state = match &exchanged {
            Ok((answers, _)) => state_of_denied(station, answers).await,
            Err(_) => None,
        };
        let sent = Sent::new(request, exchanged, state.as_ref(), took_ms);
        tracing::info!(user = %caller.principal.user, from = %caller.seat.from, monitor = station.id(),
            request = %request.text(), outcome = %sent.noted.outcome, "command");
        let mut audit = None;
        if !reads {
            audit = self.note_answer(caller, station, asked, &sent.noted).await;
        }
        if matches!(
            request.id(),
            RequestId::SET_PARAM
                | RequestId::SWITCH_LIMITS
                | RequestId::RESTART
                | RequestId::CLEAN_FLASH
        ) {
            station.reread.notify_one();
        }
        if done {
            self.was_accepted(caller, station, request);
        }
        // A program is known as running from here on.
        drop(passed);
        let outcome = sent.result.map_err(|error| error.noted(audit))?;
        Ok(Outcome { audit, ..outcome })
    }

    /// Reads what a stored program sweeps, if that may have changed since: keep-outs let none pass that is not known.
    async fn know_stored(&self, station: &Arc<Station>, request: &MonitorRequest) {
        if self.keep_outs(station.id()).is_none() {
            return;
        }
        let read = async {
            for param in keep_out::stored_of(&request.buf().request()) {
                read_ahead(self, station, param).await;
            }
        };
        // What is not known then is refused, which says so.
        _ = timeout(AHEAD, read).await;
    }

    /// Lets a request pass the keep-outs and hands it to the client, one at a time for each monitor: what was
    /// let pass later gets to the line later.
    async fn pass_and_send(
        &self,
        station: &Arc<Station>,
        request: &MonitorRequest,
        terms: &Terms,
    ) -> Result<(Option<keep_out::Passed>, Exchanged), ApiError> {
        let mut exchange = pin!(exchange(station, request, terms.save));
        let changes = may_change(&request.buf().request());
        let mut passed = None;
        let first = poll_fn(|context| {
            let _one = lock(&station.sending);
            let valid = station.still_accepts(request, terms.accepted)
                && terms.valid.as_ref().is_none_or(|valid| valid());
            let may = valid.then_some(()).ok_or_else(ApiError::void);
            Poll::Ready(may.and_then(|()| self.pass_keep_outs(station, request)).map(|it| {
                passed = it;
                if changes {
                    lock(&station.stored).doubt();
                }
                // The first poll puts it into the queue of the client.
                exchange.as_mut().poll(context)
            }))
        });
        let exchanged = match first.await? {
            Poll::Ready(exchanged) => exchanged,
            Poll::Pending => exchange.await,
        };
        if changes {
            // What was read meanwhile may be of before.
            lock(&station.stored).doubt();
        }
        Ok((passed, exchanged))
    }

    /// Sends one frame for urgent requests that were joined.
    pub async fn send_urgent(
        &self,
        station: &Arc<Station>,
        request: MonitorRequest,
        since: Instant,
    ) -> Sent {
        station.ask_for_link().await;
        let exchanged = exchange(station, &request, false).await.map_err(|it| it.error);
        // The next Stop does not wait for an explanation of this one: all reasons are named.
        let sent = Sent::new(&request, exchanged, None, millis(since.elapsed()));
        let micros = u64::try_from(since.elapsed().as_micros()).unwrap_or(u64::MAX);
        self.counts().stop_max_us.fetch_max(micros, Ordering::Relaxed);
        if let (Some(simulation), Ok(Outcome { ok: true, .. })) = (self.simulated(), &sent.result) {
            simulation.commanded(station.id(), sent.noted.request.text());
        }
        sent
    }

    /// Notes for each client how its urgent request was answered; the numbers of the entries.
    pub async fn note_urgent(
        self,
        station: Arc<Station>,
        callers: Vec<Caller>,
        asked: Vec<oneshot::Receiver<u64>>,
        noted: Noted,
    ) -> BTreeMap<String, u64> {
        let each = callers.iter().zip(asked).map(async |(caller, asked)| {
            let asked = self.number_of(asked).await;
            let number = self.note_answer(caller, &station, asked, &noted).await;
            number.map(|number| (caller.seat.seat.clone(), number))
        });
        futures_util::future::join_all(each).await.into_iter().flatten().collect()
    }

    /// Notes how a request was answered, and later what came of it.
    async fn note_answer(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        asked: Option<u64>,
        noted: &Noted,
    ) -> Option<u64> {
        let record = self.record(caller, station.id(), noted.request.text(), &noted.outcome);
        let record = record.with(&AnsweredDetails {
            asked,
            took_ms: noted.took_ms,
            answers: &noted.answers,
            saved: noted.saved.map(Saved::name),
        });
        let number = self.number_of(self.audit().note(record.about(&noted.request.act()))).await;
        self.watch_effect(caller, station, &noted.request, number);
        number
    }

    /// Others have to know what a monitor has accepted.
    fn was_accepted(&self, caller: &Caller, station: &Station, request: &MonitorRequest) {
        if program::begins(request.id()) {
            let (now_ms, by) = (self.clock().now_ms(), &caller.principal.user);
            lock(&station.programs).accepted(now_ms, request.text(), by);
            station.publish_program(self);
        }
        if let Some(simulation) = self.simulated() {
            simulation.commanded(station.id(), request.text());
        }
    }

    /// Longest wait for an entry: zero while the disk takes none.
    fn patience(&self) -> Duration {
        if self.audit().is_failing() { Duration::ZERO } else { NUMBERED }
    }

    /// The number of an entry, if it is on the disk soon.
    async fn number_of(&self, noted: oneshot::Receiver<u64>) -> Option<u64> {
        timeout(self.patience(), noted).await.ok().and_then(Result::ok)
    }

    /// Waits until what a command has done is looked at.
    async fn effect_is_due(&self) {
        let mut shutdown = self.shutdown();
        tokio::select! {
            () = sleep(EFFECT) => {}
            () = shutdown.requested() => {}
        }
    }

    /// Notes the state of the addressee some time after its answer.
    fn watch_effect(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        request: &MonitorRequest,
        answered: Option<u64>,
    ) {
        let (hub, caller, station) = (self.clone(), caller.clone(), station.clone());
        let request = request.clone();
        tokio::spawn(async move {
            hub.effect_is_due().await;
            let status = station.status();
            let states = status.subsystems.iter().filter(|(name, _)| concerns(request.to(), name));
            let effect = Effect {
                answered,
                at_ms: status.at_ms,
                stale: status.stale,
                state: states.map(|(name, state)| (*name, &**state)).collect(),
            };
            let record = hub.record(&caller, station.id(), request.text(), "effect").with(&effect);
            drop(hub.audit().note(record.about(&request.act())));
        });
    }
}

/// Whether a request to a subsystem may change the state of this one.
fn concerns(to: SubsystemId, name: &str) -> bool {
    let id = SubsystemId::from_name(name);
    match to {
        SubsystemId::ALL | SubsystemId::MOTORS => {
            id.is_some_and(|id| id.is_drive() || id.is_valve() || id == SubsystemId::GENERAL)
        }
        to => id == Some(to),
    }
}

/// Details of the entry of a request that its user may not send.
#[derive(Debug, Serialize)]
struct NotAllowed {
    code: &'static str,
}

/// Details of the entry of an answer.
#[derive(Debug, Serialize)]
struct AnsweredDetails<'a> {
    asked: Option<u64>,
    took_ms: u64,
    answers: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    saved: Option<&'static str>,
}

/// Details of the entry of what came of a request.
#[derive(Debug, Serialize)]
struct Effect<'a> {
    answered: Option<u64>,
    at_ms: Option<u64>,
    stale: bool,
    state: BTreeMap<&'static str, &'a Subsystem>,
}

/// On which terms a request is sent.
#[derive(Clone)]
struct Terms {
    /// A parameter's value is waited for until it is stored.
    save: bool,
    /// Asked right before it is sent whether it still is to be.
    valid: Option<Arc<dyn Fn() -> bool + Send + Sync>>,
    /// When it was accepted: what is urgent and comes later makes it void.
    accepted: Accepted,
}

impl Terms {
    fn of(station: &Station, request: &MonitorRequest) -> Self {
        Self { save: false, valid: None, accepted: station.accepts(request) }
    }
}

/// Parameters alone are stored.
fn only_parameters(request: &MonitorRequest, save: bool) -> Result<(), ApiError> {
    match save && request.id() != RequestId::SET_PARAM {
        true => Err(ApiError::bad_request(text::OnlySetParam.words())),
        false => Ok(()),
    }
}

/// A request that was sent: what its client gets, and what is noted.
#[derive(Debug)]
pub struct Sent {
    /// The answer, or why there is none.
    pub result: Result<Outcome, ApiError>,
    /// What the audit log has of it.
    pub noted: Noted,
}

impl Sent {
    /// An exchange, with the state of the monitor that explains a refusal.
    fn new(
        request: &MonitorRequest,
        exchanged: Result<(Answers, Option<Saved>), ApiError>,
        state: Option<&MonitorStatus>,
        took_ms: u64,
    ) -> Self {
        let saved = exchanged.as_ref().ok().and_then(|(_, saved)| *saved);
        let answers = exchanged.map(|(answers, _)| answers);
        let outcome = match &answers {
            Ok(answers) => answers.refusal().unwrap_or(answers.first()).status().to_string(),
            Err(error) => error.code.to_owned(),
        };
        let texts = answers.iter().flat_map(|answers| answers.iter()).map(answer_text).collect();
        let flags = |id| state?.flags(id);
        let result = answers
            .and_then(|answers| Outcome::new(request.text(), took_ms, &answers, &flags))
            .map(|outcome| outcome.saved(saved));
        let request = request.clone();
        Self { result, noted: Noted { request, outcome, took_ms, answers: texts, saved } }
    }
}

/// What the audit log has of an answer.
#[derive(Clone, Debug)]
pub struct Noted {
    request: MonitorRequest,
    outcome: String,
    took_ms: u64,
    answers: Vec<String>,
    saved: Option<Saved>,
}

impl Noted {
    /// The result, as the audit log has it.
    pub fn outcome(&self) -> &str {
        &self.outcome
    }
}

/// The answers to a request, and how far its value is stored.
type Exchanged = Result<(Answers, Option<Saved>), Unanswered>;

/// Why a request has no answer.
#[derive(Debug)]
struct Unanswered {
    error: ApiError,
    /// It was certainly not sent.
    unsent: bool,
}

impl From<&Error> for Unanswered {
    fn from(error: &Error) -> Self {
        // A client that has ended (`Closed`) may have sent it before.
        let unsent = matches!(error, Error::NotSent { .. } | Error::Unsendable { .. });
        Self { error: ApiError::from(error), unsent }
    }
}

/// Sends a request; a parameter's value is waited for until it is stored, if that is wanted.
async fn exchange(station: &Station, request: &MonitorRequest, save: bool) -> Exchanged {
    let client = station.client().map_err(|error| Unanswered { error, unsent: true })?;
    let exchanged = match save {
        true => Monitor::new(client).save(&request.buf().request()).await,
        false => client.send(request.buf().clone()).await.map(|answers| (answers, None)),
    };
    exchanged.map_err(|error| Unanswered::from(&error))
}

/// The state of a monitor that has denied a request, read after the refusal: the last poll may be older than
/// the reason.
async fn state_of_denied(station: &Station, answers: &Answers) -> Option<MonitorStatus> {
    answers.iter().find(|answer| answer.status() == Status::DENIED)?;
    let monitor = Monitor::new(station.client().ok()?);
    timeout(EXPLAINED, monitor.status_all()).await.ok()?.ok()
}

fn millis(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}
