//! Failures of a command, and their exit codes.

use std::io;

use lafet_client::refusal::{Help, Reason, reason, reason_of};
use lafet_client::{AnswerBuf, Error, MonitorStatus, os_text};
use lafet_proto::text::AnswerText;
use lafet_proto::{Request, RequestId, Status, SubsystemId};
use lafet_texts::{Text as _, cli as text};
use serde_json::{Value, json};

use crate::describe::hex;
use crate::exchange;
use crate::lang::current;
use crate::undo::BrokenOff;

/// Result of a command.
pub type Outcome = Result<(), Failure>;

/// Why a command failed.
#[derive(Debug)]
pub enum Failure {
    /// The monitor refused or did not answer, or the request could not be sent.
    Client(Error),
    /// The monitor refused a request, which is shown with its answer.
    Asked {
        /// The request and its answer.
        asked: Box<Asked>,
        /// The refusal.
        error: Error,
    },
    /// Some of several requests were refused; the answers have been printed.
    Refused {
        /// The first refusal.
        first: Error,
        /// Its request and its answer.
        asked: Box<Asked>,
        /// Number of refusals.
        count: usize,
    },
    /// There was no answer, as has been printed.
    Silent(String),
    /// The monitor accepted the request but did not complete it.
    Ended(String),
    /// The arguments are not valid.
    Usage(String),
    /// An error of a file or port of this computer.
    Io {
        /// The operation that failed.
        what: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The failure has been reported already; the exit code.
    Told(u8),
    /// The command was broken off; what it started was brought to rest, or not.
    BrokenOff(Box<BrokenOff>),
    /// A motion was not seen to come to rest.
    NotAtRest(String),
    /// Ctrl-C or a signal ended the command.
    Interrupted,
}

/// A request and the answer that refused it, as text and as bytes.
#[derive(Clone, Debug)]
pub struct Asked {
    request: String,
    sent: String,
    answer: String,
    received: String,
    reason: Reason,
}

impl Asked {
    /// Records a request and its refusal; the state of the monitor, if it is known, shows why.
    pub fn new(request: &Request<'_>, refusal: &AnswerBuf, state: Option<&MonitorStatus>) -> Self {
        let record = refusal.record();
        let mut received = vec![
            record.request.0,
            record.device.0,
            record.status.0,
            record.data.len().min(255) as u8,
        ];
        received.extend(record.data);
        Self {
            request: request.to_string(),
            sent: hex(&exchange::bytes(request)),
            answer: AnswerText(record).to_string(),
            received: hex(&received),
            reason: reason_of(request, refusal.status(), refusal.from(), &|id| state?.flags(id)),
        }
    }
}

impl Failure {
    /// Adds the request and the answer to a refusal.
    pub fn asked(self, asked: Option<Asked>) -> Self {
        match (self, asked) {
            (Self::Client(error), Some(asked)) => Self::Asked { asked: Box::new(asked), error },
            (failure, _) => failure,
        }
    }

    /// A failure of the file system or network of this computer.
    pub fn io(what: impl Into<String>, source: io::Error) -> Self {
        Self::Io { what: what.into(), source }
    }

