//! What a client asks for over its WebSocket, and the answers.

use std::collections::{BTreeSet, HashMap};
use std::pin::pin;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::extract::ws::{self, Utf8Bytes, WebSocket};
use futures_util::StreamExt;
use futures_util::future::join_all;
use futures_util::stream::SplitStream;
use lafet_proto::SubsystemId;
use lafet_texts::{Text, hub as text};
use serde_json::Value;
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc, watch};
use tokio::task::{AbortHandle, yield_now};
use tokio::time::{sleep, timeout};

use super::frames::show_frames;
use super::said::{Id, Said, understand};
use super::writer::{ENDED, TOO_SLOW};
use super::{Close, Pings, standing};
use crate::access::{Bucket, Standing};
use crate::api::guard;
use crate::api::monitors::{self, JogBeat};
use crate::command::outcome::{OfAll, OfOne, Outcome, parted};
use crate::command::request::MonitorRequest;
use crate::command::urgent::{Joined, UNANSWERED};
use crate::control::beats::Delay;
use crate::error::{ApiError, shown};
use crate::hub::{Caller, Has, Hub};
use crate::monitor::station::Station;
use crate::publish::messages::{Answer, Message, Progress, Subscribed};
use crate::publish::topics::Audience;
use crate::server::allowances::Talk;
use crate::sync::lock;
use crate::words::{MotionEnd, MotionWord};

/// Requests of a connection that wait for their answers.
pub const REQUESTS_MAX: usize = 32;
/// Stop, Close and Lockout that wait for theirs. One more is carried out, and then nothing is read until
/// one of them is answered: more than a person can send while a monitor does not answer.
pub const URGENT_MAX: usize = 64;

/// A client that leaves no room for an answer for this time takes none: until its connection is closed nothing would be
/// read from it, and a Stop would wait.
const TAKEN: Duration = Duration::from_secs(2);
/// Messages a second of a connection that is being closed, which are passed over: as many as it may have sent before it was
/// read no more are passed over while it is closed, and a Stop behind them is reached.
const PASSED: f64 = 2000.0;

/// Monitors to which a connection subscribes by name.
const SUBSCRIBED_MAX: usize = 32;

const TOO_LARGE: (u16, &str) = (1009, "message too large");
const TOO_MANY: (u16, &str) = (4429, "too many messages");

/// What is done with a message that is not urgent.
enum Counted {
    /// It is heeded.
    Heeded,
    /// It came too late.
    Passed,
    /// It is one too many.
    Over,
}

pub struct Reader {
    pub hub: Hub,
    pub caller: Caller,
    pub answers: mpsc::Sender<Utf8Bytes>,
    pub pings: Arc<Pings>,
    pub room: Arc<Semaphore>,
    pub urgent_room: Arc<Semaphore>,
    pub watching: HashMap<String, AbortHandle>,
    /// What was said last of a drive: beats are many, news are few.
    pub told: HashMap<(String, SubsystemId), MotionWord>,
    /// Passes to the writer what the client looks at.
    pub audience: watch::Sender<Audience>,
    /// How much it may say.
    pub talk: Talk,
    /// Whether the seat is still this connection's.
    pub has: Has,
    /// How long its requests are under way.
    pub delay: Delay,
    /// The connection is being closed: of what still comes, only the urgent is carried out.
    pub rest: Option<Rest>,
    /// The client takes no answers.
    pub full: bool,
}

/// What is left of a connection that is being closed.
pub struct Rest(Mutex<Bucket>);

impl Rest {
    fn new(now: Duration) -> Self {
        Self(Mutex::new(Bucket::new(now, PASSED, PASSED)))
    }
}

impl Reader {
    /// The connection is being closed.
    pub fn close(&mut self) {
        (self.rest, self.full) = (Some(Rest::new(self.hub.now())), false);
    }

