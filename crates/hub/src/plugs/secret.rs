//! Numbers that a client has to have seen: keys of openings, and tickets.

/// A random number of the system; `None`: there is none.
pub fn random() -> Option<u64> {
    getrandom::u64().ok()
}

/// A number that cannot be guessed: not zero.
pub fn fresh(random: &mut dyn FnMut() -> Option<u64>) -> Option<u64> {
    random().filter(|it| *it != 0)
}
