//! Reason codes of MQTT 5, in words: why a broker refuses a connection or ends one.

use lafet_texts::{Text, hub as text};
use rumqttc::ConnectReturnCode as Refused;
use rumqttc::mqttbytes::v5::DisconnectReasonCode as Ended;

/// Why a broker has ended a connection.
pub fn of_end(code: Ended) -> &'static dyn Text {
    match code {
        Ended::NotAuthorized | Ended::AdministrativeAction => &text::MqttWhyForbidden,
        Ended::ServerBusy => &text::MqttWhyBusy,
        Ended::ServerShuttingDown => &text::MqttWhyEnds,
        Ended::KeepAliveTimeout => &text::MqttWhySilence,
        Ended::SessionTakenOver => &text::MqttWhyTakenOver,
        Ended::ReceiveMaximumExceeded
        | Ended::PacketTooLarge
        | Ended::MessageRateTooHigh
        | Ended::QuotaExceeded
        | Ended::ConnectionRateExceeded
        | Ended::MaximumConnectTime => &text::MqttWhyLimit,
        Ended::UseAnotherServer | Ended::ServerMoved => &text::MqttWhyElsewhere,
        Ended::TopicFilterInvalid
        | Ended::TopicNameInvalid
        | Ended::PayloadFormatInvalid
        | Ended::RetainNotSupported
        | Ended::QoSNotSupported => &text::MqttWhyUnsupported,
        Ended::NormalDisconnection | Ended::DisconnectWithWillMessage | Ended::UnspecifiedError => {
            &text::MqttWhyUnknown
        }
        _ => &text::MqttWhyProtocol,
    }
}

/// Why a broker refuses a connection.
pub fn of_refusal(code: Refused) -> &'static dyn Text {
    match code {
        Refused::Banned | Refused::BadAuthenticationMethod => &text::MqttWhyForbidden,
        Refused::ServiceUnavailable | Refused::ServerUnavailable | Refused::ServerBusy => {
            &text::MqttWhyBusy
        }
        Refused::BadClientId | Refused::ClientIdentifierNotValid => &text::MqttWhyName,
        Refused::PacketTooLarge | Refused::QuotaExceeded | Refused::ConnectionRateExceeded => {
            &text::MqttWhyLimit
        }
        Refused::UseAnotherServer | Refused::ServerMoved => &text::MqttWhyElsewhere,
        Refused::TopicNameInvalid
        | Refused::PayloadFormatInvalid
        | Refused::RetainNotSupported
        | Refused::QoSNotSupported => &text::MqttWhyUnsupported,
        Refused::Success | Refused::UnspecifiedError => &text::MqttWhyUnknown,
        _ => &text::MqttWhyProtocol,
    }
}

#[cfg(test)]
mod tests {
    use lafet_texts::Lang;

    use super::*;

    #[test]
    fn a_reason_is_in_words_of_the_reader() {
        for code in 0..=u8::MAX {
            let Ok(code) = Ended::try_from(code) else { continue };
            let (en, ru) = (of_end(code).of(Lang::En), of_end(code).of(Lang::Ru));
            let name = format!("{code:?}");
            assert!(!en.contains(&name) && en.contains(' '), "{en}");
            assert!(!ru.chars().any(|c| c.is_ascii_lowercase()), "{ru}");
        }
        let busy = of_refusal(Refused::ServerBusy).of(Lang::En);
        assert_eq!(busy, of_end(Ended::ServerBusy).of(Lang::En));
        assert_ne!(busy, of_refusal(Refused::Banned).of(Lang::En));
    }
}
