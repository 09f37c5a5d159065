//! Why a command is refused, in words for clients of a broker.

use lafet_texts::{Text as _, hub as text};

use crate::plugs::refusal::Refusal;
use crate::text::Both;

/// What a refusal means, and what to do.
pub fn of(refusal: Refusal) -> Both {
    match refusal {
        Refusal::Command => text::MqttNoCommand.words(),
        Refusal::Monitor => text::MqttNoMonitor.words(),
        Refusal::Argument => text::MqttArgument.words(),
        Refusal::Heartbeat | Refusal::Void => text::MqttVoid.words(),
        Refusal::Role => text::MqttRole.words(),
        Refusal::Held => text::MqttHeld.words(),
        Refusal::NotTaken => text::MqttNotTaken.words(),
        Refusal::Key => text::MqttKey.words(),
        Refusal::Sequence => text::MqttTwice.words(),
        Refusal::Refused => text::MqttRefused.words(),
        other => other.text(),
    }
}
