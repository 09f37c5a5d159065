//! A request to a monitor: read once, where it comes in.

use lafet_client::{Lang, RequestBuf, parse_error_text};
use lafet_proto::request::Body;
use lafet_proto::text::{BUFFER_SIZE, ParseError, parse};
use lafet_proto::{Request, RequestId, SubsystemId};
use lafet_texts::{Text as _, hub as text};

use crate::access::{Need, need};
use crate::error::{ApiError, Details};
use crate::store::Act;
use crate::text::Both;

/// Longest text of a request.
const TEXT_MAX: usize = 4096;

/// A request and what it needs. Equal ones have equal bytes.
#[derive(Clone, Debug)]
pub struct MonitorRequest {
    buf: RequestBuf,
    text: String,
    need: Need,
}

impl MonitorRequest {
    /// Reads the text form, `Move Vertical 1200`.
    pub fn parse(text: &str) -> Result<Self, ApiError> {
        if text.len() > TEXT_MAX {
            let text = text::RequestTooLong.words();
            let status = axum::http::StatusCode::PAYLOAD_TOO_LARGE;
            return Err(ApiError::new(status, "too_large", text));
        }
        let mut buffer = [0; BUFFER_SIZE];
        Self::new(&parse(text, &mut buffer).map_err(|error| wrong(text, &error))?)
    }

    /// A request that is not the bus controller's own.
    pub fn new(request: &Request<'_>) -> Result<Self, ApiError> {
        let buf = RequestBuf::new(request).map_err(|error| ApiError::from(&error))?;
        let need =
            needed(&buf).ok_or_else(|| ApiError::bad_request(text::BusControllerOwn.words()))?;
        Ok(Self { need, text: request.to_string(), buf })
    }

    /// Stops a subsystem, or All.
    pub fn stop(of: SubsystemId) -> Result<Self, ApiError> {
        Self::new(&Request::new(of, Body::Stop))
    }

    /// What moves a drive: a Stop undoes it as it does every motion.
    pub fn moving(drive: SubsystemId) -> Result<Self, ApiError> {
        Self::new(&Request::new(drive, Body::Move { destination: 0 }))
    }

    /// Closes a valve.
    pub fn close(valve: SubsystemId) -> Result<Self, ApiError> {
        Self::new(&Request::close(valve))
    }

    /// Locks the monitor out.
    pub fn lockout() -> Result<Self, ApiError> {
        Self::new(&Request::lockout(true))
    }

    /// Id of the request.
    pub const fn id(&self) -> RequestId {
        self.buf.id()
    }

    /// The addressee.
    pub const fn to(&self) -> SubsystemId {
        self.buf.to()
    }

    /// Role and conditions that the request needs.
    pub const fn need(&self) -> Need {
        self.need
    }

    /// The text form.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its bytes on the wire.
    pub const fn buf(&self) -> &RequestBuf {
        &self.buf
    }

    /// What the audit log has of it.
    pub fn act(&self) -> Act {
        let mut words = self.text.split(' ').map(str::to_owned);
        let (request, to) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        Act::Request { request, to }
    }
}

/// What a request needs. One that was written in numbers counts as what its bytes mean.
fn needed(request: &RequestBuf) -> Option<Need> {
    let Request { to, body } = request.request();
    let foreign = || need(RequestId(0), &body);
    match need(request.id(), &body)? {
        // Data that are not those of Stop or Close make it none. And what no monitor has cannot be
        // stopped: there are too many such names to let each of them overtake.
        Need { urgent: true, .. }
            if matches!(body, Body::Unknown { .. }) || to.name().is_none() =>
        {
            foreign()
        }
        need => Some(need),
    }
}

fn wrong(text: &str, error: &ParseError) -> ApiError {
    let what = Both {
        en: parse_error_text(text, error, Lang::En),
        ru: parse_error_text(text, error, Lang::Ru),
    };
    ApiError::bad_request(what).with(Details {
        column: Some(error.column),
        length: Some(error.len),
        suggestion: error.suggestion,
        ..Details::default()
    })
}
