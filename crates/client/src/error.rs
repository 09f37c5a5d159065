//! Errors: each message says what, where and what to do, in English and Russian.

use std::fmt;
use std::io;
use std::sync::Arc;

use lafet_proto::{RequestId, Status, SubsystemId};
pub use lafet_texts::Lang;

use crate::deviation::Deviation;
use crate::os_text::os_text;
use crate::outcome_check::outcome_check;
use crate::port_error::{CannotSwitch, PortError};
use crate::refusal::{Reason, reason};
use crate::url_error::UrlError;

/// Error of a request.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Error {
    /// The monitor refused the request.
    Refused {
        /// The request.
        request: RequestId,
        /// The addressee.
        to: SubsystemId,
        /// The refusal.
        status: Status,
        /// The subsystem that refused: the addressee, or one that intercepted the request (§1).
        by: SubsystemId,
    },
    /// No answer to a request that changes nothing.
    NoAnswer {
        /// The request.
        request: RequestId,
        /// The addressee.
        to: SubsystemId,
        /// The link.
        endpoint: Arc<str>,
        /// Number of transmissions.
        tries: u32,
        /// A request that was not sent but that the monitor answered meanwhile.
        stray: Option<RequestId>,
    },
    /// No device answers presence probes.
    Absent {
        /// The link.
        endpoint: Arc<str>,
        /// Number of probes sent.
        tries: u32,
    },
    /// No presence probe was sent.
    NotProbed {
        /// The link.
        endpoint: Arc<str>,
        /// Why none was sent.
        cause: Cause,
    },
    /// The request was sent; whether it was executed is not known.
    OutcomeUnknown {
        /// The request.
        request: RequestId,
        /// The addressee.
        to: SubsystemId,
        /// The link.
        endpoint: Arc<str>,
        /// Why the outcome is unknown.
        cause: Cause,
    },
    /// The request was not sent, so it is certainly not executed.
    NotSent {
        /// The request.
        request: RequestId,
        /// The addressee.
        to: SubsystemId,
        /// Why it was not sent.
        cause: Cause,
    },
    /// There is no connection.
    Link {
        /// The link.
        endpoint: Arc<str>,
        /// The error of the operating system.
        source: Arc<io::Error>,
    },
    /// The answer to a request that changes nothing breaks the protocol.
    Protocol {
        /// The request.
        request: RequestId,
        /// The subsystem that answered, or should have answered.
        from: SubsystemId,
        /// The deviation of the answer.
        what: Deviation,
    },
    /// The request is longer than a record can be (§2: 255 bytes of data).
    Unsendable {
        /// The request.
        request: RequestId,
        /// The addressee.
        to: SubsystemId,
    },
    /// A subscription to a request that changes something.
    NotARead {
        /// The request.
        request: RequestId,
        /// The addressee.
        to: SubsystemId,
    },
    /// There can be no monitor with this address on the link.
    Address {
        /// The address.
        address: u8,
        /// The link.
        endpoint: Arc<str>,
    },
    /// The URL is invalid.
    Url(UrlError),
    /// `sim:` without a simulator.
    NeedsStream,
    /// The client's task has ended.
    Closed,
}

/// Why a request was not sent, or its outcome is unknown.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Cause {
    /// No answer came.
    Silence,
    /// The answer breaks the protocol.
    Odd {
        /// The subsystem that answered, or should have answered.
        from: SubsystemId,
        /// The deviation of the answer.
        what: Deviation,
    },
    /// The connection was lost, or there was none.
    Link(Arc<io::Error>),
    /// A Stop, Close or Lockout was sent first and cancelled it.
    Superseded {
        /// The urgent request.
        by: RequestId,
    },
    /// Too many requests wait already.
    QueueFull,
    /// Its time limit passed before its turn came.
    Expired,
    /// Another request of the same batch failed.
    EarlierFailed,
    /// A CRC-32C is required, and the monitor does not support it.
    CheckMissing,
    /// A console waits for a grant, and there is no bus controller.
    NoController,
    /// The bus controller does not grant access to this console.
    NotGranted,
    /// There is a bus controller, and the request was not to wait for a grant.
    ControllerPresent,
}

impl Error {
    /// The message in a language.
    pub fn localized(&self, lang: Lang) -> String {
        match lang {
            Lang::En => self.english(),
            Lang::Ru => self.russian(),
        }
    }

    /// Whether the monitor answered with a refusal.
    pub const fn is_refused(&self) -> bool {
        matches!(self, Self::Refused { .. })
    }

