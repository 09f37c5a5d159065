//! Updating the software of monitors (ours; docs/update.md): [`lafet_client::update`] with the hub's authority, audit
//! log and images, one monitor after the other.
//!
//! ```text
//!            POST        each monitor: check ─▶ lock out ─▶ update ─▶ release
//!  (nothing) ────▶ running ───────────────────────────────────────────────────▶ done
//!                    │ a monitor fails, Stop of the run, rights revoked, the hub ends,
//!                    │ an alarm in a zone of the monitor before its commit
//!                    └──────────────────────────────────────────────────────────▶ ended
//! ```
//!
//! A run moves nothing: that a monitor is in standby is for a person to see to. What was received stays in the
//! monitor, and what confirms it in the folder of the data: the next run goes on with both. Nothing starts by itself.

mod hold;
mod images;
mod notes;
mod ready;
mod run;
#[cfg(test)]
mod samples;
pub mod view;

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::http::StatusCode;
use lafet_client::update::{Image, Pace, are_a_set, hex};
use lafet_texts::{Text as _, hub as text};
use tokio::sync::{Semaphore, watch};
use tokio::time::{Instant, timeout};

use crate::control::authority::Refusal;
use crate::error::{ApiError, shown};
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::store::{Act, StoreError};
use crate::sync::lock;
use crate::text::Both;
use images::{IMAGES_MAX, Images, Put};
use notes::Notes;
use run::Run;
use view::{MonitorUpdate, MonitorWord, RunWord, StartUpdate, StoredImage, UpdateRun, Updates};

/// Topic of the images and of the run.
const TOPIC: &str = "updates";
/// Figures are published this often at most.
const FIGURES: Duration = Duration::from_millis(250);
/// Longest wait for the disk of the images while others wait for it.
const DISK_WAIT: Duration = Duration::from_secs(3);

/// Images and runs.
#[derive(Debug)]
pub struct Updating {
    images: Images,
    notes: Notes,
    course: Mutex<Course>,
    /// Held while an image is uploaded: one after the other.
    pub sending: Arc<Semaphore>,
    /// Held by who waits for the disk of the images: a disk that does not answer takes one thread.
    disk: Arc<Semaphore>,
}

/// The run, and when it was published.
#[derive(Debug, Default)]
struct Course {
    /// The one that runs, or the last one.
    run: Option<UpdateRun>,
    /// Who has stopped the one that runs; `None` while none runs.
    stop: Option<watch::Sender<Option<String>>>,
    /// Who is about to start one, and the digests of its images.
    starting: Option<(String, Vec<String>)>,
    published: Option<Instant>,
}

impl Updating {
    /// With what is in a folder of data; without one all is in memory.
    pub fn open(data: Option<&Path>) -> Self {
        let turn = || Arc::new(Semaphore::new(1));
        let (images, notes) = (Images::open(data), Notes::new(data));
        Self { images, notes, course: Mutex::default(), sending: turn(), disk: turn() }
    }

    /// Changes a monitor of the run, and publishes it; figures alone not each time.
    fn show(&self, hub: &Hub, at: usize, figures: bool, change: impl FnOnce(&mut MonitorUpdate)) {
        let mut course = lock(&self.course);
        let monitors = course.run.as_mut().map(|run| &mut run.monitors);
        if let Some(monitor) = monitors.and_then(|all| all.get_mut(at)) {
            change(monitor);
        }
        let soon = course.published.is_some_and(|at| at.elapsed() < FIGURES);
        if !(figures && soon) {
            self.publish(hub, &mut course);
        }
    }

    /// Of two changes at once the later one is published last.
    fn publish(&self, hub: &Hub, course: &mut Course) {
        course.published = Some(Instant::now());
        hub.topics().set(TOPIC, &self.view(course));
    }

    fn view(&self, course: &Course) -> Updates {
        Updates { images: self.images.list(), run: course.run.clone() }
    }

    /// What confirms the updates of monitors.
    fn notes(&self) -> &Notes {
        &self.notes
    }
}

