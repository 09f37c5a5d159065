//! Turns of clients: what they have sent is dealt with for few of them at a time, address after address.
//!
//! A client that has two hundred busy connections does not make those of another address wait for all of
//! them, but for the turns that are being taken. And what no client waits for, as a Stop on its way to a
//! monitor and the answer to it, finds processors free and few tasks before it.
//!
//! A turn is one poll of a future: who waits for a disk, a monitor or its client takes none meanwhile. One that is not over
//! after [`LONG`], for whatever reason, holds up no one: the next one that comes is given another.

use std::collections::{HashMap, VecDeque};
use std::net::IpAddr;
use std::num::NonZero;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

use crate::sync::lock;

/// Turns at a time: half of the processors, and of the threads of the hub, are for all else.
const TURNS_MAX: usize = 2;
/// After this time a turn does not count any more: its thread is blocked, or its future is not polled.
const LONG: Duration = Duration::from_millis(100);

/// Whose turns are counted together: an address, or a connection of a proxy, behind which there are many.
pub type Party = (IpAddr, Option<u64>);

/// The turns of all clients. Clones are the same.
#[derive(Clone, Debug)]
pub struct Turns(Arc<Mutex<Inner>>);

#[derive(Debug)]
struct Inner {
    /// As long as some are free, none waits.
    free: usize,
    next: u64,
    /// Who waits, by number.
    waiting: HashMap<u64, Waker>,
    /// Whose turn it is, and who has not come yet; since when.
    called: HashMap<u64, Instant>,
    /// Whose turn is being taken; since when.
    taken: HashMap<u64, Instant>,
    /// The numbers of those who wait, by party in the order of their coming.
    of: HashMap<Party, VecDeque<u64>>,
    /// The parties of which some wait, the next one first.
    order: VecDeque<Party>,
}

impl Default for Turns {
    fn default() -> Self {
        let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
        Self::new((processors / 2).clamp(1, TURNS_MAX))
    }
}

impl Turns {
    /// So many at a time.
    fn new(free: usize) -> Self {
        let (waiting, called, taken, of, order) = Default::default();
        Self(Arc::new(Mutex::new(Inner { free, next: 0, waiting, called, taken, of, order })))
    }

    /// The turns of a client.
    pub fn of(&self, party: Party) -> Client {
        Client { turns: self.clone(), party }
    }
}

/// A client, as far as its turns are concerned.
#[derive(Clone, Debug)]
pub struct Client {
    turns: Turns,
    party: Party,
}

impl Client {
    /// Polls a future in turns of this client alone.
    pub fn serve<F: Future + Unpin>(&self, future: F) -> Served<F> {
        let mut inner = lock(&self.turns.0);
        let number = inner.next;
        inner.next += 1;
        drop(inner);
        Served { future, ticket: Ticket { client: self.clone(), number, waits: false } }
    }
}

/// A future that is polled in turns.
#[derive(Debug)]
pub struct Served<F> {
    future: F,
    ticket: Ticket,
}

impl<F: Future + Unpin> Future for Served<F> {
    type Output = F::Output;

    fn poll(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<F::Output> {
        let Self { future, ticket } = &mut *self;
        let Some(_turn) = ticket.turn(cx) else { return Poll::Pending };
        Pin::new(future).poll(cx)
    }
}

/// The place of a future among those that wait.
#[derive(Debug)]
struct Ticket {
    client: Client,
    number: u64,
    waits: bool,
}

impl Ticket {
    /// A turn, if it is this one's; otherwise it is woken when it is. It never is at once: those that are ready, too,
    /// come to wait first.
    fn turn(&mut self, cx: &Context<'_>) -> Option<Turn<'_>> {
        let mut inner = lock(&self.client.turns.0);
        if !self.waits {
            self.waits = true;
            let next = inner.enter(self.number, self.client.party, cx.waker().clone());
            drop(inner);
            next.into_iter().for_each(Waker::wake);
            return None;
        }
        if let Some(waker) = inner.waiting.get_mut(&self.number) {
            waker.clone_from(cx.waker());
            return None;
        }
        self.waits = false;
        if inner.called.remove(&self.number).is_none() {
            drop(inner);
            // It came too late for its turn.
            return self.turn(cx);
        }
        inner.taken.insert(self.number, Instant::now());
        drop(inner);
        Some(Turn { turns: &self.client.turns, number: self.number })
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        if !self.waits {
            return;
        }
        let next = lock(&self.client.turns.0).leave(self.number, self.client.party);
        next.into_iter().for_each(Waker::wake);
    }
}

/// A turn, until it is dropped.
struct Turn<'a> {
    turns: &'a Turns,
    number: u64,
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        let next = lock(&self.turns.0).end(self.number);
        next.into_iter().for_each(Waker::wake);
    }
}

