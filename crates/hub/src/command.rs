//! A request of somebody to a monitor: may they, is it noted, what was answered.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use lafet_client::{Answers, Lang, Monitor, Saved, mistake};
use lafet_proto::text::{BUFFER_SIZE, parse};
use lafet_proto::{Record as WireRecord, Request, RequestId, SubsystemId};
use serde_json::{Map, Value, json};
use tokio::sync::oneshot;
use tokio::time::{Instant, sleep, timeout};

use crate::access::{Need, Role, need};
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::model;
use crate::program;
use crate::station::Station;
use crate::store::Act;
use crate::sync::lock;
use crate::text::both;

/// So long a command waits for its entry to be on the disk; then it goes first.
const NOTED: Duration = Duration::from_millis(50);
/// So long an answer waits for the number of its entry.
pub const NUMBERED: Duration = Duration::from_millis(500);
/// The effect of a command is looked at so long after its answer.
const EFFECT: Duration = Duration::from_secs(2);
/// Longest text of a request.
const TEXT_MAX: usize = 4096;

impl Hub {
    /// Sends a request in the text form to a monitor. It is seen through even if nobody waits for
    /// the answer any more.
    pub async fn command(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        text: &str,
        confirm: Option<&str>,
    ) -> Result<Value, ApiError> {
        self.send(caller, station, text, confirm, false).await
    }

    /// Sets a parameter, and waits until it is stored.
    pub async fn save(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        text: &str,
    ) -> Result<Value, ApiError> {
        self.send(caller, station, text, None, true).await
    }

    async fn send(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        text: &str,
        confirm: Option<&str>,
        save: bool,
    ) -> Result<Value, ApiError> {
        let began = Instant::now();
        let mut buffer = [0; BUFFER_SIZE];
        let request = understand(text, &mut buffer)?;
        if save && request.body.id() != RequestId::SET_PARAM {
            let text = both("Only SetParam is waited for.", "Ожидается только SetParam.");
            return Err(ApiError::bad_request(text));
        }
        let needs = needs(&request)?;
        if needs.urgent {
            return self.urgent(caller, station, &request.to_string()).result().await;
        }
        let allowed = self.allow(caller, station, needs, confirm);
        if let Err(error) = allowed {
            self.counts.refused.fetch_add(1, Ordering::Relaxed);
            // A program that has gone wild must not fill the disk with what was not done.
            if error.status != axum::http::StatusCode::TOO_MANY_REQUESTS {
                let what = request.to_string();
                let mut record = self.record(caller, station.id(), &what, "not allowed");
                record.details = json!({ "code": error.code });
                drop(self.audit.note(record.about(&act_of(&request.to_string()))));
            }
            return Err(error);
        }
        self.counts.commands.fetch_add(1, Ordering::Relaxed);
        let (hub, caller, station) = (self.clone(), caller.clone(), station.clone());
        let text = text.to_owned();
        let run = tokio::spawn(async move {
            hub.carry_out(&caller, &station, &text, (needs, save), began).await
        });
        run.await.unwrap_or_else(|_| Err(ApiError::from(&lafet_client::Error::Closed)))
    }

    /// What somebody may not do, and why.
    fn allow(
        &self,
        caller: &Caller,
        station: &Station,
        needs: Need,
        confirm: Option<&str>,
    ) -> Result<(), ApiError> {
        if caller.via == "hub" {
            return Ok(());
        }
        let principal = &caller.principal;
        self.count_request(principal)?;
        if principal.role < needs.role || !principal.is_good() {
            return Err(ApiError::role(needs.role));
        }
        if needs.authority {
            let mut authority = lock(&station.authority);
            let held = authority.command(self.now(), &caller.seat.seat);
            held.map_err(|refusal| ApiError::authority(station.id(), refusal))?;
        }
        if needs.confirm && confirm != Some(station.id()) {
            let id = station.id();
            let text = both(
                format!("This needs \"confirm\": \"{id}\", so that nobody does it by mistake."),
                format!("Нужно \"confirm\": \"{id}\", чтобы это не сделали по ошибке."),
            );
            return Err(ApiError::new(axum::http::StatusCode::BAD_REQUEST, "confirm_needed", text));
        }
        Ok(())
    }

    /// Whether somebody may move this monitor by hand; if so, it counts as a command.
    pub fn may_jog(&self, caller: &Caller, station: &Station) -> Result<(), ApiError> {
        if caller.principal.role < Role::Operator || !caller.principal.is_good() {
            return Err(ApiError::role(Role::Operator));
        }
        let mut authority = lock(&station.authority);
        let held = authority.command(self.now(), &caller.seat.seat);
        held.map_err(|refusal| ApiError::authority(station.id(), refusal))
    }