impl Course {
    /// 409 while one runs, or is about to.
    fn refuse_second(&self) -> Result<(), ApiError> {
        let running = self.stop.as_ref().and(self.run.as_ref()).map(|run| &run.by);
        let user = self.starting.as_ref().map(|(by, _)| by).or(running);
        user.map_or(Ok(()), |user| {
            Err(conflict("update_runs", text::UpdatesRunAlready { user }.words()))
        })
    }

    /// Whether a run needs this image.
    fn uses(&self, digest: &str) -> bool {
        let running = self.stop.as_ref().and(self.run.as_ref()).map(|run| &run.images);
        let starting = self.starting.as_ref().map(|(_, images)| images);
        starting.into_iter().chain(running).flatten().any(|it| it == digest)
    }
}

fn conflict(code: &'static str, text: Both) -> ApiError {
    ApiError::new(StatusCode::CONFLICT, code, text)
}

/// The right to start the next run; without a run it is given back.
struct Claim<'a>(&'a Hub);

impl<'a> Claim<'a> {
    fn take(hub: &'a Hub, by: &str, images: &[String]) -> Result<Self, ApiError> {
        let mut course = lock(&hub.updating().course);
        course.refuse_second()?;
        course.starting = Some((by.to_owned(), images.to_vec()));
        Ok(Self(hub))
    }

    /// The run begins; what stops it.
    fn begin(self, run: UpdateRun) -> watch::Receiver<Option<String>> {
        let updating = self.0.updating();
        let (stop, stopped) = watch::channel(None);
        let mut course = lock(&updating.course);
        (course.run, course.stop) = (Some(run), Some(stop));
        updating.publish(self.0, &mut course);
        stopped
    }
}

impl Drop for Claim<'_> {
    fn drop(&mut self) {
        lock(&self.0.updating().course).starting = None;
    }
}

impl Hub {
    /// The images, and the run.
    pub fn updates(&self) -> Updates {
        let updating = self.updating();
        updating.view(&lock(&updating.course))
    }

    /// Publishes both.
    pub fn publish_updates(&self) {
        let updating = self.updating();
        updating.publish(self, &mut lock(&updating.course));
    }

    /// Stores an image that a client has sent; whether it is new.
    ///
    /// # Errors
    ///
    /// 400: no image. 409: there are too many, or one of this payload with another header. 503: the disk.
    pub async fn store_image(
        &self,
        caller: &Caller,
        bytes: Vec<u8>,
    ) -> Result<(StoredImage, bool), ApiError> {
        let (own, by, at_ms) = (self.clone(), caller.principal.user.clone(), self.clock().now_ms());
        let put = self.at_images(move || {
            let image =
                Image::read(&bytes).map_err(|error| ApiError::bad_request(error.words()))?;
            drop(bytes);
            own.updating().images.put(image, &by, at_ms).map_err(of_disk)
        });
        let image = match put.await?? {
            Put::New(image) => image,
            Put::Known(image) => return Ok((image, false)),
            Put::Differs(StoredImage { version, board, .. }) => {
                let text = text::UpdatesImageDiffers { version: &version, board: &board }.words();
                return Err(conflict("image_differs", text));
            }
            Put::Full => {
                let text = text::UpdatesImagesFull { most: IMAGES_MAX }.words();
                return Err(conflict("images_full", text));
            }
        };
        let StoredImage { digest, version, board, .. } = image.clone();
        let what = format!("store image {version} for {board}");
        let act = Act::StoreImage { digest, version, board };
        drop(self.audit().note(self.record(caller, "", &what, "Ok").about(&act)));
        self.publish_updates();
        Ok((image, true))
    }