impl Inner {
    /// One more waits. Returns whom to wake, if a turn is free.
    fn enter(&mut self, number: u64, party: Party, waker: Waker) -> Option<Waker> {
        self.waiting.insert(number, waker);
        let own = self.of.entry(party).or_default();
        if own.is_empty() {
            self.order.push_back(party);
        }
        own.push_back(number);
        match self.free.checked_sub(1) {
            Some(free) => self.free = free,
            None => self.end_long()?,
        }
        self.call()
    }

    /// Ends a turn that is not over after a long time, if there is one.
    fn end_long(&mut self) -> Option<()> {
        let of = |turns: &mut HashMap<u64, Instant>| {
            let long = turns.iter().find(|(_, since)| since.elapsed() >= LONG);
            long.map(|(number, _)| *number).map(|number| _ = turns.remove(&number))
        };
        of(&mut self.taken).or_else(|| of(&mut self.called))
    }

    /// A turn is over: the next one has it, unless it was given on before.
    fn end(&mut self, number: u64) -> Option<Waker> {
        self.taken.remove(&number).and_then(|_| self.call())
    }

    /// Gives a turn to the next one.
    fn call(&mut self) -> Option<Waker> {
        while let Some(party) = self.order.pop_front() {
            let Some(own) = self.of.get_mut(&party) else { continue };
            let first = own.pop_front();
            if own.is_empty() {
                self.of.remove(&party);
            } else {
                self.order.push_back(party);
            }
            let first = first.and_then(|it| Some((it, self.waiting.remove(&it)?)));
            if let Some((number, waker)) = first {
                self.called.insert(number, Instant::now());
                return Some(waker);
            }
        }
        self.free += 1;
        None
    }