    /// Whether the caller asked for something that cannot be sent.
    pub const fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::Unsendable { .. }
                | Self::NotARead { .. }
                | Self::Address { .. }
                | Self::Url(_)
                | Self::NeedsStream
        )
    }

    /// Whether there is no valid answer.
    pub const fn is_no_answer(&self) -> bool {
        !self.is_refused() && !self.is_usage()
    }

    fn english(&self) -> String {
        match self {
            Self::Refused { request, to, status, by } => {
                let Reason { why, remedy, .. } = reason(*request, *to, *status, *by);
                format!("{request} {to}: {by} answers {status}. {} {}", why.en, remedy.en)
            }
            Self::NoAnswer { request, to, endpoint, tries, stray: Some(stray) } => format!(
                "{request} {to}: no answer from {endpoint} (tries: {tries}). What came answers \
                 {stray}, which was not asked: another program uses this connection, or the \
                 monitor's program does not follow the protocol."
            ),
            Self::NoAnswer { request, to, endpoint, tries, .. } => format!(
                "{request} {to}: no answer from {endpoint} (tries: {tries}). Check the power, \
                 the cable, the address (addr=) and, on a serial line, the speed (baud=)."
            ),
            Self::Absent { endpoint, tries } => format!(
                "No device answers at {endpoint} (probes: {tries}). Check the power, the cable, \
                 the address (addr=) and, on a serial line, the speed (baud=)."
            ),
            Self::NotProbed { endpoint, cause } => {
                format!("Nothing was sent to {endpoint}, because {}.", cause.english())
            }
            Self::OutcomeUnknown { request, to, endpoint, cause } => format!(
                "{request} {to}: sent to {endpoint}, but {}. It may have been executed. {}",
                cause.english(),
                outcome_check(*request).en
            ),
            Self::NotSent { request, to, cause } => format!(
                "{request} {to}: not sent, because {}. Nothing was executed: repeat it if it is \
                 still wanted.",
                cause.english()
            ),
            Self::Link { endpoint, source } if cannot_switch(source) => format!(
                "{endpoint}: the driver of this port cannot switch the direction of RS-485 by RTS \
                 ({source}). Leave out rs485= if the adapter does it by itself, as most on USB do."
            ),
            Self::Link { endpoint, source } => match PortError::of(source) {
                Some(error) => format!("{endpoint}: {error}"),
                None => format!(
                    "No connection to {endpoint}: {source}. Check that the monitor is on and that \
                     host, port or device are right."
                ),
            },
            Self::Protocol { request, from, what } => format!(
                "{request} {from}: the monitor answered, but not what the protocol says: {what}. \
                 The monitor's program does not follow the protocol: note it and report it."
            ),
            Self::Unsendable { request, to } => format!(
                "{request} {to}: more than a request can carry (255 bytes of data, 63 values). \
                 Send fewer values."
            ),
            Self::NotARead { request, to } => format!(
                "{request} {to} changes something, so it cannot be asked again and again. \
                 Subscribe to a request that reads."
            ),
            Self::Address { address, endpoint } => format!(
                "{endpoint}: {address} is no address of another device there. Monitors have 1…127; \
                 bare records (framing=records) lead to one monitor only."
            ),
            Self::Url(error) => error.to_string(),
            Self::NeedsStream => {
                "sim: needs a simulator in this process. Give the client its stream, or start \
                 `lafet sim` and connect to the address it prints."
                    .into()
            }
            Self::Closed => "The client has been shut down. Make a new one.".into(),
        }
    }

    fn russian(&self) -> String {
        match self {
            Self::Refused { request, to, status, by } => {
                let Reason { why, remedy, .. } = reason(*request, *to, *status, *by);
                format!("{request} {to}: {by} отвечает {status}. {} {}", why.ru, remedy.ru)
            }
            Self::NoAnswer { request, to, endpoint, tries, stray: Some(stray) } => format!(
                "{request} {to}: нет ответа от {endpoint}, попыток: {tries}. Пришёл ответ на \
                 {stray}, которого не запрашивали: соединением пользуется другая программа или \
                 программа ствола отступает от протокола."
            ),
            Self::NoAnswer { request, to, endpoint, tries, .. } => format!(
                "{request} {to}: нет ответа от {endpoint}, попыток: {tries}. Проверьте питание, \
                 кабель, адрес (addr=), а на последовательной линии и скорость (baud=)."
            ),
            Self::Absent { endpoint, tries } => format!(
                "На {endpoint} никто не отвечает, проб: {tries}. Проверьте питание, кабель, адрес \
                 (addr=), а на последовательной линии и скорость (baud=)."
            ),
            Self::NotProbed { endpoint, cause } => {
                format!("На {endpoint} ничего не отправлено, так как {}.", cause.russian())
            }
            Self::OutcomeUnknown { request, to, endpoint, cause } => format!(
                "{request} {to}: отправлено на {endpoint}, но {}. Запрос мог быть исполнен. {}",
                cause.russian(),
                outcome_check(*request).ru
            ),
            Self::NotSent { request, to, cause } => format!(
                "{request} {to}: не отправлено, так как {}. Ничего не исполнено: повторите, если \
                 это всё ещё нужно.",
                cause.russian()
            ),
            Self::Link { endpoint, source } if cannot_switch(source) => format!(
                "{endpoint}: драйвер этого порта не умеет переключать направление RS-485 сигналом \
                 RTS ({}). Уберите rs485=, если адаптер делает это сам, как большинство на USB.",
                os_text(source, Lang::Ru)
            ),
            Self::Link { endpoint, source } => match PortError::of(source) {
                Some(error) => format!("{endpoint}: {}", error.localized(Lang::Ru)),
                None => format!(
                    "Нет соединения с {endpoint}: {}. Проверьте, что ствол включён и что узел, \
                     порт или устройство указаны верно.",
                    os_text(source, Lang::Ru)
                ),
            },
            Self::Protocol { request, from, what } => format!(
                "{request} {from}: ствол ответил, но не так, как требует протокол: {}. Программа \
                 ствола отступает от протокола: запишите и сообщите.",
                what.localized(Lang::Ru)
            ),
            Self::Unsendable { request, to } => format!(
                "{request} {to}: больше, чем вмещает запрос (255 байт данных, 63 значения). \
                 Отправьте меньше значений."
            ),
            Self::NotARead { request, to } => format!(
                "{request} {to} что-то изменяет, поэтому его нельзя повторять постоянно. \
                 Подпишитесь на запрос чтения."
            ),
            Self::Address { address, endpoint } => format!(
                "{endpoint}: {address} — не адрес другого устройства на этой линии. У стволов \
                 1…127; голые записи (framing=records) ведут только к одному стволу."
            ),
            Self::Url(error) => error.localized(Lang::Ru),
            Self::NeedsStream => {
                "Для sim: нужен имитатор в этом же процессе. Передайте клиенту его поток или \
                 запустите `lafet sim` и подключитесь к напечатанному адресу."
                    .into()
            }
            Self::Closed => "Клиент завершил работу. Создайте новый.".into(),
        }
    }
}

