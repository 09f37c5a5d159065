//! Tests of the client on sockets and pseudo-terminals, in real time.

#[path = "../fake/mod.rs"]
mod fake;

mod direct;
mod lead;
mod links;
mod scan;
#[cfg(unix)]
mod serial;
mod wakes;
