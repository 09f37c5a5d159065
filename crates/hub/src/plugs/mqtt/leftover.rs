//! What a broker keeps of monitors that are not configured any more: clients would take them for living ones.

use serde::Deserialize;

use super::{BrokerConfig, discovery, message};
use crate::config::is_name;

/// Such monitors in a session at most; the rest is for the next one.
pub const LEFT_MAX: usize = 256;

/// A key as it was published.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Key {
    key: Option<String>,
}

/// What is subscribed to: each monitor that a hub has published has a key there. No other device has such messages.
pub fn filter(config: &BrokerConfig) -> String {
    config.topic("+/key")
}

/// Whether it is what a hub has published of a monitor that is not configured now.
pub fn is_left(config: &BrokerConfig, id: &str, payload: &[u8]) -> bool {
    let is_ours = |it: Key| it.key.is_none_or(|key| message::number(&key).is_some());
    is_name(id)
        && !config.monitors.iter().any(|it| it == id)
        && message::is_object(payload)
        && serde_json::from_slice(payload).is_ok_and(is_ours)
}

/// The topics that are kept of it; last the key, by which it is known.
pub fn topics(config: &BrokerConfig, id: &str) -> Vec<String> {
    let of = |part| format!("{}/{id}/{part}", config.prefix);
    let discovered = discovery::topic(config, id);
    [of("state"), of("available")].into_iter().chain(discovered).chain([of("key")]).collect()
}
