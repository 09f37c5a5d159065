//! One update, from any state to its end.

use std::sync::Arc;
use std::time::Duration;

use lafet_proto::param::Param;
use lafet_proto::update::{DIGEST_LEN, Order, PART_MAX, Phase, Report};
use lafet_proto::{Status, SubsystemId};
use tokio::time::{Instant, sleep};

use super::before::Before;
use super::error::{Change, Unready, UpdateError};
use super::image::Image;
use super::{Given, PATIENCE, PAUSE, Stage, Trial, Updated, digest_of, give, passes};
use crate::error::Error;
use crate::monitor::Monitor;
use crate::status::MonitorStatus;

/// An order is carried out by the next step of the monitor: a pause before it is asked whether it was.
const SOON: Duration = Duration::from_millis(20);
/// Pause between two looks at a monitor that verifies or restarts.
const POLL: Duration = Duration::from_millis(200);
/// An accepted order that waits for longer has not been carried out.
const CARRIED_OUT: Duration = Duration::from_secs(30);
/// No byte more and no other phase for so long: nothing goes on.
const STANDSTILL: Duration = Duration::from_secs(120);
/// Longest time for the hash of a payload: 16 MiB at 512 bytes a step take five and a half minutes.
const HASHING: Duration = Duration::from_secs(600);
/// Longest time from a commit to the restart.
const RESTART: Duration = Duration::from_secs(60);
/// Until then an image on trial that is not as before is given time for its self-tests.
const SELF_TESTS: Duration = Duration::from_secs(30);
/// Longest time for which an image on trial is looked at, on a line that loses much.
const LOOKING: Duration = Duration::from_secs(120);
/// An image on trial that is not heard for so long has not answered all the while: it may have restarted.
const GAP: Duration = Duration::from_secs(10);
/// A monitor that is said to be confirmed, which was not asked for here, is asked once more after so long.
const SURELY: Duration = Duration::from_secs(2);
/// Pause before a trial is ended once more that has not ended.
const AGAIN: Duration = Duration::from_secs(5);
/// Longest time for a confirmation that is answered, but not carried out.
const CONFIRMATION: Duration = Duration::from_secs(60);
/// A trial that is not confirmed ends by itself after 180 s; with the restart.
const TRIAL_MAX: Duration = Duration::from_secs(240);
/// Longest pause for the others after a part without an answer.
const PAUSE_MAX: Duration = Duration::from_secs(10);
/// So often is an order repeated that the report shows not to be carried out.
const TRIES: u32 = 10;
/// So often is a part sent again at once while the one before it waits to be carried out.
const WAITS: u32 = 10;
/// So often is an image brought again after a power cut that lost its commit.
const ROUNDS: u32 = 3;

/// The numbers of reasons that are handled (docs/update.md).
const HASH: u8 = 16;
const FLASH: u8 = 21;

/// What became of an order.
#[derive(Clone, Copy)]
enum Outcome {
    /// It was accepted: the report says what came of it, unless the monitor has restarted since.
    Accepted(Report),
    /// It was not accepted, or the answer is lost: the report shows how far the monitor is.
    Open(Report),
}

impl Outcome {
    const fn report(self) -> Report {
        let (Self::Accepted(report) | Self::Open(report)) = self;
        report
    }

    /// Why the order could not be carried out; 0 if it was, or that is not known.
    const fn reason(self) -> u8 {
        match self {
            Self::Accepted(report) => report.reason,
            Self::Open(_) => 0,
        }
    }
}

/// What is running after a restart.
enum Now {
    /// The image, on trial.
    Trial,
    /// The image, confirmed.
    Confirmed,
    /// The old one, and it has not tried the image: power was lost before the commit was stored.
    Untried,
}

/// How far a transfer has come, and since when it has not come further.
struct Course {
    best: u32,
    phase: Phase,
    since: Instant,
    /// Begins left until there are more bytes than ever.
    begins: u32,
    /// What was received whole was not what was signed.
    rejected: bool,
}

impl Course {
    fn new() -> Self {
        let since = Instant::now();
        Self { best: 0, phase: Phase::IDLE, since, begins: TRIES, rejected: false }
    }