    pub async fn run(&mut self, stream: &mut SplitStream<WebSocket>) -> Close {
        while let Some(message) = stream.next().await {
            let message = match message {
                Ok(message) => message,
                Err(error) if error.to_string().contains("too long") => return Some(TOO_LARGE),
                Err(_) => return None,
            };
            self.pings.heard.store(true, Ordering::Relaxed);
            let text = match message {
                ws::Message::Text(text) => text,
                ws::Message::Close(_) => return None,
                message if self.was_asked_for(&message) => continue,
                // A ping is answered, and costs as much as what says something.
                _ => match self.count().await {
                    Counted::Over => return Some(TOO_MANY),
                    Counted::Heeded | Counted::Passed => {
                        yield_now().await;
                        continue;
                    }
                },
            };
            let said = understand(&text);
            let urgent = said.as_ref().is_ok_and(is_urgent);
            if !urgent {
                match self.count().await {
                    Counted::Heeded => {}
                    Counted::Passed => {
                        yield_now().await;
                        continue;
                    }
                    Counted::Over => return Some(TOO_MANY),
                }
            }
            // A user who was removed or has another role commands nothing any more, however long the writer
            // waits for the client before it closes the connection.
            let standing = match urgent {
                true => Standing::Good,
                false => match standing(&self.hub, &self.caller.principal) {
                    Some(standing) => standing,
                    None => return Some(ENDED),
                },
            };
            match said {
                Ok(said) if standing != Standing::Good => self.refuse(said).await,
                Ok(said) => self.heed(said).await,
                Err(error) => {
                    let id = serde_json::from_str::<Value>(&text).ok();
                    let id = Id::from(id.map(|it| it["id"].clone()));
                    self.answer(id, Err(guard::not_understood(&error))).await;
                }
            }
            if self.full {
                return Some(TOO_SLOW);
            }
            let wait = match urgent {
                true => lock(&self.talk.urgent).take(self.hub.now()).err(),
                false => None,
            };
            match wait {
                Some(wait) => sleep(wait).await,
                // What one client has sent at once does not hold up the others: each message has its turn.
                None => yield_now().await,
            }
        }
        None
    }

    /// The answer to a ping of the hub: it costs nothing, once.
    fn was_asked_for(&self, message: &ws::Message) -> bool {
        matches!(message, ws::Message::Pong(_))
            && self.pings.unanswered.swap(false, Ordering::Relaxed)
    }

    /// Counts a message that is not urgent. What was on its way when the connection ended, or when another one took the
    /// seat, is not carried out; how fast it is passed over is bounded.
    async fn count(&self) -> Counted {
        if let Some(rest) = &self.rest {
            let wait = lock(&rest.0).take(self.hub.now()).err();
            if let Some(wait) = wait {
                sleep(wait).await;
            }
            return Counted::Passed;
        }
        let left = lock(&self.talk.messages).take(self.hub.now());
        match (left, self.has.still()) {
            (Ok(()), true) => return Counted::Heeded,
            (Err(_), true) => return Counted::Over,
            (Ok(()), false) => {}
            (Err(wait), false) => sleep(wait).await,
        }
        Counted::Passed
    }

    /// What is not urgent, of a client whose certificate has ended: it is answered as a session that has run out.
    async fn refuse(&mut self, said: Said) {
        let principal = &self.caller.principal;
        let left = principal.outlasted(self.hub.now_for(principal));
        let error = guard::login_needed(&self.hub, left.as_ref());
        match said {
            Said::Jog { monitor, beat } => self.tell(monitor, &beat, Err(error)),
            // What only ends a motion is taken from everyone.
            Said::JogEnd { .. } | Said::TuneBeat { end: true, .. } => self.heed(said).await,
            Said::TuneBeat { .. } | Said::Watch { .. } => {}
            Said::Request { id, .. }
            | Said::Authority { id, .. }
            | Said::Tune { id, .. }
            | Said::Subscribe { id, .. }
            | Said::Stop { id, .. }
            | Said::Close { id, .. }
            | Said::Lockout { id, .. } => self.send(Answer::refused(id, &error)).await,
        }
    }

