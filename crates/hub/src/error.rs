//! Why the API does not do something: a class, a code for programs, a text for people.

use std::time::Duration;

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use lafet_client::refusal::Flags;
use lafet_client::{Answers, Error};
use lafet_texts::{Text as _, hub as text};
use serde::Serialize;
use utoipa::ToSchema;

use crate::access::{AccessError, Role, Standing};
use crate::command::outcome::{Answered, answered};
use crate::control::authority::{Refusal, Seat};
use crate::store::StoreError;
use crate::text::Both;

/// Characters of a client's own text that an answer repeats.
const SHOWN_MAX: usize = 64;

/// The beginning of a client's own text: answers stay small whatever is sent.
pub fn shown(text: &str) -> &str {
    text.char_indices().nth(SHOWN_MAX).map_or(text, |(end, _)| text.get(..end).unwrap_or_default())
}

/// An error of the API.
#[derive(Clone, Debug)]
pub struct ApiError {
    /// HTTP status.
    pub status: StatusCode,
    /// Code for programs.
    pub code: &'static str,
    /// What happened, and what to do.
    pub text: Box<Both>,
    details: Box<Details>,
}

/// What else is known of an error; each code has its own.
#[derive(Clone, Debug, Default, Serialize, ToSchema)]
pub struct Details {
    /// `role`: at least this one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub needs: Option<&'static str>,
    /// `slow_down`: not before this time has passed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub retry_after_ms: Option<u64>,
    /// Where a request's text is wrong, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
    /// How long that part is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<usize>,
    /// The value that was probably meant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suggestion: Option<&'static str>,
    /// `held`, `no_authority`: the holder; null: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Seat>)]
    pub holder: Option<Option<Seat>>,
    /// `refused`: what the monitor answered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub answers: Option<Vec<Answered>>,
    /// Number of the entry in the audit log; null while the disk takes none.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<u64>)]
    pub audit: Option<Option<u64>>,
    /// The field of the body that is wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field: Option<&'static str>,
    /// `login_needed`: there is no user yet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub setup_needed: Option<bool>,
    /// `login_needed`: what has become of the session.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standing: Option<Standing>,
    /// `login_needed`: Stop still passes for this time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_ms: Option<u64>,
}

/// An error as clients get it.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ErrorBody {
    /// Code for programs.
    pub code: &'static str,
    /// What happened and what to do, in English.
    pub en: String,
    /// Text in Russian.
    pub ru: String,
    /// Further data, by code.
    #[serde(flatten)]
    pub details: Details,
}

/// The body of an answer that is an error.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Failed {
    /// The error.
    pub error: ErrorBody,
}

impl ApiError {
    /// An error with this HTTP status and code.
    pub fn new(status: StatusCode, code: &'static str, text: Both) -> Self {
        Self { status, code, text: Box::new(text), details: Box::default() }
    }

    /// The same with these details.
    #[must_use]
    pub fn with(self, details: Details) -> Self {
        Self { details: Box::new(details), ..self }
    }

    /// The same with the number of its entry in the audit log.
    #[must_use]
    pub fn noted(mut self, audit: Option<u64>) -> Self {
        self.details.audit = Some(audit);
        self
    }

    /// What was asked makes no sense.
    pub fn bad_request(text: Both) -> Self {
        Self::new(StatusCode::BAD_REQUEST, "bad_request", text)
    }

    /// The same of a field of the body.
    #[must_use]
    fn of(mut self, field: &'static str) -> Self {
        self.details.field = Some(field);
        self
    }

    /// There is no monitor of this id.
    pub fn no_monitor(id: &str) -> Self {
        let id = shown(id);
        let text = text::NoMonitor { id }.words();
        Self::new(StatusCode::NOT_FOUND, "no_monitor", text)
    }

    /// The same of an urgent request: what was to stop goes on.
    pub fn nothing_stopped(id: &str) -> Self {
        let text = text::NothingStopped { id: shown(id) }.words();
        Self::new(StatusCode::NOT_FOUND, "no_monitor", text)
    }

    /// 404: there is no camera of this id.
    pub fn no_camera(id: &str) -> Self {
        let text = text::NoCamera { id: shown(id) }.words();
        Self::new(StatusCode::NOT_FOUND, "no_camera", text)
    }