    /// Takes a report.
    ///
    /// # Errors
    ///
    /// [`UpdateError::Stalled`] when nothing goes on.
    fn note(&mut self, report: &Report) -> Result<(), UpdateError> {
        let more = report.received > self.best;
        if more {
            (self.best, self.begins) = (report.received, TRIES);
        }
        if more || report.phase != self.phase {
            (self.phase, self.since) = (report.phase, Instant::now());
        }
        let most = if report.phase == Phase::VERIFYING { HASHING } else { STANDSTILL };
        if self.since.elapsed() >= most { Err(stalled(report)) } else { Ok(()) }
    }
}

const fn stalled(report: &Report) -> UpdateError {
    UpdateError::Stalled { done: report.received, size: report.size }
}

/// The slot that is written while this one is running.
const fn other(slot: u8) -> u8 {
    if slot == 1 { 2 } else { 1 }
}

/// The part of a payload that begins there; `None` at its end.
fn part(payload: &[u8], at: u32) -> Option<&[u8]> {
    let rest = payload.get(at as usize..).filter(|rest| !rest.is_empty())?;
    rest.get(..rest.len().min(PART_MAX))
}

/// Sends one update.
pub(super) struct Sender<'a, F> {
    monitor: &'a Monitor,
    trial: &'a Trial<'a>,
    told: F,
    /// When, and from which byte on, the data are being sent.
    started: Option<(Instant, u32)>,
    /// An image has been committed.
    committed: bool,
    /// The image has answered on trial.
    lived: bool,
}

impl<'a, F: FnMut(Stage)> Sender<'a, F> {
    pub(super) const fn new(monitor: &'a Monitor, trial: &'a Trial<'a>, told: F) -> Self {
        Self { monitor, trial, told, started: None, committed: false, lived: false }
    }

    pub(super) async fn run(mut self, images: &[Image]) -> Result<Updated, UpdateError> {
        match self.update(images).await {
            // It has answered before: this is the new program.
            Err(UpdateError::NoUpdate(status)) if self.committed => Err(UpdateError::Deaf(status)),
            ended => ended,
        }
    }

    async fn update(&mut self, images: &[Image]) -> Result<Updated, UpdateError> {
        let mut report = self.monitor.software().await?;
        if report.waits {
            report = self.settled().await?;
        }
        if report.phase == Phase::COMMITTED {
            // An earlier sender was cut off behind its commit.
            let ours = images.iter().find(|image| image.is_received(&report));
            let target = other(report.slot);
            let from = report.version;
            report = self.restarted().await?;
            if let Some(image) = ours {
                match self.judge(image, target, &report).await? {
                    Now::Trial => return self.finish(image, from).await,
                    Now::Confirmed => return Ok(self.confirmed(image, from)),
                    Now::Untried => {}
                }
            }
        }
        // What is on trial is being replaced, as it has nothing to go back to.
        let replaced = report.phase != Phase::IDLE;
        let awaited = report.trial && !replaced && !self.trial.fresh;
        let running = images.iter().find(|image| image.is_running(&report));
        if let Some(image) = running.filter(|_| awaited) {
            return self.finish(image, report.version).await;
        }
        let same = images.iter().any(|image| image.version() == report.version);
        if same && !report.trial {
            return Err(UpdateError::AlreadyRunning(report.version));
        }
        let target = other(report.slot);
        let image = images.iter().find(|image| image.fits(target));
        let image = image.ok_or(UpdateError::NoImage { slot: target })?;
        self.install(image, target, report.version).await
    }

    /// Brings the image into the other slot, has it tried, and confirms it.
    async fn install(
        &mut self,
        image: &Image,
        target: u8,
        from: [u16; 4],
    ) -> Result<Updated, UpdateError> {
        let digest = digest_of(self.trial.word);
        self.takes_effect().await?;
        for _ in 0..ROUNDS {
            let verified = self.bring(image, &digest).await?;
            let before = Before::new(&self.takes_effect().await?);
            (self.trial.keep)(&before).map_err(|error| UpdateError::Note(Arc::new(error)))?;
            let report = self.commit(image, &digest, &verified).await?;
            match self.judge(image, target, &report).await? {
                Now::Trial => return self.prove(image, from, &before).await,
                Now::Confirmed => return Ok(self.confirmed(image, from)),
                Now::Untried => {}
            }
        }
        Err(UpdateError::Stalled { done: image.size(), size: image.size() })
    }

    /// From a trial that another run has started to the end.
    async fn finish(&mut self, image: &Image, from: [u16; 4]) -> Result<Updated, UpdateError> {
        let before = match self.trial.before {
            Some(before) => before.clone(),
            None => self.composition().await?,
        };
        self.prove(image, from, &before).await
    }

