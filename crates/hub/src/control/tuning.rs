//! The tuning of a drive (ours, §D/9) for a client that holds the monitor: [`lafet_client::tune`] with the
//! hub's authority, audit log and dead-man.
//!
//! ```text
//!            tune                 all moves done
//!  (nothing) ────▶ running ─────────────────────▶ rest, values as before ─▶ done
//!                    │ Stop of any client, another command, a motion by hand,
//!                    │ authority or connection lost, no beat for LAPSE, water
//!                    └─────────────────────────▶ Stop, rest, values as before ─▶ ended
//! ```
//!
//! What was measured is published; the client sets it like any other parameter. What the tuning puts out of
//! force is noted on the disk first: a hub that was killed puts it back when the monitor is connected again.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use lafet_client::tune::kept::{self, Kept, Note};
use lafet_client::tune::{self, Bench, Judged, Look, Pair, Trouble, Tuned, Tuning};
use lafet_client::{Answers, Client, Monitor, SystemError};
use lafet_proto::request::Body;
use lafet_proto::{Ints, ParamId, Request, RequestId, SubsystemId};
use lafet_texts::{Shown, Text as _, hub as text};
use serde::Serialize;
use tokio::time::{Instant, sleep};
use utoipa::ToSchema;

use crate::access::Role;
use crate::command::request::MonitorRequest;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::program;
use crate::monitor::station::Station;
use crate::plugs::orders::AXES;
use crate::sync::lock;
use crate::text::Both;
use crate::words::SavedWord;

/// How the audit log names the source of these requests.
pub const TUNE: &str = "tune";
/// Without a beat of its client for so long a tuning ends.
const LAPSE: Duration = Duration::from_secs(2);
/// Pause between two looks.
const LOOK: Duration = Duration::from_millis(100);
/// A request that was accepted shows in the state within this time.
const START: Duration = Duration::from_secs(1);
/// For so long a drive that does not rest is stopped again, and values are written back.
const INSIST: Duration = Duration::from_secs(10);
/// Pause between these attempts.
const AGAIN: Duration = Duration::from_millis(500);

/// The tuning that runs at a monitor.
#[derive(Debug)]
pub struct Running {
    /// The session that has started it.
    seat: String,
    beat: Instant,
    /// Its client wants it to end.
    ends: bool,
}

/// How often others than a tuning have moved each drive, by its place in [`AXES`].
#[derive(Debug, Default)]
pub struct Begun([AtomicU64; 3]);

impl Begun {
    /// Others have moved a drive.
    pub fn moved(&self, drive: SubsystemId) {
        self.count(|it| it == drive);
    }

    /// A request of others was accepted.
    pub fn accepted(&self, caller: &Caller, request: &MonitorRequest) {
        match request.id() {
            _ if caller.via == TUNE => {}
            RequestId::MOVE => self.moved(request.buf().to()),
            RequestId::DEPLOY | RequestId::WRAP => self.count(|_| true),
            id if program::begins(id) => self.count(|_| true),
            _ => {}
        }
    }

    fn count(&self, of: impl Fn(SubsystemId) -> bool) {
        let drives = AXES.into_iter().zip(&self.0).filter(|(drive, _)| of(*drive));
        drives.for_each(|(_, count)| _ = count.fetch_add(1, Ordering::SeqCst));
    }

    fn of(&self, drive: SubsystemId) -> u64 {
        let mut drives = AXES.into_iter().zip(&self.0);
        let count = drives.find(|(it, _)| *it == drive).map(|(_, count)| count);
        count.map(|it| it.load(Ordering::SeqCst)).unwrap_or_default()
    }
}

/// A tuning, as the topic `tune` has it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = Tune)]
pub struct TuneView {
    /// Name of the drive.
    pub drive: String,
    /// User who started it.
    pub by: String,
    /// `running`, `done` or `ended` before its end.
    pub state: TuneWord,
    /// Moves that are done.
    pub done: usize,
    /// Moves in total; 0: the first one has not started.
    pub total: usize,
    /// Values before.
    #[schema(required)]
    pub before: Option<TunePair>,
    /// Values measured; they are not in force.
    #[schema(required)]
    pub found: Option<TunePair>,
    /// Greatest distance from the target at rest with the measured values, arc-minutes; the nozzle mm.
    #[schema(required)]
    pub error: Option<i32>,
    /// Whether the values before are in force again.
    pub restored: bool,
    /// Why it has ended.
    #[schema(required)]
    pub text: Option<Both>,
    /// Date of the last change of the state, ms since 1970.
    pub at_ms: u64,
}

