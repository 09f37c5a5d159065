//! What is kept: SQLite, one file for each purpose, each with a thread of its own.

mod act;
mod audit;
mod chain;
mod current;
mod db;
mod events;
mod format;
mod history;
pub(crate) mod integrity;
mod mark;
#[cfg_attr(not(feature = "postgres"), path = "no_postgres.rs")]
mod postgres;
pub(crate) mod reserve;
mod series;
mod thin;
mod torn;
mod work;

pub use act::{Act, JogEnding};
pub use audit::{Audit, Entry, Record};
pub(crate) use chain::Chain;
pub use chain::{GENESIS, Verified, verify_lines};
pub use db::{Db, StoreError, replace};
pub(crate) use db::{checkpoint, occupy, open, private};
pub use events::{Event, Events, Page, Search};
pub(crate) use format::refuse_newer;
pub use format::{FORMAT, Newer, newer};
pub use history::{AlarmChange, Base, Change, DAY_MS, History, RAW_RANGE_MS, Series};
pub(crate) use mark::{
    Examined, Head, Mark, Users, begin, examine, mark, note, note_audit, noted, people, users,
};
pub use mark::{Fault, Loss, StateFile};
pub use postgres::Address;
pub use thin::{Rows, resolution_ms};
