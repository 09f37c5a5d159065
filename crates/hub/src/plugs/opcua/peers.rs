//! Who is at the other end of a secure channel.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex};

use crate::sync::lock;

/// The open channels, by number. One that is not here did not come through the front, or its connection has ended.
#[derive(Clone, Debug, Default)]
pub struct Peers(Arc<Mutex<BTreeMap<u32, SocketAddr>>>);

impl Peers {
    /// A channel of a connection is open.
    pub fn came(&self, channel: u32, from: SocketAddr) {
        lock(&self.0).insert(channel, from);
    }

    /// A connection has ended, and its channels with it.
    pub fn went(&self, from: SocketAddr) {
        lock(&self.0).retain(|_, it| *it != from);
    }

    /// Who is at the other end of a channel.
    pub fn of(&self, channel: u32) -> Option<SocketAddr> {
        lock(&self.0).get(&channel).copied()
    }
}
