//! What clients say over the WebSocket.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use serde_json::value::RawValue;
use utoipa::ToSchema;

use crate::api::monitors::JogBeat;

/// Longest text that is an id.
const ID_MAX: usize = 128;

/// What a client calls its message: a number or a short text. Any other is answered with `null`, so
/// that answers stay small.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Id(Option<Value>);

impl From<Option<Value>> for Id {
    fn from(value: Option<Value>) -> Self {
        Self(value.filter(|value| match value {
            Value::Number(_) => true,
            Value::String(text) => text.len() <= ID_MAX,
            _ => false,
        }))
    }
}

impl<'de> Deserialize<'de> for Id {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Option::<Value>::deserialize(from).map(Self::from)
    }
}

/// A message of a client.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Said {
    Request {
        #[serde(default)]
        #[schema(value_type = Option<String>)]
        id: Id,
        monitor: String,
        request: String,
        /// When it was sent, by the client's monotonic clock, ms.
        t: Option<f64>,
        /// The same in ms since the hub's start, as far as the client knows them.
        up_ms: Option<f64>,
        confirm: Option<String>,
        /// A parameter is waited for until it is stored.
        #[serde(default)]
        save: bool,
    },
    Stop {
        #[serde(default)]
        #[schema(value_type = Option<String>)]
        id: Id,
        monitor: Option<String>,
        of: Option<String>,
    },
    Close {
        #[serde(default)]
        #[schema(value_type = Option<String>)]
        id: Id,
        monitor: String,
        valve: Option<String>,
    },
    Lockout {
        #[serde(default)]
        #[schema(value_type = Option<String>)]
        id: Id,
        monitor: Option<String>,
    },
    Authority {
        #[serde(default)]
        #[schema(value_type = Option<String>)]
        id: Id,
        monitor: String,
        action: String,
        reason: Option<String>,
    },
    Jog {
        monitor: String,
        #[serde(flatten)]
        beat: JogBeat,
    },
    JogEnd {
        monitor: String,
        drive: String,
    },
    /// Measures a drive (role engineer, with authority); the topic `tune` shows how far it is.
    Tune {
        #[serde(default)]
        #[schema(value_type = Option<String>)]
        id: Id,
        monitor: String,
        drive: String,
        /// As that of a request.
        up_ms: Option<f64>,
    },
    /// The client of a tuning is still there: at least every two seconds.
    TuneBeat {
        monitor: String,
        /// The tuning is to end.
        #[serde(default)]
        end: bool,
    },
    Watch {
        frames: Vec<String>,
    },
    /// What the client looks at; without `monitors`, at all of them.
    Subscribe {
        #[serde(default)]
        #[schema(value_type = Option<String>)]
        id: Id,
        monitors: Option<Vec<String>>,
    },
}

/// The kinds of messages, as the type has them: they are named in the answer to any other.
pub fn kinds() -> Vec<String> {
    let error = serde_json::from_str::<Said>(r#"{"type":""}"#).err();
    let text = error.map(|error| error.to_string()).unwrap_or_default();
    let names = text.split('`').skip(1).step_by(2).filter(|name| !name.is_empty());
    names.map(str::to_owned).collect()
}

/// What a message says. Stop, Close and Lockout are understood as far as they can be, as over HTTP:
/// what makes no sense in them is left out.
pub fn understand(text: &str) -> Result<Said, serde_json::Error> {
    let error = match serde_json::from_str(text) {
        Ok(said) => return Ok(said),
        Err(error) => error,
    };
    // Each value by itself: of one that is none, as the number 1e400 or half a surrogate pair, only
    // that one is left out.
    let Ok(parts) = serde_json::from_str::<BTreeMap<String, &RawValue>>(text) else {
        return Err(error);
    };
    let part = |name: &str| serde_json::from_str::<Value>(parts.get(name)?.get()).ok();
    let word = |name: &str| part(name)?.as_str().map(str::to_owned);
    let id = Id::from(part("id"));
    match (word("type").as_deref(), word("monitor")) {
        (Some("stop"), monitor) => Ok(Said::Stop { id, monitor, of: word("of") }),
        (Some("lockout"), monitor) => Ok(Said::Lockout { id, monitor }),
        (Some("close"), Some(monitor)) => Ok(Said::Close { id, monitor, valve: word("valve") }),
        _ => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_clients_say_is_understood() {
        let said = |text: &str| serde_json::from_str::<Said>(text);
        assert!(matches!(said(r#"{"type":"stop"}"#), Ok(Said::Stop { monitor: None, .. })));
        let jog =
            said(r#"{"type":"jog","monitor":"M1","drive":"Vertical","toward":"max","t":1.5}"#);
        assert!(matches!(jog, Ok(Said::Jog { beat: JogBeat { t: Some(_), end: false, .. }, .. })));
        assert!(said(r#"{"type":"jog_end","monitor":"M1","drive":"Vertical"}"#).is_ok());
        assert!(said(r#"{"type":"dance"}"#).is_err());
    }

    #[test]
    fn every_kind_is_named() {
        let kinds = kinds();
        assert!(kinds.len() >= 8 && kinds.iter().any(|kind| kind == "jog_end"), "{kinds:?}");
        for kind in kinds {
            let error = serde_json::from_str::<Said>(&format!(r#"{{"type":"{kind}"}}"#)).err();
            let known = error.is_none_or(|error| !error.to_string().contains("variant"));
            assert!(known, "{kind}");
        }
    }

    /// The grammar of JSON allows all of these, and none of them is a value.
    #[test]
    fn a_value_that_is_none_stops_no_stop() {
        for none in ["1e400", "-1e999", r#""\ud800""#, r#""\udc00x""#, r#"[1e400, "\ud800"]"#] {
            for name in ["id", "of", "more"] {
                let text = format!(r#"{{"{name}":{none},"type":"stop","monitor":"M1"}}"#);
                let Ok(Said::Stop { id, monitor, of: None }) = understand(&text) else {
                    panic!("{text}")
                };
                assert_eq!((id, monitor.as_deref()), (Id::default(), Some("M1")), "{text}");
            }
            let text = format!(r#"{{"type":"lockout","id":{none}}}"#);
            assert!(matches!(understand(&text), Ok(Said::Lockout { monitor: None, .. })), "{text}");
            let text = format!(r#"{{"type":"close","monitor":"M1","id":"a","valve":{none}}}"#);
            let Ok(Said::Close { id, valve: None, .. }) = understand(&text) else {
                panic!("{text}")
            };
            assert_eq!(id.0, Some("a".into()), "what can be read is kept");
            // What is not urgent is refused.
            let text = format!(r#"{{"type":"watch","frames":["M1"],"id":{none}}}"#);
            let refused = understand(&text).is_err();
            assert!(refused || matches!(understand(&text), Ok(Said::Watch { .. })), "{text}");
        }
        assert!(understand(r#"{"type":"stop","id":1e400"#).is_err(), "it may be cut off anywhere");
    }

    #[test]
    fn ids_are_small() {
        let id = |id: Value| Id::from(Some(id));
        assert_eq!(id("x".repeat(ID_MAX).into()).0, Some("x".repeat(ID_MAX).into()));
        for large in ["x".repeat(ID_MAX + 1).into(), Value::Array(vec![]), Value::Null] {
            assert_eq!(id(large), Id::default());
        }
        let text = format!(r#"{{"type":"stop","monitor":["M1"],"id":"{}"}}"#, "x".repeat(9000));
        let Ok(Said::Stop { id, monitor: None, .. }) = understand(&text) else { panic!() };
        assert_eq!(id, Id::default());
    }
}
