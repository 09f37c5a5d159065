//! One run: each monitor is checked, locked out, updated and released.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_client::update::{
    Before, Choice, Dotted, Image, Kept, Pace, Stage, Trial, UpdateError, Updated, Word, Wordless,
    choose, is_of_others, is_over,
};
use lafet_client::{Monitor, SystemError};
use lafet_proto::flags::GeneralFlags;
use lafet_proto::update::{Phase, Report};
use lafet_proto::{Request, SubsystemId};
use lafet_texts::{Text as _, hub as text};
use tokio::runtime::{Handle, RuntimeFlavor};
use tokio::sync::watch;
use tokio::task::block_in_place;
use tokio::time::{Instant, interval, sleep};

use super::hold::Hold;
use super::ready::{alarmed, at_rest, joined, missing};
use super::view::{MonitorUpdate, MonitorWord};
use crate::command::request::MonitorRequest;
use crate::command::withdrawn::Accepted;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::owner::link_of;
use crate::monitor::station::Station;
use crate::store::Act;
use crate::sync::lock;
use crate::text::Both;

/// Whether a run may go on is looked at this often.
const LOOK: Duration = Duration::from_millis(250);
/// Pause before a monitor is asked again.
const AGAIN: Duration = Duration::from_millis(500);
/// A lockout is repeated so often until it is stored.
const LOCKS: u64 = 20;
/// Longest time in which valves close after a lockout.
const CLOSES: Duration = Duration::from_secs(15);
/// A lockout is released, and shows to be, within this time.
const RELEASES: Duration = Duration::from_secs(10);

/// A run.
#[derive(Debug)]
pub struct Run {
    /// The hub.
    pub hub: Hub,
    /// Who has started it, with the session of updates.
    pub caller: Caller,
    /// One image, or one for each slot.
    pub images: Vec<Image>,
    /// How much of the line's time it takes; `None`: as the line is shared.
    pub pace: Option<Pace>,
    /// Who has stopped it.
    pub stopped: watch::Receiver<Option<String>>,
}

/// Why the update of a monitor has ended, and with it the run.
#[derive(Debug)]
enum Why {
    /// Its update has failed.
    Failed(Both),
    /// The run may not go on.
    Ended(Both),
}

impl From<ApiError> for Why {
    fn from(error: ApiError) -> Self {
        Self::Failed(*error.text)
    }
}

/// What an update has come to.
struct Came {
    /// The version before; `None`: it was on trial already.
    from: Option<[u16; 4]>,
    to: [u16; 4],
    /// It ran already.
    same: bool,
    /// What is left to be done.
    left: Option<Both>,
}

/// A lockout that the run has set itself.
struct Lockout {
    /// The request that releases it.
    off: MonitorRequest,
    /// It is void as soon as another client locks the monitor out.
    accepted: Accepted,
}

impl Run {
    /// Updates the monitors; why it has ended before it was done.
    pub async fn go(self, stations: Vec<Arc<Station>>) -> Option<Both> {
        for (at, station) in stations.iter().enumerate() {
            let turn = Turn::new(&self, at, station);
            match turn.take().await {
                Ok(()) => {}
                Err(Why::Ended(why)) => return Some(why),
                Err(Why::Failed(_)) => {
                    let monitor = station.id();
                    return Some(text::UpdatesFailedAt { monitor }.words());
                }
            }
        }
        None
    }

    /// Which share of a line an update takes: others wait where several monitors have one line.
    fn pace(&self, station: &Station) -> Pace {
        let link = link_of(&station.config.endpoint);
        let on_it = |it: &&Arc<Station>| link_of(&it.config.endpoint) == link;
        self.pace.unwrap_or_else(|| match self.hub.stations().iter().filter(on_it).count() {
            2.. => Pace::SHARED,
            _ => Pace::usual(&station.config.endpoint),
        })
    }
}

/// The turn of a monitor.
struct Turn<'a> {
    run: &'a Run,
    hub: &'a Hub,
    /// Its place in the run.
    at: usize,
    station: &'a Arc<Station>,
    far: Mutex<Far>,
    /// The run has locked it out, and not released it.
    locked: AtomicBool,
}