    /// One that waits has gone; if it was called, the next one is.
    fn leave(&mut self, number: u64, party: Party) -> Option<Waker> {
        if self.called.remove(&number).is_some() {
            return self.call();
        }
        self.waiting.remove(&number);
        let own = self.of.get_mut(&party)?;
        own.retain(|it| *it != number);
        if own.is_empty() {
            self.of.remove(&party);
            self.order.retain(|it| *it != party);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use std::future::poll_fn;
    use std::pin::pin;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc;

    use tokio::task::{JoinSet, yield_now};
    use tokio::time::timeout;

    use super::*;

    const PATIENCE: Duration = Duration::from_secs(10);

    fn client(turns: &Turns, host: u8) -> Client {
        turns.of(([10, 0, 0, host].into(), None))
    }

    /// Work in so many polls, each of which is noted.
    async fn works(client: Client, host: u8, polls: usize, done: Arc<Mutex<Vec<u8>>>) {
        let mut left = polls;
        let work = poll_fn(|cx| {
            lock(&done).push(host);
            left -= 1;
            if left == 0 {
                return Poll::Ready(());
            }
            cx.waker().wake_by_ref();
            Poll::Pending
        });
        client.serve(work).await;
    }

    /// Two hundred connections of one address have their turns, and one of another address: it waits for one of
    /// them each time, not for two hundred.
    #[tokio::test]
    async fn another_address_does_not_wait_for_all_connections_of_a_flood() {
        const POLLS: usize = 5;
        let (turns, done) = (Turns::new(1), Arc::<Mutex<Vec<u8>>>::default());
        let mut tasks = JoinSet::new();
        for _ in 0..200 {
            tasks.spawn(works(client(&turns, 1), 1, POLLS, done.clone()));
        }
        // All of them wait before the other one comes.
        while lock(&done).len() < 200 {
            yield_now().await;
        }
        let before = lock(&done).len();
        tasks.spawn(works(client(&turns, 2), 2, POLLS, done.clone()));
        while tasks.join_next().await.is_some() {}
        let done = lock(&done);
        assert_eq!(done.len(), 201 * POLLS);
        let last = done.iter().rposition(|it| *it == 2).unwrap();
        let others = done[before..last].iter().filter(|it| **it == 1).count();
        // Each time, the one that is being taken, the next one, and those until it is there to wait.
        assert!(others <= 5 * POLLS, "{others} turns of the flood before {POLLS} of another");
    }

    /// However many are ready, so few are polled at a time.
    #[tokio::test(flavor = "multi_thread", worker_threads = 4)]
    async fn few_are_served_at_a_time() {
        let (now, most) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
        let turns = Turns::new(2);
        let mut tasks = JoinSet::new();
        for host in 0..100 {
            let (client, now, most) = (client(&turns, host % 7), now.clone(), most.clone());
            let mut left = 50;
            tasks.spawn(async move {
                let work = poll_fn(|cx| {
                    most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    std::thread::yield_now();
                    now.fetch_sub(1, Ordering::SeqCst);
                    left -= 1;
                    cx.waker().wake_by_ref();
                    if left == 0 { Poll::Ready(()) } else { Poll::Pending }
                });
                client.serve(work).await;
            });
        }
        let all = async { while tasks.join_next().await.is_some() {} };
        timeout(PATIENCE, all).await.expect("all have their turns");
        assert!((1..=2).contains(&most.load(Ordering::SeqCst)), "{most:?}");
        let inner = lock(&turns.0);
        assert_eq!((inner.free, inner.waiting.len(), inner.called.len()), (2, 0, 0));
        assert_eq!((inner.of.len(), inner.order.len()), (0, 0));
    }

    /// Who waits for something else takes no turn meanwhile, and who goes gives its place back, called or not.
    #[tokio::test]
    async fn no_turn_is_lost() {
        let turns = Turns::new(1);
        let noop = &mut Context::from_waker(Waker::noop());
        let mut idle = client(&turns, 1).serve(std::future::pending::<()>());
        for _ in 0..2 {
            assert!(Pin::new(&mut idle).poll(noop).is_pending());
        }
        assert_eq!(lock(&turns.0).free, 1, "it is not at work");
        let ready = |host| client(&turns, host).serve(std::future::ready(host));
        let (mut called, mut gone, mut last) = (ready(2), ready(2), ready(3));
        for waits in [&mut called, &mut gone, &mut last] {
            assert!(Pin::new(waits).poll(noop).is_pending());
        }
        drop(gone);
        assert!(Pin::new(&mut last).poll(noop).is_pending(), "it is the turn of the first one");
        drop(called);
        assert_eq!(Pin::new(&mut last).poll(noop), Poll::Ready(3));
        let inner = lock(&turns.0);
        assert_eq!((inner.free, inner.waiting.len(), inner.called.len()), (1, 0, 0));
        assert_eq!((inner.of.len(), inner.order.len()), (0, 0));
    }

    /// Assumed: a poll that blocks its thread, as on a disk that hangs, and a future that was called and is not polled.
    #[tokio::test(flavor = "multi_thread", worker_threads = 3)]
    async fn a_turn_that_does_not_end_holds_up_no_other() {
        let turns = Turns::new(1);
        let (go, waits) = mpsc::channel::<()>();
        let (own, blocked) = (client(&turns, 1), Arc::new(AtomicUsize::new(0)));
        let is_blocked = blocked.clone();
        let hangs = tokio::spawn(async move {
            let work = Box::pin(async move {
                is_blocked.store(1, Ordering::SeqCst);
                _ = waits.recv();
            });
            own.serve(work).await;
        });
        while blocked.load(Ordering::SeqCst) == 0 {
            yield_now().await;
        }
        let noop = &mut Context::from_waker(Waker::noop());
        let mut forgotten = client(&turns, 2).serve(std::future::ready(2));
        assert!(Pin::new(&mut forgotten).poll(noop).is_pending());
        for _ in 0..3 {
            tokio::time::sleep(LONG * 2).await;
            let served = client(&turns, 3).serve(std::future::ready(7));
            let served = timeout(LONG / 2, served).await;
            // The first one ends the turn of that which blocks, the second one that of the forgotten one.
            if served.is_ok() {
                break;
            }
        }
        let served = client(&turns, 3).serve(std::future::ready(7));
        assert_eq!(timeout(LONG / 2, served).await, Ok(7));
        go.send(()).unwrap();
        hangs.await.unwrap();
        assert!(Pin::new(&mut forgotten).poll(noop).is_pending(), "it waits once more");
        assert_eq!(Pin::new(&mut forgotten).poll(noop), Poll::Ready(2));
        let inner = lock(&turns.0);
        assert_eq!((inner.free, inner.called.len(), inner.taken.len()), (1, 0, 0));
    }

    /// A future that panics gives its turn back.
    #[tokio::test]
    async fn a_panic_takes_no_turn_away() {
        let turns = Turns::new(1);
        let own = client(&turns, 1);
        let fails = tokio::spawn(async move {
            let work = pin!(async { assert!(std::hint::black_box(false), "as intended") });
            own.serve(work).await;
        });
        assert!(fails.await.unwrap_err().is_panic());
        let served = client(&turns, 2).serve(std::future::ready(7));
        assert_eq!(timeout(PATIENCE, served).await, Ok(7));
    }
}
