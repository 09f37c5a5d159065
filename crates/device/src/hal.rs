//! What a board or a simulator has to provide: a process image, a store, a reset.

use crate::guard::Passed;
use crate::image::Inputs;
#[cfg(feature = "update")]
use lafet_proto::update::{Order, Report};

/// The hardware under the monitor. `step` alone uses it; `handle` never does.
pub trait Hal: Storage {
    /// Samples everything the monitor senses. `inputs` are those of the step before, as they were judged: each field is
    /// to be set, or what a judgement has taken away of it stays away.
    ///
    /// The core judges them, a board must not: contacts and faults count when they have lasted for 30 ms, whether a unit
    /// is heard by [its two flags](crate::image::UnitInput). Of a unit that is not heard the board sets its last
    /// picture.
    fn read(&mut self, inputs: &mut Inputs);

    /// Drives everything the monitor drives. Called in each step, after the guard; and once more,
    /// with everything inert, before a reset.
    fn write(&mut self, outputs: &Passed);

    /// Resets the program (§3.12, §3.19): the caller of `step` builds a new `Device` before the
    /// next step. Outputs have been made inert before.
    fn reset(&mut self);

    /// The part of the board that updates its software over the link (ours), where it has one.
    #[cfg(feature = "update")]
    fn software(&mut self) -> Option<&mut dyn Software> {
        None
    }
}

/// Updates the software (ours): `lafet-update` has it. It is asked for nothing but in `step`, while
/// the monitor is locked out and everything rests (but for the order that ends a trial, which touches no flash);
/// an order may take as long as flash takes to be erased, on trial as four signatures and three hashes of a slot.
#[cfg(feature = "update")]
pub trait Software {
    /// Carries an order out; what became of it is in the report.
    fn perform(&mut self, order: &Order<'_>);

    /// Goes on with what takes longer, a little in each step.
    fn poll(&mut self);

    /// How far it is.
    fn report(&self) -> Report;

    /// SHA-256 of the payload that is running, zeros if that cannot be read. It is asked for once, at the start.
    fn hash(&self) -> [u8; 32];
}

/// Non-volatile memory (ЭНОЗУ) as a small map from keys to values.
///
/// A value is replaced as a whole or not at all, also when power fails in between.
pub trait Storage {
    /// Reads a value into `buffer`; `Ok(None)` when the key is unset.
    ///
    /// # Errors
    ///
    /// [`StorageError::Read`] when the memory cannot be read, when the value is damaged, or when
    /// `buffer` is too small for it. Values have [`VALUE_MAX`] bytes at most.
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError>;

    /// Writes a value. When it returns `Ok`, the value survives power loss. It may take as long as
    /// flash takes to be erased: the device calls it at rest only (§3.5/10).
    ///
    /// # Errors
    ///
    /// [`StorageError::Write`] when the value is not known to survive power loss; what was there
    /// before is unchanged.
    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError>;

    /// Erases everything (§3.19).
    ///
    /// # Errors
    ///
    /// [`StorageError::Write`] when not everything is erased.
    fn erase(&mut self) -> Result<(), StorageError>;
}

/// Names a stored value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(pub u16);

/// Largest value the monitor stores, bytes.
pub const VALUE_MAX: usize = 264;

/// The memory failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StorageError {
    /// Reading failed or what was read is damaged (ConfigFault).
    Read,
    /// Writing or erasing failed (ConfigWriteFault).
    Write,
}

/// Crash data left by a fault before this start (§3.20), as the board's fault handler kept them.
pub use lafet_proto::status::FaultInfo;
