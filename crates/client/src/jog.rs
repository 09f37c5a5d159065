//! A motion that lasts only while the caller renews it: see [`crate::session::jog`].

use std::sync::{Arc, Mutex, Weak};

use lafet_proto::SubsystemId;
use tokio::sync::{Notify, watch};
use tokio::time::{Instant, sleep_until};

use crate::answers::{Answers, RequestBuf};
use crate::client::Client;
use crate::error::Error;
use crate::session::Now;
use crate::session::jog::{Hold, JogCore, JogEnd, Next, Reason, Toward};
use crate::shared::lock;

/// A motion of a drive that lasts while this is renewed.
///
/// The lease (300 ms by default) starts with the motion and with each [`Jog::renew`]. When it
/// expires, when this is dropped or released, when the connection is lost or the monitor does not
/// answer, the client sends Stop until the drive's Move flag clears, over the next connection if
/// necessary, even if every other handle has been dropped. A Stop or Lockout sent with any clone of
/// the client ends the motion as well.
///
/// If nothing can be sent any more (program killed, cable cut), the drive stops by itself: a
/// monitor with the parameter MoveHold (ours, §D/4) 300 ms after the last renewal, or after two and
/// a half round trips and 50 ms if that is longer; any other monitor at the end of the last short
/// step, see [`crate::session::jog`]. It does not replace an emergency stop.
#[derive(Debug)]
pub struct Jog {
    held: Arc<Held>,
}

/// State of a motion, shared by its handle, its task and the client.
#[derive(Debug)]
pub struct Held {
    core: Mutex<JogCore>,
    start: Instant,
    address: u8,
    moving: RequestBuf,
    /// Notified when the state is changed outside the task.
    changed: Notify,
    end: watch::Sender<Option<JogEnd>>,
}

impl Jog {
    /// Starts a motion. Call it inside a Tokio runtime.
    pub(crate) fn start(
        client: &Client,
        drive: SubsystemId,
        toward: Toward,
        hold: Hold,
    ) -> Result<Self, Error> {
        let holds = lock(&client.shared.holds).contains(&client.address());
        let core = JogCore::new(Now::ZERO, drive, toward, hold, holds);
        let held = Arc::new(Held {
            moving: RequestBuf::new(&core.request())?,
            core: Mutex::new(core),
            start: Instant::now(),
            address: client.address(),
            changed: Notify::new(),
            end: watch::Sender::new(None),
        });
        replace(client, &held);
        tokio::spawn(run(client.clone(), Served(held.clone())));
        Ok(Self { held })
    }

    /// Extends the motion by another lease; `false` if it is being stopped or has ended.
    pub fn renew(&self) -> bool {
        let held = self.held.with(|core, now| core.renew(now));
        self.held.changed.notify_one();
        held
    }

    /// Whether the motion is still held.
    pub fn is_held(&self) -> bool {
        self.held.with(|core, now| {
            core.handle_timeout(now);
            core.is_held()
        })
    }

    /// Stops the motion and waits until the drive is at rest. Dropping the future stops it as well.
    ///
    /// Without answers that takes up to ten minutes, in which Stop is sent again and again. Who cannot wait
    /// for so long limits it by a timeout: Stop is still sent after that.
    pub async fn release(mut self) -> JogEnd {
        self.held.let_go();
        self.ended().await
    }

    /// Waits for the end of the motion, whatever its cause.
    pub async fn ended(&mut self) -> JogEnd {
        let mut end = self.held.end.subscribe();
        match end.wait_for(Option::is_some).await {
            Ok(end) => end.clone().unwrap_or(JogEnd::Unknown(Error::Closed)),
            Err(_) => JogEnd::Unknown(Error::Closed),
        }
    }
}

impl Drop for Jog {
    fn drop(&mut self) {
        self.held.let_go();
    }
}

impl Held {
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// Whether this urgent request ends the motion.
    pub fn is_undone_by(&self, stop: &RequestBuf) -> bool {
        stop.supersedes(&self.moving)
    }

    /// A Stop was submitted to the client.
    pub fn stop_asked(&self) {
        self.with(|core, now| core.stop(now, Reason::StopAsked));
        self.changed.notify_one();
    }

    /// Others have set drives in motion, by a request that was submitted then: whether that has replaced this motion.
    pub fn is_replaced(&self, drive: Option<SubsystemId>, submitted: Instant) -> bool {
        if drive.is_some_and(|it| it != self.drive()) {
            return false;
        }
        let submitted = submitted.saturating_duration_since(self.start);
        let replaced = self.with(|core, _| core.begun_by_others(submitted));
        if replaced {
            self.changed.notify_one();
        }
        replaced
    }

    /// The drive.
    pub const fn drive(&self) -> SubsystemId {
        self.moving.to()
    }

