//! Why the API does not do something: a class, a code for programs, a text for people.

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use lafet_client::{Answers, Error};
use serde_json::{Map, Value, json};

use crate::access::{AccessError, Role};
use crate::authority::{Refusal, Seat};
use crate::model;
use crate::store::StoreError;
use crate::text::{Both, both};

/// Characters of a client's own text that an answer repeats.
const SHOWN_MAX: usize = 64;

/// The beginning of a client's own text: answers stay small whatever is sent.
pub fn shown(text: &str) -> &str {
    text.char_indices().nth(SHOWN_MAX).map_or(text, |(end, _)| text.get(..end).unwrap_or_default())
}

/// An error of the API.
#[derive(Clone, Debug)]
pub struct ApiError {
    /// Its class.
    pub status: StatusCode,
    /// Its reason, for programs.
    pub code: &'static str,
    /// What happened, and what to do.
    pub text: Box<Both>,
    details: Map<String, Value>,
}

impl ApiError {
    /// An error.
    pub fn new(status: StatusCode, code: &'static str, text: Both) -> Self {
        Self { status, code, text: Box::new(text), details: Map::new() }
    }

    /// The same with a detail.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.details.insert(name.into(), value.into());
        self
    }

    /// What was asked makes no sense.
    pub fn bad_request(text: Both) -> Self {
        Self::new(StatusCode::BAD_REQUEST, "bad_request", text)
    }

    /// There is no monitor of this id.
    pub fn no_monitor(id: &str) -> Self {
        let id = shown(id);
        let text = both(format!("There is no monitor {id}."), format!("Ствола {id} нет."));
        Self::new(StatusCode::NOT_FOUND, "no_monitor", text)
    }

    /// There is nothing here.
    pub fn not_found() -> Self {
        let text = both(
            "There is nothing here. See /api/openapi.json.",
            "Здесь ничего нет. См. /api/openapi.json.",
        );
        Self::new(StatusCode::NOT_FOUND, "not_found", text)
    }

    /// The role does not suffice.
    pub fn role(needs: Role) -> Self {
        let text = both(
            format!("This needs the role {}.", needs.text().en),
            format!("Нужна роль «{}».", needs.text().ru),
        );
        Self::new(StatusCode::FORBIDDEN, "role", text).with("needs", needs.name())
    }

    /// The session was ended, not by its own user.
    pub fn ended() -> Self {
        let text = both(
            "This session was ended: only Stop still works, for ten minutes. Log in.",
            "Сеанс завершён: ещё десять минут работает только «Стоп». Войдите снова.",
        );
        Self::new(StatusCode::UNAUTHORIZED, "login_needed", text)
    }

    /// Too many requests.
    pub fn slow_down(wait: std::time::Duration) -> Self {
        let wait_ms = u64::try_from(wait.as_millis()).unwrap_or(u64::MAX).max(1);
        // People count seconds.
        let wait_s = wait_ms.div_ceil(1000);
        let text = both(
            format!("Too fast. Try again in {wait_s} s."),
            format!("Слишком часто. Повторите через {wait_s} с."),
        );
        Self::new(StatusCode::TOO_MANY_REQUESTS, "slow_down", text).with("retry_after_ms", wait_ms)
    }

    /// Authority is refused.
    pub fn authority(monitor: &str, refusal: Refusal) -> Self {
        let held = |seat: Seat, code| {
            let user = &seat.user;
            let text = both(
                format!("{monitor} is held by {user}. Request control, or wait."),
                format!("{monitor} управляет {user}. Запросите управление или подождите."),
            );
            Self::new(StatusCode::CONFLICT, code, text).with("holder", json!(seat))
        };
        match refusal {
            Refusal::Held(seat) => held(seat, "held"),
            Refusal::NotHolder(Some(seat)) => held(seat, "no_authority"),
            Refusal::NotHolder(None) => {
                let text = both(
                    format!("Nobody holds {monitor}. Take control first."),
                    format!("{monitor} никем не управляется. Сначала возьмите управление."),
                );
                Self::new(StatusCode::CONFLICT, "no_authority", text).with("holder", Value::Null)
            }
            Refusal::NoRequest => {
                let text = both("Nobody asks for control.", "Никто не запрашивает управление.");
                Self::new(StatusCode::CONFLICT, "no_request", text)
            }
            Refusal::NoReason => Self::bad_request(both(
                "Taking over by force needs a reason, 5 characters or more.",
                "Для принудительного захвата нужна причина, не короче 5 знаков.",
            )),
        }
    }

    /// The monitor refuses.
    pub fn refused(answers: &Answers) -> Self {
        let refusal = answers.clone().accepted().err();
        let text = refusal.as_ref().map(Both::of_error).unwrap_or_default();
        let list = model::answers(answers);
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, "refused", text).with("answers", list)
    }

    /// There is no connection to a monitor yet.
    pub fn not_connected(monitor: &str) -> Self {
        let text = both(
            format!("There is no connection to {monitor}. Nothing was sent."),
            format!("Нет соединения с {monitor}. Ничего не отправлено."),
        );
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "not_connected", text)
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        let mut all = self.details.clone();
        all.insert("code".into(), self.code.into());
        all.insert("en".into(), self.text.en.clone().into());
        all.insert("ru".into(), self.text.ru.clone().into());
        Value::Object(all)
    }
}