    async fn heed(&mut self, said: Said) {
        match said {
            Said::Stop { id, monitor: None, .. } => {
                self.everywhere(id, MonitorRequest::stop(SubsystemId::ALL)).await;
            }
            Said::Lockout { id, monitor: None } => {
                self.everywhere(id, MonitorRequest::lockout()).await;
            }
            Said::Stop { id, monitor: Some(monitor), of } => {
                let stop = |_: &Station| Ok(vec![monitors::stop(of.as_deref())?]);
                self.urgent(id, &monitor, stop).await;
            }
            Said::Close { id, monitor, valve } => {
                let close = |station: &Station| monitors::close(station, valve.as_deref());
                self.urgent(id, &monitor, close).await;
            }
            Said::Lockout { id, monitor: Some(monitor) } => {
                self.urgent(id, &monitor, |_| Ok(vec![MonitorRequest::lockout()?])).await;
            }
            Said::Request { id, monitor, request, t, up_ms, confirm, save } => {
                let now = self.hub.now();
                let longer = t.map(|t| self.delay.longer(now, t).unwrap_or(Duration::MAX));
                let longer = longer.map(|it| self.hub.age(it));
                self.request(id, &monitor, (&request, longer, up_ms), confirm, save).await;
            }
            Said::Authority { id, monitor, action, reason } => {
                let answer = self.authority(id, &monitor, &action, reason.as_deref());
                self.send(answer).await;
            }
            Said::Jog { monitor, beat } => self.beat(monitor, &beat),
            Said::JogEnd { monitor, drive } => {
                let end =
                    JogBeat { drive: drive.clone(), toward: None, t: None, up_ms: None, end: true };
                if let Ok(station) = self.hub.station(&monitor) {
                    _ = self.hub.beat(&self.caller, &station, &end);
                }
                if let Some(drive) = SubsystemId::from_name(&drive) {
                    self.told.remove(&(monitor, drive));
                }
            }
            Said::Tune { id, monitor, drive, up_ms } => {
                let station = self.hub.station(&monitor);
                let begun = station.and_then(|it| self.tune(&it, &drive, up_ms));
                let answer = match begun {
                    Ok(()) => Answer::to(id),
                    Err(error) => Answer::refused(id, &error),
                };
                self.send(answer).await;
            }
            Said::TuneBeat { monitor, end } => {
                if let Ok(station) = self.hub.station(&monitor) {
                    station.beat_tuning(&self.caller.seat.seat, end);
                }
            }
            Said::Watch { frames } => self.watch(&frames),
            Said::Subscribe { id, monitors } => {
                let answer = match self.subscribe(monitors) {
                    Ok(subscribed) => Answer { subscribed: Some(subscribed), ..Answer::to(id) },
                    Err(error) => Answer::refused(id, &error),
                };
                self.send(answer).await;
            }
        }
    }

    /// Who asks for something urgent. A session that others have ended may still stop until its connection is closed,
    /// but shuts no water of a fire.
    fn urgent_caller(&self) -> Caller {
        let mut caller = self.caller.clone();
        if self.hub.access().was_ended(&caller.principal) {
            caller.principal.standing = Standing::Ended;
        }
        caller
    }

    fn authority(&self, id: Id, monitor: &str, action: &str, reason: Option<&str>) -> Answer {
        let result = self
            .hub
            .station(monitor)
            .and_then(|station| self.hub.change_authority(&self.caller, &station, action, reason));
        match result {
            Ok(authority) => Answer { authority: Some(authority), ..Answer::to(id) },
            Err(error) => Answer::refused(id, &error),
        }
    }

    fn tune(
        &self,
        station: &Arc<Station>,
        drive: &str,
        up_ms: Option<f64>,
    ) -> Result<(), ApiError> {
        if let Some(id) = SubsystemId::from_name(drive) {
            self.hub.in_time(station, &MonitorRequest::moving(id)?, None, up_ms)?;
        }
        self.hub.tune(&self.caller, station, drive)
    }

