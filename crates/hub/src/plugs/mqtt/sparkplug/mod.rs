//! Sparkplug B: the hub as an edge node, its monitors as the devices of that node.
//!
//! ```text
//!  session ─▶ serve ─▶ commands ─▶ desk ─▶ hand ─▶ hub: authority, commands
//!  broker       │        reads     decides  orders
//!    ◀──────── node ◀─ metrics ◀─ states, results
//!             births, data, deaths, what was missed
//! ```
//!
//! [`node`] decides what is published and is without I/O and clock. What commands, and what becomes of it, are the
//! desk and the hand of the plain topics. Version 3.0 of the specification; what is ours in it: docs/mqtt.md.

mod commands;
mod history;
mod metrics;
mod node;
mod payload;
pub mod serve;

#[cfg(test)]
mod attack;
#[cfg(test)]
mod host;
#[cfg(test)]
mod node_tests;

use std::time::Duration;

/// What all topics of the format begin with.
const SPACE: &str = "spBv1.0";

/// An edge node of the configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeConfig {
    /// The group.
    pub group: String,
    /// The node.
    pub node: String,
    /// The host without which nothing is published; `None`: there is none.
    pub host: Option<String>,
    /// Values that wait while it is not there, at most.
    pub history: usize,
    /// They are not older than this.
    pub history_age: Duration,
}

impl NodeConfig {
    /// A topic of the node.
    fn topic(&self, kind: &str) -> String {
        let Self { group, node, .. } = self;
        format!("{SPACE}/{group}/{kind}/{node}")
    }

    /// A topic of a device; `+`: of all.
    fn topic_of(&self, kind: &str, device: &str) -> String {
        format!("{}/{device}", self.topic(kind))
    }

    /// Where the host says whether it is there.
    fn host_topic(&self) -> Option<String> {
        let host = self.host.as_ref()?;
        Some(format!("{SPACE}/STATE/{host}"))
    }

    /// What is like the prefix of the plain topics: no other node has it.
    pub fn prefix(&self) -> String {
        self.topic("+")
    }
}
