//! Whether the state is what the hub has written: files that were lost are reported, the chain of the
//! audit log is walked again and again, and its head is noted outside of the log.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use serde::Serialize;
use tokio::time::{Instant, MissedTickBehavior, interval};
use utoipa::ToSchema;

use super::db::is_corrupt;
use crate::config::Config;
use crate::hub::{Caller, Hub};
use crate::store::reserve::Room;
use crate::store::{
    self, Act, Audit, Chain, Examined, Fault, Head, Loss, Mark, StateFile, StoreError,
};
use crate::sync::lock;

/// The longest time for the files at the end.
const SETTLE: Duration = Duration::from_secs(5);
/// Entries that are looked at in one step.
const PIECE: u32 = 500;
/// Time between two steps: a walk takes a few per cent of a processor.
const STEP: Duration = Duration::from_millis(100);
/// Steps from one note of the head to the next: 10 s. What is cut off within them does not show.
const STEPS_TO_NOTE: u64 = 100;
/// What could not be read is tried again after this time.
const READ_AGAIN: Duration = Duration::from_secs(10);
/// Time from the end of a walk along the whole chain to the next.
const WALK_EVERY: Duration = Duration::from_secs(3600);

/// What is known of the chain of the audit log.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct ChainState {
    /// `checking`: not the whole chain was walked since the start; `ok`; `broken`.
    pub state: ChainWord,
    /// Entries up to which it was found right.
    pub verified: u64,
    /// The first entry that is not right.
    #[schema(required)]
    pub bad: Option<u64>,
}

/// State of the chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ChainWord {
    /// Not yet walked as a whole since the start.
    #[default]
    Checking,
    /// As written.
    Ok,
    /// Something was changed or taken out.
    Broken,
}

/// The state of the hub as a whole.
#[derive(Debug, Default)]
pub struct Integrity {
    folder: Option<PathBuf>,
    history: bool,
    /// All files were marked before this start.
    is_whole: bool,
    noted: Mutex<Mark>,
    /// The end of the audit log as it was noted before this start.
    noted_before: Mutex<Head>,
    chain: Mutex<ChainState>,
    losses: Mutex<Vec<Loss>>,
}

impl Integrity {
    /// Looks at the files before they are opened; refuses when users or the audit log are lost and
    /// that is not accepted, and to begin a folder on a disk that has no room for it. What cannot be
    /// read is moved aside.
    pub fn examine(config: &Config, room: Room) -> Result<Self, StoreError> {
        let Some(folder) = config.data.clone() else { return Ok(Self::default()) };
        let history = config.postgres.is_none();
        let Examined { site, is_new, is_whole, mut losses } = store::examine(&folder, history)?;
        if let Room::None(error) = room {
            if is_new {
                return Err(StoreError::NoRoom(folder, error));
            }
            tracing::warn!(%error, "there is no room on the disk of the state, and no reserve");
        }
        let accepted = |loss: &Loss| config.accept_lost.contains(&loss.file);
        let grave: Vec<Loss> =
            losses.iter().filter(|it| it.is_grave() && !accepted(it)).cloned().collect();
        if !grave.is_empty() {
            return Err(StoreError::Lost(grave));
        }
        for loss in &mut losses {
            loss.set_aside(&folder)?;
        }
        let site = match site {
            Some(site) => site,
            None => {
                let secret = crate::access::secret();
                secret.map_err(|error| std::io::Error::other(error.to_string()))?[..32].to_owned()
            }
        };
        if is_new {
            store::begin(&folder, &site, history)?;
        }
        let noted = Mutex::new(Mark { site, ..Mark::default() });
        let (folder, losses) = (Some(folder), losses.into());
        Ok(Self { folder, history, is_whole, noted, losses, ..Self::default() })
    }

    /// Opens a file, or what takes its place where the disk does not let it be read: the hub starts as it goes on when
    /// the disk fails while it runs. `hub.db` is not opened in this way.
    ///
    /// # Errors
    ///
    /// Any other error of opening it; that of the disk as well in a folder that is new.
    pub fn opened<T>(
        &self,
        file: StateFile,
        open: impl FnOnce() -> Result<T, StoreError>,
        unread: impl FnOnce() -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        if self.unread().contains(&file) {
            return unread();
        }
        match open() {
            Err(error) if error.is_of_disk() && self.is_whole => {
                self.lost(Loss { file, fault: Fault::Unread { error: error.to_string() } });
                unread()
            }
            opened => opened,
        }
    }

    /// The files that the disk did not let be read at this start.
    fn unread(&self) -> Vec<StateFile> {
        let losses = lock(&self.losses);
        let unread = losses.iter().filter(|it| matches!(it.fault, Fault::Unread { .. }));
        unread.map(|it| it.file).collect()
    }