    fn let_go(&self) {
        self.with(|core, now| {
            core.handle_timeout(now);
            core.stop(now, Reason::Released);
        });
        self.changed.notify_one();
    }

    fn with<T>(&self, change: impl FnOnce(&mut JogCore, Now) -> T) -> T {
        change(&mut lock(&self.core), self.start.elapsed())
    }
}

/// Replaces another motion of the same drive.
fn replace(client: &Client, new: &Arc<Held>) {
    let mut jogs = lock(&client.shared.jogs);
    jogs.retain(|jog| jog.strong_count() > 0);
    for jog in jogs.iter().filter_map(Weak::upgrade) {
        if jog.address == new.address && jog.moving.to() == new.moving.to() {
            jog.with(|core, _| core.replace());
            jog.changed.notify_one();
        }
    }
    jogs.push(Arc::downgrade(new));
}

/// Ends the wait of a motion's callers when its task is gone: its runtime was dropped.
struct Served(Arc<Held>);

impl Drop for Served {
    fn drop(&mut self) {
        self.0.end.send_if_modified(|end| {
            let gone = end.is_none();
            end.get_or_insert(JogEnd::Unknown(Error::Closed));
            gone
        });
    }
}

async fn run(client: Client, served: Served) {
    let held = &served.0;
    let mut link = client.link_state();
    let losses = link.borrow_and_update().losses;
    loop {
        let state = *link.borrow_and_update();
        if state.losses != losses {
            held.with(|core, now| core.stop(now, Reason::LinkLost));
        }
        if state.gone {
            let gone = Error::Link { endpoint: client.endpoint().into(), source: gone() };
            held.with(|core, _| core.gone(gone));
        }
        if let Some(end) = held.with(|core, _| core.poll_end()) {
            held.end.send_replace(Some(end));
            return;
        }
        let rtt = client.stats().rtt_average;
        let next = held.with(|core, now| {
            core.set_rtt(rtt);
            core.poll_next(now)
        });
        match next {
            Some(next) => exchange(&client, held, &mut link, next).await,
            None => {
                let timeout = held.with(|core, _| core.poll_timeout());
                tokio::select! {
                    () = held.changed.notified() => {}
                    _ = link.changed() => {}
                    () = until(timeout.map(|time| held.start + time)) => {}
                }
                held.with(|core, now| core.handle_timeout(now));
            }
        }
    }
}

/// Sends a request of the motion. If the motion is to be stopped meanwhile, it does not wait: a
/// request that has not been sent is cancelled.
async fn exchange(
    client: &Client,
    held: &Held,
    link: &mut watch::Receiver<crate::shared::LinkState>,
    next: Next,
) {
    let was_held = held.with(|core, _| core.is_held());
    let expires = next.expires.map(|time| held.start + time);
    let requests = match next.requests(held.moving.to()) {
        Ok(requests) => requests,
        Err(error) => return held.with(|core, now| core.handle_result(now, vec![Err(error)])),
    };
    let result = client.run_frame(requests, expires);
    tokio::pin!(result);
    loop {
        let lease = held.with(|core, _| if was_held { core.poll_timeout() } else { None });
        tokio::select! {
            // A result that has arrived is handled first.
            biased;
            result = &mut result => {
                held.with(|core, now| told(core, now, was_held, result));
                return remember(client, held);
            }
            () = held.changed.notified() => {}
            changed = link.changed(), if was_held => {
                // A lost link ends a motion that is held; the stop of a motion continues.
                if changed.is_ok() && !link.borrow().up {
                    held.with(|core, now| core.stop(now, Reason::LinkLost));
                }
            }
            () = until(lease.map(|time| held.start + time)) => {
                held.with(|core, now| core.handle_timeout(now));
            }
        }
        if was_held && held.with(|core, _| !core.is_held()) {
            return;
        }
    }
}

/// Stores what is known of the monitor for the next motion.
fn remember(client: &Client, held: &Held) {
    let mut holds = lock(&client.shared.holds);
    match held.with(|core, _| core.holds()) {
        Some(true) => _ = holds.insert(client.address()),
        _ => _ = holds.remove(&client.address()),
    }
}

fn told(core: &mut JogCore, now: Now, was_held: bool, result: Vec<Result<Answers, Error>>) {
    core.handle_timeout(now);
    // The answer to a request of a motion that has been released says nothing about its Stop.
    if was_held == core.is_held() {
        core.handle_result(now, result);
    }
}

fn gone() -> Arc<std::io::Error> {
    Arc::new(std::io::ErrorKind::NotConnected.into())
}

async fn until(time: Option<Instant>) {
    match time {
        Some(time) => sleep_until(time).await,
        None => std::future::pending().await,
    }
}

impl JogEnd {
    /// Whether the drive is known to be at rest.
    pub const fn stands(&self) -> bool {
        matches!(self, Self::Stopped { .. } | Self::Standing(_) | Self::Refused(_))
    }
}