    /// 503: a camera has as many viewers as it can have.
    pub fn too_many_viewers() -> Self {
        let text = text::TooManyViewers.words();
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "too_many_viewers", text)
    }

    /// 404: no zones are configured.
    pub fn no_zones() -> Self {
        let text = text::NoZones.words();
        Self::new(StatusCode::NOT_FOUND, "no_zones", text)
    }

    /// 404: there is no detector of this id.
    pub fn no_detector(id: &str) -> Self {
        let id = shown(id);
        let text = text::NoDetector { id }.words();
        Self::new(StatusCode::NOT_FOUND, "no_detector", text)
    }

    /// 409: a detector on a bus reports itself.
    pub fn detector_on_bus(id: &str, bus: &str) -> Self {
        let (id, bus) = (shown(id), shown(bus));
        let text = text::DetectorOnBus { id, bus }.words();
        Self::new(StatusCode::CONFLICT, "detector_on_bus", text)
    }

    /// The zone controller refuses: 404 for an unknown name, else 409.
    pub fn zone_refused(why: lafet_site::Refusal) -> Self {
        let status = match why {
            lafet_site::Refusal::Unknown => StatusCode::NOT_FOUND,
            _ => StatusCode::CONFLICT,
        };
        Self::new(status, "zone_refused", why.text())
    }

    /// 409: an order that was withdrawn before it was sent.
    pub fn void() -> Self {
        let text = text::OrderVoid.words();
        Self::new(StatusCode::CONFLICT, "void", text)
    }

    /// 409: the software of the monitor is being updated.
    pub fn updating(monitor: &str) -> Self {
        let text = text::UpdatesOrderRefused { monitor }.words();
        Self::new(StatusCode::CONFLICT, "updating", text)
    }

    /// 409: a request that was under way for too long.
    pub fn late() -> Self {
        Self::new(StatusCode::CONFLICT, "late", text::RequestLate.words())
    }

    /// 409: a beat of a motion by hand that was under way for too long.
    pub fn late_beat() -> Self {
        Self::new(StatusCode::CONFLICT, "late", text::BeatLate.words())
    }

    /// 400: the id has to be repeated.
    pub fn confirm_needed(id: &str) -> Self {
        let id = shown(id);
        let text = text::ConfirmNeeded { id }.words();
        Self::new(StatusCode::BAD_REQUEST, "confirm_needed", text)
    }

    /// 404: no such resource.
    pub fn not_found() -> Self {
        let text = text::NothingHere.words();
        Self::new(StatusCode::NOT_FOUND, "not_found", text)
    }

    /// The role does not suffice.
    pub fn role(needs: Role) -> Self {
        let text = text::RoleNeeded { role: needs.text() }.words();
        Self::new(StatusCode::FORBIDDEN, "role", text)
            .with(Details { needs: Some(needs.name()), ..Details::default() })
    }

    /// The session was ended, not by its own user.
    pub fn ended() -> Self {
        let text = text::SessionEnded.words();
        Self::new(StatusCode::UNAUTHORIZED, "login_needed", text)
    }

    /// 429: too many requests; `wait` until the next one.
    pub fn slow_down(wait: std::time::Duration) -> Self {
        let wait_ms = u64::try_from(wait.as_millis()).unwrap_or(u64::MAX).max(1);
        // People count seconds.
        let wait_s = wait_ms.div_ceil(1000);
        let text = text::TooFast { wait_s }.words();
        let details = Details { retry_after_ms: Some(wait_ms), ..Details::default() };
        Self::new(StatusCode::TOO_MANY_REQUESTS, "slow_down", text).with(details)
    }

    /// Authority is refused.
    pub fn authority(monitor: &str, refusal: Refusal) -> Self {
        let held = |seat: Seat, code| {
            let user = &seat.user;
            let text = text::ControlHeld { monitor, user }.words();
            let details = Details { holder: Some(Some(seat)), ..Details::default() };
            Self::new(StatusCode::CONFLICT, code, text).with(details)
        };
        match refusal {
            Refusal::Held(seat) => held(seat, "held"),
            Refusal::NotHolder(Some(seat)) => held(seat, "no_authority"),
            Refusal::NotHolder(None) => {
                let text = text::ControlFree { monitor }.words();
                let details = Details { holder: Some(None), ..Details::default() };
                Self::new(StatusCode::CONFLICT, "no_authority", text).with(details)
            }
            Refusal::NoRequest => {
                let text = text::ControlNotAsked.words();
                Self::new(StatusCode::CONFLICT, "no_request", text)
            }
            Refusal::NoReason => Self::bad_request(text::ForceNeedsReason.words()),
        }
    }

    /// 422: the monitor refuses; its flags show why.
    pub fn refused(answers: &Answers, flags: Flags<'_>) -> Self {
        let refusal = answers.clone().accepted().err();
        let text = refusal.map(|refusal| refusal.explained(flags).words()).unwrap_or_default();
        let details = Details { answers: Some(answered(answers, flags)), ..Details::default() };
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, "refused", text).with(details)
    }

    /// 409: water could go into a keep-out; where the barrel points is known, or not.
    pub fn keep_out(name: &str, located: bool) -> Self {
        let text = match located {
            true => text::KeepOutMet { name }.words(),
            false => text::KeepOutUnknown { name }.words(),
        };
        Self::new(StatusCode::CONFLICT, "keep_out", text)
    }

    /// There is no connection to a monitor yet.
    pub fn not_connected(monitor: &str) -> Self {
        let text = text::NotConnected { monitor }.words();
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "not_connected", text)
    }

    /// 502: what was asked of a monitor was not answered in the time that a client waits.
    pub fn no_answer_within(monitor: &str, waited: Duration) -> Self {
        let text = text::NoAnswerWithin { monitor, seconds: waited.as_secs() }.words();
        Self::new(StatusCode::BAD_GATEWAY, "no_answer", text)
    }

    /// The body of the HTTP response.
    pub fn body(&self) -> ErrorBody {
        let Both { en, ru } = *self.text.clone();
        ErrorBody { code: self.code, en, ru, details: *self.details.clone() }
    }
}