    /// From the trial to the end.
    async fn prove(
        &mut self,
        image: &Image,
        from: [u16; 4],
        before: &Before,
    ) -> Result<Updated, UpdateError> {
        (self.told)(Stage::OnTrial);
        self.lived = true;
        let what = self.check(image, before).await?;
        if !what.is_empty() {
            let back = self.go_back(image).await;
            return Err(UpdateError::Changed { what, back });
        }
        self.confirm(image).await?;
        Ok(self.confirmed(image, from))
    }

    fn confirmed(&mut self, image: &Image, from: [u16; 4]) -> Updated {
        (self.told)(Stage::Confirmed);
        Updated { from, to: image.version() }
    }

    const fn went_back(&self, image: &Image, report: &Report) -> UpdateError {
        let (wanted, running) = (image.version(), report.version);
        UpdateError::WentBack { wanted, running, lived: self.lived }
    }

    /// What runs after the restart that follows a commit.
    async fn judge(&self, image: &Image, target: u8, report: &Report) -> Result<Now, UpdateError> {
        let mut report = *report;
        if report.slot == target && !report.trial {
            // Nothing has confirmed it from here.
            sleep(SURELY).await;
            report = self.state().await?;
        }
        match report.slot == target {
            true if report.version != image.version() => Err(UpdateError::OtherSender),
            true if report.trial => Ok(Now::Trial),
            true => Ok(Now::Confirmed),
            false if report.failed || report.pending => Err(self.went_back(image, &report)),
            false => Ok(Now::Untried),
        }
    }

    /// The status of a monitor that a restart leaves where and what it is.
    ///
    /// # Errors
    ///
    /// [`UpdateError::NotReady`] where it would come back at another address or with other subsystems: that would
    /// be taken for a fault of the image.
    async fn takes_effect(&self) -> Result<MonitorStatus, UpdateError> {
        let status = self.status().await?;
        let client = self.monitor.client();
        let address = match client.has_addresses() {
            true => self.general(Param::GeneralAddress).await?,
            false => None,
        };
        let elsewhere = address.is_some_and(|it| it != i32::from(client.address()));
        let others = match self.general(Param::GeneralChain).await? {
            Some(chain) => {
                let seen = |id| {
                    status.flags(id).is_some() || status.others.iter().any(|it| it.from() == id)
                };
                of_chain(chain).any(|(id, is_in)| is_in != seen(id))
            }
            None => false,
        };
        let waits = [(elsewhere, "Address"), (others, "Chain")].into_iter().filter(|it| it.0);
        let waits: Vec<_> = waits.map(|(_, param)| Unready::WaitsForRestart { param }).collect();
        if waits.is_empty() { Ok(status) } else { Err(UpdateError::NotReady(waits)) }
    }

    /// What has to be there where it is not known what was there before.
    async fn composition(&self) -> Result<Before, UpdateError> {
        let chain = self.general(Param::GeneralChain).await?.unwrap_or(0);
        let others = of_chain(chain).filter(|(_, is_in)| *is_in).map(|(id, _)| id);
        Ok(Before::unknown([SubsystemId::GENERAL].into_iter().chain(others)))
    }

    /// The value of a parameter of General, where the monitor has one.
    async fn general(&self, param: Param) -> Result<Option<i32>, UpdateError> {
        let since = Instant::now();
        loop {
            match self.monitor.param_id(SubsystemId::GENERAL, param.id()).await {
                Ok(values) => return Ok(values.first().copied()),
                Err(error) if error.is_refused() || is_odd(&error) => return Ok(None),
                Err(error) => outlast(error, since).await?,
            }
        }
    }

    /// Has the image received and verified; returns the report that says so.
    async fn bring(
        &mut self,
        image: &Image,
        digest: &[u8; DIGEST_LEN],
    ) -> Result<Report, UpdateError> {
        let mut course = Course::new();
        let mut report = self.begin(image, digest).await?;
        loop {
            if report.phase != Phase::IDLE && !image.is_received(&report) {
                return Err(UpdateError::OtherSender);
            }
            course.note(&report)?;
            let seen = report;
            report = match report.phase {
                Phase::VERIFIED => return Ok(report),
                // Nothing has been committed from here.
                Phase::COMMITTED => return Err(UpdateError::OtherSender),
                Phase::RECEIVING if report.received < report.size => {
                    self.data(image, report.received).await?
                }
                Phase::RECEIVING => self.verify().await?,
                Phase::VERIFYING => {
                    sleep(POLL).await;
                    self.state().await?
                }
                // The monitor has restarted, or has given up what it had.
                _ => self.begin_again(image, digest, &report, &mut course).await?,
            };
            if (report.phase, report.received) == (seen.phase, seen.received) {
                sleep(PAUSE).await;
            }
        }
    }