    /// What the client looks at from now on, instead of what it looked at before.
    fn subscribe(&self, monitors: Option<Vec<String>>) -> Result<Subscribed, ApiError> {
        let monitors = match monitors {
            Some(monitors) if monitors.len() > SUBSCRIBED_MAX => {
                return Err(ApiError::bad_request(
                    text::SubscribedTooMany { subscribed_max: SUBSCRIBED_MAX }.words(),
                ));
            }
            Some(monitors) => {
                let known = |id: String| self.hub.station(&id).map(|it| it.id().to_owned());
                Some(monitors.into_iter().map(known).collect::<Result<BTreeSet<_>, _>>()?)
            }
            None => None,
        };
        self.audience.send_replace(Audience(monitors.clone()));
        Ok(Subscribed { monitors })
    }

    fn beat(&mut self, monitor: String, beat: &JogBeat) {
        let station = self.hub.station(&monitor);
        let result = station.and_then(|station| self.hub.beat(&self.caller, &station, beat));
        self.tell(monitor, beat, result);
    }

    /// A beat is answered where the state is news: `moving` and the end are sent by the motion.
    fn tell(&mut self, monitor: String, beat: &JogBeat, result: Result<MotionWord, ApiError>) {
        let is_known = self.hub.station(&monitor).is_ok();
        let drive = SubsystemId::from_name(&beat.drive).filter(|_| is_known);
        let (state, text) = match &result {
            Ok(state) => (*state, None),
            Err(error) => (MotionWord::Ended, Some(&error.text)),
        };
        // What does not exist is not remembered: a client could invent names without end.
        let news =
            drive.is_none_or(|it| self.told.insert((monitor.clone(), it), state) != Some(state));
        if state == MotionWord::Armed && news || state == MotionWord::Ended {
            let message = Message::Jog {
                monitor: shown(&monitor).to_owned(),
                drive: shown(&beat.drive).to_owned(),
                state,
                end: text.map(|_| MotionEnd::Refused),
                text: text.map(|text| (**text).clone()),
            };
            self.hub.send_to(&self.caller.seat.seat, &message);
        }
    }

    /// The same urgent request to every monitor. Each result is sent as it comes, then all of them.
    async fn everywhere(&mut self, id: Id, request: Result<MonitorRequest, ApiError>) {
        let request = match request {
            Ok(request) => request,
            Err(error) => return self.answer(id, Err(error)).await,
        };
        let all = self.hub.overtake_everywhere(&self.urgent_caller(), &request);
        // It is under way: only what comes next may wait for room for the answers.
        let Some(turn) = self.turn().await else { return };
        let answers = self.answers.clone();
        tokio::spawn(async move {
            let _turn = turn;
            let each = all.into_iter().map(async |(monitor, mut joined)| {
                let progress = Progress::sent(id.clone(), &monitor);
                let result = match joined.soon().await {
                    Some(result) => result,
                    None => {
                        _ = answers.send(written(progress.clone())).await;
                        joined.result().await
                    }
                };
                let of_one = OfOne::new(Some(result.clone()));
                let (result, error) = parted(result);
                let progress = Progress { answered: true, result, error, ..progress };
                _ = answers.send(written(progress)).await;
                (monitor, of_one)
            });
            let results: OfAll = join_all(each).await.into_iter().collect();
            let answer = Answer { results: Some(results), ..Answer::to(id.clone()) };
            _ = answers.send(Message::Answer(answer.into()).written()).await;
        });
    }

    /// Room for the answer of what is urgent; `None`: there is none to be sent.
    async fn turn(&mut self) -> Option<OwnedSemaphorePermit> {
        while self.rest.is_none() && !self.full {
            let turn = timeout(TAKEN, self.urgent_room.clone().acquire_owned()).await;
            match turn {
                Ok(turn) => return turn.ok(),
                // As long as answers are taken, a monitor is what is waited for.
                Err(_) => self.full = self.answers.capacity() == 0,
            }
        }
        None
    }

