//! A request that is answered before its body has come ends its connection.
//!
//! Its client has to know: what it sends next over that connection is lost, and that may be a Stop.

use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, ready};

use axum::body::{Body, Bytes, HttpBody};
use axum::extract::Request;
use axum::http::{HeaderValue, Version, header};
use axum::middleware::Next;
use axum::response::Response;
use futures_util::FutureExt;
use hyper::body::{Frame, SizeHint};

use super::BODY_MAX;
use crate::sync::lock;

/// What was not read of a body.
#[derive(Debug, Default)]
enum Rest {
    /// It is still being read.
    #[default]
    Unknown,
    Nothing,
    Left(Body),
}

/// A body that leaves what was not read of it.
struct Watched {
    body: Body,
    rest: Arc<Mutex<Rest>>,
}

impl Drop for Watched {
    fn drop(&mut self) {
        let body = std::mem::take(&mut self.body);
        *lock(&self.rest) = if body.is_end_stream() { Rest::Nothing } else { Rest::Left(body) };
    }
}

impl HttpBody for Watched {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let frame = ready!(Pin::new(&mut self.body).poll_frame(cx));
        if frame.is_none() {
            self.body = Body::empty();
        }
        Poll::Ready(frame)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

/// Adds `Connection: close` to an answer that is given before the body has come.
pub async fn ends_the_connection(request: Request, next: Next) -> Response {
    if request.body().is_end_stream() || request.version() > Version::HTTP_11 {
        return next.run(request).await;
    }
    let rest = Arc::<Mutex<Rest>>::default();
    let watched = rest.clone();
    let watch = |body| Body::new(Watched { body, rest: watched });
    let mut response = next.run(request.map(watch)).await;
    let rest = std::mem::take(&mut *lock(&rest));
    let has_come = match rest {
        Rest::Nothing => true,
        Rest::Left(body) => has_come(body).now_or_never() == Some(true),
        Rest::Unknown => false,
    };
    if !has_come {
        response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    }
    response
}

/// Whether the rest of a body is there, and short.
async fn has_come(body: Body) -> bool {
    axum::body::to_bytes(body, BODY_MAX).await.is_ok()
}