    /// Begins, or goes on. It is repeated until it was certainly carried out: what was started before may have
    /// the digest of another word.
    async fn begin(
        &mut self,
        image: &Image,
        digest: &[u8; DIGEST_LEN],
    ) -> Result<Report, UpdateError> {
        let order = Order::Begin { header: image.header(), digest };
        let mut tries = 1;
        loop {
            let outcome = self.order(&order).await?;
            let report = outcome.report();
            match (outcome, outcome.reason()) {
                (_, Report::NOT_READY) => return Err(self.not_ready().await),
                (Outcome::Accepted(_), 0) if image.is_received(&report) => return Ok(report),
                (Outcome::Accepted(_), 0) if report.phase != Phase::IDLE => {
                    return Err(UpdateError::OtherSender);
                }
                (_, FLASH) if tries >= TRIES => return Err(UpdateError::Refused(FLASH)),
                (_, 0 | FLASH) => {}
                (_, reason) => return Err(UpdateError::Refused(reason)),
            }
            if tries >= TRIES {
                return Err(stalled(&report));
            }
            tries += 1;
            sleep(PAUSE).await;
        }
    }

    /// Begins after the monitor has lost what was started: for the reason of this report, or by a restart.
    async fn begin_again(
        &mut self,
        image: &Image,
        digest: &[u8; DIGEST_LEN],
        report: &Report,
        course: &mut Course,
    ) -> Result<Report, UpdateError> {
        let used_up = course.begins == 0 || (report.reason == HASH && course.rejected);
        if used_up && report.reason != 0 {
            return Err(UpdateError::Refused(report.reason));
        }
        if used_up {
            return Err(stalled(report));
        }
        course.begins -= 1;
        course.rejected |= report.reason == HASH;
        sleep(PAUSE).await;
        self.begin(image, digest).await
    }

    /// Sends data from there on until all are sent or something is unclear; then the report says where to go on.
    /// A part that was accepted is taken as carried out: if it was not, the next one is refused.
    async fn data(&mut self, image: &Image, from: u32) -> Result<Report, UpdateError> {
        let (mut at, mut waits) = (from, 0);
        self.sending(image, at);
        while let Some(part) = part(image.payload(), at) {
            let sent = Instant::now();
            let given = give(self.monitor, &Order::Data { offset: at, part }).await;
            let pause = self.trial.pace.pause(sent.elapsed());
            match given {
                Ok(given) if given.status == Status::ACCEPTED => {
                    (at, waits) = (at + part.len() as u32, 0);
                    self.sending(image, at);
                    sleep(pause).await;
                }
                Ok(given) if given.status == Status::BUSY && waits < WAITS => {
                    waits += 1;
                    sleep(SOON.max(pause)).await;
                }
                Ok(given) if given.status == Status::DENIED && given.report.is_some() => {
                    return Err(self.not_ready().await);
                }
                Ok(given) if is_unclear(given.status) => break,
                Ok(given) => return Err(given.refused().into()),
                Err(error) if passes(&error) => {
                    sleep(pause.min(PAUSE_MAX)).await;
                    break;
                }
                Err(error) => return Err(error.into()),
            }
        }
        self.settled().await
    }

    fn sending(&mut self, image: &Image, done: u32) {
        let size = image.size();
        let (since, from) = match self.started {
            Some((since, from)) if from <= done => (since, from),
            _ => (Instant::now(), done),
        };
        self.started = Some((since, from));
        let share = f64::from(size.saturating_sub(done)) / f64::from(done - from);
        let left = Duration::try_from_secs_f64(since.elapsed().as_secs_f64() * share).ok();
        (self.told)(Stage::Sending { done, size, left: left.filter(|_| done > from) });
    }

    async fn verify(&mut self) -> Result<Report, UpdateError> {
        (self.told)(Stage::Verifying);
        Ok(self.order(&Order::Verify).await?.report())
    }