    /// Removes an image.
    ///
    /// # Errors
    ///
    /// 404: there is none. 409: the run needs it. 503: the disk.
    pub async fn remove_image(&self, caller: &Caller, digest: &str) -> Result<(), ApiError> {
        if lock(&self.updating().course).uses(digest) {
            return Err(conflict("image_in_use", text::UpdatesImageInUse.words()));
        }
        let (own, name) = (self.clone(), digest.to_owned());
        let removed = self.at_images(move || own.updating().images.remove(&name)).await?;
        let image = removed.map_err(of_disk)?.ok_or_else(ApiError::not_found)?;
        let StoredImage { digest, version, board, .. } = image;
        let what = format!("remove image {version} for {board}");
        let act = Act::RemoveImage { digest, version, board };
        drop(self.audit().note(self.record(caller, "", &what, "Ok").about(&act)));
        self.publish_updates();
        Ok(())
    }

    /// Starts to update monitors, one after the other.
    ///
    /// # Errors
    ///
    /// 409: one runs already, or another client holds a monitor. 400: there is no such monitor or image, the images
    /// do not belong together, there is nothing to update.
    pub async fn start_update(
        &self,
        caller: &Caller,
        wanted: StartUpdate,
    ) -> Result<UpdateRun, ApiError> {
        let pace = match wanted.pace.map(Pace::new) {
            Some(None) => return Err(ApiError::bad_request(text::UpdatesPaceRange.words())),
            pace => pace.flatten(),
        };
        let digests = wanted.images;
        if !(1..=2).contains(&digests.len()) {
            return Err(ApiError::bad_request(text::UpdatesImagesNumber.words()));
        }
        let stations = self.to_update(wanted.monitors)?;
        let claim = Claim::take(self, &caller.principal.user, &digests)?;
        for station in &stations {
            let held = lock(&station.authority).holder().map(|(seat, _)| seat.clone());
            if let Some(seat) = held {
                return Err(ApiError::authority(station.id(), Refusal::Held(seat)));
            }
        }
        let images = self.load_images(&digests).await?;
        if !are_a_set(&images) {
            return Err(ApiError::bad_request(text::UpdatesNotASet.words()));
        }
        let run = self.new_run(caller, &images, &stations);
        self.note_start(caller, &run);
        let stopped = claim.begin(run.clone());
        let hub = self.clone();
        let running = Run { hub, caller: hold::caller(caller), images, pace, stopped };
        self.clone().attend(running, stations);
        Ok(run)
    }

    /// Ends the run before its next order; what was received stays in the monitor.
    ///
    /// # Errors
    ///
    /// 404: none runs.
    pub fn stop_update(&self, caller: &Caller) -> Result<UpdateRun, ApiError> {
        let course = lock(&self.updating().course);
        let (Some(stop), Some(run)) = (&course.stop, &course.run) else {
            let text = text::UpdatesNoneRuns.words();
            return Err(ApiError::new(StatusCode::NOT_FOUND, "no_update", text));
        };
        let user = caller.principal.user.clone();
        let first = stop.send_if_modified(|by| {
            let first = by.is_none();
            by.get_or_insert(user);
            first
        });
        if first {
            let record = self.record(caller, "", "stop update", "Ok");
            drop(self.audit().note(record.about(&Act::StopUpdate)));
        }
        Ok(run.clone())
    }

    /// The monitors of a request, in its order or in that of the configuration; each once.
    fn to_update(&self, ids: Option<Vec<String>>) -> Result<Vec<Arc<Station>>, ApiError> {
        let all = self.all_stations();
        let ids = ids.unwrap_or_else(|| {
            let configured = self.config().monitors.iter().map(|it| it.id.clone());
            // A simulation may have replaced those of the configuration.
            configured.chain(all.keys().cloned()).filter(|id| all.contains_key(id)).collect()
        });
        let mut stations: Vec<Arc<Station>> = Vec::new();
        for id in &ids {
            let station = all
                .get(id)
                .ok_or_else(|| ApiError::bad_request(text::NoMonitor { id: shown(id) }.words()))?;
            if !stations.iter().any(|it| it.id() == id) {
                stations.push(station.clone());
            }
        }
        match stations.is_empty() {
            true => Err(ApiError::bad_request(text::UpdatesNoMonitors.words())),
            false => Ok(stations),
        }
    }

