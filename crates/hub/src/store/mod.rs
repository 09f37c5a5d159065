//! What is kept: SQLite, one file for each purpose, each with a thread of its own.

mod audit;
mod db;
mod events;
mod history;
mod postgres;

pub use audit::{Audit, Entry, Record, Verified, verify_lines};
pub use db::{Db, StoreError};
pub(crate) use db::{occupy, open};
pub use events::{Event, Events, Page, Search};
pub use history::{Base, Change, History, RAW_RANGE_MS, Series};
pub use postgres::Address;
