//! Large answers: few at once, so that clients that do not read them hold little memory. And what takes
//! longer to make than a Stop may wait: on a thread of its own.

use std::collections::HashMap;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};
use std::time::Duration;

use axum::body::{Body, Bytes};
use axum::extract::{Request, State};
use axum::http::{Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use hyper::body::{Body as HttpBody, Frame, SizeHint};
use lafet_texts::{Text as _, hub as text};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

use super::guard;
use crate::error::ApiError;
use crate::hub::Hub;
use crate::sync::lock;

/// Readings that are being answered, of one user and in all.
const EACH_MAX: usize = 4;
const ALL_MAX: usize = 16;
/// A reading waits this long for its turn.
const PATIENCE: Duration = Duration::from_secs(10);
/// An answer of this size or less is done with when it is made.
const SMALL: u64 = 64 * 1024;
/// Users that are remembered though nothing of theirs is being answered.
const REMEMBERED_MAX: usize = 1000;

/// Work beside that is done, of one user and in all; what strangers want is done apart.
const WORK_EACH_MAX: usize = 2;
const WORK_ALL_MAX: usize = 1;

/// Who is being sent an answer, and whose is being made.
#[derive(Debug)]
pub struct Answering {
    readings: Turns,
    work: Turns,
    strangers: Turns,
}

/// Turns: so many at once, and so many of one user, who does not take or wait for all of them.
#[derive(Debug)]
struct Turns {
    all: Arc<Semaphore>,
    each: Mutex<HashMap<String, Arc<Semaphore>>>,
    each_max: usize,
}

/// Held while an answer is made and taken.
type Turn = (OwnedSemaphorePermit, OwnedSemaphorePermit);

impl Default for Answering {
    fn default() -> Self {
        let work = || Turns::new(WORK_ALL_MAX, WORK_EACH_MAX);
        Self { readings: Turns::new(ALL_MAX, EACH_MAX), work: work(), strangers: work() }
    }
}

/// Too much of the same client waits, or of all.
fn busy() -> ApiError {
    let text = text::AnswersTooMany.words();
    ApiError::new(StatusCode::SERVICE_UNAVAILABLE, "busy", text)
}

impl Answering {
    /// Does what takes milliseconds of the processor without holding up what has to be quick: one such work at a
    /// time, and few of one client wait. Strangers are `None`.
    ///
    /// # Errors
    ///
    /// 503, `busy`: its turn has not come in time.
    pub async fn beside<T: Send + 'static>(
        &self,
        who: Option<&str>,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, ApiError> {
        let turns = if who.is_some() { &self.work } else { &self.strangers };
        let turn = turns.turn(who.unwrap_or_default()).await.ok_or_else(busy)?;
        // A client that does not wait any more has its turn until the work is done.
        let done = move || {
            let _turn = turn;
            work()
        };
        tokio::task::spawn_blocking(done).await.map_err(|error| match error.try_into_panic() {
            Ok(panic) => std::panic::resume_unwind(panic),
            Err(_) => busy(),
        })
    }
}

impl Turns {
    fn new(all_max: usize, each_max: usize) -> Self {
        Self { all: Arc::new(Semaphore::new(all_max)), each: Mutex::default(), each_max }
    }

    async fn turn(&self, who: &str) -> Option<Turn> {
        let own = {
            let mut each = lock(&self.each);
            if each.len() >= REMEMBERED_MAX {
                each.retain(|_, own| Arc::strong_count(own) > 1);
            }
            let own = each.entry(who.to_owned());
            own.or_insert_with(|| Arc::new(Semaphore::new(self.each_max))).clone()
        };
        let turn = async {
            let own = own.acquire_owned().await.ok()?;
            Some((own, self.all.clone().acquire_owned().await.ok()?))
        };
        timeout(PATIENCE, turn).await.ok().flatten()
    }
}

/// Lets few readings be answered at once. What changes something, and WebSockets, are not concerned.
pub async fn bounded(State(hub): State<Hub>, request: Request, next: Next) -> Response {
    let path = request.uri().path();
    let metrics = path == "/metrics";
    let reads = matches!(*request.method(), Method::GET | Method::HEAD)
        && (path.starts_with("/api/") || metrics)
        && path != "/api/ws";
    if !reads {
        return next.run(request).await;
    }
    let (parts, body) = request.into_parts();
    // Strangers are answered with little, but for the metrics where these are open to all.
    let stranger = || metrics.then(|| guard::address(&parts, &hub).to_string());
    let who = guard::key(&parts, &hub).or_else(stranger);
    let Some(who) = who else {
        return next.run(Request::from_parts(parts, body)).await;
    };
    let Some(turn) = hub.answering().readings.turn(&who).await else {
        return busy().into_response();
    };
    let response = next.run(Request::from_parts(parts, body)).await;
    if response.body().size_hint().upper().is_some_and(|size| size <= SMALL) {
        return response;
    }
    response.map(|body| Body::new(Held { body, _turn: turn }))
}

/// A body that holds its turn until it is taken.
struct Held {
    body: Body,
    _turn: Turn,
}

impl HttpBody for Held {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(cx)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn one_user_does_not_take_every_turn() {
        let answering = Answering::default().readings;
        let mut held = Vec::new();
        for _ in 0..EACH_MAX {
            held.push(answering.turn("a").await.unwrap());
        }
        assert!(answering.turn("a").await.is_none());
        held.push(answering.turn("b").await.unwrap());
        drop(held.remove(0));
        held.push(answering.turn("a").await.unwrap());
    }

    #[tokio::test]
    async fn work_of_a_client_that_has_gone_keeps_its_turn_until_it_is_done() {
        let answering = Arc::new(Answering::default());
        let (starts, has_started) = tokio::sync::oneshot::channel();
        let (ends, end) = std::sync::mpsc::channel::<()>();
        let own = answering.clone();
        let gone = tokio::spawn(async move {
            let work = move || {
                _ = starts.send(());
                _ = end.recv();
            };
            _ = own.beside(Some("a"), work).await;
        });
        has_started.await.unwrap();
        gone.abort();
        assert!(gone.await.unwrap_err().is_cancelled());
        let of_another = answering.beside(Some("b"), || ());
        let mut of_another = std::pin::pin!(of_another);
        assert!(timeout(Duration::from_millis(100), &mut of_another).await.is_err());
        assert!(answering.beside(None, || ()).await.is_ok(), "a stranger's is apart");
        ends.send(()).unwrap();
        assert!(of_another.await.is_ok());
    }
}
