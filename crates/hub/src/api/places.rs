//! The connections that are open: how many, whose, and which one gives way to the next.

use std::collections::{BTreeMap, HashMap};
use std::net::{IpAddr, Ipv6Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore};

use crate::hub::Hub;
use crate::server::allowances::{Allowance, Kept, Shared, Talk};

/// Handshakes of TLS at a time, and of one address. One more, and the oldest gives way.
const HANDSHAKES_MAX: usize = 256;
const HANDSHAKES_OF_MAX: usize = 64;
/// Connections at a time that have ended on this side while their clients still send, and of one address. One more,
/// and the oldest is closed: each holds what was read of it, and waits for its turns.
const ENDINGS_MAX: usize = 256;
const ENDINGS_OF_MAX: usize = 64;

/// One of the connections that the hub has room for.
#[derive(Debug)]
pub struct Place {
    hub: Hub,
    address: IpAddr,
    proxy: bool,
    number: u64,
    end: Arc<Notify>,
    /// What cannot be sent any more ends no reading.
    reads_on: AtomicBool,
    /// What the connection may still read and request.
    pub allowance: Allowance,
    #[expect(dead_code, reason = "held for its end")]
    permit: OwnedSemaphorePermit,
}

/// The connections that are open.
#[derive(Debug, Default)]
pub struct Places {
    addresses: HashMap<IpAddr, Here>,
    /// Those whose client is not known yet.
    strangers: Queue,
    /// Those whose handshake is not done yet.
    handshakes: Queue,
    /// Those that have ended on this side.
    endings: Queue,
    /// What those have left that are closed.
    left: Kept<IpAddr, Allowance>,
    /// The same of WebSockets, by who talked from where.
    pub talks: Kept<(String, IpAddr), Talk>,
    next: u64,
}

/// The connections of an address.
#[derive(Debug)]
struct Here {
    count: usize,
    shared: Shared,
}

/// Connections that may have to give way, the oldest first, and how many an address has of them.
#[derive(Debug, Default)]
struct Queue {
    all: BTreeMap<u64, (IpAddr, Arc<Notify>)>,
    of: HashMap<IpAddr, usize>,
}

impl Queue {
    fn enter(&mut self, number: u64, address: IpAddr, end: Arc<Notify>) {
        self.all.insert(number, (address, end));
        *self.of.entry(address).or_default() += 1;
    }

    fn leave(&mut self, number: u64) -> Option<Arc<Notify>> {
        let (address, end) = self.all.remove(&number)?;
        if let Some(count) = self.of.get_mut(&address) {
            *count -= 1;
            if *count == 0 {
                self.of.remove(&address);
            }
        }
        Some(end)
    }

    fn count_of(&self, address: IpAddr) -> usize {
        self.of.get(&address).copied().unwrap_or(0)
    }

    /// The oldest of the address that has most of them gives way.
    fn give_way(&mut self) {
        let most = self.of.values().max().copied().unwrap_or(0);
        self.oldest_gives_way(|queue, address| queue.count_of(address) == most);
    }

    fn oldest_gives_way(&mut self, which: impl Fn(&Self, IpAddr) -> bool) {
        let first = self.all.iter().find(|(_, (address, _))| which(self, *address));
        let number = first.map(|(number, _)| *number);
        if let Some(end) = number.and_then(|number| self.leave(number)) {
            end.notify_one();
        }
    }
}

/// The network of an address: with IPv6, a client has 64 bits of addresses.
pub fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => Ipv6Addr::from_bits(address.to_bits() >> 64 << 64).into(),
        address => address,
    }
}