/// How far the update of a monitor is, for what follows if it ends there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Far {
    /// Nothing was sent.
    Nothing,
    /// Data were sent.
    Sent,
    /// The image is committed: it is on trial, or about to be.
    OnTrial,
    /// One of the images runs, confirmed.
    Confirmed,
}

impl<'a> Turn<'a> {
    fn new(run: &'a Run, at: usize, station: &'a Arc<Station>) -> Self {
        let (far, locked) = (Mutex::new(Far::Nothing), AtomicBool::new(false));
        Self { run, hub: &run.hub, at, station, far, locked }
    }

    fn show(&self, change: impl FnOnce(&mut MonitorUpdate)) {
        self.hub.updating().show(self.hub, self.at, false, change);
    }

    fn is_now(&self, state: MonitorWord) {
        self.show(|it| it.state = state);
    }

    /// Updates the monitor, and reports what came of it.
    async fn take(&self) -> Result<(), Why> {
        // Before it begins the monitor is not the reason.
        self.may_go_on().map_err(Why::Ended)?;
        self.is_now(MonitorWord::Checking);
        let came = self.update().await;
        let failed = match &came {
            Ok(came) => {
                self.came(came);
                return Ok(());
            }
            Err(Why::Failed(why)) => (why.clone(), None),
            Err(Why::Ended(why)) => (why.clone(), self.follows()),
        };
        let stays = self.locked.load(Ordering::SeqCst).then(|| text::UpdatesLockoutStays.words());
        let (why, follows) = failed;
        let text = joined(&[why].into_iter().chain(follows).chain(stays).collect::<Vec<_>>());
        self.note("failed", (None, None), Some(text.clone()));
        self.hub.event(Some(self.station.id()), &text::UpdatesEventFailed { why: &text }.words());
        self.show(|it| (it.state, it.text) = (MonitorWord::Failed, Some(text)));
        came.map(drop)
    }

    /// What the monitor does when nothing more is sent.
    fn follows(&self) -> Option<Both> {
        match *lock(&self.far) {
            Far::Nothing => None,
            Far::Sent => Some(text::UpdatesGoesOn.words()),
            Far::OnTrial => Some(text::UpdatesGoesBack.words()),
            Far::Confirmed => Some(text::UpdatesConfirmedYet { to: &self.version() }.words()),
        }
    }

    /// The version of the images.
    fn version(&self) -> String {
        self.run.images.first().map(|it| dotted(it.version())).unwrap_or_default()
    }

    fn came(&self, came: &Came) {
        let (from, to) = (came.from.map(dotted), dotted(came.to));
        let event = match (&from, came.same) {
            (_, true) => None,
            (Some(from), _) => Some(text::UpdatesEventDone { from, to: &to }.words()),
            (None, _) => Some(text::UpdatesEventConfirmed { to: &to }.words()),
        };
        if let Some(event) = event {
            self.hub.event(Some(self.station.id()), &event);
        }
        let (state, outcome) = match came.same {
            true => (MonitorWord::Same, "same"),
            false => (MonitorWord::Done, "Ok"),
        };
        self.note(outcome, (from.clone(), Some(to.clone())), came.left.clone());
        self.show(|it| {
            (it.state, it.stage, it.left_s) = (state, None, None);
            (it.from, it.to, it.text) = (from, Some(to), came.left.clone());
        });
    }

    /// Notes what came of it in the audit log.
    fn note(
        &self,
        outcome: &str,
        (from, to): (Option<String>, Option<String>),
        text: Option<Both>,
    ) {
        let version = self.version();
        let what = format!("update to {version}");
        let record = self.hub.record(&self.run.caller, self.station.id(), &what, outcome);
        let act = Act::UpdateMonitor { version, from, to, text };
        drop(self.hub.audit().note(record.about(&act)));
    }

