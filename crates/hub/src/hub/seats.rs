//! WebSocket clients and their seats.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use axum::extract::ws::Utf8Bytes;
use tokio::sync::{broadcast, mpsc, watch};

use super::Hub;
use crate::access::Principal;
use crate::monitor::station::Station;
use crate::publish::messages::Message;
use crate::sync::lock;

/// Messages that may wait for a slow client: so many that are for it alone, and so many that are for all.
const EVENTS_MAX: usize = 128;

/// The seats by id.
#[derive(Debug)]
pub(super) struct Seats {
    all: Mutex<HashMap<String, Live>>,
    next: AtomicU64,
    /// What is for all is queued once: a message takes a place here, whatever the number of seats.
    common: broadcast::Sender<Utf8Bytes>,
}

impl Default for Seats {
    fn default() -> Self {
        let common = broadcast::Sender::new(EVENTS_MAX);
        Self { all: Mutex::default(), next: AtomicU64::default(), common }
    }
}

/// A WebSocket and its seat.
#[derive(Debug)]
struct Live {
    events: mpsc::Sender<Utf8Bytes>,
    missed: Arc<AtomicU64>,
    /// Dropped with this: the seat is another connection's.
    _has: watch::Sender<()>,
    /// Number of the connection: a seat outlives its connection.
    connection: u64,
    /// Secret with which a new connection resumes the seat; `None` if the random generator failed: the
    /// seat cannot be resumed.
    resume: Option<String>,
    principal: Principal,
    from: String,
    since_ms: u64,
}

/// The client of a WebSocket.
#[derive(Clone, Debug)]
pub struct Seated {
    /// Id of its seat.
    pub seat: String,
    /// User, role and session.
    pub principal: Principal,
    /// Address of the client.
    pub from: String,
    /// When it connected, ms since 1970.
    pub since_ms: u64,
    /// Whether the connection is open; a lost one may be resumed while its seat holds authority.
    pub open: bool,
}

/// The seat of a new WebSocket.
#[derive(Debug)]
pub struct SeatKey {
    /// Id of the seat.
    pub seat: String,
    /// Secret with which a later connection resumes the seat.
    pub resume: Option<String>,
    /// Messages to this client alone, besides published values.
    pub events: mpsc::Receiver<Utf8Bytes>,
    /// Messages to every client. Unread, it costs the sender nothing.
    pub common: broadcast::Receiver<Utf8Bytes>,
    /// Messages dropped because the client is slow.
    pub missed: Arc<AtomicU64>,
    /// Whether the seat is still this connection's.
    pub has: Has,
    connection: u64,
}

/// Whether a connection has its seat, or another one has resumed it.
#[derive(Clone, Debug)]
pub struct Has(watch::Receiver<()>);

impl Has {
    /// Whether it has it still.
    pub fn still(&self) -> bool {
        self.0.has_changed().is_ok()
    }

    /// Waits until it has it no more.
    pub async fn lost(mut self) {
        while self.0.changed().await.is_ok() {}
    }
}

impl Hub {
    /// Gives a new WebSocket a seat; with the right secret, the one it had before.
    pub fn connect(&self, principal: &Principal, from: &str, resume: Option<&str>) -> SeatKey {
        self.connect_with(principal, from, resume, crate::access::secret().ok())
    }