    /// 1 refused by the monitor or not completed, 2 usage, 3 no answer, 4 it may still move or
    /// flow, 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Client(error) if error.is_refused() => 1,
            Self::Client(error) if error.is_usage() => 2,
            Self::Client(_) | Self::Silent(_) => 3,
            Self::Asked { .. } | Self::Refused { .. } | Self::Ended(_) => 1,
            Self::Io { source, .. } if source.kind() == io::ErrorKind::BrokenPipe => 0,
            Self::Usage(_) | Self::Io { .. } => 2,
            Self::Told(code) => *code,
            Self::BrokenOff(broken) => broken.exit_code(),
            Self::NotAtRest(_) => 4,
            Self::Interrupted => 130,
        }
    }

    /// The message for the user; empty where there is nothing to say.
    pub fn message(&self) -> String {
        match self {
            Self::Client(error) => told(error, None),
            Self::Asked { asked, error } => told(error, Some(asked)),
            Self::Refused { first, asked, count: 1 } => told(first, Some(asked)),
            Self::Refused { first, asked, count } => {
                let first = told(first, Some(asked));
                text::RequestsRefused { count, first }.of(current())
            }
            Self::Ended(message)
            | Self::Usage(message)
            | Self::Silent(message)
            | Self::NotAtRest(message) => message.clone(),
            Self::Io { source, .. } if source.kind() == io::ErrorKind::BrokenPipe => String::new(),
            Self::Io { what, source } => format!("{what}: {}", os_text(source, current())),
            Self::Told(_) => String::new(),
            Self::BrokenOff(broken) => broken.message(),
            Self::Interrupted => text::Interrupted.str(current()).into(),
        }
    }

    /// The failure as JSON.
    pub fn json(&self) -> Value {
        let kind = match self.exit_code() {
            1 if matches!(self, Self::Ended(_) | Self::BrokenOff(_)) => "ended",
            1 => "refused",
            2 => "usage",
            3 => "no-answer",
            4 => "not-at-rest",
            _ => "interrupted",
        };
        let mut error = json!({
            "kind": kind,
            "exit_code": self.exit_code(),
            "message": self.message(),
        });
        match self {
            Self::BrokenOff(broken) => error["at_rest"] = json!(broken.is_at_rest()),
            Self::NotAtRest(_) => error["at_rest"] = json!(false),
            _ => {}
        }
        let asked = match self {
            Self::Asked { asked, .. } | Self::Refused { asked, .. } => Some(asked),
            _ => None,
        };
        if let Some(asked) = asked {
            error["asked"] = json!(asked.request);
            error["sent"] = json!(asked.sent);
            error["received"] = json!(asked.received);
        }
        if let Some(Error::Refused { request, to, status, by }) = self.cause() {
            let reason =
                asked.map_or_else(|| reason(*request, *to, *status, *by), |asked| asked.reason);
            error["scenario"] = json!(reason.scenario);
            error["why"] = json!(reason.why.str(current()));
            error["remedy"] = json!(reason.remedy.str(current()));
            error["try"] = json!(reason.helps.map(command));
            error["request"] = json!(request.to_string());
            error["to"] = json!(to.to_string());
            error["status"] = json!(status.to_string());
            error["by"] = json!(by.to_string());
        }
        json!({ "error": error })
    }

    /// Whether the monitor refused with this status.
    pub fn is_refused_with(&self, status: Status) -> bool {
        matches!(self.cause(), Some(Error::Refused { status: refused, .. }) if *refused == status)
    }

    const fn cause(&self) -> Option<&Error> {
        match self {
            Self::Client(cause)
            | Self::Asked { error: cause, .. }
            | Self::Refused { first: cause, .. } => Some(cause),
            _ => None,
        }
    }
}

/// The error; for a refusal also the request, the answer, the reason, and the most likely remedy.
fn told(error: &Error, asked: Option<&Asked>) -> String {
    let Error::Refused { request, to, status, by } = error else {
        return error.localized(current());
    };
    let answers = text::Answers.str(current());
    let mut lines = Vec::new();
    match asked {
        Some(Asked { request, sent, answer, received, .. }) => {
            lines.push(format!("{request}: {by} {answers} {status}."));
            lines.push(format!("  {}  {request}  [{sent}]", text::ExchangeRequest.str(current())));
            lines
                .push(format!("  {}  {answer}  [{received}]", text::ExchangeAnswer.str(current())));
        }
        None => lines.push(format!("{request} {to}: {by} {answers} {status}.")),
    }
    let reason = asked.map_or_else(|| reason(*request, *to, *status, *by), |asked| asked.reason);
    let Reason { scenario, why, remedy, helps } = reason;
    lines.push(format!("{}: {} ({scenario})", text::Why.str(current()), why.str(current())));
    let try_it = text::Try.str(current());
    lines.push(match helps.map(command) {
        Some(command) => format!("{try_it}: {command}\n  {}", remedy.str(current())),
        None => format!("{try_it}: {}", remedy.str(current())),
    });
    lines.join("\n")
}

/// The command that most likely helps.
fn command(help: Help) -> String {
    let name = |id: SubsystemId| id.to_string().to_lowercase();
    match help {
        Help::Status(SubsystemId::ALL) => "lafet status".into(),
        Help::Status(id) => format!("lafet status {}", name(id)),
        Help::Stop(SubsystemId::ALL) => "lafet stop".into(),
        Help::Stop(id) => format!("lafet stop {}", name(id)),
        Help::Close(valve) => format!("lafet close {}", name(valve)),
        Help::Deploy => "lafet deploy".into(),
        Help::ReleaseLockout => "lafet lockout off".into(),
        Help::Limits => "lafet limits".into(),
        Help::LimitsOn => "lafet limits on".into(),
        Help::RejectLimits(id) => format!("lafet limits reject {}", name(id)),
        Help::Parameters(id) => format!("lafet param list {}", name(id)),
        Help::DriveType(id) => format!("lafet param get {} DriveType", name(id)),
        Help::InputFaults => "lafet param get general InputFaults".into(),
        Help::Programs => "lafet program list".into(),
        Help::CrashData => "lafet crash".into(),
    }
}

/// The error for a refusal with this status.
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
        Self::io(text::StandardStreams.str(current()), source)
    }
}

#[cfg(test)]
mod tests {
    use lafet_proto::flags::GeneralFlags;
    use lafet_proto::status::GeneralStatus;

    use super::*;