    async fn update(&self) -> Result<Came, Why> {
        let monitor = Monitor::new(self.station.client()?);
        let report = self.unless_ended(monitor.software()).await?.map_err(of_client)?;
        if !report.trial {
            self.show(|it| it.from = Some(dotted(report.version)));
        }
        if self.runs_already(&report) {
            let (from, to) = (Some(report.version), report.version);
            return Ok(Came { from, to, same: true, left: None });
        }
        let _hold = Hold::take(self.hub, &self.run.caller, self.station)?;
        let lockout = self.lock_out(&monitor).await?;
        self.is_now(MonitorWord::Updating);
        let report = self.unless_ended(monitor.software()).await?.map_err(of_client)?;
        let (kept, fresh) = self.word(&report).await?;
        let ended = self.unless_ended(self.send(&monitor, &kept, fresh)).await?;
        let elsewhere = fresh && is_of_others(&report, &ended);
        if is_over(&ended) || elsewhere {
            self.forget_word().await;
        }
        if elsewhere {
            return Err(self.wordless(Wordless::Elsewhere));
        }
        let came = match ended {
            Ok(Updated { from, to }) => {
                let from = Some(from).filter(|_| !report.trial && from != to);
                Came { from, to, same: false, left: None }
            }
            Err(UpdateError::AlreadyRunning(version)) => {
                Came { from: Some(version), to: version, same: true, left: None }
            }
            Err(error) => return Err(Why::Failed(error.words())),
        };
        *lock(&self.far) = Far::Confirmed;
        let left = match lockout {
            Some(lockout) => self.release(lockout, came.to).await?,
            None => None,
        };
        Ok(Came { left, ..came })
    }

    /// Whether one of the images runs, confirmed, and nothing else is under way.
    fn runs_already(&self, report: &Report) -> bool {
        let Report { trial, waits, pending, phase, .. } = *report;
        let rests = !trial && !waits && !pending && phase != Phase::COMMITTED;
        rests && self.run.images.iter().any(|it| it.version() == report.version)
    }

    /// Locks the monitor out, if that is not so already and nothing else is missing; returns what the run has set.
    async fn lock_out(&self, monitor: &Monitor) -> Result<Option<Lockout>, Why> {
        let off = MonitorRequest::new(&Request::lockout(false))?;
        // Before the state is read: what others set later is theirs.
        let Accepted(before) = self.station.accepts(&off);
        let status = self.unless_ended(monitor.status_all()).await?;
        let status = status.map_err(|error| Why::Failed(error.words()))?;
        let missing = missing(self.hub, self.station, &status);
        if !missing.is_empty() {
            return Err(Why::Failed(joined(&missing)));
        }
        let general = status.general.map(|it| it.flags);
        if general.is_some_and(|flags| flags.contains(GeneralFlags::LOCKED_OUT)) {
            return Ok(None);
        }
        self.is_now(MonitorWord::Locking);
        let own = self.set_lockout().await?;
        self.is_at_rest(monitor).await?;
        Ok(Some(Lockout { off, accepted: Accepted(before + own) }))
    }

    /// Sends Lockout until it is stored; how often.
    async fn set_lockout(&self) -> Result<u64, Why> {
        let request = MonitorRequest::lockout()?;
        for sent in 1..=LOCKS {
            self.may_go_on().map_err(Why::Ended)?;
            // For the wire alone: no hand has said no to the zones.
            let (mut joined, _) = self.hub.overtake(&self.run.caller, self.station, &request);
            self.locked.store(true, Ordering::SeqCst);
            let outcome = joined.result().await.map_err(|error| {
                Why::Failed(text::UpdatesNotLocked { error: &*error.text }.words())
            })?;
            let general = SubsystemId::GENERAL.to_string();
            if outcome.answers.iter().any(|it| it.from == general && it.status == "Ok") {
                return Ok(sent);
            }
            sleep(AGAIN).await;
        }
        Err(Why::Failed(text::UpdatesLockoutNotStored.words()))
    }

    /// Waits until the valves that a lockout closes are closed.
    async fn is_at_rest(&self, monitor: &Monitor) -> Result<(), Why> {
        let since = Instant::now();
        loop {
            let status = self.unless_ended(monitor.status_all()).await?;
            let missing = match status {
                Ok(status) => at_rest(&status),
                Err(error) => vec![error.words()],
            };
            match missing.is_empty() {
                true => return Ok(()),
                false if since.elapsed() >= CLOSES => return Err(Why::Failed(joined(&missing))),
                false => self.unless_ended(sleep(AGAIN)).await?,
            }
        }
    }

