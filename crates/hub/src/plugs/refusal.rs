//! Why a command of a plug is not carried out: numbers that never change their meaning. The texts here are those
//! of Modbus; [`crate::plugs::mqtt`] has others where they name registers.

use lafet_texts::{Text as _, hub as text};

use crate::error::ApiError;
use crate::text::Both;

/// Why a command is refused or has no result. A number is never used again for something else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum Refusal {
    /// There is no command of this number.
    Command = 1,
    /// There is no monitor of this number.
    Monitor = 2,
    /// An argument is outside of its range.
    Argument = 3,
    /// The number of the session is not that of this connection.
    Session = 4,
    /// The heartbeat of the master is not alive.
    Heartbeat = 5,
    /// The configuration lets this master only read.
    Role = 6,
    /// Another client has authority.
    Held = 7,
    /// No client has authority: it is taken first.
    NotTaken = 8,
    /// The key is not the one that is offered now.
    Key = 9,
    /// The command before it has no result yet.
    Busy = 10,
    /// The sequence number was used for another command.
    Sequence = 11,
    /// The monitor has refused; its result is beside this number.
    Refused = 12,
    /// The monitor has not answered.
    NoAnswer = 13,
    /// Whether the monitor has done it is not known.
    Unknown = 14,
    /// There is no connection to the monitor, or the request was not sent.
    NotSent = 15,
    /// Water could go where the configuration forbids it.
    KeepOut = 16,
    /// Too many requests: to be sent again later.
    TooFast = 17,
    /// The heartbeat or authority was lost before it was sent.
    Void = 18,
    /// Another client already asks for authority.
    Asked = 19,
    /// There was no result in time; it may still be carried out.
    Late = 20,
    /// Another client or an event has ended the motion.
    Ended = 21,
    /// The hub cannot do it now: see its log.
    Hub = 22,
    /// MQTT: the ticket is not one of the last seconds.
    Ticket = 23,
    /// MQTT: a retained message commands nothing but Stop, Close and Lockout.
    Retained = 24,
    /// MQTT: it cannot be read.
    Form = 25,
}

impl Refusal {
    /// Those of Modbus, by their numbers.
    pub const ALL: [Self; 22] = [
        Self::Command,
        Self::Monitor,
        Self::Argument,
        Self::Session,
        Self::Heartbeat,
        Self::Role,
        Self::Held,
        Self::NotTaken,
        Self::Key,
        Self::Busy,
        Self::Sequence,
        Self::Refused,
        Self::NoAnswer,
        Self::Unknown,
        Self::NotSent,
        Self::KeepOut,
        Self::TooFast,
        Self::Void,
        Self::Asked,
        Self::Late,
        Self::Ended,
        Self::Hub,
    ];

    /// Whether the monitor may have done it all the same.
    pub const fn may_be_done(self) -> bool {
        matches!(self, Self::NoAnswer | Self::Unknown)
    }

    /// The number in registers and results.
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// What it means on Modbus, and what to do.
    pub fn text(self) -> Both {
        match self {
            Self::Command => text::PlugNoCommand.words(),
            Self::Monitor => text::PlugNoMonitor.words(),
            Self::Argument => text::PlugArgument.words(),
            Self::Session => text::PlugSession.words(),
            Self::Heartbeat => text::PlugHeartbeat.words(),
            Self::Role => text::PlugRole.words(),
            Self::Held => text::PlugHeld.words(),
            Self::NotTaken => text::PlugNotTaken.words(),
            Self::Key => text::PlugKey.words(),
            Self::Busy => text::PlugBusy.words(),
            Self::Sequence => text::PlugSequence.words(),
            Self::Refused => text::PlugRefused.words(),
            Self::NoAnswer => text::PlugNoAnswer.words(),
            Self::Unknown => text::PlugUnknown.words(),
            Self::NotSent => text::PlugNotSent.words(),
            Self::KeepOut => text::PlugKeepOut.words(),
            Self::TooFast => text::PlugTooFast.words(),
            Self::Void => text::PlugVoid.words(),
            Self::Asked => text::PlugAsked.words(),
            Self::Late => text::PlugLate.words(),
            Self::Ended => text::PlugEnded.words(),
            Self::Hub => text::PlugHub.words(),
            Self::Ticket => text::MqttTicket.words(),
            Self::Retained => text::MqttRetained.words(),
            Self::Form => text::MqttForm.words(),
        }
    }