impl Cause {
    fn english(&self) -> String {
        match self {
            Self::Silence => "no answer came".into(),
            Self::Odd { from, what } => {
                format!("the answer of {from} is not what the protocol says: {what}")
            }
            Self::Link(source) => format!("there is no connection ({source})"),
            Self::Superseded { by } => format!("{by} overtook it"),
            Self::QueueFull => "too many requests are waiting".into(),
            Self::Expired => "its time was over before its turn came".into(),
            Self::EarlierFailed => "another request of the batch failed".into(),
            Self::CheckMissing => {
                "the monitor answers frames with a CRC-16 only (use check=auto)".into()
            }
            Self::NoController => {
                "there is no controller on the bus to give access (use role=direct)".into()
            }
            Self::NotGranted => {
                "the controller of the bus gives this address no access (is src= one \
                                 that it looks for, and no other device's?)"
                    .into()
            }
            Self::ControllerPresent => {
                "there is a controller on the bus (use role=active, and a src= of your own)".into()
            }
        }
    }

    fn russian(&self) -> String {
        match self {
            Self::Silence => "ответ не пришёл".into(),
            Self::Odd { from, what } => {
                format!("ответ {from} не соответствует протоколу: {}", what.localized(Lang::Ru))
            }
            Self::Link(source) => match PortError::of(source) {
                Some(error) => format!("нет соединения ({})", error.localized(Lang::Ru)),
                None => format!("нет соединения ({})", os_text(source, Lang::Ru)),
            },
            Self::Superseded { by } => format!("его опередил запрос {by}"),
            Self::QueueFull => "слишком много запросов в очереди".into(),
            Self::Expired => "его время вышло раньше, чем подошла очередь".into(),
            Self::EarlierFailed => "не удался другой запрос пакета".into(),
            Self::CheckMissing => {
                "ствол отвечает только на кадры с CRC-16 (укажите check=auto)".into()
            }
            Self::NoController => {
                "на магистрали нет контроллера, который дал бы доступ (укажите role=direct)".into()
            }
            Self::NotGranted => "контроллер магистрали не даёт доступа этому адресу (ищет ли он \
                                 src=, и не занят ли этот адрес другим?)"
                .into(),
            Self::ControllerPresent => {
                "на магистрали есть контроллер (укажите role=active и свой src=)".into()
            }
        }
    }
}