    /// The audit log in the place of one that the disk did not let be read at this start.
    ///
    /// # Errors
    ///
    /// There is no folder, or no thread.
    pub fn audit_unread(&self) -> Result<Audit, StoreError> {
        let folder = self.folder.clone().ok_or(StoreError::Unread)?;
        Audit::unread(folder.clone(), store::noted(&folder))
    }

    /// Marks the files, which are open now.
    pub fn mark(&self) -> Result<(), StoreError> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let site = lock(&self.noted).site.clone();
        let (before, now) = store::mark(folder, &site, self.history, &self.unread())?;
        (*lock(&self.noted_before), *lock(&self.noted)) = (before, now);
        Ok(())
    }

    /// What is known of the chain of the audit log.
    pub fn chain(&self) -> ChainState {
        lock(&self.chain).clone()
    }

    /// Files that were lost before this start, until the alarm is acknowledged.
    pub fn losses(&self) -> Vec<Loss> {
        lock(&self.losses).clone()
    }

    /// A loss that shows when a file is opened.
    pub fn lost(&self, loss: Loss) {
        lock(&self.losses).push(loss);
    }

    /// The alarm was acknowledged.
    pub fn known(&self) {
        lock(&self.losses).clear();
    }

    fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }
}

impl Hub {
    /// Reports the files that were lost before this start.
    pub fn report_losses(&self) {
        if let Some(error) = self.access().revocations_spoilt() {
            let fault = Fault::Malformed { error, aside: None };
            self.integrity().lost(Loss { file: StateFile::Revoked, fault });
        }
        for loss in self.integrity().losses() {
            self.event(None, &loss.both());
            let record = self.record(&Caller::hub(), "", "state lost", loss.file.word());
            drop(self.audit().note(record.about(&Act::StateLost { loss })));
        }
    }

    /// Notes the head of the audit log in `hub.db`, how often users were changed in `audit.db`, and
    /// both beside them. Only what is on the disk is noted.
    pub async fn note_state(&self) -> Result<(), StoreError> {
        self.note_as(false).await
    }

    /// The same as the hub ends: what is changed from now on was not changed by it.
    pub async fn note_end(&self) -> Result<(), StoreError> {
        // They are stored yet, at the end of this program or at the start of the next.
        let ended = !self.access().revocations_wait();
        self.note_as(ended).await
    }

    async fn note_as(&self, ended: bool) -> Result<(), StoreError> {
        let Some(folder) = self.integrity().folder().map(Path::to_owned) else { return Ok(()) };
        let (n, hash) = self.audit().head().await?;
        let own = self.clone();
        let read = tokio::task::spawn_blocking(move || own.access().people());
        let (users, people) = read.await.map_err(|_| StoreError::Busy)??;
        let noted = lock(&self.integrity().noted).clone();
        // Users who are others without a change that was counted are not noted: they show at the next start.
        let is_known = noted.users == users && !noted.people.is_empty();
        let people = if is_known { noted.people.clone() } else { people };
        let now = Mark { site: noted.site.clone(), users, audit: Head { n, hash }, people };
        if noted == now && !ended {
            return Ok(());
        }
        if noted.users != now.users {
            self.audit().note_users(now.users).await?;
        }
        let (own, mark) = (self.clone(), now.clone());
        let written = tokio::task::spawn_blocking(move || {
            own.access().note_audit(&mark.audit)?;
            store::note(&folder, &mark, own.integrity().history, ended)
        });
        written.await.map_err(|_| StoreError::Busy)??;
        *lock(&self.integrity().noted) = now;
        Ok(())
    }

    /// Moves what the databases have in SQLite's logs into their files: a copy of each file alone is
    /// whole then. Takes `SETTLE` at most; what did not get so far is in the log beside the file as
    /// before, and nothing is lost.
    pub async fn settle(&self) {
        let own = self.clone();
        let users = async move {
            let settled = tokio::task::spawn_blocking(move || own.access().checkpoint()).await;
            settled.map_err(|_| StoreError::Busy)?
        };
        let history = self.history().settle();
        let said = |file: StateFile, settled: Result<(), StoreError>| {
            if let Err(error) = settled {
                tracing::warn!(file = file.name(), %error, "a part stays in the log beside it");
            }
        };
        let all = async {
            let (hub, audit, events, history) =
                tokio::join!(users, self.audit().settle(), self.events().settle(), history);
            said(StateFile::Hub, hub);
            said(StateFile::Audit, audit);
            said(StateFile::Events, events);
            said(StateFile::History, history);
        };
        if tokio::time::timeout(SETTLE, all).await.is_err() {
            tracing::warn!(
                "the disk is slow: a part of the state stays in the logs beside the files"
            );
        }
    }

    /// Writes the head of the audit log into the program's own log, which is kept elsewhere.
    pub async fn log_head(&self) {
        if let Ok((entries, head)) = self.audit().head().await {
            tracing::info!(entries, head, "head of the audit log");
        }
    }