    fn asked() -> Box<Asked> {
        let record = lafet_proto::Record {
            request: RequestId::STOP,
            device: SubsystemId::VERTICAL,
            status: Status::DENIED,
            data: &[],
        };
        let request = Request::new(SubsystemId::VERTICAL, lafet_proto::request::Body::Stop);
        Box::new(Asked::new(&request, &AnswerBuf::new(&record), None))
    }

    #[test]
    fn exit_codes() {
        let denied = || {
            refusal(RequestId::MOVE, SubsystemId::VERTICAL, Status::DENIED, SubsystemId::DEPLOYER)
        };
        assert_eq!(Failure::Client(denied()).exit_code(), 1);
        assert_eq!(Failure::Refused { first: denied(), asked: asked(), count: 2 }.exit_code(), 1);
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
        assert_eq!(json["error"]["scenario"], "§3.1/1");
        assert_eq!(json["error"]["try"], "lafet deploy");
    }

    /// Neither closing a blocked valve nor deploying a barrel whose rest is not known helps.
    #[test]
    fn what_to_try_helps() {
        let to_try = |request, by| {
            let json = Failure::Client(refusal(request, by, Status::DENIED, by)).json();
            json["error"]["try"].as_str().map(str::to_owned)
        };
        let valve = SubsystemId::VALVE1;
        assert_eq!(to_try(RequestId::OPEN, valve).as_deref(), Some("lafet status valve1"));
        assert_eq!(to_try(RequestId::WRAP, valve).as_deref(), Some("lafet close valve1"));
        let faults = Some("lafet param get general InputFaults");
        assert_eq!(to_try(RequestId::WRAP, SubsystemId::DEPLOYER).as_deref(), faults);
        for request in [RequestId::SWITCH_LIMITS, RequestId::SET_PARAM] {
            assert_eq!(to_try(request, SubsystemId::HORIZONTAL).as_deref(), faults);
        }
        assert_eq!(to_try(RequestId::MOVE, SubsystemId::DEPLOYER).as_deref(), Some("lafet deploy"));
    }

    /// A table of corrections is not bounded by the limits of the drives.
    #[test]
    fn what_to_try_belongs_to_the_request() {
        let to_try = |request, by, status| {
            Failure::Client(refusal(request, by, status, by)).json()["error"]["try"].clone()
        };
        let control = SubsystemId::CONTROL;
        let value = |request| to_try(request, control, Status::INVALID_VALUE);
        assert_eq!(value(RequestId::SETUP_CORRECTION_TABLE), Value::Null);
        assert_eq!(value(RequestId::START_QUENCH), "lafet limits");
        let list = to_try(RequestId::SET_PARAM, control, Status::ACCESS_DENIED);
        assert_eq!(list, "lafet param list control");
        let stop = to_try(RequestId::START_SEEK, SubsystemId::DETECTOR, Status::DENIED);
        assert_eq!(stop, "lafet stop detector");
    }

    /// §3.3.1/4 A weak supply is no lockout: the state that is read after the refusal shows which it is.
    #[test]
    fn a_weak_supply_is_no_lockout() {
        let (to, general) = (SubsystemId::VERTICAL, SubsystemId::GENERAL);
        let request = Request::new(to, lafet_proto::request::Body::Move { destination: 600 });
        let record = lafet_proto::Record {
            request: RequestId::MOVE,
            device: general,
            status: Status::DENIED,
            data: &[],
        };
        let tried = |flags| {
            let mut state = MonitorStatus::default();
            state.general =
                Some(GeneralStatus { flags, main_voltage: 15, pressure: 0, flowrate: 0 });
            let asked = Asked::new(&request, &AnswerBuf::new(&record), Some(&state));
            let error = refusal(RequestId::MOVE, to, Status::DENIED, general);
            let failure = Failure::Client(error).asked(Some(asked));
            assert!(failure.message().contains("Try: lafet"), "{}", failure.message());
            let json = failure.json();
            ["scenario", "try"].map(|key| json["error"][key].as_str().unwrap().to_owned())
        };
        assert_eq!(tried(GeneralFlags::BAD_POWER), ["§3.3.1/4", "lafet status general"]);
        assert_eq!(tried(GeneralFlags::LOCKED_OUT), ["§3.18/2", "lafet lockout off"]);
        assert_eq!(tried(GeneralFlags::empty()), ["§1/2", "lafet status general"]);
    }

    #[test]
    fn every_refusal_says_why_and_what_to_try() {
        for status in (2..=19).map(Status) {
            for request in lafet_proto::dictionary::REQUESTS.iter().map(|info| info.id) {
                for by in SubsystemId::TABLE {
                    let text = told(&refusal(request, by, status, by), None);
                    for word in ["answers", "\nWhy: ", "(§", "\nTry: "] {
                        assert!(text.contains(word), "{word}: {text}");
                    }
                }
            }
        }
    }
}