    /// What the hub answers, as a number.
    pub fn of(error: &ApiError) -> Self {
        match error.code {
            "bad_request" | "too_large" => Self::Argument,
            "no_monitor" => Self::Monitor,
            "role" | "login_needed" => Self::Role,
            "slow_down" => Self::TooFast,
            // An update of its software holds it.
            "held" | "updating" => Self::Held,
            "no_authority" if error.body().details.holder == Some(None) => Self::NotTaken,
            "no_authority" => Self::Held,
            "refused" => Self::Refused,
            "keep_out" => Self::KeepOut,
            "not_connected" | "not_sent" => Self::NotSent,
            "no_answer" => Self::NoAnswer,
            "outcome_unknown" => Self::Unknown,
            "void" => Self::Void,
            _ => Self::Hub,
        }
    }
}

/// Why there is no result: the number, and the result of the monitor if it has refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed {
    /// The reason.
    pub why: Refusal,
    /// Number of the monitor's result (§2/5); 0: none.
    pub status: u16,
}

impl From<Refusal> for Failed {
    fn from(why: Refusal) -> Self {
        Self { why, status: 0 }
    }
}

impl From<&ApiError> for Failed {
    fn from(error: &ApiError) -> Self {
        let answers = error.body().details.answers.unwrap_or_default();
        let status = answers.iter().find(|it| !it.success).map_or(0, |it| it.code.into());
        Self { why: Refusal::of(error), status }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::time::Duration;

    use lafet_client::Error;

    use super::*;
    use crate::access::Role;
    use crate::control::authority::{Refusal as Denied, Seat};

    #[test]
    fn numbers_and_texts_are_each_of_one_meaning() {
        let numbers: Vec<u16> = Refusal::ALL.iter().map(|it| it.number()).collect();
        assert_eq!(numbers, (1..=22).collect::<Vec<_>>());
        let texts: BTreeSet<String> = Refusal::ALL.iter().map(|it| it.text().en).collect();
        assert_eq!(texts.len(), Refusal::ALL.len());
        let russian = |it: &Refusal| it.text().ru.chars().any(|c| ('а'..='я').contains(&c));
        assert!(Refusal::ALL.iter().all(russian));
    }

    #[test]
    fn what_the_hub_answers_has_its_number() {
        let seat = Seat {
            user: "anna".into(),
            role: Role::Operator,
            seat: "s1".into(),
            from: String::new(),
            live: true,
        };
        for (error, why) in [
            (ApiError::no_monitor("M1"), Refusal::Monitor),
            (ApiError::role(Role::Operator), Refusal::Role),
            (ApiError::slow_down(Duration::from_secs(1)), Refusal::TooFast),
            (ApiError::authority("M1", Denied::Held(seat.clone())), Refusal::Held),
            (ApiError::authority("M1", Denied::NotHolder(Some(seat))), Refusal::Held),
            (ApiError::authority("M1", Denied::NotHolder(None)), Refusal::NotTaken),
            (ApiError::keep_out("x", true), Refusal::KeepOut),
            (ApiError::not_connected("M1"), Refusal::NotSent),
            (ApiError::no_answer_within("M1", Duration::ZERO), Refusal::NoAnswer),
            (ApiError::void(), Refusal::Void),
            // A client that has ended may have sent it before.
            (ApiError::from(&Error::Closed), Refusal::Unknown),
            (ApiError::not_found(), Refusal::Hub),
        ] {
            assert_eq!(Failed::from(&error), Failed { why, status: 0 }, "{}", error.code);
        }
    }
}