    async fn load_images(&self, digests: &[String]) -> Result<Vec<Image>, ApiError> {
        let (own, digests) = (self.clone(), digests.to_vec());
        let load = move |digest: &String| {
            let image = own.updating().images.load(digest);
            let digest = shown(digest);
            let image = image.map_err(|error| {
                ApiError::bad_request(text::UpdatesImageUnusable { digest, error }.words())
            })?;
            image.ok_or_else(|| ApiError::bad_request(text::UpdatesImageMissing { digest }.words()))
        };
        self.at_images(move || digests.iter().map(load).collect()).await?
    }

    fn new_run(&self, caller: &Caller, images: &[Image], stations: &[Arc<Station>]) -> UpdateRun {
        let version = images.first().map(Image::version).unwrap_or_default();
        UpdateRun {
            by: caller.principal.user.clone(),
            began_ms: self.clock().now_ms(),
            ended_ms: None,
            state: RunWord::Running,
            images: images.iter().map(|image| hex(&image.digest())).collect(),
            version: lafet_client::update::Dotted(version).to_string(),
            monitors: stations.iter().map(|it| MonitorUpdate::new(it.id())).collect(),
            text: None,
        }
    }

    fn note_start(&self, caller: &Caller, run: &UpdateRun) {
        let UpdateRun { images, version, monitors, .. } = run;
        let monitors = monitors.iter().map(|it| it.id.clone()).collect();
        let what = format!("update to {version}");
        let act = Act::StartUpdate { version: version.clone(), images: images.clone(), monitors };
        drop(self.audit().note(self.record(caller, "", &what, "Ok").about(&act)));
    }

    /// Carries a run out. If it ends by a panic, it has ended all the same.
    fn attend(self, run: Run, stations: Vec<Arc<Station>>) {
        let caller = run.caller.clone();
        tokio::spawn(async move {
            let text = tokio::spawn(run.go(stations)).await;
            self.update_ended(&caller, text.unwrap_or_else(|_| Some(text::UpdatesBroken.words())));
        });
    }

    /// A run has ended; with a reason, before it was done.
    fn update_ended(&self, caller: &Caller, why: Option<Both>) {
        let updating = self.updating();
        let mut course = lock(&updating.course);
        course.stop = None;
        let Some(run) = &mut course.run else { return };
        for monitor in &mut run.monitors {
            match monitor.state {
                MonitorWord::Waiting => monitor.state = MonitorWord::Skipped,
                MonitorWord::Done | MonitorWord::Same => {}
                // Also what a panic has left as it was.
                _ => monitor.state = MonitorWord::Failed,
            }
        }
        run.ended_ms = Some(self.clock().now_ms());
        run.state = if why.is_some() { RunWord::Ended } else { RunWord::Done };
        let is_done =
            |it: &&MonitorUpdate| matches!(it.state, MonitorWord::Done | MonitorWord::Same);
        let done = run.monitors.iter().filter(is_done).count();
        let act = Act::EndUpdate { done, monitors: run.monitors.len(), text: why.clone() };
        let what = format!("update to {}", run.version);
        let outcome = if why.is_some() { "ended" } else { "done" };
        drop(self.audit().note(self.record(caller, "", &what, outcome).about(&act)));
        run.text = why;
        updating.publish(self, &mut course);
    }

    /// Does something that waits for the disk of the images, on a thread for that.
    async fn at_images<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, StoreError> {
        let turn = timeout(DISK_WAIT, self.updating().disk.clone().acquire_owned()).await;
        let Ok(Ok(turn)) = turn else { return Err(StoreError::Busy) };
        let done = tokio::task::spawn_blocking(move || {
            let _turn = turn;
            work()
        });
        done.await.map_err(|_| StoreError::Busy)
    }
}

fn of_disk(error: std::io::Error) -> ApiError {
    StoreError::Io(error).into()
}
