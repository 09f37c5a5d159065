//! The non-volatile memory: a map in RAM that outlives resets and power cycles of the monitor.

use std::collections::BTreeMap;

use lafet_device::hal::{Key, StorageError, VALUE_MAX};

use crate::fault::{Faults, SingleFault};

/// The memory. It does no I/O: `to_bytes` and `from_bytes` let a caller keep it in a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Flash(BTreeMap<u16, Vec<u8>>);

/// The bytes are not a memory that `to_bytes` made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damaged;

impl core::fmt::Display for Damaged {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("not the memory of a simulated monitor, or cut short")
    }
}

impl core::error::Error for Damaged {}

const MAGIC: &[u8] = b"lafet flash 1\n";

impl Flash {
    /// Nothing has ever been stored: a new monitor, or one after CleanFlash.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The stored values.
    pub fn values(&self) -> impl Iterator<Item = (Key, &[u8])> {
        self.0.iter().map(|(key, value)| (Key(*key), value.as_slice()))
    }

    /// Flips a bit of a stored value, as a worn cell would; false when nothing is stored there.
    pub fn damage(&mut self, key: Key) -> bool {
        match self.0.get_mut(&key.0).and_then(|value| value.first_mut()) {
            Some(byte) => {
                *byte ^= 1;
                true
            }
            None => false,
        }
    }

    pub(crate) fn load<'b>(
        &self,
        key: Key,
        buffer: &'b mut [u8],
        faults: &Faults,
    ) -> Result<Option<&'b [u8]>, StorageError> {
        if faults.single(SingleFault::FlashRead) {
            return Err(StorageError::Read);
        }
        let Some(value) = self.0.get(&key.0) else { return Ok(None) };
        let space = buffer.get_mut(..value.len()).ok_or(StorageError::Read)?;
        space.copy_from_slice(value);
        Ok(Some(space))
    }

    pub(crate) fn store(
        &mut self,
        key: Key,
        value: &[u8],
        faults: &Faults,
    ) -> Result<(), StorageError> {
        if faults.single(SingleFault::FlashWrite) || value.len() > VALUE_MAX {
            return Err(StorageError::Write);
        }
        self.0.insert(key.0, value.to_vec());
        Ok(())
    }

    pub(crate) fn erase(&mut self, faults: &Faults) -> Result<(), StorageError> {
        if faults.single(SingleFault::FlashWrite) {
            return Err(StorageError::Write);
        }
        self.0.clear();
        Ok(())
    }

    /// The whole memory: a line of text, then key (u16), length (u16) and value of each.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        for (key, value) in &self.0 {
            bytes.extend_from_slice(&key.to_le_bytes());
            bytes.extend_from_slice(&(value.len() as u16).to_le_bytes());
            bytes.extend_from_slice(value);
        }
        bytes
    }

    /// Reads what `to_bytes` wrote.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Damaged> {
        let mut rest = bytes.strip_prefix(MAGIC).ok_or(Damaged)?;
        let mut values = BTreeMap::new();
        while !rest.is_empty() {
            let (&[k0, k1, l0, l1], tail) = rest.split_first_chunk().ok_or(Damaged)?;
            let length = usize::from(u16::from_le_bytes([l0, l1]));
            let (value, tail) = tail.split_at_checked(length).ok_or(Damaged)?;
            values.insert(u16::from_le_bytes([k0, k1]), value.to_vec());
            rest = tail;
        }
        Ok(Self(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;

    #[test]
    fn keeps_replaces_erases() {
        let mut flash = Flash::default();
        let faults = Faults::default();
        let mut buffer = [0; 16];
        assert_eq!(flash.load(Key(7), &mut buffer, &faults), Ok(None));
        flash.store(Key(7), &[1, 2, 3], &faults).unwrap();
        flash.store(Key(7), &[4, 5], &faults).unwrap();
        assert_eq!(flash.load(Key(7), &mut buffer, &faults), Ok(Some(&[4, 5][..])));
        assert_eq!(Flash::from_bytes(&flash.to_bytes()), Ok(flash.clone()));
        assert_eq!(Flash::from_bytes(&flash.to_bytes()[..17]), Err(Damaged));
        assert_eq!(Flash::from_bytes(b"something else"), Err(Damaged));
        assert!(flash.damage(Key(7)) && !flash.damage(Key(8)));
        assert_eq!(flash.load(Key(7), &mut buffer, &faults), Ok(Some(&[5, 5][..])));
        flash.erase(&faults).unwrap();
        assert!(flash.is_empty());
    }

    #[test]
    fn faults() {
        let mut flash = Flash::default();
        let mut faults = Faults::default();
        faults.inject(Fault::Single(SingleFault::FlashWrite));
        assert_eq!(flash.store(Key(1), &[1], &faults), Err(StorageError::Write));
        assert_eq!(flash.erase(&faults), Err(StorageError::Write));
        assert_eq!(flash.load(Key(1), &mut [0; 4], &faults), Ok(None));
        faults.inject(Fault::Single(SingleFault::FlashRead));
        assert_eq!(flash.load(Key(1), &mut [0; 4], &faults), Err(StorageError::Read));
    }
}