    async fn send(
        &self,
        monitor: &Monitor,
        kept: &Kept,
        fresh: bool,
    ) -> Result<Updated, UpdateError> {
        let restarts = AtomicBool::new(false);
        let told = |stage: Stage| {
            *lock(&self.far) = match stage {
                Stage::Confirmed => Far::Confirmed,
                stage if stage.is_trial() => Far::OnTrial,
                _ => Far::Sent,
            };
            if stage == Stage::Restarting && !restarts.swap(true, Ordering::SeqCst) {
                let event = text::UpdatesEventRestarts { to: &self.version() }.words();
                self.hub.event(Some(self.station.id()), &event);
            }
            let figures = matches!(stage, Stage::Sending { .. });
            self.hub.updating().show(self.hub, self.at, figures, |it| it.is_at(&stage));
        };
        let keep = |before: &Before| {
            let kept = Kept { before: Some(before.clone()), ..kept.clone() };
            aside(|| self.hub.updating().notes().write(&self.station.config.endpoint, &kept))
        };
        let trial = Trial {
            word: &kept.word,
            fresh,
            before: kept.before.as_ref(),
            keep: &keep,
            proven: self.hub.config().proven,
            pace: self.run.pace(self.station),
        };
        monitor.update_with(&self.run.images, &trial, told).await
    }

    /// The word, with what is noted beside it: that of the update which goes on, or a new one, which is on the disk
    /// then. Whether it is new.
    async fn word(&self, report: &Report) -> Result<(Kept, bool), Why> {
        let (hub, endpoint) = (self.hub.clone(), self.station.config.endpoint.clone());
        let noted = at_disk(move || hub.updating().notes().read(&endpoint)).await;
        let choice = choose(report, &self.run.images, &noted).map_err(|why| self.wordless(why))?;
        if let (Choice::Noted(_), Ok(Some(kept))) = (choice, noted) {
            return Ok((kept, false));
        }
        let mut word = Word::default();
        getrandom::fill(&mut word).map_err(|error| {
            let error = error.to_string();
            Why::Failed(text::UpdatesNoRandom { error: &error }.words())
        })?;
        let images = self.run.images.iter().map(Image::digest).collect();
        let (hub, endpoint) = (self.hub.clone(), self.station.config.endpoint.clone());
        let kept = Kept { word, images, before: None };
        let note = kept.clone();
        let written = at_disk(move || hub.updating().notes().write(&endpoint, &note)).await;
        written.map_err(|error| {
            Why::Failed(text::UpdatesWordNotNoted { error: SystemError(&error) }.words())
        })?;
        Ok((kept, true))
    }

    fn wordless(&self, why: Wordless) -> Why {
        Why::Failed(match why {
            Wordless::OtherImage => text::UpdatesOtherImage.words(),
            Wordless::Elsewhere => text::UpdatesSentElsewhere.words(),
            Wordless::Unreadable => {
                let file = self.hub.updating().notes().file(&self.station.config.endpoint);
                text::UpdatesNoteUnreadable { file: &file }.words()
            }
        })
    }

    /// Removes the note. One that stays is of no harm: the next update replaces it.
    async fn forget_word(&self) {
        let (hub, endpoint) = (self.hub.clone(), self.station.config.endpoint.clone());
        let removed = at_disk(move || hub.updating().notes().remove(&endpoint)).await;
        if let Err(error) = removed {
            tracing::warn!(monitor = self.station.id(), %error, "the note of an update stays");
        }
    }

