//! Who is at the other end of a secure channel.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex};

use tokio::sync::Notify;

use crate::sync::lock;

/// The open channels, by number. One that is not here did not come through the front, or its connection has ended.
#[derive(Clone, Debug, Default)]
pub struct Peers(Arc<Mutex<BTreeMap<u32, Peer>>>);

/// The other end of a channel, and how its connection is ended.
#[derive(Clone, Debug)]
struct Peer {
    from: SocketAddr,
    end: Arc<Notify>,
}

impl Peers {
    /// A channel of a connection is open; the connection ends when it is notified.
    pub fn came(&self, channel: u32, from: SocketAddr, end: &Arc<Notify>) {
        lock(&self.0).insert(channel, Peer { from, end: end.clone() });
    }

    /// A connection has ended, and its channels with it.
    pub fn went(&self, from: SocketAddr) {
        lock(&self.0).retain(|_, it| it.from != from);
    }

    /// Who is at the other end of a channel.
    pub fn of(&self, channel: u32) -> Option<SocketAddr> {
        lock(&self.0).get(&channel).map(|it| it.from)
    }

    /// Ends the connection of a channel.
    pub fn end(&self, channel: u32) {
        if let Some(peer) = lock(&self.0).get(&channel) {
            peer.end.notify_one();
        }
    }

    /// Ends the connections of all channels but these.
    pub fn end_others(&self, kept: impl Fn(u32) -> bool) {
        let all = lock(&self.0);
        all.iter().filter(|(channel, _)| !kept(**channel)).for_each(|(_, it)| it.end.notify_one());
    }
}
