//! The seats of the sessions: each session that asks for something of the hub has one.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use opcua::server::authenticator::UserToken;
use opcua::server::node_manager::RequestContext;
use tokio::runtime::Handle;
use tokio::sync::{mpsc, oneshot};

use super::methods::Method;
use super::peers::Peers;
use super::session::{ASKS_MAX, Ask, Beginning, Session};
use super::{Server, ServerConfig, VIA};
use crate::access::{Kind, Principal, Role, Standing};
use crate::hub::{Caller, Hub};
use crate::plugs::modbus::access::Level;
use crate::plugs::refusal::{Failed, Refusal};
use crate::plugs::view::PlugClient;
use crate::sync::lock;
use opcua::types::Variant;

/// The user of a session: the name, and the digest of the password with which the user has logged in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Who(Option<(String, String)>);

/// What a user may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rights {
    /// Read.
    pub reads: bool,
    /// Command; Stop, Close and Lockout are taken all the same.
    pub operates: bool,
}

impl Rights {
    const NONE: Self = Self { reads: false, operates: false };

    fn of(level: Level) -> Self {
        Self { reads: level >= Level::Observer, operates: level >= Level::Operator }
    }
}

impl Who {
    /// A user who has logged in.
    pub fn user(name: &str, password: &str) -> UserToken {
        UserToken(format!("{password}\n{name}"))
    }

    fn of(token: &UserToken) -> Self {
        let split = token.0.split_once('\n').filter(|_| !token.is_anonymous());
        Self(split.map(|(password, name)| (name.to_owned(), password.to_owned())))
    }

    /// What the user may do now.
    pub fn rights(&self, hub: &Hub, config: &ServerConfig) -> Rights {
        let Some((name, password)) = &self.0 else { return Rights::of(config.anonymous) };
        let standing = hub.access().standing(name);
        let Some((role, _)) = standing.filter(|(_, now)| now == password) else {
            return Rights::NONE;
        };
        let level = if role >= Role::Operator { Level::Operator } else { Level::Observer };
        Rights::of(level.min(config.role))
    }

    fn name(&self, config: &ServerConfig) -> String {
        match &self.0 {
            Some((name, _)) => name.clone(),
            None => format!("opcua {}", config.name),
        }
    }
}

/// The seat of a session.
#[derive(Debug)]
pub struct Seat {
    token: UserToken,
    channel: u32,
    asks: mpsc::Sender<Ask>,
    /// What the user may do.
    pub rights: Rights,
    /// As the author of what it asks for.
    pub caller: Caller,
}

/// The seats.
#[derive(Clone, Debug)]
pub struct Seats {
    hub: Hub,
    server: Arc<Server>,
    peers: Peers,
    main: Handle,
    all: Arc<Mutex<HashMap<u32, Arc<Seat>>>>,
}

impl Seats {
    /// None yet.
    pub fn new(hub: &Hub, server: &Arc<Server>, peers: &Peers, main: &Handle) -> Self {
        let (hub, server, peers) = (hub.clone(), server.clone(), peers.clone());
        Self { hub, server, peers, main: main.clone(), all: Arc::default() }
    }

    /// The hub's own threads.
    pub fn main(&self) -> &Handle {
        &self.main
    }

    /// Users or their rights have changed: who has no seat, which looks for itself, logs in again.
    pub fn end_others(&self) {
        let seated: Vec<u32> = lock(&self.all).values().map(|it| it.channel).collect();
        self.peers.end_others(|channel| seated.contains(&channel));
    }

    /// Whether who asks may read.
    pub fn may_read(&self, context: &RequestContext) -> bool {
        self.of(context).is_some_and(|seat| seat.rights.reads)
    }

    /// The seat of who asks; `None`: the connection did not come through the front.
    pub fn of(&self, context: &RequestContext) -> Option<Arc<Seat>> {
        let (channel, number) = (context.session.read().secure_channel_id(), context.session_id);
        let mut all = lock(&self.all);
        if let Some(seat) = all.get(&number) {
            let is_open = !seat.asks.is_closed();
            if seat.channel == channel && seat.token == context.token && is_open {
                return Some(seat.clone());
            }
        }
        let from = self.peers.of(channel)?;
        let config = &self.server.config;
        let who = Who::of(&context.token);
        let rights = who.rights(&self.hub, config);
        let principal = Principal {
            user: who.name(config),
            role: if rights.operates { Role::Operator } else { Role::Observer },
            kind: Kind::Opcua,
            key: format!("opcua {} {number} {channel}", config.name),
            csrf: String::new(),
            expires_ms: 0,
            standing: Standing::Good,
        };
        let (place, since_ms) = (from.to_string(), self.hub.clock().now_ms());
        let key = self.hub.connect(&principal, &place, None);
        let caller = Caller::plug(principal, place.clone(), key.seat.clone(), VIA);
        self.server.counts.came(PlugClient {
            name: caller.principal.user.clone(),
            from: place,
            seat: key.seat.clone(),
            since_ms,
        });
        let (asks, asked) = mpsc::channel(ASKS_MAX);
        let session = context.session.clone();
        let seat = Arc::new(Seat {
            token: context.token.clone(),
            channel,
            asks,
            rights,
            caller: caller.clone(),
        });
        // One that was there ends: its asks have no sender any more.
        all.insert(number, seat.clone());
        drop(all);
        let beginning = Beginning {
            hub: self.hub.clone(),
            server: self.server.clone(),
            peers: self.peers.clone(),
            active: Box::new(move || {
                let session = session.read();
                session.is_activated().then(|| session.secure_channel_id())
            }),
            channel: (channel, from),
            who,
            rights,
            key,
            caller,
        };
        let (all, own) = (self.all.clone(), Arc::downgrade(&seat));
        self.main.spawn(async move {
            Session::begin(beginning).run(asked).await;
            let is_own = |it: &Arc<Seat>| std::ptr::eq(Arc::as_ptr(it), own.as_ptr());
            let mut all = lock(&all);
            if all.get(&number).is_some_and(is_own) {
                all.remove(&number);
            }
        });
        Some(seat)
    }
}

impl Seat {
    /// Calls a method that is a command.
    pub async fn command(
        &self,
        monitor: Option<usize>,
        method: Method,
        inputs: Vec<Variant>,
    ) -> Result<(), Failed> {
        let (done, result) = oneshot::channel();
        let ask = Ask::Command { monitor, method, inputs, done };
        if self.asks.send(ask).await.is_err() {
            return Err(Failed::from(Refusal::Session));
        }
        result.await.unwrap_or(Err(Failed::from(Refusal::Unknown)))
    }

    /// The key of a monitor.
    pub async fn key(&self, monitor: usize) -> Option<u64> {
        let (done, key) = oneshot::channel();
        self.asks.send(Ask::Key(monitor, done)).await.ok()?;
        key.await.ok().flatten()
    }

    /// A sign of life.
    pub async fn alive(&self, ticket: Option<u64>) -> Option<(Option<u64>, bool)> {
        let (done, alive) = oneshot::channel();
        self.asks.send(Ask::Alive(ticket, done)).await.ok()?;
        alive.await.ok()
    }
}