impl TuneView {
    /// Nothing is moved or set yet.
    fn new(drive: SubsystemId, caller: &Caller, at_ms: u64) -> Self {
        Self {
            drive: drive.to_string(),
            by: caller.principal.user.clone(),
            state: TuneWord::Running,
            done: 0,
            total: 0,
            before: None,
            found: None,
            error: None,
            restored: true,
            text: None,
            at_ms,
        }
    }
}

/// How far a tuning is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum TuneWord {
    /// The drive is being measured.
    Running,
    /// It was measured.
    Done,
    /// It was not measured to the end.
    Ended,
}

/// StopLag and MinSpeed of a drive, as on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct TunePair {
    /// StopLag, ms.
    pub stop_lag: i32,
    /// MinSpeed, in its own unit.
    pub min_speed: i32,
}

impl From<Pair> for TunePair {
    fn from(pair: Pair) -> Self {
        Self { stop_lag: pair.lag_ms, min_speed: pair.min_tenths }
    }
}

impl Hub {
    /// Begins to measure a drive. The client has to send beats until it has ended.
    pub fn tune(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        drive: &str,
    ) -> Result<(), ApiError> {
        let drive = SubsystemId::from_name(drive).filter(|drive| tune::DRIVES.contains(drive));
        let drive = drive.ok_or_else(|| ApiError::bad_request(text::TuneDrives.words()))?;
        let caller = Caller { via: TUNE, ..caller.clone() };
        if caller.principal.role < Role::Engineer || !caller.principal.is_good() {
            return Err(ApiError::role(Role::Engineer));
        }
        station.refuse_while_updated(&caller)?;
        let mut authority = lock(&station.authority);
        let held = authority.command(self.now(), &caller.seat.seat);
        held.map_err(|refusal| ApiError::authority(station.id(), refusal))?;
        drop(authority);
        let monitor = Monitor::new(station.client()?);
        let mut running = lock(&station.tuning);
        if running.is_some() {
            return Err(ApiError::bad_request(text::TuneRunning.words()));
        }
        let seat = caller.seat.seat.clone();
        *running = Some(Running { seat, beat: Instant::now(), ends: false });
        drop(running);
        let view = TuneView::new(drive, &caller, self.clock().now_ms());
        let interrupted = station.interrupted.load(Ordering::SeqCst);
        let begun = station.begun.of(drive);
        let (hub, station) = (self.clone(), station.clone());
        let bench = Held { hub, caller, station, monitor, interrupted, begun, view, ending: false };
        bench.publish();
        tokio::spawn(bench.run(drive));
        Ok(())
    }
}

impl Station {
    /// The client is still there; `false`: nothing of it runs.
    pub fn beat_tuning(&self, seat: &str, ends: bool) -> bool {
        let mut running = lock(&self.tuning);
        let own = running.as_mut().filter(|running| running.seat == seat);
        own.is_some_and(|running| {
            running.beat = Instant::now();
            running.ends |= ends;
            true
        })
    }

    /// A command or motion of others: a tuning does not go on after it.
    pub fn interrupt_tuning(&self, caller: &Caller) {
        if caller.via != TUNE {
            self.interrupted.fetch_add(1, Ordering::SeqCst);
        }
    }
}

/// Folder of the notes, in that of the data.
const NOTES: &str = "tune";

/// The note of a monitor: what a tuning has put out of force. Without a folder for data there is none.
fn note_of(hub: &Hub, station: &Station) -> Option<Note> {
    let data = hub.config().data.as_ref()?;
    Some(Note::new(&data.join(NOTES), station.id()))
}