    /// Urgent requests to a monitor; they are under way when this returns.
    async fn urgent(
        &mut self,
        id: Id,
        monitor: &str,
        requests: impl FnOnce(&Station) -> Result<Vec<MonitorRequest>, ApiError>,
    ) {
        let known = self.hub.station(monitor).map_err(|_| ApiError::nothing_stopped(monitor));
        let (station, requests) =
            match known.and_then(|station| Ok((station.clone(), requests(&station)?))) {
                Ok(known) => known,
                Err(error) => return self.answer(id, Err(error)).await,
            };
        let caller = self.urgent_caller();
        let all: Vec<Joined> =
            requests.iter().map(|it| self.hub.urgent(&caller, &station, it)).collect();
        // They are under way: only what comes next may wait for room for the answers.
        let Some(turn) = self.turn().await else { return };
        let (answers, monitor) = (self.answers.clone(), station.id().to_owned());
        tokio::spawn(async move {
            let _turn = turn;
            let mut results = pin!(monitors::together(all));
            let result = match timeout(UNANSWERED, &mut results).await {
                Ok(result) => result,
                Err(_) => {
                    _ = answers.send(written(Progress::sent(id.clone(), &monitor))).await;
                    results.await
                }
            };
            _ = answers.send(answered(id, result)).await;
        });
    }

    async fn request(
        &mut self,
        id: Id,
        monitor: &str,
        (request, longer, up_ms): (&str, Option<Duration>, Option<f64>),
        confirm: Option<String>,
        save: bool,
    ) {
        let request = MonitorRequest::parse(request);
        if let Ok(request) = &request
            && request.need().urgent
        {
            return self.urgent(id, monitor, |_| Ok(vec![request.clone()])).await;
        }
        let known = self.hub.station(monitor);
        let (station, request) = match known.and_then(|station| Ok((station, request?))) {
            Ok(known) => known,
            Err(error) => return self.answer(id, Err(error)).await,
        };
        if let Err(error) = self.hub.in_time(&station, &request, longer, up_ms) {
            return self.answer(id, Err(error)).await;
        }
        let Ok(turn) = self.room.clone().try_acquire_owned() else {
            let error = ApiError::slow_down(Duration::from_millis(100));
            return self.answer(id, Err(error)).await;
        };
        let (hub, caller, answers) = (self.hub.clone(), self.caller.clone(), self.answers.clone());
        let accepted = station.accepts(&request);
        tokio::spawn(async move {
            let _turn = turn;
            let how = (confirm.as_deref(), save);
            let result = hub.command_accepted(&caller, &station, request, how, accepted).await;
            _ = answers.send(answered(id, result)).await;
        });
    }

    async fn answer(&mut self, id: Id, result: Result<Outcome, ApiError>) {
        self.send(Answer::of(id, result)).await;
    }

    /// Waits while the client does not take its answers: then nothing more is read from it either, and it is closed.
    async fn send(&mut self, answer: Answer) {
        let text = Message::Answer(answer.into()).written();
        if let Err(TrySendError::Full(text)) = self.answers.try_send(text) {
            self.full = timeout(TAKEN, self.answers.send(text)).await.is_err();
        }
    }

    fn watch(&mut self, monitors: &[String]) {
        self.watching.retain(|id, task| {
            let stays = monitors.contains(id);
            if !stays {
                task.abort();
            }
            stays
        });
        for id in monitors {
            if let Ok(station) = self.hub.station(id)
                && !self.watching.contains_key(id)
            {
                let show = show_frames(self.hub.clone(), self.caller.clone(), station.clone());
                self.watching.insert(id.clone(), tokio::spawn(show).abort_handle());
            }
        }
    }
}

/// Stop, Close and Lockout, also where they are written as a request.
fn is_urgent(said: &Said) -> bool {
    match said {
        Said::Stop { .. } | Said::Close { .. } | Said::Lockout { .. } => true,
        Said::Request { request, .. } => {
            MonitorRequest::parse(request).is_ok_and(|it| it.need().urgent)
        }
        _ => false,
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        self.watching.values().for_each(AbortHandle::abort);
    }
}