impl From<&Error> for ApiError {
    fn from(error: &Error) -> Self {
        let (status, code) = match error {
            Error::NoAnswer { .. } | Error::Absent { .. } | Error::Protocol { .. } => {
                (StatusCode::BAD_GATEWAY, "no_answer")
            }
            // A client that has ended may have sent it before.
            Error::OutcomeUnknown { .. } | Error::Closed => {
                (StatusCode::BAD_GATEWAY, "outcome_unknown")
            }
            Error::NotSent { .. } => (StatusCode::SERVICE_UNAVAILABLE, "not_sent"),
            Error::Link { .. } => (StatusCode::SERVICE_UNAVAILABLE, "not_connected"),
            Error::Refused { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "refused"),
            _ => (StatusCode::BAD_REQUEST, "bad_request"),
        };
        Self::new(status, code, error.words())
    }
}

impl From<StoreError> for ApiError {
    fn from(error: StoreError) -> Self {
        let text = match &error {
            StoreError::Away => text::PostgresAway.words(),
            #[cfg(feature = "postgres")]
            StoreError::Postgres(_) => text::PostgresFailed { error }.words(),
            _ => text::StorageFailed { error }.words(),
        };
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "storage", text)
    }
}

impl From<AccessError> for ApiError {
    fn from(error: AccessError) -> Self {
        match error {
            AccessError::Wrong => {
                Self::new(StatusCode::UNAUTHORIZED, "login_failed", text::LoginFailed.words())
            }
            AccessError::Conflict => {
                Self::new(StatusCode::CONFLICT, "held", text::AccessConflict.words())
            }
            AccessError::Missing => Self::not_found(),
            AccessError::Ended => Self::ended(),
            AccessError::Name(what) => Self::bad_request(what).of("user"),
            AccessError::Weak(what) => Self::bad_request(what).of("password"),
            AccessError::Busy => Self::slow_down(std::time::Duration::from_secs(5)),
            AccessError::Store(error) => error.into(),
        }
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let body = Failed { error: self.body() };
        let mut response = (self.status, axum::Json(body)).into_response();
        if let Some(wait_ms) = self.details.retry_after_ms {
            let seconds = HeaderValue::from(wait_ms.div_ceil(1000));
            response.headers_mut().insert(header::RETRY_AFTER, seconds);
        }
        response
    }
}