/// Puts back what a tuning has left in the monitor, if the hub was killed in the middle of it.
pub async fn put_back(hub: &Hub, station: &Arc<Station>, client: &Client) {
    let Some(note) = note_of(hub, station) else { return };
    // What is set on trial is not stored. After an update all is read again.
    if station.is_updated() {
        return;
    }
    {
        let mut running = lock(&station.tuning);
        if running.is_some() {
            return;
        }
        let seat = Caller::hub().seat.seat;
        *running = Some(Running { seat, beat: Instant::now(), ends: true });
    }
    // The note is read when no tuning runs: one that runs is entitled to the values it has set.
    let done = match note.read() {
        Ok(Some(kept)) => {
            Some(Held::former(hub, station, client, &kept).put_back(&note, &kept).await)
        }
        Ok(None) => None,
        Err(error) => Some(
            text::TuneNoteBad {
                file: &note.file().display().to_string(),
                error: SystemError(&error),
            }
            .words(),
        ),
    };
    lock(&station.tuning).take();
    if let Some(text) = done {
        hub.event(Some(station.id()), &text);
    }
}

/// Why a tuning has ended.
#[derive(Debug)]
struct Ended(Both);

impl From<Trouble> for Ended {
    fn from(trouble: Trouble) -> Self {
        Self(trouble.words())
    }
}

impl From<&lafet_client::Error> for Ended {
    fn from(error: &lafet_client::Error) -> Self {
        Self(error.words())
    }
}

impl From<ApiError> for Ended {
    fn from(error: ApiError) -> Self {
        Self(*error.text)
    }
}

/// A drive that is tuned for a client.
struct Held {
    hub: Hub,
    caller: Caller,
    station: Arc<Station>,
    monitor: Monitor,
    /// The number of interruptions at its beginning.
    interrupted: u64,
    /// How often others had moved the drive by then.
    begun: u64,
    view: TuneView,
    /// Nothing moves any more: values are written back.
    ending: bool,
}

impl Held {
    /// For the values that a former hub has set.
    fn former(hub: &Hub, station: &Arc<Station>, client: &Client, kept: &Kept) -> Self {
        let view = TuneView {
            before: Some(kept.before.into()),
            state: TuneWord::Ended,
            restored: false,
            ..TuneView::new(kept.drive, &Caller::hub(), hub.clock().now_ms())
        };
        Self {
            hub: hub.clone(),
            caller: Caller { via: TUNE, ..Caller::hub() },
            station: station.clone(),
            monitor: Monitor::new(client.clone()),
            interrupted: station.interrupted.load(Ordering::SeqCst),
            begun: station.begun.of(kept.drive),
            view,
            ending: true,
        }
    }

    async fn put_back(mut self, note: &Note, kept: &Kept) -> Both {
        let drive = Shown(kept.drive);
        let text = match kept::put_back(&mut self, kept).await {
            Ok(_) => {
                self.view.restored = note.remove().is_ok();
                text::TunePutBack { drive }.words()
            }
            Err(Ended(error)) => text::TuneNotPutBack { drive, error: &error }.words(),
        };
        self.view.text = Some(text.clone());
        self.publish();
        text
    }

    async fn run(mut self, drive: SubsystemId) {
        let tuned = self.tune(drive).await;
        match tuned {
            Ok(tuned) => {
                self.view.found = Some(tuned.found.into());
                self.view.error = tuned.errors.iter().copied().max();
                self.view.state = TuneWord::Done;
            }
            Err(Ended(text)) => {
                self.view.text = Some(text);
                self.view.state = TuneWord::Ended;
            }
        }
        self.view.at_ms = self.hub.clock().now_ms();
        lock(&self.station.tuning).take();
        self.publish();
        self.station.reread.notify_one();
    }

    async fn tune(&mut self, drive: SubsystemId) -> Result<Tuned, Ended> {
        let limits = self.monitor.limits(drive).await.map_err(|error| Ended::from(&error))?;
        let mut tuning = Tuning::new(self, drive, limits).await?;
        self.view.before = Some(tuning.before().into());
        self.view.restored = false;
        let tuned = tuning.measure(self).await;
        self.ending = true;
        if tuned.is_err() {
            self.rest(drive).await;
        }
        let until = Instant::now() + INSIST;
        let mut written = tune::write(self, drive, tuning.before()).await;
        while written.is_err() && Instant::now() < until {
            sleep(AGAIN).await;
            written = tune::write(self, drive, tuning.before()).await;
        }
        self.view.restored = self.has(drive, tuning.before()).await;
        if let Err(Ended(error)) = &written {
            let text = text::TuneNotWrittenBack { drive: Shown(drive), error }.words();
            self.hub.event(Some(self.station.id()), &text);
        }
        // One that stays is used when the monitor is next connected.
        if written.is_ok()
            && self.view.restored
            && let Some(note) = note_of(&self.hub, &self.station)
        {
            _ = note.remove();
        }
        tuned
    }