fn answered(id: Id, result: Result<Outcome, ApiError>) -> Utf8Bytes {
    Message::Answer(Answer::of(id, result).into()).written()
}

fn written(progress: Progress) -> Utf8Bytes {
    Message::Progress(progress.into()).written()
}

#[cfg(test)]
mod tests {
    use tokio::time::Instant;

    use super::super::ANSWERS_MAX;
    use super::super::writer::SLOW;
    use super::*;
    use crate::access::Role;
    use crate::monitor::view::UrgentCounts;
    use crate::text::both;

    #[test]
    fn a_refusal_is_an_answer() {
        let error = both("a", "б");
        let answer = answered(Id::default(), Err(ApiError::bad_request(error)));
        let answer: Value = serde_json::from_str(&answer).unwrap();
        assert_eq!(answer["error"]["en"], "a");
        assert!(answer["id"].is_null() && answer.get("result").is_none(), "{answer}");
    }

    /// A connection of the hub's own, with room for so many answers.
    fn reader(answers: usize) -> (Reader, mpsc::Receiver<Utf8Bytes>) {
        let config = crate::Config::default();
        let hub = Hub::new(config, crate::Clock::System, Value::Null).unwrap();
        let (answers, waiting) = mpsc::channel(answers);
        let room = || Arc::new(Semaphore::new(1));
        let key = hub.connect(&Caller::hub().principal, "", None);
        let reader = Reader {
            hub,
            caller: Caller::hub(),
            answers,
            pings: Arc::default(),
            room: room(),
            urgent_room: room(),
            watching: HashMap::new(),
            told: HashMap::new(),
            audience: watch::channel(Audience::default()).0,
            talk: Talk::new(Duration::ZERO),
            has: key.has,
            delay: Delay::default(),
            rest: None,
            full: false,
        };
        (reader, waiting)
    }

    /// An administrator removes a user whose WebSocket is open: until it is closed, it stops, and shuts no water.
    #[tokio::test]
    async fn a_removed_user_stops_and_shuts_no_water() {
        const PASSWORD: &str = "correct horse";
        let (hub, station) = Hub::of_one(None);
        let access = hub.access();
        let link = access.setup_link().unwrap().unwrap();
        access.set_up(1, &link, "root", PASSWORD).unwrap();
        access.add(1, "anna", Role::Operator, PASSWORD).unwrap();
        let principal = access.log_in(1, "anna", PASSWORD).unwrap().principal;
        let key = hub.connect(&principal, "", None);
        let caller = Caller::socket(principal, [127, 0, 0, 1].into(), key.seat.clone());
        let (mut own, _waiting) = reader(ANSWERS_MAX);
        (own.hub, own.caller) = (hub.clone(), caller);
        (own.urgent_room, own.has) = (Arc::new(Semaphore::new(URGENT_MAX)), key.has);
        let id = Id::default;
        let monitor = || Some("M1".to_owned());
        let sent = async |own: &mut Reader| {
            let before = station.urgent_counts();
            own.heed(Said::Close { id: id(), monitor: "M1".into(), valve: None }).await;
            own.heed(Said::Lockout { id: id(), monitor: monitor() }).await;
            own.heed(Said::Lockout { id: id(), monitor: None }).await;
            own.heed(Said::Stop { id: id(), monitor: monitor(), of: None }).await;
            let after = station.urgent_counts();
            let of = |count: fn(&UrgentCounts) -> u64| count(&after) - count(&before);
            [of(|it| it.close) > 0, of(|it| it.lockout) > 0, of(|it| it.stop) > 0]
        };
        assert_eq!(sent(&mut own).await, [true; 3]);
        hub.access().remove(2, "anna").unwrap();
        assert_eq!(sent(&mut own).await, [false, false, true]);
    }

