//! The task of a link: serves it while no caller does, keeps its times, and opens it again.

use std::fmt;
use std::future::{Future, poll_fn};
use std::io;
use std::pin::{Pin, pin};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};

use tokio::time::{Instant, Sleep, sleep, sleep_until};

use crate::engine::{Dial, Engine, Next};
use crate::shared::{Shared, lock};
use crate::transport::Link;

/// A link that is being opened.
pub type Dialing = Pin<Box<dyn Future<Output = io::Result<Link>> + Send>>;

/// How the link is opened again, for something urgent or not.
#[derive(Clone)]
pub struct Redial(Arc<Mutex<dyn FnMut(bool) -> Dialing + Send>>);

impl Redial {
    pub fn new(dial: impl FnMut(bool) -> Dialing + Send + 'static) -> Self {
        Self(Arc::new(Mutex::new(dial)))
    }
}

impl fmt::Debug for Redial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Redial")
    }
}

/// See [`crate::engine`].
pub struct Task {
    engine: Arc<Mutex<Engine>>,
    shared: Arc<Shared>,
    /// How to connect again; without it a lost link is not replaced.
    redial: Option<Redial>,
    dialing: Option<Dialing>,
    /// For something urgent.
    urgently: bool,
}

impl Task {
    pub const fn new(
        engine: Arc<Mutex<Engine>>,
        shared: Arc<Shared>,
        redial: Option<Redial>,
    ) -> Self {
        Self { engine, shared, redial, dialing: None, urgently: false }
    }

    /// Runs until all handles are dropped and urgent requests are done.
    pub async fn run(mut self) {
        let turn = lock(&self.engine).turn().clone();
        // Kept between polls: creating it costs more than a request.
        let mut alarm = pin!(sleep_until(Instant::now()));
        poll_fn(|cx| {
            turn.set_task(cx.waker());
            self.poll(cx, alarm.as_mut())
        })
        .await;
    }

    fn poll(&mut self, cx: &mut Context<'_>, mut alarm: Pin<&mut Sleep>) -> Poll<()> {
        loop {
            if let Some(dialing) = &mut self.dialing
                && let Poll::Ready(link) = dialing.as_mut().poll(cx)
            {
                self.dialing = None;
                lock(&self.engine).dialed(link);
            }
            let (next, news) = {
                let mut engine = lock(&self.engine);
                (engine.work(), engine.news())
            };
            if let Some(state) = news {
                self.shared.publish(state);
            }
            let Next::Wait { dial, alarm: due } = next else { return Poll::Ready(()) };
            if dial.is_some_and(|dial| self.dials(dial)) {
                continue;
            }
            let Some(due) = due else { return Poll::Pending };
            if alarm.deadline() != due || alarm.is_elapsed() {
                alarm.as_mut().reset(due);
            }
            if alarm.as_mut().poll(cx).is_pending() {
                return Poll::Pending;
            }
        }
    }
}

impl Task {
    /// Opens the link, unless that goes on already; whether it does so now. What is urgent does not wait for an
    /// attempt that was made before it, and such an attempt ends when nothing urgent is left.
    fn dials(&mut self, Dial { pause, urgent }: Dial) -> bool {
        let goes_on = self.dialing.is_some() && self.urgently == urgent;
        let Some(redial) = self.redial.clone().filter(|_| !goes_on) else { return false };
        lock(&self.engine).dialing();
        self.urgently = urgent;
        self.dialing = Some(Box::pin(async move {
            sleep(pause).await;
            let opening = (lock(&redial.0))(urgent);
            opening.await
        }));
        true
    }
}

impl Drop for Task {
    fn drop(&mut self) {
        lock(&self.engine).end();
    }
}