    /// Writes a value of before back, and waits until it is stored: the monitor has those of the measurement in its
    /// memory, and would have them again after a loss of power. It does so even if another client holds the monitor by now.
    async fn write_back(&self, request: MonitorRequest) -> Result<(), Ended> {
        let outcome = self.hub.save(&Caller::hub(), &self.station, request).await?;
        match outcome.saved {
            Some(SavedWord::WriteFailed) => Err(Ended(text::TuneNotStored.words())),
            // As for `lafet tune`: many monitors never confirm it.
            Some(SavedWord::Stored | SavedWord::Unconfirmed) | None => Ok(()),
        }
    }

    /// Whether these values are in force.
    async fn has(&mut self, drive: SubsystemId, pair: Pair) -> bool {
        let lag_ms = self.param(drive, tune::STOP_LAG).await.ok();
        let min_tenths = self.param(drive, tune::MIN_SPEED).await.ok();
        (lag_ms, min_tenths) == (Some(pair.lag_ms), Some(pair.min_tenths))
    }

    /// Stops the drive, again if need be, and as long as nothing else has moved it since: what a person has started is not
    /// ended, nor is its rest that of the tuning.
    async fn rest(&mut self, drive: SubsystemId) {
        let Ok(stop) = MonitorRequest::stop(drive) else { return };
        let (until, mut first, mut last) = (Instant::now() + INSIST, true, None);
        while Instant::now() < until {
            let (hub, station) = (&self.hub, &self.station);
            let own = || station.begun.of(drive) == self.begun;
            let sent = match std::mem::take(&mut first) {
                true => own().then(|| hub.overtake(&self.caller, station, &stop).0),
                false => hub.overtake_while(station, &stop, own),
            };
            let Some(mut sent) = sent else { return };
            _ = sent.result().await;
            sleep(AGAIN).await;
            let look = self.look(drive).await.ok().filter(|look| !look.moves);
            let position = look.map(|look| look.position);
            // One that follows late runs out after it is no longer fed.
            if position.is_some() && position == last {
                return;
            }
            last = position;
        }
    }

    /// Why it must not go on.
    fn goes_on(&self) -> Result<(), Ended> {
        let running = lock(&self.station.tuning);
        let (beat, ends) = running.as_ref().map_or((None, true), |it| (Some(it.beat), it.ends));
        drop(running);
        if self.station.interrupted.load(Ordering::SeqCst) != self.interrupted {
            return Err(Ended(text::TuneInterrupted.words()));
        }
        if ends {
            return Err(Ended(text::TuneEnded.words()));
        }
        if !lock(&self.station.authority).is_present(&self.caller.seat.seat) {
            return Err(Ended(text::TuneAuthorityLost.words()));
        }
        if beat.is_none_or(|beat| beat.elapsed() > LAPSE) {
            return Err(Ended(text::TunePageGone.words()));
        }
        Ok(())
    }

    /// Sends a request, and waits for its answer.
    async fn send(&self, request: &Request<'_>) -> Result<(), Ended> {
        let request = MonitorRequest::new(request)?;
        if request.need().urgent {
            let (mut joined, _) = self.hub.overtake(&self.caller, &self.station, &request);
            joined.result().await?;
            return Ok(());
        }
        let (station, interrupted) = (self.station.clone(), self.interrupted);
        let valid = move || station.interrupted.load(Ordering::SeqCst) == interrupted;
        self.hub.command_while(&self.caller, &self.station, request, Arc::new(valid)).await?;
        Ok(())
    }

    fn publish(&self) {
        self.station.publish_tune(&self.hub, &self.view);
    }
}

impl Bench for Held {
    type Error = Ended;

    async fn param(&mut self, drive: SubsystemId, name: &'static str) -> Result<i32, Ended> {
        let values = self.monitor.param(drive, name).await.map_err(|error| Ended::from(&error))?;
        Ok(values.first().copied().unwrap_or_default())
    }

