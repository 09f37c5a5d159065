//! What goes to a history that writes by itself.

use tokio::sync::oneshot;

use super::history::Row;
use super::series::Sweep;

/// What is to be stored.
#[derive(Debug)]
pub enum Work {
    /// Rows to store.
    Rows(Vec<Row>),
    /// What an alarm did: when; id, monitor, before, after, by, reason, and by what it is known when it comes twice.
    Alarm(u64, Box<[Option<String>; 7]>),
    /// What is too old is forgotten, piece by piece.
    Forget(Sweep),
    /// Says that everything before it is stored.
    Stored(oneshot::Sender<()>),
}