    async fn carry_out(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        text: &str,
        (needs, save): (Need, bool),
        began: Instant,
    ) -> Result<Value, ApiError> {
        let mut buffer = [0; BUFFER_SIZE];
        let request = understand(text, &mut buffer)?;
        let what = request.to_string();
        let reads = needs.role == Role::Observer;
        let mut asked = None;
        if !reads {
            station.urgent.other_sent(self, station);
            let record = self.record(caller, station.id(), &what, "asked");
            let mut note = self.audit.note(record.about(&act_of(&request.to_string())));
            asked = timeout(NOTED.min(self.patience()), &mut note).await.ok().and_then(Result::ok);
        }
        let sent = self.send_now(station, &request, save, began).await;
        tracing::info!(user = %caller.principal.user, from = %caller.seat.from, monitor = station.id(),
            request = %what, outcome = %sent.noted.outcome, "command");
        let mut audit = None;
        if !reads {
            audit = self.note_answer(caller, station, asked, &sent.noted).await;
        }
        if matches!(
            request.body.id(),
            RequestId::SET_PARAM | RequestId::SWITCH_LIMITS | RequestId::RESTART
        ) {
            station.reread.notify_one();
        }
        let mut result = sent.result.map_err(|error| error.with("audit", audit))?;
        result["audit"] = audit.into();
        if result["ok"] == true {
            self.was_accepted(caller, station, request.body.id(), &what);
        }
        Ok(result)
    }

    /// Sends one frame for urgent requests that were joined.
    pub async fn send_urgent(&self, station: &Arc<Station>, text: &str, since: Instant) -> Sent {
        let mut buffer = [0; BUFFER_SIZE];
        let sent = match understand(text, &mut buffer) {
            Ok(request) => self.send_now(station, &request, false, since).await,
            Err(error) => Sent::failed(text, error),
        };
        let micros = u64::try_from(since.elapsed().as_micros()).unwrap_or(u64::MAX);
        self.counts.stop_max_us.fetch_max(micros, Ordering::Relaxed);
        if let (Some(simulation), true) = (self.simulation.get(), sent.is_accepted()) {
            simulation.commanded(station.id(), text);
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
            let asked = timeout(self.patience(), asked).await.ok().and_then(Result::ok);
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
        let mut record = self.record(caller, station.id(), &noted.what, &noted.outcome);
        record.details = noted.details(asked);
        let answered = self.audit.note(record.about(&act_of(&noted.what)));
        let number = timeout(self.patience(), answered).await.ok().and_then(Result::ok);
        self.watch_effect(caller, station, &noted.what, noted.to, number);
        number
    }

    async fn send_now(
        &self,
        station: &Arc<Station>,
        request: &Request<'_>,
        save: bool,
        began: Instant,
    ) -> Sent {
        let exchanged = exchange(station, request, save).await;
        let saved = exchanged.as_ref().ok().and_then(|(_, saved)| *saved).map(Saved::name);
        let answers = exchanged.map(|(answers, _)| answers);
        let outcome = match &answers {
            Ok(answers) => answers.refusal().unwrap_or(answers.first()).status().to_string(),
            Err(error) => error.code.to_owned(),
        };
        let texts = answers.iter().flat_map(|answers| answers.iter());
        let noted = Noted {
            what: request.to_string(),
            to: request.to,
            outcome,
            took_ms: millis(began.elapsed()),
            answers: texts.map(model::answer_text).collect(),
            saved,
        };
        let result = answers.and_then(|answers| noted.result(&answers));
        Sent { result, noted }
    }

    /// Others have to know what a monitor has accepted.
    fn was_accepted(&self, caller: &Caller, station: &Station, id: RequestId, what: &str) {
        if program::begins(id) {
            let (now_ms, by) = (self.clock.now_ms(), &caller.principal.user);
            lock(&station.programs).accepted(now_ms, what, by);
            station.publish_program(self);
        }
        if let Some(simulation) = self.simulation.get() {
            simulation.commanded(station.id(), what);
        }
    }

    /// So long an entry is waited for: not at all while the disk takes none.
    fn patience(&self) -> Duration {
        if self.audit.is_failing() { Duration::ZERO } else { NUMBERED }
    }

    /// Notes the state of the addressee some time after its answer.
    fn watch_effect(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        what: &str,
        to: SubsystemId,
        answered: Option<u64>,
    ) {
        let (hub, caller, station) = (self.clone(), caller.clone(), station.clone());
        let what = what.to_owned();
        tokio::spawn(async move {
            let mut ending = hub.ending.subscribe();
            tokio::select! {
                () = sleep(EFFECT) => {}
                () = async { _ = ending.wait_for(|ending| *ending).await } => {}
            }
            let status = station.status();
            let concerned = |name: &str| {
                let id = SubsystemId::from_name(name);
                match to {
                    SubsystemId::ALL | SubsystemId::MOTORS => id.is_some_and(|id| {
                        id.is_drive() || id.is_valve() || id == SubsystemId::GENERAL
                    }),
                    to => id == Some(to),
                }
            };
            let state: Map<String, Value> = status
                .subsystems
                .iter()
                .filter(|(name, _)| concerned(name))
                .map(|(name, state)| ((*name).to_owned(), json!(state)))
                .collect();
            let mut record = hub.record(&caller, station.id(), &what, "effect");
            record.details = json!({
                "answered": answered, "at_ms": status.at_ms, "stale": status.stale, "state": state,
            });
            drop(hub.audit.note(record.about(&act_of(&what))));
        });
    }
}

/// A request in the text form, as the audit log has it.
pub fn act_of(text: &str) -> Act {
    let mut words = text.split(' ').map(str::to_owned);
    let (request, to) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    Act::Request { request, to }
}

/// A request that was sent: what its client gets, and what is noted.
#[derive(Debug)]
pub struct Sent {
    /// The answer.
    pub result: Result<Value, ApiError>,
    /// What the audit log has of it.
    pub noted: Noted,
}

/// What the audit log has of an answer.
#[derive(Clone, Debug)]
pub struct Noted {
    what: String,
    to: SubsystemId,
    outcome: String,
    took_ms: u64,
    answers: Vec<String>,
    saved: Option<&'static str>,
}

impl Sent {
    fn failed(text: &str, error: ApiError) -> Self {
        let noted = Noted {
            what: text.to_owned(),
            to: SubsystemId::ALL,
            outcome: error.code.to_owned(),
            took_ms: 0,
            answers: Vec::new(),
            saved: None,
        };
        Self { result: Err(error), noted }
    }

