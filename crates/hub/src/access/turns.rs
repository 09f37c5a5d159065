//! Turns for what is slow on purpose: the client with the fewest tries goes first.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use tokio::sync::oneshot;

use crate::sync::lock;

/// Who waits for a turn; of more, those of the worst rank are turned away.
const WAITING_MAX: usize = 256;

/// Turns. Clones are the same.
#[derive(Clone, Debug)]
pub struct Turns(Arc<Mutex<Inner>>);

#[derive(Debug)]
struct Inner {
    free: usize,
    next: u64,
    /// By rank, and of one rank in the order of their coming.
    waiting: BTreeMap<(u32, u64), oneshot::Sender<Turn>>,
}

/// A turn, until it is dropped.
#[derive(Debug)]
pub struct Turn(Option<Turns>);

impl Turns {
    /// Turns for `free` users at a time.
    pub fn new(free: usize) -> Self {
        Self(Arc::new(Mutex::new(Inner { free, next: 0, waiting: BTreeMap::new() })))
    }

    /// Waits for a turn; the lower the rank, the sooner. `None`: too many of better rank wait.
    pub async fn take(&self, rank: u32) -> Option<Turn> {
        let turn = {
            let mut inner = lock(&self.0);
            if inner.free > 0 {
                inner.free -= 1;
                return Some(Turn(Some(self.clone())));
            }
            inner.waiting.retain(|_, waiting| !waiting.is_closed());
            if inner.waiting.len() >= WAITING_MAX {
                let worst = inner.waiting.last_key_value().map(|((rank, _), _)| *rank);
                if worst.is_none_or(|worst| worst <= rank) {
                    return None;
                }
                inner.waiting.pop_last();
            }
            let (sender, turn) = oneshot::channel();
            let place = (rank, inner.next);
            inner.next += 1;
            inner.waiting.insert(place, sender);
            turn
        };
        turn.await.ok()
    }

    fn give_back(self) {
        loop {
            let first = {
                let mut inner = lock(&self.0);
                match inner.waiting.pop_first() {
                    Some((_, first)) => first,
                    None => {
                        inner.free += 1;
                        return;
                    }
                }
            };
            match first.send(Turn(Some(self.clone()))) {
                Ok(()) => return,
                // Gone in the meantime: the next one.
                Err(mut turn) => turn.0 = None,
            }
        }
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        if let Some(turns) = self.0.take() {
            turns.give_back();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn who_has_tried_least_goes_first() {
        let turns = Turns::new(1);
        let held = turns.take(0).await.unwrap();
        let order = Arc::new(Mutex::new(Vec::new()));
        let mut tasks = Vec::new();
        for rank in [5, 3, 9, 3, 1] {
            let (turns, order) = (turns.clone(), order.clone());
            tasks.push(tokio::spawn(async move {
                let turn = turns.take(rank).await.unwrap();
                lock(&order).push(rank);
                drop(turn);
            }));
            tokio::task::yield_now().await;
        }
        drop(held);
        for task in tasks {
            task.await.unwrap();
        }
        assert_eq!(*lock(&order), [1, 3, 3, 5, 9]);
    }

    #[tokio::test]
    async fn too_many_push_the_worst_out_and_no_turn_is_lost() {
        let turns = Turns::new(1);
        let held = turns.take(0).await.unwrap();
        let wait = |rank| {
            let turns = turns.clone();
            tokio::spawn(async move { turns.take(rank).await.is_some() })
        };
        let crowd: Vec<_> = (0..WAITING_MAX).map(|_| wait(7)).collect();
        tokio::task::yield_now().await;
        assert!(!wait(7).await.unwrap(), "as bad as the others, and later");
        let better = wait(1);
        tokio::task::yield_now().await;
        // Half of them give up.
        crowd.iter().step_by(2).for_each(tokio::task::JoinHandle::abort);
        tokio::task::yield_now().await;
        drop(held);
        assert!(better.await.unwrap());
        let mut served = 0;
        for task in crowd {
            served += usize::from(task.await.unwrap_or(false));
        }
        assert!(served >= WAITING_MAX / 2 - 1, "{served}");
        assert!(turns.take(9).await.is_some(), "the turn came back");
    }
}
