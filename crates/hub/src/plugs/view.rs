//! A plug as clients of the API see it, and what it counts.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::Serialize;
use utoipa::ToSchema;

use crate::sync::lock;
use crate::text::Both;

/// A plug: a server of another protocol, or a connection to one.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct PlugView {
    /// `modbus`, `mqtt` or `opcua`.
    pub protocol: &'static str,
    /// Its name in the configuration.
    pub name: String,
    /// Where it listens, or what it connects to.
    pub address: String,
    /// Why it does not listen or is not connected; null: it is.
    #[schema(required)]
    pub error: Option<Both>,
    /// Its clients.
    pub clients: Vec<PlugClient>,
    /// Requests that were answered.
    pub requests: u64,
    /// Of these, those that were refused: on Modbus by an exception.
    pub exceptions: u64,
    /// Frames or messages that were none, and connections closed for that.
    pub malformed: u64,
    /// Connections that were not taken: not allowed, or too many. Over MQTT: lost results.
    pub rejected: u64,
}

/// A client of a plug.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct PlugClient {
    /// Its name in the configuration.
    pub name: String,
    /// Its address, or the serial port.
    pub from: String,
    /// Its seat: what holds authority.
    pub seat: String,
    /// When it connected, ms since 1970.
    pub since_ms: u64,
}

/// What a plug counts.
#[derive(Debug, Default)]
pub struct Counts {
    pub(super) requests: AtomicU64,
    pub(super) exceptions: AtomicU64,
    pub(super) malformed: AtomicU64,
    pub(super) rejected: AtomicU64,
    error: Mutex<Option<Both>>,
    /// By seat.
    clients: Mutex<BTreeMap<String, PlugClient>>,
}

impl Counts {
    /// Counts one more.
    pub fn count(&self, of: impl Fn(&Self) -> &AtomicU64) {
        of(self).fetch_add(1, Ordering::Relaxed);
    }

    /// Why it does not listen or is not connected; `true`: that is news.
    pub fn set_error(&self, error: Option<Both>) -> bool {
        let mut own = lock(&self.error);
        let news = *own != error;
        *own = error;
        news
    }

    /// A client is there.
    pub fn came(&self, client: PlugClient) {
        lock(&self.clients).insert(client.seat.clone(), client);
    }

    /// A client has gone.
    pub fn went(&self, seat: &str) {
        lock(&self.clients).remove(seat);
    }

    /// The plug as it is.
    pub fn view(&self, protocol: &'static str, name: &str, address: String) -> PlugView {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        PlugView {
            protocol,
            name: name.to_owned(),
            address,
            error: lock(&self.error).clone(),
            clients: lock(&self.clients).values().cloned().collect(),
            requests: of(&self.requests),
            exceptions: of(&self.exceptions),
            malformed: of(&self.malformed),
            rejected: of(&self.rejected),
        }
    }
}