    fn is_accepted(&self) -> bool {
        self.result.as_ref().is_ok_and(|result| result["ok"] == true)
    }
}

impl Noted {
    fn details(&self, asked: Option<u64>) -> Value {
        let mut details =
            json!({ "asked": asked, "took_ms": self.took_ms, "answers": self.answers });
        if let Some(saved) = self.saved {
            details["saved"] = saved.into();
        }
        details
    }

    fn result(&self, answers: &Answers) -> Result<Value, ApiError> {
        if answers.refusal().is_some() && answers.len() == 1 {
            return Err(ApiError::refused(answers));
        }
        let ok = answers.iter().all(|answer| answer.status().is_success());
        let mut result = json!({
            "ok": ok, "request": self.what, "took_ms": self.took_ms, "audit": null,
            "answers": model::answers(answers),
        });
        if let Some(saved) = self.saved {
            result["saved"] = saved.into();
        }
        Ok(result)
    }
}

/// Sends a request; a parameter's value is waited for until it is stored, if that is wanted.
async fn exchange(
    station: &Station,
    request: &Request<'_>,
    save: bool,
) -> Result<(Answers, Option<Saved>), ApiError> {
    let client = station.client()?;
    let exchanged = match save {
        true => Monitor::new(client).save(request).await,
        false => client.request(request).await.map(|answers| (answers, None)),
    };
    exchanged.map_err(|error| ApiError::from(&error))
}

/// Reads the text of a request.
pub fn understand<'b>(text: &str, buffer: &'b mut [u8]) -> Result<Request<'b>, ApiError> {
    if text.len() > TEXT_MAX {
        let text = both("The request is too long.", "Запрос слишком длинный.");
        return Err(ApiError::new(axum::http::StatusCode::PAYLOAD_TOO_LARGE, "too_large", text));
    }
    parse(text, buffer).map_err(|error| {
        let told = both(mistake(text, &error, Lang::En), mistake(text, &error, Lang::Ru));
        let told = ApiError::bad_request(told);
        let told = told.with("column", error.column).with("length", error.len);
        match error.suggestion {
            Some(suggestion) => told.with("suggestion", suggestion),
            None => told,
        }
    })
}

/// What a request needs. One that was written in numbers is understood first, lest it hides.
pub fn needs(request: &Request<'_>) -> Result<Need, ApiError> {
    use lafet_proto::request::Body;
    let id = request.body.id();
    let need = match request.body {
        Body::Unknown { request: id, data } => {
            let record = WireRecord {
                request: id,
                device: request.to,
                status: lafet_proto::Status::OK,
                data,
            };
            match Request::decode(&record) {
                Ok(understood) => need(id, &understood.body),
                // Stop and Close with data that are not theirs are no Stop and no Close.
                Err(_) => match need(id, &request.body) {
                    Some(Need { urgent: true, .. }) => need(RequestId(0), &request.body),
                    other => other,
                },
            }
        }
        body => need(id, &body),
    };
    let need = match need {
        // What no monitor has cannot be stopped; and there are too many such names to let each of
        // them overtake.
        Some(Need { urgent: true, .. }) if request.to.name().is_none() => {
            crate::access::need(RequestId(0), &request.body)
        }
        need => need,
    };
    need.ok_or_else(|| {
        ApiError::bad_request(both(
            "This is the bus controller's own.",
            "Этот запрос — только для контроллера магистрали.",
        ))
    })
}

fn millis(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}
