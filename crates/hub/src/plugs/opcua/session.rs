//! A session of OPC UA: its seat in the hub, and the desk that decides what it may do. On the hub's own threads.

use std::collections::HashMap;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use opcua::types::Variant;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::{MissedTickBehavior, interval, sleep_until};

use super::methods::Method;
use super::peers::Peers;
use super::seats::{Rights, Who};
use super::{Server, words};
use crate::hub::{Caller, Hub, SeatKey};
use crate::plugs::mqtt::desk::{Act, Around, Desk, Heard, Reply, Terms};
use crate::plugs::mqtt::hand::{Answer, Hand, Tongue};
use crate::plugs::refusal::{Failed, Refusal};

/// So often it is looked whether the session is still there.
const LOOK_EACH: Duration = Duration::from_millis(100);
/// Results that wait for the session.
const RESULTS_MAX: usize = 64;
/// Calls that wait for the session.
pub const ASKS_MAX: usize = 64;

/// What is said of a client.
const TONGUE: Tongue = Tongue {
    silent: |client, from| text::OpcuaSilent { client, from }.words(),
    refusal: words::of,
    ids: false,
};

/// A call.
#[derive(Debug)]
pub enum Ask {
    /// A command to a monitor; `None`: to all.
    Command {
        /// The monitor.
        monitor: Option<usize>,
        /// The method.
        method: Method,
        /// Its arguments.
        inputs: Vec<Variant>,
        /// Where its result goes.
        done: oneshot::Sender<Result<(), Failed>>,
    },
    /// The key with which the next opening of a monitor is taken.
    Key(usize, oneshot::Sender<Option<u64>>),
    /// A sign of life with a ticket; the next ticket, and whether the client counts as alive.
    Alive(Option<u64>, oneshot::Sender<(Option<u64>, bool)>),
}

/// What a session begins with.
pub struct Beginning {
    /// The hub.
    pub hub: Hub,
    /// The server.
    pub server: Arc<Server>,
    /// The open channels.
    pub peers: Peers,
    /// The channel of the session in the library, as long as it is active.
    pub active: Box<dyn Fn() -> Option<u32> + Send + Sync>,
    /// Its channel, and the other end of it.
    pub channel: (u32, SocketAddr),
    /// Its user.
    pub who: Who,
    /// What the user may do.
    pub rights: Rights,
    /// Its seat.
    pub key: SeatKey,
    /// The same, as the author of commands.
    pub caller: Caller,
}

/// A session. Dropped, it ends what it has started.
pub struct Session {
    from: Beginning,
    desk: Desk,
    hand: Hand,
    results: mpsc::Receiver<Answer>,
    waiting: HashMap<String, oneshot::Sender<Result<(), Failed>>>,
    numbers: u64,
    changes: watch::Receiver<u64>,
    checked: (mpsc::Sender<Rights>, mpsc::Receiver<Rights>),
}

fn random() -> Option<u64> {
    getrandom::u64().ok()
}

impl Session {
    /// Begins it.
    pub fn begin(from: Beginning) -> Self {
        let (hub, config) = (&from.hub, &from.server.config);
        let (answers, results) = mpsc::channel(RESULTS_MAX);
        let ids = &config.monitors;
        let terms = Terms { operates: from.rights.operates, ..config.terms };
        let reports = from.server.reports.of(&from.caller.principal.user);
        Self {
            desk: Desk::new(terms, ids.len(), hub.now(), &mut random),
            hand: Hand::new(hub, &from.caller, ids, answers, (reports, TONGUE)),
            results,
            waiting: HashMap::new(),
            numbers: 0,
            changes: hub.access_changes(),
            checked: mpsc::channel(1),
            from,
        }
    }

    /// Until the session or its connection ends, or the rights of its user change.
    pub async fn run(mut self, mut asks: mpsc::Receiver<Ask>) {
        let (mut shutdown, start) = (self.from.hub.shutdown(), self.from.hub.start());
        let mut looks = interval(LOOK_EACH);
        looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        self.check();
        loop {
            let next = self.desk.timeout();
            tokio::select! {
                () = shutdown.requested() => return,
                ask = asks.recv() => match ask {
                    Some(ask) => self.heed(ask),
                    None => return,
                },
                Some((number, result)) = self.results.recv() => {
                    let acts = self.desk.answered(number, result);
                    self.carry_out(acts);
                }
                // What is for this client alone it reads from its variables.
                Some(_) = self.from.key.events.recv() => {}
                Ok(()) = self.changes.changed() => self.check(),
                // What the client has subscribed to ends with its connection.
                Some(rights) = self.checked.1.recv() => if rights != self.from.rights {
                    self.from.peers.end(self.from.channel.0);
                    return;
                },
                _ = looks.tick() => if !self.is_there() {
                    return;
                },
                () = sleep_until(start + next) => {
                    let acts = self.desk.tick(self.from.hub.now(), &mut random);
                    self.carry_out(acts);
                }
            }
        }
    }

    /// The session is active, on the channel on which it was, and the connection of that is open.
    fn is_there(&self) -> bool {
        let (channel, from) = self.from.channel;
        (self.from.active)() == Some(channel) && self.from.peers.of(channel) == Some(from)
    }

    /// Looks, aside, what the user may do now.
    fn check(&self) {
        let (hub, server, who) =
            (self.from.hub.clone(), self.from.server.clone(), self.from.who.clone());
        let checked = self.checked.0.clone();
        tokio::spawn(async move {
            let rights = tokio::task::spawn_blocking(move || who.rights(&hub, &server.config));
            if let Ok(rights) = rights.await {
                _ = checked.send(rights).await;
            }
        });
    }

    fn heed(&mut self, ask: Ask) {
        let hand = self.hand.clone();
        let holder = |at: usize| hand.holder(at);
        let (mut random, now) = (random, self.from.hub.now());
        let mut around = Around { now, holder: &holder, random: &mut random };
        match ask {
            Ask::Command { monitor, method, inputs, done } => {
                self.numbers += 1;
                let id = self.numbers.to_string();
                let asked = method.asked(id.clone(), &inputs);
                self.waiting.insert(id, done);
                let heard = Heard { monitor, retained: false };
                let acts = self.desk.command(&mut around, heard, asked);
                self.carry_out(acts);
            }
            Ask::Key(monitor, done) => _ = done.send(self.desk.key(monitor)),
            Ask::Alive(ticket, done) => {
                let (_, acts) = self.desk.alive(&mut around, ticket);
                self.carry_out(acts);
                _ = done.send((self.desk.ticket(), self.desk.is_live()));
            }
        }
    }

    fn carry_out(&mut self, acts: Vec<Act>) {
        for act in self.hand.carry_out(&self.desk, acts) {
            if let Act::Say(reply) = act {
                self.say(&reply);
            }
        }
    }

    fn say(&mut self, reply: &Reply) {
        if reply.result.is_err() {
            self.from.server.counts.count(|it| &it.exceptions);
        }
        let done = reply.id.as_ref().and_then(|id| self.waiting.remove(id));
        if let Some(done) = done {
            // A call that is given up has no reader.
            _ = done.send(reply.result);
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let acts = self.desk.end(&mut random);
        self.carry_out(acts);
        for (_, done) in self.waiting.drain() {
            _ = done.send(Err(Failed::from(Refusal::Unknown)));
        }
        self.from.hub.disconnect(&self.from.key);
        self.from.server.counts.went(&self.from.key.seat);
    }
}
