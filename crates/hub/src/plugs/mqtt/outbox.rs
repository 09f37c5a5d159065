//! What is to be published, bounded: of a topic the latest message waits, of results and events so many. A broker
//! that takes nothing costs no more than this.

use std::collections::VecDeque;
use std::sync::Mutex;

use tokio::sync::Notify;

use crate::sync::lock;

/// Results that wait.
pub const RESULTS_MAX: usize = 512;
/// Events that wait.
pub const EVENTS_MAX: usize = 128;
/// After so many results one of the other messages has its turn.
const TURN: u32 = 4;

/// A message to the broker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Letter {
    /// The topic.
    pub topic: String,
    /// The text.
    pub payload: Vec<u8>,
    /// The broker keeps it for clients that come later.
    pub retained: bool,
    /// The broker confirms it.
    pub confirmed: bool,
}

/// Results that wait, each with whether it gives way first.
#[derive(Debug)]
pub struct Results<T>(VecDeque<(T, bool)>);

impl<T> Default for Results<T> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<T> Results<T> {
    /// One more; `false`: one was lost, of a flood first.
    pub fn push(&mut self, result: T, of_flood: bool) -> bool {
        let full = self.0.len() >= RESULTS_MAX;
        if full {
            let least = self.0.iter().position(|(_, of_flood)| *of_flood);
            match least {
                None if of_flood => return false,
                least => drop(self.0.remove(least.unwrap_or(0))),
            }
        }
        self.0.push_back((result, of_flood));
        !full
    }

    /// The oldest one.
    pub fn pop(&mut self) -> Option<T> {
        self.0.pop_front().map(|(result, _)| result)
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// What waits.
#[derive(Debug, Default)]
pub struct Outbox {
    waiting: Mutex<Waiting>,
    news: Notify,
}

#[derive(Debug, Default)]
struct Waiting {
    /// One of each topic.
    latest: VecDeque<Letter>,
    results: Results<Letter>,
    events: VecDeque<Letter>,
    turn: u32,
    /// The latest one that was taken is not with the library yet.
    under_way: bool,
}

impl Outbox {
    /// A message that replaces the one before it on its topic.
    pub fn put(&self, letter: Letter) {
        let mut waiting = lock(&self.waiting);
        match waiting.latest.iter_mut().find(|it| it.topic == letter.topic) {
            Some(old) => *old = letter,
            None => waiting.latest.push_back(letter),
        }
        drop(waiting);
        self.news.notify_one();
    }

    /// A result; `false`: one was lost, of a flood first.
    pub fn put_result(&self, letter: Letter, of_flood: bool) -> bool {
        let mut waiting = lock(&self.waiting);
        let kept = waiting.results.push(letter, of_flood);
        drop(waiting);
        self.news.notify_one();
        kept
    }

    /// An event; the oldest ones are lost.
    pub fn put_event(&self, letter: Letter) {
        let mut waiting = lock(&self.waiting);
        if waiting.events.len() >= EVENTS_MAX {
            waiting.events.pop_front();
        }
        waiting.events.push_back(letter);
        drop(waiting);
        self.news.notify_one();
    }

    /// The next one, once there is one; the one before it is done then. Cancel safe.
    pub async fn next(&self) -> Letter {
        lock(&self.waiting).under_way = false;
        loop {
            let news = self.news.notified();
            if let Some(letter) = lock(&self.waiting).send() {
                return letter;
            }
            news.await;
        }
    }

    /// Whether nothing waits, and nothing is under way to the library.
    pub fn is_empty(&self) -> bool {
        let waiting = lock(&self.waiting);
        !waiting.under_way
            && waiting.latest.is_empty()
            && waiting.results.is_empty()
            && waiting.events.is_empty()
    }
}

impl Waiting {
    /// Takes one out, for the library.
    fn send(&mut self) -> Option<Letter> {
        let letter = self.take();
        self.under_way = letter.is_some();
        letter
    }

    /// Results first, but not alone.
    fn take(&mut self) -> Option<Letter> {
        self.turn = self.turn.wrapping_add(1);
        let result = |it: &mut Self| it.results.pop();
        let other = |it: &mut Self| it.latest.pop_front().or_else(|| it.events.pop_front());
        if self.turn.is_multiple_of(TURN) {
            other(self).or_else(|| result(self))
        } else {
            result(self).or_else(|| other(self))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn letter(topic: &str, number: usize) -> Letter {
        let payload = number.to_string().into_bytes();
        Letter { topic: topic.to_owned(), payload, retained: false, confirmed: true }
    }

    fn all(outbox: &Outbox) -> Vec<Letter> {
        let mut waiting = lock(&outbox.waiting);
        std::iter::from_fn(|| waiting.take()).collect()
    }

    #[tokio::test]
    async fn of_a_topic_the_latest_waits() {
        let outbox = Outbox::default();
        for number in 0..10_000 {
            outbox.put(letter(["a", "b"][number % 2], number));
        }
        assert_eq!(outbox.next().await, letter("a", 9998));
        assert_eq!(all(&outbox), [letter("b", 9999)]);
        assert!(!outbox.is_empty(), "the first one is under way");
        let more = tokio::time::timeout(std::time::Duration::from_millis(20), outbox.next());
        assert!(more.await.is_err() && outbox.is_empty());
    }

    #[test]
    fn results_of_a_flood_give_way_first() {
        let outbox = Outbox::default();
        assert!(outbox.put_result(letter("r", 0), false));
        for number in 1..RESULTS_MAX {
            assert!(outbox.put_result(letter("r", number), true));
        }
        assert!(!outbox.put_result(letter("r", 9000), true), "the oldest of the flood has gone");
        assert!(!outbox.put_result(letter("r", 9001), false));
        let left = all(&outbox);
        assert_eq!(left.len(), RESULTS_MAX);
        for kept in [0, 9001] {
            assert!(left.contains(&letter("r", kept)), "{kept}");
        }
        assert!(!left.contains(&letter("r", 1)) && !left.contains(&letter("r", 2)));
    }

    #[test]
    fn results_do_not_keep_states_from_their_turn() {
        let outbox = Outbox::default();
        for number in 0..100 {
            outbox.put_result(letter("r", number), false);
        }
        outbox.put(letter("state", 0));
        (0..1000).for_each(|number| outbox.put_event(letter("event", number)));
        let order = all(&outbox);
        let at = order.iter().position(|it| it.topic == "state").unwrap();
        assert!(at < 4, "{at}");
        assert_eq!(order.iter().filter(|it| it.topic == "event").count(), EVENTS_MAX);
        assert_eq!(order.last(), Some(&letter("event", 999)));
    }
}