    async fn set_param(
        &mut self,
        drive: SubsystemId,
        name: &'static str,
        value: i32,
    ) -> Result<(), Ended> {
        let (id, values) = (ParamId::of(name), [value]);
        let request = Request::new(drive, Body::SetParam { id, values: Ints::Values(&values) });
        if self.ending {
            return self.write_back(MonitorRequest::new(&request)?).await;
        }
        self.goes_on()?;
        // One of the measurement is in force for seconds: that it is stored is not waited for.
        self.send(&request).await
    }

    async fn keep(&mut self, kept: &Kept) -> Result<(), Ended> {
        let Some(note) = note_of(&self.hub, &self.station) else { return Ok(()) };
        let kept = kept.clone();
        let written = tokio::task::spawn_blocking(move || note.write(&kept)).await;
        let written = written.unwrap_or_else(|_| Err(io::ErrorKind::Other.into()));
        written.map_err(|error| Ended(text::TuneNotNoted { error: SystemError(&error) }.words()))
    }

    async fn look(&mut self, drive: SubsystemId) -> Result<Look, Ended> {
        let watched = tune::watched(drive).map(|who| Request::new(who, Body::GetStatus));
        let answers = self.monitor.client().batch(&watched).await;
        let answers: Result<Vec<Answers>, _> = answers.into_iter().collect();
        let answers = answers.map_err(|error| Ended::from(&error))?;
        Ok(Look::of(drive, answers.iter().flat_map(|answers| answers.iter()))?)
    }

    async fn follow(
        &mut self,
        drive: SubsystemId,
        request: Request<'static>,
        mut judge: impl FnMut(&Look) -> Judged + Send,
    ) -> Result<Look, Ended> {
        self.goes_on()?;
        self.send(&request).await?;
        let (began, mut running) = (Instant::now(), false);
        loop {
            self.goes_on()?;
            let look = self.look(drive).await?;
            match judge(&look) {
                Judged::Done => return Ok(look),
                Judged::Running => running = true,
                Judged::Ended(trouble) => return Err(trouble.into()),
                Judged::Idle(trouble) if running || began.elapsed() > START => {
                    return Err(trouble.into());
                }
                Judged::Idle(_) => {}
            }
            sleep(LOOK).await;
        }
    }

    fn progress(&mut self, done: usize, total: usize) {
        (self.view.done, self.view.total) = (done, total);
        self.publish();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A monitor that no connection reaches: no Stop is confirmed, and each is repeated for ten seconds.
    async fn stops(moved: Option<&str>) -> u64 {
        let (hub, station) = Hub::of_one(None);
        let drive = SubsystemId::VERTICAL;
        let caller = Caller { via: TUNE, ..Caller::hub() };
        let view = TuneView::new(drive, &caller, 0);
        let (ours, _theirs) = lafet_client::transport::memory::pair();
        let client = Client::over("sim:", ours, lafet_client::Config::default());
        let mut held = Held {
            hub: hub.clone(),
            monitor: Monitor::new(client),
            interrupted: 0,
            begun: station.begun.of(drive),
            station: station.clone(),
            caller: caller.clone(),
            view,
            ending: true,
        };
        let meanwhile = async {
            let request = moved.map(|it| MonitorRequest::parse(it).unwrap());
            let own = async |caller: &Caller, time| {
                request.iter().for_each(|it| station.begun.accepted(caller, it));
                let before = station.urgent_counts().stop;
                sleep(time).await;
                station.urgent_counts().stop - before
            };
            sleep(AGAIN).await;
            assert!(own(&caller, INSIST / 2).await > 0, "what a tuning itself has moved");
            own(&Caller::hub(), INSIST).await
        };
        let ((), stops) = tokio::join!(held.rest(drive), meanwhile);
        stops
    }

    /// Assumed: the drive does not stop, and meanwhile others take the monitor and move it.
    #[tokio::test(start_paused = true)]
    async fn what_others_have_begun_is_not_stopped_by_a_tuning_that_ends() {
        for (moved, goes_on) in [
            (None, true),
            (Some("Move Horizontal 60"), true),
            (Some("Open Valve1"), true),
            (Some("Move Vertical 60"), false),
            (Some("Deploy Deployer"), false),
            (
                Some("StartQuench Control centre=0,0 nozzle=60 sector=600,300 step=1 distance=30"),
                false,
            ),
        ] {
            let stops = stops(moved).await;
            assert_eq!(stops > 0, goes_on, "{moved:?}: {stops}");
        }
    }
}
