//! What a bootloader does before it starts a program.

use crate::decide::{Decision, decide};
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
    /// No slot has an image that may be started.
    Nothing,
}

/// Decides what to start, verifies it, and stores what has to be remembered.
///
/// It writes the record alone, and only when a trial begins or ends or the active image no longer
/// verifies. A trial that cannot be noted is not started, unless there is nothing else
/// to start.
pub fn boot<F: NorFlash>(memory: &mut Memory<F>, board: &Board<'_>) -> Boot {
    let verify = |memory: &mut Memory<F>, recorded: &Recorded| {
        decide(recorded, |slot, revoked| memory.verify(slot, board, revoked))
    };
    let recorded = memory.record();
    let decision = verify(memory, &recorded);
    let stored = match &decision.record {
        Some(record) => memory.keep(record).is_ok(),
        None => true,
    };
    if let Recorded::Known(record) = recorded
        && decision.trial
        && !stored
    {
        let without = Recorded::Known(Record { other: Other::Empty, ..record });
        let active = verify(memory, &without).start();
        if active != Boot::Nothing {
            return active;
        }
    }
    decision.start()
}

impl Decision {
    fn start(&self) -> Boot {
        match self.start {
            Some((slot, header)) => Boot::Start { slot, header, trial: self.trial },
            None => Boot::Nothing,
        }
    }
}