/// Whether the user is not a member of the group that owns the serial port.
fn cannot_switch(source: &io::Error) -> bool {
    source.get_ref().is_some_and(|inner| inner.is::<CannotSwitch>())
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.english())
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Link { source, .. }
            | Self::OutcomeUnknown { cause: Cause::Link(source), .. }
            | Self::NotSent { cause: Cause::Link(source), .. } => Some(source.as_ref()),
            Self::Protocol { what: Deviation::Shape(source), .. } => Some(source),
            Self::Url(error) => Some(error),
            _ => None,
        }
    }
}

impl From<UrlError> for Error {
    fn from(error: UrlError) -> Self {
        Self::Url(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Error> {
        let (request, to) = (RequestId::MOVE, SubsystemId::VERTICAL);
        let endpoint: Arc<str> = "tcp://h:1?addr=1".into();
        let source = Arc::new(io::Error::from(io::ErrorKind::ConnectionRefused));
        let unknown = |cause| Error::OutcomeUnknown { request, to, endpoint: "x".into(), cause };
        let by = SubsystemId::DEPLOYER;
        let decode =
            lafet_proto::DecodeError { offset: 0, expected: lafet_proto::Expected::Size, got: 3 };
        vec![
            Error::Refused { request, to, status: Status::DENIED, by },
            Error::Refused { request, to, status: Status(77), by },
            Error::NoAnswer { request, to, endpoint: endpoint.clone(), tries: 3, stray: None },
            Error::Absent { endpoint: endpoint.clone(), tries: 3 },
            Error::NoAnswer {
                request,
                to,
                endpoint: endpoint.clone(),
                tries: 3,
                stray: Some(request),
            },
            unknown(Cause::Silence),
            unknown(Cause::Link(source.clone())),
            unknown(Cause::Superseded { by: RequestId::STOP }),
            Error::NotSent { request, to, cause: Cause::QueueFull },
            Error::NotSent { request, to, cause: Cause::EarlierFailed },
            Error::NotSent { request, to, cause: Cause::Expired },
            Error::NotSent { request, to, cause: Cause::CheckMissing },
            Error::NotSent { request, to, cause: Cause::NoController },
            Error::NotProbed { endpoint: endpoint.clone(), cause: Cause::NotGranted },
            Error::NotProbed { endpoint: endpoint.clone(), cause: Cause::ControllerPresent },
            Error::NotARead { request, to },
            Error::Address { address: 129, endpoint: endpoint.clone() },
            Error::Link { endpoint, source },
            Error::Protocol { request, from: by, what: Deviation::Shape(decode) },
            Error::Protocol { request, from: by, what: Deviation::NoData },
            unknown(Cause::Odd { from: by, what: Deviation::UnknownStatus(Status(200)) }),
            Error::Unsendable { request, to },
            Error::Url("x:".parse::<crate::Endpoint>().unwrap_err()),
            Error::NeedsStream,
            Error::Closed,
        ]
    }

    #[test]
    fn every_error_speaks_both_languages_and_ends_its_sentences() {
        for error in all() {
            let (english, russian) = (error.to_string(), error.localized(Lang::Ru));
            let cyrillic = |text: &str| text.chars().any(|c| ('а'..='я').contains(&c));
            assert!(!cyrillic(&english) && cyrillic(&russian), "{english} / {russian}");
            assert!(english.ends_with('.') && russian.ends_with('.'), "{english} / {russian}");
        }
    }

    #[test]
    fn a_refusal_names_request_addressee_status_and_who_refused() {
        let text = all()[0].to_string();
        for word in ["Move", "Vertical", "Denied", "Deployer"] {
            assert!(text.contains(word), "{text}");
        }
    }

    #[test]
    fn every_error_has_one_kind() {
        for error in all() {
            let kinds = [error.is_refused(), error.is_usage(), error.is_no_answer()];
            assert_eq!(kinds.iter().filter(|is| **is).count(), 1, "{error}");
        }
    }
}
