//! Why a call is refused: in words, and as a status of OPC UA.

use lafet_texts::{Text as _, hub as text};
use opcua::types::StatusCode;

use crate::plugs::refusal::Refusal;
use crate::text::Both;

/// What a refusal means, and what to do.
pub fn of(refusal: Refusal) -> Both {
    match refusal {
        Refusal::Command | Refusal::Form => text::OpcuaNoMethod.words(),
        Refusal::Monitor => text::MqttNoMonitor.words(),
        Refusal::Argument => text::OpcuaArgument.words(),
        Refusal::Heartbeat | Refusal::Void => text::OpcuaVoid.words(),
        Refusal::Role => text::OpcuaRole.words(),
        Refusal::Held => text::OpcuaHeld.words(),
        Refusal::NotTaken => text::OpcuaNotTaken.words(),
        Refusal::Key => text::OpcuaKey.words(),
        Refusal::Refused => text::OpcuaRefused.words(),
        Refusal::Ticket => text::OpcuaTicket.words(),
        other => other.text(),
    }
}

/// The status of a call: bad, so that a client that reads no results knows that nothing was done.
pub const fn status(refusal: Refusal) -> StatusCode {
    match refusal {
        Refusal::Command | Refusal::Form => StatusCode::BadNotSupported,
        Refusal::Monitor => StatusCode::BadNodeIdUnknown,
        Refusal::Argument => StatusCode::BadOutOfRange,
        Refusal::Role | Refusal::Key | Refusal::Session => StatusCode::BadUserAccessDenied,
        Refusal::Held | Refusal::Asked => StatusCode::BadResourceUnavailable,
        Refusal::NotTaken | Refusal::Sequence => StatusCode::BadInvalidState,
        Refusal::Ticket | Refusal::Heartbeat => StatusCode::BadInvalidTimestamp,
        Refusal::Busy | Refusal::TooFast => StatusCode::BadTooManyOperations,
        Refusal::Refused | Refusal::KeepOut | Refusal::Retained => StatusCode::BadRequestNotAllowed,
        Refusal::NoAnswer => StatusCode::BadNoCommunication,
        Refusal::Unknown => StatusCode::BadUnknownResponse,
        Refusal::NotSent => StatusCode::BadNotConnected,
        Refusal::Void | Refusal::Ended => StatusCode::BadOperationAbandoned,
        Refusal::Late => StatusCode::BadTimeout,
        Refusal::Hub => StatusCode::BadInternalError,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_refusal_is_a_bad_status_and_has_words() {
        for refusal in Refusal::ALL.into_iter().chain([Refusal::Ticket, Refusal::Form]) {
            assert!(status(refusal).is_bad(), "{refusal:?}");
            let words = of(refusal);
            assert!(!words.en.contains("register"), "{refusal:?}: {}", words.en);
            assert!(words.ru.chars().any(|c| ('а'..='я').contains(&c)), "{refusal:?}");
        }
    }
}
