//! Locks.

use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use tokio::runtime::{Handle, RuntimeFlavor};
use tokio::task::block_in_place;

/// Nothing that is kept behind these locks can be left half done.
pub fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The same, unless it is taken.
pub fn lock_if_free<T: ?Sized>(mutex: &Mutex<T>) -> Option<MutexGuard<'_, T>> {
    match mutex.try_lock() {
        Ok(guard) => Some(guard),
        Err(TryLockError::Poisoned(error)) => Some(error.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    }
}

/// The same for what others may keep for milliseconds: what this task has just spawned, a Stop, and all else
/// that its thread has to run do not wait for the lock. What waits here takes a thread, so it may not be as much as
/// clients like.
pub fn lock_aside<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    if let Some(guard) = lock_if_free(mutex) {
        return guard;
    }
    match Handle::try_current().map(|it| it.runtime_flavor()) {
        Ok(RuntimeFlavor::MultiThread) => block_in_place(|| lock(mutex)),
        _ => lock(mutex),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::{Duration, Instant};

    use super::*;

    #[tokio::test(flavor = "multi_thread", worker_threads = 1)]
    async fn what_was_spawned_runs_while_a_lock_is_waited_for() {
        let (mutex, ran) = (Arc::new(Mutex::new(())), Arc::new(AtomicBool::new(false)));
        let (kept, seen) = (mutex.clone(), ran.clone());
        let (taken, is_taken) = std::sync::mpsc::channel();
        let keeps = std::thread::spawn(move || {
            let _guard = lock(&kept);
            taken.send(()).expect("a waiter");
            let began = Instant::now();
            while !seen.load(Ordering::SeqCst) && began.elapsed() < Duration::from_secs(5) {
                std::thread::park_timeout(Duration::from_millis(1));
            }
            seen.load(Ordering::SeqCst)
        });
        is_taken.recv().expect("it is taken");
        let waits = tokio::spawn(async move {
            tokio::spawn(async move { ran.store(true, Ordering::SeqCst) });
            drop(lock_aside(&mutex));
        });
        waits.await.expect("it gets the lock");
        assert!(keeps.join().expect("it has kept the lock"), "the task waited for the lock");
    }
}
