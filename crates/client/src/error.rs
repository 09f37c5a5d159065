//! Errors: each message says what, where and what to do.

use std::fmt;
use std::io;
use std::sync::Arc;

use lafet_proto::{RequestId, Status, SubsystemId};
pub use lafet_texts::Lang;
use lafet_texts::{Argument, Shown, Text, client as text};

use crate::deviation::Deviation;
use crate::os_text::SystemError;
use crate::outcome_check::outcome_check;
use crate::port_error::{CannotSwitch, PortError};
use crate::refusal::{Flags, Reason, reason_now};
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
    /// Bytes that are no frames arrive, so it could disturb others.
    Unreadable,
}

impl Error {
    /// The message in a language.
    pub fn localized(&self, lang: Lang) -> String {
        self.of(lang)
    }

    /// The message with the flags of the monitor, which show the reason of a refusal.
    pub const fn explained<'a>(&'a self, flags: Flags<'a>) -> Explained<'a> {
        Explained { error: self, flags }
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

    /// The text of a failed connection.
    fn write_link(
        endpoint: &str,
        source: &io::Error,
        lang: Lang,
        out: &mut dyn fmt::Write,
    ) -> fmt::Result {
        if cannot_switch(source) {
            let source = SystemError(source);
            return text::CannotSwitchDirection { endpoint, source }.write(lang, out);
        }
        match PortError::of(source) {
            Some(error) => {
                write!(out, "{endpoint}: ")?;
                error.write(lang, out)
            }
            None => text::NoConnection { endpoint, source: SystemError(source) }.write(lang, out),
        }
    }
}

impl Argument for Error {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self {
            Self::Refused { request, to, status, by } => {
                write_refused(*request, *to, *status, *by, &|_| None, lang, out)
            }
            Self::NoAnswer { request, to, endpoint, tries, stray } => {
                let (request, to, endpoint) = (Shown(request), Shown(to), &**endpoint);
                match stray.map(Shown) {
                    Some(stray) => text::NoAnswerButStray { request, to, endpoint, tries, stray }
                        .write(lang, out),
                    None => text::NoAnswer { request, to, endpoint, tries }.write(lang, out),
                }
            }
            Self::Absent { endpoint, tries } => {
                text::Absent { endpoint: &**endpoint, tries }.write(lang, out)
            }
            Self::NotProbed { endpoint, cause } => {
                text::NotProbed { endpoint: &**endpoint, cause }.write(lang, out)
            }
            Self::OutcomeUnknown { request, to, endpoint, cause } => {
                let check = outcome_check(*request);
                let (request, to, endpoint) = (Shown(request), Shown(to), &**endpoint);
                text::OutcomeUnknown { request, to, endpoint, cause, check }.write(lang, out)
            }
            Self::NotSent { request, to, cause } => {
                text::NotSent { request: Shown(request), to: Shown(to), cause }.write(lang, out)
            }
            Self::Link { endpoint, source } => Self::write_link(endpoint, source, lang, out),
            Self::Protocol { request, from, what } => {
                text::BreaksProtocol { request: Shown(request), from: Shown(from), what }
                    .write(lang, out)
            }
            Self::Unsendable { request, to } => {
                text::TooLong { request: Shown(request), to: Shown(to) }.write(lang, out)
            }
            Self::NotARead { request, to } => {
                text::NotARead { request: Shown(request), to: Shown(to) }.write(lang, out)
            }
            Self::Address { address, endpoint } => {
                text::AddressImpossible { endpoint: &**endpoint, address }.write(lang, out)
            }
            Self::Url(error) => error.write(lang, out),
            Self::NeedsStream => text::NeedsStream.write(lang, out),
            Self::Closed => text::Closed.write(lang, out),
        }
    }
}

impl Text for Error {}

/// An error of a monitor whose flags are known.
#[derive(Clone, Copy)]
pub struct Explained<'a> {
    error: &'a Error,
    flags: Flags<'a>,
}

impl Argument for Explained<'_> {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self.error {
            Error::Refused { request, to, status, by } => {
                write_refused(*request, *to, *status, *by, self.flags, lang, out)
            }
            error => error.write(lang, out),
        }
    }
}

impl Text for Explained<'_> {}

fn write_refused(
    request: RequestId,
    to: SubsystemId,
    status: Status,
    by: SubsystemId,
    flags: Flags<'_>,
    lang: Lang,
    out: &mut dyn fmt::Write,
) -> fmt::Result {
    let Reason { why, remedy, .. } = reason_now(request, to, status, by, flags);
    let (request, to, by) = (Shown(&request), Shown(&to), Shown(&by));
    text::Refused { request, to, by, status: Shown(&status), why, remedy }.write(lang, out)
}

impl Argument for Cause {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self {
            Self::Silence => text::CauseSilence.write(lang, out),
            Self::Odd { from, what } => {
                text::CauseOddAnswer { from: Shown(from), what }.write(lang, out)
            }
            Self::Link(source) => match PortError::of(source) {
                Some(source) => text::CauseNoConnection { source }.write(lang, out),
                None => text::CauseNoConnection { source: SystemError(source) }.write(lang, out),
            },
            Self::Superseded { by } => text::CauseSuperseded { by: Shown(by) }.write(lang, out),
            Self::QueueFull => text::CauseQueueFull.write(lang, out),
            Self::Expired => text::CauseExpired.write(lang, out),
            Self::EarlierFailed => text::CauseEarlierFailed.write(lang, out),
            Self::CheckMissing => text::CauseCheckMissing.write(lang, out),
            Self::NoController => text::CauseNoController.write(lang, out),
            Self::NotGranted => text::CauseNotGranted.write(lang, out),
            Self::ControllerPresent => text::CauseControllerPresent.write(lang, out),
            Self::Unreadable => text::CauseUnreadable.write(lang, out),
        }
    }
}

/// Whether the driver of the port cannot switch the direction of RS-485.
fn cannot_switch(source: &io::Error) -> bool {
    source.get_ref().is_some_and(|inner| inner.is::<CannotSwitch>())
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(Lang::En, f)
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