    /// `secret`: with which the new connection can be resumed later.
    fn connect_with(
        &self,
        principal: &Principal,
        from: &str,
        resume: Option<&str>,
        secret: Option<String>,
    ) -> SeatKey {
        let user = &principal.user;
        let (sender, events) = mpsc::channel(EVENTS_MAX);
        let missed = Arc::new(AtomicU64::new(0));
        let (given, has) = watch::channel(());
        let mut seats = lock(&self.0.seats.all);
        let old = resume.and_then(|secret| {
            let matches = |live: &&Live| {
                live.resume.as_deref() == Some(secret) && live.principal.user == *user
            };
            seats.iter().find(|(_, live)| matches(live)).map(|(seat, _)| seat.clone())
        });
        let connection = self.0.seats.next.fetch_add(1, Ordering::Relaxed) + 1;
        let resumed = old.is_some();
        let seat = old.unwrap_or_else(|| format!("s{connection}"));
        let live = Live {
            events: sender,
            missed: missed.clone(),
            _has: given,
            connection,
            resume: secret.clone(),
            principal: principal.clone(),
            from: from.to_owned(),
            since_ms: self.clock().now_ms(),
        };
        seats.insert(seat.clone(), live);
        drop(seats);
        // A new seat has nothing.
        if resumed {
            self.stations().iter().for_each(|station| self.seat_is_back(station, &seat));
        }
        let common = self.0.seats.common.subscribe();
        SeatKey { seat, resume: secret, events, common, missed, has: Has(has), connection }
    }

    /// A WebSocket is closed: its motions stop, and its authority is lost unless it is resumed.
    pub fn disconnect(&self, key: &SeatKey) {
        let mut seats = lock(&self.0.seats.all);
        if seats.get(&key.seat).is_none_or(|live| live.connection != key.connection) {
            return;
        }
        if !self.seat_is_silent_everywhere(&key.seat) {
            seats.remove(&key.seat);
        }
    }

    /// A seat gives no sign of life to any monitor. Whether it has authority over one.
    pub fn seat_is_silent_everywhere(&self, seat: &str) -> bool {
        let stations = self.stations();
        stations.iter().fold(false, |holds, it| self.seat_is_silent(it, seat) | holds)
    }

    /// A seat gives no sign of life: its motions on a monitor stop, what it asks for is withdrawn, and its authority
    /// over it is lost unless [`Hub::seat_is_back`] comes in time. Whether it has authority.
    pub fn seat_is_silent(&self, station: &Station, seat: &str) -> bool {
        station.let_go(seat);
        let (asked, holds) = {
            let mut authority = lock(&station.authority);
            (authority.is_asked_by(seat), authority.lost(self.now(), seat))
        };
        if asked || holds {
            station.publish_authority(self);
        }
        holds
    }

    /// A seat gives signs of life again.
    pub fn seat_is_back(&self, station: &Station, seat: &str) {
        if lock(&station.authority).back(self.now(), seat) {
            station.publish_authority(self);
        }
    }

    /// The clients of the WebSockets.
    pub fn connected(&self) -> Vec<Seated> {
        let seats = lock(&self.0.seats.all);
        let one = |(seat, live): (&String, &Live)| Seated {
            seat: seat.clone(),
            principal: live.principal.clone(),
            from: live.from.clone(),
            since_ms: live.since_ms,
            open: !live.events.is_closed(),
        };
        seats.iter().map(one).collect()
    }

