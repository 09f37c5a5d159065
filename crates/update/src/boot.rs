//! What a bootloader does before it starts a program.

use crate::decide::{Decision, Verified, decide};
use crate::image::{Board, Header};
use crate::memory::Memory;
use crate::record::{Other, Record, Recorded, Slot};
use embedded_storage::nor_flash::NorFlash;

/// What the bootloader is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boot {
    /// Start the program in a slot, [`Memory::payload_of`].
    Start {
        /// The slot.
        slot: Slot,
        /// Its header, verified.
        header: Header,
        /// It is on trial: unless it is confirmed, the next start goes back.
        trial: bool,
    },
    /// No slot has an image that may be started. What could not be read now may be read later, so
    /// the bootloader resets after a pause of some seconds.
    Nothing,
}

/// Decides what to start, verifies it, and stores what has to be remembered. `feed` is called all
/// the while, for a watchdog.
///
/// It writes the record alone, and only when a trial begins or ends, the active image no longer
/// verifies, or a copy of the record has been damaged. A trial is noted before its image is looked
/// at, so what a bootloader dies of is not tried twice. One that cannot be noted is not started,
/// unless there is nothing else to start.
pub fn boot<F: NorFlash>(
    memory: &mut Memory<F>,
    board: &Board<'_>,
    mut feed: impl FnMut(),
) -> Boot {
    let recorded = memory.record();
    let noted = match recorded {
        Recorded::Known(record) if record.other == Other::Committed => {
            memory.keep(&Record { other: Other::Tried, ..record }).is_ok()
        }
        _ => false,
    };
    let decision = decide(&recorded, noted, |slot, revoked| {
        let header = memory.verify(slot, board, revoked, &mut feed)?;
        Ok(Verified { header, trusted: memory.is_trusted(slot) })
    });
    if let Some(record) = &decision.record {
        // Whatever is not stored is decided in the same way by the next start.
        let _ = memory.keep(record);
    }
    decision.boot()
}

impl Decision {
    fn boot(&self) -> Boot {
        match self.start {
            Some((slot, header)) => Boot::Start { slot, header, trial: self.trial },
            None => Boot::Nothing,
        }
    }
}