    /// From a client that takes no answers nothing more is read, so what waits for it is little; nor is it waited for longer
    /// than a Stop behind it can wait.
    #[tokio::test(start_paused = true)]
    async fn answers_that_are_not_taken_are_few() {
        let (mut reader, mut waiting) = reader(ANSWERS_MAX);
        let stop = || Said::Stop { id: Id::default(), monitor: Some("M9".into()), of: None };
        let began = Instant::now();
        let mut heeded = 0;
        while heeded < 1000 && !reader.full {
            reader.heed(stop()).await;
            heeded += 1;
        }
        assert_eq!((heeded, began.elapsed()), (ANSWERS_MAX + 1, TAKEN));
        // Each that is taken in time makes room for one.
        reader.full = false;
        assert!(waiting.recv().await.is_some());
        reader.heed(stop()).await;
        assert!(!reader.full && began.elapsed() == TAKEN);
        // One of a slow line is waited for.
        let takes = async {
            sleep(TAKEN / 2).await;
            waiting.recv().await
        };
        let (taken, ()) = tokio::join!(takes, reader.heed(stop()));
        assert!(taken.is_some() && !reader.full);
    }

    /// Sixty-four Stops wait for their monitors: the client is there, and takes its answers. Once it does not, or its
    /// connection is closed, there is no answer to wait for.
    #[tokio::test(start_paused = true)]
    async fn a_stop_waits_for_its_answer_only_as_long_as_answers_are_taken() {
        let (mut reader, mut waiting) = reader(1);
        let held = reader.urgent_room.clone().acquire_owned().await.unwrap();
        assert!(timeout(TAKEN * 10, reader.turn()).await.is_err(), "a monitor is waited for");
        assert!(!reader.full);
        reader.answer(Id::default(), Err(ApiError::not_found())).await;
        assert!(timeout(TAKEN * 10, reader.turn()).await.unwrap().is_none());
        assert!(reader.full);
        reader.close();
        let began = Instant::now();
        assert!(reader.turn().await.is_none() && began.elapsed() == Duration::ZERO);
        reader.rest = None;
        drop((held, waiting.recv().await));
        assert!(reader.turn().await.is_some());
    }

    /// What was sent before a connection was closed, and a Stop behind it.
    #[tokio::test(start_paused = true)]
    async fn what_is_left_of_a_connection_is_passed_over_in_time_and_not_at_once() {
        let (mut reader, _waiting) = reader(1);
        while lock(&reader.talk.messages).take(reader.hub.now()).is_ok() {}
        reader.close();
        let began = Instant::now();
        // As many pings as the system keeps of a connection.
        for _ in 0..128 * 1024 / 6 {
            assert!(matches!(reader.count().await, Counted::Passed));
        }
        let took = began.elapsed();
        assert!(took > SLOW / 2 && took < SLOW, "{took:?}");
    }

    /// Who has said too much is still there: the pong of a ping of ours does not end the connection.
    #[tokio::test(start_paused = true)]
    async fn pongs_that_were_asked_for_cost_nothing() {
        let (reader, _waiting) = reader(1);
        let pong = ws::Message::Pong(Vec::new().into());
        while lock(&reader.talk.messages).take(reader.hub.now()).is_ok() {}
        for _ in 0..3 {
            reader.pings.unanswered.store(true, Ordering::Relaxed);
            assert!(reader.was_asked_for(&pong));
            assert!(!reader.was_asked_for(&ws::Message::Ping(Vec::new().into())));
            assert!(!reader.was_asked_for(&pong), "one pong for each ping");
            assert!(matches!(reader.count().await, Counted::Over));
        }
    }

    #[tokio::test]
    async fn what_is_invented_is_not_remembered() {
        let (mut reader, _waiting) = reader(1);
        for number in 0..1000 {
            let drive = format!("Drive{number}");
            let beat =
                JogBeat { drive, toward: Some("max".into()), t: None, up_ms: None, end: false };
            reader.beat(format!("M{number}"), &beat);
            reader.beat(format!("M{number}"), &JogBeat { drive: "Vertical".into(), ..beat });
            reader.watch(&[format!("M{number}")]);
        }
        assert!(reader.told.is_empty() && reader.watching.is_empty());
    }
}