    /// Commits; returns the report after the restart. Not repeated unless the report shows that the image is as
    /// it was before: verified, and neither tried nor taken back.
    async fn commit(
        &mut self,
        image: &Image,
        digest: &[u8; DIGEST_LEN],
        before: &Report,
    ) -> Result<Report, UpdateError> {
        (self.told)(Stage::Committing);
        let mut sent = false;
        for _ in 0..TRIES {
            let given = give(self.monitor, &Order::Commit { digest }).await;
            sent |= !matches!(given, Err(Error::NotSent { .. } | Error::Closed));
            self.committed |= sent;
            let outcome = match self.outcome(given).await {
                // It may be restarting.
                Err(UpdateError::Client(error)) if sent => return Err(UpdateError::Silent(error)),
                outcome => outcome?,
            };
            let report = outcome.report();
            match report.phase {
                Phase::COMMITTED => return self.restarted().await,
                Phase::VERIFIED => {}
                Phase::IDLE => return Ok(report),
                _ => return Err(UpdateError::OtherSender),
            }
            if !image.is_received(&report) {
                return Err(UpdateError::OtherSender);
            }
            match outcome.reason() {
                Report::NOT_READY => return Err(self.not_ready().await),
                0 | FLASH => {}
                reason => return Err(UpdateError::Refused(reason)),
            }
            if report.pending || (report.failed && !before.failed) {
                return Err(UpdateError::Refused(FLASH));
            }
            sleep(PAUSE).await;
        }
        Err(stalled(before))
    }

    /// Waits until a monitor that has committed has restarted.
    async fn restarted(&mut self) -> Result<Report, UpdateError> {
        (self.told)(Stage::Committed);
        (self.told)(Stage::Restarting);
        self.committed = true;
        let since = Instant::now();
        loop {
            let report = match self.state().await {
                Err(UpdateError::Client(error)) => return Err(UpdateError::Silent(error)),
                report => report?,
            };
            if report.phase != Phase::COMMITTED {
                return Ok(report);
            }
            if since.elapsed() >= RESTART {
                return Err(stalled(&report));
            }
            sleep(POLL).await;
        }
    }

    /// What is not as before; nothing, if it has been so for long enough without a break.
    async fn check(&self, image: &Image, before: &Before) -> Result<Vec<Change>, UpdateError> {
        let since = Instant::now();
        let (mut heard, mut good) = (since, None);
        loop {
            let read = self.monitor.status_all().await;
            let now = Instant::now();
            let silent = read.as_ref().is_err_and(|error| passes(error) && !is_odd(error));
            let over = heard.elapsed() >= PATIENCE || since.elapsed() >= LOOKING;
            let changes = match read {
                Err(error) if silent && over => return Err(error.into()),
                Err(error @ Error::Closed) => return Err(error.into()),
                Err(error) => vec![Change::Unreadable(error)],
                Ok(status) => before.changes(&status),
            };
            if now - heard >= GAP {
                good = None;
            }
            if !silent {
                heard = now;
            }
            if changes.is_empty() {
                if now - *good.get_or_insert(now) >= self.trial.proven {
                    return Ok(changes);
                }
            } else {
                good = None;
                if !silent && since.elapsed() >= SELF_TESTS {
                    return Ok(changes);
                }
            }
            let report = self.state().await?;
            if !image.is_running(&report) {
                return Err(self.went_back(image, &report));
            }
            sleep(PAUSE).await;
        }
    }

    /// Ends a trial at once, where the program on trial can, or waits until its time is over; returns the version
    /// that is running again.
    async fn go_back(&mut self, image: &Image) -> Option<[u16; 4]> {
        (self.told)(Stage::Restarting);
        let digest = digest_of(self.trial.word);
        let since = Instant::now();
        let mut asked: Option<Instant> = None;
        while since.elapsed() < TRIAL_MAX {
            let report = self.state().await.ok()?;
            let tried = image.is_running(&report);
            if !report.trial && !tried {
                return Some(report.version);
            }
            if tried && report.trial && asked.is_none_or(|at| at.elapsed() >= AGAIN) {
                asked = Some(Instant::now());
                let given = give(self.monitor, &Order::Abandon { digest: &digest }).await;
                // A program that does not know the order, which may restart under lockout.
                let unknown = given.is_ok_and(|it| {
                    it.status == Status::INVALID_VALUE && it.report.is_none_or(|it| it.trial)
                });
                if unknown {
                    _ = self.monitor.restart().await;
                }
            }
            sleep(PAUSE).await;
        }
        None
    }

