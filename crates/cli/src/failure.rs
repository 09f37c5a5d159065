//! How a command can fail, and the exit code that says so.

use std::io;

use lafet_client::Error;
use lafet_proto::{RequestId, Status, SubsystemId};
use serde_json::{Value, json};

use crate::lang::{current, pick};

/// Result of a command.
pub type Outcome = Result<(), Failure>;

/// Why a command is not done.
#[derive(Debug)]
pub enum Failure {
    /// The monitor refused, nobody answered, or the request could not be made.
    Client(Error),
    /// Some of several requests were refused; the answers have been shown.
    Refused {
        /// The first of the refusals.
        first: Error,
        /// How many there are.
        count: usize,
    },
    /// The monitor took the request but did not carry it through.
    Ended(String),
    /// The arguments make no sense.
    Usage(String),
    /// A file or a port of this computer.
    Io {
        /// What was being done.
        what: String,
        /// What the system says.
        source: io::Error,
    },
    /// Ctrl-C or a signal.
    Interrupted,
}

impl Failure {
    /// A failure of the file system or of the network of this computer.
    pub fn io(what: impl Into<String>, source: io::Error) -> Self {
        Self::Io { what: what.into(), source }
    }

    /// 1 refused by the monitor, 2 usage, 3 no answer, 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Client(error) if error.is_refused() => 1,
            Self::Client(error) if error.is_usage() => 2,
            Self::Client(_) => 3,
            Self::Refused { .. } | Self::Ended(_) => 1,
            Self::Io { source, .. } if source.kind() == io::ErrorKind::BrokenPipe => 0,
            Self::Usage(_) | Self::Io { .. } => 2,
            Self::Interrupted => 130,
        }
    }

    /// What a person reads; empty where there is nothing to say.
    pub fn message(&self) -> String {
        match self {
            Self::Client(error) => told(error),
            Self::Refused { first, count: 1 } => told(first),
            Self::Refused { first, count } => {
                let first = told(first);
                pick(
                    format!("{count} requests refused; the first: {first}"),
                    format!("Отклонено запросов: {count}; первый: {first}"),
                )
            }
            Self::Ended(message) | Self::Usage(message) => message.clone(),
            Self::Io { source, .. } if source.kind() == io::ErrorKind::BrokenPipe => String::new(),
            Self::Io { what, source } => format!("{what}: {source}"),
            Self::Interrupted => pick("Interrupted.", "Прервано.").into(),
        }
    }

    /// What a program reads.
    pub fn json(&self) -> Value {
        let kind = match self.exit_code() {
            1 if matches!(self, Self::Ended(_)) => "ended",
            1 => "refused",
            2 => "usage",
            3 => "no-answer",
            _ => "interrupted",
        };
        let mut error = json!({
            "kind": kind,
            "exit_code": self.exit_code(),
            "message": self.message(),
        });
        if let Self::Client(cause) | Self::Refused { first: cause, .. } = self
            && let Error::Refused { request, to, status, by } = cause
        {
            error["request"] = json!(request.to_string());
            error["to"] = json!(to.to_string());
            error["status"] = json!(status.to_string());
            error["by"] = json!(by.to_string());
        }
        json!({ "error": error })
    }

    /// Whether the monitor refused with this status.
    pub fn is_refused_with(&self, status: Status) -> bool {
        matches!(self, Self::Client(Error::Refused { status: refused, .. }) if *refused == status)
    }
}

/// The error, and the command that helps most likely.
fn told(error: &Error) -> String {
    let message = error.localized(current());
    let Error::Refused { request, status, by, .. } = error else { return message };
    let command = match (*status, *by) {
        // Stop All is never denied (§3.2/1).
        (Status::DENIED, _) if *request == RequestId::STOP => "lafet stop",
        (Status::DENIED, SubsystemId::DEPLOYER) => "lafet deploy",
        (Status::DENIED, SubsystemId::DETECTOR) => "lafet stop detector",
        (Status::DENIED, SubsystemId::CONTROL) => "lafet stop control",
        (Status::DENIED, SubsystemId::VALVE1) => "lafet close valve1",
        (Status::DENIED, SubsystemId::VALVE2) => "lafet close valve2",
        (Status::DENIED, SubsystemId::GENERAL) => "lafet lockout off",
        (Status::INVALID_ID, _) => "lafet param list",
        (Status::MODULE_NOT_EXIST, _) => "lafet status",
        (Status::MODULE_FAULT, _) => "lafet status",
        (Status::INVALID_VALUE, SubsystemId::DETECTOR | SubsystemId::CONTROL) => "lafet limits",
        _ => return message,
    };
    format!("{message}\n{}: {command}", pick("Try", "Попробуйте"))
}

/// The refusal of a request that an answer tells.
pub fn refusal(request: RequestId, to: SubsystemId, status: Status, by: SubsystemId) -> Error {
    Error::Refused { request, to, status, by }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Client(error)
    }
}

impl From<io::Error> for Failure {
    fn from(source: io::Error) -> Self {
        Self::io(pick("standard input or output", "стандартный ввод или вывод"), source)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exit_codes() {
        let denied = || {
            refusal(RequestId::MOVE, SubsystemId::VERTICAL, Status::DENIED, SubsystemId::DEPLOYER)
        };
        assert_eq!(Failure::Client(denied()).exit_code(), 1);
        assert_eq!(Failure::Refused { first: denied(), count: 2 }.exit_code(), 1);
        assert_eq!(Failure::Client(Error::NeedsStream).exit_code(), 2);
        assert_eq!(Failure::Client(Error::Closed).exit_code(), 3);
        assert_eq!(Failure::Usage(String::new()).exit_code(), 2);
        assert_eq!(Failure::Interrupted.exit_code(), 130);
        let pipe = Failure::from(io::Error::from(io::ErrorKind::BrokenPipe));
        assert_eq!((pipe.exit_code(), pipe.message()), (0, String::new()));
    }

    #[test]
    fn a_program_reads_who_refused() {
        let denied =
            refusal(RequestId::MOVE, SubsystemId::VERTICAL, Status::DENIED, SubsystemId::DEPLOYER);
        let json = Failure::Client(denied).json();
        assert_eq!(json["error"]["kind"], "refused");
        assert_eq!(json["error"]["status"], "Denied");
        assert_eq!(json["error"]["by"], "Deployer");
    }
}