impl Place {
    /// A place for a connection, if there is one. A quarter of them is for other addresses than
    /// the one that has the most, so that no client takes them all; and half of them for clients that
    /// are known: of the others, the oldest gives way to the next. Its allowance is what an earlier
    /// connection of its address has left.
    pub fn take(hub: &Hub, room: &Arc<Semaphore>, address: IpAddr) -> Option<Self> {
        let proxy = hub.config().proxies.contains(&address.to_canonical());
        let address = network(address);
        let all = hub.config().connections_max;
        let mut places = hub.places();
        let Ok(permit) = room.clone().try_acquire_owned() else {
            places.strangers.give_way();
            return None;
        };
        let strangers_max = all / 2;
        if places.strangers.all.len() >= strangers_max {
            places.strangers.give_way();
        }
        let here = places.addresses.get(&address);
        if here.is_some_and(|it| it.count >= all - all / 4) && !proxy {
            return None;
        }
        let allowance = places.allowance(hub, address, proxy);
        let (number, end) = (places.next, Arc::new(Notify::new()));
        places.next += 1;
        places.strangers.enter(number, address, end.clone());
        hub.counts().connections.fetch_add(1, Ordering::Relaxed);
        let reads_on = AtomicBool::new(false);
        Some(Self { hub: hub.clone(), address, proxy, number, end, reads_on, allowance, permit })
    }

    /// It is a WebSocket: if nothing can be sent over it any more, what its client has sent is read all the same. A Stop
    /// may be in it.
    pub fn read_on(&self) {
        self.reads_on.store(true, Ordering::Relaxed);
    }

    /// Whether it is read on.
    pub fn reads_on(&self) -> bool {
        self.reads_on.load(Ordering::Relaxed)
    }

    /// The client has logged in: the connection leaves the small pool.
    pub fn known(&self) {
        self.hub.places().strangers.leave(self.number);
    }

    /// Its handshake begins, and lasts as long as what is returned.
    pub fn handshake(&self) -> Handshake<'_> {
        self.enter(&mut self.hub.places().handshakes, HANDSHAKES_MAX, HANDSHAKES_OF_MAX);
        Handshake(self)
    }

    /// It has ended on this side, and is closed with what is returned at the latest.
    pub fn ending(self: &Arc<Self>) -> Ending {
        self.enter(&mut self.hub.places().endings, ENDINGS_MAX, ENDINGS_OF_MAX);
        Ending(self.clone())
    }

    /// It is one of those that may have to give way: so many, and of one address.
    fn enter(&self, queue: &mut Queue, most: usize, of_most: usize) {
        if queue.count_of(self.address) >= of_most && !self.proxy {
            queue.oldest_gives_way(|_, address| address == self.address);
        } else if queue.all.len() >= most {
            queue.give_way();
        }
        queue.enter(self.number, self.address, self.end.clone());
    }

    /// It has to give way to another one.
    pub async fn given_up(&self) {
        self.end.notified().await;
    }
}

/// A handshake that is under way.
#[derive(Debug)]
pub struct Handshake<'a>(&'a Place);

impl Drop for Handshake<'_> {
    fn drop(&mut self) {
        self.0.hub.places().handshakes.leave(self.0.number);
    }
}

/// A connection that has ended on this side.
#[derive(Debug)]
pub struct Ending(Arc<Place>);

impl Drop for Ending {
    fn drop(&mut self) {
        self.0.hub.places().endings.leave(self.0.number);
    }
}