impl From<&Error> for ApiError {
    fn from(error: &Error) -> Self {
        let (status, code) = match error {
            Error::NoAnswer { .. } | Error::Absent { .. } | Error::Protocol { .. } => {
                (StatusCode::BAD_GATEWAY, "no_answer")
            }
            Error::OutcomeUnknown { .. } => (StatusCode::BAD_GATEWAY, "outcome_unknown"),
            Error::NotSent { .. } | Error::Closed => (StatusCode::SERVICE_UNAVAILABLE, "not_sent"),
            Error::Link { .. } => (StatusCode::SERVICE_UNAVAILABLE, "not_connected"),
            Error::Refused { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "refused"),
            _ => (StatusCode::BAD_REQUEST, "bad_request"),
        };
        Self::new(status, code, Both::of_error(error))
    }
}

impl From<StoreError> for ApiError {
    fn from(error: StoreError) -> Self {
        let text = match &error {
            StoreError::Away => both(
                "PostgreSQL, which has the history, does not answer. Check that server.",
                "PostgreSQL, где хранится история, не отвечает. Проверьте этот сервер.",
            ),
            #[cfg(feature = "postgres")]
            StoreError::Postgres(_) => both(
                format!("PostgreSQL, which has the history: {error}. Check that server."),
                format!("PostgreSQL, где хранится история: {error}. Проверьте этот сервер."),
            ),
            _ => both(
                format!("The hub's storage does not work: {error}. Check the disk."),
                format!("Хранилище не работает: {error}. Проверьте диск."),
            ),
        };
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "storage", text)
    }
}

impl From<AccessError> for ApiError {
    fn from(error: AccessError) -> Self {
        match error {
            AccessError::Wrong => Self::new(
                StatusCode::UNAUTHORIZED,
                "login_failed",
                both(
                    "Wrong user, password or link. Each failure makes the next try wait longer.",
                    "Неверный пользователь, пароль или ссылка. С каждой ошибкой ждать дольше.",
                ),
            ),
            AccessError::Conflict => Self::new(
                StatusCode::CONFLICT,
                "held",
                both(
                    "There is one of this name already, or it is the last administrator.",
                    "Такой уже есть, либо это последний администратор.",
                ),
            ),
            AccessError::Missing => Self::not_found(),
            AccessError::Name(what) => Self::bad_request(what).with("field", "user"),
            AccessError::Weak(what) => Self::bad_request(what).with("field", "password"),
            AccessError::Busy => Self::slow_down(std::time::Duration::from_secs(5)),
            AccessError::Store(error) => error.into(),
        }
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let body = json!({ "error": self.json() });
        let mut response = (self.status, axum::Json(body)).into_response();
        if let Some(wait_ms) = self.details.get("retry_after_ms").and_then(Value::as_u64) {
            let seconds = HeaderValue::from(wait_ms.div_ceil(1000));
            response.headers_mut().insert(header::RETRY_AFTER, seconds);
        }
        response
    }
}