    /// Releases the lockout of the run, unless another client has locked the monitor out meanwhile; what is left to be
    /// done then.
    async fn release(&self, lockout: Lockout, to: [u16; 4]) -> Result<Option<Both>, Why> {
        self.is_now(MonitorWord::Unlocking);
        self.show(|it| it.to = Some(dotted(to)));
        let Lockout { off, accepted } = lockout;
        let since = Instant::now();
        loop {
            self.may_go_on().map_err(Why::Ended)?;
            let (station, confirm) = (self.station, Some(self.station.id()));
            let sent = self.hub.command_accepted(
                &self.run.caller,
                station,
                off.clone(),
                (confirm, false),
                accepted,
            );
            let why = match sent.await {
                Ok(outcome) if outcome.ok => break,
                // Each part of the monitor has answered for itself.
                Ok(_) => text::UpdatesLockoutStays.words(),
                Err(error) if error.code == "void" => {
                    return Ok(Some(text::UpdatesLockoutOfOthers.words()));
                }
                Err(error) => *error.text,
            };
            if since.elapsed() >= RELEASES {
                let to = dotted(to);
                return Err(Why::Failed(text::UpdatesNotReleased { to: &to, error: &why }.words()));
            }
            sleep(AGAIN).await;
        }
        self.locked.store(false, Ordering::SeqCst);
        self.is_seen_released().await;
        Ok(None)
    }

    /// Waits until the hub has a state in which the monitor is back: the next one of its zone needs it.
    async fn is_seen_released(&self) {
        let since = Instant::now();
        while since.elapsed() < RELEASES {
            let status = self.station.status();
            let locked = status.is_set(SubsystemId::GENERAL, "LockedOut");
            if self.station.health() == "up" && !locked {
                return;
            }
            sleep(LOOK).await;
        }
    }

    /// Carries something out as long as the run may go on.
    async fn unless_ended<T>(&self, work: impl Future<Output = T>) -> Result<T, Why> {
        tokio::select! {
            biased;
            why = self.ends() => Err(Why::Ended(why)),
            done = work => Ok(done),
        }
    }

    /// Waits until the run may not go on; why.
    async fn ends(&self) -> Both {
        let (mut stopped, mut shutdown) = (self.run.stopped.clone(), self.hub.shutdown());
        let mut looks = interval(LOOK);
        loop {
            if let Err(why) = self.may_go_on() {
                return why;
            }
            tokio::select! {
                _ = looks.tick() => {}
                () = shutdown.requested() => {}
                // Its sender is there until the run has ended.
                Ok(_) = stopped.wait_for(Option::is_some) => {}
            }
        }
    }

    /// Why the run may not go on.
    fn may_go_on(&self) -> Result<(), Both> {
        let principal = &self.run.caller.principal;
        if let Some(user) = &*self.run.stopped.borrow() {
            return Err(text::UpdatesStopped { user }.words());
        }
        if self.hub.ends() {
            return Err(text::UpdatesHubEnds.words());
        }
        if !self.hub.is_still_good(principal) {
            return Err(text::UpdatesRightsLost { user: &principal.user }.words());
        }
        let same = |it: Arc<Station>| Arc::ptr_eq(&it, self.station);
        if !self.hub.station(self.station.id()).is_ok_and(same) {
            return Err(text::UpdatesMonitorReplaced.words());
        }
        // Before its commit a monitor that is needed can be released at once; after it, nothing is quicker than to go on.
        let may_end = matches!(*lock(&self.far), Far::Nothing | Far::Sent);
        let zone =
            (may_end && self.station.is_updated()).then(|| alarmed(self.hub, self.station.id()));
        zone.flatten().map_or(Ok(()), |zone| Err(text::UpdatesZoneAlarm { zone: &zone }.words()))
    }
}

fn dotted(version: [u16; 4]) -> String {
    Dotted(version).to_string()
}

fn of_client(error: lafet_client::Error) -> Why {
    Why::Failed(UpdateError::from(error).words())
}

/// Does something that waits for the disk, on a thread for that: a run does one such thing at a time.
async fn at_disk<T: Send + 'static>(
    work: impl FnOnce() -> io::Result<T> + Send + 'static,
) -> io::Result<T> {
    let done = tokio::task::spawn_blocking(work).await;
    done.unwrap_or_else(|_| Err(io::ErrorKind::Other.into()))
}

/// Does something that waits for the disk and cannot be awaited: what else its thread has to run does not wait.
fn aside<T>(work: impl FnOnce() -> T) -> T {
    match Handle::try_current().map(|it| it.runtime_flavor()) {
        Ok(RuntimeFlavor::MultiThread) => block_in_place(work),
        _ => work(),
    }
}
