//! A frame of requests that a caller waits for.

use std::future::Future;
use std::pin::Pin;
use std::sync::Mutex;
use std::task::{Context, Poll};

use crate::engine::{Engine, Job, Reply};
use crate::session::Ticket;
use crate::shared::{Shared, lock};

/// From the first poll to the outcome; `None` if the task of the client has ended. Dropped before
/// that, it cancels its requests.
#[derive(Debug)]
pub struct Exchange<'a> {
    engine: &'a Mutex<Engine>,
    shared: &'a Shared,
    state: State,
}

#[derive(Debug)]
enum State {
    New(Job),
    Waiting(Ticket),
    Done,
}

impl<'a> Exchange<'a> {
    pub const fn new(engine: &'a Mutex<Engine>, shared: &'a Shared, job: Job) -> Self {
        Self { engine, shared, state: State::New(job) }
    }
}

impl Future for Exchange<'_> {
    type Output = Option<Reply>;

    fn poll(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Self::Output> {
        if let State::New(job) = &self.state
            && job.is_urgent()
        {
            self.shared.stop_jogs(job.address, &job.requests);
            self.shared.look_elsewhere();
        }
        let mut engine = lock(self.engine);
        let ended = match std::mem::replace(&mut self.state, State::Done) {
            State::New(job) => {
                let now = engine.now();
                match engine.submit(now, job, cx.waker()) {
                    Ok(ticket) => {
                        self.state = State::Waiting(ticket);
                        Poll::Pending
                    }
                    Err(reply) => Poll::Ready(reply),
                }
            }
            State::Waiting(ticket) => {
                let ended = engine.poll(ticket, cx.waker());
                if ended.is_pending() {
                    self.state = State::Waiting(ticket);
                }
                ended
            }
            State::Done => Poll::Ready(None),
        };
        let news = engine.news();
        drop(engine);
        if let Some(state) = news {
            self.shared.publish(state);
        }
        ended
    }
}

impl Drop for Exchange<'_> {
    fn drop(&mut self) {
        if let State::Waiting(ticket) = self.state {
            lock(self.engine).forget(ticket);
        }
    }
}