    fn chain_is_broken(&self, n: u64) {
        let text = text::AuditChanged { n }.words();
        self.event(None, &text);
        tracing::error!(entry = n, "the chain of the audit log is broken");
        let record = self.record(&Caller::hub(), "", "audit log changed", "broken");
        drop(self.audit().note(record.about(&Act::ChainBroken { n })));
    }
}

/// Whether an error of reading says something of the disk or the moment, and nothing of what was written.
fn passes(error: &StoreError) -> bool {
    match error {
        StoreError::Sqlite(error @ rusqlite::Error::SqliteFailure(..)) => !is_corrupt(error),
        StoreError::Sqlite(_) => false,
        _ => true,
    }
}

/// A walk along the chain.
struct Walk {
    chain: Chain,
    /// It began at the first entry.
    whole: bool,
    /// Rests until this time.
    rests: Option<Instant>,
}

impl Walk {
    fn from_the_first() -> Self {
        Self { chain: Chain::default(), whole: true, rests: None }
    }

    /// Checks some entries more.
    async fn step(&mut self, hub: &Hub) {
        if self.rests.is_some_and(|until| Instant::now() < until) {
            return;
        }
        self.rests = None;
        let first = self.chain.next();
        let (chain, goes_on) = match hub.audit().walk(self.chain.clone(), PIECE).await {
            Ok(walked) => walked,
            Err(error) if passes(&error) => {
                tracing::warn!(%error, "the audit log cannot be read just now");
                self.rests = Some(Instant::now() + READ_AGAIN);
                return;
            }
            // An entry that cannot be read is not the one that was written.
            Err(error) => {
                tracing::error!(%error, "the audit log cannot be read");
                return self.broken(hub, first);
            }
        };
        if let Some(bad) = chain.bad() {
            tracing::error!(entry = bad, "an entry of the audit log is not right");
            return self.broken(hub, bad);
        }
        self.chain = chain;
        {
            let mut known = lock(&hub.integrity().chain);
            if known.state != ChainWord::Broken {
                known.verified = known.verified.max(self.chain.next() - 1);
            }
        }
        if !goes_on {
            self.ended(hub, first - 1);
        }
    }

    fn ended(&mut self, hub: &Hub, last: u64) {
        let rests = self.whole.then(|| Instant::now() + WALK_EVERY);
        if self.whole {
            let new = ChainState { state: ChainWord::Ok, verified: last, bad: None };
            *lock(&hub.integrity().chain) = new;
        }
        *self = Self { rests, ..Self::from_the_first() };
    }

    fn broken(&mut self, hub: &Hub, n: u64) {
        let before = {
            let mut known = lock(&hub.integrity().chain);
            let verified = known.verified.min(n - 1);
            let new = ChainState { state: ChainWord::Broken, verified, bad: Some(n) };
            std::mem::replace(&mut *known, new)
        };
        if before.bad != Some(n) {
            hub.chain_is_broken(n);
        }
        *self = Self { rests: Some(Instant::now() + WALK_EVERY), ..Self::from_the_first() };
    }
}

/// Walks along the chain, first from the entry that was noted last, and notes its head.
pub async fn run(hub: Hub) {
    let noted = lock(&hub.integrity().noted_before).clone();
    let mut walk =
        Walk { chain: Chain::after((noted.n, noted.hash)), whole: noted.n == 0, rests: None };
    let mut steps = interval(STEP);
    steps.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut shutdown = hub.shutdown();
    hub.log_head().await;
    for step in 1_u64.. {
        tokio::select! {
            _ = steps.tick() => {}
            () = shutdown.requested() => return,
        }
        walk.step(&hub).await;
        if step.is_multiple_of(STEPS_TO_NOTE)
            && let Err(error) = hub.note_state().await
        {
            tracing::debug!(%error, "the head of the audit log is not noted");
        }
        if step.is_multiple_of(STEPS_TO_NOTE * 360) {
            hub.log_head().await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_passes_accuses_no_entry() {
        use rusqlite::ffi;
        let of = |code| {
            let error = rusqlite::Error::SqliteFailure(ffi::Error::new(code), None);
            passes(&StoreError::Sqlite(error))
        };
        for code in [ffi::SQLITE_IOERR, ffi::SQLITE_BUSY, ffi::SQLITE_CANTOPEN, ffi::SQLITE_NOMEM] {
            assert!(of(code), "{code}");
        }
        assert!(!of(ffi::SQLITE_CORRUPT) && !of(ffi::SQLITE_NOTADB));
        let odd = rusqlite::Error::IntegralValueOutOfRange(0, -1);
        assert!(!passes(&StoreError::Sqlite(odd)), "an entry that none has written");
        assert!(passes(&StoreError::Busy));
    }
}