    /// Sends the word until the report shows that the image is not on trial any more.
    async fn confirm(&mut self, image: &Image) -> Result<(), UpdateError> {
        (self.told)(Stage::Confirming);
        let since = Instant::now();
        loop {
            let outcome = match self.order(&Order::Confirm { word: self.trial.word }).await {
                // After a start, what is at rest may not be known to be.
                Err(UpdateError::NotReady(_)) if since.elapsed() < CONFIRMATION => {
                    sleep(PAUSE).await;
                    continue;
                }
                outcome => outcome?,
            };
            let report = outcome.report();
            if !image.is_running(&report) {
                return Err(self.went_back(image, &report));
            }
            if !report.trial {
                return Ok(());
            }
            let over = since.elapsed() >= CONFIRMATION;
            match outcome.reason() {
                Report::NOT_READY if over => return Err(self.not_ready().await),
                FLASH if over => return Err(UpdateError::Refused(FLASH)),
                0 if over => return Err(stalled(&report)),
                0 | FLASH | Report::NOT_READY => {}
                reason => return Err(UpdateError::Refused(reason)),
            }
            sleep(PAUSE).await;
        }
    }

    /// Gives an order once, and finds out what became of it.
    async fn order(&self, order: &Order<'_>) -> Result<Outcome, UpdateError> {
        self.outcome(give(self.monitor, order).await).await
    }

    /// What became of an order that was given once.
    async fn outcome(&self, given: Result<Given, Error>) -> Result<Outcome, UpdateError> {
        match given {
            Ok(given) if given.status == Status::ACCEPTED => {
                Ok(Outcome::Accepted(self.settled().await?))
            }
            Ok(given) if given.status == Status::DENIED && given.report.is_some() => {
                Err(self.not_ready().await)
            }
            Ok(given) if is_unclear(given.status) => Ok(Outcome::Open(self.settled().await?)),
            Ok(given) => Err(given.refused().into()),
            Err(error) if passes(&error) => Ok(Outcome::Open(self.settled().await?)),
            Err(error) => Err(error.into()),
        }
    }

    /// The report as soon as no order waits to be carried out.
    async fn settled(&self) -> Result<Report, UpdateError> {
        let since = Instant::now();
        loop {
            let report = self.state().await?;
            if !report.waits {
                return Ok(report);
            }
            if since.elapsed() >= CARRIED_OUT {
                return Err(stalled(&report));
            }
            sleep(SOON).await;
        }
    }

    /// The report; a line that is dead is waited for.
    async fn state(&self) -> Result<Report, UpdateError> {
        let since = Instant::now();
        loop {
            match give(self.monitor, &Order::State).await.and_then(Given::report) {
                Ok(report) => return Ok(report),
                Err(error) => outlast(error, since).await?,
            }
        }
    }

    /// The status of all; a line that is dead is waited for.
    async fn status(&self) -> Result<MonitorStatus, UpdateError> {
        let since = Instant::now();
        loop {
            match self.monitor.status_all().await {
                Ok(status) => return Ok(status),
                Err(error) => outlast(error, since).await?,
            }
        }
    }

    /// Why an order was denied, as far as the status shows it.
    async fn not_ready(&self) -> UpdateError {
        match self.monitor.status_all().await {
            Ok(status) => UpdateError::NotReady(Unready::of(&status)),
            Err(_) => UpdateError::NotReady(vec![Unready::Hidden]),
        }
    }
}

/// The pause before the same is asked again; the error, where that is of no use or has been done for long enough.
async fn outlast(error: Error, since: Instant) -> Result<(), UpdateError> {
    if !passes(&error) || since.elapsed() >= PATIENCE {
        return Err(error.into());
    }
    sleep(PAUSE).await;
    Ok(())
}

/// Whether an order with this status was not accepted, but may be in another state.
const fn is_unclear(status: Status) -> bool {
    matches!(status, Status::BUSY | Status::INVALID_VALUE | Status::NO_ROOM)
}

/// Whether an answer came that is not what the protocol says.
const fn is_odd(error: &Error) -> bool {
    matches!(error, Error::Protocol { .. })
}

/// What the parameter Chain says of each subsystem but General.
fn of_chain(chain: i32) -> impl Iterator<Item = (SubsystemId, bool)> {
    let all = SubsystemId::TABLE.into_iter().enumerate().skip(1);
    all.map(move |(at, id)| (id, chain >> at & 1 != 0))
}
