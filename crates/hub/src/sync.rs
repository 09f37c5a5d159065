//! Locks.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Nothing that is kept behind these locks can be left half done.
pub fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