impl Places {
    /// The allowance of one connection more.
    fn allowance(&mut self, hub: &Hub, address: IpAddr, proxy: bool) -> Allowance {
        let now = hub.now();
        let left = if proxy { None } else { self.left.take(now, &address) };
        let shared = || left.as_ref().and_then(|it| it.shared.clone());
        let here = self.addresses.entry(address).or_insert_with(|| Here {
            count: 0,
            shared: shared().unwrap_or_else(|| Allowance::of_address(now)),
        });
        here.count += 1;
        let shared = (!proxy).then(|| here.shared.clone());
        match left {
            Some(left) => Allowance { shared, ..left },
            None => Allowance::new(now, shared),
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.hub.counts().connections.fetch_sub(1, Ordering::Relaxed);
        let mut places = self.hub.places();
        places.strangers.leave(self.number);
        if !self.proxy {
            places.left.put(self.hub.now(), self.address, self.allowance.clone());
        }
        if let Some(here) = places.addresses.get_mut(&self.address) {
            here.count -= 1;
            if here.count == 0 {
                places.addresses.remove(&self.address);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use serde_json::json;
    use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};
    use tokio::time::{Instant, timeout_at};

    use super::*;
    use crate::server::paced::Paced;
    use crate::sync::lock;
    use crate::{Clock, Config};

    fn hub(connections_max: usize) -> (Hub, Arc<Semaphore>) {
        let proxies = vec!["10.0.0.9".parse().unwrap()];
        let config = Config { connections_max, proxies, ..Config::default() };
        let hub = Hub::new(config, Clock::System, json!({})).unwrap();
        (hub, Arc::new(Semaphore::new(connections_max)))
    }

    fn take(hub: &Hub, room: &Arc<Semaphore>, address: &str) -> Option<Place> {
        Place::take(hub, room, address.parse().unwrap())
    }

    /// With IPv6 a customer has 2⁶⁴ addresses: they count as one, and share its allowance.
    #[tokio::test]
    async fn a_network_of_64_bits_is_one_client() {
        let (hub, room) = hub(8);
        let of_one = (0..8).map(|host| take(&hub, &room, &format!("2001:db8:0:7::{host:x}")));
        let places: Vec<Place> = of_one.flatten().collect();
        assert_eq!(places.len(), 6, "three quarters of all");
        let shared: Vec<_> = places.iter().filter_map(|it| it.allowance.shared.clone()).collect();
        assert_eq!(shared.len(), 6);
        assert!(shared.windows(2).all(|it| Arc::ptr_eq(&it[0], &it[1])));
        assert!(take(&hub, &room, "2001:db8:0:8::1").is_some(), "the network beside it");
        // The same IPv4 address, as either family has it.
        assert_eq!(network("::ffff:192.0.2.1".parse().unwrap()), IpAddr::from([192, 0, 2, 1]));
    }

    /// Readings of a client that closes the connection after so many, within 10 s.
    async fn readings(hub: &Hub, room: &Arc<Semaphore>, address: &str, each: usize) -> usize {
        let (end, mut count) = (Instant::now() + Duration::from_secs(10), 0);
        loop {
            let place = take(hub, room, address).unwrap();
            let (mut client, stream) = duplex(1 << 16);
            client.write_all(&[0; 1 << 16]).await.unwrap();
            let mut stream = Paced::new(stream, place.allowance.clone(), hub.start());
            for _ in 0..each {
                if timeout_at(end, stream.read_u8()).await.is_err() {
                    return count;
                }
                count += 1;
            }
        }
    }

    #[tokio::test(start_paused = true)]
    async fn who_reconnects_gets_no_more_than_who_stays() {
        let (hub, room) = hub(8);
        let stays = readings(&hub, &room, "10.0.0.1", usize::MAX).await;
        for (address, each) in [("10.0.0.2", 50), ("10.0.0.3", 1), ("2001:db8::1", 50)] {
            let again = readings(&hub, &room, address, each).await;
            assert!(again <= stays + 2, "{again} each {each}, {stays} of who stays");
            assert!(again >= stays / 2, "{again}");
        }
        // Another address does not notice, nor do clients of a proxy one another.
        readings(&hub, &room, "10.0.0.4", 50).await;
        let full = |address: &str| {
            let place = take(&hub, &room, address).unwrap();
            let taken = lock(&place.allowance.readings).take_so_many(hub.now(), 50.0);
            (taken.is_ok(), place.allowance.shared.is_none())
        };
        assert_eq!((full("10.0.0.5"), full("10.0.0.4")), ((true, false), (false, false)));
        assert_eq!((full("10.0.0.9"), full("10.0.0.9")), ((true, true), (true, true)), "a proxy");
    }

    #[tokio::test]
    async fn the_oldest_handshake_of_whoever_has_most_gives_way() {
        let (hub, room) = hub(2048);
        let from = |address: &str| take(&hub, &room, address).unwrap();
        let under_way = |hub: &Hub| hub.places().handshakes.all.len();
        let places: Vec<Place> = (0..100).map(|_| from("10.0.0.1")).collect();
        let all: Vec<_> = places.iter().map(Place::handshake).collect();
        assert_eq!(under_way(&hub), HANDSHAKES_OF_MAX);
        let ended = |place: &Place| {
            let now = std::task::Waker::noop();
            let given_up = std::pin::pin!(place.given_up());
            given_up.poll(&mut std::task::Context::from_waker(now)).is_ready()
        };
        let ended_of = |places: &[Place]| places.iter().filter(|it| ended(it)).count();
        assert_eq!((ended_of(&places[..36]), ended_of(&places[36..])), (36, 0), "the oldest");
        // Many addresses together: who has few of them is not touched.
        let operator = from("10.0.1.1");
        let own = operator.handshake();
        let others: Vec<Place> = (2..12_u8)
            .flat_map(|host| (0..50).map(move |_| format!("10.0.0.{host}")))
            .map(|address| from(&address))
            .collect();
        let more: Vec<_> = others.iter().map(Place::handshake).collect();
        assert_eq!(under_way(&hub), HANDSHAKES_MAX);
        assert!(!ended(&operator), "an operator's");
        drop((all, more, own));
        assert_eq!((under_way(&hub), hub.places().handshakes.of.len()), (0, 0));
    }

    /// Assumed: the client has sent a Stop and is gone, or takes nothing that is sent to it.
    #[tokio::test(start_paused = true)]
    async fn what_came_over_a_websocket_is_read_although_nothing_can_be_sent() {
        let (hub, room) = hub(8);
        for (websocket, gone) in [(true, true), (true, false), (false, true), (false, false)] {
            let place = Arc::new(take(&hub, &room, "10.0.0.1").unwrap());
            let (mut client, stream) = duplex(4);
            client.write_all(b"stop").await.unwrap();
            let client = Some(client).filter(|_| !gone);
            let mut stream = Paced::of(stream, &place, hub.start());
            if websocket {
                place.read_on();
            }
            let mut sent = [stream.write_all(&[0; 64]).await.is_ok(), false, false];
            sent[1] = stream.write_all(&[0; 64]).await.is_ok();
            sent[2] = stream.flush().await.is_ok();
            assert_eq!(sent[..2], [websocket; 2], "{gone}");
            assert!(sent[2]);
            let mut heard = [0; 4];
            stream.read_exact(&mut heard).await.unwrap();
            assert_eq!(&heard, b"stop");
            drop(client);
            assert_eq!(stream.read(&mut heard).await.unwrap(), 0, "its end is noticed");
        }
    }

    /// A client that is refused and goes on sending, again and again, holds no more connections than this.
    #[tokio::test]
    async fn few_connections_are_kept_that_have_ended() {
        let (hub, room) = hub(2048);
        let mut clients = Vec::new();
        let mut served = tokio::task::JoinSet::new();
        for _ in 0..200 {
            let place = Arc::new(take(&hub, &room, "10.0.0.1").unwrap());
            let (client, stream) = duplex(64);
            clients.push(client);
            let mut stream = Paced::of(stream, &place, hub.start());
            served.spawn(async move {
                tokio::select! {
                    _ = stream.shutdown() => {}
                    () = place.given_up() => {}
                }
            });
            tokio::task::yield_now().await;
        }
        for _ in 0..200 - ENDINGS_OF_MAX {
            served.join_next().await.unwrap().unwrap();
        }
        assert_eq!(
            (served.len(), hub.places().endings.all.len()),
            (ENDINGS_OF_MAX, ENDINGS_OF_MAX)
        );
        drop(clients);
        while served.join_next().await.is_some() {}
        let places = hub.places();
        assert_eq!((places.endings.all.len(), places.addresses.len()), (0, 0));
    }
}
