//! A request of somebody to a monitor: may they, is it noted, what was answered.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use lafet_client::{Answers, Lang, Monitor, Saved, mistake};
use lafet_proto::text::{BUFFER_SIZE, parse};
use lafet_proto::{Record as WireRecord, Request, RequestId, SubsystemId};
use serde_json::{Map, Value, json};
use tokio::time::{Instant, sleep, timeout};

use crate::access::{Need, Role, need};
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::model;
use crate::program;
use crate::station::Station;
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
        let allowed = self.allow(caller, station, needs, confirm);
        if let Err(error) = allowed {
            self.counts.refused.fetch_add(1, Ordering::Relaxed);
            // A program that has gone wild must not fill the disk with what was not done.
            if error.status != axum::http::StatusCode::TOO_MANY_REQUESTS {
                let what = request.to_string();
                let mut record = self.record(caller, station.id(), &what, "not allowed");
                record.details = json!({ "code": error.code });
                drop(self.audit.note(record));
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
        if needs.urgent || caller.via == "hub" {
            return Ok(());
        }
        let principal = &caller.principal;
        self.count_request(principal)?;
        if principal.role < needs.role || principal.stale {
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
        if caller.principal.role < Role::Operator || caller.principal.stale {
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
        let reads = needs.role == Role::Observer && !needs.urgent;
        let mut asked = None;
        let mut noted = None;
        if !reads {
            let mut note = self.audit.note(self.record(caller, station.id(), &what, "asked"));
            if !needs.urgent {
                asked =
                    timeout(NOTED.min(self.patience()), &mut note).await.ok().and_then(Result::ok);
            }
            noted = Some(note);
        }
        let exchanged = exchange(station, &request, save).await;
        let saved = exchanged.as_ref().ok().and_then(|(_, saved)| *saved).map(Saved::name);
        let result = exchanged.map(|(answers, _)| answers);
        let took = began.elapsed();
        if needs.urgent {
            let micros = u64::try_from(took.as_micros()).unwrap_or(u64::MAX);
            self.counts.stop_max_us.fetch_max(micros, Ordering::Relaxed);
        }
        let outcome = match &result {
            Ok(answers) => answers.refusal().unwrap_or(answers.first()).status().to_string(),
            Err(error) => error.code.to_owned(),
        };
        tracing::info!(user = %caller.principal.user, from = %caller.seat.from, monitor = station.id(),
            request = %what, %outcome, took_ms = took.as_millis(), "command");
        let mut audit = None;
        if let Some(mut note) = noted {
            if asked.is_none() {
                asked = timeout(self.patience(), &mut note).await.ok().and_then(Result::ok);
            }
            let mut record = self.record(caller, station.id(), &what, &outcome);
            record.details = details(asked, millis(took), result.as_ref().ok(), saved);
            let answered = self.audit.note(record);
            audit = timeout(self.patience(), answered).await.ok().and_then(Result::ok);
            self.watch_effect(caller, station, &what, request.to, audit);
        }
        if matches!(
            request.body.id(),
            RequestId::SET_PARAM | RequestId::SWITCH_LIMITS | RequestId::RESTART
        ) {
            station.reread.notify_one();
        }
        let answers = result?;
        if answers.refusal().is_some() && answers.len() == 1 {
            return Err(ApiError::refused(&answers).with("audit", audit));
        }
        let list = model::answers(&answers);
        let ok = answers.iter().all(|answer| answer.status().is_success());
        if ok {
            self.was_accepted(caller, station, request.body.id(), &what);
        }
        let mut result = json!({
            "ok": ok, "request": what, "took_ms": millis(took), "audit": audit, "answers": list,
        });
        if let Some(saved) = saved {
            result["saved"] = saved.into();
        }
        Ok(result)
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
                .map(|(name, state)| (name.clone(), json!(state)))
                .collect();
            let mut record = hub.record(&caller, station.id(), &what, "effect");
            record.details = json!({
                "answered": answered, "at_ms": status.at_ms, "stale": status.stale, "state": state,
            });
            drop(hub.audit.note(record));
        });
    }
}

/// What the log has of an answer besides its outcome.
fn details(
    asked: Option<u64>,
    took_ms: u64,
    answers: Option<&Answers>,
    saved: Option<&str>,
) -> Value {
    let texts = answers.into_iter().flat_map(|answers| answers.iter());
    let texts: Vec<String> = texts.map(model::answer_text).collect();
    let mut details = json!({ "asked": asked, "took_ms": took_ms, "answers": texts });
    if let Some(saved) = saved {
        details["saved"] = saved.into();
    }
    details
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
