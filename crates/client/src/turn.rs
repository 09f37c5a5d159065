//! The waker of a link: wakes the caller that leads, or the task of the link.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::task::{Wake, Waker};

use crate::shared::lock;

/// Registered with the link for both directions, so that it makes no difference to the link who
/// serves it. Wakers are woken without the lock.
#[derive(Debug, Default)]
pub struct Turn {
    /// The link is ready, and has not been served since.
    signalled: AtomicBool,
    who: Mutex<Who>,
}

#[derive(Debug, Default)]
struct Who {
    /// The caller that leads. It is woken once: after that the task is, until it leads again.
    leader: Option<Waker>,
    task: Option<Waker>,
}

impl Turn {
    /// Whether the link was ready since the last call.
    pub fn take_signal(&self) -> bool {
        self.is_signalled() && self.signalled.swap(false, Ordering::AcqRel)
    }

    fn is_signalled(&self) -> bool {
        self.signalled.load(Ordering::Acquire)
    }

    /// Makes the task serve the link, though it is not ready.
    pub fn signal(&self) {
        self.signalled.store(true, Ordering::Release);
        self.wake_task();
    }

    /// The caller to wake next; `None`: the task.
    pub fn set_leader(&self, leader: Option<Waker>) {
        let former = std::mem::replace(&mut lock(&self.who).leader, leader);
        drop(former);
        // The link became ready before this: the former leader was woken, who may be done.
        if self.is_signalled() {
            self.wake_task();
        }
    }

    /// The waker of the task.
    pub fn set_task(&self, waker: &Waker) {
        let task = &mut lock(&self.who).task;
        match task {
            Some(task) => task.clone_from(waker),
            None => *task = Some(waker.clone()),
        }
    }

    /// Wakes the task.
    pub fn wake_task(&self) {
        let task = lock(&self.who).task.clone();
        if let Some(task) = task {
            task.wake();
        }
    }
}

impl Wake for Turn {
    fn wake(self: Arc<Self>) {
        self.wake_by_ref();
    }

    fn wake_by_ref(self: &Arc<Self>) {
        self.signalled.store(true, Ordering::Release);
        let mut who = lock(&self.who);
        let next = who.leader.take().or_else(|| who.task.clone());
        drop(who);
        if let Some(next) = next {
            next.wake();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;

    #[derive(Default)]
    struct Count(AtomicUsize);

    impl Wake for Count {
        fn wake(self: Arc<Self>) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    impl Count {
        fn new() -> (Arc<Self>, Waker) {
            let count = Arc::new(Self::default());
            (count.clone(), count.into())
        }

        fn get(&self) -> usize {
            self.0.load(Ordering::Relaxed)
        }
    }

    #[test]
    fn a_leader_is_woken_once_then_the_task() {
        let turn = Arc::new(Turn::default());
        let ((leader, leads), (task, works)) = (Count::new(), Count::new());
        turn.set_task(&works);
        assert!(!turn.take_signal());
        turn.set_leader(Some(leads));
        assert_eq!((leader.get(), task.get()), (0, 0), "nothing has come");
        turn.wake_by_ref();
        turn.wake_by_ref();
        assert_eq!((leader.get(), task.get()), (1, 1));
        assert!(turn.take_signal() && !turn.take_signal());
    }

    /// What comes while a caller serves the link may have woken that caller, who may be done.
    #[test]
    fn what_comes_meanwhile_wakes_the_task() {
        let turn = Arc::new(Turn::default());
        let ((leader, leads), (task, works)) = (Count::new(), Count::new());
        turn.set_task(&works);
        turn.set_leader(Some(leads));
        turn.take_signal();
        turn.wake_by_ref();
        turn.set_leader(None);
        assert_eq!((leader.get(), task.get()), (1, 1));
        assert!(turn.take_signal());
    }
}