    /// Sends a message to a seat, written: what waits for a slow client takes little room. Dropped and counted if it
    /// is slow.
    pub fn send_to(&self, seat: &str, message: &Message) {
        let message = message.written();
        let seats = lock(&self.0.seats.all);
        if let Some(live) = seats.get(seat)
            && live.events.try_send(message).is_err()
        {
            live.missed.fetch_add(1, Ordering::Relaxed);
            self.counts().missed.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Sends a message to every seat, in the order of the calls. Written and queued once: the list of seats is not
    /// looked at, and of the clients only those that wait for it are woken.
    pub(super) fn send_to_all(&self, message: &Message) {
        // Without a client there is none to send it to.
        _ = self.0.seats.common.send(message.written());
    }

    /// Counts messages to all that a slow client has missed.
    pub fn count_missed(&self, count: u64) {
        self.counts().missed.fetch_add(count, Ordering::Relaxed);
    }

    /// Forgets a seat whose connection is lost, unless it may come back to what it holds.
    pub(super) fn forget_seat(&self, seat: &str) {
        let holds = |station: &std::sync::Arc<Station>| {
            lock(&station.authority).holder().is_some_and(|(holder, _)| holder.seat == seat)
        };
        if self.stations().iter().any(holds) {
            return;
        }
        lock(&self.0.seats.all).retain(|id, live| id != seat || !live.events.is_closed());
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::time::Duration;

    use serde_json::Value;
    use tokio::sync::broadcast::error::{RecvError, TryRecvError};

    use super::*;
    use crate::hub::Caller;
    use crate::text::both;
    use crate::{Clock, Config};

    /// Assumed: many clients are connected, and something holds the list of them.
    #[test]
    fn an_event_waits_for_no_list_of_clients() {
        let (hub, _) = Hub::of_one(None);
        let principal = Caller::hub().principal;
        let mut idle: Vec<SeatKey> = (0..500).map(|_| hub.connect(&principal, "", None)).collect();
        let held = lock(&hub.0.seats.all);
        let (own, (said, heard)) = (hub.clone(), channel());
        let sends = std::thread::spawn(move || {
            own.event(Some("M1"), &both("tested", "проверено"));
            said.send(())
        });
        assert_eq!(heard.recv_timeout(Duration::from_secs(30)), Ok(()));
        drop(held);
        sends.join().unwrap().unwrap();
        for key in &mut idle {
            assert!(key.common.try_recv().is_ok_and(|it| it.contains("tested")));
            assert_eq!(key.common.try_recv(), Err(TryRecvError::Empty), "once");
            assert!(key.events.try_recv().is_err(), "it takes no place of what is for one alone");
        }
    }

    /// One client takes everything at once, another one nothing for a while.
    #[tokio::test]
    async fn events_come_in_their_order_and_what_a_slow_client_misses_is_counted() {
        let (hub, _) = Hub::of_one(None);
        let principal = Caller::hub().principal;
        let mut quick = hub.connect(&principal, "", None);
        let mut slow = hub.connect(&principal, "", None);
        let number = |message: &Utf8Bytes| -> u64 {
            let message: Value = serde_json::from_str(message).unwrap();
            message["what"]["en"].as_str().unwrap().parse().unwrap()
        };
        let count = EVENTS_MAX as u64 + 30;
        for event in 0..count {
            hub.event(None, &both(event.to_string(), event.to_string()));
            assert_eq!(number(&quick.common.recv().await.unwrap()), event);
        }
        assert_eq!(slow.common.recv().await, Err(RecvError::Lagged(30)), "the oldest");
        for event in 30..count {
            assert_eq!(number(&slow.common.recv().await.unwrap()), event);
        }
        assert_eq!(slow.common.try_recv(), Err(TryRecvError::Empty));
    }

    /// Its connection is lost, and another client takes the monitor before it comes back.
    #[tokio::test]
    async fn a_lost_seat_is_forgotten_with_the_last_that_it_held() {
        let (hub, station) = Hub::of_one(None);
        let principal = Caller::hub().principal;
        let key = hub.connect(&principal, "", None);
        let caller = Caller::socket(principal.clone(), [127, 0, 0, 1].into(), key.seat.clone());
        hub.change_authority(&caller, &station, "take", None).unwrap();
        drop(key.events);
        let key = SeatKey { events: mpsc::channel(1).1, ..key };
        hub.disconnect(&key);
        assert_eq!(hub.connected().len(), 1, "it may come back");
        hub.change_authority(&Caller::hub(), &station, "force", Some("as a test")).unwrap();
        assert!(hub.connected().is_empty(), "{:?}", hub.connected());
    }

    #[tokio::test]
    async fn without_random_numbers_a_connection_is_closed_like_any_other() {
        let hub = Hub::new(Config::default(), Clock::System, Value::Null).unwrap();
        let principal = Caller::hub().principal;
        let first = hub.connect_with(&principal, "", None, None);
        let second = hub.connect_with(&principal, "", Some(""), None);
        assert_ne!(first.seat, second.seat, "nothing brings a connection back without a secret");
        assert_eq!((first.resume.clone(), hub.connected().len()), (None, 2));
        hub.disconnect(&first);
        hub.disconnect(&second);
        assert!(hub.connected().is_empty());
    }
}
